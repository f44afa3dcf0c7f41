//! The corners of Guo, Yan, Wang 2023, through the whole builder: beside control points worked out from the paper's
//! text by another program (`host-tests/data/vectors/guo_2023.txt`).

use super::*;
use crate::block::Block;
use crate::machine::{AxisLimits, Config, CornerMode, Limits};
use crate::number::vector::norm;
use crate::path::cut::{Cut, Emitted};
use crate::path::hermite::Hermite;
use crate::path::node::Node;
use std::vec::Vec;

const VECTORS: &str = include_str!("../../../host-tests/data/vectors/guo_2023.txt");

/// What rounding may leave, mm.
const ROUNDING: f64 = 1.0e-9;

type Point = [f64; 3];

/// A corner as printed.
struct Printed {
    edge: f64,
    curvature: f64,
    controls: Vec<Point>,
}

/// A path with its corners as printed.
struct Path {
    name: &'static str,
    delta: f64,
    lambda: f64,
    points: Vec<Point>,
    corners: Vec<Printed>,
}

fn paths() -> Vec<Path> {
    let mut paths: Vec<Path> = Vec::new();
    for line in VECTORS.lines().filter(|line| !line.starts_with('#')) {
        let (kind, rest) = line.split_once(' ').unwrap();
        let number = |word: &str| word.parse::<f64>().unwrap();
        let words = || rest.split(' ').skip(1);
        let point = |p: &[f64]| [p[0], p[1], p[2]];
        match kind {
            "path" => {
                let values: Vec<f64> = words().map(number).collect();
                let name = rest.split(' ').next().unwrap();
                let (delta, lambda) = (values[0], values[1]);
                paths.push(Path { name, delta, lambda, points: Vec::new(), corners: Vec::new() });
            }
            "point" => {
                let values: Vec<f64> = rest.split(' ').map(number).collect();
                paths.last_mut().unwrap().points.push(point(&values));
            }
            _ => {
                let values: Vec<f64> = words().map(number).collect();
                paths.last_mut().unwrap().corners.push(Printed {
                    edge: values[1],
                    curvature: values[4],
                    controls: values[5..].chunks(3).map(point).collect(),
                });
            }
        }
    }
    paths
}

fn coords<const N: usize>(point: &[f64; N]) -> [Coord; N] {
    point.map(|x| Coord::from_mm(x).unwrap())
}

fn place<const N: usize>(node: &Node<f64, N>) -> [f64; N] {
    node.at.map(Coord::to_mm)
}

fn apart<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// The cells of a poly-line in the paper's mode.
fn cells<const N: usize>(points: &[[f64; N]], delta: f64, lambda: f64) -> Vec<Emitted<f64, N>> {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; N]).unwrap());
    config.tolerance = delta;
    config.corner = CornerMode::Paper { lambda };
    let block = |(point, tag)| Block::line(coords(point), 100.0, tag);
    let blocks: Vec<_> = points[1..].iter().zip(1..).map(block).collect();
    cut_all(coords(&points[0]), &blocks, &config)
}

/// The cells of a program.
fn cut_all<const N: usize>(
    from: [Coord; N],
    blocks: &[Block<f64, N>],
    config: &Config<f64, N>,
) -> Vec<Emitted<f64, N>> {
    let mut builder = std::boxed::Box::new(Builder::<f64, N, 16>::EMPTY);
    builder.restart(from);
    let mut last = Node { at: from, tangent: [0.0; N], curvature: [0.0; N] };
    let (mut list, mut next): (Vec<Emitted<f64, N>>, usize) = (Vec::new(), 0);
    loop {
        if next == blocks.len() {
            builder.close();
        } else if !builder.is_full() {
            builder.push(&blocks[next], config).unwrap();
            next += 1;
            continue;
        }
        match builder.emit(&last, config) {
            Cut::Cell(cut) => {
                last = cut.node;
                list.push(cut);
            }
            Cut::Working => {}
            Cut::Nothing if next == blocks.len() => return list,
            Cut::Nothing => assert!(!builder.is_full(), "the builder waits, and is full"),
        }
    }
}

