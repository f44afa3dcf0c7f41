//! Blocks of a program for C.

use super::convert::{coord, coords, feed, refusal, tolerance};
use super::planner;
use super::types::{
    SPLINEWAY_AXES, splineway_arc, splineway_block, splineway_core, splineway_result,
};
use crate::block::{Block, Motion, Turn};

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
///
/// Context: background.
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
///
/// Context: background.
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
///
/// Context: background.
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
///
/// Context: background.
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
///
/// Context: background.
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
