//! From blocks to the chain of nodes and cells: look-ahead over blocks, joints, and cutting.
//!
//! A joint needs to know both neighbours, and to share a leg by need also what the next joint
//! wants of it: so a block is held until two more have come, or until the path is closed.

use super::blend::{self, Blend};
use super::corner::{Corner, Transition};
use super::node::{Cell, Node};
use super::segment::{Segment, Shape, mm_to_raw, raw_to_mm};
use crate::block::{Block, BlockError, Feed, Field, Motion, PushError};
use crate::machine::{Config, CornerMode, Limits};
use crate::number::vector::{dot, norm, zero};
use crate::number::{Coord, Scalar};
use core::array::from_fn;
use heapless::Deque;

/// Cosine of the turn (160 degrees) beyond which a joint is an exact stop: there a stop is faster
/// than the rounding.
const STOP_COSINE: f64 = -0.94;
/// Turn, rad, up to which a joint is simply passed, however tight the tolerance.
const STRAIGHT: f64 = 1.0e-6;
/// Turn, rad, up to which a joint may be passed if the tolerance allows.
const SLIGHT_TURN: f64 = 0.4;
/// Longest time one cell may take at the programmed feed, s.
const LONGEST_CELL_TIME: f64 = 0.25;
/// Each cell of a line may be longer than the one before by this share of the way from the end.
const GROWTH: f64 = 0.8;

/// Most vertices merged into one line.
const MERGED: usize = 16;
/// Lines are merged only if the new one takes less than this at its feed, s, and both together
/// twice as much.
const MERGE_TIME: f64 = 0.01;
/// Share of the tolerance that merging may take.
const MERGE_SHARE: f64 = 0.15;
/// Least cosine of the turn between lines that are merged.
const MERGE_COSINE: f64 = 0.7;

/// How two segments meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Joint {
    /// At rest.
    Stop,
    /// Through the common point: tangents (and curvatures) agree.
    Through,
    /// B-spline corner between lines.
    Corner,
    /// Quintic blend where an arc takes part.
    Blend,
}

/// A block that waits for its neighbours.
#[derive(Clone, Copy, Debug)]
struct Item<S, const N: usize> {
    /// `None` for a dwell.
    segment: Option<Segment<S, N>>,
    dwell: S,
    feed: S,
    /// Tolerance as programmed.
    programmed: S,
    /// What is left of it for corners and passed joints.
    tolerance: S,
    stop_after: bool,
    tag: u32,
    /// Joint to the next item, once that is known.
    joint: Joint,
    /// Length the joint would like of either segment, 1e-12 mm.
    want: i64,
    /// Joint through which it was entered.
    entered: Joint,
    /// Length of the segment before that joint, mm.
    length_before: S,
    /// Length that joint has taken, 1e-12 mm.
    taken: i64,
}

/// Tangent and curvature.
type Frame<S, const N: usize> = ([S; N], [S; N]);

/// What is being cut at the moment.
#[derive(Clone, Copy)]
enum Stage<S, const N: usize> {
    /// Nothing: the front item waits.
    Waiting,
    /// The body of the front segment, up to `until`.
    Body { way: i64, until: i64, first: S, last: S },
    /// The corner behind the front segment.
    Corner { transition: Transition<S, N>, index: u8 },
    /// The blend behind the front segment.
    Blend { blend: Blend<S, N>, index: u8 },
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

/// The look-ahead buffer over blocks.
pub struct Builder<S, const N: usize, const BLOCKS: usize> {
    items: Deque<Item<S, N>, BLOCKS>,
    /// End of the last accepted block.
    end: [Coord; N],
    closed: bool,
    stage: Stage<S, N>,
    /// Length kept free of the front segment's end by the joint under way, 1e-12 mm.
    kept: i64,
    /// Vertices that the last block has merged.
    passed: heapless::Vec<[Coord; N], MERGED>,
    /// Whether the last cell ended at rest, so that the direction may change.
    rested: bool,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    pub fn new(start: [Coord; N]) -> Self {
        const { assert!(BLOCKS >= 4, "a look-ahead of fewer than 4 blocks cannot share legs") };
        Self {
            items: Deque::new(),
            end: start,
            closed: false,
            stage: Stage::Waiting,
            kept: 0,
            passed: heapless::Vec::new(),
            rested: true,
        }
    }

