//! From any speed and acceleration to a place, at rest there: a ramp to some speed, a while at that speed, a ramp to zero.
//!
//! In real time the distance covered is a continuous function of the speed between, which is found by bisection. Its durations,
//! rounded up to servo cycles, are kept, and the distance is then an affine function of the speed: the equation is linear, and
//! its solution exact.

use super::ramp::{Caps, MOST_CYCLES, Motion, Ramp, SHARES, Steps, rounded_up};
use crate::number::Scalar;

/// Halvings of the range of speeds: to the rounding of an `f32`.
const HALVINGS: usize = 24;

/// The seven phases from a motion to a rest at a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The ramp to the speed between.
    pub first: Steps,
    /// Servo cycles at that speed.
    pub cruise: u32,
    /// The ramp to zero.
    pub last: Steps,
}

/// Durations of the seven phases, servo cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    pub first: [u32; 3],
    pub cruise: u32,
    pub last: [u32; 3],
    /// The speed between, mm per cycle.
    pub speed: f64,
}

/// By how much the first and the last phase of the first ramp are longer than in real time, rounded up: tried in this order.
const FIRST: [[i64; 3]; 12] = [
    [0, 0, 0],
    [0, 0, -1],
    [-1, 0, 0],
    [1, 0, 0],
    [0, 0, 1],
    [1, 0, 1],
    [0, -1, 0],
    [0, 1, 0],
    [1, -1, 0],
    [-1, 1, 0],
    [2, 0, 2],
    [3, 0, 3],
];
/// The same of the first and the last phase of the last ramp.
const LAST: [i64; 3] = [0, 1, 3];

impl Times {
    /// The fastest in real time, rounded up, from a motion to a rest at `distance`, with a speed between of `most` at most.
    ///
    /// Cost: 56 ramps at most, each with one square root and four divisions.
    pub fn new<S: Scalar>(
        from: &Motion<f64>,
        distance: f64,
        most: f64,
        caps: &Caps<f64>,
        share: f64,
    ) -> Self {
        let unit = caps.jerk * share;
        let (most, mut distance) = (S::of(most / unit), S::of(distance / unit));
        let (caps, mut from) = (caps.sought::<S>(unit), from.sought::<S>(unit));
        let ends = |from: &Motion<S>, speed: S| {
            let first = Ramp::new(from, speed, &caps);
            let rest = Motion { velocity: speed, acceleration: S::ZERO };
            (first, Ramp::new(&rest, S::ZERO, &caps))
        };
        let covered = |from: &Motion<S>, speed: S| {
            let (first, last) = ends(from, speed);
            first.distance + last.distance
        };
        let backwards = distance < covered(&from, S::ZERO);
        if backwards {
            distance = -distance;
            from = Motion { velocity: -from.velocity, acceleration: -from.acceleration };
        }
        let mut speed = most;
        if covered(&from, speed) > distance {
            let (mut least, mut most) = (S::ZERO, speed);
            let released = from.released(caps.jerk);
            if released > least && released < most && covered(&from, released) <= distance {
                least = released;
            }
            for _ in 0..HALVINGS {
                let middle = (least + most) * S::of(0.5);
                if covered(&from, middle) <= distance {
                    least = middle;
                } else {
                    most = middle;
                }
            }
            speed = most;
        }
        let (first, last) = ends(&from, speed);
        let left = (distance - first.distance - last.distance).greatest(S::ZERO);
        let ramp = |ramp: Ramp<S>| {
            let [rise, held, fall] = ramp.times.map(rounded_up);
            [rise.max(1), held, fall.max(1)]
        };
        let cruise = if left > S::ZERO { rounded_up(left / speed) } else { 0 };
        let speed = if backwards { -speed } else { speed }.to_f64() * unit;
        Self { first: ramp(first), cruise, last: ramp(last), speed }
    }

    /// Servo cycles in all.
    pub fn total(&self) -> u32 {
        let sum = |cycles: [u32; 3]| cycles.iter().fold(0, |sum: u32, n| sum.saturating_add(*n));
        sum(self.first).saturating_add(self.cruise).saturating_add(sum(self.last))
    }

