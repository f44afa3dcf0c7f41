//! An axis with a mass on a spring, with and without input shaping: position, velocity, acceleration and jerk of what it is given, and
//! how the mass swings, as a plot; and a table of what each shaper leaves and costs.
//!
//! `cargo run --release -p splineway-host --example shaping -- docs/shaping.svg`

use anyhow::{Result, anyhow};
use splineway::output::{Shape, Shaper, ShaperKind};
use splineway::{Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress};
use splineway_host::view::{Panel, Series, plot_panels};
use std::path::PathBuf;

/// s.
const CYCLE: f64 = 1.0e-3;
/// Of the mass, Hz; its damping ratio.
const FREQUENCY: f64 = 45.0;
const DAMPING: f64 = 0.05;
/// mm.
const TOLERANCE: f64 = 0.05;
/// How long the mass is watched after the end, s.
const AFTER: f64 = 0.3;
/// Steps of its integration in a servo cycle.
const STEPS: u32 = 50;

type Kind = Option<ShaperKind>;
type Point = [f64; 2];

const KINDS: [(&str, Kind); 5] = [
    ("none", None),
    ("ZV", Some(ShaperKind::Zv)),
    ("MZV", Some(ShaperKind::Mzv)),
    ("EI", Some(ShaperKind::Ei)),
    ("smooth", Some(ShaperKind::Smooth)),
];

/// What the machine is given in a servo cycle: position, velocity and acceleration of both axes.
type Given = [[f64; 3]; 2];

/// Runs lines through points; returns what the axes are given, and how many cycles until they rest.
fn run(points: &[Point], feed: f64, acceleration: f64, kind: Kind) -> Result<(Vec<Given>, usize)> {
    let axis = AxisLimits::linear(300.0, acceleration, 200.0 * acceleration);
    let mut config = Config::new(Limits::new([axis; 2])?);
    config.cycle = CYCLE;
    config.tolerance = TOLERANCE;
    let shape = kind.map(|kind| Shape { kind, frequency: FREQUENCY, damping: DAMPING });
    let mut shaper = Shaper::<f64, 2, 64>::new();
    shaper.set([shape; 2], &config)?;
    config.follower = shaper.follower(&config);
    let mut link = Box::new(Link::<f64, 2, 64, 192>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 2])?;
    let mut left = points.iter().peekable();
    let mut given = Vec::new();
    for _ in 0..1_000_000 {
        while let Some([x, y]) = left.peek() {
            let to = [Coord::from_mm(*x)?, Coord::from_mm(*y)?];
            if planner.push(&Block::line(to, feed, 1)).is_err() {
                break;
            }
            left.next();
        }
        if left.peek().is_none() {
            planner.finish();
        }
        let progress = planner.settle();
        let at = shaper.shape(&interpolator.tick());
        given.push([0, 1].map(|i| [at.position_mm(i), at.velocity[i], at.acceleration[i]]));
        if progress == Progress::Done && at.activity == Activity::Idle {
            let ends = given.len();
            given.extend(std::iter::repeat_n(given[ends - 1], (AFTER / CYCLE) as usize));
            return Ok((given, ends));
        }
    }
    Err(anyhow!("the machine does not come to rest"))
}

/// How a mass on an axis swings about it, mm, at the end of every servo cycle.
fn swing(given: &[Given], axis: usize, frequency: f64) -> Vec<f64> {
    let natural = 2.0 * std::f64::consts::PI * frequency / (1.0 - DAMPING * DAMPING).sqrt();
    let (mut off, mut speed) = (0.0, 0.0);
    let h = CYCLE / f64::from(STEPS);
    given
        .windows(2)
        .map(|two| {
            let [before, now] = [two[0][axis][2], two[1][axis][2]];
            for step in 0..STEPS {
                // The axis accelerates under it.
                let part = (f64::from(step) + 0.5) / f64::from(STEPS);
                let pull = -natural * natural * off - 2.0 * DAMPING * natural * speed;
                speed += h * (pull - before - (now - before) * part);
                off += h * speed;
            }
            off
        })
        .collect()
}

