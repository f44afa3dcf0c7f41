//! From blocks to the chain of nodes and cells: look-ahead over blocks, joints, and cutting.
//!
//! A joint needs to know both neighbours, and to share a leg by need also what the next joint
//! wants of it: so a block is held until two more have come, or until the path is closed.

use super::blend::{self, Blend};
use super::budget::Straightened;
use super::chords::Chords;
use super::corner::Corner;
use super::cut::{Emitted, dwell_part, next_cut, rest_cell, standstill};
use super::joint::{Taken, bent_lengths, corner_mode, joint, mean_node, reach};
use super::node::{Node, Programmed};
use super::queued::{Joint, QueuedBlock};
use super::run::{Run, Tie};
use super::segment::Segment;
use super::straight::{Mark, Marks, Sleeve};
use super::transition::{Half, Transition};
use crate::block::{Block, PushError};
use crate::machine::{Config, CornerMode, Ramp};
use crate::number::vector::{norm, sub};
use crate::number::{Coord, Length, Scalar};
use heapless::Deque;

/// Shortest piece whose tag is shown, as a share of the length over which the feed is reached: every piece
/// that is shown takes a node of the window.
const SHOWN_SHARE: f64 = 1.0 / 32.0;
/// Rounding of the turn between two lines, in units of the scalar's.
const TURN_ROUNDING: f64 = 16.0;
/// Least part of a cell that the end of a piece cuts off.
const PART_OF_CELL: i64 = 8;
/// Share of a line next to a joint that is simply passed which a run leaves alone.
const PASSED_SHARE: i64 = 4;

/// What is being cut at the moment.
#[derive(Clone, Copy)]
enum Stage<S, const N: usize> {
    /// Nothing: the front block waits.
    Waiting,
    /// The body of the front segment, up to `until`. The cell under s ends at `next`, unless a piece of the
    /// line ends before.
    Body { s: Length, next: Length, until: Length, first: S, last: S },
    /// A run of lines from the front segment on. Once its end is known, the front segment is its last
    /// line, which it leaves at `until`.
    Run { until: Option<Length> },
    /// The corner behind the front segment.
    Corner { transition: Transition<S, N>, index: u8 },
    /// The blend behind the front segment.
    Blend { blend: Blend<S, N>, index: u8 },
}

/// Length of the shortest piece of a line whose tag is shown, mm: a servo cycle at the feed at least.
fn least_piece<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    feed: S,
    config: &Config<S, N>,
) -> S {
    let ramp = Ramp::new(&config.limits, &segment.start_frame().tangent).length(feed);
    (feed * config.cycle).greatest(ramp * S::of(SHOWN_SHARE))
}

/// The look-ahead buffer over blocks.
pub struct Builder<S, const N: usize, const BLOCKS: usize> {
    queue: Deque<QueuedBlock<S, N>, BLOCKS>,
    /// The rest of a curve that has been accepted last.
    chords: Option<Chords<S, N>>,
    /// Where the last block, a line, may run on to.
    sleeve: Sleeve<N>,
    /// Marks of the queued lines, in order.
    marks: Marks<S, BLOCKS>,
    /// End of the last accepted block.
    end: [Coord; N],
    closed: bool,
    stage: Stage<S, N>,
    /// Length kept free of the front segment's end by the joint under s.
    kept: Length,
    /// Shape of that joint, if it is a corner.
    half: Option<Half<S>>,
    /// The run of lines under s.
    run: Run<S, N>,
    /// Place on the front segment from which on the run takes it.
    run_from: Length,
    /// Whether the last cell ended at rest, so that the direction may change.
    rested: bool,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    pub fn new(start: [Coord; N]) -> Self {
        const { assert!(BLOCKS >= 4, "a look-ahead of fewer than 4 blocks cannot share legs") };
        Self {
            queue: Deque::new(),
            chords: None,
            sleeve: Sleeve::NONE,
            marks: Marks::new(),
            end: start,
            closed: false,
            stage: Stage::Waiting,
            kept: Length::ZERO,
            half: None,
            run: Run::new(),
            run_from: Length::ZERO,
            rested: true,
        }
    }

    /// Forgets everything and starts anew at a point. (In place: a new one would take its size of stack.)
    pub fn restart(&mut self, start: [Coord; N]) {
        self.queue.clear();
        self.marks.clear();
        self.chords = None;
        self.end = start;
        self.closed = false;
        self.stage = Stage::Waiting;
        self.kept = Length::ZERO;
        self.half = None;
        self.run.clear();
        self.rested = true;
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
        let marked = self.marks.is_full() && self.queue.len() >= 3;
        self.queue.is_full() || self.chords.is_some() || marked
    }

