//! The core for C (feature `c`); the header is `src/c/splineway.h`, and `host-tests/c/example.c` an example.
//!
//! `cargo rustc --release --lib --features c-lib --crate-type staticlib` makes the library. It is built
//! for one machine: the environment variables `SPLINEWAY_AXES`, `SPLINEWAY_BLOCKS` and `SPLINEWAY_NODES` set
//! its size (3, 16 and 64 if they are not set), and C code that includes the header defines the same. With the feature `outputs`
//! it has outputs in time with the path too, and C code defines `SPLINEWAY_OUTPUTS` as 1; with `kinematics` motors that follow several
//! axes, and `SPLINEWAY_KINEMATICS` is 1; with `shaping` input shaping, `SPLINEWAY_SHAPING` is 1, and `SPLINEWAY_HISTORY` says how
//! many servo cycles a shaper remembers (64).
//! The library knows what it was built for and refuses anything else before it touches it: the header passes
//! its sizes and its version.
//!
//! Nothing allocates and nothing panics. A core lives in storage that the caller provides and must not
//! move. [`splineway_tick`] may interrupt any other function; of the others only one may run at a time,
//! but for the commands of an operator, which may come from anywhere. Every function says which context it may come from.
#![allow(unsafe_code)]
// The header is read by people who have no Rust.
#![allow(clippy::missing_safety_doc, clippy::undocumented_unsafe_blocks)]

mod commands;
mod convert;
mod jogging;
#[cfg(feature = "kinematics")]
mod motors;
#[cfg(feature = "outputs")]
mod outputs;
mod program;
#[cfg(all(feature = "c-lib", not(test)))]
mod runtime;
mod seeking;
mod shaping;
mod types;

pub use commands::*;
pub use jogging::*;
#[cfg(feature = "kinematics")]
pub use motors::*;
#[cfg(feature = "outputs")]
pub use outputs::*;
pub use program::*;
pub use seeking::*;
pub use shaping::*;
pub use types::*;

use crate::machine::defaults;
use crate::number::Coord;
use crate::planner::{Link, Planner};
use crate::servo::{Controls, Inputs, Interpolator};
use convert::{config, coords, limits, refusal, travel};
use core::mem::MaybeUninit;
#[cfg(not(feature = "shaping"))]
use shaping::refuse_shapes;
#[cfg(feature = "shaping")]
use shaping::{CShaper, shape};

/// What stands in the storage.
#[repr(C)]
struct Core {
    /// [`READY`] once everything else is set.
    ready: u32,
    /// Where it was set up: its parts point to each other, so it works nowhere else.
    home: *const Core,
    link: MaybeUninit<Link<f32, SPLINEWAY_AXES, SPLINEWAY_BLOCKS, SPLINEWAY_NODES>>,
    planner: MaybeUninit<CPlanner>,
    interpolator: MaybeUninit<Interpolator<'static, f32, SPLINEWAY_AXES>>,
    controls: MaybeUninit<Controls<'static>>,
    inputs: MaybeUninit<Inputs<'static>>,
    #[cfg(feature = "shaping")]
    shaper: MaybeUninit<CShaper>,
    /// Of the shaper, s.
    #[cfg(feature = "shaping")]
    delay: f32,
}

type CPlanner = Planner<'static, f32, SPLINEWAY_AXES, SPLINEWAY_BLOCKS, SPLINEWAY_NODES>;

const READY: u32 = 0x5350_4C31;

const _: () = assert!(size_of::<Core>() <= SPLINEWAY_STORAGE_BYTES, "the storage is too small");
const _: () = assert!(align_of::<Core>() <= align_of::<splineway_core>());

/// The core in some storage, if it is ready.
fn ready(storage: *mut splineway_core) -> Option<*mut Core> {
    let core = storage.cast::<Core>();
    // SAFETY: the caller gives storage that `splineway_init` has seen, or that is all zeros, or null.
    let ready = !core.is_null()
        && unsafe {
            (&raw const (*core).ready).read() == READY
                && core::ptr::eq((&raw const (*core).home).read(), core)
        };
    ready.then_some(core)
}

/// The planner, for one call; nothing of the interrupt's is touched.
fn planner<'a>(storage: *mut splineway_core) -> Option<&'a mut CPlanner> {
    // SAFETY: `ready` says it is set; the caller keeps to one background call at a time.
    ready(storage).map(|core| unsafe { (*core).planner.assume_init_mut() })
}

