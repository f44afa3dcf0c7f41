//! The line to a controller: requests and replies in their time.

use super::place::describe_place;
use anyhow::{Context, Result, bail, ensure};
use serial2::SerialPort;
use splineway::gcode::{Code, Event};
use splineway::wire::{
    Denial, FRAME, Inlet, Item, Move, Path, PowerMove, Refusal, Reply, Request, Sender, Situation,
    State, Step, SwitchTrigger, VERSION, encode,
};
use std::io::ErrorKind;
use std::time::{Duration, Instant};

/// Silence after which a controller counts as gone.
pub const GONE: Duration = Duration::from_secs(5);
/// Time it gets for an abort.
const HOPE: Duration = Duration::from_secs(2);
/// Silence after which a question without a session is asked again.
const AGAIN: Duration = Duration::from_millis(100);

/// Who is at the other end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Controlled {
    /// Its number of axes.
    pub axes: usize,
    /// How it stands, when the session has been opened, and behind every probe and homing: at rest.
    pub situation: Situation,
    /// Where it stood when the session was opened, nm.
    pub start: Vec<i64>,
    /// Where it stood behind each probe and homing of the program, nm.
    pub stops: Vec<Vec<i64>>,
}

/// What happens on the way.
#[derive(Clone, Copy, Debug)]
pub enum News<'a> {
    /// The controller has said how things are.
    Status {
        /// Items taken.
        taken: u32,
        /// Items in all.
        items: u32,
        /// What the machine does.
        situation: &'a Situation,
    },
    /// The machine has come to an event of the program.
    Event {
        /// Line of the program.
        line: u32,
        /// What it is.
        event: Event,
    },
    /// Something the operator should know.
    Notice(&'a str),
}

/// The host's end of a session, on a port.
pub struct Talk<'a> {
    port: &'a SerialPort,
    inlet: Inlet,
    frame: [u8; FRAME],
    began: Instant,
    heard: Instant,
    patience: Duration,
    asked: Option<Instant>,
    hello: Option<(u8, u8)>,
    pub sender: Sender,
    pub items: Vec<Item>,
    /// Where in the items the events are.
    events: Vec<usize>,
    /// Events that have been told of.
    told: usize,
    /// The last status of this session, and the items that had been taken then.
    status: Option<(Situation, u32)>,
    pub sent: u32,
    pub damaged: u32,
}

impl<'a> Talk<'a> {
    /// Clears the line.
    pub fn new(port: &'a mut SerialPort, sender: Sender) -> Result<Self> {
        port.set_read_timeout(Duration::from_millis(2))?;
        let port: &SerialPort = port;
        // Ends whatever half of a frame stood on the line before.
        port.write_all(&[0]).context("the port does not take what is sent")?;
        let now = Instant::now();
        Ok(Self {
            port,
            inlet: Inlet::new(),
            frame: [0; FRAME],
            began: now,
            heard: now,
            patience: GONE,
            asked: None,
            hello: None,
            sender,
            items: Vec::new(),
            events: Vec::new(),
            told: 0,
            status: None,
            sent: 0,
            damaged: 0,
        })
    }

    fn write(&mut self, request: &Request) -> Result<()> {
        let length = encode(request, &mut self.frame).context("a block is too long for a frame")?;
        self.port.write_all(&self.frame[..length]).context("the port does not take what is sent")
    }

