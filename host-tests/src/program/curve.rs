//! Curves, cut into chords.

use super::{Course, Move, Program, ReadOptions, Speed};
use crate::smoothing::{Nurbs, SplineFile};
use anyhow::{Result, bail};

/// Greatest distance of a chord from its spline, mm.
const SAG: f64 = 1.0e-4;
/// Most chords of a span.
const MOST_CHORDS: f64 = 1.0e5;

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

/// Cuts a spline file into chords that are within 1e-4 mm of it. (The tolerance in it is that of
/// smoothing; the run takes the machine's.)
///
/// # Errors
/// Names what is wrong with the spline.
pub fn parse_spline(file: &SplineFile, options: ReadOptions) -> Result<Program> {
    let path = file.path()?;
    let mut program = Program::default();
    let point = |[x, y, z]: [f64; 3]| {
        let mut point = [0.0; 9];
        point[..3].copy_from_slice(&[x, y, z]);
        point
    };
    program.start = point(path.point(0, 0.0));
    let mut line = 0;
    for span in 0..path.spans() {
        // A chord over a share u of the span lies up to u^2 / 8 times the second derivative off.
        let (from, to) = path.range(span);
        let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let bend = [0.0, 1.0].map(|u| norm(path.derivatives(span, u)[1]));
        let chords = (to - from) * (bend[0].max(bend[1]) / (8.0 * SAG)).sqrt();
        if chords > MOST_CHORDS {
            bail!("span {span} would take {chords:.0} chords");
        }
        let chords = chords.ceil().max(1.0) as u32;
        for k in 1..=chords {
            line += 1;
            program.moves.push(Move {
                path: Course::Line {
                    to: point(path.point(span, f64::from(k) / f64::from(chords))),
                },
                speed: Speed::PerSecond(file.feed.unwrap_or(options.feed)),
                tolerance: None,
                exact_stop: false,
                line,
            });
        }
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

    const OPTIONS: ReadOptions = ReadOptions { feed: 10.0, segments: 8 };

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
