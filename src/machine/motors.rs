//! Motors that follow the axes, as rows beside the axes' own limits.

use super::AxisLimits;
#[cfg(feature = "kinematics")]
use super::{ConfigError, Quantity};
use crate::number::Scalar;
use crate::number::vector::dot;

/// Motors that a machine may have (feature `kinematics`).
#[cfg(feature = "kinematics")]
pub const MOTORS: usize = 8;

/// A motor of some [`Limits`](super::Limits) (feature `kinematics`).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Motor<S, const N: usize> {
    /// How far it goes for one of each axis.
    pub factors: [S; N],
    /// What bounds it.
    pub limits: AxisLimits<S>,
    /// Whether the limits of the axes leave room for it to be beyond its own.
    #[cfg(feature = "kinematics")]
    binds: bool,
}

impl<S: Scalar, const N: usize> Motor<S, N> {
    /// One that goes so far for one of each axis, with limits. [`Limits::with_motor_list`](super::Limits::with_motor_list) checks it.
    #[cfg(feature = "kinematics")]
    pub const fn new(factors: [S; N], limits: AxisLimits<S>) -> Self {
        Self { factors, limits, binds: true }
    }

    /// What it does where the axes do this.
    #[inline]
    pub(crate) fn of(&self, axes: &[S; N]) -> S {
        dot(&self.factors, axes)
    }

    /// The most it does where no axis does more than these.
    #[inline]
    pub(crate) fn most(&self, axes: impl Fn(usize) -> S) -> S {
        let mut most = S::ZERO;
        for (i, factor) in self.factors.iter().enumerate() {
            most += factor.abs() * axes(i);
        }
        most
    }
}

/// The motors of a machine.
#[cfg(feature = "kinematics")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Motors<S, const N: usize> {
    list: [Motor<S, N>; MOTORS],
    count: usize,
}

#[cfg(feature = "kinematics")]
impl<S: Scalar, const N: usize> Motors<S, N> {
    /// None: all zeros.
    pub const NONE: Self = Self {
        list: [Motor {
            factors: [S::ZERO; N],
            limits: AxisLimits::linear(S::ZERO, S::ZERO, S::ZERO),
            binds: false,
        }; MOTORS],
        count: 0,
    };

    /// One more, if there is room.
    pub fn push(&mut self, factors: [S; N], limits: AxisLimits<S>) -> Result<(), ConfigError> {
        let motor = self.count;
        for (quantity, value) in [
            (Quantity::Velocity, limits.velocity),
            (Quantity::Acceleration, limits.acceleration),
            (Quantity::Jerk, limits.jerk),
        ] {
            let named = |error| ConfigError::MotorLimit { motor, quantity, error };
            quantity.check(value).map_err(named)?;
        }
        if let Some(slot) = self.list.get_mut(motor) {
            *slot = Motor::new(factors, limits);
            self.count += 1;
        }
        Ok(())
    }

    /// All of them, in their order.
    pub fn all(&self) -> &[Motor<S, N>] {
        self.list.get(..self.count).unwrap_or(&[])
    }

    /// Those that the limits of the axes do not hold already.
    #[inline]
    pub fn binding(&self) -> impl Iterator<Item = &Motor<S, N>> + Clone {
        self.all().iter().filter(|motor| motor.binds)
    }

    /// Finds out which are held by limits of the axes.
    pub fn compare(&mut self, axes: &[AxisLimits<S>; N]) {
        for motor in &mut self.list {
            let over = |of: fn(&AxisLimits<S>) -> S| {
                motor.most(|i| axes.get(i).map_or(S::ZERO, of)) > of(&motor.limits)
            };
            motor.binds = over(|axis| axis.velocity)
                || over(|axis| axis.acceleration)
                || over(|axis| axis.jerk);
        }
    }

    /// With something of the limits of others, motor by motor; where others have none, these stay.
    #[must_use]
    pub fn chosen(
        mut self,
        others: &Self,
        choose: impl Fn(&mut AxisLimits<S>, &AxisLimits<S>),
    ) -> Self {
        let count = self.count;
        for (motor, other) in self.list.iter_mut().take(count).zip(others.all()) {
            choose(&mut motor.limits, &other.limits);
        }
        self
    }
}
