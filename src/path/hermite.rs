//! Quintic Hermite curves: point, tangent and curvature given at both ends.

use super::node::{Cell, Frame, Node, by_arc_length};
use crate::number::quadrature::integral;
use crate::number::vector::{Vector, norm, shifted};
use crate::number::{Coord, Scalar};
use core::array::from_fn;

/// A quintic curve over s in [0, length] that leaves the origin with a given tangent and curvature
/// and arrives at `length x tangent + offset` with the others. Six conditions per axis, six
/// coefficients: it is unique.
#[derive(Clone, Copy, Debug)]
pub struct Hermite<S, const N: usize> {
    /// Tangent at the start, and the parameter length, mm: their product in full.
    tangent: Vector<S, N>,
    length: S,
    /// Coefficients of u^1 .. u^5, u = s / length.
    coefficients: [Vector<S, N>; 5],
}

impl<S: Scalar, const N: usize> Hermite<S, N> {
    /// The curve between two directions: `length` is the parameter length, mm, `tangent_offset` the end point minus `length x start tangent`, mm.
    #[inline(never)]
    pub fn new(
        start: &Frame<S, N>,
        end: &Frame<S, N>,
        length: S,
        tangent_offset: &Vector<S, N>,
    ) -> Self {
        let square = length * length;
        // The straight part length x tangent x u is split off: what is left is small.
        let rest = |i: usize| {
            let slope = (end.tangent[i] - start.tangent[i]) * length;
            (tangent_offset[i], slope, start.curvature[i] * square, end.curvature[i] * square)
        };
        let half = S::of(0.5);
        Self {
            tangent: start.tangent,
            length,
            coefficients: [
                from_fn(|i| start.tangent[i] * length),
                from_fn(|i| start.curvature[i] * square * half),
                from_fn(|i| {
                    let (d, v, a0, a1) = rest(i);
                    S::of(10.0) * d - S::of(4.0) * v - S::of(1.5) * a0 + half * a1
                }),
                from_fn(|i| {
                    let (d, v, a0, a1) = rest(i);
                    S::of(-15.0) * d + S::of(7.0) * v + S::of(1.5) * a0 - a1
                }),
                from_fn(|i| {
                    let (d, v, a0, a1) = rest(i);
                    S::of(6.0) * d - S::of(3.0) * v - half * a0 + half * a1
                }),
            ],
        }
    }

    /// The curve of a cell.
    #[inline(never)]
    pub fn of_cell(from: &Node<S, N>, cell: &Cell<S, N>, to: &Node<S, N>) -> Self {
        Self::new(&from.frame(), &to.frame(), cell.length, &cell.tangent_offset)
    }

    /// Offset from the start at `u` in [0, 1], mm.
    pub fn offset(&self, u: S) -> Vector<S, N> {
        let c = &self.coefficients;
        from_fn(|i| ((((c[4][i] * u + c[3][i]) * u + c[2][i]) * u + c[1][i]) * u + c[0][i]) * u)
    }

    /// The same in full: what is made of differences of places must not lose them to rounding.
    fn exact(&self, u: f64) -> Vector<f64, N> {
        let along = self.length.to_f64() * u;
        from_fn(|i| {
            let c = |k: usize| self.coefficients[k][i].to_f64();
            self.tangent[i].to_f64() * along + (((c(4) * u + c(3)) * u + c(2)) * u + c(1)) * u * u
        })
    }

    /// First derivative by u.
    fn first(&self, u: S) -> Vector<S, N> {
        let c = &self.coefficients;
        from_fn(|i| {
            (((S::of(5.0) * c[4][i] * u + S::of(4.0) * c[3][i]) * u + S::of(3.0) * c[2][i]) * u
                + S::of(2.0) * c[1][i])
                * u
                + c[0][i]
        })
    }

