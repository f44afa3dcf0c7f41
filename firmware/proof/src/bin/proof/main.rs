//! Proof by the linker: this image calls everything a controller calls, and its panic handler needs a
//! function that does not exist. It links only if no panic can be reached.
//!
//! What is linked is also what sizes and stacks are measured on: `cargo bench -p splineway-host --bench
//! target`.
#![cfg_attr(target_os = "none", no_std, no_main)]
// Names for the linker.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
