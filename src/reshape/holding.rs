//! Whether a motion stays inside the band between the places that are looked at.

use super::course::Cubic;
use super::vector::{along, minus, square};
use super::way::{Joint, MOST_LINES, are_one, passes};
use super::{Bounds, COUPLED, Draft};
use crate::number::Scalar;

/// Chords of a span.
pub(super) const CHORDS: u32 = 32;
/// Share of the whole band by which a motion may use more between the places that were looked at than there.
const MORE: f64 = 0.008;
/// How much less of the band is used than what was too much.
const LESS: f64 = 0.003;
/// Share of the feed up to which a speed has it.
const FEED: f64 = 1.0005;
/// Share of the band that is left to motions beside the one that is looked at; the rest is for rounding.
const BESIDE: f64 = 0.993;
/// Between lines that turn further, cosine of half the turn, nothing can be said.
const SHARPEST: f64 = 0.13;

/// Whether all of the motion is inside the band, line after line up to that in which it is to end; else `used` is made less where it is not,
/// as a share of the band. How far each span may be left to either side, mm, so that no band is left, is written to `free`.
///
/// The motion is followed by chords, each within the band of one line, or crossing from one line's band into the next's in a place that
/// lies in both: a band is convex. The motion leaves a chord by no more than its acceleration allows.
pub(super) fn narrow<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
    band: S,
    ends: usize,
    [used, free]: [&mut [S; K]; 2],
) -> bool {
    let lines = bounds.lines;
    let mut line = bounds.line;
    let mut before = Cubic::new(&draft.points).at(S::ZERO);
    let mut inside = true;
    for span in 0..draft.spans() {
        let four = &draft.points[span..span + COUPLED];
        let cubic = Cubic::new(four);
        // Second differences are what acceleration is in a span's time squared.
        let bend = |k: usize| {
            let (a, b) = (minus(&four[k + 1], &four[k]), minus(&four[k + 2], &four[k + 1]));
            square(&minus(&b, &a))
        };
        let sagitta = bend(0).greatest(bend(1)).sqrt() / S::from_u32(8 * CHORDS * CHORDS);
        let mut kept = Kept::new(sagitta);
        // Square of the greatest distance from the line that the motion is in.
        let mut farthest = S::ZERO;
        for chord in 1..=CHORDS {
            let share = S::from_u32(chord) / S::from_u32(CHORDS);
            let x = cubic.at(share);
            for _ in 0..MOST_LINES {
                let Some([here, next]) = lines.get(line..line + 2) else { break };
                let joint = Joint::new(here, next);
                let passed = joint.passed(&x);
                if !(passed > S::ZERO) {
                    break;
                }
                if square(&joint.across) < S::of(4.0 * SHARPEST * SHARPEST) {
                    kept.most = S::of(2.0);
                    break;
                }
                let behind = joint.passed(&before).least(S::ZERO);
                let at = along(&before, behind / (behind - passed), &minus(&x, &before));
                farthest = farthest.greatest(here.foot(&at).square);
                kept.see(farthest, here.band);
                farthest = next.foot(&at).square;
                before = at;
                line += 1;
            }
            let off = lines[line].foot(&x).square;
            if off.is_finite() {
                farthest = farthest.greatest(off);
            } else {
                // What is no number is outside.
                kept.most = S::of(2.0);
            }
            before = x;
        }
        kept.see(farthest, lines[line].band);
        let Kept { most, .. } = kept;
        free[span] = kept.free;
        if most > band + S::of(MORE) {
            used[span] = used[span] * (band / most) - S::of(LESS);
            inside = false;
        }
    }
    if !are_one(lines, line, ends, &before) {
        // What lies in the bands of two lines may be in either: a fold of the path would be left out.
        used[draft.spans() - 1] = S::ZERO;
        inside = false;
    }
    inside
}

/// What a span was found to keep.
struct Kept<S> {
    /// How far the motion may lie off a chord, mm.
    sagitta: S,
    /// The greatest share of a band that is used.
    most: S,
    /// How far the motion may be left to either side, mm.
    free: S,
}

impl<S: Scalar> Kept<S> {
    fn new(sagitta: S) -> Self {
        Self { sagitta, most: S::ZERO, free: S::of(1.0e9) }
    }

    /// The square of the greatest distance from a line with this band.
    fn see(&mut self, farthest: S, band: S) {
        let off = farthest.sqrt() + self.sagitta;
        self.most = self.most.greatest(off / band);
        self.free = self.free.least(band * S::of(BESIDE) - off);
    }
}

/// Whether the first span keeps the feed: its speed is bounded by a hull elsewhere, but here that is given with the state in which
/// the motion begins.
pub(super) fn keeps_feed<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
) -> bool {
    let cubic = Cubic::new(&draft.points);
    let mut line = bounds.line;
    (1..=CHORDS).all(|chord| {
        let share = S::from_u32(chord) / S::from_u32(CHORDS);
        line = passes(bounds.lines, line, &cubic.at(share));
        let most = bounds.lines[line].feed * draft.h * S::of(FEED);
        square(&cubic.slope(share)) <= most * most
    })
}
