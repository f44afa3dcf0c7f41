//! The programmed lines that the motion is on, or will be: what its band is around.

use crate::number::vector::{norm, zero};
use crate::number::{Coord, Scalar};
use crate::reshape::Line;
use heapless::{Deque, Vec};

/// Lines that are remembered from the motion on: a run of short ones takes a dozen or more for a cell.
const LINES: usize = 2048;
/// Lines that a window may pass.
pub const NEAR: usize = 640;

/// A straight line, from the end of the one before.
#[derive(Clone, Copy, Debug)]
struct Course<S, const N: usize> {
    to: [Coord; N],
    /// Half the width of its band, mm; 0: it is no line, or has no band.
    band: S,
    /// mm/s.
    feed: S,
}

/// Lines in order, with running numbers that wrap.
pub struct Lines<S, const N: usize> {
    list: Deque<Course<S, N>, LINES>,
    /// Number of the first, and where it starts.
    first: u32,
    start: [Coord; N],
}

impl<S: Scalar, const N: usize> Lines<S, N> {
    pub const NONE: Self = Self { list: Deque::new(), first: 0, start: [Coord::ZERO; N] };

    /// Forgets all; those to come are behind them.
    pub fn clear(&mut self) {
        self.first = self.first.wrapping_add(self.list.len() as u32);
        self.list.clear();
    }

    /// Takes a line, or something else that leads from a place to another, which has no band. Whether it goes on from the last: if not,
    /// that and all before it are forgotten.
    pub fn push(&mut self, from: &[Coord; N], to: [Coord; N], band: S, feed: S) -> bool {
        let goes_on = self.list.back().is_some_and(|last| last.to == *from);
        if !goes_on {
            self.clear();
            self.start = *from;
        }
        if self.list.is_full()
            && let Some(passed) = self.list.pop_front()
        {
            self.start = passed.to;
            self.first = self.first.wrapping_add(1);
        }
        let _ = self.list.push_back(Course { to, band, feed });
        goes_on
    }

    /// Forgets the lines before a number.
    pub fn release_before(&mut self, number: u32) {
        for _ in 0..LINES {
            if self.first == number || self.index(number).is_none() {
                return;
            }
            if let Some(passed) = self.list.pop_front() {
                self.start = passed.to;
                self.first = self.first.wrapping_add(1);
            }
        }
    }

    fn index(&self, number: u32) -> Option<usize> {
        let ahead = number.wrapping_sub(self.first) as usize;
        (ahead < self.list.len()).then_some(ahead)
    }

    /// The first line of all that starts in a place; behind a number the only one.
    pub fn starting_at(&self, place: &[Coord; N], from: Option<u32>) -> Option<u32> {
        let first = from.and_then(|number| self.index(number)).unwrap_or(0);
        let mut found = (first..self.list.len()).filter_map(|i| {
            let start = if i == 0 { &self.start } else { &self.list.get(i - 1)?.to };
            (start == place).then(|| self.first.wrapping_add(i as u32))
        });
        let line = found.next()?;
        (from.is_none() || found.next().is_none()).then_some(line)
    }

    /// Lines from a number on about an origin, as many as cover a length, mm, from a place in the first on, and the next; with `rests` no
    /// further than to the last that ends there. `None` if they are not known for all of it.
    pub fn near(
        &self,
        (number, from): (u32, &[Coord; N]),
        origin: &[Coord; N],
        length: S,
        feed: S,
        rests: Option<&[Coord; N]>,
        list: &mut Vec<Line<S, N>, NEAR>,
    ) -> Option<()> {
        list.clear();
        let first = self.index(number)?;
        let mut start = if first == 0 { self.start } else { self.list.get(first - 1)?.to };
        let mut covered = S::ZERO;
        let mut end = None;
        let mut complete = false;
        for i in first..self.list.len() {
            let course = self.list.get(i)?;
            if !(course.band > S::ZERO) {
                break;
            }
            let way: [S; N] = core::array::from_fn(|k| course.to[k].minus(start[k]));
            let size = norm(&way);
            let direction = if size > S::ZERO { way.map(|x| x / size) } else { zero() };
            let line = Line {
                from: core::array::from_fn(|k| start[k].minus(origin[k])),
                direction,
                length: size,
                band: course.band,
                feed: course.feed * feed,
            };
            if i == first {
                let from = core::array::from_fn(|k| from[k].minus(origin[k]));
                covered = covered - line.distance(&from).1;
            }
            if list.push(line).is_err() {
                break;
            }
            if rests == Some(&course.to) {
                end = Some(list.len());
            }
            complete = covered > length || i + 1 == self.list.len();
            if covered > length {
                break;
            }
            covered += size;
            start = course.to;
        }
        match (rests, end) {
            (Some(_), Some(end)) => list.truncate(end),
            (Some(_), None) => return None,
            _ => {}
        }
        (!list.is_empty() && (complete || rests.is_some())).then_some(())
    }
}
