//! Holds where planning takes time: so many slices of it in a servo cycle. The speed falls soon and the machine stands still hardly later than
//! with planning that takes no time; limits, tolerance and end hold whatever is pressed on the way.

mod common;

use common::soak;
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Limits, Link, Progress, PushError, Scalar,
};
use splineway_studies::paths::Made;

const AXES: usize = 2;
const VELOCITY: f64 = 200.0;
const ACCELERATION: f64 = 2000.0;
const JERK: f64 = 50_000.0;
const TOLERANCE: f64 = 0.05;
/// Servo cycle, s.
const CYCLE: f64 = 1.0e-3;
/// And others, in `f64`: in short ones rounding of `f32` is felt as jerk.
const CYCLES: [f64; 4] = [CYCLE, 0.25e-3, 0.5e-3, 2.0e-3];
/// Slices in a servo cycle where planning takes no time.
const ALL: u32 = 20_000;
/// Servo cycles of a run at most.
const LONGEST: u32 = 60_000;
/// A speed that differs by more shows, mm/s.
const SHOWN: f64 = 0.1;
/// Two motions are the same as long as their speeds differ by less, mm/s, for so many servo cycles.
const SAME: f64 = 1.0;
const SAME_FOR: usize = 60;

type Point = [f64; AXES];

/// Random numbers of no great quality.
struct Draw(u64);

impl Draw {
    fn new(seed: u64) -> Self {
        let mut draw = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        for _ in 0..4 {
            draw.share();
        }
        draw
    }

    fn share(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }
}

/// A program of lines.
struct Path {
    points: Vec<Point>,
    feed: f64,
    /// Servo cycle, s.
    cycle: f64,
}

impl Path {
    /// Some long lines, or many short ones along a bend.
    fn any(draw: &mut Draw) -> Self {
        let points: Vec<Point> = if draw.share() < 0.5 {
            let count = 2 + (draw.share() * 9.0) as usize;
            (0..count).map(|_| [draw.between(0.0, 30.0), draw.between(0.0, 30.0)]).collect()
        } else {
            let (radius, step) = (draw.between(0.5, 20.0), draw.between(0.05, 1.0));
            let count = 20 + (draw.share() * 130.0) as usize;
            let at = |i: usize| {
                let turn = i as f64 * step / radius;
                [radius * turn.cos() + 0.3 * (3.0 * turn).sin(), radius * turn.sin()]
            };
            (0..count).map(at).collect()
        };
        // To the nanometre, as the core has it.
        let grid = |mm: f64| (mm * 1.0e6).round() * 1.0e-6;
        let points = points.into_iter().map(|at| at.map(grid)).collect();
        Self { points, feed: draw.between(20.0, 200.0), cycle: CYCLE }
    }

    /// Distance of a place from the lines, mm.
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

    /// Some lines in a row of a tool path.
    fn stretch(draw: &mut Draw, of: &Made, cycle: f64) -> Self {
        let count = of.points.len().min(20 + (draw.share() * 380.0) as usize);
        let first = (draw.share() * (of.points.len() - count) as f64) as usize;
        let points = of.points[first..first + count].iter().map(|[x, y, _]| [*x, *y]).collect();
        Self { points, feed: draw.between(50.0, 200.0), cycle }
    }

    fn end(&self) -> Point {
        self.points[self.points.len() - 1]
    }
}

#[derive(Clone, Copy, Debug)]
enum Press {
    Hold,
    Resume,
    Stop,
    Single(bool),
    Feed(u16),
}

impl Press {
    fn any(draw: &mut Draw) -> Self {
        match (draw.share() * 10.0) as u32 {
            0 | 1 => Self::Hold,
            2 | 3 => Self::Resume,
            4 | 5 => Self::Stop,
            6 => Self::Single(draw.share() < 0.5),
            _ => Self::Feed(draw.between(1.0, 200.0) as u16),
        }
    }

    fn send(self, controls: Controls<'_>) {
        match self {
            Self::Hold => controls.hold(),
            Self::Resume => controls.resume(),
            Self::Stop => controls.stop(),
            Self::Single(on) => controls.single_block(on),
            Self::Feed(percent) => controls.feed_override(percent),
        }
    }
}

