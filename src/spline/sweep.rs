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
//! distance over the radius, or that to the power 1.5), so the weights tend to the multipliers of the
//! band; *direction and sensitivity*: the exact minimiser of the price plus the weighted squares of
//! the distances, for all control points together - one band matrix of half-width 3, the same for
//! all axes, factored once per sweep, where the thesis tries one point at a time; *move distance*:
//! all of it where the bound of [`super::tube`] allows it, else a part of it, or none, for the control
//! points around the place. So the path is inside the band after any number of sweeps, also none.
//!
//! A run of lines is smoothed again and again, a stretch of it that slides on: what lies in its front has been many times, and
//! its end will be as often. So it need not be drawn into the band by the weights each time. Where it is
//! nearly inside, the moves are shortened: the bound is convex, and what the spline was is inside, so the share of the
//! moves that leads to the edge of the band can be told; it is left to the places that are outside, and rises to the
//! whole over some control points on either side, so that the path does not bend there. The weights of those places grow, and what is
//! shortened now is made good by the sweeps over the next stretch.
//!
//! All of this takes a while on a small processor, so it is done in steps ([`Smoothing`]), each of which costs one band
//! system at most: between two of them the spline is as it was, with what is tried beside it.

use super::banded::{Sum, System};
use super::tube::{CheckPoint, Pole, Span, edges, third};
use crate::number::Scalar;
use crate::number::cube_root;
use crate::number::list::{part, part_mut, some};
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
/// Growth of the weight, by what the target is exceeded by, where sweeps have left the band in places. (Six: a line with noise
/// takes a tenth longer.)
const REPAIR_GROWTH: f64 = 10.0;
/// Most that a weight grows by there. (Half or twice: no path by more than 0.6 %.)
const MOST_REPAIR: f64 = 4.0;
/// Sweeps for that, at most.
const REPAIRS: u8 = 8;
/// Share of the radius that weights aim at; the rest is for what a few sweeps leave over.
const TARGET: f64 = 0.98;
/// A spline that has become longer to run by this factor has curled up: the sweeps are taken back. The
/// measure knows neither feeds nor accelerations; good sweeps raise it by a tenth at times.
const WOUND_UP: f64 = 1.3;
/// Rounds in which moves are shortened where they lead out of the band.
const ROUNDS: u8 = 8;
/// Rounds in which a part of them is left; after that they are dropped.
const PARTS: u8 = 3;
/// Greatest part that is left, in the first rounds.
const MOST_LEFT: f64 = 0.9;
/// What is left of the part that leads to the edge of the band: all that is known of it is a bound.
const SURELY: f64 = 0.98;
/// A stretch of lines is nearly inside where this part of its moves is. (None: paths with noise and stairs take up to a tenth longer;
/// more than half: nothing is gained.)
const NEARLY: f64 = 0.4;
/// Control points over which the part rises to the whole.
const RAMP: f64 = 6.0;
/// Check points whose distances and weights are found side by side.
const ABREAST: usize = 4;

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
            Self::Third => span.stiffness(&span.thirds()),
            Self::Second => span.second_stiffness(&span.second_rows()),
        }
    }

    /// The weight that draws the spline to its reference at first, in proportion to its stiffness.
    pub fn first_weight<S: Scalar>(self, span: &Span<S>) -> S {
        self.stiffness(span) * S::of(FIRST_WEIGHT)
    }
}

/// What is smoothed, and to which end: a type, so that a program contains the code of its own kinds only.
pub trait Kind<S> {
    /// What the tube is around.
    const REFERENCE: Reference;
    /// What is minimised.
    const DERIVATIVE: Derivative;

    /// The factor of a weight in a sweep, by the distance over the target.
    fn change(ratio: S) -> S;

    /// Whether span number `k` may be bent as the edges of its control polygon make it.
    fn admits<const N: usize>(&self, k: usize, span: &Span<S>, edges: &[Vector<S, N>; 3]) -> bool;
}

