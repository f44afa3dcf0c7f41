//! Single block mode: the motion rests exactly where a block ends that was pushed while the mode was on.

mod common;

use common::{Draw, Stretch, config, dense, draws, machine, program, stretches};
use proptest::prelude::*;
use splineway::{Activity, Coord, Link, Progress, PushError, Scalar, Setpoint};
use splineway_simulator::machine::Axis;
use splineway_simulator::program::{Course, Move, Program};
use splineway_simulator::run::block;

const AXES: usize = 3;
const CYCLE: f64 = 1.0e-3;
/// How far a rest may be from the programmed end, mm.
const EXACT: f64 = 1.0e-6;

/// When the mode is switched.
#[derive(Clone, Debug)]
struct Operator {
    /// Whether it is on at the beginning.
    on: bool,
    /// Cycles between two switches.
    switches: Vec<u32>,
    /// Cycles between two blocks that are pushed; 0: as fast as there is room.
    drip: u32,
    /// Slices of planning per servo cycle.
    slices: u32,
}

fn operator() -> impl Strategy<Value = Operator> {
    (any::<bool>(), prop::collection::vec(1u32..300, 0..8), 0u32..20, 1u32..60)
        .prop_map(|(on, switches, drip, slices)| Operator { on, switches, drip: drip * 2, slices })
}

/// What came of a run.
#[derive(Default)]
struct Outcome {
    /// Tags at rests of single block mode.
    rests: Vec<u32>,
    /// Of these, those that had to be exact, and were.
    exact: u32,
    /// The mode was switched off because the program took too long.
    cut_off: bool,
}

/// Distance from a place, mm.
fn apart<S: Scalar>(setpoint: &Setpoint<S, AXES>, place: &[f64]) -> f64 {
    let off = (0..AXES).map(|axis| (setpoint.position_mm(axis) - place[axis]).abs());
    off.fold(0.0, f64::max)
}

/// The shares of its limits that an axis uses, if one is exceeded.
fn beyond<S: Scalar>(
    setpoint: &Setpoint<S, AXES>,
    limits: &[Axis],
    before: &mut [f64; AXES],
) -> Option<[f64; 3]> {
    limits.iter().enumerate().find_map(|(axis, limit)| {
        let velocity = setpoint.velocity[axis].to_f64() / limit.velocity;
        let acceleration = setpoint.acceleration[axis].to_f64();
        let jerk = (acceleration - before[axis]) / CYCLE / limit.jerk;
        before[axis] = acceleration;
        let used = [velocity, acceleration / limit.acceleration, jerk];
        used.iter().any(|share| share.abs() > 1.01).then_some(used)
    })
}

/// Runs a program with an operator who goes on at every rest. What has gone wrong, in words.
fn operate<S: Scalar>(
    program: &Program,
    tolerance: f64,
    operator: &Operator,
) -> Result<Outcome, String> {
    let axes: Vec<usize> = (0..AXES).collect();
    let machine = machine(tolerance, (1.0, 1.0), AXES);
    let limits: Vec<_> = axes.iter().map(|&axis| machine.axis(axis).unwrap()).collect();
    let mut link = Box::new(Link::<S, AXES, 8, 56>::new());
    let start = [Coord::ZERO; AXES];
    let (mut planner, mut interpolator) =
        link.split(machine.config(&axes).unwrap(), start).unwrap();
    let controls = planner.controls();
    let mut single = operator.on;
    controls.single_block(single);
    let mut switches = operator.switches.iter();
    let mut next_switch = switches.next().copied();
    // Of every block that was pushed in the mode which is still on: tag and end.
    let mut due: Vec<(u32, [f64; AXES])> = Vec::new();
    let curved = |step: &&Move| matches!(step.path, Course::Cubic { .. });
    let curves: Vec<u32> = program.moves.iter().filter(curved).map(|step| step.line).collect();
    let known = tags(program);
    let mut moves = program.moves.iter().peekable();
    let (mut outcome, mut idle, mut before) = (Outcome::default(), 0, [0.0; AXES]);
    for cycle in 0..120_000u32 {
        if next_switch == Some(cycle) {
            single = !single;
            controls.single_block(single);
            controls.resume();
            if !single {
                due.clear();
            }
            next_switch = switches.next().map(|wait| cycle + wait);
        } else if next_switch.is_none() && cycle > 20_000 && single {
            // At last everything is to be run.
            (single, outcome.cut_off) = (false, true);
            controls.single_block(false);
            controls.resume();
            due.clear();
        }
        while let Some(step) = moves.peek() {
            if operator.drip > 0 && cycle % operator.drip != 0 {
                break;
            }
            match planner.push(&block::<S, AXES>(step, &axes).unwrap()) {
                Ok(()) => {
                    if let (true, Some(end)) =
                        (single && known.contains(&step.line), step.path.end())
                    {
                        due.retain(|(tag, _)| *tag != step.line);
                        due.push((step.line, std::array::from_fn(|axis| end[axis])));
                    }
                    moves.next();
                }
                Err(PushError::Full) => break,
                Err(error) => return Err(error.to_string()),
            }
            if operator.drip > 0 {
                break;
            }
        }
        if moves.peek().is_none() {
            planner.finish();
        }
        let mut progress = Progress::Planning;
        for _ in 0..operator.slices {
            progress = planner.poll();
            if progress != Progress::Planning {
                break;
            }
        }
        let setpoint = interpolator.tick();
        if let Some(used) = beyond(&setpoint, &limits, &mut before) {
            return Err(format!("cycle {cycle}: {used:?} of the limits"));
        }
        idle = if setpoint.activity == Activity::Idle { idle + 1 } else { 0 };
        if progress == Progress::Held && idle > 0 {
            outcome.rests.push(setpoint.tag);
            if let Some(k) = due.iter().position(|(tag, _)| *tag == setpoint.tag) {
                let off = apart(&setpoint, &due[k].1);
                // A curve that turns back on itself rests where it does, and then at its end.
                if off > EXACT && !curves.contains(&setpoint.tag) {
                    return Err(format!(
                        "cycle {cycle}: block {} rests {off} mm off",
                        setpoint.tag
                    ));
                }
                if k > 0 {
                    return Err(format!("cycle {cycle}: no rest at the end of block {}", due[0].0));
                }
                if off <= EXACT {
                    due.remove(0);
                    outcome.exact += 1;
                }
            }
            controls.resume();
        }
        if progress == Progress::Done && idle > 0 && moves.peek().is_none() {
            let end = program.moves.iter().rev().find_map(|step| step.path.end()).copied();
            if apart(&setpoint, &end.unwrap_or(program.start)) > EXACT {
                return Err("it ends elsewhere".into());
            }
            return Ok(outcome);
        }
    }
    Err(format!("no end: {:?}", planner.counters()))
}

