//! A cubic B-spline with fixed capacity.

use crate::error::SplineError;
use core::array::from_fn;
use heapless::Vec;
use splineway::number::Scalar;
use splineway::number::list::some_mut;
use splineway::number::quadrature::{FIVE, Point};
use splineway::number::vector::{Vector, dot, mix, norm, sub, zero};
use splineway::spline::basis::Local;
use splineway::spline::bezier;

/// Parts of a span in its arc length.
const PARTS: u32 = 8;

/// A cubic B-spline in `N` axes with at most `CAP` control points, mm (degrees on rotary axes).
///
/// Open splines have Bezier end conditions: they start and end in their first and last control point,
/// along the legs of the control polygon there (Naseath 2007, section 2.3.2). Knots are kept
/// each once: with m control points an open spline has m - 2 of them, m - 3 spans; a closed one has m
/// intervals and m spans. All inner knots are single, so the spline is C2.
#[derive(Clone, Debug)]
pub struct Spline<S, const N: usize, const CAP: usize> {
    controls: Vec<Vector<S, N>, CAP>,
    /// Open: the knots, each once. Closed: the knots from 0 on; the last is the period.
    knots: Vec<S, CAP>,
    closed: bool,
}

/// Adds an item to a list that has room for it, by the sizes that its owner has checked.
pub fn append<T, const CAP: usize>(list: &mut Vec<T, CAP>, item: T) {
    let added = list.push(item);
    debug_assert!(added.is_ok(), "a list without room");
}

/// Puts something into a list that has room for it.
fn insert<T, const CAP: usize>(list: &mut Vec<T, CAP>, at: usize, mut new: T) {
    for old in list.iter_mut().skip(at) {
        core::mem::swap(old, &mut new);
    }
    append(list, new);
}

fn in_order<S: Scalar>(knots: &[S]) -> Result<(), SplineError> {
    for (index, (before, knot)) in knots.iter().zip(knots.iter().skip(1)).enumerate() {
        // A NaN fails too.
        if !(knot > before) {
            return Err(SplineError::KnotOrder { index: index + 1, value: knot.to_f64() });
        }
    }
    Ok(())
}

/// Curvature, 1/mm, of a cubic Bezier curve at the share `u`: see [`Spline::curvature`].
fn bezier_curvature<S: Scalar, const N: usize>(mut b: [Vector<S, N>; 4], u: S) -> S {
    // The part that is longer, seen from its end.
    if u > S::of(0.5) {
        b.reverse();
    }
    let u = u.least(S::ONE - u);
    let between = |p: &Vector<S, N>, q: &Vector<S, N>| mix(S::ONE - u, p, u, q);
    let (p01, p12, p23) = (between(&b[0], &b[1]), between(&b[1], &b[2]), between(&b[2], &b[3]));
    let (p012, p123) = (between(&p01, &p12), between(&p12, &p23));
    let start = between(&p012, &p123);
    let leg = sub(&p123, &start);
    let third = sub(&p23, &start);
    let a = norm(&leg);
    let along = dot(&third, &leg) / (a * a);
    let h = norm(&mix(S::ONE, &third, -along, &leg));
    S::of(2.0 / 3.0) * h / (a * a)
}

impl<S: Scalar, const N: usize, const CAP: usize> Spline<S, N, CAP> {
    /// An open spline. `knots` follow any of three conventions, told apart by their number: each once
    /// (m - 2 for m control points; the thesis's parser, section 3.4), threefold at the ends (m +
    /// 2; Sederberg and the thesis's text), or fourfold (m + 4; most CAD systems).
    ///
    /// # Errors
    /// Names the knot, control point or count that is wrong.
    pub fn open(controls: &[Vector<S, N>], knots: &[S]) -> Result<Self, SplineError> {
        let m = controls.len();
        if m < 4 {
            return Err(SplineError::TooFew { controls: m });
        }
        let extra = [0, 2, 3].into_iter().find(|extra| knots.len() + 2 == m + 2 * extra);
        let inner = extra.and_then(|extra| Some((extra, knots.get(extra..knots.len() - extra)?)));
        let Some((extra, distinct @ [first, .., last])) = inner else {
            return Err(SplineError::KnotCount { knots: knots.len(), controls: m });
        };
        for (index, knot) in knots.iter().enumerate() {
            let end = if index < extra { first } else { last };
            let outside = index < extra || index >= knots.len() - extra;
            if outside && knot != end {
                return Err(SplineError::EndKnot { index, value: knot.to_f64() });
            }
        }
        in_order(distinct).map_err(|error| match error {
            SplineError::KnotOrder { index, value } => {
                SplineError::KnotOrder { index: index + extra, value }
            }
            other => other,
        })?;
        let mut own = Vec::new();
        let room = own.extend_from_slice(distinct).is_ok();
        Self::new(controls, own, false, room)
    }

