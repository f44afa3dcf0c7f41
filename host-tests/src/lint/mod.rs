//! What the core will do with a program, before a machine does it.

mod blame;
mod feeds;

pub use self::blame::{Blame, Lost};
pub use self::feeds::{LineFeed, feeds};

use self::blame::AT_FEED;
use self::feeds::{Asked, NOTHING, asked, length};
use crate::view::Progress;
use anyhow::Result;
use serde::Serialize;
use splineway::Activity;
use splineway_simulator::judge::Track;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::arc::Spiral;
use splineway_simulator::program::{Course, Program, Speed};
use splineway_simulator::run::{Observer, Precision, Sample, run};
use std::collections::BTreeMap;

/// What a line of the file costs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Place {
    /// Line of the file.
    pub line: u32,
    /// Length of its moves, mm.
    pub length: f64,
    /// Its feed, mm/s; of a rapid, what the axes allow.
    pub feed: f64,
    /// Time, s.
    pub time: f64,
    /// Time lost against the feed around its slowest place, s, be it on other lines.
    pub lost: f64,
    /// Least speed, mm/s.
    pub slowest: f64,
    /// What held the motion back there.
    pub cause: String,
}

/// What was found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Findings {
    /// Moves by kind: lines, arcs, curves, dwells.
    pub moves: [usize; 4],
    /// Length, mm.
    pub length: f64,
    /// Least and greatest coordinate of every axis in use, mm or degrees.
    pub extent: Vec<(char, f64, f64)>,
    /// Machining time, s.
    pub time: f64,
    /// Share of it at the feed asked for, at less, and at rest.
    pub shares: [f64; 3],
    /// Stops at the end of a move.
    pub stops: usize,
    /// The places that lose most time.
    pub slowest: Vec<Place>,
    /// What might be done about it.
    pub advice: Vec<String>,
}

/// Time per line.
#[derive(Default)]
struct Clock {
    cycle: f64,
    time: BTreeMap<u32, (f64, f64)>,
    at_feed: f64,
    resting: f64,
    total: f64,
    feeds: BTreeMap<u32, f64>,
}

impl Observer for Clock {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        if sample.time == 0.0 {
            return Ok(());
        }
        self.total += self.cycle;
        if sample.activity != Activity::Running {
            self.resting += self.cycle;
        }
        let feed = self.feeds.get(&sample.tag).copied().unwrap_or(f64::INFINITY);
        if sample.speed >= AT_FEED * feed {
            self.at_feed += self.cycle;
        }
        let entry = self.time.entry(sample.tag).or_insert((0.0, f64::INFINITY));
        entry.0 += self.cycle;
        entry.1 = entry.1.min(sample.speed);
        Ok(())
    }
}

/// The lines that lose most time, as [`Blame`] found them: at most so many, none that lost less than two cycles.
pub fn slow_places(blame: Blame, cycle: f64, places: usize) -> Vec<(u32, Lost)> {
    let mut slow: Vec<(u32, Lost)> = blame.finish().into_iter().collect();
    slow.sort_by(|(_, a), (_, b)| b.seconds.total_cmp(&a.seconds));
    slow.retain(|(_, lost)| lost.seconds > 2.0 * cycle);
    slow.truncate(places);
    slow
}

/// Least and greatest coordinates over the axes: of arcs and curves, too, not of their ends alone.
fn extent(program: &Program, track: &Track, axes: &[usize]) -> Vec<(f64, f64)> {
    let mut extent: Vec<(f64, f64)> =
        axes.iter().map(|&axis| (program.start[axis], program.start[axis])).collect();
    let mut see = |n: usize, x: f64| {
        let (least, greatest) = &mut extent[n];
        (*least, *greatest) = (least.min(x), greatest.max(x));
    };
    for k in 0..track.len() {
        track.point(k).iter().enumerate().for_each(|(n, x)| see(n, *x));
    }
    let mut here = program.start;
    for step in &program.moves {
        if let Some(arc) = Spiral::of(&step.path, &here) {
            for u in arc.extremes() {
                let point = arc.point(u);
                axes.iter().enumerate().for_each(|(n, &axis)| see(n, point[axis]));
            }
        }
        if let Some(to) = step.path.end() {
            here = *to;
            axes.iter().enumerate().for_each(|(n, &axis)| see(n, to[axis]));
        }
    }
    extent
}

/// Whether a line of the file pushes or pulls filament (an E word): without a way, it is not useless.
fn is_extrusion(text: &str) -> bool {
    let code = text.split([';', '(']).next().unwrap_or("");
    let letters = code.char_indices().filter(|(_, letter)| letter.eq_ignore_ascii_case(&'e'));
    let number = |rest: &str| {
        rest.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
    };
    letters.into_iter().any(|(at, _)| {
        let before = code[..at].chars().next_back();
        !before.is_some_and(|c| c.is_ascii_digit() || c == '.') && number(&code[at + 1..])
    })
}

