//! A whole controller on an emulated board, and a sender that streams to it: what the steps at its pins describe, against the G-code.
//!
//! `cargo bench -p splineway-host --bench board -- FILE [--lines N] [--feed F] [--tolerance T] [--client grbl-streamer]` builds
//! `firmware/mps2`, runs it in QEMU (8 ns an instruction: about 168 MHz), streams the file over its line, and judges every step
//! ([`verdict`]). `--feed` (mm/s) takes the place of every F word, `--tolerance` (mm) is set by `$11`. The sender is this
//! program's own, which counts characters, or grbl-streamer, which others wrote (`host-tests/grbl/run.py`).
//!
//! With `--check`: a file with holds, overrides and a reset on the way, jogs and probes ([`reaction`]), and a file that
//! grbl-streamer sends where it can be installed.
//!
//! Without a toolchain for the target or QEMU it says so and ends; with `SPLINEWAY_REQUIRE_TARGET` set it fails.

// Of both there is more than is needed here.
#[allow(dead_code)]
#[path = "../common/image.rs"]
mod built;
mod emulator;
#[allow(dead_code)]
#[path = "../../../firmware/machine.rs"]
mod machine;
mod reaction;
mod recording;
mod sender;
mod verdict;

use anyhow::{Context, Result, bail, ensure};
use built::{Image, Missing};
use emulator::{Emulator, End};
use sender::Sender;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use verdict::{Leg, Verdict, judge};

/// Counts of the log that must stay 0.
const NONE: [&str; 5] = ["stuck", "lost", "lagged", "missed", "damaged"];

/// What is asked for.
#[derive(Default)]
struct Options {
    file: Option<PathBuf>,
    lines: Option<usize>,
    feed: Option<f64>,
    tolerance: Option<f64>,
    others: bool,
    check: bool,
}

impl Options {
    fn read() -> Result<Self> {
        let mut options = Self::default();
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().with_context(|| format!("{word} needs a value"));
            match word.as_str() {
                "--lines" => options.lines = Some(value()?.parse()?),
                "--feed" => options.feed = Some(value()?.parse()?),
                "--tolerance" => options.tolerance = Some(value()?.parse()?),
                "--client" => match value()?.as_str() {
                    "grbl-streamer" => options.others = true,
                    client => bail!("{client} is no sender that this bench knows: grbl-streamer"),
                },
                "--check" => options.check = true,
                // Cargo's own.
                "--bench" => {}
                file => options.file = Some(file.into()),
            }
        }
        Ok(options)
    }

    /// The lines of the file that are to be run, without comments.
    fn program(&self, file: &Path) -> Result<Vec<String>> {
        let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
        let lines = text.lines().map(|line| line.split(';').next().unwrap_or_default().trim());
        let mut lines: Vec<String> =
            lines.filter(|line| !line.is_empty()).map(str::to_owned).collect();
        lines.truncate(self.lines.unwrap_or(usize::MAX));
        if let Some(feed) = self.feed {
            for line in &mut lines {
                let words = line.split_whitespace();
                let words = words.filter(|word| !word.starts_with(['F', 'f']));
                *line = words.collect::<Vec<_>>().join(" ");
            }
            lines.insert(0, format!("F{}", feed * 60.0));
        }
        Ok(lines)
    }
}

/// A rose of short lines, up and down.
fn rose(lines: u32) -> Vec<String> {
    let mut text = vec!["G21 G90 G17".to_owned(), "M3 S8000".to_owned()];
    text.extend((0..lines).map(|k| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(lines - 1);
        let (sin, cos) = angle.sin_cos();
        let radius = 40.0 * (3.0 * angle).cos();
        format!("G1 X{:.3} Y{:.3} Z{sin:.3} F2400", radius * cos, radius * sin)
    }));
    text.extend(["M5", "G0 X1.5 Y-2.5 Z3"].map(str::to_owned));
    text
}

/// The tolerance of the machine, mm.
fn tolerance(options: &Options) -> Result<f64> {
    let config = machine::config::<f32>().context("the machine cannot be used")?;
    Ok(options.tolerance.unwrap_or(f64::from(config.tolerance)))
}

/// A board at the host's end of a line, and what has been run on it.
struct Session {
    board: Emulator,
    sender: Sender,
    legs: Vec<Leg>,
}

impl Session {
    fn begin(image: &Image, options: &Options) -> Result<Self> {
        let board = Emulator::start(image, End::Socket)?;
        let sender = Sender::open(&board.line)?;
        let mut session = Self { board, sender, legs: Vec::new() };
        session.sender.wait_for("Idle")?;
        if let Some(tolerance) = options.tolerance {
            session.sender.stream(&[&format!("$11={tolerance}")], |_, _| Ok(false))?;
        }
        Ok(session)
    }

