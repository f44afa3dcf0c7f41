//! Sending a program to a controller.

use super::order::Order;
use super::place::describe_place;
use super::talk::{Controlled, News, Talk};
use anyhow::{Context, Result, anyhow, bail, ensure};
use serial2::SerialPort;
use splineway::wire::{Command, HomeFault, Item, Refusal, SILENCE, Sender, Situation, State};
use splineway_simulator::letters::{ALL, lettered};
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::{Duration, Instant};

/// Time in which an aborted machine must have come to rest. Nothing that is driven by it needs so long.
const STOPS: Duration = Duration::from_secs(10);
/// Time for the abort to get through when nobody waits for the machine.
const HASTE: Duration = Duration::from_millis(200);
/// And until one that answers begins a program.
const OPENS: Duration = Duration::from_secs(10);

/// How it is sent.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Silence after which the controller stops the machine, ms; 0: never.
    pub silence: u16,
    /// Whether to abort what a lost sender has left.
    pub abort: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { silence: SILENCE, abort: false }
    }
}

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
    /// Whether the program has been aborted, and by whom.
    pub aborted: Option<&'static str>,
}

/// How the run ended, if not by an error.
enum End {
    Run,
    /// By an abort, which the controller has taken.
    Aborted,
    /// The operator leaves: the abort is still to be sent.
    Leaves(&'static str),
}

/// Sends a program and waits until it has been run. `make` gives its items when the session is open and it
/// is known where the machine stands; those up to a probe or homing, if there is one, and the following when it is over. Orders come from `orders`; `watch` hears what happens.
///
/// Whatever goes wrong once a block has been sent, and if an order says so, the machine is aborted before
/// this returns, and it waits until it stands: at most ten seconds.
///
/// # Errors
/// No controller answers; it speaks another protocol or has another sender; `make` fails; it refuses a block,
/// or stops for an alarm; the port fails. The message says where the machine stands.
pub fn send<F>(
    port: &mut SerialPort,
    settings: Settings,
    mut make: F,
    orders: &Receiver<Order>,
    watch: &mut dyn FnMut(News<'_>),
) -> Result<Summary>
where
    F: FnMut(&Controlled) -> Result<Vec<Item>> + Send,
{
    let clock = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH)?;
    let sender = Sender::new(clock.as_millis() as u32, 0, settings.silence);
    let sender = if settings.abort { sender.aborting() } else { sender };
    let mut talk = Talk::new(port, sender)?;
    let mut controlled = Controlled::default();
    let mut operator = Operator { orders, alone: false };
    let begun = begin(&mut talk, &mut controlled, &mut make, &mut operator, watch);
    let end = begun.and_then(|early| match early {
        Some(reason) => Ok(End::Leaves(reason)),
        None => run(&mut talk, &mut controlled, &mut make, &mut operator, watch),
    });
    let aborted = match end {
        Ok(End::Run) => None,
        Ok(End::Aborted) => Some("an abort"),
        Ok(End::Leaves(reason)) => {
            if talk.sent > 0 {
                watch(News::Notice(&format!("{reason}: the machine is being stopped")));
                stop(&mut talk, orders)?;
            }
            Some(reason)
        }
        Err(error) if talk.sent > 0 => {
            let after = match stop(&mut talk, orders) {
                Ok(()) => format!("the machine stands at {}", talk.place()),
                Err(worse) => format!("{worse:#}"),
            };
            talk.leave();
            return Err(anyhow!("{error:#}; {after}"));
        }
        Err(error) => {
            talk.leave();
            return Err(error);
        }
    };
    talk.leave();
    Ok(Summary {
        blocks: talk.sender.taken().min(talk.items.len().saturating_sub(1) as u32),
        damaged: talk.damaged,
        sent: talk.sent,
        situation: talk.situation().cloned().unwrap_or_default(),
        aborted,
    })
}

/// Why the machine is not jogged before the program runs, and where it waits for more of it.
const NO_JOG: &str = "no jog: the program is about to run; \"hold\" it first";

/// Whether the machine has nothing to run, as far as is known, of a program that is under way.
fn is_between(talk: &Talk<'_>) -> bool {
    talk.situation().is_none_or(|situation| situation.state == State::Idle)
}

/// Who gives orders.
struct Operator<'a> {
    orders: &'a Receiver<Order>,
    /// No command comes from there any more.
    alone: bool,
}

impl Operator<'_> {
    /// Orders before the program runs: the reason of the first to leave. Commands wait for the machine; it is not jogged any more.
    fn leaves(
        &mut self,
        talk: &mut Talk<'_>,
        watch: &mut dyn FnMut(News<'_>),
    ) -> Option<&'static str> {
        for order in self.orders.try_iter() {
            match order {
                Order::Leave(reason) => return Some(reason),
                Order::Command(Command::Abort) => return Some("an abort"),
                Order::Command(Command::Jog(_)) => {
                    watch(News::Notice(NO_JOG));
                }
                Order::Command(command) => {
                    talk.sender.command(command);
                }
                Order::NoMore => self.alone = true,
            }
        }
        None
    }
}

