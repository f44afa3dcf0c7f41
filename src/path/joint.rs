//! How two segments meet: at rest, passed, rounded or blended, and what that takes of them.

use super::blend::Blend;
use super::budget;
use super::corner::{Corner, Legs};
use super::cut::rest_cell;
use super::half::{End, Half, Spot};
use super::node::{Frame, Node};
use super::queued::{Entrance, Joint, QueuedBlock};
use super::segment::{Segment, Shape};
use super::swing;
use crate::machine::{Config, CornerMode, Ramp};
use crate::number::vector::{dot, norm};
use crate::number::{Coord, Length, Scalar};
use core::array::from_fn;

/// A corner between lines this many times as long as Guo's transition, with a turn whose cosine is
/// less than this, is faster by itself than as a part of a run. (Half or twice: no path by more than 1.5 %.)
const LONE_ROOM: f64 = 5.0;
/// See [`LONE_ROOM`]. (0 or 0.4: no path by more than 0.4 %.)
const LONE_COSINE: f64 = 0.2;
/// A turn whose cosine is less than this (100 degrees) is never a part of a run. (90 or 110 degrees: no path by more
/// than 0.8 %.)
const BACK_COSINE: f64 = -0.17;
/// Ratio of the feeds of two lines from which on it matters where the one changes to the other. (1.25 or 2: nothing.)
const FEED_RATIO: f64 = 1.5;
/// Share of the band by which that place gives way. (Half or twice: no path by more than 0.3 %.)
const STOP_SHARE: f64 = 0.25;
/// The same at the end of a curve, whatever the feeds. (Half or twice: nothing.)
const CURVE_STOP_SHARE: f64 = 1.0 / 16.0;
/// Reach of a blend, as a share of the tolerance and of the length over which the feed is reached, below both of which
/// it is a stop. (Half or twice: no path by more than 0.4 %.)
const TINY_REACH: f64 = 1.0 / 16.0;
/// See [`TINY_REACH`]. (Half or twice: nothing.)
const TINY_RAMP: f64 = 1.0 / 8.0;
/// Share of a line that a run which goes on along it keeps for itself. (Half or twice: no path by more than 0.5 %.)
const RUN_SHARE: i64 = 4;
/// Least reach of a joint: where there is less room than for a line, a stop is faster.
const LEAST_REACH: Length = Length::from_raw(500_000);
/// Share of a line that is left between two joints, and of a joint's reach: a cell much shorter than its neighbours is
/// slow to plan.
const BODY_SHARE: i64 = 8;
/// Share of a joint's reach up to which what is left of the line is rounding.
const ROUNDING_BODY: i64 = 1024;
/// Least length of a straight stretch beside a transition of the paper, as a part of its reach: what is shorter, or is
/// rounding, is passed with its outer cell, which leaves the printed curve by 1e-3 of e for it at most.
const PAPER_BODY: i64 = 16;
/// Most of a line that is kept to get going on it. (Half or twice: no path by more than 0.1 %.)
const RAMP_SHARE: f64 = 0.125;
/// Turn, rad, up to which a joint is simply passed, however tight the tolerance.
const STRAIGHT: f64 = 1.0e-6;
/// Turn, rad, up to which a joint may be passed if the tolerance allows. (Half or twice: nothing, for the tolerance is
/// what decides.)
const SLIGHT_TURN: f64 = 0.4;

/// Tolerance, mm, above which a line may be passed on to where it goes on though the two differ in direction by the rounding of
/// the program: pieces that lie less than [`budget`]'s least off one line.
pub const LEAST_SLIGHT: f64 = 1.0e-5;

/// Length, mm, from which on a line may go on from another before its end is known: over the length in which its feed
/// is reached, what turn rounding leaves between them costs nothing.
pub fn goes_on_from<S: Scalar, const N: usize>(
    line: &Segment<S, N>,
    feed: S,
    config: &Config<S, N>,
) -> S {
    Ramp::new(&config.limits, &line.start_frame().tangent).length(feed)
}

/// The node between two segments that is simply passed. Between lines it lies on the circle
/// through the three points; the jump between two curves is halved.
pub fn mean_node<S: Scalar, const N: usize>(
    at: [Coord; N],
    frame_in: &Frame<S, N>,
    frame_out: &Frame<S, N>,
    BentLengths { before: l0, after: l1 }: BentLengths<S>,
) -> Node<S, N> {
    let half = S::of(0.5);
    let sum: [S; N] = from_fn(|i| frame_in.tangent[i] * l1 + frame_out.tangent[i] * l0);
    let size = norm(&sum);
    let per = S::of(2.0) / (l0 + l1);
    let tangent: [S; N] = from_fn(|i| sum[i] / size);
    let bend: [S; N] = from_fn(|i| {
        (frame_out.tangent[i] - frame_in.tangent[i]) * per
            + (frame_in.curvature[i] + frame_out.curvature[i]) * half
    });
    // Curvature is at right angles to the tangent.
    let along = dot(&bend, &tangent);
    Node { at, tangent, curvature: from_fn(|i| bend[i] - along * tangent[i]) }
}

