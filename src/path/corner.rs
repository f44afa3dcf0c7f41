//! Corner transitions between two straight lines: the cubic B-spline of Guo, Yan, Wang 2023.
//!
//! Five control points P0..P4 with four equal edges L, P2 on the corner, P0 P1 P2 on the leg that
//! comes in and P2 P3 P4 on the leg that goes out, knots {0, 0, 0, 0, .5, 1, 1, 1, 1}. It is two
//! cubic Bezier spans that mirror each other; its curvature is zero at both ends, so it joins the
//! legs with continuous curvature.
//!
//! With theta half the angle *between* the legs: shoulder C(.5) = (P1 + 2 P2 + P3) / 4, so
//! e = |P2 - C(.5)| = (L / 2) cos theta (paper, eq. 7), and the distance of the shoulder from the
//! legs is e sin theta = (L / 4) sin 2 theta. The band delta is met exactly by
//! L = 4 delta / sin 2 theta, with no search.

use super::node::{Cell, GAUSS, Node, Order};
use crate::number::vector::{Vector, dot, mix, shifted};
use crate::number::{Coord, Scalar};

/// Share of the band that the default mode uses; the rest is for rounding.
const BAND_SHARE: f64 = 0.998;

/// The corner between two legs.
#[derive(Clone, Copy, Debug)]
pub struct Corner<S> {
    /// Cosine of the turn: tangent in . tangent out.
    cos_turn: S,
    /// Sine of the turn = sin 2 theta.
    sin_turn: S,
}

impl<S: Scalar> Corner<S> {
    /// The corner between two unit directions.
    pub fn new<const N: usize>(tangent_in: &Vector<S, N>, tangent_out: &Vector<S, N>) -> Self {
        let cos_turn = dot(tangent_in, tangent_out).least(S::ONE).greatest(-S::ONE);
        // From the difference, which keeps its digits where the turn is slight.
        let gap: Vector<S, N> = core::array::from_fn(|i| tangent_out[i] - tangent_in[i]);
        let square = dot(&gap, &gap); // = 2 - 2 cos
        let sin_turn = (square * (S::ONE - square * S::of(0.25)).greatest(S::ZERO)).sqrt();
        Self { cos_turn, sin_turn }
    }

    /// Cosine of the turn.
    pub fn cos_turn(&self) -> S {
        self.cos_turn
    }

    /// cos theta, theta being half the angle between the legs (paper, fig. 3).
    fn cos_theta(&self) -> S {
        // The angle between the legs is pi - turn, so cos theta = sin(turn / 2).
        ((S::ONE - self.cos_turn) * S::of(0.5)).greatest(S::ZERO).sqrt()
    }

    /// sin theta.
    fn sin_theta(&self) -> S {
        ((S::ONE + self.cos_turn) * S::of(0.5)).greatest(S::ZERO).sqrt()
    }

    /// Distance e of the shoulder from the corner for an edge L (eq. 7), mm.
    pub fn shoulder(&self, edge: S) -> S {
        edge * S::of(0.5) * self.cos_theta()
    }

    /// Edge L that uses the whole band `delta`, mm: 4 delta / sin 2 theta, or `most` if that is
    /// less.
    pub fn full_band_edge(&self, delta: S, most: S) -> S {
        let wanted = S::of(4.0 * BAND_SHARE) * delta;
        // Compared before the division, which would overflow for straight joints.
        if wanted >= most * self.sin_turn { most } else { wanted / self.sin_turn }
    }

    /// Edge L as the paper's routines give it (sections 3.2 to 3.5), mm.
    ///
    /// `leg_in` is the length left of the leg that comes in, after the gap to the transition
    /// before; `leg_out` the whole leg that goes out.
    pub fn paper_edge(&self, delta: S, leg_in: S, leg_out: S) -> S {
        let half = S::of(0.5);
        // Three cases: both halves of the control polygon are as long as the shorter leg.
        let edge = leg_in.least(leg_out) * half;
        let e = self.shoulder(edge);
        let sin_theta = self.sin_theta();
        // e > epsilon = delta / sin theta: shrink to e* = delta / 2.
        if e * sin_theta > delta {
            return edge * (delta * half / e);
        }
        // The whole next leg would be used up and leave a corner at its end (fig. 7): halve.
        if leg_in >= leg_out { edge * half } else { edge }
    }
}

