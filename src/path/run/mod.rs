//! Runs of short lines as one cubic B-spline inside their tolerance band.
//!
//! [`polyline`] holds the poly-line, thinned; [`Run`] lays knots along it, where it turns; [`sliding`]
//! makes a spline over them that is inside the band, by a bound, and has [`crate::spline::sweep`]
//! smooth it as far as the band allows. A stretch of spans is kept in hand: when it is full, or the
//! run ends, it is smoothed and its first spans are handed on for good.

mod polyline;
mod sliding;
mod span;

pub use self::polyline::Leg;
pub use self::sliding::Tie;

use self::polyline::{Polyline, Ray};
use self::sliding::SlidingSpline;
use super::cut::{Emitted, EndSizes, LONGEST_CELL_TIME, NextPiece, next_piece};
use super::node::Node;
use crate::machine::Ramp;
use crate::number::vector::{Vector, dot, norm, sub, zero};
use crate::number::{Coord, Interval, Length, Scalar};
use heapless::Deque;

/// Share of the tolerance by which vertices may lie off the line between two dominant points: at
/// least this far apart knots are laid.
const COARSE: f64 = 0.7;
/// Most vertices between two dominant points.
const PASSED: u32 = 5;
/// Pieces with tags of their own that are remembered; of more, the tag of the next is shown.
const PIECES: usize = 10;
/// Dominant points waiting for their spans.
const WAITING: usize = 6;
/// Length of the spans at a dominant point, times turn over tolerance: what a uniform cubic spline with
/// spans of this length cuts off is two thirds of the band.
const DOMINANT_SPAN: f64 = 4.0;
/// Reach at a dominant point, times turn^1.5 over tolerance: see [`crate::spline::sweep`].
const DOMINANT_REACH: f64 = 25.0;
/// Twice the sine of half the turn (100 degrees) from which on a dominant point is a rest.
const BACK: f64 = 1.53;
/// Least cosine between a line and the line that stands for it and others.
const AHEAD: f64 = 0.3;
/// Spans next to each other differ in length by less than this share of the distance to a dominant point.
const GRADE: f64 = 0.5;
/// Spans handed on at once.
const BATCH: usize = 6;
/// Share of the first or last line of a smooth end that one span may take: two must fit.
const SMOOTH_SHARE: f64 = 0.49;

/// A dominant point of the run: a vertex at which the poly-line turns, so that knots are laid by it. (The term is
/// Park and Lee's, 2007, "B-spline curve fitting based on adaptive curve refinement using dominant points".)
#[derive(Clone, Copy)]
struct DominantPoint<S, const N: usize> {
    s: Length,
    at: [Coord; N],
    /// Direction in which it is reached.
    direction: Vector<S, N>,
    /// Length of the spans next to it, mm.
    size: S,
    /// Feed of the line that ends there, mm/s.
    feed: S,
    /// Whether the path turns back there, so that the motion has to rest.
    stop: bool,
    tolerance: S,
}

/// A run of lines.
pub struct Run<S, const N: usize> {
    polyline: Polyline<S, N>,
    spline: SlidingSpline<S, N>,
    /// Dominant points from the one that knots have been laid up to.
    dominant: Deque<DominantPoint<S, N>, WAITING>,
    /// Vertex of the polyline at the newest dominant point, and the next to be looked at.
    newest: u32,
    next: u32,
    start: Tie,
    end: Option<Tie>,
    /// How the machine gets going along its first line.
    ramp: Ramp<S>,
    /// Longest span next to a smooth start, mm.
    beside: S,
    knots: KnotState,
    /// Spans of the spline handed on, and that may be.
    handed: usize,
    ready: usize,
    /// Cells of the next one that have been handed on.
    part: u32,
    /// Pieces of lines that have tags of their own.
    pieces: Deque<TaggedPiece<S>, PIECES>,
}

