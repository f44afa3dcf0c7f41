//! The constructions.

use super::bspline::{Planar, Spline};
use super::curve::{Curve, Sample};
use super::tally::{Effort, Number, Tally, effort};

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

/// What finding the control points costs, from the cosine and sine of the turn and the deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Operations, counted while it was done.
    Counted(Effort),
    /// So many curves were tried.
    Search(u32),
    /// No closed form: what is done instead.
    Numerical(&'static str),
}

impl std::fmt::Display for Cost {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::Counted(Effort { operations, roots: 0 }) => write!(f, "{operations}"),
            Self::Counted(Effort { operations, roots: 1 }) => write!(f, "{operations} and a root"),
            Self::Counted(Effort { operations, roots }) => {
                write!(f, "{operations} and {roots} roots")
            }
            Self::Search(curves) => write!(f, "a search: {curves} curves"),
            Self::Numerical(words) => f.write_str(words),
        }
    }
}

/// A method.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Name and source.
    pub name: &'static str,
    /// Continuity by construction.
    pub continuity: Continuity,
    /// What finding the control points costs at a turn (rad).
    pub cost: fn(f64) -> Cost,
    /// Whether the construction was derived for lack of the published one.
    pub derived: bool,
    /// The curve for a turn (rad), of any size.
    pub(super) build: fn(f64) -> Curve,
}

/// Cosine and sine of the turn.
#[derive(Clone, Copy)]
struct Turn<N> {
    cos: N,
    sin: N,
}

impl Turn<f64> {
    fn new(turn: f64) -> Self {
        Self { cos: turn.cos(), sin: turn.sin() }
    }
}

type Points<N> = Vec<(N, N)>;

/// Points on both legs at these distances from the corner.
fn on_legs<N: Number>(turn: Turn<N>, distances: &[f64], corner: Option<(N, N)>) -> Points<N> {
    let out = |d: &f64| (turn.cos * N::from(*d), turn.sin * N::from(*d));
    let mut points: Points<N> = distances.iter().map(|d| (N::from(-d), N::from(0.0))).collect();
    points.extend(corner);
    points.extend(distances.iter().rev().map(out));
    points
}

/// The corner itself as a control point.
fn corner<N: Number>() -> (N, N) {
    (N::from(0.0), N::from(0.0))
}

/// What each point weighs at the middle of a symmetric spline.
fn weights(degree: usize, count: usize) -> Vec<f64> {
    let weight = |k: usize| {
        let points = (0..count).map(|i| (f64::from(u8::from(i == k)), 0.0)).collect();
        let spline = Spline::clamped(degree, points);
        spline.at(spline.end() / 2.0).0
    };
    (0..count).map(weight).collect()
}

/// A symmetric curve made as large as the deviation allows: the greatest distance from the legs is that of the apex.
fn fitted<N: Number>(points: &[(N, N)], weights: &[f64], deviation: N) -> Points<N> {
    let off = points
        .iter()
        .zip(weights)
        .map(|((_, y), weight)| *y * N::from(*weight))
        .fold(N::from(0.0), |sum, y| sum + y);
    let scale = deviation / off;
    points.iter().map(|(x, y)| (*x * scale, *y * scale)).collect()
}

/// Counts what it costs to make the points and to fit them.
fn counted(turn: f64, weights: &[f64], points: fn(Turn<Tally>) -> Points<Tally>) -> Cost {
    let Turn { cos, sin } = Turn::new(turn);
    let turn = Turn { cos: Tally::input(cos), sin: Tally::input(sin) };
    let deviation = Tally::input(0.05);
    Cost::Counted(effort(|| fitted(&points(turn), weights, deviation)))
}

fn spline(degree: usize, points: Points<f64>, turn: f64) -> Curve {
    Curve::of_spline(&Spline::clamped(degree, points), turn)
}

fn guo_points<N: Number>(turn: Turn<N>) -> Points<N> {
    on_legs(turn, &[2.0, 1.0], Some(corner()))
}

fn guo(turn: f64) -> Curve {
    spline(3, guo_points(Turn::new(turn)), turn)
}

/// Three points on either leg, evenly from the corner, which is none of them: it passes by at a distance.
fn pateloup_points<N: Number>(turn: Turn<N>) -> Points<N> {
    on_legs(turn, &[3.0, 2.0, 1.0], None)
}

