//! Outputs in time with the path: what is to switch where, one queue per output, beside the pieces (feature `outputs`).
//!
//! The planner writes entries, the interrupt takes them; of each queue it looks at the first only. An entry
//! is a place on the path by its arc length, which every setpoint has: so it does not matter which plan the motion
//! is on, how fast it is or whether it has rested. Where a time before a place counts, the place depends on the
//! plan, and an entry has one for either plan buffer.
//!
//! Where an answer to a command has cut a cell that is not straight, its parts are a little longer or shorter than the whole,
//! as arc lengths go, and all that is behind has shifted. So places of entries are those of the path as it was cut first, and of
//! either plan it is known by how much it has shifted.
//!
//! # Orderings
//!
//! An entry is written before `ready` is stored with release, and read after that is loaded with acquire; it is written over only
//! after `done`, stored with release behind the last read, has been loaded with acquire. The place for the plan buffer that
//! is not being executed is written before the plan in it is offered, and read after that is taken: the pair of
//! [`super::link`] orders them. What an abort drops is told by `void`, which is stored before `ready` goes there.

use super::interleave::point;
use crate::block::Trigger;
use crate::machine::{ANALOGUE, DIGITAL, POWERS, SWITCHES};
use crate::number::atomic::AtomicU32;
use crate::number::serial::Serial;
use crate::number::shared::Shared;
use crate::number::{ArcLength, Scalar};
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};

/// Outputs that have a queue of switches.
pub const LINES: usize = DIGITAL + ANALOGUE;
/// Near a rest a place is taken for its own from this distance on, in units of arc length, and a share of the piece:
/// what sums of lengths and polynomials round.
pub const ZONE: i64 = 1_000;
/// Most servo cycles that an entry waits.
pub const MOST_WAIT: u32 = u32::MAX >> 2;

/// What is numbered: entries of a queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entries {}

/// Running number of an entry.
pub type EntrySerial = Serial<Entries>;

/// When the motion has passed a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passing {
    /// When it leaves it: not at a rest there.
    Leaving,
    /// When it gets there: at a rest there too.
    Arriving,
    /// At an event, wherever that is.
    Event,
    /// When it leaves it, or when the planner says that it does not: the end of a standstill.
    Ending,
}

impl From<Trigger> for Passing {
    fn from(trigger: Trigger) -> Self {
        match trigger {
            Trigger::Start => Self::Leaving,
            Trigger::End => Self::Arriving,
            Trigger::Rest => Self::Event,
        }
    }
}

impl Passing {
    /// Of its number.
    pub const fn from_raw(raw: u32) -> Self {
        match raw & 3 {
            0 => Self::Leaving,
            1 => Self::Arriving,
            2 => Self::Event,
            _ => Self::Ending,
        }
    }
}

/// An entry as it is written: `M` values.
#[derive(Clone, Copy, Debug)]
pub struct Item<S, const M: usize> {
    pub passing: Passing,
    /// Place on the path, of either plan; until it is known, the place on the programmed path.
    pub place: i64,
    /// Standstills before that place; of [`Passing::Event`], the number of the event.
    pub order: u32,
    /// Servo cycles from the place on, and a part of one; until the place is known, the offset.
    pub wait: u32,
    pub part: S,
    pub values: [S; M],
}

/// Place for an item.
pub struct Entry<S: Scalar, const M: usize> {
    places: [[AtomicU32; 2]; 2],
    /// As in [`Item`]; then the servo cycle in which it is due.
    pub order: AtomicU32,
    /// [`Passing`], and four times the cycles to wait.
    pub kind: AtomicU32,
    /// As in [`Item`]; then when in the servo cycle it is due.
    pub part: S::Shared,
    pub values: [S::Shared; M],
}

impl<S: Scalar, const M: usize> Entry<S, M> {
    #[allow(clippy::declare_interior_mutable_const)]
    const EMPTY: Self = Self {
        places: [const { <[AtomicU32; 2] as Shared<ArcLength>>::ZERO }; 2],
        order: AtomicU32::new(0),
        kind: AtomicU32::new(0),
        part: S::Shared::ZERO,
        values: [const { S::Shared::ZERO }; M],
    };

    /// Where it is in a plan.
    pub fn place(&self, plan: usize) -> ArcLength {
        self.places[plan & 1].load()
    }
}

/// A queue of `DEPTH` entries.
pub struct Line<S: Scalar, const DEPTH: usize, const M: usize> {
    entries: [Entry<S, M>; DEPTH],
    /// Behind the last entry whose place is known.
    pub ready: AtomicU32,
    /// Behind the last one that has been carried out.
    pub done: AtomicU32,
    /// Entries before this one are void.
    pub void: AtomicU32,
}

impl<S: Scalar, const DEPTH: usize, const M: usize> Line<S, DEPTH, M> {
    const fn new() -> Self {
        const { assert!(DEPTH.is_power_of_two(), "running numbers wrap around") };
        Self {
            entries: [const { Entry::EMPTY }; DEPTH],
            ready: AtomicU32::new(0),
            done: AtomicU32::new(0),
            void: AtomicU32::new(0),
        }
    }

    fn clear(&mut self) {
        for counter in [&self.ready, &self.done, &self.void] {
            counter.store(0, Relaxed);
        }
    }

    /// An entry.
    pub fn entry(&self, serial: EntrySerial) -> Option<&Entry<S, M>> {
        self.entries.get(serial.raw() as usize % DEPTH)
    }

    /// Whether there is room for entry `serial`.
    pub fn has_room(&self, serial: EntrySerial) -> bool {
        point();
        let done = EntrySerial::from_raw(self.done.load(Acquire));
        serial.since(done).is_none_or(|waiting| (waiting as usize) < DEPTH)
    }

