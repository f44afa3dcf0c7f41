//! From blocks to the chain of nodes and cells: look-ahead over blocks, joints, and cutting.
//!
//! A joint needs to know both neighbours, and to share a leg by need also what the next joint
//! wants of it: so a block is held until two more have come, or until the path is closed.

use super::blend::{self, Blend};
use super::chords::Chords;
use super::corner::Corner;
use super::cut::{Emitted, dwell_part, next_way, rest_cell, standstill};
use super::item::{Item, Joint};
use super::joint::{Taken, bent_lengths, corner_mode, joint, mean_node, reach};
use super::node::{Node, Order};
use super::run::{Run, Tie};
use super::segment::{Segment, raw_to_mm};
use super::transition::{Half, Transition};
use crate::block::{Block, PushError};
use crate::machine::{Config, CornerMode};
use crate::number::{Coord, Scalar};
use heapless::Deque;

/// Share of a line next to a joint that is simply passed which a run leaves alone.
const PASSED_SHARE: i64 = 4;

/// What is being cut at the moment.
#[derive(Clone, Copy)]
enum Stage<S, const N: usize> {
    /// Nothing: the front item waits.
    Waiting,
    /// The body of the front segment, up to `until`.
    Body { way: i64, until: i64, first: S, last: S },
    /// A run of lines from the front segment on. Once its end is known, the front segment is its last
    /// line, which it leaves at `until`.
    Run { until: Option<i64> },
    /// The corner behind the front segment.
    Corner { transition: Transition<S, N>, index: u8 },
    /// The blend behind the front segment.
    Blend { blend: Blend<S, N>, index: u8 },
}

/// The look-ahead buffer over blocks.
pub struct Builder<S, const N: usize, const BLOCKS: usize> {
    items: Deque<Item<S, N>, BLOCKS>,
    /// The rest of a curve that has been accepted last.
    chords: Option<Chords<S, N>>,
    /// End of the last accepted block.
    end: [Coord; N],
    closed: bool,
    stage: Stage<S, N>,
    /// Length kept free of the front segment's end by the joint under way, 1e-12 mm.
    kept: i64,
    /// Shape of that joint, if it is a corner.
    half: Option<Half<S>>,
    /// The run of lines under way.
    run: Run<S, N>,
    /// Whether the last cell ended at rest, so that the direction may change.
    rested: bool,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    pub fn new(start: [Coord; N]) -> Self {
        const { assert!(BLOCKS >= 4, "a look-ahead of fewer than 4 blocks cannot share legs") };
        Self {
            items: Deque::new(),
            chords: None,
            end: start,
            closed: false,
            stage: Stage::Waiting,
            kept: 0,
            half: None,
            run: Run::new(),
            rested: true,
        }
    }

    /// Forgets everything and starts anew at a point. (In place: a new one would take its size of stack.)
    pub fn restart(&mut self, start: [Coord; N]) {
        self.items.clear();
        self.chords = None;
        self.end = start;
        self.closed = false;
        self.stage = Stage::Waiting;
        self.kept = 0;
        self.half = None;
        self.run.clear();
        self.rested = true;
    }

    /// End point of the last accepted block.
    pub fn end(&self) -> &[Coord; N] {
        self.chords.as_ref().map_or(&self.end, Chords::end)
    }

    /// Blocks waiting.
    pub fn len(&self) -> usize {
        self.items.len() + usize::from(self.chords.is_some())
    }

