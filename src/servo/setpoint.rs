//! What a servo cycle gets.

use crate::number::{ArcLength, Coord, Scalar};

/// What the interpolator is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Activity {
    /// At rest: nothing to run.
    #[default]
    Idle,
    /// In motion.
    Running,
    /// In a dwell, or in what is left of the time that an event takes.
    Dwelling,
    /// At rest at an event of the program ([`Motion::Event`](crate::Motion::Event)), whose tag the
    /// setpoint has: now is the time to do what it stands for. For one servo cycle.
    Event,
    /// At rest, in other coordinates than before (feature `home`): the machine has not moved, and what counts steps counts on from this
    /// position. For one servo cycle.
    Set,
    /// In a jog (feature `jog`): off the path, whose arc length and speed do not change.
    Jogging,
}

/// Where every axis should be at one servo cycle, and how it moves there.
///
/// The position is `origin + offset`: the origin in fixed point, the offset small, so that an
/// `f32` keeps fractions of a nanometre.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct Setpoint<S, const N: usize> {
    /// Fixed-point part of the position.
    pub origin: [Coord; N],
    /// What is to be added to it, mm (degrees on a rotary axis).
    pub offset: [S; N],
    /// Velocity per axis, mm/s.
    pub velocity: [S; N],
    /// Acceleration per axis, mm/s2.
    pub acceleration: [S; N],
    /// Arc length since the start: fixed-point part.
    pub path_origin: ArcLength,
    /// What is to be added to it, mm.
    pub path_offset: S,
    /// Speed along the path, mm/s.
    pub path_speed: S,
    /// Tag of the block under way (of the last one when idle).
    pub tag: u32,
    /// What the interpolator is doing.
    pub activity: Activity,
}

impl<S: Scalar, const N: usize> Setpoint<S, N> {
    /// At rest in the origin.
    pub(crate) const REST: Self = Self {
        origin: [Coord::ZERO; N],
        offset: [S::ZERO; N],
        velocity: [S::ZERO; N],
        acceleration: [S::ZERO; N],
        path_origin: ArcLength::ZERO,
        path_offset: S::ZERO,
        path_speed: S::ZERO,
        tag: 0,
        activity: Activity::Idle,
    };

    /// Position of an axis in mm, for hosts with fast `f64`; 0 for an axis that does not exist.
    pub fn position_mm(&self, axis: usize) -> f64 {
        match (self.origin.get(axis), self.offset.get(axis)) {
            (Some(origin), Some(offset)) => origin.to_mm() + offset.to_f64(),
            _ => 0.0,
        }
    }

    /// Position of an axis in fixed point; zero for an axis that does not exist.
    pub fn position(&self, axis: usize) -> Coord {
        match (self.origin.get(axis), self.offset.get(axis)) {
            (Some(origin), Some(offset)) => origin.plus(*offset),
            _ => Coord::ZERO,
        }
    }

    /// Position of an axis in nanometres, rounded; 0 for an axis that does not exist.
    pub fn position_nm(&self, axis: usize) -> i64 {
        self.position(axis).to_nm()
    }

    /// Arc length since the start, mm.
    pub fn path_mm(&self) -> f64 {
        self.path_origin.to_mm() + self.path_offset.to_f64()
    }
}

/// A place on the path, as in a [`Setpoint`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<S, const N: usize> {
    pub origin: [Coord; N],
    pub offset: [S; N],
    pub path_origin: ArcLength,
    pub path_offset: S,
    pub tag: u32,
}

impl<S: Scalar, const N: usize> Place<S, N> {
    /// The origin.
    pub const ZERO: Self = Self {
        origin: [Coord::ZERO; N],
        offset: [S::ZERO; N],
        path_origin: ArcLength::ZERO,
        path_offset: S::ZERO,
        tag: 0,
    };

    /// At rest there.
    #[inline]
    pub fn setpoint(&self) -> Setpoint<S, N> {
        let Self { origin, offset, path_origin, path_offset, tag } = *self;
        Setpoint { origin, offset, path_origin, path_offset, tag, ..Setpoint::REST }
    }
}
