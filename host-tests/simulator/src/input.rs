//! Files as they are read by all who read any: as a whole, up to a size, and from standard input.

use anyhow::{Context, Result, ensure};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Most bytes of a file: 1 GB.
const MOST_BYTES: u64 = 1_000_000_000;

/// The name of standard input.
pub const STDIN: &str = "-";

/// Whether a name is that of standard input.
pub fn is_stdin(path: &Path) -> bool {
    path == Path::new(STDIN)
}

/// What a text in UTF-8 may begin with, and is no part of it.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// What is in a file, or comes on standard input, without the mark of UTF-8 before it.
///
/// # Errors
/// It cannot be read; it is larger than any program.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let count = if is_stdin(path) {
        let input = std::io::stdin().lock();
        input.take(MOST_BYTES + 1).read_to_end(&mut bytes).context("cannot read standard input")
    } else {
        let read = |file: File| file.take(MOST_BYTES + 1).read_to_end(&mut bytes);
        let name = path.display();
        File::open(path).and_then(read).with_context(|| format!("cannot read {name}"))
    };
    // A device may have no end.
    ensure!(count? as u64 <= MOST_BYTES, "{}: more than {MOST_BYTES} bytes", path.display());
    if bytes.starts_with(MARK) {
        bytes.drain(..MARK.len());
    }
    Ok(bytes)
}

/// The same as text.
///
/// # Errors
/// As [`bytes`]; it is no text.
pub fn text(path: &Path) -> Result<String> {
    String::from_utf8(bytes(path)?)
        .with_context(|| format!("cannot read {}: it is no text in UTF-8", path.display()))
}
