//! Points over all axes a program may name.

/// Letters of the axes in the order of their indices.
pub const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];
/// Most axes.
pub const AXES: usize = LETTERS.len();

/// Whether an axis turns: A, B, C.
pub const fn is_rotary(index: usize) -> bool {
    const { assert!(AXES == 9) };
    matches!(index, 3..=5)
}

/// A point over all nine axes, mm or degrees.
pub type Point = [f64; AXES];

/// Place on a cubic curve at a share of its parameter.
pub fn on_cubic(from: &Point, [first, second]: &[Point; 2], to: &Point, u: f64) -> Point {
    let v = 1.0 - u;
    let w = [v * v * v, 3.0 * v * v * u, 3.0 * v * u * u, u * u * u];
    std::array::from_fn(|i| w[0] * from[i] + w[1] * first[i] + w[2] * second[i] + w[3] * to[i])
}
