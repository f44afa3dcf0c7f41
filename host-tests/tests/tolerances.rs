//! Programs whose tolerance changes between blocks: every block is kept to within its own, and the place where two meet to
//! within the lesser.

#[path = "common/cases.rs"]
mod cases;
#[path = "common/ways.rs"]
#[allow(dead_code)] // A part of it is for other tests.
mod ways;

use cases::soak;
use fastrand::Rng;
use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Feed, Limits, Link, Progress, PushError, Scalar,
};
use ways::{Followed, distance};

const AXES: usize = 3;
/// What is granted in `f32` to the directions of long lines, mm.
const SINGLE: f64 = 1.0e-5;
/// Share of a tolerance that is granted to rounding.
const ROUNDING: f64 = 5.0e-4;

type Point = ways::Point<AXES>;
type Way = ways::Way<AXES>;

#[derive(Clone, Copy, Debug)]
struct Step {
    way: Way,
    to: Point,
    tolerance: f64,
    feed: f64,
    exact: bool,
}

impl Step {
    fn block<S: Scalar>(&self, tag: u32) -> Block<S, AXES> {
        let (motion, feed) = (self.way.motion(&self.to), Feed::PerSecond(S::of(self.feed)));
        Block { motion, feed, tolerance: Some(S::of(self.tolerance)), exact_stop: self.exact, tag }
    }
}

/// What a run came to.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    time: f64,
    /// Greatest distance from the path as a share of the tolerance there and what is granted to rounding, the block, and where.
    share: f64,
    block: usize,
    at: Point,
}

/// Runs a program from the origin.
fn run<S: Scalar>(steps: &[Step], cycle: f64) -> Found {
    let axis = [1.0, 0.92, 0.84].map(|share| {
        AxisLimits::linear(S::of(200.0 * share), S::of(2000.0 * share), S::of(50_000.0 * share))
    });
    let mut config = Config::new(Limits::new(axis).unwrap());
    config.cycle = S::of(cycle);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let mut followed =
        Followed::new([0.0; AXES], steps.iter().map(|step| (step.way, step.to, step.tolerance)));
    let (mut next, mut finished) = (0, false);
    let mut found = Found::default();
    for cycles in 0.. {
        let progress = loop {
            while let Some(step) = steps.get(next) {
                match planner.push(&step.block(next as u32)) {
                    Ok(()) => next += 1,
                    Err(PushError::Full) => break,
                    Err(refused) => panic!("{refused}: {step:?}"),
                }
            }
            if next == steps.len() && !finished {
                planner.finish();
                finished = true;
            }
            let progress = planner.poll();
            if !matches!(progress, Progress::Planning | Progress::Planned) {
                break progress;
            }
        };
        let here = interpolator.tick();
        let x = std::array::from_fn(|i| here.position_mm(i));
        let (outside, block, tolerance) = followed.outside(&x);
        let single = if S::NAME == "f32" { SINGLE } else { 0.0 };
        let grant = tolerance * ROUNDING + steps[block].way.grant() + single;
        let share = (tolerance + outside) / (tolerance + grant);
        if share > found.share {
            (found.share, found.block, found.at) = (share, block, x);
        }
        if progress == Progress::Done && here.activity == Activity::Idle {
            assert!(distance(&x, &steps[steps.len() - 1].to) < 2.0e-6, "beside the end");
            found.time = f64::from(cycles) * cycle;
            break;
        }
        assert!(f64::from(cycles) * cycle < 1000.0, "no end");
    }
    found
}

/// A number of any order of magnitude between two.
fn any(rng: &mut Rng, least: f64, greatest: f64) -> f64 {
    least * (greatest / least).powf(rng.f64())
}

/// A program that has not come to its end.
struct Draft {
    steps: Vec<Step>,
    at: Point,
    heading: f64,
    tolerance: f64,
    /// For so many blocks more.
    alike: usize,
    few: [f64; 3],
    /// Of any other tolerance, mm.
    range: [f64; 2],
    flat: bool,
}

impl Draft {
    fn new(rng: &mut Rng, ways: u8) -> Self {
        let range = if ways == 1 && rng.u8(..4) == 0 { [0.0002, 1.0] } else { [0.002, 0.2] };
        let few = [0; 3].map(|_| any(rng, range[0], range[1]));
        let (at, flat) = ([0.0; AXES], rng.bool());
        Self { steps: Vec::new(), at, heading: 0.0, tolerance: 0.0, alike: 0, few, range, flat }
    }

