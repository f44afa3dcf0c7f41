//! The window as a list, and the solver on windows that can be reckoned by hand.

use super::bounds::Pace;
use super::law::{Law, PathState};
use super::problem::{Probe, Weights};
use super::relaxation::Relaxation;
use super::seeding::Seeding;
use super::solver::{Aim, Solver, Stretch};
use super::solving::Solving;
use super::tridiagonal::Rows;
use super::window::Window;
use crate::machine::{AxisLimits, LimitSets, Limits};
use crate::number::serial::NodeSerial;
use crate::number::{Coord, Scalar};
use crate::path::node::{Cell, Node, Programmed};
use crate::servo::link::Room;
use crate::servo::piece::Slot;
use std::format;
use std::vec::Vec;

const NODES: usize = 48;
const V: f64 = 200.0;
const A: f64 = 2000.0;
const J: f64 = 50_000.0;

fn limits<S: Scalar>() -> Limits<S, 2> {
    Limits::new([AxisLimits::linear(S::of(V), S::of(A), S::of(J)); 2]).unwrap()
}

fn pace<S: Scalar>(limits: &Limits<S, 2>) -> Pace<'_, S, 2> {
    Pace { limits: LimitSets::only(limits), cycle: S::of(1e-3), feed: S::ONE, rapid: S::ONE }
}

/// A straight along the first axis, cut into cells of these lengths.
fn straight<S: Scalar>(lengths: &[f64], first: NodeSerial) -> Window<S, 2, NODES> {
    let node = |x: f64| Node {
        at: [Coord::from_mm(x).unwrap(), Coord::ZERO],
        tangent: [S::ONE, S::ZERO],
        curvature: [S::ZERO; 2],
    };
    let mut window = Window::EMPTY;
    window.begin(node(0.0), first);
    let mut x = 0.0;
    for (i, length) in lengths.iter().enumerate() {
        x += length;
        let cell = Cell {
            length: S::of(*length),
            tangent_offset: [S::ZERO; 2],
            programmed: Programmed { tag: i as u32, ..Programmed::feed(S::of(V)) },
            dwell: S::ZERO,
            event: None,
            straight: true,
        };
        window.append(cell, node(x), i + 1 == lengths.len(), &pace(&limits()));
    }
    window
}

/// Numbers of the stations from the front to the back, by their tags.
fn tags<S: Scalar>(window: &Window<S, 2, NODES>) -> Vec<u32> {
    (0..window.len()).map(|i| window.get(i).unwrap().cell.programmed.tag).collect()
}

#[test]
fn a_window_is_a_list_whose_numbers_wrap_around() {
    let first = NodeSerial::from_raw(u32::MAX - 1);
    let mut window = straight::<f64>(&[1.0; 5], first);
    assert_eq!(window.len(), 6);
    for i in 0..6 {
        let serial = first.plus(i as u32);
        assert_eq!(window.serial(i), serial);
        assert_eq!((window.find(serial), window.clamped_index(serial)), (Some(i), i));
    }
    let (before, behind) = (first.previous(), first.plus(6));
    assert_eq!((window.find(before), window.clamped_index(before)), (None, 0));
    assert_eq!((window.find(behind), window.clamped_index(behind)), (None, 5));
    let third = *window.get(2).unwrap();
    assert!(window.insert_after(2, third));
    assert_eq!(tags(&window), [0, 1, 2, 2, 3, 4, 4]);
    assert!(window.insert_after(0, third) && window.insert_after(6, third));
    assert_eq!(tags(&window), [0, 2, 1, 2, 2, 3, 4, 2, 4]);
    window.remove(&core::array::from_fn(|i| [1, 3, 7].contains(&i)));
    assert_eq!(tags(&window), [0, 1, 2, 3, 4, 4]);
    window.release_before(first.plus(3));
    assert_eq!((window.serial(0), tags(&window)), (NodeSerial::from_raw(1), [3, 4, 4].to_vec()));
    window.release_before(first);
    assert_eq!(window.len(), 3, "what is gone is gone");
    window.truncate(1);
    assert!(window.last().unwrap().rest);
    window.release_before(first.plus(100));
    assert_eq!(window.len(), 1, "the last station is kept");
}

