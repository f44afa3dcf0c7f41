//! What can be wrong with a machine description.

use super::Quantity;
use crate::number::RangeError;
use core::fmt;

/// A machine description that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// An axis limit is not a number in the range the core works with.
    AxisLimit {
        /// Index of the axis.
        axis: usize,
        /// Which limit.
        quantity: Quantity,
        /// The value given, and the range.
        error: RangeError,
    },
    /// The start position is beyond `Coord::LIMIT_MM`.
    Start {
        /// Index of the axis.
        axis: usize,
        /// The coordinate given, and the range, mm.
        error: RangeError,
    },
    /// A limit of travel is beyond `Coord::LIMIT_MM`, or the greatest position is less than the least.
    Travel {
        /// Index of the axis.
        axis: usize,
        /// The position given, and the range, mm.
        error: RangeError,
    },
    /// A setting of the whole machine is outside its range.
    Setting {
        /// Which setting.
        quantity: Quantity,
        /// The value given, and the range.
        error: RangeError,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::AxisLimit { axis, quantity, error: RangeError { value, least, greatest } } => {
                let (name, unit) = quantity.words();
                write!(
                    f,
                    "{name} limit of axis {axis} is {value} {unit}; it must be {least} to {greatest}"
                )
            }
            Self::Start { axis, error: RangeError { value, least, greatest } } => {
                write!(f, "start of axis {axis} is {value} mm; it must be {least} to {greatest}")
            }
            Self::Travel { axis, error: RangeError { value, least, greatest } } => {
                write!(
                    f,
                    "limit of travel of axis {axis} is {value} mm; it must be {least} to {greatest}"
                )
            }
            Self::Setting { quantity, error: RangeError { value, least, greatest } } => {
                let (name, unit) = quantity.words();
                let space = if unit.is_empty() { "" } else { " " };
                write!(f, "{name} is {value}{space}{unit}; it must be {least} to {greatest}")
            }
        }
    }
}

impl core::error::Error for ConfigError {}
