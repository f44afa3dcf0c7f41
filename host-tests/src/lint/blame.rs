//! Whose fault a slow place is: time lost while braking and getting up to speed again counts for the line
//! on which the motion was slowest between, with what held it back there.

use anyhow::Result;
use splineway::Activity;
use splineway_simulator::machine::Axis;
use splineway_simulator::program::arc::Spiral;
use splineway_simulator::program::{Course, LETTERS, Point, Program};
use splineway_simulator::run::{Observer, Sample};
use std::collections::BTreeMap;

/// A move counts as run at its feed from this share of it on.
pub const AT_FEED: f64 = 0.98;
/// A limit counts as reached from this share of it on.
const REACHED: f64 = 0.95;
/// A place is over when the speed has risen by this share, and is about to fall again.
const RISE: f64 = 1.02;
/// Turns less than this, degrees, are no corners.
const CORNER: f64 = 1.0;

/// Turns of the path at the beginning and the end of a line, degrees; whether it ends in an exact stop.
#[derive(Clone, Copy, Debug, Default)]
struct Joints {
    turns: [f64; 2],
    stops: bool,
    dwells: bool,
}

/// A slow stretch between two faster ones.
#[derive(Clone, Copy, Debug)]
struct Valley {
    lost: f64,
    slowest: f64,
    greatest_since: f64,
    line: u32,
    /// When it was slowest, s.
    time: f64,
    limit: Option<(&'static str, usize)>,
}

/// What was lost on a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lost {
    /// Time, s.
    pub seconds: f64,
    /// Most of it at one place, s.
    most: f64,
    /// When it was slowest there, s.
    pub time: f64,
    /// Least speed there, mm/s.
    pub slowest: f64,
    /// Why.
    pub cause: String,
}

/// Collects what was lost, and why.
#[derive(Debug)]
pub struct Blame {
    cycle: f64,
    limits: Vec<Axis>,
    letters: Vec<char>,
    feeds: BTreeMap<u32, f64>,
    joints: BTreeMap<u32, Joints>,
    valley: Option<Valley>,
    before: Vec<f64>,
    lost: BTreeMap<u32, Lost>,
}

fn tangents(course: &Course, here: &Point) -> Option<[Vec<f64>; 2]> {
    let unit = |from: &Point, to: &Point| {
        let way: Vec<f64> = from.iter().zip(to).map(|(a, b)| b - a).collect();
        let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        (length > 1e-9).then(|| way.iter().map(|x| x / length).collect::<Vec<f64>>())
    };
    match course {
        Course::Line { to } => unit(here, to).map(|tangent| [tangent.clone(), tangent]),
        Course::Arc { .. } => {
            let arc = Spiral::of(course, here)?;
            let small = 1e-5;
            Some([
                unit(&arc.point(0.0), &arc.point(small))?,
                unit(&arc.point(1.0 - small), &arc.point(1.0))?,
            ])
        }
        Course::Cubic { controls: [first, second], to } => {
            let begin =
                unit(here, first).or_else(|| unit(here, second)).or_else(|| unit(here, to))?;
            let end = unit(second, to).or_else(|| unit(first, to)).or_else(|| unit(here, to))?;
            Some([begin, end])
        }
        Course::Dwell { .. } | Course::Event { .. } => None,
    }
}

fn joints(program: &Program) -> BTreeMap<u32, Joints> {
    let mut map: BTreeMap<u32, Joints> = BTreeMap::new();
    let mut here = program.start;
    let mut before: Option<(u32, Vec<f64>)> = None;
    for step in &program.moves {
        let own = map.entry(step.line).or_default();
        own.stops |= step.exact_stop;
        own.dwells |= step.path.end().is_none();
        let Some(to) = step.path.end() else { continue };
        if let Some([begin, end]) = tangents(&step.path, &here)
            && let Some((line, last)) = before.replace((step.line, end))
        {
            let cosine: f64 = last.iter().zip(&begin).map(|(a, b)| a * b).sum();
            let turn = cosine.clamp(-1.0, 1.0).acos().to_degrees();
            let own = map.entry(step.line).or_default();
            own.turns[0] = own.turns[0].max(turn);
            let other = map.entry(line).or_default();
            other.turns[1] = other.turns[1].max(turn);
        }
        here = *to;
    }
    map
}

