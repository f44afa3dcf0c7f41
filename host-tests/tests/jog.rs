//! Jogs: random commands at random servo cycles, against a check of the limits that knows setpoints alone.

#[path = "common/cases.rs"]
mod cases;
#[path = "common/motors.rs"]
mod motors;

use motors::{motor_shares, with_motors};
use proptest::prelude::*;
use splineway::machine::Quantity;
use splineway::{
    Activity, AxisLimits, AxisTravel, Block, Config, Coord, Interpolator, Jog, JogError, Limits,
    Link, Planner, Progress, PushError, Scalar, Setpoint, Travel,
};

const AXES: usize = 3;
type Point = [Coord; AXES];

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
        self.between(least.log10(), most.log10()).exp2().powf(10f64.log2())
    }
    fn chance(&mut self, of: f64) -> bool {
        self.share() < of
    }
}

/// Every limit at every servo cycle and between: within a cycle the jerk is constant, so what velocity and acceleration say at
/// its ends says all.
struct Watch<S, const N: usize> {
    config: Config<S, N>,
    before: Option<Setpoint<S, N>>,
    room: [(Coord, Coord); N],
    /// Greatest share of velocity, acceleration and jerk so far, and how far positions are from their derivatives, mm.
    most: [f64; 4],
}

impl<S: Scalar, const N: usize> Watch<S, N> {
    fn new(config: Config<S, N>) -> Self {
        let open = AxisTravel::default();
        let room = config.travel.axes().map(|axis| {
            assert!(axis != open || axis.least.is_none());
            (axis.least.unwrap_or(at(-1.0e6)), axis.greatest.unwrap_or(at(1.0e6)))
        });
        Self { config, before: None, room, most: [0.0; 4] }
    }

    /// Relative rounding of setpoints.
    fn rounding() -> f64 {
        if S::NAME == "f32" { 2.0e-4 } else { 1.0e-7 }
    }

    fn see(&mut self, now: Setpoint<S, N>) {
        let h = self.config.cycle.to_f64();
        if let Some(before) = self.before.replace(now) {
            let (limits, e) = (&self.config.limits, Self::rounding());
            let seen = motor_shares((limits, &[]), [&before, &now], (h, e));
            assert!(seen.iter().all(|seen| *seen < 1.0 + e), "a motor at {seen:?} of its limits");
            for (i, axis) in self.config.limits.axes().iter().enumerate() {
                let [v0, v1] = [before.velocity[i], now.velocity[i]].map(S::to_f64);
                let [a0, a1] = [before.acceleration[i], now.acceleration[i]].map(S::to_f64);
                let (most_v, most_a) = (axis.velocity.to_f64(), axis.acceleration.to_f64());
                let most_j = axis.jerk.to_f64();
                let jerk = (a1 - a0) / h;
                let turned = if a0 * a1 < 0.0 { v0 - 0.5 * a0 * a0 / jerk } else { v1 };
                let steps = (v1 - v0 - 0.5 * (a0 + a1) * h).abs() / most_v;
                let moved: f64 = now.position(i).minus(before.position(i));
                let moved = (moved - (v0 + (2.0 * a0 + a1) * h / 6.0) * h).abs();
                let seen = [
                    v1.abs().max(turned.abs()) / most_v,
                    a1.abs() / most_a,
                    jerk.abs() / (most_j + 2.0 * Self::rounding() * most_a / h),
                    moved,
                ];
                for (most, seen) in self.most.iter_mut().zip(seen) {
                    *most = most.max(seen);
                }
                assert!(
                    steps < 10.0 * Self::rounding(),
                    "axis {i}: velocity steps by {steps} of its limit"
                );
                for (seen, of) in seen.iter().zip(["velocity", "acceleration", "jerk"]) {
                    assert!(*seen < 1.0 + Self::rounding(), "axis {i}: {of} {seen} of its limit");
                }
                let (least, greatest) = self.room[i];
                let slack = 1.0e-6;
                let at = now.position(i);
                assert!(
                    least.plus(-slack) <= at && at <= greatest.plus(slack),
                    "axis {i} at {} leaves {} to {}",
                    at.to_mm(),
                    least.to_mm(),
                    greatest.to_mm()
                );
                if now.activity == Activity::Idle {
                    assert!(at >= least && at <= greatest, "axis {i} rests beyond a limit");
                }
            }
        }
    }
}

