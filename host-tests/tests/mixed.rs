//! Everything at once: blocks of all kinds and lengths in bands and by limits that change, on machines of several axes, with reshaping or
//! without; commands in any order, a sender that falls silent, planning that takes long or does not come to run. Every servo
//! cycle is looked at.

#[path = "common/ways.rs"]
#[allow(dead_code)] // A part of it is for other tests.
mod ways;

use fastrand::Rng;
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Feed, Limits, Link, Progress, PushError,
    Reshaping, Scalar, Setpoint,
};
use std::fmt::Write;
use ways::{Followed, SAGITTA, between, distance};

/// Axes of a program: a machine takes the first of them, and the fourth is a rotary one.
const AXES: usize = 4;
/// What is granted in `f32` to the directions of long lines, mm.
const SINGLE: f64 = 1.0e-5;
/// Share of a tolerance that is granted to rounding.
const ROUNDING: f64 = 5.0e-4;
/// The same between two servo cycles, where a place is only nearly known.
const BETWEEN: f64 = 0.01;
/// Slices of planning in a servo cycle.
const SLICES: [u32; 6] = [100_000, 30, 10, 4, 2, 1];
/// More slices than all that can be planned in a servo cycle takes.
const ENDLESS: u32 = 20_000;

type Point = ways::Point<AXES>;
type Way = ways::Way<AXES>;

#[derive(Clone, Copy, Debug)]
struct Step {
    way: Way,
    to: Point,
    tolerance: f64,
    /// mm/s; 0 for a rapid.
    feed: f64,
    exact: bool,
    /// Which limits it is run by.
    set: usize,
}

#[derive(Clone, Copy, Debug)]
enum Press {
    Feed(u16),
    Rapid(u16),
    Hold,
    QuickHold,
    Resume,
    Stop,
    Single(bool),
    Abort,
    QuickAbort,
}

