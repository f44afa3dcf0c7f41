//! Running programs through the core, cycle by cycle, and judging what comes out.

pub mod duration;
pub mod events;
pub mod geometry;
pub mod happenings;
pub mod judge;
pub mod runner;
pub mod track;
pub mod witness;

pub use duration::{Overtime, Pace, Stops, Stopwatch};
pub use events::{Action, Event, Events, FORMAT};
pub use geometry::Geometry;
pub use happenings::{Happening, Happenings};
pub use judge::{Judge, Verdict};
pub use runner::{Observer, Precision, Sample, Stats, Timing, block, run, run_with};
pub use track::Track;
pub(crate) use track::Winding;
