//! Overrides at random instants of random paths, with as many slices of planning in a servo cycle as there are: limits, band, order
//! and end in every cycle; and the motion that is too fast for a lowered override slows down nearly as fast as the limits allow.

use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress, PushError, Scalar,
};

const AXES: usize = 2;
const VELOCITY: f64 = 200.0;
const ACCELERATION: f64 = 2000.0;
const JERK: f64 = 50_000.0;
const TOLERANCE: f64 = 0.05;
/// s.
const CYCLE: f64 = 1.0e-3;
/// Servo cycles in which a run ends.
const LONGEST: u32 = 120_000;
/// Slices of planning in a servo cycle: as many as there is something to do, and fewer than a plan takes.
const SLICES: [u32; 4] = [100_000, 30, 10, 4];
/// More slices than all that can be planned in a servo cycle takes.
const ENDLESS: u32 = 20_000;
/// Speeds above what is asked for by less than this share are none.
const ROUNDED: f64 = 1.0e-3;

type Point = [f64; AXES];

/// The same draws in every run.
struct Draws(u64);

impl Draws {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.unit()
    }

    fn below(&mut self, end: u32) -> u32 {
        (self.unit() * f64::from(end)) as u32
    }
}

/// A program of lines.
struct Path {
    points: Vec<Point>,
    /// Of the line to each point but the first, mm/s; 0 for a rapid.
    feeds: Vec<f64>,
}

impl Path {
    /// Long lines with corners, some of them rapids, or a run of short lines along a bend.
    fn any(draws: &mut Draws, rapids: bool) -> Self {
        let feed = draws.between(30.0, 200.0);
        let points: Vec<Point> = if draws.below(2) == 0 {
            let count = 3 + draws.below(9);
            (0..count).map(|_| [draws.between(0.0, 40.0), draws.between(0.0, 40.0)]).collect()
        } else {
            let (radius, step) = (draws.between(2.0, 20.0), draws.between(0.05, 1.0));
            let count = 60 + draws.below(150);
            (0..count)
                .map(|i| f64::from(i) * step / radius)
                .map(|turn| [radius * turn.cos() + 0.3 * (3.0 * turn).sin(), radius * turn.sin()])
                .collect()
        };
        let grid = |mm: f64| (mm * 1.0e6).round() * 1.0e-6;
        let points: Vec<Point> = points.into_iter().map(|at| at.map(grid)).collect();
        let mut feed_of = || if rapids && draws.below(4) == 0 { 0.0 } else { feed };
        let feeds = points[1..].iter().map(|_| feed_of()).collect();
        Self { points, feeds }
    }

    fn blocks<S: Scalar>(&self) -> Vec<Block<S, AXES>> {
        let lines = self.points[1..].iter().zip(&self.feeds).zip(1..);
        lines
            .map(|((to, feed), tag)| match feed {
                0.0 => Block::rapid(coordinates(*to), tag),
                _ => Block::line(coordinates(*to), S::of(*feed), tag),
            })
            .collect()
    }

