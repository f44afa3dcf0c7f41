//! What bounds the motion over a cell besides its shape: speed, and on a straight acceleration and jerk.

use crate::machine::{AxisLimits, LimitSets, UNLIMITED};
use crate::number::Scalar;
use crate::number::vector::norm;
use crate::path::node::{Cell, Node};

/// Share of the velocity limits and the feed that is used: the length of a curved cell is known to
/// this much.
const SPEED_SHARE: f64 = 0.9998;

/// Share of its factors that a motor is taken to move more than at steady speed. Where it hardly moves, because what the axes do
/// cancels out, a path that turns makes more of a change of speed than for any axis: up to .0001 of them was seen.
const MOTOR_RESERVE: f64 = 5.0e-4;

/// Jerk along a cell that is not straight, mm/s^3: its axes bound it in other places. A guess takes the root of it, and that
/// of [`UNLIMITED`] would hold speeds down over cells of micrometres.
const NO_JERK_LIMIT: f64 = 1.0e15;

/// A cell takes at least this share of a servo cycle, so that a tick passes few of them.
pub const LEAST_CYCLE_SHARE: f64 = 0.25;

/// How fast the machine may go, and is asked to.
#[derive(Clone, Copy, Debug)]
pub struct Pace<'a, S, const N: usize> {
    pub limits: LimitSets<'a, S, N>,
    /// Servo cycle, s.
    pub cycle: S,
    /// Override of feeds, as a factor.
    pub feed: S,
    /// Override of rapids, as a factor.
    pub rapid: S,
}

/// What bounds the motion over a cell besides its shape.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bounds<S> {
    /// Greatest path speed, mm/s.
    pub speed: S,
    /// Path speed that is asked for, mm/s. It is less than `speed` while the motion slows down to
    /// an override that has just been lowered: no motion could keep it at once.
    pub goal: S,
    /// Greatest path acceleration and jerk on a straight cell.
    pub acceleration: S,
    /// See `acceleration`.
    pub jerk: S,
}

impl<S: Scalar> Bounds<S> {
    /// The bounds of a cell.
    pub fn new<const N: usize>(
        from: &Node<S, N>,
        cell: &Cell<S, N>,
        to: &Node<S, N>,
        Pace { limits, cycle, feed, rapid }: &Pace<'_, S, N>,
    ) -> Self {
        let feed = cell.programmed.feed * if cell.programmed.rapid { *rapid } else { *feed };
        let mut bounds = Self {
            goal: S::ZERO,
            speed: feed.least(cell.length / (*cycle * S::of(LEAST_CYCLE_SHARE))),
            acceleration: S::of(UNLIMITED),
            jerk: S::of(NO_JERK_LIMIT),
        };
        let (quarter, per) = (cell.length * S::of(0.25), S::of(5.0) / cell.length);
        let four = S::of(4.0);
        // Of an axis, or of a motor.
        let mut keep = |[t0, t1, k0, k1, offset]: [S; 5], axis: &AxisLimits<S>| {
            // The axis's velocity at steady speed is a quartic, between its Bernstein coefficients; at any
            // other speed below the bound it was never seen beyond them by more than the share above leaves.
            let early = t0 + k0 * quarter;
            let late = t1 - k1 * quarter;
            let middle = four * t0 + offset * per - early - late - t1;
            let ends = t0.abs().greatest(t1.abs()).greatest(middle.abs());
            let share = ends.greatest(early.abs()).greatest(late.abs());
            if share * bounds.speed > axis.velocity {
                bounds.speed = axis.velocity / share;
            }
            let steady = share;
            let share = t0.abs();
            if share * bounds.acceleration > axis.acceleration {
                bounds.acceleration = axis.acceleration / share;
            }
            if share * bounds.jerk > axis.jerk {
                bounds.jerk = axis.jerk / share;
            }
            steady
        };
        let limits = limits.of(cell.programmed.limits);
        let shape =
            [&from.tangent, &to.tangent, &from.curvature, &to.curvature, &cell.tangent_offset];
        for (i, axis) in limits.axes().iter().enumerate() {
            keep(shape.map(|of| of[i]), axis);
        }
        let mut slower = S::of(UNLIMITED);
        for motor in limits.motors() {
            let mut share = keep(shape.map(|of| motor.of(of)), &motor.limits);
            if !cell.straight {
                share += norm(&motor.factors) * S::of(MOTOR_RESERVE);
            }
            if share * slower > motor.limits.velocity {
                slower = motor.limits.velocity / share;
            }
        }
        bounds.speed = bounds.speed.least(slower);
        bounds.speed = bounds.speed * S::of(SPEED_SHARE);
        bounds.goal = bounds.speed;
        bounds
    }
}

impl<S: Scalar> Bounds<S> {
    /// The same with only a share of acceleration and jerk.
    #[must_use]
    pub fn share(self, share: S) -> Self {
        Self { acceleration: self.acceleration * share, jerk: self.jerk * share, ..self }
    }
}
