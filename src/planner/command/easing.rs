//! The first answer to a lowered override: the motion slows down to what is asked for at once, whatever the whole answer takes.
//!
//! The agreed motion is run by a clock that slows down ([`clock`](crate::profile::clock)), as for a hold ([`super::slowing`]), until it goes
//! evenly at the rate at which the fastest cell is as fast as it is asked to be, and evenly from there on. A motion by a clock that goes evenly
//! and slower keeps all limits wherever it goes: nothing has to be looked for behind the march, and no solver is asked.
//! The march takes steps of constant bend, each within a cell, and each as hard as the limits allow - provided that the clock
//! could go evenly again from its end on without having become slower than it is to be. Whether it could is tried by marching on
//! with the greatest bends. Where one bend more takes the clock to its rate, it is the last.
//!
//! At the end of every step a station is put in, with the speed and the acceleration of the motion there: to all that comes after
//! it the motion is one like any other, and a hold, another override or the whole answer branches off from within the march, too.
//!
//! Cells that are slow because the path bends are slower than they need be; the whole answer ([`super::retune`]) makes that good. Until it has
//! been taken it is owed ([`Horizon::is_eased`]), also where the override has been raised again.

use super::Flow;
use super::slowing::{Ahead, Place, Stride};
use crate::machine::{LEAST_CYCLE_SHARE, LimitSets, Limits, UNLIMITED};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::making::{Purpose, Stage};
use crate::planner::phase::Halt;
use crate::profile::barrier::Slack;
use crate::profile::clock::Clock;
use crate::profile::law::{Law, PathState};
use crate::profile::relaxation::Relaxation;
use crate::profile::rows::rows;
use crate::profile::solver::Stretch;
use crate::profile::window::Station;
use crate::servo::control::Overrides;

/// Steps of a fall on a straight.
const STEPS: f64 = 9.0;
/// Servo cycles that a step takes at least.
const LEAST_CYCLES: f64 = 3.0;
/// Steps that a march takes at most.
const MOST_STEPS: u8 = 80;
/// Steps in which the clock must be able to go evenly again.
const RELEASE_STEPS: usize = 24;
/// Share of the limits with which that is tried: what is known of a step before it is taken is not exact.
const RELEASED: f64 = 0.92;
/// Where no step can be taken, one so much shorter is tried.
const SHORTER: f64 = 0.5;
/// Halvings in the search for the hardest bend.
const HALVINGS: u32 = 3;
/// Steps taken in one slice, and strides of the clock that may be tried for them.
const STEPS_PER_SLICE: usize = 2;
const STRIDES: u16 = 48;
/// Steps that the last one lasts at most: in a longer one the motion would not be what it stands for.
const LONGEST_LAST: f64 = 1.5;
/// Shares of the greatest bend that are tried where none leads to the rate.
const SOFTER: [f64; 5] = [1.0, 0.9, 0.75, 0.6, 0.45];
/// Above its rate by less than this share of it, a clock is nearly there.
const NEARLY: f64 = 0.03;
/// Share of the speed that is asked for below which a motion is far from it.
const FAR_BELOW: f64 = 0.2;
/// Servo cycles that are left of a cell at least where the motion has come to its speed in it.
const LEAST_LEFT: f64 = 2.0;
/// The clock may become slower than it is to be by this share.
const SLOWER: f64 = 0.01;
/// And may go evenly when it is faster by no more than this.
const FASTER: f64 = 1.0e-4;
/// Stations that are kept for the last steps.
const KEPT: usize = 2;
/// Shares of the limits, attempt by attempt.
const SHARES: [f64; 4] = [1.0, 0.95, 0.88, 0.75];
/// Attempts in a row.
pub const ATTEMPTS: usize = SHARES.len();
/// A march under way.
#[derive(Clone, Copy, Debug)]
pub struct Easing<S> {
    /// Station from which it goes on.
    cell: usize,
    clock: Clock<S>,
    /// Rate at which it is to go evenly.
    rate: S,
    /// Duration of a step, s.
    step: S,
    /// Share of the limits.
    share: S,
    /// Steps that it may still take.
    left: u8,
}

