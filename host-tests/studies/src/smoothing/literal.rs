//! Section 4.5 of Naseath 2007 read word by word.
//!
//! "All of the velocities that were not local maximum or minimum values were removed": the extremes of V =
//! sqrt(A / k) stay at their places, and nothing lies between them. "The s-curves were required to traverse
//! the distances between the positions": an S-curve fills the distance to its neighbour, however long that
//! is. "Local maximum velocity values were decreased until the robot was capable of": the faster of two
//! neighbours is lowered until the S-curve between them is no longer than the distance. So a distance d
//! takes 2 d / (v0 + v1), as an S-curve is symmetric about its mean.
//!
//! The text does not say what becomes of a plateau, where the feed is the limit: it is one extreme, in its
//! middle, or two, its edges ([`Plateau`]).

use super::trajectory::{Moment, Motion, Place};
use splineway_splines::Trajectory;

/// Parts of an S-curve in the motion.
const PARTS: u32 = 24;
/// Halvings in the search for a speed.
const HALVINGS: u32 = 50;

/// What a plateau of the speed counts as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plateau {
    /// One extreme, in its middle.
    Middle,
    /// Two, its edges.
    Edges,
}

/// A place where the speed is extreme.
#[derive(Clone, Copy, Debug)]
struct Extreme {
    /// mm.
    way: f64,
    /// mm/s.
    speed: f64,
}

/// Stretches of equal speed, with the way where each begins and ends.
fn levels(trajectory: &Trajectory<f64>, places: &[Place]) -> Vec<(f64, f64, f64)> {
    let mut levels: Vec<(f64, f64, f64)> = Vec::new();
    for place in places {
        let speed = trajectory.allowed(place.curvature);
        match levels.last_mut() {
            #[allow(clippy::float_cmp)] // a plateau is the feed itself
            Some((_, end, same)) if *same == speed => *end = place.way,
            _ => levels.push((place.way, place.way, speed)),
        }
    }
    levels
}

/// The extremes along a path, its ends included.
fn extremes(trajectory: &Trajectory<f64>, places: &[Place], plateau: Plateau) -> Vec<Extreme> {
    let levels = levels(trajectory, places);
    let last = levels.len().saturating_sub(1);
    let mut out: Vec<Extreme> = Vec::new();
    for (k, &(start, end, speed)) in levels.iter().enumerate() {
        let is_end = k == 0 || k == last;
        if !is_end && (speed - levels[k - 1].2) * (levels[k + 1].2 - speed) > 0.0 {
            continue;
        }
        match plateau {
            Plateau::Middle if !is_end => {
                out.push(Extreme { way: f64::midpoint(start, end), speed });
            }
            // Where the path begins and ends there is an extreme in any case.
            _ => {
                let edges = plateau == Plateau::Edges;
                if edges || k == 0 {
                    out.push(Extreme { way: start, speed });
                }
                if (edges && end > start) || (!edges && k == last) {
                    out.push(Extreme { way: end, speed });
                }
            }
        }
    }
    out
}

/// The speed `to`, lowered until its S-curve from the lower speed `from` is no longer than `room`.
fn reachable(trajectory: &Trajectory<f64>, from: f64, to: f64, room: f64) -> f64 {
    if to <= from || trajectory.length(from, to) <= room {
        return to;
    }
    let (mut low, mut high) = (from, to);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if trajectory.length(from, middle) <= room { low = middle } else { high = middle }
    }
    low
}

fn lower(trajectory: &Trajectory<f64>, extremes: &mut [Extreme]) {
    for k in 1..extremes.len() {
        let (from, to) = (extremes[k - 1], extremes[k]);
        extremes[k].speed = reachable(trajectory, from.speed, to.speed, to.way - from.way);
    }
    for k in (1..extremes.len()).rev() {
        let (to, from) = (extremes[k - 1], extremes[k]);
        extremes[k - 1].speed = reachable(trajectory, from.speed, to.speed, from.way - to.way);
    }
}

/// The motion along a path.
pub fn run(trajectory: &Trajectory<f64>, places: &[Place], plateau: Plateau) -> Motion {
    let mut extremes = extremes(trajectory, places, plateau);
    lower(trajectory, &mut extremes);
    let mut motion = Motion::default();
    for pair in extremes.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let room = to.way - from.way;
        let takes = 2.0 * room / (from.speed + to.speed);
        let whole = trajectory.time(from.speed, to.speed);
        for k in 0..=PARTS {
            let share = f64::from(k) / f64::from(PARTS);
            let (speed, way) = if whole > 0.0 {
                let (speed, way) = trajectory.at(from.speed, to.speed, whole * share);
                (speed, way * takes / whole)
            } else {
                (from.speed, room * share)
            };
            let time = motion.time + takes * share;
            motion.moments.push(Moment { time, way: from.way + way, speed });
        }
        motion.time += takes;
    }
    motion
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(curvatures: &[f64]) -> Vec<Place> {
        curvatures
            .iter()
            .enumerate()
            .map(|(k, &curvature)| Place { way: k as f64, curvature, point: [k as f64, 0.0, 0.0] })
            .collect()
    }

    /// A bend in the middle of a line: both readings of a plateau by hand.
    #[test]
    fn an_s_curve_fills_the_distance() {
        let trajectory = Trajectory::thesis();
        let mut curvatures = [0.0; 401];
        curvatures[200] = 0.1;
        let places = places(&curvatures);
        // sqrt(4000 / 0.1) = 200 mm/s; the change by 200 mm/s takes 0.25 s and 75 mm.
        let edges = run(&trajectory, &places, Plateau::Edges);
        // The plateaus end a millimetre before the bend: there the speed is lowered until its
        // S-curve is a millimetre long.
        let near = edges.moments.iter().find(|moment| moment.way >= 199.0 - 1e-9).unwrap();
        assert!((trajectory.length(200.0, near.speed) - 1.0).abs() < 1e-6, "{near:?}");
        let first = 2.0 * 199.0 / (400.0 + near.speed);
        let wanted = 2.0 * (first + 2.0 / (200.0 + near.speed));
        assert!((edges.time - wanted).abs() < 1e-9, "{} {wanted}", edges.time);
        let end = edges.moments.last().unwrap();
        assert!((end.way - 400.0).abs() < 1e-9 && (end.time - edges.time).abs() < 1e-12);
    }

    #[test]
    fn a_line_is_run_at_the_feed() {
        for plateau in [Plateau::Middle, Plateau::Edges] {
            let time = run(&Trajectory::thesis(), &places(&[0.0; 101]), plateau).time;
            assert!((time - 0.25).abs() < 1e-12);
        }
    }
}
