//! Coming to rest at the end of a block.

use super::halting::Tried;
use crate::number::Scalar;
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::phase::Halt;
use crate::profile::law::PathState;
use crate::profile::solver::{Aim, Stretch};
use crate::servo::link::Branch;

/// Nodes tried for a stop.
const END_TRIES: u8 = 6;

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// A plan that rests at the end of the block under way, or of the first one that is possible.
    pub(super) fn rest_at_block_end(&mut self, moment: Option<Moment<S>>) -> Option<Proposal> {
        self.draft(|draft| {
            let (stretch, branch) = draft.prepare(moment?)?;
            if draft.is_stopping(stretch.first) {
                return None;
            }
            draft.improve(stretch, Aim::Halt);
            draft.rest_at(stretch, branch, Halt::Block, Self::ends_block)
        })
    }

    /// A plan that rests at the first node that can be and that is fit for it.
    fn rest_at(
        &mut self,
        stretch: Stretch,
        branch: Branch,
        halt: Halt,
        fits: impl Fn(&Self, usize) -> bool,
    ) -> Option<Proposal> {
        let mut tries = 0;
        for end in stretch.first + 1..=stretch.last {
            if !fits(self, end) {
                continue;
            }
            if let Some(stretch) = self.rest_at_node(stretch, end) {
                self.improve(stretch, Aim::Time);
                return Some(Proposal { stretch, branch, halt: Some(halt) });
            }
            tries += 1;
            if tries >= END_TRIES {
                break;
            }
        }
        None
    }

    /// Tries a rest at the next node of a stretch, from `next` on.
    pub(super) fn try_rest_at(
        &mut self,
        stretch: Stretch,
        next: &mut usize,
        tries: &mut u8,
    ) -> Tried {
        if *next > stretch.last || *tries >= END_TRIES {
            return Tried::Exhausted;
        }
        let held = self.rest_at_node(stretch, *next);
        (*next, *tries) = (*next + 1, *tries + 1);
        held.map_or(Tried::Fails, Tried::Rests)
    }

    /// The stretch up to a node, at rest there, if that keeps the limits; else nothing has changed.
    fn rest_at_node(&mut self, stretch: Stretch, end: usize) -> Option<Stretch> {
        let state = self.window.get(end).map_or(PathState::REST, |station| station.state);
        self.window.set_state(end, PathState::REST);
        let held = Stretch { last: end, ..stretch };
        // With no node between there is nothing that could be improved.
        let crawls = end == stretch.first + 1 && self.crawl_in(held).is_some();
        if !crawls && self.holds(held) {
            return Some(held);
        }
        self.window.set_state(end, state);
        None
    }
}