    /// Runs lines; `meanwhile` is asked how many have been answered, and may end it by a reset.
    fn run(
        &mut self,
        lines: &[String],
        mut meanwhile: impl FnMut(&mut Emulator, &mut Sender, usize) -> Result<bool>,
    ) -> Result<()> {
        let recording = self.board.look()?;
        let (from, first) = (recording.place(), recording.cycles.len());
        let Self { board, sender, .. } = self;
        let whole = sender.stream(lines, |sender, answered| meanwhile(board, sender, answered))?;
        sender.wait_for("Idle")?;
        ensure!(sender.alarms.is_empty(), "it says {:?}", sender.alarms);
        ensure!(sender.errors.is_empty(), "it answers {:?}", sender.errors);
        // Its report is some cycles younger than the record that has been written by then.
        std::thread::sleep(Duration::from_millis(50));
        let recording = board.look()?;
        ensure!(recording.is_enabled(), "the drives have lost their enable");
        let place = recording::mm(&recording.place());
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        let off = place.iter().zip(&sender.status.place).map(off).fold(0.0, f64::max);
        let most = 0.5 / f64::from(machine::steps_per_mm()) + 0.0005 + 1.0e-6;
        ensure!(off <= most, "the board says {:?}, its steps say {place:?}", sender.status.place);
        self.legs.push(Leg {
            text: lines.join("\n"),
            from,
            cycles: first..recording.cycles.len(),
            whole,
        });
        Ok(())
    }

    /// Judges all that has been run, and tells.
    fn end(&self, name: &str, tolerance: f64, began: Instant) -> Result<()> {
        tell(&self.board, &self.legs, name, tolerance, began)
    }
}

/// Judges what has been run on a board, and tells.
fn tell(board: &Emulator, legs: &[Leg], name: &str, tolerance: f64, began: Instant) -> Result<()> {
    let wall = began.elapsed();
    let log = board.log()?;
    let mut verdict = Verdict::default();
    for leg in legs {
        verdict = verdict.and(&judge(leg, &board.recording.cycles, tolerance)?);
    }
    let lines = legs.iter().map(|leg| leg.text.lines().count()).sum();
    row(name, lines, wall, board.recording.steps, &verdict, &log);
    // Whether a sender is quick enough depends on what else this computer does.
    for cycles in board.starved()? {
        println!(
            "It stopped for want of blocks; the last byte of a line had come {cycles} ms before."
        );
    }
    for name in NONE {
        let count = log.get(name).with_context(|| format!("no {name} in the log"))?;
        ensure!(*count == 0, "{name}: {count}");
    }
    Ok(())
}

/// Holds the machine, looks whether it stands, and lets it go on.
fn hold(board: &mut Emulator, sender: &mut Sender) -> Result<()> {
    sender.command(b'!')?;
    sender.wait_for("Hold:0")?;
    let before = board.look()?.place();
    std::thread::sleep(Duration::from_millis(300));
    ensure!(board.look()?.place() == before, "it moves though it is held");
    sender.command(b'~')
}

/// The input pin of the emergency stop.
const STOP: u8 = 1 << 5;

/// The emergency stop in full motion: the drives lose their enable, the machine brakes, and moves no more.
fn emergency(image: &Image, options: &Options) -> Result<()> {
    let mut session = Session::begin(image, options)?;
    let Session { board, sender, .. } = &mut session;
    let lines = ["G1 X100 F6000", "X0", "X100", "X0", "X100", "X0"];
    sender.stream(&lines, |_, _| Ok(false))?;
    sender.wait_until(1, "motion", |status| status.state == "Run" && status.place[0] > 20.0)?;
    board.set_inputs(STOP)?;
    sender.wait_for("Alarm")?;
    let recording = board.look()?;
    ensure!(!recording.is_enabled(), "the drives are enabled after an emergency stop");
    // It brakes within its limits.
    let mut place = recording.place();
    for _ in 0..50 {
        std::thread::sleep(Duration::from_millis(300));
        let now = board.look()?.place();
        if std::mem::replace(&mut place, now) == now {
            break;
        }
    }
    // It is let go; the position is lost all the same.
    board.set_inputs(0)?;
    sender.errors.clear();
    sender.stream(&["$X", "G0 X0"], |_, _| Ok(false))?;
    sender.wait_for("Alarm")?;
    ensure!(!sender.errors.is_empty(), "a move is taken after an emergency stop");
    std::thread::sleep(Duration::from_millis(300));
    let recording = board.look()?;
    ensure!(recording.place() == place, "it moves after an emergency stop");
    ensure!(!recording.is_enabled(), "the drives are enabled again");
    let peaks = verdict::peaks(&recording.cycles);
    ensure!(peaks.iter().all(|&peak| peak <= 1.0 + verdict::ROUNDING), "{peaks:?} of the limits");
    Ok(())
}

