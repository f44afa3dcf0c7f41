//! A file through the reader, with its subprograms.

use super::guess::guess;
use super::text::{column, lines, plain};
use crate::program::{
    AXES, Course, Finding, LETTERS, Move, Point, Program, ReadOptions, Severity, Speed,
};
use splineway::gcode::{Action, Code, Dialect, Note, Reader, Settings};
use splineway::{Block, Coord, Feed, Motion, Turn};
use std::collections::{BTreeMap, BTreeSet};

/// Deepest call of a subprogram from a subprogram.
const DEPTH: usize = 8;
/// Most lines that are read, those of subprograms as often as they are called.
const MOST_LINES: u64 = 50_000_000;
/// Most moves, with those of repeated subprograms and holes: some 3 GB.
const MOST_MOVES: usize = 10_000_000;

/// Reads a G-code file: what it does, and what there is to say of it. Where there is an error among the findings, the
/// program is what is left without those lines, and must not be run.
pub fn examine(bytes: &[u8], options: ReadOptions<'_>) -> (Program, Vec<Finding>) {
    examine_within(bytes, options, MOST_MOVES)
}

/// The same with at most so many moves; more are refused.
pub fn examine_within(
    bytes: &[u8],
    options: ReadOptions<'_>,
    most_moves: usize,
) -> (Program, Vec<Finding>) {
    let bytes = plain(bytes);
    let lines = lines(&bytes);
    let mut findings = Vec::new();
    let dialect = options.dialect.unwrap_or_else(|| {
        let Some(guess) = guess(&lines) else { return Dialect::LinuxCnc };
        let name = match guess.dialect {
            Dialect::LinuxCnc => return guess.dialect,
            Dialect::Grbl => "grbl",
            Dialect::Marlin => "marlin",
        };
        let text = format!("read as --dialect {name}: {}", guess.because);
        findings.push(Finding::warning(0, text));
        guess.dialect
    });
    let mut start = [Coord::ZERO; AXES];
    for (axis, slot) in start.iter_mut().enumerate() {
        let mm = options.start[axis];
        match Coord::from_mm(mm) {
            Ok(coord) => *slot = coord,
            // The error says that nothing may be run; the rest of the program is still examined.
            Err(error) => {
                let text = format!("the machine stands at {}: {error}", LETTERS[axis]);
                findings.push(Finding::error(0, text));
            }
        }
    }
    let settings = Settings {
        dialect,
        feed: options.feed,
        start,
        axes: [true; AXES],
        lenient: options.lenient,
        block_delete: options.block_delete,
        setup: *options.setup,
        ..Settings::default()
    };
    let program = Program { start: point(&start), ..Program::default() };
    let mut run = Run {
        reader: Reader::new(&settings),
        lines: &lines,
        at: 0,
        calls: Vec::new(),
        labels: None,
        has_label: false,
        told: Vec::new(),
        refused: BTreeSet::new(),
        program,
        findings,
        most_moves,
    };
    run.all();
    if run.program.moves.is_empty() && run.findings.iter().all(|finding| !finding.is_error()) {
        run.findings.push(Finding::warning(0, "there is nothing to run in it"));
    }
    run.program.uses = run.reader.named();
    let warnings = run.findings.iter().filter(|finding| !finding.is_error());
    run.program.warnings = warnings.map(Finding::to_string).collect();
    (run.program, run.findings)
}

/// A subprogram under way.
struct Call {
    program: u32,
    /// Index of its first line, and of the line to go back to.
    first: usize,
    back: usize,
    /// Times that are left after this one.
    left: u32,
}

struct Run<'a> {
    reader: Reader,
    lines: &'a [&'a [u8]],
    /// Index of the next line.
    at: usize,
    calls: Vec<Call>,
    /// Index of the line behind each O word; see [`labels`].
    labels: Option<BTreeMap<u32, Option<usize>>>,
    has_label: bool,
    /// Notes are told once.
    told: Vec<Note>,
    /// Lines that are refused, lest they are so in every call.
    refused: BTreeSet<usize>,
    program: Program,
    findings: Vec<Finding>,
    most_moves: usize,
}

