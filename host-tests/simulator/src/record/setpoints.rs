//! Setpoints as CSV.

use crate::machine::MotorRow;
use crate::run::{Observer, Sample};
use anyhow::{Context, Result};
use std::fs::File;
use std::path::Path;

/// Writes `t,x,y,z` (the axes in use, then the motors by their names), one row per servo cycle, 15 significant digits.
#[derive(Debug)]
pub struct CsvOut {
    writer: csv::Writer<File>,
    row: Vec<String>,
    motors: Vec<MotorRow>,
    name: String,
}

impl CsvOut {
    /// Creates the file and its header.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(path: &Path, letters: &[char], motors: Vec<MotorRow>) -> Result<Self> {
        let file =
            File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        let mut writer = csv::Writer::from_writer(file);
        let mut header = vec!["t".to_owned()];
        header.extend(letters.iter().map(|letter| letter.to_ascii_lowercase().to_string()));
        header.extend(motors.iter().map(|motor| motor.name.clone()));
        writer.write_record(&header)?;
        Ok(Self { writer, row: Vec::new(), motors, name: path.display().to_string() })
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
        let motors = self.motors.iter().map(|motor| motor.of(sample.position));
        let all = sample.position.iter().copied().chain(motors);
        self.row.extend(all.map(|x| format!("{x:.14e}")));
        self.writer.write_record(&self.row).with_context(|| format!("cannot write {}", self.name))
    }
}
