//! Bytes that are obeyed at once, wherever they stand.

/// How an override is changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// To 100 per cent.
    Back,
    /// By so many per cent.
    By(i16),
}

/// Least and greatest override that a sender can ask for, per cent.
const RANGE: (u16, u16) = (10, 200);

impl Change {
    /// An override after it.
    pub fn of(self, percent: u16) -> u16 {
        match self {
            Self::Back => 100,
            Self::By(by) => percent.saturating_add_signed(by).clamp(RANGE.0, RANGE.1),
        }
    }
}

/// A command of one byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Realtime {
    /// `?`
    Status,
    /// `~`
    Start,
    /// `!`
    Hold,
    /// 0x18
    Reset,
    /// 0x84
    Door,
    /// 0x85
    CancelJog,
    /// 0x90 to 0x94
    Feed(Change),
    /// 0x95 to 0x97, per cent
    Rapid(u16),
    /// 0x99 to 0x9D
    Spindle(Change),
    /// 0x9E
    SpindleStop,
    /// 0xA0
    Flood,
    /// 0xA1
    Mist,
    /// Any other byte above those of ASCII: it is no part of a line.
    Other,
}

/// The command that a byte is; `None` if it is a part of a line.
pub const fn command(byte: u8) -> Option<Realtime> {
    Some(match byte {
        b'?' => Realtime::Status,
        b'~' => Realtime::Start,
        b'!' => Realtime::Hold,
        0x18 => Realtime::Reset,
        0x84 => Realtime::Door,
        0x85 => Realtime::CancelJog,
        0x90 => Realtime::Feed(Change::Back),
        0x91 => Realtime::Feed(Change::By(10)),
        0x92 => Realtime::Feed(Change::By(-10)),
        0x93 => Realtime::Feed(Change::By(1)),
        0x94 => Realtime::Feed(Change::By(-1)),
        0x95 => Realtime::Rapid(100),
        0x96 => Realtime::Rapid(50),
        0x97 => Realtime::Rapid(25),
        0x99 => Realtime::Spindle(Change::Back),
        0x9A => Realtime::Spindle(Change::By(10)),
        0x9B => Realtime::Spindle(Change::By(-10)),
        0x9C => Realtime::Spindle(Change::By(1)),
        0x9D => Realtime::Spindle(Change::By(-1)),
        0x9E => Realtime::SpindleStop,
        0xA0 => Realtime::Flood,
        0xA1 => Realtime::Mist,
        0x80.. => Realtime::Other,
        _ => return None,
    })
}

/// Letters beyond ASCII come as several bytes (UTF-8), and some of those behind the first are commands too. Counts them, so that a
/// comment changes no override.
#[derive(Clone, Copy, Debug, Default)]
pub struct Letters {
    left: u8,
}

impl Letters {
    /// Whether a byte goes on with a letter. What stops the machine is always obeyed: 0x84 and 0x85 are never a part of one.
    pub const fn goes_on(&mut self, byte: u8) -> bool {
        let goes_on = self.left > 0 && matches!(byte, 0x80..=0xBF);
        self.left = match byte {
            _ if goes_on => self.left - 1,
            0xC2..=0xDF => 1,
            0xE0..=0xEF => 2,
            0xF0..=0xF4 => 3,
            _ => 0,
        };
        goes_on && !matches!(byte, 0x84 | 0x85)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_ascii_are_parts_of_lines_but_for_four() {
        let commands: std::vec::Vec<u8> =
            (0..0x80).filter(|&byte| command(byte).is_some()).collect();
        assert_eq!(commands, [0x18, b'!', b'?', b'~']);
        assert!((0x80..=0xFF).all(|byte| command(byte).is_some()));
    }

    #[test]
    fn overrides_stay_in_their_range() {
        assert_eq!(Change::By(-10).of(12), 10);
        assert_eq!(Change::By(10).of(195), 200);
        assert_eq!((Change::By(1).of(100), Change::Back.of(37)), (101, 100));
    }

    /// A hyphen that does not break is E2 80 91, and 0x91 raises the feed.
    #[test]
    fn letters_of_a_comment_are_no_overrides() {
        let mut letters = Letters::default();
        let mut obeyed = |text: &[u8]| {
            let other = |byte: &&u8| !letters.goes_on(**byte) && command(**byte).is_some();
            text.iter().filter(other).filter(|byte| **byte < 0xC0).count()
        };
        assert_eq!(obeyed("(non\u{2011}stop, 5 °, é)".as_bytes()), 0);
        assert_eq!(obeyed(&[0x91, 0x91]), 2);
        assert_eq!(obeyed(&[0xC3, 0x84, 0xC3, 0x85]), 2);
        assert_eq!(obeyed(&[0xC3, b'!', 0x91]), 2);
    }
}
