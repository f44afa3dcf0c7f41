//! The agreed motion made faster while it runs: every path is faster and judged clean, and an operator who presses whatever he likes, while
//! plans come late, finds limits and band kept in every cycle.

#[path = "common/cycles.rs"]
#[allow(dead_code)] // A part of it is for other tests.
mod cycles;

use cycles::{Between, Draw, at, soak};
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Limits, Link, Progress, PushError, Reshaping,
    Scalar, Setpoint,
};
use splineway_simulator::judge::{judged, violations};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::poly;
use splineway_simulator::run::{Events, Precision};
use splineway_studies::paths;

/// By how much every path is faster at least, as a share of its time without.
const FASTER: [(&str, f64, f64); 8] = [
    ("zigzag90", 0.05, 0.02),
    ("zigzag90", 0.01, 0.018),
    ("star", 0.01, 0.025),
    ("butterfly80", 0.05, 0.07),
    ("butterfly2000", 0.05, 0.03),
    ("gear", 0.05, 0.07),
    ("guilloche", 0.05, 0.035),
    ("walk", 0.05, 0.06),
];

/// Without a limit broken, and faster.
#[test]
fn every_path_is_faster_and_clean() {
    let made = paths::all().unwrap();
    for (name, tolerance, share) in FASTER {
        let path = made
            .iter()
            .find(|path| path.name == name && (path.tolerance - tolerance).abs() < 1.0e-9)
            .unwrap();
        let program = poly::parse(&path.text()).unwrap();
        let mut machine = Machine::default();
        machine.apply(program.header.as_ref().unwrap());
        machine.lookahead = 256;
        let time = |reshape: bool, precision: Precision| {
            let machine = Machine { reshape, ..machine.clone() };
            let (verdict, _) = judged(&program, &machine, precision, &Events::default()).unwrap();
            let broken = violations(&verdict);
            assert!(broken.is_empty(), "{name} {tolerance} {precision:?}: {broken:?}");
            verdict.time
        };
        let (before, after) = (time(false, Precision::F64), time(true, Precision::F64));
        assert!(after < before * (1.0 - share), "{name} {tolerance}: {before} s, {after} s");
        let single = time(true, Precision::F32);
        assert!(
            (single - after).abs() < 0.015 * after,
            "{name} {tolerance}: {after} s, {single} s"
        );
    }
}

const BLOCKS: usize = 64;
const NODES: usize = 256;
const CYCLE: f64 = 1.0e-3;
const FEED: f64 = 200.0;

/// A path of lines of some kind: corners, short ones that hardly turn, noise, all sizes, and runs that turn back at times.
fn path(draw: &mut Draw) -> Vec<[f64; 3]> {
    let kind = draw.between(0.0, 5.0) as u32;
    let (size, mut heading) = (draw.scale(0.05, 5.0), draw.between(0.0, 6.3));
    let mut points = vec![[0.0; 3]];
    for _ in 0..draw.between(20.0, 300.0) as u32 {
        let (length, turn) = match kind {
            0 => (draw.between(0.5, 10.0), draw.between(-3.0, 3.0)),
            1 => (size, 0.1),
            2 => (size * draw.between(0.1, 1.0), draw.between(-0.5, 0.5)),
            3 => (0.1 + 3.0 * draw.share().powi(3), draw.between(-1.5, 1.5)),
            _ if draw.chance(0.2) => (draw.between(1.0, 6.0), draw.between(0.0, 3.1)),
            _ => (draw.between(1.0, 6.0), draw.between(-0.1, 0.1)),
        };
        heading += turn;
        let rise = if draw.chance(0.1) { draw.between(-0.5, 0.5) * length } else { 0.0 };
        let [x, y, z] = points[points.len() - 1];
        points.push([x + length * heading.cos(), y + length * heading.sin(), z + rise]);
    }
    points
}

/// Presses something.
fn press(draw: &mut Draw, controls: Controls<'_>, aborts: bool) {
    match draw.between(0.0, 8.0) as u32 {
        0 | 1 => controls.hold(),
        2 => controls.stop(),
        3 => controls.feed_override([10, 50, 80, 120, 150][draw.between(0.0, 5.0) as usize]),
        4 => controls.feed_override(100),
        5 if aborts => controls.abort(),
        _ => controls.resume(),
    }
}

/// The line in which a place may be, from one on: the first whose band it is in.
fn line_of(points: &[[f64; 3]], from: usize, band: f64, x: [f64; 3]) -> Option<usize> {
    (from..points.len() - 1).find(|&q| {
        let (a, b) = (points[q], points[q + 1]);
        let way = [0, 1, 2].map(|i| b[i] - a[i]);
        let length = way.iter().map(|w| w * w).sum::<f64>();
        let along = (0..3).map(|i| (x[i] - a[i]) * way[i]).sum::<f64>() / length.max(1.0e-12);
        let along = along.clamp(0.0, 1.0);
        (0..3).map(|i| (x[i] - a[i] - along * way[i]).powi(2)).sum::<f64>() <= band * band
    })
}

