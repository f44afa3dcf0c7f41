//! Tool paths as read from files, before they become blocks of the core.

pub mod arc;
pub mod curve;
mod finding;
pub mod gcode;
pub mod poly;
mod read;
mod tape;
mod tool_path;

pub use crate::point::{AXES, LETTERS, Point, on_cubic};
pub use finding::{Finding, SHOWN, Severity, refuse};
pub use read::{KINDS, Kind, Loaded, inspect, inspect_bytes, read};
pub use splineway::gcode::{Code, Dialect, Setup};
pub use tape::{Overriding, Reel, Summary, Tape};
pub use tool_path::{Aside, Attended, Course, Header, Move, Program, ReadOptions, Speed};
