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
use crate::number::serial::NodeSerial;
use crate::path::node::Cell;
use crate::profile::law::PathState;
use crate::profile::rows::Pace;
use crate::profile::solver::{Aim, Stretch};
use crate::servo::control::Wish;
use crate::servo::link::Branch;

/// Leads within which a node is waited for where an override finds no answer at once.
const NEAR_LEADS: f64 = 4.0;
/// Nodes tried for a stop.
const END_TRIES: u32 = 6;

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
    pub(super) fn obey(&mut self, wish: &Wish, at: NodeSerial) -> Option<Progress> {
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
        if wish.overrides != self.overrides && self.revoke() && self.retune(wish.overrides, at) {
            return Some(Progress::Planned);
        }
        if self.pending.is_some() {
            return None;
        }
        if wish.stop || wish.single {
            if matches!(self.halt, Some(Halt::Block)) {
                return Some(Progress::Waiting);
            }
            if self.stands(at) {
                if self.rest_next(Halt::Block) {
                    return Some(Progress::Planned);
                }
            } else if self.tried != self.counters.plans {
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
            self.bound_all();
        }
        let end = self.end_index();
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
        self.window.truncate(self.end_index());
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
    pub(super) fn stretch_from(&self, first: usize) -> Stretch {
        let end = self.end_index();
        let rests = |i: &usize| self.window.get(*i).is_some_and(|station| station.rest);
        let last = (first + 1..end).find(rests).unwrap_or(end);
        Stretch { first, last, open: false }
    }

    /// The motion as agreed from where an answer can take effect, on cells cut finer.
    pub(super) fn prepare(&mut self) -> Option<(Stretch, Branch)> {
        let (first, branch) = self.cut_in()?;
        let mut stretch = self.stretch_from(first);
        stretch.last = self.refine(first, stretch.last, self.braking_distance(first));
        self.loosen(first, stretch.last);
        Some((stretch, branch))
    }

    /// The first node behind station `first` at which a block ends.
    pub(super) fn block_end(&self, first: usize) -> Option<usize> {
        (first + 1..self.window.len()).find(|&i| self.ends_block(i))
    }

    /// Whether a block ends at station `i`.
    pub(super) fn ends_block(&self, i: usize) -> bool {
        let Some((before, here)) = i.checked_sub(1).and_then(|i| self.window.pair(i)) else {
            return false;
        };
        let last = i + 1 == self.window.len();
        let (before, after) = (&before.cell, &here.cell);
        let differs = !last && before.programmed.tag != after.programmed.tag;
        // A long dwell is many cells.
        let dwells = |cell: &Cell<S, N>| !(cell.length > S::ZERO) && cell.event.is_none();
        differs || (here.rest && (last || !(dwells(before) && dwells(after))))
    }

    /// A plan that rests at the end of the block under way, or of the first one that is possible.
    fn rest_at_block_end(&mut self) -> bool {
        let Some((stretch, branch)) = self.prepare() else {
            self.undo();
            return false;
        };
        if self.is_stopping(stretch.first) {
            self.undo();
            return false;
        }
        self.improve(stretch, Aim::Halt);
        let done = self.rest_at(stretch, branch, Halt::Block, Self::ends_block);
        if !done {
            self.undo();
        }
        done
    }

    /// A plan that rests at the first node that can be and that is fit for it.
    pub(super) fn rest_at(
        &mut self,
        stretch: Stretch,
        branch: Branch,
        halt: Halt,
        fits: impl Fn(&Self, usize) -> bool,
    ) -> bool {
        let mut tries = 0;
        for end in stretch.first + 1..=stretch.last {
            if !fits(self, end) {
                continue;
            }
            let state = self.window.get(end).map_or(PathState::REST, |station| station.state);
            self.window.set_state(end, PathState::REST);
            let held = Stretch { last: end, ..stretch };
            // With no node between there is nothing that could be improved.
            let crawls = end == stretch.first + 1 && self.crawl_in(held).is_some();
            if !crawls && self.holds(held) {
                self.improve(held, Aim::Time);
                self.publish(held, branch, self.overrides, Some(halt));
                return true;
            }
            self.window.set_state(end, state);
            tries += 1;
            if tries >= END_TRIES {
                break;
            }
        }
        false
    }

    /// A plan at other overrides: from the next servo cycle on, or else from a node on.
    fn retune(&mut self, overrides: (u16, u16), at: NodeSerial) -> bool {
        let before = core::mem::replace(&mut self.overrides, overrides);
        let cut = self.cut_in();
        let stops = cut.is_some_and(|(first, _)| self.is_stopping(first));
        if let Some((first, branch)) = cut
            && !stops
            && self.retune_from(first, branch, before)
        {
            return true;
        }
        self.undo();
        // One that is far off would only keep the next try waiting.
        let near = |node: &NodeSerial| {
            let all = self.window.clamped_index(at)..self.window.clamped_index(*node);
            let time = all.fold(S::ZERO, |time, i| time + self.agreed_time(i));
            *node != self.planned_end && time < self.config.lead * S::of(NEAR_LEADS)
        };
        let node = self.branch(at).filter(near);
        if !stops && let Some(node) = node {
            if self.retune_from(self.window.clamped_index(node), Branch::Node(node), before) {
                return true;
            }
            self.undo();
        }
        if !stops {
            self.overrides = before;
        }
        // A stop under way is finished; what comes after it goes at the new pace.
        self.bound_all();
        false
    }

    /// Bounds of all cells anew, for other overrides.
    pub(super) fn bound_all(&mut self) {
        let pace = self.pace();
        for i in 0..self.window.len() {
            self.window.bound(i, &pace);
        }
    }

    /// A plan at the pace that is set now.
    fn retune_from(&mut self, first: usize, branch: Branch, before: (u16, u16)) -> bool {
        let end = self.end_index();
        let by_cycle = matches!(branch, Branch::Cycle(_));
        let pace = self.pace();
        self.window.bound(first, &pace);
        let speed = self.window.get(first).map_or(S::ZERO, |station| station.state.b.sqrt());
        let distance = self.ramp(first, speed).greatest(self.braking_distance(first));
        let last = if by_cycle { self.refine(first, end, distance) } else { end };
        for i in first..self.window.len() {
            self.window.bound(i, &pace);
        }
        self.loosen(first, last);
        let slower = (first..last).any(|i| {
            self.window.get(i).is_some_and(|station| station.bounds.speed > station.bounds.goal)
        });
        let rests = self.window.get(last).is_some_and(|station| station.rest);
        let mut stretch = Stretch { first, last, open: !rests && self.halt.is_none() };
        // A plan that was made to rest at its end does so with all that the limits allow.
        stretch.open &= self.holds(stretch);
        if !slower && self.find_afresh(stretch) {
            self.publish(stretch, branch, before, self.halt);
            return true;
        }
        // First down to the goal, at a price; then, with the speeds reached as bounds, for time.
        for aim in [Aim::Slow, Aim::Time] {
            if aim == Aim::Slow && !slower {
                continue;
            }
            self.improve(stretch, aim);
            self.loosen(first, last);
        }
        let holds = self.holds(stretch);
        if !holds || self.crawl_in(stretch).is_some() {
            return false;
        }
        self.publish(stretch, branch, before, self.halt);
        true
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
