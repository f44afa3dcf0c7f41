//! Why a block was not taken.

use super::arc::radius_slack;
use crate::machine::Quantity;
use crate::number::RangeError;
use core::fmt;

/// What is wrong with a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BlockError {
    /// A number of the block is not finite or out of its range.
    OutOfRange {
        /// Which number.
        quantity: Quantity,
        /// The value given, and the range.
        error: RangeError,
    },
    /// A coordinate is beyond `Coord::LIMIT_MM`.
    Coordinate {
        /// Index of the axis.
        axis: usize,
        /// The value given, and the range, mm.
        error: RangeError,
    },
    /// It leads out of the limits of travel (feature `travel`).
    Travel {
        /// Index of the axis.
        axis: usize,
        /// How far the block would go, and the limits, mm.
        error: RangeError,
    },
    /// The arc's plane names an axis that does not exist, or the same axis twice.
    Plane {
        /// The two axes named.
        axes: (usize, usize),
    },
    /// Start and end are at different distances from the centre; by little, but on the same ray, where no turn
    /// and a full one cannot be told apart.
    ArcRadius {
        /// Distance from the start to the centre, mm.
        start: f64,
        /// Distance from the end to the centre, mm.
        end: f64,
    },
    /// The block is longer than the fixed-point arc length can hold with all its turns.
    TooLong {
        /// Its length, mm.
        length: f64,
        /// Greatest length accepted, mm.
        greatest: f64,
    },
    /// The radius is too small for the distance between start and end, or less than 1.5 nm, or the
    /// circle is undetermined because start and end coincide.
    ArcUnreachable {
        /// The radius given, mm.
        radius: f64,
        /// Distance from start to end in the plane, mm.
        chord: f64,
    },
}

impl fmt::Display for BlockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::OutOfRange { quantity, error: RangeError { value, least, greatest } } => {
                let (name, unit) = quantity.words();
                write!(f, "{name} is {value} {unit}; it must be {least} to {greatest}")
            }
            Self::Coordinate { axis, error: RangeError { value, least, greatest } } => {
                write!(
                    f,
                    "coordinate of axis {axis} is {value} mm; it must be {least} to {greatest}"
                )
            }
            Self::Travel { axis, error: RangeError { value, least, greatest } } => {
                write!(f, "axis {axis} would go to {value} mm; its travel is {least} to {greatest}")
            }
            Self::Plane { axes: (p, q) } => {
                write!(f, "arc plane of axes {p} and {q} does not exist")
            }
            Self::ArcRadius { start, end } => {
                write!(f, "arc starts {start:.6} mm from its centre but ends {end:.6} mm from it")?;
                let slack = radius_slack(start);
                if (start - end).abs() > slack {
                    write!(f, "; they may differ by {slack:.3}")
                } else {
                    f.write_str(", on the same ray: no turn and a full one cannot be told apart")
                }
            }
            Self::TooLong { length, greatest } => {
                write!(f, "block is {length} mm long; it must be at most {greatest}")
            }
            Self::ArcUnreachable { radius, chord } => {
                write!(f, "no arc of radius {radius} mm joins points {chord:.6} mm apart")
            }
        }
    }
}

impl core::error::Error for BlockError {}

/// Why a push did not take a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PushError {
    /// The look-ahead buffer is full: nothing is wrong, push the same block again later.
    Full,
    /// An abort was asked for: nothing is taken, and what had been pushed is dropped, until
    /// [`Planner::acknowledge_abort`](crate::Planner::acknowledge_abort). What comes then starts where
    /// the machine stands.
    Aborted,
    /// The block is not valid. Nothing of it was taken; what was accepted before is unchanged.
    Rejected {
        /// The block's tag.
        tag: u32,
        /// What is wrong with it.
        reason: BlockError,
    },
}

impl fmt::Display for PushError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str("look-ahead buffer is full"),
            Self::Aborted => f.write_str("an abort has not been acknowledged"),
            Self::Rejected { tag, reason } => write!(f, "block {tag}: {reason}"),
        }
    }
}

impl core::error::Error for PushError {}
