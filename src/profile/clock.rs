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

use crate::machine::{AxisLimits, Limits};
use crate::number::Scalar;
use crate::number::vector::norm;
use crate::profile::law::PathState;
use crate::servo::piece::Piece;

/// Share of the limits with which a bend is chosen: the quintic is not quite what it stands for.
const SHARE: f64 = 0.998;
/// A bend beyond 1 / step^2 times this would stop the clock within the step, whatever its rate was.
const STEEPEST: f64 = 4.0;
/// Share of a time that is a rounding.
const ROUNDED: f64 = 1.0e-3;
/// A slope that is none, in parts of 1 / step.
const EVEN: f64 = 1.0e-5;
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

    /// A state of the motion as it is run by it.
    #[inline(never)]
    pub fn run(self, PathState { b, a }: PathState<S>) -> PathState<S> {
        let Self { rate, slope } = self;
        PathState { b: b * rate * rate, a: a * rate * rate + b.sqrt() * slope }
    }

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

    /// When exactly it shows `last` if it shows `first` now, `time` seconds from now or a rounding away. In `f64`: at the speed of
    /// the motion a fraction of a nanosecond is a way that would be felt as jerk.
    #[inline(never)]
    pub fn exactly(self, [first, last]: [S; 2], time: S, bend: S) -> S {
        let clock = Clock { rate: self.rate.to_f64(), slope: self.slope.to_f64() };
        let shown = clock.shown(time.to_f64(), bend.to_f64());
        let now = self.after(time, bend).rate;
        let later = S::of(last.to_f64() - first.to_f64() - shown) / now;
        // Where the clock hardly goes, no time would make up for it.
        if later.abs() <= time * S::of(ROUNDED) { time + later } else { time }
    }

    /// When it shows so much, about `guess` seconds from now; `None` if it stops before.
    #[inline(never)]
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

    /// Whether it goes evenly, to the last bit: a slope that is left would be a leap of the acceleration.
    pub fn is_even(self) -> bool {
        !(self.slope.abs() > S::ZERO)
    }

    /// The same but for a rounding, for steps of a duration, s.
    pub fn is_nearly_even(self, step: S) -> bool {
        (self.slope * step).abs() < S::of(EVEN)
    }

    /// By how much it goes faster than a rate.
    pub fn above(self, rate: S) -> Self {
        Self { rate: self.rate - rate, ..self }
    }

    /// The one bend, 1/s2, that stops a clock which slows down, and how long that takes, s; `None` if it does not slow down.
    pub fn end(self) -> Option<(S, S)> {
        let Self { rate, slope } = self;
        let slows = rate > S::ZERO && slope < S::ZERO;
        slows.then(|| (slope * slope * S::of(0.5) / rate, -(rate + rate) / slope))
    }
}

/// What the axes do at an instant, by the motion's own time.
#[derive(Clone, Copy, Debug)]
pub struct Instant<S, const N: usize> {
    /// mm/s.
    pub velocity: [S; N],
    /// mm/s2.
    pub acceleration: [S; N],
    /// mm/s3.
    pub jerk: [S; N],
}

impl<S: Scalar, const N: usize> Instant<S, N> {
    /// `t` seconds after the start of a piece with these coefficients.
    #[inline(never)]
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
        // What a clock that goes evenly asks for may use all of a limit; and half of what it leaves is for a bend.
        let half = S::of(0.5);
        let most =
            |limit: S, even: S| (limit * share).greatest(limit.least((limit + even.abs()) * half));
        let Self { rate: r, slope: g } = self;
        let end = (r + g * time).greatest(S::ZERO);
        // By how much the rate at the end changes with the bend; its slope by `time`.
        let per_rate = time * time * S::of(0.5);
        let mut keep = |[from, to]: [[S; 3]; 2], axis: &AxisLimits<S>| {
            let [v, a, j] = from;
            let even = j * r * r * r;
            range.keep(even + three * a * g * r, v, most(axis.jerk, even));
            let [v, a, j] = to;
            let per_bend = three * (a * (end * time + g * per_rate) + j * end * end * per_rate);
            let even = j * end * end * end;
            range.keep(even + three * a * g * end, v + per_bend, most(axis.jerk, even));
            let per_bend = v * time + two * a * end * per_rate;
            let even = a * end * end;
            range.keep(even + v * g, per_bend, most(axis.acceleration, even));
        };
        for (i, axis) in limits.axes().iter().enumerate() {
            let at = |it: &Instant<S, N>| [it.velocity[i], it.acceleration[i], it.jerk[i]];
            keep([from, to].map(at), axis);
        }
        for motor in limits.motors() {
            let at = |it: &Instant<S, N>| {
                [&it.velocity, &it.acceleration, &it.jerk].map(|of| motor.of(of))
            };
            keep([from, to].map(at), &motor.limits);
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
    #[inline(never)]
    pub fn of(piece: &Piece<S, N>) -> Self {
        Self { time: piece.time, axes: piece.axes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const SLOWS: Clock<f64> = Clock { rate: 0.8, slope: -9.0 };
    const BEND: f64 = -400.0;
    const TIME: f64 = 4.0e-3;
    /// Coefficients of a motion, and when the step begins in it.
    const AXES: [[f64; 5]; 2] =
        [[80.0, -300.0, 4.0e3, 2.0e4, -1.0e5], [20.0, 500.0, -6.0e3, 5.0e4, 3.0e5]];
    const FIRST: f64 = 5.0e-3;

    #[test]
    fn bends_are_those_that_keep_the_limits() {
        let limits = Limits::new([AxisLimits::linear(200.0, 2.0e3, 5.0e4); 2]).unwrap();
        let from = Instant::of(&AXES, FIRST);
        let last = FIRST + SLOWS.shown(TIME, 0.0);
        let to = Instant::of(&AXES, last);
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
}