/// What may be looked at for a step.
struct Look<'a, S, const N: usize> {
    ahead: Ahead<S, N>,
    /// Station at which the motion rests.
    rest: usize,
    /// Strides that are left.
    strides: &'a mut u16,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Begins to slow down to other overrides, if a speed that is agreed is above what they ask for. Whether that was looked into
    /// in this slice.
    pub(super) fn ease(&mut self, asked: Overrides, at: NodeSerial) -> bool {
        if self.pressing.eased == Some(asked) {
            return false;
        }
        if !asked.lowers(self.horizon.overrides()) && !self.horizon.is_eased() {
            self.pressing.eased = Some(asked);
            return false;
        }
        if self.fall(asked, at) {
            return true;
        }
        if self.is_falling(asked, at) {
            return false;
        }
        // Before anything is cut: where no speed is too great, the whole answer is begun in this slice.
        let first = self.horizon.window.clamped_index(at);
        if self.horizon.excess(first..self.horizon.end_index(), asked).is_none() {
            self.pressing.eased = Some(asked);
            return false;
        }
        let Some(moment) = self.moment_of_first_answer() else { return false };
        self.pressing.eased = Some(asked);
        let (halt, attempt) = (self.phase.halt(), self.pressing.easings);
        let begun = self.horizon.draft(|draft| draft.begin_easing(moment, (asked, attempt), halt));
        self.make((Purpose::Easing(asked), at), begun);
        true
    }

    /// An attempt has come to nothing: there is another, or none.
    pub(in crate::planner) fn ease_again(&mut self) {
        self.pressing.easings += 1;
        if usize::from(self.pressing.easings) < ATTEMPTS {
            self.pressing.eased = None;
        } else {
            self.pressing.easings = 0;
        }
    }
}

