//! `splineway smooth`: lowers the curvature of a spline file inside a tube.

use super::files::{self, named};
use crate::view::{TubeScene, plot_tube};
use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use splineway_simulator::spline::{Path, SplineFile, read, write};
use splineway_splines::Trajectory;
use splineway_studies::smoothing::{
    Figures, Method, Reading, Request, Smoothed, measure, profile, run, smooth,
};
use std::path::PathBuf;

/// Greatest number of places of a profile in the report.
const PROFILE: usize = 2000;

/// Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed
/// and machining time before and after
#[derive(Debug, clap::Args)]
pub struct Smooth {
    /// Spline file: .json, .toml or .txt (control points, knots, tolerance, precision, accuracy)
    file: PathBuf,
    /// Radius of the tube, mm; the file's if left out
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Places per knot interval at which the thesis's method takes distances [default: the file's, or 5]
    #[arg(long, value_name = "COUNT")]
    precision: Option<u32>,
    /// Share of the radius within which the thesis's method ends [default: the file's, or 0.01]
    #[arg(long, value_name = "SHARE")]
    accuracy: Option<f64>,
    /// Most iterations of the thesis's method, or sweeps per pass of the bounded one
    #[arg(long, value_name = "COUNT")]
    iterations: Option<u32>,
    /// The spline is closed: the knots are its intervals
    #[arg(long)]
    closed: bool,
    /// How to smooth
    #[arg(long, value_enum, default_value = "bounded")]
    method: Method,
    /// Feed of the trajectory generator, mm/s
    #[arg(long, value_name = "MM_PER_S", default_value_t = 400.0)]
    feed: f64,
    /// Its acceleration, mm/s2
    #[arg(long, value_name = "MM_PER_S2", default_value_t = 4000.0)]
    acceleration: f64,
    /// Its jerk, mm/s3
    #[arg(long, value_name = "MM_PER_S3", default_value_t = 20_000.0)]
    jerk: f64,
    /// How section 4.5 of the thesis is read
    #[arg(long, value_enum, default_value = "free")]
    reading: Reading,
    /// The smoothed spline (.json, .toml or .txt)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Figures and profiles (JSON)
    #[arg(long, value_name = "JSON")]
    report: Option<PathBuf>,
    /// Plot (.html, .svg or .png)
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// What is written as JSON.
#[derive(Serialize)]
struct Report {
    method: String,
    radius_mm: f64,
    iterations: u32,
    ending: String,
    calculation_s: f64,
    deviation_mm: f64,
    deviation_bound_mm: f64,
    before: Side,
    after: Side,
}

/// A path's figures and profiles.
#[derive(Serialize)]
struct Side {
    #[serde(flatten)]
    figures: Figures,
    /// Way, mm, and curvature, 1/mm.
    curvature: Vec<[f64; 2]>,
    /// Way, mm, and feed, mm/s.
    feed: Vec<[f64; 2]>,
}

fn thin(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let all: Vec<[f64; 2]> = points.collect();
    let step = all.len().div_ceil(PROFILE).max(1);
    all.into_iter().step_by(step).collect()
}

fn side(path: &Path, trajectory: &Trajectory<f64>, reading: Reading) -> Side {
    let places = profile(path);
    let moments = run(trajectory, &places, reading).moments;
    Side {
        figures: measure(path, trajectory, reading),
        curvature: thin(places.iter().map(|place| [place.way, place.curvature])),
        feed: thin(moments.into_iter().map(|moment| [moment.way, moment.speed])),
    }
}

