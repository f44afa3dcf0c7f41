//! G-code, as a board reads it.

use core::hint::black_box;
use splineway::gcode::{Coolant, Dialect, Laser, Reader, Settings};
use splineway::{Block, Offset};

/// A line and what comes of it.
pub fn read(line: &[u8]) -> Option<Block<f32, 3>> {
    let settings = black_box(Settings {
        dialect: Dialect::Marlin,
        lenient: true,
        block_delete: true,
        switches: true,
        laser: Some(Laser { least: 1.0, most: 1000.0 }),
        coolant: Some(Coolant { mist: 0, flood: 1, lead: Offset::Time(-0.1) }),
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
