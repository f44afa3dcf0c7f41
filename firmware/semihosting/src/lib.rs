//! Files of the host, and the end, for images on an emulated Cortex-M. They come by semihosting, which takes no time in the
//! emulator.
//!
//! Nothing of the core belongs here.
#![no_std]
#![cfg(target_os = "none")]
// The calls of semihosting.
#![allow(unsafe_code)]

use cortex_m_semihosting::{debug, hprintln, syscall, syscall1};

/// Modes of `SYS_OPEN`: "rb" and "wb".
const READ: usize = 1;
const WRITE: usize = 5;
/// `SYS_GET_CMDLINE`.
const COMMAND_LINE: usize = 0x15;

/// A file whose name is a word of the image's command line; the first word, 0, is the image itself.
pub struct File {
    handle: usize,
}

impl File {
    /// Opens a file that is there. `None`: there is no such word or file.
    pub fn read_from(word: usize) -> Option<Self> {
        Self::open(word, READ)
    }

    /// Makes a file, or empties it. `None`: there is no such word, or it cannot be made.
    pub fn write_to(word: usize) -> Option<Self> {
        Self::open(word, WRITE)
    }

    fn open(word: usize, mode: usize) -> Option<Self> {
        let mut line = [0u8; 256];
        let mut block = [line.as_mut_ptr() as usize, line.len()];
        // SAFETY: SYS_GET_CMDLINE writes at most the given length to the buffer.
        if unsafe { syscall1(COMMAND_LINE, block.as_mut_ptr() as usize) } != 0 {
            return None;
        }
        let end = line.iter().position(|&byte| byte == 0)?;
        let before: usize =
            line[..end].split(|&byte| byte == b' ').take(word).map(|word| word.len() + 1).sum();
        let length = line.get(before..end)?.iter().take_while(|&&byte| byte != b' ').count();
        line[before + length] = 0;
        // SAFETY: SYS_OPEN reads a string of that length which ends in zero.
        let handle = unsafe { syscall!(OPEN, line.as_ptr() as usize + before, mode, length) };
        (handle != usize::MAX).then_some(Self { handle })
    }

    /// Reads on; returns how many bytes there were.
    pub fn read(&mut self, bytes: &mut [u8]) -> usize {
        // SAFETY: SYS_READ writes at most the given length to the buffer.
        let left = unsafe { syscall!(READ, self.handle, bytes.as_mut_ptr() as usize, bytes.len()) };
        bytes.len().saturating_sub(left)
    }

    /// Writes on.
    pub fn write(&mut self, bytes: &[u8]) {
        // SAFETY: SYS_WRITE reads the given length from the buffer.
        unsafe { syscall!(WRITE, self.handle, bytes.as_ptr() as usize, bytes.len()) };
    }

    /// What is left of it, byte by byte.
    pub const fn bytes(self) -> Bytes {
        Bytes { file: self, buffer: [0; 512], next: 0, end: 0 }
    }
}

/// The bytes of a file.
pub struct Bytes {
    file: File,
    buffer: [u8; 512],
    next: usize,
    end: usize,
}

impl Iterator for Bytes {
    type Item = u8;

    fn next(&mut self) -> Option<u8> {
        if self.next == self.end {
            self.next = 0;
            self.end = self.file.read(&mut self.buffer);
        }
        let byte = *self.buffer[..self.end].get(self.next)?;
        self.next += 1;
        Some(byte)
    }
}

/// Ends the image: with success, or with failure after saying why there is nothing.
pub fn end(done: Option<()>, why: &str) -> ! {
    if done.is_none() {
        hprintln!("{}", why);
        debug::exit(debug::EXIT_FAILURE);
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        core::hint::spin_loop();
    }
}
