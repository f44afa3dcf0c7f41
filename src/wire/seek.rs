//! Probes and homing as they are sent, and what comes of them.

use super::moves::{Axes, Target};
#[cfg(feature = "home")]
use crate::jog::{AxisHome, HomeFailure, HomePhase};
#[cfg(feature = "probe")]
use crate::jog::{Outcome, Probe, ProbeError, Probed};
#[cfg(feature = "probe")]
use crate::number::{Coord, Scalar};
#[cfg(feature = "probe")]
use crate::servo::Input;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// What ends a probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProbeInput {
    /// The probe.
    Probe,
    /// The home switch of the axis with this index.
    Home(u8),
}

/// A straight move that ends early on an input, in whole numbers: see `Probe` (feature `probe`).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProbeMove {
    /// Where it ends if nothing comes, absolute.
    pub to: Target,
    /// Speed along the line, um/s.
    pub feed: u32,
    /// What ends it.
    pub input: ProbeInput,
    /// Whether it ends when the input closes (G38.2, G38.3, G31) or when it opens (G38.4, G38.5).
    pub closes: bool,
    /// Whether the session ends if its input does not come (G38.2, G38.4).
    pub required: bool,
    /// The caller's mark.
    pub tag: u32,
}

/// How one axis is homed, in whole numbers: see `AxisHome` (feature `home`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HomeAxis {
    /// Speed of the first approach and of the ways back, um/s; its sign says on which side the switch is.
    pub fast: i32,
    /// Speed of the second approach, um/s.
    pub slow: u32,
    /// How far away the switch may be, um.
    pub reach: u32,
    /// How far it goes back from the switch, um.
    pub back: u32,
    /// The coordinate of the edge, nm.
    pub at: i64,
    /// Where the axis shall stand in the end, nm in the new coordinates; `None`: where it comes to rest behind the edge.
    pub park: Option<i64>,
    /// Axes of a lower number are homed before those of a higher one.
    pub order: u8,
}

/// Axes that are to find their switches.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HomeMove {
    /// Those that have a number, by index; axes beyond those of the controller are not looked at.
    pub axes: Vec<Option<HomeAxis>, 9>,
    /// The caller's mark.
    pub tag: u32,
}

/// Why a probe or homing was not begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SeekRefusal {
    /// This controller does not do that.
    Unknown,
    /// The input is already as it would be at the end, or there is no such input.
    Input,
    /// A number is out of its range, or there are not as many axes as the controller has.
    OutOfRange,
    /// The point lies outside the limits of travel.
    Travel {
        /// Index of the axis.
        axis: u8,
    },
}

impl core::fmt::Display for SeekRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Unknown => "the controller does not probe or home",
            Self::Input => "the input is already as it would be at the end",
            Self::OutOfRange => "a number is out of its range",
            Self::Travel { axis } => {
                return write!(f, "the point lies outside the travel of axis {axis}");
            }
        })
    }
}

/// How a probe ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProbeEnd {
    /// By its input.
    Tripped,
    /// At its target, without it.
    Missed,
    /// By a cancel, an abort, or the silence of its sender.
    Cancelled,
}

impl core::fmt::Display for ProbeEnd {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Tripped => "contact",
            Self::Missed => "no contact",
            Self::Cancelled => "cancelled",
        })
    }
}

/// What came of a probe.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProbeResult {
    /// Number of its item in the session.
    pub number: u32,
    /// Its tag.
    pub tag: u32,
    /// How it ended.
    pub end: ProbeEnd,
    /// Where the axes were when the input changed, nm; where they came to rest if it did not.
    pub position: Axes,
}

/// What an axis does while it is homed: see `HomePhase` (feature `home`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HomeStep {
    /// It is done, or has not been asked for.
    #[default]
    Done,
    /// Others come before it.
    Waits,
    /// Away from a switch that was closed at the start.
    Leaves,
    /// To the switch, fast.
    Seeks,
    /// Back from its edge.
    BacksOff,
    /// To the switch, slowly.
    Latches,
    /// To where it shall stand.
    Parks,
}

/// What has gone wrong with an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HomeTrouble {
    /// The switch has not closed within the way it was given.
    Missing,
    /// The switch is still closed after the way back.
    Stuck,
    /// A cancel, an abort, or the silence of its sender.
    Cancelled,
}

impl core::fmt::Display for HomeTrouble {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Missing => "the switch does not close",
            Self::Stuck => "the switch does not open",
            Self::Cancelled => "cancelled",
        })
    }
}

/// The axis that has ended homing: the coordinates are as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HomeFault {
    /// Its index.
    pub axis: u8,
    /// What it was doing.
    pub step: HomeStep,
    /// What has gone wrong.
    pub trouble: HomeTrouble,
}

