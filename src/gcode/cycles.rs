//! Canned cycles: G73, G81, G82, G83.
//!
//! As in LinuxCNC: over the hole by a rapid (first up to R, where the tool is lower), down to R, to the bottom at the
//! feed, and back to R (G99), or to the level the cycles began on (G98, where that is higher). Every move ends in an exact stop, as corners
//! that are rounded would begin to drill beside the hole.

use super::drilling::{DrillStage, Drilling, Series, Spacing};
use super::error::{Reason, Refusal};
use super::groups::Found;
use super::modal::Cycle;
use super::offsets::{Place, difference, sum};
use super::reader::Reader;
use super::words::{LONGEST_DWELL, Words};
use super::{AXES, LETTERS};
use crate::number::Coord;

/// Most pecks of a hole.
const PECKS: f64 = 10_000.0;
/// Most repetitions.
const TIMES: f64 = 9999.0;

fn at(place: &Place, axis: usize) -> Coord {
    place.get(axis).copied().unwrap_or_default()
}

fn missing((code, column): Found, what: &'static str) -> Refusal {
    Refusal::new(column, Reason::Missing { code, what })
}

fn context((code, column): Found, what: &'static str) -> Refusal {
    Refusal::new(column, Reason::Context { code, what })
}

impl Reader {
    /// A line of a canned cycle.
    pub(super) fn cycle(
        &mut self,
        cycle: Cycle,
        found: Found,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        if self.modal.inverse_time {
            return Err(context(found, "does not go with inverse time (G93)"));
        }
        let (p, q) = self.modal.plane.axes();
        let axis = self.modal.plane.across();
        let mut values = self.cycle_axes(found, words)?;
        let series = self.series_with(cycle, found, &mut values, words)?;
        let times = words.take_in('L', found.0, (1.0, TIMES), true)?.unwrap_or(1.0) as u32;
        let bottom = "the bottom of the hole (Z in the XY plane)";
        let bottom = series.bottom.ok_or(missing(found, bottom))?;
        let clear = "an R word, the level it begins on";
        let clear = series.clear.ok_or(missing(found, clear))?;
        let here = at(&self.position, axis);
        let (clear, bottom) = self.levels(axis, here, clear, bottom, found)?;
        let peck = self.peck(&series, found, difference(clear, bottom), words)?;
        if cycle == Cycle::Counterbore && series.dwell.is_none() {
            return Err(missing(found, "a P word, the dwell in seconds"));
        }
        let hole = self.target(&values, false).map_err(|reason| words.blame(reason))?;
        let feed = self.speed(found, true, words)?;
        let spacing = self.spacing(&hole, times, words)?;
        let back = if self.modal.to_initial { series.initial.max(clear) } else { clear };
        // Holes may lie along a line that is turned, and the depth may be of a line before.
        for axis in [p, q, axis] {
            self.set_named_axis(axis);
        }
        self.series = Some(series);
        self.curve = None;
        self.set_drilling(Drilling {
            cycle,
            axis,
            hole,
            spacing,
            times,
            clear,
            bottom,
            back,
            peck,
            depth: clear,
            dwell: series.dwell.unwrap_or(0.0),
            feed,
            tolerance: self.modal.tolerance,
            stage: DrillStage::Raise,
        });
        Ok(())
    }

    /// The axis words of a cycle: of the plane and of the axis across it only.
    fn cycle_axes(
        &self,
        (code, _): Found,
        words: &mut Words,
    ) -> Result<[Option<f64>; AXES], Refusal> {
        let (p, q) = self.modal.plane.axes();
        let own = [p, q, self.modal.plane.across()];
        let values = words.take_axes(code)?;
        for (axis, value) in values.iter().enumerate() {
            if value.is_some() && !own.contains(&axis) {
                let letter = LETTERS.get(axis).copied().unwrap_or('?');
                return Err(Refusal::new(words.column(letter), Reason::Unused(letter)));
            }
        }
        Ok(values)
    }

