//! Where a segment is cut into cells.

use super::node::{Cell, Node};
use super::queued::{Joint, QueuedBlock};
use super::segment::Segment;
use crate::machine::{Limits, Ramp};
use crate::number::vector::zero;
use crate::number::{Length, Scalar};

/// Longest time one cell may take at the programmed feed, s.
pub const LONGEST_CELL_TIME: f64 = 0.25;
/// Each cell of a line may be longer than the one before by this share of the distance from the end.
const GROWTH: f64 = 0.5;

/// A cell, the nodes it starts and ends at, and whether the motion rests at the end.
pub struct Emitted<S, const N: usize> {
    /// The node it starts at: the end of the last one, but after a stop with the direction in
    /// which the motion goes on.
    pub from: Node<S, N>,
    pub cell: Cell<S, N>,
    pub node: Node<S, N>,
    pub rest: bool,
}

/// Most servo cycles of a standstill in one cell: they are counted exactly, in `f32` too.
const MOST_DWELL_CYCLES: f64 = 1_048_576.0;
/// Halvings of 2^20 s down to a dwell of that many of the shortest cycles.
const HALVINGS: u32 = 20;

/// The part of a dwell, s, that goes into one cell: a power of two, so that what is left is exact.
pub fn dwell_part<S: Scalar>(dwell: S, cycle: S) -> S {
    let most = cycle * S::of(MOST_DWELL_CYCLES);
    let mut part = S::of(MOST_DWELL_CYCLES);
    for _ in 0..HALVINGS {
        if part > most {
            part = part * S::of(0.5);
        }
    }
    dwell.least(part)
}

/// A cell without length, for a standstill.
pub fn standstill<S: Scalar, const N: usize>(
    from: &Node<S, N>,
    item: &QueuedBlock<S, N>,
) -> Emitted<S, N> {
    Emitted {
        from: *from,
        cell: Cell {
            length: S::ZERO,
            tangent_offset: zero(),
            programmed: item.programmed(),
            dwell: item.dwell,
            event: item.event,
            straight: true,
        },
        node: *from,
        rest: true,
    }
}

/// Length of the first cell from rest, mm.
pub fn rest_cell<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    feed: S,
    limits: &Limits<S, N>,
) -> S {
    Ramp::new(limits, &segment.start_frame().tangent).first_cell(feed)
}

/// Length of the next of the pieces that a length is cut into, mm: `done` lies behind, `left` ahead,
/// pieces next to the ends are `first` and `last` mm long and grow with the distance from there, as
/// speed does, to `longest` at most. `None` where less than two pieces would be left.
pub fn next_piece<S: Scalar>(
    (done, left): (S, S),
    (first, last): (S, S),
    longest: S,
) -> (S, Remainder) {
    let growth = S::of(GROWTH);
    let forward = first.greatest(growth * done);
    let backward = last.greatest(left * S::of(GROWTH / (1.0 + GROWTH)));
    let step = forward.least(backward).least(longest);
    let remainder = if left <= step * S::of(1.0001) {
        Remainder::One
    } else if left < step * S::of(2.1) {
        Remainder::Two
    } else {
        Remainder::More
    };
    (step, remainder)
}

/// How many pieces are left.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Remainder {
    One,
    /// Two, of equal length.
    Two,
    More,
}

/// The node at which the next cell of a body ends, by its arc length along the segment.
pub fn next_cut<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    item: &QueuedBlock<S, N>,
    (s, until): (Length, Length),
    ends: (S, S),
) -> Length {
    let done = (s - item.taken).to_mm::<S>();
    let left = (until - s).to_mm::<S>();
    let longest = segment.longest_cell(item.tolerance).least(item.feed * S::of(LONGEST_CELL_TIME));
    match next_piece((done, left), ends, longest) {
        // From rest to rest there must be a node between.
        (_, Remainder::One) if !(s == item.taken && item.joint == Joint::Stop) => until,
        (_, Remainder::One | Remainder::Two) => s + (until - s + Length::UNIT) / 2,
        (step, Remainder::More) => {
            // At least a thousandth of what is left of a line, so that the count of cells is bounded. On
            // an arc the band has the last word.
            let least = if segment.is_line() { (until - s) / 1024 } else { Length::ZERO };
            s + Length::from_mm(step).max(least).max(Length::UNIT)
        }
    }
}
