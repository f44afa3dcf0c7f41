//! The planner's times beside the least time along the very same path.
//!
//! `cargo bench -p splineway-host --bench reference [-- FOLDER]`. The geometry is taken from the
//! setpoints of the run itself, at several times the servo rate: position, velocity and acceleration
//! of every servo cycle give tangent and curvature by arc length. The least time along it is that of
//! `splineway_studies::reference`.

mod common;

use anyhow::{Result, anyhow};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, ReadOptions};
use splineway_simulator::run::{Precision, run};
use splineway_studies::geometry::Geometry;
use splineway_studies::reference::{Ends, Place, least_time, time};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Speed, mm/s, from which on a motion is looked at: below it starts or stops at constant jerk.
const SLOW: f64 = 3.0;
/// Longest run of setpoints solved at once; its ends are kept as they are.
const CHUNK: usize = 6000;
const ROUNDS: usize = 8;
/// Setpoints are taken this many times per servo cycle: between them the reference sees nothing, and
/// kinks of dense paths would go unnoticed. Fewer for runs longer than [`LONG`], s, to save time.
const FINER: f64 = 8.0;
const LESS_FINE: f64 = 2.0;
const LONG: f64 = 30.0;

/// Planner's time and least time of a path.
fn compare(path: &Path) -> Result<(f64, f64)> {
    let options = ReadOptions { feed: 200.0, ..ReadOptions::DEFAULT };
    // A NURBS curve as chords, all else as it is.
    let program = program::read(path, ReadOptions { segments: Some(80), ..options })
        .or_else(|_| program::read(path, options))?;
    let mut machine = Machine::default();
    if let Some(header) = &program.header {
        machine.apply(header);
    }
    let limits = machine.axes_of(&program)?;
    let mut record = Geometry::new(machine.cycle);
    run(&program, &machine, Precision::F64, &mut [&mut record])?;
    let long = record.places.len() as f64 * machine.cycle > LONG;
    machine.cycle /= if long { LESS_FINE } else { FINER };
    record = Geometry::new(machine.cycle);
    run(&program, &machine, Precision::F64, &mut [&mut record])?;
    let (places, speeds): (&[Place], &[f64]) = (&record.places, &record.speeds);
    let own = (places.len() - 2) as f64 * machine.cycle;
    let mut least = own;
    let mut first = 0;
    while first < places.len() {
        let moving = speeds[first..].iter().take(CHUNK).take_while(|v| **v >= SLOW).count();
        let chunk = first..first + moving;
        if moving > 8 {
            let (places, before) = (&places[chunk.clone()], &speeds[chunk]);
            let after = least_time(places, &limits, 200.0, before, Ends::Kept, ROUNDS)?;
            // As a ratio, so that the rule of the sum does not matter.
            let share = time(places, &after) / time(places, before);
            least -= (1.0 - share) * (moving - 1) as f64 * machine.cycle;
        }
        first += moving.max(1);
    }
    Ok((own, least))
}

fn main() -> Result<()> {
    let paths = common::paths();
    if paths.is_empty() {
        return Ok(());
    }
    println!("{:<20} {:>10} {:>14} {:>8}", "path", "planner, s", "least time, s", "ratio");
    let (mut sum, mut worst) = (0.0, 0.0f64);
    // On as many threads as the machine has: a path takes minutes.
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(vec![None; paths.len()]);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    let Some(path) = paths.get(k) else { return };
                    let outcome = compare(path).map_err(|error| format!("{error:#}"));
                    outcomes.lock().unwrap()[k] = Some(outcome);
                }
            });
        }
    });
    for (path, outcome) in paths.iter().zip(outcomes.into_inner().unwrap()) {
        let (own, least) = outcome
            .unwrap_or(Err("not run".to_owned()))
            .map_err(|error| anyhow!("{}: {error}", path.display()))?;
        let ratio = own / least;
        sum += ratio;
        worst = worst.max(ratio);
        println!(
            "{:<20} {own:>10.3} {least:>14.3} {ratio:>8.4}",
            path.file_stem().unwrap_or_default().to_string_lossy()
        );
    }
    println!("mean ratio {:.4}, worst {worst:.4}", sum / paths.len().max(1) as f64);
    Ok(())
}
