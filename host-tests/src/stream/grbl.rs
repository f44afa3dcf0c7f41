//! A controller without a machine that speaks the protocol of grbl: the background of the firmware
//! ([`splineway_controller::grbl`]), on a line.

use super::line::{Heard, Line};
use super::pace::Pace;
use anyhow::{Context, Result, bail, ensure};
use splineway::grbl::{Accessories, Event, Events, Inputs, Settings, State, Store, words};
use splineway::{BLOCKS, Coord, Input, Link, NODES, Output, Progress, Setpoint, Switched, Travel};
use splineway_controller::grbl::{Background, Port};
use splineway_simulator::machine::Machine;
use std::collections::VecDeque;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// Events that may be on their way.
const EVENTS: usize = 8;
/// Steps per mm that a machine without motors says it has, and its travel where that is open, mm.
const STEPS: f32 = 250.0;
const TRAVEL: f32 = 500.0;

/// Settings in a file, or in none.
#[derive(Debug)]
pub struct Kept {
    file: Option<File>,
    /// Words of a copy.
    words: usize,
    /// Without a file.
    memory: [Vec<u32>; 2],
}

impl Kept {
    /// For a machine of so many axes, in a file, which is made if it is not there.
    ///
    /// # Errors
    /// The file cannot be opened, or is one of something else, which would be lost.
    pub fn new(axes: usize, path: Option<&Path>) -> Result<Self> {
        let open = |path: &Path| {
            File::options()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(path)
                .with_context(|| format!("cannot open {}", path.display()))
        };
        let file = path.map(open).transpose()?;
        let kept = Self { file, words: words(axes), memory: [Vec::new(), Vec::new()] };
        if let (Some(path), Some(file)) = (path, &kept.file) {
            ensure!(
                kept.are_settings(file),
                "--settings {}: not the settings of grbl for {axes} axes",
                path.display()
            );
        }
        Ok(kept)
    }

    /// Whether either copy is one, of whatever layout, has been erased, or has never been written.
    fn are_settings(&self, file: &File) -> bool {
        [0, 1].into_iter().all(|copy| {
            let mut mark = [0xFF; 4];
            let read = file.read_at(&mut mark, self.place(copy, 0));
            read.is_ok()
                && matches!(mark, [0, 0, 0, 0] | [0xFF, 0xFF, 0xFF, 0xFF] | [b'S', b'W', b'G', _])
        })
    }

    fn place(&self, copy: usize, at: usize) -> u64 {
        4 * (copy * self.words + at) as u64
    }
}

impl Store for Kept {
    fn read(&mut self, copy: usize, at: usize) -> Option<u32> {
        let Some(file) = &self.file else { return self.memory.get(copy)?.get(at).copied() };
        let mut word = [0; 4];
        file.read_exact_at(&mut word, self.place(copy, at)).ok()?;
        Some(u32::from_le_bytes(word))
    }

    fn erase(&mut self, copy: usize) -> bool {
        let Some(file) = &self.file else {
            if let Some(copy) = self.memory.get_mut(copy) {
                copy.clear();
            }
            return true;
        };
        let blank = vec![0xFF; 4 * self.words];
        file.write_all_at(&blank, self.place(copy, 0)).is_ok()
    }

    fn write(&mut self, copy: usize, at: usize, word: u32) -> bool {
        let Some(file) = &self.file else {
            if let Some(copy) = self.memory.get_mut(copy) {
                copy.push(word);
            }
            return true;
        };
        file.write_all_at(&word.to_le_bytes(), self.place(copy, at)).is_ok()
    }
}

/// What a controller without a machine has to tell.
#[derive(Clone, Debug, PartialEq)]
pub enum Doing {
    /// The machine does something else than before.
    State {
        /// What.
        state: State,
        /// Where it is, nm.
        position: Vec<i64>,
    },
    /// Spindle or coolant is switched.
    Switch(Accessories),
    /// Something else that is not motion is to be done.
    Event(Event),
    /// An output has switched, to 0 or 1 if it is a digital one.
    Output {
        /// Which. The power is told by [`Doing::Laser`].
        output: Output,
        /// To what.
        value: f32,
    },
    /// The laser has begun to burn, with this power, or has stopped (0).
    Laser(f32),
}

/// What the background sees.
struct Outside<const N: usize> {
    /// `None`: whoever sent has gone.
    incoming: VecDeque<Option<u8>>,
    outgoing: Vec<u8>,
    /// Whether the line takes nothing now.
    full: bool,
    setpoint: Setpoint<f32, N>,
    kept: Kept,
    told: Vec<Doing>,
    inputs: Inputs,
    /// Per cent of its power that the laser gets, and its power.
    percent: u16,
    power: f32,
}

impl<const N: usize> Outside<N> {
    /// A servo cycle's switches, and the power at its end.
    fn show(&mut self, power: f32, switched: &[Switched<f32>]) {
        for Switched { output, value, .. } in switched {
            if *output != Output::Power {
                self.told.push(Doing::Output { output: *output, value: *value });
            }
        }
        let power = power * f32::from(self.percent) * 0.01;
        if (power > 0.0) != (self.power > 0.0) {
            self.told.push(Doing::Laser(power));
        }
        self.power = power;
    }

