//! Canned cycles: G73, G81, G82, G83.
//!
//! As in LinuxCNC: over the hole by a rapid (first up to R, where the tool is lower), down to R, to the bottom at the
//! feed, and back to R (G99), or to the level the cycles began on (G98, where that is higher). Every move ends in an exact stop, as corners
//! that are rounded would begin to drill beside the hole.

use super::error::{Reason, Refusal};
use super::groups::Found;
use super::modal::Cycle;
use super::motion::{LONGEST_DWELL, blame};
use super::offsets::{Place, difference, sum};
use super::reader::Reader;
use super::words::Words;
use super::{AXES, LETTERS};
use crate::block::{Block, Feed, Motion};
use crate::number::Coord;

/// Way back to break a chip, and above the last depth where a peck goes on, mm (LinuxCNC).
const CLEARANCE: f64 = 0.254;
/// Most pecks of a hole.
const PECKS: f64 = 10_000.0;
/// Most repetitions.
const TIMES: f64 = 9999.0;

/// What the cycles of the lines before have said.
#[derive(Clone, Copy, Debug)]
pub struct Series {
    /// What its words are for: those of another cycle are none of this, but they are of one row.
    cycle: Cycle,
    /// The level they began on.
    initial: Coord,
    /// Words, mm, as the program has them.
    bottom: Option<f64>,
    clear: Option<f64>,
    /// G73, G83.
    peck: Option<f64>,
    /// G82, s.
    dwell: Option<f64>,
}

/// A cycle under way.
#[derive(Clone, Copy, Debug)]
pub struct Drilling {
    cycle: Cycle,
    /// Index of the axis that is drilled along.
    axis: usize,
    /// The hole, at level R.
    hole: Place,
    /// From hole to hole.
    apart: (usize, Coord, usize, Coord),
    times: u32,
    clear: Coord,
    bottom: Coord,
    /// Where it ends.
    back: Coord,
    peck: Coord,
    /// How deep it has been.
    depth: Coord,
    dwell: f64,
    feed: Feed<f64>,
    tolerance: Option<f64>,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Up to R.
    Raise,
    /// Over the hole.
    Across,
    /// Down to R.
    Approach,
    /// At the feed to the next depth.
    Feed,
    /// Out, or a little up.
    Lift,
    /// Down again to where it has been.
    Return,
    /// At the bottom.
    Dwell,
    /// Up at the end.
    Back,
}

impl Drilling {
    /// The next move; `None` after the last.
    pub fn step(&mut self, position: &mut Place, line: u32) -> Option<Block<f64, AXES>> {
        // Moves of no length are passed over: at most eight stages in a row.
        for _ in 0..16 {
            let (motion, feed) = self.stage(position)?;
            if let Motion::Line { to } = &motion {
                if to == position {
                    continue;
                }
                *position = *to;
            }
            let tolerance = self.tolerance;
            return Some(Block { motion, feed, tolerance, exact_stop: true, tag: line });
        }
        None
    }

    /// The tool along its axis.
    fn along(&self, position: &Place, level: Coord) -> Motion<f64, AXES> {
        let mut to = *position;
        if let Some(slot) = to.get_mut(self.axis) {
            *slot = level;
        }
        Motion::Line { to }
    }

    fn stage(&mut self, position: &Place) -> Option<(Motion<f64, AXES>, Feed<f64>)> {
        let here = position.get(self.axis).copied().unwrap_or_default();
        let rapid = |motion| Some((motion, Feed::Rapid));
        match self.stage {
            Stage::Raise => {
                self.stage = Stage::Across;
                rapid(self.along(position, here.max(self.clear)))
            }
            Stage::Across => {
                if self.times == 0 {
                    return None;
                }
                self.times -= 1;
                self.depth = self.clear;
                self.stage = Stage::Approach;
                let mut to = self.hole;
                if let Some(slot) = to.get_mut(self.axis) {
                    *slot = here;
                }
                rapid(Motion::Line { to })
            }
            Stage::Approach => {
                self.stage = Stage::Feed;
                rapid(self.along(position, self.clear))
            }
            Stage::Feed => {
                self.depth = Coord::from_raw(self.depth.raw().saturating_sub(self.peck.raw()))
                    .max(self.bottom);
                self.stage = match (self.depth == self.bottom, self.cycle) {
                    (false, _) => Stage::Lift,
                    (true, Cycle::Counterbore) => Stage::Dwell,
                    (true, _) => Stage::Back,
                };
                Some((self.along(position, self.depth), self.feed))
            }
            Stage::Lift => {
                if self.cycle == Cycle::ChipBreak {
                    self.stage = Stage::Feed;
                    return rapid(self.along(position, self.depth.plus(CLEARANCE).min(self.clear)));
                }
                self.stage = Stage::Return;
                rapid(self.along(position, self.clear))
            }
            Stage::Return => {
                self.stage = Stage::Feed;
                rapid(self.along(position, self.depth.plus(CLEARANCE).min(self.clear)))
            }
            Stage::Dwell => {
                self.stage = Stage::Back;
                rapid(Motion::Dwell { seconds: self.dwell })
            }
            Stage::Back => {
                self.stage = Stage::Across;
                for (axis, way) in [(self.apart.0, self.apart.1), (self.apart.2, self.apart.3)] {
                    if let Some(slot) = self.hole.get_mut(axis) {
                        *slot = sum(*slot, way);
                    }
                }
                rapid(self.along(position, self.back))
            }
        }
    }
}

