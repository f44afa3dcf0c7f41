//! The figures that the paper prints, beside what its routines give here and what the core makes of them.

use super::cases::{Case, case};
use super::measure::{Measured, dense_cells, measure};
use super::routines::{Rule, Transition, transitions};
use anyhow::{Context, Result};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use splineway_simulator::machine::Mode;

/// A figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// What it is, with its unit behind the last comma, if it has one.
    pub name: String,
    /// As the paper has it, if it prints it.
    pub printed: Option<f64>,
    /// By its routines, worked out here.
    pub routines: Option<f64>,
    /// Measured of the core's setpoints in paper mode.
    pub paper: Option<f64>,
    /// The same in the core's own mode.
    pub own: Option<f64>,
}

impl Serialize for Figure {
    /// With name and unit apart; `1` is the unit of a ratio or a count.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (name, unit) = self.name.rsplit_once(", ").unwrap_or((&self.name, "1"));
        let mut out = serializer.serialize_struct("Figure", 6)?;
        out.serialize_field("name", name.trim())?;
        out.serialize_field("unit", unit)?;
        out.serialize_field("printed", &self.printed)?;
        out.serialize_field("routines", &self.routines)?;
        out.serialize_field("paper", &self.paper)?;
        out.serialize_field("own", &self.own)?;
        out.end()
    }
}

impl Figure {
    fn new(name: &str, values: [Option<f64>; 4]) -> Self {
        let [printed, routines, paper, own] = values;
        Self { name: name.to_owned(), printed, routines, paper, own }
    }
}

/// A part of the paper with its figures.
#[derive(Clone, Debug, Serialize)]
pub struct Section {
    /// Number and subject.
    pub title: String,
    /// Its figures.
    pub figures: Vec<Figure>,
}

/// A path of section 4 as printed, and through the core.
#[derive(Clone, Debug)]
pub struct Run {
    /// The path.
    pub case: Case,
    /// Its transitions as printed.
    pub transitions: Vec<Transition>,
    /// The core's paper mode, and its own.
    pub measured: [Measured; 2],
}

impl Run {
    /// Of one of the cases.
    ///
    /// # Errors
    /// There is no such case, or the core refuses it.
    pub fn new(name: &str) -> Result<Self> {
        let case = case(name).with_context(|| format!("there is no path {name}"))?;
        let transitions = transitions(&case.points, case.delta, case.lambda);
        let measured =
            [measure(&case, Mode::Paper, &transitions)?, measure(&case, Mode::Band, &transitions)?];
        Ok(Self { case, transitions, measured })
    }

    fn both(&self, value: impl Fn(&Measured) -> f64) -> [Option<f64>; 2] {
        let [paper, own] = &self.measured;
        [Some(value(paper)), Some(value(own))]
    }

    fn lines(&self) -> f64 {
        (self.case.points.len() - 1) as f64
    }
}

/// Section 3.3: theta 35 degrees, delta 0.01, L 0.0479.
fn worked_example(run: &Run) -> Section {
    let made = run.transitions[0];
    let (first, corner) = (made.first_edge, made.controls[2]);
    let [e, own] = run.both(|m| m.nearest(&corner));
    // Of a measured e.
    let edge = e.map(|e| 2.0 * e / made.theta.cos());
    let figures = vec![
        Figure::new("epsilon, mm", [Some(0.0173), Some(made.epsilon), None, None]),
        Figure::new("e0, mm", [Some(0.0195), Some(made.first_e), None, None]),
        Figure::new(
            "alpha",
            [Some(0.256), Some(made.edge() / first), edge.map(|edge| edge / first), None],
        ),
        Figure::new("L*, mm", [Some(0.0123), Some(made.edge()), edge, None]),
        Figure::new("e*, mm", [Some(0.005), Some(made.e()), e, own]),
    ];
    Section { title: "3.3 worked example".to_owned(), figures }
}

