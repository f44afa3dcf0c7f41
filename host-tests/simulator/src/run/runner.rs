//! The servo cycle simulation: the core as a controller would run it, without the controller.

use super::command::Command;
use super::duration::Pace;
use super::events::{Action, Event, Events};
use super::jog::on_axes;
use super::seek::Seeker;
use super::sought::Sought;
use super::timing::Timing;
use super::validate::on_letters;
use crate::letters::said;
use crate::machine::Machine;
use crate::program::{Course, Move, Speed, Tape};
use anyhow::{Context, Result, bail, ensure};
use splineway::{
    Activity, Block, Config, Coord, Counters, Feed, Link, Motion, Planner, Progress, PushError,
    Reshaping, Scalar, Setpoint, Turn,
};
use std::time::Instant;

/// Scalar the core computes with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Precision {
    /// As on a Cortex-M4F.
    F32,
    /// As on a Cortex-M7.
    #[default]
    F64,
}

/// One servo cycle.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Time since the start, s.
    pub time: f64,
    /// Positions of the axes in use, mm or degrees.
    pub position: &'a [f64],
    /// Velocities, mm/s.
    pub velocity: &'a [f64],
    /// Accelerations, mm/s2.
    pub acceleration: &'a [f64],
    /// Arc length, mm.
    pub path: f64,
    /// Speed along the path, mm/s.
    pub speed: f64,
    /// Line of the block under way.
    pub tag: u32,
    /// What the interpolator does.
    pub activity: Activity,
    /// Whether another piece of motion than in the cycle before is under way.
    pub began: bool,
    /// Relative distance of neighbouring numbers of the core's scalar.
    pub unit: f64,
    /// What the operator makes of the time.
    pub pace: Pace,
}

/// Sees every servo cycle.
pub trait Observer {
    /// One servo cycle.
    ///
    /// # Errors
    /// An observer that fails ends the run.
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()>;
}

/// What a run was like from the inside.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// Blocks accepted.
    pub blocks: u64,
    /// Planner's counters.
    pub counters: Counters,
    /// Least number of nodes ahead of the motion while blocks were left, at a planning step.
    pub least_ahead: usize,
    /// What came of probes and homing.
    pub sought: Vec<Sought>,
    /// Whether the run ended with an abort.
    pub aborted: bool,
    /// Times of the events that were still to come when it ended, s.
    pub unplayed: Vec<f64>,
    /// Duration of the planning steps.
    pub planning: Timing,
    /// Duration of the ticks.
    pub ticks: Timing,
}

/// Gives up after this many cycles at rest without an end in sight.
const PATIENCE: u32 = 1000;

/// Runs a program from rest to rest and shows every cycle to the observers.
///
/// # Errors
/// A block that the core refuses (with its line), a machine that lacks an axis, an observer's
/// error.
pub fn run(
    program: &dyn Tape,
    machine: &Machine,
    precision: Precision,
    observers: &mut [&mut dyn Observer],
) -> Result<Stats> {
    run_with(program, machine, precision, &Events::default(), observers)
}

/// Runs a program while an operator gives commands. An abort ends the run.
///
/// # Errors
/// As [`run`]; a run that is still held after the last command.
pub fn run_with(
    program: &dyn Tape,
    machine: &Machine,
    precision: Precision,
    events: &Events,
    observers: &mut [&mut dyn Observer],
) -> Result<Stats> {
    ensure!(
        !machine.reshape || machine.lookahead >= 64,
        "reshape: the look-ahead is {} blocks; with less than 64 there is no room for it",
        machine.lookahead
    );
    let setting = Setting { program, machine, events };
    match precision {
        Precision::F32 => run_scalar::<f32>(setting, observers),
        Precision::F64 => run_scalar::<f64>(setting, observers),
    }
}

/// What is run, on what, and what the operator does.
#[derive(Clone, Copy)]
struct Setting<'a> {
    program: &'a dyn Tape,
    machine: &'a Machine,
    events: &'a Events,
}

fn run_scalar<S: Scalar>(
    setting: Setting<'_>,
    observers: &mut [&mut dyn Observer],
) -> Result<Stats> {
    // Unused axes up to the next size cost nothing but time.
    match setting.program.axes().len() {
        0..=3 => run_axes::<S, 3>(setting, observers),
        4..=6 => run_axes::<S, 6>(setting, observers),
        _ => run_axes::<S, 9>(setting, observers),
    }
}

