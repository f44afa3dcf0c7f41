//! The pieces of a motion that is run by another clock.

use super::clock::{Clock, Instant};
use crate::machine::{AxisLimits, Limits, UNLIMITED};
use crate::number::Scalar;
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// What may be used of a limit more than all of it, but for rounding, which agreed pieces have as well.
const MOST: f64 = 1.000_001;
/// What the velocity gained over a step is rounded by, in units of its last place, is felt as this much jerk for every step squared.
const FELT: f64 = 60.0;

/// A clock over a step.
#[derive(Clone, Copy, Debug)]
pub struct Run<S> {
    /// Duration, s.
    pub time: S,
    /// Bend, 1/s2.
    pub bend: S,
    /// How it goes at the beginning.
    pub from: Clock<S>,
    /// How it goes at the end.
    pub to: Clock<S>,
}

impl<S: Scalar> Run<S> {
    /// What it makes of a piece between two instants, s from its start.
    #[inline(never)]
    pub fn piece<const N: usize>(
        &self,
        piece: &Piece<S, N>,
        [first, last]: [S; 2],
        sequel: Sequel,
    ) -> Piece<S, N> {
        let h = self.time;
        let per = S::ONE / h;
        let axes = self.axes(piece, [first, last]);
        let [s1, s2, s3, s4] = piece.path;
        let along = [[s1, s2, s3, s4, S::ZERO]];
        let (from, to) = (Instant::of(&along, first), Instant::of(&along, last));
        let [p1, p2, _] = self.begins(from.velocity[0], from.acceleration[0], from.jerk[0]);
        let run = |t: S| (s1 + (s2 + (s3 + s4 * t) * t) * t) * t;
        let way = run(last) - run(first);
        let ends = to.velocity[0] * self.to.rate;
        // The second and the third of the Bernstein coefficients of the speed.
        let second = p1 + p2 * h * S::of(2.0 / 3.0);
        let third = way * S::of(4.0) * per - p1 - second - ends;
        let path = if self.to == Clock::STOPPED {
            forwards([p1, S::of(UNLIMITED), S::ZERO], way, h)
        } else if !(second >= S::ZERO && third >= S::ZERO) {
            forwards([p1, second, ends], way, h)
        } else {
            // What is still missing of speed at the end, and of the way.
            let begun = (p1 + p2 * h) * h;
            let speed = (ends - (p1 + (p2 + p2) * h)) * h;
            let p4 = speed - S::of(3.0) * (way - begun);
            let p3 = (speed - S::of(4.0) * p4) * S::of(1.0 / 3.0);
            let cube = per * per * per;
            [p1, p2, p3 * cube, p4 * cube * per]
        };
        Piece {
            time: h,
            origin: piece.place(first),
            axes,
            arc_length: piece.arc_length.plus(run(first)),
            path,
            sequel,
            event: false,
            ..*piece
        }
    }

    /// Whether what it makes of a piece between two instants keeps the limits of acceleration and jerk at every instant.
    #[inline(never)]
    pub fn keeps<const N: usize>(
        &self,
        piece: &Piece<S, N>,
        shows: [S; 2],
        limits: &Limits<S, N>,
    ) -> bool {
        keeps(self.time, &self.axes(piece, shows), limits)
    }

    /// What it makes of the axes of a piece between two instants.
    #[inline(never)]
    fn axes<const N: usize>(&self, piece: &Piece<S, N>, [first, last]: [S; 2]) -> [[S; 5]; N] {
        from_fn(|i| self.axis(&piece.axes[i], first, last - first))
    }

