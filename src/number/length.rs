//! Lengths along the path.

use super::{Coord, Scalar};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// An arc length, or a difference of two, in fixed point: a whole number of 1e-12 mm, as [`Coord`]inates are.
///
/// Knots, cuts and marks are counted in it, so that lengths add up exactly in `f32` builds too. It holds 9.2e6 mm;
/// the longest block is shorter, and a run forgets what lies behind it (`path::segment`, `path::run`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Length(i64);

impl Length {
    /// Zero.
    pub const ZERO: Self = Self(0);
    /// The least length there is.
    pub const UNIT: Self = Self(1);
    /// Units in a millimetre.
    pub const PER_MM: i64 = Coord::PER_MM;

    /// From units of 1e-12 mm.
    pub const fn from_raw(raw: i64) -> Self {
        Self(raw)
    }

    /// From mm, rounded towards zero; what is beyond the range becomes its end, NaN zero.
    #[inline]
    pub fn from_mm<S: Scalar>(mm: S) -> Self {
        Self(mm.to_units())
    }

    /// From mm, rounded to the nearest.
    pub fn nearest_mm(mm: f64) -> Self {
        Self(libm::round(mm * 1.0e12) as i64)
    }

    /// In units of 1e-12 mm.
    #[cfg(feature = "outputs")]
    pub const fn raw(self) -> i64 {
        self.0
    }

    /// In mm.
    #[inline]
    pub fn to_mm<S: Scalar>(self) -> S {
        S::from_i64(self.0) * S::of(1.0e-12)
    }

    /// Its magnitude.
    #[must_use]
    pub const fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The length half way between two, rounded towards zero.
    #[must_use]
    pub const fn midpoint(self, other: Self) -> Self {
        Self(self.0.midpoint(other.0))
    }

    /// The mean of three lengths, of which `a` is the least, rounded towards zero. (Not by a division of wide
    /// integers, which is a loop on the target: a spline takes one for every control point.)
    #[must_use]
    pub const fn mean(a: Self, b: Self, c: Self) -> Self {
        let more = (b.0 - a.0) + (c.0 - a.0);
        let floor = a.0 + more / 3;
        Self(if floor < 0 && more % 3 != 0 { floor + 1 } else { floor })
    }

    /// The share that it is of a whole, in units of 1 / 2^62: 0 to 2^62 for lengths from 0 up to the whole. (Bit by bit: a
    /// division of wide integers takes twenty times as long on the target.)
    pub const fn share_of(self, whole: Self) -> i64 {
        debug_assert!(self.0 >= 0 && self.0 <= whole.0);
        let whole = if whole.0 > 0 { whole.0 as u64 } else { 1 };
        let (mut rest, mut share) = (self.0 as u64, 0);
        if rest >= whole {
            return 1 << 62;
        }
        let mut bits = 62;
        while bits > 0 {
            rest <<= 1;
            share <<= 1;
            if rest >= whole {
                rest -= whole;
                share |= 1;
            }
            bits -= 1;
        }
        share
    }
}

/// What lies between two arc lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// Where it begins.
    pub from: Length,
    /// Where it ends.
    pub to: Length,
}

impl Add for Length {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Length {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Neg for Length {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl AddAssign for Length {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Length {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Mul<i64> for Length {
    type Output = Self;
    #[inline]
    fn mul(self, times: i64) -> Self {
        Self(self.0 * times)
    }
}

/// Rounded towards zero. For divisors that are constants: with others it might panic.
impl Div<i64> for Length {
    type Output = Self;
    #[inline]
    fn div(self, parts: i64) -> Self {
        Self(self.0 / parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_add_up_exactly_and_are_rounded_towards_zero() {
        let step = Length::from_mm(0.1f64);
        assert_eq!(step.0, 100_000_000_000);
        let sum = (0..10).fold(Length::ZERO, |sum, _| sum + step);
        assert_eq!(sum, Length::from_raw(Length::PER_MM));
        assert!((sum.to_mm::<f32>() - 1.0).abs() < f32::EPSILON);
        assert_eq!(Length::from_mm(1.9e-12), Length::UNIT);
        assert_eq!(Length::from_mm(-1.9e-12), -Length::UNIT);
        assert_eq!(Length::from_raw(-7) / 2, Length::from_raw(-3));
        assert_eq!(Length::from_mm(f64::NAN), Length::ZERO);
        assert_eq!(Length::from_mm(1.0e300).0, i64::MAX);
    }

    #[test]
    fn shares_are_those_of_the_whole() {
        let whole = Length::from_mm(7.0e6f64);
        assert_eq!(Length::ZERO.share_of(whole), 0);
        assert_eq!(whole.share_of(whole), 1 << 62);
        assert_eq!((whole / 2).share_of(whole), 1 << 61);
        // Of nothing: no division by zero.
        assert_eq!(Length::ZERO.share_of(Length::ZERO), 0);
        for (part, whole) in [(1, 3), (2, 3), (1, i64::MAX), (i64::MAX - 1, i64::MAX), (7, 1 << 40)]
        {
            let wide = (i128::from(part) << 62) / i128::from(whole);
            assert_eq!(i128::from(Length(part).share_of(Length(whole))), wide, "{part} {whole}");
        }
        assert_eq!(Length::from_raw(3).midpoint(Length::from_raw(6)), Length::from_raw(4));
    }

    #[test]
    fn the_mean_of_three_is_that_of_their_sum() {
        let wide =
            |a: i64, b: i64, c: i64| ((i128::from(a) + i128::from(b) + i128::from(c)) / 3) as i64;
        let far = 2_000_000_000_000_000_000;
        for a in [-far, -7, -6, -5, -1, 0, 1, 2, 3, 1_000_003, far] {
            for b in [0, 1, 2, 3, 4, 5, 999_999_999_937, far] {
                for c in [0, 1, 2, 3, 5, 7, 1_000_000_000_039] {
                    let [first, second, third] = [a, a + b, a + b + c];
                    let mean = Length::mean(Length(first), Length(second), Length(third));
                    assert_eq!(mean.0, wide(first, second, third), "{a} {b} {c}");
                }
            }
        }
    }
}