/// The tags of the moves that lead anywhere.
fn tags(program: &Program) -> Vec<u32> {
    let mut here = program.start;
    let mut tags = Vec::new();
    for step in &program.moves {
        let Some(&to) = step.path.end() else { continue };
        let way = to.iter().zip(&here).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let curved = !matches!(step.path, Course::Line { .. });
        if (way > 2.0e-6 || curved) && tags.last() != Some(&step.line) {
            tags.push(step.line);
        }
        here = to;
    }
    tags
}

fn check(
    draws: &[Draw],
    tolerance: f64,
    operator: &Operator,
    wide: bool,
) -> Result<u32, TestCaseError> {
    run(&program(draws, &[0, 1, 2]), tolerance, operator, wide)
}

fn run(
    program: &Program,
    tolerance: f64,
    operator: &Operator,
    wide: bool,
) -> Result<u32, TestCaseError> {
    let outcome = if wide {
        operate::<f64>(program, tolerance, operator)
    } else {
        operate::<f32>(program, tolerance, operator)
    };
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => return Err(TestCaseError::fail(error)),
    };
    if operator.on && operator.switches.is_empty() && !outcome.cut_off {
        // Every block has had its rest.
        let wanted = tags(program);
        let all = wanted.iter().all(|tag| outcome.rests.contains(tag));
        prop_assert!(all, "{:?} of {wanted:?}", outcome.rests);
    }
    Ok(outcome.exact)
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn rests_are_at_the_programmed_ends(
        draws in draws(AXES, 1..14),
        operator in operator(),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
        wide in any::<bool>(),
    ) {
        check(&draws, tolerance, &operator, wide)?;
    }

    /// Short lines, which are runs where the mode is off, and lines that go straight on.
    #[test]
    fn runs_are_parted(
        stretches in stretches(1..3),
        operator in operator(),
        tolerance in (-2.5f64..-0.5).prop_map(|e| 10f64.powf(e)),
        wide in any::<bool>(),
    ) {
        run(&short(&stretches), tolerance, &operator, wide)?;
    }
}

/// Some dense lines.
fn short(stretches: &[Stretch]) -> Program {
    let mut program = dense(stretches);
    program.moves.truncate(40);
    program
}

/// A square, straight lines in pieces, an arc, a curve: the mode is on from the beginning, so all are exact.
#[test]
fn every_block_of_a_program_ends_where_it_is_programmed() {
    let draw = |kind: u8, step: [f64; 3], size: f64| Draw {
        kind,
        step: step.to_vec(),
        size,
        feed: 60.0,
        stop: false,
        bend: 0.4,
    };
    let draws = [
        draw(19, [1.0, 0.0, 0.0], 10.0),
        draw(12, [0.0, 1.0, 0.0], 10.0),
        draw(12, [0.0, 1.0, 0.0], 7.3),
        draw(12, [0.0, 1.0, 0.0], 0.02),
        draw(12, [-1.0, 0.2, 0.0], 12.0),
        draw(3, [-1.0, 1.0, 0.3], 9.0),
        draw(10, [1.0, 0.4, 0.0], 8.0),
        draw(12, [1.0, 0.0, 1.0], 0.3),
        draw(12, [1.0, 0.1, 1.0], 0.3),
        draw(12, [1.0, 0.0, 0.9], 0.3),
    ];
    let operator = Operator { on: true, switches: Vec::new(), drip: 0, slices: 100 };
    for wide in [false, true] {
        assert_eq!(check(&draws, 0.05, &operator, wide).unwrap(), 10);
    }
}
