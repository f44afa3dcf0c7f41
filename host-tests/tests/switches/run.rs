//! Runs a program with a switch at the end of every block, before and behind it by a distance or a time, and checks where they
//! came.

use crate::common::machine;
use proptest::prelude::*;
use splineway::{
    Activity, Controls, Coord, Interpolator, Jog, Link, Output, Planner, Progress, PushError,
    Scalar, Setpoint, Switch, SwitchError, Trigger,
};
use splineway_simulator::program::{Move, Program};
use splineway_simulator::run::block;
use std::collections::VecDeque;

pub const AXES: usize = 3;
pub const CYCLE: f64 = 1.0e-3;

/// A command of the operator's.
#[derive(Clone, Copy, Debug)]
pub enum Command {
    Hold,
    Resume,
    Feed(u16),
    Single(bool),
    Stop,
}

#[derive(Clone, Debug)]
pub struct Case {
    /// Distance and time of the switches about the ends of blocks.
    pub distance: f64,
    pub time: f64,
    /// Cycles to wait, then a command.
    pub commands: Vec<(u32, Command)>,
    /// Slices of planning per servo cycle.
    pub slices: u32,
    /// Whether a held machine is jogged.
    pub jogs: bool,
}

/// What an output did.
#[derive(Clone, Copy, Debug)]
pub struct Fired {
    pub block: usize,
    /// In servo cycles.
    pub time: f64,
    /// Arc length there, mm.
    pub path: f64,
    pub place: [f64; AXES],
    /// Speed there, mm per servo cycle.
    speed: f64,
}

impl Fired {
    /// Servo cycles by which the time is uncertain at which the motion gets to the same place: near a rest, a place that
    /// is known to the tenth of a micrometre.
    pub fn fuzz(&self) -> f64 {
        (3.0e-4 / self.speed.abs()).min(3.0)
    }
}

/// A cubic through two values with their slopes, per cycle.
fn between(u: f64, (a, da): (f64, f64), (b, db): (f64, f64)) -> f64 {
    let v = 1.0 - u;
    let (c, d) = (a + da / 3.0, b - db / 3.0);
    v * v * v * a + 3.0 * v * v * u * c + 3.0 * v * u * u * d + u * u * u * b
}

#[derive(Default)]
pub struct Outcome {
    /// Of the analogue outputs: at the end; a distance off; a time before; a time behind.
    pub fired: [Vec<Fired>; 4],
    /// Of the digital one.
    pub toggles: Vec<Fired>,
    /// Ends of the blocks that move.
    pub ends: Vec<[f64; AXES]>,
    /// Times at which a standstill ended, and arc lengths.
    pub stands: Vec<(f64, f64)>,
    /// Time and arc length at which switches were pushed, by block.
    pub pushed: Vec<(f64, f64)>,
    /// Servo cycles in which the motion began.
    pub starts: Vec<f64>,
    /// Cells of the path.
    pub cells: u32,
    /// Jogs in a hold.
    pub jogs: u32,
}

pub fn there<S: Scalar>(
    (before, after): (&Setpoint<S, AXES>, &Setpoint<S, AXES>),
    u: f64,
) -> (f64, [f64; AXES]) {
    let slope = |x: S| x.to_f64() * CYCLE;
    let path = between(
        u,
        (before.path_mm(), slope(before.path_speed)),
        (after.path_mm(), slope(after.path_speed)),
    );
    let place = std::array::from_fn(|i| {
        between(
            u,
            (before.position_mm(i), slope(before.velocity[i])),
            (after.position_mm(i), slope(after.velocity[i])),
        )
    });
    (path, place)
}

/// The switches of a block.
fn switches<S: Scalar>(block: usize, case: &Case) -> [Switch<S>; 5] {
    let value = S::of(block as f64);
    let end = |output: u8| Switch::analogue(output, value).at(Trigger::End);
    [
        end(0),
        end(1).behind_mm(S::of(case.distance)),
        end(2).behind_s(S::of(-case.time)),
        end(3).behind_s(S::of(case.time)),
        Switch::digital(0, block.is_multiple_of(2)),
    ]
}

/// Gives the commands.
struct Operator<'a> {
    commands: std::slice::Iter<'a, (u32, Command)>,
    next: Option<(u32, Command)>,
}

impl<'a> Operator<'a> {
    fn new(commands: &'a [(u32, Command)]) -> Self {
        let mut commands = commands.iter();
        let next = commands.next().copied();
        Self { commands, next }
    }

    fn play(&mut self, cycle: u32, controls: Controls<'_>) {
        let Some((_, command)) = self.next.filter(|(when, _)| *when <= cycle) else { return };
        match command {
            Command::Hold => controls.hold(),
            Command::Resume => controls.resume(),
            Command::Feed(percent) => controls.feed_override(percent),
            Command::Single(on) => controls.single_block(on),
            Command::Stop => controls.stop(),
        }
        self.next = self.commands.next().map(|(wait, command)| (cycle + wait, *command));
        if self.next.is_none() {
            controls.single_block(false);
            controls.feed_override(100);
            controls.resume();
        }
    }
}

