//! Arcs as programs have them: of three decimals, tiny, nearly full, of many turns, helical, in every plane.
//! Every setpoint is held against the arc as it is programmed - a spiral where its ends do not fit - and
//! against the limits by its own derivatives; the end must be exact, and nothing may crawl.

mod common;

use common::config;
use proptest::prelude::*;
use splineway::block::{BlockError, FINEST_BAND};
use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Feed, Limits, Link, Motion, Progress, PushError,
    Scalar, Turn,
};
use std::f64::consts::TAU;

type Point = [f64; 3];

/// An arc as it is programmed.
#[derive(Clone, Debug)]
struct Arc {
    start: Point,
    end: Point,
    plane: (usize, usize),
    centre: (f64, f64),
    clockwise: bool,
    turns: u16,
}

/// The same by its share of the way: the definition, once more and apart from the core's.
#[derive(Clone, Debug)]
struct Curve {
    arc: Arc,
    radii: (f64, f64),
    from: f64,
    angle: f64,
    /// mm.
    length: f64,
}

impl Curve {
    fn new(arc: &Arc) -> Self {
        let (p, q) = arc.plane;
        let (cx, cy) = arc.centre;
        let (a, b) = ((arc.start[p] - cx, arc.start[q] - cy), (arc.end[p] - cx, arc.end[q] - cy));
        let from = a.1.atan2(a.0);
        let sign = if arc.clockwise { -1.0 } else { 1.0 };
        let apart = sign * (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1);
        let equal = (a.0 - b.0).hypot(a.1 - b.1) < 1.5e-6;
        let sweep = if equal || apart <= 0.0 { apart + TAU } else { apart };
        let angle = sign * (sweep + TAU * f64::from(arc.turns));
        let radii = (a.0.hypot(a.1), b.0.hypot(b.1));
        let mut curve = Self { arc: arc.clone(), radii, from, angle, length: 0.0 };
        curve.length = curve.sum_up();
        curve
    }

    fn at(&self, u: f64) -> Point {
        let Arc { start, end, plane, centre, .. } = &self.arc;
        let mut at: Point = std::array::from_fn(|i| start[i] + (end[i] - start[i]) * u);
        let radius = self.radii.0 + (self.radii.1 - self.radii.0) * u;
        let phi = self.from + self.angle * u;
        (at[plane.0], at[plane.1]) = (centre.0 + radius * phi.cos(), centre.1 + radius * phi.sin());
        at
    }

    fn sum_up(&self) -> f64 {
        let n = 500 * (1 + usize::from(self.arc.turns));
        let point = |k: usize| self.at(k as f64 / n as f64);
        (0..n).map(|k| distance(&point(k), &point(k + 1))).sum()
    }

    /// Distance of a point from the curve: the place at its angle, on the turn that a share of the way is in
    /// and its neighbours, and a little on from there.
    fn distance(&self, x: &Point, near: f64) -> f64 {
        let (p, q) = self.arc.plane;
        let phi = (x[q] - self.arc.centre.1).atan2(x[p] - self.arc.centre.0);
        let first = ((phi - self.from) * self.angle.signum()).rem_euclid(TAU);
        let whole = self.angle.abs();
        let mut best = distance(x, &self.at(0.0)).min(distance(x, &self.at(1.0)));
        let turn = ((near * whole - first) / TAU).round().clamp(0.0, f64::from(self.arc.turns));
        for turn in [turn - 1.0, turn, turn + 1.0] {
            let mut u = ((first + TAU * turn) / whole).clamp(0.0, 1.0);
            for _ in 0..2 {
                let (here, step) = (self.at(u), 1e-4 / whole);
                let next = self.at(u + step);
                let (mut along, mut square) = (0.0, 0.0);
                for i in 0..3 {
                    let d = (next[i] - here[i]) / step;
                    along += (x[i] - here[i]) * d;
                    square += d * d;
                }
                u = (u + along / square).clamp(0.0, 1.0);
                best = best.min(distance(x, &self.at(u)));
            }
        }
        best
    }
}

