//! The atomics that contexts share: those of `core`, or, in tests under `cfg(loom)`, those of the model checker
//! [loom](https://docs.rs/loom), which tries every interleaving and every value that the memory model lets a load
//! see. See `servo/models.rs`.

#[cfg(not(all(test, loom)))]
pub use core::sync::atomic::{AtomicU32, fence};

#[cfg(all(test, loom))]
pub mod modelled;
#[cfg(all(test, loom))]
pub use modelled::{AtomicU32, fence};
