//! Smoothing a spline inside its tube, in a fixed number of sweeps.
//!
//! What is minimised for runs ([`Derivative::Third`]): the integral of w |c'''|^2 over the window, c''' being
//! the third derivative by arc length (of the poly-line that the spline follows). On a jerk-limited
//! machine it is what costs time: at a speed v it needs the jerk |c'''| v^3, so a path is run at (J / |c'''|)^(1/3); curvature alone, which the
//! thesis (Naseath 2007, section 3.1) lowers, limits it only where acceleration does. The price w is
//! the cube of the *reach*: of k band / turn^1.5 at a corner of the poly-line, plus the distance to it.
//! Out of a corner the speed grows with the power 2/3 of the distance (constant jerk), from a speed
//! with the same power of that length, and a c''' where the motion is fast costs more than where it is slow anyway. It
//! is what makes the path swing out before a corner and bend most at its apex.
//!
//! One sweep, against the thesis's iteration (chapter 3): *categorisation*: a check point
//! whose distance nears the band gets a greater weight, one that is well inside a lesser one (its
//! distance over the radius, to the power 1.5), so the weights tend to the multipliers of the
//! band; *direction and sensitivity*: the exact minimiser of the price plus the weighted squares of
//! the distances, for all control points together - one band matrix of half-width 3, the same for
//! all axes, factored once per sweep, where the thesis tries one point at a time; *move distance*:
//! all of it where the bound of [`super::tube`] allows it, else half of it, or none, for the control
//! points around the place. So the path is inside the band after any number of sweeps, also none.

use super::banded::System;
use super::tube::{CheckPoint, Pole, Span, edges};
use crate::number::Scalar;
use crate::number::cube_root;
use crate::number::list::{part, part_mut, some, some_mut};
use crate::number::vector::{Vector, norm, sub};
use core::array::from_fn;
use core::ops::Range;

/// Weight of a place at first, as a share of the stiffness of the spline there.
const FIRST_WEIGHT: f64 = 5.0e-3;
/// Least weight of a check point, as a share of the stiffness.
const LEAST_WEIGHT: f64 = 1.0e-5;
/// Greatest weight, as a share of the stiffness.
const MOST_WEIGHT: f64 = 1.0e4;
/// Least distance over the target that counts for the change of a weight in a sweep.
const LEAST_CHANGE: f64 = 0.05;
/// Greatest of it.
const MOST_CHANGE: f64 = 4.0;
/// Growth of the weight, by what the target is exceeded by, where sweeps have left the band in places.
const REPAIR_GROWTH: f64 = 10.0;
/// Most that a weight grows by there.
const MOST_REPAIR: f64 = 4.0;
/// Sweeps for that, at most.
const REPAIRS: u32 = 8;
/// Share of the radius that weights aim at; the rest is for what a few sweeps leave over.
const TARGET: f64 = 0.98;
/// A spline that has become longer to run by this factor has curled up: the sweeps are taken back. The
/// measure knows neither feeds nor accelerations; good sweeps raise it by a tenth at times.
const WOUND_UP: f64 = 1.3;
/// Rounds in which moves are shortened where they lead out of the band.
const ROUNDS: usize = 8;
/// Rounds in which they are halved; after that they are dropped.
const HALVINGS: usize = 3;

/// Price of the third derivative by the reach, mm.
pub fn price<S: Scalar>(reach: S) -> S {
    reach * reach * reach
}

/// What a tube is around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// Lines, straight between the check points: all of the spline's second derivative bends away from
    /// them.
    Lines,
    /// The spline as it was given: only what has been moved counts.
    Itself,
}

/// What is minimised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivative {
    /// The second derivative across the path, at the span's price.
    Second,
    /// The third derivative, at the span's price.
    Third,
}

impl Derivative {
    /// What holds a spline against being moved, by the square of a displacement.
    fn stiffness<S: Scalar>(self, span: &Span<S>) -> S {
        match self {
            Self::Third => span.stiffness(),
            Self::Second => span.second_stiffness(),
        }
    }