fn distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// What a program is made of.
#[derive(Clone, Debug)]
enum Step {
    Line(Point, Point),
    Arc(Curve),
}

impl Step {
    /// `way`: how far it has been followed, mm.
    fn distance(&self, x: &Point, way: f64) -> f64 {
        match self {
            Self::Line(a, b) => {
                let square: f64 = a.iter().zip(b).map(|(a, b)| (b - a) * (b - a)).sum();
                let along: f64 = (0..3).map(|i| (x[i] - a[i]) * (b[i] - a[i])).sum();
                let t = (along / square.max(1e-30)).clamp(0.0, 1.0);
                distance(x, &std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t))
            }
            Self::Arc(curve) => curve.distance(x, way / curve.length),
        }
    }

    fn end(&self) -> &Point {
        match self {
            Self::Line(_, end) => end,
            Self::Arc(curve) => &curve.arc.end,
        }
    }
}

/// Velocity, acceleration and jerk of each axis.
type Machine = [[f64; 3]; 3];

const ORDINARY: Machine = [[200.0, 2000.0, 5.0e4]; 3];

/// Holds of a run at most.
const HOLDS: u64 = 12;

/// How a program is run.
#[derive(Clone, Debug)]
struct Setup {
    machine: Machine,
    tolerance: f64,
    feed: f64,
    cycle: f64,
    /// Hold after this many cycles, some times, and resume after half as many.
    hold: Option<u64>,
}

impl Setup {
    fn new(tolerance: f64, feed: f64) -> Self {
        Self { machine: ORDINARY, tolerance, feed, cycle: 1.0e-3, hold: None }
    }
}

/// What a run came to.
#[derive(Debug, Default)]
struct Outcome {
    time: f64,
    /// Greatest distance from the program, mm.
    off: f64,
    /// Velocity, acceleration and jerk over their limits.
    peaks: [f64; 3],
    /// Nanometres by which the end is missed.
    missed: i64,
    way: f64,
}

fn coords(point: &Point) -> [Coord; 3] {
    point.map(|x| Coord::from_mm(x).unwrap())
}

/// Servo cycles without a motion, longer than any hold, after which none is expected: arcs of many turns last for minutes.
const STILL: u64 = 20_000;

