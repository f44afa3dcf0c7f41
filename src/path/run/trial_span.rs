//! A span of a run that may be taken on: held against the poly-line beside it.
//!
//! The bound: spline and poly-line are compared at equal arc length of the poly-line, so the
//! Frechet distance is bounded, not only the distance. Between two neighbouring check points
//! the poly-line is straight, so the difference e has the spline's own second derivative, which is
//! linear on a span: |e| <= max(|e_a|, |e_b|) + gap^2 / 8 max |c''|.

use super::narrows::Room;
use super::polyline::{Polyline, Vertex};
use crate::number::vector::{Vector, dot, norm, sub, zero};
use crate::number::{Coord, Interval, Length, Scalar};
use crate::path::budget;
use crate::path::leg::Leg;
use crate::path::node::Programmed;
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
pub struct TrialSpan<S> {
    pub span: Span<S>,
    /// What is asked of its cells.
    pub programmed: Programmed<S>,
    /// What it may be away from the poly-line at its end, mm.
    pub end_radius: S,
}

/// A line of the poly-line: the vertices at its start and its end, and the room beside it.
type Line<'a, S, const N: usize> = (&'a Vertex<S, N>, &'a Vertex<S, N>, Room<S>);

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
    /// Over six knots, with four control points; `None` if there is no line beside it.
    fn new(
        polyline: &Polyline<S, N>,
        knots: &[Length; 6],
        [origin, others @ ..]: &[[Coord; N]; 4],
    ) -> Option<Self> {
        let interval = Interval { from: knots[2], to: knots[3] };
        let lines = polyline.lines(interval);
        let leg = lines.map(|(_, end, _)| end.leg).reduce(|a, b| a.with(&b))?;
        Some(Self {
            local: Local::new(knots),
            interval,
            origin: *origin,
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

    /// Held against a line at an arc length, where that is `at`, or if it `slips` against what of it is near there.
    fn check(
        &self,
        s: Length,
        at: &[Coord; N],
        (start, end, room): Line<'_, S, N>,
        slips: bool,
    ) -> CheckPoint<S, N> {
        let basis = self.local.values((s - self.interval.from).to_mm());
        let [b, c, d] = &self.others;
        let there: Vector<S, N> = from_fn(|i| at[i].minus(self.origin[i]));
        let off = from_fn(|i| basis[1] * b[i] + basis[2] * c[i] + basis[3] * d[i] - there[i]);
        let mut check = CheckPoint {
            basis,
            off,
            radius: room.radius(s, self.radius),
            weight: S::ZERO,
            along: zero(),
            slip: Slip::NONE,
        };
        if slips {
            let most = self.leg.tolerance * S::of(SLIP);
            check.along = end.direction;
            let slip = Slip {
                back: -most.least((s - start.s).to_mm()),
                ahead: most.least((end.s - s).to_mm()),
            };
            check.slip = room.slip(s, slip);
        }
        check
    }
}

/// The check points of a span, as they are found.
struct Checked<'a, S, const N: usize, const CHECKS: usize> {
    list: Option<&'a mut Vec<CheckPoint<S, N>, CHECKS>>,
    count: usize,
    /// What the spline may be away from the poly-line where nothing is narrower, and is at most, with what it has less elsewhere, mm.
    radius: S,
    most: S,
    /// Whether it is nowhere farther than it may be.
    inside: bool,
}

impl<S: Scalar, const N: usize, const CHECKS: usize> Checked<'_, S, N, CHECKS> {
    /// `None` if there is no room for it.
    fn add(&mut self, check: CheckPoint<S, N>) -> Option<()> {
        self.count += 1;
        self.see(&check);
        if let Some(list) = &mut self.list {
            list.push(check).ok()?;
        }
        (self.count <= SPAN_CHECKS).then_some(())
    }

    /// Takes note of what one misses the poly-line by.
    #[inline(never)]
    fn see(&mut self, check: &CheckPoint<S, N>) {
        let miss = norm(&check.slipped(&check.off));
        self.most = self.most.greatest(miss + (self.radius - check.radius));
        self.inside &= miss <= check.radius;
    }
}

impl<S: Scalar> TrialSpan<S> {
    /// A span over six knots with four control points, whose check points are added to a list if there is one; `None`
    /// if the base spline leaves the band there, or has more vertices beside it than there is room for. (The list may
    /// have grown then.)
    pub fn new<const N: usize, const CHECKS: usize>(
        polyline: &Polyline<S, N>,
        knots: &[Length; 6],
        controls: &[[Coord; N]; 4],
        list: Option<&mut Vec<CheckPoint<S, N>, CHECKS>>,
    ) -> Option<Self> {
        let base = Base::new(polyline, knots, controls)?;
        let Interval { from, to } = base.interval;
        let mut checked =
            Checked { list, count: 0, radius: base.radius, most: S::ZERO, inside: true };
        let mut widest = Length::ZERO;
        let mut before = None;
        let mut end_radius = base.radius;
        for line in polyline.lines(base.interval) {
            let (start, end, _) = line;
            let (first, last) = (start.s.max(from), end.s.min(to));
            // The start: a vertex, or a point of the line.
            let at = end.beside(start, first);
            if start.s < first {
                checked.add(base.check(first, &at, line, true))?;
            } else if is_sharp(start, end) {
                if let Some(before) = before {
                    // Both lines must be near where they meet.
                    checked.add(base.check(first, &at, before, true))?;
                }
                checked.add(base.check(first, &at, line, true))?;
            } else {
                checked.add(base.check(first, &at, line, false))?;
            }
            let mut gap = last - first;
            // Gaps of little more than half a span.
            if gap > (to - from) / 8 * 5 {
                gap = gap / 2 + Length::UNIT;
                let middle = first + gap;
                checked.add(base.check(middle, &end.beside(start, middle), line, true))?;
            }
            widest = widest.max(gap);
            before = Some(line);
            if last == to {
                let next = if end.s == to { polyline.leaving(to) } else { None };
                let sharp = next.is_some_and(|next| is_sharp(end, next));
                let at_end = base.check(to, &end.beside(start, to), line, sharp || end.s > to);
                end_radius = at_end.radius;
                if sharp {
                    checked.add(at_end)?;
                } else {
                    // The first check point of the next span.
                    checked.see(&at_end);
                }
            }
        }
        let gap: S = widest.to_mm();
        let edges = base.edges();
        let rest = base.local.step() * base.local.step() * S::of(budget::REST);
        let span = Span::new(&base.local, gap * gap * S::of(0.125) + rest);
        let holds = checked.inside && checked.most + span.slack(&edges) <= base.radius;
        let programmed = base.leg.programmed;
        (holds && span.goes_on(&edges)).then_some(Self { span, programmed, end_radius })
    }
}

/// Whether two lines meet at more than a slight turn.
fn is_sharp<S: Scalar, const N: usize>(before: &Vertex<S, N>, after: &Vertex<S, N>) -> bool {
    let turn = sub(&after.direction, &before.direction);
    dot(&turn, &turn) > S::of(SHARP * SHARP)
}
