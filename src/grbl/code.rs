//! Numbers of errors and alarms, as published.

use crate::block::BlockError;
use crate::gcode::{AXIS_WORDS, Code, Reason, Refusal};
use crate::jog::JogError;
#[cfg(feature = "probe")]
use crate::jog::ProbeError;
use crate::machine::Quantity;

/// Why a line is answered by `error:` and a number: the list of grbl 1.1 (`doc/csv/error_codes_en_US.csv` there).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Error {
    /// A word does not begin with a letter.
    Letter = 1,
    /// A number is missing or badly written.
    Number = 2,
    /// A `$` command that is not known.
    Statement = 3,
    /// A number is not positive, or out of its range.
    Negative = 4,
    /// There is no homing, by setting.
    HomingDisabled = 5,
    /// A step pulse would be shorter than 3 us.
    StepPulse = 6,
    /// Settings could not be kept.
    Store = 7,
    /// The command needs a machine that is idle.
    NotIdle = 8,
    /// Locked: an alarm, or a jog.
    Locked = 9,
    /// Soft limits need homing.
    NeedsHoming = 10,
    /// The line is too long, or came when there was no room.
    Overflow = 11,
    /// Steps would come faster than the board can make them.
    StepRate = 12,
    /// The door is open.
    Door = 13,
    /// A startup line or build info is too long to be kept.
    TooLong = 14,
    /// A jog leads out of the travel.
    Travel = 15,
    /// A line of a jog has other words than those of a jog.
    Jog = 16,
    /// Laser mode needs an output with a duty cycle.
    Laser = 17,
    /// A code that is not known or not supported.
    Unsupported = 20,
    /// Two codes of one modal group.
    Group = 21,
    /// A feed is missing.
    Feed = 22,
    /// A number must be whole.
    Whole = 23,
    /// Two codes ask for the axis words.
    TwoTakers = 24,
    /// A word stands twice.
    Repeated = 25,
    /// Axis words are missing.
    NoAxes = 26,
    /// A line number is wrong.
    LineNumber = 27,
    /// A word is missing.
    Missing = 28,
    /// A work offset that nobody has set.
    Offset = 29,
    /// G53 with another motion than G0 and G1.
    Machine = 30,
    /// Axis words that no code takes.
    AxesUnused = 31,
    /// A motion that cannot be.
    Target = 33,
    /// The radius of an arc is wrong.
    Radius = 34,
    /// An arc without its centre.
    Centre = 35,
    /// Words that no code takes.
    Unused = 36,
    /// A tool that is not known.
    Tool = 38,
}

/// Why the machine is locked, said by `ALARM:` and a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Alarm {
    /// A limit switch.
    HardLimit = 1,
    /// A line would have led out of the travel.
    SoftLimit = 2,
    /// An abort that no sender has asked for: an emergency stop.
    Abort = 3,
    /// The probe was not as it must be before a probe.
    ProbeInitial = 4,
    /// The probe's contact has not come.
    ProbeContact = 5,
    /// A reset while axes were homed.
    HomingReset = 6,
    /// The door was opened while axes were homed.
    HomingDoor = 7,
    /// A switch was still closed after the way back from it.
    HomingPullOff = 8,
    /// A switch was not found.
    HomingApproach = 9,
}

impl Error {
    /// The number of a refusal of the reader.
    pub fn of(refusal: &Refusal) -> Self {
        match refusal.reason {
            Reason::Character(_)
            | Reason::Parameter(_)
            | Reason::CommentOpen
            | Reason::CommentNested
            | Reason::Mark(_) => Self::Letter,
            Reason::TooManyWords => Self::Overflow,
            Reason::LineNumber | Reason::Range { letter: 'N', .. } => Self::LineNumber,
            Reason::Repeated(_) => Self::Repeated,
            Reason::Group(..) => Self::Group,
            Reason::Both(..) => Self::TwoTakers,
            Reason::Unused(_) => Self::Unused,
            Reason::Missing { code, what } => Self::missing(code, what),
            Reason::Context { code: Code { tenths: 530, .. }, .. } => Self::Machine,
            Reason::Range { letter: 'T' | 'H', .. } | Reason::NoTool(_) => Self::Tool,
            Reason::Range { letter: 'F', .. } => Self::Feed,
            Reason::Range { value, .. } if value < 0.0 => Self::Negative,
            Reason::Range { whole: true, .. } => Self::Whole,
            Reason::Range { .. }
            | Reason::NoNumber(_)
            | Reason::NotANumber(_)
            | Reason::Exponent(_)
            | Reason::Huge(_)
            | Reason::Checksum { .. } => Self::Number,
            Reason::Coordinate { .. } | Reason::Centre { .. } | Reason::ControlPoints { .. } => {
                Self::Target
            }
            Reason::Arc(error) => Self::of_block(&error),
            Reason::NoMotion => Self::AxesUnused,
            Reason::NoOffset(_) => Self::Offset,
            _ => Self::Unsupported,
        }
    }

    fn missing(code: Code, what: &str) -> Self {
        match (code.letter, code.tenths) {
            _ if what == AXIS_WORDS || what == "an axis word" => Self::NoAxes,
            (_, 930) => Self::Feed,
            ('G', 20 | 30) => Self::Centre,
            _ if what.starts_with("an F word") => Self::Feed,
            _ => Self::Missing,
        }
    }

    /// The number of what is wrong with a move.
    pub const fn of_block(error: &BlockError) -> Self {
        match error {
            BlockError::Travel { .. } => Self::Travel,
            BlockError::ArcUnreachable { .. } => Self::Radius,
            BlockError::OutOfRange { quantity: Quantity::Feed, .. } => Self::Feed,
            _ => Self::Target,
        }
    }

    /// The number of what is wrong with a jog.
    pub const fn of_jog(error: &JogError) -> Self {
        match error {
            JogError::Travel { .. } => Self::Travel,
            JogError::Aborted => Self::Locked,
            JogError::OutOfRange { quantity: Quantity::Feed, .. } => Self::Feed,
            JogError::OutOfRange { .. } | JogError::Coordinate { .. } => Self::Target,
            JogError::Running | JogError::NoProgram => Self::NotIdle,
        }
    }

    /// The number of what is wrong with a probe.
    #[cfg(feature = "probe")]
    pub const fn of_probe(error: &ProbeError) -> Self {
        match error {
            ProbeError::Travel { .. } => Self::Travel,
            ProbeError::OutOfRange { .. } => Self::Feed,
            ProbeError::Coordinate { .. } => Self::Target,
            ProbeError::Running | ProbeError::Held | ProbeError::Input => Self::NotIdle,
            ProbeError::Aborted => Self::Locked,
        }
    }

    /// The number of what is wrong with homing: of numbers that settings give.
    #[cfg(feature = "home")]
    pub const fn of_homing(error: &ProbeError) -> Self {
        match error {
            ProbeError::OutOfRange { .. }
            | ProbeError::Coordinate { .. }
            | ProbeError::Travel { .. } => Self::Negative,
            _ => Self::of_probe(error),
        }
    }

    /// The number of a refusal of a line that jogs.
    pub fn of_jog_line(refusal: &Refusal) -> Self {
        match refusal.reason {
            Reason::Context { .. } | Reason::Unused(_) => Self::Jog,
            _ => Self::of(refusal),
        }
    }
}
