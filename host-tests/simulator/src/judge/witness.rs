//! Velocity, acceleration and jerk of every axis by two witnesses, and whether they tell the same story.
//!
//! 1. **Differences** of positions over strides of 1, 2, 4 ... servo cycles, as an outsider who sees only
//!    positions would. The difference over a stride is a mean of the derivative, so it never exceeds its
//!    peak; rounding is taken off it. At short cycles rounding drowns the short strides, and the longer
//!    ones see what lasts.
//! 2. **The setpoints' own** velocities and accelerations, which are derivatives of the very polynomials
//!    that positions are taken from; the mean jerk is a difference of the latter.
//! 3. **Their agreement**: over every stride, positions must go as far as velocities say, and velocities
//!    as accelerations say, to within what the trapezoidal rule leaves and rounding.
//!
//! # Rounding
//!
//! A piece of motion is a quintic from a fixed-point origin, evaluated by Horner's scheme at a time that
//! itself is rounded: 24 roundings at most (2 n + 1 of the scheme and its coefficients, n for each of two
//! of the time), each of half an [`Sample::unit`] of the sum S of the magnitudes of its terms. With |jerk| <= J
//! on the whole piece, a quadratic, its coefficients are at most J, 8 J, 8 J in units of the piece's
//! time (Chebyshev), so tau seconds into the piece, with speed v and acceleration a there,
//! S <= v tau + 1.5 a tau^2 + 1.7 J tau^3 for the position, v + 2 a tau + 3.5 J tau^2 for the velocity,
//! a + 9 J tau for the acceleration. The coefficients of a polynomial of degree 5, 4, 3 that is at most M
//! sum to 3363, 577, 99 M at most (Chebyshev again): the lesser bound counts. The origin is rounded to 1e-12 mm.
//! What is left of the piece before counts too, since the time carries over. What a motor does is a sum of what the axes do,
//! and so is its rounding.

use crate::machine::{Axis, MotorRow};
use crate::run::Sample;
use splineway::Activity;

/// The longest stride is the first power of two that spans this time, s: phases of jerk that last
/// shorter are left to the second witness where rounding is that large.
const LONGEST: f64 = 5.0e-3;
/// No stride is longer than this, cycles.
const MOST: usize = 8192;
/// Roundings of half a unit.
const ROUNDINGS: f64 = 12.0;
/// Fixed point: both ends of a piece, mm.
const FIXED: f64 = 1.0e-12;
/// Sums of the magnitudes of the coefficients of polynomials of degree 5, 4 and 3 within +-1 on 0..1.
const CHEBYSHEV: [f64; 3] = [3363.0, 577.0, 99.0];

/// Peaks of one axis, in mm and s, or as ratios to its limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Peaks {
    /// Velocity, mm/s.
    pub velocity: f64,
    /// Acceleration, mm/s2.
    pub acceleration: f64,
    /// Jerk, mm/s3.
    pub jerk: f64,
    /// Jerk by third differences over every fourth cycle, with rounding still in it.
    pub jerk4: f64,
}

impl Peaks {
    /// Over the limits of an axis.
    #[must_use]
    pub fn over(self, limit: &Axis) -> Self {
        Self {
            velocity: self.velocity / limit.velocity,
            acceleration: self.acceleration / limit.acceleration,
            jerk: self.jerk / limit.jerk,
            jerk4: self.jerk4 / limit.jerk,
        }
    }

    /// What is seen of a stop by its own limits, as it would be of a motion by the others.
    #[must_use]
    fn of_stop(self, limit: &Axis, stop: &Axis) -> Self {
        let (acceleration, jerk) = (limit.acceleration / stop.acceleration, limit.jerk / stop.jerk);
        Self {
            acceleration: self.acceleration * acceleration,
            jerk: self.jerk * jerk,
            jerk4: self.jerk4 * jerk,
            ..self
        }
    }

    /// The greater of each.
    #[must_use]
    pub fn greater(self, other: Self) -> Self {
        Self {
            velocity: self.velocity.max(other.velocity),
            acceleration: self.acceleration.max(other.acceleration),
            jerk: self.jerk.max(other.jerk),
            jerk4: self.jerk4.max(other.jerk4),
        }
    }
}

/// What an axis was at one cycle.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    position: f64,
    velocity: f64,
    acceleration: f64,
    /// Sums of velocities and accelerations by the trapezoidal rule.
    sums: [f64; 2],
    /// Bounds of rounding of position, velocity and acceleration.
    rounding: [f64; 3],
}

/// Greatest magnitudes in a piece: way from its start, velocity, acceleration.
#[derive(Clone, Copy, Debug, Default)]
struct Reach {
    from: f64,
    most: [f64; 3],
    time: f64,
}

impl Reach {
    fn see(&mut self, state: &State) {
        let [way, velocity, acceleration] = &mut self.most;
        *way = way.max((state.position - self.from).abs());
        *velocity = velocity.max(state.velocity.abs());
        *acceleration = acceleration.max(state.acceleration.abs());
    }
}

