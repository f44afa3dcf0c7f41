//! Curves: splines as cubic blocks, NURBS of any degree as chords.

use super::{Course, Move, Program, ReadOptions, Speed};
use crate::smoothing::{Nurbs, SplineFile};
use anyhow::{Result, bail};

/// Reads a curve and cuts it into chords of equal parameter steps.
///
/// # Errors
/// Names the place in the file, or the member and what is wrong with it.
pub fn parse_nurbs(text: &str, options: ReadOptions) -> Result<Program> {
    let curve = Nurbs::read(text)?;
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

/// A spline file as cubic blocks, one per span. (The tolerance in it is that of smoothing; the run
/// takes the machine's.)
///
/// # Errors
/// Names what is wrong with the spline.
pub fn parse_spline(file: &SplineFile, options: ReadOptions) -> Result<Program> {
    let path = file.path()?;
    let point = |[x, y, z]: [f64; 3]| {
        let mut point = [0.0; 9];
        point[..3].copy_from_slice(&[x, y, z]);
        point
    };
    let mut program = Program { start: point(path.point(0, 0.0)), ..Program::default() };
    for span in 0..path.spans() {
        let [_, first, second, to] = path.bezier(span).map(point);
        program.moves.push(Move {
            path: Course::Cubic { controls: [first, second], to },
            speed: Speed::PerSecond(file.feed.unwrap_or(options.feed)),
            tolerance: None,
            exact_stop: false,
            line: u32::try_from(span + 1)?,
        });
    }
    Ok(program)
}

/// JSON with a degree is a NURBS curve, cut into chords of equal parameter steps; without one it is a
/// spline file.
///
/// # Errors
/// Names the place in the text and what is wrong there.
pub fn parse_json(text: &str, options: ReadOptions) -> Result<Program> {
    match serde_json::from_str::<serde_json::Value>(text) {
        Ok(value) if value.get("control_points").is_some() && value.get("degree").is_none() => {
            parse_spline(&SplineFile::parse(text, "json")?, options)
        }
        _ => parse_nurbs(text, options),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPTIONS: ReadOptions = ReadOptions { feed: 10.0, segments: 8, ..ReadOptions::DEFAULT };

    /// The quarter circle as a rational quadratic: every point at distance 1.
    #[test]
    fn rational_weights_make_a_circle() {
        let text = r#"{"degree": 2, "control_points": [[1, 0], [1, 1], [0, 1]],
            "weights": [1, 0.7071067811865476, 1], "knots": [0, 0, 0, 1, 1, 1]}"#;
        let program = parse_nurbs(text, OPTIONS).unwrap();
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
            let error = format!("{:#}", parse_nurbs(text, OPTIONS).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
    }
}
