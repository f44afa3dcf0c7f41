//! Inputs, probes and homing for C.

use super::convert::{coords, probe_refusal};
use super::types::{SPLINEWAY_AXES, splineway_core, splineway_result};
use super::{inputs, planner};
use crate::jog::{AxisHome, HomeFault, Outcome, Probe};
use crate::number::Coord;
use crate::servo::Input;

/// How a probe ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_probe_outcome {
    /// There is none, it is not over, or it has been said.
    NONE = 0,
    /// By its input.
    TRIPPED = 1,
    /// At its target, without it.
    MISSED = 2,
    /// By `splineway_jog_cancel` or an abort.
    CANCELLED = 3,
}

/// What came of a probe.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_probe_result {
    /// How it ended.
    pub outcome: splineway_probe_outcome,
    /// Where the axes were when the input changed, where they came to rest if it did not, nm.
    pub position: [i64; SPLINEWAY_AXES],
}

/// How an axis is homed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_axis_home {
    /// Whether it is.
    pub wanted: bool,
    /// Axes of a lower number are homed before those of a higher one; those of the same at once.
    pub order: u8,
    /// Speed of the first approach and of the ways back, mm/s; its sign says on which side the switch is.
    pub fast: f32,
    /// Speed of the second approach, mm/s.
    pub slow: f32,
    /// How far away the switch may be, nm: without an edge the axis ends there.
    pub reach: i64,
    /// How far it goes back from the switch, nm: more than the switch needs to open.
    pub back: i64,
    /// The coordinate of the edge, nm.
    pub at: i64,
    /// Whether the axis goes somewhere in the end.
    pub parks: bool,
    /// Where to, in the new coordinates, nm.
    pub park: i64,
}

/// What came of homing.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_homing {
    /// There is none, it is not over, or it has been said.
    NONE = 0,
    /// All axes are homed, and the coordinates set.
    DONE = 1,
    /// A switch has not closed within the way it was given.
    MISSING = 2,
    /// A switch is still closed after the way back.
    STUCK = 3,
    /// By `splineway_jog_cancel` or an abort.
    CANCELLED = 4,
}

/// What came of homing, and with which axis.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_home_result {
    /// What came of it.
    pub homing: splineway_homing,
    /// The axis with which something has gone wrong.
    pub axis: u32,
    /// What it was doing: 0 done, 1 waiting for others, 2 leaving its switch, 3 seeking it, 4 backing off, 5 approaching it slowly,
    /// 6 on its way from it.
    pub phase: u32,
}

/// An input by its number: an axis's home switch, or the probe.
fn input(number: i32) -> Option<Input> {
    match usize::try_from(number) {
        Ok(axis) if axis < SPLINEWAY_AXES => Some(Input::Home(axis)),
        _ => (number == -1).then_some(Input::Probe),
    }
}

/// Tells the level of an input, `fraction` of a servo cycle after the last `splineway_tick`: to be called from the interrupt of its
/// edges, from any context, and once at the start. `number` is the index of an axis for its home switch, -1 for the probe; `INPUT`
/// if it is neither. Where the fraction is read while a tick is due that has not come, it is one more; where one came after it was read, one less. What
/// is no number counts as -1.
///
/// Context: any.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_input(
    core: *mut splineway_core,
    number: i32,
    closed: bool,
    fraction: f32,
) -> splineway_result {
    let Some(inputs) = inputs(core) else { return splineway_result::NOT_READY };
    let Some(input) = input(number) else { return splineway_result::INPUT };
    inputs.tell(input, closed, fraction);
    splineway_result::OK
}

/// Probes: a straight move to `to` (nm) at a feed (mm/s) that ends early when an input closes, or opens. From rest with nothing to run;
/// `RUNNING`, `HELD` or `ABORTED` else, and `INPUT` if the input is as it would be at the end. `splineway_probed` says what came of it;
/// until then no block is taken.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_probe(
    core: *mut splineway_core,
    to: *const i64,
    feed: f32,
    number: i32,
    closes: bool,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if to.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one number per axis to read.
    let Some(to) = (unsafe { coords(to) }) else { return splineway_result::COORDINATE };
    let Some(input) = input(number) else { return splineway_result::INPUT };
    let probe = Probe { to, feed, input, closes };
    planner.probe(&probe).map_or_else(|error| probe_refusal(&error), |()| splineway_result::OK)
}