/// Looks at a program and runs it.
///
/// `source` are the lines of its file; a bar on a terminal shows how far it is, unless it is to be `quiet`.
///
/// # Errors
/// It cannot be run on this machine.
pub fn look(
    program: &Program,
    machine: &Machine,
    places: usize,
    source: &[&str],
    quiet: bool,
) -> Result<Findings> {
    let axes = program.axes();
    let limits = machine.axes_of(program)?;
    let mut findings = Findings::default();
    let mut lines: BTreeMap<u32, Place> = BTreeMap::new();
    let mut here = program.start;
    let (mut nothing, mut beyond) = (0, 0);
    for step in &program.moves {
        let way = length(&here, &step.path, &axes);
        let (kind, to) = match &step.path {
            Course::Line { to } => (0, to),
            Course::Arc { to, .. } => (1, to),
            Course::Cubic { to, .. } => (2, to),
            Course::Dwell { .. } | Course::Event { .. } => (3, &here),
        };
        findings.moves[kind] += 1;
        findings.stops += usize::from(step.exact_stop);
        let empty = kind == 0 && way < NOTHING;
        let text = (step.line as usize).checked_sub(1).and_then(|n| source.get(n)).unwrap_or(&"");
        nothing += usize::from(empty && !is_extrusion(text));
        let Asked { wanted, most } = asked(step, &here, &axes, &limits);
        beyond += usize::from(step.speed != Speed::Rapid && wanted > most * 1.001);
        let place = lines.entry(step.line).or_default();
        place.line = step.line;
        place.length += way;
        place.feed = place.feed.max(wanted.min(most));
        findings.length += way;
        here = *to;
    }
    let track = Track::new(program);
    findings.extent = axes
        .iter()
        .zip(extent(program, &track, &axes))
        .map(|(&axis, (least, greatest))| {
            (splineway_simulator::program::LETTERS[axis], least, greatest)
        })
        .collect();
    let feeds: BTreeMap<u32, f64> = lines.values().map(|place| (place.line, place.feed)).collect();
    let mut blame = Blame::new(program, &limits, machine.cycle, feeds.clone());
    let mut clock = Clock { cycle: machine.cycle, feeds, ..Clock::default() };
    let mut progress = Progress::new(track.length(), quiet);
    run(program, machine, Precision::F64, &mut [&mut clock, &mut blame, &mut progress])?;
    progress.finish();
    findings.time = clock.total;
    let total = clock.total.max(machine.cycle);
    let slow = (total - clock.at_feed - clock.resting).max(0.0);
    findings.shares = [clock.at_feed / total, slow / total, clock.resting / total];
    for (line, (time, slowest)) in clock.time {
        let place = lines.entry(line).or_default();
        (place.line, place.time, place.slowest) = (line, time, slowest);
    }
    for (line, lost) in blame.finish() {
        let place = lines.entry(line).or_default();
        (place.line, place.lost, place.cause) = (line, lost.seconds, lost.cause);
    }
    let mut slowest: Vec<Place> = lines.into_values().collect();
    slowest.sort_by(|a, b| b.lost.total_cmp(&a.lost));
    slowest.retain(|place| place.lost > 2.0 * machine.cycle);
    slowest.truncate(places);
    findings.slowest = slowest;
    findings.advice = advice(&findings, machine, (nothing, beyond));
    Ok(findings)
}

fn advice(
    findings: &Findings,
    machine: &Machine,
    (nothing, beyond): (usize, usize),
) -> Vec<String> {
    let mut advice = Vec::new();
    let moves: usize = findings.moves.iter().sum();
    if machine.tolerance == 0.0 && moves > 1 {
        advice.push("the tolerance is 0, so every corner is an exact stop: give one (G64 P0.01, or --tolerance 0.01)".to_owned());
    }
    if findings.stops * 5 > moves && moves > 5 {
        advice.push(format!(
            "{} of {moves} moves end in an exact stop: if that is not meant, leave G61 for G64",
            findings.stops
        ));
    }
    if nothing > 0 {
        advice.push(format!(
            "{nothing} lines have no length and do nothing: the post-processor could leave them out"
        ));
    }
    if beyond > 0 {
        advice.push(format!(
            "{beyond} moves ask for more feed than the axes allow: they run as fast as those do"
        ));
    }
    if findings.shares[1] > 0.5 && machine.tolerance > 0.0 {
        advice.push(format!(
            "more than half of the time is spent below the feed: a tolerance wider than {} mm, or more acceleration and jerk, would tell",
            machine.tolerance
        ));
    }
    advice
}