fn coordinates(at: Point) -> [Coord; AXES] {
    at.map(|mm| Coord::from_mm(mm).unwrap())
}

/// Where a run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Until {
    End,
    /// At the first rest after a servo cycle.
    Rest(u32),
    /// When the planner says that it is held, after a servo cycle.
    Held(u32),
}

/// The speed, mm/s, in every servo cycle.
fn run<S: Scalar>(path: &Path, presses: &[(u32, Press)], slices: u32, until: Until) -> Vec<f64> {
    let axis = AxisLimits::linear(S::of(VELOCITY), S::of(ACCELERATION), S::of(JERK));
    let mut settings = Config::new(Limits::new([axis; AXES]).unwrap());
    settings.tolerance = S::of(TOLERANCE);
    settings.cycle = S::of(path.cycle);
    let blocks: Vec<Block<S, AXES>> = path.points[1..]
        .iter()
        .zip(1..)
        .map(|(to, tag)| Block::line(coordinates(*to), S::of(path.feed), tag))
        .collect();
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) =
        link.split(settings, coordinates(path.points[0])).unwrap();
    let controls = planner.controls();
    // The difference of two accelerations has their rounding.
    let rounding = 1.0e-4;
    let (mut next, mut before, mut speeds) = (0, None::<[f64; AXES]>, Vec::new());
    for cycle in 0..LONGEST {
        for (_, press) in presses.iter().filter(|(when, _)| *when == cycle) {
            press.send(controls);
        }
        let mut progress = Progress::Planning;
        let mut done = 0;
        while done < slices && matches!(progress, Progress::Planning | Progress::Planned) {
            while next < blocks.len() {
                match planner.push(&blocks[next]) {
                    Ok(()) => next += 1,
                    Err(PushError::Full) => break,
                    Err(error) => panic!("{error}"),
                }
            }
            if next == blocks.len() {
                planner.finish();
            }
            progress = planner.poll();
            done += 1;
        }
        assert!(done < ALL, "cycle {cycle}: no end of planning");
        let at = interpolator.tick();
        let (velocity, acceleration) =
            (at.velocity.map(Scalar::to_f64), at.acceleration.map(Scalar::to_f64));
        for axis in 0..AXES {
            let (v, a) = (velocity[axis], acceleration[axis]);
            assert!(v.abs() <= VELOCITY * (1.0 + rounding), "cycle {cycle}: velocity {v}");
            assert!(a.abs() <= ACCELERATION * (1.0 + rounding), "cycle {cycle}: acceleration {a}");
            let jerk = before.map_or(0.0, |before| (a - before[axis]) / path.cycle);
            assert!(jerk.abs() <= JERK * (1.0 + rounding), "cycle {cycle}: jerk {jerk}");
        }
        before = Some(acceleration);
        let here = [0, 1].map(|axis| at.position_mm(axis));
        let distance = path.distance(here);
        let most = TOLERANCE * (1.0 + 1.0e-6) + 2.0e-6;
        assert!(distance <= most, "cycle {cycle}: {distance} mm off the path");
        speeds.push(at.path_speed.to_f64());
        let idle = at.activity == Activity::Idle;
        if matches!(until, Until::Rest(after) if idle && cycle > after + 1) {
            return speeds;
        }
        if matches!(until, Until::Held(after) if progress == Progress::Held && cycle > after) {
            return speeds;
        }
        if idle && progress == Progress::Done {
            let [x, y] = path.end();
            let off = f64::hypot(here[0] - x, here[1] - y);
            assert!(off < 1.0e-5, "{off} mm from the end");
            return speeds;
        }
    }
    panic!("no end: {:?}", planner.counters());
}

/// How a hold is answered, against planning that takes no time: how much later it shows, and how much later the machine rests than that by a
/// factor of 1.05 or 10 servo cycles.
#[derive(Default)]
struct Seen {
    shows: Vec<usize>,
    beyond: Vec<f64>,
}