/// A run of short lines, for a machine whose jerk is limited.
#[derive(Clone, Copy, Debug)]
pub struct OfLines;

impl<S: Scalar> Kind<S> for OfLines {
    const REFERENCE: Reference = Reference::Lines;
    const DERIVATIVE: Derivative = Derivative::Third;

    fn change(ratio: S) -> S {
        // With a power of 1.5 few sweeps end sometimes before the weights, sometimes behind them.
        ratio
    }

    fn admits<const N: usize>(&self, _: usize, span: &Span<S>, edges: &[Vector<S, N>; 3]) -> bool {
        span.goes_on(edges)
    }
}

/// A spline that comes as such, for less curvature.
#[derive(Clone, Copy, Debug)]
pub struct OfSpline<'a, S> {
    /// Greatest [`Span::curl`] that every span may have, 1/mm.
    pub most_curls: &'a [S],
}

impl<S: Scalar> Kind<S> for OfSpline<'_, S> {
    const REFERENCE: Reference = Reference::Itself;
    const DERIVATIVE: Derivative = Derivative::Second;

    fn change(ratio: S) -> S {
        ratio * ratio.sqrt()
    }

    fn admits<const N: usize>(&self, k: usize, span: &Span<S>, edges: &[Vector<S, N>; 3]) -> bool {
        self.most_curls.get(k).is_some_and(|most| span.curl(edges) <= *most)
    }
}

/// A spline in its tube: span number k depends on the control points k to k + 3.
pub struct Tube<'a, S, const N: usize, K> {
    /// The control points.
    pub poles: &'a mut [Pole<S, N>],
    /// The spans: three fewer.
    pub spans: &'a [Span<S>],
    /// The check points, span by span.
    pub checks: &'a mut [CheckPoint<S, N>],
    /// What it is.
    pub kind: K,
}

/// A smoothing under way: what is left of it, between two steps.
#[derive(Clone, Debug)]
pub struct Smoothing<S> {
    stage: Stage,
    /// How long the spline took to run before.
    hard: S,
    end: End,
}

/// How far sweeps go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Until the spline is inside the tube.
    Inside,
    /// Until it nearly is: it will be smoothed again.
    Nearly,
}

impl<S> Smoothing<S> {
    /// Repairs that have been made.
    pub fn repairs(&self) -> u8 {
        match self.stage {
            Stage::Repairs { left, .. } => REPAIRS - left,
            _ => 0,
        }
    }
}

/// What the next step of a smoothing does.
#[derive(Clone, Debug)]
enum Stage {
    /// A sweep, of so many.
    Sweeps(u16),
    /// A sweep where the spline as tried is not inside the tube, of so many; a span that was outside before.
    Repairs { left: u8, outside: u16 },
    /// Moves are shortened where they lead out of the tube.
    Shortening { round: u8 },
}

/// How a sweep changes the weights. (A closure would be a sweep of its own in the image.)
#[derive(Clone, Copy, Debug)]
enum Change {
    /// Towards the target everywhere.
    Smooths,
    /// The spline is drawn back into the tube where it is outside.
    Repairs,
}

impl Change {
    /// The factor of a weight, by the distance over the target.
    #[inline]
    fn factor<S: Scalar, K: Kind<S>>(self, ratio: S) -> S {
        match self {
            Self::Smooths => {
                K::change(ratio.greatest(S::of(LEAST_CHANGE)).least(S::of(MOST_CHANGE)))
            }
            Self::Repairs => {
                let growth = S::ONE + (ratio - S::ONE) * S::of(REPAIR_GROWTH);
                growth.greatest(S::ONE).least(S::of(MOST_REPAIR))
            }
        }
    }
}

