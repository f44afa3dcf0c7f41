//! `splineway stream`: a program to a controller over a serial line.

use super::reading::{Reading, setup};
use crate::stream::{
    Controlled, News, Order, Settings, Summary, check, describe_place, describe_state, items,
    open_port, parse_command, placed, send,
};
use anyhow::{Context, Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use splineway::wire::{Item, Situation};
use splineway_simulator::program::{self, AXES, Point, ReadOptions, STDIN, refuse};
use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Sender, channel};

const EXAMPLES: &str = "\
While the program runs, lines on standard input are commands to the controller:
  hold | resume | stop | abort | feed 0..200 | rapid 0..100 | single on | single off
  jog X20 Y-5 for SECONDS (mm/s) | jog-step X0.1 at FEED | jog-to X0 Y0 at FEED | jog-back at FEED | jog-cancel
If the program itself comes from there (-), there are none: Ctrl-C aborts.

The machine is aborted - it brakes on the path and drops the rest - and this program waits until it stands:
  on Ctrl-C, SIGTERM and SIGHUP (a second one does not wait), on every error, and when standard input ends if
  that is a terminal. The end of a pipe or a file is only the end of its commands.
If this program dies otherwise, or the cable comes off, the controller holds the machine after --watchdog
seconds. The next `stream` is refused then, unless --abort drops what is left.

A G-code program begins where the machine stands. Poly-lines, splines and curves begin at their own first
point: if the machine stands elsewhere, they are refused unless --approach says to move there first.
The whole program is read and checked before the first block is sent.

Example, without hardware:
  splineway controller            (prints the name of its port)
  splineway stream host-tests/data/butterfly.json --port /dev/pts/3 --approach

Exit codes: 0 run to its end, 1 error or aborted, 2 wrong usage.";

/// Sends a program to a controller and waits until it has been run.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Stream {
    /// G-code (.ngc .nc .gcode .tap ...), "-" for G-code on standard input, poly-line (.txt), spline (.toml) or
    /// curve (.json).
    pub file: PathBuf,
    /// The serial port. It is locked: one sender at a time.
    #[arg(long)]
    pub port: PathBuf,
    /// Bits per second.
    #[arg(long, default_value_t = 921_600)]
    pub baud: u32,
    /// Feed of moves before any F word, mm/s.
    #[arg(long, value_name = "MM_PER_S", default_value_t = 50.0)]
    pub feed: f64,
    /// Silence of this program after which the controller stops the machine, 0.1 to 60; 0: never.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0)]
    pub watchdog: f64,
    /// Move straight to the first point of a path that does not begin where the machine stands.
    #[arg(long)]
    pub approach: bool,
    /// Abort what a program before has left whose sender is gone.
    #[arg(long)]
    pub abort: bool,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Machine description (TOML), for its work offsets, tools and reference points.
    #[arg(long, value_name = "TOML")]
    pub machine: Option<PathBuf>,
    /// How G-code is read.
    #[command(flatten)]
    pub reading: Reading,
}

impl Stream {
    /// Runs the command.
    ///
    /// # Errors
    /// What the file, the port or the controller has against it.
    pub fn execute(&self) -> Result<()> {
        ensure!(
            self.watchdog == 0.0 || (0.1..=60.0).contains(&self.watchdog),
            "watchdog is {} s; it must be 0.1 to 60, or 0 for none",
            self.watchdog
        );
        // All of it, before the port is anybody's: standard input may be slow.
        let program = program::bytes(&self.file)?;
        let settings =
            Settings { silence: (self.watchdog * 1000.0).round() as u16, abort: self.abort };
        let mut port = open_port(&self.port, self.baud)?;
        let (sender, orders) = channel();
        obey_signals(sender.clone())?;
        if self.file != Path::new(STDIN) {
            listen(sender);
        }
        let bar = bar(self.quiet);
        let outcome = send(
            &mut port,
            settings,
            |controlled| self.prepare(&program, controlled),
            &orders,
            &mut |news| match news {
                News::Status { taken, items, situation } => {
                    bar.set_length(u64::from(items));
                    bar.set_position(u64::from(taken));
                    bar.set_message(describe(situation));
                }
                News::Event { line, event } if !self.quiet => {
                    bar.suspend(|| say(&format!("line {line}: {event}")));
                }
                News::Event { .. } => {}
                News::Notice(notice) => bar.suspend(|| complain(notice)),
            },
        );
        bar.finish_and_clear();
        let summary = outcome.with_context(|| self.port.display().to_string())?;
        if !self.quiet {
            print(&summary);
        }
        match summary.aborted {
            Some(reason) => Err(anyhow::anyhow!(
                "aborted: {reason}; the machine stands at {}",
                describe_place(&summary.situation.position)
            )),
            None => Ok(()),
        }
    }

