//! The constructions.

use super::bspline::{Planar, Spline};
use super::curve::{Curve, Sample};

/// Continuity of direction and curvature along legs and curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Continuity {
    /// Direction only: a jerk-limited machine must stop where the curvature jumps.
    G1,
    /// Direction and curvature.
    G2,
    /// Direction, curvature and its change.
    G3,
}

/// A method.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Name and source.
    pub name: &'static str,
    /// Continuity by construction.
    pub continuity: Continuity,
    /// Arithmetic operations to find the control points at a given deviation, counted by hand.
    pub operations: &'static str,
    /// Whether the construction was derived for lack of the published one.
    pub derived: bool,
    /// The curve for a turn (rad), of any size.
    pub(super) build: fn(f64) -> Curve,
}

/// Points on both legs at these distances from the corner, the corner between them.
fn on_legs(turn: f64, distances: &[f64], corner: Planar) -> Vec<Planar> {
    let mut points: Vec<Planar> = distances.iter().map(|d| (-d, 0.0)).collect();
    points.push(corner);
    points.extend(distances.iter().rev().map(|d| (d * turn.cos(), d * turn.sin())));
    points
}

fn guo(turn: f64) -> Curve {
    Curve::of_spline(&Spline::clamped(3, on_legs(turn, &[2.0, 1.0], (0.0, 0.0))), turn)
}

/// One cubic whose end tangents reach two thirds of the way to the corner.
fn zhang(turn: f64) -> Curve {
    let (c, s) = (turn.cos(), turn.sin());
    let third = 1.0 / 3.0;
    let points = vec![(-1.0, 0.0), (-third, 0.0), (third * c, third * s), (c, s)];
    Curve::of_spline(&Spline::clamped(3, points), turn)
}

/// Two cubics that share curvature at the shoulder and have none at the legs: the closed form of
/// Yang and Sukkarieh (2010), which the paper's pair reduces to for symmetric corners.
fn bi(turn: f64) -> Curve {
    let c2 = 0.4 * (6f64.sqrt() - 1.0);
    let c3 = (c2 + 4.0) / (7.2364 + 6.0);
    let beta = turn / 2.0;
    let (h, g) = (c3, c2 * c3);
    let k = 6.0 * c3 * beta.cos() / (c2 + 4.0);
    // B0, B1, B2 on the leg at 1, 1 - g, 1 - g - h; B3 and E3 meet on the bisector.
    let (b2, direction) = (1.0 - g - h, (beta.cos(), beta.sin()));
    let inner = (-b2 + k * direction.0, k * direction.1);
    // Both spans as one spline with a triple knot would need other knots: sample them apart.
    let first = [(-1.0, 0.0), (-1.0 + g, 0.0), (-b2, 0.0), inner];
    let mirror = |(x, y): Planar| {
        let (c, s) = (turn.cos(), turn.sin());
        (-x * c - y * s, -x * s + y * c)
    };
    // The other half is the mirror image about the bisector, run the other way.
    let second = [inner, mirror(first[2]), mirror(first[1]), mirror(first[0])];
    joined(&first, &second, turn)
}

fn joined(first: &[Planar; 4], second: &[Planar; 4], turn: f64) -> Curve {
    let a = Curve::of_spline(&Spline::clamped(3, first.to_vec()), turn);
    let b = Curve::of_spline(&Spline::clamped(3, second.to_vec()), turn);
    let (mut samples, length) = (a.samples.clone(), a.length());
    samples.extend(
        b.samples.iter().skip(1).map(|sample| Sample { way: sample.way + length, ..*sample }),
    );
    Curve { samples, turn }
}

/// Five points, the outer edges half as long as the inner ones.
fn zhao(turn: f64) -> Curve {
    Curve::of_spline(&Spline::clamped(3, on_legs(turn, &[1.5, 1.0], (0.0, 0.0))), turn)
}

/// Cubic, four points on either leg: derivatives up to the third lie along the leg.
fn tang(turn: f64) -> Curve {
    let points = on_legs(turn, &[4.0, 3.0, 2.0, 1.0], (0.0, 0.0));
    Curve::of_spline(&Spline::clamped(3, points), turn)
}

