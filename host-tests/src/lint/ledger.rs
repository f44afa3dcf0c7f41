//! What is known of the lines of a program: of one whose lines come in order, only of those around the motion.

use super::feeds::{Asked, NOTHING, asked, length};
use super::listing::Listing;
use super::way::{Stretch, Way};
use super::{Extent, Findings, Place};
use anyhow::Result;
use splineway_simulator::machine::{Axis, Machine, is_rotary};
use splineway_simulator::program::arc::Spiral;
use splineway_simulator::program::{Course, LETTERS, Move, Point, Speed, Tape, on_cubic};
use splineway_simulator::run::Sample;
use std::collections::BTreeMap;

/// A line of the file.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// What becomes of it in the report.
    pub place: Place,
    /// Turns of the path at its beginning and its end, degrees.
    pub turns: [f64; 2],
    /// Whether it ends in an exact stop.
    pub stops: bool,
    /// Whether it goes nowhere.
    pub dwells: bool,
}

/// How much of a program might be otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Odd {
    /// Lines without a length.
    pub empty: usize,
    /// Moves with more feed than the axes allow.
    pub beyond: usize,
    /// Exact stops that the program asks for: not those within a drilling cycle.
    pub stops: usize,
}

/// Moves of one line, one behind the other: of a drilling cycle, which stops between them and has some of no length.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    line: u32,
    moves: usize,
    stops: usize,
    empty: usize,
}

/// The lines of a program, as far as they are needed.
pub struct Ledger<'a> {
    steps: Box<dyn Iterator<Item = Move> + 'a>,
    source: Listing<'a>,
    axes: Vec<usize>,
    limits: Vec<Axis>,
    /// Whether lines come in order: else all are kept.
    ordered: bool,
    here: Point,
    /// The last move that went anywhere: its line, and its direction at its end.
    last: Option<(u32, Vec<f64>)>,
    /// Lines before this one are complete.
    complete: u32,
    lines: BTreeMap<u32, Line>,
    /// The moves around the motion.
    way: Way,
    /// The moves that were looked at last.
    group: Group,
    extent: Vec<(f64, f64)>,
    /// Places that lose most of those that are done with, and how many are wanted.
    worst: Vec<Place>,
    places: usize,
    /// What a place must lose to be one, s.
    least: f64,
    /// Moves, lengths and stops so far.
    pub findings: Findings,
    /// What there is to say something about.
    pub odd: Odd,
}

impl<'a> Ledger<'a> {
    /// A ledger of a program; so many slow places are wanted.
    ///
    /// # Errors
    /// The machine lacks an axis.
    pub fn new(
        program: &'a dyn Tape,
        machine: &Machine,
        places: usize,
        source: Listing<'a>,
    ) -> Result<Self> {
        let axes = program.axes();
        let here = program.start();
        let mut ledger = Self {
            steps: program.steps(),
            source,
            limits: machine.axes_of(program)?,
            ordered: program.summary().is_ordered,
            here,
            last: None,
            complete: 0,
            lines: BTreeMap::new(),
            way: Way::default(),
            group: Group::default(),
            extent: axes.iter().map(|&axis| (here[axis], here[axis])).collect(),
            axes,
            worst: Vec::new(),
            places,
            least: 2.0 * machine.cycle,
            findings: Findings::default(),
            odd: Odd::default(),
        };
        if !ledger.ordered {
            while ledger.load() {}
        }
        Ok(ledger)
    }

    /// What is known of a line.
    pub fn line(&mut self, line: u32) -> &mut Line {
        while self.complete <= line && self.load() {}
        self.own(line)
    }

    /// What the move asks for that is under way; every cycle is to be told.
    pub fn asked(&mut self, sample: &Sample<'_>) -> Asked {
        while self.way.wants(sample) && self.load() {}
        self.way.follow(sample)
    }

    /// Lines before this one have been run, and what was lost there is known.
    pub fn retire(&mut self, line: u32) {
        while self.ordered
            && let Some(entry) = self.lines.first_entry()
            && *entry.key() < line.min(self.complete)
        {
            let place = entry.remove().place;
            self.rank(place);
        }
    }

