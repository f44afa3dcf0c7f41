//! The programmed path as a fine poly-line, to hold setpoints against: arcs as they are meant, and of a
//! curve file the curve itself, not the blocks that stand for it.

use crate::program::arc::Spiral;
use crate::program::{Course, Move, Point, Program, on_cubic};
use crate::spline::Rational;
use splineway::block::FINEST_BAND;

/// Arcs and curves are cut into chords that leave them by no more than this, mm.
pub const SAGITTA: f64 = 1.0e-6;
/// A move is cut into no more chords than this.
const MOST: usize = 2_000_000;
/// Curves are halved no more often than this.
const HALVINGS: u32 = 20;

/// Where the path was left furthest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// Distance beyond the tolerance there, mm.
    pub distance: f64,
    /// Tolerance there, mm.
    pub tolerance: f64,
    /// Line of the move.
    pub line: u32,
}

impl Default for Outside {
    fn default() -> Self {
        Self { distance: f64::NEG_INFINITY, tolerance: 0.0, line: 0 }
    }
}

/// The programmed path over the axes in use.
#[derive(Clone, Debug)]
pub struct Track {
    /// Number of axes.
    pub axes: usize,
    /// Vertices, one after the other.
    points: Vec<f64>,
    /// Arc length up to each vertex.
    way: Vec<f64>,
    /// The move that leads to each vertex.
    moves: Vec<u32>,
    /// Tolerance of every move, if it names one, the least that it has whatever is named, and its line.
    bands: Vec<(Option<f64>, f64, u32)>,
}

impl Track {
    /// The path of a program.
    pub fn new(program: &Program) -> Self {
        let axes = program.axes();
        let mut track = Self {
            axes: axes.len(),
            points: Vec::new(),
            way: Vec::new(),
            moves: Vec::new(),
            bands: Vec::new(),
        };
        let mut here = program.start;
        track.add(&here, &axes);
        for (n, step) in program.moves.iter().enumerate() {
            let least = if matches!(step.path, Course::Arc { .. }) { FINEST_BAND } else { 0.0 };
            track.bands.push((step.tolerance, least, step.line));
            match program.exact.get(n) {
                Some(curve) => track.curve(curve, &axes, 0),
                None => track.course(step, &here, &axes),
            }
            if let Some(to) = step.path.end() {
                here = *to;
            }
        }
        track
    }

    fn course(&mut self, step: &Move, here: &Point, axes: &[usize]) {
        match &step.path {
            Course::Line { to } => self.add(to, axes),
            Course::Arc { to, .. } => {
                let Some(arc) = Spiral::of(&step.path, here) else { return };
                let radius = arc.radii.0.max(arc.radii.1).max(1e-9);
                let chord = (8.0 * radius * SAGITTA).sqrt();
                let n = ((radius * arc.sweep.abs() / chord).ceil() as usize).clamp(8, MOST);
                for k in 1..n {
                    self.add(&arc.point(k as f64 / n as f64), axes);
                }
                self.add(to, axes);
            }
            Course::Cubic { controls, to } => {
                let bend = [(here, &controls[0], &controls[1]), (&controls[0], &controls[1], to)]
                    .map(|(a, b, c)| {
                        let x = (0..a.len()).map(|i| a[i] - 2.0 * b[i] + c[i]);
                        6.0 * x.map(|x| x * x).sum::<f64>().sqrt()
                    });
                let n = (bend[0].max(bend[1]) / (8.0 * SAGITTA)).sqrt().ceil();
                let n = (n as usize).clamp(8, MOST);
                for k in 1..=n {
                    self.add(&on_cubic(here, controls, to, k as f64 / n as f64), axes);
                }
            }
            Course::Dwell { .. } | Course::Event { .. } => {}
        }
    }

    /// A curve, halved until its chords are near enough.
    fn curve(&mut self, curve: &Rational, axes: &[usize], depth: u32) {
        if depth == HALVINGS || curve.is_flat(SAGITTA) {
            self.add(&curve.point(1.0), axes);
        } else {
            for half in curve.halves() {
                self.curve(&half, axes, depth + 1);
            }
        }
    }

    fn add(&mut self, point: &Point, axes: &[usize]) {
        let start = self.points.len();
        self.points.extend(axes.iter().map(|&axis| point[axis]));
        let step = match start.checked_sub(self.axes) {
            Some(before) => distance(&self.points[before..start], &self.points[start..]),
            None => 0.0,
        };
        if start > 0 && step < 1e-9 {
            self.points.truncate(start);
            return;
        }
        self.way.push(self.way.last().copied().unwrap_or(0.0) + step);
        self.moves.push((self.bands.len() as u32).saturating_sub(1));
    }

    /// The widest tolerance of any move, mm; `default` is that of moves which name none.
    pub fn widest(&self, default: f64) -> f64 {
        let named = self.bands.iter().map(|(band, least, _)| band.unwrap_or(default).max(*least));
        named.fold(default, f64::max)
    }

    /// The tolerance of the move that leads to a vertex, mm; `default` is that of moves which name none.
    pub fn tolerance(&self, k: usize, default: f64) -> f64 {
        self.band(k, default).0
    }