/// Every control point of every corner: P0 and P4 are nodes of the path, and so is the apex, at which the curvature is
/// that of the closed form; P2 is the corner itself, and P1 and P3 lie half way.
#[test]
fn corners_are_as_printed() {
    for path in paths() {
        let cells = cells(&path.points, path.delta, path.lambda);
        for (n, printed) in path.corners.iter().enumerate() {
            let name = std::format!("{}, corner {}", path.name, n + 1);
            let node = |at: &Point| {
                let near = |cut: &&Emitted<f64, 3>| {
                    apart(&place(&cut.from), at) < ROUNDING
                        || apart(&place(&cut.node), at) < ROUNDING
                };
                cells.iter().find(near)
            };
            let [p0, p1, p2, p3, p4] = [0, 1, 2, 3, 4].map(|k| printed.controls[k]);
            assert!(node(&p0).is_some(), "{name}: no P0");
            assert!(node(&p4).is_some(), "{name}: no P4");
            assert!(apart(&p2, &path.points[n + 1]) < ROUNDING, "{name}: P2");
            for (p, q) in [(p0, p1), (p1, p2), (p2, p3), (p3, p4)] {
                assert!((apart(&p, &q) - printed.edge).abs() < ROUNDING, "{name}: edges");
            }
            let apex = core::array::from_fn(|i| (p1[i] + 2.0 * p2[i] + p3[i]) / 4.0);
            let found = node(&apex).map(|cut| {
                let at_end = apart(&place(&cut.node), &apex) < ROUNDING;
                norm(&if at_end { cut.node.curvature } else { cut.from.curvature })
            });
            let curvature = found.unwrap_or_else(|| panic!("{name}: no apex"));
            assert!((curvature / printed.curvature - 1.0).abs() < 1.0e-9, "{name}: {curvature}");
        }
    }
}

/// The cells keep to the printed curves to 2e-3 of e, none is made of rounding, and there is no rest but at the end.
#[test]
fn cells_keep_to_the_printed_curve() {
    for path in paths() {
        let cells = cells(&path.points, path.delta, path.lambda);
        let shortest = path.corners.iter().map(|c| c.edge).fold(f64::INFINITY, f64::min);
        let rests = cells.iter().filter(|cut| cut.rest).count();
        assert!(rests == 1 && cells.last().unwrap().rest, "{}: {rests} rests", path.name);
        for cut in &cells {
            let length = cut.cell.length;
            assert!(length > shortest / 64.0, "{}: a cell of {length} mm", path.name);
            let curve = Hermite::of_cell(&cut.from, &cut.cell, &cut.node);
            for k in 1..8 {
                let at = curve.place(&cut.from.at, f64::from(k) / 8.0).map(Coord::to_mm);
                let off = distance(&path, &at);
                assert!(off < 2.0e-3 * path.delta, "{}: {off} mm off at {at:?}", path.name);
            }
        }
    }
}

/// The distance from the printed path, mm.
fn distance(path: &Path, at: &Point) -> f64 {
    const STEPS: usize = 512;
    let mut least = f64::INFINITY;
    let mut see = |a: &Point, b: &Point| least = least.min(from_line(a, b, at));
    let mut start = path.points[0];
    for corner in &path.corners {
        let [p0, p1, p2, p3, p4] = [0, 1, 2, 3, 4].map(|k| corner.controls[k]);
        see(&start, &p0);
        start = p4;
        if apart(&p2, at) > 2.5 * corner.edge {
            continue;
        }
        let mean = |a: &Point, b: &Point| core::array::from_fn(|i| f64::midpoint(a[i], b[i]));
        let (a, b): (Point, Point) = (mean(&p1, &p2), mean(&p2, &p3));
        let apex = mean(&a, &b);
        for bezier in [[p0, p1, a, apex], [apex, b, p3, p4]] {
            let curve = |k: usize| -> Point {
                let u = k as f64 / STEPS as f64;
                let v = 1.0 - u;
                let weights = [v * v * v, 3.0 * v * v * u, 3.0 * v * u * u, u * u * u];
                core::array::from_fn(|i| (0..4).map(|k| weights[k] * bezier[k][i]).sum())
            };
            for k in 0..STEPS {
                see(&curve(k), &curve(k + 1));
            }
        }
    }
    see(&start, path.points.last().unwrap());
    least
}

fn from_line(a: &Point, b: &Point, at: &Point) -> f64 {
    let along = |p: &Point| (0..3).map(|i| (p[i] - a[i]) * (b[i] - a[i])).sum::<f64>();
    let whole = along(b);
    let share = if whole > 0.0 { (along(at) / whole).clamp(0.0, 1.0) } else { 0.0 };
    apart(&core::array::from_fn(|i| a[i] + share * (b[i] - a[i])), at)
}

/// Of a curve that becomes more lines than there is room for, the next are taken as soon as there is.
#[test]
fn a_curve_of_many_lines_never_waits() {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; 2]).unwrap());
    config.tolerance = 0.02;
    let at = |x: f64, y: f64| coords(&[x, y]);
    let curves = [0.0, 15.0, 30.0, 45.0].map(|x| {
        let side = if x % 2.0 == 0.0 { 9.0 } else { -4.0 };
        Block::cubic([at(x + 4.0, side), at(x + 13.0, -side)], at(x + 15.0, 3.0), 100.0, 1)
    });
    let cells = cut_all(at(0.0, 0.0), &curves, &config);
    assert_eq!(cells.last().unwrap().node.at, at(60.0, 3.0));
}
