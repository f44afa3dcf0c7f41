//! Vectors over the axes.

use super::{Coord, Scalar};
use core::array::from_fn;

/// A vector with one component per axis.
pub type Vector<S, const N: usize> = [S; N];

/// No length.
pub fn zero<S: Scalar, const N: usize>() -> Vector<S, N> {
    [S::ZERO; N]
}

/// The scalar product.
pub fn dot<S: Scalar, const N: usize>(a: &Vector<S, N>, b: &Vector<S, N>) -> S {
    let mut sum = S::ZERO;
    for (x, y) in a.iter().zip(b) {
        sum += *x * *y;
    }
    sum
}

/// The Euclidean length.
pub fn norm<S: Scalar, const N: usize>(a: &Vector<S, N>) -> S {
    dot(a, a).sqrt()
}

/// `a - b`.
pub fn sub<S: Scalar, const N: usize>(a: &Vector<S, N>, b: &Vector<S, N>) -> Vector<S, N> {
    from_fn(|i| a[i] - b[i])
}

/// `x a + y b`.
pub fn mix<S: Scalar, const N: usize>(
    x: S,
    a: &Vector<S, N>,
    y: S,
    b: &Vector<S, N>,
) -> Vector<S, N> {
    from_fn(|i| x * a[i] + y * b[i])
}

/// The point `offset` mm away from `at`.
pub fn shifted<S: Scalar, const N: usize>(at: &[Coord; N], offset: &Vector<S, N>) -> [Coord; N] {
    from_fn(|i| at[i].plus(offset[i]))
}
