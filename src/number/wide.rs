//! Conversions between `f32` and wide integers in few instructions where the processor has none for them.
//!
//! Path coordinates and lengths are 64-bit integers, and on a Cortex-M every use of one in `f32` is a conversion: the
//! compiler's own functions take some fifty instructions for each, these some twenty-five. The bits are the same.

use core::num::NonZeroU32;

/// Bits of an `f32` below its leading one.
const FRACTION: u32 = 23;
/// The bit of the sign.
const SIGN: u32 = 1 << 31;
/// Exponent of one.
const ONE: u32 = 127;

/// The `f32` nearest to an integer, as `as` has it.
#[cfg_attr(not(target_arch = "arm"), allow(dead_code))]
#[inline(never)]
pub fn nearest(x: i64) -> f32 {
    let size = x.unsigned_abs();
    let (high, low) = ((size >> 32) as u32, size as u32);
    // The upper 32 bits from the leading one on. What is cut off only says on which side of a middle it is. By words: a
    // shift of a wide integer is twice as long.
    let (word, power) = match NonZeroU32::new(high) {
        None => (low, 0),
        Some(high) => {
            let zeros = high.leading_zeros();
            let top = high.get() << zeros | low >> 1 >> (31 - zeros);
            (top | u32::from(low << zeros != 0), 32 - zeros)
        }
    };
    // Rounded once, by the processor; a power of two is exact, and brings the sign.
    let sign = (x >> 32) as u32 & SIGN;
    word as f32 * f32::from_bits(sign | (ONE + power) << FRACTION)
}

/// An `f32` without its fraction, as `as` has it: saturated; NaN gives 0.
#[cfg_attr(not(target_arch = "arm"), allow(dead_code))]
#[inline(never)]
pub fn truncated(x: f32) -> i64 {
    scaled::<1, 0>(x)
}

/// 5^12, of which and 2^12 the 1e12 units of 1e-12 in one are made.
const FIVES: u64 = 244_140_625;

/// Whole units of 1e-12 in an `f32`, rounded towards zero: exact, where a product in `f32` is off by up to 6e-8 of
/// itself (a tenth of a nanometre over 3 mm). Saturated; NaN gives 0.
#[inline(never)]
pub fn units(x: f32) -> i64 {
    scaled::<FIVES, 12>(x)
}

/// `FACTOR` 2^`POWER` times an `f32`, rounded once, towards zero. Saturated; NaN gives 0. Of the 64 bits `FACTOR` has 40 at most.
#[inline]
fn scaled<const FACTOR: u64, const POWER: u32>(x: f32) -> i64 {
    let bits = x.to_bits();
    let exponent = bits >> FRACTION & 0xff;
    let word = u64::from(bits & ((1 << FRACTION) - 1) | 1 << FRACTION);
    let product = word * FACTOR;
    // Numbers so small that they have no leading one are shifted out.
    let size = match (exponent + POWER).checked_sub(ONE + FRACTION) {
        None => product.checked_shr(ONE + FRACTION - POWER - exponent).unwrap_or(0),
        Some(up) if up < product.leading_zeros() => product << up,
        Some(_) if x.is_nan() => 0,
        Some(_) if x < 0.0 => return i64::MIN,
        Some(_) => return i64::MAX,
    };
    let size = size.cast_signed();
    if x < 0.0 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of all sizes, with bits at both ends, and about the middles between two `f32`.
    fn numbers() -> impl Iterator<Item = i64> {
        let mut seed = 1u64;
        let random = (0..200_000u32).map(move |k| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed.cast_signed() >> (k % 64)) ^ i64::from(k % 3)
        });
        let edges = (0..63).flat_map(|k| [-1i64, 0, 1].map(|d| (1i64 << k) + d));
        let middles = (24..62).flat_map(|k| {
            let middle = (1i64 << k) + (1i64 << (k - 24));
            [-1, 0, 1].map(|d| middle + d)
        });
        let some = [0, i64::MAX, i64::MIN, i64::MAX - 1, i64::MIN + 1];
        some.into_iter().chain(edges).chain(middles).chain(random)
    }

    #[test]
    fn integers_are_converted_as_the_language_does() {
        for x in numbers().flat_map(|x| [x, x.wrapping_neg()]) {
            assert_eq!(nearest(x).to_bits(), (x as f32).to_bits(), "{x}");
        }
    }

    #[test]
    fn fractions_are_cut_off_as_the_language_does() {
        let floats = numbers().map(|x| f32::from_bits(x as u32));
        let wide = numbers().map(|x| x as f32);
        let some = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.999_999_9, -0.0, 9.223_372e18];
        for x in floats.chain(wide).chain(some).flat_map(|x| [x, -x]) {
            assert_eq!(truncated(x), x as i64, "{x}");
        }
    }

    #[test]
    fn units_are_exact() {
        let floats = numbers().map(|x| f32::from_bits(x as u32));
        let wide = numbers().map(|x| x as f32 * 1.0e-12);
        let some = [f32::NAN, f32::INFINITY, 0.0, 1.0e-12, 9.0e-13, 9_223_372.0, 9_223_373.0];
        for x in floats.chain(wide).chain(some).flat_map(|x| [x, -x]) {
            // 24 bits and 28: within the 53 of an `f64`.
            assert_eq!(units(x), (f64::from(x) * 1.0e12) as i64, "{x}");
        }
    }
}
