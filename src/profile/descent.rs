//! Least time over a window, by Newton's method on time and barrier.
//!
//! Two ways lead there. [`Solver::find`] starts from a guess that need not keep the limits
//! ([`super::guess`]), under a relaxed barrier ([`Edge`]): no limit stands in the way of a step, so
//! that the number of steps hardly depends on the path. While mu falls, so does the share of a
//! limit from which on the barrier is relaxed; it ends when all limits hold. [`Solver::improve`]
//! starts from states that keep all limits, and every iterate does: a step is shortened until they
//! hold, so it may be stopped after any number of steps. It serves where an answer is owed that is
//! valid whatever happens, and when the other way has failed.
//!
//! Work of either: at most `iterations` steps, each one pass with gradients over the cells of the
//! window and at most [`TRIES`] + 2 without; one and a half times as many for an aim other than
//! the time.

use super::barrier::Edge;
use super::chain::solve;
use super::solver::{Aim, Solver, Stretch, Weights};
use super::window::Window;
use crate::machine::Limits;
use crate::number::Scalar;

/// Most shortenings of one step.
const TRIES: usize = 16;
/// By what a step is shortened.
const SHORTER: f64 = 0.65;
/// Share of a step that is taken when more than all of it would break a limit.
const DISTANCE: f64 = 0.9;
/// A step counts as taken from this share on.
const WHOLE_STEP: f64 = 0.6;
/// mu at the end, in units of the machine's time scale: by then the barrier costs less than half a
/// per cent of the time.
const LAST_WEIGHT: f64 = 5.0e-5;
/// mu at the start, in units of the machine's time scale; and at least this share of the mean time of
/// a cell: far from the least time the barrier must keep up with it, or the first steps run into
/// a corner of the limits and stay there.
const FIRST_WEIGHT: f64 = 7.5e-4;
const FIRST_SHARE: f64 = 0.05;
/// Weight at the end of a halt, as a share of the first: by then the creep that the barrier leaves is
/// a few per cent of the speed at its start.
const HALT_SHARE: f64 = 1.0e-3;
/// Steps in a row that found nothing better, with more damping each time, before the weight falls.
const MOST_FAILURES: u32 = 4;
/// Damping after the first step that a limit has shortened.
const LEAST_DAMPING: f64 = 0.01;

/// How fast the barrier gives way.
struct Course {
    /// By what mu falls.
    fall: f64,
    /// It falls when a step promises less than this many mu, or has been the first with a new mu.
    small: f64,
}

const STRICT: Course = Course { fall: 0.3, small: 10.0 };
const RELAXED: Course = Course { fall: 0.4, small: 160.0 };

/// Share of a limit from which on the barrier is relaxed, at first.
const FIRST_LEFT: f64 = 0.3;
/// By what this share falls, with mu.
const LEFT_FALL: f64 = 0.3;
/// Its least value while mu falls.
const LEAST_LEFT: f64 = 1.0e-4;
/// At the last mu it falls on if a limit is still broken when a step promises less than this many mu.
const SHARPEN: f64 = 60.0;

/// A new share from which on the barrier is relaxed.
fn sharper<S: Scalar>(edge: Edge<S>) -> Edge<S> {
    if edge.is_relaxed() { Edge::relaxed(edge.left() * S::of(LEFT_FALL)) } else { edge }
}

impl<S: Scalar, const NODES: usize> Solver<S, NODES> {
    /// Improves the states of a stretch. If they keep all limits, they still do; else they may or may not.
    /// Returns how many steps were taken.
    pub fn improve<const N: usize>(
        &mut self,
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        iterations: u16,
        aim: Aim,
    ) -> u16 {
        self.aim = aim;
        let mut span = Self::weights(window, stretch, limits);
        if aim == Aim::Halt {
            // A halt costs as much at first as it takes time.
            self.price = S::ONE;
            let time = Self::time(window, stretch).unwrap_or(S::ONE);
            self.price = time / self.tolls(window, stretch).greatest(S::of(1.0e-9));
            span.1 = span.0 * S::of(HALT_SHARE);
        }
        // Answers to an operator are rare, and start farther from what is asked for.
        let more = if aim == Aim::Time { 0 } else { iterations / 2 };
        // In `f32` a cut may break a limit by its rounding: then no strict step could be taken.
        let strict = self.holds(window, stretch, limits);
        let course = if strict { &STRICT } else { &RELAXED };
        if !strict {
            self.edge = Edge::relaxed(S::of(FIRST_LEFT));
        }
        let steps = self.descend(window, stretch, limits, iterations + more, (span, course));
        self.edge = Edge::STRICT;
        self.aim = Aim::Time;
        steps
    }

