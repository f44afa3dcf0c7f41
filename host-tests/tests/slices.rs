//! Planning that takes time, and an operator who presses whatever he likes meanwhile: whatever is late, no limit and no
//! tolerance is exceeded, no block is lost, and every program ends.

mod common;

use common::config;
use proptest::prelude::*;
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Limits, Link, Progress, PushError, Scalar,
};

const AXES: usize = 2;
const VELOCITY: f64 = 200.0;
const ACCELERATION: f64 = 2000.0;
const JERK: f64 = 50_000.0;
const TOLERANCE: f64 = 0.05;
/// s.
const CYCLE: f64 = 1.0e-3;
/// A run that has not ended by then, s, never will.
const LONGEST: f64 = 120.0;
/// Nor will planning that takes more slices than that in a servo cycle.
const MOST_SLICES: u32 = 2000;

#[derive(Clone, Copy, Debug)]
enum Press {
    Hold,
    Resume,
    Stop,
    Feed(u16),
    Single(bool),
}

impl Press {
    fn send(self, controls: Controls<'_>) {
        match self {
            Self::Hold => controls.hold(),
            Self::Resume => controls.resume(),
            Self::Stop => controls.stop(),
            Self::Feed(percent) => controls.feed_override(percent),
            Self::Single(on) => controls.single_block(on),
        }
    }
}

/// Where planning takes time.
#[derive(Clone, Copy, Debug)]
struct Pace {
    /// A slice takes this long at most, servo cycles; every one another time.
    slice: f64,
    seed: u64,
}

type Point = [f64; AXES];

/// A program of lines; where it starts and its corners.
#[derive(Clone, Debug)]
struct Path {
    points: Vec<Point>,
    feed: f64,
}

impl Path {
    /// Distance of a place from the lines up to and from those at hand, mm.
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

/// What two setpoints, one after the other, may differ by.
fn check<S: Scalar>(
    before: Option<([f64; AXES], [f64; AXES])>,
    (velocity, acceleration): ([f64; AXES], [f64; AXES]),
) -> Result<(), String> {
    // As the judge has it; in `f32` the difference of two accelerations has their rounding besides.
    let rounding = if S::EPSILON.to_f64() > 1e-10 { 2.0e-3 } else { 1.0e-3 };
    for axis in 0..AXES {
        let within = |name: &str, value: f64, limit: f64| {
            if value.abs() <= limit * (1.0 + rounding) {
                Ok(())
            } else {
                Err(format!("axis {axis}: {name} {value}"))
            }
        };
        within("velocity", velocity[axis], VELOCITY)?;
        within("acceleration", acceleration[axis], ACCELERATION)?;
        if let Some((_, before)) = before {
            within("jerk", (acceleration[axis] - before[axis]) / CYCLE, JERK)?;
        }
    }
    Ok(())
}

/// Runs a program while planning takes time. What has gone wrong, in words.
fn run<S: Scalar>(path: &Path, presses: &[(u32, Press)], pace: Pace) -> Result<(), String> {
    let axis = AxisLimits::linear(S::of(VELOCITY), S::of(ACCELERATION), S::of(JERK));
    let mut settings = Config::new(Limits::new([axis; AXES]).unwrap());
    settings.tolerance = S::of(TOLERANCE);
    let blocks: Vec<Block<S, AXES>> = path.points[1..]
        .iter()
        .zip(1..)
        .map(|(to, tag)| Block::line(coordinates(*to), S::of(path.feed), tag))
        .collect();
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) =
        link.split(settings, coordinates(path.points[0])).unwrap();
    let controls = planner.controls();
    let (mut next, mut tag, mut seed) = (0, 0, pace.seed | 1);
    // Time that the background is behind, in cycles.
    let mut behind = 0.0;
    let mut before = None;
    for cycle in 0..(LONGEST / CYCLE) as u32 {
        for (_, press) in presses.iter().filter(|(when, _)| *when == cycle) {
            press.send(controls);
        }
        // An operator who has pressed anything resumes in the end.
        if cycle % 1000 == 999 {
            controls.single_block(false);
            controls.resume();
        }
        behind -= 1.0;
        let mut progress = Progress::Planning;
        // With slices that take no time, as many as do something.
        let mut slices = 0;
        while behind < 0.0 && progress == Progress::Planning {
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
            if progress == Progress::Planned {
                progress = Progress::Planning;
            }
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            if progress == Progress::Planning {
                behind += pace.slice * (seed >> 40) as f64 / f64::from(1 << 24);
            }
            slices += 1;
            if slices > MOST_SLICES {
                return Err(format!("cycle {cycle}: no end of planning: {:?}", planner.counters()));
            }
        }
        behind = behind.max(-1.0);
        let setpoint = interpolator.tick();
        let velocity = setpoint.velocity.map(Scalar::to_f64);
        let acceleration = setpoint.acceleration.map(Scalar::to_f64);
        let here = [0, 1].map(|axis| setpoint.position_mm(axis));
        let fail = |what: String| Err(format!("cycle {cycle}, line {}: {what}", setpoint.tag));
        if let Err(what) = check::<S>(before, (velocity, acceleration)) {
            return fail(what);
        }
        before = Some((velocity, acceleration));
        let distance = path.distance(here);
        if distance > TOLERANCE * (1.0 + 1.0e-6) + 2.0e-6 {
            return fail(format!("{distance} mm off the path"));
        }
        if setpoint.tag < tag {
            return fail(format!("line {tag} was before"));
        }
        tag = setpoint.tag;
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            let end = path.points[path.points.len() - 1];
            let off = f64::hypot(here[0] - end[0], here[1] - end[1]);
            return if off < 1.0e-5 { Ok(()) } else { fail(format!("{off} mm from the end")) };
        }
    }
    Err(format!("no end: {:?}", planner.counters()))
}

