//! A cubic curve on its way into the look-ahead: as chords, made one at a time as there is room.
//!
//! The chords stay within a sixteenth of the tolerance of the curve, and the run they become
//! ([`super::run`]) within the rest of it: so a curve is followed within its tolerance, and curves that
//! join with the same tangent go on smoothly, whatever their curvature does.

use super::item::{check_coordinates, in_range};
use crate::block::{Block, BlockError, Feed, Field, Motion};
use crate::machine::Config;
use crate::number::{Coord, Scalar};
use core::array::from_fn;

/// Share of the tolerance that the chords take.
const SHARE: f64 = 1.0 / 16.0;
/// Least tolerance of a curve, mm.
const LEAST_TOLERANCE: f64 = 1.0e-4;
/// Most chords of a curve.
const MOST: f64 = 1.0e6;
/// Parts in which the length of a curve is found, for inverse-time feeds.
const PARTS: u32 = 64;

/// What is left of a curve.
#[derive(Clone, Copy, Debug)]
pub struct Chords<S, const N: usize> {
    /// The chords' common data.
    line: Block<S, N>,
    exact_stop: bool,
    start: [Coord; N],
    end: [Coord; N],
    /// From the start to the other three Bezier points, mm.
    ways: [[f64; N]; 3],
    count: u32,
    next: u32,
}

impl<S: Scalar, const N: usize> Chords<S, N> {
    /// A curve that starts at `from`, checked; `None` if the block is none.
    pub fn new(
        from: [Coord; N],
        block: &Block<S, N>,
        config: &Config<S, N>,
    ) -> Result<Option<Self>, BlockError> {
        let Motion::Cubic { controls, to } = block.motion else { return Ok(None) };
        for point in [&controls[0], &controls[1], &to] {
            check_coordinates(point)?;
        }
        let tolerance = block.tolerance.unwrap_or(config.tolerance);
        in_range(Field::Tolerance, tolerance, LEAST_TOLERANCE, 1.0e3)?;
        let ways =
            [controls[0], controls[1], to].map(|point| from_fn(|i| point[i].minus::<f64>(from[i])));
        let [a, b, c] = &ways;
        // Six times the greater of the second differences is the greatest second derivative.
        let (mut early, mut late) = (0.0, 0.0);
        for i in 0..N {
            early += (b[i] - 2.0 * a[i]) * (b[i] - 2.0 * a[i]);
            let x = c[i] - 2.0 * b[i] + a[i];
            late += x * x;
        }
        let sag = tolerance.to_f64() * SHARE;
        let bend = Scalar::sqrt(f64::max(early, late));
        let count = libm::ceil(Scalar::sqrt(0.75 * bend / sag));
        if count > MOST {
            let least = tolerance.to_f64() * (count / MOST) * (count / MOST);
            let (field, value) = (Field::Tolerance, tolerance.to_f64());
            return Err(BlockError::OutOfRange { field, value, least, greatest: 1.0e3 });
        }
        let mut line = *block;
        line.tolerance = Some(tolerance - S::of(sag));
        line.exact_stop = false;
        let mut chords = Self {
            line,
            exact_stop: block.exact_stop,
            start: from,
            end: to,
            ways,
            count: (count as u32).max(1),
            next: 1,
        };
        if let Feed::Duration(seconds) = block.feed {
            in_range(Field::Duration, seconds, 1.0e-6, 1.0e6)?;
            let speed = chords.length() / seconds.to_f64();
            chords.line.feed = Feed::PerSecond(S::of(speed.clamp(1.0e-9, 1.0e6)));
        }
        Ok(Some(chords))
    }

    /// Where the curve ends.
    pub fn end(&self) -> &[Coord; N] {
        &self.end
    }

    /// From the start to the place at a share of the parameter, mm.
    fn way(&self, u: f64) -> [f64; N] {
        let v = 1.0 - u;
        let [a, b, c] = &self.ways;
        from_fn(|i| 3.0 * v * u * (v * a[i] + u * b[i]) + u * u * u * c[i])
    }

    /// Length, mm, by chords.
    fn length(&self) -> f64 {
        let (mut sum, mut before) = (0.0, [0.0; N]);
        for k in 1..=PARTS {
            let here = self.way(f64::from(k) / f64::from(PARTS));
            let mut square = 0.0;
            for (x, y) in here.iter().zip(before) {
                square += (x - y) * (x - y);
            }
            sum += Scalar::sqrt(square);
            before = here;
        }
        sum
    }

    /// The next chord, as a line.
    pub fn line(&self) -> Block<S, N> {
        let last = self.next == self.count;
        let to = if last {
            self.end
        } else {
            let way = self.way(f64::from(self.next) / f64::from(self.count));
            from_fn(|i| self.start[i].plus(way[i]))
        };
        Block { motion: Motion::Line { to }, exact_stop: last && self.exact_stop, ..self.line }
    }

    /// Moves on to the chord after it; `None` if that was the last.
    pub fn advanced(self) -> Option<Self> {
        (self.next < self.count).then_some(Self { next: self.next + 1, ..self })
    }
}
