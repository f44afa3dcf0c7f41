//! Instructions, counted with a timer.

use splineway_emulator::{Meter, Part};

/// Counter of TIM2. In QEMU it counts nanoseconds, and an instruction takes 64.
const COUNTER: *const u32 = 0x4000_0024 as *const u32;

#[inline]
fn now() -> u32 {
    // SAFETY: reads a register of a timer that nothing else uses.
    unsafe { COUNTER.read_volatile() }
}

/// Instructions in a time, ns.
pub fn instructions(ns: u64) -> u64 {
    (ns + 32) / 64
}

/// Calls, instructions in all, and of the costliest call.
#[derive(Clone, Copy, Default)]
pub struct Count {
    pub calls: u32,
    /// ns.
    pub sum: u64,
    /// ns.
    pub worst: u32,
}

impl Count {
    fn add(&mut self, ns: u32) {
        self.calls += 1;
        self.sum += u64::from(ns);
        self.worst = self.worst.max(ns);
    }
}

/// Counts what is between [`Meter::begin`] and [`Meter::end`].
#[derive(Default)]
pub struct Timer {
    began: u32,
    /// What an empty call costs, ns.
    empty: u32,
    /// Of planning.
    pub planning: Count,
    /// Of ticks.
    pub tick: Count,
}

impl Timer {
    /// One that knows what it costs itself.
    pub fn calibrated() -> Self {
        let mut timer = Self::default();
        timer.begin();
        timer.empty = now().wrapping_sub(timer.began);
        timer
    }

    /// Time since the call began, ns.
    #[inline]
    fn taken(&self) -> u32 {
        now().wrapping_sub(self.began).saturating_sub(self.empty)
    }

    /// A call of another kind has ended.
    #[inline(never)]
    #[allow(dead_code)] // Of one of the images that share this file.
    pub fn add(&self, count: &mut Count) {
        count.add(self.taken());
    }
}

impl Meter for Timer {
    #[inline(never)]
    fn begin(&mut self) {
        self.began = now();
    }

    #[inline(never)]
    fn end(&mut self, part: Part) {
        let ns = self.taken();
        let count = if part == Part::Tick { &mut self.tick } else { &mut self.planning };
        count.add(ns);
    }
}
