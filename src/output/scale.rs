//! Steps per millimetre.

use crate::number::Coord;
use core::fmt;

/// Steps per length, exactly: `steps` per `nm` nanometres (1e-6 degrees).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scale {
    /// Steps per raw unit times 2^`shift`, 2^62 to 2^63.
    factor: i64,
    shift: u32,
}

/// A scale that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScaleError {
    /// Steps given.
    pub steps: u32,
    /// Length given, nm.
    pub nm: u32,
}

impl fmt::Display for ScaleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} steps per {} nm are no scale: both must be above 0", self.steps, self.nm)
    }
}

impl core::error::Error for ScaleError {}

impl Scale {
    /// `steps` steps per `nm` nanometres: 400 steps/mm are (400, 1_000_000); a motor of 200 steps in 16
    /// microsteps on a screw of 5 mm is (3200, 5_000_000).
    ///
    /// # Errors
    /// [`ScaleError`] if either is 0.
    pub const fn new(steps: u32, nm: u32) -> Result<Self, ScaleError> {
        if steps == 0 || nm == 0 {
            return Err(ScaleError { steps, nm });
        }
        let raw = nm as u128 * (Coord::PER_MM as u128 / 1_000_000);
        // steps / raw lies between 2^-52 and 2^12: with this shift, taken in two parts for the width of the
        // numbers, the factor has 63 bits at least.
        let mut shift = 115;
        let wide = (steps as u128) << 80;
        let mut factor = ((wide / raw) << 35) + ((wide % raw) << 35) / raw;
        while factor >= 1 << 63 {
            factor >>= 1;
            shift -= 1;
        }
        debug_assert!(factor >= 1 << 62 && shift > 0 && shift < 128);
        Ok(Self { factor: factor as i64, shift })
    }

    /// A place in steps, rounded to the nearest.
    ///
    /// Cost: one multiplication of 64-bit numbers, no division.
    pub const fn steps(self, at: Coord) -> i64 {
        let wide = at.raw() as i128 * self.factor as i128;
        (((wide >> (self.shift - 1)) + 1) >> 1) as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(nm: i64) -> Coord {
        Coord::from_nm(nm).unwrap()
    }

    #[test]
    fn places_are_rounded_to_the_nearest_step_either_side_of_zero() {
        let scale = Scale::new(400, 1_000_000).unwrap(); // A step is 2,500 nm.
        for (nm, steps) in
            [(0, 0), (1_249, 0), (1_251, 1), (-1_249, 0), (-1_251, -1), (2_500, 1), (-10_000, -4)]
        {
            assert_eq!(scale.steps(at(nm)), steps, "{nm}");
        }
    }

    /// Against whole numbers, at every size of scale and to the ends of the range.
    #[test]
    fn no_scale_is_off_by_more_than_its_rounding() {
        let largest = 1_000_000_000_000;
        for (steps, nm) in [(1, 1), (3, 7), (3200, 5_000_000), (1, u32::MAX), (1_000_003, 999_983)]
        {
            let scale = Scale::new(steps, nm).unwrap();
            for place in [0, 1, 12_345_678, largest - 1, largest] {
                for place in [place, -place] {
                    let exact = i128::from(place) * i128::from(steps);
                    let off = i128::from(scale.steps(at(place))) * i128::from(nm) - exact;
                    // Half a step, and at 2^62 units one part in it.
                    assert!(2 * off.abs() <= i128::from(nm) + 2, "{steps}/{nm} {place}: {off}");
                }
            }
        }
    }

    #[test]
    fn nothing_per_something_is_no_scale() {
        assert_eq!(Scale::new(0, 5), Err(ScaleError { steps: 0, nm: 5 }));
        assert_eq!(Scale::new(5, 0), Err(ScaleError { steps: 5, nm: 0 }));
    }
}
