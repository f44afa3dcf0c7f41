//! Limits that change between blocks, and stops by the stop limits: random programs on random machines, against a check of
//! the limits that knows setpoints and the blocks they belong to.

mod common;
#[path = "common/motors.rs"]
mod motors;

use common::config;
use motors::{motor_shares, with_motors, with_stops};
use proptest::prelude::*;
use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Feed, Interpolator, Limits, Link, Motion, Planner,
    Progress, PushError, Scalar, Setpoint,
};

const AXES: usize = 3;
type Point = [Coord; AXES];
type Core<'a, S> = (Planner<'a, S, AXES, 16, 64>, Interpolator<'a, S, AXES>);

fn at(mm: f64) -> Coord {
    Coord::from_mm(mm).unwrap()
}

/// Random numbers of no great quality.
struct Draw(u64);

impl Draw {
    fn share(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }
    fn scale(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }
    fn below(&mut self, count: usize) -> usize {
        (self.share() * count as f64) as usize
    }
    fn chance(&mut self, of: f64) -> bool {
        self.share() < of
    }
}

fn limits<S: Scalar>(draw: &mut Draw) -> Limits<S, AXES> {
    let axes = std::array::from_fn(|_| {
        let [v, a, j] = [(20.0, 300.0), (200.0, 5.0e3), (5.0e3, 2.0e5)];
        let mut draw = |(least, most)| S::of(draw.scale(least, most));
        AxisLimits::linear(draw(v), draw(a), draw(j))
    });
    Limits::new(axes).unwrap()
}

/// Others for the same machine, as often as not for its motors too.
fn changed<S: Scalar>(draw: &mut Draw, now: &Limits<S, AXES>) -> Limits<S, AXES> {
    let new = limits(draw);
    with_stops(new, now, || draw.share())
}

/// The greater of two limits of acceleration and jerk.
fn greater<S: Scalar>(a: &Limits<S, AXES>, b: &Limits<S, AXES>) -> Limits<S, AXES> {
    let axes = std::array::from_fn(|i| {
        let (a, b) = (&a.axes()[i], &b.axes()[i]);
        let most = |a: S, b: S| if a > b { a } else { b };
        AxisLimits::linear(a.velocity, most(a.acceleration, b.acceleration), most(a.jerk, b.jerk))
    });
    Limits::new(axes).unwrap()
}

/// The greatest shares of limits that were seen.
struct Watch<S> {
    cycle: f64,
    before: Option<(Setpoint<S, AXES>, [Limits<S, AXES>; 2])>,
    most: [f64; 3],
    /// Of a motor.
    motor: [f64; 3],
}

impl<S: Scalar> Watch<S> {
    fn new(config: &Config<S, AXES>) -> Self {
        Self { cycle: config.cycle.to_f64(), before: None, most: [0.0; 3], motor: [0.0; 3] }
    }

    fn rounding() -> f64 {
        if S::NAME == "f32" { 3.0e-3 } else { 1.0e-6 }
    }

    /// A setpoint, the limits of its block, and what counts of others.
    fn see(&mut self, now: &Setpoint<S, AXES>, limits: Limits<S, AXES>, more: &Limits<S, AXES>) {
        let both = [limits, *more];
        let Some((before, earlier)) = self.before.replace((*now, both)) else { return };
        // Within the cycle another block may have begun.
        let others = [more, &earlier[0], &earlier[1]];
        let seen = (self.cycle, Self::rounding());
        let motor = motor_shares((&limits, &others), [&before, now], seen);
        let (limits, earlier) = (greater(&limits, more), greater(&earlier[0], &earlier[1]));
        for (most, seen) in self.motor.iter_mut().zip(motor) {
            *most = most.max(seen);
        }
        for i in 0..AXES {
            let (axis, other) = (&limits.axes()[i], &earlier.axes()[i]);
            let gain = (now.acceleration[i] - before.acceleration[i]).to_f64() / self.cycle;
            // Within the cycle another block may have begun.
            let jerk = axis.jerk.to_f64().max(other.jerk.to_f64());
            let seen = [
                now.velocity[i].to_f64().abs() / axis.velocity.to_f64(),
                now.acceleration[i].to_f64().abs() / axis.acceleration.to_f64(),
                gain.abs() / (jerk + Self::rounding() * axis.acceleration.to_f64() / self.cycle),
            ];
            for (most, seen) in self.most.iter_mut().zip(seen) {
                *most = most.max(seen);
            }
        }
    }

    fn check(&self, what: &str) {
        let [v, a, j] = self.most;
        let most = 1.0 + Self::rounding();
        assert!(v <= most && a <= most && j <= most, "{what}: {:?}", self.most);
        assert!(self.motor.iter().all(|seen| *seen <= most), "{what}, motor: {:?}", self.motor);
    }
}

fn machine<S: Scalar>(draw: &mut Draw) -> Config<S, AXES> {
    let mut config = Config::new(with_motors(limits(draw), || draw.share()));
    config.cycle = S::of([1.0e-3, 0.5e-3][draw.below(2)]);
    config.tolerance = S::of(draw.scale(0.005, 0.2));
    config
}

