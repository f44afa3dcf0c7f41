//! C4 corners with acceleration 0 in their middle, and symmetric S-curves between.
//!
//! Written from what the Prunt motion controller publishes, with limits up to that of jerk (it has snap and crackle besides): every
//! corner is a curve of [`pythagorean`](super::pythagorean) as large as band and half the lines allow; the speed in its middle is
//! bound by the curvature k there, v <= (A / k)^(1/2) and v <= (J / k^2)^(1/3), and by what can be reached from the corners next to
//! it; from middle to middle the speed follows an S-curve that begins and ends with acceleration 0.
//!
//! That rule says nothing of what curvature and S-curve come to together, axis by axis. What breaks a limit of an axis is made
//! slower here, until all are kept: the speed of the corner, the limits of the S-curve, or both, whatever is faster, and smaller
//! corners are tried too. Or the S-curves keep to the lines and the speed is constant in the corners, where it is bound by their
//! third derivative (as with most corners of the literature); that is taken where it is faster.

use super::blend::{Corner, KEPT};
use super::line_path::{LinePath, limit, plus, times};
use super::ramp::{End, Phases, leg};
use crate::anymotion::motion::{Motion, State};
use anyhow::{Context, Result};
use splineway_simulator::scurve::{Limit, reachable};

/// Where S-curves begin and end.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Between {
    /// In the middle of the corners; and how much slower a corner, and a line, becomes by each look that finds a limit broken.
    Middles(f64, f64),
    /// At the ends of the corners.
    Corners,
}

/// All ways that are tried, and sizes of the corners as shares of what the band allows: the larger a corner, the longer it is
/// gone through at its low speed.
const WAYS: [Between; 3] =
    [Between::Corners, Between::Middles(0.98, 0.97), Between::Middles(0.97, 0.995)];
const SIZES: [f64; 2] = [1.0, 0.1];
/// Looks at the motion, and this often in a servo cycle; how much slower a corner becomes where the speed is constant.
const LOOKS: usize = 300;
const PER_CYCLE: usize = 2;
const STEADY: f64 = 0.995;
/// Places at which a corner of constant speed is looked at.
const PLACES: usize = 200;

/// Path and limits of what is run.
struct Plan<'a> {
    path: &'a LinePath,
    /// At the end of every line but the last.
    corners: Vec<Option<Corner>>,
    /// Speeds in the middle of them, mm/s.
    speeds: Vec<f64>,
    /// Limits of the S-curve of every line.
    limits: Vec<Limit>,
    between: Between,
}

impl<'a> Plan<'a> {
    fn new(path: &'a LinePath, between: Between, size: f64) -> Self {
        let corners: Vec<_> = (0..path.lines() - 1).map(|k| Corner::new(path, k, size)).collect();
        let limits = (0..path.lines()).map(|k| path.limit(k)).collect();
        let mut plan = Self { path, corners, speeds: Vec::new(), limits, between };
        plan.speeds = (0..path.lines() - 1).map(|k| plan.rule(k)).collect();
        plan
    }

    /// The speed of a corner by curvature.
    fn rule(&self, k: usize) -> f64 {
        let most = self.path.feeds[k].min(self.path.feeds[k + 1]);
        let Some(corner) = &self.corners[k] else {
            return if self.path.turn(k) < 1.0 { most } else { 0.0 };
        };
        let at = |way: f64| {
            let [_, _, second, third] = corner.derivatives(way);
            // Limits along the second and third derivative as they are, not as directions.
            let acceleration = limit(&second, &self.path.limits).acceleration;
            let jerk = limit(&third, &self.path.limits).jerk;
            (acceleration * KEPT).sqrt().min((jerk * KEPT).cbrt())
        };
        let whole = 2.0 * corner.half();
        match self.between {
            Between::Middles(..) => most.min(at(corner.half())),
            Between::Corners => {
                (0..=PLACES).map(|n| at(whole * n as f64 / PLACES as f64)).fold(most, f64::min)
            }
        }
    }

    /// Half the corner at the start, and at the end, of a line, mm.
    fn halves(&self, line: usize) -> [f64; 2] {
        let half =
            |k: usize| self.corners.get(k).and_then(Option::as_ref).map_or(0.0, Corner::half);
        [if line > 0 { half(line - 1) } else { 0.0 }, half(line)]
    }

