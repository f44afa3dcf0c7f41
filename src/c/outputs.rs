//! Outputs in time with the path, of a library with the feature `outputs`.

use super::types::{SPLINEWAY_AXES, splineway_core, splineway_result, splineway_setpoint};
use super::{planner, ready};
use crate::block::{Offset, Output, Power, Switch, SwitchError, Trigger};

/// What of the program an output switches with.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_trigger {
    /// With the end of the block that was pushed last; of a dwell or an event as the motion leaves it, or at rest if nothing follows.
    END = 0,
    /// With the start of the next motion.
    START = 1,
    /// At rest, behind all that was pushed, before all that will be.
    REST = 2,
}

/// An output.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_output {
    /// On or off, number 0 to 7.
    DIGITAL = 0,
    /// Any value, number 0 to 3.
    ANALOGUE = 1,
    /// The power of a tool.
    POWER = 2,
}

/// An output that takes a value at a place of the program.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_switch {
    /// A digital or an analogue one: a number of `splineway_output`.
    pub output: u32,
    /// Its number.
    pub number: u8,
    /// What it is to be: 0 or 1 of a digital one.
    pub value: f32,
    /// With what: a number of `splineway_trigger`.
    pub trigger: u32,
    /// How far behind that, mm; negative: before.
    pub distance: f32,
    /// Or how long behind that, s; negative: before. One of the two is 0.
    pub time: f32,
    /// Tag of the event at `REST`.
    pub tag: u32,
}

/// The power of a tool that works along the path.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_power {
    /// At the programmed feed.
    pub level: f32,
    /// Whether it is in proportion to the speed along the path.
    pub dynamic: bool,
    /// The least of one in proportion to the speed, as long as the motion moves.
    pub least: f32,
    /// The greatest.
    pub most: f32,
}

/// An output has switched.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_switched {
    /// Which.
    pub output: splineway_output,
    /// Its number.
    pub number: u8,
    /// To what.
    pub value: f32,
    /// When in the servo cycle that ends with the setpoint: 0 at its beginning, 1 at its end.
    pub fraction: f32,
}

fn refusal(error: SwitchError) -> splineway_result {
    match error {
        SwitchError::Full => splineway_result::FULL,
        SwitchError::Aborted => splineway_result::ABORTED,
        _ => splineway_result::OUT_OF_RANGE,
    }
}

/// Has an output switch at or about the end of the block that was pushed last. `FULL`: poll, and push the same switch again.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_push_switch(
    core: *mut splineway_core,
    switch: *const splineway_switch,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if switch.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives a switch to read.
    let c = unsafe { &*switch };
    let trigger = match c.trigger {
        0 => Trigger::End,
        1 => Trigger::Start,
        2 => Trigger::Rest,
        _ => return splineway_result::OUT_OF_RANGE,
    };
    let offset = match (c.distance == 0.0, c.time == 0.0) {
        (_, true) => Offset::Distance(c.distance),
        (true, false) => Offset::Time(c.time),
        (false, false) => return splineway_result::OUT_OF_RANGE,
    };
    let output = match c.output {
        0 => Output::Digital(c.number),
        1 => Output::Analogue(c.number),
        _ => return splineway_result::OUT_OF_RANGE,
    };
    let switch = Switch { output, value: c.value, trigger, offset, tag: c.tag };
    planner.push_switch(&switch).map_or_else(refusal, |()| splineway_result::OK)
}

fn power(c: &splineway_power) -> Power<f32> {
    Power { level: c.level, dynamic: c.dynamic, least: c.least, most: c.most }
}

/// The power of the blocks that are pushed from now on. One that is the same at every speed is on in dwells and events behind such a block
/// too, if it is not taken back before they are pushed. `ABORTED` from an abort on until it is acknowledged.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_set_power(
    core: *mut splineway_core,
    wanted: *const splineway_power,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if wanted.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives a power to read.
    let wanted = power(unsafe { &*wanted });
    planner.set_power(&wanted).map_or_else(refusal, |()| splineway_result::OK)
}

/// The same, and at rest, behind all that was pushed, before all that will be: one that is the same at every speed is on in
/// the dwells that follow.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_push_power(
    core: *mut splineway_core,
    wanted: *const splineway_power,
    tag: u32,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if wanted.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives a power to read.
    let wanted = power(unsafe { &*wanted });
    planner.push_power(&wanted, tag).map_or_else(refusal, |()| splineway_result::OK)
}

/// `splineway_tick`, and what has switched in that servo cycle, in `list`, which has room for `room`: 52 is enough for
/// all. `count` is how many there are, also beyond the room; `level` the power at the end of the cycle. Where setpoints are shaped, both
/// belong to where the machine is: to the setpoint that is written.
///
/// Context: servo interrupt.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_tick_outputs(
    core: *mut splineway_core,
    setpoint: *mut splineway_setpoint,
    list: *mut splineway_switched,
    room: u32,
    count: *mut u32,
    level: *mut f32,
) -> splineway_result {
    let Some(core) = ready(core) else { return splineway_result::NOT_READY };
    if setpoint.is_null() || count.is_null() || level.is_null() || (list.is_null() && room > 0) {
        return splineway_result::NULL;
    }
    // SAFETY: as in `splineway_tick`; the caller gives places to write to.
    unsafe {
        let interpolator = (*core).interpolator.assume_init_mut();
        let at: crate::servo::Setpoint<f32, SPLINEWAY_AXES> = interpolator.tick();
        #[cfg(feature = "shaping")]
        let at = (*core).shaper.assume_init_mut().shape(&at);
        let mut switches = 0;
        let power = interpolator.switch(&at, |switched| {
            let (output, number) = match switched.output {
                Output::Digital(number) => (splineway_output::DIGITAL, number),
                Output::Analogue(number) => (splineway_output::ANALOGUE, number),
                Output::Power => (splineway_output::POWER, 0),
            };
            if switches < room {
                let (value, fraction) = (switched.value, switched.fraction);
                list.add(switches as usize).write(splineway_switched {
                    output,
                    number,
                    value,
                    fraction,
                });
            }
            switches += 1;
        });
        count.write(switches);
        level.write(power);
        setpoint.write(at.into());
    }
    splineway_result::OK
}
