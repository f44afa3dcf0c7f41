//! One piece of motion: a quintic per axis over a short time.

use super::setpoint::{Activity, Setpoint};
use crate::number::shared::Shared;
use crate::number::{Coord, Scalar};
use core::array::from_fn;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

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

impl Sequel {
    const ALL: [Self; 3] = [Self::Motion, Self::Stop, Self::Starved];
}

/// The motion over one cell of the path.
#[derive(Clone, Copy, Debug)]
pub struct Piece<S, const N: usize> {
    /// Running number of the node it starts at.
    pub serial: u32,
    /// Tag of the block.
    pub tag: u32,
    /// Duration, s.
    pub time: S,
    /// Position at its start.
    pub origin: [Coord; N],
    /// Coefficients of t^1 .. t^5 per axis.
    pub axes: [[S; 5]; N],
    /// Arc length at its start.
    pub way: Coord,
    /// Coefficients of t^1 .. t^4 of the arc length.
    pub path: [S; 4],
    /// What comes after it.
    pub sequel: Sequel,
}

impl<S: Scalar, const N: usize> Piece<S, N> {
    /// The setpoint `t` seconds after the start: 12 multiplications and as many additions per
    /// axis, no division, no root.
    #[inline]
    pub fn at(&self, t: S) -> Setpoint<S, N> {
        let (two, three, four, five) = (S::of(2.0), S::of(3.0), S::of(4.0), S::of(5.0));
        let (six, twelve, twenty) = (S::of(6.0), S::of(12.0), S::of(20.0));
        let p = &self.path;
        Setpoint {
            origin: self.origin,
            offset: from_fn(|i| {
                let c = &self.axes[i];
                ((((c[4] * t + c[3]) * t + c[2]) * t + c[1]) * t + c[0]) * t
            }),
            velocity: from_fn(|i| {
                let c = &self.axes[i];
                (((five * c[4] * t + four * c[3]) * t + three * c[2]) * t + two * c[1]) * t + c[0]
            }),
            acceleration: from_fn(|i| {
                let c = &self.axes[i];
                ((twenty * c[4] * t + twelve * c[3]) * t + six * c[2]) * t + two * c[1]
            }),
            path_origin: self.way,
            path_offset: (((p[3] * t + p[2]) * t + p[1]) * t + p[0]) * t,
            path_speed: ((four * p[3] * t + three * p[2]) * t + two * p[1]) * t + p[0],
            tag: self.tag,
            activity: if self.is_dwell() { Activity::Dwelling } else { Activity::Running },
        }
    }

    fn is_dwell(&self) -> bool {
        self.path[0] == S::ZERO && self.path[2] == S::ZERO && self.path[3] == S::ZERO
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
    way: [AtomicU32; 2],
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
        way: <[AtomicU32; 2] as Shared<Coord>>::ZERO,
        path: [const { S::Shared::ZERO }; 4],
    };

    pub fn store(&self, piece: &Piece<S, N>) {
        self.serial.store(piece.serial, Relaxed);
        self.tag.store(piece.tag, Relaxed);
        self.sequel.store(piece.sequel as u32, Relaxed);
        self.time.store(piece.time);
        for i in 0..N {
            self.origin[i].store(piece.origin[i]);
            for (slot, value) in self.axes[i].iter().zip(piece.axes[i]) {
                slot.store(value);
            }
        }
        self.way.store(piece.way);
        for (slot, value) in self.path.iter().zip(piece.path) {
            slot.store(value);
        }
    }

    pub fn load(&self) -> Piece<S, N> {
        let sequel = self.sequel.load(Relaxed) as usize;
        Piece {
            serial: self.serial.load(Relaxed),
            tag: self.tag.load(Relaxed),
            time: self.time.load(),
            origin: from_fn(|i| self.origin[i].load()),
            axes: from_fn(|i| from_fn(|k| self.axes[i][k].load())),
            way: self.way.load(),
            path: from_fn(|k| self.path[k].load()),
            sequel: Sequel::ALL.get(sequel).copied().unwrap_or(Sequel::Stop),
        }
    }
}
