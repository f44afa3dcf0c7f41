//! A motion run by another clock: the same places in the same order, only later.
//!
//! Of a motion x(tau), tau(t) makes another one. With the clock's rate r = d tau / dt, its slope g = dr / dt and its bend
//! u = dg / dt
//!   x_t   = x' r
//!   x_tt  = x'' r^2 + x' g
//!   x_ttt = x''' r^3 + 3 x'' r g + x' u.
//! A clock that goes slower and evenly (r < 1, g = u = 0) asks less of every axis than the motion does by its own: whatever a
//! machine can run, it can run slower. Over a step the bend is constant; what an axis then does is a quintic that has
//! velocity and acceleration of x(tau(t)) at both ends, and its jerk at the start.

use crate::machine::Limits;
use crate::number::Scalar;
use crate::number::vector::norm;
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// Share of the limits with which a bend is chosen: the quintic is not quite what it stands for.
const SHARE: f64 = 0.998;
/// What may be used of a limit more than all of it, but for rounding, which agreed pieces have as well.
const MOST: f64 = 1.000_001;
/// What a way is rounded by, in units of its last place, is felt as this much jerk for every step cubed.
const FELT: f64 = 60.0;
/// A bend beyond 1 / step^2 times this would stop the clock within the step, whatever its rate was.
const STEEPEST: f64 = 4.0;
/// Rounds of Newton's method for the time at which the clock shows something.
const ROUNDS: usize = 4;

/// How a clock goes at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock<S> {
    /// Seconds that it shows for every second: 1 at first, 0 where it stops.
    pub rate: S,
    /// How that changes, 1/s.
    pub slope: S,
}

impl<S: Scalar> Clock<S> {
    /// The time itself.
    pub const NORMAL: Self = Self { rate: S::ONE, slope: S::ZERO };
    /// For good.
    pub const STOPPED: Self = Self { rate: S::ZERO, slope: S::ZERO };

    /// How it goes `time` seconds later, at a bend, 1/s2.
    #[inline]
    pub fn after(self, time: S, bend: S) -> Self {
        Self {
            rate: self.rate + (self.slope + bend * time * S::of(0.5)) * time,
            slope: self.slope + bend * time,
        }
    }

    /// What it shows until then, s.
    #[inline]
    pub fn shown(self, time: S, bend: S) -> S {
        let (half, sixth) = (S::of(0.5), S::of(1.0 / 6.0));
        (self.rate + (self.slope * half + bend * time * sixth) * time) * time
    }

    /// What it shows after `time` seconds if it shows `shown` now, and when exactly: that number is rounded, and a fraction of a
    /// nanosecond is a way that would be felt as jerk.
    pub fn shows(self, shown: S, time: S, bend: S) -> (S, S) {
        let more = self.shown(time, bend);
        let last = shown + more;
        let rate = self.after(time, bend).rate;
        let missed = (last - shown) - more;
        (last, if rate > S::ZERO { time + missed / rate } else { time })
    }

    /// When it shows so much, about `guess` seconds from now; `None` if it stops before.
    pub fn when(self, shown: S, bend: S, guess: S) -> Option<S> {
        let mut time = guess;
        for _ in 0..ROUNDS {
            let rate = self.after(time, bend).rate;
            if !(rate > S::ZERO) {
                return None;
            }
            time = time - (self.shown(time, bend) - shown) / rate;
        }
        let there = (self.shown(time, bend) - shown).abs() <= shown * S::of(1.0e-4);
        (there && time > S::ZERO && self.goes_on(time, bend)).then_some(time)
    }

    /// Whether it goes forward for so long at a bend.
    pub fn goes_on(self, time: S, bend: S) -> bool {
        let Self { rate, slope } = self;
        let turns = slope < S::ZERO && slope + bend * time > S::ZERO;
        let least = if turns { rate - slope * slope * S::of(0.5) / bend } else { rate };
        least > S::ZERO && self.after(time, bend).rate > S::ZERO
    }

    /// A stop by a bend of -`bend` for some time and of `bend` for another, both in s; no first one is needed if the clock
    /// slows down already. `None` if it slows down too fast for that.
    pub fn stop(self, bend: S) -> Option<[S; 2]> {
        let slows = -self.slope;
        let half = slows * slows * S::of(0.5);
        let first = ((half + bend * self.rate).sqrt() - slows) / bend;
        (first >= S::ZERO).then(|| [first, first + slows / bend])
    }
}

