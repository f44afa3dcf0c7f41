//! One piece of motion: a quintic per axis over a short time.

use super::interleave::point;
use super::setpoint::{Activity, Place, Setpoint};
use crate::number::atomic::AtomicU32;
use crate::number::serial::NodeSerial;
use crate::number::shared::Shared;
use crate::number::{ArcLength, Coord, Length, Scalar};
use core::array::from_fn;
use core::sync::atomic::Ordering::Relaxed;

/// What follows a piece in its plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequel {
    /// The next piece, at speed.
    Motion,
    /// The next piece, at speed, over the same cell: no plan branches off there.
    Within,
    /// A stop that the program asks for, or its end.
    Stop,
    /// A stop because the plan knows no further.
    Starved,
    /// The next piece of a jog, or its end.
    #[cfg(feature = "jog")]
    Jog = 8,
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

/// Halvings of a piece's time that find a place in it to less than rounding.
#[cfg(feature = "outputs")]
const HALVINGS: u32 = 40;

/// In a slot, added to the sequel of a piece with an event.
const EVENT: u32 = 4;

/// Times that are one but for rounding differ by less than this share: those of a cell and of its half do not.
const SAME_TIME: f64 = 1.0e-3;
/// What rounding makes of a velocity, as a share of the speed, is less than this.
const ROUNDED: f64 = 1.0e-4;

/// Pieces meet, in `f64`, within this, in mm and mm/s and as a share of velocity and acceleration.
#[cfg(debug_assertions)]
const MET: f64 = 1.0e-8;

/// What a piece that is run slower has of its own.
#[derive(Clone, Copy, Debug)]
pub struct Slower<S> {
    /// Running number of the node it starts at.
    pub serial: NodeSerial,
    /// Arc length at its start.
    pub arc_length: ArcLength,
    /// Duration, s.
    pub time: S,
}

impl<S: Scalar, const N: usize> Piece<S, N> {
    /// What the interrupt will give `t` seconds after the start.
    pub fn at(&self, t: S) -> Setpoint<S, N> {
        let slot = Slot::EMPTY;
        slot.store(self);
        slot.at(t, false)
    }

    /// Where it is `t` seconds after its start. In `f64`: what is rounded in a place at which another piece begins would be felt
    /// as jerk.
    pub fn place(&self, t: S) -> [Coord; N] {
        let t = t.to_f64();
        from_fn(|i| {
            let offset = self.axes[i].iter().rev().fold(0.0, |sum, c| (sum + c.to_f64()) * t);
            self.origin[i].plus(offset)
        })
    }