fn run<S: Scalar>(start: &Point, steps: &[Step], setup: &Setup) -> Result<Outcome, BlockError> {
    let limits = setup.machine.map(|[velocity, acceleration, jerk]| {
        AxisLimits::linear(S::of(velocity), S::of(acceleration), S::of(jerk))
    });
    let mut config = Config::new(Limits::new(limits).unwrap());
    config.tolerance = S::of(setup.tolerance);
    config.cycle = S::of(setup.cycle);
    let mut link = Box::new(Link::<S, 3, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, coords(start)).unwrap();
    let feed = Feed::PerSecond(S::of(setup.feed));
    for (n, step) in steps.iter().enumerate() {
        let motion = match step {
            Step::Line(_, to) => Motion::Line { to: coords(to) },
            Step::Arc(Curve { arc, .. }) => Motion::Arc {
                to: coords(&arc.end),
                plane: arc.plane,
                centre: (
                    Coord::from_mm(arc.centre.0).unwrap(),
                    Coord::from_mm(arc.centre.1).unwrap(),
                ),
                turn: if arc.clockwise { Turn::Clockwise } else { Turn::CounterClockwise },
                extra_turns: arc.turns,
            },
        };
        let block = Block { motion, feed, tolerance: None, exact_stop: false, tag: n as u32 };
        match planner.push(&block) {
            Ok(()) => {}
            Err(PushError::Rejected { reason, .. }) => return Err(reason),
            Err(other) => panic!("{other}"),
        }
    }
    planner.finish();
    let controls = planner.controls();
    let mut outcome = Outcome::default();
    let (mut cycles, mut moved, mut before) = (0u64, 0, [S::ZERO; 3]);
    loop {
        if let Some(every) = setup.hold.filter(|every| cycles <= HOLDS * every + every / 2) {
            match cycles % every {
                k if k == every - 1 => controls.hold(),
                k if k == every / 2 => controls.resume(),
                _ => {}
            }
        }
        let progress = planner.settle();
        let here = interpolator.tick();
        cycles += 1;
        let x: Point = std::array::from_fn(|i| here.position_mm(i));
        let near = (here.tag as usize).saturating_sub(1)..(here.tag as usize + 2).min(steps.len());
        // An arc of many turns is the first step, or follows a line.
        let lead = steps.iter().take(1).filter_map(|step| match step {
            Step::Line(a, b) => Some(distance(a, b)),
            Step::Arc(_) => None,
        });
        let way = here.path_mm() - lead.sum::<f64>();
        let off = steps[near].iter().map(|step| step.distance(&x, way));
        let off = off.fold(f64::INFINITY, f64::min);
        outcome.off = outcome.off.max(off);
        for i in 0..3 {
            let jerk = (here.acceleration[i] - before[i]).to_f64() / setup.cycle;
            let values = [here.velocity[i].to_f64(), here.acceleration[i].to_f64(), jerk];
            for ((peak, value), limit) in outcome.peaks.iter_mut().zip(values).zip(setup.machine[i])
            {
                *peak = peak.max(value.abs() / limit);
            }
        }
        before = here.acceleration;
        if here.path_mm() > outcome.way {
            moved = cycles;
        }
        outcome.way = here.path_mm();
        if progress == Progress::Done && here.activity == Activity::Idle {
            let end = steps.last().map_or(start, Step::end);
            for i in 0..3 {
                let wanted = Coord::from_mm(end[i]).unwrap().to_nm();
                outcome.missed = outcome.missed.max((here.position_nm(i) - wanted).abs());
            }
            break;
        }
        assert!(cycles < moved + STILL, "no end: {progress:?} at {x:?}");
    }
    outcome.time = cycles as f64 * setup.cycle;
    Ok(outcome)
}

/// Both scalars; what is broken. `slack` is for the band, by the rounding of positions.
fn check(start: &Point, steps: &[Step], setup: &Setup) -> Result<[Outcome; 2], String> {
    let refused = |e: BlockError| format!("refused: {e}");
    let outcomes = [
        run::<f64>(start, steps, setup).map_err(refused)?,
        run::<f32>(start, steps, setup).map_err(refused)?,
    ];
    for (outcome, single) in outcomes.iter().zip([false, true]) {
        let band = setup.tolerance.max(FINEST_BAND) + if single { 1.0e-5 } else { 1.0e-9 };
        let [v, a, j] = outcome.peaks;
        let limits = if single { [1.001, 1.002, 1.01] } else { [1.0 + 1e-9, 1.0 + 1e-6, 1.001] };
        let within = v <= limits[0] && a <= limits[1] && j <= limits[2];
        if outcome.off > band || !within || outcome.missed != 0 {
            return Err(format!("f32 {single}: {outcome:?}"));
        }
    }
    Ok(outcomes)
}

/// Speed that an arc of a radius allows, mm/s.
fn speed(radius: f64, setup: &Setup) -> f64 {
    let least = |k: usize| setup.machine.iter().map(|axis| axis[k]).fold(f64::INFINITY, f64::min);
    let (v, a, j) = (least(0), least(1), least(2));
    setup.feed.min(v).min((a * radius).sqrt()).min((j * radius * radius).cbrt())
}

/// Longest time that a lone arc may take, s: at its speed, with starts and stops, and by `share` more.
fn patience(curve: &Curve, setup: &Setup, share: f64) -> f64 {
    let v = speed(curve.radii.0.min(curve.radii.1), setup);
    let [_, a, j] =
        [0, 1, 2].map(|k| setup.machine.iter().map(|axis| axis[k]).fold(f64::INFINITY, f64::min));
    share * curve.length / v + 3.0 * (v / a + a / j) + 0.02
}

