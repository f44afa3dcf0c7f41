//! The proof of `proof` for what lies around the core: outputs, the checks of a program, the wire, the protocol of grbl, the reader of
//! G-code, splines, and the interface for C. It links only if no panic can be reached from any of them.
#![cfg_attr(target_os = "none", no_std, no_main)]
// Names for the linker, and the interface for C.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod curves;
#[cfg(target_os = "none")]
mod grbl;
#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod line;
#[cfg(target_os = "none")]
mod text;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("an image for thumbv7em-none-eabihf; there is nothing to run on a host");
}
