//! A file through the reader, with its subprograms.

use super::guess::guess;
use super::text::{Place, column, lines};
use crate::program::{
    AXES, Aside, Attended, Course, Finding, LETTERS, Move, Point, Program, ReadOptions, Severity,
    Speed,
};
use splineway::gcode::{Action, Code, Dialect, Laser, Note, ProbeMove, Reader, Reason, Settings};
use splineway::{Block, Coord, Feed, Motion, Switch, Turn};
use std::collections::{BTreeMap, BTreeSet};

/// Deepest call of a subprogram from a subprogram.
const DEPTH: usize = 8;
/// Most lines that are read, those of subprograms as often as they are called.
const MOST_LINES: u64 = 50_000_000;

/// Reads G-code, in an encoding that has ASCII for its codes, to its end: what there is of the program besides its moves, what there
/// is to say of it, and its dialect. `each` gets the moves, and may stop the run.
pub fn go_through<'a>(
    bytes: &'a [u8],
    options: ReadOptions<'a>,
    mut each: impl FnMut(Move, &mut Run<'a>),
) -> (Program, Vec<Finding>, Dialect) {
    let mut run = Run::new(bytes, options);
    let mut count = 0u64;
    while let Some(step) = run.next() {
        count += 1;
        each(step, &mut run);
    }
    let Run { reader, start, dialect, mut findings, asides, .. } = run;
    if count == 0 && asides.is_empty() && findings.iter().all(|finding| !finding.is_error()) {
        findings.push(Finding::warning(0, "there is nothing to run in it"));
    }
    let warnings = findings.iter().filter(|finding| !finding.is_error());
    let warnings = warnings.map(Finding::to_string).collect();
    let (start, uses) = (point(&start), reader.named());
    let program = Program { start, uses, warnings, asides, ..Program::default() };
    (program, findings, dialect)
}

/// A subprogram under way.
struct Call {
    program: u32,
    /// Its first line, and the line to go back to.
    first: Place,
    back: Place,
    /// Times that are left after this one.
    left: u32,
}

/// A program as it is read: gives its moves, one after the other.
pub struct Run<'a> {
    reader: Reader,
    bytes: &'a [u8],
    /// The next line.
    at: Place,
    /// Lines read so far.
    count: u64,
    calls: Vec<Call>,
    /// The line behind each O word; see [`labels`].
    labels: Option<BTreeMap<u32, Option<Place>>>,
    has_label: bool,
    /// Notes are told once.
    told: Vec<Note>,
    /// An F word has been refused: that moves behind it run without one is said by that.
    feed_refused: bool,
    /// Lines that are refused, lest they are so in every call.
    refused: BTreeSet<usize>,
    /// Nothing more is read.
    is_over: bool,
    start: [Coord; AXES],
    dialect: Dialect,
    findings: Vec<Finding>,
    attended: Option<&'a Attended<'a>>,
    /// Moves given so far, and what stood between them.
    given: usize,
    asides: Vec<(usize, Aside)>,
    /// Probes and homing so far.
    stops: usize,
}

