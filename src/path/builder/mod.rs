//! From blocks to the chain of nodes and cells: look-ahead over blocks, joints, and cutting.
//!
//! A joint needs to know both neighbours, and to share a leg by need also what the next joint
//! wants of it: so a block is held until two more have come, or until the path is closed.
//!
//! [`intake`] takes blocks in; [`front`] decides how the first of them joins the next; [`emit`] cuts it into cells, which
//! show the [`tags`] of its lines. A `meter` tells outputs where blocks end.

mod emit;
#[cfg(feature = "shaping")]
mod free;
mod front;
mod intake;
#[cfg(feature = "outputs")]
pub(crate) mod meter;
mod tags;
#[cfg(test)]
mod tests;

use super::blend::Blend;
use super::chords::Chords;
use super::cut::EndSizes;
use super::half::{Half, Spot};
use super::joint;
use super::queued::{Entrance, QueuedBlock};
use super::run::Run;
use super::segment::Segment;
use super::straight::{Marks, Sleeve};
use super::transition::Transition;
use crate::machine::{Config, SetNumber};
use crate::number::optional::Optional;
use crate::number::{Coord, Interval, Length, Scalar};
use heapless::Deque;

/// With so many blocks in the look-ahead the joint behind the first can be decided, whatever the third is.
const ENOUGH: usize = 3;
/// A line that has become so many times as long as its next must be to go on from it may be cut before its end is known.
const CAPPED_LENGTHS: f64 = 2.0;

/// What is being cut at the moment.
#[derive(Clone, Copy)]
enum Stage<S, const N: usize> {
    /// Nothing: the front block waits.
    Waiting,
    /// The body of the front segment.
    Body(Body<S>),
    /// A run of lines from the front segment on. Once its end is known, the front segment is its last
    /// line, which it leaves at `until`.
    Run { until: Option<Length> },
    /// The corner behind the front segment, from a place on.
    Corner { transition: Transition<S, N>, at: Spot<S> },
    /// The blend behind the front segment.
    Blend { blend: Blend<S, N>, index: u8 },
}

/// What lies between the joints of the front segment.
#[derive(Clone, Copy)]
struct Body<S> {
    /// Where the next cell begins.
    s: Length,
    /// Where it ends, unless a piece of the line ends before; not behind `s` if that is open.
    next: Length,
    /// Where the body ends.
    until: Length,
    /// Lengths of its first and last cell.
    ends: EndSizes<S>,
}

impl<S> Body<S> {
    const fn new(s: Length, until: Length, ends: EndSizes<S>) -> Self {
        Self { s, next: Length::ZERO, until, ends }
    }

    /// What is not cut.
    const fn left(&self) -> Interval {
        Interval { from: self.s, to: self.until }
    }
}

/// The front block, which moves, and its segment.
struct Front<S, const N: usize> {
    block: QueuedBlock<S, N>,
    segment: Segment<S, N>,
    entrance: Entrance<S>,
}

/// The look-ahead buffer over blocks.
pub struct Builder<S, const N: usize, const BLOCKS: usize> {
    queue: Deque<QueuedBlock<S, N>, BLOCKS>,
    /// The rest of a curve that has been accepted last.
    chords: Optional<Chords<S, N>>,
    /// Where the last block may run on to, if lines have become one in it.
    sleeve: Optional<Sleeve<N>>,
    /// Marks of the queued lines, in order.
    marks: Marks<S, BLOCKS>,
    /// End of the last accepted block.
    end: [Coord; N],
    closed: bool,
    /// Whether the last block, a line, becomes no longer: what runs straight on from it is the next.
    capped: bool,
    /// Whether the motion is to rest exactly where a block ends (single block mode): as far as joints are decided from now on.
    single: bool,
    /// Which limits bound the blocks that are taken from now on.
    limits: SetNumber,
    /// Whether they bound one yet.
    #[cfg(feature = "limits")]
    limits_used: bool,
    stage: Stage<S, N>,
    /// How the front block is entered.
    entrance: Entrance<S>,
    /// Length kept free of the front segment's end by its joint to the next.
    kept: Length,
    /// Length that this joint takes of the next segment.
    given: Length,
    /// Shape of that joint, if it is a corner.
    half: Option<Half<S>>,
    /// The run of lines that is cut.
    run: Run<S, N>,
    /// Place on the front segment from which on the run takes it.
    run_from: Length,
    /// Whether the last block was one that is run alone.
    #[cfg(feature = "shaping")]
    after_alone: bool,
    /// Whether the last block was a standstill through which the machine rests.
    #[cfg(feature = "shaping")]
    stands: bool,
    /// Greatest speed at which the front segment is entered, mm/s.
    #[cfg(feature = "shaping")]
    entry: S,
    /// Whether the last cell ended at rest, so that the direction may change.
    rested: bool,
    #[cfg(feature = "outputs")]
    meter: meter::Meter,
    /// Whether the last cell is one of the run.
    #[cfg(feature = "outputs")]
    in_run: bool,
    /// Speed along the path that the last block asks for, whatever the axes allow, mm/s; `None` of a rapid.
    #[cfg(feature = "outputs")]
    asked: Option<S>,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    /// The memory of one: all zeros. It works from [`Builder::restart`] on.
    pub const EMPTY: Self = Self {
        queue: Deque::new(),
        chords: Optional::NONE,
        sleeve: Optional::NONE,
        marks: Marks::new(),
        end: [Coord::ZERO; N],
        closed: false,
        capped: false,
        single: false,
        limits: SetNumber::FIRST,
        #[cfg(feature = "limits")]
        limits_used: false,
        stage: Stage::Waiting,
        entrance: Entrance::REST,
        kept: Length::ZERO,
        given: Length::ZERO,
        half: None,
        run: Run::new(),
        run_from: Length::ZERO,
        #[cfg(feature = "shaping")]
        after_alone: false,
        #[cfg(feature = "shaping")]
        stands: false,
        #[cfg(feature = "shaping")]
        entry: S::ZERO,
        rested: false,
        #[cfg(feature = "outputs")]
        meter: meter::Meter::new(),
        #[cfg(feature = "outputs")]
        in_run: false,
        #[cfg(feature = "outputs")]
        asked: None,
    };