impl Press {
    fn send(self, controls: Controls<'_>) {
        match self {
            Self::Feed(percent) => controls.feed_override(percent),
            Self::Rapid(percent) => controls.rapid_override(percent),
            Self::Hold => controls.hold(),
            Self::QuickHold => controls.quick_hold(),
            Self::Resume => controls.resume(),
            Self::Stop => controls.stop(),
            Self::Single(on) => controls.single_block(on),
            Self::Abort => controls.abort(),
            Self::QuickAbort => controls.quick_abort(),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Machine {
    axes: [[f64; 3]; AXES],
    cycle: f64,
    lead: f64,
    start_delay: f64,
    iterations: u16,
    sweeps: u16,
    /// Factors of limits that take turns.
    sets: [[f64; 3]; 2],
    /// And of the stop limits; 0 for none.
    stops: f64,
}

/// Servo cycles in which something does not come.
#[derive(Clone, Copy, Debug)]
struct Gap {
    from: u32,
    cycles: u32,
    /// Said to be the end.
    finish: bool,
}

impl Gap {
    fn has(&self, cycle: u32) -> bool {
        cycle >= self.from && cycle - self.from < self.cycles
    }
}

#[derive(Clone, Debug)]
struct Case {
    axes: usize,
    machine: Machine,
    reshape: bool,
    slices: u32,
    /// A program, and what is run after an abort each.
    parts: Vec<Vec<Step>>,
    presses: Vec<(u32, Press)>,
    /// In which no block comes.
    silences: Vec<Gap>,
    /// In which nothing is planned.
    stalls: Vec<Gap>,
}

impl Step {
    fn block<S: Scalar, const N: usize>(&self, tag: u32) -> Block<S, N> {
        let motion = match self.way {
            Way::Dwell(seconds) => return Block::dwell(S::of(seconds), tag),
            Way::Event => return Block::event(tag),
            way => way.motion(&self.to),
        };
        let feed = if self.feed > 0.0 { Feed::PerSecond(S::of(self.feed)) } else { Feed::Rapid };
        Block { motion, feed, tolerance: Some(S::of(self.tolerance)), exact_stop: self.exact, tag }
    }
}

/// The path of a program from a place on.
fn follow(start: Point, steps: &[Step]) -> Followed<AXES> {
    Followed::new(start, steps.iter().map(|step| (step.way, step.to, step.tolerance)))
}

/// A number of any order of magnitude between two.
fn any(rng: &mut Rng, least: f64, greatest: f64) -> f64 {
    least * (greatest / least).powf(rng.f64())
}

fn one<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[rng.usize(..of.len())]
}

/// A program that has not come to its end, from the origin.
struct Draft {
    axes: usize,
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
    set: usize,
    /// Whether limits change.
    sets: bool,
}

impl Draft {
    fn new(rng: &mut Rng, axes: usize) -> Self {
        let range = one(rng, &[[0.0002, 1.0], [0.002, 0.2], [0.002, 0.2], [0.02, 0.05]]);
        let few = [0; 3].map(|_| any(rng, range[0], range[1]));
        let flat = rng.bool();
        let sets = rng.u8(..4) == 0;
        Self {
            axes,
            steps: Vec::new(),
            at: [0.0; AXES],
            heading: 0.0,
            tolerance: 0.0,
            alike: 0,
            few,
            range,
            flat,
            set: 0,
            sets,
        }
    }

    fn turn_tolerance(&mut self, rng: &mut Rng) {
        if self.alike == 0 {
            let most = rng.usize(1..=10);
            self.alike = rng.usize(1..=most);
            self.tolerance = match rng.u8(..16) {
                0 => 0.0,
                1..=8 => self.few[rng.usize(..3)],
                _ => any(rng, self.range[0], self.range[1]),
            };
            if self.sets && rng.u8(..3) == 0 {
                self.set = rng.usize(..3);
            }
        }
        self.alike -= 1;
    }

    /// Goes on in the heading, to which a way is turned.
    fn push(&mut self, rng: &mut Rng, size: f64, feed: f64, way: u8) {
        self.turn_tolerance(rng);
        let from = self.at;
        let round = |x: f64| (x * 1.0e6).round() / 1.0e6;
        let (sin, cos) = self.heading.sin_cos();
        let climb = if self.flat { 0.0 } else { size * 0.2 * (rng.f64() - 0.5) };
        let swing = if rng.u8(..3) == 0 { size * 2.0 * (rng.f64() - 0.5) } else { 0.0 };
        let bend = 3.0 * (rng.f64() - 0.5);
        let cut = |mut p: Point| {
            p.iter_mut().skip(self.axes).for_each(|x| *x = 0.0);
            p.map(round)
        };
        let way = match way {
            // Tangent to the heading, with a chord as long as the size.
            1 if bend.abs() > 0.05 && size > 0.05 => {
                let radius = round(size / (2.0 * (0.5 * bend).sin()));
                let centre = [round(from[0] - radius * sin), round(from[1] + radius * cos)];
                Way::Arc(centre, bend)
            }
            2 if size > 0.01 => {
                let away = |share: f64, turn: f64| {
                    let (sin, cos) = (self.heading + turn).sin_cos();
                    cut([
                        from[0] + share * size * cos,
                        from[1] + share * size * sin,
                        from[2] + share * climb,
                        from[3] + share * swing,
                    ])
                };
                Way::Curve([away(0.33, 0.0), away(0.67, bend * 0.3)])
            }
            _ => Way::Line,
        };
        let straight =
            cut([from[0] + size * cos, from[1] + size * sin, from[2] + climb, from[3] + swing]);
        let mut step = Step {
            way,
            to: straight,
            // A curve needs some.
            tolerance: if matches!(way, Way::Line) {
                self.tolerance
            } else {
                self.tolerance.max(0.0005)
            },
            feed: if feed > 0.0 { feed.max(2.0 * size) } else { 0.0 },
            exact: rng.u8(..64) == 0,
            set: self.set,
        };
        match way {
            Way::Arc(_, angle) => {
                step.to = cut(step.way.at(&from, &step.to, 1.0));
                self.heading += angle;
            }
            Way::Curve(_) => {
                let (sin, cos) = (self.heading + 0.6 * bend).sin_cos();
                step.to = [from[0] + size * cos, from[1] + size * sin, straight[2], straight[3]];
                step.to = cut(step.to);
                self.heading += bend;
            }
            _ => {}
        }
        self.at = step.to;
        self.steps.push(step);
    }

    fn stand(&mut self, rng: &mut Rng) {
        let way = if rng.bool() { Way::Event } else { Way::Dwell(any(rng, 0.002, 0.1)) };
        let (to, set) = (self.at, self.set);
        self.steps.push(Step { way, to, tolerance: 0.0, feed: 0.0, exact: true, set });
    }
}

/// Blocks of all lengths in stretches that turn slightly, sharply, to and fro or anyhow.
fn program(rng: &mut Rng, axes: usize) -> Vec<Step> {
    let mut draft = Draft::new(rng, axes);
    let ways = rng.u8(1..4);
    let range = one(rng, &[[0.02, 30.0], [0.001, 100.0], [0.05, 2.0], [0.001, 0.3]]);
    for _ in 0..rng.usize(1..6) {
        let (kind, count) = (rng.u8(..8), rng.usize(1..20));
        let (size, turn) = (any(rng, range[0], range[1]), rng.f64() - 0.5);
        let feed = match rng.u8(..8) {
            0 => 0.0,
            1 | 3 => any(rng, 0.01, 1.0),
            2 => 1.0e4,
            _ => any(rng, 3.0, 300.0),
        };
        let vary = rng.bool();
        for k in 0..count {
            let size = if vary && rng.u8(..4) == 0 { any(rng, range[0], range[1]) } else { size };
            let size = if rng.u8(..40) == 0 { 0.0 } else { size };
            draft.heading += match kind {
                0 | 1 => turn,
                2 => turn * rng.f64(),
                3 => 3.0 * turn * if k % 2 == 0 { 1.0 } else { -1.0 },
                4 => 6.0 * turn * rng.f64(),
                5 => std::f64::consts::PI,
                _ => 0.0,
            };
            let way = if ways > 1 && rng.bool() { rng.u8(..ways) } else { 0 };
            draft.push(rng, size, feed, way);
            if rng.u8(..80) == 0 {
                draft.stand(rng);
            }
        }
    }
    draft.steps
}

fn machine(rng: &mut Rng) -> Machine {
    let axes = if rng.bool() {
        [1.0, 0.92, 0.84, 2.0].map(|share| [200.0 * share, 2000.0 * share, 50_000.0 * share])
    } else {
        let unlike = rng.bool();
        let [v, a, j] = [any(rng, 20.0, 800.0), any(rng, 5.0, 60.0), any(rng, 5.0, 200.0)];
        [0; 4].map(|_| {
            let v = if unlike { v * any(rng, 0.3, 3.0) } else { v };
            let a = v * if unlike { a * any(rng, 0.5, 2.0) } else { a };
            [v, a, a * if unlike { j * any(rng, 0.5, 2.0) } else { j }]
        })
    };
    let mut set = || [any(rng, 0.3, 1.0), any(rng, 0.2, 2.0), any(rng, 0.2, 2.0)];
    let sets = [set(), set()];
    Machine {
        axes,
        cycle: one(rng, &[1.0e-3, 1.0e-3, 1.0e-3, 2.5e-4, 2.0e-3]),
        lead: one(rng, &[0.0, 0.0, 0.0, 0.001, 0.2]),
        start_delay: one(rng, &[-1.0, -1.0, 0.0, 0.02]),
        iterations: one(rng, &[0, 0, 0, 15, 60]),
        sweeps: one(rng, &[0, 0, 0, 1, 11]),
        sets,
        stops: if rng.u8(..3) == 0 { any(rng, 0.5, 4.0) } else { 0.0 },
    }
}

fn presses(rng: &mut Rng) -> Vec<(u32, Press)> {
    let (mut presses, mut cycle) = (Vec::new(), rng.u32(..600));
    let often = 1 + rng.u32(..40);
    let (mut aborts, liked) = (0, rng.u8(..8));
    for _ in 0..rng.u32(1..40) {
        let percent = match rng.u8(..4) {
            0 => one(rng, &[0, 1, 5, 20, 50, 80, 100, 150, 200]),
            1 => 100,
            _ => rng.u16(1..=200),
        };
        let what = if rng.bool() { liked } else { rng.u8(..16) };
        let press = match what {
            0..=3 => Press::Feed(percent),
            4 => Press::Rapid(percent.min(100)),
            5 | 8 => Press::Hold,
            6 | 9 | 10 => Press::Resume,
            7 | 11 => Press::Stop,
            12 => Press::QuickHold,
            13 if aborts < 2 => {
                aborts += 1;
                if rng.bool() { Press::Abort } else { Press::QuickAbort }
            }
            14 => Press::Single(rng.bool()),
            _ => Press::Feed(100),
        };
        presses.push((cycle, press));
        let most = if rng.u8(..4) == 0 { 300 } else { often };
        cycle += rng.u32(..most);
    }
    presses
}

fn gaps(rng: &mut Rng) -> Vec<Gap> {
    let (mut gaps, mut from) = (Vec::new(), rng.u32(..400));
    for _ in 0..rng.u32(1..6) {
        let cycles = any(rng, 1.0, 200.0) as u32;
        gaps.push(Gap { from, cycles, finish: rng.bool() });
        from += cycles + rng.u32(..400);
    }
    gaps
}

impl Case {
    fn new(seed: u64, axes: usize, may_reshape: bool) -> Self {
        let mut rng = Rng::with_seed(seed);
        let rng = &mut rng;
        let machine = machine(rng);
        let mut presses = presses(rng);
        if rng.u8(..12) == 0 {
            presses.clear();
        }
        let is_abort = |press: &Press| matches!(press, Press::Abort | Press::QuickAbort);
        let aborts = presses.iter().filter(|(_, press)| is_abort(press)).count();
        Self {
            axes,
            machine,
            reshape: may_reshape && rng.bool(),
            slices: one(rng, &SLICES),
            parts: (0..=aborts).map(|_| program(rng, axes)).collect(),
            presses,
            silences: if rng.u8(..4) == 0 { gaps(rng) } else { Vec::new() },
            stalls: if rng.u8(..4) == 0 { gaps(rng) } else { Vec::new() },
        }
    }

    fn limits<S: Scalar, const N: usize>(&self, set: usize) -> Limits<S, N> {
        let factors = if set == 0 { [1.0; 3] } else { self.machine.sets[set - 1] };
        Limits::new(std::array::from_fn(|i| {
            let [v, a, j]: [S; 3] =
                std::array::from_fn(|k| S::of(self.machine.axes[i][k] * factors[k]));
            if i == 3 { AxisLimits::rotary(v, a, j) } else { AxisLimits::linear(v, a, j) }
        }))
        .unwrap()
    }

    fn config<S: Scalar, const N: usize>(&self) -> Config<S, N> {
        let mut config = Config::new(self.limits(0));
        let machine = &self.machine;
        config.cycle = S::of(machine.cycle);
        if machine.lead > 0.0 {
            config.lead = S::of(machine.lead);
        }
        if machine.start_delay >= 0.0 {
            config.start_delay = S::of(machine.start_delay);
        }
        if machine.iterations > 0 {
            config.iterations = machine.iterations;
        }
        match machine.sweeps {
            0 => {}
            11 => config.sweeps = 0,
            sweeps => config.sweeps = sweeps,
        }
        if machine.stops > 0.0 {
            let axes = self.limits::<S, N>(0);
            let axes = axes.axes().map(|mut axis| {
                axis.acceleration = axis.acceleration * S::of(machine.stops);
                axis.jerk = axis.jerk * S::of(machine.stops);
                axis
            });
            config.stop_limits = Some(Limits::new(axes).unwrap());
        }
        config
    }

    /// Servo cycles of a part if it rests at the end of every block, about.
    fn longest(&self, part: usize) -> f64 {
        let mut from = [0.0; AXES];
        let mut time = 0.0;
        for step in &self.parts[part] {
            if let Way::Dwell(seconds) = step.way {
                time += seconds;
            }
            let chords = step.way.chords(&from, &step.to).min(64);
            let mut length = 0.0;
            let mut last = from;
            for k in 1..=chords {
                let at = step.way.at(&from, &step.to, k as f64 / chords as f64);
                length += distance(&last, &at);
                last = at;
            }
            from = step.to;
            let least = |k: usize| {
                (0..self.axes)
                    .map(|i| {
                        let sets = self.machine.sets.map(|set| set[k]);
                        self.machine.axes[i][k] * sets[0].min(sets[1]).min(1.0)
                    })
                    .fold(f64::INFINITY, f64::min)
            };
            let [v, a, j] = [least(0), least(1), least(2)];
            let v = if step.feed > 0.0 { v.min(step.feed) } else { v };
            time += length / v + (32.0 * length / j).cbrt() + 2.0 * (length / a).sqrt();
        }
        time / self.machine.cycle
    }

    /// Servo cycles that a stop takes on a straight, about.
    fn stop_from<S: Scalar, const N: usize>(&self, at: &Setpoint<S, N>) -> f64 {
        let least = |k: usize| self.machine.sets.map(|set| set[k]).into_iter().fold(1.0, f64::min);
        let time = |i: usize| {
            let [_, a, j] = self.machine.axes[i];
            let (a, j) = (a * least(1), j * least(2));
            let now = at.acceleration[i].to_f64().abs();
            let v = at.velocity[i].to_f64().abs() + now * now / (2.0 * j);
            let fall = if v * j < a * a { 2.0 * (v / j).sqrt() } else { v / a + a / j };
            fall + now / j
        };
        (0..N).map(time).fold(0.0, f64::max) / self.machine.cycle
    }
}

/// What a run came to.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    cycles: u32,
    /// After the last command, beyond what it may take.
    late: f64,
    /// From a hold to its rest, as a share of what it may take.
    rests: f64,
    /// Servo cycle of the last command.
    calm: f64,
}

/// What a hold, an abort or a stop leaves in force.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Force {
    hold: bool,
    stop: bool,
    abort: bool,
    single: bool,
    feed: u16,
    rapid: u16,
}

