//! The core on an emulated Cortex-M: runs the frames of a file, counts the instructions of every call,
//! and prints a digest of all setpoints, which must be that of the host.
//!
//! Built and run by `cargo bench -p splineway-host --bench target`. The file's name is the image's
//! argument; it comes by semihosting. Instructions are counted with a timer: under QEMU's `-icount
//! shift=6` every instruction takes 64 ns.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The register of a timer.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod timer;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
