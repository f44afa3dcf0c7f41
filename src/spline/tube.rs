//! A spline and the tube it has to stay in, for smoothing.
//!
//! The spline is compared with a reference - a poly-line, or the spline as it was - at *check points*; what
//! it moves by between two of them is bounded by its second derivative.

use super::basis::Local;
use super::bezier;
use crate::number::Scalar;
use crate::number::list::some;
use crate::number::quadrature::TWO;
use crate::number::vector::{Vector, dot, mix, norm};
use core::array::from_fn;
use core::ops::Range;

/// Shares of the value at a span's start in those at its two Gauss points: what is left of 1, which by symmetry is the
/// other point.
const NEAR: [f64; 2] = [TWO[1].at, TWO[0].at];
/// Least product of neighbouring first derivatives, by the parameter.
const LEAST_SPEED: f64 = 0.01;

/// What smoothing does with a control point.
#[derive(Clone, Copy, Debug)]
pub struct Pole<S, const N: usize> {
    /// From it to the next one as they were given, mm.
    pub edge: Vector<S, N>,
    /// By how much it has been moved, mm; valid: the spline is in its tube.
    pub shift: Vector<S, N>,
    /// The same while it is being worked on.
    pub trial: Vector<S, N>,
}

/// A span: it depends on four control points, the first of which has the span's index.
#[derive(Clone, Copy, Debug)]
pub struct Span<S> {
    /// Factors of the edges of the control polygon in the first derivative's control points, 1/mm.
    pub firsts: [S; 3],
    /// Factors of the differences of those in the second derivatives at both ends, 1/mm.
    pub seconds: [S; 2],
    /// The knots next to its own, from its start, mm.
    pub beside: [S; 2],
    /// Length by the knots, mm.
    pub step: S,
    /// Factor of the second derivative in what is kept free of the band, mm2: for the gaps between check points,
    /// and for rests.
    pub sag: S,
    /// How soon the motion has to be slow from here, mm: see [`super::sweep`].
    pub reach: S,
    /// Price of the derivative that is minimised.
    pub price: S,
    /// Its first check point.
    pub first_check: u16,
    /// How many it has.
    pub checks: u16,
}

/// A check point.
#[derive(Clone, Copy, Debug)]
pub struct CheckPoint<S, const N: usize> {
    /// Factors of the span's four control points.
    pub basis: [S; 4],
    /// Base spline minus poly-line, mm.
    pub off: Vector<S, N>,
    /// What spline and poly-line may be apart, mm.
    pub radius: S,
    /// Weight with which the spline is drawn to the poly-line.
    pub weight: S,
    /// Direction of the poly-line.
    pub along: Vector<S, N>,
    /// From where to where along it the point to compare with may lie, mm.
    pub slip: Slip<S>,
}

/// How far along the poly-line the point that is compared with may lie.
#[derive(Clone, Copy, Debug)]
pub struct Slip<S> {
    /// Back from the check point, mm: negative or zero.
    pub back: S,
    /// Ahead of it, mm.
    pub ahead: S,
}

impl<S: Scalar> Slip<S> {
    /// At the check point itself.
    pub const NONE: Self = Self { back: S::ZERO, ahead: S::ZERO };
}

impl<S: Scalar, const N: usize> Pole<S, N> {
    /// One that has not moved.
    pub fn new(edge: Vector<S, N>) -> Self {
        Self { edge, shift: [S::ZERO; N], trial: [S::ZERO; N] }
    }
}

impl<S: Scalar, const N: usize> CheckPoint<S, N> {
    /// A place on a spline that has not moved.
    pub fn still(basis: [S; 4], radius: S) -> Self {
        Self {
            basis,
            off: [S::ZERO; N],
            radius,
            weight: S::ZERO,
            along: [S::ZERO; N],
            slip: Slip::NONE,
        }
    }

    /// Spline minus poly-line for shifts of the four control points, mm.
    #[inline]
    pub fn displaced(&self, shifts: [&Vector<S, N>; 4]) -> Vector<S, N> {
        let mut off = self.off;
        for (part, shift) in self.basis.iter().zip(shifts) {
            for (sum, x) in off.iter_mut().zip(shift) {
                *sum += *part * *x;
            }
        }
        off
    }

    /// From the nearest point of the poly-line that it may be compared with to the spline, mm: `off` is spline minus
    /// poly-line at the check point.
    #[inline]
    pub fn slipped(&self, off: &Vector<S, N>) -> Vector<S, N> {
        if !(self.slip.back < self.slip.ahead) {
            return *off;
        }
        let slip = self.slip(off);
        from_fn(|i| off[i] - slip * self.along[i])
    }

    /// How far ahead of the check point that point lies, mm.
    #[inline]
    pub fn slip(&self, off: &Vector<S, N>) -> S {
        dot(off, &self.along).least(self.slip.ahead).greatest(self.slip.back)
    }
}

