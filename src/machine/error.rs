//! What can be wrong with a machine description.

use core::fmt;

/// A quantity of a machine description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Quantity {
    /// Axis velocity, mm/s or degrees/s.
    Velocity,
    /// Axis acceleration, mm/s2 or degrees/s2.
    Acceleration,
    /// Axis jerk, mm/s3 or degrees/s3.
    Jerk,
    /// Servo cycle, s.
    Cycle,
    /// Default tolerance, mm.
    Tolerance,
    /// Lead of the plan over the execution, s.
    Lead,
    /// Wait for more blocks before a start from rest, s.
    StartDelay,
    /// Overlap factor lambda of the paper.
    Lambda,
}

impl Quantity {
    const fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Velocity => ("velocity", "mm/s"),
            Self::Acceleration => ("acceleration", "mm/s2"),
            Self::Jerk => ("jerk", "mm/s3"),
            Self::Cycle => ("servo cycle", "s"),
            Self::Tolerance => ("tolerance", "mm"),
            Self::Lead => ("lead", "s"),
            Self::StartDelay => ("start delay", "s"),
            Self::Lambda => ("lambda", ""),
        }
    }
}

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
        /// The value given.
        value: f64,
        /// Least value accepted.
        least: f64,
        /// Greatest value accepted.
        greatest: f64,
    },
    /// The start position is beyond `Coord::LIMIT_MM`.
    Start {
        /// Index of the axis.
        axis: usize,
        /// The coordinate given, mm.
        value: f64,
    },
    /// A setting of the whole machine is outside its range.
    Setting {
        /// Which setting.
        quantity: Quantity,
        /// The value given.
        value: f64,
        /// Least value accepted.
        least: f64,
        /// Greatest value accepted.
        greatest: f64,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::AxisLimit { axis, quantity, value, least, greatest } => {
                let (name, unit) = quantity.words();
                write!(
                    f,
                    "{name} limit of axis {axis} is {value} {unit}; it must be {least} to {greatest}"
                )
            }
            Self::Start { axis, value } => {
                write!(f, "start of axis {axis} is {value} mm; it must be within +-1e6")
            }
            Self::Setting { quantity, value, least, greatest } => {
                let (name, unit) = quantity.words();
                write!(f, "{name} is {value} {unit}; it must be {least} to {greatest}")
            }
        }
    }
}

impl core::error::Error for ConfigError {}
