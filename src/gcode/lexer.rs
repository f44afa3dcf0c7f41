//! From the bytes of a line to words.
//!
//! A lexer of its own: the crate `gcode` (0.7) has one, but it reads numbers as `f32` (8 um off at 100 mm),
//! takes `X1e-05` for X1 and E-05, a carriage return for a space (two moves become one), lets comments run on over
//! line ends, and gives words to the code that stands before them, where a line of RS274 is one whole.
//!
//! # Exponents
//!
//! | as written, without a space | LinuxCNC, grbl | Marlin |
//! |---|---|---|
//! | `X1e-05`, `X1e+3` | exponent: so programs print numbers | exponent |
//! | `X1E-05`, `X1E+3`, `X1e5`, `x1e-3` | refused: an exponent, or X1 and E-05 | refused |
//! | `X1E5`, `X1E-0.5` | refused | X1 and a word of the extruder |
//!
//! A file of a printer that is not known for one must not send an axis to where E says.
//! The numbers of codes (G, M, T, N, O) have no exponents: G2E1 is not G20. With a space before it, E is a word. An E without digits behind it is none of these and is refused.

use super::Dialect;
use super::error::{Reason, Refusal};
use super::number::Decimal;
use super::words::Words;

/// What kind of line it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shape {
    /// `%`: begin or end of the program.
    pub percent: bool,
    /// `/`: it may be left out.
    pub deleted: bool,
}

/// The words of a line, without comments. One pass over its bytes.
pub fn split(text: &[u8], dialect: Dialect, words: &mut Words) -> Result<Shape, Refusal> {
    words.clear();
    let mut lexer = Lexer { text, at: 0, dialect };
    let mut shape = Shape::default();
    while let Some(byte) = lexer.skip_blanks() {
        let column = lexer.column();
        let refuse = |reason| Err(Refusal::new(column, reason));
        match byte {
            b';' => break,
            b'(' => lexer.comment()?,
            b'%' if words.is_empty() && shape == Shape::default() => {
                shape.percent = true;
                lexer.at += 1;
            }
            b'%' => return refuse(Reason::Mark('%')),
            b'/' => {
                lexer.at += 1;
                let number = lexer.peek().is_some_and(|byte| byte.is_ascii_digit());
                if !words.is_empty() || shape != Shape::default() || number {
                    return refuse(Reason::Mark('/'));
                }
                shape.deleted = true;
            }
            b'*' => {
                lexer.checksum()?;
                break;
            }
            letter if letter.is_ascii_alphabetic() => {
                if shape.percent {
                    return refuse(Reason::Mark('%'));
                }
                if lexer.word(letter, words)? {
                    break;
                }
            }
            b'#' | b'[' | b']' | b'=' | b'<' => return refuse(Reason::Parameter(char::from(byte))),
            _ => return refuse(Reason::Character(lexer.character())),
        }
    }
    Ok(shape)
}

struct Lexer<'a> {
    text: &'a [u8],
    at: usize,
    dialect: Dialect,
}