type Core<'a, S> = (Planner<'a, S, AXES, 8, 56>, Interpolator<'a, S, AXES>);

/// Pushes blocks and their switches.
struct Producer<'a, S> {
    moves: std::iter::Peekable<std::slice::Iter<'a, Move>>,
    waiting: VecDeque<Switch<S>>,
    here: [f64; 9],
}

impl<S: Scalar> Producer<'_, S> {
    /// As much as there is room for; `now`: servo cycle and arc length.
    fn push(
        &mut self,
        planner: &mut Planner<'_, S, AXES, 8, 56>,
        (case, now): (&Case, (f64, f64)),
        outcome: &mut Outcome,
    ) -> Result<(), String> {
        loop {
            while let Some(switch) = self.waiting.front() {
                match planner.push_switch(switch) {
                    Ok(()) => drop(self.waiting.pop_front()),
                    Err(SwitchError::Full) => return Ok(()),
                    Err(error) => return Err(error.to_string()),
                }
                if self.waiting.is_empty() {
                    outcome.pushed.push(now);
                }
            }
            let Some(step) = self.moves.peek() else {
                planner.finish();
                return Ok(());
            };
            match planner.push(&block::<S, AXES>(step, &[0, 1, 2]).unwrap()) {
                Ok(()) => {
                    let to = step.path.end().copied().unwrap_or(self.here);
                    let ways = to.iter().zip(&self.here).map(|(a, b)| (a - b).abs());
                    // One of no length is no block.
                    if ways.fold(0.0, f64::max) > 2.0e-6 {
                        self.waiting.extend(switches(outcome.ends.len(), case));
                        outcome.ends.push(std::array::from_fn(|axis| to[axis]));
                    }
                    self.here = to;
                    self.moves.next();
                }
                Err(PushError::Full) => return Ok(()),
                Err(error) => return Err(error.to_string()),
            }
        }
    }

    fn is_done(&mut self) -> bool {
        self.moves.peek().is_none() && self.waiting.is_empty()
    }
}

/// What is done while the machine is held: nothing, or a jog away and back; then a resume.
fn pause<S: Scalar>(
    planner: &mut Planner<'_, S, AXES, 8, 56>,
    (jogs, idle): (bool, u32),
    outcome: &mut Outcome,
) {
    let feed = S::of(60.0);
    let by = [0.3, -0.2, 0.0].map(|x| Coord::from_mm(x).unwrap());
    let away = planner.is_jogging();
    let jog = match idle {
        5.. if away => Jog::Back { feed },
        5 if jogs && outcome.jogs == 0 => Jog::Step { by, feed },
        21.. => return planner.controls().resume(),
        _ => return,
    };
    // At the end of the program there is nothing to go back to.
    outcome.jogs += u32::from(planner.jog(&jog).is_ok());
}

pub fn run<S: Scalar>(program: &Program, tolerance: f64, case: &Case) -> Result<Outcome, String> {
    let machine = machine(tolerance, (1.0, 1.0), AXES);
    let mut link = Box::new(Link::<S, AXES, 8, 56>::new());
    let (mut planner, mut interpolator): Core<'_, S> =
        link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
    let controls = planner.controls();
    let mut operator = Operator::new(&case.commands);
    let moves = program.moves.iter().peekable();
    let mut producer = Producer { moves, waiting: VecDeque::new(), here: program.start };
    let mut outcome = Outcome::default();
    let mut before = interpolator.tick();
    interpolator.switch(&before, |_| ());
    let mut idle = 0;
    for cycle in 0..200_000u32 {
        operator.play(cycle, controls);
        let now = (f64::from(cycle), before.path_mm());
        producer.push(&mut planner, (case, now), &mut outcome)?;
        let polls = (0..case.slices).map(|_| planner.poll());
        let progress = polls.into_iter().find(|progress| *progress != Progress::Planning);
        if progress == Some(Progress::Held) {
            pause(&mut planner, (case.jogs, idle), &mut outcome);
        }
        let after = interpolator.tick();
        outcome.note(f64::from(cycle), (&before, &after), &mut interpolator)?;
        idle = if after.activity == Activity::Idle { idle + 1 } else { 0 };
        before = after;
        if progress == Some(Progress::Done) && idle > 400 && producer.is_done() {
            outcome.cells = planner.counters().cells;
            return Ok(outcome);
        }
        if operator.next.is_none() && cycle > 100_000 {
            controls.resume();
        }
    }
    Err(format!("no end: {:?}", planner.counters()))
}

