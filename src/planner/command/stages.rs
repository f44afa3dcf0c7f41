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
//! Of every step the march knows what becomes of the clock if it is let go behind it ([`Released`]): how many steps that takes, and how fast it goes then. So
//! a stage is ended while there is time and room for that. Where the clock would hardly go by then, it is let go no more than takes it to
//! rest: a motion that crawls on would have to be stopped once more, and the hardest stop eases off from there as well. That stage is the last.
//!
//! States of nodes from the branch on are those of the agreed motion run at the clock's last rate: from where it goes evenly on that is what is
//! run, and every plan may branch off there as from any other. So one clock is enough to say what goes on at the node before.

use super::falling::NEARLY;
use super::slowing::{
    Leg, Place, RELEASED, Released, SHORTER, STEPS_PER_SLICE, Slowing, Stepped, Stride,
};
use crate::number::Scalar;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::planner::Planner;
use crate::planner::effort::Work;
use crate::planner::horizon::{Handover, Horizon, Moment, Proposal};
use crate::planner::phase::Halt;
use crate::profile::clock::{Clock, Shape};
use crate::profile::slowed::Run;
use crate::servo::link::Branch;
use crate::servo::piece::{Piece, Sequel};

/// Slices of a stop in all.
pub(super) const SLICES: usize = 16;
/// Servo cycles within which it is made as a whole.
const AT_ONCE: f64 = 1.5;
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
/// Steps of letting the clock go in a slice: about as much work as those of a march in one.
const RELEASES_PER_SLICE: usize = 6;
/// Such steps behind a stage, as long as none has been tried.
const RELEASES: u8 = 6;
/// Pieces that there must be room for besides: of a step, of the last where the clock is let go, and of what is cut.
const MORE_PIECES: usize = 3;
/// A clock that would go evenly faster than it is to by less than this share is taken all the way.
const NEAR: f64 = 0.03;
/// Share of its rate that a clock must have left when it goes evenly.
pub(super) const LEAST_LEFT: f64 = 0.1;

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
pub enum Marched<S> {
    /// There is more to do.
    Working,
    /// The motion rests, and the proposal can be offered.
    Rests,
    /// From this station on the motion goes evenly, by a clock with a rate: its cells are to be handed over.
    Evens { next: usize, rate: S },
    /// There is no stop.
    Nothing,
}

/// How far a stage has got.
#[derive(Clone, Copy, Debug)]
pub struct Staging<S> {
    /// Whether the stop is made as a whole, or is to be from here on.
    whole: bool,
    to_rest: bool,
    /// Whether there is time for no more than one slice of steps.
    pub(super) pressed: bool,
    /// What becomes of the clock if it is let go where the march has got to.
    release: Released<S>,
    /// Servo cycle at whose end it begins: by then it must be on offer.
    from: CycleSerial,
    /// What a slice takes.
    work: Work<S>,
    /// How long it lasts, s.
    lasts: S,
    /// Rate at which the clock must be able to go evenly behind every step; 0 if it is to stop.
    pub(super) floor: S,
    /// Where the clock has begun to be let go.
    pub(super) released: Option<Release<S>>,
}

/// Where the next stage branches off.
#[derive(Clone, Copy, Debug)]
pub struct Release<S> {
    /// Station there; `None` where the clock is let go between two of them, and no stage branches off.
    station: Option<usize>,
    clock: Clock<S>,
    /// Whether it is to stop: by the time it went evenly it would hardly go.
    stops: bool,
}

impl<S: Scalar> Staging<S> {
    /// A stop as a whole.
    const WHOLE: Self = Self {
        whole: true,
        to_rest: false,
        pressed: false,
        release: Released::STOPPED,
        from: CycleSerial::ZERO,
        work: Work::NONE,
        lasts: S::ZERO,
        floor: S::ZERO,
        released: None,
    };

    /// Whether it is to come down to a rate, and not to stop.
    pub(super) fn falls(&self) -> bool {
        self.floor > S::ZERO
    }

    /// Whether it is no stage, but a stop as a whole.
    pub(super) fn is_whole(&self) -> bool {
        self.whole
    }

    /// Whether the motion has slowed down as much as is asked for, if it is not to stop.
    fn has_fallen(&self) -> bool {
        self.falls() && self.release.rate < self.floor * S::of(1.0 + NEAR)
    }

