//! Tool paths as read from files, before they become blocks of the core.

pub mod arc;
pub mod curve;
mod finding;
pub mod gcode;
pub mod poly;
pub mod rational;

pub use finding::{Finding, SHOWN, Severity, refuse, validate};
pub use splineway::gcode::{Code, Dialect, Setup};

use self::rational::Rational;
use crate::smoothing::{self, SplineFile};
use anyhow::{Context, Result, bail, ensure};
use splineway::block::BlockError;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Letters of the axes in the order of their indices.
pub const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];
/// Most axes.
pub const AXES: usize = LETTERS.len();

/// A point over all nine axes, mm or degrees.
pub type Point = [f64; AXES];

/// What a move does.
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// Straight to a point.
    Line {
        /// End point.
        to: Point,
    },
    /// Circle or helix.
    Arc {
        /// End point.
        to: Point,
        /// Axes of the plane.
        plane: (usize, usize),
        /// Centre in these axes.
        centre: (f64, f64),
        /// G2.
        clockwise: bool,
        /// Full turns beyond the first arrival.
        extra_turns: u16,
    },
    /// Cubic curve by its Bezier points.
    Cubic {
        /// The two points between.
        controls: [Point; 2],
        /// End point.
        to: Point,
    },
    /// Stand still, s.
    Dwell {
        /// Duration.
        seconds: f64,
    },
    /// Something that the machine does at rest, in order with the motion: spindle, coolant, tool, stop.
    Event {
        /// Which.
        code: Code,
        /// Its number (`splineway::gcode::Event` says of which word).
        value: Option<f64>,
        /// Whether the machine waits there for the operator.
        pause: bool,
    },
}

impl Course {
    /// Where it ends; `None` if it goes nowhere.
    pub fn end(&self) -> Option<&Point> {
        match self {
            Self::Line { to } | Self::Arc { to, .. } | Self::Cubic { to, .. } => Some(to),
            Self::Dwell { .. } | Self::Event { .. } => None,
        }
    }
}

/// How fast a move runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// mm/s (or degrees/s).
    PerSecond(f64),
    /// Duration of the move, s.
    Duration(f64),
    /// As fast as the axes can.
    Rapid,
}

/// One move of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Its path.
    pub path: Course,
    /// Its speed.
    pub speed: Speed,
    /// Tolerance, mm, if the program gives one.
    pub tolerance: Option<f64>,
    /// Whether it ends in an exact stop.
    pub exact_stop: bool,
    /// Line of the file, from 1.
    pub line: u32,
}

impl Move {
    /// Whether the machine waits for the operator there.
    pub const fn is_pause(&self) -> bool {
        matches!(self.path, Course::Event { pause: true, .. })
    }
}

/// Limits and settings that a path file brings along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Axis velocity, mm/s.
    pub velocity: f64,
    /// Axis acceleration, mm/s2.
    pub acceleration: f64,
    /// Axis jerk, mm/s3.
    pub jerk: f64,
    /// Tolerance, mm.
    pub tolerance: f64,
    /// Servo cycle, s.
    pub cycle: f64,
}

/// A tool path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// Where the motion starts.
    pub start: Point,
    /// Which axes it uses; X, Y and Z always.
    pub uses: [bool; AXES],
    /// The moves.
    pub moves: Vec<Move>,
    /// What the file says about the machine.
    pub header: Option<Header>,
    /// What was noticed while reading.
    pub warnings: Vec<String>,
    /// Curves that the moves stand for, one for each; empty if the moves are the program themselves.
    pub exact: Vec<Rational>,
}

impl Program {
    /// Where it ends.
    pub fn end(&self) -> Point {
        let mut ends = self.moves.iter().rev().filter_map(|step| step.path.end());
        *ends.next().unwrap_or(&self.start)
    }

    /// Indices of the axes in use.
    pub fn axes(&self) -> Vec<usize> {
        (0..AXES).filter(|&axis| axis < 3 || self.uses[axis]).collect()
    }

    /// Lines in which the machine waits for the operator.
    pub fn pauses(&self) -> BTreeSet<u32> {
        self.moves.iter().filter(|step| step.is_pause()).map(|step| step.line).collect()
    }
}

impl Program {
    /// The same for a machine that stands in the origin: with a rapid move to where the path starts.
    #[must_use]
    pub fn with_approach(&self) -> Self {
        let mut out = self.clone();
        if self.start.iter().any(|&mm| mm != 0.0) {
            let path = Course::Line { to: self.start };
            let approach =
                Move { path, speed: Speed::Rapid, tolerance: None, exact_stop: true, line: 0 };
            out.moves.insert(0, approach);
            out.exact.clear();
            out.start = [0.0; AXES];
        }
        out
    }

    /// The same with curves as chords, `chords` each.
    #[must_use]
    pub fn flattened(&self, chords: u32) -> Self {
        let mut out = Self { moves: Vec::new(), exact: Vec::new(), ..self.clone() };
        let mut here = self.start;
        for step in &self.moves {
            match &step.path {
                Course::Cubic { controls, to } => {
                    for k in 1..=chords {
                        let to = on_cubic(&here, controls, to, f64::from(k) / f64::from(chords));
                        out.moves.push(Move { path: Course::Line { to }, ..step.clone() });
                    }
                    here = *to;
                    continue;
                }
                Course::Line { to } | Course::Arc { to, .. } => here = *to,
                Course::Dwell { .. } | Course::Event { .. } => {}
            }
            out.moves.push(step.clone());
        }
        out
    }
}

