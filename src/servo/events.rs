//! Events on their way to the firmware.

use super::{Activity, Setpoint};
use crate::block::Block;
use crate::number::Scalar;
use crate::number::atomic::AtomicU32;
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};

/// Set in the word of the code if the event pauses, and if it has a value; the letter is above them.
const PAUSE: u32 = 1 << 16;
const VALUE: u32 = 1 << 17;
const LETTER: u32 = 24;

/// Something that is not motion, at its place between the moves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Event {
    /// The caller's mark (a line number).
    pub tag: u32,
    /// Letter of the word that asks for it, in ASCII: M, S or T.
    pub letter: u8,
    /// Its number times ten: 30 for M3.
    pub tenths: u16,
    /// What goes with it: a spindle speed, the number of a tool.
    pub value: Option<f32>,
    /// Whether the machine then rests until it is resumed.
    pub pause: bool,
}

impl Event {
    /// The block at which it happens.
    pub(crate) const fn block<S: Scalar, const N: usize>(&self) -> Block<S, N> {
        if self.pause { Block::pause(self.tag) } else { Block::event(self.tag) }
    }
}

/// One event, word by word: tag, code and pause, value.
type Slot = [AtomicU32; 3];

/// The way of events from the controller's end of a line (`wire::Station`, `grbl::Station`) to the servo interrupt,
/// in the order in which they happen. It can live in a `static`.
///
/// That end puts an event in when the planner has taken its block, and waits if there is no room; the
/// interrupt takes it out in the very cycle in which it happens, with [`Events::take`]. One context may
/// do each. It holds 12 bytes per event and 12 besides.
#[derive(Debug)]
pub struct Events<const M: usize> {
    slots: [Slot; M],
    /// Events put in, and taken out or dropped, so far.
    put: AtomicU32,
    out: AtomicU32,
    /// Events taken out.
    happened: AtomicU32,
}

impl<const M: usize> Default for Events<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const M: usize> Events<M> {
    /// None under way.
    pub const fn new() -> Self {
        const { assert!(M.is_power_of_two(), "the number of events must be a power of two") };
        Self {
            slots: [const { [const { AtomicU32::new(0) }; 3] }; M],
            put: AtomicU32::new(0),
            out: AtomicU32::new(0),
            happened: AtomicU32::new(0),
        }
    }

    /// The event that happens in this servo cycle, if one does. To be asked with every setpoint, once.
    ///
    /// Cost: a comparison; with an event, at most `M` loads.
    pub fn take<S: Scalar, const N: usize>(&self, setpoint: &Setpoint<S, N>) -> Option<Event> {
        if setpoint.activity != Activity::Event {
            return None;
        }
        let put = self.put.load(Acquire);
        let mut out = self.out.load(Relaxed);
        let mut found = None;
        while out != put && found.is_none() {
            found = self.slot(out).map(load).filter(|event| event.tag == setpoint.tag);
            out = out.wrapping_add(1);
        }
        // One of the planner's own, between two dwells.
        found?;
        self.happened.store(self.happened().wrapping_add(1), Relaxed);
        self.out.store(out, Release);
        found
    }

    /// Events that have happened, since the start.
    pub fn happened(&self) -> u32 {
        self.happened.load(Relaxed)
    }

    fn slot(&self, number: u32) -> Option<&Slot> {
        self.slots.get(number as usize & (M - 1))
    }

    /// Uses every atomic once.
    #[cfg(all(test, loom))]
    pub fn touch(&self) {
        for word in self.slots.iter().flatten().chain([&self.put, &self.out, &self.happened]) {
            word.load(Relaxed);
        }
    }

    /// Whether there is room for another.
    pub(crate) fn has_room(&self) -> bool {
        let waiting = self.put.load(Relaxed).wrapping_sub(self.out.load(Acquire));
        (waiting as usize) < M
    }

    /// Puts one in. There must be room.
    pub(crate) fn put(&self, event: &Event) {
        let put = self.put.load(Relaxed);
        if let Some([tag, code, value]) = self.slot(put) {
            tag.store(event.tag, Relaxed);
            let flags = if event.pause { PAUSE } else { 0 } | event.value.map_or(0, |_| VALUE);
            let word = u32::from(event.letter) << LETTER | u32::from(event.tenths) | flags;
            code.store(word, Relaxed);
            value.store(event.value.unwrap_or_default().to_bits(), Relaxed);
        }
        self.put.store(put.wrapping_add(1), Release);
    }

    /// Drops those that have not happened. Only while none can: at rest, with nothing planned.
    pub(crate) fn clear(&self) {
        self.out.store(self.put.load(Relaxed), Release);
    }
}

fn load([tag, code, value]: &Slot) -> Event {
    let code = code.load(Relaxed);
    Event {
        tag: tag.load(Relaxed),
        letter: (code >> LETTER) as u8,
        tenths: code as u16,
        value: (code & VALUE != 0).then(|| f32::from_bits(value.load(Relaxed))),
        pause: code & PAUSE != 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(tag: u32) -> Event {
        let value = (!tag.is_multiple_of(3)).then_some(0.5);
        Event { tag, letter: b'M', tenths: tag as u16 * 30, value, pause: tag.is_multiple_of(2) }
    }

    fn at(tag: u32, activity: Activity) -> Setpoint<f32, 3> {
        Setpoint { tag, activity, ..Setpoint::REST }
    }

    #[test]
    fn events_come_in_order_and_only_when_they_happen() {
        let events = Events::<2>::new();
        events.put(&event(1));
        assert!(events.has_room());
        events.put(&event(2));
        assert!(!events.has_room());
        assert_eq!(events.take(&at(1, Activity::Running)), None);
        assert_eq!(events.take(&at(1, Activity::Event)), Some(event(1)));
        events.put(&event(3));
        assert_eq!(events.take(&at(2, Activity::Event)), Some(event(2)));
        assert_eq!(events.take(&at(3, Activity::Event)), Some(event(3)));
        events.put(&event(4));
        assert_eq!((events.take(&at(3, Activity::Event)), events.happened()), (None, 3));
        assert_eq!(events.take(&at(4, Activity::Event)), Some(event(4)));
    }

    #[test]
    fn dropped_events_do_not_happen() {
        let events = Events::<4>::new();
        events.put(&event(1));
        events.put(&event(2));
        events.clear();
        events.put(&event(2));
        assert_eq!(events.take(&at(2, Activity::Event)), Some(event(2)));
        assert!(events.has_room());
        assert_eq!(events.take(&at(2, Activity::Event)), None);
    }
}
