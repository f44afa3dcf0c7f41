//! Least time over a stretch, by Newton's method on time and barrier.
//!
//! There are two methods ([`super::solving`]). [`Problem::find`] starts from a guess that need not keep the limits
//! ([`super::guess`]), under a relaxed barrier ([`super::relaxation`]): no limit stands in the way of a step, so
//! that the number of steps hardly depends on the path. While mu falls, so does the share of a
//! limit from which on the barrier is relaxed; it ends when all limits hold. [`Problem::improve`]
//! starts from states that keep all limits, and every iterate does: a step is shortened until they
//! hold, so it may be stopped after any number of steps. It serves where an answer is owed that is
//! valid whatever happens, and when the other has failed.
//!
//! Either is a [`Descent`], which takes a part of a Newton step at a time and is plain data between two.
//!
//! Work of either: at most `iterations` steps, each one pass with gradients over the cells of the
//! stretch, in parts (two where the first does not like the step before), and at most [`TRIES`] + 2 without, each a part; one and a half times as many for an aim
//! other than the time.
//!
//! The numbers below were chosen by trial; one of them changed hardly changes the time, and not much the number of steps. Over
//! the paths of [`super::guess`] (17,330 servo cycles in 760 steps) the time stays within 5 cycles, with another last mu within 29:
//!
//! | number | from | to | steps |
//! |---|---|---|---|
//! | [`SHORTER`] | 0.5 | 0.8 | 756, 750 |
//! | [`DISTANCE`] | 0.8 | 0.97 | 759, 764 |
//! | [`WHOLE_STEP`] | 0.4 | 0.8 | 764, 756 |
//! | [`LEAST_DAMPING`] | 0.003 | 0.03 | 757, 759 |
//! | [`DELTA_FALL`] | 0.2 | 0.5 | 850, 1105 |
//! | [`SHARPEN`] | 30.0 | 120.0 | 761, 759 |
//! | [`NEARLY`] | 0.01 | 1.0 | 784, 744 |
//! | [`RELAXED`], `fall` | 0.3 | 0.5 | 807, 788 |
//! | [`RELAXED`], `last` | 5e-5 | 2e-4 | 802, 640 |
//! | factor of the second derivative of the time ([`super::model`]) | 0.2 | 0.5 | 778, 749 |
//!
//! The method, and the words, are those of Boyd and Vandenberghe, Convex Optimization (2004), chapters 9 and 11: mu is 1 / t
//! there, the Newton decrement bounds what is left to gain.

use super::problem::{Assembly, Probe, Problem, Weights};
use super::relaxation::Relaxation;
use crate::machine::UNLIMITED;
use crate::number::Scalar;

/// Most shortenings of one step.
const TRIES: usize = 16;
/// By what a step is shortened (beta of a backtracking line search; 0.1 to 0.8 are usual).
const SHORTER: f64 = 0.65;
/// Share of a step that is taken when more than all of it would break a limit.
const DISTANCE: f64 = 0.9;
/// Most of its b that a station may lose in one step: 0 is a limit of its own.
const MOST_LOSS: f64 = 0.9;
/// A step counts as taken from this share on.
const WHOLE_STEP: f64 = 0.6;
/// A step that makes worse by less than so many rounding errors of the value is no worse.
const ROUNDING_ERRORS: f64 = 8.0;
/// mu at the start, in units of the machine's time scale; and at least this share of the mean time of
/// a cell: far from the least time the barrier must keep up with it, or the first steps run into
/// a corner of the limits and stay there.
const FIRST_MU: f64 = 7.5e-4;
const FIRST_SHARE: f64 = 0.05;
/// The same of the last: where cells take long beside the machine's time scale, a smaller mu is lost in the rounding of their time.
const LAST_SHARE: f64 = 1.0e-5;
/// Share of what is minimised that is hardly worth another step: a decrement squared below it, and all limits kept, is the end. (It is
/// twice what the step before was to gain; the next one gains the square of that.)
const NEARLY: f64 = 0.1;
/// Steps in a row that found nothing better, with more damping each time, before mu falls.
const MOST_FAILURES: u32 = 4;
/// Damping after the first step that a limit has shortened.
const LEAST_DAMPING: f64 = 0.01;

