//! `splineway thesis`: the tables of Naseath 2007 beside this program's.

use anyhow::Result;
use splineway_simulator::spline::Path;
use splineway_splines::Trajectory;
use splineway_studies::smoothing::cases::{Case, RADII, all, ripple, ripple_peaks};
use splineway_studies::smoothing::{Figures, Method, Request, Smoothed, measure, smooth};

/// Rebuilds the test cases of Naseath 2007, smooths them as printed and in bounded sweeps, and prints
/// the figures beside those of the thesis's tables 4-1, 4-3, 4-4, 4-5 and 4-6
#[derive(Debug, clap::Args)]
pub struct Thesis {}

/// One path smoothed by one method within one radius.
struct Run {
    figures: Figures,
    smoothed: Smoothed,
    /// How far it is from the path as given, at equal parameter, over the radius.
    off: f64,
}

fn run(path: &Path, method: Method, radius: f64, trajectory: &Trajectory<f64>) -> Result<Run> {
    let smoothed = smooth(path, &Request::new(method, radius))?;
    let off = smoothed.path.difference(path).map_or(0.0, |d| d.greatest(200)) / radius;
    Ok(Run { figures: measure(&smoothed.path, trajectory), smoothed, off })
}

/// By how much `to` is less than `from`, per cent.
fn saved(from: f64, to: f64) -> f64 {
    (from - to) / from * 100.0
}

const METHODS: [Method; 2] = [Method::Thesis, Method::Bounded];

impl Thesis {
    /// # Errors
    /// None, unless the cases themselves are wrong.
    pub fn execute(&self) -> Result<()> {
        let trajectory = Trajectory::thesis();
        let cases = all()?;
        let mut runs = Vec::new();
        for case in &cases {
            let given = measure(&case.path, &trajectory);
            let mut rows = Vec::new();
            for radius in RADII {
                let mut row = Vec::new();
                for method in METHODS {
                    row.push(run(&case.path, method, radius, &trajectory)?);
                }
                rows.push(row);
            }
            runs.push((case, given, rows));
        }
        print_table(&runs);
        print_means(&runs);
        print_ripples(&trajectory)
    }
}

type Runs<'a> = [(&'a Case, Figures, Vec<Vec<Run>>)];

fn print_table(runs: &Runs<'_>) {
    println!(
        "Improvement in per cent: printed in the thesis, its method here, bounded sweeps here."
    );
    println!("Deviation over radius is dense (200 places per span), calculation time in ms.\n");
    println!(
        "{:<13} {:>5} | {:>26} | {:>26} | {:>26} | {:>11} | {:>26}",
        "case",
        "R, mm",
        "curvature (table 4-1), %",
        "length (4-3), %",
        "time (4-4), %",
        "deviation/R",
        "calculation (4-5), ms"
    );
    for (case, given, rows) in runs {
        println!(
            "{}: {:<10} {:>5} | {:>8.4} {:>8.4} 1/mm     | {:>8.2} {:>8.2} mm       | {:>8.3} {:>8.3} s        | {:>11} | {} control points",
            case.number,
            case.name,
            "given",
            case.published.curvature[0],
            given.curvature_average,
            case.published.length[0],
            given.length_mm,
            case.published.time[0],
            given.time_s,
            "",
            case.path.controls().len()
        );
        for (k, row) in rows.iter().enumerate() {
            let printed = |values: [f64; 4]| saved(values[0], values[k + 1]);
            let own = |value: fn(&Figures) -> f64| -> [f64; 2] {
                [0, 1].map(|m| saved(value(given), value(&row[m].figures)))
            };
            let p = &case.published;
            let (c, l, t) = (own(|f| f.curvature_average), own(|f| f.length_mm), own(|f| f.time_s));
            println!(
                "{:<13} {:>5} | {:>8.2} {:>8.2} {:>8.2} | {:>8.2} {:>8.2} {:>8.2} | {:>8.2} {:>8.2} {:>8.2} | {:>5.3} {:>5.3} | {:>8.0} {:>8.3} {:>8.3}",
                "",
                RADII[k],
                printed(p.curvature),
                c[0],
                c[1],
                printed(p.length),
                l[0],
                l[1],
                printed(p.time),
                t[0],
                t[1],
                row[0].off,
                row[1].off,
                p.calculation[k] * 1e3,
                row[0].smoothed.took.as_secs_f64() * 1e3,
                row[1].smoothed.took.as_secs_f64() * 1e3,
            );
        }
    }
}

fn print_means(runs: &Runs<'_>) {
    println!(
        "\nMeans over the cases (table 4-6), per cent: printed, thesis's method, bounded sweeps"
    );
    println!("{:<6} | {:>26} | {:>26} | {:>26}", "R, mm", "length", "curvature", "time");
    let printed = [(0.20, 2.78, 1.10), (1.02, 13.28, 6.61), (1.93, 23.26, 18.12)];
    for (k, radius) in RADII.iter().enumerate() {
        let mean = |m: usize, value: fn(&Figures) -> f64| -> f64 {
            let sum: f64 = runs
                .iter()
                .map(|(_, given, rows)| saved(value(given), value(&rows[k][m].figures)))
                .sum();
            sum / runs.len() as f64
        };
        let own = |value: fn(&Figures) -> f64| [0, 1].map(|m| mean(m, value));
        let (l, c, t) = (own(|f| f.length_mm), own(|f| f.curvature_average), own(|f| f.time_s));
        let (pl, pc, pt) = printed[k];
        println!(
            "{radius:<6} | {pl:>8.2} {:>8.2} {:>8.2} | {pc:>8.2} {:>8.2} {:>8.2} | {pt:>8.2} {:>8.2} {:>8.2}",
            l[0], l[1], c[0], c[1], t[0], t[1]
        );
    }
}

fn print_ripples(trajectory: &Trajectory<f64>) -> Result<()> {
    println!("\nSingle ripples (section 3.12): peak of curvature and time saved, per cent");
    println!("{:<12} | {:>53} | {:>53}", "", "thesis's method", "bounded sweeps");
    print!("{:<12}", "peak, 1/mm");
    for _ in METHODS {
        for radius in RADII {
            print!(" | {:>7} R = {radius:<5}", "");
        }
    }
    println!();
    for wanted in ripple_peaks() {
        let path = ripple(wanted)?;
        let given = measure(&path, trajectory);
        print!("{wanted:<12.4}");
        for method in METHODS {
            for radius in RADII {
                let run = run(&path, method, radius, trajectory)?;
                print!(
                    " | {:>7.2} {:>8.2}",
                    saved(given.curvature_peak, run.figures.curvature_peak),
                    saved(given.time_s, run.figures.time_s)
                );
            }
        }
        println!();
    }
    Ok(())
}
