//! Operators who press whatever they like: every command is answered, nothing crawls, and the program ends in
//! about the time that stopping everywhere would take.

mod common;

use common::config;
use proptest::prelude::*;
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Limits, Link, Planner, Progress,
    PushError, Scalar, Setpoint,
};

const BLOCKS: usize = 16;
const NODES: usize = 64;
const ACCELERATION: f64 = 2000.0;
const JERK: f64 = 50_000.0;
/// s.
const CYCLE: f64 = 1.0e-3;
/// What a command may cost, and the start: some stops from full speed, s.
const ALLOWANCE: f64 = 0.4;
/// A motion slower than this, mm/s, for so many cycles is a crawl: no feed here asks for it.
const CRAWL: (f64, u32) = (1.0e-3, 20);
/// The arc length may seem to run back by its rounding, mm.
const BACK: f64 = 1.0e-5;
/// A hold or an abort is answered within this time, s: v / A + A / J is 0.09 to 0.14, and where the path bends
/// there is not always a stop at once.
const ANSWER: f64 = 0.3;

fn setting<S: Scalar>(cycle: f64) -> Config<S, 2> {
    let axis = AxisLimits::linear(S::of(200.0), S::of(ACCELERATION), S::of(JERK));
    let stop = AxisLimits::linear(S::of(200.0), S::of(3.0 * ACCELERATION), S::of(8.0 * JERK));
    let mut config = Config::new(Limits::new([axis; 2]).unwrap());
    config.stop_limits = Some(Limits::new([stop; 2]).unwrap());
    config.tolerance = S::of(0.05);
    config.cycle = S::of(cycle);
    config
}

fn at(x: f64, y: f64) -> [Coord; 2] {
    [Coord::from_mm(x).unwrap(), Coord::from_mm(y).unwrap()]
}

/// A command and the cycle in which it is given.
#[derive(Clone, Copy, Debug)]
enum Press {
    Hold,
    QuickHold,
    Resume,
    Stop,
    Abort,
    QuickAbort,
    Override(u16),
    Single(bool),
}

impl Press {
    fn send(self, controls: Controls<'_>) {
        match self {
            Self::Hold => controls.hold(),
            Self::QuickHold => controls.quick_hold(),
            Self::Resume => controls.resume(),
            Self::Stop => controls.stop(),
            Self::Abort => controls.abort(),
            Self::QuickAbort => controls.quick_abort(),
            Self::Override(percent) => {
                controls.feed_override(percent);
                controls.rapid_override(percent);
            }
            Self::Single(on) => controls.single_block(on),
        }
    }
}

/// A short program: corners, and feeds (0: a rapid) or, below zero, dwells, ms.
type Steps = Vec<((f64, f64), f64)>;

fn blocks<S: Scalar>(steps: &Steps) -> (Vec<Block<S, 2>>, f64) {
    let (mut time, mut from) = (0.0, (0.0, 0.0));
    let mut list = Vec::new();
    for (&(to, feed), tag) in steps.iter().zip(1..) {
        if feed < 0.0 {
            list.push(Block::dwell(S::of(-feed * 1.0e-3), tag));
            time -= feed * 1.0e-3;
            continue;
        }
        let length = f64::hypot(to.0 - from.0, to.1 - from.1);
        let speed = if feed > 0.0 { feed } else { 200.0 };
        time += length / speed + speed / ACCELERATION + ACCELERATION / JERK;
        list.push(match feed {
            0.0 => Block::rapid(at(to.0, to.1), tag),
            _ => Block::line(at(to.0, to.1), S::of(feed), tag),
        });
        from = to;
    }
    (list, time)
}

/// How often the planner is polled in a cycle.
fn polls(seed: u32, cycle: u32) -> u32 {
    match seed {
        0..=2 => seed + 1,
        _ => (cycle.wrapping_mul(2_654_435_761) >> 16) % (seed - 1),
    }
}

