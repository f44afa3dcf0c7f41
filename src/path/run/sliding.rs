//! The sliding stretch of a run's spline: knots, control points, and the points at which it is held
//! against the programmed poly-line.
//!
//! With knots t the control point number j belongs to the Greville abscissa (t[j-2] + t[j-1] +
//! t[j]) / 3. The *base* spline has its control points on the poly-line, at these arc lengths
//! (Schoenberg's operator): it reproduces straight lines, needs no system to be solved, and every
//! span is checked against the band before its knots are taken. Smoothing ([`crate::spline::sweep`]) moves
//! control points away from there; what is moved is checked by the same bound.
//!
//! The bound: spline and poly-line are compared at equal arc length of the poly-line, so the
//! Frechet distance is bounded, not only the distance. Between two neighbouring places of comparison
//! the poly-line is straight, so the difference e has the spline's own second derivative, which is
//! linear on a span: |e| <= max(|e_a|, |e_b|) + gap^2 / 8 max |c''|.

use super::polyline::{Leg, Polyline, Vertex};
use super::span::SpanCurve;
use crate::number::list::some;
use crate::number::vector::{Vector, dot, norm, sub, zero};
use crate::number::{Coord, Length, Scalar};
use crate::path::budget;
use crate::spline::basis::Local;
use crate::spline::sweep::{Order, Reference, System, Tube, price};
use crate::spline::tube::{Place, Pole, Span, edges};
use core::array::from_fn;
use heapless::Vec;

/// Control points held.
pub const CONTROLS: usize = 48;
/// Places of comparison held.
pub const PLACES: usize = 128;
/// Places of comparison in one span: its start, the vertices of the poly-line in it, and more if
/// they are far apart.
pub const SPAN_PLACES: usize = 10;
/// Turn, rad, from which on a vertex of the poly-line is compared with either of its lines instead of
/// by arc length: the inside of a corner is farther from its vertex than from its lines.
const SHARP: f64 = 0.15;
/// How far along its line the point that a place is compared with may lie, as a share of the tolerance.
const SLIP: f64 = 2.0;
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

/// The stretch.
pub struct SlidingSpline<S, const N: usize> {
    /// The two knots before that of the first control point.
    before: [Length; 2],
    pub controls: Vec<Control<N>, CONTROLS>,
    /// What smoothing does with them.
    pub poles: Vec<Pole<S, N>, CONTROLS>,
    pub spans: Vec<Span<S>, CONTROLS>,
    /// The lines beside them.
    pub legs: Vec<Leg<S>, CONTROLS>,
    pub places: Vec<Place<S, N>, PLACES>,
    /// Control points at the front that no longer move.
    pub frozen: usize,
    /// Control points at the back that do not move yet, or at all.
    pub tied: usize,
    /// Arc length and reach of places to be slow at ahead of the last span.
    slow_points: Vec<(Length, S), SLOW_POINTS>,
    /// Reach at the end of the last span.
    reach: S,
}

/// A span that may be taken on.
struct Draft<S, const N: usize> {
    span: Span<S>,
    leg: Leg<S>,
    places: Vec<Place<S, N>, SPAN_PLACES>,
}

/// Reach where no such place is known.
const FAR: f64 = 1.0e3;

