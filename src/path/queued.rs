//! Blocks that wait for their neighbours, checked and with their geometry.

use super::budget;
#[cfg(feature = "travel")]
use super::extent::Extent;
use super::feed::{self, LinearFeed};
use super::joint;
use super::leg::Leg;
use super::node::{Event, Programmed};
use super::segment::Segment;
use super::swing::CornerBand;
use crate::block::range::{check_coordinate, check_coordinates, in_range};
use crate::block::{Block, BlockError, Feed, Motion};
use crate::machine::{Config, Quantity, SetNumber};
use crate::number::{Coord, Length, Range, Scalar};

/// How two segments meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// At rest.
    Stop,
    /// Through the common point: tangents (and curvatures) agree.
    Through,
    /// B-spline corner between lines.
    Corner,
    /// Quintic blend where an arc takes part.
    Blend,
    /// Within a run of lines that becomes one spline.
    Run,
}

/// Servo cycles that an event takes: it is reported in the first that sees it, and whenever it begins
/// within a cycle, one does.
const EVENT_CYCLES: f64 = 1.5;

/// A block that waits for its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct QueuedBlock<S, const N: usize> {
    /// `None` for a standstill.
    pub segment: Option<Segment<S, N>>,
    pub dwell: S,
    pub event: Option<Event>,
    pub feed: S,
    /// The same over the linear axes, on a machine that has both.
    pub linear: LinearFeed,
    pub rapid: bool,
    /// Which limits bound it.
    pub limits: SetNumber,
    /// Greatest distance of the motion from it, mm: as programmed, or what the limits of travel leave of that.
    pub tolerance: S,
    /// As programmed, mm: a corner keeps this on its inner side, which no limit of travel cuts off.
    #[cfg(feature = "travel")]
    pub inner: S,
    pub stop_after: bool,
    /// Whether what follows the setpoints must have come to rest before it begins and when it has ended, at stops: it has no
    /// tolerance for that.
    pub alone: bool,
    /// Whether it is a chord of a curve.
    pub chord: bool,
    /// Whether the next runs straight on from it: a line that has become too long to wait for its end.
    pub goes_on: bool,
    /// Of a line made of several, the tag of the last.
    pub tag: u32,
    /// Marks of the pieces before the last ([`super::straight`]).
    pub marks: u16,
    /// Greatest distance of the ends of its pieces from it, mm.
    pub error: S,
    /// Joint to the next block, once that is known.
    pub joint: Joint,
    /// Length the joint would like of either segment.
    pub want: Length,
}

/// How the front block is entered: of those behind it that is not known yet.
#[derive(Clone, Copy, Debug)]
pub struct Entrance<S> {
    /// The joint.
    pub joint: Joint,
    /// Length of the segment before it, mm.
    pub length_before: S,
    /// Tolerance of that, mm.
    pub tolerance_before: Option<S>,
    /// Length that it has taken of the front segment.
    pub taken: Length,
}

impl<S: Scalar> Entrance<S> {
    /// From rest, at its start.
    pub const REST: Self = Self::rest(None);

    /// From rest, at its start, behind a segment of a tolerance, if there is one, mm.
    pub const fn rest(tolerance_before: Option<S>) -> Self {
        Self { joint: Joint::Stop, length_before: S::ZERO, tolerance_before, taken: Length::ZERO }
    }

    /// Whether it is that.
    pub fn is_rest(&self) -> bool {
        self.joint == Joint::Stop && self.taken == Length::ZERO
    }
}

impl<S: Scalar, const N: usize> QueuedBlock<S, N> {
    /// Whether it moves, and does not stand before.
    pub fn only_moves(&self) -> bool {
        self.segment.is_some() && !(self.dwell > S::ZERO)
    }

    /// What it asks of its cells.
    pub fn programmed(&self) -> Programmed<S> {
        let Self { feed, linear, rapid, limits, tag, .. } = *self;
        Programmed { feed, linear, rapid, limits, tag }
    }

    /// What it asks of a run that it is a part of.
    pub fn leg(&self) -> Leg<S> {
        Leg { programmed: self.programmed(), tolerance: self.tolerance, error: self.error }
    }

    /// Whether a block goes on as this one does: no stop between them, and alike in all but direction.
    pub fn runs_on(&self, next: &Self) -> bool {
        !self.stop_after
            && self.rapid == next.rapid
            && self.limits == next.limits
            && self.chord == next.chord
            && self.alone == next.alone
            && self.tolerance == next.tolerance
            && self.inner() == next.inner()
            && (self.rapid || feed::alike(self.feed, next.feed, feed::ROUNDED))
    }

