//! Jogs for C.

use super::convert::{coords, jog_refusal};
use super::planner;
use super::types::{SPLINEWAY_AXES, splineway_core, splineway_result};
use crate::jog::Jog;

/// Asks the planner for a jog.
fn jog(
    storage: *mut splineway_core,
    jog: impl FnOnce() -> Option<Jog<f32, SPLINEWAY_AXES>>,
) -> splineway_result {
    let Some(planner) = planner(storage) else { return splineway_result::NOT_READY };
    let Some(jog) = jog() else { return splineway_result::COORDINATE };
    planner.jog(&jog).map_or_else(|error| jog_refusal(&error), |()| splineway_result::OK)
}

/// Jogs: every axis by itself comes to a velocity (mm/s) and keeps it for some seconds, unless it is asked for again, or up to
/// its limit of travel. From rest with nothing to run, or from a hold within a program; the next `splineway_poll` plans it.
/// `RUNNING` if a program runs.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_jog_velocity(
    core: *mut splineway_core,
    velocity: *const f32,
    seconds: f32,
) -> splineway_result {
    if velocity.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one number per axis to read.
    let velocity = core::array::from_fn(|axis| unsafe { velocity.add(axis).read() });
    jog(core, || Some(Jog::Velocity { velocity, time: seconds }))
}

/// Jogs by a distance per axis (nm), at a speed along the line (mm/s). Steps add up.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_jog_step(
    core: *mut splineway_core,
    by: *const i64,
    feed: f32,
) -> splineway_result {
    if by.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one number per axis to read.
    jog(core, || Some(Jog::Step { by: unsafe { coords(by) }?, feed }))
}

/// Jogs to a point (nm), from rest along the straight line, at a speed along it (mm/s).
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_jog_to(
    core: *mut splineway_core,
    to: *const i64,
    feed: f32,
) -> splineway_result {
    if to.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one number per axis to read.
    jog(core, || Some(Jog::To { to: unsafe { coords(to) }?, feed }))
}

/// Jogs back to where the program was held; from there `splineway_resume` goes on. `NO_PROGRAM` if none is held.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_jog_back(
    core: *mut splineway_core,
    feed: f32,
) -> splineway_result {
    jog(core, || Some(Jog::Back { feed }))
}
