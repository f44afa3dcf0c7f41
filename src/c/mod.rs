//! The core for C (feature `c`); the header is `src/c/splineway.h`, and `host-tests/c/example.c` an example.
//!
//! `cargo rustc --release --lib --features c-lib --crate-type staticlib` makes the library. It is built
//! for one machine: the environment variables `SPLINEWAY_AXES`, `SPLINEWAY_BLOCKS` and `SPLINEWAY_NODES` set
//! its size (3, 16 and 64 if they are not set), and C code that includes the header defines the same. With the feature `outputs`
//! it has outputs in time with the path too, and C code defines `SPLINEWAY_OUTPUTS` as 1; with `kinematics` motors that follow several
//! axes, and `SPLINEWAY_KINEMATICS` is 1.
//! The library knows what it was built for and refuses anything else before it touches it: the header passes
//! its sizes and its version.
//!
//! Nothing allocates and nothing panics. A core lives in storage that the caller provides and must not
//! move. [`splineway_tick`] may interrupt any other function; of the others only one may run at a time,
//! but for the commands of an operator, which may come from anywhere.
#![allow(unsafe_code)]
// The header is read by people who have no Rust.
#![allow(clippy::missing_safety_doc, clippy::undocumented_unsafe_blocks)]

mod convert;
#[cfg(feature = "kinematics")]
mod motors;
#[cfg(feature = "outputs")]
mod outputs;
#[cfg(all(feature = "c-lib", not(test)))]
mod runtime;
mod seeking;
mod types;

#[cfg(feature = "kinematics")]
pub use motors::*;
#[cfg(feature = "outputs")]
pub use outputs::*;
pub use seeking::*;
pub use types::*;

use crate::block::{Block, Motion, Turn};
use crate::jog::Jog;
use crate::machine::defaults;
use crate::number::Coord;
use crate::planner::{Link, Planner};
use crate::servo::{Controls, Inputs, Interpolator};
use convert::{config, coord, coords, feed, jog_refusal, limits, refusal, tolerance, travel};
use core::mem::MaybeUninit;

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
/// passes the header's size of a configuration, `bytes`, and its version, `interface`: if they are not the
/// library's, nothing is written.
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
    if interface != SPLINEWAY_INTERFACE {
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
/// forgotten. Not while an interrupt may call [`splineway_tick`] on the same storage.
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
        let settings = match self::config(settings) {
            Ok(settings) => settings,
            Err(result) => return result,
        };
        let Some(start) = coords(start) else { return splineway_result::COORDINATE };
        (&raw mut (*core).link).write(MaybeUninit::new(Link::new()));
        let link = (*core).link.assume_init_mut();
        let Ok((planner, interpolator)) = link.split(settings, start) else {
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

/// Adds a block; what its motion is comes from `motion`.
fn push(
    storage: *mut splineway_core,
    options: *const splineway_block,
    motion: impl FnOnce() -> Option<Motion<f32, SPLINEWAY_AXES>>,
) -> splineway_result {
    let Some(planner) = planner(storage) else { return splineway_result::NOT_READY };
    if options.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives options to read.
    let options = unsafe { &*options };
    let Some(motion) = motion() else { return splineway_result::COORDINATE };
    let block = Block {
        motion,
        feed: feed(options),
        tolerance: tolerance(options),
        exact_stop: options.exact_stop,
        tag: options.tag,
    };
    planner.push(&block).map_or_else(|error| refusal(&error), |()| splineway_result::OK)
}

/// Adds a straight line to `to` (nm).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_push_line(
    core: *mut splineway_core,
    to: *const i64,
    options: *const splineway_block,
) -> splineway_result {
    if to.is_null() {
        return splineway_result::NULL;
    }
    push(core, options, || Some(Motion::Line { to: unsafe { coords(to) }? }))
}

/// Adds a circular arc or helix to `to` (nm) about a centre (nm) in the plane of two axes, in the order
/// in which a quarter turn takes the first to the second: G17 is 0, 1. The same end as start in the plane is
/// a full circle; `extra_turns` are added.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_push_arc(
    core: *mut splineway_core,
    to: *const i64,
    arc: *const splineway_arc,
    options: *const splineway_block,
) -> splineway_result {
    if to.is_null() || arc.is_null() {
        return splineway_result::NULL;
    }
    push(core, options, || {
        // SAFETY: the caller gives an arc to read.
        let arc = unsafe { &*arc };
        Some(Motion::Arc {
            to: unsafe { coords(to) }?,
            plane: (arc.plane[0] as usize, arc.plane[1] as usize),
            centre: (coord(arc.centre[0])?, coord(arc.centre[1])?),
            turn: if arc.clockwise { Turn::Clockwise } else { Turn::CounterClockwise },
            extra_turns: arc.extra_turns,
        })
    })
}

