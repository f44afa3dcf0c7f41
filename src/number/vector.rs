//! Vectors over the axes.
//!
//! What is made of two goes through both by iterators: by an index it would be checked, with a panic that can be reached, wherever the
//! compiler leaves a loop as it is (`opt-level = "s"`).

use super::{Coord, Scalar};

/// A vector with one component per axis.
pub type Vector<S, const N: usize> = [S; N];

/// No length.
pub fn zero<S: Scalar, const N: usize>() -> Vector<S, N> {
    [S::ZERO; N]
}

/// The scalar product.
pub fn dot<S: Scalar, const N: usize>(a: &Vector<S, N>, b: &Vector<S, N>) -> S {
    let mut sum = S::ZERO;
    for (x, y) in a.iter().zip(b) {
        sum += *x * *y;
    }
    sum
}

/// The Euclidean length.
pub fn norm<S: Scalar, const N: usize>(a: &Vector<S, N>) -> S {
    dot(a, a).sqrt()
}

/// `a - b`.
pub fn sub<S: Scalar, const N: usize>(a: &Vector<S, N>, b: &Vector<S, N>) -> Vector<S, N> {
    let mut out = *a;
    for (x, y) in out.iter_mut().zip(b) {
        *x = *x - *y;
    }
    out
}

/// `x a + y b`.
pub fn mix<S: Scalar, const N: usize>(
    x: S,
    a: &Vector<S, N>,
    y: S,
    b: &Vector<S, N>,
) -> Vector<S, N> {
    let mut out = *a;
    for (a, b) in out.iter_mut().zip(b) {
        *a = x * *a + y * *b;
    }
    out
}

/// The point `offset` mm away from `at`.
pub fn shifted<S: Scalar, const N: usize>(at: &[Coord; N], offset: &Vector<S, N>) -> [Coord; N] {
    let mut out = *at;
    for (coord, offset) in out.iter_mut().zip(offset) {
        *coord = coord.plus(*offset);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_products() {
        let (a, b) = ([3.0f64, 4.0, 0.0], [1.0, -1.0, 2.0]);
        assert!((norm(&a) - 5.0).abs() < f64::EPSILON);
        assert!((dot(&a, &b) + 1.0).abs() < f64::EPSILON);
        assert_eq!(sub(&a, &b).map(f64::to_bits), [2.0, 5.0, -2.0].map(f64::to_bits));
        assert_eq!(mix(2.0, &a, -1.0, &b).map(f64::to_bits), [5.0, 9.0, -2.0].map(f64::to_bits));
        assert!(norm(&zero::<f64, 3>()) <= 0.0);
    }

    #[test]
    fn a_point_is_moved_by_its_offset() {
        let at = [Coord::from_mm(1.0).unwrap(), Coord::ZERO];
        let moved = shifted(&at, &[0.25f32, -0.5]);
        assert_eq!(moved.map(Coord::to_nm), [1_250_000, -500_000]);
    }
}
