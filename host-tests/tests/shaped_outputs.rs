//! Outputs where setpoints are shaped: they switch where the machine is, not where the setpoints are. Along straight lines the place is
//! compared with the programmed one; on any path with that of another core, whose outputs follow its setpoints; with holds, overrides
//! and aborts at random times.

#[allow(dead_code)]
#[path = "common/cycles.rs"]
mod cycles;

use cycles::{AXES, Draw, Point, at, soak};
use splineway::output::{Shape, Shaper, ShaperKind};
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Interpolator, Limits, Link, Motion,
    Output, Planner, Power, Progress, Scalar, Setpoint, Switch, Switched, Trigger, Turn,
};

const HISTORY: usize = 256;
const CYCLE: f64 = 1.0e-3;

type Core<'a, S> = (Planner<'a, S, AXES, 32, 96>, Interpolator<'a, S, AXES>);

fn machine<S: Scalar>(draw: &mut Draw) -> Config<S, AXES> {
    let axis = AxisLimits::linear(S::of(300.0), S::of(2.0e3), S::of(4.0e5));
    let mut config = Config::<S, AXES>::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(draw.scale(0.02, 0.1));
    let stop = AxisLimits::linear(S::of(300.0), S::of(4.0e3), S::of(1.0e6));
    config.stop_limits = Some(Limits::new([stop; AXES]).unwrap());
    config
}

fn shape(draw: &mut Draw) -> Shape {
    let kinds = [ShaperKind::Zv, ShaperKind::Mzv, ShaperKind::Ei, ShaperKind::Smooth];
    let kind = kinds[(draw.share() * 4.0) as usize];
    Shape { kind, frequency: draw.between(25.0, 70.0), damping: draw.between(0.0, 0.2) }
}

/// One for each axis, or the same for all.
fn shapes(draw: &mut Draw, alike: bool) -> [Option<Shape>; AXES] {
    let first = shape(draw);
    std::array::from_fn(|_| {
        if alike { Some(first) } else { Some(shape(draw)).filter(|_| draw.chance(0.8)) }
    })
}

/// A machine with shapers, and whether its axes are shaped alike.
struct Shaped<S: Scalar> {
    config: Config<S, AXES>,
    shaper: Box<Shaper<S, AXES, HISTORY>>,
    alike: bool,
}

impl<S: Scalar> Shaped<S> {
    fn new(draw: &mut Draw) -> Self {
        let mut config = machine::<S>(draw);
        let alike = draw.chance(0.5);
        let mut shaper = Box::new(Shaper::<S, AXES, HISTORY>::new());
        shaper.set(shapes(draw, alike), &config).unwrap();
        config.follower = shaper.follower(&config);
        Self { config, shaper, alike }
    }
}

