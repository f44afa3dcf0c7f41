//! The least time of any motion inside the band: shape of the path and speed found together.
//!
//! A motion is given by knots every few milliseconds, with constant jerk of every axis between them. Round by round the best one
//! near the last is found as a cone program (`cone`), from the motion that the core has planned on; which line of the path
//! bounds a place of it is looked for anew in each (`tube`). At last the durations are kept and a motion is found that
//! satisfies everything, a little slower if it must be, and the judge has its word on the setpoints.
//!
//! Where a path turns back, farther than the band is wide, it rests, as the core does: the far end of a line out and back is a place
//! that distance alone does not ask for. Between rests, what is asked is that every place is in the band of a line, and lines come in order.
//!
//! The results are local optima: they can be reached, and are no proof that nothing is faster. Where a path folds back on itself by
//! less than the band is wide, a round may leave the fold out; then no motion is found in the end, or the judge says so. It is slow, and meant as a
//! yardstick for what is planned.

mod cone;
pub(crate) mod motion;
pub(crate) mod tube;

use anyhow::{Context, Result, bail, ensure};
use cone::{Better, Bounds, round};
use motion::{Motion, State};
use splineway::{Activity, CornerMode};
use splineway_simulator::judge::{Judge, Track, Verdict};
use splineway_simulator::machine::{Machine, is_rotary};
use splineway_simulator::program::{Course, Point, Program, Speed};
use splineway_simulator::run::{Observer, Pace, Precision, Sample, run};
use std::collections::BTreeSet;
use std::ops::Range;
use tube::{Band, Plan, Segment};

/// Share of the band that is used at the places that are looked at: between them there is a little more.
const BAND: f64 = 0.996;
/// Curves are taken for chords that leave them by this share of the band.
const CHORDS: f64 = 0.01;
/// Intervals that change alike.
const BLOCK: usize = 12;
/// Share by which durations change in the first rounds, and the least share.
const TRUST: (f64, f64) = (0.06, 2.0e-3);
/// The rounds end when the time falls by less than this share, with hardly anything outside the band, and knots that
/// lie off what leads to them by no more than this, mm.
const ENOUGH: f64 = 2.0e-5;
const OUTSIDE: f64 = 2.0e-3;
const OFF: f64 = 1.0e-4;
/// How much slower the last motion is, until everything is satisfied.
const SLOWER: [f64; 8] = [1.0, 1.0002, 1.0005, 1.001, 1.002, 1.004, 1.008, 1.016];
/// How often it is mended where it leaves the band between places, by how much durations change then, and what share of the
/// band is kept from its border.
const REPAIRS: usize = 8;
const REPAIR_TRUST: f64 = 0.01;
const SPARE: f64 = 5.0e-4;
/// A share of the band that may be left in it.
const LEFT: f64 = 1.5e-3;

/// How it is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Duration of an interval at first, s.
    pub step: f64,
    /// Most rounds.
    pub rounds: usize,
    /// Longest motion that is looked at, s: time and memory grow with it.
    pub longest: f64,
}

/// What was found.
#[derive(Debug)]
pub struct Found {
    /// Time of the motion that the core plans, s.
    pub planned: f64,
    /// Time of the motion found, s, in whole servo cycles.
    pub least: f64,
    /// The judge's word on that.
    pub verdict: Verdict,
    /// Rounds in all.
    pub rounds: usize,
    /// Its setpoints: positions of the axes in use in every servo cycle.
    pub setpoints: Vec<Vec<f64>>,
}

/// A part of a program from rest to rest.
pub(crate) struct Part {
    pub(crate) program: Program,
    /// Its path as lines over the axes in use.
    pub(crate) path: Vec<Segment>,
    /// s; then nothing moves.
    pub(crate) dwell: f64,
}