    /// End point of the last accepted block.
    pub fn end(&self) -> &[Coord; N] {
        &self.end
    }

    /// Blocks waiting.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    pub fn is_full(&self) -> bool {
        self.items.is_full()
    }

    /// Takes a block, or leaves everything as it was.
    pub fn push(&mut self, block: &Block<S, N>, config: &Config<S, N>) -> Result<(), PushError> {
        if self.items.is_full() {
            return Err(PushError::Full);
        }
        let reject = |reason| PushError::Rejected { tag: block.tag, reason };
        let Some(item) = self.checked(block, config).map_err(reject)? else {
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
            if self.merge(&item, segment, config) {
                return Ok(());
            }
        }
        self.passed.clear();
        if let Some(last) = self.items.back_mut() {
            (last.joint, last.want) = joint(last, &item, config.corner);
        }
        // Cannot fail: room was checked.
        let _ = self.items.push_back(item);
        Ok(())
    }

    fn checked(
        &self,
        block: &Block<S, N>,
        config: &Config<S, N>,
    ) -> Result<Option<Item<S, N>>, BlockError> {
        let tolerance = block.tolerance.unwrap_or(config.tolerance);
        in_range(Field::Tolerance, tolerance, 0.0, 1.0e3)?;
        match block.feed {
            Feed::PerSecond(feed) => in_range(Field::Feed, feed, 1.0e-9, 1.0e6)?,
            Feed::Duration(seconds) => in_range(Field::Duration, seconds, 1.0e-6, 1.0e6)?,
            Feed::Rapid => {}
        }
        let mut item = Item {
            segment: None,
            dwell: S::ZERO,
            feed: S::ONE,
            programmed: tolerance,
            tolerance,
            stop_after: block.exact_stop,
            tag: block.tag,
            joint: Joint::Stop,
            want: 0,
            entered: Joint::Stop,
            length_before: S::ZERO,
            taken: 0,
        };
        let segment = match block.motion {
            Motion::Dwell { seconds } => {
                in_range(Field::Dwell, seconds, 0.0, 1.0e6)?;
                item.dwell = seconds;
                item.stop_after = true;
                return Ok((seconds > S::ZERO).then_some(item));
            }
            Motion::Line { to } => {
                check_coordinates(&to)?;
                Segment::line(self.end, to)
            }
            Motion::Arc { to, plane, centre, turn, extra_turns } => {
                check_coordinates(&to)?;
                Segment::arc(self.end, to, plane, centre, turn, extra_turns)?
            }
        };
        let Some(segment) = segment else { return Ok(None) };
        item.feed = path_speed(&segment, block.feed, &config.limits);
        item.segment = Some(segment);
        Ok(Some(item))
    }

    /// Makes one line of the last block and a short one that goes on from it, if the vertices in
    /// between stay within [`MERGE_SHARE`] of the tolerance. Returns whether it did.
    ///
    /// Dense programs would fill the window with a few millimetres of path otherwise. What merging
    /// takes of the band is taken off the tolerance that corners and passed joints may use.
    fn merge(&mut self, item: &Item<S, N>, segment: &Segment<S, N>, config: &Config<S, N>) -> bool {
        let back = self.items.len().wrapping_sub(1);
        // What is being cut, and what its joint leads to, must stay.
        let fixed = if matches!(self.stage, Stage::Waiting) { 0 } else { 2 };
        if self.items.is_empty()
            || back < fixed
            || config.corner != CornerMode::Band
            || self.passed.is_full()
        {
            return false;
        }
        let Some(last) = self.items.get(back) else { return false };
        let Some(before) = &last.segment else { return false };
        // Equal but for the rounding of directions.
        let same_feed = (last.feed - item.feed).abs() <= item.feed * S::of(1.0e-3);
        let alike = same_feed && last.programmed == item.programmed && !last.stop_after;
        let (Shape::Line(a), Shape::Line(b)) = (&before.shape, &segment.shape) else {
            return false;
        };
        let short = segment.length < item.feed * S::of(MERGE_TIME)
            && before.length + segment.length < item.feed * S::of(2.0 * MERGE_TIME);
        if !(alike && short && dot(a, b) > S::of(MERGE_COSINE)) {
            return false;
        }
        let Some(whole) = Segment::line(before.start, segment.end) else { return false };
        let Shape::Line(tangent) = &whole.shape else { return false };
        let most = item.programmed * S::of(MERGE_SHARE);
        let mut along = S::ZERO;
        for vertex in self.passed.iter().chain(core::iter::once(&before.end)) {
            let way: [S; N] = from_fn(|i| vertex[i].minus(before.start[i]));
            let on = dot(&way, tangent);
            let off: [S; N] = from_fn(|i| way[i] - on * tangent[i]);
            // In order along the line, so that every point of it has one of the path beside it.
            if on < along || on > whole.length || norm(&off) > most {
                return false;
            }
            along = on;
        }
        let _ = self.passed.push(before.end);
        let merged = Item {
            segment: Some(whole),
            tolerance: item.programmed * S::of(1.0 - MERGE_SHARE),
            feed: last.feed.least(item.feed),
            entered: last.entered,
            length_before: last.length_before,
            taken: last.taken,
            ..*item
        };
        if let Some(last) = self.items.back_mut() {
            *last = merged;
        }
        if let Some(previous) = back.checked_sub(1).and_then(|i| self.items.get_mut(i)) {
            (previous.joint, previous.want) = joint(previous, &merged, config.corner);
        }
        true
    }