/// Lengths of the cells on either side of a joint that is simply passed, mm.
#[derive(Clone, Copy)]
pub struct BentLengths<S> {
    pub before: S,
    pub after: S,
}

impl<S: Scalar> BentLengths<S> {
    /// Of segments of so many mm: a long line next to a short one bends only over its end.
    pub fn new(before: S, after: S) -> Self {
        let three = S::of(3.0);
        Self { before: before.least(after * three), after: after.least(before * three) }
    }
}

/// Whether the common point of two segments can simply be passed with a mean direction.
///
/// With the directions weighted so that the curve is the circle through the three points, the
/// node turns away from either chord by turn l / (l0 + l1) and has the curvature 2 turn / (l0 +
/// l1). The quintic of a cell answers a unit of direction at one end with at most 0.196 l and a
/// unit of curvature with at most 0.0173 l^2, so it leaves its chord by no more than
/// 0.231 turn l^2 / (l0 + l1) for each of its ends.
pub fn passes<S: Scalar, const N: usize>(
    a: &Segment<S, N>,
    b: &Segment<S, N>,
    (frame_in, frame_out): (&Frame<S, N>, &Frame<S, N>),
    tolerance: S,
    mode: CornerMode<S>,
) -> bool {
    let gap: [S; N] = from_fn(|i| frame_out.tangent[i] - frame_in.tangent[i]);
    let turn = norm(&gap);
    let bend: [S; N] = from_fn(|i| frame_out.curvature[i] - frame_in.curvature[i]);
    let bend = norm(&bend);
    let BentLengths { before: l0, after: l1 } = BentLengths::new(a.length, b.length);
    let longest = l0.greatest(l1);
    let straight = S::of(STRAIGHT);
    if turn <= straight && bend * longest <= straight {
        return true;
    }
    let slight = match mode {
        CornerMode::Band => S::of(SLIGHT_TURN),
        CornerMode::Paper { .. } => return false,
    };
    // A jump in curvature (an arc that starts or ends) must be a small one.
    if turn > slight || bend * longest > S::of(0.01) {
        return false;
    }
    let off = (turn * S::of(0.24) / (l0 + l1) + bend * S::of(0.02)) * longest * longest;
    off <= tolerance * S::of(budget::PASSED)
}

/// How corners between two blocks are rounded: those between the chords of a curve, which nobody has
/// programmed, always in the band.
pub fn corner_mode<S: Scalar, const N: usize>(
    before: &QueuedBlock<S, N>,
    after: &QueuedBlock<S, N>,
    mode: CornerMode<S>,
) -> CornerMode<S> {
    if before.chord && after.chord { CornerMode::Band } else { mode }
}

/// Whether a stop between two blocks costs less than what lets the motion pass: where the feed changes, the place
/// of the change gives way by a share of the band; the slower feed is reached in less.
#[inline(never)]
fn stop_is_shorter<S: Scalar, const N: usize>(
    before: &QueuedBlock<S, N>,
    after: &QueuedBlock<S, N>,
    direction: &[S; N],
    config: &Config<S, N>,
) -> bool {
    let slower = before.feed.least(after.feed);
    let alike = before.feed.greatest(after.feed) <= slower * S::of(FEED_RATIO);
    // To go on smoothly a curve must keep its direction at its end, which alone may make it longer.
    let share = match before.chord != after.chord {
        _ if !alike => STOP_SHARE,
        true => CURVE_STOP_SHARE,
        false => return false,
    };
    let band = before.tolerance.least(after.tolerance);
    Ramp::new(&config.limits, direction).length(slower) < band * S::of(share)
}