/// Runs a random path with an operator, planning `pace` slices in a cycle in the mean.
fn operate<S: Scalar>(case: u64) {
    let mut draw = Draw(case.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    for _ in 0..5 {
        draw.share();
    }
    let points = path(&mut draw);
    let tolerance = [0.05, 0.01, 0.02, 0.1][draw.between(0.0, 4.0) as usize];
    let axis = AxisLimits::linear(
        FEED,
        [2000.0, 1000.0, 5000.0][draw.between(0.0, 3.0) as usize],
        [5.0e4, 2.0e4, 1.0e5][draw.between(0.0, 3.0) as usize],
    );
    let of = |axis: AxisLimits<f64>| {
        AxisLimits::linear(S::of(axis.velocity), S::of(axis.acceleration), S::of(axis.jerk))
    };
    let mut config = Config::<S, 3>::new(Limits::new([of(axis); 3]).unwrap());
    config.tolerance = S::of(tolerance);
    config.cycle = S::of(CYCLE);
    let feed = [200.0, 100.0, 60.0, 20.0][draw.between(0.0, 4.0) as usize];
    let pace = [1.0e3, 20.0, 5.0, 2.0][draw.between(0.0, 4.0) as usize];
    let busy = [0.0, 0.002, 0.01, 0.03][draw.between(0.0, 4.0) as usize];
    let aborts = draw.chance(0.1);
    // A block in some is slower, and planning pauses at times, as under other work.
    let (slower, pauses) = (draw.chance(0.5), draw.chance(0.3));
    let feeds: Vec<f64> = points
        .iter()
        .map(|_| if slower && draw.chance(0.3) { feed * draw.between(0.1, 1.0) } else { feed })
        .collect();
    let mut paused = 0;
    let place = |point: &[f64; 3]| point.map(at);
    let mut memory = Box::new(Reshaping::<S, 3>::new());
    let mut link = Box::new(Link::<S, 3, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator) = link.split(config, place(&points[0])).unwrap();
    planner.reshape(&mut memory);
    let controls = planner.controls();
    let (mut next, mut line, mut slices) = (1, 0, 0.0f64);
    let mut before: Option<Setpoint<S, 3>> = None;
    let band = tolerance * if S::NAME == "f32" { 1.001 } else { 1.000_01 };
    // Nobody presses anything at the end, so that there is one.
    let last = points.len() as u32 * 40;
    for cycle in 0..2_000_000u32 {
        if cycle < last && draw.share() < busy {
            press(&mut draw, controls, aborts);
        } else if cycle == last {
            controls.feed_override(100);
            controls.resume();
        }
        slices = (slices + pace * draw.between(0.5, 1.5)).min(2.0 * pace);
        if pauses && draw.chance(0.003) {
            paused = draw.between(10.0, 150.0) as u32;
        }
        if paused > 0 {
            (paused, slices) = (paused - 1, 0.0);
        }
        let mut progress = Progress::Waiting;
        while slices >= 1.0 {
            while next < points.len() {
                match planner.push(&Block::line(
                    place(&points[next]),
                    S::of(feeds[next]),
                    next as u32,
                )) {
                    Ok(()) => next += 1,
                    Err(PushError::Full | PushError::Aborted) => break,
                    Err(error) => panic!("case {case}: {error}"),
                }
            }
            if next == points.len() {
                planner.finish();
            }
            progress = planner.poll();
            slices -= 1.0;
            if !matches!(progress, Progress::Planning | Progress::Planned) {
                slices = 0.0;
            }
        }
        let setpoint = interpolator.tick();
        if let Some(from) = before.replace(setpoint) {
            Between { from, to: setpoint, cycle: CYCLE }.check(&config, false);
        }
        let x = [0, 1, 2].map(|i| setpoint.position(i).to_mm());
        let found = line_of(&points, line, band, x);
        assert!(found.is_some(), "case {case}, cycle {cycle}: off the path at line {line}");
        line = found.unwrap_or(line);
        let rests = setpoint.activity == Activity::Idle;
        if progress == Progress::Aborted && rests {
            return;
        }
        if progress == Progress::Done && rests && cycle > last.min(1) {
            let end = points[points.len() - 1];
            let off = (0..3).map(|i| (x[i] - end[i]).abs()).fold(0.0, f64::max);
            assert!(off < 1.0e-5, "case {case}: ends {off} mm off");
            assert_eq!(setpoint.tag as usize, points.len() - 1, "case {case}: block at the end");
            return;
        }
    }
    panic!("case {case}: no end: {:?}", planner.counters());
}

#[test]
fn an_operator_finds_limits_and_band_kept() {
    for case in 0..u64::from(40 * soak()) {
        operate::<f64>(case);
    }
}

#[test]
fn an_operator_finds_limits_and_band_kept_in_f32() {
    for case in 0..u64::from(20 * soak()) {
        operate::<f32>(case);
    }
}

/// What is not for reshaping is run as without it, to the last bit.
#[test]
fn where_it_does_nothing_nothing_changes() {
    let run = |nodes_for_it: bool, memory: &mut Reshaping<f64, 3>| {
        let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
        let config = Config::<f64, 3>::new(Limits::new([axis; 3]).unwrap());
        // Too small a window.
        let mut link = Box::new(Link::<f64, 3, 16, 64>::new());
        let (mut planner, mut interpolator) = link.split(config, [at(0.0); 3]).unwrap();
        if nodes_for_it {
            planner.reshape(memory);
        }
        let mut next = 1;
        let mut list = Vec::new();
        loop {
            while next <= 60 {
                let to = [at(f64::from(next)), at(f64::from(next * next % 7)), at(0.0)];
                match planner.push(&Block::line(to, 100.0, next as u32)) {
                    Ok(()) => next += 1,
                    Err(_) => break,
                }
            }
            if next > 60 {
                planner.finish();
            }
            let progress = planner.settle();
            let setpoint = interpolator.tick();
            list.push([0, 1, 2].map(|i| setpoint.position(i).raw()));
            if progress == Progress::Done && setpoint.activity == Activity::Idle {
                return list;
            }
        }
    };
    let mut memory = Box::new(Reshaping::new());
    assert_eq!(run(true, &mut memory), run(false, &mut memory));
}

/// The true speed over a cell exceeds the greatest path speed by no more than is said where cells are made, and those that are no longer
/// straight by what their length is known to.
const SWIFTER: f64 = 1.004;

/// Random bent short lines at a low feed, and at overrides of it.
fn keeps_a_feed_that_binds<S: Scalar>(case: u64) {
    let mut draw = Draw(case.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let axis = AxisLimits::linear(
        S::of(FEED),
        S::of([2000.0, 1000.0, 5000.0][draw.between(0.0, 3.0) as usize]),
        S::of([5.0e4, 2.0e4, 1.0e5][draw.between(0.0, 3.0) as usize]),
    );
    let mut config = Config::<S, 3>::new(Limits::new([axis; 3]).unwrap());
    config.tolerance = S::of([0.02, 0.05, 0.1][draw.between(0.0, 3.0) as usize]);
    config.cycle = S::of(CYCLE);
    let (size, turn) = (draw.between(0.2, 4.0), draw.between(0.2, 1.8));
    let (mut points, mut heading) = (vec![[0.0; 3]], 0.0f64);
    for k in 0..150 {
        let length = draw.between(0.05, size);
        let [x, y, z] = points[k];
        points.push([x + length * heading.cos(), y + length * heading.sin(), z]);
        heading += draw.between(-turn, turn);
    }
    let feed = draw.between(2.0, 20.0);
    let place = |point: &[f64; 3]| point.map(at);
    let mut memory = Box::new(Reshaping::<S, 3>::new());
    let mut link = Box::new(Link::<S, 3, 256, NODES>::new());
    let (mut planner, mut interpolator) = link.split(config, place(&points[0])).unwrap();
    planner.reshape(&mut memory);
    let controls = planner.controls();
    let (mut next, mut change) = (1, 100);
    for cycle in 0..2_000_000u32 {
        if cycle == change && cycle < 10_000 {
            controls.feed_override([10, 50, 80, 100, 120, 150][draw.between(0.0, 6.0) as usize]);
            change += draw.between(40.0, 900.0) as u32;
        }
        while next < points.len()
            && planner.push(&Block::line(place(&points[next]), S::of(feed), next as u32)).is_ok()
        {
            next += 1;
        }
        if next == points.len() {
            planner.finish();
        }
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        let speed = setpoint.velocity.map(S::to_f64).iter().map(|v| v * v).sum::<f64>().sqrt();
        let path_speed = setpoint.path_speed.to_f64();
        // Beside a speed that changes much the greatest over the cell is another.
        let near = path_speed > 0.9 * feed;
        assert!(
            !near || speed <= path_speed * SWIFTER,
            "case {case}, cycle {cycle}: {speed} mm/s, {path_speed} of the path"
        );
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            return;
        }
    }
    panic!("case {case}: no end");
}

#[test]
fn a_feed_that_binds_is_kept_by_the_true_speed() {
    for case in 0..u64::from(24 * soak()) {
        keeps_a_feed_that_binds::<f64>(case);
        keeps_a_feed_that_binds::<f32>(case + 1000);
    }
}