/// A transition at a corner, ready to be cut into cells.
#[derive(Clone, Copy, Debug)]
pub struct Transition<S, const N: usize> {
    vertex: [Coord; N],
    tangent_in: Vector<S, N>,
    tangent_out: Vector<S, N>,
    cos_turn: S,
    edge: S,
    /// Cells in each of the two mirrored halves.
    halves: u8,
}

/// A point in the frame of the two legs: alpha along the leg that comes in, beta along the one
/// that goes out.
type Planar<S> = (S, S);

impl<S: Scalar, const N: usize> Transition<S, N> {
    /// The transition with edge L, mm, at `vertex`.
    pub fn new(
        vertex: [Coord; N],
        tangent_in: Vector<S, N>,
        tangent_out: Vector<S, N>,
        corner: &Corner<S>,
        edge: S,
    ) -> Self {
        let cos = corner.cos_turn().to_f64();
        // The sharper, the more the curvature is gathered at the apex.
        let halves = if cos > 0.96 {
            1
        } else if cos > -0.2 {
            2
        } else if cos > -0.7 {
            3
        } else {
            4
        };
        Self { vertex, tangent_in, tangent_out, cos_turn: corner.cos_turn(), edge, halves }
    }

    /// Number of cells.
    pub fn cells(&self) -> u8 {
        2 * self.halves
    }

    /// Bezier span of the first half in units of L: control points (-2,0) (-1,0) (-1/2,0)
    /// (-1/4,1/4). The second half is its mirror image.
    fn first_half(u: S) -> (Planar<S>, Planar<S>, Planar<S>) {
        let v = S::ONE - u;
        let (uu, vv) = (u * u, v * v);
        let three = S::of(3.0);
        let quarter = S::of(0.25);
        let point = (
            S::of(-2.0) * v * vv - three * vv * u - S::of(1.5) * v * uu - quarter * u * uu,
            quarter * u * uu,
        );
        let first = (three * (vv + u * v + quarter * uu), S::of(0.75) * uu);
        let second = (S::of(-3.0) * v - S::of(1.5) * u, S::of(1.5) * u);
        (point, first, second)
    }

    /// Point and derivatives by the span's parameter at `x` in [0, 2], in units of L.
    fn planar(x: S) -> (Planar<S>, Planar<S>, Planar<S>) {
        if x <= S::ONE {
            return Self::first_half(x);
        }
        let (p, d, dd) = Self::first_half(S::of(2.0) - x);
        ((-p.1, -p.0), (d.1, d.0), (-dd.1, -dd.0))
    }

    /// Length of a planar vector; the legs are not at right angles.
    fn planar_norm(&self, (a, b): Planar<S>) -> S {
        (a * a + b * b + S::of(2.0) * self.cos_turn * a * b).sqrt()
    }

    fn parameter(&self, index: u8) -> S {
        S::from_i64(i64::from(index)) / S::from_i64(i64::from(self.halves))
    }

    /// Node number `index`, 0 to [`Transition::cells`].
    pub fn node(&self, index: u8) -> Node<S, N> {
        let (p, d, dd) = Self::planar(self.parameter(index));
        let square = d.0 * d.0 + d.1 * d.1 + S::of(2.0) * self.cos_turn * d.0 * d.1;
        let speed = square.sqrt();
        let t = (d.0 / speed, d.1 / speed);
        let along = t.0 * dd.0 + t.1 * dd.1 + self.cos_turn * (t.0 * dd.1 + t.1 * dd.0);
        let per = S::ONE / (square * self.edge);
        let k = ((dd.0 - t.0 * along) * per, (dd.1 - t.1 * along) * per);
        let expand = |(a, b): Planar<S>| mix(a, &self.tangent_in, b, &self.tangent_out);
        Node {
            at: shifted(&self.vertex, &expand((p.0 * self.edge, p.1 * self.edge))),
            tangent: expand(t),
            curvature: expand(k),
        }
    }

    /// Cell number `index`, between the nodes `index` and `index + 1`.
    pub fn cell(&self, index: u8, from: &Node<S, N>, order: Order<S>) -> Cell<S, N> {
        let (x0, x1) = (self.parameter(index), self.parameter(index + 1));
        let mut length = S::ZERO;
        for (x, weight) in GAUSS {
            let (_, d, _) = Self::planar(x0 + (x1 - x0) * S::of(x));
            length += S::of(weight) * self.planar_norm(d);
        }
        length = length * (x1 - x0) * self.edge;
        let (a, b) = (Self::planar(x0).0, Self::planar(x1).0);
        let step = mix(
            (b.0 - a.0) * self.edge,
            &self.tangent_in,
            (b.1 - a.1) * self.edge,
            &self.tangent_out,
        );
        Cell {
            length,
            bulge: core::array::from_fn(|i| step[i] - from.tangent[i] * length),
            order,
            dwell: S::ZERO,
            straight: false,
        }
    }