    /// Whether the next runs straight on from it, and is so long that the joint between them, which is simply passed, can
    /// be cut whatever it will become.
    pub fn is_gone_on_from(&self, next: &Self, config: &Config<S, N>) -> bool {
        let long = |segment: &Segment<S, N>| {
            segment.length >= joint::goes_on_from(segment, next.feed, config)
        };
        self.goes_on && self.joint == Joint::Through && next.segment.as_ref().is_some_and(long)
    }

    /// The band of the joint with a neighbour, mm: what the lines that each was made of have left of its tolerance,
    /// and the narrower of the two.
    pub fn band_with(&self, neighbour: &Self) -> S {
        (self.tolerance - self.error).least(neighbour.tolerance - neighbour.error)
    }

    /// The tolerance of the inner side of a corner, mm.
    #[cfg(feature = "travel")]
    fn inner(&self) -> S {
        self.inner
    }

    /// The same without limits of travel.
    #[cfg(not(feature = "travel"))]
    fn inner(&self) -> S {
        self.tolerance
    }

    /// The band of the corner with a neighbour, and whether it may use both sides of it.
    pub fn corner_band_with(&self, neighbour: &Self) -> CornerBand<S> {
        let inner = |block: &Self| block.inner() - block.error;
        let delta = inner(self).least(inner(neighbour));
        CornerBand { delta, outside: delta <= self.band_with(neighbour) }
    }

    /// A block that starts at `from`, checked; `None` if there is nothing to do for it. `whole` is the length
    /// of the curve that it is a part of, mm.
    #[inline(never)]
    pub fn new(
        from: [Coord; N],
        block: &Block<S, N>,
        whole: Option<S>,
        config: &Config<S, N>,
    ) -> Result<Option<Self>, BlockError> {
        let asked = budget::tolerance(block, config);
        in_range(Quantity::Tolerance, asked)?;
        feed::check(block.feed)?;
        // A chord's is what its curve has left.
        let tolerance = if whole.is_some() { asked } else { budget::of_setpoints(asked, config) };
        let alone = whole.is_none() && config.settle() > S::ZERO && asked <= config.reserve();
        let mut item = Self {
            segment: None,
            dwell: S::ZERO,
            event: None,
            feed: S::ONE,
            linear: LinearFeed::of(block.feed, &config.limits),
            rapid: block.feed == Feed::Rapid,
            limits: SetNumber::FIRST,
            tolerance,
            #[cfg(feature = "travel")]
            inner: tolerance,
            stop_after: block.exact_stop,
            alone,
            chord: whole.is_some(),
            goes_on: false,
            tag: block.tag,
            marks: 0,
            error: S::ZERO,
            joint: Joint::Stop,
            want: Length::ZERO,
        };
        let segment = match block.motion {
            Motion::Dwell { seconds } => {
                in_range(Quantity::Dwell, seconds)?;
                item.dwell = seconds;
                item.stop_after = true;
                return Ok((seconds > S::ZERO).then_some(item));
            }
            Motion::Event { pause } => {
                item.dwell = config.cycle * S::of(EVENT_CYCLES);
                item.event = Some(if pause { Event::Pause } else { Event::Pass });
                item.stop_after = true;
                return Ok(Some(item));
            }
            // A curve comes as chords; as a whole it is taken for the line to its end.
            Motion::Line { to } | Motion::Cubic { to, .. } => {
                check_coordinates(&to)?;
                Segment::line(from, to)
            }
            Motion::Arc { to, plane, centre, turn, extra_turns } => {
                check_coordinates(&to)?;
                check_coordinate(plane.0, centre.0)?;
                check_coordinate(plane.1, centre.1)?;
                Some(Segment::arc(from, to, plane, centre, turn, extra_turns)?)
            }
        };
        let Some(segment) = segment else { return Ok(None) };
        let tangent = segment.start_frame().tangent;
        if alone && !(segment.is_line() && config.keeps_straight(&tangent, segment.length)) {
            let quantity = Quantity::Tolerance;
            let least = config.reserve().to_f64();
            let error = Range { least, ..quantity.range() }.refused(asked.to_f64());
            return Err(BlockError::OutOfRange { quantity, error });
        }
        // A curve has been looked at as a whole.
        #[cfg(feature = "travel")]
        if whole.is_none() {
            let extent = Extent::of_segment(&segment);
            item.tolerance = extent.within(&config.travel, &from, tolerance)?;
        }
        item.feed = feed::path_speed(&segment, whole, block.feed, &config.limits);
        item.segment = Some(segment);
        Ok(Some(item))
    }
}
