//! What the machine can do: axis limits, servo cycle, and how the core is tuned to it.

mod config;
mod error;
mod limits;
mod ramp;
mod size;

pub use config::{Config, CornerMode};
pub use error::{ConfigError, Quantity};
pub use limits::{AxisLimits, Limits};
pub(crate) use ramp::Ramp;
pub use size::{BLOCKS, NODES};
