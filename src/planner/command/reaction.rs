//! The first answer to an override where planning takes time: the motion begins to do what is asked for while the whole
//! answer is still being made.
//!
//! The agreed motion is improved for the override's aim in a few Newton steps, over the path that it takes to
//! come to the new pace. Every step keeps all limits and leaves the motion behind that path as it is, so the plan still
//! ends where the agreed one does, whatever becomes of the rest of the answer.

use super::Flow;
use crate::number::Scalar;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::planner::Planner;
use crate::planner::effort::Effort;
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::making::{Purpose, Stage};
use crate::planner::phase::Halt;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::solving::Solving;
use crate::servo::control::Overrides;
use crate::servo::link::Room;

/// Newton steps of a first answer.
const STEPS: u16 = 4;
/// Cells that take as much work in a plan ahead as a first answer does in all, as long as none has been measured.
pub const CELLS: usize = 4;
/// The same of a whole answer that takes long.
const LONG: usize = 18;
/// Braking distances over which a motion is changed at first.
const REACH: f64 = 1.3;
/// Plans ahead that an answer takes as much work as which leads past many blocks.
pub const PLANS: usize = 3;
/// First answers that a whole one takes as much work as.
const FIRSTS: usize = 4;
/// Servo cycles within which an answer can do without a first one.
const AT_ONCE: f64 = 3.0;

/// How far the answer to a command that lasts has got.
#[derive(Clone, Copy, Debug)]
pub struct Pressing {
    /// Overrides that the motion answers to already in part.
    pub reacted: Option<Overrides>,
    /// Overrides for which it has been looked into whether the motion is to slow down.
    pub eased: Option<Overrides>,
    /// Attempts at that which have come to nothing.
    pub easings: u8,
    /// Stages of slowing down to that which have been made.
    pub falls: u8,
    /// Attempts to find a rest that have come to nothing.
    pub attempts: u8,
    /// Servo cycle of the first of them.
    pub attempted: CycleSerial,
    /// Servo cycles that planning was reckoned to take for the stop that is waited for.
    pub reckoned: u32,
    /// How often it has been made anew for that.
    pub anew: u8,
    /// Calls that have waited for it since a servo cycle.
    pub waits: u8,
    pub waiting: CycleSerial,
    /// Whether a plan to the end of a block has come to nothing, or too late: for a stop that is still asked for the motion comes to rest as soon as it can,
    /// and goes on to the end of the block from there.
    pub short: bool,
    /// Tries to come to other overrides that have come to nothing.
    pub retunes: u8,
    /// Whole answers to them that have fallen short.
    pub short_falls: u8,
    /// Those overrides, when no more tries are made for now.
    pub refused: Option<Overrides>,
    /// Servo cycle of the last of them.
    pub retuned: CycleSerial,
    /// Where the motion was at the last attempt or try.
    pub at: NodeSerial,
}

impl Pressing {
    /// Nothing is asked for.
    pub const NONE: Self = Self {
        reacted: None,
        eased: None,
        easings: 0,
        falls: 0,
        attempts: 0,
        attempted: CycleSerial::ZERO,
        reckoned: 0,
        anew: 0,
        waits: 0,
        waiting: CycleSerial::ZERO,
        short: false,
        retunes: 0,
        short_falls: 0,
        refused: None,
        retuned: CycleSerial::ZERO,
        at: NodeSerial::ZERO,
    };
}

/// A first answer in the making.
#[derive(Clone, Copy, Debug)]
pub struct Reacting<S> {
    solving: Solving<S>,
    /// Station from which on the motion stays as it is.
    until: usize,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Where the motion is, and when an answer that takes so many servo cycles can take effect.
    #[inline(never)]
    pub(super) fn moment_after(&self, cycles: S) -> Option<Moment<S>> {
        let mut moment = self.moment()?;
        let work = (cycles + S::of(0.5)).to_i64().clamp(0, 1_000_000) as u32;
        let least = self.side.cycles().plus(work);
        if moment.when.is_before(least) {
            moment.when = least;
        }
        Some(moment)
    }