/// One axis.
#[derive(Clone, Debug)]
struct Record {
    ring: Vec<State>,
    pieces: [Reach; 2],
    differences: Peaks,
    reported: Peaks,
    mismatch: f64,
}

/// Watches the axes of a run.
#[derive(Clone, Debug)]
pub struct Witness {
    /// Motors, which are watched like axes behind these.
    motors: Vec<MotorRow>,
    /// Limits of the axes, and of the motors.
    limits: Vec<Axis>,
    /// Those of stops by the stop limits.
    stops: Vec<Axis>,
    /// Servo cycles since the last one in which such a stop was under way.
    since_stop: usize,
    cycle: f64,
    longest: usize,
    mask: usize,
    head: usize,
    axes: Vec<Record>,
}

impl Witness {
    /// Of axes with these limits at a servo cycle, s.
    pub fn new(limits: &[Axis], cycle: f64) -> Self {
        let mut longest = 4;
        while (longest as f64) * cycle < LONGEST && longest < MOST {
            longest *= 2;
        }
        let size = (3 * longest + 1).next_power_of_two();
        let (limits, stops) = (limits.to_vec(), limits.to_vec());
        Self {
            motors: Vec::new(),
            limits,
            stops,
            since_stop: usize::MAX,
            cycle,
            longest,
            mask: size - 1,
            head: 0,
            axes: Vec::new(),
        }
    }

    /// The limits of stops by the stop limits. What is seen of these is scaled to the others.
    #[must_use]
    pub fn stopping(mut self, stops: &[Axis]) -> Self {
        self.stops = stops.to_vec();
        self
    }

    /// Watches motors too; to be said last.
    #[must_use]
    pub fn driven_by(mut self, motors: &[MotorRow]) -> Self {
        self.motors = motors.to_vec();
        self.limits.extend(motors.iter().map(|motor| motor.limits));
        self.stops.extend(motors.iter().map(|motor| motor.stop));
        self
    }

    /// By differences: mm and s, less what rounding may amount to.
    pub fn differences(&self) -> Vec<Peaks> {
        self.limits
            .iter()
            .enumerate()
            .map(|(n, _)| self.axes.get(n).map_or(Peaks::default(), |axis| axis.differences))
            .collect()
    }

    /// By the setpoints' velocities and accelerations, less what rounding may amount to in the jerk.
    pub fn reported(&self) -> Vec<Peaks> {
        self.axes.iter().map(|axis| axis.reported).collect()
    }

    /// Greatest disagreement of the two over what may be: at most 1 if setpoints are consistent.
    pub fn mismatch(&self) -> f64 {
        self.axes.iter().map(|axis| axis.mismatch).fold(0.0, f64::max)
    }

    /// One servo cycle.
    pub fn see(&mut self, sample: &Sample<'_>) {
        let first = self.axes.is_empty();
        self.head = self.head.wrapping_add(1) & self.mask;
        self.since_stop = if sample.pace.quick { 0 } else { self.since_stop.saturating_add(1) };
        let count = self.limits.len() - self.motors.len();
        let mut rounded: Vec<[f64; 3]> = Vec::with_capacity(count);
        for (n, (limit, stop)) in self.limits.iter().zip(&self.stops).enumerate() {
            let motor = n.checked_sub(count).map(|motor| &self.motors[motor]);
            let of = |all: &[f64]| motor.map_or_else(|| all[n], |motor| motor.of(all));
            let mut now = State {
                position: of(sample.position),
                velocity: of(sample.velocity),
                acceleration: of(sample.acceleration),
                ..State::default()
            };
            if first {
                let sum = |motor: &MotorRow| motor.factors.iter().map(|k| k.abs()).sum::<f64>();
                now.rounding = [FIXED * motor.map_or(1.0, sum), 0.0, 0.0];
                let from = Reach { from: now.position, ..Reach::default() };
                self.axes.push(Record {
                    ring: vec![now; self.mask + 1],
                    pieces: [from; 2],
                    differences: Peaks::default(),
                    reported: Peaks::default(),
                    mismatch: 0.0,
                });
                continue;
            }
            let axis = &mut self.axes[n];
            let before = axis.ring[self.head.wrapping_sub(1) & self.mask];
            if sample.began {
                axis.pieces = [Reach { from: before.position, ..Reach::default() }, axis.pieces[0]];
                axis.pieces[0].see(&before);
            }
            if matches!(sample.activity, Activity::Running | Activity::Jogging) {
                axis.pieces[0].time += self.cycle;
            } else {
                // At rest nothing is carried over.
                axis.pieces = [Reach { from: now.position, ..Reach::default() }; 2];
            }
            axis.pieces[0].see(&now);
            // As long as the longest stride and the piece under way may reach back.
            let recent = self.since_stop <= 4 * self.longest;
            let jerk = if recent { stop.jerk } else { limit.jerk };
            now.rounding = match motor {
                None => rounding(&axis.pieces, &now, jerk, sample),
                Some(motor) => [0, 1, 2].map(|k| {
                    let parts = motor.factors.iter().zip(&rounded);
                    // The sum is rounded once more, in the host's numbers.
                    let own = if k == 0 { 4.0 * f64::EPSILON * now.position.abs() } else { 0.0 };
                    parts.map(|(factor, axis)| factor.abs() * axis[k]).sum::<f64>() + own
                }),
            };
            rounded.push(now.rounding);
            let h = self.cycle;
            now.sums = [
                before.sums[0] + (before.velocity + now.velocity) * h / 2.0,
                before.sums[1] + (before.acceleration + now.acceleration) * h / 2.0,
            ];
            axis.ring[self.head] = now;
            let mut stride = 1;
            while stride <= self.longest {
                let back = |k: usize| &axis.ring[self.head.wrapping_sub(k * stride) & self.mask];
                let share = |seen: Peaks, back: usize| {
                    let stops = self.since_stop <= back * stride;
                    if stops { seen.of_stop(limit, stop) } else { seen }
                };
                let seen = differences([back(0), back(1), back(2), back(3)], stride as f64 * h);
                let seen = (share(seen.0, 3), share(Peaks { jerk4: seen.1, ..seen.0 }, 3).jerk4);
                axis.differences = axis.differences.greater(seen.0);
                if stride == 4 {
                    axis.differences.jerk4 = axis.differences.jerk4.max(seen.1);
                }
                let said = share(reported(back(0), back(1), stride as f64 * h), 1);
                axis.reported = axis.reported.greater(said);
                let off = mismatch(back(0), back(1), stride as f64, h, jerk);
                axis.mismatch = axis.mismatch.max(off);
                stride *= 2;
            }
        }
    }
}