fn run_axes<S: Scalar, const N: usize>(
    setting: Setting<'_>,
    observers: &mut [&mut dyn Observer],
) -> Result<Stats> {
    match setting.machine.lookahead {
        16 => run_sized::<S, N, 16, 64>(setting, observers),
        64 => run_sized::<S, N, 64, 192>(setting, observers),
        256 => run_sized::<S, N, 256, 512>(setting, observers),
        depth => bail!("lookahead is {depth}; the simulator has 16, 64 and 256"),
    }
}

/// A link of its own frame: it lies on the stack before it lies in its box.
#[inline(never)]
fn link<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>()
-> Box<Link<S, N, BLOCKS, NODES>> {
    Box::new(Link::new())
}

/// The same for what reshaping remembers.
#[inline(never)]
fn reshaping<S: Scalar, const N: usize>() -> Box<Reshaping<S, N>> {
    Box::new(Reshaping::new())
}

fn run_sized<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    setting: Setting<'_>,
    observers: &mut [&mut dyn Observer],
) -> Result<Stats> {
    let Setting { program, machine, events } = setting;
    let axes = program.axes();
    let config: Config<S, N> = machine.config(&axes)?;
    let mut shaper = machine.shaper(&axes, &config)?;
    let mut stats = Stats { least_ahead: usize::MAX, ..Stats::default() };
    let start = coords::<N>(&program.start(), &axes).context("start point")?;
    let mut link = link::<S, N, BLOCKS, NODES>();
    let mut reshaping = machine.reshape.then(reshaping::<S, N>);
    let (mut planner, mut interpolator) =
        link.split(config, start).map_err(|error| said(&error, &axes))?;
    if let Some(memory) = reshaping.as_deref_mut() {
        planner.reshape(memory);
    }
    let controls = planner.controls();
    let mut moves = program.steps().peekable();
    let mut operator = Operator::new(events.list(), machine.seeker());
    let mut cycle = 0u64;
    let mut idle = 0;
    let mut view = View::new(program, &axes, S::EPSILON.to_f64());
    let mut origin = start;
    let mut before = None;
    view.show(0.0, observers)?;
    let pauses = program.summary().pauses;
    let mut at_pause = false;
    loop {
        let now = cycle as f64 * machine.cycle;
        operator.play(now, &mut planner, &axes).with_context(|| format!("at {now:.3} s"))?;
        operator.seek(&mut planner, &axes, moves.peek().is_some())?;
        // Planning takes no time here: what it makes room for is sent in the same cycle.
        let progress = loop {
            let fed = if now >= operator.silent_until {
                feed_blocks(&mut planner, &mut moves, &axes)?
            } else {
                0
            };
            stats.blocks += fed;
            let began = Instant::now();
            let progress = planner.settle();
            operator.seeker.hear(&mut planner, &axes, now);
            if progress == Progress::Planned {
                stats.planning.add(began);
                if moves.peek().is_some() {
                    stats.least_ahead = stats.least_ahead.min(planner.nodes_ahead());
                }
            }
            if fed == 0 {
                break progress;
            }
        };
        let waiting = progress == Progress::Held || now < operator.silent_until;
        if progress == Progress::Held && operator.is_done() {
            ensure!(std::mem::take(&mut at_pause), operator.wants());
            controls.resume();
        }
        let began = Instant::now();
        let setpoint = interpolator.tick();
        let setpoint = shaper.as_mut().map_or(setpoint, |shaper| shaper.shape(&setpoint));
        stats.ticks.add(began);
        cycle += 1;
        let from = before.replace(setpoint).unwrap_or(setpoint);
        operator.seeker.sense(planner.inputs(), &axes, (&from, &setpoint), machine.cycle);
        view.take(&setpoint, setpoint.origin != origin, &operator.seeker.shift);
        view.pace = operator.pace(waiting || is_beside(setpoint.activity, progress));
        origin = setpoint.origin;
        operator.quick &= setpoint.activity != Activity::Idle;
        view.show(cycle as f64 * machine.cycle, observers)?;
        match setpoint.activity {
            Activity::Event => at_pause = pauses.contains(&setpoint.tag),
            Activity::Running => at_pause = false,
            _ => {}
        }
        if setpoint.activity == Activity::Idle {
            if progress == Progress::Done && !operator.moves_later() {
                break;
            }
            if progress == Progress::Aborted {
                stats.aborted = true;
                check_rest(planner.end(), &setpoint, &axes)?;
                break;
            }
            idle = if waiting || progress == Progress::Done { 0 } else { idle + 1 };
            if idle > PATIENCE {
                bail!("line {}: the core found no motion from here", setpoint.tag);
            }
        } else {
            idle = 0;
        }
    }
    stats.counters = planner.counters();
    stats.unplayed = operator.events.map(|event| event.time).collect();
    stats.sought = operator.seeker.outcomes;
    if stats.least_ahead == usize::MAX {
        stats.least_ahead = 0;
    }
    Ok(stats)
}