    /// Whether cell `index` lies before the apex.
    pub fn is_first_half(&self, index: u8) -> bool {
        index < self.halves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legs(between_degrees: f64) -> ([f64; 2], [f64; 2]) {
        let turn = (180.0 - between_degrees).to_radians();
        ([1.0, 0.0], [turn.cos(), turn.sin()])
    }

    /// Section 3.3: theta 35 degrees, delta 0.01, L 0.0479.
    #[test]
    fn worked_example_of_the_paper() {
        let (a, b) = legs(70.0);
        let corner = Corner::new(&a, &b);
        let edge = 0.0479;
        let e0 = corner.shoulder(edge);
        assert!((e0 - 0.0196).abs() < 5e-5, "{e0}");
        let epsilon = 0.01 / corner.sin_theta();
        assert!((epsilon - 0.0174).abs() < 5e-5, "{epsilon}");
        let alpha = 0.005 / e0;
        // The paper divides by e0 cut to 0.0195.
        assert!((alpha - 0.256).abs() < 2e-3, "{alpha}");
        // Legs of 2 L give the paper's L as the first guess.
        let shrunk = corner.paper_edge(0.01, 2.0 * edge, 3.0 * edge);
        assert!((shrunk - 0.0123).abs() < 1e-4, "{shrunk}");
    }

    /// Section 3.5: inside the band already, and the next leg used up, so the edge is halved.
    #[test]
    fn halving_rule_of_the_paper() {
        let (a, b) = legs(170.0);
        let corner = Corner::new(&a, &b);
        assert!((corner.paper_edge(0.05, 1.0, 0.4) - 0.1).abs() < 1e-12);
        assert!((corner.paper_edge(0.05, 0.4, 1.0) - 0.2).abs() < 1e-12);
    }

    /// The closed form meets the band, whatever the angle.
    #[test]
    fn full_band_is_met_exactly() {
        for degrees in [5.0, 20.0, 70.0, 90.0, 130.0, 175.0] {
            let (a, b) = legs(degrees);
            let corner = Corner::new(&a, &b);
            let edge = corner.full_band_edge(0.05, 1e9);
            let off = corner.shoulder(edge) * corner.sin_theta();
            assert!((off / 0.05 - BAND_SHARE).abs() < 1e-9, "{degrees}: {off}");
        }
    }

    /// Curvature is zero where the transition meets the legs, continuous at the apex, and the
    /// cells add up to a curve that starts at P0 and ends at P4.
    #[test]
    fn transition_is_g2_and_closed() {
        let (a, b) = legs(75.0);
        let corner = Corner::new(&a, &b);
        let edge = 0.3;
        let transition = Transition::new([Coord::ZERO; 2], a, b, &corner, edge);
        let n = transition.cells();
        let (first, last) = (transition.node(0), transition.node(n));
        for i in 0..2 {
            assert!(first.curvature[i].abs() < 1e-12 && last.curvature[i].abs() < 1e-12);
            assert!(
                (first.tangent[i] - a[i]).abs() < 1e-12 && (last.tangent[i] - b[i]).abs() < 1e-12
            );
            assert!((first.at[i].to_mm() + 2.0 * edge * a[i]).abs() < 1e-9);
            assert!((last.at[i].to_mm() - 2.0 * edge * b[i]).abs() < 1e-9);
        }
        let eps = 1e-7;
        let near = |x: f64| {
            let (_, d, dd) = Transition::<f64, 2>::planar(x);
            let v: [f64; 2] = mix(d.0, &a, d.1, &b);
            let w: [f64; 2] = mix(dd.0, &a, dd.1, &b);
            crate::path::node::by_arc_length(&v, &w)
        };
        let (before, after) = (near(1.0 - eps), near(1.0 + eps));
        for i in 0..2 {
            assert!((before.0[i] - after.0[i]).abs() < 1e-5);
            assert!((before.1[i] - after.1[i]).abs() < 1e-4);
        }
    }
}
