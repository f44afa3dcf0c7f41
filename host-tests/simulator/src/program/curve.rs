//! Curves as cubic blocks: splines as they are, NURBS of any degree within [`ERROR`] of what they mean.

use super::{AXES, Course, Move, Point, Program, ReadOptions, Speed};
use crate::spline::{Nurbs, SplineFile};
use anyhow::{Result, bail, ensure};
use splineway::spline::nurbs::ERROR;

/// A NURBS curve as cubic blocks; as chords of equal parameter steps if the options ask for them.
fn of_nurbs(curve: &Nurbs, options: ReadOptions<'_>) -> Result<Program> {
    let cubics = curve.cubics(ERROR)?;
    let are_known = cubics.iter().flat_map(|cubic| cubic.points).flatten().all(f64::is_finite);
    ensure!(are_known, "knots or weights lie so far apart that the curve cannot be computed");
    for two in cubics.windows(2) {
        let ([.., here], [from, ..]) = (two[0].points, two[1].points);
        let is_torn = (0..3).any(|axis| !((here[axis] - from[axis]).abs() < ERROR));
        ensure!(!is_torn, "the curve is torn: it leaps from {here:?} to {from:?}");
    }
    if let Some(segments) = options.segments {
        return chords(curve, segments, options.feed);
    }
    let mut program = empty(curve);
    for cubic in cubics {
        let [_, first, second, to] = cubic.points.map(wide);
        let path = if cubic.is_straight {
            Course::Line { to }
        } else {
            Course::Cubic { controls: [first, second], to }
        };
        program.exact.push(curve.piece(cubic.range));
        push(&mut program, path, options.feed)?;
    }
    ensure!(!program.moves.is_empty(), "the curve has no length");
    Ok(program)
}

/// A program that begins where the curve does, and names the axes that it names.
fn empty(curve: &Nurbs) -> Program {
    let mut program = Program { start: at(curve, curve.domain().0), ..Program::default() };
    program.uses[..curve.axes().min(3)].fill(true);
    program
}

fn at(curve: &Nurbs, u: f64) -> Point {
    wide(curve.point(u))
}

fn wide([x, y, z]: [f64; 3]) -> Point {
    let mut point = [0.0; AXES];
    point[..3].copy_from_slice(&[x, y, z]);
    point
}

fn push(program: &mut Program, path: Course, feed: f64) -> Result<()> {
    let line = u32::try_from(program.moves.len() + 1)?;
    let speed = Speed::PerSecond(feed);
    program.moves.push(Move::new(path, speed, line));
    Ok(())
}

/// A curve as chords: then they are the program, and it is said how far they lie off.
fn chords(curve: &Nurbs, segments: usize, feed: f64) -> Result<Program> {
    const PLACES: usize = 16;
    if segments == 0 {
        bail!("a curve cannot be cut into 0 segments");
    }
    let (begin, end) = curve.domain();
    let parameter = |k: f64| begin + (end - begin) * k / segments as f64;
    let mut program = empty(curve);
    let (mut here, mut off) = (program.start, 0.0f64);
    for k in 1..=segments {
        let to = at(curve, parameter(k as f64));
        for n in 1..PLACES {
            let point = at(curve, parameter(k as f64 - n as f64 / PLACES as f64));
            off = off.max(from_line(&point, &here, &to));
        }
        push(&mut program, Course::Line { to }, feed)?;
        here = to;
    }
    program.warnings.push(format!(
        "the curve is run as {segments} chords, which lie up to {off:.6} mm off it; the tolerance counts from them"
    ));
    Ok(program)
}

/// Distance of a point from a line between two others, mm.
fn from_line(point: &Point, from: &Point, to: &Point) -> f64 {
    let dot = |f: &dyn Fn(usize) -> (f64, f64)| (0..3).map(|i| f(i).0 * f(i).1).sum::<f64>();
    let square = dot(&|i| (to[i] - from[i], to[i] - from[i]));
    let along = dot(&|i| (to[i] - from[i], point[i] - from[i]));
    let t = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    let off = |i: usize| point[i] - from[i] - (to[i] - from[i]) * t;
    dot(&|i| (off(i), off(i))).sqrt()
}