/// How two blocks meet, and what length the joint would like of either.
pub fn joint<S: Scalar, const N: usize>(
    before: &QueuedBlock<S, N>,
    after: &QueuedBlock<S, N>,
    config: &Config<S, N>,
) -> (Joint, Length) {
    let (Some(a), Some(b)) = (&before.segment, &after.segment) else {
        return (Joint::Stop, Length::ZERO);
    };
    if before.alone != after.alone {
        return (Joint::Stop, Length::ZERO);
    }
    let mode = corner_mode(before, after, config.corner);
    let tolerance = before.band_with(after);
    let (frame_in, frame_out) = (a.end_frame(), b.start_frame());
    let corner = Corner::new(&frame_in.tangent, &frame_out.tangent);
    let shorter = a.length.least(b.length);
    // Where the limits change there is to be a node, which within a run there need not be.
    let runs = before.limits == after.limits;
    let lines = runs && a.is_line() && b.is_line() && mode == CornerMode::Band;
    let stops = || stop_is_shorter(before, after, &frame_in.tangent, config);
    // Of two lines that could be parts of a run.
    let run = || if stops() { Joint::Stop } else { Joint::Run };
    if before.goes_on && passes(a, b, (&frame_in, &frame_out), tolerance, mode) {
        return (Joint::Through, Length::ZERO);
    }
    // A spike smaller than the tolerance is ironed out.
    let spike = lines && shorter < tolerance * S::of(budget::SPIKE);
    if corner.cos_turn() < S::of(CornerMode::<S>::STOP_COSINE) {
        return (if spike { run() } else { Joint::Stop }, Length::ZERO);
    }
    // The paper's corners are corners however slight: each takes its part of the legs.
    let paper = a.is_line() && b.is_line() && matches!(mode, CornerMode::Paper { .. });
    let straight = corner.cos_turn() > S::ZERO && !((lines || paper) && tolerance > S::ZERO);
    if straight && passes(a, b, (&frame_in, &frame_out), tolerance, mode) {
        return (Joint::Through, Length::ZERO);
    }
    if !(tolerance > S::ZERO) {
        return (Joint::Stop, Length::ZERO);
    }
    match (&a.shape, &b.shape, mode) {
        (Shape::Line(_), Shape::Line(_), CornerMode::Paper { .. }) => (Joint::Corner, Length::ZERO),
        (Shape::Line(_), Shape::Line(_), CornerMode::Band) => {
            if before.chord != after.chord && stops() {
                return (Joint::Stop, Length::ZERO);
            }
            let most = shorter * S::of(1.0 / LONE_ROOM);
            let slight = corner.cos_turn() > S::of(LONE_COSINE);
            let short = corner.full_band_length(tolerance, most) >= most;
            let back = corner.cos_turn() < S::of(BACK_COSINE) && !spike;
            if runs && !back && (slight || short) {
                return (run(), Length::ZERO);
            }
            let band = before.corner_band_with(after);
            (Joint::Corner, Length::from_mm(swing::longest_reach(&corner, band, shorter)))
        }
        _ if stops() => (Joint::Stop, Length::ZERO),
        _ => {
            let bound = |segment: &Segment<S, N>| {
                segment.length.least(segment.longest_angle() * S::of(3.0))
            };
            let most = bound(a).least(bound(b)) * S::of(0.5);
            (Joint::Blend, Length::from_mm(Blend::longest_reach(a, b, tolerance, most)))
        }
    }
}

/// What a joint takes of either segment.
#[derive(Clone, Copy, Debug)]
pub struct Taken<S> {
    /// Length of the segment before it; none or less if there is no room for the joint.
    pub before: Length,
    /// Length of the segment behind it.
    pub after: Length,
    /// Its shape, if it is a corner between lines.
    pub half: Option<Half<S>>,
}

impl<S: Scalar> Taken<S> {
    /// There is no room.
    pub const NONE: Self = Self { before: Length::ZERO, after: Length::ZERO, half: None };
}

