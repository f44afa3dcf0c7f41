//! Answers to overrides of feed and rapids.

use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::horizon::{Horizon, Proposal};
use crate::planner::making::Purpose;
use crate::planner::phase::Halt;
use crate::profile::solver::{Aim, Stretch};
use crate::servo::control::Overrides;
use crate::servo::link::Branch;

/// Leads within which a node is waited for where an override finds no answer at once.
const NEAR_LEADS: f64 = 4.0;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// A plan at other overrides: from the next servo cycle on, or else from a node on. Whether there is one.
    pub(super) fn retune(&mut self, overrides: Overrides, at: NodeSerial) -> bool {
        let (moment, halt) = (self.moment(), self.phase.halt());
        let horizon = &mut *self.horizon;
        let mut stops = false;
        let mut made = horizon.draft(|draft| {
            draft.try_overrides(overrides);
            let (first, branch) = draft.cut_in(moment?)?;
            stops = draft.is_stopping(first);
            if stops { None } else { draft.retune_from(first, branch, halt) }
        });
        if stops {
            // A stop under way is finished; what comes after it goes at the new pace.
            horizon.set_overrides(overrides);
            return false;
        }
        if made.is_none()
            && let Some(node) =
                horizon.branch(at, S::ZERO).filter(|node| horizon.is_near(at, *node))
        {
            made = horizon.draft(|draft| {
                draft.try_overrides(overrides);
                let first = draft.window.clamped_index(node);
                draft.retune_from(first, Branch::Node(node), halt)
            });
        }
        self.propose(Purpose::Overrides, made)
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Whether a node before the end of the plan is near enough to wait for: one that is far off would only
    /// keep the next try waiting.
    fn is_near(&self, at: NodeSerial, node: NodeSerial) -> bool {
        let all = self.window.clamped_index(at)..self.window.clamped_index(node);
        let time = all.fold(S::ZERO, |time, i| time + self.agreed_time(i));
        node != self.end() && time < self.config.lead * S::of(NEAR_LEADS)
    }

    /// A plan at the pace that is set now.
    fn retune_from(
        &mut self,
        first: usize,
        branch: Branch,
        halt: Option<Halt>,
    ) -> Option<Proposal> {
        let end = self.end_index();
        let by_cycle = matches!(branch, Branch::Cycle(_));
        self.window.bound(first, &self.pace());
        let speed = self.window.get(first).map_or(S::ZERO, |station| station.state.b.sqrt());
        let distance = self.ramp(first, speed).greatest(self.braking_distance(first));
        let last = if by_cycle { self.refine(first, end, distance) } else { end };
        self.bound_from(first);
        self.loosen(first, last);
        let slower = (first..last).any(|i| {
            self.window.get(i).is_some_and(|station| station.bounds.speed > station.bounds.goal)
        });
        let rests = self.window.get(last).is_some_and(|station| station.rest);
        let mut stretch = Stretch { first, last, open: !rests && halt.is_none() };
        // A plan that was made to rest at its end does so with all that the limits allow.
        stretch.open &= self.holds(stretch);
        if !slower && self.find_afresh(stretch) {
            return Some(Proposal { stretch, branch, halt });
        }
        // First down to the goal, at a penalty; then, with the speeds reached as bounds, for time.
        for aim in [Aim::Slow, Aim::Time] {
            if aim == Aim::Slow && !slower {
                continue;
            }
            self.improve(stretch, aim);
            self.loosen(first, last);
        }
        let runs = self.holds(stretch) && self.crawl_in(stretch).is_none();
        runs.then_some(Proposal { stretch, branch, halt })
    }

    /// Whether a motion was found from a guess, as for a new plan; else the states are as they were.
    fn find_afresh(&mut self, stretch: Stretch) -> bool {
        let found = self.find_from_guess(stretch, stretch.first + 1);
        let runs = found && self.crawl_in(stretch).is_none();
        if !runs {
            self.take_agreed(stretch.first..stretch.last + 1);
        }
        runs
    }
}