impl Lexer<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn column(&self) -> u32 {
        self.at as u32 + 1
    }

    /// The first byte that is no blank.
    fn skip_blanks(&mut self) -> Option<u8> {
        while let Some(byte) = self.peek() {
            // A carriage return ends a line elsewhere: two moves must not become one.
            let ends = byte == b'\r' && self.at + 1 == self.text.len();
            if !(matches!(byte, b' ' | b'\t') || ends) {
                return Some(byte);
            }
            self.at += 1;
        }
        None
    }

    /// The character at hand, for a message.
    fn character(&self) -> char {
        let rest = self.text.get(self.at..).unwrap_or(&[]);
        let head = rest.get(..rest.len().min(4)).unwrap_or(&[]);
        let valid = match core::str::from_utf8(head) {
            Ok(text) => text,
            Err(error) => {
                let head = head.get(..error.valid_up_to()).unwrap_or(&[]);
                core::str::from_utf8(head).unwrap_or("")
            }
        };
        valid.chars().next().unwrap_or(char::REPLACEMENT_CHARACTER)
    }

    fn comment(&mut self) -> Result<(), Refusal> {
        let column = self.column();
        self.at += 1;
        while let Some(byte) = self.peek() {
            match byte {
                b')' => {
                    self.at += 1;
                    return Ok(());
                }
                b'(' => return Err(Refusal::new(self.column(), Reason::CommentNested)),
                _ => self.at += 1,
            }
        }
        Err(Refusal::new(column, Reason::CommentOpen))
    }

    /// The sum of a line of a serial protocol: its bytes, each exclusive-or'ed to the others.
    fn checksum(&mut self) -> Result<(), Refusal> {
        let column = self.column();
        let sum = self.text.get(..self.at).unwrap_or(&[]).iter().fold(0, |sum, byte| sum ^ byte);
        self.at += 1;
        let mut written = 0u32;
        let mut digits = false;
        self.skip_blanks();
        while let Some(digit @ b'0'..=b'9') = self.peek() {
            written = written.saturating_mul(10).saturating_add(u32::from(digit - b'0'));
            digits = true;
            self.at += 1;
        }
        match self.skip_blanks() {
            None | Some(b';') if digits && written == u32::from(sum) => Ok(()),
            None | Some(b';') if digits => {
                Err(Refusal::new(column, Reason::Checksum { written, found: sum }))
            }
            _ => Err(Refusal::new(column, Reason::Character('*'))),
        }
    }

    /// A letter and what stands behind it; whether the rest of the line is text.
    fn word(&mut self, byte: u8, words: &mut Words) -> Result<bool, Refusal> {
        let column = self.column();
        let capital = byte.to_ascii_uppercase();
        let letter = char::from(capital);
        let refuse = |reason| Err(Refusal::new(column, reason));
        self.at += 1;
        let behind = self.at;
        let mut value = None;
        match self.skip_blanks() {
            Some(b'0'..=b'9' | b'.' | b'+' | b'-') => {
                let number = self.number(byte, column)?;
                if !number.is_finite() {
                    return refuse(Reason::Huge(letter));
                }
                value = Some(number);
            }
            Some(b'"') if self.dialect == Dialect::Marlin => self.string(column)?,
            Some(c @ (b'#' | b'[' | b'=')) => return refuse(Reason::Parameter(char::from(c))),
            Some(b'<') if letter == 'O' => return refuse(Reason::ControlFlow),
            // A name or a word of a language.
            Some(next) if next.is_ascii_alphabetic() && self.at == behind => {
                return refuse(if letter == 'O' {
                    Reason::ControlFlow
                } else {
                    Reason::NoNumber(letter)
                });
            }
            // What stands there is looked at in its turn, from where it stands.
            _ => self.at = behind,
        }
        if letter == 'O' && self.peek_word().is_some() {
            return refuse(Reason::ControlFlow);
        }
        if !matches!(letter, 'G' | 'M') && words.has(letter) {
            return refuse(Reason::Repeated(letter));
        }
        if letter == 'N' && !words.is_empty() {
            return refuse(Reason::LineNumber);
        }
        words.push(capital, value, column)?;
        let tenths = value.map_or(0.0, |value| value * 10.0);
        let text = (0.0..60_000.0).contains(&tenths) && self.dialect.takes_text(tenths as u16);
        Ok(letter == 'M' && value.is_some() && text)
    }

    /// The letter of the word that follows.
    fn peek_word(&mut self) -> Option<u8> {
        let at = self.at;
        let found = self.skip_blanks().filter(u8::is_ascii_alphabetic);
        self.at = at;
        found
    }

    /// A text in quotes, which is left out.
    fn string(&mut self, column: u32) -> Result<(), Refusal> {
        self.at += 1;
        while let Some(byte) = self.peek() {
            self.at += 1;
            if byte == b'"' {
                return Ok(());
            }
        }
        Err(Refusal::new(column, Reason::CommentOpen))
    }

    fn number(&mut self, byte: u8, column: u32) -> Result<f64, Refusal> {
        let letter = char::from(byte.to_ascii_uppercase());
        let mut number = Decimal::default();
        if let Some(sign @ (b'+' | b'-')) = self.peek() {
            number.negative = sign == b'-';
            self.at += 1;
        }
        while let Some(byte) = self.peek() {
            match byte {
                b'0'..=b'9' => number.digit(byte - b'0'),
                b'.' if !number.point => number.point = true,
                b'.' | b'+' | b'-' | b',' => {
                    return Err(Refusal::new(column, Reason::NotANumber(letter)));
                }
                _ => break,
            }
            self.at += 1;
        }
        if !number.digits {
            return Err(Refusal::new(column, Reason::NotANumber(letter)));
        }
        self.exponent(&mut number, byte, column)?;
        Ok(number.value())
    }

    /// Whether the digits from a place on have a point among them, which no exponent has.
    fn has_point(&self, at: usize) -> bool {
        let rest = self.text.get(at..).unwrap_or(&[]);
        rest.iter().find(|byte| !byte.is_ascii_digit()) == Some(&b'.')
    }

    /// The exponent behind a number, as the table at the top has it.
    fn exponent(&mut self, number: &mut Decimal, byte: u8, column: u32) -> Result<(), Refusal> {
        let letter = char::from(byte.to_ascii_uppercase());
        let Some(e @ (b'e' | b'E')) = self.peek() else { return Ok(()) };
        if matches!(letter, 'G' | 'M' | 'T' | 'N' | 'O') {
            return Ok(());
        }
        let signed = matches!(self.text.get(self.at + 1), Some(b'+' | b'-'));
        let first = self.text.get(self.at + 1 + usize::from(signed)).copied();
        let is_digit = first.is_some_and(|byte| byte.is_ascii_digit());
        let extruder = self.dialect == Dialect::Marlin && e == b'E';
        if extruder && (!signed || self.has_point(self.at + 2)) {
            return Ok(());
        }
        if !(e == b'e' && signed && is_digit && byte.is_ascii_uppercase()) {
            return Err(Refusal::new(column, Reason::Exponent(letter)));
        }
        let negative = self.text.get(self.at + 1) == Some(&b'-');
        self.at += 1 + usize::from(signed);
        let mut exponent = 0i32;
        while let Some(digit @ b'0'..=b'9') = self.peek() {
            exponent = exponent.saturating_mul(10).saturating_add(i32::from(digit - b'0'));
            self.at += 1;
        }
        if let Some(b'.' | b'+' | b'-' | b',') = self.peek() {
            return Err(Refusal::new(column, Reason::NotANumber(letter)));
        }
        number.shift(if negative { exponent.saturating_neg() } else { exponent });
        Ok(())
    }
}
