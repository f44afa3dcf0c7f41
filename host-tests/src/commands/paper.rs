//! `splineway paper`: the figures of Guo, Yan, Wang 2023 beside this program's.

use super::files::make_folder;
use crate::view::{Busy, Drawn, Panel, Series, plot_panels};
use anyhow::Result;
use splineway_studies::paper::printed::{Comparison, Figure, Run};
use splineway_studies::paper::routines::Point;
use std::path::PathBuf;

/// Works out the routines of Guo, Yan, Wang 2023 as printed, runs the paths of the paper through the core in paper mode and in
/// its own, and prints the figures side by side, with those of the paper's list of further work
#[derive(Clone, Debug, clap::Args)]
pub struct Paper {
    /// Writes pictures into this folder: the curvature profiles of figure 13b, and corners as in figure 12b (SVG) [default: not
    /// written]
    #[arg(long, value_name = "FOLDER")]
    pub plots: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl Paper {
    /// Runs the command.
    ///
    /// # Errors
    /// The core refuses a path, or a picture cannot be written.
    pub fn execute(&self) -> Result<()> {
        if let Some(folder) = &self.plots {
            make_folder(("--plots", folder))?;
        }
        let busy = Busy::new("running the paths of the paper", false);
        let all = Comparison::new()?;
        drop(busy);
        if self.json {
            println!("{}", serde_json::to_string_pretty(&all.sections)?);
        } else {
            print(&all);
        }
        if let Some(folder) = &self.plots {
            let title = "closed hexagon in space: curvature (figure 13b)";
            plot_panels(&folder.join("hexagon-curvature.svg"), title, &profiles(&all.hexagon))?;
            let title = "butterfly in 80 lines (figure 12b)";
            plot_panels(&folder.join("butterfly-corners.svg"), title, &corners(&all.butterfly))?;
        }
        Ok(())
    }
}

/// Four digits and more, as short as they come.
fn number(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(x) if x.abs() >= 100.0 || x.fract() == 0.0 => format!("{x:.0}"),
        Some(x) if x.abs() >= 1.0 => format!("{x:.3}"),
        Some(x) if x.abs() < 1.0e-4 => format!("{x:.1e}"),
        Some(x) => format!("{x:.5}"),
    }
}

fn print(all: &Comparison) {
    for section in &all.sections {
        println!(
            "{:<56} {:>9} {:>16} {:>12} {:>10}",
            section.title, "printed", "as printed here", "paper mode", "own mode"
        );
        for Figure { name, printed, routines, paper, own } in &section.figures {
            let [printed, routines, paper, own] =
                [printed, routines, paper, own].map(|x| number(*x));
            println!("  {name:<54} {printed:>9} {routines:>16} {paper:>12} {own:>10}");
        }
        println!();
    }
    println!(
        "Control points of the hexagon's transitions, P0 to P4, mm; curvature at the apex, 1/mm"
    );
    for (n, transition) in all.hexagon.transitions.iter().enumerate() {
        let point = |p: &Point| format!("({:.4}, {:.4}, {:.4})", p[0], p[1], p[2]);
        let points: Vec<String> = transition.controls.iter().map(point).collect();
        println!("  C{n}  {}  {:.3}", points.join(" "), transition.apex_curvature());
    }
    println!();
    let counted = |value: fn(&Figure) -> Option<f64>| {
        let [count, two, ten, more] = all.within(value);
        format!("of {count} within 2 %: {two}, 10 %: {ten}, 25 %: {more}")
    };
    println!(
        "printed figures, as printed here: {}; measured in paper mode: {}",
        counted(|figure| figure.routines),
        counted(|figure| figure.paper)
    );
}

/// Figure 13b: the five transitions as printed, and the curvature along the whole path in both modes.
fn profiles(run: &Run) -> Vec<Panel> {
    const STEPS: u32 = 400;
    let curve = |n: usize| {
        let at = |k: u32| f64::from(k) / f64::from(STEPS);
        (0..=STEPS).map(|k| (at(k), run.transitions[n].curvature(at(k)))).collect()
    };
    let printed = (0..run.transitions.len()).map(|n| (format!("C{n}"), curve(n))).collect();
    let mut panels = vec![Panel {
        title: "transitions as printed".to_owned(),
        axes: ["parameter u", "curvature, 1/mm"],
        logarithmic: false,
        drawn: Drawn::Curve,
        series: printed,
    }];
    for (name, measured) in ["paper mode", "own mode"].iter().zip(&run.measured) {
        panels.push(Panel {
            title: format!("{name}: {:.3} s", measured.time),
            axes: ["way, mm", "curvature, 1/mm"],
            logarithmic: false,
            drawn: Drawn::Curve,
            series: vec![((*name).to_owned(), measured.profile.clone())],
        });
    }
    panels
}

/// Figure 12b: corners close to, one of every rule.
fn corners(run: &Run) -> Vec<Panel> {
    let mut rules = Vec::new();
    let mut panels = Vec::new();
    for (n, transition) in run.transitions.iter().enumerate() {
        if rules.contains(&transition.rule) {
            continue;
        }
        rules.push(transition.rule);
        let corner = transition.controls[2];
        let reach = transition.edge() * 2.2;
        let flat = |p: &Point| (p[0], p[1]);
        let off = |p: &Point| (p[0] - corner[0]).hypot(p[1] - corner[1]);
        let control = transition.controls.iter().map(flat).collect();
        let mut curves: Vec<Series> = vec![("control polygon as printed".to_owned(), control)];
        for (name, measured) in ["paper mode", "own mode"].iter().zip(&run.measured) {
            // The one stretch of the path that passes the corner.
            let places = &measured.places;
            let by_distance = |a: &&Point, b: &&Point| off(a).total_cmp(&off(b));
            let nearest = places.iter().min_by(by_distance).map(off);
            let passes = places.iter().position(|p| Some(off(p)) == nearest).unwrap_or(0);
            let (before, after) = places.split_at(passes);
            let near = |p: &&Point| off(p) < reach;
            let mut stretch: Vec<_> = before.iter().rev().take_while(near).map(flat).collect();
            stretch.reverse();
            stretch.extend(after.iter().take_while(near).map(flat));
            curves.push(((*name).to_owned(), stretch));
        }
        panels.push(Panel {
            title: format!("corner {}: {:?}", n + 1, transition.rule),
            axes: ["x, mm", "y, mm"],
            logarithmic: false,
            drawn: Drawn::Path,
            series: curves,
        });
    }
    panels
}
