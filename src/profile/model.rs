//! The derivatives over one cell: those of the [barrier](super::barrier), and what stands in for the curvature of
//! the time.

use super::barrier::{GROUP, Slack, hinge, is_near, none};
use super::law::{Law, PathState};
use super::relaxation::{NEAR, Relaxation};
use super::rows::{End, Gradient, Sink};
use crate::number::Scalar;
use core::array::from_fn;

/// Factor of h b^(-5/2) in the second derivative of the time h b^(-1/2) by b. The true one is 3/4, with which Newton's step
/// from far below the limits takes b to 1.7 times itself; with this one it is 2.7 times, and still an
/// overestimate of what a step costs near the limits, where the barrier decides.
const TIME_CURVATURE: f64 = 0.3;

/// First and second derivatives over one cell.
#[derive(Clone, Copy)]
pub struct Sums<S> {
    pub gradient: Gradient<S>,
    /// Upper triangle, row by row.
    pub hessian: [S; 10],
}

/// Slope and curvature of a function of one row.
#[derive(Clone, Copy)]
struct Bend<S> {
    slope: S,
    curvature: S,
}

/// A barrier that was relaxed no less: its rows that are a logarithm now were one then, or are in `others`.
#[derive(Clone, Copy, Debug)]
pub struct Before<S> {
    pub relaxation: Relaxation<S>,
    /// The barrier of the rows that are not in the logarithms of the one now.
    pub others: S,
}

/// Collects gradient and second derivatives of the barrier over one cell.
pub struct Model<S> {
    /// Its value.
    pub slack: Slack<S>,
    /// The barrier before, of the rows that are not in the logarithms of `slack`.
    pub before: Before<S>,
    /// Barrier parameter in the gradient.
    pub mu: S,
    /// Barrier parameter in the second derivatives.
    pub mu_curvature: S,
    pub sums: Sums<S>,
}

/// Upper triangle of `weight` g g^T, row by row.
#[inline]
fn outer<S: Scalar>(weight: S, g: &Gradient<S>) -> [S; 10] {
    let [g0, g1, g2, g3] = *g;
    let [r0, r1, r2, r3] = [weight * g0, weight * g1, weight * g2, weight * g3];
    [r0 * g0, r0 * g1, r0 * g2, r0 * g3, r1 * g1, r1 * g2, r1 * g3, r2 * g2, r2 * g3, r3 * g3]
}

impl<S: Scalar> Sums<S> {
    pub const ZERO: Self = Self { gradient: [S::ZERO; 4], hessian: [S::ZERO; 10] };

    /// Adds functions of rows by the gradients of these.
    // A function of its own: so the sums stay in registers over all rows, and it is in the image once.
    #[inline(never)]
    fn add(&mut self, rows: &[(Bend<S>, Gradient<S>)]) {
        let Self { mut gradient, mut hessian } = *self;
        for (Bend { slope, curvature }, g) in rows {
            for (sum, gi) in gradient.iter_mut().zip(g) {
                *sum += *slope * *gi;
            }
            for (sum, part) in hessian.iter_mut().zip(outer(*curvature, g)) {
                *sum += part;
            }
        }
        *self = Self { gradient, hessian };
    }

    /// Adds a function of a row that depends on speed and acceleration at one end alone.
    #[inline]
    fn add_at(&mut self, end: End, Bend { slope, curvature }: Bend<S>, [by_v, by_a]: [S; 2]) {
        let [g0, g1, g2, g3] = &mut self.gradient;
        let [h00, h01, _, _, h11, _, _, h22, h23, h33] = &mut self.hessian;
        let ([v, a], [vv, va, aa]) = match end {
            End::Start => ([g0, g1], [h00, h01, h11]),
            End::Finish => ([g2, g3], [h22, h23, h33]),
        };
        *v += slope * by_v;
        *a += slope * by_a;
        let weighted = curvature * by_v;
        *vv += weighted * by_v;
        *va += weighted * by_a;
        *aa += curvature * by_a * by_a;
    }
}

/// Slope and curvature of -ln(1 - r^2) by r, where `left` is 1 - r^2.
#[inline]
fn log_bend<S: Scalar>(r: S, left: S) -> [S; 2] {
    let per = S::ONE / left;
    let slope = S::of(2.0) * r * per;
    [slope, S::of(2.0) * per + slope * slope]
}