/// Quintic, four points on either leg.
fn cai(turn: f64) -> Curve {
    let points = on_legs(turn, &[4.0, 3.0, 2.0, 1.0], (0.0, 0.0));
    Curve::of_spline(&Spline::clamped(5, points), turn)
}

/// Seven points; those next to the corner and the one on the bisector where the greatest curvature
/// at equal deviation is least, by search.
fn huang(turn: f64) -> Curve {
    let mut best: Option<(f64, Curve)> = None;
    for outer in [0.6, 0.7, 0.8] {
        for inner in [0.2, 0.3, 0.4, 0.5] {
            for depth in [-0.15, -0.1, -0.05, 0.0, 0.05, 0.1] {
                let half = turn / 2.0;
                let corner = (-depth * half.sin(), depth * half.cos());
                let spline = Spline::clamped(3, on_legs(turn, &[1.0, outer, inner], corner));
                let curve = Curve::of_spline(&spline, turn);
                let score = curve.peak_curvature() * curve.deviation();
                if best.as_ref().is_none_or(|(least, _)| score < *least) {
                    best = Some((score, curve));
                }
            }
        }
    }
    // The lists are not empty.
    best.map_or_else(|| guo(turn), |(_, curve)| curve)
}

/// Five points with shorter edges on the leg that goes out, where rotary axes would turn.
fn yan(turn: f64) -> Curve {
    let (c, s) = (turn.cos(), turn.sin());
    let points = vec![(-2.0, 0.0), (-1.0, 0.0), (0.0, 0.0), (0.6 * c, 0.6 * s), (1.2 * c, 1.2 * s)];
    Curve::of_spline(&Spline::clamped(3, points), turn)
}

fn arc(turn: f64) -> Curve {
    Curve::of_curvature(|_| 1.0, turn)
}

fn clothoid(turn: f64) -> Curve {
    Curve::of_curvature(|way| way.min(1.0 - way), turn)
}

/// The methods, without this core's.
pub const METHODS: [Method; 10] = [
    Method {
        name: "Guo 2023, five points, equal edges",
        continuity: Continuity::G2,
        operations: "8 and 1 root",
        derived: false,
        build: guo,
    },
    Method {
        name: "Zhang 2011, parametric cubic",
        continuity: Continuity::G1,
        operations: "8 and 1 root",
        derived: true,
        build: zhang,
    },
    Method {
        name: "Bi 2012, pair of cubic Beziers",
        continuity: Continuity::G2,
        operations: "24 and 3 roots (closed form)",
        derived: true,
        build: bi,
    },
    Method {
        name: "Zhao 2013, five points, edges 1 : 2",
        continuity: Continuity::G2,
        operations: "8 and 1 root",
        derived: true,
        build: zhao,
    },
    Method {
        name: "Tang 2017, cubic, nine points",
        continuity: Continuity::G2,
        operations: "12 and 1 root",
        derived: true,
        build: tang,
    },
    Method {
        name: "Cai 2022, quintic, nine points",
        continuity: Continuity::G3,
        operations: "12 and 1 root",
        derived: true,
        build: cai,
    },
    Method {
        name: "Huang 2022, seven points, least curvature",
        continuity: Continuity::G2,
        operations: "a search",
        derived: true,
        build: huang,
    },
    Method {
        name: "Yan 2023, asymmetric edges 1 : 0.6",
        continuity: Continuity::G2,
        operations: "8 and 1 root",
        derived: true,
        build: yan,
    },
    Method {
        name: "circular arc",
        continuity: Continuity::G1,
        operations: "4 and 1 root",
        derived: false,
        build: arc,
    },
    Method {
        name: "clothoid pair",
        continuity: Continuity::G2,
        operations: "two Fresnel integrals",
        derived: false,
        build: clothoid,
    },
];

/// This core's own corner.
pub const OWN: Method = Method {
    name: "splineway, eleven points",
    continuity: Continuity::G2,
    operations: "about 300 and 4 roots",
    derived: false,
    build: guo,
};
