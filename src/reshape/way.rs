//! The lines of a path with their bands, and which of them a place lies in.

use super::vector::{along, dot, minus, square};
use crate::number::Scalar;

/// Lines that a motion may pass between two places.
pub(super) const MOST_LINES: usize = 64;

/// A line of the path, over all axes, about the window's origin.
#[derive(Clone, Copy, Debug)]
pub struct Line<S, const N: usize> {
    /// Start, mm.
    pub from: [S; N],
    /// Unit direction.
    pub direction: [S; N],
    /// mm.
    pub length: S,
    /// Half the width of its band, mm.
    pub band: S,
    /// Greatest speed on it, mm/s; what is at least [`Line::RAPID`] is none.
    pub feed: S,
}

/// A line and the place of it that is next to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot<S, const N: usize> {
    /// From that place to the point, mm.
    pub(super) off: [S; N],
    /// What is left of its square is the distance's, mm^2.
    pub(super) square: S,
}

impl<S: Scalar, const N: usize> Line<S, N> {
    /// A feed that is none, mm/s.
    pub const RAPID: f64 = 1.0e9;

    /// End, mm.
    pub(super) fn end(&self) -> [S; N] {
        along(&self.from, self.length, &self.direction)
    }

    /// Distance of a point from it, and where on it the place next to that lies, mm from its start.
    pub fn distance(&self, x: &[S; N]) -> (S, S) {
        let way = dot(&minus(x, &self.from), &self.direction).greatest(S::ZERO).least(self.length);
        (self.foot(x).square.sqrt(), way)
    }

    /// The place of it next to a point.
    pub(super) fn foot(&self, x: &[S; N]) -> Foot<S, N> {
        let off = minus(x, &self.from);
        let way = dot(&off, &self.direction).greatest(S::ZERO).least(self.length);
        let off = along(&off, -way, &self.direction);
        Foot { off, square: square(&off) }
    }
}

/// Where one line of the path follows the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint<'a, S, const N: usize> {
    /// mm.
    pub(super) at: &'a [S; N],
    /// Across the plane in which both lines are equally near.
    pub(super) across: [S; N],
}

impl<'a, S: Scalar, const N: usize> Joint<'a, S, N> {
    pub(super) fn new(before: &Line<S, N>, after: &'a Line<S, N>) -> Self {
        let across = along(&before.direction, S::ONE, &after.direction);
        Self { at: &after.from, across }
    }

    /// How far a point lies behind it, in a measure that is mm where the path goes straight on, times 2.
    pub(super) fn passed(&self, x: &[S; N]) -> S {
        dot(&minus(x, self.at), &self.across)
    }
}

/// Square of the sine of half the turn from one line to the next.
pub(super) fn turn<S: Scalar, const N: usize>(before: &Line<S, N>, after: &Line<S, N>) -> S {
    square(&minus(&after.direction, &before.direction)) * S::of(0.25)
}

/// The line in which a point is that comes after others in `line`.
pub(super) fn passes<S: Scalar, const N: usize>(
    lines: &[Line<S, N>],
    mut line: usize,
    x: &[S; N],
) -> usize {
    for _ in 0..MOST_LINES {
        let Some([before, after]) = lines.get(line..line + 2) else { break };
        if !(Joint::new(before, after).passed(x) > S::ZERO) {
            break;
        }
        line += 1;
    }
    line
}

/// Whether a point may be in one of two lines as well as in the other: all joints between them lie within the narrower band on either
/// side. Further from them, where the path folds back or lines are shorter than that, what lies between would be left out.
pub(super) fn are_one<S: Scalar, const N: usize>(
    lines: &[Line<S, N>],
    one: usize,
    other: usize,
    x: &[S; N],
) -> bool {
    let (first, last) = if one < other { (one, other) } else { (other, one) };
    last < lines.len()
        && (first..last).all(|line| {
            let near = lines[line].band.least(lines[line + 1].band);
            square(&minus(&lines[line].end(), x)) <= near * near
        })
}
