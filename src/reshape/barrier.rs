//! What being near a limit costs.

use crate::number::Scalar;

/// `-ln(1 - y^2)` of a share `y` of a limit, and beyond a share that is near 1 the parabola that goes on from there: a guess may
/// break limits, and is led back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Barrier<S> {
    /// Where the parabola begins.
    edge: S,
    /// Value, slope and curvature there.
    there: [S; 3],
}

/// Value, slope and curvature of a cost, by the share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cost<S> {
    pub(super) value: S,
    /// Over the share: is finite at 0.
    pub(super) slope: S,
    pub(super) curvature: S,
}

impl<S: Scalar> Barrier<S> {
    /// With a parabola over the last `width` of the share.
    pub(super) fn new(width: S) -> Self {
        let edge = S::ONE - width;
        let cost = inside(edge);
        Self { edge, there: [cost.value, cost.slope * edge, cost.curvature] }
    }

    /// Cost of a share of a limit, which is not negative.
    pub(super) fn cost(&self, share: S) -> Cost<S> {
        if share < self.edge {
            return inside(share);
        }
        let [value, slope, curvature] = self.there;
        let by = share - self.edge;
        Cost {
            value: value + by * (slope + by * curvature * S::of(0.5)),
            slope: (slope + by * curvature) / share,
            curvature,
        }
    }
}

fn inside<S: Scalar>(share: S) -> Cost<S> {
    let square = share * share;
    let slack = S::ONE - square;
    let two = S::of(2.0);
    let slope = two / slack;
    Cost { value: -slack.ln(), slope, curvature: slope * (S::ONE + square) / slack }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_and_curvatures_are_those_of_the_values() {
        let barrier = Barrier::<f64>::new(0.05);
        for k in 1..150 {
            let (share, step) = (f64::from(k) * 0.0101, 1e-5);
            let [before, here, after] =
                [share - step, share, share + step].map(|share| barrier.cost(share));
            let slope = (after.value - before.value) / (2.0 * step);
            let curvature =
                (after.slope * (share + step) - before.slope * (share - step)) / (2.0 * step);
            assert!((here.slope * share - slope).abs() < 1e-5 * (1.0 + slope.abs()), "{share}");
            assert!((here.curvature - curvature).abs() < 1e-3 * (1.0 + curvature), "{share}");
        }
    }
}
