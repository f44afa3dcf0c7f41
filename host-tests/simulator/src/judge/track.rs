//! The programmed path as a fine poly-line, to hold setpoints against: arcs as they are meant, and of a
//! curve file the curve itself, not the blocks that stand for it. All of it, or the stretch that a [`Follower`] is on.

use crate::program::arc::Spiral;
use crate::program::{Course, Move, Point, Program, Tape, on_cubic};
use crate::spline::Rational;

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
    /// Their indices.
    indices: Vec<usize>,
    /// Where the path has come to with what has been added.
    here: Point,
    /// Vertices, and moves, that have been left behind.
    gone: [usize; 2],
    /// Vertices, one after the other.
    points: Vec<f64>,
    /// Arc length up to each vertex.
    way: Vec<f64>,
    /// The move that leads to each vertex.
    moves: Vec<u32>,
    /// Tolerance of every move, if it names one, the least that it has whatever is named, and its line.
    bands: Vec<(Option<f64>, f64, u32)>,
    /// The widest tolerance that a move names, or has.
    widest: f64,
}

impl Track {
    /// The path of a program.
    pub fn new(program: &Program) -> Self {
        Self::of(program)
    }

    /// The same, gone through.
    pub fn of(program: &dyn Tape) -> Self {
        let mut track = Self::begin(program);
        for (n, step) in program.steps().enumerate() {
            track.extend(&step, program.exact().get(n));
        }
        track
    }

    /// Its first point.
    pub fn begin(program: &dyn Tape) -> Self {
        let indices = program.axes();
        let mut track = Self {
            axes: indices.len(),
            indices,
            here: program.start(),
            gone: [0; 2],
            points: Vec::new(),
            way: Vec::new(),
            moves: Vec::new(),
            bands: Vec::new(),
            widest: 0.0,
        };
        track.add(&program.start());
        track
    }

    /// A further move, or the curve that it stands for.
    pub fn extend(&mut self, step: &Move, exact: Option<&Rational>) {
        let least = step.least_band();
        self.widest = self.widest.max(step.tolerance.unwrap_or(0.0)).max(least);
        self.bands.push((step.tolerance, least, step.line));
        match exact {
            Some(curve) => self.curve(curve, 0),
            None => self.course(step),
        }
        if let Some(to) = step.path.end() {
            self.here = *to;
        }
    }

    /// Leaves behind what lies before an arc length, all but a vertex. The numbers of the others stay.
    pub fn forget(&mut self, way: f64) {
        let before = self.way.partition_point(|end| *end < way).saturating_sub(1);
        // Not worth the while for a few.
        if before < 1024 || before < self.way.len() / 2 {
            return;
        }
        self.points.drain(..before * self.axes);
        self.way.drain(..before);
        self.moves.drain(..before);
        self.gone[0] += before;
        let first = self.moves.first().map_or(0, |&step| step as usize) - self.gone[1];
        // The band of the vertex before counts at a corner.
        let first = first.saturating_sub(1);
        self.bands.drain(..first);
        self.gone[1] += first;
    }

