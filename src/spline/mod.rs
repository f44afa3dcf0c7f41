//! Cubic B-splines and their smoothing inside a tolerance tube.
//!
//! [`Spline`] is a cubic B-spline of fixed capacity, open (with Bezier end conditions) or closed, in
//! any number of axes. Two ways lower its curvature inside a tube: [`thesis`] is the algorithm of
//! Naseath (2007), chapter 3, as printed; [`bounded`] is for real time: a set number of sweeps, each
//! of which leaves a valid spline, the same that smooth runs of short lines on their way to the machine.

pub(crate) mod basis;
pub mod bounded;
mod bspline;
mod error;
pub(crate) mod sweep;
pub mod thesis;
mod trajectory;
pub(crate) mod tube;

pub use self::bspline::Spline;
pub use self::error::SplineError;
pub use self::trajectory::{Low, Lows, Trajectory};