#[test]
fn what_is_put_into_a_full_window_is_refused() {
    let mut window = straight::<f32>(&[1.0; NODES - 1], NodeSerial::ZERO);
    assert_eq!(window.room(), 0);
    let before = format!("{:?}", tags(&window));
    assert!(!window.insert_after(3, *window.get(3).unwrap()));
    assert_eq!(format!("{:?}", tags(&window)), before);
}

/// From rest to rest at constant jerk, a quarter of the time each: h = 2 J (T / 4)^3.
fn by_jerk(length: f64) -> f64 {
    4.0 * (length / (2.0 * J)).cbrt()
}

/// Rest to rest with acceleration and speed below their limits: jerk alone, which has a closed form.
#[test]
fn a_short_straight_takes_hardly_longer_than_jerk_alone_asks_for() {
    let cells = 24;
    let length = 2.0;
    // Fine enough at the ends that the jerk may change where it should.
    let lengths: Vec<_> = (0..cells)
        .map(|i| {
            let x = |k: i32| {
                0.5 - 0.5 * (core::f64::consts::PI * f64::from(k) / f64::from(cells)).cos()
            };
            length * (x(i + 1) - x(i))
        })
        .collect();
    let mut window = straight::<f64>(&lengths, NodeSerial::ZERO);
    let mut solver = Solver::new();
    let limits = limits();
    let stretch = Stretch { first: 0, last: lengths.len(), open: false };
    solver.on(&mut window, LimitSets::only(&limits), stretch).guess(1);
    let solving = solver.on(&mut window, LimitSets::only(&limits), stretch).find(40);
    let steps = solve(&mut solver, &mut window, solving);
    let holds = solver.on(&mut window, LimitSets::only(&limits), stretch).holds();
    assert!(holds && steps < 40, "{steps}");
    let time = solver.on(&mut window, LimitSets::only(&limits), stretch).time().unwrap();
    let least = by_jerk(length);
    assert!(time >= least && time < 1.03 * least, "{time} {least}");
}

/// Room for a system.
fn slots<S: Scalar>() -> [Slot<S, 2>; NODES] {
    [const { Slot::EMPTY }; NODES]
}

/// All steps; how many there were.
fn solve(
    solver: &mut Solver,
    window: &mut Window<f64, 2, NODES>,
    mut solving: Solving<f64>,
) -> u32 {
    let mut steps = 0;
    let slots = slots();
    let room = Room { slots: &slots, number: solver.problems() };
    while solving.go_on((solver, room), window, LimitSets::only(&limits()), &mut steps) {}
    steps
}

/// Slow states from the first station on; whether there are any.
fn seed(solver: &mut Solver, window: &mut Window<f64, 2, NODES>, stretch: Stretch) -> bool {
    let limits = limits();
    let mut seeding = Seeding::new(LimitSets::only(&limits), stretch, 1);
    loop {
        if let Some(found) = solver.on(window, LimitSets::only(&limits), stretch).seed(&mut seeding)
        {
            return found;
        }
    }
}

/// Cells of very unequal lengths, from rest to rest.
const UNEVEN: [f64; 9] = [0.1, 0.4, 2.0, 3.0, 0.7, 5.0, 1.0, 0.2, 0.1];

fn uneven() -> (Window<f64, 2, NODES>, Stretch) {
    (straight(&UNEVEN, NodeSerial::ZERO), Stretch { first: 0, last: UNEVEN.len(), open: false })
}

/// It may be stopped after any number of steps: no step breaks a limit, or makes worse.
#[test]
fn an_improvement_keeps_the_limits_after_any_number_of_steps() {
    let (limits, mut solver) = (limits(), Solver::new());
    let mut last = f64::INFINITY;
    for iterations in 0..25 {
        let (mut window, stretch) = uneven();
        assert!(seed(&mut solver, &mut window, stretch));
        let solving = solver
            .on(&mut window, LimitSets::only(&limits), stretch)
            .improve(iterations, Aim::Time);
        let steps = solve(&mut solver, &mut window, solving);
        assert!(steps <= u32::from(iterations));
        let mut problem = solver.on(&mut window, LimitSets::only(&limits), stretch);
        assert!(problem.holds(), "after {iterations}");
        let time = problem.time().unwrap();
        assert!(time < 1.02 * last, "{iterations}: {time} after {last}");
        last = last.min(time);
    }
    // Up to a speed v and down again, with jerk and acceleration at their limits: v (v / A + A / J) is the length.
    let length: f64 = UNEVEN.iter().sum();
    let speed = 0.5 * ((A * A / J).powi(2) + 4.0 * A * length).sqrt() - 0.5 * A * A / J;
    let least = 2.0 * (speed / A + A / J);
    assert!(last >= least && last < 1.03 * least, "{last} {least}");
}

