//! Answers to an operator's commands.
//!
//! What a command means to a user, when it ends and which one wins is in the table of [`Controls`](crate::Controls). This is
//! what the planner does about each, in the order in which [`obey`](Planner::obey) looks at them: the first that
//! has something to do wins.
//!
//! | asked for | at rest | in motion | with a plan on offer |
//! |---|---|---|---|
//! | abort | everything is dropped (`drop_all`), [`Progress::Aborted`] until acknowledged | as a hold | as a hold |
//! | hold, or an override of 0 | [`Progress::Held`] | [`brake`]: a plan that rests as soon as the limits allow, or the first and the next stage of it; none if the plan under way already does | it is withdrawn first, or waited for if it branches off at one of the next servo cycles |
//! | a halt no longer wanted | - | the plan is taken further at once; from its rest where that comes anyway and lower overrides are asked for | - |
//! | lower overrides | in effect at once | [`easing`], or [`falling`] in stages: the motion slows down as soon as the limits allow; then [`retune`] from where it has, and again where that falls short | as for a hold, but one from a servo cycle within a lead is waited for |
//! | higher overrides | in effect at once | [`retune`]: a plan at the new pace from the next servo cycle on, or from a node that is near | the same |
//! | stop, single block | held; in single block mode after every block, until a resume | [`block_end`]: a plan that rests at the end of a block; none but a halt where the plan rests there anyway. If none is found, or too late: [`brake`], and from rest on to the end of the block | withdrawn if the motion rests there before it, or no rest has been looked for, else waited for |
//! | resume | ends the rest at a pause or in single block mode; a hold or a stop it has ended at the source | - | - |
//!
//! # How an answer takes effect
//!
//! By a plan that branches off where the motion will be at the end of a
//! servo cycle, so the answer shows in the cycle after it. The cell under way is cut there: what is
//! left of it starts at the very position, velocity and acceleration that the piece under way has
//! at that moment, so the motion as planned before is a valid start for the solver, and the new
//! plan joins without a step in any derivative up to the second. A hold is a march from there on ([`slowing`]), in stages where planning takes
//! time ([`stages`]), and so is the first answer to a lowered override ([`easing`], [`falling`]); for the others
//! the cells within the distance that it takes to stop are cut finer, and the solver finds the states ([`retune`],
//! [`block_end`]). Then the plan is offered. How many
//! servo cycles ahead it branches off is what plans have taken so far ([`super::effort`]). If the interrupt
//! has passed that cycle meanwhile, it refuses; then everything is as it was before and the
//! next attempt allows more cycles.
//!
//! An override has a first answer and a whole one. A lowered one is answered by a clock that slows down ([`easing`]), which takes a few slices
//! and no solver. Where planning takes long, one that is raised is, by a few steps for [`Aim::Time`] over the path that is near
//! ([`reaction`]); for [`Aim::Slow`] where no clock does. From then on the motion does what is asked for, and the whole answer branches
//! off from that; it is owed until it has been taken, whatever is asked for by then. It leaves the motion as it is until that has come down.
//!
//! [`Aim::Slow`]: crate::profile::solver::Aim::Slow
//! [`Aim::Time`]: crate::profile::solver::Aim::Time

pub mod block_end;
mod brake;
pub mod easing;
pub mod falling;
pub mod reaction;
pub mod retune;
pub mod slowing;
pub mod stages;
#[cfg(test)]
mod tests;

use self::reaction::Pressing;
use super::phase::{Following, Halt, Offer, Phase, Rest};
use super::{Planner, Progress};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::servo::control::{Overrides, Wish};

/// Servo cycles within which a plan on offer must be decided on for a hold to wait for that.
const SOON: u32 = 2;

/// What a slice of an answer has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// There is more to do.
    Working,
    /// The proposal can be handed over.
    Ready,
    /// There is none.
    Nothing,
}

/// What is to be done about what an operator asks for.
#[derive(Clone, Copy, Debug)]
enum Answer {
    /// Nothing that would keep the planner from going on.
    Nothing,
    /// It is being done, or waits: nothing else is to be done in this call.
    Says(Progress),
    /// The motion is to come to rest as soon as it can, by the stop limits or not.
    Brake { quick: bool, halt: Halt },
    /// A rest at the end of a block is to be looked for.
    BlockEnd,
}

impl From<Option<Progress>> for Answer {
    fn from(progress: Option<Progress>) -> Self {
        progress.map_or(Self::Nothing, Self::Says)
    }
}

