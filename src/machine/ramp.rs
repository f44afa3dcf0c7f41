//! How the machine gets going along a line: the lengths that geometry needs for its choices, made of the
//! limits here, so that geometry need not know time.

use super::{Limits, UNLIMITED};
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
    /// The memory of one.
    pub const UNSET: Self = Self { jerk: S::ZERO, time: S::ZERO };

    /// Along a unit direction.
    #[inline(never)]
    pub fn new<const N: usize>(limits: &Limits<S, N>, direction: &Vector<S, N>) -> Self {
        let mut jerk = S::of(UNLIMITED);
        for (axis, share) in limits.shares(direction) {
            if share * jerk > axis.jerk {
                jerk = axis.jerk / share;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::AxisLimits;

    fn limits() -> Limits<f64, 2> {
        let axis = AxisLimits { velocity: 200.0, acceleration: 2000.0, jerk: 5.0e4, rotary: false };
        Limits::new([axis; 2]).unwrap()
    }

    /// Constant jerk over half of the time in which acceleration builds up: s = J t^3 / 6.
    #[test]
    fn the_first_cell_is_what_jerk_covers() {
        let ramp = Ramp::new(&limits(), &[1.0, 0.0]);
        let time = 0.5 * 2000.0 / 5.0e4;
        assert!((ramp.first_cell(200.0) / (5.0e4 * time * time * time / 6.0) - 1.0).abs() < 1e-12);
        // A slow feed is reached sooner, and a standstill has a length all the same.
        assert!(ramp.first_cell(0.1) < ramp.first_cell(200.0));
        assert!((ramp.first_cell(0.0) - LEAST_REST).abs() < 1.0e-20);
    }

    /// Along a diagonal both axes give their jerk.
    #[test]
    fn jerk_is_that_along_the_direction() {
        let half = core::f64::consts::FRAC_1_SQRT_2;
        let (straight, diagonal) =
            (Ramp::new(&limits(), &[1.0, 0.0]), Ramp::new(&limits(), &[half, half]));
        assert!((diagonal.jerk / straight.jerk - core::f64::consts::SQRT_2).abs() < 1.0e-12);
        assert!(diagonal.length(100.0) < straight.length(100.0));
        assert!(straight.length(10.0) < straight.length(100.0));
    }
}
