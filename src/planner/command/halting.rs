//! A rest on the path, as near as the limits allow: looked for slice by slice.
//!
//! An attempt is a draft of its own. The first ones put a rest at a distance and ask the solver for states that lead
//! there ([`Halting::Placing`], [`Halting::Resting`]): at first little more than what a stop on a straight would take from
//! anywhere on the motion as agreed, then as much further as the limits are exceeded by. After a few Newton steps that is
//! known. Where none of these attempts finds states, a stop of at most three phases of constant jerk is tried from every station of the agreed motion, then of one that brakes as hard as the limits
//! allow ([`Halting::Braking`]), and then a rest at the nodes of that.

use crate::machine::Config;
use crate::number::Scalar;
use crate::planner::horizon::stop_profile::{Depth, StopProfile};
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::making::Stage;
use crate::planner::phase::Halt;
use crate::profile::law::PathState;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::solving::Solving;

/// Distance of the first rest that is tried, in thousandths of what a stop on a straight would take.
pub const FIRST_REACH: u16 = 1_050;
/// There is none further than this.
const LAST_REACH: u16 = 5_000;
/// More than this use of a limit says no more about how much further it is to be.
const MOST_USED: f64 = 2.0;
/// Newton steps for one of them. Those that come to something take 10 to 14.
const STOP_STEPS: u16 = 20;
/// Steps after which so much of a limit may be used in states that will come to something.
const USED: [(u16, f64); 2] = [(7, 1.1), (11, 1.03)];
/// Attempts: those with the solver, one with stops from the agreed motion, one with stops from a motion that brakes.
pub const ATTEMPTS: u8 = STOPS + 2;
/// The attempt with stops from the agreed motion.
const STOPS: u8 = 6;
/// What is tried of the distance that is left to a rest which has been found, by attempts that have come to nothing.
const NEARER: [f64; 2] = [0.8, 0.9];
/// More than this of it is not worth the work.
const HARDLY_NEARER: f64 = 0.92;
/// A stop of fewer servo cycles is brief: it is looked for in closed form.
const BRIEF: f64 = 8.0;
/// The rest that the plan comes to anyway is taken if the shortest stop takes as long but for this factor and
/// so many servo cycles.
const LATER: f64 = 1.1;
const LATER_CYCLES: f64 = 3.0;
/// A rest is put into a cell only if it is this share of its length away from both ends.
const LEAST_PART: f64 = 0.08;
/// Braking distances over which a motion is made to brake.
pub const BRAKING_REACH: f64 = 1.3;

/// A rest that is being looked for.
#[derive(Clone, Copy, Debug)]
pub enum Halting<S> {
    /// The path is cut where the motion will be; a rest is to be put on it.
    Placing { attempt: u8, reach: u16 },
    /// States that lead there are being found.
    Resting { solving: Solving<S>, reach: u16 },
    /// Do they keep the limits?
    Checking { reach: u16 },
    /// States that brake as hard as the limits allow are being found.
    Braking(Solving<S>),
    /// Stops in closed form further than `nearest` are tried; whether the motion has been made to brake.
    Stopping { nearest: S, tries: u8, braked: bool },
    /// Rests at nodes from `next` on are tried.
    Ending { next: usize, tries: u8 },
}

/// What a slice of an answer has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// There is more to do.
    Working,
    /// The proposal can be handed over.
    Ready,
    /// There is none.
    Nothing,
    /// There is none; in the next attempt the rest is to be so far away, in thousandths of a stop on a straight.
    Further(u16),
}

/// What one try has come to.
#[derive(Clone, Copy, Debug)]
pub enum Tried {
    /// The motion comes to rest at the end of this stretch.
    Rests(Stretch),
    /// A limit is broken; there may be another.
    Fails,
    /// There is no other.
    Exhausted,
}

