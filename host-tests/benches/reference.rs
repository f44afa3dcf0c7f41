//! The planner's times beside the least time along the very same path.
//!
//! `cargo bench -p splineway-host --bench reference [-- FOLDER]`. The geometry is taken from the
//! setpoints of the run itself (position, velocity and acceleration of every servo cycle give
//! tangent and curvature by arc length). The least time along it is then computed by a method that
//! has nothing in common with the planner's: over b = v^2 at the setpoints' places, speed and
//! acceleration limits are linear, and so is the limit of jerk, v (x''' b + 3 x'' b' / 2 + x' b'' /
//! 2), once its factor v is frozen. A quadratic program (clarabel) minimises the time's second-order
//! model; then v is frozen again at the geometric mean of old and new; twelve rounds. Limits are
//! held only at the setpoints, by differences, so the reference is on the optimistic side.

use anyhow::{Result, ensure};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus,
};
use splineway_host::machine::{Axis, Machine};
use splineway_host::program::{self, ReadOptions};
use splineway_host::run::{Observer, Precision, Sample, run};
use std::path::{Path, PathBuf};

/// Rounds of freezing and solving.
const ROUNDS: usize = 12;
/// Speed, mm/s, from which on a motion is looked at: below it starts or stops at constant jerk.
const SLOW: f64 = 3.0;
/// Longest run of setpoints solved at once; its ends are kept as they are.
const CHUNK: usize = 3000;

/// One setpoint with the derivatives of the path by arc length.
#[derive(Clone, Debug)]
struct Place {
    speed: f64,
    acceleration: f64,
    tangent: Vec<f64>,
    bend: Vec<f64>,
}

/// Records the setpoints of a run.
#[derive(Default)]
struct Record {
    places: Vec<Place>,
    ways: Vec<f64>,
}

impl Observer for Record {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let square: f64 = sample.velocity.iter().map(|v| v * v).sum();
        let speed = square.sqrt();
        let tangent: Vec<f64> = sample.velocity.iter().map(|v| v / speed.max(1e-9)).collect();
        let along: f64 = tangent.iter().zip(sample.acceleration).map(|(t, a)| t * a).sum();
        let bend = sample
            .acceleration
            .iter()
            .zip(&tangent)
            .map(|(a, t)| (a - t * along) / square.max(1e-9))
            .collect();
        self.places.push(Place { speed, acceleration: along, tangent, bend });
        self.ways.push(sample.path);
        Ok(())
    }
}

/// Lengths between setpoints from speeds and accelerations at both ends: exact for a quartic.
fn steps(places: &[Place], cycle: f64) -> Vec<f64> {
    places
        .windows(2)
        .map(|p| {
            (p[0].speed + p[1].speed) * cycle / 2.0
                + (p[0].acceleration - p[1].acceleration) * cycle * cycle / 12.0
        })
        .collect()
}

/// Rows of the program: `coefficients . b <= bound`.
#[derive(Default)]
struct Rows {
    row: Vec<usize>,
    column: Vec<usize>,
    value: Vec<f64>,
    bound: Vec<f64>,
}

impl Rows {
    fn push(&mut self, entries: &[(usize, f64)], bound: f64) {
        for &(column, value) in entries {
            self.row.push(self.bound.len());
            self.column.push(column);
            self.value.push(value / bound.abs());
        }
        self.bound.push(bound.signum());
    }

    fn both(&mut self, entries: &[(usize, f64)], bound: f64) {
        self.push(entries, bound);
        let negative: Vec<(usize, f64)> = entries.iter().map(|&(k, x)| (k, -x)).collect();
        self.push(&negative, bound);
    }
}

