//! Showing a run: plots, tables, progress. Nothing is judged here.

pub mod page;
mod panels;
mod picture;
mod progress;
pub mod table;
mod tube;

pub use panels::{Drawn, Panel, Series};
pub use progress::{Busy, Progress, bar};
pub use tube::TubeScene;

use anyhow::{Context, Result, anyhow, bail};
use splineway_simulator::judge::Track;
use splineway_simulator::record::Trace;
use std::path::Path;

/// What a plot shows.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// Title.
    pub title: &'a str,
    /// Programmed path.
    pub track: &'a Track,
    /// Tolerance, mm.
    pub tolerance: f64,
    /// Letters of the axes in use.
    pub letters: &'a [char],
    /// Their limits.
    pub limits: &'a [splineway_simulator::machine::Axis],
    /// What was run.
    pub trace: &'a Trace,
}

/// Speed over the way of one run.
#[derive(Clone, Debug)]
pub struct Curve {
    /// What it shows.
    pub name: String,
    /// Way in mm and speed in mm/s.
    pub points: Vec<(f64, f64)>,
}

/// Writes a picture of a run; the kind is told by the file's ending. (A page of a run is a [`page::Page`].)
///
/// # Errors
/// An unknown ending, or a file that cannot be written.
pub fn plot(path: &Path, scene: &Scene<'_>) -> Result<()> {
    write(path, || picture::svg(scene), bare_page)
}

/// Writes a plot of speeds over the way, one below the other.
///
/// # Errors
/// An unknown ending, or a file that cannot be written.
pub fn plot_speeds(path: &Path, title: &str, curves: &[Curve]) -> Result<()> {
    write(path, || picture::speeds_svg(title, curves), bare_page)
}

/// Writes a plot of a smoothed path in its tube.
///
/// # Errors
/// An unknown ending, or a file that cannot be written.
pub fn plot_tube(path: &Path, scene: &TubeScene<'_>) -> Result<()> {
    let svg = || {
        let mut text = String::new();
        tube::draw(&mut text, scene).map_err(|error| anyhow!("plot: {error}"))?;
        Ok(text)
    };
    write(path, svg, bare_page)
}

/// Writes panels of points or lines, two in a row.
///
/// # Errors
/// An unknown ending, or a file that cannot be written.
pub fn plot_panels(path: &Path, title: &str, panels: &[Panel]) -> Result<()> {
    let svg = || {
        let mut text = String::new();
        panels::draw(&mut text, title, panels).map_err(|error| anyhow!("plot: {error}"))?;
        Ok(text)
    };
    write(path, svg, bare_page)
}

/// A page that shows a picture and nothing else.
#[allow(clippy::unnecessary_wraps)] // as other pages
fn bare_page(svg: &str) -> Result<String> {
    Ok(format!("<!doctype html><meta charset=\"utf-8\">{svg}"))
}

fn write(
    path: &Path,
    svg: impl FnOnce() -> Result<String>,
    page: impl FnOnce(&str) -> Result<String>,
) -> Result<()> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("");
    let bytes = match ending {
        "html" => page(&svg()?)?.into_bytes(),
        "svg" => svg()?.into_bytes(),
        "png" => picture::png(&svg()?)?,
        _ => bail!("{}: plots are .svg, .png or .html", path.display()),
    };
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