    /// The weight that draws the spline to its reference at first, in proportion to its stiffness.
    pub fn first_weight<S: Scalar>(self, span: &Span<S>) -> S {
        self.stiffness(span) * S::of(FIRST_WEIGHT)
    }
}

/// A spline in its tube: span number k depends on the control points k to k + 3.
pub struct Tube<'a, S, const N: usize> {
    /// The control points.
    pub poles: &'a mut [Pole<S, N>],
    /// The spans: three fewer.
    pub spans: &'a [Span<S>],
    /// The check points, span by span.
    pub checks: &'a mut [CheckPoint<S, N>],
    /// What the tube is around.
    pub reference: Reference,
    /// What is minimised.
    pub derivative: Derivative,
}

impl<S: Scalar, const N: usize> Tube<'_, S, N> {
    /// Smooths the spline by `sweeps` sweeps, and as many repairs as the tube asks for, up to
    /// eight; the `free` control points may move.
    pub fn improve<const SIZE: usize>(
        &mut self,
        sweeps: u16,
        free: &Range<usize>,
        system: &mut System<S, N, SIZE>,
    ) {
        if free.is_empty() || sweeps == 0 {
            return;
        }
        let mut before = [[S::ZERO; N]; SIZE];
        for (pole, before) in self.poles.iter_mut().zip(&mut before) {
            pole.trial = pole.shift;
            *before = pole.shift;
        }
        let hard = self.hardness();
        self.measure();
        for _ in 0..sweeps {
            self.weigh(|ratio| {
                let ratio = ratio.greatest(S::of(LEAST_CHANGE)).least(S::of(MOST_CHANGE));
                ratio * ratio.sqrt()
            });
            self.sweep(system, free);
        }
        for _ in 0..REPAIRS {
            if self.spans.iter().enumerate().all(|(k, span)| self.holds(k, span)) {
                break;
            }
            self.weigh(|ratio| {
                let growth = S::ONE + (ratio - S::ONE) * S::of(REPAIR_GROWTH);
                growth.greatest(S::ONE).least(S::of(MOST_REPAIR))
            });
            self.sweep(system, free);
        }
        self.accept(free);
        // Where the tube is much wider than the lines in it are long, that happens.
        if self.reference == Reference::Lines && self.hardness() > hard * S::of(WOUND_UP) {
            for (pole, before) in self.poles.iter_mut().zip(before) {
                pole.shift = before;
            }
        }
    }

    /// How long the spline as it is takes, times the cube root of the jerk: at every place the speed is
    /// that which its third derivative allows, or which can be reached there.
    fn hardness(&self) -> S {
        let mut sum = S::ZERO;
        for (k, span) in self.spans.iter().enumerate() {
            let third = norm(&span.third(&edges(self.poles, k, |pole| pole.shift)));
            // From rest, constant jerk J leads to v = (9/2 J s^2)^(1/3).
            let reached = S::of(2.0 / 9.0) / (span.reach * span.reach).greatest(S::of(1.0e-12));
            sum += span.step * cube_root(third.greatest(reached));
        }
        sum
    }

    /// Moves what is tried to the minimiser for the present weights.
    fn sweep<const SIZE: usize>(&mut self, system: &mut System<S, N, SIZE>, free: &Range<usize>) {
        self.assemble(system, free);
        system.solve(free);
        for (pole, step) in
            self.poles.iter_mut().zip(system.solution()).take(free.end).skip(free.start)
        {
            for (x, dx) in pole.trial.iter_mut().zip(step) {
                *x += *dx;
            }
        }
        self.measure();
    }

    /// The edges of the control polygon of a span, as tried.
    fn trial_edges(&self, span: usize) -> [Vector<S, N>; 3] {
        edges(self.poles, span, |pole| pole.trial)
    }

    /// What is kept free of the tube between the check points of a span, as tried.
    fn slack(&self, k: usize, span: &Span<S>) -> S {
        let edges = match self.reference {
            Reference::Lines => self.trial_edges(k),
            Reference::Itself => match some(self.poles, k) {
                Some([a, b, c, d]) => {
                    [sub(&b.trial, &a.trial), sub(&c.trial, &b.trial), sub(&d.trial, &c.trial)]
                }
                None => [[S::ZERO; N]; 3],
            },
        };
        span.slack(&edges)
    }

    /// Distances at all check points, as tried.
    fn measure(&mut self) {
        for (k, span) in self.spans.iter().enumerate() {
            let Some(poles) = some::<_, 4>(self.poles, k) else { return };
            let shifts = poles.each_ref().map(|pole| pole.trial);
            for check in part_mut(self.checks, span.range()) {
                check.measure(&shifts);
            }
        }
    }

    /// Weights by distances: `change` is the factor for a distance over the target.
    fn weigh(&mut self, change: impl Fn(S) -> S) {
        for (k, span) in self.spans.iter().enumerate() {
            let sag = self.slack(k, span);
            let stiffness = self.derivative.stiffness(span);
            let (least, most) = (stiffness * S::of(LEAST_WEIGHT), stiffness * S::of(MOST_WEIGHT));
            for check in part_mut(self.checks, span.range()) {
                let ratio = (norm(&check.miss) + sag) / (check.radius * S::of(TARGET));
                let weight = check.weight * change(ratio);
                check.weight = weight.greatest(least).least(most);
            }
        }
    }

    /// The system whose solution is the step from what is tried to the minimiser.
    fn assemble<const SIZE: usize>(&self, system: &mut System<S, N, SIZE>, free: &Range<usize>) {
        system.clear(free);
        for (k, span) in
            self.spans.iter().enumerate().take(free.end).skip(free.start.saturating_sub(3))
        {
            let edges = self.trial_edges(k);
            match self.derivative {
                Derivative::Third => {
                    let third = span.third(&edges);
                    system.add(k, free, span.weight(), &span.thirds, &third);
                }
                Derivative::Second => {
                    // Only what bends the path is to vanish, not what changes the parameter's speed.
                    for (row, value) in span.second_rows().iter().zip(span.across(&edges)) {
                        system.add(k, free, span.second_weight(), row, &value);
                    }
                }
            }
            for check in part(self.checks, span.range()) {
                system.add(k, free, check.weight, &check.basis, &check.miss);
            }
        }
    }

    /// Whether a span is inside the tube, as tried and measured, and goes on without a kink.
    fn holds(&self, k: usize, span: &Span<S>) -> bool {
        let edges = self.trial_edges(k);
        let goes_on = match self.reference {
            Reference::Lines => span.goes_on(&edges),
            Reference::Itself => span.curl(&edges) <= span.most_curl,
        };
        if !goes_on {
            return false;
        }
        let sag = self.slack(k, span);
        let own = part(self.checks, span.range());
        // The end of the span is the first place of the next one.
        let next = self.spans.get(k + 1).and_then(|s| self.checks.get(usize::from(s.first_check)));
        own.iter().chain(next).all(|check| norm(&check.miss) + sag <= check.radius)
    }

    /// Takes on what was tried, as far as it is inside the tube.
    fn accept(&mut self, free: &Range<usize>) {
        for round in 0..ROUNDS {
            let share = if round < HALVINGS { S::of(0.5) } else { S::ZERO };
            let mut all = true;
            for (k, span) in self.spans.iter().enumerate() {
                if !self.holds(k, span) {
                    all = false;
                    for pole in some_mut::<_, 4>(self.poles, k).into_iter().flatten() {
                        pole.back = true;
                    }
                }
            }
            for (i, pole) in self.poles.iter_mut().enumerate() {
                if core::mem::take(&mut pole.back) && free.contains(&i) {
                    pole.trial =
                        from_fn(|n| pole.shift[n] + share * (pole.trial[n] - pole.shift[n]));
                }
            }
            if all {
                for pole in &mut *self.poles {
                    pole.shift = pole.trial;
                }
                return;
            }
            self.measure();
        }
    }
}
