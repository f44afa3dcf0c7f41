//! Input: blocks as a G-code reader or a host program gives them.
//!
//! A [`Block`] is plain data. It is checked as a whole when it is pushed; a block that is refused
//! changes nothing of what was accepted before.

mod arc;
mod error;
pub(crate) mod range;
#[cfg(feature = "outputs")]
mod switch;

pub use arc::centre_from_radius;
pub(crate) use arc::radius_slack;
pub use error::{BlockError, PushError};
#[cfg(feature = "outputs")]
pub use switch::{Offset, Output, Power, Switch, SwitchError, Trigger};

use crate::number::{Coord, Scalar};

/// Finest band that an arc is followed in, mm: a smaller tolerance, down to 0, counts as this
/// along an arc (its ends are exact at any tolerance). What is left of the tolerance to rounding in `f32` is
/// less than a tenth of it.
pub const FINEST_BAND: f64 = 2.0e-4;

/// Sense of an arc, seen against the plane's normal (for XY: from above).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Turn {
    /// G2.
    Clockwise,
    /// G3.
    CounterClockwise,
}

/// What a block does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Motion<S, const N: usize> {
    /// A straight line to `to`.
    Line {
        /// End point, absolute.
        to: [Coord; N],
    },
    /// A circular arc in a plane, a helix if axes outside the plane move too.
    ///
    /// Its ends may be at distances from the centre that differ by 0.005 mm or a thousandth, and never more than
    /// 0.5 mm: the radius then goes from the one to the other in proportion to the angle, and the
    /// centre stays. It turns by the angle from start to end in its sense, however small or near a full turn. An
    /// end on the ray of the start at another radius is refused ([`BlockError::ArcRadius`]): nobody can tell
    /// whether that is no turn or a full one. It is followed within the tolerance, at the finest
    /// within [`FINEST_BAND`].
    Arc {
        /// End point, absolute. Equal to the start within a nanometre in either axis of the plane: one full circle.
        to: [Coord; N],
        /// The plane's two axes, in the order in which a quarter turn takes the first to the
        /// second: G17 is (0, 1), G18 is (2, 0), G19 is (1, 2).
        plane: (usize, usize),
        /// Centre, absolute, in the plane's two axes.
        centre: (Coord, Coord),
        /// Sense.
        turn: Turn,
        /// Full turns beyond the first arrival (P word minus one).
        extra_turns: u16,
    },
    /// A cubic curve by its Bezier points, of which the first is the start (G5; a span of a spline:
    /// `splineway_splines::Spline::bezier`). It is followed within the tolerance, which must be at least 1e-4 mm;
    /// where two join with the same tangent the motion goes on.
    Cubic {
        /// The two Bezier points between, absolute.
        controls: [[Coord; N]; 2],
        /// End point, absolute.
        to: [Coord; N],
    },
    /// Stand still for a time, s, a quarter of a servo cycle at least (0: not at all). Always comes with an exact stop.
    Dwell {
        /// Duration, s.
        seconds: S,
    },
    /// Rest exactly at the end of the block before, and say so: for one servo cycle the setpoint has
    /// [`Activity::Event`](crate::Activity::Event) and this block's tag. There the machine switches
    /// spindle, coolant or tool, in order with the motion. It takes two servo cycles.
    Event {
        /// Whether to rest there, as after a stop, until the operator resumes (M0, M1, M6).
        pause: bool,
    },
}

/// How fast a block runs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "wire", derive(serde::Serialize, serde::Deserialize))]
pub enum Feed<S> {
    /// Units per time (G94), here per second. It is the speed over the linear axes; if only rotary
    /// axes move, degrees per second over those.
    PerSecond(S),
    /// Inverse time (G93): the block takes this many seconds at an override of 100 %, or longer where the axes, a corner, or the way
    /// from and to rest ask for it. One without length takes none.
    Duration(S),
    /// As fast as the axes allow (G0).
    Rapid,
}

impl<S: Scalar> Feed<S> {
    /// The same in another scalar, rounded to the nearest.
    pub fn to_scalar<T: Scalar>(self) -> Feed<T> {
        let other = |x: S| T::of(x.to_f64());
        match self {
            Self::PerSecond(feed) => Feed::PerSecond(other(feed)),
            Self::Duration(seconds) => Feed::Duration(other(seconds)),
            Self::Rapid => Feed::Rapid,
        }
    }
}