/// Runs a program with an operator. What has gone wrong, in words.
fn operate<S: Scalar>(steps: &Steps, presses: &[(u32, Press)], seed: u32) -> Result<(), String> {
    let (blocks, stops) = blocks::<S>(steps);
    let mut link = Box::new(Link::<S, 2, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator): (Planner<'_, S, 2, BLOCKS, NODES>, _) =
        link.split(setting(CYCLE), at(0.0, 0.0)).unwrap();
    let controls = planner.controls();
    let (mut next, mut slow, mut way) = (0, 0, 0.0);
    // When a hold or an abort was pressed that is still in force and not answered.
    let (mut held, mut aborts) = (None, false);
    let last = presses.iter().map(|(cycle, _)| *cycle).max().unwrap_or(0);
    let most = last + ((stops + ALLOWANCE) / CYCLE) as u32;
    for cycle in 0.. {
        for (_, press) in presses.iter().filter(|(when, _)| *when == cycle) {
            press.send(controls);
            match press {
                Press::Abort | Press::QuickAbort => (held, aborts) = (held.or(Some(cycle)), true),
                Press::Hold | Press::QuickHold => held = held.or(Some(cycle)),
                Press::Resume if !aborts => held = None,
                _ => {}
            }
        }
        let mut progress = Progress::Waiting;
        for _ in 0..polls(seed, cycle) {
            while next < blocks.len() {
                match planner.push(&blocks[next]) {
                    Ok(()) => next += 1,
                    Err(PushError::Full | PushError::Aborted) => break,
                    Err(error) => return Err(error.to_string()),
                }
            }
            if next == blocks.len() {
                planner.finish();
            }
            progress = planner.settle();
        }
        let setpoint = interpolator.tick();
        let here = setpoint.path_mm();
        if here < way - BACK {
            return Err(format!("cycle {cycle}: path_mm runs back from {way} to {here}"));
        }
        way = here;
        let crawls =
            setpoint.activity == Activity::Running && setpoint.path_speed.to_f64().abs() < CRAWL.0;
        slow = if crawls { slow + 1 } else { 0 };
        if slow > CRAWL.1 {
            return Err(format!(
                "cycle {cycle}: crawls at {:e} mm/s",
                setpoint.path_speed.to_f64()
            ));
        }
        if let Some(since) = held {
            if setpoint.activity == Activity::Idle {
                held = aborts.then_some(since).filter(|_| progress != Progress::Aborted);
            } else if f64::from(cycle - since) * CYCLE > ANSWER {
                return Err(format!("cycle {cycle}: not at rest since {since}"));
            }
        }
        if progress == Progress::Aborted {
            return if planner.acknowledge_abort() { Ok(()) } else { Err("no abort".into()) };
        }
        if cycle > last && progress == Progress::Done && setpoint.activity == Activity::Idle {
            return Ok(());
        }
        if cycle > most {
            return Err(format!(
                "{} s after the last command at {way} mm, {progress:?}, {:?}, {} mm/s: {:?}",
                f64::from(cycle - last) * CYCLE,
                setpoint.activity,
                setpoint.path_speed.to_f64(),
                planner.counters()
            ));
        }
    }
    Ok(())
}

fn steps() -> impl Strategy<Value = Steps> {
    let feed = prop_oneof![
        4 => 20.0f64..150.0,
        1 => Just(0.0),
        1 => -80.0f64..-0.1,
    ];
    prop_oneof![
        Just(vec![((20.0, 10.0), 100.0)]),
        Just(vec![
            ((10.0, 0.0), 100.0),
            ((10.0, 10.0), 100.0),
            ((0.0, 10.0), 100.0),
            ((5.0, 5.0), 100.0)
        ]),
        prop::collection::vec(((0.0f64..30.0, 0.0f64..30.0), feed), 1..6),
    ]
}

/// Hold and resume at any moment, now and then something else, and at last what lets the program run.
fn presses() -> impl Strategy<Value = Vec<(u32, Press)>> {
    let other = prop_oneof![
        Just(Press::Stop),
        prop::sample::select(vec![5u16, 20, 50, 100, 150]).prop_map(Press::Override),
        prop::bool::ANY.prop_map(Press::Single),
    ];
    let round = (0.0f64..1.0, 0.0f64..1.0, prop::option::weighted(0.3, (0u32..100, other)));
    (0u32..200, prop::collection::vec(round, 1..6), prop::bool::weighted(0.2)).prop_map(
        |(start, rounds, aborts)| {
            let (mut list, mut time) = (Vec::new(), start);
            for (rest, run, other) in rounds {
                let quick = rest < 0.3;
                list.push((time, if quick { Press::QuickHold } else { Press::Hold }));
                list.extend(other.map(|(after, press)| (time + after, press)));
                time += 1 + (rest * rest * 250.0) as u32;
                list.push((time, Press::Resume));
                time += 1 + (run * run * 100.0) as u32;
            }
            let end = list.iter().map(|(cycle, _)| *cycle).max().unwrap_or(0) + 1;
            let runs_on = [Press::Single(false), Press::Override(100), Press::Resume];
            let abort = if start % 2 == 0 { Press::Abort } else { Press::QuickAbort };
            let last: &[Press] = if aborts { &[abort] } else { &runs_on };
            list.extend(last.iter().map(|press| (end, *press)));
            list
        },
    )
}

proptest! {
    #![proptest_config(config(1500))]

    #[test]
    fn every_command_is_answered_and_nothing_crawls(
        steps in steps(),
        presses in presses(),
        seed in 0u32..6,
        single in prop::bool::ANY,
    ) {
        let outcome = if single {
            operate::<f32>(&steps, &presses, seed)
        } else {
            operate::<f64>(&steps, &presses, seed)
        };
        prop_assert!(outcome.is_ok(), "{}", outcome.unwrap_err());
    }
}

/// What once took 2,320 s: hold and resume three times on a line of 22 mm.
#[test]
fn hold_and_resume_three_times() {
    use Press::{Hold, Resume};
    let presses =
        [(74, Hold), (119, Resume), (121, Hold), (146, Resume), (147, Hold), (157, Resume)];
    operate::<f64>(&vec![((20.0, 10.0), 100.0)], &presses, 1).unwrap();
    operate::<f32>(&vec![((20.0, 10.0), 100.0)], &presses, 1).unwrap();
}

/// An override that is raised just after the start at a lower one is not put off to a node a second away.
#[test]
fn an_override_is_answered_before_the_next_node() {
    use Press::{Hold, Override, Resume};
    let presses =
        [(97, Hold), (97, Override(5)), (223, Resume), (224, Override(100)), (224, Resume)];
    operate::<f64>(&vec![((20.0, 10.0), 100.0)], &presses, 0).unwrap();
    operate::<f32>(&vec![((20.0, 10.0), 100.0)], &presses, 0).unwrap();
}

/// Lines with a corner, and a square.
fn corners() -> [Steps; 2] {
    let bent = vec![
        ((24.124_942_843_592_88, 0.0), 35.777_242_742_390_15),
        ((11.961_830_214_203_1, 0.0), 65.601_307_610_861_3),
        ((13.376_871_557_668_98, 17.915_885_643_759_78), 94.545_870_026_537_78),
    ];
    let square = [(10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (5.0, 5.0)];
    [bent, square.map(|to| (to, 100.0)).to_vec()]
}

/// An override that is raised soon after a start at a lower one takes the motion to its speed at once, not to
/// a third of it for the rest of the program.
#[test]
fn a_raised_override_is_reached() {
    use Press::{Hold, Override, Resume, Single};
    let [bent, square] = corners();
    let late = [(0, Hold), (1, Resume), (65, Hold), (65, Override(20)), (203, Resume)];
    let again = [
        (42, Hold),
        (43, Resume),
        (44, Hold),
        (44, Override(20)),
        (197, Resume),
        (198, Hold),
        (198, Override(5)),
        (311, Resume),
    ];
    for (steps, presses) in [(bent, &late[..]), (square, &again[..])] {
        let end = presses.last().map_or(0, |(cycle, _)| cycle + 1);
        let mut presses = presses.to_vec();
        presses.extend([(end, Single(false)), (end, Override(100)), (end, Resume)]);
        operate::<f64>(&steps, &presses, 0).unwrap();
        operate::<f32>(&steps, &presses, 0).unwrap();
    }
}

/// A motion at 1 per cent reaches its speed in no time, and is held at once, however slow it is: a start is not
/// spread over cells that were cut for a hundred times the speed.
#[test]
fn a_slow_start_is_short_and_can_be_held() {
    use Press::{Hold, Override, Resume};
    for steps in corners() {
        for wait in [1, 2, 3, 5, 9, 20, 60] {
            let presses = [(0, Override(1)), (wait, Hold), (400, Override(100)), (400, Resume)];
            operate::<f64>(&steps, &presses, 1).unwrap();
            operate::<f32>(&steps, &presses, 1).unwrap();
        }
        let (mut slow, mut fast) = (0, 0);
        let (blocks, _) = blocks::<f64>(&steps);
        drive::<f64>(&blocks, (CYCLE, 1), |cycle, _, setpoint, controls| {
            controls.feed_override(1);
            let asked = 0.9 * steps[0].1 * 0.01;
            slow +=
                u32::from(setpoint.activity == Activity::Running && setpoint.path_speed < asked);
            fast += u32::from(setpoint.path_speed > 1.2 * asked);
            cycle < 600
        });
        assert!(slow < 100, "{slow} cycles below 0.9 per cent");
        assert!(fast < 10, "{fast} cycles above 1.08 per cent");
    }
}

/// Runs blocks at a servo cycle, one poll every `every` cycles, until `then` says stop.
fn drive<S: Scalar>(
    blocks: &[Block<S, 2>],
    (cycle, every): (f64, u32),
    mut then: impl FnMut(u32, Progress, &Setpoint<S, 2>, Controls<'_>) -> bool,
) {
    let mut link = Box::new(Link::<S, 2, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator): (Planner<'_, S, 2, BLOCKS, NODES>, _) =
        link.split(setting(cycle), at(0.0, 0.0)).unwrap();
    for block in blocks {
        planner.push(block).unwrap();
    }
    planner.finish();
    let controls = planner.controls();
    let mut progress = Progress::Waiting;
    for cycle in 0..20_000_000 {
        if cycle % every == 0 {
            progress = planner.settle();
        }
        let setpoint = interpolator.tick();
        if !then(cycle, progress, &setpoint, controls) {
            return;
        }
    }
    panic!("the run did not end");
}

/// Hold and abort before the interrupt has taken up the first plan, whatever the program begins with.
#[test]
fn commands_before_the_first_plan_are_answered() {
    for aborts in [false, true] {
        for dwells in [false, true] {
            let mut link = Box::new(Link::<f64, 2, BLOCKS, NODES>::new());
            let (mut planner, mut interpolator): (Planner<'_, f64, 2, BLOCKS, NODES>, _) =
                link.split(setting(CYCLE), at(0.0, 0.0)).unwrap();
            interpolator.tick();
            if dwells {
                planner.push(&Block::dwell(0.1, 1)).unwrap();
            }
            planner.push(&Block::line(at(20.0, 10.0), 100.0, 2)).unwrap();
            planner.finish();
            assert_eq!(planner.settle(), Progress::Planned);
            let controls = planner.controls();
            if aborts {
                controls.abort();
                assert_eq!(planner.settle(), Progress::Aborted);
                assert_eq!(interpolator.tick().activity, Activity::Idle);
                assert!(planner.acknowledge_abort());
                planner.push(&Block::line(at(20.0, 10.0), 100.0, 2)).unwrap();
                planner.finish();
            } else {
                controls.hold();
                assert_eq!(planner.settle(), Progress::Held);
                assert_eq!(interpolator.tick().activity, Activity::Idle);
                controls.resume();
            }
            let ends = (0..1000).any(|_| {
                let progress = planner.settle();
                let setpoint = interpolator.tick();
                progress == Progress::Done && setpoint.activity == Activity::Idle
            });
            assert!(ends, "aborts {aborts}, dwells {dwells}");
        }
    }
}

/// A dwell is suspended by a hold and ended by an abort, at once; a hold takes nothing of it away.
#[test]
fn a_dwell_is_answered_at_once() {
    let blocks = [
        Block::line(at(1.0, 0.0), 100.0, 1),
        Block::dwell(2.0, 2),
        Block::line(at(2.0, 0.0), 100.0, 3),
    ];
    for wait in [1, 10, 500, 1990, 1997] {
        let (mut dwelt, mut rested, mut since) = (0u32, 0u32, None);
        drive::<f64>(&blocks, (CYCLE, 1), |cycle, progress, setpoint, controls| {
            let dwells = setpoint.activity == Activity::Dwelling;
            dwelt += u32::from(dwells);
            if dwelt == wait && dwells {
                controls.hold();
                since = Some(cycle);
            }
            if let Some(pressed) = since {
                assert!(setpoint.activity != Activity::Running);
                rested += u32::from(progress == Progress::Held);
                // A dwell that is as good as over ends.
                assert!(cycle - pressed < 6 || rested > 0, "{wait}: {progress:?}");
                if rested == 100 {
                    controls.resume();
                    since = None;
                }
            }
            !(progress == Progress::Done && setpoint.activity == Activity::Idle)
        });
        assert!((1997..=2003).contains(&dwelt) && rested == 100, "{wait}: {dwelt} {rested}");
        let mut pressed = None;
        dwelt = 0;
        drive::<f64>(&blocks, (CYCLE, 1), |cycle, progress, setpoint, controls| {
            dwelt += u32::from(setpoint.activity == Activity::Dwelling);
            if dwelt == wait && pressed.is_none() {
                controls.abort();
                pressed = Some(cycle);
            }
            assert!(pressed.is_none_or(|pressed| cycle - pressed < 6));
            progress != Progress::Aborted
        });
    }
}

/// A dwell of more cycles than one cell of it holds: as long as it says, in `f32` too.
#[test]
fn long_dwells_take_their_time() {
    fn check<S: Scalar>() {
        let (cycle, seconds) = (2.0e-6, 7.4);
        let blocks = [Block::dwell(S::of(seconds), 1), Block::rapid(at(0.001, 0.0), 2)];
        let mut dwelt = 0u32;
        drive::<S>(&blocks, (cycle, 1000), |_, progress, setpoint, _| {
            dwelt += u32::from(setpoint.activity == Activity::Dwelling);
            !(progress == Progress::Done && setpoint.activity == Activity::Idle)
        });
        assert!((f64::from(dwelt) * cycle - seconds).abs() < 2.0e-5, "{dwelt}");
    }
    check::<f32>();
    check::<f64>();
}

/// Dwells that are shorter than a servo cycle: a tick passes four at most, be they from rest or between moves.
#[test]
fn dwells_of_less_than_a_servo_cycle_are_passed_four_at_a_time() {
    fn check<S: Scalar>() {
        let dwells = |from: u32| (from..from + 7).map(|tag| Block::dwell(S::of(2.0e-4), tag));
        let mut blocks: Vec<Block<S, 2>> = dwells(1).collect();
        blocks.push(Block::rapid(at(0.1, 0.0), 8));
        blocks.extend(dwells(9));
        let (mut before, mut dwelt) = (0, 0u32);
        drive::<S>(&blocks, (0.01, 1000), |_, progress, setpoint, _| {
            // The fifth begins as the fourth ends.
            assert!(setpoint.tag <= before + 5, "{} after {before}", setpoint.tag);
            before = setpoint.tag;
            dwelt += u32::from(setpoint.activity == Activity::Dwelling);
            !(progress == Progress::Done && setpoint.activity == Activity::Idle)
        });
        assert!((3..=4).contains(&dwelt), "{dwelt}");
    }
    check::<f32>();
    check::<f64>();
}
