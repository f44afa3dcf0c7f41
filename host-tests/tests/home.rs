//! Homing: random machines with switches at random places, some of which never close or never open, and an operator at random times.

#[path = "common/cycles.rs"]
mod cycles;

use cycles::{AXES, Between, Draw, Point, at, cases, machine, off_most};
use proptest::prelude::*;
use splineway::{
    Activity, AxisHome, Block, Config, Coord, HomeFailure, HomeFault, HomePhase, Input,
    Interpolator, Link, Planner, ProbeError, Progress, Scalar,
};

/// What a switch is like.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Good,
    /// Never closes.
    Missing,
    /// Never opens.
    Stuck,
}

/// The switch of an axis: closed beyond a place, in the coordinates at the start.
#[derive(Clone, Copy, Debug)]
struct Switch {
    side: f64,
    edge: f64,
    kind: Kind,
}

impl Switch {
    fn is_closed(&self, place: f64) -> bool {
        match self.kind {
            Kind::Good => self.side * (place - self.edge) >= 0.0,
            Kind::Missing => false,
            Kind::Stuck => true,
        }
    }
}

/// A machine with its switches.
struct Bench<'a, S: Scalar> {
    planner: Planner<'a, S, AXES>,
    interpolator: Interpolator<'a, S, AXES>,
    config: Config<S, AXES>,
    last: Between<S>,
    switches: [Switch; AXES],
    /// Where the machine really is, less what setpoints say.
    shift: [f64; AXES],
    /// Whether something has asked for a stop.
    stops: bool,
    bounces: bool,
}

impl<'a, S: Scalar> Bench<'a, S> {
    fn new(
        link: &'a mut Link<S, AXES>,
        config: Config<S, AXES>,
        start: Point,
        switches: [Switch; AXES],
    ) -> Self {
        let (planner, mut interpolator) = link.split(config, start).unwrap();
        let from = interpolator.tick();
        let last = Between { from, to: from, cycle: config.cycle.to_f64() };
        let (shift, bounces) = ([0.0; AXES], true);
        for (axis, switch) in switches.iter().enumerate() {
            let closed = switch.is_closed(start[axis].to_mm());
            planner.inputs().tell(Input::Home(axis), closed, 0.0);
        }
        Self { planner, interpolator, config, last, switches, shift, stops: false, bounces }
    }

    /// A servo cycle, and the edges in it.
    fn tick(&mut self, draw: &mut Draw) {
        let now = self.interpolator.tick();
        let before = self.last.to;
        self.last = Between { from: before, to: now, ..self.last };
        if now.activity == Activity::Set {
            assert_eq!(before.activity, Activity::Idle);
            for i in 0..AXES {
                assert!(now.velocity[i] == S::ZERO && now.acceleration[i] == S::ZERO);
                self.shift[i] += before.position(i).minus::<f64>(now.position(i));
            }
            return;
        }
        self.last.check(&self.config, self.stops);
        for (i, switch) in self.switches.iter().enumerate() {
            let place =
                |part: f64| self.shift[i] + before.position_mm(i) + self.last.offset(i, part);
            let inputs = self.planner.inputs();
            // What the cycle before has told: its end is the beginning of this one but for rounding.
            let (was, is) = (inputs.is_closed(Input::Home(i)), switch.is_closed(place(1.0)));
            if was == is {
                continue;
            }
            self.stops = true;
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if switch.is_closed(place(middle)) == was { low = middle } else { high = middle }
            }
            inputs.tell(Input::Home(i), is, high as f32);
            for _ in 0..(if self.bounces { 4 } else { 0 }) {
                inputs.tell(Input::Home(i), draw.chance(0.5), draw.share() as f32);
            }
            inputs.tell(Input::Home(i), is, 1.0);
        }
    }

    fn here(&self) -> Point {
        std::array::from_fn(|i| self.last.to.position(i))
    }
}

