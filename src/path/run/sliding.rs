//! The sliding stretch of a run's spline: knots, control points, and the points at which it is held
//! against the programmed poly-line.
//!
//! With knots t the control point number j belongs to the Greville abscissa `(t[j-2] + t[j-1] +
//! t[j]) / 3`. The *base* spline has its control points on the poly-line, at these arc lengths
//! (Schoenberg's operator): it reproduces straight lines, needs no system to be solved, and every
//! span is checked against the band before its knots are taken. Smoothing ([`crate::spline::sweep`]) moves
//! control points away from there; what is moved is checked by the same bound ([`super::trial_span`]).

use super::polyline::Polyline;
use super::span::SpanCurve;
use super::trial_span::{SPAN_CHECKS, TrialSpan};
use crate::number::list::{part_mut, some};
use crate::number::vector::zero;
use crate::number::{Coord, Interval, Length, Scalar};
use crate::path::node::Programmed;
use crate::spline::banded::System;
use crate::spline::basis::Local;
use crate::spline::sweep::{End, Kind, OfLines, Smoothing, Tube, price};
use crate::spline::tube::{CheckPoint, Pole, Span, edges};
use core::array::from_fn;
use core::ops::Range;
use heapless::Vec;

/// Control points held.
pub const CONTROLS: usize = 48;
/// Intervals between knots before the newest over which the poly-line is still needed.
pub const NEEDED_BEHIND: usize = 5;
/// Spans held: each depends on four control points.
const SPANS: usize = CONTROLS - 3;
/// Check points held.
pub const CHECKS: usize = 128;
/// Places to be slow at that are remembered for the spans behind them.
const SLOW_POINTS: usize = 8;

/// A control point and the newest knot it depends on.
#[derive(Clone, Copy, Debug)]
pub struct Control<const N: usize> {
    /// The knot, by its arc length.
    pub knot: Length,
    /// Where the base spline has it.
    pub base: [Coord; N],
}

/// How a run starts or ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tie {
    /// At rest, in any direction.
    Rest,
    /// Going on along the line there.
    Smooth,
}

/// A place at which the motion has to be slow.
#[derive(Clone, Copy, Debug)]
struct SlowPoint<S> {
    s: Length,
    /// See [`crate::spline::sweep`], mm.
    reach: S,
}

/// What a knot would make.
struct Fit<S, const N: usize> {
    control: [Coord; N],
    /// The span that it completes.
    span: Option<TrialSpan<S>>,
}

/// The stretch.
pub struct SlidingSpline<S, const N: usize> {
    /// The two knots before that of the first control point.
    before: [Length; 2],
    pub controls: Vec<Control<N>, CONTROLS>,
    /// What smoothing does with them.
    pub poles: Vec<Pole<S, N>, CONTROLS>,
    pub spans: Vec<Span<S>, SPANS>,
    /// What is asked of their cells.
    pub programmed: Vec<Programmed<S>, SPANS>,
    pub checks: Vec<CheckPoint<S, N>, CHECKS>,
    /// Control points at the front that no longer move.
    pub frozen: usize,
    /// Control points at the front that have been smoothed before.
    smoothed: usize,
    /// Control points at the back that do not move yet, or at all.
    pub tied: usize,
    /// Places to be slow at ahead of the last span.
    slow_points: Vec<SlowPoint<S>, SLOW_POINTS>,
    /// Reach at the end of the last span.
    reach: S,
    /// What that may be away from the poly-line at its end, mm.
    end_radius: S,
    /// Repairs that the last smoothing took.
    repairs: u8,
}

/// A stretch of which no more than this part is new...
const MOSTLY: usize = 4;
/// ... is smoothed by this part of the sweeps, in eighths: the weights of the rest are nearly what they become. (Eight: no path of lines
/// that are smooth by more than 0.4 %.)
const FEWER: u16 = 2;
/// Where the last stretch took so many repairs, by one sweep more: lines with noise take up to a twentieth longer without.
const LABOURED: u8 = 2;

