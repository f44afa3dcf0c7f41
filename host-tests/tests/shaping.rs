//! Input shaping: random programs on random machines with random shapers, commands at random times; every limit and the
//! band of what the machine is given, and a vibration that is gone.

#[path = "common/cycles.rs"]
mod cycles;

use cycles::{AXES, Between, Draw, Point, at, machine, soak};
use std::collections::VecDeque;

use splineway::output::{Shape, Shaper, ShaperKind};
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Feed, Interpolator, Jog, Limits, Link,
    Motion, Planner, Progress, PushError, Scalar, Setpoint, Turn,
};

use splineway_simulator::judge::{judged, violations};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Course, Move, Program, Speed};
use splineway_simulator::run::{Events, Precision};

const HISTORY: usize = 1024;
type Core<'a, S> = (Planner<'a, S, AXES, 16, 64>, Interpolator<'a, S, AXES>);

fn shapes(draw: &mut Draw, cycle: f64, alike: bool) -> [Option<Shape>; AXES] {
    let mut shape = || {
        let kinds = [ShaperKind::Zv, ShaperKind::Mzv, ShaperKind::Ei, ShaperKind::Smooth];
        let kind = kinds[(draw.share() * 4.0) as usize];
        let frequency = draw.scale(8.0, 0.05 / cycle);
        let damping = if draw.chance(0.3) { 0.0 } else { draw.between(0.0, 0.3) };
        draw.chance(0.8).then_some(Shape { kind, frequency, damping })
    };
    let all = [(); AXES].map(|()| shape());
    // Often alike.
    if draw.chance(0.4) || alike { [all[0]; AXES] } else { all }
}

/// Where a block leads, and how far from it the machine may be.
#[derive(Clone, Copy, Debug)]
enum Way {
    Line {
        from: [f64; AXES],
        to: [f64; AXES],
    },
    /// In the plane of the first two axes.
    Arc {
        centre: [f64; 2],
        radius: f64,
        height: f64,
    },
}

impl Way {
    fn distance(&self, at: &[f64; AXES]) -> f64 {
        match self {
            Self::Line { from, to } => {
                let way: Vec<f64> = (0..AXES).map(|i| to[i] - from[i]).collect();
                let square: f64 = way.iter().map(|x| x * x).sum();
                let along: f64 = (0..AXES).map(|i| (at[i] - from[i]) * way[i]).sum();
                let part = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
                (0..AXES).map(|i| (at[i] - from[i] - part * way[i]).powi(2)).sum::<f64>().sqrt()
            }
            Self::Arc { centre, radius, height } => {
                let r = (at[0] - centre[0]).hypot(at[1] - centre[1]);
                (r - radius).hypot(at[2] - height)
            }
        }
    }
}

/// A block from a place, its way, and the tolerance it has.
fn block<S: Scalar>(
    draw: &mut Draw,
    from: &Point,
    config: &Config<S, AXES>,
    tag: u32,
) -> (Block<S, AXES>, Option<(Way, f64)>) {
    let reserve = config.follower.reserve.to_f64();
    // Of the least axis no more than some tenths of a second.
    let slowest = config.limits.axes().iter().map(|axis| axis.velocity.to_f64());
    let size = draw.scale(0.02, 20.0).min(0.2 * slowest.fold(f64::INFINITY, f64::min));
    let to: Point = std::array::from_fn(|i| {
        at((from[i].to_mm() + draw.between(-size, size)).clamp(-500.0, 500.0))
    });
    let feed = S::of(draw.scale(0.2, 2.0) * config.limits.axes()[0].velocity.to_f64());
    let mut block = Block::line(to, feed, tag);
    if draw.chance(0.1) {
        block.feed = Feed::Rapid;
    }
    if draw.chance(0.05) {
        block.motion = Motion::Event { pause: false };
        return (block, None);
    }
    if draw.chance(0.05) {
        block.motion = Motion::Dwell { seconds: S::of(draw.between(0.001, 0.05)) };
        return (block, None);
    }
    let mm = from.map(Coord::to_mm);
    let mut tolerance = config.tolerance.to_f64();
    if reserve > 0.0 && draw.chance(0.3) {
        tolerance = reserve * draw.scale(0.1, 5.0);
        block.tolerance = Some(S::of(tolerance));
        // Such a line has one axis, or all follow alike.
        if tolerance < reserve * 1.0001 && !config.follower.alike {
            let axis = (draw.share() * AXES as f64) as usize;
            let to = std::array::from_fn(|i| if i == axis { to[i] } else { from[i] });
            block.motion = Motion::Line { to };
            return (block, Some((Way::Line { from: mm, to: to.map(Coord::to_mm) }, tolerance)));
        }
    }
    let mut way = Way::Line { from: mm, to: to.map(Coord::to_mm) };
    if draw.chance(0.2) {
        let r = 0.3 * size;
        let end = [at(mm[0] + 2.0 * r), from[1], from[2]];
        let centre = (at(mm[0] + r), from[1]);
        let turn = if draw.chance(0.5) { Turn::Clockwise } else { Turn::CounterClockwise };
        block.motion = Motion::Arc { to: end, plane: (0, 1), centre, turn, extra_turns: 0 };
        way = Way::Arc { centre: [mm[0] + r, mm[1]], radius: r, height: mm[2] };
        if tolerance <= reserve * 1.0001 {
            tolerance = reserve * 1.5;
            block.tolerance = Some(S::of(tolerance));
        }
    }
    (block, Some((way, tolerance)))
}