/// The least time of any motion inside the band of a program; `progress` hears of every round: the part (from 0 on), the round,
/// the time, s, and what is outside the band.
///
/// # Errors
/// A program that cannot be run, or with a tolerance of 0; one whose motion is too long; a program that the solver cannot solve.
pub fn least_time(
    program: &Program,
    machine: &Machine,
    options: &Options,
    mut progress: impl FnMut(usize, usize, f64, f64),
) -> Result<Found> {
    let limits = machine.axes_of(program)?;
    let track = Track::new(program);
    let axes = program.axes();
    ensure!(track.len() > 1, "nothing moves");
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
    let mut found = Found {
        planned: 0.0,
        least: 0.0,
        verdict: Verdict::default(),
        rounds: 0,
        setpoints: Vec::new(),
    };
    let mut show = Show { judge: &mut judge, cycle: machine.cycle, time: 0.0 };
    for (n, part) in parts(program, machine, &axes, BAND)?.into_iter().enumerate() {
        let path = &part.path;
        found.planned += part.dwell;
        if path.is_empty() {
            show.time += part.dwell;
            continue;
        }
        let planned = Planned::of(&part.program, machine, options)?;
        found.planned += planned.duration();
        let feeding = feeding(&axes, path);
        let bounds = Bounds { path, limits: &limits, feeding: &feeding };
        let motion = improve(bounds, planned, options, |round, time, outside| {
            found.rounds += 1;
            progress(n, round, time, outside);
        })
        .with_context(|| format!("part {} of the program", n + 1))?;
        show.motion(&motion, &mut found.setpoints)?;
        show.time += part.dwell;
    }
    found.least = show.time;
    found.verdict = judge.verdict();
    Ok(found)
}

/// Rounds, and a last one in which everything is satisfied.
fn improve(
    bounds: Bounds<'_>,
    mut motion: Motion,
    options: &Options,
    mut progress: impl FnMut(usize, f64, f64),
) -> Result<Motion> {
    let (mut trust, mut before) = (TRUST.0, motion.duration());
    let mut failures = 0;
    let mut band = Band::whole(bounds.path, &motion);
    for n in 0..options.rounds {
        let plan = Plan::new(bounds.path, &motion, &band, BLOCK);
        let better = match round(bounds, &motion, &plan, Some(trust)) {
            Ok(better) => better,
            Err(error) => {
                failures += 1;
                if failures > 4 {
                    return Err(error);
                }
                trust *= 0.5;
                continue;
            }
        };
        let Better { motion: next, outside } = better;
        let (time, off) = (next.duration(), next.defect());
        progress(n, time, outside);
        let gain = before - time;
        (motion, before) = (next, time);
        if n > 3 && gain.abs() < ENOUGH * time && outside < OUTSIDE && off < OFF {
            break;
        }
        if n > 2 && (gain < 1.0e-3 * time || off > 1.0e-3) {
            trust = (trust * 0.6f64).max(TRUST.1);
        }
    }
    for repair in 0..REPAIRS {
        let settled = settle(bounds, &motion, &band)?;
        if !band.tighten(bounds.path, &settled, 1.0 / BAND - 1.0 - SPARE) {
            return Ok(settled);
        }
        for _ in 0..2 {
            let plan = Plan::new(bounds.path, &motion, &band, BLOCK);
            if let Ok(Better { motion: next, outside }) =
                round(bounds, &motion, &plan, Some(REPAIR_TRUST))
            {
                progress(options.rounds + repair, next.duration(), outside);
                motion = next;
            }
        }
    }
    bail!("no motion was found that stays inside the band between the places that are looked at")
}

/// A motion with the durations of another, or a little longer ones, that satisfies everything.
fn settle(bounds: Bounds<'_>, motion: &Motion, band: &Band) -> Result<Motion> {
    let mut least = f64::INFINITY;
    for factor in SLOWER {
        let slower = motion.slower(factor);
        let plan = Plan::new(bounds.path, &slower, band, BLOCK);
        if let Ok(Better { motion, outside }) = round(bounds, &slower, &plan, None) {
            if outside < LEFT {
                return Ok(motion);
            }
            least = least.min(outside);
        }
    }
    bail!(
        "no motion was found that keeps all limits: at best it leaves the band by {least:.4} of it"
    )
}

/// A program from rest to rest: parts end at exact stops, at dwells, and where the path turns back, as the core stops there
/// ([`CornerMode::STOP_COSINE`]): a motion that is near enough to the lines before and behind such a turn need not have been there.
/// `share`: of the band.
pub(crate) fn parts(
    program: &Program,
    machine: &Machine,
    axes: &[usize],
    share: f64,
) -> Result<Vec<Part>> {
    let mut here = program.start;
    let mut lines = Vec::new();
    for (n, step) in program.moves.iter().enumerate() {
        lines.push(segments(program, n, here, (machine, axes, share))?);
        here = step.path.end().copied().unwrap_or(here);
    }
    let turns = turns(program, &lines);
    let begin = |start: Point| Part {
        program: Program { start, uses: program.uses, ..Program::default() },
        path: Vec::new(),
        dwell: 0.0,
    };
    let mut parts = Vec::new();
    here = program.start;
    let mut part = begin(here);
    for ((n, step), lines) in program.moves.iter().enumerate().zip(lines) {
        if let Some(to) = step.path.end() {
            if turns.contains(&n) {
                parts.push(std::mem::replace(&mut part, begin(here)));
            }
            here = *to;
            part.path.extend(lines);
            part.program.moves.push(step.clone());
            if let Some(exact) = program.exact.get(n) {
                part.program.exact.push(exact.clone());
            }
            if !step.exact_stop {
                continue;
            }
        }
        if let Course::Dwell { seconds } = step.path {
            part.dwell += seconds;
        }
        parts.push(std::mem::replace(&mut part, begin(here)));
    }
    parts.push(part);
    Ok(parts)
}

