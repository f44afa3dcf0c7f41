//! Memory of the core, and machining times of the common bench paths beside stops at every corner.
//!
//! `cargo bench --bench paths [-- FOLDER]`; the paths lie in `../shared/bench/paths` beside the
//! checkout. Without them there is nothing to do, and it says so.

mod common;

use splineway::{Link, Planner, Scalar};
use splineway_host::machine::Machine;
use splineway_host::program::{self, Program, ReadOptions};
use splineway_host::run::{Judge, Precision, Stats, Track, Verdict, run};
use splineway_host::view::violations;
use std::path::Path;

fn judge(
    program: &Program,
    machine: &Machine,
    precision: Precision,
) -> anyhow::Result<(Verdict, Stats)> {
    let limits = machine.axes_of(program)?;
    let track = Track::new(program);
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
    let stats = run(program, machine, precision, &mut [&mut judge])?;
    Ok((judge.verdict(), stats))
}

fn row(path: &Path) -> anyhow::Result<()> {
    let program = program::read(path, ReadOptions { feed: 200.0, segments: 80 })?;
    let mut machine = Machine::default();
    if let Some(header) = &program.header {
        machine.apply(header);
    }
    let (wide, stats) = judge(&program, &machine, Precision::F64)?;
    let (narrow, _) = judge(&program, &machine, Precision::F32)?;
    let mut stops = program.clone();
    for step in &mut stops.moves {
        step.exact_stop = true;
    }
    let (stopping, _) = judge(&stops, &machine, Precision::F64)?;
    let limits = machine.axes_of(&program)?;
    let worst = wide.worst();
    let broken = [
        violations(&wide, Precision::F64, machine.cycle, machine.tolerance, &limits),
        violations(&narrow, Precision::F32, machine.cycle, machine.tolerance, &limits),
    ]
    .concat();
    println!(
        "{:<20} {:>9.3} {:>9.3} {:>10.3} {:>8.3} {:>7.4} {:>7.4} {:>7.4} {:>10.0}  {}",
        path.file_stem().unwrap_or_default().to_string_lossy(),
        wide.time,
        narrow.time,
        stopping.time,
        wide.deviation / machine.tolerance,
        worst.velocity,
        worst.acceleration,
        worst.jerk,
        stats.planning.total() / stats.blocks.max(1) as f64,
        if broken.is_empty() { "ok".to_owned() } else { broken.join("; ") }
    );
    anyhow::ensure!(broken.is_empty(), "{}: a limit is broken", path.display());
    anyhow::ensure!(wide.time <= stopping.time, "{}: slower than stopping", path.display());
    Ok(())
}

/// Bytes of the two parts of a core.
fn print_memory<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>() {
    println!(
        "{:<4} {N} axes {BLOCKS:>4} blocks {NODES:>4} nodes   link {:>7} bytes   planner {:>7} bytes",
        S::NAME,
        size_of::<Link<S, N, NODES>>(),
        size_of::<Planner<'static, S, N, BLOCKS, NODES>>(),
    );
}

fn main() -> anyhow::Result<()> {
    print_memory::<f32, 3, 8, 56>();
    print_memory::<f32, 3, 16, 64>();
    print_memory::<f32, 3, 128, 96>();
    print_memory::<f32, 6, 8, 56>();
    print_memory::<f32, 6, 16, 64>();
    print_memory::<f64, 3, 64, 192>();
    let paths = common::paths();
    if paths.is_empty() {
        return Ok(());
    }
    println!(
        "{:<20} {:>9} {:>9} {:>10} {:>8} {:>7} {:>7} {:>7} {:>10}",
        "path", "f64, s", "f32, s", "stops, s", "dev/tol", "v", "a", "j", "ns/block"
    );
    paths.iter().try_for_each(|path| row(path))
}
