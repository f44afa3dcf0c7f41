//! Smoothing in a bounded amount of work, inside the tube by a bound.
//!
//! Three candidates are made, and the one with the least time (estimated, see below) is taken, be it
//! the spline as given:
//! - *sweeps*: the same that smooth runs of short lines on their way to the machine (`sweep` in this
//!   room), on the second derivative across the path. One band system for all control points at once; the
//!   weight of a place grows with the speed that the motion can have there, so curvature is not moved to where it
//!   costs more;
//! - *moves*: the thesis's own iterations ([`super::thesis`]), at most [`MOVES`] of them, drawn back into the
//!   tube as a whole where its samples missed that they leave it. They are better at peaks so sharp that the speed by the
//!   parameter, which the sweeps hold, is what has to change;
//! - sweeps after moves.
//!
//! Against the thesis:
//! - the tube is never left: between the check points the difference spline is bounded by
//!   its second derivative;
//! - the known weaknesses of the thesis (section 5.1: a "U" that becomes a "V", curvature that rises in
//!   places) are looked for: sweeps that make a span's curvature exceed what the spline as given had in
//!   its neighbourhood by more than a little are taken back there; moves that make it exceed that
//!   threefold are no candidate, and what they cost in time below that counts against them;
//! - sweeps leave the ends where they are; moves take them across the path, as the thesis has it,
//!   unless `ends_stay`.
//!
//! The *time* is that of the thesis's trajectory generator ([`Trajectory`]) over eight places per span, forty
//! where it turns much.

use crate::bspline::{Spline, append};
use crate::error::SplineError;
use crate::trajectory::{Low, Lows, Trajectory};
use core::array::from_fn;
use heapless::Vec;
use splineway::machine::Quantity;
use splineway::number::list::part_mut;
use splineway::number::vector::{Vector, dot, mix, norm, sub, zero};
use splineway::number::{RangeError, Scalar};
use splineway::spline::banded::System;
use splineway::spline::bezier;
use splineway::spline::sweep::{Kind, OfSpline, Tube};
use splineway::spline::tube::{CheckPoint, Pole, Span, edges};

/// Check points in a span.
pub const SPAN_CHECKS: usize = 4;
/// Most iterations of the moves.
pub const MOVES: u32 = 40;
/// Share of the radius that is used; the rest is for rounding.
const SHARE: f64 = 0.9998;
/// By what curvature may exceed the greatest of the neighbourhood as given; and the share of the
/// greatest of all that it may reach anywhere.
const CURL_SHARE: f64 = 1.02;
const CURL_FLOOR: f64 = 0.02;
/// The first, for moves.
const MOVED_CURL_SHARE: f64 = 3.0;
/// Spans on either side that are its neighbourhood.
const BESIDE: usize = 4;
/// Parts of a span in the estimate of the time.
const PARTS: u32 = 8;
/// The same where curvature times length, rad, is greater than this.
const SHARP_PARTS: u32 = 40;
const SHARP_TURN: f64 = 0.5;
/// Places per span at which the result of the moves is bounded.
const PRECISION: u32 = 20;
/// Control points of a closed spline that are held while the others move.
const HELD: usize = 3;

/// How to smooth.
#[derive(Clone, Copy, Debug)]
pub struct Options<S> {
    /// Radius of the tube, mm.
    pub radius: S,
    /// Sweeps in a pass.
    pub sweeps: u16,
    /// Passes; 0 leaves the spline as it is. A closed spline is cut open at another place for each.
    pub passes: u16,
    /// Whether the end points must stay.
    pub ends_stay: bool,
    /// The machine by which the time is estimated.
    pub trajectory: Trajectory<S>,
}

impl<S: Scalar> Options<S> {
    /// Sixteen sweeps in two passes within a radius, mm; the thesis's machine (section 4.5).
    pub fn new(radius: S) -> Self {
        let trajectory = Trajectory::thesis();
        Self { radius, sweeps: 16, passes: 2, ends_stay: true, trajectory }
    }
}

