//! What outlasts power: settings, work offsets, startup lines; in two copies, so that a write that is cut loses nothing.
//!
//! A copy is a row of words: a mark, a running number, the number of axes, what is kept, and a checksum. A write goes to the copy
//! that is not the newest whole one; of those that are whole, the one with the higher number counts. So whatever a power cut leaves of
//! the copy that is being written, the other one is as it was.

use super::settings::Settings;
use crate::number::Coord;
use heapless::Vec;

/// Bytes of a startup line, and of the text of `$I`.
pub const TEXT: usize = 80;
/// Work offsets that are kept: G54 to G59.
pub const WORKS: usize = 6;
/// Startup lines.
pub const STARTUPS: usize = 2;

/// First word of a copy: changes with the layout.
const MARK: u32 = u32::from_le_bytes(*b"SWG1");

/// Words of a copy for so many axes: what a [`Store`] must have room for, twice.
pub const fn words(axes: usize) -> usize {
    3 + 22 + 5 * axes + 2 * axes * (WORKS + 2) + (STARTUPS + 1) * (TEXT / 4 + 1) + 1
}

/// Two places that keep words without power, as pages of flash do. It is only asked when the machine rests.
pub trait Store {
    /// A word of a copy, 0 or 1; `None` if it cannot be read.
    fn read(&mut self, copy: usize, at: usize) -> Option<u32>;
    /// Makes a copy ready to be written. `false`: it cannot be.
    fn erase(&mut self, copy: usize) -> bool;
    /// Writes a word of a copy that has been erased, each once, in their order.
    fn write(&mut self, copy: usize, at: usize, word: u32) -> bool;
}

/// Keeps nothing.
impl Store for () {
    fn read(&mut self, _: usize, _: usize) -> Option<u32> {
        None
    }

    fn erase(&mut self, _: usize) -> bool {
        true
    }

    fn write(&mut self, _: usize, _: usize, _: u32) -> bool {
        true
    }
}

/// A text that is kept.
pub type Text = Vec<u8, TEXT>;

/// What is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory<const N: usize> {
    pub settings: Settings<N>,
    /// G54 to G59.
    pub work: [[Coord; N]; WORKS],
    /// G28 and G30.
    pub reference: [[Coord; N]; 2],
    pub startup: [Text; STARTUPS],
    pub info: Text,
}

/// Goes through words: writes them, or reads them in.
trait Words {
    fn word(&mut self, word: &mut u32);
}

impl<const N: usize> Memory<N> {
    /// With nothing but settings.
    pub const fn new(settings: Settings<N>) -> Self {
        Self {
            settings,
            work: [[Coord::ZERO; N]; WORKS],
            reference: [[Coord::ZERO; N]; 2],
            startup: [Text::new(), Text::new()],
            info: Text::new(),
        }
    }

    /// Everything in its order, for both directions.
    fn pass(&mut self, words: &mut impl Words) {
        for value in self.settings.values() {
            let mut word = value.to_bits();
            words.word(&mut word);
            *value = f32::from_bits(word);
        }
        for coord in self.work.iter_mut().chain(&mut self.reference).flatten() {
            let raw = coord.raw();
            let (mut low, mut high) = (raw as u32, (raw >> 32) as u32);
            words.word(&mut low);
            words.word(&mut high);
            *coord = Coord::from_raw(i64::from(high) << 32 | i64::from(low));
        }
        for text in self.startup.iter_mut().chain([&mut self.info]) {
            pass_text(text, words);
        }
    }

    /// The newest whole copy; `None` if there is none.
    pub fn load(store: &mut impl Store, defaults: &Self) -> Option<Self> {
        let (copy, _) = newest::<N>(store)?;
        let mut memory = defaults.clone();
        memory.pass(&mut Reading { store, copy, at: HEAD });
        memory.is_sound().then_some(memory)
    }

    fn is_sound(&self) -> bool {
        let mut coords = self.work.iter().chain(&self.reference).flatten();
        self.settings.is_sound() && coords.all(|coord| coord.to_mm().abs() <= Coord::LIMIT_MM)
    }

