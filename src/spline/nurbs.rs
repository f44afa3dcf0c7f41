//! NURBS curves as cubic Bezier curves, within a bound.
//!
//! A curve is cut at its knots, and every span is halved until the cubic with the ends of a part and the derivatives there is
//! near enough ([`Cubics`]). How near it is follows from Bezier points, not from samples: let the part be
//! R = sum w_i P_i B_i / sum w_i B_i, with the Bernstein polynomials B_i of degree p, and C the cubic with the Bezier points
//! C_j. Then (R - C) sum w_i B_i is a polynomial of degree p + 3, and its Bezier points are
//!
//! E_k = sum over i + j = k of binom(p, i) binom(3, j) / binom(p + 3, k) w_i (P_i - C_j).
//!
//! The sum of the w_i B_i is nowhere less than the least weight, so |R - C| at equal parameter is at most the greatest |E_k| over
//! the least w_i. (The first two and the last two of the E_k vanish: halved, a part is some sixteen times nearer.)

use crate::number::list::{part, part_mut};
use crate::number::vector::{Vector, dot, mix, norm, sub, zero};
use core::array::from_fn;
use core::fmt;

/// Greatest degree.
pub const DEGREE: usize = 9;
/// Distance between a curve and the cubics that stand for it in a program, mm: a hundredth of the least tolerance that a
/// curve may have.
pub const ERROR: f64 = 1.0e-6;
/// Share of the error within which a part is a straight line, or a point.
const STRAIGHT: f64 = 1.0e-3;
/// A span is halved at most so many times: by then its parts are shorter than [`ERROR`] on any machine.
const HALVINGS: u32 = 30;

/// Knots of a curve.
#[derive(Clone, Copy, Debug)]
pub enum Knots<'a> {
    /// As given, in order: degree + 1 more than control points.
    Given(&'a [f64]),
    /// 0, 1, 2 and so on, the first and the last as often as the order says: the curve begins and ends in its outer
    /// control points (G5.2 of LinuxCNC).
    Even,
}

/// What is wrong with a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NurbsError {
    /// A degree that is not 1 to [`DEGREE`].
    Degree(usize),
    /// Fewer control points than degree + 1, or not as many weights.
    Points {
        /// Control points.
        points: usize,
        /// Weights.
        weights: usize,
        /// Control points at least.
        least: usize,
    },
    /// Another number of knots than control points and degree + 1.
    KnotCount {
        /// Those that there are.
        knots: usize,
        /// Those that there should be.
        needed: usize,
    },
    /// A knot that is less than the one before it, or no number, or a curve without a span between knots.
    KnotOrder {
        /// Its index.
        index: usize,
    },
    /// A weight that is not positive, or a control point that is not finite.
    Point {
        /// Its index.
        index: usize,
    },
}

impl fmt::Display for NurbsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Degree(degree) => {
                write!(f, "a NURBS curve of degree {degree}; it must be 1 to {DEGREE}")
            }
            Self::Points { points, weights, least } => {
                write!(
                    f,
                    "{points} control points and {weights} weights; both must be {least} or more, and as many"
                )
            }
            Self::KnotCount { knots, needed } => {
                write!(f, "{knots} knots where {needed} are needed")
            }
            Self::KnotOrder { index } => write!(f, "knot {index} is not beyond those before it"),
            Self::Point { index } => {
                write!(f, "control point {index} is not finite, or its weight not positive")
            }
        }
    }
}

impl core::error::Error for NurbsError {}

/// A curve in `N` axes, mm.
#[derive(Clone, Copy, Debug)]
pub struct Nurbs<'a, const N: usize> {
    degree: usize,
    points: &'a [Vector<f64, N>],
    weights: &'a [f64],
    knots: Knots<'a>,
}

/// A part of a curve as a cubic Bezier curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic<const N: usize> {
    /// From which parameter of the curve to which.
    pub range: [f64; 2],
    /// Its Bezier points.
    pub points: [Vector<f64, N>; 4],
    /// Whether the part is a straight line from end to end.
    pub is_straight: bool,
}

/// How far the conversion of a curve has come: the part of a span that is next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cubics {
    span: usize,
    /// The part is the one of number `index` of 2^`depth`.
    depth: u32,
    index: u32,
}

/// A control point times its weight, and the weight.
#[derive(Clone, Copy, Debug)]
struct Weighted<const N: usize> {
    place: Vector<f64, N>,
    weight: f64,
}

impl<const N: usize> Weighted<N> {
    const NONE: Self = Self { place: [0.0; N], weight: 1.0 };