/// The whole of a line in [`Coord::towards`].
const WHOLE: f64 = (1_u64 << 62) as f64;

/// Reach where no such place is known.
const FAR: f64 = 1.0e3;

impl<S: Scalar, const N: usize> SlidingSpline<S, N> {
    pub const fn new() -> Self {
        Self {
            before: [Length::ZERO; 2],
            controls: Vec::new(),
            poles: Vec::new(),
            spans: Vec::new(),
            programmed: Vec::new(),
            checks: Vec::new(),
            frozen: 0,
            smoothed: 0,
            tied: 0,
            slow_points: Vec::new(),
            reach: S::ZERO,
            end_radius: S::ZERO,
            repairs: 0,
        }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        self.forget();
        self.slow_points.clear();
    }

    /// Forgets the spline, not the places to be slow at ahead.
    fn forget(&mut self) {
        self.controls.clear();
        self.poles.clear();
        self.spans.clear();
        self.programmed.clear();
        self.checks.clear();
    }

    /// Starts anew at an arc length; for a smooth start the first span is `step` long.
    pub fn begin(&mut self, polyline: &Polyline<S, N>, s: Length, tie: Tie, step: Length) {
        self.forget();
        self.smoothed = 0;
        let step = if tie == Tie::Smooth { step } else { Length::ZERO };
        self.before = [s - step * 2, s - step];
        let here = self.slow_points.iter().find(|slow| slow.s == s);
        self.reach = here.map_or(S::of(FAR), |slow| slow.reach);
        self.frozen = if tie == Tie::Smooth { 3 } else { 1 };
        self.tied = 3;
        self.push(polyline, s);
    }

    /// Knot number `j`, from -2 on.
    fn knot(&self, j: isize) -> Length {
        match j {
            -2 => self.before[0],
            -1 => self.before[1],
            _ => self.controls.get(j as usize).map_or(Length::ZERO, |control| control.knot),
        }
    }

    /// The newest knot.
    pub fn end(&self) -> Length {
        self.knot(self.controls.len().cast_signed() - 1)
    }

    /// Whether a knot and what comes with it can be taken.
    pub fn has_room(&self) -> bool {
        self.controls.len() + 3 <= CONTROLS && self.checks.len() + 3 * SPAN_CHECKS <= CHECKS
    }

    /// Knot number `j`, with more behind the last.
    fn knot_with(&self, j: isize, more: &[Length]) -> Length {
        let behind =
            j.checked_sub_unsigned(self.controls.len()).and_then(|k| usize::try_from(k).ok());
        match behind {
            Some(k) => more.get(k).or(more.last()).copied().unwrap_or(Length::ZERO),
            None => self.knot(j),
        }
    }

    /// The six knots of a span, with more behind the last.
    fn knots_of(&self, span: isize, more: &[Length]) -> [Length; 6] {
        from_fn(|i| self.knot_with(span - 2 + i.cast_signed(), more))
    }

    /// Control point number `j` of the base spline, with more behind the last.
    fn control(&self, j: isize, more: &[[Coord; N]]) -> [Coord; N] {
        let known = self.controls.get(j as usize).map(|control| &control.base);
        let new = || more.get((j as usize).checked_sub(self.controls.len())?);
        known.or_else(new).copied().unwrap_or([Coord::ZERO; N])
    }

    /// Control point number `j` of the base spline, which more knots would make.
    fn new_control(&self, polyline: &Polyline<S, N>, j: isize, more: &[Length]) -> [Coord; N] {
        let [a, b, c] = [j - 2, j - 1, j].map(|j| self.knot_with(j, more));
        polyline.point(Length::mean(a, b, c))
    }

    /// The arc lengths over which a span lies.
    pub fn interval(&self, span: usize) -> Interval {
        let span = span.cast_signed();
        Interval { from: self.knot(span), to: self.knot(span + 1) }
    }

