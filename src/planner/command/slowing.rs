//! Coming to rest by slowing down the clock of the agreed motion.
//!
//! What the agreed motion does as its clock shows tau is done later, and what is asked of the axes then is known for every bend
//! of the clock ([`clock`](crate::profile::clock)). A march from the branch on takes steps of constant bend, each within a cell, and each as hard as the
//! limits allow at both of its ends - provided that the clock could go evenly again from its end on: a motion by a clock
//! that goes evenly and slower keeps all limits wherever it goes, so whatever follows, the next step has an answer. Whether it
//! could is tried by marching on with the greatest bends. Where two bends of the same size would stop the clock
//! within a step each, they are the last ones.
//!
//! The pieces are handed over as they are found; no solver is asked, and nothing is found that has to be improved. They are more
//! than one to a cell ([`Sequel::Within`]): no plan branches off from within them ([`Horizon::is_slowed`]), but for the next stage of a stop,
//! at a node that is put there for it ([`stages`](super::stages)).

use super::stages::{Marched, Staging, Start};
use crate::machine::{LimitSets, Limits};
use crate::number::Scalar;
use crate::planner::horizon::{Handover, Horizon, Proposal};
use crate::planner::making::Stage;
use crate::planner::phase::Halt;
use crate::profile::clock::{Clock, Instant, Shape};
use crate::profile::law::PathState;
use crate::profile::slowed::Run;
use crate::profile::solver::Stretch;
use crate::servo::control::Overrides;
use crate::servo::piece::{Piece, Sequel};

/// Steps of a stop on a straight.
const STEPS: f64 = 34.0;
/// Servo cycles that a step takes at least.
const LEAST_CYCLES: f64 = 3.0;
/// A step that ends this near to the end of its cell, in steps, goes there; from a little further away it goes half-way.
const NEAR: f64 = 1.2;
const HALF_WAY: f64 = 2.0;
/// Steps in which the clock must be able to go evenly again.
const RELEASE_STEPS: usize = 48;
/// Share of the limits with which that is tried: what is known of a step before it is taken is not exact.
pub(super) const RELEASED: f64 = 0.985;
/// From this part of all the pieces on that there may be, each step is longer than the one before by this factor.
const MANY: usize = 2;
const LONGER: f64 = 1.06;
/// Where no step can be taken, one so much shorter is tried.
pub(super) const SHORTER: f64 = 0.5;
/// Halvings in the search for the hardest bend; and where no time is left.
const HALVINGS: u32 = 3;
const FEW_HALVINGS: u32 = 1;
/// Steps taken in one slice, and strides of the clock that may be tried for them; with fewer than half of these left no other step is begun.
pub(super) const STEPS_PER_SLICE: usize = 2;
const STRIDES: usize = 80;
/// Where a motion turns, a step takes at most this share of the time in which its velocity changes by as much as there is of it,
/// but at least this share of what it takes elsewhere.
const CALM: f64 = 0.15;
const LEAST_PART: f64 = 0.4;
/// Cells looked at in one slice.
const CELLS: usize = 10;
/// Shares of the limits, attempt by attempt, and how much longer the steps are.
const SHARES: [(f64, f64); 4] = [(1.0, 1.0), (0.97, 1.0), (0.94, 1.6), (0.88, 2.5)];
/// Attempts in a row.
pub const ATTEMPTS: usize = SHARES.len();
/// Shares of the hardest bend with which the clock is stopped.
const LAST: [f64; 3] = [0.95, 0.8, 0.6];
/// Steps that the last piece lasts at most: in a longer one the motion would not be what it stands for.
const LONGEST_LAST: f64 = 1.5;
/// Share of a short cell that is left behind a rest at least.
const LEAST_PART_LEFT: f64 = 0.25;
/// Servo cycles that the pieces last at least with which it stops, or comes to its rate.
const SHORTEST: f64 = 0.5;
/// Servo cycles that are left of a cell at least behind a node where the clock begins to go evenly within it.
const LEAST_CYCLES_LEFT: f64 = 2.0;

