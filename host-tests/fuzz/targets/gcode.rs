//! Any text as G-code or as a poly-line: it is read or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use splineway_host::program::{gcode, poly};

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data);
    let _ = gcode::parse(&text, 50.0);
    let _ = poly::parse(&text);
});