impl<S: Scalar> Span<S> {
    /// A span without check points; `sag` is the factor of the second derivative in what is kept free of
    /// the tube, mm2.
    pub fn new(local: &Local<S>, sag: S) -> Self {
        Self {
            firsts: local.firsts(),
            seconds: local.seconds(),
            beside: local.beside(),
            step: local.step(),
            sag,
            reach: S::ZERO,
            price: S::ONE,
            first_check: 0,
            checks: 0,
        }
    }

    /// Its check points.
    pub fn range(&self) -> Range<usize> {
        let first = usize::from(self.first_check);
        first..first + usize::from(self.checks)
    }

    /// What is kept free of the tube between the check points, mm.
    pub fn slack<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> S {
        self.sag * self.bend(edges)
    }

    /// The second derivatives at both ends, by the edges of the control polygon, 1/mm.
    pub fn second<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> [Vector<S, N>; 2] {
        let part = |k: usize| -> Vector<S, N> {
            let (a, b) = (self.seconds[k] * self.firsts[k], self.seconds[k] * self.firsts[k + 1]);
            mix(b, &edges[k + 1], -a, &edges[k])
        };
        [part(0), part(1)]
    }

    /// Greatest second derivative, by the edges of the control polygon, 1/mm.
    pub fn bend<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> S {
        let [start, end] = self.second(edges);
        norm(&start).greatest(norm(&end))
    }

    /// The second derivative across the path at the two Gauss points, 1/mm.
    pub fn across<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> [Vector<S, N>; 2] {
        let [a, b, c] = self.first(edges);
        let [start, end] = self.second(edges);
        let at = |near: f64| -> Vector<S, N> {
            let (v, u) = (S::of(near), S::of(1.0 - near));
            let d = bezier::parabola([&a, &b, &c], u);
            let dd: Vector<S, N> = from_fn(|i| v * start[i] + u * end[i]);
            let along = dot(&d, &dd) / dot(&d, &d).greatest(S::of(1.0e-12));
            from_fn(|i| dd[i] - along * d[i])
        };
        [at(NEAR[0]), at(NEAR[1])]
    }

    /// The least speed by the parameter, of those at both ends and in the middle.
    pub fn slowest<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> S {
        let [a, b, c] = self.first(edges);
        let middle: Vector<S, N> = from_fn(|i| (a[i] + S::of(2.0) * b[i] + c[i]) * S::of(0.25));
        norm(&a).least(norm(&middle)).least(norm(&c))
    }

    /// Curvature, 1/mm: the greatest of those at both ends and in the middle.
    pub fn curl<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> S {
        let [a, b, c] = self.first(edges);
        let [start, end] = self.second(edges);
        let quarter = S::of(0.25);
        let middle = from_fn(|i| (a[i] + S::of(2.0) * b[i] + c[i]) * quarter);
        let mean = from_fn(|i| (start[i] + end[i]) * S::of(0.5));
        let mut most = S::ZERO;
        for (d, dd) in [(&a, &start), (&middle, &mean), (&c, &end)] {
            let square = dot(d, d).greatest(S::of(1.0e-12));
            let along = dot(d, dd) / square;
            let across: Vector<S, N> = from_fn(|i| dd[i] - along * d[i]);
            most = most.greatest(norm(&across) / square);
        }
        most
    }

    /// The Bezier points of the first derivative.
    pub fn first<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> [Vector<S, N>; 3] {
        let [start, end] = self.ends();
        [
            from_fn(|i| start[0] * edges[0][i] + start[1] * edges[1][i]),
            from_fn(|i| self.firsts[1] * edges[1][i]),
            from_fn(|i| end[0] * edges[1][i] + end[1] * edges[2][i]),
        ]
    }

    /// Whether the curve goes on everywhere: the Bezier points of its first derivative turn by less
    /// than a right angle from one to the next, so it does not vanish.
    pub fn goes_on<const N: usize>(&self, edges: &[Vector<S, N>; 3]) -> bool {
        let [a, b, c] = self.first(edges);
        let least = S::of(LEAST_SPEED);
        dot(&a, &b) > least && dot(&b, &c) > least && dot(&b, &b) > least
    }

    /// Factors of the edges in the first derivative at the start (of the first two) and at the end
    /// (of the last two).
    fn ends(&self) -> [[S; 2]; 2] {
        let ([a0, a1, a2], [before, behind]) = (self.firsts, self.beside);
        // 1 / support, of 2 / support to the bit.
        let [start, end] = self.seconds.map(|second| second * S::of(0.5));
        [
            [a0 * self.step * start, -(a1 * before * start)],
            [a1 * (behind - self.step) * end, a2 * self.step * end],
        ]
    }

    /// The third derivative, which is constant on the span, by the four control points, 1/mm3.
    #[inline]
    pub fn thirds(&self) -> [S; 4] {
        let ([a0, a1, a2], [b0, b1]) = (self.firsts, self.seconds);
        let per = S::ONE / self.step;
        let (first, last) = (b0 * a0 * per, b1 * a2 * per);
        let middle = (b0 + b1) * a1 * per;
        [-first, first + middle, -(middle + last), last]
    }

