//! What an operator wants.

pub use splineway_simulator::run::{Command, parse_command};

/// From the operator's side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// For the machine.
    Command(Command),
    /// Abort, wait until the machine stands, and end: the operator is gone, or wants to be. A second one
    /// does not wait.
    Leave(&'static str),
    /// No command comes any more; the program is run to its end.
    NoMore,
}
