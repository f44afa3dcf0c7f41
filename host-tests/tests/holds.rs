//! Holds at single servo cycles of small paths where it is hard to come to rest: in a corner, on a helix, along lines shorter than
//! a step, where axes differ, in fast servo cycles, in `f32`. The limits hold, and the machine stands still soon.

mod common;

use common::judged;
use splineway_simulator::judge::violations;
use splineway_simulator::machine::{Axis, Machine};
use splineway_simulator::program::{Course, Move, Program, Speed};
use splineway_simulator::run::{
    Action, Command, Event, Events, Observer, Precision, Sample, run_with,
};
use std::collections::BTreeMap;

fn machine(limits: (f64, f64, f64), tolerance: f64, cycle: f64) -> Machine {
    let axis = Axis { velocity: limits.0, acceleration: limits.1, jerk: limits.2 };
    Machine {
        tolerance,
        cycle,
        lookahead: 16,
        axes: BTreeMap::from([("default".to_owned(), axis)]),
        ..Machine::default()
    }
}

fn unequal() -> Machine {
    let mut machine = machine((150.0, 900.0, 9000.0), 0.03, 1.0e-3);
    for (name, velocity, acceleration, jerk) in
        [("X", 300.0, 4000.0, 100_000.0), ("Y", 100.0, 800.0, 10_000.0), ("Z", 20.0, 100.0, 1500.0)]
    {
        machine.axes.insert(name.to_owned(), Axis { velocity, acceleration, jerk });
    }
    machine
}

fn program(courses: Vec<(Course, f64)>) -> Program {
    let mut program = Program::default();
    program.uses[..3].fill(true);
    for (n, (path, feed)) in courses.into_iter().enumerate() {
        program.moves.push(Move::new(path, Speed::PerSecond(feed), n as u32 + 1));
    }
    program
}

fn point(x: [f64; 3]) -> [f64; 9] {
    let mut to = [0.0; 9];
    to[..3].copy_from_slice(&x);
    to
}

fn line(x: [f64; 3], feed: f64) -> (Course, f64) {
    (Course::Line { to: point(x) }, feed)
}

fn cubic(a: [f64; 3], b: [f64; 3], to: [f64; 3], feed: f64) -> (Course, f64) {
    (Course::Cubic { controls: [point(a), point(b)], to: point(to) }, feed)
}

fn cubics() -> Program {
    program(vec![
        cubic([5.0, 10.0, 0.0], [10.0, -10.0, 3.0], [15.0, 0.0, 1.0], 150.0),
        cubic([17.0, 4.0, 0.0], [30.0, 10.0, 0.0], [20.0, 15.0, 0.0], 200.0),
    ])
}

fn square() -> Program {
    program(vec![
        line([10.0, 0.0, 0.0], 100.0),
        line([10.0, 10.0, 0.0], 100.0),
        line([0.0, 10.0, 0.0], 150.0),
        line([5.0, 5.0, 0.0], 80.0),
    ])
}

fn helix() -> Program {
    let to = point([2.0, 0.0, 8.0]);
    let arc =
        Course::Arc { to, plane: (0, 1), centre: (1.0, 0.0), clockwise: true, extra_turns: 3 };
    program(vec![(arc, 120.0)])
}

/// 59 lines of 0.3 mm along an arc of 2 mm.
fn tiny() -> Program {
    program(
        (1..60)
            .map(|k| f64::from(k) * 0.15)
            .map(|t| line([2.0 * t.cos() - 2.0, 2.0 * t.sin(), 0.0], 100.0))
            .collect(),
    )
}

fn wiggle() -> Program {
    program(
        (1..120)
            .map(|k| f64::from(k) * 0.05)
            .map(|t| line([10.0 * t, 0.4 * (t * 9.0).sin(), 0.2 * (t * 7.0).cos() - 0.2], 180.0))
            .collect(),
    )
}

/// A hold in a servo cycle, and a resume 2 s later.
fn hold(machine: &Machine, cycle: u32) -> Events {
    let time = (f64::from(cycle) - 0.5) * machine.cycle;
    let event = |time, command| Event { time, action: Action::Command(command) };
    Events::new(vec![event(time, Command::Hold), event(time + 2.0, Command::Resume)])
}

fn keeps(program: &Program, machine: &Machine, precision: Precision, cycle: u32) {
    let (verdict, _) = judged(program, machine, precision, &hold(machine, cycle));
    let broken = violations(&verdict);
    assert!(broken.is_empty(), "hold in cycle {cycle}: {broken:?}");
}

#[derive(Default)]
struct Rest {
    pressed: f64,
    rested: Option<f64>,
}

