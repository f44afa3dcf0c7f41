//! Any bytes as G-code in every dialect, or as a poly-line: they are read or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use splineway_host::program::{Dialect, ReadOptions, gcode, poly};

fuzz_target!(|data: &[u8]| {
    for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Marlin] {
        for lenient in [false, true] {
            let options = ReadOptions { dialect: Some(dialect), lenient, ..ReadOptions::DEFAULT };
            let _ = gcode::examine(data, options);
        }
    }
    let _ = poly::parse(&String::from_utf8_lossy(data));
});
