//! Smoothing in a set number of sweeps, inside the tube by a bound.
//!
//! The same sweeps that smooth runs of short lines on their way to the machine
//! (`sweep` in this room), applied to a spline that comes as such. Against [`super::thesis`]:
//! - the tube is never left: between the places of comparison the difference spline is bounded by
//!   its second derivative; every pass leaves a valid spline, so it may be stopped after any of them;
//! - what is minimised is the third derivative (what a jerk-limited machine pays for), weighted by how fast the
//!   motion can be there, by solving one band system for all control points at once; no
//!   categories, so nothing changes in jumps, and it works in any number of axes;
//! - the known weaknesses of the thesis (section 5.1: a "U" that becomes a "V", curvature that rises in
//!   places) are excluded: no span's curvature, by an upper estimate, may exceed what the spline as
//!   given had in its neighbourhood by more than a little;
//! - the ends stay where they are, so that nothing has to be joined to them anew.

use super::bspline::Spline;
use super::error::SplineError;
use super::sweep::{Reference, System, Tube};
use super::tube::{Place, Pole, Span};
use crate::number::Scalar;
use crate::number::vector::{Vector, dot, norm, sub, zero};
use core::array::from_fn;
use heapless::Vec;

/// Places of comparison in a span.
pub const SPAN_PLACES: usize = 4;
/// Reach at a vertex of the control polygon, times turn^1.5 over radius.
const REACH: f64 = 25.0;
/// Share of the radius that is used; the rest is for rounding.
const SHARE: f64 = 0.99;
/// By what curvature may exceed the greatest of the neighbourhood as given; and the share of the
/// greatest of all that it may reach anywhere.
const BEND_SHARE: f64 = 1.02;
const BEND_FLOOR: f64 = 0.05;
/// Spans on either side that are its neighbourhood.
const BESIDE: usize = 4;
/// Control points of a closed spline that are held while the others move.
const HELD: usize = 3;

/// How to smooth.
#[derive(Clone, Copy, Debug)]
pub struct Options<S> {
    /// Radius of the tube, mm.
    pub radius: S,
    /// Sweeps in a pass; 0 leaves the spline as it is.
    pub sweeps: u16,
    /// Passes; a closed spline is cut open at another place for each.
    pub passes: u16,
}

impl<S: Scalar> Options<S> {
    /// 16 sweeps in two passes within a radius, mm.
    pub fn new(radius: S) -> Self {
        Self { radius, sweeps: 16, passes: 2 }
    }
}

/// Work space for splines of at most `SIZE` - 3 control points and `PLACES` = 4 `SIZE` places of
/// comparison.
pub struct Smoother<S, const N: usize, const SIZE: usize, const PLACES: usize> {
    poles: Vec<Pole<S, N>, SIZE>,
    spans: Vec<Span<S>, SIZE>,
    places: Vec<Place<S, N>, PLACES>,
    system: System<S, N, SIZE>,
}

