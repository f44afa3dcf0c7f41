//! Bugs put in on purpose, between the core and those who use it: a soak that finds nothing means something
//! only if it finds these.

use super::referee::Sample;
use splineway::wire::Command;
use splineway::{Activity, AxisLimits, Config, Limits, Progress, Scalar};
use splineway_simulator::program::{Course, Move};

/// A bug.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // Names say it.
pub enum Plant {
    LostHold,
    LostAbort,
    LostStop,
    LostResume,
    LostFeed,
    AbortEndsHold,
    TakenAfterAbort,
    MovesWhileHeld,
    HeldInMotion,
    Crawl,
    NeverEnds,
    Velocity,
    Acceleration,
    Jerk,
    Band,
    BlockLost,
    BlockDoubled,
    EventLost,
    EventDoubled,
    DwellShort,
    DwellLong,
    JumpAtBlock,
    EndOff,
    PathBack,
    OfferFirst,
    RefusedIsTaken,
}

/// All of them.
pub const PLANTS: [Plant; 26] = [
    Plant::LostHold,
    Plant::LostAbort,
    Plant::LostStop,
    Plant::LostResume,
    Plant::LostFeed,
    Plant::AbortEndsHold,
    Plant::TakenAfterAbort,
    Plant::MovesWhileHeld,
    Plant::HeldInMotion,
    Plant::Crawl,
    Plant::NeverEnds,
    Plant::Velocity,
    Plant::Acceleration,
    Plant::Jerk,
    Plant::Band,
    Plant::BlockLost,
    Plant::BlockDoubled,
    Plant::EventLost,
    Plant::EventDoubled,
    Plant::DwellShort,
    Plant::DwellLong,
    Plant::JumpAtBlock,
    Plant::EndOff,
    Plant::PathBack,
    Plant::OfferFirst,
    Plant::RefusedIsTaken,
];

/// Stands between the core and the rest, and spoils what passes.
#[derive(Debug)]
pub struct Shim {
    plant: Option<Plant>,
    count: u32,
    tag: u32,
    since: u32,
    done: bool,
    event: Option<Sample>,
}

/// How much of a limit is too much.
const TOO_MUCH: f64 = 1.02;
/// A band that leads paths 2 per cent out of the band asked for: they use up to 0.97 of it.
const TOO_WIDE: f64 = 1.06;

impl Shim {
    /// A shim with a bug, or without.
    pub fn new(plant: Option<Plant>) -> Self {
        Self { plant, count: 0, tag: 0, since: 0, done: false, event: None }
    }

    /// Which bug.
    pub fn plant(&self) -> Option<Plant> {
        self.plant
    }

    /// Between the settings asked for and the core.
    pub fn config<S: Scalar, const N: usize>(&self, config: &mut Config<S, N>) {
        let scaled = |of: fn(&mut AxisLimits<S>) -> &mut S| {
            let mut axes = *config.limits.axes();
            for axis in &mut axes {
                let limit = of(axis);
                *limit = *limit * S::of(TOO_MUCH);
            }
            Limits::new(axes).unwrap_or(config.limits)
        };
        match self.plant {
            Some(Plant::Velocity) => config.limits = scaled(|axis| &mut axis.velocity),
            Some(Plant::Acceleration) => config.limits = scaled(|axis| &mut axis.acceleration),
            Some(Plant::Jerk) => config.limits = scaled(|axis| &mut axis.jerk),
            Some(Plant::Band) => config.tolerance = config.tolerance * S::of(TOO_WIDE),
            _ => {}
        }
    }

    /// Between the operator and the core: what arrives.
    pub fn press(&mut self, action: Command) -> [Option<Command>; 2] {
        match (self.plant, action) {
            (Some(Plant::LostHold), Command::Hold)
            | (Some(Plant::LostAbort), Command::Abort)
            | (Some(Plant::LostStop), Command::Stop)
            | (Some(Plant::LostResume), Command::Resume)
            | (Some(Plant::LostFeed | Plant::Crawl), Command::FeedOverride(_)) => [None, None],
            (Some(Plant::Crawl), Command::Resume) => [Some(action), Some(Command::FeedOverride(1))],
            _ => [Some(action), None],
        }
    }

    /// Between the producer and the core: what arrives.
    pub fn push(&mut self, step: &Move) -> [Option<Move>; 2] {
        self.count += 1;
        let mut step = step.clone();
        match self.plant {
            Some(Plant::BlockLost) if self.count.is_multiple_of(4) => return [None, None],
            Some(Plant::BlockDoubled) => return [Some(step.clone()), Some(step)],
            Some(Plant::DwellShort | Plant::DwellLong) => {
                let share = if self.plant == Some(Plant::DwellShort) { 0.9 } else { 1.1 };
                if let Course::Dwell { seconds } = &mut step.path {
                    *seconds *= share;
                }
            }
            _ => {}
        }
        [Some(step), None]
    }

    /// Between the interpolator and the drives.
    pub fn tick(&mut self, sample: &mut Sample) {
        self.since = if sample.tag == self.tag { self.since.saturating_add(1) } else { 0 };
        self.tag = sample.tag;
        match self.plant {
            Some(Plant::JumpAtBlock) if self.since < 20 && sample.tag > 1 => {
                sample.raw[0] += 1_000_000_000;
            }
            Some(Plant::EndOff) if self.done => sample.raw[0] += 2_000_000,
            Some(Plant::PathBack) if self.since == 5 => sample.path -= 0.002,
            Some(Plant::EventLost) if sample.activity == Activity::Event => {
                sample.activity = Activity::Idle;
            }
            Some(Plant::EventDoubled) => {
                if let Some(event) = self.event.take() {
                    *sample = event;
                } else if sample.activity == Activity::Event {
                    self.event = Some(*sample);
                }
            }
            _ => {}
        }
    }

    /// Between the planner and the producer.
    pub fn progress(&mut self, progress: Progress) -> Progress {
        self.done = progress == Progress::Done;
        match (self.plant, progress) {
            (Some(Plant::NeverEnds), Progress::Done) => Progress::NeedsBlocks,
            (Some(Plant::HeldInMotion), Progress::Planned) => Progress::Held,
            _ => progress,
        }
    }

    /// What reaches the core though nobody pressed it.
    pub fn secretly(&mut self, progress: Progress) -> Option<Command> {
        match (self.plant, progress) {
            (Some(Plant::MovesWhileHeld), Progress::Held)
            | (Some(Plant::AbortEndsHold), Progress::Aborted) => Some(Command::Resume),
            _ => None,
        }
    }
}