impl Reader {
    /// A line of a canned cycle.
    pub(super) fn cycle(
        &mut self,
        cycle: Cycle,
        found: Found,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let (code, column) = found;
        let missing = |what| Refusal::new(column, Reason::Missing { code, what });
        let context = |column, what| Refusal::new(column, Reason::Context { code, what });
        let (p, q) = self.modal.plane.axes();
        let axis = self.modal.plane.across();
        if self.modal.inverse_time {
            return Err(context(column, "does not go with inverse time (G93)"));
        }
        let mut values = words.take_axes(code)?;
        for (other, value) in values.iter().enumerate() {
            if value.is_some() && ![p, q, axis].contains(&other) {
                let letter = LETTERS.get(other).copied().unwrap_or('?');
                return Err(Refusal::new(words.column(letter), Reason::Unused(letter)));
            }
        }
        let here = self.position.get(axis).copied().unwrap_or_default();
        let initial = self.series.map_or(here, |series| series.initial);
        let fresh = Series { cycle, initial, bottom: None, clear: None, peck: None, dwell: None };
        let goes_on = self.series.is_some();
        let mut series = self.series.filter(|series| series.cycle == cycle).unwrap_or(fresh);
        if goes_on && self.modal.relative && !self.modal.to_initial {
            let what = "under G91 and G99 is read in two ways after its first line: use G90 or G98";
            return Err(context(column, what));
        }
        let depth = values.get_mut(axis).and_then(Option::take);
        let scale = self.scale();
        series.bottom = depth.map(|value| value * scale).or(series.bottom);
        series.clear = words.take('R', code)?.map(|value| value * scale).or(series.clear);
        if matches!(cycle, Cycle::Peck | Cycle::ChipBreak) {
            let range = (1.0e-6, Coord::LIMIT_MM);
            series.peck =
                words.take_in('Q', code, range, false)?.map(|value| value * scale).or(series.peck);
        }
        if cycle == Cycle::Counterbore {
            series.dwell = words.take_in('P', code, (0.0, LONGEST_DWELL), false)?.or(series.dwell);
        }
        let times = words.take_in('L', code, (1.0, TIMES), true)?.unwrap_or(1.0) as u32;
        let bottom = series.bottom.ok_or(missing("the bottom of the hole (Z in the XY plane)"))?;
        let clear = series.clear.ok_or(missing("an R word, the level it begins on"))?;
        let (clear, bottom) = self.levels(axis, here, clear, bottom, (code, column))?;
        let way: f64 = clear.minus(bottom);
        let peck = match cycle {
            Cycle::Peck | Cycle::ChipBreak => {
                series.peck.ok_or(missing("a Q word, the depth of a peck"))?
            }
            _ => way,
        };
        if way > peck * PECKS {
            let (least, greatest) = (way / PECKS / scale, Coord::LIMIT_MM);
            let range =
                Reason::Range { letter: 'Q', value: peck / scale, least, greatest, whole: false };
            return Err(Refusal::new(words.column('Q'), range));
        }
        if cycle == Cycle::Counterbore && series.dwell.is_none() {
            return Err(missing("a P word, the dwell in seconds"));
        }
        let hole = self.target(&values, false).map_err(|reason| blame(words, reason))?;
        let feed = self.speed(found, true, words)?;
        let at = |place: &Place, axis: usize| place.get(axis).copied().unwrap_or_default();
        let step = |axis: usize| {
            let here = if self.modal.relative { &self.position } else { &hole };
            difference(at(&hole, axis), at(here, axis))
        };
        let apart = (p, step(p), q, step(q));
        for (axis, way) in [(p, apart.1), (q, apart.3)] {
            let value = at(&hole, axis).to_mm() + way.to_mm() * f64::from(times - 1);
            if value.abs() > Coord::LIMIT_MM {
                return Err(blame(words, Reason::Coordinate { axis, value }));
            }
        }
        let back = if self.modal.to_initial { series.initial.max(clear) } else { clear };
        // The way across may be turned, and the depth may be of a line before.
        for axis in [p, q, axis] {
            self.set_named_axis(axis);
        }
        self.series = Some(series);
        self.curve = None;
        self.set_drilling(Drilling {
            cycle,
            axis,
            hole,
            apart,
            times,
            clear,
            bottom,
            back,
            peck: Coord::ZERO.plus(peck.min(way)),
            depth: clear,
            dwell: series.dwell.unwrap_or(0.0),
            feed,
            tolerance: self.modal.tolerance,
            stage: Stage::Raise,
        });
        Ok(())
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
