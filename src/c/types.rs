//! What C sees.
#![allow(non_camel_case_types, clippy::upper_case_acronyms)]

use super::shaping::splineway_shape;
use crate::planner::Progress;
use crate::servo::{Activity, Setpoint};
use core::ffi::CStr;

/// A number from the environment of the build.
const fn setting(text: Option<&str>, default: usize) -> usize {
    let Some(text) = text else { return default };
    let mut rest = text.as_bytes();
    let mut value = 0;
    while let [digit, more @ ..] = rest {
        assert!(digit.is_ascii_digit(), "SPLINEWAY_AXES, _BLOCKS, _NODES and _HISTORY are numbers");
        value = value * 10 + (*digit - b'0') as usize;
        rest = more;
    }
    value
}

/// Axes.
pub const SPLINEWAY_AXES: usize = setting(option_env!("SPLINEWAY_AXES"), 3);
/// Blocks of the look-ahead.
pub const SPLINEWAY_BLOCKS: usize = setting(option_env!("SPLINEWAY_BLOCKS"), crate::BLOCKS);
/// Nodes of the planning window.
pub const SPLINEWAY_NODES: usize = setting(option_env!("SPLINEWAY_NODES"), crate::NODES);
/// 1 of a library with outputs (feature `outputs`), else 0.
pub const SPLINEWAY_OUTPUTS: usize = cfg!(feature = "outputs") as usize;
/// 1 of a library with motors that follow several axes (feature `kinematics`), else 0.
pub const SPLINEWAY_KINEMATICS: usize = cfg!(feature = "kinematics") as usize;
/// 1 of a library with input shaping (feature `shaping`), else 0.
pub const SPLINEWAY_SHAPING: usize = cfg!(feature = "shaping") as usize;
/// Servo cycles that a shaper remembers: what it takes at the lowest frequency, and what axes wait for each other.
pub const SPLINEWAY_HISTORY: usize = setting(option_env!("SPLINEWAY_HISTORY"), 64);
/// Bytes that a core takes at most; the build fails if it were more.
pub const SPLINEWAY_STORAGE_BYTES: usize = 13_600
    + 4_900 * SPLINEWAY_AXES
    + SPLINEWAY_NODES * (200 + 80 * SPLINEWAY_AXES)
    + SPLINEWAY_BLOCKS * (136 + 20 * SPLINEWAY_AXES)
    + SPLINEWAY_OUTPUTS * 13_000
    + SPLINEWAY_KINEMATICS * (1_200 + 256 * SPLINEWAY_AXES)
    + SPLINEWAY_SHAPING
        * (512 + 256 * SPLINEWAY_AXES + SPLINEWAY_HISTORY * (8 + 36 * SPLINEWAY_AXES));

/// The same in words of 64 bits.
pub const SPLINEWAY_STORAGE_WORDS: usize = SPLINEWAY_STORAGE_BYTES / 8 + 1;

/// Version of the interface, which header and library must agree on.
pub const SPLINEWAY_INTERFACE: u32 = 6;

/// Storage of a core: opaque, and not to be moved once it is set up (it would no longer be ready).
#[repr(C)]
pub struct splineway_core {
    /// Not to be touched.
    pub words: [u64; SPLINEWAY_STORAGE_WORDS],
}

/// What came of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_result {
    /// Done.
    OK = 0,
    /// There is no room now: poll, and push the same block again.
    FULL = 1,
    /// A pointer is null. (Without a core, `NOT_READY`.)
    NULL = 2,
    /// The core is not set up.
    NOT_READY = 3,
    /// The storage is smaller than this library needs, which was built for another size, or not aligned.
    STORAGE = 4,
    /// The library was built for another number of axes.
    AXES = 5,
    /// A limit or a setting is not finite or out of its range.
    CONFIG = 6,
    /// A coordinate is beyond +-1e6 mm.
    COORDINATE = 7,
    /// Feed, duration, tolerance, dwell, or the velocity or time of a jog is not finite or out of its range.
    OUT_OF_RANGE = 8,
    /// The arc's plane names an axis that does not exist, or one twice.
    PLANE = 9,
    /// Start and end of the arc are at different distances from its centre, or it has no radius.
    ARC = 10,
    /// The block is too long.
    TOO_LONG = 11,
    /// An abort was asked for and has not been acknowledged: nothing is taken.
    ABORTED = 12,
    /// Header and library are not of the same version, or the configuration was not made by
    /// `splineway_config_init`.
    HEADER = 13,
    /// The block or the point of a jog leads out of the limits of travel.
    TRAVEL = 14,
    /// A jog while a program runs: hold it first.
    RUNNING = 15,
    /// A jog back, but no program is held.
    NO_PROGRAM = 16,
    /// A probe or homing: a hold, a stop or an override of 0 is in force, or a pause waits for its resume.
    HELD = 17,
    /// A probe: the input is already as it would be at the end; or there is no such input.
    INPUT = 18,
}