/// A piece of a line with a tag of its own.
#[derive(Clone, Copy)]
struct TaggedPiece<S> {
    /// Where it ends.
    to: Length,
    /// mm.
    length: S,
    tag: u32,
}

impl<S: Scalar> TaggedPiece<S> {
    fn from(&self) -> Length {
        self.to - Length::from_mm(self.length)
    }
}

/// How far the spline has come.
#[derive(Clone, Copy, PartialEq, Eq)]
enum KnotState {
    /// Not begun.
    New,
    /// Taking knots.
    Open,
    /// It has its last knots.
    Tied,
    /// It has its last knots, but the run goes on behind them from rest: the band allowed no other.
    Broken,
}

impl<S: Scalar, const N: usize> Run<S, N> {
    pub const fn new() -> Self {
        Self {
            polyline: Polyline::new(),
            spline: SlidingSpline::new(),
            dominant: Deque::new(),
            newest: 0,
            next: 1,
            start: Tie::Rest,
            end: None,
            ramp: Ramp::NONE,
            beside: S::ZERO,
            knots: KnotState::Tied,
            handed: 0,
            ready: 0,
            part: 0,
            pieces: Deque::new(),
        }
    }

    /// Forgets the run.
    pub fn clear(&mut self) {
        self.spline.clear();
        self.knots = KnotState::Tied;
        (self.handed, self.ready, self.part) = (0, 0, 0);
    }

    /// Starts a run at a point. Next to a smooth start spans are `beside` mm long at most.
    pub fn begin(&mut self, at: [Coord; N], tie: Tie, leg: Leg<S>, (ramp, beside): (Ramp<S>, S)) {
        let rest_size = ramp.first_cell(leg.programmed.feed);
        self.polyline.begin(at, leg);
        self.spline.clear();
        self.dominant.clear();
        self.pieces.clear();
        (self.newest, self.next) = (0, 1);
        (self.start, self.end) = (tie, None);
        (self.ramp, self.beside) = (ramp, beside);
        self.knots = KnotState::New;
        (self.handed, self.ready) = (0, 0);
        let _ = self.dominant.push_back(DominantPoint {
            s: Length::ZERO,
            at,
            direction: zero(),
            size: rest_size,
            feed: leg.programmed.feed,
            stop: false,
            tolerance: leg.tolerance,
        });
        if tie == Tie::Rest {
            self.spline.slow_at(Length::ZERO, rest_size);
        }
    }

    /// Whether a line can be taken.
    pub fn has_room(&self) -> bool {
        self.end.is_none() && self.polyline.has_room() && self.dominant.len() + 3 <= WAITING
    }

    /// Arc length at the end of the last line taken.
    pub fn reach(&self) -> Length {
        self.polyline.reach()
    }

    /// Takes note of a piece of the next line, between two arc lengths, and its tag. Where there is no room
    /// the tag is not shown.
    pub fn mark(&mut self, Interval { from, to }: Interval, tag: u32) {
        if let Some((start, before)) = self.polyline.growing() {
            // The next line may become one with those before it, and show its last tag all over.
            let start = self.pieces.back().map_or(start, |piece| start.max(piece.to));
            if start < from {
                self.note(start, from, before);
            }
        }
        self.note(from, to, tag);
    }

    fn note(&mut self, from: Length, to: Length, tag: u32) {
        let _ = self.pieces.push_back(TaggedPiece { to, length: (to - from).to_mm(), tag });
    }

    /// Takes a line to `at`.
    pub fn push(&mut self, at: [Coord; N], leg: Leg<S>) {
        self.polyline.push(at, leg);
        let first = self.start == Tie::Smooth && self.polyline.end() == 1;
        if first {
            // The first line of a smooth start stays as it is.
            self.polyline.settle();
        }
        self.look(first);
    }

