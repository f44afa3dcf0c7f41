//! A complete controller of three axes on an STM32F407: blocks over a serial line, step and direction
//! out, a duty cycle in proportion to the speed along the path, emergency stop and limit switches.
//!
//! Four contexts, the lower ones interrupted by the higher:
//!
//! | priority | task | what it does |
//! |---|---|---|
//! | 4 | `steps`, timer interrupt at `machine::STEP_HZ` | one tick of every axis; every servo cycle begins here |
//! | 3 | `servo`, started by it | `Interpolator::tick`, the next targets |
//! | 2 | `receive`, `emergency`, `limit` | a byte from the line; inputs |
//! | 0 | `idle` | the line, planning, the watchdog |
//!
//! Wiring is in `board.rs`, rates and limits in `../machine.rs`; `docs/boards.md` says more.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The frameworks' macros.
#![cfg_attr(target_os = "none", allow(unsafe_code, missing_docs))]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
#[path = "../../machine.rs"]
mod machine;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