fn first_motion(speeds: &[f64]) -> usize {
    speeds.iter().position(|v| *v > 0.0).unwrap_or(0)
}

fn is_same(one: &[f64], other: &[f64]) -> bool {
    one.iter().zip(other).take(SAME_FOR).all(|(a, b)| (a - b).abs() < SAME)
}

/// When a hold shows, and when it has come to rest, in servo cycles after it.
fn answer<S: Scalar>(path: &Path, base: &[f64], at: usize, slices: u32) -> (Option<usize>, usize) {
    let press = [(at as u32, Press::Hold)];
    let held = run::<S>(path, &press, slices, Until::Rest(at as u32));
    let differs = |k: &usize| (held[*k] - base[*k]).abs() > SHOWN;
    let shows = (at..held.len().min(base.len())).find(differs).map(|k| k - at);
    (shows, held.len() - at)
}

impl Seen {
    fn see<S: Scalar>(&mut self, seed: u64, slices: u32) {
        let draw = &mut Draw::new(seed);
        let path = Path::any(draw);
        let base = run::<S>(&path, &[], slices, Until::End);
        let free = run::<S>(&path, &[], ALL, Until::End);
        for _ in 0..3 {
            let at = (draw.share() * base.len() as f64) as usize;
            let press_again = draw.share();
            if at < 30 || base[at] < 10.0 {
                continue;
            }
            let (shows, rests) = answer::<S>(&path, &base, at, slices);
            let (now, on) = (at as u32, at as u32 + (press_again * 1.3 * rests as f64) as u32);
            // Let go in the fall or later; held again while that shows, and other things.
            let mut presses = vec![(now, Press::Hold), (on, Press::Resume)];
            run::<S>(&path, &presses, slices, Until::End);
            presses.extend([
                (on + 7, Press::Hold),
                (on + 60, Press::Feed(50)),
                (on + 61, Press::Resume),
                (on + 90, Press::Stop),
                (on + 500, Press::Resume),
            ]);
            run::<S>(&path, &presses, slices, Until::End);
            let same = (at + first_motion(&free)).saturating_sub(first_motion(&base));
            if same >= free.len() || !is_same(&base[at..], &free[same..]) {
                continue;
            }
            let (soonest, least) = answer::<S>(&path, &free, same, ALL);
            self.shows.extend(shows.zip(soonest).map(|(k, soonest)| k.saturating_sub(soonest)));
            let goal = (least as f64 * 1.05).max(least as f64 + 10.0);
            self.beyond.push(rests as f64 - goal);
        }
    }
}

/// Holds on random paths: in nine of ten cases it shows at most so many servo cycles later, and so many in a hundred may rest later than the goal.
fn holds<S: Scalar>(slices: u32, shows: usize, beyond: usize) {
    let mut seen = Seen::default();
    for seed in 1..=40 * u64::from(soak()) {
        seen.see::<S>(seed, slices);
    }
    seen.shows.sort_unstable();
    let late = seen.beyond.iter().filter(|over| **over > 0.0).count();
    let worst = seen.beyond.iter().fold(f64::NEG_INFINITY, |most, over| most.max(*over));
    let (half, most) = (seen.shows[seen.shows.len() / 2], seen.shows[seen.shows.len() * 9 / 10]);
    let count = seen.beyond.len();
    println!("{slices}: shows {half} / {most} later, {late} of {count} rest late, by {worst}");
    assert!(most <= shows, "{slices} slices: shows {most} cycles later");
    assert!(late * 100 <= beyond * count, "{slices} slices: {late} of {count} rest late");
}