/// The rest that the plan comes to anyway is taken if the shortest stop takes as long but for this factor and
/// so many servo cycles.
const LATER: f64 = 1.05;
const LATER_CYCLES: f64 = 3.0;

/// What the motion slows down to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal {
    /// Rest.
    Rest(Halt),
    /// What overrides ask for.
    Overrides(Overrides),
}

/// What the beginning of a stop has come to.
#[derive(Clone, Copy, Debug)]
pub enum Begun<S> {
    /// It is under way, in a draft.
    Attempt((Proposal, Stage<S>)),
    /// The motion as agreed comes to rest hardly later.
    Soon,
    /// The motion cannot be cut there.
    Nothing,
}

/// A march under way.
#[derive(Clone, Copy, Debug)]
pub struct Slowing<S> {
    pub(super) place: Place<S>,
    /// Duration of a step, s.
    pub(super) step: S,
    /// Share of the limits.
    pub(super) share: S,
    /// Whether by the stop limits.
    pub(super) quick: bool,
    /// Whether the next step is to be a shorter one.
    pub(super) shorter: bool,
    /// Pieces handed over.
    pub(super) pieces: usize,
    /// How far the stage has got, if it is one.
    pub staging: Staging<S>,
}

impl<S: Scalar> Slowing<S> {
    /// Duration of the next step, s.
    pub(super) fn next<const NODES: usize>(&self) -> S {
        if self.pieces > NODES / MANY { self.step * S::of(LONGER) } else { self.step }
    }
}

/// How far the march has got.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<S> {
    /// Station from which the cell starts.
    pub(super) cell: usize,
    /// What the clock shows since then, s.
    pub(super) shown: S,
    pub(super) clock: Clock<S>,
}

/// Agreed pieces, as far as they are needed.
pub(super) struct Ahead<S, const N: usize> {
    first: usize,
    shapes: heapless::Vec<Shape<S, N>, CELLS>,
}

impl<S: Scalar, const N: usize> Ahead<S, N> {
    /// From the cell of station `first` on, over which this piece is agreed.
    pub(super) fn from(first: usize, agreed: &Piece<S, N>) -> Option<Self> {
        let mut shapes = heapless::Vec::new();
        shapes.push(Shape::of(agreed)).ok()?;
        Some(Self { first, shapes })
    }
}

/// A piece to be made: of a run of the clock over the agreed piece between two instants of that, s from its start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg<S> {
    pub(super) run: Run<S>,
    pub(super) shows: [S; 2],
    pub(super) sequel: Sequel,
}

impl<S: Scalar> Leg<S> {
    pub(super) fn piece<const N: usize>(&self, agreed: &Piece<S, N>) -> Piece<S, N> {
        self.run.piece(agreed, self.shows, self.sequel)
    }

    /// Whether that keeps all limits.
    pub(super) fn keeps<const N: usize>(
        &self,
        agreed: &Piece<S, N>,
        limits: &Limits<S, N>,
    ) -> bool {
        self.run.keeps(agreed, self.shows, limits)
    }
}

/// What becomes of a clock that is let go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Released<S> {
    /// Steps in which it goes evenly.
    pub(super) steps: u8,
    /// Its rate then; 0 if it stops.
    pub(super) rate: S,
}

impl<S: Scalar> Released<S> {
    /// It has stopped.
    pub(super) const STOPPED: Self = Self { steps: 0, rate: S::ZERO };
}

