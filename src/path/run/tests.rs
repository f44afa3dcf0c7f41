//! The band, the joints of cells and the smoothing, on whole poly-lines.

use super::*;
use crate::machine::{AxisLimits, Limits};
use crate::number::vector::{norm, sub};
use crate::path::hermite::Hermite;
use crate::path::node::Programmed;
use std::vec::Vec;

const BAND: f64 = 0.02;

/// A first cell from rest of 0.01 mm.
fn ramp() -> Ramp<f64> {
    let axis = AxisLimits::linear(200.0, 1063.0, 50_000.0);
    Ramp::new(&Limits::new([axis; 2]).unwrap(), &[1.0, 0.0])
}

/// Runs a poly-line through a run; the cells with their nodes.
fn cells(points: &[[f64; 2]], sweeps: u16) -> Vec<Emitted<f64, 2>> {
    cells_within(points, sweeps, |_| BAND)
}

/// The same, with a tolerance for every line.
fn cells_within(
    points: &[[f64; 2]],
    sweeps: u16,
    band: impl Fn(usize) -> f64,
) -> Vec<Emitted<f64, 2>> {
    run_through(points, sweeps, band).0
}

/// The same, with the number of steps in between.
fn run_through(
    points: &[[f64; 2]],
    sweeps: u16,
    band: impl Fn(usize) -> f64,
) -> (Vec<Emitted<f64, 2>>, usize) {
    let mut steps = 0;
    let at = |p: &[f64; 2]| p.map(|x| Coord::from_mm(x).unwrap());
    let programmed = Programmed::feed(100.0);
    let leg = |line| Leg { programmed, tolerance: band(line), error: 0.0 };
    let mut line = 0;
    let mut run = std::boxed::Box::new(Run::new());
    let mut list: Vec<Emitted<f64, 2>> = Vec::new();
    let mut last = Node { at: at(&points[0]), tangent: [0.0; 2], curvature: [0.0; 2] };
    run.begin(
        Start { at: last.at, tie: Tie::Rest, ramp: ramp(), beside: 0.0, before: None },
        leg(0),
    );
    let (end, inner) = points[1..].split_last().unwrap();
    let mut inner = inner.iter();
    let mut ended = false;
    while !run.is_done() {
        let rested = list.last().is_none_or(|cut| cut.rest);
        match run.next(&last, rested, sweeps) {
            Cut::Cell(cut) => {
                last = cut.node;
                list.push(cut);
            }
            Cut::Working => steps += 1,
            Cut::Nothing => {
                if let Some(point) = inner.next() {
                    assert!(run.has_room());
                    run.push(at(point), leg(line));
                    line += 1;
                } else if !ended {
                    run.finish(at(end), leg(line), Tie::Rest, (0.0, None));
                    ended = true;
                } else {
                    assert!(run.is_done(), "a run hangs");
                }
            }
        }
    }
    (list, steps)
}

/// A run ends where its last line does: back within half a nanometre of where it started, too, and of where its last line did.
#[test]
fn a_run_ends_where_its_last_line_does() {
    let back = [[0.0, 0.0], [1.7e-6, 0.0], [-4.0e-7, 0.0]];
    let later = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.7e-6], [1.0, -4.0e-7]];
    let twice = [[0.0, 0.0], [3.0e-6, 0.0], [-4.0e-7, 0.0], [3.0e-6, 0.0], [1.0e-7, 0.0]];
    for points in [&back[..], &later, &twice] {
        let end = points.last().unwrap().map(|x| Coord::from_mm(x).unwrap());
        assert_eq!(cells(points, 8).last().map(|cut| cut.node.at), Some(end), "{points:?}");
    }
}

