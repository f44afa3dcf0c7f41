//! The programmed path for plots: the vertices that it takes.

use super::columns::Column;
use crate::judge::Track;

/// Vertices that may be left out one after the other.
const MOST: usize = 256;

/// The programmed path over its first three axes, thinned by geometry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Number of vertices.
    pub vertices: usize,
    /// Differences of their coordinates in counts, a column for each axis.
    pub columns: [Column; 3],
    /// Tolerances in force: for how many vertices, and how many counts.
    pub tolerances: Column,
    /// One count, mm.
    pub count: f64,
}

impl Outline {
    /// Of a path whose moves have the tolerance `default`, mm, if they name none; `off` by this much at most, mm.
    pub fn new(track: &Track, default: f64, off: f64) -> Self {
        let mut outline = Self { count: off / 8.0, ..Self::default() };
        let axes = track.axes.min(3);
        let mut here = [0i64; 3];
        let mut run = (0u64, 0u64);
        for k in kept(track, default, off * 0.75) {
            for (n, slot) in here.iter_mut().enumerate().take(axes) {
                let there = (track.point(k)[n] / outline.count).round() as i64;
                outline.columns[n].number(there - std::mem::replace(slot, there));
            }
            let tolerance = (track.tolerance(k, default) / outline.count).round() as u64;
            if tolerance != run.1 && run.0 > 0 {
                outline.tolerances.count(run.0);
                outline.tolerances.count(run.1);
                run.0 = 0;
            }
            run = (run.0 + 1, tolerance);
            outline.vertices += 1;
        }
        if run.0 > 0 {
            outline.tolerances.count(run.0);
            outline.tolerances.count(run.1);
        }
        outline
    }
}

/// Vertices such that all others are within `off` of the lines between them.
fn kept(track: &Track, default: f64, off: f64) -> Vec<usize> {
    let axes = track.axes.min(3);
    let mut kept = vec![0];
    let mut from = 0;
    while from + 1 < track.len() {
        let mut good = from + 1;
        let mut step = 1;
        // As long as it goes: twice as far, then half of it.
        while step > 0 {
            let next = good + step;
            if next < track.len()
                && next - from <= MOST
                && spans(track, default, (from, next), off, axes)
            {
                good = next;
                step *= 2;
            } else {
                step /= 2;
            }
        }
        kept.push(good);
        from = good;
    }
    kept
}

/// Whether a line between two vertices passes all between them.
fn spans(track: &Track, default: f64, (from, to): (usize, usize), off: f64, axes: usize) -> bool {
    let (a, b) = (&track.point(from)[..axes], &track.point(to)[..axes]);
    let way: Vec<f64> = a.iter().zip(b).map(|(a, b)| b - a).collect();
    let square = way.iter().map(|x| x * x).sum::<f64>().max(1e-300);
    let tolerance = track.tolerance(to, default);
    let mut along = 0.0;
    (from + 1..to).all(|k| {
        let x = &track.point(k)[..axes];
        let t: f64 = x.iter().zip(a).zip(&way).map(|((x, a), w)| (x - a) * w).sum::<f64>() / square;
        let beside = x.iter().zip(a).zip(&way).map(|((x, a), w)| (x - a - t * w).powi(2));
        // A line that goes back on itself is none.
        let forward = (along..=1.0).contains(&t);
        along = t;
        forward
            && beside.sum::<f64>() <= off * off
            && track.tolerance(k, default).to_bits() == tolerance.to_bits()
    })
}