impl<'a> Run<'a> {
    /// A program before its first line.
    pub fn new(bytes: &'a [u8], options: ReadOptions<'a>) -> Self {
        let mut findings = Vec::new();
        let dialect = options.dialect.unwrap_or_else(|| {
            let Some(guess) = guess(lines(bytes)) else { return Dialect::LinuxCnc };
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
            switches: options.attended.is_some_and(|attended| attended.outputs),
            laser: options
                .attended
                .and_then(|attended| attended.laser)
                .map(|most| Laser { least: 0.0, most }),
            ..Settings::default()
        };
        Self {
            reader: Reader::new(&settings),
            bytes,
            at: Place::default(),
            count: 0,
            calls: Vec::new(),
            labels: None,
            has_label: false,
            told: Vec::new(),
            feed_refused: false,
            refused: BTreeSet::new(),
            is_over: false,
            start,
            dialect,
            findings,
            attended: options.attended,
            given: 0,
            asides: Vec::new(),
            stops: 0,
        }
    }

    /// Where the machine stands behind the probe or homing that comes next, if that is known.
    fn stop_place(&mut self, assumed: Point) -> (Point, [Coord; AXES]) {
        let known = self.attended.and_then(|attended| attended.stops.get(self.stops).copied());
        self.stops += 1;
        let place = known.unwrap_or(assumed);
        (place, place.map(|mm| Coord::from_mm(mm).unwrap_or_default()))
    }

    /// A probe is the machine's.
    fn probe(&mut self, probe: &ProbeMove) {
        if self.attended.is_none() {
            self.reader.set_position(&probe.to);
            let text = "a probe within a program needs the machine: what follows depends on where it then stands";
            return self.refuse(None, text.to_owned());
        }
        let (ends, place) = self.stop_place(point(&probe.to));
        self.reader.set_position(&place);
        self.asides.push((self.given, Aside::Probe(*probe, ends)));
    }

    /// So is `$H`. `false`: this line is another.
    fn homes(&mut self, line: &[u8]) -> bool {
        if !line.trim_ascii().eq_ignore_ascii_case(b"$H") {
            return false;
        }
        let Some(attended) = self.attended else {
            let text =
                "$H homes, which needs the machine: what follows depends on where it then stands";
            self.refuse(Some(1), text.to_owned());
            return true;
        };
        let Some(home) = attended.home else {
            self.refuse(Some(1), "$H: nothing says how the axes are homed".to_owned());
            return true;
        };
        let mut assumed = point(self.reader.position());
        for (slot, mm) in assumed.iter_mut().zip(home) {
            *slot = mm.unwrap_or(*slot);
        }
        let (ends, place) = self.stop_place(assumed);
        self.reader.set_position(&place);
        self.asides.push((self.given, Aside::Home { line: self.line_number(), ends }));
        true
    }

    /// Reads no further, for a reason.
    pub fn stop(&mut self, reason: String) {
        self.refuse(None, reason);
        self.is_over = true;
    }

    /// Reads a line, if there is one.
    fn read(&mut self) {
        let line = if self.reader.has_ended() { None } else { self.at.line(self.bytes) };
        let Some((line, next)) = line else {
            return self.end();
        };
        self.at = next;
        self.count += 1;
        if self.count > MOST_LINES {
            return self.stop(format!("more than {MOST_LINES} lines with all subprograms"));
        }
        if self.homes(line) {
            return;
        }
        if let Err(refusal) = self.reader.line(self.line_number(), line) {
            self.feed_refused |= matches!(refusal.reason, Reason::Range { letter: 'F', .. });
            let column = column(line, refusal.column);
            self.refuse(Some(column), refusal.reason.to_string());
        } else {
            self.tell();
        }
    }

    /// Tells that there is more behind the end of the program, where a motion may have been meant. Subprograms belong there.
    fn tell_rest(&mut self) {
        let is_empty = |line: &[u8]| matches!(line.trim_ascii(), [] | [b'%' | b'(' | b';', ..]);
        let mut at = self.at;
        while let Some((line, next)) = at.line(self.bytes) {
            at = next;
            if !is_empty(line) {
                if !matches!(line.trim_ascii(), [b'O' | b'o' | b':', ..]) {
                    let end = self.line_number();
                    let text = format!("the program ends in line {end}: nothing behind it is read");
                    self.findings.push(Finding::warning(at.lines as u32, text));
                }
                return;
            }
        }
    }

    /// Behind the last line.
    fn end(&mut self) {
        self.is_over = true;
        if self.reader.has_ended() {
            self.tell_rest();
        }
        if let Err(refusal) = self.reader.finish() {
            self.refuse(None, refusal.reason.to_string());
        }
        if let (Some(call), false) = (self.calls.last(), self.reader.has_ended()) {
            let text = format!("the file ends before M99 of the subprogram O{}", call.program);
            self.refuse(None, text);
        }
    }

    fn line_number(&self) -> u32 {
        self.at.lines as u32
    }

    fn refuse(&mut self, column: Option<u32>, message: String) {
        if self.refused.insert(self.at.lines) {
            let line = self.line_number();
            self.findings.push(Finding { line, column, severity: Severity::Error, message });
        }
    }

    fn tell(&mut self) {
        let line = self.line_number();
        for note in self.reader.notes() {
            let known = self.feed_refused && matches!(note, Note::NoFeed(_));
            if !known && !self.told.contains(note) {
                self.told.push(*note);
                self.findings.push(Finding::warning(line, note.to_string()));
            }
        }
    }

    /// Does what a line asks for, or gives the move; nothing more is read where it cannot go on.
    fn take(&mut self, action: &Action) -> Option<Move> {
        match action {
            Action::Move(block) => return Some(step(block)),
            Action::Event(event) => {
                let (code, value, pause) = (event.code, event.value, event.pause);
                return Some(Move {
                    path: Course::Event { code, value, pause },
                    speed: Speed::Rapid,
                    tolerance: None,
                    exact_stop: true,
                    line: self.line_number(),
                });
            }
            Action::Probe(probe) => self.probe(probe),
            Action::Label(number) => self.is_over |= !self.label(*number),
            Action::Call { program, times } => self.is_over |= !self.call(*program, *times),
            Action::Return => self.is_over |= !self.back(),
            Action::Switch(switch) => {
                let switch = Switch { tag: self.line_number(), ..*switch };
                self.asides.push((self.given, Aside::Switch(switch)));
            }
            Action::Power { power, rest } => {
                let (power, rest, line) = (*power, *rest, self.line_number());
                self.asides.push((self.given, Aside::Power { power, rest, line }));
            }
            Action::End => {}
        }
        None
    }

    fn label(&mut self, number: u32) -> bool {
        if let Some(call) = self.calls.last() {
            let text =
                format!("O{} runs on into O{number}: M99 is missing before it", call.program);
            self.refuse(Some(1), text);
            return false;
        }
        if self.has_label || self.given > 0 || !self.asides.is_empty() {
            let text =
                format!("the program runs on into O{number}: M2 or M30 is missing before it");
            self.refuse(Some(1), text);
            return false;
        }
        self.has_label = true;
        true
    }

    fn call(&mut self, program: u32, times: u32) -> bool {
        let bytes = self.bytes;
        let labels = self.labels.get_or_insert_with(|| labels(bytes));
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

impl Iterator for Run<'_> {
    type Item = Move;

    fn next(&mut self) -> Option<Move> {
        while !self.is_over {
            match self.reader.action() {
                Some(action) => {
                    let step = self.take(&action);
                    if step.is_some() {
                        self.given += 1;
                        return step;
                    }
                }
                None => self.read(),
            }
        }
        None
    }
}

/// Where programs begin: the lines behind their O words; `None` of a number that is there twice.
fn labels(bytes: &[u8]) -> BTreeMap<u32, Option<Place>> {
    let mut labels = BTreeMap::new();
    let mut place = Place::default();
    while let Some((line, next)) = place.line(bytes) {
        place = next;
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
                labels.entry(number).and_modify(|at| *at = None).or_insert(Some(next));
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
