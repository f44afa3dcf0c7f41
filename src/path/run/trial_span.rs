//! A span of a run that may be taken on: held against the poly-line beside it.
//!
//! The bound: spline and poly-line are compared at equal arc length of the poly-line, so the
//! Frechet distance is bounded, not only the distance. Between two neighbouring check points
//! the poly-line is straight, so the difference e has the spline's own second derivative, which is
//! linear on a span: |e| <= max(|e_a|, |e_b|) + gap^2 / 8 max |c''|.

use super::polyline::{Polyline, Vertex};
use crate::number::vector::{Vector, dot, norm, sub, zero};
use crate::number::{Coord, Interval, Length, Scalar};
use crate::path::budget;
use crate::path::leg::Leg;
use crate::spline::basis::Local;
use crate::spline::tube::{CheckPoint, Slip, Span};
use core::array::from_fn;
use heapless::Vec;

/// Check points in one span: its start, the vertices of the poly-line in it, and more if
/// they are far apart.
pub const SPAN_CHECKS: usize = 10;
/// Turn, rad, from which on a vertex of the poly-line is compared with either of its lines instead of
/// by arc length: the inside of a corner is farther from its vertex than from its lines.
/// (Half or twice: no path by more than 0.7 %.)
const SHARP: f64 = 0.15;
/// How far along its line the point that a check point is compared with may lie, as a share of the tolerance.
/// (Half: no path by more than 0.6 %.)
const SLIP: f64 = 2.0;

/// A span that may be taken on.
pub struct TrialSpan<S, const N: usize> {
    pub span: Span<S>,
    /// What is asked for on it.
    pub leg: Leg<S>,
    pub checks: Vec<CheckPoint<S, N>, SPAN_CHECKS>,
}

/// A line of the poly-line: the vertices at its start and its end.
type Line<'a, S, const N: usize> = (&'a Vertex<S, N>, &'a Vertex<S, N>);

/// A span of the base spline.
struct Base<S, const N: usize> {
    local: Local<S>,
    interval: Interval,
    /// Its first control point, and from there to the other three, mm.
    origin: [Coord; N],
    others: [Vector<S, N>; 3],
    leg: Leg<S>,
    /// What it may be away from the poly-line, mm.
    radius: S,
}

impl<S: Scalar, const N: usize> Base<S, N> {
    /// Over six knots; `None` if there is no line beside it.
    fn new(polyline: &Polyline<S, N>, knots: &[Length; 6]) -> Option<Self> {
        let interval = Interval { from: knots[2], to: knots[3] };
        let lines = polyline.lines(interval);
        let leg = lines.map(|(_, end)| end.leg).reduce(|a, b| a.with(&b))?;
        let [origin, others @ ..]: [[Coord; N]; 4] =
            from_fn(|j| polyline.point(Length::mean(knots[j], knots[j + 1], knots[j + 2])));
        Some(Self {
            local: Local::new(knots),
            interval,
            origin,
            others: others.each_ref().map(|at| from_fn(|i| at[i].minus(origin[i]))),
            leg,
            radius: budget::run_radius(leg.tolerance, leg.error),
        })
    }

    /// The edges of its control polygon.
    fn edges(&self) -> [Vector<S, N>; 3] {
        let [b, c, d] = &self.others;
        [*b, sub(c, b), sub(d, c)]
    }

    /// Held against the poly-line at an arc length, where that is `at`, or against what of a line is near there.
    fn check(&self, s: Length, at: &[Coord; N], line: Option<Line<'_, S, N>>) -> CheckPoint<S, N> {
        let basis = self.local.values((s - self.interval.from).to_mm());
        let [b, c, d] = &self.others;
        let there: Vector<S, N> = from_fn(|i| at[i].minus(self.origin[i]));
        let off = from_fn(|i| basis[1] * b[i] + basis[2] * c[i] + basis[3] * d[i] - there[i]);
        let mut check = CheckPoint {
            basis,
            off,
            radius: self.radius,
            weight: S::ZERO,
            along: zero(),
            slip: Slip::NONE,
            miss: off,
        };
        if let Some((start, end)) = line {
            let most = self.leg.tolerance * S::of(SLIP);
            check.along = end.direction;
            check.slip = Slip {
                back: -most.least((s - start.s).to_mm()),
                ahead: most.least((end.s - s).to_mm()),
            };
            check.measure(&[[S::ZERO; N]; 4]);
        }
        check
    }
}

impl<S: Scalar, const N: usize> TrialSpan<S, N> {
    /// A span over six knots with its check points; `None` if the base spline leaves the band there, or has more
    /// vertices beside it than there is room for.
    pub fn new(polyline: &Polyline<S, N>, knots: &[Length; 6]) -> Option<Self> {
        let base = Base::new(polyline, knots)?;
        let Interval { from, to } = base.interval;
        let mut checks: Vec<CheckPoint<S, N>, SPAN_CHECKS> = Vec::new();
        let mut at_end = S::ZERO;
        let mut widest = Length::ZERO;
        for line in polyline.lines(base.interval) {
            let (start, end) = line;
            let (first, last) = (start.s.max(from), end.s.min(to));
            // The start: a vertex, or a point of the line.
            let at = polyline.point(first);
            if start.s < first {
                checks.push(base.check(first, &at, Some(line))).ok()?;
            } else if is_sharp(start, end) {
                if first > from {
                    // Both lines must be near where they meet.
                    let point = Interval { from: first - Length::UNIT, to: first };
                    let before = polyline.lines(point).next();
                    checks.push(base.check(first, &at, before)).ok()?;
                }
                checks.push(base.check(first, &at, Some(line))).ok()?;
            } else {
                checks.push(base.check(first, &at, None)).ok()?;
            }
            let mut gap = last - first;
            // Gaps of little more than half a span.
            if gap > (to - from) / 8 * 5 {
                gap = gap / 2 + Length::UNIT;
                let middle = first + gap;
                checks.push(base.check(middle, &polyline.point(middle), Some(line))).ok()?;
            }
            widest = widest.max(gap);
            if last == to {
                let sharp = polyline.leaving(to).is_some_and(|next| is_sharp(end, next));
                let line = (sharp || end.s > to).then_some(line);
                let end = base.check(to, &polyline.point(to), line);
                if sharp {
                    checks.push(end).ok()?;
                } else {
                    // The first check point of the next span.
                    at_end = norm(&end.miss);
                }
            }
        }
        let gap: S = widest.to_mm();
        let edges = base.edges();
        let rest = base.local.step() * base.local.step() * S::of(budget::REST);
        let span = Span::new(&base.local, gap * gap * S::of(0.125) + rest);
        let sag = span.slack(&edges);
        let holds = |miss: S| miss + sag <= base.radius;
        let inside = holds(at_end) && checks.iter().all(|check| holds(norm(&check.miss)));
        (inside && span.goes_on(&edges)).then_some(Self { span, leg: base.leg, checks })
    }
}

/// Whether two lines meet at more than a slight turn.
fn is_sharp<S: Scalar, const N: usize>(before: &Vertex<S, N>, after: &Vertex<S, N>) -> bool {
    let turn = sub(&after.direction, &before.direction);
    dot(&turn, &turn) > S::of(SHARP * SHARP)
}
