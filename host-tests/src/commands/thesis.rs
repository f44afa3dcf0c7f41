//! `splineway thesis`: the tables and figures of Naseath 2007 beside this program's.

use super::files::make_folder;
use crate::view::{Busy, Drawn, Panel, TubeScene, plot_panels, plot_tube};
use anyhow::Result;
use clap::ValueEnum;
use splineway_splines::Trajectory;
use splineway_studies::smoothing::cases::{Family, RADII, ripple_peaks};
use splineway_studies::smoothing::comparison::{Comparison, MEASURES, saved};
use splineway_studies::smoothing::printed::{CORRELATIONS, NAMES};
use splineway_studies::smoothing::{Method, Reading, Request, measure, records, smooth, tables};
use std::path::{Path, PathBuf};

/// What a plateau of the speed is when section 4.5 is read word by word.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Plateau {
    /// One extreme, in its middle.
    Middle,
    /// Two, its edges.
    Edges,
}

/// Smooths the cases of Naseath 2007 (equivalents) and the ripples of its section 3.12 as printed and in bounded
/// sweeps, prints tables 4-1 to 4-7 beside the printed ones, and counts the figures that come out
#[derive(Debug, clap::Args)]
pub struct Thesis {
    /// What a plateau of the speed is when section 4.5 is read word by word
    #[arg(long, value_enum, default_value = "edges")]
    plateau: Plateau,
    /// Writes figures 3-26, 3-27 and 4-8 to 4-31 into this folder [default: not written]
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
    /// Print the figures of every case as JSON
    #[arg(long)]
    json: bool,
}

impl Thesis {
    /// # Errors
    /// If a figure cannot be written.
    pub fn execute(&self) -> Result<()> {
        let literal = match self.plateau {
            Plateau::Middle => Reading::Middle,
            Plateau::Edges => Reading::Edges,
        };
        if let Some(folder) = &self.plots {
            make_folder(("--plots", folder))?;
        }
        let busy = Busy::new("smoothing the cases", false);
        let comparison = Comparison::new([Reading::Free, literal])?;
        let text = if self.json {
            serde_json::to_string_pretty(&records(&comparison))?
        } else {
            tables(&comparison)?
        };
        drop(busy);
        println!("{}", text.trim_end());
        let Some(folder) = &self.plots else { return Ok(()) };
        let _busy = Busy::new("drawing", false);
        plot_cases(folder, &comparison, literal)?;
        plot_correlations(folder, &comparison)?;
        plot_ripples(folder)
    }
}

/// Figures 4-8 to 4-27, a file per case: the path in the tube of the greatest radius, curvature along
/// the way and feed over time at all radii.
fn plot_cases(folder: &Path, comparison: &Comparison, reading: Reading) -> Result<()> {
    for case in &comparison.cases {
        let smoothed: Vec<_> = case
            .runs
            .iter()
            .zip(RADII)
            .map(|(runs, radius)| (format!("R = {radius} mm"), &runs[0].smoothed.path))
            .collect();
        let number = case.case.number;
        plot_tube(
            &folder.join(format!("case{number}.svg")),
            &TubeScene {
                title: &format!("Case {number}: {}", case.case.name),
                given: &case.case.path,
                smooth: &smoothed,
                radius: RADII[2],
                trajectory: &Trajectory::thesis(),
                reading,
            },
        )?;
    }
    Ok(())
}

/// Figures 4-28 to 4-31.
fn plot_correlations(folder: &Path, comparison: &Comparison) -> Result<()> {
    let mut figures: Vec<(&str, Panel)> = Vec::new();
    for printed in CORRELATIONS {
        let Some(number) = printed.figure else { continue };
        let [a, b] = printed.pair;
        let flat = |rows: Vec<[f64; 3]>| rows.as_flattened().to_vec();
        let series = [("printed", None), ("free", Some(0)), ("word by word", Some(1))];
        let series = series.map(|(name, reading)| {
            let of = |k: usize| match reading {
                Some(reading) => flat(comparison.improvements(&MEASURES[k], 0, reading)),
                None => flat(MEASURES[k].table.improvement.to_vec()),
            };
            (name.to_owned(), of(a).into_iter().zip(of(b)).collect())
        });
        let title = format!("figure {number}: improvements, per cent");
        let axes = [NAMES[a], NAMES[b]];
        let panel = Panel {
            title,
            axes,
            logarithmic: false,
            drawn: Drawn::Points,
            series: series.to_vec(),
        };
        figures.push((number, panel));
    }
    figures.sort_by_key(|(number, _)| *number);
    let panels: Vec<Panel> = figures.into_iter().map(|(_, panel)| panel).collect();
    plot_panels(&folder.join("correlations.svg"), "Naseath 2007, table 4-7", &panels)
}

/// Figures 3-26 and 3-27, for both families of ripples.
fn plot_ripples(folder: &Path) -> Result<()> {
    let (trajectory, reading) = (Trajectory::thesis(), Reading::Free);
    let mut panels = Vec::new();
    for (family, what) in [(Family::OneHeight, "one height"), (Family::OneShape, "one shape")] {
        let mut series = [Vec::new(), Vec::new()];
        for radius in RADII {
            let mut points = [Vec::new(), Vec::new()];
            for peak in ripple_peaks() {
                let path = family.ripple(peak)?;
                let given = measure(&path, &trajectory, reading);
                let smoothed = smooth(&path, &Request::new(Method::Thesis, radius))?;
                let figures = measure(&smoothed.path, &trajectory, reading);
                points[0].push((peak, saved(given.curvature_peak, figures.curvature_peak)));
                points[1].push((peak, saved(given.time_s, figures.time_s)));
            }
            for (series, points) in series.iter_mut().zip(points) {
                series.push((format!("R = {radius} mm"), points));
            }
        }
        let figures = [("3-26", "curvature saved, %"), ("3-27", "time saved, %")];
        for (series, (number, up)) in series.into_iter().zip(figures) {
            let title = format!("figure {number}, ripples of {what}");
            let axes = ["peak of curvature as given, 1/mm", up];
            panels.push(Panel { title, axes, logarithmic: true, drawn: Drawn::Joined, series });
        }
    }
    plot_panels(&folder.join("ripples.svg"), "Naseath 2007, section 3.12", &panels)
}
