//! A stop in stages: the motion begins to slow down while most of the stop is still to be planned.
//!
//! Where planning takes time, a whole march ([`slowing`](super::slowing)) would show only when all of it is made. So only its first steps are made and
//! offered at once, as a plan that ends at rest like every other: behind them the clock is let go until it goes evenly, as the march has
//! made sure that it can, and from there the agreed motion is run on evenly and slower, to its end.
//!
//! ```text
//!   rate  1 ──╮                   ── stage 1 ── node ── let go ── even ──▶ end of the agreed motion
//!              ╲ ╭───── stage 1                  └──── stage 2 ── node ── let go ── even ──▶
//!               ◆  ╭─── stage 2                                    └──── the last one, to rest
//!                ╲◆
//!                  ╲___ rest
//! ```
//!
//! Where the clock begins to be let go, a node is put into the path: there the next stage branches off ([`Handover`]) and takes the fall
//! further, so that whoever is quick enough sees one march. A stage takes so many steps that the next is made meanwhile, by what slices of stops
//! have taken. One that comes too late is refused: then the motion goes on evenly, at what it has come down to, and the
//! next stage branches off from that at a servo cycle, like the first.
//!
//! States of nodes from the branch on are those of the agreed motion run at the clock's last rate: from where it goes evenly on that is what is
//! run, and every plan may branch off there as from any other. So one clock is enough to say what goes on at the node before.

use super::slowing::{
    EVEN, Leg, Place, RELEASED, SHORTER, STEPS_PER_SLICE, Slowing, Stepped, Stride,
};
use crate::number::Scalar;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::planner::Planner;
use crate::planner::horizon::{Handover, Horizon, Moment, Proposal};
use crate::planner::making::PIECES;
use crate::planner::phase::Halt;
use crate::profile::clock::{Clock, Shape};
use crate::profile::slowed::keeps;
use crate::servo::link::Branch;
use crate::servo::piece::{Piece, Sequel};

/// Slices of a stop in all.
const SLICES: usize = 16;
/// Cells that take as much work in a plan ahead as a slice of a stop does, as long as none has been measured.
const GUESSED: f64 = 1.0;
/// Attempts at a stop that are made in stages.
const STAGED: u8 = 2;
/// Steps of a stage at most.
const MOST_STEPS: usize = 16;
/// Servo cycles that a step lasts at least, as a rule, but in shorter cells; so many cells are looked at.
const STEP_CYCLES: f64 = 2.7;
const CELLS_AHEAD: usize = 8;
/// A first stage lasts so many times as long as it takes to make it, and so many servo cycles more: the next may be longer.
const GROWTH: f64 = 1.4;
const HEARD: f64 = 1.0;
/// Slices in which a stage is ended, besides those for the pieces of what is run evenly: the last step, and where the clock is let go.
const ENDING: usize = 2;
/// Steps of that in a slice.
const RELEASES_PER_SLICE: usize = 8;
/// Pieces that it takes at most, as a rule.
const RELEASES: usize = 14;
/// Share of its rate that a clock must have left when it goes evenly.
const LEAST_LEFT: f64 = 0.1;

/// Where a stop, or a stage of it, begins.
#[derive(Clone, Copy, Debug)]
pub enum Start<S> {
    /// In the agreed motion; `None` while the interrupt is changing over.
    Moment(Option<Moment<S>>),
    /// Where the stage before hands over.
    Handover(Handover<S>),
}

/// What a slice has come to.
#[derive(Clone, Copy, Debug)]
pub enum Marched {
    /// There is more to do.
    Working,
    /// The motion rests, and the proposal can be offered.
    Rests,
    /// From this station on the motion goes evenly: its cells are to be handed over.
    Evens { next: usize },
    /// There is no stop.
    Nothing,
}

