//! What planning takes on this machine, in servo cycles: measured, so that a plan is begun early enough.

use crate::number::Scalar;

/// Share of what is new in the mean, and in the mean deviation from it: as for times on a network (RFC 6298).
const NEW_IN_MEAN: f64 = 0.125;
const NEW_IN_DEVIATION: f64 = 0.25;
/// The deviation of the first, as a share of it.
const FIRST_DEVIATION: f64 = 0.5;
/// What answers to a command take more than the mean of plans: one that comes too late is made again at once.
const USUAL: f64 = 1.25;
/// What an estimate adds to the mean: mean deviations, and servo cycles, since a count of them is rounded down at either end.
const DEVIATIONS: f64 = 3.0;
const RESERVE_CYCLES: f64 = 2.0;
/// What one adds to it that may be too small.
const ROUNDED: f64 = 0.5;

/// So many times what one took it has taken in the mean if it is another time: a hard plan takes some times as long as an easy one.
pub const SLOWER: f64 = 16.0;

/// What plans and stops take, from the first slice to the offer.
#[derive(Clone, Copy, Debug)]
pub struct Effort<S> {
    /// A plan, for each of the cells that it is looked for over.
    pub plan: Work<S>,
    /// A stop, or a stage of one, for each of its slices; as long as none has been measured, a plan for each of its.
    pub stop: Work<S>,
    /// A first answer to an override, in all.
    pub first: Work<S>,
    /// A whole one, for each of the cells that lie ahead: the mean.
    whole: S,
    /// A window that is reshaped.
    #[cfg(feature = "reshape")]
    pub shape: Work<S>,
}

impl<S: Scalar> Effort<S> {
    /// Nothing is known, or planning takes no time.
    pub const NONE: Self = Self {
        plan: Work::NONE,
        stop: Work::NONE,
        first: Work::NONE,
        whole: S::ZERO,
        #[cfg(feature = "reshape")]
        shape: Work::NONE,
    };

    /// A whole answer to overrides, for each of the cells that lie ahead.
    pub fn whole(&self) -> Work<S> {
        Work { mean: self.whole, deviation: S::ZERO }
    }

    /// One has taken so many servo cycles over so many cells.
    pub fn learn_whole(&mut self, cells: usize, cycles: u32) {
        let mut whole = self.whole();
        whole.learn(cells, cycles);
        self.set_whole(&whole);
    }

    /// What is known of them from now on.
    pub fn set_whole(&mut self, whole: &Work<S>) {
        self.whole = whole.mean;
    }

    /// One has taken so many servo cycles over so many cells, and is not done: the next are given twice as many.
    pub fn raise_whole(&mut self, cells: usize, cycles: u32) {
        let per_cell = per_part::<S>(cells, cycles);
        self.whole = self.whole.greatest(per_cell + per_cell);
    }
}

/// Servo cycles that something takes for each of its parts: the mean lately, and how far from it they were.
#[derive(Clone, Copy, Debug)]
pub struct Work<S> {
    mean: S,
    deviation: S,
}

impl<S: Scalar> Work<S> {
    /// Nothing is known.
    pub const NONE: Self = Self { mean: S::ZERO, deviation: S::ZERO };

    /// So many parts took so many servo cycles, or have taken them so far when it was too late: that is more than was reckoned
    /// with, so that the next estimate is greater all the same. (One in twenty plans takes twice as long as the others: an estimate by
    /// the worst of them would hold back the next twenty.)
    #[inline(never)]
    pub fn learn(&mut self, parts: usize, cycles: u32) {
        let per_part = per_part(parts, cycles);
        if !(self.mean > S::ZERO) {
            *self = Self { mean: per_part, deviation: per_part * S::of(FIRST_DEVIATION) };
            return;
        }
        let off = per_part - self.mean;
        self.mean += off * S::of(NEW_IN_MEAN);
        self.deviation += (off.abs() - self.deviation) * S::of(NEW_IN_DEVIATION);
    }

