//! Events and pauses of the program: in order with the motion, exactly at its rests, none lost, none
//! doubled.

use proptest::prelude::*;
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Limits, Link, Planner, Progress,
    PushError, Scalar, Setpoint,
};

mod common;
use common::config;

const BLOCKS: usize = 8;
const NODES: usize = 56;

fn setting<S: Scalar>() -> Config<S, 2> {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let mut config = Config::new(Limits::new([axis; 2]).unwrap());
    config.tolerance = S::of(0.05);
    config
}

fn at(x: f64, y: f64) -> [Coord; 2] {
    [Coord::from_mm(x).unwrap(), Coord::from_mm(y).unwrap()]
}

/// What a cycle sees: its number, the planner's last word, the setpoint.
type Seen<'a, S> = (u32, Progress, &'a Setpoint<S, 2>);

/// Runs blocks; the planner is called `polls(cycle)` times per cycle. `then` says whether to go on.
fn drive<S: Scalar>(
    blocks: &[Block<S, 2>],
    polls: impl Fn(u32) -> u32,
    mut then: impl FnMut(Seen<'_, S>, Controls<'_>) -> bool,
) {
    let mut link = Box::new(Link::<S, 2, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator): (Planner<'_, S, 2, BLOCKS, NODES>, _) =
        link.split(setting(), at(0.0, 0.0)).unwrap();
    let controls = planner.controls();
    let mut next = 0;
    let mut progress = Progress::Waiting;
    for cycle in 0..200_000 {
        for _ in 0..polls(cycle) {
            while let Some(block) = blocks.get(next) {
                match planner.push(block) {
                    Ok(()) => next += 1,
                    Err(PushError::Full) => break,
                    Err(error) => panic!("{error}"),
                }
            }
            if next == blocks.len() {
                planner.finish();
            }
            progress = planner.settle();
        }
        let setpoint = interpolator.tick();
        if !then((cycle, progress, &setpoint), controls) {
            return;
        }
    }
    panic!("the run did not end");
}

/// The event stands between the two motions: at rest on the end of the block before, in one cycle.
#[test]
fn an_event_is_reported_once_and_at_rest() {
    let blocks = [
        Block::line(at(10.0, 0.0), 100.0, 1),
        Block::event(2),
        Block::event(3),
        Block::line(at(10.0, 10.0), 100.0, 4),
        Block::event(5),
    ];
    let mut tags = Vec::new();
    let mut cycles = 0;
    drive::<f64>(
        &blocks,
        |_| 1,
        |(cycle, progress, setpoint), _| {
            if setpoint.activity == Activity::Event {
                tags.push((setpoint.tag, setpoint.position_nm(0), setpoint.position_nm(1)));
                assert!(setpoint.velocity.iter().all(|v| *v == 0.0));
            }
            cycles = cycle;
            !(progress == Progress::Done && setpoint.activity == Activity::Idle)
        },
    );
    let mm = 1_000_000;
    assert_eq!(tags, [(2, 10 * mm, 0), (3, 10 * mm, 0), (5, 10 * mm, 10 * mm)]);
    assert!(cycles < 450, "{cycles}");
}

/// A pause waits for a resume that is pressed after it has been reached.
#[test]
fn a_pause_waits_for_its_resume() {
    let blocks = [
        Block::pause(1),
        Block::line(at(10.0, 0.0), 100.0, 2),
        Block::pause(3),
        Block::pause(4),
        Block::line(at(0.0, 0.0), 100.0, 5),
        Block::pause(6),
    ];
    let mut held = Vec::new();
    let mut since = 0;
    drive::<f64>(
        &blocks,
        |_| 1,
        |(cycle, progress, setpoint), controls| {
            if setpoint.activity == Activity::Running && cycle % 7 == 0 {
                // In motion: it does nothing to a pause that is to come.
                controls.resume();
            }
            if progress == Progress::Held {
                since += 1;
                assert!(setpoint.activity == Activity::Idle && held.len() < 4);
                if since == 50 {
                    held.push(setpoint.tag);
                    since = 0;
                    controls.resume();
                }
            }
            !(progress == Progress::Done && setpoint.activity == Activity::Idle)
        },
    );
    assert_eq!(held, [1, 3, 4, 6]);
}

/// An abort before it drops it.
#[test]
fn an_abort_drops_the_events_before_it() {
    let blocks = [Block::line(at(10.0, 0.0), 100.0, 1), Block::event(2)];
    drive::<f64>(
        &blocks,
        |_| 1,
        |(cycle, progress, setpoint), controls| {
            if cycle == 50 {
                controls.abort();
            }
            assert_ne!(setpoint.activity, Activity::Event);
            !(progress == Progress::Aborted && cycle > 1000)
        },
    );
}

/// A program with events, and an operator who presses anything. Presses at random moments, and polls that
/// do not come in every cycle.
fn check<S: Scalar>(kinds: &[u8], presses: &[(u32, u8)], late: u32) -> Result<(), TestCaseError> {
    let mut blocks = Vec::new();
    for (tag, kind) in (1..).zip(kinds) {
        blocks.push(match kind {
            0..=2 => Block::event(tag),
            3 => Block::pause(tag),
            4 => Block::dwell(S::of(0.0123), tag),
            5 => {
                Block { exact_stop: true, ..Block::line(at(f64::from(tag), 0.0), S::of(80.0), tag) }
            }
            _ => Block::line(at(f64::from(tag), f64::from(tag % 2)), S::of(80.0), tag),
        });
    }
    let wanted: Vec<u32> =
        (1..).zip(kinds).filter(|(_, kind)| **kind <= 3).map(|(tag, _)| tag).collect();
    let mut tags = Vec::new();
    let mut still = 0;
    drive::<S>(
        &blocks,
        |cycle| u32::from(cycle % (late + 1) == 0),
        |seen, controls| {
            let (cycle, progress, setpoint) = seen;
            for (_, kind) in presses.iter().filter(|(when, _)| *when == cycle) {
                match kind {
                    0..=2 => controls.hold(),
                    3..=5 => controls.resume(),
                    6 => controls.stop(),
                    7 => controls.single_block(true),
                    8 => controls.single_block(false),
                    9 => controls.feed_override(40),
                    _ => controls.feed_override(130),
                }
            }
            if setpoint.activity == Activity::Event {
                tags.push(setpoint.tag);
                assert!(setpoint.velocity.iter().all(|v| *v == S::ZERO));
            }
            still = if progress == Progress::Held { still + 1 } else { 0 };
            if still > 30 {
                controls.single_block(false);
                controls.resume();
            }
            !(progress == Progress::Done && setpoint.activity == Activity::Idle)
        },
    );
    prop_assert_eq!(tags, wanted);
    Ok(())
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn none_is_lost_and_none_doubled(
        kinds in prop::collection::vec(0u8..10, 1..24),
        presses in prop::collection::vec((0u32..1500, 0u8..11), 0..12),
        late in 0u32..4,
        single in prop::bool::ANY,
    ) {
        if single {
            check::<f32>(&kinds, &presses, late)?;
        } else {
            check::<f64>(&kinds, &presses, late)?;
        }
    }
}