/// How far the mass swings after the end, mm.
fn left(given: &[Given], ends: usize, frequency: f64) -> f64 {
    let swings = [0, 1].map(|axis| swing(given, axis, frequency));
    (ends..swings[0].len()).map(|n| swings[0][n].hypot(swings[1][n])).fold(0.0, f64::max)
}

/// A path of right angles, and one of short lines.
fn paths() -> [(&'static str, Vec<Point>); 3] {
    let stairs = (1..=40).map(|n| [f64::from(n / 2) * 5.0, f64::from((n + 1) / 2) * 5.0]);
    let rose = (1..=1500).map(|n| {
        let turn = f64::from(n) / 1500.0 * 2.0 * std::f64::consts::PI;
        let radius = 20.0 * (4.0 * turn).sin();
        [radius * turn.cos(), radius * turn.sin()]
    });
    [
        ("line of 50 mm", vec![[50.0, 0.0]]),
        ("stairs of 5 mm", stairs.collect()),
        ("rose", rose.collect()),
    ]
}

fn main() -> Result<()> {
    println!(
        "| shaper | left of a line at {FREQUENCY} Hz, um | at 0.9 of it | at 1.1 | behind, ms | line, s | stairs, s | rose, s | the same at 8,000 mm/s2: line, s | stairs, s | rose, s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, kind) in KINDS {
        let [line, ..] = paths();
        let (given, ends) = run(&line.1, 100.0, 2000.0, kind)?;
        let [exact, low, high] =
            [1.0, 0.9, 1.1].map(|of| left(&given, ends, of * FREQUENCY) * 1000.0);
        print!("| {name} | {exact:.1} | {low:.1} | {high:.1} ");
        let shape = kind.map(|kind| Shape { kind, frequency: FREQUENCY, damping: DAMPING });
        let axis = AxisLimits::linear(300.0, 2000.0, 4.0e5);
        let config = Config::new(Limits::new([axis])?);
        let mut shaper = Shaper::<f64, 1, 64>::new();
        shaper.set([shape], &config)?;
        print!("| {:.1} ", shaper.delay() * 1000.0);
        for acceleration in [2000.0, 8000.0] {
            for (_, points) in paths() {
                let (_, ends) = run(&points, 100.0, acceleration, kind)?;
                print!("| {:.3} ", ends as f64 * CYCLE);
            }
        }
        println!("|");
    }
    let Some(out) = std::env::args_os().nth(1) else { return Ok(()) };
    let line = &paths()[0].1;
    let mut series: [Vec<Series>; 5] = Default::default();
    for (name, kind) in [KINDS[0], KINDS[1], KINDS[4]] {
        let (given, _) = run(line, 100.0, 2000.0, kind)?;
        let time = |n: usize| n as f64 * CYCLE;
        for (k, series) in series.iter_mut().enumerate().take(3) {
            let curve = given.iter().enumerate().map(|(n, at)| (time(n), at[0][k]));
            series.push((name.to_owned(), curve.collect()));
        }
        let jerk = given.windows(2).enumerate();
        let jerk = jerk.map(|(n, two)| (time(n), (two[1][0][2] - two[0][0][2]) / CYCLE));
        series[3].push((name.to_owned(), jerk.collect()));
        let swing = swing(&given, 0, FREQUENCY).into_iter().enumerate();
        series[4].push((name.to_owned(), swing.map(|(n, off)| (time(n), off)).collect()));
    }
    let titles = [
        "position, mm",
        "velocity, mm/s",
        "acceleration, mm/s2",
        "jerk, mm/s3",
        "mass of 45 Hz beside the axis, mm",
    ];
    let panels: Vec<Panel> = titles
        .into_iter()
        .zip(series)
        .map(|(title, series)| Panel::over_time(title, series))
        .collect();
    plot_panels(&PathBuf::from(out), "one line, with and without input shaping", &panels)?;
    Ok(())
}
