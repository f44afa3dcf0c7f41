//! How long a run may take: what it would take with a stop after every move, and something for every
//! command. A run that takes longer crawls, or does not end at all.

use crate::machine::{Axis, Machine, MotorRow, is_rotary};
use crate::program::arc::Spiral;
use crate::program::{Course, Move, Point, Program, Speed, Tape, on_cubic};
use crate::scurve::{Leg, Limit};
use anyhow::Result;
use std::collections::VecDeque;

/// A run may take this much more than with stops.
pub const SHARE: f64 = 1.25;

/// Shares of acceleration and of jerk that are left along an arc, where the way around takes the rest:
/// both at once stay within the limits of an axis at any angle.
const ROUND: (f64, f64) = (0.7, 0.5);

/// Pieces into which a curve is cut at most.
const FINEST: usize = 64;

/// What the moves of a program take from rest to rest, one by one.
///
/// Legs of seven phases within every axis's limits, in closed form, with nothing of the core in them.
pub struct Stops<'a> {
    moves: Moves<'a>,
    /// Whether lines come in order, so that they tell how far a run has come.
    ordered: bool,
    /// All of the program, s; of one in order that is gone through, it is not known before its end.
    whole: f64,
    allowance: f64,
}

/// Where the times come from.
enum Moves<'a> {
    /// Line of each move, and the time up to its end, s.
    List(Vec<(u32, f64)>),
    /// They are worked out again whenever they are wanted.
    Tape(&'a dyn Tape, &'a Machine),
}

/// Times up to the ends of moves, s, with their lines.
struct Ends<'a> {
    steps: Box<dyn Iterator<Item = Move> + 'a>,
    axes: Vec<usize>,
    limits: Vec<Axis>,
    motors: Vec<MotorRow>,
    here: Point,
    time: f64,
}

impl<'a> Ends<'a> {
    fn new(program: &'a dyn Tape, machine: &Machine) -> Result<Self> {
        let mut limits = machine.axes_of(program)?;
        let motors = machine.motors_for(program);
        limits.extend(motors.iter().map(|motor| motor.limits));
        let (axes, here) = (program.axes(), program.start());
        Ok(Self { steps: program.steps(), axes, limits, motors, here, time: 0.0 })
    }
}

impl Iterator for Ends<'_> {
    type Item = (u32, f64);

    fn next(&mut self) -> Option<(u32, f64)> {
        let step = self.steps.next()?;
        self.time += duration(&step, &self.here, &self.axes, (&self.limits, &self.motors));
        if let Some(to) = step.path.end() {
            self.here = *to;
        }
        Some((step.line, self.time))
    }
}

impl<'a> Stops<'a> {
    /// Of a program on a machine.
    ///
    /// # Errors
    /// The machine lacks an axis.
    pub fn new(program: &Program, machine: &Machine) -> Result<Self> {
        let list: Vec<(u32, f64)> = Ends::new(program, machine)?.collect();
        let whole = list.last().map_or(0.0, |(_, time)| *time);
        let ordered = list.is_sorted_by_key(|(line, _)| *line);
        let allowance = allowance(program, machine)?;
        Ok(Self { moves: Moves::List(list), ordered, whole, allowance })
    }

    /// Of a program that is gone through, so that its length takes no room. [`Stops::whole`] and [`Stops::left`] are not known of it.
    ///
    /// # Errors
    /// The machine lacks an axis.
    pub fn passing(program: &'a dyn Tape, machine: &'a Machine) -> Result<Self> {
        let ordered = program.summary().is_ordered;
        let ends = Ends::new(program, machine)?;
        let whole = if ordered { 0.0 } else { ends.last().map_or(0.0, |(_, time)| time) };
        let allowance = allowance(program, machine)?;
        Ok(Self { moves: Moves::Tape(program, machine), ordered, whole, allowance })
    }

    /// All of the program, s.
    pub fn whole(&self) -> f64 {
        self.whole
    }

    /// What is left from the beginning of a line on, s; all if lines do not tell.
    pub fn left(&self, line: u32) -> f64 {
        self.whole() - self.before(line)
    }

