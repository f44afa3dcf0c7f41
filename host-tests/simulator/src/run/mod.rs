//! Running programs through the core, cycle by cycle.

mod command;
pub mod duration;
pub mod events;
pub mod happenings;
mod jog;
pub mod runner;
mod seek;
mod sought;
mod timing;
mod validate;

pub use command::{Command, parse_command};
pub use duration::{Overtime, Pace, Stops, Stopwatch};
pub use events::{Action, Event, Events, FORMAT};
pub use happenings::{Happening, Happenings};
pub use jog::{on_axes, parse_jog};
pub use runner::{Observer, Precision, Sample, Stats, block, run, run_with};
pub use seek::{Beyond, Homing, Seeker};
pub use sought::{Ending, Search, Sought, Spot};
pub use timing::Timing;
pub use validate::{on_letters, sharp_corners, validate};