fn distance(points: &[[f64; 2]], x: [f64; 2]) -> f64 {
    let one = |a: [f64; 2], b: [f64; 2]| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let square = dx * dx + dy * dy;
        let t = if square > 0.0 {
            (((x[0] - a[0]) * dx + (x[1] - a[1]) * dy) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (a[0] + t * dx - x[0]).hypot(a[1] + t * dy - x[1])
    };
    points.windows(2).map(|pair| one(pair[0], pair[1])).fold(f64::INFINITY, f64::min)
}

fn paths() -> Vec<Vec<[f64; 2]>> {
    let wave = (0..300)
        .map(|k| {
            let x = 0.1 * f64::from(k);
            [x, (1.3 * x).sin() + 0.2 * (5.0 * x).sin()]
        })
        .collect();
    let stairs =
        (0..60).map(|k| [0.4 * f64::from(k / 2 + k % 2), 0.4 * f64::from(k / 2)]).collect();
    let noise =
        (0..200).map(|k| [0.05 * f64::from(k), 0.008 * f64::from(k * k % 7 - 3) / 3.0]).collect();
    let spikes =
        (0..100).map(|k| [0.03 * f64::from(k), if k % 10 == 5 { 0.3 } else { 0.0 }]).collect();
    let lengths = (0..60)
        .scan([0.0, 0.0], |at, k| {
            let size = [1.0e-4, 1.0, 0.01, 3.0, 2.0e-7][k % 5];
            let heading = 0.4 * (k as f64 * 0.7).sin();
            *at = [at[0] + size * heading.cos(), at[1] + size * heading.sin()];
            Some(*at)
        })
        .collect();
    std::vec![wave, stairs, noise, spikes, lengths]
}

/// The curve of every cell, at many places, with any number of sweeps.
#[test]
fn the_band_is_never_left() {
    for points in paths() {
        for sweeps in [0, 1, 3, 8, 40] {
            for cut in cells(&points, sweeps) {
                let curve = Hermite::of_cell(&cut.from, &cut.cell, &cut.node);
                for k in 0..=10 {
                    let offset = curve.offset(f64::from(k) / 10.0);
                    let x = [0, 1].map(|i| cut.from.at[i].to_mm() + offset[i]);
                    let off = distance(&points, x);
                    assert!(off <= BAND, "{sweeps} sweeps: {off} at {x:?}");
                }
            }
        }
    }
}

/// A line with a narrower band than its neighbours, which run on nearly straight: where it is
/// beside the path its own band counts (found by the soak).
#[test]
fn every_line_keeps_its_own_band() {
    for (corner, narrow) in [(0.3, 0.001_3), (0.2, 0.003), (0.4, 0.000_5), (0.1, 0.002)] {
        let path = [
            [-1.4, -0.3 - corner],
            [0.0, 0.0],
            [0.207, 0.0],
            [0.2588, 0.0],
            [0.3106, 0.0],
            [1.0, corner],
        ];
        let band = |line: usize| if line == 2 { narrow } else { 0.01 };
        for sweeps in [0, 1, 8, 40] {
            for cut in cells_within(&path, sweeps, band) {
                let curve = Hermite::of_cell(&cut.from, &cut.cell, &cut.node);
                for k in 0..=20 {
                    let offset = curve.offset(f64::from(k) / 20.0);
                    let x = [0, 1].map(|i| cut.from.at[i].to_mm() + offset[i]);
                    let beside = x[0] > path[2][0] && x[0] < path[3][0];
                    assert!(!beside || x[1].abs() <= narrow, "{narrow}: {x:?}");
                }
            }
        }
    }
}

/// Every cell starts where the one before ends, in the same direction and with the same
/// curvature, and the last one ends where the poly-line does.
#[test]
fn cells_join_with_continuous_curvature() {
    for points in paths() {
        let list = cells(&points, 8);
        for pair in list.windows(2) {
            assert_eq!(pair[0].node.at, pair[1].from.at);
            let (a, b) = (&pair[0].node, &pair[1].from);
            let apart =
                norm(&sub(&a.tangent, &b.tangent)).max(norm(&sub(&a.curvature, &b.curvature)));
            assert!(pair[0].rest || apart < 1.0e-15, "{apart}");
        }
        let (first, last) = (points[0], points[points.len() - 1]);
        let (a, b) = (&list[0].from.at, &list[list.len() - 1].node.at);
        assert!((0..2).all(|i| (a[i].to_mm() - first[i]).abs() < 1.0e-9));
        assert!((0..2).all(|i| (b[i].to_mm() - last[i]).abs() < 1.0e-9));
    }
}

/// The integral of the square of the third derivative.
fn roughness(points: &[[f64; 2]], sweeps: u16) -> f64 {
    let change = |cut: &Emitted<f64, 2>| {
        let (a, b) = (&cut.from.curvature, &cut.node.curvature);
        ((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)) / cut.cell.length
    };
    cells(points, sweeps).iter().map(change).sum()
}

/// It falls with the sweeps.
#[test]
fn sweeps_smooth() {
    let roughness = [0, 4, 20].map(|sweeps| roughness(&paths()[0], sweeps));
    assert!(roughness[1] < 0.5 * roughness[0], "{roughness:?}");
    assert!(roughness[2] < 1.05 * roughness[1], "{roughness:?}");
}

/// As smooth with few sweeps as with many, wherever a stretch ends: also where control points are close together.
#[test]
fn few_sweeps_leave_no_kink() {
    let points = &paths()[0];
    let many = roughness(points, 40);
    for sweeps in 1..20 {
        let few = roughness(points, sweeps);
        assert!(few < 1.1 * many, "{sweeps} sweeps: {few} of {many}");
    }
}

/// A stretch that slides on is not drawn into the band by sweeps: some 3.2, 2.2 and 3.3 steps for a cell before.
#[test]
fn a_stretch_takes_few_steps() {
    let [wave, stairs, noise, ..] = &paths()[..] else { panic!("no paths") };
    for (points, most) in [(wave, 2.9), (stairs, 2.0), (noise, 3.15)] {
        let (cells, steps) = run_through(points, 8, |_| BAND);
        let each = steps as f64 / cells.len() as f64;
        assert!(each < most, "{each} steps for a cell, {} cells", cells.len());
    }
}