/// What the axes do at an instant, by the motion's own time.
#[derive(Clone, Copy, Debug)]
pub struct Instant<S, const N: usize> {
    velocity: [S; N],
    acceleration: [S; N],
    jerk: [S; N],
}

impl<S: Scalar, const N: usize> Instant<S, N> {
    /// `t` seconds after the start of a piece with these coefficients.
    pub fn of(axes: &[[S; 5]; N], t: S) -> Self {
        let n = |x: f64| S::of(x);
        let (mut velocity, mut acceleration, mut jerk) = ([S::ZERO; N], [S::ZERO; N], [S::ZERO; N]);
        for i in 0..N {
            let [c1, c2, c3, c4, c5] = axes[i];
            let (d4, d5) = (c4 * n(4.0), c5 * n(5.0));
            velocity[i] = c1 + (c2 * n(2.0) + (c3 * n(3.0) + (d4 + d5 * t) * t) * t) * t;
            acceleration[i] = c2 * n(2.0) + (c3 * n(6.0) + (d4 * n(3.0) + d5 * n(4.0) * t) * t) * t;
            jerk[i] = c3 * n(6.0) + (d4 * n(6.0) + d5 * n(12.0) * t) * t;
        }
        Self { velocity, acceleration, jerk }
    }

    /// The time in which the velocity changes by as much as there is of it, s.
    pub fn time_scale(&self) -> S {
        norm(&self.velocity) / (norm(&self.acceleration) + S::of(1.0e-6))
    }
}

/// The numbers between two.
#[derive(Clone, Copy, Debug)]
struct Range<S> {
    least: S,
    most: S,
}

impl<S: Scalar> Range<S> {
    /// Those x for which |constant + slope x| is at most `limit`.
    #[inline]
    fn keep(&mut self, constant: S, slope: S, limit: S) {
        if !(slope.abs() > S::of(1.0e-6)) {
            return;
        }
        let per = S::ONE / slope;
        let (a, b) = ((-limit - constant) * per, (limit - constant) * per);
        self.least = self.least.greatest(a.least(b));
        self.most = self.most.least(a.greatest(b));
    }
}

impl<S: Scalar> Clock<S> {
    /// The bends, 1/s2, from the least to the greatest, at which acceleration and jerk of all axes keep a share of their
    /// limits at both ends of a step of `time` seconds; `None` if there are none.
    #[inline(never)]
    pub fn bends<const N: usize>(
        self,
        [from, to]: [&Instant<S, N>; 2],
        time: S,
        (limits, share): (&Limits<S, N>, S),
    ) -> Option<[S; 2]> {
        let (two, three) = (S::of(2.0), S::of(3.0));
        let steepest = S::of(STEEPEST) / (time * time);
        let mut range = Range { least: -steepest, most: steepest };
        let share = share * S::of(SHARE);
        // What is run already may use all of a limit.
        let most = |limit: S, own: S| (limit * share).greatest(limit.least(own.abs()));
        let Self { rate: r, slope: g } = self;
        let end = (r + g * time).greatest(S::ZERO);
        // By how much the rate at the end changes with the bend; its slope by `time`.
        let per_rate = time * time * S::of(0.5);
        for (i, axis) in limits.axes().iter().enumerate() {
            let (v, a, j) = (from.velocity[i], from.acceleration[i], from.jerk[i]);
            range.keep((j * r * r + three * a * g) * r, v, most(axis.jerk, j));
            let (v, a, j) = (to.velocity[i], to.acceleration[i], to.jerk[i]);
            let per_bend = three * (a * (end * time + g * per_rate) + j * end * end * per_rate);
            range.keep((j * end * end + three * a * g) * end, v + per_bend, most(axis.jerk, j));
            let per_bend = v * time + two * a * end * per_rate;
            range.keep(a * end * end + v * g, per_bend, most(axis.acceleration, a));
        }
        (range.least <= range.most).then_some([range.least, range.most])
    }
}

/// What the axes do over a piece.
#[derive(Clone, Copy, Debug)]
pub struct Shape<S, const N: usize> {
    /// Duration, s.
    pub time: S,
    /// Coefficients of t^1 .. t^5 per axis.
    pub axes: [[S; 5]; N],
}

