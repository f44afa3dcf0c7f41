//! A run of a controller in which planning takes time, as the emulated image makes it; and the same in which
//! it takes none, as a host makes it to compare.
//!
//! The image is `src/main.rs`: a timer interrupt calls [`Servo::cycle`] once per servo cycle of virtual time, and the
//! background goes round meanwhile. What comes of it is read by the bench `realtime` of the host's package.
//! Nothing here knows a chip.
#![no_std]

use serde::{Deserialize, Serialize};
use splineway::wire::Events;
use splineway::{
    Activity, AxisLimits, BLOCKS, Config, ConfigError, Controls, Interpolator, Limits, Progress,
    Setpoint,
};
use splineway_controller::Background;

/// Axes.
pub const AXES: usize = 3;
/// Events that may be on their way from interrupt to background.
pub const EVENTS: usize = 4;
/// Items that wait for the planner.
pub const QUEUE: usize = 16;
/// Nodes of the planning window where motion is reshaped, which takes room for its stations.
pub const RESHAPED_NODES: usize = 256;
/// Bytes that a round takes from the line at most: what is dropped for an abort must not take longer than what a real line brings.
pub const LINE: usize = 128;
/// Most commands in a run.
pub const COMMANDS: usize = 8;

/// What the first frame says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// Velocity, mm/s, acceleration, mm/s2, and jerk, mm/s3, of every axis.
    pub limits: [f32; 3],
    /// Tolerance, mm.
    pub tolerance: f32,
    /// Servo cycle, s.
    pub cycle: f32,
    /// Time by which plans are handed over before they take effect, s.
    pub lead: f32,
    /// Time of an instruction, ns.
    pub instruction: u32,
    /// The run ends after this many servo cycles whatever happens.
    pub most_cycles: u32,
    /// It ends when the machine has been at rest for this many servo cycles after the last command; 0: at the end
    /// of the program only.
    pub linger: u32,
    /// An operator's commands, in order.
    pub commands: heapless::Vec<Due, COMMANDS>,
}

impl Setup {
    /// The settings of the core.
    ///
    /// # Errors
    /// They cannot be used.
    pub fn config(&self) -> Result<Config<f32, AXES>, ConfigError> {
        let [velocity, acceleration, jerk] = self.limits;
        let axis = AxisLimits::linear(velocity, acceleration, jerk);
        let mut config = Config::new(Limits::new([axis; AXES])?);
        config.tolerance = self.tolerance;
        config.cycle = self.cycle;
        config.lead = self.lead;
        Ok(config)
    }
}

/// A command at a servo cycle: given in the interrupt, after that cycle's setpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Due {
    /// Number of the cycle.
    pub cycle: u32,
    /// What is asked for.
    pub order: Order,
}

/// What an operator asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Order {
    /// Feed hold.
    Hold,
    /// On from a hold.
    Resume,
    /// Stop at the end of a block.
    Stop,
    /// Stop, and drop the program.
    Abort,
    /// Feed override, per cent.
    Feed(u16),
}

impl Order {
    fn give(self, controls: Controls<'_>) {
        match self {
            Self::Hold => controls.hold(),
            Self::Resume => controls.resume(),
            Self::Stop => controls.stop(),
            Self::Abort => controls.abort(),
            Self::Feed(percent) => controls.feed_override(percent),
        }
    }
}

/// What is kept of a servo cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Arc length from the start, in units of [`splineway::number::ArcLength`].
    pub path: i64,
    /// Speed along the path, mm/s.
    pub speed: f32,
    /// Whether the machine is at rest with nothing to do.
    pub idle: bool,
    /// Velocities of the axes, mm/s.
    pub velocity: [f32; AXES],
    /// Accelerations of the axes, mm/s2.
    pub acceleration: [f32; AXES],
    /// Positions of the axes, nm.
    pub position: [i32; AXES],
}

impl Sample {
    /// Bytes of a sample in a file.
    pub const SIZE: usize = 8 + 4 + 4 + 3 * AXES * 4;
    /// Before the first cycle.
    pub const EMPTY: Self = Self {
        path: 0,
        speed: 0.0,
        idle: true,
        velocity: [0.0; AXES],
        acceleration: [0.0; AXES],
        position: [0; AXES],
    };

    fn new(setpoint: &Setpoint<f32, AXES>) -> Self {
        Self {
            path: setpoint.path_origin.plus(setpoint.path_offset).raw(),
            speed: setpoint.path_speed,
            idle: setpoint.activity == Activity::Idle,
            velocity: setpoint.velocity,
            acceleration: setpoint.acceleration,
            position: core::array::from_fn(|axis| setpoint.position_nm(axis) as i32),
        }
    }