impl Force {
    fn holds(self) -> bool {
        self.hold || self.abort || self.feed == 0 || self.rapid == 0
    }
}

fn place<S: Scalar, const N: usize>(at: &Setpoint<S, N>) -> Point {
    std::array::from_fn(|i| at.position_mm(i))
}

const STAY: f64 = 1.0e-9;

#[allow(clippy::too_many_lines)] // One servo cycle after another.
fn run<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    case: &Case,
) -> Result<Found, String> {
    let h = case.machine.cycle;
    let single = S::EPSILON.to_f64() > 1.0e-10;
    let e = if single { 3.0e-3 } else { 1.0e-3 };
    let config = case.config::<S, N>();
    let sets: Vec<[[f64; 3]; N]> = (0..3)
        .map(|set| {
            case.limits::<S, N>(set)
                .axes()
                .map(|axis| [axis.velocity, axis.acceleration, axis.jerk].map(S::to_f64))
        })
        .collect();
    let mut memory = Box::new(Reshaping::<S, N>::new());
    let mut link = Box::new(Link::<S, N, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; N]).unwrap();
    if case.reshape {
        planner.reshape(&mut memory);
    }
    let controls = planner.controls();
    let mut force =
        Force { hold: false, stop: false, abort: false, single: false, feed: 100, rapid: 100 };
    let last_press = case.presses.iter().map(|(cycle, _)| *cycle).max().unwrap_or(0);
    let ends = case.silences.iter().chain(&case.stalls).map(|gap| gap.from + gap.cycles).max();
    let calm = (last_press + 1).max(ends.unwrap_or(0));
    let slow = f64::from(case.parts.iter().map(Vec::len).sum::<usize>() as u32)
        * if case.slices > 1000 { 1.0 } else { 200.0 / f64::from(case.slices) }
        + 1000.0
        + if case.slices > 1000 { 0.0 } else { 3000.0 / f64::from(case.slices) };
    let worst = (0..case.parts.len()).map(|part| case.longest(part)).fold(0.0, f64::max);
    let most = worst * 1.5 + slow;
    let mut found = Found { calm: f64::from(calm), ..Found::default() };
    let mut part = 0;
    let shifted = |start: &Point, part: usize| -> Vec<Step> {
        let shift = |p: Point| std::array::from_fn(|i| p[i] + start[i]);
        let steps = case.parts.get(part).cloned().unwrap_or_default();
        steps
            .into_iter()
            .map(|mut step| {
                step.to = shift(step.to);
                match &mut step.way {
                    Way::Arc(centre, _) => {
                        *centre = [centre[0] + start[0], centre[1] + start[1]];
                    }
                    Way::Curve(controls) => *controls = controls.map(shift),
                    _ => {}
                }
                step
            })
            .collect()
    };
    let mut steps = shifted(&[0.0; AXES], 0);
    let mut followed = follow([0.0; AXES], &steps);
    let (mut next, mut set, mut first_tag) = (0, 0, 1u32);
    let mut before: Option<Setpoint<S, N>> = None;
    let mut tags = [0u32; 2];
    let mut most_feed = 100;
    let mut standing: Option<(Point, Force, bool)> = None;
    let mut held_since: Option<(u32, u32)> = None;
    let (mut quick, mut stop, mut settled) = (false, 0.0, None);
    let mut events: Vec<u32> = Vec::new();
    let mut dwelt = std::collections::BTreeMap::<u32, u32>::new();
    let mut progress = Progress::Planning;
    let trace = std::env::var("TRACE").ok().map(|text| {
        let mut ends = text.split(',').map(|x| x.parse::<u32>().unwrap());
        [ends.next().unwrap(), ends.next().unwrap()]
    });
    for cycle in 0..2_000_000u32 {
        found.cycles = cycle;
        for (_, press) in case.presses.iter().filter(|(when, _)| *when == cycle) {
            press.send(controls);
            match *press {
                Press::Feed(percent) => force.feed = percent,
                Press::Rapid(percent) => force.rapid = percent,
                Press::Hold => force.hold = true,
                Press::QuickHold => (force.hold, quick) = (true, true),
                Press::Resume => (force.hold, force.stop) = (false, false),
                Press::Stop => force.stop = true,
                Press::Single(on) => force.single = on,
                Press::Abort => (force.hold, force.stop, force.abort) = (false, false, true),
                Press::QuickAbort => {
                    (force.hold, force.stop, force.abort) = (false, false, true);
                    quick = true;
                }
            }
            if !matches!(press, Press::Hold | Press::QuickHold | Press::Stop) {
                standing = None;
            }
        }
        if cycle == calm {
            controls.feed_override(100);
            controls.rapid_override(100);
            controls.single_block(false);
            controls.resume();
            (force.hold, force.stop, force.single) = (false, false, false);
            (force.feed, force.rapid) = (100, 100);
            standing = None;
        }
        most_feed = most_feed.max(force.feed);
        let fail = |what: &str, of: String| Err(format!("{what}: cycle {cycle}: {of}"));
        let silent = case.silences.iter().find(|gap| gap.has(cycle));
        if case.stalls.iter().any(|gap| gap.has(cycle)) {
            // Nothing is planned.
        } else {
            let mut polls = 0;
            progress = Progress::Planning;
            while polls < case.slices && matches!(progress, Progress::Planning | Progress::Planned)
            {
                while silent.is_none()
                    && let Some(step) = steps.get(next)
                {
                    if step.set != set {
                        match planner.set_limits(case.limits(step.set)) {
                            Ok(()) => set = step.set,
                            Err(_) => break,
                        }
                    }
                    let tag = first_tag + next as u32;
                    match planner.push(&step.block(tag)) {
                        Ok(()) => next += 1,
                        Err(PushError::Full | PushError::Aborted) => break,
                        Err(refused) => return fail("refused", format!("{refused}: {step:?}")),
                    }
                    standing = None;
                }
                if silent.is_some_and(|gap| gap.finish) || next == steps.len() {
                    planner.finish();
                }
                progress = planner.poll();
                polls += 1;
                if polls > ENDLESS {
                    return fail("endless planning", String::new());
                }
            }
            if progress == Progress::Aborted && force.abort {
                if planner.acknowledge_abort() {
                    force.abort = false;
                    let end = planner.end().map(Coord::to_mm);
                    let start: Point = std::array::from_fn(|i| end.get(i).copied().unwrap_or(0.0));
                    let here = before.map_or(start, |before| place(&before));
                    if distance(&here, &start) > 1.0e-9 {
                        return fail("abort", format!("{here:?} {start:?}"));
                    }
                    first_tag += steps.len() as u32;
                    part += 1;
                    steps = shifted(&start, part);
                    // The core keeps places between nanometres.
                    followed = follow(start, &steps);
                    next = 0;
                    events.clear();
                    standing = None;
                } else if case.slices > 1000 {
                    return fail("abort", "not acknowledged".into());
                }
            }
        }
        let setpoint = interpolator.tick();
        let here = place(&setpoint);
        let idle = setpoint.activity == Activity::Idle;
        if trace.is_some_and(|[from, to]| cycle >= from && cycle < to) {
            println!(
                "{cycle} v {:.3} tag {} {:?} {progress:?} {force:?} {:?} next {next} ahead {} late {}",
                setpoint.path_speed.to_f64(),
                setpoint.tag,
                setpoint.activity,
                &here[..N],
                planner.nodes_ahead(),
                planner.counters().late
            );
        }
        // Limits.
        if setpoint.tag < tags[1] {
            return fail("tags", format!("{} after {}", setpoint.tag, tags[1]));
        }
        if setpoint.tag != tags[1] {
            tags = [tags[1], setpoint.tag];
        }
        let step_of = |tag: u32| tag.checked_sub(first_tag).and_then(|n| steps.get(n as usize));
        let near: Vec<&Step> = (tags[0].max(first_tag)..=tags[1] + 1).filter_map(step_of).collect();
        let greatest = |i: usize, k: usize| {
            let of = if near.is_empty() {
                sets.iter().map(|set| set[i][k]).fold(0.0, f64::max)
            } else {
                near.iter().map(|step| sets[step.set][i][k]).fold(0.0, f64::max)
            };
            let stop = config.stop_limits.filter(|_| quick);
            let stop = stop.map_or(0.0, |stop| {
                let axis = stop.axes()[i];
                [0.0, axis.acceleration.to_f64(), axis.jerk.to_f64()][k]
            });
            of.max(stop)
        };
        if let Some(from) = &before {
            for i in 0..N {
                let [v0, v1] = [from.velocity[i], setpoint.velocity[i]].map(S::to_f64);
                let [a0, a1] = [from.acceleration[i], setpoint.acceleration[i]].map(S::to_f64);
                let [v, a, j] = [0, 1, 2].map(|k| greatest(i, k));
                let jerk = (a1 - a0) / h;
                let used = [v1.abs() / v, a1.abs() / a, jerk.abs() / (j + 1.0e-3 * e * a / h)];
                if used.iter().any(|share| !(*share <= 1.0 + e)) {
                    return fail("limits", format!("axis {i}: {used:?}, tag {}", setpoint.tag));
                }
                let moved: f64 = setpoint.position(i).minus(from.position(i));
                let off = (moved - 0.5 * (v0 + v1) * h + (a1 - a0) * h * h / 12.0).abs();
                let grant =
                    j * h * h * h * 0.05 + if single { 1.0e-5 + 1.0e-6 * v * h } else { 2.0e-9 };
                if off > grant {
                    return fail("jump", format!("axis {i}: {off} of {grant}"));
                }
            }
            let grant = if single { 1.0e-5 } else { 1.0e-9 };
            // It is kept in tenths of a micrometre from piece to piece.
            let grant = grant + 1.1e-7;
            if setpoint.path_mm() < from.path_mm() - grant {
                let (one, other) = (from.path_mm(), setpoint.path_mm());
                return fail(
                    "back",
                    format!(
                        "{one} {other} {:?} {:?} {:?} {:?}",
                        from.activity, setpoint.activity, from.path_speed, here
                    ),
                );
            }
            let moving =
                setpoint.activity == Activity::Running && from.activity == Activity::Running;
            if moving && N < 4 {
                let feed = near.iter().map(|step| step.feed).fold(0.0, f64::max);
                let rapid = near.is_empty() || near.iter().any(|step| step.feed == 0.0);
                let most = feed * f64::from(most_feed) * 0.01;
                if !rapid && setpoint.path_speed.to_f64() > most * (1.0 + 2.0e-3) + 1.0e-6 {
                    return fail("feed", format!("{} of {most}", setpoint.path_speed.to_f64()));
                }
            }
            // Band, at the setpoint and between.
            for part in [0.25, 0.5, 0.75, 1.0] {
                let x = if part < 1.0 { between([from, &setpoint], h, part) } else { here };
                if part < 1.0
                    && from.activity != Activity::Running
                    && setpoint.activity != Activity::Running
                {
                    continue;
                }
                let (outside, block, tolerance) = followed.outside(&x);
                let share = if part < 1.0 { BETWEEN } else { ROUNDING };
                let jerk = (0..N).map(|i| greatest(i, 2)).fold(0.0, f64::max);
                let grant = tolerance * share
                    + steps.get(block).map_or(SAGITTA, |step| step.way.grant())
                    + if single { SINGLE } else { 0.0 }
                    + if part < 1.0 { jerk * h * h * h * 0.02 } else { 0.0 };
                if trace.is_some_and(|[from, to]| cycle >= from && cycle < to) {
                    println!("  {part} {x:?} outside {outside} of {tolerance} block {block}");
                }
                if outside > grant {
                    return fail(
                        "band",
                        format!(
                            "{part} block {block} (tag {}) outside {outside} of {tolerance}, grant {grant}",
                            setpoint.tag
                        ),
                    );
                }
            }
        }
        // Events and dwells.
        if setpoint.activity == Activity::Event {
            if events.last().is_some_and(|last| *last >= setpoint.tag) {
                return fail("events", format!("{} again", setpoint.tag));
            }
            events.push(setpoint.tag);
        }
        if setpoint.activity == Activity::Dwelling {
            *dwelt.entry(setpoint.tag).or_default() += 1;
        }
        // Rests.
        if let Some((at, since, aborted)) = standing {
            if !(distance(&at, &here) < STAY) || setpoint.activity == Activity::Running {
                return fail("motion", format!("{at:?} to {here:?}, {since:?} {aborted}"));
            }
        } else if idle
            && matches!(progress, Progress::Held | Progress::Done)
            && !case.stalls.iter().any(|gap| gap.has(cycle))
        {
            standing = Some((here, force, false));
        }
        if force.holds() {
            let (since, stalled) = held_since.unwrap_or((cycle, 0));
            let stalled = stalled + u32::from(case.stalls.iter().any(|gap| gap.has(cycle)));
            held_since = Some((since, stalled));
            let all = f64::from(cycle + 1 - since - stalled);
            if since == cycle {
                stop = before.map_or(0.0, |at| case.stop_from(&at));
            }
            let planned =
                if case.slices > 1000 { 0.0 } else { 400.0 / f64::from(case.slices) + 20.0 };
            let most = 2.0 * stop + 20.0 + planned;
            let rests = setpoint.activity != Activity::Running;
            if rests && settled != Some(since) {
                settled = Some(since);
                found.rests = found.rests.max(all / most);
            }
            if !rests && all > most {
                return fail("no rest", format!("{all} cycles after a hold, {most} are many"));
            }
        } else {
            held_since = None;
        }
        before = Some(setpoint);
        if cycle > calm {
            let waited = f64::from(cycle - calm);
            found.late = waited / most;
            if waited > most {
                return fail(
                    "no end",
                    format!("{waited} of {most} cycles, {progress:?}, {:?}", planner.counters()),
                );
            }
        }
        if cycle > calm && progress == Progress::Done && idle && next == steps.len() && !force.abort
        {
            let end = steps.last().map_or(followed.start(), |step| step.to);
            let off = distance(&end, &here);
            if off > 2.0e-6 {
                return fail("end", format!("{off} beside it"));
            }
            for (n, step) in steps.iter().enumerate() {
                let tag = first_tag + n as u32;
                if step.way == Way::Event && !events.contains(&tag) {
                    return fail("events", format!("{tag} is missing"));
                }
                if let Way::Dwell(seconds) = step.way {
                    let cycles = f64::from(dwelt.get(&tag).copied().unwrap_or(0));
                    if (cycles - seconds / h).abs() > 4.0 + 0.02 * seconds / h {
                        return fail("dwell", format!("{cycles} of {}, tag {tag}", seconds / h));
                    }
                }
            }
            return Ok(found);
        }
    }
    Err("no end at all".into())
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Flat,
    Large,
    Turning,
    Single,
    SingleFlat,
}

