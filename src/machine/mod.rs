//! What the machine can do: axis limits, servo cycle, and how the core is tuned to it.

mod config;
mod error;
mod limits;

pub use config::{Config, CornerMode};
pub use error::{ConfigError, Quantity};
pub use limits::{AxisLimits, Limits};
