//! Axis limits, checked once when they are made.

#[cfg(feature = "kinematics")]
use super::motors::{MOTORS, Motors};
use super::{ConfigError, Motor, Quantity};
#[cfg(feature = "kinematics")]
use super::{Everywhere, Kinematics, check_factors};
use crate::number::Scalar;

/// No limit: more than any axis is allowed, in any direction in which it has a share worth counting.
pub(crate) const UNLIMITED: f64 = 1.0e12;
/// Least time scale of a machine, s: what it builds up sooner makes no difference in a servo cycle, and what is measured by less (first
/// speeds, the end of a plan) would be too fast, or too fine, for everything else.
const LEAST_SCALE: f64 = 1.0e-5;

/// Limits of one axis, or of one motor (feature `kinematics`). Units: mm and s on a linear axis, degrees and s on a rotary one.
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

impl<S: Scalar> AxisLimits<S> {
    /// As much acceleration as can be used, mm/s2: where jerk is low, an axis is at its full speed before it is at its full
    /// acceleration.
    #[inline(never)]
    pub(crate) fn usable_acceleration(&self) -> S {
        self.acceleration.least((self.velocity * self.jerk).sqrt())
    }
}

/// The checked limits of all axes: every value is finite, positive and within the range in which
/// the core's arithmetic is sound.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits<S, const N: usize> {
    axes: [AxisLimits<S>; N],
    #[cfg(feature = "kinematics")]
    motors: Motors<S, N>,
}