/// A problem may be laid aside within a step, and the solver put to another one: the step begins again, and the states
/// come out the same, bit by bit. With more cells than are taken at once, a step has several parts.
#[test]
fn a_problem_that_is_interrupted_comes_out_the_same() {
    let lengths: Vec<_> = (0..40).map(|i| 0.2 + 0.05 * f64::from(i % 7)).collect();
    let stretch = Stretch { first: 0, last: lengths.len(), open: false };
    let (limits, mut solver, slots) = (limits::<f64>(), Solver::new(), slots());
    let mut solved = |every: usize| {
        let mut window = straight(&lengths, NodeSerial::ZERO);
        solver.on(&mut window, LimitSets::only(&limits), stretch).guess(1);
        let mut solving = solver.on(&mut window, LimitSets::only(&limits), stretch).find(40);
        let (mut steps, mut parts) = (0, 0);
        let mut room = Room { slots: &slots, number: 0 };
        while solving.go_on((&mut solver, room), &mut window, LimitSets::only(&limits), &mut steps)
        {
            parts += 1;
            if parts % every == 0 {
                // Another use of the workspace.
                for slot in &slots {
                    slot.keep_five([f64::NAN; 5]);
                    slot.keep_two([f64::NAN; 2]);
                }
                if parts % 2 == 0 {
                    solver.on(&mut window, LimitSets::only(&limits), stretch).holds();
                } else {
                    room.number += 1;
                }
            }
        }
        let states: Vec<_> = (0..window.len()).map(|i| window.get(i).unwrap().state).collect();
        (states, steps, parts)
    };
    let (states, steps, parts) = solved(usize::MAX);
    assert!(parts > steps as usize, "{parts} parts of {steps} steps");
    for every in [5, 7, 11] {
        let (same, as_many, more) = solved(every);
        assert!(states == same && steps == as_many && more > parts, "{every}");
    }
}

/// The gradient in the Newton system against differences of the value, for everything that can be minimised.
#[test]
fn the_model_has_the_slope_of_the_value() {
    let limits = limits();
    for aim in [Aim::Time, Aim::Slow] {
        let (mut window, stretch) = uneven();
        let mut solver = Solver::new();
        assert!(seed(&mut solver, &mut window, stretch));
        let slots = slots();
        let mut problem = solver.on(&mut window, LimitSets::only(&limits), stretch);
        problem.rows = Rows::new(&slots);
        problem.task.aim = aim;
        let mu = 1.0e-5;
        let weights = Weights { mu, mu_curvature: mu, damping: 0.0 };
        let mut assembly = problem.begin_assembly(problem.task.relaxation);
        while !problem.assemble(weights, &mut assembly).unwrap() {}
        let cells = problem.cells();
        // Before what the station before has taken.
        let gradients: Vec<_> = (0..cells.end)
            .map(|i| {
                let left = problem.rows.diagonal(i).unwrap().gradient;
                let taken = i.checked_sub(1).and_then(|i| problem.rows.taken(i));
                let taken = taken.map_or([0.0; 2], |taken| taken.gradient);
                [left[0] + taken[0], left[1] + taken[1]]
            })
            .collect();
        for i in 1..cells.end {
            for k in 0..2 {
                for slot in &slots {
                    slot.keep_two([0.0; 2]);
                }
                let PathState { b, .. } = problem.window.get(i).unwrap().state;
                // A step is taken away from the state.
                problem.rows.set_step(i, if k == 0 { [-b, 0.0] } else { [0.0, -b] });
                let step = if k == 0 { 1e-5 } else { 1e-4 };
                let probe = |share: f64| Probe { mu, share, most: f64::MAX };
                let value = |share: f64| problem.value(probe(share), cells.clone()).unwrap();
                let slope = (value(step) - value(-step)) / (2.0 * step * b);
                let scale = gradients[i][k].abs().max(1e-7);
                assert!(
                    (slope - gradients[i][k]).abs() < 1e-3 * scale,
                    "{aim:?} {i} {k}: {slope} {}",
                    gradients[i][k]
                );
            }
        }
    }
}