impl Run<'_> {
    fn all(&mut self) {
        let mut count = 0;
        while !self.reader.has_ended() {
            let Some(line) = self.lines.get(self.at) else { break };
            self.at += 1;
            count += 1;
            if count > MOST_LINES {
                return self
                    .refuse(None, format!("more than {MOST_LINES} lines with all subprograms"));
            }
            if let Err(refusal) = self.reader.line(self.at as u32, line) {
                let column = column(line, refusal.column);
                self.refuse(Some(column), refusal.reason.to_string());
                continue;
            }
            self.tell();
            while let Some(action) = self.reader.action() {
                let most = self.most_moves;
                if self.program.moves.len() == most {
                    let text = format!("more than {most} moves with all subprograms and holes");
                    return self.refuse(None, text);
                }
                if !self.take(&action) {
                    return;
                }
            }
        }
        if let Err(refusal) = self.reader.finish() {
            self.refuse(None, refusal.reason.to_string());
        }
        if let (Some(call), false) = (self.calls.last(), self.reader.has_ended()) {
            let text = format!("the file ends before M99 of the subprogram O{}", call.program);
            self.refuse(None, text);
        }
    }

    fn refuse(&mut self, column: Option<u32>, message: String) {
        if self.refused.insert(self.at) {
            let line = self.at as u32;
            self.findings.push(Finding { line, column, severity: Severity::Error, message });
        }
    }

    fn tell(&mut self) {
        for note in self.reader.notes() {
            if !self.told.contains(note) {
                self.told.push(*note);
                self.findings.push(Finding::warning(self.at as u32, note.to_string()));
            }
        }
    }

    /// Does what a line asks for; `false` where it cannot go on.
    fn take(&mut self, action: &Action) -> bool {
        match action {
            Action::Move(block) => self.program.moves.push(step(block)),
            Action::Event(event) => {
                let (code, value, pause) = (event.code, event.value, event.pause);
                self.program.moves.push(Move {
                    path: Course::Event { code, value, pause },
                    speed: Speed::Rapid,
                    tolerance: None,
                    exact_stop: true,
                    line: self.at as u32,
                });
            }
            Action::Probe(probe) => {
                self.reader.set_position(&probe.to);
                let text = "a probe within a program needs the machine: what follows depends on where it then stands";
                self.refuse(None, text.to_owned());
            }
            Action::Label(number) => return self.label(*number),
            Action::Call { program, times } => return self.call(*program, *times),
            Action::Return => return self.back(),
            // The settings ask for no outputs.
            Action::End | Action::Switch(_) | Action::Power { .. } => {}
        }
        true
    }

    fn label(&mut self, number: u32) -> bool {
        if let Some(call) = self.calls.last() {
            let text =
                format!("O{} runs on into O{number}: M99 is missing before it", call.program);
            self.refuse(Some(1), text);
            return false;
        }
        if self.has_label {
            let text =
                format!("the program runs on into O{number}: M2 or M30 is missing before it");
            self.refuse(Some(1), text);
            return false;
        }
        self.has_label = true;
        true
    }

    fn call(&mut self, program: u32, times: u32) -> bool {
        let lines = self.lines;
        let labels = self.labels.get_or_insert_with(|| labels(lines));
        let Some(first) = labels.get(&program).copied().flatten() else {
            let twice = labels.contains_key(&program);
            let what = if twice { "more than one" } else { "no" };
            self.refuse(None, format!("M98 P{program}: there is {what} O{program} in this file"));
            return true;
        };
        if self.calls.len() == DEPTH {
            self.refuse(None, format!("M98 P{program}: calls go deeper than {DEPTH}"));
            return false;
        }
        self.calls.push(Call { program, first, back: self.at, left: times - 1 });
        self.at = first;
        true
    }

    fn back(&mut self) -> bool {
        let Some(call) = self.calls.last_mut() else {
            let text = "M99 outside of a subprogram would repeat the program for ever";
            self.refuse(Some(1), text.to_owned());
            return false;
        };
        if let Some(left) = call.left.checked_sub(1) {
            call.left = left;
            self.at = call.first;
        } else {
            self.at = call.back;
            self.calls.pop();
        }
        true
    }
}

/// Where programs begin: the lines behind their O words; `None` of a number that is there twice.
fn labels(lines: &[&[u8]]) -> BTreeMap<u32, Option<usize>> {
    let mut labels = BTreeMap::new();
    for (index, line) in lines.iter().enumerate() {
        let text = String::from_utf8_lossy(line);
        let mut rest = text.trim_start();
        if let Some(behind) = rest.strip_prefix(['N', 'n']) {
            rest =
                behind.trim_start().trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
        }
        if let Some(number) = rest.strip_prefix(['O', 'o']) {
            let number = number.trim_start();
            let digits = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
            if let Ok(number) = number[..digits].parse() {
                labels.entry(number).and_modify(|at| *at = None).or_insert(Some(index + 1));
            }
        }
    }
    labels
}

fn point(place: &[Coord; AXES]) -> Point {
    place.map(Coord::to_mm)
}

fn step(block: &Block<f64, AXES>) -> Move {
    let path = match &block.motion {
        Motion::Line { to } => Course::Line { to: point(to) },
        Motion::Arc { to, plane, centre, turn, extra_turns } => Course::Arc {
            to: point(to),
            plane: *plane,
            centre: (centre.0.to_mm(), centre.1.to_mm()),
            clockwise: *turn == Turn::Clockwise,
            extra_turns: *extra_turns,
        },
        Motion::Cubic { controls, to } => {
            Course::Cubic { controls: [point(&controls[0]), point(&controls[1])], to: point(to) }
        }
        Motion::Dwell { seconds } => Course::Dwell { seconds: *seconds },
        Motion::Event { pause } => Course::Event { code: Code::m(0), value: None, pause: *pause },
    };
    let speed = match block.feed {
        Feed::PerSecond(feed) => Speed::PerSecond(feed),
        Feed::Duration(seconds) => Speed::Duration(seconds),
        Feed::Rapid => Speed::Rapid,
    };
    let (tolerance, exact_stop) = (block.tolerance, block.exact_stop);
    Move { path, speed, tolerance, exact_stop, line: block.tag }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line may ask for 300 million pecks, and a subprogram for more: what does not fit is said, and not tried.
    #[test]
    fn programs_that_fill_the_memory_are_refused() {
        for (text, line) in [
            ("G91 G83 X1 Z-10 R1 Q0.0011 L9999 F600", 1),
            ("M98 P1 L9999\nM30\nO1\nM98 P2 L9999\nM99\nO2\nG91 G0 X1\nX-1\nM99", 9),
        ] {
            let (program, findings) = examine_within(text.as_bytes(), ReadOptions::DEFAULT, 1000);
            assert_eq!((program.moves.len(), findings.len()), (1000, 1));
            assert_eq!(findings[0].line, line);
            assert!(findings[0].message.contains("more than 1000 moves"), "{findings:?}");
        }
    }
}
