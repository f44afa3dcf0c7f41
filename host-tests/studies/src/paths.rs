//! Tool paths of our own making, so that every figure can be measured again with this repository alone: shapes of the
//! literature, and what posts of CAM programs write. The same bits on every computer but for the last digit of sines.

use anyhow::{Context, Result};
use splineway_simulator::program::curve::parse_json;
use splineway_simulator::program::{Course, ReadOptions};
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::io;

/// Limits of every axis, mm/s, mm/s2, mm/s3; servo cycle, s; feed, mm/s.
const LIMITS: (f64, f64, f64, f64, f64) = (200.0, 2000.0, 50_000.0, 0.001, 200.0);
/// Tolerances that each is run within, mm.
const TOLERANCES: [f64; 2] = [0.01, 0.05];

type Point = [f64; 3];

/// A poly-line.
#[derive(Clone, Debug)]
pub struct Made {
    /// What it is called.
    pub name: &'static str,
    /// Tolerance, mm.
    pub tolerance: f64,
    /// Vertices, mm; the first is the start.
    pub points: Vec<Point>,
}

impl Made {
    /// Name of its file: `star_0.05.txt`.
    pub fn file_name(&self) -> String {
        format!("{}_{}.txt", self.name, self.tolerance)
    }

    /// As a poly-line file has it.
    pub fn text(&self) -> String {
        let (velocity, acceleration, jerk, cycle, feed) = LIMITS;
        let mut text = format!("# {velocity} {acceleration} {jerk} {} {cycle}\n", self.tolerance);
        for [x, y, z] in &self.points {
            let _ = writeln!(text, "{x:.6} {y:.6} {z:.6} {feed}");
        }
        text
    }
}

/// All poly-lines, at each tolerance, by name.
///
/// # Errors
/// None, unless the butterfly's file is wrong.
pub fn all() -> Result<Vec<Made>> {
    let shapes: [(&str, Vec<Point>); 8] = [
        ("butterfly2000", butterfly(2000)?),
        ("butterfly80", butterfly(80)?),
        ("circle", circle()),
        ("gear", gear()),
        ("guilloche", guilloche()),
        ("star", star()),
        ("walk", walk()),
        ("zigzag90", zigzag()),
    ];
    let each = |(name, points): &(&'static str, Vec<Point>)| {
        let (name, points) = (*name, points.clone());
        TOLERANCES.map(|tolerance| Made { name, tolerance, points: points.clone() })
    };
    Ok(shapes.iter().flat_map(each).collect())
}

/// The butterfly of the literature, a NURBS curve, as chords of equal steps of its parameter.
fn butterfly(chords: usize) -> Result<Vec<Point>> {
    let options = ReadOptions { segments: Some(chords), ..ReadOptions::DEFAULT };
    let program = parse_json(include_str!("../../data/butterfly.json"), options)?;
    let space = |point: &[f64]| [point[0], point[1], point[2]];
    let mut points = vec![space(&program.start)];
    for step in &program.moves {
        let Course::Line { to } = &step.path else { continue };
        points.push(space(to));
    }
    (points.len() == chords + 1).then_some(points).context("the butterfly is no list of chords")
}

/// Twenty legs of 10 mm at right angles.
fn zigzag() -> Vec<Point> {
    let mut points = vec![[0.0; 3]];
    let [mut x, mut y] = [0.0; 2];
    for leg in 0..20 {
        match leg % 4 {
            1 => y += 10.0,
            3 => y -= 10.0,
            _ => x += 10.0,
        }
        points.push([x, y, 0.0]);
    }
    points
}

/// 20 mm radius in chords of 0.1 mm.
fn circle() -> Vec<Point> {
    const CHORDS: u32 = 1257;
    let angle = |k: u32| TAU * f64::from(k) / f64::from(CHORDS);
    (0..=CHORDS).map(|k| [20.0 * angle(k).cos(), 20.0 * angle(k).sin(), 0.0]).collect()
}

