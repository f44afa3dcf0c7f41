//! A plan in the making: what is kept of it between two slices of the planner's work.
//!
//! ```text
//!   Ahead:   Solving ──┬───────────────────────────▶ Publishing ──▶ offered
//!               ▲      │ beyond a limit                  ▲
//!               │      ▼                                 │
//!               └── Seeding                              │
//!   Hold:       Slowing (its pieces as they are found) ───┼─▶ offered
//!                  └─ (a stage of it, the rest evenly) ──▶│
//!   Overrides:  Retuning ────────────────────────────────▶│
//!   Falling:    Slowing, as a stage of a stop ───────────▶ offered
//!   Easing:     Easing ──────────────────────────────────▶│
//!   Reaction:   Reacting ────────────────────────────────▶│
//!   BlockEnd:   Ending ───────────────────────────────────┘
//!   Shape:      Shaping ──▶ Reshaped ─────────────────────▶ offered
//! ```
//!
//! With memory for reshaping a plan ahead does not go on to Publishing at once: windows of it, and of what is agreed before it, are shaped
//! first (Shaping, Reshaped), and while none can be it waits, as long as it may (`may_ripen`).
//!
//! What it has changed lies in the horizon as a draft ([`super::horizon`]), so it can be dropped after any slice: by
//! a command that it does not serve, or because the motion has passed the place where it would have branched off.

use super::command::Flow;
use super::command::block_end::Ending;
use super::command::easing::Easing;
use super::command::reaction::{self, Reacting};
use super::command::retune::Retuning;
use super::command::slowing::Slowing;
use super::command::stages::Marched;
use super::effort::{Effort, SLOWER, Work};
use super::horizon::{Horizon, Proposal};
use super::phase::{Halt, Phase};
#[cfg(feature = "reshape")]
use super::reshaping::Shaping;
use super::{Planner, Progress};
use crate::number::Scalar;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::profile::seeding::Seeding;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::solving::Solving;
use crate::servo::control::{Overrides, Wish};
use crate::servo::link::{Branch, Room};
use crate::servo::piece::Slower;
use core::ops::{ControlFlow, Range};

/// Leads before its branch at which a plan that waits is handed over.
#[cfg(feature = "reshape")]
const RIPE_LEADS: f64 = 3.0;
/// Leads within which an answer takes effect soon.
const NEAR_LEADS: u32 = 4;
/// Pieces that are handed over in one slice.
pub const PIECES: usize = 48;

/// What a plan is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To go on as far as is known.
    Ahead,
    /// To come to rest.
    Hold,
    /// To go on at other overrides.
    Overrides,
    /// To come to rest at the end of a block.
    BlockEnd,
    /// To slow down to what is asked for.
    Easing(Overrides),
    /// The same, a stage of it.
    Falling(Overrides),
    /// To begin with what is asked for.
    Reaction(Overrides),
    /// To make the agreed motion faster.
    #[cfg(feature = "reshape")]
    Shape,
}

/// A plan in the making.
#[derive(Clone, Copy, Debug)]
pub struct Making<S> {
    pub purpose: Purpose,
    proposal: Proposal,
    /// Servo cycle in which it was begun, and where the motion was.
    began: CycleSerial,
    at: NodeSerial,
    /// Slices so far.
    slices: u16,
    /// Whether its states have been found for long, and it waits until more of it can be reshaped.
    #[cfg(feature = "reshape")]
    ripe: bool,
    stage: Stage<S>,
}

/// What the next slice does.
#[derive(Clone, Copy, Debug)]
pub enum Stage<S> {
    /// A Newton step; the states from station `guessed` on began as a guess, or all as slow seeds.
    /// When none is left: are all limits kept?
    Solving { solving: Solving<S>, guessed: Option<usize> },
    /// A try for slow states that keep them, where the guess has led to none.
    Seeding(Seeding<S>),
    /// Some steps of a clock that slows down, which are handed over.
    Slowing(Slowing<S>),
    /// Some steps of a clock that slows down to a rate.
    Easing(Easing<S>),
    /// A slice of looking for a rest at the end of a block.
    Ending(Ending<S>),
    /// A slice of a first answer to a command.
    Reacting(Reacting<S>),
    /// A slice of a plan at other overrides.
    Retuning(Retuning<S>),
    /// Pieces from this station on are handed over.
    Publishing { next: usize },
    /// A window of it is reshaped.
    #[cfg(feature = "reshape")]
    Shaping(Shaping<S>),
    /// Pieces of the agreed plan with stations replaced are handed over, from this one on.
    #[cfg(feature = "reshape")]
    Reshaped { next: usize },
}

