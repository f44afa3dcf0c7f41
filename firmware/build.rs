//! Build script of every image: hands the memory map of the top level to the linker.

use std::env;
use std::fs;
use std::path::PathBuf;

/// The memory map, from the folder of an image.
const MEMORY: &str = "../../memory.x";

fn main() {
    println!("cargo:rerun-if-changed=../build.rs");
    println!("cargo:rerun-if-changed={MEMORY}");
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os != "none") {
        // An empty program on a host.
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy(MEMORY, out.join("memory.x")).expect("the memory map can be copied");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if env::var("CARGO_PKG_NAME").is_ok_and(|name| name == "splineway-stm32f407") {
        // The only one with a log.
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}
