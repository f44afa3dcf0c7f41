//! What planning takes on this machine, in servo cycles: measured, so that a plan is begun early enough.

use crate::number::Scalar;

/// Share of what is known that one which took less changes.
const FORGET: f64 = 0.125;
/// By how much more something that came too late is taken to have needed.
const LATE: f64 = 1.5;
/// What an estimate adds, in parts of itself and in servo cycles: a count of cycles is rounded down at either end.
const RESERVE: f64 = 1.25;
const RESERVE_CYCLES: f64 = 2.0;

/// What plans and stops take, from the first slice to the offer.
#[derive(Clone, Copy, Debug)]
pub struct Effort<S> {
    /// A plan, for each of its cells.
    pub plan: Work<S>,
    /// A stop, in all.
    pub stop: Work<S>,
    /// A window that is reshaped.
    #[cfg(feature = "reshape")]
    pub shape: Work<S>,
}

impl<S: Scalar> Effort<S> {
    /// Nothing is known, or planning takes no time.
    pub const NONE: Self = Self {
        plan: Work::NONE,
        stop: Work::NONE,
        #[cfg(feature = "reshape")]
        shape: Work::NONE,
    };
}

/// Servo cycles that something takes for each of its parts. As much as the worst lately.
#[derive(Clone, Copy, Debug)]
pub struct Work<S> {
    per_part: S,
}

impl<S: Scalar> Work<S> {
    const NONE: Self = Self { per_part: S::ZERO };

    /// So many parts took so many servo cycles.
    pub fn learn(&mut self, parts: usize, cycles: u32) {
        let per_part = S::from_u32(cycles) / S::from_u32(parts.max(1) as u32);
        if per_part > self.per_part {
            self.per_part = per_part;
        } else {
            self.per_part += (per_part - self.per_part) * S::of(FORGET);
        }
    }

    /// So many parts came too late after so many servo cycles.
    pub fn learn_late(&mut self, parts: usize, cycles: u32) {
        let most = S::from_u32(cycles).greatest(S::ONE) * S::of(LATE);
        self.learn(parts, most.to_i64().clamp(1, i64::from(u32::MAX)) as u32);
    }

    /// Servo cycles that so many parts will take; 0 if they take none.
    pub fn cycles(&self, parts: usize) -> S {
        let cycles = self.per_part * S::from_u32(parts as u32);
        // Less than a cycle in all: the clock does not move meanwhile.
        if cycles < S::of(0.5) { S::ZERO } else { cycles * S::of(RESERVE) + S::of(RESERVE_CYCLES) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_up_more_at_once_and_less_slowly() {
        let mut effort = Work::<f64>::NONE;
        assert!(effort.cycles(64) == 0.0);
        effort.learn(10, 20);
        assert!((effort.cycles(5) - 14.5).abs() < 1e-12);
        effort.learn(10, 0);
        assert!((effort.per_part - 1.75).abs() < 1e-12);
        effort.learn_late(10, 20);
        assert!((effort.per_part - 3.0).abs() < 1e-12);
    }

    #[test]
    fn forgets_when_planning_takes_no_time() {
        let mut effort = Work::<f32>::NONE;
        effort.learn(40, 40);
        for _ in 0..60 {
            effort.learn(40, 0);
        }
        assert!(effort.cycles(64) == 0.0);
    }
}
