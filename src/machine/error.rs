//! What can be wrong with a machine description.

use crate::number::Scalar;
use core::fmt;

/// A quantity of a machine description; [`Quantity::range`] is what is accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
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
    /// Improvement steps of one planning step.
    Iterations,
    /// Smoothing sweeps over a run.
    Sweeps,
}

impl Quantity {
    /// The settings of a [`Config`](super::Config), beside the limits of the axes.
    pub const SETTINGS: [Self; 7] = [
        Self::Cycle,
        Self::Tolerance,
        Self::Lead,
        Self::StartDelay,
        Self::Lambda,
        Self::Iterations,
        Self::Sweeps,
    ];

    /// Least and greatest value accepted. Within these the core's arithmetic is sound, and a setting at
    /// either end costs little time: fewer iterations than the least make motions that are slower than a stop
    /// at every corner, and beyond the greatest numbers of iterations and sweeps nothing is gained.
    pub const fn range(self) -> (f64, f64) {
        match self {
            Self::Velocity => (1.0e-6, 1.0e6),
            Self::Acceleration => (1.0e-4, 1.0e8),
            Self::Jerk => (1.0e-3, 1.0e11),
            Self::Cycle => (1.0e-6, 0.01),
            Self::Tolerance | Self::StartDelay => (0.0, 1.0e3),
            Self::Lead => (0.0, 10.0),
            Self::Lambda => (0.0, 0.99),
            Self::Iterations => (15.0, 1000.0),
            Self::Sweeps => (0.0, 100.0),
        }
    }

    /// Whether a value lies in the range, whose ends are those of its type.
    pub(super) fn accepts<S: Scalar>(self, value: S) -> bool {
        let (least, greatest) = self.range();
        value >= S::of(least) && value <= S::of(greatest)
    }

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
            Self::Iterations => ("number of iterations", ""),
            Self::Sweeps => ("number of sweeps", ""),
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
                let space = if unit.is_empty() { "" } else { " " };
                write!(f, "{name} is {value}{space}{unit}; it must be {least} to {greatest}")
            }
        }
    }
}

impl core::error::Error for ConfigError {}