/// Presses buttons when it is time.
struct Operator<'a> {
    events: std::iter::Peekable<std::slice::Iter<'a, Event>>,
    /// Overrides of feed and of rapids, per cent.
    overrides: (u16, u16),
    /// The producer sends nothing until then, s.
    silent_until: f64,
    /// Whether something was pressed in this cycle.
    pressed: bool,
    /// Whether a hold or a stop was asked for, and no resume since.
    held: bool,
    /// Whether a stop by the stop limits was asked for, and the machine has not rested since.
    quick: bool,
    /// Probes and homing.
    seeker: Seeker,
}

impl<'a> Operator<'a> {
    fn new(events: &'a [Event], seeker: Seeker) -> Self {
        let events = events.iter().peekable();
        Self {
            events,
            overrides: (100, 100),
            silent_until: 0.0,
            pressed: false,
            held: false,
            quick: false,
            seeker,
        }
    }

    fn play<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
        &mut self,
        now: f64,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        axes: &[usize],
    ) -> Result<()> {
        let controls = planner.controls();
        self.pressed = false;
        while let Some(event) = self.events.next_if(|event| event.time <= now) {
            self.pressed = true;
            match event.action {
                Action::Command(command) => {
                    command.send(controls);
                    match command {
                        Command::Jog(jog) => {
                            let jog = on_axes(&jog, axes)?.jog(&planner.jog_end());
                            let jog = jog.map_err(|refusal| said(&refusal, axes))?;
                            planner.jog(&jog).map_err(|error| said(&error, axes))?;
                        }
                        Command::FeedOverride(percent) => self.overrides.0 = percent,
                        Command::RapidOverride(percent) => self.overrides.1 = percent,
                        Command::QuickHold => (self.quick, self.held) = (true, true),
                        Command::QuickAbort => self.quick = true,
                        Command::Hold | Command::Stop => self.held = true,
                        Command::Resume => self.held = false,
                        _ => {}
                    }
                }
                Action::Seek(seek) => self.seeker.take(seek),
                Action::Starve(seconds) => self.silent_until = now + seconds,
            }
        }
        Ok(())
    }

    /// Begins the probes and homing that are due.
    fn seek<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        axes: &[usize],
        is_left: bool,
    ) -> Result<()> {
        // What follows in the program has been read for another place.
        if !(is_left && self.seeker.is_waiting()) {
            self.seeker.begin(planner, axes)?;
        }
        // They stop by the limits of stops.
        self.quick |= planner.is_probing() || planner.is_homing();
        Ok(())
    }

    /// Whether a jog, a probe or homing is still to come.
    fn moves_later(&self) -> bool {
        let moves = |event: &Event| {
            matches!(event.action, Action::Command(Command::Jog(_)) | Action::Seek(_))
        };
        self.seeker.is_waiting() || self.events.clone().any(moves)
    }

    fn is_done(&mut self) -> bool {
        self.events.peek().is_none()
    }

    /// What is missing in a run that stands still after the last event.
    fn wants(&self) -> String {
        let zero = [("feed", self.overrides.0), ("rapid", self.overrides.1)];
        let zero = zero.iter().filter(|(_, percent)| *percent == 0).map(|(name, _)| *name);
        let zero: Vec<&str> = zero.collect();
        if zero.is_empty() || self.held {
            return "the run is held after its last event: it needs a resume, and a jog-back before it if it was jogged away".to_owned();
        }
        format!(
            "the run stands still after its last event: {} is 0 %; it needs a value above 0",
            zero.join(" and ")
        )
    }

    fn pace(&self, waits: bool) -> Pace {
        let share = f64::from(self.overrides.0.min(self.overrides.1)) / 100.0;
        Pace { share, command: self.pressed, waits, quick: self.quick }
    }
}

/// A setpoint as observers see it.
struct View {
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    path: f64,
    speed: f64,
    tag: u32,
    activity: Activity,
    began: bool,
    unit: f64,
    pace: Pace,
}

impl View {
    fn new(program: &dyn Tape, axes: &[usize], unit: f64) -> Self {
        let zero = vec![0.0; axes.len()];
        Self {
            position: axes.iter().map(|&axis| program.start()[axis]).collect(),
            velocity: zero.clone(),
            acceleration: zero,
            path: 0.0,
            speed: 0.0,
            tag: 0,
            activity: Activity::Idle,
            began: false,
            unit,
            pace: Pace::FULL,
        }
    }

