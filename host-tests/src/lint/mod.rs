//! What the core will do with a program, before a machine does it.

mod blame;
mod feeds;
mod ledger;
mod listing;
mod way;

pub use self::blame::{Blame, Times, slow_places};
pub use self::feeds::Asked;
pub use self::ledger::{Ledger, Odd};
pub use self::listing::Listing;

use crate::view::Progress;
use anyhow::Result;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::Tape;
use splineway_simulator::run::{Precision, run};

/// What a line of the file costs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Place {
    /// Line of the file.
    pub line: u32,
    /// Length of its moves, mm.
    #[serde(rename = "length_mm")]
    pub length: f64,
    /// The feed at its slowest place, mm/s, as far as the axes allow.
    #[serde(rename = "feed_mm_s")]
    pub feed: f64,
    /// Time, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Time lost against the feed around its slowest place, s, be it on other lines.
    #[serde(rename = "lost_s")]
    pub lost: f64,
    /// Least speed, mm/s, over the axes that the feed is for.
    #[serde(rename = "slowest_mm_s")]
    pub slowest: f64,
    /// What held the motion back there.
    pub cause: String,
    /// The one that lost most of those on this line.
    #[serde(skip)]
    pub worst: Worst,
}

/// A slow place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// Time lost, s.
    pub lost: f64,
    /// When it was slowest, s.
    pub time: f64,
    /// Speed then, mm/s.
    pub slowest: f64,
}

/// Moves by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Moves {
    /// Straight ones.
    pub lines: usize,
    /// Arcs and helices.
    pub arcs: usize,
    /// Cubic curves.
    pub curves: usize,
    /// Dwells and events.
    pub dwells: usize,
}

/// Shares of the time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Shares {
    /// At the feed asked for.
    #[serde(rename = "at_feed_share")]
    pub at_feed: f64,
    /// At less.
    #[serde(rename = "below_feed_share")]
    pub below_feed: f64,
    /// At rest.
    #[serde(rename = "at_rest_share")]
    pub at_rest: f64,
}

/// Least and greatest coordinate of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Its letter.
    pub axis: char,
    /// `mm` or `deg`.
    pub unit: &'static str,
    /// Least.
    pub least: f64,
    /// Greatest.
    pub greatest: f64,
}

impl Serialize for Extent {
    /// As `axis`, `least_mm`, `greatest_mm`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_map(Some(3))?;
        out.serialize_entry("axis", &self.axis)?;
        out.serialize_entry(&format!("least_{}", self.unit), &self.least)?;
        out.serialize_entry(&format!("greatest_{}", self.unit), &self.greatest)?;
        out.end()
    }
}

/// What was found.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Findings {
    /// Moves by kind.
    pub moves: Moves,
    /// Length, mm.
    #[serde(rename = "length_mm")]
    pub length: f64,
    /// Of every axis in use.
    pub extent: Vec<Extent>,
    /// Machining time, s.
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Shares of it.
    pub shares: Shares,
    /// Stops at the end of a move.
    pub stops: usize,
    /// The places that lose most time.
    pub slowest: Vec<Place>,
    /// What might be done about it.
    pub advice: Vec<String>,
}

/// Looks at a program and runs it.
///
/// `source` are the lines of its file; a bar on a terminal shows how far it is, unless it is to be `quiet`. Of a program whose lines come
/// in order no more is kept than what is around the motion.
///
/// # Errors
/// It cannot be run on this machine.
pub fn look(
    program: &dyn Tape,
    machine: &Machine,
    places: usize,
    source: Listing<'_>,
    quiet: bool,
) -> Result<Findings> {
    let limits = machine.axes_of(program)?;
    let ledger = Ledger::new(program, machine, places, source)?;
    let mut blame = Blame::new(program, &limits, machine.cycle, ledger);
    let last = program.summary().last_line;
    let mut progress = Progress::over_lines(last, quiet);
    run(program, machine, Precision::F64, &mut [&mut blame, &mut progress])?;
    progress.finish();
    blame.close();
    let Times { all, at_feed, at_rest, at_limit } = blame.times;
    let (mut findings, odd) = blame.ledger.finish();
    let total = all.max(machine.cycle);
    let slow = (total - at_feed - at_rest).max(0.0);
    findings.time = all;
    findings.shares =
        Shares { at_feed: at_feed / total, below_feed: slow / total, at_rest: at_rest / total };
    findings.advice = advice(&findings, machine, odd, (slow - at_limit) / total);
    Ok(findings)
}

/// What might be done about it; `held` is the share of the time below what the axes allow of the feed.
fn advice(findings: &Findings, machine: &Machine, odd: Odd, held: f64) -> Vec<String> {
    let Odd { empty, beyond, stops } = odd;
    let mut advice = Vec::new();
    let Moves { lines, arcs, curves, dwells } = findings.moves;
    let moves = lines + arcs + curves + dwells;
    if machine.tolerance == 0.0 && moves > 1 {
        advice.push("the tolerance is 0, so every corner is an exact stop: give one (G64 P0.01, or --tolerance 0.01)".to_owned());
    }
    if stops * 5 > moves && moves > 5 {
        advice.push(format!(
            "{stops} of {moves} moves end in an exact stop: if that is not meant, leave G61 for G64"
        ));
    }
    if empty > 0 {
        advice.push(format!(
            "{empty} lines have no length and do nothing: the post-processor could leave them out"
        ));
    }
    if beyond > 0 {
        advice.push(format!(
            "{beyond} moves ask for more feed than the axes allow: they run as fast as those do"
        ));
    }
    if held > 0.5 && machine.tolerance > 0.0 {
        advice.push(format!(
            "more than half of the time is spent below the feed: a tolerance wider than {} mm, or more acceleration and jerk, would tell",
            machine.tolerance
        ));
    }
    advice
}
