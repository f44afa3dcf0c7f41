//! What host and controller say to each other.

use crate::block::{Block, BlockError, Feed, Motion, Turn};
use crate::number::{Coord, Scalar};
use core::fmt;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the protocol.
pub const VERSION: u8 = 1;

/// Positions of up to nine axes, nm (1e-6 degrees on a rotary axis).
pub type Axes = Vec<i64, 9>;

/// Where a move goes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Path {
    /// Straight to a point.
    Line {
        /// End point, absolute.
        to: Axes,
    },
    /// Along a circle or helix.
    Arc {
        /// End point, absolute.
        to: Axes,
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
        controls: [Axes; 2],
        /// End point, absolute.
        to: Axes,
    },
    /// Stand still.
    Dwell {
        /// Duration, s.
        seconds: f32,
    },
    /// Rest, and report an event.
    Event {
        /// Whether to rest until the operator resumes.
        pause: bool,
    },
}

/// How fast a move runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Speed {
    /// mm/s, or degrees/s.
    PerSecond(f32),
    /// Duration of the move, s.
    Duration(f32),
    /// As fast as the axes can.
    Rapid,
}

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
    let error = BlockError::Coordinate { axis, value: nm as f64 * 1.0e-6 };
    Coord::from_nm(nm).ok_or(MoveError::Coordinate(error))
}

fn point<const N: usize>(axes: &Axes) -> Result<[Coord; N], MoveError> {
    if axes.len() != N {
        return Err(MoveError::Axes { given: axes.len(), axes: N });
    }
    let mut to = [Coord::ZERO; N];
    for (axis, (to, &nm)) in to.iter_mut().zip(axes).enumerate() {
        *to = coord(axis, nm)?;
    }
    Ok(to)
}

fn axes<const N: usize>(point: &[Coord; N]) -> Axes {
    point.iter().map(|coord| coord.to_nm()).take(9).collect()
}

impl Move {
    /// As a block of a controller with `N` axes.
    ///
    /// # Errors
    /// [`MoveError`] if it has another number of axes, or a coordinate beyond [`Coord::LIMIT_MM`].
    pub fn block<S: Scalar, const N: usize>(&self) -> Result<Block<S, N>, MoveError> {
        let motion = match &self.path {
            Path::Line { to } => Motion::Line { to: point(to)? },
            Path::Arc { to, plane, centre, clockwise, extra_turns } => Motion::Arc {
                to: point(to)?,
                plane: (usize::from(plane.0), usize::from(plane.1)),
                centre: (
                    coord(usize::from(plane.0), centre.0)?,
                    coord(usize::from(plane.1), centre.1)?,
                ),
                turn: if *clockwise { Turn::Clockwise } else { Turn::CounterClockwise },
                extra_turns: *extra_turns,
            },
            Path::Cubic { controls: [first, second], to } => {
                Motion::Cubic { controls: [point(first)?, point(second)?], to: point(to)? }
            }
            Path::Dwell { seconds } => Motion::Dwell { seconds: scalar(*seconds) },
            Path::Event { pause } => Motion::Event { pause: *pause },
        };
        let feed = match self.speed {
            Speed::PerSecond(feed) => Feed::PerSecond(scalar(feed)),
            Speed::Duration(seconds) => Feed::Duration(scalar(seconds)),
            Speed::Rapid => Feed::Rapid,
        };
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
    /// Rounds to nanometres and `f32`.
    fn from(block: &Block<S, N>) -> Self {
        let path = match &block.motion {
            Motion::Line { to } => Path::Line { to: axes(to) },
            Motion::Arc { to, plane, centre, turn, extra_turns } => Path::Arc {
                to: axes(to),
                plane: (plane.0 as u8, plane.1 as u8),
                centre: (centre.0.to_nm(), centre.1.to_nm()),
                clockwise: *turn == Turn::Clockwise,
                extra_turns: *extra_turns,
            },
            Motion::Cubic { controls: [first, second], to } => {
                Path::Cubic { controls: [axes(first), axes(second)], to: axes(to) }
            }
            Motion::Dwell { seconds } => Path::Dwell { seconds: single(*seconds) },
            Motion::Event { pause } => Path::Event { pause: *pause },
        };
        let speed = match block.feed {
            Feed::PerSecond(feed) => Speed::PerSecond(single(feed)),
            Feed::Duration(seconds) => Speed::Duration(single(seconds)),
            Feed::Rapid => Speed::Rapid,
        };
        let tolerance = block.tolerance.map(single);
        Self { path, speed, tolerance, exact_stop: block.exact_stop, tag: block.tag }
    }
}

/// What is taken in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Item {
    /// A block.
    Move(Move),
    /// No more blocks come: the path ends where the last one ends.
    End,
}

