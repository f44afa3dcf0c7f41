//! What a page is told in words and single numbers.

use super::{Page, part};
use crate::lint::Asked;
use serde::Serialize;
use splineway_simulator::machine::is_rotary;
use splineway_simulator::program::LETTERS;
use splineway_simulator::record::recording::{Column, Outline};

/// Feeds are counted in thousandths of mm/s.
const FEED_COUNT: f64 = 1.0e-3;
/// A speed law's curve is counted in these shares of its length and its greatest speed.
const OVERLAY_COUNTS: f64 = 50_000.0;
/// It may be off by this many of them.
const OVERLAY_OFF: f64 = 25.0;

/// What an operator did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Command {
    /// When, s.
    pub time: f64,
    /// What.
    pub text: String,
}

/// A speed law on the same path.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// What it is.
    pub name: String,
    /// Time, s.
    pub time: f64,
    /// Way, mm, and speed, mm/s.
    pub points: Vec<(f64, f64)>,
}

impl Overlay {
    /// Length of the way, mm, and the greatest speed, mm/s.
    fn extent(&self) -> (f64, f64) {
        let most = |all: &mut dyn Iterator<Item = f64>| all.fold(1e-9, f64::max);
        (most(&mut self.points.iter().map(|p| p.0)), most(&mut self.points.iter().map(|p| p.1)))
    }

    /// Its points in counts, less those that lie on lines between others: differences of way and speed.
    pub fn column(&self) -> Column {
        let (length, fastest) = self.extent();
        let counts = |(way, speed): &(f64, f64)| {
            let count = |x: f64, most: f64| (x / most * OVERLAY_COUNTS).round() as i64;
            (count(*way, length), count(*speed, fastest))
        };
        let points: Vec<(i64, i64)> = self.points.iter().map(counts).collect();
        let mut column = Column::default();
        let mut last = (0, 0);
        let mut write = |point: (i64, i64)| {
            column.number(point.0 - last.0);
            column.number(point.1 - last.1);
            last = point;
        };
        // A swinging door: the slopes that pass all points since the last that was written.
        let mut door = (f64::NEG_INFINITY, f64::INFINITY);
        let mut from = None;
        for (n, point) in points.iter().enumerate() {
            let Some(start) = from else {
                write(*point);
                from = Some(*point);
                continue;
            };
            let slopes = |from: (i64, i64), point: &(i64, i64)| {
                let (way, speed) = ((point.0 - from.0) as f64, (point.1 - from.1) as f64);
                ((speed - OVERLAY_OFF) / way, (speed + OVERLAY_OFF) / way)
            };
            let step = point.0 > start.0;
            let (low, high) = if step { slopes(start, point) } else { door };
            let slope = (point.1 - start.1) as f64 / (point.0 - start.0) as f64;
            if step && door.0 <= slope && slope <= door.1 {
                door = (door.0.max(low), door.1.min(high));
                continue;
            }
            let before = points[n - 1];
            write(before);
            from = Some(before);
            door = if point.0 > before.0 { slopes(before, point) } else { (1.0, -1.0) };
        }
        if let Some(end) = points.last() {
            write(*end);
        }
        column
    }
}

/// Feeds as they were run: cycles since the last change, kind (0 over the linear axes, 1 no linear axis moves, 2 rapid), feed in counts.
#[derive(Clone, Debug, Default)]
pub struct Feeds {
    column: Column,
    cycle: u64,
    /// The cycle of the last change, and what has been asked for since.
    last: (u64, Option<(u64, u64)>),
}

impl Feeds {
    /// One more servo cycle.
    pub fn add(&mut self, asked: Asked) {
        let kind = if asked.rapid { 2 } else { u64::from(asked.turns) };
        let finite = asked.wanted.is_finite() && asked.wanted > 0.0;
        let count = if finite { (asked.wanted / FEED_COUNT).round() as u64 } else { 0 };
        if self.last.1 != Some((kind, count)) {
            self.column.count(self.cycle - self.last.0);
            self.column.count(kind);
            self.column.count(count);
            self.last = (self.cycle, Some((kind, count)));
        }
        self.cycle += 1;
    }

    /// All of them.
    pub const fn column(&self) -> &Column {
        &self.column
    }
}

#[derive(Debug, Serialize)]
struct HeadAxis {
    letter: char,
    rotary: bool,
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    least: Option<f64>,
    greatest: Option<f64>,
    /// Counts of velocity and acceleration.
    counts: [f64; 2],
    start: [i64; 3],
    peaks: Vec<[f64; 2]>,
}

