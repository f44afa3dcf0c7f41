//! A background that was late for long and is in time again: planning takes no time any more, and what it took before is no reason to wait.

#[allow(dead_code)]
#[path = "common/cycles.rs"]
mod cycles;

use cycles::{Draw, soak};

use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Interpolator, Limits, Link, Planner,
    Progress, Scalar, Setpoint,
};

const AXES: usize = 2;
/// s.
const CYCLE: f64 = 1.0e-3;
/// mm/s.
const FEED: f64 = 20.0;
/// Servo cycles that a slice takes while the background is late.
const SLICE: u32 = 40;
/// Servo cycles in motion until it is in time.
const LATE: u32 = 100;
/// Servo cycles within which a command shows that is given then: four leads, and what speeds up or brakes.
const SOON: u32 = 150;

/// Whether a command shows, by the setpoint before and this one.
type Shows<S> = fn([&Setpoint<S, AXES>; 2]) -> bool;

fn line<S: Scalar>(to: [f64; AXES], tag: u32) -> Block<S, AXES> {
    Block::line(to.map(|mm| Coord::from_mm(mm).unwrap()), S::of(FEED), tag)
}

/// One long line.
fn straight<S: Scalar>() -> Vec<Block<S, AXES>> {
    vec![line([400.0, 300.0], 1)]
}

/// Many corners.
fn zigzag<S: Scalar>() -> Vec<Block<S, AXES>> {
    (1..400u32).map(|n| line([2.0 * f64::from(n), f64::from(n % 2)], n)).collect()
}

type Background<'a, S> = Planner<'a, S, AXES, 16, 64>;

fn push<'a, S: Scalar>(
    planner: &mut Background<'_, S>,
    blocks: &'a [Block<S, AXES>],
) -> &'a [Block<S, AXES>] {
    let taken = blocks.iter().take_while(|block| planner.push(block).is_ok()).count();
    if taken == blocks.len() {
        planner.finish();
    }
    &blocks[taken..]
}

/// Runs a program from rest at an override while the background is late, and for [`LATE`] cycles of motion; then it is in time, and
/// a command is given: servo cycles until it shows.
fn cycles_until<S: Scalar>(
    blocks: &[Block<S, AXES>],
    percent: u16,
    command: fn(Controls<'_>),
    shows: Shows<S>,
) -> u32 {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(0.02);
    assert!((config.cycle.to_f64() - CYCLE).abs() < 1.0e-9);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let controls = planner.controls();
    controls.feed_override(percent);
    let (mut left, mut moved) = (blocks, 0);
    let mut last = interpolator.tick();
    for cycle in 0.. {
        assert!(cycle < 100_000, "no start");
        left = push(&mut planner, left);
        if cycle % SLICE == 0 {
            planner.poll();
        }
        last = interpolator.tick();
        moved += u32::from(last.activity == Activity::Running);
        if moved == LATE {
            break;
        }
    }
    command(controls);
    for cycle in 0.. {
        assert!(cycle < 200_000, "no end: {:?}", planner.counters());
        left = in_time(&mut planner, left);
        let next = interpolator.tick();
        if shows([&last, &next]) {
            return cycle;
        }
        last = next;
    }
    unreachable!("it shows or takes too long")
}

/// All that can be done in a servo cycle.
fn in_time<'a, S: Scalar>(
    planner: &mut Background<'_, S>,
    mut left: &'a [Block<S, AXES>],
) -> &'a [Block<S, AXES>] {
    for _ in 0..8 {
        left = push(planner, left);
        if !matches!(planner.settle(), Progress::Planning | Progress::Planned) {
            break;
        }
    }
    left
}

fn is_fast<S: Scalar>([_, now]: [&Setpoint<S, AXES>; 2]) -> bool {
    now.path_speed.to_f64() > 0.99 * FEED
}

fn is_slow<S: Scalar>([_, now]: [&Setpoint<S, AXES>; 2]) -> bool {
    now.path_speed.to_f64() < 0.11 * FEED
}

fn rests<S: Scalar>([before, now]: [&Setpoint<S, AXES>; 2]) -> bool {
    before.activity == Activity::Idle && now.activity == Activity::Idle
}

