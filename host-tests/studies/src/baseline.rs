//! What a program takes with the speed laws that controllers commonly have, to compare with.
//!
//! All three run on the programmed path itself and change direction in an instant: where they do
//! not stop they break every limit at a corner, by the jump of velocity that is reported.
//!
//! - exact stop: seven phases (or fewer) from rest to rest on every move;
//! - junction deviation: grbl's rule for the speed at a corner, v^2 = A d s / (1 - s) with s the sine
//!   of half the angle between the legs and d the tolerance, and trapezoids between, with no limit of
//!   jerk;
//! - S-curve: the same speeds at corners, seven phases between, acceleration 0 at every corner.

use splineway_simulator::machine::Axis;
use splineway_simulator::program::{Course, Program, Speed};
use splineway_simulator::run::duration::fed;
use splineway_simulator::scurve::{Leg, Limit, reachable};

/// A speed law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Rest at the end of every move.
    ExactStop,
    /// Junction deviation and trapezoids.
    Trapezoid,
    /// Junction deviation and seven phases with acceleration 0 at every corner.
    SCurve,
}

/// Chords that stand for a curve.
const CURVE_CHORDS: u32 = 32;

/// What a law came to.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Time, s.
    pub time: f64,
    /// Greatest jump of velocity at a corner, mm/s.
    pub jump: f64,
    /// Speed over the way, mm/s and mm, for plots.
    pub curve: Vec<(f64, f64)>,
}

