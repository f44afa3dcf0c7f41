//! Random motors on a machine, and what they do of their limits between two setpoints.

#![allow(dead_code)] // Every test uses a part of it.

use splineway::{AxisLimits, Limits, Linear, MOTORS, Scalar, Setpoint};

/// The same machine, as often as not with motors that follow its axes: belts over two of them, or anything.
pub fn with_motors<S: Scalar, const N: usize>(
    limits: Limits<S, N>,
    mut share: impl FnMut() -> f64,
) -> Limits<S, N> {
    let kind = (share() * 6.0) as u32;
    let mut between = |least: f64, most: f64| least + (most - least) * share();
    match kind {
        0 | 1 => {
            let belts = [Linear::core_xy().factors()[0], Linear::core_xy().factors()[1]];
            bounded(limits, belts, &mut between)
        }
        2 => bounded(limits, random::<S, N, N>(&mut between), &mut between),
        3 => bounded(limits, random::<S, N, 4>(&mut between), &mut between),
        _ => limits,
    }
}

fn random<S: Scalar, const N: usize, const M: usize>(
    between: &mut dyn FnMut(f64, f64) -> f64,
) -> [[S; N]; M] {
    [(); M].map(|()| {
        [(); N].map(|()| if between(0.0, 1.0) < 0.3 { S::ZERO } else { S::of(between(-2.0, 2.0)) })
    })
}

/// Motors that get from a fifth of what the axes would ask of them to a little more than that, or all a little more: then only stops by
/// other limits ask too much. As they are, if they make no sense.
fn bounded<S: Scalar, const N: usize, const M: usize>(
    limits: Limits<S, N>,
    factors: [[S; N]; M],
    between: &mut dyn FnMut(f64, f64) -> f64,
) -> Limits<S, N> {
    let Ok(motors) = Linear::new(factors) else { return limits };
    let least = if between(0.0, 1.0) < 0.25 { 1.01 } else { 0.2 };
    let motor_limits = factors.map(|row| {
        let mut part = |of: fn(&AxisLimits<S>) -> S| {
            let sum: f64 =
                (0..N).map(|i| row[i].to_f64().abs() * of(&limits.axes()[i]).to_f64()).sum();
            S::of(sum * between(least, 1.1))
        };
        AxisLimits::linear(
            part(|axis| axis.velocity),
            part(|axis| axis.acceleration),
            part(|axis| axis.jerk),
        )
    });
    limits.with_motors(&motors, motor_limits).unwrap()
}

/// Limits of stops, as often as not with more for the motors too.
pub fn with_stops<S: Scalar, const N: usize>(
    stop: Limits<S, N>,
    limits: &Limits<S, N>,
    mut share: impl FnMut() -> f64,
) -> Limits<S, N> {
    let count = (0..MOTORS).take_while(|&motor| limits.motor(motor).is_some()).count();
    if share() < 0.5 {
        return stop;
    }
    match count {
        2 => stopping::<S, N, 2>(stop, limits, &mut share),
        3 => stopping::<S, N, 3>(stop, limits, &mut share),
        4 => stopping::<S, N, 4>(stop, limits, &mut share),
        _ => stop,
    }
}

fn stopping<S: Scalar, const N: usize, const M: usize>(
    stop: Limits<S, N>,
    limits: &Limits<S, N>,
    share: &mut dyn FnMut() -> f64,
) -> Limits<S, N> {
    let motors: [_; M] = std::array::from_fn(|motor| *limits.motor(motor).unwrap());
    let linear = Linear::new(motors.map(|motor| motor.factors)).unwrap();
    let more = motors.map(|motor| {
        let times = |x: S, by: f64, most: f64| S::of((x.to_f64() * by).min(most));
        AxisLimits {
            acceleration: times(motor.limits.acceleration, 0.5 + 4.0 * share(), 1.0e5),
            jerk: times(motor.limits.jerk, 0.5 + 8.0 * share(), 1.0e7),
            ..motor.limits
        }
    });
    stop.with_motors(&linear, more).unwrap()
}

/// Greatest shares of velocity, acceleration and jerk that a motor has used between two setpoints, and where it turned; `more`
/// are limits of acceleration and jerk that count too, and `rounding` is that of setpoints.
pub fn motor_shares<S: Scalar, const N: usize>(
    (limits, more): (&Limits<S, N>, &[&Limits<S, N>]),
    [from, to]: [&Setpoint<S, N>; 2],
    (cycle, rounding): (f64, f64),
) -> [f64; 3] {
    let mut most = [0.0f64; 3];
    for (motor, row) in (0..MOTORS).map_while(|motor| limits.motor(motor)).enumerate() {
        let sum = |of: &[S; N]| -> f64 {
            row.factors.iter().zip(of).map(|(k, x)| k.to_f64() * x.to_f64()).sum()
        };
        // What the axes' own rounding may come to.
        let slack = |of: fn(&AxisLimits<S>) -> S| -> f64 {
            let axes = row.factors.iter().zip(limits.axes());
            rounding * axes.map(|(k, axis)| k.to_f64().abs() * of(axis).to_f64()).sum::<f64>()
        };
        let most_of = |of: fn(&AxisLimits<S>) -> S| -> f64 {
            let others = more.iter().filter_map(|more| more.motor(motor));
            let all = others.map(|motor| of(&motor.limits).to_f64());
            all.fold(of(&row.limits).to_f64(), f64::max)
        };
        let [v0, v1] = [from, to].map(|at| sum(&at.velocity));
        let [a0, a1] = [from, to].map(|at| sum(&at.acceleration));
        let jerk = (a1 - a0) / cycle;
        let (v, a) = (slack(|axis| axis.velocity), slack(|axis| axis.acceleration));
        // Where the jerk changes within the cycle, setpoints do not say how fast it was in between.
        let steady = (v1 - v0 - 0.5 * (a0 + a1) * cycle).abs() < v;
        let turned = if a0 * a1 < 0.0 && steady { v0 - 0.5 * a0 * a0 / jerk } else { v1 };
        let seen = [
            v1.abs().max(turned.abs()) / (row.limits.velocity.to_f64() + v),
            a1.abs() / (most_of(|axis| axis.acceleration) + a),
            jerk.abs() / (most_of(|axis| axis.jerk) + 2.0 * a / cycle),
        ];
        for (most, seen) in most.iter_mut().zip(seen) {
            *most = most.max(seen);
        }
    }
    most
}
