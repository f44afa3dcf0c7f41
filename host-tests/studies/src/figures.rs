//! The figures of `docs/figures.md`: machining times beside other speed laws, judged, and what they cost.

use crate::baseline::{self, Law};
use crate::paths::Made;
use anyhow::{Context, Result};
use serde::Serialize;
use splineway::{Link, Planner, Scalar};
use splineway_simulator::judge::{Verdict, judged, violations};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, Program, ReadOptions, poly};
use splineway_simulator::run::{Events, Precision};
use std::path::Path;

/// The computer on which costs were measured.
#[derive(Clone, Debug, Serialize)]
pub struct Host {
    /// Name of the processor.
    pub processor: String,
    /// Cores.
    pub cores: usize,
    /// Operating system and kind of processor.
    pub system: String,
    /// Version of this program.
    pub version: String,
}

impl Host {
    /// This one.
    pub fn this() -> Self {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = info.lines().find_map(|line| line.strip_prefix("model name"));
        let name = name.and_then(|rest| rest.split(':').nth(1)).unwrap_or("unknown");
        Self {
            processor: name.trim().to_owned(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

/// Memory of a core, bytes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Memory {
    /// Scalar.
    pub scalar: &'static str,
    /// Axes.
    pub axes: usize,
    /// Blocks of the look-ahead.
    pub blocks: usize,
    /// Nodes of the window.
    pub nodes: usize,
    /// What both contexts share.
    #[serde(rename = "link_bytes")]
    pub link: usize,
    /// The background's.
    #[serde(rename = "planner_bytes")]
    pub planner: usize,
}

impl Memory {
    fn of<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>() -> Self {
        Self {
            scalar: S::NAME,
            axes: N,
            blocks: BLOCKS,
            nodes: NODES,
            link: size_of::<Link<S, N, BLOCKS, NODES>>(),
            planner: size_of::<Planner<'static, S, N, BLOCKS, NODES>>(),
        }
    }

    /// Of cores of some sizes.
    pub fn table() -> Vec<Self> {
        vec![
            Self::of::<f32, 3, 8, 56>(),
            Self::of::<f32, 3, 16, 64>(),
            Self::of::<f32, 3, 128, 96>(),
            Self::of::<f32, 6, 8, 56>(),
            Self::of::<f32, 6, 16, 64>(),
            Self::of::<f64, 3, 64, 192>(),
        ]
    }
}

/// A path through the core.
#[derive(Clone, Debug, Serialize)]
pub struct PathFigures {
    /// Its name.
    pub name: String,
    /// Blocks.
    pub blocks: u64,
    /// mm.
    #[serde(rename = "tolerance_mm")]
    pub tolerance: f64,
    /// Machining time in `f64`, s.
    #[serde(rename = "time_f64_s")]
    pub seconds_f64: f64,
    /// In `f32`.
    #[serde(rename = "time_f32_s")]
    pub seconds_f32: f64,
    /// With an exact stop after every block, run by this core.
    #[serde(rename = "time_stops_s")]
    pub seconds_stops: f64,
    /// With trapezoids and junction deviation, which knows no jerk.
    #[serde(rename = "time_trapezoid_s")]
    pub seconds_trapezoid: f64,
    /// With S-curves and junction deviation.
    #[serde(rename = "time_s_curve_s")]
    pub seconds_s_curve: f64,
    /// Greatest deviation over the tolerance.
    #[serde(rename = "deviation_share")]
    pub deviation: f64,
    /// Greatest velocity, acceleration and jerk of any axis over its limit.
    #[serde(rename = "velocity_acceleration_jerk_share")]
    pub peaks: [f64; 3],
    /// Planning, ns per block.
    pub ns_per_block: f64,
    /// Interpolating, ns per tick.
    pub ns_per_tick: f64,
    /// Limits that were broken.
    pub broken: Vec<String>,
}

fn run(
    program: &Program,
    machine: &Machine,
    precision: Precision,
) -> Result<(Verdict, f64, f64, u64)> {
    let (verdict, stats) = judged(program, machine, precision, &Events::default())?;
    let per_block = stats.planning.total() / stats.blocks.max(1) as f64;
    Ok((verdict, per_block, stats.ticks.summary().0, stats.blocks))
}

impl PathFigures {
    /// Of a file, on the machine it names, or on the built-in one.
    ///
    /// # Errors
    /// It cannot be read or run.
    pub fn of(path: &Path) -> Result<Self> {
        let program = program::read(path, ReadOptions { feed: 200.0, ..ReadOptions::DEFAULT })?;
        let mut machine = Machine::default();
        if let Some(header) = &program.header {
            machine.apply(header);
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Self::new(name, &program, &machine).with_context(|| path.display().to_string())
    }

    /// Of one of our own making.
    ///
    /// # Errors
    /// It cannot be run.
    pub fn of_made(made: &Made) -> Result<Self> {
        let program = poly::parse(&made.text())?;
        let mut machine = Machine::default();
        if let Some(header) = &program.header {
            machine.apply(header);
        }
        let name = format!("{}_{}", made.name, made.tolerance);
        Self::new(name.clone(), &program, &machine).context(name)
    }

    fn new(name: String, program: &Program, machine: &Machine) -> Result<Self> {
        let (wide, ns_per_block, ns_per_tick, blocks) = run(program, machine, Precision::F64)?;
        let (narrow, ..) = run(program, machine, Precision::F32)?;
        let mut stops = program.clone();
        for step in &mut stops.moves {
            step.exact_stop = true;
        }
        let (stopping, ..) = run(&stops, machine, Precision::F64)?;
        let limits = machine.axes_of(program)?;
        let law = |law| baseline::run(program, &limits, machine.tolerance, law).time;
        let worst = wide.worst();
        Ok(Self {
            name,
            blocks,
            tolerance: machine.tolerance,
            seconds_f64: wide.time,
            seconds_f32: narrow.time,
            seconds_stops: stopping.time,
            seconds_trapezoid: law(Law::Trapezoid),
            seconds_s_curve: law(Law::SCurve),
            deviation: wide.deviation / machine.tolerance,
            peaks: [worst.velocity, worst.acceleration, worst.jerk],
            ns_per_block,
            ns_per_tick,
            broken: [violations(&wide), violations(&narrow)].concat(),
        })
    }
}

/// All of them.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// Where they were measured.
    pub host: Host,
    /// Memory.
    pub memory: Vec<Memory>,
    /// Paths.
    pub paths: Vec<PathFigures>,
}

impl Figures {
    /// Of some files; `each` sees every path as it is done.
    ///
    /// # Errors
    /// A file cannot be read or run.
    pub fn of(files: &[impl AsRef<Path>], each: impl FnMut(&PathFigures)) -> Result<Self> {
        Self::of_all(files.iter().map(|file| PathFigures::of(file.as_ref())), each)
    }

    /// Of paths of our own making.
    ///
    /// # Errors
    /// One cannot be run.
    pub fn of_made(made: &[Made], each: impl FnMut(&PathFigures)) -> Result<Self> {
        Self::of_all(made.iter().map(PathFigures::of_made), each)
    }

    fn of_all(
        all: impl Iterator<Item = Result<PathFigures>>,
        mut each: impl FnMut(&PathFigures),
    ) -> Result<Self> {
        let look = |figures: Result<PathFigures>| figures.inspect(&mut each);
        let paths = all.map(look).collect::<Result<_>>()?;
        Ok(Self { host: Host::this(), memory: Memory::table(), paths })
    }
}
