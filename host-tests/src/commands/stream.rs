//! `splineway stream`: a program to a controller over a serial line.

use super::files::check_stdin;
use super::numbers::positive;
use super::reading::Reading;
use crate::stream::{
    Controlled, News, Order, Settings, Summary, check, describe_place, describe_state, open_port,
    parse_command, parts, placed, send,
};
use crate::view::bar;
use anyhow::{Context, Result, ensure};
use serde::Serialize;
use splineway::wire::{Item, Situation};
use splineway_simulator::input::{self, is_stdin};
use splineway_simulator::machine::is_rotary;
use splineway_simulator::program::{
    self, AXES, Attended, LETTERS, Point, ReadOptions, Setup, Tape, refuse,
};
use splineway_simulator::run::Homing;
use std::collections::BTreeMap;
use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

const EXAMPLES: &str = "\
While the program runs, lines on standard input are commands to the controller:
  hold | resume | stop | abort | feed 0..200 | rapid 0..100 | single on | single off
  jog X20 Y-5 for SECONDS (mm/s) | jog-step X0.1 at FEED | jog-to X0 Y0 at FEED | jog-back at FEED | jog-cancel
If the program itself comes from there (-), there are none: Ctrl-C aborts.

The machine is aborted - it brakes on the path and drops the rest - and this program waits until it stands:
  on Ctrl-C, SIGTERM and SIGHUP (a second one does not wait), on every error, and when standard input ends if
  that is a terminal. The end of a pipe or a file is only the end of its commands: a machine that is held then
  waits for a resume of its own, or for Ctrl-C.
If this program dies otherwise, or the cable comes off, the controller holds the machine after --watchdog
seconds. Where something of the program is left there, the next `stream` is refused, unless --abort drops it.

A G-code program begins where the machine stands. Poly-lines, splines and curves begin at their own first
point: if the machine stands elsewhere, they are refused unless --approach says to move there first.
The whole program is read and checked before the first block is sent.

Example, without hardware:
  splineway controller            (prints the name of its port)
  splineway stream host-tests/data/butterfly.json --port /dev/pts/3 --approach

Exit codes: 0 run to its end, 1 error or aborted, 2 wrong usage.";

/// Sends a program to a controller and waits until it has been run
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Stream {
    /// G-code (.ngc .nc .gcode .tap ...), poly-line (.txt), spline (.toml) or curve (.json); "-" is standard input: see `splineway formats`
    pub file: PathBuf,
    /// The serial port. It is locked: one sender at a time
    #[arg(long)]
    pub port: PathBuf,
    /// Bits per second
    #[arg(long, value_name = "BITS_PER_S", default_value_t = 921_600)]
    pub baud: u32,
    /// Silence of this program after which the controller stops the machine, s, 0.1 to 60; 0: never
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = silence)]
    pub watchdog: f64,
    /// Move straight to the first point of a path that does not begin where the machine stands
    #[arg(long)]
    pub approach: bool,
    /// Abort what a program before has left whose sender is gone
    #[arg(long)]
    pub abort: bool,
    /// How axes are homed at a line `$H` of the program, mm and mm/s: "X-40 Y-20 slow 4 reach 300 back 2 at 0 park 5"
    /// [default: none]
    #[arg(long, value_name = "HOW")]
    pub home: Option<String>,
    /// Switch outputs in time with the path by M62 to M68; without it M62 to M65 are events
    #[arg(long)]
    pub outputs: bool,
    /// S and M3 to M5 are those of a laser with this greatest power [default: none]
    #[arg(long, value_name = "POWER", value_parser = positive())]
    pub laser: Option<f64>,
    /// Print what came of it as JSON
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// How the program is read. Of the machine, its work offsets, tools and reference points count; its limits are the controller's.
    #[command(flatten)]
    pub reading: Reading,
}

impl Stream {
    /// Runs the command.
    ///
    /// # Errors
    /// What the file, the port or the controller has against it.
    pub fn execute(&self) -> Result<()> {
        check_stdin(&[Some(("the program", &self.file)), self.reading.file()])?;
        let homing = self.home.as_deref().map(Homing::parse).transpose().context("--home")?;
        let setup = self.reading.machine()?.setup();
        // All of it, before the port is anybody's: standard input may be slow.
        let program = input::bytes(&self.file)?;
        let settings =
            Settings { silence: (self.watchdog * 1000.0).round() as u16, abort: self.abort };
        let mut port = open_port(&self.port, self.baud)?;
        let (sender, orders) = channel();
        obey_signals(sender.clone())?;
        if is_stdin(&self.file) {
            sender.send(Order::NoMore)?;
        } else {
            listen(sender);
        }
        let bar = bar(0, self.quiet, "{bar:30} {pos}/{len}  {msg}");
        let outcome = send(
            &mut port,
            settings,
            |controlled| self.prepare(&program, (&setup, homing.as_ref()), controlled),
            &orders,
            &mut |news| match news {
                News::Status { taken, items, situation } => {
                    bar.set_length(u64::from(items));
                    bar.set_position(u64::from(taken));
                    bar.set_message(describe(situation));
                }
                News::Event { line, event } if !(self.quiet || self.json) => {
                    bar.suspend(|| say(&format!("line {line}: {event}")));
                }
                News::Event { .. } => {}
                News::Notice(notice) => bar.suspend(|| complain(notice)),
            },
        );
        bar.finish_and_clear();
        let summary = outcome.with_context(|| self.port.display().to_string())?;
        let position = &summary.situation.position;
        if self.json {
            say(&serde_json::to_string_pretty(&Report::new(&summary))?);
        } else if !self.quiet && !position.is_empty() {
            print(&summary);
        }
        match summary.aborted {
            Some(reason) if position.is_empty() => {
                Err(anyhow::anyhow!("aborted: {reason}, before anything was sent"))
            }
            Some(reason) => Err(anyhow::anyhow!(
                "aborted: {reason}; the machine stands at {}",
                describe_place(position)
            )),
            None => Ok(()),
        }
    }