fn machine<S: Scalar>(draw: &mut Draw) -> Config<S, AXES> {
    let axis = [(); AXES].map(|()| {
        let v = draw.scale(1.0, 1.0e3);
        let a = v * draw.scale(1.0, 100.0);
        AxisLimits::linear(S::of(v), S::of(a), S::of(a * draw.scale(2.0, 1000.0)))
    });
    let mut config = Config::new(with_motors(Limits::new(axis).unwrap(), || draw.share()));
    config.cycle = S::of(if draw.chance(0.5) { 1.0e-3 } else { 2.5e-4 });
    config.start_delay = S::ZERO;
    config
}

fn any_jog<S: Scalar>(draw: &mut Draw, config: &Config<S, AXES>, room: f64) -> Jog<S, AXES> {
    let axes = config.limits.axes();
    let feed = S::of(draw.scale(0.01, 2.0) * axes[0].velocity.to_f64());
    let [x, y, z] = [(); AXES].map(|()| draw.between(-1.0, 1.0) * room);
    match (draw.share() * 8.0) as u32 {
        0..=3 => {
            let velocity = std::array::from_fn(|i| {
                let share = match (draw.share() * 6.0) as u32 {
                    0 => 0.0,
                    1 => 1.0,
                    2 => -1.0,
                    _ => draw.between(-1.2, 1.2),
                };
                let velocity = share * axes[i].velocity.to_f64();
                // Less than the least that is accepted is refused.
                S::of(if velocity.abs() < 1.1e-6 { 0.0 } else { velocity })
            });
            Jog::Velocity { velocity, time: S::of(draw.scale(1.0e-3, 2.0)) }
        }
        4 => Jog::Step { by: [at(x * 0.1), at(y * 0.01), Coord::ZERO], feed },
        5 => Jog::Step { by: [at(0.01), at(-0.01), at(z)], feed },
        _ => Jog::To { to: [at(x), at(y), at(z)], feed },
    }
}

/// Random jogs and cancels in one machine, as often as every cycle; then to a point, which is reached to the last unit.
fn random_jogs<S: Scalar>(seed: u64, cycles: usize) {
    let mut draw = Draw(seed | 1);
    let mut config = machine::<S>(&mut draw);
    let reach = draw.scale(0.1, 300.0);
    if draw.chance(0.7) {
        let end = || AxisTravel { least: Some(at(-reach)), greatest: Some(at(reach)) };
        config.travel = Travel::new([(); AXES].map(|()| end())).unwrap();
    }
    let often = draw.scale(0.002, 1.0);
    let mut link: Link<S, AXES> = Link::new();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let mut watch = Watch::new(config);
    for _ in 0..cycles {
        if draw.chance(often) {
            let jog = any_jog(&mut draw, &config, reach);
            let taken = planner.jog(&jog);
            // A way that takes hours is refused.
            let slow = matches!(taken, Err(JogError::OutOfRange { quantity: Quantity::Feed, .. }));
            assert!(taken.is_ok() || slow, "{taken:?}");
        }
        if draw.chance(often * 0.1) {
            planner.controls().cancel_jog();
        }
        if draw.chance(0.9) {
            planner.settle();
        }
        watch.see(interpolator.tick());
    }
    let to: Point = [(); AXES].map(|()| at(draw.between(-reach, reach)));
    planner.jog(&Jog::To { to, feed: S::of(1.0e6) }).unwrap();
    let setpoint = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
    for (i, to) in to.iter().enumerate() {
        assert_eq!(setpoint.position(i), *to, "axis {i}");
    }
    assert_eq!(*planner.end(), to);
}

