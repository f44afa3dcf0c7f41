//! How soon the machine reacts to what an operator asks for while no program runs: a jog, the edge of a probe.

use super::built::Image;
use super::emulator::Emulator;
use super::machine::{ACCELERATION, AXES, JERK};
use super::recording::{self, InputEdge};
use super::sender::Sender;
use super::{Options, Session};
use anyhow::{Context, Result, ensure};
use std::time::Duration;

/// Most servo cycles from the end of a jog's line to the first setpoint that moves.
const SOON: u64 = 5;
/// How much longer than the shortest stop one may be, and steps on either end that the pins do not tell.
const LONGER: f64 = 1.02;
const STEPS: f64 = 3.0;
/// Most servo cycles from an edge to steps that brake: what planning the stop takes, twice if it came too late, and two that
/// setpoints are ahead of steps.
const LATE: f64 = 10.0;
/// The input pin of the probe.
const PROBE: u8 = 1 << 3;
/// How far from a step on an axis the place of an edge may be told, mm: three digits, and a tick of the step timer.
const PLACE: f64 = 0.002;
/// Feeds of probes, mm/s.
const FEEDS: [f64; 4] = [5.0, 20.0, 50.0, 90.0];

/// A count of the log.
fn count(board: &Emulator, name: &str) -> Result<u64> {
    board.log()?.get(name).copied().with_context(|| format!("no {name} in the log"))
}

/// The way and the time of the shortest stop from a speed, mm and s.
fn shortest(speed: f64) -> (f64, f64) {
    let (acceleration, jerk) = (f64::from(ACCELERATION), f64::from(JERK));
    let time = if speed * jerk > acceleration * acceleration {
        speed / acceleration + acceleration / jerk
    } else {
        2.0 * (speed / jerk).sqrt()
    };
    (speed * time / 2.0, time)
}

/// Jogs and probes, judged.
///
/// # Errors
/// What comes too late, lasts too long, or is told wrongly.
pub fn check(image: &Image, options: &Options) -> Result<()> {
    let mut session = Session::begin(image, options)?;
    let Session { board, sender, .. } = &mut session;
    jogs(board, sender)?;
    println!(
        "| probe, mm/s | from the edge to rest, ms | the stop over the shortest | brakes after, ms | overshoot, mm | place told off the steps, mm |\n\
         |---|---|---|---|---|---|"
    );
    for feed in FEEDS {
        probe(board, sender, feed)?;
    }
    Ok(())
}

/// Jogs at instants that have nothing to do with servo cycles.
fn jogs(board: &mut Emulator, sender: &mut Sender) -> Result<()> {
    let mut reactions = Vec::new();
    for n in 0..12u64 {
        std::thread::sleep(Duration::from_micros(20_000 + 373 * n));
        let way = if n % 2 == 0 { 5 } else { -5 };
        sender.stream(&[format!("$J=G91 G21 X{way} F3000")], |_, _| Ok(false))?;
        sender.wait_for("Idle")?;
        let (heard, began) = (count(board, "heard")?, count(board, "began")?);
        ensure!(began > heard, "a jog began in servo cycle {began}, its line ended in {heard}");
        reactions.push(began - heard);
    }
    reactions.sort_unstable();
    let (least, most) = (reactions[0], reactions[reactions.len() - 1]);
    println!(
        "| jogs | a setpoint moves after, servo cycles |\n|---|---|\n| {} | {least} to {most} |\n",
        reactions.len()
    );
    ensure!(most <= SOON, "a jog began {most} servo cycles after its line; {SOON} are too many");
    ensure!(sender.errors.is_empty(), "it answers {:?}", sender.errors);
    Ok(())
}

/// A probe that trips on the way.
fn probe(board: &mut Emulator, sender: &mut Sender, feed: f64) -> Result<()> {
    board.look()?;
    let start = recording::mm(&board.recording.place())[0];
    // Far enough that the feed has been reached.
    let (run_up, _) = shortest(feed);
    sender.probed = None;
    let mut tripped = false;
    let line = format!("G38.2 X{:.3} F{:.0}", start + 200.0, feed * 60.0);
    sender.stream(&[line, "G4 P0.01".to_owned()], |sender, _| {
        if !tripped && sender.status.place[0] - start > 2.0 * run_up + 1.0 {
            board.set_inputs(PROBE)?;
            tripped = true;
        }
        Ok(false)
    })?;
    sender.wait_for("Idle")?;
    let rested = count(board, "rested")?;
    board.look()?;
    let recording = &board.recording;
    let InputEdge { time, place } = *recording.edges_of_inputs.last().context("no edge came")?;
    let told = sender.probed.take().context("no place has been told")?;
    let at = recording::mm(&place);
    let off = (0..AXES).map(|axis| (told[axis] - at[axis]).abs()).fold(0.0, f64::max);
    // The setpoint of rest is where the steps of the next cycle lead.
    let whole = rested as f64 + 1.0 - time;
    let way = recording::mm(&recording.place())[0] - at[0];
    let (least, quickest) = shortest(feed);
    // Before it brakes it goes on at the feed: what is missing there is the way of the stop, which on the average is half as fast.
    let cycle = 1.0 / f64::from(super::machine::SERVO_HZ);
    let ratio = (feed * whole * cycle - way) / least;
    let brakes = whole - ratio * quickest / cycle;
    println!("| {feed} | {whole:.1} | {ratio:.3} | {brakes:.1} | {way:.4} | {off:.4} |");
    let step = 1.0 / f64::from(super::machine::steps_per_mm());
    let most = LONGER + STEPS * step / least;
    ensure!(ratio <= most, "a stop from {feed} mm/s took {ratio:.3} of the shortest");
    ensure!(brakes <= LATE, "a probe at {feed} mm/s braked {brakes:.1} ms after the edge");
    ensure!(off <= step + PLACE, "the edge was at {at:?} mm, and {told:?} is told");
    board.set_inputs(0)?;
    sender.stream(&["G0 X0"], |_, _| Ok(false))?;
    sender.wait_for("Idle")?;
    ensure!(
        sender.errors.is_empty() && sender.alarms.is_empty(),
        "{:?} {:?}",
        sender.errors,
        sender.alarms
    );
    Ok(())
}
