//! The rules of a run, held against every servo cycle, every command and every answer.

use super::bound::{braking_time, stop_time};
use super::setting::Setting;

use super::path::Path;
use splineway::wire::Command;
use splineway::{Activity, Coord, Progress};
use splineway_simulator::program::{AXES, Course, Move, Point, Speed};
use std::collections::VecDeque;

/// Where notes go as they are made.
pub type Print = fn(&str);

/// Which rule was broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // The findings say it in words.
pub enum Rule {
    Velocity,
    Acceleration,
    Jerk,
    Jump,
    Band,
    Backwards,
    Tag,
    Uncalled,
    Standing,
    HoldLate,
    AbortLate,
    StopLate,
    Feed,
    Held,
    AbortTaken,
    Dwell,
    Event,
    Point,
    End,
    TooLong,
    Slow,
    Refused,
    Panic,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Which rule.
    pub rule: Rule,
    /// In words.
    pub text: String,
    /// At which servo cycle.
    pub cycle: u64,
}

/// One servo cycle.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Units of 1e-12 mm.
    pub raw: [i64; AXES],
    /// mm/s.
    pub velocity: Point,
    /// mm/s2.
    pub acceleration: Point,
    /// Greatest offset from a piece's origin, mm: what the rounding is a share of.
    pub offset: f64,
    /// Path, mm.
    pub path: f64,
    /// mm/s.
    pub speed: f64,
    /// Block.
    pub tag: u32,
    /// What the interpolator does.
    pub activity: Activity,
}

/// Looseness of limits, per scalar: velocity and acceleration, jerk.
const LOOSE: [(f64, f64); 2] = [(1.002, 1.006), (1.0005, 1.001)];
/// Share of J h^3 by which the integral of a cycle may miss its Hermite quadrature: the integral of
/// |s^2 - s + 1/6| / 2 over 0 to 1 is 0.032.
const KERNEL: f64 = 0.033;
/// How exactly a rest that the program asks for is met, in 1e-12 mm.
const EXACT: i64 = 510_000;
/// Times that braking may take.
const BRAKINGS: f64 = 10.0;
/// Times that a run may take what it would with a stop after every block.
const STOPS: f64 = 1.3;
/// Answers that are due at once may take so many polls.
const POLLS: u32 = 24;
/// Of them, those that begin at rest.
const RESTED: u32 = 2;
/// Happenings that are kept for a report.
const KEPT: usize = 24;

/// What is known of a block that was taken.
#[derive(Clone, Debug)]
struct Taken {
    tag: u32,
    time: f64,
    /// Cycles of a dwell, and how many have been seen.
    dwell: Option<f64>,
    seen: u32,
    /// Whether it is an event, and whether that has been seen.
    event: bool,
    pause: bool,
    /// Where it ends.
    end: [i64; AXES],
    feed: f64,
}

/// A command in force: for how long, in cycles and in polls.
#[derive(Clone, Copy, Debug, Default)]
struct Since {
    cycles: u32,
    polls: u32,
    /// s, from the speed at which it was given.
    bound: f64,
    /// Whether it was given while the background was late: what has been planned by then takes effect as late.
    rough: bool,
    /// So many times as long as at programmed speed a block may have taken meanwhile.
    slow: f64,
}

/// Watches a run.
#[derive(Debug)]
pub struct Referee {
    setting: Setting,
    double: bool,
    path: Path,
    taken: VecDeque<Taken>,
    /// Blocks before the present one; first block after an abort.
    passed: usize,
    first: u32,
    last: Sample,
    cycle: u64,
    idle: u32,
    /// Polls in a row that began at rest: one that began before says what it found then.
    rested: u32,
    /// The hold's key is down.
    key: bool,
    hold: Option<Since>,
    held: bool,
    /// A pause has come.
    pause: bool,
    abort: Option<Since>,
    /// An abort was given while one was acknowledged.
    vague: bool,
    stop: Option<Since>,
    overrides: (u16, u16),
    since_feed: u32,
    /// Rests that must last: by the command that is in force, by an abort, at the end.
    dropped: bool,
    done: bool,
    presses: u64,
    presses_at_poll: u64,
    /// Cycles and bound since which the run must come to its end, s.
    deadline: Option<(u64, f64)>,
    /// The background is late.
    rough: bool,
    log: VecDeque<String>,
    print: Option<Print>,
    /// What was found first.
    pub finding: Option<Finding>,
}

