//! The path that the blocks taken so far ask for, as the referee sees it.
//!
//! Curves are chords, made where they are looked at: an arc of a hundred turns takes no memory.

use splineway::block::FINEST_BAND;
use splineway_simulator::judge::Winding;
use splineway_simulator::program::arc::Spiral;
use splineway_simulator::program::{Course, Point};

/// How far chords may leave their curve, as a share of the tolerance and at least, mm.
const SAGITTA: (f64, f64) = (1.0e-3, 1.0e-7);
/// Rounding that no band is asked to hold, per scalar, mm.
const ROUNDING: [f64; 2] = [1.0e-5, 2.0e-6];
/// Looseness of the band.
const SLACK: f64 = 1.002;

/// One block's part of the path.
#[derive(Clone, Debug)]
struct Segment {
    from: Point,
    shape: Course,
    /// What an arc is.
    spiral: Option<Spiral>,
    chords: u32,
    /// Length of a chord, nearly; path before the segment, mm.
    chord: f64,
    way: f64,
    /// Path up to every chord of a curve, mm: they are of different lengths where it turns sharply.
    ways: Vec<f64>,
    /// Greatest distance allowed, mm.
    band: f64,
    tag: u32,
}

impl Segment {
    fn at(&self, k: u32) -> Point {
        let u = f64::from(k) / f64::from(self.chords);
        let (from, mut place) = (&self.from, self.from);
        match &self.shape {
            Course::Line { to } => {
                if k == self.chords {
                    return *to;
                }
                for axis in 0..place.len() {
                    place[axis] += (to[axis] - from[axis]) * u;
                }
            }
            Course::Arc { to, .. } => {
                if k == self.chords {
                    return *to;
                }
                if let Some(spiral) = self.spiral {
                    return spiral.point(u);
                }
            }
            Course::Cubic { controls, to } => {
                place = splineway_simulator::program::on_cubic(from, controls, to, u);
            }
            Course::Dwell { .. } | Course::Event { .. } => {}
        }
        place
    }

    /// Path up to a chord, mm.
    fn start(&self, k: u32) -> f64 {
        let way = self.ways.get(k as usize).copied();
        self.way + way.unwrap_or(self.chord * f64::from(k))
    }

    /// The chord at some path.
    fn chord_at(&self, way: f64) -> u32 {
        let way = (way - self.way).max(0.0);
        let k = if self.ways.is_empty() {
            (way / self.chord) as u32
        } else {
            self.ways.partition_point(|start| *start <= way).saturating_sub(1) as u32
        };
        k.min(self.chords - 1)
    }

    fn end(&self) -> f64 {
        self.start(self.chords)
    }
}

/// The path, and how far along it the motion has come.
#[derive(Clone, Debug)]
pub struct Path {
    axes: usize,
    rounding: f64,
    segments: Vec<Segment>,
    end: Point,
    /// Segment, chord and path reached at least.
    at: (usize, u32),
    way: f64,
    /// Path that may have been reached: where it winds within its band, nobody can tell which turn it is.
    far: f64,
    /// The setpoint before.
    last: Point,
}

/// How a setpoint lies to the path.
#[derive(Clone, Copy, Debug)]
pub struct Off {
    /// By how much it is farther off than its place allows, mm; below 0 if it is not.
    pub excess: f64,
    /// Distance, mm, and what was allowed.
    pub distance: f64,
    /// As above.
    pub band: f64,
    /// Block nearest to it.
    pub tag: u32,
}

impl Path {
    /// A path that starts at a place, for a core in `f64` or not.
    pub fn new(start: Point, axes: usize, double: bool) -> Self {
        let rounding = ROUNDING[usize::from(double)];
        let (segments, at) = (Vec::new(), (0, 0));
        Self { axes, rounding, segments, end: start, at, way: 0.0, far: 0.0, last: start }
    }

    /// Where it ends.
    pub fn end(&self) -> &Point {
        &self.end
    }

    /// Its length, mm, nearly.
    pub fn length(&self) -> f64 {
        self.segments.last().map_or(0.0, Segment::end)
    }

    /// Adds a block; returns its length, mm.
    pub fn append(&mut self, shape: &Course, tolerance: f64, tag: u32) -> f64 {
        let from = self.end;
        let spiral = Spiral::of(shape, &from);
        let tolerance = if spiral.is_some() { tolerance.max(FINEST_BAND) } else { tolerance };
        let sagitta = SAGITTA.1.max(tolerance * SAGITTA.0);
        let (to, chords) = match shape {
            Course::Line { to } => (*to, 1.0),
            Course::Arc { to, .. } => {
                let (radius, turn) = spiral.map_or((0.0, 0.0), |spiral| {
                    (spiral.radii.0.max(spiral.radii.1).max(1.0e-9), spiral.sweep.abs())
                });
                (*to, (radius * turn / (8.0 * radius * sagitta).sqrt()).ceil().max(8.0))
            }
            Course::Cubic { controls, to } => {
                let bend = |a: &Point, b: &Point, c: &Point| {
                    6.0 * (0..self.axes)
                        .map(|i| (a[i] - 2.0 * b[i] + c[i]).powi(2))
                        .sum::<f64>()
                        .sqrt()
                };
                let most = bend(&from, &controls[0], &controls[1]).max(bend(
                    &controls[0],
                    &controls[1],
                    to,
                ));
                (*to, (most / (8.0 * sagitta)).sqrt().ceil().max(8.0))
            }
            Course::Dwell { .. } | Course::Event { .. } => return 0.0,
        };
        let mut segment = Segment {
            from,
            shape: shape.clone(),
            spiral,
            chords: chords.clamp(1.0, 1.0e7) as u32,
            chord: 0.0,
            way: self.length(),
            ways: Vec::new(),
            band: tolerance * SLACK + sagitta + self.rounding,
            tag,
        };
        let length = match shape {
            Course::Arc { .. } => {
                let axes: Vec<usize> = (0..self.axes).collect();
                spiral.map_or(0.0, |spiral| spiral.length(&axes))
            }
            Course::Cubic { .. } => {
                let mut way = 0.0;
                segment.ways.push(way);
                for k in 0..segment.chords {
                    way += self.distance(&segment.at(k), &segment.at(k + 1));
                    segment.ways.push(way);
                }
                way
            }
            _ => self.distance(&from, &to),
        };
        self.end = to;
        if length < 1.0e-12 {
            return 0.0;
        }
        segment.chord = length / f64::from(segment.chords);
        self.segments.push(segment);
        length
    }