/// How fast the barrier gives way.
#[derive(Debug)]
pub(super) struct Schedule {
    /// By what mu falls.
    fall: f64,
    /// It falls when the decrement squared is less than this many mu, or after the first whole step with a new mu.
    small: f64,
    /// mu at the end, in units of the machine's time scale: by then the barrier costs less than half a per cent of the time.
    last: f64,
}

/// Where the limits are kept, the states must stay near the centre of what is left.
pub(super) const STRICT: Schedule = Schedule { fall: 0.3, small: 10.0, last: 5.0e-5 };
/// Where they may be broken, there is no need to.
pub(super) const RELAXED: Schedule = Schedule { fall: 0.4, small: 160.0, last: 1.0e-4 };

/// Share of a limit from which on the barrier is relaxed, at first.
pub(super) const FIRST_DELTA: f64 = 0.3;
/// By what this share falls, with mu.
const DELTA_FALL: f64 = 0.3;
/// Its least value while mu falls.
const LEAST_DELTA: f64 = 1.0e-4;
/// At the last mu it falls on if a limit is still broken when the decrement squared is less than this many mu.
const SHARPEN: f64 = 60.0;

/// What the barrier parameter runs through.
#[derive(Clone, Copy, Debug)]
pub(super) struct MuRange<S> {
    pub first: S,
    pub last: S,
}

/// What came of going on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Went {
    /// There is more to do for the step.
    Part,
    /// A step has been taken, or could not be; there is another to try.
    Step,
    /// The states are those that were looked for, or as near as can be.
    Settled,
    /// The states cannot be evaluated: nothing has been done.
    Lost,
}

/// How far the method has got with a problem.
#[derive(Clone, Copy, Debug)]
pub(super) struct Descent<S> {
    weights: Weights<S>,
    last_mu: S,
    schedule: &'static Schedule,
    /// Steps in a row that found nothing better.
    failures: u32,
    /// Whether the last step was taken whole: the next one is taken to be good, too.
    trusts: bool,
    stage: Stage<S>,
}

/// How far it has got with a step.
#[derive(Clone, Copy, Debug)]
enum Stage<S> {
    Begin,
    /// The Newton system is being made, behind a leap or not.
    Assembling(Assembly<S>, Option<Leap<S>>),
    /// The step is in the workspace: how much of it to take?
    Searching(Trial<S>),
}

/// A search along a step for states that are no worse than those at hand.
#[derive(Clone, Copy, Debug)]
struct Trial<S> {
    /// What the states at hand are worth.
    here: S,
    /// Newton decrement, squared.
    decrement: S,
    /// The share of the step that is tried next.
    share: S,
    /// Whether a limit stood in the way of the whole step.
    blocked: bool,
    tries: usize,
}

/// A step that was taken before it was known to be good: that comes out while the next system is made, at hardly any cost.
#[derive(Clone, Copy, Debug)]
struct Leap<S> {
    trial: Trial<S>,
    /// What to go back to.
    weights: Weights<S>,
    relaxation: Relaxation<S>,
    failures: u32,
}

impl<S: Scalar> Trial<S> {
    /// What states may be worth to be no worse.
    fn most(&self) -> S {
        self.here + self.here.abs() * S::EPSILON * S::of(ROUNDING_ERRORS)
    }

    /// Less of the step, for what has been tried was not good.
    fn shorten(&mut self, blocked: bool) {
        self.blocked |= blocked;
        self.share = self.share * S::of(SHORTER);
        self.tries += 1;
    }
}

impl<S: Scalar> Descent<S> {
    pub(super) fn new(range: MuRange<S>, schedule: &'static Schedule) -> Self {
        let weights = Weights { mu: range.first, mu_curvature: range.first, damping: S::ZERO };
        Self {
            weights,
            last_mu: range.last,
            schedule,
            failures: 0,
            trusts: true,
            stage: Stage::Begin,
        }
    }

    /// Forgets what has been done for a step: the workspace has been used for something else. Whether a step has been taken
    /// that nobody has looked at: it stays.
    pub(super) fn begin_again(&mut self) -> bool {
        let leapt = matches!(self.stage, Stage::Assembling(_, Some(_)));
        self.stage = Stage::Begin;
        leapt
    }