fn path() -> impl Strategy<Value = Path> {
    let long = prop::collection::vec([0.0f64..30.0, 0.0..30.0], 2..12);
    // A run of short lines along a bend.
    let dense = (0.5f64..20.0, 0.05f64..1.0, 20usize..150).prop_map(|(radius, step, count)| {
        let at = |i: usize| {
            let turn = i as f64 * step / radius;
            [radius * turn.cos() + 0.3 * (3.0 * turn).sin(), radius * turn.sin()]
        };
        (0..count).map(at).collect::<Vec<_>>()
    });
    (prop_oneof![long, dense], 10.0f64..200.0).prop_map(|(points, feed)| {
        // To the nanometre, as the core has it.
        let grid = |mm: f64| (mm * 1.0e6).round() * 1.0e-6;
        Path { points: points.into_iter().map(|at| at.map(grid)).collect(), feed }
    })
}

fn presses() -> impl Strategy<Value = Vec<(u32, Press)>> {
    let press = prop_oneof![
        3 => Just(Press::Hold),
        3 => Just(Press::Resume),
        1 => Just(Press::Stop),
        2 => prop::sample::select(vec![0u16, 5, 20, 50, 100, 100, 150]).prop_map(Press::Feed),
        1 => prop::bool::ANY.prop_map(Press::Single),
    ];
    prop::collection::vec((0u32..2000, press), 0..10).prop_map(|mut list| {
        // At the end nothing may keep the program from its end.
        list.push((2000, Press::Feed(100)));
        list
    })
}

fn pace() -> impl Strategy<Value = Pace> {
    // A plan has some 20 slices: from none to 300 ms.
    (prop::sample::select(vec![0.0, 0.1, 0.5, 2.0, 5.0, 15.0]), any::<u64>())
        .prop_map(|(slice, seed)| Pace { slice, seed })
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn nothing_is_exceeded_or_lost_however_long_planning_takes(
        path in path(),
        presses in presses(),
        pace in pace(),
        single in prop::bool::ANY,
    ) {
        let outcome =
            if single { run::<f32>(&path, &presses, pace) } else { run::<f64>(&path, &presses, pace) };
        prop_assert!(outcome.is_ok(), "{}", outcome.unwrap_err());
    }
}