/// Moves before which the path turns back, and is farther than the band is wide from there before it turned back the last time, and will be
/// before it does the next time: no place is in the band of all.
fn turns(program: &Program, lines: &[Vec<Segment>]) -> BTreeSet<usize> {
    // From rests or turns on to the next, and whether from a turn.
    let mut stretches = Vec::new();
    let (mut begin, mut from_turn) = (0, false);
    let mut before: Option<&Segment> = None;
    for (n, step) in program.moves.iter().enumerate() {
        if let (Some(before), Some(next)) = (before, lines[n].first())
            && before.cosine_to(next) < CornerMode::<f64>::STOP_COSINE
        {
            stretches.push((begin..n, from_turn));
            (begin, from_turn) = (n, true);
        }
        before = lines[n].last().or(before);
        if step.path.end().is_none() || step.exact_stop {
            stretches.push((begin..n + 1, from_turn));
            (begin, from_turn, before) = (n + 1, false, None);
        }
    }
    stretches.push((begin..lines.len(), from_turn));
    let leaves = |moves: &Range<usize>, turn: &Segment| {
        lines[moves.clone()].iter().flatten().any(|line| {
            let ends = line.from.iter().zip(&line.direction).map(|(x, d)| x + d * line.length);
            apart(&ends.collect::<Vec<_>>(), &turn.from).max(apart(&line.from, &turn.from))
                > 2.0 * turn.band
        })
    };
    let is_turn = |pair: &[(Range<usize>, bool)]| {
        let (moves, from_turn) = &pair[1];
        let turn = lines[moves.clone()].iter().flatten().next()?;
        let folds = *from_turn && leaves(&pair[0].0, turn) && leaves(moves, turn);
        folds.then_some(moves.start)
    };
    stretches.windows(2).filter_map(is_turn).collect()
}

