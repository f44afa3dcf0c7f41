/tmp/w/boards/host-tests/c/hal/splineway-cargo/firmware/deps/stable_deref_trait-302f204a4e2dacf0.d: /root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/stable_deref_trait-1.2.1/src/lib.rs

/tmp/w/boards/host-tests/c/hal/splineway-cargo/firmware/deps/libstable_deref_trait-302f204a4e2dacf0.rlib: /root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/stable_deref_trait-1.2.1/src/lib.rs

/tmp/w/boards/host-tests/c/hal/splineway-cargo/firmware/deps/libstable_deref_trait-302f204a4e2dacf0.rmeta: /root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/stable_deref_trait-1.2.1/src/lib.rs

/root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/stable_deref_trait-1.2.1/src/lib.rs:
