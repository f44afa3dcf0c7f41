//! G-code, one line in, actions out (feature `gcode`): the same reader on the host and on the board.

mod event;

pub use event::{Code, Event};