/// Random homings of one machine. How it ended.
fn random_homing<S: Scalar>(seed: u64) -> Result<(), HomeFailure> {
    let mut draw = Draw(seed | 1);
    let config = machine::<S>(&mut draw);
    let start: Point = [(); AXES].map(|()| at(draw.between(-50.0, 50.0)));
    let operated = draw.chance(0.5);
    let homes: [Option<AxisHome<S>>; AXES] = std::array::from_fn(|i| {
        let velocity = config.limits.axes()[i].velocity.to_f64();
        let side = if draw.chance(0.5) { 1.0 } else { -1.0 };
        let fast = velocity * draw.scale(0.05, 1.0);
        let reach = fast * draw.scale(0.05, 2.0);
        draw.chance(0.8).then(|| AxisHome {
            fast: S::of(side * fast),
            slow: S::of(fast * draw.scale(0.05, 0.5)),
            reach: at(reach),
            back: at(fast * draw.scale(0.02, 0.3)),
            at: at(draw.between(-500.0, 500.0)),
            park: draw.chance(0.5).then(|| at(draw.between(-500.0, 500.0))),
            order: (draw.share() * 3.0) as u8,
        })
    });
    // Parking is somewhere near.
    let homes = homes.map(|home| {
        home.map(|home| AxisHome {
            park: home.park.map(|_| home.at.plus(draw.between(-0.5, 0.5) * home.fast.to_f64())),
            ..home
        })
    });
    let switches = std::array::from_fn(|i| {
        let side = homes[i].map_or(1.0, |home| home.fast.to_f64().signum());
        let (reach, back) =
            homes[i].map_or((1.0, 1.0), |home| (home.reach.to_mm(), home.back.to_mm()));
        let kind = match (draw.share() * 20.0) as u32 {
            0 => Kind::Missing,
            1 => Kind::Stuck,
            _ => Kind::Good,
        };
        // The machine may stand on it.
        let way =
            if draw.chance(0.2) { -0.9 * back * draw.share() } else { reach * 0.95 * draw.share() };
        Switch { side, edge: start[i].to_mm() + side * way, kind }
    });
    let mut link: Link<S, AXES> = Link::new();
    let mut bench = Bench::new(&mut link, config, start, switches);
    match bench.planner.home(&homes) {
        Ok(()) => {}
        Err(ProbeError::OutOfRange { .. }) => return Ok(()),
        Err(error) => panic!("{error}"),
    }
    let controls = bench.planner.controls();
    let mut held = false;
    let cancel = (operated && draw.chance(0.3)).then(|| draw.scale(1.0, 5000.0) as u32);
    let misses = if draw.chance(0.5) { 0.0 } else { 0.2 };
    for cycle in 0..3_000_000 {
        if operated && draw.chance(0.005) {
            held = !held;
            bench.stops = true;
            if held { controls.hold() } else { controls.resume() }
        }
        if cancel == Some(cycle) {
            bench.stops = true;
            if draw.chance(0.5) { controls.cancel_jog() } else { controls.abort() }
        }
        if !draw.chance(misses) && bench.planner.settle() == Progress::Aborted {
            bench.planner.acknowledge_abort();
        }
        // An axis that fails stops the others.
        bench.stops = true;
        bench.tick(&mut draw);
        let Some(result) = bench.planner.homed() else { continue };
        check_homed(&mut bench, &homes, start, result, cancel.is_some(), &mut draw);
        return result;
    }
    panic!(
        "homing does not end: {homes:?} {switches:?} {:?}",
        [0, 1, 2].map(|i| bench.planner.home_phase(i))
    );
}

/// What holds in the end.
fn check_homed<S: Scalar>(
    bench: &mut Bench<'_, S>,
    homes: &[Option<AxisHome<S>>; AXES],
    start: Point,
    result: Result<(), HomeFailure>,
    cancelled: bool,
    draw: &mut Draw,
) {
    bench.planner.controls().resume();
    let here = bench.here();
    for _ in 0..20 {
        if bench.planner.settle() == Progress::Aborted {
            bench.planner.acknowledge_abort();
        }
        bench.tick(draw);
        assert_eq!((bench.last.to.activity, bench.here()), (Activity::Idle, here));
    }
    assert_eq!(*bench.planner.end(), here);
    let way = bench.config.limits.axes().iter().map(|axis| axis.velocity.to_f64());
    let slack = off_most::<S>(way.fold(0.0, f64::max) * bench.last.cycle) * 4.0 + 1.0e-9;
    for i in 0..AXES {
        let (switch, shift) = (bench.switches[i], bench.shift[i]);
        match (homes[i], result) {
            (Some(home), Ok(())) => {
                assert_eq!(switch.kind, Kind::Good);
                // The switch has the coordinate it was given.
                let off = switch.edge - shift - home.at.to_mm();
                assert!(
                    off.abs() < slack + 1.0e-7 * home.slow.to_f64().abs() * bench.last.cycle,
                    "{off}"
                );
                if let Some(park) = home.park {
                    assert_eq!(here[i], park);
                }
            }
            (None, Ok(())) => assert_eq!(here[i], start[i]),
            (_, Err(_)) => assert!(shift == 0.0),
        }
    }
    let Err(HomeFailure { axis, phase, fault }) = result else { return };
    let kind = bench.switches[axis].kind;
    match (phase, fault) {
        (_, HomeFault::Cancelled) => assert!(cancelled),
        (HomePhase::Seeks, HomeFault::Missing) => {
            assert_eq!(kind, Kind::Missing);
            // At the bound, exactly.
            let home = homes[axis].unwrap();
            assert!(!bench.switches[axis].is_closed(start[axis].to_mm()));
            let way = here[axis].raw() - start[axis].raw();
            assert_eq!(way.abs(), home.reach.raw());
            assert_eq!(way > 0, home.fast > S::ZERO);
        }
        (HomePhase::Leaves, HomeFault::Stuck) => assert_eq!(kind, Kind::Stuck),
        // The way back may be shorter than what the axis has gone beyond.
        other => panic!("{other:?} {kind:?}"),
    }
}

