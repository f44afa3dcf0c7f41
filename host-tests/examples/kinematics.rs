//! A square and a diagonal on a machine with two belts, by the limits of its motors, and by limits of the axes that keep those in every
//! direction: the motors' position, velocity, acceleration and jerk, as a plot.
//!
//! `cargo run --release -p splineway-host --example kinematics -- docs/kinematics.svg`

use anyhow::{Result, anyhow};
use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Interpolator, Limits, Linear, Link, Planner,
    Progress,
};
use splineway_host::view::{Panel, Series, plot_panels};
use std::path::PathBuf;

/// s.
const CYCLE: f64 = 1.0e-3;
/// Corners, mm.
const CORNERS: [(f64, f64); 5] = [(40.0, 0.0), (40.0, 40.0), (0.0, 40.0), (0.0, 0.0), (40.0, 40.0)];
/// mm/s.
const FEED: f64 = 250.0;

type Core<'a> = (Planner<'a, f64, 2>, Interpolator<'a, f64, 2>);
type Curve = Vec<(f64, f64)>;

/// mm/s, mm/s2, mm/s3 of a motor; of an axis, a share of that.
fn part(share: f64) -> AxisLimits<f64> {
    AxisLimits::linear(200.0 * share, 2000.0 * share, 5.0e4 * share)
}

/// Position, velocity, acceleration and jerk of a motor over time, on a machine with these limits.
fn run(limits: &Limits<f64, 2>, motor: usize) -> Result<[Curve; 4]> {
    let mut config = Config::new(*limits);
    (config.cycle, config.tolerance) = (CYCLE, 0.05);
    let belts = Linear::<f64, 2, 2>::core_xy();
    let mut link = Box::new(Link::<f64, 2>::new());
    let (mut planner, mut interpolator): Core<'_> = link.split(config, [Coord::ZERO; 2])?;
    for ((x, y), tag) in CORNERS.into_iter().zip(1..) {
        planner.push(&Block::line([Coord::from_mm(x)?, Coord::from_mm(y)?], FEED, tag))?;
    }
    planner.finish();
    let mut curves: [Curve; 4] = Default::default();
    let mut before = 0.0;
    for cycle in 0..20_000 {
        let progress = planner.settle();
        let axes = interpolator.tick();
        let setpoint = belts.setpoint(&axes);
        let (time, acceleration) = (f64::from(cycle) * CYCLE, setpoint.acceleration[motor]);
        let jerk = (acceleration - before) / CYCLE;
        before = acceleration;
        let position = setpoint.position_mm(motor);
        let values = [position, setpoint.velocity[motor], acceleration, jerk];
        for (curve, value) in curves.iter_mut().zip(values) {
            curve.push((time, value));
        }
        if progress == Progress::Done && axes.activity == Activity::Idle {
            return Ok(curves);
        }
    }
    Err(anyhow!("the machine does not come to rest"))
}

fn main() -> Result<()> {
    let belts = Linear::<f64, 2, 2>::core_xy();
    let by_motors = Limits::new([part(5.0); 2])?.with_motors(&belts, [part(1.0); 2])?;
    let by_axes = Limits::new([part(0.5); 2])?;
    let runs = [
        ("x + y, by limits of the motors", run(&by_motors, 0)?),
        ("x - y, by limits of the motors", run(&by_motors, 1)?),
        ("x + y, by limits of the axes", run(&by_axes, 0)?),
    ];
    for (name, curves) in &runs {
        println!("{name}: {:.3} s", curves[0].len() as f64 * CYCLE);
    }
    let titles = ["position, mm", "velocity, mm/s", "acceleration, mm/s2", "jerk, mm/s3"];
    let panels: Vec<Panel> = titles
        .into_iter()
        .enumerate()
        .map(|(n, title)| {
            let series = |(name, curves): &(&str, [Curve; 4])| -> Series {
                ((*name).to_owned(), curves[n].clone())
            };
            Panel::over_time(title, runs.iter().map(series).collect())
        })
        .collect();
    if let Some(out) = std::env::args_os().nth(1) {
        plot_panels(
            &PathBuf::from(out),
            "motors of two belts: a square and its diagonal",
            &panels,
        )?;
    }
    Ok(())
}