    fn course(&mut self, step: &Move) {
        let here = self.here;
        let here = &here;
        match &step.path {
            Course::Line { to } => self.add(to),
            Course::Arc { to, .. } => {
                let Some(arc) = Spiral::of(&step.path, here) else { return };
                let radius = arc.radii.0.max(arc.radii.1).max(1e-9);
                let chord = (8.0 * radius * SAGITTA).sqrt();
                let n = ((radius * arc.sweep.abs() / chord).ceil() as usize).clamp(8, MOST);
                for k in 1..n {
                    self.add(&arc.point(k as f64 / n as f64));
                }
                self.add(to);
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
                    self.add(&on_cubic(here, controls, to, k as f64 / n as f64));
                }
            }
            Course::Dwell { .. } | Course::Event { .. } => {}
        }
    }

    /// A curve, halved until its chords are near enough.
    fn curve(&mut self, curve: &Rational, depth: u32) {
        if depth == HALVINGS || curve.is_flat(SAGITTA) {
            self.add(&curve.point(1.0));
        } else {
            for half in curve.halves() {
                self.curve(&half, depth + 1);
            }
        }
    }

    fn add(&mut self, point: &Point) {
        let start = self.points.len();
        self.points.extend(self.indices.iter().map(|&axis| point[axis]));
        let step = match start.checked_sub(self.axes) {
            Some(before) => distance(&self.points[before..start], &self.points[start..]),
            None => 0.0,
        };
        if start > 0 && step < 1e-9 {
            self.points.truncate(start);
            return;
        }
        self.way.push(self.way.last().copied().unwrap_or(0.0) + step);
        self.moves.push(((self.gone[1] + self.bands.len()) as u32).saturating_sub(1));
    }

    /// The widest tolerance of any move so far, mm; `default` is that of moves which name none.
    pub fn widest(&self, default: f64) -> f64 {
        self.widest.max(default)
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
        let step = k.checked_sub(self.gone[0]).and_then(|k| self.moves.get(k));
        let band =
            step.and_then(|&step| self.bands.get((step as usize).checked_sub(self.gone[1])?));
        band.map_or((default, 0), |&(band, least, line)| (band.unwrap_or(default).max(least), line))
    }

    /// Number of vertices, with those left behind.
    pub fn len(&self) -> usize {
        self.gone[0] + self.way.len()
    }

    /// Whether it has no vertex.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of the first vertex that has not been left behind.
    pub fn first(&self) -> usize {
        self.gone[0]
    }

    /// A vertex that has not been left behind.
    pub fn point(&self, k: usize) -> &[f64] {
        let k = k - self.gone[0];
        &self.points[k * self.axes..(k + 1) * self.axes]
    }

    /// Arc length up to it, mm.
    fn way(&self, k: usize) -> f64 {
        self.way[k - self.gone[0]]
    }

    /// How many vertices lie beyond an arc length, up to 3.
    pub fn beyond(&self, way: f64) -> usize {
        self.way.iter().rev().take(3).take_while(|end| **end > way).count()
    }

    /// How many vertices lie no farther along than an arc length, with those left behind.
    pub fn passed(&self, way: f64) -> usize {
        self.gone[0] + self.way.partition_point(|end| *end <= way)
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
        while lo > track.first() && track.way(lo) > self.way - reach {
            lo -= 1;
        }
        let mut nearest = (self.segment, self.way);
        let mut place = None;
        let step = if self.last.is_empty() { 0.0 } else { distance(&self.last, x) };
        let mut winding = Winding::new(self.way, self.far + 2.0 * step);
        for k in lo..last {
            if k > self.segment && track.way(k) > self.far + reach {
                break;
            }
            let (a, b) = (track.point(k), track.point(k + 1));
            let length = track.way(k + 1) - track.way(k);
            let along: f64 = a.iter().zip(b).zip(x).map(|((a, b), x)| (x - a) * (b - a)).sum();
            let off = |t: f64| {
                let square = |((a, b), x): ((&f64, &f64), &f64)| (a + t * (b - a) - x).powi(2);
                a.iter().zip(b).zip(x).map(square).sum::<f64>().sqrt()
            };
            let t = (along / (length * length)).clamp(0.0, 1.0);
            let distance = off(t);
            if distance < best.distance {
                best.distance = distance;
                nearest = (k, track.way(k) + t * length);
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
                let t = t.max((self.way - track.way(k)) / length).min(1.0);
                if off(t) <= own * 1.001 + SAGITTA {
                    place = Some((k, track.way(k) + t * length));
                }
            }
            let t = along / (length * length);
            let band = (own * 1.001 + SAGITTA) / length;
            winding.pass((track.way(k), length), t, off(t) / length, band);
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

    /// Arc length that may have been reached, mm.
    pub const fn far(&self) -> f64 {
        self.far
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
