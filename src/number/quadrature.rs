//! Gauss-Legendre quadrature on [0, 1]: the one table of its rules.
//!
//! A rule of n points is exact for polynomials up to the degree 2 n - 1 (Abramowitz and Stegun, 25.4.30, moved from
//! [-1, 1]). Fixed numbers of points: the cost is known, and the bits agree on every target.

use super::Scalar;

/// A point of a rule.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Where, 0 to 1.
    pub at: f64,
    /// Its weight; those of a rule add up to 1.
    pub weight: f64,
}

const fn point(at: f64, weight: f64) -> Point {
    Point { at, weight }
}

/// The rule of two points.
pub const TWO: [Point; 2] =
    [point(0.211_324_865_405_187_1, 0.5), point(0.788_675_134_594_812_9, 0.5)];

/// The rule of three points.
pub const THREE: [Point; 3] = [
    point(0.112_701_665_379_258_31, 5.0 / 18.0),
    point(0.5, 8.0 / 18.0),
    point(0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// The rule of five points.
pub const FIVE: [Point; 5] = [
    point(0.046_910_077_030_668, 0.118_463_442_528_094_5),
    point(0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    point(0.5, 0.284_444_444_444_444_4),
    point(0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    point(0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// The integral of a function, by the rule of three points.
pub fn integral<S: Scalar>(from: S, to: S, f: impl Fn(S) -> S) -> S {
    let mut sum = S::ZERO;
    for Point { at, weight } in THREE {
        sum += S::of(weight) * f(from + (to - from) * S::of(at));
    }
    sum * (to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral of x^k over [0, 1] is 1 / (k + 1).
    fn exact_up_to(degree: i32, rule: &[Point]) {
        for k in 0..=degree {
            let sum: f64 = rule.iter().map(|p| p.weight * p.at.powi(k)).sum();
            assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1.0e-14, "{} points, {k}", rule.len());
        }
        let beyond: f64 = rule.iter().map(|p| p.weight * p.at.powi(degree + 1)).sum();
        assert!((beyond - 1.0 / f64::from(degree + 2)).abs() > 1.0e-9);
    }

    #[test]
    fn rules_are_exact_for_their_degree() {
        exact_up_to(3, &TWO);
        exact_up_to(5, &THREE);
        exact_up_to(9, &FIVE);
    }

    #[test]
    fn an_integral_is_that_over_its_range() {
        assert!((integral(1.0f64, 3.0, |x| x * x) - 26.0 / 3.0).abs() < 1.0e-14);
        assert!(integral(2.0f32, 2.0, |x| x) <= 0.0);
    }
}
