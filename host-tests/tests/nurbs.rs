//! NURBS blocks of G-code (G5.2 to G5.3): the curve that is meant, within the tolerance; and what is refused.

use anyhow::Result;
use fastrand::Rng;
use splineway_simulator::judge::{judged, violations};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Course, Dialect, Point, Program, ReadOptions, gcode};
use splineway_simulator::run::{Events, Observer, Precision, Sample, run};
use std::fmt::Write;

/// A curve as a program has it: X, Y and the weight of every control point.
struct Curve {
    order: usize,
    points: Vec<[f64; 3]>,
}

impl Curve {
    /// In a square of `size` mm, with weights of 0.2 to 5.
    fn random(rng: &mut Rng, order: usize, size: f64) -> Self {
        let count = order + rng.usize(0..8);
        let mm = |rng: &mut Rng| (rng.f64() * size * 1000.0).round() / 1000.0;
        let weight = |rng: &mut Rng| (5f64.powf(rng.f64() * 2.0 - 1.0) * 1000.0).round() / 1000.0;
        let points = (0..count).map(|_| [mm(rng), mm(rng), weight(rng)]).collect();
        Self { order, points }
    }

    fn text(&self, before: &str) -> String {
        let [x, y, p] = self.points[0];
        let mut text = format!("{before}\nG0 X{x} Y{y}\nF6000\nG5.2 P{p} L{}\n", self.order);
        for [x, y, p] in &self.points[1..] {
            writeln!(text, "X{x} Y{y} P{p}").unwrap();
        }
        text + "G5.3\n"
    }

    fn knots(&self) -> Vec<f64> {
        let (n, k) = (self.points.len(), self.order);
        (0..n + k).map(|i| (i + 1).clamp(k, n + 1) as f64 - k as f64).collect()
    }

    /// The point at a parameter, by the definition of the basis functions on the fly: degree after degree in
    /// homogeneous coordinates.
    fn at(&self, u: f64) -> [f64; 2] {
        let (n, k, knots) = (self.points.len(), self.order, self.knots());
        let last = u >= knots[n];
        let mut basis: Vec<f64> = knots
            .windows(2)
            .map(|pair| {
                let inside = pair[0] <= u && (u < pair[1] || last && pair[1] >= knots[n]);
                f64::from(u8::from(inside && pair[0] < pair[1]))
            })
            .collect();
        for p in 1..k {
            let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
            basis = (0..basis.len() - 1)
                .map(|i| {
                    share(u - knots[i], knots[i + p] - knots[i]) * basis[i]
                        + share(knots[i + p + 1] - u, knots[i + p + 1] - knots[i + 1])
                            * basis[i + 1]
                })
                .collect();
        }
        let mut sum = [0.0; 3];
        for (basis, [x, y, w]) in basis.iter().zip(&self.points) {
            for (sum, part) in sum.iter_mut().zip([x * w, y * w, *w]) {
                *sum += basis * part;
            }
        }
        [sum[0] / sum[2], sum[1] / sum[2]]
    }

    /// Points so dense that the lines between them are it.
    fn dense(&self) -> Vec<[f64; 2]> {
        let spans = self.points.len() + 1 - self.order;
        let count = 8000 * spans;
        (0..=count).map(|k| self.at(spans as f64 * k as f64 / count as f64)).collect()
    }
}

fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (way, off) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = way[0] * way[0] + way[1] * way[1];
    let along = if square > 0.0 { (way[0] * off[0] + way[1] * off[1]) / square } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    (off[0] - along * way[0]).hypot(off[1] - along * way[1])
}

/// How far the motion is from the curve at most, in the order of both.
struct Off {
    dense: Vec<[f64; 2]>,
    at: usize,
    most: f64,
}

impl Off {
    fn of(curve: &Curve) -> Self {
        Self { dense: curve.dense(), at: 0, most: 0.0 }
    }
}

