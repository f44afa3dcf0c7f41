//! A problem that is being solved: what is kept between two Newton steps, so that it may be laid aside after any.

use super::descent::{Descent, End, FIRST_DELTA, RELAXED, STRICT};
use super::problem::{Objective, Problem, Task};
use super::relaxation::Relaxation;
use super::solver::{Aim, Solver};
use super::window::Window;
use crate::machine::Limits;
use crate::number::Scalar;
use core::ops::ControlFlow;

/// mu at the end of a halt, as a share of the first: by then the creep that the barrier leaves is
/// a few per cent of the speed at its start.
const HALT_SHARE: f64 = 1.0e-3;

/// A problem on the way to its solution. The states it has reached are in the window.
#[derive(Clone, Copy, Debug)]
pub struct Solving<S> {
    task: Task<S>,
    descent: Descent<S>,
    /// Steps that may still be taken.
    left: u16,
}

impl<S: Scalar, const N: usize, const NODES: usize> Problem<'_, S, N, NODES> {
    /// To improve the states. If they keep all limits, they still do after every step; else they may or may not.
    pub fn improve(mut self, iterations: u16, aim: Aim) -> Solving<S> {
        let mut range = self.mu_range(&STRICT);
        match aim {
            Aim::Time => {}
            Aim::Slow => self.task.objective = Objective::PenalisedTime,
            Aim::Halt => {
                // A halt costs as much at first as it takes time.
                let time = self.time().unwrap_or(S::ONE);
                self.task.objective = Objective::SpeedSquared { weight: S::ONE };
                let weight = time / self.speed_squared().greatest(S::of(1.0e-9));
                self.task.objective = Objective::SpeedSquared { weight };
                range.last = range.first * S::of(HALT_SHARE);
            }
        }
        // Answers to an operator are rare, and start farther from what is asked for.
        let more = if aim == Aim::Time { 0 } else { iterations / 2 };
        // In `f32` a cut may break a limit by its rounding: then no strict step could be taken.
        let strict = self.holds();
        if !strict {
            self.task.relaxation = Relaxation::new(S::of(FIRST_DELTA));
        }
        let descent = Descent::new(range, if strict { &STRICT } else { &RELAXED });
        Solving { task: self.task, descent, left: iterations + more }
    }

    /// To take the states, which may break limits, to those of least time. Whether these keep all limits is known
    /// at the end ([`Problem::holds`]).
    pub fn find(mut self, iterations: u16) -> Solving<S> {
        let descent = Descent::new(self.mu_range(&RELAXED), &RELAXED);
        self.task.relaxation = Relaxation::new(S::of(FIRST_DELTA));
        Solving { task: self.task, descent, left: iterations }
    }
}

impl<S: Scalar> Solving<S> {
    /// One Newton step, if one is left. Whether there is another to take.
    ///
    /// Cost: one pass with gradients over the cells of the stretch, and the trials of [`super::descent`].
    pub fn step<const N: usize, const NODES: usize>(
        &mut self,
        solver: &mut Solver<S, NODES>,
        window: &mut Window<S, N, NODES>,
        limits: &Limits<S, N>,
        steps: &mut u32,
    ) -> bool {
        if self.left == 0 {
            return false;
        }
        let mut problem = solver.take_up(window, limits, self.task);
        let came = self.descent.step(&mut problem);
        self.task = problem.task;
        self.left -= 1;
        *steps += u32::from(came != ControlFlow::Break(End::Lost));
        if came.is_break() {
            self.left = 0;
        }
        self.left > 0
    }
}
