//! Sine and cosine: the bits of `libm`, for arguments of an arc.
//!
//! `libm` takes any argument, and for the largest of them has a reduction that needs a kilobyte of stack and four of code. An
//! arc of 65,536 turns, the longest there is, ends below 2^20 quarter turns. The rest is that of FreeBSD's msun as `libm` has it
//! (s_sin.c, k_sin.c, k_cos.c, e_rem_pio2.c and their kin in single precision), of which this notice stands:
//!
//! Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved. Developed at SunPro, a Sun Microsystems, Inc. business.
//! Permission to use, copy, modify, and distribute this software is freely granted, provided that this notice is preserved.

// The constants are those of the sources, digit by digit; where ranges overlap, the first counts.
#![allow(clippy::excessive_precision, clippy::unreadable_literal, clippy::match_overlapping_arm)]

/// Greatest argument: 2^20 quarter turns.
const MOST: f64 = 1647099.0;
/// What makes a number an integer, and back.
const TO_INT: f64 = 1.5 / f64::EPSILON;
const QUARTERS: f64 = core::f64::consts::FRAC_2_PI;
/// A quarter turn: in parts of 33 bits each, and what is left.
const PARTS: [(f64, f64); 3] = [
    (1.57079632673412561417e+00, 6.07710050650619224932e-11),
    (6.07710050630396597660e-11, 2.02226624879595063154e-21),
    (2.02226624871116645580e-21, 8.47842766036889956997e-32),
];