    /// What a command may cost beyond, s: a stop from full speed, and getting there again. The start
    /// may cost as much.
    pub fn allowance(&self) -> f64 {
        self.allowance
    }

    fn before(&self, line: u32) -> f64 {
        let Moves::List(ends) = &self.moves else { return 0.0 };
        let first = ends.partition_point(|(other, _)| *other < line);
        if self.ordered && first > 0 { ends[first - 1].1 } else { 0.0 }
    }
}

/// Braking and getting up to speed again, and the planner's part of it; the start waits for blocks.
fn allowance(program: &dyn Tape, machine: &Machine) -> Result<f64> {
    let change = |axis: &Axis| axis.velocity / axis.acceleration + axis.acceleration / axis.jerk;
    let axes = machine.axes_of(program)?;
    let motors = machine.motors_for(program);
    let limits = axes.iter().chain(motors.iter().map(|motor| &motor.limits));
    let change = limits.map(change).fold(0.0, f64::max);
    Ok(2.0 * change + 4.0 * machine.lead + 0.1 + 20.0 * machine.cycle)
}

/// The times around the line that is under way, of a program in order.
struct Around<'a> {
    ends: Box<dyn Iterator<Item = (u32, f64)> + 'a>,
    /// The last moves of lines, in order, from one before those that are asked for; the last one is not complete.
    lines: VecDeque<(u32, f64)>,
}

impl<'a> Around<'a> {
    fn new(ends: impl Iterator<Item = (u32, f64)> + 'a) -> Self {
        Self { ends: Box::new(ends), lines: VecDeque::new() }
    }

    /// So many lines behind the one that is under way are kept, as commands may still be about them.
    const KEPT: usize = 1024;

    /// Reads on to a line behind this one.
    fn pass(&mut self, line: u32) {
        while self.lines.back().is_none_or(|(last, _)| *last <= line) {
            let Some((next, time)) = self.ends.next() else { return };
            match self.lines.back_mut() {
                Some((last, end)) if *last == next => *end = time,
                _ => self.lines.push_back((next, time)),
            }
            if self.lines.len() > 2 * Self::KEPT && self.lines[Self::KEPT].0 < line {
                self.lines.pop_front();
            }
        }
    }

    fn before(&mut self, line: u32) -> f64 {
        self.pass(line);
        let first = self.lines.partition_point(|(other, _)| *other < line);
        first.checked_sub(1).map_or(0.0, |last| self.lines[last].1)
    }

    fn until(&mut self, line: u32) -> f64 {
        self.pass(line);
        let next = self.lines.partition_point(|(other, _)| *other <= line);
        self.lines.get(next.max(1) - 1).map_or(0.0, |(_, time)| *time)
    }
}

/// Holds the time of a run against [`Stops`], cycle by cycle: what has been run since the last command
/// may not have taken longer than with stops, and what a command may cost.
///
/// It does not tell a crawl from a run that makes good for it elsewhere on the same line.
pub struct Stopwatch<'a> {
    /// Times up to the line under way; none if lines do not come in order.
    around: Option<Around<'a>>,
    whole: f64,
    allowance: f64,
    slack: f64,
    /// Time with stops at the last command, s.
    from: f64,
    /// Time since then as it counts, s.
    spent: f64,
    worst: Overtime,
}

/// The greatest excess of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overtime {
    /// Time beyond what was allowed, s: 0 or less if there was none.
    pub seconds: f64,
    /// The line on which it was.
    pub line: u32,
}

/// How the world was in a servo cycle, as far as time is concerned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Share of the feed that the overrides leave, at most 1.
    pub share: f64,
    /// The operator gave a command in this cycle.
    pub command: bool,
    /// Nothing is to be expected: the machine rests held or paused, or waits for blocks that do not come.
    pub waits: bool,
    /// A stop by the stop limits is under way.
    pub quick: bool,
}

impl Pace {
    /// Nobody interferes.
    pub const FULL: Self = Self { share: 1.0, command: false, waits: false, quick: false };
}

