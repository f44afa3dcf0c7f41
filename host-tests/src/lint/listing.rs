//! The lines of a file by their numbers, without a list of them.

use splineway_simulator::program::gcode::Place;
use std::borrow::Cow;

/// A text whose lines are asked for, mostly in order.
#[derive(Clone, Debug)]
pub struct Listing<'a> {
    bytes: &'a [u8],
    at: Place,
}

impl<'a> Listing<'a> {
    /// Of a text in an encoding that has ASCII for its codes; nothing if the file has no lines to speak of.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: Place::default() }
    }

    /// A line by its number, from 1; empty if there is none. Lines in order cost a pass over the text.
    pub fn line(&mut self, number: u32) -> Cow<'a, str> {
        if (number as usize) <= self.at.lines {
            self.at = Place::default();
        }
        while let Some((line, next)) = self.at.line(self.bytes) {
            self.at = next;
            if next.lines == number as usize {
                return String::from_utf8_lossy(line);
            }
        }
        Cow::Borrowed("")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_found_in_any_order() {
        let mut listing = Listing::new(b"a\r\nb\n\nd");
        for (number, text) in
            [(2, "b"), (4, "d"), (1, "a"), (1, "a"), (3, ""), (5, ""), (0, ""), (4, "d")]
        {
            assert_eq!(listing.line(number), text, "{number}");
        }
    }
}
