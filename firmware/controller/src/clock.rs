//! Time out of servo cycles.

/// Milliseconds since its first use, out of a count of servo cycles; both may wrap around.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    cycles_per_ms: u32,
    cycles: u32,
    /// Cycles that do not make a millisecond yet.
    rest: u32,
    ms: u32,
}

impl Clock {
    /// A clock that stands at 0 when no cycle has been counted. `cycles_per_ms` is at least 1.
    pub const fn new(cycles_per_ms: u32) -> Self {
        let cycles_per_ms = if cycles_per_ms == 0 { 1 } else { cycles_per_ms };
        Self { cycles_per_ms, cycles: 0, rest: 0, ms: 0 }
    }

    /// The time, ms, when `cycles` cycles have been counted. To be asked at least once in 2^32 cycles.
    pub fn ms(&mut self, cycles: u32) -> u32 {
        let passed = cycles.wrapping_sub(self.cycles);
        self.cycles = cycles;
        self.ms = self.ms.wrapping_add(passed / self.cycles_per_ms);
        self.rest += passed % self.cycles_per_ms;
        self.ms = self.ms.wrapping_add(self.rest / self.cycles_per_ms);
        self.rest %= self.cycles_per_ms;
        self.ms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cycle_is_lost_and_counts_may_wrap() {
        let mut clock = Clock::new(10);
        assert_eq!(
            [9, 10, 11, 25, 25, 39, 40].map(|cycles| clock.ms(cycles)),
            [0, 1, 1, 2, 2, 3, 4]
        );
        let before = clock.ms(u32::MAX - 4);
        assert_eq!(before, (u32::MAX - 4) / 10);
        // 2^32 - 5 is 429,496,729 ms and 1 cycle: nine more make the next.
        assert_eq!(clock.ms(3), before);
        assert_eq!(clock.ms(4), before + 1);
    }

    #[test]
    fn a_clock_without_a_rate_counts_cycles() {
        assert_eq!(Clock::new(0).ms(7), 7);
    }
}