impl<'a> Stopwatch<'a> {
    /// A watch at the start of a run; planning may be late by `slack` seconds after a command.
    pub fn new(stops: &'a Stops<'a>, slack: f64) -> Self {
        let worst = Overtime { seconds: f64::NEG_INFINITY, line: 0 };
        let around = match &stops.moves {
            Moves::List(list) => Some(Around::new(list.iter().copied())),
            // Its axes have been looked for before.
            Moves::Tape(tape, machine) => Ends::new(*tape, machine).ok().map(Around::new),
        };
        let (whole, allowance) = (stops.whole, stops.allowance);
        let around = around.filter(|_| stops.ordered);
        Self { around, whole, allowance, slack, from: 0.0, spent: 0.0, worst }
    }

    /// One servo cycle of `seconds` on a line (0: before the first).
    pub fn see(&mut self, seconds: f64, line: u32, pace: Pace) {
        if pace.command || pace.waits {
            self.from = self.around.as_mut().map_or(0.0, |around| around.before(line));
            self.spent = 0.0;
            return;
        }
        self.spent += seconds * pace.share.clamp(0.0, 1.0);
        let until = self.around.as_mut().map_or(self.whole, |around| around.until(line));
        let granted = SHARE * (until - self.from);
        let seconds = self.spent - granted - self.allowance - self.slack;
        if seconds > self.worst.seconds {
            self.worst = Overtime { seconds, line };
        }
    }

    /// The greatest excess so far.
    pub fn overtime(&self) -> Overtime {
        self.worst
    }
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| x * x).sum::<f64>().sqrt()
}

/// A stretch without a stop: its length, the part of it over the axes that the feed is for, the least
/// radius of curvature, and for each axis, then each motor, the greatest share it has in the tangent.
struct Stretch {
    length: f64,
    fed: f64,
    radius: f64,
    shares: Vec<f64>,
}

impl Stretch {
    /// From rest to rest, s.
    fn time(&self, limits: &[Axis], speed: Speed) -> f64 {
        if !(self.length > 0.0) {
            return 0.0;
        }
        let least = |of: fn(&Axis) -> f64| {
            let shares = limits.iter().zip(&self.shares).filter(|(_, share)| **share > 1e-9);
            shares.map(|(limit, share)| of(limit) / share).fold(f64::INFINITY, f64::min)
        };
        let (mut acceleration, mut jerk) =
            (least(|axis| axis.acceleration), least(|axis| axis.jerk));
        let mut feed = least(|axis| axis.velocity);
        if self.radius.is_finite() {
            (acceleration, jerk) = (acceleration * ROUND.0, jerk * ROUND.1);
            feed = feed.min((acceleration * self.radius).sqrt());
            feed = feed.min((jerk * self.radius * self.radius).cbrt());
        }
        feed = feed.min(match speed {
            Speed::PerSecond(feed) => feed * self.length / self.fed.max(1e-12),
            Speed::Duration(seconds) => self.length / seconds,
            Speed::Rapid => f64::INFINITY,
        });
        Leg::new(0.0, 0.0, self.length, feed, Limit { acceleration, jerk }).time()
    }
}

/// Length over the axes that a feed is for: the linear ones, or the rotary ones if no other moves.
pub fn fed(way: &[f64], axes: &[usize]) -> f64 {
    let over = |rotary: bool| {
        norm(way.iter().zip(axes).filter(|(_, axis)| is_rotary(**axis) == rotary).map(|(x, _)| *x))
    };
    let linear = over(false);
    if linear > 0.0 { linear } else { over(true) }
}

