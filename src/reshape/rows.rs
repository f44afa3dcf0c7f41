//! The rows of a window: every limit, and how near a draft is to it.

use super::course::{Cubic, weights};
use super::vector::{along, dot, minus, square};
use super::way::{Foot, Joint, Line, MOST_LINES, turn};
use super::{Bounds, COUPLED, Draft, PLACES};
use crate::number::Scalar;

/// A joint counts of its own where the band, between the places on both sides of it, may be left by this share of it.
const BUMP: f64 = 0.03;
/// Of a crossing so oblique to its plane nothing is said about where it lies, as a share of the speed.
const OBLIQUE: f64 = 0.05;

/// Bounds on velocity, acceleration and jerk of every axis: the first, second and third difference of control points from `span` on.
pub(super) struct AxisRows<'a, S, const N: usize> {
    pub(super) span: usize,
    /// Shares of the limits that are used, with a sign.
    pub(super) shares: [[S; 3]; N],
    /// What a difference is to be multiplied by for that: goes with the distance of the knots to the power of -1, -2 and -3.
    pub(super) scales: &'a [[S; 3]; N],
}

/// A bound on the distance from a line, at the same place of every span.
pub(super) struct PlaceRow<'a, S, const N: usize> {
    /// 0 is the first behind the span's start.
    pub(super) place: usize,
    pub(super) foot: &'a Foot<S, N>,
    pub(super) direction: &'a [S; N],
    /// 1 over the limit's square.
    pub(super) inverse: S,
}

/// How the length of what `weights` times control points from `first` on make changes with them.
pub(super) struct LengthRow<S, const N: usize, const W: usize> {
    pub(super) first: usize,
    pub(super) weights: [S; W],
    /// Of the length's square, the half.
    pub(super) gradient: [S; N],
    /// Lower half.
    pub(super) stiffness: [[S; N]; N],
    /// Whether the limit goes with the distance of the knots.
    pub(super) stretches: bool,
}

/// What takes the rows.
pub(super) trait Rows<S, const N: usize> {
    fn axes(&mut self, rows: &AxisRows<'_, S, N>);
    fn place(&mut self, row: &PlaceRow<'_, S, N>);
    /// All places of a span have been given; at its end the last has none.
    fn places_end(&mut self, span: usize);
    /// A bound on a length: the square of it, and 1 over that of the limit.
    fn length<const W: usize>(
        &mut self,
        square: S,
        inverse: S,
        row: impl FnOnce() -> LengthRow<S, N, W>,
    );
}

/// How far the rows of a draft have been gone through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk<S> {
    span: usize,
    /// The line that the place before the next is in.
    pub(super) line: usize,
    feeds: Feeds<S>,
}

impl<S: Scalar> Walk<S> {
    pub(super) fn new<const N: usize, const K: usize>(
        draft: &Draft<S, N, K>,
        bounds: &Bounds<'_, S, N>,
    ) -> Self {
        Self { span: 0, line: bounds.line, feeds: Feeds::new(draft.h) }
    }

    /// Whether all have been.
    pub(super) fn is_done<const N: usize, const K: usize>(&self, draft: &Draft<S, N, K>) -> bool {
        self.span >= draft.spans()
    }
}

/// Goes through all rows of a draft. The line that its end is in.
#[cfg(test)]
pub(super) fn rows<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
    used: &[S; K],
    to: &mut impl Rows<S, N>,
) -> usize {
    let mut walk = Walk::new(draft, bounds);
    go_on(draft, bounds, used, (&mut walk, K), to);
    walk.line
}

/// Goes on through the rows of a draft by at most so many spans.
///
/// Cost: bounded by these, with up to 64 lines for each of its places.
pub(super) fn go_on<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
    used: &[S; K],
    (walk, most): (&mut Walk<S>, usize),
    to: &mut impl Rows<S, N>,
) {
    let lines = bounds.lines;
    let scales = scales(bounds, draft.h);
    // The very first differences are given, but for the third.
    let first = scales.map(|[_, _, third]| [S::ZERO, S::ZERO, third]);
    let part = S::ONE / S::from_u32(PLACES as u32);
    let Walk { span: begins, mut line, mut feeds } = *walk;
    // The end of the span before, to the last bit.
    let mut before = match begins.checked_sub(1) {
        Some(last) => Cubic::new(&draft.points[last..last + COUPLED]).at(S::ONE),
        None => Cubic::new(&draft.points).at(S::ZERO),
    };
    let ends = draft.spans().min(begins + most);
    for span in begins..ends {
        let four = &draft.points[span..span + COUPLED];
        differences(four, span, if span > 0 { &scales } else { &first }, to);
        let cubic = Cubic::new(four);
        feeds.next(lines[line].feed);
        let mut inverse = band(&lines[line], used[span]);
        for place in 0..PLACES {
            let start = part * S::from_u32(place as u32);
            let share = part * S::from_u32(place as u32 + 1);
            let x = cubic.at(share);
            for _ in 0..MOST_LINES {
                let Some([here, next]) = lines.get(line..line + 2) else { break };
                let joint = Joint::new(here, next);
                let passed = joint.passed(&x);
                if !(passed > S::ZERO) {
                    break;
                }
                let turn = turn(here, next);
                let band_there = here.band.least(next.band);
                let bump = band_there * S::of(BUMP);
                if square(&minus(&x, &before)) * turn > bump * bump {
                    let behind = joint.passed(&before).least(S::ZERO);
                    let cross = start + part * (behind / (behind - passed));
                    let limit = band_there * used[span];
                    crossing(span, &cubic, cross, (&joint, &here.direction), limit, to);
                }
                line += 1;
                feeds.also(next.feed);
                inverse = band(next, used[span]);
            }
            before = x;
            // The end is given.
            if span + 1 < draft.spans() || place + 1 < PLACES {
                let Line { direction, .. } = &lines[line];
                to.place(&PlaceRow { place, foot: &lines[line].foot(&x), direction, inverse });
            }
        }
        to.places_end(span);
        if span > 1 {
            feeds.row(&draft.points, span, to);
        }
    }
    *walk = Walk { span: ends, line, feeds };
}

