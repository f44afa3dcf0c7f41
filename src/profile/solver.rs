//! Who finds the states of a stretch: a workspace, and the problem it is put to.
//!
//! [`Solver`] is memory, nothing else. What is to be solved, with all that it takes, is one value: a [`Problem`], made by
//! [`Solver::on`] of a stretch of a window and the limits. It is asked for first states
//! ([`Problem::guess`], [`Problem::seed`]), for the states of least time ([`Problem::find`]), for better ones
//! ([`Problem::improve`]), and whether those at hand keep the limits ([`Problem::holds`]). What is looked for step by
//! step is a [`Solving`](super::solving::Solving) meanwhile.

pub use super::problem::Stretch;
use super::problem::{Objective, Problem, Task};
use super::relaxation::Relaxation;
use super::tridiagonal::BlockRow;
use super::window::Window;
use crate::machine::LimitSets;
use crate::number::Scalar;

/// What states are wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// The least time.
    Time,
    /// The least time, with a high penalty on speed above the goal of a cell
    /// ([`Bounds::goal`](super::bounds::Bounds)): the motion slows down to it as fast as the limits
    /// allow.
    Slow,
    /// The least speed everywhere: the motion brakes as hard as the limits allow, and creeps on.
    Halt,
}

/// Workspace of the method: the Newton system of a whole window.
pub struct Solver<S, const NODES: usize> {
    rows: [BlockRow<S>; NODES],
    /// How many problems it has been put to.
    pub(super) problems: u32,
}

impl<S: Scalar, const NODES: usize> Solver<S, NODES> {
    pub const fn new() -> Self {
        Self { rows: [BlockRow::EMPTY; NODES], problems: 0 }
    }

    /// The states of a stretch as a problem: for least time within all limits, until it is told otherwise.
    pub fn on<'a, const N: usize>(
        &'a mut self,
        window: &'a mut Window<S, N, NODES>,
        limits: LimitSets<'a, S, N>,
        stretch: Stretch,
    ) -> Problem<'a, S, N, NODES> {
        debug_assert!(stretch.first <= stretch.last && stretch.last < window.len());
        let task = Task {
            stretch,
            until: stretch.last,
            objective: Objective::Time,
            relaxation: Relaxation::STRICT,
        };
        self.problems = self.problems.wrapping_add(1);
        self.take_up(window, limits, task)
    }

    /// A task that has been laid aside.
    pub(super) fn take_up<'a, const N: usize>(
        &'a mut self,
        window: &'a mut Window<S, N, NODES>,
        limits: LimitSets<'a, S, N>,
        task: Task<S>,
    ) -> Problem<'a, S, N, NODES> {
        Problem { rows: &mut self.rows, window, limits, task }
    }
}
