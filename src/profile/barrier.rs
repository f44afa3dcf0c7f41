//! The barrier over one cell: its value, its derivatives, and what stands in for the curvature of
//! the time.

use super::law::{Law, State};
use super::rows::{Gradient, Sink};
use crate::number::Scalar;

/// Share of the second derivative of the time that is used: far from the limits it lets speeds
/// grow threefold in a step instead of by two thirds.
const TIME_CURVATURE: f64 = 0.3;

/// Rounding of the corner in the price of an excess.
const ROUNDING: f64 = 0.01;

/// What r exceeds 1 by, its corner rounded: value and first two derivatives.
fn hinge<S: Scalar>(r: S) -> [S; 3] {
    let half = S::of(0.5);
    let rounding = S::of(ROUNDING);
    let excess = r - S::ONE;
    let root = (excess * excess + rounding * rounding).sqrt();
    [
        (excess + root) * half,
        (S::ONE + excess / root) * half,
        rounding * rounding / (root * root * root) * half,
    ]
}

/// Collects gradient and second derivatives of the barrier over one cell.
pub struct Model<S> {
    pub weight: S,
    pub gradient: Gradient<S>,
    /// Upper triangle, row by row.
    pub hessian: [S; 10],
}

impl<S: Scalar> Model<S> {
    #[inline]
    fn add(&mut self, slope: S, curvature: S, g: &Gradient<S>) {
        let mut n = 0;
        for i in 0..4 {
            self.gradient[i] += slope * g[i];
            let row = curvature * g[i];
            for gj in &g[i..] {
                self.hessian[n] += row * *gj;
                n += 1;
            }
        }
    }
}

impl<S: Scalar> Sink<S> for Model<S> {
    const GRADIENT: bool = true;
    #[inline]
    fn two_sided(&mut self, r: S, g: &Gradient<S>) {
        // -mu ln(1 - r^2)
        let per = S::ONE / (S::ONE - r * r);
        let slope = S::of(2.0) * r * per;
        let curvature = S::of(2.0) * per + slope * slope;
        self.add(self.weight * slope, self.weight * curvature, g);
    }
    #[inline]
    fn one_sided(&mut self, r: S, g: &Gradient<S>) {
        // -mu ln(1 - r)
        let per = S::ONE / (S::ONE - r);
        self.add(self.weight * per, self.weight * per * per, g);
    }
    #[inline]
    fn positive(&mut self, r: S, g: &Gradient<S>) {
        // -mu ln r
        let per = S::ONE / r;
        self.add(-(self.weight * per), self.weight * per * per, g);
    }
    #[inline]
    fn priced(&mut self, r: S, price: S, g: &Gradient<S>) {
        let [_, slope, curvature] = hinge(r);
        self.add(price * slope, price * curvature, g);
    }
}

/// Sums the logarithms of what is left of the limits; notices a broken one.
pub struct Slack<S> {
    pub product: S,
    pub logarithm: S,
    /// Least slack seen; positive means that all limits hold.
    pub least: S,
    /// Sum of the prices.
    pub price: S,
}

impl<S: Scalar> Slack<S> {
    #[inline]
    fn take(&mut self, slack: S) {
        // A NaN must count as broken: the comparison is false for it.
        if !(slack > self.least) {
            self.least = slack;
        }
        self.product = self.product * slack;
        if self.product < S::of(1.0e-18) && self.product > S::ZERO {
            self.fold();
        }
    }

    #[inline]
    pub fn fold(&mut self) {
        self.logarithm += self.product.ln();
        self.product = S::ONE;
    }
}

impl<S: Scalar> Sink<S> for Slack<S> {
    const GRADIENT: bool = false;
    #[inline]
    fn two_sided(&mut self, r: S, _: &Gradient<S>) {
        self.take(S::ONE - r * r);
    }
    #[inline]
    fn one_sided(&mut self, r: S, _: &Gradient<S>) {
        self.take(S::ONE - r);
    }
    #[inline]
    fn positive(&mut self, r: S, _: &Gradient<S>) {
        self.take(r);
    }
    #[inline]
    fn priced(&mut self, r: S, price: S, _: &Gradient<S>) {
        self.price += price * hinge(r)[0];
    }
}

/// From derivatives by v to derivatives by b = v^2; those by fixed states vanish.
#[inline]
pub fn by_square<S: Scalar>(
    model: &Model<S>,
    law: &Law<S>,
    (free0, free1): (bool, bool),
) -> (Gradient<S>, [S; 10]) {
    let mut factor = [S::ZERO; 4];
    if free0 {
        factor[0] = S::of(0.5) / law.v0;
        factor[1] = S::ONE;
    }
    if free1 {
        factor[2] = S::of(0.5) / law.v1;
        factor[3] = S::ONE;
    }
    let gradient = core::array::from_fn(|k| model.gradient[k] * factor[k]);
    let mut hessian = model.hessian;
    let mut n = 0;
    for i in 0..4 {
        for fj in &factor[i..] {
            hessian[n] = hessian[n] * (factor[i] * *fj);
            n += 1;
        }
    }
    (gradient, hessian)
}

/// Damping, by relative changes of b and of a over the cell. It shortens a step along a curved
/// limit and leaves the way off the limit as it is, which shortening the whole step would not.
#[inline]
pub fn add_damping<S: Scalar>(
    hessian: &mut [S; 10],
    weight: S,
    length: S,
    (from, to): (State<S>, State<S>),
    (free0, free1): (bool, bool),
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
    length: S,
    (from, to): (State<S>, State<S>),
    (free0, free1): (bool, bool),
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
    let weight = S::of(4.0) * steepness(middle);
    let mut g = [S::ZERO; 4];
    if free0 {
        g[0] = S::of(0.5);
        g[1] = quarter;
    }
    if free1 {
        g[2] = S::of(0.5);
        g[3] = -quarter;
    }
    let mut n = 0;
    for i in 0..4 {
        for gj in &g[i..] {
            hessian[n] += weight * g[i] * *gj;
            n += 1;
        }
    }
}
