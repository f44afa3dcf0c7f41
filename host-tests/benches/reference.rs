//! The planner's times beside the least time along the very same path.
//!
//! `cargo bench -p splineway-host --bench reference [-- FOLDER]`. The geometry is taken from the
//! setpoints of the run itself: position, velocity and acceleration of every servo cycle give
//! tangent and curvature by arc length. The least time along it is that of
//! `splineway_host::reference`.

use anyhow::Result;
use splineway_host::machine::Machine;
use splineway_host::program::{self, ReadOptions};
use splineway_host::reference::{Ends, Place, least_time, time};
use splineway_host::run::{Geometry, Precision, run};
use std::path::{Path, PathBuf};

/// Speed, mm/s, from which on a motion is looked at: below it starts or stops at constant jerk.
const SLOW: f64 = 3.0;
/// Longest run of setpoints solved at once; its ends are kept as they are.
const CHUNK: usize = 3000;
const ROUNDS: usize = 12;

/// Planner's time and least time of a path.
fn compare(path: &Path) -> Result<(f64, f64)> {
    let program = program::read(path, ReadOptions { feed: 200.0, segments: 80 })?;
    let mut machine = Machine::default();
    if let Some(header) = &program.header {
        machine.apply(header);
    }
    let limits = machine.axes_of(&program)?;
    let mut record = Geometry::new(machine.cycle);
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
    let given = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let folder = given.map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/bench/paths"),
        PathBuf::from,
    );
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: the bench paths are not at {}", folder.display());
        return Ok(());
    };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "txt"));
    paths.sort();
    println!("{:<20} {:>10} {:>14} {:>8}", "path", "planner, s", "least time, s", "ratio");
    let (mut sum, mut worst) = (0.0, 0.0f64);
    for path in &paths {
        let (own, least) = compare(path)?;
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