    /// A further move; whether there is one.
    fn load(&mut self) -> bool {
        let Some(step) = self.steps.next() else {
            self.complete = u32::MAX;
            return false;
        };
        let way = length(&self.here, &step.path, &self.axes);
        self.count(&step, way);
        self.join(&step);
        self.reach(&step);
        if let Some(to) = step.path.end() {
            self.here = *to;
        }
        true
    }

    fn count(&mut self, step: &Move, way: f64) {
        let moves = &mut self.findings.moves;
        let (kind, straight) = match &step.path {
            Course::Line { .. } => (&mut moves.lines, true),
            Course::Arc { .. } => (&mut moves.arcs, false),
            Course::Cubic { .. } => (&mut moves.curves, false),
            Course::Dwell { .. } | Course::Event { .. } => (&mut moves.dwells, false),
        };
        *kind += 1;
        self.findings.stops += usize::from(step.exact_stop);
        self.findings.length += way;
        if step.line != self.group.line {
            self.end_group();
            self.group.line = step.line;
        }
        self.group.moves += 1;
        self.group.stops += usize::from(step.exact_stop && step.path.end().is_some());
        let empty = straight && way < NOTHING;
        if empty && !is_extrusion(&self.source.line(step.line)) {
            self.group.empty += 1;
        }
        let asked = asked(step, &self.here, &self.axes, &self.limits);
        self.odd.beyond +=
            usize::from(step.speed != Speed::Rapid && asked.wanted > asked.most * 1.001);
        self.way.add(Stretch { line: step.line, length: way, asked });
        self.own(step.line).place.length += way;
    }

    /// The moves of a line are over.
    fn end_group(&mut self) {
        let Group { moves, stops, empty, .. } = std::mem::take(&mut self.group);
        if moves == 1 {
            self.odd.stops += stops;
            self.odd.empty += empty;
        }
    }

    /// A line of the program.
    fn own(&mut self, line: u32) -> &mut Line {
        self.lines.entry(line).or_insert_with(|| Line {
            place: Place { line, slowest: f64::INFINITY, ..Place::default() },
            ..Line::default()
        })
    }

    /// Turns between this move and the one before.
    fn join(&mut self, step: &Move) {
        let own = self.own(step.line);
        own.stops |= step.exact_stop;
        own.dwells |= step.path.end().is_none();
        let Some([begin, end]) = tangents(&step.path, &self.here) else { return };
        // Only a move that goes somewhere tells how the lines before it end.
        self.complete = step.line;
        let Some((line, last)) = self.last.replace((step.line, end)) else { return };
        let cosine: f64 = last.iter().zip(&begin).map(|(a, b)| a * b).sum();
        let turn = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        let first = &mut self.own(step.line).turns[0];
        *first = first.max(turn);
        // One that is done with has had its place.
        if let Some(other) = self.lines.get_mut(&line) {
            other.turns[1] = other.turns[1].max(turn);
        }
    }

    /// Least and greatest coordinates: of arcs and curves, too, not of their ends alone.
    fn reach(&mut self, step: &Move) {
        let here = self.here;
        let mut see = |point: &Point| {
            for ((least, greatest), &axis) in self.extent.iter_mut().zip(&self.axes) {
                (*least, *greatest) = (least.min(point[axis]), greatest.max(point[axis]));
            }
        };
        if let Some(arc) = Spiral::of(&step.path, &here) {
            arc.extremes().for_each(|u| see(&arc.point(u)));
        }
        if let Course::Cubic { controls, to } = &step.path {
            for axis in 0..here.len() {
                let at = [here[axis], controls[0][axis], controls[1][axis], to[axis]];
                extremes(at).for_each(|u| see(&on_cubic(&here, controls, to, u)));
            }
        }
        if let Some(to) = step.path.end() {
            see(to);
        }
    }

