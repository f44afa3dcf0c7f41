//! The chip in real time: what planning that takes time makes of a path, and how soon commands are answered.
//!
//! `cargo bench -p splineway-host --bench realtime [-- [FOLDER] [--reshape] [--m7] [--instants N] [--lead S] [--check]]` runs the
//! background loop of a controller on an emulated Cortex-M4F (QEMU, 8 ns an instruction: about 168 MHz) or, with `--m7`, a
//! Cortex-M7 (2 ns: 500 MHz at a cycle an instruction), blocks always at hand, over every path in FOLDER, and prints
//! - machining time against that of planning which takes no time; stops on the way; plans that came late; stops for
//!   want of blocks; the longest round of the background and the longest time between two; load of the processor; what was
//!   used of the limits of the axes and of the tolerance at most, servo cycle by servo cycle;
//! - with N > 0, for hold, abort, a feed override of 50 %, and 100 % again, at N places of each path: after how many ms
//!   the speed differs from what it would have been, and, but for the last, how much later than it could
//!   (`splineway_studies::stop`) the machine stands still or has the new speed: median / worst; and for a stop at the end of a block how far
//!   beyond the place where a hold rests it goes, and past how many vertices of the path.
//!
//! With `--reshape` the motion is reshaped in idle time, with a planning window of 256 nodes instead of 64.
//!
//! With `--check` it runs paths of `host-tests/data`, with and without, and fails where a bound is exceeded.
//!
//! Without a toolchain for the target or QEMU it says so and ends; with `SPLINEWAY_REQUIRE_TARGET` set it fails.

// Some of it is for other benches.
#[allow(dead_code)]
#[path = "../common/image.rs"]
mod built;
#[path = "../common/mod.rs"]
mod common;
mod judge;
mod run;
#[path = "../common/session.rs"]
mod session;

use anyhow::{Context, Result, ensure};
use built::{Chip, Image, Missing};
use run::Run;
use session::Machine;
use splineway_realtime::{AXES, Due, Order, Setup};
use splineway_simulator::program::Program;
use splineway_studies::stop::{Limits, Moment, shortest};
use std::path::{Path, PathBuf};

/// A speed that differs by more shows, mm/s: what jerk changes in two servo cycles.
const SHOWN: f32 = 0.1;
/// Standing still is less, mm/s.
const STILL: f32 = 0.3;

/// What must hold of a path in `host-tests/data`: somewhat more than was measured.
struct Bound {
    path: &'static str,
    /// Real time over zero time.
    ratio: f64,
    /// Longest round of the background, ms.
    round: f64,
    /// Longest time until a hold shows, ms.
    hold: f64,
    /// How far beyond a hold a stop at the end of a block rests, mm.
    stop: f64,
}

const BOUNDS: [Bound; 3] = [
    Bound { path: "noisy.txt", ratio: 1.05, round: 1.6, hold: 20.0, stop: 10.0 },
    Bound { path: "butterfly.json", ratio: 1.03, round: 1.6, hold: 60.0, stop: 4.0 },
    Bound { path: "zigzag.txt", ratio: 1.01, round: 1.6, hold: 60.0, stop: 12.0 },
];

/// Settings of a bench run.
struct Options {
    instants: usize,
    lead: f32,
    check: bool,
    reshape: bool,
    chip: Chip,
}

impl Options {
    const DEFAULT: Self =
        Self { instants: 0, lead: 0.01, check: false, reshape: false, chip: Chip::M4 };

    fn read() -> Result<Self> {
        let mut options = Self::DEFAULT;
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().with_context(|| format!("{word} needs a value"));
            match word.as_str() {
                "--instants" => options.instants = value()?.parse()?,
                "--check" => options.check = true,
                "--reshape" => options.reshape = true,
                "--m7" => options.chip = Chip::M7,
                "--lead" => options.lead = value()?.parse()?,
                _ => {}
            }
        }
        Ok(options)
    }

    fn image(&self) -> Result<Image> {
        let features = if self.reshape { "reshape" } else { "" };
        Image::build_for(self.chip, "realtime", "realtime", features)
    }
}

/// A path with all that its runs need.
struct Job<'a> {
    image: &'a Image,
    program: Program,
    setup: Setup,
    reshape: bool,
}

impl<'a> Job<'a> {
    fn new(image: &'a Image, path: &Path, options: &Options) -> Result<Self> {
        let program = session::read(path)?;
        let Machine { limits, tolerance, cycle } = Machine::of(&program);
        let setup = Setup {
            limits,
            tolerance,
            cycle,
            lead: options.lead,
            instruction: image.chip.instruction(),
            most_cycles: 120_000,
            linger: 0,
            commands: heapless::Vec::new(),
        };
        Ok(Self { image, program, setup, reshape: options.reshape })
    }

    fn real(&self, setup: &Setup) -> Result<Run> {
        run::real(self.image, &session::frames(&self.program, setup, AXES)?)
    }

    fn zero(&self) -> Result<Run> {
        let frames = session::frames(&self.program, &self.setup, AXES)?;
        run::zero(&self.setup, &frames, self.reshape)
    }

    fn limits(&self) -> Limits {
        let [_, acceleration, jerk] = self.setup.limits.map(f64::from);
        Limits { acceleration, jerk }
    }
}

/// Places at which the machine all but stands though with planning that takes no time it would not.
fn stops(real: &Run, zero: &Run) -> usize {
    let speed_at = |run: &Run, at: f64| {
        let (first, last) = run.ends();
        let k = (first..last).collect::<Vec<_>>().partition_point(|&k| run.path(k) < at);
        f64::from(run.samples[(first + k).min(last)].speed)
    };
    let length = real.path(real.ends().1).min(zero.path(zero.ends().1));
    let mut count = 0;
    let mut low = false;
    for step in 1..4000 {
        let at = length * f64::from(step) / 4000.0;
        let (slow, fast) = (speed_at(real, at), speed_at(zero, at));
        let now = fast > 5.0 && slow < 0.1 * fast;
        count += usize::from(now && !low);
        low = now;
    }
    count
}

/// Servo cycles at places spread over the path, at speed.
fn instants(run: &Run, count: usize, least: f32) -> Vec<usize> {
    let (first, last) = run.ends();
    let (begin, end) = (run.path(first), run.path(last));
    let mut out = Vec::new();
    for k in 0..count {
        let share = 0.04 + 0.9 * (k as f64 + 0.5) / count as f64;
        let at = begin + (end - begin) * share;
        let from = (first..last).find(|&k| run.path(k) >= at).unwrap_or(last);
        out.extend((from..last).find(|&k| run.samples[k].speed >= least));
    }
    out
}

/// Median and worst of a list of times, s, in ms.
fn spread(list: Vec<f64>) -> String {
    if list.is_empty() {
        return "-".to_owned();
    }
    let [median, worst] = extremes(list);
    format!("{:.0} / {:.0}", median * 1e3, worst * 1e3)
}

/// Median and greatest of a list; NaN where it is empty.
fn extremes(mut list: Vec<f64>) -> [f64; 2] {
    list.sort_by(f64::total_cmp);
    [list.get(list.len() / 2), list.last()].map(|value| value.copied().unwrap_or(f64::NAN))
}

/// What the speed is compared with after a command.
#[derive(Clone, Copy, Debug)]
enum Goal {
    /// Standing still.
    Rest,
    /// A speed that is not to be exceeded any more, mm/s.
    Below(f32),
    /// Nothing but that it rises.
    Rise,
}

/// A command, in a run in which others may have been given before.
struct Trial {
    name: &'static str,
    before: Option<Order>,
    order: Order,
    goal: Goal,
}

impl Trial {
    /// All of them, for a machine that goes at most `speed` mm/s.
    fn all(speed: f32) -> [Self; 4] {
        let half = Order::Feed(50);
        [
            Self { name: "hold", before: None, order: Order::Hold, goal: Goal::Rest },
            Self { name: "abort", before: None, order: Order::Abort, goal: Goal::Rest },
            Self { name: "feed 50", before: None, order: half, goal: Goal::Below(speed * 0.5) },
            Self {
                name: "feed 100",
                before: Some(half),
                order: Order::Feed(100),
                goal: Goal::Rise,
            },
        ]
    }

    fn setup(&self, job: &Job<'_>, at: Option<usize>) -> Setup {
        let before = self.before.map(|order| Due { cycle: 0, order });
        let at = at.map(|at| Due { cycle: at as u32, order: self.order });
        Setup {
            commands: before.into_iter().chain(at).collect(),
            linger: if at.is_some() && matches!(self.goal, Goal::Rest) { 30 } else { 0 },
            most_cycles: at.map_or(job.setup.most_cycles, |due| due.cycle + 2000),
            ..job.setup.clone()
        }
    }

