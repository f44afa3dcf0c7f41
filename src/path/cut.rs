//! Where a segment is cut into cells.

use super::node::{Cell, Node};
use super::queued::{Joint, QueuedBlock};
use super::segment::Segment;
use crate::machine::{LEAST_CYCLE_SHARE, Limits, Ramp};
use crate::number::vector::{norm, zero};
use crate::number::{Interval, Length, Scalar};

/// Longest time one cell may take at the programmed feed, s. (Half or twice: nothing.)
pub const LONGEST_CELL_TIME: f64 = 0.25;
/// Each cell of a line may be longer than the one before by this share of the distance from the end. (Half: 0.2 % shorter
/// on bench paths, but 13 to 32 % more cells; twice: 1.3 % longer.)
const GROWTH: f64 = 0.5;
/// What is left is one piece up to so many times the length of a piece: a rest of rounding is none.
const REST: f64 = 1.0001;
/// It is two equal pieces below so many times that length: the second would else be a tenth of the first, or less.
/// (1.5: no path by more than 0.4 %; 3: 0.4 % longer.)
const HALVED: f64 = 2.1;

/// What asking for the next cell comes to.
pub enum Cut<S, const N: usize> {
    /// The cell.
    Cell(Emitted<S, N>),
    /// It is not known yet, but nearer than it was: ask again. Work that takes long is done in parts.
    Working,
    /// It is not known before more of the path is.
    Nothing,
}

/// A cell, the nodes it starts and ends at, and whether the motion rests at the end.
pub struct Emitted<S, const N: usize> {
    /// The node it starts at: the end of the last one, but after a stop with the direction in
    /// which the motion goes on.
    pub from: Node<S, N>,
    pub cell: Cell<S, N>,
    pub node: Node<S, N>,
    pub rest: bool,
}

impl<S: Scalar, const N: usize> Emitted<S, N> {
    /// What every cell keeps to, whoever made it: it moves or stands still, and at both ends it has a direction of unit
    /// length. Beyond the path a broken one would be a motion that nobody has asked for.
    pub fn holds(&self) -> bool {
        let unit = |node: &Node<S, N>| (norm(&node.tangent) - S::ONE).abs() <= S::of(UNIT_SLACK);
        let Cell { length, dwell, .. } = self.cell;
        if !(length > S::ZERO) {
            return length == S::ZERO && dwell > S::ZERO && self.rest && self.cell.straight;
        }
        dwell == S::ZERO && length.is_finite() && unit(&self.from) && unit(&self.node)
    }
}

/// What rounding may take of a unit vector.
const UNIT_SLACK: f64 = 1.0e-5;

/// Most servo cycles of a standstill in one cell: they are counted exactly, in `f32` too.
const MOST_DWELL_CYCLES: f64 = 1_048_576.0;
/// Halvings of 2^20 s down to a dwell of that many of the shortest cycles.
const HALVINGS: u32 = 20;

/// How long, s, the motion stands where a dwell asks for less than a cell takes.
pub fn dwell_time<S: Scalar>(dwell: S, cycle: S) -> S {
    dwell.greatest(cycle * S::of(LEAST_CYCLE_SHARE))
}

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
#[inline(never)]
pub fn rest_cell<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    feed: S,
    limits: &Limits<S, N>,
) -> S {
    Ramp::new(limits, &segment.start_frame().tangent).first_cell(feed)
}

/// Lengths of the pieces at the ends of a length that is cut, mm: they grow with the distance from there, as speed does.
#[derive(Clone, Copy)]
pub struct EndSizes<S> {
    pub first: S,
    pub last: S,
}

/// The next of the pieces that a length is cut into.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum NextPiece<S> {
    /// All that is left.
    Rest,
    /// Half of what is left.
    Half,
    /// So much, mm.
    Length(S),
}

/// The next piece of a length of which `done` mm lie behind and `left` mm ahead; `longest` mm at most.
pub fn next_piece<S: Scalar>(done: S, left: S, ends: EndSizes<S>, longest: S) -> NextPiece<S> {
    let growth = S::of(GROWTH);
    let forward = ends.first.greatest(growth * done);
    let backward = ends.last.greatest(left * S::of(GROWTH / (1.0 + GROWTH)));
    let step = forward.least(backward).least(longest);
    if left <= step * S::of(REST) {
        NextPiece::Rest
    } else if left < step * S::of(HALVED) {
        NextPiece::Half
    } else {
        NextPiece::Length(step)
    }
}

/// The node at which the next cell of a body ends, which begins at `begins` and of which the interval is uncut, by its arc length
/// along the segment.
pub fn next_cut<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    (block, begins): (&QueuedBlock<S, N>, Length),
    Interval { from: s, to: until }: Interval,
    ends: EndSizes<S>,
) -> Length {
    let done = (s - begins).to_mm::<S>();
    let left = (until - s).to_mm::<S>();
    let longest =
        segment.longest_cell(block.tolerance).least(block.feed * S::of(LONGEST_CELL_TIME));
    match next_piece(done, left, ends, longest) {
        // From rest to rest there must be a node between.
        NextPiece::Rest if !(s == begins && block.joint == Joint::Stop) => until,
        NextPiece::Rest | NextPiece::Half => s + (until - s + Length::UNIT) / 2,
        NextPiece::Length(step) => {
            // At least a thousandth of what is left of a line, so that the count of cells is bounded. On
            // an arc the band has the last word.
            let least = if segment.is_line() { (until - s) / 1024 } else { Length::ZERO };
            s + Length::from_mm(step).max(least).max(Length::UNIT)
        }
    }
}