/// How far a stop at the end of a block goes beyond where a hold rests, mm, on stretches of tool paths: median and worst of what is more than
/// the longest line.
fn stops_beyond_holds<S: Scalar>(slices: u32) -> [f64; 2] {
    let paths = splineway_studies::paths::all().unwrap();
    let mut beyond = Vec::new();
    for seed in 1..=60 * u64::from(soak()) {
        let draw = &mut Draw::new(seed);
        let of = &paths[(draw.share() * paths.len() as f64) as usize];
        let path = Path::stretch(draw, of, CYCLE);
        let base = run::<S>(&path, &[], slices, Until::End);
        let at = (draw.share() * base.len() as f64) as usize;
        let way = |press: Press, until: Until| {
            run::<S>(&path, &[(at as u32, press)], slices, until).iter().sum::<f64>() * path.cycle
        };
        let [hold, stop] =
            [(Press::Hold, Until::Rest(at as u32)), (Press::Stop, Until::Held(at as u32))]
                .map(|(press, until)| way(press, until));
        let length = |ends: &[Point]| f64::hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
        let longest = path.points.windows(2).map(length).fold(0.0, f64::max);
        beyond.push(stop - hold - longest);
    }
    beyond.sort_by(f64::total_cmp);
    [beyond[beyond.len() / 2], beyond[beyond.len() - 1]]
}

/// Whatever planning takes, a stop comes at an end of a block near where a hold would rest.
#[test]
fn a_stop_goes_hardly_farther_than_a_hold() {
    for (slices, most) in [(ALL, 8.0), (4, 10.0), (1, 14.0)] {
        let [median, worst] = stops_beyond_holds::<f32>(slices);
        println!("{slices} slices: {median:.2} / {worst:.2} mm beyond a hold");
        assert!(median < 1.0 && worst < most, "{slices} slices: {median} / {worst} mm");
    }
}

/// Presses in random servo cycles, some right behind each other, and at last what lets every program come to its end.
fn presses(draw: &mut Draw) -> Vec<(u32, Press)> {
    let mut when = 0;
    let mut presses: Vec<(u32, Press)> = (0..(draw.share() * 30.0) as u32)
        .map(|_| {
            when += (0.3 * 10_f64.powf(draw.between(0.0, 3.5))) as u32;
            (when, Press::any(draw))
        })
        .collect();
    // A stop may only have come to the end of its line then.
    presses.extend([
        (when + 199, Press::Single(false)),
        (when + 200, Press::Feed(100)),
        (when + 201, Press::Resume),
    ]);
    presses.push((when + 5000, Press::Resume));
    presses
}

/// Real tool paths find what random lines and bends do not.
fn on_tool_paths<S: Scalar>() {
    let paths = splineway_studies::paths::all().unwrap();
    for seed in 1..=200 * u64::from(soak()) {
        let draw = &mut Draw::new(seed);
        let of = &paths[(draw.share() * paths.len() as f64) as usize];
        let cycles = if S::NAME == "f32" { &CYCLES[..1] } else { &CYCLES };
        let cycle = cycles[(draw.share() * cycles.len() as f64) as usize];
        let path = Path::stretch(draw, of, cycle);
        let slices = [1, 2, 4, 10, 30, ALL][(draw.share() * 6.0) as usize];
        let presses = presses(draw);
        let runs = || run::<S>(&path, &presses, slices, Until::End);
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(runs));
        assert!(
            outcome.is_ok(),
            "case {seed}: {} in {}, {slices} slices in {cycle} s",
            of.name,
            S::NAME
        );
    }
}

#[test]
fn any_commands_on_tool_paths_in_f32() {
    on_tool_paths::<f32>();
}

#[test]
fn any_commands_on_tool_paths_in_f64() {
    on_tool_paths::<f64>();
}

#[test]
fn thirty_slices_in_a_servo_cycle() {
    holds::<f64>(30, 1, 1);
    holds::<f32>(30, 1, 1);
}

#[test]
fn ten_slices_in_a_servo_cycle() {
    holds::<f64>(10, 2, 1);
    holds::<f32>(10, 2, 1);
}

/// About what a Cortex-M4F does.
#[test]
fn four_slices_in_a_servo_cycle() {
    holds::<f64>(4, 3, 3);
    holds::<f32>(4, 3, 3);
}

#[test]
fn two_slices_in_a_servo_cycle() {
    holds::<f64>(2, 5, 8);
    holds::<f32>(2, 5, 8);
}

#[test]
fn a_slice_in_a_servo_cycle() {
    holds::<f64>(1, 18, 22);
    holds::<f32>(1, 18, 22);
}
