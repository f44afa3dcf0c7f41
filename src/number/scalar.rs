//! The scalar the core computes with.

use super::atomic::AtomicU32;
use super::root::sqrtf;
use super::shared::Shared;
use super::trig;
use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point number type the core can run in: `f32` (Cortex-M4F) or `f64` (Cortex-M7 and
/// checking on a PC).
///
/// Only operations that give the same bits on every target are offered: the four basic ones,
/// square root, and `libm` functions. There is no fused multiply-add on purpose.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + PartialOrd
    + Debug
    + Default
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Rounding error of one operation, relative.
    const EPSILON: Self;
    /// Storage for handing a value from one context to another; not for users of the core.
    #[doc(hidden)]
    #[allow(private_bounds)]
    type Shared: Shared<Self>;
    /// Name of the type, for reports.
    const NAME: &'static str;

    /// The nearest value to a constant.
    fn of(x: f64) -> Self;
    /// This value as `f64`, exact.
    fn to_f64(self) -> f64;
    /// A small count.
    fn from_u32(x: u32) -> Self;
    /// The nearest value to an integer.
    fn from_i64(x: i64) -> Self;
    /// Truncated to an integer; saturates, NaN gives 0.
    fn to_i64(self) -> i64;
    /// Units of 1e-12 in it, truncated; saturates, NaN gives 0. Exact in `f32`.
    fn to_units(self) -> i64;
    /// Square root; NaN below zero.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Cube root.
    #[must_use]
    fn cbrt(self) -> Self;
    /// Natural logarithm.
    #[must_use]
    fn ln(self) -> Self;
    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);
    /// Whether the value is neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// Magnitude.
    #[must_use]
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }

    /// The lesser of two numbers, by comparison, so that the bits agree on every target.
    #[must_use]
    fn least(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The greater of two numbers, by comparison, so that the bits agree on every target.
    #[must_use]
    fn greatest(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

macro_rules! scalar {
    ($t:ident, $shared:ty, $sqrt:path, $cbrt:path, $ln:path, $sincos:path, $nearest:expr, $truncated:expr, $units:expr) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $t::EPSILON;
            type Shared = $shared;
            const NAME: &'static str = stringify!($t);
            #[inline]
            fn of(x: f64) -> Self {
                x as Self
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            #[allow(clippy::cast_lossless)] // lossy for f32
            fn from_u32(x: u32) -> Self {
                x as Self
            }
            #[inline]
            fn from_i64(x: i64) -> Self {
                $nearest(x)
            }
            #[inline]
            fn to_i64(self) -> i64 {
                $truncated(self)
            }
            #[inline]
            fn to_units(self) -> i64 {
                $units(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline]
            fn cbrt(self) -> Self {
                $cbrt(self)
            }
            #[inline]
            fn ln(self) -> Self {
                $ln(self)
            }
            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
        }
    };
}

/// Where the processor has instructions for them, those are less.
mod conversions {
    #[cfg(target_arch = "arm")]
    pub(super) use super::super::wide::{nearest, truncated};

    #[cfg(not(target_arch = "arm"))]
    pub(super) fn nearest(x: i64) -> f32 {
        x as f32
    }
    #[cfg(not(target_arch = "arm"))]
    pub(super) fn truncated(x: f32) -> i64 {
        x as i64
    }
}

/// `libm`'s is made to be inlined.
#[inline(never)]
fn logarithm(x: f32) -> f32 {
    libm::logf(x)
}

scalar!(
    f32,
    AtomicU32,
    sqrtf,
    libm::cbrtf,
    logarithm,
    trig::sin_cos_f32,
    conversions::nearest,
    conversions::truncated,
    super::wide::units
);
scalar!(
    f64,
    [AtomicU32; 2],
    libm::sqrt,
    libm::cbrt,
    libm::log,
    trig::sin_cos,
    |x: i64| x as f64,
    whole,
    |x: f64| whole(x * 1.0e12)
);

/// Without its fraction. (On the target that takes 60 instructions.)
#[inline(never)]
fn whole(x: f64) -> i64 {
    x as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn comparisons<S: Scalar>() {
        let (one, two, nan) = (S::ONE, S::of(2.0), S::of(f64::NAN));
        assert!(one.least(two) == one && two.least(one) == one);
        assert!(one.greatest(two) == two && two.greatest(one) == two);
        // What is no number loses as an argument, and stays where it was: the same on every target.
        assert!(one.least(nan) == one && one.greatest(nan) == one);
        assert!(!nan.least(one).is_finite() && !nan.greatest(one).is_finite());
        assert!((-two).abs() == two && S::ZERO.abs() == S::ZERO);
    }

    fn conversions<S: Scalar>() {
        assert_eq!(S::of(2.9).to_i64(), 2);
        assert_eq!(S::of(-2.9).to_i64(), -2);
        assert_eq!(S::of(1.0e30).to_i64(), i64::MAX);
        assert_eq!(S::of(f64::NAN).to_i64(), 0);
        assert!(S::from_u32(7) == S::from_i64(7) && S::from_u32(7) == S::of(7.0));
        let (sin, cos) = S::of(0.3).sin_cos();
        assert!((sin * sin + cos * cos - S::ONE).abs() <= S::EPSILON + S::EPSILON);
    }

    #[test]
    fn both_scalars_compare_and_convert_alike() {
        comparisons::<f32>();
        comparisons::<f64>();
        conversions::<f32>();
        conversions::<f64>();
        assert_eq!((f32::NAME, f64::NAME), ("f32", "f64"));
    }
}