impl<S: Scalar, const N: usize, K: Kind<S>> Tube<'_, S, N, K> {
    /// Smooths the spline by `sweeps` sweeps, and as many repairs as the tube asks for, up to
    /// eight; the `free` control points may move.
    pub fn improve<const SIZE: usize>(
        &mut self,
        sweeps: u16,
        free: &Range<usize>,
        system: &mut System<S, N, SIZE>,
    ) {
        let mut smoothing = self.begin(sweeps, free, End::Inside);
        // Every turn is a sweep, a repair or a round.
        while let Some(now) = smoothing {
            smoothing = self.step(now, free, system);
        }
    }

    /// Begins to smooth the spline as [`Tube::improve`] does; `None` if there is nothing to do.
    pub fn begin(&mut self, sweeps: u16, free: &Range<usize>, end: End) -> Option<Smoothing<S>> {
        if free.is_empty() || sweeps == 0 {
            return None;
        }
        for pole in &mut *self.poles {
            pole.trial = pole.shift;
        }
        let hard = self.hardness(|pole| pole.shift);
        Some(Smoothing { stage: Stage::Sweeps(sweeps), hard, end })
    }

    /// Goes on with a smoothing, of the same spline with the same `free` control points; `None` if that was the last step.
    ///
    /// Cost: one band system over the free control points, and every check point twice.
    pub fn step<const SIZE: usize>(
        &mut self,
        Smoothing { stage, hard, end }: Smoothing<S>,
        free: &Range<usize>,
        system: &mut System<S, N, SIZE>,
    ) -> Option<Smoothing<S>> {
        let stage = match stage {
            Stage::Sweeps(left) => {
                self.sweep(system, free, Change::Smooths);
                match left {
                    0 | 1 => Stage::Repairs { left: REPAIRS, outside: 0 },
                    _ => Stage::Sweeps(left - 1),
                }
            }
            Stage::Repairs { left, outside } => match self.lies(outside.into(), end) {
                Lies::Inside => return self.take_on(hard),
                Lies::Outside(outside) if left > 0 => {
                    self.sweep(system, free, Change::Repairs);
                    Stage::Repairs { left: left - 1, outside: outside as u16 }
                }
                Lies::NearlyInside | Lies::Outside(_) => Stage::Shortening { round: 0 },
            },
            Stage::Shortening { round: ROUNDS } => return None,
            Stage::Shortening { round } => {
                let first = round < PARTS;
                let shortened = match K::REFERENCE {
                    Reference::Lines => {
                        self.draw_in::<SIZE>(free, if first { S::of(MOST_LEFT) } else { S::ZERO })
                    }
                    Reference::Itself => {
                        self.shorten(free, if first { S::of(0.5) } else { S::ZERO })
                    }
                };
                if !shortened {
                    return self.take_on(hard);
                }
                Stage::Shortening { round: round + 1 }
            }
        };
        Some(Smoothing { stage, hard, end })
    }

    /// How long the spline as it is takes, times the cube root of the jerk: at every place the speed is
    /// that which its third derivative allows, or which can be reached there.
    fn hardness(&self, moved: impl Fn(&Pole<S, N>) -> Vector<S, N>) -> S {
        let mut sum = S::ZERO;
        for (k, span) in self.spans.iter().enumerate() {
            let third = norm(&third(&span.thirds(), &edges(self.poles, k, &moved)));
            // From rest, constant jerk J leads to v = (9/2 J s^2)^(1/3).
            let reached = S::of(2.0 / 9.0) / (span.reach * span.reach).greatest(S::of(1.0e-12));
            sum += span.step * cube_root(third.greatest(reached));
        }
        sum
    }

    /// Moves what is tried of the `free` control points to the minimiser for new weights.
    fn sweep<const SIZE: usize>(
        &mut self,
        system: &mut System<S, N, SIZE>,
        free: &Range<usize>,
        change: Change,
    ) {
        let spans = free.start.saturating_sub(3)..free.end.min(self.spans.len());
        self.assemble(system, (free, &spans), change);
        system.solve(free);
        for (pole, step) in
            self.poles.iter_mut().zip(system.solution()).take(free.end).skip(free.start)
        {
            for (x, dx) in pole.trial.iter_mut().zip(step) {
                *x += *dx;
            }
        }
    }

    /// What is kept free of the tube between the check points of a span, as tried.
    fn slack(&self, k: usize, span: &Span<S>, edges: &[Vector<S, N>; 3]) -> S {
        match K::REFERENCE {
            Reference::Lines => span.slack(edges),
            Reference::Itself => match some(self.poles, k) {
                Some([a, b, c, d]) => span.slack(&[
                    sub(&b.trial, &a.trial),
                    sub(&c.trial, &b.trial),
                    sub(&d.trial, &c.trial),
                ]),
                None => S::ZERO,
            },
        }
    }

    /// From the reference to the spline at a check point, the four control points being moved as tried, mm.
    #[inline]
    fn miss(check: &CheckPoint<S, N>, poles: &[Pole<S, N>; 4]) -> Vector<S, N> {
        let off = check.displaced(poles.each_ref().map(|pole| &pole.trial));
        match K::REFERENCE {
            Reference::Lines => check.slipped(&off),
            Reference::Itself => off,
        }
    }

    /// The system whose solution is the step from what is tried to the minimiser, for weights by the distances there.
    fn assemble<const SIZE: usize>(
        &mut self,
        system: &mut System<S, N, SIZE>,
        (free, spans): (&Range<usize>, &Range<usize>),
        change: Change,
    ) {
        system.begin(free);
        let mut misses = [[S::ZERO; N]; ABREAST];
        for (k, span) in self.spans.iter().enumerate().take(spans.end).skip(spans.start) {
            let edges = trial_edges(self.poles, k);
            let mut sum = Sum::new();
            let stiffness = match K::DERIVATIVE {
                Derivative::Third => {
                    let row = span.thirds();
                    sum.add(span.weight(), &row, &third(&row, &edges));
                    span.stiffness(&row)
                }
                Derivative::Second => {
                    let rows = span.second_rows();
                    // Only what bends the path is to vanish, not what changes the parameter's speed.
                    for (row, value) in rows.iter().zip(&span.across(&edges)) {
                        sum.add(span.second_weight(), row, value);
                    }
                    span.second_stiffness(&rows)
                }
            };
            let sag = self.slack(k, span, &edges);
            let (least, most) = (stiffness * S::of(LEAST_WEIGHT), stiffness * S::of(MOST_WEIGHT));
            let weight = |check: &CheckPoint<S, N>, miss: &Vector<S, N>| {
                let ratio = (norm(miss) + sag) / (check.radius * S::of(TARGET));
                (check.weight * change.factor::<S, K>(ratio)).greatest(least).least(most)
            };
            let Some(poles) = some(self.poles, k) else { return };
            let checks = part_mut(self.checks, span.range());
            match K::DERIVATIVE {
                Derivative::Third => {
                    for check in checks {
                        let miss = Self::miss(check, poles);
                        check.weight = weight(check, &miss);
                        sum.add(check.weight, &check.basis, &miss);
                    }
                }
                Derivative::Second => {
                    // Apart: a processor that looks ahead takes the roots and divisions of several places at once.
                    for checks in checks.chunks_mut(ABREAST) {
                        for (check, miss) in checks.iter_mut().zip(&mut misses) {
                            *miss = Self::miss(check, poles);
                            check.weight = weight(check, miss);
                        }
                        for (check, miss) in checks.iter().zip(&misses) {
                            sum.add(check.weight, &check.basis, miss);
                        }
                    }
                }
            }
            system.add(k, free, &sum);
        }
    }

    /// Where the spline lies as tried; a span outside is looked for from one on that probably is.
    fn lies(&self, from: usize, end: End) -> Lies {
        let mut lies = Lies::Inside;
        for k in (from..self.spans.len()).chain(0..from) {
            let Some(span) = self.spans.get(k) else { continue };
            if self.holds(k, span) {
                continue;
            }
            if end == End::Inside || self.share_inside(k, span) < S::of(NEARLY) {
                return Lies::Outside(k);
            }
            lies = Lies::NearlyInside;
        }
        lies
    }

    /// Whether a span is inside the tube, as tried, and bent as it may be.
    fn holds(&self, k: usize, span: &Span<S>) -> bool {
        let edges = trial_edges(self.poles, k);
        if !self.kind.admits(k, span, &edges) {
            return false;
        }
        let sag = self.slack(k, span, &edges);
        let inside = |check: &CheckPoint<S, N>, poles: &[Pole<S, N>; 4]| {
            norm(&Self::miss(check, poles)) + sag <= check.radius
        };
        let Some(poles) = some(self.poles, k) else { return true };
        if !part(self.checks, span.range()).iter().all(|check| inside(check, poles)) {
            return false;
        }
        // The end of the span is the first place of the next one.
        let next = self.spans.get(k + 1).and_then(|s| self.checks.get(usize::from(s.first_check)));
        let next = next.zip(some(self.poles, k + 1));
        next.is_none_or(|(check, poles)| inside(check, poles))
    }

    /// Leaves of the moves of the `free` control points a `share`, where they lead out of the tube. Returns whether
    /// any does.
    fn shorten(&mut self, free: &Range<usize>, share: S) -> bool {
        let mut any = false;
        // Whether the spans that depend on a control point are outside, the last of them first.
        let mut outside = [false; 4];
        for i in 0..self.poles.len() {
            let out = self.spans.get(i).is_some_and(|span| !self.holds(i, span));
            outside = [out, outside[0], outside[1], outside[2]];
            any |= out;
            // No span that is looked at later depends on it.
            if outside.contains(&true)
                && free.contains(&i)
                && let Some(pole) = self.poles.get_mut(i)
            {
                pole.trial = from_fn(|n| pole.shift[n] + share * (pole.trial[n] - pole.shift[n]));
            }
        }
        any
    }

    /// Leaves of the moves around the spans outside the tube what leads to its edge, and lets their weights grow. Returns whether
    /// any is.
    #[inline(never)]
    fn draw_in<const SIZE: usize>(&mut self, free: &Range<usize>, most: S) -> bool {
        let mut shares = [S::ONE; SIZE];
        let mut any = false;
        for (k, span) in self.spans.iter().enumerate() {
            if !self.holds(k, span) {
                any = true;
                let share = self.draw(k, span).least(most);
                for least in shares.iter_mut().skip(k).take(4) {
                    *least = least.least(share);
                }
            }
        }
        let apart = |i: usize| self.spans.get(i.saturating_sub(1)).map_or(S::ONE, |span| span.step);
        let mut ramp = Ramp::new();
        for (i, share) in shares.iter_mut().enumerate() {
            ramp.pass(share, apart(i));
        }
        let mut ramp = Ramp::new();
        for (i, share) in shares.iter_mut().enumerate().rev() {
            ramp.pass(share, apart(i));
        }
        for (pole, share) in self.poles.iter_mut().zip(&shares).take(free.end).skip(free.start) {
            pole.trial = from_fn(|n| pole.shift[n] + *share * (pole.trial[n] - pole.shift[n]));
        }
        any
    }

    /// The share of the moves with which a span outside the tube would be inside it.
    fn share_inside(&self, k: usize, span: &Span<S>) -> S {
        let sags = self.sags(k, span);
        let outside = places(k, span).filter_map(|place| self.outlies(place, sags));
        outside.fold(S::ONE, |least, place| least.least(place.share))
    }

    /// Lets the weights grow with which a span is held inside the tube. Returns the share of the moves with which it would be.
    fn draw(&mut self, k: usize, span: &Span<S>) -> S {
        let sags = self.sags(k, span);
        let mut least = S::ONE;
        for place in places(k, span) {
            if let Some(Outside { share, distance }) = self.outlies(place, sags)
                && let Some(check) = self.checks.get_mut(place.0)
            {
                least = least.least(share);
                let ratio = distance / (check.radius * S::of(TARGET));
                check.weight = check.weight * Change::Repairs.factor::<S, K>(ratio);
            }
        }
        least
    }

    /// What is kept free of the tube between the check points of a span, as it is and as tried.
    fn sags(&self, k: usize, span: &Span<S>) -> [S; 2] {
        let edges = edges(self.poles, k, |pole| pole.shift);
        [span.slack(&edges), self.slack(k, span, &trial_edges(self.poles, k))]
    }

    /// By how much a check point is outside the tube as tried, if it is: one of [`places`].
    fn outlies(
        &self,
        (at, first): (usize, usize),
        [sag_before, sag]: [S; 2],
    ) -> Option<Outside<S>> {
        let (check, poles) = (self.checks.get(at)?, some(self.poles, first)?);
        let distance = norm(&Self::miss(check, poles)) + sag;
        if !(distance > check.radius) {
            return None;
        }
        let off = check.displaced(poles.each_ref().map(|pole| &pole.shift));
        let before = norm(&check.slipped(&off)) + sag_before;
        // Distances and the bound of the bend are convex: on the way from one to the other they are at most what a line gives.
        let share = (check.radius - before) / (distance - before) * S::of(SURELY);
        let share = if before < check.radius { share } else { S::ZERO };
        Some(Outside { share, distance })
    }

    /// Takes on what was tried and is inside the tube, unless that takes longer to run than before. The smoothing is over.
    fn take_on(&mut self, hard: S) -> Option<Smoothing<S>> {
        // Where the tube is much wider than the lines in it are long, that happens.
        let wound_up = K::REFERENCE == Reference::Lines
            && self.hardness(|pole| pole.trial) > hard * S::of(WOUND_UP);
        if !wound_up {
            for pole in &mut *self.poles {
                pole.shift = pole.trial;
            }
        }
        None
    }
}

