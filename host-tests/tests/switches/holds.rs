//! A hold at every servo cycle of a small path: what has been slowed down switches at the same places, each once.

use crate::run::{AXES, CYCLE, Case, Command, Fired, Outcome, check, run};
use splineway::Scalar;
use splineway_simulator::program::{Course, Move, Program, Speed};

/// Lines with corners, an arc, lines shorter than what is run in a servo cycle, a dwell, a turn back.
fn path() -> Program {
    let point = |x: f64, y: f64, z: f64| [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let line = |x, y, z| Course::Line { to: point(x, y, z) };
    let arc = Course::Arc {
        to: point(4.0, 4.0, 0.5),
        plane: (0, 1),
        centre: (4.0, 3.0),
        clockwise: false,
        extra_turns: 0,
    };
    let courses = [
        line(4.0, 0.0, 0.0),
        line(4.0, 2.0, 0.0),
        arc,
        Course::Dwell { seconds: 0.01 },
        line(3.9, 4.05, 0.5),
        line(3.8, 4.05, 0.5),
        line(2.0, 3.0, 0.0),
        line(3.0, 3.5, 0.0),
    ];
    let mut program = Program::default();
    program.uses[..AXES].fill(true);
    for (path, line) in courses.into_iter().zip(1..) {
        let speed = Speed::PerSecond(90.0);
        program.moves.push(Move { path, speed, tolerance: None, exact_stop: false, line });
    }
    program
}

fn case(hold: Option<u32>, jogs: bool) -> Case {
    let commands =
        hold.map_or(Vec::new(), |cycle| vec![(cycle, Command::Hold), (9999, Command::Resume)]);
    Case { distance: -0.7, time: LEAD, commands, slices: 100_000, jogs }
}

/// Time before the ends of blocks, s.
const LEAD: f64 = 0.021;
const TOLERANCE: f64 = 0.03;

/// Where and when the outputs of a held run switched, against those of one without a hold.
fn compare(held: &Outcome, free: &Outcome, hold: u32, most_mm: f64) {
    for (output, (held, free)) in held
        .fired
        .iter()
        .zip(&free.fired)
        .take(2)
        .chain([(&held.toggles, &free.toggles)])
        .enumerate()
    {
        assert_eq!(held.len(), free.len());
        for (a, b) in held.iter().zip(free) {
            let off = (a.path - b.path).abs();
            assert!(off < most_mm, "hold at {hold}, output {output}: {off} mm off: {a:?} {b:?}");
        }
    }
    let [ends, _, leads, _] = &held.fired;
    for (i, (lead, end)) in leads.iter().zip(ends).enumerate() {
        lead_is_right((lead, end), (&free.fired[2][i], held), hold);
    }
}

/// A time before a place is kept, unless the hold came in between: then it has been kept by the motion as it was, or is made
/// up for as soon as the motion goes on.
fn lead_is_right((lead, end): (&Fired, &Fired), (free, held): (&Fired, &Outcome), hold: u32) {
    let due = end.time - LEAD / CYCLE;
    let near = 0.5 + end.fuzz() + lead.fuzz();
    let exact = (lead.time - due).abs() < near;
    let as_it_was = lead.time < due && (lead.time - free.time).abs() < near;
    let at_once = |start: &f64| lead.time >= *start && lead.time < start + 2.0 && due < lead.time;
    assert!(
        exact || as_it_was || held.starts.iter().any(at_once),
        "hold at {hold}: {lead:?}, due at {due}, {:?}",
        held.starts
    );
}

fn at_every_cycle<S: Scalar>(jogs: bool, most_mm: f64) {
    let program = path();
    let free = run::<S>(&program, TOLERANCE, &case(None, false)).unwrap();
    let length = free.fired[0].last().unwrap().time as u32;
    assert!(length > 200, "{length}");
    let step = if jogs { 7 } else { 1 };
    for hold in (1..length).step_by(step) {
        let case = case(Some(hold), jogs);
        let held = run::<S>(&program, TOLERANCE, &case).unwrap();
        // At the end of the program there is nothing to go back to.
        let away_and_back = held.jogs == 2 || (held.jogs == 1 && hold + 80 > length);
        assert!(if jogs { away_and_back } else { held.jogs == 0 }, "hold at {hold}");
        check(&held, TOLERANCE, &case).unwrap();
        compare(&held, &free, hold, most_mm);
    }
}

#[test]
fn a_hold_at_every_cycle_loses_and_doubles_nothing() {
    at_every_cycle::<f64>(false, 1.0e-4);
}

#[test]
fn nor_does_it_in_single_precision() {
    at_every_cycle::<f32>(false, 3.0e-4);
}

#[test]
fn a_jog_away_and_back_switches_nothing() {
    at_every_cycle::<f64>(true, 3.0e-4);
    at_every_cycle::<f32>(true, 3.0e-4);
}

/// A hold cuts a curve into parts that are together a micrometre longer or shorter than it was.
#[test]
fn the_end_of_a_curve_that_was_cut_is_where_it_was() {
    let point = |x: f64, y: f64, z: f64| [x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut program = Program::default();
    program.uses[..AXES].fill(true);
    let arc = Course::Arc {
        to: point(19.243, 0.0, -5.321),
        plane: (0, 1),
        centre: (9.6215, 31.16),
        clockwise: true,
        extra_turns: 0,
    };
    let (speed, tolerance, exact_stop) = (Speed::PerSecond(111.0), None, false);
    program.moves.push(Move { path: arc, speed, tolerance, exact_stop, line: 1 });
    for hold in (5..1500).step_by(61) {
        for slices in [14, 100_000] {
            let case = Case { slices, ..case(Some(hold), false) };
            let outcome = run::<f32>(&program, 1.0, &case).unwrap();
            assert_eq!(outcome.fired[0].len(), 1, "hold at {hold}");
        }
    }
}
