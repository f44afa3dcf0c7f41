//! Running programs through the core, cycle by cycle, and judging what comes out.

pub mod judge;
pub mod runner;
pub mod track;

pub use judge::{Judge, Verdict};
pub use runner::{Observer, Precision, Sample, Stats, Timing, run};
pub use track::Track;
