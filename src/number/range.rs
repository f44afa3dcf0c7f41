//! A number out of its range.

use core::fmt;

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
