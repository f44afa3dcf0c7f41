//! A surface is probed, and two axes are homed: position, velocity, acceleration and jerk, as two plots.
//!
//! `cargo run --release -p splineway-host --example probe -- docs/probe.svg docs/home.svg`

use anyhow::Result;
use splineway::Activity;
use splineway_host::view::{Panel, plot_panels};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, ReadOptions};
use splineway_simulator::run::{Events, Observer, Precision, Sample, run_with};
use std::path::{Path, PathBuf};

/// One of so many servo cycles is shown.
const EVERY: u64 = 4;

/// Positions, velocities, accelerations and jerks of X and Y over time, from the end of the program on.
#[derive(Default)]
struct Curves {
    cycles: u64,
    begun: Option<f64>,
    before: [f64; 2],
    over_time: [[Vec<(f64, f64)>; 2]; 4],
}

impl Observer for Curves {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        self.cycles += 1;
        let jerk = [0, 1].map(|axis| (sample.acceleration[axis] - self.before[axis]) * 1.0e3);
        self.before = [sample.acceleration[0], sample.acceleration[1]];
        if sample.activity == Activity::Jogging {
            self.begun.get_or_insert(sample.time);
        }
        let Some(begun) = self.begun.filter(|_| self.cycles.is_multiple_of(EVERY)) else {
            return Ok(());
        };
        for axis in 0..2 {
            let values = [
                sample.position[axis],
                sample.velocity[axis],
                sample.acceleration[axis],
                jerk[axis],
            ];
            for (curves, value) in self.over_time.iter_mut().zip(values) {
                curves[axis].push((sample.time - begun, value));
            }
        }
        Ok(())
    }
}

fn draw(events: &str, title: &str, axes: usize, out: Option<PathBuf>) -> Result<()> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let program = program::read(&data.join("square.ngc"), ReadOptions::DEFAULT)?;
    let machine = Machine { tolerance: 0.05, cycle: 1.0e-3, ..Machine::default() };
    let events = Events::read(&data.join(events))?;
    let mut curves = Curves::default();
    let stats = run_with(&program, &machine, Precision::F64, &events, &mut [&mut curves])?;
    for words in &stats.sought {
        println!("{words}");
    }
    let over_time = ["position, mm", "velocity, mm/s", "acceleration, mm/s2", "jerk, mm/s3"];
    let mut panels = Vec::new();
    for (title, both) in over_time.into_iter().zip(curves.over_time) {
        let named = ["X", "Y"].map(str::to_owned).into_iter().zip(both);
        panels.push(Panel::over_time(title, named.take(axes).collect()));
    }
    if let Some(out) = out {
        plot_panels(&out, title, &panels)?;
    }
    Ok(())
}

fn main() -> Result<()> {
    let mut out = std::env::args_os().skip(1).map(PathBuf::from);
    let title = "probed at 20 mm/s, left at 5 mm/s, probed at 1 mm/s";
    draw("probe.csv", title, 1, out.next())?;
    draw("home.csv", "X and Y homed at once, and parked", 2, out.next())
}
