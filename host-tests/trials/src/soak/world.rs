//! Planner, interrupt and operator, one in between the other.
//!
//! Everything runs in one thread. Before every access to state that contexts share the core calls
//! [`Contexts::point`]: there the interrupt or the operator may come in, as they may on a machine - the
//! interrupt into anything but itself, the operator into the planner's calls. Who comes in when follows
//! from the case's seed.

use super::api;
use super::case::{Case, Moment, Press, Producer, Tempo};

use super::plant::{Plant, Shim};
use super::referee::{Finding, Print, Referee, Rule, Sample};
use super::setting::Core;
use fastrand::Rng;
use splineway::wire::Command;
use splineway::{
    Activity, Block, Controls, Coord, Interpolator, Link, Planner, Progress, PushError, Scalar,
};
use splineway_simulator::program::{AXES, Move, Point};
use splineway_simulator::run::block;
use std::cell::{Cell, RefCell};

/// What comes in at an access to shared state.
trait Contexts {
    fn point(&self);
}

#[cfg(feature = "interleave")]
mod hook {
    // The macro's own, for a reference that lives as long as the call.
    #![allow(unsafe_code)]
    use super::{Contexts, Plant};
    use splineway::servo::interleave::{Fault, plant, set};
    scoped_tls_hkt::scoped_thread_local!(static CONTEXTS: for<'a> &'a (dyn Contexts + 'a));

    /// Calls `body` while `contexts` come in at every access to shared state.
    pub fn with(contexts: &dyn Contexts, bug: Option<Plant>, body: impl FnOnce()) {
        plant(match bug {
            Some(Plant::OfferFirst) => Some(Fault::OfferFirst),
            Some(Plant::RefusedIsTaken) => Some(Fault::RefusedIsTaken),
            _ => None,
        });
        set(Some(|| CONTEXTS.with(|contexts| contexts.point())));
        CONTEXTS.set(contexts, body);
        set(None);
        plant(None);
    }
}

#[cfg(not(feature = "interleave"))]
mod hook {
    use super::{Contexts, Plant};

    /// Without the core's feature nothing comes in.
    pub fn with(_: &dyn Contexts, _: Option<Plant>, body: impl FnOnce()) {
        body();
    }
}

/// Cycles after which an operator presses even if the moment has not come.
const PATIENCE: u32 = 1500;
/// Cycles until all has been pressed, at most. Then the referee has a deadline, which follows from the program: an arc of sixty turns
/// by itself takes longer than this at thirty microseconds a cycle.
const MOST_CYCLES: u64 = 400_000;
/// Polls that a stubborn producer goes on pushing after an abort.
const STUBBORN: u32 = 60;

/// The operator: what is pressed next, and whether its moment has come.
#[derive(Debug)]
struct Operator {
    presses: std::vec::IntoIter<Press>,
    next: Option<Press>,
    /// Cycles awaited so far; whether the moment has come.
    waited: u32,
    come: bool,
    /// Polls since it was due.
    overdue: u32,
}

impl Operator {
    fn new(presses: &[Press]) -> Self {
        let presses: Vec<Press> = presses.into();
        let mut presses = presses.into_iter();
        let next = presses.next();
        Self { presses, next, waited: 0, come: false, overdue: 0 }
    }

    /// A cycle has passed, or a poll.
    fn sees(&mut self, moment: impl Fn(Moment) -> bool, cycles: u32) {
        let Some(next) = &mut self.next else { return };
        if !self.come {
            self.waited += cycles;
            self.come = next.moment == Moment::Now || moment(next.moment) || self.waited > PATIENCE;
        } else if next.cycles > 0 {
            next.cycles -= cycles.min(next.cycles);
        }
    }

    fn is_due(&self) -> bool {
        self.come && self.next.is_some_and(|next| next.cycles == 0)
    }

    /// At an access: what is to be pressed here.
    fn at_access(&mut self) -> Option<Command> {
        if !self.is_due() {
            return None;
        }
        let next = self.next.as_mut()?;
        if next.accesses > 0 {
            next.accesses -= 1;
            return None;
        }
        self.take()
    }

    /// Between two calls of the planner.
    fn between(&mut self) -> Option<Command> {
        if !self.is_due() {
            return None;
        }
        self.overdue += 1;
        let next = self.next?;
        if next.accesses > 0 && self.overdue < 4 {
            return None;
        }
        self.take()
    }

    fn take(&mut self) -> Option<Command> {
        let action = self.next.map(|next| next.action);
        self.next = self.presses.next();
        (self.waited, self.come, self.overdue) = (0, false, 0);
        if let Some(next) = &self.next {
            self.come = next.moment == Moment::Now;
        }
        action
    }

    fn is_done(&self) -> bool {
        self.next.is_none()
    }
}

/// The contexts of a run besides the planner's.
struct World<'a, S: Scalar, const N: usize> {
    interpolator: RefCell<Interpolator<'a, S, N>>,
    controls: Controls<'a>,
    referee: RefCell<Referee>,
    operator: RefCell<Operator>,
    shim: RefCell<Shim>,
    rng: RefCell<Rng>,
    tempo: Cell<Tempo>,
    /// Contexts above the planner: 0 none, 1 the operator, 2 the interrupt.
    depth: Cell<u8>,
    /// Access at which the interrupt of this poll comes, if it comes inside.
    tick_at: Cell<Option<u32>>,
    aborts: Cell<u32>,
}

impl<S: Scalar, const N: usize> Contexts for World<'_, S, N> {
    fn point(&self) {
        let depth = self.depth.get();
        if depth >= 2 || self.referee.borrow().finding.is_some() {
            return;
        }
        if depth == 0 {
            let action = self.operator.borrow_mut().at_access();
            if let Some(action) = action {
                self.press(action);
            }
        }
        if let Some(at) = self.tick_at.get() {
            self.tick_at.set(at.checked_sub(1));
            if at == 0 {
                self.tick();
            }
        }
        let Tempo { rough, burst, .. } = self.tempo.get();
        if rough > 0.0 && self.rng.borrow_mut().f64() < rough {
            let ticks = self.rng.borrow_mut().u32(1..=burst.max(1));
            for _ in 0..ticks {
                self.tick();
            }
        }
    }
}