    fn point(&self) -> Vector<f64, N> {
        self.place.map(|x| x / self.weight)
    }
}

/// A rational Bezier curve: its points, and their weights.
struct Part<const N: usize> {
    points: heapless::Vec<Vector<f64, N>, { DEGREE + 1 }>,
    weights: heapless::Vec<f64, { DEGREE + 1 }>,
}

impl<'a, const N: usize> Nurbs<'a, N> {
    /// A curve.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub fn new(
        degree: usize,
        points: &'a [Vector<f64, N>],
        weights: &'a [f64],
        knots: Knots<'a>,
    ) -> Result<Self, NurbsError> {
        if !(1..=DEGREE).contains(&degree) {
            return Err(NurbsError::Degree(degree));
        }
        let (n, least) = (points.len(), degree + 1);
        if n < least || weights.len() != n {
            return Err(NurbsError::Points { points: n, weights: weights.len(), least });
        }
        for (index, (point, weight)) in points.iter().zip(weights).enumerate() {
            // A NaN is not greater either.
            if !(*weight > 0.0 && weight.is_finite() && point.iter().all(|x| x.is_finite())) {
                return Err(NurbsError::Point { index });
            }
        }
        let curve = Self { degree, points, weights, knots };
        if let Knots::Given(knots) = knots {
            let needed = n + least;
            if knots.len() != needed {
                return Err(NurbsError::KnotCount { knots: knots.len(), needed });
            }
            let pairs = knots.iter().zip(knots.iter().skip(1));
            for (index, (before, knot)) in (1..).zip(pairs) {
                if !(before <= knot && before.is_finite() && knot.is_finite()) {
                    return Err(NurbsError::KnotOrder { index });
                }
            }
            if !(curve.knot(degree) < curve.knot(n)) {
                return Err(NurbsError::KnotOrder { index: n });
            }
        }
        Ok(curve)
    }

    fn knot(&self, i: usize) -> f64 {
        match self.knots {
            Knots::Given(knots) => knots.get(i).copied().unwrap_or(0.0),
            // The outer ones are all the first or the last one. (`clamp` may panic.)
            Knots::Even => {
                i.max(self.degree).min(self.points.len()).saturating_sub(self.degree) as f64
            }
        }
    }

    /// The polar form of the span from knot number `span` on, at parameters given for levels 1 to the degree (de Boor).
    fn blossom(&self, span: usize, parameter: impl Fn(usize) -> f64) -> Weighted<N> {
        let p = self.degree;
        // The control points of the span: the last one has its number.
        let first = span.saturating_sub(p);
        let mut d = [Weighted::NONE; DEGREE + 1];
        let own =
            part(self.points, first..span + 1).iter().zip(part(self.weights, first..span + 1));
        for (slot, (point, &weight)) in d.iter_mut().zip(own) {
            *slot = Weighted { place: point.map(|x| x * weight), weight };
        }
        for level in 1..=p {
            let u = parameter(level);
            let mut rest = part_mut(&mut d, 0..p + 2 - level);
            let mut at = first + level;
            while let [here, later @ ..] = rest {
                if let Some(next) = later.first() {
                    let (a, b) = (self.knot(at), self.knot(at + p + 1 - level));
                    let t = if b > a { (u - a) / (b - a) } else { 0.0 };
                    here.place = mix(1.0 - t, &here.place, t, &next.place);
                    here.weight = (1.0 - t) * here.weight + t * next.weight;
                }
                rest = later;
                at += 1;
            }
        }
        let [out, ..] = d;
        out
    }

    /// The parameters at which it is cut, in order: its knots, each once.
    pub fn breaks(&self) -> impl Iterator<Item = f64> + '_ {
        let inner = (self.degree..=self.points.len()).map(|i| self.knot(i));
        let mut before = None;
        inner.filter(move |knot| before.replace(*knot) != Some(*knot))
    }

    /// Number of the knot at which the span with a parameter begins; beyond the ends those of the ends.
    fn span(&self, u: f64) -> usize {
        let (p, n) = (self.degree, self.points.len());
        let last = (p..n).rev().find(|&span| self.knot(span) < self.knot(span + 1));
        let own =
            (p..n).find(|&span| self.knot(span) < self.knot(span + 1) && u < self.knot(span + 1));
        own.or(last).unwrap_or(p)
    }

    /// The point at a parameter.
    ///
    /// Work: p (p + 1) / 2 steps of de Boor, p being the degree, and a look at the knots.
    pub fn point(&self, u: f64) -> Vector<f64, N> {
        self.blossom(self.span(u), |_| u).point()
    }

    /// A bound of the distance from a cubic Bezier curve, mm, at equal shares of a range between two neighbouring knots: see
    /// the head of the file.
    pub fn distance(&self, range: [f64; 2], cubic: &[Vector<f64, N>; 4]) -> f64 {
        self.part(self.span(range[0]), range).error(cubic)
    }

    /// A part of the span from knot number `span` on.
    fn part(&self, span: usize, [from, to]: [f64; 2]) -> Part<N> {
        let mut part = Part { points: heapless::Vec::new(), weights: heapless::Vec::new() };
        for k in 0..=self.degree {
            let bezier = self.blossom(span, |level| if level > k { from } else { to });
            // There is room: the degree has been checked.
            let _ = part.points.push(bezier.point());
            let _ = part.weights.push(bezier.weight);
        }
        part
    }
}