    /// Least speed at which the command is of interest, mm/s.
    fn least(&self) -> f32 {
        if let Goal::Below(speed) = self.goal { speed * 1.25 } else { 20.0 }
    }
}

/// How the speed answers to a command, s.
struct Answer {
    /// Until it differs from what it would have been.
    reaction: Option<f64>,
    /// Until the goal is reached, beyond the least time.
    over: Option<f64>,
    /// Longest round of the background, ms.
    round: f64,
}

/// The run with a command at servo cycle `at` against the one without.
fn answer(job: &Job<'_>, trial: &Trial, base: &Run, at: usize) -> Result<Answer> {
    let cycle = f64::from(job.setup.cycle);
    let run = job.real(&trial.setup(job, Some(at)))?;
    let differs = |k: &usize| {
        let (before, now) = (base.samples[*k].speed, run.samples[*k].speed);
        (before - now).abs() > SHOWN
    };
    let shared = run.samples.len().min(base.samples.len());
    let reaction = (at + 1..shared).find(differs).map(|k| (k - at) as f64 * cycle);
    let round = run.round();
    let goal = match trial.goal {
        Goal::Rest => STILL,
        Goal::Below(speed) => speed * 1.01,
        Goal::Rise => return Ok(Answer { reaction, over: None, round }),
    };
    let there = (at + 1..run.samples.len())
        .find(|&k| run.samples[k].idle || run.samples[k].speed <= goal)
        .map(|k| (k - at) as f64 * cycle);
    let moments: Vec<Moment> = base.samples[at..]
        .iter()
        .map(|sample| Moment {
            velocity: sample.velocity.map(f64::from).to_vec(),
            acceleration: sample.acceleration.map(f64::from).to_vec(),
        })
        .collect();
    // Without the shortest one there is nothing to compare with.
    let least = shortest(&moments, cycle, job.limits(), f64::from(goal)).unwrap_or_else(|error| {
        println!("    cycle {at}: {error:#}");
        None
    });
    let over = there.zip(least).map(|(there, least)| there - least);
    Ok(Answer { reaction, over, round })
}

/// Reactions and excess of a command at some places of a path, s, and the longest round, ms.
fn answers(job: &Job<'_>, trial: &Trial, count: usize) -> Result<(Vec<f64>, Vec<f64>, f64)> {
    let base = job.real(&trial.setup(job, None))?;
    let (mut reactions, mut overs, mut round) = (Vec::new(), Vec::new(), 0.0f64);
    for at in instants(&base, count, trial.least()) {
        let answer = answer(job, trial, &base, at)?;
        reactions.extend(answer.reaction);
        overs.extend(answer.over);
        round = round.max(answer.round);
    }
    Ok((reactions, overs, round))
}

/// How far a stop at the end of a block goes beyond where a hold rests, at some places of a path, `base` without a command: mm, and vertices passed;
/// and the longest round, ms.
fn stops_at_ends(job: &Job<'_>, base: &Run, count: usize) -> Result<(Vec<f64>, Vec<f64>, f64)> {
    let trial = |order| Trial { name: "stop", before: None, order, goal: Goal::Rest };
    let [stop, hold] = [Order::Stop, Order::Hold].map(trial);
    let (mut ways, mut vertices, mut round) = (Vec::new(), Vec::new(), 0.0f64);
    for at in instants(base, count, stop.least()) {
        let run = job.real(&stop.setup(job, Some(at)))?;
        let held = job.real(&hold.setup(job, Some(at)))?;
        let end = |run: &Run| judge::end(&job.program, &job.setup, run);
        let ((way, passed), (least, before)) = (end(&run), end(&held));
        ways.push(way - least);
        vertices.push(passed as f64 - before as f64);
        round = round.max(run.round());
    }
    Ok((ways, vertices, round))
}

/// What a path came to.
struct Outcome {
    /// Real time over zero time.
    ratio: f64,
    /// Longest round, ms, with commands too.
    round: f64,
    /// Worst reaction to a hold, ms.
    hold: f64,
    /// How far beyond a hold a stop at the end of a block rests at most, mm.
    stop: f64,
    /// Load of the processor.
    load: f64,
    /// What was used of the limits, and of the tolerance.
    shares: [f64; 2],
}

