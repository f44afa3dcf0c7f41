//! The protocol of grbl 1.1, as senders that people have speak it (feature `grbl`).
//!
//! [`Station`] is the controller's end: bytes go in ([`Station::receive`]), lines of G-code become blocks of the planner
//! ([`Station::poll`], in place of [`Planner::poll`](crate::Planner::poll)), and bytes come out ([`Station::say`]). It knows no port and
//! no clock. `docs/grbl.md` has what is spoken, and what settings mean here.
//!
//! # Rules
//!
//! - *One answer per line*, in the order of the lines: `ok` when the planner has taken all that a line asks for, or `error:` and a number
//!   as published. So a sender may count characters, up to [`RECEIVE`]; while the look-ahead is full, the `ok` waits.
//! - *A line with an error does nothing*: the modes and the position of the reader are as before it. A line that would lead out of the
//!   travel raises [`Alarm::SoftLimit`] besides.
//! - *Commands of one byte* are obeyed when they come, wherever they stand: `?`, `!`, `~`, 0x18 and those above 0x7F.
//! - *The position is never lost*: a reset brakes within the limits, and the machine knows where it rests. So it ends in no alarm.
//! - *Nothing moves that nobody asked for*: after a reset or an alarm the reader stands where the machine does, and everything that
//!   waited is dropped.
//!
//! `$H` is there with the feature `home`, G38.2 to G38.5 with `probe`, M62 to M68 and a laser with `outputs`. A probe and homing are answered
//! when they are over; lines behind them wait.
//!
//! What is kept without power - settings, work offsets, startup lines - goes through a [`Store`] of two pages.

mod accessories;
mod code;
mod commands;
#[cfg(feature = "home")]
mod homing;
mod inbox;
mod lines;
mod outbox;
#[cfg(feature = "outputs")]
mod outputs;
#[cfg(feature = "probe")]
mod probing;
mod realtime;
mod report;
mod safety;
mod settings;
mod station;
mod store;
mod telling;
#[cfg(test)]
mod tests;
#[cfg(all(test, feature = "home"))]
mod tests_home;
#[cfg(all(test, feature = "outputs"))]
mod tests_outputs;
#[cfg(all(test, feature = "probe"))]
mod tests_seek;

pub use accessories::{Accessories, Spindle};
pub use code::{Alarm, Error};
pub use inbox::RECEIVE;
pub use report::{Inputs, State};
pub use settings::{AxisSettings, Settings};
pub use station::Station;
pub use store::{Store, words};

pub use crate::servo::events::{Event, Events};
