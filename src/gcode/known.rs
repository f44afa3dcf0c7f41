//! What the reader makes of a code, for lists of what it reads: asked of the very tables that it reads by.

use super::Code;
use super::dialect::{Dialect, Refused, Use};
use super::groups::group;

/// What the reader makes of a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Known {
    /// It is carried out, or handed on as an event.
    Read,
    /// It does not concern the path: left out with the words of its line.
    LeftOut,
    /// It is refused by name.
    Refused {
        /// What it would ask for.
        what: &'static str,
        /// Whether it cannot change where the tool goes: lenient settings leave it out.
        harmless: bool,
    },
    /// It is refused as unknown.
    Unknown,
}

impl Dialect {
    /// What the reader makes of a G or M code, which may still be refused for its words or for the codes beside it.
    /// Features that the reader is built without count. Cost: a table.
    pub fn knows(self, code: Code) -> Known {
        let refused = |Refused { what, harmless }| Known::Refused { what, harmless };
        match code.letter {
            'G' => match group(code.tenths, self) {
                Some(Ok(_)) => Known::Read,
                Some(Err(reason)) => refused(reason),
                None => Known::Unknown,
            },
            'M' => match self.m_code(code) {
                Some(Ok(Use::Skip)) => Known::LeftOut,
                Some(Ok(_)) => Known::Read,
                Some(Err(reason)) => refused(reason),
                None => Known::Unknown,
            },
            _ => Known::Unknown,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{AXES, Reader, Settings};
    use super::*;

    /// A code that is known is never refused as unknown, and the other way round, in every dialect.
    #[test]
    fn the_reader_reads_by_the_same_table() {
        for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Marlin] {
            let settings = Settings {
                dialect,
                axes: [true; AXES],
                // Without them the reader refuses what it could read.
                #[cfg(feature = "outputs")]
                switches: true,
                ..Settings::default()
            };
            for (letter, tenths) in
                ['G', 'M'].into_iter().flat_map(|letter| (0..10_010).map(move |n| (letter, n)))
            {
                let code = Code { letter, tenths };
                let mut text = [0u8; 8];
                let (whole, tenth) = (tenths / 10, tenths % 10);
                let digits = [whole / 1000, whole / 100 % 10, whole / 10 % 10, whole % 10];
                text[0] = letter as u8;
                for (slot, digit) in text[1..5].iter_mut().zip(digits) {
                    *slot = b'0' + digit as u8;
                }
                (text[5], text[6]) = (b'.', b'0' + tenth as u8);
                let outcome = Reader::new(&settings).line(1, &text[..7]);
                let reason = outcome.err().map(|refusal| refusal.reason);
                let unknown = matches!(reason, Some(super::super::Reason::Unknown(_)));
                let unsupported = matches!(reason, Some(super::super::Reason::Unsupported { .. }));
                let known = dialect.knows(code);
                // M92 of printers is harmless for the extruder alone.
                if dialect == Dialect::Marlin && code == Code::m(92) {
                    continue;
                }
                assert_eq!(unknown, known == Known::Unknown, "{code}: {reason:?}");
                let refused = matches!(known, Known::Refused { .. });
                assert_eq!(unsupported, refused, "{code}: {reason:?}");
            }
        }
        assert_eq!(Dialect::LinuxCnc.knows(Code::TOOL), Known::Unknown);
    }
}