    pub fn is_full(&self) -> bool {
        self.items.is_full() || self.chords.is_some()
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

    /// Takes chords of the curve under way as long as there is room.
    fn feed(&mut self, config: &Config<S, N>) {
        for _ in 0..BLOCKS {
            let Some(chords) = self.chords else { return };
            if self.items.is_full() {
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
        let Some(item) = Item::new(self.end, block, whole, config).map_err(reject)? else {
            // Zero length: nothing to do but to honour an exact stop.
            if block.exact_stop
                && let Some(last) = self.items.back_mut()
            {
                last.stop_after = true;
            }
            return Ok(());
        };
        self.closed = false;
        if let Some(segment) = &item.segment {
            self.end = segment.end;
        }
        // The joint behind a block that is being cut has been decided, unless a run goes on.
        let waits = matches!(self.stage, Stage::Waiting | Stage::Run { until: None });
        if (waits || self.items.len() > 1)
            && let Some(last) = self.items.back_mut()
        {
            (last.joint, last.want) = joint(last, &item, config.corner);
        }
        // Cannot fail: room was checked.
        let _ = self.items.push_back(item);
        Ok(())
    }

    /// No more blocks for now: the path ends, at rest, where the last block ends.
    pub fn close(&mut self) {
        self.closed = self.chords.is_none();
    }

    /// The next cell, if enough is known to cut it. `last` is the node the last one ended at.
    pub fn emit(&mut self, last: &Node<S, N>, config: &Config<S, N>) -> Option<Emitted<S, N>> {
        self.feed(config);
        // A finished stage leads to the next: body, joint, next item. Each turn of this loop
        // moves on by one of these, and an item has a body or a joint with cells, or is dropped.
        for _ in 0..4 * BLOCKS {
            let item = *self.items.front()?;
            let Some(segment) = item.segment else {
                let dwell = dwell_part(item.dwell, config.cycle);
                match self.items.front_mut() {
                    Some(front) if dwell < item.dwell => front.dwell = item.dwell - dwell,
                    _ => drop(self.items.pop_front()),
                }
                self.rested = true;
                return Some(standstill(last, &Item { dwell, ..item }));
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
                    if let Some(way) = until {
                        if !self.run.is_done() {
                            return None;
                        }
                        self.leave_run(&segment, way);
                    } else if !self.run.has_room() || !self.extend_run((&item, &segment), config) {
                        return None;
                    }
                }
                Stage::Body { way, until, first, last: end } if way < until => {
                    let next = next_way(&segment, &item, (way, until), (first, end));
                    self.stage = Stage::Body { way: next, until, first, last: end };
                    let entry = Node { at: last.at, ..segment.node(way) };
                    let from = if self.rested { entry } else { *last };
                    let cut = self.body_cell(&item, &segment, (&from, &entry), (way, next), until);
                    self.rested = cut.rest;
                    return Some(cut);
                }
                Stage::Body { way, .. } if item.joint == Joint::Run => {
                    self.start_run((&item, &segment), way, config);
                }
                Stage::Body { .. } => self.start_joint(&item, &segment),
                Stage::Corner { transition, index } if index < transition.cells() => {
                    self.stage = Stage::Corner { transition, index: index + 1 };
                    let order = self.order(transition.is_first_half(index))?;
                    let from = if self.rested { transition.node(index) } else { *last };
                    self.rested = false;
                    return Some(Emitted {
                        from,
                        cell: transition.cell(index, &from, order),
                        node: transition.node(index + 1),
                        rest: false,
                    });
                }
                Stage::Blend { blend, index } if index < blend::CELLS => {
                    self.stage = Stage::Blend { blend, index: index + 1 };
                    let order = self.order(2 * index < blend::CELLS)?;
                    let from = if self.rested { blend.node(index) } else { *last };
                    self.rested = false;
                    return Some(Emitted {
                        from,
                        cell: blend.cell(index, &from, order),
                        node: blend.node(index + 1),
                        rest: false,
                    });
                }
                Stage::Corner { .. } | Stage::Blend { .. } => self.next_item(),
            }
        }
        None
    }

    /// What the front item asks of its cells, or the one behind it.
    fn order(&self, front: bool) -> Option<Order<S>> {
        Some(self.items.get(usize::from(!front))?.order())
    }

    /// Whether the joint behind the front item can be decided.
    fn front_is_ready(&self, config: &Config<S, N>) -> bool {
        let Some(item) = self.items.front() else { return false };
        let runs_on = item.joint == Joint::Run && self.items.len() >= 2;
        if item.stop_after || runs_on || self.items.len() >= 3 {
            return true;
        }
        match self.items.get(1) {
            None => self.closed,
            Some(next) => {
                self.closed
                    || next.stop_after
                    || next.segment.is_none()
                    || matches!(corner_mode(item, next, config.corner), CornerMode::Paper { .. })
            }
        }
    }

    /// Decides the joint behind the front item: how it is, and what it takes of the segment.
    fn decide(
        &mut self,
        item: &Item<S, N>,
        segment: &Segment<S, N>,
        config: &Config<S, N>,
    ) -> Joint {
        let next = self.items.get(1).copied();
        let mut joint = item.joint;
        let ahead = next.as_ref().and_then(|next| next.segment.as_ref());
        if item.stop_after || ahead.is_none() {
            joint = Joint::Stop;
        }
        let taken = match (joint, &next, ahead) {
            (Joint::Corner | Joint::Blend, Some(next), Some(ahead)) => {
                reach(item, segment, next, ahead, joint, config)
            }
            _ => Taken { raw: 0, half: None },
        };
        (self.kept, self.half) = (taken.raw, taken.half);
        if matches!(joint, Joint::Corner | Joint::Blend) && self.kept <= 0 {
            joint = Joint::Stop;
            self.kept = 0;
        }
        if let Some(front) = self.items.front_mut() {
            front.joint = joint;
        }
        joint
    }

    /// Decides the joint behind the front item and starts on its body.
    fn start_front(&mut self, item: &Item<S, N>, segment: &Segment<S, N>, config: &Config<S, N>) {
        let joint = self.decide(item, segment, config);
        if joint == Joint::Run {
            let mut until = item.taken;
            if item.entered == Joint::Through {
                until += segment.length_raw / PASSED_SHARE;
            }
            let first = raw_to_mm(until - item.taken);
            self.stage = Stage::Body { way: item.taken, until, first, last: first };
            return;
        }
        let until = segment.length_raw - self.kept;
        let ahead = self.items.get(1).and_then(|next| next.segment.as_ref());
        let size = |joint: Joint, kept: i64, neighbour: S| match joint {
            Joint::Stop | Joint::Run => rest_cell(segment, item.feed, &config.limits),
            Joint::Through => bent_lengths(segment.length, neighbour).0,
            Joint::Corner | Joint::Blend => raw_to_mm::<S>(kept) * S::of(0.5),
        };
        let first = size(item.entered, item.taken, item.length_before);
        let last = size(joint, self.kept, ahead.map_or(S::ZERO, |ahead| ahead.length));
        self.stage = Stage::Body { way: item.taken, until, first, last };
    }

    /// Starts a run `way` along the front segment.
    fn start_run(
        &mut self,
        (item, segment): (&Item<S, N>, &Segment<S, N>),
        way: i64,
        config: &Config<S, N>,
    ) {
        let tie = if self.rested { Tie::Rest } else { Tie::Smooth };
        let rest_size = rest_cell(segment, item.feed, &config.limits);
        self.run.begin(segment.node(way).at, tie, item.leg(), rest_size);
        self.stage = Stage::Run { until: None };
    }

    /// Takes the front item into the run, if its joint is known. Returns whether it was.
    fn extend_run(
        &mut self,
        (item, segment): (&Item<S, N>, &Segment<S, N>),
        config: &Config<S, N>,
    ) -> bool {
        if !self.front_is_ready(config) {
            return false;
        }
        let joint = self.decide(item, segment, config);
        if joint == Joint::Run {
            self.run.push(segment.end, item.leg());
            self.next_item();
            self.stage = Stage::Run { until: None };
            return true;
        }
        let mut until = segment.length_raw - self.kept;
        if joint == Joint::Through {
            until -= segment.length_raw / PASSED_SHARE;
        }
        let tie = if joint == Joint::Stop { Tie::Rest } else { Tie::Smooth };
        self.run.finish(segment.node(until).at, item.leg(), tie);
        self.stage = Stage::Run { until: Some(until) };
        true
    }

    /// The run is done: on with the rest of its last line.
    fn leave_run(&mut self, segment: &Segment<S, N>, way: i64) {
        if let Some(front) = self.items.front_mut() {
            front.taken = way;
        }
        let until = segment.length_raw - self.kept;
        let size = raw_to_mm(until - way);
        self.stage = Stage::Body { way, until, first: size, last: size };
    }

    /// One cell of the front segment's body. `entry` is the segment's own node at its start,
    /// `from` the node of the path there, which may hold the mean direction of two segments.
    fn body_cell(
        &self,
        item: &Item<S, N>,
        segment: &Segment<S, N>,
        (from, entry): (&Node<S, N>, &Node<S, N>),
        way: (i64, i64),
        until: i64,
    ) -> Emitted<S, N> {
        let mut cell = segment.cell(way, item.order());
        let mut node = segment.node(way.1);
        let at_end = way.1 >= until;
        if at_end && item.joint == Joint::Through {
            let next = self.items.get(1).and_then(|next| next.segment.as_ref());
            if let Some(next) = next {
                let lengths = bent_lengths(segment.length, next.length);
                let frames = (segment.end_frame(true), next.end_frame(false));
                node = mean_node(node.at, &frames.0, &frames.1, lengths);
            }
        }
        // A node that is simply passed has the mean tangent of both sides: the curve of the cell
        // bends by the little difference.
        for i in 0..N {
            cell.bulge[i] += (entry.tangent[i] - from.tangent[i]) * cell.length;
            cell.straight &= node.tangent[i] == from.tangent[i] && from.curvature[i] == S::ZERO;
        }
        Emitted { from: *from, cell, node, rest: at_end && item.joint == Joint::Stop }
    }

    /// The body is done: on to the joint, or over it.
    fn start_joint(&mut self, item: &Item<S, N>, segment: &Segment<S, N>) {
        let ahead = self.items.get(1).and_then(|next| next.segment);
        let Some(ahead) = ahead else {
            self.next_item();
            return;
        };
        let reach = raw_to_mm::<S>(self.kept);
        match (item.joint, self.half) {
            (Joint::Corner, Some(half)) => {
                let (a, b) = (segment.end_frame(true).0, ahead.end_frame(false).0);
                let transition = Transition::new(segment.end, (&a, &b), &Corner::new(&a, &b), half);
                self.stage = Stage::Corner { transition, index: 0 };
            }
            (Joint::Blend, _) => {
                self.stage = Stage::Blend { blend: Blend::new(segment, &ahead, reach), index: 0 };
            }
            _ => self.next_item(),
        }
    }

    /// Drops the front item; the next one starts where its joint ended.
    fn next_item(&mut self) {
        let done = self.items.pop_front();
        if let (Some(done), Some(next)) = (done, self.items.front_mut()) {
            next.taken = self.kept;
            next.entered = done.joint;
            next.length_before = done.segment.map_or(S::ZERO, |segment| segment.length);
        }
        self.kept = 0;
        self.stage = Stage::Waiting;
    }
}
