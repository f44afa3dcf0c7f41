//! Moves that end early on an input, and where exactly that came.

use super::axis::{AxisMotion, State};
use super::brake::Brake;
use super::plan::{Plan, Planned, caps_along, feed_along, stop_limits};
use super::ramp::{Caps, Motion};
use crate::block::range::{check_coordinates, in_range};
use crate::jog::JogError;
use crate::machine::{Config, Quantity};
use crate::number::{Coord, RangeError, Scalar};
use crate::servo::Input;
use core::array::from_fn;
use core::fmt;

/// A straight move that ends early when an input closes or opens: [`Planner::probe`](crate::Planner::probe).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Probe<S, const N: usize> {
    /// Where it ends if nothing comes.
    pub to: [Coord; N],
    /// Speed along the line, mm/s, as of a block: [`Quantity::Feed`].
    pub feed: S,
    /// What ends it.
    pub input: Input,
    /// Whether it ends when the input closes (towards the work: G38.2, G38.3, G31) or when it opens (away: G38.4, G38.5).
    pub closes: bool,
}

/// How a probe ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Outcome {
    /// By its input.
    Tripped,
    /// At its target, without it.
    Missed,
    /// By [`Controls::cancel_jog`](crate::Controls::cancel_jog) or an abort.
    Cancelled,
}

/// What came of a probe: [`Planner::probed`](crate::Planner::probed).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Probed<const N: usize> {
    /// Where the axes were when the input changed; where they came to rest if it did not.
    pub position: [Coord; N],
    /// How it ended.
    pub outcome: Outcome,
}

/// How far a probe goes on after its edge: [`Planner::probe_overshoot`](crate::Planner::probe_overshoot).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Overshoot<S> {
    /// Where the feed has been reached, mm along the line.
    pub at_feed: S,
    /// Anywhere, mm: where it is still being reached, the acceleration has to be taken back first.
    pub most: S,
}

/// Why a [`Probe`] was not taken: nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ProbeError {
    /// Something else moves the machine, or is about to, or is left to run.
    Running,
    /// A hold, a stop or an override of 0 is in force, or a pause waits for its resume.
    Held,
    /// An abort has not been acknowledged.
    Aborted,
    /// The input is already as it would be at the end, or there is no such input.
    Input,
    /// A number is not finite or out of its range.
    OutOfRange {
        /// Which number.
        quantity: Quantity,
        /// The value given, and the range.
        error: RangeError,
    },
    /// A coordinate is beyond `Coord::LIMIT_MM`.
    Coordinate {
        /// Index of the axis.
        axis: usize,
        /// The value given, and the range, mm.
        error: RangeError,
    },
    /// The point lies outside the limits of travel (feature `travel`).
    Travel {
        /// Index of the axis.
        axis: usize,
        /// The coordinate of the point, and the limits, mm.
        error: RangeError,
    },
}

impl From<JogError> for ProbeError {
    fn from(error: JogError) -> Self {
        match error {
            JogError::Aborted => Self::Aborted,
            JogError::OutOfRange { quantity, error } => Self::OutOfRange { quantity, error },
            JogError::Coordinate { axis, error } => Self::Coordinate { axis, error },
            JogError::Travel { axis, error } => Self::Travel { axis, error },
            JogError::Running | JogError::NoProgram => Self::Running,
        }
    }
}

impl fmt::Display for ProbeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Running => f.write_str("the machine moves, or has something left to run"),
            Self::Held => f.write_str("the machine is held; resume it first"),
            Self::Aborted => JogError::Aborted.fmt(f),
            Self::Input => f.write_str(
                "the input is already as it would be at the end, or there is none of this number",
            ),
            Self::OutOfRange { quantity, error } => JogError::OutOfRange { quantity, error }.fmt(f),
            Self::Coordinate { axis, error } => JogError::Coordinate { axis, error }.fmt(f),
            Self::Travel { axis, error } => JogError::Travel { axis, error }.fmt(f),
        }
    }
}

impl core::error::Error for ProbeError {}

impl<S: Scalar, const N: usize> Probe<S, N> {
    /// Whether every number lies in its range.
    pub(crate) fn check(&self) -> Result<(), JogError> {
        check_coordinates(&self.to)?;
        in_range(Quantity::Feed, self.feed)?;
        Ok(())
    }
}