    /// No more blocks for now: the path ends, at rest, where the last block ends.
    pub fn close(&mut self) {
        self.closed = true;
    }

    /// The next cell, if enough is known to cut it. `last` is the node the last one ended at.
    pub fn emit(&mut self, last: &Node<S, N>, config: &Config<S, N>) -> Option<Emitted<S, N>> {
        // A finished stage leads to the next: body, joint, next item. Each turn of this loop
        // moves on by one of these, and an item has a body or a joint with cells, or is dropped.
        for _ in 0..4 * BLOCKS {
            let item = *self.items.front()?;
            let Some(segment) = item.segment else {
                self.items.pop_front();
                self.rested = true;
                return Some(standstill(last, &item));
            };
            match self.stage {
                Stage::Waiting => {
                    if !self.front_is_ready(config) {
                        return None;
                    }
                    self.start_front(&item, &segment, config);
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
                Stage::Body { .. } => self.start_joint(&item, &segment, config),
                Stage::Corner { transition, index } if index < transition.cells() => {
                    self.stage = Stage::Corner { transition, index: index + 1 };
                    let side = self.side(transition.is_first_half(index))?;
                    let from = if self.rested { transition.node(index) } else { *last };
                    self.rested = false;
                    return Some(Emitted {
                        from,
                        cell: transition.cell(index, &from, side.0, side.1),
                        node: transition.node(index + 1),
                        rest: false,
                    });
                }
                Stage::Blend { blend, index } if index < blend::CELLS => {
                    self.stage = Stage::Blend { blend, index: index + 1 };
                    let side = self.side(2 * index < blend::CELLS)?;
                    let from = if self.rested { blend.node(index) } else { *last };
                    self.rested = false;
                    return Some(Emitted {
                        from,
                        cell: blend.cell(index, &from, side.0, side.1),
                        node: blend.node(index + 1),
                        rest: false,
                    });
                }
                Stage::Corner { .. } | Stage::Blend { .. } => self.next_item(),
            }
        }
        None
    }

    /// Feed and tag of the front item, or of the one behind it.
    fn side(&self, front: bool) -> Option<(S, u32)> {
        let item = self.items.get(usize::from(!front))?;
        Some((item.feed, item.tag))
    }

    /// Whether the joint behind the front item can be decided.
    fn front_is_ready(&self, config: &Config<S, N>) -> bool {
        let Some(item) = self.items.front() else { return false };
        if item.stop_after || self.items.len() >= 3 {
            return true;
        }
        match self.items.get(1) {
            None => self.closed,
            Some(next) => {
                self.closed
                    || next.stop_after
                    || next.segment.is_none()
                    || matches!(config.corner, CornerMode::Paper { .. })
            }
        }
    }

    /// Decides the joint behind the front item and starts on its body.
    fn start_front(&mut self, item: &Item<S, N>, segment: &Segment<S, N>, config: &Config<S, N>) {
        let next = self.items.get(1).copied();
        let mut joint = item.joint;
        let ahead = next.as_ref().and_then(|next| next.segment.as_ref());
        if item.stop_after || ahead.is_none() {
            joint = Joint::Stop;
        }
        self.kept = match (joint, &next, ahead) {
            (Joint::Corner | Joint::Blend, Some(next), Some(ahead)) => {
                reach(item, segment, next, ahead, joint, config)
            }
            _ => 0,
        };
        if matches!(joint, Joint::Corner | Joint::Blend) && self.kept <= 0 {
            joint = Joint::Stop;
            self.kept = 0;
        }
        if let Some(front) = self.items.front_mut() {
            front.joint = joint;
        }
        let until = segment.length_raw - self.kept;
        let size = |joint: Joint, kept: i64, neighbour: S| match joint {
            Joint::Stop => rest_cell(segment, item.feed, &config.limits),
            Joint::Through => segment.length.least(neighbour * S::of(3.0)),
            Joint::Corner | Joint::Blend => raw_to_mm::<S>(kept) * S::of(0.5),
        };
        let first = size(item.entered, item.taken, item.length_before);
        let last = size(joint, self.kept, ahead.map_or(S::ZERO, |ahead| ahead.length));
        self.stage = Stage::Body { way: item.taken, until, first, last };
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
        let mut cell = segment.cell(entry, way, item.feed, item.tag);
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
    fn start_joint(&mut self, item: &Item<S, N>, segment: &Segment<S, N>, config: &Config<S, N>) {
        let ahead = self.items.get(1).and_then(|next| next.segment);
        let Some(ahead) = ahead else {
            self.next_item();
            return;
        };
        let reach = raw_to_mm::<S>(self.kept);
        match item.joint {
            Joint::Corner => {
                let (a, b) = (segment.end_frame(true).0, ahead.end_frame(false).0);
                let corner = Corner::new(&a, &b);
                let mut edge = reach * S::of(0.5);
                if let CornerMode::Paper { .. } = config.corner {
                    // The paper's edge is what `kept` was made of.
                    edge = raw_to_mm::<S>(self.kept / 2);
                }
                let transition = Transition::new(segment.end, a, b, &corner, edge);
                self.stage = Stage::Corner { transition, index: 0 };
            }
            Joint::Blend => {
                self.stage = Stage::Blend { blend: Blend::new(segment, &ahead, reach), index: 0 };
            }
            Joint::Stop | Joint::Through => self.next_item(),
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

fn in_range<S: Scalar>(
    field: Field,
    value: S,
    least: f64,
    greatest: f64,
) -> Result<(), BlockError> {
    let value = value.to_f64();
    if value >= least && value <= greatest {
        Ok(())
    } else {
        Err(BlockError::OutOfRange { field, value, least, greatest })
    }
}

fn check_coordinates<const N: usize>(to: &[Coord; N]) -> Result<(), BlockError> {
    const LIMIT: i64 = Coord::LIMIT_MM as i64 * Coord::PER_MM;
    for (axis, coord) in to.iter().enumerate() {
        if coord.raw() > LIMIT || coord.raw() < -LIMIT {
            return Err(BlockError::Coordinate { axis, value: coord.to_mm() });
        }
    }
    Ok(())
}

/// A cell without length, for a dwell.
fn standstill<S: Scalar, const N: usize>(from: &Node<S, N>, item: &Item<S, N>) -> Emitted<S, N> {
    Emitted {
        from: *from,
        cell: Cell {
            length: S::ZERO,
            bulge: zero(),
            feed: S::ONE,
            dwell: item.dwell,
            straight: true,
            tag: item.tag,
        },
        node: *from,
        rest: true,
    }
}

/// Speed along the path that the feed word asks for, at most what the axes allow on a line, mm/s.
fn path_speed<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    feed: Feed<S>,
    limits: &Limits<S, N>,
) -> S {
    let (tangent, _) = segment.end_frame(false);
    let mut linear = zero::<S, N>();
    let mut most = S::of(1.0e6);
    for (i, axis) in limits.axes().iter().enumerate() {
        if !axis.rotary {
            linear[i] = tangent[i];
        }
        let share = tangent[i].abs();
        if segment.is_line() && share * most > axis.velocity {
            most = axis.velocity / share;
        }
    }
    let wanted = match feed {
        Feed::Rapid => return most,
        Feed::Duration(seconds) => segment.length / seconds,
        Feed::PerSecond(feed) => {
            // G94: the feed is the speed over the linear axes if any of them moves.
            let share = norm(&linear);
            if share * most <= feed { most } else { feed / share.greatest(S::of(1.0e-9)) }
        }
    };
    wanted.least(most)
}

/// Length of the first cell from rest, mm: what constant jerk covers in half the time in which
/// acceleration builds up.
fn rest_cell<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    feed: S,
    limits: &Limits<S, N>,
) -> S {
    let (tangent, _) = segment.end_frame(false);
    let mut jerk = S::of(1.0e12);
    for (axis, share) in limits.axes().iter().zip(&tangent) {
        if share.abs() * jerk > axis.jerk {
            jerk = axis.jerk / share.abs();
        }
    }
    let time = limits.time_scale().least((feed / jerk).sqrt()) * S::of(0.5);
    jerk * time * time * time / S::of(6.0)
}

/// The node at which the next cell of a body ends, by its way along the segment.
///
/// Cells grow from either end with the distance from it, as speed does.
fn next_way<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    item: &Item<S, N>,
    (way, until): (i64, i64),
    (first, last): (S, S),
) -> i64 {
    let growth = S::of(GROWTH);
    let done = raw_to_mm::<S>(way - item.taken);
    let left = raw_to_mm::<S>(until - way);
    let longest = segment.longest_cell(item.tolerance).least(item.feed * S::of(LONGEST_CELL_TIME));
    let forward = first.greatest(growth * done);
    let backward = last.greatest(left * S::of(GROWTH / (1.0 + GROWTH)));
    let step = forward.least(backward).least(longest);
    if left < step * S::of(2.1) {
        // From rest to rest there must be a node between.
        let whole =
            left <= step * S::of(1.0001) && !(way == item.taken && item.joint == Joint::Stop);
        return if whole { until } else { way + (until - way + 1) / 2 };
    }
    // At least a thousandth of what is left, so that the count of cells is bounded.
    way + mm_to_raw(step).max((until - way) / 1024).max(1)
}

/// The node between two segments that is simply passed. Between lines it lies on the circle
/// through the three points; the jump between two curves is halved.
fn mean_node<S: Scalar, const N: usize>(
    at: [Coord; N],
    frame_in: &Frame<S, N>,
    frame_out: &Frame<S, N>,
    (l0, l1): (S, S),
) -> Node<S, N> {
    let half = S::of(0.5);
    let sum: [S; N] = from_fn(|i| frame_in.0[i] * l1 + frame_out.0[i] * l0);
    let size = norm(&sum);
    let per = S::of(2.0) / (l0 + l1);
    let tangent: [S; N] = from_fn(|i| sum[i] / size);
    let bend: [S; N] = from_fn(|i| {
        (frame_out.0[i] - frame_in.0[i]) * per + (frame_in.1[i] + frame_out.1[i]) * half
    });
    // Curvature is at right angles to the tangent.
    let along = dot(&bend, &tangent);
    Node { at, tangent, curvature: from_fn(|i| bend[i] - along * tangent[i]) }
}

/// Lengths of the cells on either side of a joint that is simply passed, mm: a long line next to
/// a short one bends only over its end.
fn bent_lengths<S: Scalar>(before: S, after: S) -> (S, S) {
    let three = S::of(3.0);
    (before.least(after * three), after.least(before * three))
}

/// Whether the common point of two segments can simply be passed with a mean direction.
///
/// With the directions weighted so that the curve is the circle through the three points, the
/// node turns away from either chord by turn l / (l0 + l1) and has the curvature 2 turn / (l0 +
/// l1). The quintic of a cell answers a unit of direction at one end with at most 0.196 l and a
/// unit of curvature with at most 0.0173 l^2, so it leaves its chord by no more than
/// 0.231 turn l^2 / (l0 + l1) for each of its ends.
fn passes<S: Scalar, const N: usize>(
    a: &Segment<S, N>,
    b: &Segment<S, N>,
    (frame_in, frame_out): (&Frame<S, N>, &Frame<S, N>),
    tolerance: S,
    mode: CornerMode<S>,
) -> bool {
    let gap: [S; N] = from_fn(|i| frame_out.0[i] - frame_in.0[i]);
    let turn = norm(&gap);
    let bend: [S; N] = from_fn(|i| frame_out.1[i] - frame_in.1[i]);
    let bend = norm(&bend);
    let (l0, l1) = bent_lengths(a.length, b.length);
    let longest = l0.greatest(l1);
    let straight = S::of(STRAIGHT);
    if turn <= straight && bend * longest <= straight {
        return true;
    }
    let slight = match mode {
        CornerMode::Band => S::of(SLIGHT_TURN),
        CornerMode::Paper { .. } => return false,
    };
    // A jump in curvature (an arc that starts or ends) must be a small one.
    if turn > slight || bend * longest > S::of(0.01) {
        return false;
    }
    let off = (turn * S::of(0.24) / (l0 + l1) + bend * S::of(0.02)) * longest * longest;
    off <= tolerance * S::of(0.48)
}

/// How two items meet, and what length the joint would like of either.
fn joint<S: Scalar, const N: usize>(
    before: &Item<S, N>,
    after: &Item<S, N>,
    mode: CornerMode<S>,
) -> (Joint, i64) {
    let (Some(a), Some(b)) = (&before.segment, &after.segment) else {
        return (Joint::Stop, 0);
    };
    let tolerance = before.tolerance.least(after.tolerance);
    let (frame_in, frame_out) = (a.end_frame(true), b.end_frame(false));
    let corner = Corner::new(&frame_in.0, &frame_out.0);
    if corner.cos_turn() < S::of(STOP_COSINE) {
        return (Joint::Stop, 0);
    }
    if corner.cos_turn() > S::ZERO && passes(a, b, (&frame_in, &frame_out), tolerance, mode) {
        return (Joint::Through, 0);
    }
    if !(tolerance > S::ZERO) {
        return (Joint::Stop, 0);
    }
    let shorter = a.length.least(b.length);
    match (&a.shape, &b.shape, mode) {
        (Shape::Line(_), Shape::Line(_), CornerMode::Paper { .. }) => (Joint::Corner, 0),
        (Shape::Line(_), Shape::Line(_), CornerMode::Band) => {
            let edge = corner.full_band_edge(tolerance, shorter * S::of(0.5));
            (Joint::Corner, mm_to_raw(edge) * 2)
        }
        _ => {
            let bound = |segment: &Segment<S, N>| {
                segment.length.least(segment.longest_angle() * S::of(3.0))
            };
            let most = bound(a).least(bound(b)) * S::of(0.5);
            (Joint::Blend, mm_to_raw(Blend::longest_reach(a, b, tolerance, most)))
        }
    }
}

/// Length the joint behind `item` takes of either segment, 1e-12 mm.
fn reach<S: Scalar, const N: usize>(
    item: &Item<S, N>,
    segment: &Segment<S, N>,
    next: &Item<S, N>,
    ahead: &Segment<S, N>,
    joint: Joint,
    config: &Config<S, N>,
) -> i64 {
    let left = segment.length_raw - item.taken;
    if let (Joint::Corner, CornerMode::Paper { lambda }) = (joint, config.corner) {
        let corner = Corner::new(&segment.end_frame(true).0, &ahead.end_frame(false).0);
        let tolerance = item.tolerance.least(next.tolerance);
        let leg_in = raw_to_mm::<S>(left) * (S::ONE - lambda);
        let edge = corner.paper_edge(tolerance, leg_in, ahead.length);
        return (mm_to_raw(edge) * 2).min(left).min(ahead.length_raw);
    }
    // Sharing by need: what the next joint does not want of the next segment is free for this one.
    let next_want = if next.stop_after { 0 } else { next.want };
    let free = if next_want == 0 {
        // The next segment ends in its own last point: it must keep a body.
        ahead.length_raw - ahead.length_raw / 8
    } else {
        (ahead.length_raw - next_want).max(ahead.length_raw / 2)
    };
    let granted = item.want.min(left).min(free);
    // Either nothing of the body is left, or a stretch long enough to be a cell of its own.
    let body = left - granted;
    if body <= granted / 1024 {
        // Within rounding: the band has room for it.
        return left;
    }
    let least = granted / 8;
    if body < least { granted - (least - body) } else { granted }
}