impl<S: Scalar> Model<S> {
    /// The barrier's bend by x where `left` is left of a row x `scale` with one side.
    #[inline]
    fn bend(&self, left: S, scale: S) -> Bend<S> {
        let relaxation = &self.slack.relaxation;
        let (slope, curvature) = if !is_near(left) {
            (S::ZERO, S::ZERO)
        } else if left >= relaxation.delta() {
            let per = S::ONE / left;
            (per - S::of(1.0 / NEAR), per * per)
        } else {
            (relaxation.one_sided.slope(relaxation.delta() - left), relaxation.one_sided.curvature)
        };
        self.weighed(slope, curvature, scale)
    }

    /// The same of a row with two sides that is worth `r`, whose value is taken.
    #[inline]
    fn take_two(&mut self, r: S, scale: S) -> Bend<S> {
        let left = S::ONE - r * r;
        let [slope, curvature] = if left >= self.before.relaxation.delta() {
            self.slack.logs.take(left);
            log_bend(r, left)
        } else {
            self.take_two_apart(r, left)
        };
        self.weighed(slope, curvature, scale)
    }

    /// The same where the barrier before was another.
    // A function of its own: it is seldom called, and would take registers from what is done for every row.
    #[inline(never)]
    fn take_two_apart(&mut self, r: S, left: S) -> [S; 2] {
        let relaxation = self.slack.relaxation;
        self.take_apart(left, |barrier| barrier.of_two(r, left));
        if left >= relaxation.delta() {
            return log_bend(r, left);
        }
        let slope = relaxation.two_sided.slope(r.abs() - relaxation.used());
        [if r < S::ZERO { -slope } else { slope }, relaxation.two_sided.curvature]
    }

    /// Takes the value of a row with one side, of which so much is left that it is near.
    #[inline]
    fn take_near(&mut self, left: S) {
        if left >= self.before.relaxation.delta() {
            self.slack.logs.take_near(left);
        } else {
            self.take_near_apart(left);
        }
    }

    #[inline(never)]
    fn take_near_apart(&mut self, left: S) {
        self.take_apart(left, |barrier| barrier.of_one(left));
    }

    /// Takes the values of a row of which so little is `left` that the barrier before was another.
    #[inline]
    fn take_apart(&mut self, left: S, value: impl Fn(&Relaxation<S>) -> S) {
        self.slack.note(left);
        self.slack.others = self.slack.others + value(&self.slack.relaxation);
        self.before.others = self.before.others + value(&self.before.relaxation);
    }

    #[inline]
    fn weighed(&self, slope: S, curvature: S, scale: S) -> Bend<S> {
        Bend {
            slope: self.mu * slope * scale,
            curvature: self.mu_curvature * curvature * (scale * scale),
        }
    }
}

impl<S: Scalar> Sink<S> for Model<S> {
    const GRADIENT: bool = true;
    #[inline]
    fn two_sided<const M: usize>(
        &mut self,
        r: [S; M],
        scale: [S; M],
        g: impl FnOnce() -> [Gradient<S>; M],
    ) {
        const { assert!(M <= GROUP) };
        let g = g();
        let rows: [_; M] = from_fn(|k| (self.take_two(r[k], scale[k]), g[k]));
        self.slack.logs.look();
        self.sums.add(&rows);
    }
    #[inline]
    fn two_sided_at(&mut self, end: End, r: S, scale: S, g: [S; 2]) {
        let bend = self.take_two(r, scale);
        self.slack.logs.look();
        self.sums.add_at(end, bend, g);
    }
    #[inline]
    fn one_sided<const M: usize>(
        &mut self,
        r: [S; M],
        scale: S,
        g: impl FnOnce() -> [Gradient<S>; M],
    ) {
        if r.iter().any(|r| is_near(S::ONE - *r)) {
            for left in r.map(|r| S::ONE - r) {
                if is_near(left) {
                    self.take_near(left);
                }
            }
            let g = g();
            let rows: [_; M] = from_fn(|k| (self.bend(S::ONE - r[k], scale), g[k]));
            self.sums.add(&rows);
        }
    }
    #[inline]
    fn one_sided_at(&mut self, end: End, r: S, scale: S, g: [S; 2]) {
        if is_near(S::ONE - r) {
            self.take_near(S::ONE - r);
            self.sums.add_at(end, self.bend(S::ONE - r, scale), g);
        }
    }
    #[inline]
    fn positive(&mut self, r: S, g: impl FnOnce() -> Gradient<S>) {
        if is_near(r) {
            self.take_near(r);
            self.sums.add(&[(self.bend(r, -S::ONE), g())]);
        }
    }
    #[inline]
    fn positive_at(&mut self, end: End, r: S, g: [S; 2]) {
        if is_near(r) {
            self.take_near(r);
            self.sums.add_at(end, self.bend(r, -S::ONE), g);
        }
    }
    #[inline]
    fn penalised<const M: usize>(
        &mut self,
        r: [S; M],
        weight: S,
        g: impl FnOnce() -> [Gradient<S>; M],
    ) {
        self.slack.penalised(r, weight, none);
        let g = g();
        let rows: [_; M] = from_fn(|k| {
            let [_, slope, curvature] = hinge(r[k]);
            (Bend { slope: weight * slope, curvature: weight * curvature }, g[k])
        });
        self.sums.add(&rows);
    }
}

