//! What a feed word means: the speed along the path that it asks for.
//!
//! The one place where a feed word is read, for lines, arcs and the chords of curves. A block of no length asks for
//! nothing and never comes here.

use super::segment::Segment;
use crate::block::range::in_range;
use crate::block::{BlockError, Feed};
use crate::machine::{Limits, Quantity};
use crate::number::Scalar;
use crate::number::vector::{norm, zero};

/// Most difference of the feeds of lines that become one, relative: what their directions are rounded by.
pub const ROUNDED: f64 = 1.0e-3;
/// The same of short lines in a run: what a speed law would not make anything of between two of its nodes.
pub const BLURRED: f64 = 0.02;

/// Whether two speeds, mm/s, differ by a share of the lesser at most.
pub fn alike<S: Scalar>(a: S, b: S, share: f64) -> bool {
    (a - b).abs() <= a.least(b) * S::of(share)
}

/// Whether the number of a feed word lies in its range.
pub fn check<S: Scalar>(feed: Feed<S>) -> Result<(), BlockError> {
    match feed {
        Feed::PerSecond(feed) => in_range(Quantity::Feed, feed),
        Feed::Duration(seconds) => in_range(Quantity::Duration, seconds),
        Feed::Rapid => Ok(()),
    }
}

/// Least speed along the path that is asked for, mm/s: a long duration of a tiny length gives less.
const LEAST_SPEED: f64 = 1.0e-9;

/// Speed along the path that the feed word asks for, at most what the axes allow on a line, mm/s. The one
/// place where a feed word is read: for lines, arcs, and the chords of a curve that is `whole` mm long.
pub fn path_speed<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    whole: Option<S>,
    feed: Feed<S>,
    limits: &Limits<S, N>,
) -> S {
    let tangent = segment.start_frame().tangent;
    let mut linear = zero::<S, N>();
    let mut most = S::of(Quantity::Feed.range().greatest);
    for (i, axis) in limits.axes().iter().enumerate() {
        if !axis.rotary {
            linear[i] = tangent[i];
        }
        let share = tangent[i].abs();
        if segment.is_line() && share * most > axis.velocity {
            most = axis.velocity / share;
        }
    }
    for motor in limits.motors() {
        let share = motor.of(&tangent).abs();
        if segment.is_line() && share * most > motor.limits.velocity {
            most = motor.limits.velocity / share;
        }
    }
    let wanted = match feed {
        Feed::Rapid => return most,
        Feed::Duration(seconds) => by_duration(whole.unwrap_or(segment.length), seconds),
        Feed::PerSecond(feed) => {
            // G94: the feed is the speed over the linear axes if any of them moves.
            let mut share = norm(&linear);
            if !(share > S::ZERO) {
                share = S::ONE;
            }
            if share * most <= feed { most } else { feed / share }
        }
    };
    wanted.least(most)
}

/// Speed over the linear axes that a feed word asks for, mm/s, where a path may have more or less of them than its block has: the upper half
/// of an `f32`, rounded up by less than 0.8 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinearFeed(u16);

/// Bits of an `f32` that are left out.
const LEFT_OUT: u32 = 16;

impl LinearFeed {
    /// None is asked for.
    pub const NONE: Self = Self(0);

    /// What a feed word asks for on a machine that has both linear and rotary axes.
    pub fn of<S: Scalar, const N: usize>(feed: Feed<S>, limits: &Limits<S, N>) -> Self {
        let axes = limits.axes();
        match feed {
            Feed::PerSecond(feed) if axes.iter().any(|axis| axis.rotary) => {
                let bits = (feed.to_f64() as f32).to_bits();
                Self((bits.saturating_add((1 << LEFT_OUT) - 1) >> LEFT_OUT) as u16)
            }
            _ => Self::NONE,
        }
    }

    /// In mm/s.
    pub fn speed<S: Scalar>(self) -> Option<S> {
        let Self(upper) = self;
        let bits = u32::from(upper) << LEFT_OUT;
        (upper != 0).then(|| S::of(f64::from(f32::from_bits(bits))))
    }

    /// What is asked for where both are.
    pub fn with(self, other: Self) -> Self {
        if self == Self::NONE || other == Self::NONE {
            Self::NONE
        } else {
            Self(self.0.min(other.0))
        }
    }
}

/// Speed of a length, mm, in a time, s, mm/s.
fn by_duration<S: Scalar>(length: S, seconds: S) -> S {
    (length / seconds).greatest(S::of(LEAST_SPEED))
}

/// Speed along the path that the feed word asks for, mm/s, whatever the axes allow; `None` of a rapid.
#[cfg(feature = "outputs")]
pub fn programmed_speed<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    whole: Option<S>,
    feed: Feed<S>,
    limits: &Limits<S, N>,
) -> Option<S> {
    let feed = match feed {
        Feed::Rapid => return None,
        Feed::Duration(seconds) => {
            return Some(by_duration(whole.unwrap_or(segment.length), seconds));
        }
        Feed::PerSecond(feed) => feed,
    };
    if limits.axes().iter().all(|axis| !axis.rotary) {
        return Some(feed);
    }
    let mut linear = segment.start_frame().tangent;
    for (share, axis) in linear.iter_mut().zip(limits.axes()) {
        if axis.rotary {
            *share = S::ZERO;
        }
    }
    let share = norm(&linear);
    // Where the linear axes hardly move, a speed over them is none of the path.
    let least = S::of(LEAST_SHARE);
    Some(if share > least { feed / share } else { feed })
}

/// A path whose linear axes have less of it than this is one of the rotary ones.
#[cfg(feature = "outputs")]
const LEAST_SHARE: f64 = 1.0e-6;
