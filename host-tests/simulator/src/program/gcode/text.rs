//! From the bytes of a file to lines.

use std::borrow::Cow;

/// What stands at the end of files of old systems.
const END_OF_FILE: u8 = 0x1a;

/// The bytes without a byte order mark, in an encoding that has ASCII for its codes. (Comments may be in any.)
pub fn plain(bytes: &[u8]) -> Cow<'_, [u8]> {
    let wide = |order: fn([u8; 2]) -> u16| {
        let units = bytes[2..].chunks_exact(2).map(|pair| order([pair[0], pair[1]]));
        // Half a character at the end is one that is not known, and refused as such.
        let half = (bytes.len() % 2 == 1).then_some(Ok(char::REPLACEMENT_CHARACTER));
        let text: String = char::decode_utf16(units)
            .chain(half)
            .map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect();
        Cow::Owned(text.into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => Cow::Borrowed(trimmed(rest)),
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ => Cow::Borrowed(trimmed(bytes)),
    }
}

fn trimmed(bytes: &[u8]) -> &[u8] {
    bytes.strip_suffix(&[END_OF_FILE]).unwrap_or(bytes)
}

/// Where in a text a line begins, and how many are before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Bytes before it.
    pub offset: usize,
    /// Lines before it.
    pub lines: usize,
}

impl Place {
    /// The line that begins here, whatever ends it - line feed, carriage return, or both -, and the place behind it.
    pub fn line(self, bytes: &[u8]) -> Option<(&[u8], Self)> {
        let rest = bytes.get(self.offset..).filter(|rest| !rest.is_empty())?;
        let lines = self.lines + 1;
        let Some(at) = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r') else {
            return Some((rest, Self { offset: bytes.len(), lines }));
        };
        let both = rest[at] == b'\r' && rest.get(at + 1) == Some(&b'\n');
        Some((&rest[..at], Self { offset: self.offset + at + 1 + usize::from(both), lines }))
    }
}

/// The lines of a text.
pub fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut place = Place::default();
    std::iter::from_fn(move || {
        let (line, next) = place.line(bytes)?;
        place = next;
        Some(line)
    })
}

/// A column in bytes as one in characters, as editors count.
pub fn column(line: &[u8], bytes: u32) -> u32 {
    let before = line.iter().take(bytes.saturating_sub(1) as usize);
    before.filter(|&&byte| byte & 0xc0 != 0x80).count() as u32 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_end_counts_once() {
        let all: Vec<&[u8]> = lines(b"a\nb\r\nc\rd\n\ne").collect();
        assert_eq!(all, [&b"a"[..], b"b", b"c", b"d", b"", b"e"]);
        assert_eq!(lines(b"").count(), 0);
    }

    #[test]
    fn marks_and_wide_characters_are_taken_off() {
        assert_eq!(plain(b"\xef\xbb\xbfG0"), &b"G0"[..]);
        assert_eq!(plain(b"\xff\xfeG\x000\x00"), &b"G0"[..]);
        assert_eq!(plain(b"\xfe\xff\x00G\x000"), &b"G0"[..]);
        assert_eq!(plain(b"\xff\xfeG\x000"), "G\u{fffd}".as_bytes());
        assert_eq!(plain(b"G0\n\x1a"), &b"G0\n"[..]);
        assert_eq!(column("(\u{e4}) G".as_bytes(), 6), 5);
    }
}
