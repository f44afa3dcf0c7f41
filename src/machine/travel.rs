//! Travel limits: how far the axes may go.

use super::ConfigError;
use crate::number::{Coord, Range};

/// How far one axis may go, in the coordinates of blocks; an end that is `None` is open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisTravel {
    /// Least position.
    pub least: Option<Coord>,
    /// Greatest position.
    pub greatest: Option<Coord>,
}

/// The checked travel limits of all axes: [`Config::travel`](super::Config::travel). [`Travel::OPEN`] has none.
///
/// A block whose line, arc or curve leads out of them is refused when it is pushed
/// (`BlockError::Travel`), and nothing of it is taken. Which part counts:
///
/// - *Lines and ends* to the last unit of a [`Coord`].
/// - *Arcs, helices and cubic curves* by their true extents, not by those of their control points; what lies between
///   the ends to a nanometre, which is more than the rounding of a centre.
/// - *From outside* - a machine that stands there, or limits that have been changed - what leads no further out is taken: so it
///   comes back in.
///
/// What is programmed is inside, and the motion is at most its tolerance away: next to a limit the side of the band
/// that lies beyond it is not used. Corners between lines are then rounded on the inner side alone; of the other blocks
/// the tolerance counts as the distance to the limit, but not as less than `block::FINEST_BAND`. So the motion stays
/// inside to 0.0002 mm; where it rests or starts within a rounded corner, to a twenty-fifth of the tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Travel<const N: usize> {
    /// Least and greatest; of an open end, beyond every coordinate that is accepted.
    axes: [(Coord, Coord); N],
}

impl<const N: usize> Travel<N> {
    /// No limits.
    pub const OPEN: Self =
        Self { axes: [(Coord::from_raw(i64::MIN), Coord::from_raw(i64::MAX)); N] };

    /// The memory of some that are not known.
    pub(crate) const UNSET: Self = Self { axes: [(Coord::ZERO, Coord::ZERO); N] };

    /// Checks and keeps the limits.
    ///
    /// # Errors
    /// [`ConfigError::Travel`] names the first axis with a limit beyond +-[`Coord::LIMIT_MM`], or whose greatest position is less
    /// than its least.
    pub fn new(axes: [AxisTravel; N]) -> Result<Self, ConfigError> {
        let most = Coord::from_raw(Coord::LIMIT_MM as i64 * Coord::PER_MM);
        let mut travel = Self::OPEN;
        for (axis, (ends, wanted)) in travel.axes.iter_mut().zip(axes).enumerate() {
            let mut floor = Coord::from_raw(-most.raw());
            for (slot, coord) in [(&mut ends.0, wanted.least), (&mut ends.1, wanted.greatest)] {
                let Some(coord) = coord else { continue };
                if coord < floor || coord > most {
                    let range = Range::new(floor.to_mm(), most.to_mm());
                    let error = range.refused(coord.to_mm());
                    return Err(ConfigError::Travel { axis, error });
                }
                (*slot, floor) = (coord, coord);
            }
        }
        Ok(travel)
    }

    /// The limits of every axis.
    pub fn axes(&self) -> [AxisTravel; N] {
        self.axes.map(|(least, greatest)| AxisTravel {
            least: (least != Coord::from_raw(i64::MIN)).then_some(least),
            greatest: (greatest != Coord::from_raw(i64::MAX)).then_some(greatest),
        })
    }

    /// Least and greatest position of every axis; of an open end, beyond every coordinate that is accepted.
    pub(crate) fn ends(&self) -> &[(Coord, Coord); N] {
        &self.axes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mm(mm: f64) -> Coord {
        Coord::from_mm(mm).unwrap()
    }

    #[test]
    fn limits_that_are_none_are_named() {
        let ends = |least: f64, greatest: f64| {
            let raw = |mm: f64| Coord::from_raw((mm * 1.0e12) as i64);
            AxisTravel { least: Some(raw(least)), greatest: Some(raw(greatest)) }
        };
        for (axis, value) in [
            (ends(1.0, 0.9), 0.9),
            (ends(-2.0e6, 0.0), -2.0e6),
            (ends(0.0, 1.5e6), 1.5e6),
            (
                AxisTravel { greatest: Some(Coord::from_raw(i64::MAX)), ..AxisTravel::default() },
                9.2e6,
            ),
        ] {
            let error = Travel::new([ends(0.0, 1.0), axis]).unwrap_err();
            let ConfigError::Travel { axis: 1, error } = error else { panic!("{error}") };
            assert!((error.value - value).abs() < 0.1e6, "{error}");
        }
        // An axis that may not move at all.
        assert!(Travel::new([ends(7.0, 7.0)]).is_ok());
        assert_eq!(Travel::new([AxisTravel::default()]), Ok(Travel::OPEN));
        let axes = [AxisTravel { least: Some(mm(-10.0)), greatest: None }, ends(0.0, 3.0)];
        assert_eq!(Travel::new(axes).unwrap().axes(), axes);
    }
}
