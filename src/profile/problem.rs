//! What is minimised over a stretch, and its second-order model.
//!
//! The sum of the cell times minus mu times the logarithms of what is left of every limit
//! ([`super::rows`]), over (b, a) of all stations between two fixed ones. The model leaves the
//! second derivatives of the rows out, so it is positive definite: block tridiagonal, each 2 x 2 block
//! coupled to the next ([`super::tridiagonal`]). How it is minimised is in [`super::descent`].

use super::barrier::Slack;
use super::law::{Law, PathState};
use super::model::{Before, CellEnds, Model, Sums, add_damping, add_time_curvature, by_square};
use super::relaxation::Relaxation;
use super::rows::{View, rows, time_gradient};
use super::tridiagonal::{Diagonal, Rows};
use super::window::{Station, Window};
use crate::machine::{LimitSets, UNLIMITED};
use crate::number::Scalar;
use core::ops::Range;

/// Share of acceleration and jerk that the last cell before an open end may use.
const OPEN_END_SHARE: f64 = 0.4;
/// Share of acceleration and jerk that is aimed at while they may be exceeded: they are kept before the last digits of a solution are
/// found.
const RELAXED_SHARE: f64 = 0.9995;
/// How much dearer it is to be above the goal than time is at the goal. Above 1 no time that could be won there pays for
/// it: the penalty is exact.
const EXCESS_PENALTY: f64 = 1.5;

/// What states are wanted for: what is minimised besides the barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// The least time.
    Time,
    /// The least time, with a high penalty on speed above the goal of a cell
    /// ([`Bounds::goal`](super::bounds::Bounds)): the motion slows down to it as fast as the limits
    /// allow.
    Slow,
}

/// A stretch of the window: stations strictly between the two are free.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    pub first: usize,
    pub last: usize,
    /// Whether it ends only because no more is known.
    pub open: bool,
}

impl Stretch {
    /// Cells in it.
    pub const fn cells(&self) -> usize {
        self.last.saturating_sub(self.first)
    }
}

/// What there is to do, without the memory it is done in: a value that may be kept while the problem is laid
/// aside.
#[derive(Clone, Copy, Debug)]
pub struct Task<S> {
    pub stretch: Stretch,
    /// Station behind whose cells nothing changes: the end of the stretch, or one before it.
    pub until: usize,
    pub aim: Aim,
    pub relaxation: Relaxation<S>,
}

/// A task with all that it works on.
pub struct Problem<'a, S: Scalar, const N: usize, const NODES: usize> {
    /// The Newton system, where there is one.
    pub(super) rows: Rows<'a, S, N>,
    pub(super) window: &'a mut Window<S, N, NODES>,
    pub(super) limits: LimitSets<'a, S, N>,
    pub(super) task: Task<S>,
}

/// Where the value is taken: how far along the step, under which barrier.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe<S> {
    /// Barrier parameter, in what is minimised.
    pub mu: S,
    /// Share of the step.
    pub share: S,
    /// A value above this need not be known any better.
    pub most: S,
}

/// Cells whose derivatives are made at once: some 100,000 instructions on the target with three axes, 250,000 with nine.
const CELLS_AT_ONCE: usize = 24;

/// How far the derivatives of a stretch have been made: those of the cells before `next` are in the blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Assembly<S> {
    next: usize,
    time: S,
    slack: Slack<S>,
    before: Before<S>,
}

impl<S: Scalar> Assembly<S> {
    /// What was minimised before, over the cells so far, under the barrier before; `None` if it is no number.
    pub(super) fn value_before(&self, mu: S) -> Option<S> {
        self.with_others(mu, self.before.others)
    }

    /// What is minimised, over the cells so far; `None` if it is no number.
    pub(super) fn value(&self, mu: S) -> Option<S> {
        self.with_others(mu, self.slack.others)
    }

    /// The same with this barrier of the rows that are no logarithm under both.
    fn with_others(&self, mu: S, others: S) -> Option<S> {
        let barrier = self.slack.logs.value() + others;
        let value = self.time + self.slack.penalty + mu * barrier;
        value.is_finite().then_some(value)
    }
}

/// How the model weighs its parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights<S> {
    /// Barrier parameter, in what is minimised.
    pub mu: S,
    /// Barrier parameter in the second derivatives: until a step has been taken with a new mu it is the one before,
    /// for which the states are the centre. (The step is then that of a primal-dual method, which
    /// takes up a new mu at once; one with the new mu throughout would go several times too far.)
    pub mu_curvature: S,
    /// Damping by relative changes of the states, after Levenberg and Marquardt.
    pub damping: S,
}

