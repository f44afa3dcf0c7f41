//! The first half of a transition at the corner of two lines: a chain of cubic Bezier spans, given in the frame of the leg
//! that comes in, x along the leg, 0 at the corner, y to the inside of the turn.

use crate::number::Scalar;
use crate::number::quadrature::integral;
use crate::spline::bezier::cubic;
use core::array::from_fn;

/// A point or vector in the frame of a leg.
pub type Planar<S> = (S, S);

/// Most spans of a half.
pub const SPANS: usize = 4;

/// The first half of a transition: Bezier spans that share their ends.
#[derive(Clone, Copy, Debug)]
pub struct Half<S> {
    points: [Planar<S>; 3 * SPANS + 1],
    spans: u8,
    cells: u8,
    /// The outer cells of the transition: of the half that comes in, and of its mirror image.
    ends: [End<S>; 2],
}

/// A place on a transition or a half of one.
#[derive(Clone, Copy, Debug)]
pub struct Spot<S> {
    /// Node before it, or there.
    pub node: u8,
    /// Share of the cell behind that node that lies before it, by the curve's parameter.
    pub share: S,
}

impl<S: Scalar> Spot<S> {
    /// Where a node is.
    pub const fn at(node: u8) -> Self {
        Self { node, share: S::ZERO }
    }

    /// The same place as seen from the other end of `cells` cells.
    pub fn mirrored(self, cells: u8) -> Self {
        if self.share > S::ZERO {
            Self { node: cells - 1 - self.node, share: S::ONE - self.share }
        } else {
            Self::at(cells - self.node)
        }
    }
}

/// What the outer cell of a half has besides its part of the curve.
#[derive(Clone, Copy, Debug)]
pub struct End<S> {
    /// The stretch of the leg beside it, if that is too short to be a cell of its own, mm.
    pub gap: S,
    /// How often it is halved towards its end, because the motion rests there.
    pub halvings: u8,
}

impl<S: Scalar> End<S> {
    /// Nothing.
    const NONE: Self = Self { gap: S::ZERO, halvings: 0 };
    /// Most halvings.
    const MOST: u8 = 8;

    /// Of an outer cell of `outer` mm with a stretch of `gap` mm; where the motion rests at its end, `rest` is the
    /// length of a first cell from there, mm.
    pub fn new(gap: S, outer: S, rest: Option<S>) -> Self {
        let mut end = Self { gap, halvings: 0 };
        let Some(rest) = rest else { return end };
        let mut length = outer;
        while length > rest && end.halvings < Self::MOST {
            length = length * S::of(0.5);
            end.halvings += 1;
        }
        end
    }
}

impl<S: Scalar> Half<S> {
    /// A chain of spans, 3 points each and one more, to be cut into `cells` cells.
    pub fn new(points: &[Planar<S>], cells: u8) -> Self {
        let mut half = Self {
            points: [(S::ZERO, S::ZERO); 3 * SPANS + 1],
            spans: (points.len() / 3).min(SPANS) as u8,
            cells,
            ends: [End::NONE; 2],
        };
        for (slot, point) in half.points.iter_mut().zip(points) {
            *slot = *point;
        }
        half
    }

    /// Length it takes of the leg, mm.
    pub fn reach(&self) -> S {
        -self.points[0].0
    }

    /// The same, smaller.
    #[must_use]
    pub fn scaled(&self, share: S) -> Self {
        Self { points: self.points.map(|(x, y)| (x * share, y * share)), ..*self }
    }

    /// Number of cells, if the outer one is whole.
    pub fn cells(&self) -> u8 {
        self.cells
    }

    /// The same with other outer cells.
    #[must_use]
    pub fn with_ends(&self, ends: [End<S>; 2]) -> Self {
        Self { ends, ..*self }
    }

    /// The outer cells.
    pub fn ends(&self) -> [End<S>; 2] {
        self.ends
    }

    /// The points of a span.
    fn span(&self, index: usize) -> [Planar<S>; 4] {
        let first = 3 * index.min(SPANS - 1);
        from_fn(|k| self.points[first + k])
    }

