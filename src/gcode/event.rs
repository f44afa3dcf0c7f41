//! What a program asks of the machine besides motion.

use core::fmt;

/// A code: its letter and its number in tenths, so G61.1 is `G` and 611.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Code {
    /// G, M; S or T for a word that stands alone.
    pub letter: char,
    /// Ten times the number; 0 for S and T.
    pub tenths: u16,
}

impl Code {
    /// A G code by its number in tenths.
    pub const fn g(tenths: u16) -> Self {
        Self { letter: 'G', tenths }
    }

    /// An M code by its whole number, at most 6553.
    pub const fn m(number: u16) -> Self {
        Self { letter: 'M', tenths: number.saturating_mul(10) }
    }

    /// A word on its own.
    pub const fn word(letter: char) -> Self {
        Self { letter, tenths: 0 }
    }

    /// The spindle speed on its own.
    pub const SPEED: Self = Self::word('S');
    /// A tool's number on its own.
    pub const TOOL: Self = Self::word('T');
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.letter, self.tenths / 10, self.tenths % 10) {
            (letter @ ('G' | 'M'), whole, 0) => write!(f, "{letter}{whole}"),
            (letter @ ('G' | 'M'), whole, tenth) => write!(f, "{letter}{whole}.{tenth}"),
            (letter, ..) => write!(f, "{letter}"),
        }
    }
}

/// Something the machine does between two moves: spindle, coolant, tool, stop.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Event {
    /// Which.
    pub code: Code,
    /// Its number: S of M3 and M4 (rpm), T of M6, P or Q or S of others; of S and T their own.
    pub value: Option<f64>,
    /// Whether the machine waits there for the operator (M0, M1, M6, M60).
    pub pause: bool,
}

impl Event {
    /// Letter of the word that [`Event::value`] was read from.
    pub const fn word(&self) -> char {
        match (self.code.letter, self.code.tenths / 10) {
            ('M', 6) => 'T',
            ('M', 61) => 'Q',
            ('M', 19) => 'R',
            ('M', 50..=53 | 62..=65) => 'P',
            _ => 'S',
        }
    }
}

impl fmt::Display for Event {
    /// As a program has it: `M3 S1000`, `M6 T2`, `S500`, `M8`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.code.letter, self.value) {
            ('S' | 'T', Some(value)) => write!(f, "{}{value}", self.code),
            (_, Some(value)) => write!(f, "{} {}{value}", self.code, self.word()),
            (_, None) => write!(f, "{}", self.code),
        }
    }
}