#[derive(Debug, Serialize)]
struct HeadMotor {
    name: String,
    factors: Vec<f64>,
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

#[derive(Debug, Serialize)]
struct HeadSlow {
    line: u32,
    lost: f64,
    time: f64,
    slowest: f64,
    feed: f64,
    cause: String,
}

#[derive(Debug, Serialize)]
struct HeadOverlay {
    name: String,
    time: f64,
    /// Counts of way and speed.
    counts: [f64; 2],
}

/// What was run, without its columns.
#[derive(Debug, Serialize)]
pub struct Head {
    name: String,
    time: f64,
    cycle: f64,
    cycles: u64,
    spans: usize,
    axes: Vec<HeadAxis>,
    motors: Vec<HeadMotor>,
    tolerance: f64,
    deviation: f64,
    length: f64,
    mean_speed: f64,
    starved: u32,
    shaped: bool,
    broken: Vec<String>,
    /// One count of position, mm; how far positions are off at most, and what they should be.
    count: f64,
    off: f64,
    part: f64,
    /// How often curves were made coarser, and by how much of their limits they may be off: velocity, acceleration, jerk.
    level: usize,
    curves_off: [f64; 3],
    vertices: usize,
    outline_count: f64,
    feed_count: f64,
    slow: Vec<HeadSlow>,
    events: Vec<Command>,
    event_lines: Vec<u32>,
    commands: Vec<Command>,
    overlays: Vec<HeadOverlay>,
    pub source: bool,
    pub columns: Vec<(String, usize)>,
}

impl Head {
    /// Of a page.
    pub fn new(page: &Page<'_>, outline: &Outline) -> Self {
        let (tape, machine) = (&page.recording.tape, page.machine);
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let used = page.program.axes();
        let axes = used.iter().enumerate().filter_map(|(n, &index)| {
            let limits = machine.axis(index).ok()?;
            let letter = LETTERS[index];
            let ends = machine
                .travel
                .iter()
                .find(|(key, _)| key.eq_ignore_ascii_case(&letter.to_string()));
            let peaks = page.recording.peaks.get(n).copied().unwrap_or_default();
            Some(HeadAxis {
                letter,
                rotary: is_rotary(index),
                velocity: limits.velocity,
                acceleration: limits.acceleration,
                jerk: limits.jerk,
                least: ends.and_then(|(_, ends)| ends.least),
                greatest: ends.and_then(|(_, ends)| ends.greatest),
                counts: [tape.grain.axes[n].velocity, tape.grain.axes[n].acceleration],
                start: tape.start[n],
                peaks: peaks.map(|ends| ends.map(finite)).to_vec(),
            })
        });
        let motors = machine.motors_for(page.program).into_iter().map(|motor| HeadMotor {
            name: motor.name,
            factors: motor.factors,
            velocity: motor.limits.velocity,
            acceleration: motor.limits.acceleration,
            jerk: motor.limits.jerk,
        });
        let slow = page.slow.iter().map(|place| HeadSlow {
            line: place.line,
            lost: place.lost,
            time: place.worst.time,
            slowest: finite(place.worst.slowest),
            feed: finite(place.feed),
            cause: place.cause.clone(),
        });
        let overlays = page.overlays.iter().map(|overlay| {
            let (length, fastest) = overlay.extent();
            HeadOverlay {
                name: overlay.name.clone(),
                time: overlay.time,
                counts: [length / OVERLAY_COUNTS, fastest / OVERLAY_COUNTS],
            }
        });
        let events = page.report.events.iter();
        Self {
            name: page.name.to_owned(),
            time: page.report.time_s,
            cycle: tape.grain.cycle,
            cycles: tape.cycles,
            spans: tape.spans,
            axes: axes.collect(),
            motors: motors.collect(),
            tolerance: machine.tolerance,
            deviation: page.report.max_deviation_mm,
            length: page.report.path_length_mm,
            mean_speed: page.report.feed.mean_mm_s,
            starved: page.report.starved,
            shaped: !machine.shaper.is_empty(),
            broken: page.broken.to_vec(),
            count: tape.grain.position,
            off: tape.grain.off_run,
            part: part(page.track, machine),
            level: tape.grain.level,
            curves_off: tape.grain.off_limits(),
            vertices: outline.vertices,
            outline_count: outline.count,
            feed_count: FEED_COUNT,
            slow: slow.collect(),
            events: events
                .clone()
                .map(|event| Command {
                    time: event.time_s,
                    text: format!("{}{}", event.code, if event.pause { ", pause" } else { "" }),
                })
                .collect(),
            event_lines: events.map(|event| event.line).collect(),
            commands: page.commands.to_vec(),
            overlays: overlays.collect(),
            source: false,
            columns: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_overlay_keeps_its_shape() {
        let points = (0..=2000).map(|k| {
            let s = f64::from(k) / 10.0;
            (s, if k % 500 == 0 { 0.0 } else { 40.0 + (s / 20.0).sin() })
        });
        let overlay = Overlay { name: "law".to_owned(), time: 1.0, points: points.collect() };
        let (length, fastest) = overlay.extent();
        let column = overlay.column();
        let mut read = column.read();
        let (mut at, mut kept) = ((0, 0), Vec::new());
        while !read.is_empty() {
            at = (at.0 + read.number(), at.1 + read.number());
            kept.push((
                at.0 as f64 / OVERLAY_COUNTS * length,
                at.1 as f64 / OVERLAY_COUNTS * fastest,
            ));
        }
        assert!(kept.len() < 400, "{}", kept.len());
        for (way, speed) in &overlay.points {
            let after = kept.partition_point(|p| p.0 < *way).clamp(1, kept.len() - 1);
            let (a, b) = (kept[after - 1], kept[after]);
            let there = a.1 + (b.1 - a.1) * ((way - a.0) / (b.0 - a.0)).clamp(0.0, 1.0);
            assert!((there - speed).abs() < 0.002 * fastest, "{way}: {there}, not {speed}");
        }
    }
}
