//! Constant jerk throughout, with speed and acceleration carried over the ends of the blocks.
//!
//! Written from Tajima and Sencer, "Global tool-path smoothing for CNC machine tools with uninterrupted acceleration" (2017), and
//! their "Kinematic corner smoothing for high speed machine tools" (2016): near a corner the axes are not led along a curve, but
//! each from its speed and acceleration on one line to those on the other, in the same time, with phases of constant jerk. The
//! motion comes in while it still slows down and leaves while it already speeds up, so that the acceleration is not interrupted.
//! Between the corners are seven phases (as Ruckig finds them, or TinyG, which ends its blocks with acceleration 0).
//!
//! What is ours: corners are symmetric, in at (v, -a) and out at (v, a), with two phases of jerk; for every corner some pairs (v,
//! a) are made that keep the limits of every axis and the band, and the best of them all over the path are found by dynamic
//! programming, so that the look-ahead is longer than that of any controller.

use super::exact_stop::along;
use super::line_path::{LinePath, plus, times};
use super::ramp::{End, Phases, duration, leg};
use crate::anymotion::motion::Motion;
use anyhow::{Context, Result};
use splineway_simulator::machine::Axis;

/// Accelerations that are tried at corners, shares of the limit.
const RISES: [f64; 9] = [0.0, 0.15, 0.3, 0.45, 0.6, 0.7, 0.8, 0.9, 1.0];
/// Speeds, shares of the greatest with that acceleration.
const SPEEDS: [f64; 3] = [1.0, 0.75, 0.5];
/// Steps of the search for the greatest speed, and halvings of the last.
const STEPS: i32 = 60;
const HALVINGS: usize = 30;
/// Less is no turn, rad; with more the axis goes back, and stops.
const TURNS: (f64, f64) = (1.0e-9, 3.0);
/// What is kept of limits and band against rounding.
const KEPT: f64 = 1.0 - 1.0e-6;

/// A way through a corner.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    end: End,
    /// s.
    time: f64,
    /// Jerks across the corner and along its chord, mm/s3.
    across: f64,
    chord: f64,
    /// What it takes of either line, mm.
    length: f64,
}

/// The place of a corner.
struct Place<'a> {
    limits: &'a [Axis],
    /// Unit vectors: across (to the inside), and along the chord.
    across: Vec<f64>,
    chord: Vec<f64>,
    /// Sine and cosine of half the turn.
    sine: f64,
    cosine: f64,
    /// What it may take of either line, and leave them by, mm.
    room: f64,
    band: f64,
    /// Greatest speed and acceleration along both lines.
    speed: f64,
    rise: f64,
}

impl<'a> Place<'a> {
    /// The corner at the end of a line; `None` if it can only be a stop.
    fn new(path: &'a LinePath, line: usize) -> Option<Self> {
        let turn = path.turn(line);
        if turn > TURNS.1 {
            return None;
        }
        let (a, b) = (&path.directions[line], &path.directions[line + 1]);
        let (sine, cosine) = ((turn / 2.0).sin(), (turn / 2.0).cos());
        let across =
            if turn > TURNS.0 { times(0.5 / sine, &plus(b, -1.0, a)) } else { vec![0.0; a.len()] };
        Some(Self {
            limits: &path.limits,
            across,
            chord: times(0.5 / cosine, &plus(b, 1.0, a)),
            sine,
            cosine,
            room: path.lengths[line].min(path.lengths[line + 1]) / 2.0,
            band: path.bands[line + 1] * KEPT,
            speed: path.feeds[line].min(path.feeds[line + 1]),
            rise: path.limit(line).acceleration.min(path.limit(line + 1).acceleration) * KEPT,
        })
    }

    /// Jerks that lead from (v, -a) to (v, a) in a time, in two halves with opposite jerk across.
    fn jerks(&self, end: End, time: f64) -> (f64, f64) {
        let gain = self.sine * (2.0 * end.speed - end.rise * time);
        (4.0 * gain / (time * time), 2.0 * end.rise * self.cosine / time)
    }

