//! Random block sequences against every limit, at every cycle, by finite differences.

mod common;

use common::{Draw, check, config, draws, judged, machine, program};
use proptest::prelude::*;
use splineway_simulator::machine::Mode;
use splineway_simulator::run::{Events, Precision};

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
        let (smooth, stops) = (judged(&smooth, &machine, Precision::F64, &Events::default()).0, judged(&stops, &machine, Precision::F64, &Events::default()).0);
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
        let a = judged(&program, &machine, Precision::F64, &Events::default()).0.time;
        let b = judged(&program, &machine, Precision::F32, &Events::default()).0.time;
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
