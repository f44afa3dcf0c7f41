//! Handing cells on: what is cut at the moment, one cell at a time.

#[cfg(feature = "shaping")]
use super::free::{self, Free};
use super::{Body, Builder, Front, Stage};
use crate::machine::Config;
use crate::number::{Interval, Length, Scalar};
use crate::path::blend::{self, Blend};
use crate::path::corner::Corner;
use crate::path::cut::{Cut, Emitted, dwell_part, dwell_time, next_cut, standstill};
use crate::path::half::Spot;
use crate::path::joint::{BentLengths, mean_node};
use crate::path::node::{Cell, Node};
use crate::path::queued::{Entrance, Joint, QueuedBlock};
use crate::path::transition::Transition;

/// Times as long as reckoned with that the cell behind a node that is passed may be: where two of them are left, they are halves.
const BENT_MOST: f64 = 1.06;

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    /// The next cell, if enough is known to cut it. `last` is the node the last one ended at.
    ///
    /// Cost: bounded; of what takes long, a part.
    pub fn emit(&mut self, last: &Node<S, N>, config: &Config<S, N>) -> Cut<S, N> {
        // Not in `cut`, whose frame is large.
        if self.take_chord(config) {
            return Cut::Working;
        }
        let cut = self.cut(last, config).unwrap_or(Cut::Nothing);
        #[cfg(feature = "outputs")]
        if matches!(cut, Cut::Cell(_)) {
            self.in_run = matches!(self.stage, Stage::Run { .. });
        }
        debug_assert!(!matches!(&cut, Cut::Cell(cell) if !cell.holds()), "a broken cell");
        // Blocks that have gone into a run have left room for more of a curve.
        if matches!(cut, Cut::Nothing) && self.chords.is_some() && !self.queue.is_full() {
            return Cut::Working;
        }
        cut
    }

    #[inline(never)]
    fn cut(&mut self, last: &Node<S, N>, config: &Config<S, N>) -> Option<Cut<S, N>> {
        // A finished stage leads to the next: body, joint, next block. Each turn of this loop
        // moves on by one of these, and a block has a body or a joint with cells, or is dropped.
        for _ in 0..4 * BLOCKS {
            if let Stage::Run { until } = self.stage
                && self.queue.front().is_some_and(QueuedBlock::only_moves)
            {
                // Before the front block is copied: most of what is done for a run does not need it.
                match self.run.next(last, self.rested, config.sweeps) {
                    Cut::Nothing => {}
                    cut => return Some(self.cut_run(cut, until)),
                }
            }
            let block = *self.queue.front()?;
            let Some(segment) = block.segment else {
                return Some(Cut::Cell(self.stand(last, block, config)));
            };
            if block.dwell > S::ZERO {
                if self.entrance.joint == Joint::Stop {
                    let tag = self.tag_at(0, S::ZERO);
                    return Some(Cut::Cell(self.stand(last, QueuedBlock { tag, ..block }, config)));
                }
                if let Some(front) = self.queue.front_mut() {
                    front.dwell = S::ZERO;
                }
                continue;
            }
            let front = Front { block, segment, entrance: self.entrance };
            match self.stage {
                Stage::Waiting => {
                    if !self.front_is_ready(config) {
                        return None;
                    }
                    self.start_front(&front, config);
                }
                Stage::Run { until } => {
                    if let Some(s) = until {
                        if !self.run.is_done() {
                            return None;
                        }
                        self.leave_run(&front.segment, s);
                    } else if !self.run.has_room() || !self.extend_run(&front, config) {
                        return None;
                    }
                }
                Stage::Body(body) if body.s < body.until => {
                    return Some(Cut::Cell(self.emit_body(&front, body, last, config)));
                }
                Stage::Body(body) if block.joint == Joint::Run => {
                    self.start_run(&front, body.s, config);
                }
                Stage::Body(_) => self.start_joint(&front, config),
                Stage::Corner { transition, at } if at.node < transition.cells() => {
                    return self
                        .emit_corner(&front, &transition, at, (last, config))
                        .map(Cut::Cell);
                }
                Stage::Blend { blend, index } if index < blend::CELLS => {
                    return self.emit_blend(&front, &blend, index, last).map(Cut::Cell);
                }
                Stage::Corner { .. } | Stage::Blend { .. } => self.next_block(config),
            }
        }
        None
    }

    /// The run, which ends `until` a place on the front segment if that is known, has been gone on with.
    #[inline]
    fn cut_run(&mut self, cut: Cut<S, N>, until: Option<Length>) -> Cut<S, N> {
        #[cfg(not(feature = "outputs"))]
        let _ = until;
        if let Cut::Cell(cell) = &cut {
            #[cfg(feature = "outputs")]
            match until {
                Some(s) if self.run.is_done() => self.meter.cut_to(s),
                _ => self.meter.cut_run(self.run.handed_to()),
            }
            self.rested = cell.rest;
        }
        cut
    }

    /// The next cell of the corner behind the front segment: one of the transition's, or a part of that up to where a piece of a line ends.
    #[inline(never)]
    fn emit_corner(
        &mut self,
        front: &Front<S, N>,
        transition: &Transition<S, N>,
        at: Spot<S>,
        (last, config): (&Node<S, N>, &Config<S, N>),
    ) -> Option<Emitted<S, N>> {
        let (cells, whole) = (transition.cells(), Spot::at(at.node + 1));
        let before = at.node < transition.middle();
        // Places on the legs are counted from the vertex, those on a segment from its start.
        let (item, origin) =
            if before { (0, front.segment.exact_length) } else { (1, Length::ZERO) };
        let [from, to] =
            [at, whole].map(|spot| origin + Length::from_mm(transition.foot(spot, before)));
        let mark = self.mark_beside(item, Interval { from, to }, config);
        let end = mark.map_or(whole, |(s, _)| transition.beside(at, (s - origin).to_mm()));
        self.stage = Stage::Corner { transition: *transition, at: end };
        let mut programmed = self.programmed_at(item, from.midpoint(to).to_mm())?;
        if let Some((_, tag)) = mark {
            programmed.tag = tag;
        }
        // A transition of the paper may begin where the path does, and end where it ends.
        let from = if self.rested { Node { at: last.at, ..transition.node(at) } } else { *last };
        let cell = transition.cell((at, end), &from, programmed);
        let next = self.queue.get(1).and_then(|next| next.segment)?;
        let node = transition.node(end);
        #[cfg(feature = "outputs")]
        {
            let inner = end.node < cells;
            let end = if inner { Length::from_mm(transition.along(end)) } else { self.given };
            self.meter_joint(front, end);
        }
        if end.node == cells && self.given >= next.exact_length {
            self.rested = true;
            return Some(Emitted { from, cell, node: Node { at: next.end, ..node }, rest: true });
        }
        Some(self.moving(from, cell, node))
    }

    /// The next cell of the blend behind the front segment.
    #[inline(never)]
    fn emit_blend(
        &mut self,
        front: &Front<S, N>,
        blend: &Blend<S, N>,
        index: u8,
        last: &Node<S, N>,
    ) -> Option<Emitted<S, N>> {
        self.stage = Stage::Blend { blend: *blend, index: index + 1 };
        let programmed = self.programmed_beside(index, front.segment.length)?;
        #[cfg(feature = "outputs")]
        {
            // Of either side by equal parts.
            let parts = i64::from(index) + 1 - i64::from(blend::CELLS / 2);
            let end = self.kept * 2 / i64::from(blend::CELLS) * parts;
            self.meter_joint(front, if index + 1 < blend::CELLS { end } else { self.given });
        }
        let from = if self.rested { blend.node(index) } else { *last };
        let cell = blend.cell(index, &from, programmed);
        Some(self.moving(from, cell, blend.node(index + 1)))
    }

    /// The joint behind the front segment is cut up to a place behind the end of that, or before it.
    #[cfg(feature = "outputs")]
    fn meter_joint(&mut self, front: &Front<S, N>, along: Length) {
        let whole = front.segment.exact_length;
        if along < Length::ZERO {
            self.meter.cut_to(whole + along);
        } else {
            self.meter.cut_beyond(whole, along);
        }
    }

    /// A cell that is passed.
    fn moving(&mut self, from: Node<S, N>, cell: Cell<S, N>, node: Node<S, N>) -> Emitted<S, N> {
        self.rested = false;
        Emitted { from, cell, node, rest: false }
    }

    /// As much of a standstill at the front as one cell may take.
    #[inline(never)]
    fn stand(
        &mut self,
        last: &Node<S, N>,
        block: QueuedBlock<S, N>,
        config: &Config<S, N>,
    ) -> Emitted<S, N> {
        let dwell = dwell_part(block.dwell, config.cycle);
        match self.queue.front_mut() {
            Some(front) if dwell < block.dwell => front.dwell = block.dwell - dwell,
            // It stands before it moves.
            Some(front) if front.segment.is_some() => front.dwell = S::ZERO,
            _ => {
                let _ = self.queue.pop_front();
                self.entrance = Entrance::rest(self.entrance.tolerance_before);
                #[cfg(feature = "outputs")]
                self.meter.cut_stand();
            }
        }
        self.rested = true;
        standstill(last, &QueuedBlock { dwell: dwell_time(dwell, config.cycle), ..block })
    }

    /// The next cell of the front segment's body.
    #[inline(never)]
    fn emit_body(
        &mut self,
        front: &Front<S, N>,
        body: Body<S>,
        last: &Node<S, N>,
        config: &Config<S, N>,
    ) -> Emitted<S, N> {
        // Where pieces end there are nodes as well, and the others stay where they are: written in
        // pieces, a line takes no longer.
        let goal = if body.next > body.s {
            body.next
        } else {
            let begins = front.entrance.taken;
            let goal = next_cut(&front.segment, (&front.block, begins), body.left(), body.ends);
            // What is bent behind a node that is passed is no longer than was reckoned with, however long the line is.
            let bent = front.entrance.joint == Joint::Through && body.s == begins;
            if bent && (goal - body.s).to_mm::<S>() > body.ends.first * S::of(BENT_MOST) {
                body.s + Length::from_mm(body.ends.first).max(Length::UNIT)
            } else {
                goal
            }
        };
        #[cfg(feature = "shaping")]
        let free = self.free(front, &body, config);
        #[cfg(feature = "shaping")]
        let goal = free.map_or(goal, |free| free.goal(body.s, goal));
        let (next, goal) = self.to_mark(front, body.left(), goal, config);
        self.stage = Stage::Body(Body { s: next, next: goal, ..body });
        #[cfg(feature = "outputs")]
        self.meter.cut_to(next);
        let entry = Node { at: last.at, ..front.segment.node(body.s) };
        let from = if self.rested { entry } else { *last };
        let piece = Interval { from: body.s, to: next };
        let mut cut = self.body_cell(front, (&from, &entry), piece, next >= body.until);
        cut.cell.programmed.tag = self.tag_at(0, body.s.midpoint(next).to_mm());
        #[cfg(feature = "shaping")]
        if cut.cell.straight && free.is_some_and(|free| free.holds(body.s, next)) {
            cut.cell.programmed.limits = cut.cell.programmed.limits.freed();
        }
        self.pass_marks(next);
        self.rested = cut.rest;
        cut
    }

    /// Where the front segment may be run by the axes' full limits.
    #[cfg(feature = "shaping")]
    fn free(&self, front: &Front<S, N>, body: &Body<S>, config: &Config<S, N>) -> Option<Free> {
        let direction = front.segment.end_frame().tangent;
        // What is known here are the newest limits.
        let newest = front.block.limits == self.limits;
        if !newest
            || !front.segment.is_line()
            || !config.bears_less(&direction, front.segment.length)
        {
            return None;
        }
        let next = self.queue.get(1);
        let ahead = next.and_then(|next| next.segment);
        let behind = ahead.map_or(direction, |ahead| ahead.start_frame().tangent);
        let alike = next.is_none_or(|next| next.limits == front.block.limits);
        let exit =
            free::beside(front.block.joint, (&direction, &behind), (self.kept, alike), config);
        Free::of(front, body, [self.entry, exit], config)
    }

    /// The cell over a piece of the front segment's body. `entry` is the segment's own node at its start,
    /// `from` the node of the path there, which may hold the mean direction of two segments.
    #[inline(never)]
    fn body_cell(
        &self,
        Front { block, segment, .. }: &Front<S, N>,
        (from, entry): (&Node<S, N>, &Node<S, N>),
        piece: Interval,
        at_end: bool,
    ) -> Emitted<S, N> {
        let mut cell = segment.cell(piece, block.programmed());
        let mut node = segment.node(piece.to);
        if at_end && block.joint == Joint::Through {
            let next = self.queue.get(1).and_then(|next| next.segment.as_ref());
            if let Some(next) = next {
                let lengths = BentLengths::new(segment.length, next.length);
                node = mean_node(node.at, &segment.end_frame(), &next.start_frame(), lengths);
            }
        }
        // A node that is simply passed has the mean tangent of both sides: the curve of the cell
        // bends by the little difference.
        for i in 0..N {
            cell.tangent_offset[i] += (entry.tangent[i] - from.tangent[i]) * cell.length;
            cell.straight &= node.tangent[i] == from.tangent[i] && from.curvature[i] == S::ZERO;
        }
        Emitted { from: *from, cell, node, rest: at_end && block.joint == Joint::Stop }
    }

    /// The body is done: on to the joint, or over it.
    #[inline(never)]
    fn start_joint(&mut self, Front { block, segment, .. }: &Front<S, N>, config: &Config<S, N>) {
        let ahead = self.queue.get(1).and_then(|next| next.segment);
        let Some(ahead) = ahead else {
            self.next_block(config);
            return;
        };
        let reach = self.kept.to_mm::<S>();
        match (block.joint, self.half) {
            (Joint::Corner, Some(half)) => {
                let (a, b) = (segment.end_frame().tangent, ahead.start_frame().tangent);
                let transition = Transition::new(segment.end, (&a, &b), &Corner::new(&a, &b), half);
                self.stage = Stage::Corner { transition, at: Spot::at(0) };
            }
            (Joint::Blend, _) => {
                self.stage = Stage::Blend { blend: Blend::new(segment, &ahead, reach), index: 0 };
            }
            _ => self.next_block(config),
        }
    }

    /// Drops the front block; the next one starts where its joint ended.
    #[inline(never)]
    pub(super) fn next_block(&mut self, config: &Config<S, N>) {
        let done = self.queue.pop_front();
        #[cfg(feature = "shaping")]
        {
            let frames = |done: &QueuedBlock<S, N>| {
                let next = self.queue.front()?.segment?;
                Some((done.segment?.end_frame().tangent, next.start_frame().tangent))
            };
            let alike = |done: &QueuedBlock<S, N>| {
                self.queue.front().is_some_and(|n| n.limits == done.limits)
            };
            let taken = (self.given, done.as_ref().is_some_and(alike));
            self.entry = match done.as_ref().and_then(|done| Some((done.joint, frames(done)?))) {
                Some((joint, (a, b))) => free::beside(joint, (&a, &b), taken, config),
                None => S::ZERO,
            };
        }
        #[cfg(not(feature = "shaping"))]
        let _ = config;
        #[cfg(feature = "outputs")]
        if let Some(segment) = done.as_ref().and_then(|done| done.segment.as_ref()) {
            self.meter.pass(segment.exact_length);
        }
        self.marks.drop_front(done.as_ref().map_or(0, |done| usize::from(done.marks)));
        self.entrance = match done {
            Some(QueuedBlock { joint, segment, tolerance, .. }) if !self.queue.is_empty() => {
                Entrance {
                    joint,
                    tolerance_before: Some(tolerance),
                    length_before: segment.map_or(S::ZERO, |segment| segment.length),
                    taken: self.given,
                }
            }
            Some(QueuedBlock { tolerance, .. }) => Entrance::rest(Some(tolerance)),
            None => Entrance::REST,
        };
        self.pass_marks(self.given);
        (self.kept, self.given) = (Length::ZERO, Length::ZERO);
        self.stage = Stage::Waiting;
    }
}