    /// Whether the axes can do that; if so, they can in a longer time.
    fn can(&self, end: End, time: f64) -> bool {
        let (across, chord) = self.jerks(end, time);
        let middle = self.sine * end.rise + across * time / 2.0;
        let axes = self.limits.iter().zip(&self.across).zip(&self.chord);
        axes.into_iter().all(|((limit, n), b)| {
            n.abs() * across + b.abs() * chord <= limit.jerk * KEPT
                && n.abs() * middle <= limit.acceleration * KEPT
        })
    }

    /// The shortest way through with an end, if there is one within the band and the lines.
    fn through(&self, end: End) -> Option<Corner> {
        // Later the jerk across would have to be the other way; and the lines are over.
        let whole = 4.0 * self.room / end.speed;
        let most = if end.rise > 0.0 { whole.min(2.0 * end.speed / end.rise) } else { whole };
        if !self.can(end, most) {
            return None;
        }
        let (mut low, mut time) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, time);
            if self.can(end, middle) { time = middle } else { low = middle }
        }
        let (across, chord) = self.jerks(end, time);
        let length = time * (end.speed / 2.0 - end.rise * time / 12.0);
        // Half way, from the corner to the inside; the lines are nearer by the cosine.
        let apex = time * time * (self.sine * end.rise / 24.0 + across * time / 48.0);
        let inside = apex * self.cosine <= self.band && length <= self.room;
        inside.then_some(Corner { end, time, across, chord, length })
    }

    /// The fastest way through with an acceleration.
    fn fastest(&self, rise: f64) -> Option<Corner> {
        let speed = |step: i32| self.speed * 0.9f64.powi(step);
        let through = |speed: f64| self.through(End { speed, rise });
        let step = (0..STEPS).find(|&step| through(speed(step)).is_some())?;
        let mut found = through(speed(step));
        if step > 0 {
            let (mut low, mut high) = (speed(step), speed(step - 1));
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(low, high);
                if let Some(corner) = through(middle) {
                    (low, found) = (middle, Some(corner));
                } else {
                    high = middle;
                }
            }
        }
        found
    }

    /// Ways through that the search chooses from.
    fn choice(&self) -> Vec<Corner> {
        let mut all = Vec::new();
        for share in RISES {
            let Some(fastest) = self.fastest(self.rise * share) else { continue };
            let End { speed, rise } = fastest.end;
            let slower = |share: &f64| self.through(End { speed: speed * share, rise });
            all.push(fastest);
            all.extend(SPEEDS[1..].iter().filter_map(slower));
        }
        all
    }
}

/// The phases of a line between two ways through its corners.
fn between(path: &LinePath, line: usize, from: &Corner, to: &Corner) -> Option<Phases> {
    let length = path.lengths[line] - from.length - to.length;
    leg([from.end, to.end], length, path.feeds[line], path.limit(line))
}

/// The ways through all corners that take the least time together, rest at both ends, and that time: dynamic programming.
fn best(path: &LinePath) -> (f64, Vec<Corner>) {
    let rest = Corner::default();
    let mut choices = vec![vec![rest]];
    for k in 0..path.lines() - 1 {
        let mut choice = vec![rest];
        choice.extend(Place::new(path, k).iter().flat_map(Place::choice));
        choices.push(choice);
    }
    choices.push(vec![rest]);
    let mut times = vec![0.0];
    let mut back = Vec::new();
    for k in 0..path.lines() {
        let mut next = vec![(f64::INFINITY, 0); choices[k + 1].len()];
        for (to, least) in choices[k + 1].iter().zip(&mut next) {
            for (n, (from, time)) in choices[k].iter().zip(&times).enumerate() {
                // What is behind already is not worth a look.
                if *time >= least.0 {
                    continue;
                }
                let Some(phases) = between(path, k, from, to) else { continue };
                let sum = time + duration(&phases) + to.time;
                if sum < least.0 {
                    *least = (sum, n);
                }
            }
        }
        times = next.iter().map(|(time, _)| *time).collect();
        back.push(next.into_iter().map(|(_, from)| from).collect::<Vec<usize>>());
    }
    let mut chosen = vec![rest];
    let mut n = 0;
    for k in (0..path.lines()).rev() {
        n = back[k][n];
        chosen.push(choices[k][n]);
    }
    chosen.reverse();
    (times[0], chosen)
}