/// How far homing is, or what came of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HomeReport {
    /// Number of its item in the session.
    pub number: u32,
    /// Its tag.
    pub tag: u32,
    /// Whether it is over.
    pub over: bool,
    /// What each axis does.
    pub steps: Vec<HomeStep, 9>,
    /// What has gone wrong, if so.
    pub fault: Option<HomeFault>,
}

#[cfg(feature = "probe")]
impl ProbeMove {
    /// The same for a core, from where the axes are before it.
    ///
    /// # Errors
    /// It has another number of axes, or a coordinate out of range.
    pub fn probe<S: Scalar, const N: usize>(
        &self,
        from: &[Coord; N],
    ) -> Result<Probe<S, N>, SeekRefusal> {
        if self.to.len() != N {
            return Err(SeekRefusal::OutOfRange);
        }
        let mut to = *from;
        for (slot, nm) in to.iter_mut().zip(&self.to) {
            if let Some(nm) = nm {
                *slot = coord(*nm)?;
            }
        }
        let input = match self.input {
            ProbeInput::Probe => Input::Probe,
            ProbeInput::Home(axis) => Input::Home(usize::from(axis)),
        };
        let feed = S::of(f64::from(self.feed) * 1.0e-3);
        Ok(Probe { to, feed, input, closes: self.closes })
    }
}

#[cfg(feature = "probe")]
fn coord(nm: i64) -> Result<Coord, SeekRefusal> {
    Coord::from_nm(nm).map_err(|_| SeekRefusal::OutOfRange)
}

#[cfg(feature = "probe")]
impl SeekRefusal {
    /// Why a core does not begin it; `None` if it may later.
    pub(super) fn of(error: &ProbeError) -> Option<Self> {
        Some(match error {
            ProbeError::Running | ProbeError::Held | ProbeError::Aborted => return None,
            ProbeError::Input => Self::Input,
            ProbeError::OutOfRange { .. } | ProbeError::Coordinate { .. } => Self::OutOfRange,
            ProbeError::Travel { axis, .. } => Self::Travel { axis: *axis as u8 },
        })
    }
}

#[cfg(feature = "probe")]
impl ProbeResult {
    pub(super) fn new<const N: usize>(number: u32, tag: u32, probed: &Probed<N>) -> Self {
        let end = match probed.outcome {
            Outcome::Tripped => ProbeEnd::Tripped,
            Outcome::Missed => ProbeEnd::Missed,
            Outcome::Cancelled => ProbeEnd::Cancelled,
        };
        let position = probed.position.iter().take(9).map(|at| at.to_nm()).collect();
        Self { number, tag, end, position }
    }
}

#[cfg(feature = "home")]
impl HomeMove {
    /// The same for a core.
    ///
    /// # Errors
    /// A coordinate out of range.
    pub fn home<S: Scalar, const N: usize>(&self) -> Result<[Option<AxisHome<S>>; N], SeekRefusal> {
        let mut axes = [None; N];
        for (slot, axis) in axes.iter_mut().zip(&self.axes) {
            let Some(axis) = axis else { continue };
            let speed = |um: f64| S::of(um * 1.0e-3);
            *slot = Some(AxisHome {
                fast: speed(f64::from(axis.fast)),
                slow: speed(f64::from(axis.slow)),
                reach: coord(i64::from(axis.reach) * 1000)?,
                back: coord(i64::from(axis.back) * 1000)?,
                at: coord(axis.at)?,
                park: axis.park.map(coord).transpose()?,
                order: axis.order,
            });
        }
        Ok(axes)
    }
}

#[cfg(feature = "home")]
impl From<HomePhase> for HomeStep {
    fn from(phase: HomePhase) -> Self {
        match phase {
            HomePhase::Done => Self::Done,
            HomePhase::Waits => Self::Waits,
            HomePhase::Leaves => Self::Leaves,
            HomePhase::Seeks => Self::Seeks,
            HomePhase::BacksOff => Self::BacksOff,
            HomePhase::Latches => Self::Latches,
            HomePhase::Parks => Self::Parks,
        }
    }
}

#[cfg(feature = "home")]
impl From<HomeFailure> for HomeFault {
    fn from(failure: HomeFailure) -> Self {
        let trouble = match failure.fault {
            crate::jog::HomeFault::Missing => HomeTrouble::Missing,
            crate::jog::HomeFault::Stuck => HomeTrouble::Stuck,
            crate::jog::HomeFault::Cancelled => HomeTrouble::Cancelled,
        };
        Self { axis: failure.axis as u8, step: failure.phase.into(), trouble }
    }
}
