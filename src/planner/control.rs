//! Answers to an operator's commands: hold, stop, abort, overrides, single block.
//!
//! A command is answered by a plan that branches off where the motion will be at the end of a
//! servo cycle, so the answer shows in the cycle after it. The cell under way is cut there: what is
//! left of it starts at the very position, velocity and acceleration that the piece under way has
//! at that moment, so the motion as planned before is a valid start for the solver, and the new
//! plan joins without a step in any derivative up to the second. The cells within the distance
//! that it takes to stop are cut finer, the solver finds the states ([`Aim::Halt`], [`Aim::Slow`]
//! or, when an override is raised, [`Aim::Time`]), and the plan is offered. If the interrupt
//! has passed that cycle meanwhile, it refuses; then everything is as it was before and the
//! next attempt allows more cycles.

use super::{Halt, Planner, Progress};
use crate::number::Scalar;
use crate::profile::law::State;
use crate::profile::rows::Pace;
use crate::profile::solver::{Aim, Stretch};
use crate::servo::control::Wish;
use crate::servo::link::Branch;

/// Ends of blocks tried for a stop.
const END_TRIES: u32 = 4;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// How fast the machine may go, and is asked to.
    pub(super) fn pace(&self) -> Pace<S, N> {
        let factor = |percent: u16| S::from_u32(u32::from(percent.max(1))) * S::of(0.01);
        Pace {
            limits: self.config.limits,
            cycle: self.config.cycle,
            feed: factor(self.overrides.0),
            rapid: factor(self.overrides.1),
        }
    }

    /// Does what is asked for. `Some` if there is nothing else to do in this call.
    pub(super) fn obey(&mut self, wish: &Wish, at: u32) -> Option<Progress> {
        let resumed = wish.resumes != self.resumes;
        self.resumes = wish.resumes;
        let brakes = wish.holds() || wish.aborts != self.aborts;
        let rests = at == self.planned_end;
        if rests && (brakes || wish.stop || wish.overrides != self.overrides) {
            // A start that has not been taken up.
            self.revoke();
        }
        if self.pending.is_none() && at == self.planned_end {
            return self.obey_at_rest(wish, resumed);
        }
        if brakes {
            if matches!(self.halt, Some(Halt::Hold)) {
                return Some(Progress::Waiting);
            }
            let planned = self.revoke() && self.brake();
            // If it could not be done at once: the plan is not taken further, and ends at rest.
            return Some(if planned { Progress::Planned } else { Progress::Waiting });
        }
        if self.pending.is_none() && self.halt.is_some_and(|halt| !halt.is_wanted(wish)) {
            // On at once.
            self.halt = None;
            self.checkpoint = at;
        }
        if wish.overrides != self.overrides && self.revoke() && self.retune(wish.overrides) {
            return Some(Progress::Planned);
        }
        if self.pending.is_some() {
            return None;
        }
        if wish.stop || wish.single {
            if matches!(self.halt, Some(Halt::Block)) {
                return Some(Progress::Waiting);
            }
            if self.tried != self.counters.plans {
                self.tried = self.counters.plans;
                if self.rest_at_block_end() {
                    return Some(Progress::Planned);
                }
            }
        }
        None
    }

    /// At rest: whether to go on.
    fn obey_at_rest(&mut self, wish: &Wish, resumed: bool) -> Option<Progress> {
        let halted = self.halt.take();
        if wish.aborts != self.aborts {
            self.drop_all(wish.aborts);
            return Some(Progress::Aborted);
        }
        if wish.overrides != self.overrides {
            self.overrides = wish.overrides;
            let pace = self.pace();
            for i in 0..self.window.len() {
                self.window.bound(i, &pace);
            }
        }
        let end = self.window.index(self.planned_end);
        let pauses = self.window.get_mut(end).is_some_and(|end| core::mem::take(&mut end.pause));
        if pauses || (wish.single && matches!(halted, Some(Halt::Block))) {
            // A resume that was pressed before this was known was not meant for it.
            self.waits = true;
        } else if resumed {
            self.waits = false;
        }
        (wish.holds() || wish.stop || self.waits).then_some(Progress::Held)
    }

    /// At rest: forgets everything that has not been run, for the abort with this number.
    fn drop_all(&mut self, abort: u32) {
        if self.dropped == Some(abort) {
            return;
        }
        self.window.truncate(self.window.index(self.planned_end));
        if let Some(station) = self.window.last() {
            self.builder.restart(station.node.at);
        }
        self.waits = false;
        self.finished = false;
        self.waiting_since = None;
        self.dropped = Some(abort);
    }

    /// Takes back a plan that has not been decided on. Whether there is none any more.
    fn revoke(&mut self) -> bool {
        match self.pending {
            None => true,
            // It will be decided on within a few cycles.
            Some(pending) if pending.by_cycle => false,
            Some(_) => {
                self.side.withdraw();
                let late = self.counters.late;
                self.hear();
                // That was no fault of the planner's.
                self.counters.late = late;
                self.pending.is_none()
            }
        }
    }

    /// The stretch from a branch to the end of the plan, or to the first rest in it.
    fn stretch_from(&self, first: usize) -> Stretch {
        let end = self.window.index(self.planned_end);
        let rests = |i: &usize| self.window.get(*i).is_some_and(|station| station.rest);
        let last = (first + 1..end).find(rests).unwrap_or(end);
        Stretch { first, last, open: false }
    }

    /// The motion as agreed from where an answer can take effect, on cells cut finer.
    pub(super) fn prepare(&mut self) -> Option<(Stretch, Branch)> {
        let (first, branch) = self.cut_in()?;
        let mut stretch = self.stretch_from(first);
        stretch.last = self.refine(first, stretch.last);
        self.loosen(first, stretch.last);
        Some((stretch, branch))
    }

    /// The first node behind station `first` at which a block ends.
    pub(super) fn block_end(&self, first: usize) -> Option<usize> {
        (first + 1..self.window.len()).find(|&i| self.ends_block(i))
    }

    /// Whether a block ends at station `i`.
    fn ends_block(&self, i: usize) -> bool {
        let Some((before, here)) = i.checked_sub(1).and_then(|i| self.window.pair(i)) else {
            return false;
        };
        let last = i + 1 == self.window.len();
        here.rest || (!last && before.cell.order.tag != here.cell.order.tag)
    }

    /// A plan that rests at the end of the block under way, or of the first one that is possible.
    fn rest_at_block_end(&mut self) -> bool {
        let Some((stretch, branch)) = self.prepare() else {
            self.undo();
            return false;
        };
        self.improve(stretch, Aim::Halt);
        let mut tries = 0;
        for end in stretch.first + 1..=stretch.last {
            if !self.ends_block(end) {
                continue;
            }
            let state = self.window.get(end).map_or(State::REST, |station| station.state);
            self.window.set_state(end, State::REST);
            let held = Stretch { last: end, ..stretch };
            if self.solver.holds(&self.window, held, &self.config.limits) {
                self.improve(held, Aim::Time);
                self.publish(held, branch, self.overrides, Some(Halt::Block));
                return true;
            }
            self.window.set_state(end, state);
            tries += 1;
            if tries >= END_TRIES {
                break;
            }
        }
        self.undo();
        false
    }

    /// A plan at other overrides.
    fn retune(&mut self, overrides: (u16, u16)) -> bool {
        let before = self.overrides;
        self.overrides = overrides;
        let Some((first, branch)) = self.cut_in() else {
            self.overrides = before;
            self.undo();
            return false;
        };
        let end = self.window.index(self.planned_end);
        let last = self.refine(first, end);
        let pace = self.pace();
        for i in first..self.window.len() {
            self.window.bound(i, &pace);
        }
        self.loosen(first, last);
        let slower = (first..last).any(|i| {
            self.window.get(i).is_some_and(|station| station.bounds.speed > station.bounds.goal)
        });
        let rests = self.window.get(last).is_some_and(|station| station.rest);
        let stretch = Stretch { first, last, open: !rests && self.halt.is_none() };
        // First down to the goal, at a price; then, with the speeds reached as bounds, for time.
        for aim in [Aim::Slow, Aim::Time] {
            if aim == Aim::Slow && !slower {
                continue;
            }
            self.improve(stretch, aim);
            self.loosen(first, last);
        }
        if !self.solver.holds(&self.window, stretch, &self.config.limits) {
            self.overrides = before;
            self.undo();
            return false;
        }
        self.publish(stretch, branch, before, self.halt);
        true
    }
}