/// Time of a move from rest to rest, s.
fn duration(
    step: &Move,
    here: &Point,
    axes: &[usize],
    (limits, motors): (&[Axis], &[MotorRow]),
) -> f64 {
    match &step.path {
        Course::Dwell { seconds } => *seconds,
        Course::Event { .. } => 0.0,
        Course::Line { to } => {
            let way: Vec<f64> = axes.iter().map(|&axis| to[axis] - here[axis]).collect();
            let length = norm(way.iter().copied());
            let driven = motors.iter().map(|motor| motor.of(&way));
            let all = way.iter().copied().chain(driven);
            let shares = all.map(|x| x.abs() / length.max(1e-12)).collect();
            let line = Stretch { length, fed: fed(&way, axes), radius: f64::INFINITY, shares };
            line.time(limits, step.speed)
        }
        Course::Arc { to, plane: (p, q), .. } => {
            let Some(arc) = Spiral::of(&step.path, here) else { return 0.0 };
            let round = f64::midpoint(arc.radii.0, arc.radii.1) * arc.sweep.abs();
            let radius = arc.radii.0.min(arc.radii.1).max(1e-9);
            let mut way: Vec<f64> = axes.iter().map(|&axis| to[axis] - here[axis]).collect();
            for (x, axis) in way.iter_mut().zip(axes) {
                // The plane's axes take turns in the way round.
                *x = if axis == p {
                    round
                } else if axis == q {
                    0.0
                } else {
                    *x
                };
            }
            let length = norm(way.iter().copied()).max(1e-12);
            let share = |(x, axis): (&f64, &usize)| {
                if axis == p || axis == q { round / length } else { x.abs() / length }
            };
            let mut shares: Vec<f64> = way.iter().zip(axes).map(share).collect();
            // Of a motor, the two of the plane at the angle where it moves most.
            let most = |motor: &MotorRow| {
                let parts = motor.factors.iter().zip(&shares).zip(axes);
                let (mut round, mut along) = (0.0f64, 0.0);
                for ((factor, share), axis) in parts {
                    let part = factor.abs() * share;
                    if axis == p || axis == q { round = round.hypot(part) } else { along += part }
                }
                round + along
            };
            let driven: Vec<f64> = motors.iter().map(most).collect();
            shares.extend(driven);
            // Of a helix, the curvature is less than that of its circle.
            let radius = radius * (length / round.max(1e-12)).powi(2);
            let arc = Stretch { length, fed: fed(&way, axes), radius, shares };
            arc.time(limits, step.speed)
        }
        Course::Cubic { controls, to } => {
            let points: Vec<Vec<f64>> = (0..=FINEST)
                .map(|k| on_cubic(here, controls, to, k as f64 / FINEST as f64))
                .map(|point| axes.iter().map(|&axis| point[axis]).collect())
                .collect();
            let mut best = f64::INFINITY;
            let mut count = FINEST;
            // One leg with the speed that its sharpest bend allows, or more with stops between.
            while count >= 1 {
                let parts = (0..FINEST).step_by(count).map(|k| &points[k..=k + count]);
                let times = parts.map(|part| stretch(part, axes, motors).time(limits, step.speed));
                best = best.min(times.sum());
                count /= 2;
            }
            best
        }
    }
}

