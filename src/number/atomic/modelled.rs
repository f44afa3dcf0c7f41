//! Atomics of the model checker that can stand in a constant, as those of `core` can, and whose orderings a test
//! can weaken one by one.

use core::panic::Location;
use core::sync::atomic::Ordering::{self, AcqRel, Acquire, Relaxed, Release};
use std::collections::BTreeSet;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::vec::Vec;

/// Half of an ordering, at a place in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Half {
    pub file: &'static str,
    pub line: u32,
    pub column: u32,
    /// Whether it is the acquiring half, or the releasing one.
    pub acquires: bool,
}

/// Halves that have been met, and the one that is left out.
static MET: Mutex<BTreeSet<Half>> = Mutex::new(BTreeSet::new());
static LEFT_OUT: Mutex<Option<Half>> = Mutex::new(None);

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Every half of an ordering that has been met so far.
pub fn met() -> Vec<Half> {
    lock(&MET).iter().copied().collect()
}

/// Forgets them.
pub fn forget() {
    lock(&MET).clear();
}

/// Leaves one half out from now on, or none.
pub fn leave_out(half: Option<Half>) {
    *lock(&LEFT_OUT) = half;
}

/// What is left of an ordering at its place.
fn at(order: Ordering, place: &Location<'static>) -> Ordering {
    let keeps = |acquires: bool| {
        let half =
            Half { file: place.file(), line: place.line(), column: place.column(), acquires };
        lock(&MET).insert(half);
        *lock(&LEFT_OUT) != Some(half)
    };
    let acquires = matches!(order, Acquire | AcqRel) && keeps(true);
    let releases = matches!(order, Release | AcqRel) && keeps(false);
    match (acquires, releases) {
        (true, true) => AcqRel,
        (true, false) => Acquire,
        (false, true) => Release,
        (false, false) => Relaxed,
    }
}

/// A fence; a relaxed one is none.
#[track_caller]
pub fn fence(order: Ordering) {
    let order = at(order, Location::caller());
    if order != Relaxed {
        loom::sync::atomic::fence(order);
    }
}

/// The model checker's atomic, made at its first use: before a second thread knows of it.
pub struct AtomicU32 {
    start: u32,
    model: OnceLock<loom::sync::atomic::AtomicU32>,
}

impl core::fmt::Debug for AtomicU32 {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.start.fmt(f)
    }
}

impl AtomicU32 {
    pub const fn new(start: u32) -> Self {
        Self { start, model: OnceLock::new() }
    }

    fn model(&self) -> &loom::sync::atomic::AtomicU32 {
        self.model.get_or_init(|| loom::sync::atomic::AtomicU32::new(self.start))
    }

    #[track_caller]
    pub fn load(&self, order: Ordering) -> u32 {
        self.model().load(at(order, Location::caller()))
    }

    #[track_caller]
    pub fn store(&self, value: u32, order: Ordering) {
        self.model().store(value, at(order, Location::caller()));
    }

    #[track_caller]
    pub fn fetch_or(&self, value: u32, order: Ordering) -> u32 {
        self.model().fetch_or(value, at(order, Location::caller()))
    }

    #[cfg(feature = "jog")]
    #[track_caller]
    pub fn fetch_add(&self, value: u32, order: Ordering) -> u32 {
        self.model().fetch_add(value, at(order, Location::caller()))
    }

    /// Where the acquiring half is left out, it is so on failure too.
    #[track_caller]
    pub fn compare_exchange(
        &self,
        old: u32,
        new: u32,
        done: Ordering,
        failed: Ordering,
    ) -> Result<u32, u32> {
        let done = at(done, Location::caller());
        let failed = if matches!(done, Acquire | AcqRel) { failed } else { Relaxed };
        self.model().compare_exchange(old, new, done, failed)
    }
}