impl<S: Scalar, const N: usize> World<'_, S, N> {
    fn press(&self, action: Command) {
        let depth = self.depth.replace(1);
        self.referee.borrow_mut().presses(action);
        let shown = self.shim.borrow_mut().press(action);
        for action in shown.into_iter().flatten() {
            action.send(self.controls);
        }
        if action == Command::Abort {
            self.aborts.set(self.aborts.get() + 1);
        }
        self.referee.borrow_mut().pressed(action);
        self.depth.set(depth);
    }

    fn tick(&self) {
        let depth = self.depth.replace(2);
        let setpoint = self.interpolator.borrow_mut().tick();
        let mut sample = Sample {
            raw: [0; AXES],
            velocity: [0.0; AXES],
            acceleration: [0.0; AXES],
            offset: setpoint.path_offset.to_f64().abs(),
            path: setpoint.path_mm(),
            speed: setpoint.path_speed.to_f64(),
            tag: setpoint.tag,
            activity: setpoint.activity,
        };
        for n in 0..N {
            sample.raw[n] = setpoint.position(n).raw();
            sample.velocity[n] = setpoint.velocity[n].to_f64();
            sample.acceleration[n] = setpoint.acceleration[n].to_f64();
            sample.offset = sample.offset.max(setpoint.offset[n].to_f64().abs());
        }
        self.shim.borrow_mut().tick(&mut sample);
        let mut referee = self.referee.borrow_mut();
        let last = *referee.last();
        referee.tick(&sample);
        let rests = referee.rests();
        drop(referee);
        let top = last.speed.max(sample.speed);
        self.operator.borrow_mut().sees(
            |moment| match moment {
                Moment::Dwells => sample.activity == Activity::Dwelling,
                Moment::Slow => {
                    sample.activity == Activity::Running && sample.speed < last.speed && top < 2.0
                }
                Moment::Rests => rests,
                Moment::Block => sample.tag != last.tag,
                _ => false,
            },
            1,
        );
        self.depth.set(depth);
    }

    fn finding(&self) -> Option<Finding> {
        self.referee.borrow().finding.clone()
    }
}

