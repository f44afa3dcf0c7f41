//! How many cases a property test draws, and which.

#![allow(dead_code)] // Every test uses a part of it.

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// How many times as many are asked for (`SOAK=20 cargo test`), if so.
fn asked() -> Option<u32> {
    std::env::var("SOAK").ok().and_then(|factor| factor.parse().ok())
}

/// How many times as many as usual.
pub fn soak() -> u32 {
    asked().unwrap_or(1)
}

/// The same cases in every run, so that a check is repeatable; `SOAK=20 cargo test --release --test
/// limits` draws twenty times as many new ones.
pub fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases: cases * soak(),
        rng_seed: if asked().is_some() { RngSeed::Random } else { RngSeed::Fixed(2023) },
        failure_persistence: None,
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    }
}
