//! The programmed path as a fine poly-line, to hold setpoints against.

use crate::program::{Course, Program, on_cubic};

/// Arcs are cut into chords that leave them by no more than this, mm.
const SAGITTA: f64 = 1.0e-6;

/// The programmed path over the axes in use.
#[derive(Clone, Debug)]
pub struct Track {
    /// Number of axes.
    pub axes: usize,
    /// Vertices, one after the other.
    points: Vec<f64>,
    /// Arc length up to each vertex.
    way: Vec<f64>,
}

impl Track {
    /// The path of a program.
    pub fn new(program: &Program) -> Self {
        let axes = program.axes();
        let mut track = Self { axes: axes.len(), points: Vec::new(), way: Vec::new() };
        let mut here = program.start;
        track.add(axes.iter().map(|&axis| here[axis]));
        for step in &program.moves {
            match &step.path {
                Course::Line { to } => {
                    here = *to;
                    track.add(axes.iter().map(|&axis| here[axis]));
                }
                Course::Arc { to, plane: (p, q), centre, clockwise, extra_turns } => {
                    let from = (here[*p] - centre.0, here[*q] - centre.1);
                    let end = (to[*p] - centre.0, to[*q] - centre.1);
                    let (r0, r1) = (from.0.hypot(from.1), end.0.hypot(end.1));
                    let a0 = from.1.atan2(from.0);
                    let mut sweep = end.1.atan2(end.0) - a0;
                    if *clockwise {
                        sweep = -sweep;
                    }
                    let tau = std::f64::consts::TAU;
                    let closed = (from.0 - end.0).hypot(from.1 - end.1) < 1e-6;
                    if closed {
                        sweep = tau;
                    } else if sweep <= 0.0 {
                        sweep += tau;
                    }
                    sweep += tau * f64::from(*extra_turns);
                    let sign = if *clockwise { -1.0 } else { 1.0 };
                    let chord = (8.0 * r0.max(r1).max(1e-9) * SAGITTA).sqrt();
                    let n = ((r0.max(r1) * sweep / chord).ceil() as usize).clamp(8, 2_000_000);
                    for k in 1..=n {
                        let u = k as f64 / n as f64;
                        let mut point = here;
                        for axis in 0..point.len() {
                            point[axis] += (to[axis] - here[axis]) * u;
                        }
                        let (r, phi) = (r0 + (r1 - r0) * u, a0 + sign * sweep * u);
                        point[*p] = centre.0 + r * phi.cos();
                        point[*q] = centre.1 + r * phi.sin();
                        track.add(axes.iter().map(|&axis| point[axis]));
                    }
                    here = *to;
                }
                Course::Cubic { controls, to } => {
                    let bend =
                        [(&here, &controls[0], &controls[1]), (&controls[0], &controls[1], to)]
                            .map(|(a, b, c)| {
                                let x = (0..a.len()).map(|i| a[i] - 2.0 * b[i] + c[i]);
                                6.0 * x.map(|x| x * x).sum::<f64>().sqrt()
                            });
                    let n = (bend[0].max(bend[1]) / (8.0 * SAGITTA)).sqrt().ceil();
                    let n = (n as usize).clamp(8, 2_000_000);
                    for k in 1..=n {
                        let point = on_cubic(&here, controls, to, k as f64 / n as f64);
                        track.add(axes.iter().map(|&axis| point[axis]));
                    }
                    here = *to;
                }
                Course::Dwell { .. } | Course::Event { .. } => {}
            }
        }
        track
    }

    fn add(&mut self, point: impl Iterator<Item = f64>) {
        let start = self.points.len();
        self.points.extend(point);
        let Some(before) = start.checked_sub(self.axes) else {
            self.way.push(0.0);
            return;
        };
        let step = distance(&self.points[before..start], &self.points[start..]);
        if step < 1e-9 {
            self.points.truncate(start);
            return;
        }
        self.way.push(self.way.last().copied().unwrap_or(0.0) + step);
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.way.len()
    }

    /// Whether it has no vertex.
    pub fn is_empty(&self) -> bool {
        self.way.is_empty()
    }

    /// A vertex.
    pub fn point(&self, k: usize) -> &[f64] {
        &self.points[k * self.axes..(k + 1) * self.axes]
    }

    /// The last vertex.
    pub fn end(&self) -> &[f64] {
        self.point(self.len() - 1)
    }

    /// Whole length, mm.
    pub fn length(&self) -> f64 {
        self.way.last().copied().unwrap_or(0.0)
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

/// Follows the path in order and measures how far setpoints are from it.
#[derive(Clone, Debug, Default)]
pub struct Follower {
    /// Segment and arc length reached.
    segment: usize,
    way: f64,
}

impl Follower {
    /// Distance of a setpoint from the stretch of path up to `reach` mm around the place that the
    /// setpoint before it had come to.
    ///
    /// The place moves on only as far as it must to stay within `band` mm of the setpoint: where
    /// the path folds back on itself it does not skip the fold.
    pub fn distance(&mut self, track: &Track, x: &[f64], reach: f64, band: f64) -> f64 {
        let last = track.len() - 1;
        if last == 0 {
            return distance(track.point(0), x);
        }
        let mut lo = self.segment;
        while lo > 0 && track.way[lo] > self.way - reach {
            lo -= 1;
        }
        let mut best = f64::INFINITY;
        let mut nearest = (self.segment, self.way);
        let mut place = None;
        for k in lo..last {
            if k > self.segment && track.way[k] > self.way + reach {
                break;
            }
            let (a, b) = (track.point(k), track.point(k + 1));
            let length = track.way[k + 1] - track.way[k];
            let along: f64 = a.iter().zip(b).zip(x).map(|((a, b), x)| (x - a) * (b - a)).sum();
            let off = |t: f64| {
                let square = |((a, b), x): ((&f64, &f64), &f64)| (a + t * (b - a) - x).powi(2);
                a.iter().zip(b).zip(x).map(square).sum::<f64>().sqrt()
            };
            let t = (along / (length * length)).clamp(0.0, 1.0);
            if off(t) < best {
                best = off(t);
                nearest = (k, track.way[k] + t * length);
            }
            if k >= self.segment && place.is_none() {
                // Never back: a path that is run to and fro is passed twice.
                let t = t.max((self.way - track.way[k]) / length).min(1.0);
                if off(t) <= band {
                    place = Some((k, track.way[k] + t * length));
                }
            }
        }
        let (segment, way) = place.unwrap_or(nearest);
        if way > self.way {
            self.way = way;
            self.segment = segment;
        }
        best
    }
}