impl Observer for Off {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        const AHEAD: usize = 2000;
        let place = [sample.position[0], sample.position[1]];
        let from = self.at.saturating_sub(50);
        let near = self.dense[from..].windows(2).take(AHEAD).enumerate();
        let each = near.map(|(k, pair)| (k, distance(place, pair[0], pair[1])));
        if let Some((k, off)) = each.min_by(|a, b| a.1.total_cmp(&b.1)) {
            self.at = from + k;
            self.most = self.most.max(off);
        }
        Ok(())
    }
}

fn read(text: &str) -> Program {
    gcode::parse(text, 10.0).unwrap_or_else(|error| panic!("{text}: {error:#}"))
}

fn errors(text: &str) -> Vec<String> {
    let options = ReadOptions { dialect: Some(Dialect::LinuxCnc), ..ReadOptions::DEFAULT };
    let (_, findings) = gcode::examine(text.as_bytes(), options);
    findings.iter().filter(|finding| finding.is_error()).map(ToString::to_string).collect()
}

fn ends(program: &Program) -> Vec<[f64; 2]> {
    let mut ends: Vec<[f64; 2]> = Vec::new();
    for step in &program.moves {
        let to: Option<&Point> = step.path.end();
        ends.extend(to.map(|to| [to[0], to[1]]));
    }
    ends
}

/// Sums of what the conversion and what the motion leave the curve by are within the tolerance, of the machine or of the
/// program; and the curve is run from its first to its last control point.
#[test]
fn the_motion_is_within_the_tolerance_of_the_curve() {
    let mut rng = Rng::with_seed(5);
    for round in 0..16 {
        let curve = Curve::random(&mut rng, 3 + round % 8, 60.0);
        let tolerance = [0.05, 0.01, 0.001][round % 3];
        let own = round % 2 == 0;
        let path_mode = if own { format!("G64 P{tolerance}") } else { String::new() };
        let mut program = read(&curve.text(&path_mode));
        // Without the way to its beginning.
        let start = ends(&program)[0];
        program.moves.remove(0);
        program.start[..2].copy_from_slice(&start);
        let last = curve.points[curve.points.len() - 1];
        assert_eq!(
            ends(&program).last().unwrap().map(f64::to_bits),
            [last[0], last[1]].map(f64::to_bits)
        );
        let machine =
            Machine { tolerance: if own { 1.0 } else { tolerance }, ..Machine::default() };
        for precision in [Precision::F32, Precision::F64] {
            let mut off = Off::of(&curve);
            run(&program, &machine, precision, &mut [&mut off]).unwrap();
            assert!(
                off.most <= tolerance && off.at + 2 >= off.dense.len() - 1,
                "{round}: {} of {tolerance}",
                off.most
            );
            let (verdict, _) = judged(&program, &machine, precision, &Events::default()).unwrap();
            assert!(violations(&verdict).is_empty(), "{round}: {:?}", violations(&verdict));
        }
    }
}

/// The blocks are on the curve to a micrometre's thousandth, whatever order, weights, units, offsets and rotation.
#[test]
fn the_blocks_are_on_the_curve() {
    let mut rng = Rng::with_seed(7);
    for round in 0..24 {
        let curve = Curve::random(&mut rng, 3 + round % 8, 200.0);
        let (before, scale, shift) = match round % 3 {
            0 => ("", 1.0, [0.0; 2]),
            1 => ("G20", 25.4, [0.0; 2]),
            _ => ("G92 X-100 Y20", 1.0, [100.0, -20.0]),
        };
        let program = read(&curve.text(before));
        let dense: Vec<[f64; 2]> = curve
            .dense()
            .iter()
            .map(|[x, y]| [x * scale + shift[0], y * scale + shift[1]])
            .collect();
        let mut at = 0;
        let mut here = ends(&program)[0];
        for step in &program.moves[1..] {
            let Some(to) = step.path.end() else { panic!("{step:?}") };
            let controls = match &step.path {
                Course::Cubic { controls: [a, b], .. } => [[a[0], a[1]], [b[0], b[1]]],
                _ => [here, [to[0], to[1]]],
            };
            let b = [here, controls[0], controls[1], [to[0], to[1]]];
            for k in 0..=8 {
                let (u, v) = (f64::from(k) / 8.0, 1.0 - f64::from(k) / 8.0);
                let weights = [v * v * v, 3.0 * v * v * u, 3.0 * v * u * u, u * u * u];
                let p = std::array::from_fn(|i| (0..4).map(|j| weights[j] * b[j][i]).sum::<f64>());
                let near = dense[at..].windows(2).take(2000).enumerate();
                let each = near.map(|(k, pair)| (k, distance(p, pair[0], pair[1])));
                let (ahead, off) = each.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
                at += ahead;
                // A line between two samples is off the curve by an eighth of the second difference.
                let [a, b, c] = [0, 1, 2].map(|k| dense[(at + k).min(dense.len() - 1)]);
                let bend = (a[0] - 2.0 * b[0] + c[0]).hypot(a[1] - 2.0 * b[1] + c[1]);
                assert!(off < 1.01e-6 + bend / 6.0, "{round}: {off}");
            }
            here = [to[0], to[1]];
        }
        assert!(at + 3 >= dense.len(), "{round}: it ends at {at} of {}", dense.len());
    }
}

