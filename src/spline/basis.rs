//! Cubic B-splines over any knots, by what a single span sees of them.
//!
//! A span between two knots is a cubic made of four control points; besides its own two knots it
//! depends on two more on either side.

use crate::number::{Length, Scalar};

/// The six knots a span depends on, as arc lengths from the span's start, mm; the third is 0, the
/// fourth the length of the span.
#[derive(Clone, Copy, Debug)]
pub struct Local<S> {
    knots: [S; 6],
}

impl<S: Scalar> Local<S> {
    /// From arc lengths; the span lies between the third and the fourth.
    pub(crate) fn new(knots: &[Length; 6]) -> Self {
        let start = knots[2];
        Self { knots: knots.map(|knot| (knot - start).to_mm()) }
    }

    /// From knots counted from the third of them.
    pub fn from_knots(knots: [S; 6]) -> Self {
        Self { knots }
    }

    /// Length of the span, mm.
    pub fn step(&self) -> S {
        self.knots[3]
    }

    /// The basis functions of the four control points at a place of the span, by the recurrence
    /// of Cox and de Boor.
    pub fn values(&self, at: S) -> [S; 4] {
        let [t0, t1, t2, t3, t4, t5] = self.knots;
        let rights = [t3 - at, t4 - at, t5 - at];
        let (mut n, mut lefts) = ([S::ONE, S::ZERO, S::ZERO, S::ZERO], [S::ZERO; 3]);
        for (j, left) in [t2, t1, t0].into_iter().enumerate() {
            // The left ends of this degree's supports: one more in front each time.
            lefts = [at - left, lefts[0], lefts[1]];
            let mut saved = S::ZERO;
            for ((n, right), left) in n.iter_mut().zip(rights).zip(lefts).take(j + 1) {
                let part = *n / (right + left);
                *n = saved + right * part;
                saved = left * part;
            }
            if let Some(last) = n.get_mut(j + 1) {
                *last = saved;
            }
        }
        n
    }

    /// Factors 3 / support of the three edges of the control polygon: the control points of the
    /// first derivative are these times the edges.
    pub fn firsts(&self) -> [S; 3] {
        let t = &self.knots;
        let three = S::of(3.0);
        [three / (t[3] - t[0]), three / (t[4] - t[1]), three / t[5]]
    }

    /// Factors 2 / support of the differences of those: the second derivatives at both ends.
    pub fn seconds(&self) -> [S; 2] {
        let two = S::of(2.0);
        [two / (self.knots[3] - self.knots[1]), two / self.knots[4]]
    }

    /// The knots next to those of the span, from its start.
    pub fn beside(&self) -> [S; 2] {
        [self.knots[1], self.knots[4]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNEVEN: [i64; 6] = [-3, -1, 0, 2, 3, 7];

    fn local() -> Local<f64> {
        Local::new(&UNEVEN.map(|k| Length::from_raw(k * Length::PER_MM)))
    }

    /// The spline with control points at the Greville abscissae is the identity, and its values
    /// add up to one.
    #[test]
    fn lines_are_reproduced() {
        let knots = UNEVEN.map(|k| k as f64);
        for k in 0..=8 {
            let u = f64::from(k) * 0.25;
            let n = local().values(u);
            assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let at: f64 =
                (0..4).map(|j| n[j] * (knots[j] + knots[j + 1] + knots[j + 2]) / 3.0).sum();
            assert!((at - u).abs() < 1e-14, "{u} {at}");
        }
    }
}