    /// Takes a block, or leaves everything as it was.
    pub fn push(&mut self, block: &Block<S, N>, config: &Config<S, N>) -> Result<(), PushError> {
        self.feed(config);
        if self.is_full() {
            return Err(PushError::Full);
        }
        let reject = |reason| PushError::Rejected { tag: block.tag, reason };
        if let Some(chords) = Chords::new(self.end, block, config).map_err(reject)? {
            // The first chord is checked as the block is, by its feed; the others are what it is.
            self.take(&chords.line(), Some(chords.whole()), config)?;
            self.chords = chords.advanced();
            self.feed(config);
            return Ok(());
        }
        self.take(block, None, config)
    }

    /// Takes chords of the curve under s as long as there is room.
    fn feed(&mut self, config: &Config<S, N>) {
        for _ in 0..BLOCKS {
            let Some(chords) = self.chords else { return };
            if self.queue.is_full() {
                return;
            }
            // Cannot fail: its fields are those of the first, its end lies between control points.
            let _ = self.take(&chords.line(), Some(chords.whole()), config);
            self.chords = chords.advanced();
        }
    }

    /// Takes a block for which there is room, or leaves everything as it was. `whole` is the length of the
    /// curve that it is a part of, mm.
    fn take(
        &mut self,
        block: &Block<S, N>,
        whole: Option<S>,
        config: &Config<S, N>,
    ) -> Result<(), PushError> {
        let reject = |reason| PushError::Rejected { tag: block.tag, reason };
        let Some(item) = QueuedBlock::new(self.end, block, whole, config).map_err(reject)? else {
            // Zero length: nothing to do but to honour an exact stop.
            if block.exact_stop
                && let Some(last) = self.queue.back_mut()
            {
                last.stop_after = true;
            }
            return Ok(());
        };
        self.closed = false;
        if let Some(segment) = &item.segment {
            self.end = segment.end;
        }
        if self.take_as_part(&item, config) {
            return Ok(());
        }
        self.sleeve = match &item.segment {
            Some(segment) => Sleeve::of(&segment.start, &segment.end),
            None => Sleeve::NONE,
        };
        // The joint behind a block that is being cut has been decided, unless a run goes on.
        if (self.waits() || self.queue.len() > 1)
            && let Some(last) = self.queue.back_mut()
        {
            (last.joint, last.want) = joint(last, &item, config);
        }
        // Cannot fail: room was checked.
        let _ = self.queue.push_back(item);
        Ok(())
    }

    /// Whether the joint behind the front block has not been decided.
    fn waits(&self) -> bool {
        matches!(self.stage, Stage::Waiting | Stage::Run { until: None })
    }

    /// Whether the last block may still become longer; `exact`: without turning.
    fn last_is_open(&self, exact: bool) -> bool {
        let Some(front) = self.queue.front() else { return false };
        match (self.queue.len(), self.stage) {
            (1, Stage::Waiting) => {
                exact || (front.taken == Length::ZERO && front.entered == Joint::Stop)
            }
            (1, Stage::Run { until: None }) => exact || front.taken == Length::ZERO,
            (1, _) => false,
            // What the joint behind the front block takes of the last has been decided.
            (2, _) if !self.waits() => match front.joint {
                Joint::Stop | Joint::Run => true,
                Joint::Corner | Joint::Blend => exact,
                Joint::Through => false,
            },
            _ => true,
        }
    }

    /// Takes a line on to which the last one runs straight as a part of it. Returns whether it is one.
    fn take_as_part(&mut self, item: &QueuedBlock<S, N>, config: &Config<S, N>) -> bool {
        let Some((longer, sleeve, mark)) = self.longer(item, config) else { return false };
        if let Some(mark) = mark {
            self.marks.push(mark);
        }
        self.sleeve = sleeve;
        if let Some(last) = self.queue.back_mut() {
            *last = longer;
        }
        // The joint behind a block that is being cut has been decided, unless a run goes on.
        if let Some(n) = self.queue.len().checked_sub(2)
            && (n > 0 || self.waits())
            && let Some(before) = self.queue.get_mut(n)
        {
            (before.joint, before.want) = joint(before, &longer, config);
        }
        true
    }

