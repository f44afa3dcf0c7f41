//! Dense programs: runs of short lines as one spline, against every limit.

mod common;

use common::{check, config, dense, judged, machine, poly_line, stretches};
use proptest::prelude::*;
use splineway_simulator::machine::{Axis, Machine};
use splineway_simulator::program::Program;
use splineway_simulator::run::{Events, Observer, Precision, Sample, run};
use std::f64::consts::TAU;

/// Time of a program, of which nothing may be broken or lost.
fn time(program: &Program, machine: &Machine, precision: Precision) -> Result<f64, TestCaseError> {
    let (verdict, stats) = check(program, machine, precision)?;
    prop_assert_eq!(stats.blocks, program.moves.len() as u64);
    Ok(verdict.time)
}

proptest! {
    #![proptest_config(config(600))]

    #[test]
    fn any_dense_program_in_f64(
        stretches in stretches(1..10),
        tolerance in (-3.0f64..0.0).prop_map(|e| 10f64.powf(e)),
        scale in ((-1.0f64..1.0).prop_map(|e| 10f64.powf(e)), (-1.0f64..1.0).prop_map(|e| 10f64.powf(e))),
        sweeps in 0u16..12,
    ) {
        let machine = Machine { sweeps, ..machine(tolerance, scale, 3) };
        time(&dense(&stretches), &machine, Precision::F64)?;
    }
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn any_dense_program_in_f32(
        stretches in stretches(1..10),
        tolerance in (-2.5f64..-0.5).prop_map(|e| 10f64.powf(e)),
    ) {
        time(&dense(&stretches), &machine(tolerance, (1.0, 1.0), 3), Precision::F32)?;
    }
}

fn common_machine(tolerance: f64) -> Machine {
    let axis = Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 };
    Machine { tolerance, axes: [("default".to_owned(), axis)].into(), ..Machine::default() }
}

fn circle(radius: f64, chords: u32, feed: f64) -> Vec<([f64; 3], f64)> {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(chords);
    (1..=chords)
        .map(|k| ([radius * angle(k).sin(), radius * (1.0 - angle(k).cos()), 0.0], feed))
        .collect()
}

/// Thesis test case 5: points off a line by less than the tolerance are ironed out.
#[test]
fn noise_within_the_band_costs_nothing() {
    let feed = 200.0;
    let noise = [0.03, -0.02, 0.035, -0.035, 0.01, -0.03, 0.025, 0.0, -0.03, 0.03];
    let noisy: Vec<_> = (1..=200)
        .map(|k| {
            let off = if k == 200 { 0.0 } else { noise[k % noise.len()] };
            ([0.5 * k as f64, off, 0.0], feed)
        })
        .collect();
    let machine = common_machine(0.05);
    let plain = time(&poly_line(&[([100.0, 0.0, 0.0], feed)]), &machine, Precision::F64).unwrap();
    let noisy = time(&poly_line(&noisy), &machine, Precision::F64).unwrap();
    assert!(noisy < 1.03 * plain, "{noisy} s, the straight line {plain} s");
}

/// Sweeps pay, and none at all is a path inside the band too.
#[test]
fn every_number_of_sweeps_is_inside_and_more_are_faster() {
    let wave: Vec<_> = (1..=400)
        .map(|k| {
            let x = 0.2 * f64::from(k);
            let y =
                1.5 * (0.9 * x).sin() + 0.4 * (2.7 * x).sin() + if k % 3 == 0 { 0.02 } else { 0.0 };
            ([x, y, 0.0], 200.0)
        })
        .collect();
    let times = [0, 1, 2, 4, 8, 16].map(|sweeps| {
        let machine = Machine { sweeps, ..common_machine(0.03) };
        time(&poly_line(&wave), &machine, Precision::F64).unwrap()
    });
    assert!(times[4] < 0.8 * times[0] && times[5] < 1.01 * times[4], "{times:?}");
}

/// As many lines as one likes make as many cells as the curve needs.
#[test]
fn cells_follow_the_curve_and_not_the_lines() {
    let cells = [600, 6000, 60_000].map(|chords| {
        let program = poly_line(&circle(10.0, chords, 100.0));
        judged(&program, &common_machine(0.02), Precision::F64, &Events::default()).1.counters.cells
    });
    assert!(cells[0] < 150 && cells[1] < 150 && cells[2] < 300, "{cells:?}");
}

/// The speed along the path, by differences of positions.
#[derive(Default)]
struct Feed {
    last: Option<Vec<f64>>,
    speeds: Vec<f64>,
    way: f64,
    arc: f64,
}

impl Observer for Feed {
    fn setpoint(&mut self, sample: &Sample<'_>) -> anyhow::Result<()> {
        if let Some(last) = &self.last {
            let step: f64 = last.iter().zip(sample.position).map(|(a, b)| (a - b) * (a - b)).sum();
            self.speeds.push(step.sqrt() / 1.0e-3);
            self.way += step.sqrt();
        }
        self.last = Some(sample.position.to_vec());
        self.arc = sample.path;
        Ok(())
    }
}

/// On a circle whose limits allow the feed it is kept to a thousandth, and so is the arc length.
#[test]
fn the_feed_is_kept_on_a_circle() {
    let program = poly_line(&circle(20.0, 1257, 60.0));
    for precision in [Precision::F64, Precision::F32] {
        let mut feed = Feed::default();
        run(&program, &common_machine(0.01), precision, &mut [&mut feed]).unwrap();
        let n = feed.speeds.len();
        let middle = &feed.speeds[n / 10..n - n / 10];
        let least = middle.iter().copied().fold(f64::INFINITY, f64::min);
        let most = middle.iter().copied().fold(0.0, f64::max);
        println!("{precision:?}: {least} to {most} mm/s, arc length {} of {}", feed.arc, feed.way);
        assert!(most - least < 1.0e-3 * 60.0, "{least} to {most}");
        assert!(least > 0.997 * 60.0, "{least}");
        assert!((feed.arc - feed.way).abs() < 2.0e-5 * feed.way, "{} {}", feed.arc, feed.way);
    }
}

/// A tiny line in a corner, in a band much wider than it is long: the sweeps wound the spline up, and it
/// took half as long again as with stops. (Case 11371 of the soak.)
#[test]
fn a_wide_tube_does_not_wind_short_lines_up() {
    let program = poly_line(&[
        ([-3.696_684, -0.886_880, 2.952_774], 24.0),
        ([-3.695_671, -0.887_651, 2.953_774], 0.863),
        ([9.338_807, -10.595_932, 16.666_753], 238.0),
    ]);
    for tolerance in [0.01, 0.03, 0.1, 0.2, 0.38] {
        let (verdict, _) =
            check(&program, &machine(tolerance, (1.0, 1.0), 3), Precision::F64).unwrap();
        assert!(verdict.time < 0.55, "{tolerance} mm: {} s", verdict.time);
    }
}