proptest! {
    #![proptest_config(cases::config(150))]

    #[test]
    fn random_homings(seed in any::<u64>()) {
        let _ = random_homing::<f64>(seed);
    }

    #[test]
    fn random_homings_in_f32(seed in any::<u64>()) {
        let _ = random_homing::<f32>(seed);
    }
}

/// Where pieces are few they are long, 65 mm here, and places far from where their piece begins are rounded to 4 nm and more.
#[test]
fn long_pieces_in_f32_are_rounded_by_no_more_than_their_length_asks_for() {
    let fault = random_homing::<f32>(16_935_004_806_110_416_258).unwrap_err();
    assert_eq!((fault.axis, fault.fault), (0, HomeFault::Missing));
}

/// All ends are met.
#[test]
fn random_homings_end_in_every_way() {
    let mut seen = [0; 4];
    for seed in 1..300u64 {
        let end = match random_homing::<f64>(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15)) {
            Ok(()) => 0,
            Err(HomeFailure { fault: HomeFault::Missing, .. }) => 1,
            Err(HomeFailure { fault: HomeFault::Stuck, .. }) => 2,
            Err(_) => 3,
        };
        seen[end] += 1;
    }
    assert!(seen.iter().all(|seen| *seen >= 5) && seen[0] > 100, "{seen:?}");
}

/// A program begins in the new coordinates.
#[test]
fn a_program_runs_in_the_new_coordinates() {
    let axis = splineway::AxisLimits::linear(100.0, 1000.0, 2.0e4);
    let config = Config::<f64, AXES>::new(splineway::Limits::new([axis; AXES]).unwrap());
    let mut draw = Draw(5);
    let switches = [Switch { side: -1.0, edge: -1.0e3, kind: Kind::Missing }; AXES];
    let mut link = Link::new();
    let mut bench = Bench::<f64>::new(&mut link, config, [at(0.0); AXES], switches);
    let to = [at(7.0), at(-2.5), Coord::from_raw(3)];
    bench.planner.set_position(&to).unwrap();
    assert_eq!(bench.planner.set_position(&to), Err(ProbeError::Running));
    for _ in 0..10 {
        bench.planner.settle();
        bench.tick(&mut draw);
    }
    assert_eq!(bench.planner.homed(), Some(Ok(())));
    assert_eq!((bench.here(), *bench.planner.end()), (to, to));
    bench.stops = false;
    bench.planner.push(&Block::line([at(8.0), to[1], to[2]], 50.0, 1)).unwrap();
    bench.planner.finish();
    let mut most = 0.0f64;
    for _ in 0..1000 {
        bench.planner.settle();
        bench.tick(&mut draw);
        most = most.max(bench.here()[0].to_mm());
    }
    assert_eq!(bench.here()[0], at(8.0));
    assert!(most < 8.000_001);
}

/// A cancel or an abort that comes when the coordinates are about to change, or have changed: what is told is what has been done.
#[test]
fn what_is_told_of_a_change_of_coordinates_is_what_has_been_done() {
    let axis = splineway::AxisLimits::linear(100.0, 1000.0, 2.0e4);
    let config = Config::<f64, AXES>::new(splineway::Limits::new([axis; AXES]).unwrap());
    let switches = [Switch { side: -1.0, edge: -1.0e3, kind: Kind::Missing }; AXES];
    let to = [at(7.0), at(-2.5), Coord::from_raw(3)];
    let mut seen = [0; 2];
    for (moment, aborts, late) in
        (0..12).flat_map(|moment| (0..4).map(move |k| (moment, k & 1 > 0, k & 2 > 0)))
    {
        let mut draw = Draw(5);
        let mut link = Link::new();
        let mut bench = Bench::<f64>::new(&mut link, config, [at(0.0); AXES], switches);
        bench.planner.set_position(&to).unwrap();
        let controls = bench.planner.controls();
        let mut told = None;
        for cycle in 0..30 {
            if cycle == moment {
                if aborts { controls.abort() } else { controls.cancel_jog() }
            }
            // The planner may hear of the change and of the cancel at once.
            if !late || !(2..=moment).contains(&cycle) {
                if bench.planner.settle() == Progress::Aborted {
                    bench.planner.acknowledge_abort();
                }
                told = told.or(bench.planner.homed());
            }
            bench.tick(&mut draw);
        }
        let changed = bench.here() == to;
        assert_eq!(told.map(|told| told.is_ok()), Some(changed), "{moment} {aborts} {late}");
        assert_eq!(*bench.planner.end(), bench.here());
        seen[usize::from(changed)] += 1;
    }
    assert!(seen.iter().all(|seen| *seen > 2), "{seen:?}");
}