const KINDS: [Kind; 5] = [Kind::Flat, Kind::Large, Kind::Turning, Kind::Single, Kind::SingleFlat];

impl Kind {
    fn case(self, seed: u64) -> Case {
        match self {
            Self::Flat => Case::new(seed, 2, false),
            Self::Large => Case::new(seed, 3, true),
            Self::Turning => Case::new(seed, 4, false),
            Self::Single => Case::new(seed, 3, false),
            Self::SingleFlat => Case::new(seed, 2, true),
        }
    }

    fn run(self, case: &Case) -> Result<Found, String> {
        let body = || match self {
            Self::Flat => run::<f64, 2, 16, 64>(case),
            Self::Large => run::<f64, 3, 64, 256>(case),
            Self::Turning => run::<f64, 4, 16, 64>(case),
            Self::Single => run::<f32, 3, 16, 64>(case),
            Self::SingleFlat => run::<f32, 2, 32, 128>(case),
        };
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(body)).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
            Err(format!("panic: {}", text.unwrap_or_default()))
        })
    }
}

impl Kind {
    /// Whether a run ends much later after the last command than it takes in all without any, in words.
    fn lags(self, case: &Case, found: &Found) -> Option<String> {
        if case.parts.len() > 1 {
            return None;
        }
        let (presses, silences, stalls) = (Vec::new(), Vec::new(), Vec::new());
        let free = Case { presses, silences, stalls, ..case.clone() };
        let free = self.run(&free).ok()?;
        let planned = 2000.0 / f64::from(case.slices.min(100));
        let most = 1.1 * f64::from(free.cycles) + 200.0 + planned;
        let after = f64::from(found.cycles) - found.calm;
        (after > most).then(|| format!("late: {after} cycles, {} without commands", free.cycles))
    }
}