fn report(image: &Image, path: &Path, options: &Options) -> Result<Outcome> {
    let job = Job::new(image, path, options)?;
    let zero = job.zero()?;
    let real = job.real(&job.setup)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    ensure!(real.complete && zero.complete, "{name}: it does not come to its end");
    let cycle = f64::from(job.setup.cycle);
    let seconds = |run: &Run| run.cycles() as f64 * cycle;
    let (ratio, mut longest) = (seconds(&real) / seconds(&zero), real.round());
    let shares @ [limits, band] = judge::shares(&job.program, &job.setup, &real);
    let load = real.value("busy") as f64 * 1e-9 / seconds(&real);
    println!(
        "| {name} | {:.3} | {:.3} | {ratio:.3} | {} | {} | {} | {longest:.1} | {:.1} | {:.2} | {limits:.3} | {band:.3} |",
        seconds(&zero),
        seconds(&real),
        stops(&real, &zero),
        real.value("late"),
        real.value("starved"),
        real.value("gap") as f64 * 1e-6,
        load,
    );
    let mut hold: f64 = 0.0;
    if options.instants > 0 {
        for trial in Trial::all(job.setup.limits[0]) {
            let (reactions, overs, round) = answers(&job, &trial, options.instants)?;
            longest = longest.max(round);
            if matches!(trial.order, Order::Hold) {
                hold = reactions.iter().fold(0.0, |most, &x| most.max(x * 1e3));
            }
            let late = if overs.is_empty() {
                String::new()
            } else {
                format!(", there {} ms later than it could be", spread(overs))
            };
            println!(
                "    {}: differs after {} ms{late}; longest round {round:.1} ms",
                trial.name,
                spread(reactions)
            );
        }
    }
    let mut stop: f64 = 0.0;
    if options.instants > 0 {
        let (ways, vertices, round) = stops_at_ends(&job, &real, options.instants)?;
        longest = longest.max(round);
        let ([way, farthest], [median, most]) = (extremes(ways), extremes(vertices));
        stop = farthest;
        println!(
            "    stop: rests {way:.2} / {farthest:.2} mm beyond a hold, past {median} / {most} vertices; longest round {round:.1} ms"
        );
    }
    Ok(Outcome { ratio, round: longest, hold, stop, load, shares })
}

/// Paths that are always at hand.
fn data(name: &str) -> PathBuf {
    built::root().join("host-tests/data").join(name)
}

/// Three of them, and what must hold of them; and two with reshaping on the faster chip.
fn check(image: &Image) -> Result<()> {
    let options = Options { instants: 3, check: true, ..Options::DEFAULT };
    for bound in &BOUNDS {
        let path = data(bound.path);
        let Outcome { ratio, round, hold, stop, .. } = report(image, &path, &options)?;
        ensure!(ratio <= bound.ratio, "{}: {ratio:.3} of zero time", bound.path);
        ensure!(round <= bound.round, "{}: a round of {round:.1} ms", bound.path);
        ensure!(hold <= bound.hold, "{}: {hold:.0} ms until a hold shows", bound.path);
        ensure!(stop <= bound.stop, "{}: a stop rests {stop:.1} mm beyond a hold", bound.path);
    }
    let options = Options { reshape: true, chip: Chip::M7, ..Options::DEFAULT };
    let image = options.image()?;
    for name in ["butterfly.json", "zigzag.txt"] {
        let Outcome { ratio, round, load, shares, .. } = report(&image, &data(name), &options)?;
        ensure!(ratio <= 1.02, "{name}, reshaped: {ratio:.3} of zero time");
        ensure!(round <= 1.0, "{name}, reshaped: a round of {round:.1} ms");
        ensure!(load <= 0.6, "{name}, reshaped: a load of {load:.2}");
        ensure!(shares[0] <= 1.001 && shares[1] <= 1.0, "{name}, reshaped: {shares:?} used");
    }
    Ok(())
}

fn main() -> Result<()> {
    let options = Options::read()?;
    let image = match options.image() {
        Err(error)
            if error.is::<Missing>() && std::env::var_os("SPLINEWAY_REQUIRE_TARGET").is_none() =>
        {
            println!("skipped: {error}");
            return Ok(());
        }
        image => image?,
    };
    println!(
        "| path | zero time, s | real time, s | ratio | stops | late | starved | longest round, ms \
         | longest gap, ms | load | limits | tolerance |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
    if options.check {
        return check(&image);
    }
    for path in common::paths() {
        report(&image, &path, &options)?;
    }
    Ok(())
}
