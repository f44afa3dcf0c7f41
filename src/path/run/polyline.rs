//! The programmed poly-line of a run, thinned a little, by its arc length.

use super::VERTICES;
use super::narrows::Room;
use crate::number::optional::Optional;
use crate::number::serial::Serial;
use crate::number::vector::{Vector, dot, norm, zero};
use crate::number::{Coord, Interval, Length, Scalar};
use crate::path::budget;
use crate::path::leg::Leg;
use crate::path::segment::Segment;
use core::array::from_fn;
use heapless::{Deque, Vec};

/// Vertices left out between two that are kept.
const DROPPED: usize = 12;
/// Lines shorter than this, are followed by their direction, in `f32` to a nanometre; on longer
/// ones a point is found by a division of wide integers.
const SHORT: Length = Length::from_raw(10 * Length::PER_MM);

/// What is numbered: vertices of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vertices {}

/// Running number of a vertex of a run, from 0 at its start.
pub type VertexSerial = Serial<Vertices>;

/// A vertex, and the line that ends there.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<S, const N: usize> {
    pub at: [Coord; N],
    /// Arc length from the start of the run.
    pub s: Length,
    /// Direction of the line that ends here.
    pub direction: Vector<S, N>,
    pub leg: Leg<S>,
}

/// The poly-line.
pub struct Polyline<S, const N: usize> {
    vertices: Deque<Vertex<S, N>, VERTICES>,
    /// Running number of the first vertex.
    first: VertexSerial,
    /// End of the line that is still growing.
    growing: Optional<Vertex<S, N>>,
    /// Vertices left out on it.
    dropped: Vec<[Coord; N], DROPPED>,
    /// What was lost when some of those were forgotten, mm.
    forgotten: S,
    /// Greatest error that its lines came with, mm.
    brought: S,
    /// Tolerance behind the last line, mm.
    behind: Optional<S>,
}

impl<S: Scalar, const N: usize> Polyline<S, N> {
    pub const fn new() -> Self {
        Self {
            vertices: Deque::new(),
            first: VertexSerial::ZERO,
            growing: Optional::NONE,
            dropped: Vec::new(),
            forgotten: S::ZERO,
            brought: S::ZERO,
            behind: Optional::NONE,
        }
    }

    /// Starts anew at a point, to which a line leads that is no part of it.
    pub fn begin(&mut self, at: [Coord; N], leg: Leg<S>) {
        self.vertices.clear();
        self.first = VertexSerial::ZERO;
        self.growing.set(None);
        self.clear_dropped();
        self.behind.set(None);
        self.keep(Vertex { at, s: Length::ZERO, direction: zero(), leg });
    }

    /// Keeps a vertex, for which there is room: see [`VERTICES`].
    fn keep(&mut self, vertex: Vertex<S, N>) {
        debug_assert!(vertex.s >= self.vertices.back().map_or(Length::ZERO, |last| last.s));
        let kept = self.vertices.push_back(vertex);
        debug_assert!(kept.is_ok(), "no room for a vertex");
    }

    /// Whether another line can be taken, be it the last.
    pub fn has_room(&self) -> bool {
        self.vertices.len() + 2 <= VERTICES
    }

    /// Takes a line to `at`. It becomes one with the line before if that is alike and all vertices
    /// between stay within a share of the tolerance. Then that is a piece of it, which is returned, with its tag.
    pub fn push(&mut self, at: [Coord; N], leg: Leg<S>) -> Option<(Interval, u32)> {
        if let Some(last) = self.growing.as_ref().copied() {
            if let Some(longer) = self.longer(&last, at, &leg) {
                self.keep_dropped(last.at, &leg);
                self.brought = self.brought.greatest(leg.error);
                self.growing.set(Some(longer));
                let from = self.vertices.back()?.s;
                let piece = Interval { from, to: last.s.min(longer.s) };
                return Some((piece, last.leg.programmed.tag));
            }
            self.settle();
        }
        if let Some(last) = self.vertices.back() {
            self.growing.set(Vertex::new(last, at, leg));
            self.brought = leg.error;
        }
        None
    }

    /// The growing line taken on to `at`, if all it leaves out is near enough.
    fn longer(&self, last: &Vertex<S, N>, at: [Coord; N], leg: &Leg<S>) -> Option<Vertex<S, N>> {
        if !last.leg.is_like(leg) {
            return None;
        }
        let from = self.vertices.back()?;
        let line = Ray::<S, N>::new(&from.at, &at);
        let (mut along, mut error, mut back) = (S::ZERO, S::ZERO, S::ZERO);
        for vertex in self.dropped.iter().chain(core::iter::once(&last.at)) {
            let (on, off) = line.place(vertex);
            // In order along the line, so that every point of it has one of the path beside it: or
            // as far back, or beyond an end, as a spike may be.
            let beyond = (-on).greatest(on - line.length).greatest(S::ZERO);
            back = back.greatest(along - on).greatest(beyond);
            error = error.greatest((off * off + beyond * beyond).sqrt());
            along = along.greatest(on);
        }
        error += self.forgotten;
        let spike = back > leg.tolerance * S::of(budget::BACKWARDS);
        let share = if spike { budget::SPIKE } else { budget::THINNED };
        if error.greatest(back) > leg.tolerance * S::of(share) {
            return None;
        }
        let mut longer = Vertex::new(from, at, last.leg.with(leg)).unwrap_or(Vertex {
            // Back at the start: the line has no length for now.
            at,
            s: from.s,
            direction: zero(),
            leg: last.leg.with(leg),
        });
        longer.leg.error = error + self.brought.greatest(leg.error);
        Some(longer)
    }

