//! Outputs in time with the path as they are sent.

#[cfg(feature = "outputs")]
use crate::block::{Offset, Output, Power, Switch, SwitchError, Trigger};
#[cfg(feature = "outputs")]
use crate::number::Scalar;
use serde::{Deserialize, Serialize};

/// Letter of the event that is told where an output switches at rest: the firmware has nothing to do there but what
/// `Interpolator::switch` tells.
pub const IN_TIME: u8 = 0;

/// An output that takes a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SwitchOutput {
    /// On or off: the value is 1 or 0.
    Digital(u8),
    /// Any value.
    Analogue(u8),
}

/// What it switches with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SwitchTrigger {
    /// With the end of the move before it.
    End,
    /// With the start of the next motion (M62, M63, M67).
    Start,
    /// At rest, behind all that was sent before (M64, M65, M68): an event of its own, of the letter [`IN_TIME`].
    Rest,
}

/// How long before or behind that.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SwitchOffset {
    /// A distance along the path, mm; negative: before.
    Distance(f32),
    /// A time, s; negative: before.
    Time(f32),
}

/// An output that switches at a place of the program: see `Switch` (feature `outputs`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SwitchMove {
    /// Which.
    pub output: SwitchOutput,
    /// What it is to be.
    pub value: f32,
    /// With what.
    pub trigger: SwitchTrigger,
    /// And how long before or behind that. None at [`SwitchTrigger::Rest`].
    pub offset: SwitchOffset,
    /// The caller's mark.
    pub tag: u32,
}

/// The power of a tool along the moves that follow: see `Power` (feature `outputs`). A session begins without.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PowerMove {
    /// At the programmed feed.
    pub level: f32,
    /// Whether it is in proportion to the speed along the path.
    pub dynamic: bool,
    /// The least of one in proportion to the speed.
    pub least: f32,
    /// The greatest.
    pub most: f32,
    /// Whether it changes at rest, behind all that was sent before: an event of its own, of the letter [`IN_TIME`]. Then one that is the
    /// same at every speed is on in the dwells that follow.
    pub rest: bool,
    /// The caller's mark.
    pub tag: u32,
}

/// Why an output was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SwitchRefusal {
    /// This controller switches no outputs in time with the path.
    Unknown,
    /// There is no such output.
    Output,
    /// A value or an offset is out of its range.
    OutOfRange,
    /// Too many wait for a motion that cannot come before they are taken.
    Full,
}

impl core::fmt::Display for SwitchRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Unknown => "the controller switches no outputs in time with the path",
            Self::Output => "there is no such output",
            Self::OutOfRange => "a value or an offset is out of its range",
            Self::Full => "too many outputs wait for the next motion",
        })
    }
}

#[cfg(feature = "outputs")]
fn scalar<S: Scalar>(x: f32) -> S {
    S::of(f64::from(x))
}

#[cfg(feature = "outputs")]
impl SwitchMove {
    /// The same for a core.
    pub fn switch<S: Scalar>(&self) -> Switch<S> {
        Switch {
            output: match self.output {
                SwitchOutput::Digital(number) => Output::Digital(number),
                SwitchOutput::Analogue(number) => Output::Analogue(number),
            },
            value: scalar(self.value),
            trigger: match self.trigger {
                SwitchTrigger::End => Trigger::End,
                SwitchTrigger::Start => Trigger::Start,
                SwitchTrigger::Rest => Trigger::Rest,
            },
            offset: match self.offset {
                SwitchOffset::Distance(mm) => Offset::Distance(scalar(mm)),
                SwitchOffset::Time(seconds) => Offset::Time(scalar(seconds)),
            },
            tag: self.tag,
        }
    }
}

#[cfg(feature = "outputs")]
impl PowerMove {
    /// The same for a core.
    pub fn power<S: Scalar>(&self) -> Power<S> {
        let Self { level, dynamic, least, most, .. } = *self;
        Power { level: scalar(level), dynamic, least: scalar(least), most: scalar(most) }
    }
}

#[cfg(feature = "outputs")]
impl<S: Scalar> TryFrom<&Switch<S>> for SwitchMove {
    type Error = SwitchRefusal;

    /// Rounds to `f32`.
    fn try_from(switch: &Switch<S>) -> Result<Self, SwitchRefusal> {
        let single = |x: S| x.to_f64() as f32;
        Ok(Self {
            output: match switch.output {
                Output::Digital(number) => SwitchOutput::Digital(number),
                Output::Analogue(number) => SwitchOutput::Analogue(number),
                Output::Power => return Err(SwitchRefusal::Output),
            },
            value: single(switch.value),
            trigger: match switch.trigger {
                Trigger::End => SwitchTrigger::End,
                Trigger::Start => SwitchTrigger::Start,
                Trigger::Rest => SwitchTrigger::Rest,
            },
            offset: match switch.offset {
                Offset::Distance(mm) => SwitchOffset::Distance(single(mm)),
                Offset::Time(seconds) => SwitchOffset::Time(single(seconds)),
            },
            tag: switch.tag,
        })
    }
}

#[cfg(feature = "outputs")]
impl From<SwitchError> for SwitchRefusal {
    fn from(error: SwitchError) -> Self {
        match error {
            SwitchError::Output(_) => Self::Output,
            SwitchError::Value(_) | SwitchError::Offset(_) => Self::OutOfRange,
            // Those that are no refusal of the switch itself.
            SwitchError::Full | SwitchError::Aborted => Self::Full,
        }
    }
}