/// A smaller case that fails alike.
fn shrink(kind: Kind, mut case: Case, what: &str) -> (Case, String) {
    let alike = |text: &str| text.split(':').next() == what.split(':').next();
    let mut text = what.to_string();
    let mut tries = 0;
    loop {
        let mut changed = false;
        let mut attempt = |case: &mut Case, new: Case, text: &mut String| {
            tries += 1;
            if tries > 3000 {
                return false;
            }
            if let Err(error) = kind.run(&new)
                && alike(&error)
            {
                (*case, *text) = (new, error);
                return true;
            }
            false
        };
        for part in (0..case.parts.len()).rev() {
            let mut size = case.parts[part].len().max(1);
            while size > 0 {
                let mut at = case.parts[part].len();
                while at > 0 {
                    let from = at.saturating_sub(size);
                    let mut new = case.clone();
                    new.parts[part].drain(from..at);
                    changed |= attempt(&mut case, new, &mut text);
                    at = from;
                    at = at.min(case.parts[part].len());
                }
                size /= 2;
            }
        }
        for k in (0..case.presses.len()).rev() {
            let mut new = case.clone();
            new.presses.remove(k);
            changed |= attempt(&mut case, new, &mut text);
        }
        for k in (0..case.silences.len()).rev() {
            let mut new = case.clone();
            new.silences.remove(k);
            changed |= attempt(&mut case, new, &mut text);
        }
        for k in (0..case.stalls.len()).rev() {
            let mut new = case.clone();
            new.stalls.remove(k);
            changed |= attempt(&mut case, new, &mut text);
        }
        let mut new = case.clone();
        if new.slices < 100_000 {
            new.slices = 100_000;
            changed |= attempt(&mut case, new, &mut text);
        }
        let mut new = case.clone();
        if new.reshape {
            new.reshape = false;
            changed |= attempt(&mut case, new, &mut text);
        }
        if !changed {
            return (case, text);
        }
    }
}

