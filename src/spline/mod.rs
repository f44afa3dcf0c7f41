//! Cubic B-splines and their smoothing inside a tube.

pub(crate) mod basis;
pub(crate) mod sweep;
pub(crate) mod tube;
