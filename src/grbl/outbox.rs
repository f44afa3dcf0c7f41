//! What is said, and has not been sent.

use crate::number::Coord;
use heapless::Deque;

/// Longest line: a report over nine axes with every number at its longest takes 340.
pub const LONGEST: usize = 384;
const ROOM: usize = 2 * LONGEST;

/// Millimetres of an inch.
pub const INCH: f64 = 25.4;

/// Text on its way to the line. Numbers are written without `core::fmt`, which can panic.
#[derive(Debug, Default)]
pub struct Outbox {
    bytes: Deque<u8, ROOM>,
}

impl Outbox {
    /// Whether another line has room, however long.
    pub fn has_room(&self) -> bool {
        ROOM - self.bytes.len() >= LONGEST
    }

    /// The next byte to be sent.
    pub fn peek(&self) -> Option<u8> {
        self.bytes.front().copied()
    }

    /// It has been sent.
    pub fn sent(&mut self) {
        self.bytes.pop_front();
    }

    pub fn byte(&mut self, byte: u8) -> &mut Self {
        // Lines are only begun where the longest has room.
        let _ = self.bytes.push_back(byte);
        self
    }

    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        for &byte in bytes {
            self.byte(byte);
        }
        self
    }

    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    /// The end of a line.
    pub fn end(&mut self) {
        self.text("\r\n");
    }

    /// A line.
    pub fn line(&mut self, text: &str) {
        self.text(text).end();
    }

    pub fn whole(&mut self, number: u32) -> &mut Self {
        self.scaled(i64::from(number), 0)
    }

    /// A number that is so many powers of ten too large, with so many decimals.
    fn scaled(&mut self, number: i64, decimals: usize) -> &mut Self {
        if number < 0 {
            self.byte(b'-');
        }
        let mut digits = [b'0'; 20];
        let mut left = number.unsigned_abs();
        let mut count = 0;
        for (i, slot) in digits.iter_mut().enumerate() {
            if left == 0 && i > decimals {
                break;
            }
            *slot = b'0' + (left % 10) as u8;
            left /= 10;
            count = i + 1;
        }
        for (i, &digit) in digits.iter().enumerate().take(count).rev() {
            self.byte(digit);
            if i == decimals && decimals > 0 {
                self.byte(b'.');
            }
        }
        self
    }

    /// A number, rounded to so many decimals, 3 at most.
    pub fn number(&mut self, number: f64, decimals: usize) -> &mut Self {
        let scale = match decimals {
            0 => 1.0,
            1 => 10.0,
            2 => 100.0,
            3 => 1.0e3,
            _ => 1.0e4,
        };
        self.scaled(libm::round(number * scale) as i64, decimals.min(4))
    }

    /// A coordinate: mm with 3 decimals, or inches with 4; degrees are never inches.
    pub fn coordinate(&mut self, coord: Coord, inches: bool) -> &mut Self {
        if inches {
            return self.number(coord.to_mm() / INCH, 4);
        }
        let nm = coord.to_nm();
        let half = if nm < 0 { -500 } else { 500 };
        self.scaled((nm + half) / 1000, 3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;

    fn said(say: impl Fn(&mut Outbox)) -> String {
        let mut outbox = Outbox::default();
        say(&mut outbox);
        let mut text = String::new();
        while let Some(byte) = outbox.peek() {
            text.push(char::from(byte));
            outbox.sent();
        }
        text
    }

    #[test]
    fn numbers_are_rounded_to_their_decimals() {
        for (number, decimals, text) in [
            (0.0, 3, "0.000"),
            (0.01, 3, "0.010"),
            (-0.0006, 3, "-0.001"),
            (-12.3456, 3, "-12.346"),
            (50_000.0, 3, "50000.000"),
            (1.0e18, 0, "1000000000000000000"),
            (7.96, 1, "8.0"),
            (99.6, 0, "100"),
        ] {
            assert_eq!(said(|out| _ = out.number(number, decimals)), text);
        }
        assert_eq!(said(|out| _ = out.whole(u32::MAX)), "4294967295");
    }

    #[test]
    fn coordinates_are_in_millimetres_or_inches() {
        let at = |mm: f64| Coord::from_mm(mm).unwrap();
        for (mm, millimetres, inches) in [
            (0.0, "0.000", "0.0000"),
            (-0.0004, "0.000", "0.0000"),
            (25.4, "25.400", "1.0000"),
            (-1.0e6, "-1000000.000", "-39370.0787"),
            (0.0005, "0.001", "0.0000"),
        ] {
            assert_eq!(said(|out| _ = out.coordinate(at(mm), false)), millimetres);
            assert_eq!(said(|out| _ = out.coordinate(at(mm), true)), inches);
        }
    }
}
