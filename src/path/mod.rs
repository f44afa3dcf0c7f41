//! Geometry: from blocks to a curvature-continuous path, as a chain of nodes and cells.
//!
//! No file in here knows at what speed the path will be run. Of feed words, limits and the servo cycle it takes three
//! things. [`feed`] makes of a feed word the speed along the path that is asked for, at most what the axes' velocities
//! allow on a line; a cell carries it on. [`cut`] makes lengths of feed, jerk and acceleration: a cell is at most what the
//! feed covers in a quarter of a second, and the first from a standstill what jerk covers while it gets going; a
//! [`run`] lays its knots no farther apart, so that within the band its spline depends on them, too. And a dwell is a
//! number of seconds, cut into parts whose servo cycles can be counted.
//!
//! The path of a block: [`segment`] makes it a checked line or arc ([`helix`]) with exact ends; where it
//! runs [`straight`] on, it becomes one with the line before; [`builder`]
//! holds it as a [`queued`] one (a curve as [`chords`]) until its neighbours are known; [`joint`] decides by
//! geometry how they meet inside the band: as a [`corner`] (two long lines, Guo 2023), within a [`run`]
//! (short lines, which become one smooth spline), or by a [`blend`] (wherever an arc takes part);
//! [`budget`] says who may use which share of the tolerance.
//! [`cut`] says where line and arc are cut into cells. A cell is what lies between two [`node`]s; its shape is fixed by the
//! two (point, tangent, curvature), as a quintic [`hermite`] curve.
//!
//! Numbers that are chosen, not derived, say what they change: the machining time of 16 bench paths of chords and of 39
//! random programs of lines, arcs, curves and dwells, in `f64`, where the number is halved and doubled (an angle: moved
//! by some 8 degrees). "No path by more than" is of one path, else of the sum. The band is kept
//! with any of them, unless they say otherwise.

pub(crate) mod blend;
pub mod budget;
pub(crate) mod builder;
mod check;
mod chords;
pub(crate) mod corner;
pub(crate) mod cut;
#[cfg(feature = "travel")]
mod extent;
pub(crate) mod feed;
pub(crate) mod half;
mod helix;
pub(crate) mod hermite;
pub(crate) mod joint;
mod leg;
pub(crate) mod node;
pub(crate) mod queued;
mod run;
pub(crate) mod segment;
mod straight;
pub(crate) mod swing;
pub(crate) mod transition;
