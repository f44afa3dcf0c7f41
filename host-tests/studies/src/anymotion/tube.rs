//! The band of a path of lines, and which part of it a motion is in when.

use super::motion::Motion;

/// A line of the path.
#[derive(Clone, Debug)]
pub struct Segment {
    /// Start, over the axes in use.
    pub from: Vec<f64>,
    /// Unit direction.
    pub direction: Vec<f64>,
    /// mm.
    pub length: f64,
    /// Half the width of its band, mm.
    pub band: f64,
    /// Greatest speed over the axes that count for it, mm/s.
    pub feed: f64,
}

impl Segment {
    /// Cosine of the turn to another.
    pub fn cosine_to(&self, next: &Self) -> f64 {
        self.direction.iter().zip(&next.direction).map(|(a, b)| a * b).sum()
    }

    /// Distance of a point from it, and the place next to that, mm from its start.
    pub fn distance(&self, x: &[f64]) -> (f64, f64) {
        let off = || x.iter().zip(&self.from).zip(&self.direction);
        let along: f64 = off().map(|((x, a), d)| (x - a) * d).sum();
        let along = along.clamp(0.0, self.length);
        let square: f64 = off().map(|((x, a), d)| (x - a - d * along).powi(2)).sum();
        (square.sqrt(), along)
    }
}

/// A place of the motion that has to lie in the band of a segment.
#[derive(Clone, Copy, Debug)]
pub struct Check {
    /// Interval and share of it.
    pub interval: usize,
    /// See `interval`.
    pub share: f64,
    pub segment: usize,
    /// Share of the segment's band that may be used.
    pub part: f64,
}

/// What a round is made for: the places, and which intervals share a change of their duration.
#[derive(Clone, Debug)]
pub struct Plan {
    pub checks: Vec<Check>,
    /// The segment of the last place before every knot.
    pub segments: Vec<usize>,
    /// Block of every interval.
    pub blocks: Vec<usize>,
}

/// Segments that are looked at around a guess.
const WINDOW: usize = 40;
/// Places of an interval; of a path of lines hardly longer than the band is wide.
const PARTS: usize = 2;
const DENSE_PARTS: usize = 4;
/// Beyond the band a distance counts so much more.
const OUTSIDE: f64 = 1.0e3;

/// The segments of places in order: those of least distance in all, none before the one of the place before.
pub fn associate(path: &[Segment], places: &[Vec<f64>]) -> Vec<usize> {
    let window = WINDOW.min(path.len());
    let base: Vec<usize> = guess(path, places)
        .into_iter()
        .map(|guess| guess.saturating_sub(window / 2).min(path.len() - window))
        .collect();
    let cost = |k: usize, q: usize| {
        let segment = &path[base[k] + q];
        let off = segment.distance(&places[k]).0 / segment.band;
        off * off + if off > 1.02 { OUTSIDE * off } else { 0.0 }
    };
    let mut costs: Vec<f64> =
        (0..window).map(|q| cost(0, q) + 1e-3 * (base[0] + q) as f64).collect();
    let mut back: Vec<Vec<u16>> = vec![vec![0; window]];
    for k in 1..places.len() {
        // The best up to each, and which that is.
        let mut best = vec![(f64::INFINITY, 0u16); window];
        let mut least = (f64::INFINITY, 0u16);
        for q in 0..window {
            if costs[q] < least.0 {
                least = (costs[q], q as u16);
            }
            best[q] = least;
        }
        // Guesses never go back.
        let ahead = base[k] - base[k - 1];
        let mut from = vec![0; window];
        costs = (0..window)
            .map(|q| {
                let (least, which) = best[(q + ahead).min(window - 1)];
                from[q] = which;
                cost(k, q) + least
            })
            .collect();
        back.push(from);
    }
    let mut q = (0..window).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
    let mut found = vec![0; places.len()];
    for k in (0..places.len()).rev() {
        found[k] = base[k] + q;
        q = usize::from(back[k][q]);
    }
    found
}

/// The nearest segment not far from the place before.
fn guess(path: &[Segment], places: &[Vec<f64>]) -> Vec<usize> {
    let mut starts = vec![0.0];
    for segment in path {
        starts.push(starts[starts.len() - 1] + segment.length);
    }
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let step = places.windows(2).map(|pair| apart(&pair[0], &pair[1])).fold(0.0, f64::max).sqrt();
    let widest = path.iter().map(|segment| segment.band).fold(0.0, f64::max);
    let reach = 2.0 * step + 20.0 * widest + 0.2;
    let mut way = 0.0f64;
    places
        .iter()
        .map(|x| {
            let first = starts.partition_point(|s| *s <= way - reach).max(1) - 1;
            let last = starts.partition_point(|s| *s < way + reach).clamp(first + 1, path.len());
            let mut nearest = (f64::INFINITY, 0.0);
            for i in first..last {
                let (off, along) = path[i].distance(x);
                if off < nearest.0 - 1e-9 {
                    nearest = (off, starts[i] + along);
                }
            }
            way = way.max(nearest.1);
            (starts.partition_point(|s| *s <= way).max(1) - 1).min(path.len() - 1)
        })
        .collect()
}

