//! What planning and interpolating cost: nanoseconds (divan) and instructions (callgrind).
//!
//! `cargo bench -p splineway-host --bench cost [-- FOLDER]`. A dense program - a circle of 20 mm in chords of
//! 0.05 mm, then a meander of 0.2 mm steps - runs through the core with three axes in `f32`, at
//! look-ahead depths of 16, 64 and 256 blocks. Instruction counts are exact and need valgrind; without
//! it they are skipped, and it says so. Then the same for planning a path of corners in both modes and the bench paths in
//! FOLDER, with `splineway simulate`.

mod common;

use divan::Bencher;
use divan::counter::ItemsCount;
use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Interpolator, Limits, Link, Planner, Progress,
    PushError, Setpoint,
};
use std::hint::black_box;
use std::process::Command;

/// Which part of the core is counted in a run under callgrind, and at which depth.
const PART: &str = "SPLINEWAY_COST_PART";
const DEPTH: &str = "SPLINEWAY_COST_DEPTH";
const DEPTHS: [usize; 3] = [16, 64, 256];

fn program() -> Vec<Block<f32, 3>> {
    let point = |x: f64, y: f64| [x, y, 0.0].map(|mm| Coord::from_mm(mm).unwrap());
    let circle = (1..=1257).map(|k| {
        let angle = f64::from(k) * std::f64::consts::TAU / 1257.0;
        (10.0 * angle.sin(), 10.0 - 10.0 * angle.cos())
    });
    let meander = (1..=400).map(|k| {
        let along = f64::from(k) * 0.2;
        (along, 1.5 * (along * 0.9).sin() + 0.4 * (along * 2.7).sin())
    });
    circle
        .chain(meander)
        .zip(1..)
        .map(|((x, y), tag)| Block::line(point(x, y), 200.0, tag))
        .collect()
}

fn config() -> Config<f32, 3> {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; 3]).unwrap());
    config.tolerance = 0.01;
    config
}

#[inline(never)]
fn planning_step<const BLOCKS: usize, const NODES: usize>(
    planner: &mut Planner<'_, f32, 3, BLOCKS, NODES>,
    blocks: &mut std::iter::Peekable<std::slice::Iter<'_, Block<f32, 3>>>,
) -> Progress {
    while let Some(block) = blocks.peek() {
        match planner.push(block) {
            Ok(()) => blocks.next(),
            Err(PushError::Full) => break,
            Err(error) => panic!("{error}"),
        };
    }
    if blocks.peek().is_none() {
        planner.finish();
    }
    planner.settle()
}

#[inline(never)]
fn servo_tick(interpolator: &mut Interpolator<'_, f32, 3>) -> Setpoint<f32, 3> {
    interpolator.tick()
}

/// Runs the program; returns blocks and ticks.
fn run<const BLOCKS: usize, const NODES: usize>(program: &[Block<f32, 3>]) -> (usize, usize) {
    let mut link = Box::new(Link::<f32, 3, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator) = link.split(config(), [Coord::ZERO; 3]).unwrap();
    let mut blocks = program.iter().peekable();
    for ticks in 1.. {
        let progress = planning_step(&mut planner, &mut blocks);
        let setpoint = black_box(servo_tick(&mut interpolator));
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            return (program.len(), ticks);
        }
    }
    unreachable!("a run ends")
}

fn run_at(depth: usize, program: &[Block<f32, 3>]) -> (usize, usize) {
    match depth {
        16 => run::<16, 64>(program),
        64 => run::<64, 192>(program),
        _ => run::<256, 512>(program),
    }
}

/// A whole run per block: planning, and the ticks that belong to it.
#[divan::bench(args = DEPTHS)]
fn whole_run_per_block(bencher: Bencher<'_, '_>, depth: usize) {
    let program = program();
    bencher.counter(ItemsCount::new(program.len())).bench(|| run_at(depth, &program));
}

/// One tick in motion.
#[divan::bench(sample_count = 200)]
fn tick(bencher: Bencher<'_, '_>) {
    let program = program();
    let mut link = Box::new(Link::<f32, 3, 256, 512>::new());
    let (mut planner, mut interpolator) = link.split(config(), [Coord::ZERO; 3]).unwrap();
    let mut blocks = program.iter().peekable();
    // Planning happens in between, outside the measured time.
    bencher
        .with_inputs(|| {
            if planning_step(&mut planner, &mut blocks) == Progress::Done {
                blocks = program.iter().peekable();
            }
        })
        .bench_local_values(|()| servo_tick(&mut interpolator));
}

