//! A complete controller of three axes for senders of grbl, on a board that QEMU emulates: `mps2-an386`, a Cortex-M4F. It
//! is the image of `firmware/stm32f407` with other pins and clocks, so that all of it runs where there is no board: the
//! line byte by byte, planning that takes time, step and direction at 100 kHz.
//!
//! Under QEMU's `-icount shift=3` an instruction takes 8 ns, which is fair for a Cortex-M4F at 168 MHz that needs 1.35
//! cycles for one. Flash waits, contention on buses and the entry of interrupts are not modelled.
//!
//! | port of QEMU | what |
//! |---|---|
//! | `serial0` | the line to the sender; bytes take the time that they take at `machine::BAUD` |
//! | `serial1` | the output pins: every change of a level and when ([`splineway_mps2::pins`]) |
//! | `serial2` | a log: what the machine does, plans, late plans, times |
//! | `serial3` | the input pins: a byte is the levels from now on, bits 0 to 2 limit switches, 3 probe, 4 door, 5 emergency stop |
//!
//! Five contexts, the lower ones interrupted by the higher:
//!
//! | priority | task | what it does |
//! |---|---|---|
//! | 4 | `steps`, timer interrupt at `machine::STEP_HZ` | one tick of every axis; every servo cycle begins here |
//! | 3 | `servo`, started by it, `inputs` | `Interpolator::tick`, the next targets; limit switches, probe, emergency stop |
//! | 2 | `receive`, `line` | bytes on the line |
//! | 0 | `idle` | lines of G-code, planning, the log, the watchdog |
//!
//! How to run it: `docs/emulated.md`.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The frameworks' macros, and registers.
#![cfg_attr(target_os = "none", allow(unsafe_code, missing_docs))]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod device;
#[cfg(target_os = "none")]
#[path = "../../followers.rs"]
mod followers;
#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod log;
#[cfg(target_os = "none")]
#[path = "../../machine.rs"]
mod machine;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
