//! Files: the kind is told by the ending.

use super::finding::{Finding, refuse};
use super::tool_path::{Program, ReadOptions};
use super::{curve, gcode, poly};
use crate::spline::{self, SplineFile};
use anyhow::{Context, Result, bail, ensure};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Most bytes of a file: 1 GB.
const MOST_BYTES: u64 = 1_000_000_000;

/// The name of standard input.
pub const STDIN: &str = "-";

/// Reads a tool path; the kind of file is told by its ending. `-` is standard input: JSON if it begins with `{`,
/// else G-code.
///
/// # Errors
/// Names the file, and the places in it that are refused ([`refuse`]).
pub fn read(path: &Path, options: ReadOptions<'_>) -> Result<Program> {
    let (program, findings) = inspect(path, options)?;
    refuse(&findings).with_context(|| path.display().to_string())?;
    Ok(program)
}

/// The same with everything there is to say of the file, errors and warnings. If there is an error among that, the
/// program must not be run: it is what is left without what was refused.
///
/// # Errors
/// The file cannot be read, or not at all be understood; only G-code is read on behind an error.
pub fn inspect(path: &Path, options: ReadOptions<'_>) -> Result<(Program, Vec<Finding>)> {
    inspect_bytes(path, &bytes(path)?, options)
}

/// What is in a file, or comes on standard input.
///
/// # Errors
/// It cannot be read; it is larger than any program.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let count = if path == Path::new(STDIN) {
        let input = std::io::stdin().lock();
        input.take(MOST_BYTES + 1).read_to_end(&mut bytes).context("cannot read standard input")
    } else {
        let read = |file: File| file.take(MOST_BYTES + 1).read_to_end(&mut bytes);
        let name = path.display();
        File::open(path).and_then(read).with_context(|| format!("cannot read {name}"))
    };
    // A device may have no end.
    ensure!(count? as u64 <= MOST_BYTES, "{}: more than {MOST_BYTES} bytes", path.display());
    Ok(bytes)
}

/// The same of a file that has been read; `path` tells the kind.
///
/// # Errors
/// As [`inspect`].
pub fn inspect_bytes(
    path: &Path,
    bytes: &[u8],
    options: ReadOptions<'_>,
) -> Result<(Program, Vec<Finding>)> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_lowercase();
    let name = path.display();
    let text = || String::from_utf8_lossy(bytes);
    let is_json = path == Path::new(STDIN) && bytes.trim_ascii_start().starts_with(b"{");
    let program = match ending.as_str() {
        "" if is_json => curve::parse_json(&text(), options),
        "txt" if spline::is_spline(&text()) => of_spline(&text(), "txt", options),
        "txt" => poly::parse(&text()),
        "toml" => of_spline(&text(), "toml", options),
        "json" => curve::parse_json(&text(), options),
        "ngc" | "nc" | "gcode" | "tap" | "cnc" | "g" | "gc" | "gco" | "mpf" | "eia" | "" => {
            return Ok(gcode::examine(bytes, options));
        }
        _ => bail!(
            "{name}: unknown kind of file \".{ending}\"; known are .ngc .nc .gcode .gco .g .gc .tap .cnc .mpf .eia \
             (G-code), .txt (poly-line or spline), .toml (spline) and .json (spline or NURBS curve)"
        ),
    };
    let program = program.with_context(|| format!("{name}"))?;
    let findings = program.warnings.iter().map(|text| Finding::warning(0, text)).collect();
    Ok((program, findings))
}

fn of_spline(text: &str, ending: &str, options: ReadOptions<'_>) -> Result<Program> {
    curve::parse_spline(&SplineFile::parse(text, ending)?, options)
}