impl<S: Scalar, const N: usize> Shape<S, N> {
    /// That of a piece.
    pub fn of(piece: &Piece<S, N>) -> Self {
        Self { time: piece.time, axes: piece.axes }
    }
}

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
        let Self { time: h, .. } = *self;
        let (per, shows) = (S::ONE / h, last - first);
        let cube = per * per * per;
        let (from, to) = (Instant::of(&piece.axes, first), Instant::of(&piece.axes, last));
        let axes = from_fn(|i| {
            let [c1, c2, c3] = self.begins(from.velocity[i], from.acceleration[i], from.jerk[i]);
            // What is still missing of velocity and acceleration at the end.
            let speed = to.velocity[i] * self.to.rate - (c1 + (c2 + c2 + S::of(3.0) * c3 * h) * h);
            let acceleration = to.acceleration[i] * self.to.rate * self.to.rate
                + to.velocity[i] * self.to.slope
                - (c2 + c2 + S::of(6.0) * c3 * h);
            let gain = acceleration * h;
            let c4 = (speed - gain * S::of(0.25)) * cube;
            let c5 = (gain - S::of(3.0) * speed) * S::of(0.2) * cube * per;
            // And of the way: what it has beyond the fifth power, and what is rounded in the clock.
            let [.., d4, d5] = piece.axes[i];
            let (half, sixth) = (S::of(0.5), S::of(1.0 / 6.0));
            let further = from.jerk[i] * sixth + (d4 + (S::of(5.0) * first + shows) * d5) * shows;
            let way = (from.velocity[i] + (from.acceleration[i] * half + further * shows) * shows)
                * shows;
            let missed = (way - (c1 + (c2 + (c3 + (c4 + c5 * h) * h) * h) * h) * h) * cube;
            let (more, less) = (S::of(10.0) * missed, S::of(15.0) * missed * per);
            [c1, c2, c3 + more, c4 - less, c5 + S::of(6.0) * missed * per * per]
        });
        let [s1, s2, s3, s4] = piece.path;
        let along = [[s1, s2, s3, s4, S::ZERO]];
        let (from, to) = (Instant::of(&along, first), Instant::of(&along, last));
        let [p1, p2, _] = self.begins(from.velocity[0], from.acceleration[0], from.jerk[0]);
        let run = |t: S| (s1 + (s2 + (s3 + s4 * t) * t) * t) * t;
        // What is still missing of speed at the end, and of the way.
        let begun = (p1 + p2 * h) * h;
        let speed = (to.velocity[0] * self.to.rate - (p1 + (p2 + p2) * h)) * h;
        let third = S::of(1.0 / 3.0);
        let (p4, start) = if self.to == Clock::STOPPED {
            // Of acceleration instead, so that it does not go back; and it ends where it should.
            let p4 = -(p2 * h * h + speed) * S::of(0.5);
            (p4, run(last) - begun - (speed - p4) * third)
        } else {
            (speed - S::of(3.0) * (run(last) - run(first) - begun), run(first))
        };
        let p3 = (speed - S::of(4.0) * p4) * third;
        let path = [p1, p2, p3 * cube, p4 * cube * per];
        Piece {
            time: h,
            origin: piece.place(first),
            axes,
            arc_length: piece.arc_length.plus(start),
            path,
            sequel,
            event: false,
            ..*piece
        }
    }

    /// The first coefficients of a motion, from its derivatives by its own time.
    #[inline]
    fn begins(&self, v: S, a: S, j: S) -> [S; 3] {
        let Clock { rate: r, slope: g } = self.from;
        let jerk = v * self.bend + (S::of(3.0) * a * g + j * r * r) * r;
        [v * r, (a * r * r + v * g) * S::of(0.5), jerk * S::of(1.0 / 6.0)]
    }
}

