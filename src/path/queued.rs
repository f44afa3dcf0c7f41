//! Blocks that wait for their neighbours, checked and with their geometry.

use super::budget;
use super::node::{Event, Programmed};
use super::run::Leg;
use super::segment::Segment;
use crate::block::{Block, BlockError, Feed, Field, Motion};
use crate::machine::{Config, Limits};
use crate::number::vector::{norm, zero};
use crate::number::{Coord, Length, Scalar};

/// Most difference of the feeds of lines that become one, relative: rounding of their directions.
const FEED_SLACK: f64 = 1.0e-3;

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
    pub rapid: bool,
    pub tolerance: S,
    pub stop_after: bool,
    /// Whether it is a chord of a curve.
    pub chord: bool,
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
    /// Joint through which it was entered.
    pub entered: Joint,
    /// Length of the segment before that joint, mm.
    pub length_before: S,
    /// Length that joint has taken.
    pub taken: Length,
}

impl<S: Scalar, const N: usize> QueuedBlock<S, N> {
    /// What it asks of its cells.
    pub fn programmed(&self) -> Programmed<S> {
        Programmed { feed: self.feed, rapid: self.rapid, tag: self.tag }
    }

    /// What it asks of a run that it is a part of.
    pub fn leg(&self) -> Leg<S> {
        Leg { programmed: self.programmed(), tolerance: self.tolerance, error: self.error }
    }

    /// Whether a block goes on as this one does: no stop between them, and alike in all but direction.
    pub fn runs_on(&self, next: &Self) -> bool {
        let (a, b) = (self.feed, next.feed);
        !self.stop_after
            && self.rapid == next.rapid
            && self.chord == next.chord
            && self.tolerance == next.tolerance
            && (self.rapid || (a - b).abs() <= a.least(b) * S::of(FEED_SLACK))
    }

    /// The band of the joint with a neighbour, mm: what the lines that each was made of have left of its tolerance,
    /// and the narrower of the two.
    pub fn band_with(&self, neighbour: &Self) -> S {
        (self.tolerance - self.error).least(neighbour.tolerance - neighbour.error)
    }

    /// A block that starts at `from`, checked; `None` if there is nothing to do for it. `whole` is the length
    /// of the curve that it is a part of, mm.
    pub fn new(
        from: [Coord; N],
        block: &Block<S, N>,
        whole: Option<S>,
        config: &Config<S, N>,
    ) -> Result<Option<Self>, BlockError> {
        let tolerance = budget::tolerance(block, config);
        in_range(Field::Tolerance, tolerance, 0.0, 1.0e3)?;
        match block.feed {
            Feed::PerSecond(feed) => in_range(Field::Feed, feed, 1.0e-9, 1.0e6)?,
            Feed::Duration(seconds) => in_range(Field::Duration, seconds, 1.0e-6, 1.0e6)?,
            Feed::Rapid => {}
        }
        let mut item = Self {
            segment: None,
            dwell: S::ZERO,
            event: None,
            feed: S::ONE,
            rapid: block.feed == Feed::Rapid,
            tolerance,
            stop_after: block.exact_stop,
            chord: whole.is_some(),
            tag: block.tag,
            marks: 0,
            error: S::ZERO,
            joint: Joint::Stop,
            want: Length::ZERO,
            entered: Joint::Stop,
            length_before: S::ZERO,
            taken: Length::ZERO,
        };
        let segment = match block.motion {
            Motion::Dwell { seconds } => {
                in_range(Field::Dwell, seconds, 0.0, 1.0e6)?;
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
        item.feed = path_speed(&segment, whole, block.feed, &config.limits);
        item.segment = Some(segment);
        Ok(Some(item))
    }
}

pub fn in_range<S: Scalar>(
    field: Field,
    value: S,
    least: f64,
    greatest: f64,
) -> Result<(), BlockError> {
    if value >= S::of(least) && value <= S::of(greatest) {
        Ok(())
    } else {
        Err(BlockError::OutOfRange { field, value: value.to_f64(), least, greatest })
    }
}

/// Every coordinate of a point within [`Coord::LIMIT_MM`].
pub fn check_coordinates<const N: usize>(to: &[Coord; N]) -> Result<(), BlockError> {
    to.iter().enumerate().try_for_each(|(axis, coord)| check_coordinate(axis, *coord))
}

fn check_coordinate(axis: usize, coord: Coord) -> Result<(), BlockError> {
    const LIMIT: i64 = Coord::LIMIT_MM as i64 * Coord::PER_MM;
    if coord.raw() > LIMIT || coord.raw() < -LIMIT {
        return Err(BlockError::Coordinate { axis, value: coord.to_mm() });
    }
    Ok(())
}

/// Least speed along the path that is asked for, mm/s: a long duration of a tiny length gives less.
const LEAST_SPEED: f64 = 1.0e-9;

/// Speed along the path that the feed word asks for, at most what the axes allow on a line, mm/s. The one
/// place where a feed word is read: for lines, arcs, and the chords of a curve that is `whole` mm long.
fn path_speed<S: Scalar, const N: usize>(
    segment: &Segment<S, N>,
    whole: Option<S>,
    feed: Feed<S>,
    limits: &Limits<S, N>,
) -> S {
    let tangent = segment.start_frame().tangent;
    let mut linear = zero::<S, N>();
    let mut most = S::of(1.0e6);
    for (i, axis) in limits.axes().iter().enumerate() {
        if !axis.rotary {
            linear[i] = tangent[i];
        }
        let share = tangent[i].abs();
        if segment.is_line() && share * most > axis.velocity {
            most = axis.velocity / share;
        }
    }
    let wanted = match feed {
        Feed::Rapid => return most,
        Feed::Duration(seconds) => {
            (whole.unwrap_or(segment.length) / seconds).greatest(S::of(LEAST_SPEED))
        }
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
