//! `splineway bench`: the figures of `docs/figures.md`.

use super::files;
use crate::view::bar;
use crate::view::table::{print_head, print_memory, print_row};
use anyhow::{Context, Result, ensure};
use splineway_simulator::program::Kind;
use splineway_studies::figures::{Figures, PathFigures};
use splineway_studies::paths;
use std::path::PathBuf;

/// Runs tool paths through the core in both number types, judges them, and prints times beside those of
/// other speed laws, with memory and cost
#[derive(Clone, Debug, clap::Args)]
pub struct Bench {
    /// Files, or folders of them, or "-" for standard input [default: paths that this program makes itself]
    pub paths: Vec<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

impl Bench {
    /// Runs the command.
    ///
    /// # Errors
    /// A file cannot be read or run, or a limit is broken.
    pub fn execute(&self) -> Result<()> {
        let files = self.files()?;
        let made = if files.is_empty() { paths::all()? } else { Vec::new() };
        let count = files.len() + made.len();
        let bar = bar(count as u64, false, "{bar:40} {pos}/{len} paths  {elapsed}");
        let run = |each: &mut dyn FnMut(&PathFigures)| {
            let each = |figures: &PathFigures| {
                bar.suspend(|| each(figures));
                bar.inc(1);
            };
            let figures = if files.is_empty() {
                Figures::of_made(&made, each)
            } else {
                Figures::of(&files, each)
            };
            bar.finish_and_clear();
            figures
        };
        let figures = if self.json {
            let figures = run(&mut |_| {})?;
            println!("{}", serde_json::to_string_pretty(&figures)?);
            figures
        } else {
            print_memory();
            print_head();
            let figures = run(&mut print_row)?;
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

    /// The files that were named, and those of folders; none if none were.
    fn files(&self) -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        for path in &self.paths {
            if !path.is_dir() {
                files.push(path.clone());
                continue;
            }
            let entries =
                path.read_dir().with_context(|| format!("cannot read {}", path.display()))?;
            let found = entries.filter_map(|entry| Some(entry.ok()?.path()));
            // In a folder, .toml may be a machine.
            let is_path = |file: &PathBuf| {
                let kind = file.extension().and_then(|_| Kind::of(file));
                kind.is_some_and(|kind| kind != Kind::Toml)
            };
            files.extend(found.filter(is_path));
        }
        files.sort();
        let inputs: Vec<_> =
            files.iter().map(|file| Some(("a tool path", file.as_path()))).collect();
        files::check(&inputs, &[])?;
        ensure!(self.paths.is_empty() || !files.is_empty(), "there are no tool paths to run");
        Ok(files)
    }
}
