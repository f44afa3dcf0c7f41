//! A problem that is being solved: what is kept between two parts of a Newton step, so that it may be laid aside after any.

use super::descent::{Descent, FIRST_DELTA, RELAXED, STRICT, Went};
use super::problem::{Aim, Problem, Task};
use super::relaxation::Relaxation;
use super::solver::Solver;
use super::window::Window;
use crate::machine::LimitSets;
use crate::number::Scalar;
use crate::servo::link::Room;

/// A problem on the way to its solution. The states it has reached are in the window.
#[derive(Clone, Copy, Debug)]
pub struct Solving<S> {
    task: Task<S>,
    descent: Descent<S>,
    /// Steps that may still be taken.
    left: u16,
    /// Of the solver, when it was last at it.
    problems: u32,
}

impl<S: Scalar, const N: usize, const NODES: usize> Problem<'_, S, N, NODES> {
    /// To improve the states. If they keep all limits, they still do after every step; else they may or may not.
    pub fn improve(mut self, iterations: u16, aim: Aim) -> Solving<S> {
        self.task.aim = aim;
        let range = self.mu_range(&STRICT);
        // Answers to an operator are rare, and start farther from what is asked for.
        let more = if aim == Aim::Time { 0 } else { iterations / 2 };
        // In `f32` a cut may break a limit by its rounding: then no strict step could be taken.
        let strict = self.holds();
        if !strict {
            self.task.relaxation = Relaxation::new(S::of(FIRST_DELTA));
        }
        let descent = Descent::new(range, if strict { &STRICT } else { &RELAXED });
        Solving { task: self.task, descent, left: iterations + more, problems: 0 }
    }

    /// To take the states, which may break limits, to those of least time. Whether these keep all limits is known
    /// at the end ([`Problem::holds`]).
    pub fn find(mut self, iterations: u16) -> Solving<S> {
        let descent = Descent::new(self.mu_range(&RELAXED), &RELAXED);
        self.task.relaxation = Relaxation::new(S::of(FIRST_DELTA));
        Solving { task: self.task, descent, left: iterations, problems: 0 }
    }
}

impl<S: Scalar> Solving<S> {
    /// The first station of the stretch: those before it keep their states.
    pub fn first(&self) -> usize {
        self.task.stretch.first
    }

    /// A part of a Newton step, if one is left, in a room. Whether there was: what comes of the last is for another slice. If the
    /// solver has been put to another problem since the last call, or the room is another, the step begins again.
    ///
    /// Cost: a pass with gradients over some cells of the stretch, or at most three without over all of it: at most 250,000
    /// instructions on the target, with three axes and 64 nodes.
    pub fn go_on<const N: usize, const NODES: usize>(
        &mut self,
        (solver, room): (&mut Solver, Room<'_, S, N>),
        window: &mut Window<S, N, NODES>,
        limits: LimitSets<'_, S, N>,
        steps: &mut u32,
    ) -> bool {
        if self.left == 0 {
            return false;
        }
        let rows = solver.rows(room);
        if self.problems != solver.problems {
            self.problems = solver.problems;
            if self.descent.begin_again() {
                self.left -= 1;
                *steps += 1;
                if self.left == 0 {
                    return false;
                }
            }
        }
        let mut problem = Problem { rows, window, limits, task: self.task };
        let went = self.descent.go_on(&mut problem);
        self.task = problem.task;
        match went {
            Went::Part => {}
            Went::Step => self.left -= 1,
            Went::Settled | Went::Lost => self.left = 0,
        }
        *steps += u32::from(matches!(went, Went::Step | Went::Settled));
        true
    }
}