    /// The same of the poly-line that lies beside a span: it may slip along that.
    pub fn beside(&self, span: usize) -> Interval {
        let Interval { from, to } = self.interval(span);
        let from = from + Length::from_mm(self.slip(span));
        Interval { from, to: (to + Length::from_mm(self.slip(span + 1))).max(from + Length::UNIT) }
    }

    /// How far along the poly-line from where it is held against the start of a span lies beside it, mm. A vertex is beside itself: it lies beyond the
    /// one line as far as before the other.
    fn slip(&self, span: usize) -> S {
        let check = self.spans.get(span).and_then(|span| self.checks.get(span.range())?.first());
        let (Some(check), Some(poles)) = (check, some::<_, 4>(&self.poles, span)) else {
            return S::ZERO;
        };
        if !(check.slip.back < S::ZERO && check.slip.ahead > S::ZERO) {
            return S::ZERO;
        }
        check.slip(&check.displaced(poles.each_ref().map(|pole| &pole.shift)))
    }

    /// Length between the last two knots.
    pub fn last_step(&self) -> Length {
        let n = self.controls.len().cast_signed();
        self.end() - self.knot(n - 2)
    }

    /// Arc length before which the polyline is no longer needed.
    pub fn oldest_needed(&self) -> Length {
        self.knot((self.controls.len().cast_signed() - 1 - NEEDED_BEHIND.cast_signed()).max(-2))
    }

    /// Whether the base spline keeps to the band in the spans that these knots would make, three at most, and there is room
    /// for them with all their check points: a span that lacks one would not be held to the band there.
    pub fn allows(&mut self, polyline: &Polyline<S, N>, more: &[Length]) -> bool {
        self.fits(polyline, more, false).is_some()
    }

    /// Takes a knot, if that is allowed and the spline might end there. Returns whether it is taken.
    pub fn try_push(&mut self, polyline: &Polyline<S, N>, s: Length) -> bool {
        let places = self.checks.len();
        // With room for the two that would end the spline there.
        let Some(Fit { control, span }) = self.fits(polyline, &[s, s, s], true) else {
            self.checks.truncate(places);
            return false;
        };
        self.take(s, control, span, places);
        true
    }

    /// Takes a knot that is allowed.
    pub fn push(&mut self, polyline: &Polyline<S, N>, s: Length) {
        let n = self.controls.len().cast_signed();
        let places = self.checks.len();
        let control = self.new_control(polyline, n, &[s]);
        let mut span = None;
        if n >= 3 {
            let knots = self.knots_of(n - 3, &[s]);
            let controls = from_fn(|i| self.control(n - 3 + i.cast_signed(), &[control]));
            span = TrialSpan::new(polyline, &knots, &controls, Some(&mut self.checks));
            debug_assert!(span.is_some() || knots[3] <= knots[2], "a knot that was not allowed");
            if span.is_none() {
                self.checks.truncate(places);
            }
        }
        self.take(s, control, span, places);
    }

    /// What more knots would make, up to three, if the base spline keeps to the band there. `keep`: the check points of
    /// the first are added to the list, which may have grown in any case.
    fn fits(
        &mut self,
        polyline: &Polyline<S, N>,
        more: &[Length],
        keep: bool,
    ) -> Option<Fit<S, N>> {
        if self.controls.len() + more.len() > CONTROLS
            || self.checks.len() + more.len() * SPAN_CHECKS > CHECKS
        {
            return None;
        }
        let known = self.controls.len().cast_signed();
        let new: [[Coord; N]; 3] =
            from_fn(|k| self.new_control(polyline, known + k.cast_signed(), more));
        let mut fit = Fit { control: new[0], span: None };
        for span in (known - 3).max(0)..known + more.len().cast_signed() - 3 {
            let knots = self.knots_of(span, more);
            if knots[3] <= knots[2] {
                continue;
            }
            let controls = from_fn(|i| self.control(span + i.cast_signed(), &new));
            let first = span + 3 == known;
            let list = (keep && first).then_some(&mut self.checks);
            let trial = TrialSpan::new(polyline, &knots, &controls, list)?;
            if first {
                fit.span = Some(trial);
            }
        }
        Some(fit)
    }

