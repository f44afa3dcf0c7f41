//! Splines through points, and NURBS curves as splines.

use crate::bspline::{Spline, append};
use crate::error::SplineError;
use core::array::from_fn;
use heapless::Vec;
use splineway::number::Scalar;
use splineway::number::vector::{Vector, zero};
use splineway::spline::nurbs::Nurbs;

impl<S: Scalar, const N: usize, const CAP: usize> Spline<S, N, CAP> {
    /// The spline through points, mm, at given parameters, without curvature at its ends: two control points more than points.
    ///
    /// Work: one tridiagonal system.
    ///
    /// # Errors
    /// Fewer than two points, more than there is room for, or parameters that are not as many or do not increase.
    pub fn through(points: &[Vector<f64, N>], parameters: &[f64]) -> Result<Self, SplineError> {
        let (n, m) = (points.len(), points.len() + 2);
        if n < 2 {
            return Err(SplineError::TooFew { controls: m });
        }
        if m > CAP {
            return Err(SplineError::TooMany { controls: m, room: CAP });
        }
        if parameters.len() != n {
            return Err(SplineError::KnotCount { knots: parameters.len(), controls: m });
        }
        // Polar form: the point at a knot is made of the control points before, at and after it.
        let knot = |i: usize, by: isize| {
            let at = i.saturating_add_signed(by).min(n - 1);
            parameters.get(at).copied().unwrap_or(0.0)
        };
        let mut rows: Vec<[f64; 3], CAP> = Vec::new();
        let mut controls: Vec<Vector<f64, N>, CAP> = Vec::new();
        for (i, point) in points.iter().enumerate() {
            let t = |by: isize| knot(i, by);
            let (is_first, is_last) = (i == 0, i + 1 == n);
            if is_last {
                // No second derivative: the two edges over their supports are equal.
                let (a, b) = (1.0 / (t(0) - t(-1)), 1.0 / (t(0) - t(-2)));
                append(&mut rows, [b, -a - b, a]);
                append(&mut controls, zero());
            }
            if is_first || is_last {
                append(&mut rows, [0.0, 1.0, 0.0]);
            } else {
                let before = (t(1) - t(0)) * (t(1) - t(0)) / ((t(1) - t(-2)) * (t(1) - t(-1)));
                let after = (t(0) - t(-1)) * (t(0) - t(-1)) / ((t(2) - t(-1)) * (t(1) - t(-1)));
                append(&mut rows, [before, 1.0 - before - after, after]);
            }
            append(&mut controls, *point);
            if is_first {
                let (a, b) = (1.0 / (t(1) - t(0)), 1.0 / (t(2) - t(0)));
                append(&mut rows, [a, -a - b, b]);
                append(&mut controls, zero());
            }
        }
        solve(&mut rows, &mut controls);
        let (mut own, mut knots): (Vec<_, CAP>, Vec<_, CAP>) = (Vec::new(), Vec::new());
        let start = knot(0, 0);
        for parameter in parameters {
            append(&mut knots, S::of(*parameter - start));
        }
        for control in &controls {
            append(&mut own, control.map(S::of));
        }
        Self::open(&own, &knots)
    }

    /// A NURBS curve as a cubic spline within `error` mm of it, by a bound; spans are halved until it is.
    ///
    /// The curve must not have a kink: a spline goes round it, as near as there is room for control points. In `f32` the error
    /// cannot be less than what coordinates are rounded by.
    ///
    /// Work: a tridiagonal system and a bound per span in every round; rounds are at most as many as control points, and
    /// three to eight where the curve is smooth.
    ///
    /// # Errors
    /// There is no room for as many control points as it takes.
    pub fn from_nurbs(curve: &Nurbs<'_, N>, error: f64) -> Result<Self, SplineError> {
        let mut parameters: Vec<f64, CAP> = Vec::new();
        for knot in curve.breaks() {
            push(&mut parameters, knot)?;
        }
        // Bends of a single span need some points to begin with.
        for _ in 0..2 {
            parameters = halved(&parameters, |_, _| true)?;
        }
        // Every round but the last one adds a control point.
        for _ in 0..CAP {
            let mut points: Vec<Vector<f64, N>, CAP> = Vec::new();
            for parameter in &parameters {
                append(&mut points, curve.point(*parameter));
            }
            let spline = Self::through(&points, &parameters)?;
            let is_wide = |span: usize, range: [f64; 2]| {
                let bezier = spline.bezier(span).map(|point| point.map(S::to_f64));
                !(curve.distance(range, &bezier) <= error)
            };
            let more = halved(&parameters, is_wide)?;
            if more.len() == parameters.len() {
                return Ok(spline);
            }
            parameters = more;
        }
        Err(SplineError::TooMany { controls: CAP + 1, room: CAP })
    }
}