/// Work space for splines of at most `SIZE` - 3 control points and `CHECKS` = 4 `SIZE` check
/// points.
pub struct Smoother<S, const N: usize, const SIZE: usize, const CHECKS: usize> {
    poles: Vec<Pole<S, N>, SIZE>,
    spans: Vec<Span<S>, SIZE>,
    checks: Vec<CheckPoint<S, N>, CHECKS>,
    system: System<S, N, SIZE>,
    lows: Vec<Low<S>, CHECKS>,
    /// [`Span::curl`] of every span as given.
    curls: Vec<S, SIZE>,
    /// What each of these may become.
    most_curls: Vec<S, SIZE>,
    /// The control point from which on spans and check points are those of the spline as given.
    loaded: Option<usize>,
}

impl<S: Scalar, const N: usize, const SIZE: usize, const CHECKS: usize> Default
    for Smoother<S, N, SIZE, CHECKS>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const N: usize, const SIZE: usize, const CHECKS: usize>
    Smoother<S, N, SIZE, CHECKS>
{
    /// An empty work space.
    pub const fn new() -> Self {
        const { assert!(CHECKS >= SPAN_CHECKS * SIZE, "four places per control point") };
        Self {
            poles: Vec::new(),
            spans: Vec::new(),
            checks: Vec::new(),
            system: System::new(),
            lows: Vec::new(),
            curls: Vec::new(),
            most_curls: Vec::new(),
            loaded: None,
        }
    }

    /// Smooths a spline inside the tube around it.
    ///
    /// Work: at most (`sweeps` + 8) (`passes` + 1) band systems over the control points, each with six
    /// rows per span (of a closed spline twice `passes`); about 500 operations per control point, axis and sweep. Moves: see
    /// [`super::thesis::smooth`].
    ///
    /// # Errors
    /// If the radius is negative or not finite, or the spline has more control points than there is room for.
    pub fn smooth<const CAP: usize>(
        &mut self,
        spline: &mut Spline<S, N, CAP>,
        options: &Options<S>,
    ) -> Result<(), SplineError> {
        let radius = options.radius.to_f64();
        if let Err(error) = Quantity::Tolerance.range().check(radius) {
            let RangeError { value, least, greatest } = error;
            return Err(SplineError::OutOfRange {
                what: "tolerance radius",
                value,
                least,
                greatest,
            });
        }
        let m = spline.controls().len();
        if m + HELD > SIZE {
            return Err(SplineError::TooMany { controls: m, room: SIZE - HELD });
        }
        if radius == 0.0 || options.passes == 0 {
            return Ok(());
        }
        let given = spline.clone();
        self.begin(&given, options);
        let mut least = self.time(spline, &given, options, CURL_SHARE);
        let mut consider = |smoother: &mut Self, candidate: &Spline<S, N, CAP>, share: f64| {
            let time = smoother.time(candidate, &given, options, share);
            if least.zip(time).is_some_and(|(least, time)| time < least) {
                least = time;
                spline.move_to(candidate.controls());
            }
        };
        let mut swept = given.clone();
        self.sweep(&mut swept, &given, options, options.passes);
        consider(self, &swept, CURL_SHARE);
        let mut moved = given.clone();
        let mut thesis = super::thesis::Options::new(options.radius);
        thesis.most_iterations = MOVES;
        super::thesis::smooth(&mut moved, &thesis)?;
        if options.ends_stay
            && !given.is_closed()
            && let ([first, .., last], [start, .., end]) = (moved.controls_mut(), given.controls())
        {
            (*first, *last) = (*start, *end);
        }
        // What the samples missed, or the ends no longer hold against, may lie outside the tube.
        let off = moved.difference(&given).map_or(S::ZERO, |off| off.bound(PRECISION));
        let share = options.radius * S::of(SHARE) / off;
        if share < S::ONE {
            for (control, start) in moved.controls_mut().iter_mut().zip(given.controls()) {
                *control = from_fn(|i| start[i] + share * (control[i] - start[i]));
            }
        }
        consider(self, &moved, MOVED_CURL_SHARE);
        swept.move_to(moved.controls());
        // A second pass gains nothing there, but that it reaches what the first one held of a closed spline.
        let passes = if given.is_closed() { options.passes } else { 1 };
        self.sweep(&mut swept, &given, options, passes);
        consider(self, &swept, MOVED_CURL_SHARE);
        Ok(())
    }

    /// Smooths by sweeps, inside the tube around `given`.
    fn sweep<const CAP: usize>(
        &mut self,
        spline: &mut Spline<S, N, CAP>,
        given: &Spline<S, N, CAP>,
        options: &Options<S>,
        passes: u16,
    ) {
        let m = given.controls().len();
        for pass in 0..passes {
            let first = if given.is_closed() { usize::from(pass) * m / 2 % m.max(1) } else { 0 };
            self.load(spline, given, first, options);
            self.prepare(first, options);
            let free = if given.is_closed() { HELD..m } else { 1..m - 1 };
            Tube {
                poles: &mut self.poles,
                spans: &self.spans,
                checks: &mut self.checks,
                // The third derivative as a candidate besides, as runs of lines are smoothed, would take half as long
                // again, and the means over the thesis's cases and ripples are the same.
                kind: OfSpline { most_curls: &self.most_curls },
            }
            .improve(options.sweeps, &free, &mut self.system);
            for (k, pole) in self.poles.iter().take(m).enumerate() {
                let i = (first + k) % m.max(1);
                if let (Some(control), Some(start)) =
                    (spline.controls_mut().get_mut(i), given.controls().get(i))
                {
                    *control = from_fn(|n| start[n] + pole.shift[n]);
                }
            }
        }
    }

    /// Takes the spline as given: how much every span of it is curved.
    fn begin<const CAP: usize>(&mut self, given: &Spline<S, N, CAP>, options: &Options<S>) {
        self.loaded = None;
        self.load(given, given, 0, options);
        self.curls.clear();
        for (k, span) in self.spans.iter().enumerate() {
            append(&mut self.curls, span.curl(&edges(&self.poles, k, |_| zero())));
        }
    }

    /// Takes the poles of a spline, from control point `first` on, and the spans and check points of the spline as given.
    fn load<const CAP: usize>(
        &mut self,
        spline: &Spline<S, N, CAP>,
        given: &Spline<S, N, CAP>,
        first: usize,
        options: &Options<S>,
    ) {
        self.poles.clear();
        let (controls, spans) = (given.controls(), given.spans());
        let m = controls.len().max(1);
        let at = |k: usize| controls.get(k % m).copied().unwrap_or_else(zero);
        for k in first..first + spans + 3 {
            let mut pole = Pole::new(sub(&at(k + 1), &at(k)));
            pole.shift = spline.controls().get(k % m).map_or_else(zero, |now| sub(now, &at(k)));
            append(&mut self.poles, pole);
        }
        if self.loaded == Some(first) {
            return;
        }
        self.loaded = Some(first);
        self.spans.clear();
        self.checks.clear();
        let radius = options.radius * S::of(SHARE);
        for k in 0..spans {
            let local = given.local((first + k) % m);
            let gap = local.step() * S::of(1.0 / SPAN_CHECKS as f64);
            let mut span = Span::new(&local, gap * gap * S::of(0.125));
            span.first_check = (k * SPAN_CHECKS) as u16;
            span.checks = SPAN_CHECKS as u16;
            append(&mut self.spans, span);
            for j in 0..SPAN_CHECKS {
                let at = gap * S::from_u32(j as u32);
                append(&mut self.checks, CheckPoint::still(local.values(at), radius));
            }
        }
    }

    /// What sweeps need besides: prices by the present curvature.
    fn prepare(&mut self, first: usize, options: &Options<S>) {
        self.set_most_curls(first, CURL_SHARE);
        self.set_reach(options);
        for (k, span) in self.spans.iter_mut().enumerate() {
            let edges = edges(&self.poles, k, |pole| pole.shift);
            let (r, speed) = (span.reach, span.slowest(&edges).greatest(S::of(1.0e-9)));
            // v^4 by the integral of k^2 over the length.
            let root = r.cbrt();
            span.price = r * r * root * root / (speed * speed * speed);
            let weight = <OfSpline<S> as Kind<S>>::DERIVATIVE.first_weight(span);
            for check in part_mut(&mut self.checks, span.range()) {
                check.weight = weight;
            }
        }
    }

    /// How far from every span, by the motion, the place is at which it would be at rest: v^1.5
    /// over its slope.
    fn set_reach(&mut self, options: &Options<S>) {
        let slope = S::of(1.5) * options.trajectory.jerk.sqrt();
        let n = self.spans.len();
        for (k, span) in self.spans.iter_mut().enumerate() {
            let curl = span.curl(&edges(&self.poles, k, |pole| pole.shift));
            let speed = options.trajectory.allowed(curl);
            span.reach = speed * speed.sqrt() / slope;
        }
        // Twice there and back, for closed ones.
        let Some(mut there) = self.spans.last().map(|span| span.reach) else { return };
        for k in (0..2 * n).rev().chain(0..2 * n).map(|k| k % n.max(1)) {
            let Some(span) = self.spans.get_mut(k) else { return };
            let way = span.slowest(&edges(&self.poles, k, |pole| pole.shift)) * span.step;
            span.reach = span.reach.least(there);
            there = span.reach + way;
        }
    }

    /// What curvature may reach, the spans being those from control point `first` on: see the head of the file.
    fn set_most_curls(&mut self, first: usize, share: f64) {
        let n = self.spans.len();
        let curls = |from: usize, to: usize| {
            (from..to).filter_map(|k| self.curls.get((first + k) % n).copied())
        };
        let floor = curls(0, n).fold(S::ZERO, S::greatest) * S::of(CURL_FLOOR);
        self.most_curls.clear();
        for k in 0..n {
            let beside = curls(k.saturating_sub(BESIDE), n.min(k + BESIDE + 1));
            append(&mut self.most_curls, beside.fold(floor, S::greatest) * S::of(share));
        }
    }

    /// Estimated time over a spline, s; none if curvature has risen somewhere.
    fn time<const CAP: usize>(
        &mut self,
        spline: &Spline<S, N, CAP>,
        given: &Spline<S, N, CAP>,
        options: &Options<S>,
        share: f64,
    ) -> Option<S> {
        self.load(spline, given, 0, options);
        self.set_most_curls(0, share);
        let mut finder = Lows::default();
        self.lows.clear();
        let mut way = S::ZERO;
        for (k, (span, most_curl)) in self.spans.iter().zip(&self.most_curls).enumerate() {
            let curl = span.curl(&edges(&self.poles, k, |pole| pole.shift));
            if !(curl <= *most_curl) {
                return None;
            }
            let hodograph = Hodograph::new(&spline.bezier(k));
            // Where the path turns much its peak of curvature is narrow.
            let turn = curl * hodograph.polygon();
            let parts = if turn > S::of(SHARP_TURN) { SHARP_PARTS } else { PARTS };
            let per = S::ONE / S::from_u32(parts);
            // The way grows as the trapezoidal rule has it.
            let mut before = None;
            for j in 0..=parts {
                let (slope, speed) = hodograph.at(S::from_u32(j) * per, &options.trajectory);
                if let Some(before) = before.replace(slope) {
                    way += (before + slope) * per * S::of(0.5);
                } else if k > 0 {
                    // The end of the span before.
                    continue;
                }
                if let Some(low) = finder.push(way, speed) {
                    self.lows.push(low).ok()?;
                }
            }
        }
        for low in finder.finish()? {
            self.lows.push(low).ok()?;
        }
        Some(options.trajectory.plan(&mut self.lows))
    }
}

