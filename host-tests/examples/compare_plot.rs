//! Speed along a path with this planner and with other speed laws, as a plot.
//!
//! `cargo run --release --example compare_plot -- speeds.html`

use anyhow::Result;
use splineway_host::view::{Curve, plot_speeds};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, ReadOptions};
use splineway_simulator::record::Trace;
use splineway_simulator::run::{Precision, run};
use splineway_studies::baseline::{self, Law};
use std::path::{Path, PathBuf};

fn main() -> Result<()> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/butterfly.json");
    let program = program::read(
        &file,
        ReadOptions { feed: 200.0, segments: Some(80), ..ReadOptions::DEFAULT },
    )?;
    let machine = Machine { tolerance: 0.05, ..Machine::default() };
    let mut trace = Trace::new(machine.cycle);
    run(&program, &machine, Precision::F64, &mut [&mut trace])?;
    let mut curves = vec![Curve {
        name: "splineway".to_owned(),
        points: trace.points.iter().map(|point| (point.way, point.speed)).collect(),
    }];
    let limits = machine.axes_of(&program)?;
    for (law, name) in
        [(Law::ExactStop, "exact stop"), (Law::SCurve, "junction deviation, S-curve")]
    {
        let outcome = baseline::run(&program, &limits, machine.tolerance, law);
        println!("{name}: {:.3} s", outcome.time);
        curves.push(Curve { name: name.to_owned(), points: outcome.curve });
    }
    if let Some(out) = std::env::args_os().nth(1) {
        plot_speeds(&PathBuf::from(out), "butterfly, 0.05 mm: speed along the way", &curves)?;
    }
    Ok(())
}