    /// Remembers a vertex that is left out. When there are too many every other one is forgotten:
    /// what lies near the line between its neighbours is near whatever they are near.
    fn keep_dropped(&mut self, at: [Coord; N], leg: &Leg<S>) {
        if self.dropped.is_full() {
            let mut kept: Vec<[Coord; N], DROPPED> = Vec::new();
            let mut lost = S::ZERO;
            for pair in self.dropped.chunks_exact(2) {
                let after = self.dropped.get(2 * kept.len() + 2).copied().unwrap_or(at);
                let line = Ray::<S, N>::new(&pair[0], &after);
                let (on, off) = line.place(&pair[1]);
                let beyond = (-on).greatest(on - line.length).greatest(S::ZERO);
                lost = lost.greatest((off * off + beyond * beyond).sqrt());
                let pushed = kept.push(pair[0]);
                debug_assert!(pushed.is_ok(), "half of a list has room in one");
            }
            self.dropped = kept;
            self.forgotten = (self.forgotten + lost).least(leg.tolerance);
        }
        let pushed = self.dropped.push(at);
        debug_assert!(pushed.is_ok(), "half of the vertices left out have been forgotten");
    }

    fn clear_dropped(&mut self) {
        self.dropped.clear();
        self.forgotten = S::ZERO;
    }

    /// Ends the growing line where it is.
    #[inline(never)]
    pub fn settle(&mut self) {
        let start = self.vertices.back().map_or(Length::ZERO, |v| v.s);
        if let Some(vertex) = self.growing.take()
            && vertex.s > start
        {
            self.keep(vertex);
        }
        self.clear_dropped();
    }

    /// Whether a point is where the line starts that may become one with the next.
    pub fn returns(&self, at: &[Coord; N]) -> bool {
        self.vertices.back().is_some_and(|from| Segment::<S, N>::line(from.at, *at).is_none())
    }

    /// Takes note of the tolerance behind the last line, which is no part of it, mm.
    pub fn end_before(&mut self, behind: Option<S>) {
        self.behind.set(behind);
    }

    /// Where the line starts that may become one with the next, and its tag.
    pub fn growing(&self) -> Option<(Length, u32)> {
        let tag = self.growing.as_ref()?.leg.programmed.tag;
        Some((self.vertices.back()?.s, tag))
    }

    /// Arc length at the end of the last line taken.
    pub fn reach(&self) -> Length {
        self.growing.as_ref().or(self.vertices.back()).map_or(Length::ZERO, |vertex| vertex.s)
    }

    /// Running number of the vertex behind the last.
    pub fn end(&self) -> VertexSerial {
        self.first.plus(self.vertices.len() as u32)
    }

    /// A vertex by its running number.
    pub fn vertex(&self, serial: VertexSerial) -> Option<&Vertex<S, N>> {
        self.vertices.get(serial.since(self.first)? as usize)
    }

    /// Forgets what lies before an arc length.
    pub fn release_before(&mut self, s: Length) {
        // At most all of them.
        for _ in 0..VERTICES {
            if self.vertices.len() < 3 || self.vertices.get(1).is_none_or(|v| v.s >= s) {
                return;
            }
            self.vertices.pop_front();
            self.first = self.first.next();
        }
    }

    /// The line that leaves an arc length, and its tag.
    #[inline(never)]
    pub fn line_at(&self, s: Length) -> Option<(Interval, u32)> {
        let end = self.index(s + Length::UNIT);
        let (from, to) = (self.vertices.get(end.checked_sub(1)?)?, self.vertices.get(end)?);
        Some((Interval { from: from.s, to: to.s }, to.leg.programmed.tag))
    }

    /// Arc length at its end.
    pub fn line_end(&self, s: Length) -> Length {
        self.line_at(s).map_or(s, |(line, _)| line.to)
    }

    /// Arc length at the last end within an interval, or at its end, of a line of at least so many mm.
    pub fn last_end(&self, Interval { from, to }: Interval, least: S) -> Option<Length> {
        let mut at = to;
        for _ in 0..VERTICES {
            let (line, _) = self.line_at(at)?;
            if line.to > from && line.to <= to && (line.to - line.from).to_mm::<S>() >= least {
                return Some(line.to);
            }
            if line.from <= from {
                return None;
            }
            at = line.from - Length::UNIT;
        }
        None
    }