impl Outcome {
    /// A servo cycle.
    fn note<S: Scalar>(
        &mut self,
        cycle: f64,
        (before, after): (&Setpoint<S, AXES>, &Setpoint<S, AXES>),
        interpolator: &mut Interpolator<'_, S, AXES>,
    ) -> Result<(), String> {
        let stood =
            |at: &Setpoint<S, AXES>| matches!(at.activity, Activity::Dwelling | Activity::Event);
        if stood(before) && !stood(after) {
            self.stands.push((cycle, before.path_mm()));
        }
        if before.activity == Activity::Idle && after.activity == Activity::Running {
            self.starts.push(cycle);
        }
        let mut wrong = None;
        interpolator.switch(after, |switched| {
            let u = switched.fraction.to_f64();
            if !(0.0..=1.0).contains(&u) {
                wrong = Some(format!("{switched:?}"));
            }
            let (path, place) = there((before, after), u);
            let [was, is] = [before, after].map(|at| at.path_speed.to_f64() * CYCLE);
            let speed = was + (is - was) * u;
            let fired =
                |value: f64| Fired { block: value as usize, time: cycle + u, path, place, speed };
            match switched.output {
                Output::Analogue(output) => {
                    self.fired[usize::from(output)].push(fired(switched.value.to_f64()));
                }
                Output::Digital(0) => self.toggles.push(fired(switched.value.to_f64())),
                other => wrong = Some(format!("{other:?}")),
            }
        });
        wrong.map_or(Ok(()), Err)
    }
}

/// Of more than four switches in a servo cycle some have to wait for the next.
fn is_one_of_many(fired: &[Fired], i: usize) -> bool {
    i >= 4 && fired[i].time - fired[i - 4].time < 2.0
}

/// What was due switched, once and in order, where and when it was to.
pub fn check(outcome: &Outcome, tolerance: f64, case: &Case) -> Result<[usize; 2], TestCaseError> {
    let quiet = case.commands.is_empty();
    let [ends, offs, leads, lags] = &outcome.fired;
    prop_assert_eq!(ends.len(), outcome.ends.len());
    for (i, fired) in ends.iter().enumerate() {
        prop_assert_eq!(fired.block, i);
        let end = &outcome.ends[i];
        let off: f64 = (0..AXES).map(|k| (fired.place[k] - end[k]).powi(2)).sum::<f64>().sqrt();
        // At a sharp corner the vertex is further off than the legs are.
        prop_assert!(off <= tolerance * 8.0 + 1.0e-3, "block {i}: {off} mm off, {fired:?}");
    }
    for (i, fired) in outcome.toggles.iter().enumerate() {
        prop_assert_eq!(fired.block % 2, (i + 1) % 2);
        let late = fired.time - ends[i].time;
        prop_assert!(late > -1.0e-2, "block {i} starts before the one before has ended: {late}");
        prop_assert!((fired.path - ends[i].path).abs() < 1.0e-3, "{fired:?} {:?}", ends[i]);
    }
    let last = ends.last().map_or(0.0, |fired| fired.path);
    let mut exact = [0; 2];
    for (i, fired) in offs.iter().enumerate() {
        prop_assert_eq!(fired.block, i);
        let due = ends[i].path + case.distance;
        prop_assert!(fired.path > due - 2.0e-3, "block {i} early: {fired:?}, due at {due}");
        let floor = outcome.stands.iter().filter(|(time, _)| *time < ends[i].time + 0.5);
        let floor = floor.map(|(_, path)| *path).fold(0.0, f64::max);
        // All of it is known from the beginning.
        let free = outcome.cells < 40 && due > floor + 1.0e-3 && outcome.pushed[i].0 < 0.5;
        if free && quiet && !is_one_of_many(offs, i) {
            prop_assert!(
                fired.path < due + 2.0e-3,
                "block {i} late: {fired:?}, due at {due} {:?}",
                outcome.pushed[i]
            );
            exact[0] += 1;
        }
    }
    let missing = ends.iter().skip(offs.len());
    prop_assert!(missing.into_iter().all(|end| end.path + case.distance > last - 2.0e-3));
    prop_assert_eq!(leads.len(), ends.len());
    prop_assert_eq!(lags.len(), ends.len());
    for (i, end) in ends.iter().enumerate() {
        let (lead, lag) = (&leads[i], &lags[i]);
        prop_assert_eq!((lead.block, lag.block), (i, i));
        prop_assert!(lead.time <= end.time + 1.0e-2, "{lead:?} behind {end:?}");
        // One that is pushed late, for want of room, has its time from then on.
        let is_late = outcome.pushed[i].0 > end.time - 1.0;
        let after = end.time.max(outcome.pushed[i].0) + case.time / CYCLE;
        let near = if is_late || is_one_of_many(lags, i) { 2.0 } else { 1.0e-2 };
        prop_assert!((lag.time - after).abs() < near, "block {i}: {lag:?}, due at {after}");
        let due = end.time - case.time / CYCLE;
        // Plans that come after it differ a little.
        let early = 1.0 + end.fuzz() + lead.fuzz() + 0.05 * case.time / CYCLE;
        prop_assert!(!quiet || lead.time > due - early, "block {i}: {lead:?}, due at {due}");
        exact[1] += usize::from((lead.time - due).abs() < 0.05);
    }
    Ok(exact)
}
