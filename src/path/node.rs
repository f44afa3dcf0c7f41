//! Nodes of the path and the cells between them.

use crate::machine::SetNumber;
use crate::number::vector::{Vector, dot, sub};
use crate::number::{Coord, Scalar};
use crate::path::feed::LinearFeed;
use core::array::from_fn;

/// A point of the path with its derivatives by arc length s.
#[derive(Clone, Copy, Debug)]
pub struct Node<S, const N: usize> {
    /// Position.
    pub at: [Coord; N],
    /// dx/ds: unit tangent.
    pub tangent: Vector<S, N>,
    /// d2x/ds2, 1/mm.
    pub curvature: Vector<S, N>,
}

impl<S: Scalar, const N: usize> Node<S, N> {
    /// Its direction and bend.
    pub fn frame(&self) -> Frame<S, N> {
        Frame { tangent: self.tangent, curvature: self.curvature }
    }

    /// The node at a point with a direction and bend.
    pub fn new(at: [Coord; N], Frame { tangent, curvature }: Frame<S, N>) -> Self {
        Self { at, tangent, curvature }
    }

    /// How far a point lies off the straight line along this node's tangent: see [`Cell::tangent_offset`].
    /// In `f64`, because it is a small difference: its rounding in `f32` would be felt as jerk.
    pub fn tangent_offset_to(&self, to: &[Coord; N], length: S) -> Vector<S, N> {
        from_fn(|i| {
            let straight = self.tangent[i].to_f64() * length.to_f64();
            S::of(to[i].minus::<f64>(self.at[i]) - straight)
        })
    }
}

/// Direction and bend of a curve at a point.
#[derive(Clone, Copy, Debug)]
pub struct Frame<S, const N: usize> {
    /// dx/ds: unit tangent.
    pub tangent: Vector<S, N>,
    /// d2x/ds2, 1/mm.
    pub curvature: Vector<S, N>,
}

/// The path between two neighbouring nodes.
#[derive(Clone, Copy, Debug)]
pub struct Cell<S, const N: usize> {
    /// Arc length, mm. Zero for a dwell.
    pub length: S,
    /// How far the next node lies off the straight line along this node's tangent, mm: next
    /// position - position - length x tangent. Kept apart from the position difference because it
    /// is small and would drown in its rounding.
    pub tangent_offset: Vector<S, N>,
    /// What its block asks of it.
    pub programmed: Programmed<S>,
    /// Standstill at this place, s; such a cell has no length.
    pub dwell: S,
    /// What is reported when the standstill begins.
    pub event: Option<Event>,
    /// Whether the cell is a piece of a straight line.
    pub straight: bool,
}

/// A place in the program at which the machine does something else than move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The motion goes on by itself.
    Pass,
    /// The motion goes on when it is resumed.
    Pause,
}

/// What a block asks of the cells that are made of it.
#[derive(Clone, Copy, Debug)]
pub struct Programmed<S> {
    /// Programmed speed along the path, mm/s.
    pub feed: S,
    /// The same over the linear axes, where a path may have another share of them than its line.
    pub linear: LinearFeed,
    /// Whether it is run as a rapid: which override applies.
    pub rapid: bool,
    /// Which limits bound it.
    pub limits: SetNumber,
    /// Tag of the block.
    pub tag: u32,
}

#[cfg(test)]
impl<S> Programmed<S> {
    /// A feed, mm/s.
    pub fn feed(feed: S) -> Self {
        Self { feed, linear: LinearFeed::NONE, rapid: false, limits: SetNumber::FIRST, tag: 0 }
    }
}

/// Tangent and curvature from the first two derivatives by any parameter.
///
/// x'' = (c'' - t (t . c'')) / |c'|^2.
pub fn by_arc_length<S: Scalar, const N: usize>(
    d1: &Vector<S, N>,
    d2: &Vector<S, N>,
) -> Frame<S, N> {
    let square = dot(d1, d1);
    let speed = square.sqrt();
    let tangent: Vector<S, N> = from_fn(|i| d1[i] / speed);
    let along = dot(&tangent, d2);
    let normal: Vector<S, N> = from_fn(|i| tangent[i] * along);
    let bend = sub(d2, &normal);
    Frame { tangent, curvature: from_fn(|i| bend[i] / square) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_by_arc_length_are_those_of_a_circle() {
        // A circle of 5 mm, run at 3 mm and with 7 mm along it by the parameter.
        let (d1, d2) = ([3.0f64, 0.0], [7.0, 9.0 / 5.0]);
        let Frame { tangent, curvature } = by_arc_length(&d1, &d2);
        assert!((tangent[0] - 1.0).abs() < 1e-15 && tangent[1].abs() < 1e-15);
        assert!(curvature[0].abs() < 1e-15 && (curvature[1] - 0.2).abs() < 1e-15);
    }

    #[test]
    fn the_tangent_offset_is_the_distance_from_the_tangent() {
        let at = |x: f64, y: f64| [x, y].map(|x| Coord::from_mm(x).unwrap());
        let node = Node { at: at(1.0, 1.0), tangent: [1.0f32, 0.0], curvature: [0.0; 2] };
        let offset = node.tangent_offset_to(&at(2.999, 1.25), 2.0);
        assert!((offset[0] + 0.001).abs() < 1e-9 && (offset[1] - 0.25).abs() < 1e-9);
        let frame = Node::new(node.at, node.frame());
        assert_eq!(frame.at, node.at);
    }
}