    /// The last block with a line that runs straight on from it, and the mark between them, if that is
    /// to be shown. At equal feed, tolerance and kind only, where no stop is asked for.
    #[allow(clippy::type_complexity)]
    fn longer(
        &self,
        item: &QueuedBlock<S, N>,
        config: &Config<S, N>,
    ) -> Option<(QueuedBlock<S, N>, Sleeve<N>, Option<Mark<S>>)> {
        let last = self.queue.back().filter(|last| last.runs_on(item))?;
        let (before, after) = (last.segment.as_ref()?, item.segment.as_ref()?);
        let lines = before.is_line() && after.is_line() && config.corner == CornerMode::Band;
        if !lines {
            return None;
        }
        let shorter = before.length.least(after.length);
        let slack = Straightened::new(item.tolerance, shorter);
        // The vertex lies at least half the turn times the shorter line off the line past it. Most lines turn by
        // far more, and what follows is done in `f64`, which the target has no instructions for.
        let turn = norm(&sub(&after.start_frame().tangent, &before.end_frame().tangent));
        let least = S::of(2.0 * slack.rounded) / shorter;
        if turn > least + S::EPSILON * S::of(TURN_ROUNDING) {
            return None;
        }
        let (sleeve, error) =
            self.sleeve.extended(&before.start, &before.end, &after.end, slack)?;
        let exact = error <= slack.exact;
        if !self.last_is_open(exact) {
            return None;
        }
        let begun = match last.marks {
            0 => S::ZERO,
            _ => self.marks.get(self.marks.len().checked_sub(1)?)?.s,
        };
        let piece = before.length - begun;
        // Without room for a mark the piece is shown as a part of the next.
        let shown = last.tag != item.tag
            && piece >= least_piece(before, last.feed, config)
            && !self.marks.is_full();
        let off = if exact { 0.0 } else { error };
        let longer = QueuedBlock {
            segment: Some(Segment::line(before.start, after.end)?),
            feed: last.feed.least(item.feed),
            stop_after: item.stop_after,
            tag: item.tag,
            marks: last.marks + u16::from(shown),
            error: Straightened::taken(item.tolerance, S::of(off).greatest(last.error)),
            ..*last
        };
        Some((longer, sleeve, shown.then_some(Mark { s: before.length, tag: last.tag })))
    }

    /// No more blocks for now: the path ends, at rest, where the last block ends.
    pub fn close(&mut self) {
        self.closed = self.chords.is_none();
    }

    /// The next cell, if enough is known to cut it. `last` is the node the last one ended at.
    pub fn emit(&mut self, last: &Node<S, N>, config: &Config<S, N>) -> Option<Emitted<S, N>> {
        self.feed(config);
        // A finished stage leads to the next: body, joint, next block. Each turn of this loop
        // moves on by one of these, and a block has a body or a joint with cells, or is dropped.
        for _ in 0..4 * BLOCKS {
            let item = *self.queue.front()?;
            let Some(segment) = item.segment else {
                let dwell = dwell_part(item.dwell, config.cycle);
                match self.queue.front_mut() {
                    Some(front) if dwell < item.dwell => front.dwell = item.dwell - dwell,
                    _ => drop(self.queue.pop_front()),
                }
                self.rested = true;
                return Some(standstill(last, &QueuedBlock { dwell, ..item }));
            };
            match self.stage {
                Stage::Waiting => {
                    if !self.front_is_ready(config) {
                        return None;
                    }
                    self.start_front(&item, &segment, config);
                }
                Stage::Run { until } => {
                    if let Some(cut) = self.run.next(last, self.rested, config.sweeps) {
                        self.rested = cut.rest;
                        return Some(cut);
                    }
                    if let Some(s) = until {
                        if !self.run.is_done() {
                            return None;
                        }
                        self.leave_run(&segment, s);
                    } else if !self.run.has_room() || !self.extend_run((&item, &segment), config) {
                        return None;
                    }
                }
                Stage::Body { s, next, until, first, last: end } if s < until => {
                    // Where pieces end there are nodes as well, and the others stay where they are: written in
                    // pieces, a line takes no longer.
                    let goal = if next > s {
                        next
                    } else {
                        next_cut(&segment, &item, (s, until), (first, end))
                    };
                    let (next, goal) = self.to_mark((&item, &segment), (s, goal, until), config);
                    self.stage = Stage::Body { s: next, next: goal, until, first, last: end };
                    let entry = Node { at: last.at, ..segment.node(s) };
                    let from = if self.rested { entry } else { *last };
                    let mut cut =
                        self.body_cell(&item, &segment, (&from, &entry), (s, next), until);
                    cut.cell.programmed.tag = self.tag_at(0, s.midpoint(next).to_mm());
                    self.pass_marks(next);
                    self.rested = cut.rest;
                    return Some(cut);
                }
                Stage::Body { s, .. } if item.joint == Joint::Run => {
                    self.start_run((&item, &segment), s, config);
                }
                Stage::Body { .. } => self.start_joint(&item, &segment),
                Stage::Corner { transition, index } if index < transition.cells() => {
                    self.stage = Stage::Corner { transition, index: index + 1 };
                    let programmed =
                        self.programmed_beside(index, transition.cells(), segment.length)?;
                    let from = if self.rested { transition.node(index) } else { *last };
                    self.rested = false;
                    return Some(Emitted {
                        from,
                        cell: transition.cell(index, &from, programmed),
                        node: transition.node(index + 1),
                        rest: false,
                    });
                }
                Stage::Blend { blend, index } if index < blend::CELLS => {
                    self.stage = Stage::Blend { blend, index: index + 1 };
                    let programmed = self.programmed_beside(index, blend::CELLS, segment.length)?;
                    let from = if self.rested { blend.node(index) } else { *last };
                    self.rested = false;
                    return Some(Emitted {
                        from,
                        cell: blend.cell(index, &from, programmed),
                        node: blend.node(index + 1),
                        rest: false,
                    });
                }
                Stage::Corner { .. } | Stage::Blend { .. } => self.next_item(),
            }
        }
        None
    }

