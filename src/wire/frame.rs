//! Frames: postcard, CRC, COBS.

use crc::{CRC_32_ISCSI, Crc};
use heapless::Vec;
use postcard::ser_flavors::crc::CrcModifier;
use postcard::ser_flavors::{Cobs, Slice};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Most bytes of a frame, its zero byte included: a cubic block over nine axes with every number at its
/// longest, CRC and COBS take 336.
pub const FRAME: usize = 340;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// Writes a message as a frame and gives its length; `None` if `out` is too short for it. [`FRAME`]
/// bytes are enough for every message.
pub fn encode<T: Serialize>(message: &T, out: &mut [u8]) -> Option<usize> {
    let cobs = Cobs::try_new(Slice::new(out)).ok()?;
    let frame = postcard::serialize_with_flavor(message, CrcModifier::new(cobs, CRC.digest()));
    frame.ok().map(|frame| frame.len())
}

/// Puts bytes together to frames and frames to messages.
#[derive(Debug)]
pub struct Inlet {
    bytes: Vec<u8, FRAME>,
    /// The frame under way is too long, or began before anyone listened.
    spoilt: bool,
    damaged: u32,
}

impl Default for Inlet {
    fn default() -> Self {
        Self::new()
    }
}

impl Inlet {
    /// An inlet at the beginning of a frame.
    pub const fn new() -> Self {
        Self { bytes: Vec::new(), spoilt: false, damaged: 0 }
    }

    /// Takes a byte, and gives the message it completes.
    ///
    /// Cost: a store; at the end of a frame, decoding of at most [`FRAME`] bytes.
    pub fn push<T: DeserializeOwned>(&mut self, byte: u8) -> Option<T> {
        if byte != 0 {
            self.spoilt |= self.bytes.push(byte).is_err();
            return None;
        }
        let message = if self.spoilt { None } else { decode(&mut self.bytes) };
        // Zero bytes alone are harmless: a host may send one to end what stood on the line before.
        if message.is_none() && !self.bytes.is_empty() {
            self.damaged = self.damaged.wrapping_add(1);
        }
        self.bytes.clear();
        self.spoilt = false;
        message
    }

    /// Frames dropped because they were damaged.
    pub fn damaged(&self) -> u32 {
        self.damaged
    }
}

fn decode<T: DeserializeOwned>(bytes: &mut [u8]) -> Option<T> {
    let length = cobs::decode_in_place(bytes).ok()?;
    let payload = bytes.get(..length)?;
    let (message, rest) = postcard::take_from_bytes_crc32(payload, CRC.digest()).ok()?;
    rest.is_empty().then_some(message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{Item, Move, Path, Request, Speed, Target};

    fn longest() -> Request {
        let far = Target::from([Some(i64::MIN); 9]);
        let path = Path::Cubic { controls: [far.clone(), far.clone()], to: far };
        let step = Move {
            path,
            speed: Speed::PerSecond(1.0),
            tolerance: Some(0.5),
            exact_stop: true,
            tag: u32::MAX,
        };
        Request::Item { session: u32::MAX, number: u32::MAX, item: Item::Move(step) }
    }

    fn receive(inlet: &mut Inlet, bytes: &[u8]) -> std::vec::Vec<Request> {
        bytes.iter().filter_map(|&byte| inlet.push(byte)).collect()
    }

    #[test]
    fn the_longest_message_fits_into_a_frame_and_comes_back() {
        let mut out = [0; FRAME];
        let length = encode(&longest(), &mut out).unwrap();
        assert_eq!(length, 336);
        assert_eq!(receive(&mut Inlet::new(), &out[..length]), [longest()]);
        assert_eq!(encode(&longest(), &mut out[..100]), None);
    }

    #[test]
    fn no_single_damaged_byte_passes() {
        let mut out = [0; FRAME];
        let length = encode(&longest(), &mut out).unwrap();
        let mut inlet = Inlet::new();
        for place in 0..length {
            for wrong in [0u8, 1, 0xFF, out[place] ^ 0x10] {
                let mut bytes = out[..length].to_vec();
                if bytes[place] == wrong {
                    continue;
                }
                bytes[place] = wrong;
                bytes.push(0);
                assert_eq!(receive(&mut inlet, &bytes), [], "byte {place} as {wrong}");
            }
        }
        // The next whole one does.
        assert_eq!(receive(&mut inlet, &out[..length]), [longest()]);
    }

    #[test]
    fn noise_without_end_is_dropped() {
        let mut inlet = Inlet::new();
        assert_eq!(receive(&mut inlet, &[0xA5; 5000]), []);
        let mut out = [0; FRAME];
        let length = encode(&Request::Ask, &mut out).unwrap();
        assert_eq!(receive(&mut inlet, &[0]), []);
        assert_eq!(inlet.damaged(), 1);
        assert_eq!(receive(&mut inlet, &out[..length]), [Request::Ask]);
    }
}
