//! The same path takes the same time however it is written: lines given in pieces are one line, and their
//! tags stay true.

mod common;

use common::{Draw, config, dense, draws, machine, poly_line, program, stretches, watched};
use proptest::prelude::*;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Course, Move, Program};
use splineway_simulator::run::Precision;

/// The program with its lines cut at shares of their lengths; lines are numbered anew.
fn split(program: &Program, cuts: &[Vec<f64>], round: bool) -> Program {
    let mut here = program.start;
    let mut moves: Vec<Move> = Vec::new();
    for (step, cuts) in program.moves.iter().zip(cuts.iter().cycle()) {
        let end = match &step.path {
            Course::Line { to } | Course::Arc { to, .. } | Course::Cubic { to, .. } => *to,
            _ => here,
        };
        if let Course::Line { to } = &step.path {
            let mut shares = cuts.clone();
            shares.sort_by(f64::total_cmp);
            for share in shares {
                let mut via = here;
                for (x, end) in via.iter_mut().zip(to) {
                    *x += (end - *x) * share;
                    if round {
                        *x = (*x * 1000.0).round() / 1000.0;
                    }
                }
                let path = Course::Line { to: via };
                moves.push(Move { path, exact_stop: false, ..step.clone() });
            }
        }
        moves.push(step.clone());
        here = end;
    }
    for (line, step) in (1u32..).zip(&mut moves) {
        step.line = line;
    }
    Program { moves, ..program.clone() }
}

fn cuts() -> impl Strategy<Value = Vec<Vec<f64>>> {
    prop::collection::vec(prop::collection::vec(0.001f64..0.999, 0..6), 1..8)
}

/// Share of its time by which a program may take longer in pieces.
const LONGER: f64 = 0.005;
/// And where lines have as much noise as the band is wide: how far a few sweeps get hangs on where their stretches end.
const NOISY: f64 = 0.025;

/// Splits a program: the time stays, the tags are in order.
fn check(
    program: &Program,
    cuts: &[Vec<f64>],
    machine: &Machine,
    (precision, share): (Precision, f64),
) -> Result<(), TestCaseError> {
    let whole = watched(program, machine, precision);
    let pieces = watched(&split(program, cuts, false), machine, precision);
    // Starts and ends fall on whole cycles. (Cells are cut where pieces end as well: the motion may be faster.)
    let longer = pieces.time - whole.time - 3.0 * machine.cycle;
    let most = share * whole.time;
    prop_assert!(longer <= most, "{} s in pieces, {} s as a whole", pieces.time, whole.time);
    prop_assert!(pieces.tags.is_sorted_by_key(|(tag, _)| *tag), "{:?}", pieces.tags);
    Ok(())
}

/// Moves of a program over some axes that are lines.
fn lines(draws: &[Draw], axes: &[usize]) -> Program {
    let lines: Vec<Draw> =
        draws.iter().map(|draw| Draw { kind: draw.kind.max(12), ..draw.clone() }).collect();
    program(&lines, axes)
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn lines_in_pieces(
        draws in draws(3, 1..12),
        cuts in cuts(),
        tolerance in (-3.0f64..0.0).prop_map(|e| 10f64.powf(e)),
        single in any::<bool>(),
    ) {
        let precision = if single { Precision::F32 } else { Precision::F64 };
        let machine = machine(tolerance, (1.0, 1.0), 3);
        check(&lines(&draws, &[0, 1, 2]), &cuts, &machine, (precision, LONGER))?;
    }

    #[test]
    fn lines_of_six_axes_in_pieces(
        draws in draws(6, 1..12),
        cuts in cuts(),
        tolerance in (-3.0f64..0.0).prop_map(|e| 10f64.powf(e)),
    ) {
        let program = lines(&draws, &[0, 1, 2, 3, 4, 5]);
        let machine = machine(tolerance, (1.0, 1.0), 6);
        check(&program, &cuts, &machine, (Precision::F64, LONGER))?;
    }

    #[test]
    fn dense_lines_in_pieces(
        stretches in stretches(1..6),
        cuts in cuts(),
        tolerance in (-2.5f64..-0.5).prop_map(|e| 10f64.powf(e)),
        single in any::<bool>(),
    ) {
        let precision = if single { Precision::F32 } else { Precision::F64 };
        let machine = machine(tolerance, (1.0, 1.0), 3);
        check(&dense(&stretches), &cuts, &machine, (precision, NOISY))?;
    }
}

