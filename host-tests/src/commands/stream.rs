//! `splineway stream`: a program to a controller over a serial line.

use crate::program::{self, LETTERS, ReadOptions};
use crate::stream::{Command, Summary, parse_command, send};
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use serial2::SerialPort;
use splineway::wire::{Situation, State};
use std::io::{BufRead, IsTerminal};
use std::path::PathBuf;
use std::sync::mpsc::{Sender, channel};

const EXAMPLES: &str = "\
While the program runs, lines on standard input are commands to the controller:
  hold | resume | stop | abort | feed PERCENT | rapid PERCENT | single on | single off
Ctrl-C aborts: the machine brakes on the path and drops the rest.

Example, without hardware:
  splineway controller            (prints the name of its port)
  splineway stream host-tests/examples/butterfly.json --port /dev/pts/3

Exit codes: 0 run to its end, 1 error or aborted, 2 wrong usage.";

/// Sends a program to a controller and waits until it has been run.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Stream {
    /// G-code (.ngc .nc .gcode .tap .cnc), poly-line (.txt), spline (.toml) or curve (.json).
    pub file: PathBuf,
    /// The serial port.
    #[arg(long)]
    pub port: PathBuf,
    /// Bits per second.
    #[arg(long, default_value_t = 921_600)]
    pub baud: u32,
    /// Feed of moves before any F word, mm/s.
    #[arg(long, value_name = "MM_PER_S", default_value_t = 50.0)]
    pub feed: f64,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

impl Stream {
    /// Runs the command.
    ///
    /// # Errors
    /// What the file, the port or the controller has against it.
    pub fn execute(&self) -> Result<()> {
        let options = ReadOptions { feed: self.feed, ..ReadOptions::DEFAULT };
        let program = program::read(&self.file, options)?.with_approach();
        for warning in &program.warnings {
            eprintln!("warning: {warning}");
        }
        let mut port = SerialPort::open(&self.port, self.baud)
            .with_context(|| format!("cannot open {}", self.port.display()))?;
        let (sender, commands) = channel();
        let interrupt = sender.clone();
        ctrlc::set_handler(move || {
            // Nobody listens any more only when the program has ended.
            let _ = interrupt.send(Command::Abort);
        })?;
        listen(sender);
        let bar = bar(self.quiet);
        let outcome = send(&mut port, &program, &commands, |taken, items, situation| {
            bar.set_length(u64::from(items));
            bar.set_position(u64::from(taken));
            bar.set_message(describe(situation));
        });
        bar.finish_and_clear();
        let summary = outcome.with_context(|| self.port.display().to_string())?;
        if !self.quiet {
            print(&summary);
        }
        anyhow::ensure!(!summary.aborted, "aborted");
        Ok(())
    }
}

/// Commands from standard input.
fn listen(sender: Sender<Command>) {
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if line.trim().is_empty() {
                continue;
            }
            match parse_command(&line) {
                Ok(command) => {
                    if sender.send(command).is_err() {
                        return;
                    }
                }
                Err(error) => eprintln!("{error}"),
            }
        }
    });
}

fn bar(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len}  {msg}") {
        bar.set_style(style);
    }
    bar
}

fn describe(situation: &Situation) -> String {
    let state = match situation.state {
        State::Idle => "idle",
        State::Running => "running",
        State::Held => "held",
        State::Alarm => "alarm",
    };
    let axes = LETTERS.iter().zip(&situation.position);
    let place: Vec<String> =
        axes.map(|(letter, &nm)| format!("{letter}{:.3}", nm as f64 * 1.0e-6)).collect();
    format!("{state}, line {}, {:.1} mm/s, {}", situation.tag, situation.speed, place.join(" "))
}

fn print(summary: &Summary) {
    println!("{} blocks taken, {} items sent", summary.blocks, summary.sent);
    println!("{}", describe(&summary.situation));
    if summary.damaged > 0 {
        println!(
            "{} damaged frames on the line; nothing is lost, but look at the wiring",
            summary.damaged
        );
    }
    if summary.situation.starved > 0 {
        println!(
            "{} stops because blocks came too late: a higher --baud may help",
            summary.situation.starved
        );
    }
}
