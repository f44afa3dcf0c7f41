//! What bounds the motion over a cell besides its shape: speed, and on a straight acceleration and jerk.

use crate::machine::{LimitSets, UNLIMITED};
use crate::number::Scalar;
use crate::path::node::{Cell, Node};

/// Share of the velocity limits and the feed that is used: the length of a curved cell is known to
/// this much.
const SPEED_SHARE: f64 = 0.9998;

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
        for (i, axis) in limits.of(cell.programmed.limits).axes().iter().enumerate() {
            // The axis's velocity at steady speed is a quartic, between its Bernstein coefficients; at any
            // other speed below the bound it was never seen beyond them by more than the share above leaves.
            let (t0, t1) = (from.tangent[i], to.tangent[i]);
            let early = t0 + from.curvature[i] * quarter;
            let late = t1 - to.curvature[i] * quarter;
            let middle = four * t0 + cell.tangent_offset[i] * per - early - late - t1;
            let ends = t0.abs().greatest(t1.abs()).greatest(middle.abs());
            let share = ends.greatest(early.abs()).greatest(late.abs());
            if share * bounds.speed > axis.velocity {
                bounds.speed = axis.velocity / share;
            }
            let share = from.tangent[i].abs();
            if share * bounds.acceleration > axis.acceleration {
                bounds.acceleration = axis.acceleration / share;
            }
            if share * bounds.jerk > axis.jerk {
                bounds.jerk = axis.jerk / share;
            }
        }
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