/// Least time over a run of setpoints whose first two and last two speeds are kept, s.
fn least_time(places: &[Place], cycle: f64, limits: &[Axis], feed: f64) -> Result<f64> {
    let n = places.len();
    let ds = steps(places, cycle);
    let before: Vec<f64> = places.iter().map(|place| place.speed * place.speed).collect();
    let mut b = before.clone();
    let mut frozen: Vec<f64> = places.iter().map(|place| place.speed).collect();
    for _ in 0..ROUNDS {
        // Minimise sum of ds (1 / v) by its model to the second order; unknown: b over its scale.
        let scale: Vec<f64> = b.clone();
        let mut linear = vec![0.0; n];
        let mut square = vec![0.0; n];
        for k in 1..n - 1 {
            let weight = (ds[k - 1] + ds[k]) / 2.0 / b[k].sqrt();
            // f = w y^-1/2 at y = 1: slope -1/2, curvature 3/4.
            linear[k] = weight * (-0.5 - 0.75);
            square[k] = weight * 0.75;
        }
        let mut rows = Rows::default();
        for k in 0..n {
            if k < 2 || k + 2 >= n {
                // Kept.
                rows.push(&[(k, 1.0)], before[k] / scale[k] * (1.0 + 1e-9));
                rows.push(&[(k, -1.0)], -before[k] / scale[k] * (1.0 - 1e-9));
                continue;
            }
            rows.push(&[(k, -1.0)], -0.2);
            rows.push(&[(k, 1.0)], 4.0);
            let place = &places[k];
            let mut most = feed;
            for (tangent, limit) in place.tangent.iter().zip(limits) {
                most = most.min(limit.velocity / tangent.abs().max(1e-9));
            }
            rows.push(&[(k, scale[k])], most * most);
            let (h0, h1) = (ds[k - 1], ds[k]);
            // First and second derivative of b by s over three places.
            let d1 = [-h1 / (h0 * (h0 + h1)), (h1 - h0) / (h0 * h1), h0 / (h1 * (h0 + h1))];
            let d2 = [2.0 / (h0 * (h0 + h1)), -2.0 / (h0 * h1), 2.0 / (h1 * (h0 + h1))];
            for (i, limit) in limits.iter().enumerate() {
                let (x1, x2) = (place.tangent[i], place.bend[i]);
                let third =
                    |j: usize| [places[k - 1].bend[i], x2, places[k + 1].bend[i]][j] * d1[j];
                let x3 = third(0) + third(1) + third(2);
                if x1.abs() < 1e-7 && x2.abs() < 1e-7 {
                    continue;
                }
                let entries = |own: f64, first: f64, second: f64| {
                    [0, 1, 2].map(|j| {
                        let direct = if j == 1 { own } else { 0.0 };
                        let at = k + j - 1;
                        (at, (direct + first * d1[j] + second * d2[j]) * scale[at])
                    })
                };
                rows.both(&entries(x2, x1 / 2.0, 0.0), limit.acceleration);
                rows.both(&entries(x3, 1.5 * x2, x1 / 2.0), limit.jerk / frozen[k]);
            }
        }
        let m = rows.bound.len();
        let constraint = CscMatrix::new_from_triplets(m, n, rows.row, rows.column, rows.value);
        let all: Vec<usize> = (0..n).collect();
        let objective = CscMatrix::new_from_triplets(n, n, all.clone(), all, square);
        let settings =
            DefaultSettingsBuilder::default().verbose(false).max_iter(100).build().unwrap();
        let cones = [NonnegativeConeT(m)];
        let mut solver =
            DefaultSolver::new(&objective, &linear, &constraint, &rows.bound, &cones, settings)?;
        solver.solve();
        ensure!(
            matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved),
            "the reference was not solved: {:?}",
            solver.solution.status
        );
        for k in 0..n {
            b[k] = (solver.solution.x[k] * scale[k]).max(1e-6);
            frozen[k] = (frozen[k] * b[k].sqrt()).sqrt();
        }
    }
    // Trapezoids in 1 / v, with the correction that makes the run itself come out exactly.
    let time = |b: &[f64]| -> f64 {
        (0..n - 1).map(|k| 2.0 * ds[k] / (b[k].sqrt() + b[k + 1].sqrt())).sum()
    };
    let own = (n - 1) as f64 * cycle;
    Ok(time(&b) * own / time(&before))
}

/// Planner's time and least time of a path.
fn compare(path: &Path) -> Result<(f64, f64)> {
    let program = program::read(path, ReadOptions { feed: 200.0, segments: 80 })?;
    let mut machine = Machine::default();
    if let Some(header) = &program.header {
        machine.apply(header);
    }
    let limits = machine.axes_of(&program)?;
    let mut record = Record::default();
    run(&program, &machine, Precision::F64, &mut [&mut record])?;
    let places = record.places;
    let own = (places.len() - 2) as f64 * machine.cycle;
    let mut least = own;
    let mut first = 0;
    while first < places.len() {
        if places[first].speed < SLOW {
            first += 1;
            continue;
        }
        let moving = places[first..].iter().take(CHUNK).take_while(|p| p.speed >= SLOW).count();
        let chunk = &places[first..first + moving];
        if moving > 8 {
            let time = least_time(chunk, machine.cycle, &limits, 200.0)?;
            least += time - (moving - 1) as f64 * machine.cycle;
        }
        first += moving;
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