    fn distance(&self, a: &Point, b: &Point) -> f64 {
        (0..self.axes).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>().sqrt()
    }

    /// Whether all that is left of the path is near its end: where it winds within its band, the place
    /// reached lags behind.
    pub fn is_done(&self, near: f64) -> bool {
        let widest = self.segments.get(self.at.0).map_or(0.0, |segment| segment.band);
        let mut k = self.at.1 + 1;
        for segment in self.segments.iter().skip(self.at.0) {
            while k <= segment.chords {
                if self.distance(&segment.at(k), &self.end) > near + 4.0 * segment.band.max(widest)
                {
                    return false;
                }
                k += (segment.chords / 256).max(1);
            }
            k = 0;
        }
        true
    }

    /// Path that is left, mm.
    pub fn left(&self) -> f64 {
        (self.length() - self.way).max(0.0)
    }

    /// How a setpoint lies to the stretch of path between the places that have been reached at least and at most,
    /// `reach` mm beyond what the band there lets corners cut off. The one moves on only as far as it must to have
    /// the setpoint in its band: where the path folds back on itself it does not skip the fold. The other moves on
    /// as long as the path stays in the setpoint's band: where it winds in there, that may be many turns.
    pub fn follow(&mut self, x: &Point, reach: f64) -> Off {
        let Some(first) = self.segments.get(self.at.0) else {
            let distance = self.distance(&self.end, x);
            return Off { excess: distance - self.rounding, distance, band: 0.0, tag: 0 };
        };
        // A sharp corner inside the band cuts off this much of the path.
        let reach = reach + 20.0 * first.band;
        let mut best =
            Off { excess: f64::INFINITY, distance: f64::INFINITY, band: 0.0, tag: first.tag };
        let (mut nearest, mut place) = ((self.at, self.way), None);
        let near = self.far + 2.0 * self.distance(&self.last, x);
        let mut winding = Winding::new(self.way, near);
        // Back by the reach.
        let (mut n, mut k) = self.at;
        let from = self.way - reach;
        while n > 0 && self.segments[n].way > from {
            n -= 1;
            k = 0;
        }
        k = if n == self.at.0 {
            k.min(self.segments[n].chord_at(from))
        } else {
            self.segments[n].chord_at(from)
        };
        while let Some(segment) = self.segments.get(n) {
            k = k.min(segment.chords - 1);
            let mut a = segment.at(k);
            while k < segment.chords {
                let start = segment.start(k);
                let length = (segment.start(k + 1) - start).max(1.0e-15);
                if start > self.far + reach {
                    break;
                }
                let b = segment.at(k + 1);
                let (mut along, mut square) = (0.0, 0.0);
                for i in 0..self.axes {
                    along += (x[i] - a[i]) * (b[i] - a[i]);
                    square += (b[i] - a[i]) * (b[i] - a[i]);
                }
                let off = |t: f64| {
                    (0..self.axes)
                        .map(|i| (a[i] + t * (b[i] - a[i]) - x[i]).powi(2))
                        .sum::<f64>()
                        .sqrt()
                };
                let t = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
                let distance = off(t);
                if distance - segment.band < best.excess {
                    best = Off {
                        excess: distance - segment.band,
                        distance,
                        band: segment.band,
                        tag: segment.tag,
                    };
                    nearest = ((n, k), start + t * length);
                }
                if place.is_none() && (n, k) >= self.at {
                    // Never back: a path that is run to and fro is passed twice.
                    let t = t.max((self.way - start) / length).min(1.0);
                    if off(t) <= segment.band {
                        place = Some(((n, k), start + t * length));
                    }
                }
                if square > 0.0 {
                    let (t, whole) = (along / square, square.sqrt());
                    winding.pass((start, length), t, off(t) / whole, segment.band / whole);
                }
                a = b;
                k += 1;
            }
            if segment.end() > self.far + reach {
                break;
            }
            (n, k) = (n + 1, 0);
        }
        let (at, way) = place.unwrap_or(nearest);
        if way > self.way || at > self.at {
            (self.at, self.way) = (at, way.max(self.way));
        }
        (self.far, self.last) = (winding.far().max(self.way), *x);
        best
    }
}
