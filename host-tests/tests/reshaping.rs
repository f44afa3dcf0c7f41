//! Planned motions that are reshaped window by window: whatever the path does, the judge finds nothing.

use splineway_simulator::judge::violations;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Course, Move, Program, Speed};
use splineway_simulator::run::Precision;
use splineway_studies::reshaping::{Improved, reshaped};

fn program(points: &[[f64; 2]], feeds: &[f64]) -> Program {
    let mut program = Program::default();
    program.uses[..2].fill(true);
    let point = |x: &[f64; 2]| {
        let mut to = [0.0; 9];
        to[..2].copy_from_slice(x);
        to
    };
    program.start = point(&points[0]);
    for (n, x) in points[1..].iter().enumerate() {
        let path = Course::Line { to: point(x) };
        let feed = Speed::PerSecond(feeds[n % feeds.len()]);
        program.moves.push(Move::new(path, feed, n as u32 + 1));
    }
    program
}

/// What is agreed is rendered by quintics of a quarter of a servo cycle, whose jerk between their ends is more than theirs by so much.
const RENDERED: f64 = 1.001;

fn judged(program: &Program, tolerance: f64, precision: Precision) -> Improved {
    let machine = Machine { tolerance, ..Machine::default() };
    let improved = reshaped(program, &machine, precision).unwrap();
    let mut verdict = improved.verdict.clone();
    verdict.mismatch /= RENDERED;
    let broken = violations(&verdict);
    assert!(broken.is_empty(), "{precision:?}, {tolerance} mm: {broken:?}: {program:?}");
    assert!(improved.reshaped <= improved.planned + machine.cycle, "{program:?}");
    improved
}

fn random(state: &mut u32, from: f64, to: f64) -> f64 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    from + (to - from) * f64::from(*state >> 8) / f64::from(1 << 24)
}

/// Of a 3-D print. The line there and the line back lie within their bands for some mm, and the planned motion uses them.
#[test]
fn a_way_that_turns_back_beside_itself_is_gone_to_its_end() {
    let points = [
        [119.0047, 106.0165],
        [119.0047, 105.5528],
        [102.325, 88.873],
        [119.0047, 105.089],
        [94.9375, 81.0218],
        [95.4015, 81.022],
    ];
    let improved = judged(&program(&points, &[25.0, 25.0, 100.0]), 0.05, Precision::F64);
    let gone = |x: &[f64; 2]| {
        let off = |place: &Vec<f64>| (place[0] - x[0]).hypot(place[1] - x[1]);
        improved.setpoints.iter().map(off).fold(f64::INFINITY, f64::min)
    };
    for point in &points {
        assert!(gone(point) < 0.4, "{point:?} is passed at {} mm", gone(point));
    }
}

#[test]
fn random_ways_there_and_back_are_gone_to_their_ends() {
    let mut state = 7;
    for case in 0..60 {
        let (mut points, mut heading) = (vec![[0.0; 2]], random(&mut state, 0.0, 6.3));
        for k in 0..8 {
            let length = random(&mut state, 1.0, 20.0);
            let [x, y] = points[k];
            points.push([x + length * heading.cos(), y + length * heading.sin()]);
            let back = random(&mut state, 0.0, 1.0) < 0.6;
            let (least, most) = if back { (2.8, 3.4) } else { (-2.0, 2.0) };
            heading += random(&mut state, least, most);
        }
        let feeds = [random(&mut state, 10.0, 200.0), random(&mut state, 10.0, 200.0)];
        let tolerance = random(&mut state, 0.005, 0.1);
        let precision = if case % 2 == 0 { Precision::F64 } else { Precision::F32 };
        judged(&program(&points, &feeds), tolerance, precision);
    }
}

#[test]
fn random_short_lines_become_faster() {
    let mut state = 3;
    let (mut planned, mut found) = (0.0, 0.0);
    for case in 0..20 {
        let (mut points, mut heading) = (vec![[0.0; 2]], 0.0f64);
        for k in 0..40 {
            let length = random(&mut state, 0.05, 4.0);
            let [x, y] = points[k];
            points.push([x + length * heading.cos(), y + length * heading.sin()]);
            heading += random(&mut state, -1.5, 1.5);
        }
        let precision = if case % 2 == 0 { Precision::F64 } else { Precision::F32 };
        let improved = judged(&program(&points, &[200.0]), 0.03, precision);
        planned += improved.planned;
        found += improved.reshaped;
    }
    assert!(planned > 1.04 * found, "{planned} {found}");
}
