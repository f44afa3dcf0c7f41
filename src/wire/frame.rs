//! Frames: postcard, CRC, COBS.
//!
//! COBS is written here, and only of postcard is used what cannot panic: its own coder for COBS, and that of the
//! crate of that name, keep bounds checks that no compiler can remove.

use crc::{CRC_32_ISCSI, Crc, Digest};
use heapless::Vec;
use postcard::ser_flavors::Flavor;
use postcard::{Error, Result as PostcardResult};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Most bytes of a frame, its zero byte included: homing of nine axes with every number at its
/// longest, CRC and COBS take 412.
pub const FRAME: usize = 412;

/// A block of COBS that is so long, its code included, stands for its bytes alone: no zero follows.
const FULL: u8 = u8::MAX;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// Writes a message as a frame and gives its length; `None` if `out` is too short for it. [`FRAME`]
/// bytes are enough for every message.
///
/// Cost: proportional to the bytes of the frame.
pub fn encode<T: Serialize>(message: &T, out: &mut [u8]) -> Option<usize> {
    postcard::serialize_with_flavor(message, Writer::new(out)).ok()
}

/// Puts what postcard writes, and the CRC of it, into a frame (Cheshire, Baker 1999).
struct Writer<'a> {
    out: &'a mut [u8],
    /// Where the block under way has its code: how far it is to the next.
    code: usize,
    /// Where the next byte goes.
    next: usize,
    digest: Digest<'static, u32>,
}

impl<'a> Writer<'a> {
    fn new(out: &'a mut [u8]) -> Self {
        Self { out, code: 0, next: 1, digest: CRC.digest() }
    }

    fn put(&mut self, place: usize, byte: u8) -> PostcardResult<()> {
        *self.out.get_mut(place).ok_or(Error::SerializeBufferFull)? = byte;
        Ok(())
    }

    /// Length of the block under way, its code included: at most [`FULL`].
    fn length(&self) -> u8 {
        self.next.wrapping_sub(self.code) as u8
    }

    fn end_block(&mut self) -> PostcardResult<()> {
        self.put(self.code, self.length())?;
        (self.code, self.next) = (self.next, self.next + 1);
        Ok(())
    }

    fn stuff(&mut self, byte: u8) -> PostcardResult<()> {
        if byte == 0 {
            return self.end_block();
        }
        self.put(self.next, byte)?;
        self.next += 1;
        if self.length() == FULL { self.end_block() } else { Ok(()) }
    }
}

impl Flavor for Writer<'_> {
    /// Length of the frame.
    type Output = usize;

    fn try_push(&mut self, byte: u8) -> PostcardResult<()> {
        self.digest.update(&[byte]);
        self.stuff(byte)
    }

    fn finalize(mut self) -> PostcardResult<usize> {
        for byte in self.digest.clone().finalize().to_le_bytes() {
            self.stuff(byte)?;
        }
        let end = self.next;
        self.put(end, 0)?;
        self.end_block()?;
        Ok(end + 1)
    }
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
    let (payload, sum) = unstuff(bytes)?.split_last_chunk()?;
    if CRC.checksum(payload) != u32::from_le_bytes(*sum) {
        return None;
    }
    let (message, rest) = postcard::take_from_bytes(payload).ok()?;
    rest.is_empty().then_some(message)
}

/// Takes COBS back, in place; `None` if the last block is cut off.
fn unstuff(bytes: &mut [u8]) -> Option<&[u8]> {
    // Bytes to come of the block under way, and whether it stands for a zero after them.
    let (mut left, mut zero) = (0, false);
    let mut written = 0;
    for read in 0..bytes.len() {
        let mut byte = *bytes.get(read)?;
        if left > 0 {
            left -= 1;
        } else {
            left = byte.checked_sub(1)?;
            if !core::mem::replace(&mut zero, byte != FULL) {
                continue;
            }
            byte = 0;
        }
        *bytes.get_mut(written)? = byte;
        written += 1;
    }
    if left == 0 { bytes.get(..written) } else { None }
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
