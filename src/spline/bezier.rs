//! Bezier curves of degree two and three.
//!
//! One curve has several formulas here: they are equal but for rounding, and each user keeps to one, so that its
//! results stay the same to the bit.

use crate::number::Scalar;
use crate::number::vector::Vector;
use core::array::from_fn;

/// The parabola with three Bezier points, at `u` in [0, 1].
pub fn parabola<S: Scalar, const N: usize>([a, b, c]: [&Vector<S, N>; 3], u: S) -> Vector<S, N> {
    let v = S::ONE - u;
    let (va, vb, vc) = (v * v, S::of(2.0) * u * v, u * u);
    from_fn(|i| va * a[i] + vb * b[i] + vc * c[i])
}

/// A cubic of one axis at a parameter.
#[derive(Clone, Copy, Debug)]
pub struct CubicPoint<S> {
    /// Its value.
    pub value: S,
    /// First derivative by the parameter.
    pub first: S,
    /// Second derivative by the parameter.
    pub second: S,
}

/// The cubic of one axis with four Bezier points, at `u` in [0, 1].
pub fn cubic<S: Scalar>(p: [S; 4], u: S) -> CubicPoint<S> {
    let v = S::ONE - u;
    let (three, six, two) = (S::of(3.0), S::of(6.0), S::of(2.0));
    let (d0, d1, d2) = (p[1] - p[0], p[2] - p[1], p[3] - p[2]);
    CubicPoint {
        value: ((p[0] * v + three * p[1] * u) * v + three * p[2] * u * u) * v + p[3] * u * u * u,
        first: three * ((d0 * v + two * d1 * u) * v + d2 * u * u),
        second: six * ((d1 - d0) * v + (d2 - d1) * u),
    }
}

/// Weights of the four Bezier points of a cubic at `u` in [0, 1]: the Bernstein polynomials.
pub fn weights<S: Scalar>(u: S) -> [S; 4] {
    let v = S::ONE - u;
    let (uu, vv, three) = (u * u, v * v, S::of(3.0));
    [vv * v, three * vv * u, three * v * uu, uu * u]
}

/// The cubic with the Bezier points 0 and three others, at `u` in [0, 1].
pub fn cubic_from_origin<const N: usize>([a, b, c]: &[[f64; N]; 3], u: f64) -> [f64; N] {
    let v = 1.0 - u;
    from_fn(|i| 3.0 * v * u * (v * a[i] + u * b[i]) + u * u * u * c[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_formulas_are_of_one_curve() {
        let p = [0.0f64, 1.5, -0.7, 2.2];
        let h = 1.0e-5;
        for k in 0..=10 {
            let u = f64::from(k) / 10.0;
            let CubicPoint { value, first, second } = cubic(p, u);
            let by_weights: f64 = weights(u).iter().zip(p).map(|(w, p)| w * p).sum();
            let [from_origin] = cubic_from_origin(&[[p[1]], [p[2]], [p[3]]], u);
            assert!((value - by_weights).abs() < 1e-14 && (value - from_origin).abs() < 1e-14);
            let edges: [Vector<f64, 1>; 3] = from_fn(|j| [3.0 * (p[j + 1] - p[j])]);
            let [slope] = parabola([&edges[0], &edges[1], &edges[2]], u);
            assert!((first - slope).abs() < 1e-13);
            let (before, after) = (cubic(p, u - h), cubic(p, u + h));
            assert!(((after.value - before.value) / (2.0 * h) - first).abs() < 1e-8);
            assert!(((after.first - before.first) / (2.0 * h) - second).abs() < 1e-8);
        }
    }
}
