//! What may be added to a tick, on an emulated Cortex-M: switching of outputs, input shaping, motors that follow several axes. Counts
//! the instructions of every call.
//!
//! Built and run by `cargo bench -p splineway-host --bench target`, as the other images of this package.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The register of a timer.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
#[path = "../../timer.rs"]
mod timer;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
