//! G-code files: encodings, line ends, dialects, and subprograms, around the reader of the core
//! ([`splineway::gcode`]), which knows what the codes mean.

mod guess;
mod run;
mod text;

pub use guess::{Guess, guess};
pub(super) use run::{Run, go_through};
pub use text::{Place, lines, plain};

use super::{Finding, Program, ReadOptions, refuse};
use anyhow::Result;

/// Most moves of a list, with those of repeated subprograms and holes: some 3 GB.
const MOST_MOVES: usize = 10_000_000;

/// Reads a G-code file: what it does, and what there is to say of it. Where there is an error among the findings, the
/// program is what is left without those lines, and must not be run.
pub fn examine(bytes: &[u8], options: ReadOptions<'_>) -> (Program, Vec<Finding>) {
    examine_within(bytes, options, MOST_MOVES)
}

/// The same with at most so many moves; more are refused.
pub fn examine_within(
    bytes: &[u8],
    options: ReadOptions<'_>,
    most_moves: usize,
) -> (Program, Vec<Finding>) {
    let mut moves = Vec::new();
    let (mut program, findings, _) = go_through(&plain(bytes), options, |step, run| {
        if moves.len() == most_moves {
            run.stop(format!("more than {most_moves} moves with all subprograms and holes"));
        } else {
            moves.push(step);
        }
    });
    program.moves = moves;
    (program, findings)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A line may ask for 300 million pecks, and a subprogram for more: what does not fit is said, and not tried.
    #[test]
    fn programs_that_fill_the_memory_are_refused() {
        for (text, line) in [
            ("G91 G83 X1 Z-10 R1 Q0.0011 L9999 F600", 1),
            ("M98 P1 L9999\nM30\nO1\nM98 P2 L9999\nM99\nO2\nG91 G0 X1\nX-1\nM99", 7),
        ] {
            let (program, findings) = examine_within(text.as_bytes(), ReadOptions::DEFAULT, 1000);
            assert_eq!((program.moves.len(), findings.len()), (1000, 1));
            assert_eq!(findings[0].line, line);
            assert!(findings[0].message.contains("more than 1000 moves"), "{findings:?}");
        }
    }
}
