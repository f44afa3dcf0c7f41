//! Duty cycles: velocities and powers.

use crate::number::Scalar;
use core::fmt;
use embedded_hal::pwm::SetDutyCycle;

/// A value as a duty cycle.
#[derive(Clone, Copy, Debug)]
pub struct Analogue<P, S> {
    pin: P,
    /// Value at full scale.
    full: S,
    /// Whether half the duty cycle is 0.
    bipolar: bool,
}

impl<P: SetDutyCycle, S: Scalar> Analogue<P, S> {
    /// From -`full` at a duty cycle of 0 over 0 in the middle to `full` at its greatest: the input of a
    /// servo drive that takes velocities, mm/s.
    pub const fn bipolar(pin: P, full: S) -> Self {
        Self { pin, full, bipolar: true }
    }

    /// From 0 to `full`: the power of a laser by the speed along the path, say.
    pub const fn unipolar(pin: P, full: S) -> Self {
        Self { pin, full, bipolar: false }
    }

    /// Sets a value; what is beyond full scale is cut to it, and what is no number gives 0, as everything
    /// does if full scale is not above 0.
    ///
    /// # Errors
    /// The pin's.
    pub fn set(&mut self, value: S) -> Result<(), P::Error> {
        let share = value / self.full;
        let share = if self.bipolar { (share + S::ONE) * S::of(0.5) } else { share };
        let rest = if self.bipolar { S::of(0.5) } else { S::ZERO };
        let number = share.is_finite() || share.abs() > S::ONE;
        let known = number && self.full > S::ZERO;
        let share = if known { share.greatest(S::ZERO).least(S::ONE) } else { rest };
        let most = self.pin.max_duty_cycle();
        let duty = (share * S::from_u32(u32::from(most)) + S::of(0.5)).to_i64();
        self.pin.set_duty_cycle(duty.clamp(0, i64::from(most)) as u16)
    }

    /// Gives the pin back.
    pub fn release(self) -> P {
        self.pin
    }
}

/// The loop around a drive that takes velocities: velocity of the setpoint plus a gain times what is left
/// to the place it should be at.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PositionLoop<S> {
    /// 1/s.
    pub gain: S,
    /// Greatest distance from the setpoint, mm; beyond it something is wrong.
    pub most_error: S,
}

/// An axis is too far from its setpoint, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FollowingError<S> {
    /// Setpoint minus place.
    pub error: S,
    /// What is allowed.
    pub most: S,
}

impl<S: Scalar> fmt::Display for FollowingError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "following error is {:?} mm; {:?} is allowed", self.error, self.most)
    }
}

impl<S: Scalar> core::error::Error for FollowingError<S> {}

impl<S: Scalar> PositionLoop<S> {
    /// The velocity to ask for, mm/s, with the setpoint's velocity and what is left to its place, mm.
    ///
    /// # Errors
    /// [`FollowingError`] if that is too much, or if it or the velocity is no number.
    pub fn velocity(&self, velocity: S, left: S) -> Result<S, FollowingError<S>> {
        let asked = velocity + self.gain * left;
        if !(left.abs() <= self.most_error && asked.is_finite()) {
            return Err(FollowingError { error: left, most: self.most_error });
        }
        Ok(asked)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_adds_what_is_left_and_refuses_what_is_too_much() {
        let position = PositionLoop { gain: 20.0, most_error: 0.5 };
        assert_eq!(position.velocity(100.0, -0.25), Ok(95.0));
        assert_eq!(position.velocity(100.0, 0.75), Err(FollowingError { error: 0.75, most: 0.5 }));
        assert!(position.velocity(f32::NAN, 0.0).is_err());
        assert!(position.velocity(0.0, f32::NAN).is_err());
    }
}
