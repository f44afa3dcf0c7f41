//! Moves as they are sent.

use crate::block::{Block, BlockError, Feed, Motion, Turn};
use crate::number::{Coord, Scalar};
use core::fmt;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Positions of up to nine axes, nm (1e-6 degrees on a rotary axis).
pub type Axes = Vec<i64, 9>;

/// A place for up to nine axes, nm (1e-6 degrees on a rotary axis). An axis without a number stays
/// exactly where the move before left it, be that between two nanometres.
pub type Target = Vec<Option<i64>, 9>;

/// Where a move goes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Path {
    /// Straight to a point.
    Line {
        /// End point, absolute.
        to: Target,
    },
    /// Along a circle or helix.
    Arc {
        /// End point, absolute.
        to: Target,
        /// The plane's two axes.
        plane: (u8, u8),
        /// Centre in these axes, nm.
        centre: (i64, i64),
        /// G2.
        clockwise: bool,
        /// Full turns beyond the first arrival.
        extra_turns: u16,
    },
    /// Along a cubic curve.
    Cubic {
        /// The two Bezier points between, absolute.
        controls: [Target; 2],
        /// End point, absolute.
        to: Target,
    },
    /// Stand still.
    Dwell {
        /// Duration, s.
        seconds: f32,
    },
    /// Something that is not motion, at its place between the moves: the machine rests there for one
    /// servo cycle and the firmware gets it from [`Events`](super::Events).
    Event {
        /// Letter of the word that asks for it, in ASCII: M, S or T.
        letter: u8,
        /// Its number times ten: 30 for M3.
        tenths: u16,
        /// What goes with it: a spindle speed, the number of a tool.
        value: Option<f32>,
        /// Whether the machine then rests until it is resumed.
        pause: bool,
    },
}

/// How fast a move runs: mm/s or degrees/s, or s.
pub type Speed = Feed<f32>;

/// A block as it is sent: to the nanometre, for any number of axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Move {
    /// Where.
    pub path: Path,
    /// How fast.
    pub speed: Speed,
    /// Tolerance, mm; `None` takes the controller's.
    pub tolerance: Option<f32>,
    /// Whether it ends in an exact stop.
    pub exact_stop: bool,
    /// The caller's mark.
    pub tag: u32,
}

/// Why a move is not a block of this controller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MoveError {
    /// It does not give as many axes as the controller has.
    Axes {
        /// Axes given.
        given: usize,
        /// Axes of the controller.
        axes: usize,
    },
    /// A coordinate is out of range.
    Coordinate(BlockError),
}

impl fmt::Display for MoveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Axes { given, axes } => {
                write!(f, "the move gives {given} axes; the controller has {axes}")
            }
            Self::Coordinate(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for MoveError {}

fn coord(axis: usize, nm: i64) -> Result<Coord, MoveError> {
    Coord::from_nm(nm)
        .map_err(|error| MoveError::Coordinate(BlockError::Coordinate { axis, error }))
}

fn point<const N: usize>(target: &Target, from: &[Coord; N]) -> Result<[Coord; N], MoveError> {
    if target.len() != N {
        return Err(MoveError::Axes { given: target.len(), axes: N });
    }
    let mut to = *from;
    for (axis, (to, nm)) in to.iter_mut().zip(target).enumerate() {
        if let Some(nm) = nm {
            *to = coord(axis, *nm)?;
        }
    }
    Ok(to)
}

fn target<const N: usize>(point: &[Coord; N]) -> Target {
    point.iter().map(|coord| Some(coord.to_nm())).take(9).collect()
}

impl Move {
    /// As a block of a controller with `N` axes, which begins where the one before ended.
    ///
    /// # Errors
    /// [`MoveError`] if it has another number of axes, or a coordinate beyond [`Coord::LIMIT_MM`].
    pub fn block<S: Scalar, const N: usize>(
        &self,
        from: &[Coord; N],
    ) -> Result<Block<S, N>, MoveError> {
        let motion = match &self.path {
            Path::Line { to } => Motion::Line { to: point(to, from)? },
            Path::Arc { to, plane, centre, clockwise, extra_turns } => Motion::Arc {
                to: point(to, from)?,
                plane: (usize::from(plane.0), usize::from(plane.1)),
                centre: (
                    coord(usize::from(plane.0), centre.0)?,
                    coord(usize::from(plane.1), centre.1)?,
                ),
                turn: if *clockwise { Turn::Clockwise } else { Turn::CounterClockwise },
                extra_turns: *extra_turns,
            },
            Path::Cubic { controls: [first, second], to } => Motion::Cubic {
                controls: [point(first, from)?, point(second, from)?],
                to: point(to, from)?,
            },
            Path::Dwell { seconds } => Motion::Dwell { seconds: scalar(*seconds) },
            Path::Event { pause, .. } => Motion::Event { pause: *pause },
        };
        let feed = self.speed.to_scalar();
        let tolerance = self.tolerance.map(scalar);
        Ok(Block { motion, feed, tolerance, exact_stop: self.exact_stop, tag: self.tag })
    }
}

fn scalar<S: Scalar>(x: f32) -> S {
    S::of(f64::from(x))
}

fn single<S: Scalar>(x: S) -> f32 {
    x.to_f64() as f32
}

impl<S: Scalar, const N: usize> From<&Block<S, N>> for Move {
    /// Rounds to nanometres and `f32`, and gives every axis a number.
    fn from(block: &Block<S, N>) -> Self {
        let path = match &block.motion {
            Motion::Line { to } => Path::Line { to: target(to) },
            Motion::Arc { to, plane, centre, turn, extra_turns } => Path::Arc {
                to: target(to),
                plane: (plane.0 as u8, plane.1 as u8),
                centre: (centre.0.to_nm(), centre.1.to_nm()),
                clockwise: *turn == Turn::Clockwise,
                extra_turns: *extra_turns,
            },
            Motion::Cubic { controls: [first, second], to } => {
                Path::Cubic { controls: [target(first), target(second)], to: target(to) }
            }
            Motion::Dwell { seconds } => Path::Dwell { seconds: single(*seconds) },
            Motion::Event { pause } => {
                Path::Event { letter: b'M', tenths: 0, value: None, pause: *pause }
            }
        };
        let speed = block.feed.to_scalar();
        let tolerance = block.tolerance.map(single);
        Self { path, speed, tolerance, exact_stop: block.exact_stop, tag: block.tag }
    }
}