/// A command is answered as soon as planning is as fast as it is, not as it was.
fn commands<S: Scalar>() {
    let raised: fn(Controls<'_>) = |controls| controls.feed_override(100);
    let lowered: fn(Controls<'_>) = |controls| controls.feed_override(10);
    let held: fn(Controls<'_>) = |controls| controls.hold();
    for (name, command, percent, shows) in [
        ("raised", raised, 1, is_fast::<S> as Shows<S>),
        ("lowered", lowered, 100, is_slow::<S>),
        ("held", held, 100, rests::<S>),
    ] {
        let cycles = cycles_until(&straight::<S>(), percent, command, shows);
        assert!(cycles < SOON, "{name}: {cycles} servo cycles");
    }
}

#[test]
fn commands_are_answered_at_once_by_a_background_that_is_in_time_again() {
    commands::<f64>();
    commands::<f32>();
}

/// The motion does not stop before every plan any more.
#[test]
fn plans_follow_each_other_without_a_rest_when_the_background_is_in_time_again() {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let config = Config::new(Limits::new([axis; AXES]).unwrap());
    let mut link = Box::new(Link::<f64, AXES, 16, 64>::new());
    let (mut planner, mut interpolator): (Background<'_, f64>, Interpolator<'_, f64, AXES>) =
        link.split(config, [Coord::ZERO; AXES]).unwrap();
    let blocks = zigzag();
    let (mut left, mut moved, mut stops, mut after) = (&blocks[..], 0, 0, 0);
    for cycle in 0..400_000u32 {
        let late = moved < LATE;
        if late {
            left = push(&mut planner, left);
            if cycle % SLICE == 0 {
                planner.poll();
            }
        } else {
            left = in_time(&mut planner, left);
        }
        let setpoint = interpolator.tick();
        let runs = setpoint.activity == Activity::Running;
        moved += u32::from(runs);
        if !late && left.is_empty() {
            break;
        }
        after += u32::from(!late);
        // All but at rest.
        stops += u32::from(!late && setpoint.path_speed < 0.02 * FEED);
    }
    assert!(left.is_empty() && stops < 40, "{stops} of {after} servo cycles all but at rest");
}

/// What else is asked for when a hold is taken back.
#[derive(Clone, Copy, Debug)]
enum Besides {
    Nothing,
    /// Single block mode has been on from the beginning.
    Single,
    Stop,
}

/// Runs a line with so many slices in a servo cycle; a hold is given after so many cycles of motion, and taken back after as many more. Servo cycles to its end.
fn held_for_a_moment<S: Scalar>(slices: u32, hold: u32, resume: u32, besides: Besides) -> u32 {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let config = Config::new(Limits::new([axis; AXES]).unwrap());
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let controls = planner.controls();
    controls.single_block(matches!(besides, Besides::Single));
    push(&mut planner, &[line([4.0, 3.0], 1)]);
    let mut moved = 0;
    for cycle in 0..60_000 {
        let mut progress = Progress::Planning;
        for _ in 0..slices {
            progress = planner.poll();
            if progress != Progress::Planning {
                break;
            }
        }
        let runs = interpolator.tick().activity == Activity::Running;
        let rests = progress == Progress::Held && moved > hold + resume;
        if (progress == Progress::Done || rests) && !runs {
            return cycle;
        }
        moved += u32::from(runs || moved > 0);
        if moved == hold {
            controls.hold();
        } else if moved == hold + resume {
            controls.resume();
            if matches!(besides, Besides::Stop) {
                controls.stop();
            }
        }
    }
    panic!(
        "no end with {slices} slices, a hold at {hold} and a resume after {resume}: {:?}",
        planner.counters()
    );
}

/// What a hold has slowed the motion down to is no pace to go on at, also where all of the path is planned.
#[test]
fn a_hold_that_is_taken_back_leaves_no_crawl() {
    let usual = held_for_a_moment::<f64>(1000, u32::MAX / 2, 0, Besides::Nothing);
    for slices in [1, 2, 4, 8] {
        for (hold, resume) in (1..60).flat_map(|hold| [1, 2, 4, 8, 16].map(|resume| (hold, resume)))
        {
            for besides in [Besides::Nothing, Besides::Single, Besides::Stop] {
                let times = [
                    held_for_a_moment::<f64>(slices, hold, resume, besides),
                    held_for_a_moment::<f32>(slices, hold, resume, besides),
                ];
                let most = times.into_iter().max().unwrap_or(0);
                assert!(
                    most < usual + 250,
                    "{slices} slices, a hold at {hold}, a resume after {resume}, {besides:?}: {most} servo cycles, {usual} without"
                );
            }
        }
    }
}

/// What a hold comes to that is given while the background is late.
struct Held {
    /// Servo cycles in which it is in time, to the rest.
    took: u32,
    /// Whether the machine has rested, and moved again.
    again: bool,
}

/// Lines and dwells at random; for some cycles there is a slice in `slice` of them, and a hold is given in that time. `None` if the machine did
/// not move when it was over.
fn held_while_late<S: Scalar>(seed: u64, slice: u64, cycles: u64) -> Option<Held> {
    let mut draw = Draw(seed | 1);
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(0.02);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let controls = planner.controls();
    let late = 50 + draw.between(0.0, 400.0) as u64;
    let hold = late + draw.between(0.0, cycles as f64) as u64;
    let (longest, dwells) = (draw.between(0.5, 8.0), draw.between(0.0, 0.3));
    let feed = S::of(draw.between(10.0, 100.0));
    let (mut at, mut course, mut tag) = ([0.0f64; AXES], 0.0f64, 0);
    let mut blocks = std::iter::from_fn(|| {
        tag += 1;
        if draw.chance(dwells) {
            return Some(Block::dwell(S::of(draw.between(0.0, 0.03)), tag));
        }
        course += draw.between(-1.5, 1.5);
        let length = draw.between(0.2, longest.max(0.3));
        at = [at[0] + length * course.cos(), at[1] + length * course.sin()];
        Some(Block::line(at.map(|mm| Coord::from_mm(mm).unwrap()), feed, tag))
    })
    .peekable();
    let (mut took, mut rested, mut again) = (0, false, false);
    for cycle in 1..late + cycles + 2000 {
        while blocks.next_if(|block| planner.push(block).is_ok()).is_some() {}
        if cycle == hold {
            controls.hold();
        }
        let is_late = (late..late + cycles).contains(&cycle);
        let mut progress = Progress::Planning;
        if !is_late {
            progress = planner.settle();
        } else if cycle % slice == 0 {
            planner.poll();
        }
        let moves = interpolator.tick().path_speed > S::ZERO;
        if cycle < late + cycles {
            continue;
        }
        if took == 0 && !moves {
            return None;
        }
        if progress == Progress::Held {
            return Some(Held { took, again });
        }
        took += 1;
        rested |= !moves;
        again |= rested && moves;
    }
    panic!("seed {seed}, a slice in {slice} cycles: no rest, {:?}", planner.counters())
}

/// A hold that a background has begun to answer while it was late is answered anew when it is not: the machine does not run on to where the stop would have
/// been by then, nor leave a rest that comes before.
#[test]
fn a_hold_is_answered_anew_by_a_background_that_is_in_time_again() {
    let mut holds = 0;
    for (slice, cycles) in [(3, 60), (5, 60), (5, 200), (10, 60), (10, 200), (20, 200), (40, 200)] {
        for seed in 0..100 * u64::from(soak()) {
            let seed = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
            let both = [
                held_while_late::<f64>(seed, slice, cycles),
                held_while_late::<f32>(seed, slice, cycles),
            ];
            for Held { took, again } in both.into_iter().flatten() {
                holds += 1;
                let name = format!("seed {seed}, a slice in {slice} cycles for {cycles} cycles");
                assert!(took < 200, "{name}: {took} servo cycles to the rest");
                assert!(!again, "{name}: it moves again");
            }
        }
    }
    assert!(holds > 700, "{holds}");
}

/// A dwell is cut short by a background that is late all the time, too, however short the lead.
#[test]
fn a_dwell_is_cut_short_by_a_background_that_stays_late() {
    for (slice, lead) in [(3, 0.0), (5, 0.003), (5, 0.0), (8, 0.01), (12, 0.05)] {
        let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
        let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
        config.lead = lead;
        let mut link = Box::new(Link::<f64, AXES, 16, 64>::new());
        let (mut planner, mut interpolator): (Background<'_, f64>, _) =
            link.split(config, [Coord::ZERO; AXES]).unwrap();
        let controls = planner.controls();
        let mut blocks = vec![];
        for n in 0..20 {
            let x = f64::from(n + 1);
            blocks.extend([line([x, 0.0], 2 * n), Block::dwell(0.5, 2 * n + 1)]);
        }
        let (mut left, mut dwelled, mut held) = (&blocks[..], 0, 0);
        for cycle in 0..20_000u32 {
            left = push(&mut planner, left);
            let mut progress = Progress::Planning;
            if cycle % slice == 0 {
                progress = planner.poll();
            }
            let setpoint = interpolator.tick();
            // In the third, when what slices take is known.
            dwelled += u32::from(setpoint.activity == Activity::Dwelling && setpoint.tag == 5);
            if dwelled == 100 {
                controls.hold();
            }
            assert!(dwelled < 100 || setpoint.path_speed == 0.0, "{slice}, {lead}: it moves");
            held += u32::from(progress == Progress::Held);
            if held > 100 {
                break;
            }
        }
        assert!(held > 100 && dwelled < 250, "{slice}, {lead}: {dwelled} servo cycles of 500");
    }
}
