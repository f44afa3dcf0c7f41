//! Reshaping: shape and speed of an agreed motion, improved together inside the band.
//!
//! The planner fixes the path's shape first and then its speed. The least time needs both at once: the best motion uses what the
//! band leaves and two axes at their limits nearly always. Here a window of the motion is a uniform cubic B-spline in time, so
//! that every limit of an axis is a bound on differences of control points: velocity by their hull, acceleration and jerk
//! exactly. The first three control points are the state in which the window begins, the last three that of the agreed motion at
//! a later time: what comes behind the window is run as agreed. That time is made as late as the limits and the band allow
//! (`window`): by Newton's method on a barrier (`barrier`, `rows`) whose system is banded, since every
//! control point is coupled with three before it (`banded`, `model`). Where the agreed motion ends within the window, its
//! end is kept and the knots are brought closer together. Which line of the path the agreed motion is in when is found
//! beforehand (`placing`).
//!
//! Whatever is found is checked between the places that were looked at before it is offered (`holding`); what is not
//! faster than agreed, or cannot be shown to stay inside the band, is not offered. So it can be left out, or cut short, at
//! any moment.
//!
//! What does not belong here: where the agreed motion comes from, and how motion is handed to the interrupt.

mod banded;
mod barrier;
mod course;
mod holding;
mod model;
mod placing;
mod rows;
#[cfg(test)]
mod tests;
mod vector;
mod way;
mod window;

pub use course::State;
pub use placing::Places;
pub use way::Line;
pub use window::{Improving, Refused, Reshaped, Window};

use crate::AxisLimits;
use crate::number::Scalar;

/// Control points of a span, which are those that are coupled with each other.
const COUPLED: usize = 4;
/// Places of a span at which the band is looked at.
pub(crate) const PLACES: usize = 4;

/// What goes on as agreed, in time from the window's start.
pub trait Agreed<S, const N: usize> {
    /// State at a time, s, with the jerk and the rate of that, mm/s3 and mm/s4; at its end, and behind it, it rests.
    fn at(&self, time: S) -> Onward<S, N>;
    /// The line that it is in then, of those that are given, by [`Places`]; one that there is not, where that is not known.
    fn line(&self, time: S) -> usize;
    /// The latest time, s, not behind another, at which it can be joined: the beginning of one of its pieces, or not so shortly before
    /// the end of one that what is left of it would be nothing but rounding.
    fn can_be_joined(&self, time: S) -> S;
    /// When it ends, s.
    fn end(&self) -> S;
}

/// A state of the agreed motion, and how it goes on.
#[derive(Clone, Copy, Debug)]
pub struct Onward<S, const N: usize> {
    /// Position, velocity, acceleration.
    pub state: State<S, N>,
    /// mm/s3.
    pub jerk: [S; N],
    /// mm/s4.
    pub snap: [S; N],
}

/// What a motion has to keep.
#[derive(Clone, Copy, Debug)]
pub struct Bounds<'a, S, const N: usize> {
    /// Of the axes.
    pub limits: &'a [AxisLimits<S>; N],
    /// The path, in order, about the window's origin: as far as the window may come.
    pub lines: &'a [Line<S, N>],
    /// The line in which the window begins.
    pub line: usize,
}

/// A motion that is being looked for.
#[derive(Clone, Debug)]
struct Draft<S, const N: usize, const K: usize> {
    points: [[S; N]; K],
    /// Control points in use.
    count: usize,
    /// Time between knots, s.
    h: S,
    /// Time at which the agreed motion has the state in which it ends, s.
    joins: S,
}

impl<S: Scalar, const N: usize, const K: usize> Draft<S, N, K> {
    const NONE: Self = Self { points: [[S::ZERO; N]; K], count: 3, h: S::ZERO, joins: S::ZERO };

    fn spans(&self) -> usize {
        self.count - 3
    }
}