    /// Distance of a place from the lines, mm.
    fn distance(&self, at: Point) -> f64 {
        let apart = |ends: &[Point]| {
            let ([ax, ay], [bx, by]) = (ends[0], ends[1]);
            let (dx, dy) = (bx - ax, by - ay);
            let along = (at[0] - ax) * dx + (at[1] - ay) * dy;
            let t = (along / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
            f64::hypot(at[0] - ax - t * dx, at[1] - ay - t * dy)
        };
        self.points.windows(2).map(apart).fold(f64::INFINITY, f64::min)
    }
}

fn coordinates(at: Point) -> [Coord; AXES] {
    at.map(|mm| Coord::from_mm(mm).unwrap())
}

/// What a servo cycle gave.
#[derive(Clone, Copy, Debug)]
struct Sample {
    velocity: [f64; AXES],
    acceleration: [f64; AXES],
    speed: f64,
    tag: u32,
}

/// What an operator turns in a servo cycle.
#[derive(Clone, Copy, Debug)]
enum Turn {
    Feed(u16),
    Rapid(u16),
    Hold,
    Resume,
    Stop,
    Single(bool),
}

/// Runs a program while planning has so many slices in a servo cycle; what it gave, cycle by cycle, or in words what went wrong.
fn run<S: Scalar>(path: &Path, turns: &[(u32, Turn)], slices: u32) -> Result<Vec<Sample>, String> {
    let rounding = if S::EPSILON.to_f64() > 1e-10 { 2.0e-3 } else { 1.0e-3 };
    let axis = AxisLimits::linear(S::of(VELOCITY), S::of(ACCELERATION), S::of(JERK));
    let mut settings = Config::new(Limits::new([axis; AXES]).unwrap());
    settings.tolerance = S::of(TOLERANCE);
    let blocks = path.blocks::<S>();
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) =
        link.split(settings, coordinates(path.points[0])).unwrap();
    let controls = planner.controls();
    let (mut next, mut samples) = (0, Vec::<Sample>::new());
    let last = turns.iter().map(|(cycle, _)| *cycle).max().unwrap_or(0);
    for cycle in 0..LONGEST {
        for (_, turn) in turns.iter().filter(|(when, _)| *when == cycle) {
            match *turn {
                Turn::Feed(percent) => controls.feed_override(percent),
                Turn::Rapid(percent) => controls.rapid_override(percent),
                Turn::Hold => controls.hold(),
                Turn::Resume => controls.resume(),
                Turn::Stop => controls.stop(),
                Turn::Single(on) => controls.single_block(on),
            }
        }
        if cycle > last && cycle % 1000 == 999 {
            controls.single_block(false);
            controls.resume();
        }
        let mut progress = Progress::Planning;
        let mut polls = 0;
        while polls < slices && matches!(progress, Progress::Planning | Progress::Planned) {
            while next < blocks.len() {
                match planner.push(&blocks[next]) {
                    Ok(()) => next += 1,
                    Err(PushError::Full) => break,
                    Err(error) => return Err(error.to_string()),
                }
            }
            if next == blocks.len() {
                planner.finish();
            }
            progress = planner.poll();
            polls += 1;
            if polls > ENDLESS {
                return Err(format!("cycle {cycle}: no end of planning"));
            }
        }
        let setpoint = interpolator.tick();
        let sample = Sample {
            velocity: setpoint.velocity.map(Scalar::to_f64),
            acceleration: setpoint.acceleration.map(Scalar::to_f64),
            speed: setpoint.path_speed.to_f64(),
            tag: setpoint.tag,
        };
        let fail = |what: String| Err(format!("cycle {cycle}, line {}: {what}", setpoint.tag));
        let before = samples.last().copied();
        for axis in 0..AXES {
            let used = [
                sample.velocity[axis] / VELOCITY,
                sample.acceleration[axis] / ACCELERATION,
                before.map_or(0.0, |before| {
                    (sample.acceleration[axis] - before.acceleration[axis]) / CYCLE / JERK
                }),
            ];
            if used.iter().any(|share| share.abs() > 1.0 + rounding) {
                return fail(format!("axis {axis}: {used:?} of the limits"));
            }
        }
        let here = [0, 1].map(|axis| setpoint.position_mm(axis));
        let distance = path.distance(here);
        if distance > TOLERANCE * (1.0 + 1.0e-6) + 2.0e-6 {
            return fail(format!("{distance} mm off the path"));
        }
        if before.is_some_and(|before| setpoint.tag < before.tag) {
            return fail("a line that was before".into());
        }
        samples.push(sample);
        if progress == Progress::Done
            && setpoint.activity == Activity::Idle
            && cycle >= last.min(LONGEST)
        {
            let end = path.points[path.points.len() - 1];
            let off = f64::hypot(here[0] - end[0], here[1] - end[1]);
            return if off < 1.0e-5 { Ok(samples) } else { fail(format!("{off} mm from the end")) };
        }
    }
    Err(format!("no end: {:?}", planner.counters()))
}