/// What came of the last probe, once: afterwards, and as long as it is not over, the outcome is `NONE`.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_probed(
    core: *mut splineway_core,
    result: *mut splineway_probe_result,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if result.is_null() {
        return splineway_result::NULL;
    }
    let probed = planner.probed();
    let outcome = match probed.map(|probed| probed.outcome) {
        None => splineway_probe_outcome::NONE,
        Some(Outcome::Tripped) => splineway_probe_outcome::TRIPPED,
        Some(Outcome::Missed) => splineway_probe_outcome::MISSED,
        Some(Outcome::Cancelled) => splineway_probe_outcome::CANCELLED,
    };
    let position = probed.map_or([0; SPLINEWAY_AXES], |probed| probed.position.map(Coord::to_nm));
    // SAFETY: the caller gives a result to write to.
    unsafe { result.write(splineway_probe_result { outcome, position }) };
    splineway_result::OK
}

/// How far a probe in a direction (one number per axis, of any length) at a feed (mm/s) goes on after its edge at the worst, mm: where the
/// feed has been reached, and anywhere.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_probe_overshoot(
    core: *mut splineway_core,
    feed: f32,
    direction: *const f32,
    at_feed: *mut f32,
    most: *mut f32,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if direction.is_null() || at_feed.is_null() || most.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one number per axis to read.
    let direction = core::array::from_fn(|axis| unsafe { direction.add(axis).read() });
    match planner.probe_overshoot(feed, &direction) {
        Ok(told) => {
            // SAFETY: the caller gives two numbers to write to.
            unsafe {
                at_feed.write(told.at_feed);
                most.write(told.most);
            }
            splineway_result::OK
        }
        Err(error) => probe_refusal(&error),
    }
}

/// Homes axes, one `splineway_axis_home` per axis: each that has `wanted` goes to its switch, back, to it again slowly, and the
/// coordinate of its edge then is `at`. Refused as `splineway_probe` is. `splineway_homed` says what came of it.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_home(
    core: *mut splineway_core,
    axes: *const splineway_axis_home,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if axes.is_null() {
        return splineway_result::NULL;
    }
    let mut homes = [None; SPLINEWAY_AXES];
    for (axis, slot) in homes.iter_mut().enumerate() {
        // SAFETY: the caller gives one per axis to read.
        let home = unsafe { axes.add(axis).read() };
        if !home.wanted {
            continue;
        }
        let [Ok(reach), Ok(back), Ok(at), Ok(park)] =
            [home.reach, home.back, home.at, home.park].map(Coord::from_nm)
        else {
            return splineway_result::COORDINATE;
        };
        let park = home.parks.then_some(park);
        let (fast, slow, order) = (home.fast, home.slow, home.order);
        *slot = Some(AxisHome { fast, slow, reach, back, at, park, order });
    }
    planner.home(&homes).map_or_else(|error| probe_refusal(&error), |()| splineway_result::OK)
}

/// What came of the last `splineway_home` or `splineway_set_position`, once: afterwards, and as long as it is not over, it is `NONE`.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_homed(
    core: *mut splineway_core,
    result: *mut splineway_home_result,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if result.is_null() {
        return splineway_result::NULL;
    }
    let (homing, axis, phase) = match planner.homed() {
        None => (splineway_homing::NONE, 0, 0),
        Some(Ok(())) => (splineway_homing::DONE, 0, 0),
        Some(Err(failure)) => {
            let homing = match failure.fault {
                HomeFault::Missing => splineway_homing::MISSING,
                HomeFault::Stuck => splineway_homing::STUCK,
                HomeFault::Cancelled => splineway_homing::CANCELLED,
            };
            (homing, failure.axis as u32, failure.phase as u32)
        }
    };
    // SAFETY: the caller gives a result to write to.
    unsafe { result.write(splineway_home_result { homing, axis, phase }) };
    splineway_result::OK
}

/// Sets the coordinates (nm) of where the machine stands, at rest with nothing to run. Setpoints are the new ones from the one with the
/// activity `SET` on, and `splineway_homed` says `DONE`.
///
/// Context: background.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn splineway_set_position(
    core: *mut splineway_core,
    to: *const i64,
) -> splineway_result {
    let Some(planner) = planner(core) else { return splineway_result::NOT_READY };
    if to.is_null() {
        return splineway_result::NULL;
    }
    // SAFETY: the caller gives one number per axis to read.
    let Some(to) = (unsafe { coords(to) }) else { return splineway_result::COORDINATE };
    planner.set_position(&to).map_or_else(|error| probe_refusal(&error), |()| splineway_result::OK)
}