    /// A part of a Newton step: some cells' derivatives, or one trial.
    // Once in the image, however often it is called.
    #[inline(never)]
    pub(super) fn go_on<const N: usize, const NODES: usize>(
        &mut self,
        problem: &mut Problem<'_, S, N, NODES>,
    ) -> Went {
        match self.stage {
            Stage::Begin => {
                let assembly = problem.begin_assembly(problem.task.relaxation);
                self.assemble(problem, assembly, None)
            }
            Stage::Assembling(assembly, leap) => self.assemble(problem, assembly, leap),
            Stage::Searching(trial) => self.try_share(problem, trial),
        }
    }

    /// Makes the Newton system, or a part of it, and solves it if it is complete.
    #[inline]
    fn assemble<const N: usize, const NODES: usize>(
        &mut self,
        problem: &mut Problem<'_, S, N, NODES>,
        mut assembly: Assembly<S>,
        leap: Option<Leap<S>>,
    ) -> Went {
        let complete = problem.assemble(self.weights, &mut assembly);
        if complete == Some(false) {
            self.stage = Stage::Assembling(assembly, leap);
            return Went::Part;
        }
        let mut went = Went::Part;
        if let Some(leap) = leap {
            let there = complete.and_then(|_| assembly.value_before(leap.weights.mu));
            if !there.is_some_and(|there| there <= leap.trial.most()) {
                self.go_back(problem, leap, there.is_none());
                return Went::Part;
            }
            went = Went::Step;
        }
        let Some(here) = complete.and_then(|_| assembly.value(self.weights.mu)) else {
            return Went::Lost;
        };
        // At the end of the stretch nothing is free.
        let decrement = problem.rows.solve(problem.cells());
        if !decrement.is_finite() {
            // Rounding has made the system singular: take it from further inside.
            self.weights.damping = (self.weights.damping * S::of(16.0)).greatest(S::ONE);
            self.stage = Stage::Begin;
            return Went::Step;
        }
        let share = problem.longest_share();
        let trial = Trial { here, decrement, share, blocked: false, tries: 0 };
        let whole = share == S::ONE && problem.task.relaxation.is_relaxed();
        if whole && self.trusts && !self.may_be_last(&trial) {
            self.leap(problem, trial);
        } else {
            self.stage = Stage::Searching(trial);
        }
        went
    }

    /// Whether there may be nothing more to do after a step: mu has fallen as far as it does, and hardly anything is left to gain.
    fn may_be_last(&self, trial: &Trial<S>) -> bool {
        let mu = self.weights.mu;
        let small = (mu * S::of(self.schedule.small)).greatest(trial.here * S::of(NEARLY));
        mu <= self.last_mu && trial.decrement < small
    }

    /// Takes a step, and leaves it to the next system whether it was good: nearly all are, and to try them first takes a third as much
    /// as a system.
    #[inline]
    fn leap<const N: usize, const NODES: usize>(
        &mut self,
        problem: &mut Problem<'_, S, N, NODES>,
        trial: Trial<S>,
    ) {
        let (weights, relaxation) = (self.weights, problem.task.relaxation);
        let leap = Leap { trial, weights, relaxation, failures: self.failures };
        let went = self.take(problem, &trial, true);
        debug_assert!(went == Went::Step, "an end that nobody has looked at");
        self.stage = Stage::Assembling(problem.begin_assembly(relaxation), Some(leap));
    }

    /// Takes a leap back that was not good, and tries less of its step. The next step is tried first.
    #[inline]
    fn go_back<const N: usize, const NODES: usize>(
        &mut self,
        problem: &mut Problem<'_, S, N, NODES>,
        Leap { mut trial, weights, relaxation, failures }: Leap<S>,
        blocked: bool,
    ) {
        problem.take_back();
        (self.weights, self.failures, self.trusts) = (weights, failures, false);
        problem.task.relaxation = relaxation;
        trial.shorten(blocked);
        self.stage = Stage::Searching(trial);
    }

