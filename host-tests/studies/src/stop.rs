//! The shortest stop within the limits of the axes, on the path that was run.
//!
//! What was run, x(tau), is run again with another clock: w = (d tau / d t)^2 over tau. Then
//!   x_tt  = x'' w + x' w' / 2
//!   x_ttt = (x''' w + 3 x'' w' / 2 + x' w'' / 2) w^1/2
//! are linear in w but for the last factor, so that the limits of jerk are |...| <= J w^-1/2: their right side
//! is convex and taken by its tangent, which lies below, at the result of the round before. Each round is a linear
//! program (clarabel) whose result keeps all limits at the servo cycles. w = 1, the motion as it was, always does.
//! Limits are held only there, and a stop ends at a small speed, so the result is on the optimistic side, by up to 8 ms.

use crate::rows::Rows;
use anyhow::{Context, Result};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{NonnegativeConeT, ZeroConeT};

/// Servo cycles looked at.
const HORIZON: usize = 350;
/// Linear programs.
const ROUNDS: usize = 6;
/// Standing still is less, mm/s.
const STILL: f64 = 0.3;
/// Least w in a tangent.
const LEAST: f64 = 1.0e-6;

/// Limits of an axis: acceleration, mm/s2, and jerk, mm/s3.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Acceleration.
    pub acceleration: f64,
    /// Jerk.
    pub jerk: f64,
}

/// What was run at a servo cycle.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Velocities of the axes, mm/s.
    pub velocity: Vec<f64>,
    /// Accelerations, mm/s2.
    pub acceleration: Vec<f64>,
}

/// Least time, s, from the first of some moments, `cycle` seconds apart, until the path speed is at most `goal` mm/s (or the machine stands still);
/// `None` if it takes longer than what was run.
///
/// # Errors
/// A program that the solver cannot solve.
pub fn shortest(run: &[Moment], cycle: f64, limits: Limits, goal: f64) -> Result<Option<f64>> {
    let run = &run[..run.len().min(HORIZON + 1)];
    let n = run.len();
    if n < 4 {
        return Ok(None);
    }
    let goal = goal.max(STILL);
    let speeds: Vec<f64> = run
        .iter()
        .map(|moment| moment.velocity.iter().map(|v| v * v).sum::<f64>().sqrt())
        .collect();
    let mut w = vec![1.0f64; n];
    let mut least = None;
    for _ in 0..ROUNDS {
        let mut rows = Rows::default();
        // As before the command, in value and slope.
        rows.push([(0, 1.0)], 1.0);
        rows.push([(1, 1.0)], 1.0);
        let fixed = rows.len();
        // Excess over the goal: n more unknowns.
        for i in 0..n {
            let square = speeds[i] * speeds[i];
            let scale = speeds[0] * speeds[0] + 1.0;
            rows.push_scaled([(i, square), (n + i, -scale)], goal * goal, scale);
            rows.push_scaled([(n + i, -1.0)], 0.0, 1.0);
            rows.push_scaled([(i, -1.0)], 0.0, 1.0);
            rows.push([(i, 1.0)], 1.0);
        }
        for i in 1..n - 1 {
            for k in 0..run[i].velocity.len() {
                let (v, a) = (run[i].velocity[k], run[i].acceleration[k]);
                let j = (run[i + 1].acceleration[k] - a) / cycle;
                if v.abs() < 1.0e-6 && a.abs() < 1.0e-3 && j.abs() < 1.0 {
                    continue;
                }
                let first = [(i - 1, -0.5 / cycle), (i + 1, 0.5 / cycle)];
                let per = 1.0 / (cycle * cycle);
                let second = [(i - 1, per), (i, -2.0 * per), (i + 1, per)];
                let acceleration = |sign: f64| {
                    let slopes = first.map(|(at, x)| (at, sign * 0.5 * v * x));
                    [(i, sign * a)].into_iter().chain(slopes)
                };
                let most = limits.acceleration.max(a.abs()) * 1.002;
                let (jerk, root) = (limits.jerk.max(j.abs()) * 1.002, w[i].max(LEAST).sqrt());
                let tangent = jerk * 0.5 / (root * root * root);
                for sign in [1.0, -1.0] {
                    rows.push(acceleration(sign), most);
                    let slopes = first.map(|(at, x)| (at, sign * 1.5 * a * x));
                    let bends = second.map(|(at, x)| (at, sign * 0.5 * v * x));
                    let own = [(i, sign * j + tangent)];
                    let entries = own.into_iter().chain(slopes).chain(bends);
                    rows.push_scaled(entries, 1.5 * jerk / root, jerk / root);
                }
            }
        }
        let objective = CscMatrix::spalloc((2 * n, 2 * n), 0);
        // Down to the goal first of all; below it what is slower costs a little.
        let linear: Vec<f64> = (0..2 * n).map(|i| if i < n { 1.0e-4 } else { 1.0 }).collect();
        let cones = [ZeroConeT(fixed), NonnegativeConeT(rows.len() - fixed)];
        let x = rows.minimise(&objective, &linear, &cones).context("the shortest stop")?;
        for (w, x) in w.iter_mut().zip(&x) {
            *w = x.clamp(0.0, 1.0);
        }
        let there = (0..n).find(|&i| speeds[i] * w[i].sqrt() <= goal * 1.001);
        let time = |end: usize| {
            let means = w.windows(2).take(end).map(|w| f64::midpoint(w[0], w[1]).max(1.0e-9));
            means.map(|w| cycle / w.sqrt()).sum::<f64>()
        };
        least = there.map(time).or(least);
    }
    Ok(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { acceleration: 2000.0, jerk: 50_000.0 };

    fn steady(speed: f64) -> Vec<Moment> {
        vec![Moment { velocity: vec![speed * 0.6, speed * 0.8], acceleration: vec![0.0; 2] }; 400]
    }

    /// On a straight line at constant speed: v / A + A / J, with the limits of the axis that has most of it.
    #[test]
    fn a_straight_stop_takes_what_it_must() {
        let share = 1.0 / 0.8;
        let (acceleration, jerk) = (LIMITS.acceleration * share, LIMITS.jerk * share);
        let build_up = acceleration / jerk;
        // At rest the acceleration is gone too; a speed is passed with all of it.
        for (goal, exact) in
            [(0.0, 150.0 / acceleration + build_up), (75.0, 75.0 / acceleration + build_up * 0.5)]
        {
            let least = shortest(&steady(150.0), 1.0e-3, LIMITS, goal).unwrap().unwrap();
            assert!(least < exact + 2.0e-3 && least > exact - 8.0e-3, "{least} s, not {exact}");
        }
    }

    #[test]
    fn what_was_run_may_end_too_soon() {
        assert_eq!(shortest(&steady(150.0)[..20], 1.0e-3, LIMITS, 0.0).unwrap(), None);
    }
}
