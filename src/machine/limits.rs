//! Axis limits, checked once when they are made.

use super::{ConfigError, Quantity};
use crate::number::Scalar;

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
