//! A spline smoothed as the emulated image and the host both do it: the same numbers in, one digest of the control points
//! out.

use crate::{Meter, Part};
use crc::{CRC_32_ISCSI, Crc};
use heapless::Vec;
use splineway_splines::{Spline, bounded, thesis};

/// Control points there is room for.
pub const ROOM: usize = 64;
const SIZE: usize = ROOM + 3;
const CHECKS: usize = SIZE * bounded::SPAN_CHECKS;

type Planar = Spline<f32, 2, ROOM>;

/// What came out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smoothed {
    /// Control points.
    pub points: u32,
    /// Iterations of the thesis's method; 0 of the bounded one.
    pub iterations: u32,
    /// CRC-32/ISCSI of all control points.
    pub digest: u32,
}

/// Smooths an open spline in the plane. `source` gives single-precision numbers, byte by byte, the least significant one
/// first: sweeps of the bounded method, or 0 for the thesis's; how many control points there are, the tube's radius, the
/// knots, each once, and the control points. `None`: these are no spline.
pub fn smooth(source: &mut dyn FnMut() -> Option<u8>, meter: &mut dyn Meter) -> Option<Smoothed> {
    let mut number = || -> Option<f32> {
        let mut bytes = [0; 4];
        for byte in &mut bytes {
            *byte = source()?;
        }
        Some(f32::from_le_bytes(bytes))
    };
    let sweeps = number()? as u16;
    let points = number()? as usize;
    let radius = number()?;
    let mut knots: Vec<f32, ROOM> = Vec::new();
    for _ in 2..points {
        knots.push(number()?).ok()?;
    }
    let mut controls: Vec<[f32; 2], ROOM> = Vec::new();
    for _ in 0..points {
        controls.push([number()?, number()?]).ok()?;
    }
    let mut spline = Planar::open(&controls, &knots).ok()?;
    let mut iterations = 0;
    if sweeps == 0 {
        meter.begin();
        let outcome = thesis::smooth(&mut spline, &thesis::Options::new(radius));
        meter.end(Part::Planning);
        iterations = outcome.ok()?.iterations;
    } else {
        let options = bounded::Options { sweeps, ..bounded::Options::new(radius) };
        let mut room = bounded::Smoother::<f32, 2, SIZE, CHECKS>::new();
        meter.begin();
        let outcome = room.smooth(&mut spline, &options);
        meter.end(Part::Planning);
        outcome.ok()?;
    }
    let crc = Crc::<u32>::new(&CRC_32_ISCSI);
    let mut digest = crc.digest();
    for x in spline.controls().as_flattened() {
        digest.update(&x.to_le_bytes());
    }
    Some(Smoothed { points: points as u32, iterations, digest: digest.finalize() })
}
