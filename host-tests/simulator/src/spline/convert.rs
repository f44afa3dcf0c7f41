//! NURBS as cubic splines within a stated error.

use super::interpolate::interpolate;
use super::nurbs::Nurbs;
use super::path::{Path, ROOM};
use anyhow::{Result, bail};

/// Places looked at in every span.
const PLACES: u32 = 8;

/// The cubic spline through points of a NURBS curve that is within `error` mm of it, at equal
/// parameter, at eight places of every span; spans are halved until it is.
///
/// # Errors
/// If that takes more control points than there is room for: the curve has a corner.
pub fn convert(curve: &Nurbs, error: f64) -> Result<Path> {
    let mut parameters = curve.breaks();
    // Bends of a single span need some points to begin with.
    for _ in 0..2 {
        parameters = halved(&parameters, |_| true);
    }
    loop {
        let points: Vec<[f64; 3]> = parameters.iter().map(|&t| curve.point(t)).collect();
        let path = interpolate(&points, &parameters)?;
        let mut wide = vec![false; path.spans()];
        for (span, wide) in wide.iter_mut().enumerate() {
            let (from, to) = path.range(span);
            *wide = (1..PLACES).any(|k| {
                let u = f64::from(k) / f64::from(PLACES);
                let (a, b) = (path.point(span, u), curve.point(from + (to - from) * u));
                a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt() > error
            });
        }
        if !wide.contains(&true) {
            return Ok(path);
        }
        parameters = halved(&parameters, |span| wide[span]);
        if parameters.len() + 2 > ROOM {
            bail!("no cubic spline of {ROOM} control points is within {error} mm of the curve");
        }
    }
}

fn halved(parameters: &[f64], which: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut out = Vec::new();
    for (span, pair) in parameters.windows(2).enumerate() {
        out.push(pair[0]);
        if which(span) {
            out.push(f64::midpoint(pair[0], pair[1]));
        }
    }
    out.extend(parameters.last());
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rational quarter circle.
    #[test]
    fn a_rational_circle_is_met_within_the_error() {
        let text = r#"{"degree": 2, "control_points": [[10, 0], [10, 10], [0, 10]],
            "weights": [1, 0.7071067811865476, 1], "knots": [0, 0, 0, 1, 1, 1]}"#;
        let curve = Nurbs::read(text).unwrap();
        for error in [1e-2, 1e-5] {
            let path = convert(&curve, error).unwrap();
            for k in 0..=1000 {
                let p = path.at(f64::from(k) / 1000.0);
                assert!((p[0].hypot(p[1]) - 10.0).abs() <= 1.5 * error, "{error}: {p:?}");
            }
        }
        assert!(convert(&curve, 1e-14).is_err());
    }
}
