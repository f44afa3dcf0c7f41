//! A motion as a uniform cubic B-spline in time, and states.

use super::COUPLED;
use super::vector::along;
use crate::number::Scalar;

/// A state of motion: position, velocity and acceleration of every axis.
#[derive(Clone, Copy, Debug)]
pub struct State<S, const N: usize> {
    /// mm.
    pub position: [S; N],
    /// mm/s.
    pub velocity: [S; N],
    /// mm/s2.
    pub acceleration: [S; N],
}

impl<S: Scalar, const N: usize> State<S, N> {
    /// At rest.
    pub fn resting(position: [S; N]) -> Self {
        Self { position, velocity: [S::ZERO; N], acceleration: [S::ZERO; N] }
    }

    /// The three control points of a spline with knots every `h` that has this state in a knot: which are linear in the state.
    pub(super) fn points(&self, h: S) -> [[S; N]; 3] {
        let square = h * h;
        let mid = along(&self.position, -square * S::of(1.0 / 6.0), &self.acceleration);
        let bent = along(&mid, square * S::of(0.5), &self.acceleration);
        [along(&bent, -h, &self.velocity), mid, along(&bent, h, &self.velocity)]
    }
}

/// Weights of the four control points of a span, a share of it behind its start.
pub(super) fn weights<S: Scalar>(share: S) -> [S; COUPLED] {
    let (u, v) = (share, S::ONE - share);
    let (sixth, two_thirds, half) = (S::of(1.0 / 6.0), S::of(2.0 / 3.0), S::of(0.5));
    [
        v * v * v * sixth,
        two_thirds - u * u * (S::ONE - u * half),
        two_thirds - v * v * (S::ONE - v * half),
        u * u * u * sixth,
    ]
}

/// A span as a polynomial of the share of it that lies behind: its coefficients.
pub(super) struct Cubic<S, const N: usize>([[S; N]; COUPLED]);

impl<S: Scalar, const N: usize> Cubic<S, N> {
    /// Of four control points.
    pub(super) fn new(four: &[[S; N]]) -> Self {
        let (half, sixth) = (S::of(0.5), S::of(1.0 / 6.0));
        let mut of = [[S::ZERO; N]; COUPLED];
        for i in 0..N {
            let [first, second, third] =
                [four[1][i] - four[0][i], four[2][i] - four[1][i], four[3][i] - four[2][i]];
            let bend = second - first;
            of[0][i] = four[1][i] + bend * sixth;
            of[1][i] = (first + second) * half;
            of[2][i] = bend * half;
            of[3][i] = (third - second - bend) * sixth;
        }
        Self(of)
    }

    /// Position.
    pub(super) fn at(&self, share: S) -> [S; N] {
        let [a, b, c, d] = &self.0;
        core::array::from_fn(|i| a[i] + share * (b[i] + share * (c[i] + share * d[i])))
    }

    /// Its change per span.
    pub(super) fn slope(&self, share: S) -> [S; N] {
        let [_, b, c, d] = &self.0;
        let (two, three) = (S::of(2.0), S::of(3.0));
        core::array::from_fn(|i| b[i] + share * (two * c[i] + share * three * d[i]))
    }

    /// The change of that.
    pub(super) fn bend(&self, share: S) -> [S; N] {
        let [.., c, d] = &self.0;
        let (two, six) = (S::of(2.0), S::of(6.0));
        core::array::from_fn(|i| two * c[i] + six * share * d[i])
    }
}

/// State a share of the span of four control points behind its start.
pub(super) fn within<S: Scalar, const N: usize>(four: &[[S; N]], h: S, share: S) -> State<S, N> {
    let cubic = Cubic::new(four);
    State {
        position: cubic.at(share),
        velocity: cubic.slope(share).map(|x| x / h),
        acceleration: cubic.bend(share).map(|x| x / (h * h)),
    }
}

/// State in the knot between three control points.
pub(super) fn state<S: Scalar, const N: usize>(points: &[[S; N]], h: S) -> State<S, N> {
    let (sixth, two) = (S::of(1.0 / 6.0), S::of(2.0));
    let (half, square) = (S::of(0.5) / h, S::ONE / (h * h));
    let at = |f: &dyn Fn(S, S, S) -> S| {
        core::array::from_fn(|i| f(points[0][i], points[1][i], points[2][i]))
    };
    State {
        position: at(&|a, b, c| b + (a - b + (c - b)) * sixth),
        velocity: at(&|a, _, c| (c - a) * half),
        acceleration: at(&|a, b, c| (a - two * b + c) * square),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_have_the_state_that_they_were_made_of() {
        let given =
            State { position: [3.0, -1.0], velocity: [20.0, 5.0], acceleration: [-400.0, 90.0] };
        let found = state(&given.points(0.008), 0.008);
        for i in 0..2 {
            assert!((found.position[i] - given.position[i]).abs() < 1e-12);
            assert!((found.velocity[i] - given.velocity[i]).abs() < 1e-9);
            assert!((found.acceleration[i] - given.acceleration[i]).abs() < 1e-7);
        }
    }

    #[test]
    fn weights_and_polynomials_are_of_one_motion() {
        let four = [[1.0, -3.0], [2.5, 0.5], [-1.0, 4.0], [0.3, 0.2]];
        let cubic = Cubic::new(&four);
        for k in 0..=10 {
            let (u, step) = (f64::from(k) * 0.1, 1e-5);
            let weights = weights(u);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let (before, after) = (cubic.at(u - step), cubic.at(u + step));
            for i in 0..2 {
                let mixed = (0..4).map(|k| weights[k] * four[k][i]).sum::<f64>();
                let (here, slope) = (cubic.at(u)[i], (after[i] - before[i]) / (2.0 * step));
                let bend = (after[i] - 2.0 * here + before[i]) / (step * step);
                assert!((here - mixed).abs() < 1e-14, "{u} {i}");
                assert!((cubic.slope(u)[i] - slope).abs() < 1e-8, "{u} {i}");
                assert!((cubic.bend(u)[i] - bend).abs() < 1e-4, "{u} {i}");
            }
        }
    }
}