impl splineway_result {
    /// What a number means.
    pub(super) fn text(number: i32) -> &'static CStr {
        let all = [
            (Self::OK, c"done"),
            (Self::FULL, c"no room now: poll and push again"),
            (Self::NULL, c"a pointer is null"),
            (Self::NOT_READY, c"the core is not set up"),
            (Self::STORAGE, c"the storage is too small: header and library differ in size"),
            (Self::AXES, c"header and library differ in the number of axes"),
            (Self::CONFIG, c"a limit or a setting is out of its range"),
            (Self::COORDINATE, c"a coordinate is beyond 1e6 mm"),
            (Self::OUT_OF_RANGE, c"feed, duration, tolerance, dwell or velocity is out of its range"),
            (Self::PLANE, c"the plane of the arc does not exist"),
            (Self::ARC, c"the arc's ends are not at the same distance from its centre"),
            (Self::TOO_LONG, c"the block is too long"),
            (Self::ABORTED, c"an abort has not been acknowledged"),
            (Self::TRAVEL, c"the block or the jog leads out of the limits of travel"),
            (Self::RUNNING, c"a program runs: hold it before jogging"),
            (Self::NO_PROGRAM, c"no program is held that could be gone back to"),
            (Self::HELD, c"the machine is held: resume it first"),
            (Self::INPUT, c"the input is already as it would be at the end, or there is none of this number"),
            (Self::HEADER, c"header and library differ, or the configuration is not from splineway_config_init"),
        ];
        let known = all.into_iter().find(|(result, _)| *result as i32 == number);
        known.map_or(c"no result of splineway", |(_, text)| text)
    }
}

/// Limits of an axis.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_axis {
    /// mm/s (degrees/s on a rotary axis).
    pub velocity: f32,
    /// mm/s2.
    pub acceleration: f32,
    /// mm/s3.
    pub jerk: f32,
    /// Whether it turns: its feed does not count as way.
    pub rotary: bool,
}

/// Limits of an axis for stops that must be short.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_stop_limits {
    /// mm/s2; less than that of the axis at the time, as 0, says nothing.
    pub acceleration: f32,
    /// mm/s3; the same.
    pub jerk: f32,
}

/// How far an axis may go.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_travel {
    /// Least position, nm; `INT64_MIN`: none.
    pub least: i64,
    /// Greatest position, nm; `INT64_MAX`: none.
    pub greatest: i64,
}

/// A machine. Made by `splineway_config_init`, which says how large the header has it: a library of another
/// size then touches nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_config {
    /// Bytes of this structure in the header; not to be changed.
    pub size: u32,
    /// `SPLINEWAY_AXES` of the header.
    pub axis_count: u32,
    /// Limits of the axes.
    pub axes: [splineway_axis; SPLINEWAY_AXES],
    /// Limits for `splineway_quick_hold` and `splineway_quick_abort`; none of their own unless they are set.
    pub stop: [splineway_stop_limits; SPLINEWAY_AXES],
    /// Limits of travel; none unless they are set.
    pub travel: [splineway_travel; SPLINEWAY_AXES],
    /// Input shaping; none unless it is set.
    pub shape: [splineway_shape; SPLINEWAY_AXES],
    /// Servo cycle, s.
    pub cycle: f32,
    /// Tolerance of blocks that name none, mm.
    pub tolerance: f32,
    /// Time by which a plan is handed over before it takes effect, s: longer than a planning step takes.
    pub lead: f32,
    /// How long a start from rest waits for the look-ahead to fill, s.
    pub start_delay: f32,
    /// Most improvement steps of one planning step.
    pub iterations: u16,
    /// Sweeps in which runs of short lines are smoothed.
    pub sweeps: u16,
}