/// Ticks until the jog is over.
fn rest<S: Scalar, const N: usize>(
    planner: &mut Planner<'_, S, N>,
    interpolator: &mut Interpolator<'_, S, N>,
    mut see: impl FnMut(Setpoint<S, N>),
) -> Setpoint<S, N> {
    for _ in 0..4_000_000 {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        see(setpoint);
        if setpoint.activity == Activity::Idle
            && progress != Progress::Waiting
            && progress != Progress::Planned
        {
            return setpoint;
        }
    }
    panic!("the jog does not end");
}

proptest! {
    #![proptest_config(cases::config(60))]

    #[test]
    fn random_jogs_keep_every_limit(seed in any::<u64>()) {
        random_jogs::<f64>(seed, 4000);
    }

    #[test]
    fn random_jogs_keep_every_limit_in_f32(seed in any::<u64>()) {
        random_jogs::<f32>(seed, 4000);
    }
}

fn usual<S: Scalar>() -> Config<S, AXES> {
    let axis = AxisLimits::linear(S::of(100.0), S::of(1000.0), S::of(2.0e4));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.start_delay = S::ZERO;
    config
}

#[test]
fn a_velocity_is_kept_until_its_time_is_over() {
    let config = usual::<f64>();
    let mut link: Link<f64, AXES> = Link::new();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let mut watch = Watch::new(config);
    let jog = Jog::Velocity { velocity: [50.0, 0.0, -20.0], time: 0.5 };
    planner.jog(&jog).unwrap();
    let mut seen = Vec::new();
    rest(&mut planner, &mut interpolator, |setpoint| {
        watch.see(setpoint);
        seen.push(setpoint);
    });
    // It moves in the very next servo cycle.
    assert!(seen[0].velocity[0] > 0.0 && seen[0].activity == Activity::Jogging);
    // From 0 to 50 mm/s by 20,000 mm/s3 and 1,000 mm/s2: 100 ms, and a twentieth more; it brakes at 500 ms.
    for (k, setpoint) in seen.iter().enumerate() {
        if (106..500).contains(&(k + 1)) {
            assert!((setpoint.velocity[0] - 50.0).abs() < 1.0e-9, "{k}");
            assert!((setpoint.velocity[2] + 20.0).abs() < 1.0e-9, "{k}");
        }
    }
    assert!(seen[500].acceleration[0] < 0.0 && seen.len() < 610, "{}", seen.len());
    // Asked for again in time, it goes on without a change of speed.
    for k in 0..3000 {
        if k % 100 == 0 {
            planner.jog(&jog).unwrap();
        }
        planner.settle();
        let setpoint = interpolator.tick();
        watch.see(setpoint);
        assert!(k < 106 || (setpoint.velocity[0] - 50.0).abs() < 1.0e-9);
    }
    rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
    assert!(watch.most[..3].iter().all(|most| *most > 0.4), "{:?}", watch.most);
}

#[test]
fn it_stands_exactly_at_the_limit_of_travel() {
    for (velocity, end) in [(100.0, 37.123_456_789), (-3.0, -0.25), (0.02, 0.001)] {
        let mut config = usual::<f32>();
        let room = AxisTravel {
            least: Some(at(-0.25)),
            greatest: Some(at(if end > 0.0 { end } else { 1.0 })),
        };
        config.travel = Travel::new([room, AxisTravel::default(), AxisTravel::default()]).unwrap();
        let mut link: Link<f32, AXES> = Link::new();
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        let mut watch = Watch::new(config);
        let jog = Jog::Velocity { velocity: [velocity, 10.0, 0.0], time: 0.3 };
        for k in 0..2000 {
            if k % 150 == 0 {
                planner.jog(&jog).unwrap();
            }
            planner.settle();
            watch.see(interpolator.tick());
        }
        let setpoint = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
        assert_eq!(setpoint.position(0), at(end), "{velocity}");
        // The other axis runs free.
        assert!(setpoint.position_mm(1) > 19.0);
        // Further out there is nothing, and back it goes.
        planner.jog(&jog).unwrap();
        let setpoint = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
        assert_eq!(setpoint.position(0), at(end));
        planner.jog(&Jog::Velocity { velocity: [-velocity, 0.0, 0.0], time: 0.01 }).unwrap();
        let setpoint = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
        assert!((setpoint.position(0) < at(end)) == (velocity > 0.0));
    }
}