/// What comes of a step: one leg, or the two or one that stop the clock; and where it leads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stepped<S> {
    pub(super) legs: [Option<Leg<S>>; 2],
    pub(super) to: Place<S>,
    pub(super) release: Released<S>,
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Begins a stop, or a stage of it, or one of slowing down to overrides. There is a draft afterwards only if there is an attempt.
    pub(super) fn begin_slowing(
        &mut self,
        start: Start<S>,
        (attempt, quick): (u8, bool),
        goal: Goal,
        mut staging: Staging<S>,
    ) -> Begun<S> {
        let mut soon = false;
        let begun = self.draft(|draft| {
            let (share, longer) = *SHARES.get(usize::from(attempt) % SHARES.len())?;
            let (first, branch, clock) = draft.branch_off(start, &mut staging)?;
            draft.window.measure(first);
            let stretch = draft.stretch_from(first);
            let halt = match goal {
                Goal::Rest(halt) => Some(halt),
                Goal::Overrides(asked) => {
                    staging.floor = draft.rate_for(stretch, asked)?;
                    None
                }
            };
            let from = clock.run(draft.window.get(first)?.state);
            let least = draft.stop_time(first, from, &draft.limits_over(first, quick));
            soon = draft.rests_soon(stretch, least);
            if soon {
                return None;
            }
            let step =
                (least * S::of(1.0 / STEPS)).greatest(draft.config.cycle * S::of(LEAST_CYCLES));
            let place = Place { cell: first, shown: S::ZERO, clock };
            let step = step * S::of(longer);
            let share = S::of(share);
            let slowing = Slowing { place, step, share, quick, shorter: false, pieces: 0, staging };
            let proposal = Proposal { stretch, branch, halt };
            Some((proposal, Stage::Slowing(slowing)))
        });
        match begun {
            Some(begun) => Begun::Attempt(begun),
            None if soon => Begun::Soon,
            None => Begun::Nothing,
        }
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

    /// A slice of it.
    pub fn go_on_slowing(
        &mut self,
        slowing: &mut Slowing<S>,
        proposal: &mut Proposal,
        hand_over: impl FnMut(&Piece<S, N>),
    ) -> Marched<S> {
        match slowing.staging.released {
            Some(release) => self.go_on_releasing(slowing, release, proposal, hand_over),
            None => self.march_on(slowing, proposal, hand_over),
        }
    }

    /// Some steps, whose pieces are handed over.
    #[inline(never)]
    fn march_on(
        &mut self,
        slowing: &mut Slowing<S>,
        proposal: &mut Proposal,
        mut hand_over: impl FnMut(&Piece<S, N>),
    ) -> Marched<S> {
        let stretch = proposal.stretch;
        let mut ahead = Ahead { first: slowing.place.cell, shapes: heapless::Vec::new() };
        let mut strides = STRIDES;
        for left in (0..STEPS_PER_SLICE).rev() {
            if strides < STRIDES / 2 {
                break;
            }
            if slowing.pieces + 3 > NODES {
                return Marched::Nothing;
            }
            let Some(agreed) = self.agreed_piece(slowing.place.cell) else {
                return Marched::Nothing;
            };
            if ahead.shapes.is_empty() && ahead.shapes.push(Shape::of(&agreed)).is_err() {
                return Marched::Nothing;
            }
            let Some(mut stepped) =
                self.step(slowing, &agreed, stretch, (&mut ahead, &mut strides))
            else {
                if slowing.shorter {
                    return slowing.end_stage();
                }
                slowing.shorter = true;
                return Marched::Working;
            };
            slowing.shorter = false;
            let to = stepped.to;
            let stops = to.clock == Clock::STOPPED;
            let Some(end) = (if stops { self.put_rest_at(to) } else { Some(to.cell) }) else {
                return slowing.end_stage();
            };
            let rests = stops || end == stretch.last;
            if rests && slowing.staging.falls() {
                return Marched::Nothing;
            }
            if !rests {
                let ends_slice = left == 0 || strides < STRIDES / 2;
                self.hand_over_behind(&mut stepped, slowing, proposal, ends_slice);
            }
            for leg in stepped.legs.iter().flatten() {
                let mut piece = leg.piece(&agreed);
                if rests
                    && leg.sequel != Sequel::Within
                    && let Some(station) = self.window.get(end)
                {
                    piece.sequel = Sequel::Stop;
                    piece.end_at(&station.node.at);
                }
                hand_over(&piece);
            }
            slowing.pieces += 1;
            slowing.step = slowing.next::<NODES>();
            if rests {
                return self.rest_at(stretch.first, end, proposal);
            }
            slowing.place = stepped.to;
            if slowing.staging.released.is_some() {
                return Marched::Working;
            }
        }
        Marched::Working
    }

    /// Puts a station where the clock stops, unless that is too near to another: then nothing has changed.
    #[inline(never)]
    pub(super) fn put_rest_at(&mut self, place: Place<S>) -> Option<usize> {
        let fits = self.has_room_at(place)?;
        (fits && self.cut_at_rest(place.cell, place.shown)).then_some(place.cell + 1)
    }

    /// Whether a place lies behind the station before it, and apart from the next, to which the motion will go on from rest: where
    /// cells are short, so far that its part is not much shorter than they are. Up to the rest they are run once, as the motion
    /// slows down: it may be as near as it is to a motion that is slow.
    // What it needs of the stack is not needed while the station is put in.
    #[inline(never)]
    fn has_room_at(&self, place: Place<S>) -> Option<bool> {
        let station = self.window.get(place.cell)?;
        let (whole, apart) = (station.cell.length, self.apart(station.bounds.jerk));
        let cut = self.station_within(place.cell, place.shown)?;
        let mut before = *station;
        before.lead_to(&cut.node.at, cut.agreed, place.shown);
        let length = before.cell.length;
        Some(length > S::ZERO && whole - length > apart.least(whole * S::of(LEAST_PART_LEFT)))
    }

    /// The march has come to station `last`, at which the motion rests.
    pub(super) fn rest_at(
        &mut self,
        first: usize,
        last: usize,
        proposal: &mut Proposal,
    ) -> Marched<S> {
        for i in last..self.window.len() {
            self.window.set_state(i, PathState::REST);
        }
        let end = self.window.serial(last);
        self.mark_slowing(end, Handover::none(end));
        proposal.stretch = Stretch { first, last, open: false };
        Marched::Rests
    }

    /// What the axes do as agreed from station `i`.
    #[inline(never)]
    pub(super) fn ahead<'a>(
        &self,
        i: usize,
        ahead: &'a mut Ahead<S, N>,
    ) -> Option<&'a Shape<S, N>> {
        let wanted = i.checked_sub(ahead.first)?;
        // At most as many as there is room for.
        while ahead.shapes.len() <= wanted {
            let next = self.agreed_piece(ahead.first + ahead.shapes.len())?;
            ahead.shapes.push(Shape::of(&next)).ok()?;
        }
        ahead.shapes.get(wanted)
    }

    /// The hardest step from a place.
    #[inline(never)]
    fn step(
        &self,
        slowing: &Slowing<S>,
        piece: &Piece<S, N>,
        stretch: Stretch,
        (ahead, strides): (&mut Ahead<S, N>, &mut usize),
    ) -> Option<Stepped<S>> {
        let Slowing { place, step: mut longest, share, quick, .. } = *slowing;
        let mut next = slowing.next::<NODES>();
        if slowing.shorter {
            (longest, next) = (longest * S::of(SHORTER), next * S::of(SHORTER));
        }
        let limits = &self.limits_over(place.cell, quick);
        let shape = Shape::of(piece);
        let step = Stride::new(&shape, place, longest);
        let [least, most] = step.bends(limits, share)?;
        let floor = slowing.staging.floor;
        if !slowing.staging.falls()
            && let Some(stops) = self.stop(piece, place, ([least, most], longest), limits)
        {
            return Some(stops);
        }
        let asked = (next, share, quick, floor);
        let mut good = |bend: S, least: usize| {
            *strides = (*strides).max(least);
            self.at_bend(bend, (&step, piece, limits), asked, stretch, (ahead, strides))
        };
        if let Some(hardest) = good(least, 0) {
            return Some(hardest);
        }
        // Even again, or on the way there.
        let sure = step.release(step.bends(limits, share * S::of(RELEASED))?);
        let (mut hard, mut soft) = (least, sure);
        let mut found = None;
        let halvings = if slowing.staging.pressed { FEW_HALVINGS } else { HALVINGS };
        for _ in 0..halvings {
            let bend = (hard + soft) * S::of(0.5);
            match good(bend, 0) {
                Some(stepped) => (soft, found) = (bend, Some(stepped)),
                None => hard = bend,
            }
        }
        found.or_else(|| good(soft, RELEASE_STEPS))
    }

    /// A step at a bend, if it keeps all limits and the clock can go evenly behind it.
    #[inline(never)]
    fn at_bend(
        &self,
        bend: S,
        (step, piece, limits): (&Stride<'_, S, N>, &Piece<S, N>, &Limits<S, N>),
        asked: (S, S, bool, S),
        stretch: Stretch,
        (ahead, strides): (&mut Ahead<S, N>, &mut usize),
    ) -> Option<Stepped<S>> {
        let (leg, to) = step.take(bend)?;
        let most = S::ONE.greatest(step.place.clock.rate);
        if !(to.clock.rate <= most && leg.keeps(piece, limits)) {
            return None;
        }
        let release = self.evens_out(to, asked, stretch, (ahead, strides))?;
        Some(Stepped { legs: [Some(leg), None], to, release })
    }

    /// The last pieces, if the clock can be stopped within a step or two.
    #[inline(never)]
    pub(super) fn stop(
        &self,
        piece: &Piece<S, N>,
        place: Place<S>,
        ([least, most], longest): ([S; 2], S),
        limits: &Limits<S, N>,
    ) -> Option<Stepped<S>> {
        let times = [self.config.cycle * S::of(SHORTEST), longest];
        let runs = |stops: &Stepped<S>| {
            let mut legs = stops.legs.iter().flatten();
            legs.all(|leg| leg.keeps(piece, limits))
        };
        stop_at_once(piece, place, (most, times)).filter(runs).or_else(|| {
            let bend = most.least(-least);
            LAST.iter().find_map(|share| {
                stop_in_two(piece, place, (bend * S::of(*share), times)).filter(runs)
            })
        })
    }

    /// What bounds the motion over the cell of station `i`. Where other limits come into effect behind it, neither is exceeded:
    /// what comes then goes on from there.
    #[inline(never)]
    pub(super) fn limits_over(&self, i: usize, quick: bool) -> Limits<S, N> {
        let sets = LimitSets::new(&self.config, &self.older);
        let number = |i| self.window.get(i).map(|station| station.cell.programmed.limits);
        let (here, behind) = (number(i).unwrap_or_default(), number(i + 1));
        let mut limits = *sets.of(here);
        if let Some(behind) = behind.filter(|behind| *behind != here) {
            limits = limits.with_less(sets.of(behind));
        }
        match &self.config.stop_limits {
            Some(stop) if quick => limits.with_more(stop),
            _ => limits,
        }
    }

    /// How the clock can go evenly again from a place on, within the limits, faster than at a least rate, or be stopped where that is none; `None` if it
    /// cannot.
    #[inline(never)]
    fn evens_out(
        &self,
        mut place: Place<S>,
        (longest, share, quick, floor): (S, S, bool, S),
        stretch: Stretch,
        (ahead, strides): (&mut Ahead<S, N>, &mut usize),
    ) -> Option<Released<S>> {
        for steps in 0..RELEASE_STEPS as u8 {
            if !(place.clock.rate > floor) {
                return None;
            }
            if place.clock.is_nearly_even(longest) || place.cell >= stretch.last {
                let rate = place.clock.rate;
                return (rate <= S::ONE).then_some(Released { steps, rate });
            }
            *strides = strides.checked_sub(1)?;
            let shape = self.ahead(place.cell, ahead)?;
            let step = Stride::new(shape, place, longest);
            let limits = self.limits_over(place.cell, quick);
            let bends = step.bends(&limits, share * S::of(RELEASED))?;
            if !(floor > S::ZERO) && step.may_stop(bends, longest) {
                return Some(Released { steps: steps + 1, rate: S::ZERO });
            }
            (_, place) = step.end(step.release(bends))?;
        }
        None
    }
}