    /// The least offset of its control points to the inner side, mm: the curve has none that is less.
    #[cfg(test)]
    pub fn least_offset(&self) -> S {
        let points = self.points.iter().take(3 * usize::from(self.spans) + 1);
        points.fold(S::ZERO, |least, (_, y)| least.least(*y))
    }

    /// Greatest distance from the leg's line, mm; exact.
    pub fn deviation(&self) -> S {
        let mut most = S::ZERO;
        for index in 0..usize::from(self.spans) {
            let [p0, p1, p2, p3] = self.span(index).map(|(_, y)| y);
            most = most.greatest(p0.abs()).greatest(p3.abs());
            // y' / 3 = d0 (1-u)^2 + 2 d1 u (1-u) + d2 u^2
            let (d0, d1, d2) = (p1 - p0, p2 - p1, p3 - p2);
            let (a, b, c) = (d0 - S::of(2.0) * d1 + d2, d1 - d0, d0);
            let square = b * b - a * c;
            if !(square > S::ZERO) {
                continue;
            }
            // Both roots, without the difference of nearly equal numbers.
            let root = square.sqrt();
            let sum = if b > S::ZERO { -(b + root) } else { root - b };
            for u in [sum / a, c / sum] {
                if u > S::ZERO && u < S::ONE {
                    most = most.greatest(cubic([p0, p1, p2, p3], u).value.abs());
                }
            }
        }
        most
    }

    /// Span and parameter in it of a place on the half.
    fn place(&self, Spot { node, share }: Spot<S>, halvings: u8) -> (usize, S) {
        let (span, u) = self.node(node, halvings);
        if share <= S::ZERO {
            return (span, u);
        }
        let sum = |(span, u): (usize, S)| S::from_u32(span as u32) + u;
        let (from, to) = (sum((span, u)), sum(self.node(node + 1, halvings)));
        let place = from + (to - from) * share;
        let last = usize::from(self.spans).saturating_sub(1);
        let span = (span..last).find(|&span| place < sum((span + 1, S::ZERO))).unwrap_or(last);
        (span, place - sum((span, S::ZERO)))
    }

    /// Span and parameter in it of a node of the half, 0 to `cells` and the `halvings` of the outer cell, which lies
    /// in the first span.
    fn node(&self, node: u8, halvings: u8) -> (usize, S) {
        if node > 0 && node <= halvings {
            let parts = u32::from(self.cells).max(1) << (halvings + 1 - node).min(End::<S>::MOST);
            return (0, S::from_u32(u32::from(self.spans)) / S::from_u32(parts));
        }
        let node = node.saturating_sub(halvings);
        let place = u16::from(node) * u16::from(self.spans);
        let cells = u16::from(self.cells).max(1);
        let span = (place / cells).min(u16::from(self.spans).saturating_sub(1));
        let rest = place - span * cells;
        (usize::from(span), S::from_u32(u32::from(rest)) / S::from_u32(u32::from(cells)))
    }

    /// Point and derivatives by the span's parameter at a place.
    pub fn at(&self, spot: Spot<S>, halvings: u8) -> (Planar<S>, Planar<S>, Planar<S>) {
        let (span, u) = self.place(spot, halvings);
        bezier(&self.span(span), u)
    }

    /// Arc length between two places, mm.
    pub fn length(&self, from: Spot<S>, to: Spot<S>, halvings: u8) -> S {
        let (first, from) = self.place(from, halvings);
        let (last, to) = self.place(to, halvings);
        let mut sum = S::ZERO;
        for index in first..=last {
            let u0 = if index == first { from } else { S::ZERO };
            let u1 = if index == last { to } else { S::ONE };
            let span = self.span(index);
            sum += integral(u0, u1, |u| {
                let (_, (dx, dy), _) = bezier(&span, u);
                (dx * dx + dy * dy).sqrt()
            });
        }
        sum
    }
}

/// Point, first and second derivative of a cubic Bezier span.
fn bezier<S: Scalar>(p: &[Planar<S>; 4], u: S) -> (Planar<S>, Planar<S>, Planar<S>) {
    let (x, y) = (cubic(p.map(|p| p.0), u), cubic(p.map(|p| p.1), u));
    ((x.value, y.value), (x.first, y.first), (x.second, y.second))
}
