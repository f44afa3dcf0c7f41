//! The rows of a window: every limit, and how near a draft is to it.

use super::course::{mixed, slopes, weights};
use super::vector::{along, dot, minus, square};
use super::way::{Foot, Joint, Line, MOST_LINES};
use super::{Bounds, Draft, PLACES};
use crate::number::Scalar;

/// A joint counts of its own where the band, between the places on both sides of it, may be left by this share of it.
const BUMP: f64 = 0.03;
/// Of a crossing so oblique to its plane nothing is said about where it lies, as a share of the speed.
const OBLIQUE: f64 = 0.05;

/// A bound on one axis: `y` is the share of the limit that is used, with a sign; the sum of `weights` times control points from
/// `first` on, times `scale`, which goes with the distance of the knots to the power of `-degree`.
pub(super) struct AxisRow<'a, S> {
    pub(super) first: usize,
    pub(super) weights: &'a [S],
    pub(super) axis: usize,
    pub(super) scale: S,
    pub(super) degree: u8,
    pub(super) y: S,
}

/// A bound on a length: of `off`, `square` its square, of `weights` times control points from `first` on; by the point that
/// these make the square's half changes as `gradient`, and that as `stiffness`.
pub(super) struct LengthRow<'a, S, const N: usize> {
    pub(super) first: usize,
    pub(super) weights: &'a [S],
    pub(super) gradient: [S; N],
    pub(super) stiffness: [[S; N]; N],
    pub(super) square: S,
    pub(super) limit: S,
    /// As of [`AxisRow`]: 1 if the limit goes with the distance of the knots.
    pub(super) degree: u8,
}

/// What takes the rows.
pub(super) trait Rows<S, const N: usize> {
    fn axis(&mut self, row: &AxisRow<'_, S>);
    fn length(&mut self, row: &LengthRow<'_, S, N>);
}

/// Goes through all rows of a draft. The line that its end is in.
///
/// Cost: bounded by the points of the draft, with up to 64 lines for each of its places.
pub(super) fn rows<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
    used: &[S; K],
    to: &mut impl Rows<S, N>,
) -> usize {
    differences(draft, bounds, to);
    let mut feeds = [S::of(Line::<S, N>::RAPID); K];
    let line = band(draft, bounds, used, &mut feeds, to);
    feed(draft, &feeds, to);
    line
}

/// Velocity, acceleration and jerk of every axis.
fn differences<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
    to: &mut impl Rows<S, N>,
) {
    let (one, two, three) = (S::ONE, S::of(2.0), S::of(3.0));
    let h = draft.h;
    let points = &draft.points[..draft.count];
    for axis in 0..N {
        let limits = &bounds.limits[axis];
        let scales = [
            one / (limits.velocity * h),
            one / (limits.acceleration * h * h),
            one / (limits.jerk * h * h * h),
        ];
        for first in 0..points.len() - 1 {
            let of = |k: usize| points[first + k][axis];
            let mut row = |weights: &[S], degree: u8, sum: S| {
                let scale = scales[usize::from(degree) - 1];
                to.axis(&AxisRow { first, weights, axis, scale, degree, y: sum * scale });
            };
            // The very first are given.
            let change = of(1) - of(0);
            if first + 3 < points.len() {
                let next = of(2) - of(1);
                let last = of(3) - of(2);
                if first > 0 {
                    row(&[-one, one], 1, change);
                    row(&[one, -two, one], 2, next - change);
                }
                row(&[-one, three, -three, one], 3, (last - next) - (next - change));
            }
        }
    }
}

/// Speed along the path, by the hull of the velocity.
fn feed<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    feeds: &[S; K],
    to: &mut impl Rows<S, N>,
) {
    let spans = draft.spans();
    let mut stiffness = [[S::ZERO; N]; N];
    for i in 0..N {
        stiffness[i][i] = S::ONE;
    }
    for first in 2..draft.count - 3 {
        // The change to the next control point counts in the spans from two before it on.
        let feed = (first - 2..=first)
            .filter(|span| *span < spans)
            .fold(S::of(Line::<S, N>::RAPID), |least, span| least.least(feeds[span]));
        if feed >= S::of(Line::<S, N>::RAPID) {
            continue;
        }
        let off = minus(&draft.points[first + 1], &draft.points[first]);
        to.length(&LengthRow {
            first,
            weights: &[-S::ONE, S::ONE],
            gradient: off,
            stiffness,
            square: square(&off),
            limit: feed * draft.h,
            degree: 1,
        });
    }
}