    /// Writes the copy that is not the newest. Whether it can be read back.
    ///
    /// Cost: [`words`] words, written and read.
    pub fn save(&mut self, store: &mut impl Store) -> bool {
        let (copy, number) = newest::<N>(store).map_or((0, 0), |(copy, number)| (1 - copy, number));
        let number = number.wrapping_add(1);
        if !store.erase(copy) {
            return false;
        }
        let mut writing = Writing { store, copy, at: 0, sum: SUM, good: true };
        for mut word in [MARK, number, N as u32] {
            writing.word(&mut word);
        }
        self.pass(&mut writing);
        let mut sum = !writing.sum;
        writing.word(&mut sum);
        let good = writing.good;
        good && whole::<N>(store, copy) == Some(number)
    }
}

fn pass_text(text: &mut Text, words: &mut impl Words) {
    let mut length = text.len() as u32;
    words.word(&mut length);
    let mut bytes = [0; TEXT];
    for (slot, byte) in bytes.iter_mut().zip(&*text) {
        *slot = *byte;
    }
    for chunk in bytes.chunks_exact_mut(4) {
        let mut word = 0;
        for (i, byte) in chunk.iter().enumerate() {
            word |= u32::from(*byte) << (8 * i);
        }
        words.word(&mut word);
        for (i, byte) in chunk.iter_mut().enumerate() {
            *byte = (word >> (8 * i)) as u8;
        }
    }
    text.clear();
    for byte in bytes.iter().take(length as usize) {
        // As many as there are bytes.
        let _ = text.push(*byte);
    }
}

/// Words before what is kept.
const HEAD: usize = 3;

/// Number of a copy, if it is whole.
fn whole<const N: usize>(store: &mut impl Store, copy: usize) -> Option<u32> {
    let last = words(N) - 1;
    let mut sum = SUM;
    for at in 0..last {
        sum = added(sum, store.read(copy, at)?);
    }
    let head = [store.read(copy, 0)?, store.read(copy, 2)?];
    let is_whole = store.read(copy, last)? == !sum && head == [MARK, N as u32];
    if is_whole { store.read(copy, 1) } else { None }
}

/// The newest whole copy and its number.
fn newest<const N: usize>(store: &mut impl Store) -> Option<(usize, u32)> {
    match (whole::<N>(store, 0), whole::<N>(store, 1)) {
        (Some(first), Some(second)) if second.wrapping_sub(first).cast_signed() > 0 => {
            Some((1, second))
        }
        (Some(first), _) => Some((0, first)),
        (None, second) => second.map(|number| (1, number)),
    }
}

struct Reading<'a, T> {
    store: &'a mut T,
    copy: usize,
    at: usize,
}

impl<T: Store> Words for Reading<'_, T> {
    fn word(&mut self, word: &mut u32) {
        // It has been read a moment ago.
        *word = self.store.read(self.copy, self.at).unwrap_or(0);
        self.at += 1;
    }
}

struct Writing<'a, T> {
    store: &'a mut T,
    copy: usize,
    at: usize,
    sum: u32,
    good: bool,
}

impl<T: Store> Words for Writing<'_, T> {
    fn word(&mut self, word: &mut u32) {
        self.good = self.good && self.store.write(self.copy, self.at, *word);
        self.sum = added(self.sum, *word);
        self.at += 1;
    }
}

/// Where the checksum begins.
const SUM: u32 = u32::MAX;