/// Seven points, each third one joined.
fn star() -> Vec<Point> {
    let angle = |k: u32| f64::from(k * 3) * TAU / 7.0;
    (0..=7).map(|k| [30.0 * angle(k).cos(), 30.0 * angle(k).sin(), 0.0]).collect()
}

/// A gear's outline, flanks with corners at root and tip, in chords of about 0.14 mm, and its bore.
fn gear() -> Vec<Point> {
    const TEETH: u32 = 24;
    const CHORD: f64 = 0.14;
    let polar = |radius: f64, angle: f64| [radius * angle.cos(), radius * angle.sin(), 0.0];
    let mut points = vec![[0.0; 3]];
    let mut to = |from: (f64, f64), to: (f64, f64)| {
        let length = (to.0 - from.0).hypot((to.1 - from.1) * f64::midpoint(from.0, to.0));
        let count = (length / CHORD).ceil().max(1.0) as u32;
        for k in 1..=count {
            let share = f64::from(k) / f64::from(count);
            points.push(polar(from.0 + (to.0 - from.0) * share, from.1 + (to.1 - from.1) * share));
        }
    };
    let pitch = TAU / f64::from(TEETH);
    to((0.0, 0.0), (27.0, 0.0));
    for tooth in 0..TEETH {
        let start = f64::from(tooth) * pitch;
        let at = |share: f64| start + share * pitch;
        to((27.0, at(0.0)), (27.0, at(0.3)));
        to((27.0, at(0.3)), (32.0, at(0.42)));
        to((32.0, at(0.42)), (32.0, at(0.58)));
        to((32.0, at(0.58)), (27.0, at(0.7)));
        to((27.0, at(0.7)), (27.0, at(1.0)));
    }
    to((27.0, TAU), (8.0, TAU));
    to((8.0, TAU), (8.0, 2.0 * TAU));
    points
}

/// Four closed curves of an engraving in chords of about a quarter of a millimetre, lifted from one to the next.
fn guilloche() -> Vec<Point> {
    const CHORDS: u32 = 800;
    let mut points = vec![[0.0, 0.0, 5.0]];
    for ring in 0..4 {
        let ring = f64::from(ring);
        let at = |k: u32| {
            let angle = TAU * f64::from(k) / f64::from(CHORDS);
            let radius = 14.0 + 5.0 * ring + 2.5 * ((7.0 + 2.0 * ring) * angle).cos();
            [radius * angle.cos(), radius * angle.sin(), -0.2 - 0.1 * (11.0 * angle).sin()]
        };
        let [x, y, _] = at(0);
        points.push([x, y, 5.0]);
        points.extend((0..=CHORDS).map(at));
        points.push([x, y, 5.0]);
    }
    points
}

/// Numbers at random, the same ones every time (splitmix64).
struct Draw(u64);

impl Draw {
    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Of a normal distribution.
    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.share()).ln()).sqrt() * (TAU * self.share()).cos()
    }
}

/// 3000 lines of 0.05 to 2 mm that turn as they like, in space.
fn walk() -> Vec<Point> {
    let mut draw = Draw(7);
    let (mut heading, mut turn, mut climb) = (0.0f64, 0.0, 0.0f64);
    let mut points = vec![[0.0; 3]];
    for _ in 0..3000 {
        turn = 0.85 * turn + 0.05 * draw.normal();
        heading += turn;
        climb = 0.9 * climb + 0.03 * draw.normal();
        let length = 0.05 * 40.0f64.powf(draw.share());
        let [x, y, z] = points[points.len() - 1];
        let flat = length * climb.cos();
        let way = [flat * heading.cos(), flat * heading.sin(), length * climb.sin()];
        points.push([x + way[0], y + way[1], z + way[2]]);
    }
    points
}

