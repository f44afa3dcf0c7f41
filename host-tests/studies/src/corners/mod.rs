//! Corner transitions of the literature beside this core's, for comparison; nothing of this is in
//! the firmware.
//!
//! Every method is built by its defining construction as far as that is published in the sources
//! at hand; what had to be derived is marked. All are brought to the same true deviation from the
//! legs and timed with the same speed law ([`crate::reference`]) as one leg of a long zigzag.

mod bspline;
mod curve;
mod methods;
mod tally;

pub use methods::{Continuity, Cost, METHODS, Method, OWN};
pub use tally::Effort;

use crate::geometry::Geometry;
use crate::reference::{Ends, Place, least_time, time};
use anyhow::{Context, Result};
use bspline::Planar;
use curve::Curve;
use splineway_simulator::machine::{Axis, Machine};
use splineway_simulator::program::{Course, Move, Program, Speed};
use splineway_simulator::run::{Precision, run};
use splineway_simulator::scurve::{Leg, Limit};

/// What a method came to at one corner.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The method.
    pub method: Method,
    /// Greatest curvature, 1/mm.
    pub curvature: f64,
    /// Greatest third derivative, 1/mm2; infinite where the curvature jumps.
    pub third: f64,
    /// Time per leg of 10 mm, s.
    pub time: f64,
}

/// Leg of the zigzag, mm.
pub const LEG: f64 = 10.0;
/// Stations on a curve.
const STATIONS: usize = 200;
const ROUNDS: usize = 22;

fn limits(machine: &Machine) -> Vec<Axis> {
    let axis = machine.axes.get("default").copied().unwrap_or(Axis {
        velocity: 200.0,
        acceleration: 2000.0,
        jerk: 50_000.0,
    });
    vec![axis; 2]
}

/// Turned so that both legs make the same angle with the x axis.
fn place(step: f64, tangent: Planar, curvature: f64, turn: f64) -> Place {
    let (c, s) = ((turn / 2.0).cos(), (turn / 2.0).sin());
    let t = (tangent.0 * c + tangent.1 * s, tangent.1 * c - tangent.0 * s);
    Place { step, tangent: vec![t.0, t.1], bend: vec![-t.1 * curvature, t.0 * curvature] }
}

/// Places from the middle of one leg to the middle of the next.
fn places(curve: &Curve) -> Vec<Place> {
    let length = curve.length();
    let first = curve.samples.first().map_or(0.0, |sample| sample.at.0.abs());
    let last = curve.samples.last().map_or(0.0, |sample| sample.at.0.hypot(sample.at.1));
    let step = length / STATIONS as f64;
    // Steps that grow away from the curve.
    let leg = |reach: f64| {
        let room = (LEG / 2.0 - reach).max(step);
        let mut steps = Vec::new();
        let (mut size, mut sum) = (step, 0.0);
        while sum < room {
            steps.push(size);
            sum += size;
            size = (size * 1.08).min(0.12);
        }
        let fit = room / sum;
        steps.iter().map(|step| step * fit).collect::<Vec<f64>>()
    };
    let mut list = Vec::new();
    for step in leg(first).iter().rev() {
        list.push(place(*step, (1.0, 0.0), 0.0, curve.turn));
    }
    for k in 0..STATIONS {
        let sample = curve.sample(k as f64 * step);
        list.push(place(step, sample.tangent, sample.curvature, curve.turn));
    }
    let out = (curve.turn.cos(), curve.turn.sin());
    for step in leg(last) {
        list.push(place(step, out, 0.0, curve.turn));
    }
    list.push(place(0.0, out, 0.0, curve.turn));
    list
}

/// Time per leg along places from mid-leg to mid-leg, s.
fn leg_time(places: &[Place], limits: &[Axis]) -> Result<f64> {
    let guess = vec![8.0; places.len()];
    let speeds = least_time(places, limits, 200.0, &guess, Ends::Level, ROUNDS)?;
    Ok(time(places, &speeds))
}

/// Limits along a leg that makes half the turn with the x axis.
fn along_leg(turn: f64, limits: &[Axis]) -> Limit {
    let most = (turn / 2.0).cos().abs().max((turn / 2.0).sin().abs());
    Limit { acceleration: limits[0].acceleration / most, jerk: limits[0].jerk / most }
}