impl<S: Scalar, const N: usize, const NODES: usize> Problem<'_, S, N, NODES> {
    /// The same with all states from a station of the stretch on as they are.
    #[must_use]
    pub fn until(mut self, station: usize) -> Self {
        // Not `clamp`, which can panic.
        self.task.until = station.min(self.task.stretch.last).max(self.task.stretch.first);
        self
    }

    /// The cells of the stretch.
    pub(super) fn cells(&self) -> Range<usize> {
        self.task.stretch.first..self.task.until
    }

    /// Whether the state of a station is to be found.
    pub(super) fn is_free(&self, i: usize) -> bool {
        self.window.get(i).is_some_and(|station| self.frees(i, station))
    }

    /// The same of station `i` at hand.
    #[inline]
    pub(super) fn frees(&self, i: usize, station: &Station<S, N>) -> bool {
        i > self.task.stretch.first && i < self.task.until && !station.rest
    }

    /// Cell `i`, from a station to the one after it, with its limits. The last one before an end that is only the end of what
    /// is known keeps a reserve, so that the plan can be taken on from there without a break.
    #[inline]
    fn view<'b>(
        &'b self,
        i: usize,
        station: &'b Station<S, N>,
        after: &'b Station<S, N>,
    ) -> View<'b, S, N> {
        let mut view = station.view(after, self.limits);
        let stretch = self.task.stretch;
        if i + 1 == stretch.last && stretch.open && !after.rest {
            view.share = S::of(OPEN_END_SHARE);
        }
        if view.share < S::ONE {
            view.bounds = view.bounds.share(view.share);
        }
        if self.task.relaxation.is_relaxed() {
            let share = S::of(RELAXED_SHARE);
            view.share = view.share * share;
            view.bounds = view.bounds.share(share);
        }
        if self.task.aim == Aim::Slow {
            view.penalty = S::of(EXCESS_PENALTY) * station.cell.length / station.bounds.goal;
        }
        view
    }

    /// The state of station `i` moved by `share` of its step.
    #[inline]
    fn moved(&self, i: usize, station: &Station<S, N>, share: S) -> PathState<S> {
        if i == self.task.stretch.last {
            return PathState::REST;
        }
        if !self.frees(i, station) {
            return station.state;
        }
        let step = self.rows.step(i);
        PathState { b: station.state.b - share * step[0], a: station.state.a - share * step[1] }
    }

    /// Moves the states by a share of their steps, of which the states before are kept instead.
    pub(super) fn take_step(&mut self, share: S) {
        for i in self.task.stretch.first..=self.task.until {
            if let Some(station) = self.window.get(i) {
                let (before, after) = (station.state, self.moved(i, station, share));
                self.window.set_state(i, after);
                self.rows.set_step(i, [before.b, before.a]);
            }
        }
    }

    /// Moves the states back to what they were before whole steps, and these are steps again.
    pub(super) fn take_back(&mut self) {
        for i in self.task.stretch.first..=self.task.until {
            if let Some(station) = self.window.get(i) {
                let (after, [b, a]) = (station.state, self.rows.step(i));
                self.rows.set_step(i, [b - after.b, a - after.a]);
                self.window.set_state(i, PathState { b, a });
            }
        }
    }

    /// What is minimised, over some cells of the stretch; `None` if a limit is broken that must not be.
    pub(super) fn value(&self, probe: Probe<S>, cells: Range<usize>) -> Option<S> {
        let Probe { mu, share, most } = probe;
        let mut time = S::ZERO;
        let mut slack = Slack::new(self.task.relaxation);
        let mut here = self.moved(cells.start, self.window.get(cells.start)?, share);
        for i in cells {
            let (station, after) = self.window.pair(i)?;
            let next = self.moved(i + 1, after, share);
            if station.cell.length > S::ZERO {
                if !(here.b >= S::ZERO && next.b >= S::ZERO) {
                    return None;
                }
                let law = Law::new(station.cell.length, here, next)?;
                time += law.time;
                // Without a barrier nothing is led.
                rows(&View { led: mu > S::ZERO, ..self.view(i, station, after) }, &law, &mut slack);
                if slack.is_broken() {
                    return None;
                }
            }
            // What the cells to come add is not negative.
            let least = time + slack.penalty + mu * slack.least_barrier();
            if least > most {
                return Some(least);
            }
            here = next;
        }
        let value = time + slack.penalty + mu * slack.barrier();
        value.is_finite().then_some(value)
    }

    /// Whether the states of the stretch keep all limits, with a rest at its end, however the barrier
    /// is relaxed; and the rows that lead the method.
    pub fn holds(&mut self) -> bool {
        self.holds_over(self.cells())
    }

    /// The same over some cells of the stretch.
    // Once in the image, however often it is called.
    #[inline(never)]
    pub(super) fn holds_over(&mut self, cells: Range<usize>) -> bool {
        self.is_whole_over(cells, S::ONE)
    }

    /// Whether the states of the stretch keep all limits. A part that was cut from a cell does, as the whole did, but perhaps not the rows that lead the method.
    pub fn keeps_limits(&mut self) -> bool {
        self.is_whole_over(self.cells(), S::ZERO)
    }

    /// Whether the value over some cells is a number, with rows that lead the method if there is a barrier.
    fn is_whole_over(&mut self, cells: Range<usize>, mu: S) -> bool {
        let (task, rows) = (self.task, self.rows);
        self.task.relaxation = Relaxation::STRICT;
        // Without a step.
        self.rows = Rows::NONE;
        let everywhere = Probe { mu, share: S::ZERO, most: S::of(UNLIMITED) };
        let holds = self.value(everywhere, cells).is_some();
        (self.task, self.rows) = (task, rows);
        holds
    }

    /// Time over the stretch, s; `None` if there is no motion over a cell.
    pub(super) fn time(&self) -> Option<S> {
        let mut time = S::ZERO;
        for i in self.cells() {
            let (station, after) = self.window.pair(i)?;
            if station.cell.length > S::ZERO {
                let to =
                    if i + 1 == self.task.stretch.last { PathState::REST } else { after.state };
                time += Law::new(station.cell.length, station.state, to)?.time;
            }
        }
        Some(time)
    }

    /// An assembly of which nothing has been done, and which also finds what the states are worth under the barrier `before`,
    /// that was relaxed no less.
    pub(super) fn begin_assembly(&self, before: Relaxation<S>) -> Assembly<S> {
        let slack = Slack::new(self.task.relaxation);
        Assembly {
            next: self.cells().start,
            time: S::ZERO,
            slack,
            before: Before { relaxation: before, others: S::ZERO },
        }
    }

    /// Gradient and second derivatives of the next cells into the blocks, of at most [`CELLS_AT_ONCE`]. Whether those of all
    /// are there; `None` if a limit is broken that must not be.
    pub(super) fn assemble(
        &mut self,
        weights: Weights<S>,
        assembly: &mut Assembly<S>,
    ) -> Option<bool> {
        let Weights { mu, mu_curvature, damping } = weights;
        let Range { start: first, end } = self.cells();
        let Assembly { next: start, time, slack, before } = assembly;
        let part = *start..end.min(*start + CELLS_AT_ONCE);
        let mut model =
            Model { mu, mu_curvature, sums: Sums::ZERO, slack: *slack, before: *before };
        // What the cell before has left in the rows of the station, and what the station before takes of them.
        let [mut here, mut taken] = [Diagonal::EMPTY; 2];
        if part.start > first {
            here = self.rows.diagonal(part.start)?;
            taken = self.rows.taken(part.start - 1)?;
        }
        for i in part.clone() {
            let (station, after) = self.window.pair(i)?;
            let free = [self.frees(i, station), self.frees(i + 1, after)];
            let (length, from) = (station.cell.length, station.state);
            let to = if i + 1 == self.task.stretch.last { PathState::REST } else { after.state };
            let mut next = Diagonal::EMPTY;
            let mut coupling = [S::ZERO; 4];
            if length > S::ZERO {
                let ends = CellEnds { length, from, to, free };
                let law = Law::new(length, from, to)?;
                model.sums = Sums::ZERO;
                *time += law.time;
                model.sums.gradient = time_gradient(&law);
                rows(&self.view(i, station, after), &law, &mut model);
                if model.slack.is_broken() {
                    return None;
                }
                let Sums { gradient: g, hessian: mut h } = by_square(&model.sums, &law, free);
                if damping > S::ZERO {
                    add_damping(&mut h, damping * law.time, &ends);
                }
                add_time_curvature(&mut h, &ends);
                let ([bb, ba, aa], [b, a]) = (here.block, here.gradient);
                here = Diagonal {
                    block: [bb + h[0], ba + h[1], aa + h[4]],
                    gradient: [b + g[0], a + g[1]],
                };
                coupling = [h[2], h[3], h[5], h[6]];
                next = Diagonal { block: [h[7], h[8], h[9]], gradient: [g[2], g[3]] };
            }
            taken = self.eliminate(i, free[0], here, coupling, taken);
            here = next;
        }
        (*start, *slack, *before) = (part.end, model.slack, model.before);
        let complete = part.end == end;
        // Of the last station, which is not free, nothing is needed.
        if !complete {
            self.rows.keep(part.end, here);
        }
        Some(complete)
    }

    /// Puts the rows of a station into the system, of which the station before has `taken` its part.
    #[inline]
    fn eliminate(
        &self,
        i: usize,
        free: bool,
        diagonal: Diagonal<S>,
        coupling: [S; 4],
        taken: Diagonal<S>,
    ) -> Diagonal<S> {
        let diagonal = if free { diagonal } else { Diagonal::FIXED };
        self.rows.eliminate(i, diagonal, coupling, taken)
    }
}