/// One cubic whose end tangents reach two thirds of the way to the corner.
fn zhang_points<N: Number>(turn: Turn<N>) -> Points<N> {
    on_legs(turn, &[1.0, 1.0 / 3.0], None)
}

/// Two cubics that share curvature at the shoulder and have none at the legs: the closed form of
/// Yang and Sukkarieh (2010), which the paper's pair reduces to for symmetric corners.
fn bi_points<N: Number>(turn: Turn<N>) -> Points<N> {
    let c2 = 0.4 * (6f64.sqrt() - 1.0);
    let c3 = (c2 + 4.0) / (7.2364 + 6.0);
    let number = |x: f64| N::from(x);
    // Cosine and sine of half the turn.
    let cos = ((number(1.0) + turn.cos) * number(0.5)).root();
    let sin = turn.sin * number(0.5) / cos;
    let (h, g) = (c3, c2 * c3);
    let k = cos * number(6.0 * c3 / (c2 + 4.0));
    // B0, B1, B2 on the leg at 1, 1 - g, 1 - g - h; B3 and E3 meet on the bisector.
    let b2 = 1.0 - g - h;
    let inner = (k * cos - number(b2), k * sin);
    on_legs(turn, &[1.0, 1.0 - g, b2], Some(inner))
}

/// The apex is the point in the middle.
const BI_WEIGHTS: [f64; 7] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

