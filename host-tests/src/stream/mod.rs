//! Programs over a serial line: the host's end, and a controller without a machine to try it on.

#[cfg(unix)]
mod controller;
mod send;

#[cfg(unix)]
pub use controller::{Controller, Faults};
pub use send::{Command, Summary, items, parse_command, send};