/// A move as the laws see it.
struct Piece {
    length: f64,
    feed: f64,
    limit: Limit,
    tangents: [Vec<f64>; 2],
    stop: bool,
    /// Standstill after it, s.
    dwell: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Greatest value along a direction that leaves every axis within its own.
fn along(tangent: &[f64], limits: &[Axis], of: fn(&Axis) -> f64) -> f64 {
    tangent
        .iter()
        .zip(limits)
        .map(|(t, limit)| of(limit) / t.abs().max(1e-12))
        .fold(f64::INFINITY, f64::min)
}

/// The moves, and the standstill before the first, s.
fn pieces(program: &Program, limits: &[Axis]) -> (Vec<Piece>, f64) {
    let axes = program.axes();
    let mut here = program.start;
    let (mut list, mut before) = (Vec::<Piece>::new(), 0.0);
    for step in &program.flattened(CURVE_CHORDS).moves {
        let (to, (length, counted), tangents, radius) = match &step.path {
            Course::Cubic { .. } | Course::Event { .. } => continue,
            Course::Dwell { seconds } => {
                if let Some(last) = list.last_mut() {
                    last.dwell += seconds;
                    last.stop = true;
                } else {
                    before += seconds;
                }
                continue;
            }
            Course::Line { to } => {
                let way: Vec<f64> = axes.iter().map(|&axis| to[axis] - here[axis]).collect();
                let length = dot(&way, &way).sqrt();
                let tangent: Vec<f64> = way.iter().map(|x| x / length.max(1e-12)).collect();
                (to, (length, fed(&way, &axes)), [tangent.clone(), tangent], f64::INFINITY)
            }
            Course::Arc { to, plane: (p, q), centre, clockwise, extra_turns } => {
                let (sx, sy) = (here[*p] - centre.0, here[*q] - centre.1);
                let (ex, ey) = (to[*p] - centre.0, to[*q] - centre.1);
                let sign = if *clockwise { -1.0 } else { 1.0 };
                let tau = std::f64::consts::TAU;
                let mut sweep = sign * (ey.atan2(ex) - sy.atan2(sx));
                if sweep <= 1e-9 {
                    sweep += tau;
                }
                sweep += tau * f64::from(*extra_turns);
                let radius = sx.hypot(sy).max(1e-9);
                let round = radius * sweep;
                let drift = |axis: usize| {
                    if axis == *p || axis == *q { 0.0 } else { to[axis] - here[axis] }
                };
                // The plane's axes take turns in the way round.
                let part = |&axis: &usize| if axis == *p { round } else { drift(axis) };
                let way: Vec<f64> = axes.iter().map(part).collect();
                let length = dot(&way, &way).sqrt();
                let tangent = |x: f64, y: f64| -> Vec<f64> {
                    let share = round / length / radius * sign;
                    axes.iter()
                        .map(|&axis| match axis {
                            axis if axis == *p => -y * share,
                            axis if axis == *q => x * share,
                            axis => drift(axis) / length,
                        })
                        .collect()
                };
                (to, (length, fed(&way, &axes)), [tangent(sx, sy), tangent(ex, ey)], radius)
            }
        };
        here = *to;
        if length < 1e-9 {
            continue;
        }
        let straight = radius.is_infinite();
        let least = |of: fn(&Axis) -> f64| limits.iter().map(of).fold(f64::INFINITY, f64::min);
        let by = |of: fn(&Axis) -> f64| {
            if straight { along(&tangents[0], limits, of) } else { least(of) }
        };
        let limit = Limit { acceleration: by(|a| a.acceleration), jerk: by(|a| a.jerk) };
        let wanted = match step.speed {
            Speed::PerSecond(feed) => feed * length / counted,
            Speed::Duration(seconds) => length / seconds,
            Speed::Rapid => f64::INFINITY,
        };
        let round = (limit.acceleration * radius).sqrt().min((limit.jerk * radius * radius).cbrt());
        list.push(Piece {
            length,
            feed: wanted.min(by(|a| a.velocity)).min(round),
            limit,
            tangents,
            stop: step.exact_stop,
            dwell: 0.0,
        });
    }
    (list, before)
}

/// Speed at the corner between two moves by the rule of junction deviation.
fn junction(before: &Piece, after: &Piece, deviation: f64) -> f64 {
    let cosine = -dot(&before.tangents[1], &after.tangents[0]);
    let sine = ((1.0 - cosine) / 2.0).max(0.0).sqrt();
    let most = before.feed.min(after.feed);
    if before.stop {
        return 0.0;
    }
    if sine > 1.0 - 1e-9 {
        return most;
    }
    let acceleration = before.limit.acceleration.min(after.limit.acceleration);
    (acceleration * deviation * sine / (1.0 - sine)).sqrt().min(most)
}

/// Runs a program with a speed law; `tolerance` in mm is the junction deviation.
pub fn run(program: &Program, limits: &[Axis], tolerance: f64, law: Law) -> Outcome {
    let (list, before) = pieces(program, limits);
    let n = list.len();
    let limit = |piece: &Piece| match law {
        Law::Trapezoid => Limit { jerk: f64::INFINITY, ..piece.limit },
        _ => piece.limit,
    };
    // Speeds at the corners: the rule, then what can be reached from the next one and the last.
    let mut speeds = vec![0.0; n + 1];
    if law != Law::ExactStop {
        for k in 1..n {
            speeds[k] = junction(&list[k - 1], &list[k], tolerance);
        }
    }
    for k in (0..n).rev() {
        let most = speeds[k];
        speeds[k] = reachable(speeds[k + 1], list[k].length, most, limit(&list[k])).min(most);
    }
    for k in 0..n {
        let most = speeds[k + 1];
        speeds[k + 1] = reachable(speeds[k], list[k].length, most, limit(&list[k])).min(most);
    }
    let mut outcome = Outcome { time: before, jump: 0.0, curve: Vec::new() };
    let mut way = 0.0;
    for (k, piece) in list.iter().enumerate() {
        let leg = Leg::new(speeds[k], speeds[k + 1], piece.length, piece.feed, limit(piece));
        outcome.time += leg.time() + piece.dwell;
        outcome.curve.extend(leg.plot(way));
        way += piece.length;
        if let Some(next) = list.get(k + 1) {
            let gap: Vec<f64> =
                piece.tangents[1].iter().zip(&next.tangents[0]).map(|(a, b)| b - a).collect();
            outcome.jump = outcome.jump.max(speeds[k + 1] * dot(&gap, &gap).sqrt());
        }
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway_simulator::program::Move;

    fn zigzag() -> Program {
        let mut program = Program::default();
        (program.uses[0], program.uses[1]) = (true, true);
        let mut to = [0.0; 9];
        for n in 0..20 {
            to[n % 2] += 10.0;
            program.moves.push(Move::new(Course::Line { to }, Speed::PerSecond(200.0), 0));
        }
        program
    }

    /// A feed is for the linear axes: an axis that turns with them takes nothing of it, along a line and around an arc.
    #[test]
    fn an_axis_that_turns_takes_no_feed() {
        let limits = [Axis { velocity: 500.0, acceleration: 20_000.0, jerk: 1.0e6 }; 4];
        let mut to = [0.0; 9];
        (to[0], to[5]) = (10.0, 200.0);
        let arc =
            Course::Arc { to, plane: (0, 1), centre: (5.0, 0.0), clockwise: true, extra_turns: 0 };
        for (path, way) in [(Course::Line { to }, 10.0), (arc, 5.0 * std::f64::consts::PI)] {
            let mut program = Program::default();
            program.uses[5] = true;
            program.moves.push(Move::new(path, Speed::PerSecond(20.0), 1));
            for law in [Law::ExactStop, Law::Trapezoid, Law::SCurve] {
                let time = run(&program, &limits, 0.05, law).time;
                assert!((time - way / 20.0).abs() < 0.06, "{law:?}: {time} s for {way} mm");
            }
        }
    }

    /// Twenty legs of 10 mm, each from rest to rest.
    #[test]
    fn stopping_at_every_corner_of_a_zigzag() {
        let limits = [Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 }; 2];
        let stops = run(&zigzag(), &limits, 0.05, Law::ExactStop);
        assert!((stops.time - 3.74).abs() < 0.01, "{}", stops.time);
        assert!(stops.jump < 1e-9);
        let trapezoid = run(&zigzag(), &limits, 0.05, Law::Trapezoid);
        let curve = run(&zigzag(), &limits, 0.05, Law::SCurve);
        assert!(trapezoid.time < curve.time && curve.time < stops.time);
        // At 90 degrees: v^2 = A d s / (1 - s) with s = sin 45.
        let v = (2000.0f64 * 0.05 * 0.5f64.sqrt() / (1.0 - 0.5f64.sqrt())).sqrt();
        assert!((trapezoid.jump - v * 2f64.sqrt()).abs() < 1e-6, "{}", trapezoid.jump);
    }
}
