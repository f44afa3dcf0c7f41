//! A motion as a uniform cubic B-spline in time, and states.

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
pub(super) fn weights<S: Scalar>(share: S) -> [S; 4] {
    let (u, v) = (share, S::ONE - share);
    let (sixth, two_thirds, half) = (S::of(1.0 / 6.0), S::of(2.0 / 3.0), S::of(0.5));
    [
        v * v * v * sixth,
        two_thirds - u * u * (S::ONE - u * half),
        two_thirds - v * v * (S::ONE - v * half),
        u * u * u * sixth,
    ]
}

/// The same, of the change per span.
pub(super) fn slopes<S: Scalar>(share: S) -> [S; 4] {
    let (u, v) = (share, S::ONE - share);
    let (half, threehalf, two) = (S::of(0.5), S::of(1.5), S::of(2.0));
    [-v * v * half, u * (threehalf * u - two), v * (two - threehalf * v), u * u * half]
}

/// Four control points by weights.
pub(super) fn mixed<S: Scalar, const N: usize>(points: &[[S; N]], weights: &[S; 4]) -> [S; N] {
    core::array::from_fn(|i| {
        weights[0] * points[0][i]
            + weights[1] * points[1][i]
            + weights[2] * points[2][i]
            + weights[3] * points[3][i]
    })
}

/// State a share of the span of four control points behind its start.
pub(super) fn within<S: Scalar, const N: usize>(four: &[[S; N]], h: S, share: S) -> State<S, N> {
    let (two, three) = (S::of(2.0), S::of(3.0));
    let bend = [S::ONE - share, three * share - two, S::ONE - three * share, share];
    State {
        position: mixed(four, &weights(share)),
        velocity: mixed(four, &slopes(share)).map(|x| x / h),
        acceleration: mixed(four, &bend).map(|x| x / (h * h)),
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
    fn weights_sum_to_one_and_slopes_are_their_changes() {
        for k in 0..=10 {
            let (u, step) = (f64::from(k) * 0.1, 1e-6);
            let (a, b, slopes) = (weights(u - step), weights(u + step), slopes(u));
            assert!((weights(u).iter().sum::<f64>() - 1.0).abs() < 1e-14);
            for i in 0..4 {
                assert!(((b[i] - a[i]) / (2.0 * step) - slopes[i]).abs() < 1e-9, "{u} {i}");
            }
        }
    }
}