    /// Takes the states of a stretch, which may break limits, to those of least time. Returns how
    /// many steps were taken, and whether all limits hold now.
    pub fn find<const N: usize>(
        &mut self,
        window: &mut Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        iterations: u16,
    ) -> (u16, bool) {
        let span = Self::weights(window, stretch, limits);
        self.edge = Edge::relaxed(S::of(FIRST_LEFT));
        let steps = self.descend(window, stretch, limits, iterations, (span, &RELAXED));
        self.edge = Edge::STRICT;
        (steps, self.holds(window, stretch, limits))
    }

    /// First and last mu.
    fn weights<const N: usize>(
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
    ) -> (S, S) {
        let scale = limits.time_scale();
        let cells = S::from_u32((stretch.last - stretch.first) as u32);
        let time = Self::time(window, stretch).unwrap_or(S::ZERO);
        let first = (scale * S::of(FIRST_WEIGHT)).greatest(time / cells * S::of(FIRST_SHARE));
        (first, scale * S::of(LAST_WEIGHT))
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
        ((first_weight, last_weight), course): ((S, S), &Course),
    ) -> u16 {
        let mut now = Weights { weight: first_weight, stiffness: first_weight, damping: S::ZERO };
        let mut failures = 0;
        for steps in 0..iterations {
            let Some(here) = self.assemble(window, stretch, limits, now) else { return steps };
            let promise = solve(self.works(stretch.first, stretch.last));
            if !promise.is_finite() {
                // Rounding has made the system singular: take it from further inside.
                now.damping = (now.damping * S::of(16.0)).greatest(S::ONE);
                continue;
            }
            for work in self.works(stretch.first, stretch.last) {
                work.step = work.gradient;
            }
            let (found, blocked) = self.search(window, stretch, limits, now.weight, here);
            now.damping = next_damping(now.damping, found.is_some(), blocked);
            let mut settled = promise < now.weight * S::of(course.small);
            if let Some(share) = found {
                for i in stretch.first..=stretch.last {
                    window.set_state(i, self.trial(window, stretch, i, share));
                }
                failures = 0;
                let share = if share > S::of(WHOLE_STEP) { S::ONE } else { share };
                settled |= now.stiffness > now.weight && share == S::ONE;
                now.stiffness += (now.weight - now.stiffness) * share;
            } else {
                failures += 1;
                settled |= failures >= MOST_FAILURES;
            }
            if !settled {
                continue;
            }
            now.stiffness = now.weight;
            if now.weight > last_weight {
                now.weight = (now.weight * S::of(course.fall)).greatest(last_weight);
                if self.edge.left() > S::of(LEAST_LEFT) {
                    self.edge = sharper(self.edge);
                }
            } else if !self.edge.is_relaxed()
                || self.holds(window, stretch, limits)
                || failures >= MOST_FAILURES
            {
                return steps + 1;
            } else if promise < now.weight * S::of(SHARPEN) {
                self.edge = sharper(self.edge);
            }
        }
        iterations
    }

    /// The share of the step to take, if any share is no worse than `here`;
    /// and whether a limit stood in the way of the whole step.
    fn search<const N: usize>(
        &self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        weight: S,
        here: S,
    ) -> (Option<S>, bool) {
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
                let kept = blocked && value(shorter).is_some();
                return (Some(if kept { shorter } else { share }), blocked);
            }
            blocked |= there.is_none();
            share = share * S::of(SHORTER);
        }
        (None, blocked)
    }

    /// Longest share of the step that leaves every b at least a tenth of what it was.
    fn longest_share<const N: usize>(&self, window: &Window<S, N, NODES>, stretch: Stretch) -> S {
        let mut share = S::ONE;
        for i in stretch.first..stretch.last {
            if Self::is_free(window, stretch, i)
                && let (Some(station), Some(work)) = (window.get(i), self.work.get(i))
            {
                let (b, step) = (station.state.b * S::of(0.9), work.step[0]);
                if share * step > b {
                    share = b / step;
                }
            }
        }
        share
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
