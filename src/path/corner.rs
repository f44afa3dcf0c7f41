//! The corner between two straight lines, and the cubic B-spline of Guo, Yan, Wang 2023 for it.
//!
//! Five control points P0..P4 with four equal edges L, P2 on the corner, P0 P1 P2 on the leg that
//! comes in and P2 P3 P4 on the leg that goes out, knots {0, 0, 0, 0, .5, 1, 1, 1, 1}. It is two
//! cubic Bezier spans that mirror each other; its curvature is zero at both ends, so it joins the
//! legs with continuous curvature.
//!
//! With theta half the angle *between* the legs: shoulder C(.5) = (P1 + 2 P2 + P3) / 4, so
//! e = |P2 - C(.5)| = (L / 2) cos theta (paper, eq. 7), and the distance of the shoulder from the
//! legs is e sin theta = (L / 4) sin 2 theta. The band delta is met exactly by
//! L = 4 delta / sin 2 theta, with no search. The default mode shapes its corners otherwise
//! ([`super::swing`]), but measures them by this one.

use super::budget;
use super::half::Half;
use crate::number::Scalar;
use crate::number::vector::{Vector, dot};

/// Share of a leg from which on it is used up by a transition of the paper: what is left is rounding.
const USED_UP: f64 = 1.0 - 1.0e-6;

/// What a transition of the paper may use.
#[derive(Clone, Copy, Debug)]
pub struct Legs<S> {
    /// What is left of the leg that comes in, after the gap to the transition before (eq. 8), mm.
    pub before: S,
    /// The whole leg that goes out, mm.
    pub after: S,
    /// Whether the path ends with that leg: routine 3 in place of routines 1 and 2.
    pub last: bool,
}

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
    #[inline(never)]
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
    fn shoulder(&self, edge: S) -> S {
        // cos theta = sin 2 theta / (2 sin theta), which keeps its digits where the turn is slight.
        edge * S::of(0.25) * (self.sin_turn / self.sin_theta())
    }

    /// Sine of the turn.
    pub fn sin_turn(&self) -> S {
        self.sin_turn
    }

    /// Tangent of half the turn; very large where the path reverses.
    pub fn tan_half_turn(&self) -> S {
        // Not beyond what an f32 can square.
        self.cos_theta() / self.sin_theta().greatest(S::of(1.0e-6))
    }

    /// Length 2 L of the paper's transition along either leg if it uses the whole band `delta`,
    /// mm: 8 delta / sin 2 theta, or `most` if that is less.
    pub fn full_band_length(&self, delta: S, most: S) -> S {
        let wanted = S::of(8.0 * budget::CORNER) * delta;
        // Compared before the division, which would overflow for straight joints.
        if wanted >= most * self.sin_turn { most } else { wanted / self.sin_turn }
    }

    /// Edge L as the paper's routines give it (sections 3.2 to 3.5), mm.
    pub fn paper_edge(&self, delta: S, legs: Legs<S>) -> S {
        let half = S::of(0.5);
        // Three cases: both halves of the control polygon are as long as the shorter leg.
        let edge = legs.before.least(legs.after) * half;
        let e = self.shoulder(edge);
        let sin_theta = self.sin_theta();
        // e > epsilon = delta / sin theta: shrink to e* = delta / 2.
        if e * sin_theta > delta {
            return edge * (delta * half / e);
        }
        // P4 would be the next corner, and leave it as it is (fig. 7): halve. Routine 3 has no such rule.
        let used_up = legs.before >= legs.after * S::of(USED_UP);
        if used_up && !legs.last { edge * half } else { edge }
    }

    /// The first half of the paper's transition with edge L, mm: one Bezier span with the control
    /// points -2 L, -L and -L / 2 on the leg and the shoulder.
    pub fn paper_half(&self, edge: S) -> Half<S> {
        let quarter = S::of(0.25);
        let shoulder = ((self.cos_turn - S::ONE) * quarter * edge, self.sin_turn * quarter * edge);
        let on_leg = |x: f64| (S::of(x) * edge, S::ZERO);
        // The sharper, the more the curvature is gathered at the apex. The cells follow the printed curve to a
        // thousandth of e.
        let cos = self.cos_turn.to_f64();
        let cells = if cos > 0.5 {
            2
        } else if cos > -0.35 {
            3
        } else if cos > -0.7 {
            4
        } else {
            6
        };
        Half::new(&[on_leg(-2.0), on_leg(-1.0), on_leg(-0.5), shoulder], cells)
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
        let legs = Legs { before: 2.0 * edge, after: 3.0 * edge, last: false };
        let shrunk = corner.paper_edge(0.01, legs);
        assert!((shrunk - 0.0123).abs() < 1e-4, "{shrunk}");
    }

    /// Section 3.5: inside the band already, and the next leg used up, so the edge is halved; but not by routine 3.
    #[test]
    fn halving_rule_of_the_paper() {
        let (a, b) = legs(170.0);
        let corner = Corner::new(&a, &b);
        let edge = |before, after, last| corner.paper_edge(0.05, Legs { before, after, last });
        assert!((edge(1.0, 0.4, false) - 0.1).abs() < 1e-12);
        assert!((edge(0.4, 1.0, false) - 0.2).abs() < 1e-12);
        assert!((edge(1.0, 0.4, true) - 0.2).abs() < 1e-12);
        // P4 is not Q2 where less than all is used up.
        assert!((edge(0.399, 0.4, false) - 0.1995).abs() < 1e-12);
    }

    /// The closed form meets the band, whatever the angle.
    #[test]
    fn full_band_is_met_exactly() {
        for degrees in [5.0, 20.0, 70.0, 90.0, 130.0, 175.0] {
            let (a, b) = legs(degrees);
            let corner = Corner::new(&a, &b);
            let edge = corner.full_band_length(0.05, 1e9) * 0.5;
            let off = corner.shoulder(edge) * corner.sin_theta();
            assert!((off / 0.05 - budget::CORNER).abs() < 1e-9, "{degrees}: {off}");
        }
    }
}