/// The axes of a program, in their order.
const EVERY: [usize; AXES] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

/// The producer under way.
struct Feeder<'a> {
    steps: &'a [Move],
    next: usize,
    producer: Producer,
    polls: u32,
    /// A push has been refused because of an abort.
    refused: bool,
    /// Polls since the abort was said to be complete.
    aborted: u32,
    finished: bool,
}

/// What a run was like.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// What was found.
    pub finding: Option<Finding>,
    /// Blocks run; servo cycles judged.
    pub blocks: u64,
    /// As above.
    pub cycles: u64,
    /// Time over the time with a stop after every block, if nothing was pressed.
    pub against_stops: Option<f64>,
    /// What happened last.
    pub log: Vec<String>,
}

type Background<'a, S, const N: usize, const BLOCKS: usize, const NODES: usize> =
    Planner<'a, S, N, BLOCKS, NODES>;

impl Feeder<'_> {
    /// Pushes what is due.
    fn push<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Background<'_, S, N, BLOCKS, NODES>,
        world: &World<'_, S, N>,
        at_once: bool,
    ) {
        self.polls += 1;
        let every = if at_once { 0 } else { self.producer.every };
        if every > 0 && !self.polls.is_multiple_of(every) {
            return;
        }
        while let Some(step) = self.steps.get(self.next) {
            let tag = self.next as u32 + 1;
            let (aborts, plant) = (world.aborts.get(), world.shim.borrow().plant());
            let shown = world.shim.borrow_mut().push(step);
            let (mut result, mut beyond) = (Ok(()), false);
            for step in shown.iter().flatten() {
                match block::<S, N>(step, &EVERY[..N]) {
                    Ok(block) => result = api::told(planner, &Block { tag, ..block }, plant),
                    Err(_) => beyond = true,
                }
            }
            match result {
                // What is out of range is refused before the core sees it.
                _ if beyond => {
                    self.next += 1;
                    world.referee.borrow_mut().refused();
                }
                Ok(()) => {
                    self.next += 1;
                    self.finished = false;
                    let mut end = [0; AXES];
                    for (slot, at) in end.iter_mut().zip(planner.end()) {
                        *slot = at.raw();
                    }
                    let excused = aborts != world.aborts.get();
                    world.referee.borrow_mut().take(step, tag, end, excused);
                }
                Err(PushError::Rejected { .. }) => {
                    // A program with such a block is refused; here it goes on without.
                    self.next += 1;
                    world.referee.borrow_mut().refused();
                }
                Err(PushError::Aborted) => {
                    self.refused = true;
                    break;
                }
                Err(PushError::Full) => break,
                Err(error) => unreachable!("no judge knows of it: {error}"),
            }
            if self.producer.finishes && !at_once {
                planner.finish();
            }
            if every > 0 || world.finding().is_some() {
                return;
            }
        }
        if self.next >= self.steps.len() && !self.finished {
            planner.finish();
            self.finished = true;
        }
    }

    /// What the producer does about an abort.
    fn answer_abort<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Background<'_, S, N, BLOCKS, NODES>,
        world: &World<'_, S, N>,
        progress: Progress,
    ) {
        if progress == Progress::Aborted {
            self.aborted += 1;
            // The moment has come for those who wait for it.
            self.refused = true;
        }
        let due = self.aborted > self.producer.patience
            && !(self.producer.stubborn && self.aborted < STUBBORN);
        if !due {
            return;
        }
        let aborts = world.aborts.get();
        if api::acknowledge(planner) {
            let mut end = [0; AXES];
            for (slot, at) in end.iter_mut().zip(planner.end()) {
                *slot = at.raw();
            }
            let given = aborts != world.aborts.get();
            let mut referee = world.referee.borrow_mut();
            referee.acknowledge(end, given);
            referee.starts_at(self.next as u32 + 1);
            (self.refused, self.aborted, self.finished) = (false, 0, false);
        }
    }

    /// Whether blocks may be pushed, by the contract.
    fn may_push(&self) -> bool {
        self.producer.stubborn || !self.refused
    }

    /// Time of what is still to be pushed, with a stop after every block, s.
    fn to_come(&self, case: &Case, from: Point) -> f64 {
        let mut from = from;
        let mut time = 0.0;
        for step in self.steps.iter().skip(self.next) {
            time += super::bound::stop_time(&from, step, &case.setting);
            from = step.path.end().copied().unwrap_or(from);
        }
        time
    }
}

