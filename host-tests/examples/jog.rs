//! A program is held, jogged away from and back, and resumed: path, position, velocity, acceleration and jerk, as a plot.
//!
//! `cargo run --release -p splineway-host --example jog -- docs/jog.svg`

use anyhow::Result;
use splineway_host::view::{Drawn, Panel, Series, plot_panels};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, ReadOptions};
use splineway_simulator::run::{Events, Observer, Precision, Sample, run_with};
use std::path::{Path, PathBuf};

/// What is shown of it, s: the hold, the jogs, and the way on.
const SHOWN: (f64, f64) = (0.5, 3.3);
/// One of so many servo cycles is shown.
const EVERY: u64 = 4;

/// Positions, velocities, accelerations and jerks of X and Y over time; and the path.
#[derive(Default)]
struct Curves {
    cycles: u64,
    before: [f64; 2],
    path: Vec<(f64, f64)>,
    over_time: [[Vec<(f64, f64)>; 2]; 4],
}

impl Observer for Curves {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        self.cycles += 1;
        let jerk = [0, 1].map(|axis| (sample.acceleration[axis] - self.before[axis]) * 1.0e3);
        self.before = [sample.acceleration[0], sample.acceleration[1]];
        if sample.time < SHOWN.0 || sample.time > SHOWN.1 || !self.cycles.is_multiple_of(EVERY) {
            return Ok(());
        }
        self.path.push((sample.position[0], sample.position[1]));
        for axis in 0..2 {
            let values = [
                sample.position[axis],
                sample.velocity[axis],
                sample.acceleration[axis],
                jerk[axis],
            ];
            for (curves, value) in self.over_time.iter_mut().zip(values) {
                curves[axis].push((sample.time, value));
            }
        }
        Ok(())
    }
}

fn main() -> Result<()> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let program = program::read(&data.join("square.ngc"), ReadOptions::DEFAULT)?;
    let machine = Machine { tolerance: 0.05, cycle: 1.0e-3, ..Machine::default() };
    let events = Events::read(&data.join("jog.csv"))?;
    let mut curves = Curves::default();
    run_with(&program, &machine, Precision::F64, &events, &mut [&mut curves])?;
    let over_time = ["position, mm", "velocity, mm/s", "acceleration, mm/s2", "jerk, mm/s3"];
    let panel = |title: &str, axes, drawn, series| Panel {
        title: title.to_owned(),
        axes,
        logarithmic: false,
        drawn,
        series,
    };
    let path: Vec<Series> = vec![("setpoints".to_owned(), curves.path)];
    let mut panels = vec![panel("path", ["X, mm", "Y, mm"], Drawn::Path, path)];
    for (title, [x, y]) in over_time.into_iter().zip(curves.over_time) {
        let series = vec![("X".to_owned(), x), ("Y".to_owned(), y)];
        panels.push(panel(title, ["time, s", title], Drawn::Curve, series));
    }
    if let Some(out) = std::env::args_os().nth(1) {
        plot_panels(
            &PathBuf::from(out),
            "held at 0.6 s, jogged away and back, resumed at 2.9 s",
            &panels,
        )?;
    }
    Ok(())
}
