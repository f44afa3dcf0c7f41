//! What came of probes and of homing.

use crate::machine::is_rotary;
use crate::program::LETTERS;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use splineway::Coord;
use std::fmt;

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Search {
    /// A probe.
    Probe,
    /// Axes to their switches.
    Home,
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Ending {
    /// A probe found what it sought.
    Tripped,
    /// A probe came to its target without it.
    Missed,
    /// A probe was cancelled.
    Cancelled,
    /// All axes have found their switches.
    Homed,
    /// An axis has not.
    Failed,
}

/// A place of some axes, mm or degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot(Vec<(usize, f64)>);

impl Spot {
    /// Of the axes of a run.
    pub fn new<const N: usize>(place: &[Coord; N], axes: &[usize]) -> Self {
        Self(axes.iter().copied().zip(place.iter().map(|at| at.to_mm())).collect())
    }
}

impl Serialize for Spot {
    /// As `X_mm`, `C_deg` and so on.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut out = serializer.serialize_map(Some(self.0.len()))?;
        for (axis, at) in &self.0 {
            let unit = if is_rotary(*axis) { "deg" } else { "mm" };
            out.serialize_entry(&format!("{}_{unit}", LETTERS[*axis]), at)?;
        }
        out.end()
    }
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|(axis, at)| write!(f, " {}{at:.6}", LETTERS[*axis]))
    }
}

/// A probe or homing that is over.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sought {
    /// What was done.
    pub kind: Search,
    /// When the machine had come to rest, s.
    pub time_s: f64,
    /// How it ended.
    pub outcome: Ending,
    /// Where the input changed, of a probe that found it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<Spot>,
    /// Where the machine rests.
    pub rest: Spot,
    /// Which axis was not homed, and why.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

impl Sought {
    /// Whether what was sought was found.
    pub const fn is_found(&self) -> bool {
        matches!(self.outcome, Ending::Tripped | Ending::Homed)
    }
}

impl fmt::Display for Sought {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rest, .. } = self;
        match (self.outcome, &self.edge, &self.failure) {
            (Ending::Tripped, Some(edge), _) => {
                write!(f, "probe: tripped at{edge}, rests at{rest}")
            }
            (Ending::Missed, ..) => write!(f, "probe: no contact up to{rest}"),
            (Ending::Failed, _, Some(failure)) => write!(f, "home: {failure}"),
            (Ending::Homed | Ending::Failed, ..) => write!(f, "home: stands at{rest}"),
            (Ending::Cancelled | Ending::Tripped, ..) => {
                write!(f, "probe: cancelled, rests at{rest}")
            }
        }
    }
}