/// The example of LinuxCNC's manual, and a quarter of a circle.
#[test]
fn blocks_are_read_as_linuxcnc_reads_them() {
    let manual = "G0 X0 Y0 (rapid move)\nF10 (set feed rate)\nG5.2 P1 L3\n     X0 Y1 P1\n     X2 Y2 P1\n     X2 Y0 P1\n     X0 Y0 P2\nG5.3\nG0 X0 Y1\nM2\n";
    let program = read(manual);
    assert!(
        program.moves.len() > 4
            && program.moves.iter().all(|step| step.line >= 8 || step.line == 1)
    );
    let w = 0.5f64.sqrt();
    for text in [
        format!("G0 X10\nF600\nG5.2 P1 L3\nX10 Y10 P{w}\nX0 Y10 P1\nG5.3"),
        // The first control point in the line of G5.2, the code again, weights and order left out, blank lines, feeds.
        format!("G0 X10\nG5.2 X10 Y10 P{w}\n\nN5 (a comment)\nF600\nG5.2 X0 Y10\nN9 G5.3"),
        format!("G0 X10\nG5.2 X10 Y10 P{w} L3\nX0 Y10 P1\nG5.3 F600"),
    ] {
        let program = read(&text);
        assert!(program.moves.len() > 3, "{program:?}");
        for [x, y] in &ends(&program)[1..] {
            assert!((x.hypot(*y) - 10.0).abs() < 1e-6, "{text}: {x} {y}");
        }
    }
    // Under G61 the machine stops where the curve ends, and nowhere in it.
    let program = read("G61\nG0 X10\nF600\nG5.2\nX10 Y10 P.7\nX0 Y10\nG5.3");
    let stops: Vec<bool> = program.moves[1..].iter().map(|step| step.exact_stop).collect();
    assert!(stops.iter().rev().skip(1).all(|stop| !stop) && stops.last() == Some(&true));
}

