//! The commands of the `splineway` program.

#[cfg(unix)]
pub mod controller;
pub mod corners;
pub mod simulate;
pub mod smooth;
pub mod soak;
pub mod stream;
pub mod thesis;
