//! The interrupt side: pieces of motion in, one setpoint per servo cycle out.
//!
//! Nothing in here plans. A piece is a polynomial per axis; the [`Interpolator`] evaluates it
//! and moves on to the next; a [`Link`](crate::Link) carries whole plans over from the planner, each ending
//! at rest, so that the interrupt can always come to a stop with what it has.

pub(crate) mod control;
#[cfg(any(feature = "wire", feature = "grbl"))]
pub(crate) mod events;
#[cfg(feature = "probe")]
pub(crate) mod input;
#[cfg(not(feature = "interleave"))]
pub(crate) mod interleave;
#[cfg(feature = "interleave")]
#[doc(hidden)]
pub mod interleave;
mod interpolator;
pub(crate) mod link;
#[cfg(all(test, loom, not(feature = "interleave")))]
mod models;
pub(crate) mod piece;
mod setpoint;
#[cfg(feature = "outputs")]
mod switcher;
#[cfg(feature = "outputs")]
pub(crate) mod switching;

pub use control::Controls;
#[cfg(feature = "probe")]
pub use input::{Input, Inputs};
pub use interpolator::Interpolator;
pub use setpoint::{Activity, Setpoint};
#[cfg(feature = "outputs")]
pub use switcher::Switched;