fn press(draw: &mut Draw, controls: Controls<'_>) {
    match (draw.share() * 9.0) as usize {
        0 => controls.quick_hold(),
        1 | 2 => controls.hold(),
        3 | 4 => controls.resume(),
        5 => controls.stop(),
        6 => controls.feed_override(draw.between(10.0, 200.0) as u16),
        7 => controls.rapid_override(draw.between(10.0, 100.0) as u16),
        _ => controls.single_block(draw.chance(0.3)),
    }
}

/// What the machine is given, watched.
struct Watch<S> {
    config: Config<S, AXES>,
    ways: Vec<(Way, f64)>,
    before: Setpoint<S, AXES>,
    /// Distance over tolerance at most.
    most: f64,
    quick: bool,
}

impl<S: Scalar> Watch<S> {
    fn see(&mut self, now: &Setpoint<S, AXES>, on_path: bool) {
        let between = Between { from: self.before, to: *now, cycle: self.config.cycle.to_f64() };
        between.check(&self.config, self.quick);
        let slack = if S::NAME == "f32" { 2.0e-5 } else { 1.0e-7 };
        for i in 0..AXES {
            // Between two cycles of bounded jerk.
            let h = between.cycle;
            let mean = (between.from.velocity[i] + now.velocity[i]).to_f64() / 2.0;
            let moved: f64 = now.position(i).minus(between.from.position(i));
            let gain = (now.acceleration[i] - between.from.acceleration[i]).to_f64() / h;
            let jerk = self.config.limits.axes()[i].jerk.to_f64().max(gain.abs());
            let stops = self.config.stop_limits.map_or(0.0, |of| of.axes()[i].jerk.to_f64());
            let off = (moved - mean * h + gain * h * h * h / 12.0).abs();
            let may = 0.2 * jerk.max(stops) * h * h * h + slack * (1.0 + mean * h);
            assert!(off < may, "axis {i}: jumps by {off} of {may} mm");
        }
        self.before = *now;
        // At rest it may be where a jog has led.
        if !on_path || now.activity == Activity::Idle {
            return;
        }
        let at: [f64; AXES] = std::array::from_fn(|i| now.position_mm(i));
        let share =
            |(way, tolerance): &(Way, f64)| (way.distance(&at) - slack) / tolerance.max(1.0e-9);
        let least = self.ways.iter().map(share).fold(f64::INFINITY, f64::min);
        if least.is_finite() {
            self.most = self.most.max(least);
        }
    }
}

