//! Least time over a window, by a barrier method whose every iterate keeps all limits.
//!
//! Minimised is the sum of the cell times minus mu times the logarithms of what is left of every
//! limit ([`super::rows`]), over (b, a) of all stations between two fixed ones. Each step solves a
//! Newton system (second derivatives of the rows left out, so it is positive definite): a chain
//! of 2 x 2 blocks, each coupled to the next, factored in one pass forth and one back. A step is
//! shortened until every limit holds, so the method can stop after any step; mu falls towards a
//! value at which the barrier costs less than half a percent of the time.
//!
//! Work: at most `iterations` steps, each one pass with gradients over the cells of the window and
//! at most [`TRIES`] + 2 without.

use super::barrier::{Model, Slack, add_damping, add_time_curvature, by_square};
use super::chain::{Work, solve};
use super::law::{Law, State};
use super::rows::{View, rows, time_gradient};
use super::window::Window;
use crate::machine::Limits;
use crate::number::Scalar;

/// Most shortenings of one step.
const TRIES: usize = 12;
/// Most halvings of the first guess of speeds for new stations.
const SEED_TRIES: usize = 40;
/// mu at the end, in units of the machine's time scale.
const LAST_WEIGHT: f64 = 5.0e-5;
/// mu at the start of an improvement of a plan that was good before, and of a new one.
const WARM_WEIGHT: f64 = 7.5e-4;
const COLD_WEIGHT: f64 = 2.5e-2;
/// mu at the start, at least this share of the mean time of a cell.
const FIRST_SHARE: f64 = 0.05;
/// Steps in a row that found nothing better, with more damping each time, before the weight falls.
const MOST_FAILURES: u32 = 4;
/// Damping after the first step that a limit has shortened.
const LEAST_DAMPING: f64 = 0.05;
/// Share of a step that is taken when more than all of it would break a limit.
const DISTANCE: f64 = 0.7;
/// Share of acceleration and jerk that the last cell before an open end may use.
const OPEN_END_SHARE: f64 = 0.4;
/// By what mu falls once the steps get small.
const WEIGHT_FALL: f64 = 0.3;
/// A step is small when it promises less than this many mu.
const SMALL_STEP: f64 = 10.0;

/// Weight at the end of a halt, as a share of the first: by then the creep that the barrier leaves is
/// a few per cent of the speed at its start.
const HALT_SHARE: f64 = 1.0e-3;
/// How much dearer it is to be above the goal than time is at the goal.
const EXCESS_PRICE: f64 = 1.5;

/// What is minimised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// The time.
    Time,
    /// The time, and at a high price speed above the goal of a cell
    /// ([`Bounds::goal`](super::rows::Bounds)): the motion slows down to it as fast as the limits
    /// allow.
    Slow,
    /// Speed everywhere: the motion brakes as hard as the limits allow, and creeps on.
    Halt,
}

/// Workspace of the method.
pub struct Solver<S, const NODES: usize> {
    work: [Work<S>; NODES],
    aim: Aim,
    /// Price of b x length in a halt.
    price: S,
}

/// A stretch of the window to improve: stations strictly between the two are free.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    pub first: usize,
    pub last: usize,
    /// Whether it ends only because no more is known.
    pub open: bool,
}

impl<S: Scalar, const NODES: usize> Solver<S, NODES> {
    pub const fn new() -> Self {
        Self { work: [Work::EMPTY; NODES], aim: Aim::Time, price: S::ZERO }
    }

    /// Whether a station's state is to be found.
    fn is_free<const N: usize>(window: &Window<S, N, NODES>, stretch: Stretch, i: usize) -> bool {
        i > stretch.first && i < stretch.last && window.get(i).is_some_and(|station| !station.rest)
    }