/// Numbers of the commands that have been answered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answered {
    /// The last resume seen.
    pub resumes: u32,
    /// The last abort that has been acknowledged.
    pub aborts: u32,
    /// The last stop by the stop limits that is over.
    pub quick: u32,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Does what is asked for, with the motion at node `at`. `Some` if there is nothing else to do in this call.
    pub(super) fn obey(&mut self, wish: &Wish, at: NodeSerial) -> Option<Progress> {
        match self.look(wish, at) {
            Answer::Nothing => None,
            Answer::Says(progress) => Some(progress),
            Answer::BlockEnd => self.rest_at_block_end(at).then_some(Progress::Planning),
            Answer::Brake { quick, halt } => {
                let planned = self.brake(at, quick, halt);
                // If it could not be done at once: the plan is not taken further, and ends at rest.
                Some(if planned { Progress::Planning } else { Progress::Waiting })
            }
        }
    }

    /// What there is to be done, and all of it but that: what it needs of the stack is not added to what a stop needs.
    #[inline(never)]
    fn look(&mut self, wish: &Wish, at: NodeSerial) -> Answer {
        let resumed = wish.resumes != self.answered.resumes;
        self.answered.resumes = wish.resumes;
        let brakes = self.brakes(wish);
        let paced = self.horizon.is_paced(wish.overrides);
        let (rests, lead) = (at == self.horizon.end(), self.most_reaction());
        if brakes || !wish.stops_at_end() {
            self.pressing.short = false;
        }
        let stays = wish.stop && !self.pressing.short;
        if rests && (brakes || stays || !paced) {
            // A start that has not been taken up.
            self.revoke(lead);
        }
        if self.phase.offer().is_none() && at == self.horizon.end() {
            return self.obey_at_rest(wish, resumed).into();
        }
        if !brakes {
            self.pressing.anew = 0;
            self.answered.quick = wish.quick;
            if !self.pressing.short {
                self.pressing.attempts = 0;
            }
        }
        if paced {
            let Pressing { retunes, short_falls, refused, falls, easings, .. } = &mut self.pressing;
            (*retunes, *short_falls, *refused, *falls, *easings) = (0, 0, None, 0, 0);
        }
        let stands = |asked: &Overrides| !brakes && *asked == wish.overrides;
        if self.pressing.reacted.is_some_and(|asked| !stands(&asked)) {
            (self.pressing.reacted, self.pressing.falls) = (None, 0);
        }
        self.pressing.eased = self.pressing.eased.filter(stands);
        if brakes {
            let slows = self.phase.halt() == Some(Halt::Slowing);
            let answered = self.phase.halt() == Some(Halt::Hold);
            if (answered || (slows && self.phase.offer().is_some())) && !self.may_stop_sooner(at) {
                return Answer::Says(Progress::Waiting);
            }
            let quick = wish.quick != self.answered.quick;
            if !self.revoke(SOON) {
                return Answer::Says(Progress::Waiting);
            }
            return Answer::Brake { quick, halt: Halt::Hold };
        }
        let short = self.pressing.short;
        if let Phase::Following(now) = &mut self.phase
            && let Some(halt) = now.halt.filter(|halt| !halt.is_wanted(wish, short))
        {
            now.go_on(at);
            if halt == Halt::Slowing {
                self.horizon.owe_pace(at);
            }
        }
        let halts = matches!(self.phase.halt(), Some(Halt::Short | Halt::Slowing));
        if wish.stops_at_end() && (halts || self.pressing.short) {
            // Other overrides are for what comes behind the rest.
            return self.obey_stop(at);
        }
        let paced = self.horizon.is_paced(wish.overrides);
        let stays = |offer: &Offer| offer.before.is_some() && offer.taken.halt == Some(Halt::Block);
        if self.phase.offer().is_some_and(stays) && !wish.stops_at_end() {
            self.revoke(lead);
        }
        // A first answer on offer comes before the whole one.
        let begins = self.phase.offer().is_some_and(|offer| offer.begins)
            && self.pressing.reacted == Some(wish.overrides);
        if !paced
            && !begins
            && !self.is_refused(wish.overrides, at)
            && self.revoke(lead)
            && self.retune(wish.overrides, at)
        {
            return Answer::Says(Progress::Planning);
        }
        if wish.stops_at_end() { self.obey_stop(at) } else { Answer::Nothing }
    }

    /// Whether the motion is to come to rest as soon as it can: a hold, or an abort that has not been acknowledged.
    pub(super) fn brakes(&self, wish: &Wish) -> bool {
        wish.holds() || wish.aborts != self.answered.aborts
    }

    /// Whether a rest at the end of a block is to be looked for before anything is planned ahead. (Of a start that has not been taken up: for a stop
    /// only.)
    pub(super) fn looks_for_block_end(&self, wish: &Wish, at: NodeSerial) -> bool {
        if at == self.horizon.end() {
            return wish.stop && !self.pressing.short;
        }
        let Phase::Following(now) = self.phase else { return false };
        let in_vain = now.halt.is_some() || now.tried_block_end || self.horizon.stands(at);
        wish.stops_at_end() && !in_vain && self.horizon.agreed_block_end(at).is_none()
    }

    /// In motion: rests at the end of a block, as a stop or single block mode asks for.
    fn obey_stop(&mut self, at: NodeSerial) -> Answer {
        // A plan on offer that would leave the present one behind the rest that is asked for; or one in which no rest has been looked for:
        // the ends of blocks before it is taken up would be passed.
        let rest = self.horizon.agreed_block_end(at);
        let leaves = |offer: &Offer| match rest {
            Some(rest) => !offer.first.is_before(rest),
            None => offer.before.is_some_and(|before| !before.tried_block_end),
        };
        let goes_on = |offer: &Offer| offer.taken.halt.is_none() && leaves(offer);
        if self.phase.offer().is_some_and(goes_on) && (rest.is_some() || self.sees_block_end(at)) {
            let asked = self.horizon.overrides();
            self.revoke(self.most_reaction());
            if !self.horizon.is_paced(asked) {
                // A whole answer to other overrides: it waits until the motion has come farther, or both would be made for ever.
                self.refuse(asked, at);
            }
        }
        let Phase::Following(now) = &mut self.phase else { return Answer::Nothing };
        let halt = now.halt;
        match halt {
            Some(Halt::Block) => {
                // Up to the end of a block other overrides count.
                self.pressing.short = false;
                return Answer::Says(Progress::Waiting);
            }
            Some(Halt::Short) => return Answer::Says(Progress::Waiting),
            _ => {}
        }
        let planned = if self.horizon.stands(at) {
            self.rest_next(Halt::Block)
        } else if halt.is_none()
            && let Some(rest) = self.horizon.agreed_block_end(at)
        {
            let planned = self.rest_there(rest, Halt::Block);
            if self.phase.halt() == Some(Halt::Block) {
                return Answer::Says(Progress::Waiting);
            }
            planned
        } else if self.pressing.short {
            return Answer::Brake { quick: false, halt: Halt::Short };
        } else if now.tried_block_end {
            false
        } else {
            now.tried_block_end = true;
            return Answer::BlockEnd;
        };
        planned.then_some(Progress::Planning).into()
    }

    /// At rest: whether to go on.
    fn obey_at_rest(&mut self, wish: &Wish, resumed: bool) -> Option<Progress> {
        self.answered.quick = wish.quick;
        let end = self.horizon.end_index();
        // From a rest within a block, whatever it came from, a stop goes on to the end of that.
        self.pressing.short = wish.stop && !wish.holds() && self.rests_within_block();
        #[cfg(feature = "shaping")]
        if let Phase::Following(_) = self.phase {
            self.rested = self.side.cycles();
        }
        let (mut rest, ended) = match self.phase {
            // A plan may end with a block by itself, where no more was known in time.
            Phase::Following(Following { halt: None | Some(Halt::Slowing), .. }) => {
                (Rest::IDLE, self.horizon.ends_block(end))
            }
            Phase::Following(Following { halt, .. }) => (Rest::IDLE, halt == Some(Halt::Block)),
            Phase::Resting(rest) => (rest, false),
            Phase::Offered(_) => {
                debug_assert!(false, "a start is on offer");
                return None;
            }
        };
        if wish.aborts != self.answered.aborts {
            if rest != (Rest::Dropped { abort: wish.aborts }) {
                self.drop_all();
            }
            self.phase = Phase::Resting(Rest::Dropped { abort: wish.aborts });
            return Some(self.settled(Progress::Aborted));
        }
        if !self.horizon.is_paced(wish.overrides) {
            self.horizon.set_overrides(wish.overrides);
        }
        let station = self.horizon.window.get_mut(end);
        let pauses = station.is_some_and(|end| core::mem::take(&mut end.pause));
        if pauses || (wish.single && ended) {
            // A resume that was pressed before the machine rested was not meant for it; one since then was, though nobody has looked.
            let pressed = wish.resumes != self.requests.resumes_before_rest();
            rest = if pressed { Rest::IDLE } else { Rest::AwaitsResume };
        } else if resumed && rest == Rest::AwaitsResume {
            rest = Rest::IDLE;
        }
        self.phase = Phase::Resting(rest);
        let held =
            wish.holds() || (wish.stop && !self.pressing.short) || rest == Rest::AwaitsResume;
        held.then(|| self.settled(Progress::Held))
    }

    /// At rest: whether a block is under way, and more of it is known.
    #[inline(never)]
    fn rests_within_block(&self) -> bool {
        let window = &self.horizon.window;
        let end = self.horizon.end_index();
        let is_more = self.builder.len() > 0 || end + 1 < window.len();
        is_more && window.ends_block(end) == Some(false)
    }

    /// What is to be said of a rest: it is none before what follows the setpoints rests too.
    fn settled(&self, progress: Progress) -> Progress {
        if self.has_settled() { progress } else { Progress::Waiting }
    }

    /// At rest: forgets everything that has not been run.
    fn drop_all(&mut self) {
        let end = self.horizon.end_index();
        self.horizon.window.truncate(end);
        #[cfg(feature = "limits")]
        let newest = self.horizon.older.newest();
        if let Some(station) = self.horizon.window.last_mut() {
            self.builder.restart(station.node.at);
            // What was dropped leaves no limits in use but the newest.
            #[cfg(feature = "limits")]
            {
                station.cell.programmed.limits = newest;
            }
        }
        #[cfg(feature = "outputs")]
        self.drop_switches();
        #[cfg(feature = "reshape")]
        if let Some(memory) = self.reshaping.as_deref_mut() {
            memory.clear();
        }
        self.finished = false;
        self.pressing.short = false;
    }
}
