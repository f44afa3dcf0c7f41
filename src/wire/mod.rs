//! Streaming of blocks from a host to a controller over a serial line (feature `wire`).
//!
//! # On the line
//!
//! Every message is one frame: its fields as [postcard](https://postcard.jamesmunns.com/wire-format)
//! writes them, a CRC-32/ISCSI of these bytes (little-endian), the whole in COBS, and a zero byte at the
//! end. Zero bytes occur nowhere else, so a receiver that has lost its place finds it again at the next
//! frame. A frame whose CRC does not fit is dropped and counted. A frame has at most [`FRAME`] bytes; a
//! line in three axes has about 35.
//!
//! # What is said
//!
//! The host sends [`Request`]s, the controller answers with [`Reply`]s:
//!
//! - [`Request::Hello`] asks which protocol is spoken: the same in every version.
//! - [`Request::Open`] begins a session under a number of the host's choosing. Frames of any other
//!   session are dropped.
//! - [`Request::Item`] carries a block, or the end of the program, and its running number from 0. The
//!   controller takes items strictly in order: a number it has had is dropped, and so is one after a
//!   gap. Each [`Reply::Taken`] says which number comes next (so everything before is taken, for good),
//!   and up to which number there is room: the window. The host sends what is in the window and goes
//!   back to the next number expected if it hears of a gap, or nothing for a while.
//! - [`Request::Command`] is an operator's command. It has a running number of its own and is repeated
//!   until it is acknowledged, and obeyed once. It does not wait for the items before it: the
//!   controller gives it to [`Controls`](crate::Controls) as soon as the frame is complete.
//!   A jog ([`Command::Jog`]) is for the planner: the next [`Station::poll`] hands it over, and [`Situation::jog`] says why it
//!   was not taken, if so.
//! - [`Request::Ask`] asks for [`Reply::Status`], in a session or without one.
//!
//! So cut, garbled, doubled and lost frames cost time and nothing else.
//!
//! # Who may move the machine
//!
//! - One sender at a time. While its session is alive, every other is denied ([`Denial::Busy`]).
//! - A sender that has not been heard of for as long as it said in [`Opening::silence`] (any frame of its
//!   session counts; [`Request::Alive`] is there for when nothing else is to be said) is lost: with the
//!   next [`Station::poll`] the machine is held, and rests on the path as soon as its limits allow:
//!   [`State::SenderLost`]. It goes on when the same sender comes back and sends [`Command::Resume`],
//!   never by itself. A sender that leaves ([`Request::Close`]) with blocks unfinished is lost at once.
//! - The session of a lost sender may be followed by another. What it has left is never run in that:
//!   the new one is denied ([`Denial::Left`]) unless it asks for an abort ([`Opening::abort`]); then
//!   the machine comes to rest, everything is dropped, and only then does the session begin.
//! - A jog with nothing to run leads away from where the session's blocks would begin: no more are taken in it. The silence of its
//!   sender ends it.
//! - After an abort, a refused block or an emergency stop the controller takes no more items in this
//!   session: what the host still had on the line cannot be run by mistake. A new session starts where
//!   the machine stands, and acknowledges the abort
//!   ([`Planner::acknowledge_abort`](crate::Planner::acknowledge_abort)).
//! - Overrides, single block mode and holds that an operator has pressed outlast the session, and the abort that the next one may open with: that
//!   finds [`State::Held`] and has to resume. (An abort by command ends a hold that was pressed before.)
//!
//! A move names the axes that move ([`Target`]); the others stay exactly where they are, to the last of
//! the core's units.
//!
//! # Events
//!
//! What is not motion - spindle, coolant, tool - goes through the queue of items in its place
//! ([`Path::Event`]), and comes out of [`Events`] in the servo cycle in which the motion has come to it.
//! [`Situation::events`] tells the host how many have happened.
//!
//! # Outputs
//!
//! [`Item::Switch`] and [`Item::Power`] stand between the moves (feature `outputs` of the controller). What switches at rest is an event,
//! of the letter [`IN_TIME`]; everything else comes out of `Interpolator::switch`. A session begins without power.
//!
//! # Probes and homing
//!
//! [`Item::Probe`] and [`Item::Home`] begin when everything before them has been run (features `probe` and `home`). Until they are over the
//! window is closed: what follows begins where the machine then stands, and a host that does not know the place asks for the
//! status first. [`Situation::probe`] has the place of the edge, [`Situation::homing`] what every axis does and what has gone wrong. A hold
//! stops them, and they go on when it is resumed; [`Command::CancelJog`], an abort and the silence of the sender end them. Then, and if
//! a probe had to end by its input and has not, or an axis does not find its switch, no more items are taken in the session:
//! [`Refusal::Probe`], [`Refusal::Home`].
//!
//! # Both ends
//!
//! [`Station`] is the controller's end and [`Sender`] the host's. Neither knows a port or a clock; bytes
//! and times go in, bytes come out.

mod frame;
#[cfg(test)]
mod golden;
mod jog;
// Messages live on the stack for the length of a call; there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
mod message;
#[allow(clippy::large_enum_variant)]
mod moves;
mod outputs;
mod seek;
mod seeking;
#[allow(clippy::large_enum_variant)]
mod sender;
mod station;

pub use frame::{FRAME, Inlet, encode};
pub use jog::{JogMove, JogRefusal};
pub use message::{
    Command, Denial, Item, Opening, Refusal, Reply, Request, SILENCE, Situation, State, Taken,
    VERSION,
};
pub use moves::{Axes, Move, MoveError, Path, Speed, Target};
pub use outputs::{
    IN_TIME, PowerMove, SwitchMove, SwitchOffset, SwitchOutput, SwitchRefusal, SwitchTrigger,
};
pub use seek::{
    HomeAxis, HomeFault, HomeMove, HomeReport, HomeStep, HomeTrouble, ProbeEnd, ProbeInput,
    ProbeMove, ProbeResult, SeekRefusal,
};
pub use sender::{Sender, Step};
pub use station::Station;

pub use crate::servo::events::{Event, Events};
