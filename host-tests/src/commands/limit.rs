//! `splineway limit`: how much faster any motion could be.

use super::files::{self, named};
use super::numbers::{Usage, between, positive, setting, whole};
use super::reading::Reading;
use anyhow::{Context, Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use splineway::machine::Quantity;
use splineway_simulator::judge::violations;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, LETTERS, Tape};
use splineway_studies::anymotion::{Found, Options, least_time};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Finds the least time of any motion inside the band of a tool path, shape and speed together, and says how near to it the
/// planned motion is. It takes some seconds of work for every second of motion. What it finds can be reached, for the
/// judge looks at it; that nothing is faster is not proven
#[derive(Clone, Debug, clap::Args)]
pub struct Limit {
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
    /// Time between the knots of the motion, ms
    #[arg(long, value_name = "MS", default_value_t = 2.0, value_parser = between(0.25, 50.0, "ms"))]
    pub step: f64,
    /// Most rounds
    #[arg(long, value_name = "COUNT", default_value_t = 20, value_parser = whole(0_usize, 1_000_000))]
    pub rounds: usize,
    /// Longest motion that is looked at, s
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = positive())]
    pub longest: f64,
    /// Writes the setpoints of the motion found (CSV; one file only) [default: not written]
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
    least_s: f64,
    planned_over_least_ratio: f64,
    rounds: usize,
    deviation_mm: f64,
    velocity_share: f64,
    acceleration_share: f64,
    jerk_share: f64,
    broken: Vec<String>,
}

/// Setpoints are those of one file.
///
/// # Errors
/// There are more.
pub fn check_setpoints(setpoints: Option<&Path>, files: &[PathBuf]) -> Result<()> {
    let files = files.len();
    if setpoints.is_some() && files > 1 {
        return Err(Usage::error(format!("--setpoints is for one file; there are {files}")));
    }
    Ok(())
}

impl Limit {
    /// Runs the command.
    ///
    /// # Errors
    /// A file cannot be read or run, no motion is found, or the one found breaks a limit.
    pub fn execute(&self) -> Result<()> {
        check_setpoints(self.setpoints.as_deref(), &self.files)?;
        let mut inputs: Vec<_> =
            self.files.iter().map(|file| Some(("a tool path", file.as_path()))).collect();
        inputs.push(self.reading.file());
        files::check(&inputs, &[named("--setpoints", self.setpoints.as_ref())])?;
        let machine = self.reading.machine()?;
        let mut rows = Vec::new();
        if !self.json {
            println!("{:32} {:>10} {:>10} {:>8}", "", "planned, s", "least, s", "ratio");
        }
        for file in &self.files {
            let row =
                self.look(file, machine.clone()).with_context(|| file.display().to_string())?;
            if !self.json {
                println!(
                    "{:32} {:>10.3} {:>10.3} {:>8.3}{}",
                    row.path,
                    row.planned_s,
                    row.least_s,
                    row.planned_over_least_ratio,
                    row.broken.iter().fold(String::new(), |mut all, broken| {
                        let _ = write!(all, "  {broken}");
                        all
                    })
                );
            }
            rows.push(row);
        }
        let mean =
            rows.iter().map(|row| row.planned_over_least_ratio).sum::<f64>() / rows.len() as f64;
        if self.json {
            println!("{}", serde_json::to_string_pretty(&rows)?);
        } else if rows.len() > 1 {
            println!("{:32} {:>10} {:>10} {mean:>8.3}", "mean", "", "");
        }
        let broken = rows.iter().filter(|row| !row.broken.is_empty()).count();
        ensure!(broken == 0, "{broken} of the motions found break a limit");
        Ok(())
    }

    fn look(&self, file: &Path, mut machine: Machine) -> Result<Row> {
        let setup = machine.setup();
        let program = program::read(file, self.reading.options(&setup))?;
        let program = self.reading.overriding(&program, self.tolerance).to_program();
        self.reading.apply_header(&program, &mut machine);
        machine.tolerance = self.tolerance.unwrap_or(machine.tolerance);
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let bar = ProgressBar::new_spinner();
        bar.set_style(ProgressStyle::with_template("{spinner} {msg}")?);
        let options =
            Options { step: self.step * 1.0e-3, rounds: self.rounds, longest: self.longest };
        let found = least_time(&program, &machine, &options, |part, round, time, outside| {
            bar.set_message(format!(
                "{name}: part {}, round {}: {time:.4} s, {outside:.4} of the band outside",
                part + 1,
                round + 1
            ));
            bar.tick();
        })?;
        bar.finish_and_clear();
        if let Some(out) = &self.setpoints {
            let letters = program.axes().into_iter().map(|axis| LETTERS[axis].to_ascii_lowercase());
            write(out, &found.setpoints, machine.cycle, letters)?;
        }
        let Found { planned, least, verdict, rounds, .. } = &found;
        let worst = verdict.worst();
        Ok(Row {
            path: name,
            planned_s: *planned,
            least_s: *least,
            planned_over_least_ratio: planned / least,
            rounds: *rounds,
            deviation_mm: verdict.deviation,
            velocity_share: worst.velocity,
            acceleration_share: worst.acceleration,
            jerk_share: worst.jerk,
            broken: violations(verdict),
        })
    }
}

/// As `simulate` writes setpoints.
pub(super) fn write(
    out: &Path,
    setpoints: &[Vec<f64>],
    cycle: f64,
    letters: impl Iterator<Item = char>,
) -> Result<()> {
    let mut text = String::from("t");
    for letter in letters {
        let _ = write!(text, ",{letter}");
    }
    text.push('\n');
    for (k, position) in setpoints.iter().enumerate() {
        let _ = write!(text, "{:.9}", k as f64 * cycle);
        for x in position {
            let _ = write!(text, ",{x:.14e}");
        }
        text.push('\n');
    }
    std::fs::write(out, text).with_context(|| format!("cannot write {}", out.display()))
}
