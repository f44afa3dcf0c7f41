//! Corners for least time: a cubic B-spline that uses the band on both sides of the legs.
//!
//! A jerk-limited machine takes a corner faster if the path leaves the leg early, swings out to the
//! far side of the band and then cuts the corner on the near side, as racing cars do. Eleven control
//! points P0..P10, symmetric about the bisector, knots {0, 0, 0, 0, 1, 2, .. 7, 8, 8, 8, 8}; P0, P1,
//! P2 lie on the leg, so the curvature is zero where the transition begins and continuous
//! everywhere; P3 and P4 may lie off the leg, P5 lies on the bisector.
//!
//! Near the apex jerk alone decides the time, so the best shape scales with the band: with lengths
//! along the leg in units of G = 8 delta / sin(turn), the length of Guo's transition (eq. 7), and
//! offsets from the leg in units of delta, it hardly depends on the turn, nor on the limits of the
//! machine. It does depend on x = r / G, how much of the leg (r) there is for it. [`TEMPLATES`] holds the
//! best shapes of a search (downhill simplex on the eight numbers; time over a zigzag of long legs
//! with this core's own speed law, mean over three directions in the axes' frame). Between its rows
//! and columns shapes are interpolated; then the true deviation of the curve is computed and the
//! shape scaled to the band, so the band is kept whatever the table says.

use super::budget;
use super::corner::Corner;
use super::half::Half;
use crate::number::Scalar;
use crate::number::list::some;
use core::array::from_fn;

/// One shape: distances of P0..P4 from the corner in units of G, offsets of P3 and P4 and of P5 in
/// units of delta, to the inside.
type Template = [f64; 8];

/// Turns of the columns: 30, 60, 90, 120, 135 and 154 degrees.
const TURNS: usize = 6;
/// Their cosines.
const COSINE: [f64; TURNS] = [0.866, 0.5, 0.0, -0.5, -0.707, -0.901];
/// Room on the leg, r / G, of the rows.
const ROOM: [f64; 5] = [1.0, 2.0, 4.0, 10.0, 30.0];

/// The best shapes found, by room and turn.
const TEMPLATES: [[Template; TURNS]; 5] = [
    [
        [0.875, 0.787, 0.620, 0.399, 0.206, 0.089, 0.366, 0.935],
        [0.8744, 0.7863, 0.6201, 0.3992, 0.2125, 0.0886, 0.3661, 0.9347],
        [0.875, 0.781, 0.611, 0.399, 0.235, 0.098, 0.375, 0.9345],
        [0.8753, 0.7765, 0.6022, 0.4, 0.2573, 0.1083, 0.3842, 0.9344],
        [0.875, 0.7374, 0.5592, 0.3769, 0.2596, 0.1117, 0.404, 0.9469],
        [0.8749, 0.6983, 0.5163, 0.3538, 0.2618, 0.115, 0.4238, 0.9593],
    ],
    [
        [1.9981, 1.8547, 1.505, 0.9801, 0.4767, -0.3585, -0.3649, 0.7137],
        [1.7581, 1.571, 1.2017, 0.7211, 0.3391, -0.1506, -0.0189, 0.8259],
        [1.7499, 1.5398, 1.1401, 0.6608, 0.3167, -0.082, 0.086, 0.842],
        [1.7028, 1.4048, 0.96, 0.5387, 0.2865, 0.0178, 0.2495, 0.8928],
        [1.522, 1.1894, 0.8028, 0.468, 0.2771, 0.0403, 0.3121, 0.921],
        [1.3413, 0.9739, 0.6455, 0.3972, 0.2676, 0.0627, 0.3746, 0.9492],
    ],
    [
        [3.5625, 3.2638, 2.6159, 1.6702, 0.7933, -0.8752, -1.2106, 0.4752],
        [3.9963, 3.5739, 2.7285, 1.5869, 0.6834, -0.7691, -1.0338, 0.518],
        [3.5002, 3.0751, 2.2457, 1.206, 0.484, -0.4283, -0.4926, 0.6521],
        [2.5386, 2.1192, 1.4255, 0.7378, 0.3294, -0.1484, 0.0094, 0.8371],
        [2.6832, 2.2544, 1.5045, 0.7407, 0.3302, -0.4171, -0.3274, 0.8445],
        [2.8278, 2.3896, 1.5835, 0.7435, 0.3309, -0.6858, -0.6641, 0.8519],
    ],
    [
        [7.8584, 5.1251, 3.5733, 2.0371, 0.8778, -0.6763, -1.324, 0.3589],
        [6.2609, 5.3002, 3.6206, 1.9524, 0.7781, -0.8299, -1.2379, 0.405],
        [8.3119, 5.8345, 3.8768, 1.9236, 0.6806, -0.8588, -1.2203, 0.4409],
        [7.4076, 6.0537, 3.8147, 1.6168, 0.5218, -0.9798, -1.1287, 0.5945],
        [5.0008, 4.1221, 2.6116, 1.1526, 0.4112, -0.8529, -0.8298, 0.7354],
        [3.2175, 2.6851, 1.7382, 0.8219, 0.3463, -0.9179, -0.9405, 0.8282],
    ],
    [
        [7.8584, 5.1251, 3.5733, 2.0371, 0.8778, -0.6763, -1.324, 0.3589],
        [6.2609, 5.3002, 3.6206, 1.9524, 0.7781, -0.8299, -1.2379, 0.405],
        [8.2908, 5.7958, 3.8527, 1.9136, 0.6778, -0.8729, -1.2104, 0.444],
        [6.8631, 5.6618, 3.6109, 1.6092, 0.5214, -0.9698, -1.138, 0.5964],
        [5.6609, 4.6271, 2.9384, 1.3133, 0.4431, -1.016, -1.0927, 0.6909],
        [4.3158, 3.0084, 1.8993, 0.8556, 0.3519, -1.0715, -1.0349, 0.8193],
    ],
];

