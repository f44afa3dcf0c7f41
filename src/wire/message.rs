//! What host and controller say to each other.

use super::jog::{JogMove, JogRefusal};
use super::moves::{Axes, Move};
use super::outputs::{PowerMove, SwitchMove, SwitchRefusal};
use super::seek::{HomeMove, HomeReport, ProbeEnd, ProbeMove, ProbeResult, SeekRefusal};
use crate::block::BlockError;
use crate::number::RangeError;
use crate::number::serial::Serial;
use core::fmt;
use serde::{Deserialize, Serialize};

/// Version of the protocol. [`Request::Hello`] and [`Reply::Hello`] are the same in every version, so
/// that two ends of different versions can say so.
pub const VERSION: u8 = 6;

/// Silence after which a controller counts a sender as lost, if the sender does not ask for another
/// time, ms.
pub const SILENCE: u16 = 1000;

/// What is numbered: items of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Items {}

/// Running number of an item, without the session.
pub(super) type ItemSerial = Serial<Items>;

/// What is taken in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Item {
    /// A block.
    Move(Move),
    /// No more blocks come: the path ends where the last one ends.
    End,
    /// An output that switches in time with the path.
    Switch(SwitchMove),
    /// The power of a tool along the moves that follow.
    Power(PowerMove),
    /// A probe, when everything before it has been run. No more items are taken until it is over: what follows begins where the machine
    /// then stands.
    Probe(ProbeMove),
    /// Axes that find their switches, in the same way.
    Home(HomeMove),
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
    /// Move off the path.
    Jog(JogMove),
    /// End a jog.
    CancelJog,
    /// Feed hold by the stop limits.
    QuickHold,
    /// Brake by the stop limits and drop everything.
    QuickAbort,
}

impl Command {
    /// Passes the command on. A jog is the planner's: [`Station`](super::Station) keeps it.
    pub fn send(self, controls: crate::Controls<'_>) {
        match self {
            Self::Hold => controls.hold(),
            Self::Resume => controls.resume(),
            Self::Stop => controls.stop(),
            Self::Abort => controls.abort(),
            Self::QuickHold => controls.quick_hold(),
            Self::QuickAbort => controls.quick_abort(),
            Self::FeedOverride(percent) => controls.feed_override(percent),
            Self::RapidOverride(percent) => controls.rapid_override(percent),
            Self::SingleBlock(on) => controls.single_block(on),
            #[cfg(feature = "jog")]
            Self::CancelJog => controls.cancel_jog(),
            #[cfg(not(feature = "jog"))]
            Self::CancelJog => {}
            Self::Jog(_) => {}
        }
    }
}

/// What a sender asks for who wants to begin a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Opening {
    /// Its [`VERSION`].
    pub version: u8,
    /// The session's number, of the sender's choosing; it must differ from the one before.
    pub session: u32,
    /// Silence of the sender after which the machine is stopped, ms; 0: it runs on with what it has.
    pub silence: u16,
    /// Whether to abort what a dead session has left; without it such an opening is denied.
    pub abort: bool,
}

/// From the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Say which protocol you speak. Opens nothing.
    Hello {
        /// Comes back in the reply.
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
    /// Say how things are. Anybody may ask, in any session or none.
    Ask,
    /// Begin a session.
    Open(Opening),
    /// The sender of the session is there; say how things are.
    Alive {
        /// The session.
        session: u32,
    },
    /// The sender leaves. What it leaves unfinished is stopped as if it had fallen silent.
    Close {
        /// The session.
        session: u32,
    },
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
    /// The block with this tag leads out of the limits of travel; everything before it is run.
    Travel {
        /// Its tag.
        tag: u32,
        /// Index of the axis.
        axis: u8,
        /// How far the block would go, nm.
        to: i64,
        /// The limit that it would leave, nm.
        limit: i64,
    },
    /// The machine has been jogged away from where the blocks would have begun.
    Jogged,
    /// The output with this tag cannot be; everything before it is run.
    Output {
        /// Its tag.
        tag: u32,
        /// Why.
        reason: SwitchRefusal,
    },
    /// The probe or homing with this tag cannot begin.
    Seek {
        /// Its tag.
        tag: u32,
        /// Why.
        reason: SeekRefusal,
    },
    /// The probe with this tag has not ended by its input, which it had to, or was cancelled.
    Probe {
        /// Its tag.
        tag: u32,
        /// How it ended.
        end: ProbeEnd,
    },
    /// The homing with this tag has failed: [`Situation::homing`] says at which axis.
    Home {
        /// Its tag.
        tag: u32,
    },
}

impl Refusal {
    /// Of the block with this tag, for a reason.
    pub(super) fn of(tag: u32, reason: &BlockError) -> Self {
        let BlockError::Travel { axis, error: RangeError { value, least, greatest } } = *reason
        else {
            return Self::Block { tag };
        };
        let nm = |mm: f64| libm::round(mm * 1.0e6) as i64;
        let limit = nm(if value < least { least } else { greatest });
        Self::Travel { tag, axis: axis as u8, to: nm(value), limit }
    }
}

/// Why the controller does not begin a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Denial {
    /// It speaks another version of the protocol.
    Version,
    /// The session of another sender is alive.
    Busy,
    /// Blocks of a session whose sender is gone are left; [`Opening::abort`] would drop them.
    Left,
    /// An abort is under way. Not a refusal: ask again.
    Stopping,
    /// The session with this number is over.
    Over,
}

impl fmt::Display for Denial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Version => "it speaks another version of the protocol",
            Self::Busy => "another sender has the machine",
            Self::Left => "blocks of another program are left whose sender is gone",
            Self::Stopping => "an abort is under way",
            Self::Over => "the session is over",
        })
    }
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
    /// At rest because an operator or a pause of the program asked for it.
    Held,
    /// Stopped, or stopping, by the emergency stop, a limit switch, or an output that did not follow.
    Alarm,
    /// At rest on the path because the sender has fallen silent: goes on when it sends
    /// [`Command::Resume`].
    SenderLost,
    /// At rest after an abort; everything is dropped. Lasts until a new session.
    Aborted,
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
    /// Events of the session that have happened.
    pub events: u32,
    /// Why the last jog of the session was not taken, if so.
    pub jog: Option<JogRefusal>,
    /// What came of the last probe of the session, if there was one.
    pub probe: Option<ProbeResult>,
    /// How far homing is, or what came of the last of the session, if there was one.
    pub homing: Option<HomeReport>,
}

/// From the controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// The answer to [`Request::Hello`].
    Hello {
        /// [`VERSION`] of the controller.
        version: u8,
        /// Its number of axes.
        axes: u8,
        /// Its [`Taken::session`] is that of the request; the rest says nothing.
        taken: Taken,
    },
    /// Items or commands have come.
    Taken(Taken),
    /// The answer to [`Request::Ask`] and [`Request::Alive`].
    Status {
        /// How far it is; `None` before the first session.
        taken: Option<Taken>,
        /// What the machine is doing.
        situation: Situation,
        /// Frames that arrived damaged.
        damaged: u32,
    },
    /// The session is open.
    Opened(Taken),
    /// The session is not open.
    Denied {
        /// The session that was asked for.
        session: u32,
        /// Why.
        reason: Denial,
    },
}