/// Presses a button now and then.
fn press(draw: &mut Draw, controls: &[Controls<'_>]) {
    let (which, percent) = ((draw.share() * 6.0) as usize, draw.between(20.0, 180.0) as u16);
    for controls in controls {
        match which {
            0 => controls.quick_hold(),
            1 | 2 => controls.hold(),
            3 => controls.feed_override(percent),
            _ => controls.resume(),
        }
    }
}

/// Where something that moves as two setpoints say is in between.
fn between<S: Scalar>(
    (before, after): (&Setpoint<S, AXES>, &Setpoint<S, AXES>),
    u: f64,
) -> [f64; AXES] {
    let v = 1.0 - u;
    std::array::from_fn(|axis| {
        let ends = [before, after]
            .map(|of| (of.position_mm(axis), of.velocity[axis].to_f64() * CYCLE / 3.0));
        let [(a, da), (b, db)] = ends;
        v * v * v * a + 3.0 * v * v * u * (a + da) + 3.0 * v * u * u * (b - db) + u * u * u * b
    })
}

/// Lines one behind the other in one direction, each with a feed of its own, and a switch at each end: where the axes are when it comes.
/// Gives how far off they were at most, and how far the setpoints were.
fn straight<S: Scalar>(seed: u64) -> [f64; 2] {
    let mut draw = Draw(seed | 1);
    let Shaped { config, mut shaper, alike } = Shaped::<S>::new(&mut draw);
    let mut link = Box::new(Link::<S, AXES, 32, 96>::new());
    let (mut planner, mut interpolator): Core<'_, S> =
        link.split(config, [Coord::ZERO; AXES]).unwrap();
    let mut way: [f64; AXES] = std::array::from_fn(|_| draw.between(-1.0, 1.0));
    if !alike {
        let axis = (draw.share() * AXES as f64) as usize;
        way = std::array::from_fn(|i| if i == axis { way[i] } else { 0.0 });
    }
    let size = way.iter().map(|x| x * x).sum::<f64>().sqrt();
    let count = 4 + (draw.share() * 11.0) as u32;
    let (mut length, mut ends) = (0.0, Vec::<[f64; AXES]>::new());
    for tag in 0..count {
        length += draw.scale(0.3, 12.0);
        let to: Point = way.map(|x| at(x / size * length));
        planner.push(&Block::line(to, S::of(draw.scale(10.0, 250.0)), tag)).unwrap();
        planner.push_switch(&Switch::analogue(0, S::of(f64::from(tag))).at(Trigger::End)).unwrap();
        ends.push(to.map(Coord::to_mm));
    }
    planner.finish();
    let (controls, commands) = (planner.controls(), draw.chance(0.6));
    let mut before = shaper.shape(&interpolator.tick());
    let mut raw = before;
    let (mut off, mut ahead, mut fired) = (0.0f64, 0.0f64, 0);
    for _ in 0..400_000 {
        let progress = planner.settle();
        if commands && draw.chance(0.01) {
            press(&mut draw, &[controls]);
        }
        if progress == Progress::Held && draw.chance(0.05) {
            controls.feed_override(100);
            controls.resume();
        }
        let now = interpolator.tick();
        let shaped = shaper.shape(&now);
        interpolator.switch(&shaped, |switched| {
            assert_eq!(switched.value.to_f64() as u32, fired, "out of order");
            let end = &ends[fired as usize];
            let along = |place: [f64; AXES]| {
                (0..AXES).map(|i| (place[i] - end[i]) * way[i] / size).sum::<f64>().abs()
            };
            let u = switched.fraction.to_f64();
            off = off.max(along(between((&before, &shaped), u)));
            ahead = ahead.max(along(between((&raw, &now), u)));
            fired += 1;
        });
        (before, raw) = (shaped, now);
        if progress == Progress::Done && shaped.activity == Activity::Idle {
            assert_eq!(fired, count);
            return [off, ahead];
        }
    }
    panic!("no end: {fired} of {count}");
}

#[test]
fn on_a_line_outputs_switch_where_the_machine_is() {
    let [mut most, mut ahead] = [0.0f64; 2];
    for case in 0..80 * u64::from(soak()) {
        let seed = (case + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let wide = case % 2 == 1;
        let seen = if wide { straight::<f64>(seed) } else { straight::<f32>(seed) };
        // Within a cycle what is shaped is a little rougher than what the fraction is worked out for.
        assert!(seen[0] < 5.0e-4, "case {case}: {} mm off", seen[0]);
        (most, ahead) = (most.max(seen[0]), ahead.max(seen[1]));
    }
    println!("{most} mm off at most; the setpoints were {ahead} mm ahead");
    assert!(ahead > 1.0, "{ahead}");
}

/// Stands for the digital output, which switches a time before.
const LEADS: u8 = 4;

/// What a core's outputs did: output, number of the switch, time in cycles, place.
#[derive(Default)]
struct Fired(Vec<(u8, u32, f64, [f64; AXES])>);

impl Fired {
    fn note<S: Scalar>(
        &mut self,
        switched: &Switched<S>,
        cycle: u32,
        ends: (&Setpoint<S, AXES>, &Setpoint<S, AXES>),
    ) {
        let (output, value) = match switched.output {
            Output::Analogue(output) => (output, switched.value.to_f64() as u32),
            Output::Digital(_) => {
                (LEADS, self.0.iter().filter(|(of, ..)| *of == LEADS).count() as u32)
            }
            Output::Power => return,
        };
        let u = switched.fraction.to_f64();
        self.0.push((output, value, f64::from(cycle) + u, between(ends, u)));
    }
}

/// Lines, arcs, dwells and events.
fn program<S: Scalar>(
    draw: &mut Draw,
    planners: &mut [&mut Planner<'_, S, AXES, 32, 96>; 2],
) -> u32 {
    let count = 3 + (draw.share() * 11.0) as u32;
    for tag in 0..count {
        let from = *planners[0].end();
        let mm = from.map(Coord::to_mm);
        let size = draw.scale(0.2, 15.0);
        let feed = S::of(80.0);
        let to: Point = std::array::from_fn(|i| at(mm[i] + draw.between(-size, size)));
        let block = match (draw.share() * 8.0) as usize {
            0 => Block::dwell(S::of(draw.scale(1.0e-3, 0.05)), tag),
            1 => Block::event(tag),
            2 | 3 => {
                let end = [at(mm[0] + 2.0 * size), from[1], from[2]];
                let centre = (at(mm[0] + size), from[1]);
                let turn = Turn::Clockwise;
                let motion = Motion::Arc { to: end, plane: (0, 1), centre, turn, extra_turns: 0 };
                Block { motion, ..Block::line(end, feed, tag) }
            }
            _ => Block::line(to, feed, tag),
        };
        let value = S::of(f64::from(tag));
        let trigger = if draw.chance(0.5) { Trigger::End } else { Trigger::Start };
        let by = S::of(draw.between(-3.0, 3.0));
        let lag = S::of(draw.between(0.0, 0.05));
        let switches = [
            Switch::analogue(0, value).at(trigger),
            Switch::analogue(1, value).at(trigger).behind_mm(by),
            Switch::analogue(2, value).at(trigger).behind_s(lag),
            Switch::analogue(3, value).at(Trigger::Rest),
        ];
        let lead = Switch::digital(0, tag.is_multiple_of(2)).behind_s(S::of(-0.02));
        let rests = draw.chance(0.2);
        for planner in planners.iter_mut() {
            planner.push(&block).unwrap();
            if tag < 8 {
                planner.push_switch(&lead).unwrap();
            }
            for switch in switches.iter().take(if rests { 4 } else { 3 }) {
                planner.push_switch(switch).unwrap();
            }
        }
    }
    for planner in planners {
        planner.finish();
    }
    count
}

/// Two cores run the same. The outputs of the one follow its setpoints, those of the other the machine. Gives how far apart the places are
/// at which they switch, at most, in parts of what the shaper may leave the
/// path by, and how many there were.
fn any_path<S: Scalar>(seed: u64, abort: bool) -> (f64, usize) {
    let mut draw = Draw(seed | 1);
    let Shaped { config, mut shaper, .. } = Shaped::<S>::new(&mut draw);
    let span = (config.follower.settle.to_f64() / CYCLE).round();
    let (mut raw_link, mut link) =
        (Box::new(Link::<S, AXES, 32, 96>::new()), Box::new(Link::<S, AXES, 32, 96>::new()));
    let start = [Coord::ZERO; AXES];
    let (mut raw_planner, mut raw): Core<'_, S> = raw_link.split(config, start).unwrap();
    let (mut planner, mut interpolator): Core<'_, S> = link.split(config, start).unwrap();
    let power = Power::in_proportion(S::of(800.0), S::ZERO, S::of(1.0e4));
    raw_planner.set_power(&power).unwrap();
    planner.set_power(&power).unwrap();
    program(&mut draw, &mut [&mut raw_planner, &mut planner]);
    let controls = [raw_planner.controls(), planner.controls()];
    let commands = abort || draw.chance(0.6);
    let when = abort.then(|| draw.between(5.0, 800.0) as u32);
    let mut befores = [raw.tick(); 2];
    befores[1] = shaper.shape(&interpolator.tick());
    let (mut by_setpoint, mut by_machine) = (Fired::default(), Fired::default());
    let mut powers = std::collections::VecDeque::from([0.0f64]);
    for cycle in 0..400_000u32 {
        let progress = planner.settle();
        assert_eq!(raw_planner.settle(), progress, "they run the same");
        if commands && draw.chance(0.01) {
            press(&mut draw, &controls);
        }
        if when == Some(cycle) {
            for controls in &controls {
                controls.abort();
            }
        }
        if progress == Progress::Held && draw.chance(0.05) {
            for controls in &controls {
                controls.feed_override(100);
                controls.resume();
            }
        }
        let now = raw.tick();
        let unshaped =
            raw.switch(&now, |switched| by_setpoint.note(&switched, cycle, (&befores[0], &now)));
        let same = interpolator.tick();
        assert_eq!(same, now, "they run the same");
        let shaped = shaper.shape(&same);
        let level = interpolator
            .switch(&shaped, |switched| by_machine.note(&switched, cycle, (&befores[1], &shaped)));
        // Power goes with the speed of the machine: a mean of what it was with those of the setpoints.
        powers.push_front(unshaped.to_f64());
        powers.truncate(span as usize + 1);
        let least = powers.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = powers.iter().copied().fold(0.0, f64::max);
        let level = level.to_f64();
        let dropped = matches!(progress, Progress::Aborted);
        assert!(
            (level > least * 0.999 - 0.5 && level < greatest * 1.001 + 0.5) || when.is_some(),
            "{cycle}: power {level} not of {least} to {greatest}"
        );
        if shaped.activity == Activity::Idle || dropped {
            assert!(level == 0.0, "{cycle}: power {level} at rest");
        }
        // At once: not when the machine has settled.
        if when.is_some_and(|when| cycle > when) && now.activity == Activity::Idle {
            assert!(level == 0.0 || befores[0].activity != Activity::Idle, "{cycle}: {level}");
        }
        befores = [now, shaped];
        let ends = progress == Progress::Done && shaped.activity == Activity::Idle;
        if dropped || (ends && by_machine.0.len() == by_setpoint.0.len()) {
            break;
        }
        assert!(cycle < 300_000, "no end: {} {}", by_machine.0.len(), by_setpoint.0.len());
    }
    if when.is_some() {
        // What the machine has not come to is dropped.
        assert!(by_machine.0.len() <= by_setpoint.0.len());
        return (0.0, by_machine.0.len());
    }
    let mut most = 0.0f64;
    for output in 0..=LEADS {
        let of = |fired: &Fired| {
            let of = fired.0.iter().filter(|(of, ..)| *of == output).copied();
            of.map(|(_, value, time, place)| (value, time, place)).collect::<Vec<_>>()
        };
        let (raw, shaped) = (of(&by_setpoint), of(&by_machine));
        assert_eq!(raw.len(), shaped.len(), "output {output}");
        for (a, b) in raw.iter().zip(&shaped) {
            assert_eq!(a.0, b.0, "output {output}: out of order");
            // Near a rest a place is taken for its own a little before.
            let late = b.1 - a.1;
            // A time before a place is kept by the plan in force.
            assert!(
                (output == LEADS && commands) || late > -3.0 && late < span + 3.0,
                "output {output}: {late} of {span} cycles: {a:?} {b:?}"
            );
            let off = (0..AXES).map(|i| (a.2[i] - b.2[i]).powi(2)).sum::<f64>().sqrt();
            // Of those that wait for a time, the machine is where it is then.
            if output < 2 {
                most = most.max(off / config.follower.reserve.to_f64());
            }
        }
    }
    (most, by_machine.0.len())
}

#[test]
fn on_any_path_they_are_behind_the_setpoints_by_no_more_than_the_shaper() {
    let (mut most, mut count) = (0.0f64, [0; 2]);
    for case in 0..60 * u64::from(soak()) {
        let seed = (case + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let run = if case % 2 == 0 { any_path::<f32> } else { any_path::<f64> };
        let share = std::panic::catch_unwind(|| [false, true].map(|abort| run(seed, abort)));
        let Ok(seen) = share else { panic!("case {case}") };
        most = most.max(seen[0].0);
        count = std::array::from_fn(|i| count[i] + seen[i].1);
    }
    println!("{most} of the reserve; {count:?} switches");
    assert!(most < 2.0, "{most}");
    assert!(count.iter().all(|count| *count > 300), "{count:?}");
}

/// An abort in the time in which an event has been run, and the machine has not come to rest there: what is asked for afterwards waits for
/// its own event.
#[test]
fn an_event_that_an_abort_has_overtaken_switches_nothing() {
    for late in 0..40 {
        let mut config = machine::<f64>(&mut Draw(1));
        let shape = Shape { kind: ShaperKind::Ei, frequency: 30.0, damping: 0.05 };
        let mut shaper = Box::new(Shaper::<f64, AXES, HISTORY>::new());
        shaper.set([Some(shape); AXES], &config).unwrap();
        config.follower = shaper.follower(&config);
        let mut link = Box::new(Link::<f64, AXES, 32, 96>::new());
        let (mut planner, mut interpolator): Core<'_, f64> =
            link.split(config, [Coord::ZERO; AXES]).unwrap();
        let controls = planner.controls();
        let to = |x: f64| [at(x), Coord::ZERO, Coord::ZERO];
        planner.push(&Block::line(to(5.0), 100.0, 1)).unwrap();
        planner.push(&Block::event(2)).unwrap();
        planner.push(&Block::line(to(10.0), 100.0, 3)).unwrap();
        planner.finish();
        let (mut since, mut pushed, mut told) = (None, false, false);
        for _ in 0..3000 {
            let progress = planner.settle();
            if progress == Progress::Aborted && planner.acknowledge_abort() {
                let x = planner.end()[0].to_mm();
                planner.push(&Block::line(to(x + 3.0), 100.0, 4)).unwrap();
                planner.push_power(&Power::constant(300.0), 5).unwrap();
                planner.push(&Block::dwell(0.05, 6)).unwrap();
                planner.finish();
                pushed = true;
            }
            let now = interpolator.tick();
            if now.activity == Activity::Event && since.is_none() {
                since = Some(0);
            }
            if let Some(since) = &mut since {
                if *since == late {
                    controls.abort();
                }
                *since += 1;
            }
            let shaped = shaper.shape(&now);
            let power = interpolator.switch(&shaped, |_| ());
            told |= pushed && shaped.activity == Activity::Event;
            assert!(power == 0.0 || told, "{late}: power {power} before its event");
        }
        assert!(pushed && told, "{late}");
    }
}

/// Axes that rest but for the rounding of what is weighed have no speeds whose squares could be divided by: what a setpoint says is a number in
/// every cycle, whatever stands between two moves.
#[test]
fn speed_and_power_are_numbers_in_every_cycle() {
    let mut draw = Draw(7);
    let smooth = |frequency| Shape { kind: ShaperKind::Smooth, frequency, damping: 0.014 };
    for _ in 0..400 * soak() {
        let axis = AxisLimits::linear(100.0f32, 2.0e3, 5.0e4);
        let mut config = Config::<f32, AXES>::new(Limits::new([axis; AXES]).unwrap());
        let mut shaper = Box::new(Shaper::<f32, AXES, HISTORY>::new());
        let [first, second] = [0; 2].map(|_| smooth(draw.between(35.0, 90.0)));
        shaper.set([Some(first), Some(first), Some(second)], &config).unwrap();
        config.follower = shaper.follower(&config);
        let mut link = Box::new(Link::<f32, AXES, 32, 96>::new());
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        planner.set_power(&Power::in_proportion(1000.0, 0.0, 1000.0)).unwrap();
        let mut place = [0.0; AXES];
        for move_ in 0..3 {
            place = place.map(|x| x + draw.between(0.0, 3.0));
            place[0] = 0.0;
            planner.push(&Block::line(place.map(at), 20.0, move_)).unwrap();
            planner.push(&Block::event(10)).unwrap();
            planner.push(&Block::event(11)).unwrap();
        }
        planner.finish();
        for _ in 0..2500 {
            planner.settle();
            let setpoint = shaper.shape(&interpolator.tick());
            let power = interpolator.switch(&setpoint, |_| {});
            assert!(setpoint.path_speed.is_finite() && power.is_finite(), "{setpoint:?}, {power}");
        }
    }
}

/// Where axes are shaped unlike each other, one may stand while the shaper of another has not come to its end: a constant power is off there.
#[test]
fn power_is_off_where_the_machine_stands() {
    let shape = |kind, frequency| Some(Shape { kind, frequency, damping: 0.05 });
    let zv = ShaperKind::Zv;
    for other in [shape(ShaperKind::Smooth, 13.0), shape(zv, 30.0), shape(zv, 100.0), None] {
        for power in [Power::constant(500.0), Power::in_proportion(1000.0, 100.0, 1500.0)] {
            let mut config = machine::<f64>(&mut Draw(1));
            config.tolerance = 0.2;
            let mut shaper = Box::new(Shaper::<f64, AXES, HISTORY>::new());
            shaper.set([shape(zv, 100.0), other, None], &config).unwrap();
            config.follower = shaper.follower(&config);
            let mut link = Box::new(Link::<f64, AXES, 32, 96>::new());
            let (mut planner, mut interpolator): Core<'_, f64> =
                link.split(config, [Coord::ZERO; AXES]).unwrap();
            let controls = planner.controls();
            planner.set_power(&power).unwrap();
            let to = |x: f64| [at(x), Coord::ZERO, Coord::ZERO];
            planner.push(&Block::line(to(20.0), 100.0, 1)).unwrap();
            let (mut before, mut stood, mut burned) = (shaper.shape(&interpolator.tick()), 0, 0);
            for cycle in 0..2000 {
                match cycle {
                    100 => controls.hold(),
                    500 => controls.resume(),
                    // Blocks have run dry.
                    900 => {
                        planner.push(&Block::line(to(40.0), 100.0, 2)).unwrap();
                        planner.finish();
                    }
                    _ => {}
                }
                planner.settle();
                let now = shaper.shape(&interpolator.tick());
                let power = interpolator.switch(&now, |_| ());
                if now.position_nm(0) == before.position_nm(0) && now.path_speed == 0.0 {
                    stood += 1;
                    assert!(power == 0.0, "{other:?}, {cycle}: {power} at rest");
                } else {
                    burned += usize::from(power > 0.0);
                }
                before = now;
            }
            assert!(stood > 500 && burned > 400, "{other:?}: {stood} {burned}");
        }
    }
}