/// How files are read.
#[derive(Clone, Copy, Debug)]
pub struct ReadOptions<'a> {
    /// Feed of moves before any F word, and of curves that bring none, mm/s.
    pub feed: f64,
    /// Chords of equal parameter steps that a NURBS curve is run as, in place of the curve itself.
    pub segments: Option<usize>,
    /// Where the machine stands when a G-code program begins, mm or degrees: relative programs go on from
    /// there, and axes that are never named stay there.
    pub start: Point,
    /// Whose G-code it is; told by the file itself, where that is plain, if nothing is said, else LinuxCNC's.
    pub dialect: Option<Dialect>,
    /// Whether codes that cannot change where the tool goes are left out where they would be refused.
    pub lenient: bool,
    /// Whether lines of G-code that begin with `/` are left out.
    pub block_delete: bool,
    /// Work offsets, tools and reference points of the machine ([`crate::machine::Machine::setup`]).
    pub setup: &'a Setup,
}

impl ReadOptions<'_> {
    /// 50 mm/s, curves as they are, a machine in its origin that brings no offsets.
    pub const DEFAULT: Self = Self {
        feed: 50.0,
        segments: None,
        start: [0.0; AXES],
        dialect: None,
        lenient: false,
        block_delete: false,
        setup: &Setup::NONE,
    };
}

impl Default for ReadOptions<'_> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Most bytes of a file: 1 GB.
const MOST_BYTES: u64 = 1_000_000_000;

/// The name of standard input.
pub const STDIN: &str = "-";

/// Reads a tool path; the kind of file is told by its ending. `-` is standard input: JSON if it begins with `{`,
/// else G-code.
///
/// # Errors
/// Names the file, and the places in it that are refused ([`refuse`]).
pub fn read(path: &Path, options: ReadOptions<'_>) -> Result<Program> {
    let (program, findings) = inspect(path, options)?;
    refuse(&findings).with_context(|| path.display().to_string())?;
    Ok(program)
}

/// The same with everything there is to say of the file, errors and warnings. If there is an error among that, the
/// program must not be run: it is what is left without what was refused.
///
/// # Errors
/// The file cannot be read, or not at all be understood; only G-code is read on behind an error.
pub fn inspect(path: &Path, options: ReadOptions<'_>) -> Result<(Program, Vec<Finding>)> {
    inspect_bytes(path, &bytes(path)?, options)
}

/// What is in a file, or comes on standard input.
///
/// # Errors
/// It cannot be read; it is larger than any program.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let count = if path == Path::new(STDIN) {
        let input = std::io::stdin().lock();
        input.take(MOST_BYTES + 1).read_to_end(&mut bytes).context("cannot read standard input")
    } else {
        let read = |file: File| file.take(MOST_BYTES + 1).read_to_end(&mut bytes);
        let name = path.display();
        File::open(path).and_then(read).with_context(|| format!("cannot read {name}"))
    };
    // A device may have no end.
    ensure!(count? as u64 <= MOST_BYTES, "{}: more than {MOST_BYTES} bytes", path.display());
    Ok(bytes)
}

/// The same of a file that has been read; `path` tells the kind.
///
/// # Errors
/// As [`inspect`].
pub fn inspect_bytes(
    path: &Path,
    bytes: &[u8],
    options: ReadOptions<'_>,
) -> Result<(Program, Vec<Finding>)> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_lowercase();
    let name = path.display();
    let text = || String::from_utf8_lossy(bytes);
    let is_json = path == Path::new(STDIN) && bytes.trim_ascii_start().starts_with(b"{");
    let program = match ending.as_str() {
        "" if is_json => curve::parse_json(&text(), options),
        "txt" if smoothing::is_spline(&text()) => spline(&text(), "txt", options),
        "txt" => poly::parse(&text()),
        "toml" => spline(&text(), "toml", options),
        "json" => curve::parse_json(&text(), options),
        "ngc" | "nc" | "gcode" | "tap" | "cnc" | "g" | "gc" | "gco" | "mpf" | "eia" | "" => {
            return Ok(gcode::examine(bytes, options));
        }
        _ => bail!(
            "{name}: unknown kind of file \".{ending}\"; known are .ngc .nc .gcode .gco .g .gc .tap .cnc .mpf .eia \
             (G-code), .txt (poly-line or spline), .toml (spline) and .json (spline or NURBS curve)"
        ),
    };
    let program = program.with_context(|| format!("{name}"))?;
    let findings = program.warnings.iter().map(|text| Finding::warning(0, text)).collect();
    Ok((program, findings))
}

fn spline(text: &str, ending: &str, options: ReadOptions<'_>) -> Result<Program> {
    curve::parse_spline(&SplineFile::parse(text, ending)?, options)
}

/// What the core says about a block, with the letters of the axes instead of their numbers.
pub fn on_letters(error: &BlockError, axes: &[usize]) -> String {
    match *error {
        BlockError::Coordinate { axis, error } => {
            let letter = axes.get(axis).map_or('?', |&axis| LETTERS[axis]);
            format!("{letter} would go to {} mm; coordinates must be within +-1e6", error.value)
        }
        ref other => other.to_string(),
    }
}

/// Place on a cubic curve at a share of its parameter.
pub fn on_cubic(from: &Point, [first, second]: &[Point; 2], to: &Point, u: f64) -> Point {
    let v = 1.0 - u;
    let w = [v * v * v, 3.0 * v * v * u, 3.0 * v * u * u, u * u * u];
    std::array::from_fn(|i| w[0] * from[i] + w[1] * first[i] + w[2] * second[i] + w[3] * to[i])
}