    /// Whether an entry has been carried out.
    pub fn is_done(&self, serial: EntrySerial) -> bool {
        point();
        serial.is_before(EntrySerial::from_raw(self.done.load(Acquire)))
    }

    /// Writes an entry for which there is room, and which is not ready.
    pub fn write(&self, serial: EntrySerial, item: &Item<S, M>) {
        let Some(entry) = self.entry(serial) else { return };
        for place in &entry.places {
            place.store(ArcLength::from_raw(item.place));
        }
        entry.order.store(item.order, Relaxed);
        entry.kind.store(item.wait.min(MOST_WAIT) << 2 | item.passing as u32, Relaxed);
        entry.part.store(item.part);
        for (slot, value) in entry.values.iter().zip(item.values) {
            slot.store(value);
        }
    }

    /// An entry that is not ready, as it was written.
    pub fn read(&self, serial: EntrySerial) -> Option<Item<S, M>> {
        let entry = self.entry(serial)?;
        let kind = entry.kind.load(Relaxed);
        Some(Item {
            passing: Passing::from_raw(kind),
            place: entry.place(0).raw(),
            order: entry.order.load(Relaxed),
            wait: kind >> 2,
            part: entry.part.load(),
            values: entry.values.each_ref().map(Shared::load),
        })
    }

    /// What is ready, not carried out and to come at the end of a standstill comes now that it is over: where the motion has arrived.
    pub fn end_standstills(&self, ready: EntrySerial) {
        point();
        let done = EntrySerial::from_raw(self.done.load(Acquire));
        for serial in (0..ready.since(done).unwrap_or(0)).map(|k| done.plus(k)) {
            let Some(entry) = self.entry(serial) else { return };
            // Of an entry that is ready nobody else writes this.
            let kind = entry.kind.load(Relaxed);
            if Passing::from_raw(kind) == Passing::Ending {
                point();
                entry.kind.store(kind & !3 | Passing::Arriving as u32, Relaxed);
            }
        }
    }

    /// Sets the place of an entry in one plan: in one that the interrupt is not on, or of an entry that is not ready.
    pub fn set_place(&self, serial: EntrySerial, plan: usize, place: ArcLength) {
        point();
        if let Some(entry) = self.entry(serial) {
            entry.places[plan & 1].store(place);
        }
    }

    /// The place of an entry in a plan.
    pub fn place(&self, serial: EntrySerial, plan: usize) -> ArcLength {
        self.entry(serial).map_or(ArcLength::ZERO, |entry| entry.place(plan))
    }

    /// The entries before this one are ready.
    pub fn set_ready(&self, serial: EntrySerial) {
        point();
        self.ready.store(serial.raw(), Release);
    }

    /// The entries before this one, the last that was written, are void.
    pub fn set_void(&self, serial: EntrySerial) {
        point();
        self.void.store(serial.raw(), Release);
        self.set_ready(serial);
    }
}

/// A place further on, by units of arc length.
pub const fn moved(place: ArcLength, units: i64) -> ArcLength {
    ArcLength::from_raw(place.raw().wrapping_add(units))
}

/// All queues of a core.
pub struct Board<S: Scalar> {
    /// Of digital outputs, then of analogue ones: the value.
    pub lines: [Line<S, SWITCHES, 1>; LINES],
    /// Of power: level, level over feed or 0, least, greatest.
    pub powers: Line<S, POWERS, 4>,
    /// By how much what is not behind has shifted in either plan.
    shifts: [[AtomicU32; 2]; 2],
    /// Entries of all queues that are ready or void, modulo 2^32.
    pub placed: AtomicU32,
    /// Events seen by the interrupt.
    pub events: AtomicU32,
    /// How often the power was to be switched off whatever was asked for.
    pub resets: AtomicU32,
}

impl<S: Scalar> Board<S> {
    /// An empty one: all zeros.
    pub const fn new() -> Self {
        Self {
            lines: [const { Line::new() }; LINES],
            powers: Line::new(),
            shifts: [const { <[AtomicU32; 2] as Shared<ArcLength>>::ZERO }; 2],
            placed: AtomicU32::new(0),
            events: AtomicU32::new(0),
            resets: AtomicU32::new(0),
        }
    }

    /// Forgets everything, with nobody at either end.
    pub fn clear(&mut self) {
        // What is left in the entries is never read.
        for line in &mut self.lines {
            line.clear();
        }
        self.powers.clear();
        for shift in &self.shifts {
            shift.store(ArcLength::ZERO);
        }
        for counter in [&self.placed, &self.events, &self.resets] {
            counter.store(0, Relaxed);
        }
    }

    /// So many more entries are ready or void.
    pub fn add_placed(&self, count: u32) {
        point();
        self.placed.store(self.placed.load(Relaxed).wrapping_add(count), Release);
    }

    /// By how much what lies ahead has shifted in a plan, in units of arc length.
    pub fn shift(&self, plan: usize) -> i64 {
        let shift: ArcLength = self.shifts[plan & 1].load();
        shift.raw()
    }

    /// Sets that of a plan that the interrupt is not on.
    pub fn set_shift(&self, plan: usize, units: i64) {
        point();
        self.shifts[plan & 1].store(ArcLength::from_raw(units));
    }

    /// Events seen by the interrupt.
    pub fn events(&self) -> u32 {
        point();
        self.events.load(Acquire)
    }

    /// Switches the power off, until it is asked for again.
    pub fn reset(&self) {
        point();
        self.resets.store(self.resets.load(Relaxed).wrapping_add(1), Release);
    }
}