/// A machine like many.
fn plain(cycle: f64) -> Machine {
    let axes = [1.0, 0.92, 0.84, 2.0].map(|share| [200.0, 2000.0, 50_000.0].map(|of| of * share));
    let sets = [[0.4, 0.5, 0.6], [0.65, 0.7, 0.25]];
    Machine {
        axes,
        cycle,
        lead: 0.0,
        start_delay: -1.0,
        iterations: 0,
        sweeps: 0,
        sets,
        stops: 0.0,
    }
}

impl Case {
    /// Some programs on a machine like many, with planning that takes no time.
    fn plain(axes: usize, cycle: f64, parts: Vec<Vec<Step>>, presses: Vec<(u32, Press)>) -> Self {
        let (silences, stalls) = (Vec::new(), Vec::new());
        let machine = plain(cycle);
        Self { axes, machine, reshape: false, slices: SLICES[0], parts, presses, silences, stalls }
    }
}

/// Lines to points in XY, in mm, at a feed and within a tolerance.
fn lines(points: &[[f64; 2]], feed: f64, tolerance: f64) -> Vec<Step> {
    let round = |x: f64| (x * 1.0e6).round() * 1.0e-6;
    let line = |[x, y]: &[f64; 2]| {
        let to = [round(*x), round(*y), 0.0, 0.0];
        Step { way: Way::Line, to, tolerance, feed, exact: false, set: 0 }
    };
    points.iter().map(line).collect()
}