    /// As it lies in a file: little-endian words in the order of the fields.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let mut out = [0; Self::SIZE];
        out[..8].copy_from_slice(&self.path.to_le_bytes());
        let words = [self.speed.to_bits(), u32::from(self.idle)]
            .into_iter()
            .chain(self.velocity.iter().chain(&self.acceleration).map(|x| x.to_bits()))
            .chain(self.position.iter().map(|x| x.cast_unsigned()));
        for (bytes, word) in out[8..].chunks_exact_mut(4).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        out
    }

    /// From a file.
    pub fn from_bytes(bytes: &[u8; Self::SIZE]) -> Self {
        let word = |k: usize| {
            let at = 8 + 4 * k;
            u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
        };
        let float = |k: usize| f32::from_bits(word(k));
        let mut path = [0; 8];
        path.copy_from_slice(&bytes[..8]);
        Self {
            path: i64::from_le_bytes(path),
            speed: float(0),
            idle: word(1) != 0,
            velocity: core::array::from_fn(|k| float(2 + k)),
            acceleration: core::array::from_fn(|k| float(2 + AXES + k)),
            position: core::array::from_fn(|k| word(2 + 2 * AXES + k).cast_signed()),
        }
    }
}

/// The interrupt side of a run.
pub struct Servo<'a> {
    interpolator: Interpolator<'a, f32, AXES>,
    controls: Controls<'a>,
    events: &'a Events<EVENTS>,
    commands: heapless::Vec<Due, COMMANDS>,
    given: usize,
    linger: u32,
    /// The last setpoint.
    pub setpoint: Setpoint<f32, AXES>,
    /// Servo cycles so far.
    pub cycles: u32,
    /// Servo cycles since the machine moved, and since the last command.
    pub resting: u32,
}

impl<'a> Servo<'a> {
    /// At rest, before the first cycle.
    pub fn new(
        mut interpolator: Interpolator<'a, f32, AXES>,
        controls: Controls<'a>,
        events: &'a Events<EVENTS>,
        setup: &Setup,
    ) -> Self {
        let setpoint = interpolator.tick();
        Self {
            interpolator,
            controls,
            events,
            commands: setup.commands.clone(),
            given: 0,
            linger: setup.linger,
            setpoint,
            cycles: 0,
            resting: 0,
        }
    }

    /// One servo cycle: the setpoint, events, and the commands that are due.
    #[inline]
    pub fn cycle(&mut self) -> Sample {
        self.setpoint = tick(&mut self.interpolator);
        let _ = self.events.take(&self.setpoint);
        self.resting = if self.setpoint.activity == Activity::Idle { self.resting + 1 } else { 0 };
        while let Some(due) = self.commands.get(self.given)
            && due.cycle <= self.cycles
        {
            due.order.give(self.controls);
            self.given += 1;
            self.resting = 0;
        }
        self.cycles += 1;
        Sample::new(&self.setpoint)
    }

    /// Whether there is no more to see: at rest after the last command, if that is the end.
    pub fn is_over(&self) -> bool {
        self.linger > 0 && self.given == self.commands.len() && self.resting > self.linger
    }
}

/// The background of a run: sizes as on a board.
pub type Loop<'a, 'link, const NODES: usize> =
    Background<'a, 'link, f32, AXES, BLOCKS, NODES, QUEUE, EVENTS>;

/// A line on which everything that is to come has come already.
pub struct Line<I> {
    frames: I,
    open: bool,
}

impl<I: Iterator<Item = u8>> Line<I> {
    /// The frames of one session, the opening first.
    pub const fn new(frames: I) -> Self {
        Self { frames, open: false }
    }

    /// Gives the background as much as it takes, or a round of it.
    pub fn feed<const NODES: usize>(&mut self, background: &mut Loop<'_, '_, NODES>) {
        for _ in 0..LINE {
            if background.is_full() {
                return;
            }
            let Some(byte) = self.frames.next() else { return };
            let _ = background.receive(byte);
            // The first frame opens the session, which is answered by the next planning step.
            if byte == 0 && !self.open {
                self.open = true;
                return;
            }
        }
    }
}

/// One round of the background at `now` ms: what has come, a planning step, replies, which nobody reads.
#[inline(never)]
pub fn round<const NODES: usize>(
    background: &mut Loop<'_, '_, NODES>,
    line: &mut Line<impl Iterator<Item = u8>>,
    setpoint: &Setpoint<f32, AXES>,
    now: u32,
) -> Progress {
    line.feed(background);
    let progress = background.plan(now);
    background.reply(setpoint, |_| true);
    progress
}

/// Where its cost is to be measured alone.
#[inline(never)]
fn tick(interpolator: &mut Interpolator<'_, f32, AXES>) -> Setpoint<f32, AXES> {
    interpolator.tick()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_comes_back_from_its_bytes() {
        let sample = Sample {
            path: -123_456_789_012,
            speed: 12.5,
            idle: false,
            velocity: [1.0, -2.0, 3.5],
            acceleration: [-4.0, 5.0, 6.25],
            position: [i32::MIN, 7, i32::MAX],
        };
        assert_eq!(Sample::from_bytes(&sample.to_bytes()), sample);
    }
}