    /// Keeps a place that is done with if it loses as much as those that are wanted.
    fn rank(&mut self, place: Place) {
        if !(place.lost > self.least) {
            return;
        }
        let at = self.worst.partition_point(|other| other.lost >= place.lost);
        self.worst.insert(at, place);
        self.worst.truncate(self.places);
    }

    /// The findings of all of it: moves, length, extent, and the places that lose most.
    pub fn finish(mut self) -> (Findings, Odd) {
        while self.load() {}
        self.end_group();
        for (_, line) in std::mem::take(&mut self.lines) {
            self.rank(line.place);
        }
        let mut findings = self.findings;
        findings.slowest = self.worst;
        let extent = self.axes.iter().zip(self.extent);
        findings.extent = extent
            .map(|(&axis, (least, greatest))| Extent {
                axis: LETTERS[axis],
                unit: if is_rotary(axis) { "deg" } else { "mm" },
                least,
                greatest,
            })
            .collect();
        (findings, self.odd)
    }
}

/// Where a coordinate of a cubic curve with these control points turns.
fn extremes([a, b, c, d]: [f64; 4]) -> impl Iterator<Item = f64> {
    // The derivative over three: p t^2 + 2 q t + r.
    let (p, q, r) = (d - 3.0 * c + 3.0 * b - a, a - 2.0 * b + c, b - a);
    let root = (q * q - p * r).max(0.0).sqrt();
    // Without a difference of like numbers.
    let s = -(q + if q < 0.0 { -root } else { root });
    [s / p, r / s].into_iter().filter(|u| (0.0..=1.0).contains(u))
}

/// Directions of a move at its beginning and its end.
fn tangents(course: &Course, here: &Point) -> Option<[Vec<f64>; 2]> {
    let unit = |from: &Point, to: &Point| {
        let way: Vec<f64> = from.iter().zip(to).map(|(a, b)| b - a).collect();
        let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        (length > 1e-9).then(|| way.iter().map(|x| x / length).collect::<Vec<f64>>())
    };
    match course {
        Course::Line { to } => unit(here, to).map(|tangent| [tangent.clone(), tangent]),
        Course::Arc { .. } => {
            let arc = Spiral::of(course, here)?;
            let small = 1e-5;
            Some([
                unit(&arc.point(0.0), &arc.point(small))?,
                unit(&arc.point(1.0 - small), &arc.point(1.0))?,
            ])
        }
        Course::Cubic { controls: [first, second], to } => {
            let begin =
                unit(here, first).or_else(|| unit(here, second)).or_else(|| unit(here, to))?;
            let end = unit(second, to).or_else(|| unit(first, to)).or_else(|| unit(here, to))?;
            Some([begin, end])
        }
        Course::Dwell { .. } | Course::Event { .. } => None,
    }
}

/// Whether a line of the file pushes or pulls filament (an E word): without a way, it is not useless.
fn is_extrusion(text: &str) -> bool {
    let code = text.split([';', '(']).next().unwrap_or("");
    let letters = code.char_indices().filter(|(_, letter)| letter.eq_ignore_ascii_case(&'e'));
    let number = |rest: &str| {
        rest.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
    };
    letters.into_iter().any(|(at, _)| {
        let before = code[..at].chars().next_back();
        !before.is_some_and(|c| c.is_ascii_digit() || c == '.') && number(&code[at + 1..])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_turns_where_its_derivative_is_none() {
        for points in [[0.0, 1.0, -1.0, 0.0], [0.0, 3.0, 3.0, 0.0], [2.0, -5.0, 1.0, 9.0]] {
            let at = |t: f64| {
                let s = 1.0 - t;
                let [a, b, c, d] = points;
                s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
            };
            let sampled = (0..=1000).map(|k| at(f64::from(k) / 1000.0));
            let most = sampled.fold(f64::NEG_INFINITY, f64::max);
            let own = extremes(points).map(at).fold(points[0].max(points[3]), f64::max);
            assert!(own >= most - 1e-12 && own <= most + 1e-5, "{points:?}: {own}, {most}");
        }
        // A line has none, and says so without a NaN.
        assert_eq!(extremes([0.0, 1.0, 2.0, 3.0]).count(), 0);
    }
}
