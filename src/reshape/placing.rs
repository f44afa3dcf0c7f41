//! Which line of the path the agreed motion is in when.
//!
//! The motion keeps the band of every line, and bands overlap: near a corner, and all along a path that nearly turns back on itself or
//! whose lines are shorter than the band is wide. So the nearest line says little. But joints are passed one after the other, each
//! where the motion comes near to it, and it goes along its lines, not against them; the lines that cost least in all places of a stretch together, from a line that is known on, are found
//! by dynamic programming.

use super::vector::{along, dot, minus, square};
use super::way::{Line, passes};
use crate::number::Scalar;

/// Lines that are looked at in a place: bits of a word.
const LOOKED: usize = u64::BITS as usize;
/// Of those, so many lie before the one that is the most likely.
const BEHIND: usize = LOOKED / 4;
/// From what share of the band on a place counts as outside, and what it costs then, by the share.
const OUTSIDE: (f64, f64) = (1.02, 1.0e3);
/// The same of a joint that is passed: a turn of 165 degrees may be cut off by about so much.
const MISSED: (f64, f64) = (8.0, 1.0e3);
/// A joint's distance counts so many times as much as one from a line: a motion that turns back stays near both lines for many
/// places, and near the joint for few.
const JOINT: f64 = 4.0;
/// What costs so much more than the best is left out.
const HOPELESS: f64 = 1.0e4;
/// No cost.
const NEVER: f64 = 1.0e30;

/// The lines of up to `P` places of a motion, a fixed time apart.
///
/// `P` times 16 bytes.
#[derive(Clone, Debug)]
pub struct Places<S, const P: usize> {
    /// s.
    step: S,
    count: usize,
    /// While they are looked for: the first that is looked at.
    lines: [usize; P],
    /// The lines, from the first that is looked at on, that are come to from the one before in the same place.
    passed: [u64; P],
    /// While they are looked for: up to when, s, the line that is the most likely at the last of them, and what each costs there.
    end: S,
    likely: usize,
    costs: [S; LOOKED],
}

impl<S: Scalar, const P: usize> Places<S, P> {
    /// None, no time apart: all zeros.
    pub const NONE: Self = Self::new(S::ZERO);

    /// None; one every `step` s.
    pub const fn new(step: S) -> Self {
        let (lines, passed) = ([0; P], [0; P]);
        Self { step, count: 0, lines, passed, end: S::ZERO, likely: 0, costs: [S::ZERO; LOOKED] }
    }

    /// None; one every `step` s.
    pub fn set_step(&mut self, step: S) {
        (self.step, self.count) = (step, 0);
    }

    /// Finds those of a motion that begins in the line `first`; `at` is the place that it has come to after a time, s, up to `end`.
    ///
    /// Cost: the distance from at most 64 lines and 64 joints for each of `P` places; as a rule from a few.
    pub fn find<const N: usize>(
        &mut self,
        lines: &[Line<S, N>],
        first: usize,
        end: S,
        at: impl Fn(S) -> [S; N],
    ) {
        self.begin(first, end);
        self.go_on(lines, P, at);
    }

    /// Begins with that.
    pub fn begin(&mut self, first: usize, end: S) {
        self.costs = [S::of(NEVER); LOOKED];
        self.costs[0] = S::ZERO;
        (self.end, self.likely, self.count) = (end, first, 0);
    }

