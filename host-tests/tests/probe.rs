//! Probes: edges, bounces and an operator at random times, against a check of the limits that knows setpoints alone, and against the
//! polynomial between them.

#[path = "common/cycles.rs"]
mod cycles;

use cycles::{AXES, Between, Draw, Point, at, cases, machine, off_most};
use proptest::prelude::*;
use splineway::{
    Activity, AxisLimits, AxisTravel, Block, Config, Coord, Input, Interpolator, Jog, JogError,
    Limits, Link, Outcome, Planner, Probe, ProbeError, Progress, PushError, Scalar, Setpoint,
    Travel,
};

/// A machine under the test, cycle by cycle.
struct Bench<'a, S: Scalar> {
    planner: Planner<'a, S, AXES>,
    interpolator: Interpolator<'a, S, AXES>,
    config: Config<S, AXES>,
    last: Between<S>,
    /// Whether something has asked for a stop.
    stops: bool,
}

impl<'a, S: Scalar> Bench<'a, S> {
    fn new(link: &'a mut Link<S, AXES>, config: Config<S, AXES>) -> Self {
        let (planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        let from = interpolator.tick();
        let last = Between { from, to: from, cycle: config.cycle.to_f64() };
        Self { planner, interpolator, config, last, stops: false }
    }

    fn tick(&mut self) -> Setpoint<S, AXES> {
        let now = self.interpolator.tick();
        self.last = Between { from: self.last.to, to: now, ..self.last };
        self.last.check(&self.config, self.stops);
        now
    }

    fn here(&self) -> Point {
        std::array::from_fn(|i| self.last.to.position(i))
    }

    /// Nothing moves any more that nobody asked for.
    fn stays(&mut self) {
        let here = self.here();
        for _ in 0..20 {
            self.planner.settle();
            assert_eq!(self.tick().activity, Activity::Idle);
            assert_eq!(self.here(), here);
        }
        assert_eq!(*self.planner.end(), here);
    }
}

/// How far a point is from the line between two, and how far along, mm.
fn on_line(point: &Point, from: &Point, to: &Point) -> (f64, f64) {
    let minus = |a: &Point, b: &Point| -> [f64; AXES] { std::array::from_fn(|i| a[i].minus(b[i])) };
    let (way, way_to) = (minus(point, from), minus(to, from));
    let norm = |x: &[f64; AXES]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let length = norm(&way_to);
    if length == 0.0 {
        return (norm(&way), 0.0);
    }
    let along = way.iter().zip(&way_to).map(|(a, b)| a * b / length).sum::<f64>();
    let beside: [f64; AXES] = std::array::from_fn(|i| way[i] - way_to[i] * along / length);
    (norm(&beside), along)
}

/// What an operator and a switch do to one probe.
#[derive(Debug)]
struct Script {
    /// Servo cycle of the edge, and the part of it.
    edge: (u32, f32),
    /// Told before the poll of its cycle, after it, or after the next tick.
    told: u32,
    hold: Option<(u32, u32)>,
    cancel: Option<u32>,
    abort: Option<u32>,
    /// Share of polls that are missed.
    misses: f64,
}

/// Random probes in one machine. How many of them were ended by their edge, at their target, and by the operator.
fn random_probes<S: Scalar>(seed: u64) -> [u32; 3] {
    let mut draw = Draw(seed | 1);
    let config = machine::<S>(&mut draw);
    let mut link: Link<S, AXES> = Link::new();
    let mut bench = Bench::new(&mut link, config);
    let mut seen = [0; 3];
    for _ in 0..6 {
        let reach = draw.scale(1.0e-3, 100.0);
        let feed = draw.scale(0.01, 2.0) * config.limits.axes()[0].velocity.to_f64();
        let one =
            |draw: &mut Draw| if draw.chance(0.3) { 0.0 } else { draw.between(-reach, reach) };
        let from = bench.here();
        let by = [(); AXES].map(|()| one(&mut draw));
        let to: Point = std::array::from_fn(|i| from[i].plus(by[i]));
        let closes = draw.chance(0.5);
        let probe = Probe { to, feed: S::of(feed), input: Input::Probe, closes };
        let inputs = bench.planner.inputs();
        inputs.tell(Input::Probe, closes, 0.0);
        let refused = bench.planner.probe(&probe);
        assert!(matches!(refused, Err(ProbeError::Input | ProbeError::OutOfRange { .. })));
        inputs.tell(Input::Probe, !closes, 0.0);
        if reach / feed > 300.0 {
            continue;
        }
        match bench.planner.probe(&probe) {
            Ok(()) => {}
            // A way that takes hours.
            Err(ProbeError::OutOfRange { .. }) => continue,
            Err(error) => panic!("{error}"),
        }
        let about = draw.scale(1.0, 3.0 * reach / feed / config.cycle.to_f64() + 300.0) as u32;
        let some =
            |draw: &mut Draw, chance| draw.chance(chance).then(|| draw.scale(1.0, 500.0) as u32);
        let script = Script {
            // A number of which one can be taken exactly.
            edge: (about, (draw.share() * 1.0e6).floor() as f32 / 1_048_576.0),
            told: (draw.share() * 3.0) as u32,
            hold: some(&mut draw, 0.2).map(|at| (at, at + draw.scale(1.0, 300.0) as u32)),
            cancel: some(&mut draw, 0.1),
            abort: some(&mut draw, 0.1),
            misses: if draw.chance(0.5) { 0.0 } else { 0.3 },
        };
        bench.stops = false;
        let outcome = one_probe(&mut bench, &probe, from, &script, &mut draw);
        seen[outcome as usize] += 1;
        bench.stays();
    }
    seen
}

/// Runs one probe, and checks it.
fn one_probe<S: Scalar>(
    bench: &mut Bench<'_, S>,
    probe: &Probe<S, AXES>,
    from: Point,
    script: &Script,
    draw: &mut Draw,
) -> Outcome {
    let inputs = bench.planner.inputs();
    let controls = bench.planner.controls();
    let by: [f64; AXES] = std::array::from_fn(|i| probe.to[i].minus(from[i]));
    let told = bench.planner.probe_overshoot(probe.feed, &by.map(S::of)).ok();
    let mut expected: Option<(Point, [f64; AXES], bool)> = None;
    let mut pressed = false;
    for cycle in 1..4_000_000u32 {
        if script.hold.is_some_and(|(at, _)| at == cycle) {
            bench.stops = true;
            controls.hold();
        }
        if script.hold.is_some_and(|(_, at)| at == cycle) {
            controls.resume();
        }
        if script.cancel == Some(cycle) {
            controls.cancel_jog();
        }
        if script.abort == Some(cycle) {
            controls.abort();
        }
        bench.stops |= script.edge.0 == cycle || script.cancel == Some(cycle);
        bench.stops |= script.abort == Some(cycle);
        pressed |= script.cancel.is_some_and(|at| at <= cycle)
            || script.abort.is_some_and(|at| at <= cycle);
        // The edge comes in the cycle of the last tick, or is told after the next.
        let mut tell = |bench: &Bench<'_, S>, late: bool| {
            if bench.planner.is_probing() {
                let part = f64::from(script.edge.1);
                let last = &bench.last;
                let place =
                    std::array::from_fn(|i| last.from.position(i).plus(last.offset(i, part)));
                let speed = last.from.velocity.map(S::to_f64);
                let even = last.from.acceleration == [S::ZERO; AXES]
                    && last.to.acceleration == [S::ZERO; AXES];
                expected.get_or_insert((place, speed, even));
            }
            inputs.tell(Input::Probe, probe.closes, script.edge.1 - if late { 1.0 } else { 0.0 });
        };
        let comes = script.edge.0 == cycle;
        if comes && script.told == 0 {
            tell(bench, false);
        }
        let progress =
            if draw.chance(script.misses) { Progress::Waiting } else { bench.planner.settle() };
        if comes && script.told == 1 {
            tell(bench, false);
        }
        if comes && script.told == 2 {
            // The setpoint of the next cycle is taken before the interrupt of the edge is.
            let before = bench.last;
            bench.tick();
            let now = core::mem::replace(&mut bench.last, before);
            tell(bench, true);
            bench.last = now;
        } else {
            bench.tick();
        }
        // It bounces.
        if script.edge.0 < cycle && cycle < script.edge.0 + 20 {
            inputs.tell(Input::Probe, draw.chance(0.5), draw.share() as f32);
        }
        if progress == Progress::Aborted {
            assert!(bench.planner.acknowledge_abort());
        }
        if let Some(probed) = bench.planner.probed() {
            assert!(!bench.planner.is_probing());
            controls.resume();
            let way = bench.config.limits.axes().iter().map(|axis| axis.velocity.to_f64());
            let way = way.fold(0.0, f64::max) * bench.last.cycle;
            let slack = off_most::<S>(way) * 4.0;
            let here = bench.here();
            assert_eq!(bench.last.to.activity, Activity::Idle);
            let (beside, along) = on_line(&here, &from, &probe.to);
            assert!(beside < slack, "{beside} mm beside the line: {script:?}");
            match (probed.outcome, expected) {
                (Outcome::Tripped, Some((place, speed, even))) => {
                    for i in 0..AXES {
                        let off: f64 = probed.position[i].minus(place[i]);
                        assert!(off.abs() < slack, "{off} mm off on axis {i}: {script:?}");
                    }
                    let (_, edge) = on_line(&place, &from, &probe.to);
                    assert!(along >= edge - slack, "{along} before {edge}: {script:?}");
                    if let (Some(told), true) = (told, script.misses == 0.0) {
                        // Nothing is planned while the edge waits to be told.
                        let late = if script.told == 2 { bench.last.cycle } else { 0.0 };
                        let late = late * speed.iter().map(|v| v * v).sum::<f64>().sqrt() * 1.1;
                        let over = along - edge - late;
                        let most = if even { told.at_feed } else { told.most }.to_f64();
                        assert!(over < most * 1.000_01 + slack, "{over} of {told:?}: {script:?}");
                    }
                }
                (Outcome::Missed, None) => assert_eq!(here, probe.to),
                (Outcome::Cancelled, None) => assert!(pressed),
                other => panic!("{other:?}: {script:?}"),
            }
            while bench.planner.settle() == Progress::Aborted {
                assert!(bench.planner.acknowledge_abort());
            }
            return probed.outcome;
        }
    }
    panic!("the probe does not end: {script:?}");
}