    /// Forgets everything and starts anew at a point. (In place: a new one would take its size of stack.)
    pub fn restart(&mut self, start: [Coord; N]) {
        const { assert!(BLOCKS >= 4, "a look-ahead of fewer than 4 blocks cannot share legs") };
        self.queue.clear();
        self.sleeve.set(None);
        self.marks.clear();
        self.chords.set(None);
        self.end = start;
        self.closed = false;
        self.capped = false;
        self.stage = Stage::Waiting;
        self.entrance = Entrance::REST;
        self.kept = Length::ZERO;
        self.given = Length::ZERO;
        self.half = None;
        self.run.clear();
        self.rested = true;
        #[cfg(feature = "shaping")]
        {
            (self.after_alone, self.stands) = (false, false);
            self.entry = S::ZERO;
        }
        #[cfg(feature = "outputs")]
        self.meter.clear();
    }

    /// End point of the last accepted block.
    pub fn end(&self) -> &[Coord; N] {
        self.chords.as_ref().map_or(&self.end, Chords::end)
    }

    /// Blocks waiting: of lines that have become one, those whose tags are kept.
    pub fn len(&self) -> usize {
        self.queue.len() + self.marks.len() + usize::from(self.chords.is_some())
    }

    pub fn is_full(&self) -> bool {
        // Of marks there is no more room before something is cut: which it will be, of three blocks.
        let marked = self.marks.is_full() && self.queue.len() >= ENOUGH;
        self.queue.is_full() || self.chords.is_some() || marked
    }

    /// No more blocks for now: the path ends, at rest, where the last block ends.
    pub fn close(&mut self) {
        self.closed = !self.chords.is_some();
    }

    /// The motion will soon need more of the path than is cut, and more comes slowly: a long line that is sent in pieces
    /// no longer keeps what waits for its end from being cut, nor a run what waits for a longer stretch of it.
    pub fn hurry(&mut self, config: &Config<S, N>) {
        if matches!(self.stage, Stage::Run { .. }) {
            self.run.hurry();
        }
        if self.queue.len() < ENOUGH
            && !self.capped
            && let Some(QueuedBlock { segment: Some(segment), tolerance, feed, .. }) =
                self.queue.back()
        {
            let slight = *tolerance > S::of(joint::LEAST_SLIGHT);
            let least = joint::goes_on_from(segment, *feed, config) * S::of(CAPPED_LENGTHS);
            self.capped = slight && segment.is_line() && segment.length >= least;
        }
    }

    /// Single block mode: whether joints that are not decided yet are exact stops, and lines stay as they are written.
    pub fn set_single(&mut self, single: bool) {
        self.single = single;
    }

    /// Which limits bound the blocks that are taken from now on, the whole of each.
    pub fn set_limits(&mut self, limits: SetNumber) {
        self.limits = limits;
        #[cfg(feature = "limits")]
        {
            self.limits_used = false;
        }
    }

    /// Whether a block has been taken with the limits that are set.
    #[cfg(feature = "limits")]
    pub fn uses_limits(&self) -> bool {
        self.limits_used
    }

    /// Whether a curve that has been taken is still being cut into blocks.
    #[cfg(feature = "limits")]
    pub fn takes_curve(&self) -> bool {
        self.chords.is_some()
    }

    /// Whether the motion rests between two blocks because single block mode asks for it. A block is all that has one tag:
    /// the chords of a curve, the moves of a cycle.
    fn parts(&self, before: &QueuedBlock<S, N>, after: &QueuedBlock<S, N>) -> bool {
        self.single && before.tag != after.tag
    }

    /// How far blocks go, and have been cut.
    #[cfg(feature = "outputs")]
    pub fn meter(&self) -> &meter::Meter {
        &self.meter
    }

    /// Share of the length of the last cell that lies before a share of the programmed path that it is made from.
    #[cfg(feature = "outputs")]
    pub fn share_before(&self, share: S) -> S {
        if self.in_run { self.run.share_before(share) } else { share }
    }

    /// Speed along the path that the block taken last asks for, whatever the axes allow, mm/s; `None` of a rapid.
    #[cfg(feature = "outputs")]
    pub fn asked(&self) -> Option<S> {
        self.asked
    }

    /// Whether the end of the last block is known: of a curve not before all of it has been taken.
    #[cfg(feature = "outputs")]
    pub fn knows_end(&self) -> bool {
        !self.chords.is_some()
    }

    /// Whether the joint behind the front block has not been decided.
    fn waits(&self) -> bool {
        matches!(self.stage, Stage::Waiting | Stage::Run { until: None })
    }
}
