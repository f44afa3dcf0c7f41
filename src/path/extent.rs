//! How far a block reaches on every axis, and whether that is inside the limits of travel.

use super::segment::Segment;
use crate::block::{BlockError, FINEST_BAND};
use crate::machine::Travel;
use crate::number::{Coord, Range, Scalar};

/// By how much what lies between the ends of a curve may be further out than a limit, mm: the nanometre of the
/// finest input, which is more than the rounding of a centre.
const ROUNDING: f64 = 1.0e-6;

/// The least and the greatest coordinates of a part of the path.
#[derive(Clone, Copy, Debug)]
pub struct Extent<const N: usize> {
    /// Of the ends alone.
    ends: [(Coord, Coord); N],
    /// Of all of it.
    axes: [(Coord, Coord); N],
}

impl<const N: usize> Extent<N> {
    /// Of a straight line, or of the ends of a curve.
    pub fn between(from: &[Coord; N], to: &[Coord; N]) -> Self {
        let ends = core::array::from_fn(|i| (from[i].min(to[i]), from[i].max(to[i])));
        Self { ends, axes: ends }
    }

    /// Of a line or arc.
    pub fn of_segment<S: Scalar>(segment: &Segment<S, N>) -> Self {
        let mut extent = Self::between(&segment.start, &segment.end);
        if let Some(helix) = segment.helix() {
            helix.reaches(|axis, at| extent.reach(axis, at));
        }
        extent
    }

    /// Reaches out to a place of a curve on one axis.
    pub fn reach(&mut self, axis: usize, at: Coord) {
        if let Some((least, greatest)) = self.axes.get_mut(axis) {
            (*least, *greatest) = ((*least).min(at), (*greatest).max(at));
        }
    }

