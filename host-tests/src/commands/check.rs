//! `splineway check`: a program before it is run.

use super::files::check_stdin;
use super::numbers::{setting, whole};
use super::reading::Reading;
use crate::lint::{Extent, Findings, Listing, Moves, Shares, look};
use crate::view::Busy;
use anyhow::{Context, Result};
use splineway::machine::Quantity;
use splineway_simulator::program::{self, Loaded, Tape};
use splineway_simulator::run::sharp_corners;
use std::io::IsTerminal;
use std::path::PathBuf;

/// Says what the core will do with a program: what was noticed while reading it, how long it takes, where the time goes, and the
/// places that lose most of it
#[derive(Clone, Debug, clap::Args)]
pub struct Check {
    /// G-code (.ngc .nc .gcode .tap ...), poly-line (.txt), spline (.toml) or curve (.json); "-" is standard input: see `splineway formats`
    pub file: PathBuf,
    /// How the program is read, and the machine.
    #[command(flatten)]
    pub reading: Reading,
    /// Greatest distance from the programmed path, mm, in place of the machine's, and of those that the program names (G64 P)
    /// [default: those]
    #[arg(long, value_name = "MM", value_parser = setting(Quantity::Tolerance, "mm"))]
    pub tolerance: Option<f64>,
    /// How many slow places are shown
    #[arg(long, value_name = "COUNT", default_value_t = 10, value_parser = whole(0_usize, 1_000_000))]
    pub places: usize,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Print nothing but warnings and errors
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}

impl Check {
    /// Runs the command.
    ///
    /// # Errors
    /// The file cannot be read, or not be run on this machine.
    pub fn execute(&self) -> Result<()> {
        check_stdin(&[Some(("the program", &self.file)), self.reading.file()])?;
        let mut machine = self.reading.machine()?;
        let setup = machine.setup();
        let busy = Busy::new(format!("reading {}", self.file.display()), self.quiet);
        let file = Loaded::new(&self.file)?;
        let (program, mut found) = file.program(self.reading.options(&setup))?;
        let program = self.reading.overriding(&*program, self.tolerance);
        self.reading.apply_header(&program, &mut machine);
        machine.tolerance = self.tolerance.unwrap_or(machine.tolerance);
        found.extend(splineway_simulator::run::validate(&program, &machine));
        if let Some(words) = sharp_corners(&program, &machine) {
            eprintln!("note: {words}");
        }
        program::refuse(&found).with_context(|| self.file.display().to_string())?;
        drop(busy);
        let source = file.lines();
        let findings = look(&program, &machine, self.places, Listing::new(source), self.quiet)?;
        for warning in program.warnings().iter().chain(&findings.advice) {
            eprintln!("{}: {warning}", paint("warning", "33", std::io::stderr().is_terminal()));
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&findings)?);
        } else if !self.quiet {
            print(&findings, Listing::new(source));
        }
        Ok(())
    }
}

/// Colour, on a terminal only.
fn paint(text: &str, code: &str, colour: bool) -> String {
    if colour { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() }
}

fn print(findings: &Findings, mut source: Listing<'_>) {
    let bold = |text: &str| paint(text, "1", std::io::stdout().is_terminal());
    let Moves { lines, arcs, curves, dwells } = findings.moves;
    println!(
        "moves     {lines} lines, {arcs} arcs, {curves} curves, {dwells} dwells; {} exact stops",
        findings.stops
    );
    println!("length    {:.3} mm", findings.length);
    for Extent { axis, least, greatest, .. } in &findings.extent {
        println!("  {axis}       {least:.3} to {greatest:.3}");
    }
    let Shares { at_feed, below_feed, at_rest } = findings.shares;
    let [at_feed, slow, resting] = [at_feed, below_feed, at_rest].map(|share| share * 100.0);
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
        let text = source.line(place.line);
        let text: String = text.trim().chars().take(48).collect();
        // What goes nowhere has no feed.
        let feed = if place.feed.is_finite() { format!("{:.2}", place.feed) } else { "-".into() };
        println!(
            "{:>6} {:>9.3} {:>9.3}  {:>8.2} / {feed:<8} {text}  ({})",
            place.line, place.lost, place.time, place.worst.slowest, place.cause
        );
    }
}
