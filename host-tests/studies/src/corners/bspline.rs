//! Clamped uniform B-splines of any degree in the plane.

/// A point or vector in the plane.
pub type Planar = (f64, f64);

/// A spline by its control points.
#[derive(Clone, Debug)]
pub struct Spline {
    degree: usize,
    points: Vec<Planar>,
    knots: Vec<f64>,
}

impl Spline {
    /// Ends clamped, inner knots at 1, 2, 3...
    pub fn clamped(degree: usize, points: Vec<Planar>) -> Self {
        let spans = (points.len() - degree) as f64;
        let knots = (0..=points.len() + degree)
            .map(|k| (k as f64 - degree as f64).clamp(0.0, spans))
            .collect();
        Self { degree, points, knots }
    }

    /// Greatest parameter; the least is 0.
    pub fn end(&self) -> f64 {
        (self.points.len() - self.degree) as f64
    }

    /// The derivative by the parameter.
    pub fn derivative(&self) -> Self {
        let p = self.degree;
        let points = self
            .points
            .windows(2)
            .enumerate()
            .map(|(i, pair)| {
                let per = p as f64 / (self.knots[i + p + 1] - self.knots[i + 1]);
                ((pair[1].0 - pair[0].0) * per, (pair[1].1 - pair[0].1) * per)
            })
            .collect();
        let knots = self.knots[1..self.knots.len() - 1].to_vec();
        Self { degree: p - 1, points, knots }
    }

    /// Value at a parameter: de Boor's algorithm.
    pub fn at(&self, u: f64) -> Planar {
        let p = self.degree;
        let span = (u.max(0.0).floor() as usize).min(self.points.len() - p - 1);
        let k = span + p;
        let mut d: Vec<Planar> = self.points[k - p..=k].to_vec();
        for r in 1..=p {
            for j in (r..=p).rev() {
                let low = self.knots[j + k - p];
                let share = (u - low) / (self.knots[j + 1 + k - r] - low);
                d[j].0 += (share - 1.0) * (d[j].0 - d[j - 1].0);
                d[j].1 += (share - 1.0) * (d[j].1 - d[j - 1].1);
            }
        }
        d[p]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guo's five points: the shoulder is (P1 + 2 P2 + P3) / 4, the derivative at the start 3 times
    /// the first edge over its knot distance.
    #[test]
    fn five_points() {
        let points = vec![(-2.0, 0.0), (-1.0, 0.0), (0.0, 0.0), (0.0, 1.0), (0.0, 2.0)];
        let spline = Spline::clamped(3, points);
        let middle = spline.at(1.0);
        assert!((middle.0 + 0.25).abs() < 1e-12 && (middle.1 - 0.25).abs() < 1e-12);
        let slope = spline.derivative().at(0.0);
        assert!((slope.0 - 3.0).abs() < 1e-12 && slope.1.abs() < 1e-12);
    }
}