/// Bounds of rounding of an axis's position, velocity and acceleration: see the module.
fn rounding(pieces: &[Reach; 2], now: &State, j: f64, sample: &Sample<'_>) -> [f64; 3] {
    // Adding origin and offset rounds once more, in the host's numbers.
    let fixed = FIXED + 2.0 * f64::EPSILON * now.position.abs();
    let tau = pieces[0].time + pieces[1].time;
    let (v, a) = (now.velocity.abs(), now.acceleration.abs());
    let by_jerk = [
        v * tau + 1.5 * a * tau * tau + 1.7 * j * tau * tau * tau,
        v + 2.0 * a * tau + 3.5 * j * tau * tau,
        a + 9.0 * j * tau,
    ];
    let bound = |k: usize| {
        let most = pieces[0].most[k].max(pieces[1].most[k]);
        ROUNDINGS * sample.unit * by_jerk[k].min(CHEBYSHEV[k] * most)
    };
    [fixed + bound(0), bound(1), bound(2)]
}

/// Velocity, acceleration and jerk by differences over steps of `h` seconds, less rounding; and the last
/// with it.
fn differences([s0, s1, s2, s3]: [&State; 4], h: f64) -> (Peaks, f64) {
    let [x0, x1, x2, x3] = [s0, s1, s2, s3].map(|state| state.position);
    let [e0, e1, e2, e3] = [s0, s1, s2, s3].map(|state| state.rounding[0]);
    let third = (x0 - 3.0 * x1 + 3.0 * x2 - x3).abs();
    let (square, cube) = (h * h, h * h * h);
    let seen = Peaks {
        velocity: ((x0 - x1).abs() - e0 - e1) / h,
        acceleration: ((x0 - 2.0 * x1 + x2).abs() - e0 - 2.0 * e1 - e2) / square,
        jerk: (third - e0 - 3.0 * e1 - 3.0 * e2 - e3) / cube,
        jerk4: 0.0,
    };
    (seen, third / cube)
}

/// The same by what setpoints say.
fn reported(now: &State, before: &State, h: f64) -> Peaks {
    let gain = (now.acceleration - before.acceleration).abs();
    Peaks {
        velocity: now.velocity.abs() - now.rounding[1],
        acceleration: now.acceleration.abs() - now.rounding[2],
        jerk: (gain - now.rounding[2] - before.rounding[2]) / h,
        jerk4: 0.0,
    }
}

/// Disagreement over a stride of `count` cycles of `h` seconds, over what may be.
///
/// The trapezoidal rule errs by J h^3 / 12 per cycle for the position and J h^2 / 4 for the velocity, whose
/// second and first derivatives are jerks of at most J, with leaps.
fn mismatch(now: &State, before: &State, count: f64, h: f64, jerk: f64) -> f64 {
    let way = (now.position - before.position) - (now.sums[0] - before.sums[0]);
    let gain = (now.velocity - before.velocity) - (now.sums[1] - before.sums[1]);
    let ends = |k: usize| now.rounding[k] + before.rounding[k];
    // Sums of many terms round too.
    let lost = f64::EPSILON * count;
    let may_way = count * jerk * h * h * h / 12.0
        + ends(0)
        + count * h * ends(1)
        + lost * now.sums[0].abs().max(1.0);
    let may_gain = count * jerk * h * h / 4.0
        + ends(1)
        + count * h * ends(2)
        + lost * now.sums[1].abs().max(1.0);
    (way.abs() / may_way).max(gain.abs() / may_gain)
}