    /// Goes on with it, by at most `most` places. Whether all are found.
    pub fn go_on<const N: usize>(
        &mut self,
        lines: &[Line<S, N>],
        most: usize,
        at: impl Fn(S) -> [S; N],
    ) -> bool {
        if P == 0 || self.likely >= lines.len() {
            self.count = 0;
            return true;
        }
        if self.count == 0 {
            (self.lines[0], self.passed[0], self.count) = (self.likely, 0, 1);
        }
        let never = S::of(NEVER);
        let time = |k: usize| S::from_u32(k as u32) * self.step;
        let mut before = at(time(self.count - 1));
        for _ in 0..most {
            let k = self.count;
            // One place behind the end, so that every time up to it has one.
            if k == P || time(k) > self.end + self.step {
                self.trace(self.likely);
                return true;
            }
            let x = at(time(k));
            let mut base = self.lines[k - 1];
            let ahead = self.likely.saturating_sub(BEHIND).max(base) - base;
            base += ahead;
            let costs = &mut self.costs;
            costs.copy_within(ahead.min(LOOKED).., 0);
            costs[LOOKED - ahead.min(LOOKED)..].fill(never);
            let kept = costs.iter().fold(never, |least, cost| least.least(*cost));
            let reached = costs.iter().rposition(|cost| *cost < never).unwrap_or(0);
            let mut passed = 0u64;
            // What it costs to have come to the line, the place itself left out.
            let mut came = never;
            let mut least = never;
            for (q, cost) in costs.iter_mut().enumerate() {
                let Some(line) = lines.get(base + q) else { break };
                if q > 0 {
                    came = came + missed(&lines[base + q - 1], line, &before, &x);
                }
                if came < *cost {
                    passed |= 1 << q;
                } else {
                    came = *cost;
                }
                if came > kept + S::of(HOPELESS) {
                    *cost = never;
                    if q > reached {
                        break;
                    }
                    continue;
                }
                *cost = came + off(line, &before, &x);
                if *cost < least {
                    (least, self.likely) = (*cost, base + q);
                }
            }
            self.lines[k] = base;
            self.passed[k] = passed;
            self.count = k + 1;
            before = x;
        }
        false
    }

    /// From the last place back.
    fn trace(&mut self, mut line: usize) {
        for k in (0..self.count).rev() {
            let base = self.lines[k];
            self.lines[k] = line;
            // To the line that it had before the place: those which were passed there are not taken back twice.
            let own = line.saturating_sub(base).min(LOOKED - 1);
            let others = !(self.passed[k] << (LOOKED - 1 - own));
            line -= (others.leading_zeros() as usize).min(own);
        }
    }

    /// The line in which the motion is after a time, s, at `x`; none where it has not been looked for.
    pub fn line<const N: usize>(&self, lines: &[Line<S, N>], time: S, x: &[S; N]) -> Option<usize> {
        let k = (time / self.step).greatest(S::ZERO).to_i64() as usize;
        let [from, to] = self.lines[..self.count].get(k..k + 2)? else { return None };
        // In between: by the planes in which both lines are equally near.
        Some(passes(&lines[..lines.len().min(to + 1)], *from, x))
    }
}

/// What a place costs in a line, with the way that leads to it from another.
fn off<S: Scalar, const N: usize>(line: &Line<S, N>, from: &[S; N], x: &[S; N]) -> S {
    let square = line.foot(x).square / (line.band * line.band);
    let back = -dot(&minus(x, from), &line.direction) / line.band;
    let cost = square + back.greatest(S::ZERO);
    if square > S::of(OUTSIDE.0 * OUTSIDE.0) {
        cost + S::of(OUTSIDE.1) * square.sqrt()
    } else {
        cost
    }
}