    /// What is asked of a cell of the joint behind the front block, of `cells` in all: in its first half
    /// by the front block, `length` mm long, at the place beside it, in the second by the next.
    fn programmed_beside(&self, index: u8, cells: u8, length: S) -> Option<Programmed<S>> {
        let per = self.kept.to_mm::<S>() / S::from_u32(u32::from(cells));
        // From the middle of the joint to the middle of the cell.
        let s = S::from_i64(2 * i64::from(index) + 1 - i64::from(cells)) * per;
        let (item, s) = if s < S::ZERO { (0, length + s) } else { (1, s) };
        Some(Programmed { tag: self.tag_at(item, s), ..self.queue.get(item)?.programmed() })
    }

    /// The tag at a place of the front block (0) or the next (1), mm from its start.
    fn tag_at(&self, item: usize, s: S) -> u32 {
        let count = |index: usize| self.queue.get(index).map_or(0, |item| usize::from(item.marks));
        let first = if item == 0 { 0 } else { count(0) };
        let marks = (first..first + count(item)).filter_map(|index| self.marks.get(index));
        let own = self.queue.get(item).map_or(0, |item| item.tag);
        marks.into_iter().find(|mark| mark.s > s).map_or(own, |mark| mark.tag)
    }

    /// Where a cell of the front block ends that would end at `next`, and where the next one would begin without
    /// what pieces end between: at the end of a piece if that is near, else at one before.
    fn to_mark(
        &self,
        (item, segment): (&QueuedBlock<S, N>, &Segment<S, N>),
        (s, next, until): (Length, Length, Length),
        config: &Config<S, N>,
    ) -> (Length, Length) {
        if item.marks == 0 {
            return (next, next);
        }
        // What is too short to be shown is no cell of its own, nor is a small part of one: in `f32` the motion
        // over a cell a hundred times as short as its neighbour is not found.
        let least = Length::from_mm(least_piece(segment, item.feed, config)) / 2;
        let near = least.max((next - s) / PART_OF_CELL);
        let count = usize::from(item.marks);
        let mut ends =
            (0..count).filter_map(|index| self.marks.get(index)).map(|m| Length::from_mm(m.s));
        match ends.find(|&at| at - s > near) {
            Some(at) if next - at > near => (at, next),
            Some(at) if at - next < near && next < until && until - at > near => (at, at),
            _ => (next, next),
        }
    }

    /// Forgets the marks of the front block up to a place on it.
    fn pass_marks(&mut self, s: Length) {
        let Some(front) = self.queue.front_mut() else { return };
        let passed = s.to_mm::<S>();
        while front.marks > 0 && self.marks.get(0).is_some_and(|mark| mark.s <= passed) {
            self.marks.drop_front(1);
            front.marks -= 1;
        }
    }

