//! Sums over the axes.

use crate::number::Scalar;

pub(super) fn dot<S: Scalar, const N: usize>(a: &[S; N], b: &[S; N]) -> S {
    let mut sum = S::ZERO;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
}

pub(super) fn square<S: Scalar, const N: usize>(a: &[S; N]) -> S {
    dot(a, a)
}

pub(super) fn minus<S: Scalar, const N: usize>(a: &[S; N], b: &[S; N]) -> [S; N] {
    core::array::from_fn(|i| a[i] - b[i])
}

/// `a + x b`.
pub(super) fn along<S: Scalar, const N: usize>(a: &[S; N], x: S, b: &[S; N]) -> [S; N] {
    core::array::from_fn(|i| a[i] + x * b[i])
}
