//! Numbers at the edges: phases that vanish, crawling and racing feeds, far coordinates, the finest and the
//! widest bands, nine axes. Every cycle is judged.

mod common;

use common::{config, judged, machine};
use proptest::prelude::*;
use splineway::machine::Quantity;
use splineway_simulator::judge::violations;
use splineway_simulator::machine::{Axis, Machine};
use splineway_simulator::program::{Course, Move, Point, Program, Speed};
use splineway_simulator::run::{Events, Precision};

/// A zigzag of `count` legs of `size` mm in as many axes, around a place.
fn zigzag(axes: usize, count: usize, size: f64, feed: f64, place: f64) -> Program {
    let mut program = Program::default();
    program.uses[..axes].fill(true);
    program.start = [place; 9];
    let mut to: Point = program.start;
    for n in 0..count {
        to[n % axes] += if n % 3 == 2 { -size } else { size };
        let path = Course::Line { to };
        program.moves.push(Move::new(path, Speed::PerSecond(feed), n as u32 + 1));
    }
    program
}

fn check(program: &Program, machine: &Machine, what: &str) {
    for precision in [Precision::F64, Precision::F32] {
        let (verdict, stats) = judged(program, machine, precision, &Events::default());
        let broken = violations(&verdict);
        assert!(broken.is_empty(), "{what}, {precision:?}: {broken:?}");
        assert_eq!(stats.blocks, program.moves.len() as u64, "{what}");
    }
}

fn with(velocity: f64, acceleration: f64, jerk: f64) -> Machine {
    let mut machine = machine(0.02, (1.0, 1.0), 9);
    for axis in machine.axes.values_mut() {
        *axis = Axis { velocity, acceleration, jerk };
    }
    machine
}

/// Jerk so high that its phases take less than a servo cycle, or so low that acceleration is never
/// reached; the same for acceleration.
#[test]
fn phases_may_vanish() {
    for (velocity, acceleration, jerk) in [
        (200.0, 2000.0, 1.0e8),
        (200.0, 2000.0, 200.0),
        (200.0, 1.0e6, 5.0e4),
        (200.0, 50.0, 1.0e6),
        (2.0, 2000.0, 5.0e4),
        (5000.0, 5.0e4, 5.0e6),
    ] {
        let machine = with(velocity, acceleration, jerk);
        let what = format!("V {velocity}, A {acceleration}, J {jerk}");
        check(&zigzag(3, 12, 3.0, 1.0e5, 0.0), &machine, &what);
    }
}

/// A value of a quantity's range, by its share of the range's powers of ten.
fn of_range(quantity: Quantity, share: f64) -> f64 {
    let range = quantity.range();
    (range.least.ln() * (1.0 - share) + range.greatest.ln() * share).exp()
}

proptest! {
    #![proptest_config(config(60))]
    /// Whatever limits are accepted, a program ends, in about the time that a leg takes by the one that binds, and within them.
    #[test]
    fn any_limits_do(shares in [0.0..1.0, 0.0..1.0, 0.0..1.0f64], time in 0.05..3.0f64) {
        let quantities = [Quantity::Velocity, Quantity::Acceleration, Quantity::Jerk];
        let [velocity, acceleration, jerk]: [f64; 3] =
            std::array::from_fn(|k| of_range(quantities[k], shares[k]));
        // From rest to rest, by each of them alone.
        let size = (velocity * time).min(acceleration * time * time / 4.0).min(jerk * time.powi(3) / 32.0);
        prop_assume!((0.02..1.0e4).contains(&size));
        let mut machine = with(velocity, acceleration, jerk);
        machine.tolerance = 0.01 * size;
        let program = zigzag(3, 9, size, 1.0e6, 0.0);
        let what = format!("V {velocity}, A {acceleration}, J {jerk}, {size} mm in {time} s");
        for precision in [Precision::F64, Precision::F32] {
            let (verdict, stats) = judged(&program, &machine, precision, &Events::default());
            let broken = violations(&verdict);
            prop_assert!(broken.is_empty(), "{what}, {precision:?}: {broken:?}");
            prop_assert_eq!(stats.blocks, 9);
            prop_assert!(verdict.time < 9.0 * 2.5 * time, "{} s: {}", verdict.time, what);
        }
    }
}

#[test]
fn feeds_may_crawl_and_race() {
    let machine = machine(0.02, (1.0, 1.0), 9);
    check(&zigzag(3, 6, 2.0e-6, 1.0e-6, 0.0), &machine, "feed 1e-6");
    check(&zigzag(3, 6, 1.0e-3, 1.0e-3, 0.0), &machine, "feed 1e-3");
    check(&zigzag(3, 12, 10.0, 1.0e6, 0.0), &machine, "feed 1e6");
}

/// A hundred metres from zero an `f32` still resolves nanometres: positions are fixed point. (The judge
/// sees positions in `f64`, and there the differences of setpoints lose their digits: so no limits, but
/// band and end.)
#[test]
fn coordinates_may_be_far() {
    let program = zigzag(3, 12, 5.0, 150.0, 1.0e5);
    let machine = machine(0.02, (1.0, 1.0), 9);
    for precision in [Precision::F64, Precision::F32] {
        let (verdict, _) = judged(&program, &machine, precision, &Events::default());
        assert!(verdict.deviation <= 0.02 && verdict.end_error < 1.0e-6, "{verdict:?}");
        let worst = verdict.worst();
        assert!(worst.velocity <= 1.0 + 1.0e-6 && worst.acceleration <= 1.001, "{worst:?}");
    }
    // Moves across them.
    let program = zigzag(2, 3, 1.0e5, 5000.0, 0.0);
    let (verdict, _) =
        judged(&program, &with(5000.0, 5.0e4, 5.0e6), Precision::F64, &Events::default());
    assert!(verdict.deviation <= 0.02 && verdict.end_error < 1.0e-6, "{verdict:?}");
}

#[test]
fn bands_may_be_fine_and_wide() {
    for tolerance in [1.0e-6, 1.0e-4, 1.0, 100.0] {
        let mut machine = machine(tolerance, (1.0, 1.0), 9);
        machine.tolerance = tolerance;
        let program = zigzag(3, 20, 4.0, 150.0, 0.0);
        let (verdict, _) = judged(&program, &machine, Precision::F64, &Events::default());
        let broken = violations(&verdict);
        assert!(broken.is_empty(), "tolerance {tolerance}: {broken:?}");
    }
}

#[test]
fn nine_axes_at_once() {
    check(&zigzag(9, 40, 2.0, 150.0, 0.0), &machine(0.02, (1.0, 1.0), 9), "nine axes");
}
