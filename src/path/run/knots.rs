//! Laying the knots of a run: where the next one lies, and how the spline ends.

use super::{LONGER_IN_BENDS, Run, Tie, VERTICES};
use crate::number::{Interval, Length, Scalar};
use crate::path::cut::{EndSizes, LONGEST_CELL_TIME, NextPiece, next_piece};
use crate::path::straight::LAST_PART;

/// How far the spline has come.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum KnotState {
    /// Not begun.
    New,
    /// Taking knots.
    Open,
    /// It has its last knots.
    Tied,
    /// It has its last knots, but the run goes on behind them from rest: the band allowed no other.
    Broken,
}

/// Longest span where more of the path comes slowly, as a share of the longest.
const BRIEF_SHARE: f64 = 0.125;
/// A vertex this part of a span behind a knot is no place for the next: the span between the two would be crept through, for a cell takes
/// its time however short it is.
const BESIDE: i64 = 16;
/// Least part of a span that the end of a line cuts off at its beginning, or at the end of one that stays where it is: a shorter one would be crept
/// through.
const CUT_OFF: i64 = 8;
/// Of a line that is longer than a span by less than this, a span takes half.
const LITTLE_LONGER: f64 = 1.5;

/// The place whose tag a span shows: what it ends on, if that is not too short to be a part of its own.
pub(super) fn ends_on(Interval { from, to }: Interval) -> Length {
    to - (to - from) / LAST_PART
}

impl<S: Scalar, const N: usize> Run<S, N> {
    /// Lays the next knot, if enough is known and there is room.
    #[inline(never)]
    pub(super) fn extend(&mut self) -> bool {
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
        let share = if self.brief { BRIEF_SHARE } else { 1.0 };
        let longest = to.feed * S::of(LONGEST_CELL_TIME * share);
        let s = match next_piece(done, left, ends, longest) {
            NextPiece::Rest => to.s,
            NextPiece::Half => here + (to.s - here) / 2,
            NextPiece::Length(step) => here + Length::from_mm(step).max(Length::UNIT),
        };
        let s = self.to_end(Interval { from: here, to: s }, s == to.s, self.least_end(to.feed));
        if self.knots == KnotState::New {
            self.spline.begin(&self.polyline, here, self.start, s - here);
            self.knots = KnotState::Open;
        }
        let Some(s) = self.lay_allowed(here, s) else {
            self.tie_at_rest();
            self.knots = KnotState::Broken;
            return true;
        };
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
        self.show(before);
    }

    /// Shows the tags of the span that has been completed, if there were `before` before.
    fn show(&mut self, before: usize) {
        if self.spline.spans.len() == before {
            return;
        }
        let span = self.spline.interval(before);
        let shown = ends_on(span);
        if let Some((line, tag)) = self.polyline.line_at(shown)
            && let Some(programmed) = self.spline.programmed.last_mut()
        {
            programmed.tag = self.pieces.tag_at(shown, line.to).unwrap_or(tag);
        }
        let least = self.least_end_in(before);
        let mut here = self.polyline.line_at(span.from);
        for _ in 0..VERTICES {
            let Some((line, tag)) = here.filter(|(line, _)| line.to < span.to) else { break };
            here = self.polyline.line_at(line.to).filter(|(next, _)| next.to > line.to);
            // Chords of a curve have one tag.
            let changes = here.is_some_and(|(_, next)| next != tag);
            if changes && (line.to - line.from).to_mm::<S>() >= least {
                self.pieces.note_end(line, tag);
            }
        }
        self.pieces.shown(span, least);
    }

    /// Where a span ends that is to end about there, or there if that is `fixed`: at the end of a piece that is near and no shorter than half of the span,
    /// or of a line. Pieces are `least` mm long at least.
    fn to_end(&self, span: Interval, fixed: bool, least: S) -> Length {
        let half = (span.to - span.from) / 2;
        let near = || self.pieces.end_near(span, least.greatest(half.to_mm()));
        let piece = if fixed { None } else { near() };
        piece
            .or_else(|| self.to_line(span, fixed, least * S::of(LONGER_IN_BENDS)))
            .unwrap_or(span.to)
    }

    /// The end of a line of at least so many mm at which a span ends. A span that begins at the end of a line may lead past others; one that begins
    /// within a line ends with that. So another tag begins to be shown where a line ends, and the motion rests there for a stop.
    fn to_line(&self, Interval { from, to }: Interval, fixed: bool, least: S) -> Option<Length> {
        let cut = (to - from) / CUT_OFF;
        let line = self.polyline.line_end(from);
        let within = self.polyline.leaving(from).is_none();
        if fixed && !within {
            return None;
        }
        let last = if fixed { to - cut } else { to };
        let last = if within { line.min(last) } else { last };
        let end = self.polyline.last_end(Interval { from: from + cut, to: last }, least);
        if within {
            return end;
        }
        let (whole, line): (S, S) = ((to - from).to_mm(), (line - from).to_mm());
        let longer = line > whole.greatest(least) && line < whole * S::of(LITTLE_LONGER);
        end.or_else(|| longer.then(|| from + Length::from_mm(line * S::of(0.5))))
    }

    /// Lays the knot that was asked for, or one nearer at which the band is kept. Returns where.
    fn lay_allowed(&mut self, here: Length, s: Length) -> Option<Length> {
        let span = s - here;
        let line = (self.polyline.line_end(here) - here).min(span);
        let line = if line < span / BESIDE { span / 4 } else { line };
        let tries = [s, here + span / 2, here + line, here + line / 4];
        let before = self.spline.spans.len();
        let taken =
            tries.into_iter().find(|&w| w > here && self.spline.try_push(&self.polyline, w));
        self.show(before);
        taken
    }

    /// Ends the spline at its last knot.
    fn tie(&mut self, end: Length) -> bool {
        if self.end.as_ref() == Some(&Tie::Smooth) {
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
            self.end.set(Some(Tie::Rest));
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
    #[inline(never)]
    pub(super) fn reopen(&mut self) {
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
}