/// How a block is run.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_block {
    /// mm/s; with a `duration` it does not count; 0 is a rapid: as fast as the axes can.
    pub feed: f32,
    /// Seconds the block takes (inverse time); 0 if `feed` counts.
    pub duration: f32,
    /// Greatest distance from the programmed path, mm; a number below 0: the machine's.
    pub tolerance: f32,
    /// Whether to come to rest exactly on the end point.
    pub exact_stop: bool,
    /// The caller's mark; it comes back with the setpoints.
    pub tag: u32,
}

/// A circle or helix.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_arc {
    /// The plane's two axes.
    pub plane: [u32; 2],
    /// Centre in these axes, nm.
    pub centre: [i64; 2],
    /// G2.
    pub clockwise: bool,
    /// Full turns beyond the first arrival.
    pub extra_turns: u16,
}

/// What the interpolator is doing.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_activity {
    /// At rest: nothing to run.
    IDLE = 0,
    /// In motion.
    RUNNING = 1,
    /// In a dwell.
    DWELLING = 2,
    /// At an event of the program, whose tag the setpoint has: for one servo cycle.
    EVENT = 3,
    /// In a jog.
    JOGGING = 4,
    /// At rest, in other coordinates than before: what counts steps counts on from this position. For one servo cycle.
    SET = 5,
}

/// Where the axes should be at the end of a servo cycle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_setpoint {
    /// nm (1e-6 degrees on a rotary axis).
    pub position: [i64; SPLINEWAY_AXES],
    /// mm/s.
    pub velocity: [f32; SPLINEWAY_AXES],
    /// mm/s2.
    pub acceleration: [f32; SPLINEWAY_AXES],
    /// Speed along the path, mm/s.
    pub path_speed: f32,
    /// Tag of the block under way.
    pub tag: u32,
    /// What the interpolator is doing.
    pub activity: splineway_activity,
}

impl From<Setpoint<f32, SPLINEWAY_AXES>> for splineway_setpoint {
    fn from(setpoint: Setpoint<f32, SPLINEWAY_AXES>) -> Self {
        Self {
            position: core::array::from_fn(|axis| setpoint.position_nm(axis)),
            velocity: setpoint.velocity,
            acceleration: setpoint.acceleration,
            path_speed: setpoint.path_speed,
            tag: setpoint.tag,
            activity: match setpoint.activity {
                Activity::Idle => splineway_activity::IDLE,
                Activity::Running => splineway_activity::RUNNING,
                Activity::Dwelling => splineway_activity::DWELLING,
                Activity::Event => splineway_activity::EVENT,
                Activity::Jogging => splineway_activity::JOGGING,
                Activity::Set => splineway_activity::SET,
            },
        }
    }
}

/// What a call of `splineway_poll` came to.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum splineway_progress {
    /// A new plan was handed over.
    PLANNED = 0,
    /// Nothing to do until the interpolator has moved on.
    WAITING = 1,
    /// Nothing to do until more blocks come.
    NEEDS_BLOCKS = 2,
    /// Everything that was pushed has been handed over.
    DONE = 3,
    /// At rest because an operator asked for it.
    HELD = 4,
    /// At rest after an abort, and everything that had been pushed is dropped. Said until
    /// `splineway_acknowledge_abort`.
    ABORTED = 5,
    /// The core is not set up.
    NOT_READY = 6,
    /// A part of the work has been done, and more can be done now: poll again.
    PLANNING = 7,
}

impl From<Progress> for splineway_progress {
    fn from(progress: Progress) -> Self {
        match progress {
            Progress::Planning => Self::PLANNING,
            Progress::Planned => Self::PLANNED,
            Progress::Waiting => Self::WAITING,
            Progress::NeedsBlocks => Self::NEEDS_BLOCKS,
            Progress::Done => Self::DONE,
            Progress::Held => Self::HELD,
            Progress::Aborted => Self::ABORTED,
        }
    }
}

/// How the planner is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct splineway_report {
    /// End point of the last block taken, nm; after an abort, where the machine stands.
    pub end: [i64; SPLINEWAY_AXES],
    /// Blocks that have not been cut into cells yet.
    pub blocks_waiting: u32,
    /// Nodes of the window that lie ahead of the motion.
    pub nodes_ahead: u32,
    /// Whether there is no room for another block.
    pub full: bool,
    /// Plans handed over.
    pub plans: u32,
    /// Plans that came too late; the one before went on.
    pub late: u32,
    /// Stops because blocks did not come in time.
    pub starved: u32,
    /// Stretches for which no motion was found at once.
    pub stuck: u32,
}
