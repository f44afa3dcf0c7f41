//! A tool path as a machine on the emulated chip gets it.

use anyhow::{Context, Result};
use splineway::wire::{self, FRAME, Opening, Request, VERSION};
use splineway_host::stream;
use splineway_simulator::program::{self, Program, ReadOptions};
use std::path::Path;

/// The machine that a path is meant for.
pub struct Machine {
    /// Velocity, mm/s, acceleration, mm/s2, and jerk, mm/s3, of every axis.
    pub limits: [f32; 3],
    /// Tolerance, mm.
    pub tolerance: f32,
    /// Servo cycle, s.
    pub cycle: f32,
}

impl Machine {
    /// As the header of the path says, if it has one.
    pub fn of(program: &Program) -> Self {
        let header = program.header;
        let limit = |value: Option<f64>, else_: f64| value.unwrap_or(else_) as f32;
        Self {
            limits: [
                limit(header.map(|h| h.velocity), 200.0),
                limit(header.map(|h| h.acceleration), 2000.0),
                limit(header.map(|h| h.jerk), 50_000.0),
            ],
            tolerance: limit(header.map(|h| h.tolerance), 0.01),
            cycle: limit(header.map(|h| h.cycle), 0.001),
        }
    }
}

/// Reads a path.
pub fn read(path: &Path) -> Result<Program> {
    let options = ReadOptions { feed: 100.0, ..ReadOptions::DEFAULT };
    // A NURBS curve as chords, all else as it is.
    program::read(path, ReadOptions { segments: Some(500), ..options })
        .or_else(|_| program::read(path, options))
}

fn frame(bytes: &mut Vec<u8>, message: &impl serde::Serialize) -> Result<()> {
    let mut out = [0; FRAME];
    let length = wire::encode(message, &mut out).context("a message is too long")?;
    bytes.extend_from_slice(&out[..length]);
    Ok(())
}

/// A program as the frames of a session, after a frame with the image's setup.
pub fn frames(program: &Program, setup: &impl serde::Serialize, axes: usize) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    frame(&mut bytes, setup)?;
    let opening = Opening { version: VERSION, session: 1, silence: 0, abort: false };
    frame(&mut bytes, &Request::Open(opening))?;
    let items = stream::items(&program.with_approach(), axes)?;
    for (item, number) in items.into_iter().zip(0..) {
        frame(&mut bytes, &Request::Item { session: 1, number, item })?;
    }
    Ok(bytes)
}