fn random_program<S: Scalar>(seed: u64, commands: bool) -> f64 {
    let mut draw = Draw(seed | 1);
    let mut config = machine::<S>(&mut draw);
    config.tolerance = S::of(draw.scale(0.005, 0.2));
    // Where motors follow several axes these are shaped alike.
    let motors = config.limits.motor(0).is_some();
    let shapes = shapes(&mut draw, config.cycle.to_f64(), motors);
    let mut shaper = Box::new(Shaper::<S, AXES, HISTORY>::new());
    shaper.set(shapes, &config).unwrap();
    config.follower = shaper.follower(&config);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let start = [Coord::ZERO; AXES];
    let (mut planner, mut interpolator): Core<'_, S> = link.split(config, start).unwrap();
    let rest = shaper.shape(&interpolator.tick());
    let mut watch = Watch { config, ways: Vec::new(), before: rest, most: 0.0, quick: false };
    let count = 5 + (draw.share() * 40.0) as u32;
    let (mut tag, mut wanted, mut events) = (0, None, 0);
    let controls = planner.controls();
    let slices = if draw.chance(0.5) { 0 } else { 1 + (draw.share() * 6.0) as u32 };
    let (mut idle, mut told, mut jogs) = (0, 0, 0);
    for _ in 0..4_000_000u32 {
        while tag < count && !planner.is_jogging() {
            let (block, way) = *wanted
                .get_or_insert_with(|| block::<S>(&mut draw, planner.end(), &config, tag + 1));
            match planner.push(&block) {
                Ok(()) => {
                    wanted = None;
                    tag += 1;
                    watch.ways.extend(way);
                    events += u32::from(matches!(block.motion, Motion::Event { .. }));
                }
                Err(PushError::Full) => break,
                Err(error) => panic!("{error}"),
            }
        }
        if tag == count {
            planner.finish();
        }
        let progress = match slices {
            0 => planner.settle(),
            _ => (0..slices).map(|_| planner.poll()).last().unwrap(),
        };
        if commands && draw.chance(0.01) {
            press(&mut draw, controls);
            watch.quick = true;
        }
        if progress == Progress::Held {
            assert!(shaper.is_settled(), "held before the machine rests");
            if commands && jogs < 3 && draw.chance(0.02) {
                let by = std::array::from_fn(|_| at(draw.between(-1.0, 1.0)));
                let feed = config.limits.axes()[0].velocity;
                planner.jog(&Jog::Step { by, feed }).unwrap();
                jogs += 1;
            } else if planner.is_jogging() && draw.chance(0.01) {
                let feed = config.limits.axes()[0].velocity;
                let _ = planner.jog(&Jog::Back { feed });
            } else if draw.chance(0.02) && !planner.is_jogging() {
                controls.single_block(false);
                controls.feed_override(100);
                controls.resume();
            }
        }
        if commands && draw.chance(0.002) && !planner.is_jogging() {
            // It is refused but at rest, of the setpoints and of the machine.
            let velocity = config.limits.axes().map(|axis| axis.velocity * S::of(0.5));
            if planner.jog(&Jog::Velocity { velocity, time: S::of(0.05) }).is_ok() {
                // What comes begins elsewhere.
                wanted = None;
                jogs += 1;
            }
        }
        let setpoint = interpolator.tick();
        let shaped = shaper.shape(&setpoint);
        if setpoint.activity == Activity::Jogging {
            assert_eq!(setpoint, shaped, "a jog is shaped");
        }
        watch.see(&shaped, !planner.is_jogging());
        if matches!(shaped.activity, Activity::Idle | Activity::Event | Activity::Dwelling) {
            assert!(shaper.is_settled());
            let gap: Vec<f64> =
                (0..AXES).map(|i| shaped.position(i).minus(setpoint.position(i))).collect();
            assert!(gap.iter().all(|x| *x == 0.0), "at rest elsewhere: {gap:?}");
        }
        told += u32::from(shaped.activity == Activity::Event);
        if progress == Progress::Done && shaped.activity == Activity::Idle && !planner.is_jogging()
        {
            idle += 1;
            if idle > 2 {
                let end = planner.end().map(Coord::to_mm);
                for (i, end) in end.iter().enumerate() {
                    assert!((shaped.position_mm(i) - end).abs() < 2.0e-6);
                }
                assert_eq!((told, planner.counters().stuck), (events, 0));
                return watch.most;
            }
        } else {
            idle = 0;
        }
    }
    panic!("no end: tag {tag} of {count}");
}

