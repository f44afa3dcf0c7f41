//! A controller without a machine that speaks the protocol of grbl: the background of the firmware
//! ([`splineway_controller::grbl`]), on a line.

use super::line::Line;
use super::pace::Pace;
use anyhow::{Context, Result, bail};
use splineway::grbl::{Accessories, Event, Events, Settings, State, Store, words};
use splineway::{BLOCKS, Coord, Link, NODES, Progress, Setpoint};
use splineway_controller::grbl::{Background, Port};
use splineway_simulator::machine::Machine;
use std::collections::VecDeque;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// Events that may be on their way.
const EVENTS: usize = 8;
/// Steps per mm that a machine without motors says it has, and its travel where it has none, mm.
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
    /// The file cannot be opened.
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
        Ok(Self { file, words: words(axes), memory: [Vec::new(), Vec::new()] })
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
}

/// What the background sees.
struct Outside<const N: usize> {
    incoming: VecDeque<u8>,
    outgoing: Vec<u8>,
    /// Whether the line takes nothing now.
    full: bool,
    setpoint: Setpoint<f32, N>,
    kept: Kept,
    told: Vec<Doing>,
}

impl<const N: usize> Port<f32, N> for Outside<N> {
    type Store = Kept;

    fn read(&mut self) -> Option<u8> {
        self.incoming.pop_front()
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

    fn switch(&mut self, accessories: &Accessories) {
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
        let settings = Settings::new(&config, [STEPS; N], [TRAVEL; N]);
        let mut background =
            Background::<_, N, BLOCKS, NODES, EVENTS>::new(&mut planner, &events, settings);
        let mut outside = Outside {
            incoming: VecDeque::new(),
            outgoing: Vec::new(),
            full: false,
            setpoint: interpolator.tick(),
            kept: self.kept,
            told: Vec::new(),
        };
        let (mut pace, mut state) = (Pace::new(speed, machine.cycle), State::Idle);
        loop {
            pace.hear(&self.line, state == State::Idle, |chunk| outside.incoming.extend(chunk));
            outside.full = self.line.is_full();
            // The line is served whether a servo cycle is due or not.
            while background.round(&mut outside) == Progress::Planning {}
            pace.run(|| {
                outside.setpoint = interpolator.tick();
                events.take(&outside.setpoint);
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
