//! The least time of any motion inside the band: what is known of it in closed form, and that it can be run.

use splineway_simulator::judge::violations;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Course, Move, Program, Speed};
use splineway_studies::anymotion::{Found, Options, least_time};

const OPTIONS: Options = Options { step: 2.0e-3, rounds: 20, longest: 10.0 };

fn point(x: [f64; 3]) -> [f64; 9] {
    let mut to = [0.0; 9];
    to[..3].copy_from_slice(&x);
    to
}

fn program(axes: usize, courses: Vec<Course>) -> Program {
    let mut program = Program::default();
    program.uses[..axes].fill(true);
    for (path, line) in courses.into_iter().zip(1..) {
        program.moves.push(Move::new(path, Speed::PerSecond(200.0), line));
    }
    program
}

fn line(x: [f64; 3]) -> Course {
    Course::Line { to: point(x) }
}

fn found(program: &Program, tolerance: f64) -> Found {
    let machine = Machine { tolerance, ..Machine::default() };
    let found = least_time(program, &machine, &OPTIONS, |_, _, _, _| {}).unwrap();
    let broken = violations(&found.verdict);
    assert!(broken.is_empty(), "{broken:?}");
    found
}

#[test]
fn along_a_line_it_is_the_s_curve() {
    for axes in [1, 3] {
        let found = found(&program(axes, vec![line([100.0, 0.0, 0.0])]), 0.05);
        // 100 mm / 200 mm/s + 200 / 2000 + 2000 / 50,000.
        assert!((found.least - 0.64).abs() < 3.0e-3, "{}", found.least);
        assert!(found.planned >= found.least && found.planned < 0.645);
    }
}

#[test]
fn around_corners_and_along_arcs_nothing_planned_is_faster() {
    let arc = Course::Arc {
        to: point([30.0, 10.0, 0.0]),
        plane: (0, 1),
        centre: (20.0, 10.0),
        clockwise: true,
        extra_turns: 0,
    };
    let corners =
        vec![line([10.0, 0.0, 0.0]), line([10.0, 10.0, 0.0]), arc, line([30.0, 20.0, 2.0])];
    let found = found(&program(3, corners), 0.05);
    let ratio = found.planned / found.least;
    assert!(ratio > 1.0 && ratio < 1.2, "{} / {}", found.planned, found.least);
}

#[test]
fn a_rest_parts_a_program() {
    let mut program = program(2, vec![line([5.0, 0.0, 0.0]), line([5.0, 5.0, 0.0])]);
    let together = found(&program, 0.05).least;
    program.moves[0].exact_stop = true;
    let apart = found(&program, 0.05).least;
    program.moves.insert(1, Move::new(Course::Dwell { seconds: 0.25 }, Speed::Rapid, 9));
    let dwelling = found(&program, 0.05).least;
    assert!(apart > together * 1.1, "{apart} {together}");
    assert!((dwelling - apart - 0.25).abs() < 2.0e-3, "{dwelling} {apart}");
}

/// A motion that stays near the first half of a line out and back is within the band of both at every place, and has not been at its end.
#[test]
fn it_goes_to_the_far_end_of_a_line_out_and_back() {
    let there = |x| line([x, 0.0, 0.0]);
    let once = found(&program(2, vec![there(10.0)]), 0.05).least;
    let thrice = found(&program(2, vec![there(10.0), there(0.0), there(10.0)]), 0.05);
    assert!((thrice.least - 3.0 * once).abs() < 4.0e-3, "{} {once}", thrice.least);
    let far = thrice.setpoints.iter().map(|at| at[0]).fold(0.0, f64::max);
    assert!((far - 10.0).abs() < 1.0e-6, "{far}");
    // Folds that lie in the band of what is around them are none.
    let jitter = vec![there(5.0), there(4.999), there(10.0), there(9.99999), there(10.0)];
    let smooth = found(&program(2, jitter), 0.05).least;
    assert!((smooth - once).abs() < 4.0e-3, "{smooth} {once}");
}

#[test]
fn what_leaves_no_choice_or_takes_too_long_is_refused() {
    let machine = |tolerance| Machine { tolerance, ..Machine::default() };
    let refused = |program: &Program, tolerance| {
        let outcome = least_time(program, &machine(tolerance), &OPTIONS, |_, _, _, _| {});
        format!("{:#}", outcome.unwrap_err())
    };
    let corner = program(2, vec![line([5.0, 0.0, 0.0]), line([5.0, 5.0, 0.0])]);
    assert!(refused(&corner, 0.0).contains("line 1: a tolerance of 0"));
    let long = program(2, vec![line([9000.0, 0.0, 0.0])]);
    assert!(refused(&long, 0.01).contains("more than 10 s"));
    assert!(refused(&program(2, vec![]), 0.01).contains("nothing moves"));
}
