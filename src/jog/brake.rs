//! The shortest stop from a motion, with the whole of the jerk, in whole servo cycles.
//!
//! In every cycle the acceleration goes as far down as it can so that a rest can still be reached without going back: to bring an
//! acceleration of -m (in units of jerk and cycle) to zero takes the speed `L(m) = m/2 + sum (m - k), k = 1 ..= floor(m)` at
//! least. The speed is so the least possible at every cycle, and with it the distance. Over one in real time, which does not know
//! cycles, it is longer by a twentieth of what the machine covers in a cycle, where acceleration takes three cycles or more to
//! build up.

use super::ramp::{Caps, MOST_CYCLES, Motion};

/// To the limit, one cycle less, at the limit, the turn, back, the last cycle.
const PHASES: usize = 6;

/// What a speed may be missing by for a stop, relative: the rounding of a motion that is one already.
const ROUNDING: f64 = 1.0e-9;

/// A stop: servo cycles of constant jerk, and the acceleration at their ends, mm per square cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    phases: [(u32, f64); PHASES],
    count: usize,
}

/// The least speed from which an acceleration of -`m` comes to zero at rest, both in units of the jerk.
fn least_speed(m: f64) -> f64 {
    let whole = libm::floor(m);
    m * 0.5 + whole * m - whole * (whole + 1.0) * 0.5
}

/// In units of the jerk, forwards.
#[derive(Clone, Copy)]
struct State {
    v: f64,
    a: f64,
}

impl State {
    /// After some cycles at the whole jerk downwards.
    fn down(self, cycles: u32) -> Self {
        let n = f64::from(cycles);
        Self { v: self.v + n * self.a - 0.5 * n * n, a: self.a - n }
    }

    /// Whether a rest can be reached without going back.
    fn can_rest(self) -> bool {
        self.a >= 0.0 || self.v >= least_speed(-self.a)
    }
}

impl Brake {
    /// From a motion to rest; `None` if it would have to go back first.
    ///
    /// Cost: 24 comparisons of some ten operations at most, a square root.
    pub fn new(from: &Motion<f64>, caps: &Caps<f64>) -> Option<Self> {
        let sign = match from.velocity {
            v if v > 0.0 => 1.0,
            v if v < 0.0 => -1.0,
            _ => 1.0f64.copysign(from.acceleration),
        };
        let unit = sign * caps.jerk;
        let mut now = State { v: from.velocity / unit, a: from.acceleration / unit };
        let most = caps.acceleration / caps.jerk;
        let slack = now.v * ROUNDING;
        if !(State { v: now.v + slack, ..now }).can_rest() {
            return None;
        }
        let mut brake = Self { phases: [(0, 0.0); PHASES], count: 0 };
        if now.v == 0.0 && now.a == 0.0 {
            return Some(brake);
        }
        // As far down as can be: whether a number of cycles is too many depends on them monotonically.
        let (mut good, mut bad) = (0, ((now.a + most).max(0.0) as u32).min(MOST_CYCLES) + 1);
        while bad - good > 1 {
            let middle = good + (bad - good) / 2;
            if now.down(middle).can_rest() { good = middle } else { bad = middle }
        }
        now = now.down(good);
        brake.push(good, now.a * unit);
        // The limit of acceleration, as long as can be.
        let limited = State { v: now.v + 0.5 * (now.a - most), a: -most };
        if now.a - 1.0 < -most && limited.can_rest() {
            brake.push(1, -most * unit);
            let cycles = (((limited.v - least_speed(most)) / most) as u32).min(MOST_CYCLES);
            now = State { v: limited.v - f64::from(cycles) * most, ..limited };
            brake.push(cycles, -most * unit);
        }
        // One cycle to the acceleration from which the whole jerk leads to rest: from -m by whole cycles and a last one.
        let change = (now.v + 0.5 * now.a).max(0.0);
        let whole = libm::floor((libm::sqrt(8.0 * change + 1.0) - 1.0) * 0.5);
        let m = (change + 0.5 * whole * (whole + 1.0)) / (whole + 1.0);
        brake.push(1, -m * unit);
        let left = libm::floor(m);
        brake.push((left as u32).min(MOST_CYCLES), (left - m) * unit);
        brake.push(u32::from(m > left), 0.0);
        Some(brake)
    }

    fn push(&mut self, cycles: u32, until: f64) {
        if cycles > 0
            && let Some(phase) = self.phases.get_mut(self.count)
        {
            *phase = (cycles, until);
            self.count += 1;
        }
    }

    /// Servo cycles of its phases, and the acceleration at their ends, mm per square cycle.
    pub fn phases(&self) -> &[(u32, f64)] {
        self.phases.get(..self.count).unwrap_or(&[])
    }