proptest! {
    #![proptest_config(cases::config(100))]

    #[test]
    fn random_probes_keep_every_limit(seed in any::<u64>()) {
        random_probes::<f64>(seed);
    }

    #[test]
    fn random_probes_keep_every_limit_in_f32(seed in any::<u64>()) {
        random_probes::<f32>(seed);
    }
}

/// All ends are met.
#[test]
fn random_probes_end_in_every_way() {
    let mut all = [0; 3];
    for seed in 1..60u64 {
        let seen = random_probes::<f64>(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        for (all, seen) in all.iter_mut().zip(seen) {
            *all += seen;
        }
    }
    assert!(all.iter().all(|seen| *seen > 10), "{all:?}");
}

fn usual() -> Config<f64, AXES> {
    let axis = AxisLimits::linear(100.0, 1000.0, 2.0e4);
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.start_delay = 0.0;
    config
}

fn down(to: f64, feed: f64) -> Probe<f64, AXES> {
    Probe { to: [at(0.0), at(0.0), at(to)], feed, input: Input::Probe, closes: true }
}

impl Bench<'_, f64> {
    /// Until the probe is over, with an edge at a height on the way down, told in its cycle.
    fn probe_down(&mut self, height: f64) -> splineway::Probed<AXES> {
        for _ in 0..200_000 {
            let (from, to) = (self.last.from.position_mm(2), self.last.to.position_mm(2));
            if from > height && to <= height {
                // By halvings: the motion is monotone.
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if from + self.last.offset(2, middle) > height {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                self.planner.inputs().tell(Input::Probe, true, high as f32);
            }
            self.planner.settle();
            self.tick();
            if let Some(probed) = self.planner.probed() {
                return probed;
            }
        }
        panic!("the probe does not end");
    }

    fn run(&mut self, cycles: usize) -> Progress {
        let mut progress = Progress::Waiting;
        for _ in 0..cycles {
            progress = self.planner.settle();
            self.tick();
        }
        progress
    }
}

/// A surface at 10.25 mm below: found to a nanometre and less; the stop within 2 per cent of the shortest from the cycle of the edge on.
#[test]
fn a_surface_is_found() {
    for feed in [1.0, 5.0, 20.0, 100.0] {
        let mut link = Link::new();
        let mut bench = Bench::<f64>::new(&mut link, usual());
        bench.planner.probe(&down(-20.0, feed)).unwrap();
        let told = bench.planner.probe_overshoot(feed, &[0.0, 0.0, -1.0]).unwrap();
        let probed = bench.probe_down(-10.25);
        assert_eq!(probed.outcome, Outcome::Tripped);
        // The fraction is an `f32`, of a cycle of 0.1 mm at most.
        assert!((probed.position[2].to_mm() + 10.25).abs() < 1.0e-8, "{probed:?}");
        let over = -10.25 - bench.here()[2].to_mm();
        // By 20,000 mm/s3, and 1,000 mm/s2 at the most.
        let ramp = (feed / 2.0e4f64).sqrt().min(0.05);
        let shortest = feed * (ramp + (feed / (2.0e4 * ramp))) * 0.5;
        assert!(over > shortest && over < shortest * 1.02 + feed * 1.0e-3, "{over} {shortest}");
        assert!(over < told.at_feed && told.at_feed < shortest * 1.02 + 2.0e-3 * feed, "{told:?}");
        assert!(told.most >= told.at_feed);
        bench.stays();
    }
}

#[test]
fn it_is_taken_from_rest_with_nothing_else_to_do() {
    let mut config = usual();
    let room = AxisTravel { least: Some(at(-50.0)), greatest: Some(at(50.0)) };
    config.travel = Travel::new([room; AXES]).unwrap();
    let mut link = Link::new();
    let mut bench = Bench::<f64>::new(&mut link, config);
    let refused = |bench: &mut Bench<'_, f64>| bench.planner.probe(&down(-20.0, 5.0)).unwrap_err();
    let controls = bench.planner.controls();
    controls.hold();
    assert_eq!(refused(&mut bench), ProbeError::Held);
    controls.resume();
    controls.feed_override(0);
    assert_eq!(refused(&mut bench), ProbeError::Held);
    controls.feed_override(100);
    controls.abort();
    assert_eq!(refused(&mut bench), ProbeError::Aborted);
    bench.run(3);
    assert!(bench.planner.acknowledge_abort());
    let out = bench.planner.probe(&down(-50.1, 5.0)).unwrap_err();
    assert!(matches!(out, ProbeError::Travel { axis: 2, .. }), "{out}");
    for feed in [0.0, f64::NAN, 1.0e-8] {
        let out = bench.planner.probe(&down(-20.0, feed)).unwrap_err();
        assert!(matches!(out, ProbeError::OutOfRange { .. }), "{out}");
    }
    let none = Probe { input: Input::Home(9), ..down(-20.0, 5.0) };
    assert_eq!(bench.planner.probe(&none), Err(ProbeError::Input));
    assert!(bench.planner.probe_overshoot(5.0, &[0.0; AXES]).is_err());
    // A jog, a program, and the end of it.
    bench.planner.jog(&Jog::Velocity { velocity: [10.0; AXES], time: 0.1 }).unwrap();
    assert_eq!(refused(&mut bench), ProbeError::Running);
    bench.run(1000);
    bench.planner.push(&Block::line([at(0.0); AXES], 20.0, 1)).unwrap();
    assert_eq!(refused(&mut bench), ProbeError::Running);
    bench.planner.finish();
    bench.run(10);
    assert_eq!(refused(&mut bench), ProbeError::Running);
    bench.run(1000);
    assert_eq!(bench.planner.probe(&down(-20.0, 5.0)), Ok(()));
    // And while it runs nothing else is.
    for _ in 0..2 {
        assert_eq!(refused(&mut bench), ProbeError::Running);
        let jog = bench.planner.jog(&Jog::Back { feed: 1.0 });
        assert_eq!(jog, Err(JogError::Running));
        let pushed = bench.planner.push(&Block::line([at(1.0); AXES], 20.0, 2));
        assert_eq!(pushed, Err(PushError::Full));
        bench.run(10);
    }
    assert_eq!(bench.probe_down(-0.5).outcome, Outcome::Tripped);
    // The next block begins where the machine rests.
    let here = bench.here();
    assert_eq!(*bench.planner.end(), here);
    bench.planner.push(&Block::line([here[0], here[1], at(3.0)], 20.0, 2)).unwrap();
    bench.planner.finish();
    bench.run(1000);
    assert_eq!(bench.here(), [here[0], here[1], at(3.0)]);
}

/// A hold is a rest on the way; what is asked for afterwards, and a cancel, end it.
#[test]
fn it_waits_while_it_is_held() {
    for touches in [false, true] {
        let mut link = Link::new();
        let mut bench = Bench::<f64>::new(&mut link, usual());
        let controls = bench.planner.controls();
        bench.planner.probe(&down(-20.0, 20.0)).unwrap();
        bench.run(300);
        controls.hold();
        assert_eq!(bench.run(300), Progress::Held);
        assert!(bench.planner.is_probing() && bench.here()[2] < at(-5.0));
        if touches {
            // By hand: where it stands.
            bench.planner.inputs().tell(Input::Probe, true, 0.5);
            bench.run(5);
            let probed = bench.planner.probed().unwrap();
            assert_eq!(probed.outcome, Outcome::Tripped);
            assert_eq!(probed.position, bench.here());
        } else {
            controls.resume();
            assert_eq!(bench.probe_down(-15.0).outcome, Outcome::Tripped);
            assert!(bench.here()[2] < at(-15.0));
        }
        assert_eq!(bench.planner.probed(), None);
    }
    let mut link = Link::new();
    let mut bench = Bench::<f64>::new(&mut link, usual());
    bench.planner.controls().single_block(true);
    bench.planner.probe(&down(-20.0, 20.0)).unwrap();
    bench.run(100);
    bench.planner.controls().cancel_jog();
    let mut progress = bench.run(300);
    assert_eq!(bench.planner.probed().unwrap().outcome, Outcome::Cancelled);
    // In single block mode the machine waits behind it.
    assert_eq!(progress, Progress::Held);
    bench.planner.push(&Block::line([at(0.0); AXES], 20.0, 1)).unwrap();
    let here = bench.here();
    bench.run(100);
    assert_eq!(bench.here(), here);
    bench.planner.controls().resume();
    bench.planner.finish();
    progress = bench.run(1000);
    assert_eq!((progress, bench.here()), (Progress::Held, [at(0.0); AXES]));
}

/// A surface at 6.25 mm, and switches, as files of events have them: found, and every cycle judged.
#[test]
fn files_of_events_probe_and_home() {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    for (events, lines) in [
        (
            "probe.csv",
            ["probe: tripped at X6.2500", "probe: tripped at X6.2500", "probe: tripped at X6.2500"],
        ),
        ("home.csv", ["home: stands at X2.000000 Y2.000000", "", ""]),
    ] {
        for scalar in ["f32", "f64"] {
            let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_splineway"));
            command.arg("simulate").arg(data.join("square.ngc")).args(["--scalar", scalar]);
            let run = command.arg("--events").arg(data.join(events)).output().unwrap();
            let text = String::from_utf8_lossy(&run.stdout);
            let errors = String::from_utf8_lossy(&run.stderr);
            assert!(run.status.success(), "{text}{errors}");
            let mut told =
                text.lines().filter(|line| line.starts_with("probe:") || line.starts_with("home:"));
            for line in lines.iter().filter(|line| !line.is_empty()) {
                let said = told.next().unwrap_or_default();
                assert!(said.starts_with(line), "{said}: {text}");
            }
            assert_eq!(told.next(), None);
        }
    }
}