/// Whether a piece keeps the limits of acceleration and jerk at every instant.
pub fn keeps<S: Scalar, const N: usize>(piece: &Piece<S, N>, limits: &Limits<S, N>) -> bool {
    let h = piece.time;
    let half = S::of(0.5);
    let most = S::of(MOST);
    let felt = S::EPSILON * S::of(FELT) / (h * h);
    limits.axes().iter().zip(&piece.axes).all(|(axis, [c1, c2, c3, c4, c5])| {
        // Bernstein coefficients of the jerk, and of either half (see the rows); of the acceleration.
        let q0 = S::of(6.0) * *c3;
        let rise = S::of(12.0) * *c4 * h;
        let (q1, q2) = (q0 + rise, q0 + rise + rise + S::of(60.0) * *c5 * h * h);
        let (a0, third) = (*c2 + *c2, h * S::of(1.0 / 3.0));
        let a1 = a0 + (q0 + q1 + q2) * third;
        let jerk = axis.jerk * most + c1.abs() * felt;
        let acceleration = axis.acceleration * most;
        [q0, (q0 + q1) * half, (q1 + q2) * half, q2].iter().all(|q| q.abs() <= jerk)
            && [a0, a0 + q0 * third, a1 - q2 * third, a1].iter().all(|a| a.abs() <= acceleration)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::AxisLimits;
    use crate::number::serial::NodeSerial;
    use crate::number::{ArcLength, Coord};
    use std::vec::Vec;

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

    /// At the least and the greatest bend a limit is used up, between them none is broken.
    #[test]
    fn bends_are_those_that_keep_the_limits() {
        let piece = piece();
        let limits = Limits::new([AxisLimits::linear(200.0, 2.0e3, 5.0e4); 2]).unwrap();
        let (_, [first, _]) = run();
        let from = Instant::of(&piece.axes, first);
        let last = first + SLOWS.shown(TIME, 0.0);
        let to = Instant::of(&piece.axes, last);
        let [least, most] = SLOWS.bends([&from, &to], TIME, (&limits, 1.0)).unwrap();
        assert!(least < 0.0 && most > 0.0);
        let used = |bend: f64| {
            let end = SLOWS.after(TIME, bend);
            let mut all = Vec::new();
            for i in 0..2 {
                for (at, clock) in [(&from, SLOWS), (&to, end)] {
                    let Clock { rate: r, slope: g } = clock;
                    let (v, a, j) = (at.velocity[i], at.acceleration[i], at.jerk[i]);
                    all.push((j * r * r * r + 3.0 * a * r * g + v * bend) / 5.0e4);
                }
                all.push(
                    (to.acceleration[i] * end.rate * end.rate + to.velocity[i] * end.slope) / 2.0e3,
                );
            }
            all.into_iter().fold(0.0, |most: f64, share| most.max(share.abs()))
        };
        for bend in [least, most] {
            assert!((used(bend) - 1.0).abs() < 0.02, "{bend}: {}", used(bend));
        }
        assert!(used(least * 0.5) < 1.0 && used(most * 0.5) < 1.0);
        assert!(used(least * 1.2) > 1.05 && used(most * 1.2) > 1.05);
    }

    #[test]
    fn a_clock_is_stopped_by_two_bends() {
        for clock in [Clock { rate: 0.3, slope: 0.0 }, Clock { rate: 0.2, slope: -6.0 }] {
            let [first, second] = clock.stop(900.0).unwrap();
            let end = clock.after(first, -900.0).after(second, 900.0);
            assert!(end.rate.abs() < 1.0e-12 && end.slope.abs() < 1.0e-9, "{end:?}");
        }
        assert!(Clock { rate: 0.01, slope: -6.0 }.stop(900.0).is_none());
    }

    #[test]
    fn a_clock_is_read_backwards() {
        let shown = SLOWS.shown(3.0e-3, BEND);
        let time = SLOWS.when(shown, BEND, 2.0e-3).unwrap();
        assert!((time - 3.0e-3).abs() < 1.0e-12);
        // It stops before; or would show it on its way back.
        assert!(SLOWS.when(1.0, BEND, 2.0e-3).is_none());
        let clock = Clock { rate: 0.1, slope: -40.0 };
        assert!(clock.goes_on(2.0e-3, 0.0) && !clock.goes_on(3.0e-3, 0.0));
        assert!(!clock.goes_on(20.0e-3, 5.0e3) && clock.goes_on(20.0e-3, 9.0e3));
        assert!(clock.when(clock.shown(4.0e-3, 0.0), 0.0, 4.0e-3).is_none());
    }

    #[test]
    fn a_piece_beyond_a_limit_is_seen() {
        let (run, shows) = run();
        let made = run.piece(&piece(), shows, Sequel::Within);
        let kept = |acceleration: f64, jerk: f64| {
            keeps(&made, &Limits::new([AxisLimits::linear(200.0, acceleration, jerk); 2]).unwrap())
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
