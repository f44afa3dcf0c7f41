//! Fixed-point coordinates.

use super::{Range, RangeError, Scalar};

/// One axis coordinate in fixed point: a whole number of 1e-12 mm (or 1e-12 degrees on a rotary
/// axis).
///
/// Adding and subtracting is exact, so a position never drifts however many blocks have run, in
/// `f32` builds too. The range is +-9.2e6 mm; the core accepts +-[`Coord::LIMIT_MM`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Coord(i64);

impl Coord {
    /// Zero.
    pub const ZERO: Self = Self(0);
    /// Units in a millimetre (or a degree).
    pub const PER_MM: i64 = 1_000_000_000_000;
    /// Largest coordinate that is accepted in a block, mm (1 km).
    pub const LIMIT_MM: f64 = 1.0e6;
    /// Coordinates that are accepted, mm.
    pub const RANGE: Range = Range::new(-Self::LIMIT_MM, Self::LIMIT_MM);

    /// The coordinate nearest to `mm`.
    ///
    /// # Errors
    /// [`RangeError`], in mm, if it is not finite or beyond [`Coord::LIMIT_MM`].
    pub fn from_mm(mm: f64) -> Result<Self, RangeError> {
        if !(mm.abs() <= Self::LIMIT_MM) {
            return Err(Self::RANGE.refused(mm));
        }
        Ok(Self(libm::round(mm * Self::PER_MM as f64) as i64))
    }

    /// From nanometres (or 1e-6 degrees), exact.
    ///
    /// # Errors
    /// [`RangeError`], in mm, beyond [`Coord::LIMIT_MM`].
    pub const fn from_nm(nm: i64) -> Result<Self, RangeError> {
        const LIMIT: i64 = 1_000_000_000_000;
        if nm > LIMIT || nm < -LIMIT {
            return Err(Self::RANGE.refused(nm as f64 * 1.0e-6));
        }
        Ok(Self(nm * 1_000_000))
    }

    /// From raw units of 1e-12 mm.
    pub const fn from_raw(raw: i64) -> Self {
        Self(raw)
    }

    /// Raw units of 1e-12 mm.
    pub const fn raw(self) -> i64 {
        self.0
    }

    /// In millimetres; the rounding is that of an `f64`.
    pub fn to_mm(self) -> f64 {
        self.0 as f64 / Self::PER_MM as f64
    }

    /// In nanometres, rounded to the nearest.
    pub const fn to_nm(self) -> i64 {
        let half = if self.0 < 0 { -500_000 } else { 500_000 };
        (self.0.saturating_add(half)) / 1_000_000
    }

    /// `self - from` in mm.
    #[inline]
    pub fn minus<S: Scalar>(self, from: Self) -> S {
        S::from_i64(self.0.wrapping_sub(from.0)) * S::of(1.0e-12)
    }

    /// Moved by `mm`.
    #[inline]
    #[must_use]
    pub fn plus<S: Scalar>(self, mm: S) -> Self {
        Self(self.0.saturating_add(mm.to_units()))
    }

    /// The point at `fraction` (in 1/2^62, 0..=2^62) of the line to `to`; exact to one unit.
    #[must_use]
    #[inline(never)]
    pub(crate) fn towards(self, to: Self, fraction: i64) -> Self {
        let step = i128::from(to.0) - i128::from(self.0);
        Self(self.0 + ((step * i128::from(fraction)) >> 62) as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn millimetres_and_nanometres_are_rounded_to_the_nearest() {
        assert_eq!(Coord::from_mm(1.0), Coord::from_nm(1_000_000));
        assert_eq!(Coord::from_mm(-0.6e-12).unwrap().raw(), -1);
        assert_eq!(Coord::from_mm(0.4e-12), Ok(Coord::ZERO));
        for (raw, nm) in [(499_999, 0), (500_000, 1), (-499_999, 0), (-500_000, -1)] {
            assert_eq!(Coord::from_raw(raw).to_nm(), nm, "{raw}");
        }
        assert_eq!(Coord::from_raw(i64::MAX).to_nm(), i64::MAX / 1_000_000);
    }

    #[test]
    fn what_is_out_of_range_is_no_coordinate() {
        for mm in [1.0e6, -1.0e6, 0.0] {
            assert!((Coord::from_mm(mm).unwrap().to_mm() - mm).abs() < f64::EPSILON);
        }
        for mm in [1.000_000_1e6, -2.0e6, f64::INFINITY] {
            assert_eq!(Coord::from_mm(mm), Err(Coord::RANGE.refused(mm)));
        }
        assert!(Coord::from_mm(f64::NAN).is_err());
        assert!(Coord::from_nm(1_000_000_000_001).is_err());
    }

    /// Moves of an `f32` add up exactly: what was added is what is between.
    #[test]
    fn sums_do_not_drift() {
        let mut at = Coord::from_mm(999.0).unwrap();
        let start = at;
        for _ in 0..100_000 {
            at = at.plus(0.001f32);
        }
        let step = Coord::ZERO.plus(0.001f32).raw();
        assert_eq!(at.raw() - start.raw(), 100_000 * step);
        assert_eq!(Coord::from_raw(i64::MAX).plus(1.0f64), Coord::from_raw(i64::MAX));
    }

    #[test]
    fn a_fraction_of_a_line_ends_exactly_at_its_end() {
        let (a, b) = (Coord::from_raw(-1_000_000_007), Coord::from_raw(3_000_000_001));
        assert_eq!((a.towards(b, 0), a.towards(b, 1 << 62)), (a, b));
        assert_eq!(a.towards(b, 1 << 61).raw(), 999_999_997);
    }
}
