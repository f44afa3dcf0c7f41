//! The value of the barrier over one cell, and of the penalty.
//!
//! It is the logarithm of what is left of every limit that may bind, or the [relaxed](super::relaxation) one.

use super::relaxation::{NEAR, Relaxation};
use super::rows::{End, Gradient, Sink};
use crate::number::Scalar;

/// Rounding of the kink of the penalty, as a share of the goal: within so much on either side its slope goes from a seventh
/// of the whole to six sevenths.
const ROUNDING: f64 = 0.01;

/// Rows whose slacks are multiplied before the product is looked at, and the product from which on
/// its logarithm is taken: four slacks of a rounding error are still a number in `f32`.
const GROUP: usize = 4;
const LEAST_PRODUCT: f64 = 1.0e-9;

/// What r exceeds 1 by, with its kink rounded to a hyperbola: value and first two derivatives.
pub fn hinge<S: Scalar>(r: S) -> [S; 3] {
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

/// Whether a limit on one side of which so much is left is in the barrier; NaN is.
#[inline]
pub fn is_near<S: Scalar>(left: S) -> bool {
    !(left >= S::of(NEAR))
}

/// Gradients that nobody asks for.
pub fn none<S: Scalar, const M: usize>() -> [Gradient<S>; M] {
    [[S::ZERO; 4]; M]
}

/// Sums the barrier over all rows; notices a broken limit.
#[derive(Clone, Copy, Debug)]
pub struct Slack<S> {
    pub relaxation: Relaxation<S>,
    product: S,
    /// Value of the barrier, but for the logarithm of `product`.
    barrier: S,
    /// Least slack seen; positive means that all limits hold.
    least: S,
    /// Sum of the penalties.
    pub penalty: S,
}

impl<S: Scalar> Slack<S> {
    pub fn new(relaxation: Relaxation<S>) -> Self {
        Self { relaxation, product: S::ONE, barrier: S::ZERO, least: S::ONE, penalty: S::ZERO }
    }

    /// Whether a limit is broken that must not be.
    #[inline]
    pub fn is_broken(&self) -> bool {
        !(self.least > S::ZERO || self.relaxation.is_relaxed())
    }

    /// Some rows with what is left of them; at most [`GROUP`], so that their product is a number.
    #[inline]
    fn take<const M: usize>(&mut self, slack: [S; M], beyond: impl Fn(&Relaxation<S>, usize) -> S) {
        const { assert!(M <= GROUP) };
        let mut least = slack[0];
        for &s in &slack {
            // A NaN must count as broken: the comparison is false for it.
            if !(s > least) {
                least = s;
            }
        }
        if !(least > self.least) {
            self.least = least;
        }
        if least >= self.relaxation.delta() {
            for &s in &slack {
                self.product = self.product * s;
            }
            if self.product < S::of(LEAST_PRODUCT) {
                self.fold();
            }
            return;
        }
        for (k, &s) in slack.iter().enumerate() {
            self.barrier = if s < self.relaxation.delta() {
                self.barrier + beyond(&self.relaxation, k)
            } else {
                self.barrier - s.ln()
            };
        }
    }

    /// Takes a row with one side, of which so much is left that it is near.
    pub fn near(&mut self, left: S) {
        debug_assert!(is_near(left));
        if !(left > self.least) {
            self.least = left;
        }
        let delta = self.relaxation.delta();
        if left >= delta {
            let u = left * S::of(1.0 / NEAR);
            self.barrier = self.barrier + (u - S::ONE);
            self.product = self.product * u;
            if self.product < S::of(LEAST_PRODUCT) {
                self.fold();
            }
        } else {
            self.barrier = self.barrier + self.relaxation.one_sided.value(delta - left);
        }
    }

    #[inline]
    fn fold(&mut self) {
        self.barrier = self.barrier - self.product.ln();
        self.product = S::ONE;
    }

    /// What the value of the barrier is at least: without a logarithm that is never negative.
    #[inline]
    pub fn least_barrier(&self) -> S {
        self.barrier
    }

    /// Value of the barrier.
    pub fn barrier(&mut self) -> S {
        self.fold();
        self.barrier
    }
}

impl<S: Scalar> Sink<S> for Slack<S> {
    const GRADIENT: bool = false;
    #[inline]
    fn two_sided<const M: usize>(
        &mut self,
        r: [S; M],
        _: [S; M],
        _: impl FnOnce() -> [Gradient<S>; M],
    ) {
        let beyond = |relaxed: &Relaxation<S>, k: usize| {
            relaxed.two_sided.value(r[k].abs() - relaxed.used())
        };
        let mut slack = r;
        for s in &mut slack {
            *s = S::ONE - *s * *s;
        }
        self.take(slack, beyond);
    }
    #[inline]
    fn two_sided_at(&mut self, _: End, r: S, scale: S, _: [S; 2]) {
        self.two_sided([r], [scale], none);
    }
    #[inline]
    fn one_sided<const M: usize>(&mut self, r: [S; M], _: S, _: impl FnOnce() -> [Gradient<S>; M]) {
        for r in r {
            if is_near(S::ONE - r) {
                self.near(S::ONE - r);
            }
        }
    }
    #[inline]
    fn one_sided_at(&mut self, _: End, r: S, scale: S, _: [S; 2]) {
        self.one_sided([r], scale, none);
    }
    #[inline]
    fn positive(&mut self, r: S, _: impl FnOnce() -> Gradient<S>) {
        if is_near(r) {
            self.near(r);
        }
    }
    #[inline]
    fn positive_at(&mut self, _: End, r: S, _: [S; 2]) {
        self.positive(r, || [S::ZERO; 4]);
    }
    #[inline]
    fn penalised<const M: usize>(
        &mut self,
        r: [S; M],
        weight: S,
        _: impl FnOnce() -> [Gradient<S>; M],
    ) {
        for &r in &r {
            self.penalty += weight * hinge(r)[0];
        }
    }
}
