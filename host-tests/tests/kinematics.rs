//! Motors that follow several axes: what they give is used to the full and never exceeded, on paths, in jogs and in homing, and their
//! setpoints are those of the axes. (Random machines with motors are in the tests of limits, jogs, probes and homing too.)

#[path = "common/motors.rs"]
mod motors;

use motors::motor_shares;
use splineway::machine::ConfigError;
use splineway::{
    Activity, AxisHome, AxisLimits, Block, Config, Coord, Input, Interpolator, Jog, Kinematics,
    Limits, Linear, Link, Motion, Planner, Progress, Scalar, Setpoint, Turn,
};

const AXES: usize = 3;
type Core<'a, S> = (Planner<'a, S, AXES>, Interpolator<'a, S, AXES>);

fn at(mm: f64) -> Coord {
    Coord::from_mm(mm).unwrap()
}

fn limits<S: Scalar>(velocity: f64, acceleration: f64, jerk: f64) -> AxisLimits<S> {
    AxisLimits::linear(S::of(velocity), S::of(acceleration), S::of(jerk))
}

/// What every belt may do.
fn motor<S: Scalar>() -> AxisLimits<S> {
    limits(200.0, 2000.0, 5.0e4)
}

/// Belts over X and Y, whose motors are what bounds them.
fn belts<S: Scalar>() -> Config<S, AXES> {
    let axes = Limits::new([limits(1000.0, 1.0e4, 2.5e5); AXES]).unwrap();
    let mut config = Config::new(axes.with_motors(&Linear::core_xy(), [motor(); 3]).unwrap());
    config.tolerance = S::of(0.05);
    config.start_delay = S::ZERO;
    config
}

/// The same machine by limits of the axes that the motors keep in every direction.
fn careful<S: Scalar>() -> Config<S, AXES> {
    let half = limits(100.0, 1000.0, 2.5e4);
    let mut config = Config::new(Limits::new([half, half, motor()]).unwrap());
    (config.tolerance, config.start_delay) = (S::of(0.05), S::ZERO);
    config
}

/// A machine under the test, cycle by cycle.
struct Bench<'a, S: Scalar> {
    planner: Planner<'a, S, AXES>,
    interpolator: Interpolator<'a, S, AXES>,
    config: Config<S, AXES>,
    last: Setpoint<S, AXES>,
    /// Greatest shares of velocity, acceleration and jerk of any motor.
    most: [f64; 3],
    cycles: u32,
}

impl<'a, S: Scalar> Bench<'a, S> {
    fn new(link: &'a mut Link<S, AXES>, config: Config<S, AXES>) -> Self {
        let (planner, mut interpolator): Core<'a, S> =
            link.split(config, [Coord::ZERO; AXES]).unwrap();
        let last = interpolator.tick();
        Self { planner, interpolator, config, last, most: [0.0; 3], cycles: 0 }
    }

    fn tick(&mut self) -> Setpoint<S, AXES> {
        self.planner.settle();
        let now = self.interpolator.tick();
        self.cycles += 1;
        let before = std::mem::replace(&mut self.last, now);
        let rounding = if S::NAME == "f32" { 1.0e-3 } else { 1.0e-6 };
        let cycle = (self.config.cycle.to_f64(), rounding);
        let seen = motor_shares((&self.config.limits, &[]), [&before, &now], cycle);
        for (most, seen) in self.most.iter_mut().zip(seen) {
            *most = most.max(seen);
        }
        assert!(seen.iter().all(|seen| *seen < 1.0 + rounding), "{seen:?} of a motor's limits");
        now
    }

    /// Until it rests.
    fn run(&mut self) -> u32 {
        let began = self.cycles;
        for _ in 0..200_000 {
            let now = self.tick();
            if now.activity == Activity::Idle && self.cycles > began + 20 {
                return self.cycles - began;
            }
        }
        panic!("it does not rest");
    }

