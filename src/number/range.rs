//! Ranges, and a number out of its range.

use super::Scalar;
use core::fmt;

/// The numbers accepted of something: both ends, and all between.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range {
    /// Least value accepted.
    pub least: f64,
    /// Greatest value accepted.
    pub greatest: f64,
}

impl Range {
    /// From least to greatest.
    pub const fn new(least: f64, greatest: f64) -> Self {
        Self { least, greatest }
    }

    /// Whether a number lies in the range, whose ends are those of its type; NaN does not.
    pub fn contains<S: Scalar>(self, value: S) -> bool {
        value >= S::of(self.least) && value <= S::of(self.greatest)
    }

    /// Whether a number lies in the range, or what is wrong with it.
    ///
    /// # Errors
    /// [`RangeError`] if it is not finite or not within the range.
    pub fn check<S: Scalar>(self, value: S) -> Result<(), RangeError> {
        if self.contains(value) { Ok(()) } else { Err(self.refused(value.to_f64())) }
    }

    /// What is said of a value that is not accepted.
    pub const fn refused(self, value: f64) -> RangeError {
        RangeError { value, least: self.least, greatest: self.greatest }
    }
}

/// A number that is not finite or not within a range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RangeError {
    /// The value given.
    pub value: f64,
    /// Least value accepted.
    pub least: f64,
    /// Greatest value accepted.
    pub greatest: f64,
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is out of range; it must be {} to {}", self.value, self.least, self.greatest)
    }
}

impl core::error::Error for RangeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_are_accepted_and_nothing_beyond() {
        let range = Range::new(0.1, 1.0e3);
        for value in [0.1f32, 1.0, 1.0e3] {
            assert!(range.contains(value) && range.check(f64::from(value)).is_ok());
        }
        for value in [0.0999, 1000.1, f64::INFINITY, -f64::INFINITY, -1.0] {
            assert!(!range.contains(value), "{value}");
            assert_eq!(range.check(value), Err(RangeError { value, least: 0.1, greatest: 1.0e3 }));
        }
        assert!(!range.contains(f32::NAN));
        let text = std::format!("{}", range.check(2.0e3).unwrap_err());
        assert_eq!(text, "2000 is out of range; it must be 0.1 to 1000");
    }
}
