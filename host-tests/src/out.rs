//! Standard output that may end: a full disk behind it is an error with a message, not a panic.

use anyhow::{Result, anyhow};
use std::fmt::Arguments;
use std::io::{Error, Write};
use std::sync::OnceLock;

static FAILURE: OnceLock<Error> = OnceLock::new();

fn note(outcome: std::io::Result<()>) {
    if let Err(error) = outcome {
        // The first one is told.
        let _ = FAILURE.set(error);
    }
}

/// Prints a line; what goes wrong is noted for [`finish`], and nothing more is printed.
pub fn line(text: Arguments<'_>) {
    if FAILURE.get().is_none() {
        let mut out = std::io::stdout().lock();
        note(out.write_fmt(text).and_then(|()| out.write_all(b"\n")));
    }
}

/// Whether everything that was printed has arrived.
///
/// # Errors
/// It has not.
pub fn finish() -> Result<()> {
    note(std::io::stdout().flush());
    match FAILURE.get() {
        Some(error) => Err(anyhow!("cannot write to standard output: {error}")),
        None => Ok(()),
    }
}
