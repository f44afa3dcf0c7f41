//! Lines that run on straight become one: the sleeve that says whether they do, and the marks that keep
//! their tags.

use super::budget::Straightened;
use crate::number::{Coord, Interval, Length, Scalar};
use core::array::from_fn;

/// Shortest piece whose tag is shown, as a share of the length over which the feed is reached: every piece
/// that is shown takes a node of the window.
pub const SHOWN_SHARE: f64 = 1.0 / 32.0;
/// Part of a cell by which its end is moved to that of a piece.
pub const NEAR: i64 = 8;
/// Least part of a cell that the end of a piece cuts off at its beginning: a cell is up to about twice as long as the one before, and the end of a
/// piece that was too far behind that to be its end is not too near to be one of this.
pub const FIRST_PART: i64 = 2 * NEAR;
/// The same at the end of what is cut, which stays where it is.
pub const LAST_PART: i64 = 32;
/// Marks held per block of the look-ahead.
const PER_BLOCK: usize = 2;

/// Where a cell over an interval is cut, and what tag it shows before: at the first of the ends of pieces, in order, that leaves no part that is too small,
/// nor one shorter than `least`.
pub fn end_in(
    interval: Interval,
    least: Length,
    mut ends: impl Iterator<Item = (Length, u32)>,
) -> Option<(Length, u32)> {
    let [first, last] = least_parts(interval, least);
    ends.find(|(at, _)| *at - interval.from > first).filter(|(at, _)| interval.to - *at > last)
}

/// Whether a place cuts a cell over an interval.
pub fn cuts(interval: Interval, at: Length) -> bool {
    let [first, last] = least_parts(interval, Length::ZERO);
    at - interval.from > first && interval.to - at > last
}

/// The least parts that may be cut off a cell over an interval, at its beginning and its end.
fn least_parts(Interval { from, to }: Interval, least: Length) -> [Length; 2] {
    let whole = to - from;
    [least.max(whole / FIRST_PART), least.max(whole / LAST_PART)]
}

/// Least and greatest value of a component.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: f64,
    high: f64,
}

impl Bounds {
    const NONE: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };
}

/// All straight lines from a point that pass every vertex so far within what was allowed there.
///
/// The line to a new end is c(r) = s r over the distance r along a first direction; a vertex o at r
/// allows |o - s r| <= slack, which bounds every component of s from both sides. The bounds of all
/// vertices are kept, not the vertices: nothing adds up, however many there are.
///
/// There are two of them: of lines that are straight, and of lines whose vertices are rounded.
#[derive(Clone, Copy, Debug)]
pub struct Sleeve<const N: usize> {
    direction: [f64; N],
    /// Bounds of s.
    straight: [Bounds; N],
    rounded: [Bounds; N],
}

impl<const N: usize> Sleeve<N> {
    /// No line yet.
    const NONE: Self =
        Self { direction: [0.0; N], straight: [Bounds::NONE; N], rounded: [Bounds::NONE; N] };

    /// The sleeve of a line.
    pub fn of(start: &[Coord; N], end: &[Coord; N]) -> Self {
        let step: [f64; N] = from_fn(|i| end[i].minus(start[i]));
        let length = libm::sqrt(step.iter().map(|d| d * d).sum());
        if !(length > 0.0) {
            return Self::NONE;
        }
        Self { direction: step.map(|d| d / length), ..Self::NONE }
    }

    /// Taken on from `via`, the end so far, to `to`, with what the vertices may lie off the line from
    /// `start` to there, mm: less than `slack.exact`, or if that is not so `slack.rounded`. `None` if
    /// they lie farther off.
    pub fn extended(
        &self,
        start: &[Coord; N],
        via: &[Coord; N],
        to: &[Coord; N],
        slack: Straightened,
    ) -> Option<(Self, f64)> {
        let along = |offset: &[f64; N]| -> f64 {
            offset.iter().zip(&self.direction).map(|(x, d)| x * d).sum()
        };
        let here: [f64; N] = from_fn(|i| via[i].minus(start[i]));
        let there: [f64; N] = from_fn(|i| to[i].minus(start[i]));
        let (near, far) = (along(&here), along(&there));
        if !(near > 0.0 && far > near) {
            return None;
        }
        let inside = |bounds: &[Bounds; N]| {
            bounds
                .iter()
                .zip(there)
                .all(|(bounds, x)| x / far >= bounds.low && x / far <= bounds.high)
        };
        let straight = narrowed(&self.straight, (&here, near), slack.exact);
        let rounded = narrowed(&self.rounded, (&here, near), slack.rounded);
        let longer = Self { direction: self.direction, straight, rounded };
        if inside(&straight) {
            return Some((longer, slack.exact));
        }
        inside(&rounded).then_some((longer, slack.rounded))
    }
}