impl<S: Scalar, const N: usize> SlidingSpline<S, N> {
    pub const fn new() -> Self {
        Self {
            before: [Length::ZERO; 2],
            controls: Vec::new(),
            poles: Vec::new(),
            spans: Vec::new(),
            legs: Vec::new(),
            places: Vec::new(),
            frozen: 0,
            tied: 0,
            slow_points: Vec::new(),
            reach: S::ZERO,
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
        self.legs.clear();
        self.places.clear();
    }

    /// Starts anew at an arc length; for a smooth start the first span is `step` long.
    pub fn begin(&mut self, polyline: &Polyline<S, N>, s: Length, tie: Tie, step: Length) {
        self.forget();
        let step = if tie == Tie::Smooth { step } else { Length::ZERO };
        self.before = [s - step * 2, s - step];
        let here = self.slow_points.iter().find(|(at, _)| *at == s);
        self.reach = here.map_or(S::of(FAR), |(_, reach)| *reach);
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
        self.controls.len() + 3 <= CONTROLS && self.places.len() + 3 * SPAN_PLACES <= PLACES
    }

    /// The six knots of a span.
    fn knots_of(&self, span: isize) -> [Length; 6] {
        from_fn(|i| self.knot(span - 2 + i.cast_signed()))
    }

    /// Arc lengths at which a span starts and ends.
    pub fn stretch(&self, span: usize) -> (Length, Length) {
        let span = span.cast_signed();
        (self.knot(span), self.knot(span + 1))
    }

    /// Length between the last two knots.
    pub fn last_step(&self) -> Length {
        let n = self.controls.len().cast_signed();
        self.end() - self.knot(n - 2)
    }

    /// Arc length before which the polyline is no longer needed.
    pub fn oldest_needed(&self) -> Length {
        self.knot((self.controls.len().cast_signed() - 6).max(-2))
    }

    /// Whether the base spline keeps to the band in the spans that these knots would make.
    pub fn allows(&self, polyline: &Polyline<S, N>, more: &[Length]) -> bool {
        let known = self.controls.len().cast_signed();
        let first = (known - 3).max(0);
        (first..known + more.len().cast_signed() - 3).all(|span| {
            let knots: [Length; 6] = from_fn(|i| {
                let j = span - 2 + i.cast_signed();
                let new = || more.get((j - known) as usize).copied().unwrap_or(Length::ZERO);
                if j < known { self.knot(j) } else { new() }
            });
            knots[3] <= knots[2] || Self::draft(polyline, &knots).is_some()
        })
    }

    /// Takes a knot.
    pub fn push(&mut self, polyline: &Polyline<S, N>, s: Length) {
        let n = self.controls.len().cast_signed();
        let base = polyline.point(Length::mean(self.knot(n - 2), self.knot(n - 1), s));
        if let (Some(last), Some(pole)) = (self.controls.last(), self.poles.last_mut()) {
            pole.edge = from_fn(|i| base[i].minus(last.base[i]));
        }
        let _ = self.controls.push(Control { knot: s, base });
        let _ = self.poles.push(Pole::new(zero()));
        if n >= 3 {
            let knots = self.knots_of(n - 3);
            if let Some(draft) = Self::draft(polyline, &knots) {
                self.take(draft, knots[3]);
            }
        }
    }

    fn take(&mut self, draft: Draft<S, N>, end: Length) {
        let mut span = draft.span;
        let start = self.reach;
        self.reach += span.step;
        self.slow_points.retain(|(s, _)| *s >= end);
        for (s, reach) in &self.slow_points {
            self.reach = self.reach.least(*reach + (*s - end).to_mm());
        }
        span.reach = start.least(self.reach);
        span.price = price(span.reach);
        span.first_place = self.places.len() as u16;
        span.places = draft.places.len() as u16;
        // The place where two spans meet is held against the narrower band of the two.
        let mut narrower = self.places.last().map(|place| place.radius);
        for mut place in draft.places {
            place.weight = Order::Third.first_weight(&span);
            if let Some(radius) = narrower.take() {
                place.radius = place.radius.least(radius);
            }
            let _ = self.places.push(place);
        }
        let _ = self.spans.push(span);
        let _ = self.legs.push(draft.leg);
    }

    /// A place at which the motion has to be slow, and the reach there.
    pub fn slow_at(&mut self, s: Length, reach: S) {
        if self.slow_points.is_full() {
            self.slow_points.remove(0);
        }
        let _ = self.slow_points.push((s, reach));
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

    /// A span over six knots with its places of comparison; `None` if the base spline leaves the band
    /// there, or has more vertices beside it than there is room for.
    fn draft(polyline: &Polyline<S, N>, knots: &[Length; 6]) -> Option<Draft<S, N>> {
        let local = Local::new(knots);
        let (from, to) = (knots[2], knots[3]);
        let leg = polyline.lines(from, to).map(|(_, end)| end.leg).reduce(|a, b| a.with(&b))?;
        let radius = budget::run_radius(leg.tolerance, leg.error);
        let [origin, others @ ..]: [[Coord; N]; 4] =
            from_fn(|j| polyline.point(Length::mean(knots[j], knots[j + 1], knots[j + 2])));
        let from_origin = |at: &[Coord; N]| -> Vector<S, N> { from_fn(|i| at[i].minus(origin[i])) };
        let [b, c, d] = others.each_ref().map(from_origin);
        let place = |s: Length, at: &[Coord; N], line: Option<(&Vertex<S, N>, &Vertex<S, N>)>| {
            let basis = local.values((s - from).to_mm());
            let there = from_origin(at);
            let off = from_fn(|i| basis[1] * b[i] + basis[2] * c[i] + basis[3] * d[i] - there[i]);
            let mut place = Place {
                basis,
                off,
                radius,
                weight: S::ZERO,
                along: zero(),
                slip: (S::ZERO, S::ZERO),
                miss: off,
            };
            if let Some((start, end)) = line {
                let most = leg.tolerance * S::of(SLIP);
                place.along = end.direction;
                place.slip = (-most.least((s - start.s).to_mm()), most.least((end.s - s).to_mm()));
                place.measure(&[[S::ZERO; N]; 4]);
            }
            place
        };
        let mut places: Vec<Place<S, N>, SPAN_PLACES> = Vec::new();
        let mut at_end = S::ZERO;
        let mut widest = Length::ZERO;
        for line in polyline.lines(from, to) {
            let (start, end) = line;
            let (first, last) = (start.s.max(from), end.s.min(to));
            // The start: a vertex, or a place on the line.
            let at = polyline.point(first);
            if start.s < first {
                places.push(place(first, &at, Some(line))).ok()?;
            } else if is_sharp(start, end) {
                if first > from {
                    // Both lines must be near where they meet.
                    let before = polyline.lines(first - Length::UNIT, first).next();
                    places.push(place(first, &at, before)).ok()?;
                }
                places.push(place(first, &at, Some(line))).ok()?;
            } else {
                places.push(place(first, &at, None)).ok()?;
            }
            let mut gap = last - first;
            // Gaps of little more than half a span.
            if gap > (to - from) / 8 * 5 {
                gap = gap / 2 + Length::UNIT;
                let middle = first + gap;
                places.push(place(middle, &polyline.point(middle), Some(line))).ok()?;
            }
            widest = widest.max(gap);
            if last == to {
                let sharp = polyline.leaving(to).is_some_and(|next| is_sharp(end, next));
                let end = place(to, &polyline.point(to), (sharp || end.s > to).then_some(line));
                if sharp {
                    places.push(end).ok()?;
                } else {
                    // The first place of the next span.
                    at_end = norm(&end.miss);
                }
            }
        }
        let gap: S = widest.to_mm();
        let edges = [b, sub(&c, &b), sub(&d, &c)];
        let rest = local.step() * local.step() * S::of(budget::RUN_REST);
        let span = Span::new(&local, gap * gap * S::of(0.125) + rest);
        let sag = span.slack(&edges);
        let inside =
            at_end + sag <= radius && places.iter().all(|place| norm(&place.miss) + sag <= radius);
        (inside && span.goes_on(&edges)).then_some(Draft { span, leg, places })
    }

    /// Forgets the first `count` spans, which have been handed on.
    pub fn release(&mut self, count: usize) {
        if count == 0 {
            return;
        }
        let places =
            self.spans.get(count).map_or(self.places.len(), |s| usize::from(s.first_place));
        self.before = [self.knot(count.cast_signed() - 2), self.knot(count.cast_signed() - 1)];
        drop_front(&mut self.controls, count);
        drop_front(&mut self.poles, count);
        drop_front(&mut self.spans, count);
        drop_front(&mut self.legs, count);
        drop_front(&mut self.places, places);
        for span in &mut self.spans {
            span.first_place -= places as u16;
        }
        self.frozen = self.frozen.saturating_sub(count);
    }

    /// The six knots of a span.
    fn local(&self, span: usize) -> Local<S> {
        Local::new(&self.knots_of(span.cast_signed()))
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

    /// The sum of three control points from `first` on; the factors add up to one.
    fn point(&self, first: usize, before: S, after: S) -> [Coord; N] {
        let (Some(c), Some(p)) =
            (some::<_, 3>(&self.controls, first), some::<_, 3>(&self.poles, first))
        else {
            return [Coord::ZERO; N];
        };
        from_fn(|i| {
            // The base in f64: the control points may be far apart.
            let (b0, b2): (f64, f64) =
                (c[0].base[i].minus(c[1].base[i]), c[2].base[i].minus(c[1].base[i]));
            let base = b0 * before.to_f64() + b2 * after.to_f64();
            let middle = p[1].shift[i];
            let shift =
                middle + (p[0].shift[i] - middle) * before + (p[2].shift[i] - middle) * after;
            c[1].base[i].plus(base).plus(shift)
        })
    }

    /// Smooths the spline by `sweeps` sweeps; the control points that may move are those between
    /// the frozen and the tied ones.
    pub fn improve(&mut self, sweeps: u16) {
        let mut system = System::<S, N, CONTROLS>::new();
        let last = self.controls.len().saturating_sub(self.tied);
        Tube {
            poles: &mut self.poles,
            spans: &self.spans,
            places: &mut self.places,
            reference: Reference::Lines,
            order: Order::Third,
        }
        .improve(sweeps, (self.frozen, last), &mut system);
    }
}

/// Whether two lines meet at more than a slight turn.
fn is_sharp<S: Scalar, const N: usize>(before: &Vertex<S, N>, after: &Vertex<S, N>) -> bool {
    let turn = sub(&after.direction, &before.direction);
    dot(&turn, &turn) > S::of(SHARP * SHARP)
}

fn drop_front<T: Copy, const M: usize>(list: &mut Vec<T, M>, count: usize) {
    let kept = list.len().saturating_sub(count);
    let first = list.len() - kept;
    list.copy_within(first.., 0);
    list.truncate(kept);
}
