//! Outputs that switch in time with the path (feature `outputs`).

use crate::machine::{ANALOGUE, DIGITAL};
use crate::number::Scalar;
use core::fmt;

/// Greatest distance before or behind the end of a block, mm.
const MOST_MM: f64 = 10_000.0;
/// Greatest time before or behind it, s.
const MOST_SECONDS: f64 = 3_600.0;

/// An output of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Output {
    /// On or off: the value is 1 or 0. The number is less than [`DIGITAL`].
    Digital(u8),
    /// Any value. The number is less than [`ANALOGUE`].
    Analogue(u8),
    /// The tool's power: see [`Power`]. Not for a [`Switch`].
    Power,
}

/// What of the program an output switches with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Trigger {
    /// With the end of the block that was pushed last: as soon as the motion gets there. The end of a standstill is when
    /// the motion leaves it, or when it is over and nothing follows.
    End,
    /// With the start of the next motion (M62, M63, M67): as soon as the motion leaves from where the block that was pushed
    /// last ends. If it rests there, then not before it goes on.
    Start,
    /// At rest, behind all that was pushed, before all that will be (M64, M65, M68): an event of its own, without a pause.
    Rest,
}

/// How long before or behind that.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Offset<S> {
    /// A distance along the path, mm; negative: before.
    Distance(S),
    /// A time, s; negative: before.
    Time(S),
}

impl<S: Scalar> Offset<S> {
    /// Neither before nor behind.
    pub const NONE: Self = Self::Distance(S::ZERO);

    /// The same in another scalar, rounded to the nearest.
    pub fn to_scalar<T: Scalar>(self) -> Offset<T> {
        match self {
            Self::Distance(mm) => Offset::Distance(T::of(mm.to_f64())),
            Self::Time(seconds) => Offset::Time(T::of(seconds.to_f64())),
        }
    }
}

/// An output that takes a value at a place of the program.
///
/// Where the motion is rounded at the end of a block, the middle of the rounding stands for it; where short lines have become a
/// spline, the point of the spline that belongs to it. The place is one on the path: under an override, a hold, in single block
/// mode an output keeps to it, and a part of the path that is not run switches nothing. A distance or a time
/// before it never reaches behind a standstill that the program asks for (a dwell, an event): then the output switches
/// when the motion leaves it. A time behind it counts on whatever the motion does.
///
/// One that is due before it has been pushed, or before the motion to it has been planned, switches at once: as a
/// rule that is a lead longer than the look-ahead. The switches of one output keep their order: none takes effect before
/// one that was pushed before it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Switch<S> {
    /// Which.
    pub output: Output,
    /// What it is to be: 0 or 1 of a digital one.
    pub value: S,
    /// With what.
    pub trigger: Trigger,
    /// And how long before or behind that. None at [`Trigger::Rest`].
    pub offset: Offset<S>,
    /// Tag of the event at [`Trigger::Rest`].
    pub tag: u32,
}

impl<S: Scalar> Switch<S> {
    /// A digital output with the start of the next motion.
    pub const fn digital(output: u8, on: bool) -> Self {
        let value = if on { S::ONE } else { S::ZERO };
        Self { output: Output::Digital(output), value, ..Self::analogue(0, value) }
    }

    /// An analogue output with the start of the next motion.
    pub const fn analogue(output: u8, value: S) -> Self {
        let output = Output::Analogue(output);
        Self { output, value, trigger: Trigger::Start, offset: Offset::NONE, tag: 0 }
    }

    /// The same with something else.
    #[must_use]
    pub const fn at(self, trigger: Trigger) -> Self {
        Self { trigger, ..self }
    }

    /// The same a distance, mm, behind that; before it if that is negative.
    #[must_use]
    pub const fn behind_mm(self, mm: S) -> Self {
        Self { offset: Offset::Distance(mm), ..self }
    }

    /// The same a time, s, behind that; before it if that is negative.
    #[must_use]
    pub const fn behind_s(self, seconds: S) -> Self {
        Self { offset: Offset::Time(seconds), ..self }
    }

    /// The same in another scalar, rounded to the nearest.
    pub fn to_scalar<T: Scalar>(self) -> Switch<T> {
        let Self { output, trigger, tag, .. } = self;
        let (value, offset) = (T::of(self.value.to_f64()), self.offset.to_scalar());
        Switch { output, value, trigger, offset, tag }
    }