/// An operator's command: see [`Controls`](crate::Controls).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Feed hold.
    Hold,
    /// Go on.
    Resume,
    /// Finish the block under way.
    Stop,
    /// Brake and drop everything.
    Abort,
    /// Feed override, per cent.
    FeedOverride(u16),
    /// Override of rapids, per cent.
    RapidOverride(u16),
    /// Single block mode.
    SingleBlock(bool),
}

impl Command {
    /// Passes the command on.
    pub fn send(self, controls: crate::Controls<'_>) {
        match self {
            Self::Hold => controls.hold(),
            Self::Resume => controls.resume(),
            Self::Stop => controls.stop(),
            Self::Abort => controls.abort(),
            Self::FeedOverride(percent) => controls.feed_override(percent),
            Self::RapidOverride(percent) => controls.rapid_override(percent),
            Self::SingleBlock(on) => controls.single_block(on),
        }
    }
}

/// From the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Begin a session.
    Open {
        /// Its number.
        session: u32,
    },
    /// A block, or the end.
    Item {
        /// The session it belongs to.
        session: u32,
        /// Running number from 0.
        number: u32,
        /// The item.
        item: Item,
    },
    /// A command that overtakes the items.
    Command {
        /// The session it belongs to.
        session: u32,
        /// Running number from 0, apart from that of the items.
        number: u32,
        /// The command.
        command: Command,
    },
    /// Say how things are.
    Ask,
}

/// Why the controller takes no more items in this session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// The block with this tag is not valid; everything before it is run.
    Block {
        /// Its tag.
        tag: u32,
    },
    /// An abort was asked for.
    Aborted,
    /// The emergency stop, a limit switch, or an output that did not follow.
    Alarm,
}

/// How far the controller is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Taken {
    /// The session.
    pub session: u32,
    /// Number of the item that comes next.
    pub next: u32,
    /// The first number for which there is no room yet.
    pub limit: u32,
    /// Number of the command that comes next.
    pub commands: u32,
    /// An item after a gap has just been dropped.
    pub gap: bool,
    /// Why no more is taken, if so.
    pub refused: Option<Refusal>,
}

/// What the machine is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// At rest, nothing to do.
    #[default]
    Idle,
    /// In motion, or about to be.
    Running,
    /// At rest because an operator asked for it.
    Held,
    /// Stopped by the emergency stop, a limit switch, or an output that did not follow.
    Alarm,
}

/// What the controller tells of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Situation {
    /// What it is doing.
    pub state: State,
    /// Setpoints of the axes, nm.
    pub position: Axes,
    /// Speed along the path, mm/s.
    pub speed: f32,
    /// Tag of the block under way.
    pub tag: u32,
    /// Stops because blocks did not come in time.
    pub starved: u32,
}

/// From the controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// The session is open.
    Opened {
        /// [`VERSION`] of the controller.
        version: u8,
        /// Its number of axes.
        axes: u8,
        /// How far it is.
        taken: Taken,
    },
    /// Items or commands have come.
    Taken(Taken),
    /// The answer to [`Request::Ask`].
    Status {
        /// How far it is; `None` before the first session.
        taken: Option<Taken>,
        /// What the machine is doing.
        situation: Situation,
        /// Frames that arrived damaged.
        damaged: u32,
    },
}
