//! From planned states to pieces of motion.

use super::law::Law;
use super::rows::{Axis, JERK_MIX, View};
use crate::number::{Coord, Scalar};
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// Where a piece stands in the path.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub serial: u32,
    pub way: Coord,
    pub sequel: Sequel,
}

/// The piece over a cell: the very polynomials whose bounds the rows are.
pub fn piece<S: Scalar, const N: usize>(
    view: &View<'_, S, N>,
    law: &Law<S>,
    place: Place,
) -> Piece<S, N> {
    let rate = law.rate;
    let half = S::of(0.5);
    let straight = view.cell.straight;
    let axes = from_fn(|i| {
        let axis = Axis::new(view, law, i);
        let q: [S; 3] = if straight {
            from_fn(|j| axis.tangent * law.jerk[j])
        } else {
            from_fn(|j| axis.jerk(law, JERK_MIX[j]))
        };
        let e0 = if straight { S::ZERO } else { axis.e0 };
        // The jerk Q0 (1-u)^2 + 2 Q1 u (1-u) + Q2 u^2, integrated three times.
        [
            axis.tangent * law.v0,
            (axis.tangent * law.a0 + e0) * half,
            q[0] * S::of(1.0 / 6.0),
            (q[1] - q[0]) * rate * S::of(1.0 / 12.0),
            (q[0] - S::of(2.0) * q[1] + q[2]) * rate * rate * S::of(1.0 / 60.0),
        ]
    });
    Piece {
        serial: place.serial,
        tag: view.cell.order.tag,
        time: law.time,
        origin: view.from.at,
        axes,
        way: place.way,
        path: [
            law.v0,
            law.a0 * half,
            law.jerk[0] * S::of(1.0 / 6.0),
            (law.jerk[2] - law.jerk[0]) * rate * S::of(1.0 / 24.0),
        ],
        sequel: place.sequel,
    }
}

/// Standing still for `time` seconds.
pub fn standstill<S: Scalar, const N: usize>(view: &View<'_, S, N>, place: Place) -> Piece<S, N> {
    Piece {
        serial: place.serial,
        tag: view.cell.order.tag,
        time: view.cell.dwell,
        origin: view.from.at,
        axes: [[S::ZERO; 5]; N],
        way: place.way,
        path: [S::ZERO; 4],
        sequel: place.sequel,
    }
}