/// A pocket of 40,000 lines as G-code: loops along a spiral from the middle to the wall (trochoids), then the wall at three depths.
pub fn pocket() -> String {
    /// Radius of a loop, mm; what its centre goes on by in a line, mm; lines of a loop; the spiral's pitch, mm.
    const LOOP: (f64, f64, f64, f64) = (1.2, 0.025, 24.0, 2.4);
    let (radius, step, lines, pitch) = LOOP;
    let mut text =
        String::from("(a pocket)\nG21 G90 G17\nG64 P0.01\nM3 S8000\nG0 Z5\nG0 X1.2 Y0\n");
    text.push_str("G1 Z-2.4 F300\nF1800\n");
    for k in 0..38_400u32 {
        let angle = (4.0 * PI * f64::from(k) * step / pitch).sqrt();
        let turn = TAU * f64::from(k) / lines;
        let out = pitch * angle / TAU;
        let [x, y] = [out * angle.cos(), out * angle.sin()];
        let _ =
            writeln!(text, "G1 X{:.4} Y{:.4}", x + radius * turn.cos(), y + radius * turn.sin());
    }
    for depth in [-0.8, -1.6, -2.4] {
        let wall = |k: u32| {
            let angle = TAU * f64::from(k) / 700.0;
            let radius = 28.0 + 1.5 * (5.0 * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        };
        let [x, y] = wall(0);
        let _ = writeln!(text, "G0 Z5\nG0 X{x:.4} Y{y:.4}\nG1 Z{depth:.3} F300\nF1800");
        for [x, y] in (1..=700).map(wall) {
            let _ = writeln!(text, "G1 X{x:.4} Y{y:.4}");
        }
    }
    text.push_str("G0 Z5\nM5\nM2\n");
    text
}

/// A relief of at least so many bytes as G-code: rows of 100 mm in steps of 0.2 mm over waves.
///
/// # Errors
/// It cannot be written.
pub fn relief(out: &mut impl io::Write, bytes: usize) -> io::Result<()> {
    const STEPS: u32 = 500;
    let mut text =
        String::from("(a relief)\nG21 G90 G17\nG64 P0.01\nG0 Z5\nG0 X0 Y0\nG1 Z0 F3000\n");
    let (mut written, mut row) = (0, 0u32);
    while written + text.len() < bytes {
        let y = f64::from(row) * 0.05;
        for k in 0..=STEPS {
            let k = if row.is_multiple_of(2) { k } else { STEPS - k };
            let x = f64::from(k) * 0.2;
            let z = -2.0 + (x * 0.31).sin() * (y * 0.17).cos() + 0.4 * (x * 1.3 + y).sin();
            let _ = writeln!(text, "X{x:.3} Y{y:.3} Z{z:.4}");
        }
        out.write_all(text.as_bytes())?;
        written += text.len();
        text.clear();
        row += 1;
    }
    text.push_str("G0 Z5\nM2\n");
    out.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway_simulator::program::gcode::parse;
    use splineway_simulator::program::poly;

    #[test]
    fn they_are_read_as_what_they_are() {
        let made = all().unwrap();
        assert_eq!(made.len(), 16);
        for made in &made {
            let program = poly::parse(&made.text()).unwrap();
            assert_eq!(program.moves.len(), made.points.len() - 1, "{}", made.file_name());
        }
        let program = parse(&pocket(), 50.0).unwrap();
        assert!(program.moves.len() > 40_000, "{}", program.moves.len());
        let furthest = program.moves.iter().filter_map(|step| step.path.end());
        assert!(furthest.map(|to| to[0].hypot(to[1])).fold(0.0, f64::max) < 35.0);
        let mut text = Vec::new();
        relief(&mut text, 100_000).unwrap();
        assert!((100_000..130_000).contains(&text.len()));
        assert!(parse(std::str::from_utf8(&text).unwrap(), 50.0).unwrap().moves.len() > 3000);
    }
}