/// Blocks of all kinds, mostly in runs and corners.
fn block<S: Scalar>(draw: &mut Draw, from: &Point, tag: u32, feed: f64) -> Block<S, AXES> {
    let size = draw.scale(0.2, 20.0);
    let mut away = |axis: usize, share: f64| {
        let by = if axis < 2 { draw.between(-size, size) } else { draw.between(-share, share) };
        at((from[axis].to_mm() + by).clamp(-500.0, 500.0))
    };
    let to: Point = std::array::from_fn(|i| away(i, size * 0.2));
    let mut block = Block::line(to, S::of(feed), tag);
    if draw.chance(0.15) {
        let [x, y, z] = *from;
        let r = draw.scale(0.5, 10.0);
        let end = [at(x.to_mm() + 2.0 * r), y, z];
        let centre = (at(x.to_mm() + r), y);
        let turn = if draw.chance(0.5) {
            splineway::Turn::Clockwise
        } else {
            splineway::Turn::CounterClockwise
        };
        block.motion = Motion::Arc { to: end, plane: (0, 1), centre, turn, extra_turns: 0 };
    }
    if draw.chance(0.1) {
        block.feed = Feed::Rapid;
    }
    block
}

/// What the operator does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Presses {
    Nothing,
    QuickHolds,
    Anything,
}

/// Presses something. Whether the stop limits count from now on.
fn press(draw: &mut Draw, controls: splineway::Controls<'_>, presses: Presses) -> bool {
    let kind = if presses == Presses::QuickHolds { 0 } else { draw.below(10) };
    match kind {
        0 => controls.quick_hold(),
        1 => controls.quick_abort(),
        2 => controls.hold(),
        3 => controls.resume(),
        4 => controls.stop(),
        5 => controls.abort(),
        6 | 7 => controls.feed_override(draw.between(10.0, 200.0) as u16),
        8 => controls.rapid_override(draw.between(10.0, 100.0) as u16),
        _ => controls.single_block(draw.chance(0.3)),
    }
    kind < 2
}

/// Random blocks, before some of which the limits change. Every block has its own tag.
fn random_changes<S: Scalar>(seed: u64, presses: Presses) {
    let mut draw = Draw(seed | 1);
    let mut config = machine::<S>(&mut draw);
    let stop = changed(&mut draw, &config.limits);
    config.stop_limits = (presses != Presses::Nothing).then_some(stop);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator): Core<'_, S> =
        link.split(config, [Coord::ZERO; AXES]).unwrap();
    // Of the blocks by their tags, from 1 on.
    let mut sets = vec![config.limits];
    let (count, often) = (10 + draw.below(50), draw.between(0.1, 0.8));
    let feed = draw.scale(10.0, 400.0);
    let mut watch = Watch::new(&config);
    let mut wanted = None;
    let slices = if draw.chance(0.5) { 0 } else { 1 + draw.below(6) };
    let controls = planner.controls();
    let (mut braking, mut held, mut idle, mut refused) = (false, 0, 0, 0);
    for _ in 0..2_000_000 {
        while sets.len() <= count {
            let block = wanted.get_or_insert_with(|| {
                if draw.chance(often)
                    && planner.set_limits(changed(&mut draw, planner.limits())).is_err()
                {
                    refused += 1;
                }
                block::<S>(&mut draw, planner.end(), sets.len() as u32, feed)
            });
            match planner.push(block) {
                Ok(()) => {
                    wanted = None;
                    sets.push(*planner.limits());
                }
                Err(PushError::Full | PushError::Aborted) => break,
                Err(error) => panic!("{error}"),
            }
        }
        if sets.len() > count {
            planner.finish();
        }
        // Planning may be late.
        let progress = match slices {
            0 => planner.settle(),
            _ => (0..slices).map(|_| planner.poll()).last().unwrap(),
        };
        let setpoint = interpolator.tick();
        let running = setpoint.activity == Activity::Running;
        braking &= running;
        let limits = sets[setpoint.tag as usize];
        watch.see(&setpoint, limits, if braking { &stop } else { &limits });
        match progress {
            Progress::Held => {
                held += 1;
                if held > 20 {
                    controls.resume();
                    held = 0;
                }
            }
            Progress::Aborted => {
                assert!(planner.acknowledge_abort());
                wanted = None;
            }
            Progress::Done if setpoint.activity == Activity::Idle => break,
            _ => {}
        }
        if presses != Presses::Nothing && running && draw.chance(0.003) {
            braking |= press(&mut draw, controls, presses);
        }
        idle = if running || progress == Progress::Held { 0 } else { idle + 1 };
        assert!(idle < 2000, "seed {seed}: no motion from block {}", setpoint.tag);
    }
    assert_eq!(planner.settle(), Progress::Done, "seed {seed}");
    watch.check(&format!("seed {seed}, {refused} changes refused"));
}

