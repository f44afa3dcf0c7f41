//! Switches and probes: their levels, and when one of them was closed or opened (feature `probe`).

use super::interleave::AtomicU32;
use crate::number::atomic::AtomicU32 as Count;
use crate::number::serial::CycleSerial;
use core::sync::atomic::Ordering::{self, Acquire, Relaxed, Release};

/// An input that can end a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Input {
    /// The probe.
    Probe,
    /// The home switch of the axis with this index.
    Home(usize),
}

/// Inputs: one per axis, and the probe.
const INPUTS: usize = 10;

impl Input {
    const fn index(self) -> usize {
        match self {
            Self::Probe => INPUTS - 1,
            Self::Home(axis) if axis < INPUTS - 1 => axis,
            Self::Home(_) => INPUTS,
        }
    }
}

/// The input is closed.
const CLOSED: u32 = 1;
/// An edge is waited for.
const ARMED: u32 = 2;
/// It is that to closed.
const WANTS_CLOSED: u32 = 4;
/// It has come, and its time is being written.
const TAKING: u32 = 8;
/// It has come, and its time is there.
const LATCHED: u32 = 16;

/// One input. The time of an edge belongs to who has changed [`ARMED`] to [`TAKING`], until it is [`LATCHED`].
#[derive(Debug)]
struct Line {
    state: AtomicU32,
    cycle: AtomicU32,
    /// Bits of an `f32`.
    fraction: AtomicU32,
}

impl Line {
    // Made anew wherever it is named, which is the intention.
    #[allow(clippy::declare_interior_mutable_const)]
    const NEW: Self =
        Self { state: AtomicU32::new(0), cycle: AtomicU32::new(0), fraction: AtomicU32::new(0) };

    /// Goes round again only if another context came between.
    fn change(&self, order: Ordering, change: impl Fn(u32) -> u32) -> u32 {
        let mut state = self.state.load(Relaxed);
        while let Err(now) = self.state.compare_exchange(state, change(state), order, Relaxed) {
            state = now;
        }
        state
    }

    fn tell(&self, closed: bool, cycle: u32, fraction: f32) {
        let level = u32::from(closed);
        let catches = |state: u32| state & ARMED != 0 && (state & WANTS_CLOSED != 0) == closed;
        // The time of the edge before has been read when the next is waited for.
        let before = self.change(Acquire, |state| {
            let state_now = state & !CLOSED | level;
            if catches(state) { state_now & !ARMED | TAKING } else { state_now }
        });
        if catches(before) {
            self.cycle.store(cycle, Relaxed);
            self.fraction.store(fraction.to_bits(), Relaxed);
            self.state.fetch_add(LATCHED - TAKING, Release);
        }
    }
}

/// All of them.
#[derive(Debug)]
pub struct Lines([Line; INPUTS]);

/// When an edge came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeTime {
    /// The servo cycle in which it came: the number of the last tick before it.
    pub cycle: CycleSerial,
    /// Part of that cycle that had passed; beyond 0 to 1 it was in another.
    pub fraction: f32,
}

impl EdgeTime {
    /// Whole servo cycles from the end of one with a number to the edge, rounded down.
    pub fn whole_since(self, end: CycleSerial) -> i64 {
        let cycles = self.cycle.raw().wrapping_sub(end.raw()).cast_signed();
        // The end of a cycle is a tick before that of the next.
        i64::from(cycles) - 1 + libm::floorf(self.fraction) as i64
    }

    /// The part of a cycle by which it is later.
    pub fn part(self) -> f64 {
        f64::from(self.fraction - libm::floorf(self.fraction))
    }
}

/// Fractions of a servo cycle that are told.
const FRACTIONS: (f32, f32) = (-1.0, 2.0);

impl Lines {
    pub const fn new() -> Self {
        Self([Line::NEW; INPUTS])
    }

    fn line(&self, input: Input) -> Option<&Line> {
        self.0.get(input.index())
    }

    /// Waits for an edge of an input to `closed`. `false`, and nothing has changed: that is its level now, or there is no such
    /// input.
    pub fn arm(&self, input: Input, closed: bool) -> bool {
        let Some(line) = self.line(input) else { return false };
        let is_free = |state: u32| (state & CLOSED != 0) != closed && state & TAKING == 0;
        let wanted = ARMED | if closed { WANTS_CLOSED } else { 0 };
        let before = line
            .change(Release, |state| if is_free(state) { state & CLOSED | wanted } else { state });
        is_free(before)
    }

