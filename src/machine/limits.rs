//! Axis limits, checked once when they are made.

use super::{ConfigError, Quantity};
use crate::number::Scalar;

/// No limit: more than any axis is allowed, in any direction in which it has a share worth counting.
pub(crate) const UNLIMITED: f64 = 1.0e12;

/// Limits of one axis. Units: mm and s on a linear axis, degrees and s on a rotary one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisLimits<S> {
    /// Greatest speed, mm/s.
    pub velocity: S,
    /// Greatest acceleration, mm/s2.
    pub acceleration: S,
    /// Greatest jerk, mm/s3.
    pub jerk: S,
    /// Whether the axis turns (degrees) rather than travels (mm); it decides what a feed means.
    pub rotary: bool,
}

impl<S> AxisLimits<S> {
    /// A linear axis: mm/s, mm/s2, mm/s3. They are checked by [`Limits::new`].
    pub const fn linear(velocity: S, acceleration: S, jerk: S) -> Self {
        Self { velocity, acceleration, jerk, rotary: false }
    }

    /// A rotary axis: degrees/s, degrees/s2, degrees/s3. They are checked by [`Limits::new`].
    pub const fn rotary(velocity: S, acceleration: S, jerk: S) -> Self {
        Self { velocity, acceleration, jerk, rotary: true }
    }
}

/// The checked limits of all axes: every value is finite, positive and within the range in which
/// the core's arithmetic is sound.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits<S, const N: usize> {
    axes: [AxisLimits<S>; N],
}

impl<S: Scalar, const N: usize> Limits<S, N> {
    /// The memory of some that are not known.
    pub(crate) const UNSET: Self =
        Self { axes: [AxisLimits::linear(S::ZERO, S::ZERO, S::ZERO); N] };

    /// Checks and keeps the limits.
    ///
    /// # Errors
    /// [`ConfigError::AxisLimit`] names the first axis and quantity that is not finite, not
    /// positive, or out of range.
    pub fn new(axes: [AxisLimits<S>; N]) -> Result<Self, ConfigError> {
        for (axis, limits) in axes.iter().enumerate() {
            for (quantity, value) in [
                (Quantity::Velocity, limits.velocity),
                (Quantity::Acceleration, limits.acceleration),
                (Quantity::Jerk, limits.jerk),
            ] {
                let named = |error| ConfigError::AxisLimit { axis, quantity, error };
                quantity.check(value).map_err(named)?;
            }
        }
        Ok(Self { axes })
    }

    /// The limits of every axis.
    pub const fn axes(&self) -> &[AxisLimits<S>; N] {
        &self.axes
    }

    /// The greater of two limits of acceleration and of jerk, axis by axis.
    #[must_use]
    pub(crate) fn with_more(mut self, other: &Self) -> Self {
        for (axis, other) in self.axes.iter_mut().zip(&other.axes) {
            axis.acceleration = axis.acceleration.greatest(other.acceleration);
            axis.jerk = axis.jerk.greatest(other.jerk);
        }
        self
    }

    /// The lesser of them.
    #[must_use]
    pub(crate) fn with_less(mut self, other: &Self) -> Self {
        for (axis, other) in self.axes.iter_mut().zip(&other.axes) {
            axis.acceleration = axis.acceleration.least(other.acceleration);
            axis.jerk = axis.jerk.least(other.jerk);
        }
        self
    }

    /// Greatest acceleration and jerk along a direction, mm/s2 and mm/s3.
    pub(crate) fn along(&self, direction: &[S; N]) -> [S; 2] {
        let [mut acceleration, mut jerk] = [S::of(UNLIMITED); 2];
        for (axis, share) in self.axes.iter().zip(direction) {
            let share = share.abs();
            if share * acceleration > axis.acceleration {
                acceleration = axis.acceleration / share;
            }
            if share * jerk > axis.jerk {
                jerk = axis.jerk / share;
            }
        }
        [acceleration, jerk]
    }

    /// Longest time any axis needs to build up its full acceleration, s: the time scale on which
    /// the machine's motion changes.
    pub(crate) fn time_scale(&self) -> S {
        let mut scale = S::ZERO;
        for axis in &self.axes {
            scale = scale.greatest(axis.acceleration / axis.jerk);
        }
        scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(velocity: f64, acceleration: f64, jerk: f64) -> AxisLimits<f64> {
        AxisLimits { velocity, acceleration, jerk, rotary: false }
    }

    #[test]
    fn the_first_limit_that_is_wrong_is_named() {
        let good = axis(200.0, 2000.0, 5.0e4);
        assert!(Limits::new([good; 3]).is_ok());
        for (bad, named) in [
            (axis(0.0, 2000.0, 5.0e4), Quantity::Velocity),
            (axis(200.0, f64::NAN, 5.0e4), Quantity::Acceleration),
            (axis(200.0, 2000.0, f64::INFINITY), Quantity::Jerk),
            (axis(-1.0, -1.0, -1.0), Quantity::Velocity),
        ] {
            let error = Limits::new([good, bad, bad]).unwrap_err();
            let ConfigError::AxisLimit { axis, quantity, .. } = error else { panic!("{error}") };
            assert_eq!((axis, quantity), (1, named));
        }
    }

    #[test]
    fn the_slowest_axis_sets_the_time_scale() {
        let limits = Limits::new([axis(1.0, 2000.0, 5.0e4), axis(1.0, 10.0, 100.0)]).unwrap();
        assert!((limits.time_scale() - 0.1).abs() < 1.0e-12);
    }
}
