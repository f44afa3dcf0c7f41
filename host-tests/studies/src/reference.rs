//! Least time along a fixed path, by a method that has nothing in common with the planner's.
//!
//! Over b = v^2 at places along the path, speed and acceleration limits are linear, and so is the
//! limit of jerk, v (x''' b + 3 x'' b' / 2 + x' b'' / 2), once its factor v is frozen. A quadratic
//! program (clarabel) minimises the second-order model of the time; then v is frozen again at the
//! geometric mean of old and new, some rounds long. Limits are held only at the places, by
//! differences, so the result is on the optimistic side. It is slow and meant as a yardstick.

use crate::rows::Rows;
use anyhow::{Context, Result};
use clarabel::algebra::CscMatrix;
use clarabel::solver::NonnegativeConeT;
use splineway_simulator::machine::Axis;

/// A place of the path with its derivatives by arc length.
#[derive(Clone, Debug)]
pub struct Place {
    /// Arc length to the next place, mm.
    pub step: f64,
    /// x': unit tangent.
    pub tangent: Vec<f64>,
    /// x'', 1/mm.
    pub bend: Vec<f64>,
}

/// What is known of the motion at both ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The first two and last two speeds stay as they are given.
    Kept,
    /// Speed is free, acceleration is 0: the middle of a leg of a zigzag.
    Level,
}

/// The path's limits at the given frozen speeds, for b in units of `scale`.
fn rows(
    places: &[Place],
    limits: &[Axis],
    feed: f64,
    (scale, frozen): (&[f64], &[f64]),
    ends: Ends,
) -> Rows {
    let n = places.len();
    let mut rows = Rows::default();
    for k in 0..n {
        let edge = k == 0 || k + 1 == n;
        if ends == Ends::Kept && (k < 2 || k + 2 >= n) {
            rows.push([(k, 1.0)], 1.0 + 1e-9);
            rows.push([(k, -1.0)], -(1.0 - 1e-9));
            continue;
        }
        // No further than this in one round.
        rows.push([(k, -1.0)], -0.2);
        rows.push([(k, 1.0)], 4.0);
        let place = &places[k];
        let most = place
            .tangent
            .iter()
            .zip(limits)
            .map(|(tangent, limit)| limit.velocity / tangent.abs().max(1e-9))
            .fold(feed, f64::min);
        rows.push([(k, scale[k])], most * most);
        if edge {
            let other = if k == 0 { 1 } else { n - 2 };
            rows.both(&[(k, scale[k]), (other, -scale[other])], scale[k] * 1e-6);
            continue;
        }
        let (h0, h1) = (places[k - 1].step, place.step);
        // First and second derivative by s over three places.
        let d1 = [-h1 / (h0 * (h0 + h1)), (h1 - h0) / (h0 * h1), h0 / (h1 * (h0 + h1))];
        let d2 = [2.0 / (h0 * (h0 + h1)), -2.0 / (h0 * h1), 2.0 / (h1 * (h0 + h1))];
        for (i, limit) in limits.iter().enumerate() {
            let (x1, x2) = (place.tangent[i], place.bend[i]);
            if x1.abs() < 1e-7 && x2.abs() < 1e-7 {
                continue;
            }
            let x3 = places[k - 1].bend[i] * d1[0] + x2 * d1[1] + places[k + 1].bend[i] * d1[2];
            let entries = |own: f64, first: f64, second: f64| {
                [0, 1, 2].map(|j| {
                    let direct = if j == 1 { own } else { 0.0 };
                    let at = k + j - 1;
                    (at, (direct + first * d1[j] + second * d2[j]) * scale[at])
                })
            };
            rows.both(&entries(x2, x1 / 2.0, 0.0), limit.acceleration);
            rows.both(&entries(x3, 1.5 * x2, x1 / 2.0), limit.jerk / frozen[k]);
        }
    }
    rows
}

/// Speeds, mm/s, of the motion of least time over the places, from the guess `speeds`.
///
/// # Errors
/// A program that the solver cannot solve.
pub fn least_time(
    places: &[Place],
    limits: &[Axis],
    feed: f64,
    speeds: &[f64],
    ends: Ends,
    rounds: usize,
) -> Result<Vec<f64>> {
    let n = places.len();
    let mut b: Vec<f64> = speeds.iter().map(|v| v * v).collect();
    let mut frozen = speeds.to_vec();
    for _ in 0..rounds {
        let scale = b.clone();
        let (mut linear, mut square) = (vec![0.0; n], vec![0.0; n]);
        for k in 0..n {
            let before = if k == 0 { 0.0 } else { places[k - 1].step };
            let after = if k + 1 == n { 0.0 } else { places[k].step };
            // w y^-1/2 at y = 1: slope -1/2, curvature 3/4.
            let weight = f64::midpoint(before, after) / b[k].sqrt();
            linear[k] = weight * (-0.5 - 0.75);
            square[k] = weight * 0.75;
        }
        let rows = rows(places, limits, feed, (&scale, &frozen), ends);
        let all: Vec<usize> = (0..n).collect();
        let objective = CscMatrix::new_from_triplets(n, n, all.clone(), all, square);
        let cones = [NonnegativeConeT(rows.len())];
        let x = rows.minimise(&objective, &linear, &cones).context("the least time")?;
        for k in 0..n {
            b[k] = (x[k] * scale[k]).max(1e-6);
            frozen[k] = (frozen[k] * b[k].sqrt()).sqrt();
        }
    }
    Ok(b.iter().map(|b| b.sqrt()).collect())
}

/// Time of a motion with these speeds, s.
pub fn time(places: &[Place], speeds: &[f64]) -> f64 {
    speeds.windows(2).zip(places).map(|(v, place)| 2.0 * place.step / (v[0] + v[1])).sum()
}