    /// The program for the machine where it stands, read and checked as a whole.
    fn prepare(&self, bytes: &[u8], controlled: &Controlled) -> Result<Vec<Item>> {
        let position = &controlled.situation.position;
        let mut start: Point = [0.0; AXES];
        for (mm, &nm) in start.iter_mut().zip(position) {
            *mm = nm as f64 * 1.0e-6;
        }
        let setup = setup(self.machine.as_deref())?;
        let options = ReadOptions { feed: self.feed, start, ..self.reading.options(&setup) };
        let name = self.file.display();
        let (program, found) = program::inspect_bytes(&self.file, bytes, options)?;
        refuse(&found).with_context(|| name.to_string())?;
        for warning in &program.warnings {
            complain(&format!("warning: {warning}"));
        }
        let (program, approach) = placed(&program, &start, self.approach)?;
        if let Some(to) = approach {
            let words = |point: &Point| -> String {
                let nm: Vec<i64> = point[..controlled.axes.min(AXES)]
                    .iter()
                    .map(|mm| (mm * 1.0e6).round() as i64)
                    .collect();
                describe_place(&nm)
            };
            complain(&format!("--approach: first from {} to {}", words(&start), words(&to)));
        }
        let items = items(&program, controlled.axes).with_context(|| name.to_string())?;
        refuse(&check(&items, position)?).with_context(|| name.to_string())?;
        Ok(items)
    }
}

/// Writes a line to standard output. If nobody reads it, the machine is of more importance.
fn say(line: &str) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// The same to standard error.
fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Ctrl-C, SIGTERM and SIGHUP: the first aborts and waits, the second does not wait, the third ends at once.
fn obey_signals(sender: Sender<Order>) -> Result<()> {
    static SEEN: AtomicU32 = AtomicU32::new(0);
    ctrlc::set_handler(move || {
        let gone = sender.send(Order::Leave("interrupted")).is_err();
        if gone || SEEN.fetch_add(1, Ordering::Relaxed) >= 2 {
            std::process::exit(130);
        }
    })?;
    Ok(())
}

/// Commands from standard input. Its end is the operator's only if it is a terminal.
fn listen(sender: Sender<Order>) {
    std::thread::spawn(move || {
        let terminal = std::io::stdin().is_terminal();
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if line.trim().is_empty() {
                continue;
            }
            match parse_command(&line) {
                Ok(command) => {
                    if sender.send(Order::Command(command)).is_err() {
                        return;
                    }
                }
                Err(error) => complain(&format!("{error}")),
            }
        }
        if terminal {
            // Nobody listens any more only when the program has ended.
            let _ = sender.send(Order::Leave("the terminal has ended"));
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
    let state = describe_state(situation.state);
    let place = describe_place(&situation.position);
    format!("{state}, line {}, {:.1} mm/s, {place}", situation.tag, situation.speed)
}

fn print(summary: &Summary) {
    say(&format!("{} blocks taken, {} items sent", summary.blocks, summary.sent));
    say(&describe(&summary.situation));
    if summary.damaged > 0 {
        say(&format!(
            "{} damaged frames on the line; nothing is lost, but look at the wiring",
            summary.damaged
        ));
    }
    if summary.situation.starved > 0 {
        say(&format!(
            "{} stops because blocks came too late: a higher --baud may help",
            summary.situation.starved
        ));
    }
}
