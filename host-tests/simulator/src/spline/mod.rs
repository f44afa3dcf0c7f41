//! Splines and NURBS as they come: files, curves of any degree, and what they mean exactly.

mod convert;
mod file;
mod interpolate;
mod nurbs;
mod path;
mod rational;

pub use convert::convert;
pub use file::{SplineFile, is_spline, read, write};
pub use interpolate::interpolate;
pub use nurbs::Nurbs;
pub use path::{Path, ROOM};
pub use rational::Rational;