impl Referee {
    /// A referee of a machine at rest.
    pub fn new(setting: &Setting, rough: bool, print: Option<Print>) -> Self {
        let raw =
            setting.start.map(|mm| Coord::from_mm(mm).expect("cases start within the range").raw());
        Self {
            double: setting.is_double(),
            path: Path::new(setting.start, setting.axes.len(), setting.is_double()),
            setting: setting.clone(),
            taken: VecDeque::new(),
            passed: 0,
            first: 0,
            last: Sample {
                raw,
                velocity: [0.0; AXES],
                acceleration: [0.0; AXES],
                offset: 0.0,
                path: 0.0,
                speed: 0.0,
                tag: 0,
                activity: Activity::Idle,
            },
            cycle: 0,
            idle: 1,
            rested: 0,
            key: false,
            hold: None,
            held: false,
            pause: false,
            abort: None,
            vague: false,
            stop: None,
            overrides: (100, 100),
            since_feed: 0,
            dropped: false,
            done: false,
            presses: 0,
            presses_at_poll: 0,
            deadline: None,
            rough,
            log: VecDeque::new(),
            print,
            finding: None,
        }
    }

    /// Servo cycles seen.
    pub fn cycles(&self) -> u64 {
        self.cycle
    }

    /// What happened last.
    pub fn log(&self) -> impl Iterator<Item = &String> {
        self.log.iter()
    }

    /// The last setpoint.
    pub fn last(&self) -> &Sample {
        &self.last
    }

    /// Where the blocks taken so far end.
    pub fn path_end(&self) -> &Point {
        self.path.end()
    }

    /// Whether the motion rests.
    pub fn rests(&self) -> bool {
        self.idle > 0
    }

    /// Time of all blocks taken with a stop after every one, s.
    pub fn stops(&self) -> f64 {
        self.taken.iter().map(|taken| taken.time).sum()
    }

    #[allow(clippy::needless_pass_by_value)] // Made where it is noted.
    fn note(&mut self, text: String) {
        let line = format!("{}: {text}", self.cycle);
        if let Some(print) = self.print {
            print(&line);
        }
        if self.log.len() == KEPT {
            self.log.pop_front();
        }
        self.log.push_back(line);
    }

    /// Notes that a rule was broken; the first finding counts.
    pub fn find(&mut self, rule: Rule, text: String) {
        if self.finding.is_none() {
            self.note(format!("{rule:?}: {text}"));
            self.finding = Some(Finding { rule, text, cycle: self.cycle });
        }
    }

    /// A block was taken; `excused` if an abort was given while it was pushed.
    pub fn take(&mut self, step: &Move, tag: u32, end: [i64; AXES], excused: bool) {
        let Setting { tolerance, axes, .. } = &self.setting;
        let (tolerance, count) = (step.tolerance.unwrap_or(*tolerance), axes.len());
        let time = stop_time(self.path.end(), step, &self.setting);
        self.path.append(&step.path, tolerance, tag);
        for n in 0..count {
            let off = (end[n] as f64 * 1.0e-12 - self.path.end()[n]).abs();
            if off > 1.02e-6 {
                self.find(
                    Rule::End,
                    format!("block {tag}: the core ends it {off:e} mm off on axis {n}"),
                );
            }
        }
        let dwell = match step.path {
            Course::Dwell { seconds } => Some(seconds / self.setting.cycle),
            _ => None,
        };
        let feed = match step.speed {
            Speed::PerSecond(feed) => feed,
            _ => f64::INFINITY,
        };
        let event = matches!(step.path, Course::Event { .. });
        let pause = matches!(step.path, Course::Event { pause: true, .. });
        self.taken.push_back(Taken { tag, time, dwell, seen: 0, event, pause, end, feed });
        (self.done, self.dropped) = (false, false);
        if self.abort.is_some() && !self.vague && !excused {
            self.find(Rule::AbortTaken, format!("block {tag} was taken after an abort"));
        }
        if self.vague && !excused {
            // It was a part of the abort that was acknowledged.
            (self.abort, self.vague) = (None, false);
        }
        self.note(format!("block {tag} taken: {:?} {:?}", step.path, step.speed));
    }

    fn bound(&self) -> f64 {
        let Setting { cycle, .. } = self.setting;
        BRAKINGS * braking_time(&self.setting, self.speed()) + 20.0 * cycle + 0.01
    }