/// The time, s, in which a speed falls by so much on a straight.
pub(super) fn time_of_fall<S: Scalar>(less: S, acceleration: S, jerk: S) -> S {
    if less * jerk < acceleration * acceleration {
        S::of(2.0) * (less / jerk).sqrt()
    } else {
        less / acceleration + acceleration / jerk
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    fn begin_easing(
        &mut self,
        moment: Moment<S>,
        (asked, attempt): (Overrides, u8),
        halt: Option<Halt>,
    ) -> Option<(Proposal, Stage<S>)> {
        let share = *SHARES.get(usize::from(attempt) % ATTEMPTS)?;
        let (first, branch) = self.cut_in(moment)?;
        let last = self.end_index();
        let (rate, fastest) = self.excess(first..last, asked)?;
        if self.gets_going(first, asked) || !(rate < S::of(1.0 - NEARLY)) {
            return None;
        }
        let cell = self.falls_from(first, fastest, rate);
        let step = (self.fall_time(cell, rate) * S::of(1.0 / STEPS))
            .greatest(self.config.cycle * S::of(LEAST_CYCLES));
        let mut stretch = Stretch { first, last, open: false };
        stretch.open = halt.is_none() && self.is_open(stretch);
        let easing = Easing {
            cell,
            clock: Clock::NORMAL,
            rate,
            step,
            share: S::of(share),
            left: MOST_STEPS,
        };
        Some((Proposal { stretch, branch, halt }, Stage::Easing(easing)))
    }

    /// Whether the motion is far below what it was asked for and below what it is asked for now, and would be if it let go of its acceleration: a clock
    /// that goes slower would keep it there.
    #[inline(never)]
    pub(super) fn gets_going(&self, first: usize, asked: Overrides) -> bool {
        self.window.get(first).zip(self.goal_at(first, asked)).is_some_and(|(station, goal)| {
            let PathState { b, a } = station.agreed;
            let [_, jerk] = self.limits_over(first, false).along(&station.node.tangent);
            let gains = a.greatest(S::ZERO) * a / (jerk + jerk);
            b.sqrt() + gains < goal.least(station.bounds.goal * S::of(FAR_BELOW))
        })
    }

    /// The last station from which the motion can come down to a rate before the cell of station `fastest`, or else `first`.
    pub(super) fn falls_from(&self, first: usize, fastest: usize, rate: S) -> usize {
        let mut left = self.fall_time(fastest, rate);
        for i in (first..fastest).rev() {
            if !(left > S::ZERO) {
                return i + 1;
            }
            left -= self.agreed_time(i);
        }
        first
    }

    /// The time, s, in which the speed of a station would fall to a share of it on a straight.
    #[inline(never)]
    fn fall_time(&self, i: usize, rate: S) -> S {
        let Some(station) = self.window.get(i) else { return S::ZERO };
        let speed = station.agreed.b.sqrt().greatest(station.bounds.goal);
        let [acceleration, jerk] = self.limits_over(i, false).along(&station.node.tangent);
        time_of_fall(speed * (S::ONE - rate), acceleration, jerk)
    }

    /// A slice of it: some steps, or what lies behind the march.
    #[inline(never)]
    pub fn go_on_easing(&mut self, easing: &mut Easing<S>, proposal: &mut Proposal) -> Flow {
        if self.is_eased_to(easing) {
            return self.end_easing(easing, proposal);
        }
        let mut strides = STRIDES;
        for _ in 0..STEPS_PER_SLICE {
            // The next one may take more than what is left.
            if strides < STRIDES / 2 || self.is_eased_to(easing) {
                break;
            }
            if easing.left == 0 {
                return Flow::Nothing;
            }
            let Some(Place { cell, shown, clock }) = self.ease_over(easing, &mut strides) else {
                return Flow::Nothing;
            };
            let mut next = cell;
            if cell == easing.cell {
                if self.is_brief(easing, shown, clock) || !self.cut_agreed(cell, shown) {
                    return Flow::Nothing;
                }
                proposal.stretch.last += 1;
                next += 1;
            }
            self.run_by(next, clock);
            (easing.cell, easing.clock, easing.left) = (next, clock, easing.left - 1);
        }
        Flow::Working
    }

    /// Whether one of the parts would be run in less than any cell takes into which the next step would cut its cell, `shown` seconds from its
    /// start by a clock that ends as `clock`: a tick passes few cells.
    fn is_brief(&self, easing: &Easing<S>, shown: S, clock: Clock<S>) -> bool {
        let least = self.config.cycle * S::of(LEAST_CYCLE_SHARE);
        let left = self.agreed_time(easing.cell) - shown;
        shown + shown < least * (easing.clock.rate + clock.rate) || left < least * clock.rate
    }

    /// Whether the clock goes as it is to go, or the motion rests.
    fn is_eased_to(&self, easing: &Easing<S>) -> bool {
        easing.is_even() || easing.cell >= self.stretch_from(easing.cell).last
    }

    /// Gives a station the state of the agreed motion as it is run by a clock there.
    fn run_by(&mut self, i: usize, clock: Clock<S>) {
        if let Some(station) = self.window.get_mut(i) {
            station.state = by_clock(station, clock);
        }
    }

    /// Whether the motion from station `i` to a place in its cell, or at its end, keeps all limits.
    #[inline(never)]
    fn runs_to(&self, i: usize, Place { cell, shown, clock }: Place<S>) -> bool {
        let Some((station, next)) = self.window.pair(i) else { return false };
        if cell > i {
            return self.runs_between(station, next, by_clock(next, clock));
        }
        let Some(cut) = self.station_within(i, shown) else { return false };
        let mut part = *station;
        part.lead_to(&cut.node.at, cut.agreed, shown);
        self.runs_between(&part, &cut, by_clock(&cut, clock))
    }

    /// Whether the motion from a station to a state at another keeps all limits.
    fn runs_between(
        &self,
        station: &Station<S, N>,
        next: &Station<S, N>,
        to: PathState<S>,
    ) -> bool {
        let Some(law) = Law::new(station.cell.length, station.state, to) else { return false };
        let mut view = station.view(next, LimitSets::new(&self.config, &self.older));
        // It is no faster than the agreed motion.
        view.bounds.speed = S::of(UNLIMITED);
        let mut slack = Slack::new(Relaxation::STRICT);
        rows(&view, &law, &mut slack);
        !slack.is_broken()
    }

    /// The clock goes evenly from here on.
    fn end_easing(&mut self, easing: &Easing<S>, proposal: &Proposal) -> Flow {
        let Stretch { first, last, .. } = proposal.stretch;
        let rests = self.window.get(easing.cell).is_some_and(|station| station.rest);
        // Behind a rest the motion is as much slower as it was to be.
        let rate = if rests { easing.rate } else { easing.clock.rate };
        for i in easing.cell + 1..last {
            self.run_by(i, Clock { rate, slope: S::ZERO });
        }
        // It is a plan at the overrides that are in effect, though it is slower.
        self.loosen(first, last);
        self.mark_eased(easing.cell);
        // With what is left of the last cell that was cut.
        let holds = self.holds_until(proposal.stretch, easing.cell + 1);
        if holds { Flow::Ready } else { Flow::Nothing }
    }

    /// The hardest step.
    #[inline(never)]
    fn ease_over(&self, easing: &Easing<S>, strides: &mut u16) -> Option<Place<S>> {
        let piece = self.agreed_piece(easing.cell)?;
        let rest = self.stretch_from(easing.cell).last;
        let mut look = Look { ahead: Ahead::from(easing.cell, &piece)?, rest, strides };
        // What is left of the fall must do with the stations that there is room for.
        let left = self.fall_time(easing.cell, easing.rate / easing.clock.rate);
        let stations = self.room_to_add().saturating_sub(KEPT).max(1) as u32;
        let longest = easing.step.greatest(left / S::from_u32(stations));
        [S::ONE, S::of(SHORTER)].into_iter().find_map(|share| {
            let easing = Easing { step: longest * share, ..*easing };
            self.ease_step(&easing, &mut look)
        })
    }

    /// The hardest step of about a time.
    fn ease_step(&self, easing: &Easing<S>, look: &mut Look<'_, S, N>) -> Option<Place<S>> {
        let Easing { cell, clock, share, .. } = *easing;
        let limits = &self.limits_over(cell, false);
        let shape = *self.ahead(cell, &mut look.ahead)?;
        let place = Place { cell, shown: S::ZERO, clock };
        let mut stride = Stride::new(&shape, place, easing.step_of(clock));
        if self.room_to_add() == 0 {
            stride = stride.lasting(shape.time / clock.rate, true);
        }
        let [least, most] = stride.bends(limits, share)?;
        if let Some(lands) = self.land(easing, &stride, limits) {
            return Some(lands);
        }
        let mut good = |bend: S| {
            let (_, to) = stride.end(bend)?;
            let runs =
                to.clock.rate <= S::ONE && self.settles(to, easing, look) && self.runs_to(cell, to);
            runs.then_some(to)
        };
        if let Some(hardest) = good(least) {
            return Some(hardest);
        }
        // From where one step more of the same time takes the clock to its rate.
        let (time, above) = (stride.time(), clock.rate - easing.rate);
        let last_but_one = -(above / time + clock.slope * S::of(1.5)) / time;
        if last_but_one > least
            && last_but_one < most
            && let Some(place) = good(last_but_one)
        {
            return Some(place);
        }
        // Even again, or on the way there.
        let sure = stride.release(stride.bends(limits, share * S::of(RELEASED))?);
        let (mut hard, mut soft) = (least, sure);
        let mut found = None;
        for _ in 0..HALVINGS {
            let bend = (hard + soft) * S::of(0.5);
            match good(bend) {
                Some(place) => (soft, found) = (bend, Some(place)),
                None => hard = bend,
            }
        }
        found.or_else(|| good(soft)).or_else(|| {
            // Then it becomes slower than it is to be: the whole answer makes that good.
            SOFTER.iter().find_map(|softer| {
                let (_, to) = stride.end(stride.release([least, most * S::of(*softer)]))?;
                let runs = to.clock.rate <= S::ONE && self.runs_to(cell, to);
                runs.then_some(to)
            })
        })
    }

    /// The last step, by which the clock comes to its rate; or as much of it as is in this cell.
    fn land(
        &self,
        easing: &Easing<S>,
        stride: &Stride<'_, S, N>,
        limits: &Limits<S, N>,
    ) -> Option<Place<S>> {
        let Easing { cell, clock, rate, .. } = *easing;
        let room = self.room_to_add();
        let (bend, time) = easing.landing(clock, room <= 1)?;
        let [least, most] = stride.lasting(time, false).bends(limits, easing.share)?;
        if bend > most {
            return None;
        }
        let cell_time = stride.cell_time();
        let left = cell_time - clock.shown(time, bend);
        let near = self.config.cycle * S::of(LEAST_LEFT) * rate;
        let to = if left > near && room > 0 {
            let (_, to) = stride.lasting(time, false).end(bend)?;
            Place { clock: Clock { rate, slope: S::ZERO }, ..to }
        } else if left > -near || room == 0 {
            // Hardly anything would be left of the cell.
            let whole = stride.lasting(time, true);
            let (_, to) = whole.end(whole.release([least, most]))?;
            let clock = Clock { rate: to.clock.rate.least(rate), slope: S::ZERO };
            Place { clock, ..to }
        } else {
            stride.lasting(cell_time / clock.rate, true).end(bend)?.1
        };
        self.runs_to(cell, to).then_some(to)
    }

    /// Whether the clock can go evenly again from a place on, within the limits, before it is slower than it is to be.
    #[inline(never)]
    fn settles(
        &self,
        mut place: Place<S>,
        easing: &Easing<S>,
        Look { ahead, rest, strides }: &mut Look<'_, S, N>,
    ) -> bool {
        let least = easing.rate * S::of(1.0 - SLOWER);
        for _ in 0..RELEASE_STEPS {
            if place.cell >= *rest {
                return true;
            }
            if !(place.clock.rate >= least) {
                return false;
            }
            if place.clock.is_nearly_even(easing.step) {
                return place.clock.rate <= S::ONE;
            }
            let Some(left) = strides.checked_sub(1) else { return false };
            **strides = left;
            let Some(shape) = self.ahead(place.cell, ahead) else { return false };
            let stride = Stride::new(shape, place, easing.step_of(place.clock));
            let limits = self.limits_over(place.cell, false);
            let share = easing.share * S::of(RELEASED);
            let lands = easing.landing(place.clock, false).filter(|(bend, time)| {
                let bends = stride.lasting(*time, false).bends(&limits, share);
                bends.is_some_and(|[_, most]| *bend <= most)
            });
            let next = if let Some((bend, time)) = lands {
                if place.shown + place.clock.shown(time, bend) < shape.time {
                    return true;
                }
                let rest = (shape.time - place.shown) / place.clock.rate;
                stride.lasting(rest, true).end(bend)
            } else {
                let Some(bends) = stride.bends(&limits, share) else { return false };
                stride.end(stride.release(bends))
            };
            let Some((_, to)) = next else { return false };
            place = to;
        }
        false
    }
}

/// The state of a station in the agreed motion as it is run by a clock there.
#[inline(never)]
fn by_clock<S: Scalar, const N: usize>(station: &Station<S, N>, clock: Clock<S>) -> PathState<S> {
    if station.rest { PathState::REST } else { clock.run(station.agreed) }
}

impl<S: Scalar> Easing<S> {
    /// Whether the clock goes as it is to go.
    fn is_even(&self) -> bool {
        let clock = self.clock;
        clock.is_nearly_even(self.step) && clock.rate <= self.rate * S::of(1.0 + FASTER)
    }

    /// Duration of the next step, s: none takes the clock beyond its rate by its slope alone.
    fn step_of(&self, clock: Clock<S>) -> S {
        let falls = -clock.slope * self.step;
        let above = clock.rate - self.rate;
        let near = above < self.rate * S::of(NEARLY);
        if falls > above && !near { self.step * above / falls } else { self.step }
    }

    /// The one bend that takes a clock which slows down to its rate, and how long that takes, s, if it is not too long.
    fn landing(&self, clock: Clock<S>, at_once: bool) -> Option<(S, S)> {
        clock
            .above(self.rate)
            .end()
            .filter(|(_, time)| at_once || *time <= self.step * S::of(LONGEST_LAST))
    }
}
