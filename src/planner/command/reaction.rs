//! The first answer to a command where planning takes time: the motion begins to do what is asked for while the whole
//! answer is still being made.
//!
//! The agreed motion is improved for the command's aim in a few Newton steps, over the path that it takes to stop or to
//! come to the new pace. Every step keeps all limits and leaves the motion behind that path as it is, so the plan still
//! ends where the agreed one does, whatever becomes of the rest of the answer.

use super::halting::{BRAKING_REACH, FIRST_REACH, Flow};
use crate::number::Scalar;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::planner::Planner;
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::making::{Purpose, Stage};
use crate::planner::phase::Halt;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::solving::Solving;
use crate::servo::control::Overrides;

/// Newton steps of a first answer.
const STEPS: u16 = 4;
/// Cells that take as much work in a plan ahead as a first answer does in all.
const CELLS: usize = 4;
/// Cells that take as much work in a plan ahead as an attempt to find a rest.
const ATTEMPT_CELLS: usize = 18;
/// Plans ahead that an answer takes as much work as which leads past many blocks.
const PLANS: usize = 3;
/// Servo cycles within which an answer can do without a first one.
const AT_ONCE: f64 = 3.0;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// To stop.
    Hold,
    /// To go on at other overrides.
    Overrides(Overrides),
}

/// How far the answer to a command that lasts has got.
#[derive(Clone, Copy, Debug)]
pub struct Pressing {
    /// What the motion answers already in part.
    pub reacted: Option<Asked>,
    /// Attempts to find a rest that have come to nothing.
    pub attempts: u8,
    /// How far away the next one puts it, in thousandths of a stop on a straight.
    pub reach: u16,
    /// Attempts to find a nearer rest than the one found that have come to nothing.
    pub nearer: u8,
    /// Tries to come to other overrides that have come to nothing.
    pub retunes: u8,
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
        attempts: 0,
        reach: FIRST_REACH,
        nearer: 0,
        retunes: 0,
        refused: None,
        retuned: CycleSerial::ZERO,
        at: NodeSerial::ZERO,
    };

    /// An attempt has come to nothing; how far away the rest should have been.
    pub fn fail(&mut self, reach: Option<u16>) {
        // At least a twelfth further, and more from one to the next.
        let more = (self.reach / 12).saturating_mul(1 + u16::from(self.attempts) / 2);
        let further = self.reach.saturating_add(more);
        self.reach = reach.unwrap_or(0).max(further);
        self.attempts = self.attempts.saturating_add(1);
    }
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
    /// Where the motion is, and when an answer that takes as much work as a plan ahead over so many cells can
    /// take effect.
    pub(super) fn moment_after(&self, cells: usize) -> Option<Moment<S>> {
        let mut moment = self.moment()?;
        let work = (self.effort.cycles(cells) + S::of(0.5)).to_i64().clamp(0, 1_000_000) as u32;
        let least = self.side.cycles().plus(work);
        if moment.when.is_before(least) {
            moment.when = least;
        }
        Some(moment)
    }

    /// The same for a plan at other overrides, or to the end of a block, with the motion at node `at`.
    pub(super) fn moment_of_answer(&self, at: NodeSerial) -> Option<Moment<S>> {
        self.moment_after(PLANS * self.cells_ahead(at))
    }

    /// The same for an attempt to find a rest.
    pub(super) fn moment_of_attempt(&self) -> Option<Moment<S>> {
        self.moment_after(ATTEMPT_CELLS)
    }

    /// Begins a first answer if the whole one takes long and there is none yet. Whether one is in the making.
    pub(super) fn react(&mut self, asked: Asked, at: NodeSerial) -> bool {
        let long = self.effort.cycles(ATTEMPT_CELLS) > S::of(AT_ONCE);
        if !long || self.pressing.reacted == Some(asked) {
            return false;
        }
        self.pressing.reacted = Some(asked);
        let halt = self.phase.halt();
        let Some(moment) = self.moment_after(CELLS) else { return false };
        let begun = self.horizon.begin_reaction(moment, asked, halt);
        self.make((Purpose::Reaction(asked), at), begun)
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Begins a first answer. There is a draft afterwards only if there is one.
    fn begin_reaction(
        &mut self,
        moment: Moment<S>,
        asked: Asked,
        halt: Option<Halt>,
    ) -> Option<(Proposal, Stage<S>)> {
        self.draft(|draft| draft.reaction(moment, asked, halt))
    }

    fn reaction(
        &mut self,
        moment: Moment<S>,
        asked: Asked,
        halt: Option<Halt>,
    ) -> Option<(Proposal, Stage<S>)> {
        if let Asked::Overrides(overrides) = asked {
            self.try_overrides(overrides);
        }
        let (first, branch) = self.cut_in(moment)?;
        let mut stretch = self.stretch_from(first);
        let behind;
        (stretch.last, behind) = self.refine(first, stretch.last, self.braking_distance(first));
        if let Asked::Overrides(_) = asked {
            if self.is_stopping(first) {
                return None;
            }
            self.bound_from(first);
        }
        self.loosen(first, stretch.last);
        let aim = match asked {
            Asked::Hold => Aim::Halt,
            Asked::Overrides(_) if self.exceeds_goal(stretch) => Aim::Slow,
            Asked::Overrides(_) => Aim::Time,
        };
        // What was cut may break a limit by a rounding.
        let until = self.near(stretch, S::of(BRAKING_REACH)).max(behind).min(stretch.last);
        stretch.open = halt.is_none() && self.is_open(stretch);
        let solving = self.begin_improving_until(stretch, until, (STEPS, aim));
        let reacting = Stage::Reacting(Reacting { solving, until });
        Some((Proposal { stretch, branch, halt }, reacting))
    }

    /// Whether the motion ends where it does only because no more is known.
    pub(super) fn is_open(&mut self, stretch: Stretch) -> bool {
        let rests = self.window.get(stretch.last).is_some_and(|station| station.rest);
        // A plan that was made to rest at its end does so with all that the limits allow.
        let end = Stretch { first: stretch.last.saturating_sub(1), open: true, ..stretch };
        !rests && self.holds(end)
    }

    /// A slice of a first answer: one Newton step.
    pub fn go_on_reacting(&mut self, reacting: &mut Reacting<S>, proposal: Proposal) -> Flow {
        if self.go_on(&mut reacting.solving) {
            return Flow::Working;
        }
        let stretch = proposal.stretch;
        // It is a plan at the overrides that are in effect, though it is slower or faster.
        self.keep_overrides();
        self.loosen(stretch.first, stretch.last);
        if self.holds_until(stretch, reacting.until) { Flow::Ready } else { Flow::Nothing }
    }
}