#[test]
fn a_point_is_reached_along_the_straight_line_and_a_cancel_stays_on_it() {
    let config = usual::<f64>();
    let to = [at(30.0), at(-10.0), at(4.0)];
    for cancel in [None, Some(60), Some(300)] {
        let mut link: Link<f64, AXES> = Link::new();
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        let mut watch = Watch::new(config);
        planner.jog(&Jog::To { to, feed: 80.0 }).unwrap();
        let mut cycle = 0;
        let controls = planner.controls();
        let setpoint = rest(&mut planner, &mut interpolator, |setpoint| {
            watch.see(setpoint);
            let x = setpoint.position_mm(0);
            assert!((setpoint.position_mm(1) + x / 3.0).abs() < 1.0e-9);
            assert!((setpoint.position_mm(2) - x / 7.5).abs() < 1.0e-9);
            cycle += 1;
            if Some(cycle) == cancel {
                controls.cancel_jog();
            }
        });
        let arrived = (0..AXES).all(|i| setpoint.position(i) == to[i]);
        assert_eq!(arrived, cancel.is_none());
    }
}

/// Pressed at whatever cycle, a cancel does not lead beyond the point that was asked for: at the limit of travel it would be out of that.
#[test]
fn a_cancel_before_the_point_does_not_lead_beyond_it() {
    for (cycle, feed) in [(1.0e-3, 60.0), (1.0e-3, 10.0), (4.0e-3, 60.0)] {
        let mut config = usual::<f64>();
        config.cycle = cycle;
        let to = [at(7.0), at(3.0), at(0.0)];
        let edge = AxisTravel { least: None, greatest: Some(at(7.0)) };
        config.travel = Travel::new([edge; AXES]).unwrap();
        for when in 0.. {
            let mut link = Box::new(Link::<f64, AXES>::new());
            let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
            planner.jog(&Jog::To { to, feed }).unwrap();
            let mut over = false;
            for n in 0.. {
                if n == when {
                    planner.controls().cancel_jog();
                }
                planner.settle();
                let setpoint = interpolator.tick();
                assert!(
                    setpoint.position(0) <= to[0],
                    "{cycle} s, {feed} mm/s: cancelled at {when}"
                );
                if setpoint.activity == Activity::Idle && n > 5 {
                    over = n < when;
                    break;
                }
            }
            assert!(planner.end()[0] <= to[0]);
            if over {
                break;
            }
        }
    }
}

/// A machine that has come to rest in a jog at no velocity goes on along the straight line, too.
#[test]
fn a_point_after_a_velocity_of_zero_is_reached_along_the_straight_line() {
    let slow = AxisLimits::linear(200.0, 500.0, 10_000.0);
    let axes = [AxisLimits::linear(200.0, 2000.0, 50_000.0), slow, slow];
    let config = Config::new(Limits::new(axes).unwrap());
    let mut link = Box::new(Link::<f64, AXES>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let mut run = |planner: &mut Planner<'_, f64, AXES>, cycles: usize| {
        for _ in 0..cycles {
            planner.settle();
            interpolator.tick();
        }
        interpolator.tick()
    };
    planner.jog(&Jog::Velocity { velocity: [50.0, 0.0, 0.0], time: 1.5 }).unwrap();
    run(&mut planner, 60);
    planner.jog(&Jog::Velocity { velocity: [0.0; AXES], time: 5.0 }).unwrap();
    let from = run(&mut planner, 500);
    let to = [0, 1, 2].map(|axis| from.position(axis).plus(-30.0));
    planner.jog(&Jog::To { to, feed: 100.0 }).unwrap();
    for _ in 0..2000 {
        let now = run(&mut planner, 1);
        let way = [0, 1, 2].map(|axis| now.position(axis).minus::<f64>(from.position(axis)));
        assert!((way[0] - way[1]).abs() < 1.0e-9 && (way[0] - way[2]).abs() < 1.0e-9, "{way:?}");
        if now.activity == Activity::Idle {
            break;
        }
    }
    assert_eq!(planner.jog_end(), to);
}

