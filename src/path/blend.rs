//! Transitions where an arc takes part: one quintic that meets both sides with equal tangent and
//! curvature.
//!
//! The idea is the corner's (`corner`): leave the first curve a distance d before the joint, reach
//! the second the same distance behind it, with curvature continuous at both ends, and make d as
//! long as the band allows. An arc has curvature at its end, so the control polygon with two
//! collinear edges does not fit; the quintic Hermite curve does. A tangent joint of a line and an
//! arc needs one too: its curvature jumps, and so would the acceleration.

use super::budget;
use super::hermite::Hermite;
use super::node::{Cell, Frame, Node, Programmed};
use super::segment::Segment;
use crate::number::vector::{Vector, norm};
use crate::number::{Length, Scalar};
use core::array::from_fn;

/// Rounds in which the length is fitted to the band.
const ROUNDS: usize = 8;
/// Parts at whose ends the distance from the joint is measured; one of them is the joint itself. Within a part it grows
/// by less than [`budget::BLEND_GAPS`] (see the test).
const PARTS: i64 = 16;
/// Cells of a blend.
pub const CELLS: u8 = 4;

/// A blend over a joint.
#[derive(Clone, Copy, Debug)]
pub struct Blend<S, const N: usize> {
    /// Node at which the first curve is left.
    start: Node<S, N>,
    /// Frame in which the second is reached.
    end: Node<S, N>,
    curve: Hermite<S, N>,
}

impl<S: Scalar, const N: usize> Blend<S, N> {
    /// The blend that leaves `before` and reaches `after` `reach` mm away from their joint.
    pub fn new(before: &Segment<S, N>, after: &Segment<S, N>, reach: S) -> Self {
        let exact = Length::from_mm(reach);
        let start = before.node(before.exact_length - exact);
        let end = after.node(exact);
        let length = (exact + exact).to_mm::<S>();
        let tangent_offset = start.tangent_offset_to(&end.at, length);
        let curve = Hermite::new(&start.frame(), &end.frame(), length, &tangent_offset);
        Self { start, end, curve }
    }

    /// Longest reach up to `most` that keeps within `tolerance`, mm.
    pub fn longest_reach(
        before: &Segment<S, N>,
        after: &Segment<S, N>,
        tolerance: S,
        most: S,
    ) -> S {
        let allowed = tolerance * S::of(budget::BLEND);
        let mut reach = most;
        for round in 0..ROUNDS {
            let blend = Self::new(before, after, reach);
            let off = blend.distance(before, after, reach) + blend.rest();
            if off <= allowed {
                return reach;
            }
            // The distance grows with the square of the reach at a tangent joint, with its first
            // power at a corner: the root first, so as not to shrink a tangent joint too far.
            let ratio = allowed / off;
            let factor = if 2 * round < ROUNDS { ratio.sqrt() } else { ratio };
            reach = reach * factor * S::of(0.98);
        }
        S::ZERO
    }

    /// Greatest distance between blend and joint at the ends of the parts.
    fn distance(&self, before: &Segment<S, N>, after: &Segment<S, N>, reach: S) -> S {
        let sides = Sides::new(before, after, reach);
        let mut worst = S::ZERO;
        for k in 1..PARTS {
            let u = S::from_i64(k) / S::from_i64(PARTS);
            worst = worst.greatest(sides.gap(&self.curve, u));
        }
        worst
    }

    /// How far a motion that rests or starts within a cell leaves the blend, mm: by the greatest second derivative at the
    /// ends of the cells, which is curvature times length squared.
    fn rest(&self) -> S {
        let mut bend = S::ZERO;
        for index in 0..=CELLS {
            bend = bend.greatest(norm(&self.curve.second(Self::parameter(index))));
        }
        bend * S::of(budget::REST / f64::from(u16::from(CELLS) * u16::from(CELLS)))
    }

    /// Node number `index`, 0 to [`CELLS`].
    pub fn node(&self, index: u8) -> Node<S, N> {
        match index {
            0 => self.start,
            CELLS => self.end,
            _ => self.curve.node(&self.start, Self::parameter(index)),
        }
    }

    fn parameter(index: u8) -> S {
        S::from_i64(i64::from(index)) / S::from_i64(i64::from(CELLS))
    }

