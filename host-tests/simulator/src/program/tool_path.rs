//! What a tool path is.

use crate::point::{AXES, Point, on_cubic};
use crate::spline::Rational;
use anyhow::{Result, bail};
use splineway::block::FINEST_BAND;
use splineway::gcode::{Code, Dialect, ProbeMove, Setup};
use splineway::{Power, Switch};
use std::collections::BTreeSet;

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
    /// With the program's tolerance, and no exact stop.
    pub const fn new(path: Course, speed: Speed, line: u32) -> Self {
        Self { path, speed, tolerance: None, exact_stop: false, line }
    }

    /// The tolerance that it has, whatever it names, mm.
    pub const fn least_band(&self) -> f64 {
        if matches!(self.path, Course::Arc { .. }) { FINEST_BAND } else { 0.0 }
    }

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

/// What stands between the moves of a program for a controller: see [`Attended`].
#[derive(Clone, Debug, PartialEq)]
pub enum Aside {
    /// A probe, and where the machine stands behind it.
    Probe(ProbeMove, Point),
    /// Homing (`$H`), and where the machine stands behind it.
    Home {
        /// Line of the program.
        line: u32,
        /// Where the machine then stands.
        ends: Point,
    },
    /// An output that switches in time with the path.
    Switch(Switch<f64>),
    /// The power of the moves that follow.
    Power {
        /// Which.
        power: Power<f64>,
        /// Whether it is on at rest, too.
        rest: bool,
        /// Line of the program.
        line: u32,
    },
}

/// A program for a machine that probes, homes and switches outputs while it is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Attended<'a> {
    /// Where the machine stood behind each probe and each homing, as far as they are over. Of others it is assumed: the target of a
    /// probe, and what homing is to end at.
    pub stops: &'a [Point],
    /// Where homing ends, mm, of the axes that are homed; `None`: `$H` is refused.
    pub home: Option<[Option<f64>; AXES]>,
    /// Whether M62 to M68 are outputs in time with the path; else M62 to M65 are events.
    pub outputs: bool,
    /// The greatest power of a laser, if S and M3 to M5 are for one.
    pub laser: Option<f64>,
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
    /// What stands between the moves, each with the index of the move behind it.
    pub asides: Vec<(usize, Aside)>,
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
            out.asides.iter_mut().for_each(|(place, _)| *place += 1);
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
    /// Work offsets, tools and reference points of the machine (`machine::Machine::setup`).
    pub setup: &'a Setup,
    /// Whether a machine is there that probes, homes and switches outputs; without one, probes are refused.
    pub attended: Option<&'a Attended<'a>>,
}

impl ReadOptions<'_> {
    /// For what is no NURBS curve of a file.
    ///
    /// # Errors
    /// It is to be run as chords.
    pub fn check_no_chords(&self) -> Result<()> {
        match self.segments {
            Some(count) => bail!("only a NURBS curve can be run as {count} chords (--segments)"),
            None => Ok(()),
        }
    }

    /// 50 mm/s, curves as they are, a machine in its origin that brings no offsets.
    pub const DEFAULT: Self = Self {
        feed: 50.0,
        segments: None,
        start: [0.0; AXES],
        dialect: None,
        lenient: false,
        block_delete: false,
        setup: &Setup::NONE,
        attended: None,
    };
}

impl Default for ReadOptions<'_> {
    fn default() -> Self {
        Self::DEFAULT
    }
}
