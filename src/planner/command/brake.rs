//! Coming to rest on the path as soon as the limits allow.

use super::reaction::Pressing;
use super::slowing::{ATTEMPTS, Begun, Goal};
use super::stages::{SLICES, Start};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::effort::Work;
use crate::planner::horizon::Proposal;
use crate::planner::making::Purpose;
use crate::planner::phase::{Halt, Phase};
use crate::profile::solver::Stretch;
use crate::servo::link::Branch;

/// Calls that wait for a stop from which it is told how often they come.
const WAITS: u8 = 8;
/// A stop is made anew if there is so many times as long until it as making one takes.
const SOONER: f64 = 2.0;
/// How often that is done for one command.
const ANEW: u8 = 3;
/// Slices in which a standstill is cut short.
const STANDSTILL: usize = 2;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// A plan that comes to rest as soon as the limits allow, or the stop limits. Whether there is one.
    #[inline(never)]
    pub(super) fn brake(&mut self, at: NodeSerial, quick: bool, halt: Halt) -> bool {
        let stands = self.horizon.stands(at);
        if stands {
            let moment = self.moment_after(self.effort.stop.usual(STANDSTILL));
            let made = self.horizon.draft(|draft| {
                let (stretch, branch) = draft.cut_dwell(moment?)?;
                Some(Proposal { stretch, branch, halt: Some(halt) })
            });
            return self.propose(Purpose::Hold, made) || self.rest_next(halt);
        }
        if self.horizon.slows_to_rest(at) {
            return self.rest_as_agreed(halt);
        }
        let handover = self.horizon.handover(at);
        if self.horizon.is_slowed(at) && handover.is_none() {
            // Until the clock goes evenly.
            return false;
        }
        let now = self.side.cycles();
        if usize::from(self.pressing.attempts) >= ATTEMPTS {
            // As long as nothing is known that could change it, no more.
            if self.pressing.attempted == now {
                return self.rest_next(halt);
            }
            self.pressing.attempts = 0;
        }
        if self.pressing.attempts == 0 {
            self.pressing.attempted = now;
        }
        let (needed, staging) = self.stage_of_stop(handover, at);
        let start = self.start_of_stage(handover, needed);
        (self.pressing.reckoned, self.pressing.waits) = (needed.to_i64() as u32, 0);
        let soon = needed <= S::from_u32(self.near());
        if let Start::Moment(Some(moment)) = start
            && self.horizon.rests_before(moment)
        {
            return self.rest_as_agreed(halt);
        }
        let begun = self.horizon.begin_slowing(
            start,
            (self.pressing.attempts, quick),
            Goal::Rest(halt),
            staging,
        );
        if !soon && !matches!(begun, Begun::Attempt(_)) {
            // What planning has taken leads beyond the end of the plan. Perhaps the background was late, and is in time again.
            self.effort.stop = Work::NONE;
        }
        match begun {
            Begun::Attempt(begun) => self.make((Purpose::Hold, at), Some(begun)),
            // The rest that the plan comes to anyway may be nearer than any other.
            Begun::Soon => self.rest_as_agreed(halt),
            Begun::Nothing => self.rest_next(halt),
        }
    }

    /// Whether the stop that is waited for is so far off only because planning used to take long, as calls that wait for it tell: they come so much
    /// more often than slices did that another can be made before. (A few times: a background that is late and in time by turns must not put it off for ever.)
    #[inline(never)]
    pub(super) fn may_stop_sooner(&mut self, at: NodeSerial) -> bool {
        let now = self.side.cycles();
        let Pressing { waits, waiting, .. } = &mut self.pressing;
        if *waits == 0 {
            *waiting = now;
        }
        *waits += 1;
        if *waits <= WAITS {
            return false;
        }
        *waits = 0;
        let mut work = Work::<S>::NONE;
        work.learn(usize::from(WAITS), now.since(*waiting).unwrap_or(0));
        let needed = (work.usual(SLICES) * S::of(SOONER)).to_i64() as u32;
        // A dwell is cut short at once.
        let needed = if self.horizon.stands(at) { needed } else { needed + self.near() };
        let is_far = self.phase.offer().is_none_or(|offer| !offer.by_cycle)
            || self.side.undecided_for() > needed;
        if self.pressing.reckoned <= needed || !is_far || self.pressing.anew >= ANEW {
            return false;
        }
        self.pressing.anew += 1;
        (self.pressing.reckoned, self.pressing.attempts) = (0, 0);
        (self.knows_stops, self.effort.stop) = (true, work);
        if let Phase::Following(now) = &mut self.phase {
            now.halt = None;
        }
        true
    }

    /// If the motion comes to rest at the end of the piece under way, lets it stay there.
    pub(super) fn rest_next(&mut self, halt: Halt) -> bool {
        let (at, end) = (self.side.progress(), self.horizon.end());
        if at == end {
            return false;
        }
        let next = at.next();
        let i = self.horizon.window.clamped_index(next);
        if halt == Halt::Block && !self.horizon.ends_block(i) {
            return false;
        }
        let rests = self.horizon.window.get(i).is_some_and(|station| station.rest);
        (rests || next == end) && self.rest_there(next, halt)
    }

    /// Lets the motion stay at the next rest of the plan.
    fn rest_as_agreed(&mut self, halt: Halt) -> bool {
        let at = self.side.progress();
        let window = &self.horizon.window;
        let last = self.horizon.stretch_from(window.clamped_index(at)).last;
        let rest = window.serial(last);
        at != self.horizon.end() && self.rest_there(rest, halt)
    }

    /// Lets the motion stay at a node at which it rests; whether a plan was made for it.
    pub(super) fn rest_there(&mut self, node: NodeSerial, halt: Halt) -> bool {
        let i = self.horizon.window.clamped_index(node);
        let halt = self.horizon.halt_at(i, halt);
        if node == self.horizon.end() {
            if let Phase::Following(now) = &mut self.phase {
                now.rest_at_end(halt);
            }
            return false;
        }
        let stretch = Stretch { first: i, last: i, open: false };
        let purpose = match halt {
            Halt::Hold | Halt::Slowing | Halt::Short => Purpose::Hold,
            Halt::Block => Purpose::BlockEnd,
        };
        let branch = Branch::Node(node);
        let made = self.horizon.draft(|_| Some(Proposal { stretch, branch, halt: Some(halt) }));
        self.propose(purpose, made)
    }
}
