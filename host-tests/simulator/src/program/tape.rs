//! A program as those see it who go through it from its beginning, as often as they like: a list in memory, or G-code that
//! is read again each time, so that a long one takes no more room than its text.

use super::gcode::{Run, go_through};
use super::tool_path::{Aside, Header, Move, Program, ReadOptions, Speed};
use super::{AXES, Finding};
use crate::point::Point;
use crate::spline::Rational;
use std::collections::BTreeSet;

/// What can be said of a whole program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Whether lines come in order, so that they tell how far a run has come.
    pub is_ordered: bool,
    /// The last line by its number.
    pub last_line: u32,
    /// The widest tolerance that a move names, or has whatever it names, mm.
    pub widest: f64,
    /// Lines in which the machine waits for the operator.
    pub pauses: BTreeSet<u32>,
}

impl Summary {
    /// Of no moves.
    const EMPTY: Self =
        Self { is_ordered: true, last_line: 0, widest: 0.0, pauses: BTreeSet::new() };

    fn of(steps: impl Iterator<Item = Move>) -> Self {
        let mut summary = Self::EMPTY;
        let mut before = 0;
        for step in steps {
            summary.add(&step, &mut before);
        }
        summary
    }

    /// A further move; `before` is the line of the one before.
    fn add(&mut self, step: &Move, before: &mut u32) {
        self.is_ordered &= *before <= step.line;
        *before = step.line;
        self.last_line = self.last_line.max(step.line);
        self.widest = self.widest.max(step.tolerance.unwrap_or(0.0)).max(step.least_band());
        if step.is_pause() {
            self.pauses.insert(step.line);
        }
    }
}

/// A program that is gone through.
pub trait Tape {
    /// Where it starts.
    fn start(&self) -> Point;

    /// Which axes it uses; X, Y and Z always.
    fn uses(&self) -> [bool; AXES];

    /// Its moves, in order.
    fn steps(&self) -> Box<dyn Iterator<Item = Move> + '_>;

    /// What it says about the machine.
    fn header(&self) -> Option<Header> {
        None
    }

    /// Curves that the moves stand for, one for each; empty if the moves are the program themselves.
    fn exact(&self) -> &[Rational] {
        &[]
    }

    /// What was noticed while reading.
    fn warnings(&self) -> &[String] {
        &[]
    }

    /// What stands between the moves, each with the index of the move behind it.
    fn asides(&self) -> &[(usize, Aside)] {
        &[]
    }

    /// Indices of the axes in use.
    fn axes(&self) -> Vec<usize> {
        let uses = self.uses();
        (0..AXES).filter(|&axis| axis < 3 || uses[axis]).collect()
    }

    /// What can be said of all of it. Cost: the program is gone through once, unless that is known.
    fn summary(&self) -> Summary {
        Summary::of(self.steps())
    }

    /// All of it as a list.
    fn to_program(&self) -> Program {
        Program {
            start: self.start(),
            uses: self.uses(),
            moves: self.steps().collect(),
            header: self.header(),
            warnings: self.warnings().to_vec(),
            exact: self.exact().to_vec(),
            asides: self.asides().to_vec(),
        }
    }
}

impl Tape for Program {
    fn start(&self) -> Point {
        self.start
    }

    fn uses(&self) -> [bool; AXES] {
        self.uses
    }

    fn steps(&self) -> Box<dyn Iterator<Item = Move> + '_> {
        Box::new(self.moves.iter().cloned())
    }

    fn header(&self) -> Option<Header> {
        self.header
    }

    fn exact(&self) -> &[Rational] {
        &self.exact
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn asides(&self) -> &[(usize, Aside)] {
        &self.asides
    }
}

/// G-code that is read again whenever its moves are wanted.
#[derive(Clone, Debug)]
pub struct Reel<'a> {
    bytes: &'a [u8],
    options: ReadOptions<'a>,
    /// What there is besides the moves.
    head: Program,
    summary: Summary,
}

impl<'a> Reel<'a> {
    /// Reads G-code once, for what there is to say of it. `bytes` are those of a file as `gcode::plain` has them.
    /// Where there is an error among the findings, it must not be run.
    pub fn new(bytes: &'a [u8], options: ReadOptions<'a>) -> (Self, Vec<Finding>) {
        let (mut summary, mut before) = (Summary::EMPTY, 0);
        let (head, findings, dialect) =
            go_through(bytes, options, |step, _| summary.add(&step, &mut before));
        // Told once, for all that are to come.
        let options = ReadOptions { dialect: Some(dialect), ..options };
        (Self { bytes, options, head, summary }, findings)
    }
}