/// Both, of their angle within a quarter turn about 0, turned by some quarter turns.
fn turned<T: core::ops::Neg<Output = T>>(quarters: f64, sin: T, cos: T) -> (T, T) {
    match quarters as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Nearest number of quarter turns.
fn nearest(x: f64) -> f64 {
    x * QUARTERS + TO_INT - TO_INT
}

/// Quarter turns in an argument, and the rest as a sum of two numbers.
fn reduced(x: f64) -> (f64, f64, f64) {
    let high = (x.abs().to_bits() >> 32) as u32;
    // Near a multiple the first part alone would not do.
    let quarters = match high {
        0x3ff921fb | 0x400921fb | 0x4012d97c | 0x401921fb => None,
        ..=0x4002d97c => Some(1.0),
        ..=0x400f6a7a => Some(2.0),
        ..=0x4015fdbc => Some(3.0),
        ..=0x401c463b => Some(4.0),
        _ => None,
    };
    let known = quarters.is_some();
    let quarters = quarters.map_or_else(|| nearest(x), |quarters: f64| quarters.copysign(x));
    let exponent = |x: f64| (x.to_bits() >> 52) as i32 & 0x7ff;
    let (mut rest, mut low) = (x, 0.0);
    for ((part, left), lost) in PARTS.into_iter().zip([16, 49, i32::MAX]) {
        let before = rest;
        let taken = quarters * part;
        rest = before - taken;
        low = quarters * left - ((before - rest) - taken);
        if known || exponent(x) - exponent(rest - low) <= lost {
            break;
        }
    }
    let near = rest - low;
    (quarters, near, (rest - near) - low)
}

/// Sine and cosine of `x`, rad, of at most 2^20 quarter turns; of a greater one, and of what is no number, NaN.
pub fn sin_cos(x: f64) -> (f64, f64) {
    const S: [f64; 6] = [
        -1.66666666666666324348e-01,
        8.33333333332248946124e-03,
        -1.98412698298579493134e-04,
        2.75573137070700676789e-06,
        -2.50507602534068634195e-08,
        1.58969099521155010221e-10,
    ];
    const C: [f64; 6] = [
        4.16666666666666019037e-02,
        -1.38888888888741095749e-03,
        2.48015872894767294178e-05,
        -2.75573143513906633035e-07,
        2.08757232129817482790e-09,
        -1.13596475577881948265e-11,
    ];
    if !(x.abs() < MOST) {
        return (f64::NAN, f64::NAN);
    }
    let high = (x.abs().to_bits() >> 32) as u32;
    if high < 0x3e46a09e {
        return (x, 1.0);
    }
    let whole = high > 0x3fe921fb;
    let (quarters, x, y) = if whole { reduced(x) } else { (0.0, x, 0.0) };
    let z = x * x;
    let w = z * z;
    let r = S[1] + z * (S[2] + z * S[3]) + z * w * (S[4] + z * S[5]);
    let v = z * x;
    let sin =
        if whole { x - ((z * (0.5 * y - v * r) - y) - v * S[0]) } else { x + v * (S[0] + z * r) };
    let r = z * (C[0] + z * (C[1] + z * C[2])) + w * w * (C[3] + z * (C[4] + z * C[5]));
    let half = 0.5 * z;
    let w = 1.0 - half;
    let cos = w + (((1.0 - w) - half) + (z * r - x * y));
    turned(quarters, sin, cos)
}

/// The same in single precision.
pub fn sin_cos_f32(x: f32) -> (f32, f32) {
    const S: [f64; 4] = [
        -0.166666666416265235595,
        0.0083333293858894631756,
        -0.000198393348360966317347,
        0.0000027183114939898219064,
    ];
    const C: [f64; 4] = [
        -0.499999997251031003120,
        0.0416666233237390631894,
        -0.00138867637746099294692,
        0.0000243904487962774090654,
    ];
    /// A quarter turn in 25 bits, and what is left.
    const PARTS: (f64, f64) = (1.57079631090164184570e+00, 1.58932547735281966916e-08);
    let exact = f64::from(x);
    if !(exact.abs() < MOST) {
        return (f32::NAN, f32::NAN);
    }
    let quarters = match x.abs().to_bits() {
        ..0x39800000 => return (x, 1.0),
        ..=0x3f490fda => Some(0.0),
        ..=0x4016cbe3 => Some(1.0),
        ..=0x407b53d1 => Some(2.0),
        ..=0x40afeddf => Some(3.0),
        ..=0x40e231d5 => Some(4.0),
        _ => None,
    };
    let (quarters, x) = if let Some(quarters) = quarters {
        let quarters = f64::copysign(quarters, exact);
        (quarters, exact - quarters * core::f64::consts::FRAC_PI_2)
    } else {
        let quarters = nearest(exact);
        (quarters, exact - quarters * PARTS.0 - quarters * PARTS.1)
    };
    let z = x * x;
    let w = z * z;
    let s = z * x;
    let sin = (x + s * (S[0] + z * S[1])) + s * w * (S[2] + z * S[3]);
    let cos = ((1.0 + z * C[0]) + w * C[1]) + (w * z) * (C[2] + z * C[3]);
    turned(quarters, sin as f32, cos as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::FRAC_PI_2;

    /// Bits, of both; a zero of either sign is one.
    fn same(x: f64) {
        let (ours, theirs) = (sin_cos(x), libm::sincos(x));
        assert_eq!(ours, theirs, "{x:e}");
        let (ours, theirs) = (sin_cos_f32(x as f32), libm::sincosf(x as f32));
        assert_eq!(ours, theirs, "{x:e} in f32");
    }

    #[test]
    fn the_bits_are_those_of_libm() {
        // Multiples of an eighth of a turn, and their neighbours; then numbers of all sizes.
        for k in -4000..=4000 {
            for off in [0.0, 1e-16, -1e-16, 1e-9, -1e-9, 1e-5, -1e-5, 1e-3, -1e-3, 0.1] {
                let x = f64::from(k) * 0.5 * FRAC_PI_2;
                same(x + off);
                same(x * (1.0 + off));
            }
        }
        let mut state = 1u64;
        for _ in 0..400_000 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let share = (state >> 11) as f64 / (1u64 << 53) as f64;
            for scale in [1.0e-9, 1.0, 8.0, 100.0, 411_774.0, 1.6e6] {
                same((share - 0.5) * 2.0 * scale);
            }
        }
        for bits in (0..0x49c8_0000_u32).step_by(4001) {
            same(f64::from(f32::from_bits(bits)));
            same(-f64::from(f32::from_bits(bits)));
        }
    }

    #[test]
    fn what_no_arc_asks_for_is_no_number() {
        for x in [f64::NAN, f64::INFINITY, -1.7e6, 1.0e30] {
            assert!(sin_cos(x).0.is_nan() && sin_cos_f32(x as f32).1.is_nan());
        }
    }
}