fn round(x: f64) -> f64 {
    (x * 1000.0).round() / 1000.0
}

/// An arc with a radius, from an angle, over another, as a program of three decimals writes it: ends
/// absolute, the centre from the start.
fn written(
    radius: f64,
    (from, sweep): (f64, f64),
    plane: (usize, usize),
    turns: u16,
    climb: f64,
) -> Arc {
    let other = 3 - plane.0 - plane.1;
    let true_centre = (3.217_3, -1.884_1);
    let put = |angle: f64, height: f64| {
        let mut at = [0.0; 3];
        at[plane.0] = round(true_centre.0 + radius * angle.cos());
        at[plane.1] = round(true_centre.1 + radius * angle.sin());
        at[other] = round(height);
        at
    };
    let (start, end) = (put(from, 0.5), put(from + sweep, 0.5 + climb));
    let (i, j) = (round(-radius * from.cos()), round(-radius * from.sin()));
    let centre = (start[plane.0] + i, start[plane.1] + j);
    Arc { start, end, plane, centre, clockwise: sweep < 0.0, turns }
}

/// Whether an arc must be refused: the rule of `Motion::Arc`.
fn is_refused(curve: &Curve) -> bool {
    let (r0, r1) = curve.radii;
    let gap = (r0 - r1).abs();
    let Arc { start, end, plane: (p, q), centre, .. } = &curve.arc;
    let (a, b) =
        ((start[*p] - centre.0, start[*q] - centre.1), (end[*p] - centre.0, end[*q] - centre.1));
    let apart = (a.0 * b.1 - a.1 * b.0).atan2(a.0 * b.0 + a.1 * b.1).abs() * r0.min(r1);
    let equal = (a.0 - b.0).hypot(a.1 - b.1) < 1.5e-6;
    let tiny = r0.min(r1) <= 1.5e-6;
    tiny || gap > 0.5 || (gap > 0.005 && gap > 1e-3 * r0) || (!equal && apart <= 0.1 * gap)
}

const PLANES: [(usize, usize); 3] = [(0, 1), (2, 0), (1, 2)];
const TOLERANCES: [f64; 6] = [0.0, 1.0e-4, 1.0e-3, 1.0e-2, 0.1, 1.0];

/// Angles: any, tiny, nearly full on either side.
fn sweeps() -> impl Strategy<Value = f64> {
    let small = (-4.5f64..-0.5).prop_map(|e| 10f64.powf(e));
    prop_oneof![0.01..TAU, small.clone(), small.prop_map(|small| TAU - small), Just(TAU),]
}

fn arcs(sizes: std::ops::Range<f64>) -> impl Strategy<Value = Arc> {
    let turns = prop_oneof![3 => Just(0u16), 1 => 1u16..40];
    let climb = prop_oneof![1 => Just(0.0), 2 => -20.0f64..20.0];
    (sizes.prop_map(|e| 10f64.powf(e)), 0.0..TAU, sweeps(), any::<bool>(), 0usize..3, turns, climb)
        .prop_map(|(radius, from, sweep, clockwise, plane, turns, climb)| {
            let sweep = if clockwise { -sweep } else { sweep };
            written(radius, (from, sweep), PLANES[plane], turns, climb)
        })
}

fn machines() -> impl Strategy<Value = Machine> {
    let axis = || {
        ((0.0f64..1.5), (-0.7f64..0.7), (-0.7f64..0.7)).prop_map(|(v, a, j)| {
            let velocity = 400.0 * 10f64.powf(-v);
            let acceleration = velocity * 10.0 * 10f64.powf(a);
            [velocity, acceleration, acceleration * 25.0 * 10f64.powf(j)]
        })
    };
    prop_oneof![Just(ORDINARY), [axis(), axis(), axis()]]
}

