//! What a run leaves: setpoints, a report, a trace for plots.

pub mod recording;
mod report;
mod setpoints;
mod trace;

pub use report::Report;
pub use setpoints::CsvOut;
pub use trace::{Point, Trace};
