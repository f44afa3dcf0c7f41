//! What the moves of a program ask for.

use splineway_simulator::machine::{Axis, is_rotary};
use splineway_simulator::program::arc::Spiral;
use splineway_simulator::program::{Course, Move, Point, Speed, Tape, on_cubic};
use std::collections::BTreeMap;

/// Lines shorter than this, mm, are left out by the core.
pub const NOTHING: f64 = 0.5e-6;

/// What a move asks for, and what the axes let a line have, mm/s.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// What is asked for.
    pub wanted: f64,
    /// What the axes let a line have.
    pub most: f64,
}

/// What a move from `here` asks for.
pub fn asked(step: &Move, here: &Point, axes: &[usize], limits: &[Axis]) -> Asked {
    let way = length(here, &step.path, axes);
    let mut most = f64::INFINITY;
    if let Course::Line { to } = &step.path {
        if way < NOTHING {
            return Asked { wanted: 0.0, most };
        }
        let moved = axes.iter().zip(limits);
        most = moved
            .map(|(&axis, limit)| limit.velocity * way / (to[axis] - here[axis]).abs().max(1e-12))
            .fold(f64::INFINITY, f64::min);
    }
    let wanted = match step.speed {
        Speed::PerSecond(feed) => feed,
        Speed::Duration(seconds) => way / seconds,
        Speed::Rapid => most,
    };
    Asked { wanted, most }
}

/// Feed of a line that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineFeed {
    /// Line of the file.
    pub line: u32,
    /// What is asked for, mm/s; of a rapid, what the axes allow.
    pub wanted: f64,
    /// The same as far as the axes allow.
    pub possible: f64,
    /// G0.
    pub rapid: bool,
    /// Whether all axes are meant: not the linear ones alone.
    pub whole: bool,
}

/// Feeds of the lines that move, in their order; of a line with several moves the greatest.
pub fn feeds(program: &dyn Tape, limits: &[Axis]) -> Vec<LineFeed> {
    let axes = program.axes();
    let mut lines: BTreeMap<u32, LineFeed> = BTreeMap::new();
    let mut here = program.start();
    for step in program.steps() {
        let Some(to) = step.path.end() else { continue };
        let Asked { wanted, most } = asked(&step, &here, &axes, limits);
        let linear =
            |axis: &&usize| !is_rotary(**axis) && (to[**axis] - here[**axis]).abs() > NOTHING;
        let turns =
            matches!(step.path, Course::Line { .. }) && !axes.iter().any(|axis| linear(&axis));
        let feed = LineFeed {
            line: step.line,
            wanted,
            possible: wanted.min(most),
            rapid: step.speed == Speed::Rapid,
            whole: turns || matches!(step.speed, Speed::Duration(_)),
        };
        let other = lines.entry(step.line).or_insert(feed);
        if feed.possible > other.possible {
            *other = feed;
        }
        here = *to;
    }
    lines.into_values().collect()
}

fn distance(a: &Point, b: &Point, axes: &[usize]) -> f64 {
    axes.iter().map(|&axis| (b[axis] - a[axis]).powi(2)).sum::<f64>().sqrt()
}

/// Length of a move, mm; of a curve, of its chords.
pub fn length(here: &Point, course: &Course, axes: &[usize]) -> f64 {
    match course {
        Course::Line { to } => distance(here, to, axes),
        Course::Dwell { .. } | Course::Event { .. } => 0.0,
        Course::Cubic { controls, to } => {
            let mut before = *here;
            (1..=16u32)
                .map(|k| {
                    let at = on_cubic(here, controls, to, f64::from(k) / 16.0);
                    distance(&std::mem::replace(&mut before, at), &at, axes)
                })
                .sum()
        }
        Course::Arc { .. } => Spiral::of(course, here).map_or(0.0, |arc| arc.length(axes)),
    }
}
