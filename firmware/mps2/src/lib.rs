//! What the recorder at the pins of the emulated board writes, and how it is read again.
//!
//! The image is `src/main.rs`. What streams to it and judges its steps is the bench `board` of the host's package.
//! Nothing here knows a chip.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod pins;
