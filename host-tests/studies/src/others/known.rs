//! What others have measured, and what takes too long to be computed again for a table.

/// A time on a bench path.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Name of the path.
    pub path: &'static str,
    /// Tolerance, mm.
    pub tolerance: f64,
    /// s.
    pub time: f64,
    /// Greatest deviation over the tolerance, and greatest jerk of an axis over its limit.
    pub ratios: [f64; 2],
}

const fn known(path: &'static str, tolerance: f64, time: f64, ratios: [f64; 2]) -> Known {
    Known { path, tolerance, time, ratios }
}

/// LinuxCNC 2.10 with its jerk-limited planner: master of 2026-08-22, `G64 P` with the tolerance and naive CAM merging at the same,
/// 1 kHz, limits as in the path's first line. The program itself was run, and its setpoints were judged, by others than us, on
/// paths of these names; where a ratio is greater than 1 it has not kept what the others keep.
pub const LINUXCNC: [Known; 8] = [
    known("zigzag90", 0.05, 5.49, [0.35, 1.10]),
    known("zigzag90", 0.01, 3.59, [0.05, 1.00]),
    known("star", 0.05, 2.93, [0.01, 1.00]),
    known("star", 0.01, 2.93, [0.05, 1.00]),
    known("butterfly80", 0.05, 13.10, [0.99, 1.16]),
    known("butterfly80", 0.01, 12.51, [1.00, 1.57]),
    known("butterfly2000", 0.05, 16.73, [1.01, 1.22]),
    known("butterfly2000", 0.01, 18.16, [1.08, 1.41]),
];

/// Any motion in the band, as `splineway limit` finds it in minutes ([`crate::anymotion`]).
pub const ANY_MOTION: [Known; 7] = [
    known("zigzag90", 0.05, 2.773, [1.0, 1.0]),
    known("zigzag90", 0.01, 3.144, [1.0, 1.0]),
    known("star", 0.05, 2.700, [1.0, 1.0]),
    known("star", 0.01, 2.720, [1.0, 1.0]),
    known("butterfly80", 0.05, 4.205, [1.0, 1.0]),
    known("butterfly80", 0.01, 6.279, [1.0, 1.0]),
    known("butterfly2000", 0.05, 3.382, [1.0, 1.0]),
];

/// The one of a path, by its name (`NAME_TOLERANCE`).
pub fn of<'a>(all: &'a [Known], name: &str) -> Option<&'a Known> {
    all.iter().find(|known| name == format!("{}_{}", known.path, known.tolerance))
}