    /// Takes a knot with its control point and the span that it completes, whose check points begin at `places`.
    fn take(&mut self, s: Length, base: [Coord; N], span: Option<TrialSpan<S>>, places: usize) {
        let completed = self.controls.len().checked_sub(3);
        if let (Some(last), Some(pole)) = (self.controls.last(), self.poles.last_mut()) {
            pole.edge = from_fn(|i| base[i].minus(last.base[i]));
        }
        let kept = self.controls.push(Control { knot: s, base }).is_ok()
            & self.poles.push(Pole::new(zero())).is_ok();
        debug_assert!(kept, "no room for a control point");
        if let (Some(completed), Some(trial)) = (completed, span) {
            self.take_span(trial, self.knot(completed.cast_signed() + 1), places);
        }
    }

    fn take_span(
        &mut self,
        TrialSpan { mut span, programmed, end_radius }: TrialSpan<S>,
        end: Length,
        places: usize,
    ) {
        let start = self.reach;
        self.reach += span.step;
        self.slow_points.retain(|slow| slow.s >= end);
        for slow in &self.slow_points {
            self.reach = self.reach.least(slow.reach + (slow.s - end).to_mm());
        }
        span.reach = start.least(self.reach);
        span.price = price(span.reach);
        span.first_check = places as u16;
        span.checks = (self.checks.len() - places) as u16;
        let weight = <OfLines as Kind<S>>::DERIVATIVE.first_weight(&span);
        // The place where two spans meet is held against the narrower band of the two.
        let mut narrower = (places > 0).then_some(self.end_radius);
        self.end_radius = end_radius;
        for check in part_mut(&mut self.checks, span.range()) {
            check.weight = weight;
            if let Some(radius) = narrower.take() {
                check.radius = check.radius.least(radius);
            }
        }
        let kept = self.spans.push(span).is_ok() & self.programmed.push(programmed).is_ok();
        debug_assert!(kept, "no room for a span");
    }

    /// A place at which the motion has to be slow, and the reach there.
    #[inline(never)]
    pub fn slow_at(&mut self, s: Length, reach: S) {
        let mut slow = SlowPoint { s, reach };
        if self.slow_points.push(slow).is_err() {
            // The oldest is dropped: all others move to the front.
            for place in self.slow_points.iter_mut().rev() {
                core::mem::swap(place, &mut slow);
            }
        }
        // What it means for the spans before it.
        let end = self.knot(self.spans.len().cast_signed());
        let mut there = reach + (s - end).max(Length::ZERO).to_mm();
        self.reach = self.reach.least(there);
        for span in self.spans.iter_mut().rev() {
            if span.reach <= there {
                return;
            }
            span.reach = there;
            span.price = price(there);
            there += span.step;
        }
    }

    /// Forgets the first `count` spans, which have been handed on.
    #[inline(never)]
    pub fn release(&mut self, count: usize) {
        if count == 0 {
            return;
        }
        let places =
            self.spans.get(count).map_or(self.checks.len(), |s| usize::from(s.first_check));
        self.before = [self.knot(count.cast_signed() - 2), self.knot(count.cast_signed() - 1)];
        drop_front(&mut self.controls, count);
        drop_front(&mut self.poles, count);
        drop_front(&mut self.spans, count);
        drop_front(&mut self.programmed, count);
        drop_front(&mut self.checks, places);
        for span in &mut self.spans {
            span.first_check -= places as u16;
        }
        self.frozen = self.frozen.saturating_sub(count);
        self.smoothed = self.smoothed.saturating_sub(count);
    }

    /// The six knots of a span.
    fn local(&self, span: usize) -> Local<S> {
        Local::new(&self.knots_of(span.cast_signed(), &[]))
    }

    /// The curve of a span.
    pub fn curve(&self, span: usize) -> SpanCurve<S, N> {
        let edges = edges(&self.poles, span, |pole| pole.shift);
        let moved = |pole: &Pole<S, N>| pole.shift != [S::ZERO; N];
        let still = !some::<_, 4>(&self.poles, span).is_some_and(|poles| poles.iter().any(moved));
        let (first, step) =
            self.spans.get(span).map_or((edges, S::ONE), |s| (s.first(&edges), s.step));
        SpanCurve::new(first, step, still)
    }