proptest! {
    #![proptest_config(config(60))]
    #[test]
    fn every_block_keeps_its_own_limits(seed in any::<u64>()) {
        random_changes::<f64>(seed, Presses::Nothing);
    }

    #[test]
    fn every_block_keeps_its_own_limits_in_f32(seed in any::<u64>()) {
        random_changes::<f32>(seed, Presses::Nothing);
    }

    #[test]
    fn a_quick_hold_keeps_the_stop_limits(seed in any::<u64>()) {
        random_changes::<f64>(seed, Presses::QuickHolds);
    }

    #[test]
    fn a_quick_hold_keeps_the_stop_limits_in_f32(seed in any::<u64>()) {
        random_changes::<f32>(seed, Presses::QuickHolds);
    }

    #[test]
    fn whatever_is_pressed_limits_hold(seed in any::<u64>()) {
        random_changes::<f64>(seed, Presses::Anything);
    }

    #[test]
    fn whatever_is_pressed_limits_hold_in_f32(seed in any::<u64>()) {
        random_changes::<f32>(seed, Presses::Anything);
    }
}

fn usual<S: Scalar>() -> Config<S, AXES> {
    let axis = AxisLimits::linear(S::of(200.0), S::of(1000.0), S::of(2.0e4));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(0.05);
    config
}

/// Servo cycles from a command in motion at 100 mm/s to rest.
fn cycles_to_rest(config: &Config<f64, AXES>, command: impl Fn(&splineway::Controls<'_>)) -> u32 {
    let mut link = Box::new(Link::<f64, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(*config, [Coord::ZERO; AXES]).unwrap();
    planner.push(&Block::line([at(300.0), at(0.0), at(0.0)], 100.0, 1)).unwrap();
    planner.finish();
    for _ in 0..1000 {
        planner.settle();
        interpolator.tick();
    }
    command(&planner.controls());
    for cycles in 0..5000 {
        planner.settle();
        if interpolator.tick().activity == Activity::Idle {
            return cycles;
        }
    }
    panic!("no rest");
}

#[test]
fn each_command_says_by_which_limits_it_stops() {
    let mut config = usual::<f64>();
    let stop = AxisLimits::linear(200.0, 4000.0, 4.0e5);
    config.stop_limits = Some(Limits::new([stop; AXES]).unwrap());
    // 100 mm/s by 1,000 mm/s2 and 20,000 mm/s3 take 150 ms, by 4,000 and 400,000 35 ms.
    let usual = 150..=160;
    let quick = 35..=40;
    assert!(usual.contains(&cycles_to_rest(&config, |controls| controls.hold())));
    assert!(usual.contains(&cycles_to_rest(&config, |controls| controls.abort())));
    assert!(quick.contains(&cycles_to_rest(&config, |controls| controls.quick_hold())));
    assert!(quick.contains(&cycles_to_rest(&config, |controls| controls.quick_abort())));
    // A quick one that has been taken back is no reason for the next to be quick.
    let taken_back = cycles_to_rest(&config, |controls| {
        controls.quick_hold();
        controls.resume();
    });
    assert!(taken_back > 900);
    // Lower stop limits than those of the motion say nothing.
    config.stop_limits = Some(Limits::new([AxisLimits::linear(200.0, 10.0, 100.0); 3]).unwrap());
    assert!(usual.contains(&cycles_to_rest(&config, |controls| controls.quick_hold())));
    config.stop_limits = None;
    assert!(usual.contains(&cycles_to_rest(&config, |controls| controls.quick_hold())));
}

#[test]
fn a_change_counts_from_its_block_on() {
    let config = usual::<f64>();
    let calm = Limits::new([AxisLimits::linear(50.0, 100.0, 1000.0); AXES]).unwrap();
    let mut link = Box::new(Link::<f64, AXES, 16, 64>::new());
    let (mut planner, mut interpolator): Core<'_, f64> =
        link.split(config, [Coord::ZERO; AXES]).unwrap();
    let line = |x: f64, tag| Block::line([at(x), at(0.0), at(0.0)], 150.0, tag);
    planner.push(&line(100.0, 1)).unwrap();
    // What is not used is as if it had not been set.
    for _ in 0..20 {
        planner.set_limits(config.limits).unwrap();
    }
    planner.set_limits(calm).unwrap();
    assert_eq!(planner.limits(), &calm);
    planner.push(&line(150.0, 2)).unwrap();
    planner.set_limits(config.limits).unwrap();
    planner.push(&line(250.0, 3)).unwrap();
    planner.finish();
    let mut most = [[0.0f64; 2]; 4];
    while planner.settle() != Progress::Done || interpolator.tick().activity != Activity::Idle {
        let setpoint = interpolator.tick();
        let seen = &mut most[setpoint.tag as usize];
        seen[0] = seen[0].max(setpoint.velocity[0]);
        seen[1] = seen[1].max(setpoint.acceleration[0].abs());
    }
    for tag in [1, 3] {
        assert!(most[tag][0] > 149.0 && most[tag][1] > 950.0, "{most:?}");
    }
    assert!(most[2][0] <= 50.0 && most[2][0] > 49.0 && most[2][1] <= 100.0, "{most:?}");
}
