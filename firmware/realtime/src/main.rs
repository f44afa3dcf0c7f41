//! The core in real time on an emulated Cortex-M4F (QEMU's `mps2-an386`), or M7 (`mps2-an500`): a timer interrupt calls the
//! interpolator every servo cycle, and the background plans meanwhile, as on a board.
//!
//! Built and run by `cargo bench -p splineway-host --bench realtime`. Under QEMU's `-icount shift=3` every instruction
//! takes 8 ns, which is fair for a Cortex-M4F at 168 MHz that needs 1.35 cycles for one. Flash waits, contention on
//! buses and the entry of interrupts are not modelled. A run is the same every time.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The register of a timer.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