    /// What the lines of a row of cycles have said, with the words of this one. Takes the depth out of `values`.
    fn series_with(
        &self,
        cycle: Cycle,
        found: Found,
        values: &mut [Option<f64>; AXES],
        words: &mut Words,
    ) -> Result<Series, Refusal> {
        let code = found.0;
        let axis = self.modal.plane.across();
        let initial = self.series.map_or(at(&self.position, axis), |series| series.initial);
        let fresh = Series { cycle, initial, bottom: None, clear: None, peck: None, dwell: None };
        let mut series = self.series.filter(|series| series.cycle == cycle).unwrap_or(fresh);
        if self.series.is_some() && self.modal.relative && !self.modal.to_initial {
            let what = "under G91 and G99 is read in two ways after its first line: use G90 or G98";
            return Err(context(found, what));
        }
        let scale = self.scale();
        let bottom = values.get_mut(axis).and_then(Option::take);
        series.bottom = bottom.map(|value| value * scale).or(series.bottom);
        series.clear = words.take('R', code)?.map(|value| value * scale).or(series.clear);
        if matches!(cycle, Cycle::Peck | Cycle::ChipBreak) {
            let range = (1.0e-6, Coord::LIMIT_MM);
            series.peck =
                words.take_in('Q', code, range, false)?.map(|value| value * scale).or(series.peck);
        }
        if cycle == Cycle::Counterbore {
            series.dwell = words.take_in('P', code, (0.0, LONGEST_DWELL), false)?.or(series.dwell);
        }
        Ok(series)
    }

    /// Depth of a peck in a hole of so much depth: all of it, to the unit, if the cycle has none.
    fn peck(
        &self,
        series: &Series,
        found: Found,
        depth: Coord,
        words: &Words,
    ) -> Result<Coord, Refusal> {
        if !matches!(series.cycle, Cycle::Peck | Cycle::ChipBreak) {
            return Ok(depth);
        }
        let peck = series.peck.ok_or(missing(found, "a Q word, the depth of a peck"))?;
        if depth.to_mm() > peck * PECKS {
            let scale = self.scale();
            let (least, greatest) = (depth.to_mm() / PECKS / scale, Coord::LIMIT_MM);
            let range =
                Reason::Range { letter: 'Q', value: peck / scale, least, greatest, whole: false };
            return Err(Refusal::new(words.column('Q'), range));
        }
        Ok(Coord::from_mm(peck).map_or(depth, |peck| peck.min(depth)))
    }

    /// From hole to hole: where the first is seen from the tool (G91), or nothing.
    fn spacing(&self, hole: &Place, times: u32, words: &Words) -> Result<[Spacing; 2], Refusal> {
        let (p, q) = self.modal.plane.axes();
        let before = if self.modal.relative { &self.position } else { hole };
        let spacing = [p, q].map(|axis| {
            let distance = difference(at(hole, axis), at(before, axis));
            Spacing { axis, distance }
        });
        for Spacing { axis, distance } in spacing {
            let value = at(hole, axis).to_mm() + distance.to_mm() * f64::from(times - 1);
            if value.abs() > Coord::LIMIT_MM {
                return Err(words.blame(Reason::Coordinate { axis, value }));
            }
        }
        Ok(spacing)
    }

    /// Levels of R and of the bottom in the machine.
    fn levels(
        &self,
        axis: usize,
        here: Coord,
        clear: f64,
        bottom: f64,
        (code, column): Found,
    ) -> Result<(Coord, Coord), Refusal> {
        let level = |value: f64| {
            Coord::from_mm(value)
                .map_err(|_| Refusal::new(column, Reason::Coordinate { axis, value }))
        };
        let (clear, bottom) = (level(clear)?, level(bottom)?);
        let zero = self.frame.offset(axis);
        let clear = sum(if self.modal.relative { here } else { zero }, clear);
        let bottom = sum(if self.modal.relative { clear } else { zero }, bottom);
        for coord in [clear, bottom] {
            let value = coord.to_mm();
            if value.abs() > Coord::LIMIT_MM {
                return Err(Refusal::new(column, Reason::Coordinate { axis, value }));
            }
        }
        if bottom >= clear {
            let what = "needs a bottom below its R level";
            return Err(Refusal::new(column, Reason::Context { code, what }));
        }
        Ok((clear, bottom))
    }
}
