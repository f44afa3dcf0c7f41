//! Runs of short lines as one cubic B-spline inside their tolerance band.
//!
//! [`polyline`] holds the poly-line, thinned; [`dominant`] finds the vertices where it turns, and [`knots`] are laid
//! along it by them; [`sliding`] makes a spline over the knots that is inside the band, by a bound ([`trial_span`]), and has
//! [`crate::spline::sweep`] smooth it as far as the band allows; beside lines that end at narrower ones
//! there is less room ([`narrows`]); a [`span`] of it becomes cells, with the tags of the
//! [`pieces`] beside it. A stretch of spans is held back: when it is full, or the
//! run ends, it is smoothed and its first spans are handed on for good.

mod dominant;
mod knots;
mod narrows;
mod pieces;
mod polyline;
mod sliding;
mod span;
mod trial_span;

pub use self::sliding::Tie;

use self::dominant::DominantPoint;
use self::knots::{KnotState, ends_on};
use self::pieces::Pieces;
use self::polyline::{Polyline, VertexSerial};
use self::sliding::SlidingSpline;
use self::span::SpanCurve;
use super::cut::{Cut, Emitted};
use super::leg::Leg;
use super::node::Node;
use super::straight::SHOWN_SHARE;
use crate::machine::Ramp;
use crate::number::optional::Optional;
use crate::number::vector::zero;
use crate::number::{Coord, Interval, Length, Scalar};
use crate::spline::sweep::Smoothing;
use heapless::Deque;

/// Spans handed on at once. (5: 0.2 % longer, and lines with noise up to a third.)
const BATCH: usize = 4;
/// Spans of a stretch that is not full which are held back where the motion needs what is known: the control points of
/// three of them do not move before more is.
const HELD_BACK: usize = 4;
/// So many are handed on at least from rest: they are short there, and run in no time.
const LEAST_BEGUN: usize = 14;
/// Dominant points waiting for their spans.
const WAITING: usize = 6;
/// Most lines from a dominant point to the next, and behind the newest: none is passed by more vertices.
const APART: usize = dominant::PASSED as usize + 1;
/// Vertices of the poly-line that are held at most. No interval between knots reaches beyond a dominant point; knots have
/// been laid up to the first of at most `WAITING` - 3 of them when a line is taken ([`Run::has_room`]), which adds two
/// vertices if it is the last. Before the intervals that are needed one vertex is kept.
const VERTICES: usize = 2 + sliding::NEEDED_BEHIND * APART + (WAITING - 3) * APART + 2;
/// Share of the first or last line of a smooth end that one span may take: two must fit.
const SMOOTH_SHARE: f64 = 0.49;
/// Shortest piece of a line at whose end a cell ends, as a share of the length over which the feed is reached.
const ENDS_SHARE: f64 = 0.125;
/// So many times as long at least in a bend.
const LONGER_IN_BENDS: f64 = 4.0;

/// How a run begins.
pub struct Start<S, const N: usize> {
    /// Where.
    pub at: [Coord; N],
    pub tie: Tie,
    /// How the machine gets going along its first line.
    pub ramp: Ramp<S>,
    /// Longest span next to a smooth start, mm.
    pub beside: S,
    /// Tolerance of the line that leads there, if it starts at rest at its very end, mm.
    pub before: Option<S>,
}