    /// Takes the last line, to `at`. Next to a smooth end spans are `beside` mm long at most.
    pub fn finish(&mut self, at: [Coord; N], leg: Leg<S>, tie: Tie, beside: S) {
        if tie == Tie::Smooth {
            // It stays as it is.
            self.polyline.settle();
            self.look(true);
        }
        self.polyline.push(at, leg);
        self.polyline.settle();
        self.look(true);
        self.end = Some(tie);
        if tie == Tie::Rest
            && let Some(last) = self.dominant.back_mut()
        {
            let rest_size = self.ramp.first_cell(leg.programmed.feed);
            last.size = last.size.least(rest_size);
            self.spline.slow_at(last.s, rest_size);
        }
        if tie == Tie::Smooth
            && let Some(last) = self.dominant.back_mut()
        {
            last.size = beside.least(last.size * S::of(SMOOTH_SHARE));
        }
        self.grade();
    }

    /// Looks at new vertices for dominant points; the last one is one if the run is `closed` there.
    fn look(&mut self, closed: bool) {
        // Every turn takes a vertex or makes a dominant point.
        while self.next != self.polyline.end() {
            if self.next.wrapping_sub(self.newest) > 1 && !self.reaches(self.next) {
                self.dominate(self.next.wrapping_sub(1));
            }
            self.next = self.next.wrapping_add(1);
        }
        let last = self.next.wrapping_sub(1);
        if closed && last != self.newest {
            self.dominate(last);
        }
    }

    /// Whether the line from the newest dominant point to a vertex stands for all between.
    fn reaches(&self, serial: u32) -> bool {
        let (Some(point), Some(end)) = (self.dominant.back(), self.polyline.vertex(serial)) else {
            return false;
        };
        let ray = Ray::<S, N>::new(&point.at, &end.at);
        let ahead = |direction: &Vector<S, N>| dot(direction, &ray.direction) > S::of(AHEAD);
        let most = end.leg.tolerance * S::of(COARSE);
        let first = self.newest.wrapping_add(1);
        let between = serial.wrapping_sub(first);
        let mut along = S::ZERO;
        between <= PASSED
            && ahead(&end.direction)
            && (0..between).all(|k| {
                let Some(vertex) = self.polyline.vertex(first.wrapping_add(k)) else {
                    return false;
                };
                let (on, off) = ray.place(&vertex.at);
                let ordered = on + most >= along && on <= ray.length + most;
                along = along.greatest(on);
                let goes_on = ordered && ahead(&vertex.direction);
                goes_on && off <= most && vertex.leg.is_like(&end.leg)
            })
    }

    /// Makes a vertex the newest dominant point.
    fn dominate(&mut self, serial: u32) {
        let (Some(vertex), Some(before)) =
            (self.polyline.vertex(serial), self.dominant.back().copied())
        else {
            return;
        };
        self.newest = serial;
        let length = (vertex.s - before.s).to_mm::<S>();
        let direction = Ray::new(&before.at, &vertex.at).direction;
        let first = before.s == Length::ZERO;
        let mut size = before.size.least(length);
        let mut stop = false;
        if first && self.start == Tie::Smooth {
            size = self.beside.least(length * S::of(SMOOTH_SHARE));
        }
        if !first {
            let turn = norm(&sub(&direction, &before.direction)).greatest(S::of(1.0e-6));
            let band = before.tolerance.least(vertex.leg.tolerance);
            size = size.least(band * S::of(DOMINANT_SPAN) / turn);
            let mut reach = band * S::of(DOMINANT_REACH) / (turn * turn.sqrt());
            if turn > S::of(BACK) {
                stop = true;
                let rest_size = self.ramp.first_cell(vertex.leg.programmed.feed.least(before.feed));
                size = size.least(rest_size);
                reach = rest_size;
            }
            self.spline.slow_at(before.s, reach);
        }
        if let Some(point) = self.dominant.back_mut() {
            point.size = size;
            point.stop = stop;
        }
        let _ = self.dominant.push_back(DominantPoint {
            s: vertex.s,
            at: vertex.at,
            direction,
            size: length,
            feed: vertex.leg.programmed.feed,
            stop: false,
            tolerance: vertex.leg.tolerance,
        });
        self.grade();
    }

