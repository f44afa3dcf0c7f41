//! The words of a line, and which code has taken them.

use super::error::{Reason, Refusal};
use super::groups::tenths;
use super::offsets::is_whole;
use super::{AXES, Code, LETTERS, WORDS};
use crate::machine::Quantity;
use heapless::Vec;

/// Longest dwell that a word may ask for, s.
pub const LONGEST_DWELL: f64 = Quantity::Dwell.range().greatest;

/// A letter, its number, and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Word {
    /// Capital letter.
    pub letter: u8,
    /// The number behind it; `None` where there is none.
    pub value: Option<f64>,
    /// Column of the letter, from 1.
    pub column: u32,
    /// The code that has taken it.
    pub taken: Option<Code>,
}

/// The words of a line.
#[derive(Clone, Debug, Default)]
pub struct Words {
    list: Vec<Word, WORDS>,
}

impl Words {
    pub const fn new() -> Self {
        Self { list: Vec::new() }
    }

    pub fn clear(&mut self) {
        self.list.clear();
    }

    /// A further word.
    pub fn push(&mut self, letter: u8, value: Option<f64>, column: u32) -> Result<(), Refusal> {
        let word = Word { letter, value, column, taken: None };
        self.list.push(word).map_err(|_| Refusal::new(column, Reason::TooManyWords))
    }

    pub fn list(&self) -> &[Word] {
        &self.list
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    fn find(&mut self, letter: char) -> Option<&mut Word> {
        self.list.iter_mut().find(|word| char::from(word.letter) == letter)
    }

    /// Whether a code is among them.
    pub fn names(&self, code: Code) -> bool {
        self.list.iter().any(|word| {
            char::from(word.letter) == code.letter
                && word.value.and_then(tenths) == Some(code.tenths)
        })
    }

    /// Whether there is a word of this letter.
    pub fn has(&self, letter: char) -> bool {
        self.list.iter().any(|word| char::from(word.letter) == letter)
    }

    /// Column of a letter's word; of the first word if it is not there.
    pub fn column(&self, letter: char) -> u32 {
        let word = self.list.iter().find(|word| char::from(word.letter) == letter);
        word.or(self.list.first()).map_or(1, |word| word.column)
    }

    /// The number of a letter for a code, which takes the word.
    pub fn take(&mut self, letter: char, by: Code) -> Result<Option<f64>, Refusal> {
        let Some(word) = self.find(letter) else { return Ok(None) };
        if let Some(other) = word.taken
            && other != by
        {
            return Err(Refusal::new(word.column, Reason::Both(other, by)));
        }
        word.taken = Some(by);
        match word.value {
            Some(value) => Ok(Some(value)),
            None => Err(Refusal::new(word.column, Reason::NoNumber(letter))),
        }
    }

    /// The same, of a number within a range.
    pub fn take_in(
        &mut self,
        letter: char,
        by: Code,
        (least, greatest): (f64, f64),
        whole: bool,
    ) -> Result<Option<f64>, Refusal> {
        let Some(value) = self.take(letter, by)? else { return Ok(None) };
        if value >= least && value <= greatest && (!whole || is_whole(value)) {
            return Ok(Some(value));
        }
        let column = self.column(letter);
        Err(Refusal::new(column, Reason::Range { letter, value, least, greatest, whole }))
    }

    /// The numbers of all axis words for a code, which takes them.
    pub fn take_axes(&mut self, by: Code) -> Result<[Option<f64>; AXES], Refusal> {
        let mut values = [None; AXES];
        for (value, letter) in values.iter_mut().zip(LETTERS) {
            *value = self.take(letter, by)?;
        }
        Ok(values)
    }

    /// Whether there are axis words.
    pub fn has_axes(&self) -> bool {
        self.list.iter().any(|word| LETTERS.contains(&char::from(word.letter)))
    }

    /// Column of the first axis word; of the first word if there is none.
    pub fn axis_column(&self) -> u32 {
        let word = self.list.iter().find(|word| LETTERS.contains(&char::from(word.letter)));
        word.or(self.list.first()).map_or(1, |word| word.column)
    }

    /// A refusal that blames the axis word it is about.
    pub fn blame(&self, reason: Reason) -> Refusal {
        let column = match reason {
            Reason::Coordinate { axis, .. } => {
                self.column(LETTERS.get(axis).copied().unwrap_or('X'))
            }
            Reason::NoAxis(letter) => self.column(letter),
            _ => self.axis_column(),
        };
        Refusal::new(column, reason)
    }

    /// A code takes whatever is there, with or without numbers.
    pub fn take_all(&mut self, by: Code) {
        for word in self.list.iter_mut().filter(|word| word.taken.is_none()) {
            word.taken = Some(by);
        }
    }

    /// A code takes the words of these letters, with or without numbers.
    pub fn take_bare(&mut self, letters: &[char], by: Code) {
        for word in &mut self.list {
            if word.taken.is_none() && letters.contains(&char::from(word.letter)) {
                word.taken = Some(by);
            }
        }
    }

    /// The first word that nobody has taken.
    pub fn left(&self) -> Option<&Word> {
        self.list.iter().find(|word| word.taken.is_none())
    }

    /// Takes a word by its place.
    pub fn mark(&mut self, at: usize, by: Code) {
        if let Some(word) = self.list.get_mut(at) {
            word.taken = Some(by);
        }
    }
}
