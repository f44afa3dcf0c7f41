//! A serial line that loses, garbles and doubles.

use proptest::prelude::*;
use splineway::Setpoint;
use splineway::wire::{FRAME, Item, Sender, Station, Step, encode};
use std::collections::VecDeque;

/// What the line does to a share of its bytes.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    Cut,
    Flip(u8),
    Double,
    Zero,
}

/// A line with faults at given distances, over and over.
pub struct Line {
    bytes: VecDeque<u8>,
    faults: Vec<(u16, Fault)>,
    next: usize,
    wait: u16,
    /// Nothing goes wrong any more.
    pub healed: bool,
}

impl Line {
    pub fn new(faults: &[(u16, Fault)]) -> Self {
        let wait = faults.first().map_or(0, |fault| fault.0);
        Self { bytes: VecDeque::new(), faults: faults.to_vec(), next: 0, wait, healed: false }
    }

    pub fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if self.healed || self.faults.is_empty() || self.wait > 0 {
                self.wait = self.wait.saturating_sub(1);
                self.bytes.push_back(byte);
                continue;
            }
            match self.faults[self.next].1 {
                Fault::Cut => {}
                Fault::Flip(mask) => self.bytes.push_back(byte ^ mask),
                Fault::Double => self.bytes.extend([byte, byte]),
                Fault::Zero => self.bytes.push_back(0),
            }
            self.next = (self.next + 1) % self.faults.len();
            self.wait = self.faults[self.next].0;
        }
    }

    /// As many bytes as pass in a millisecond.
    pub fn receive(&mut self) -> Vec<u8> {
        let count = self.bytes.len().min(60);
        self.bytes.drain(..count).collect()
    }
}

/// A fault after so many bytes.
pub fn fault() -> impl Strategy<Value = (u16, Fault)> {
    let kind = prop_oneof![
        Just(Fault::Cut),
        (1u8..=255).prop_map(Fault::Flip),
        Just(Fault::Double),
        Just(Fault::Zero)
    ];
    (0u16..400, kind)
}

/// What a host sends at a time, to `send`.
pub fn speak(sender: &mut Sender, items: &[Item], now: u64, mut send: impl FnMut(&[u8])) {
    let mut out = [0; FRAME];
    for _ in 0..4 {
        let request = match sender.step(now) {
            Step::Wait => break,
            Step::Send(request) => request,
            Step::Item(number) => sender.item(number, items[number as usize].clone()),
        };
        let length = encode(&request, &mut out).unwrap();
        send(&out[..length]);
    }
}

/// All that a controller has to reply.
pub fn answer<const QUEUE: usize>(
    station: &mut Station<f32, 3, QUEUE>,
    setpoint: &Setpoint<f32, 3>,
    line: &mut Line,
) {
    let mut out = [0; FRAME];
    loop {
        let length = station.reply(setpoint, &mut out);
        if length == 0 {
            break;
        }
        line.send(&out[..length]);
    }
}
