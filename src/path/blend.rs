//! Transitions where an arc takes part: one quintic that meets both sides with equal tangent and
//! curvature.
//!
//! The idea is the corner's (`corner`): leave the first curve a distance d before the joint, reach
//! the second the same distance behind it, with curvature continuous at both ends, and make d as
//! long as the band allows. An arc has curvature at its end, so the control polygon with two
//! collinear edges does not fit; the quintic Hermite curve does. A tangent joint of a line and an
//! arc needs one too: its curvature jumps, and so would the acceleration.

use super::hermite::Hermite;
use super::node::{Cell, Node, Programmed};
use super::segment::Segment;
use crate::number::vector::{Vector, norm};
use crate::number::{Length, Scalar};
use core::array::from_fn;

/// Share of the band that is used; the rest covers the distance between samples.
const BAND_SHARE: f64 = 0.95;
/// Rounds in which the length is fitted to the band.
const ROUNDS: usize = 8;
/// Places at which the distance from the joint is measured.
const SAMPLES: i64 = 16;
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
        let (a, b) = ((&start.tangent, &start.curvature), (&end.tangent, &end.curvature));
        Self { curve: Hermite::new(a, b, length, &tangent_offset), start, end }
    }

    /// Longest reach up to `most` that keeps within `tolerance`, mm.
    pub fn longest_reach(
        before: &Segment<S, N>,
        after: &Segment<S, N>,
        tolerance: S,
        most: S,
    ) -> S {
        let allowed = tolerance * S::of(BAND_SHARE);
        let mut reach = most;
        for round in 0..ROUNDS {
            let off = Self::new(before, after, reach).distance(before, after, reach);
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

    /// Greatest distance between blend and joint, each point of the blend held against the point
    /// of the same share of the arc length: never less than the true distance.
    fn distance(&self, before: &Segment<S, N>, after: &Segment<S, N>, reach: S) -> S {
        let (frame_in, frame_out) = (before.end_frame(true), after.end_frame(false));
        let origin = before.walk((&frame_in.0, &frame_in.1), -reach);
        let mut worst = S::ZERO;
        for k in 1..SAMPLES {
            let u = S::from_i64(k) / S::from_i64(SAMPLES);
            let along = (S::of(2.0) * u - S::ONE) * reach;
            let programmed = if along < S::ZERO {
                before.walk((&frame_in.0, &frame_in.1), along)
            } else {
                after.walk((&frame_out.0, &frame_out.1), along)
            };
            let p = self.curve.offset(u);
            let gap: Vector<S, N> = from_fn(|i| origin[i] + p[i] - programmed[i]);
            worst = worst.greatest(norm(&gap));
        }
        worst
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