    fn speed(&self) -> f64 {
        self.last.velocity.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    /// Whether the motion is to be held.
    fn holds(&self) -> bool {
        self.key || self.overrides.0 == 0 || self.overrides.1 == 0
    }

    /// A command is about to be given: from now on it may be obeyed.
    pub fn presses(&mut self, action: Command) {
        self.presses += 1;
        let held = self.holds();
        match action {
            Command::Resume | Command::Abort => {
                (self.key, self.held, self.stop, self.pause) = (false, false, None, false);
            }
            Command::FeedOverride(percent) if percent > 0 => self.overrides.0 = percent,
            Command::RapidOverride(percent) if percent > 0 => self.overrides.1 = percent,
            _ => {}
        }
        if held && !self.holds() {
            (self.hold, self.held) = (None, false);
        }
    }

    /// A command has been given: from now on it must be obeyed.
    pub fn pressed(&mut self, action: Command) {
        self.presses += 1;
        let since = Since { bound: self.bound(), rough: self.rough, slow: 1.0, ..Since::default() };
        match action {
            Command::Hold => self.key = true,
            Command::FeedOverride(0) => self.overrides.0 = 0,
            Command::RapidOverride(0) => self.overrides.1 = 0,
            Command::Abort => self.abort = Some(self.abort.unwrap_or(since)),
            Command::Stop => self.stop = Some(self.stop.unwrap_or(since)),
            _ => {}
        }
        if self.holds() {
            self.hold.get_or_insert(since);
        }
        self.since_feed = 0;
        self.note(format!("{action:?} at {:.3} mm/s, block {}", self.speed(), self.last.tag));
    }

    /// The planner is about to be called.
    pub fn polls(&mut self) {
        self.presses_at_poll = self.presses;
        self.rested = if self.idle > 0 { self.rested + 1 } else { 0 };
    }

    /// The planner has answered.
    pub fn polled(&mut self, progress: Progress) {
        let calm = self.presses == self.presses_at_poll;
        for since in [&mut self.hold, &mut self.stop, &mut self.abort].into_iter().flatten() {
            if calm {
                since.polls += 1;
            }
        }
        let rests = self.idle > 0;
        match progress {
            Progress::Held if calm => {
                if !rests {
                    self.find(Rule::Held, "said to be held while in motion".to_owned());
                }
                if !self.held {
                    self.note("held".to_owned());
                }
                (self.held, self.stop) = (true, None);
            }
            Progress::Aborted if self.abort.is_none() && calm => {
                self.find(Rule::Held, "said to be aborted, but nobody asked for it".to_owned());
            }
            Progress::Done if calm => {
                if self.hold.is_some_and(|since| since.polls > POLLS) {
                    self.find(Rule::Held, "said to be done while held".to_owned());
                }
                if self.stop.is_some_and(|since| since.polls > POLLS) && rests {
                    self.find(Rule::StopLate, "done, and a stop was lost".to_owned());
                }
                if rests && !self.done {
                    self.note("done".to_owned());
                    self.done = true;
                    self.check_end();
                }
            }
            _ => {}
        }
        let waits = self.idle > POLLS && self.rested > RESTED;
        if waits
            && self.abort.is_none()
            && self.hold.is_some_and(|since| since.polls > POLLS)
            && progress != Progress::Held
        {
            self.find(Rule::Held, format!("at rest and held, but said to be {progress:?}"));
        }
        if let Some(since) = self.abort
            && since.polls > POLLS
            && waits
            && progress != Progress::Aborted
        {
            self.find(
                Rule::AbortLate,
                format!("at rest after an abort, but said to be {progress:?}"),
            );
        }
    }

    /// The end of an abort is known, and acknowledged: the machine stands here. `given` says that another
    /// abort was given meanwhile.
    pub fn acknowledge(&mut self, end: [i64; AXES], given: bool) {
        self.note(format!("abort acknowledged{}", if given { ", another given" } else { "" }));
        let count = self.setting.axes.len();
        for n in 0..count {
            let off = (end[n] - self.last.raw[n]).abs();
            if off > EXACT {
                let text =
                    format!("after an abort axis {n} stands {:e} mm off", off as f64 * 1e-12);
                self.find(Rule::End, text);
            }
        }
        if self.idle == 0 {
            self.find(Rule::AbortLate, "an abort was complete before the motion rested".to_owned());
        }
        (self.abort, self.vague) = if given { (self.abort, true) } else { (None, false) };
        let start = end.map(|raw| raw as f64 * 1.0e-12);
        self.path = Path::new(start, count, self.double);
        self.taken.clear();
        // What is still to come now starts here.
        self.deadline = None;
        (self.passed, self.dropped, self.done) = (0, true, false);
        self.first = self.first.max(self.last.tag + 1);
    }

    /// Blocks from here on are new.
    pub fn starts_at(&mut self, tag: u32) {
        self.first = tag;
    }

    /// A block is refused: the next is another one, from where the last one ends that was taken, and may take longer.
    pub fn refused(&mut self) {
        self.deadline = None;
    }

    /// Whether the run has to come to an end by a time.
    pub fn is_released(&self) -> bool {
        self.deadline.is_some()
    }

    /// From now on nothing is pressed, blocks come as fast as they are taken, and the background is in time:
    /// the run has to come to an end.
    ///
    /// `blocks_to_come` is their time with a stop after every one, s.
    pub fn release(&mut self, blocks_to_come: f64) {
        if self.deadline.is_none() {
            let Setting { cycle, lead, start_delay, .. } = self.setting;
            let left: f64 = self.taken.iter().skip(self.passed).map(|taken| taken.time).sum();
            let pauses = 200.0 * cycle;
            let bound = STOPS * (left + blocks_to_come)
                + self.bound()
                + 2.0 * BRAKINGS * braking_time(&self.setting, 0.0)
                + 5.0 * lead
                + start_delay
                + pauses;
            self.deadline = Some((self.cycle, bound));
            self.rough = false;
            self.note(format!("released; the rest may take {bound:.3} s"));
        }
    }

    /// One more servo cycle.
    pub fn tick(&mut self, sample: &Sample) {
        self.cycle += 1;
        self.since_feed += 1;
        let moves = sample.activity != Activity::Idle;
        self.check_steps(sample);
        self.check_rest(sample, moves);
        self.check_tag(sample, moves);
        if moves || self.cycle < 3 || self.idle < 2 {
            self.check_band(sample);
        }
        if !moves && self.idle == 0 && self.print.is_some() {
            self.note(format!("rests at {:.6?}", &sample.raw[..self.setting.axes.len()]));
        } else if moves && self.idle > 0 && self.print.is_some() {
            self.note("moves".to_owned());
        }
        self.idle = if moves { 0 } else { self.idle + 1 };
        self.check_times(sample);
        self.last = *sample;
    }

    /// Limits, and whether positions, velocities and accelerations are derivatives of each other.
    fn check_steps(&mut self, now: &Sample) {
        let (h, before) = (self.setting.cycle, self.last);
        let (loose, loose_jerk) = LOOSE[usize::from(self.double)];
        let epsilon = if self.double { f64::EPSILON } else { f64::from(f32::EPSILON) };
        for n in 0..self.setting.axes.len() {
            let limit = self.setting.axes[n];
            let (v0, v1) = (before.velocity[n], now.velocity[n]);
            let (a0, a1) = (before.acceleration[n], now.acceleration[n]);
            if !(v1.abs() <= limit.velocity * loose) {
                let text = format!("axis {n} at {:.5} of its velocity", v1.abs() / limit.velocity);
                self.find(Rule::Velocity, text);
            }
            if !(a1.abs() <= limit.acceleration * loose) {
                let text =
                    format!("axis {n} at {:.5} of its acceleration", a1.abs() / limit.acceleration);
                self.find(Rule::Acceleration, text);
            }
            let noise = 16.0 * epsilon * limit.acceleration;
            let jerk = (a1 - a0).abs() / h;
            if !(jerk <= limit.jerk * loose_jerk + noise / h) {
                let text = format!("axis {n} at {:.5} of its jerk", jerk / limit.jerk);
                self.find(Rule::Jerk, text);
            }
            let gain = (v1 - v0 - h * (a0 + a1) / 2.0).abs();
            let noise = 16.0 * epsilon * (limit.velocity + h * limit.acceleration);
            if !(gain <= 0.26 * limit.jerk * h * h + noise) {
                self.find(Rule::Jump, format!("axis {n}: its velocity jumps by {gain:e} mm/s"));
            }
            let step = (now.raw[n] - before.raw[n]) as f64 * 1.0e-12;
            let miss = (step - h * (v0 + v1) / 2.0 - h * h * (a0 - a1) / 12.0).abs();
            let noise = 4.0 * epsilon * (before.offset + now.offset)
                + 16.0 * epsilon * h * (v0.abs() + v1.abs() + h * limit.acceleration);
            // In `f32` two nanometres: what pieces of a stop that are shorter than a cell are rounded by, at most as seen so far.
            let floor = if self.double { 1.0e-9 } else { 2.0e-6 };
            if !(miss <= KERNEL * limit.jerk * h * h * h + noise + floor) {
                self.find(Rule::Jump, format!("axis {n}: its position jumps by {miss:e} mm"));
            }
        }
        let back = before.path - now.path;
        // The path is kept to less than two tenths of a nanometre, and in `f32` to half of one: terms of a piece that slows down cancel, and
        // what is left of their rounding is more than that of the offset, at a rest as where the motion goes on from it.
        let floor = if self.double { 2.0e-7 } else { 5.0e-7 };
        let noise = floor + 4.0 * epsilon * (before.offset + now.offset);
        let fastest = self.setting.axes.iter().map(|axis| axis.velocity).fold(0.0, f64::max);
        if !(back <= noise) || !(now.speed >= -8.0 * epsilon * fastest) {
            let text = format!("the path runs back by {back:e} mm, at {:e} mm/s", now.speed);
            self.find(Rule::Backwards, text);
        }
    }

    /// Rests that must last.
    fn check_rest(&mut self, now: &Sample, moves: bool) {
        let count = self.setting.axes.len();
        let shifted = now.raw[..count] != self.last.raw[..count];
        if !(moves || shifted) {
            return;
        }
        if shifted && !moves && self.idle > 0 {
            self.find(Rule::Uncalled, "moves while idle".to_owned());
        }
        if self.idle == 0 {
            return;
        }
        let held = self.hold.is_some_and(|since| since.polls >= 2 && since.cycles > 0);
        let aborted = self.abort.is_some_and(|since| since.polls >= 2);
        let why = if held {
            "a hold in force"
        } else if self.held {
            "a stop in force"
        } else if aborted {
            "an abort in force"
        } else if self.dropped {
            "nothing pushed since an abort"
        } else if self.done {
            "everything done"
        } else if self.taken.is_empty() {
            "nothing pushed"
        } else {
            return;
        };
        self.find(Rule::Standing, format!("starts from rest with {why}"));
    }

    /// Blocks come in order, every dwell and event as it should.
    fn check_tag(&mut self, now: &Sample, moves: bool) {
        if !moves {
            return;
        }
        let last = self.taken.back().map_or(0, |taken| taken.tag);
        if now.tag < self.first || now.tag > last {
            let text = format!("moves for block {}, of {} to {last}", now.tag, self.first);
            self.find(Rule::Tag, text);
            return;
        }
        if let Some(present) = self.taken.get(self.passed)
            && now.tag < present.tag
        {
            let text = format!("block {} runs after block {}", now.tag, present.tag);
            self.find(Rule::Tag, text);
        }
        while self.taken.get(self.passed).is_some_and(|taken| taken.tag < now.tag) {
            self.leave();
        }
        let Some(present) = self.taken.get_mut(self.passed) else { return };
        let (dwells, tag) = (present.dwell.is_some(), present.tag);
        let is_event = now.activity == Activity::Event;
        let stands = now.activity == Activity::Dwelling || is_event;
        present.seen += u32::from(is_event || (stands && dwells));
        let twice = is_event && present.seen > 1;
        // An event lasts two cycles, of which it is said in one.
        let wrong = (is_event && !present.event) || stands != (dwells || present.event);
        let (event, end, pause) = (present.event, present.end, present.pause);
        if self.pause && !stands {
            self.find(Rule::Event, "runs on through a pause".to_owned());
        }
        self.pause |= pause && is_event;
        if twice {
            self.find(Rule::Event, format!("event {tag} comes twice"));
        }
        if wrong && (stands || event) {
            let text = format!(
                "{:?} in block {tag}, which is {}",
                now.activity,
                if dwells {
                    "a dwell"
                } else if event {
                    "an event"
                } else {
                    "a move"
                }
            );
            self.find(Rule::Event, text);
        }
        if stands {
            self.check_place(now, &end, tag);
        }
    }

    /// A block is over.
    fn leave(&mut self) {
        let Some(taken) = self.taken.get(self.passed).cloned() else { return };
        self.passed += 1;
        let Taken { tag, seen, .. } = taken;
        if let Some(cycles) = taken.dwell {
            let off = f64::from(seen) - cycles;
            // A dwell that was held goes on in parts.
            if off.abs() > 2.0 && (off < 0.0 || self.parts() < off) {
                self.find(Rule::Dwell, format!("dwell {tag} of {cycles:.1} cycles takes {seen}"));
            }
        }
        if taken.event && seen != 1 {
            self.find(Rule::Event, format!("event {tag} came {seen} times"));
        }
    }

    /// Cycles that a dwell may take longer because it was held.
    fn parts(&self) -> f64 {
        2.0 + 2.0 * self.presses as f64
    }

    fn check_place(&mut self, now: &Sample, end: &[i64; AXES], tag: u32) {
        for n in 0..self.setting.axes.len() {
            let off = now.raw[n] - end[n];
            if off.abs() > EXACT {
                let text = format!("block {tag}: axis {n} stands {:e} mm off", off as f64 * 1e-12);
                self.find(Rule::Point, text);
            }
        }
    }

    fn check_band(&mut self, now: &Sample) {
        let count = self.setting.axes.len();
        let x: Point = std::array::from_fn(|n| now.raw[n] as f64 * 1.0e-12);
        let step = (0..count).map(|n| (now.raw[n] - self.last.raw[n]) as f64 * 1.0e-12);
        let step = step.map(|x| x * x).sum::<f64>().sqrt();
        let reach = 20.0 * self.setting.tolerance + 0.02 + 2.0 * step;
        let off = self.path.follow(&x, reach);
        if off.excess > 0.0 {
            let text = format!(
                "{:.7} mm from the path near block {}, where {:.7} is allowed",
                off.distance, off.tag, off.band
            );
            self.find(Rule::Band, text);
        }
    }

    /// Commands are answered in time, and the run ends in time.
    fn check_times(&mut self, now: &Sample) {
        let h = self.setting.cycle;
        let stops = self.stops();
        let late_plans = 2.0 * STOPS * stops + 3.0 * self.setting.lead + 0.6;
        let rests = self.idle > 0;
        let slow = 100.0 / f64::from(self.overrides.0.min(self.overrides.1).max(1));
        let longest = self.taken.iter().map(|taken| taken.time).fold(0.0, f64::max);
        let mut late = None;
        let moves_on = [
            (&mut self.hold, Rule::HoldLate, "a hold", 0.0),
            (&mut self.abort, Rule::AbortLate, "an abort", 0.0),
            (&mut self.stop, Rule::StopLate, "a stop", 4.0 * longest + 0.2 * stops),
        ];
        for (since, rule, name, more) in moves_on {
            let Some(since) = since else { continue };
            // A poll may take as long as it likes; the next must answer.
            let counts = !self.rough || since.polls > 0;
            let (loose, extra) = if since.rough { (3.0, late_plans) } else { (1.0, 0.0) };
            since.cycles += u32::from(counts);
            since.slow = since.slow.max(slow);
            let time = f64::from(since.cycles) * h;
            if !rests && time > loose * (since.bound + more * since.slow) + extra {
                late = Some((rule, format!("{name} has not been obeyed after {time:.4} s")));
            }
        }
        if let Some((rule, text)) = late {
            self.find(rule, text);
        }
        let most = self.taken.iter().map(|taken| taken.feed).fold(0.0, f64::max);
        let settled = f64::from(self.since_feed) * h > 2.0 * self.bound();
        if !self.rough && settled && most.is_finite() && self.overrides.0 > 0 {
            let linear = self.setting.axes.len().min(self.setting.rotary_from);
            let speed = now.velocity[..linear].iter().map(|v| v * v).sum::<f64>().sqrt();
            let asked = most * f64::from(self.overrides.0) * 0.01;
            if speed > asked * 1.02 + 1.0e-6 {
                self.find(Rule::Feed, format!("{speed:.4} mm/s, {asked:.4} are asked for"));
            }
        }
        if let Some((from, bound)) = self.deadline {
            let time = (self.cycle - from) as f64 * h;
            if time > bound {
                let text = format!(
                    "not done after {time:.3} s; block {}, {:e} mm/s, {:?}, {:.6} mm left",
                    now.tag,
                    now.speed,
                    now.activity,
                    self.path.left()
                );
                self.find(Rule::TooLong, text);
            }
        }
    }

    /// At the end of everything.
    fn check_end(&mut self) {
        let Some(taken) = self.taken.back().cloned() else { return };
        while self.passed < self.taken.len() {
            self.leave();
        }
        let last = self.last;
        self.check_place(&last, &taken.end, taken.tag);
        if !self.path.is_done(0.02) {
            let text = format!("done {:.6} mm before the end of the path", self.path.left());
            self.find(Rule::End, text);
        }
    }
}
