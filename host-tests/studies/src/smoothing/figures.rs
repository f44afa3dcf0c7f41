//! What is measured on a path.

use super::trajectory::{Motion, Place, Reading, run};
use serde::Serialize;
use splineway_simulator::spline::Path;
use splineway_splines::Trajectory;

/// Places per span.
const PLACES: u32 = 200;

/// The figures that the thesis gives of a path.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Figures {
    /// Arc length, mm.
    pub length_mm: f64,
    /// Mean over equal steps of the parameter, 1/mm (the thesis does not say over what).
    #[serde(rename = "curvature_average_per_mm")]
    pub curvature_average: f64,
    /// Mean over the arc length, 1/mm.
    #[serde(rename = "curvature_by_length_per_mm")]
    pub curvature_by_length: f64,
    /// 1/mm.
    #[serde(rename = "curvature_peak_per_mm")]
    pub curvature_peak: f64,
    /// Machining time by section 4.5, s.
    pub time_s: f64,
    /// Length over time, mm/s.
    #[serde(rename = "feed_average_mm_s")]
    pub feed_average: f64,
    /// Mean over equal steps of the parameter within every span, each span alike, mm/s. (Table 4-2 is not length
    /// over time: 766.089 mm in 3.810 s are 201.1 mm/s, and 195.0 is printed.)
    #[serde(rename = "feed_by_parameter_mm_s")]
    pub feed_by_parameter: f64,
}

/// Places along a path, by equal steps of the parameter within every span.
pub fn profile(path: &Path) -> Vec<Place> {
    let mut places: Vec<Place> = Vec::new();
    for span in 0..path.spans() {
        for k in u32::from(span > 0)..=PLACES {
            let u = f64::from(k) / f64::from(PLACES);
            let point = path.point(span, u);
            let way = places.last().map_or(0.0, |before| {
                let step: f64 = before.point.iter().zip(point).map(|(a, b)| (a - b).powi(2)).sum();
                before.way + step.sqrt()
            });
            places.push(Place { way, curvature: path.curvature(span, u), point });
        }
    }
    places
}

/// Mean of the speeds at places.
fn mean_feed(motion: &Motion, places: &[Place]) -> f64 {
    let moments = &motion.moments;
    let mut sum = 0.0;
    for place in places {
        let next = moments.partition_point(|moment| moment.way < place.way);
        let next = next.clamp(1, moments.len() - 1);
        let (a, b) = (moments[next - 1], moments[next]);
        let (room, into) = (b.way - a.way, place.way - a.way);
        let share = if room > 0.0 { (into / room).clamp(0.0, 1.0) } else { 1.0 };
        sum += a.speed + share * (b.speed - a.speed);
    }
    sum / places.len() as f64
}

/// Measures a path.
pub fn measure(path: &Path, trajectory: &Trajectory<f64>, reading: Reading) -> Figures {
    let places = profile(path);
    let length = path.length();
    let (mut by_length, mut by_parameter) = (0.0, 0.0);
    for span in 0..path.spans() {
        let (from, to) = path.range(span);
        let steps = &places[span * PLACES as usize..=(span + 1) * PLACES as usize];
        for pair in steps.windows(2) {
            let mean = f64::midpoint(pair[0].curvature, pair[1].curvature);
            by_length += mean * (pair[1].way - pair[0].way);
            by_parameter += mean * (to - from) / f64::from(PLACES);
        }
    }
    let (start, end) = (path.range(0).0, path.range(path.spans() - 1).1);
    let motion = run(trajectory, &places, reading);
    let time = motion.time;
    Figures {
        length_mm: length,
        curvature_average: by_parameter / (end - start),
        curvature_by_length: by_length / length,
        curvature_peak: places.iter().map(|place| place.curvature).fold(0.0, f64::max),
        time_s: time,
        feed_average: length / time,
        feed_by_parameter: mean_feed(&motion, &places),
    }
}
