//! What is minimised over a window, and its second-order model.
//!
//! The sum of the cell times minus mu times the logarithms of what is left of every limit
//! ([`super::rows`]), over (b, a) of all stations between two fixed ones. The model leaves the
//! second derivatives of the rows out, so it is positive definite: a chain of 2 x 2 blocks, each
//! coupled to the next ([`super::chain`]). How it is minimised is in [`super::descent`].

use super::barrier::{Edge, Model, Slack, add_damping, add_time_curvature, by_square};
use super::chain::Work;
use super::law::{Law, State};
use super::rows::{View, rows, time_gradient};
use super::window::Window;
use crate::machine::Limits;
use crate::number::Scalar;
use crate::number::list::{part_mut, some_mut};

/// Share of acceleration and jerk that the last cell before an open end may use.
const OPEN_END_SHARE: f64 = 0.4;
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
    pub(super) work: [Work<S>; NODES],
    pub(super) aim: Aim,
    /// Price of b x length in a halt.
    pub(super) price: S,
    pub(super) edge: Edge<S>,
}

/// Weights of the barrier.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights<S> {
    /// mu, in what is minimised.
    pub weight: S,
    /// mu in the second derivatives: until a step has been taken with a new mu it is the one before,
    /// for which the states are the centre. (The step is then that of a primal-dual method, which
    /// takes up a new mu at once; one with the new mu throughout would go several times too far.)
    pub stiffness: S,
    pub damping: S,
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
        Self { work: [Work::EMPTY; NODES], aim: Aim::Time, price: S::ZERO, edge: Edge::STRICT }
    }

    /// The workspace of some stations.
    pub(super) fn works(&mut self, first: usize, last: usize) -> &mut [Work<S>] {
        part_mut(&mut self.work, first..last + 1)
    }

    /// The workspace of a station and the next.
    pub(super) fn two(&mut self, i: usize) -> Option<&mut [Work<S>; 2]> {
        some_mut(&mut self.work, i)
    }

    /// Whether a station's state is to be found.
    pub(super) fn is_free<const N: usize>(
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        i: usize,
    ) -> bool {
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
    pub(super) fn trial<const N: usize>(
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
        let step = self.work.get(i).map_or([S::ZERO; 2], |work| work.step);
        State { b: station.state.b - share * step[0], a: station.state.a - share * step[1] }
    }

    /// What b at a free station costs in a halt, s per unit; else nothing.
    pub(super) fn toll<const N: usize>(
        &self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        i: usize,
    ) -> S {
        if self.aim != Aim::Halt || !Self::is_free(window, stretch, i) {
            return S::ZERO;
        }
        let Some((before, here)) = i.checked_sub(1).and_then(|i| window.pair(i)) else {
            return S::ZERO;
        };
        self.price * ((before.cell.length + here.cell.length) * S::of(0.5))
    }

    /// Time and barrier over cells `from..to`, `None` if a limit is broken.
    pub(super) fn value<const N: usize>(
        &self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        (weight, share): (S, S),
        (from, to): (usize, usize),
    ) -> Option<S> {
        let mut time = S::ZERO;
        let mut slack = Slack::new(self.edge);
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
                if slack.is_broken() {
                    return None;
                }
            }
            time += self.toll(window, stretch, i + 1) * next.b;
            here = next;
        }
        let value = time + slack.price + weight * slack.barrier();
        value.is_finite().then_some(value)
    }

    /// Whether the states of a stretch keep all limits, with a rest at its end, however the barrier
    /// is relaxed.
    pub fn holds<const N: usize>(
        &mut self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
    ) -> bool {
        for work in self.works(stretch.first, stretch.last) {
            work.step = [S::ZERO; 2];
        }
        let edge = core::mem::replace(&mut self.edge, Edge::STRICT);
        let all = (stretch.first, stretch.last);
        let holds = self.value(window, stretch, limits, (S::ZERO, S::ZERO), all).is_some();
        self.edge = edge;
        holds
    }

    /// Time over a stretch, s.
    pub(super) fn time<const N: usize>(
        window: &Window<S, N, NODES>,
        stretch: Stretch,
    ) -> Option<S> {
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

    /// Gradient and second derivatives of every cell into the blocks; returns time and barrier, `None`
    /// if a limit is broken that must not be.
    pub(super) fn assemble<const N: usize>(
        &mut self,
        window: &Window<S, N, NODES>,
        stretch: Stretch,
        limits: &Limits<S, N>,
        Weights { weight, stiffness, damping }: Weights<S>,
    ) -> Option<S> {
        self.works(stretch.first, stretch.last).fill(Work::EMPTY);
        let timed = self.aim != Aim::Halt;
        let mut slack = Slack::new(self.edge);
        let mut time = S::ZERO;
        for i in stretch.first..stretch.last {
            let free = (Self::is_free(window, stretch, i), Self::is_free(window, stretch, i + 1));
            let (station, after) = window.pair(i)?;
            let toll = self.toll(window, stretch, i + 1);
            let [_, ahead] = self.two(i)?;
            ahead.gradient[0] += toll;
            time += toll * after.state.b;
            let length = station.cell.length;
            if !(length > S::ZERO) {
                continue;
            }
            let to = if i + 1 == stretch.last { State::REST } else { after.state };
            let ends = (station.state, to);
            let law = Law::new(length, station.state, to)?;
            let mut gradient = [S::ZERO; 4];
            if timed {
                time += law.time;
                gradient = time_gradient(&law);
            }
            let mut model = Model { weight, stiffness, gradient, hessian: [S::ZERO; 10], slack };
            rows(&self.view(window, stretch, i, limits)?, &law, &mut model);
            let (g, mut h) = by_square(&model, &law, free);
            slack = model.slack;
            if slack.is_broken() {
                return None;
            }
            add_damping(&mut h, damping * law.time, length, ends, free);
            if timed {
                add_time_curvature(&mut h, length, ends, free);
            }
            let [here, ahead] = self.two(i)?;
            for (sum, part) in here.block.iter_mut().zip([h[0], h[1], h[4]]) {
                *sum += part;
            }
            here.gradient[0] += g[0];
            here.gradient[1] += g[1];
            here.coupling = [h[2], h[3], h[5], h[6]];
            for (sum, part) in ahead.block.iter_mut().zip([h[7], h[8], h[9]]) {
                *sum += part;
            }
            ahead.gradient[0] += g[2];
            ahead.gradient[1] += g[3];
        }
        for (i, work) in (stretch.first..).zip(self.works(stretch.first, stretch.last)) {
            if !Self::is_free(window, stretch, i) {
                work.block = [S::ONE, S::ZERO, S::ONE];
                work.gradient = [S::ZERO; 2];
            }
        }
        let value = time + slack.price + weight * slack.barrier();
        value.is_finite().then_some(value)
    }
}