/// All methods at a corner with this turn (degrees) and true deviation (mm).
///
/// # Errors
/// A speed law that cannot be solved.
pub fn table(degrees: f64, deviation: f64, machine: &Machine) -> Result<Vec<Row>> {
    let turn = degrees.to_radians();
    let limits = limits(machine);
    let mut rows = vec![own(turn, deviation, machine)?];
    for method in METHODS {
        let curve = (method.build)(turn);
        let curve = curve.scaled(deviation / curve.deviation());
        let jumps = method.continuity == Continuity::G1;
        let time = if jumps {
            // At rest where the curvature jumps: along the leg, and along the curve.
            let limit = along_leg(turn, &limits);
            let reach = curve.samples.first().map_or(0.0, |sample| sample.at.0.abs());
            Leg::new(0.0, 0.0, (LEG - 2.0 * reach).max(0.0), 200.0, limit).time()
                + Leg::new(0.0, 0.0, curve.length(), 200.0, limit).time()
        } else {
            leg_time(&places(&curve), &limits).with_context(|| method.name.to_owned())?
        };
        rows.push(Row {
            method,
            curvature: curve.peak_curvature(),
            third: if jumps { f64::INFINITY } else { curve.peak_third() },
            time,
        });
    }
    Ok(rows)
}

/// This core's own corner, as its setpoints trace it.
fn own(turn: f64, deviation: f64, machine: &Machine) -> Result<Row> {
    let mut program = Program::default();
    (program.uses[0], program.uses[1]) = (true, true);
    let (mut to, half) = ([0.0; 9], turn / 2.0);
    for n in 0..4 {
        let angle = if n % 2 == 0 { -half } else { half };
        to[0] += LEG * angle.cos();
        to[1] += LEG * angle.sin();
        program.moves.push(Move {
            path: Course::Line { to },
            speed: Speed::PerSecond(200.0),
            tolerance: Some(deviation),
            exact_stop: false,
            line: 0,
        });
    }
    let mut record = Geometry::new(machine.cycle);
    run(&program, machine, Precision::F64, &mut [&mut record])?;
    // From the middle of the second leg to the middle of the third: all is symmetric.
    let whole: f64 = record.places.iter().map(|place| place.step).sum();
    let at = |share: f64| {
        let mut way = 0.0;
        record.places.iter().position(|place| {
            way += place.step;
            way >= share * whole
        })
    };
    let (from, to) = at(1.5 / 4.0).zip(at(2.5 / 4.0)).context("the core did not run the legs")?;
    let places = &record.places[from..=to];
    let bend = |place: &Place| place.bend[0].hypot(place.bend[1]);
    let third = places
        .windows(2)
        .map(|pair| {
            let d: Vec<f64> = pair[0]
                .bend
                .iter()
                .zip(&pair[1].bend)
                .map(|(a, b)| (b - a) / pair[0].step)
                .collect();
            d[0].hypot(d[1])
        })
        .fold(0.0, f64::max);
    let speeds = least_time(
        places,
        &limits(machine),
        200.0,
        &record.speeds[from..=to],
        Ends::Level,
        ROUNDS,
    )?;
    Ok(Row {
        method: OWN,
        curvature: places.iter().map(bend).fold(0.0, f64::max),
        third,
        time: time(places, &speeds),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At right angles and 0.05 mm: Guo's corner takes 0.151 s a leg (the common bench's table), an
    /// arc cannot be run without stopping, and this core's corner is faster than all.
    #[test]
    fn right_angles() {
        let rows = table(90.0, 0.05, &Machine::default()).unwrap();
        let of = |name: &str| rows.iter().find(|row| row.method.name.starts_with(name)).unwrap();
        assert!((of("Guo").time - 0.151).abs() < 0.003, "{}", of("Guo").time);
        assert!(of("circular").time > 0.187);
        for row in &rows[1..] {
            assert!(row.time > rows[0].time, "{}", row.method.name);
        }
    }

    /// Every curve starts on one leg and ends on the other, with their directions, and has the
    /// continuity that is said of it.
    #[test]
    fn curves_join_the_legs() {
        for method in METHODS {
            for degrees in [30.0f64, 90.0, 135.0] {
                let turn = degrees.to_radians();
                let curve = (method.build)(turn);
                let (first, last) = (curve.samples[0], curve.samples[curve.samples.len() - 1]);
                assert!(first.at.1.abs() < 1e-6 && first.tangent.1.abs() < 1e-6);
                let off = last.at.0 * turn.sin() - last.at.1 * turn.cos();
                assert!(off.abs() < 1e-4, "{} {degrees}: {off}", method.name);
                let gap = (last.tangent.0 - turn.cos()).hypot(last.tangent.1 - turn.sin());
                assert!(gap < 1e-4, "{} {degrees}: {gap}", method.name);
                let peak = curve.peak_curvature();
                let jump = first.curvature.abs().max(last.curvature.abs());
                assert_eq!(
                    jump < 1e-6 * peak,
                    method.continuity != Continuity::G1,
                    "{}",
                    method.name
                );
                let step = curve
                    .samples
                    .windows(2)
                    .map(|pair| (pair[1].curvature - pair[0].curvature).abs())
                    .fold(0.0, f64::max);
                assert!(step < 0.05 * peak, "{} {degrees}: {step} of {peak}", method.name);
            }
        }
    }
}