/// How far a stage has got.
#[derive(Clone, Copy, Debug)]
pub struct Staging<S> {
    /// Whether the stop is made as a whole, or is to be from here on.
    whole: bool,
    to_rest: bool,
    /// Whether no time is left for more steps.
    pressed: bool,
    /// Servo cycle at whose end it begins: by then it must be on offer.
    from: CycleSerial,
    /// Servo cycles that it takes to end it, and steps that are as much work.
    reserve: S,
    near: S,
    /// How long it lasts, s.
    lasts: S,
    /// Where the clock has begun to be let go.
    pub(super) released: Option<Release<S>>,
}

/// Where the next stage branches off.
#[derive(Clone, Copy, Debug)]
pub struct Release<S> {
    /// Station there; `None` where the clock is let go between two of them, and no stage branches off.
    station: Option<usize>,
    clock: Clock<S>,
}

impl<S: Scalar> Staging<S> {
    /// A stop as a whole.
    const WHOLE: Self = Self {
        whole: true,
        to_rest: false,
        pressed: false,
        from: CycleSerial::ZERO,
        reserve: S::ZERO,
        near: S::ZERO,
        lasts: S::ZERO,
        released: None,
    };

    /// Looks at the clock before a slice.
    pub(super) fn look_at(&mut self, now: CycleSerial) {
        let left = self.from.since(now).unwrap_or(0);
        self.pressed = S::from_u32(left) < self.reserve;
    }

    /// Counts a step of a march of steps that take `step_time` seconds, behind which there is room for so many pieces more than those that end the stage. Whether it is the last.
    fn is_due(&mut self, step: &Stepped<S>, step_time: S, has_room: bool) -> bool {
        for leg in step.legs.iter().flatten() {
            self.lasts += leg.run.time;
        }
        // Where a clock that slows down so fast is nearly at rest, it is no more work to stop it.
        let Clock { rate, slope } = step.to.clock;
        self.to_rest |= rate + rate < -slope * self.near * step_time;
        !self.whole && !self.to_rest && (self.pressed || !has_room)
    }
}

impl<S: Scalar> Slowing<S> {
    /// No step has been found: what there is of the stage is ended, if no time is left to try others.
    pub(super) fn end_stage(&mut self) -> Marched {
        let Self { place, pieces, .. } = *self;
        if self.staging.whole || !self.staging.pressed || pieces == 0 {
            return Marched::Nothing;
        }
        let station = (!(place.shown > S::ZERO)).then_some(place.cell);
        self.staging.released = Some(Release { station, clock: place.clock });
        Marched::Working
    }
}

