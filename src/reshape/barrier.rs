//! What being near a limit costs.

use crate::number::Scalar;

/// The logarithm is taken of a product of what is left of several limits: as often as that becomes less than this.
const LEAST: f64 = 1.0e-20;

/// `-ln(1 - y^2)` of a share `y` of a limit, and beyond a share that is near 1 the parabola that goes on from there: a guess may
/// break limits, and is led back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Barrier<S> {
    /// Where the parabola begins, and the square of that.
    edge: S,
    square: S,
    /// Value, slope and curvature there.
    there: [S; 3],
}

/// How a cost changes, by the share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change<S> {
    /// Slope over the share: is finite at 0.
    pub(super) slope: S,
    /// By how much the curvature is more than that, over the share's square.
    pub(super) bent: S,
}

impl<S: Scalar> Barrier<S> {
    /// With a parabola over the last `width` of the share.
    pub(super) fn new(width: S) -> Self {
        let edge = S::ONE - width;
        let square = edge * edge;
        let Change { slope, bent } = inside(square);
        let value = -(S::ONE - square).ln();
        Self { edge, square, there: [value, slope * edge, slope + bent * square] }
    }

    /// How the cost changes, by the square of a share.
    pub(super) fn change(&self, square: S) -> Change<S> {
        if square < self.square {
            return inside(square);
        }
        let [_, slope, curvature] = self.there;
        let share = square.sqrt();
        let slope = (slope + (share - self.edge) * curvature) / share;
        Change { slope, bent: (curvature - slope) / square }
    }
}

fn inside<S: Scalar>(square: S) -> Change<S> {
    let slope = S::of(2.0) / (S::ONE - square);
    Change { slope, bent: slope * slope }
}

/// Sum of the costs of many shares.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tally<S> {
    pub(super) barrier: Barrier<S>,
    sum: S,
    /// What is left of limits, multiplied: logarithms are slow.
    product: S,
    /// Whether no share was above 1.
    pub(super) keeps: bool,
}

impl<S: Scalar> Tally<S> {
    pub(super) fn new(barrier: Barrier<S>) -> Self {
        Self { barrier, sum: S::ZERO, product: S::ONE, keeps: true }
    }

    /// Adds the cost of a share, by its square.
    pub(super) fn add(&mut self, square: S) {
        if square < self.barrier.square {
            self.product = self.product * (S::ONE - square);
            if self.product < S::of(LEAST) {
                self.sum = self.sum - self.product.ln();
                self.product = S::ONE;
            }
        } else {
            let [value, slope, curvature] = self.barrier.there;
            let by = square.sqrt() - self.barrier.edge;
            self.sum += value + by * (slope + by * curvature * S::of(0.5));
        }
        // What is no number is no share that is kept.
        self.keeps &= square <= S::ONE;
    }

    /// What they cost at least.
    pub(super) fn so_far(&self) -> S {
        self.sum
    }

    pub(super) fn sum(&self) -> S {
        self.sum - self.product.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_those_of_the_values() {
        let barrier = Barrier::<f64>::new(0.05);
        let value = |share: f64| {
            let mut tally = Tally::new(barrier);
            tally.add(share * share);
            tally.sum()
        };
        for k in 1..150 {
            let (share, step) = (f64::from(k) * 0.0101, 1e-5);
            let slope = (value(share + step) - value(share - step)) / (2.0 * step);
            let of = |share: f64| barrier.change(share * share).slope * share;
            let curvature = (of(share + step) - of(share - step)) / (2.0 * step);
            let found = barrier.change(share * share);
            let curved = found.slope + found.bent * share * share;
            assert!((found.slope * share - slope).abs() < 1e-5 * (1.0 + slope.abs()), "{share}");
            assert!((curved - curvature).abs() < 1e-3 * (1.0 + curvature), "{share}");
        }
    }

    #[test]
    fn a_tally_is_the_sum_whatever_is_multiplied() {
        let barrier = Barrier::<f32>::new(1.0e-4);
        let (mut tally, mut sum) = (Tally::new(barrier), 0.0f64);
        for k in 0..500 {
            let square = 0.999 - f64::from(k % 7) * 0.1;
            tally.add(square as f32);
            sum -= (1.0 - f64::from(square as f32)).ln();
        }
        assert!((f64::from(tally.sum()) - sum).abs() < 1.0e-5 * sum, "{} {sum}", tally.sum());
        assert!(tally.keeps);
        tally.add(1.01);
        assert!(!tally.keeps);
        let mut none = Tally::new(barrier);
        none.add(f32::NAN);
        none.add(0.5);
        assert!(!none.keeps);
    }
}
