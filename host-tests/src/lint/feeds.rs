//! What the moves of a program ask for.

use splineway_simulator::machine::{Axis, is_rotary};
use splineway_simulator::program::arc::Spiral;
use splineway_simulator::program::{Course, Move, Point, Speed, on_cubic};

/// Lines shorter than this, mm, are left out by the core.
pub const NOTHING: f64 = 0.5e-6;

/// What a move asks for. Speeds are over the axes that a feed word is for: the linear ones, or all if none of them moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// What is asked for, mm/s; of a rapid, what the axes allow.
    pub wanted: f64,
    /// What the axes let a line have, mm/s.
    pub most: f64,
    /// G0, or no move at all.
    pub rapid: bool,
    /// Whether no linear axis moves.
    pub turns: bool,
}

impl Asked {
    /// Of what goes nowhere.
    pub const NOTHING: Self =
        Self { wanted: f64::INFINITY, most: f64::INFINITY, rapid: true, turns: false };

    /// What is asked for as far as the axes allow, mm/s.
    pub const fn possible(&self) -> f64 {
        self.wanted.min(self.most)
    }
}

/// What a move from `here` asks for.
pub fn asked(step: &Move, here: &Point, axes: &[usize], limits: &[Axis]) -> Asked {
    let linear: Vec<usize> = axes.iter().copied().filter(|axis| !is_rotary(*axis)).collect();
    let straight = length(here, &step.path, &linear);
    let turns = straight < NOTHING && step.path.end().is_some();
    let way = if turns { length(here, &step.path, axes) } else { straight };
    let mut most = f64::INFINITY;
    let rapid = step.speed == Speed::Rapid;
    if let Course::Line { to } = &step.path {
        if way < NOTHING {
            return Asked { wanted: 0.0, most, rapid, turns };
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
    Asked { wanted, most, rapid, turns }
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
