//! The record of the output pins: every change of a level, and when.
//!
//! A byte of [`CYCLE`] says that a servo cycle begins. The number of a tick in it with bit 7 set says that levels have changed there,
//! and a byte with bit 7 clear follows: the [`Levels`] from that tick on. A cycle without a change takes a byte, a pulse four.
//! [`EDGE`] says that inputs have changed since the tick before it, and a byte with the tick's number follows.

/// A servo cycle begins.
pub const CYCLE: u8 = 0xFF;
/// Inputs have changed.
pub const EDGE: u8 = 0xFE;
/// Ticks in a servo cycle that can be told apart.
pub const MOST_TICKS: u32 = 0x7E;

/// Levels of all pins: bit 2k the step pin of axis k, bit 2k + 1 its direction (high: back), [`ENABLE`] the drives' enable.
pub type Levels = u8;

/// The pin that enables the drives.
pub const ENABLE: Levels = 1 << 6;

/// The step pin of an axis.
pub const fn step(axis: usize) -> Levels {
    1 << (2 * axis)
}

/// The direction pin of an axis.
pub const fn direction(axis: usize) -> Levels {
    2 << (2 * axis)
}

/// Writes the record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Recorder {
    before: Levels,
}

impl Recorder {
    /// With all pins low.
    pub const fn new() -> Self {
        Self { before: 0 }
    }

    /// After a tick with these levels. `put` takes a byte.
    ///
    /// Cost: a comparison, and three bytes at most.
    #[inline]
    pub fn tick(&mut self, tick: u32, levels: Levels, mut put: impl FnMut(u8)) {
        if tick == 0 {
            put(CYCLE);
        }
        if levels != self.before {
            self.before = levels;
            put(0x80 | tick as u8);
            put(levels & 0x7F);
        }
    }
}

/// A change of levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Servo cycles before the one in which it happened.
    pub cycle: u64,
    /// Tick in that cycle.
    pub tick: u32,
    /// From there on.
    pub levels: Levels,
}

/// What a record says next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// A servo cycle begins; so many began before it.
    Cycle(u64),
    /// Levels change.
    Change(Change),
    /// Inputs have changed, after a tick of a cycle.
    Edge {
        /// Servo cycles before the one in which it happened.
        cycle: u64,
        /// The last tick before it.
        tick: u32,
    },
}

/// A byte that is none of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damaged {
    /// Bytes before it.
    pub at: u64,
    /// The byte.
    pub byte: u8,
}

impl core::fmt::Display for Damaged {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "byte {} of the record of the pins is {:#04x}", self.at, self.byte)
    }
}

impl core::error::Error for Damaged {}

/// Reads a record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reader {
    at: u64,
    cycles: u64,
    open: Option<Open>,
    last: u32,
}

/// What the next byte belongs to.
#[derive(Clone, Copy, Debug)]
enum Open {
    Change { tick: u32 },
    Edge,
}

impl Reader {
    /// At the beginning of a record.
    pub const fn new() -> Self {
        Self { at: 0, cycles: 0, open: None, last: 0 }
    }

    /// Takes a byte.
    ///
    /// # Errors
    /// It is none of a record: a byte before it was lost.
    pub fn push(&mut self, byte: u8) -> Result<Option<News>, Damaged> {
        let damaged = Damaged { at: self.at, byte };
        self.at += 1;
        if let Some(open) = self.open.take() {
            if byte & 0x80 != 0 || self.cycles == 0 {
                return Err(damaged);
            }
            let cycle = self.cycles - 1;
            return Ok(Some(match open {
                Open::Change { tick } => News::Change(Change { cycle, tick, levels: byte }),
                Open::Edge => News::Edge { cycle, tick: byte.into() },
            }));
        }
        if byte == CYCLE {
            (self.cycles, self.last) = (self.cycles + 1, 0);
            return Ok(Some(News::Cycle(self.cycles - 1)));
        }
        if byte == EDGE {
            self.open = Some(Open::Edge);
            return Ok(None);
        }
        let tick = u32::from(byte & 0x7F);
        // Ticks go on within a cycle; the first may be told twice, by nobody.
        if byte & 0x80 == 0 || (tick > 0 && tick <= self.last) || (tick == 0 && self.last > 0) {
            return Err(damaged);
        }
        (self.open, self.last) = (Some(Open::Change { tick }), tick);
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The levels of every tick, recorded.
    fn record(levels: &[[Levels; 4]]) -> Vec<u8> {
        let (mut recorder, mut bytes) = (Recorder::new(), Vec::new());
        for cycle in levels {
            for (levels, tick) in cycle.iter().zip(0..) {
                recorder.tick(tick, *levels, |byte| bytes.push(byte));
            }
        }
        bytes
    }

    /// The levels of every tick, read again.
    fn read(bytes: &[u8]) -> Result<Vec<[Levels; 4]>, Damaged> {
        let (mut reader, mut out, mut now) = (Reader::new(), Vec::new(), 0);
        for &byte in bytes {
            match reader.push(byte)? {
                None => {}
                Some(News::Cycle(cycle)) => {
                    assert_eq!(cycle, out.len() as u64);
                    out.push([now; 4]);
                }
                Some(News::Change(change)) => {
                    assert_eq!(change.cycle + 1, out.len() as u64);
                    now = change.levels;
                    out.last_mut().unwrap()[change.tick as usize..].fill(now);
                }
                Some(News::Edge { .. }) => panic!("no inputs have changed"),
            }
        }
        Ok(out)
    }

    #[test]
    fn a_record_says_what_the_pins_did() {
        let levels =
            [[0, 1, 0, 0x40], [0x40; 4], [0x7F, 0x40, 0x40, 0x41], [0x41, 0, 0, 0], [1, 2, 3, 4]];
        let bytes = record(&levels);
        assert_eq!(read(&bytes).unwrap(), levels);
        assert_eq!(bytes.len(), 5 + 2 * 11);
    }

    #[test]
    fn an_edge_of_an_input_lies_between_ticks() {
        let bytes = [CYCLE, 0x83, 1, EDGE, 7, 0x88, 0, CYCLE];
        let mut reader = Reader::new();
        let news: Vec<_> = bytes.iter().filter_map(|&byte| reader.push(byte).unwrap()).collect();
        assert_eq!(news[2], News::Edge { cycle: 0, tick: 7 });
        assert_eq!(news.len(), 5);
    }

    /// A byte that is lost in the middle is noticed, wherever the record can tell.
    #[test]
    fn a_lost_byte_shows() {
        let levels = [[0, 1, 0, 1], [0, 1, 0, 1], [0; 4], [0; 4]];
        let bytes = record(&levels);
        let noticed = (1..bytes.len()).filter(|&k| {
            let mut bytes = bytes.clone();
            bytes.remove(k);
            read(&bytes).is_err() || read(&bytes).unwrap().len() != levels.len()
        });
        // Both bytes of a change, and the mark of a cycle.
        assert_eq!(noticed.count(), bytes.len() - 1);
    }
}