    /// The program for the machine where it stands, read and checked as a whole, up to the next probe or homing: as if each of those
    /// that are to come ended where it is bound for.
    fn prepare(
        &self,
        bytes: &[u8],
        (setup, homing): (&Setup, Option<&Homing>),
        controlled: &Controlled,
    ) -> Result<Vec<Item>> {
        let point = |place: &[i64]| {
            let mut point: Point = [0.0; AXES];
            for (mm, &nm) in point.iter_mut().zip(place) {
                *mm = nm as f64 * 1.0e-6;
            }
            point
        };
        let start = point(&controlled.start);
        let stops: Vec<Point> = controlled.stops.iter().map(|place| point(place)).collect();
        let attended = Attended {
            stops: &stops,
            home: homing.map(Homing::ends),
            outputs: self.outputs,
            laser: self.laser,
        };
        let attended = Some(&attended);
        let options = ReadOptions { start, attended, ..self.reading.options(setup) };
        let name = self.file.display();
        let (program, found) = program::inspect_bytes(&self.file, bytes, options)?;
        refuse(&found).with_context(|| name.to_string())?;
        let is_first = stops.is_empty();
        for warning in program.warnings.iter().filter(|_| is_first) {
            complain(&format!("warning: {warning}"));
        }
        let program = self.reading.overriding(&program, None).to_program();
        let (program, approach) = placed(&program, &start, self.approach)?;
        if let (Some(to), true) = (approach, is_first) {
            let words = |point: &Point| -> String {
                let nm: Vec<i64> = point[..controlled.axes.min(AXES)]
                    .iter()
                    .map(|mm| (mm * 1.0e6).round() as i64)
                    .collect();
                describe_place(&nm)
            };
            complain(&format!("--approach: first from {} to {}", words(&start), words(&to)));
        }
        let home = homing.map(|homing| homing.as_sent(0)).transpose()?;
        let mut parts =
            parts(&program, controlled.axes, home.as_ref()).with_context(|| name.to_string())?;
        for part in parts.iter().skip(stops.len()) {
            refuse(&check(&part.items, &part.start)?).with_context(|| name.to_string())?;
        }
        ensure!(stops.len() < parts.len(), "the program has changed while it was run");
        Ok(parts.swap_remove(stops.len()).items)
    }
}

/// Reads a time without a word from here.
fn silence(text: &str) -> Result<f64, String> {
    let time = text.parse().ok().filter(|&time| time == 0.0 || (0.1..=60.0).contains(&time));
    time.ok_or_else(|| "it must be 0.1 to 60 s, or 0 for never".to_owned())
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

/// Between two commands from standard input.
const PACE: Duration = Duration::from_millis(5);

/// Commands from standard input. Its end is the operator's only if it is a terminal.
fn listen(sender: Sender<Order>) {
    std::thread::spawn(move || {
        let terminal = std::io::stdin().is_terminal();
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            // A program that writes without end must not keep the line, or an interrupt, from being served.
            std::thread::sleep(PACE);
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
        let end = if terminal { Order::Leave("the terminal has ended") } else { Order::NoMore };
        // Nobody listens any more only when the program has ended.
        let _ = sender.send(end);
    });
}

fn describe(situation: &Situation) -> String {
    let state = describe_state(situation.state);
    let place = describe_place(&situation.position);
    format!("{state}, line {}, {:.1} mm/s, {place}", situation.tag, situation.speed)
}

/// What came of it, as JSON.
#[derive(Serialize)]
struct Report {
    blocks: u32,
    items_sent: u32,
    damaged_frames: u32,
    starved: u32,
    state: String,
    line: u32,
    speed_mm_s: f64,
    /// `X_mm`, `A_deg`.
    position: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    aborted: Option<&'static str>,
}

impl Report {
    fn new(summary: &Summary) -> Self {
        let situation = &summary.situation;
        let place = situation.position.iter().enumerate().map(|(axis, &nm)| {
            let unit = if is_rotary(axis) { "deg" } else { "mm" };
            (format!("{}_{unit}", LETTERS[axis]), nm as f64 * 1.0e-6)
        });
        Self {
            blocks: summary.blocks,
            items_sent: summary.sent,
            damaged_frames: summary.damaged,
            starved: situation.starved,
            state: describe_state(situation.state).to_owned(),
            line: situation.tag,
            speed_mm_s: f64::from(situation.speed),
            position: place.collect(),
            aborted: summary.aborted,
        }
    }
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