/// Room below which two spans make one cell: there the corner takes little time anyway.
const COARSE_ROOM: f64 = 1.2;

/// Room with which the shapes do not leave the legs to the outer side: the first row.
const INSIDE_ROOM: f64 = 1.0;

/// What a corner may use.
#[derive(Clone, Copy, Debug)]
pub struct CornerBand<S> {
    /// Greatest distance from the legs, mm.
    pub delta: S,
    /// Whether the outer side may be used, too: else the curve lies between the legs.
    pub outside: bool,
}

impl<S> CornerBand<S> {
    /// Both sides of the legs.
    #[cfg(test)]
    pub const fn around(delta: S) -> Self {
        Self { delta, outside: true }
    }
}

/// Length along a leg that is worth having for a corner with its band; `most` at most.
pub fn longest_reach<S: Scalar>(corner: &Corner<S>, band: CornerBand<S>, most: S) -> S {
    let CornerBand { delta, outside } = band;
    let [.., rooms] = ROOM;
    let rooms = if outside { rooms } else { INSIDE_ROOM };
    let guo = corner.full_band_length(delta * S::of(budget::SWING), most);
    if guo >= most {
        return most;
    }
    // A tenth more than the table says: shapes are scaled to the band afterwards.
    let reach = shape(corner, rooms)[0] * 1.1;
    (guo * S::of(reach)).least(most)
}

/// The first half of the transition for a corner with its band and `room` mm of either leg to take.
pub fn half<S: Scalar>(corner: &Corner<S>, band: CornerBand<S>, room: S) -> Half<S> {
    let CornerBand { delta, outside } = band;
    let guo = corner.full_band_length(delta * S::of(budget::SWING), room * S::of(4.0));
    let ratio = (room / guo).to_f64();
    let ratio = if outside { ratio } else { ratio.min(INSIDE_ROOM) };
    let shape = shape(corner, ratio);
    // Where the legs are short, the turn slight, or both, the band is not what limits the corner:
    // offsets are those of the shape drawn for the band that it would need.
    let delta = guo * corner.sin_turn() * S::of(1.0 / 8.0);
    let half = polygon(corner, &shape, guo, delta, ratio);
    let (most, reach) = (half.deviation(), half.reach());
    let share = if delta * reach < room * most { delta / most } else { room / reach };
    half.scaled(share)
}

/// The shape for a corner with room `ratio`, interpolated.
fn shape<S: Scalar>(corner: &Corner<S>, ratio: f64) -> Template {
    let cosine = corner.cos_turn().to_f64();
    let (row, down) = bracket(&ROOM, ratio);
    let (column, across) = bracket(&COSINE, cosine);
    let mix = |k: usize, row: usize| {
        TEMPLATES[row][column][k] * (1.0 - across) + TEMPLATES[row][column + 1][k] * across
    };
    from_fn(|k| mix(k, row) * (1.0 - down) + mix(k, row + 1) * down)
}

