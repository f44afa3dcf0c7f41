//! NURBS curves of any degree.

use super::path::Path;
use super::rational::Rational;
use anyhow::{Context, Result, ensure};
use splineway::spline::nurbs::{self, Cubic, Cubics, Knots};

/// A NURBS curve.
#[derive(Debug)]
pub struct Nurbs {
    degree: usize,
    control_points: Vec<Vec<f64>>,
    /// One per control point; all 1 if left out.
    weights: Option<Vec<f64>>,
    knots: Vec<f64>,
}

impl Nurbs {
    /// A curve.
    ///
    /// # Errors
    /// Names the member and what is wrong with it.
    pub fn new(
        degree: usize,
        control_points: Vec<Vec<f64>>,
        weights: Option<Vec<f64>>,
        knots: Vec<f64>,
    ) -> Result<Self> {
        let curve = Self { degree, control_points, weights, knots };
        curve.check()?;
        Ok(curve)
    }

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

    /// Axes that its points name: one to three.
    pub fn axes(&self) -> usize {
        self.control_points.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// First and last parameter.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.knots.len() - 1 - self.degree])
    }

    /// The curve from one parameter to another between the same two knots, by blossoms.
    pub fn piece(&self, [from, to]: [f64; 2]) -> Rational {
        let span = self.span(from);
        let point = |k: usize| self.blossom(span, |level| if level > k { from } else { to });
        Rational::new((0..=self.degree).map(point).collect())
    }

    /// Number of the knot at which the span with a parameter begins.
    fn span(&self, u: f64) -> usize {
        let (p, n) = (self.degree, self.control_points.len());
        self.knots[p + 1..n].partition_point(|&knot| knot <= u) + p
    }

    /// Its cubic pieces as a board converts it, within `error` mm.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn cubics(&self, error: f64) -> Result<Vec<Cubic<3>>> {
        self.on_board(|curve| {
            let mut cubics = Cubics::default();
            std::iter::from_fn(|| cubics.step(curve, error)).collect()
        })
    }

    /// The cubic spline that a board converts it to, within `error` mm.
    ///
    /// # Errors
    /// What is wrong with it; more control points than there is room for: the curve has a corner.
    pub fn spline(&self, error: f64) -> Result<Path> {
        let spline = self.on_board(|curve| Path::from_nurbs(curve, error))?;
        spline.with_context(|| format!("no cubic spline is within {error} mm of the curve"))
    }

    /// The same curve as the core knows it.
    fn on_board<T>(&self, with: impl FnOnce(&nurbs::Nurbs<'_, 3>) -> T) -> Result<T> {
        let points: Vec<[f64; 3]> = self
            .control_points
            .iter()
            .map(|point| std::array::from_fn(|i| point.get(i).copied().unwrap_or(0.0)))
            .collect();
        let ones = vec![1.0; points.len()];
        let weights = self.weights.as_deref().unwrap_or(&ones);
        Ok(with(&nurbs::Nurbs::new(self.degree, &points, weights, Knots::Given(&self.knots))?))
    }

    /// The polar form of a span at parameters given for levels 1 to the degree, homogeneous.
    fn blossom(&self, span: usize, parameter: impl Fn(usize) -> f64) -> [f64; 4] {
        let (p, knots) = (self.degree, &self.knots);
        let mut d: Vec<[f64; 4]> = (span - p..=span).map(|i| self.homogeneous(i)).collect();
        for r in 1..=p {
            let u = parameter(r);
            for j in (r..=p).rev() {
                let (a, b) = (knots[j + span - p], knots[j + 1 + span - r]);
                let t = if b > a { (u - a) / (b - a) } else { 0.0 };
                let before = d[j - 1];
                for (x, y) in d[j].iter_mut().zip(before) {
                    *x = (1.0 - t) * y + t * *x;
                }
            }
        }
        d[p]
    }

    fn homogeneous(&self, i: usize) -> [f64; 4] {
        let w = self.weights.as_ref().map_or(1.0, |weights| weights[i]);
        let mut h = [0.0, 0.0, 0.0, w];
        for (slot, x) in h.iter_mut().zip(&self.control_points[i]) {
            *slot = x * w;
        }
        h
    }

    /// The point at a parameter of the domain, by de Boor's algorithm on homogeneous points.
    pub fn point(&self, u: f64) -> [f64; 3] {
        let [x, y, z, w] = self.blossom(self.span(u), |_| u);
        [x / w, y / w, z / w]
    }
}