/// A cell as the unknowns see it.
#[derive(Clone, Copy)]
pub struct CellEnds<S> {
    /// Length of the cell, mm.
    pub length: S,
    pub from: PathState<S>,
    pub to: PathState<S>,
    /// Whether the states at its start and at its end are to be found.
    pub free: [bool; 2],
}

/// From derivatives by v to derivatives by b = v^2; those by fixed states vanish.
#[inline]
pub fn by_square<S: Scalar>(sums: &Sums<S>, law: &Law<S>, [free0, free1]: [bool; 2]) -> Sums<S> {
    let zero = S::ZERO;
    let by = |free: bool, v: S| if free { S::of(0.5) / v } else { zero };
    let (f, e) = (by(free0, law.v0), by(free1, law.v1));
    let [g0, g1, g2, g3] = sums.gradient;
    let [h00, h01, h02, h03, h11, h12, h13, h22, h23, h33] = sums.hessian;
    let mut out = Sums {
        gradient: [g0 * f, g1, g2 * e, g3],
        hessian: [
            h00 * (f * f),
            h01 * f,
            h02 * (f * e),
            h03 * f,
            h11,
            h12 * e,
            h13,
            h22 * (e * e),
            h23 * e,
            h33,
        ],
    };
    let [_, g1, _, g3] = &mut out.gradient;
    let [_, _, _, h03, h11, h12, h13, _, _, h33] = &mut out.hessian;
    if !free0 {
        (*g1, *h11, *h12, *h13) = (zero, zero, zero, zero);
    }
    if !free1 {
        (*g3, *h03, *h13, *h33) = (zero, zero, zero, zero);
    }
    out
}

/// Damping, by relative changes of b and of a over the cell. It shortens a step along a curved
/// limit and leaves the part off the limit as it is, which shortening the whole step would not.
#[inline]
pub fn add_damping<S: Scalar>(
    hessian: &mut [S; 10],
    weight: S,
    &CellEnds { length, from, to, free: [free0, free1] }: &CellEnds<S>,
) {
    if free0 {
        let per = weight / (from.b * from.b);
        hessian[0] += per;
        hessian[4] += per * length * length;
    }
    if free1 {
        let per = weight / (to.b * to.b);
        hessian[7] += per;
        hessian[9] += per * length * length;
    }
}

/// Second derivatives of the time by Simpson's rule over 1 / v: convex in (b, a).
#[inline]
pub fn add_time_curvature<S: Scalar>(
    hessian: &mut [S; 10],
    &CellEnds { length, from, to, free: [free0, free1] }: &CellEnds<S>,
) {
    let steepness = |b: S| S::of(TIME_CURVATURE / 6.0) * length / (b * b * b.sqrt());
    if free0 {
        hessian[0] += steepness(from.b);
    }
    if free1 {
        hessian[7] += steepness(to.b);
    }
    let sum = (from.b + to.b) * S::of(0.5);
    let quarter = length * S::of(0.25);
    let middle = (sum + quarter * (from.a - to.a)).greatest(sum * S::of(0.1));
    // By (1/2, h/4, 1/2, -h/4).
    let weight = S::of(4.0) * steepness(middle);
    let bb = weight * S::of(0.25);
    let ba = weight * S::of(0.5) * quarter;
    let aa = weight * quarter * quarter;
    let [h00, h01, h02, h03, h11, h12, h13, h22, h23, h33] = hessian;
    if free0 {
        *h00 += bb;
        *h01 += ba;
        *h11 += aa;
    }
    if free1 {
        *h22 += bb;
        *h23 -= ba;
        *h33 += aa;
    }
    if free0 && free1 {
        *h02 += bb;
        *h03 -= ba;
        *h12 += ba;
        *h13 -= aa;
    }
}
