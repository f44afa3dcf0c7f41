//! Trials: random programs, machines and operators, for the property tests, and the [`soak`], which lets anything
//! happen at any moment and judges every cycle, command and answer.
//!
//! What does not belong here: the judge of a single run (`splineway-simulator`), and tests that draw nothing.

mod commands;
mod dense;
mod moves;
pub mod soak;

pub use commands::{Press, events};
pub use dense::{Stretch, dense, poly_line};
pub use moves::{Draw, program};

use splineway_simulator::machine::{Axis, Machine, StopLimits};
use std::collections::BTreeMap;

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
    let quick = StopLimits { acceleration: 5000.0 * scale.0, jerk: 4.0e5 * scale.0 * scale.1 };
    let stop = BTreeMap::from([("default".to_owned(), quick)]);
    Machine { tolerance, axes, stop, lookahead: 16, ..Machine::default() }
}