/// A spline file as cubic blocks, one per span. (The tolerance in it is that of smoothing; the run
/// takes the machine's.)
///
/// # Errors
/// Names what is wrong with the spline.
pub fn parse_spline(file: &SplineFile, options: ReadOptions<'_>) -> Result<Program> {
    let mut program = of_spline(file, options)?;
    let unused = file.unused();
    if !unused.is_empty() {
        program.warnings.push(format!("not used: {}", unused.join(", ")));
    }
    Ok(program)
}

fn of_spline(file: &SplineFile, options: ReadOptions<'_>) -> Result<Program> {
    let feed = file.feed.unwrap_or(options.feed);
    if let Some(curve) = file.by_all_knots()? {
        return of_nurbs(&curve, ReadOptions { feed, ..options });
    }
    options.check_no_chords()?;
    let path = file.path()?;
    let mut program = Program { start: wide(path.point(0, 0.0)), ..Program::default() };
    let named = file.control_points.iter().map(Vec::len).max().unwrap_or(0);
    program.uses[..named.min(3)].fill(true);
    for span in 0..path.spans() {
        let [_, first, second, to] = path.bezier(span).map(wide);
        push(&mut program, Course::Cubic { controls: [first, second], to }, feed)?;
    }
    Ok(program)
}

/// A spline file in JSON.
///
/// # Errors
/// Names the place in the text and what is wrong there.
pub fn parse_json(text: &str, options: ReadOptions<'_>) -> Result<Program> {
    parse_spline(&SplineFile::parse(text, "json")?, options)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPTIONS: ReadOptions<'static> = ReadOptions { feed: 10.0, ..ReadOptions::DEFAULT };
    const QUARTER: &str = r#"{"degree": 2, "control_points": [[100, 0], [100, 100], [0, 100]],
        "weights": [1, 0.7071067811865476, 1], "knots": [0, 0, 0, 1, 1, 1]}"#;

    /// The quarter circle as a rational quadratic: every point of every block at its distance.
    #[test]
    fn a_curve_becomes_cubics_that_stay_on_it() {
        let program = parse_json(QUARTER, OPTIONS).unwrap();
        assert!(program.moves.len() < 100 && program.moves.len() == program.exact.len());
        let mut here = program.start;
        for step in &program.moves {
            let Course::Cubic { controls, to } = &step.path else { panic!("{step:?}") };
            for k in 0..=20 {
                let point = super::super::on_cubic(&here, controls, to, f64::from(k) / 20.0);
                assert!((point[0].hypot(point[1]) - 100.0).abs() <= ERROR);
            }
            here = *to;
        }
        assert!(here[0].abs() < 1e-12 && (here[1] - 100.0).abs() < 1e-12);
    }

    /// Chords if they are asked for, and how far they are off.
    #[test]
    fn chords_say_how_far_they_lie_off() {
        let program = parse_json(QUARTER, ReadOptions { segments: Some(8), ..OPTIONS }).unwrap();
        assert_eq!((program.moves.len(), program.exact.len()), (8, 0));
        let sagitta = 100.0 * (1.0 - (std::f64::consts::PI / 32.0).cos());
        let said = &program.warnings[0];
        let off: f64 = said
            .split_whitespace()
            .find_map(|word| word.parse().ok().filter(|x: &f64| x.fract() != 0.0))
            .unwrap();
        assert!((off / sagitta - 1.0).abs() < 0.2, "{said}");
    }

    /// A knot of full multiplicity tears it, however it is run.
    #[test]
    fn a_curve_that_is_torn_is_refused() {
        let text = r#"{"degree": 2, "control_points": [[0, 0], [5, 5], [10, 0], [30, 0], [35, 5], [40, 0]],
            "knots": [0, 0, 0, 1, 1, 1, 2, 2, 2]}"#;
        for segments in [None, Some(200)] {
            let error = parse_json(text, ReadOptions { segments, ..OPTIONS }).unwrap_err();
            assert!(error.to_string().contains("it leaps from [10.0, 0.0, 0.0]"), "{error}");
        }
    }

    /// Poly-lines, a curve with a kink, and curves of all degrees.
    #[test]
    fn straight_pieces_are_lines_and_kinks_are_kept() {
        let text = r#"{"degree": 1, "control_points": [[0, 0], [10, 0], [10, 10]], "knots": [0, 0, 1, 2, 2]}"#;
        let program = parse_json(text, OPTIONS).unwrap();
        assert!(program.moves.iter().all(|step| matches!(step.path, Course::Line { .. })));
        assert_eq!(program.moves.len(), 2);
        let text = r#"{"degree": 2, "control_points": [[0, 0], [5, 5], [10, 0], [15, 5], [20, 0]],
            "knots": [0, 0, 0, 1, 1, 2, 2, 2]}"#;
        let program = parse_json(text, OPTIONS).unwrap();
        assert_eq!(program.moves.len(), 2, "parabolas are cubics");
        for degree in 1..=9usize {
            let points: Vec<String> =
                (0..12).map(|k| format!("[{}, {}]", 3 * k, (k * k * 7) % 11)).collect();
            let mut knots = vec![0.0; degree + 1];
            knots.extend((1..12 - degree).map(|k| k as f64));
            knots.extend(vec![(12 - degree) as f64; degree + 1]);
            let text = format!(
                r#"{{"degree": {degree}, "control_points": [{}], "knots": {knots:?}}}"#,
                points.join(",")
            );
            let file = SplineFile::parse(&text, "json").unwrap();
            let curve = file.by_all_knots().unwrap().unwrap();
            let program = parse_json(&text, OPTIONS).unwrap();
            let Some(Course::Cubic { to, .. } | Course::Line { to }) =
                program.moves.last().map(|step| step.path.clone())
            else {
                panic!("no move")
            };
            let end = curve.point(curve.domain().1);
            assert!((to[0] - end[0]).hypot(to[1] - end[1]) < 1e-9, "degree {degree}");
        }
    }

    /// What a curve of any degree says of itself counts, and what it says in vain is told.
    #[test]
    fn the_members_of_a_curve_count() {
        for degree in ["", r#""degree": 3,"#, r#""degree": 3, "weights": [1, 1, 1, 1],"#] {
            let text = format!(
                r#"{{{degree} "control_points": [[0, 0], [1, 0], [2, 1], [3, 3]],
                    "knots": [0, 0, 0, 0, 1, 1, 1, 1], "units": "mm", "source": "here""#
            );
            let read = |more: &str| parse_json(&format!("{text}{more}}}"), OPTIONS);
            let program = read(r#", "feed": 5, "speed": 7"#).unwrap();
            assert!(
                program.moves.iter().all(|step| step.speed == Speed::PerSecond(5.0)),
                "{degree}"
            );
            assert_eq!(program.warnings, ["not used: speed"], "{degree}");
            for (more, part) in [
                (r#", "feed": -5"#, "feed is -5"),
                (r#", "tolerance": 0"#, "tolerance is 0"),
                (r#", "feed": 5, "feed": 6"#, "duplicate field"),
            ] {
                let error = format!("{:#}", read(more).unwrap_err());
                assert!(error.contains(part), "{error}");
            }
            let inches = format!("{text}}}").replace("mm", "inch");
            let error = format!("{:#}", parse_json(&inches, OPTIONS).unwrap_err());
            assert!(error.contains("units are \"inch\""), "{error}");
        }
    }

    #[test]
    fn wrong_curves_are_explained() {
        for (text, part) in [
            ("{", "not a spline"),
            (r#"{"degree": 2, "control_points": [[0, 0]], "knots": []}"#, "too few"),
            (r#"{"degree": 3, "control_points": [[0, 0]], "knots": [0, 0, 1, 1, 1]}"#, "too few"),
            (
                r#"{"degree": 1, "control_points": [[0], [1]], "knots": [0, 0, 1]}"#,
                "4 are expected",
            ),
            (
                r#"{"degree": 1, "control_points": [[0], [1]], "weights": [1, 0], "knots": [0, 0, 1, 1]}"#,
                "weights[1]",
            ),
            (
                r#"{"degree": 1, "control_points": [[1, 1], [1, 1]], "knots": [0, 0, 1, 1]}"#,
                "no length",
            ),
        ] {
            let error = format!("{:#}", parse_json(text, OPTIONS).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
    }
}