    /// So many parts took so many servo cycles, a small part of what is reckoned with: what made the others so slow is over, and what is known of
    /// them says nothing of those to come. If that is so, this is the first that is known.
    #[inline(never)]
    pub fn begin_anew(&mut self, parts: usize, cycles: u32) -> bool {
        let taken = (S::from_u32(cycles) + S::of(ROUNDED)) * S::of(SLOWER);
        let over = self.mean * S::from_u32(parts as u32) > taken;
        if over {
            *self = Self::NONE;
            self.learn(parts, cycles);
        }
        over
    }

    /// Learns, or begins anew where it may. Whether it has begun anew.
    #[inline(never)]
    pub fn renew(&mut self, parts: usize, cycles: u32, may: bool) -> bool {
        let anew = may && self.begin_anew(parts, cycles);
        if !anew {
            self.learn(parts, cycles);
        }
        anew
    }

    /// Whether anything is known, and that it takes time.
    pub fn is_known(&self) -> bool {
        self.mean > S::ZERO
    }

    /// Servo cycles within which so many parts are done but for one time in some; 0 if they take none.
    pub fn cycles(&self, parts: usize) -> S {
        with_reserve((self.mean + self.deviation * S::of(DEVIATIONS)) * S::from_u32(parts as u32))
    }

    /// Servo cycles that so many parts take as a rule; 0 if they take none.
    pub fn usual(&self, parts: usize) -> S {
        with_reserve(self.mean * S::of(USUAL) * S::from_u32(parts as u32))
    }

    /// Servo cycles that so many parts take as a rule, where one that comes too late costs little.
    pub fn within(&self, parts: usize) -> S {
        self.mean * S::of(USUAL) * S::from_u32(parts as u32) + S::of(ROUNDED)
    }
}

fn per_part<S: Scalar>(parts: usize, cycles: u32) -> S {
    S::from_u32(cycles) / S::from_u32(parts.max(1) as u32)
}

fn with_reserve<S: Scalar>(cycles: S) -> S {
    // Less than a cycle in all: the clock does not move meanwhile.
    if cycles < S::of(0.5) { S::ZERO } else { cycles + S::of(RESERVE_CYCLES) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_mean_and_what_is_apart_from_it() {
        let mut effort = Work::<f64>::NONE;
        assert!(effort.cycles(64) == 0.0);
        effort.learn(10, 20);
        assert!((effort.cycles(5) - 27.0).abs() < 1e-12 && (effort.usual(5) - 14.5).abs() < 1e-12);
        for _ in 0..40 {
            effort.learn(10, 20);
        }
        assert!((effort.cycles(5) - 12.0).abs() < 1e-3);
    }

    /// Whatever comes too late, the next one of its kind is given more time.
    #[test]
    fn grows_with_what_is_late() {
        let mut effort = Work::<f64>::NONE;
        for _ in 0..40 {
            effort.learn(40, 10);
        }
        for _ in 0..20 {
            let before = effort.cycles(40);
            effort.learn(40, before as u32 + 1);
            assert!(effort.cycles(40) > before + 1.0, "{before}");
        }
    }

    #[test]
    fn is_over_a_late_one_in_a_few() {
        let mut effort = Work::<f64>::NONE;
        for _ in 0..40 {
            effort.learn(40, 14);
        }
        effort.learn(40, 40);
        let worst = effort.cycles(40);
        for _ in 0..8 {
            effort.learn(40, 14);
        }
        assert!(worst > 35.0 && effort.cycles(40) < 24.0, "{worst} {}", effort.cycles(40));
    }

    /// A background that was late for long is in time again.
    #[test]
    fn begins_anew_where_one_takes_a_small_part() {
        let mut effort = Work::<f64>::NONE;
        for _ in 0..40 {
            effort.learn(40, 400);
        }
        assert!(!effort.begin_anew(40, 40) && effort.cycles(40) > 400.0);
        assert!(effort.begin_anew(40, 2) && effort.cycles(40) < 8.0);
        // What it takes then is known at once.
        assert!(!effort.begin_anew(40, 1) && !effort.begin_anew(40, 0));
        let mut effort = Work::<f64>::NONE;
        assert!(!effort.begin_anew(40, 0));
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