    /// Shows a run the marks of the front block, which it takes from `from` on to `until`.
    fn mark_run(&mut self, from: Length, until: Length) {
        let count = self.queue.front().map_or(0, |front| usize::from(front.marks));
        let origin = self.run.reach() - from;
        let mut begins = from;
        for mark in (0..count).filter_map(|index| self.marks.get(index)) {
            let ends = Length::from_mm(mark.s);
            if ends > from && begins < until {
                self.run.mark(origin + begins, origin + ends, mark.tag);
            }
            begins = ends.max(from);
        }
    }

    /// Whether the joint behind the front block can be decided.
    fn front_is_ready(&self, config: &Config<S, N>) -> bool {
        let Some(item) = self.queue.front() else { return false };
        if item.stop_after || self.queue.len() >= 3 {
            return true;
        }
        match self.queue.get(1) {
            None => self.closed,
            Some(next) => {
                self.closed
                    || next.stop_after
                    || next.segment.is_none()
                    || matches!(corner_mode(item, next, config.corner), CornerMode::Paper { .. })
            }
        }
    }

    /// Decides the joint behind the front block: how it is, and what it takes of the segment.
    fn decide(
        &mut self,
        item: &QueuedBlock<S, N>,
        segment: &Segment<S, N>,
        config: &Config<S, N>,
    ) -> Joint {
        let next = self.queue.get(1).copied();
        let mut joint = item.joint;
        let ahead = next.as_ref().and_then(|next| next.segment.as_ref());
        if item.stop_after || ahead.is_none() {
            joint = Joint::Stop;
        }
        let taken = match (joint, &next, ahead) {
            (Joint::Corner | Joint::Blend, Some(next), Some(ahead)) => {
                reach(item, segment, next, ahead, joint, config)
            }
            _ => Taken { length: Length::ZERO, half: None },
        };
        (self.kept, self.half) = (taken.length, taken.half);
        if matches!(joint, Joint::Corner | Joint::Blend) && self.kept <= Length::ZERO {
            joint = Joint::Stop;
            self.kept = Length::ZERO;
        }
        if let Some(front) = self.queue.front_mut() {
            front.joint = joint;
        }
        joint
    }

    /// Decides the joint behind the front block and starts on its body.
    fn start_front(
        &mut self,
        item: &QueuedBlock<S, N>,
        segment: &Segment<S, N>,
        config: &Config<S, N>,
    ) {
        let joint = self.decide(item, segment, config);
        if joint == Joint::Run {
            let mut until = item.taken;
            if item.entered == Joint::Through {
                until += segment.exact_length / PASSED_SHARE;
            }
            let first = (until - item.taken).to_mm();
            self.stage =
                Stage::Body { s: item.taken, next: Length::ZERO, until, first, last: first };
            return;
        }
        let until = segment.exact_length - self.kept;
        let ahead = self.queue.get(1).and_then(|next| next.segment.as_ref());
        let size = |joint: Joint, kept: Length, neighbour: S| match joint {
            Joint::Stop | Joint::Run => rest_cell(segment, item.feed, &config.limits),
            Joint::Through => bent_lengths(segment.length, neighbour).0,
            Joint::Corner | Joint::Blend => kept.to_mm::<S>() * S::of(0.5),
        };
        let first = size(item.entered, item.taken, item.length_before);
        let last = size(joint, self.kept, ahead.map_or(S::ZERO, |ahead| ahead.length));
        self.stage = Stage::Body { s: item.taken, next: Length::ZERO, until, first, last };
    }

    /// Starts a run `s` along the front segment.
    fn start_run(
        &mut self,
        (item, segment): (&QueuedBlock<S, N>, &Segment<S, N>),
        s: Length,
        config: &Config<S, N>,
    ) {
        let tie = if self.rested { Tie::Rest } else { Tie::Smooth };
        let ramp = Ramp::new(&config.limits, &segment.start_frame().tangent);
        let beside = Self::beside(item.entered, item.taken, segment);
        self.run.begin(segment.node(s).at, tie, item.leg(), (ramp, beside));
        self.run_from = s;
        self.stage = Stage::Run { until: None };
    }

    /// Length of a cell next to a joint that takes so much of a segment, mm: the motion is slow there.
    fn beside(joint: Joint, taken: Length, segment: &Segment<S, N>) -> S {
        match joint {
            Joint::Corner | Joint::Blend => taken.to_mm::<S>() * S::of(0.5),
            _ => segment.length,
        }
    }