impl<S: Scalar, const N: usize, const SIZE: usize, const PLACES: usize> Default
    for Smoother<S, N, SIZE, PLACES>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const N: usize, const SIZE: usize, const PLACES: usize>
    Smoother<S, N, SIZE, PLACES>
{
    /// An empty work space.
    pub const fn new() -> Self {
        const { assert!(PLACES >= SPAN_PLACES * SIZE, "four places per control point") };
        Self { poles: Vec::new(), spans: Vec::new(), places: Vec::new(), system: System::new() }
    }

    /// Smooths a spline inside the tube around it.
    ///
    /// Work: at most (`sweeps` + 8) `passes` band systems over the control points, each with five
    /// rows per span; about 400 operations per control point, axis and sweep.
    ///
    /// # Errors
    /// If the radius is negative or not finite, or the spline has more control points than there is room for.
    pub fn smooth<const CAP: usize>(
        &mut self,
        spline: &mut Spline<S, N, CAP>,
        options: &Options<S>,
    ) -> Result<(), SplineError> {
        let radius = options.radius.to_f64();
        if !(0.0..=1.0e3).contains(&radius) {
            let what = "tolerance radius";
            return Err(SplineError::OutOfRange { what, value: radius, least: 0.0, greatest: 1e3 });
        }
        let m = spline.controls().len();
        if m + HELD > SIZE {
            return Err(SplineError::TooMany { controls: m, room: SIZE - HELD });
        }
        if radius == 0.0 {
            return Ok(());
        }
        // How far every control point has been moved so far.
        let mut shifts: Vec<Vector<S, N>, SIZE> = Vec::new();
        for _ in 0..m {
            let _ = shifts.push(zero());
        }
        for pass in 0..options.passes {
            let first = if spline.is_closed() { usize::from(pass) * m / 2 % m } else { 0 };
            self.fill(spline, first, &shifts, options.radius);
            let free = if spline.is_closed() { (HELD, m) } else { (1, m - 1) };
            Tube {
                poles: &mut self.poles,
                spans: &self.spans,
                places: &mut self.places,
                reference: Reference::Itself,
            }
            .improve(options.sweeps, free, &mut self.system);
            for (k, pole) in self.poles.iter().take(m).enumerate() {
                shifts[(first + k) % m] = pole.shift;
            }
        }
        for (control, shift) in spline.controls_mut().iter_mut().zip(&shifts) {
            for (x, dx) in control.iter_mut().zip(shift) {
                *x += *dx;
            }
        }
        Ok(())
    }

    /// Takes a spline, from control point `first` on.
    fn fill<const CAP: usize>(
        &mut self,
        spline: &Spline<S, N, CAP>,
        first: usize,
        shifts: &[Vector<S, N>],
        radius: S,
    ) {
        self.poles.clear();
        self.spans.clear();
        self.places.clear();
        let (controls, spans) = (spline.controls(), spline.spans());
        let m = controls.len();
        for k in 0..spans + 3 {
            let (i, next) = ((first + k) % m, (first + k + 1) % m);
            let mut pole = Pole::new(sub(&controls[next], &controls[i]));
            pole.shift = shifts[i];
            let _ = self.poles.push(pole);
        }
        for k in 0..spans {
            let local = spline.local((first + k) % m);
            let step = local.step();
            let gap = step * S::of(1.0 / SPAN_PLACES as f64);
            let mut span = Span::new(&local, gap * gap * S::of(0.125));
            span.first_place = self.places.len() as u16;
            span.places = SPAN_PLACES as u16;
            for j in 0..SPAN_PLACES {
                let at = gap * S::from_u32(j as u32);
                let _ = self.places.push(Place::still(local.values(at), radius * S::of(SHARE)));
            }
            let _ = self.spans.push(span);
        }
        self.set_reach(spline.is_closed(), radius);
        self.set_bends();
        for span in &self.spans {
            for place in &mut self.places[span.range()] {
                place.weight = span.first_weight();
            }
        }
    }

    /// How soon the motion has to be slow from every span: the least of reach at a vertex and
    /// way to it, in units of the parameter.
    fn set_reach(&mut self, closed: bool, radius: S) {
        let n = self.spans.len();
        for k in 0..n {
            // The vertex in the middle of the span's polygon.
            let (a, b) = (&self.poles[k].edge, &self.poles[k + 1].edge);
            let (la, lb) = (norm(a), norm(b));
            let cosine = dot(a, b) / (la * lb);
            // Twice the sine of half the turn.
            let turn = (S::of(2.0) * (S::ONE - cosine)).greatest(S::of(1.0e-6)).sqrt();
            let reach = S::of(REACH) * radius / (turn * turn.sqrt());
            let speed = (la + lb) / (self.spans[k].step * S::of(2.0));
            // In units of the parameter, of which the third derivative is one.
            self.spans[k].reach = reach / speed.greatest(S::of(1.0e-9));
        }
        // Twice around, for closed ones.
        for _ in 0..if closed { 2 } else { 1 } {
            let mut there = self.spans[n - 1].reach + self.spans[n - 1].step;
            for k in (0..n).rev() {
                let span = &mut self.spans[k];
                span.reach = span.reach.least(there);
                there = span.reach + span.step;
            }
            let mut there = self.spans[0].reach + self.spans[0].step;
            for span in &mut self.spans {
                span.reach = span.reach.least(there);
                there = span.reach + span.step;
            }
        }
    }

    /// What curvature may reach: see the head of the file.
    fn set_bends(&mut self) {
        let n = self.spans.len();
        let bend = |k: usize| -> S {
            let edges: [Vector<S, N>; 3] = from_fn(|j| self.poles[k + j].edge);
            self.spans[k].curl(&edges)
        };
        let mut bends: Vec<S, SIZE> = Vec::new();
        for k in 0..n {
            let _ = bends.push(bend(k));
        }
        let greatest = bends.iter().fold(S::ZERO, |most, bend| most.greatest(*bend));
        for (k, span) in self.spans.iter_mut().enumerate() {
            let mut most = greatest * S::of(BEND_FLOOR);
            for bend in &bends[k.saturating_sub(BESIDE)..n.min(k + BESIDE + 1)] {
                most = most.greatest(*bend);
            }
            span.most_curl = most * S::of(BEND_SHARE);
        }
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

    fn peak(spline: &Planar) -> f64 {
        (0..spline.spans() * 20)
            .map(|k| spline.curvature(k / 20, f64::from((k % 20) as u32) / 20.0))
            .fold(0.0, f64::max)
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
        assert!(peak(&spline) < 0.2 * peak(&given), "{} {}", peak(&spline), peak(&given));
        for k in [0, 29] {
            assert!(spline.controls()[k] == given.controls()[k]);
        }
    }

    #[test]
    fn no_sweeps_and_no_radius_change_nothing() {
        let given = noisy();
        for options in [
            Options { sweeps: 0, ..Options::new(0.1) },
            Options { passes: 0, ..Options::new(0.1) },
            Options::new(0.0),
        ] {
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
                peak(&spline) <= 1.2 * peak(&given),
                "{radius}: {} {}",
                peak(&spline),
                peak(&given)
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
            assert!(x.hypot(y) < 10.2, "{k}: {}", x.hypot(y));
        }
    }
}
