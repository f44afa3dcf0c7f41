//! One case of the soak: everything about it follows from its number.

use super::moves::between;
use super::{Draw, Stretch, broken, commands, dense, events, judged, machine, program};
use crate::baseline::{self, Law};
use crate::machine::Machine;
use crate::program::Program;
use crate::run::{Events, Precision};
use anyhow::Result;
use fastrand::Rng;

/// Servo cycles that do not count in a comparison of times.
const CYCLES: f64 = 3.0;

/// A random program on a random machine, with or without an operator.
#[derive(Clone, Debug)]
pub struct Case {
    /// The program.
    pub program: Program,
    /// The machine.
    pub machine: Machine,
    /// Number type of the core.
    pub precision: Precision,
    /// What the operator presses.
    presses: Vec<commands::Press>,
}

/// What a case came to.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Blocks run.
    pub blocks: u64,
    /// Servo cycles judged.
    pub cycles: u64,
    /// What was broken.
    pub broken: Vec<String>,
    /// Time without an operator, over the time with a stop at the end of every block.
    pub against_stops: f64,
}

impl Case {
    /// The case with a number.
    pub fn new(number: u64) -> Self {
        let mut rng = Rng::with_seed(number);
        let axes = [3, 3, 3, 3, 6, 9][rng.usize(..6)];
        let is_dense = rng.bool();
        let single = rng.bool();
        // In f32 the differences of setpoints show rounding of nanometres as jerk: nothing can be told of
        // bands of a micrometre from outside.
        let least = if single { -2.5 } else { -3.0 };
        let tolerance = 10f64.powf(between(&mut rng, least, 0.0));
        let mut scale = || 10f64.powf(between(&mut rng, -1.0, 1.0));
        let scale = if single { (1.0, 1.0) } else { (scale(), scale()) };
        let program = if is_dense {
            let count = rng.usize(1..12);
            dense(&(0..count).map(|_| Stretch::any(&mut rng)).collect::<Vec<_>>())
        } else {
            let used: Vec<usize> = (0..axes).collect();
            let count = rng.usize(1..40);
            program(&(0..count).map(|_| Draw::any(&mut rng, axes)).collect::<Vec<_>>(), &used)
        };
        let presses = if rng.u8(..4) == 0 {
            (0..rng.usize(1..12)).map(|_| commands::any(&mut rng)).collect()
        } else {
            Vec::new()
        };
        let machine = machine(tolerance, scale, if is_dense { 3 } else { axes });
        let precision = if single { Precision::F32 } else { Precision::F64 };
        Self { program, machine, precision, presses }
    }

    /// Runs the case and judges every cycle.
    ///
    /// # Errors
    /// The run does not end, or a block is refused.
    pub fn run(&self) -> Result<Outcome> {
        let Self { program, machine, precision, .. } = self;
        let (verdict, stats) = judged(program, machine, *precision, &Events::default())?;
        let mut outcome = Outcome {
            blocks: stats.blocks,
            cycles: verdict.cycles,
            broken: broken(&verdict, program, machine, *precision)?,
            against_stops: 0.0,
        };
        let limits = machine.axes_of(program)?;
        let stops = baseline::run(program, &limits, machine.tolerance, Law::ExactStop).time;
        // Starts and ends fall on whole cycles.
        outcome.against_stops = (verdict.time - CYCLES * machine.cycle) / stops.max(machine.cycle);
        if self.presses.is_empty() {
            return Ok(outcome);
        }
        let events = events(&self.presses, verdict.time * 1.5);
        let (mut verdict, stats) = judged(program, machine, *precision, &events)?;
        if stats.aborted {
            verdict.end_error = 0.0;
        }
        outcome.blocks += stats.blocks;
        outcome.cycles += verdict.cycles;
        outcome.broken.extend(broken(&verdict, program, machine, *precision)?);
        Ok(outcome)
    }
}
