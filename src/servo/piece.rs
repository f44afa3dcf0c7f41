//! One piece of motion: a quintic per axis over a short time.

use super::setpoint::{Activity, Setpoint};
use crate::number::{Coord, Scalar};
use core::array::from_fn;

/// What follows a piece in its plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequel {
    /// The next piece, at speed.
    Motion,
    /// A stop that the program asks for, or its end.
    Stop,
    /// A stop because the plan knows no further.
    Starved,
}

/// The motion over one cell of the path.
#[derive(Clone, Copy, Debug)]
pub struct Piece<S, const N: usize> {
    /// Running number of the node it starts at.
    pub serial: u32,
    /// Tag of the block.
    pub tag: u32,
    /// Duration, s.
    pub time: S,
    /// Position at its start.
    pub origin: [Coord; N],
    /// Coefficients of t^1 .. t^5 per axis.
    pub axes: [[S; 5]; N],
    /// Arc length at its start.
    pub way: Coord,
    /// Coefficients of t^1 .. t^4 of the arc length.
    pub path: [S; 4],
    /// What comes after it.
    pub sequel: Sequel,
}

impl<S: Scalar, const N: usize> Piece<S, N> {
    /// The setpoint `t` seconds after the start: 12 multiplications and as many additions per
    /// axis, no division, no root.
    #[inline]
    pub fn at(&self, t: S) -> Setpoint<S, N> {
        let (two, three, four, five) = (S::of(2.0), S::of(3.0), S::of(4.0), S::of(5.0));
        let (six, twelve, twenty) = (S::of(6.0), S::of(12.0), S::of(20.0));
        let p = &self.path;
        Setpoint {
            origin: self.origin,
            offset: from_fn(|i| {
                let c = &self.axes[i];
                ((((c[4] * t + c[3]) * t + c[2]) * t + c[1]) * t + c[0]) * t
            }),
            velocity: from_fn(|i| {
                let c = &self.axes[i];
                (((five * c[4] * t + four * c[3]) * t + three * c[2]) * t + two * c[1]) * t + c[0]
            }),
            acceleration: from_fn(|i| {
                let c = &self.axes[i];
                ((twenty * c[4] * t + twelve * c[3]) * t + six * c[2]) * t + two * c[1]
            }),
            path_origin: self.way,
            path_offset: (((p[3] * t + p[2]) * t + p[1]) * t + p[0]) * t,
            path_speed: ((four * p[3] * t + three * p[2]) * t + two * p[1]) * t + p[0],
            tag: self.tag,
            activity: if self.is_dwell() { Activity::Dwelling } else { Activity::Running },
        }
    }

    fn is_dwell(&self) -> bool {
        self.path[0] == S::ZERO && self.path[2] == S::ZERO && self.path[3] == S::ZERO
    }
}