/// A run of lines.
pub struct Run<S, const N: usize> {
    polyline: Polyline<S, N>,
    spline: SlidingSpline<S, N>,
    /// Whether the next spans are handed on before the stretch is full.
    hurried: bool,
    /// Whether spans are short, because more of the path comes slowly: what is held back of the stretch is. Once they are they stay so to
    /// the end of the run, unless its first stretch has been filled: with long ones again the next blocks would be waited for again.
    brief: bool,
    /// How far the spline has been smoothed, if it is being.
    smoothing: Optional<Smoothing<S>>,
    /// Dominant points from the one that knots have been laid up to.
    dominant: Deque<DominantPoint<S, N>, WAITING>,
    /// Vertex of the poly-line at the newest dominant point.
    newest: VertexSerial,
    /// The next vertex to be looked at.
    next: VertexSerial,
    start: Tie,
    end: Optional<Tie>,
    /// How the machine gets going along its first line.
    ramp: Ramp<S>,
    /// Longest span next to a smooth start, mm.
    beside: S,
    knots: KnotState,
    /// Spans of the spline handed on.
    handed: usize,
    /// Spans of it that may be.
    ready: usize,
    /// Parts of the next one that have been handed on, and up to which place, by its parameter from 0 to 1.
    part: u32,
    place: S,
    /// Arc length at the end of the last cell, and its curve and part of it.
    #[cfg(feature = "outputs")]
    handed_to: Length,
    #[cfg(feature = "outputs")]
    shape: Optional<(SpanCurve<S, N>, [S; 2])>,
    /// Pieces of lines that have tags of their own.
    pieces: Pieces<S>,
}

impl<S: Scalar, const N: usize> Run<S, N> {
    pub const fn new() -> Self {
        Self {
            polyline: Polyline::new(),
            spline: SlidingSpline::new(),
            hurried: false,
            brief: false,
            smoothing: Optional::NONE,
            dominant: Deque::new(),
            newest: VertexSerial::ZERO,
            next: VertexSerial::ZERO,
            start: Tie::Rest,
            end: Optional::NONE,
            ramp: Ramp::UNSET,
            beside: S::ZERO,
            knots: KnotState::New,
            handed: 0,
            ready: 0,
            part: 0,
            place: S::ZERO,
            #[cfg(feature = "outputs")]
            handed_to: Length::ZERO,
            #[cfg(feature = "outputs")]
            shape: Optional::NONE,
            pieces: Pieces::new(),
        }
    }

    /// Forgets the run.
    pub fn clear(&mut self) {
        self.spline.clear();
        (self.hurried, self.brief) = (false, false);
        self.smoothing.set(None);
        self.knots = KnotState::Tied;
        (self.handed, self.ready, self.part, self.place) = (0, 0, 0, S::ZERO);
    }