    /// Slices in which the stage is ended behind its last step: the clock is let go. (What is run evenly goes with the last of them.)
    fn ends(&self) -> usize {
        usize::from(self.release.steps).div_ceil(RELEASES_PER_SLICE)
    }

    /// Whether a clock that goes like this and is let go hardly goes any more when it does so evenly.
    fn stops(&self, clock: Clock<S>) -> bool {
        !(self.release.rate > clock.rate * S::of(LEAST_LEFT))
    }

    /// Looks at the clock before a slice. The slices before have taken so many servo cycles each.
    pub fn look_at(&mut self, now: CycleSerial, taken: S) {
        let left = S::from_u32(self.from.since(now).unwrap_or(0));
        // Behind this one there must be another.
        let slices = 2 + self.ends();
        let needed = self.work.within(slices).greatest(taken * S::from_u32(slices as u32));
        self.pressed = !self.whole && left < needed;
    }

    /// Counts a step of a march, the last of a slice or not, with so many cells left and room for so many pieces behind it. Whether it is
    /// the last of its stage.
    fn is_due(
        &mut self,
        step: &Stepped<S>,
        (cells, room): (usize, usize),
        ends_slice: bool,
    ) -> bool {
        for leg in step.legs.iter().flatten() {
            self.lasts += leg.run.time;
        }
        self.release = step.release;
        let cells = if self.stops(step.to.clock) { 0 } else { cells };
        let ends = usize::from(self.release.steps) + cells + MORE_PIECES;
        // Or there is no other way.
        self.to_rest |= ends > room;
        let pressed = !self.whole && self.pressed && ends_slice;
        let full = ends + MORE_PIECES > room && (self.falls() || !self.whole);
        !self.to_rest && (pressed || full || self.has_fallen())
    }
}

