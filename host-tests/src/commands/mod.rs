//! The commands of the `splineway` program.

pub mod corners;
pub mod simulate;
pub mod smooth;
pub mod thesis;