    /// What it covers, mm.
    pub fn distance(&self, from: &Motion<f64>) -> f64 {
        let Motion { mut velocity, mut acceleration } = *from;
        self.phases().iter().fold(0.0, |sum, (cycles, until)| {
            let n = f64::from(*cycles);
            let covered = (velocity + (acceleration + acceleration + until) * n / 6.0) * n;
            velocity += 0.5 * (acceleration + until) * n;
            acceleration = *until;
            sum + covered
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::ramp::Ramp;
    use super::*;

    fn check(v: f64, a: f64, caps: &Caps<f64>) -> Option<(f64, u32)> {
        let from = Motion { velocity: v, acceleration: a };
        let brake = Brake::new(&from, caps)?;
        let (mut now, mut cycles) = (from, 0);
        for (n, until) in brake.phases() {
            let jerk = (until - now.acceleration) / f64::from(*n);
            assert!(caps.allows_jerk(jerk) && *n < MOST_CYCLES, "{v} {a} {caps:?} {brake:?}");
            assert!(until.abs() <= caps.acceleration.max(a.abs()) * (1.0 + 1.0e-9));
            now.velocity += 0.5 * (now.acceleration + until) * f64::from(*n);
            now.acceleration = *until;
            cycles += n;
        }
        let scale = v.abs() + a * a / caps.jerk;
        assert!(now.velocity.abs() <= 1.0e-9 * scale, "{v} {a} {caps:?} {brake:?} {now:?}");
        assert!(now.acceleration == 0.0);
        let covered = brake.distance(&from);
        assert!(covered * v >= 0.0, "{v} {a} {covered}");
        Some((covered, cycles))
    }

    /// Over all kinds of motions and limits: within the limits, at rest at its end, and not longer than the fastest in real time
    /// by more than a part of a cycle.
    #[test]
    fn it_is_the_shortest() {
        let mut seed = 7u64;
        let mut share = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut seen = [0; 2];
        for _ in 0..100_000 {
            let scale = |x: f64| libm::pow(10.0, 3.0 * x - 0.5);
            let jerk = libm::pow(10.0, 6.0 * share() - 5.0);
            let (acceleration, time) = (scale(share()) * jerk, scale(share()));
            let caps = Caps { velocity: f64::MAX, acceleration, jerk };
            let a = if share() < 0.5 { 0.0 } else { (share() - 0.5) * 2.0 * acceleration };
            let sign = if share() < 0.5 { 1.0 } else { -1.0 };
            let v = time * time * jerk * share() + 2.0 * (-a).max(0.0) * (1.0 - a / jerk);
            let Some((covered, cycles)) = check(sign * v, sign * a, &caps) else {
                panic!("no stop from {v} {a} {caps:?}")
            };
            let from = Motion { velocity: v, acceleration: a };
            let ideal: f64 = Ramp::new(&from, 0.0, &caps).distance;
            assert!(covered.abs() >= ideal * (1.0 - 1.0e-9), "{v} {a} {caps:?}");
            if a == 0.0 && acceleration > 3.0 * jerk {
                assert!(covered.abs() - ideal <= v);
                if cycles >= 8 {
                    assert!(covered.abs() < ideal * 1.02, "{v} {caps:?} {cycles}");
                    seen[0] += 1;
                }
            }
            seen[1] += 1;
        }
        assert!(seen.iter().all(|seen| *seen > 10_000), "{seen:?}");
    }

    /// Every cycle of a stop is one from which the rest of it is the shortest stop.
    #[test]
    fn it_can_be_asked_for_again() {
        let caps = Caps { velocity: f64::MAX, acceleration: 3.7, jerk: 1.0 };
        let from = Motion { velocity: 23.4, acceleration: 1.3 };
        let brake = Brake::new(&from, &caps).unwrap();
        let mut left = brake.distance(&from);
        let mut now = from;
        for (n, until) in brake.phases() {
            let covered = (now.velocity + (2.0 * now.acceleration + until) * f64::from(*n) / 6.0)
                * f64::from(*n);
            now.velocity += 0.5 * (now.acceleration + until) * f64::from(*n);
            now.acceleration = *until;
            left -= covered;
            if now.velocity > 1.0e-6 {
                let again = Brake::new(&now, &caps).unwrap();
                assert!((again.distance(&now) - left).abs() < 1.0e-6, "{left}");
            }
        }
    }

    #[test]
    fn what_cannot_stop_without_going_back_is_none() {
        let caps = Caps { velocity: f64::MAX, acceleration: 5.0, jerk: 1.0 };
        assert_eq!(Brake::new(&Motion { velocity: 1.0, acceleration: -5.0 }, &caps), None);
        assert_eq!(Brake::new(&Motion::REST, &caps).unwrap().phases(), []);
    }
}