fn drive<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    case: &Case,
    plant: Option<Plant>,
    print: Option<Print>,
) -> Run {
    let mut run = Run::default();
    let shim = Shim::new(plant);
    let Ok(mut config) = case.setting.config::<S, N>() else { return run };
    shim.config(&mut config);
    let mut link = Box::new(Link::<S, N, BLOCKS, NODES>::new());
    let start = std::array::from_fn(|n| {
        Coord::from_mm(case.setting.start[n]).expect("cases start within the range")
    });
    let Ok((mut planner, interpolator)) = link.split(config, start) else {
        return run;
    };
    let world = World {
        interpolator: RefCell::new(interpolator),
        controls: planner.controls(),
        referee: RefCell::new(Referee::new(&case.setting, case.tempo.rough > 0.0, print)),
        operator: RefCell::new(Operator::new(&case.presses)),
        shim: RefCell::new(shim),
        rng: RefCell::new(Rng::with_seed(case.seed ^ 0x00C0_FFEE)),
        tempo: Cell::new(case.tempo),
        depth: Cell::new(0),
        tick_at: Cell::new(None),
        aborts: Cell::new(0),
    };
    let mut feeder = Feeder {
        steps: &case.steps,
        next: 0,
        producer: case.producer,
        polls: 0,
        refused: false,
        aborted: 0,
        finished: false,
    };
    hook::with(&world, plant, || turn(case, &mut planner, &world, &mut feeder));
    run.finding = world.finding();
    let referee = world.referee.borrow();
    (run.blocks, run.cycles) = (feeder.next as u64, referee.cycles());
    run.log = referee.log().cloned().collect();
    if case.presses.is_empty() && case.tempo.rough == 0.0 && case.producer.every == 0 {
        // Starts and ends fall on whole cycles.
        let (cycle, stops) = (case.setting.cycle, referee.stops());
        let time = referee.cycles() as f64 * cycle - CYCLES * cycle;
        run.against_stops = Some(time / stops.max(cycle));
    }
    run
}

/// Servo cycles that do not count in a comparison of times.
const CYCLES: f64 = 8.0;

