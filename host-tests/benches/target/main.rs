//! What holds on the target, measured on the target's own code (thumbv7em-none-eabihf).
//!
//! `cargo bench -p splineway-host --bench target [-- FOLDER]` builds two images, and
//! - links one whose panic handler cannot be linked: so no panic can be reached, and nothing allocates;
//! - links the example in C with the library for C;
//! - measures the size of the code, and computes from it the stack and the instructions of a tick that are needed at most;
//! - runs the paths of `host-tests/data` and those in FOLDER through the other in QEMU and here, compares the
//!   digests of all setpoints, and prints instructions per tick and per block;
//! - runs the butterfly of Guo, Yan, Wang 2023 in both modes of corners, and prints instructions per corner;
//! - prints what outputs, input shaping and motors add to a tick;
//! - smooths the cases of Naseath 2007 there and here, compares the control points, and prints instructions.
//!
//! Without a toolchain for the target, GNU binutils and a C compiler for it, or QEMU it says so and ends; with
//! `SPLINEWAY_REQUIRE_TARGET` set it fails.

// Some of it is for other benches.
#[allow(dead_code)]
#[path = "../common/image.rs"]
mod built;
#[path = "../common/mod.rs"]
mod common;
mod extras;
mod image;
mod listing;
mod longest;
#[path = "../common/session.rs"]
mod session;
mod smoothing;
mod stack;

use anyhow::{Context, Result, ensure};
use built::Image;
use listing::Listing;
use longest::{Rule, longest};
use session::Machine;
use splineway::Link;
use splineway::wire::Inlet;
use splineway_emulator::{Meter, Outcome, Part, Setup};
use splineway_simulator::program::{Course, Point, Program};
use splineway_studies::paper::{cases, measure};
use std::path::{Path, PathBuf};

/// Goals, as the README states them.
const TICK: [(u8, u64); 2] = [(3, 600), (6, 1100)];
/// Stack at most, bytes, of what the name of an entry contains; of every other the last.
const STACKS: [(&str, u32); 10] = [
    // The library for C has jogs, probes and homing in it, whose plans are made in one poll.
    ("splineway_poll", 8 * 1024 + 256),
    ("splineway_settle", 8 * 1024 + 256),
    ("home", 1024 + 128),
    ("tick", 1024),
    ("split", 1024),
    ("init", 2048),
    ("poll", 4 * 1024),
    ("settle", 4 * 1024),
    ("push", 4 * 1024),
    ("", 1024),
];
/// RAM of a core in three axes at most, bytes.
const RAM: u64 = 45 * 1024 + 256;

/// Code and constants of splineway in the image `proof` at most, three axes, bytes.
const CODE: u64 = 190 * 1024;

/// Loops of a tick: attempts at a compare-and-swap, of which the first fails only if another context comes in; one may. All
/// others are unrolled.
const LOOPS: [Rule; 1] = [Rule { function: "", contains: "strex", times: 2 }];

struct Free;

impl Meter for Free {
    fn begin(&mut self) {}
    fn end(&mut self, _: Part) {}
}

/// The same path in twice as many axes: the second three do as the first.
fn doubled(program: &Program) -> Program {
    let twice = |point: &Point| {
        let mut point = *point;
        point.copy_within(0..3, 3);
        point
    };
    let mut out = program.clone();
    out.start = twice(&out.start);
    out.uses = std::array::from_fn(|axis| axis < 6);
    for step in &mut out.moves {
        match &mut step.path {
            Course::Line { to } | Course::Arc { to, .. } => *to = twice(to),
            Course::Cubic { controls: [first, second], to } => {
                (*first, *second, *to) = (twice(first), twice(second), twice(to));
            }
            Course::Dwell { .. } | Course::Event { .. } => {}
        }
    }
    out
}

fn on_host<const N: usize, const BLOCKS: usize, const NODES: usize>(
    bytes: &[u8],
) -> Result<Outcome> {
    let mut bytes = bytes.iter().copied();
    let mut inlet = Inlet::new();
    let setup: Setup = bytes.find_map(|byte| inlet.push(byte)).context("no setup")?;
    let mut link = Box::new(Link::<f32, N, BLOCKS, NODES>::new());
    Ok(splineway_emulator::run::<f32, N, BLOCKS, NODES>(
        &mut link,
        &setup,
        &mut || bytes.next(),
        &mut Free,
    )?)
}

/// What a path takes on the target.
struct Taken {
    /// Instructions of all planning.
    planning: u64,
    /// A goal that was missed.
    missed: Option<String>,
}

/// Runs a program on host and target, and prints its line.
fn compare(emulator: &Image, label: &str, program: &Program, setup: &Setup) -> Result<Taken> {
    let bytes = session::frames(program, setup, setup.axes.into())?;
    let host =
        if setup.axes == 6 { on_host::<6, 8, 56>(&bytes) } else { on_host::<3, 16, 64>(&bytes) }?;
    let file = std::env::temp_dir().join(format!("splineway-{}.frames", std::process::id()));
    std::fs::write(&file, &bytes)?;
    let answer = emulator.run(&file);
    std::fs::remove_file(&file)?;
    let target = answer?;
    let blocks = target.outcome.blocks.max(1);
    let cycles = target.outcome.cycles.max(1);
    println!(
        "{label:<24} {:>7} {:>8} {:>9.0} {:>6} {:>9.0} {:>9}  {:08x} {}",
        blocks,
        cycles,
        target.tick as f64 / f64::from(cycles),
        target.tick_worst,
        target.planning as f64 / f64::from(blocks),
        target.planning_worst,
        target.outcome.digest,
        if target.outcome == host { "= host" } else { "NOT the host's" },
    );
    ensure!(host.complete, "{label}: the host did not reach the end");
    ensure!(target.outcome == host, "{label}: host {host:?}, target {:?}", target.outcome);
    let too_long =
        TICK.iter().find(|(axes, most)| *axes == setup.axes && target.tick_worst > *most);
    let missed = too_long.map(|(_, most)| {
        format!("{label}: a tick took {} instructions; {most} is the goal", target.tick_worst)
    });
    Ok(Taken { planning: target.planning, missed })
}