/// Where the stop is shorter than nodes lie apart: on a line, and on lines as short.
#[test]
fn a_hold_comes_to_rest_however_slow_the_motion_is() {
    for feed in [0.001, 0.01, 0.3] {
        for (size, count) in [(5.0, 1), (0.001, 60)] {
            let bend = |k: u32| (f64::from(k) * 0.05).sin_cos();
            let mut at = [0.0; 2];
            let mut to = |k: u32| {
                let (sin, cos) = bend(k);
                at = [at[0] + size * feed * cos, at[1] + size * feed * sin];
                at
            };
            let points: Vec<_> =
                (0..count).map(|k| if count > 1 { to(k) } else { [5.0 * feed, 0.0] }).collect();
            for cycle in [1.0e-3, 2.0e-3] {
                let presses = [500, 700, 1100]
                    .into_iter()
                    .flat_map(|at| [(at, Press::Hold), (at + 100, Press::Resume)]);
                let steps = lines(&points, feed, 0.01);
                let case = Case::plain(2, cycle, vec![steps], presses.collect());
                for kind in [Kind::Flat, Kind::SingleFlat] {
                    let outcome = kind.run(&case);
                    assert!(outcome.is_ok(), "{kind:?}, {feed} mm/s, {size}: {outcome:?}");
                }
            }
        }
    }
}

/// A whole answer to an override is ready long before the servo cycle at which it branches off, where planning takes long: a hold does not
/// wait for that.
#[test]
fn a_hold_does_not_wait_for_an_answer_that_is_on_offer() {
    let bend = |k: u32| {
        let (sin, cos) = (f64::from(k) * 0.02).sin_cos();
        [10.0 * sin + 0.1 * (f64::from(k) * 0.2).sin(), 10.0 - 10.0 * cos]
    };
    let points: Vec<_> = (1..300).map(bend).collect();
    for (slices, feed, count) in [(4, 2.0, 100), (2, 2.0, 100), (2, 100.0, 299), (1, 2.0, 100)] {
        for wait in (20..400).step_by(40) {
            let presses = [
                (600, Press::Feed(5)),
                (900, Press::Feed(100)),
                (900 + wait, Press::Hold),
                (2500 + wait, Press::Resume),
            ];
            let parts = vec![lines(&points[..count], feed, 0.01)];
            let case = Case { slices, ..Case::plain(3, 1.0e-3, parts, presses.to_vec()) };
            let rests = Kind::Large.run(&case).map(|found| found.rests);
            let soon = rests.as_ref().is_ok_and(|rests| *rests < 0.25);
            assert!(soon, "{slices} slices, {feed} mm/s, {wait}: {rests:?}");
        }
    }
}