/// Bounds of s that a vertex leaves, `near` mm along the direction.
#[inline(never)]
fn narrowed<const N: usize>(
    bounds: &[Bounds; N],
    (vertex, near): (&[f64; N], f64),
    slack: f64,
) -> [Bounds; N] {
    let most = slack / libm::sqrt(N as f64);
    from_fn(|i| {
        let Bounds { low, high } = bounds[i];
        Bounds {
            low: low.max((vertex[i] - most) / near),
            high: high.min((vertex[i] + most) / near),
        }
    })
}

/// Where a piece of a line ends, and its tag.
#[derive(Clone, Copy, Debug)]
pub struct Mark<S> {
    /// Arc length from the start of the line, mm.
    pub s: S,
    pub tag: u32,
}

/// The marks of all lines of the look-ahead, in order.
pub struct Marks<S, const BLOCKS: usize> {
    slots: [[Mark<S>; PER_BLOCK]; BLOCKS],
    first: usize,
    len: usize,
}

impl<S: Scalar, const BLOCKS: usize> Marks<S, BLOCKS> {
    pub const fn new() -> Self {
        Self { slots: [[Mark { s: S::ZERO, tag: 0 }; PER_BLOCK]; BLOCKS], first: 0, len: 0 }
    }

    pub fn clear(&mut self) {
        self.len = 0;
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_full(&self) -> bool {
        self.len >= PER_BLOCK * BLOCKS
    }

    fn place(&self, index: usize) -> (usize, usize) {
        let at = (self.first + index) % (PER_BLOCK * BLOCKS).max(1);
        (at / PER_BLOCK, at % PER_BLOCK)
    }

    pub fn get(&self, index: usize) -> Option<Mark<S>> {
        let (row, column) = self.place(index);
        if index >= self.len { None } else { self.slots.get(row)?.get(column).copied() }
    }

    /// Adds one; there must be room.
    pub fn push(&mut self, mark: Mark<S>) {
        let (row, column) = self.place(self.len);
        if self.is_full() {
            return;
        }
        if let Some(slot) = self.slots.get_mut(row).and_then(|row| row.get_mut(column)) {
            *slot = mark;
            self.len += 1;
        }
    }

    /// Forgets the first `count`.
    pub fn drop_front(&mut self, count: usize) {
        let count = count.min(self.len);
        self.first = (self.first + count) % (PER_BLOCK * BLOCKS).max(1);
        self.len -= count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> [Coord; 2] {
        [x, y].map(|x| Coord::from_mm(x).unwrap())
    }

    /// How many of the points run on straight from the origin.
    fn taken(points: &[(f64, f64)], slack: f64) -> usize {
        let list: std::vec::Vec<_> = points.iter().map(|&(x, y)| at(x, y)).collect();
        let start = at(0.0, 0.0);
        let mut sleeve = Sleeve::of(&start, &list[0]);
        for (n, pair) in list.windows(2).enumerate() {
            match sleeve.extended(
                &start,
                &pair[0],
                &pair[1],
                Straightened { exact: 1.0e-6, rounded: slack },
            ) {
                Some((longer, _)) => sleeve = longer,
                None => return n + 1,
            }
        }
        list.len()
    }

    /// Rounding to three decimals, however many pieces there are; but no arc, and no way back.
    #[test]
    fn rounded_lines_are_straight_and_arcs_are_not() {
        let round = |x: f64| (x * 1000.0).round() / 1000.0;
        let line: std::vec::Vec<_> =
            (1..1000).map(|k| (round(0.731 * f64::from(k)), round(0.317 * f64::from(k)))).collect();
        assert_eq!(taken(&line, 0.0021), line.len());
        let exact: std::vec::Vec<_> =
            (1..1000).map(|k| (0.731 * f64::from(k), 0.317 * f64::from(k))).collect();
        assert_eq!(taken(&exact, 1.0e-6), exact.len());
        // A circle of 20 mm in chords of 0.5 mm.
        let arc: std::vec::Vec<_> = (1..100)
            .map(|k| 0.025 * f64::from(k))
            .map(|phi: f64| (20.0 * phi.sin(), 20.0 * (1.0 - phi.cos())))
            .collect();
        assert_eq!(taken(&arc, 0.001), 1);
        assert_eq!(taken(&[(1.0, 0.0), (0.5, 0.0)], 0.001), 1);
    }

    #[test]
    fn marks_come_out_in_order() {
        let mut marks = Marks::<f32, 4>::new();
        let mut next = 0;
        for n in 0..100u32 {
            marks.push(Mark { s: 0.0, tag: n });
            if marks.is_full() {
                marks.drop_front(7);
                next += 7;
            }
            assert_eq!(marks.get(0).unwrap().tag, next);
        }
        assert_eq!(marks.get(marks.len() - 1).unwrap().tag, 99);
        assert!(marks.get(marks.len()).is_none());
    }
}
