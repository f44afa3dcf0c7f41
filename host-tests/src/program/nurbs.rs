//! NURBS curves as JSON, cut into chords.

use super::{Course, Move, Program, ReadOptions, Speed};
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

/// A NURBS curve: `{degree, control_points, weights, knots}`.
#[derive(Debug, Deserialize)]
pub struct Nurbs {
    degree: usize,
    control_points: Vec<Vec<f64>>,
    /// One per control point; all 1 if left out.
    weights: Option<Vec<f64>>,
    knots: Vec<f64>,
}

impl Nurbs {
    fn check(&self) -> Result<()> {
        let n = self.control_points.len();
        ensure!((1..=9).contains(&self.degree), "degree is {}; it must be 1 to 9", self.degree);
        ensure!(n > self.degree, "{n} control points are too few for degree {}", self.degree);
        let wanted = n + self.degree + 1;
        ensure!(
            self.knots.len() == wanted,
            "{} knots where {wanted} are expected ({n} control points + degree {} + 1)",
            self.knots.len(),
            self.degree
        );
        for (i, pair) in self.knots.windows(2).enumerate() {
            ensure!(
                pair[0] <= pair[1],
                "knots[{}] = {} is less than the knot before it",
                i + 1,
                pair[1]
            );
        }
        let (from, to) = self.domain();
        ensure!(from < to, "the knots span no interval");
        for (i, point) in self.control_points.iter().enumerate() {
            ensure!(
                (1..=3).contains(&point.len()) && point.iter().all(|x| x.is_finite()),
                "control_points[{i}] must be one to three finite numbers"
            );
        }
        if let Some(weights) = &self.weights {
            ensure!(weights.len() == n, "{} weights for {n} control points", weights.len());
            for (i, weight) in weights.iter().enumerate() {
                ensure!(
                    *weight > 0.0 && weight.is_finite(),
                    "weights[{i}] is {weight}; it must be greater than 0"
                );
            }
        }
        Ok(())
    }

    fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.knots.len() - 1 - self.degree])
    }

    /// The point at a parameter of the domain, by de Boor's algorithm on homogeneous points.
    fn point(&self, u: f64) -> [f64; 3] {
        let (p, knots) = (self.degree, &self.knots);
        let n = self.control_points.len();
        let span = knots[p + 1..n].partition_point(|&knot| knot <= u) + p;
        let mut d: Vec<[f64; 4]> = (span - p..=span)
            .map(|i| {
                let w = self.weights.as_ref().map_or(1.0, |weights| weights[i]);
                let mut h = [0.0, 0.0, 0.0, w];
                for (slot, x) in h.iter_mut().zip(&self.control_points[i]) {
                    *slot = x * w;
                }
                h
            })
            .collect();
        for r in 1..=p {
            for j in (r..=p).rev() {
                let (a, b) = (knots[j + span - p], knots[j + 1 + span - r]);
                let t = if b > a { (u - a) / (b - a) } else { 0.0 };
                let before = d[j - 1];
                for (x, y) in d[j].iter_mut().zip(before) {
                    *x = (1.0 - t) * y + t * *x;
                }
            }
        }
        let [x, y, z, w] = d[p];
        [x / w, y / w, z / w]
    }
}

/// Reads a curve and cuts it into chords of equal parameter steps.
///
/// # Errors
/// Names the place in the file, or the member and what is wrong with it.
pub fn parse(text: &str, options: ReadOptions) -> Result<Program> {
    let curve: Nurbs = serde_json::from_str(text).context("not a NURBS curve")?;
    curve.check()?;
    if options.segments == 0 {
        bail!("a curve cannot be cut into 0 segments");
    }
    let (from, to) = curve.domain();
    let mut program = Program::default();
    for k in 0..=options.segments {
        let u = from + (to - from) * k as f64 / options.segments as f64;
        let mut point = [0.0; 9];
        point[..3].copy_from_slice(&curve.point(u));
        if k == 0 {
            program.start = point;
        } else {
            program.moves.push(Move {
                path: Course::Line { to: point },
                speed: Speed::PerSecond(options.feed),
                tolerance: None,
                exact_stop: false,
                line: u32::try_from(k)?,
            });
        }
    }
    Ok(program)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPTIONS: ReadOptions = ReadOptions { feed: 10.0, segments: 8 };

    /// The quarter circle as a rational quadratic: every point at distance 1.
    #[test]
    fn rational_weights_make_a_circle() {
        let text = r#"{"degree": 2, "control_points": [[1, 0], [1, 1], [0, 1]],
            "weights": [1, 0.7071067811865476, 1], "knots": [0, 0, 0, 1, 1, 1]}"#;
        let program = parse(text, OPTIONS).unwrap();
        assert_eq!(program.moves.len(), 8);
        for step in &program.moves {
            let Course::Line { to } = step.path else { panic!("a chord is a line") };
            assert!((to[0].hypot(to[1]) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn wrong_curves_are_explained() {
        for (text, part) in [
            ("{", "not a NURBS curve"),
            (r#"{"degree": 3, "control_points": [[0, 0]], "knots": []}"#, "too few"),
            (
                r#"{"degree": 1, "control_points": [[0], [1]], "knots": [0, 0, 1]}"#,
                "4 are expected",
            ),
            (
                r#"{"degree": 1, "control_points": [[0], [1]], "weights": [1, 0], "knots": [0, 0, 1, 1]}"#,
                "weights[1]",
            ),
        ] {
            let error = format!("{:#}", parse(text, OPTIONS).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
    }
}