/// Legs of 10 mm that turn by `turn` rad to and fro.
fn zigzag(turn: f64) -> Program {
    let (mut at, mut points) = ([0.0; 3], Vec::new());
    for k in 0..20 {
        let heading = if k % 2 == 0 { 0.5 * turn } else { -0.5 * turn };
        at[0] += 10.0 * heading.cos();
        at[1] += 10.0 * heading.sin();
        points.push((at, 200.0));
    }
    poly_line(&points)
}

/// A zigzag in pieces of 4, 2, 1 and a tenth of a millimetre; every piece of a millimetre and more shows its
/// tag, for about as long as it takes.
#[test]
fn a_zigzag_in_pieces() {
    for turn in [45.0f64, 90.0, 120.0, 150.0] {
        let whole = zigzag(turn.to_radians());
        for (lookahead, precision) in
            [(16, Precision::F64), (16, Precision::F32), (64, Precision::F64)]
        {
            let machine = Machine { lookahead, ..machine(0.05, (1.0, 1.0), 3) };
            let time = watched(&whole, &machine, precision).time;
            for (size, round) in
                [(4.0, false), (2.0, false), (1.0, false), (1.0, true), (4.0, true), (0.1, false)]
            {
                let count = (10.0f64 / size).ceil() as u32;
                let cuts: Vec<f64> = (1..count).map(|k| f64::from(k) * size / 10.0).collect();
                let program = split(&whole, &[cuts], round);
                let pieces = watched(&program, &machine, precision);
                let ratio = pieces.time / time;
                // What is lost by rounding is taken off the tolerance. Cells that end where pieces do fill a small window.
                let most = match (round, lookahead) {
                    (true, 16) => 1.021,
                    (true, _) => 1.02,
                    _ => 1.005,
                };
                assert!(
                    ratio <= most && ratio > 0.99,
                    "{turn} degrees, {size} mm, rounded {round}, {precision:?}: {ratio}"
                );
                let tags: Vec<u32> = pieces.tags.iter().map(|(tag, _)| *tag).collect();
                assert!(tags.is_sorted(), "{tags:?}");
                let lost = program.moves.len() + 1 - tags.len();
                // In a run they are, where more wait than it remembers.
                let most = if turn < 80.0 { program.moves.len() } else { 0 };
                assert!(
                    size < 1.0 || lost <= most,
                    "{turn} degrees, {size} mm, {precision:?}: {lost} tags lost of {tags:?}"
                );
            }
        }
    }
}

/// In `f32` no motion is found over a cell that is a hundred times as short as its neighbour: the end of a piece
/// next to that of a cell makes none.
#[test]
fn the_end_of_a_piece_makes_no_sliver() {
    let steps = [
        ([-0.461_639_024, 0.710_443_396, 0.0], 0.898_032_500, 46.530_050_217),
        ([-0.802_098_003, -0.761_426_229, 0.064_157_271], 1.0, 1.0),
        ([-0.872_547_805, 0.034_909_129, 0.576_715_572], 0.311_859_233, 1.0),
        ([-0.539_984_527, 0.0, -0.731_109_013], 0.031_314_149, 1.0),
        ([-0.944_269_776, 0.0, 0.0], 12.468_888_040, 1.0),
        ([0.662_618_685, 0.337_848_054, 0.0], 0.093_213_100, 1.0),
        ([0.0, 0.0, -0.532_847_283], 2.192_421_850, 1.0),
        ([0.0, -0.488_543_690, -0.451_889_576], 0.043_169_670, 1.0),
        ([0.0, 0.643_063_501, -0.368_749_402], 5.079_468_715, 1.0),
    ];
    let draws = steps.map(|(step, size, feed)| Draw {
        kind: 12,
        step: step.to_vec(),
        size,
        feed,
        stop: false,
        bend: 0.0,
    });
    let cuts = [vec![], vec![], vec![0.553_822_379]];
    let machine = machine(0.009_107_192, (1.0, 1.0), 3);
    check(&program(&draws, &[0, 1, 2]), &cuts, &machine, (Precision::F32, LONGER)).unwrap();
}
