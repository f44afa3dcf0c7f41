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
    /// A limit of a motor is not a number in the range the core works with (feature `kinematics`).
    #[cfg(feature = "kinematics")]
    MotorLimit {
        /// Index of the motor.
        motor: usize,
        /// Which limit.
        quantity: Quantity,
        /// The value given, and the range.
        error: RangeError,
    },
    /// A factor of a motor is not finite or too great, or its greatest is too small (feature `kinematics`).
    #[cfg(feature = "kinematics")]
    MotorFactor {
        /// Index of the motor.
        motor: usize,
        /// Index of the axis.
        axis: usize,
        /// The factor given, and the range.
        error: RangeError,
    },
    /// An axis could move with others without a motor (feature `kinematics`).
    #[cfg(feature = "kinematics")]
    Singular {
        /// Index of the axis.
        axis: usize,
        /// What motors see of it beside the axes before it, as a part of all they see of it; and the range.
        error: RangeError,
    },
    /// A motor is not linear in the axes (feature `kinematics`).
    #[cfg(feature = "kinematics")]
    NotLinear {
        /// Index of the motor.
        motor: usize,
    },
    /// Motors follow several axes (feature `kinematics`), and what follows the setpoints (feature `shaping`) does so unlike in
    /// different axes: the limits of motors would not hold.
    #[cfg(all(feature = "kinematics", feature = "shaping"))]
    Unlike,
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
            #[cfg(feature = "kinematics")]
            Self::MotorLimit { motor, quantity, error: RangeError { value, least, greatest } } => {
                let (name, unit) = quantity.words();
                write!(
                    f,
                    "{name} limit of motor {motor} is {value} {unit}; it must be {least} to {greatest}"
                )
            }
            #[cfg(feature = "kinematics")]
            Self::MotorFactor { motor, axis, error: RangeError { value, least, greatest } } => {
                write!(
                    f,
                    "factor of motor {motor} for axis {axis} is {value}; it must be {least} to {greatest}"
                )
            }
            #[cfg(feature = "kinematics")]
            Self::Singular { axis, error: RangeError { value, least, .. } } => {
                write!(
                    f,
                    "axis {axis} could move with others without a motor: {value} of it is its own, and it must be {least}"
                )
            }
            #[cfg(feature = "kinematics")]
            Self::NotLinear { motor } => {
                write!(f, "motor {motor} is not linear in the axes")
            }
            #[cfg(all(feature = "kinematics", feature = "shaping"))]
            Self::Unlike => {
                f.write_str("motors follow several axes, which must then be shaped alike")
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