impl Blame {
    /// For a program with the feed of every line, mm/s.
    pub fn new(program: &Program, limits: &[Axis], cycle: f64, feeds: BTreeMap<u32, f64>) -> Self {
        Self {
            cycle,
            limits: limits.to_vec(),
            letters: program.axes().into_iter().map(|axis| LETTERS[axis]).collect(),
            feeds,
            joints: joints(program),
            valley: None,
            before: vec![0.0; limits.len()],
            lost: BTreeMap::new(),
        }
    }

    /// Feed of a line, mm/s.
    pub fn feed(&self, line: u32) -> f64 {
        self.feeds.get(&line).copied().unwrap_or(f64::INFINITY)
    }

    /// What was lost on every line.
    pub fn finish(mut self) -> BTreeMap<u32, Lost> {
        self.close();
        self.lost
    }

    fn close(&mut self) {
        let Some(valley) = self.valley.take() else { return };
        let cause = self.cause(&valley);
        let entry = self.lost.entry(valley.line).or_default();
        entry.seconds += valley.lost;
        if valley.lost > entry.most {
            (entry.most, entry.cause) = (valley.lost, cause);
            (entry.time, entry.slowest) = (valley.time, valley.slowest);
        }
    }

    fn cause(&self, valley: &Valley) -> String {
        let joints = self.joints.get(&valley.line).copied().unwrap_or_default();
        let [begin, end] = joints.turns;
        let stands = valley.slowest < 1e-3 * self.feed(valley.line).min(1e3);
        if joints.dwells {
            "standstill".to_owned()
        } else if stands && joints.stops {
            "exact stop".to_owned()
        } else if begin.max(end) > CORNER {
            let (turn, place) = if end > begin { (end, "end") } else { (begin, "beginning") };
            format!("corner of {turn:.0} degrees at its {place}")
        } else if stands {
            "start, end or stop".to_owned()
        } else if let Some((what, axis)) = valley.limit {
            format!("{what} of {}", self.letters.get(axis).copied().unwrap_or('?'))
        } else {
            "neighbouring places".to_owned()
        }
    }

    /// Which limit of which axis is reached.
    fn limit(&self, sample: &Sample<'_>) -> Option<(&'static str, usize)> {
        let find = |what: &'static str, share: &dyn Fn(usize) -> f64| {
            (0..self.limits.len()).find(|&axis| share(axis) >= REACHED).map(|axis| (what, axis))
        };
        let limits = &self.limits;
        find("velocity", &|axis| sample.velocity[axis].abs() / limits[axis].velocity)
            .or_else(|| {
                find("acceleration", &|axis| {
                    sample.acceleration[axis].abs() / limits[axis].acceleration
                })
            })
            .or_else(|| {
                find("jerk", &|axis| {
                    let gain = (sample.acceleration[axis] - self.before[axis]).abs();
                    gain / self.cycle / limits[axis].jerk
                })
            })
    }
}

impl Observer for Blame {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let (feed, speed) = (self.feed(sample.tag), sample.speed);
        let limit = self.limit(sample);
        self.before.copy_from_slice(&sample.acceleration[..self.limits.len()]);
        if sample.time == 0.0 {
            return Ok(());
        }
        let running = sample.activity == Activity::Running;
        if running && speed >= AT_FEED * feed {
            self.close();
            return Ok(());
        }
        // Down again after a rise: another place.
        if let Some(valley) = &self.valley
            && speed < valley.greatest_since / RISE
            && valley.greatest_since > valley.slowest * RISE
        {
            self.close();
        }
        let fresh = Valley {
            lost: 0.0,
            slowest: f64::INFINITY,
            greatest_since: 0.0,
            line: sample.tag,
            time: sample.time,
            limit: None,
        };
        let valley = self.valley.get_or_insert(fresh);
        let kept = if feed.is_finite() && feed > 0.0 { (speed / feed).min(1.0) } else { 0.0 };
        valley.lost += self.cycle * (1.0 - kept);
        if speed < valley.slowest {
            (valley.slowest, valley.line, valley.limit) = (speed, sample.tag, limit);
            valley.time = sample.time;
            valley.greatest_since = speed;
        }
        valley.greatest_since = valley.greatest_since.max(speed);
        Ok(())
    }
}
