//! A transition at the corner of two lines, as nodes and cells.
//!
//! It is symmetric: the second half is the mirror image of the first ([`super::half`]) about the bisector.

use super::corner::Corner;
use super::half::Half;
use super::node::{Cell, Node, Programmed};
use crate::number::vector::{Vector, mix, shifted};
use crate::number::{Coord, Scalar};
use core::array::from_fn;

/// What counts as not at the vertex, mm: more than the unit of the meter.
#[cfg(feature = "outputs")]
const LEAST_ALONG: f64 = 1.0e-6;

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
        let (cos, sin) = (corner.cos_turn(), corner.sin_turn());
        // Where the legs run straight on there is no inside, and the curve needs none.
        let per = if sin > S::ZERO { S::ONE / sin } else { S::ZERO };
        let inside = from_fn(|i| ((b[i] - a[i]) + a[i] * (S::ONE - cos)) * per);
        let beside = from_fn(|i| ((b[i] - a[i]) - b[i] * (S::ONE - cos)) * per);
        Self { vertex, before: [*a, inside], after: [*b, beside], half }
    }

    /// Number of cells.
    pub fn cells(&self) -> u8 {
        let [_, after] = self.half.ends();
        self.middle() + self.half.cells() + after.halvings
    }

    /// Number of cells before the apex.
    pub fn middle(&self) -> u8 {
        let [before, _] = self.half.ends();
        self.half.cells() + before.halvings
    }

    /// Offset from the vertex at node `index`, mm.
    fn offset(&self, index: u8) -> Vector<S, N> {
        let (first, (x, y)) = self.on_leg(index);
        let [leg, inside] = if first { &self.before } else { &self.after };
        mix(x, leg, y, inside)
    }

    /// Whether node `index` lies before the apex or on it, and how far from the vertex along that leg and beside it, mm.
    fn on_leg(&self, index: u8) -> (bool, (S, S)) {
        let (gap_before, gap_after) = self.gaps_at(index);
        let (first, [(x, y), ..]) = self.on_half(index);
        (first, (if first { x - gap_before } else { gap_after - x }, y))
    }

    /// Whether node `index` lies before the apex or on it, and where on the half: place, first and second derivative.
    fn on_half(&self, index: u8) -> (bool, [(S, S); 3]) {
        let [before, after] = self.half.ends();
        let first = index <= self.middle();
        let (at, d, dd) = if first {
            self.half.at(index, before.halvings)
        } else {
            self.half.at(self.cells() - index, after.halvings)
        };
        (first, [at, d, dd])
    }

    /// What of the legs lies between node `index` and the transition, mm: none but at its ends.
    fn gaps_at(&self, index: u8) -> (S, S) {
        let [before, after] = self.half.ends();
        (
            if index == 0 { before.gap } else { S::ZERO },
            if index == self.cells() { after.gap } else { S::ZERO },
        )
    }

    /// How far along the legs, from the vertex on, the place beside node `index` lies, mm; before the vertex negative. The apex stands for the vertex, and
    /// nothing before it does.
    #[cfg(feature = "outputs")]
    pub fn along(&self, index: u8) -> S {
        if index == self.middle() {
            return S::ZERO;
        }
        let (first, (x, _)) = self.on_leg(index);
        let least = S::of(LEAST_ALONG);
        if first { x.least(-least) } else { x.greatest(least) }
    }

    /// Node number `index`, 0 to [`Transition::cells`].
    pub fn node(&self, index: u8) -> Node<S, N> {
        let (first, [_, d, dd]) = self.on_half(index);
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
        let [before, after] = self.half.ends();
        let curve = if index < self.middle() {
            self.half.length(index, before.halvings)
        } else {
            self.half.length(self.cells() - 1 - index, after.halvings)
        };
        let length = curve + self.gaps_at(index).0 + self.gaps_at(index + 1).1;
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
            for half in
                [corner.paper_half(0.3), swing::half(&corner, swing::CornerBand::around(0.05), 2.0)]
            {
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
                let ((x, y), (dx, dy), _) = half.at(n / 2, 0);
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