    /// The least tolerance of any move, mm.
    pub fn finest(&self, default: f64) -> f64 {
        let named = self.bands.iter().map(|(band, least, _)| band.unwrap_or(default).max(*least));
        named.fold(f64::INFINITY, f64::min).min(default)
    }

    /// Tolerance and line of the move that leads to a vertex.
    fn band(&self, k: usize, default: f64) -> (f64, u32) {
        let band = self.moves.get(k).and_then(|&step| self.bands.get(step as usize));
        band.map_or((default, 0), |&(band, least, line)| (band.unwrap_or(default).max(least), line))
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

/// How far a setpoint is from the path.
#[derive(Clone, Copy, Debug)]
pub struct Off {
    /// Distance, mm.
    pub distance: f64,
    /// Least distance beyond the tolerance in force at a place near by.
    pub outside: Outside,
}

/// Follows the path in order and measures how far setpoints are from it.
#[derive(Clone, Debug, Default)]
pub struct Follower {
    /// Segment and arc length reached at least.
    segment: usize,
    way: f64,
    /// Arc length that may have been reached: where the path winds within its band, nobody can tell which turn it is.
    far: f64,
    /// The setpoint before.
    last: Vec<f64>,
}

impl Follower {
    /// Distance of a setpoint from the stretch of path up to `reach` mm around the places that the
    /// setpoint before it had come to, at least and at most; `default` is the tolerance of moves which name none.
    ///
    /// Where two tolerances meet, the lesser is in force at the corner. The first place moves on only as far as
    /// it must to stay within the tolerance: where the path folds back on itself it does not skip the fold. The
    /// other moves on as long as the path stays within the tolerance: where it winds there, that may be many turns.
    pub fn look(&mut self, track: &Track, x: &[f64], reach: f64, default: f64) -> Off {
        let mut best = Off { distance: f64::INFINITY, outside: Outside::default() };
        best.outside.distance = f64::INFINITY;
        let last = track.len() - 1;
        if last == 0 {
            let off = distance(track.point(0), x);
            let outside = Outside { distance: off, tolerance: 0.0, line: 0 };
            return Off { distance: off, outside };
        }
        let mut lo = self.segment;
        while lo > 0 && track.way[lo] > self.way - reach {
            lo -= 1;
        }
        let mut nearest = (self.segment, self.way);
        let mut place = None;
        let step = if self.last.is_empty() { 0.0 } else { distance(&self.last, x) };
        let mut winding = Winding::new(self.way, self.far + 2.0 * step);
        for k in lo..last {
            if k > self.segment && track.way[k] > self.far + reach {
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
            let distance = off(t);
            if distance < best.distance {
                best.distance = distance;
                nearest = (k, track.way[k] + t * length);
            }
            let (own, line) = track.band(k + 1, default);
            let tolerance = if t <= 0.0 && k > 0 {
                own.min(track.band(k, default).0)
            } else if t >= 1.0 && k + 1 < last {
                own.min(track.band(k + 2, default).0)
            } else {
                own
            };
            if distance - tolerance < best.outside.distance {
                best.outside = Outside { distance: distance - tolerance, tolerance, line };
            }
            if k >= self.segment && place.is_none() {
                // Never back: a path that is run to and fro is passed twice.
                let t = t.max((self.way - track.way[k]) / length).min(1.0);
                if off(t) <= own * 1.001 + SAGITTA {
                    place = Some((k, track.way[k] + t * length));
                }
            }
            let t = along / (length * length);
            let band = (own * 1.001 + SAGITTA) / length;
            winding.pass((track.way[k], length), t, off(t) / length, band);
        }
        let (segment, way) = place.unwrap_or(nearest);
        if way > self.way {
            self.way = way;
            self.segment = segment;
        }
        self.far = winding.far().max(self.way);
        self.last.clear();
        self.last.extend_from_slice(x);
        best
    }

    /// Arc length reached at least, mm.
    pub const fn way(&self) -> f64 {
        self.way
    }
}

/// How far along a path a setpoint may have come: the path winds within its band there, and nobody can tell which
/// turn it is. Its lines are looked at in order.
pub struct Winding {
    /// Where it may have been before, and how far it can have gone since.
    near: f64,
    far: f64,
    /// Where the stretch within the band began that reaches to the end of the last line.
    begin: Option<f64>,
}

impl Winding {
    /// At a place at least; `near` is how far it can be at most without having left the band.
    pub fn new(way: f64, near: f64) -> Self {
        Self { near, far: way, begin: None }
    }

    /// The next line, which begins at arc length `start` and is `length` long. As shares of its length, the
    /// setpoint lies `along` it and `off` it, and the band is so wide.
    pub fn pass(&mut self, (start, length): (f64, f64), along: f64, off: f64, band: f64) {
        let half = (band * band - off * off).sqrt();
        let (from, to) = (along - half, along + half);
        let before = self.begin.take();
        // A NaN is neither.
        if from <= 1.0 && to >= 0.0 {
            let begin = before.filter(|_| from <= 0.0);
            let begin = begin.unwrap_or(start + from.max(0.0) * length);
            if begin <= self.near {
                self.far = self.far.max(start + to.min(1.0) * length);
            }
            self.begin = (to >= 1.0).then_some(begin);
        }
    }

    /// How far it may have come.
    pub fn far(&self) -> f64 {
        self.far
    }
}