    fn line(&mut self, x: f64, y: f64) {
        let mut block = Block::line([at(x), at(y), Coord::ZERO], S::of(1.0e3), 1);
        block.feed = splineway::Feed::Rapid;
        self.planner.push(&block).unwrap();
    }
}

fn rapid_to<S: Scalar>(config: Config<S, AXES>, x: f64, y: f64) -> (u32, [f64; 3]) {
    let mut link = Box::new(Link::new());
    let mut bench = Bench::new(&mut link, config);
    bench.line(x, y);
    bench.planner.finish();
    (bench.run(), bench.most)
}

/// Whether a motor has used all of its limits but a share. Of an `f32` rounding hides half of the jerk.
fn all_but([v, a, j]: &[f64; 3], share: f64) -> bool {
    v.min(*a) > 1.0 - share && *j > 0.5
}

/// On straight lines a motor gives all it has, in any direction.
fn straight_lines_use_all_of_the_motors<S: Scalar>() {
    // 200 mm of belt at 200 mm/s: a second, and what it takes to get going (0.14 s).
    for (x, y, seconds) in [(200.0, 0.0, 1.14), (0.0, -200.0, 1.14), (100.0, 100.0, 1.14)] {
        let (cycles, most) = rapid_to::<S>(belts(), x, y);
        assert!((f64::from(cycles) * 1.0e-3 - seconds).abs() < 0.02, "{x} {y}: {cycles}");
        assert!(all_but(&most, 0.02), "{x} {y}: {most:?}");
    }
    // One axis at a time goes twice as fast as if its limits were those of any direction.
    let (own, careful) = (rapid_to::<S>(belts(), 200.0, 0.0), rapid_to::<S>(careful(), 200.0, 0.0));
    assert!(f64::from(careful.0) > 1.8 * f64::from(own.0), "{careful:?} {own:?}");
    let (own, careful) =
        (rapid_to::<S>(belts(), 100.0, 100.0), rapid_to::<S>(self::careful(), 100.0, 100.0));
    assert!(own.0.abs_diff(careful.0) < 10, "{careful:?} {own:?}");
}

#[test]
fn straight_lines_use_all_of_the_motors_in_f64() {
    straight_lines_use_all_of_the_motors::<f64>();
}

#[test]
fn straight_lines_use_all_of_the_motors_in_f32() {
    straight_lines_use_all_of_the_motors::<f32>();
}

/// Corners, circles and a run of short lines.
fn push_parts<S: Scalar>(bench: &mut Bench<'_, S>, mut each: impl FnMut(&mut Bench<'_, S>)) {
    let mut blocks = Vec::new();
    for (x, y) in [(40.0, 0.0), (40.0, 30.0), (10.0, 30.0), (0.0, 0.0)] {
        blocks.push(Block::line([at(x), at(y), Coord::ZERO], S::of(150.0), 1));
    }
    let mut round = Block::line([Coord::ZERO; AXES], S::of(150.0), 2);
    round.motion = Motion::Arc {
        to: [Coord::ZERO; AXES],
        plane: (0, 1),
        centre: (at(15.0), at(0.0)),
        turn: Turn::CounterClockwise,
        extra_turns: 1,
    };
    blocks.push(round);
    for k in 1..=120 {
        let angle = f64::from(k) * std::f64::consts::TAU / 120.0;
        let [x, y] = [20.0 - 20.0 * angle.cos(), 12.0 * (2.0 * angle).sin()];
        blocks.push(Block::line([at(x), at(y), Coord::ZERO], S::of(150.0), 3));
    }
    let mut blocks = blocks.iter().peekable();
    loop {
        while blocks.next_if(|block| bench.planner.push(block).is_ok()).is_some() {}
        let is_all = blocks.peek().is_none();
        if is_all {
            bench.planner.finish();
        }
        each(bench);
        let done = bench.planner.settle() == Progress::Done;
        if is_all && done && bench.last.activity == Activity::Idle {
            return;
        }
        assert!(bench.cycles < 100_000);
    }
}

