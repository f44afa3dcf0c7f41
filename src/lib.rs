//! splineway: a motion interpolator core for CNC controllers.
#![no_std]

#[cfg(any(test,feature="dbg"))]
extern crate std;
#[cfg(test)]
use std::prelude::v1::*;

pub mod block;
pub mod machine;
pub mod number;
mod path;
mod planner;
mod profile;
pub mod servo;

pub use block::{Block, Feed, Motion, PushError, Turn};
pub use machine::{AxisLimits, Config, CornerMode, Limits};
pub use number::{Coord, Scalar};
pub use planner::{Counters, Planner, Progress};
pub use servo::{Activity, Interpolator, Link, Setpoint};