impl<S: Scalar, const N: usize> Motion<S, N> {
    /// The same motion for other axes and in another scalar: `point` gives the points, `axis` the axes of a plane;
    /// `None` if either has none.
    pub fn mapped<T: Scalar, const M: usize>(
        &self,
        point: impl Fn(&[Coord; N]) -> [Coord; M],
        axis: impl Fn(usize) -> Option<usize>,
    ) -> Option<Motion<T, M>> {
        Some(match self {
            Self::Line { to } => Motion::Line { to: point(to) },
            Self::Arc { to, plane, centre, turn, extra_turns } => Motion::Arc {
                to: point(to),
                plane: (axis(plane.0)?, axis(plane.1)?),
                centre: *centre,
                turn: *turn,
                extra_turns: *extra_turns,
            },
            Self::Cubic { controls: [first, second], to } => {
                Motion::Cubic { controls: [point(first), point(second)], to: point(to) }
            }
            Self::Dwell { seconds } => Motion::Dwell { seconds: T::of(seconds.to_f64()) },
            Self::Event { pause } => Motion::Event { pause: *pause },
        })
    }
}

/// One block of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Block<S, const N: usize> {
    /// What it does.
    pub motion: Motion<S, N>,
    /// How fast.
    pub feed: Feed<S>,
    /// Greatest distance from the programmed path, mm; `None` takes the machine's. 0 means exact
    /// stops at corners, and arcs within [`FINEST_BAND`].
    pub tolerance: Option<S>,
    /// Whether to come to rest exactly on the end point (G61, G61.1, G9).
    pub exact_stop: bool,
    /// The caller's mark (a line number); it comes back with the setpoints. Lines that run on straight are
    /// one to the planner, but keep their tags where they take a servo cycle at their feed and a
    /// thirty-second of the length over which that is reached; of shorter ones, and of short lines in a run
    /// that are made one within a share of the tolerance, it is that of the last, which may follow a long one. Where the feed changes on a straight
    /// stretch, its lines are a run, too: of those that are made one, each that is longer than an eighth of that length is shown from where it begins, as
    /// long as the path hardly turns there.
    pub tag: u32,
}

impl<S: Scalar, const N: usize> Block<S, N> {
    /// A line with a feed, mm/s.
    pub const fn line(to: [Coord; N], feed: S, tag: u32) -> Self {
        Self {
            motion: Motion::Line { to },
            feed: Feed::PerSecond(feed),
            tolerance: None,
            exact_stop: false,
            tag,
        }
    }

    /// A cubic curve with a feed, mm/s.
    pub const fn cubic(controls: [[Coord; N]; 2], to: [Coord; N], feed: S, tag: u32) -> Self {
        Self { motion: Motion::Cubic { controls, to }, ..Self::line(to, feed, tag) }
    }

    /// A line as fast as the axes allow.
    pub const fn rapid(to: [Coord; N], tag: u32) -> Self {
        Self {
            motion: Motion::Line { to },
            feed: Feed::Rapid,
            tolerance: None,
            exact_stop: false,
            tag,
        }
    }

    /// A dwell, s.
    pub const fn dwell(seconds: S, tag: u32) -> Self {
        Self::standing(Motion::Dwell { seconds }, tag)
    }

    /// An event: see [`Motion::Event`].
    pub const fn event(tag: u32) -> Self {
        Self::standing(Motion::Event { pause: false }, tag)
    }

    /// An event after which the machine rests until it is resumed: see [`Motion::Event`].
    pub const fn pause(tag: u32) -> Self {
        Self::standing(Motion::Event { pause: true }, tag)
    }

    const fn standing(motion: Motion<S, N>, tag: u32) -> Self {
        Self { motion, feed: Feed::Rapid, tolerance: None, exact_stop: true, tag }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_keeps_what_it_is_for_other_axes() {
        let at = |x: i64| Coord::from_raw(x);
        let arc = Motion::<f64, 3>::Arc {
            to: [at(1), at(2), at(3)],
            plane: (2, 0),
            centre: (at(4), at(5)),
            turn: Turn::Clockwise,
            extra_turns: 2,
        };
        let pick = |p: &[Coord; 3]| [p[2], p[0]];
        let find = |axis: usize| [2, 0].iter().position(|&own| own == axis);
        let mapped: Option<Motion<f32, 2>> = arc.mapped(pick, find);
        let wanted = Motion::Arc {
            to: [at(3), at(1)],
            plane: (0, 1),
            centre: (at(4), at(5)),
            turn: Turn::Clockwise,
            extra_turns: 2,
        };
        assert_eq!(mapped, Some(wanted));
        assert_eq!(arc.mapped::<f32, 2>(pick, |_| None), None);
    }

    #[test]
    fn a_feed_is_rounded_to_the_nearest() {
        assert_eq!(Feed::PerSecond(0.1f64).to_scalar::<f32>(), Feed::PerSecond(0.1f32));
        assert_eq!(Feed::Duration(0.25f32).to_scalar::<f64>(), Feed::Duration(0.25));
        assert_eq!(Feed::<f32>::Rapid.to_scalar::<f64>(), Feed::Rapid);
    }
}
