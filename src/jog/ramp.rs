//! Ramps: from any speed and acceleration to another speed, where the acceleration is zero again.
//!
//! In real time the fastest is a trapezium of acceleration with jerk at its limit (three phases: to the peak, at the peak,
//! back to zero). On the grid of servo cycles the peak of a trapezium of given phases follows from the change of speed.

use crate::number::Scalar;

/// Limits of one axis, or along a line; mm and servo cycles.
#[derive(Clone, Copy, Debug)]
pub struct Caps<S> {
    pub velocity: S,
    pub acceleration: S,
    pub jerk: S,
}

/// What a motion within the limits may exceed them by, relative: the rounding of its arithmetic.
const ROUNDING: f64 = 1.0e-9;
/// Phases that exceed a whole number of cycles by less are not rounded up, for they are that number but for their rounding.
const WHOLE: f64 = 1.0e-3;
/// Shares of the jerk that durations are sought for, in this order: a motion at the very limits cannot be left for another on the
/// grid of servo cycles but by the one way it was planned.
pub const SHARES: [f64; 2] = [0.95, 1.0];
/// Velocities that differ by less, relative to the limit, are the same: what sums of them are rounded by.
const SAME: f64 = 1.0e-13;
/// Servo cycles by which a ramp on the grid may be longer than one in real time.
const LONGER: u32 = 6;
/// Servo cycles in the longest phase: more cannot be counted in an `f32`.
pub const MOST_CYCLES: u32 = 1 << 24;

impl Caps<f64> {
    /// Whether a jerk is allowed.
    pub fn allows_jerk(&self, jerk: f64) -> bool {
        jerk.abs() <= self.jerk * (1.0 + ROUNDING)
    }

    /// Whether an acceleration is allowed.
    pub fn allows_acceleration(&self, acceleration: f64) -> bool {
        acceleration.abs() <= self.acceleration * (1.0 + ROUNDING)
    }

    /// Whether a velocity is allowed.
    pub fn allows_velocity(&self, velocity: f64) -> bool {
        velocity.abs() <= self.velocity * (1.0 + ROUNDING)
    }

    /// What durations are sought for: in units of length in which the jerk is 1, so that numbers stay within an `f32`.
    pub fn sought<S: Scalar>(&self, unit: f64) -> Caps<S> {
        Caps {
            velocity: S::of(self.velocity / unit),
            acceleration: S::of(self.acceleration / unit),
            jerk: S::ONE,
        }
    }
}

/// Speed and acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<S> {
    pub velocity: S,
    pub acceleration: S,
}

/// Less than any motion, mm per cycle and per square cycle: a tenth of the unit of coordinates.
const STILL: f64 = 1.0e-13;

impl Motion<f64> {
    /// Standing still.
    pub const REST: Self = Self { velocity: 0.0, acceleration: 0.0 };

    /// Whether it stands still, but for the rounding of a speed that came to zero: by that no coordinate moves.
    pub fn is_rest(&self) -> bool {
        self.velocity.abs() < STILL && self.acceleration.abs() < STILL
    }

    /// What durations are sought from, in a unit of length.
    pub fn sought<S: Scalar>(&self, unit: f64) -> Motion<S> {
        Motion {
            velocity: S::of(self.velocity / unit),
            acceleration: S::of(self.acceleration / unit),
        }
    }
}

impl<S: Scalar> Motion<S> {
    /// The speed that is left when the acceleration is released at once.
    pub fn released(&self, jerk: S) -> S {
        self.velocity + self.acceleration * self.acceleration.abs() / (jerk + jerk)
    }
}

/// The fastest ramp in real time.
#[derive(Clone, Copy, Debug)]
pub struct Ramp<S> {
    /// Durations of its phases, servo cycles.
    pub times: [S; 3],
    /// What it covers, mm.
    pub distance: S,
}

