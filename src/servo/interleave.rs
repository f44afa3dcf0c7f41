//! Places at which another context may come in.
//!
//! The planner's and the operator's calls pass [`point`] before every access to state that contexts share.
//! It is nothing at all without the feature `interleave`. With it - for tests on a host - a test may run
//! the servo interrupt, or the operator, at any of these places, and so between any two accesses: what real
//! interrupts do once in a million cycles, a soak does on purpose. The interrupt's own accesses are no such
//! places: nothing that shares state with it comes in while it runs.

#[cfg(not(feature = "interleave"))]
pub use crate::number::atomic::AtomicU32;

/// A bug in the hand-over of plans, to see whether a test finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A plan is offered before it is said where it branches off.
    OfferFirst,
    /// A plan that was refused is taken for one that was taken.
    RefusedIsTaken,
}

/// Another context may come in here.
#[cfg(not(feature = "interleave"))]
#[inline]
pub const fn point() {}

/// Whether that bug is planted: never, but in tests.
#[cfg(not(any(feature = "interleave", all(test, loom))))]
#[inline]
pub const fn is_planted(_: Fault) -> bool {
    false
}

#[cfg(all(test, loom, not(feature = "interleave")))]
pub use super::models::is_planted;

#[cfg(feature = "interleave")]
pub use hooked::{AtomicU32, is_planted, plant, point, set};

#[cfg(feature = "interleave")]
mod hooked {
    use super::Fault;
    use core::cell::Cell;
    use core::sync::atomic::{self, Ordering};
    use std::thread_local;

    thread_local! {
        static HOOK: Cell<Option<fn()>> = const { Cell::new(None) };
        static PLANTED: Cell<Option<Fault>> = const { Cell::new(None) };
    }

    /// Has `hook` called at every place of this thread where another context may come in.
    pub fn set(hook: Option<fn()>) {
        HOOK.set(hook);
    }

    /// Another context may come in here.
    #[inline]
    pub fn point() {
        if let Some(hook) = HOOK.get() {
            hook();
        }
    }

    /// Plants a bug in this thread, or mends it.
    pub fn plant(fault: Option<Fault>) {
        PLANTED.set(fault);
    }

    /// Whether that bug is planted.
    pub fn is_planted(fault: Fault) -> bool {
        PLANTED.get() == Some(fault)
    }

    /// The atomic of the same name, with a [`point`] before every access.
    #[derive(Debug)]
    pub struct AtomicU32(atomic::AtomicU32);

    impl AtomicU32 {
        pub const fn new(value: u32) -> Self {
            Self(atomic::AtomicU32::new(value))
        }

        pub fn load(&self, order: Ordering) -> u32 {
            point();
            self.0.load(order)
        }

        pub fn store(&self, value: u32, order: Ordering) {
            point();
            self.0.store(value, order);
        }

        pub fn fetch_or(&self, value: u32, order: Ordering) -> u32 {
            point();
            self.0.fetch_or(value, order)
        }

        pub fn compare_exchange(
            &self,
            old: u32,
            new: u32,
            done: Ordering,
            failed: Ordering,
        ) -> Result<u32, u32> {
            point();
            self.0.compare_exchange(old, new, done, failed)
        }

        pub fn fetch_add(&self, value: u32, order: Ordering) -> u32 {
            point();
            self.0.fetch_add(value, order)
        }
    }
}