    /// A closed spline: control points and as many knot intervals, all positive (Naseath 2007, section
    /// 5.1.1). Interval number k is that of the span in the middle of control points k to k + 3.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn closed(controls: &[Vector<S, N>], intervals: &[S]) -> Result<Self, SplineError> {
        let m = controls.len();
        if m < 5 {
            return Err(SplineError::TooFew { controls: m });
        }
        if intervals.len() != m {
            return Err(SplineError::KnotCount { knots: intervals.len(), controls: m });
        }
        let mut knots: Vec<S, CAP> = Vec::new();
        let mut sum = S::ZERO;
        let mut room = true;
        for (index, interval) in intervals.iter().enumerate() {
            let next = sum + *interval;
            // One that is lost beside the others is none.
            if !(*interval > S::ZERO && next > sum) {
                return Err(SplineError::KnotOrder { index, value: interval.to_f64() });
            }
            sum = next;
            room &= knots.push(sum).is_ok();
        }
        Self::new(controls, knots, true, room)
    }

    fn new(
        controls: &[Vector<S, N>],
        knots: Vec<S, CAP>,
        closed: bool,
        mut room: bool,
    ) -> Result<Self, SplineError> {
        let broken = |point: &Vector<S, N>| !point.iter().all(|x| x.is_finite());
        if let Some(index) = controls.iter().position(broken) {
            return Err(SplineError::NotFinite { index });
        }
        if let Some(index) = knots.iter().position(|knot| !knot.is_finite()) {
            return Err(SplineError::NotFinite { index });
        }
        let mut own = Vec::new();
        room &= own.extend_from_slice(controls).is_ok();
        if !room {
            return Err(SplineError::TooMany { controls: controls.len(), room: CAP });
        }
        Ok(Self { controls: own, knots, closed })
    }

    /// The control points.
    pub fn controls(&self) -> &[Vector<S, N>] {
        &self.controls
    }

    /// The control points, to be moved.
    pub fn controls_mut(&mut self) -> &mut [Vector<S, N>] {
        &mut self.controls
    }

    /// Moves the control points to others, in their order.
    pub(crate) fn move_to(&mut self, points: &[Vector<S, N>]) {
        for (control, point) in self.controls.iter_mut().zip(points) {
            *control = *point;
        }
    }

    /// Whether it is closed.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The knots, each once; closed: the ends of the intervals, counted from 0.
    pub fn knots(&self) -> &[S] {
        &self.knots
    }

    /// The knots threefold at the ends (Sederberg), one by one; closed: the intervals.
    pub fn printed_knots(&self) -> impl Iterator<Item = S> + '_ {
        let count = if self.closed { self.controls.len() } else { self.controls.len() + 2 };
        (0..count).map(|i| {
            if self.closed {
                self.ticked(i) - if i == 0 { S::ZERO } else { self.ticked(i - 1) }
            } else {
                self.knot(i)
            }
        })
    }

    /// Number of spans.
    pub fn spans(&self) -> usize {
        if self.closed { self.controls.len() } else { self.controls.len().saturating_sub(3) }
    }

    /// A knot as it is kept; there are at least two.
    fn ticked(&self, index: usize) -> S {
        self.knots.get(index).copied().unwrap_or(S::ZERO)
    }

    /// Knot number `i`: control point k has the polar label (k, k + 1, k + 2), span k lies between
    /// the knots k + 2 and k + 3.
    fn knot(&self, i: usize) -> S {
        let count = self.knots.len().max(1);
        if !self.closed {
            return self.ticked(i.saturating_sub(2).min(count - 1));
        }
        // Span 0 starts at 0; one turn more, so that nothing is negative.
        let (turns, rest) = ((i + count - 2) / count, (i + count - 2) % count);
        let turn = (S::from_u32(turns as u32) - S::ONE) * self.ticked(count - 1);
        if rest == 0 { turn } else { turn + self.ticked(rest - 1) }
    }

    /// The number of a span that there is: beyond the last, the last.
    fn known(&self, span: usize) -> usize {
        span.min(self.spans().saturating_sub(1))
    }

    /// Parameters at the ends of a span; of the last, if there are not so many.
    pub fn range(&self, span: usize) -> (S, S) {
        let span = self.known(span);
        (self.knot(span + 2), self.knot(span + 3))
    }

    /// What a span depends on.
    pub(crate) fn local(&self, span: usize) -> Local<S> {
        let span = self.known(span);
        let start = self.knot(span + 2);
        Local::from_knots(from_fn(|i| self.knot(span + i) - start))
    }

    /// The four control points of a span.
    pub(crate) fn polygon(&self, span: usize) -> [Vector<S, N>; 4] {
        let span = self.known(span);
        let count = self.controls.len().max(1);
        from_fn(|j| self.controls.get((span + j) % count).copied().unwrap_or_else(zero))
    }

    /// Point at the share `u` (0 to 1) of a span. Here and below, a span beyond the last is the last.
    pub fn point(&self, span: usize, u: S) -> Vector<S, N> {
        self.weighted(span, &self.basis(span, u))
    }

    /// The basis functions of a span's four control points at the share `u` of it.
    pub(crate) fn basis(&self, span: usize, u: S) -> [S; 4] {
        let local = self.local(span);
        local.values(local.step() * u)
    }

    /// The four control points of a span, each times its basis function.
    pub(crate) fn weighted(&self, span: usize, basis: &[S; 4]) -> Vector<S, N> {
        let polygon = self.polygon(span);
        from_fn(|i| {
            let mut sum = S::ZERO;
            for (part, control) in basis.iter().zip(&polygon) {
                sum += *part * control[i];
            }
            sum
        })
    }

    /// Span and share of it at a parameter; beyond the ends, the ends.
    pub fn locate(&self, t: S) -> (usize, S) {
        let last = self.spans().saturating_sub(1);
        // At most all spans.
        let span = (0..last).find(|&k| t < self.range(k).1).unwrap_or(last);
        let (from, to) = self.range(span);
        (span, ((t - from) / (to - from)).greatest(S::ZERO).least(S::ONE))
    }

    /// Point at a parameter.
    pub fn at(&self, t: S) -> Vector<S, N> {
        let (span, u) = self.locate(t);
        self.point(span, u)
    }

    /// Bezier points of a span.
    pub fn bezier(&self, span: usize) -> [Vector<S, N>; 4] {
        let span = self.known(span);
        let t: [S; 6] = from_fn(|i| self.knot(span + i));
        let c = self.polygon(span);
        // Boehm: the polar values at (a, a, a), (a, a, b), (a, b, b), (b, b, b).
        let (a, b) = (t[2], t[3]);
        let part = |at: S, from: S, to: S| (at - from) / (to - from);
        let between = |p: &Vector<S, N>, q: &Vector<S, N>, u: S| mix(S::ONE - u, p, u, q);
        let aab = between(&c[1], &c[2], part(a, t[1], t[4]));
        let abb = between(&c[1], &c[2], part(b, t[1], t[4]));
        let before = between(&c[0], &c[1], part(a, t[0], t[3]));
        let after = between(&c[2], &c[3], part(b, t[2], t[5]));
        let first = between(&before, &aab, part(a, t[1], t[3]));
        let last = between(&abb, &after, part(b, t[2], t[4]));
        [first, aab, abb, last]
    }

    /// The first three derivatives by the parameter at the share `u` of a span.
    pub fn derivatives(&self, span: usize, u: S) -> [Vector<S, N>; 3] {
        let (from, to) = self.range(span);
        let per = S::ONE / (to - from);
        let b = self.bezier(span);
        let edges: [Vector<S, N>; 3] = from_fn(|j| sub(&b[j + 1], &b[j]));
        let bends: [Vector<S, N>; 2] = from_fn(|j| sub(&edges[j + 1], &edges[j]));
        let v = S::ONE - u;
        let (three, six) = (S::of(3.0) * per, S::of(6.0) * per * per);
        [
            from_fn(|i| {
                three
                    * (v * v * edges[0][i] + S::of(2.0) * u * v * edges[1][i] + u * u * edges[2][i])
            }),
            from_fn(|i| six * (v * bends[0][i] + u * bends[1][i])),
            from_fn(|i| six * per * (bends[1][i] - bends[0][i])),
        ]
    }

    /// Curvature, 1/mm, at the share `u` of a span: the span's Bezier curve is divided there, and k is
    /// (n - 1) / n h / a^2 with its first leg a and the distance h of its third point from that (Naseath
    /// 2007, equation 3-6).
    pub fn curvature(&self, span: usize, u: S) -> S {
        bezier_curvature(self.bezier(span), u)
    }

    /// Arc length of a span, mm.
    pub fn span_length(&self, span: usize) -> S {
        let b = self.bezier(span);
        let edges: [Vector<S, N>; 3] = from_fn(|j| sub(&b[j + 1], &b[j]));
        let per = S::of(1.0 / f64::from(PARTS));
        let mut sum = S::ZERO;
        for part in 0..PARTS {
            for Point { at, weight } in FIVE {
                let u = (S::from_u32(part) + S::of(at)) * per;
                let slope = bezier::parabola(edges.each_ref(), u);
                sum += S::of(weight) * norm(&slope);
            }
        }
        S::of(3.0) * sum * per
    }

    /// Arc length, mm.
    pub fn length(&self) -> S {
        let mut sum = S::ZERO;
        for span in 0..self.spans() {
            sum += self.span_length(span);
        }
        sum
    }

    /// A knot more, inside an open spline; the curve stays as it is (Boehm).
    ///
    /// # Errors
    /// If it is closed, the parameter is not inside, is a knot already, or there is no room.
    pub fn insert(&mut self, t: S) -> Result<(), SplineError> {
        let (span, _) = self.locate(t);
        let (from, to) = self.range(span);
        if self.closed || !(t > from && t < to) {
            return Err(SplineError::OutOfRange {
                what: "parameter of a new knot",
                value: t.to_f64(),
                least: from.to_f64(),
                greatest: to.to_f64(),
            });
        }
        if self.controls.is_full() || self.knots.is_full() {
            let controls = self.controls.len() + 1;
            return Err(SplineError::TooMany { controls, room: CAP });
        }
        let c = self.polygon(span);
        let knots: [S; 6] = from_fn(|i| self.knot(span + i));
        let new: [Vector<S, N>; 3] = from_fn(|j| {
            let u = (t - knots[j]) / (knots[j + 3] - knots[j]);
            mix(S::ONE - u, &c[j], u, &c[j + 1])
        });
        insert(&mut self.controls, span + 2, new[1]);
        if let Some(points) = some_mut(&mut self.controls, span + 1) {
            *points = new;
        }
        insert(&mut self.knots, span + 1, t);
        Ok(())
    }

    /// The difference of two splines over the same knots, itself a spline (Naseath 2007, equation
    /// 2-16); `None` if their control points are not equally many.
    pub fn difference(&self, other: &Self) -> Option<Self> {
        let mut out = self.clone();
        if out.controls.len() != other.controls.len() || out.closed != other.closed {
            return None;
        }
        for (x, y) in out.controls.iter_mut().zip(&other.controls) {
            *x = sub(x, y);
        }
        Some(out)
    }

    /// The greatest distance from the origin, mm, at `precision` places of every span (and, for a
    /// difference spline, how far the two are apart: Naseath 2007, section 3.8).
    pub fn greatest(&self, precision: u32) -> S {
        self.most(precision, |_, _| S::ZERO)
    }

    /// An upper bound of the distance from the origin, mm: that at `precision` places of every span,
    /// and gap^2 / 8 times the greatest second derivative for what lies between.
    pub fn bound(&self, precision: u32) -> S {
        self.most(precision, |b, per| {
            let bend = |j: usize| -> Vector<S, N> {
                from_fn(|i| b[j][i] - S::of(2.0) * b[j + 1][i] + b[j + 2][i])
            };
            // Six times these are the second derivatives by the share of the span.
            let bend = dot(&bend(0), &bend(0)).greatest(dot(&bend(1), &bend(1))).sqrt();
            S::of(0.75) * per * per * bend
        })
    }

    /// The greatest distance from the origin at places of every span, and what is added in it.
    fn most(&self, precision: u32, more: impl Fn(&[Vector<S, N>; 4], S) -> S) -> S {
        let mut most = S::ZERO;
        let per = S::ONE / S::from_u32(precision.max(1));
        for span in 0..self.spans() {
            let b = self.bezier(span);
            let mut square = S::ZERO;
            for k in 0..=precision {
                let u = S::from_u32(k) * per;
                let w = bezier::weights(u);
                let point: Vector<S, N> =
                    from_fn(|i| w[0] * b[0][i] + w[1] * b[1][i] + w[2] * b[2][i] + w[3] * b[3][i]);
                square = square.greatest(dot(&point, &point));
            }
            most = most.greatest(square.sqrt() + more(&b, per));
        }
        most
    }

    /// The point beside the path at the signed distance `radius`, to the left, in the plane of the
    /// first two axes (Naseath 2007, equation 2-18). Where `radius` is greater than the path's radius of curvature these
    /// points run backwards, between two cusps (section 2.3.6); they are for the eye, and nothing is computed from them.
    pub fn offset(&self, span: usize, u: S, radius: S) -> Vector<S, N> {
        const { assert!(N >= 2, "an offset needs two axes") };
        let mut point = self.point(span, u);
        let [d, ..] = self.derivatives(span, u);
        let per = radius / (d[0] * d[0] + d[1] * d[1]).sqrt();
        point[0] = point[0] - d[1] * per;
        point[1] += d[0] * per;
        point
    }
}

