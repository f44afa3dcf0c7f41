//! A firmware with RTIC, on an STM32F407, that had a lamp and a button; an axis with step and direction was added, which goes to and fro
//! when the button is pressed. What was added stands under `Motion`; nothing of what was there has changed.
//!
//! Build it: `cargo build --profile firmware -p splineway-example-rtic --target thumbv7em-none-eabihf`. Pins: step PD0, direction PD1,
//! button PA0, lamp PD12, as on the STM32F407G-DISC1.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The frameworks' macros.
#![cfg_attr(target_os = "none", allow(unsafe_code, missing_docs))]

#[cfg(target_os = "none")]
mod firmware;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("for thumbv7em-none-eabihf; there is nothing to run on a host");
}