    /// Sizes at neighbouring dominant points differ by no more than their distance allows.
    fn grade(&mut self) {
        let n = self.dominant.len();
        let limit = |a: Option<DominantPoint<S, N>>, b: Option<DominantPoint<S, N>>| {
            let (a, b) = (a?, b?);
            let apart = (a.s - b.s).abs().to_mm::<S>();
            Some(a.size + apart * S::of(GRADE))
        };
        let get = |dominant: &Deque<_, WAITING>, i: usize| dominant.get(i).copied();
        for (a, b) in (1..n).map(|i| (i - 1, i)).chain((1..n).rev().map(|i| (i, i - 1))) {
            let most = limit(get(&self.dominant, a), get(&self.dominant, b));
            if let (Some(most), Some(point)) = (most, self.dominant.get_mut(b)) {
                point.size = point.size.least(most);
            }
        }
    }

    /// Lays the next knot, if enough is known and there is room.
    fn extend(&mut self) -> bool {
        let known = self.dominant.len() >= if self.end.is_some() { 2 } else { 3 };
        let (from, to) = (self.dominant.front().copied(), self.dominant.get(1).copied());
        let (KnotState::New | KnotState::Open, Some(from)) = (self.knots, from) else {
            return false;
        };
        if self.knots == KnotState::Open && !self.spline.has_room() {
            return false;
        }
        let (Some(to), true) = (to, known) else {
            // All knots are laid, or the run has come to nothing: it ends where it started.
            if self.end.is_some() && self.knots == KnotState::New {
                self.knots = KnotState::Tied;
                return true;
            }
            return self.end.is_some() && self.tie(from.s);
        };
        let here = if self.knots == KnotState::New { from.s } else { self.spline.end() };
        let (done, left) = ((here - from.s).to_mm(), (to.s - here).to_mm());
        let ends = EndSizes { first: from.size, last: to.size };
        let s = match next_piece(done, left, ends, to.feed * S::of(LONGEST_CELL_TIME)) {
            NextPiece::Rest => to.s,
            NextPiece::Half => here + (to.s - here) / 2,
            NextPiece::Length(step) => here + Length::from_mm(step).max(Length::UNIT),
        };
        if self.knots == KnotState::New {
            self.spline.begin(&self.polyline, here, self.start, s - here);
            self.knots = KnotState::Open;
        }
        let Some(s) = self.allowed(here, s) else {
            self.tie_at_rest();
            self.knots = KnotState::Broken;
            return true;
        };
        self.lay(s);
        if s == to.s {
            self.dominant.pop_front();
            if to.stop {
                self.tie_at_rest();
                self.knots = KnotState::Broken;
            }
        }
        self.polyline.release_before(self.spline.oldest_needed());
        true
    }

    /// Lays a knot. The span that it completes shows the tag of what it ends on.
    fn lay(&mut self, s: Length) {
        let before = self.spline.spans.len();
        self.spline.push(&self.polyline, s);
        if self.spline.spans.len() == before {
            return;
        }
        let (begins, ends) = self.spline.stretch(before);
        if let Some(tag) = self.tag_at(ends - Length::UNIT)
            && let Some(leg) = self.spline.legs.last_mut()
        {
            leg.programmed.tag = tag;
        }
        // At most all of them.
        while self.pieces.front().is_some_and(|piece| piece.to <= begins) {
            self.pieces.pop_front();
        }
    }

    /// The tag of what lies around an arc length, if it is not that of its line.
    fn tag_at(&self, s: Length) -> Option<u32> {
        let piece = self.pieces.iter().find(|piece| piece.from() <= s && s < piece.to)?;
        Some(piece.tag)
    }