/// A system says what the states are worth under the barrier before as well: as much as if that were asked for.
#[test]
fn a_system_has_the_value_under_the_barrier_before() {
    let limits = limits();
    let (mut window, stretch) = uneven();
    let mut solver = Solver::new();
    assert!(seed(&mut solver, &mut window, stretch));
    // So fast that limits are exceeded: most rows are where the two barriers differ, or beyond both.
    for faster in [1.0, 3.0, 10.0, 40.0, 100.0] {
        for i in 1..stretch.last {
            let PathState { b, a } = window.get(i).unwrap().state;
            window.set_state(i, PathState { b: b * faster, a });
        }
        let slots = slots();
        let mut problem = solver.on(&mut window, LimitSets::only(&limits), stretch);
        for [before, now] in [[0.3, 0.09], [0.3, 0.3], [1.0e-3, 1.0e-4]] {
            problem.task.relaxation = Relaxation::new(now);
            let weights = Weights { mu: 1.0e-5, mu_curvature: 1.0e-5, damping: 0.0 };
            let mut assembly = problem.begin_assembly(Relaxation::new(before));
            problem.rows = Rows::new(&slots);
            while !problem.assemble(weights, &mut assembly).unwrap() {}
            problem.rows = Rows::NONE;
            let mut value = |delta: f64, mu: f64| {
                problem.task.relaxation = Relaxation::new(delta);
                problem.value(Probe { mu, share: 0.0, most: f64::MAX }, problem.cells()).unwrap()
            };
            for (found, expected) in [
                (assembly.value(1.0e-5).unwrap(), value(now, 1.0e-5)),
                (assembly.value_before(2.0e-3).unwrap(), value(before, 2.0e-3)),
            ] {
                assert!((found - expected).abs() < 1e-12 * expected, "{faster} {before} {now}");
            }
        }
    }
}

/// The way back from a step leads to the very states from which it was taken, and the step is what it was.
#[test]
fn a_step_is_taken_back_to_the_bit() {
    let limits = limits::<f32>();
    let stretch = Stretch { first: 0, last: UNEVEN.len(), open: false };
    let (mut solver, mut window) = (Solver::new(), straight::<f32>(&UNEVEN, NodeSerial::ZERO));
    for i in 1..stretch.last {
        window.set_state(i, PathState { b: 10.1 * i as f32, a: 3.7 * i as f32 });
    }
    let mut problem = solver.on(&mut window, LimitSets::only(&limits), stretch);
    let states = |window: &Window<f32, 2, NODES>| -> Vec<_> {
        (0..window.len()).map(|i| window.get(i).unwrap().state).collect()
    };
    let before = states(problem.window);
    let (cells, slots) = (problem.cells(), slots());
    problem.rows = Rows::new(&slots);
    for i in 0..=cells.end {
        // Such as a system gives that is all but singular.
        problem.rows.set_step(i, [-0.3 * before[i].b, 1.0e9 * (i as f32 - 2.5)]);
    }
    let steps: Vec<_> = (0..=cells.end).map(|i| problem.rows.step(i)).collect();
    problem.take_step(1.0);
    assert!(states(problem.window) != before);
    problem.take_back();
    assert!(states(problem.window) == before);
    for i in 1..cells.end {
        for k in 0..2 {
            let (was, is) = (steps[i][k], problem.rows.step(i)[k]);
            let moved = was.abs().max(if k == 0 { before[i].b } else { before[i].a.abs() });
            assert!((was - is).abs() <= 2.0e-7 * moved, "{i} {k}: {was} {is}");
        }
    }
}

/// Where there is no motion there is no value, and nothing is taken for one.
#[test]
fn states_without_a_motion_do_not_hold() {
    let (limits, mut solver) = (limits(), Solver::new());
    let (mut window, stretch) = uneven();
    assert!(!solver.on(&mut window, LimitSets::only(&limits), stretch).holds(), "rest everywhere");
    window.set_state(1, PathState { b: 1.0, a: 1.0e9 });
    assert!(!solver.on(&mut window, LimitSets::only(&limits), stretch).holds());
    assert!(Law::new(0.1, PathState::REST, PathState { b: 1.0, a: 1.0e9 }).is_none());
}
