//! Any text as a spline file: it is read or refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use splineway_simulator::program::{ReadOptions, curve};
use splineway_simulator::spline::SplineFile;

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data);
    let options = ReadOptions { feed: 50.0, ..ReadOptions::DEFAULT };
    for ending in ["txt", "toml"] {
        if let Ok(file) = SplineFile::parse(&text, ending) {
            let _ = curve::parse_spline(&file, options);
        }
    }
    for segments in [None, Some(8)] {
        let _ = curve::parse_json(&text, ReadOptions { segments, ..options });
    }
});
