//! G-code, as a board reads it.

use core::hint::black_box;
use splineway::Block;
use splineway::gcode::{Dialect, Reader, Settings};

/// A line and what comes of it.
pub fn read(line: &[u8]) -> Option<Block<f32, 3>> {
    let settings = black_box(Settings {
        dialect: Dialect::Marlin,
        lenient: true,
        block_delete: true,
        ..Settings::default()
    });
    let mut reader = Reader::new(&settings);
    for number in 0..black_box(2) {
        reader.line(number, black_box(line)).ok()?;
        black_box(reader.notes());
        while let Some(action) = reader.action() {
            if let Some(block) = black_box(action).block(&black_box([0, 1, 2])) {
                return Some(block);
            }
        }
    }
    black_box((reader.position(), reader.named(), reader.has_ended()));
    None
}
