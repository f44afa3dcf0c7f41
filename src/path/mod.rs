//! Geometry: from blocks to a curvature-continuous path, as a chain of nodes and cells.
//!
//! No file in here knows time: speeds appear only as the programmed feed that a cell carries on.
//!
//! The way of a block: [`segment`] makes it a checked line or arc ([`helix`]) with exact ends; [`builder`]
//! holds it as an [`item`] (a curve as [`chords`]) until its neighbours are known; [`joint`] decides by
//! geometry how they meet inside the band: as a [`corner`] (two long lines, Guo 2023), within a [`run`]
//! (short lines, which become one smooth spline), or by a [`blend`] (wherever an arc takes part);
//! [`cut`] says where line and arc are cut into cells. A cell is what lies between two [`node`]s; its shape is fixed by the
//! two (point, tangent, curvature), as a quintic [`hermite`] curve.

pub(crate) mod blend;
pub(crate) mod builder;
mod check;
mod chords;
pub(crate) mod corner;
pub(crate) mod cut;
mod helix;
pub(crate) mod hermite;
pub(crate) mod item;
mod joint;
pub(crate) mod node;
mod run;
pub(crate) mod segment;
pub(crate) mod swing;
pub(crate) mod transition;