    /// Replies that have come, after waiting a little for the first.
    fn read(&mut self) -> Result<Vec<Reply>> {
        let mut bytes = [0; 1024];
        let count = match self.port.read(&mut bytes) {
            Ok(0) => bail!("the port is gone"),
            Ok(count) => count,
            // A signal has its own way to say what is to be done; bytes may have gone to someone else who
            // has the port.
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
                ) =>
            {
                0
            }
            Err(error) => return Err(error).context("the port cannot be read"),
        };
        Ok(bytes[..count].iter().filter_map(|&byte| self.inlet.push(byte)).collect())
    }

    fn hear(&mut self) -> Result<()> {
        let now = self.began.elapsed().as_millis() as u64;
        for reply in self.read()? {
            self.heard = Instant::now();
            self.sender.hear(&reply, now);
            match reply {
                Reply::Hello { version, axes, .. } => self.hello = Some((version, axes)),
                Reply::Status { taken, situation, damaged } => {
                    self.damaged = damaged + self.inlet.damaged();
                    if self.sender.is_open() {
                        self.status = Some((situation, taken.map_or(0, |taken| taken.next)));
                    }
                }
                _ => {}
            }
        }
        if self.heard.elapsed() >= self.patience {
            let other = "; what comes from there is no frame of this protocol";
            bail!(
                "the controller does not answer{}",
                if self.inlet.damaged() > 0 && self.hello.is_none() { other } else { "" }
            );
        }
        Ok(())
    }

    /// Asks which protocol is spoken. `Some` when that is known: number of axes.
    pub fn greet(&mut self) -> Result<Option<usize>> {
        if self.asked.is_none_or(|asked| asked.elapsed() >= AGAIN) {
            self.asked = Some(Instant::now());
            self.write(&Request::Hello { session: 0 })?;
        }
        self.hear()?;
        let Some((version, axes)) = self.hello else { return Ok(None) };
        ensure!(
            version == VERSION,
            "the controller speaks version {version} of the protocol, this program version {VERSION}"
        );
        Ok(Some(usize::from(axes)))
    }

    /// Hears what has come, and says what is to be said now.
    pub fn turn(&mut self) -> Result<()> {
        self.hear()?;
        let now = self.began.elapsed().as_millis() as u64;
        // As much as a window holds; what the controller says is looked at in between.
        for _ in 0..32 {
            match self.sender.step(now) {
                Step::Wait => break,
                Step::Send(request) => self.write(&request)?,
                Step::Item(number) => {
                    // Numbers are asked for below the count that was set.
                    if let Some(item) = self.items.get(number as usize) {
                        self.sent += 1;
                        let request = self.sender.item(number, item.clone());
                        self.write(&request)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Takes leave. Should the word be lost, the controller ends the session by itself.
    pub fn leave(&mut self) {
        // A session may be open whose answer has not come.
        if self.hello.is_some() && self.sender.denied().is_none() {
            let farewell = self.sender.farewell();
            // Nothing can be done about it here.
            let _ = self.write(&farewell);
            let _ = self.port.flush();
        }
    }

    /// Whether the session is open; why it will not be.
    pub fn is_open(&self) -> Result<bool> {
        match self.sender.denied() {
            None => Ok(self.sender.is_open()),
            Some(Denial::Stopping) => Ok(false),
            Some(Denial::Over) => {
                bail!("the session is over: another sender has taken the machine")
            }
            Some(Denial::Left) => bail!(
                "{}; --abort drops them: the machine stops, and this program begins where it stands then",
                Denial::Left
            ),
            Some(reason) => bail!("the controller does not take this program: {reason}"),
        }
    }

    /// More items.
    pub fn add_items(&mut self, items: Vec<Item>) {
        let first = self.items.len();
        let is_event = |item: &Item| match item {
            Item::Move(Move { path: Path::Event { .. }, .. })
            | Item::Power(PowerMove { rest: true, .. }) => true,
            Item::Switch(switch) => switch.trigger == SwitchTrigger::Rest,
            _ => false,
        };
        let events = items.iter().enumerate().filter(|(_, item)| is_event(item));
        self.events.extend(events.map(|(k, _)| first + k));
        self.items.extend(items);
        self.sender.set_items(self.items.len() as u32);
    }

    /// Whether the last item is a probe or homing: what follows depends on where the machine then stands.
    pub fn is_at_stop(&self) -> bool {
        matches!(self.items.last(), Some(Item::Probe(_) | Item::Home(_)))
    }

    /// Number of the last item.
    pub fn last_number(&self) -> u32 {
        (self.items.len() as u32).wrapping_sub(1)
    }

    /// What the machine was last said to do in this session.
    pub fn situation(&self) -> Option<&Situation> {
        self.status.as_ref().map(|(situation, _)| situation)
    }

    /// Forgets it, to wait for the next.
    pub fn forget(&mut self) {
        self.status = None;
    }

    /// Events that have happened and have not been told of.
    pub fn news(&mut self) -> Option<(u32, Event)> {
        let happened = self.situation()?.events as usize;
        while self.told < happened {
            let place = *self.events.get(self.told)?;
            self.told += 1;
            // Of outputs that switch at rest there is nothing to say.
            if let Item::Move(Move {
                path: Path::Event { letter, tenths, value, pause },
                tag,
                ..
            }) = self.items.get(place)?
            {
                let code = Code { letter: char::from(*letter), tenths: *tenths };
                return Some((*tag, Event { code, value: value.map(f64::from), pause: *pause }));
            }
        }
        None
    }

    /// Whether every item has been taken, by the last word of the controller.
    pub fn is_taken(&self) -> bool {
        let all = self.items.len() as u32;
        self.sender.taken() == all && self.status.as_ref().is_some_and(|(_, taken)| *taken == all)
    }

    /// Whether every item has been run.
    pub fn is_run(&self) -> bool {
        self.is_taken() && self.situation().is_some_and(|situation| situation.state == State::Idle)
    }

    /// Whether commands are still on their way.
    pub fn is_commanding(&self) -> bool {
        !self.sender.is_done()
    }

    /// Whether the controller has an abort, or a reason to stop of its own.
    pub fn is_told_to_stop(&self) -> bool {
        matches!(self.sender.refused(), Some(Refusal::Aborted | Refusal::Alarm))
    }

    /// Gives a controller that does not answer a little more time, for the last that is to be said.
    pub fn hope(&mut self) {
        self.heard = Instant::now();
        self.patience = HOPE;
    }

    /// Whether the machine stands, and runs nothing more of what it had.
    pub fn is_stopped(&self) -> bool {
        self.is_told_to_stop()
            && self.situation().is_some_and(|situation| match situation.state {
                State::Aborted => true,
                State::Alarm => situation.speed == 0.0,
                _ => false,
            })
    }

    /// In words.
    pub fn place(&self) -> String {
        match self.situation() {
            Some(situation) => describe_place(&situation.position),
            None => "an unknown place".to_owned(),
        }
    }
}