/// The planner's entries, whole: a function that one of them calls and that matched as well would turn counting off.
const ENTRIES: [&str; 2] = ["*Planner<*>::settle", "*Planner<*>::push"];

/// Instructions that a command spends in the functions whose whole names match, a run for each: of several patterns
/// callgrind heeds one. `None` without valgrind.
fn instructions(parts: &[&str], command: &Command) -> Option<f64> {
    parts.iter().map(|part| instructions_of(part, command)).sum()
}

fn instructions_of(part: &str, command: &Command) -> Option<f64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(format!("--toggle-collect={part}"))
        .arg(command.get_program())
        .args(command.get_args())
        .envs(command.get_envs().filter_map(|(key, value)| Some((key, value?))))
        .output()
        .ok()?;
    let text = String::from_utf8_lossy(&output.stderr);
    let line = text.lines().find(|line| line.contains("Collected"))?;
    line.rsplit(':').next()?.trim().parse().ok()
}

/// Instructions of this program's functions whose name matches, in a run at a depth.
fn own_instructions(part: &str, depth: usize) -> Option<f64> {
    let mut command = Command::new(std::env::current_exe().ok()?);
    instructions(&[&format!("*{part}*")], command.env(PART, part).env(DEPTH, depth.to_string()))
}

/// Instructions per block of planning the bench paths.
fn print_paths() {
    println!("{:<20} {:>8} {:>24}", "path, depth 16, f32", "blocks", "instructions per block");
    for path in common::paths() {
        let mut command = Command::new(env!("CARGO_BIN_EXE_splineway"));
        command.arg("simulate").arg(&path).args(["--scalar", "f32", "--lookahead", "16"]);
        let Some(sum) = instructions(&ENTRIES, &command) else {
            println!("skipped: valgrind is not there, so no instructions are counted");
            return;
        };
        let blocks = std::fs::read_to_string(&path).map_or(0, |text| {
            text.lines()
                .filter(|line| line.starts_with(|c: char| c == '-' || c.is_numeric()))
                .count()
        });
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        println!("{name:<20} {blocks:>8} {:>24.0}", sum / blocks as f64);
    }
}

/// Instructions per line of a path of corners - the butterfly in 80 lines - in either mode: for its geometry, and for all
/// planning.
fn print_corners() {
    const LINES: u32 = 80;
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/data/butterfly.json");
    println!(
        "{:<24} {:>22} {:>22}",
        "butterfly in 80 lines", "geometry, per line", "planning, per line"
    );
    for mode in ["band", "paper"] {
        let count = |parts: &[&str]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_splineway"));
            command.args(["simulate", file, "--tolerance", "0.05", "--feed", "200", "--quiet"]);
            command.args(["--segments", &LINES.to_string(), "--mode", mode]);
            command.args(["--scalar", "f32", "--lookahead", "16"]);
            Some(instructions(parts, &command)? / f64::from(LINES))
        };
        let (Some(geometry), Some(planning)) = (count(&["*Builder<*>::cut"]), count(&ENTRIES))
        else {
            println!("skipped: valgrind is not there, so no instructions are counted");
            return;
        };
        println!("{mode:<24} {geometry:>22.0} {planning:>22.0}");
        assert!(geometry > 0.0 && geometry < planning, "a part is missing: {geometry} {planning}");
    }
}

fn print_instructions() {
    let program = program();
    println!("{:<8} {:>24} {:>22}", "depth", "instructions per block", "instructions per tick");
    let mut first = None;
    for depth in DEPTHS {
        let (blocks, ticks) = run_at(depth, &program);
        let (Some(planning), Some(ticking)) =
            (own_instructions("planning_step", depth), own_instructions("servo_tick", depth))
        else {
            println!("skipped: valgrind is not there, so no instructions are counted");
            return;
        };
        let per_block = planning / blocks as f64;
        let first = *first.get_or_insert(per_block);
        println!(
            "{depth:<8} {per_block:>24.0} {:>22.1}   ({:.2} of depth 16)",
            ticking / ticks as f64,
            per_block / first
        );
        assert!(per_block <= 2.0 * first, "planning a block costs more than twice as much");
    }
}

fn main() {
    if std::env::var_os(PART).is_some() {
        // Under callgrind: just the run.
        let depth = std::env::var(DEPTH).ok().and_then(|depth| depth.parse().ok());
        black_box(run_at(depth.unwrap_or(64), &program()));
        return;
    }
    print_instructions();
    print_corners();
    print_paths();
    divan::main();
}
