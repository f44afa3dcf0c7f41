//! What is found in a program before it is run.

use super::{AXES, Course, Program, on_letters};
use crate::machine::Machine;
use crate::run::block;
use anyhow::{Result, bail};
use serde::Serialize;
use splineway::{Config, Coord, RangeError};
use std::fmt;

/// How much a finding weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The program can be run; where the tool goes is not touched by it.
    Warning,
    /// The program is refused.
    Error,
}

/// Something that was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Line of the file, from 1; 0 if it is about the whole.
    pub line: u32,
    /// Column in it, from 1, if one is to blame.
    pub column: Option<u32>,
    /// Its weight.
    pub severity: Severity,
    /// What it is, with the code, the value and the limit.
    pub message: String,
}

impl Finding {
    /// An error in a line.
    pub fn error(line: u32, message: impl Into<String>) -> Self {
        Self { line, column: None, severity: Severity::Error, message: message.into() }
    }

    /// A warning about a line.
    pub fn warning(line: u32, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(line, message) }
    }

    /// Whether it refuses the program.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Finding {
    /// `line 3, column 7: ...`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, self.column) {
            (0, _) => {}
            (line, None) => write!(f, "line {line}: ")?,
            (line, Some(column)) => write!(f, "line {line}, column {column}: ")?,
        }
        f.write_str(&self.message)
    }
}

/// So many findings are printed; of the others, how many there are.
pub const SHOWN: usize = 20;

/// The errors among findings as one, with the first [`SHOWN`] of them, one a line.
///
/// # Errors
/// If there are any.
pub fn refuse(findings: &[Finding]) -> Result<()> {
    let errors: Vec<&Finding> = findings.iter().filter(|finding| finding.is_error()).collect();
    let Some(first) = errors.first() else { return Ok(()) };
    if errors.len() == 1 {
        bail!("{first}");
    }
    let shown: Vec<String> =
        errors.iter().take(SHOWN).map(|finding| format!("\n  {finding}")).collect();
    let more = match errors.len() - shown.len() {
        0 => String::new(),
        more => format!("\n  and {more} more"),
    };
    bail!("{} places are refused:{}{more}", errors.len(), shown.concat())
}

/// What the core has against a program on a machine: radii, feeds, tolerances, ranges, lengths, and axes without
/// limits. All of it, in the order of the moves; nothing is planned, so it takes a fraction of a second for a
/// million moves.
pub fn validate(program: &Program, machine: &Machine) -> Vec<Finding> {
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
    let mut here = coords(&program.start).unwrap_or_else(|error| {
        findings.push(Finding::error(0, format!("the start, mm: {error}")));
        [Coord::ZERO; AXES]
    });
    for step in &program.moves {
        let complaint = match block::<f64, AXES>(step, &axes) {
            Ok(block) => block.check(&here, &config).err().map(|error| on_letters(&error, &axes)),
            Err(error) => Some(format!("{error:#}")),
        };
        if let Some(message) = complaint {
            findings.push(Finding::error(step.line, message));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Move, Speed};

    fn program(paths: &[Course]) -> Program {
        let step = |(n, path): (usize, &Course)| Move {
            path: path.clone(),
            speed: Speed::PerSecond(10.0),
            tolerance: None,
            exact_stop: false,
            line: n as u32 + 1,
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

    #[test]
    fn a_long_list_is_cut() {
        let findings: Vec<Finding> = (1..=30).map(|line| Finding::error(line, "no")).collect();
        let text = refuse(&findings).unwrap_err().to_string();
        assert_eq!(text.lines().count(), SHOWN + 2);
        assert!(text.ends_with("and 10 more"));
    }
}