/// A step within a cell, or to its end.
pub(super) struct Stride<'a, S, const N: usize> {
    shape: &'a Shape<S, N>,
    place: Place<S>,
    /// Duration, s, unless it goes to the end of the cell: then about that.
    time: S,
    to_end: bool,
    /// What the axes do at its beginning.
    from: Instant<S, N>,
}

impl<'a, S: Scalar, const N: usize> Stride<'a, S, N> {
    #[inline(never)]
    pub(super) fn new(shape: &'a Shape<S, N>, place: Place<S>, longest: S) -> Self {
        let Place { shown, clock, .. } = place;
        let half = S::of(0.5);
        let from = Instant::of(&shape.axes, shown);
        let longest = longest.least(
            (from.time_scale() / clock.rate * S::of(CALM)).greatest(longest * S::of(LEAST_PART)),
        );
        // About as fast as it goes in the middle of a step.
        let rate = (clock.rate + clock.slope * longest * half).greatest(clock.rate * half);
        let rest = (shape.time - shown) / rate;
        let to_end = rest < longest * S::of(NEAR);
        let time = if to_end {
            rest
        } else if rest < longest * S::of(HALF_WAY) {
            rest * half
        } else {
            longest
        };
        Self { shape, place, time, to_end, from }
    }

    /// How long the agreed motion takes for its cell, s.
    pub(super) fn cell_time(&self) -> S {
        self.shape.time
    }