/// A plan ahead that waits to be reshaped does not keep the answer to an override waiting that has been raised again, nor a stop.
#[test]
fn a_plan_that_waits_to_be_reshaped_keeps_no_command_waiting() {
    let bend = |k: u32| {
        let (sin, cos) = (f64::from(k) * 0.05).sin_cos();
        [10.0 * sin, 10.0 - 10.0 * cos + 0.3 * (f64::from(k) * 0.7).sin()]
    };
    let points: Vec<_> = (1..100).map(bend).collect();
    for slices in [30, 10, 4] {
        for (when, wait) in [(100, 5), (150, 40), (200, 90), (250, 150), (300, 300), (350, 20)] {
            for press in [Press::Feed(1), Press::Stop] {
                let back =
                    if matches!(press, Press::Stop) { Press::Resume } else { Press::Feed(100) };
                let presses = vec![(when, press), (when + wait, back)];
                let parts = vec![lines(&points, 30.0, 0.02)];
                let case = Case { slices, ..Case::plain(3, 1.0e-3, parts, presses) };
                let case = Case { reshape: true, ..case };
                let found = Kind::Large.run(&case);
                let lags = found.as_ref().map(|found| Kind::Large.lags(&case, found));
                assert!(matches!(lags, Ok(None)), "{slices}, {when}, {wait}: {lags:?}, {found:?}");
            }
        }
    }
}

/// Blocks of more sets of limits than are kept are dropped: the next block may have another.
#[test]
fn limits_can_be_set_after_an_abort() {
    let points: Vec<_> = (1..8).map(|k| [5.0 * f64::from(k), 0.0]).collect();
    let mut first = lines(&points, 20.0, 0.01);
    for (step, set) in first.iter_mut().zip([0, 1, 2, 1, 2, 1, 2]) {
        step.set = set;
    }
    for set in 0..3 {
        let mut then = lines(&points, 20.0, 0.01);
        for step in &mut then {
            step.set = set;
        }
        for at in [90, 200, 400, 800] {
            let parts = vec![first.clone(), then.clone()];
            let case = Case::plain(2, 1.0e-3, parts, vec![(at, Press::Abort)]);
            let outcome = Kind::Flat.run(&case);
            assert!(outcome.is_ok(), "{set}, {at}: {outcome:?}");
        }
    }
}

/// Where limits change a joint is passed, if the band allows: of a line that a run goes on along, or comes along, it bends no more than
/// the end.
#[test]
fn a_joint_that_is_passed_beside_a_run_bends_the_end_of_its_line() {
    for (far, short) in [(14.0, 0.005), (14.0, 0.0005), (300.0, 0.005), (300.0, 0.0005)] {
        let up = 0.15;
        let points = [[short, 0.0], [short + far, far * up], [2.0 * far, 2.0 * far * up + 0.1]];
        let back = [[far, far * up + 0.1], [2.0 * far, 2.0 * far * up + 0.1]];
        let back = [back[0], back[1], [2.0 * far + short, 2.0 * far * up + 0.1]];
        for (points, sets) in [(points, [0, 2, 2]), (back, [2, 2, 0])] {
            let mut steps = lines(&points, 0.0, 0.003);
            steps.iter_mut().zip(sets).for_each(|(step, set)| step.set = set);
            let case = Case::plain(2, 1.0e-3, vec![steps], Vec::new());
            for kind in [Kind::Flat, Kind::SingleFlat] {
                let outcome = kind.run(&case);
                assert!(outcome.is_ok(), "{kind:?}, {far}, {short}, {sets:?}: {outcome:?}");
            }
        }
    }
}

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|x| x.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn everything_at_once() {
    let (first, count) = (number("FIRST", 0), number("COUNT", 6 * number("SOAK", 1)));
    let kinds: Vec<Kind> = match std::env::var("KIND").ok().and_then(|x| x.parse::<usize>().ok()) {
        Some(kind) => vec![KINDS[kind]],
        None => KINDS.to_vec(),
    };
    let mut bad = String::new();
    for seed in first..first + count {
        for kind in &kinds {
            let case = kind.case(seed);
            match kind.run(&case) {
                Ok(found) => {
                    if let Some(text) = kind.lags(&case, &found) {
                        println!(
                            "{kind:?} {seed} {} slices, reshape {} : {text}",
                            case.slices, case.reshape
                        );
                        let _ = writeln!(bad, "{kind:?} {seed}: {text}");
                    }
                    if std::env::var("SHOW").is_ok() && (found.rests > 0.5 || found.late > 0.9) {
                        println!("{kind:?} {seed} {} slices: {found:?}", case.slices);
                    }
                }
                Err(text) => {
                    println!(
                        "{kind:?} {seed} {} slices {} reshape {} : {text}",
                        case.slices, case.machine.cycle, case.reshape
                    );
                    if std::env::var("SHRINK").is_ok() {
                        let (small, text) = shrink(*kind, case, &text);
                        println!("{text}\n{small:#?}");
                    }
                    let _ = writeln!(bad, "{kind:?} {seed}: {text}");
                }
            }
        }
    }
    assert!(bad.is_empty(), "{bad}");
}
