//! Who finds the states of a stretch: the problem that is put to it, and where it is worked on.
//!
//! What is to be solved, with all that it takes, is one value: a [`Problem`], made by
//! [`Solver::on`] of a stretch of a window and the limits. It is asked for first states
//! ([`Problem::guess`], [`Problem::seed`]), for the states of least time ([`Problem::find`]), for better ones
//! ([`Problem::improve`]), and whether those at hand keep the limits ([`Problem::holds`]). What is looked for step by
//! step is a [`Solving`](super::solving::Solving) meanwhile: it takes a workspace, the [`Rows`] of the Newton system, for which
//! there is room where the plan will be written.

pub use super::problem::{Aim, Stretch};
use super::problem::{Problem, Task};
use super::relaxation::Relaxation;
use super::tridiagonal::Rows;
use super::window::Window;
use crate::machine::LimitSets;
use crate::number::Scalar;
use crate::servo::link::Room;

/// What has been put to the method, and where: whether a workspace is as it was left can be told by it.
pub struct Solver {
    /// How many problems.
    pub(super) problems: u32,
    /// Number of the room that was worked in last.
    room: u32,
}

impl Solver {
    pub const fn new() -> Self {
        Self { problems: 0, room: 0 }
    }

    /// The states of a stretch as a problem: for least time within all limits, until it is told otherwise.
    pub fn on<'a, S: Scalar, const N: usize, const NODES: usize>(
        &mut self,
        window: &'a mut Window<S, N, NODES>,
        limits: LimitSets<'a, S, N>,
        stretch: Stretch,
    ) -> Problem<'a, S, N, NODES> {
        debug_assert!(stretch.first <= stretch.last && stretch.last < window.len());
        let task =
            Task { stretch, until: stretch.last, aim: Aim::Time, relaxation: Relaxation::STRICT };
        self.problems = self.problems.wrapping_add(1);
        Problem { rows: Rows::NONE, window, limits, task }
    }

    /// How many problems.
    #[cfg(test)]
    pub fn problems(&self) -> u32 {
        self.problems
    }

    /// The workspace in a room. If that is another than before, all that was worked on begins again.
    pub(super) fn rows<'a, S: Scalar, const N: usize>(
        &mut self,
        room: Room<'a, S, N>,
    ) -> Rows<'a, S, N> {
        if self.room != room.number {
            self.room = room.number;
            self.problems = self.problems.wrapping_add(1);
        }
        Rows::new(room.slots)
    }
}