    /// Makes a piece that comes to rest do so exactly at a place: what its polynomials have lost to rounding (in
    /// `f32`, a ten-millionth of the cell's length) is made up for at its start, where the motion is fast and
    /// pieces meet within rounding anyway.
    #[inline(never)]
    pub fn end_at(&mut self, place: &[Coord; N]) {
        let end = self.at(self.time);
        for (i, (origin, place)) in self.origin.iter_mut().zip(place).enumerate() {
            let missed = place.raw().wrapping_sub(end.position(i).raw());
            *origin = Coord::from_raw(origin.raw().wrapping_add(missed));
        }
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

    #[inline(never)]
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

    /// Stores what another slot has over a cell that is passed, run by a clock that goes evenly at a rate.
    #[inline(never)]
    pub fn store_slower(&self, agreed: &Self, rate: S, slower: &Slower<S>) {
        point();
        self.serial.store(slower.serial.raw(), Relaxed);
        self.tag.store(agreed.tag.load(Relaxed), Relaxed);
        self.sequel.store(Sequel::Motion as u32, Relaxed);
        self.time.store(slower.time);
        let mut powers = [rate; 5];
        for k in 1..5 {
            powers[k] = powers[k - 1] * rate;
        }
        for i in 0..N {
            point();
            let origin: Coord = agreed.origin[i].load();
            self.origin[i].store(origin);
            for ((slot, value), power) in self.axes[i].iter().zip(&agreed.axes[i]).zip(powers) {
                slot.store(value.load() * power);
            }
        }
        self.arc_length.store(slower.arc_length);
        for ((slot, value), power) in self.path.iter().zip(&agreed.path).zip(powers) {
            slot.store(value.load() * power);
        }
    }

    /// Whether what it has is a piece, but for rounding.
    pub fn is_about(&self, piece: &Piece<S, N>) -> bool {
        let same = self.serial() == piece.serial
            && self.tag.load(Relaxed) == piece.tag
            && self.time() == piece.time
            && self.sequel.load(Relaxed) == piece.sequel as u32;
        let times = [S::ZERO, piece.time * S::of(0.5), piece.time];
        // What slows down to next to nothing is rounded as what it was.
        let fastest = times.iter().fold(S::ZERO, |most, t| most.greatest(piece.at(*t).path_speed));
        let slack = S::of(ROUNDED) * fastest;
        let near = |t: S| {
            let (here, there) = (self.at(t, false), piece.at(t));
            (0..N).all(|i| {
                let off = here.position(i).minus::<S>(there.position(i)).abs();
                let faster = (here.velocity[i] - there.velocity[i]).abs();
                // Near a rest that is less than the unit of a position.
                off <= slack * piece.time + Length::UNIT.to_mm::<S>() && faster <= slack
            })
        };
        same && times.into_iter().all(near)
    }

    /// Whether it has what comes over a cell that begins at a place, the motion goes on behind it, and it takes a time, s.
    pub fn passes(&self, place: &[Coord; N], time: S) -> bool {
        let begins = |(origin, at): (&[AtomicU32; 2], &Coord)| {
            let origin: Coord = origin.load();
            origin == *at
        };
        self.sequel.load(Relaxed) == Sequel::Motion as u32
            && self.origin.iter().zip(place).all(begins)
            && (self.time() - time).abs() <= time * S::of(SAME_TIME)
    }

    /// Running number of the node it starts at.
    #[inline]
    pub fn serial(&self) -> NodeSerial {
        NodeSerial::from_raw(self.serial.load(Relaxed))
    }

    /// Four numbers that are kept while it holds no piece.
    #[inline]
    pub fn four(&self) -> [S; 4] {
        self.path.each_ref().map(Shared::load)
    }

    /// Keeps them.
    #[inline]
    pub fn keep_four(&self, values: [S; 4]) {
        for (slot, value) in self.path.iter().zip(values) {
            slot.store(value);
        }
    }

    /// Five numbers more.
    #[inline]
    pub fn five(&self) -> [S; 5] {
        self.axes.first().map_or([S::ZERO; 5], |axis| axis.each_ref().map(Shared::load))
    }

    /// Keeps them.
    #[inline]
    pub fn keep_five(&self, values: [S; 5]) {
        for (slot, value) in self.axes.iter().flatten().zip(values) {
            slot.store(value);
        }
    }

    /// Two numbers more.
    #[inline]
    pub fn two(&self) -> [S; 2] {
        match (self.axes.get(1), self.origin.first()) {
            (Some([first, second, ..]), _) => [first.load(), second.load()],
            // With one axis there is not room enough but in a place for a coordinate.
            (None, Some(origin)) => {
                let second: Coord = origin.load();
                [self.time.load(), S::of(f64::from_bits(second.raw().cast_unsigned()))]
            }
            _ => [S::ZERO; 2],
        }
    }

    /// Keeps them.
    #[inline]
    pub fn keep_two(&self, [first, second]: [S; 2]) {
        match (self.axes.get(1), self.origin.first()) {
            (Some([one, other, ..]), _) => {
                one.store(first);
                other.store(second);
            }
            (None, Some(origin)) => {
                self.time.store(first);
                origin.store(Coord::from_raw(second.to_f64().to_bits().cast_signed()));
            }
            _ => {}
        }
    }

    /// Duration, s.
    #[inline]
    pub fn time(&self) -> S {
        self.time.load()
    }

    /// Arc length at its start.
    #[cfg(feature = "outputs")]
    pub fn arc_length(&self) -> ArcLength {
        self.arc_length.load()
    }

    /// Arc length `t` seconds after its start.
    #[cfg(feature = "outputs")]
    pub fn arc_length_at(&self, t: S) -> ArcLength {
        self.arc_length().plus(self.distance(t))
    }

    /// Whether it stands still.
    #[cfg(feature = "outputs")]
    pub fn stands(&self) -> bool {
        self.path.iter().all(|c| c.load() == S::ZERO)
    }

    /// How far it has gone after `t` seconds, mm.
    #[cfg(feature = "outputs")]
    fn distance(&self, t: S) -> S {
        self.path.iter().rev().fold(S::ZERO, |sum, c| (sum + c.load()) * t)
    }

    /// When it gets to a place, s from its start; its end if it does not.
    #[cfg(feature = "outputs")]
    pub fn time_at(&self, place: ArcLength) -> S {
        let units = place.raw().wrapping_sub(self.arc_length().raw());
        let distance = S::from_i64(units) * S::of(1.0e-7);
        let (mut from, mut to) = (S::ZERO, self.time());
        if !(self.distance(to) > distance) {
            return to;
        }
        for _ in 0..HALVINGS {
            let middle = (from + to) * S::of(0.5);
            if self.distance(middle) < distance {
                from = middle;
            } else {
                to = middle;
            }
        }
        to
    }

    /// Whether it begins as another piece is `t` seconds after its start, or at rest if there is none: in `f64`, at the place, unless that is
    /// set, at the velocity, and at an acceleration that leaps by so much at most, mm/s2. What rounding makes of `f32` says nothing.
    #[cfg(debug_assertions)]
    pub fn follows(&self, before: Option<(&Self, S)>, leap: S) -> bool {
        if S::EPSILON > S::of(f64::EPSILON) {
            return true;
        }
        let begins = self.at(S::ZERO, false);
        let Some((before, t)) = before else {
            return begins.velocity == [S::ZERO; N] && begins.acceleration == [S::ZERO; N];
        };
        let ends = before.at(t, false);
        (0..N).all(|i| {
            let off: S = ends.position(i).minus(begins.position(i));
            let faster = ends.velocity[i] - begins.velocity[i];
            let harder = ends.acceleration[i] - begins.acceleration[i];
            let rounded = S::of(MET) * (S::ONE + begins.velocity[i].abs());
            (off.abs() <= S::of(MET) || self.has_event())
                && faster.abs() <= rounded
                && harder.abs() <= leap + S::of(MET) * begins.acceleration[i].abs()
        })
    }

    /// Whether its first servo cycle reports an event.
    #[inline]
    pub fn has_event(&self) -> bool {
        self.sequel.load(Relaxed) & EVENT != 0
    }

    /// Whether the next piece is over the same cell.
    #[inline]
    pub fn is_within(&self) -> bool {
        self.sequel.load(Relaxed) == Sequel::Within as u32
    }

    /// Whether the motion stops at its end because the plan knows no further.
    #[inline]
    pub fn starves(&self) -> bool {
        self.sequel.load(Relaxed) == Sequel::Starved as u32
    }

    /// The setpoint `t` seconds after the start: position, velocity and acceleration by one Horner
    /// scheme with derivatives, 13 multiplications and 12 additions per axis, no division, no root. With `event` its
    /// activity is one.
    #[inline(never)]
    pub fn at(&self, t: S, event: bool) -> Setpoint<S, N> {
        let axes: [[S; 3]; N] = from_fn(|i| {
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
            [p * t, d * t + p, e + e]
        });
        let [c1, c2, c3, c4] = self.path.each_ref().map(Shared::load);
        let mut distance = c4;
        let mut speed = distance;
        for c in [c3, c2, c1] {
            distance = distance * t + c;
            speed = speed * t + distance;
        }
        let dwells = c1 == S::ZERO && c3 == S::ZERO && c4 == S::ZERO;
        let still = Activity::Dwelling;
        #[cfg(feature = "jog")]
        let still =
            if self.sequel.load(Relaxed) == Sequel::Jog as u32 { Activity::Jogging } else { still };
        #[cfg(not(feature = "home"))]
        let what_event = || Activity::Event;
        #[cfg(feature = "home")]
        let what_event = || match self.sequel.load(Relaxed) {
            sequel if sequel == Sequel::Jog as u32 | EVENT => Activity::Set,
            _ => Activity::Event,
        };
        Setpoint {
            origin: self.origin.each_ref().map(Shared::load),
            offset: axes.map(|[offset, ..]| offset),
            velocity: axes.map(|[_, velocity, _]| velocity),
            acceleration: axes.map(|[.., acceleration]| acceleration),
            path_origin: self.arc_length.load(),
            path_offset: distance * t,
            path_speed: speed,
            tag: self.tag.load(Relaxed),
            activity: if event {
                what_event()
            } else if dwells {
                still
            } else {
                Activity::Running
            },
        }
    }

    /// Writes the place of [`Slot::at`] alone, to the bit.
    #[inline(never)]
    pub fn place(&self, t: S, place: &mut Place<S, N>) {
        for i in 0..N {
            let [c1, c2, c3, c4, c5] = &self.axes[i];
            let mut p = c5.load();
            for c in [c4, c3, c2, c1] {
                p = p * t + c.load();
            }
            place.origin[i] = self.origin[i].load();
            place.offset[i] = p * t;
        }
        let [c1, c2, c3, c4] = &self.path;
        let mut distance = c4.load();
        for c in [c3, c2, c1] {
            distance = distance * t + c.load();
        }
        place.path_origin = self.arc_length.load();
        place.path_offset = distance * t;
        place.tag = self.tag.load(Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece() -> Piece<f64, 2> {
        Piece {
            serial: NodeSerial::from_raw(u32::MAX),
            tag: 42,
            time: 0.25,
            origin: [Coord::from_raw(-5), Coord::from_raw(i64::MAX)],
            axes: [[1.0, -2.0, 3.0, -4.0, 5.0], [0.5, 0.25, -0.125, 2.0, -1.0]],
            arc_length: ArcLength::from_raw(1 << 40),
            path: [1.0, 2.0, -3.0, 0.5],
            sequel: Sequel::Starved,
            event: true,
        }
    }

    #[test]
    fn a_piece_is_evaluated_with_its_derivatives() {
        let piece = piece();
        for t in [0.0, 0.1, 0.25] {
            let setpoint = piece.at(t);
            for (axis, c) in piece.axes.iter().enumerate() {
                let sum = |term: &dyn Fn(f64, i32) -> f64| -> f64 {
                    c.iter().zip(1..).map(|(c, k)| c * term(f64::from(k), k)).sum()
                };
                let offset = sum(&|_, k| t.powi(k));
                let velocity = sum(&|n, k| n * t.powi(k - 1));
                let acceleration = sum(&|n, k| n * (n - 1.0) * t.powi((k - 2).max(0)));
                assert_eq!(setpoint.origin[axis], piece.origin[axis]);
                assert!((setpoint.offset[axis] - offset).abs() < 1e-14);
                assert!((setpoint.velocity[axis] - velocity).abs() < 1e-14);
                assert!((setpoint.acceleration[axis] - acceleration).abs() < 1e-13);
            }
            let [a, b, c, d] = piece.path;
            let offset = t * (a + t * (b + t * (c + t * d)));
            assert!((setpoint.path_offset - offset).abs() < 1e-14);
            let speed = a + t * (2.0 * b + t * (3.0 * c + t * 4.0 * d));
            assert!((setpoint.path_speed - speed).abs() < 1e-14);
            assert_eq!((setpoint.tag, setpoint.activity), (42, Activity::Running));
        }
    }

    #[test]
    fn a_place_is_that_of_the_setpoint_to_the_bit() {
        let slot = Slot::EMPTY;
        slot.store(&piece());
        for t in [0.0, 0.1, 0.25] {
            let (at, mut place) = (slot.at(t, true), Place::ZERO);
            slot.place(t, &mut place);
            assert_eq!(at.activity, Activity::Event);
            assert_eq!((at.origin, at.offset), (place.origin, place.offset));
            assert_eq!((at.path_origin, at.path_offset), (place.path_origin, place.path_offset));
            assert_eq!(at.tag, place.tag);
        }
    }

    #[test]
    fn a_slot_gives_back_what_was_stored() {
        let slot = Slot::EMPTY;
        slot.store(&piece());
        assert_eq!((slot.serial(), slot.time()), (NodeSerial::from_raw(u32::MAX), 0.25));
        assert!(slot.has_event());
        slot.store(&Piece { event: false, ..piece() });
        assert!(slot.starves() && !slot.has_event());
        slot.store(&Piece { sequel: Sequel::Motion, event: false, ..piece() });
        assert!(!slot.starves() && !slot.has_event());
    }

    /// What is kept in a slot that holds no piece, to the bit, with one axis and with more.
    #[test]
    fn a_slot_without_a_piece_keeps_numbers() {
        fn bits<const M: usize>(values: [f32; M]) -> [u32; M] {
            values.map(f32::to_bits)
        }
        fn keep<const N: usize>() {
            let slot = Slot::<f32, N>::EMPTY;
            let number = |k: u32| f32::from_bits(0x3f80_0001 + 77 * k);
            slot.keep_four([0, 1, 2, 3].map(number));
            slot.keep_five([4, 5, 6, 7, 8].map(number));
            slot.keep_two([9, 10].map(|k| -number(k)));
            assert_eq!(bits(slot.four()), bits([0, 1, 2, 3].map(number)));
            assert_eq!(bits(slot.five()), bits([4, 5, 6, 7, 8].map(number)));
            assert_eq!(bits(slot.two()), bits([9, 10].map(|k| -number(k))));
        }
        keep::<1>();
        keep::<2>();
        keep::<9>();
    }

    /// The second half of a motion follows the first; not with a leap of place, velocity or acceleration, nor from rest. Places may be set.
    #[cfg(debug_assertions)]
    #[test]
    fn a_piece_follows_the_one_that_ends_as_it_begins() {
        let whole = Piece { event: false, origin: [Coord::ZERO; 2], ..piece() };
        let first = Slot::EMPTY;
        first.store(&whole);
        let t = 0.1;
        let middle = whole.at(t);
        let half = Piece {
            origin: whole.place(t),
            axes: from_fn(|i| [middle.velocity[i], middle.acceleration[i] * 0.5, 0.0, 0.0, 0.0]),
            ..whole
        };
        let follows = |next: &Piece<f64, 2>| {
            let second = Slot::EMPTY;
            second.store(next);
            second.follows(Some((&first, t)), 1.0e-3)
        };
        assert!(follows(&half));
        let mut leaps = [half; 3];
        leaps[0].origin[1] = leaps[0].origin[1].plus(1.0e-6);
        leaps[1].axes[1][0] += 1.0e-6;
        leaps[2].axes[1][1] += 1.0e-2;
        assert!(leaps.iter().all(|leap| !follows(leap)));
        assert!(follows(&Piece { event: true, ..leaps[0] }));
        let moves = Slot::EMPTY;
        moves.store(&half);
        assert!(!moves.follows(None, 1.0e-3));
        let starts = Slot::EMPTY;
        starts.store(&Piece { axes: [[0.0, 0.0, 3.0, 0.0, 0.0]; 2], ..whole });
        assert!(starts.follows(None, 1.0e-3));
    }

    /// A path that stands still for a time: its arc length has no motion.
    #[test]
    fn a_standstill_is_a_dwell() {
        let still = Piece { axes: [[0.0; 5]; 2], path: [0.0; 4], ..piece() };
        assert_eq!(still.at(0.1).activity, Activity::Dwelling);
    }
}
