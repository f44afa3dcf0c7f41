//! A program before it is run, by the core's own checks.

use super::runner::block;
use crate::letters::lettered;
use crate::machine::{Machine, Mode};
use crate::program::{AXES, Course, Finding, Tape};
use anyhow::Result;
use splineway::block::BlockError;
use splineway::{Config, Coord, CornerMode, RangeError};

/// What the core says about a block, with the letters of the axes instead of their numbers.
pub fn on_letters(error: &BlockError, axes: &[usize]) -> String {
    let text = match *error {
        BlockError::Coordinate { axis, error } => {
            let value = error.value;
            format!("axis {axis} would go to {value} mm; coordinates must be within +-1e6")
        }
        ref other => other.to_string(),
    };
    lettered(&text, axes)
}

/// What the core has against a program on a machine: radii, feeds, tolerances, ranges, lengths, and axes without
/// limits. All of it, in the order of the moves; nothing is planned, so it takes a fraction of a second for a
/// million moves.
pub fn validate(program: &dyn Tape, machine: &Machine) -> Vec<Finding> {
    let axes = program.axes();
    let config: Config<f64, AXES> = match machine.config(&axes) {
        Ok(config) => config,
        Err(error) => return vec![Finding::error(0, format!("{error:#}"))],
    };
    let coords = |point: &[f64; AXES]| -> Result<_, RangeError> {
        let mut place = [Coord::ZERO; AXES];
        for (slot, &axis) in place.iter_mut().zip(&axes) {
            *slot = Coord::from_mm(point[axis])?;
        }
        Ok(place)
    };
    let mut findings = Vec::new();
    // Where a place is out of range, what follows is checked from the last one that was not.
    let mut here = coords(&program.start()).unwrap_or_else(|error| {
        findings.push(Finding::error(0, format!("the start, mm: {error}")));
        [Coord::ZERO; AXES]
    });
    for step in program.steps() {
        let complaint = match block::<f64, AXES>(&step, &axes) {
            Ok(block) => block.check(&here, &config).err().map(|error| on_letters(&error, &axes)),
            Err(error) => Some(format!("{error:#}")),
        };
        if let Some(message) = complaint {
            // A line may be many blocks: a curve, a cycle.
            let found = Finding::error(step.line, message);
            if findings.last() != Some(&found) {
                findings.push(found);
            }
        }
        match &step.path {
            Course::Line { to } | Course::Arc { to, .. } | Course::Cubic { to, .. } => {
                here = coords(to).unwrap_or(here);
            }
            Course::Dwell { .. } | Course::Event { .. } => {}
        }
    }
    findings
}

/// What of the paper's mode a program does not get: corners of lines that are too sharp for a transition. `None` if there
/// are none, or in the other mode.
pub fn sharp_corners(program: &dyn Tape, machine: &Machine) -> Option<String> {
    if machine.mode != Mode::Paper {
        return None;
    }
    let axes = program.axes();
    let (mut before, mut here) = (None, program.start());
    let (mut count, mut first) = (0, 0);
    for step in program.steps() {
        let (Course::Line { to } | Course::Arc { to, .. } | Course::Cubic { to, .. }) = &step.path
        else {
            before = None;
            continue;
        };
        let way: Vec<f64> = axes.iter().map(|&axis| to[axis] - here[axis]).collect();
        here = *to;
        if !matches!(step.path, Course::Line { .. }) {
            before = None;
            continue;
        }
        let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 {
            let tangent: Vec<f64> = way.iter().map(|x| x / length).collect();
            let cosine = |a: &Vec<f64>| a.iter().zip(&tangent).map(|(a, b)| a * b).sum::<f64>();
            if before.as_ref().is_some_and(|a| cosine(a) < CornerMode::<f64>::STOP_COSINE) {
                first = if count == 0 { step.line } else { first };
                count += 1;
            }
            before = Some(tangent);
        }
        if step.exact_stop {
            before = None;
        }
    }
    (count > 0).then(|| {
        format!(
            "{count} corners turn by more than 160 degrees, the first before line {first}: exact stops, where the paper has transitions"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Move, Program, Speed, refuse};

    /// A spike of 170 degrees is an exact stop, and that is said in the paper's mode only.
    #[test]
    fn corners_too_sharp_for_the_paper_are_named() {
        let turn = 170.0f64.to_radians();
        let spike = program(&[
            Course::Line { to: point(10.0, 0.0) },
            Course::Line { to: point(10.0 + 10.0 * turn.cos(), 10.0 * turn.sin()) },
            Course::Line { to: point(0.0, 20.0) },
        ]);
        let mut machine = Machine::default();
        assert_eq!(sharp_corners(&spike, &machine), None);
        machine.mode = Mode::Paper;
        let words = sharp_corners(&spike, &machine).unwrap();
        assert!(words.starts_with("1 corners") && words.contains("line 2"), "{words}");
    }

    fn program(paths: &[Course]) -> Program {
        let step = |(n, path): (usize, &Course)| {
            Move::new(path.clone(), Speed::PerSecond(10.0), n as u32 + 1)
        };
        Program { moves: paths.iter().enumerate().map(step).collect(), ..Program::default() }
    }

    fn point(x: f64, y: f64) -> [f64; AXES] {
        let mut point = [0.0; AXES];
        (point[0], point[1]) = (x, y);
        point
    }

    #[test]
    fn every_complaint_of_the_core_is_listed() {
        let arc = Course::Arc {
            to: point(2.0, 0.0),
            plane: (0, 1),
            centre: (1.0, 0.5),
            clockwise: true,
            extra_turns: 0,
        };
        let mut program = program(&[
            Course::Line { to: point(1.0, 0.0) },
            arc,
            Course::Dwell { seconds: -1.0 },
            Course::Line { to: point(2.0e6, 0.0) },
            Course::Line { to: point(3.0, 0.0) },
        ]);
        program.moves[4].speed = Speed::PerSecond(1.0e7);
        let findings = validate(&program, &Machine::default());
        let lines: Vec<u32> = findings.iter().map(|finding| finding.line).collect();
        assert_eq!(lines, [2, 3, 4, 5], "{findings:?}");
        let error = refuse(&findings).unwrap_err().to_string();
        assert!(error.starts_with("4 places are refused:\n  line 2: arc starts"), "{error}");
        assert!(refuse(&validate(&Program::default(), &Machine::default())).is_ok());
    }
}