/// The motion. The cost of a line is some 800 times seven phases.
///
/// # Errors
/// None for lines of some length.
pub fn motion(path: &LinePath) -> Result<Motion> {
    let (_, corners) = best(path);
    let mut motion = Motion::resting(&path.points[0]);
    for k in 0..path.lines() {
        let (from, to) = (&corners[k], &corners[k + 1]);
        let phases = between(path, k, from, to).context("a line has no length")?;
        let start = plus(&path.points[k], from.length, &path.directions[k]);
        along(&mut motion, &start, &path.directions[k], from.end, &phases);
        if let Some(place) = (k + 1 < path.lines()).then(|| Place::new(path, k)).flatten() {
            turn(&mut motion, &place, to, &path.directions[k], &path.points[k + 1]);
        }
    }
    Ok(motion)
}

/// Adds the two phases of a corner.
fn turn(motion: &mut Motion, place: &Place<'_>, corner: &Corner, into: &[f64], vertex: &[f64]) {
    let half = corner.time / 2.0;
    let mut x = plus(vertex, -corner.length, into);
    let mut v = times(corner.end.speed, into);
    let mut a = times(-corner.end.rise, into);
    for sign in [1.0, -1.0] {
        let j = plus(&times(sign * corner.across, &place.across), corner.chord, &place.chord);
        x = plus(&plus(&plus(&x, half, &v), half * half / 2.0, &a), half.powi(3) / 6.0, &j);
        v = plus(&plus(&v, half, &a), half * half / 2.0, &j);
        a = plus(&a, half, &j);
        motion.advance(half, [&x, &v, &a]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::others::tests::zigzag;

    /// A right angle along the axes, where the one ends its S-curve while the other begins: v = a^2 / (2 J), T = a / J,
    /// and the apex leaves the lines by a^3 / (48 J^2).
    #[test]
    fn one_axis_ends_while_the_other_begins() {
        let mut path = zigzag();
        (path.directions[0], path.directions[1]) = (vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0]);
        let (a, j): (f64, f64) = (1500.0, 50_000.0);
        let off = a.powi(3) / (48.0 * j * j);
        for (share, found) in [(0.99, false), (1.01, true)] {
            path.bands[1] = off * share;
            let place = Place::new(&path, 0).unwrap();
            let corner = place.through(End { speed: a * a / (2.0 * j) * (1.0 + 1e-5), rise: a });
            assert_eq!(corner.is_some(), found);
            if let Some(corner) = corner {
                assert!((corner.time - a / j).abs() < 1e-4 * a / j, "{}", corner.time);
                assert!(corner.across.abs() < 1e-2 * j);
            }
        }
    }

    /// Out of the corner with the speed, acceleration and on the line that the next block begins with.
    #[test]
    fn corners_end_on_the_next_line() {
        let path = zigzag();
        let place = Place::new(&path, 0).unwrap();
        for corner in place.choice() {
            let mut motion = Motion::resting(&path.points[0]);
            turn(&mut motion, &place, &corner, &path.directions[0], &path.points[1]);
            let [x, v, a] = motion.at(motion.duration());
            let next = &path.directions[1];
            let gap = |a: &[f64], b: &[f64]| crate::others::line_path::apart(a, b);
            assert!(gap(&x, &plus(&path.points[1], corner.length, next)) < 1e-9);
            assert!(gap(&v, &times(corner.end.speed, next)) < 1e-6);
            assert!(gap(&a, &times(corner.end.rise, next)) < 1e-6);
        }
    }
}
