//! Steps per millimetre.

use crate::number::Coord;
use core::fmt;

/// How many steps make how much way, exactly: `steps` per `nm` nanometres (1e-6 degrees).
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
    /// Way given, nm.
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