impl<S: Scalar, const N: usize> Limits<S, N> {
    /// The memory of some that are not known.
    pub(crate) const UNSET: Self = Self {
        axes: [AxisLimits::linear(S::ZERO, S::ZERO, S::ZERO); N],
        #[cfg(feature = "kinematics")]
        motors: Motors::NONE,
    };

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
        Ok(Self {
            axes,
            #[cfg(feature = "kinematics")]
            motors: Motors::NONE,
        })
    }

    /// The same with the limits of motors (feature `kinematics`), in mm of the motor's way, or whatever its factors make of an
    /// axis's: velocity, acceleration and jerk of every motor keep them at every instant, as those of the axes do theirs.
    /// A motor that the limits of its axes hold anyway costs nothing.
    ///
    /// Cost: that of a few hundred multiplications.
    ///
    /// # Errors
    /// [`ConfigError::MotorLimit`] names the first motor and quantity out of range; [`ConfigError::NotLinear`] the first motor
    /// that is not linear in the axes.
    #[cfg(feature = "kinematics")]
    pub fn with_motors<K: Kinematics<S, N, M>, const M: usize>(
        mut self,
        kinematics: &K,
        limits: [AxisLimits<S>; M],
    ) -> Result<Self, ConfigError> {
        const { assert!(M <= MOTORS, "8 motors at most") };
        self.motors = Motors::NONE;
        for (motor, limits) in limits.into_iter().enumerate() {
            let follows = kinematics.follows(motor, &Everywhere::AXES);
            if follows.strays.iter().any(|stray| *stray != S::ZERO) {
                return Err(ConfigError::NotLinear { motor });
            }
            self.motors.push(follows.factors, limits)?;
        }
        self.motors.compare(&self.axes);
        Ok(self)
    }

    /// The same with motors in a list: those beyond the first [`MOTORS`] do not count.
    ///
    /// # Errors
    /// As [`Limits::with_motors`] and [`Linear::new`](super::Linear::new).
    #[cfg(feature = "kinematics")]
    pub fn with_motor_list(mut self, motors: &[Motor<S, N>]) -> Result<Self, ConfigError> {
        self.motors = Motors::NONE;
        check_factors(&motors.iter().take(MOTORS).map(|motor| &motor.factors))?;
        for motor in motors.iter().take(MOTORS) {
            self.motors.push(motor.factors, motor.limits)?;
        }
        self.motors.compare(&self.axes);
        Ok(self)
    }

    /// A motor (feature `kinematics`), if there is one of this number.
    #[cfg(feature = "kinematics")]
    pub fn motor(&self, motor: usize) -> Option<&Motor<S, N>> {
        self.motors.all().get(motor)
    }

    /// The same for a machine whose motors are those of `other`: of motors only the limits can change, and those that are not
    /// named stay as they are.
    #[cfg(feature = "kinematics")]
    #[must_use]
    pub(crate) fn on_motors_of(self, other: &Self) -> Self {
        let mut motors = other.motors.chosen(&self.motors, |own, new| *own = *new);
        motors.compare(&self.axes);
        Self { motors, ..self }
    }

    /// Whether it names motors.
    #[cfg(feature = "kinematics")]
    pub(crate) fn names_motors(&self) -> bool {
        !self.motors.all().is_empty()
    }

    /// The motors that are bounded by more than what bounds the axes.
    #[cfg(feature = "kinematics")]
    #[inline]
    pub(crate) fn motors(&self) -> impl Iterator<Item = &Motor<S, N>> + Clone {
        self.motors.binding()
    }

    /// There are none without the feature.
    #[cfg(not(feature = "kinematics"))]
    #[inline]
    #[allow(clippy::unused_self)]
    pub(crate) fn motors(&self) -> impl Iterator<Item = &Motor<S, N>> + Clone {
        core::iter::empty()
    }

    /// The limits of axes and motors, and what each of them does along a direction.
    #[inline]
    pub(crate) fn shares(&self, direction: &[S; N]) -> impl Iterator<Item = (&AxisLimits<S>, S)> {
        let axes = self.axes.iter().zip(direction).map(|(axis, share)| (axis, share.abs()));
        axes.chain(self.motors().map(|motor| (&motor.limits, motor.of(direction).abs())))
    }

    /// The limits of every axis.
    pub const fn axes(&self) -> &[AxisLimits<S>; N] {
        &self.axes
    }

    /// The greater of two limits of acceleration and of jerk, axis by axis.
    #[must_use]
    pub(crate) fn with_more(self, other: &Self) -> Self {
        self.chosen(other, |own, other| {
            own.acceleration = own.acceleration.greatest(other.acceleration);
            own.jerk = own.jerk.greatest(other.jerk);
        })
    }

    /// With every axis changed, to what is in range.
    #[cfg(feature = "shaping")]
    #[must_use]
    pub(crate) fn map(mut self, change: impl Fn(usize, AxisLimits<S>) -> AxisLimits<S>) -> Self {
        for (i, axis) in self.axes.iter_mut().enumerate() {
            *axis = change(i, *axis);
        }
        self
    }

    /// The lesser of them.
    #[must_use]
    pub(crate) fn with_less(self, other: &Self) -> Self {
        self.chosen(other, |own, other| {
            own.acceleration = own.acceleration.least(other.acceleration);
            own.jerk = own.jerk.least(other.jerk);
        })
    }

    /// With something of others, axis by axis and motor by motor.
    #[inline]
    fn chosen(mut self, other: &Self, choose: impl Fn(&mut AxisLimits<S>, &AxisLimits<S>)) -> Self {
        for (axis, other) in self.axes.iter_mut().zip(&other.axes) {
            choose(axis, other);
        }
        #[cfg(feature = "kinematics")]
        {
            self.motors = self.motors.chosen(&other.motors, choose);
            self.motors.compare(&self.axes);
        }
        self
    }

    /// Greatest acceleration and jerk along a direction, mm/s2 and mm/s3.
    #[inline(never)]
    pub(crate) fn along(&self, direction: &[S; N]) -> [S; 2] {
        let [mut acceleration, mut jerk] = [S::of(UNLIMITED); 2];
        for (axis, share) in self.shares(direction) {
            if share * acceleration > axis.acceleration {
                acceleration = axis.acceleration / share;
            }
            if share * jerk > axis.jerk {
                jerk = axis.jerk / share;
            }
        }
        [acceleration, jerk]
    }

    /// Longest time any axis or motor needs to build up as much acceleration as it can use, s: the time scale on which
    /// the machine's motion changes.
    #[inline(never)]
    pub(crate) fn time_scale(&self) -> S {
        let mut scale = S::ZERO;
        for axis in self.axes.iter().chain(self.motors().map(|motor| &motor.limits)) {
            scale = scale.greatest(axis.usable_acceleration() / axis.jerk);
        }
        scale.greatest(S::of(LEAST_SCALE))
    }

    /// The jerk, mm/s3, that every axis may have whatever the others have.
    pub(crate) fn least_jerk(&self) -> S {
        let axes = self.axes.iter().fold(S::of(UNLIMITED), |j, axis| j.least(axis.jerk));
        self.motors().fold(axes, |j, motor| j.least(motor.limits.jerk / motor.most(|_| S::ONE)))
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
        // Neither what cannot be reached counts, nor what is built up in no time.
        let limits = Limits::new([axis(4.0, 1.0e8, 100.0)]).unwrap();
        assert!((limits.time_scale() - 0.2).abs() < 1.0e-12);
        let limits = Limits::new([axis(4.0, 1.0, 1.0e11)]).unwrap();
        assert!((limits.time_scale() - LEAST_SCALE).abs() < 1.0e-20);
    }
}