    /// What a third derivative costs here, by the square of a displacement of a control point; `row` is what
    /// [`thirds`](Self::thirds) gives.
    pub fn stiffness(&self, row: &[S; 4]) -> S {
        let [a, b, c, d] = *row;
        self.weight() * (a * a + b * b + c * c + d * d)
    }

    /// What a second derivative costs here, by the square of a displacement of a control point; `rows` are its
    /// [`second_rows`](Self::second_rows).
    pub fn second_stiffness(&self, rows: &[[S; 4]; 2]) -> S {
        let mut sum = S::ZERO;
        for row in rows {
            for x in row {
                sum += *x * *x;
            }
        }
        self.second_weight() * sum
    }

    /// Weight of the squares of the second derivative at the two points of
    /// [`second_rows`](Self::second_rows): their sum is the integral.
    pub fn second_weight(&self) -> S {
        self.step * self.price * S::of(0.5)
    }

    /// The second derivative at the two Gauss points of the span, by the four control points.
    pub fn second_rows(&self) -> [[S; 4]; 2] {
        let ([a0, a1, a2], [b0, b1]) = (self.firsts, self.seconds);
        let zero = S::ZERO;
        let start = [b0 * a0, -(b0 * (a0 + a1)), b0 * a1, zero];
        let end = [zero, b1 * a1, -(b1 * (a1 + a2)), b1 * a2];
        let at = |near: f64| mix(S::of(near), &start, S::of(1.0 - near), &end);
        [at(NEAR[0]), at(NEAR[1])]
    }

    /// Weight of the square of the third derivative.
    pub fn weight(&self) -> S {
        self.step * self.price
    }
}

/// The third derivative by the edges of the control polygon, 1/mm2; `row` is what [`Span::thirds`] gives.
pub fn third<S: Scalar, const N: usize>(row: &[S; 4], edges: &[Vector<S, N>; 3]) -> Vector<S, N> {
    let [a, b, _, d] = *row;
    from_fn(|i| d * edges[2][i] - (a + b) * edges[1][i] - a * edges[0][i])
}

/// The edges of the control polygon of a span, the control points being moved; of a span that does not
/// exist they have no length.
pub fn edges<S: Scalar, const N: usize>(
    poles: &[Pole<S, N>],
    span: usize,
    moved: impl Fn(&Pole<S, N>) -> Vector<S, N>,
) -> [Vector<S, N>; 3] {
    let Some([a, b, c, d]) = some(poles, span) else { return [[S::ZERO; N]; 3] };
    let edge = |a: &Pole<S, N>, b: &Pole<S, N>| -> Vector<S, N> {
        let (from, to) = (moved(a), moved(b));
        let mut edge = a.edge;
        for ((x, from), to) in edge.iter_mut().zip(&from).zip(&to) {
            *x += *to - *from;
        }
        edge
    };
    [edge(a, b), edge(b, c), edge(c, d)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives against differences of the values.
    #[test]
    fn derivatives_agree_with_differences() {
        let knots = [-3.0, -1.0, 0.0, 2.0, 3.0, 7.0];
        let local = Local::from_knots(knots);
        let span = Span::new(&local, 0.0);
        let c = [0.3, -1.0, 2.5, 0.7];
        let value = |u: f64| -> f64 { local.values(u).iter().zip(c).map(|(n, c)| n * c).sum() };
        let edges = [c[1] - c[0], c[2] - c[1], c[3] - c[2]];
        let h = 1e-3;
        let third = (value(1.0 + 2.0 * h) - 2.0 * value(1.0 + h) + 2.0 * value(1.0 - h)
            - value(1.0 - 2.0 * h))
            / (2.0 * h * h * h);
        let by_points: f64 = span.thirds().iter().zip(c).map(|(g, c)| g * c).sum();
        assert!((third - by_points).abs() < 1e-4, "{third} {by_points}");
        let [[a, b], [c1, c2]] = span.ends();
        let start = (value(h) - value(0.0)) / h;
        assert!((a * edges[0] + b * edges[1] - start).abs() < 1e-2);
        let end = (value(2.0) - value(2.0 - h)) / h;
        assert!((c1 * edges[1] + c2 * edges[2] - end).abs() < 1e-2);
        let [f0, f1, f2] = span.firsts;
        let [s0, s1] = span.seconds;
        let second = s0 * (f1 * edges[1] - f0 * edges[0]);
        let measured = (value(2.0 * h) - 2.0 * value(h) + value(0.0)) / (h * h);
        assert!((second - measured).abs() < 1e-2, "{second} {measured}");
        let second = s1 * (f2 * edges[2] - f1 * edges[1]);
        let measured = (value(2.0) - 2.0 * value(2.0 - h) + value(2.0 - 2.0 * h)) / (h * h);
        assert!((second - measured).abs() < 1e-2, "{second} {measured}");
    }
}