#[test]
fn steps_add_up_to_the_unit() {
    let config = usual::<f32>();
    let mut link: Link<f32, AXES> = Link::new();
    let (mut planner, mut interpolator) = link.split(config, [at(999.0); AXES]).unwrap();
    let mut watch = Watch::new(config);
    let by = [at(0.1), Coord::ZERO, at(-0.01)];
    for k in 0..200 {
        // The next before the last has ended, as a rule.
        planner.jog(&Jog::Step { by, feed: 50.0 }).unwrap();
        for _ in 0..k % 40 {
            planner.settle();
            watch.see(interpolator.tick());
        }
    }
    let setpoint = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
    assert_eq!([0, 1, 2].map(|i| setpoint.position(i)), [at(1019.0), at(999.0), at(997.0)]);
}

/// A program of two lines and an arc, pushed whole.
fn program<S: Scalar>(planner: &mut Planner<'_, S, AXES>) {
    for (tag, (x, y)) in [(40.0, 0.0), (40.0, 40.0), (0.0, 40.0)].into_iter().enumerate() {
        let line = Block::line([at(x), at(y), Coord::ZERO], S::of(60.0), tag as u32 + 1);
        planner.push(&line).unwrap();
    }
    planner.finish();
}

/// Held in a program, jogged away and back, resumed: the setpoints on the path are those without the jog.
#[test]
fn from_a_hold_and_back_to_the_path() {
    for (held, away) in [(300, true), (300, false), (777, true), (1000, true), (1400, true)] {
        let config = usual::<f64>();
        let mut link: Link<f64, AXES> = Link::new();
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        let mut watch = Watch::new(config);
        program(&mut planner);
        let mut path = Vec::new();
        for _ in 0..held {
            planner.settle();
            path.push(interpolator.tick());
        }
        let jog = Jog::Velocity { velocity: [10.0, -70.0, 20.0], time: 0.2 };
        assert_eq!(planner.jog(&jog), Err(JogError::Running));
        planner.controls().hold();
        assert_eq!(planner.jog(&jog), Err(JogError::Running));
        while planner.settle() != Progress::Held {
            path.push(interpolator.tick());
        }
        let home = path[path.len() - 1];
        if away {
            planner.jog(&jog).unwrap();
            let there = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
            assert!(there.position_mm(2) > 1.0);
            // A resume away from the path moves nothing; nor is it remembered.
            planner.controls().resume();
            for _ in 0..50 {
                assert_eq!(planner.settle(), Progress::Held);
                assert_eq!(interpolator.tick().activity, Activity::Idle);
            }
            planner.controls().hold();
            assert_eq!(planner.settle(), Progress::Held);
            planner.jog(&Jog::Back { feed: 30.0 }).unwrap();
            let back = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
            for i in 0..AXES {
                assert_eq!(back.position(i), home.position(i), "axis {i}");
            }
            let along = back.path_mm() - home.path_mm();
            assert!(along.abs() < 1.0e-6, "{along} {home:?} {back:?}");
        }
        assert_eq!(planner.settle(), Progress::Held);
        planner.controls().resume();
        loop {
            let progress = planner.settle();
            let setpoint = interpolator.tick();
            assert_ne!(setpoint.activity, Activity::Jogging);
            path.push(setpoint);
            if progress == Progress::Done && setpoint.activity == Activity::Idle {
                break;
            }
        }
        assert_eq!(path[path.len() - 1].position(1), at(40.0));
        // Inside the band of the square all the way.
        for setpoint in &path {
            let (x, y) = (setpoint.position_mm(0), setpoint.position_mm(1));
            let off = f64::min(y.abs().min((y - 40.0).abs()), (x - 40.0).abs());
            assert!(off < 0.0101, "{x} {y}");
            assert_eq!(setpoint.position(2), Coord::ZERO);
        }
        // A jog once more, from rest with nothing to run; there is nothing to go back to.
        assert_eq!(planner.jog(&Jog::Back { feed: 1.0 }), Err(JogError::NoProgram));
        planner.jog(&jog).unwrap();
        assert_eq!(planner.push(&Block::dwell(0.1, 1)), Err(PushError::Full));
        rest(&mut planner, &mut interpolator, |_| ());
        assert!(planner.end()[2] > at(1.0));
        assert_eq!(planner.push(&Block::line([at(0.0); AXES], 20.0, 7)), Ok(()));
        planner.finish();
        for _ in 0..10_000 {
            let progress = planner.settle();
            let rests = interpolator.tick().activity == Activity::Idle;
            if progress == Progress::Done && rests {
                break;
            }
        }
        assert_eq!(interpolator.tick().position(2), Coord::ZERO);
    }
}

