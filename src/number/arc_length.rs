//! The length of the path so far.

use super::Scalar;

/// Arc length in fixed point: a whole number of 1e-7 mm.
///
/// A counter, not a place: it goes on for 920,000 km - a machine at 1 m/s takes 29 years for that - and
/// then begins anew at the other end of its range, as counters do. What a length added is rounded by
/// is 0.05 nm at most, up and down alike.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ArcLength(i64);

impl ArcLength {
    /// Zero.
    pub const ZERO: Self = Self(0);
    /// Units in a millimetre.
    pub const PER_MM: i64 = 10_000_000;

    /// From raw units of 1e-7 mm.
    pub const fn from_raw(raw: i64) -> Self {
        Self(raw)
    }

    /// Raw units of 1e-7 mm.
    pub const fn raw(self) -> i64 {
        self.0
    }

    /// In millimetres; the rounding is that of an `f64`.
    pub fn to_mm(self) -> f64 {
        self.0 as f64 / Self::PER_MM as f64
    }

    /// Longer by `mm`.
    #[inline]
    #[must_use]
    pub fn plus<S: Scalar>(self, mm: S) -> Self {
        let half = S::of(if mm < S::ZERO { -0.5 } else { 0.5 });
        let units = mm * S::of(1.0e7);
        Self(self.0.wrapping_add((units + half).to_i64()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_add_up_without_a_bias_and_wrap() {
        for step in [1.234_567_89e-4f64, -3.3e-8, 0.7] {
            let sum = (0..10_000).fold(ArcLength::ZERO, |sum, _| sum.plus(step));
            // Every step is rounded alike.
            assert!((sum.to_mm() - 10_000.0 * step).abs() <= 10_000.0 * 0.5e-7);
        }
        let steps = (0..10_000).map(|k| 1.0e-4 + 1.2345e-9 * f64::from(k));
        let sum = steps.clone().fold(ArcLength::ZERO, ArcLength::plus);
        assert!((sum.to_mm() - steps.sum::<f64>()).abs() < 1.0e-5);
        assert_eq!(ArcLength::from_raw(i64::MAX).plus(1.0f32).raw(), i64::MIN + 9_999_999);
    }
}