/// A feed at which a curve does not take much of the test's time.
fn feed(curve: &Curve, feed: f64) -> f64 {
    feed.max(curve.length / 0.8)
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn lone_arcs(
        arc in arcs(-2.0..2.3),
        tolerance in 0usize..6,
        fast in (0.5f64..3.0).prop_map(|e| 10f64.powf(e)),
        machine in machines(),
        hold in prop_oneof![4 => Just(None), 1 => (40u64..400).prop_map(Some)],
    ) {
        let curve = Curve::new(&arc);
        let mut setup = Setup::new(TOLERANCES[tolerance], feed(&curve, fast));
        setup.machine = machine;
        // Slow axes and long ways would only take the test's time.
        prop_assume!(patience(&curve, &setup, 1.0) < 20.0);
        let steps = [Step::Arc(curve.clone())];
        if is_refused(&curve) {
            let reason = run::<f64>(&arc.start, &steps, &setup).unwrap_err();
            let named = matches!(
                reason,
                BlockError::ArcRadius { .. } | BlockError::ArcUnreachable { .. }
            );
            prop_assert!(named, "{reason}");
            return Ok(());
        }
        let outcomes = check(&arc.start, &steps, &setup);
        prop_assert!(outcomes.is_ok(), "{setup:?}: {}", outcomes.unwrap_err());
        let share = if setup.tolerance < 1.0e-3 { 2.0 } else { 1.3 };
        for outcome in outcomes.unwrap() {
            let most = patience(&curve, &setup, share);
            prop_assert!(outcome.time <= most, "{} s, at most {most}", outcome.time);
            prop_assert!((outcome.way - curve.length).abs() < 1e-4 * curve.length + 1e-6);
        }
        setup.hold = hold;
        if hold.is_some() {
            let outcomes = check(&arc.start, &steps, &setup);
            prop_assert!(outcomes.is_ok(), "held: {setup:?}: {}", outcomes.unwrap_err());
        }
    }

    /// A line, an arc, a line: the first or the second as a tangent or anywhere.
    #[test]
    fn arcs_between_lines(
        arc in arcs(-1.0..1.7),
        lines in ([-10.0f64..10.0, -10.0f64..10.0, -10.0f64..10.0], [-10.0f64..10.0, -10.0f64..10.0, -10.0f64..10.0]),
        tangents in (any::<bool>(), any::<bool>()),
        tolerance in 0usize..6,
        fast in (0.5f64..3.0).prop_map(|e| 10f64.powf(e)),
        machine in machines(),
    ) {
        let curve = Curve::new(&arc);
        prop_assume!(!is_refused(&curve));
        let beside = |at: &Point, way: Point, u: f64, tangent: bool| -> Point {
            let along: Point = {
                let (a, b) = (curve.at(u - 1e-4), curve.at(u + 1e-4));
                std::array::from_fn(|i| (b[i] - a[i]) / distance(&a, &b))
            };
            std::array::from_fn(|i| round(at[i] + if tangent { along[i] * way[0] } else { way[i] }))
        };
        let mut before = lines.0;
        before[0] = -before[0].abs() - 0.01;
        let mut behind = lines.1;
        behind[0] = behind[0].abs() + 0.01;
        let start = beside(&arc.start, before, 0.0, tangents.0);
        let end = beside(&arc.end, behind, 1.0, tangents.1);
        let mut setup = Setup::new(TOLERANCES[tolerance], feed(&curve, fast));
        setup.machine = machine;
        let steps = [
            Step::Line(start, arc.start),
            Step::Arc(curve),
            Step::Line(arc.end, end),
        ];
        let outcomes = check(&start, &steps, &setup);
        prop_assert!(outcomes.is_ok(), "{setup:?}: {}", outcomes.unwrap_err());
    }
}

