//! Setpoints as CSV.

use crate::run::{Observer, Sample};
use anyhow::{Context, Result};
use std::fs::File;
use std::path::Path;

/// Writes `t,x,y,z` (the axes in use), one row per servo cycle, 15 significant digits.
#[derive(Debug)]
pub struct CsvOut {
    writer: csv::Writer<File>,
    row: Vec<String>,
    name: String,
}

impl CsvOut {
    /// Creates the file and its header.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(path: &Path, letters: &[char]) -> Result<Self> {
        let file =
            File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        let mut writer = csv::Writer::from_writer(file);
        let mut header = vec!["t".to_owned()];
        header.extend(letters.iter().map(|letter| letter.to_ascii_lowercase().to_string()));
        writer.write_record(&header)?;
        Ok(Self { writer, row: Vec::new(), name: path.display().to_string() })
    }

    /// Writes what is buffered.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<()> {
        self.writer.flush().with_context(|| format!("cannot write {}", self.name))
    }
}

impl Observer for CsvOut {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        self.row.clear();
        self.row.push(format!("{:.9}", sample.time));
        self.row.extend(sample.position.iter().map(|x| format!("{x:.14e}")));
        self.writer.write_record(&self.row).with_context(|| format!("cannot write {}", self.name))
    }
}
