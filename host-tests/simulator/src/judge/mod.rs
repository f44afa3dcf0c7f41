//! Every setpoint against the band, the axis limits and the time that a run may take; pass or fail is said here
//! and nowhere else.

mod guide;
mod pass;
mod track;
mod verdict;
mod witness;

pub use pass::{judged, violations};
pub use track::{Follower, Outside, SAGITTA, Track, Winding};
pub use verdict::{Judge, Verdict};
pub use witness::{Peaks, Witness};