/// CRC-32 (IEEE 802.3) with a further word, bit by bit: a copy has some hundred words.
fn added(sum: u32, word: u32) -> u32 {
    (0..32).fold(sum ^ word, |sum, _| sum >> 1 ^ if sum & 1 == 1 { 0xEDB8_8320 } else { 0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Config;
    use crate::machine::{AxisLimits, Limits};

    const WORDS: usize = words(3);

    /// Two pages of flash, and a power cut after so many operations.
    #[derive(Clone)]
    struct Flash {
        pages: [[u32; WORDS]; 2],
        left: usize,
        /// Of the word that the cut is in, these bits have been written.
        torn: u32,
    }

    impl Flash {
        fn operates(&mut self) -> bool {
            let on = self.left > 0;
            self.left = self.left.saturating_sub(1);
            on
        }
    }

    impl Store for Flash {
        fn read(&mut self, copy: usize, at: usize) -> Option<u32> {
            self.pages[copy].get(at).copied()
        }

        fn erase(&mut self, copy: usize) -> bool {
            if !self.operates() {
                // An erase that was cut: anything.
                self.pages[copy].iter_mut().step_by(2).for_each(|word| *word = self.torn);
                return false;
            }
            self.pages[copy] = [u32::MAX; WORDS];
            true
        }

        fn write(&mut self, copy: usize, at: usize, word: u32) -> bool {
            let on = self.operates();
            // Flash only clears bits.
            self.pages[copy][at] &= if on { word } else { word | self.torn };
            on
        }
    }

    fn memory(steps: f32) -> Memory<3> {
        let axis = AxisLimits::linear(200.0f32, 2000.0, 50_000.0);
        let config = Config::new(Limits::new([axis; 3]).unwrap());
        let mut memory = Memory::new(Settings::new(&config, [steps; 3], [300.0; 3]));
        memory.work[2] = [Coord::from_raw(-1), Coord::from_mm(12.5).unwrap(), Coord::from_raw(1)];
        memory.startup[1].extend_from_slice(b"G54 G20").unwrap();
        memory.info.extend_from_slice(&[b'i'; TEXT]).unwrap();
        memory
    }

    #[test]
    fn what_is_kept_comes_back() {
        let mut flash = Flash { pages: [[u32::MAX; WORDS]; 2], left: usize::MAX, torn: 0 };
        assert_eq!(Memory::load(&mut flash, &memory(1.0)), None);
        for steps in 2..9 {
            let mut kept = memory(steps as f32);
            assert!(kept.save(&mut flash));
            assert_eq!(Memory::load(&mut flash, &memory(1.0)), Some(kept));
        }
    }

    /// A write that is cut at any operation, with any part of its word written: the old or the new, never anything else.
    #[test]
    fn a_torn_write_loses_nothing() {
        let mut flash = Flash { pages: [[u32::MAX; WORDS]; 2], left: usize::MAX, torn: 0 };
        for steps in [2.0, 3.0] {
            assert!(memory(steps).save(&mut flash));
        }
        for left in 0..=WORDS {
            for torn in [0, u32::MAX, 0xFFFF_FF00, 0xFFFF_0000, 0xFF00_0000, 0x5555_5555] {
                let mut cut = Flash { left, torn, ..flash.clone() };
                assert!(!memory(4.0).save(&mut cut));
                let found = Memory::load(&mut cut, &memory(1.0)).unwrap();
                assert!(found == memory(3.0) || found == memory(4.0), "{left} {torn:x}");
                // And the next write is good, whatever is left of the torn one.
                cut.left = usize::MAX;
                assert!(memory(5.0).save(&mut cut));
                assert_eq!(Memory::load(&mut cut, &memory(1.0)), Some(memory(5.0)));
            }
        }
    }

    #[test]
    fn a_copy_of_another_machine_or_with_a_flipped_bit_is_none() {
        let mut flash = Flash { pages: [[u32::MAX; WORDS]; 2], left: usize::MAX, torn: 0 };
        assert!(memory(2.0).save(&mut flash));
        for at in 0..WORDS {
            let mut other = flash.clone();
            other.pages[0][at] ^= 1 << (at % 32);
            assert_eq!(Memory::load(&mut other, &memory(1.0)), None, "word {at}");
        }
    }

    #[test]
    fn the_checksum_is_the_published_one() {
        let words = [u32::from_le_bytes(*b"1234"), u32::from_le_bytes(*b"5678")];
        // CRC-32 of "12345678".
        assert_eq!(!words.into_iter().fold(SUM, added), 0x9AE0_DAAF);
    }
}
