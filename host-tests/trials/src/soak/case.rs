//! One case of the soak: everything about it follows from its number.

use super::draw::{log, steps};
use super::setting::Setting;
use fastrand::Rng;
use splineway::wire::Command;
use splineway_simulator::program::Move;

/// The moment that an operator waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// None.
    Now,
    /// A dwell is under way.
    Dwells,
    /// Slow, or at rest.
    Slow,
    /// At rest.
    Rests,
    /// The planner has said that it is held.
    Held,
    /// The planner has said that everything is dropped.
    Aborted,
    /// A plan has just been made.
    Planned,
    /// Another block has begun.
    Block,
    /// All is done.
    Done,
}

/// One command: which, and when after the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Press {
    /// What is awaited.
    pub moment: Moment,
    /// Servo cycles after that.
    pub cycles: u32,
    /// Accesses of the planner to shared state after that.
    pub accesses: u32,
    /// Which.
    pub action: Command,
}

impl Press {
    fn any(rng: &mut Rng) -> Self {
        use Command::{Abort, FeedOverride, Hold, RapidOverride, Resume, SingleBlock, Stop};
        let action = match rng.u8(..24) {
            0..=6 => Hold,
            7..=12 => Resume,
            13..=15 => Stop,
            16 | 17 => Abort,
            18 => SingleBlock(true),
            19 => SingleBlock(false),
            20 => RapidOverride([0, 10, 50, 100][rng.usize(..4)]),
            21 => FeedOverride(0),
            _ => FeedOverride([1, 5, 20, 50, 100, 120, 200][rng.usize(..7)]),
        };
        let moment = match rng.u8(..20) {
            0 | 1 => Moment::Dwells,
            2 | 3 => Moment::Slow,
            4 => Moment::Rests,
            5 | 6 => Moment::Held,
            7 => Moment::Aborted,
            8 => Moment::Planned,
            9 => Moment::Block,
            10 => Moment::Done,
            _ => Moment::Now,
        };
        let cycles = match rng.u8(..8) {
            0..=2 => 0,
            3 | 4 => rng.u32(..8),
            5 | 6 => log(rng, 0.0, 2.0) as u32,
            _ => log(rng, 0.0, 3.3) as u32,
        };
        let accesses = if rng.bool() { 0 } else { rng.u32(..60) };
        Self { moment, cycles, accesses, action }
    }
}

/// How planner, interrupt and operator come in between each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tempo {
    /// Chance that the one interrupt of a poll comes inside it.
    pub inside: f64,
    /// Chance of an interrupt at an access, with background work that is late.
    pub rough: f64,
    /// Most cycles that pass at one of these.
    pub burst: u32,
    /// Most polls per cycle.
    pub polls: u32,
}

/// The one who pushes blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Producer {
    /// Polls from one push to the next; 0 pushes as many as are taken.
    pub every: u32,
    /// After an abort: pushes the same block again and again all the same.
    pub stubborn: bool,
    /// Polls from the end of an abort to its acknowledgement.
    pub patience: u32,
    /// Says after every block that no more comes for now.
    pub finishes: bool,
}

/// A random program on a random machine, with or without an operator.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Decides what is not said here.
    pub seed: u64,
    /// The machine.
    pub setting: Setting,
    /// The program.
    pub steps: Vec<Move>,
    /// The operator.
    pub presses: Vec<Press>,
    /// The contexts.
    pub tempo: Tempo,
    /// The producer.
    pub producer: Producer,
}

/// Servo cycles of a program that stops after every block, at most.
const MOST_CYCLES: f64 = 15_000.0;

impl Case {
    /// The case with a number.
    pub fn new(number: u64) -> Self {
        let mut rng = Rng::with_seed(number.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5EED);
        let rng = &mut rng;
        let setting = Setting::any(rng);
        let velocity = setting.axes.iter().map(|axis| axis.velocity).fold(f64::INFINITY, f64::min);
        let size = velocity * log(rng, -2.2, -1.0);
        let mut steps = steps(rng, setting.axes.len(), setting.start, size, velocity);
        let (mut time, mut from, mut count) = (0.0, setting.start, 0);
        for step in &steps {
            time += super::bound::stop_time(&from, step, &setting);
            if time > MOST_CYCLES * setting.cycle && count > 0 {
                break;
            }
            count += 1;
            from = step.path.end().copied().unwrap_or(from);
        }
        steps.truncate(count);
        let presses: Vec<Press> = match rng.u8(..4) {
            0 => Vec::new(),
            1 => (0..rng.usize(1..4)).map(|_| Press::any(rng)).collect(),
            _ => (0..rng.usize(1..12)).map(|_| Press::any(rng)).collect(),
        };
        let mut presses = presses;
        if rng.u8(..3) == 0 {
            // One who cannot make up his mind.
            for (n, press) in presses.iter_mut().enumerate() {
                press.action = if n % 2 == 0 { Command::Hold } else { Command::Resume };
                if n > 0 {
                    press.moment = Moment::Now;
                    press.cycles = log(rng, 0.0, 2.0) as u32;
                }
            }
        }
        let is_rough = rng.u8(..3) == 0;
        let tempo = Tempo {
            inside: [0.0, 0.5, 1.0][rng.usize(..3)],
            rough: if is_rough { log(rng, -3.0, -0.5) } else { 0.0 },
            burst: log(rng, 0.0, 2.5) as u32,
            polls: rng.u32(1..4),
        };
        let producer = Producer {
            every: if rng.bool() { 0 } else { log(rng, 0.0, 2.5) as u32 },
            stubborn: rng.bool(),
            patience: rng.u32(..40),
            finishes: rng.u8(..6) == 0,
        };
        Self { seed: number, setting, steps, presses, tempo, producer }
    }
}
