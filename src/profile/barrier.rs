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
pub const GROUP: usize = 4;
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

/// The rows of which so much is left that their barrier is a logarithm, however it is relaxed.
#[derive(Clone, Copy, Debug)]
pub struct Logs<S> {
    product: S,
    /// Their barrier, but for the logarithm of `product`.
    sum: S,
}

impl<S: Scalar> Logs<S> {
    const NONE: Self = Self { product: S::ONE, sum: S::ZERO };

    /// Takes what is left of a limit on both sides. After at most [`GROUP`] of them the product must be looked at.
    #[inline]
    pub fn take(&mut self, left: S) {
        self.product = self.product * left;
    }

    /// Takes the product's logarithm before it is too small a number.
    #[inline]
    pub fn look(&mut self) {
        if self.product < S::of(LEAST_PRODUCT) {
            self.fold();
        }
    }

    /// Takes what is left of a limit on one side that is near.
    #[inline]
    pub fn take_near(&mut self, left: S) {
        let u = left * S::of(1.0 / NEAR);
        self.sum = self.sum + (u - S::ONE);
        self.take(u);
        self.look();
    }

    #[inline]
    fn fold(&mut self) {
        self.sum = self.sum - self.product.ln();
        self.product = S::ONE;
    }

    /// Their barrier.
    pub fn value(mut self) -> S {
        self.fold();
        self.sum
    }
}

/// Sums the barrier over all rows; notices a broken limit.
#[derive(Clone, Copy, Debug)]
pub struct Slack<S> {
    pub relaxation: Relaxation<S>,
    pub logs: Logs<S>,
    /// The barrier of the other rows.
    pub others: S,
    /// Least slack seen; positive means that all limits hold.
    least: S,
    /// Sum of the penalties.
    pub penalty: S,
}

impl<S: Scalar> Slack<S> {
    pub fn new(relaxation: Relaxation<S>) -> Self {
        let zero = S::ZERO;
        Self { relaxation, logs: Logs::NONE, others: zero, least: S::ONE, penalty: zero }
    }

    /// Whether a limit is broken that must not be.
    #[inline]
    pub fn is_broken(&self) -> bool {
        !(self.least > S::ZERO || self.relaxation.is_relaxed())
    }

    /// Takes note of what is left of a limit. A NaN counts as broken: the comparison is false for it.
    #[inline]
    pub fn note(&mut self, left: S) {
        if !(left > self.least) {
            self.least = left;
        }
    }

    /// Takes a row with one side, of which so much is left that it is near.
    fn near(&mut self, left: S) {
        debug_assert!(is_near(left));
        self.note(left);
        if left >= self.relaxation.delta() {
            self.logs.take_near(left);
        } else {
            self.others = self.others + self.relaxation.of_one(left);
        }
    }

    /// What the value of the barrier is at least: without a logarithm that is never negative.
    #[inline]
    pub fn least_barrier(&self) -> S {
        self.logs.sum + self.others
    }

    /// Value of the barrier.
    pub fn barrier(&self) -> S {
        self.logs.value() + self.others
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
        const { assert!(M <= GROUP) };
        let slack = r.map(|r| S::ONE - r * r);
        let mut least = slack[0];
        for &left in &slack {
            if !(left > least) {
                least = left;
            }
        }
        self.note(least);
        if least >= self.relaxation.delta() {
            for &left in &slack {
                self.logs.take(left);
            }
            self.logs.look();
            return;
        }
        for (&r, left) in r.iter().zip(slack) {
            self.others = self.others + self.relaxation.of_two(r, left);
        }
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