/// What a share rises by on the way from a place where it is less.
struct Ramp<S> {
    share: S,
    /// By how much it rises for each mm.
    slope: S,
}

impl<S: Scalar> Ramp<S> {
    fn new() -> Self {
        Self { share: S::ONE, slope: S::ZERO }
    }

    /// Goes on to the next control point, so many mm away.
    fn pass(&mut self, share: &mut S, apart: S) {
        let here = self.share + self.slope * apart;
        if *share < here {
            // Where control points are close together, as at a rest, a share that rose by their number would bend the path.
            *self = Self { share: *share, slope: S::of(1.0 / RAMP) / apart };
        } else {
            self.share = here;
        }
        *share = self.share;
    }
}

/// Where a spline lies.
enum Lies {
    /// Inside the tube.
    Inside,
    /// Inside but for a part of what was moved that can be left away.
    NearlyInside,
    /// Outside, with this span.
    Outside(usize),
}

/// A check point outside the tube.
struct Outside<S> {
    /// Share of the moves with which it is inside.
    share: S,
    /// Distance with what is kept free, mm.
    distance: S,
}

/// The check points at which a span is held, that of its end is the first of the next one: which, and the first of the control points that
/// move it.
fn places<S: Scalar>(k: usize, span: &Span<S>) -> impl Iterator<Item = (usize, usize)> {
    let Range { start, end } = span.range();
    (start..end).map(move |at| (at, k)).chain([(end, k + 1)])
}

/// The edges of the control polygon of a span, as tried.
fn trial_edges<S: Scalar, const N: usize>(poles: &[Pole<S, N>], span: usize) -> [Vector<S, N>; 3] {
    edges(poles, span, |pole| pole.trial)
}