    /// Switches and the probe as they are now.
    fn look(&mut self, inputs: splineway::Inputs<'_>) {
        self.inputs.probe = inputs.is_closed(Input::Probe);
        let bit = |axis: usize| u16::from(inputs.is_closed(Input::Home(axis))) << axis;
        self.inputs.limits = (0..N).map(bit).sum();
    }
}

/// How far axes may go, mm.
fn travel<const N: usize>(travel: &Travel<N>) -> [f32; N] {
    travel.axes().map(|axis| match (axis.least, axis.greatest) {
        (Some(least), Some(greatest)) => (greatest.to_mm() - least.to_mm()) as f32,
        _ => TRAVEL,
    })
}

impl<const N: usize> Port<f32, N> for Outside<N> {
    type Store = Kept;

    fn read(&mut self) -> Option<u8> {
        self.incoming.front().copied().flatten()?;
        self.incoming.pop_front().flatten()
    }

    fn hung_up(&mut self) -> bool {
        let gone = self.incoming.front() == Some(&None);
        gone && self.incoming.pop_front().is_some()
    }

    fn write(&mut self, byte: u8) -> bool {
        if !self.full {
            self.outgoing.push(byte);
        }
        !self.full
    }

    fn setpoint(&mut self) -> Setpoint<f32, N> {
        self.setpoint
    }

    fn store(&mut self) -> &mut Kept {
        &mut self.kept
    }

    fn inputs(&mut self) -> Inputs {
        self.inputs
    }

    fn power(&mut self) -> f32 {
        self.power
    }

    fn switch(&mut self, accessories: &Accessories) {
        self.percent = accessories.laser;
        self.told.push(Doing::Switch(*accessories));
    }

    fn happen(&mut self, event: &Event) {
        self.told.push(Doing::Event(*event));
    }
}

/// A controller without a machine, at its end of a line.
#[derive(Debug)]
pub struct Grbl {
    line: Line,
    kept: Kept,
}

impl Grbl {
    /// At the end of a line, with what keeps its settings.
    pub const fn new(line: Line, kept: Kept) -> Self {
        Self { line, kept }
    }

    /// Runs what comes, `speed` times as fast as the clock, and tells what happens, until `tell` says that this is enough.
    ///
    /// # Errors
    /// The machine cannot be used.
    pub fn run(
        self,
        machine: &Machine,
        axes: usize,
        speed: f64,
        tell: impl FnMut(&Doing) -> bool,
    ) -> Result<()> {
        match axes {
            3 => self.run_axes::<3>(machine, speed, tell),
            6 => self.run_axes::<6>(machine, speed, tell),
            9 => self.run_axes::<9>(machine, speed, tell),
            _ => bail!("axes is {axes}; this controller has 3, 6 or 9"),
        }
    }

    fn run_axes<const N: usize>(
        self,
        machine: &Machine,
        speed: f64,
        mut tell: impl FnMut(&Doing) -> bool,
    ) -> Result<()> {
        let all: Vec<usize> = (0..N).collect();
        let config = machine.config::<f32, N>(&all)?;
        let mut link = Box::new(Link::<f32, N, BLOCKS, NODES>::new());
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; N])?;
        let events = Events::<EVENTS>::new();
        let (inputs, mut seeker) = (planner.inputs(), machine.seeker());
        let settings = Settings::new(&config, [STEPS; N], travel(&config.travel));
        let mut background =
            Background::<_, N, BLOCKS, NODES, EVENTS>::new(&mut planner, &events, settings);
        let mut outside = Outside {
            incoming: VecDeque::new(),
            outgoing: Vec::new(),
            full: false,
            setpoint: interpolator.tick(),
            kept: self.kept,
            told: Vec::new(),
            inputs: Inputs::default(),
            percent: 0,
            power: 0.0,
        };
        // Switches that are closed at the beginning.
        let start = outside.setpoint;
        seeker.sense(inputs, &all, (&start, &start), machine.cycle);
        let mut switched = Vec::new();
        let (mut pace, mut state) = (Pace::new(speed, machine.cycle), State::Idle);
        loop {
            pace.hear(&self.line, state == State::Idle, |heard| match heard {
                Heard::Bytes(bytes) => outside.incoming.extend(bytes.into_iter().map(Some)),
                Heard::HangUp => outside.incoming.push_back(None),
            });
            outside.full = self.line.is_full();
            outside.look(inputs);
            // The line is served whether a servo cycle is due or not.
            while background.round(&mut outside) == Progress::Planning {}
            pace.run(|| {
                let before = std::mem::replace(&mut outside.setpoint, interpolator.tick());
                events.take(&outside.setpoint);
                let power = interpolator.switch(&outside.setpoint, |now| switched.push(now));
                outside.show(power, &switched);
                switched.clear();
                let between = (&before, &outside.setpoint);
                seeker.sense(inputs, &all, between, machine.cycle);
                outside.look(inputs);
                while background.round(&mut outside) == Progress::Planning {}
            });
            self.line.write(&std::mem::take(&mut outside.outgoing));
            let before = std::mem::replace(&mut state, background.state());
            if state != before {
                let position = (0..N).map(|axis| outside.setpoint.position_nm(axis)).collect();
                outside.told.push(Doing::State { state, position });
            }
            let mut leaves = false;
            for doing in outside.told.drain(..) {
                leaves |= tell(&doing);
            }
            if leaves {
                return Ok(());
            }
        }
    }
}
