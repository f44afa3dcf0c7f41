//! Messages of the core, which knows axes by their numbers, as a user knows them.

use crate::point::{AXES, LETTERS, is_rotary};
use anyhow::anyhow;
use std::fmt::Display;

/// All axes, as those of a controller are numbered.
pub const ALL: [usize; AXES] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

/// A message with the letters of `axes` in the place of their numbers. What is said of an axis that turns is in degrees.
pub fn lettered(message: &str, axes: &[usize]) -> String {
    const AXIS: &str = "axis ";
    let (mut text, mut rest, mut turns) = (String::new(), message, false);
    while let Some(at) = rest.find(AXIS) {
        let number = &rest[at + AXIS.len()..];
        let behind = number.trim_start_matches(|c: char| c.is_ascii_digit());
        let digits = &number[..number.len() - behind.len()];
        text.push_str(&rest[..at]);
        match digits.parse().ok().and_then(|index: usize| axes.get(index)) {
            Some(&axis) => {
                text.push(LETTERS[axis]);
                turns |= is_rotary(axis);
            }
            None => text.extend([AXIS, digits]),
        }
        rest = behind;
    }
    text.push_str(rest);
    if turns { text.replace(" mm", " deg") } else { text }
}

/// An error of the core in these words.
pub fn said(error: &impl Display, axes: &[usize]) -> anyhow::Error {
    anyhow!(lettered(&error.to_string(), axes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_letters() {
        for (message, text) in [
            ("axis 0 would go to 5 mm", "X would go to 5 mm"),
            ("velocity limit of axis 3 is 0 mm/s", "velocity limit of C is 0 deg/s"),
            ("axis 7 and axis 1, axis", "axis 7 and Y, axis"),
            ("no number at all", "no number at all"),
        ] {
            assert_eq!(lettered(message, &[0, 1, 2, 5]), text);
        }
    }
}
