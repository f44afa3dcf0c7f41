//! `splineway check`: a program before it is run.

use super::reading::{Reading, setup};
use crate::lint::{Findings, look};
use anyhow::{Context, Result};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, ReadOptions};
use splineway_simulator::run::sharp_corners;
use std::io::IsTerminal;
use std::path::PathBuf;

/// Says what the core will do with a program: what was noticed while reading it, how long it takes, where
/// the time goes, and the places that lose most of it.
#[derive(Clone, Debug, clap::Args)]
pub struct Check {
    /// G-code (.ngc .nc .gcode .tap ...), "-" for G-code on standard input, poly-line (.txt), spline (.toml) or curve (.json).
    pub file: PathBuf,
    /// Machine description (TOML); a small milling machine if left out.
    #[arg(long, value_name = "TOML")]
    pub machine: Option<PathBuf>,
    /// Greatest distance from the programmed path, mm: in place of the machine's, and of those that
    /// the program names (G64 P).
    #[arg(long, value_name = "MM")]
    pub tolerance: Option<f64>,
    /// Feed of moves before any F word, mm/s.
    #[arg(long, value_name = "MM_PER_S", default_value_t = 50.0)]
    pub feed: f64,
    /// How many slow places are shown.
    #[arg(long, default_value_t = 10)]
    pub places: usize,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but warnings and errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// How G-code is read.
    #[command(flatten)]
    pub reading: Reading,
}

impl Check {
    /// Runs the command.
    ///
    /// # Errors
    /// The file cannot be read, or not be run on this machine.
    pub fn execute(&self) -> Result<()> {
        let setup = setup(self.machine.as_deref())?;
        let options = ReadOptions { feed: self.feed, ..self.reading.options(&setup) };
        let bytes = program::bytes(&self.file)?;
        let (mut program, mut found) = program::inspect_bytes(&self.file, &bytes, options)?;
        let mut machine = match &self.machine {
            Some(path) => Machine::read(path)?,
            None => Machine::default(),
        };
        if let (Some(header), None) = (&program.header, &self.machine) {
            machine.apply(header);
        }
        machine.tolerance = self.tolerance.unwrap_or(machine.tolerance);
        super::override_tolerance(&mut program, self.tolerance);
        found.extend(splineway_simulator::run::validate(&program, &machine));
        if let Some(words) = sharp_corners(&program, &machine) {
            eprintln!("note: {words}");
        }
        program::refuse(&found).with_context(|| self.file.display().to_string())?;
        // As the file has them; of a curve there are none.
        let ending = self.file.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        let is_curve =
            matches!(ending, "json" | "toml") || bytes.trim_ascii_start().starts_with(b"{");
        let lines = if is_curve { Vec::new() } else { program::gcode::lines(&bytes) };
        let source: Vec<&str> = lines.iter().map(String::as_str).collect();
        let findings = look(&program, &machine, self.places, &source, self.quiet || self.json)?;
        for warning in program.warnings.iter().chain(&findings.advice) {
            eprintln!("{}: {warning}", paint("warning", "33", std::io::stderr().is_terminal()));
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&findings)?);
        } else if !self.quiet {
            print(&findings, &source);
        }
        Ok(())
    }
}

/// Colour, on a terminal only.
fn paint(text: &str, code: &str, colour: bool) -> String {
    if colour { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() }
}

fn print(findings: &Findings, source: &[&str]) {
    let bold = |text: &str| paint(text, "1", std::io::stdout().is_terminal());
    let [lines, arcs, curves, dwells] = findings.moves;
    println!(
        "moves     {lines} lines, {arcs} arcs, {curves} curves, {dwells} dwells; {} exact stops",
        findings.stops
    );
    println!("length    {:.3} mm", findings.length);
    for (letter, least, greatest) in &findings.extent {
        println!("  {letter}       {least:.3} to {greatest:.3}");
    }
    let [at_feed, slow, resting] = findings.shares.map(|share| share * 100.0);
    println!(
        "time      {} ({at_feed:.1} % at the feed, {slow:.1} % below it, {resting:.1} % at rest)",
        bold(&format!("{:.3} s", findings.time))
    );
    if findings.slowest.is_empty() {
        println!("no place loses time");
        return;
    }
    println!("{}", bold("  line   lost, s   time, s  slowest / feed, mm/s"));
    // Time that is lost on the way down to the slowest place, and up again, counts there.
    for place in &findings.slowest {
        let text = (place.line as usize).checked_sub(1).and_then(|n| source.get(n)).unwrap_or(&"");
        let text: String = text.trim().chars().take(48).collect();
        println!(
            "{:>6} {:>9.3} {:>9.3}  {:>8.2} / {:<8.2} {text}  ({})",
            place.line, place.lost, place.time, place.slowest, place.feed, place.cause
        );
    }
}