/// Move `n` of a program, which begins `here`, as lines over the axes in use, with a share of the band.
fn segments(
    program: &Program,
    n: usize,
    here: Point,
    (machine, axes, share): (&Machine, &[usize], f64),
) -> Result<Vec<Segment>> {
    let step = &program.moves[n];
    let Some(to) = step.path.end() else { return Ok(Vec::new()) };
    let tolerance = step.tolerance.unwrap_or(machine.tolerance);
    ensure!(tolerance > 0.0, "line {}: a tolerance of 0 leaves no choice", step.line);
    let straight = matches!(step.path, Course::Line { .. }) && program.exact.is_empty();
    let points = if straight {
        let over = |point: &Point| axes.iter().map(|&axis| point[axis]).collect();
        vec![over(&here), over(to)]
    } else {
        let exact = program.exact.get(n).cloned().into_iter().collect();
        let moves = vec![step.clone()];
        let uses = program.uses;
        let alone = Program { start: here, uses, moves, exact, ..Program::default() };
        chords(&Track::new(&alone), tolerance * CHORDS)
    };
    let band = tolerance * share - if straight { 0.0 } else { tolerance * CHORDS };
    let length: f64 = points.windows(2).map(|pair| apart(&pair[0], &pair[1])).sum();
    let feed = match step.speed {
        Speed::PerSecond(feed) => feed,
        Speed::Duration(seconds) => length / seconds,
        Speed::Rapid => f64::INFINITY,
    };
    let lines = points.windows(2).filter_map(|pair| {
        let size = apart(&pair[0], &pair[1]);
        let direction = pair[1].iter().zip(&pair[0]).map(|(b, a)| (b - a) / size).collect();
        let from = pair[0].clone();
        (size >= 1.0e-9).then_some(Segment { from, direction, length: size, band, feed })
    });
    Ok(lines.collect())
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Chords of a fine poly-line that leave it by no more than `most`, mm.
fn chords(track: &Track, most: f64) -> Vec<Vec<f64>> {
    let point = |k: usize| track.point(k).to_vec();
    let mut points = vec![point(0)];
    let mut start = 0;
    while start + 1 < track.len() {
        // The longest that still fits, by doubling and halving.
        let fits = |end: usize| {
            let (a, b) = (point(start), point(end));
            let length = apart(&a, &b);
            let direction = b.iter().zip(&a).map(|(b, a)| (b - a) / length.max(1e-12)).collect();
            let chord = Segment { from: a, direction, length, band: most, feed: 0.0 };
            (start + 1..end).all(|k| chord.distance(track.point(k)).0 <= most)
        };
        let (mut good, mut step) = (start + 1, 1);
        while good + step < track.len() && fits(good + step) {
            good += step;
            step *= 2;
        }
        while step > 0 {
            if good + step < track.len() && fits(good + step) {
                good += step;
            }
            step /= 2;
        }
        points.push(point(good));
        start = good;
    }
    points
}

/// Which axes count for a feed: the linear ones, if any of them moves.
fn feeding(axes: &[usize], path: &[Segment]) -> Vec<bool> {
    let moves = |c: usize| path.iter().any(|segment| segment.direction[c] != 0.0);
    let linear = (0..axes.len()).any(|c| !is_rotary(axes[c]) && moves(c));
    axes.iter().map(|&axis| !linear || !is_rotary(axis)).collect()
}

/// The motion that the core plans, cycle by cycle.
struct Planned {
    states: Vec<[Vec<f64>; 3]>,
    cycle: f64,
    longest: f64,
}

impl Planned {
    /// As knots.
    fn of(program: &Program, machine: &Machine, options: &Options) -> Result<Motion> {
        let mut planned = Self { states: vec![], cycle: machine.cycle, longest: options.longest };
        run(program, machine, Precision::F64, &mut [&mut planned])?;
        let Self { states, cycle, .. } = planned;
        ensure!(states.len() > 8, "hardly anything moves");
        let mut motion = Motion::new(states[0][0].len());
        let every = ((options.step / cycle).round() as usize).max(1);
        let last = states.len() - 1;
        // The last interval may be longer than the others.
        for k in (0..last).step_by(every).filter(|k| k + every <= last).chain([last]) {
            let [position, velocity, acceleration] = &states[k];
            motion.push(k as f64 * cycle, [position, velocity, acceleration]);
        }
        Ok(motion)
    }
}

impl Observer for Planned {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let state = [sample.position, sample.velocity, sample.acceleration].map(<[f64]>::to_vec);
        let rests = sample.activity != Activity::Running;
        match self.states.last_mut() {
            // From the last rest before the motion on, to the first behind it.
            Some(before) if rests && before[1].iter().all(|v| *v == 0.0) => *before = state,
            _ => self.states.push(state),
        }
        let most = self.longest / self.cycle;
        ensure!(
            (self.states.len() as f64) < most,
            "the motion takes more than {} s, the longest that is looked at",
            self.longest
        );
        Ok(())
    }
}

/// Shows a motion to the judge.
struct Show<'a, 'b> {
    judge: &'a mut Judge<'b>,
    cycle: f64,
    time: f64,
}

impl Show<'_, '_> {
    fn motion(&mut self, motion: &Motion, setpoints: &mut Vec<Vec<f64>>) -> Result<()> {
        let first = usize::from(!setpoints.is_empty());
        let states = motion.sampled(self.cycle);
        for (k, state) in states.iter().enumerate().skip(first) {
            show(self.judge, self.time + k as f64 * self.cycle, state, (true, f64::EPSILON))?;
            setpoints.push(state[0].clone());
        }
        self.time += (states.len() - 1) as f64 * self.cycle;
        Ok(())
    }
}

/// Shows a setpoint to the judge: whether a piece of motion has begun, and the rounding error of one operation.
pub(crate) fn show(
    judge: &mut Judge<'_>,
    time: f64,
    state: &State,
    (began, unit): (bool, f64),
) -> Result<()> {
    let [position, velocity, acceleration] = state;
    judge.setpoint(&Sample {
        time,
        position,
        velocity,
        acceleration,
        path: 0.0,
        speed: 0.0,
        tag: 0,
        activity: Activity::Running,
        began,
        unit,
        pace: Pace::FULL,
    })
}