    /// The point at the start of a span.
    pub fn start(&self, span: usize) -> [Coord; N] {
        let [before, _, after, _] = self.local(span).values(S::ZERO);
        self.point(span, before, after)
    }

    /// The point at the end of a span.
    pub fn finish(&self, span: usize) -> [Coord; N] {
        let local = self.local(span);
        let [_, before, _, after] = local.values(local.step());
        self.point(span + 1, before, after)
    }

    /// The point at a place of a span, of which this is the curve.
    pub fn place(&self, span: usize, curve: &SpanCurve<S, N>, place: S) -> [Coord; N] {
        let start = self.start(span);
        if !curve.is_straight() {
            return curve.point(place, &start);
        }
        // In integers: off the line by rounding, points would be a jolt of cells that know of none.
        let (finish, share) = (self.finish(span), (place * S::of(WHOLE)).to_i64());
        from_fn(|i| start[i].towards(finish[i], share))
    }

    /// The sum of three control points from `first` on; the factors add up to one.
    fn point(&self, first: usize, before: S, after: S) -> [Coord; N] {
        let (Some(c), Some(p)) =
            (some::<_, 3>(&self.controls, first), some::<_, 3>(&self.poles, first))
        else {
            return [Coord::ZERO; N];
        };
        let [first_share, last_share] = [before, after].map(|x| (x * S::of(WHOLE)).to_i64());
        from_fn(|i| {
            // The base in integers: the control points may be far apart.
            let origin = c[1].base[i];
            let base = origin.towards(c[0].base[i], first_share);
            let base = Coord::from_raw(
                base.raw() + (origin.towards(c[2].base[i], last_share).raw() - origin.raw()),
            );
            let middle = p[1].shift[i];
            let shift =
                middle + (p[0].shift[i] - middle) * before + (p[2].shift[i] - middle) * after;
            base.plus(shift)
        })
    }

    /// Begins to smooth the spline by `sweeps` sweeps; the control points that may move are those between
    /// the frozen and the tied ones. Where most of them have been smoothed before, a part of the sweeps does. `None` if
    /// there is nothing to do.
    #[inline(never)]
    pub fn begin_smoothing(&mut self, sweeps: u16) -> Option<Smoothing<S>> {
        let free = self.free();
        let new = free.end.saturating_sub(self.smoothed.max(free.start));
        let most_are_old = new * MOSTLY <= free.len();
        self.smoothed = free.end;
        let more = u16::from(self.repairs >= LABOURED);
        self.repairs = 0;
        let (sweeps, end) = if most_are_old {
            ((sweeps * FEWER).div_ceil(8) + more, End::Nearly)
        } else {
            (sweeps, End::Inside)
        };
        self.tube().begin(sweeps, &free, end)
    }

    /// One step of a smoothing of the spline as it stands; `None` if that was the last.
    #[inline(never)]
    pub fn smooth_on(&mut self, now: Smoothing<S>) -> Option<Smoothing<S>> {
        let mut system = System::<S, N, CONTROLS>::new();
        self.repairs = self.repairs.max(now.repairs());
        let free = self.free();
        self.tube().step(now, &free, &mut system)
    }

    /// The control points that may move.
    fn free(&self) -> Range<usize> {
        self.frozen..self.controls.len().saturating_sub(self.tied)
    }

    fn tube(&mut self) -> Tube<'_, S, N, OfLines> {
        Tube { poles: &mut self.poles, spans: &self.spans, checks: &mut self.checks, kind: OfLines }
    }
}

fn drop_front<T: Copy, const M: usize>(list: &mut Vec<T, M>, count: usize) {
    let kept = list.len().saturating_sub(count);
    let first = list.len() - kept;
    list.copy_within(first.., 0);
    list.truncate(kept);
}
