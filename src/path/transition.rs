//! A transition at the corner of two lines, as nodes and cells.
//!
//! It is symmetric: the second half is the mirror image of the first about the bisector. The first
//! half is a chain of cubic Bezier spans, given in the frame of the leg that comes in: x along the
//! leg, 0 at the corner, y to the inside of the turn.

use super::corner::Corner;
use super::node::{Cell, Node, Programmed};
use crate::number::quadrature::integral;
use crate::number::vector::{Vector, mix, shifted};
use crate::number::{Coord, Scalar};
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
}

impl<S: Scalar> Half<S> {
    /// A chain of spans, 3 points each and one more, to be cut into `cells` cells.
    pub fn new(points: &[Planar<S>], cells: u8) -> Self {
        let mut half = Self {
            points: [(S::ZERO, S::ZERO); 3 * SPANS + 1],
            spans: (points.len() / 3).min(SPANS) as u8,
            cells,
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

    /// The points of a span.
    fn span(&self, index: usize) -> [Planar<S>; 4] {
        let first = 3 * index.min(SPANS - 1);
        from_fn(|k| self.points[first + k])
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

    /// Span and parameter in it of a node of the half, 0 to `cells`.
    fn place(&self, node: u8) -> (usize, S) {
        let place = u16::from(node) * u16::from(self.spans);
        let cells = u16::from(self.cells).max(1);
        let span = (place / cells).min(u16::from(self.spans).saturating_sub(1));
        let rest = place - span * cells;
        (usize::from(span), S::from_u32(u32::from(rest)) / S::from_u32(u32::from(cells)))
    }

    /// Point and derivatives by the span's parameter at a node.
    fn at(&self, node: u8) -> (Planar<S>, Planar<S>, Planar<S>) {
        let (span, u) = self.place(node);
        bezier(&self.span(span), u)
    }

    /// Arc length between a node and the next, mm.
    fn length(&self, node: u8) -> S {
        let (first, from) = self.place(node);
        let (last, to) = self.place(node + 1);
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

/// A transition at a corner, ready to be cut into cells.
#[derive(Clone, Copy, Debug)]
pub struct Transition<S, const N: usize> {
    vertex: [Coord; N],
    /// Direction of the leg that comes in, and the inside of the turn beside it.
    before: [Vector<S, N>; 2],
    /// The same for the leg that goes out.
    after: [Vector<S, N>; 2],
    half: Half<S>,
}

impl<S: Scalar, const N: usize> Transition<S, N> {
    /// The transition at `vertex` between two directions.
    pub fn new(
        vertex: [Coord; N],
        (a, b): (&Vector<S, N>, &Vector<S, N>),
        corner: &Corner<S>,
        half: Half<S>,
    ) -> Self {
        let (cos, per) = (corner.cos_turn(), S::ONE / corner.sin_turn());
        let inside = from_fn(|i| ((b[i] - a[i]) + a[i] * (S::ONE - cos)) * per);
        let beside = from_fn(|i| ((b[i] - a[i]) - b[i] * (S::ONE - cos)) * per);
        Self { vertex, before: [*a, inside], after: [*b, beside], half }
    }

    /// Number of cells.
    pub fn cells(&self) -> u8 {
        2 * self.half.cells
    }

    /// Offset from the vertex at node `index`, mm.
    fn offset(&self, index: u8) -> Vector<S, N> {
        if index <= self.half.cells {
            let ((x, y), ..) = self.half.at(index);
            return mix(x, &self.before[0], y, &self.before[1]);
        }
        let ((x, y), ..) = self.half.at(self.cells() - index);
        mix(-x, &self.after[0], y, &self.after[1])
    }

    /// Node number `index`, 0 to [`Transition::cells`].
    pub fn node(&self, index: u8) -> Node<S, N> {
        let first = index <= self.half.cells;
        let (_, d, dd) = self.half.at(if first { index } else { self.cells() - index });
        let square = d.0 * d.0 + d.1 * d.1;
        let speed = square.sqrt();
        let t = (d.0 / speed, d.1 / speed);
        let along = t.0 * dd.0 + t.1 * dd.1;
        let k = ((dd.0 - t.0 * along) / square, (dd.1 - t.1 * along) / square);
        // The mirror image is run the other way.
        let (tangent, curvature) = if first {
            (
                mix(t.0, &self.before[0], t.1, &self.before[1]),
                mix(k.0, &self.before[0], k.1, &self.before[1]),
            )
        } else {
            (
                mix(t.0, &self.after[0], -t.1, &self.after[1]),
                mix(-k.0, &self.after[0], k.1, &self.after[1]),
            )
        };
        Node { at: shifted(&self.vertex, &self.offset(index)), tangent, curvature }
    }

    /// Cell number `index`, between the nodes `index` and `index + 1`.
    pub fn cell(&self, index: u8, from: &Node<S, N>, programmed: Programmed<S>) -> Cell<S, N> {
        let first = index < self.half.cells;
        let length = self.half.length(if first { index } else { self.cells() - 1 - index });
        let (a, b) = (self.offset(index), self.offset(index + 1));
        Cell {
            length,
            tangent_offset: from_fn(|i| (b[i] - a[i]) - from.tangent[i] * length),
            programmed,
            dwell: S::ZERO,
            event: None,
            straight: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::swing;

    /// Curvature is zero where the transition meets the legs, continuous at the apex, and the
    /// cells add up to a curve from one leg to the other.
    #[test]
    fn transitions_are_g2_and_closed() {
        for degrees in [4.0f64, 30.0, 90.0, 140.0] {
            let turn = degrees.to_radians();
            let (a, b) = ([1.0, 0.0], [turn.cos(), turn.sin()]);
            let corner = Corner::new(&a, &b);
            for half in [corner.paper_half(0.3), swing::half(&corner, 0.05, 2.0)] {
                let reach = half.reach();
                let transition = Transition::new([Coord::ZERO; 2], (&a, &b), &corner, half);
                let n = transition.cells();
                let (first, last) = (transition.node(0), transition.node(n));
                for i in 0..2 {
                    assert!(first.curvature[i].abs() < 1e-9 && last.curvature[i].abs() < 1e-9);
                    assert!((first.tangent[i] - a[i]).abs() < 1e-12);
                    assert!((last.tangent[i] - b[i]).abs() < 1e-12);
                    assert!((first.at[i].to_mm() + reach * a[i]).abs() < 1e-9);
                    assert!((last.at[i].to_mm() - reach * b[i]).abs() < 1e-9);
                }
                // The apex as seen from either half.
                let apex = transition.node(n / 2);
                let ((x, y), (dx, dy), _) = half.at(n / 2);
                let mirrored: [f64; 2] = mix(-x, &transition.after[0], y, &transition.after[1]);
                for i in 0..2 {
                    assert!((apex.at[i].to_mm() - mirrored[i]).abs() < 1e-9, "{degrees}");
                }
                let size = dx.hypot(dy);
                let back: [f64; 2] =
                    mix(dx / size, &transition.after[0], -dy / size, &transition.after[1]);
                assert!((back[0] - apex.tangent[0]).abs() < 1e-9, "{degrees}");
            }
        }
    }
}
