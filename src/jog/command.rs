//! What an operator asks for, and what is wrong with it.

use crate::block::BlockError;
use crate::block::range::{check_coordinates, in_range};
use crate::machine::Quantity;
use crate::number::{Coord, RangeError, Scalar};
use core::fmt;

/// Motion that an operator asks for: [`Planner::jog`](crate::Planner::jog).
///
/// The newest counts, at once: what is under way goes over into it without a stop, within every axis's limits of velocity,
/// acceleration and jerk. It never leads out of the limits of travel (feature `travel`).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Jog<S, const N: usize> {
    /// Every axis by itself comes to a velocity, and keeps it until the time is over or the axis has come to its limit of travel,
    /// where it stands exactly. To go on it must be asked for again, and again: if the line to the operator is cut, the machine
    /// stops.
    Velocity {
        /// Per axis, mm/s (degrees/s on a rotary axis); more than the axis's limit counts as the limit.
        velocity: [S; N],
        /// Time after which it brakes, s: [`Quantity::JogTime`].
        time: S,
    },
    /// By a distance per axis, from where a step or a move under way would end, or from where the axis would stop. It ends at the
    /// limit of travel if that is nearer.
    Step {
        /// Distance per axis.
        by: [Coord; N],
        /// Speed along the line, mm/s, as of a block: [`Quantity::Feed`].
        feed: S,
    },
    /// To a point: from rest along the straight line, for that is what whoever names a point expects of the tool. In motion every axis
    /// goes there by itself, at `feed` at most: to come onto a line it would have to stop first.
    To {
        /// The point.
        to: [Coord; N],
        /// Speed along the line, mm/s, as of a block: [`Quantity::Feed`].
        feed: S,
    },
    /// To the point of the program at which the machine was held: as [`Jog::To`]; also where that lies outside the limits of travel.
    Back {
        /// Speed along the line, mm/s, as of a block: [`Quantity::Feed`].
        feed: S,
    },
}

/// Why a [`Jog`] was not taken: nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum JogError {
    /// A program runs, or is about to: hold it first.
    Running,
    /// An abort has not been acknowledged.
    Aborted,
    /// There is no program to go back to.
    NoProgram,
    /// A number is not finite or out of its range.
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
    /// The point lies outside the limits of travel (feature `travel`).
    Travel {
        /// Index of the axis.
        axis: usize,
        /// The coordinate of the point, and the limits, mm.
        error: RangeError,
    },
}

impl From<BlockError> for JogError {
    fn from(error: BlockError) -> Self {
        match error {
            BlockError::OutOfRange { quantity, error } => Self::OutOfRange { quantity, error },
            BlockError::Coordinate { axis, error } => Self::Coordinate { axis, error },
            _ => Self::Running,
        }
    }
}

impl fmt::Display for JogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Running => f.write_str("a program runs; hold it before jogging"),
            Self::Aborted => f.write_str("an abort has not been acknowledged"),
            Self::NoProgram => f.write_str("no program is held that could be gone back to"),
            Self::OutOfRange { quantity, error } => {
                BlockError::OutOfRange { quantity, error }.fmt(f)
            }
            Self::Coordinate { axis, error } => BlockError::Coordinate { axis, error }.fmt(f),
            Self::Travel { axis, error } => BlockError::Travel { axis, error }.fmt(f),
        }
    }
}

impl core::error::Error for JogError {}

impl<S: Scalar, const N: usize> Jog<S, N> {
    /// Whether every number lies in its range.
    pub(crate) fn check(&self) -> Result<(), JogError> {
        match self {
            Self::Velocity { velocity, time } => {
                for axis in velocity {
                    if *axis != S::ZERO {
                        in_range(Quantity::Velocity, axis.abs())?;
                    }
                }
                in_range(Quantity::JogTime, *time)?;
            }
            Self::Step { by, feed } => {
                check_coordinates(by)?;
                in_range(Quantity::Feed, *feed)?;
            }
            Self::To { to, feed } => {
                check_coordinates(to)?;
                in_range(Quantity::Feed, *feed)?;
            }
            Self::Back { feed } => in_range(Quantity::Feed, *feed)?,
        }
        Ok(())
    }
}