fn bi(turn: f64) -> Curve {
    // Both spans as one spline with a triple knot would need other knots: sample them apart.
    let p = bi_points(Turn::new(turn));
    joined(&[p[0], p[1], p[2], p[3]], &[p[3], p[4], p[5], p[6]], turn)
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
fn zhao_points<N: Number>(turn: Turn<N>) -> Points<N> {
    on_legs(turn, &[1.5, 1.0], Some(corner()))
}

/// Four points on either leg: of a cubic, derivatives up to the third lie along the leg.
fn nine_points<N: Number>(turn: Turn<N>) -> Points<N> {
    on_legs(turn, &[4.0, 3.0, 2.0, 1.0], Some(corner()))
}

/// Places of the points that Huang's method tries.
const OUTER: [f64; 3] = [0.6, 0.7, 0.8];
const INNER: [f64; 4] = [0.2, 0.3, 0.4, 0.5];
const DEPTH: [f64; 6] = [-0.15, -0.1, -0.05, 0.0, 0.05, 0.1];

/// Seven points; those next to the corner and the one on the bisector where the greatest curvature
/// at equal deviation is least, by search.
fn huang(turn: f64) -> Curve {
    let mut best: Option<(f64, Curve)> = None;
    for outer in OUTER {
        for inner in INNER {
            for depth in DEPTH {
                let half = turn / 2.0;
                let corner = (-depth * half.sin(), depth * half.cos());
                let points = on_legs(Turn::new(turn), &[1.0, outer, inner], Some(corner));
                let curve = spline(3, points, turn);
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
    spline(3, points, turn)
}

/// Radius and reach of an arc.
fn arc_points<N: Number>(turn: Turn<N>, deviation: N) -> [N; 2] {
    let (one, half) = (N::from(1.0), N::from(0.5));
    let cos = ((one + turn.cos) * half).root();
    let radius = deviation / (one - cos);
    [radius, radius * turn.sin * half / (cos * cos)]
}

fn arc_cost(turn: f64) -> Cost {
    let Turn { cos, sin } = Turn::new(turn);
    let turn = Turn { cos: Tally::input(cos), sin: Tally::input(sin) };
    Cost::Counted(effort(|| arc_points(turn, Tally::input(0.05))))
}

fn arc(turn: f64) -> Curve {
    Curve::of_curvature(|_| 1.0, turn)
}

fn clothoid(turn: f64) -> Curve {
    Curve::of_curvature(|way| way.min(1.0 - way), turn)
}

/// The methods, without this core's.
pub const METHODS: [Method; 11] = [
    Method {
        name: "Guo 2023, five points, equal edges",
        continuity: Continuity::G2,
        cost: |turn| counted(turn, &weights(3, 5), guo_points),
        derived: false,
        build: guo,
    },
    Method {
        name: "Pateloup 2010, cubic, six points",
        continuity: Continuity::G2,
        cost: |turn| counted(turn, &weights(3, 6), pateloup_points),
        derived: true,
        build: |turn| spline(3, pateloup_points(Turn::new(turn)), turn),
    },
    Method {
        name: "Zhang 2011, parametric cubic",
        continuity: Continuity::G1,
        cost: |turn| counted(turn, &weights(3, 4), zhang_points),
        derived: true,
        build: |turn| spline(3, zhang_points(Turn::new(turn)), turn),
    },
    Method {
        name: "Bi 2012, pair of cubic Beziers",
        continuity: Continuity::G2,
        cost: |turn| counted(turn, &BI_WEIGHTS, bi_points),
        derived: true,
        build: bi,
    },
    Method {
        name: "Zhao 2013, five points, edges 1 : 2",
        continuity: Continuity::G2,
        cost: |turn| counted(turn, &weights(3, 5), zhao_points),
        derived: true,
        build: |turn| spline(3, zhao_points(Turn::new(turn)), turn),
    },
    Method {
        name: "Tang 2017, cubic, nine points",
        continuity: Continuity::G2,
        cost: |turn| counted(turn, &weights(3, 9), nine_points),
        derived: true,
        build: |turn| spline(3, nine_points(Turn::new(turn)), turn),
    },
    Method {
        name: "Cai 2022, quintic, nine points",
        continuity: Continuity::G3,
        cost: |turn| counted(turn, &weights(5, 9), nine_points),
        derived: true,
        build: |turn| spline(5, nine_points(Turn::new(turn)), turn),
    },
    Method {
        name: "Huang 2022, seven points, least curvature",
        continuity: Continuity::G2,
        cost: |_| Cost::Search((OUTER.len() * INNER.len() * DEPTH.len()) as u32),
        derived: true,
        build: huang,
    },
    Method {
        name: "Yan 2023, asymmetric edges 1 : 0.6",
        continuity: Continuity::G2,
        cost: |_| Cost::Numerical("the greatest distance, by samples"),
        derived: true,
        build: yan,
    },
    Method {
        name: "circular arc",
        continuity: Continuity::G1,
        cost: arc_cost,
        derived: false,
        build: arc,
    },
    Method {
        name: "clothoid pair",
        continuity: Continuity::G2,
        cost: |_| Cost::Numerical("two Fresnel integrals"),
        derived: false,
        build: clothoid,
    },
];

/// This core's own corner.
pub const OWN: Method = Method {
    name: "splineway, eleven points",
    continuity: Continuity::G2,
    cost: |_| Cost::Numerical("instructions: cargo bench --bench cost"),
    derived: false,
    build: guo,
};

#[cfg(test)]
mod tests {
    use super::*;

    /// What is counted is what makes the curve: the points that were fitted have the deviation that was asked for.
    #[test]
    fn fitted_points_have_the_deviation() {
        for degrees in [20.0f64, 60.0, 90.0, 140.0] {
            let turn = degrees.to_radians();
            let t = Turn::new(turn);
            for (degree, points) in [
                (3, guo_points(t)),
                (3, pateloup_points(t)),
                (3, zhang_points(t)),
                (3, zhao_points(t)),
                (3, nine_points(t)),
                (5, nine_points(t)),
            ] {
                let fitted = fitted(&points, &weights(degree, points.len()), 0.05);
                let deviation = spline(degree, fitted, turn).deviation();
                assert!((deviation / 0.05 - 1.0).abs() < 1.0e-5, "{degrees}: {deviation}");
            }
            let p = fitted(&bi_points(t), &BI_WEIGHTS, 0.05);
            let pair = joined(&[p[0], p[1], p[2], p[3]], &[p[3], p[4], p[5], p[6]], turn);
            assert!((pair.deviation() / 0.05 - 1.0).abs() < 1.0e-5, "{degrees}");
            let [radius, reach] = arc_points(t, 0.05);
            // From the corner along the bisector, and square to a leg.
            let off = (radius.hypot(reach) - radius) * radius / radius.hypot(reach);
            assert!((off - 0.05).abs() < 1.0e-9, "{degrees}: {off}");
        }
    }

    /// A longer polygon costs more, and the count does not depend on the turn.
    #[test]
    fn costs_are_counted() {
        let cost = |name: &str, turn: f64| {
            let method = METHODS.iter().find(|method| method.name.starts_with(name)).unwrap();
            match (method.cost)(turn) {
                Cost::Counted(effort) => effort.operations,
                other => panic!("{other}"),
            }
        };
        assert!(cost("Guo", 1.0) < cost("Pateloup", 1.0));
        assert!(cost("Pateloup", 1.0) < cost("Tang", 1.0));
        assert_eq!(cost("Guo", 1.0), cost("Guo", 2.0));
    }
}