    /// Starts a run, whose first line is asked for `leg`.
    pub fn begin(&mut self, Start { at, tie, ramp, beside, before }: Start<S, N>, leg: Leg<S>) {
        let rest_size = ramp.first_cell(leg.programmed.feed);
        let tolerance = before.unwrap_or(leg.tolerance);
        self.polyline.begin(at, Leg { tolerance, ..leg });
        self.spline.clear();
        (self.hurried, self.brief) = (false, false);
        self.smoothing.set(None);
        self.dominant.clear();
        self.pieces.clear();
        (self.newest, self.next) = (VertexSerial::ZERO, VertexSerial::ZERO.next());
        self.start = tie;
        self.end.set(None);
        (self.ramp, self.beside) = (ramp, beside);
        self.knots = KnotState::New;
        (self.handed, self.ready) = (0, 0);
        self.keep(DominantPoint {
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

    /// The motion will soon need more of the path: the next spans are handed on with less of it known behind them.
    pub fn hurry(&mut self) {
        (self.hurried, self.brief) = (true, true);
    }

    /// Whether a line can be taken.
    pub fn has_room(&self) -> bool {
        let has_room = !self.end.is_some() && self.dominant.len() + 3 <= WAITING;
        debug_assert!(!has_room || self.polyline.has_room(), "more vertices than can be");
        has_room && self.polyline.has_room()
    }

    /// Arc length at the end of the last line taken.
    pub fn reach(&self) -> Length {
        self.polyline.reach()
    }

    /// Arc length at the end of the last cell that was handed on.
    #[cfg(feature = "outputs")]
    pub fn handed_to(&self) -> Length {
        self.handed_to
    }

    /// Share of the length of the last cell that lies before a share of its parameter.
    #[cfg(feature = "outputs")]
    pub fn share_before(&self, share: S) -> S {
        self.shape.as_ref().map_or(share, |(curve, part)| curve.share_before(*part, share))
    }

    /// Takes note of a piece of the next line and its tag. Where there is no room
    /// the tag is not shown.
    pub fn mark(&mut self, piece: Interval, tag: u32) {
        if let Some((start, before)) = self.polyline.growing() {
            // The next line may become one with those before it, and show its last tag all over.
            self.pieces.note_rest(Interval { from: start, to: piece.from }, S::ZERO, before);
        }
        self.pieces.note(piece, tag);
    }

    /// Takes a line to `at`. Of one that it becomes one with, what is long enough to be shown keeps its tag.
    #[inline(never)]
    fn take(&mut self, at: [Coord; N], leg: Leg<S>) {
        let Some((Interval { from, to }, tag)) = self.polyline.push(at, leg) else { return };
        if tag != leg.programmed.tag {
            let least = self.ramp.length(leg.programmed.feed) * S::of(SHOWN_SHARE);
            self.pieces.note_rest(Interval { from, to }, least, tag);
        }
    }

    /// Takes a line to `at`.
    pub fn push(&mut self, at: [Coord; N], leg: Leg<S>) {
        self.take(at, leg);
        let first = self.start == Tie::Smooth && self.polyline.end() == VertexSerial::ZERO.next();
        if first {
            // The first line of a smooth start stays as it is.
            self.polyline.settle();
        }
        self.look(first);
    }

    /// Takes the last line, to `at`. Next to a smooth end spans are `beside` mm long at most; behind one at rest there may be another
    /// tolerance, mm.
    #[inline(never)]
    pub fn finish(
        &mut self,
        at: [Coord; N],
        leg: Leg<S>,
        tie: Tie,
        (beside, behind): (S, Option<S>),
    ) {
        if tie == Tie::Smooth || self.polyline.returns(&at) {
            // It stays as it is: or, back where the line before began, would be a part of one without a length, and not be reached.
            self.polyline.settle();
            self.look(true);
        }
        self.take(at, leg);
        self.polyline.settle();
        self.look(true);
        self.end.set(Some(tie));
        self.polyline.end_before(behind);
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

    /// Whether everything has been handed on.
    pub fn is_done(&self) -> bool {
        self.knots == KnotState::Tied && self.handed == self.spline.spans.len()
    }

    /// The next cell, if there is one for good. `last` is the node it starts at; after a rest the
    /// spline's own direction counts.
    ///
    /// Cost: one cell, or one knot, or one step of smoothing.
    #[inline(never)]
    pub fn next(&mut self, last: &Node<S, N>, rested: bool, sweeps: u16) -> Cut<S, N> {
        // Every turn hands on a cell, lays a knot, or makes spans ready.
        for _ in 0..4 * sliding::CONTROLS {
            if let Some(now) = self.smoothing.take() {
                self.smoothing.set(self.spline.smooth_on(now));
                if !self.smoothing.is_some() {
                    self.make_ready();
                }
                return Cut::Working;
            }
            if self.handed < self.ready {
                return self.hand(last, rested).map_or(Cut::Nothing, Cut::Cell);
            }
            if self.extend() {
                return Cut::Working;
            }
            let tied = self.is_tied();
            let spans = self.spline.spans.len() - self.handed;
            let from_rest = self.start == Tie::Rest && self.spline.frozen < 3;
            let least = if from_rest { LEAST_BEGUN } else { 1 };
            let waits = self.spline.has_room() && !(self.hurried && spans >= HELD_BACK + least);
            if !tied && (self.knots == KnotState::New || waits) {
                return Cut::Nothing;
            }
            self.spline.release(self.handed);
            (self.handed, self.ready) = (0, 0);
            if self.spline.spans.is_empty() {
                if self.knots == KnotState::Tied {
                    return Cut::Nothing;
                }
                self.reopen();
                continue;
            }
            self.smoothing.set(self.spline.begin_smoothing(sweeps));
            if !self.smoothing.is_some() {
                self.make_ready();
            }
            return Cut::Working;
        }
        Cut::Nothing
    }

    /// Whether the spline has its last knots.
    fn is_tied(&self) -> bool {
        matches!(self.knots, KnotState::Tied | KnotState::Broken)
    }

    /// The spline has been smoothed: its first spans may be handed on.
    #[inline(never)]
    fn make_ready(&mut self) {
        let spans = self.spline.spans.len();
        // What has been handed on has left: only the first stretch of a run can be full here.
        let has_room = self.spline.has_room();
        self.brief &= has_room;
        self.ready = if self.is_tied() {
            spans.min(BATCH)
        } else if self.hurried && has_room {
            spans.saturating_sub(HELD_BACK).max(1)
        } else {
            BATCH.min(spans - 1)
        };
        self.spline.frozen = self.ready + 3;
        self.hurried = false;
    }

    /// Shortest piece of a line, mm, at whose end a cell ends at a feed, mm/s.
    fn least_end(&self, feed: S) -> S {
        self.ramp.length(feed) * S::of(ENDS_SHARE)
    }

    /// The same of the cells of a span.
    fn least_end_in(&self, span: usize) -> S {
        self.spline.programmed.get(span).map_or(S::ZERO, |of| self.least_end(of.feed))
    }

    /// The end of a piece at which a cell of a span ends that begins at `begin`, if there is one: which place that is, where it lies beside the
    /// poly-line, and the tag of the piece. Where it turns a span shows what it ends on.
    fn mark_in(&self, span: usize, curve: &SpanCurve<S, N>, begin: S) -> Option<(S, Length, u32)> {
        let shown = ends_on(self.spline.interval(span));
        if curve.parts() > 1 || !self.pieces.ends_before(shown) {
            return None;
        }
        let beside = self.spline.beside(span);
        let length: S = (beside.to - beside.from).to_mm();
        let done = Length::from_mm(length * curve.beside(begin));
        let left = Interval { from: beside.from + done, ..beside };
        let longer = S::of(if curve.is_gentle() { 1.0 } else { LONGER_IN_BENDS });
        let (s, tag) = self.pieces.end_in(left, self.least_end_in(span) * longer)?;
        // What ends behind the place whose tag the span shows is not shown before that.
        let place = curve.place_beside((s - beside.from).to_mm::<S>() / length);
        (s <= shown).then_some((place, s, tag))
    }

    /// Hands on a cell: a part of a span, or of that what ends with a piece of a line.
    #[inline(never)]
    fn hand(&mut self, last: &Node<S, N>, rested: bool) -> Option<Emitted<S, N>> {
        let (span, part, begin) = (self.handed, self.part, self.place);
        let curve = self.spline.curve(span);
        let from = if rested { Node::new(last.at, curve.frame(begin)) } else { *last };
        let mut programmed = *self.spline.programmed.get(span)?;
        let mark = self.mark_in(span, &curve, begin);
        let whole = mark.is_none() && part + 1 == curve.parts();
        let end = if let Some((place, s, tag)) = mark {
            programmed.tag = tag;
            self.pieces.release_before(s);
            place
        } else {
            curve.place(part + 1)
        };
        let at =
            if whole { self.spline.finish(span) } else { self.spline.place(span, &curve, end) };
        let node = Node::new(at, curve.frame(end));
        let cell = curve.cell([begin, end], &from, &node, programmed);
        #[cfg(feature = "outputs")]
        {
            let interval = self.spline.beside(span);
            let rest = interval.to - interval.from;
            self.shape.set(Some((curve, [begin, end])));
            self.handed_to = match mark {
                Some((_, s, _)) => s,
                None => {
                    interval.to
                        - rest / i64::from(curve.parts()) * i64::from(curve.parts() - part - 1)
                }
            };
        }
        if whole {
            (self.part, self.place) = (0, S::ZERO);
            self.handed += 1;
            self.pieces.release_before(ends_on(self.spline.interval(span)));
        } else {
            self.part += u32::from(mark.is_none());
            self.place = end;
        }
        let at_end = self.handed == self.spline.spans.len();
        let rest = match self.knots {
            KnotState::Broken => at_end,
            _ => at_end && self.end.as_ref() == Some(&Tie::Rest),
        };
        Some(Emitted { from, cell, node, rest })
    }
}
#[cfg(test)]
mod tests;