/// The background's loop, with the interrupt in between.
fn turn<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    case: &Case,
    planner: &mut Background<'_, S, N, BLOCKS, NODES>,
    world: &World<'_, S, N>,
    feeder: &mut Feeder<'_>,
) {
    let mut released = false;
    loop {
        let Tempo { inside, polls, rough, .. } = world.tempo.get();
        let (ticks, polls) = {
            let mut rng = world.rng.borrow_mut();
            let inside = rng.f64() < inside;
            world.tick_at.set(inside.then(|| rng.u32(..24)));
            let ticks = if rough > 0.0 { [0, 1, 1, 3][rng.usize(..4)] } else { u32::from(!inside) };
            (ticks, rng.u32(1..=polls))
        };
        if feeder.may_push() {
            feeder.push(planner, world, released);
        }
        let mut progress = Progress::Waiting;
        for _ in 0..polls {
            world.referee.borrow_mut().polls();
            let said = planner.settle();
            progress = world.shim.borrow_mut().progress(said);
            world.referee.borrow_mut().polled(progress);
            let secret = world.shim.borrow_mut().secretly(progress);
            if let Some(action) = secret {
                action.send(world.controls);
            }
            world.operator.borrow_mut().sees(
                |moment| match moment {
                    Moment::Held => progress == Progress::Held,
                    Moment::Aborted => progress == Progress::Aborted,
                    Moment::Planned => progress == Progress::Planned,
                    Moment::Done => progress == Progress::Done,
                    _ => false,
                },
                0,
            );
        }
        feeder.answer_abort(planner, world, progress);
        let action = world.operator.borrow_mut().between();
        if let Some(action) = action {
            world.press(action);
        }
        if world.tick_at.replace(None).is_some() {
            world.tick();
        }
        for _ in 0..ticks {
            world.tick();
        }
        if world.finding().is_some() {
            return;
        }
        let rests = world.referee.borrow().rests();
        if !released && world.operator.borrow().is_done() {
            released = true;
            for action in [
                Command::SingleBlock(false),
                Command::FeedOverride(100),
                Command::RapidOverride(100),
                Command::Resume,
            ] {
                world.press(action);
            }
            world.tempo.set(Tempo { rough: 0.0, ..world.tempo.get() });
        } else if released && rests && progress == Progress::Held {
            world.press(Command::Resume);
        }
        if released && !world.referee.borrow().is_released() {
            let from = *world.referee.borrow().path_end();
            let to_come = feeder.to_come(case, from);
            world.referee.borrow_mut().release(to_come);
        }
        if released && rests && progress == Progress::Done && feeder.finished {
            return;
        }
        let mut referee = world.referee.borrow_mut();
        if !referee.is_released() && referee.cycles() > MOST_CYCLES {
            referee.find(Rule::TooLong, "the case does not end".to_owned());
        }
    }
}

/// Runs a case. A panic is a finding too.
pub fn run(case: &Case, plant: Option<Plant>, print: Option<Print>) -> Run {
    std::panic::catch_unwind(|| run_core(case, plant, print)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or_default();
        let finding = Finding { rule: Rule::Panic, text: text.to_owned(), cycle: 0 };
        Run { finding: Some(finding), ..Run::default() }
    })
}

fn run_core(case: &Case, plant: Option<Plant>, print: Option<Print>) -> Run {
    match case.setting.core {
        Core::F64x1x4x48 => drive::<f64, 1, 4, 48>(case, plant, print),
        Core::F64x2x16x64 => drive::<f64, 2, 16, 64>(case, plant, print),
        Core::F64x3x8x56 => drive::<f64, 3, 8, 56>(case, plant, print),
        Core::F64x3x64x192 => drive::<f64, 3, 64, 192>(case, plant, print),
        Core::F64x6x16x64 => drive::<f64, 6, 16, 64>(case, plant, print),
        Core::F64x9x16x64 => drive::<f64, 9, 16, 64>(case, plant, print),
        Core::F32x1x16x64 => drive::<f32, 1, 16, 64>(case, plant, print),
        Core::F32x2x8x48 => drive::<f32, 2, 8, 48>(case, plant, print),
        Core::F32x3x16x64 => drive::<f32, 3, 16, 64>(case, plant, print),
        Core::F32x4x128x96 => drive::<f32, 4, 128, 96>(case, plant, print),
        Core::F32x9x8x56 => drive::<f32, 9, 8, 56>(case, plant, print),
    }
}
