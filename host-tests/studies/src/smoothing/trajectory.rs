//! The thesis's trajectory generator along a path.

use splineway_splines::{Lows, Trajectory};

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

/// A motion along a path.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Machining time, s.
    pub time: f64,
    /// Way, mm, and speed, mm/s.
    pub points: Vec<(f64, f64)>,
}

/// The motion along a path.
pub fn run(trajectory: &Trajectory<f64>, places: &[Place]) -> Motion {
    const PARTS: u32 = 12;
    let mut finder = Lows::default();
    let mut lows = Vec::new();
    for place in places {
        lows.extend(finder.push(place.way, trajectory.allowed(place.curvature)));
    }
    lows.extend(finder.finish().into_iter().flatten());
    let time = trajectory.plan(&mut lows);
    let mut points = Vec::new();
    for pair in lows.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let down = trajectory.length(from.most, to.speed);
        for (start, v0, v1) in
            [(from.way, from.speed, from.most), (to.way - down, from.most, to.speed)]
        {
            let whole = trajectory.time(v0, v1);
            for k in 0..=PARTS {
                let (v, s) = trajectory.at(v0, v1, whole * f64::from(k) / f64::from(PARTS));
                points.push((start + s, v));
            }
        }
    }
    Motion { time, points }
}
