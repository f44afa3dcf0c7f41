//! Coming to rest at the end of a block, slice by slice: the motion is made to brake as hard as the limits allow, a rest is
//! tried at the ends of blocks that lie ahead, and the motion to the first that can be is improved for time.

use super::Flow;
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::making::{Purpose, Stage};
use crate::planner::phase::Halt;
use crate::profile::law::PathState;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::solving::Solving;
use crate::servo::link::Room;

/// Nodes tried for a stop.
const END_TRIES: u8 = 6;

/// A rest at the end of a block that is being looked for.
#[derive(Clone, Copy, Debug)]
pub enum Ending<S> {
    /// States that brake as hard as the limits allow are being found.
    Braking(Solving<S>),
    /// Ends of blocks from `next` on are tried.
    Trying { next: usize, tries: u8 },
    /// A motion to one is being found where braking as hard as the limits allow leads to creeping, and that not to rest. `last`: of the
    /// whole stretch.
    Finding { solving: Solving<S>, last: usize, tries: u8 },
    /// One is found; the motion there is being improved.
    Improving(Solving<S>),
}

/// What one try has come to.
#[derive(Clone, Copy, Debug)]
enum Tried {
    /// The motion comes to rest at the end of this stretch.
    Rests(Stretch),
    /// A limit is broken, where the motion has braked and creeps.
    Creeps(Stretch),
    /// A limit is broken; there may be another.
    Fails,
    /// There is no other.
    Exhausted,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Begins to look for a rest at the end of the block under way, or of the first one that is possible. Whether
    /// that is under way.
    pub(super) fn rest_at_block_end(&mut self, at: NodeSerial) -> bool {
        let moment = self.moment_of_answer(at);
        let begun = moment.and_then(|moment| self.horizon.begin_ending(moment));
        self.make((Purpose::BlockEnd, at), begun)
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// There is a draft afterwards only if there is something to look for.
    fn begin_ending(&mut self, moment: Moment<S>) -> Option<(Proposal, Stage<S>)> {
        self.draft(|draft| {
            let (stretch, branch) = draft.prepare(moment)?;
            if draft.is_stopping(stretch.first) {
                return None;
            }
            let ending = Ending::Braking(draft.begin_improving(stretch, Aim::Halt));
            Some((Proposal { stretch, branch, halt: Some(Halt::Block) }, Stage::Ending(ending)))
        })
    }

    /// A slice of looking for a rest at the end of a block: a part of a Newton step, or one try.
    pub fn go_on_ending(
        &mut self,
        ending: &mut Ending<S>,
        proposal: &mut Proposal,
        room: Room<'_, S, N>,
    ) -> Flow {
        let stretch = proposal.stretch;
        *ending = match ending {
            Ending::Braking(solving) => {
                if self.go_on(solving, room) {
                    return Flow::Working;
                }
                Ending::Trying { next: stretch.first + 1, tries: 0 }
            }
            Ending::Trying { next, tries } => {
                let Some(end) = (*next..=stretch.last).find(|&i| self.ends_block(i)) else {
                    return Flow::Nothing;
                };
                *next = end;
                match self.try_rest_at(stretch, next, tries) {
                    Tried::Rests(held) => {
                        proposal.stretch = held;
                        Ending::Improving(self.begin_improving(held, Aim::Time))
                    }
                    Tried::Creeps(held) => {
                        proposal.stretch = held;
                        let solving = self.begin_finding(held, held.first + 1);
                        Ending::Finding { solving, last: stretch.last, tries: *tries }
                    }
                    Tried::Fails => return Flow::Working,
                    Tried::Exhausted => return Flow::Nothing,
                }
            }
            Ending::Finding { solving, last, tries } => {
                if self.go_on(solving, room) {
                    return Flow::Working;
                }
                if self.holds(stretch) {
                    return Flow::Ready;
                }
                proposal.stretch = Stretch { last: *last, ..stretch };
                Ending::Trying { next: stretch.last + 1, tries: *tries }
            }
            Ending::Improving(solving) => {
                return if self.go_on(solving, room) { Flow::Working } else { Flow::Ready };
            }
        };
        Flow::Working
    }

    /// Tries a rest at the next node of a stretch, from `next` on.
    fn try_rest_at(&mut self, stretch: Stretch, next: &mut usize, tries: &mut u8) -> Tried {
        if *next > stretch.last || *tries >= END_TRIES {
            return Tried::Exhausted;
        }
        let tried = self.rest_at_node(stretch, *next);
        (*next, *tries) = (*next + 1, *tries + 1);
        tried
    }

    /// The stretch up to a node, at rest there, if that keeps the limits; else nothing has changed, unless the motion creeps there.
    fn rest_at_node(&mut self, stretch: Stretch, end: usize) -> Tried {
        let speed_squared =
            |i: usize| self.window.get(i).map_or(S::ZERO, |station| station.state.b);
        // The barrier leaves a motion that has halted creeping: it goes no slower farther on.
        let creeps = (stretch.first..end).any(|i| speed_squared(i) <= speed_squared(end));
        let state = self.window.get(end).map_or(PathState::REST, |station| station.state);
        self.window.set_state(end, PathState::REST);
        let held = Stretch { last: end, ..stretch };
        // With no node between there is nothing that could be improved.
        let alone = end == stretch.first + 1;
        if !(alone && self.crawl_in(held).is_some()) && self.holds(held) {
            return Tried::Rests(held);
        }
        if creeps && !alone {
            return Tried::Creeps(held);
        }
        self.window.set_state(end, state);
        Tried::Fails
    }
}