#[cfg(test)]
impl<const N: usize, const CAP: usize> Spline<f64, N, CAP> {
    /// The greatest curvature at `places` places of every span.
    pub(crate) fn peak(&self, places: u32) -> f64 {
        (0..self.spans())
            .flat_map(|span| (0..places).map(move |k| (span, f64::from(k) / f64::from(places))))
            .map(|(span, u)| self.curvature(span, u))
            .fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Planar = Spline<f64, 2, 16>;

    fn open() -> Planar {
        let controls = [[0.0, 0.0], [1.0, 2.0], [3.0, 1.5], [4.0, -1.0], [6.0, 0.5], [7.5, 0.0]];
        Planar::open(&controls, &[0.0, 2.0, 3.0, 5.0]).unwrap()
    }

    fn closed() -> Planar {
        let controls =
            [[1.0, 0.0], [0.3, 1.0], [-0.8, 0.6], [-0.7, -0.8], [0.4, -1.1], [0.9, -0.6]];
        Planar::closed(&controls, &[1.0, 0.7, 1.2, 0.9, 1.1, 1.0]).unwrap()
    }

    fn near(a: [f64; 2], b: [f64; 2], most: f64) {
        assert!(norm(&sub(&a, &b)) <= most, "{a:?} {b:?}");
    }

    #[test]
    fn a_span_beyond_the_last_is_the_last() {
        for spline in [open(), closed()] {
            let last = spline.spans() - 1;
            for span in [last + 1, 77, usize::MAX] {
                near(spline.point(span, 0.3), spline.point(last, 0.3), 0.0);
                assert_eq!(spline.range(span), spline.range(last));
                assert_eq!(spline.bezier(span), spline.bezier(last));
                assert_eq!(spline.derivatives(span, 0.3), spline.derivatives(last, 0.3));
            }
        }
    }

    #[test]
    fn all_conventions_mean_the_same() {
        let spline = open();
        let threefold: std::vec::Vec<f64> = spline.printed_knots().collect();
        assert_eq!(threefold, [0.0, 0.0, 0.0, 2.0, 3.0, 5.0, 5.0, 5.0]);
        let mut fourfold = threefold.clone();
        fourfold.insert(0, 0.0);
        fourfold.push(5.0);
        for knots in [threefold, fourfold] {
            let other = Planar::open(spline.controls(), &knots).unwrap();
            assert_eq!(other.knots(), spline.knots());
        }
        near(spline.at(0.0), [0.0, 0.0], 0.0);
        near(spline.at(5.0), [7.5, 0.0], 1e-15);
    }

    #[test]
    fn wrong_splines_are_explained() {
        let c = open();
        let c = c.controls();
        let text = |knots: &[f64]| std::format!("{}", Planar::open(c, knots).unwrap_err());
        assert!(text(&[0.0, 1.0]).contains("2 knots for 6 control points"));
        assert!(text(&[0.0, 2.0, 2.0, 5.0]).contains("knot 2 is 2"));
        assert!(text(&[0.0, 0.1, 0.0, 2.0, 3.0, 5.0, 5.0, 5.0]).contains("knot 1 is 0.1"));
        assert!(text(&[0.0, f64::NAN, 3.0, 5.0]).contains("knot 1"));
        let small = Spline::<f64, 2, 5>::open(c, &[0.0, 2.0, 3.0, 5.0]).unwrap_err();
        assert_eq!(small, SplineError::TooMany { controls: 6, room: 5 });
        assert!(Planar::open(&c[..3], &[0.0]).is_err());
        // None, and one that is lost beside the others.
        for interval in [0.0, f64::NAN, 1.0e-300, 1.0e300] {
            let error = Planar::closed(c, &[1.0, 1.0, interval, 1.0, 1.0, 1.0]).unwrap_err();
            assert!(matches!(error, SplineError::KnotOrder { .. }), "{interval}: {error}");
        }
    }

    /// Value, first and second derivative agree from both sides of every knot.
    #[test]
    fn spans_join_with_continuous_curvature() {
        for spline in [open(), closed()] {
            let spans = spline.spans();
            for k in 0..if spline.is_closed() { spans } else { spans - 1 } {
                let next = (k + 1) % spans;
                near(spline.point(k, 1.0), spline.point(next, 0.0), 1e-13);
                let (a, b) = (spline.derivatives(k, 1.0), spline.derivatives(next, 0.0));
                near(a[0], b[0], 1e-12);
                near(a[1], b[1], 1e-11);
            }
        }
    }

    #[test]
    fn bezier_points_and_derivatives_are_the_curve() {
        for spline in [open(), closed()] {
            for span in 0..spline.spans() {
                let b = spline.bezier(span);
                let (from, to) = spline.range(span);
                for k in 0..=4 {
                    let u = f64::from(k) / 4.0;
                    let v = 1.0 - u;
                    let w = [v * v * v, 3.0 * u * v * v, 3.0 * u * u * v, u * u * u];
                    let point = from_fn(|i| (0..4).map(|j| w[j] * b[j][i]).sum());
                    near(point, spline.point(span, u), 1e-13);
                }
                let h = 1e-4;
                let (a, b) = (spline.point(span, 0.5 - h), spline.point(span, 0.5 + h));
                let slope = from_fn(|i| (b[i] - a[i]) / (2.0 * h * (to - from)));
                near(slope, spline.derivatives(span, 0.5)[0], 1e-6);
            }
        }
    }

    /// Equation 3-6 against |c' x c''| / |c'|^3.
    #[test]
    fn curvature_by_legs_is_that_of_the_derivatives() {
        let spline = open();
        for span in 0..spline.spans() {
            for k in 0..=8 {
                let u = f64::from(k) / 8.0;
                let [d, dd, _] = spline.derivatives(span, u);
                let wanted = (d[0] * dd[1] - d[1] * dd[0]).abs() / norm(&d).powi(3);
                assert!((spline.curvature(span, u) - wanted).abs() < 1e-9, "{span} {u}");
            }
        }
    }

    #[test]
    fn a_new_knot_leaves_the_curve() {
        let (before, mut after) = (open(), open());
        after.insert(2.3).unwrap();
        after.insert(0.4).unwrap();
        assert_eq!((after.spans(), after.controls().len()), (5, 8));
        for k in 0..=50 {
            let t = f64::from(k) * 0.1;
            near(before.at(t), after.at(t), 1e-13);
        }
        assert!(after.insert(2.0).is_err() && after.insert(7.0).is_err());
        assert!((before.length() - after.length()).abs() < 1e-9);
    }

    #[test]
    fn distances_are_bounded_by_the_difference() {
        let (a, mut b) = (open(), open());
        b.controls_mut()[2][1] += 0.3;
        b.controls_mut()[3][0] -= 0.1;
        let difference = b.difference(&a).unwrap();
        let dense = difference.greatest(1000);
        assert!(difference.greatest(5) <= dense && dense <= difference.bound(5));
        assert!(difference.bound(5) < 1.1 * dense && dense < 0.3);
        // The offset is at its distance.
        near(a.offset(1, 0.5, 0.0), a.point(1, 0.5), 0.0);
        let away = sub(&a.offset(1, 0.5, -0.25), &a.point(1, 0.5));
        assert!((norm(&away) - 0.25).abs() < 1e-14);
        assert!(dot(&away, &a.derivatives(1, 0.5)[0]).abs() < 1e-13);
    }
}