/// What the joint behind the front block takes of either segment. `last`: whether the motion rests at the end of the next.
#[inline(never)]
pub fn reach<S: Scalar, const N: usize>(
    (item, segment, entrance): (&QueuedBlock<S, N>, &Segment<S, N>, &Entrance<S>),
    (next, ahead, last): (&QueuedBlock<S, N>, &Segment<S, N>, bool),
    joint: Joint,
    config: &Config<S, N>,
) -> Taken<S> {
    let mut left = segment.exact_length - entrance.taken;
    let mode = corner_mode(item, next, config.corner);
    let paper = match (joint, mode) {
        (Joint::Corner, CornerMode::Paper { lambda }) => Some(lambda),
        _ => None,
    };
    if paper.is_none() && entrance.is_rest() {
        // A transition from rest on gets going in cells as long as its shape asks for: where the feed is
        // reached in less, there must be a stretch before it that is cut for that.
        let ramp = Ramp::new(&config.limits, &segment.start_frame().tangent).length(item.feed);
        left -= Length::from_mm(ramp.least(segment.length * S::of(RAMP_SHARE)));
    }
    if entrance.joint == Joint::Through {
        // A node that is passed is bent: the bend must end before the next transition begins.
        left -= segment.exact_length / BODY_SHARE;
    }
    if entrance.joint == Joint::Run {
        left -= segment.exact_length / RUN_SHARE;
    }
    let corner = Corner::new(&segment.end_frame().tangent, &ahead.start_frame().tangent);
    let (tolerance, band) = (item.band_with(next), item.corner_band_with(next));
    if let Some(lambda) = paper {
        // There is a transition before this one from which to keep away: routine 1 has none.
        let follows = matches!(entrance.joint, Joint::Corner | Joint::Blend);
        let gap = if follows { lambda } else { S::ZERO };
        let before = left.to_mm::<S>() * (S::ONE - gap);
        let last = last && !next.chord;
        let legs = Legs { before, after: ahead.length, last };
        let starts = entrance.is_rest();
        let rests = [
            starts.then(|| rest_cell(segment, item.feed, &config.limits)),
            last.then(|| rest_cell(ahead, next.feed, &config.limits)),
        ];
        return paper_reach(&corner, band.delta, legs, [left, ahead.exact_length], rests);
    }
    let length = shared_reach(item, next, ahead, left);
    if length < LEAST_REACH {
        return Taken::NONE;
    }
    // A blend that a tiny neighbour leaves next to no room is passed so slowly that a stop costs no more, and
    // ties what comes before and behind it to its direction.
    if joint == Joint::Blend {
        let reach = length.to_mm::<S>();
        let feed = item.feed.least(next.feed);
        let ramp = Ramp::new(&config.limits, &segment.end_frame().tangent).length(feed);
        if reach < tolerance * S::of(TINY_REACH) && reach < ramp * S::of(TINY_RAMP) {
            return Taken::NONE;
        }
    }
    let shape = (joint == Joint::Corner).then(|| swing::half(&corner, band, length.to_mm()));
    let length = shape.map_or(length, |half| Length::from_mm(half.reach()).min(length));
    let length = with_body(length, left, entrance.joint == Joint::Through);
    // Within rounding the band has room for more.
    let half = shape.map(|half| half.scaled(length.to_mm::<S>() / half.reach()));
    Taken { before: length, after: length, half }
}

/// What a corner of the paper takes of its legs, of which there are `[left, ahead]`. Where the motion rests at the other end
/// of a leg, `rests` has the length of the first cell from there, mm.
///
/// The shape is the printed one. A stretch of a leg beside it that is rounding, or too short to be a cell of its own (a
/// small lambda), is passed with its outer cell: as a cell, it would be passed in a crawl.
fn paper_reach<S: Scalar>(
    corner: &Corner<S>,
    tolerance: S,
    legs: Legs<S>,
    [left, ahead]: [Length; 2],
    rests: [Option<S>; 2],
) -> Taken<S> {
    let half = corner.paper_half(corner.paper_edge(tolerance, legs));
    let reach = Length::from_mm(half.reach());
    if reach < LEAST_REACH {
        return Taken::NONE;
    }
    let whole = |leg: Length| if leg - reach <= reach / PAPER_BODY { leg } else { reach };
    // What is left behind it is the next corner's.
    let (before, after) = (whole(left), if legs.last { whole(ahead) } else { reach });
    let outer = half.length(Spot::at(0), Spot::at(1), 0);
    let end = |taken: Length, leg: Length, rest: Option<S>| {
        End::new((taken - reach).to_mm(), outer, rest.filter(|_| taken == leg))
    };
    let ends = [end(before, left, rests[0]), end(after, ahead, rests[1])];
    Taken { before, after, half: Some(half.with_ends(ends)) }
}

/// What a joint may have of either segment, if `left` is free of the first: shared by need, so that what the next joint
/// does not want of the next segment is free for this one.
fn shared_reach<S: Scalar, const N: usize>(
    item: &QueuedBlock<S, N>,
    next: &QueuedBlock<S, N>,
    ahead: &Segment<S, N>,
    left: Length,
) -> Length {
    let next_want =
        if next.stop_after || next.joint == Joint::Run { Length::ZERO } else { next.want };
    let free = if next.joint == Joint::Run {
        ahead.exact_length - ahead.exact_length / RUN_SHARE
    } else if next_want == Length::ZERO {
        // The next segment ends in its own last point: it must keep a body.
        ahead.exact_length - ahead.exact_length / BODY_SHARE
    } else {
        (ahead.exact_length - next_want).max(ahead.exact_length / 2)
    };
    item.want.min(left).min(free)
}

/// What to take of `left` so that either nothing of the body is left, or a stretch long enough to be
/// a cell of its own.
fn with_body(wanted: Length, left: Length, bent: bool) -> Length {
    let body = left - wanted;
    if body <= wanted / ROUNDING_BODY {
        return left;
    }
    let least = wanted / BODY_SHARE;
    if !bent && body < least { wanted - (least - body) } else { wanted }
}
