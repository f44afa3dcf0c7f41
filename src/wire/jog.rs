//! Jogs as they are sent.

#[cfg(feature = "jog")]
use crate::jog::{Jog, JogError};
#[cfg(feature = "jog")]
use crate::number::{Coord, Scalar};
use serde::{Deserialize, Serialize};

/// Motion that an operator asks for, in whole numbers: see `Jog` (feature `jog`). Axes beyond those of the controller
/// are not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum JogMove {
    /// Every axis at a velocity, to be asked for again before its time is over.
    Velocity {
        /// Per axis, um/s (1e-3 degrees/s on a rotary axis).
        velocity: [i32; 9],
        /// Time after which it brakes, ms.
        time: u16,
    },
    /// By a distance.
    Step {
        /// Per axis, nm.
        by: [i64; 9],
        /// Speed along the line, um/s.
        feed: u32,
    },
    /// To a point.
    To {
        /// Per axis, nm; one without a number stays where it is, or is bound for.
        to: [Option<i64>; 9],
        /// Speed along the line, um/s.
        feed: u32,
    },
    /// To where the program was held.
    Back {
        /// Speed along the line, um/s.
        feed: u32,
    },
}

/// Why a jog was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum JogRefusal {
    /// This controller does not jog.
    Unknown,
    /// A program runs: hold it first.
    Running,
    /// An abort has not been acknowledged.
    Aborted,
    /// There is no program to go back to.
    NoProgram,
    /// A number is out of its range.
    OutOfRange,
    /// The point lies outside the limits of travel.
    Travel {
        /// Index of the axis.
        axis: u8,
    },
}

impl core::fmt::Display for JogRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Unknown => "the controller does not jog",
            Self::Running => "a program runs: hold it before jogging",
            Self::Aborted => "an abort has not been acknowledged",
            Self::NoProgram => "no program is held that could be gone back to",
            Self::OutOfRange => "a number of the jog is out of its range",
            Self::Travel { axis } => {
                return write!(f, "the point lies outside the travel of axis {axis}");
            }
        })
    }
}

#[cfg(feature = "jog")]
impl JogMove {
    /// The same for a core whose axes stand, or are bound for, somewhere: [`Planner::jog_end`](crate::Planner::jog_end).
    ///
    /// # Errors
    /// A coordinate out of range.
    pub fn jog<S: Scalar, const N: usize>(
        &self,
        stands: &[Coord; N],
    ) -> Result<Jog<S, N>, JogRefusal> {
        let mm = |um: f64| S::of(um * 1.0e-3);
        let coord = |nm: i64| Coord::from_nm(nm).map_err(|_| JogRefusal::OutOfRange);
        Ok(match self {
            Self::Velocity { velocity, time } => {
                let mut per_axis = [S::ZERO; N];
                for (slot, um) in per_axis.iter_mut().zip(velocity) {
                    *slot = mm(f64::from(*um));
                }
                Jog::Velocity { velocity: per_axis, time: S::of(f64::from(*time) * 1.0e-3) }
            }
            Self::Step { by, feed } => {
                let mut distance = [Coord::ZERO; N];
                for (slot, nm) in distance.iter_mut().zip(by) {
                    *slot = coord(*nm)?;
                }
                Jog::Step { by: distance, feed: mm(f64::from(*feed)) }
            }
            Self::To { to, feed } => {
                let mut point = *stands;
                for (slot, nm) in point.iter_mut().zip(to) {
                    if let Some(nm) = nm {
                        *slot = coord(*nm)?;
                    }
                }
                Jog::To { to: point, feed: mm(f64::from(*feed)) }
            }
            Self::Back { feed } => Jog::Back { feed: mm(f64::from(*feed)) },
        })
    }
}

#[cfg(feature = "jog")]
impl From<JogError> for JogRefusal {
    fn from(error: JogError) -> Self {
        match error {
            JogError::Running => Self::Running,
            JogError::Aborted => Self::Aborted,
            JogError::NoProgram => Self::NoProgram,
            JogError::Travel { axis, .. } => Self::Travel { axis: axis as u8 },
            JogError::OutOfRange { .. } | JogError::Coordinate { .. } => Self::OutOfRange,
        }
    }
}
