//! Where the tolerance narrows from a line of a run to the next: the room that the spline has beside the wider one.
//!
//! Beside its middle a line has all of its tolerance on either side. But beyond its end the nearest of it is its last point, which is
//! the other line's, too: there the lesser tolerance holds. What a spline may be beside the wider line is thus a strip that ends
//! with the line, and a disc around its last point. Spline and line are compared at places ([`super::trial_span`]), and what lies between
//! two of them is bounded by the line between those: so the places must lie in a part of that which is convex. It is the disc, a little
//! smaller, and the wedge that opens from it, whose sides touch the disc and meet the strip's end where that leaves the whole disc:
//! a spline that is compared with a place `left` mm before the end may be off it by [`SHARE`] of the lesser tolerance and [`OPENING`] of
//! `left`.
//!
//! Where the run begins or ends at rest in that point the spline goes through it, however narrow the other line is, and to the
//! last it needs no room. What it may stray by from the last place before the point grows with the distance from either; within the
//! eighth of what is left, four times of which it is at most near the point, it remains before the end.

use super::polyline::Vertex;
use crate::number::{Length, Scalar};
use crate::path::budget;
use crate::path::leg::Leg;
use crate::spline::tube::Slip;

/// Cosine of the half angle of the wedge, of 14.5 degrees.
const SHARE: f64 = 0.968;
/// Its sine, of half of what is left: over the other half the place that is compared with may slip.
const OPENING: f64 = 0.125;

/// What of the lesser tolerance is left, mm, and where along the path.
#[derive(Clone, Copy)]
struct Narrow<S> {
    s: Length,
    radius: S,
    /// Whether the line is the wider one.
    wider: bool,
    /// Whether the spline goes through the very point.
    exact: bool,
}

impl<S: Scalar> Narrow<S> {
    /// Where a line with `own` tolerance meets one with `other`; `None` if that is as wide.
    fn new(s: Length, own: S, other: S, exact: bool) -> Option<Self> {
        let radius = || own.least(other) * S::of(budget::RUN * SHARE);
        (other != own).then(|| Self { s, radius: radius(), wider: other < own, exact })
    }
}

/// The room beside a line.
#[derive(Clone, Copy)]
pub struct Room<S> {
    before: Option<Narrow<S>>,
    behind: Option<Narrow<S>>,
    /// How far along the line a place of the path may lie beside the same of the line, mm.
    error: S,
}

impl<S: Scalar> Room<S> {
    /// Of a line between two vertices; `behind` is the tolerance of the line behind it, mm, `last` whether that is no part of the
    /// run.
    pub fn new<const N: usize>(
        start: &Vertex<S, N>,
        end: &Vertex<S, N>,
        (behind, last): (S, bool),
    ) -> Self {
        let Leg { tolerance, error, .. } = end.leg;
        Self {
            before: Narrow::new(start.s, tolerance, start.leg.tolerance, start.s == Length::ZERO),
            behind: Narrow::new(end.s, tolerance, behind, last),
            error,
        }
    }

    /// What a spline may be off the line at an arc length, mm, of a `radius` where nothing is narrow.
    pub fn radius(&self, s: Length, radius: S) -> S {
        let most = |narrow: &Option<Narrow<S>>| {
            let narrow = narrow.as_ref().filter(|narrow| !(narrow.exact && narrow.s == s))?;
            Some(narrow.radius + self.apart(narrow, s) * S::of(OPENING))
        };
        let least = |radius: S, most: Option<S>| most.map_or(radius, |most| radius.least(most));
        least(least(radius, most(&self.before)), most(&self.behind))
    }

    /// How far along the line the place may lie that is compared with, of a slip where nothing is narrow.
    pub fn slip(&self, s: Length, Slip { back, ahead }: Slip<S>) -> Slip<S> {
        let half = |narrow: &Narrow<S>| self.apart(narrow, s) * S::of(0.5);
        let before = self.before.as_ref().filter(|narrow| narrow.wider).map(half);
        let behind = self.behind.as_ref().filter(|narrow| narrow.wider).map(half);
        Slip {
            back: before.map_or(back, |half| back.greatest(-half)),
            ahead: behind.map_or(ahead, |half| ahead.least(half)),
        }
    }

    fn apart(&self, narrow: &Narrow<S>, s: Length) -> S {
        // Next to a point that the spline goes through there would be no room at all.
        let error = if narrow.exact { S::ZERO } else { self.error };
        ((narrow.s - s).abs().to_mm::<S>() - error).greatest(S::ZERO)
    }
}
