//! How long things may take.

use super::setting::Setting;

use splineway::block::FINEST_BAND;
use splineway_simulator::machine::Axis;
use splineway_simulator::program::arc::Spiral;
use splineway_simulator::program::{Course, Move, Point, Speed};
use splineway_simulator::scurve::{Leg, Limit};

/// Chords of a curve that might stop at each of them.
const CURVE_STOPS: u32 = 8;

fn least(setting: &Setting, of: fn(&Axis) -> f64) -> f64 {
    setting.axes.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Nodes of the window that hold no path ahead: those that a draft adds, and room for a cell.
const KEPT_NODES: usize = 14;
/// A cell of an arc is at most the square root of so many times band over curvature, and so much of an angle, rad (`src/path/segment.rs`): a rest within it
/// keeps the band then.
const CELL: f64 = 19.2 * 0.97;
const CELL_ANGLE: f64 = 0.3;
/// Share of a servo cycle that a cell takes at least (`src/profile/bounds.rs`).
const CELL_CYCLES: f64 = 0.25;

/// The greatest speed on an arc from which a motion can rest on what a window holds of it, and at which a servo cycle passes few cells, mm/s.
///
/// A plan ends at rest on the last node that is known, `window` mm ahead when it is begun. It is taken where it branches off, a lead later and
/// what a cycle rounds that up by; the next is begun then and takes over as much later, and until it does the motion must be able to come to
/// rest at the end of the one before: within `window` less two leads. (A plan branches off at half of what is left, where that is
/// less than a lead: twice that leaves a quarter.)
///
/// Of the acceleration A a circle leaves sqrt(A^2 - (v^2 / R)^2) along the path, so that a stop from v takes at least the integral of
/// v dv over that, R / 2 asin(v^2 / (A R)), and half of v A / J until it has been built up.
fn sighted(setting: &Setting, tolerance: f64, radius: f64, limit: Limit, most: f64) -> f64 {
    let Limit { acceleration, jerk } = limit;
    let cell = (CELL * tolerance.max(FINEST_BAND) * radius).sqrt().min(CELL_ANGLE * radius);
    let window = (setting.nodes() - KEPT_NODES) as f64 * cell;
    let leads = 2.0 * (setting.lead + setting.cycle);
    let rests = |v: f64| {
        let share = (v * v / (acceleration * radius)).min(1.0);
        let stop = 0.5 * (radius * share.asin() + v * acceleration / jerk);
        stop <= (window - leads * v).max(0.25 * window)
    };
    let (mut low, mut high) = (0.0, most.min(cell / (CELL_CYCLES * setting.cycle)));
    if rests(high) {
        return high;
    }
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if rests(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Time of a block from rest to rest, s: what a controller that stops after every block needs. Curves are
/// taken for slow ones, and on arcs it sees no further than a window.
pub fn stop_time(from: &Point, step: &Move, setting: &Setting) -> f64 {
    let count = setting.axes.len();
    let (to, length, parts, radius) = match &step.path {
        Course::Dwell { seconds } => return seconds + 2.0 * setting.cycle,
        Course::Event { .. } => return 3.0 * setting.cycle,
        Course::Line { to } => (to, norm(from, to, count), 1, f64::INFINITY),
        Course::Arc { to, .. } => {
            let Some(spiral) = Spiral::of(&step.path, from) else { return 0.0 };
            let axes: Vec<usize> = (0..count).collect();
            (to, spiral.length(&axes), 1, spiral.radii.0.max(1.0e-9))
        }
        Course::Cubic { controls, to } => {
            let [a, b] = controls;
            let length = norm(from, a, count) + norm(a, b, count) + norm(b, to, count);
            (to, length, CURVE_STOPS, f64::INFINITY)
        }
    };
    if length < 1.0e-9 {
        return 0.0;
    }
    let share = |n: usize| (to[n] - from[n]).abs() / length;
    let straight = matches!(step.path, Course::Line { .. });
    let by = |of: fn(&Axis) -> f64| -> f64 {
        if !straight {
            return least(setting, of);
        }
        let along = |(n, axis): (usize, &Axis)| of(axis) / share(n).max(1.0e-12);
        setting.axes.iter().enumerate().map(along).fold(f64::INFINITY, f64::min)
    };
    let limit = Limit { acceleration: by(|a| a.acceleration), jerk: by(|a| a.jerk) };
    let linear =
        (0..count.min(setting.rotary_from)).map(|n| share(n) * share(n)).sum::<f64>().sqrt();
    let wanted = match step.speed {
        Speed::PerSecond(feed) => {
            if straight && linear > 0.0 {
                feed / linear
            } else {
                feed
            }
        }
        Speed::Duration(seconds) => length / seconds,
        Speed::Rapid => f64::INFINITY,
    };
    let round = (limit.acceleration * radius).sqrt().min((limit.jerk * radius * radius).cbrt());
    let mut most = wanted.min(by(|a| a.velocity)).min(round);
    if radius.is_finite() {
        let tolerance = step.tolerance.unwrap_or(setting.tolerance);
        most = sighted(setting, tolerance, radius, limit, most);
    }
    let part = length / f64::from(parts);
    f64::from(parts) * Leg::new(0.0, 0.0, part, most, limit).time()
}

fn norm(a: &Point, b: &Point, count: usize) -> f64 {
    (0..count).map(|n| (a[n] - b[n]).powi(2)).sum::<f64>().sqrt()
}

/// Time to rest from a speed, s: of a machine whose axes all have the least limits of any.
pub fn braking_time(setting: &Setting, speed: f64) -> f64 {
    let (acceleration, jerk) = (least(setting, |a| a.acceleration), least(setting, |a| a.jerk));
    if speed * jerk < acceleration * acceleration {
        return 2.0 * (speed / jerk).sqrt() + acceleration / jerk;
    }
    speed / acceleration + 2.0 * acceleration / jerk
}