    /// What a line loses at its start, and at its end, mm.
    fn reaches(&self, line: usize) -> [f64; 2] {
        let reach = |corner: &Corner| corner.size * corner.curve.reach;
        let of = |k: usize| self.corners.get(k).and_then(Option::as_ref).map_or(0.0, reach);
        [if line > 0 { of(line - 1) } else { 0.0 }, of(line)]
    }

    /// Length of what an S-curve runs.
    fn length(&self, line: usize) -> f64 {
        let straight = self.path.lengths[line] - self.reaches(line).iter().sum::<f64>();
        match self.between {
            Between::Middles(..) => straight + self.halves(line).iter().sum::<f64>(),
            Between::Corners => straight,
        }
    }

    /// Speeds at the ends of a line.
    fn ends(speeds: &[f64], line: usize) -> [f64; 2] {
        [if line > 0 { speeds[line - 1] } else { 0.0 }, speeds.get(line).copied().unwrap_or(0.0)]
    }

    /// Speeds that can be reached from each other, back and forth.
    fn reached(&self) -> Vec<f64> {
        let mut speeds = self.speeds.clone();
        let lines = self.path.lines();
        for k in (1..lines).rev() {
            let next = Self::ends(&speeds, k)[1];
            let most = speeds[k - 1];
            speeds[k - 1] = most.min(reachable(next, self.length(k), most, self.limits[k]));
        }
        for k in 0..lines - 1 {
            let before = Self::ends(&speeds, k)[0];
            let most = speeds[k];
            speeds[k] = most.min(reachable(before, self.length(k), most, self.limits[k]));
        }
        speeds
    }

    /// Way over time, and where each line's part of it begins: in the middle of a corner.
    fn schedule(&self) -> Result<(Motion, Vec<f64>)> {
        let speeds = self.reached();
        let mut motion = Motion::resting(&[0.0]);
        let mut begins = Vec::new();
        let mut way = 0.0;
        for k in 0..self.path.lines() {
            begins.push(way);
            let ends = Self::ends(&speeds, k).map(|speed| End { speed, rise: 0.0 });
            let phases = leg(ends, self.length(k), self.path.feeds[k], self.limits[k])
                .with_context(|| format!("line {k} has no room"))?;
            let steady = |half: f64, speed: f64| {
                let hold = self.between == Between::Corners && half > 0.0;
                if hold { (half, speed) } else { (0.0, speed) }
            };
            let [first, last] = self.halves(k);
            hold(&mut motion, &mut way, steady(first, ends[0].speed));
            let straight = self.length(k);
            follow(&mut motion, way, ends[0].speed, &phases);
            way += straight;
            hold(&mut motion, &mut way, steady(last, ends[1].speed));
        }
        Ok((motion, begins))
    }

    /// Position, derivatives by arc length, and the line, `off` mm behind the middle of the corner at the start of line `k`.
    fn place(&self, k: usize, off: f64) -> ([Vec<f64>; 4], Option<usize>) {
        let ([first, last], [from, to]) = (self.halves(k), self.reaches(k));
        let straight = self.path.lengths[k] - from - to;
        let curved = |corner: usize, way: f64| {
            let curve = self.corners[corner].as_ref()?;
            let mut derivatives = curve.derivatives(way);
            derivatives[0] = plus(&derivatives[0], 1.0, &self.path.points[corner + 1]);
            Some((derivatives, Some(corner)))
        };
        let found = if off < first {
            curved(k - 1, first + off)
        } else if off > first + straight && last > 0.0 {
            curved(k, off - first - straight)
        } else {
            None
        };
        found.unwrap_or_else(|| {
            let direction = self.path.directions[k].clone();
            let zero = vec![0.0; direction.len()];
            let at = plus(&self.path.points[k], from + (off - first).min(straight), &direction);
            ([at, direction, zero.clone(), zero], None)
        })
    }

    /// The state at a time, the jerk, and the corner that it is in, with the line of its S-curve.
    fn at(
        &self,
        schedule: &(Motion, Vec<f64>),
        time: f64,
    ) -> (State, Vec<f64>, Option<(usize, usize)>) {
        let (motion, begins) = schedule;
        let [s, v, a] = motion.at(time).map(|value| value[0]);
        let j = motion.jerk(time)[0];
        let k = begins.partition_point(|begin| *begin <= s).max(1) - 1;
        let ([x, d1, d2, d3], corner) = self.place(k, s - begins[k]);
        let velocity = times(v, &d1);
        let acceleration = plus(&times(a, &d1), v * v, &d2);
        let jerk = plus(&plus(&times(j, &d1), 3.0 * v * a, &d2), v * v * v, &d3);
        ([x, velocity, acceleration], jerk, corner.map(|corner| (corner, k)))
    }