    /// Whether its numbers are in their ranges.
    pub(crate) fn check(&self) -> Result<(), SwitchError> {
        let known = match self.output {
            Output::Digital(number) => usize::from(number) < DIGITAL,
            Output::Analogue(number) => usize::from(number) < ANALOGUE,
            Output::Power => false,
        };
        if !known {
            return Err(SwitchError::Output(self.output));
        }
        let digital = matches!(self.output, Output::Digital(_));
        let is_value = if digital {
            self.value == S::ZERO || self.value == S::ONE
        } else {
            self.value.is_finite()
        };
        if !is_value {
            return Err(SwitchError::Value(self.value.to_f64()));
        }
        let (offset, most) = match self.offset {
            Offset::Distance(mm) => (mm, MOST_MM),
            Offset::Time(seconds) => (seconds, MOST_SECONDS),
        };
        let most = if self.trigger == Trigger::Rest { S::ZERO } else { S::of(most) };
        if !(offset.abs() <= most) {
            return Err(SwitchError::Offset(offset.to_f64()));
        }
        Ok(())
    }
}

/// The power of a tool that works along the path: a laser, a plasma torch, an extruder's pressure.
///
/// It is a number that the board makes a duty cycle or a voltage of; 0 is off. In rapids, and wherever the motion
/// rests without having been told to by a dwell or an event, it is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub struct Power<S> {
    /// At the programmed feed.
    pub level: S,
    /// Whether it is in proportion to the speed along the path (grbl's M4): so the work gets the same everywhere,
    /// in corners and with an override. Else it is the same at every speed (M3).
    pub dynamic: bool,
    /// The least of one in proportion to the speed, as long as the motion moves.
    pub least: S,
    /// The greatest.
    pub most: S,
}

impl<S: Scalar> Power<S> {
    /// None.
    pub const OFF: Self = Self { level: S::ZERO, dynamic: false, least: S::ZERO, most: S::ZERO };

    /// The same at every speed.
    pub const fn constant(level: S) -> Self {
        Self { level, dynamic: false, least: S::ZERO, most: level }
    }

    /// In proportion to the speed, between two bounds.
    pub const fn in_proportion(level: S, least: S, most: S) -> Self {
        Self { level, dynamic: true, least, most }
    }

    /// The same in another scalar, rounded to the nearest.
    pub fn to_scalar<T: Scalar>(self) -> Power<T> {
        let other = |x: S| T::of(x.to_f64());
        let Self { level, dynamic, least, most } = self;
        Power { level: other(level), dynamic, least: other(least), most: other(most) }
    }

    /// Whether its numbers are in their ranges.
    pub(crate) fn check(&self) -> Result<(), SwitchError> {
        for value in [self.level, self.least, self.most] {
            if !(value >= S::ZERO && value.is_finite()) {
                return Err(SwitchError::Value(value.to_f64()));
            }
        }
        if self.least > self.most {
            return Err(SwitchError::Value(self.least.to_f64()));
        }
        Ok(())
    }
}

/// Why a switch was not taken. Nothing has changed then.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SwitchError {
    /// No room now: poll, and push it again.
    Full,
    /// Everything was dropped, which is to be acknowledged first.
    Aborted,
    /// There is no such output.
    Output(Output),
    /// Its value is not finite, a digital one's neither 0 nor 1, a power's below 0 or of bounds in the wrong order.
    Value(f64),
    /// Its offset is out of range: 10 m or an hour at most, none at rest.
    Offset(f64),
}

impl fmt::Display for SwitchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str("no room for another output now"),
            Self::Aborted => f.write_str("an abort has not been acknowledged"),
            Self::Output(output) => write!(
                f,
                "there is no output {output:?}; there are {DIGITAL} digital and {ANALOGUE} analogue ones, from 0"
            ),
            Self::Value(value) => write!(
                f,
                "the value {value} is out of range: 0 or 1 for a digital output, at least 0 for a power, whose least is not above its most; finite"
            ),
            Self::Offset(offset) => write!(
                f,
                "the offset {offset} is out of range: up to {MOST_MM} mm or {MOST_SECONDS} s either way, none at rest"
            ),
        }
    }
}

impl core::error::Error for SwitchError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_out_of_range_is_refused() {
        let on = Switch::<f64>::digital(0, true);
        assert_eq!(on.check(), Ok(()));
        assert_eq!(Switch { value: 0.5, ..on }.check(), Err(SwitchError::Value(0.5)));
        let none = Output::Digital(DIGITAL as u8);
        assert_eq!(Switch { output: none, ..on }.check(), Err(SwitchError::Output(none)));
        let power = Switch { output: Output::Power, ..on };
        assert_eq!(power.check(), Err(SwitchError::Output(Output::Power)));
        assert_eq!(on.behind_mm(-2.0e4).check(), Err(SwitchError::Offset(-2.0e4)));
        assert!(on.behind_s(f64::NAN).check().is_err());
        assert!(on.behind_s(0.1).at(Trigger::Rest).check().is_err());
        assert!(Switch::analogue(0, f64::INFINITY).check().is_err());
        assert_eq!(Power::in_proportion(1.0, 0.1, 1.0).check(), Ok(()));
        assert!(Power::in_proportion(1.0, 0.5, 0.1).check().is_err());
        assert!(Power::constant(-1.0).check().is_err());
    }
}
