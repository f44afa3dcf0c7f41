//! The tags of lines that have become one: which a cell shows, and where cells end for it.

use super::intake::least_piece;
use super::{Builder, Front};
use crate::machine::Config;
use crate::number::{Interval, Length, Scalar};
use crate::path::blend;
use crate::path::node::Programmed;
use crate::path::straight::{self, FIRST_PART, LAST_PART, Mark, NEAR};

impl<S: Scalar, const N: usize, const BLOCKS: usize> Builder<S, N, BLOCKS> {
    /// What is asked of a cell of the joint behind the front block, at a place of the front block (0) or the next (1), mm from its start.
    pub(super) fn programmed_at(&self, item: usize, s: S) -> Option<Programmed<S>> {
        Some(Programmed { tag: self.tag_at(item, s), ..self.queue.get(item)?.programmed() })
    }

    /// The same of cell `index` of a blend, with the tag of the place that lies beside it by equal parts; the front block is `length` mm long.
    pub(super) fn programmed_beside(&self, index: u8, length: S) -> Option<Programmed<S>> {
        let per = self.kept.to_mm::<S>() / S::from_u32(u32::from(blend::CELLS));
        // From the middle of the joint to the middle of the cell.
        let s = S::from_i64(2 * i64::from(index) + 1 - i64::from(blend::CELLS)) * per;
        if s < S::ZERO { self.programmed_at(0, length + s) } else { self.programmed_at(1, s) }
    }

    /// The marks of the front block (0) or the next (1).
    fn marks_of(&self, item: usize) -> impl Iterator<Item = Mark<S>> {
        let count = |index: usize| self.queue.get(index).map_or(0, |item| usize::from(item.marks));
        let first = if item == 0 { 0 } else { count(0) };
        (first..first + count(item)).filter_map(|index| self.marks.get(index))
    }

    /// The tag at a place of the front block (0) or the next (1), mm from its start.
    #[inline(never)]
    pub(super) fn tag_at(&self, item: usize, s: S) -> u32 {
        let own = self.queue.get(item).map_or(0, |item| item.tag);
        self.marks_of(item).find(|mark| mark.s > s).map_or(own, |mark| mark.tag)
    }

    /// Where a cell of the corner behind the front block ends that is beside so much of that (0) or the next (1), if a piece of it ends there; and the tag
    /// of that piece.
    pub(super) fn mark_beside(
        &self,
        item: usize,
        beside: Interval,
        config: &Config<S, N>,
    ) -> Option<(Length, u32)> {
        let block = self.queue.get(item).filter(|block| block.marks > 0)?;
        let least = Length::from_mm(least_piece(block.segment.as_ref()?, block.feed, config)) * 4;
        let ends = self.marks_of(item).map(|mark| (Length::from_mm(mark.s), mark.tag));
        straight::end_in(beside, least, ends)
    }

    /// Where a cell of the front block ends, of which the interval is uncut, that would end at `next`, and where the next one would begin without
    /// what pieces end between: at the end of a piece if that is near, else at one before.
    pub(super) fn to_mark(
        &self,
        Front { block, segment, .. }: &Front<S, N>,
        Interval { from: s, to: until }: Interval,
        next: Length,
        config: &Config<S, N>,
    ) -> (Length, Length) {
        if block.marks == 0 {
            return (next, next);
        }
        // What is too short to be shown is no cell of its own, nor is a small part of one: in `f32` the motion
        // over a cell a hundred times as short as its neighbour is not found.
        let least = Length::from_mm(least_piece(segment, block.feed, config)) / 2;
        let part = |of: i64| least.max((next - s) / of);
        let (near, first, last) = (part(NEAR), part(FIRST_PART), part(LAST_PART));
        let mut ends = self.marks_of(0).map(|mark| Length::from_mm(mark.s));
        match ends.find(|&at| at - s > first) {
            Some(at) if until - at <= last => (next, next),
            Some(at) if next < until && at - next < near && next - at < near => (at, at),
            Some(at) if at < next => (at, next),
            _ => (next, next),
        }
    }

    /// Forgets the marks of the front block up to a place on it.
    #[inline(never)]
    pub(super) fn pass_marks(&mut self, s: Length) {
        let Some(front) = self.queue.front_mut() else { return };
        let passed = s.to_mm::<S>();
        while front.marks > 0 && self.marks.get(0).is_some_and(|mark| mark.s <= passed) {
            self.marks.drop_front(1);
            front.marks -= 1;
        }
    }

    /// Shows a run the marks of the front block, over what it takes of it.
    pub(super) fn mark_run(&mut self, Interval { from, to: until }: Interval) {
        let origin = self.run.reach() - from;
        let mut begins = from;
        for index in 0..self.queue.front().map_or(0, |front| usize::from(front.marks)) {
            let Some(mark) = self.marks.get(index) else { break };
            let ends = Length::from_mm(mark.s);
            if ends > from && begins < until {
                let piece = Interval { from: origin + begins, to: origin + ends };
                self.run.mark(piece, mark.tag);
            }
            begins = ends.max(from);
        }
    }
}
