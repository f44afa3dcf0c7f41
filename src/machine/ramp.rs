//! How the machine gets going along a line: the lengths that geometry needs for its choices, made of the
//! limits here, so that geometry need not know time.

use super::Limits;
use crate::number::Scalar;
use crate::number::vector::Vector;

/// Shortest first cell from rest, mm: at feeds below 0.05 mm/s speed is reached within less, and knots would
/// fall together.
const LEAST_REST: f64 = 2.5e-7;

/// Jerk along a direction, and how long it may act.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ramp<S> {
    /// mm/s3.
    jerk: S,
    /// Time in which acceleration builds up, s.
    time: S,
}

impl<S: Scalar> Ramp<S> {
    /// A ramp of no length.
    pub const NONE: Self = Self { jerk: S::ONE, time: S::ZERO };

    /// Along a unit direction.
    pub fn new<const N: usize>(limits: &Limits<S, N>, direction: &Vector<S, N>) -> Self {
        let mut jerk = S::of(1.0e12);
        for (axis, share) in limits.axes().iter().zip(direction) {
            if share.abs() * jerk > axis.jerk {
                jerk = axis.jerk / share.abs();
            }
        }
        Self { jerk, time: limits.time_scale() }
    }

    /// Length over which a feed, mm/s, is reached from rest, about, mm.
    pub fn length(&self, feed: S) -> S {
        let time = (feed / self.jerk).sqrt();
        let longer = (feed / (self.jerk * self.time)).greatest(time);
        feed * (longer + time) * S::of(0.5)
    }

    /// Length of the first cell from rest to a feed, mm/s: what constant jerk covers in half the time in
    /// which acceleration builds up, mm.
    pub fn first_cell(&self, feed: S) -> S {
        let time = self.time.least((feed / self.jerk).sqrt()) * S::of(0.5);
        (self.jerk * time * time * time / S::of(6.0)).greatest(S::of(LEAST_REST))
    }
}
