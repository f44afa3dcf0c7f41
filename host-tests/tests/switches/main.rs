//! Outputs in time with the path: random programs with an operator, and a hold at every servo cycle of a small path.

#[path = "../common/mod.rs"]
mod common;
mod holds;
mod places;
mod run;

use common::{Stretch, config, dense, draws, program, stretches};
use proptest::prelude::*;
use run::{AXES, Case, Command, check, run};
use splineway_simulator::program::Program;

fn command() -> impl Strategy<Value = Command> {
    prop_oneof![
        Just(Command::Hold),
        Just(Command::Resume),
        prop::sample::select(vec![0u16, 10, 50, 100, 150, 200]).prop_map(Command::Feed),
        any::<bool>().prop_map(Command::Single),
        Just(Command::Stop),
    ]
}

fn case(commands: usize) -> impl Strategy<Value = Case> {
    (
        -4.0f64..4.0,
        1.0e-4f64..0.1,
        prop::collection::vec((1u32..150, command()), 0..=commands),
        prop_oneof![Just(100_000u32), 2u32..60],
        any::<bool>(),
    )
        .prop_map(|(distance, time, commands, slices, jogs)| Case {
            distance,
            time,
            commands,
            slices,
            jogs,
        })
}

fn both(program: &Program, tolerance: f64, case: &Case, wide: bool) -> Result<(), TestCaseError> {
    // Of more, those that are due behind the end would leave no room for others.
    let many = program.moves.len() > 15;
    let case =
        &Case { distance: if many { -case.distance.abs() } else { case.distance }, ..case.clone() };
    let outcome = if wide {
        run::<f64>(program, tolerance, case)
    } else {
        run::<f32>(program, tolerance, case)
    };
    let outcome = outcome.map_err(TestCaseError::fail)?;
    check(&outcome, tolerance, case).map(drop)
}

/// Some dense lines.
fn short(stretches: &[Stretch]) -> Program {
    let mut program = dense(stretches);
    program.moves.truncate(60);
    program
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn every_end_of_a_block_switches_where_it_is(
        draws in draws(AXES, 1..14),
        case in case(0),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
        wide in any::<bool>(),
    ) {
        both(&program(&draws, &[0, 1, 2]), tolerance, &case, wide)?;
    }

    #[test]
    fn so_it_does_under_commands(
        draws in draws(AXES, 1..14),
        case in case(8),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
        wide in any::<bool>(),
    ) {
        both(&program(&draws, &[0, 1, 2]), tolerance, &case, wide)?;
    }

    #[test]
    fn so_it_does_in_runs(
        stretches in stretches(1..3),
        case in case(4),
        tolerance in (-2.5f64..-0.5).prop_map(|e| 10f64.powf(e)),
        wide in any::<bool>(),
    ) {
        both(&short(&stretches), tolerance, &case, wide)?;
    }
}