    /// Makes slower what breaks a limit; whether there was any.
    fn look(&mut self, schedule: &(Motion, Vec<f64>)) -> bool {
        let (lines, step) = (self.path.lines(), self.path.cycle / PER_CYCLE as f64);
        let (mut corners, mut legs) = (vec![false; lines], vec![false; lines]);
        for n in 0..(schedule.0.duration() / step) as usize {
            let ([_, _, acceleration], jerk, place) = self.at(schedule, n as f64 * step);
            let Some((corner, line)) = place else { continue };
            let mut axes = self.path.limits.iter().zip(acceleration.iter().zip(&jerk));
            if axes.any(|(limit, (a, j))| {
                a.abs() > limit.acceleration * KEPT.sqrt() || j.abs() > limit.jerk * KEPT.sqrt()
            }) {
                (corners[corner], legs[line]) = (true, true);
            }
        }
        let (slower, calmer) = match self.between {
            Between::Middles(slower, calmer) => (slower, calmer),
            Between::Corners => (STEADY, 1.0),
        };
        for k in 0..lines {
            if corners[k] {
                self.speeds[k] *= slower;
            }
            if legs[k] {
                self.limits[k].acceleration *= calmer;
                self.limits[k].jerk *= calmer;
            }
        }
        corners.contains(&true)
    }
}

/// Adds a way at constant speed.
fn hold(motion: &mut Motion, way: &mut f64, (length, speed): (f64, f64)) {
    if length > 0.0 {
        *way += length;
        motion.advance(length / speed, [&[*way], &[speed], &[0.0]]);
    }
}

/// Adds an S-curve.
fn follow(motion: &mut Motion, from: f64, speed: f64, phases: &Phases) {
    let (mut x, mut v, mut a) = (from, speed, 0.0);
    for &(t, j) in phases {
        x += t * (v + t * (a / 2.0 + t * j / 6.0));
        v += t * (a + t * j / 2.0);
        a += t * j;
        motion.advance(t, [&[x], &[v], &[a]]);
    }
}

/// The states in every servo cycle of the fastest way, if it takes fewer than `most` cycles. The cost is that of a motion for every
/// time that something in it is made slower.
///
/// # Errors
/// A line on which no S-curve has room.
pub fn states(path: &LinePath, most: usize) -> Result<Option<Vec<State>>> {
    let (mut best, mut most) = (None, most);
    for (between, size) in WAYS.into_iter().flat_map(|way| SIZES.map(|size| (way, size))) {
        let mut plan = Plan::new(path, between, size);
        for _ in 0..LOOKS {
            let schedule = plan.schedule()?;
            // It only ever becomes slower.
            if schedule.0.duration() >= (most as f64 - 1.0) * path.cycle {
                break;
            }
            if !plan.look(&schedule) {
                let times = schedule.0.cycles(path.cycle);
                let states: Vec<State> = times.map(|time| plan.at(&schedule, time).0).collect();
                (most, best) = (states.len(), Some(states));
                break;
            }
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::others::tests::zigzag;

    /// In the middle of every corner the acceleration along the path is 0, and the speed is what curvature allows at most.
    #[test]
    fn no_acceleration_in_the_middle() {
        let path = zigzag();
        let plan = Plan::new(&path, WAYS[1], 1.0);
        let (motion, begins) = plan.schedule().unwrap();
        for begin in &begins[1..] {
            let time = motion.time[motion.position.partition_point(|way| *way < begin - 1e-6)];
            let [_, v, a] = motion.at(time).map(|value| value[0]);
            assert!(a.abs() < 1e-3 && v > 1.0, "{v} mm/s, {a} mm/s2");
            let corner = plan.corners[0].as_ref().unwrap();
            let bend =
                corner.derivatives(corner.half())[2].iter().map(|x| x * x).sum::<f64>().sqrt();
            assert!(v <= (50_000.0 / (bend * bend)).cbrt() * 1.001, "{v} mm/s at {bend} / mm");
        }
    }
}
