//! Coming to rest along a straight: at most three phases of constant jerk.

use crate::number::Scalar;
use crate::profile::law::PathState;
use crate::profile::window::Station;

/// Shares of acceleration and jerk limits that a stop uses: where one ends too near to a node, the next does
/// not.
pub const SHARES: [f64; 8] = [0.97, 0.92, 0.85, 0.5, 0.2, 0.05, 0.01, 0.002];
/// So many of them brake as hard as can be; the others are for speeds so low that the stop of these is over
/// within some servo cycles.
pub const HARD: usize = 3;
/// Halvings of the time in a search for the state at a place.
const HALVINGS: u32 = 40;
/// Most phases.
pub const PHASES: usize = 3;

/// A stretch of constant jerk.
#[derive(Clone, Copy, Debug)]
struct JerkPhase<S> {
    speed: S,
    acceleration: S,
    jerk: S,
    time: S,
}

/// Where a phase has got.
#[derive(Clone, Copy, Debug)]
struct Reached<S> {
    length: S,
    speed: S,
    acceleration: S,
}

impl<S: Scalar> JerkPhase<S> {
    /// What is reached after `t` seconds.
    fn at(&self, t: S) -> Reached<S> {
        let half = S::of(0.5);
        let Self { speed: v, acceleration: a, jerk: j, .. } = *self;
        Reached {
            length: ((j * t * S::of(1.0 / 6.0) + a * half) * t + v) * t,
            speed: (j * t * half + a) * t + v,
            acceleration: j * t + a,
        }
    }

    fn length(&self) -> S {
        self.at(self.time).length
    }
}

/// How hard a stop may brake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// As hard as the limits of a straight allow.
    Limits,
    /// No harder than the motion brakes already.
    Steady,
}

/// Both, the harder first.
pub const DEPTHS: [Depth; 2] = [Depth::Limits, Depth::Steady];

/// Acceleration down to a depth, held, and back to zero together with the speed.
#[derive(Clone, Copy, Debug)]
pub struct StopProfile<S> {
    phases: [JerkPhase<S>; PHASES],
    /// Where the rest is, from the branch, mm.
    pub at: S,
}

impl<S: Scalar> StopProfile<S> {
    /// The stop from a station that is `distance` mm from the branch, if there is one.
    pub fn new<const N: usize>(
        station: &Station<S, N>,
        distance: S,
        depth: Depth,
        share: S,
    ) -> Option<Self> {
        let PathState { b, a } = station.state;
        if !(b > S::ZERO && station.cell.length > S::ZERO) {
            return None;
        }
        let (speed, half) = (b.sqrt(), S::of(0.5));
        let jerk = station.bounds.jerk * share;
        // Where the depth p must give way to its release: v + a^2 / 2 J - p^2 / 2 J = p^2 / 2 J.
        let free = jerk * speed + a * a * half;
        let deepest = match depth {
            Depth::Limits => (station.bounds.acceleration * share).greatest(-a),
            Depth::Steady => -a,
        };
        let p = deepest.least(free.sqrt());
        if !(p > S::ZERO && p + a >= S::ZERO) {
            return None;
        }
        let fall = JerkPhase { speed, acceleration: a, jerk: -jerk, time: (a + p) / jerk };
        let v1 = fall.at(fall.time).speed;
        let v2 = p * p * half / jerk;
        let hold = JerkPhase {
            speed: v1,
            acceleration: -p,
            jerk: S::ZERO,
            time: ((v1 - v2) / p).greatest(S::ZERO),
        };
        // To rest exactly, whatever the rounding: j = p^2 / 2 v over 2 v / p.
        let v2 = hold.at(hold.time).speed;
        let release =
            JerkPhase { speed: v2, acceleration: -p, jerk: p * p * half / v2, time: (v2 + v2) / p };
        let phases = [fall, hold, release];
        let length = phases.iter().fold(S::ZERO, |sum, phase| sum + phase.length());
        length.is_finite().then_some(Self { phases, at: distance + length })
    }

    /// Length, mm.
    pub fn length(&self) -> S {
        self.phases.iter().fold(S::ZERO, |sum, phase| sum + phase.length())
    }

    /// Duration, s.
    pub fn time(&self) -> S {
        self.phases.iter().fold(S::ZERO, |sum, phase| sum + phase.time)
    }

    /// Where its jerk changes, mm from its beginning; not within `least` seconds of each other or of its ends.
    pub fn changes(&self, least: S) -> impl Iterator<Item = S> + use<S> {
        let total = self.time();
        let (mut distance, mut time, mut last) = (S::ZERO, S::ZERO, S::ZERO);
        self.phases.into_iter().take(PHASES - 1).filter_map(move |phase| {
            distance += phase.length();
            time += phase.time;
            let lasts = time - last >= least && total - time >= least;
            if lasts {
                last = time;
            }
            lasts.then_some(distance)
        })
    }

    /// Speed and acceleration `distance` mm after its beginning.
    pub fn state(&self, mut distance: S) -> PathState<S> {
        for phase in &self.phases {
            let length = phase.length();
            if distance > length {
                distance = distance - length;
                continue;
            }
            let (mut low, mut high) = (S::ZERO, phase.time);
            for _ in 0..HALVINGS {
                let middle = (low + high) * S::of(0.5);
                if phase.at(middle).length < distance {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let Reached { speed, acceleration, .. } = phase.at(high);
            return PathState { b: speed * speed, a: acceleration };
        }
        PathState::REST
    }
}
