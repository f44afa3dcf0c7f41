//! One piece of motion: a quintic per axis over a short time.

use super::interleave::point;
use super::setpoint::{Activity, Setpoint};
use crate::number::atomic::AtomicU32;
use crate::number::serial::NodeSerial;
use crate::number::shared::Shared;
use crate::number::{ArcLength, Coord, Scalar};
use core::sync::atomic::Ordering::Relaxed;

/// What follows a piece in its plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequel {
    /// The next piece, at speed.
    Motion,
    /// A stop that the program asks for, or its end.
    Stop,
    /// A stop because the plan knows no further.
    Starved,
}

/// The motion over one cell of the path.
#[derive(Clone, Copy, Debug)]
pub struct Piece<S, const N: usize> {
    /// Running number of the node it starts at.
    pub serial: NodeSerial,
    /// Tag of the block.
    pub tag: u32,
    /// Duration, s.
    pub time: S,
    /// Position at its start.
    pub origin: [Coord; N],
    /// Coefficients of t^1 .. t^5 per axis.
    pub axes: [[S; 5]; N],
    /// Arc length at its start.
    pub arc_length: ArcLength,
    /// Coefficients of t^1 .. t^4 of the arc length.
    pub path: [S; 4],
    /// What comes after it.
    pub sequel: Sequel,
    /// Whether its first servo cycle reports an event.
    pub event: bool,
}

/// In a slot, added to the sequel of a piece with an event.
const EVENT: u32 = 4;

impl<S: Scalar, const N: usize> Piece<S, N> {
    /// What the interrupt will give `t` seconds after the start.
    pub fn at(&self, t: S) -> Setpoint<S, N> {
        let slot = Slot::EMPTY;
        slot.store(self);
        slot.at(t)
    }
}

/// Place for a piece in memory that two contexts share.
pub struct Slot<S: Scalar, const N: usize> {
    serial: AtomicU32,
    tag: AtomicU32,
    sequel: AtomicU32,
    time: S::Shared,
    origin: [[AtomicU32; 2]; N],
    axes: [[S::Shared; 5]; N],
    arc_length: [AtomicU32; 2],
    path: [S::Shared; 4],
}

impl<S: Scalar, const N: usize> Slot<S, N> {
    #[allow(clippy::declare_interior_mutable_const)]
    pub const EMPTY: Self = Self {
        serial: AtomicU32::new(0),
        tag: AtomicU32::new(0),
        sequel: AtomicU32::new(0),
        time: S::Shared::ZERO,
        origin: [const { <[AtomicU32; 2] as Shared<Coord>>::ZERO }; N],
        axes: [const { [const { S::Shared::ZERO }; 5] }; N],
        arc_length: <[AtomicU32; 2] as Shared<ArcLength>>::ZERO,
        path: [const { S::Shared::ZERO }; 4],
    };

    pub fn store(&self, piece: &Piece<S, N>) {
        point();
        self.serial.store(piece.serial.raw(), Relaxed);
        self.tag.store(piece.tag, Relaxed);
        let event = if piece.event { EVENT } else { 0 };
        self.sequel.store(piece.sequel as u32 | event, Relaxed);
        self.time.store(piece.time);
        for i in 0..N {
            point();
            self.origin[i].store(piece.origin[i]);
            for (slot, value) in self.axes[i].iter().zip(piece.axes[i]) {
                slot.store(value);
            }
        }
        self.arc_length.store(piece.arc_length);
        for (slot, value) in self.path.iter().zip(piece.path) {
            slot.store(value);
        }
    }

    /// Running number of the node it starts at.
    #[inline]
    pub fn serial(&self) -> NodeSerial {
        NodeSerial::from_raw(self.serial.load(Relaxed))
    }

    /// Duration, s.
    #[inline]
    pub fn time(&self) -> S {
        self.time.load()
    }

    /// Whether its first servo cycle reports an event.
    #[inline]
    pub fn has_event(&self) -> bool {
        self.sequel.load(Relaxed) & EVENT != 0
    }

    /// Whether the motion stops at its end because the plan knows no further.
    #[inline]
    pub fn starves(&self) -> bool {
        self.sequel.load(Relaxed) == Sequel::Starved as u32
    }

    /// The setpoint `t` seconds after the start: position, velocity and acceleration by one Horner
    /// scheme with derivatives, 13 multiplications and 12 additions per axis, no division, no root.
    // Not inlined, the setpoint is copied once more: a third of a tick.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn at(&self, t: S) -> Setpoint<S, N> {
        let mut at = Setpoint {
            path_origin: self.arc_length.load(),
            tag: self.tag.load(Relaxed),
            ..Setpoint::REST
        };
        for i in 0..N {
            let [c1, c2, c3, c4, c5] = &self.axes[i];
            // Every sum takes in the one above it as it has just become: `d` runs one step of the scheme
            // ahead, `e` two.
            let mut p = c5.load();
            let mut d = p;
            let mut e = p;
            for c in [c4, c3, c2] {
                p = p * t + c.load();
                d = d * t + p;
                e = e * t + d;
            }
            p = p * t + c1.load();
            at.origin[i] = self.origin[i].load();
            at.offset[i] = p * t;
            at.velocity[i] = d * t + p;
            at.acceleration[i] = e + e;
        }
        let [c1, c2, c3, c4] = self.path.each_ref().map(Shared::load);
        let mut distance = c4;
        let mut speed = distance;
        for c in [c3, c2, c1] {
            distance = distance * t + c;
            speed = speed * t + distance;
        }
        at.path_offset = distance * t;
        at.path_speed = speed;
        let dwells = c1 == S::ZERO && c3 == S::ZERO && c4 == S::ZERO;
        at.activity = if dwells { Activity::Dwelling } else { Activity::Running };
        at
    }
}
