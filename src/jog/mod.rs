//! Jogging: motion without a program, on the path of which nothing is known (feature `jog`).
//!
//! [`Planner::jog`](crate::Planner::jog) takes a [`Jog`]; `docs/jog.md` tells the rules and shows the motion.
//!
//! - `ramp`: from any speed and acceleration to another speed, within the limits of one axis.
//! - `reach`: the same to a place, at rest.
//! - `axis`: what one axis does from a servo cycle on until it rests: phases of constant jerk.
//! - `shares`: what each axis gets of motors that several of them have in common (feature `kinematics`, `docs/kinematics.md`).
//! - `plan`: what all axes do, and the pieces that the interrupt runs.
//! - `brake`: the shortest stop along a line, and `probe`: moves that end so on an input (feature `probe`, `docs/probe.md`).
//! - `homing`: how an axis finds its switch (feature `home`, `docs/home.md`).
//!
//! Every phase lasts a whole number of servo cycles, so those of different axes never begin within a cycle at different times,
//! and a motion can be left for another at any cycle with its exact state. Durations are found as real numbers and rounded up;
//! then the peaks of acceleration and the speed between are solved for, exactly, by a linear equation. Units of what is not
//! public are mm and servo cycles.

pub(crate) mod axis;
#[cfg(feature = "probe")]
mod brake;
mod command;
#[cfg(feature = "home")]
pub(crate) mod homing;
pub(crate) mod plan;
#[cfg(feature = "probe")]
pub(crate) mod probe;
mod ramp;
mod reach;
#[cfg(feature = "kinematics")]
mod shares;

pub use command::{Jog, JogError};
#[cfg(feature = "home")]
pub use homing::{AxisHome, HomeFailure, HomeFault, HomePhase};
#[cfg(feature = "probe")]
pub use probe::{Outcome, Overshoot, Probe, ProbeError, Probed};
