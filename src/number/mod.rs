//! Numbers: the scalar (f32 or f64), the fixed-point coordinate, and small vectors.
//!
//! A machine of 2 m that resolves a nanometre needs 31 bits; an f32 has 24. So *positions* are
//! fixed point ([`Coord`], exact sums, no drift), and the scalar only ever holds *differences* of
//! positions inside one cell of the path, where it is precise to fractions of a nanometre.

mod arc_length;
pub(crate) mod atomic;
mod coord;
mod length;
pub mod list;
pub(crate) mod optional;
pub mod quadrature;
mod range;
mod root;
mod scalar;
pub(crate) use root::cube_root;
pub(crate) mod serial;
pub(crate) mod shared;
pub(crate) mod trig;
pub mod vector;
mod wide;

pub use arc_length::ArcLength;
pub use coord::Coord;
pub(crate) use length::{Interval, Length};
pub use range::{Range, RangeError};
pub use scalar::Scalar;
