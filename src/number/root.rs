//! Roots: the square root by the processor's own instruction where `core` does not offer it, and a cheap
//! cube root.
//!
//! On Cortex-M4F and M7, `libm::sqrtf` is 52 instructions of integer arithmetic; VSQRT is one, and both
//! round correctly, so the bits agree. This is the only `unsafe` of the core: an instruction that
//! touches nothing but its two registers.

/// Square root of an `f32`, correctly rounded; NaN below zero.
#[inline]
pub fn sqrtf(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let root;
        // The class of single registers is refused on this target, so the value goes by a core register.
        // SAFETY: reads `x`, writes `root`, and uses s0, which is declared; no memory, no stack.
        #[allow(unsafe_code)]
        unsafe {
            core::arch::asm!(
                "vmov s0, {x}",
                "vsqrt.f32 s0, s0",
                "vmov {root}, s0",
                x = in(reg) x,
                root = lateout(reg) root,
                out("s0") _,
                options(pure, nomem, nostack)
            );
        }
        root
    }
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    libm::sqrtf(x)
}

/// Cube root for estimates, to 2e-4 from 1e-10 to 1e10 and 1e-3 from 1e-12 to 1e12: libm's costs some thousand instructions where f64 is software.
/// x^(1/4 + 1/16), and two steps of Halley's method for the rest of the exponent.
#[inline(never)]
pub fn cube_root<S: super::Scalar>(x: S) -> S {
    let quarter = x.sqrt().sqrt();
    let mut root = quarter * quarter.sqrt().sqrt();
    for _ in 0..2 {
        let cube = root * root * root;
        let less = cube + cube + x;
        if less > S::ZERO {
            root = root * ((cube + x + x) / less);
        }
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_roots_are_correctly_rounded() {
        for x in [0.0f32, 1.0, 2.0, 1.0e-30, 3.402_823e38, 0.1] {
            assert_eq!(sqrtf(x).to_bits(), x.sqrt().to_bits(), "{x}");
        }
        assert!(sqrtf(-1.0).is_nan());
    }

    #[test]
    fn cube_roots_are_as_good_as_is_said() {
        for k in -60i32..60 {
            let x = 10.0f64.powf(f64::from(k) * 0.2);
            let wanted = x.cbrt();
            let most = if k.abs() <= 50 { 2.0e-4 } else { 1.0e-3 };
            assert!((cube_root(x) / wanted - 1.0).abs() < most, "{x}");
            let single = f64::from(cube_root(x as f32));
            assert!((single / wanted - 1.0).abs() < most, "{x}");
        }
        assert!(cube_root(0.0f64) <= 0.0);
    }
}
