//! A corner curve as samples: place, direction, curvature.

use super::bspline::{Planar, Spline};

/// One sample of a curve.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Arc length from the start, mm.
    pub way: f64,
    /// Place; the corner is the origin, the leg that comes in lies on the negative x axis.
    pub at: Planar,
    /// Unit tangent.
    pub tangent: Planar,
    /// Signed curvature, 1/mm.
    pub curvature: f64,
}

/// A curve from one leg to the other.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Samples, closely spaced.
    pub samples: Vec<Sample>,
    /// Turn of the corner, rad.
    pub turn: f64,
}

/// Samples of a curve.
const SAMPLES: usize = 2400;

impl Curve {
    /// The samples of a spline.
    pub fn of_spline(spline: &Spline, turn: f64) -> Self {
        let (first, second) = (spline.derivative(), spline.derivative().derivative());
        let mut samples: Vec<Sample> = Vec::with_capacity(SAMPLES + 1);
        for k in 0..=SAMPLES {
            let u = spline.end() * k as f64 / SAMPLES as f64;
            let (at, d, dd) = (spline.at(u), first.at(u), second.at(u));
            let speed = d.0.hypot(d.1);
            let way = samples
                .last()
                .map_or(0.0, |last: &Sample| last.way + (at.0 - last.at.0).hypot(at.1 - last.at.1));
            samples.push(Sample {
                way,
                at,
                tangent: (d.0 / speed, d.1 / speed),
                curvature: (d.0 * dd.1 - d.1 * dd.0) / speed.powi(3),
            });
        }
        Self { samples, turn }
    }

    /// A curve of unit length by its curvature over the way, up to a factor.
    pub fn of_curvature(curvature: impl Fn(f64) -> f64, turn: f64) -> Self {
        let h = 1.0 / SAMPLES as f64;
        let whole: f64 = (0..SAMPLES).map(|k| curvature((k as f64 + 0.5) * h) * h).sum();
        let factor = turn / whole;
        let (mut angle, mut at) = (0.0f64, (0.0, 0.0));
        let mut samples = Vec::with_capacity(SAMPLES + 1);
        for k in 0..=SAMPLES {
            let way = k as f64 * h;
            samples.push(Sample {
                way,
                at,
                tangent: (angle.cos(), angle.sin()),
                curvature: factor * curvature(way),
            });
            let half = angle + factor * curvature(way + h / 4.0) * h / 2.0;
            at = (at.0 + half.cos() * h, at.1 + half.sin() * h);
            angle += factor * curvature(way + h / 2.0) * h;
        }
        // The corner is where the tangents at both ends meet.
        let end = samples[SAMPLES].at;
        let x = end.0 - end.1 / turn.tan();
        for sample in &mut samples {
            sample.at.0 -= x;
        }
        Self { samples, turn }
    }

    /// Greatest distance from the legs.
    pub fn deviation(&self) -> f64 {
        let (cos, sin) = (self.turn.cos(), self.turn.sin());
        let ray = |along: f64, beside: f64| {
            if along < 0.0 { beside.abs() } else { along.hypot(beside) }
        };
        self.samples
            .iter()
            .map(|sample| {
                let (x, y) = sample.at;
                ray(x, y).min(ray(-(x * cos + y * sin), y * cos - x * sin))
            })
            .fold(0.0, f64::max)
    }

    /// The same curve, larger or smaller.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let samples = self
            .samples
            .iter()
            .map(|sample| Sample {
                way: sample.way * factor,
                at: (sample.at.0 * factor, sample.at.1 * factor),
                tangent: sample.tangent,
                curvature: sample.curvature / factor,
            })
            .collect();
        Self { samples, turn: self.turn }
    }

    /// Length, mm.
    pub fn length(&self) -> f64 {
        self.samples.last().map_or(0.0, |last| last.way)
    }

    /// Greatest curvature, 1/mm.
    pub fn peak_curvature(&self) -> f64 {
        self.samples.iter().map(|sample| sample.curvature.abs()).fold(0.0, f64::max)
    }

    /// Greatest third derivative by arc length, 1/mm2: of curvature change and curvature squared.
    pub fn peak_third(&self) -> f64 {
        self.samples
            .windows(2)
            .map(|pair| {
                let change = (pair[1].curvature - pair[0].curvature) / (pair[1].way - pair[0].way);
                change.hypot(pair[0].curvature.powi(2))
            })
            .fold(0.0, f64::max)
    }

    /// Sample at an arc length, interpolated.
    pub fn sample(&self, way: f64) -> Sample {
        let after = self.samples.partition_point(|sample| sample.way < way);
        let after = after.clamp(1, self.samples.len() - 1);
        let (a, b) = (&self.samples[after - 1], &self.samples[after]);
        let u = ((way - a.way) / (b.way - a.way)).clamp(0.0, 1.0);
        let mix = |x: f64, y: f64| x + (y - x) * u;
        let tangent = (mix(a.tangent.0, b.tangent.0), mix(a.tangent.1, b.tangent.1));
        let size = tangent.0.hypot(tangent.1);
        Sample {
            way,
            at: (mix(a.at.0, b.at.0), mix(a.at.1, b.at.1)),
            tangent: (tangent.0 / size, tangent.1 / size),
            curvature: mix(a.curvature, b.curvature),
        }
    }
}
