//! Whether a motion stays inside the band between the places that are looked at.

use super::course::{mixed, weights};
use super::vector::{minus, square};
use super::way::{Joint, MOST_LINES};
use super::{Bounds, Draft};
use crate::number::Scalar;

/// Chords of a span.
pub(super) const CHORDS: u32 = 32;
/// Share of the whole band that a motion uses at most.
const WHOLE: f64 = 0.998;
/// How much less of the band is used than what was too much.
const LESS: f64 = 0.003;
/// Between lines that turn further, cosine of half the turn, nothing can be said.
const SHARPEST: f64 = 0.13;

/// Whether all of the motion is inside the band, line after line up to that in which it is to end; else `used` is made less where it is not,
/// as a share of the band.
///
/// The motion is followed by chords, each within the band of one line, or crossing from one line's band into the next's in a place that
/// lies in both: a band is convex. The motion leaves a chord by no more than its acceleration allows.
pub(super) fn narrow<S: Scalar, const N: usize, const K: usize>(
    draft: &Draft<S, N, K>,
    bounds: &Bounds<'_, S, N>,
    band: S,
    ends: usize,
    used: &mut [S; K],
) -> bool {
    let lines = bounds.lines;
    let mut line = bounds.line;
    let mut before = mixed(&draft.points, &weights(S::ZERO));
    let mut inside = true;
    for span in 0..draft.spans() {
        let four = &draft.points[span..span + 4];
        // Second differences are what acceleration is in a span's time squared.
        let bend = |k: usize| {
            let (a, b) = (minus(&four[k + 1], &four[k]), minus(&four[k + 2], &four[k + 1]));
            square(&minus(&b, &a))
        };
        let sagitta = bend(0).greatest(bend(1)).sqrt() / S::from_u32(8 * CHORDS * CHORDS);
        let mut most = S::ZERO;
        for chord in 1..=CHORDS {
            let share = S::from_u32(chord) / S::from_u32(CHORDS);
            let x = mixed(four, &weights(share));
            for _ in 0..MOST_LINES {
                if line + 1 >= lines.len() {
                    break;
                }
                let joint = Joint::new(&lines[line], &lines[line + 1]);
                let passed = joint.passed(&x);
                if !(passed > S::ZERO) {
                    break;
                }
                if square(&joint.across) < S::of(4.0 * SHARPEST * SHARPEST) {
                    most = S::of(2.0);
                    break;
                }
                let behind = joint.passed(&before).least(S::ZERO);
                let cross = behind / (behind - passed);
                let at = core::array::from_fn(|i| before[i] + cross * (x[i] - before[i]));
                for line in &lines[line..line + 2] {
                    most = most.greatest((line.foot(&at).square.sqrt() + sagitta) / line.band);
                }
                before = at;
                line += 1;
            }
            let off = lines[line].foot(&x).square.sqrt() + sagitta;
            // What is no number is outside.
            let off = off / lines[line].band;
            most = if off.is_finite() { most.greatest(off) } else { S::of(2.0) };
            before = x;
        }
        if most > S::of(WHOLE).greatest(band) {
            used[span] = used[span] * (band / most) - S::of(LESS);
            inside = false;
        }
    }
    if line != ends {
        // What lies in the bands of two lines may be in either: a fold of the path would be left out.
        used[draft.spans() - 1] = S::ZERO;
        inside = false;
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AxisLimits;
    use crate::reshape::Line;
    use crate::reshape::vector::along;

    const BAND: f64 = 0.05;
    const K: usize = 8;

    fn line(from: [f64; 2], direction: [f64; 2], length: f64) -> Line<f64, 2> {
        Line { from, direction, length, band: BAND, feed: 100.0 }
    }

    /// Whether a motion holds, and how much of the band is used then in each span.
    fn holds(points: &[[f64; 2]], lines: &[Line<f64, 2>], ends: usize) -> (bool, [f64; K]) {
        let limits = [AxisLimits::linear(100.0, 1000.0, 10_000.0); 2];
        let bounds = Bounds { limits: &limits, lines, line: 0 };
        let mut draft = Draft { points: [[0.0; 2]; K], count: points.len(), h: 0.008, joins: 0.0 };
        draft.points[..points.len()].copy_from_slice(points);
        let mut used = [0.99; K];
        (narrow(&draft, &bounds, 0.99, ends, &mut used), used)
    }

    #[test]
    fn the_band_is_looked_at_up_to_the_very_end() {
        let lines = [line([0.0; 2], [1.0, 0.0], 10.0)];
        let mut points: [[f64; 2]; K] = core::array::from_fn(|k| [k as f64 * 0.5, 0.0]);
        // In the end a sixth of the last point counts, a chord before it a tenth less of that.
        for (end, inside) in [(0.99, true), (1.05, false)] {
            points[K - 1][1] = 6.0 * end * BAND;
            let (holds, used) = holds(&points, &lines, 0);
            assert_eq!(holds, inside, "{end} of the band");
            let narrowed = |span: usize| used[span] < 0.99;
            assert_eq!((0..K - 3).find(|span| narrowed(*span)), (!inside).then_some(K - 4));
        }
    }

    /// Along a straight line that cuts a corner, with its middle within a chord.
    fn cut(by: f64) -> ([[f64; 2]; 4], [Line<f64, 2>; 2]) {
        let lines = [line([-1.0, 0.0], [1.0, 0.0], 1.0), line([0.0; 2], [0.0, 1.0], 1.0)];
        let long = 2.0 * by * BAND;
        let way = [long, long];
        let begin = along(&[-long, 0.0], -0.5 / f64::from(CHORDS), &way);
        (core::array::from_fn(|k| along(&begin, k as f64 - 1.0, &way)), lines)
    }

    #[test]
    fn a_corner_is_crossed_in_the_bands_of_both_lines() {
        for (by, inside) in [(0.98, true), (1.015, false)] {
            let (points, lines) = cut(by);
            assert_eq!(holds(&points, &lines, 1).0, inside, "cut by {by} of the band");
        }
    }

    #[test]
    fn a_motion_ends_in_the_line_that_it_should() {
        let (points, lines) = cut(0.5);
        assert!(holds(&points, &lines, 1).0);
        for ends in [0, 2, usize::MAX] {
            let (holds, used) = holds(&points, &lines, ends);
            assert!(!holds && used[0] < 0.1, "{ends}");
        }
    }

    #[test]
    fn where_the_path_turns_back_nothing_is_shown() {
        let (s, c) = 0.05f64.sin_cos();
        let lines = [line([-1.0, 0.0], [1.0, 0.0], 1.0), line([0.0; 2], [-c, s], 1.0)];
        // All of it in both bands, and over to the way back before the turn.
        let points = core::array::from_fn::<_, 4, _>(|k| [-0.5, k as f64 * 0.02 - 0.02]);
        assert!(!holds(&points, &lines, 1).0);
        assert!(!holds(&points, &lines, 0).0);
    }

    #[test]
    fn what_is_no_number_does_not_hold() {
        let (mut points, lines) = cut(0.5);
        points[3][1] = f64::NAN;
        assert!(!holds(&points, &lines, 1).0);
    }
}
