//! A controller without a machine: the background of the firmware ([`splineway_controller`]), on a line.

use super::line::{Heard, Line};
use super::pace::Pace;
use anyhow::{Result, bail};
use splineway::wire::{Event, Events, IN_TIME, State};
use splineway::{
    Activity, BLOCKS, Coord, Link, NODES, Output, Planner, Progress, Setpoint, Switched,
};
use splineway_controller::{Background, Port};
use splineway_simulator::machine::Machine;
use std::collections::VecDeque;
use std::time::Duration;

/// Items that wait for the planner.
const QUEUE: usize = 16;
/// Events that may be on their way to the firmware.
const EVENTS: usize = 8;
/// What a bad line does, for trials.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    /// Share of the bytes that are lost, garbled or doubled, in either direction.
    pub share: f64,
}

impl Faults {
    fn pass(self, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::with_capacity(bytes.len());
        for &byte in bytes {
            if self.share <= 0.0 || fastrand::f64() >= self.share {
                out.push(byte);
                continue;
            }
            match fastrand::u8(..3) {
                0 => {}
                1 => out.push(byte ^ fastrand::u8(1..)),
                _ => out.extend([byte, byte]),
            }
        }
        out
    }
}

/// What the background sees: bytes that have come and that go out, the time, the last setpoint.
struct Outside<const N: usize> {
    faults: Faults,
    incoming: VecDeque<u8>,
    outgoing: Vec<u8>,
    now: Duration,
    setpoint: Setpoint<f32, N>,
}

impl<const N: usize> Outside<N> {
    fn position(&self) -> Vec<i64> {
        (0..N).map(|axis| self.setpoint.position_nm(axis)).collect()
    }
}

impl<const N: usize> Port<f32, N> for Outside<N> {
    fn read(&mut self) -> Option<u8> {
        self.incoming.pop_front()
    }

    fn write(&mut self, byte: u8) -> bool {
        self.outgoing.extend(self.faults.pass(&[byte]));
        true
    }

    fn now_ms(&mut self) -> u32 {
        self.now.as_millis() as u32
    }

    fn setpoint(&mut self) -> Setpoint<f32, N> {
        self.setpoint
    }
}

/// What a controller without a machine has to tell.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// The machine does something else than before.
    State {
        /// What.
        state: State,
        /// Where it is, nm.
        position: Vec<i64>,
    },
    /// Something that is not motion is to be done.
    Event(Event),
    /// An output has switched, to 0 or 1 if it is a digital one. The power is told by [`Happening::Laser`].
    Output {
        /// Which.
        output: Output,
        /// To what.
        value: f32,
    },
    /// The power of a tool has become more than 0, or 0.
    Laser(f32),
    /// A program has been run to its end, with the axes here, nm.
    Run(Vec<i64>),
}

/// A controller without a machine, at its end of a line.
#[derive(Debug)]
pub struct Controller {
    line: Line,
}

impl Controller {
    /// At the end of a line.
    pub const fn new(line: Line) -> Self {
        Self { line }
    }

    /// On a pseudo-terminal.
    ///
    /// # Errors
    /// The system has none left.
    pub fn open() -> Result<Self> {
        Line::terminal().map(Self::new)
    }

    /// Name of the port that a host opens.
    pub fn name(&self) -> &str {
        self.line.name()
    }

    /// Runs what comes, `speed` times as fast as the clock, and tells what happens, until `tell` says that
    /// this is enough.
    ///
    /// # Errors
    /// The machine cannot be used.
    pub fn run(
        self,
        machine: &Machine,
        axes: usize,
        speed: f64,
        faults: Faults,
        tell: impl FnMut(&Happening) -> bool,
    ) -> Result<()> {
        match axes {
            3 => self.run_axes::<3>(machine, speed, faults, tell),
            6 => self.run_axes::<6>(machine, speed, faults, tell),
            9 => self.run_axes::<9>(machine, speed, faults, tell),
            _ => bail!("axes is {axes}; this controller has 3, 6 or 9"),
        }
    }

    fn run_axes<const N: usize>(
        self,
        machine: &Machine,
        speed: f64,
        faults: Faults,
        mut tell: impl FnMut(&Happening) -> bool,
    ) -> Result<()> {
        let all: Vec<usize> = (0..N).collect();
        let config = machine.config::<f32, N>(&all)?;
        let mut link = Box::new(Link::<f32, N, BLOCKS, NODES>::new());
        let (mut planner, mut interpolator): (Planner<'_, f32, N, BLOCKS, NODES>, _) =
            link.split(config, [Coord::ZERO; N])?;
        let mut shaper = machine.shaper(&all, &config)?;
        let events = Events::<EVENTS>::new();
        let (inputs, mut seeker) = (planner.inputs(), machine.seeker());
        let mut background =
            Background::<_, N, BLOCKS, NODES, QUEUE, EVENTS>::new(&mut planner, &events);
        let mut pace = Pace::new(speed, machine.cycle);
        let mut outside = Outside {
            faults,
            incoming: VecDeque::new(),
            outgoing: Vec::new(),
            now: Duration::ZERO,
            setpoint: interpolator.tick(),
        };
        // Switches that are closed at the beginning.
        let start = outside.setpoint;
        seeker.sense(inputs, &all, (&start, &start), machine.cycle);
        let (mut ran, mut leaves, mut burns) = (false, false, false);
        let mut state = State::Idle;
        loop {
            pace.hear(&self.line, state == State::Idle, |heard| {
                // Half a frame is none, and its session outlasts a line.
                if let Heard::Bytes(bytes) = heard {
                    outside.incoming.extend(faults.pass(&bytes));
                }
            });
            outside.now = pace.now();
            // The line is served whether a servo cycle is due or not.
            while background.round(&mut outside) == Progress::Planning {}
            pace.run(|| {
                let now = interpolator.tick();
                let now = shaper.as_mut().map_or(now, |shaper| shaper.shape(&now));
                let before = std::mem::replace(&mut outside.setpoint, now);
                // Of a controller that is behind, a short program may be run in one go.
                ran |= now.activity != Activity::Idle;
                let power = interpolator.switch(&now, |Switched { output, value, .. }| {
                    if output != Output::Power {
                        leaves |= tell(&Happening::Output { output, value });
                    }
                });
                if std::mem::replace(&mut burns, power > 0.0) != burns {
                    leaves |= tell(&Happening::Laser(power));
                }
                // What switches at rest has been told.
                if let Some(event) = events.take(&now).filter(|event| event.letter != IN_TIME) {
                    leaves |= tell(&Happening::Event(event));
                }
                seeker.sense(inputs, &all, (&before, &now), machine.cycle);
                while background.round(&mut outside) == Progress::Planning {}
            });
            self.line.write(&outside.outgoing);
            outside.outgoing.clear();
            let setpoint = outside.setpoint;
            let before = std::mem::replace(&mut state, background.state(&setpoint));
            if state != before {
                leaves |= tell(&Happening::State { state, position: outside.position() });
            }
            if ran && state == State::Idle && background.is_done(&setpoint) {
                ran = false;
                leaves |= tell(&Happening::Run(outside.position()));
            }
            // Only when the host has nothing more to ask.
            if leaves && pace.is_silent() {
                return Ok(());
            }
        }
    }
}
