//! The ranges of what a block gives.

use super::BlockError;
use crate::machine::Quantity;
use crate::number::{Coord, Scalar};

/// Whether a number of a block lies in its range.
pub fn in_range<S: Scalar>(quantity: Quantity, value: S) -> Result<(), BlockError> {
    quantity.check(value).map_err(|error| BlockError::OutOfRange { quantity, error })
}

/// Every coordinate of a point within [`Coord::LIMIT_MM`].
#[inline(never)]
pub fn check_coordinates<const N: usize>(point: &[Coord; N]) -> Result<(), BlockError> {
    point.iter().enumerate().try_for_each(|(axis, coord)| check_coordinate(axis, *coord))
}

/// A coordinate within [`Coord::LIMIT_MM`]; exactly, not as an `f64` is rounded.
pub fn check_coordinate(axis: usize, coord: Coord) -> Result<(), BlockError> {
    const LIMIT: i64 = Coord::LIMIT_MM as i64 * Coord::PER_MM;
    if coord.raw() > LIMIT || coord.raw() < -LIMIT {
        return Err(BlockError::Coordinate { axis, error: Coord::RANGE.refused(coord.to_mm()) });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_that_is_too_far_is_named() {
        let limit = Coord::from_mm(Coord::LIMIT_MM).unwrap();
        let beyond = Coord::from_raw(limit.raw() + 1);
        assert!(check_coordinates(&[limit, Coord::ZERO]).is_ok());
        assert!(matches!(
            check_coordinates(&[Coord::ZERO, beyond]),
            Err(BlockError::Coordinate { axis: 1, .. })
        ));
        assert!(check_coordinate(0, Coord::from_raw(-limit.raw() - 1)).is_err());
    }
}
