//! What the planner does, phase by phase; that a draft which is dropped leaves no trace; and numbers that wrap around.

use super::horizon::{Horizon, Proposal};
use super::making::Purpose;
use super::phase::{Following, Halt, Phase, Rest};
use super::{Planner, Progress};
use crate::block::Block;
use crate::machine::{AxisLimits, Config, Limits};
use crate::number::Coord;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::vector::norm;
use crate::path::hermite::Hermite;
use crate::path::node::Node;
use crate::planner::Link;
use crate::profile::law::PathState;
use crate::profile::solver::Aim;
use crate::servo::control::Overrides;
use crate::servo::link::Origin;
use crate::servo::{Activity, Interpolator};
use std::boxed::Box;
use std::format;
use std::string::String;
use std::vec::Vec;

const AXES: usize = 2;
const BLOCKS: usize = 16;
const NODES: usize = 64;
type TestLink = Link<f64, AXES, BLOCKS, NODES>;
type TestPlanner<'a> = Planner<'a, f64, AXES, BLOCKS, NODES>;
type Handles<'a> = (TestPlanner<'a>, Interpolator<'a, f64, AXES>);

fn config() -> Config<f64, AXES> {
    let mut config =
        Config::new(Limits::new([AxisLimits::linear(200.0, 2000.0, 50_000.0); AXES]).unwrap());
    config.tolerance = 0.05;
    config
}

fn link() -> Box<TestLink> {
    Box::new(Link::new())
}

fn handles(link: &mut TestLink) -> Handles<'_> {
    link.split(config(), [Coord::ZERO; AXES]).unwrap()
}

fn line(x: f64, y: f64, tag: u32) -> Block<f64, AXES> {
    Block::line([x, y].map(|mm| Coord::from_mm(mm).unwrap()), 150.0, tag)
}

/// Corners, a run of short lines, a dwell and a stop.
fn program() -> Vec<Block<f64, AXES>> {
    let mut blocks = Vec::new();
    for k in 0..30u32 {
        let (x, y) = (f64::from(k) * 3.0, f64::from(k % 3) * 7.0);
        blocks.push(line(x, y, k + 1));
    }
    for k in 1..60u32 {
        let angle = f64::from(k) * 0.1;
        blocks.push(line(87.0 + 8.0 * angle.sin(), 14.0 + 8.0 * (1.0 - angle.cos()), 100 + k));
    }
    blocks.push(Block::dwell(0.05, 200));
    blocks.push(line(0.0, 0.0, 201));
    blocks
}

/// A long straight, on which any answer is found at once, and a corner.
fn straight() -> [Block<f64, AXES>; 2] {
    [line(100.0, 0.0, 1), line(100.0, 20.0, 2)]
}

/// Pushes what there is room for.
fn feed(planner: &mut TestPlanner<'_>, blocks: &mut &[Block<f64, AXES>]) {
    while let [block, rest @ ..] = *blocks
        && planner.push(block).is_ok()
    {
        *blocks = rest;
    }
    if blocks.is_empty() {
        planner.finish();
    }
}