    /// A cell with its limits. The last one before an end that is only the end of what is known
    /// keeps a reserve, so that the plan can be taken on from there without a break.
    fn view<'a, const N: usize>(
        &self,
        window: &'a Window<S, N, NODES>,
        stretch: Stretch,
        i: usize,
        limits: &'a Limits<S, N>,
    ) -> Option<View<'a, S, N>> {
        let (station, after) = window.pair(i)?;
        let mut view = station.view(after, limits);
        if i + 1 == stretch.last && stretch.open && !after.rest {
            view.share = S::of(OPEN_END_SHARE);
            view.bounds = view.bounds.share(view.share);
        }
        if self.aim == Aim::Slow {
            view.price = S::of(EXCESS_PRICE) * station.cell.length / station.bounds.goal;
        }
        Some(view)
    }

    /// A station's state moved by `share` of its step.
    fn trial<const N: usize>(
        &self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        i: usize,
        share: S,
    ) -> State<S> {
        let Some(station) = window.get(i) else { return State::REST };
        if i == stretch.last {
            return State::REST;
        }
        if !Self::is_free(window, stretch, i) {
            return station.state;
        }
        let step = self.work[i].step;
        State { b: station.state.b - share * step[0], a: station.state.a - share * step[1] }
    }

    /// What b at a free station costs in a halt, s per unit; else nothing.
    fn toll<const N: usize>(&self, window: &Window<S, N, NODES>, stretch: Stretch, i: usize) -> S {
        if self.aim != Aim::Halt || !Self::is_free(window, stretch, i) {
            return S::ZERO;
        }
        let Some((before, here)) = i.checked_sub(1).and_then(|i| window.pair(i)) else {
            return S::ZERO;
        };
        self.price * ((before.cell.length + here.cell.length) * S::of(0.5))
    }

    /// Time minus barrier over cells `from..to`, `None` if a limit is broken.
    fn value<const N: usize>(
        &self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        (weight, share): (S, S),
        (from, to): (usize, usize),
    ) -> Option<S> {
        let mut time = S::ZERO;
        let mut slack =
            Slack { product: S::ONE, logarithm: S::ZERO, least: S::ONE, price: S::ZERO };
        let mut here = self.trial(window, stretch, from, share);
        for i in from..to {
            let next = self.trial(window, stretch, i + 1, share);
            let station = window.get(i)?;
            if station.cell.length > S::ZERO {
                if !(here.b >= S::ZERO && next.b >= S::ZERO) {
                    return None;
                }
                let law = Law::new(station.cell.length, here, next)?;
                if self.aim != Aim::Halt {
                    time += law.time;
                }
                rows(&self.view(window, stretch, i, limits)?, &law, &mut slack);
                if !(slack.least > S::ZERO) {
                    return None;
                }
            }
            time += self.toll(window, stretch, i + 1) * next.b;
            here = next;
        }
        slack.fold();
        let value = time + slack.price - weight * slack.logarithm;
        value.is_finite().then_some(value)
    }

    /// Whether the states of a stretch keep all limits, with a rest at its end.
    pub fn holds<const N: usize>(
        &mut self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
    ) -> bool {
        self.value_here(window, stretch, limits, S::ZERO).is_some()
    }

    /// Gives the free stations from index `new` on slow speeds at which all limits hold: every cell
    /// takes about the same time, long enough. Those before keep theirs. Returns whether such a
    /// time was found.
    pub fn seed<const N: usize>(
        &mut self,
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        new: usize,
        limits: &Limits<S, N>,
    ) -> bool {
        let new = new.max(stretch.first + 1);
        let cells = (new - 1, stretch.last);
        for work in &mut self.work[cells.0..=cells.1] {
            work.step = [S::ZERO; 2];
        }
        let mut rate = S::ONE / (limits.time_scale() * S::of(0.125));
        // The first new station was the stop of the plan before: what it may have is little if
        // that plan brakes hard, and should not hold back the others.
        let mut entry = S::of(1.0e-3);
        let mut found = false;
        for _ in 0..SEED_TRIES {
            Self::seed_speeds(window, stretch, new, rate, entry);
            found = self.value(window, stretch, limits, (S::ZERO, S::ZERO), cells).is_some();
            if found {
                break;
            }
            rate = rate * S::of(0.5);
        }
        if !found {
            return false;
        }
        let best = [S::of(0.004), S::of(0.016), S::of(0.06), S::of(0.25), S::ONE];
        for wider in best {
            Self::seed_speeds(window, stretch, new, rate, wider);
            if self.value(window, stretch, limits, (S::ZERO, S::ZERO), cells).is_none() {
                break;
            }
            entry = wider;
        }
        Self::seed_speeds(window, stretch, new, rate, entry);
        true
    }

    /// Gives every new station the speed at which the shorter of its cells takes 1 / `rate`; the
    /// first one only the share `entry` of it.
    fn seed_speeds<const N: usize>(
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        new: usize,
        rate: S,
        entry: S,
    ) {
        let mut before = S::of(1.0e6);
        for i in new - 1..stretch.last {
            let Some(station) = window.get(i) else { return };
            let here = if station.cell.length > S::ZERO {
                (station.cell.length * rate).least(station.bounds.goal * S::of(0.7))
            } else {
                S::ZERO
            };
            let mut speed = before.least(here);
            before = here;
            if i >= new {
                if i == new {
                    speed = speed * entry;
                }
                let b = if Self::is_free(window, stretch, i) { speed * speed } else { S::ZERO };
                window.set_state(i, State { b, a: S::ZERO });
            }
        }
    }

    /// Improves the states of a stretch, which must keep all limits, by at most `iterations`
    /// steps; half as many again for an aim other than the time. Returns how many were taken.
    pub fn improve<const N: usize>(
        &mut self,
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        iterations: u16,
        (aim, cold): (Aim, bool),
    ) -> u16 {
        let scale = limits.time_scale();
        let mut last_weight = scale * S::of(LAST_WEIGHT);
        let mut weight = scale * S::of(if cold { COLD_WEIGHT } else { WARM_WEIGHT });
        let cells = S::from_u32((stretch.last - stretch.first) as u32);
        self.aim = aim;
        if let Some(time) = Self::time(window, stretch) {
            // Far from the least time the barrier must keep up with it, or the first steps run
            // into a corner of the limits and stay there.
            let first_weight = time / cells * S::of(FIRST_SHARE);
            if aim == Aim::Halt {
                // A halt costs as much at first as it takes time.
                self.price = S::ONE;
                self.price = time / self.tolls(window, stretch).greatest(S::of(1.0e-9));
                weight = first_weight;
                last_weight = first_weight * S::of(HALT_SHARE);
            } else {
                weight = weight.greatest(first_weight);
            }
        }
        // Answers to an operator are rare, and start farther from what is asked for.
        let more = if aim == Aim::Time { 0 } else { iterations / 2 };
        let steps = self.descend(window, stretch, limits, iterations + more, (weight, last_weight));
        self.aim = Aim::Time;
        steps
    }

    /// Sum of the tolls of a stretch.
    fn tolls<const N: usize>(&self, window: &Window<S, N, NODES>, stretch: Stretch) -> S {
        let mut sum = S::ZERO;
        for i in stretch.first..stretch.last {
            if let Some(station) = window.get(i) {
                sum += self.toll(window, stretch, i) * station.state.b;
            }
        }
        sum
    }

    /// The method itself, from one weight of the barrier to another.
    fn descend<const N: usize>(
        &mut self,
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        iterations: u16,
        (mut weight, last_weight): (S, S),
    ) -> u16 {
        let (mut damping, mut failures) = (S::ZERO, 0);
        // Value at the present states and weight, where it is known from the step before.
        let mut known = None;
        for steps in 0..iterations {
            let Some(here) =
                known.take().or_else(|| self.value_here(window, stretch, limits, weight))
            else {
                return steps;
            };
            self.assemble(window, stretch, limits, weight, damping);
            let promise = solve(&mut self.work[stretch.first..=stretch.last]);
            if !promise.is_finite() {
                // Rounding has made the system singular: take it from further inside.
                damping = (damping * S::of(16.0)).greatest(S::ONE);
                known = Some(here);
                continue;
            }
            for work in &mut self.work[stretch.first..=stretch.last] {
                work.step = work.gradient;
            }
            let (found, blocked) = self.search(window, stretch, limits, weight, here);
            damping = next_damping(damping, found.is_some(), blocked);
            if let Some((share, value)) = found {
                for i in stretch.first..=stretch.last {
                    window.set_state(i, self.trial(window, stretch, i, share));
                }
                known = Some(value);
                failures = 0;
            } else {
                known = Some(here);
                failures += 1;
            }
            let small = promise < weight * S::of(SMALL_STEP) || failures >= MOST_FAILURES;
            if small {
                if weight <= last_weight {
                    return steps + 1;
                }
                weight = (weight * S::of(WEIGHT_FALL)).greatest(last_weight);
                known = None;
            }
        }
        iterations
    }

    /// Time minus barrier over a stretch as it stands.
    fn value_here<const N: usize>(
        &mut self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        weight: S,
    ) -> Option<S> {
        for work in &mut self.work[stretch.first..=stretch.last] {
            work.step = [S::ZERO; 2];
        }
        self.value(window, stretch, limits, (weight, S::ZERO), (stretch.first, stretch.last))
    }

    /// The share of the step to take and the value there, if any share is no worse than `here`;
    /// and whether a limit stood in the way of the whole step.
    fn search<const N: usize>(
        &self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        weight: S,
        here: S,
    ) -> (Option<(S, S)>, bool) {
        let value = |share: S| {
            self.value(window, stretch, limits, (weight, share), (stretch.first, stretch.last))
        };
        let mut share = self.longest_share(window, stretch);
        let slack = here.abs() * S::EPSILON * S::of(8.0);
        let mut blocked = false;
        for _ in 0..TRIES {
            let there = value(share);
            if let Some(there) = there
                && there <= here + slack
            {
                // A limit is near: keep a distance from it, or the next steps only slide along.
                let shorter = share * S::of(DISTANCE);
                let kept = if blocked { value(shorter) } else { None };
                return (Some(kept.map_or((share, there), |kept| (shorter, kept))), blocked);
            }
            blocked |= there.is_none();
            share = share * S::of(0.5);
        }
        (None, blocked)
    }

    /// Time over a stretch, s.
    fn time<const N: usize>(window: &Window<S, N, NODES>, stretch: Stretch) -> Option<S> {
        let mut time = S::ZERO;
        for i in stretch.first..stretch.last {
            let (station, after) = window.pair(i)?;
            if station.cell.length > S::ZERO {
                let to = if i + 1 == stretch.last { State::REST } else { after.state };
                time += Law::new(station.cell.length, station.state, to)?.time;
            }
        }
        Some(time)
    }

    /// Longest share of the step that leaves every b at least a tenth of what it was.
    fn longest_share<const N: usize>(&self, window: &Window<S, N, NODES>, stretch: Stretch) -> S {
        let mut share = S::ONE;
        for i in stretch.first..stretch.last {
            if Self::is_free(window, stretch, i)
                && let Some(station) = window.get(i)
            {
                let (b, step) = (station.state.b * S::of(0.9), self.work[i].step[0]);
                if share * step > b {
                    share = b / step;
                }
            }
        }
        share
    }

    /// Gradient and second derivatives of every cell into the blocks.
    fn assemble<const N: usize>(
        &mut self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        weight: S,
        damping: S,
    ) {
        for work in &mut self.work[stretch.first..=stretch.last] {
            *work = Work::EMPTY;
        }
        for i in stretch.first..stretch.last {
            let (free0, free1) =
                (Self::is_free(window, stretch, i), Self::is_free(window, stretch, i + 1));
            let Some((station, after)) = window.pair(i) else { continue };
            if !(station.cell.length > S::ZERO) || !(free0 || free1) {
                continue;
            }
            let to = if i + 1 == stretch.last { State::REST } else { after.state };
            let Some(law) = Law::new(station.cell.length, station.state, to) else { continue };
            let timed = self.aim != Aim::Halt;
            let gradient = if timed { time_gradient(&law) } else { [S::ZERO; 4] };
            let mut model = Model { weight, gradient, hessian: [S::ZERO; 10] };
            let Some(view) = self.view(window, stretch, i, limits) else { continue };
            rows(&view, &law, &mut model);
            let (g, mut h) = by_square(&model, &law, (free0, free1));
            add_damping(
                &mut h,
                damping * law.time,
                station.cell.length,
                (station.state, to),
                (free0, free1),
            );
            let ends = (station.state, to);
            if timed {
                add_time_curvature(&mut h, station.cell.length, ends, (free0, free1));
            }
            let toll = self.toll(window, stretch, i + 1);
            let work = &mut self.work[i];
            for (sum, part) in work.block.iter_mut().zip([h[0], h[1], h[4]]) {
                *sum += part;
            }
            work.gradient[0] += g[0];
            work.gradient[1] += g[1];
            work.coupling = [h[2], h[3], h[5], h[6]];
            let work = &mut self.work[i + 1];
            for (sum, part) in work.block.iter_mut().zip([h[7], h[8], h[9]]) {
                *sum += part;
            }
            work.gradient[0] += g[2] + toll;
            work.gradient[1] += g[3];
        }
        for i in stretch.first..=stretch.last {
            if !Self::is_free(window, stretch, i) {
                let work = &mut self.work[i];
                work.block = [S::ONE, S::ZERO, S::ONE];
                work.gradient = [S::ZERO; 2];
            }
        }
    }
}

/// Damping of the next step, by how this one went.
fn next_damping<S: Scalar>(damping: S, found: bool, blocked: bool) -> S {
    let least = S::of(LEAST_DAMPING);
    if !found {
        (damping * S::of(16.0)).greatest(least)
    } else if blocked {
        (damping * S::of(4.0)).greatest(least)
    } else {
        let less = damping * S::of(0.25);
        if less < least { S::ZERO } else { less }
    }
}
