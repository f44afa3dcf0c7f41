//! Random programs and machines for the property tests.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use splineway_host::machine::{Axis, Machine};
use splineway_host::program::{Course, Move, Point, Program, Speed};
use std::collections::BTreeMap;

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
