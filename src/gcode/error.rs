//! Why a line is refused, and what is only worth a remark.

use super::{Code, LETTERS, WORDS};
use crate::block::BlockError;
use crate::number::Coord;
use core::fmt;

/// Why a line is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Reason {
    /// A character that no word has.
    Character(char),
    /// A parameter (`#`), an expression (`[`), or an assignment.
    Parameter(char),
    /// A letter without a number.
    NoNumber(char),
    /// What stands behind a letter is no number.
    NotANumber(char),
    /// An `E` behind a number that may be an exponent or a word.
    Exponent(char),
    /// A number that is too large for any.
    Huge(char),
    /// A comment that is not closed.
    CommentOpen,
    /// A comment in a comment: which bracket closes which cannot be told.
    CommentNested,
    /// The sum behind `*` is not that of the line.
    Checksum {
        /// The sum that is written.
        written: u32,
        /// The line's.
        found: u8,
    },
    /// `/` or `%` in the wrong place, or `/` with a number.
    Mark(char),
    /// More words in a line than a reader holds.
    TooManyWords,
    /// N stands behind other words.
    LineNumber,
    /// A second word of a letter.
    Repeated(char),
    /// `O` with a name or with more behind it: control flow of LinuxCNC.
    ControlFlow,
    /// A G or M code that is not known.
    Unknown(Code),
    /// A code that is known and cannot be done.
    Unsupported {
        /// Which.
        code: Code,
        /// What it asks for.
        what: &'static str,
        /// Whether it cannot change where the tool goes.
        harmless: bool,
    },
    /// Two codes of one group, or the same twice.
    Group(Code, Code),
    /// Two codes that ask for the same words.
    Both(Code, Code),
    /// A word that no code of the line takes.
    Unused(char),
    /// A word that is missing.
    Missing {
        /// The code that asks for it.
        code: Code,
        /// What it asks for.
        what: &'static str,
    },
    /// A code where it cannot be.
    Context {
        /// Which.
        code: Code,
        /// What it needs, or does not go with.
        what: &'static str,
    },
    /// A word whose number is beyond its range, or not whole where it must be.
    Range {
        /// Its letter.
        letter: char,
        /// Its number.
        value: f64,
        /// Least number accepted.
        least: f64,
        /// Greatest number accepted.
        greatest: f64,
        /// Whether it must be a whole number.
        whole: bool,
    },
    /// An axis would go beyond the range of coordinates.
    Coordinate {
        /// Index of the axis.
        axis: usize,
        /// Where it would go, mm.
        value: f64,
    },
    /// The centre of an arc lies beyond the range of coordinates.
    Centre {
        /// Index of the axis.
        axis: usize,
    },
    /// Too few or too many control points of a NURBS block.
    ControlPoints {
        /// How many there are, or would be.
        found: u32,
        /// Its order.
        least: u32,
        /// What a reader has room for.
        greatest: u32,
    },
    /// An arc that does not exist.
    Arc(BlockError),
    /// Axis words with no motion code in force.
    NoMotion,
    /// A work offset that nobody has set.
    NoOffset(Code),
    /// An axis that the machine has not.
    NoAxis(char),
    /// A tool that the table has not.
    NoTool(u32),
    /// The actions of the line before have not been taken yet.
    Busy,
}

/// A line that is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Refusal {
    /// Column of the word to blame, from 1, in bytes.
    pub column: u32,
    /// Why.
    pub reason: Reason,
}

impl Refusal {
    pub(super) const fn new(column: u32, reason: Reason) -> Self {
        Self { column, reason }
    }