    /// What it makes of an axis with these coefficients while it shows `shows` seconds from `first` on.
    ///
    /// By what changes over the step, not by what is there at its ends: a difference of velocities is rounded like the
    /// velocities, and in `f32` that would be felt as jerk.
    fn axis(&self, [c1, c2, c3, c4, c5]: &[S; 5], first: S, shows: S) -> [S; 5] {
        let n = |x: f64| S::of(x);
        let (h, s) = (self.time, shows);
        let (Clock { rate: r, slope: g }, end) = (self.from, self.to);
        let Instant { velocity: [v], acceleration: [a], jerk: [j] } =
            Instant::of(&[[*c1, *c2, *c3, *c4, *c5]], first);
        let (fourth, fifth) = (*c4 + n(5.0) * first * *c5, *c5);
        // What the motion gains over the step by its own clock, of acceleration and of velocity; and what it goes beyond its
        // velocity.
        let more = (j + (n(12.0) * fourth + n(20.0) * fifth * s) * s) * s;
        let faster = (a + (j * n(0.5) + (n(4.0) * fourth + n(5.0) * fifth * s) * s) * s) * s;
        let further = (a * n(0.5) + (j * n(1.0 / 6.0) + (fourth + fifth * s) * s) * s) * s * s;
        // Of its jerk by this clock, what does not come from the bend: that is a cubic, and missed nowhere.
        let jerk = (n(3.0) * a * g + j * r * r) * r;
        // The clock may be let go to the last bit: what its bend leaves of its slope.
        let left = end.slope - (g + self.bend * h);
        // What the cubic has not, of acceleration, velocity and way.
        let gain = (a * (end.rate + r) * (end.rate - r)
            + more * end.rate * end.rate
            + faster * end.slope
            + v * left
            - jerk * h)
            * h;
        let speed = faster * end.rate - (a * r * r + jerk * h * n(0.5)) * h;
        let missed = further - (a * r * r * n(0.5) + jerk * h * n(1.0 / 6.0)) * h * h;
        let per = S::ONE / h;
        let cube = per * per * per;
        // The quartic and the quintic that end with these gains of velocity and acceleration, and then the way.
        let (c4, c5) = (speed - gain * n(0.25), (gain - n(3.0) * speed) * n(0.2));
        let way = missed * per - c4 - c5;
        let [p1, p2, p3] = self.begins(v, a, j);
        [
            p1,
            p2,
            p3 + n(10.0) * way * per * per,
            (c4 - n(15.0) * way) * cube,
            (c5 + n(6.0) * way) * cube * per,
        ]
    }

    /// The first coefficients of a motion, from its derivatives by its own time.
    #[inline]
    fn begins(&self, v: S, a: S, j: S) -> [S; 3] {
        let Clock { rate: r, slope: g } = self.from;
        let jerk = v * self.bend + (S::of(3.0) * a * g + j * r * r) * r;
        [v * r, (a * r * r + v * g) * S::of(0.5), jerk * S::of(1.0 / 6.0)]
    }
}

/// Coefficients of t^1 .. t^4 of a path that goes a way in `time` seconds, with a speed at its start and one at its end, and never back.
///
/// Of its speed the Bernstein coefficients are none below 0: those two, between them one that is as near as can be to `second`, and what the way
/// asks for then. Of a motion that stops the second has all of that, and its acceleration has gone where it rests. Where the motion slows down by its own
/// clock so much that the way is less than the speeds at the ends alone would make, that at the start is a lesser one.
fn forwards<S: Scalar>([first, second, last]: [S; 3], way: S, time: S) -> [S; 4] {
    let per = S::ONE / time;
    let all = (way * S::of(4.0) * per).greatest(S::ZERO);
    let last = last.least(all);
    let first = first.least(all - last);
    let left = all - last - first;
    let second = second.greatest(S::ZERO).least(left);
    let third = left - second;
    let (two, three) = (S::of(2.0), S::of(3.0));
    [
        first,
        (second - first) * S::of(1.5) * per,
        (first - two * second + third) * per * per,
        (last - three * third + three * second - first) * S::of(0.25) * per * per * per,
    ]
}