impl<S: Scalar> Slowing<S> {
    /// No step has been found: what there is of the stage is ended, if no time is left to try others.
    pub(super) fn end_stage(&mut self) -> Marched<S> {
        let Self { place, pieces, .. } = *self;
        let ends = self.staging.pressed || self.staging.falls();
        if self.staging.whole || !ends || pieces == 0 {
            return Marched::Nothing;
        }
        let station = (!(place.shown > S::ZERO)).then_some(place.cell);
        self.staging.released =
            Some(Release { station, clock: place.clock, stops: self.staging.stops(place.clock) });
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
    /// Where a stop or a stage of it begins that is made within so many servo cycles: where the one before hands over, or as soon as can be.
    pub(super) fn start_of_stage(&self, handover: Option<Handover<S>>, needed: S) -> Start<S> {
        match handover {
            Some(handover) => Start::Handover(handover),
            None => Start::Moment(self.moment_after(needed)),
        }
    }

    /// How much of a stop is made at a time, and how many servo cycles that takes.
    pub(super) fn stage_of_stop(
        &self,
        handover: Option<Handover<S>>,
        at: NodeSerial,
    ) -> (S, Staging<S>) {
        let work = self.effort.stop;
        let whole = work.usual(SLICES);
        let staged = handover.is_some() || self.pressing.attempts < STAGED;
        if !(whole > S::ZERO && staged) {
            return (whole, Staging::WHOLE);
        }
        let cycles = work.within(SLICES);
        if handover.is_none() && cycles < S::of(AT_ONCE) {
            return (S::ZERO, Staging::WHOLE);
        }
        let from = self.horizon.window.clamped_index(at);
        let cells = self.horizon.stretch_from(from).cells();
        let release = Released { steps: RELEASES, rate: S::ONE };
        let staging = Staging { whole: false, release, work, ..Staging::WHOLE };
        if handover.is_some() {
            return (S::ZERO, staging);
        }
        if cells + usize::from(RELEASES) + MORE_PIECES > NODES {
            return (cycles, Staging::WHOLE);
        }
        // As many steps as last longer than it takes to make as many more.
        let ahead = from..self.horizon.end_index().min(from + CELLS_AHEAD);
        let count = S::from_u32(ahead.len().max(1) as u32);
        let time = ahead.fold(S::ZERO, |time, i| time + self.horizon.agreed_time(i));
        let step = (time / count / self.horizon.config.cycle).least(S::of(STEP_CYCLES));
        let cycles =
            |steps: usize| work.within(1 + steps.div_ceil(STEPS_PER_SLICE) + staging.ends());
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

    /// If a step, the last of a slice or not, is the last of its stage, puts the node at its end where the next goes on.
    pub(super) fn hand_over_behind(
        &mut self,
        stepped: &mut Stepped<S>,
        slowing: &mut Slowing<S>,
        proposal: &mut Proposal,
        ends_slice: bool,
    ) {
        let to = stepped.to;
        let cells = proposal.stretch.last.saturating_sub(to.cell);
        let room = NODES.saturating_sub(slowing.pieces + 1);
        if slowing.staging.is_due(stepped, (cells, room), ends_slice)
            && self.put_node_at(to, proposal)
        {
            end_at_node(&mut stepped.legs);
            let station = to.cell + usize::from(to.shown > S::ZERO);
            let stops = slowing.staging.stops(to.clock);
            slowing.staging.released =
                Some(Release { station: Some(station), clock: to.clock, stops });
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
    ) -> Marched<S> {
        for left in (0..=RELEASES_PER_SLICE).rev() {
            let place = slowing.place;
            let stretch = proposal.stretch;
            if place.clock.is_even() {
                // Within a cell there is no node from which it could go on so.
                let within = place.shown > S::ZERO;
                return if within {
                    Marched::Nothing
                } else {
                    self.even_out(slowing, release, proposal)
                };
            }
            if left == 0 {
                break;
            }
            if slowing.pieces + 3 > NODES {
                return Marched::Nothing;
            }
            let Some(agreed) = self.agreed_piece(place.cell) else { return Marched::Nothing };
            let stepped = self.release_step(slowing, &agreed, release.stops).or_else(|| {
                let shorter = Slowing { step: slowing.step * S::of(SHORTER), ..*slowing };
                self.release_step(&shorter, &agreed, release.stops)
            });
            let Some(Stepped { mut legs, mut to, .. }) = stepped else { return Marched::Nothing };
            let stops = to.clock == Clock::STOPPED;
            let Some(end) = (if stops { self.put_rest_at(to) } else { Some(to.cell) }) else {
                return Marched::Nothing;
            };
            let rests = stops || end == stretch.last;
            if rests && slowing.staging.falls() {
                return Marched::Nothing;
            }
            if !rests && to.clock.is_even() {
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
    fn release_step(
        &self,
        slowing: &Slowing<S>,
        piece: &Piece<S, N>,
        stops: bool,
    ) -> Option<Stepped<S>> {
        let Slowing { place, step: longest, share, quick, .. } = *slowing;
        let floor = slowing.staging.floor;
        let limits = &self.limits_over(place.cell, quick);
        let shape = Shape::of(piece);
        let mut step = Stride::new(&shape, place, longest);
        let bends = step.bends(limits, share * S::of(RELEASED))?;
        if !slowing.staging.falls()
            && step.may_stop(bends, longest)
            && let Some(all) = step.bends(limits, share)
            && let Some(stops) = self.stop(piece, place, (all, longest), limits)
        {
            return Some(stops);
        }
        let mut bend = step.release(bends);
        if (stops || slowing.staging.has_fallen())
            && let Some((end, time)) = place.clock.above(floor).end()
        {
            // All the way with what is needed.
            bend = bend.least(end);
            if !stops && time <= longest {
                let lands = step.land(floor, (end, time, bends), self.config.cycle);
                bend = lands.unwrap_or(bend);
            }
        }
        let (mut leg, mut to) = step.take(bend)?;
        let mut keeps = false;
        if to.clock.is_nearly_even(longest) {
            // To the last bit, if a limit leaves room for that; or else with the next step.
            let clock = Clock { slope: S::ZERO, ..to.clock };
            let even = Leg { run: Run { to: clock, ..leg.run }, ..leg };
            keeps = even.keeps(piece, limits);
            if keeps {
                (leg, to.clock) = (even, clock);
            }
        }
        (keeps || leg.keeps(piece, limits)).then_some(Stepped {
            legs: [Some(leg), None],
            to,
            release: Released::STOPPED,
        })
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
    ) -> Marched<S> {
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
        if slowing.staging.falls() {
            // One that does not get on is left to others.
            if !(rate < S::of(1.0 - NEARLY)) {
                return Marched::Nothing;
            }
            self.mark_eased(next);
            proposal.stretch.open = self.is_open(stretch);
        } else {
            proposal.halt = Some(Halt::Slowing);
        }
        Marched::Evens { next, rate }
    }
}