#[test]
fn a_hold_and_an_abort_end_a_jog() {
    for abort in [false, true] {
        for from_hold in [false, true] {
            let config = usual::<f64>();
            let mut link: Link<f64, AXES> = Link::new();
            let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
            if from_hold {
                program(&mut planner);
                for _ in 0..500 {
                    planner.settle();
                    interpolator.tick();
                }
                planner.controls().hold();
                while planner.settle() != Progress::Held {
                    interpolator.tick();
                }
            }
            let mut watch = Watch::new(config);
            planner.jog(&Jog::Velocity { velocity: [100.0, 50.0, 0.0], time: 10.0 }).unwrap();
            for _ in 0..300 {
                planner.settle();
                watch.see(interpolator.tick());
            }
            let before = interpolator.tick();
            if abort {
                planner.controls().abort();
            } else {
                planner.controls().hold();
            }
            let mut cycles = 0;
            let setpoint = rest(&mut planner, &mut interpolator, |setpoint| {
                assert!(setpoint.acceleration[0] < 0.0 || setpoint.velocity[0].abs() < 1.0e-9);
                watch.see(setpoint);
                cycles += 1;
            });
            // 100 mm/s by 1,000 mm/s2 and 20,000 mm/s3: 150 ms, and a twentieth of the 100 ms in which jerk acts.
            assert!((150..=158).contains(&cycles), "{cycles}");
            assert!(setpoint.position_mm(0) > before.position_mm(0));
            if abort {
                assert_eq!(planner.settle(), Progress::Aborted);
                assert_eq!(planner.jog(&Jog::Back { feed: 1.0 }), Err(JogError::Aborted));
                assert!(planner.acknowledge_abort());
                assert!((0..AXES).all(|i| planner.end()[i] == setpoint.position(i)));
            } else {
                assert_eq!(planner.settle(), Progress::Held);
                // From there on again, though the hold is in force.
                planner.jog(&Jog::Velocity { velocity: [0.0, -50.0, 0.0], time: 0.1 }).unwrap();
                let there = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
                assert!(there.position_mm(1) < setpoint.position_mm(1));
            }
        }
    }
}

#[test]
fn what_is_no_jog_is_refused_and_changes_nothing() {
    let mut config = usual::<f64>();
    let room = AxisTravel { least: Some(at(-5.0)), greatest: Some(at(5.0)) };
    config.travel = Travel::new([room; AXES]).unwrap();
    let mut link: Link<f64, AXES> = Link::new();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let zero = Coord::ZERO;
    for jog in [
        Jog::Velocity { velocity: [f64::NAN, 0.0, 0.0], time: 1.0 },
        Jog::Velocity { velocity: [2.0e6, 0.0, 0.0], time: 1.0 },
        Jog::Velocity { velocity: [1.0, 0.0, 0.0], time: 0.0 },
        Jog::To { to: [zero; AXES], feed: 0.0 },
        Jog::To { to: [at(4.0), zero, zero], feed: 1.0e-8 },
    ] {
        let refused = planner.jog(&jog);
        assert!(matches!(refused, Err(JogError::OutOfRange { .. })), "{jog:?} {refused:?}");
    }
    let out = planner.jog(&Jog::To { to: [zero, at(5.001), zero], feed: 1.0 });
    assert!(matches!(out, Err(JogError::Travel { axis: 1, .. })), "{out:?}");
    assert_eq!(planner.settle(), Progress::NeedsBlocks);
    assert_eq!(interpolator.tick().activity, Activity::Idle);
    planner.push(&Block::line([at(1.0); AXES], 1.0, 1)).unwrap();
    let refused = planner.jog(&Jog::To { to: [zero; AXES], feed: 1.0 });
    assert_eq!(refused, Err(JogError::Running));
}