impl Tape for Reel<'_> {
    fn start(&self) -> Point {
        self.head.start
    }

    fn uses(&self) -> [bool; AXES] {
        self.head.uses
    }

    fn steps(&self) -> Box<dyn Iterator<Item = Move> + '_> {
        Box::new(Run::new(self.bytes, self.options))
    }

    fn warnings(&self) -> &[String] {
        &self.head.warnings
    }

    fn summary(&self) -> Summary {
        self.summary.clone()
    }
}

/// A program with other feeds and tolerances than its own.
#[derive(Clone, Copy)]
pub struct Overriding<'a> {
    /// The program.
    pub tape: &'a dyn Tape,
    /// Feed of all moves but rapids, mm/s, in place of their own.
    pub feed: Option<f64>,
    /// Whether no tolerance that it names counts.
    pub tolerance: bool,
}

impl Overriding<'_> {
    /// Moves whose feed, and whose tolerance, is not their own.
    pub fn count(&self) -> (usize, usize) {
        if self.feed.is_none() && !self.tolerance {
            return (0, 0);
        }
        let changed = |before: &Move| {
            let after = self.change(before.clone());
            let feed = before.path.end().is_some() && after.speed != before.speed;
            (usize::from(feed), usize::from(after.tolerance != before.tolerance))
        };
        let add = |sum: (usize, usize), each: (usize, usize)| (sum.0 + each.0, sum.1 + each.1);
        self.tape.steps().map(|step| changed(&step)).fold((0, 0), add)
    }

    fn change(&self, mut step: Move) -> Move {
        if let (Some(feed), false) = (self.feed, step.speed == Speed::Rapid) {
            step.speed = Speed::PerSecond(feed);
        }
        if self.tolerance {
            step.tolerance = None;
        }
        step
    }
}

impl Tape for Overriding<'_> {
    fn start(&self) -> Point {
        self.tape.start()
    }

    fn uses(&self) -> [bool; AXES] {
        self.tape.uses()
    }

    fn steps(&self) -> Box<dyn Iterator<Item = Move> + '_> {
        Box::new(self.tape.steps().map(|step| self.change(step)))
    }

    fn header(&self) -> Option<Header> {
        self.tape.header()
    }

    fn exact(&self) -> &[Rational] {
        self.tape.exact()
    }

    fn summary(&self) -> Summary {
        // Feeds are nothing to it.
        if self.tolerance { Summary::of(self.steps()) } else { self.tape.summary() }
    }

    fn warnings(&self) -> &[String] {
        self.tape.warnings()
    }

    fn asides(&self) -> &[(usize, Aside)] {
        self.tape.asides()
    }
}

#[cfg(test)]
mod tests {
    use super::super::gcode::{parse, plain};
    use super::*;

    /// A reel gives the moves that a list has, however often it is gone through: with subprograms, drilling and arcs.
    #[test]
    fn a_reel_is_the_list() {
        let text = "G21 (a)\nG1 X1 F600\nM98 P7 L3\nG81 X5 Z-2 R1 L2\nG2 X10 I2\r\nG64 P0.1\rM3 S5\nM30\nO7\nG91 G1 Y1\nM99\n";
        let list = parse(text, 50.0).unwrap();
        let bytes = plain(text.as_bytes());
        let (reel, findings) = Reel::new(&bytes, ReadOptions::DEFAULT);
        assert!(findings.is_empty(), "{findings:?}");
        for _ in 0..2 {
            assert!(reel.steps().eq(list.moves.iter().cloned()));
        }
        assert_eq!(reel.to_program(), list);
        assert!(!reel.summary().is_ordered);
        assert_eq!(reel.summary(), list.summary());
        let over = Overriding { tape: &reel, feed: Some(3.0), tolerance: true };
        // Of the moves before G64, none names a tolerance.
        let (feeds, tolerances) = over.count();
        assert!(feeds > 4 && tolerances == 0, "{feeds} {tolerances}");
        let feed = |step: &Move| step.speed == Speed::Rapid || step.speed == Speed::PerSecond(3.0);
        assert!(over.steps().all(|step| feed(&step)));
    }
}
