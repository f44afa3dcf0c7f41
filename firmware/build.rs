//! Build script of every image, and of the examples for a chip: hands the memory map to the linker.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

/// The memory map, from the folder of an image: its own, or that of all others.
const OWN: &str = "memory.x";
const MEMORY: &str = "../memory.x";
/// Names of interrupts, of an image that brings its own device.
const DEVICE: &str = "device.x";
/// Images that have a log by defmt.
const LOGGED: [&str; 3] = ["splineway-stm32f407", "splineway-stm32h743", "splineway-example-rtic"];

fn main() {
    for file in [OWN, MEMORY, DEVICE] {
        if Path::new(file).exists() {
            println!("cargo:rerun-if-changed={file}");
        }
    }
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os != "none") {
        // An empty program on a host.
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let memory = if Path::new(OWN).exists() { OWN } else { MEMORY };
    fs::copy(memory, out.join("memory.x")).expect("the memory map can be copied");
    if Path::new(DEVICE).exists() {
        fs::copy(DEVICE, out.join("device.x")).expect("the names of interrupts can be copied");
    }
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if env::var("CARGO_PKG_NAME").is_ok_and(|name| LOGGED.contains(&name.as_str())) {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}