/// A file with holds and overrides on the way, a reset, and the file once more, undisturbed.
fn disturbed(image: &Image, options: &Options) -> Result<()> {
    let lines = rose(1200);
    let began = Instant::now();
    let mut session = Session::begin(image, options)?;
    let mut due = vec![
        (900, b"!".as_slice()),
        (750, b"\x90\x95"),
        (600, b"!"),
        (450, b"\x92\x92\x92\x96"),
        (300, b"\x91\x91"),
        (150, b"!"),
    ];
    let mut holds = 0;
    session.run(&lines, |board, sender, answered| {
        if due.last().is_some_and(|(number, _)| *number <= answered)
            && let Some((_, commands)) = due.pop()
        {
            if commands == b"!" {
                hold(board, sender)?;
                holds += 1;
            }
            for command in commands.iter().filter(|&&command| command != b'!') {
                sender.command(*command)?;
            }
        }
        Ok(false)
    })?;
    ensure!(holds == 3 && due.is_empty(), "{holds} holds, {} not given", due.len());
    session.run(&lines, |_, sender, answered| {
        if answered < 500 {
            return Ok(false);
        }
        ensure!(sender.status.state == "Run", "it does not run but is in {}", sender.status.state);
        sender.reset()?;
        Ok(true)
    })?;
    session.run(&lines, |_, _, _| Ok(false))?;
    session.end("rose, disturbed", tolerance(options)?, began)
}

/// A file from its first line to its last, by this program's sender.
fn whole(image: &Image, options: &Options, name: &str, lines: &[String]) -> Result<()> {
    let began = Instant::now();
    let mut session = Session::begin(image, options)?;
    session.run(lines, |_, _, _| Ok(false))?;
    session.end(name, tolerance(options)?, began)
}

/// The code with which `run.py` says that its sender cannot be installed.
const SKIPPED: i32 = 77;

/// A file from its first line to its last, by a sender that others wrote. `false`: it cannot be installed.
fn others(image: &Image, options: &Options, name: &str, lines: &[String]) -> Result<bool> {
    let began = Instant::now();
    let mut board = Emulator::start(image, End::Terminal)?;
    let mut text = lines.join("\n");
    if let Some(tolerance) = options.tolerance {
        text = format!("$11={tolerance}\n{text}");
    }
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("program");
    std::fs::write(&file, &text)?;
    let mut sender = Command::new(built::root().join("host-tests/grbl/run.py"));
    let mut sender = sender.arg("--port").arg(&board.line).arg(&file).spawn()?;
    // The record is followed on the way: whatever is wrong at the pins ends the run at once.
    let status = loop {
        if let Some(status) = sender.try_wait()? {
            break status;
        }
        let looked = board.look();
        if let Err(error) = looked {
            sender.kill()?;
            sender.wait()?;
            return Err(error);
        }
        std::thread::sleep(Duration::from_millis(200));
    };
    if status.code() == Some(SKIPPED) {
        return Ok(false);
    }
    ensure!(status.success(), "the sender ends with {status}");
    let cycles = 0..board.look()?.cycles.len();
    let leg = Leg { text: lines.join("\n"), from: [0; machine::AXES], cycles, whole: true };
    tell(&board, &[leg], name, tolerance(options)?, began)?;
    Ok(true)
}

fn head() {
    println!(
        "| file | lines | machining time, s | virtual over real time | steps | farthest from the path, mm | velocity / acceleration / jerk \
         over limits | plans | late | starved | longest round, ms | longest servo task, us | longest step interrupt, us |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|"
    );
}

fn row(
    name: &str,
    lines: usize,
    wall: Duration,
    steps: u64,
    verdict: &Verdict,
    log: &HashMap<String, u64>,
) {
    let value = |name: &str| log.get(name).copied().unwrap_or(0);
    let time = verdict.cycles as f64 / f64::from(machine::SERVO_HZ);
    let [velocity, acceleration, jerk] = verdict.peaks;
    println!(
        "| {name} | {lines} | {time:.1} | {:.2} | {steps} | {:.4} | {velocity:.3} / {acceleration:.3} / {jerk:.3} | {} | {} | {} | \
         {:.1} | {:.1} | {:.1} |",
        value("cycles") as f64 / f64::from(machine::SERVO_HZ) / wall.as_secs_f64(),
        verdict.deviation,
        value("plans"),
        value("late"),
        value("starved"),
        value("round") as f64 * 1.0e-6,
        value("servo") as f64 * 1.0e-3,
        value("steps") as f64 * 1.0e-3,
    );
}

fn main() -> Result<()> {
    let options = Options::read()?;
    let image = match Image::build("mps2") {
        Err(error)
            if error.is::<Missing>() && std::env::var_os("SPLINEWAY_REQUIRE_TARGET").is_none() =>
        {
            println!("skipped: {error}");
            return Ok(());
        }
        image => image?,
    };
    if options.check {
        emergency(&image, &options)?;
        reaction::check(&image, &options)?;
        head();
        disturbed(&image, &options)?;
        others(&image, &options, "rose, by grbl-streamer", &rose(2000))?;
        return Ok(());
    }
    head();
    let file = options.file.as_deref().context("which file? See the beginning of the bench")?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let program = options.program(file)?;
    if !options.others {
        return whole(&image, &options, &name, &program);
    }
    let done = others(&image, &options, &format!("{name}, by grbl-streamer"), &program)?;
    ensure!(done, "grbl-streamer cannot be installed");
    Ok(())
}
