//! Programs over a serial line: the host's end, and a controller without a machine to try it on.

#[cfg(unix)]
mod controller;
mod convert;
#[cfg(unix)]
mod grbl;
#[cfg(unix)]
mod line;
mod order;
#[cfg(unix)]
mod pace;
mod place;
mod send;
mod talk;

#[cfg(unix)]
pub use controller::{Controller, Faults, Happening};
pub use convert::{Part, check, items, parts};
#[cfg(unix)]
pub use grbl::{Doing, Grbl, Kept};
#[cfg(unix)]
pub use line::Line;
pub use order::{Command, Order, parse_command};
pub use place::{describe_event, describe_place, describe_state, open_port, placed};
pub use send::{Settings, Summary, send};
pub use talk::{Controlled, News};