/// Polynomial of constant jerk from a motion on, after a time in servo cycles.
fn moved(motion: &Motion<f64>, jerk: f64, time: f64) -> f64 {
    ((jerk * time / 3.0 + motion.acceleration) * time * 0.5 + motion.velocity) * time
}

impl<const N: usize> Plan<N> {
    /// Where the axes are at its beginning, and how they move.
    fn states(&self) -> [State; N] {
        self.axes.each_ref().map(AxisMotion::start)
    }

    /// The shortest stop on the line under way, which has this direction; if there is none, on as before.
    pub fn halted<S: Scalar>(&self, unit: &[f64; N], config: &Config<S, N>) -> Planned<N> {
        let states = self.states();
        let over = |of: fn(&Motion<f64>) -> f64| -> f64 {
            states.iter().zip(unit).map(|(state, unit)| of(&state.motion) * unit).sum()
        };
        let from = Motion {
            velocity: over(|motion| motion.velocity),
            acceleration: over(|motion| motion.acceleration),
        };
        let caps = caps_along(unit, &stop_limits(config), config.cycle);
        match Brake::new(&from, &caps) {
            Some(brake) if !brake.phases().is_empty() => {
                let axes = from_fn(|i| AxisMotion::braked(states[i], &brake, unit[i]));
                Planned { plan: Self { axes, straight: true }, whole: true }
            }
            _ => Planned { plan: self.clone(), whole: false },
        }
    }

    /// Where it is `whole` servo cycles and a fraction after its beginning; up to one before that, with the jerks that the axes had
    /// then.
    pub fn place_at(&self, whole: i64, fraction: f64, before: &[f64; N]) -> [Coord; N] {
        if whole < 0 {
            let states = self.states();
            let time = (whole as f64 + fraction).max(-1.0);
            return from_fn(|i| states[i].at.plus(moved(&states[i].motion, before[i], time)));
        }
        let passed = whole.min(i64::from(u32::MAX)) as u32;
        from_fn(|i| {
            let mut cursor = self.axes[i].cursor();
            cursor.advance(passed);
            let way = cursor.distance + moved(&cursor.motion, cursor.jerk(), fraction);
            self.axes[i].start().at.plus(way)
        })
    }

    /// Jerks of the axes in the servo cycle before so many have passed.
    pub fn jerks_before(&self, cycles: u32) -> [f64; N] {
        self.axes.each_ref().map(|axis| {
            let mut cursor = axis.cursor();
            cursor.advance(cycles.saturating_sub(1));
            cursor.jerk()
        })
    }
}

/// Intervals in which the acceleration of a start is looked at.
const PARTS: u32 = 16;

impl<S: Scalar> Overshoot<S> {
    /// Along a direction that is not zero, at a feed in mm per cycle, of a stop that begins so many cycles after the edge.
    ///
    /// Where the feed is still being reached, speed and acceleration meet `v + a^2 / 2 j <= feed` with the jerk of the start, and
    /// the stop is longer the greater either of them is.
    pub fn new<const N: usize>(
        direction: &[f64; N],
        feed: f64,
        cycles: u32,
        config: &Config<S, N>,
    ) -> Self {
        let start = caps_along(direction, &config.limits, config.cycle);
        let stop = caps_along(direction, &stop_limits(config), config.cycle);
        let feed = feed_along(direction, feed, config).min(start.velocity);
        let wait = feed * f64::from(cycles);
        let at = |velocity: f64, acceleration: f64, caps: &Caps<f64>| {
            let from = Motion { velocity: velocity.max(0.0), acceleration };
            Brake::new(&from, caps).map_or(0.0, |brake| brake.distance(&from))
        };
        let peak = start.acceleration.min(libm::sqrt(feed * start.jerk));
        let most = (0..PARTS).fold(0.0, |most: f64, part| {
            let [low, high] =
                [part, part + 1].map(|part| peak * f64::from(part) / f64::from(PARTS));
            most.max(at(feed - low * low / (2.0 * start.jerk), high, &stop))
        });
        Self { at_feed: S::of(wait + at(feed, 0.0, &stop)), most: S::of(wait + most) }
    }
}
