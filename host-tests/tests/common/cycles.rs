//! Random machines, and every limit between two setpoints of constant jerk.

#[path = "cases.rs"]
pub mod cases;
#[path = "motors.rs"]
mod motors;

#[allow(unused_imports)] // Not every test counts its own.
pub use cases::soak;
use motors::{motor_shares, with_motors, with_stops};
use splineway::{Activity, AxisLimits, Config, Coord, Limits, Scalar, Setpoint};

pub const AXES: usize = 3;
pub type Point = [Coord; AXES];

/// Random numbers of no great quality.
pub struct Draw(pub u64);

impl Draw {
    pub fn share(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }
    pub fn scale(&mut self, least: f64, most: f64) -> f64 {
        self.between(least.ln(), most.ln()).exp()
    }
    pub fn chance(&mut self, of: f64) -> bool {
        self.share() < of
    }
}

/// Relative rounding of setpoints.
pub fn rounding<S: Scalar>() -> f64 {
    if S::NAME == "f32" { 2.0e-4 } else { 1.0e-7 }
}

/// The motion between two setpoints: constant jerk.
#[derive(Clone, Copy, Debug)]
pub struct Between<S> {
    pub from: Setpoint<S, AXES>,
    pub to: Setpoint<S, AXES>,
    pub cycle: f64,
}

impl<S: Scalar> Between<S> {
    /// Position, mm from `from`, after a part of the cycle.
    pub fn offset(&self, axis: usize, part: f64) -> f64 {
        let t = part * self.cycle;
        let [v, a, b] = [self.from.velocity, self.from.acceleration, self.to.acceleration]
            .map(|of| of[axis].to_f64());
        let jerk = (b - a) / self.cycle;
        ((jerk * t / 3.0 + a) * t * 0.5 + v) * t
    }

    /// Every limit, at the end and within: those of stops too, where it may stop.
    pub fn check(&self, config: &Config<S, AXES>, stops: bool) {
        let h = self.cycle;
        let of_stops = config.stop_limits.filter(|_| stops).unwrap_or(config.limits);
        let e = rounding::<S>();
        let seen = motor_shares((&config.limits, &[&of_stops]), [&self.from, &self.to], (h, e));
        assert!(seen.iter().all(|seen| *seen < 1.0 + e), "a motor at {seen:?} of its limits");
        for (i, (axis, stop)) in config.limits.axes().iter().zip(of_stops.axes()).enumerate() {
            let [v0, v1] = [self.from.velocity[i], self.to.velocity[i]].map(S::to_f64);
            let [a0, a1] = [self.from.acceleration[i], self.to.acceleration[i]].map(S::to_f64);
            let [v, a, j] = [axis.velocity, axis.acceleration, axis.jerk].map(S::to_f64);
            let (a, j) = (a.max(stop.acceleration.to_f64()), j.max(stop.jerk.to_f64()));
            let jerk = (a1 - a0) / h;
            // On a path the jerk changes within a cycle.
            let on_path = [self.from, self.to].iter().any(|at| at.activity == Activity::Running);
            let turns = a0 * a1 < 0.0 && !on_path;
            let turned = if turns { v0 - 0.5 * a0 * a0 / jerk } else { v1 };
            assert!(v1.abs().max(turned.abs()) < v * (1.0 + e), "axis {i}: velocity {v1}");
            assert!(a1.abs() < a * (1.0 + e), "axis {i}: acceleration {a1} of {a}");
            assert!(jerk.abs() < (j + 2.0 * e * a / h) * (1.0 + e), "axis {i}: jerk {jerk} of {j}");
            if on_path {
                continue;
            }
            let step = (v1 - v0 - 0.5 * (a0 + a1) * h).abs();
            assert!(step < 10.0 * e * v, "axis {i}: velocity steps by {step}");
            let moved: f64 = self.to.position(i).minus(self.from.position(i));
            let off = (moved - self.offset(i, 1.0)).abs();
            // Where an axis waits for its share of a motor, what others do is cut off and taken up again in many cycles, and each time a
            // place is rounded to a unit: by no more than a motion may be off its end.
            let shared = if config.limits.motor(0).is_some() { 1.0e-9 } else { 0.0 };
            // A product and a sum are rounded for either place, to its distance from where its piece begins.
            let ulps = if S::NAME == "f32" { f64::from(f32::EPSILON) } else { f64::EPSILON };
            let far = self.from.offset[i].to_f64().abs() + self.to.offset[i].to_f64().abs();
            let most = off_most::<S>(v * h) + shared + ulps * far;
            assert!(off < most, "axis {i}: {off} mm beside its derivatives");
        }
    }
}

/// What a position may be off by rounding, mm: of a way that ends in it, and of the longest way in a cycle.
pub fn off_most<S: Scalar>(way: f64) -> f64 {
    // A piece of 8 mm in an `f32`.
    if S::NAME == "f32" { 1.0e-5 + 1.0e-6 * way } else { 2.0e-11 + 1.0e-12 * way }
}

pub fn machine<S: Scalar>(draw: &mut Draw) -> Config<S, AXES> {
    let axis = [(); AXES].map(|()| {
        let v = draw.scale(1.0, 1.0e3);
        let a = v * draw.scale(1.0, 100.0);
        AxisLimits::linear(S::of(v), S::of(a), S::of(a * draw.scale(2.0, 1000.0)))
    });
    let mut config = Config::new(with_motors(Limits::new(axis).unwrap(), || draw.share()));
    config.cycle = S::of(if draw.chance(0.5) { 1.0e-3 } else { 2.5e-4 });
    config.start_delay = S::ZERO;
    if draw.chance(0.5) {
        let stop = axis.map(|axis| AxisLimits {
            acceleration: axis.acceleration * S::of(draw.scale(0.5, 5.0)),
            jerk: axis.jerk * S::of(draw.scale(0.5, 10.0)),
            ..axis
        });
        let stop = Limits::new(stop).unwrap();
        config.stop_limits = Some(with_stops(stop, &config.limits, || draw.share()));
    }
    config
}

pub fn at(mm: f64) -> Coord {
    Coord::from_mm(mm).unwrap()
}
