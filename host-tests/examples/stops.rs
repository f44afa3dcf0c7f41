//! One line by three sets of limits: a hold, a quick hold, and a calm stretch in the middle: position, velocity, acceleration
//! and jerk, as a plot.
//!
//! `cargo run --release -p splineway-host --example stops -- docs/stops.svg`

use anyhow::{Result, anyhow};
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Interpolator, Limits, Link, Planner,
    Progress,
};
use splineway_host::view::{Panel, Series, plot_panels};
use std::path::PathBuf;

/// s.
const CYCLE: f64 = 1.0e-3;
/// Servo cycle in which the operator presses.
const PRESSED: u32 = 400;
/// Ends of the three blocks, mm.
const ENDS: [f64; 3] = [30.0, 50.0, 80.0];
/// mm/s.
const FEED: f64 = 100.0;

type Core<'a> = (Planner<'a, f64, 1>, Interpolator<'a, f64, 1>);
type Curve = Vec<(f64, f64)>;

fn limits(velocity: f64, acceleration: f64, jerk: f64) -> Result<Limits<f64, 1>> {
    Ok(Limits::new([AxisLimits::linear(velocity, acceleration, jerk)])?)
}

/// Position, velocity, acceleration and jerk over time.
fn run(calm: bool, press: Option<fn(Controls<'_>)>) -> Result<[Curve; 4]> {
    let usual = limits(200.0, 1000.0, 2.0e4)?;
    let mut config = Config::new(usual);
    config.cycle = CYCLE;
    config.stop_limits = Some(limits(200.0, 4000.0, 2.0e5)?);
    let mut link = Box::new(Link::<f64, 1>::new());
    let (mut planner, mut interpolator): Core<'_> = link.split(config, [Coord::ZERO])?;
    for (end, tag) in ENDS.into_iter().zip(1..) {
        let middle = calm && tag == 2;
        planner.set_limits(if middle { limits(40.0, 300.0, 1.0e4)? } else { usual })?;
        planner.push(&Block::line([Coord::from_mm(end)?], FEED, tag))?;
    }
    planner.finish();
    let mut curves: [Curve; 4] = Default::default();
    let mut before = 0.0;
    for cycle in 0..5000 {
        if let Some(press) = press.filter(|_| cycle == PRESSED) {
            press(planner.controls());
        }
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        let (time, acceleration) = (f64::from(cycle) * CYCLE, setpoint.acceleration[0]);
        let jerk = (acceleration - before) / CYCLE;
        before = acceleration;
        let values = [setpoint.position_mm(0), setpoint.velocity[0], acceleration, jerk];
        for (curve, value) in curves.iter_mut().zip(values) {
            curve.push((time, value));
        }
        let over = matches!(progress, Progress::Done | Progress::Held);
        if over && setpoint.activity == Activity::Idle && cycle > PRESSED {
            return Ok(curves);
        }
    }
    Err(anyhow!("the machine does not come to rest"))
}

fn hold(controls: Controls<'_>) {
    controls.hold();
}

fn quick_hold(controls: Controls<'_>) {
    controls.quick_hold();
}

fn main() -> Result<()> {
    let runs = [
        ("hold", run(false, Some(hold))?),
        ("quick hold", run(false, Some(quick_hold))?),
        ("calm from 30 to 50 mm", run(true, None)?),
    ];
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
        plot_panels(&PathBuf::from(out), "one line, three sets of limits", &panels)?;
    }
    Ok(())
}