/// The programs that the defects were seen with.
#[test]
fn the_centre_stays_where_it_is() {
    let start = [10.0, 0.0, 0.0];
    for (x, y, least, most) in [
        (10.0, 0.0, 62.831, 62.833),
        (10.0, -0.001, 62.83, 62.832),
        (9.9995, -0.001, 62.829, 62.831),
        (9.999, -0.001, 62.827, 62.829),
        (9.996, -0.01, 62.808, 62.812),
        (10.0, 0.001, 0.0009, 0.0011),
    ] {
        let arc = Arc {
            start,
            end: [x, y, 0.0],
            plane: (0, 1),
            centre: (0.0, 0.0),
            clockwise: false,
            turns: 0,
        };
        let outcomes =
            check(&start, &[Step::Arc(Curve::new(&arc))], &Setup::new(0.01, 50.0)).unwrap();
        for outcome in outcomes {
            assert!(outcome.way > least && outcome.way < most, "{x} {y}: {outcome:?}");
        }
    }
    // A turn that nobody can tell from none.
    for x in [10.001, 9.996] {
        let end = [x, 0.0, 0.0];
        let arc = Arc { start, end, plane: (0, 1), centre: (0.0, 0.0), clockwise: false, turns: 0 };
        let reason = check(&start, &[Step::Arc(Curve::new(&arc))], &Setup::new(0.01, 50.0));
        assert!(reason.unwrap_err().starts_with("refused: arc starts 10.0"));
    }
}

#[test]
fn many_turns_keep_the_band() {
    for (radius, turns, tolerance) in
        [(15.0, 50, 1.0e-2), (100.0, 50, 1.0e-2), (2.0, 300, 1.0e-4), (15.0, 20, 1.0e-3)]
    {
        let start = [radius, 0.0, 0.0];
        let end = [radius, 0.0, f64::from(turns)];
        let arc = Arc { start, end, plane: (0, 1), centre: (0.0, 0.0), clockwise: true, turns };
        let mut setup = Setup::new(tolerance, 4000.0);
        setup.machine = [[4000.0, 2.0e5, 1.0e8]; 3];
        setup.hold = Some(613);
        check(&start, &[Step::Arc(Curve::new(&arc))], &setup).unwrap();
    }
}

/// An arc at tolerance 0 is followed within a band of its own, with stops at its ends, and without more
/// delay than those.
#[test]
fn arcs_at_tolerance_nought_do_not_crawl() {
    for (radius, feed) in [(0.1, 50.0), (0.5, 50.0), (2.0, 50.0), (10.0, 100.0), (100.0, 150.0)] {
        let mut times = [0.0; 2];
        for (time, tolerance) in times.iter_mut().zip([0.0, 0.01]) {
            let mut steps = Vec::new();
            for k in 0..8 {
                let x = 2.0 * radius * f64::from(k);
                steps.push(Step::Arc(Curve::new(&Arc {
                    start: [x, 0.0, 0.0],
                    end: [x + 2.0 * radius, 0.0, 0.0],
                    plane: (0, 1),
                    centre: (x + radius, 0.0),
                    clockwise: k % 2 == 0,
                    turns: 0,
                })));
            }
            let outcomes = check(&[0.0; 3], &steps, &Setup::new(tolerance, feed)).unwrap();
            *time = outcomes[0].time;
        }
        assert!(times[0] < 1.6 * times[1], "radius {radius}: {times:?}");
    }
}

/// In `f32` too: long helices do not jump, ends are exact to the nanometre.
#[test]
fn long_helices_end_where_they_should() {
    for climb in [100.0, 1000.0, 36_000.0] {
        let start = [10.0, 0.0, 0.0];
        let turns = (climb / 370.0) as u16;
        let end = [10.0, 0.0, climb];
        let arc = Arc { start, end, plane: (0, 1), centre: (0.0, 0.0), clockwise: false, turns };
        let mut setup = Setup::new(0.01, 5000.0);
        setup.machine = [[2.0e3, 1.0e5, 1.0e7], [2.0e3, 1.0e5, 1.0e7], [1.0e4, 1.0e5, 1.0e7]];
        check(&start, &[Step::Arc(Curve::new(&arc))], &setup).unwrap();
    }
}