/// The setpoints of motors are what the axes make of them, to the unit of a coordinate, and end where the program does; a program
/// takes less time than by limits of the axes that hold in any direction.
fn motors_follow_a_program<S: Scalar>() {
    let belt = Linear::<S, AXES, 3>::core_xy();
    let skewed = Linear::<S, AXES, 4>::new([
        [S::ONE, S::of(-0.0123), S::ZERO],
        [S::ZERO, S::ONE, S::ZERO],
        [S::ZERO, S::ZERO, S::of(72.0)],
        [S::ZERO, S::ZERO, S::of(72.0)],
    ])
    .unwrap();
    let mut link = Box::new(Link::new());
    let mut bench = Bench::new(&mut link, belts::<S>());
    push_parts(&mut bench, |bench| {
        let now = bench.tick();
        let axes: [i64; AXES] = std::array::from_fn(|i| now.position(i).raw());
        let motors = belt.setpoint(&now);
        let [a, b] = [0, 1].map(|i| motors.position(i).raw());
        let off = (a - axes[0] - axes[1]).abs().max((b - axes[0] + axes[1]).abs());
        // Offsets are rounded to a part of what they are.
        let offsets = now.offset[0].to_f64().abs() + now.offset[1].to_f64().abs();
        let fine = offsets * 1.0e12 * S::EPSILON.to_f64();
        assert!(off as f64 <= 2.0 * fine + 2.0, "{off} units beside the axes");
        let sums = [now.velocity[0] + now.velocity[1], now.velocity[0] - now.velocity[1]];
        assert!((0..2).all(|i| motors.velocity[i] == sums[i]));
        let odd = skewed.setpoint(&now);
        let x = now.position_mm(0) - 0.0123 * now.position_mm(1);
        assert!((odd.position_mm(0) - x).abs() < 2.0e-6, "{} {x}", odd.position_mm(0));
        assert_eq!(odd.position(2), odd.position(3));
    });
    let end = belt.setpoint(&bench.last);
    assert_eq!([0, 1, 2].map(|i| end.position_nm(i)), [0, 0, 0]);
    assert_eq!(belt.positions(&[at(3.0), at(1.0), at(7.0)]), [at(4.0), at(2.0), at(7.0)]);
    let mut other = Box::new(Link::new());
    let mut careful = Bench::new(&mut other, careful::<S>());
    push_parts(&mut careful, |bench| {
        bench.tick();
    });
    let gained = f64::from(careful.cycles) / f64::from(bench.cycles);
    assert!(gained > 1.1, "{} and {} cycles", bench.cycles, careful.cycles);
    assert!(all_but(&bench.most, 0.05), "{:?}", bench.most);
}

#[test]
fn motors_follow_a_program_in_f64() {
    motors_follow_a_program::<f64>();
}

#[test]
fn motors_follow_a_program_in_f32() {
    motors_follow_a_program::<f32>();
}

/// A machine whose axes hold its motors moves to the bit as one without.
#[test]
fn motors_that_do_not_bind_change_nothing() {
    let plain = careful::<f32>();
    let mut driven = plain;
    driven.limits = plain.limits.with_motors(&Linear::core_xy(), [motor(); 3]).unwrap();
    let [mut one, mut two] = [(), ()].map(|()| Box::new(Link::new()));
    let mut seen = Vec::new();
    push_parts(&mut Bench::new(&mut one, plain), |bench| seen.push(bench.tick()));
    let mut seen = seen.into_iter();
    push_parts(&mut Bench::new(&mut two, driven), |bench| {
        assert_eq!(seen.next(), Some(bench.tick()));
    });
    assert_eq!(seen.len(), 0);
}

