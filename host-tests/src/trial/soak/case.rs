//! One case of the soak: everything about it follows from its number.

use super::super::moves::between;
use super::draw::{Place, Step, log, steps};
use fastrand::Rng;
use splineway::machine::Quantity;
use splineway::number::Range;
use splineway::wire::Command;
use splineway::{AxisLimits, Config, ConfigError, CornerMode, Limits, Scalar};
use splineway_simulator::machine::Axis;
use splineway_simulator::program::AXES;

/// The cores that are soaked: scalar, axes, blocks, nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // Names say it.
pub enum Core {
    F64x1x4x48,
    F64x2x16x64,
    F64x3x8x56,
    F64x3x64x192,
    F64x6x16x64,
    F64x9x16x64,
    F32x1x16x64,
    F32x2x8x48,
    F32x3x16x64,
    F32x4x128x96,
    F32x9x8x56,
}

/// All of them, with their numbers of axes.
pub const CORES: [(Core, usize); 11] = [
    (Core::F64x1x4x48, 1),
    (Core::F64x2x16x64, 2),
    (Core::F64x3x8x56, 3),
    (Core::F64x3x64x192, 3),
    (Core::F64x6x16x64, 6),
    (Core::F64x9x16x64, 9),
    (Core::F32x1x16x64, 1),
    (Core::F32x2x8x48, 2),
    (Core::F32x3x16x64, 3),
    (Core::F32x4x128x96, 4),
    (Core::F32x9x8x56, 9),
];

/// The machine of a case and how its core is set up.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Which core.
    pub core: Core,
    /// Limits of its axes.
    pub axes: Vec<Axis>,
    /// Axes that turn: from this one on.
    pub rotary_from: usize,
    /// s.
    pub cycle: f64,
    /// mm.
    pub tolerance: f64,
    /// s.
    pub lead: f64,
    /// s.
    pub start_delay: f64,
    /// Overlap factor of the paper's corners, if they are used.
    pub lambda: Option<f64>,
    /// Improvement steps.
    pub iterations: u16,
    /// Smoothing sweeps.
    pub sweeps: u16,
    /// Where the machine stands at first.
    pub start: Place,
}

impl Setting {
    /// Whether the core computes in `f64`.
    pub fn is_double(&self) -> bool {
        CORES.iter().position(|(core, _)| *core == self.core) < Some(6)
    }

    /// For the core.
    ///
    /// # Errors
    /// What it does not accept.
    pub fn config<S: Scalar, const N: usize>(&self) -> Result<Config<S, N>, ConfigError> {
        let limits = std::array::from_fn(|n| AxisLimits {
            velocity: S::of(self.axes[n].velocity),
            acceleration: S::of(self.axes[n].acceleration),
            jerk: S::of(self.axes[n].jerk),
            rotary: n >= self.rotary_from,
        });
        let mut config = Config::new(Limits::new(limits)?);
        config.cycle = S::of(self.cycle);
        config.tolerance = S::of(self.tolerance);
        config.lead = S::of(self.lead);
        config.start_delay = S::of(self.start_delay);
        config.iterations = self.iterations;
        config.sweeps = self.sweeps;
        if let Some(lambda) = self.lambda {
            config.corner = CornerMode::Paper { lambda: S::of(lambda) };
        }
        config.check()?;
        Ok(config)
    }

    fn any(rng: &mut Rng) -> Self {
        let (core, count) = CORES[rng.usize(..CORES.len())];
        let usual = Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 };
        let base = if rng.u8(..3) == 0 {
            usual
        } else {
            let velocity = log(rng, 0.5, 3.3);
            let acceleration = velocity / log(rng, -2.0, 0.0);
            Axis { velocity, acceleration, jerk: acceleration / log(rng, -2.5, -0.7) }
        };
        let unequal = rng.u8(..4);
        let axes = (0..count)
            .map(|n| {
                let share = match unequal {
                    0 => 1.0 - 0.08 * n as f64,
                    1 => log(rng, -1.0, 0.0),
                    _ => 1.0,
                };
                let Axis { velocity, acceleration, jerk } = base;
                Axis {
                    velocity: velocity * share,
                    acceleration: acceleration * share,
                    jerk: jerk * share,
                }
            })
            .collect();
        // Where nothing is said, what is usual; often enough anything that is accepted.
        let or = |rng: &mut Rng, usual: f64, any: fn(&mut Rng) -> f64| {
            if rng.bool() { usual } else { any(rng) }
        };
        let mut start = [0.0; AXES];
        if rng.u8(..4) == 0 {
            for slot in &mut start[..count] {
                *slot = (between(rng, -1.0, 1.0) * 2.0e6).round() * 1.0e-3;
            }
        }
        Self {
            core,
            axes,
            rotary_from: if rng.bool() { 3 } else { AXES },
            cycle: or(rng, 1.0e-3, |rng| log(rng, -4.7, -2.0)),
            tolerance: or(
                rng,
                0.01,
                |rng| if rng.u8(..6) == 0 { 0.0 } else { log(rng, -3.5, 0.0) },
            ),
            lead: or(rng, 0.01, |rng| if rng.u8(..4) == 0 { 0.0 } else { log(rng, -3.0, -0.3) }),
            start_delay: or(rng, 0.05, |rng| if rng.bool() { 0.0 } else { log(rng, -3.0, -0.5) }),
            lambda: (rng.u8(..7) == 0).then(|| [0.0, 0.99, rng.f64() * 0.99][rng.usize(..3)]),
            iterations: within(
                Quantity::Iterations,
                [40, 40, 40, 0, 15, 20, 100, 1000][rng.usize(..8)],
            ),
            sweeps: within(Quantity::Sweeps, [8, 8, 8, 8, 0, 1, 2, 32, 1000][rng.usize(..9)]),
            start,
        }
    }
}

/// The nearest number that is accepted for a setting.
fn within(quantity: Quantity, value: u16) -> u16 {
    let Range { least, greatest } = quantity.range();
    f64::from(value).clamp(least, greatest) as u16
}

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
    pub steps: Vec<Step>,
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
            from = step.to().copied().unwrap_or(from);
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