    /// Whether what is refused cannot change where the tool goes, so that it may be left out.
    pub const fn is_harmless(&self) -> bool {
        match self.reason {
            Reason::Unsupported { harmless, .. } => harmless,
            Reason::Unused(letter) => letter == 'E',
            _ => false,
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Character(c) => write!(f, "unexpected character {c:?}"),
            Self::Parameter(c) => {
                write!(f, "parameters and expressions (\"{c}\") are not supported")
            }
            Self::NoNumber(letter) => write!(f, "no number behind \"{letter}\""),
            Self::NotANumber(letter) => {
                write!(f, "what stands behind \"{letter}\" is not a number")
            }
            Self::Exponent(letter) => write!(
                f,
                "the E behind the number of \"{letter}\" may be an exponent or a word: write 0.00001 or a space before E"
            ),
            Self::Huge(letter) => write!(f, "the number behind \"{letter}\" is too large"),
            Self::CommentOpen => f.write_str("the comment is not closed"),
            Self::CommentNested => f.write_str("a comment in a comment"),
            Self::Checksum { written, found } => {
                write!(f, "the sum behind \"*\" is {written}, that of the line is {found}")
            }
            Self::Mark('%') => f.write_str("\"%\" must stand alone in its line"),
            Self::Mark(c) => write!(f, "\"{c}\" must be the first in its line, without a number"),
            Self::TooManyWords => write!(f, "more than {WORDS} words in a line"),
            Self::LineNumber => f.write_str("N must be the first word of its line"),
            Self::Repeated(letter) => write!(f, "a second {letter} word"),
            Self::ControlFlow => f.write_str(
                "O words with names or keywords (sub, call, if, while) are not supported",
            ),
            Self::Unknown(code) => write!(f, "{code} is not known"),
            Self::Unsupported { code, what, .. } => write!(f, "{code} ({what}) is not supported"),
            Self::Group(first, second) if first == second => write!(f, "{first} twice in a line"),
            Self::Group(first, second) => {
                write!(f, "{first} and {second} exclude each other in a line")
            }
            Self::Both(first, second) => write!(f, "{first} and {second} both take this word"),
            Self::Unused(letter) => write!(f, "no code of this line takes the word {letter}"),
            Self::Missing { code, what } => write!(f, "{code} needs {what}"),
            Self::Context { code, what } => write!(f, "{code} {what}"),
            Self::Range { letter, value, least, greatest, whole } => {
                write!(f, "{letter}{value}: it must be ")?;
                if least >= greatest {
                    return write!(f, "{least}");
                }
                let kind = if whole { "a whole number from" } else { "from" };
                write!(f, "{kind} {least} to {greatest}")?;
                // Numbers of codes.
                let is_code = matches!(letter, 'G' | 'M');
                f.write_str(if is_code { ", with at most one decimal" } else { "" })
            }
            Self::Coordinate { axis, value } => {
                let letter = LETTERS.get(axis).copied().unwrap_or('?');
                let limit = Coord::LIMIT_MM;
                write!(f, "{letter} would go to {value} mm; coordinates must be within +-{limit}")
            }
            Self::Centre { axis } => {
                let letter = LETTERS.get(axis).copied().unwrap_or('?');
                let limit = Coord::LIMIT_MM;
                write!(f, "the arc's centre would lie beyond +-{limit} mm of {letter}")
            }
            Self::ControlPoints { found, least, greatest } => {
                write!(
                    f,
                    "{found} control points of a NURBS block; it must have {least} to {greatest}"
                )
            }
            Self::Arc(error) => write!(f, "{error}"),
            Self::NoMotion => {
                f.write_str("axis words without a motion code (G0, G1, G2, G3) in force")
            }
            Self::NoOffset(code) => {
                write!(f, "{code} has not been set: by G10 L2, or in the machine description")
            }
            Self::NoAxis(letter) => write!(f, "the machine has no axis {letter}"),
            Self::NoTool(number) => write!(f, "the tool table has no length of tool {number}"),
            Self::Busy => f.write_str("the line before has not been done yet"),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {}: {}", self.column, self.reason)
    }
}

impl core::error::Error for Refusal {}

/// What is worth a remark; where the tool goes is not touched by it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Note {
    /// A code of printers that was left out with its words.
    Skipped(Code),
    /// M220 of printers with another share than 100 %: it is handed on, and feeds are read as they are written.
    FeedShare(f64),
    /// E words are left out: there is no extruder.
    Extruder,
    /// A move at the feed of the settings, for want of an F word.
    NoFeed(f64),
    /// A line with a `/` was run.
    Optional,
    /// A dwell of minutes, in a dialect where others mean milliseconds.
    LongDwell(f64),
    /// What was refused and left out because the settings are lenient.
    LeftOut(Reason),
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Skipped(code) => write!(f, "{code} is of a printer and is left out"),
            Self::FeedShare(percent) => {
                write!(f, "M220 S{percent} is handed on; feeds are read as they are written")
            }
            Self::Extruder => f.write_str("E words (extruder) are left out"),
            Self::NoFeed(feed) => write!(f, "no F word in force; moves run at {feed} mm/s"),
            Self::Optional => {
                f.write_str("lines with \"/\" are run (--block-delete leaves them out)")
            }
            Self::LongDwell(seconds) => {
                write!(
                    f,
                    "G4 P is in seconds: this dwell takes {seconds} s (--dialect marlin has milliseconds)"
                )
            }
            Self::LeftOut(reason) => write!(f, "{reason}; left out"),
        }
    }
}