impl Smooth {
    /// # Errors
    /// What is wrong with a file or an option, and where.
    pub fn execute(&self) -> Result<()> {
        self.check_files()?;
        let mut file = read(&self.file)?;
        file.closed |= self.closed;
        let name = self.file.display();
        if !file.other.is_empty() {
            let other: Vec<&str> = file.other.keys().map(String::as_str).collect();
            eprintln!("warning: {name}: not used: {}", other.join(", "));
        }
        let given = file.path().with_context(|| name.to_string())?;
        let Some(radius) = self.tolerance.or(file.tolerance) else {
            bail!("{name}: no tolerance in the file; give one with --tolerance");
        };
        for (what, value) in
            [("feed", self.feed), ("acceleration", self.acceleration), ("jerk", self.jerk)]
        {
            if !(value > 0.0 && value.is_finite()) {
                return Err(anyhow!("--{what} {value} must be greater than 0"));
            }
        }
        let trajectory =
            Trajectory { feed: self.feed, acceleration: self.acceleration, jerk: self.jerk };
        let mut request = Request::new(self.method, radius);
        request.precision = self.precision.or(file.precision).unwrap_or(request.precision);
        request.accuracy = self.accuracy.or(file.accuracy).unwrap_or(request.accuracy);
        request.iterations = self.iterations;
        request.ends_stay = true;
        let smoothed = smooth(&given, &request)?;
        let report = self.report(&given, &smoothed, radius, &trajectory);
        print(&report);
        if let Some(out) = &self.out {
            write(out, &SplineFile { feed: file.feed, ..SplineFile::of(&smoothed.path) })?;
        }
        if let Some(path) = &self.report {
            std::fs::write(path, serde_json::to_string_pretty(&report)?)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        if let Some(path) = &self.plot {
            let title = format!("{name}, R = {radius} mm, {}", report.method);
            plot_tube(
                path,
                &TubeScene {
                    title: &title,
                    given: &given,
                    smooth: &[("smoothed".to_owned(), &smoothed.path)],
                    radius,
                    trajectory: &trajectory,
                    reading: self.reading,
                },
            )?;
        }
        Ok(())
    }

    fn check_files(&self) -> Result<()> {
        let (out, plot) = (named("--out", self.out.as_ref()), named("--plot", self.plot.as_ref()));
        files::check_ending(out, &["json", "toml", "txt"])?;
        files::check_ending(plot, &["html", "svg", "png"])?;
        let report = named("--report", self.report.as_ref());
        files::check(&[Some(("the spline", &self.file))], &[out, report, plot])
    }

    fn report(
        &self,
        given: &Path,
        smoothed: &Smoothed,
        radius: f64,
        trajectory: &Trajectory<f64>,
    ) -> Report {
        let off = smoothed.path.difference(given);
        Report {
            method: format!("{:?}", self.method).to_lowercase(),
            radius_mm: radius,
            iterations: smoothed.iterations,
            ending: smoothed.ending.clone(),
            calculation_s: smoothed.took.as_secs_f64(),
            deviation_mm: off.as_ref().map_or(0.0, |off| off.greatest(200)),
            deviation_bound_mm: off.as_ref().map_or(0.0, |off| off.bound(200)),
            before: side(given, trajectory, self.reading),
            after: side(&smoothed.path, trajectory, self.reading),
        }
    }
}

fn print(report: &Report) {
    let (before, after) = (&report.before.figures, &report.after.figures);
    println!("{:<28} {:>12} {:>12} {:>10}", "", "given", "smoothed", "change, %");
    for (name, from, to) in [
        ("length, mm", before.length_mm, after.length_mm),
        ("curvature, average, 1/mm", before.curvature_average, after.curvature_average),
        ("curvature, by length, 1/mm", before.curvature_by_length, after.curvature_by_length),
        ("curvature, peak, 1/mm", before.curvature_peak, after.curvature_peak),
        ("feed, average, mm/s", before.feed_average, after.feed_average),
        ("machining time (4.5), s", before.time_s, after.time_s),
    ] {
        let change = if from == 0.0 { 0.0 } else { (to - from) / from * 100.0 };
        println!("{name:<28} {from:>12.5} {to:>12.5} {change:>+10.2}");
    }
    println!(
        "deviation {:.6} mm (bound {:.6}) in a tube of {} mm; {} iterations, {}; {:.3} ms",
        report.deviation_mm,
        report.deviation_bound_mm,
        report.radius_mm,
        report.iterations,
        report.ending,
        report.calculation_s * 1e3
    );
}