/// A gantry's second motor counts as much as the first, and a slower one slows its axis.
#[test]
fn the_slower_motor_of_a_gantry_sets_the_pace() {
    let axes = Limits::new([motor::<f64>(); AXES]).unwrap();
    let gantry = Linear::<f64, AXES, 4>::gantry(0).unwrap();
    let slow = limits(80.0, 2000.0, 5.0e4);
    let mut config =
        Config::new(axes.with_motors(&gantry, [motor(), motor(), motor(), slow]).unwrap());
    config.start_delay = 0.0;
    let (cycles, most) = rapid_to(config, 200.0, 0.0);
    assert!((2540..2600).contains(&cycles) && most[0] > 0.999, "{cycles} {most:?}");
    assert!(rapid_to(config, 0.0, 200.0).0 < 1200);
}

/// X alone has all that the belts give; when Y is asked for too, X makes room, and both keep to what they were asked for as far as
/// the belts allow. A cancel ends both.
fn jogs_share_what_the_motors_give<S: Scalar>() {
    let mut link = Box::new(Link::new());
    let mut bench = Bench::new(&mut link, belts::<S>());
    let jog = |bench: &mut Bench<'_, S>, x: f64, y: f64| {
        let velocity = [S::of(x), S::of(y), S::of(150.0)];
        bench.planner.jog(&Jog::Velocity { velocity, time: S::of(3.0) }).unwrap();
    };
    let wait = |bench: &mut Bench<'_, S>, cycles: u32| {
        for _ in 0..cycles {
            bench.tick();
        }
        bench.last.velocity.map(S::to_f64)
    };
    jog(&mut bench, 300.0, 0.0);
    let [x, y, z] = wait(&mut bench, 160);
    assert!((x - 200.0).abs() < 0.1 && y == 0.0 && (z - 150.0).abs() < 0.1, "{x} {y} {z}");
    assert!(all_but(&bench.most, 0.07), "{:?}", bench.most);
    // Both want all: each gets a half. Z has a motor of its own.
    jog(&mut bench, 300.0, 300.0);
    let [x, y, z] = wait(&mut bench, 400);
    assert!((x - 100.0).abs() < 0.1 && (y - 100.0).abs() < 0.1, "{x} {y}");
    assert!((z - 150.0).abs() < 0.1);
    // A little of one leaves the more to the other.
    jog(&mut bench, 170.0, -30.0);
    let [x, y, _] = wait(&mut bench, 500);
    assert!((x - 170.0).abs() < 0.1 && (y + 30.0).abs() < 0.1, "{x} {y}");
    jog(&mut bench, -30.0, 170.0);
    let [x, y, _] = wait(&mut bench, 600);
    assert!((x + 30.0).abs() < 0.1 && (y - 170.0).abs() < 0.1, "{x} {y}");
    bench.planner.controls().cancel_jog();
    let stopped = bench.run();
    assert!(stopped < 400, "{stopped}");
    // A point from rest: straight, with all that the belts have in that direction.
    let to = [at(500.0), at(500.0), Coord::ZERO];
    let from: [f64; 3] = std::array::from_fn(|i| bench.last.position_mm(i));
    bench.planner.jog(&Jog::To { to, feed: S::of(1.0e3) }).unwrap();
    bench.most = [0.0; 3];
    let cycles = bench.run();
    let way = (1000.0 - from[0] - from[1]).abs().max((from[0] - from[1]).abs()).max(from[2].abs());
    let least = way / 200.0 * 1.0e3;
    assert!(f64::from(cycles) < least + 180.0, "{cycles} {least}");
    assert_eq!(std::array::from_fn(|i| bench.last.position(i)), to);
}

#[test]
fn jogs_share_what_the_motors_give_in_f64() {
    jogs_share_what_the_motors_give::<f64>();
}

#[test]
fn jogs_share_what_the_motors_give_in_f32() {
    jogs_share_what_the_motors_give::<f32>();
}