/// Nine axes in motion each by itself need more pieces than a plan has room for: then they stop first.
#[test]
fn nine_axes_arrive() {
    let axis = AxisLimits::linear(100.0, 1000.0, 2.0e4);
    let config = Config::<f64, 9>::new(Limits::new([axis; 9]).unwrap());
    let mut link: Link<f64, 9> = Link::new();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 9]).unwrap();
    let mut watch = Watch::new(config);
    let mut draw = Draw(99);
    for _ in 0..400 {
        let velocity = std::array::from_fn(|_| draw.between(-100.0, 100.0));
        let to = std::array::from_fn(|_| at(draw.between(-100.0, 100.0)));
        let jog = if draw.chance(0.5) {
            Jog::To { to, feed: 70.0 }
        } else {
            Jog::Velocity { velocity, time: 0.3 }
        };
        planner.jog(&jog).unwrap();
        for _ in 0..(draw.share() * 200.0) as usize {
            planner.settle();
            watch.see(interpolator.tick());
        }
    }
    let to = std::array::from_fn(|_| at(draw.between(-100.0, 100.0)));
    planner.jog(&Jog::To { to, feed: 70.0 }).unwrap();
    let setpoint = rest(&mut planner, &mut interpolator, |setpoint| watch.see(setpoint));
    assert!((0..9).all(|i| setpoint.position(i) == to[i]));
}

/// Where one of nine axes could not be turned at once, all that was asked for was asked again, with all of its time, for ever: without a word from the operator
/// the others ran on.
#[test]
#[allow(clippy::unreadable_literal)] // As they were drawn.
fn a_velocity_ends_though_an_axis_cannot_be_turned() {
    let limits = [
        [38.98324966430664, 122.01905059814453, 3468.54736328125],
        [27.014965057373047, 445.9387512207031, 8493.5498046875],
        [77.20626068115234, 355.9462890625, 20023.615234375],
        [263.630126953125, 1808.761474609375, 176947.421875],
        [189.18051147460938, 1623.5655517578125, 16434.4765625],
        [72.8891372680664, 624.124267578125, 29236.1796875],
        [43.48078918457031, 425.0822448730469, 2761.8125],
        [36.51051712036133, 245.7560272216797, 21005.751953125],
        [585.4501953125, 16521.544921875, 1083337.0],
    ];
    let mut config = Config::<f64, 9>::new(
        Limits::new(limits.map(|[v, a, j]| AxisLimits::linear(v, a, j))).unwrap(),
    );
    config.cycle = f64::from(0.002f32);
    let axis_5 = |of: f64| std::array::from_fn(|axis| if axis == 5 { of } else { 0.0 });
    let jogs = [
        (0, Jog::Velocity { velocity: axis_5(-189.2434539794922), time: 0.08932215720415115 }),
        (1, Jog::Step { by: axis_5(-1.932827591896).map(at), feed: 16.03028678894043 }),
        (
            3,
            Jog::Velocity {
                velocity: [
                    229.33074951171875,
                    19.91200065612793,
                    108.10548400878906,
                    -77.25090026855469,
                    -179.64309692382813,
                    261.4397888183594,
                    115.2477035522461,
                    -244.6811981201172,
                    284.03424072265625,
                ],
                time: 0.22282694280147552,
            },
        ),
    ];
    let mut link = Box::new(Link::<f64, 9>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 9]).unwrap();
    for cycle in 0.. {
        assert!(cycle < 1000, "no rest");
        for (when, jog) in &jogs {
            if *when == cycle {
                planner.jog(jog).unwrap();
            }
        }
        planner.settle();
        let setpoint = interpolator.tick();
        if cycle > 3 && setpoint.activity == Activity::Idle {
            return;
        }
    }
}