/// A stretch of a curve by points of it.
fn stretch(points: &[Vec<f64>], axes: &[usize], motors: &[MotorRow]) -> Stretch {
    let shares = vec![0.0; axes.len() + motors.len()];
    let mut out = Stretch { length: 0.0, fed: 0.0, radius: f64::INFINITY, shares };
    let mut before: Option<(f64, Vec<f64>)> = None;
    for pair in points.windows(2) {
        let way: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| b - a).collect();
        let length = norm(way.iter().copied());
        if !(length > 0.0) {
            continue;
        }
        out.length += length;
        out.fed += fed(&way, axes);
        let tangent: Vec<f64> = way.iter().map(|x| x / length).collect();
        let driven = motors.iter().map(|motor| motor.of(&tangent));
        for (share, x) in out.shares.iter_mut().zip(tangent.iter().copied().chain(driven)) {
            *share = share.max(x.abs());
        }
        if let Some((last, other)) = before.replace((length, tangent.clone())) {
            let turn = norm(other.iter().zip(&tangent).map(|(a, b)| a - b));
            // Rounding of a straight one is no bend.
            if turn > 1e-9 {
                out.radius = out.radius.min(f64::midpoint(last, length) / turn);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(paths: Vec<(Course, Speed)>) -> Program {
        let mut program = Program::default();
        for (n, (path, speed)) in paths.into_iter().enumerate() {
            program.moves.push(Move::new(path, speed, n as u32 + 1));
        }
        program
    }

    fn x(mm: f64) -> Point {
        let mut point = [0.0; 9];
        point[0] = mm;
        point
    }

    /// 10 mm from rest to rest at V 200, A 2000, J 50,000 (see `baseline`), a second, a rotary axis whose
    /// feed is that of X, a duration, and a straight line written as a curve.
    #[test]
    fn moves_take_what_they_must() {
        let limit = (-0.04 + (0.0016f64 + 4.0 * 10.0 / 2000.0).sqrt()) * 1000.0;
        let leg = 2.0 * (limit / 2000.0 + 0.04);
        let mut both = x(0.0);
        both[3] = 1000.0;
        let list = vec![
            (Course::Line { to: x(10.0) }, Speed::PerSecond(1e3)),
            (Course::Dwell { seconds: 1.0 }, Speed::Rapid),
            (Course::Line { to: x(0.0) }, Speed::Duration(5.0)),
            (Course::Cubic { controls: [x(10.0 / 3.0), x(20.0 / 3.0)], to: x(10.0) }, Speed::Rapid),
            (Course::Line { to: both }, Speed::PerSecond(2.0)),
        ];
        let mut program = program(list);
        program.uses[3] = true;
        let machine = Machine::default();
        let stops = Stops::new(&program, &machine).unwrap();
        let ends = Ends::new(&program, &machine).unwrap();
        let times: Vec<f64> = ends.map(|(_, time)| time).collect();
        let each: Vec<f64> = std::iter::once(times[0])
            .chain(times.windows(2).map(|pair| pair[1] - pair[0]))
            .collect();
        for (n, (time, expected)) in each.iter().zip([leg, 1.0, 5.05, leg, 5.14]).enumerate() {
            assert!((time / expected - 1.0).abs() < 0.01, "move {n}: {time} s, not {expected}");
        }
        assert!((stops.left(3) - (stops.whole() - times[1])).abs() < 1e-12);
    }

    /// A crawl is found on the line where it is; a hold, an override and what they cost are not.
    #[test]
    fn a_crawl_is_found_and_a_hold_is_not() {
        let list = (1..=3).map(|k| (Course::Line { to: x(10.0 * f64::from(k)) }, Speed::Rapid));
        let program = program(list.collect());
        let stops = Stops::new(&program, &Machine::default()).unwrap();
        let run = |cycles: [u32; 3], pace: Pace| {
            let mut watch = Stopwatch::new(&stops, 0.0);
            for (n, cycles) in cycles.into_iter().enumerate() {
                for _ in 0..cycles {
                    watch.see(1e-3, n as u32 + 1, pace);
                }
            }
            watch.overtime()
        };
        assert!(run([190; 3], Pace::FULL).seconds < 0.0);
        let crawl = run([190, 1200, 190], Pace::FULL);
        assert!(crawl.seconds > 0.0 && crawl.line == 2, "{crawl:?}");
        assert!(run([380; 3], Pace { share: 0.5, ..Pace::FULL }).seconds < 0.0);
        assert!(run([190, 10_000, 190], Pace { waits: true, ..Pace::FULL }).seconds < 0.0);
    }

    /// A program that is gone through is judged as its list is, whatever lines are asked for.
    #[test]
    fn a_tape_has_the_times_of_its_list() {
        let list =
            (1..=5000).map(|k| (Course::Line { to: x(f64::from(k)) }, Speed::PerSecond(50.0)));
        let program = program(list.collect());
        let machine = Machine::default();
        let list = Stops::new(&program, &machine).unwrap();
        let tape = Stops::passing(&program, &machine).unwrap();
        let (mut a, mut b) = (Stopwatch::new(&list, 0.0), Stopwatch::new(&tape, 0.0));
        for k in 0..20_000u32 {
            // Now and then back by some lines, as of a jog to and fro.
            let line = if k % 7 == 0 { (k / 4).saturating_sub(900) } else { k / 4 };
            let pace = Pace { command: k % 1000 == 999, ..Pace::FULL };
            a.see(1e-3, line, pace);
            b.see(1e-3, line, pace);
            assert_eq!(a.overtime(), b.overtime(), "{k}");
        }
        assert!((list.left(4) - (list.whole() - list.before(4))).abs() < 1e-12);
    }
}