    /// Tries a share of the step, and takes it if it is no worse.
    #[inline]
    fn try_share<const N: usize, const NODES: usize>(
        &mut self,
        problem: &mut Problem<'_, S, N, NODES>,
        mut trial: Trial<S>,
    ) -> Went {
        let mu = self.weights.mu;
        let value = |share: S, most: S| problem.value(Probe { mu, share, most }, problem.cells());
        let most = trial.most();
        let there = value(trial.share, most);
        let found = there.is_some_and(|there| there <= most);
        if found {
            // A limit is near: keep a distance from it, or the next steps only slide along.
            let shorter = trial.share * S::of(DISTANCE);
            if trial.blocked && value(shorter, S::of(UNLIMITED)).is_some() {
                trial.share = shorter;
            }
        } else {
            trial.shorten(there.is_none());
            if trial.tries < TRIES {
                self.stage = Stage::Searching(trial);
                return Went::Part;
            }
        }
        self.stage = Stage::Begin;
        self.take(problem, &trial, found)
    }

    /// Takes the step as far as was `found` good, and sees what comes next.
    #[inline]
    fn take<const N: usize, const NODES: usize>(
        &mut self,
        problem: &mut Problem<'_, S, N, NODES>,
        trial: &Trial<S>,
        found: bool,
    ) -> Went {
        let may_be_last = self.may_be_last(trial);
        let now = &mut self.weights;
        now.damping = next_damping(now.damping, found, trial.blocked);
        let mut settled = trial.decrement < now.mu * S::of(self.schedule.small);
        if found {
            problem.take_step(trial.share);
            self.failures = 0;
            self.trusts = trial.share == S::ONE;
            let share = if trial.share > S::of(WHOLE_STEP) { S::ONE } else { trial.share };
            settled |= (now.mu_curvature > now.mu || may_be_last) && share == S::ONE;
            now.mu_curvature += (now.mu - now.mu_curvature) * share;
        } else {
            self.failures += 1;
            settled |= self.failures >= MOST_FAILURES;
        }
        if settled { self.settle(problem, trial) } else { Went::Step }
    }

    /// Near enough to the least value at this mu: on to the next, or to an end.
    #[inline]
    fn settle<const N: usize, const NODES: usize>(
        &mut self,
        problem: &mut Problem<'_, S, N, NODES>,
        trial: &Trial<S>,
    ) -> Went {
        let may_be_last = self.may_be_last(trial);
        let now = &mut self.weights;
        let fall = S::of(DELTA_FALL);
        now.mu_curvature = now.mu;
        if now.mu > self.last_mu {
            now.mu = (now.mu * S::of(self.schedule.fall)).greatest(self.last_mu);
            if problem.task.relaxation.delta() > S::of(LEAST_DELTA) {
                problem.task.relaxation = problem.task.relaxation.sharpened(fall);
            }
        } else if !problem.task.relaxation.is_relaxed()
            || (may_be_last && problem.holds())
            || self.failures >= MOST_FAILURES
        {
            return Went::Settled;
        } else if trial.decrement < now.mu * S::of(SHARPEN) {
            problem.task.relaxation = problem.task.relaxation.sharpened(fall);
        }
        Went::Step
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Problem<'_, S, N, NODES> {
    /// First and last mu of a schedule.
    // Once in the image.
    #[inline(never)]
    pub(super) fn mu_range(&self, schedule: &Schedule) -> MuRange<S> {
        let scale = self.limits.time_scale();
        let cells = S::from_u32(self.cells().len() as u32);
        let time = self.time().unwrap_or(S::ZERO);
        let mean = time / cells;
        MuRange {
            first: (scale * S::of(FIRST_MU)).greatest(mean * S::of(FIRST_SHARE)),
            last: (scale * S::of(schedule.last)).greatest(mean * S::of(LAST_SHARE)),
        }
    }

    /// Longest share of the step that leaves every b at least a tenth of what it was.
    fn longest_share(&self) -> S {
        let mut share = S::ONE;
        for i in self.cells() {
            if let Some(station) = self.window.get(i)
                && self.frees(i, station)
            {
                let (b, [step, _]) = (station.state.b * S::of(MOST_LOSS), self.rows.step(i));
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