    /// The knot that was asked for, or one nearer at which the band is kept.
    fn allowed(&self, here: Length, s: Length) -> Option<Length> {
        let line = self.polyline.line_end(here);
        let tries = [s, here + (s - here) / 2, line.min(s), here + (line.min(s) - here) / 4];
        tries.into_iter().find(|&w| w > here && self.spline.allows(&self.polyline, &[w, w, w]))
    }

    /// Ends the spline at its last knot.
    fn tie(&mut self, end: Length) -> bool {
        if self.end == Some(Tie::Smooth) {
            let step = self.spline.last_step();
            let more = [end + step, end + step * 2];
            if self.spline.allows(&self.polyline, &more) {
                for s in more {
                    self.lay(s);
                }
                self.spline.tied = 3;
                self.knots = KnotState::Tied;
                return true;
            }
            self.end = Some(Tie::Rest);
        }
        self.tie_at_rest();
        self.knots = KnotState::Tied;
        true
    }

    fn tie_at_rest(&mut self) {
        let end = self.spline.end();
        for _ in 0..2 {
            self.lay(end);
        }
        self.spline.tied = 1;
    }

    /// Goes on from rest behind a broken stretch.
    fn reopen(&mut self) {
        let s = self.spline.end();
        let ahead = self.dominant.get(1).map(|point| point.feed);
        let mut rest_size = S::ZERO;
        if let Some(point) = self.dominant.front_mut() {
            let feed = ahead.map_or(point.feed, |ahead| ahead.least(point.feed));
            rest_size = self.ramp.first_cell(feed);
            point.s = s;
            point.at = self.polyline.point(s);
            point.size = rest_size;
        }
        self.spline.begin(&self.polyline, s, Tie::Rest, Length::ZERO);
        self.spline.slow_at(s, rest_size);
        self.knots = KnotState::Open;
        (self.handed, self.ready) = (0, 0);
    }

    /// Whether everything has been handed on.
    pub fn is_done(&self) -> bool {
        self.knots == KnotState::Tied && self.handed == self.spline.spans.len()
    }

    /// The next cell, if there is one for good. `last` is the node it starts at; after a rest the
    /// spline's own direction counts.
    pub fn next(&mut self, last: &Node<S, N>, rested: bool, sweeps: u16) -> Option<Emitted<S, N>> {
        // Every turn hands on a cell, lays a knot, or makes spans ready.
        for _ in 0..4 * sliding::CONTROLS {
            if self.handed < self.ready {
                return self.hand(last, rested);
            }
            if self.extend() {
                continue;
            }
            let tied = matches!(self.knots, KnotState::Tied | KnotState::Broken);
            if !tied && (self.knots == KnotState::New || self.spline.has_room()) {
                return None;
            }
            self.spline.release(self.handed);
            (self.handed, self.ready) = (0, 0);
            let spans = self.spline.spans.len();
            if spans == 0 {
                if self.knots == KnotState::Tied {
                    return None;
                }
                self.reopen();
                continue;
            }
            self.spline.improve(sweeps);
            self.ready = if tied { spans.min(BATCH) } else { BATCH.min(spans - 1) };
            self.spline.frozen = self.ready + 3;
        }
        None
    }

