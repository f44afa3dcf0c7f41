//! A complete controller of three axes on an STM32H743, a Cortex-M7: the image of `firmware/stm32f407` with other pins, clocks and
//! interrupts. With the feature `f64` the core computes in double precision.
//!
//! Pins, clocks and interrupts are in `board.rs`, tasks in `../stm32.rs`, rates and limits in `../machine.rs`; `docs/boards.md` says
//! more.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The frameworks' macros.
#![cfg_attr(target_os = "none", allow(unsafe_code, unsafe_op_in_unsafe_fn, missing_docs))]

// First, for its macro.
#[cfg(target_os = "none")]
#[macro_use]
#[path = "../../stm32.rs"]
mod tasks;

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
#[path = "../../followers.rs"]
mod followers;
#[cfg(target_os = "none")]
#[path = "../../machine.rs"]
mod machine;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