/// Polls and ticks until a condition holds.
fn run_until(
    (planner, interpolator): &mut Handles<'_>,
    mut done: impl FnMut(&TestPlanner<'_>, Progress) -> bool,
) {
    for _ in 0..20_000 {
        let progress = planner.settle();
        if done(planner, progress) {
            return;
        }
        interpolator.tick();
    }
    panic!("not in {:?}", planner.phase);
}

fn follows(planner: &TestPlanner<'_>) -> Option<Following> {
    if let Phase::Following(now) = planner.phase { Some(now) } else { None }
}

/// Moves for some servo cycles, with the plan under way decided on.
fn in_motion(core: &mut Handles<'_>, cycles: u32) {
    let mut count = 0;
    run_until(core, |planner, _| {
        count += 1;
        count > cycles && follows(planner).is_some()
    });
}

#[test]
fn a_start_waits_for_blocks_and_a_program_comes_to_its_end() {
    let mut link = link();
    let (mut planner, mut interpolator) = handles(&mut link);
    assert_eq!(planner.phase, Phase::Resting(Rest::IDLE));
    assert_eq!(planner.settle(), Progress::NeedsBlocks);
    planner.push(&line(10.0, 0.0, 1)).unwrap();
    planner.push(&line(10.0, 10.0, 2)).unwrap();
    assert_eq!(planner.settle(), Progress::NeedsBlocks);
    let since = Some(CycleSerial::ZERO);
    assert_eq!(planner.phase, Phase::Resting(Rest::Ready { since }));
    // The delay of a start: 50 cycles.
    let mut cycles = 0;
    while planner.settle() != Progress::Planned {
        interpolator.tick();
        cycles += 1;
    }
    assert!((50..=51).contains(&cycles), "{cycles}");
    let offer = *planner.phase.offer().unwrap();
    assert_eq!((offer.first, offer.before), (NodeSerial::ZERO, None));
    assert!(!offer.by_cycle && planner.horizon.has_draft());
    assert_eq!(planner.settle(), Progress::Waiting);
    interpolator.tick();
    planner.finish();
    planner.settle();
    let now = follows(&planner).unwrap_or_else(|| planner.phase.offer().unwrap().before.unwrap());
    assert_eq!(now.halt, None);
    run_until(&mut (planner, interpolator), |planner, progress| {
        let done = progress == Progress::Done;
        assert!(!done || planner.phase == Phase::Resting(Rest::IDLE));
        done
    });
}

#[test]
fn a_start_that_is_not_taken_up_is_withdrawn_by_a_hold() {
    let mut link = link();
    let mut core = handles(&mut link);
    core.0.push(&line(10.0, 0.0, 1)).unwrap();
    core.0.finish();
    assert_eq!(core.0.settle(), Progress::Planned);
    core.0.controls().hold();
    assert_eq!(core.0.settle(), Progress::Held);
    assert_eq!(core.0.phase, Phase::Resting(Rest::IDLE));
    assert_eq!(core.0.counters().late, 0, "that was no fault of the planner's");
    assert_eq!(core.1.tick().activity, Activity::Idle);
    core.0.controls().resume();
    assert_eq!(core.0.settle(), Progress::Planned);
    run_until(&mut core, |_, progress| progress == Progress::Done);
}

#[test]
fn a_hold_is_answered_by_a_plan_that_rests_and_a_resume_goes_on() {
    let mut link = link();
    let mut core = handles(&mut link);
    feed(&mut core.0, &mut &straight()[..]);
    in_motion(&mut core, 100);
    core.0.controls().hold();
    assert_eq!(core.0.settle(), Progress::Planned);
    let offer = *core.0.phase.offer().unwrap();
    assert!(offer.by_cycle && offer.before.is_some());
    assert_eq!(offer.taken.halt, Some(Halt::Hold));
    core.1.tick();
    assert_eq!(core.0.settle(), Progress::Waiting);
    let now = follows(&core.0).unwrap();
    assert_eq!(now, Following { shown: now.shown, ..offer.taken });
    run_until(&mut core, |_, progress| progress == Progress::Held);
    assert_eq!(core.0.phase, Phase::Resting(Rest::IDLE));
    core.0.controls().resume();
    run_until(&mut core, |_, progress| progress == Progress::Done);
}

#[test]
fn a_hold_that_is_called_off_while_it_brakes_is_taken_further_at_once() {
    let mut link = link();
    let mut core = handles(&mut link);
    feed(&mut core.0, &mut &straight()[..]);
    in_motion(&mut core, 100);
    core.0.controls().hold();
    assert_eq!(core.0.settle(), Progress::Planned);
    core.1.tick();
    core.0.settle();
    core.0.controls().resume();
    assert_eq!(follows(&core.0).unwrap().halt, Some(Halt::Hold));
    assert_eq!(core.0.settle(), Progress::Planned);
    assert_eq!(core.0.phase.halt(), None);
    run_until(&mut core, |_, progress| progress == Progress::Done);
}

#[test]
fn a_stop_is_looked_for_once_in_every_plan_and_single_block_mode_awaits_a_resume() {
    let (mut link, blocks) = (link(), program());
    let mut core = handles(&mut link);
    feed(&mut core.0, &mut &blocks[..14]);
    in_motion(&mut core, 60);
    core.0.controls().single_block(true);
    run_until(&mut core, |planner, progress| {
        let tried = follows(planner).is_some_and(|now| now.tried_block_end || now.halt.is_some());
        assert!(tried || planner.phase.offer().is_some() || progress == Progress::Held);
        progress == Progress::Held
    });
    assert_eq!(core.0.phase, Phase::Resting(Rest::AwaitsResume));
    core.1.tick();
    assert_eq!(core.0.settle(), Progress::Held);
    core.0.controls().resume();
    assert_eq!(core.0.settle(), Progress::Planned);
    assert_eq!(core.0.phase.halt(), Some(Halt::Block));
    run_until(&mut core, |_, progress| progress == Progress::Held);
    assert_eq!(core.0.phase, Phase::Resting(Rest::AwaitsResume));
}

#[test]
fn a_pause_awaits_a_resume_that_is_pressed_after_it() {
    let mut link = link();
    let mut core = handles(&mut link);
    core.0.push(&line(10.0, 0.0, 1)).unwrap();
    core.0.push(&Block::pause(2)).unwrap();
    core.0.push(&line(10.0, 10.0, 3)).unwrap();
    core.0.finish();
    in_motion(&mut core, 10);
    core.0.controls().resume();
    run_until(&mut core, |_, progress| progress == Progress::Held);
    assert_eq!(core.0.phase, Phase::Resting(Rest::AwaitsResume));
    core.0.controls().resume();
    assert_eq!(core.0.settle(), Progress::Planned);
    run_until(&mut core, |_, progress| progress == Progress::Done);
}

#[test]
fn an_abort_drops_everything_until_it_is_acknowledged() {
    let (mut link, blocks) = (link(), program());
    let mut core = handles(&mut link);
    feed(&mut core.0, &mut &blocks[..12]);
    in_motion(&mut core, 150);
    core.0.controls().abort();
    assert!(core.0.push(&blocks[12]).is_err());
    assert!(!core.0.acknowledge_abort(), "it is not complete");
    run_until(&mut core, |_, progress| progress == Progress::Aborted);
    assert_eq!(core.0.phase, Phase::Resting(Rest::Dropped { abort: 1 }));
    // Another one, pressed after the first is complete, is complete at the next poll.
    core.0.controls().abort();
    assert!(!core.0.acknowledge_abort());
    assert_eq!(core.0.settle(), Progress::Aborted);
    assert_eq!(core.0.phase, Phase::Resting(Rest::Dropped { abort: 2 }));
    assert!(core.0.acknowledge_abort());
    assert_eq!(core.0.phase, Phase::Resting(Rest::IDLE));
    assert_eq!(core.0.settle(), Progress::NeedsBlocks);
    let end = core.1.tick();
    for (i, at) in core.0.end().iter().enumerate() {
        assert_eq!(end.position(i), *at);
    }
}

#[test]
fn a_plan_that_comes_too_late_leaves_everything_as_it_was() {
    let mut link = link();
    let mut core = handles(&mut link);
    feed(&mut core.0, &mut &straight()[..]);
    in_motion(&mut core, 120);
    let (planner, interpolator) = &mut core;
    let (before, phase, reaction) = (picture(planner.horizon), planner.phase, planner.reaction);
    let moment = planner.moment().unwrap();
    interpolator.tick();
    let made = planner.horizon.draft(|draft| {
        draft.try_overrides(Overrides { feed: 60, rapid: 100 });
        let (stretch, branch) = draft.prepare(moment)?;
        draft.improve(stretch, Aim::Slow);
        Some(Proposal { stretch, branch, halt: Some(Halt::Hold) })
    });
    assert!(planner.propose(Purpose::Hold, made));
    while planner.go_on() == Progress::Planning {}
    assert_eq!(planner.phase.halt(), Some(Halt::Hold));
    assert_ne!(picture(planner.horizon), before);
    interpolator.tick();
    planner.hear();
    assert_eq!(planner.counters().late, 1);
    assert_eq!(picture(planner.horizon), before);
    assert!(planner.reaction > reaction, "the next answer is given more time");
    assert_eq!(follows(planner).unwrap().halt, phase.halt());
    run_until(&mut core, |_, progress| progress == Progress::Done);
}

/// Everything that a draft may change, to the last bit: a number is written so that it is read as the same.
fn picture(horizon: &Horizon<f64, AXES, NODES>) -> String {
    let stations: Vec<_> = (0..horizon.window.len()).map(|i| horizon.window.get(i)).collect();
    let (end, overrides) = (horizon.end(), horizon.overrides());
    format!("{end:?} {overrides:?} {:?} {stations:?}", horizon.window.serial(0))
}

/// All that a command may do to the window, at many places of a program, and dropped.
#[test]
fn a_draft_that_is_dropped_leaves_no_trace() {
    let (mut link, blocks) = (link(), program());
    let mut core = handles(&mut link);
    let mut left = &blocks[..];
    let (mut dropped, mut changed) = (0, 0);
    for cycle in 0.. {
        feed(&mut core.0, &mut left);
        let progress = core.0.settle();
        if progress == Progress::Done {
            break;
        }
        if cycle % 37 == 0 && follows(&core.0).is_some() {
            let before = picture(core.0.horizon);
            let moment = core.0.moment();
            for which in 0..6 {
                let horizon = &mut *core.0.horizon;
                let made: Option<()> = horizon.draft(|draft| {
                    if which == 4 {
                        draft.try_overrides(Overrides { feed: 30, rapid: 50 });
                        draft.bound_from(0);
                    }
                    let (stretch, _) = draft.prepare(moment?)?;
                    match which {
                        0 => {}
                        1 => draft.improve(stretch, Aim::Time),
                        2 => {
                            let solving = draft.begin_finding(stretch, stretch.first + 1);
                            draft.solve(solving);
                        }
                        3 | 4 => draft.improve(stretch, Aim::Slow),
                        _ => {
                            let time = draft.agreed_time(stretch.first);
                            draft.cut_at_rest(stretch.first, time * 0.5);
                        }
                    }
                    changed += u32::from(picture(draft) != before);
                    None
                });
                assert!(made.is_none() && !horizon.has_draft());
                assert_eq!(picture(horizon), before, "cycle {cycle}, {which}");
                dropped += 1;
            }
        }
        core.1.tick();
    }
    assert!(dropped > 100 && changed > 100, "{dropped} {changed}");
}

/// A motion that starts in a bend has a shape of its own for some micrometres. Where it comes to rest there, the path goes on by its
/// own: taken for its curvature, that of the motion would lead round in circles of a micrometre, and far out of the band.
#[test]
fn a_path_keeps_its_shape_where_a_start_comes_to_rest() {
    let (mut link, blocks) = (link(), program());
    // With an axis so slow that next to no speed counts as one at which a motion says nothing of its path.
    let mut config = config();
    let slow = AxisLimits::linear(200.0, 2000.0, 50.0);
    config.limits = Limits::new([slow, AxisLimits::linear(200.0, 2000.0, 50_000.0)]).unwrap();
    let mut core = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let mut left = &blocks[..];
    let mut tried = 0;
    for cycle in 0.. {
        feed(&mut core.0, &mut left);
        if core.0.settle() == Progress::Done {
            break;
        }
        if cycle % 50 == 0 && follows(&core.0).is_some() {
            let horizon = &mut *core.0.horizon;
            for share in [0.01, 0.02, 0.05, 0.1, 0.3] {
                let agreed = [3, 4].map(|i| horizon.window.get(i).map(|station| station.agreed));
                let _: Option<()> = horizon.draft(|draft| {
                    let (from, to) = draft.window.pair(3).map(|(from, to)| (*from, *to))?;
                    let (cell, end) = (&from.cell, from.arrival(&to));
                    if cell.straight || from.rest || to.rest || !(cell.length > 0.05) {
                        return None;
                    }
                    // Such a start, at constant jerk.
                    let (jerk, crawl) = (3_000.0, 1.0e-9);
                    let time = (6.0 * cell.length / jerk).cbrt();
                    let (v, a) = (jerk * time * time / 2.0, jerk * time);
                    for (i, state) in
                        [(3, PathState { b: crawl, a: 0.0 }), (4, PathState { b: v * v, a })]
                    {
                        draft.window.set_state(i, state);
                        draft.window.get_mut(i)?.agreed = state;
                    }
                    let time = draft.agreed_time(3);
                    let whole = Hermite::of_cell(&from.node, cell, &end).arc_length(0.0, 1.0);
                    if time > 0.0 && draft.cut_at_rest(3, time * share) {
                        let [first, rest] = [3, 4].map(|i| *draft.window.get(i).unwrap());
                        let bend = |node: &Node<f64, AXES>| norm(&node.curvature);
                        let most = 1.5 * bend(&from.node).max(bend(&end)) + 1.0e-3;
                        assert!(bend(&rest.node) < most, "{cycle} {share}: {:?}", rest.node);
                        let length = first.cell.length + rest.cell.length;
                        assert!(
                            (length / whole - 1.0).abs() < 0.05,
                            "{cycle} {share}: {length} of {whole}"
                        );
                        tried += 1;
                    }
                    None
                });
                // What was agreed is no part of a draft.
                for (i, agreed) in [3, 4].into_iter().zip(agreed) {
                    if let Some((station, agreed)) = horizon.window.get_mut(i).zip(agreed) {
                        (station.agreed, station.state) = (agreed, agreed);
                    }
                }
            }
        }
        core.1.tick();
    }
    assert!(tried > 50, "{tried}");
}

/// A program under commands, with numbers that count on from an origin: bits of all positions, and what every poll
/// came to.
fn run_from(origin: Origin) -> (Vec<[Coord; AXES]>, Vec<Progress>) {
    let (mut link, blocks) = (link(), program());
    let (mut planner, mut interpolator) =
        link.split_from(config(), [Coord::ZERO; AXES], origin).unwrap();
    let controls = planner.controls();
    let mut left = &blocks[..];
    let (mut positions, mut answers) = (Vec::new(), Vec::new());
    for cycle in 0..40_000u32 {
        feed(&mut planner, &mut left);
        let progress = planner.settle();
        answers.push(progress);
        match cycle % 400 {
            90 => controls.hold(),
            170 | 395 => controls.resume(),
            220 => controls.feed_override(if cycle % 800 < 400 { 60 } else { 140 }),
            300 => controls.stop(),
            _ => {}
        }
        let setpoint = interpolator.tick();
        positions.push([setpoint.position(0), setpoint.position(1)]);
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            return (positions, answers);
        }
    }
    panic!("the program does not end");
}