/// The interval of a monotonic list that holds `x`, and how far into it `x` lies; clamped.
fn bracket<const M: usize>(list: &[f64; M], x: f64) -> (usize, f64) {
    let rising = list[1] > list[0];
    let passed = |value: f64| if rising { x >= value } else { x <= value };
    let mut at = 0;
    for (i, value) in list.iter().enumerate().take(M - 1).skip(1) {
        if passed(*value) {
            at = i;
        }
    }
    let Some([before, after]) = some(list, at) else { return (0, 0.0) };
    let share = (x - before) / (after - before);
    (at, share.clamp(0.0, 1.0))
}

/// The Bezier spans of the B-spline's first half.
fn polygon<S: Scalar>(
    corner: &Corner<S>,
    shape: &Template,
    guo: S,
    delta: S,
    ratio: f64,
) -> Half<S> {
    let [d0, d1, d2, d3, d4, o3, o4, apex] = shape.map(S::of);
    let on = |d: S, o: S| (-(d * guo), o * delta);
    let zero = S::ZERO;
    let p5 = (-(apex * delta * corner.tan_half_turn()), apex * delta);
    let p4 = on(d4, o4);
    // Mirror image of P4 about the bisector.
    let (cos, sin) = (corner.cos_turn(), corner.sin_turn());
    let p6 = (-(p4.0 * cos) - p4.1 * sin, -(p4.0 * sin) + p4.1 * cos);
    let p = [on(d0, zero), on(d1, zero), on(d2, zero), on(d3, o3), p4, p5, p6];
    let half = S::of(0.5);
    let third = S::of(1.0 / 3.0);
    let between =
        |a: (S, S), b: (S, S), share: S| (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share);
    // Inner Bezier points divide the edges of the control polygon in three (the second edge of the
    // clamped end in two); spans meet half way between two of them.
    let mut points = [(zero, zero); 13];
    points[0] = p[0];
    points[1] = p[1];
    points[2] = between(p[1], p[2], half);
    for span in 1..4 {
        let (a, b) = (p[span + 1], p[span + 2]);
        points[3 * span + 1] = between(a, b, third);
        points[3 * span + 2] = between(a, b, third + third);
    }
    let beyond = between(p[5], p[6], third);
    for joint in 1..5 {
        let after = if joint < 4 { points[3 * joint + 1] } else { beyond };
        points[3 * joint] = between(points[3 * joint - 1], after, half);
    }
    let coarse = ratio < COARSE_ROOM && corner.cos_turn() > S::of(-0.2);
    let cells = match coarse {
        true if corner.cos_turn() > S::of(0.96) => 1,
        true => 2,
        false => 4,
    };
    Half::new(&points, cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any turn, any room: inside the band and the room, and using one of them.
    #[test]
    fn the_band_is_kept_and_used() {
        for degrees in [0.01f64, 1.0, 10.0, 45.0, 90.0, 135.0, 159.0] {
            let turn = degrees.to_radians();
            let corner = Corner::new(&[1.0, 0.0], &[turn.cos(), turn.sin()]);
            for room in [1e-3, 0.05, 0.3, 1.0, 3.0, 10.0, 100.0] {
                let half = half(&corner, CornerBand::around(0.05), room);
                assert!(half.deviation() <= 0.05 * 0.951, "{degrees} {room} {}", half.deviation());
                assert!(half.reach() <= room * 1.000_001, "{degrees} {room}");
                let used = half.deviation() > 0.047 || half.reach() > 0.99 * room;
                assert!(used, "{degrees} {room} {} {}", half.deviation(), half.reach());
            }
        }
    }

    /// Without the outer side the curve lies between the legs, and uses the band or the room all the same.
    #[test]
    fn the_inner_side_alone_is_kept_and_used() {
        for degrees in [0.01f64, 1.0, 10.0, 45.0, 90.0, 135.0, 159.0] {
            let turn = degrees.to_radians();
            let corner = Corner::new(&[1.0, 0.0], &[turn.cos(), turn.sin()]);
            for room in [1e-3, 0.05, 0.3, 1.0, 3.0, 10.0, 100.0] {
                let half = half(&corner, CornerBand { delta: 0.05, outside: false }, room);
                assert!(half.deviation() <= 0.05 * 0.951 && half.reach() <= room * 1.000_001);
                assert!(half.least_offset() >= 0.0, "{degrees} {room}");
                let used = half.deviation() > 0.047 || half.reach() > 0.99 * room;
                assert!(used, "{degrees} {room} {} {}", half.deviation(), half.reach());
            }
        }
    }
}
