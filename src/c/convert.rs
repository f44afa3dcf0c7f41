//! From C's plain data to the core's.

use super::types::{
    SPLINEWAY_AXES, splineway_axis, splineway_block, splineway_config, splineway_result,
    splineway_travel,
};
use crate::block::{BlockError, Feed, PushError};
use crate::jog::{JogError, ProbeError};
use crate::machine::{AxisLimits, AxisTravel, Config, Limits, Quantity, Travel};
use crate::number::Coord;

pub fn coord(nm: i64) -> Option<Coord> {
    Coord::from_nm(nm).ok()
}

/// A point of `SPLINEWAY_AXES` numbers, nm.
///
/// # Safety
/// They can be read.
pub unsafe fn coords(nm: *const i64) -> Option<[Coord; SPLINEWAY_AXES]> {
    let mut point = [Coord::ZERO; SPLINEWAY_AXES];
    for (axis, slot) in point.iter_mut().enumerate() {
        // SAFETY: as the caller says.
        *slot = coord(unsafe { nm.add(axis).read() })?;
    }
    Some(point)
}

pub fn feed(options: &splineway_block) -> Feed<f32> {
    if options.duration != 0.0 {
        Feed::Duration(options.duration)
    } else if options.feed.to_bits() == 0 {
        // Zero and nothing else: what a calculation has rounded to -0 is no rapid.
        Feed::Rapid
    } else {
        Feed::PerSecond(options.feed)
    }
}

/// What is no number is no way to ask for the machine's tolerance: it is refused with the block.
pub fn tolerance(options: &splineway_block) -> Option<f32> {
    let default = options.tolerance < 0.0 && options.tolerance.is_finite();
    (!default).then_some(options.tolerance)
}

/// `None` if one is out of its range.
pub fn limits(axes: [splineway_axis; SPLINEWAY_AXES]) -> Option<Limits<f32, SPLINEWAY_AXES>> {
    let axes = axes.map(|axis| AxisLimits {
        velocity: axis.velocity,
        acceleration: axis.acceleration,
        jerk: axis.jerk,
        rotary: axis.rotary,
    });
    Limits::new(axes).ok()
}

/// `None` if a limit is out of its range, or the greatest position is less than the least.
pub fn travel(axes: [splineway_travel; SPLINEWAY_AXES]) -> Option<Travel<SPLINEWAY_AXES>> {
    let mut travel = [AxisTravel::default(); SPLINEWAY_AXES];
    for (slot, ends) in travel.iter_mut().zip(axes) {
        if ends.least != i64::MIN {
            slot.least = Some(coord(ends.least)?);
        }
        if ends.greatest != i64::MAX {
            slot.greatest = Some(coord(ends.greatest)?);
        }
    }
    Travel::new(travel).ok()
}

pub fn config(c: &splineway_config) -> Result<Config<f32, SPLINEWAY_AXES>, splineway_result> {
    let usual = limits(c.axes).ok_or(splineway_result::CONFIG)?;
    let mut config = Config::new(usual);
    let mut stop = c.axes;
    for (axis, stop) in stop.iter_mut().zip(c.stop) {
        // The greater of these and of the axis's own, which may change, counts in a stop. No number is refused with the rest.
        let said = |quantity: Quantity, stop: f32| {
            let least = quantity.range().least as f32;
            if stop <= least { least } else { stop }
        };
        axis.acceleration = said(Quantity::Acceleration, stop.acceleration);
        axis.jerk = said(Quantity::Jerk, stop.jerk);
    }
    if c.stop.iter().any(|stop| stop.acceleration != 0.0 || stop.jerk != 0.0) {
        config.stop_limits = Some(limits(stop).ok_or(splineway_result::CONFIG)?);
    }
    config.travel = travel(c.travel).ok_or(splineway_result::CONFIG)?;
    config.cycle = c.cycle;
    config.tolerance = c.tolerance;
    config.lead = c.lead;
    config.start_delay = c.start_delay;
    config.iterations = c.iterations;
    config.sweeps = c.sweeps;
    Ok(config)
}

pub fn refusal(error: &PushError) -> splineway_result {
    let reason = match error {
        PushError::Full => return splineway_result::FULL,
        PushError::Aborted => return splineway_result::ABORTED,
        PushError::Rejected { reason, .. } => reason,
    };
    match reason {
        BlockError::OutOfRange { .. } => splineway_result::OUT_OF_RANGE,
        BlockError::Coordinate { .. } => splineway_result::COORDINATE,
        BlockError::Plane { .. } => splineway_result::PLANE,
        BlockError::ArcRadius { .. } | BlockError::ArcUnreachable { .. } => splineway_result::ARC,
        BlockError::TooLong { .. } => splineway_result::TOO_LONG,
        BlockError::Travel { .. } => splineway_result::TRAVEL,
    }
}

pub fn probe_refusal(error: &ProbeError) -> splineway_result {
    match error {
        ProbeError::Running => splineway_result::RUNNING,
        ProbeError::Held => splineway_result::HELD,
        ProbeError::Aborted => splineway_result::ABORTED,
        ProbeError::Input => splineway_result::INPUT,
        ProbeError::OutOfRange { .. } => splineway_result::OUT_OF_RANGE,
        ProbeError::Coordinate { .. } => splineway_result::COORDINATE,
        ProbeError::Travel { .. } => splineway_result::TRAVEL,
    }
}

pub fn jog_refusal(error: &JogError) -> splineway_result {
    match error {
        JogError::Running => splineway_result::RUNNING,
        JogError::Aborted => splineway_result::ABORTED,
        JogError::NoProgram => splineway_result::NO_PROGRAM,
        JogError::OutOfRange { .. } => splineway_result::OUT_OF_RANGE,
        JogError::Coordinate { .. } => splineway_result::COORDINATE,
        JogError::Travel { .. } => splineway_result::TRAVEL,
    }
}
