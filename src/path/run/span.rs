//! One span of a run as nodes and cells.

use crate::number::quadrature::integral;
use crate::number::vector::{Vector, dot, norm, shifted, sub};
use crate::number::{Coord, Scalar};
use crate::path::node::{Cell, Frame, Node, Programmed, by_arc_length};
use core::array::from_fn;

/// Turn of a cell, rad. A cell is a quintic through its ends with their tangents and curvatures,
/// which follows a cubic closely as long as it does not turn much: twice as much would leave it by more than the budget
/// has for rounding. (Half: 6 % more cells, no path by more than 0.2 %.)
const TURN: f64 = 0.25;
/// Turn of a span, rad, that is cut where pieces of lines end: with lines that are hardly a part of a bend. (Ten times as much: of short lines with noise
/// a program in pieces takes up to a tenth longer.)
const GENTLE: f64 = 0.02;
/// Most cells of a span.
const PARTS: u32 = 8;
/// Steps to a place beside the poly-line.
const STEPS: usize = 4;

/// A cubic by its first derivative, a parabola in Bezier form.
#[derive(Clone, Copy)]
pub struct SpanCurve<S, const N: usize> {
    first: [Vector<S, N>; 3],
    /// Length of the parameter, mm.
    step: S,
    straight: bool,
    /// Whether it hardly turns.
    gentle: bool,
    parts: u32,
}

impl<S: Scalar, const N: usize> SpanCurve<S, N> {
    /// From the Bezier points of the first derivative; `still` if the control points are those of
    /// the programmed line.
    pub fn new(first: [Vector<S, N>; 3], step: S, still: bool) -> Self {
        let unit = first.map(|v| {
            let per = S::ONE / norm(&v).greatest(S::of(1.0e-9));
            v.map(|x| x * per)
        });
        let turn = norm(&sub(&unit[1], &unit[0])) + norm(&sub(&unit[2], &unit[1]));
        // Where the parameter slows down the turn is gathered.
        let sizes = first.map(|v| norm(&v));
        let (least, most) = (
            sizes[0].least(sizes[1]).least(sizes[2]),
            sizes[0].greatest(sizes[1]).greatest(sizes[2]),
        );
        let gathered = most * S::of(0.5) > least && turn > S::of(0.1);
        let parts = 1 + (turn * S::of(1.0 / TURN)).to_i64().clamp(0, i64::from(PARTS) - 1) as u32;
        let straight = still && turn <= S::EPSILON * S::of(8.0);
        let gentle = turn < S::of(GENTLE);
        Self { first, step, straight, gentle, parts: if gathered { PARTS } else { parts } }
    }

    /// Cells it is cut into.
    pub fn parts(&self) -> u32 {
        self.parts
    }

    /// Whether it hardly turns.
    pub fn is_gentle(&self) -> bool {
        self.gentle
    }

    /// Whether it is a straight line.
    pub fn is_straight(&self) -> bool {
        self.straight
    }

    /// Where a part begins, by the parameter from 0 to 1.
    pub fn place(&self, part: u32) -> S {
        S::from_u32(part) / S::from_u32(self.parts)
    }

    /// First derivative by the parameter.
    fn first(&self, u: S) -> Vector<S, N> {
        let (v, [a, b, c]) = (S::ONE - u, &self.first);
        let two = S::of(2.0);
        from_fn(|i| (a[i] * v + two * b[i] * u) * v + c[i] * (u * u))
    }

    /// From the start to a place, mm.
    fn offset(&self, u: S) -> Vector<S, N> {
        let third = S::of(1.0 / 3.0);
        let [a, b, c] = &self.first;
        let wa = ((third * u - S::ONE) * u + S::ONE) * u * self.step;
        let wb = (S::ONE - (third + third) * u) * u * u * self.step;
        let wc = third * u * u * u * self.step;
        from_fn(|i| a[i] * wa + b[i] * wb + c[i] * wc)
    }

    fn length(&self, from: S, to: S) -> S {
        integral(from, to, |u| norm(&self.first(u))) * self.step
    }

    /// Which share of the poly-line beside it lies before a place, where it does not turn much: by the foot on the chord.
    #[inline(never)]
    pub fn beside(&self, u: S) -> S {
        let chord = self.offset(S::ONE);
        let square = dot(&chord, &chord);
        if self.parts == 1 && square > S::ZERO { dot(&self.offset(u), &chord) / square } else { u }
    }

    /// The place beside a share of the poly-line.
    pub fn place_beside(&self, share: S) -> S {
        let mut u = share;
        for _ in 0..STEPS {
            // Nearly in proportion: a step by the mean slope takes off all but a small part of what is left.
            u = (u + (share - self.beside(u))).greatest(S::ZERO).least(S::ONE);
        }
        u
    }

    /// Share of the length between two places that lies before a share of the poly-line beside.
    #[cfg(feature = "outputs")]
    pub fn share_before(&self, [from, to]: [S; 2], share: S) -> S {
        let (first, last) = (self.beside(from), self.beside(to));
        let place = self.place_beside(first + (last - first) * share).greatest(from);
        let whole = self.length(from, to);
        if whole > S::ZERO { self.length(from, place) / whole } else { share }
    }

    /// Direction and bend at a place.
    #[inline(never)]
    pub fn frame(&self, u: S) -> Frame<S, N> {
        let [a, b, c] = &self.first;
        let per = S::of(2.0) / self.step;
        let second = from_fn(|i| ((b[i] - a[i]) * (S::ONE - u) + (c[i] - b[i]) * u) * per);
        by_arc_length(&self.first(u), &second)
    }

    /// The point at a place, given where the curve starts.
    pub fn point(&self, u: S, start: &[Coord; N]) -> [Coord; N] {
        shifted(start, &self.offset(u))
    }

    /// The cell between two places, with the nodes there.
    #[inline(never)]
    pub fn cell(
        &self,
        [begin, end]: [S; 2],
        from: &Node<S, N>,
        to: &Node<S, N>,
        programmed: Programmed<S>,
    ) -> Cell<S, N> {
        let mut length = self.length(begin, end);
        let mut tangent_offset = [S::ZERO; N];
        if self.straight {
            let chord: Vector<S, N> = from_fn(|i| to.at[i].minus(from.at[i]));
            length = dot(&chord, &from.tangent);
        } else {
            tangent_offset = from.tangent_offset_to(&to.at, length);
        }
        Cell {
            length,
            tangent_offset,
            programmed,
            dwell: S::ZERO,
            event: None,
            straight: self.straight,
        }
    }
}
