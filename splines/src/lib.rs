//! Cubic B-splines and their smoothing inside a tolerance tube, for splines that come as such: from a CAD
//! system, or a file. `no_std`, allocation-free, without a way to panic.
//!
//! [`Spline`] is a cubic B-spline of fixed capacity, open (with Bezier end conditions) or closed, in
//! any number of axes. Two methods lower its curvature inside a tube: [`thesis`] is the algorithm of
//! Naseath (2007), chapter 3, as printed; [`bounded`] is for real time: a set number of sweeps, each
//! of which leaves a valid spline, the same that smooth runs of short lines on their way to the machine
//! ([`splineway::spline`]). [`Trajectory`] is the thesis's trajectory generator, which compares paths.
//!
//! To run a spline, give its spans ([`Spline::bezier`]) to a planner as cubic blocks.
//!
//! What does not belong here: anything that the core itself needs between a block and a setpoint.
//! File formats are the host's. Rational curves of any degree are the core's ([`splineway::spline::nurbs`]);
//! [`Spline::from_nurbs`] makes splines of them.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod bounded;
mod bspline;
mod convert;
mod error;
pub mod thesis;
mod trajectory;

pub use self::bspline::Spline;
pub use self::error::SplineError;
pub use self::trajectory::{Low, Lows, Trajectory};