#[test]
fn a_jog_after_a_cancel_counts() {
    let config = usual();
    let mut link: Link<f64, AXES> = Link::new();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let (velocity, time) = ([50.0, 0.0, 0.0], 1.0);
    planner.jog(&Jog::Velocity { velocity, time }).unwrap();
    for _ in 0..100 {
        planner.settle();
        interpolator.tick();
    }
    planner.controls().cancel_jog();
    let to: Point = [at(30.0), at(2.0), at(-1.0)];
    planner.jog(&Jog::To { to, feed: 50.0 }).unwrap();
    let setpoint = rest(&mut planner, &mut interpolator, |_| {});
    assert_eq!([0, 1, 2].map(|i| setpoint.position(i)), to);
}

/// What is asked for in every servo cycle, or every few, is reached all the same.
#[test]
fn a_place_that_is_asked_for_again_and_again_is_reached() {
    for every in [1, 2, 3, 7] {
        let config = usual();
        let mut link: Link<f64, AXES> = Link::new();
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        let to: Point = [at(10.0), at(-3.0), at(0.7)];
        let mut ended = false;
        for k in 0..2000 {
            if k % every == 0 {
                planner.jog(&Jog::To { to, feed: 50.0 }).unwrap();
            }
            planner.settle();
            let setpoint = interpolator.tick();
            ended = setpoint.activity == Activity::Idle;
            if ended {
                assert_eq!([0, 1, 2].map(|i| setpoint.position(i)), to);
                break;
            }
        }
        assert!(ended, "every {every} cycles: no end");
    }
}

/// A machine that stands outside its limits of travel leaves and comes back to where its program was held.
#[test]
fn back_leads_out_of_the_limits_of_travel_if_the_program_is_there() {
    for cycles in [0, 10, 60, 150, 400] {
        let mut config = usual::<f64>();
        let free = AxisTravel { least: None, greatest: None };
        let narrow = AxisTravel { least: Some(at(-2.0)), greatest: Some(at(2.0)) };
        config.travel = Travel::new([narrow, free, free]).unwrap();
        let start = [at(-4.0), at(0.0), at(0.0)];
        let mut link: Link<f64, AXES> = Link::new();
        let (mut planner, mut interpolator) = link.split(config, start).unwrap();
        planner.controls().hold();
        planner.push(&Block::line([at(1.0), at(1.0), at(0.0)], 50.0, 1)).unwrap();
        planner.finish();
        while planner.settle() != Progress::Held {
            interpolator.tick();
        }
        let to = [at(1.0), at(0.5), at(0.0)];
        planner.jog(&Jog::To { to, feed: 20.0 }).unwrap();
        for _ in 0..cycles {
            planner.settle();
            interpolator.tick();
        }
        planner.jog(&Jog::Back { feed: 20.0 }).unwrap();
        let setpoint = rest(&mut planner, &mut interpolator, |_| {});
        assert_eq!([0, 1, 2].map(|i| setpoint.position(i)), start, "{cycles}");
        planner.controls().resume();
        let setpoint = rest(&mut planner, &mut interpolator, |_| {});
        assert_eq!(setpoint.position(0), at(1.0));
    }
}

#[test]
fn what_is_sent_again_does_not_outrun_a_hold() {
    for held_before in [false, true] {
        let config = usual();
        let mut link: Link<f64, AXES> = Link::new();
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        if held_before {
            program(&mut planner);
            planner.controls().hold();
            while planner.settle() != Progress::Held {
                interpolator.tick();
            }
        }
        let jog = Jog::Velocity { velocity: [50.0, 0.0, 0.0], time: 1.0 };
        planner.jog(&jog).unwrap();
        for _ in 0..100 {
            planner.settle();
            interpolator.tick();
        }
        // The operator's hand, and in the same moment what his device sends every so often.
        planner.controls().hold();
        planner.jog(&jog).unwrap();
        let mut cycles = 0;
        rest(&mut planner, &mut interpolator, |_| cycles += 1);
        assert!(cycles < 150, "{held_before}: {cycles}");
        // Asked for after that, it is meant.
        planner.jog(&jog).unwrap();
        let mut cycles = 0;
        rest(&mut planner, &mut interpolator, |_| cycles += 1);
        assert!(cycles > 1000, "{held_before}: {cycles}");
    }
}