/// The least time, s, for which a motion is faster than `speed` from now on if it does all it can to be slower, on a straight in the
/// direction in which it goes: jerk takes the acceleration to its depth and back to none.
fn shortest_fall(at: &Sample, speed: f64) -> f64 {
    let size = f64::hypot(at.velocity[0], at.velocity[1]);
    if !(size > 0.0) {
        return 0.0;
    }
    let along = [0, 1].map(|i| at.velocity[i] / size);
    let share = along[0].abs().max(along[1].abs());
    let (acceleration, jerk) = (ACCELERATION / share, JERK / share);
    let slows = -(at.acceleration[0] * along[0] + at.acceleration[1] * along[1]);
    let excess = size - speed;
    // A motion that gathers speed still does until jerk has taken its acceleration away.
    let gains = if slows < 0.0 { slows * slows / (2.0 * jerk) } else { 0.0 };
    if excess + gains <= 0.0 {
        return 0.0;
    }
    // If what it slows down by already, let go of at once, takes it there, it cannot be hurried.
    if slows > 0.0 && slows * slows / (2.0 * jerk) >= excess {
        return excess / slows;
    }
    let free = (jerk * excess + slows * slows / 2.0).sqrt();
    let depth = free.min(acceleration);
    let sides = (2.0 * depth * depth - slows * slows) / (2.0 * jerk);
    let time = (2.0 * depth - slows) / jerk + (excess - sides).max(0.0) / depth;
    // As long as it has not got to that speed yet it is not faster.
    let before = if excess < 0.0 {
        (-slows - (slows * slows + 2.0 * jerk * excess).sqrt()) / jerk
    } else {
        0.0
    };
    time - before
}

/// Servo cycles from the command on in which a motion is faster than what is asked for, beyond those that the shortest fall takes.
fn excess(path: &Path, samples: &[Sample], pressed: u32, percent: u16) -> f64 {
    let asked = |tag: u32| {
        let feed = path.feeds.get((tag as usize).wrapping_sub(1)).copied().unwrap_or(0.0);
        if feed > 0.0 { feed * f64::from(percent) * 0.01 } else { f64::INFINITY }
    };
    let pressed = pressed as usize;
    let Some(at) = samples.get(pressed.wrapping_sub(1)) else { return 0.0 };
    let fast = samples[pressed..]
        .iter()
        .filter(|sample| sample.speed > asked(sample.tag) * (1.0 + ROUNDED))
        .count();
    let least = shortest_fall(at, asked(at.tag)) / CYCLE;
    (fast as f64 - least).max(0.0)
}

/// Paths of the statistics; `SOAK=10` takes ten times as many.
const PATHS: u64 = 40;

fn paths(count: u64) -> std::ops::RangeInclusive<u64> {
    let soak = std::env::var("SOAK").ok().and_then(|factor| factor.parse::<u64>().ok());
    1..=count * soak.unwrap_or(1)
}

/// A path, when an override is lowered on it, and to what.
fn lowered(seed: u64, rapids: bool) -> (Path, Vec<Sample>, u32, u16) {
    let mut draws = Draws::new(seed);
    let path = Path::any(&mut draws, rapids);
    let free = run::<f64>(&path, &[], SLICES[0]).unwrap();
    let pressed = 1 + draws.below(free.len() as u32 * 9 / 10);
    let percent = 10 + draws.below(61) as u16;
    (path, free, pressed, percent)
}