    /// How long it takes, s, about that if it goes to the end of the cell.
    pub(super) fn time(&self) -> S {
        self.time
    }

    /// The same for another time, s, or to the end of the cell in about that time.
    pub(super) fn lasting(&self, time: S, to_end: bool) -> Self {
        Self { time, to_end, ..*self }
    }

    /// Becomes one at whose end the clock has come to a rate, with the one bend and in the time that it takes, or to the end of the cell where
    /// hardly anything would be left of that. Returns the bend; `None` if it would be too short or go beyond the cell: then it stays.
    pub(super) fn land(
        &mut self,
        rate: S,
        (end, time, bends): (S, S, [S; 2]),
        cycle: S,
    ) -> Option<S> {
        let Place { shown, clock, .. } = self.place;
        let left = (self.shape.time - shown - clock.shown(time, end)) / rate;
        if !(left > S::ZERO) || time < cycle * S::of(SHORTEST) {
            return None;
        }
        self.to_end = left < cycle * S::of(LEAST_CYCLES_LEFT);
        if self.to_end {
            self.time = time + left;
            return Some(self.release(bends));
        }
        self.time = time;
        Some(end.least(bends[1]))
    }

    /// The bends at which the limits are kept.
    #[inline(never)]
    pub(super) fn bends(&self, limits: &Limits<S, N>, share: S) -> Option<[S; 2]> {
        let Place { shown, clock, .. } = self.place;
        let last = if self.to_end {
            self.shape.time
        } else {
            (shown + clock.shown(self.time, S::ZERO)).least(self.shape.time)
        };
        let ends = [&self.from, &Instant::of(&self.shape.axes, last)];
        clock.bends(ends, self.time, (limits, share))
    }