/// What it costs to pass from a line to the next on the way from one place to another.
fn missed<S: Scalar, const N: usize>(
    line: &Line<S, N>,
    next: &Line<S, N>,
    from: &[S; N],
    to: &[S; N],
) -> S {
    let band = line.band.greatest(next.band);
    let (way, joint) = (minus(to, from), minus(&next.from, from));
    let long = square(&way);
    let share = if long > S::ZERO { dot(&joint, &way) / long } else { S::ZERO };
    let share = share.greatest(S::ZERO).least(S::ONE);
    let square = square(&along(&joint, -share, &way)) / (band * band);
    let cost = S::of(JOINT) * square;
    if square > S::of(MISSED.0 * MISSED.0) { cost + S::of(MISSED.1) * square.sqrt() } else { cost }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const N: usize = 2;
    const STEP: f64 = 2.0e-3;

    fn path(points: &[[f64; N]], band: f64) -> Vec<Line<f64, N>> {
        points
            .windows(2)
            .map(|pair| {
                let off = minus(&pair[1], &pair[0]);
                let length = square(&off).sqrt();
                let direction = off.map(|x| x / length);
                Line { from: pair[0], direction, length, band, feed: 100.0 }
            })
            .collect()
    }

    /// The place at an arc length, and its line.
    fn place(lines: &[Line<f64, N>], way: f64) -> ([f64; N], usize) {
        let (mut left, mut q) = (way, 0);
        while q + 1 < lines.len() && left > lines[q].length {
            left -= lines[q].length;
            q += 1;
        }
        (along(&lines[q].from, left.min(lines[q].length), &lines[q].direction), q)
    }

    #[test]
    fn a_motion_that_is_nearer_to_the_way_back_has_not_turned_yet() {
        let (long, angle) = (20.0, 0.014f64);
        let end = [long - long * angle.cos(), long * angle.sin()];
        let lines = path(&[[0.0; N], [long, 0.0], end], 0.05);
        let mut places = Places::<f64, 256>::new(STEP);
        let speed = 50.0;
        let at = |time: f64| {
            let way = 15.0 + speed * time;
            let ([x, y], _) = place(&lines, way);
            // Nearly at the way back on the way there, and midway between both on that.
            let off = long - x;
            let bent =
                if off < 4.0 { off * angle * if way < long { 0.9 } else { -0.5 } } else { y };
            [x, if way < long { bent } else { y + bent.min(0.0) }]
        };
        places.find(&lines, 0, 0.4, at);
        for k in 0..400 {
            let time = f64::from(k) * 1.0e-3;
            let off = speed * time - 5.0;
            let line = places.line(&lines, time, &at(time)).unwrap();
            if off.abs() > 0.4 {
                assert_eq!(line, usize::from(off > 0.0), "{off} mm behind the turn");
            }
        }
    }

    #[test]
    fn lines_are_found_by_the_way_that_was_gone() {
        let mut state = 1u32;
        let mut random = |from: f64, to: f64| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            from + (to - from) * f64::from(state >> 8) / f64::from(1 << 24)
        };
        for case in 0..300 {
            let band = random(0.01, 0.1);
            let (mut points, mut heading) = (std::vec![[0.0; N]], 0.0f64);
            let (short, longest) = [(0.5, 3.0), (2.0, 40.0), (40.0, 200.0)][case % 3];
            for k in 0..200 {
                let length = band * random(short, longest);
                points.push([
                    points[k][0] + length * heading.cos(),
                    points[k][1] + length * heading.sin(),
                ]);
                // As a rule gently; at times straight back.
                heading +=
                    if random(0.0, 1.0) < 0.1 { random(2.9, 3.3) } else { random(-1.0, 1.0) };
            }
            let lines = path(&points, band);
            let (speed, swing) = (random(2.0, 100.0), random(0.0, 0.5) * band);
            let whole: f64 = lines.iter().map(|line| line.length).sum();
            let (mut from, mut first) = (0.0, 0);
            let mut places = Places::<f64, 128>::new(STEP);
            while from < whole {
                let at = |time: f64| {
                    let (x, q) = place(&lines, from + speed * time);
                    let [c, s] = lines[q].direction;
                    let off = swing * (40.0 * (from + speed * time)).sin();
                    [x[0] - s * off, x[1] + c * off]
                };
                places.find(&lines, first, 0.1, at);
                for k in 0..100 {
                    let time = f64::from(k) * 1.0e-3;
                    let (.., q) = place(&lines, from + speed * time);
                    let found = places.line(&lines, time, &at(time)).unwrap();
                    let between = &lines[found.min(q)..=found.max(q)];
                    // All but the two that the places are in.
                    let inner = between.len().saturating_sub(2);
                    let apart: f64 = between.iter().skip(1).take(inner).map(|l| l.length).sum();
                    assert!(
                        apart <= 8.0 * band + 2.0 * speed * STEP,
                        "{case}: line {found} of {q}, {apart} mm of {band} mm off"
                    );
                }
                // What the next stretch begins in.
                (first, from) =
                    (places.line(&lines, 0.08, &at(0.08)).unwrap(), from + 0.08 * speed);
            }
        }
    }

    #[test]
    fn lines_beyond_the_places_are_not_known() {
        let lines = path(&[[0.0; N], [1.0, 0.0], [1.0, 1.0]], 0.05);
        let mut places = Places::<f64, 8>::new(STEP);
        let at = |time: f64| [time, 0.0];
        places.find(&lines, 0, 1.0, at);
        assert_eq!(places.line(&lines, 6.9 * STEP, &at(6.9 * STEP)), Some(0));
        assert_eq!(places.line(&lines, 7.1 * STEP, &at(7.1 * STEP)), None);
        places.find(&lines, 0, 2.5 * STEP, at);
        assert_eq!(places.line(&lines, 2.5 * STEP, &at(2.5 * STEP)), Some(0));
        assert_eq!(places.line(&lines, 4.5 * STEP, &at(4.5 * STEP)), None);
        places.find(&lines, 2, 1.0, at);
        assert_eq!(places.line(&lines, 0.0, &at(0.0)), None);
    }
}