    /// Index of the vertex at the end of the line that holds an arc length.
    fn index(&self, s: Length) -> usize {
        // The first vertex at or behind it, by halving; the last if there is none, never the first.
        let last = self.vertices.len().saturating_sub(1);
        let (mut low, mut high) = (1, last);
        while low < high {
            let middle = usize::midpoint(low, high);
            if self.vertices.get(middle).is_some_and(|v| v.s >= s) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        low.min(last)
    }

    /// The point at an arc length. Beyond either end the polyline goes on straight, for as much as its
    /// last line is long.
    pub fn point(&self, s: Length) -> [Coord; N] {
        let (Some(front), Some(back)) = (self.vertices.front(), self.vertices.back()) else {
            return [Coord::ZERO; N];
        };
        for end in [front, back] {
            let mirrored = end.s * 2 - s;
            if (end.s == front.s && s < end.s) || (end.s == back.s && s > end.s) {
                let there = self.inside(mirrored);
                return from_fn(|i| Coord::from_raw(2 * end.at[i].raw() - there[i].raw()));
            }
        }
        self.inside(s)
    }

    fn inside(&self, s: Length) -> [Coord; N] {
        let i = self.index(s);
        match (self.vertices.get(i.saturating_sub(1)), self.vertices.get(i)) {
            (Some(start), Some(end)) => end.beside(start, s),
            _ => self.vertices.front().map_or([Coord::ZERO; N], |v| v.at),
        }
    }

    /// The lines that hold what lies between two arc lengths, each by the vertices at its start
    /// and its end, and with the room beside it.
    pub fn lines(
        &self,
        Interval { from, to }: Interval,
    ) -> impl Iterator<Item = (&Vertex<S, N>, &Vertex<S, N>, Room<S>)> {
        let first = self.index(from + Length::UNIT);
        (first..self.vertices.len()).map_while(move |i| {
            let start = self.vertices.get(i.saturating_sub(1))?;
            let end = self.vertices.get(i).filter(|_| start.s < to)?;
            let next = self.vertices.get(i + 1).map(|next| next.leg.tolerance);
            let behind = next.or(self.behind.as_ref().copied()).unwrap_or(end.leg.tolerance);
            Some((start, end, Room::new(start, end, (behind, next.is_none()))))
        })
    }

    /// The line that starts at the vertex at an arc length, if there is one.
    pub fn leaving(&self, s: Length) -> Option<&Vertex<S, N>> {
        let end = self.index(s + Length::UNIT);
        let start = self.vertices.get(end.checked_sub(1)?)?;
        (start.s == s).then(|| self.vertices.get(end))?
    }
}

impl<S: Scalar, const N: usize> Vertex<S, N> {
    /// The vertex at the end of a line; `None` if it has no length.
    fn new(from: &Self, at: [Coord; N], leg: Leg<S>) -> Option<Self> {
        let line = Segment::<S, N>::line(from.at, at)?;
        let direction = line.end_frame().tangent;
        Some(Self { at, s: from.s + line.exact_length, direction, leg })
    }

    /// The point at an arc length of the line that leads here from `start`; at most as far as here.
    pub fn beside(&self, start: &Self, s: Length) -> [Coord; N] {
        let (a, b) = (start, self);
        if s >= b.s || b.s <= a.s {
            return b.at;
        }
        let (done, all) = ((s - a.s).max(Length::ZERO), b.s - a.s);
        if all < SHORT {
            // From the nearer end: next to one, points lie closer together than the rounding of the whole.
            let left = all - done;
            let (end, along) = if done < left { (a, done) } else { (b, -left) };
            let along: S = along.to_mm();
            return from_fn(|k| end.at[k].plus(b.direction[k] * along));
        }
        let fraction = done.share_of(all);
        from_fn(|k| a.at[k].towards(b.at[k], fraction))
    }
}

/// A straight line, to place points beside.
pub struct Ray<S, const N: usize> {
    from: [Coord; N],
    pub direction: Vector<S, N>,
    pub length: S,
}

impl<S: Scalar, const N: usize> Ray<S, N> {
    /// From one point to another; without a direction if they are the same.
    pub fn new(from: &[Coord; N], to: &[Coord; N]) -> Self {
        let step: Vector<S, N> = from_fn(|i| to[i].minus(from[i]));
        let length = norm(&step);
        let per = if length > S::ZERO { S::ONE / length } else { S::ZERO };
        Self { from: *from, direction: step.map(|x| x * per), length }
    }

    /// How far along the line and how far off it a point lies, mm.
    pub fn place(&self, at: &[Coord; N]) -> (S, S) {
        let offset: Vector<S, N> = from_fn(|i| at[i].minus(self.from[i]));
        let on = dot(&offset, &self.direction);
        let off: Vector<S, N> = from_fn(|i| offset[i] - on * self.direction[i]);
        (on, norm(&off))
    }
}
