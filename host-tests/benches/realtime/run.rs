//! One run, in the emulator or here.

use crate::built::{self, Image};
use anyhow::{Context, Result, ensure};
use splineway::wire::{Events, Inlet};
use splineway::{BLOCKS, Coord, Link, NODES, Progress, Reshaping};
use splineway_realtime::{AXES, Line, Loop, RESHAPED_NODES, Sample, Servo, Setup, round};
use std::collections::HashMap;
use std::path::Path;

/// What came of a run.
pub struct Run {
    /// Every servo cycle.
    pub samples: Vec<Sample>,
    /// Whether the end of the program was reached.
    pub complete: bool,
    /// Counts and times that the image tells; times in ns.
    values: HashMap<String, u64>,
}

impl Run {
    /// First and last servo cycle with motion.
    pub fn ends(&self) -> (usize, usize) {
        let moves = |sample: &Sample| !sample.idle;
        let first = self.samples.iter().position(moves).unwrap_or(0);
        (first, self.samples.iter().rposition(moves).unwrap_or(first))
    }

    /// Machining time, servo cycles.
    pub fn cycles(&self) -> usize {
        let (first, last) = self.ends();
        last + 2 - first
    }

    /// A value that the image tells.
    pub fn value(&self, name: &str) -> u64 {
        self.values.get(name).copied().unwrap_or(0)
    }

    /// The longest round of the background, ms.
    pub fn round(&self) -> f64 {
        self.value("worst") as f64 * 1e-6
    }

    /// Arc length at a servo cycle, mm.
    pub fn path(&self, cycle: usize) -> f64 {
        splineway::number::ArcLength::from_raw(self.samples[cycle].path).to_mm()
    }
}

/// In the emulator, where planning takes time.
pub fn real(image: &Image, bytes: &[u8]) -> Result<Run> {
    let folder = tempfile::tempdir()?;
    let (frames, samples) = (folder.path().join("frames"), folder.path().join("samples"));
    std::fs::write(&frames, bytes)?;
    let name = |path: &Path| path.to_str().map(str::to_owned).context("the name of a file");
    let arguments = [name(&frames)?, name(&samples)?];
    let text = image.emulate(&arguments)?;
    let values = built::values(&text);
    ensure!(values.contains_key("missed"), "the image says: {text}");
    let bytes = std::fs::read(&samples)?;
    let (chunks, _) = bytes.as_chunks::<{ Sample::SIZE }>();
    let samples = chunks.iter().map(Sample::from_bytes).collect();
    Ok(Run { samples, complete: values.get("complete") == Some(&1), values })
}

/// Here, where planning takes no time: in a servo cycle as many rounds as do something.
pub fn zero(setup: &Setup, bytes: &[u8], reshape: bool) -> Result<Run> {
    if reshape {
        let memory = &mut Box::new(Reshaping::new());
        zero_with::<RESHAPED_NODES>(setup, bytes, Some(memory))
    } else {
        zero_with::<NODES>(setup, bytes, None)
    }
}

fn zero_with<const NODES: usize>(
    setup: &Setup,
    bytes: &[u8],
    reshaping: Option<&mut Reshaping<f32, AXES>>,
) -> Result<Run> {
    let mut bytes = bytes.iter().copied();
    let mut inlet = Inlet::new();
    let _: Setup = bytes.find_map(|byte| inlet.push(byte)).context("no setup")?;
    let mut link = Box::new(Link::<f32, AXES, BLOCKS, NODES>::new());
    let (mut planner, interpolator) = link.split(setup.config()?, [Coord::ZERO; AXES])?;
    if let Some(memory) = reshaping {
        planner.reshape(memory);
    }
    let events = Events::new();
    let mut servo = Servo::new(interpolator, planner.controls(), &events, setup);
    let mut background = Loop::new(&mut planner, &events);
    let mut line = Line::new(bytes);
    let mut samples = Vec::new();
    let mut complete = false;
    while !complete && !servo.is_over() && servo.cycles < setup.most_cycles {
        while round(&mut background, &mut line, &servo.setpoint, servo.cycles) == Progress::Planning
        {
        }
        samples.push(servo.cycle());
        complete = background.is_done(&servo.setpoint) && servo.resting > 2 && setup.linger == 0;
    }
    Ok(Run { samples, complete, values: HashMap::new() })
}