    /// What is left of a tolerance, mm, to a motion from `from` of this extent: the distance from the limits, but
    /// [`FINEST_BAND`] at least.
    ///
    /// Cost: four comparisons per axis.
    ///
    /// # Errors
    /// [`BlockError::Travel`] if it leads out of the limits; from outside, if it leads further out.
    pub fn within<S: Scalar>(
        &self,
        travel: &Travel<N>,
        from: &[Coord; N],
        tolerance: S,
    ) -> Result<S, BlockError> {
        let mut room = i64::MAX;
        let axes = self.axes.iter().zip(&self.ends).zip(travel.ends()).zip(from).enumerate();
        for (axis, (((reached, ends), limits), from)) in axes {
            let (least, greatest) = (limits.0.min(*from), limits.1.max(*from));
            let below = ends.0 < least || reached.0.plus(ROUNDING) < least;
            if below || ends.1 > greatest || reached.1.plus(-ROUNDING) > greatest {
                let beyond = if below { reached.0 } else { reached.1 };
                let end = |coord: Coord| coord.to_mm().clamp(-Coord::LIMIT_MM, Coord::LIMIT_MM);
                let error = Range::new(end(limits.0), end(limits.1)).refused(beyond.to_mm());
                return Err(BlockError::Travel { axis, error });
            }
            let below = reached.0.raw().saturating_sub(least.raw());
            let above = greatest.raw().saturating_sub(reached.1.raw());
            room = room.min(below).min(above);
        }
        let room = S::of(Coord::from_raw(room).to_mm().max(FINEST_BAND));
        Ok(tolerance.least(room))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::Turn;
    use crate::machine::AxisTravel;

    fn mm(mm: f64) -> Coord {
        Coord::from_mm(mm).unwrap()
    }

    /// X from -10 to 300, Y up to 0.
    fn travel() -> Travel<2> {
        let ends = |least, greatest| AxisTravel { least, greatest };
        Travel::new([ends(Some(mm(-10.0)), Some(mm(300.0))), ends(None, Some(mm(0.0)))]).unwrap()
    }

    fn room(from: [Coord; 2], to: [Coord; 2]) -> Result<f64, BlockError> {
        Extent::between(&from, &to).within(&travel(), &from, 1.0e3)
    }

    #[test]
    fn the_ends_are_inside_and_a_unit_beyond_is_not() {
        let from = [mm(0.0), mm(-5.0)];
        assert_eq!(room(from, [mm(300.0), mm(-5.0)]), Ok(FINEST_BAND));
        assert_eq!(room(from, [mm(297.0), mm(-1.0e6)]), Ok(3.0));
        assert_eq!(room(from, [mm(100.0), mm(-0.5)]), Ok(0.5));
        let beyond = Coord::from_raw(mm(300.0).raw() + 1);
        let Err(BlockError::Travel { axis: 0, error }) = room(from, [beyond, mm(0.0)]) else {
            panic!("it is taken")
        };
        assert_eq!((error.least, error.greatest), (-10.0, 300.0));
        assert!(matches!(room(from, [mm(1.0), mm(0.1)]), Err(BlockError::Travel { axis: 1, .. })));
        assert!(room(from, [mm(-10.1), mm(-5.0)]).is_err());
        let far = [mm(1.0e6), mm(-1.0e6)];
        let open = Extent::between(&from, &far).within(&Travel::OPEN, &from, 1.0e3);
        assert_eq!(open, Ok(1.0e3));
    }

    #[test]
    fn from_outside_what_leads_no_further_out_is_taken() {
        let from = [mm(310.0), mm(-5.0)];
        let room = |x: f64, y: f64| room(from, [mm(x), mm(y)]);
        assert_eq!(room(305.0, -5.0), Ok(FINEST_BAND));
        assert_eq!(room(0.0, -7.0), Ok(FINEST_BAND));
        assert!(room(310.001, -5.0).is_err() && room(300.0, 1.0).is_err());
        assert!(room(-11.0, -5.0).is_err());
    }

    /// Arcs, spirals and full turns against a dense evaluation: a quarter counts only if the arc gets there.
    #[test]
    fn an_arc_reaches_as_far_as_its_points() {
        let mut state = 7u64;
        let mut draw = |most: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64 * most
        };
        let mut between = 0;
        for round in 0..1_000 {
            let (radius, angle) = (0.003 + draw(20.0), draw(7.0) - 3.5);
            let far = if round % 7 == 0 { 9.0e5 } else { 0.0 };
            let centre = (mm(far + draw(5.0)), mm(draw(5.0)));
            let place = |radius: f64, angle: f64| {
                [centre.0.plus(radius * angle.cos()), centre.1.plus(radius * angle.sin())]
            };
            let start = place(radius, angle);
            // The end at another radius, by as much as is taken.
            let grown = radius + (draw(2.0) - 1.0) * f64::max(0.005, radius * 1.0e-3) * 0.99;
            let swept = if round % 3 == 0 { draw(0.3) } else { draw(6.2) } + 0.02;
            let end = match round % 5 {
                0 => start,
                _ => place(grown, angle + if round % 2 == 0 { swept } else { -swept }),
            };
            let turn = if round % 2 == 0 { Turn::CounterClockwise } else { Turn::Clockwise };
            let turns = if round % 4 == 0 { 2 } else { 0 };
            let arc = Segment::<f64, 2>::arc(start, end, (0, 1), centre, turn, turns);
            let Ok(segment) = arc else { continue };
            let extent = Extent::of_segment(&segment);
            let mut dense = Extent::between(&start, &end);
            let steps = 4_000;
            for k in 0..=steps {
                let s = crate::number::Length::nearest_mm(
                    segment.exact_length.to_mm::<f64>() * f64::from(k) / f64::from(steps),
                );
                for (axis, at) in segment.node(s).at.into_iter().enumerate() {
                    dense.reach(axis, at);
                }
            }
            // Between two samples an arc rises by its sagitta at most.
            let step = segment.length / f64::from(steps);
            let slack = 1.0e-9 + if far > 0.0 { 1.0e-9 } else { 0.0 } + step * step / radius;
            for (own, seen) in extent.axes.iter().zip(dense.axes) {
                for (own, seen) in [(own.1, seen.1), (seen.0, own.0)] {
                    let more: f64 = own.minus(seen);
                    assert!(more > -1.0e-9 && more < slack, "{round}: {more} {segment:?}");
                }
                between += u32::from(own.1 > start[0].max(end[0]));
            }
        }
        assert!(between > 300, "{between}");
    }
}
