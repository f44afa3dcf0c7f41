//! `splineway smooth`: lowers the curvature of a spline file inside a tube.

use super::files::{self, named};
use super::numbers::positive;
use crate::view::{Busy, TubeScene, plot_tube};
use anyhow::{Context, Result, bail};
use serde::Serialize;
use splineway_simulator::input::{self, is_stdin};
use splineway_simulator::program::Kind;
use splineway_simulator::spline::{Path, SplineFile, write};
use splineway_splines::Trajectory;
use splineway_studies::smoothing::{
    Figures, Method, Reading, Request, Smoothed, measure, profile, run, smooth,
};
use std::path::{Path as FilePath, PathBuf};

/// Feed of splines that name none, mm/s.
const FEED: f64 = 400.0;
/// Greatest number of places of a profile in the report.
const PROFILE: usize = 2000;

/// Smooths a B-spline tool path inside the tolerance tube around it, and reports curvature, length, feed
/// and machining time before and after
#[derive(Debug, clap::Args)]
pub struct Smooth {
    /// Spline file: .json, .toml or .txt (control points, knots, tolerance, precision, accuracy); "-" is standard input
    file: PathBuf,
    /// Radius of the tube, mm [default: the file's]
    #[arg(long, value_name = "MM")]
    tolerance: Option<f64>,
    /// Places per knot interval at which the thesis's method takes distances [default: the file's, or 5]
    #[arg(long, value_name = "COUNT")]
    precision: Option<u32>,
    /// Share of the radius within which the thesis's method ends [default: the file's, or 0.01]
    #[arg(long, value_name = "SHARE")]
    accuracy: Option<f64>,
    /// Most iterations of the thesis's method, or sweeps per pass of the bounded one [default: 1000 iterations, 16 sweeps]
    #[arg(long, value_name = "COUNT")]
    iterations: Option<u32>,
    /// The spline is closed: the knots are its intervals
    #[arg(long)]
    closed: bool,
    /// How to smooth
    #[arg(long, value_enum, default_value = "bounded")]
    method: Method,
    /// Feed of the motion along it, mm/s, in place of what the file says [default: the file's; 400 where it says nothing]
    #[arg(long, value_name = "MM_PER_S", value_parser = positive())]
    feed: Option<f64>,
    /// Its acceleration, mm/s2
    #[arg(long, value_name = "MM_PER_S2", default_value_t = 4000.0, value_parser = positive())]
    acceleration: f64,
    /// Its jerk, mm/s3
    #[arg(long, value_name = "MM_PER_S3", default_value_t = 20_000.0, value_parser = positive())]
    jerk: f64,
    /// How section 4.5 of the thesis is read
    #[arg(long, value_enum, default_value = "free")]
    reading: Reading,
    /// Writes the smoothed spline (.json, .toml or .txt) [default: not written]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Writes figures and profiles (JSON) [default: not written]
    #[arg(long, value_name = "JSON")]
    report: Option<PathBuf>,
    /// Writes a plot (.html, .svg or .png) [default: not written]
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print the figures, without the profiles, as JSON
    #[arg(long)]
    json: bool,
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
    #[serde(rename = "way_mm_curvature_per_mm", skip_serializing_if = "Vec::is_empty")]
    curvature: Vec<[f64; 2]>,
    /// Way, mm, and feed, mm/s.
    #[serde(rename = "way_mm_feed_mm_s", skip_serializing_if = "Vec::is_empty")]
    feed: Vec<[f64; 2]>,
}

/// A spline file; the kind of standard input is told by what is in it.
fn read(path: &FilePath) -> Result<SplineFile> {
    let text = input::text(path)?;
    let guessed = || match Kind::guessed(text.as_bytes()) {
        Kind::Json => "json",
        Kind::Toml => "toml",
        Kind::Text | Kind::Gcode => "txt",
    };
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("");
    let ending = if is_stdin(path) { guessed() } else { ending };
    SplineFile::parse(&text, ending).with_context(|| path.display().to_string())
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
        let busy = Busy::new("smoothing", false);
        file.closed |= self.closed;
        let name = self.file.display();
        let unused = file.unused();
        if !unused.is_empty() {
            eprintln!("warning: {name}: not used: {}", unused.join(", "));
        }
        let given = file.path().with_context(|| name.to_string())?;
        let Some(radius) = self.tolerance.or(file.tolerance) else {
            bail!("{name}: no tolerance in the file; give one with --tolerance");
        };
        let feed = self.feed.or(file.feed).unwrap_or(FEED);
        let trajectory = Trajectory { feed, acceleration: self.acceleration, jerk: self.jerk };
        let mut request = Request::new(self.method, radius);
        request.precision = self.precision.or(file.precision).unwrap_or(request.precision);
        request.accuracy = self.accuracy.or(file.accuracy).unwrap_or(request.accuracy);
        request.iterations = self.iterations;
        request.ends_stay = true;
        let smoothed = smooth(&given, &request)?;
        drop(busy);
        let mut report = self.report(&given, &smoothed, radius, &trajectory);
        if let Some(out) = &self.out {
            write(out, &SplineFile { feed: file.feed, ..SplineFile::of(&smoothed.path) })?;
        }
        if let Some(path) = &self.report {
            std::fs::write(path, serde_json::to_string_pretty(&report)?)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        if self.json {
            for side in [&mut report.before, &mut report.after] {
                (side.curvature, side.feed) = (Vec::new(), Vec::new());
            }
            println!("{}", serde_json::to_string_pretty(&report)?);
        } else {
            print(&report);
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
