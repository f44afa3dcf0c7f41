/tmp/w/boards/host-tests/c/hal/splineway-cargo/firmware/deps/byteorder-1b2be7adaf885947.d: /root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/byteorder-1.5.0/src/lib.rs

/tmp/w/boards/host-tests/c/hal/splineway-cargo/firmware/deps/libbyteorder-1b2be7adaf885947.rlib: /root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/byteorder-1.5.0/src/lib.rs

/tmp/w/boards/host-tests/c/hal/splineway-cargo/firmware/deps/libbyteorder-1b2be7adaf885947.rmeta: /root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/byteorder-1.5.0/src/lib.rs

/root/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/byteorder-1.5.0/src/lib.rs:
