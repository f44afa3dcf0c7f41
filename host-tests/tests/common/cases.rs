//! How many cases a property test draws, and which.

#![allow(dead_code)] // Every test uses a part of it.

use proptest::prelude::ProptestConfig;
use proptest::test_runner::RngSeed;

/// By how many times more, if more is asked for (`SOAK=20 cargo test`).
pub fn soak() -> Option<u32> {
    std::env::var("SOAK").ok().and_then(|factor| factor.parse().ok())
}

/// The same cases in every run, so that a check is repeatable; `SOAK=20 cargo test --release --test
/// limits` draws twenty times as many new ones.
pub fn config(cases: u32) -> ProptestConfig {
    let soak = soak();
    ProptestConfig {
        cases: cases * soak.unwrap_or(1),
        rng_seed: if soak.is_some() { RngSeed::Random } else { RngSeed::Fixed(2023) },
        failure_persistence: None,
        max_shrink_iters: 200,
        ..ProptestConfig::default()
    }
}
