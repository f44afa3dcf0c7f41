//! Every setpoint against the band, the axis limits and the time that a run may take.

use super::guide::{Guide, Passing};
use super::track::{Follower, Outside, Track};
use super::witness::{Peaks, Witness};
use crate::machine::{Axis, MotorRow};
use crate::program::Tape;
use crate::run::{Observer, Overtime, Sample, Stops, Stopwatch};
use splineway::Activity;

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Time from rest to rest, s.
    pub time: f64,
    /// Servo cycles.
    pub cycles: u64,
    /// Largest distance from the programmed path, mm.
    pub deviation: f64,
    /// Largest distance beyond the tolerance that is in force there, mm (less than 0: inside), and the
    /// line.
    pub outside: Outside,
    /// Largest speed along the path, mm/s.
    pub path_speed: f64,
    /// Way from setpoint to setpoint, mm.
    pub way: f64,
    /// Peaks per axis, then per motor, by differences of positions, less rounding: mm and s.
    pub peaks: Vec<Peaks>,
    /// The same over the limits.
    pub ratios: Vec<Peaks>,
    /// Peaks over the limits by the setpoints' own velocities and accelerations.
    pub reported: Vec<Peaks>,
    /// Disagreement of positions, velocities and accelerations over what rounding and the jerk explain.
    pub mismatch: f64,
    /// Distance of the last setpoint from the programmed end, mm.
    pub end_error: f64,
    /// Time beyond what stops and commands explain, if the judge was given a measure of it.
    pub overtime: Option<Overtime>,
}

impl Verdict {
    /// Largest ratio of any axis or motor, by differences.
    pub fn worst(&self) -> Peaks {
        self.ratios.iter().fold(Peaks::default(), |worst, ratio| worst.greater(*ratio))
    }

    /// Largest ratio of any axis or motor, by what setpoints say.
    pub fn worst_reported(&self) -> Peaks {
        self.reported.iter().fold(Peaks::default(), |worst, ratio| worst.greater(*ratio))
    }
}

/// Watches a run.
pub struct Judge<'a> {
    guide: Guide<'a>,
    limits: &'a [Axis],
    /// Of the motors.
    driven: Vec<Axis>,
    cycle: f64,
    tolerance: f64,
    reach: f64,
    follower: Follower,
    witness: Witness,
    watch: Option<Stopwatch<'a>>,
    before: Vec<f64>,
    /// The machine has been jogged, and not been on the path since.
    jogged: bool,
    /// In the last cycle.
    deviation: f64,
    verdict: Verdict,
}

impl<'a> Judge<'a> {
    /// A judge of runs along `track`; `tolerance` (mm) is that of moves which name none.
    pub fn new(track: &'a Track, limits: &'a [Axis], cycle: f64, tolerance: f64) -> Self {
        Self::along(Guide::Whole(track), limits, cycle, tolerance)
    }

    /// A judge of a run of a program that is gone through as it is run, so that its length takes no room.
    pub fn passing(tape: &'a dyn Tape, limits: &'a [Axis], cycle: f64, tolerance: f64) -> Self {
        Self::along(Guide::Passing(Box::new(Passing::new(tape))), limits, cycle, tolerance)
    }

    fn along(guide: Guide<'a>, limits: &'a [Axis], cycle: f64, tolerance: f64) -> Self {
        Self {
            limits,
            driven: Vec::new(),
            cycle,
            tolerance,
            // A sharp corner inside the band cuts off this much of the path.
            reach: 20.0 * guide.widest(tolerance) + 0.02,
            guide,
            follower: Follower::default(),
            witness: Witness::new(limits, cycle),
            watch: None,
            before: Vec::new(),
            jogged: false,
            deviation: 0.0,
            verdict: Verdict::default(),
        }
    }

    /// The limits of stops by the stop limits, of the same axes.
    #[must_use]
    pub fn stopping(mut self, stops: &[Axis]) -> Self {
        self.witness = self.witness.stopping(stops);
        self
    }

    /// Motors that follow the axes keep limits of their own. To be said behind those of stops.
    #[must_use]
    pub fn driven_by(mut self, motors: &[MotorRow]) -> Self {
        self.driven = motors.iter().map(|motor| motor.limits).collect();
        self.witness = self.witness.driven_by(motors);
        self
    }

    /// Holds the run against the time with stops, too; `slack` (s) is what late planning may add to
    /// every command.
    #[must_use]
    pub fn timed(mut self, stops: &'a Stops<'a>, slack: f64) -> Self {
        self.watch = Some(Stopwatch::new(stops, slack));
        self
    }

    /// The length of the path, mm.
    pub fn length(&mut self) -> f64 {
        self.guide.length()
    }

    /// Distance from the programmed path in the last cycle, mm; 0 off the path, in a jog.
    pub const fn deviation(&self) -> f64 {
        self.deviation
    }

    /// The findings.
    pub fn verdict(&mut self) -> Verdict {
        let mut verdict = self.verdict.clone();
        verdict.time = verdict.cycles.saturating_sub(1) as f64 * self.cycle;
        let over = |peaks: &[Peaks]| {
            peaks
                .iter()
                .zip(self.limits.iter().chain(&self.driven))
                .map(|(peak, limit)| peak.over(limit))
                .collect()
        };
        verdict.peaks = self.witness.differences();
        verdict.ratios = over(&verdict.peaks);
        verdict.reported = over(&self.witness.reported());
        verdict.mismatch = self.witness.mismatch();
        verdict.overtime = self.watch.as_ref().map(Stopwatch::overtime);
        if !self.before.is_empty() && !self.jogged {
            verdict.end_error = distance(self.guide.end(), &self.before);
        }
        verdict
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

impl Observer for Judge<'_> {
    fn setpoint(&mut self, sample: &Sample<'_>) -> anyhow::Result<()> {
        let x = &sample.position[..self.limits.len()];
        self.verdict.cycles += 1;
        let step = if self.before.is_empty() { 0.0 } else { distance(&self.before, x) };
        match sample.activity {
            Activity::Jogging | Activity::Set => self.jogged = true,
            Activity::Idle => {}
            _ => self.jogged = false,
        }
        self.deviation = 0.0;
        if !self.jogged {
            let reach = self.reach + 2.0 * step;
            let off = self.guide.look(&mut self.follower, x, reach, self.tolerance);
            self.deviation = off.distance;
            self.verdict.deviation = self.verdict.deviation.max(off.distance);
            if off.outside.distance > self.verdict.outside.distance {
                self.verdict.outside = off.outside;
            }
        }
        self.witness.see(sample);
        self.verdict.path_speed = self.verdict.path_speed.max(step / self.cycle);
        self.verdict.way += step;
        self.before.clear();
        self.before.extend_from_slice(x);
        if let Some(watch) = &mut self.watch {
            watch.see(self.cycle, sample.tag, sample.pace);
        }
        Ok(())
    }
}
