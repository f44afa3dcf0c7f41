//! A path of the paper through the core, measured by its setpoints.

use super::cases::Case;
use super::routines::{Point, Transition, path_distance, poly_distance};
use anyhow::Result;
use splineway_simulator::judge::{Judge, Track, violations};
use splineway_simulator::machine::{Machine, Mode};
use splineway_simulator::program::{Course, Move, Program, ReadOptions, Speed, inspect_bytes};
use splineway_simulator::run::{Observer, Precision, Sample, run};

/// Feed, mm/s: that of the common bench, beyond what corners allow.
const FEED: f64 = 200.0;
/// Servo cycle at which a path is traced, s. The path does not depend on it.
const CYCLE: f64 = 2.0e-4;
/// Speed below which a setpoint says nothing of the curvature, mm/s: beside a rest a motion leaves the curve by little, but bends
/// more than it (at 0.2 mm/s three times as much).
const RESTING: f64 = 1.0;

/// What a run came to.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Machining time, s.
    pub time: f64,
    /// Greatest distance from the lines, mm.
    pub deviation: f64,
    /// Greatest distance from the printed path, mm.
    pub off_printed: f64,
    /// Greatest curvature, 1/mm.
    pub curvature: f64,
    /// Greatest change of the curvature from one setpoint to the next, 1/mm, at `CYCLE` and at half of it: half as much
    /// where the curvature is continuous.
    pub changes: [f64; 2],
    /// Cells into which the path was cut.
    pub cells: u32,
    /// Planning on this computer, ns per line.
    pub planning: f64,
    /// Limits that were broken: none.
    pub broken: Vec<String>,
    /// Places of the setpoints, mm.
    pub places: Vec<Point>,
    /// Way, mm, and curvature, 1/mm.
    pub profile: Vec<(f64, f64)>,
}

impl Measured {
    /// What the curvature jumps by, at most, 1/mm: what of the changes does not shrink with the cycle.
    pub fn jump(&self) -> f64 {
        (2.0 * self.changes[1] - self.changes[0]).max(0.0)
    }

    /// The least distance of the path from a point, mm: of a corner, e.
    pub fn nearest(&self, to: &Point) -> f64 {
        let each = self.places.windows(2).map(|pair| poly_distance(pair, to));
        each.fold(f64::INFINITY, f64::min)
    }
}

/// The lines through the points of a case.
pub fn program(case: &Case) -> Program {
    let wide = |p: &Point| {
        let mut point = [0.0; 9];
        point[..3].copy_from_slice(p);
        point
    };
    let mut program = Program::default();
    for axis in 0..3 {
        program.uses[axis] = axis < 2 || case.points.iter().any(|p| p[axis] != 0.0);
    }
    program.start = case.points.first().map_or([0.0; 9], wide);
    for (line, point) in (1..).zip(case.points.iter().skip(1)) {
        let path = Course::Line { to: wide(point) };
        program.moves.push(Move::new(path, Speed::PerSecond(FEED), line));
    }
    program
}

/// Places and curvatures of the setpoints.
#[derive(Default)]
struct Tracer {
    places: Vec<Point>,
    profile: Vec<(f64, f64)>,
    last: Option<Vec<f64>>,
    change: f64,
}

impl Observer for Tracer {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let mut place = [0.0; 3];
        for (slot, x) in place.iter_mut().zip(sample.position) {
            *slot = *x;
        }
        self.places.push(place);
        let square: f64 = sample.velocity.iter().map(|v| v * v).sum();
        if square < RESTING * RESTING {
            self.last = None;
            return Ok(());
        }
        let (v, a) = (sample.velocity, sample.acceleration);
        let along: f64 = v.iter().zip(a).map(|(v, a)| v * a).sum::<f64>() / square;
        let bend: Vec<f64> = v.iter().zip(a).map(|(v, a)| (a - along * v) / square).collect();
        let size = |bend: &[f64]| bend.iter().map(|x| x * x).sum::<f64>().sqrt();
        if let Some(last) = &self.last {
            let change: Vec<f64> = bend.iter().zip(last).map(|(a, b)| a - b).collect();
            self.change = self.change.max(size(&change));
        }
        self.profile.push((sample.path, size(&bend)));
        self.last = Some(bend);
        Ok(())
    }
}