    /// Goes on in the heading, to which a way is turned.
    fn push(&mut self, rng: &mut Rng, size: f64, feed: f64, way: u8) {
        if self.alike == 0 {
            let most = rng.usize(1..=10);
            self.alike = rng.usize(1..=most);
            self.tolerance = match rng.u8(..16) {
                0 => 0.0,
                1..=8 => self.few[rng.usize(..3)],
                _ => any(rng, self.range[0], self.range[1]),
            };
        }
        self.alike -= 1;
        let from = self.at;
        let round = |x: f64| (x * 1.0e6).round() / 1.0e6;
        let (sin, cos) = self.heading.sin_cos();
        let climb = if self.flat { 0.0 } else { size * 0.2 * (rng.f64() - 0.5) };
        let bend = 3.0 * (rng.f64() - 0.5);
        let way = match way {
            // Tangent to the heading, with a chord as long as the size.
            1 if bend.abs() > 0.05 && size > 0.05 => {
                let radius = round(size / (2.0 * (0.5 * bend).sin()));
                let centre = [round(from[0] - radius * sin), round(from[1] + radius * cos)];
                Way::Arc(centre, bend)
            }
            2 => {
                let away = |share: f64, turn: f64| {
                    let (sin, cos) = (self.heading + turn).sin_cos();
                    [
                        from[0] + share * size * cos,
                        from[1] + share * size * sin,
                        from[2] + share * climb,
                    ]
                    .map(round)
                };
                Way::Curve([away(0.33, 0.0), away(0.67, bend * 0.3)])
            }
            _ => Way::Line,
        };
        let straight = [from[0] + size * cos, from[1] + size * sin, from[2] + climb].map(round);
        let mut step = Step {
            way,
            to: straight,
            // A curve needs some.
            tolerance: if matches!(way, Way::Line) {
                self.tolerance
            } else {
                self.tolerance.max(0.0005)
            },
            feed: feed.max(5.0 * size),
            exact: rng.u8(..64) == 0,
        };
        match way {
            Way::Arc(_, angle) => {
                step.to = step.way.at(&from, &step.to, 1.0).map(round);
                self.heading += angle;
            }
            Way::Curve(_) => {
                let (sin, cos) = (self.heading + 0.6 * bend).sin_cos();
                step.to = [from[0] + size * cos, from[1] + size * sin, straight[2]].map(round);
                self.heading += bend;
            }
            _ => {}
        }
        self.at = step.to;
        self.steps.push(step);
    }
}

/// Blocks of all lengths in stretches that turn slightly, sharply, to and fro or anyhow. `ways`: of how many kinds.
fn program(rng: &mut Rng, ways: u8) -> Vec<Step> {
    let mut draft = Draft::new(rng, ways);
    for _ in 0..rng.usize(1..8) {
        let (kind, count) = (rng.u8(..6), rng.usize(1..16));
        let (size, turn) = (any(rng, 0.02, 30.0), rng.f64() - 0.5);
        let feed = any(rng, 3.0, 200.0);
        for k in 0..count {
            let size = if rng.u8(..4) == 0 { any(rng, 0.02, 30.0) } else { size };
            draft.heading += match kind {
                0 | 1 => turn,
                2 => turn * rng.f64(),
                3 => 3.0 * turn * if k % 2 == 0 { 1.0 } else { -1.0 },
                4 => 6.0 * turn * rng.f64(),
                _ => 0.0,
            };
            let way = if ways > 1 && rng.bool() { rng.u8(..ways) } else { 0 };
            draft.push(rng, size, feed, way);
        }
    }
    draft.steps
}

fn search<S: Scalar>(ways: u8, cases: u64) {
    let first = std::env::var("FIRST").ok().and_then(|x| x.parse().ok()).unwrap_or(0);
    let (mut worst, mut bad, mut time) = (0.0f64, Vec::new(), 0.0);
    for seed in first..first + cases * u64::from(soak()) {
        let mut rng = Rng::with_seed(seed);
        let steps = program(&mut rng, ways);
        let cycle = if rng.u8(..4) == 0 { 1.0e-4 } else { 1.0e-3 };
        let found = run::<S>(&steps, cycle);
        worst = worst.max(found.share);
        time += found.time;
        if found.share > 1.0 {
            bad.push((seed, found));
        }
    }
    bad.sort_by(|a, b| b.1.share.total_cmp(&a.1.share));
    println!(
        "{} {ways}: {} of {cases} bad, worst {worst} of the tolerance, {time} s",
        S::NAME,
        bad.len()
    );
    assert!(bad.is_empty(), "{:#?}", &bad[..bad.len().min(8)]);
}

#[test]
fn lines_in_f64() {
    search::<f64>(1, 1000);
}

#[test]
fn lines_in_f32() {
    search::<f32>(1, 500);
}

#[test]
fn arcs_in_f64() {
    search::<f64>(2, 400);
}

#[test]
fn curves_in_f64() {
    search::<f64>(3, 400);
}

#[test]
fn curves_in_f32() {
    search::<f32>(3, 200);
}

/// Behind an exact stop on a line of no tolerance a short line leads to a curve, in a wide band: the motion from rest does not
/// begin by going back beside the stop.
#[test]
fn the_band_behind_an_exact_stop_begins_with_its_line() {
    let steps = program(&mut Rng::with_seed(3779), 3);
    let found = run::<f64>(&steps, 1.0e-3);
    assert!(found.share <= 1.0, "{found:?}");
}

/// A knot lay half a nanometre before a vertex, and the next at that: the span between the two was crept through for seconds.
#[test]
fn a_vertex_just_behind_a_knot_is_not_crept_to() {
    let points = [
        [0.3289, -0.0368, -0.1086],
        [0.3249, -0.0368, -0.1057],
        [0.3275, -0.0368, -0.1015],
        [0.3261, -0.0368, -0.0944],
        [0.3233, -0.0368, -0.0802],
    ];
    let steps: Vec<Step> = (points.into_iter().zip([0.0, 0.01, 0.01, 0.3, 0.01]))
        .map(|(to, tolerance)| Step { way: Way::Line, to, tolerance, feed: 43.0, exact: false })
        .collect();
    let found = run::<f64>(&steps, 1.0e-3);
    assert!(found.share <= 1.0 && found.time < 0.15, "{found:?}");
}