/// The band, at some places of every span and where lines are left for the next; the least feed of every span. The line of the end.
fn band<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
    used: &[S; K],
    feeds: &mut [S; K],
    to: &mut impl Rows<S, N>,
) -> usize {
    let (lines, points) = (bounds.lines, &draft.points);
    let mut line = bounds.line;
    let mut before = mixed(points, &weights(S::ZERO));
    for span in 0..draft.spans() {
        let four = &points[span..span + 4];
        feeds[span] = feeds[span].least(lines[line].feed);
        for place in 1..=PLACES {
            let start = S::from_u32(place as u32 - 1) / S::from_u32(PLACES as u32);
            let share = S::from_u32(place as u32) / S::from_u32(PLACES as u32);
            let at = weights(share);
            let x = mixed(four, &at);
            for _ in 0..MOST_LINES {
                if line + 1 >= lines.len() {
                    break;
                }
                let joint = Joint::new(&lines[line], &lines[line + 1]);
                let passed = joint.passed(&x);
                if !(passed > S::ZERO) {
                    break;
                }
                let step = square(&minus(&x, &before));
                let bump = joint.band * S::of(BUMP);
                if step * joint.turn > bump * bump {
                    let behind = joint.passed(&before).least(S::ZERO);
                    let cross = start + (share - start) * (behind / (behind - passed));
                    crossing(span, four, cross, &joint, &lines[line].direction, used[span], to);
                }
                line += 1;
                feeds[span] = feeds[span].least(lines[line].feed);
            }
            before = x;
            if span + 1 == draft.spans() && place == PLACES {
                break;
            }
            let Foot { off, square } = lines[line].foot(&x);
            let mut stiffness = [[S::ZERO; N]; N];
            across(&lines[line].direction, &mut stiffness);
            let limit = lines[line].band * used[span];
            let weights = &at;
            to.length(&LengthRow {
                first: span,
                weights,
                gradient: off,
                stiffness,
                square,
                limit,
                degree: 0,
            });
        }
    }
    line
}

/// What is across a direction.
fn across<S: Scalar, const N: usize>(direction: &[S; N], to: &mut [[S; N]; N]) {
    for i in 0..N {
        for j in 0..N {
            let own = if i == j { S::ONE } else { S::ZERO };
            to[i][j] = own - direction[i] * direction[j];
        }
    }
}

/// Where the motion crosses the plane in which two lines are equally near it has to be in the bands of both: the square of its
/// distance from either is that from the joint less that along the line. As the motion changes the crossing moves along it.
fn crossing<S: Scalar, const N: usize>(
    span: usize,
    four: &[[S; N]],
    mut share: S,
    joint: &Joint<S, N>,
    direction: &[S; N],
    used: S,
    to: &mut impl Rows<S, N>,
) {
    let mut x = mixed(four, &weights(share));
    let mut slope = mixed(four, &slopes(share));
    let mut speed = dot(&slope, &joint.across);
    let oblique = S::of(OBLIQUE * OBLIQUE) * square(&slope) * square(&joint.across);
    if !(speed * speed > oblique && speed > S::ZERO) {
        return;
    }
    // Nearer to the plane.
    share = (share - joint.passed(&x) / speed).greatest(S::ZERO).least(S::ONE);
    x = mixed(four, &weights(share));
    slope = mixed(four, &slopes(share));
    speed = dot(&slope, &joint.across);
    if !(speed * speed > oblique && speed > S::ZERO) {
        return;
    }
    let off = minus(&x, &joint.at);
    let way = dot(&off, direction).least(S::ZERO);
    let off = along(&off, -way, direction);
    // The point moves by `d - slope (across . d) / speed` when its control points move it by `d`.
    let moved = |v: &[S; N]| along(v, -dot(v, &slope) / speed, &joint.across);
    let mut flat = [[S::ZERO; N]; N];
    across(direction, &mut flat);
    let mut half = [[S::ZERO; N]; N];
    for i in 0..N {
        half[i] = moved(&flat[i]);
    }
    let mut stiffness = [[S::ZERO; N]; N];
    for j in 0..N {
        let column = moved(&core::array::from_fn(|i| half[i][j]));
        for i in 0..N {
            stiffness[i][j] = column[i];
        }
    }
    to.length(&LengthRow {
        first: span,
        weights: &weights(share),
        gradient: moved(&off),
        stiffness,
        square: square(&off),
        limit: joint.band * used,
        degree: 0,
    });
}