/// Nodes, servo cycles and plans, each of which wraps around in the middle of the program.
#[test]
fn numbers_that_wrap_around_make_no_difference() {
    let (positions, answers) = run_from(Origin::ZERO);
    let cycles = positions.len() as u32;
    for part in [2, 3, 5] {
        let origin = Origin {
            node: NodeSerial::ZERO.plus(0u32.wrapping_sub(100 / part)),
            cycle: CycleSerial::ZERO.plus(0u32.wrapping_sub(cycles / part)),
            plan: (1 << 30) - 10 / part,
        };
        let wrapped = run_from(origin);
        assert!(positions == wrapped.0, "{origin:?}");
        assert!(answers == wrapped.1, "{origin:?}");
    }
}

/// What follows the setpoints does so unlike on each axis: a line within less than what that takes must be parallel to an axis, but for
/// the last nanometre, at which a jog may have ended.
#[cfg(feature = "shaping")]
#[test]
fn a_line_is_parallel_to_an_axis_to_the_nanometre() {
    let axis = AxisLimits::linear(200.0, 2000.0, 5.0e4);
    let mut config = Config::<f32, 2>::new(Limits::new([axis; 2]).unwrap());
    config.follower.reserve = 0.01;
    config.follower.settle = 0.02;
    for (off, fits) in [(0, true), (400_000, true), (-900_000, true), (2_000_000, false)] {
        let mut link = Box::new(Link::<f32, 2>::new());
        let start = [Coord::ZERO, Coord::from_raw(off)];
        let (mut planner, _interpolator) = link.split(config, start).unwrap();
        let to = [Coord::from_mm(-20.0).unwrap(), Coord::ZERO];
        let line = Block { tolerance: Some(0.0), ..Block::line(to, 100.0, 1) };
        assert_eq!(planner.push(&line).is_ok(), fits, "{off}");
    }
}
