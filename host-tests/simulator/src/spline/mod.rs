//! Splines and NURBS as they come: files, curves of any degree, and what they mean exactly.

mod file;
mod nurbs;
mod path;
mod rational;

pub use file::{SplineFile, is_spline, write};
pub use nurbs::Nurbs;
pub use path::{Path, ROOM};
pub use rational::Rational;