/// What the beginning of an attempt has come to.
#[derive(Clone, Copy, Debug)]
pub enum Begun<S> {
    /// It is under way, in a draft.
    Attempt((Proposal, Stage<S>)),
    /// The motion as agreed comes to rest hardly later.
    Soon,
    /// The motion cannot be cut there.
    Nothing,
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Begins to look for a rest. There is a draft afterwards only if there is an attempt.
    pub(super) fn begin_halt(
        &mut self,
        moment: Option<Moment<S>>,
        (attempt, reach): (u8, u16),
    ) -> Begun<S> {
        let mut soon = false;
        let begun = self.draft(|draft| {
            let (stretch, branch) = draft.prepare(moment?)?;
            let least = draft.straight_stop(stretch.first);
            soon = least.as_ref().is_some_and(|stop| draft.rests_soon(stretch, stop.time()));
            if soon {
                return None;
            }
            let brief = least.is_none_or(|stop| draft.is_brief(&stop));
            let attempt = if brief || reach > LAST_REACH { attempt.max(STOPS) } else { attempt };
            let proposal = Proposal { stretch, branch, halt: Some(Halt::Hold) };
            Some((proposal, Stage::Halting(Halting::Placing { attempt, reach })))
        });
        match begun {
            Some(begun) => Begun::Attempt(begun),
            None if soon => Begun::Soon,
            None => Begun::Nothing,
        }
    }

    /// Begins to look for a rest nearer than the one that the agreed motion comes to, if there may be one that is much
    /// nearer. There is a draft afterwards only if there is an attempt.
    pub(super) fn begin_nearer(
        &mut self,
        moment: Option<Moment<S>>,
        failures: u8,
    ) -> Option<(Proposal, Stage<S>)> {
        let share = NEARER.get(usize::from(failures))?;
        self.draft(|draft| draft.nearer(moment?, S::of(*share)))
    }

    fn nearer(&mut self, moment: Moment<S>, share: S) -> Option<(Proposal, Stage<S>)> {
        let (stretch, branch) = self.prepare(moment)?;
        let mut left = S::ZERO;
        for i in stretch.first..stretch.last {
            left += self.window.get(i)?.cell.length;
        }
        let least = self.least_reach(stretch)?;
        let reach = (left * share).greatest(least * S::of(f64::from(FIRST_REACH) * 1.0e-3));
        if reach > left * S::of(HARDLY_NEARER) {
            return None;
        }
        let held = self.put_rest(stretch, reach)?;
        let solving = self.begin_resting(held, STOP_STEPS);
        let proposal = Proposal { stretch: held, branch, halt: Some(Halt::Hold) };
        Some((proposal, Stage::Halting(Halting::Resting { solving, reach: LAST_REACH })))
    }

    /// Whether a stop is brief: its phases are hardly longer than servo cycles.
    pub(super) fn is_brief(&self, stop: &StopProfile<S>) -> bool {
        stop.time() < self.config.cycle * S::of(BRIEF)
    }

    /// The stop from a station as if the path were straight from there on.
    fn straight_stop(&self, i: usize) -> Option<StopProfile<S>> {
        StopProfile::new(self.window.get(i)?, S::ZERO, Depth::Limits, S::ONE)
    }

    /// Whether the motion as agreed comes to rest hardly later than a stop that takes `least` seconds.
    fn rests_soon(&self, stretch: Stretch, least: S) -> bool {
        let most = (least + self.config.cycle * S::of(LATER_CYCLES)) * S::of(LATER);
        let mut agreed = S::ZERO;
        for i in stretch.first..stretch.last {
            agreed += self.agreed_time(i);
            if agreed > most {
                return false;
            }
        }
        true
    }

    /// The distance, mm, at which the motion could come to rest if the path were straight from some station on.
    fn least_reach(&self, stretch: Stretch) -> Option<S> {
        let mut least: Option<S> = None;
        let mut distance = S::ZERO;
        for i in stretch.first..stretch.last {
            let station = self.window.get(i)?;
            if least.is_some_and(|least| distance > least) {
                break;
            }
            if let Some(stop) = StopProfile::new(station, distance, Depth::Limits, S::ONE) {
                least = Some(least.map_or(stop.at, |least| least.least(stop.at)));
            }
            distance += station.cell.length;
        }
        least
    }

