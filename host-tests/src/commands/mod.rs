//! The commands of the `splineway` program.

pub mod simulate;
