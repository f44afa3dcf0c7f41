//! Never slower than stopping: a program takes no longer than with an exact stop after every block.

mod common;

use common::{Draw, Stretch, dense, machine, poly_line, program, soak, watched};
use fastrand::Rng;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Program, Speed};
use splineway_simulator::run::Precision;

fn time(program: &Program, machine: &Machine, precision: Precision) -> f64 {
    watched(program, machine, precision).time
}

/// Time over the time with an exact stop after every block; starts and ends fall on whole cycles.
fn against_stops(program: &Program, machine: &Machine, precision: Precision) -> f64 {
    let mut stopped = program.clone();
    for step in &mut stopped.moves {
        step.exact_stop = true;
    }
    let stops = time(&stopped, machine, precision);
    (time(program, machine, precision) - 3.0 * machine.cycle) / stops
}

/// What was slower once: steps in mm, feed in mm/s.
#[test]
fn slow_feeds_and_tiny_lines() {
    type Steps = &'static [([f64; 3], f64)];
    let cases: [(&str, f64, Steps); 5] = [
        (
            "a run ends at a slow feed: its last cells as long as those of its fast start",
            0.09,
            &[([-0.0013, 0.0002, 0.0001], 158.138), ([0.0296, 0.0303, 0.0219], 0.857)],
        ),
        (
            "the same, longer",
            0.0427,
            &[([0.0437, -0.0043, -0.0221], 54.742), ([0.0208, 0.0091, -0.0056], 0.652)],
        ),
        (
            "a corner that takes the whole line from rest, whose feed is reached in less than a cell",
            0.1692,
            &[([-0.0685, 0.0845, 0.0572], 0.614), ([-0.2166, -0.2038, -0.3575], 45.684)],
        ),
        (
            "a run that goes on from a tiny corner in one cell of half a long line",
            0.0071,
            &[
                ([0.0004, -0.0022, -0.0006], 0.664),
                ([0.8590, -5.4876, -1.3926], 385.023),
                ([0.0070, 0.0229, -0.0107], 161.328),
                ([4.9747, -17.2096, 0.4468], 89.599),
                ([0.0031, 0.0013, -0.0031], 199.761),
            ],
        ),
        (
            "where the feed changes in a run, the place gives way by the width of the band",
            0.4135,
            &[
                ([-0.0369, 0.0740, 0.0924], 1.202),
                ([0.0069, -0.0006, 0.0054], 136.669),
                ([-0.0015, 0.0073, 0.0069], 0.799),
                ([-0.0008, 0.0008, 0.0003], 70.787),
                ([-0.1491, 0.0756, 0.0012], 0.759),
            ],
        ),
    ];
    for (what, tolerance, steps) in cases {
        let mut at = [0.0; 3];
        let points: Vec<_> = steps
            .iter()
            .map(|(step, feed)| {
                for (x, step) in at.iter_mut().zip(step) {
                    *x += step;
                }
                (at, *feed)
            })
            .collect();
        for precision in [Precision::F64, Precision::F32] {
            let machine = machine(tolerance, (1.0, 1.0), 3);
            let ratio = against_stops(&poly_line(&points), &machine, precision);
            assert!(ratio <= 1.005, "{what}: {ratio} in {precision:?}");
        }
    }
}

/// A random program on a random machine.
fn case(number: u64) -> (Program, Machine, Precision) {
    let mut rng = Rng::with_seed(number);
    let axes = [3, 3, 6][rng.usize(..3)];
    let single = rng.bool();
    let scale = |rng: &mut Rng| if single { 1.0 } else { 10f64.powf(2.0 * rng.f64() - 1.0) };
    let scale = (scale(&mut rng), scale(&mut rng));
    let tolerance = 10f64.powf(-2.5 + 2.5 * rng.f64());
    let precision = if single { Precision::F32 } else { Precision::F64 };
    if rng.bool() {
        let count = rng.usize(1..12);
        let stretches: Vec<_> = (0..count).map(|_| Stretch::any(&mut rng)).collect();
        return (dense(&stretches), machine(tolerance, scale, 3), precision);
    }
    let count = rng.usize(1..20);
    let draws: Vec<_> = (0..count).map(|_| Draw::any(&mut rng, axes)).collect();
    let used: Vec<usize> = (0..axes).collect();
    (program(&draws, &used), machine(tolerance, scale, axes), precision)
}

fn count(least: u64) -> u64 {
    least * u64::from(soak())
}

#[test]
fn random_programs() {
    for number in 0..count(300) {
        let (program, machine, precision) = case(number);
        let ratio = against_stops(&program, &machine, precision);
        assert!(ratio <= 1.005, "case {number}: {ratio} of the time with stops");
    }
}

/// What is eased: each must not cost time.
const EASED: [&str; 4] = ["tolerance", "acceleration and jerk", "velocity", "feed"];

/// The program and the machine with one of them greater.
fn eased(program: &Program, machine: &Machine, what: usize, by: f64) -> (Program, Machine) {
    let (mut program, mut machine) = (program.clone(), machine.clone());
    match what {
        0 => machine.tolerance *= by,
        1 => machine.axes.values_mut().for_each(|axis| {
            axis.acceleration *= by;
            axis.jerk *= by;
        }),
        2 => machine.axes.values_mut().for_each(|axis| axis.velocity *= by),
        _ => {
            for step in &mut program.moves {
                if let Speed::PerSecond(feed) = &mut step.speed {
                    *feed *= by;
                }
            }
        }
    }
    (program, machine)
}

/// A greater tolerance, limit or feed costs no time: more than a per cent, and what starts and ends on whole
/// cycles make of it, in one pair of thirty at most. (Where circles of short lines are hardly wider than the band,
/// other vertices are left out of them, and the spline that is left may be a worse one.)
#[test]
fn more_is_not_slower() {
    let (mut pairs, mut slower) = (0, Vec::new());
    for number in 0..count(150) {
        let (program, mut machine, precision) = case(number);
        machine.tolerance = machine.tolerance.min(0.02);
        let whole = time(&program, &machine, precision);
        for (what, name) in EASED.iter().enumerate() {
            let by = [1.1, 1.5, 4.0][number as usize % 3];
            let (eased, easier) = eased(&program, &machine, what, by);
            let ratio = (time(&eased, &easier, precision) - 3.0 * machine.cycle) / whole;
            pairs += 1;
            if ratio > 1.01 {
                slower.push((number, name, by, ratio));
            }
        }
    }
    println!("{} of {pairs} slower: {slower:?}", slower.len());
    assert!(slower.len() * 30 <= pairs, "{} of {pairs} slower: {slower:?}", slower.len());
    assert!(slower.iter().all(|(.., ratio)| *ratio < 2.0), "{slower:?}");
}
