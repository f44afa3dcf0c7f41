//! Random programs, machines and operators, and what a run of them has broken: for the property tests and
//! for `splineway soak`.

mod commands;
mod dense;
mod moves;
pub mod soak;

pub use commands::{Press, events};
pub use dense::{Stretch, dense, poly_line};
pub use moves::{Draw, program};

use crate::machine::{Axis, Machine};
use crate::program::Program;
use crate::run::{Events, Judge, Observer, Precision, Sample, Stats, Track, Verdict, run_with};
use crate::view::violations;
use anyhow::Result;
use std::collections::BTreeMap;

/// No trial takes that long.
struct Patience;

impl Observer for Patience {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        anyhow::ensure!(sample.time < 1000.0, "line {}: the run does not end", sample.tag);
        Ok(())
    }
}

/// Runs a program while an operator gives commands, and judges it.
///
/// # Errors
/// The run does not end, or a block is refused.
pub fn judged(
    program: &Program,
    machine: &Machine,
    precision: Precision,
    events: &Events,
) -> Result<(Verdict, Stats)> {
    let limits = machine.axes_of(program)?;
    let track = Track::new(program);
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
    let observers: &mut [&mut dyn Observer] = &mut [&mut judge, &mut Patience];
    let stats = run_with(program, machine, precision, events, observers)?;
    Ok((judge.verdict(), stats))
}

/// What a run has broken.
///
/// # Errors
/// The machine lacks an axis.
pub fn broken(
    verdict: &Verdict,
    program: &Program,
    machine: &Machine,
    precision: Precision,
) -> Result<Vec<String>> {
    let _ = (program, machine, precision);
    Ok(violations(verdict))
}

/// A machine whose axes differ; `scale` is for its acceleration and, on top, for its jerk.
pub fn machine(tolerance: f64, scale: (f64, f64), axes: usize) -> Machine {
    let letters = ["X", "Y", "Z", "A", "B", "C", "U", "V", "W"];
    let axes: BTreeMap<String, Axis> = letters[..axes]
        .iter()
        .enumerate()
        .map(|(n, letter)| {
            let share = 1.0 - 0.08 * n as f64;
            let acceleration = 2000.0 * share * scale.0;
            let axis =
                Axis { velocity: 200.0 * share, acceleration, jerk: acceleration * 25.0 * scale.1 };
            ((*letter).to_owned(), axis)
        })
        .collect();
    Machine { tolerance, axes, lookahead: 16, ..Machine::default() }
}
