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

    /// The distance of two points: a root in `S`, and half of what its square misses those of the steps by, over it. That is
    /// exact, so the distance is right to the unit up to some centimetres, and to 1e-13 of itself beyond, in `f32` too. (`f64` would
    /// take five times as long on the target.)
    pub fn between<S: Scalar, const N: usize>(from: &[Coord; N], to: &[Coord; N]) -> Self {
        let (mut squares, mut missed) = (S::ZERO, 0);
        for (from, to) in from.iter().zip(to) {
            let step: S = to.minus(*from);
            squares += step * step;
            missed += square(to.raw().wrapping_sub(from.raw()));
        }
        let root = squares.sqrt().to_units();
        if root == 0 {
            return Self::ZERO;
        }
        missed -= square(root);
        let twice = S::from_i64(root) + S::from_i64(root);
        let half = S::of(if missed < 0 { -0.5 } else { 0.5 });
        Self(root.saturating_add((from_wide::<S>(missed) / twice + half).to_i64()))
    }

    /// In units of 1e-12 mm.
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
    #[inline(never)]
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

/// The square of an integer. (By halves: a product of wide integers is a call on the target.)
const fn square(x: i64) -> i128 {
    let x = x.unsigned_abs();
    let (high, low) = (x >> 32, x & 0xffff_ffff);
    ((high * high) as i128) * (1 << 64) + ((high * low) as i128) * (1 << 33) + (low * low) as i128
}

/// The value next to a wide integer.
fn from_wide<S: Scalar>(x: i128) -> S {
    let size = x.unsigned_abs();
    let (high, low) = ((size >> 64) as u64, size as u64);
    let half = S::of(9_223_372_036_854_775_808.0);
    // Of the lower half the last bit does not count.
    let (high, low) = (S::from_i64(high.cast_signed()), S::from_i64((low >> 1).cast_signed()));
    let size = (high * half + low) * S::of(2.0);
    if x < 0 { -size } else { size }
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

    /// Against the root of wide integers, in both scalars.
    #[test]
    fn distances_are_exact() {
        let root = |square: u128| {
            // The greatest whole number of which the square is no greater.
            let (mut low, mut high) = (0, u128::from(u64::MAX));
            while low < high {
                let middle = (low + high).div_ceil(2);
                if middle * middle <= square { low = middle } else { high = middle - 1 }
            }
            low
        };
        let mut seed = 1u64;
        let mut random = |bits: u32| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            seed.cast_signed() >> (64 - bits)
        };
        for bits in 1..=61 {
            for _ in 0..200 {
                let [from, to] = [0; 2].map(|_| [0; 3].map(|_| Coord::from_raw(random(bits))));
                let squares = (0..3).map(|i| {
                    let step = i128::from(to[i].raw()) - i128::from(from[i].raw());
                    (step * step).unsigned_abs()
                });
                let wanted = root(squares.sum()) as i64;
                let most = 1 + ((1 << bits) >> 43);
                for found in
                    [Length::between::<f32, 3>(&from, &to), Length::between::<f64, 3>(&from, &to)]
                {
                    assert!((found.0 - wanted).abs() <= most, "{bits}: {found:?} {wanted}");
                }
            }
        }
        assert_eq!(Length::between::<f32, 3>(&[Coord::ZERO; 3], &[Coord::ZERO; 3]), Length::ZERO);
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
