//! The commands of the `splineway` program.

pub mod bench;
pub mod check;
#[cfg(unix)]
pub mod controller;
pub mod corners;
pub mod simulate;
pub mod smooth;
pub mod soak;
pub mod stream;
pub mod thesis;
