//! Commands of an operator for C.

use super::controls;
use super::types::{splineway_core, splineway_result};
use crate::servo::Controls;

/// Passes an operator's command on.
fn command(core: *mut splineway_core, send: impl FnOnce(Controls<'static>)) -> splineway_result {
    let Some(controls) = controls(core) else { return splineway_result::NOT_READY };
    send(controls);
    splineway_result::OK
}

/// Ends a jog: every axis brakes as hard as its limits allow. From any context, as the commands of an operator.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_jog_cancel(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::cancel_jog)
}

/// Feed hold: brake as hard as the limits allow, and rest on the path.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_hold(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::hold)
}

/// The same by the limits for stops. If the motion brakes already, it goes on as it does.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_quick_hold(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::quick_hold)
}

/// Ends a hold or a stop; in single block mode, runs the next block.
/// It is meant for a rest or a pause from the tick on that shows it, polled or not; before that it is for the motion.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_resume(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::resume)
}

/// Finish the block under way, then rest until resumed. If the motion is too fast to rest at its end, the first block is finished at whose end it
/// can; where a corner is rounded, the end of a block is the middle of the rounding. Where no motion to such an end is found in time, the machine
/// brakes as for a hold, and goes on from rest to the end of that block.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_stop(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::stop)
}

/// Brake, and drop everything that has not been run. No block is taken until `splineway_acknowledge_abort`.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_abort(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::abort)
}

/// The same by the limits for stops.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_quick_abort(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::quick_abort)
}

/// Feed override, 0 to 200 per cent.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_feed_override(
    core: *mut splineway_core,
    percent: u16,
) -> splineway_result {
    command(core, |controls| controls.feed_override(percent))
}

/// Override of rapids, 0 to 100 per cent.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_rapid_override(
    core: *mut splineway_core,
    percent: u16,
) -> splineway_result {
    command(core, |controls| controls.rapid_override(percent))
}

/// Single block mode: rest at the end of every block until resumed.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_single_block(
    core: *mut splineway_core,
    on: bool,
) -> splineway_result {
    command(core, |controls| controls.single_block(on))
}
