//! The dominant points of a run: the vertices at which its poly-line turns.

use super::polyline::{Ray, VertexSerial};
use super::{Run, SMOOTH_SHARE, Tie, WAITING};
use crate::number::vector::{Vector, dot, norm, sub};
use crate::number::{Coord, Length, Scalar};
use heapless::Deque;

/// Share of the tolerance by which vertices may lie off the line between two dominant points: at
/// least this far apart knots are laid. (Half: 20 % more cells, and a circle takes 17 % longer; 0.9: no path by more
/// than 3 %.)
const COARSE: f64 = 0.7;
/// Most vertices between two dominant points. (2: 0.3 % longer, 6 % more cells; 8: no path by more than 0.4 %.)
pub(super) const PASSED: u32 = 5;
/// Length of the spans at a dominant point, times turn over tolerance: what a uniform cubic spline with
/// spans of this length cuts off is two thirds of the band. (Half: 0.5 % longer, 29 % more cells; twice: 12 % longer,
/// for the band allows no such knots.)
const DOMINANT_SPAN: f64 = 4.0;
/// Reach at a dominant point, times turn^1.5 over tolerance: see [`crate::spline::sweep`]. (Half: no path by
/// more than 1.6 %; twice: 1.3 % longer.)
const DOMINANT_REACH: f64 = 25.0;
/// Twice the sine of half the turn (100 degrees) from which on a dominant point is a rest. (74 degrees: 1 % longer.)
const BACK: f64 = 1.53;
/// Least cosine between a line and the line that stands for it and others.
const AHEAD: f64 = 0.3;
/// Spans next to each other differ in length by less than this share of the distance to a dominant point. (Half:
/// 0.2 % shorter, 1.6 % more cells; twice: no path by more than 0.4 %.)
const GRADE: f64 = 0.5;

/// A dominant point of the run: a vertex at which the poly-line turns, so that knots are laid by it. (The term is
/// Park and Lee's, 2007, "B-spline curve fitting based on adaptive curve refinement using dominant points".)
#[derive(Clone, Copy)]
pub struct DominantPoint<S, const N: usize> {
    pub s: Length,
    pub at: [Coord; N],
    /// Direction in which it is reached.
    pub direction: Vector<S, N>,
    /// Length of the spans next to it, mm.
    pub size: S,
    /// Feed of the line that ends there, mm/s.
    pub feed: S,
    /// Whether the path turns back there, so that the motion has to rest.
    pub stop: bool,
    pub tolerance: S,
}

impl<S: Scalar, const N: usize> Run<S, N> {
    /// Keeps a dominant point, for which there is room: [`Run::has_room`] leaves it.
    pub(super) fn keep(&mut self, point: DominantPoint<S, N>) {
        let kept = self.dominant.push_back(point);
        debug_assert!(kept.is_ok(), "no room for a dominant point");
    }

    /// Looks at new vertices for dominant points; the last one is one if the run is `closed` there.
    pub(super) fn look(&mut self, closed: bool) {
        // Every turn takes a vertex or makes a dominant point.
        while self.next != self.polyline.end() {
            if self.next.since(self.newest).is_some_and(|ahead| ahead > 1)
                && !self.reaches(self.next)
            {
                self.dominate(self.next.previous());
            }
            self.next = self.next.next();
        }
        let last = self.next.previous();
        if closed && last != self.newest {
            self.dominate(last);
        }
    }

    /// Whether the line from the newest dominant point to a vertex stands for all between.
    fn reaches(&self, serial: VertexSerial) -> bool {
        let (Some(point), Some(end)) = (self.dominant.back(), self.polyline.vertex(serial)) else {
            return false;
        };
        let ray = Ray::<S, N>::new(&point.at, &end.at);
        let ahead = |direction: &Vector<S, N>| dot(direction, &ray.direction) > S::of(AHEAD);
        let most = end.leg.tolerance * S::of(COARSE);
        let first = self.newest.next();
        let Some(between) = serial.since(first) else { return false };
        let mut along = S::ZERO;
        between <= PASSED
            && ahead(&end.direction)
            && (0..between).all(|k| {
                let Some(vertex) = self.polyline.vertex(first.plus(k)) else {
                    return false;
                };
                let (on, off) = ray.place(&vertex.at);
                let ordered = on + most >= along && on <= ray.length + most;
                along = along.greatest(on);
                let goes_on = ordered && ahead(&vertex.direction);
                goes_on && off <= most && vertex.leg.is_like(&end.leg)
            })
    }

    /// Makes a vertex the newest dominant point.
    fn dominate(&mut self, serial: VertexSerial) {
        let (Some(vertex), Some(before)) =
            (self.polyline.vertex(serial), self.dominant.back().copied())
        else {
            return;
        };
        self.newest = serial;
        let length = (vertex.s - before.s).to_mm::<S>();
        let direction = Ray::new(&before.at, &vertex.at).direction;
        let first = before.s == Length::ZERO;
        let mut size = before.size.least(length);
        let mut stop = false;
        if first && self.start == Tie::Smooth {
            size = self.beside.least(length * S::of(SMOOTH_SHARE));
        }
        if !first {
            let turn = norm(&sub(&direction, &before.direction)).greatest(S::of(1.0e-6));
            let band = before.tolerance.least(vertex.leg.tolerance);
            size = size.least(band * S::of(DOMINANT_SPAN) / turn);
            let mut reach = band * S::of(DOMINANT_REACH) / (turn * turn.sqrt());
            if turn > S::of(BACK) {
                stop = true;
                let rest_size = self.ramp.first_cell(vertex.leg.programmed.feed.least(before.feed));
                size = size.least(rest_size);
                reach = rest_size;
            }
            self.spline.slow_at(before.s, reach);
        }
        if let Some(point) = self.dominant.back_mut() {
            point.size = size;
            point.stop = stop;
        }
        self.keep(DominantPoint {
            s: vertex.s,
            at: vertex.at,
            direction,
            size: length,
            feed: vertex.leg.programmed.feed,
            stop: false,
            tolerance: vertex.leg.tolerance,
        });
        self.grade();
    }

    /// Sizes at neighbouring dominant points differ by no more than their distance allows.
    pub(super) fn grade(&mut self) {
        let n = self.dominant.len();
        let limit = |a: Option<DominantPoint<S, N>>, b: Option<DominantPoint<S, N>>| {
            let (a, b) = (a?, b?);
            let apart = (a.s - b.s).abs().to_mm::<S>();
            Some(a.size + apart * S::of(GRADE))
        };
        let get = |dominant: &Deque<_, WAITING>, i: usize| dominant.get(i).copied();
        for (a, b) in (1..n).map(|i| (i - 1, i)).chain((1..n).rev().map(|i| (i, i - 1))) {
            let most = limit(get(&self.dominant, a), get(&self.dominant, b));
            if let (Some(most), Some(point)) = (most, self.dominant.get_mut(b)) {
                point.size = point.size.least(most);
            }
        }
    }
}
