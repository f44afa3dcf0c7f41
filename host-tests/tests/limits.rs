//! Random block sequences against every limit, at every cycle, by finite differences.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use splineway_host::machine::{Axis, Machine, Mode};
use splineway_host::program::{Course, Move, Point, Program, Speed};
use splineway_host::run::{Judge, Precision, Track, Verdict, run};
use splineway_host::view::violations;
use std::collections::BTreeMap;

/// One random move: kind, direction and size, feed, stop.
#[derive(Clone, Debug)]
struct Draw {
    kind: u8,
    step: Vec<f64>,
    size: f64,
    feed: f64,
    stop: bool,
    bend: f64,
}

fn draws(axes: usize, count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Draw>> {
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

fn program(draws: &[Draw], axes: &[usize]) -> Program {
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

fn machine(tolerance: f64, scale: (f64, f64), axes: usize) -> Machine {
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

fn judge(program: &Program, machine: &Machine, precision: Precision) -> Verdict {
    let limits = machine.axes_of(program).unwrap();
    let track = Track::new(program);
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
    run(program, machine, precision, &mut [&mut judge]).unwrap();
    judge.verdict()
}

fn check(program: &Program, machine: &Machine, precision: Precision) -> Result<(), TestCaseError> {
    let verdict = judge(program, machine, precision);
    let limits = machine.axes_of(program).unwrap();
    let broken = violations(&verdict, precision, machine.cycle, machine.tolerance, &limits);
    prop_assert!(broken.is_empty(), "{broken:?}");
    Ok(())
}

/// The same cases in every run, so that a check is repeatable; `SOAK=20 cargo test --release --test
/// limits` draws twenty times as many new ones.
fn config(cases: u32) -> ProptestConfig {
    let soak = std::env::var("SOAK").ok().and_then(|factor| factor.parse::<u32>().ok());
    ProptestConfig {
        cases: cases * soak.unwrap_or(1),
        rng_seed: if soak.is_some() { RngSeed::Random } else { RngSeed::Fixed(2023) },
        failure_persistence: None,
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(1500))]

    #[test]
    fn three_axes_in_f64(
        draws in draws(3, 1..14),
        tolerance in (-3.0f64..0.5).prop_map(|e| 10f64.powf(e)),
        scale in ((-1.0f64..1.0).prop_map(|e| 10f64.powf(e)), (-1.0f64..1.0).prop_map(|e| 10f64.powf(e))),
    ) {
        check(&program(&draws, &[0, 1, 2]), &machine(tolerance, scale, 3), Precision::F64)?;
    }
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn three_axes_in_f32(
        draws in draws(3, 1..14),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
    ) {
        check(&program(&draws, &[0, 1, 2]), &machine(tolerance, (1.0, 1.0), 3), Precision::F32)?;
    }

    #[test]
    fn planar_in_paper_mode(draws in draws(2, 2..14), lambda in 0.0f64..0.6) {
        let mut machine = machine(0.05, (1.0, 1.0), 3);
        machine.mode = Mode::Paper;
        machine.lambda = lambda;
        check(&program(&draws, &[0, 1]), &machine, Precision::F64)?;
    }
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn six_axes(draws in draws(6, 1..10)) {
        check(&program(&draws, &[0, 1, 2, 3, 4, 5]), &machine(0.02, (1.0, 1.0), 6), Precision::F64)?;
    }

    #[test]
    fn nine_axes(draws in draws(9, 1..8)) {
        let axes: Vec<usize> = (0..9).collect();
        check(&program(&draws, &axes), &machine(0.02, (1.0, 1.0), 9), Precision::F64)?;
    }

    /// Corners in 2-D and 3-D: inside the band, and not slower than stopping. (One path in thousands,
    /// with legs shorter than the band between long ones, loses a per cent.)
    #[test]
    fn corners_are_not_slower_than_stops(draws in draws(3, 2..8), flat in any::<bool>()) {
        let mut draws = draws;
        for draw in &mut draws {
            draw.kind = 10;
            draw.stop = false;
            draw.size = draw.size.max(0.1);
            draw.feed = 200.0;
            if flat {
                draw.step[2] = 0.0;
            }
        }
        let machine = machine(0.05, (1.0, 1.0), 3);
        let smooth = program(&draws, &[0, 1, 2]);
        check(&smooth, &machine, Precision::F64)?;
        let mut stops = smooth.clone();
        for step in &mut stops.moves {
            step.exact_stop = true;
        }
        let (smooth, stops) = (judge(&smooth, &machine, Precision::F64), judge(&stops, &machine, Precision::F64));
        prop_assert!(smooth.time <= stops.time * 1.03 + 0.002, "{} s, with stops {} s", smooth.time, stops.time);
    }
}

/// The f32 core follows the f64 core: one by one nearly, all together closely. (Single programs may
/// differ where a cell is cut in two on one side of a rounding and not on the other.)
#[test]
fn f32_takes_as_long_as_f64() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let draws = draws(3, 1..10);
    let machine = machine(0.02, (1.0, 1.0), 3);
    let (mut wide, mut narrow, mut apart) = (0.0, 0.0, 0);
    for _ in 0..300 {
        let program = program(&draws.new_tree(&mut runner).unwrap().current(), &[0, 1, 2]);
        let a = judge(&program, &machine, Precision::F64).time;
        let b = judge(&program, &machine, Precision::F32).time;
        wide += a;
        narrow += b;
        apart += u32::from((a - b).abs() > 0.005 * a + 0.002);
    }
    assert!((wide - narrow).abs() < 0.002 * wide, "{wide} s and {narrow} s");
    assert!(apart <= 12, "{apart} of 300 differ by more than 0.5 %");
}

/// A corner behind a joint that is simply passed must leave room for the bend there.
#[test]
fn a_corner_behind_a_passed_joint_keeps_the_band() {
    let draw = |step: [f64; 3], size| Draw {
        kind: 10,
        step: step.to_vec(),
        size,
        feed: 1.0,
        stop: false,
        bend: 0.0,
    };
    let draws = [
        draw([0.58, 0.0, -0.04], 0.0038),
        draw([0.48, 0.0, 0.076], 1.0),
        draw([0.98, 0.035, 0.197], 11.8),
    ];
    check(&program(&draws, &[0, 1, 2]), &machine(0.0193, (1.0, 1.0), 3), Precision::F64).unwrap();
}