/// The first derivative of a cubic Bezier curve by its parameter, and the second, as Bezier curves.
struct Hodograph<S, const N: usize> {
    first: [Vector<S, N>; 3],
    second: [Vector<S, N>; 2],
}

impl<S: Scalar, const N: usize> Hodograph<S, N> {
    fn new(b: &[Vector<S, N>; 4]) -> Self {
        let three = S::of(3.0);
        let first: [Vector<S, N>; 3] = from_fn(|j| from_fn(|i| three * (b[j + 1][i] - b[j][i])));
        let two = S::of(2.0);
        let second = from_fn(|j| from_fn(|i| two * (first[j + 1][i] - first[j][i])));
        Self { first, second }
    }

    /// Length of the control polygon, mm: not less than that of the curve.
    fn polygon(&self) -> S {
        let [a, b, c] = &self.first;
        (norm(a) + norm(b) + norm(c)) * S::of(1.0 / 3.0)
    }

    /// What the curve gains by the parameter at a share of it, mm, and the speed that is allowed there, mm/s.
    #[inline]
    fn at(&self, u: S, trajectory: &Trajectory<S>) -> (S, S) {
        let [a, b, c] = &self.first;
        let [start, end] = &self.second;
        let d = bezier::parabola([a, b, c], u);
        let dd = mix(S::ONE - u, start, u, end);
        let square = dot(&d, &d);
        let across = mix(S::ONE, &dd, -(dot(&d, &dd) / square), &d);
        (square.sqrt(), trajectory.allowed(norm(&across) / square))
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // what is exact is meant to be
mod tests {
    use super::*;
    use std::boxed::Box;

    type Planar = Spline<f64, 2, 64>;

    fn smoother<const N: usize>() -> Box<Smoother<f64, N, 64, 256>> {
        Box::new(Smoother::new())
    }

    fn check(given: &Planar, radius: f64) -> Planar {
        let mut spline = given.clone();
        smoother().smooth(&mut spline, &Options::new(radius)).unwrap();
        let off = spline.difference(given).unwrap();
        assert!(off.greatest(200) <= radius, "{}", off.greatest(200));
        spline
    }

    fn noisy() -> Planar {
        let points: std::vec::Vec<[f64; 2]> =
            (0..30).map(|k| [f64::from(k), if k == 12 || k == 20 { 0.2 } else { 0.0 }]).collect();
        let knots: std::vec::Vec<f64> = (0..28).map(f64::from).collect();
        Planar::open(&points, &knots).unwrap()
    }

    #[test]
    fn noise_goes_and_the_ends_stay() {
        let given = noisy();
        let spline = check(&given, 0.15);
        assert!(spline.peak(20) < 0.2 * given.peak(20), "{} {}", spline.peak(20), given.peak(20));
        for k in [0, 29] {
            assert!(spline.controls()[k] == given.controls()[k]);
        }
    }

    #[test]
    fn no_passes_and_no_radius_change_nothing() {
        let given = noisy();
        for options in [Options { passes: 0, ..Options::new(0.1) }, Options::new(0.0)] {
            let mut spline = given.clone();
            smoother().smooth(&mut spline, &options).unwrap();
            assert!(spline.controls() == given.controls());
        }
        let mut spline = given;
        for radius in [-0.1, f64::NAN, 1e9] {
            assert!(smoother().smooth(&mut spline, &Options::new(radius)).is_err());
        }
    }

    /// A "U" does not become a "V": its curvature does not rise (it is held down at three places per
    /// span), however wide the tube.
    #[test]
    fn a_u_stays_a_u() {
        let points: std::vec::Vec<[f64; 2]> = (-8..=8)
            .map(|k| match k {
                -8..=-4 => [-2.0, f64::from(-k) - 3.0],
                4..=8 => [2.0, f64::from(k) - 3.0],
                _ => {
                    let angle = f64::from(k) * core::f64::consts::FRAC_PI_8;
                    [2.0 * angle.sin(), 1.0 - 2.0 * angle.cos()]
                }
            })
            .collect();
        let knots: std::vec::Vec<f64> = (0..15).map(f64::from).collect();
        let given = Planar::open(&points, &knots).unwrap();
        for radius in [0.05, 0.3, 1.0] {
            let spline = check(&given, radius);
            assert!(
                spline.peak(20) <= 1.2 * given.peak(20),
                "{radius}: {} {}",
                spline.peak(20),
                given.peak(20)
            );
        }
    }

    #[test]
    fn closed_splines_are_smoothed_all_around() {
        let points: std::vec::Vec<[f64; 2]> = (0..24)
            .map(|k| {
                let angle = f64::from(k) * core::f64::consts::TAU / 24.0;
                let r = if k % 4 == 0 { 10.3 } else { 10.0 };
                [r * angle.cos(), r * angle.sin()]
            })
            .collect();
        let given = Planar::closed(&points, &[1.0; 24]).unwrap();
        let mut spline = given.clone();
        let options = Options { passes: 4, ..Options::new(0.2) };
        smoother().smooth(&mut spline, &options).unwrap();
        assert!(spline.difference(&given).unwrap().greatest(200) <= 0.2);
        // All of the ripples, not only those far from where it was cut open.
        for k in (0..24).step_by(4) {
            let [x, y] = spline.controls()[k];
            assert!(x.hypot(y) < 10.25, "{k}: {}", x.hypot(y));
        }
    }
}
