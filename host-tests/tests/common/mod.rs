//! Random programs and machines for the property tests.

#![allow(dead_code)] // Every test uses a part of it.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use splineway_host::machine::{Axis, Machine};
use splineway_host::program::{Course, Move, Point, Program, Speed};
use splineway_host::run::{
    Events, Judge, Observer, Precision, Sample, Stats, Track, Verdict, run_with,
};
use splineway_host::view::violations;
use std::collections::BTreeMap;

/// No program of the tests takes that long.
struct Patience;

impl Observer for Patience {
    fn setpoint(&mut self, sample: &Sample<'_>) -> anyhow::Result<()> {
        anyhow::ensure!(sample.time < 1000.0, "line {}: the run does not end", sample.tag);
        Ok(())
    }
}

/// Runs a program while an operator gives commands, and judges it.
pub fn judged(
    program: &Program,
    machine: &Machine,
    precision: Precision,
    events: &Events,
) -> (Verdict, Stats) {
    let limits = machine.axes_of(program).unwrap();
    let track = Track::new(program);
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
    let observers: &mut [&mut dyn Observer] = &mut [&mut judge, &mut Patience];
    let stats = run_with(program, machine, precision, events, observers).unwrap();
    (judge.verdict(), stats)
}

/// What a run has broken.
pub fn broken(
    verdict: &Verdict,
    program: &Program,
    machine: &Machine,
    precision: Precision,
) -> Vec<String> {
    let limits = machine.axes_of(program).unwrap();
    violations(verdict, precision, machine.cycle, machine.tolerance, &limits)
}

/// Runs a program without commands; nothing may be broken.
pub fn check(
    program: &Program,
    machine: &Machine,
    precision: Precision,
) -> Result<(Verdict, Stats), TestCaseError> {
    let (verdict, stats) = judged(program, machine, precision, &Events::default());
    let broken = broken(&verdict, program, machine, precision);
    prop_assert!(broken.is_empty(), "{broken:?}");
    Ok((verdict, stats))
}

/// One random move: kind, direction and size, feed, stop.
#[derive(Clone, Debug)]
pub struct Draw {
    pub kind: u8,
    pub step: Vec<f64>,
    pub size: f64,
    pub feed: f64,
    pub stop: bool,
    pub bend: f64,
}

pub fn draws(axes: usize, count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Draw>> {
    let one = (
        0u8..20,
        prop::collection::vec(-1.0f64..1.0, axes),
        // Lengths from a micrometre to 30 mm, all orders of magnitude alike.
        (-3.0f64..1.5).prop_map(|e| 10f64.powf(e)),
        (-0.5f64..2.6).prop_map(|e| 10f64.powf(e)),
        prop::bool::weighted(0.05),
        -2.5f64..2.5,
    )
        .prop_map(|(kind, step, size, feed, stop, bend)| Draw {
            kind,
            step,
            size,
            feed,
            stop,
            bend,
        });
    prop::collection::vec(one, count)
}

pub fn program(draws: &[Draw], axes: &[usize]) -> Program {
    let mut program = Program::default();
    for &axis in axes {
        program.uses[axis] = true;
    }
    let mut here: Point = [0.0; 9];
    for (n, draw) in draws.iter().enumerate() {
        let norm = draw.step.iter().map(|x| x * x).sum::<f64>().sqrt().max(0.1);
        let mut to = here;
        for (&axis, step) in axes.iter().zip(&draw.step) {
            to[axis] += step / norm * draw.size;
        }
        let path = match draw.kind {
            0 => Course::Dwell { seconds: draw.size.min(0.05) },
            // An arc or helix through `to`: the centre anywhere on the chord's bisector.
            1..=5 if (to[0] - here[0]).hypot(to[1] - here[1]) > 1e-3 => {
                let middle = (f64::midpoint(here[0], to[0]), f64::midpoint(here[1], to[1]));
                let chord = (to[0] - here[0], to[1] - here[1]);
                let centre = (middle.0 - chord.1 * draw.bend, middle.1 + chord.0 * draw.bend);
                Course::Arc {
                    to,
                    plane: (0, 1),
                    centre,
                    clockwise: draw.bend > 0.7,
                    extra_turns: 0,
                }
            }
            // Straight on, as dense programs go.
            6..=9 if n > 0 => {
                if let Some(Move { path: Course::Line { to: end }, .. }) = program.moves.last() {
                    let before = draws[n - 1].step.clone();
                    let size = before.iter().map(|x| x * x).sum::<f64>().sqrt().max(0.1);
                    to = *end;
                    for ((&axis, old), new) in axes.iter().zip(&before).zip(&draw.step) {
                        to[axis] += (old / size + 0.05 * new) * draw.size;
                    }
                }
                Course::Line { to }
            }
            // A curve, bent one way or the other, even back on itself.
            10..=11 => {
                let mut controls = [here, to];
                for (k, &axis) in axes.iter().enumerate() {
                    let across = draw.bend * draw.size * draw.step[(k + 1) % axes.len()];
                    controls[0][axis] += across;
                    controls[1][axis] += if draw.kind == 10 { across } else { -across };
                }
                Course::Cubic { controls, to }
            }
            _ => Course::Line { to },
        };
        if !matches!(path, Course::Dwell { .. }) {
            here = to;
        }
        program.moves.push(Move {
            path,
            // No move takes longer than a fifth of a second at its feed, or the tests would.
            speed: if draw.kind == 19 {
                Speed::Rapid
            } else {
                Speed::PerSecond(draw.feed.max(draw.size * 5.0))
            },
            tolerance: None,
            exact_stop: draw.stop,
            line: u32::try_from(n + 1).unwrap(),
        });
    }
    program
}

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
    Machine { tolerance, axes, lookahead: 16, ..Machine::default() }
}

