//! G-code files: encodings, line ends, dialects, and subprograms, around the reader of the core
//! ([`splineway::gcode`]), which knows what the codes mean.

mod guess;
mod run;
mod text;

pub use guess::{Guess, guess};
pub use run::{examine, examine_within};

use super::{Program, ReadOptions, refuse};
use anyhow::Result;

/// The lines of a file, as they are counted.
pub fn lines(bytes: &[u8]) -> Vec<String> {
    let bytes = text::plain(bytes);
    text::lines(&bytes).iter().map(|line| String::from_utf8_lossy(line).into_owned()).collect()
}

/// Reads a G-code program. Moves before any F word run at `feed` mm/s.
///
/// # Errors
/// Names line, column and reason, of the first places that are refused.
pub fn parse(text: &str, feed: f64) -> Result<Program> {
    parse_with(text, ReadOptions { feed, ..ReadOptions::DEFAULT })
}

/// Reads a G-code program for a machine that stands at `options.start`.
///
/// # Errors
/// As [`parse`].
pub fn parse_with(text: &str, options: ReadOptions<'_>) -> Result<Program> {
    let (program, findings) = examine(text.as_bytes(), options);
    refuse(&findings)?;
    Ok(program)
}
