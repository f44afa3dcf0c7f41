//! What the machine can do, and how often it is told: the same for every board of this folder. To drive another
//! machine, change this file.

use splineway::output::{EdgeTimes, Scale, StepDir, StepError, StepTiming};
use splineway::{AxisLimits, AxisTravel, Config, Coord, Limits, Scalar, Travel};

/// Axes.
pub const AXES: usize = 3;
/// Rate of the step timer, Hz.
pub const STEP_HZ: u32 = 100_000;
/// Servo cycles per second, 1000 to 10,000.
pub const SERVO_HZ: u32 = 1_000;
/// Ticks of the step timer per servo cycle.
pub const TICKS: u32 = STEP_HZ / SERVO_HZ;
/// Bits per second on the serial line.
pub const BAUD: u32 = 921_600;
/// Time without a sign of life from the background after which the chip is reset, ms. A planning step
/// may take a tenth of a second.
pub const WATCHDOG_MS: u32 = 1_000;
/// Steps per nanometres: 400 steps/mm.
pub const SCALE: (u32, u32) = (400, 1_000_000);
/// Pulse, pause, set-up and hold, ns: common drives ask for 2500, 2500, 5000 and 5000 at most.
pub const DRIVE: EdgeTimes = EdgeTimes { pulse: 2_500, pause: 2_500, setup: 5_000, hold: 5_000 };
/// Velocity of every axis, mm/s. Steps are made for it, and a sender of grbl may set less (`$110`), not more.
pub const VELOCITY: f32 = 100.0;
/// Acceleration, mm/s2.
pub const ACCELERATION: f32 = 1_000.0;
/// Jerk, mm/s3.
pub const JERK: f32 = 20_000.0;
/// How far the axes may go from where they stand when the board is switched on: there is no homing. `Some` of a
/// coordinate is a limit.
pub const TRAVEL: [AxisTravel; AXES] = [AxisTravel { least: None, greatest: None }; AXES];

const _: () = assert!(SERVO_HZ >= 1_000 && SERVO_HZ <= 10_000 && STEP_HZ.is_multiple_of(SERVO_HZ));

/// What the core is told of the machine. `None`: it cannot be used.
pub fn config<S: Scalar>() -> Option<Config<S, AXES>> {
    let [velocity, acceleration, jerk] =
        [VELOCITY, ACCELERATION, JERK].map(|limit| S::of(f64::from(limit)));
    let axis = AxisLimits::linear(velocity, acceleration, jerk);
    let mut config = Config::new(Limits::new([axis; AXES]).ok()?);
    config.travel = Travel::new(TRAVEL).ok()?;
    config.cycle = S::ONE / S::from_u32(SERVO_HZ);
    // More than the default: with 10 ms five plans in 40,000 short lines came late on a clock of 168 MHz, with this none.
    config.lead = S::of(0.05);
    Some(config)
}

/// Blocks of look-ahead: of the shortest lines that files have, as many as a machine runs while a sender is silent for a fifth
/// of a second. (Most senders have six short lines under way, and wait for answers to them.) In `f64` fewer, for they must fit into
/// 128 kB.
pub const fn blocks<S: Scalar>() -> usize {
    if size_of::<S>() > 4 { 32 } else { 128 }
}

/// Steps per mm.
pub const fn steps_per_mm() -> f32 {
    SCALE.0 as f32 * 1.0e6 / SCALE.1 as f32
}

/// Steps of an axis per servo cycle at its greatest velocity, rounded up, and one for the rounding of the setpoints.
pub const fn most_steps() -> u32 {
    (VELOCITY * steps_per_mm() / SERVO_HZ as f32) as u32 + 2
}

/// An axis on these pins, which stands at zero.
///
/// # Errors
/// The timing does not allow its velocity: a faster step timer, or fewer steps per mm.
pub fn stepper<E, STEP, DIR>(step: STEP, dir: DIR) -> Result<StepDir<STEP, DIR>, StepError<E>>
where
    STEP: embedded_hal::digital::OutputPin<Error = E>,
    DIR: embedded_hal::digital::OutputPin<Error = E>,
{
    let Ok(scale) = Scale::new(SCALE.0, SCALE.1) else { return Err(StepError::NoTime) };
    let timing = StepTiming::from_ns(STEP_HZ, 1_000_000 / SERVO_HZ, DRIVE);
    StepDir::new(step, dir, scale, timing, Coord::ZERO, most_steps())
}