impl Plan {
    /// Of a motion as it is; at most `block` intervals change alike.
    pub fn new(path: &[Segment], motion: &Motion, band: &Band, block: usize) -> Self {
        let parts = band.parts;
        let steps = motion.steps();
        let dense = is_dense(path);
        let (places, positions) = places(motion, parts);
        let found = associate(path, &positions);
        let check = |n: usize, segment: usize| {
            let (interval, share) = places[n];
            Check { interval, share, segment, part: band.used[n] }
        };
        let mut checks: Vec<Check> = (0..found.len()).map(|n| check(n, found[n])).collect();
        let mut breaks = vec![false; steps];
        // Where one segment follows the other, a place lies in both bands.
        for q in 0..found.len().saturating_sub(1) {
            if found[q + 1] != found[q] + 1 {
                continue;
            }
            let (a, b) = (&path[found[q]], &path[found[q] + 1]);
            let off = |n: &usize| {
                let x = &positions[*n];
                (a.distance(x).0 / a.band).max(b.distance(x).0 / b.band)
            };
            let near = q.saturating_sub(1)..(q + 3).min(found.len());
            let Some(n) = near.min_by(|m, n| off(m).total_cmp(&off(n))) else { continue };
            let (shorter, band) = (a.length.min(b.length), a.band.max(b.band));
            let cosine = a.cosine_to(b);
            let joined = if shorter > if dense { 20.0 } else { 4.0 } * band {
                breaks[places[n].0] = true;
                !dense || off(&n) <= 1.3
            } else {
                cosine < 0.9995 && off(&n) <= if cosine > 0.87 { 1.15 } else { 2.0 }
            };
            if joined {
                let other = if found[n] == found[q] { found[q] + 1 } else { found[q] };
                checks.push(check(n, other));
            }
        }
        let mut blocks = Vec::with_capacity(steps);
        let (mut number, mut count) = (0, 0);
        for breaks in breaks {
            if count >= block || (breaks && count >= 3) {
                (number, count) = (number + 1, 0);
            }
            blocks.push(number);
            count += 1;
        }
        let knot = |k: usize| found[(k * parts).clamp(1, found.len()) - 1];
        Self { checks, segments: (0..=steps).map(knot).collect(), blocks }
    }
}

/// How much of the band is used at the places that are looked at.
#[derive(Clone, Debug)]
pub struct Band {
    /// Places of an interval.
    parts: usize,
    /// Shares of the band, place by place.
    used: Vec<f64>,
}

/// Times as many places are looked at to see where the band is left.
const FINER: usize = 4;
/// What is left of the band where it is used less: beyond what was seen, and at least.
const RESERVE: f64 = 0.003;
const LEAST_USED: f64 = 0.7;

impl Band {
    /// All of it.
    pub fn whole(path: &[Segment], motion: &Motion) -> Self {
        let parts = if is_dense(path) { DENSE_PARTS } else { PARTS };
        Self { parts, used: vec![1.0; motion.steps() * parts - 1] }
    }

    /// Uses less of it where a motion leaves the whole of it between places by more than a share of it. Whether there is such
    /// a place.
    pub fn tighten(&mut self, path: &[Segment], motion: &Motion, share: f64) -> bool {
        let (_, positions) = places(motion, self.parts * FINER);
        let found = associate(path, &positions);
        let mut factors = vec![1.0f64; self.used.len()];
        for (n, (x, segment)) in positions.iter().zip(found).enumerate() {
            let segment = &path[segment];
            let off = segment.distance(x).0 / segment.band;
            if off <= 1.0 + share {
                continue;
            }
            let near = (n + 1) / FINER;
            for place in [near.saturating_sub(1), near.min(factors.len() - 1)] {
                factors[place] = factors[place].min(1.0 / off - RESERVE);
            }
        }
        for (used, factor) in self.used.iter_mut().zip(&factors) {
            *used = (*used * factor).max(LEAST_USED);
        }
        factors.iter().any(|factor| *factor < 1.0)
    }
}

/// Intervals with shares of them, and the positions there.
fn places(motion: &Motion, parts: usize) -> (Vec<(usize, f64)>, Vec<Vec<f64>>) {
    let place = |n: usize| (n / parts, (n % parts) as f64 / parts as f64);
    let places: Vec<(usize, f64)> = (1..motion.steps() * parts).map(place).collect();
    let positions = places.iter().map(|&(k, share)| motion.within(k, share)).collect();
    (places, positions)
}

/// Whether most lines are hardly longer than the band is wide.
fn is_dense(path: &[Segment]) -> bool {
    let mut lengths: Vec<f64> = path.iter().map(|segment| segment.length / segment.band).collect();
    lengths.sort_by(f64::total_cmp);
    lengths[lengths.len() / 2] < 20.0
}