/// The mean of some numbers, and what nine of ten do not exceed.
fn mean_and_most(mut all: Vec<f64>) -> (f64, f64) {
    all.sort_by(f64::total_cmp);
    (all.iter().sum::<f64>() / all.len() as f64, all[all.len() * 9 / 10])
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Runs of all paths in either precision with so many slices.
fn falls<S: Scalar>(slices: u32) -> (Vec<f64>, Vec<f64>) {
    let (mut excesses, mut delays) = (Vec::new(), Vec::new());
    for seed in paths(PATHS) {
        let (path, free, pressed, percent) = lowered(seed, false);
        let turns = [(pressed, Turn::Feed(percent))];
        let samples = run::<S>(&path, &turns, slices)
            .unwrap_or_else(|what| panic!("seed {seed}, {slices} slices: {what}"));
        excesses.push(excess(&path, &samples, pressed, percent));
        if free[pressed as usize - 1].speed > path.feeds[0] * f64::from(percent) * 0.01 {
            delays.push(delay(&free, &samples, pressed));
        }
    }
    (excesses, delays)
}

/// Servo cycles from the command on until the motion is slower than without it.
fn delay(free: &[Sample], samples: &[Sample], pressed: u32) -> f64 {
    let pairs = free.iter().zip(samples).skip(pressed as usize);
    pairs.take_while(|(free, here)| here.speed > free.speed * (1.0 - ROUNDED)).count() as f64
}

/// The speed begins to fall within a few servo cycles, and comes down nearly as fast as the limits allow, however few slices of planning there are
/// in a cycle. (What remains is mostly where the motion is at the limits of its axes all the time, in bends: no clock slows it down at once there.)
fn a_lowered_override_is_answered_at_once<S: Scalar>() {
    for slices in SLICES {
        let (excesses, delays) = falls::<S>(slices);
        let (mean, most) = mean_and_most(excesses);
        assert!(mean < 18.0 && most < 60.0, "{slices} slices: too fast for {mean}, {most} cycles");
        let (middle, (mean, _)) = (median(delays.clone()), mean_and_most(delays));
        assert!(
            middle <= 5.0 && mean < 14.0,
            "{slices} slices: slower after {middle}, in the mean {mean} cycles"
        );
    }
}

#[test]
fn a_lowered_override_is_answered_at_once_in_f64() {
    a_lowered_override_is_answered_at_once::<f64>();
}

#[test]
fn a_lowered_override_is_answered_at_once_in_f32() {
    a_lowered_override_is_answered_at_once::<f32>();
}

/// Whatever is turned, pressed and taken back meanwhile.
fn any_turns(draws: &mut Draws, cycles: u32, often: u32) -> Vec<(u32, Turn)> {
    let (mut turns, mut cycle) = (Vec::new(), draws.below(cycles));
    for _ in 0..=draws.below(60) {
        let percent = [0, 1, 5, 20, 50, 80, 100, 100, 150, 200][draws.below(10) as usize];
        let turn = match draws.below(16) {
            0..=9 => Turn::Feed(percent),
            10 | 11 => Turn::Rapid(percent),
            12 => Turn::Hold,
            13 => Turn::Resume,
            14 => Turn::Stop,
            _ => Turn::Single(draws.below(2) == 0),
        };
        turns.push((cycle, turn));
        let most = if draws.below(4) == 0 { 200 } else { often };
        cycle += draws.below(most);
    }
    let end = cycle + 1;
    turns.extend(
        [Turn::Single(false), Turn::Feed(100), Turn::Rapid(100), Turn::Resume]
            .map(|turn| (end, turn)),
    );
    turns
}

/// Where a plan ahead on offer kept an answer waiting at a crawl, and where a rest of a hold was put too near to a station.
const FOUND: [u64; 2] = [364, 711];

fn nothing_is_exceeded_or_lost<S: Scalar>() {
    for seed in paths(120).chain(FOUND) {
        let mut draws = Draws::new(seed + 1000);
        let path = Path::any(&mut draws, true);
        let turns = any_turns(&mut draws, 600, 1 + seed as u32 % 20);
        for slices in SLICES.into_iter().chain([1]) {
            let outcome = run::<S>(&path, &turns, slices);
            assert!(outcome.is_ok(), "seed {seed}, {slices} slices: {}", outcome.unwrap_err());
        }
    }
}

#[test]
fn nothing_is_exceeded_or_lost_in_f64() {
    nothing_is_exceeded_or_lost::<f64>();
}

#[test]
fn nothing_is_exceeded_or_lost_in_f32() {
    nothing_is_exceeded_or_lost::<f32>();
}

/// An override that is lowered and soon raised again costs the time in between and that of the ramps: the motion does not stay slow. With one
/// slice in a servo cycle a plan takes half a second.
#[test]
fn a_raised_override_is_answered_whatever_was_before() {
    for (slices, allowed) in [(100_000, 20.0), (30, 20.0), (10, 40.0), (4, 90.0), (1, 600.0)] {
        let mut later = Vec::new();
        for seed in paths(PATHS) {
            let (path, free, pressed, percent) = lowered(seed, true);
            let wait = 1 + (seed * 37 % 200) as u32;
            let turns = [(pressed, Turn::Feed(percent)), (pressed + wait, Turn::Feed(100))];
            let samples = run::<f64>(&path, &turns, slices).unwrap();
            later.push(samples.len() as f64 - free.len() as f64 - f64::from(wait));
        }
        let (mean, _) = mean_and_most(later);
        assert!(mean < allowed, "{slices} slices: {mean} cycles later");
    }
}

/// An override that is raised from next to nothing in a servo cycle, before a stop or without one: cycles from the resume until nine tenths of what is
/// asked for are reached, on lines of so many mm.
fn raised(
    polls: u32,
    (length, feed): (f64, f64),
    [from, to]: [u16; 2],
    (pressed, stop): (u32, Option<u32>),
) -> u32 {
    let axis = AxisLimits::linear(VELOCITY, ACCELERATION, JERK);
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = TOLERANCE;
    let mut link = Box::new(Link::<f64, AXES>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let controls = planner.controls();
    controls.feed_override(from);
    let (mut lines, mut passed) = (0, 0.0);
    let resumed = pressed + stop.map_or(0, |after| after + 30);
    for cycle in 0..resumed + 4000 {
        // Long ones run on straight.
        while f64::from(lines) * length < passed + 800.0 {
            let beside = if length < 100.0 { 0.01 * f64::from(lines % 2) } else { 0.0 };
            let to = coordinates([f64::from(lines + 1) * length, beside]);
            if planner.push(&Block::line(to, feed, lines)).is_err() {
                break;
            }
            lines += 1;
        }
        if cycle == pressed {
            controls.feed_override(to);
        }
        if stop.is_some_and(|after| cycle == pressed + after) {
            controls.stop();
        }
        if cycle == resumed {
            controls.resume();
        }
        for _ in 0..polls {
            planner.poll();
        }
        let wanted = (feed * f64::from(to) / 100.0).min(VELOCITY);
        let setpoint = interpolator.tick();
        if setpoint.path_speed >= 0.9 * wanted && cycle > resumed {
            return cycle - resumed;
        }
        passed = setpoint.path_mm();
    }
    u32::MAX
}

/// A raised override is followed, whatever the motion was doing: with one slice in a servo cycle the plan for it takes some fifty cycles, and the fall to a stop
/// that is taken back as many.
#[test]
fn a_raised_override_is_followed_from_next_to_nothing() {
    for (polls, allowed) in [(1, 500), (3, 300), (10, 300), (50, 250)] {
        for length in [0.5, 2.0, 10.0, 600.0] {
            for feed in [10.0, 90.0] {
                for range in [[1, 100], [10, 100], [1, 10]] {
                    for pressed in [400, 1500] {
                        for stop in [None, Some(5), Some(40), Some(200)] {
                            let taken = raised(polls, (length, feed), range, (pressed, stop));
                            assert!(
                                taken < allowed,
                                "{polls} polls, lines of {length}, feed {feed}, {range:?} % at {pressed}, stop {stop:?}: {taken}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// Overrides that change every few servo cycles for a second: planning comes to an end in every cycle, and the motion goes on.
#[test]
fn overrides_that_change_all_the_time_leave_time_for_blocks() {
    for slices in [SLICES[0], 30] {
        for seed in paths(20) {
            let mut draws = Draws::new(seed + 5000);
            let path = Path::any(&mut draws, false);
            let free = run::<f64>(&path, &[], SLICES[0]).unwrap();
            let every = 2 + draws.below(6);
            let turns: Vec<_> = (0..1000 / every)
                .map(|k| (50 + k * every, Turn::Feed(60 + draws.below(41) as u16)))
                .chain([(1050, Turn::Feed(100))])
                .collect();
            let samples = run::<f64>(&path, &turns, slices)
                .unwrap_or_else(|what| panic!("seed {seed}, {slices} slices: {what}"));
            // At 60 per cent for a second, and what the changes cost.
            let most = free.len().max(1050) as f64 + 1000.0;
            assert!(
                (samples.len() as f64) < most,
                "seed {seed}, {slices}: {} {most}",
                samples.len()
            );
        }
    }
}

/// A line on which the override is lowered, a hold is given and taken back, with so many polls in a servo cycle, and the speed after so many more.
fn lowered_and_held<S: Scalar>(
    (polls, lead): (u32, f64),
    [from, to]: [u16; 2],
    [hold, resume]: [u32; 2],
) -> f64 {
    let axis = AxisLimits::linear(S::of(VELOCITY), S::of(ACCELERATION), S::of(JERK));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.lead = S::of(lead);
    let mut link = Box::new(Link::<S, AXES>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let controls = planner.controls();
    controls.feed_override(from);
    let end = [3000.0, 0.0].map(|mm| Coord::from_mm(mm).unwrap());
    planner.push(&Block::line(end, S::of(90.0), 1)).unwrap();
    planner.finish();
    planner.settle();
    let mut speed = 0.0;
    for cycle in 0..2600 {
        if cycle == 300 {
            controls.feed_override(to);
        }
        if cycle == 300 + hold {
            controls.hold();
        }
        if cycle == 300 + resume {
            controls.resume();
        }
        for _ in 0..polls {
            planner.poll();
        }
        speed = interpolator.tick().path_speed.to_f64();
    }
    speed
}

/// A hold that is taken back while the motion brakes loses no lowered override: it does not go on at what was asked for before.
#[test]
fn a_lowered_override_outlasts_a_hold() {
    for (polls, lead) in [(1, 0.01), (3, 0.0), (50, 0.01), (300, 0.01), (300, 0.0)] {
        for (from, to) in [(200, 1), (200, 10), (100, 1), (100, 10)] {
            for (hold, wait) in [(0, 3), (0, 23), (0, 40), (0, 80), (3, 10), (60, 30), (130, 20)] {
                let times = [hold, hold + wait];
                let most = 0.9 * f64::from(to) * 1.1;
                for speed in [
                    lowered_and_held::<f64>((polls, lead), [from, to], times),
                    lowered_and_held::<f32>((polls, lead), [from, to], times),
                ] {
                    assert!(
                        speed < most,
                        "{polls} polls, lead {lead}, {from} to {to} %, {times:?}: {speed} mm/s"
                    );
                }
            }
        }
    }
}

/// Servo cycles until the motion is no faster than a hundredth of the feed, and a tenth of that: it is lowered to that some cycles after it was from 150 to 30 %,
/// with a burst of slices in one servo cycle of some, and all that is to do from `more` cycles later on.
fn lowered_again(feed: f64, (apart, burst): (u32, u32), gap: u32, more: u32) -> u32 {
    const PRESSED: u32 = 500;
    let axis = AxisLimits::linear(VELOCITY, ACCELERATION, JERK);
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = TOLERANCE;
    let mut link = Box::new(Link::<f64, AXES>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    planner.push(&Block::line(coordinates([600.0, 0.0]), feed, 1)).unwrap();
    planner.finish();
    let controls = planner.controls();
    controls.feed_override(150);
    let fast = PRESSED + gap + more;
    for cycle in 0..fast + 3000 {
        if cycle == PRESSED {
            controls.feed_override(30);
        }
        if cycle == PRESSED + gap {
            controls.feed_override(1);
        }
        if !(PRESSED - 50..fast).contains(&cycle) {
            planner.settle();
        } else if cycle % apart == 0 {
            for _ in 0..burst {
                planner.poll();
            }
        }
        let setpoint = interpolator.tick();
        if cycle >= fast && setpoint.path_speed <= feed * 0.011 {
            return cycle - fast;
        }
    }
    u32::MAX
}

/// An answer that fell short was withdrawn for the next before it took effect, for ever; and a motion that had been slowed down counted as one that gets going.
#[test]
fn an_override_that_is_lowered_again_is_obeyed() {
    for feed in [10.0, 90.0] {
        for background in [(1, 1), (10, 1), (10, 5), (20, 5), (40, 5)] {
            for gap in [20, 60, 150] {
                for more in [10, 60, 100] {
                    let taken = lowered_again(feed, background, gap, more);
                    assert!(
                        taken < 200,
                        "{feed} mm/s, {background:?}, {gap} and {more}: {taken} cycles"
                    );
                }
            }
        }
    }
}