impl<const N: usize> Part<N> {
    /// Bezier points of the cubic that has its ends and its derivatives there.
    fn cubic(&self) -> [Vector<f64, N>; 4] {
        let third = self.points.len().saturating_sub(1) as f64 / 3.0;
        let ([from, next, ..], [w0, w1, ..]) = (&*self.points, &*self.weights) else {
            return [zero(); 4];
        };
        let ([.., last, to], [.., v1, v0]) = (&*self.points, &*self.weights) else {
            return [zero(); 4];
        };
        let first = mix(1.0, from, third * w1 / w0, &sub(next, from));
        let second = mix(1.0, to, third * v1 / v0, &sub(last, to));
        [*from, first, second, *to]
    }

    /// A bound of the distance from a cubic, at equal parameter: see the head of the file.
    fn error(&self, cubic: &[Vector<f64, N>; 4]) -> f64 {
        let p = self.points.len().saturating_sub(1);
        // binom(p, i) w_i P_i B_i times binom(3, j) C_j, by i + j.
        let mut sums = [[0.0; N]; DEGREE + 4];
        let mut binomial = 1.0;
        for (i, (point, weight)) in self.points.iter().zip(&self.weights).enumerate() {
            let factors = [1.0, 3.0, 3.0, 1.0].map(|three| binomial * three * weight);
            for ((sum, c), factor) in sums.iter_mut().skip(i).zip(cubic).zip(factors) {
                *sum = mix(1.0, sum, factor, &sub(point, c));
            }
            binomial = binomial * p.saturating_sub(i) as f64 / (i + 1) as f64;
        }
        let (mut most, mut binomial) = (0.0f64, 1.0);
        for (k, sum) in sums.iter().enumerate().take(p + 4) {
            most = most.max(norm(sum) / binomial);
            binomial = binomial * (p + 3).saturating_sub(k) as f64 / (k + 1) as f64;
        }
        most / self.weights.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Whether it goes nowhere, to within `error` mm.
    fn is_point(&self, error: f64) -> bool {
        let Some(from) = self.points.first() else { return true };
        self.points.iter().all(|point| norm(&sub(point, from)) <= error)
    }

    /// Whether it is a straight line run from end to end, to within `error` mm.
    fn is_straight(&self, error: f64) -> bool {
        let [from, .., to] = &*self.points else { return false };
        let way = sub(to, from);
        let length = norm(&way);
        let mut before = 0.0;
        self.points.iter().all(|point| {
            let off = sub(point, from);
            let along = dot(&off, &way) / length;
            let forward = along >= before - error && along <= length + error;
            before = along;
            let foot: Vector<f64, N> = from_fn(|i| off[i] - way[i] * along / length);
            length > 0.0 && forward && norm(&foot) <= error
        })
    }
}

impl Cubics {
    /// The next cubic of a curve, within `error` mm of its part; `None` at the end. The last one ends in the end of the
    /// curve; parts without length are left out.
    ///
    /// Work: at most a part per span and 30 besides, of (p + 1)^2 p / 2 steps of de Boor each; on the average less than two
    /// parts for a cubic.
    pub fn step<const N: usize>(&mut self, curve: &Nurbs<'_, N>, error: f64) -> Option<Cubic<N>> {
        loop {
            let span = self.span + curve.degree;
            if span >= curve.points.len() {
                return None;
            }
            let (a, b) = (curve.knot(span), curve.knot(span + 1));
            if !(a < b) {
                self.span += 1;
                continue;
            }
            let share = 1.0 / f64::from(1u32 << self.depth);
            let at = |index: u32| {
                // The ends of a span are its knots, to the bit.
                if index >> self.depth == 1 { b } else { a + (b - a) * (f64::from(index) * share) }
            };
            let range = [at(self.index), at(self.index + 1)];
            let part = curve.part(span, range);
            let points = part.cubic();
            let (tiny, is_straight) = (error * STRAIGHT, part.is_straight(error * STRAIGHT));
            let is_point = !is_straight && part.is_point(tiny);
            let is_done = is_straight || is_point || self.depth == HALVINGS;
            if !is_done && !(part.error(&points) <= error) {
                self.depth += 1;
                self.index *= 2;
                continue;
            }
            self.go_on();
            if !is_point {
                return Some(Cubic { range, points, is_straight });
            }
        }
    }

