//! A transition at the corner of two lines, as nodes and cells.
//!
//! It is symmetric: the second half is the mirror image of the first ([`super::half`]) about the bisector.

use super::corner::Corner;
use super::half::{Half, Spot};
use super::node::{Cell, Node, Programmed};
use crate::number::vector::{Vector, mix, shifted};
use crate::number::{Coord, Scalar};
use core::array::from_fn;

/// What counts as not at the vertex, mm: more than the unit of the meter.
#[cfg(feature = "outputs")]
const LEAST_ALONG: f64 = 1.0e-6;

/// Halvings of a cell that find a place in it.
const HALVINGS: u32 = 20;

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

    /// Offset from the vertex, mm.
    fn offset(&self, spot: Spot<S>) -> Vector<S, N> {
        let (first, (x, y)) = self.on_leg(spot);
        let [leg, inside] = if first { &self.before } else { &self.after };
        mix(x, leg, y, inside)
    }

    /// Whether a place lies before the apex or on it, and how far from the vertex along that leg and beside it, mm.
    fn on_leg(&self, spot: Spot<S>) -> (bool, (S, S)) {
        let (gap_before, gap_after) = self.gaps_at(spot);
        let (first, [(x, y), ..]) = self.on_half(spot);
        (first, (if first { x - gap_before } else { gap_after - x }, y))
    }

    /// Whether a place lies before the apex or on it, and where on the half: place, first and second derivative.
    fn on_half(&self, spot: Spot<S>) -> (bool, [(S, S); 3]) {
        let [before, after] = self.half.ends();
        let apex = self.middle();
        let first = spot.node < apex || (spot.node == apex && spot.share <= S::ZERO);
        let (at, d, dd) = if first {
            self.half.at(spot, before.halvings)
        } else {
            self.half.at(spot.mirrored(self.cells()), after.halvings)
        };
        (first, [at, d, dd])
    }

    /// What of the legs lies between a place and the transition, mm: none but at its ends.
    fn gaps_at(&self, Spot { node, share }: Spot<S>) -> (S, S) {
        let [before, after] = self.half.ends();
        let at_node = share <= S::ZERO;
        (
            if at_node && node == 0 { before.gap } else { S::ZERO },
            if at_node && node == self.cells() { after.gap } else { S::ZERO },
        )
    }

    /// How far along one of the legs, from the vertex on, the place lies that a place before the apex, or one behind it, is beside, mm; before the vertex
    /// negative. The apex is beside both.
    pub fn foot(&self, spot: Spot<S>, before: bool) -> S {
        let (first, (x, _)) = self.on_leg(spot);
        if first == before { x } else { -x }
    }

    /// The same as outputs count it: the apex stands for the vertex, and nothing before it does.
    #[cfg(feature = "outputs")]
    pub fn along(&self, spot: Spot<S>) -> S {
        let (first, (x, _)) = self.on_leg(spot);
        let least = S::of(LEAST_ALONG);
        if first && spot.node == self.middle() {
            S::ZERO
        } else if first {
            x.least(-least)
        } else {
            x.greatest(least)
        }
    }

    /// The place behind another, in the same cell, that is beside one `foot` mm along the legs from the vertex, to a millionth of the cell; its end if
    /// there is none before.
    #[inline(never)]
    pub fn beside(&self, from: Spot<S>, foot: S) -> Spot<S> {
        let before = from.node < self.middle();
        let (mut low, mut high) = (from.share, S::ONE);
        for _ in 0..HALVINGS {
            let middle = (low + high) * S::of(0.5);
            let is_before = self.foot(Spot { share: middle, ..from }, before) < foot;
            if is_before { low = middle } else { high = middle }
        }
        if high < S::ONE { Spot { share: high, ..from } } else { Spot::at(from.node + 1) }
    }

    /// The node at a place.
    pub fn node(&self, spot: Spot<S>) -> Node<S, N> {
        let (first, [_, d, dd]) = self.on_half(spot);
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
        Node { at: shifted(&self.vertex, &self.offset(spot)), tangent, curvature }
    }

    /// The cell between two places on the same side of the apex, of which the node at the first is given.
    pub fn cell(
        &self,
        (from, to): (Spot<S>, Spot<S>),
        node: &Node<S, N>,
        programmed: Programmed<S>,
    ) -> Cell<S, N> {
        let [before, after] = self.half.ends();
        let curve = if from.node < self.middle() {
            self.half.length(from, to, before.halvings)
        } else {
            let [from, to] = [from, to].map(|spot| spot.mirrored(self.cells()));
            self.half.length(to, from, after.halvings)
        };
        let length = curve + self.gaps_at(from).0 + self.gaps_at(to).1;
        let (a, b) = (self.offset(from), self.offset(to));
        Cell {
            length,
            tangent_offset: from_fn(|i| (b[i] - a[i]) - node.tangent[i] * length),
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
    use crate::path::half::End;
    use crate::path::swing;

    /// The directions before and behind a turn, and its corner.
    fn turned(degrees: f64) -> ([f64; 2], [f64; 2], Corner<f64>) {
        let turn = degrees.to_radians();
        let (a, b) = ([1.0, 0.0], [turn.cos(), turn.sin()]);
        (a, b, Corner::new(&a, &b))
    }

    /// Curvature is zero where the transition meets the legs, continuous at the apex, and the
    /// cells add up to a curve from one leg to the other.
    #[test]
    fn transitions_are_g2_and_closed() {
        for degrees in [4.0, 30.0, 90.0, 140.0] {
            let (a, b, corner) = turned(degrees);
            for half in
                [corner.paper_half(0.3), swing::half(&corner, swing::CornerBand::around(0.05), 2.0)]
            {
                let reach = half.reach();
                let transition = Transition::new([Coord::ZERO; 2], (&a, &b), &corner, half);
                let n = transition.cells();
                let (first, last) = (transition.node(Spot::at(0)), transition.node(Spot::at(n)));
                for i in 0..2 {
                    assert!(first.curvature[i].abs() < 1e-9 && last.curvature[i].abs() < 1e-9);
                    assert!((first.tangent[i] - a[i]).abs() < 1e-12);
                    assert!((last.tangent[i] - b[i]).abs() < 1e-12);
                    assert!((first.at[i].to_mm() + reach * a[i]).abs() < 1e-9);
                    assert!((last.at[i].to_mm() - reach * b[i]).abs() < 1e-9);
                }
                // The apex as seen from either half.
                let apex = transition.node(Spot::at(n / 2));
                let ((x, y), (dx, dy), _) = half.at(Spot::at(n / 2), 0);
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

    /// Nodes within cells lie on the same curve, with its direction and bend, and the parts of a cell are as long as that.
    #[test]
    fn a_cell_may_be_cut_anywhere() {
        for degrees in [4.0, 30.0, 90.0, 140.0] {
            let (a, b, corner) = turned(degrees);
            let ends = [End::new(0.01, 0.1, None), End::new(0.0, 0.1, Some(0.02))];
            let band = swing::CornerBand::around(0.05);
            let halves = [corner.paper_half(0.3).with_ends(ends), swing::half(&corner, band, 2.0)];
            for half in halves {
                let transition = Transition::new([Coord::ZERO; 2], (&a, &b), &corner, half);
                for node in 0..transition.cells() {
                    let whole = (Spot::at(node), Spot::at(node + 1));
                    let cut = |share| Spot { node, share };
                    let length = |(from, to)| {
                        let programmed = Programmed::feed(1.0);
                        transition.cell((from, to), &transition.node(from), programmed).length
                    };
                    let spots: std::vec::Vec<_> =
                        (0..20).map(|k| cut(f64::from(k) / 20.0)).chain([whole.1]).collect();
                    let sum: f64 = spots.windows(2).map(|pair| length((pair[0], pair[1]))).sum();
                    assert!(
                        (sum / length(whole) - 1.0).abs() < 1e-3,
                        "{degrees} {node}: {sum} {}",
                        length(whole)
                    );
                    for spot in spots.iter().skip(1).take(19) {
                        let [before, at, after] =
                            [-1e-4, 0.0, 1e-4].map(|d| transition.node(cut(spot.share + d)));
                        let step: [f64; 2] = from_fn(|i| after.at[i].minus::<f64>(before.at[i]));
                        let size = step[0].hypot(step[1]);
                        for i in 0..2 {
                            assert!(
                                (step[i] / size - at.tangent[i]).abs() < 1e-5,
                                "{degrees} {spot:?}"
                            );
                            let bend = (after.tangent[i] - before.tangent[i]) / size;
                            assert!(
                                (bend - at.curvature[i]).abs() < 1e-3 + 0.01 * bend.abs(),
                                "{degrees} {spot:?}: {bend} {}",
                                at.curvature[i]
                            );
                        }
                    }
                }
            }
        }
    }
}
