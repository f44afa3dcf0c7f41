//! Hands the memory map to the linker when a firmware image is built; a library has none.

use std::env;
use std::fs;
use std::path::PathBuf;

/// Features that stand for an image.
const IMAGES: [&str; 3] = ["STM32F407", "EMULATOR", "PROOF"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    let set = |name: &&str| env::var_os(format!("CARGO_FEATURE_{name}")).is_some();
    let bare = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if !bare || !IMAGES.iter().any(set) {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("memory.x", out.join("memory.x")).expect("the memory map can be copied");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    println!("cargo:rustc-link-arg-bins=--nmagic");
    if set(&"STM32F407") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
}
