//! What each axis gets of what the motors give, while axes move by themselves (feature `kinematics`).
//!
//! Where every axis is planned by itself, nothing is known of when one is fast and another is not; so what they may do has to hold
//! in any combination. Of the axes that move, axis i gets the share
//!
//! ```text
//! s_i = min over its motors m of  L_m / sum over k of |K_mk| w_k
//! ```
//!
//! of what it wants, w_i: then the sum over i of |K_mi| s_i w_i is no more than the motor's limit L_m. It wants all of the
//! acceleration and jerk that it might have alone, and the speed that it is asked for or has. An axis that moves alone gets all
//! that its motors have; motions along one line are exact without any of this.

use super::axis::AxisMotion;
use super::plan::{axis_caps, caps, stop_limits};
use super::ramp::{Caps, Motion};
use crate::machine::{Config, Limits, Motor};
use crate::number::Scalar;
use core::array::from_fn;

/// Share of the jerk with which an acceleration is let go, on the grid of servo cycles.
const LET_GO: f64 = 0.9;
/// Share of its own speed that an axis wants at least.
const LEAST: f64 = 1.0e-12;

/// The speed that an axis cannot but reach.
pub fn bound_for(motion: &Motion<f64>, caps: &Caps<f64>) -> f64 {
    motion.velocity.abs().max(motion.released(caps.jerk * LET_GO).abs())
}

/// A motor in servo cycles.
struct Row<const N: usize> {
    factors: [f64; N],
    caps: Caps<f64>,
}

/// A motor's row.
fn row<S: Scalar, const N: usize>(motor: &Motor<S, N>, cycle: S) -> Row<N> {
    Row {
        factors: motor.factors.map(|factor| factor.to_f64().abs()),
        caps: caps(&motor.limits, cycle),
    }
}

impl<const N: usize> Row<N> {
    /// The most it does if the axes do so much.
    fn sum(&self, axes: &[Caps<f64>; N], of: fn(&Caps<f64>) -> f64) -> f64 {
        self.factors.iter().zip(axes).map(|(factor, axis)| factor * of(axis)).sum()
    }
}

/// What an axis wants that moves, or is to move.
#[derive(Clone, Copy, Debug)]
pub struct Want {
    /// mm per cycle.
    pub speed: f64,
    /// Whether it has been given that already, and keeps it.
    pub kept: bool,
}

/// Of each quantity, what one of axis `i` may be multiplied with so that no motor does too much, where speeds of axes that keep
/// theirs are not multiplied.
fn shares<S: Scalar, const N: usize>(
    (limits, cycle): (&Limits<S, N>, S),
    wants: &[Caps<f64>; N],
    kept: &[bool; N],
) -> [Caps<f64>; N] {
    let none = Caps { velocity: f64::MAX, acceleration: f64::MAX, jerk: f64::MAX };
    let mut shares = [none; N];
    for motor in limits.motors() {
        let row = row(motor, cycle);
        let per = |most: f64, sum: f64| most.max(0.0) / sum.max(f64::MIN_POSITIVE);
        let (mut given, mut free) = (0.0, 0.0);
        for ((factor, want), kept) in row.factors.iter().zip(wants).zip(kept) {
            *(if *kept { &mut given } else { &mut free }) += factor * want.velocity;
        }
        let part = Caps {
            velocity: per(row.caps.velocity - given, free),
            acceleration: per(row.caps.acceleration, row.sum(wants, |caps| caps.acceleration)),
            jerk: per(row.caps.jerk, row.sum(wants, |caps| caps.jerk)),
        };
        for (share, factor) in shares.iter_mut().zip(&row.factors) {
            if *factor > 0.0 {
                *share = least(share, &part);
            }
        }
    }
    for (share, kept) in shares.iter_mut().zip(kept) {
        if *kept {
            share.velocity = 1.0;
        }
    }
    shares
}

/// The lesser of each.
fn least(a: &Caps<f64>, b: &Caps<f64>) -> Caps<f64> {
    Caps {
        velocity: a.velocity.min(b.velocity),
        acceleration: a.acceleration.min(b.acceleration),
        jerk: a.jerk.min(b.jerk),
    }
}

/// One times the other; what is not bounded stays so.
fn times(a: &Caps<f64>, b: &Caps<f64>) -> Caps<f64> {
    Caps {
        velocity: a.velocity * b.velocity,
        acceleration: a.acceleration * b.acceleration,
        jerk: a.jerk * b.jerk,
    }
}

/// What each axis may do alone, mm and servo cycles.
pub fn alone<S: Scalar, const N: usize>(config: &Config<S, N>) -> [Caps<f64>; N] {
    let mut own = axis_caps(&config.limits, config.cycle);
    for motor in config.limits.motors() {
        let row = row(motor, config.cycle);
        for (own, factor) in own.iter_mut().zip(&row.factors) {
            if *factor > 0.0 {
                let per = |most: f64| most / factor;
                let Caps { velocity, acceleration, jerk } = row.caps;
                let motor = Caps {
                    velocity: per(velocity),
                    acceleration: per(acceleration),
                    jerk: per(jerk),
                };
                *own = least(own, &motor);
            }
        }
    }
    own
}

/// What each axis may do while those move that want something.
pub fn shared<S: Scalar, const N: usize>(
    wants: &[Option<Want>; N],
    config: &Config<S, N>,
) -> [Caps<f64>; N] {
    let own = alone(config);
    let nothing = Caps { velocity: 0.0, acceleration: 0.0, jerk: 0.0 };
    let kept = wants.map(|want| want.is_some_and(|want| want.kept));
    let wants = from_fn(|i| match wants[i] {
        None => nothing,
        Some(Want { speed, .. }) => {
            Caps { velocity: speed.min(own[i].velocity).max(own[i].velocity * LEAST), ..own[i] }
        }
    });
    let shares = shares((&config.limits, config.cycle), &wants, &kept);
    from_fn(|i| least(&own[i], &times(&wants[i], &shares[i])))
}

/// The same of an axis that stops by the limits of stops, whatever the others do by these or by those: acceleration and jerk of all in
/// proportion.
pub fn stopping<S: Scalar, const N: usize>(
    shared: &[Caps<f64>; N],
    config: &Config<S, N>,
) -> [Caps<f64>; N] {
    let limits = stop_limits(config);
    let most = axis_caps(&limits, config.cycle);
    let shares = shares((&limits, config.cycle), shared, &[false; N]);
    from_fn(|i| {
        let more = least(&most[i], &times(&shared[i], &shares[i]));
        Caps { velocity: shared[i].velocity, ..more }
    })
}

impl AxisMotion {
    /// Whether it keeps such limits all the way.
    pub fn stays(&self, caps: &Caps<f64>) -> bool {
        let most = self.peaks();
        caps.allows_velocity(most.velocity)
            && caps.allows_acceleration(most.acceleration)
            && caps.allows_jerk(most.jerk)
    }
}