    /// Hands on a cell.
    fn hand(&mut self, last: &Node<S, N>, rested: bool) -> Option<Emitted<S, N>> {
        let (span, part) = (self.handed, self.part);
        let curve = self.spline.curve(span);
        let ends = (&self.spline.start(span), &self.spline.finish(span));
        let from = if rested { Node { at: last.at, ..curve.node(part, ends) } } else { *last };
        let node = curve.node(part + 1, ends);
        let programmed = self.spline.legs.get(span)?.programmed;
        let cell = curve.cell(part, &from, &node, programmed);
        self.part += 1;
        if self.part == curve.parts() {
            self.part = 0;
            self.handed += 1;
        }
        let at_end = self.handed == self.spline.spans.len();
        let rest = match self.knots {
            KnotState::Broken => at_end,
            _ => at_end && self.end == Some(Tie::Rest),
        };
        Some(Emitted { from, cell, node, rest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{AxisLimits, Limits};
    use crate::path::hermite::Hermite;
    use crate::path::node::Programmed;
    use std::vec::Vec;

    const BAND: f64 = 0.02;

    /// A first cell from rest of 0.01 mm.
    fn ramp() -> Ramp<f64> {
        let axis = AxisLimits::linear(200.0, 1063.0, 50_000.0);
        Ramp::new(&Limits::new([axis; 2]).unwrap(), &[1.0, 0.0])
    }

    /// Runs a poly-line through a run; the cells with their nodes.
    fn cells(points: &[[f64; 2]], sweeps: u16) -> Vec<Emitted<f64, 2>> {
        cells_within(points, sweeps, |_| BAND)
    }

    /// The same, with a tolerance for every line.
    fn cells_within(
        points: &[[f64; 2]],
        sweeps: u16,
        band: impl Fn(usize) -> f64,
    ) -> Vec<Emitted<f64, 2>> {
        let at = |p: &[f64; 2]| p.map(|x| Coord::from_mm(x).unwrap());
        let programmed = Programmed { feed: 100.0, rapid: false, tag: 0 };
        let leg = |line| Leg { programmed, tolerance: band(line), error: 0.0 };
        let mut line = 0;
        let mut run = std::boxed::Box::new(Run::new());
        let mut list: Vec<Emitted<f64, 2>> = Vec::new();
        let mut last = Node { at: at(&points[0]), tangent: [0.0; 2], curvature: [0.0; 2] };
        run.begin(last.at, Tie::Rest, leg(0), (ramp(), 0.0));
        let (end, inner) = points[1..].split_last().unwrap();
        let mut inner = inner.iter();
        let mut ended = false;
        while !run.is_done() {
            let rested = list.last().is_none_or(|cut| cut.rest);
            if let Some(cut) = run.next(&last, rested, sweeps) {
                last = cut.node;
                list.push(cut);
            } else if let Some(point) = inner.next() {
                assert!(run.has_room());
                run.push(at(point), leg(line));
                line += 1;
            } else if !ended {
                run.finish(at(end), leg(line), Tie::Rest, 0.0);
                ended = true;
            } else {
                assert!(run.is_done(), "a run hangs");
            }
        }
        list
    }

    fn distance(points: &[[f64; 2]], x: [f64; 2]) -> f64 {
        let one = |a: [f64; 2], b: [f64; 2]| {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let square = dx * dx + dy * dy;
            let t = if square > 0.0 {
                (((x[0] - a[0]) * dx + (x[1] - a[1]) * dy) / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            (a[0] + t * dx - x[0]).hypot(a[1] + t * dy - x[1])
        };
        points.windows(2).map(|pair| one(pair[0], pair[1])).fold(f64::INFINITY, f64::min)
    }

    fn paths() -> Vec<Vec<[f64; 2]>> {
        let wave = (0..300)
            .map(|k| {
                let x = 0.1 * f64::from(k);
                [x, (1.3 * x).sin() + 0.2 * (5.0 * x).sin()]
            })
            .collect();
        let stairs =
            (0..60).map(|k| [0.4 * f64::from(k / 2 + k % 2), 0.4 * f64::from(k / 2)]).collect();
        let noise = (0..200)
            .map(|k| [0.05 * f64::from(k), 0.008 * f64::from(k * k % 7 - 3) / 3.0])
            .collect();
        let spikes =
            (0..100).map(|k| [0.03 * f64::from(k), if k % 10 == 5 { 0.3 } else { 0.0 }]).collect();
        let lengths = (0..60)
            .scan([0.0, 0.0], |at, k| {
                let size = [1.0e-4, 1.0, 0.01, 3.0, 2.0e-7][k % 5];
                let heading = 0.4 * (k as f64 * 0.7).sin();
                *at = [at[0] + size * heading.cos(), at[1] + size * heading.sin()];
                Some(*at)
            })
            .collect();
        std::vec![wave, stairs, noise, spikes, lengths]
    }

    /// The curve of every cell, at many places, with any number of sweeps.
    #[test]
    fn the_band_is_never_left() {
        for points in paths() {
            for sweeps in [0, 1, 3, 8, 40] {
                for cut in cells(&points, sweeps) {
                    let curve = Hermite::of_cell(&cut.from, &cut.cell, &cut.node);
                    for k in 0..=10 {
                        let offset = curve.offset(f64::from(k) / 10.0);
                        let x = [0, 1].map(|i| cut.from.at[i].to_mm() + offset[i]);
                        let off = distance(&points, x);
                        assert!(off <= BAND, "{sweeps} sweeps: {off} at {x:?}");
                    }
                }
            }
        }
    }

    /// A line with a narrower band than its neighbours, which run on nearly straight: where it is
    /// beside the path its own band counts (found by the soak).
    #[test]
    fn every_line_keeps_its_own_band() {
        for (corner, narrow) in [(0.3, 0.001_3), (0.2, 0.003), (0.4, 0.000_5), (0.1, 0.002)] {
            let path = [
                [-1.4, -0.3 - corner],
                [0.0, 0.0],
                [0.207, 0.0],
                [0.2588, 0.0],
                [0.3106, 0.0],
                [1.0, corner],
            ];
            let band = |line: usize| if line == 2 { narrow } else { 0.01 };
            for sweeps in [0, 1, 8, 40] {
                for cut in cells_within(&path, sweeps, band) {
                    let curve = Hermite::of_cell(&cut.from, &cut.cell, &cut.node);
                    for k in 0..=20 {
                        let offset = curve.offset(f64::from(k) / 20.0);
                        let x = [0, 1].map(|i| cut.from.at[i].to_mm() + offset[i]);
                        let beside = x[0] > path[2][0] && x[0] < path[3][0];
                        assert!(!beside || x[1].abs() <= narrow, "{narrow}: {x:?}");
                    }
                }
            }
        }
    }

    /// Every cell starts where the one before ends, in the same direction and with the same
    /// curvature, and the last one ends where the poly-line does.
    #[test]
    fn cells_join_with_continuous_curvature() {
        for points in paths() {
            let list = cells(&points, 8);
            for pair in list.windows(2) {
                assert_eq!(pair[0].node.at, pair[1].from.at);
                let (a, b) = (&pair[0].node, &pair[1].from);
                let apart =
                    norm(&sub(&a.tangent, &b.tangent)).max(norm(&sub(&a.curvature, &b.curvature)));
                assert!(pair[0].rest || apart < 1.0e-15, "{apart}");
            }
            let (first, last) = (points[0], points[points.len() - 1]);
            let (a, b) = (&list[0].from.at, &list[list.len() - 1].node.at);
            assert!((0..2).all(|i| (a[i].to_mm() - first[i]).abs() < 1.0e-9));
            assert!((0..2).all(|i| (b[i].to_mm() - last[i]).abs() < 1.0e-9));
        }
    }

    /// The integral of the square of the third derivative falls with the sweeps.
    #[test]
    fn sweeps_smooth() {
        let points = &paths()[0];
        let roughness = [0, 4, 20].map(|sweeps| -> f64 {
            let change = |cut: &Emitted<f64, 2>| {
                let (a, b) = (&cut.from.curvature, &cut.node.curvature);
                ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)) / cut.cell.length
            };
            cells(points, sweeps).iter().map(change).sum()
        });
        assert!(roughness[1] < 0.5 * roughness[0], "{roughness:?}");
        assert!(roughness[2] < 1.05 * roughness[1], "{roughness:?}");
    }
}