    /// Second derivative by u.
    pub fn second(&self, u: S) -> Vector<S, N> {
        let c = &self.coefficients;
        from_fn(|i| {
            ((S::of(20.0) * c[4][i] * u + S::of(12.0) * c[3][i]) * u + S::of(6.0) * c[2][i]) * u
                + S::of(2.0) * c[1][i]
        })
    }

    /// Arc length between two parameters, by the three-point Gauss rule.
    pub fn arc_length(&self, from: S, to: S) -> S {
        integral(from, to, |u| norm(&self.first(u)))
    }

    /// Node at `u`, given the position of the start.
    pub fn node(&self, start: &Node<S, N>, u: S) -> Node<S, N> {
        Node::new(self.place(&start.at, u), by_arc_length(&self.first(u), &self.second(u)))
    }

    /// Point at `u`, given the start.
    pub fn place(&self, start: &[Coord; N], u: S) -> [Coord; N] {
        shifted(start, &self.exact(u.to_f64()))
    }
}

/// Splits a cell in its middle: the two cells follow the same curve.
#[inline(never)]
pub fn split<S: Scalar, const N: usize>(
    from: &Node<S, N>,
    cell: &Cell<S, N>,
    to: &Node<S, N>,
) -> (Cell<S, N>, Node<S, N>, Cell<S, N>) {
    split_at(from, cell, to, S::of(0.5))
}

/// Splits a cell at `u` in (0, 1) of its length, about.
pub fn split_at<S: Scalar, const N: usize>(
    from: &Node<S, N>,
    cell: &Cell<S, N>,
    to: &Node<S, N>,
    u: S,
) -> (Cell<S, N>, Node<S, N>, Cell<S, N>) {
    let curve = Hermite::of_cell(from, cell, to);
    let mut middle = curve.node(from, u);
    if cell.straight {
        // As straight as before, whatever the rounding.
        middle.tangent = from.tangent;
        middle.curvature = from.curvature;
    }
    let (first, second) = (curve.arc_length(S::ZERO, u), curve.arc_length(u, S::ONE));
    (
        Cell { length: first, tangent_offset: from.tangent_offset_to(&middle.at, first), ..*cell },
        middle,
        Cell { length: second, tangent_offset: middle.tangent_offset_to(&to.at, second), ..*cell },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::Coord;
    use crate::path::node::Programmed;

    /// A twentieth of a circle of 10 mm: the quintic through its ends keeps to it by nanometres,
    /// and so do the halves it is split into.
    #[test]
    fn an_arc_cell_and_its_halves_keep_to_the_circle() {
        let (radius, angle) = (10.0f64, 0.31f64);
        let node = |phi: f64| Node {
            at: [
                Coord::from_mm(radius * phi.sin()).unwrap(),
                Coord::from_mm(radius * (1.0 - phi.cos())).unwrap(),
            ],
            tangent: [phi.cos(), phi.sin()],
            curvature: [-phi.sin() / radius, phi.cos() / radius],
        };
        let (a, b) = (node(0.0), node(angle));
        let length = radius * angle;
        let cell = Cell {
            length,
            tangent_offset: [radius * angle.sin() - length, radius * (1.0 - angle.cos())],
            programmed: Programmed::feed(1.0),
            dwell: 0.0,
            event: None,
            straight: false,
        };
        let curve = Hermite::of_cell(&a, &cell, &b);
        for k in 0..=20 {
            let p = curve.offset(f64::from(k) / 20.0);
            let r = (p[0] * p[0] + (p[1] - radius) * (p[1] - radius)).sqrt();
            assert!((r - radius).abs() < 2e-7, "{}", r - radius);
        }
        let (first, middle, second) = split(&a, &cell, &b);
        assert!((first.length + second.length - length).abs() < 1e-6);
        assert!((middle.tangent[1] - (angle / 2.0).sin()).abs() < 1e-7);
        assert!((middle.curvature[1] - (angle / 2.0).cos() / radius).abs() < 1e-5);
    }
}