    /// Cell number `index`.
    pub fn cell(&self, index: u8, from: &Node<S, N>, programmed: Programmed<S>) -> Cell<S, N> {
        let (u0, u1) = (Self::parameter(index), Self::parameter(index + 1));
        let length = self.curve.arc_length(u0, u1);
        // To the very node: where the curve itself ends is rounded.
        let to = if index + 1 < CELLS { self.curve.place(&self.start.at, u1) } else { self.end.at };
        Cell {
            length,
            tangent_offset: from.tangent_offset_to(&to, length),
            programmed,
            dwell: S::ZERO,
            event: None,
            straight: false,
        }
    }
}

/// The segments on either side of a joint.
struct Sides<'a, S, const N: usize> {
    before: &'a Segment<S, N>,
    after: &'a Segment<S, N>,
    /// Their directions and bends at the joint.
    frames: [Frame<S, N>; 2],
    /// Their angles per length, rad/mm.
    rates: [S; 2],
    /// Length that a blend takes of either, mm.
    reach: S,
    /// From the joint to the start of the blend, mm.
    origin: Vector<S, N>,
}

impl<'a, S: Scalar, const N: usize> Sides<'a, S, N> {
    fn new(before: &'a Segment<S, N>, after: &'a Segment<S, N>, reach: S) -> Self {
        let frames = [before.end_frame(), after.start_frame()];
        let rates = [before.rate(), after.rate()];
        let origin = before.walk(&frames[0], rates[0], -reach);
        Self { before, after, frames, rates, reach, origin }
    }

    /// Distance between a blend at `u` in [0, 1] and the point at the same share of the arc length of both segments, mm:
    /// never less than the distance to the nearest point.
    fn gap(&self, blend: &Hermite<S, N>, u: S) -> S {
        let along = (S::of(2.0) * u - S::ONE) * self.reach;
        let [frame_in, frame_out] = &self.frames;
        let point = if along < S::ZERO {
            self.before.walk(frame_in, self.rates[0], along)
        } else {
            self.after.walk(frame_out, self.rates[1], along)
        };
        let p = blend.offset(u);
        let gap: Vector<S, N> = from_fn(|i| self.origin[i] + p[i] - point[i]);
        norm(&gap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::Turn;
    use crate::number::Coord;

    const REACH: f64 = 1.0;

    /// A segment that starts at the origin in a direction, and turns by an angle, rad, over [`REACH`].
    fn segment(heading: f64, angle: f64, back: bool) -> Segment<f64, 2> {
        let at = |x: f64, y: f64| [x, y].map(|x| Coord::from_mm(x).unwrap());
        let (sin, cos) = heading.sin_cos();
        let [from, sign] = if back { [-2.0, -1.0] } else { [2.0, 1.0] };
        let ends = |far: [Coord; 2]| if back { (far, at(0.0, 0.0)) } else { (at(0.0, 0.0), far) };
        if angle == 0.0 {
            let (start, end) = ends(at(from * cos, from * sin));
            return Segment::line(start, end).unwrap();
        }
        let radius = REACH / angle;
        let centre = [-radius * sin, radius * cos];
        let (s, c) = (heading + sign * 2.0 * angle).sin_cos();
        let (start, end) = ends(at(centre[0] + radius * s, centre[1] - radius * c));
        let turn = if angle > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise };
        let [x, y] = at(centre[0], centre[1]);
        Segment::arc(start, end, (0, 1), (x, y), turn, 0).unwrap()
    }

    /// At any turn, between lines and arcs of any curvature.
    #[test]
    fn between_its_samples_a_blend_keeps_what_the_budget_says() {
        let angles = [0.0, 0.03, -0.03, 0.15, -0.15, 0.3, -0.3, 0.45, -0.45];
        let mut most = 0.0f64;
        for turn in [0.0f64, 1.0e-4, 0.01, 0.03, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6, 2.0, 2.4, 2.79] {
            for (first, second) in angles.iter().flat_map(|a| angles.iter().map(move |b| (*a, *b)))
            {
                if turn <= 0.0 && (first - second).abs() < 1.0e-9 {
                    continue;
                }
                let (before, after) = (segment(0.0, first, true), segment(turn, second, false));
                let blend = Blend::new(&before, &after, REACH);
                let sides = Sides::new(&before, &after, REACH);
                let sampled = blend.distance(&before, &after, REACH);
                let dense = (0..=1024).map(|k| sides.gap(&blend.curve, f64::from(k) / 1024.0));
                most = most.max(dense.fold(0.0, f64::max) / sampled);
            }
        }
        assert!(most <= 1.0 + budget::BLEND_GAPS / budget::BLEND, "{most}");
        assert!(most >= 1.0, "{most}");
    }
}