impl<S: Scalar> Ramp<S> {
    /// From a motion to a speed.
    pub fn new(from: &Motion<S>, to: S, caps: &Caps<S>) -> Self {
        let up = to >= from.released(caps.jerk);
        let mirrored = |x: S| if up { x } else { -x };
        let (half, third) = (S::of(0.5), S::of(1.0 / 3.0));
        let (a, change) = (mirrored(from.acceleration), mirrored(to - from.velocity));
        let square = caps.jerk * change + a * a * half;
        let mut peak = square.greatest(S::ZERO).sqrt();
        let mut held = S::ZERO;
        if peak > caps.acceleration {
            peak = caps.acceleration;
            // Of the change of speed, what the two phases of jerk do not make.
            held = (square - peak * peak) / (caps.jerk * peak);
        }
        let (rise, fall) = ((peak - a).abs() / caps.jerk, peak / caps.jerk);
        let (v, p) = (from.velocity, mirrored(peak));
        let a = from.acceleration;
        let v1 = v + (a + p) * half * rise;
        let v2 = v1 + p * held;
        let distance = (v + (a + a + p) * rise * half * third) * rise
            + (v1 + p * held * half) * held
            + (v2 + p * third * fall) * fall;
        Self { times: [rise, held, fall], distance }
    }

    /// Servo cycles in all.
    pub fn time(&self) -> S {
        let [rise, held, fall] = self.times;
        rise + held + fall
    }
}

/// A number of servo cycles, rounded up.
pub fn rounded_up<S: Scalar>(time: S) -> u32 {
    let whole = (time - S::of(WHOLE)).to_i64();
    let up = if time - S::of(WHOLE) > S::from_i64(whole) { whole + 1 } else { whole };
    up.clamp(0, i64::from(MOST_CYCLES)) as u32
}

/// The phases of a ramp on the grid of servo cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Servo cycles in each.
    pub cycles: [u32; 3],
    /// Acceleration between the first and the last, mm per square cycle.
    pub peak: f64,
}

impl Steps {
    /// No change.
    pub const NONE: Self = Self { cycles: [0; 3], peak: 0.0 };

    /// The shortest from a motion to a speed that keeps the limits; `None` if there is none that is not much longer than
    /// one in real time.
    ///
    /// Cost: 28 trapezia at most, of some ten operations each.
    pub fn new<S: Scalar>(from: &Motion<f64>, to: f64, caps: &Caps<f64>) -> Option<Self> {
        let change = (to - from.velocity).abs();
        if from.acceleration == 0.0 && change <= caps.velocity * SAME {
            return Some(Self::NONE);
        }
        SHARES.iter().find_map(|share| {
            let unit = caps.jerk * share;
            let ramp = Ramp::new(&from.sought(unit), S::of(to / unit), &caps.sought(unit));
            Self::near(&ramp, from, to, caps)
        })
    }

    /// Near to a ramp in real time.
    fn near<S: Scalar>(
        ramp: &Ramp<S>,
        from: &Motion<f64>,
        to: f64,
        caps: &Caps<f64>,
    ) -> Option<Self> {
        let [rise, _, fall] = ramp.times.map(rounded_up);
        let least = rounded_up(ramp.time());
        for total in least..=least + LONGER {
            for (rise, fall) in [
                (rise, fall),
                (rise, fall.saturating_sub(1)),
                (rise.saturating_sub(1), fall),
                (rise + 1, fall),
            ] {
                let (rise, fall) = (rise.max(1), fall.max(1));
                let Some(held) = total.checked_sub(rise + fall) else { continue };
                let steps = Self::between(from, to, [rise, held, fall]);
                if steps.keeps(from, caps) {
                    return Some(steps);
                }
            }
        }
        None
    }

    /// Those of given phases, of which the first or the last is not empty.
    pub fn between(from: &Motion<f64>, to: f64, cycles: [u32; 3]) -> Self {
        let [rise, held, fall] = cycles.map(f64::from);
        let change = to - from.velocity - 0.5 * rise * from.acceleration;
        Self { cycles, peak: change / (0.5 * (rise + fall) + held) }
    }

    /// Whether they keep the limits, at and between servo cycles.
    pub fn keeps(&self, from: &Motion<f64>, caps: &Caps<f64>) -> bool {
        let [rise, _, fall] = self.cycles.map(f64::from);
        let (a, peak) = (from.acceleration, self.peak);
        let jerk = (peak - a) / rise.max(1.0);
        // Where the acceleration changes its sign the speed is greatest or least.
        let turned =
            if a * peak < 0.0 { from.velocity - 0.5 * a * a / jerk } else { from.velocity };
        caps.allows_jerk(jerk)
            && caps.allows_jerk(peak / fall.max(1.0))
            && caps.allows_acceleration(peak)
            && caps.allows_velocity(turned)
    }
}