/// Both axes of the belts at once, each with its switch: found, and no motor beyond its limits of stops.
#[test]
fn axes_on_common_belts_are_homed_at_once() {
    let mut link = Box::new(Link::<f64, AXES>::new());
    let mut bench = Bench::new(&mut link, belts());
    let home = |fast: f64| AxisHome {
        fast,
        slow: 5.0,
        reach: at(300.0),
        back: at(2.0),
        at: at(0.0),
        park: None,
        order: 0,
    };
    for axis in 0..AXES {
        bench.planner.inputs().tell(Input::Home(axis), false, 0.0);
    }
    bench.planner.home(&[Some(home(-150.0)), Some(home(120.0)), None]).unwrap();
    let mut result = None;
    for _ in 0..20_000 {
        bench.planner.settle();
        let now = bench.interpolator.tick();
        if now.activity != Activity::Set {
            let said = (&bench.config.limits, [&bench.last, &now], (1.0e-3, 1.0e-6));
            let seen = motor_shares((said.0, &[]), said.1, said.2);
            assert!(seen.iter().all(|seen| *seen < 1.0 + 1.0e-6), "{seen:?}");
        }
        bench.last = now;
        let inputs = bench.planner.inputs();
        let closed = [now.position_mm(0) <= -60.0, now.position_mm(1) >= 45.0];
        for (axis, closed) in closed.into_iter().enumerate() {
            if inputs.is_closed(Input::Home(axis)) != closed {
                inputs.tell(Input::Home(axis), closed, 1.0);
            }
        }
        result = result.or_else(|| bench.planner.homed());
        if result.is_some() {
            break;
        }
    }
    assert_eq!(result, Some(Ok(())));
}

/// New limits without motors leave these in force: nobody has to think of them.
#[test]
fn limits_that_name_no_motors_keep_them() {
    let mut link = Box::new(Link::<f64, AXES>::new());
    let mut bench = Bench::new(&mut link, belts());
    let open = Limits::new([limits(2000.0, 1.0e5, 1.0e7); AXES]).unwrap();
    bench.planner.set_limits(open).unwrap();
    assert_eq!(bench.planner.limits().motor(1).map(|motor| motor.limits), Some(motor()));
    assert!(bench.planner.set_limits_at_rest(open));
    assert_eq!(bench.planner.limits().motor(0).map(|motor| motor.limits), Some(motor()));
    bench.line(200.0, 0.0);
    bench.planner.finish();
    bench.run();
    // Lower ones of motors count from their block on, and their factors stay whatever is said.
    let slow = limits(50.0, 500.0, 1.0e4);
    let odd = Linear::<f64, AXES, 3>::direct();
    bench.planner.set_limits(open.with_motors(&odd, [slow; 3]).unwrap()).unwrap();
    assert_eq!(bench.planner.limits().motor(1).map(|it| it.factors), Some([1.0, -1.0, 0.0]));
    bench.config.limits = *bench.planner.limits();
    bench.line(100.0, 50.0);
    bench.planner.finish();
    bench.most = [0.0; 3];
    bench.run();
    assert!(all_but(&bench.most, 0.02), "{:?}", bench.most);
}

#[test]
fn what_is_wrong_is_said_in_words() {
    let error = Linear::<f64, 2, 2>::new([[1.0, 1.0], [2.0, 2.0]]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "axis 1 could move with others without a motor: 0 of it is its own, and it must be 0.001"
    );
    let axes = Limits::new([motor::<f64>(); 2]).unwrap();
    let bad = AxisLimits { acceleration: -5.0, ..motor() };
    let error = axes.with_motors(&Linear::core_xy(), [motor(), bad]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "acceleration limit of motor 1 is -5 mm/s2; it must be 0.0001 to 100000000"
    );
    let error = Linear::<f64, 2, 2>::skew(0, 1, 5.0e3).unwrap_err();
    assert!(matches!(error, ConfigError::MotorFactor { motor: 0, axis: 1, .. }), "{error}");
    assert_eq!(
        error.to_string(),
        "factor of motor 0 for axis 1 is -5000; it must be -1000 to 1000"
    );
}