/// Adds a cubic curve (a span of a spline) to `to` by its two Bezier points between (nm).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_push_cubic(
    core: *mut splineway_core,
    first: *const i64,
    second: *const i64,
    to: *const i64,
    options: *const splineway_block,
) -> splineway_result {
    if first.is_null() || second.is_null() || to.is_null() {
        return splineway_result::NULL;
    }
    push(core, options, || {
        // SAFETY: the caller gives points to read.
        let (controls, to) = unsafe { ([coords(first)?, coords(second)?], coords(to)?) };
        Some(Motion::Cubic { controls, to })
    })
}

/// Adds a standstill of some seconds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_push_dwell(
    core: *mut splineway_core,
    seconds: f32,
    tag: u32,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    let block = Block::dwell(seconds, tag);
    planner.push(&block).map_or_else(|error| refusal(&error), |()| splineway_result::OK)
}

/// Adds an event: the motion comes to rest, and for one servo cycle the setpoint has the activity `EVENT` and
/// this tag. With `pause` the machine then rests until `splineway_resume`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_push_event(
    core: *mut splineway_core,
    pause: bool,
    tag: u32,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    let block = if pause { Block::pause(tag) } else { Block::event(tag) };
    planner.push(&block).map_or_else(|error| refusal(&error), |()| splineway_result::OK)
}

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
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_jog_back(
    core: *mut splineway_core,
    feed: f32,
) -> splineway_result {
    jog(core, || Some(Jog::Back { feed }))
}

/// Ends a jog: every axis brakes as hard as its limits allow. From any context, as the commands of an operator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_jog_cancel(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::cancel_jog)
}

/// Says that no more blocks come for now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_finish(core: *mut splineway_core) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    planner.finish();
    splineway_result::OK
}

/// Does a slice of what is to be done now. To be called in the background, again and again; at once if it says
/// `PLANNING`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_poll(core: *mut splineway_core) -> splineway_progress {
    planner(core).map_or(splineway_progress::NOT_READY, |planner| planner.poll().into())
}

/// Polls until nothing can be done before the interpolator has moved on or blocks come, or until a plan was handed
/// over: for tests and simulations in which planning takes no time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_settle(core: *mut splineway_core) -> splineway_progress {
    planner(core).map_or(splineway_progress::NOT_READY, |planner| planner.settle().into())
}

/// The caller knows that an abort has dropped everything. True: it is complete, and blocks are taken again,
/// from where the machine stands (`end` of `splineway_status`). False, and nothing has changed: there is none,
/// or `splineway_poll` has not said `ABORTED` since the last was asked for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_acknowledge_abort(core: *mut splineway_core) -> bool {
    planner(core).is_some_and(Planner::acknowledge_abort)
}

/// One servo cycle: writes where the axes should be at its end. To be called by the servo interrupt.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_tick(
    core: *mut splineway_core,
    setpoint: *mut splineway_setpoint,
) -> splineway_result {
    let Some(core) = ready(core) else { return splineway_result::NOT_READY };
    if setpoint.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: only this function uses the interpolator, and it does not interrupt itself; the caller gives
    // a setpoint to write to.
    unsafe {
        let interpolator = (*core).interpolator.assume_init_mut();
        setpoint.write(interpolator.tick().into());
    }
    splineway_result::OK
}

/// How things are.
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

/// Passes an operator's command on.
fn command(core: *mut splineway_core, send: impl FnOnce(Controls<'static>)) -> splineway_result {
    let Some(controls) = controls(core) else { return splineway_result::NOT_READY };
    send(controls);
    splineway_result::OK
}

/// Feed hold: brake as hard as the limits allow, and rest on the path.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_hold(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::hold)
}

/// The same by the limits for stops. If the motion brakes already, it goes on as it does.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_quick_hold(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::quick_hold)
}

/// Ends a hold or a stop; in single block mode, runs the next block.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_resume(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::resume)
}

/// Finish the block under way, then rest until resumed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_stop(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::stop)
}

/// Brake, and drop everything that has not been run. No block is taken until `splineway_acknowledge_abort`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_abort(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::abort)
}

/// The same by the limits for stops.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_quick_abort(core: *mut splineway_core) -> splineway_result {
    command(core, Controls::quick_abort)
}

/// Feed override, 0 to 200 per cent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_feed_override(
    core: *mut splineway_core,
    percent: u16,
) -> splineway_result {
    command(core, |controls| controls.feed_override(percent))
}

/// Override of rapids, 0 to 100 per cent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_rapid_override(
    core: *mut splineway_core,
    percent: u16,
) -> splineway_result {
    command(core, |controls| controls.rapid_override(percent))
}

/// Single block mode: rest at the end of every block until resumed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_single_block(
    core: *mut splineway_core,
    on: bool,
) -> splineway_result {
    command(core, |controls| controls.single_block(on))
}

/// What a result means, in words that stay valid. Any number may be given.
#[unsafe(no_mangle)]
pub extern "C" fn splineway_result_text(result: i32) -> *const core::ffi::c_char {
    splineway_result::text(result).as_ptr()
}
