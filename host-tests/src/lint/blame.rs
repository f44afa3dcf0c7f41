//! Whose fault a slow place is: time lost while braking and getting up to speed again counts for the line
//! on which the motion was slowest between, with what held it back there.

use super::feeds::Asked;
use super::ledger::Ledger;
use super::{Place, Worst};
use anyhow::Result;
use splineway::Activity;
use splineway_simulator::machine::{Axis, is_rotary};
use splineway_simulator::program::{LETTERS, Tape};
use splineway_simulator::run::{Observer, Sample};

/// A move counts as run at its feed from this share of it on.
const AT_FEED: f64 = 0.98;
/// A limit counts as reached from this share of it on.
const REACHED: f64 = 0.95;
/// A place is over when the speed has risen by this share, and is about to fall again.
const RISE: f64 = 1.02;
/// Turns less than this, degrees, are no corners.
const CORNER: f64 = 1.0;

/// What holds a motion back where it begins and ends.
const ENDS: &str = "start, end or stop";

/// A slow stretch between two faster ones.
#[derive(Clone, Copy, Debug)]
struct Valley {
    lost: f64,
    slowest: f64,
    greatest_since: f64,
    line: u32,
    /// When it was slowest, s.
    time: f64,
    /// The feed there, as far as the axes allow, mm/s.
    feed: f64,
    limit: Option<(&'static str, usize)>,
    /// Whether nothing had moved before it.
    first: bool,
}

/// Collects where the time goes, what was lost, and why.
pub struct Blame<'a> {
    /// The lines of the program.
    pub ledger: Ledger<'a>,
    cycle: f64,
    limits: Vec<Axis>,
    letters: Vec<char>,
    /// Which axes turn.
    rotary: Vec<bool>,
    /// What the move under way asks for.
    asked: Asked,
    valley: Option<Valley>,
    before: Vec<f64>,
    /// Whether anything has moved.
    moved: bool,
    /// Where the time goes.
    pub times: Times,
}

/// Time, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// All.
    pub all: f64,
    /// At the feed asked for.
    pub at_feed: f64,
    /// At rest.
    pub at_rest: f64,
    /// Below the feed, as fast as the axes allow.
    pub at_limit: f64,
}

/// The places that lose most time, of a run that is over: as many as its ledger keeps.
pub fn slow_places(mut blame: Blame<'_>) -> Vec<Place> {
    blame.close();
    blame.ledger.finish().0.slowest
}

impl<'a> Blame<'a> {
    /// Of a program.
    pub fn new(program: &dyn Tape, limits: &[Axis], cycle: f64, ledger: Ledger<'a>) -> Self {
        Self {
            ledger,
            cycle,
            limits: limits.to_vec(),
            letters: program.axes().into_iter().map(|axis| LETTERS[axis]).collect(),
            rotary: program.axes().into_iter().map(is_rotary).collect(),
            asked: Asked::NOTHING,
            valley: None,
            before: vec![0.0; limits.len()],
            moved: false,
            times: Times::default(),
        }
    }

    /// What the move asks for that is under way.
    pub const fn asked(&self) -> Asked {
        self.asked
    }

    /// Speed over the axes that its feed is for, mm/s.
    fn fed(&self, sample: &Sample<'_>) -> f64 {
        if self.asked.turns || !self.rotary.contains(&true) {
            return sample.speed;
        }
        let linear = self.rotary.iter().zip(sample.velocity).filter(|(rotary, _)| !**rotary);
        linear.map(|(_, velocity)| velocity * velocity).sum::<f64>().sqrt()
    }

    /// The end of the run.
    pub fn close(&mut self) {
        self.leave(true);
    }

    /// A place is over; `last`: so is the run.
    fn leave(&mut self, last: bool) {
        let Some(valley) = self.valley.take() else { return };
        let cause = self.cause(&valley, last);
        let line = self.ledger.line(valley.line);
        line.place.lost += valley.lost;
        if valley.lost > line.place.worst.lost {
            let Valley { lost, time, slowest, feed, .. } = valley;
            line.place.worst = Worst { lost, time, slowest };
            line.place.feed = feed;
            line.place.cause = cause;
        }
    }

    fn cause(&mut self, valley: &Valley, last: bool) -> String {
        let line = self.ledger.line(valley.line);
        let [begin, end] = line.turns;
        let stands = valley.slowest < 1e-3 * valley.feed.min(1e3);
        if line.dwells {
            "standstill".to_owned()
        } else if stands && line.stops {
            "exact stop".to_owned()
        } else if valley.first || last && stands {
            // Whatever corners its line has: the time was lost at its other end.
            ENDS.to_owned()
        } else if begin.max(end) > CORNER {
            let (turn, place) = if end > begin { (end, "end") } else { (begin, "beginning") };
            format!("corner of {turn:.0} degrees at its {place}")
        } else if stands {
            ENDS.to_owned()
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

impl Observer for Blame<'_> {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let limit = self.limit(sample);
        self.before.copy_from_slice(&sample.acceleration[..self.limits.len()]);
        if sample.time == 0.0 {
            return Ok(());
        }
        let cycle = self.cycle;
        let running = sample.activity == Activity::Running;
        if !self.moved && !running && sample.tag == 0 {
            // No line of the program yet.
            self.times.all += cycle;
            self.times.at_rest += cycle;
            return Ok(());
        }
        self.asked = self.ledger.asked(sample);
        let (feed, speed) = (self.asked.possible(), self.fed(sample));
        let place = &mut self.ledger.line(sample.tag).place;
        place.time += cycle;
        place.slowest = place.slowest.min(speed);
        let reaches = |feed: f64| speed >= AT_FEED * feed;
        let Times { all, at_feed, at_rest, at_limit } = &mut self.times;
        *all += cycle;
        if !running {
            *at_rest += cycle;
        } else if reaches(self.asked.wanted) {
            *at_feed += cycle;
        } else if reaches(feed) {
            *at_limit += cycle;
        }
        if running && reaches(feed) {
            self.leave(false);
        } else {
            self.lose(sample, speed, limit);
        }
        self.moved |= sample.speed > 0.0;
        let open = self.valley.map_or(u32::MAX, |valley| valley.line);
        self.ledger.retire(open.min(sample.tag));
        Ok(())
    }
}

impl Blame<'_> {
    /// A cycle below the feed.
    fn lose(&mut self, sample: &Sample<'_>, speed: f64, limit: Option<(&'static str, usize)>) {
        let feed = self.asked.possible();
        // Down again after a rise: another place.
        if let Some(valley) = &self.valley
            && speed < valley.greatest_since / RISE
            && valley.greatest_since > valley.slowest * RISE
        {
            self.leave(false);
        }
        let fresh = Valley {
            lost: 0.0,
            slowest: f64::INFINITY,
            greatest_since: 0.0,
            line: sample.tag,
            time: sample.time,
            feed,
            limit: None,
            first: !self.moved,
        };
        let valley = self.valley.get_or_insert(fresh);
        let kept = if feed.is_finite() && feed > 0.0 { (speed / feed).min(1.0) } else { 0.0 };
        valley.lost += self.cycle * (1.0 - kept);
        if speed < valley.slowest {
            (valley.slowest, valley.line, valley.limit) = (speed, sample.tag, limit);
            (valley.time, valley.feed) = (sample.time, feed);
            valley.greatest_since = speed;
        }
        valley.greatest_since = valley.greatest_since.max(speed);
    }
}