/// Figures of a path of section 4, of which the paper says how many transitions it has.
fn path(title: &str, run: &Run, printed: Option<f64>) -> Section {
    let made = &run.transitions;
    let count = |rule| Some(made.iter().filter(|t| t.rule == rule).count() as f64);
    let most = |value: fn(&Transition) -> f64| Some(made.iter().map(value).fold(0.0, f64::max));
    // Where the curve meets a leg, on which the curvature is none.
    let jump = |t: &Transition| t.curvature(0.0).max(t.curvature(1.0));
    let row = |name: &str, routines: Option<f64>, [paper, own]: [Option<f64>; 2]| {
        Figure::new(name, [None, routines, paper, own])
    };
    let figures = vec![
        Figure::new("transitions", [printed, Some(made.len() as f64), None, None]),
        row("  scaled to e*", count(Rule::Scaled), [None; 2]),
        row("  as they are", count(Rule::Whole), [None; 2]),
        row("  halved", count(Rule::Halved), [None; 2]),
        row("greatest deviation, mm", most(Transition::deviation), run.both(|m| m.deviation)),
        row("off the printed path, mm", None, [Some(run.measured[0].off_printed), None]),
        row(
            "greatest curvature, 1/mm",
            most(Transition::apex_curvature),
            run.both(|m| m.curvature),
        ),
        row("time, s", None, run.both(|m| m.time)),
    ];
    let mut section = Section { title: title.to_owned(), figures };
    section.figures.push(row(
        "worst jump of curvature, 1/mm",
        most(jump),
        run.both(Measured::jump),
    ));
    section
}

/// Bytes of a point in space in `f32`.
const POINT: f64 = 12.0;

/// The paper's own list of what is left to do (section 5).
fn open_list(run: &Run) -> Result<Section> {
    let lines = run.lines();
    let made = run.transitions.len() as f64;
    let both = |value: fn(&Measured) -> f64| run.both(value);
    let [dense_lines, dense] = dense_cells()?;
    let row = |name: &str, routines: Option<f64>, [paper, own]: [Option<f64>; 2]| {
        Figure::new(name, [None, routines, paper, own])
    };
    let cells = |m: &Measured| f64::from(m.cells);
    let figures = vec![
        row("cost: planning on this PC, us per line", None, both(|m| m.planning / 1000.0)),
        // Of the method as printed, five points for every corner, and both spans and a line.
        row(
            "data: bytes stored per line",
            Some((lines * POINT + made * 5.0 * POINT) / lines),
            [Some(POINT), Some(POINT)],
        ),
        row(
            "data: spans or cells per line",
            Some((2.0 * made + lines) / lines),
            run.both(|m| cells(m) / lines),
        ),
        row(
            &format!("  the same of the curve in {dense_lines} lines"),
            Some((3.0 * dense_lines - 2.0) / dense_lines),
            [None, Some(dense / dense_lines)],
        ),
        row(
            "continuity: worst jump over greatest curvature",
            None,
            both(|m| m.jump() / m.curvature),
        ),
    ];
    Ok(Section { title: "5 what the paper leaves open, on the butterfly".to_owned(), figures })
}

/// Everything that `splineway paper` prints.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Figures by section.
    pub sections: Vec<Section>,
    /// Section 4.1.
    pub butterfly: Run,
    /// Section 4.2.
    pub hexagon: Run,
}

impl Comparison {
    /// Works it out: some seconds.
    ///
    /// # Errors
    /// The core refuses a path.
    pub fn new() -> Result<Self> {
        let example = Run::new("section_3_3")?;
        let (butterfly, hexagon) = (Run::new("butterfly80")?, Run::new("hexagon_3d")?);
        let sections = vec![
            worked_example(&example),
            path("4.1 butterfly in 80 lines, delta .05 mm", &butterfly, None),
            path("4.2 closed hexagon in space, delta .05 mm (a stand-in)", &hexagon, Some(5.0)),
            open_list(&butterfly)?,
        ];
        Ok(Self { sections, butterfly, hexagon })
    }

    /// Of the figures that are printed, how many there are, and how many come within 2, 10 and 25 per cent.
    pub fn within(&self, value: fn(&Figure) -> Option<f64>) -> [usize; 4] {
        let all = self.sections.iter().flat_map(|section| &section.figures);
        let errors: Vec<f64> =
            all.filter_map(|figure| Some((value(figure)? / figure.printed? - 1.0).abs())).collect();
        [f64::INFINITY, 0.02, 0.1, 0.25].map(|most| errors.iter().filter(|e| **e <= most).count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is printed comes out, by the routines and of the core; both modes keep the band and every limit.
    #[test]
    fn what_is_printed_comes_out() {
        let all = Comparison::new().unwrap();
        assert_eq!(all.within(|figure| figure.routines), [6; 4]);
        assert_eq!(all.within(|figure| figure.paper), [3; 4]);
        for run in [&all.butterfly, &all.hexagon] {
            for measured in &run.measured {
                assert!(measured.broken.is_empty(), "{}: {:?}", run.case.name, measured.broken);
                assert!(measured.jump() < 0.02 * measured.curvature, "{}", run.case.name);
            }
        }
    }
}
