//! Pieces of NURBS curves as rational Bezier curves: what a program in a curve file means, exactly.

use crate::point::{AXES, Point};

/// Bezier points in homogeneous coordinates: X, Y, Z, each times the weight, and the weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Rational {
    points: Vec<[f64; 4]>,
}

fn middle(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|i| f64::midpoint(a[i], b[i]))
}

fn place([x, y, z, w]: [f64; 4]) -> Point {
    let mut point = [0.0; AXES];
    point[..3].copy_from_slice(&[x / w, y / w, z / w]);
    point
}

fn distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

impl Rational {
    /// A piece by its homogeneous Bezier points: two at least, with weights greater than 0.
    pub fn new(points: Vec<[f64; 4]>) -> Self {
        Self { points }
    }

    /// The point at a parameter from 0 to 1, by de Casteljau's algorithm.
    pub fn point(&self, u: f64) -> Point {
        let mut points = self.points.clone();
        for n in (1..points.len()).rev() {
            for k in 0..n {
                points[k] =
                    std::array::from_fn(|i| points[k][i] * (1.0 - u) + points[k + 1][i] * u);
            }
        }
        place(points[0])
    }

    /// The two halves.
    pub fn halves(&self) -> [Self; 2] {
        let mut points = self.points.clone();
        let n = points.len();
        let (mut first, mut second) = (vec![points[0]], vec![points[n - 1]]);
        for level in (1..n).rev() {
            for k in 0..level {
                points[k] = middle(points[k], points[k + 1]);
            }
            first.push(points[0]);
            second.push(points[level - 1]);
        }
        second.reverse();
        [Self::new(first), Self::new(second)]
    }

    /// Whether it is nowhere further than `error` mm from the line between its ends: it lies in the hull
    /// of its points.
    pub fn is_flat(&self, error: f64) -> bool {
        let points: Vec<Point> = self.points.iter().map(|point| place(*point)).collect();
        let (from, to) = (points[0], points[points.len() - 1]);
        let square: f64 = (0..3).map(|i| (to[i] - from[i]).powi(2)).sum();
        points.iter().all(|point| {
            let along: f64 = (0..3).map(|i| (point[i] - from[i]) * (to[i] - from[i])).sum();
            let t = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
            let foot: Point = std::array::from_fn(|i| from[i] + (to[i] - from[i]) * t);
            distance(point, &foot) <= error
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter circle: halves meet on it.
    #[test]
    fn a_quarter_circle() {
        let w = 0.5f64.sqrt();
        let arc = Rational::new(vec![[1.0, 0.0, 0.0, 1.0], [w, w, 0.0, w], [0.0, 1.0, 0.0, 1.0]]);
        for k in 0..=10 {
            let point = arc.point(f64::from(k) / 10.0);
            assert!((point[0].hypot(point[1]) - 1.0).abs() < 1e-15);
        }
        let [first, second] = arc.halves();
        assert!(distance(&first.point(1.0), &second.point(0.0)) < 1e-15);
        assert!(distance(&first.point(0.5), &arc.point(0.25)) < 1e-15);
    }
}