#[test]
fn what_the_machine_is_given_keeps_limits_and_band() {
    let mut most: f64 = 0.0;
    for case in 0..30 * u64::from(soak()) {
        for (commands, seed) in [(false, 0x9e37), (true, 0x79b9)] {
            let seed = (case + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ seed;
            let run = if case % 2 == 0 { random_program::<f32> } else { random_program::<f64> };
            let share = std::panic::catch_unwind(|| run(seed, commands));
            let share = share.unwrap_or_else(|_| panic!("case {case}, {commands}"));
            assert!(share <= 1.0, "case {case}, {commands}: {share} of the tolerance");
            most = most.max(share);
        }
    }
    // The band is used.
    assert!(most > 0.6, "{most}");
}

/// A dwell lasts as long as programmed, whatever stands before it: the machine settles once.
#[test]
fn a_dwell_behind_a_standstill_is_no_longer_than_programmed() {
    let axis = AxisLimits::linear(200.0f32, 2000.0, 5.0e4);
    for kind in [ShaperKind::Zv, ShaperKind::Mzv, ShaperKind::Ei, ShaperKind::Smooth] {
        let shape = Shape { kind, frequency: 40.0, damping: 0.05 };
        let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
        config.tolerance = 0.1;
        let mut shaper = Box::new(Shaper::<f32, AXES, HISTORY>::new());
        shaper.set([Some(shape); AXES], &config).unwrap();
        config.follower = shaper.follower(&config);
        let mut link = Box::new(Link::<f32, AXES, 16, 64>::new());
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        let line = |x: f64, tag| Block::line([at(x), at(0.0), at(0.0)], 100.0, tag);
        let (dwell, ms) = (|tag| Block::dwell(0.005, tag), 5);
        let blocks = [
            line(10.0, 1),
            Block::event(2),
            dwell(3),
            line(20.0, 4),
            dwell(5),
            dwell(6),
            Block::event(7),
            Block::event(8),
            dwell(9),
            line(30.0, 10),
        ];
        for block in &blocks {
            planner.push(block).unwrap();
        }
        planner.finish();
        let (mut dwelt, mut told) = ([0; 11], 0);
        for _ in 0..2000 {
            planner.settle();
            let setpoint = interpolator.tick();
            let shaped = shaper.shape(&setpoint);
            dwelt[shaped.tag as usize] += u32::from(shaped.activity == Activity::Dwelling);
            told += u32::from(shaped.activity == Activity::Event);
            assert!(shaped.activity == Activity::Running || shaper.is_settled());
        }
        assert_eq!(told, 3, "{kind:?}");
        // A servo cycle more or less that has begun.
        for tag in [3, 5, 6, 9] {
            assert!((ms - 1..=ms + 1).contains(&dwelt[tag]), "{kind:?}: {dwelt:?}");
        }
    }
}

/// Long lines at any angle, which are run by the axes' own limits but near their ends.
fn random_legs<S: Scalar>(seed: u64) -> [f64; 2] {
    let mut draw = Draw(seed | 1);
    let axis = AxisLimits::linear(S::of(400.0), S::of(8.0e3), S::of(1.0e6));
    let mut config = Config::<S, AXES>::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(draw.scale(0.02, 0.1));
    let kinds = [ShaperKind::Zv, ShaperKind::Mzv, ShaperKind::Ei, ShaperKind::Smooth];
    let kind = kinds[(draw.share() * 4.0) as usize];
    let frequency = draw.between(25.0, 60.0);
    let shape = Shape { kind, frequency, damping: draw.between(0.0, 0.2) };
    let mut shaper = Box::new(Shaper::<S, AXES, HISTORY>::new());
    shaper.set([Some(shape); AXES], &config).unwrap();
    config.follower = shaper.follower(&config);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let start = [Coord::ZERO; AXES];
    let (mut planner, mut interpolator): Core<'_, S> = link.split(config, start).unwrap();
    let rest = shaper.shape(&interpolator.tick());
    let mut watch = Watch { config, ways: Vec::new(), before: rest, most: 0.0, quick: false };
    let feed = S::of(draw.scale(50.0, 400.0));
    let (mut tag, mut fastest) = (0, 0.0f64);
    // What the shaper looks back on: whether it is more than is borne in a bend, and where it was.
    let span = (config.follower.settle / config.cycle).to_f64().round() as usize;
    let mut past: VecDeque<(bool, [f64; AXES])> = VecDeque::new();
    for _ in 0..200_000 {
        while tag < 25 && !planner.is_full() {
            let from = *planner.end();
            let size = draw.scale(3.0, 40.0);
            let to = std::array::from_fn(|i| {
                let by = if i < 2 { draw.between(-size, size) } else { 0.0 };
                at(from[i].to_mm() + by)
            });
            tag += 1;
            if draw.chance(0.3) {
                // Calm lines between: where there is no room for other limits they stay as they are.
                let share = S::of(if draw.chance(0.5) { 1.0 } else { 0.2 });
                let calm = AxisLimits {
                    velocity: axis.velocity * share,
                    acceleration: axis.acceleration * share,
                    ..axis
                };
                let _ = planner.set_limits(Limits::new([calm; AXES]).unwrap());
            }
            planner.push(&Block::line(to, feed, tag)).unwrap();
            let way = Way::Line { from: from.map(Coord::to_mm), to: to.map(Coord::to_mm) };
            watch.ways.push((way, config.tolerance.to_f64()));
        }
        if tag == 25 {
            planner.finish();
        }
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        let shaped = shaper.shape(&setpoint);
        watch.see(&shaped, true);
        let borne = setpoint.acceleration.iter().zip(&config.follower.acceleration);
        let more = borne.into_iter().any(|(seen, of)| seen.to_f64().abs() > 1.01 * of.to_f64());
        past.push_front((more, std::array::from_fn(|i| setpoint.position_mm(i))));
        past.truncate(span + 1);
        if past.iter().any(|(more, _)| *more) {
            let [to, from] = [past.front(), past.back()].map(|end| end.unwrap().1);
            let chord = Way::Line { from, to };
            let straight = past.iter().all(|(_, at)| chord.distance(at) < 2.0e-5);
            assert!(straight, "more than is borne in a bend, tag {}", setpoint.tag);
        }
        for (seen, borne) in shaped.acceleration.iter().zip(&config.follower.acceleration) {
            fastest = fastest.max(seen.to_f64().abs() / borne.to_f64());
        }
        if progress == Progress::Done && shaped.activity == Activity::Idle {
            return [watch.most, fastest];
        }
    }
    panic!("no end");
}

#[test]
fn long_lines_are_run_by_all_that_the_axes_have() {
    let [mut most, mut fastest] = [0.0f64; 2];
    for case in 0..40 * u64::from(soak()) {
        let seed = (case + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let run = if case % 2 == 0 { random_legs::<f32> } else { random_legs::<f64> };
        let seen = run(seed);
        assert!(seen[0] <= 1.0, "case {case}: {} of the tolerance", seen[0]);
        (most, fastest) = (most.max(seen[0]), fastest.max(seen[1]));
    }
    assert!(most > 0.6 && fastest > 1.5, "{most} of the band, {fastest} of what is borne at bends");
}

/// The simulator's judge, of a machine file.
#[test]
fn a_program_on_a_machine_with_shapers_is_inside_the_band() {
    let shapers = [
        "[shaper.default]\nkind = \"zv\"\nfrequency = 45\ndamping = 0.06\n",
        "[shaper.X]\nkind = \"mzv\"\nfrequency = 60\n[shaper.Y]\nkind = \"ei\"\nfrequency = 35\n",
        "[shaper.default]\nkind = \"smooth\"\nfrequency = 70\ndamping = 0.1\n",
    ];
    let mut program = Program::default();
    for n in 1..60 {
        let mut to = [0.0; 9];
        let size = if n % 20 < 10 { 4.0 } else { 0.5 };
        (to[0], to[1]) = (f64::from(n / 2) * size, f64::from((n + 1) / 2) * 3.0);
        program.moves.push(Move {
            path: Course::Line { to },
            speed: Speed::PerSecond(80.0),
            tolerance: None,
            exact_stop: false,
            line: n as usize as u32,
        });
    }
    for shaper in shapers {
        let machine = Machine::parse(&format!("tolerance = 0.05\n{shaper}")).unwrap();
        for precision in [Precision::F32, Precision::F64] {
            let (verdict, _) = judged(&program, &machine, precision, &Events::default()).unwrap();
            let broken = violations(&verdict);
            assert!(broken.is_empty(), "{shaper} {precision:?}: {broken:?}");
            assert!(verdict.deviation > 0.3 * 0.05, "{}", verdict.deviation);
        }
    }
    let error = Machine::parse("[shaper.X]\nkind = \"zv\"\nfrequency = 0.1\n").unwrap_err();
    assert!(format!("{error:#}").contains("shaper.X: frequency"), "{error:#}");
}