/// The same cases in every run, so that a check is repeatable; `SOAK=20 cargo test --release --test
/// limits` draws twenty times as many new ones.
pub fn config(cases: u32) -> ProptestConfig {
    let soak = std::env::var("SOAK").ok().and_then(|factor| factor.parse::<u32>().ok());
    ProptestConfig {
        cases: cases * soak.unwrap_or(1),
        rng_seed: if soak.is_some() { RngSeed::Random } else { RngSeed::Fixed(2023) },
        failure_persistence: None,
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    }
}

/// A stretch of a dense program: kind, number of lines, their length and turn, and noise.
#[derive(Clone, Debug)]
pub struct Stretch {
    pub kind: u8,
    pub count: usize,
    pub size: f64,
    pub turn: f64,
    pub noise: f64,
    pub feed: f64,
}

pub fn stretches(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Stretch>> {
    let one = (
        0u8..10,
        1usize..40,
        // Lines from a tenth of a micrometre to 3 mm.
        (-4.0f64..0.5).prop_map(|e| 10f64.powf(e)),
        -0.6f64..0.6,
        (-4.0f64..0.0).prop_map(|e| 10f64.powf(e)),
        (0.5f64..2.4).prop_map(|e| 10f64.powf(e)),
    )
        .prop_map(|(kind, count, size, turn, noise, feed)| Stretch {
            kind,
            count,
            size,
            turn,
            noise,
            feed,
        });
    prop::collection::vec(one, count)
}

/// The corners of a poly-line as such programs have them.
pub fn dense(stretches: &[Stretch]) -> Program {
    let mut points: Vec<([f64; 3], f64)> = Vec::new();
    let (mut at, mut heading, mut climb) = ([0.0f64; 3], 0.0f64, 0.0f64);
    for stretch in stretches {
        let Stretch { kind, count, size, turn, noise, feed } = *stretch;
        let feed = feed.max(size * 5.0);
        let mut go = |heading: f64, climb: f64, size: f64| {
            at[0] += size * heading.cos() * climb.cos();
            at[1] += size * heading.sin() * climb.cos();
            at[2] += size * climb.sin();
            points.push((at, feed));
        };
        match kind {
            // Curves, also out of the plane.
            0..=2 => {
                for _ in 0..count {
                    heading += turn;
                    climb += if kind == 2 { 0.1 * turn } else { 0.0 };
                    go(heading, climb, size);
                }
            }
            // A straight line with noise.
            3 => {
                for k in 0..count {
                    let off = if k % 2 == 0 { noise.min(1.0) } else { -noise.min(1.0) };
                    go(heading + off, climb, size);
                }
            }
            // A spike there and back, and a reversal for good.
            4 => {
                go(heading + turn, climb, noise);
                go(heading + turn + std::f64::consts::PI, climb, noise);
                go(heading, climb, size);
            }
            5 => {
                heading += std::f64::consts::PI + turn * noise;
                go(heading, climb, size);
            }
            // The same point again and again; the tiniest lines.
            6 => (0..count).for_each(|_| go(heading, climb, 0.0)),
            7 => (0..count).for_each(|_| go(heading, climb, 2.0e-4)),
            // Ten thousand times as long.
            8 => go(heading + turn, climb, (size * 1.0e4).min(20.0)),
            // A closed loop.
            _ => {
                for _ in 0..12 {
                    heading += std::f64::consts::TAU / 12.0;
                    go(heading, climb, size);
                }
            }
        }
    }
    poly_line(&points)
}

/// A program of lines through points, each with its feed, mm/s, from the origin.
pub fn poly_line(points: &[([f64; 3], f64)]) -> Program {
    let mut program = Program::default();
    program.uses[..3].fill(true);
    for (n, (point, feed)) in points.iter().enumerate() {
        let mut to: Point = [0.0; 9];
        to[..3].copy_from_slice(point);
        program.moves.push(Move {
            path: Course::Line { to },
            speed: Speed::PerSecond(*feed),
            tolerance: None,
            exact_stop: false,
            line: u32::try_from(n + 1).unwrap(),
        });
    }
    program
}
