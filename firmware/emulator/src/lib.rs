//! A run of the core as the emulated image and the host both make it, so that their setpoints can be
//! compared bit by bit: the same frames in, the same order of calls, one digest out.
//!
//! The image is `src/main.rs`; what compares is the bench `target` of the host's package. Nothing here knows
//! a chip.
#![no_std]

pub mod smoothing;

use crc::{CRC_32_ISCSI, Crc, Digest};
use serde::{Deserialize, Serialize};
use splineway::wire::Events;
use splineway::{
    Activity, AxisLimits, Config, ConfigError, Coord, CornerMode, Interpolator, Limits, Link,
    Planner, Progress, Scalar, Setpoint,
};
use splineway_controller::Background;

/// What the first frame says: the machine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// Axes: 3 or 6.
    pub axes: u8,
    /// Velocity, mm/s, acceleration, mm/s2, and jerk, mm/s3, of every axis.
    pub limits: [f32; 3],
    /// Tolerance, mm.
    pub tolerance: f32,
    /// Servo cycle, s.
    pub cycle: f32,
    /// Lambda of [`CornerMode::Paper`]; without one corners are the core's own.
    pub lambda: Option<f32>,
}

impl Setup {
    fn config<S: Scalar, const N: usize>(&self) -> Result<Config<S, N>, ConfigError> {
        let [velocity, acceleration, jerk] = self.limits.map(|x| S::of(f64::from(x)));
        let axis = AxisLimits::linear(velocity, acceleration, jerk);
        let mut config = Config::new(Limits::new([axis; N])?);
        config.tolerance = S::of(f64::from(self.tolerance));
        config.cycle = S::of(f64::from(self.cycle));
        if let Some(lambda) = self.lambda {
            config.corner = CornerMode::Paper { lambda: S::of(f64::from(lambda)) };
        }
        Ok(config)
    }
}

/// Parts of the core whose cost is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// `Planner::push` and `Planner::poll`.
    Planning,
    /// `Interpolator::tick`.
    Tick,
}

/// Counts what a part of the core costs.
pub trait Meter {
    /// A call begins.
    fn begin(&mut self);
    /// A call has ended.
    fn end(&mut self, part: Part);
}

/// What came out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Blocks run.
    pub blocks: u32,
    /// Servo cycles.
    pub cycles: u32,
    /// CRC-32/ISCSI of every field of every setpoint.
    pub digest: u32,
    /// Whether the end was reached.
    pub complete: bool,
}

/// Cycles at rest after which the end is not waited for any more.
const PATIENCE: u32 = 1000;

type Core<'a, S, const N: usize, const BLOCKS: usize, const NODES: usize> =
    (Planner<'a, S, N, BLOCKS, NODES>, Interpolator<'a, S, N>);

#[inline(never)]
fn plan<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    background: &mut Background<'_, '_, S, N, BLOCKS, NODES, 16, 4>,
) -> Progress {
    // Time stands still: nobody is missed.
    background.plan(0)
}

#[inline(never)]
fn tick<S: Scalar, const N: usize>(interpolator: &mut Interpolator<'_, S, N>) -> Setpoint<S, N> {
    interpolator.tick()
}

fn add<S: Scalar, const N: usize>(digest: &mut Digest<'_, u32>, setpoint: &Setpoint<S, N>) {
    for i in 0..N {
        digest.update(&setpoint.origin[i].raw().to_le_bytes());
        for x in [setpoint.offset[i], setpoint.velocity[i], setpoint.acceleration[i]] {
            digest.update(&x.to_f64().to_le_bytes());
        }
    }
    digest.update(&setpoint.path_origin.raw().to_le_bytes());
    digest.update(&setpoint.path_offset.to_f64().to_le_bytes());
    digest.update(&setpoint.path_speed.to_f64().to_le_bytes());
    digest.update(&setpoint.tag.to_le_bytes());
    digest.update(&[setpoint.activity as u8]);
}

/// Runs what `source` gives, byte by byte, to its end; `BLOCKS` blocks of look-ahead, a window of `NODES`
/// nodes.
///
/// # Errors
/// The setup cannot be used.
pub fn run<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    link: &mut Link<S, N, BLOCKS, NODES>,
    setup: &Setup,
    source: &mut dyn FnMut() -> Option<u8>,
    meter: &mut dyn Meter,
) -> Result<Outcome, ConfigError> {
    // Used where it has been made: a move would take its size of stack once more.
    let mut made = link.split(setup.config()?, [Coord::ZERO; N]);
    let (planner, interpolator): &mut Core<'_, S, N, BLOCKS, NODES> = match &mut made {
        Ok(core) => core,
        Err(error) => return Err(*error),
    };
    let crc = Crc::<u32>::new(&CRC_32_ISCSI);
    let mut digest = crc.digest();
    let mut outcome = Outcome::default();
    let events = Events::new();
    let mut background = Background::new(planner, &events);
    let mut idle = 0;
    let mut open = false;
    while idle < PATIENCE {
        while !background.is_full() {
            let Some(byte) = source() else { break };
            background.receive(byte);
            // The first frame opens the session, which is answered by the next poll.
            if !open && byte == 0 {
                open = true;
                break;
            }
        }
        loop {
            meter.begin();
            let progress = plan(&mut background);
            meter.end(Part::Planning);
            if progress != Progress::Planning {
                break;
            }
        }
        meter.begin();
        let setpoint = tick(interpolator);
        meter.end(Part::Tick);
        outcome.cycles += 1;
        add(&mut digest, &setpoint);
        if setpoint.activity != Activity::Idle {
            idle = 0;
            continue;
        }
        idle += 1;
        if background.is_done(&setpoint) {
            outcome.complete = true;
            break;
        }
    }
    outcome.blocks = background.taken().saturating_sub(1);
    outcome.digest = digest.finalize();
    Ok(outcome)
}