    /// Puts a rest on the path, `reach` mm behind the first station of the stretch or a little further. Returns the
    /// stretch up to there; `None` if the motion comes to rest there anyway, or if there is no room.
    fn put_rest(&mut self, stretch: Stretch, reach: S) -> Option<Stretch> {
        let mut distance = S::ZERO;
        for i in stretch.first..stretch.last {
            let station = self.window.get(i)?;
            let (length, apart) = (station.cell.length, self.apart(station.bounds.jerk));
            let margin = apart.greatest(length * S::of(LEAST_PART));
            let place = (reach - distance).greatest(margin);
            let end = i + 1;
            if place + margin <= length {
                self.insert(i, place / length, PathState::REST)?;
                return Some(Stretch { last: end, open: false, ..stretch });
            }
            if reach <= distance + length + margin && end > stretch.first + 1 {
                // Hardly nearer than the node at the end of the cell.
                self.window.set_state(end, PathState::REST);
                return (end < stretch.last).then_some(Stretch {
                    last: end,
                    open: false,
                    ..stretch
                });
            }
            distance += length;
        }
        None
    }

    /// A slice of looking for a rest: one Newton step, or one try.
    pub fn go_on_halting(&mut self, halting: &mut Halting<S>, proposal: &mut Proposal) -> Flow {
        let stretch = proposal.stretch;
        *halting = match halting {
            Halting::Placing { attempt, reach } if *attempt < STOPS => {
                let reach = *reach;
                let share = S::from_u32(u32::from(reach)) * S::of(1.0e-3);
                let held = self
                    .least_reach(stretch)
                    .and_then(|least| self.put_rest(stretch, least * share));
                let Some(held) = held else { return Flow::Further(u16::MAX) };
                proposal.stretch = held;
                Halting::Resting { solving: self.begin_resting(held, STOP_STEPS), reach }
            }
            Halting::Placing { attempt, .. } if *attempt == STOPS => {
                Halting::Stopping { nearest: S::ZERO, tries: 0, braked: false }
            }
            Halting::Placing { .. } => {
                let near = self.near(stretch, S::of(BRAKING_REACH));
                let Config { iterations, .. } = self.config;
                Halting::Braking(self.begin_improving_until(stretch, near, (iterations, Aim::Halt)))
            }
            Halting::Resting { solving, reach } => {
                let before = solving.left();
                let goes_on = self.go_on(solving);
                let taken = STOP_STEPS.saturating_sub(solving.left());
                let most = USED.iter().find(|(steps, _)| taken == *steps);
                // Between two steps: a problem that is looked at within one begins it again.
                if goes_on
                    && solving.left() < before
                    && let Some((_, most)) = most
                    && self.most_used(stretch) > S::of(*most)
                {
                    return self.further(stretch, *reach);
                }
                if goes_on {
                    return Flow::Working;
                }
                Halting::Checking { reach: *reach }
            }
            Halting::Checking { reach } => {
                let runs = self.holds(stretch) && self.crawl_in(stretch).is_none();
                return if runs { Flow::Ready } else { self.further(stretch, *reach) };
            }
            Halting::Braking(solving) => {
                if self.go_on(solving) {
                    return Flow::Working;
                }
                Halting::Stopping { nearest: S::ZERO, tries: 0, braked: true }
            }
            Halting::Stopping { nearest, tries, braked } => {
                match self.try_stop(stretch, nearest, tries) {
                    Tried::Rests(held) => {
                        proposal.stretch = held;
                        return Flow::Ready;
                    }
                    Tried::Fails => return Flow::Working,
                    Tried::Exhausted if *braked => {
                        Halting::Ending { next: stretch.first + 1, tries: 0 }
                    }
                    Tried::Exhausted => return Flow::Nothing,
                }
            }
            Halting::Ending { next, tries } => match self.try_rest_at(stretch, next, tries) {
                Tried::Rests(held) => {
                    proposal.stretch = held;
                    return Flow::Ready;
                }
                Tried::Fails => return Flow::Working,
                Tried::Exhausted => return Flow::Nothing,
            },
        };
        Flow::Working
    }

    /// Where to look for a rest after states that lead to one at `reach` exceed a limit: braking half as hard takes twice
    /// the distance, and a little more.
    fn further(&mut self, stretch: Stretch, reach: u16) -> Flow {
        let used = self.most_used(stretch).least(S::of(MOST_USED));
        let factor = used * used.sqrt().sqrt();
        let next = S::from_u32(u32::from(reach)) * factor;
        Flow::Further(next.to_i64().clamp(0, i64::from(u16::MAX)) as u16)
    }

    /// The station by which so many braking distances from the first one of a stretch have been run.
    pub(super) fn near(&self, stretch: Stretch, reach: S) -> usize {
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
