//! Motors that follow several axes, of a library with the feature `kinematics`.

use super::planner;
use super::types::{SPLINEWAY_AXES, splineway_core, splineway_result};
use crate::machine::{AxisLimits, MOTORS, Motor, fixed, times};

/// A motor that follows several axes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_motor {
    /// How far it goes for one of each axis: mm, or degrees, each.
    pub factors: [f32; SPLINEWAY_AXES],
    /// mm/s.
    pub velocity: f32,
    /// mm/s2.
    pub acceleration: f32,
    /// mm/s3.
    pub jerk: f32,
}

/// The motors of the machine, `count` of them, 8 at most, at rest with nothing to run: after `splineway_init`, as a rule. They keep their
/// limits from then on, and `splineway_set_limits` leaves them as they are. `RUNNING` if the machine is not at rest; `CONFIG`, and nothing
/// has changed, if a limit or a factor is out of its range, an axis could move with others without a motor, or
/// axes are shaped unlike each other.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_set_motors(
    core: *mut splineway_core,
    motors: *const splineway_motor,
    count: u32,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if motors.is_null() {
        return splineway_result::NULL;
    }
    let count = count as usize;
    if count == 0 || count > MOTORS {
        return splineway_result::CONFIG;
    }
    let none = AxisLimits::linear(0.0, 0.0, 0.0);
    let mut list = [Motor::new([0.0; SPLINEWAY_AXES], none); MOTORS];
    for (n, slot) in list.iter_mut().enumerate().take(count) {
        // SAFETY: the caller gives so many to read.
        let splineway_motor { factors, velocity, acceleration, jerk } =
            unsafe { motors.add(n).read() };
        *slot = Motor::new(factors, AxisLimits::linear(velocity, acceleration, jerk));
    }
    let list = list.get(..count).unwrap_or(&[]);
    let Ok(limits) = planner.limits().with_motor_list(list) else {
        return splineway_result::CONFIG;
    };
    if !planner.is_empty() {
        splineway_result::RUNNING
    } else if planner.set_limits_at_rest(limits) {
        splineway_result::OK
    } else {
        splineway_result::CONFIG
    }
}

/// Where `count` motors are with the axes at `axes` (one number per axis, nm): in `positions`, nm. From any context; the position of a
/// setpoint is what a drive is to be given.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_motor_positions(
    motors: *const splineway_motor,
    count: u32,
    axes: *const i64,
    positions: *mut i64,
) -> splineway_result {
    if motors.is_null() || axes.is_null() || positions.is_null() {
        return splineway_result::NULL;
    }
    for n in 0..count as usize {
        let mut sum = 0i64;
        for axis in 0..SPLINEWAY_AXES {
            // SAFETY: the caller gives so many motors, and a number per axis, to read.
            let (factor, at) = unsafe {
                (
                    (&raw const (*motors.add(n)).factors).cast::<f32>().add(axis).read(),
                    axes.add(axis).read(),
                )
            };
            sum = sum.saturating_add(times(fixed(factor), at));
        }
        // SAFETY: the caller gives room for so many.
        unsafe { positions.add(n).write(sum) };
    }
    splineway_result::OK
}
