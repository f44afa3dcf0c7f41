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
//! - [`Request::Ask`] asks for [`Reply::Status`].
//!
//! So cut, garbled, doubled and lost frames cost time and nothing else. After an abort, a refused block
//! or an emergency stop the controller takes no more items in this session: what the host still had on
//! the line cannot be run by mistake. A new session starts clean.
//!
//! # Both ends
//!
//! [`Station`] is the controller's end and [`Sender`] the host's. Neither knows a port or a clock; bytes
//! and times go in, bytes come out.

mod frame;
// Messages live on the stack for the length of a call; there is no heap to box them on.
#[allow(clippy::large_enum_variant)]
mod message;
#[allow(clippy::large_enum_variant)]
mod sender;
mod station;

pub use frame::{FRAME, Inlet, encode};
pub use message::{
    Axes, Command, Item, Move, MoveError, Path, Refusal, Reply, Request, Situation, Speed, State,
    Taken, VERSION,
};
pub use sender::{Sender, Step};
pub use station::Station;
