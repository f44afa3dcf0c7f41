//! Programs over a serial line: the host's end, and a controller without a machine to try it on.

#[cfg(unix)]
mod controller;
mod convert;
mod order;
mod place;
mod send;
mod talk;

#[cfg(unix)]
pub use controller::{Controller, Faults, Happening};
pub use convert::{check, items};
pub use order::{Command, Order, parse_command};
pub use place::{describe_event, describe_place, describe_state, open_port, placed};
pub use send::{Settings, Summary, send};
pub use talk::{Controlled, News};