    /// Takes the front block into the run, if its joint is known. Returns whether it was.
    fn extend_run(
        &mut self,
        (item, segment): (&QueuedBlock<S, N>, &Segment<S, N>),
        config: &Config<S, N>,
    ) -> bool {
        if !self.front_is_ready(config) {
            return false;
        }
        let joint = self.decide(item, segment, config);
        self.mark_run(self.run_from, segment.exact_length - self.kept);
        if joint == Joint::Run {
            self.run.push(segment.end, item.leg());
            self.run_from = Length::ZERO;
            self.next_item();
            self.stage = Stage::Run { until: None };
            return true;
        }
        let mut until = segment.exact_length - self.kept;
        if joint == Joint::Through {
            until -= segment.exact_length / PASSED_SHARE;
        }
        let tie = if joint == Joint::Stop { Tie::Rest } else { Tie::Smooth };
        let beside = Self::beside(joint, self.kept, segment);
        let mut leg = item.leg();
        leg.programmed.tag = self.tag_at(0, until.to_mm());
        self.run.finish(segment.node(until).at, leg, tie, beside);
        self.stage = Stage::Run { until: Some(until) };
        true
    }

    /// The run is done: on with the rest of its last line.
    fn leave_run(&mut self, segment: &Segment<S, N>, s: Length) {
        if let Some(front) = self.queue.front_mut() {
            front.taken = s;
        }
        self.pass_marks(s);
        let until = segment.exact_length - self.kept;
        let size = (until - s).to_mm();
        self.stage = Stage::Body { s, next: Length::ZERO, until, first: size, last: size };
    }

    /// One cell of the front segment's body. `entry` is the segment's own node at its start,
    /// `from` the node of the path there, which may hold the mean direction of two segments.
    fn body_cell(
        &self,
        item: &QueuedBlock<S, N>,
        segment: &Segment<S, N>,
        (from, entry): (&Node<S, N>, &Node<S, N>),
        s: (Length, Length),
        until: Length,
    ) -> Emitted<S, N> {
        let mut cell = segment.cell(s, item.programmed());
        let mut node = segment.node(s.1);
        let at_end = s.1 >= until;
        if at_end && item.joint == Joint::Through {
            let next = self.queue.get(1).and_then(|next| next.segment.as_ref());
            if let Some(next) = next {
                let lengths = bent_lengths(segment.length, next.length);
                let frames = (segment.end_frame(), next.start_frame());
                node = mean_node(node.at, &frames.0, &frames.1, lengths);
            }
        }
        // A node that is simply passed has the mean tangent of both sides: the curve of the cell
        // bends by the little difference.
        for i in 0..N {
            cell.tangent_offset[i] += (entry.tangent[i] - from.tangent[i]) * cell.length;
            cell.straight &= node.tangent[i] == from.tangent[i] && from.curvature[i] == S::ZERO;
        }
        Emitted { from: *from, cell, node, rest: at_end && item.joint == Joint::Stop }
    }

    /// The body is done: on to the joint, or over it.
    fn start_joint(&mut self, item: &QueuedBlock<S, N>, segment: &Segment<S, N>) {
        let ahead = self.queue.get(1).and_then(|next| next.segment);
        let Some(ahead) = ahead else {
            self.next_item();
            return;
        };
        let reach = self.kept.to_mm::<S>();
        match (item.joint, self.half) {
            (Joint::Corner, Some(half)) => {
                let (a, b) = (segment.end_frame().tangent, ahead.start_frame().tangent);
                let transition = Transition::new(segment.end, (&a, &b), &Corner::new(&a, &b), half);
                self.stage = Stage::Corner { transition, index: 0 };
            }
            (Joint::Blend, _) => {
                self.stage = Stage::Blend { blend: Blend::new(segment, &ahead, reach), index: 0 };
            }
            _ => self.next_item(),
        }
    }

    /// Drops the front block; the next one starts where its joint ended.
    fn next_item(&mut self) {
        let done = self.queue.pop_front();
        self.marks.drop_front(done.as_ref().map_or(0, |done| usize::from(done.marks)));
        if let (Some(done), Some(next)) = (done, self.queue.front_mut()) {
            next.taken = self.kept;
            next.entered = done.joint;
            next.length_before = done.segment.map_or(S::ZERO, |segment| segment.length);
        }
        self.pass_marks(self.kept);
        self.kept = Length::ZERO;
        self.stage = Stage::Waiting;
    }
}