proptest! {
    #![proptest_config(config(300))]

    /// Programs end exactly on the programmed nanometre, whatever the machine.
    #[test]
    fn lines_end_on_the_nanometre(
        points in prop::collection::vec([-500.0f64..500.0, -500.0f64..500.0, -500.0f64..500.0], 1..4),
        machine in 0usize..4,
        feed in (1.0f64..4.0).prop_map(|e| 10f64.powf(e)),
    ) {
        let [v, a, j] = [
            [200.0, 2000.0, 5.0e4],
            [1000.0, 5000.0, 5.0e4],
            [2000.0, 2.0e4, 1.0e6],
            [1000.0, 1.0e4, 1.0e5],
        ][machine];
        let mut from = [0.0; 3];
        let mut steps = Vec::new();
        for point in &points {
            let to = point.map(|x| (x * 1.0e6).round() / 1.0e6);
            steps.push(Step::Line(from, to));
            from = to;
        }
        let mut setup = Setup::new(0.02, feed.max(100.0));
        setup.machine = [[v, a, j]; 3];
        let outcome = run::<f32>(&[0.0; 3], &steps, &setup).unwrap();
        prop_assert_eq!(outcome.missed, 0, "{:?}", outcome);
    }

    /// A line and one of some nanometres, in `f32`: it ends.
    #[test]
    fn lines_of_nanometres_end(
        first in [-1.0f64..1.0, -1.0f64..1.0, -1.0f64..1.0],
        (size, tiny) in (-0.5f64..1.5, 0.0f64..3.0),
        second in [-1.0f64..1.0, -1.0f64..1.0, -1.0f64..1.0],
        tolerance in (-3.0f64..0.0).prop_map(|e| 10f64.powf(e)),
        machine in 0usize..3,
        slow in any::<bool>(),
    ) {
        let [v, a, j] =
            [[200.0, 2000.0, 5.0e4], [1000.0, 1.0e4, 1.0e6], [1411.0, 717_430.0, 3.5e7]][machine];
        let nano = |x: f64| (x * 1.0e6).round() / 1.0e6;
        let middle = first.map(|x| nano(x * 10f64.powf(size)));
        let end: Point =
            std::array::from_fn(|i| nano(middle[i] + second[i] * 10f64.powf(tiny) * 1.0e-6));
        let steps = [Step::Line([0.0; 3], middle), Step::Line(middle, end)];
        let mut setup = Setup::new(tolerance, if slow { 50.0 } else { 1.0e6 });
        setup.machine = [[v, a, j]; 3];
        let outcome = run::<f32>(&[0.0; 3], &steps, &setup).unwrap();
        prop_assert_eq!(outcome.missed, 0, "{:?}", outcome);
        prop_assert!(outcome.time < 2.0, "{:?}", outcome);
    }
}

/// The arc length goes on where coordinates end.
#[test]
fn the_way_goes_on_beyond_the_range_of_coordinates() {
    let axis = AxisLimits::linear(1.0e5, 1.0e7, 1.0e9);
    let mut config = Config::new(Limits::new([axis; 1]).unwrap());
    config.cycle = 0.01;
    let mut link = Box::new(Link::<f64, 1, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO]).unwrap();
    let (mut pushed, mut last, mut way) = (0, 0.0, 0.0);
    loop {
        if pushed < 14 {
            let to = Coord::from_mm(if pushed % 2 == 0 { 1.0e6 } else { 0.0 }).unwrap();
            pushed += u32::from(planner.push(&Block::rapid([to], pushed)).is_ok());
        } else {
            planner.finish();
        }
        let progress = planner.settle();
        let here = interpolator.tick();
        let x = here.position_mm(0);
        way += f64::abs(x - last);
        last = x;
        // It turns between two cycles.
        assert!((here.path_mm() - way).abs() < 3.0e3, "{} {way}", here.path_mm());
        if progress == Progress::Done && here.activity == Activity::Idle {
            assert!((here.path_mm() - 14.0e6).abs() < 1.0, "{}", here.path_mm());
            return;
        }
    }
}
