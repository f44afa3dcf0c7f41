//! Holes of a canned cycle, move by move.

use super::AXES;
use super::modal::Cycle;
use super::offsets::{Place, difference, sum};
use crate::block::{Block, Feed, Motion};
use crate::number::Coord;

/// Length of the rise that breaks a chip, and above the last depth where a peck goes on, mm (LinuxCNC).
const CLEARANCE: f64 = 0.254;
/// What is left of a hole that is less than this is no peck of its own, but the rounding of those before: 1 nm.
const REST: i64 = 1_000_000;

/// What the cycles of the lines before have said.
#[derive(Clone, Copy, Debug)]
pub struct Series {
    /// What its words are for: those of another cycle are none of this, but they are of one row.
    pub cycle: Cycle,
    /// The level they began on.
    pub initial: Coord,
    /// Words, mm, as the program has them.
    pub bottom: Option<f64>,
    pub clear: Option<f64>,
    /// G73, G83.
    pub peck: Option<f64>,
    /// G82, s.
    pub dwell: Option<f64>,
}

/// From one hole to the next along an axis.
#[derive(Clone, Copy, Debug)]
pub struct Spacing {
    /// Index of the axis.
    pub axis: usize,
    pub distance: Coord,
}

/// A cycle under way.
#[derive(Clone, Copy, Debug)]
pub struct Drilling {
    pub cycle: Cycle,
    /// Index of the axis that is drilled along.
    pub axis: usize,
    /// The hole, at level R.
    pub hole: Place,
    /// From hole to hole, along the axes of the plane.
    pub spacing: [Spacing; 2],
    pub times: u32,
    pub clear: Coord,
    pub bottom: Coord,
    /// Where it ends.
    pub back: Coord,
    pub peck: Coord,
    /// How deep it has been.
    pub depth: Coord,
    pub dwell: f64,
    pub feed: Feed<f64>,
    pub tolerance: Option<f64>,
    pub stage: DrillStage,
}

/// The move of a hole that comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrillStage {
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

    /// A move to a corner of all that its holes take up, of four: where these are within limits of travel, so is every one of its moves.
    #[cfg(feature = "grbl")]
    pub fn corner(&self, number: usize, line: u32) -> Block<f64, AXES> {
        let mut to = self.hole;
        for Spacing { axis, distance } in self.spacing {
            if let Some(slot) = to.get_mut(axis).filter(|_| number >= 2) {
                let others = i64::from(self.times.saturating_sub(1));
                *slot = sum(*slot, Coord::from_raw(distance.raw().saturating_mul(others)));
            }
        }
        if let Some(slot) = to.get_mut(self.axis) {
            *slot = if number.is_multiple_of(2) { self.bottom } else { self.clear };
        }
        Block::line(to, 1.0, line)
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
            DrillStage::Raise => {
                self.stage = DrillStage::Across;
                rapid(self.along(position, here.max(self.clear)))
            }
            DrillStage::Across => {
                if self.times == 0 {
                    return None;
                }
                self.times -= 1;
                self.depth = self.clear;
                self.stage = DrillStage::Approach;
                let mut to = self.hole;
                if let Some(slot) = to.get_mut(self.axis) {
                    *slot = here;
                }
                rapid(Motion::Line { to })
            }
            DrillStage::Approach => {
                self.stage = DrillStage::Feed;
                rapid(self.along(position, self.clear))
            }
            DrillStage::Feed => {
                let next = difference(self.depth, self.peck);
                let rest = difference(next, self.bottom);
                self.depth = if rest.raw() < REST { self.bottom } else { next };
                self.stage = match (self.depth == self.bottom, self.cycle) {
                    (false, _) => DrillStage::Lift,
                    (true, Cycle::Counterbore) => DrillStage::Dwell,
                    (true, _) => DrillStage::Back,
                };
                Some((self.along(position, self.depth), self.feed))
            }
            DrillStage::Lift => {
                if self.cycle == Cycle::ChipBreak {
                    self.stage = DrillStage::Feed;
                    return rapid(self.along(position, self.depth.plus(CLEARANCE).min(self.clear)));
                }
                self.stage = DrillStage::Return;
                rapid(self.along(position, self.clear))
            }
            DrillStage::Return => {
                self.stage = DrillStage::Feed;
                rapid(self.along(position, self.depth.plus(CLEARANCE).min(self.clear)))
            }
            DrillStage::Dwell => {
                self.stage = DrillStage::Back;
                rapid(Motion::Dwell { seconds: self.dwell })
            }
            DrillStage::Back => {
                self.stage = DrillStage::Across;
                for Spacing { axis, distance } in self.spacing {
                    if let Some(slot) = self.hole.get_mut(axis) {
                        *slot = sum(*slot, distance);
                    }
                }
                rapid(self.along(position, self.back))
            }
        }
    }
}
