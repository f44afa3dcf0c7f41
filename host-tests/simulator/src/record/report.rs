//! The report of a run.

use crate::judge::{Peaks, Verdict};
use crate::machine::{Machine, is_rotary};
use crate::program::{LETTERS, Tape};
use crate::run::{Happening, Precision, Sought, Stats, Timing};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// Mean, 99th percentile and maximum, ns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nanoseconds {
    /// Mean.
    pub mean: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Maximum.
    pub max: f64,
}

impl Nanoseconds {
    fn new(timing: &Timing, per: f64) -> Self {
        let (mean, p99, max) = timing.summary();
        Self { mean: mean / per, p99: p99 / per, max: max / per }
    }
}

/// A peak and its ratio to the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// In this unit.
    pub value: f64,
    /// `mm_s`, `mm_s2`, `mm_s3`; of an axis that turns `deg_s` and so on.
    pub unit: &'static str,
    /// Over the limit.
    pub ratio: f64,
}

impl Serialize for Peak {
    /// As `peak_mm_s` and `ratio`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_map(Some(2))?;
        out.serialize_entry(&format!("peak_{}", self.unit), &self.value)?;
        out.serialize_entry("ratio", &self.ratio)?;
        out.end()
    }
}

/// Units of velocity, acceleration and jerk.
const LINEAR: [&str; 3] = ["mm_s", "mm_s2", "mm_s3"];
const ROTARY: [&str; 3] = ["deg_s", "deg_s2", "deg_s3"];

/// Peaks of one axis, found by finite differences of the setpoints.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxisReport {
    /// mm/s.
    pub velocity: Peak,
    /// mm/s2.
    pub acceleration: Peak,
    /// mm/s3, differences of consecutive cycles.
    pub jerk: Peak,
    /// mm/s3, over every fourth cycle.
    pub jerk_every_fourth_cycle: Peak,
}

/// Speed along the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FeedReport {
    /// Length over time; of what was run, where the rest was dropped.
    pub mean_mm_s: f64,
    /// Greatest.
    pub max_mm_s: f64,
}

/// Everything about a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Time from rest to rest, s.
    pub time_s: f64,
    /// Servo cycles.
    pub cycles: u64,
    /// Blocks.
    pub blocks: u64,
    /// Whether the rest of the program was dropped.
    pub aborted: bool,
    /// Length of the programmed path, mm.
    pub path_length_mm: f64,
    /// Tolerance, mm (the machine's; blocks may bring their own).
    pub tolerance_mm: f64,
    /// Largest distance of a setpoint from the programmed path, mm.
    pub max_deviation_mm: f64,
    /// Distance of the last setpoint from the programmed end, mm.
    pub end_error_mm: f64,
    /// Scalar of the core.
    pub scalar: &'static str,
    /// Peaks by axis letter.
    pub axes: BTreeMap<char, AxisReport>,
    /// Peaks by motor.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub motors: BTreeMap<String, AxisReport>,
    /// Speed along the path.
    pub feed: FeedReport,
    /// Planning, per block.
    pub ns_per_block: Nanoseconds,
    /// Planning, per planning step.
    pub ns_per_planning_step: Nanoseconds,
    /// Ticks.
    pub ns_per_tick: Nanoseconds,
    /// Least number of path nodes ahead of the motion at a planning step, while blocks were left.
    pub least_look_ahead_nodes: usize,
    /// Plans handed over.
    pub plans: u32,
    /// Plans that came too late.
    pub late_plans: u32,
    /// Stops for want of blocks.
    pub starved: u32,
    /// What was noticed.
    pub warnings: Vec<String>,
    /// What the program asked of the machine besides motion, in order.
    pub events: Vec<Happening>,
    /// What came of probes and homing, in order.
    pub sought: Vec<Sought>,
}

impl Report {
    /// Puts it together; `length` is that of the path, mm.
    pub fn new(
        program: &dyn Tape,
        machine: &Machine,
        precision: Precision,
        length: f64,
        verdict: &Verdict,
        stats: &Stats,
    ) -> Self {
        let peaks = verdict.peaks.iter().zip(&verdict.ratios);
        let report = |(peak, ratio): (&Peaks, &Peaks), [v, a, j]: [&'static str; 3]| AxisReport {
            velocity: Peak { value: peak.velocity, unit: v, ratio: ratio.velocity },
            acceleration: Peak { value: peak.acceleration, unit: a, ratio: ratio.acceleration },
            jerk: Peak { value: peak.jerk, unit: j, ratio: ratio.jerk },
            jerk_every_fourth_cycle: Peak { value: peak.jerk4, unit: j, ratio: ratio.jerk4 },
        };
        let used = program.axes();
        let motors = peaks.clone().skip(used.len()).map(|peaks| report(peaks, LINEAR));
        let axis = |(axis, peaks)| {
            (LETTERS[axis], report(peaks, if is_rotary(axis) { ROTARY } else { LINEAR }))
        };
        let axes = used.into_iter().zip(peaks).map(axis).collect();
        let names = machine.motors_for(program).into_iter().map(|motor| motor.name);
        let motors = names.zip(motors).collect();
        let steps = f64::from(stats.counters.plans.max(1));
        let went = if stats.aborted { verdict.way } else { length };
        let blocks_per_step = (stats.blocks as f64 / steps).max(1e-9);
        Self {
            time_s: verdict.time,
            cycles: verdict.cycles,
            blocks: stats.blocks,
            aborted: stats.aborted,
            path_length_mm: length,
            tolerance_mm: machine.tolerance,
            max_deviation_mm: verdict.deviation,
            end_error_mm: verdict.end_error,
            scalar: match precision {
                Precision::F32 => "f32",
                Precision::F64 => "f64",
            },
            axes,
            motors,
            feed: FeedReport {
                mean_mm_s: if verdict.time > 0.0 { went / verdict.time } else { 0.0 },
                max_mm_s: verdict.path_speed,
            },
            ns_per_block: Nanoseconds::new(&stats.planning, blocks_per_step),
            ns_per_planning_step: Nanoseconds::new(&stats.planning, 1.0),
            ns_per_tick: Nanoseconds::new(&stats.ticks, 1.0),
            least_look_ahead_nodes: stats.least_ahead,
            plans: stats.counters.plans,
            late_plans: stats.counters.late,
            starved: stats.counters.starved,
            warnings: program.warnings().to_vec(),
            events: Vec::new(),
            sought: stats.sought.clone(),
        }
    }
}