impl<S> Stage<S> {
    /// The states of a proposal are found.
    pub const fn publishing(proposal: &Proposal) -> Self {
        Self::Publishing { next: proposal.stretch.first }
    }
}

/// Why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Failure {
    /// The motion would crawl through the cell of this station: it is better to rest first, or to start from cells that are
    /// less unequal.
    Crawl(usize),
    /// No motion within the limits was found.
    Stuck,
    /// A command has not been answered by it.
    Unanswered,
}

impl<S: Scalar> Making<S> {
    /// Whether a window of it is being reshaped.
    #[cfg(feature = "reshape")]
    pub(super) fn is_shaping(&self) -> bool {
        matches!(self.stage, Stage::Shaping(_))
    }

    /// Whether its states are found, and nothing has been handed over.
    #[cfg(feature = "reshape")]
    fn stage_begins(&self) -> bool {
        matches!(self.stage, Stage::Publishing { next } if next == self.proposal.stretch.first)
    }

    /// A slice of looking for states, in the room for the plan; `Publishing` is the planner's.
    // By itself: what it needs of the stack is not added to what a stop needs that is handed over piece by piece.
    #[inline(never)]
    fn step<const N: usize, const NODES: usize>(
        &mut self,
        horizon: &mut Horizon<S, N, NODES>,
        room: Room<'_, S, N>,
    ) -> ControlFlow<Failure> {
        let flow = match &mut self.stage {
            Stage::Ending(ending) => horizon.go_on_ending(ending, &mut self.proposal, room),
            Stage::Easing(easing) => horizon.go_on_easing(easing, &mut self.proposal),
            Stage::Reacting(reacting) => horizon.go_on_reacting(reacting, self.proposal, room),
            Stage::Retuning(retuning) => horizon.go_on_retuning(retuning, &mut self.proposal, room),
            _ => return self.step_ahead(horizon, room),
        };
        match flow {
            Flow::Working => {}
            Flow::Ready => self.stage = Stage::publishing(&self.proposal),
            Flow::Nothing => return ControlFlow::Break(Failure::Unanswered),
        }
        ControlFlow::Continue(())
    }

