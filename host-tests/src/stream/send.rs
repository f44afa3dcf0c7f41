//! Sending a program to a controller.

use crate::program::{self, Course, LETTERS, Point, Program};
use anyhow::{Context, Result, anyhow, bail, ensure};
use serial2::SerialPort;
use splineway::Coord;
pub use splineway::wire::Command;
use splineway::wire::{
    Axes, FRAME, Inlet, Item, Move, Path, Refusal, Reply, Request, Sender, Situation, Speed, State,
    Step, VERSION, encode,
};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// Silence after which a controller counts as gone.
const GONE: Duration = Duration::from_secs(5);
/// How long the machine must have been idle before the program counts as run.
const SETTLED: Duration = Duration::from_millis(200);

/// What came of it.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Blocks the controller has taken.
    pub blocks: u32,
    /// Frames that arrived damaged at either end.
    pub damaged: u32,
    /// Items sent, those sent again included.
    pub sent: u32,
    /// What the machine did at the end.
    pub situation: Situation,
    /// Whether an operator has aborted the program.
    pub aborted: bool,
}

/// A command as a word: hold, resume, stop, abort, "feed 50", "rapid 25", "single on".
///
/// # Errors
/// Names what is not understood.
pub fn parse_command(text: &str) -> Result<Command> {
    let mut words = text.split_whitespace();
    let (word, value) = (words.next().unwrap_or(""), words.next());
    let percent = || -> Result<u16> {
        let text = value.with_context(|| format!("\"{word}\" needs a number, per cent"))?;
        text.trim_end_matches('%').parse().map_err(|_| anyhow!("{text} is no number of per cent"))
    };
    Ok(match word {
        "hold" | "!" => Command::Hold,
        "resume" | "~" => Command::Resume,
        "stop" => Command::Stop,
        "abort" => Command::Abort,
        "feed" => Command::FeedOverride(percent()?),
        "rapid" => Command::RapidOverride(percent()?),
        "single" => Command::SingleBlock(value != Some("off")),
        _ => bail!(
            "\"{text}\" is no command; known are hold, resume, stop, abort, feed, rapid, single"
        ),
    })
}

/// The program as a controller with a number of axes takes it.
///
/// # Errors
/// It moves an axis that the controller lacks; a coordinate is out of range.
pub fn items(program: &Program, axes: usize) -> Result<Vec<Item>> {
    for axis in program.axes() {
        ensure!(
            axis < axes || !program.uses[axis],
            "the program moves {}; the controller has only {}",
            LETTERS[axis],
            LETTERS[..axes].iter().collect::<String>()
        );
    }
    let mut items = Vec::with_capacity(program.moves.len() + 1);
    for step in &program.moves {
        let step = wire_move(step, axes).with_context(|| format!("line {}", step.line))?;
        items.push(Item::Move(step));
    }
    items.push(Item::End);
    Ok(items)
}

fn nm(mm: f64) -> Result<i64> {
    ensure!(mm.abs() <= Coord::LIMIT_MM, "coordinate {mm} mm is out of range (+-1e6)");
    Ok((mm * 1.0e6).round() as i64)
}

/// A move as it is sent.
fn wire_move(step: &program::Move, axes: usize) -> Result<Move> {
    let point =
        |point: &Point| -> Result<Axes> { point[..axes].iter().map(|&mm| nm(mm)).collect() };
    let path = match &step.path {
        Course::Line { to } => Path::Line { to: point(to)? },
        Course::Arc { to, plane, centre, clockwise, extra_turns } => Path::Arc {
            to: point(to)?,
            plane: (plane.0 as u8, plane.1 as u8),
            centre: (nm(centre.0)?, nm(centre.1)?),
            clockwise: *clockwise,
            extra_turns: *extra_turns,
        },
        Course::Cubic { controls: [first, second], to } => {
            Path::Cubic { controls: [point(first)?, point(second)?], to: point(to)? }
        }
        Course::Dwell { seconds } => Path::Dwell { seconds: *seconds as f32 },
        Course::Event { pause, .. } => Path::Event { pause: *pause },
    };
    let speed = match step.speed {
        program::Speed::PerSecond(feed) => Speed::PerSecond(feed as f32),
        program::Speed::Duration(seconds) => Speed::Duration(seconds as f32),
        program::Speed::Rapid => Speed::Rapid,
    };
    let tolerance = step.tolerance.map(|mm| mm as f32);
    Ok(Move { path, speed, tolerance, exact_stop: step.exact_stop, tag: step.line })
}