/// What differences are to be multiplied by, axis by axis.
fn scales<S: Scalar, const N: usize>(bounds: &Bounds<'_, S, N>, h: S) -> [[S; 3]; N] {
    core::array::from_fn(|i| {
        let limits = &bounds.limits[i];
        let first = S::ONE / h;
        let second = first * first;
        [first / limits.velocity, second / limits.acceleration, second * first / limits.jerk]
    })
}

/// 1 over the square of the limit in the band of a line.
fn band<S: Scalar, const N: usize>(line: &Line<S, N>, used: S) -> S {
    let limit = line.band * used;
    S::ONE / (limit * limit)
}

/// Velocity, acceleration and jerk in a span.
fn differences<S: Scalar, const N: usize>(
    four: &[[S; N]],
    span: usize,
    scales: &[[S; 3]; N],
    to: &mut impl Rows<S, N>,
) {
    let shares = core::array::from_fn(|i| {
        let [a, b, c, d] = [four[0][i], four[1][i], four[2][i], four[3][i]];
        let (first, next, last) = (b - a, c - b, d - c);
        let bend = next - first;
        let third = (last - next) - bend;
        [first * scales[i][0], bend * scales[i][1], third * scales[i][2]]
    });
    to.axes(&AxisRows { span, shares, scales });
}

/// Speed along the path, by the hull of the velocity.
#[derive(Clone, Copy, Debug)]
struct Feeds<S> {
    /// The least of this span and of the two before it.
    last: [S; 3],
    h: S,
}

impl<S: Scalar> Feeds<S> {
    fn new(h: S) -> Self {
        Self { last: [S::of(Line::<S, 1>::RAPID); 3], h }
    }

    /// The next span begins in a line of this feed.
    fn next(&mut self, feed: S) {
        let [_, before, last] = self.last;
        self.last = [before, last, S::of(Line::<S, 1>::RAPID).least(feed)];
    }

    /// The span is in a line of this feed too.
    fn also(&mut self, feed: S) {
        self.last[2] = self.last[2].least(feed);
    }

    /// The change to the next control point counts in the spans from two before it on.
    fn row<const N: usize>(&self, points: &[[S; N]], first: usize, to: &mut impl Rows<S, N>) {
        let feed = self.last[0].least(self.last[1]).least(self.last[2]);
        if feed >= S::of(Line::<S, N>::RAPID) {
            return;
        }
        let off = minus(&points[first + 1], &points[first]);
        let limit = feed * self.h;
        to.length(square(&off), S::ONE / (limit * limit), || {
            let mut stiffness = [[S::ZERO; N]; N];
            for i in 0..N {
                stiffness[i][i] = S::ONE;
            }
            let weights = [-S::ONE, S::ONE];
            LengthRow { first, weights, gradient: off, stiffness, stretches: true }
        });
    }
}

/// Where the motion crosses the plane in which two lines are equally near it has to be in the bands of both: the square of its
/// distance from either is that from the joint less that along the line. As the motion changes the crossing moves along it.
fn crossing<S: Scalar, const N: usize>(
    span: usize,
    cubic: &Cubic<S, N>,
    share: S,
    (joint, direction): (&Joint<'_, S, N>, &[S; N]),
    limit: S,
    to: &mut impl Rows<S, N>,
) {
    let slope = cubic.slope(share);
    let speed = dot(&slope, &joint.across);
    let oblique = S::of(OBLIQUE * OBLIQUE) * square(&slope) * square(&joint.across);
    if !(speed * speed > oblique && speed > S::ZERO) {
        return;
    }
    // On to the plane, as straight as it is near.
    let per = S::ONE / speed;
    let x = cubic.at(share);
    let ahead = -joint.passed(&x) * per;
    let off = minus(&along(&x, ahead, &slope), joint.at);
    let way = dot(&off, direction).least(S::ZERO);
    let off = along(&off, -way, direction);
    to.length(square(&off), S::ONE / (limit * limit), || {
        // The point moves by `d - slope (across . d) / speed` when its control points move it by `d`: of both sides of what is across
        // the line that leaves itself, less a product with `across` on either side.
        let way = dot(&slope, direction);
        let flat = along(&slope, -way, direction).map(|x| x * per);
        let half = along(&flat, S::of(-0.5) * per * dot(&flat, &slope), &joint.across);
        let mut stiffness = [[S::ZERO; N]; N];
        for i in 0..N {
            for j in 0..=i {
                stiffness[i][j] = -direction[i] * direction[j]
                    - half[i] * joint.across[j]
                    - joint.across[i] * half[j];
            }
            stiffness[i][i] += S::ONE;
        }
        let gradient = along(&off, -dot(&off, &slope) * per, &joint.across);
        let weights = weights((share + ahead).greatest(S::ZERO).least(S::ONE));
        LengthRow { first: span, weights, gradient, stiffness, stretches: false }
    });
}
