//! The relaxed logarithmic barrier.
//!
//! -ln(z) of the share z of a limit that is left, down to z = delta; from there on the parabola with the same value, slope
//! and curvature, which exists beyond the limit too (Feller and Ebenbauer, Relaxed Logarithmic Barrier
//! Function Based Model Predictive Control of Linear Systems, IEEE Transactions on Automatic Control 62, 2017, with a
//! parabola for their beta). With it no limit stands in the way of a step, and the start need not keep
//! them; as delta falls, it becomes the barrier itself.

use crate::number::Scalar;

/// A limit on one side of which this share is left, or more, is not in the barrier: of the share u of it that is left the
/// barrier is -ln(u) + u - 1, which meets 0 with slope 0 at 1. (Of limits on two sides all are: without
/// what those add to the second derivatives far from their limits, two and a half times as many steps are needed.)
pub const NEAR: f64 = 0.5;

/// Value, slope and curvature of the barrier, by what is left of a limit or by how much of it is
/// used, where its parabola begins.
#[derive(Clone, Copy, Debug)]
pub struct Parabola<S> {
    pub value: S,
    pub slope: S,
    pub curvature: S,
}

impl<S: Scalar> Parabola<S> {
    /// Slope `beyond` its beginning.
    #[inline]
    pub fn slope(&self, beyond: S) -> S {
        self.slope + self.curvature * beyond
    }

    /// Value `beyond` its beginning.
    #[inline]
    pub fn value(&self, beyond: S) -> S {
        self.value + (self.slope + self.curvature * beyond * S::of(0.5)) * beyond
    }
}

/// Where the barrier leaves the logarithm, and for what.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation<S> {
    /// Share of a limit that is left there; 0 if the barrier is not relaxed.
    delta: S,
    /// What is used of a two-sided limit there: 1 - r^2 = delta.
    used: S,
    /// By what is left, of a limit on one side: see [`NEAR`].
    pub one_sided: Parabola<S>,
    /// By what is used, of a limit on both sides: -ln(1 - r^2).
    pub two_sided: Parabola<S>,
}

impl<S: Scalar> Relaxation<S> {
    /// The barrier that ends at the limits.
    pub const STRICT: Self = {
        let none = Parabola { value: S::ZERO, slope: S::ZERO, curvature: S::ZERO };
        Self { delta: S::ZERO, used: S::ONE, one_sided: none, two_sided: none }
    };

    /// A barrier that goes on as a parabola where less than the share `delta` of a limit is left; 0 < delta < [`NEAR`].
    pub fn new(delta: S) -> Self {
        debug_assert!(delta > S::ZERO && delta < S::of(NEAR));
        let (per, used) = (S::ONE / delta, (S::ONE - delta).sqrt());
        let (value, u) = (-delta.ln(), delta * S::of(1.0 / NEAR));
        let slope = S::of(2.0) * used * per;
        Self {
            delta,
            used,
            one_sided: Parabola {
                value: u - S::ONE - u.ln(),
                slope: per - S::of(1.0 / NEAR),
                curvature: per * per,
            },
            two_sided: Parabola { value, slope, curvature: S::of(2.0) * per + slope * slope },
        }
    }

    /// The same with a delta that is smaller by a factor; the strict barrier stays what it is.
    #[must_use]
    pub fn sharpened(self, factor: S) -> Self {
        if self.is_relaxed() { Self::new(self.delta * factor) } else { self }
    }

    /// The barrier of a limit on one side, of which so much is left that it is near.
    pub fn of_one(&self, left: S) -> S {
        if left < self.delta {
            self.one_sided.value(self.delta - left)
        } else {
            let u = left * S::of(1.0 / NEAR);
            u - S::ONE - u.ln()
        }
    }

    /// The barrier of a limit on both sides whose row is `r`, and of which 1 - r^2 is `left`.
    pub fn of_two(&self, r: S, left: S) -> S {
        if left < self.delta { self.two_sided.value(r.abs() - self.used) } else { -left.ln() }
    }

    /// Whether limits may be exceeded.
    #[inline]
    pub fn is_relaxed(&self) -> bool {
        self.delta > S::ZERO
    }

    /// Share of a limit that is left where the parabola begins.
    #[inline]
    pub fn delta(&self) -> S {
        self.delta
    }

    /// Share of a two-sided limit that is used there.
    #[inline]
    pub fn used(&self) -> S {
        self.used
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where it leaves the logarithm, the parabola meets it with value, slope and curvature.
    #[test]
    fn parabola_meets_the_logarithm() {
        for delta in [0.3, 0.027, 1.0e-4] {
            let relaxation = Relaxation::<f64>::new(delta);
            // So near that the third derivative of the logarithm makes 1e-9 of its value.
            let step = 1.0e-3 * delta;
            let Parabola { value, slope, curvature } = relaxation.one_sided;
            let barrier = |left: f64| left / NEAR - 1.0 - (left / NEAR).ln();
            assert!((value - barrier(delta)).abs() < 1e-12);
            for sign in [-1.0, 1.0] {
                let log = barrier(delta - sign * step);
                let parabola = relaxation.one_sided.value(sign * step);
                assert!((log - parabola).abs() < 1e-8, "{delta}: {log} {parabola}");
            }
            assert!((slope - 1.0 / delta + 1.0 / NEAR).abs() < 1e-9 * slope);
            assert!((curvature - 1.0 / (delta * delta)).abs() < 1e-9 * curvature);
            let used = relaxation.used();
            let step = 1.0e-3 * (1.0 - used);
            for sign in [-1.0, 1.0] {
                let r = used + sign * step;
                let log = -(1.0 - r * r).ln();
                let parabola = relaxation.two_sided.value(sign * step);
                assert!((log - parabola).abs() < 1e-8, "{delta}: {log} {parabola}");
            }
        }
    }

    #[test]
    fn sharpening_never_makes_the_strict_barrier_relaxed() {
        assert!(!Relaxation::<f64>::STRICT.sharpened(0.3).is_relaxed());
        let relaxation = Relaxation::new(0.3f64).sharpened(0.5);
        assert!(relaxation.is_relaxed() && (relaxation.delta() - 0.15).abs() < 1e-15);
    }
}
