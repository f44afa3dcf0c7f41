//! What the machine can do: axis limits, servo cycle, and how the core is tuned to it.

mod config;
pub mod defaults;
mod error;
#[cfg(feature = "shaping")]
mod follower;
#[cfg(feature = "kinematics")]
mod kinematics;
mod limits;
mod motors;
mod quantity;
mod ramp;
mod sets;
mod size;
#[cfg(feature = "travel")]
mod travel;

pub(crate) use config::LEAST_CYCLE_SHARE;
pub use config::{Config, CornerMode};
pub use error::ConfigError;
#[cfg(feature = "shaping")]
pub use follower::Follower;
#[cfg(feature = "kinematics")]
use kinematics::{Everywhere, check_factors};
#[cfg(feature = "kinematics")]
pub use kinematics::{Follows, Kinematics, Linear, Region};
#[cfg(all(feature = "c", feature = "kinematics"))]
pub(crate) use kinematics::{fixed, times};
pub(crate) use limits::UNLIMITED;
pub use limits::{AxisLimits, Limits};
#[cfg(not(feature = "kinematics"))]
pub(crate) use motors::Motor;
#[cfg(feature = "kinematics")]
pub use motors::{MOTORS, Motor};
pub use quantity::Quantity;
pub(crate) use ramp::Ramp;
pub(crate) use sets::{LimitSets, OlderLimits, SetNumber};
#[cfg(feature = "outputs")]
pub use size::{ANALOGUE, DIGITAL, POWERS, SWITCHES};
pub use size::{BLOCKS, NODES};
#[cfg(feature = "travel")]
pub use travel::{AxisTravel, Travel};