    /// With some phases longer or shorter.
    fn changed(&self, first: &[i64; 3], last: i64) -> Self {
        let more = |cycles: u32, by: i64, least: i64| (i64::from(cycles) + by).max(least) as u32;
        let [f1, f2, f3] = self.first;
        let [l1, l2, l3] = self.last;
        Self {
            first: [more(f1, first[0], 1), more(f2, first[1], 0), more(f3, first[2], 1)],
            last: [more(l1, last, 1), l2, more(l3, last, 1)],
            ..*self
        }
    }
}

/// Distance that a unit of peak acceleration adds in phases of such durations.
fn by_peak([rise, held, fall]: [f64; 3]) -> f64 {
    rise * rise / 6.0
        + 0.5 * rise * (held + fall)
        + 0.5 * held * held
        + held * fall
        + fall * fall / 3.0
}

impl Reach {
    /// The distance covered in phases of such durations, which is affine in the speed between: at a speed of zero, and by unit.
    fn affine(from: &Motion<f64>, times: &Times) -> (f64, f64) {
        let [rise, held, fall] = times.first.map(f64::from);
        let (v, a) = (from.velocity, from.acceleration);
        let weight = 0.5 * (rise + fall) + held;
        let share = by_peak([rise, held, fall]) / weight;
        let fixed = v * (rise + held + fall) + a * rise * (rise / 3.0 + 0.5 * (held + fall))
            - share * (v + 0.5 * rise * a);
        let [braking, low, release] = times.last.map(f64::from);
        let last = 0.5 * (braking + release) + low;
        let per_speed = share + f64::from(times.cruise) + braking + low + release
            - by_peak([braking, low, release]) / last;
        (fixed, per_speed)
    }

    /// From a motion to a rest at `distance` with phases of such durations.
    pub fn at(from: &Motion<f64>, distance: f64, times: &Times) -> Self {
        let (fixed, per_speed) = Self::affine(from, times);
        let speed = (distance - fixed) / per_speed;
        let between = Motion { velocity: speed, acceleration: 0.0 };
        Self {
            first: Steps::between(from, speed, times.first),
            cruise: times.cruise,
            last: Steps::between(&between, 0.0, times.last),
        }
    }

    /// Durations of its phases.
    pub fn times(&self) -> Times {
        let Self { first, cruise, last } = self;
        Times { first: first.cycles, cruise: *cruise, last: last.cycles, speed: self.speed() }
    }

    /// The speed between.
    pub fn speed(&self) -> f64 {
        let [braking, low, release] = self.last.cycles.map(f64::from);
        -self.last.peak * (0.5 * (braking + release) + low)
    }

    /// Whether it keeps the limits, at and between servo cycles.
    pub fn keeps(&self, from: &Motion<f64>, most: f64, caps: &Caps<f64>) -> bool {
        let between = Motion { velocity: self.speed(), acceleration: 0.0 };
        self.first.keeps(from, caps)
            && Caps { velocity: most, ..*caps }.allows_velocity(between.velocity)
            && self.last.keeps(&between, caps)
    }

    /// The shortest that keeps the limits; `None` if there is none that is not much longer than one in real time: from rest
    /// there always is one.
    ///
    /// Cost: that of [`Times::new`], and 16 solutions of some sixty operations at most.
    pub fn new<S: Scalar>(
        from: &Motion<f64>,
        distance: f64,
        most: f64,
        caps: &Caps<f64>,
    ) -> Option<Self> {
        SHARES.iter().find_map(|share| {
            Times::new::<S>(from, distance, most, caps, *share).reach(from, distance, most, caps)
        })
    }
}

impl Times {
    /// On the grid, about such durations.
    fn reach(
        &self,
        from: &Motion<f64>,
        distance: f64,
        most: f64,
        caps: &Caps<f64>,
    ) -> Option<Reach> {
        let times = self;
        let longest = times.total().saturating_add(times.total() / 8 + 8).min(MOST_CYCLES);
        for last in LAST {
            for first in &FIRST {
                let mut times = times.changed(first, last);
                // At the speed between that is best in real time, the cruise that is left for.
                let (fixed, per_speed) = Reach::affine(from, &Times { cruise: 0, ..times });
                let left = (distance - fixed) / times.speed - per_speed;
                // As a number of cycles it saturates.
                let cruise = (left as u32).min(longest);
                for cruise in [cruise + 1, cruise, 0] {
                    times.cruise = cruise;
                    let reach = Reach::at(from, distance, &times);
                    if times.total() <= longest && reach.keeps(from, most, caps) {
                        return Some(reach);
                    }
                }
            }
        }
        None
    }
}