    /// The same for what lies ahead.
    fn step_ahead<const N: usize, const NODES: usize>(
        &mut self,
        horizon: &mut Horizon<S, N, NODES>,
        room: Room<'_, S, N>,
    ) -> ControlFlow<Failure> {
        let stretch = self.proposal.stretch;
        self.stage = match &mut self.stage {
            Stage::Solving { solving, guessed } => {
                if horizon.go_on(solving, room) {
                    return ControlFlow::Continue(());
                }
                if horizon.holds(stretch) {
                    let goes_on = self.proposal.branch != Branch::Node(horizon.end());
                    if let Some(crawl) = horizon.crawl_in(stretch)
                        && (goes_on || horizon.eases_crawl(stretch, crawl))
                    {
                        return ControlFlow::Break(Failure::Crawl(crawl));
                    }
                    Stage::publishing(&self.proposal)
                } else if let Some(new) = *guessed {
                    // From the plan as it stands, and slow speeds behind it.
                    horizon.take_agreed(stretch.first..new);
                    Stage::Seeding(horizon.begin_seeding(stretch, new))
                } else {
                    return ControlFlow::Break(Failure::Stuck);
                }
            }
            Stage::Seeding(seeding) => match horizon.seed(stretch, seeding) {
                None => return ControlFlow::Continue(()),
                Some(false) => return ControlFlow::Break(Failure::Stuck),
                Some(true) => {
                    let solving = horizon.begin_improving(stretch, Aim::Time);
                    Stage::Solving { solving, guessed: None }
                }
            },
            _ => {
                debug_assert!(false, "nothing to look for");
                return ControlFlow::Continue(());
            }
        };
        ControlFlow::Continue(())
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// The next slice of the plan in the making.
    #[inline(never)]
    pub(super) fn go_on(&mut self) -> Progress {
        #[cfg(feature = "reshape")]
        if let Some(progress) = self.go_on_reshaping() {
            return progress;
        }
        let Some(making) = &mut self.making else { return Progress::Waiting };
        making.slices = making.slices.saturating_add(1);
        if let Stage::Publishing { next } = making.stage {
            let stretch = making.proposal.stretch;
            return self.publish(stretch, next);
        }
        #[cfg(feature = "reshape")]
        if let Stage::Reshaped { next } = making.stage {
            let proposal = making.proposal;
            let left = self
                .reshaping(|planner, memory| planner.hand_over_reshaped(memory, proposal, next));
            let Some(Some(next)) = left else { return self.made() };
            if let Some(making) = &mut self.making {
                making.stage = Stage::Reshaped { next };
            }
            return Progress::Planning;
        }
        let step = if let Stage::Slowing(slowing) = &mut making.stage {
            let side = &mut self.side;
            let slices = making.slices;
            let now = side.cycles();
            let taken =
                S::from_u32(now.since(making.began).unwrap_or(0)) / S::from_u32(u32::from(slices));
            slowing.staging.look_at(now, taken);
            match self
                .horizon
                .go_on_slowing(slowing, &mut making.proposal, |piece| side.write(piece))
            {
                Marched::Working => ControlFlow::Continue(()),
                Marched::Rests => return self.made(),
                Marched::Evens { next, rate } => {
                    let stretch = making.proposal.stretch;
                    let next = self.run_evenly(stretch, next, rate);
                    return self.publish(stretch, next);
                }
                Marched::Nothing => ControlFlow::Break(Failure::Unanswered),
            }
        } else {
            making.step(&mut *self.horizon, self.side.room())
        };
        match step {
            ControlFlow::Continue(()) => Progress::Planning,
            ControlFlow::Break(failure) => {
                let (purpose, proposal, at) = (making.purpose, making.proposal, making.at);
                self.abandon();
                if failure == Failure::Unanswered {
                    if matches!(purpose, Purpose::Easing(_) | Purpose::Falling(_)) {
                        self.ease_again();
                    }
                    self.pressing.short |= purpose == Purpose::BlockEnd;
                    if purpose == Purpose::Hold {
                        self.pressing.attempts = self.pressing.attempts.wrapping_add(1);
                    }
                    return Progress::Planning;
                }
                self.failed(failure, proposal, at)
            }
        }
    }

    /// Hands over pieces from a station on, and offers the plan when they are all.
    #[inline(never)]
    fn publish(&mut self, stretch: Stretch, next: usize) -> Progress {
        let last = stretch.last.min(next + PIECES);
        self.write(stretch, next..last);
        if last == stretch.last {
            return self.made();
        }
        if let Some(making) = &mut self.making {
            making.stage = Stage::Publishing { next: last };
        }
        Progress::Planning
    }

    /// Hands over the pieces of some cells.
    #[inline(never)]
    fn write(&mut self, stretch: Stretch, cells: Range<usize>) {
        self.horizon.compile(stretch, cells, |piece| self.side.write(piece));
    }

    /// Hands over what a clock that goes evenly at a rate makes of the agreed plan from a station on: of the cells that are whole, but for
    /// the last, what is in the plan under way, a fifth of the work of making it anew. Returns the station up to which that could be done.
    #[inline(never)]
    fn run_evenly(&mut self, stretch: Stretch, next: usize, rate: S) -> usize {
        let (whole, added) = self.horizon.whole_from(next);
        // Where the motion comes to rest, it does so to the last bit.
        let last = stretch.last.saturating_sub(1);
        if whole >= last {
            return next;
        }
        let first = self.horizon.window.serial(whole).minus(added);
        let Some(from) = self.side.find(first) else { return next };
        self.write(stretch, next..whole);
        let Self { horizon, side, .. } = self;
        for (i, index) in (whole..last).zip(from..) {
            let Some(station) = horizon.window.get(i) else { return i };
            let (place, arc_length) = (station.node.at, station.arc_length);
            let slower =
                Slower { serial: horizon.window.serial(i), arc_length, time: horizon.time(i) };
            if !side.write_slower(index, &place, rate, &slower) {
                return i;
            }
            if cfg!(debug_assertions) {
                horizon.compile(stretch, i..i + 1, |piece| {
                    debug_assert!(side.has_written(piece), "not what is agreed, slower: {piece:?}");
                });
            }
        }
        last
    }

    /// All pieces of a plan have been written: offers it.
    fn made(&mut self) -> Progress {
        if self.is_far_too_early() {
            return Progress::Planning;
        }
        let Some(making) = self.making.take() else { return Progress::Waiting };
        let Making { purpose, began, at, mut proposal, slices, .. } = making;
        proposal.halt = proposal.halt.map(|halt| self.horizon.halt_at(proposal.stretch.last, halt));
        #[cfg(feature = "reshape")]
        let ripe = making.ripe;
        let cycles = self.side.cycles().since(began).unwrap_or(0);
        let mut begins =
            matches!(purpose, Purpose::Easing(_) | Purpose::Falling(_) | Purpose::Reaction(_));
        match purpose {
            #[cfg(feature = "reshape")]
            Purpose::Ahead if ripe => {}
            Purpose::Ahead => {
                let cells = proposal.stretch.cells();
                let (needed, near) = (self.effort.plan.cycles(self.cells_ahead(at)), self.near());
                let anew = self.effort.plan.renew(cells, cycles, needed > S::from_u32(near));
                if !self.knows_stops {
                    self.effort.stop.renew(usize::from(slices), cycles, anew);
                }
            }
            Purpose::Easing(asked) => {
                self.effort.first.learn(1, cycles);
                (self.pressing.reacted, self.pressing.easings) = (Some(asked), 0);
            }
            Purpose::Reaction(_) => self.effort.first.learn(1, cycles),
            Purpose::Overrides => {
                self.effort.learn_whole(self.cells_ahead(at), cycles);
                begins = self.look_at_answer(proposal.stretch);
            }
            Purpose::Falling(asked) => {
                self.learn_stop(usize::from(slices), cycles);
                self.pressing.reacted = Some(asked);
                self.pressing.falls += 1;
            }
            Purpose::Hold => {
                // A rest that is agreed anyway is no work.
                if slices > 1 {
                    self.learn_stop(usize::from(slices), cycles);
                }
                self.pressing.attempts = 0;
            }
            #[cfg(feature = "reshape")]
            Purpose::Shape => self.effort.shape.learn(1, cycles),
            _ => {}
        }
        #[cfg(feature = "reshape")]
        if self.reshaping.as_ref().is_some_and(|memory| memory.change.is_some()) {
            self.reshaping(|planner, memory| planner.offer_reshaped(memory, proposal));
            return Progress::Planned;
        }
        self.offer(proposal);
        if begins && let Phase::Offered(offer) = &mut self.phase {
            offer.begins = true;
            // Should the command be taken back, the motion is planned on at once.
            offer.taken.checkpoint = offer.first;
        }
        Progress::Planned
    }

    /// Whether an answer that is ready takes effect in a while only, because planning used to take many times as long: the background was late, and
    /// is in time again. Then it is dropped, to be made anew from where it can be by what it has taken.
    #[inline(never)]
    fn is_far_too_early(&mut self) -> bool {
        let Some(Making { purpose, began, at, proposal, slices, .. }) = self.making else {
            return false;
        };
        let Branch::Cycle(when) = proposal.branch else { return false };
        let now = self.side.cycles();
        let cycles = now.since(began).unwrap_or(0);
        let soon = cycles.saturating_mul(SLOWER as u32).saturating_add(self.near());
        if when.since(now).unwrap_or(0) <= soon {
            return false;
        }
        let cells = self.cells_ahead(at);
        let mut whole = self.effort.whole();
        let Effort { plan, stop, first, .. } = &mut self.effort;
        let (work, parts) = match purpose {
            Purpose::Hold | Purpose::Falling(_) => (stop, usize::from(slices)),
            Purpose::Easing(_) | Purpose::Reaction(_) if first.is_known() => (first, 1),
            Purpose::Easing(_) | Purpose::Reaction(_) => (plan, reaction::CELLS),
            Purpose::Overrides if whole.is_known() => (&mut whole, cells),
            Purpose::Overrides => (plan, reaction::PLANS * cells),
            Purpose::BlockEnd => (plan, proposal.stretch.cells()),
            Purpose::Ahead => return false,
            #[cfg(feature = "reshape")]
            Purpose::Shape => return false,
        };
        if !work.begin_anew(parts, cycles) {
            return false;
        }
        self.effort.set_whole(&whole);
        self.pressing.retunes = 0;
        self.try_again(purpose);
        self.abandon();
        true
    }

    /// A stop, or a stage of one, has taken so many servo cycles for so many slices. What slices of plans took is known no longer with the first.
    #[inline(never)]
    fn learn_stop(&mut self, slices: usize, cycles: u32) {
        if !self.knows_stops {
            // A short stage within a cycle is no stop that takes no time.
            if cycles == 0 {
                return;
            }
            (self.knows_stops, self.effort.stop) = (true, Work::NONE);
        }
        self.effort.stop.learn(slices, cycles);
    }

    /// Servo cycles within which an answer takes effect soon.
    pub(super) fn near(&self) -> u32 {
        self.most_reaction().saturating_mul(NEAR_LEADS)
    }

    /// An answer has not been taken up, and may be begun again.
    pub(super) fn try_again(&mut self, purpose: Purpose) {
        match (purpose, &mut self.phase) {
            (Purpose::Easing(_) | Purpose::Falling(_) | Purpose::Reaction(_), _) => {
                (self.pressing.reacted, self.pressing.eased) = (None, None);
            }
            // Meanwhile the motion may have become faster than is asked for.
            (Purpose::Overrides, _) => (self.pressing.eased, self.pressing.falls) = (None, 0),
            (Purpose::BlockEnd, Phase::Following(now)) => now.tried_block_end = false,
            _ => {}
        }
    }

    /// A plan ahead came to nothing.
    fn failed(&mut self, failure: Failure, proposal: Proposal, at: NodeSerial) -> Progress {
        let end = self.horizon.end();
        if let Failure::Crawl(crawl) = failure {
            if proposal.branch != Branch::Node(end) {
                // The rest that is agreed comes first.
                return self.plan(end, at, false);
            }
            self.horizon.ease_crawl(proposal.stretch, crawl);
            return self.plan(end, at, proposal.halt == Some(Halt::Block));
        }
        self.vain = Some(Vain { at, last: self.last_node() });
        if failure == Failure::Stuck {
            self.counters.stuck += 1;
            #[cfg(feature = "defmt")]
            defmt::warn!("no motion found from node {}", end.raw());
        }
        Progress::Waiting
    }

    /// Takes what has been begun, in a draft, for the plan in the making. Whether anything was.
    #[inline(never)]
    pub(super) fn make(
        &mut self,
        (purpose, at): (Purpose, NodeSerial),
        begun: Option<(Proposal, Stage<S>)>,
    ) -> bool {
        debug_assert!(self.making.is_none(), "one plan at a time");
        let began = self.side.cycles();
        self.making = begun.map(|(proposal, stage)| Making {
            purpose,
            proposal,
            began,
            at,
            slices: 0,
            #[cfg(feature = "reshape")]
            ripe: false,
            stage,
        });
        self.making.is_some()
    }

    /// The same for a proposal whose states are found.
    pub(super) fn propose(&mut self, purpose: Purpose, proposal: Option<Proposal>) -> bool {
        let begun = proposal.map(|proposal| (proposal, Stage::publishing(&proposal)));
        self.make((purpose, self.side.progress()), begun)
    }

    /// Whether a plan ahead whose states are found may wait, because it leaves the agreed one in a while only: until then what comes
    /// before can be reshaped with it.
    #[cfg(feature = "reshape")]
    fn may_ripen(&mut self) -> bool {
        let wish = self.requests.read();
        if wish.stops_at_end() {
            return false;
        }
        // Where an answer to overrides is owed, the motion may be as slow as they were, and the place where the plan leaves it far off.
        if !self.horizon.is_paced(wish.overrides) {
            return false;
        }
        let lead = self.horizon.config.lead;
        let Some(making) = &mut self.making else { return false };
        let (Phase::Following(_), Branch::Node(branch)) = (self.phase, making.proposal.branch)
        else {
            return false;
        };
        if self.reshaping.is_none() {
            return false;
        }
        let at = self.side.progress();
        let planned = self.effort.shape.cycles(1) * self.horizon.config.cycle;
        let soon = lead * S::of(RIPE_LEADS) + planned;
        if branch == self.horizon.end() || self.horizon.reaches_within(soon, at, branch) {
            return false;
        }
        if !making.ripe {
            let cycles = self.side.cycles().since(making.began).unwrap_or(0);
            self.effort.plan.learn(making.proposal.stretch.cells(), cycles);
            making.ripe = true;
        }
        true
    }

    /// What is done for reshaping in this slice, if anything.
    #[cfg(feature = "reshape")]
    fn go_on_reshaping(&mut self) -> Option<Progress> {
        let now = self.side.progress();
        let making = self.making.as_ref()?;
        let (mut proposal, at, ahead) =
            (making.proposal, making.at, making.purpose == Purpose::Ahead);
        if let Stage::Shaping(mut shaping) = making.stage {
            let enough = if ahead { !self.may_ripen() } else { self.is_pressed(now) };
            let went = if enough {
                Some(false)
            } else {
                self.reshaping(|planner, memory| {
                    planner.go_on_shaping(memory, &mut shaping, &mut proposal)
                })?
            };
            let making = self.making.as_mut()?;
            match went {
                None => making.stage = Stage::Shaping(shaping),
                Some(true) => {
                    making.proposal = proposal;
                    making.stage = Stage::Reshaped { next: 0 };
                }
                Some(false) if ahead => making.stage = Stage::publishing(&making.proposal),
                Some(false) => self.abandon(),
            }
            return Some(Progress::Planning);
        }
        if !ahead || !making.stage_begins() {
            return None;
        }
        let starts = matches!(self.phase, Phase::Resting(_)) && !making.ripe;
        let waits = self.may_ripen();
        if (starts || waits)
            && let Some(Some(shaping)) = self
                .reshaping(|planner, memory| planner.begin_shaping(memory, proposal.stretch, at))
        {
            let making = self.making.as_mut()?;
            if !making.ripe {
                let cycles = self.side.cycles().since(making.began).unwrap_or(0);
                self.effort.plan.learn(proposal.stretch.cells(), cycles);
            }
            making.ripe = true;
            making.stage = Stage::Shaping(shaping);
            return Some(Progress::Planning);
        }
        waits.then_some(Progress::Waiting)
    }

    /// Drops the plan in the making, with all that it has changed.
    fn abandon(&mut self) {
        self.making = None;
        #[cfg(feature = "reshape")]
        if let Some(memory) = self.reshaping.as_deref_mut() {
            memory.change = None;
        }
        self.side.discard();
        self.horizon.drop_draft();
    }

    /// Drops the plan in the making if it does not serve what is asked for, or can no longer be taken up.
    #[inline(never)]
    pub(super) fn drop_unwanted(&mut self, wish: &Wish, at: NodeSerial) {
        let Some(making) = &self.making else { return };
        let brakes = self.brakes(wish);
        // Those of a draft are what it is made for.
        let paced = wish.overrides == self.horizon.overrides();
        // Until they can be answered, the motion goes on at those before.
        let paced = paced || self.pressing.refused == Some(wish.overrides);
        let serves = match making.purpose {
            Purpose::Hold => {
                let short = making.proposal.halt == Some(Halt::Short);
                brakes || (short && wish.stops_at_end())
            }
            Purpose::Ahead => paced && !brakes && !self.looks_for_block_end(wish, at),
            Purpose::Overrides => paced && !brakes,
            Purpose::Easing(overrides)
            | Purpose::Falling(overrides)
            | Purpose::Reaction(overrides) => !brakes && wish.overrides == overrides,
            Purpose::BlockEnd => paced && !brakes && wish.stops_at_end(),
            #[cfg(feature = "reshape")]
            Purpose::Shape => paced && !brakes && !wish.stops_at_end(),
        };
        let passed = match making.proposal.branch {
            Branch::Node(node) => node != self.horizon.end() && !at.is_before(node),
            Branch::Cycle(cycle) => cycle.is_before(self.side.cycles()),
        };
        if passed {
            let cells = making.proposal.stretch.cells();
            let cycles = self.side.cycles().since(making.began).unwrap_or(0);
            let slices = usize::from(making.slices);
            let (purpose, begun_at) = (making.purpose, making.at);
            let by_cycle = making.proposal.branch.is_by_cycle();
            match purpose {
                Purpose::Ahead => {
                    self.effort.plan.learn(cells, cycles);
                    // With some more of the path it is another problem: the same one is as hard again. From a rest it is another,
                    // and while it lasts nothing else would change.
                    if at != self.horizon.end() {
                        self.vain = Some(Vain { at, last: self.last_node() });
                    }
                }
                Purpose::Easing(_) | Purpose::Reaction(_) => self.effort.first.learn(1, cycles),
                Purpose::Hold | Purpose::Falling(_) => self.learn_stop(slices, cycles),
                Purpose::Overrides => self.effort.raise_whole(self.cells_ahead(begun_at), cycles),
                Purpose::BlockEnd => self.pressing.short = true,
                #[cfg(feature = "reshape")]
                Purpose::Shape => {
                    self.effort.shape.learn(1, cycles);
                    self.abandon();
                    return;
                }
            }
            self.try_again(purpose);
            self.late(by_cycle);
        }
        if passed || !serves {
            self.abandon();
        }
    }
}

/// What no plan was found for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vain {
    at: NodeSerial,
    last: NodeSerial,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Whether no plan ahead is found before the motion has moved on or more of the path is known.
    pub(super) fn is_vain(&self, at: NodeSerial) -> bool {
        self.vain == Some(Vain { at, last: self.last_node() })
    }
}