fn controls(storage: *mut splineway_core) -> Option<Controls<'static>> {
    // SAFETY: set, never changed, and made for any context.
    ready(storage).map(|core| unsafe { (&raw const (*core).controls).read().assume_init() })
}

fn inputs(storage: *mut splineway_core) -> Option<Inputs<'static>> {
    // SAFETY: as the controls.
    ready(storage).map(|core| unsafe { (&raw const (*core).inputs).read().assume_init() })
}

/// Fills in sensible settings: 1 ms servo cycle, 0.01 mm tolerance, and the same limits for every axis,
/// mm/s, mm/s2 and mm/s3. To be called as `splineway_config_init(config, velocity, acceleration, jerk)`, which
/// passes the header's size of a configuration, `bytes`, and its version with the size of an enumeration (which compilers choose, and
/// `-fshort-enums` does), `interface`: if they are not the library's, nothing is written.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_config_init_sized(
    config: *mut splineway_config,
    bytes: usize,
    interface: u32,
    velocity: f32,
    acceleration: f32,
    jerk: f32,
) -> splineway_result {
    if config.is_null() {
        return splineway_result::NULL;
    }
    if interface != SPLINEWAY_INTERFACE + ((size_of::<splineway_activity>() as u32) << 8) {
        return splineway_result::HEADER;
    }
    if bytes != size_of::<splineway_config>() {
        return splineway_result::AXES;
    }
    let axis = splineway_axis { velocity, acceleration, jerk, rotary: false };
    // SAFETY: the caller gives a config of this size to write to.
    unsafe {
        config.write(splineway_config {
            size: size_of::<splineway_config>() as u32,
            axis_count: SPLINEWAY_AXES as u32,
            axes: [axis; SPLINEWAY_AXES],
            stop: [splineway_stop_limits { acceleration: 0.0, jerk: 0.0 }; SPLINEWAY_AXES],
            travel: [splineway_travel { least: i64::MIN, greatest: i64::MAX }; SPLINEWAY_AXES],
            shape: [splineway_shape { kind: 0, frequency: 0.0, damping: 0.0 }; SPLINEWAY_AXES],
            cycle: defaults::CYCLE as f32,
            tolerance: defaults::TOLERANCE as f32,
            lead: defaults::LEAD as f32,
            start_delay: defaults::START_DELAY as f32,
            iterations: defaults::ITERATIONS,
            sweeps: defaults::SWEEPS,
        });
    }
    splineway_result::OK
}

/// Sets a core up in `storage` of `bytes` bytes, at rest at `start` (nm, one number per axis). What was there is
/// forgotten, if this is refused, too. Not while an interrupt may call [`splineway_tick`] on the same storage.
///
/// Context: background, while no interrupt uses this core.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_init(
    storage: *mut splineway_core,
    bytes: usize,
    config: *const splineway_config,
    start: *const i64,
) -> splineway_result {
    if storage.is_null() || config.is_null() || start.is_null() {
        return splineway_result::NULL;
    }
    let core = storage.cast::<Core>();
    if bytes < size_of::<Core>() || !core.is_aligned() {
        return splineway_result::STORAGE;
    }
    // SAFETY: the caller gives storage of that size, aligned by its type, that is not in use, and a config
    // and a start to read.
    unsafe {
        (&raw mut (*core).ready).write(0);
        // The first member stands at the same place in every header; the others only if the size is ours.
        if (&raw const (*config).size).read() as usize != size_of::<splineway_config>() {
            return splineway_result::HEADER;
        }
        let settings = &*config;
        if settings.axis_count as usize != SPLINEWAY_AXES {
            return splineway_result::AXES;
        }
        #[cfg(not(feature = "shaping"))]
        if let Err(result) = refuse_shapes(settings) {
            return result;
        }
        #[cfg_attr(not(feature = "shaping"), allow(unused_mut))]
        let mut made = match self::config(settings) {
            Ok(made) => made,
            Err(result) => return result,
        };
        #[cfg(feature = "shaping")]
        {
            (&raw mut (*core).shaper).write(MaybeUninit::new(CShaper::new()));
            match shape((*core).shaper.assume_init_mut(), settings, &mut made) {
                Ok(delay) => (&raw mut (*core).delay).write(delay),
                Err(result) => return result,
            }
        }
        let Some(start) = coords(start) else { return splineway_result::COORDINATE };
        (&raw mut (*core).link).write(MaybeUninit::new(Link::new()));
        let link = (*core).link.assume_init_mut();
        let Ok((planner, interpolator)) = link.split(made, start) else {
            return splineway_result::CONFIG;
        };
        (&raw mut (*core).controls).write(MaybeUninit::new(planner.controls()));
        (&raw mut (*core).inputs).write(MaybeUninit::new(planner.inputs()));
        (&raw mut (*core).interpolator).write(MaybeUninit::new(interpolator));
        (&raw mut (*core).planner).write(MaybeUninit::new(planner));
        (&raw mut (*core).home).write(core);
        (&raw mut (*core).ready).write(READY);
    }
    splineway_result::OK
}