    /// To the part behind: half of the least that has been halved and is not done.
    fn go_on(&mut self) {
        self.index += 1;
        let up = self.index.trailing_zeros().min(self.depth);
        self.index >>= up;
        self.depth -= up;
        if self.depth == 0 && self.index == 1 {
            *self = Self { span: self.span + 1, depth: 0, index: 0 };
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // what is exact is meant to be
mod tests {
    use super::*;
    use std::vec::Vec;

    /// A stream of numbers that looks random.
    struct Draw(u64);

    impl Draw {
        fn next(&mut self, from: f64, to: f64) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            from + (to - from) * (self.0 >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    /// A basis function by its recursive definition (Cox, de Boor), which shares nothing with the code above.
    fn basis(knots: &[f64], i: usize, p: usize, u: f64) -> f64 {
        if p == 0 {
            let last = knots.iter().all(|knot| *knot <= knots[i + 1]);
            let inside = knots[i] <= u && (u < knots[i + 1] || last && u <= knots[i + 1]);
            return f64::from(u8::from(inside && knots[i] < knots[i + 1]));
        }
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        share(u - knots[i], knots[i + p] - knots[i]) * basis(knots, i, p - 1, u)
            + share(knots[i + p + 1] - u, knots[i + p + 1] - knots[i + 1])
                * basis(knots, i + 1, p - 1, u)
    }

    fn point<const N: usize>(
        p: usize,
        points: &[[f64; N]],
        weights: &[f64],
        knots: &[f64],
        u: f64,
    ) -> [f64; N] {
        let parts: Vec<f64> =
            (0..points.len()).map(|i| weights[i] * basis(knots, i, p, u)).collect();
        let whole: f64 = parts.iter().sum();
        from_fn(|axis| {
            parts.iter().zip(points).map(|(part, point)| part * point[axis]).sum::<f64>() / whole
        })
    }

    fn bezier<const N: usize>(b: &[[f64; N]; 4], t: f64) -> [f64; N] {
        let v = 1.0 - t;
        from_fn(|i| {
            v * v * v * b[0][i]
                + 3.0 * v * v * t * b[1][i]
                + 3.0 * v * t * t * b[2][i]
                + t * t * t * b[3][i]
        })
    }

    fn even(n: usize, p: usize) -> Vec<f64> {
        (0..=n + p).map(|i| i.clamp(p, n) as f64 - p as f64).collect()
    }

    /// Curves of every degree with any weights and knots: the cubics join, end where the curve ends, and are within the error at
    /// equal parameter everywhere.
    #[test]
    fn cubics_are_within_their_error() {
        let mut draw = Draw(1);
        let mut worst = 0.0f64;
        for round in 0..45 {
            let p = 1 + round % DEGREE;
            let n = p + 1 + draw.next(0.0, 9.0) as usize;
            let size = 10f64.powf(draw.next(-1.0, 3.0));
            let points: Vec<[f64; 2]> =
                (0..n).map(|_| [draw.next(-size, size), draw.next(-size, size)]).collect();
            let weights: Vec<f64> = (0..n).map(|_| 10f64.powf(draw.next(-1.0, 1.0))).collect();
            let mut knots = even(n, p);
            let given = round % 2 == 0;
            if given {
                // Uneven, and some of them twice.
                for k in p + 1..n {
                    knots[k] = knots[k - 1]
                        + f64::from(u8::from(draw.next(0.0, 1.0) < 0.7)) * draw.next(0.1, 3.0);
                }
                let end = knots[n - 1] + 1.0;
                knots[n..].fill(end);
            }
            // A knot that is there as often as the degree says is a kink; more often it would be a leap.
            if knots
                .windows(p + 1)
                .skip(1)
                .take(n - 1)
                .any(|few| few[0] == few[p] && few[0] != knots[n])
            {
                continue;
            }
            let kind = if given { Knots::Given(&knots) } else { Knots::Even };
            let curve = Nurbs::new(p, &points, &weights, kind).unwrap();
            let error = 10f64.powf(draw.next(-6.0, -2.0));
            let mut cubics = Cubics::default();
            let mut here = points[0];
            let (mut at, mut count) = (knots[p], 0);
            while let Some(cubic) = cubics.step(&curve, error) {
                count += 1;
                let [from, to] = cubic.range;
                assert!(from >= at && norm(&sub(&cubic.points[0], &here)) < 1e-9 * size, "{round}");
                (at, here) = (to, cubic.points[3]);
                for k in 0..=8 {
                    let t = f64::from(k) / 8.0;
                    let meant = point(p, &points, &weights, &knots, from + (to - from) * t);
                    let off = if cubic.is_straight {
                        // It is the same line, at another parameter.
                        let (way, off) = (
                            sub(&cubic.points[3], &cubic.points[0]),
                            sub(&meant, &cubic.points[0]),
                        );
                        (way[0] * off[1] - way[1] * off[0]).abs() / norm(&way)
                    } else {
                        norm(&sub(&bezier(&cubic.points, t), &meant))
                    };
                    assert!(off <= error + 1e-11 * size, "{round}: degree {p}, {off} of {error}");
                    worst = worst.max(if cubic.is_straight { 0.0 } else { off / error });
                }
            }
            assert!(norm(&sub(&here, &points[n - 1])) < 1e-12 * size);
            assert!(at == knots[n] && (1..20_000).contains(&count), "{round}: {count}");
        }
        // The bound is no more careful than it must be.
        assert!(worst > 0.3 && worst <= 1.0 + 1e-3, "{worst}");
    }

    /// A polynomial of degree three or less is a cubic as it is; a straight one is a line.
    #[test]
    fn cubics_and_lines_are_not_cut() {
        let points = [[0.0, 0.0], [1.0, 2.0], [3.0, -1.0], [4.0, 0.0], [7.0, 1.0]];
        let count = |p: usize, points: &[[f64; 2]], weights: &[f64]| {
            let curve = Nurbs::new(p, points, weights, Knots::Even).unwrap();
            let mut cubics = Cubics::default();
            let all: Vec<_> = core::iter::from_fn(|| cubics.step(&curve, 1e-6)).collect();
            (all.len(), all.iter().filter(|cubic| cubic.is_straight).count())
        };
        assert_eq!(count(3, &points, &[2.0; 5]), (2, 0));
        assert_eq!(count(2, &points, &[1.0; 5]), (3, 0));
        assert_eq!(count(1, &points, &[1.0; 5]), (4, 4));
        let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [5.0, 5.0]];
        assert_eq!(count(3, &line, &[1.0, 7.0, 0.2, 1.0]), (1, 1));
        assert_eq!(count(3, &[[1.0, 1.0]; 4], &[1.0; 4]), (0, 0));
    }

    #[test]
    fn what_is_wrong_with_a_curve_is_named() {
        let points = [[0.0], [1.0], [2.0]];
        let new = |p, points: &[[f64; 1]], weights: &[f64], knots: Knots<'_>| {
            Nurbs::new(p, points, weights, knots).map(|_| ()).unwrap_err()
        };
        let ones = [1.0; 3];
        assert_eq!(new(0, &points, &ones, Knots::Even), NurbsError::Degree(0));
        assert_eq!(new(10, &points, &ones, Knots::Even), NurbsError::Degree(10));
        let few = NurbsError::Points { points: 3, weights: 3, least: 4 };
        assert_eq!(new(3, &points, &ones, Knots::Even), few);
        assert_eq!(new(1, &points, &[1.0, 0.0, 1.0], Knots::Even), NurbsError::Point { index: 1 });
        assert_eq!(
            new(1, &points, &[1.0, 1.0, f64::NAN], Knots::Even),
            NurbsError::Point { index: 2 }
        );
        assert_eq!(
            new(1, &[[0.0], [f64::INFINITY], [1.0]], &ones, Knots::Even),
            NurbsError::Point { index: 1 }
        );
        let count = NurbsError::KnotCount { knots: 4, needed: 5 };
        assert_eq!(new(1, &points, &ones, Knots::Given(&[0.0, 0.0, 1.0, 1.0])), count);
        let order = NurbsError::KnotOrder { index: 3 };
        assert_eq!(new(1, &points, &ones, Knots::Given(&[0.0, 0.0, 1.0, 0.5, 2.0])), order);
        assert_eq!(new(1, &points, &ones, Knots::Given(&[0.0; 5])), order);
        assert!(std::string::ToString::to_string(&few).contains("4 or more"));
    }
}
