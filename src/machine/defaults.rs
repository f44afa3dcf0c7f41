//! Settings of a machine that names none: of [`Config::new`](super::Config::new), the interface for C and the host tools.

/// Servo cycle, s.
pub const CYCLE: f64 = 1.0e-3;
/// Tolerance, mm.
pub const TOLERANCE: f64 = 0.01;
/// Time by which a new plan is handed over before it takes effect, s.
pub const LEAD: f64 = 0.01;
/// How long a start from rest waits for the look-ahead to fill, s.
pub const START_DELAY: f64 = 0.05;
/// Improvement steps of one planning step.
pub const ITERATIONS: u16 = 40;
/// Smoothing sweeps over a stretch of a run.
pub const SWEEPS: u16 = 8;