/// Runs a case in one of the modes; `printed` are its transitions as printed.
///
/// # Errors
/// The core refuses it.
pub fn measure(case: &Case, mode: Mode, printed: &[Transition]) -> Result<Measured> {
    let program = program(case);
    let machine = |cycle: f64| Machine {
        tolerance: case.delta,
        mode,
        lambda: case.lambda,
        cycle,
        ..Machine::default()
    };
    let limits = machine(CYCLE).axes_of(&program)?;
    let track = Track::new(&program);
    let mut judge = Judge::new(&track, &limits, CYCLE, case.delta);
    let [mut tracer, mut finer] = [Tracer::default(), Tracer::default()];
    let stats = run(&program, &machine(CYCLE), Precision::F64, &mut [&mut judge, &mut tracer])?;
    run(&program, &machine(CYCLE / 2.0), Precision::F64, &mut [&mut finer])?;
    let verdict = judge.verdict();
    let off = |p: &Point| path_distance(&case.points, printed, p);
    Ok(Measured {
        time: verdict.time,
        deviation: verdict.deviation,
        off_printed: tracer.places.iter().map(off).fold(0.0, f64::max),
        curvature: finer.profile.iter().map(|(_, k)| *k).fold(0.0, f64::max),
        changes: [tracer.change, finer.change],
        cells: stats.counters.cells,
        planning: stats.planning.total() / stats.blocks.max(1) as f64,
        broken: violations(&verdict),
        places: tracer.places,
        profile: finer.profile,
    })
}

/// The butterfly of section 4.1 in many lines, in the core's own mode: lines, and the cells that they become.
///
/// # Errors
/// The core refuses it.
pub fn dense_cells() -> Result<[f64; 2]> {
    const LINES: usize = 2000;
    let options = ReadOptions { feed: FEED, segments: Some(LINES), ..ReadOptions::DEFAULT };
    let bytes = include_bytes!("../../../data/butterfly.json");
    let (program, _) = inspect_bytes("butterfly.json".as_ref(), bytes, options)?;
    let machine = Machine { tolerance: 0.05, ..Machine::default() };
    let stats = run(&program, &machine, Precision::F64, &mut [])?;
    Ok([LINES as f64, f64::from(stats.counters.cells)])
}

#[cfg(test)]
mod tests {
    use super::super::{cases, routines};
    use super::*;
    use splineway_simulator::judge::judged;
    use splineway_simulator::run::Events;

    /// The core in the paper's mode keeps to the printed curves - to 0.5 % of delta, which is what the motion over a cell may
    /// leave its curve by -, in the plane and in space, within every limit: every path of the vectors, lambda and the
    /// rule at the end included.
    #[test]
    fn the_core_keeps_to_the_printed_path() {
        for case in cases::all() {
            let printed = routines::transitions(&case.points, case.delta, case.lambda);
            let own = measure(&case, Mode::Paper, &printed).unwrap();
            assert!(own.broken.is_empty(), "{}: {:?}", case.name, own.broken);
            assert!(
                own.off_printed < 0.005 * case.delta,
                "{}: {} mm off",
                case.name,
                own.off_printed
            );
            assert!(own.jump() < 0.02 * own.curvature, "{}: {}", case.name, own.jump());
        }
    }

    /// Stretches of rounding, and others too short to be passed as such, cost nothing: whatever lambda is, the butterfly
    /// takes as long as at 0, in either scalar.
    #[test]
    fn no_short_stretch_is_passed_in_a_crawl() {
        let case = cases::case("butterfly80").unwrap();
        let program = program(&case);
        let time = |lambda: f64, precision: Precision| {
            let machine =
                Machine { tolerance: case.delta, mode: Mode::Paper, lambda, ..Machine::default() };
            let (verdict, _) = judged(&program, &machine, precision, &Events::default()).unwrap();
            assert!(violations(&verdict).is_empty(), "{lambda}: {:?}", violations(&verdict));
            verdict.time
        };
        let none = time(0.0, Precision::F64);
        for lambda in [0.0, 1.0e-12, 1.0e-9, 1.0e-6, 1.0e-3, 0.01, 0.02, 0.03, 0.05, 0.1] {
            for precision in [Precision::F32, Precision::F64] {
                let took = time(lambda, precision);
                assert!(
                    took < 1.03 * none,
                    "lambda {lambda}, {precision:?}: {took} s, {none} at 0"
                );
            }
        }
    }

    /// The default is faster than the paper's mode, and inside the same band.
    #[test]
    fn the_whole_band_is_faster() {
        for name in ["butterfly80", "hexagon_3d"] {
            let case = cases::case(name).unwrap();
            let printed = routines::transitions(&case.points, case.delta, case.lambda);
            let [paper, band] =
                [Mode::Paper, Mode::Band].map(|mode| measure(&case, mode, &printed).unwrap());
            assert!(band.time < paper.time && band.broken.is_empty(), "{name}");
        }
    }
}
