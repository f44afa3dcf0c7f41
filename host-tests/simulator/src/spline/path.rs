//! A spline of the host.

use splineway_splines::Spline;

/// Control points there is room for.
pub const ROOM: usize = 1024;

/// A spline tool path, mm.
pub type Path = Spline<f64, 3, ROOM>;
