//! A run against its path and the limits of its axes.

use super::run::Run;
use splineway_realtime::{AXES, Sample, Setup};
use splineway_simulator::judge::{Follower, Track};
use splineway_simulator::program::Program;

/// Roundings of an acceleration in its unit, as a share of its limit.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// What was used at most, servo cycle by servo cycle: of a limit of an axis, by the setpoints' velocities, accelerations and the
/// differences of these, less rounding; and of the tolerance.
pub fn shares(program: &Program, setup: &Setup, run: &Run) -> [f64; 2] {
    let [velocity, acceleration, jerk] = setup.limits.map(f64::from);
    let cycle = f64::from(setup.cycle);
    let rounding = ROUNDING * acceleration / (cycle * jerk);
    let (mut used, mut before) = (0.0f64, Sample::EMPTY);
    for sample in &run.samples {
        for axis in 0..AXES {
            let [v, a, last] =
                [sample.velocity[axis], sample.acceleration[axis], before.acceleration[axis]]
                    .map(f64::from);
            used = used.max(v.abs() / velocity).max(a.abs() / acceleration);
            used = used.max((a - last).abs() / (cycle * jerk) - rounding);
        }
        before = *sample;
    }
    [used, follow(program, setup, run).off / f64::from(setup.tolerance)]
}

/// Where a run has come to along the programmed path at its end, mm, and how many of the path's vertices lie behind it, but for one that it rests at.
pub fn end(program: &Program, setup: &Setup, run: &Run) -> (f64, usize) {
    let Followed { track, follower, .. } = follow(program, setup, run);
    let way = follower.way();
    (way, track.passed(way - 2.0 * f64::from(setup.tolerance)))
}

/// A run along its path.
struct Followed {
    track: Track,
    /// Where it has come to.
    follower: Follower,
    /// Greatest distance from the path, mm.
    off: f64,
}

fn follow(program: &Program, setup: &Setup, run: &Run) -> Followed {
    let reach = f64::from(setup.limits[0]) * f64::from(setup.cycle) * 4.0;
    let (mut follower, mut off) = (Follower::default(), 0.0f64);
    let track = Track::new(&program.with_approach());
    for sample in &run.samples {
        let x = sample.position.map(|nm| f64::from(nm) * 1.0e-6);
        off = off.max(follower.look(&track, &x, reach, f64::from(setup.tolerance)).distance);
    }
    Followed { track, follower, off }
}
