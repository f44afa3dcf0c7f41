//! The bench paths.

use anyhow::Context;
use splineway_studies::paths;
use std::path::PathBuf;

/// The poly-lines in the folder given on the command line, by name; without one, those of our own making.
pub fn paths() -> Vec<PathBuf> {
    let given = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let folder =
        given.map_or_else(|| made().expect("the bench paths can be written"), PathBuf::from);
    let entries = std::fs::read_dir(&folder);
    let entries =
        entries.with_context(|| folder.display().to_string()).expect("the bench paths can be read");
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "txt"));
    paths.sort();
    paths
}

/// Writes them.
fn made() -> anyhow::Result<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("paths");
    std::fs::create_dir_all(&folder)?;
    for made in paths::all()? {
        std::fs::write(folder.join(made.file_name()), made.text())?;
    }
    Ok(folder)
}
