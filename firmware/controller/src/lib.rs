//! What of a controller no board changes. The background: bytes from the line, an operator's commands,
//! alarms, planning, replies and what the machine is said to be doing. `no_std`, allocation-free, without a way
//! to panic.
//!
//! A board gives a [`Port`] - a line, a clock, the last setpoint, its alarms - and calls [`Background::round`]
//! again and again in the context of the lowest priority; its servo interrupt calls
//! [`Interpolator::tick`](splineway::Interpolator::tick) and takes [`Events`](splineway::wire::Events). The
//! images for boards, the emulator and the host's `splineway controller` run this loop. With the feature `grbl` there is the
//! same for senders that speak the protocol of grbl. And [`Drives`]: step and direction of all axes, for the timer interrupt of a
//! board with steppers.
//!
//! What does not belong here: pins, timers, a chip's registers, a log (those are a board's), the rules of the
//! line ([`splineway::wire`]), and motion ([`splineway`]).
#![no_std]

#[cfg(test)]
extern crate std;

mod background;
mod clock;
mod drives;
#[cfg(feature = "grbl")]
pub mod grbl;

pub use background::{Background, Port};
pub use clock::Clock;
pub use drives::{Beat, Drives, Targets};
