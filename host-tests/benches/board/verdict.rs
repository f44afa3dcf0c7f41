//! Steps against the G-code that asked for them.
//!
//! - *Band*: after every step the place lies within the tolerance of the programmed path, in its order
//!   ([`Follower`]), and what steps cannot say: half a step that a place was rounded by, and half a period of the pulses,
//!   on every axis.
//! - *Limits*: at the end of a servo cycle an axis is where its setpoint was, rounded to a step. So the difference of two such places, m
//!   cycles apart, is the speed in between, and a step of rounding; a second difference is an acceleration, and two steps; a third one a jerk,
//!   and four. By the mean value theorem none of them can be more than the limit, times the m cycles to the same power, whatever m is:
//!   short windows find short peaks that are high, long ones peaks that are hardly too high.
//! - *End*: the last step of a program that has been run is the programmed end, rounded to a step, and the path has been followed up to it.

use super::machine::{self, AXES};
use super::recording::{Cycle, Place, mm};
use anyhow::{Context, Result, ensure};
use splineway_simulator::judge::{Follower, Track};
use splineway_simulator::program::{self, Dialect, ReadOptions, gcode};

/// Windows of the differences, servo cycles.
const WINDOWS: [usize; 12] = [1, 2, 3, 5, 8, 13, 20, 32, 50, 80, 125, 200];
/// What steps cannot say of a place: a step on every axis, mm; and the arc that a servo cycle is a chord of.
const GRAIN: f64 = 1.75;
const SAG: f64 = 2.0e-4;
/// Share of a limit by which rounding may go beyond it.
pub const ROUNDING: f64 = 1.0e-3;

/// A stretch of G-code that the machine has run.
pub struct Leg {
    /// Its lines.
    pub text: String,
    /// Where it began, steps.
    pub from: Place,
    /// The servo cycles in which it was run, standstill before and after included.
    pub cycles: std::ops::Range<usize>,
    /// Whether it was run to its end.
    pub whole: bool,
}

/// What was found; lengths in mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Farthest from the path.
    pub deviation: f64,
    /// Peaks of velocity, acceleration and jerk of any axis, as shares of the limits, that steps prove.
    pub peaks: [f64; 3],
    /// Servo cycles from the first step to the last.
    pub cycles: usize,
    /// Length of path followed.
    pub way: f64,
}

impl Verdict {
    /// The worse of both.
    pub fn and(self, other: &Self) -> Self {
        Self {
            deviation: self.deviation.max(other.deviation),
            peaks: core::array::from_fn(|k| self.peaks[k].max(other.peaks[k])),
            cycles: self.cycles + other.cycles,
            way: self.way + other.way,
        }
    }
}

/// The peaks of all axes in a run of cycles, as shares of the limits.
pub fn peaks(cycles: &[Cycle]) -> [f64; 3] {
    let limits = [machine::VELOCITY, machine::ACCELERATION, machine::JERK].map(f64::from);
    let step = 1.0 / f64::from(machine::steps_per_mm());
    let period = 1.0 / f64::from(machine::SERVO_HZ);
    let mut out = [0.0f64; 3];
    for m in WINDOWS {
        let time = m as f64 * period;
        let powers = [time, time * time, time * time * time];
        for k in 0..cycles.len().saturating_sub(m) {
            for axis in 0..AXES {
                let at = |n: usize| cycles.get(k + n * m).map(|cycle| cycle.end[axis]);
                let (Some(a), Some(b)) = (at(0), at(1)) else { continue };
                let mut see = |order: usize, steps: i64, rounding: f64| {
                    let most = limits[order] * powers[order];
                    let length = (steps.abs() as f64 - rounding) * step;
                    out[order] = out[order].max(length / most);
                };
                see(0, b - a, 1.0);
                let Some(c) = at(2) else { continue };
                see(1, c - 2 * b + a, 2.0);
                let Some(d) = at(3) else { continue };
                see(2, d - 3 * (c - b) - a, 4.0);
            }
        }
    }
    out
}

/// Judges a leg.
///
/// # Errors
/// A step outside the band, a limit exceeded, an end that is not the programmed one.
pub fn judge(leg: &Leg, all: &[Cycle], tolerance: f64) -> Result<Verdict> {
    let cycles = all.get(leg.cycles.clone()).context("cycles that are not recorded")?;
    let mut start = [0.0; program::AXES];
    start[..AXES].copy_from_slice(&mm(&leg.from));
    let options = ReadOptions { start, dialect: Some(Dialect::Grbl), ..ReadOptions::DEFAULT };
    let track = Track::new(&gcode::parse_with(&leg.text, options)?);
    let step = 1.0 / f64::from(machine::steps_per_mm());
    let grain = GRAIN * step + SAG;
    let reach = 20.0 * tolerance + 0.02;
    let mut follower = Follower::default();
    let mut verdict = Verdict { peaks: peaks(cycles), ..Verdict::default() };
    let mut before = mm(&leg.from);
    for (number, cycle) in cycles.iter().enumerate() {
        for (tick, place) in &cycle.steps {
            let here = mm(place);
            let moved: f64 = before.iter().zip(&here).map(|(a, b)| (a - b).abs()).sum();
            let off = follower.look(&track, &here, reach + 2.0 * moved, tolerance + grain);
            ensure!(
                off.outside.distance <= 0.0,
                "{here:?} (cycle {} tick {tick}) lies {:.4} mm outside the band, near line {}",
                leg.cycles.start + number,
                off.outside.distance,
                off.outside.line
            );
            verdict.deviation = verdict.deviation.max(off.distance);
            before = here;
        }
    }
    let moves = |cycle: &Cycle| !cycle.steps.is_empty();
    if let (Some(first), Some(last)) =
        (cycles.iter().position(moves), cycles.iter().rposition(moves))
    {
        verdict.cycles = last + 1 - first;
    }
    verdict.way = follower.way();
    for (name, peak) in ["velocity", "acceleration", "jerk"].iter().zip(verdict.peaks) {
        ensure!(peak <= 1.0 + ROUNDING, "{peak:.4} of the limit of {name}");
    }
    if leg.whole {
        let end = cycles.last().map_or(leg.from, |cycle| cycle.end);
        let off = mm(&end).iter().zip(track.end()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        ensure!(
            off <= 0.5 * step + 1.0e-6,
            "it ends at {:?} instead of {:?}",
            mm(&end),
            track.end()
        );
        let rest = track.length() - verdict.way;
        ensure!(rest <= reach, "{rest:.3} mm of the path were not run");
    }
    Ok(verdict)
}