    /// The bend after which the clock goes evenly, or else the greatest.
    #[inline(never)]
    pub(super) fn release(&self, [least, most]: [S; 2]) -> S {
        most.least(-self.place.clock.slope / self.time).greatest(least)
    }

    /// Whether one piece more would stop the clock.
    pub(super) fn may_stop(&self, [_, most]: [S; 2], longest: S) -> bool {
        let Place { shown, clock, .. } = self.place;
        clock.end().is_some_and(|(bend, time)| {
            bend <= most * S::of(RELEASED)
                && time <= longest * S::of(LONGEST_LAST)
                && shown + clock.shown(time, bend) < self.shape.time
        })
    }

    /// How long it takes at a bend, s, and where it ends; `None` if the clock stops or the cell ends before.
    #[inline(never)]
    pub(super) fn end(&self, bend: S) -> Option<(S, Place<S>)> {
        let Place { cell, shown, clock } = self.place;
        let left = self.shape.time - shown;
        if self.to_end {
            let time = clock.when(left, bend, self.time)?;
            let place = Place { cell: cell + 1, shown: S::ZERO, clock: clock.after(time, bend) };
            return Some((time, place));
        }
        let (time, last) = (self.time, shown + clock.shown(self.time, bend));
        let after = clock.after(time, bend);
        let within = last > shown && last < self.shape.time && clock.goes_on(time, bend);
        within.then_some((time, Place { cell, shown: last, clock: after }))
    }