    /// No longer waits for an edge, and forgets the one that came.
    pub fn disarm(&self, input: Input) {
        if let Some(line) = self.line(input) {
            line.change(Relaxed, |state| state & !(ARMED | LATCHED));
        }
    }

    /// When the edge came that was waited for.
    pub fn latched(&self, input: Input) -> Option<EdgeTime> {
        let line = self.line(input)?;
        (line.state.load(Acquire) & LATCHED != 0).then(|| EdgeTime {
            cycle: CycleSerial::from_raw(line.cycle.load(Relaxed)),
            fraction: f32::from_bits(line.fraction.load(Relaxed)),
        })
    }

    /// Whether an input is closed.
    pub fn is_closed(&self, input: Input) -> bool {
        self.line(input).is_some_and(|line| line.state.load(Relaxed) & CLOSED != 0)
    }
}

/// The handle of what sees the inputs: [`Planner::inputs`](crate::Planner::inputs) (feature `probe`). It may be copied and used from
/// any context.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    lines: &'a Lines,
    cycles: &'a Count,
}

impl<'a> Inputs<'a> {
    pub(crate) const fn new(lines: &'a Lines, cycles: &'a Count) -> Self {
        Self { lines, cycles }
    }

    /// Tells the level of an input, `fraction` of a servo cycle after the last tick: to be called from the interrupt of its edges,
    /// and once at the start. The first edge that a motion waits for is latched with its time; those after it, of a switch that
    /// bounces, change nothing but the level.
    ///
    /// The fraction is what the timer says of the servo cycle. Where it is read while a tick is due that has not come, it is one
    /// more; where a tick came after it was read, one less: from -1 to 2 it counts as it is. The simplest is an interrupt of the same
    /// priority as that of the servo cycle, and one is added where the timer's flag stands. An input that is looked at once per
    /// servo cycle is told with a fraction of 0, right after the tick.
    ///
    /// Cost: some forty instructions; it goes round again only where another context has told the same input in between.
    pub fn tell(self, input: Input, closed: bool, fraction: f32) {
        let Some(line) = self.lines.line(input) else { return };
        let (least, most) = FRACTIONS;
        let fraction = if fraction >= least { fraction.min(most) } else { least };
        line.tell(closed, self.cycles.load(Relaxed), fraction);
    }

    /// Whether an input is closed, as last told.
    pub fn is_closed(self, input: Input) -> bool {
        self.lines.is_closed(input)
    }
}

// Of one context; `models.rs` has those of several.
#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    #[test]
    fn the_first_edge_is_kept_and_bounces_are_not() {
        let (lines, cycles) = (Lines::new(), Count::new(7));
        let inputs = Inputs::new(&lines, &cycles);
        for input in [Input::Probe, Input::Home(0), Input::Home(8)] {
            inputs.tell(input, false, 0.0);
            assert!(!lines.arm(input, false) && lines.arm(input, true));
            inputs.tell(input, false, 0.1);
            assert_eq!(lines.latched(input), None);
            inputs.tell(input, true, 0.25);
            cycles.store(8, Relaxed);
            for (closed, fraction) in [(false, 0.5), (true, 0.75), (false, 0.8)] {
                inputs.tell(input, closed, fraction);
            }
            let edge = EdgeTime { cycle: CycleSerial::from_raw(7), fraction: 0.25 };
            assert_eq!(lines.latched(input), Some(edge));
            assert!(!inputs.is_closed(input));
            lines.disarm(input);
            inputs.tell(input, true, 0.0);
            assert_eq!(lines.latched(input), None);
            // To open, and the fraction as far as it can be.
            assert!(!lines.arm(input, true) && lines.arm(input, false));
            inputs.tell(input, false, f32::NAN);
            let edge = EdgeTime { cycle: CycleSerial::from_raw(8), fraction: -1.0 };
            assert_eq!(lines.latched(input), Some(edge));
            assert!(lines.arm(input, true));
            assert_eq!(lines.latched(input), None);
            inputs.tell(input, true, 1.0e9);
            assert_eq!(
                lines.latched(input).map(|edge| edge.fraction.to_bits()),
                Some(2.0f32.to_bits())
            );
            cycles.store(7, Relaxed);
        }
        assert!(!lines.arm(Input::Home(9), true));
        inputs.tell(Input::Home(usize::MAX), true, 0.0);
    }
}
