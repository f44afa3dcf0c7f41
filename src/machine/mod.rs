//! What the machine can do: axis limits, servo cycle, and how the core is tuned to it.

mod config;
pub mod defaults;
mod error;
mod limits;
mod quantity;
mod ramp;
mod sets;
mod size;
#[cfg(feature = "travel")]
mod travel;

pub use config::{Config, CornerMode};
pub use error::ConfigError;
pub(crate) use limits::UNLIMITED;
pub use limits::{AxisLimits, Limits};
pub use quantity::Quantity;
pub(crate) use ramp::Ramp;
pub(crate) use sets::{LimitSets, OlderLimits, SetNumber};
#[cfg(feature = "outputs")]
pub use size::{ANALOGUE, DIGITAL, POWERS, SWITCHES};
pub use size::{BLOCKS, NODES};
#[cfg(feature = "travel")]
pub use travel::{AxisTravel, Travel};
