//! The thesis's trajectory generator along a path.

use super::literal::{self, Plateau};
use splineway_splines::{Lows, Trajectory};

/// Parts of an S-curve in a motion.
const PARTS: u32 = 12;

/// A place on a path.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Arc length from the start, mm.
    pub way: f64,
    /// 1/mm.
    pub curvature: f64,
    /// Where it is, mm.
    pub point: [f64; 3],
}

/// How section 4.5 is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Reading {
    /// Greatest speeds lie anywhere between the least ones, and what an S-curve does not need is run at them.
    #[default]
    Free,
    /// Word by word: extremes stay where they are, S-curves fill the distances; a plateau is one
    /// extreme.
    Middle,
    /// The same; a plateau is two.
    Edges,
}

/// A moment of a motion.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Since the start, s.
    pub time: f64,
    /// From the start, mm.
    pub way: f64,
    /// mm/s.
    pub speed: f64,
}

/// A motion along a path.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Machining time, s.
    pub time: f64,
    /// Moments, in order.
    pub moments: Vec<Moment>,
}

/// The motion along a path.
pub fn run(trajectory: &Trajectory<f64>, places: &[Place], reading: Reading) -> Motion {
    match reading {
        Reading::Free => free(trajectory, places),
        Reading::Middle => literal::run(trajectory, places, Plateau::Middle),
        Reading::Edges => literal::run(trajectory, places, Plateau::Edges),
    }
}

fn free(trajectory: &Trajectory<f64>, places: &[Place]) -> Motion {
    let mut finder = Lows::default();
    let mut lows = Vec::new();
    for place in places {
        lows.extend(finder.push(place.way, trajectory.allowed(place.curvature)));
    }
    lows.extend(finder.finish().into_iter().flatten());
    let time = trajectory.plan(&mut lows);
    let mut moments = Vec::new();
    let mut now = 0.0;
    for pair in lows.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let [up, down] = [(from.speed, from.most), (from.most, to.speed)];
        let along = to.way - from.way - trajectory.length(up.0, up.1);
        let along = (along - trajectory.length(down.0, down.1)).max(0.0);
        let starts = [from.way, to.way - trajectory.length(down.0, down.1)];
        for ((start, (v0, v1)), rest) in starts.into_iter().zip([up, down]).zip([along, 0.0]) {
            let whole = trajectory.time(v0, v1);
            for k in 0..=PARTS {
                let t = whole * f64::from(k) / f64::from(PARTS);
                let (speed, way) = trajectory.at(v0, v1, t);
                moments.push(Moment { time: now + t, way: start + way, speed });
            }
            now += whole + rest / from.most;
        }
    }
    Motion { time, moments }
}