    /// The same for a plan at other overrides, with the motion at node `at`.
    pub(super) fn moment_of_answer(&self, at: NodeSerial) -> Option<Moment<S>> {
        let cells = self.cells_ahead(at);
        let Effort { plan, first, .. } = &self.effort;
        let whole = self.effort.whole();
        // What plans ahead take for each of their cells says little: many change the end of what is agreed alone.
        self.moment_after(if whole.is_known() {
            whole.usual(cells)
        } else if first.is_known() {
            first.usual(FIRSTS)
        } else {
            plan.usual(PLANS * cells)
        })
    }

    /// The same for a first answer.
    pub(super) fn moment_of_first_answer(&self) -> Option<Moment<S>> {
        let needed = self.effort.first.usual(1);
        let needed = if needed > S::ZERO { needed } else { self.effort.plan.usual(CELLS) };
        self.moment_after(needed)
    }

    /// Begins a first answer if the whole one takes long and there is none yet. Whether one is in the making.
    pub(super) fn react(&mut self, asked: Overrides, at: NodeSerial) -> bool {
        let long = self.effort.plan.usual(LONG) > S::of(AT_ONCE);
        if !long || self.pressing.reacted == Some(asked) {
            return false;
        }
        self.pressing.reacted = Some(asked);
        let halt = self.phase.halt();
        let Some(moment) = self.moment_of_first_answer() else { return false };
        let begun = self.horizon.begin_reaction(moment, asked, halt);
        self.make((Purpose::Reaction(asked), at), begun)
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Begins a first answer. There is a draft afterwards only if there is one.
    fn begin_reaction(
        &mut self,
        moment: Moment<S>,
        asked: Overrides,
        halt: Option<Halt>,
    ) -> Option<(Proposal, Stage<S>)> {
        self.draft(|draft| draft.reaction(moment, asked, halt))
    }

    fn reaction(
        &mut self,
        moment: Moment<S>,
        asked: Overrides,
        halt: Option<Halt>,
    ) -> Option<(Proposal, Stage<S>)> {
        let (first, branch) = self.cut_in(moment)?;
        let mut stretch = self.stretch_from(first);
        let behind;
        (stretch.last, behind) = self.refine(first, stretch.last, self.braking_distance(first));
        if self.is_stopping(first) {
            return None;
        }
        // Not before it is known that there is one: all cells are bounded anew, and again when it is over.
        self.try_overrides(asked);
        self.bound_from(first);
        self.loosen(first, stretch.last);
        let aim = if self.exceeds_goal(stretch) { Aim::Slow } else { Aim::Time };
        // What was cut may break a limit by a rounding.
        let until = self.near(stretch, S::of(REACH)).max(behind).min(stretch.last);
        stretch.open = halt.is_none() && self.is_open(stretch);
        let solving = self.begin_improving_until(stretch, until, (STEPS, aim));
        let reacting = Stage::Reacting(Reacting { solving, until });
        Some((Proposal { stretch, branch, halt }, reacting))
    }

    /// Whether the motion ends where it does only because no more is known.
    #[inline(never)]
    pub(super) fn is_open(&mut self, stretch: Stretch) -> bool {
        let rests = self.window.get(stretch.last).is_some_and(|station| station.rest);
        // A plan that was made to rest at its end does so with all that the limits allow.
        let end = Stretch { first: stretch.last.saturating_sub(1), open: true, ..stretch };
        !rests && self.holds(end)
    }

    /// A slice of a first answer: one Newton step.
    pub fn go_on_reacting(
        &mut self,
        reacting: &mut Reacting<S>,
        proposal: Proposal,
        room: Room<'_, S, N>,
    ) -> Flow {
        if self.go_on(&mut reacting.solving, room) {
            return Flow::Working;
        }
        let stretch = proposal.stretch;
        // It is a plan at the overrides that are in effect, though it is slower or faster.
        self.keep_overrides();
        self.loosen(stretch.first, stretch.last);
        self.mark_eased(stretch.first);
        if self.holds_until(stretch, reacting.until) { Flow::Ready } else { Flow::Nothing }
    }

    /// The station by which so many braking distances from the first one of a stretch have been run.
    fn near(&self, stretch: Stretch, reach: S) -> usize {
        let mut left = self.braking_distance(stretch.first) * reach;
        for i in stretch.first..stretch.last {
            if !(left > S::ZERO) {
                return i;
            }
            left -= self.window.get(i).map_or(S::ZERO, |station| station.cell.length);
        }
        stretch.last
    }
}
