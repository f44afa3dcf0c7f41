//! The kernel of spline smoothing: what a span of a cubic B-spline sees of it ([`basis`]), the tube it has to
//! stay in ([`tube`]), and the sweeps that smooth it there ([`sweep`]), in a bounded amount of work; and NURBS curves as
//! cubic ones ([`nurbs`]).
//!
//! Runs of short lines are smoothed with it on their way to the machine; the crate `splineway-splines`
//! smooths splines that come as such. A spline here is what its caller keeps: lists of control points
//! and spans.

pub mod banded;
pub mod basis;
pub mod bezier;
pub mod nurbs;
pub mod sweep;
pub mod tube;