    /// Where the machine is, though its coordinates be set.
    fn take<S: Scalar, const N: usize>(
        &mut self,
        setpoint: &Setpoint<S, N>,
        began: bool,
        shift: &[f64; 9],
    ) {
        for (k, slot) in self.position.iter_mut().enumerate() {
            *slot = setpoint.position_mm(k) + shift[k];
            self.velocity[k] = setpoint.velocity[k].to_f64();
            self.acceleration[k] = setpoint.acceleration[k].to_f64();
        }
        self.path = setpoint.path_mm();
        self.speed = setpoint.path_speed.to_f64();
        self.tag = setpoint.tag;
        self.activity = setpoint.activity;
        self.began = began;
    }

    fn show(&self, time: f64, observers: &mut [&mut dyn Observer]) -> Result<()> {
        let sample = Sample {
            time,
            position: &self.position,
            velocity: &self.velocity,
            acceleration: &self.acceleration,
            path: self.path,
            speed: self.speed,
            tag: self.tag,
            activity: self.activity,
            began: self.began,
            unit: self.unit,
            pace: self.pace,
        };
        observers.iter_mut().try_for_each(|observer| observer.setpoint(&sample))
    }
}

/// Whether what the machine does is not the program's: a jog, or a rest behind its end.
fn is_beside(activity: Activity, progress: Progress) -> bool {
    activity == Activity::Jogging || (activity == Activity::Idle && progress == Progress::Done)
}

/// Pushes moves until the core takes no more; returns how many it took.
fn feed_blocks<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    moves: &mut std::iter::Peekable<impl Iterator<Item = Move>>,
    axes: &[usize],
) -> Result<u64> {
    let mut taken = 0;
    while let Some(step) = moves.peek() {
        let block = block::<S, N>(step, axes).with_context(|| format!("line {}", step.line))?;
        match planner.push(&block) {
            Ok(()) => {
                taken += 1;
                moves.next();
            }
            Err(PushError::Full | PushError::Aborted) => return Ok(taken),
            Err(PushError::Rejected { tag, reason }) => {
                bail!("line {tag}: {}", on_letters(&reason, axes))
            }
            Err(error) => bail!("line {}: {error}", step.line),
        }
    }
    planner.finish();
    Ok(taken)
}

/// Whether the machine stands where the core says after an abort.
fn check_rest<S: Scalar, const N: usize>(
    end: &[Coord; N],
    setpoint: &Setpoint<S, N>,
    axes: &[usize],
) -> Result<()> {
    for (k, place) in end.iter().enumerate() {
        let off = (place.to_mm() - setpoint.position_mm(k)).abs();
        let words = || format!("axis {k} stands {off} mm off where the core says");
        ensure!(off < 1.0e-5, said(&words(), axes));
    }
    Ok(())
}

fn coord(mm: f64) -> Result<Coord> {
    Coord::from_mm(mm).context("coordinate, mm")
}

fn coords<const N: usize>(point: &[f64], axes: &[usize]) -> Result<[Coord; N]> {
    let mut to = [Coord::ZERO; N];
    for (slot, &axis) in to.iter_mut().zip(axes) {
        *slot = coord(point[axis])?;
    }
    Ok(to)
}

/// A move as a block of the core.
///
/// # Errors
/// A coordinate out of range.
pub fn block<S: Scalar, const N: usize>(step: &Move, axes: &[usize]) -> Result<Block<S, N>> {
    let place = |axis: usize| axes.iter().position(|&used| used == axis).unwrap_or(N);
    let motion = match &step.path {
        Course::Line { to } => Motion::Line { to: coords(to, axes)? },
        Course::Arc { to, plane, centre, clockwise, extra_turns } => Motion::Arc {
            to: coords(to, axes)?,
            plane: (place(plane.0), place(plane.1)),
            centre: (coord(centre.0)?, coord(centre.1)?),
            turn: if *clockwise { Turn::Clockwise } else { Turn::CounterClockwise },
            extra_turns: *extra_turns,
        },
        Course::Cubic { controls: [first, second], to } => Motion::Cubic {
            controls: [coords(first, axes)?, coords(second, axes)?],
            to: coords(to, axes)?,
        },
        Course::Dwell { seconds } => Motion::Dwell { seconds: S::of(*seconds) },
        Course::Event { pause, .. } => Motion::Event { pause: *pause },
    };
    let feed = match step.speed {
        Speed::PerSecond(feed) => Feed::PerSecond(S::of(feed)),
        Speed::Duration(seconds) => Feed::Duration(S::of(seconds)),
        Speed::Rapid => Feed::Rapid,
    };
    Ok(Block {
        motion,
        feed,
        tolerance: step.tolerance.map(S::of),
        exact_stop: step.exact_stop,
        tag: step.line,
    })
}
