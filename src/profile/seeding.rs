//! First states for stations that have none where a guess has led to no motion: slow ones, that keep all limits.

use super::law::PathState;
use super::problem::{Problem, Stretch};
use crate::machine::LimitSets;
use crate::number::Scalar;

/// Most halvings of the speeds: down to 1e-12 of what the machine does in its time scale.
const TRIES: u32 = 40;
/// Shares of its speed that the first new station may have, from the least on: the factor is about four,
/// since a better start is only wanted to save a few steps.
const ENTRIES: [f64; 6] = [0.001, 0.004, 0.016, 0.06, 0.25, 1.0];
/// Share of the machine's time scale that a cell takes at first.
const TIME: f64 = 0.125;
/// Speed where no cell lies before that could bound it, mm/s.
const NO_SPEED_LIMIT: f64 = 1.0e6;

/// A search for slow speeds, between two tries.
///
/// Every cell takes about the same time, which is doubled until all limits hold. The first new station was the stop
/// of the plan before: what it may have is little if that plan brakes hard, and should not hold back the others. So
/// it has the least share at first, and then as much as can be.
#[derive(Clone, Copy, Debug)]
pub struct Seeding<S> {
    /// First station without a state.
    new: usize,
    /// 1 / s: one over the time of a cell.
    rate: S,
    /// Tries so far.
    tries: u32,
    /// Index of the share that is tried next.
    entry: usize,
}

impl<S: Scalar> Seeding<S> {
    /// For the free stations of a stretch from index `new` on; those before keep their states.
    pub fn new<const N: usize>(limits: LimitSets<'_, S, N>, stretch: Stretch, new: usize) -> Self {
        let rate = S::ONE / (limits.time_scale() * S::of(TIME));
        Self { new: new.max(stretch.first + 1), rate, tries: 0, entry: 0 }
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Problem<'_, S, N, NODES> {
    /// One try. Whether the stretch has such speeds now, or never will; `None` while that is not known.
    ///
    /// Cost: one pass over the cells without gradients. There are at most [`TRIES`] and one for each share.
    pub fn seed(&mut self, seeding: &mut Seeding<S>) -> Option<bool> {
        let Seeding { new, rate, entry, .. } = *seeding;
        let share = |entry: usize| S::of(ENTRIES.get(entry).copied().unwrap_or(1.0));
        self.seed_speeds(new, rate, share(entry));
        let holds = self.holds_over(new - 1..self.task.stretch.last);
        if holds {
            seeding.entry += 1;
            return (seeding.entry == ENTRIES.len()).then_some(true);
        }
        if entry > 0 {
            self.seed_speeds(new, rate, share(entry - 1));
            return Some(true);
        }
        seeding.tries += 1;
        seeding.rate = rate * S::of(0.5);
        (seeding.tries >= TRIES).then_some(false)
    }

    /// Gives every new station the speed at which the shorter of its cells takes 1 / `rate`; the
    /// first one only the share `entry` of it.
    fn seed_speeds(&mut self, new: usize, rate: S, entry: S) {
        let mut before = S::of(NO_SPEED_LIMIT);
        for i in new - 1..self.task.stretch.last {
            let Some(station) = self.window.get(i) else { return };
            let here = if station.cell.length > S::ZERO {
                (station.cell.length * rate).least(station.bounds.goal * S::of(0.7))
            } else {
                S::ZERO
            };
            let mut speed = before.least(here);
            before = here;
            if i >= new {
                if i == new {
                    speed = speed * entry;
                }
                let b = if self.is_free(i) { speed * speed } else { S::ZERO };
                self.window.set_state(i, PathState { b, a: S::ZERO });
            }
        }
    }
}