struct Line<'a> {
    port: &'a SerialPort,
    inlet: Inlet,
    frame: [u8; FRAME],
}

impl Line<'_> {
    fn write(&mut self, request: &Request) -> Result<()> {
        let length = encode(request, &mut self.frame).context("a block is too long for a frame")?;
        self.port.write_all(&self.frame[..length]).context("the port does not take what is sent")
    }

    /// Replies that have come, after waiting a little for the first.
    fn read(&mut self) -> Result<Vec<Reply>> {
        let mut bytes = [0; 1024];
        let count = match self.port.read(&mut bytes) {
            Ok(count) => count,
            Err(error) if error.kind() == std::io::ErrorKind::TimedOut => 0,
            Err(error) => return Err(error).context("the port cannot be read"),
        };
        Ok(bytes[..count].iter().filter_map(|&byte| self.inlet.push(byte)).collect())
    }
}

/// Sends a program and waits until it has been run. Commands come from `commands`; `watch` is told how
/// many of how many items have been taken, and what the machine does.
///
/// # Errors
/// No controller answers; it speaks another protocol or lacks an axis; it refuses a block, or stops for
/// an alarm; the port fails.
pub fn send(
    port: &mut SerialPort,
    program: &Program,
    commands: &Receiver<Command>,
    mut watch: impl FnMut(u32, u32, &Situation),
) -> Result<Summary> {
    port.set_read_timeout(Duration::from_millis(2))?;
    let mut line = Line { port, inlet: Inlet::new(), frame: [0; FRAME] };
    // Ends whatever half of a frame stood on the line before.
    line.port.write_all(&[0])?;
    let began = Instant::now();
    let clock = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH)?;
    let session = clock.as_millis() as u32;
    // The number of items is known as soon as the number of axes is.
    let mut sender = Sender::new(session, 0);
    let mut items = Vec::new();
    let mut summary = Summary::default();
    let mut heard = began;
    let mut idle: Option<Instant> = None;
    loop {
        let now = began.elapsed().as_millis() as u64;
        for reply in line.read()? {
            heard = Instant::now();
            sender.hear(&reply, now);
            if let Reply::Status { situation, damaged, .. } = reply {
                summary.damaged = damaged + line.inlet.damaged();
                summary.situation = situation;
                watch(sender.taken(), items.len() as u32, &summary.situation);
                let rests = matches!(summary.situation.state, State::Idle | State::Alarm);
                idle = if rests { idle.or(Some(Instant::now())) } else { None };
            }
        }
        if let Some((axes, version)) = sender.controller()
            && items.is_empty()
        {
            ensure!(
                version == VERSION,
                "the controller speaks version {version}, this is {VERSION}"
            );
            items = self::items(program, usize::from(axes))?;
            sender.set_items(items.len() as u32);
        }
        summary.blocks = sender.taken().min(items.len().saturating_sub(1) as u32);
        let rests = idle.is_some_and(|since| since.elapsed() >= SETTLED);
        match sender.refused() {
            Some(Refusal::Aborted) if rests => {
                summary.aborted = true;
                return Ok(summary);
            }
            Some(Refusal::Block { tag }) => bail!("the controller refuses the block of line {tag}"),
            Some(Refusal::Alarm) => {
                bail!("the controller has stopped: emergency stop or limit switch")
            }
            _ => {}
        }
        if !items.is_empty() && sender.is_done() && rests {
            return Ok(summary);
        }
        ensure!(heard.elapsed() < GONE, "the controller does not answer");
        for command in commands.try_iter() {
            ensure!(sender.command(command), "too many commands wait for the controller");
        }
        // As much as a window holds; what the controller says is looked at in between.
        for _ in 0..32 {
            match sender.step(now) {
                Step::Wait => break,
                Step::Send(request) => line.write(&request)?,
                Step::Item(number) => {
                    // Numbers are asked for below the count that was set.
                    if let Some(item) = items.get(number as usize) {
                        summary.sent += 1;
                        line.write(&sender.item(number, item.clone()))?;
                        idle = None;
                    }
                }
            }
        }
    }
}