impl Observer for Rest {
    fn setpoint(&mut self, sample: &Sample<'_>) -> anyhow::Result<()> {
        if sample.time > self.pressed + 1.5e-3 && sample.activity == splineway::Activity::Idle {
            self.rested = self.rested.or(Some(sample.time - self.pressed));
        }
        Ok(())
    }
}

fn time_to_rest(program: &Program, machine: &Machine, precision: Precision, cycle: u32) -> f64 {
    let mut rest = Rest { pressed: f64::from(cycle) * machine.cycle, rested: None };
    run_with(program, machine, precision, &hold(machine, cycle), &mut [&mut rest]).unwrap();
    rest.rested.unwrap()
}

fn usual() -> Machine {
    machine((200.0, 2000.0, 50_000.0), 0.05, 1.0e-3)
}

#[test]
fn jerk_in_f32_usual() {
    keeps(&cubics(), &usual(), Precision::F32, 354);
}

#[test]
fn jerk_in_f32_short_lines() {
    keeps(&tiny(), &usual(), Precision::F32, 43);
}

#[test]
fn jerk_in_f32_quick() {
    let machine = machine((200.0, 2000.0, 50_000.0), 0.02, 0.25e-3);
    keeps(&square(), &machine, Precision::F32, 812);
}

#[test]
fn jerk_in_f32_unequal() {
    keeps(&cubics(), &unequal(), Precision::F32, 624);
}

#[test]
fn helix_takes_no_longer_than_its_neighbours() {
    let times = [388, 389, 390].map(|k| time_to_rest(&helix(), &usual(), Precision::F64, k));
    assert!(times[1] < 1.3 * times[0].max(times[2]), "{times:?}");
}

/// More cells than there may be pieces, if each were run in several.
#[test]
fn short_lines_at_64_nodes() {
    let time = time_to_rest(&tiny(), &usual(), Precision::F64, 67);
    assert!(time < 0.2, "{time}");
}

/// The agreed motion is at the jerk limit of one axis or another nearly all the time.
#[test]
fn short_lines_where_axes_differ() {
    let time = time_to_rest(&wiggle(), &unequal(), Precision::F64, 1534);
    assert!(time < 0.3, "{time}");
}

/// It comes to rest where the path begins to bend.
#[test]
fn a_march_at_a_corner_finds_its_way() {
    let time = time_to_rest(&square(), &usual(), Precision::F64, 344);
    assert!(time < 0.21, "{time}");
}

#[test]
fn a_square_at_a_quarter_of_a_millisecond() {
    // What a hold takes leaps from one servo cycle to the next here: one that finds a step a little harder may come to a corner in another way.
    let machine = machine((200.0, 2000.0, 50_000.0), 0.02, 0.25e-3);
    let cycles = (1101..1400).step_by(12);
    let times: Vec<f64> =
        cycles.map(|k| time_to_rest(&square(), &machine, Precision::F64, k)).collect();
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    assert!(mean < 0.107 && times.iter().all(|time| *time < 0.14), "{mean}: {times:?}");
}

/// From 0.8 mm/s, with all the jerk that there is.
#[test]
fn the_start_of_a_line_where_axes_differ() {
    let line = program(vec![line([20.0, 10.0, 0.0], 100.0)]);
    let time = time_to_rest(&line, &unequal(), Precision::F64, 13);
    assert!(time < 0.05, "{time}");
}

#[test]
fn a_helix_where_axes_differ_with_192_nodes() {
    let machine = Machine { lookahead: 64, ..unequal() };
    let time = time_to_rest(&helix(), &machine, Precision::F64, 250);
    assert!(time < 0.4, "{time}");
}

/// Attempts that come to nothing are not made again in the same servo cycle.
#[test]
fn a_planner_that_finds_no_hold_comes_to_an_end() {
    use splineway::{Coord, Link, Progress};
    let machine = machine((200.0, 2000.0, 50_000.0), 0.02, 0.25e-3);
    let config = machine.config::<f64, 3>(&[0, 1, 2]).unwrap();
    let mut link = Box::new(Link::<f64, 3>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 3]).unwrap();
    for step in &square().moves {
        let (Course::Line { to }, Speed::PerSecond(feed)) = (&step.path, step.speed) else {
            panic!()
        };
        let to = [to[0], to[1], to[2]].map(|x| Coord::from_mm(x).unwrap());
        planner.push(&splineway::Block::line(to, feed, step.line)).unwrap();
    }
    planner.finish();
    let mut most = 0;
    for cycle in 0..2500 {
        if cycle == 1281 {
            planner.controls().hold();
        }
        let goes_on = |progress| matches!(progress, Progress::Planning | Progress::Planned);
        let polls = (0..20_000).take_while(|_| goes_on(planner.poll())).count();
        most = most.max(polls);
        interpolator.tick();
    }
    assert!(most < 1000, "{most} polls in a servo cycle");
}
