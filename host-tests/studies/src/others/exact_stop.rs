//! Exact stop: seven phases of constant jerk from rest to rest on every line.

use super::line_path::{LinePath, plus, times};
use super::ramp::{End, Phases, leg};
use crate::anymotion::motion::Motion;
use anyhow::{Context, Result};

/// The motion, whose path is the programmed one. What every machine can do (G61.1 in LinuxCNC's words), and the yardstick: what is
/// slower has cornered for nothing. The cost is a bisection for every line.
///
/// # Errors
/// None for lines of some length.
pub fn motion(path: &LinePath) -> Result<Motion> {
    let mut motion = Motion::resting(&path.points[0]);
    for k in 0..path.lines() {
        let phases = leg([End::default(); 2], path.lengths[k], path.feeds[k], path.limit(k));
        let phases = phases.context("a line has no length")?;
        along(&mut motion, &path.points[k], &path.directions[k], End::default(), &phases);
    }
    Ok(motion)
}

/// Adds phases along a direction from a point on.
pub(super) fn along(
    motion: &mut Motion,
    from: &[f64],
    direction: &[f64],
    start: End,
    phases: &Phases,
) {
    let (mut x, mut v, mut a) = (0.0, start.speed, start.rise);
    for &(t, j) in phases {
        x += t * (v + t * (a / 2.0 + t * j / 6.0));
        v += t * (a + t * j / 2.0);
        a += t * j;
        motion.advance(t, [&plus(from, x, direction), &times(v, direction), &times(a, direction)]);
    }
}
