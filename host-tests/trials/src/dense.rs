//! Poly-lines as dense programs have them.

use super::moves::between;
use fastrand::Rng;
use splineway_simulator::program::{Course, Move, Point, Program, Speed};

/// A stretch of a dense program: kind, number of lines, their length and turn, and noise.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Which kind.
    pub kind: u8,
    /// Lines.
    pub count: usize,
    /// Length of a line, mm.
    pub size: f64,
    /// Turn from one to the next, rad.
    pub turn: f64,
    /// Noise, mm or rad.
    pub noise: f64,
    /// mm/s.
    pub feed: f64,
}

impl Stretch {
    /// Any stretch, with lines from a tenth of a micrometre to 3 mm.
    pub fn any(rng: &mut Rng) -> Self {
        Self {
            kind: rng.u8(..10),
            count: rng.usize(1..40),
            size: 10f64.powf(between(rng, -4.0, 0.5)),
            turn: between(rng, -0.6, 0.6),
            noise: 10f64.powf(between(rng, -4.0, 0.0)),
            feed: 10f64.powf(between(rng, 0.5, 2.4)),
        }
    }
}

/// The corners of a poly-line as such programs have them.
pub fn dense(stretches: &[Stretch]) -> Program {
    let mut points: Vec<([f64; 3], f64)> = Vec::new();
    let (mut at, mut heading, mut climb) = ([0.0f64; 3], 0.0f64, 0.0f64);
    for stretch in stretches {
        let Stretch { kind, count, size, turn, noise, feed } = *stretch;
        let feed = feed.max(size * 5.0);
        let mut go = |heading: f64, climb: f64, size: f64| {
            at[0] += size * heading.cos() * climb.cos();
            at[1] += size * heading.sin() * climb.cos();
            at[2] += size * climb.sin();
            points.push((at, feed));
        };
        match kind {
            // Curves, also out of the plane.
            0..=2 => {
                for _ in 0..count {
                    heading += turn;
                    climb += if kind == 2 { 0.1 * turn } else { 0.0 };
                    go(heading, climb, size);
                }
            }
            // A straight line with noise.
            3 => {
                for k in 0..count {
                    let off = if k % 2 == 0 { noise.min(1.0) } else { -noise.min(1.0) };
                    go(heading + off, climb, size);
                }
            }
            // A spike there and back, and a reversal for good.
            4 => {
                go(heading + turn, climb, noise);
                go(heading + turn + std::f64::consts::PI, climb, noise);
                go(heading, climb, size);
            }
            5 => {
                heading += std::f64::consts::PI + turn * noise;
                go(heading, climb, size);
            }
            // The same point again and again; the tiniest lines.
            6 => (0..count).for_each(|_| go(heading, climb, 0.0)),
            7 => (0..count).for_each(|_| go(heading, climb, 2.0e-4)),
            // Ten thousand times as long.
            8 => go(heading + turn, climb, (size * 1.0e4).min(20.0)),
            // A closed loop.
            _ => {
                for _ in 0..12 {
                    heading += std::f64::consts::TAU / 12.0;
                    go(heading, climb, size);
                }
            }
        }
    }
    poly_line(&points)
}

/// A program of lines through points, each with its feed, mm/s, from the origin.
pub fn poly_line(points: &[([f64; 3], f64)]) -> Program {
    let mut program = Program::default();
    program.uses[..3].fill(true);
    for (n, (point, feed)) in points.iter().enumerate() {
        let mut to: Point = [0.0; 9];
        to[..3].copy_from_slice(point);
        let path = Course::Line { to };
        program.moves.push(Move::new(path, Speed::PerSecond(*feed), n as u32 + 1));
    }
    program
}