/// Runs a path as the machine of its header does; gives a goal that was missed.
fn run_path(emulator: &Image, path: &Path, six: bool) -> Result<Option<String>> {
    let program = session::read(path)?;
    let program = if six { doubled(&program) } else { program };
    let axes = if six { 6 } else { 3 };
    ensure!(program.axes().len() == axes, "{}: it has more than 3 axes", path.display());
    let Machine { limits, tolerance, cycle } = Machine::of(&program);
    let setup = Setup { axes: axes as u8, limits, tolerance, cycle, lambda: None };
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(compare(emulator, &format!("{name}, {axes} axes"), &program, &setup)?.missed)
}

/// The butterfly of Guo, Yan, Wang 2023 in 80 lines, in the paper's mode and the core's own: what a corner costs. Gives goals
/// that were missed.
fn corners(emulator: &Image) -> Result<Vec<String>> {
    let case = cases::case("butterfly80").context("the vectors have no butterfly")?;
    let program = measure::program(&case);
    let tolerance = case.delta as f32;
    let mut missed = Vec::new();
    let mut costs = Vec::new();
    for (mode, lambda) in [("paper", Some(case.lambda as f32)), ("own", None)] {
        let limits = [200.0, 2000.0, 50_000.0];
        let setup = Setup { axes: 3, limits, tolerance, cycle: 0.001, lambda };
        let taken = compare(emulator, &format!("80 lines, {mode} mode"), &program, &setup)?;
        let per = |count: usize| taken.planning as f64 / count.max(1) as f64;
        let (corners, lines) = (case.vectors.len(), program.moves.len());
        costs.push(format!("{mode} mode {:.0} and {:.0}", per(corners), per(lines)));
        missed.extend(taken.missed);
    }
    println!(
        "the paper's butterfly in 80 lines, {tolerance} mm, instructions per corner and per line: {}",
        costs.join(", ")
    );
    Ok(missed)
}

fn examples() -> Vec<PathBuf> {
    ["butterfly.json", "noisy.txt"]
        .map(|name| Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name))
        .to_vec()
}

/// Prints the stack of entries; gives those that need more than they may.
fn stacks(code: &Listing, entries: impl Iterator<Item = String>) -> Result<Vec<String>> {
    let mut missed = Vec::new();
    for entry in entries {
        let bytes = stack::worst(code, &entry)?;
        println!("stack of {entry}, bytes at most: {bytes}");
        let most =
            STACKS.iter().find(|(name, _)| entry.contains(name)).map_or(0, |(_, most)| *most);
        // Six axes take up to twice as much.
        let most = if entry.ends_with("_6") { 2 * most } else { most };
        if bytes > most {
            missed.push(format!("{entry} needs {bytes} bytes of stack; {most} is the goal"));
        }
    }
    Ok(missed)
}

fn report() -> Result<()> {
    let emulator = Image::build("emulator")?;
    println!(
        "{:<24} {:>7} {:>8} {:>16} {:>19}  digest",
        "path", "blocks", "cycles", "tick: mean worst", "block: mean, poll worst"
    );
    let mut paths = examples();
    paths.extend(common::paths());
    let mut missed = Vec::new();
    for path in &paths {
        missed.extend(run_path(&emulator, path, false)?);
    }
    for path in examples() {
        missed.extend(run_path(&emulator, &path, true)?);
    }

    missed.extend(corners(&emulator)?);

    smoothing::report()?;
    missed.extend(extras::report()?);

    let proof = Image::build("proof")?;
    println!("no panic can be reached: the image links without one");
    proof.check_symbols()?;
    let size = proof.size()?;
    println!(
        "code and constants, bytes (f32, 3 axes, 16 blocks, 64 nodes): {} of splineway, {} of libm, {} of core and compiler",
        size.own, size.libm, size.other
    );
    if size.own > CODE {
        missed.push(format!("splineway takes {} bytes of flash; {CODE} is the bound", size.own));
    }
    println!("RAM of a core, bytes (f32, 3 axes, 16 blocks, 64 nodes): {}", size.link);
    if size.link > RAM {
        missed.push(format!("a core takes {} bytes of RAM; {RAM} is the goal", size.link));
    }
    let code = proof.listing()?;
    for (axes, goal) in TICK {
        let most = longest(&code, &format!("tick_{axes}"), &LOOPS)?;
        println!(
            "instructions of a tick in {axes} axes, on the longest path through its code: {most}"
        );
        if most > goal {
            missed.push(format!(
                "a tick in {axes} axes may take {most} instructions; {goal} is the goal"
            ));
        }
    }
    let entries = ["tick", "split", "push", "poll"];
    let entries = entries.iter().flat_map(|entry| [3, 6].map(|axes| format!("{entry}_{axes}")));
    missed.extend(stacks(&code, entries)?);
    let c = Image::build_c()?;
    c.check_symbols()?;
    println!("C: the library links for the target without a panic");
    missed.extend(stacks(&c.listing()?, c.entries()?.into_iter())?);
    ensure!(missed.is_empty(), "{}", missed.join("\n"));
    Ok(())
}

fn main() -> Result<()> {
    match report() {
        Err(error)
            if error.is::<built::Missing>()
                && std::env::var_os("SPLINEWAY_REQUIRE_TARGET").is_none() =>
        {
            println!("skipped: {error:#}");
            Ok(())
        }
        outcome => outcome,
    }
}