/// The legs of a step that ends at a node.
pub(super) fn end_at_node<S: Scalar>(legs: &mut [Option<Leg<S>>; 2]) {
    if let Some(leg) = legs.iter_mut().flatten().last() {
        leg.sequel = Sequel::Motion;
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// How much of a stop is made at a time, and how many servo cycles that takes.
    pub(super) fn stage_of_stop(
        &self,
        handover: Option<Handover<S>>,
        at: NodeSerial,
    ) -> (S, Staging<S>) {
        let work = if self.effort.stop.is_known() {
            self.effort.stop
        } else {
            self.effort.plan.times(GUESSED)
        };
        let whole = work.usual(SLICES);
        let staged = handover.is_some() || self.pressing.attempts < STAGED;
        if !(whole > S::ZERO && staged) {
            return (whole, Staging::WHOLE);
        }
        let from = self.horizon.window.clamped_index(at);
        let cells = self.horizon.stretch_from(from).cells();
        let ends = ENDING + cells.div_ceil(PIECES);
        let near = S::from_u32((ends * STEPS_PER_SLICE) as u32);
        let reserve = work.within(ends);
        let staging = Staging { whole: false, reserve, near, ..Staging::WHOLE };
        if handover.is_some() {
            return (S::ZERO, staging);
        }
        // As many steps as last longer than it takes to make as many more.
        let ahead = from..self.horizon.end_index().min(from + CELLS_AHEAD);
        let count = S::from_u32(ahead.len().max(1) as u32);
        let time = ahead.fold(S::ZERO, |time, i| time + self.horizon.agreed_time(i));
        let step = (time / count / self.horizon.config.cycle).least(S::of(STEP_CYCLES));
        let cycles = |steps: usize| work.within(1 + ends + steps.div_ceil(STEPS_PER_SLICE));
        let lasts = |steps: usize| S::from_u32(steps as u32) * step;
        let wanted = |steps: usize| cycles(steps) * S::of(GROWTH) + S::of(HEARD);
        let steps = (1..=MOST_STEPS).find(|steps| lasts(*steps) >= wanted(*steps));
        steps.map_or((whole, Staging::WHOLE), |steps| (cycles(steps), staging))
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Where a stop leaves the agreed motion, and how the clock goes there.
    pub(super) fn branch_off(
        &mut self,
        start: Start<S>,
        staging: &mut Staging<S>,
    ) -> Option<(usize, Branch, Clock<S>)> {
        match start {
            Start::Moment(moment) => {
                let moment = moment?;
                staging.from = moment.when;
                let (first, branch) = self.cut_in(moment)?;
                Some((first, branch, Clock::NORMAL))
            }
            Start::Handover(Handover { node, clock, when }) => {
                staging.from = when;
                Some((self.window.find(node)?, Branch::Node(node), clock))
            }
        }
    }

    /// Puts a node where a step ends, unless there is one. Whether there is one now.
    #[inline(never)]
    fn put_node_at(&mut self, place: Place<S>, proposal: &mut Proposal) -> bool {
        if !(place.shown > S::ZERO) {
            return true;
        }
        if !self.cut_agreed(place.cell, place.shown) {
            return false;
        }
        proposal.stretch.last += 1;
        self.window.measure(place.cell);
        true
    }

    /// If a step is the last of its stage, puts the node at its end where the next goes on.
    pub(super) fn hand_over_behind(
        &mut self,
        stepped: &mut Stepped<S>,
        slowing: &mut Slowing<S>,
        proposal: &mut Proposal,
    ) {
        let to = stepped.to;
        let cells = proposal.stretch.last.saturating_sub(to.cell);
        let has_room = slowing.pieces + cells + RELEASES < NODES;
        if slowing.staging.is_due(stepped, slowing.step, has_room) && self.put_node_at(to, proposal)
        {
            end_at_node(&mut stepped.legs);
            let station = to.cell + usize::from(to.shown > S::ZERO);
            slowing.staging.released = Some(Release { station: Some(station), clock: to.clock });
            stepped.to = Place { cell: station, shown: S::ZERO, ..to };
        }
    }

    /// A slice of letting the clock go, until it goes evenly.
    #[inline(never)]
    pub(super) fn go_on_releasing(
        &mut self,
        slowing: &mut Slowing<S>,
        release: Release<S>,
        proposal: &mut Proposal,
        mut hand_over: impl FnMut(&Piece<S, N>),
    ) -> Marched {
        for _ in 0..RELEASES_PER_SLICE {
            let place = slowing.place;
            let stretch = proposal.stretch;
            if is_even(place.clock, slowing.step) {
                return self.even_out(slowing, release, proposal);
            }
            if slowing.pieces + 3 > NODES {
                return Marched::Nothing;
            }
            let Some(agreed) = self.agreed_piece(place.cell) else { return Marched::Nothing };
            let stepped = self.release_step(slowing, &agreed).or_else(|| {
                let shorter = Slowing { step: slowing.step * S::of(SHORTER), ..*slowing };
                self.release_step(&shorter, &agreed)
            });
            let Some(Stepped { mut legs, mut to }) = stepped else { return Marched::Nothing };
            let stops = to.clock == Clock::STOPPED;
            let Some(end) = (if stops { self.put_rest_at(to) } else { Some(to.cell) }) else {
                return Marched::Nothing;
            };
            let rests = stops || end == stretch.last;
            if !rests && is_even(to.clock, slowing.step) {
                if !self.put_node_at(to, proposal) {
                    return Marched::Nothing;
                }
                end_at_node(&mut legs);
                let cell = to.cell + usize::from(to.shown > S::ZERO);
                self.halve(to, cell, agreed.time, proposal);
                to = Place { cell, shown: S::ZERO, ..to };
            }
            for leg in legs.iter().flatten() {
                let mut piece = leg.piece(&agreed);
                if rests
                    && leg.sequel != Sequel::Within
                    && let Some(station) = self.window.get(end)
                {
                    piece.sequel = Sequel::Stop;
                    piece.end_at(&station.node.at);
                }
                hand_over(&piece);
                slowing.pieces += 1;
            }
            slowing.place = to;
            if rests {
                return self.rest_at(stretch.first, end, proposal);
            }
        }
        Marched::Working
    }

    /// The next step of letting the clock go, or the last of a stop.
    #[inline(never)]
    fn release_step(&self, slowing: &Slowing<S>, piece: &Piece<S, N>) -> Option<Stepped<S>> {
        let Slowing { place, step: longest, share, quick, .. } = *slowing;
        let limits = &self.limits_over(place.cell, quick);
        let shape = Shape::of(piece);
        let step = Stride::new(&shape, place, longest);
        let bends = step.bends(limits, share * S::of(RELEASED))?;
        if step.may_stop(bends, longest)
            && let Some(all) = step.bends(limits, share)
            && let Some(stops) = self.stop(piece, place, (all, longest), limits)
        {
            return Some(stops);
        }
        let (mut leg, mut to) = step.take(step.release(bends))?;
        if is_even(to.clock, longest) {
            // To the last bit.
            (to.clock.slope, leg.run.to.slope) = (S::ZERO, S::ZERO);
        }
        keeps(&leg.piece(piece), limits).then_some(Stepped { legs: [Some(leg), None], to })
    }

    /// The jerk of a curved cell is bounded by that of its halves: where one was cut before its middle, what is left is cut there.
    fn halve(&mut self, cut: Place<S>, i: usize, whole: S, proposal: &mut Proposal) {
        let half = whole * S::of(0.5) - cut.shown;
        let curved = self.window.get(i).is_some_and(|station| !station.cell.straight);
        if curved && cut.shown > S::ZERO && half > self.config.cycle && self.cut_agreed(i, half) {
            proposal.stretch.last += 1;
            self.window.measure(i);
        }
    }

    /// The clock goes evenly: so it does to the end.
    fn even_out(
        &mut self,
        slowing: &Slowing<S>,
        release: Release<S>,
        proposal: &mut Proposal,
    ) -> Marched {
        let Place { cell: next, clock, .. } = slowing.place;
        let (stretch, rate) = (proposal.stretch, clock.rate);
        let left = stretch.last.saturating_sub(next);
        if left == 0
            || slowing.pieces + left > NODES
            || !(rate > release.clock.rate * S::of(LEAST_LEFT))
        {
            return Marched::Nothing;
        }
        let even = Clock { rate, slope: S::ZERO };
        for i in stretch.first..stretch.last {
            if let Some(station) = self.window.get_mut(i) {
                station.state = even.run(station.state);
            }
        }
        let at = release.clock;
        let cycles = slowing.staging.lasts / self.config.cycle;
        let handover = Handover {
            // Where the clock goes evenly, every plan branches off.
            node: self.window.serial(release.station.unwrap_or(next)),
            clock: Clock { rate: at.rate / rate, slope: at.slope / rate },
            when: slowing
                .staging
                .from
                .plus((cycles + S::of(0.5)).to_i64().clamp(0, 1_000_000) as u32),
        };
        self.mark_slowing(self.window.serial(next), handover);
        proposal.halt = Some(Halt::Slowing);
        Marched::Evens { next }
    }
}

/// Whether a clock goes evenly, but for a rounding.
fn is_even<S: Scalar>(clock: Clock<S>, step: S) -> bool {
    (clock.slope * step).abs() < S::of(EVEN)
}
