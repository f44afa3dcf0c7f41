//! A run, recorded for plots in a page: every servo cycle, within a tenth of the tolerance.
//!
//! Positions, velocities, accelerations and jerks of all axes are one set of polynomials over spans that are as long as the motion
//! lets them be. A run takes some ten bytes per axis and change of jerk, however many cycles it has.

mod columns;
mod fit;
mod grain;
mod outline;
mod recorder;
mod span;
mod tape;

pub use columns::{Column, Numbers};
pub use fit::{Span, State};
pub use grain::{FINEST, Grain, SHARE, Unit};
pub use outline::Outline;
pub use recorder::{Peaks, Recorder, Recording, Watched, activity_code};
pub use tape::{Spans, Tape};