    /// The same with its piece.
    #[inline(never)]
    pub(super) fn take(&self, bend: S) -> Option<(Leg<S>, Place<S>)> {
        let (about, to) = self.end(bend)?;
        let (last, sequel) = if self.to_end {
            (self.shape.time, Sequel::Motion)
        } else {
            (to.shown, Sequel::Within)
        };
        let Place { shown, clock, .. } = self.place;
        let time = clock.exactly([shown, last], about, bend);
        let to = Place { clock: clock.after(time, bend), ..to };
        let run = Run { time, bend, from: clock, to: to.clock };
        Some((Leg { run, shows: [shown, last], sequel }, to))
    }
}

/// The piece that stops a clock which slows down, at no more than a bend. `None` if it takes too short or too long, or goes beyond
/// the cell.
fn stop_at_once<S: Scalar, const N: usize>(
    piece: &Piece<S, N>,
    place: Place<S>,
    (most, times): (S, [S; 2]),
) -> Option<Stepped<S>> {
    let (bend, time) = place.clock.end()?;
    let (leg, to) = last_leg(piece, place, (bend, time), times).filter(|_| bend <= most)?;
    Some(Stepped { legs: [None, Some(leg)], to, release: Released::STOPPED })
}

/// The pieces that stop the clock from a place on, at a bend to and fro. `None` if they take too short or too long, or go beyond
/// the cell.
fn stop_in_two<S: Scalar, const N: usize>(
    piece: &Piece<S, N>,
    place: Place<S>,
    (bend, times): (S, [S; 2]),
) -> Option<Stepped<S>> {
    let Place { shown, clock, .. } = place;
    let [first, second] = clock.stop(bend)?;
    let [shortest, longest] = times;
    if first < shortest || first > longest {
        return None;
    }
    let until = shown + clock.shown(first, -bend);
    let first = clock.exactly([shown, until], first, -bend);
    let middle = clock.after(first, -bend);
    let turn = Place { shown: until, clock: middle, ..place };
    let run = Run { time: first, bend: -bend, from: clock, to: middle };
    let begins = Leg { run, shows: [shown, until], sequel: Sequel::Within };
    let (ends, to) = last_leg(piece, turn, (bend, second), times)?;
    Some(Stepped { legs: [Some(begins), Some(ends)], to, release: Released::STOPPED })
}

/// The last piece: at a bend for some time, s, after which the clock has stopped.
fn last_leg<S: Scalar, const N: usize>(
    piece: &Piece<S, N>,
    place: Place<S>,
    (bend, time): (S, S),
    [shortest, longest]: [S; 2],
) -> Option<(Leg<S>, Place<S>)> {
    let Place { shown, clock, .. } = place;
    let last = shown + clock.shown(time, bend);
    let lasts = time >= shortest && time <= longest * S::of(LONGEST_LAST);
    if !lasts || !(clock.rate > S::ZERO) || !(last < piece.time) {
        return None;
    }
    let run = Run { time, bend, from: clock, to: Clock::STOPPED };
    let leg = Leg { run, shows: [shown, last], sequel: Sequel::Stop };
    Some((leg, Place { shown: last, clock: Clock::STOPPED, ..place }))
}
