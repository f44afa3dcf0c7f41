//! Pass or fail: what a run has broken.

use super::track::{Outside, Track};
use super::verdict::{Judge, Verdict};
use crate::machine::Machine;
use crate::program::Program;
use crate::run::{Events, Observer, Overtime, Precision, Sample, Stats, run_with};
use anyhow::Result;

/// An axis may be over a limit by this share: the core's own rounding in its bounds.
const OVER: f64 = 1.0e-3;
/// Share of the tolerance that is granted to rounding.
const BAND: f64 = 5.0e-4;
/// What is granted beyond, mm: to the judge's chords, and to the finest input.
const NOTHING: f64 = 1.0e-6;
/// Greatest distance from the programmed end, mm.
const END: f64 = 1.0e-4;

/// What a run has broken: nothing, if the core is right.
pub fn violations(verdict: &Verdict) -> Vec<String> {
    let mut found = Vec::new();
    for (peaks, how) in [(verdict.worst(), ""), (verdict.worst_reported(), " (as it says)")] {
        for (name, ratio) in [
            ("velocity", peaks.velocity),
            ("acceleration", peaks.acceleration),
            ("jerk", peaks.jerk),
        ] {
            if !(ratio <= 1.0 + OVER) {
                found.push(format!("{name}{how} is {ratio:.4} of its limit"));
            }
        }
    }
    if !(verdict.mismatch <= 1.0) {
        found.push(format!(
            "positions do not go as velocities and accelerations say: {:.3} of what rounding explains",
            verdict.mismatch
        ));
    }
    let Outside { distance, tolerance, line } = verdict.outside;
    if distance > tolerance * BAND + NOTHING {
        let off = tolerance + distance;
        found.push(format!(
            "line {line}: deviation is {off:.6} mm; the tolerance is {tolerance} mm"
        ));
    }
    if !(verdict.end_error <= END) {
        found.push(format!("the end is {:.6} mm off", verdict.end_error));
    }
    if let Some(Overtime { seconds, line }) = verdict.overtime
        && seconds > 0.0
    {
        found.push(format!(
            "line {line}: it took {seconds:.3} s longer than stops and commands explain"
        ));
    }
    found
}

/// No trial takes that long, s.
const LONGEST: f64 = 1000.0;

struct Patience;

impl Observer for Patience {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        anyhow::ensure!(
            sample.time < LONGEST,
            "line {}: the run has not come to its end after {LONGEST} s",
            sample.tag
        );
        Ok(())
    }
}

/// Runs a program while an operator gives commands, and judges it.
///
/// # Errors
/// The run does not end within 1000 s, or a block is refused.
pub fn judged(
    program: &Program,
    machine: &Machine,
    precision: Precision,
    events: &Events,
) -> Result<(Verdict, Stats)> {
    let limits = machine.axes_of(program)?;
    let track = Track::new(program);
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance)
        .stopping(&machine.stop_axes_of(program)?)
        .driven_by(&machine.motors_for(program));
    let observers: &mut [&mut dyn Observer] = &mut [&mut judge, &mut Patience];
    let stats = run_with(program, machine, precision, events, observers)?;
    Ok((judge.verdict(), stats))
}
