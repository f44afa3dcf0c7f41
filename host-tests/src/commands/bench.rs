//! `splineway bench`: the figures of `docs/figures.md`.

use crate::view::table::{print_head, print_memory, print_row};
use anyhow::{Context, Result, ensure};
use splineway_studies::figures::Figures;
use std::path::PathBuf;

/// Runs tool paths through the core in both number types, judges them, and prints times beside those of
/// other speed laws, with memory and cost.
#[derive(Clone, Debug, clap::Args)]
pub struct Bench {
    /// Files, or folders of them; those of `host-tests/data` if left out.
    pub paths: Vec<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Endings of files that are tool paths.
const ENDINGS: [&str; 7] = ["txt", "ngc", "nc", "gcode", "tap", "cnc", "json"];

impl Bench {
    /// Runs the command.
    ///
    /// # Errors
    /// A file cannot be read or run, or a limit is broken.
    pub fn execute(&self) -> Result<()> {
        let given = if self.paths.is_empty() {
            vec![PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data")]
        } else {
            self.paths.clone()
        };
        let mut files = Vec::new();
        for path in given {
            if !path.is_dir() {
                files.push(path);
                continue;
            }
            let entries =
                path.read_dir().with_context(|| format!("cannot read {}", path.display()))?;
            let found = entries.filter_map(|entry| Some(entry.ok()?.path()));
            files.extend(found.filter(|file| {
                let ending = file.extension().and_then(|ending| ending.to_str());
                ending.is_some_and(|ending| ENDINGS.contains(&ending))
            }));
        }
        files.sort();
        ensure!(!files.is_empty(), "there are no tool paths to run");
        let figures = if self.json {
            let figures = Figures::of(&files, |_| {})?;
            println!("{}", serde_json::to_string_pretty(&figures)?);
            figures
        } else {
            print_memory();
            print_head();
            let figures = Figures::of(&files, print_row)?;
            let host = &figures.host;
            println!(
                "on {}, {} cores, {}, splineway {}",
                host.processor, host.cores, host.system, host.version
            );
            figures
        };
        let broken = figures.paths.iter().filter(|path| !path.broken.is_empty()).count();
        ensure!(broken == 0, "{broken} paths broke a limit");
        Ok(())
    }
}
