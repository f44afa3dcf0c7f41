//! What the numbers of a recording count, and how far it may be off what was run.

use crate::machine::Axis;

/// Part of the tolerance that a recording may be off the path that was run.
pub const SHARE: f64 = 0.1;
/// Finest of that, mm: setpoints are no finer where a tolerance is 0.
pub const FINEST: f64 = 1.0e-6;
/// What each recording of a recording takes of it. Behind these, the part is left.
const STEPS: [f64; 5] = [0.5, 0.22, 0.1, 0.06, 0.045];

/// Each recording of a recording is so much coarser in its curves.
const COARSER: f64 = 3.0;

/// Shares of the limits that velocity, acceleration and jerk may be off.
const OFF: [f64; 3] = [5.0e-4, 2.0e-3, 1.0e-2];
/// Counts of a limit: of velocity, of acceleration.
const COUNTS: [f64; 2] = [100_000.0, 20_000.0];
/// Counts of what the jerk makes of an acceleration in one servo cycle: its error is one of these at most.
const JERK_COUNTS: f64 = 400.0;
/// Counts of what a position may be off: what counting is off, of nine axes, is less than the least of the steps.
const POSITION_COUNTS: f64 = 40.0;

/// The units of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// One count of velocity, mm/s.
    pub velocity: f64,
    /// One count of acceleration, mm/s2.
    pub acceleration: f64,
    /// Velocity, acceleration and jerk may be off by this much: mm and s.
    pub off: [f64; 3],
}

/// Units of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Grain {
    /// Servo cycle, s.
    pub cycle: f64,
    /// One count of position and of deviation, mm.
    pub position: f64,
    /// Positions may be off what is recorded here by this much, mm.
    pub off: f64,
    /// Positions may be off what was run by this much, mm.
    pub off_run: f64,
    /// Of each axis.
    pub axes: Vec<Unit>,
    /// How often it has been made coarser.
    pub level: usize,
}

impl Grain {
    /// Of a run with a servo cycle, s, that may be `all` mm off.
    pub fn new(cycle: f64, all: f64, limits: &[Axis]) -> Self {
        let mut grain = Self {
            cycle,
            position: all / POSITION_COUNTS,
            off: STEPS[0] * all,
            off_run: STEPS[0] * all,
            axes: Vec::new(),
            level: 0,
        };
        let unit = |axis: &Axis| Unit {
            velocity: axis.velocity / COUNTS[0],
            acceleration: (axis.acceleration / COUNTS[1]).min(axis.jerk * cycle / JERK_COUNTS),
            off: [OFF[0] * axis.velocity, OFF[1] * axis.acceleration, OFF[2] * axis.jerk],
        };
        grain.axes = limits.iter().map(unit).collect();
        grain
    }

    /// Of a recording of a recording: curves may be off three times as far. Positions stay within their part of the
    /// tolerance as long as that is of use.
    #[must_use]
    pub fn coarser(&self) -> Self {
        let mut grain = self.clone();
        grain.level += 1;
        let all = self.position * POSITION_COUNTS;
        if let Some(step) = STEPS.get(grain.level) {
            grain.off = step * all;
        } else {
            grain.position *= 2.0;
            grain.off = all;
        }
        grain.off_run += grain.off;
        for unit in &mut grain.axes {
            unit.velocity *= COARSER;
            unit.acceleration *= COARSER;
            unit.off = unit.off.map(|off| off * COARSER);
        }
        grain
    }

    /// Shares of the limits that velocities, accelerations and jerks may be off what was run.
    pub fn off_limits(&self) -> [f64; 3] {
        // Each level is off the one before.
        let all: f64 =
            std::iter::successors(Some(1.0), |off| Some(off * COARSER)).take(self.level + 1).sum();
        OFF.map(|off| off * all)
    }

    /// Whether positions are no longer within their part of the tolerance.
    pub fn is_coarse(&self) -> bool {
        self.level >= STEPS.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_stay_within_their_part_as_long_as_that_is_of_use() {
        let axis = Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 };
        let mut grain = Grain::new(1e-3, 0.005, &[axis]);
        while !grain.coarser().is_coarse() {
            grain = grain.coarser();
            assert!(grain.off_run <= 0.005 && grain.off >= grain.position, "{grain:?}");
        }
        assert!(grain.coarser().off_run > 0.005);
    }
}
