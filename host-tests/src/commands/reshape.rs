//! `splineway reshape`: what is gained by improving shape and speed of the planned motion together.

use super::files::{self, named};
use super::limit::{check_setpoints, write};
use super::numbers::setting;
use super::reading::Reading;
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use splineway::machine::Quantity;
use splineway_simulator::judge::violations;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, LETTERS, Tape};
use splineway_simulator::run::Precision;
use splineway_studies::reshaping::reshaped;
use std::path::{Path, PathBuf};

/// Plans a tool path, improves shape and speed of the planned motion together inside the band, window by window as a controller
/// would, and judges what comes out. The controllers themselves do not do this yet
#[derive(Clone, Debug, clap::Args)]
pub struct Reshape {
    /// Tool paths, as for `simulate`; "-" is standard input
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// How programs are read, and the machine.
    #[command(flatten)]
    pub reading: Reading,
    /// Greatest distance from the programmed path, mm, in place of the machine's, and of those that the program names (G64 P)
    /// [default: those]
    #[arg(long, value_name = "MM", value_parser = setting(Quantity::Tolerance, "mm"))]
    pub tolerance: Option<f64>,
    /// Scalar of the windows; the planned motion is of double precision
    #[arg(long, value_enum, default_value_t)]
    pub precision: Precision,
    /// Writes the setpoints of the improved motion (CSV; one file only) [default: not written]
    #[arg(long, value_name = "CSV")]
    pub setpoints: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// What is printed of a path: times in s, deviation in mm, peaks as shares of the limits.
#[derive(Serialize)]
struct Row {
    path: String,
    planned_s: f64,
    reshaped_s: f64,
    planned_over_reshaped_ratio: f64,
    windows: usize,
    refused: usize,
    steps: usize,
    deviation_mm: f64,
    velocity_share: f64,
    acceleration_share: f64,
    jerk_share: f64,
    broken: Vec<String>,
}

impl Reshape {
    /// Runs the command.
    ///
    /// # Errors
    /// A file cannot be read or run, or a motion breaks a limit.
    pub fn execute(&self) -> Result<()> {
        check_setpoints(self.setpoints.as_deref(), &self.files)?;
        let mut inputs: Vec<_> =
            self.files.iter().map(|file| Some(("a tool path", file.as_path()))).collect();
        inputs.push(self.reading.file());
        files::check(&inputs, &[named("--setpoints", self.setpoints.as_ref())])?;
        let machine = self.reading.machine()?;
        let mut rows = Vec::new();
        if !self.json {
            println!(
                "{:32} {:>10} {:>11} {:>8} {:>8} {:>8} {:>8}",
                "", "planned, s", "reshaped, s", "ratio", "windows", "refused", "steps"
            );
        }
        for file in &self.files {
            let row =
                self.look(file, machine.clone()).with_context(|| file.display().to_string())?;
            if !self.json {
                println!(
                    "{:32} {:>10.3} {:>11.3} {:>8.3} {:>8} {:>8} {:>8}  {}",
                    row.path,
                    row.planned_s,
                    row.reshaped_s,
                    row.planned_over_reshaped_ratio,
                    row.windows,
                    row.refused,
                    row.steps,
                    row.broken.join("  ")
                );
            }
            rows.push(row);
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&rows)?);
        }
        let broken = rows.iter().filter(|row| !row.broken.is_empty()).count();
        ensure!(broken == 0, "{broken} of the motions break a limit");
        Ok(())
    }

    fn look(&self, file: &Path, mut machine: Machine) -> Result<Row> {
        let setup = machine.setup();
        let program = program::read(file, self.reading.options(&setup))?;
        let program = self.reading.overriding(&program, self.tolerance).to_program();
        self.reading.apply_header(&program, &mut machine);
        machine.tolerance = self.tolerance.unwrap_or(machine.tolerance);
        let found = reshaped(&program, &machine, self.precision)?;
        if let Some(out) = &self.setpoints {
            let letters = program.axes().into_iter().map(|axis| LETTERS[axis].to_ascii_lowercase());
            write(out, &found.setpoints, machine.cycle, letters)?;
        }
        let worst = found.verdict.worst();
        Ok(Row {
            path: file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            planned_s: found.planned,
            reshaped_s: found.reshaped,
            planned_over_reshaped_ratio: found.planned / found.reshaped,
            windows: found.windows,
            refused: found.refused,
            steps: found.steps,
            deviation_mm: found.verdict.deviation,
            velocity_share: worst.velocity,
            acceleration_share: worst.acceleration,
            jerk_share: worst.jerk,
            broken: violations(&found.verdict),
        })
    }
}