/// Opens the session, and gets the items. `Some` if the operator leaves before that is done.
fn begin<F>(
    talk: &mut Talk<'_>,
    controlled: &mut Controlled,
    make: &mut F,
    operator: &mut Operator<'_>,
    watch: &mut dyn FnMut(News<'_>),
) -> Result<Option<&'static str>>
where
    F: FnMut(&Controlled) -> Result<Vec<Item>> + Send,
{
    let axes = loop {
        if let Some(axes) = talk.greet()? {
            break axes;
        }
        if let Some(reason) = operator.leaves(talk, watch) {
            return Ok(Some(reason));
        }
    };
    let asked = Instant::now();
    let situation = loop {
        talk.turn()?;
        // One that stops says so.
        let silent = talk.sender.denied().is_none() && !talk.sender.is_open();
        ensure!(
            !silent || asked.elapsed() < OPENS,
            "the controller answers, but does not begin a program within {} s",
            OPENS.as_secs()
        );
        if talk.is_open()?
            && let Some(situation) = talk.situation()
        {
            break situation.clone();
        }
        if let Some(reason) = operator.leaves(talk, watch) {
            return Ok(Some(reason));
        }
    };
    ensure!(
        situation.speed == 0.0 && situation.state != State::Running,
        "the machine moves, though its controller says that nothing is left to run"
    );
    let start = situation.position.to_vec();
    *controlled = Controlled { axes, situation, start, stops: Vec::new() };
    add_items(talk, controlled, make)?;
    Ok(operator.leaves(talk, watch))
}

/// Gets items. The controller hears from here while a long program is read.
fn add_items<F>(talk: &mut Talk<'_>, controlled: &Controlled, make: &mut F) -> Result<()>
where
    F: FnMut(&Controlled) -> Result<Vec<Item>> + Send,
{
    thread::scope(|scope| {
        let making = scope.spawn(|| make(controlled));
        while !making.is_finished() {
            talk.turn()?;
            talk.is_open()?;
        }
        let items = making.join().map_err(|_| anyhow!("the program could not be read"))??;
        talk.add_items(items);
        Ok(())
    })
}

/// Sends the items, and waits until they have been run.
fn run<F>(
    talk: &mut Talk<'_>,
    controlled: &mut Controlled,
    make: &mut F,
    operator: &mut Operator<'_>,
    watch: &mut dyn FnMut(News<'_>),
) -> Result<End>
where
    F: FnMut(&Controlled) -> Result<Vec<Item>> + Send,
{
    let mut before = State::Idle;
    let mut paused = None;
    let (mut jog, mut over) = (None, false);
    // What was said before the first item was sent says nothing of the program.
    talk.forget();
    loop {
        talk.turn()?;
        talk.is_open()?;
        while let Some((line, event)) = talk.news() {
            paused = event.pause.then_some(line);
            watch(News::Event { line, event });
        }
        if let Some(situation) = talk.situation() {
            let (taken, items) = (talk.sender.taken(), talk.items.len() as u32);
            watch(News::Status { taken, items, situation });
            if situation.state != before {
                let held = [before, situation.state].contains(&State::Held);
                before = situation.state;
                if let Some(notice) = notice(before, paused, operator.alone) {
                    watch(News::Notice(&notice));
                }
                // The pause may have been told before the controller shows that it rests there.
                if held {
                    paused = None;
                }
            }
        }
        let refused = talk.situation().and_then(|situation| situation.jog);
        if refused != std::mem::replace(&mut jog, refused)
            && let Some(refusal) = refused
        {
            let words = lettered(&refusal.to_string(), &ALL);
            watch(News::Notice(&format!("no jog: {words}")));
        }
        match talk.sender.refused() {
            Some(Refusal::Aborted) if talk.is_stopped() => return Ok(End::Aborted),
            None | Some(Refusal::Aborted) => {}
            // Where the machine has been jogged nothing is left to run; here nothing is left to send.
            Some(Refusal::Jogged) if talk.is_taken() && !talk.is_at_stop() => {}
            Some(refusal) => refused_by(refusal, talk.situation())?,
        }
        let is_run = talk.is_run();
        over |= is_run && !talk.is_at_stop();
        if is_run && !talk.is_commanding() {
            if over {
                return Ok(End::Run);
            }
            let Some(situation) = talk.situation().cloned() else { continue };
            watch(News::Notice(&found(&situation, talk.last_number())));
            controlled.stops.push(situation.position.to_vec());
            controlled.situation = situation;
            add_items(talk, controlled, make)?;
            talk.forget();
        }
        for order in operator.orders.try_iter() {
            match order {
                Order::Leave(reason) => return Ok(End::Leaves(reason)),
                Order::NoMore => {
                    operator.alone = true;
                    // It may have been said to go on by a command.
                    if let Some(notice) = notice(before, paused, operator.alone) {
                        watch(News::Notice(&notice));
                    }
                }
                Order::Command(Command::Abort) => talk.sender.abort(),
                // Whoever goes on to write commands does not keep a program from its end.
                Order::Command(_) if over => {}
                // From where a jog ends nothing of the program could be run.
                Order::Command(Command::Jog(_)) if is_between(talk) => {
                    watch(News::Notice(NO_JOG));
                }
                Order::Command(command) => {
                    if !talk.sender.command(command) {
                        watch(News::Notice("too many commands wait; the last one is not sent"));
                    }
                }
            }
        }
    }
}

/// What the controller has against the program.
fn refused_by(refusal: Refusal, situation: Option<&Situation>) -> Result<()> {
    let mm = |nm: i64| nm as f64 * 1.0e-6;
    let words = |text: &str| anyhow!(lettered(text, &ALL));
    match refusal {
        Refusal::Block { tag } => bail!("the controller refuses the block of line {tag}"),
        Refusal::Travel { tag, axis, to, limit } => Err(words(&format!(
            "the controller refuses the block of line {tag}: axis {axis} would go to {} mm; its travel ends at {}",
            mm(to),
            mm(limit)
        ))),
        Refusal::Jogged => bail!("the machine has been jogged: send the program anew"),
        Refusal::Alarm => bail!(
            "the controller has stopped: emergency stop, limit switch, or an output that did not follow"
        ),
        Refusal::Output { tag, reason } => bail!("line {tag}: {reason}"),
        Refusal::Seek { tag, reason } => Err(words(&format!("line {tag}: {reason}"))),
        Refusal::Probe { tag, end } => bail!("line {tag}: the probe: {end}"),
        Refusal::Home { tag } => {
            let report = situation.and_then(|situation| situation.homing.as_ref());
            let fault = report.and_then(|report| report.fault);
            // It may be told behind the refusal.
            let Some(HomeFault { axis, trouble, .. }) = fault else { return Ok(()) };
            Err(words(&format!("line {tag}: homing, axis {axis}: {trouble}")))
        }
        Refusal::Aborted => Ok(()),
    }
}

/// What came of the probe or homing that is the item of this number.
fn found(situation: &Situation, number: u32) -> String {
    let stands = describe_place(&situation.position);
    match (&situation.probe, &situation.homing) {
        (Some(probe), _) if probe.number == number => {
            let place = describe_place(&probe.position);
            format!(
                "line {}: the probe: {} at {place}; the machine rests at {stands}",
                probe.tag, probe.end
            )
        }
        (_, Some(homing)) if homing.number == number => {
            format!("line {}: homed; the machine rests at {stands}", homing.tag)
        }
        _ => format!("the machine rests at {stands}"),
    }
}

/// What the operator should know of a state; `alone` if no command comes any more.
fn notice(state: State, paused: Option<u32>, alone: bool) -> Option<String> {
    let (what, commands) = match (state, paused) {
        (State::Held, Some(line)) => {
            (format!("line {line}: the program pauses"), "\"resume\" goes on")
        }
        (State::Held, None) => (
            "the machine is held".to_owned(),
            "\"resume\" goes on, and \"feed 100\" where an override of 0 holds it",
        ),
        (State::SenderLost, _) => (
            "the controller has not heard from here for too long and has stopped the machine"
                .to_owned(),
            "\"resume\" goes on, \"abort\" ends the program",
        ),
        _ => return None,
    };
    let ended = "standard input has ended: it goes on by a resume at the machine; Ctrl-C ends it";
    Some(format!("{what}; {}", if alone { ended } else { commands }))
}

/// What is known where an abort was not answered.
const UNKNOWN: &str = "the abort was not acknowledged; a controller that misses its sender stops the machine by itself, \
                       unless --watchdog is 0";

/// Aborts, and waits until the machine stands.
fn stop(talk: &mut Talk<'_>, orders: &Receiver<Order>) -> Result<()> {
    let began = Instant::now();
    let mut hasty: Option<Instant> = None;
    talk.sender.abort();
    talk.forget();
    talk.hope();
    loop {
        talk.turn().and_then(|()| talk.is_open()).context(UNKNOWN)?;
        if talk.is_stopped() {
            return Ok(());
        }
        if orders.try_iter().any(|order| matches!(order, Order::Leave(_))) {
            hasty = hasty.or(Some(Instant::now()));
        }
        if let Some(since) = hasty
            && (talk.is_told_to_stop() || since.elapsed() >= HASTE)
        {
            ensure!(talk.is_told_to_stop(), UNKNOWN);
            bail!("the machine has been told to stop; nobody waits for it");
        }
        ensure!(
            began.elapsed() < STOPS,
            "the machine has not come to rest within {} s",
            STOPS.as_secs()
        );
    }
}