/// Changes the limits of travel, one pair per axis: they hold for every block that is pushed from now on. `CONFIG`, and
/// nothing has changed, if one is out of its range or a greatest position is less than the least.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_set_travel(
    core: *mut splineway_core,
    axes: *const splineway_travel,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if axes.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one pair per axis to read.
    let axes = core::array::from_fn(|axis| unsafe { axes.add(axis).read() });
    let Some(travel) = travel(axes) else { return splineway_result::CONFIG };
    planner.set_travel(travel);
    splineway_result::OK
}

/// Changes the limits of the axes, one set per axis: they bound every block that is pushed from now on. What has been taken keeps
/// those it was taken with. `FULL`, and nothing has changed: limits have changed four times between the motion and the last
/// block, a curve is still being taken, or a jog is on; poll, and set them again. `CONFIG`: one is out of its range.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_set_limits(
    core: *mut splineway_core,
    axes: *const splineway_axis,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if axes.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one set per axis to read.
    let axes = core::array::from_fn(|axis| unsafe { axes.add(axis).read() });
    let Some(limits) = limits(axes) else { return splineway_result::CONFIG };
    match planner.set_limits(limits) {
        Ok(()) => splineway_result::OK,
        Err(error) => refusal(&error),
    }
}

/// Says that no more blocks come for now.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_finish(core: *mut splineway_core) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    planner.finish();
    splineway_result::OK
}

/// Does a slice of what is to be done now. To be called in the background, again and again; at once if it says
/// `PLANNING`.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_poll(core: *mut splineway_core) -> splineway_progress {
    planner(core).map_or(splineway_progress::NOT_READY, |planner| planner.poll().into())
}

/// Polls until nothing can be done before the interpolator has moved on or blocks come, or until a plan was handed
/// over: for tests and simulations in which planning takes no time.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_settle(core: *mut splineway_core) -> splineway_progress {
    planner(core).map_or(splineway_progress::NOT_READY, |planner| planner.settle().into())
}

/// The caller knows that an abort has dropped everything. True: it is complete, and blocks are taken again,
/// from where the machine stands (`end` of `splineway_status`). False, and nothing has changed: there is none,
/// or `splineway_poll` has not said `ABORTED` since the last was asked for.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_acknowledge_abort(core: *mut splineway_core) -> bool {
    planner(core).is_some_and(Planner::acknowledge_abort)
}

/// One servo cycle: writes where the axes should be at its end. To be called by the servo interrupt.
///
/// Context: servo interrupt.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_tick(
    core: *mut splineway_core,
    setpoint: *mut splineway_setpoint,
) -> splineway_result {
    let Some(core) = ready(core) else { return splineway_result::NOT_READY };
    if setpoint.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: only this function uses the interpolator and, behind `splineway_init`, changes the shaper, and it does not interrupt itself; the caller gives
    // a setpoint to write to.
    unsafe {
        let at = (*core).interpolator.assume_init_mut().tick();
        #[cfg(feature = "shaping")]
        let at = (*core).shaper.assume_init_mut().shape(&at);
        setpoint.write(at.into());
    }
    splineway_result::OK
}

/// How things are.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_status(
    core: *mut splineway_core,
    status: *mut splineway_report,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if status.is_null() {
        return splineway_result::NULL;
    }
    let counters = planner.counters();
    // SAFETY: the caller gives a status to write to.
    unsafe {
        status.write(splineway_report {
            end: planner.end().map(Coord::to_nm),
            blocks_waiting: planner.blocks_waiting() as u32,
            nodes_ahead: planner.nodes_ahead() as u32,
            full: planner.is_full(),
            plans: counters.plans,
            late: counters.late,
            starved: counters.starved,
            stuck: counters.stuck,
        });
    }
    splineway_result::OK
}

/// What a result means, in words that stay valid. Any number may be given.
///
/// Context: any.
#[unsafe(no_mangle)]
pub extern "C" fn splineway_result_text(result: i32) -> *const core::ffi::c_char {
    splineway_result::text(result).as_ptr()
}