/// Gauss without exchange of rows: the system is diagonally dominant but for the rows at the ends, which do no harm.
fn solve<const N: usize>(rows: &mut [[f64; 3]], right: &mut [Vector<f64, N>]) {
    let (mut later, mut sums) = (&mut *rows, &mut *right);
    while let ([row, rest @ ..], [sum, rest_sums @ ..]) = (later, sums) {
        if let (Some(next), Some(next_sum)) = (rest.first_mut(), rest_sums.first_mut()) {
            let factor = next[0] / row[1];
            next[1] -= factor * row[2];
            *next_sum = from_fn(|i| next_sum[i] - factor * sum[i]);
        }
        (later, sums) = (rest, rest_sums);
    }
    let mut beyond: Vector<f64, N> = zero();
    for (row, sum) in rows.iter().zip(right).rev() {
        *sum = from_fn(|i| (sum[i] - row[2] * beyond[i]) / row[1]);
        beyond = *sum;
    }
}

fn push<const CAP: usize>(parameters: &mut Vec<f64, CAP>, value: f64) -> Result<(), SplineError> {
    // There are two control points more.
    let full = SplineError::TooMany { controls: parameters.len() + 3, room: CAP };
    if parameters.len() + 3 > CAP {
        return Err(full);
    }
    parameters.push(value).map_err(|_| full)
}

/// The parameters with one more in the middle of some spans.
fn halved<const CAP: usize>(
    parameters: &[f64],
    which: impl Fn(usize, [f64; 2]) -> bool,
) -> Result<Vec<f64, CAP>, SplineError> {
    let mut out = Vec::new();
    for (span, (from, to)) in parameters.iter().zip(parameters.iter().skip(1)).enumerate() {
        push(&mut out, *from)?;
        if which(span, [*from, *to]) {
            push(&mut out, f64::midpoint(*from, *to))?;
        }
    }
    if let Some(last) = parameters.last() {
        push(&mut out, *last)?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway::number::vector::{norm, sub};
    use splineway::spline::nurbs::Knots;

    #[test]
    fn a_spline_goes_through_its_points() {
        let points: std::vec::Vec<[f64; 3]> =
            (0..9).map(|k| [f64::from(k), f64::from(k * k % 5), f64::from(k % 3)]).collect();
        let parameters = [1.0, 2.0, 2.5, 4.0, 5.0, 5.2, 7.0, 8.0, 9.5];
        let spline = Spline::<f64, 3, 16>::through(&points, &parameters).unwrap();
        assert_eq!(spline.controls().len(), 11);
        for (point, t) in points.iter().zip(parameters) {
            assert!(norm(&sub(&spline.at(t - 1.0), point)) < 1e-12, "{t}");
        }
        for (span, u) in [(0, 0.0), (spline.spans() - 1, 1.0)] {
            assert!(spline.curvature(span, u) < 1e-12);
        }
        let few = Spline::<f64, 3, 10>::through(&points, &parameters).unwrap_err();
        assert_eq!(few, SplineError::TooMany { controls: 11, room: 10 });
        assert!(Spline::<f64, 3, 16>::through(&points, &parameters[1..]).is_err());
        assert!(Spline::<f64, 3, 16>::through(&points[..1], &parameters[..1]).is_err());
        assert!(Spline::<f64, 3, 16>::through(&points[..2], &[1.0, 1.0]).is_err());
        let line = Spline::<f64, 3, 4>::through(&points[..2], &[0.0, 2.0]).unwrap();
        assert!(norm(&sub(&line.at(1.0), &[0.5, 0.5, 0.5])) < 1e-12);
    }

    /// A rational quarter circle, and a poly-line.
    #[test]
    fn rational_circles_are_met_within_the_error() {
        let w = 0.5f64.sqrt();
        let quarter = [[10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let weights = [1.0, w, 1.0];
        let curve = Nurbs::new(2, &quarter, &weights, Knots::Given(&knots)).unwrap();
        for (error, room) in [(1e-2, 16), (1e-5, 64)] {
            let spline = Spline::<f64, 2, 64>::from_nurbs(&curve, error).unwrap();
            assert!(spline.controls().len() <= room, "{}", spline.controls().len());
            for k in 0..=1000 {
                let [x, y] = spline.at(f64::from(k) / 1000.0);
                assert!((x.hypot(y) - 10.0).abs() <= error);
            }
        }
        let spline = Spline::<f32, 2, 64>::from_nurbs(&curve, 1e-3).unwrap();
        let [x, y] = spline.at(0.3);
        assert!((x.hypot(y) - 10.0).abs() <= 1e-3);
        // No room: of control points, of digits.
        assert!(Spline::<f64, 2, 64>::from_nurbs(&curve, 1e-14).is_err());
        assert!(Spline::<f32, 2, 64>::from_nurbs(&curve, 1e-9).is_err());
        assert!(Spline::<f64, 2, 4>::from_nurbs(&curve, 1.0).is_err());
        // A kink is met as long as there is room.
        let kink = [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]];
        let curve = Nurbs::new(1, &kink, &[1.0; 3], Knots::Even).unwrap();
        assert!(Spline::<f64, 2, 256>::from_nurbs(&curve, 1e-2).is_ok());
    }
}