/// Whether axes with these coefficients keep the limits of acceleration and jerk at every instant of `h` seconds.
fn keeps<S: Scalar, const N: usize>(h: S, axes: &[[S; 5]; N], limits: &Limits<S, N>) -> bool {
    let half = S::of(0.5);
    let most = S::of(MOST);
    let felt = S::EPSILON * S::of(FELT) / h;
    let keeps = |axis: &AxisLimits<S>, [_, c2, c3, c4, c5]: &[S; 5], rounded: S| {
        // Bernstein coefficients of the jerk, and of either half (see the rows); of the acceleration.
        let q0 = S::of(6.0) * *c3;
        let rise = S::of(12.0) * *c4 * h;
        let (q1, q2) = (q0 + rise, q0 + rise + rise + S::of(60.0) * *c5 * h * h);
        let (a0, third) = (*c2 + *c2, h * S::of(1.0 / 3.0));
        let a1 = a0 + (q0 + q1 + q2) * third;
        let jerk = axis.jerk * most + rounded * felt;
        let acceleration = axis.acceleration * most;
        [q0, (q0 + q1) * half, (q1 + q2) * half, q2].iter().all(|q| q.abs() <= jerk)
            && [a0, a0 + q0 * third, a1 - q2 * third, a1].iter().all(|a| a.abs() <= acceleration)
    };
    // The acceleration of an axis at the start.
    let rounded = |[_, c2, ..]: &[S; 5]| (*c2 + *c2).abs();
    limits.axes().iter().zip(axes).all(|(axis, c)| keeps(axis, c, rounded(c)))
        && limits.motors().all(|motor| {
            let (mut sum, mut all) = ([S::ZERO; 5], S::ZERO);
            for (factor, c) in motor.factors.iter().zip(axes) {
                for (sum, c) in sum.iter_mut().zip(c) {
                    *sum += *factor * *c;
                }
                all += factor.abs() * rounded(c);
            }
            keeps(&motor.limits, &sum, all)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::serial::NodeSerial;
    use crate::number::{ArcLength, Coord};

    fn piece() -> Piece<f64, 2> {
        Piece {
            serial: NodeSerial::ZERO,
            tag: 7,
            time: 0.02,
            origin: [Coord::ZERO; 2],
            axes: [[80.0, -300.0, 4.0e3, 2.0e4, -1.0e5], [20.0, 500.0, -6.0e3, 5.0e4, 3.0e5]],
            arc_length: ArcLength::ZERO,
            path: [82.0, -100.0, 500.0, 1.0e3],
            sequel: Sequel::Motion,
            event: false,
        }
    }

    const SLOWS: Clock<f64> = Clock { rate: 0.8, slope: -9.0 };
    const BEND: f64 = -400.0;
    const TIME: f64 = 4.0e-3;

    /// The run from 5 ms on, and what the clock then shows.
    fn run() -> (Run<f64>, [f64; 2]) {
        let run = Run { time: TIME, bend: BEND, from: SLOWS, to: SLOWS.after(TIME, BEND) };
        (run, [5.0e-3, 5.0e-3 + SLOWS.shown(TIME, BEND)])
    }

    /// x(tau(t)) by the polynomials themselves: place, velocity, acceleration, jerk by differences.
    fn exact(t: f64) -> [f64; 2] {
        let piece = piece();
        let tau = 5.0e-3 + SLOWS.shown(t, BEND);
        [0, 1].map(|i| piece.axes[i].iter().rev().fold(0.0, |sum, c| (sum + c) * tau))
    }

    #[test]
    fn a_piece_by_another_clock_passes_the_same_places_later() {
        let (run, shows) = run();
        let made = run.piece(&piece(), shows, Sequel::Within);
        for k in 0..=8 {
            let t = TIME * f64::from(k) / 8.0;
            let here = made.at(t);
            for (i, place) in exact(t).into_iter().enumerate() {
                assert!((here.position_mm(i) - place).abs() < 1.0e-8, "{k} {i}");
            }
        }
        let (first, last) = (made.at(0.0), made.at(TIME));
        for i in 0..2 {
            let step = 1.0e-6;
            let around = |t: f64| [exact(t - step)[i], exact(t)[i], exact(t + step)[i]];
            for (t, at) in [(0.0, first), (TIME, last)] {
                let [a, b, c] = around(t);
                assert!((at.velocity[i] - (c - a) / (2.0 * step)).abs() < 1.0e-5);
                assert!((at.acceleration[i] - (c - 2.0 * b + a) / (step * step)).abs() < 2.0);
            }
        }
        let (p, s) = (piece().path, shows[1]);
        let speed = p[0] + s * (2.0 * p[1] + s * (3.0 * p[2] + s * 4.0 * p[3]));
        assert!((last.path_speed - speed * run.to.rate).abs() < 1.0e-9);
    }

    /// A clock whose bend leaves a hundredth of its slope, and which is said to go evenly at the end: so does the motion.
    #[test]
    fn a_clock_that_is_let_go_to_the_last_bit_leaves_no_leap() {
        let bend = -SLOWS.slope / TIME * 0.99;
        let to = Clock { slope: 0.0, ..SLOWS.after(TIME, bend) };
        let run = Run { time: TIME, bend, from: SLOWS, to };
        let last = 5.0e-3 + SLOWS.shown(TIME, bend);
        let end = run.piece(&piece(), [5.0e-3, last], Sequel::Motion).at(TIME);
        let agreed = piece().at(last);
        for i in 0..2 {
            let (v, a) = (agreed.velocity[i] * to.rate, agreed.acceleration[i] * to.rate * to.rate);
            assert!((end.velocity[i] - v).abs() < 1.0e-9, "{} {v}", end.velocity[i]);
            assert!((end.acceleration[i] - a).abs() < 1.0e-6, "{} {a}", end.acceleration[i]);
            assert!((end.position_mm(i) - agreed.position_mm(i)).abs() < 1.0e-9);
        }
    }

    /// A motion that comes to rest by its own clock as well, the sooner the less is left of it where the clock stops.
    #[test]
    fn a_path_that_stops_never_goes_back() {
        for slower in [-1.0, 0.0, 0.4, 0.9, 1.1, 1.34, 1.6, 2.5, 2.99] {
            let (speed, clock) = (10.0, Clock { rate: 0.6, slope: -300.0 });
            let (bend, time) = clock.end().unwrap();
            // Of its speed, a third of so much is gone where the clock stops.
            let acceleration = -slower * speed / (clock.rate * time);
            let along = [speed, acceleration * 0.5, 0.0, 0.0];
            let straight = [speed, acceleration * 0.5, 0.0, 0.0, 0.0];
            let agreed = Piece { axes: [straight, [0.0; 5]], path: along, ..piece() };
            let last = clock.shown(time, bend);
            let run = Run { time, bend, from: clock, to: Clock::STOPPED };
            let made = run.piece(&agreed, [0.0, last], Sequel::Stop);
            let mut before = 0.0;
            for k in 0..=200 {
                let here = made.at(time * f64::from(k) / 200.0);
                assert!(here.path_speed >= -1.0e-12, "{slower} {k}: {}", here.path_speed);
                assert!(here.path_mm() >= before - 1.0e-9, "{slower} {k}");
                before = here.path_mm();
            }
            let [first, end] = [0.0, time].map(|t| made.at(t));
            let way = agreed.at(last).path_mm();
            assert!(first.path_mm().abs() < 1.0e-7 && (end.path_mm() - way).abs() < 1.0e-7);
            assert!(end.path_speed.abs() < 1.0e-9);
            let begins = first.path_speed / (speed * clock.rate);
            assert!((0.6..1.0 + 1.0e-9).contains(&begins) && (slower > 1.5 || begins > 0.999));
        }
    }

    /// A clock that is let go when it hardly goes any more, in a motion that slows down by itself, or gathers speed.
    #[test]
    fn a_path_that_nearly_stops_never_goes_back() {
        let mut bent = 0;
        for rate in [0.0, 1.0e-4, 1.0e-2, 0.1] {
            for slower in [-2.0, -1.0, 0.0, 0.4, 0.9, 1.1, 1.6, 2.5, 2.9] {
                let (speed, from) = (10.0, Clock { rate: 0.6, slope: -300.0 });
                let time = 2.0 * (from.rate - rate) / -from.slope;
                let bend = -from.slope / time;
                let shown = from.shown(time, bend);
                let along = [speed, -slower * speed / shown * 0.33 * 0.5, 0.0, 0.0];
                let straight = [along[0], along[1], 0.0, 0.0, 0.0];
                let agreed = Piece { axes: [straight, [0.0; 5]], path: along, ..piece() };
                let run = Run { time, bend, from, to: Clock { rate, slope: 0.0 } };
                let made = run.piece(&agreed, [0.0, shown], Sequel::Within);
                let mut before = 0.0;
                for k in 0..=200 {
                    let here = made.at(time * f64::from(k) / 200.0);
                    assert!(
                        here.path_speed >= -1.0e-12,
                        "{rate} {slower} {k}: {}",
                        here.path_speed
                    );
                    assert!(here.path_mm() >= before - 1.0e-9, "{rate} {slower} {k}");
                    before = here.path_mm();
                }
                let ends = [made.at(time), agreed.at(shown)];
                assert!((ends[0].path_mm() - ends[1].path_mm()).abs() < 1.0e-7);
                assert!((ends[0].path_speed - ends[1].path_speed * rate).abs() < 1.0e-9);
                bent += usize::from(made.path[1] > 0.999 * -speed * 300.0 * 0.5);
            }
        }
        assert!(bent > 0);
    }

    /// At the least and the greatest bend a limit is used up, between them none is broken.
    /// In a millisecond at 180 mm/s the jerk of `f32` is that of `f64`.
    #[test]
    fn a_short_piece_asks_no_more_in_single_precision() {
        fn jerks<S: Scalar>() -> [f64; 3] {
            let clock = Clock { rate: S::of(0.97), slope: S::of(-1.4) };
            let (bend, shown) = (S::of(-170.0), S::of(1.3e-3));
            let last = S::of(2.0e-3) + clock.shown(shown, bend);
            let time = clock.exactly([S::of(2.0e-3), last], shown, bend);
            let shown = last;
            let run = Run { time, bend, from: clock, to: clock.after(time, bend) };
            let axes = [[183.0, -330.0, 2.8e3, 1.0e4, 0.0].map(S::of)];
            let place = Piece::<S, 1> {
                serial: NodeSerial::ZERO,
                tag: 0,
                time: S::of(0.01),
                origin: [Coord::ZERO],
                axes,
                arc_length: ArcLength::ZERO,
                path: [S::ZERO; 4],
                sequel: Sequel::Motion,
                event: false,
            };
            let made = run.piece(&place, [S::of(2.0e-3), shown], Sequel::Within);
            let [.., c3, c4, c5] = made.axes[0].map(Scalar::to_f64);
            [0.0, 0.5, 1.0].map(|part| {
                let t = part * made.time.to_f64();
                6.0 * c3 + (24.0 * c4 + 60.0 * c5 * t) * t
            })
        }
        for (single, double) in jerks::<f32>().into_iter().zip(jerks::<f64>()) {
            assert!((single - double).abs() < 20.0, "{single} {double}");
        }
    }

    #[test]
    fn a_piece_beyond_a_limit_is_seen() {
        let (run, shows) = run();
        let made = run.piece(&piece(), shows, Sequel::Within);
        let kept = |acceleration: f64, jerk: f64| {
            let axis = AxisLimits::linear(200.0, acceleration, jerk);
            run.keeps(&piece(), shows, &Limits::new([axis; 2]).unwrap())
        };
        let most = |of: &dyn Fn(&[f64; 5], f64) -> f64| {
            let times = (0..=40).map(|k| TIME * f64::from(k) / 40.0);
            times.flat_map(|t| made.axes.map(|c| of(&c, t).abs())).fold(0.0, f64::max)
        };
        let a = most(&|c, t| 2.0 * c[1] + t * (6.0 * c[2] + t * (12.0 * c[3] + t * 20.0 * c[4])));
        let j = most(&|c, t| 6.0 * c[2] + t * (24.0 * c[3] + t * 60.0 * c[4]));
        assert!(kept(a * 1.01, j * 1.01));
        assert!(!kept(a * 0.99, j * 1.01) && !kept(a * 1.01, j * 0.99));
    }
}