#[test]
fn what_is_refused_and_where() {
    let block = |inside: &str| format!("G0 X1\nF600\nG5.2 P1 L4\n{inside}\nG5.3\n");
    let fine = "X1 Y1\nX2 Y1\nX3 Y0";
    assert_eq!(errors(&block(fine)), [""; 0]);
    for (inside, line, part) in [
        ("X1 Y1\nX2\nX3 Y0", 5, "G5.2 needs X and Y together"),
        ("X1 Y1\nP2\nX3 Y0", 5, "G5.2 needs X and Y together"),
        ("X1 Y1 P0\nX2 Y1\nX3 Y0", 4, "P0: it must be from 0.001 to 1000"),
        ("X1 Y1 P-2\nX2 Y1\nX3 Y0", 4, "P-2"),
        ("X1 Y1 Z1\nX2 Y1\nX3 Y0", 4, "no code of this line takes the word Z"),
        ("X1 Y1 L4\nX2 Y1\nX3 Y0", 4, "no code of this line takes the word L"),
        ("X1 Y1\nG1 X2 Y1\nX3 Y0", 5, "G1 cannot stand in a NURBS block"),
        ("X1 Y1\nM3 S100\nX2 Y1\nX3 Y0", 5, "M3 cannot stand in a NURBS block"),
        ("X1 Y1\nG91\nX2 Y1\nX3 Y0", 5, "G91 cannot stand in a NURBS block"),
        ("X1 Y1\nO5\nX2 Y1\nX3 Y0", 5, "O cannot stand in a NURBS block"),
        ("X1 Y1\nX2 Y1\nX1e+9 Y0", 6, "coordinates must be within"),
        ("X1 Y1\nX2 Y1\nX3 Y1\nG5.3 X3 Y0", 7, "no code of this line takes the word X"),
        ("X1 Y1\nM2", 5, "M2 cannot stand in a NURBS block"),
    ] {
        let found = errors(&block(inside));
        assert!(
            found[0].starts_with(&format!("line {line}, ")) && found[0].contains(part),
            "{inside}: {found:?}"
        );
        let (program, _) = gcode::examine(block(inside).as_bytes(), ReadOptions::DEFAULT);
        assert_eq!(program.moves.len(), 1, "{inside}: nothing of the block is run");
    }
    for (text, part) in [
        ("F600\nG5.3", "G5.3 ends a NURBS block, and none has begun"),
        ("F600\nG5.2 L2", "L2: it must be a whole number from 3 to 10"),
        ("F600\nG5.2 L11", "L11"),
        ("F600\nG18 G5.2", "G5.2 needs the XY plane"),
        ("F600\nG91 G5.2", "G5.2 needs absolute coordinates"),
        ("G93 G5.2", "G5.2 needs a feed per minute"),
        ("F600\nG5.2 M2", "M2 cannot stand in the line"),
        ("F600\nG5.2 G9", "G9 cannot stand in the line"),
        ("F600\nG53 G5.2", "G53 cannot stand in the line"),
        ("F600\nG5.2 Z5", "the word Z"),
        ("F600\nG5.2 G1", "G5.2 and G1 exclude each other"),
        ("F600\nG5.2\nX1 Y1\nG5.3", "2 control points of a NURBS block; it must have 3 to 64"),
        ("F600\nG5.2\nX1 Y1\nX2 Y2", "G5.2 needs its end, G5.3"),
        ("%\nF600\nG5.2\nX1 Y1\nX2 Y2\n%", "G5.2 needs its end, G5.3"),
    ] {
        assert!(errors(text)[0].contains(part), "{text}: {:?}", errors(text));
        let (program, _) = gcode::examine(text.as_bytes(), ReadOptions::DEFAULT);
        assert!(program.moves.is_empty(), "{text}: {:?}", program.moves);
    }
    // As many as there is room for, and one more.
    let points = |count: usize| -> String {
        (1..count).fold(String::new(), |text, k| format!("{text}X{k} Y{}\n", k % 2))
    };
    let text = |count| format!("F600\nG5.2\n{}G5.3", points(count));
    assert!(read(&text(64)).moves.len() > 60);
    assert!(errors(&text(65))[0].contains("65 control points"), "{:?}", errors(&text(65)));
    // Lines behind a block that is refused are read as if it had been run.
    let found = errors("F600\nG5.2\nX5\nX1 Y1\nG5.3\nG1 X2\nX3");
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found[1].contains("G5.3 ends a NURBS block of which a line has been refused"),
        "{found:?}"
    );
    // Whatever is wrong with the line of G5.3, the block ends there.
    for end in [
        "G5.3 $",
        "$ G5.3",
        "G5.3 G999",
        "G5.3 F0",
        "G5.3 X1..2",
        "G5.3 (",
        "G5.3 X",
        "N1 [ g05.30",
    ] {
        let found = errors(&format!("F600\nG5.2\nX1 Y1\nX2 Y0\n{end}\nG1 X3\nG0 X4"));
        assert_eq!(found.len(), 1, "{end}: {found:?}");
    }
    // One that only looks like it does not.
    let found = errors("F600\nG5.2\nX1 Y1\n$ (G5.3)\nX2 Y0\nG5.3");
    assert_eq!(found.len(), 2, "{found:?}");
    // The mode is over.
    assert!(errors("F600\nG5.2\nX1 Y0\nX2 Y2\nG5.3\nX5")[0].contains("without a motion code"));
}
