//! A cubic spline through points.

use super::path::Path;
use anyhow::{Result, ensure};

/// The C2 cubic spline through points at given parameters, without curvature at its ends: two control
/// points more than points.
///
/// # Errors
/// Fewer than two points, or parameters that do not increase.
pub fn interpolate(points: &[[f64; 3]], parameters: &[f64]) -> Result<Path> {
    let n = points.len();
    ensure!(n >= 2 && parameters.len() == n, "{n} points and {} parameters", parameters.len());
    let last = n.cast_signed() - 1;
    // Polar form: the point at a knot is made of the control points before, at and after it.
    let knot = |i: isize| parameters[i.clamp(0, last).cast_unsigned()];
    let m = n + 2;
    let mut rows = vec![[0.0; 3]; m];
    let mut right = vec![[0.0; 3]; m];
    rows[0] = [0.0, 1.0, 0.0];
    right[0] = points[0];
    rows[m - 1] = [0.0, 1.0, 0.0];
    right[m - 1] = points[n - 1];
    // No second derivative at the ends: the first two edges over their supports are equal.
    let (a, b) = (knot(1) - knot(0), knot(2) - knot(0));
    rows[1] = [1.0 / a, -1.0 / a - 1.0 / b, 1.0 / b];
    let (a, b) = (knot(last) - knot(last - 1), knot(last) - knot(last - 2));
    rows[m - 2] = [1.0 / b, -1.0 / a - 1.0 / b, 1.0 / a];
    for i in 1..n - 1 {
        let t = |by: isize| knot(i.cast_signed() + by);
        let (t0, t1, t2, t3, t4) = (t(-2), t(-1), t(0), t(1), t(2));
        let before = (t3 - t2) * (t3 - t2) / ((t3 - t0) * (t3 - t1));
        let after = (t2 - t1) * (t2 - t1) / ((t4 - t1) * (t3 - t1));
        rows[i + 1] = [before, 1.0 - before - after, after];
        right[i + 1] = points[i];
    }
    // Forward elimination and substitution.
    for i in 1..m {
        let factor = rows[i][0] / rows[i - 1][1];
        rows[i][1] -= factor * rows[i - 1][2];
        for axis in 0..3 {
            right[i][axis] -= factor * right[i - 1][axis];
        }
    }
    let mut controls = vec![[0.0; 3]; m];
    for i in (0..m).rev() {
        for axis in 0..3 {
            let beyond = if i + 1 < m { rows[i][2] * controls[i + 1][axis] } else { 0.0 };
            controls[i][axis] = (right[i][axis] - beyond) / rows[i][1];
        }
    }
    Ok(Path::open(&controls, parameters)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_goes_through_its_points() {
        let points: Vec<[f64; 3]> =
            (0..9).map(|k| [f64::from(k), f64::from(k * k % 5), f64::from(k % 3)]).collect();
        let parameters = [0.0, 1.0, 1.5, 3.0, 4.0, 4.2, 6.0, 7.0, 8.5];
        let path = interpolate(&points, &parameters).unwrap();
        assert_eq!(path.controls().len(), 11);
        for (point, t) in points.iter().zip(parameters) {
            let there = path.at(t);
            for axis in 0..3 {
                assert!((there[axis] - point[axis]).abs() < 1e-12, "{t}: {there:?} {point:?}");
            }
        }
        for (span, u) in [(0, 0.0), (path.spans() - 1, 1.0)] {
            assert!(path.curvature(span, u) < 1e-12);
        }
    }
}
