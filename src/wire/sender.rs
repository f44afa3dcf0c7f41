//! The host's end.

use super::message::{
    Command, Denial, ItemSerial, Opening, Refusal, Reply, Request, Taken, VERSION,
};
use heapless::Deque;

/// Silence after which the host sends again what is not acknowledged, ms.
const PATIENCE: u64 = 100;
/// Silence after which it says that it is there, ms; but at least so many times in the silence that the
/// controller allows.
const IDLE: u64 = 50;
const SIGNS: u64 = 5;
/// So many times as long without a status it is asked for between what else is to be said.
const LONG: u64 = 4;
/// Commands that may wait for their acknowledgement.
const COMMANDS: usize = 16;

/// What the host should do now.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Send the item with this number, as [`Sender::item`] wraps it.
    Item(u32),
    /// Send this.
    Send(Request),
    /// Listen.
    Wait,
}

/// The host's end of the line: which frame to send next, after what the controller has said. Items stay
/// with the caller, who is asked for them by number.
#[derive(Debug)]
pub struct Sender {
    opening: Opening,
    /// Whether the request to open it has been sent.
    opened: bool,
    /// The last word of the controller; `None` before the session is open.
    taken: Option<Taken>,
    /// Why the session is not open, if so.
    denied: Option<Denial>,
    /// Whether no more items are to be sent.
    ended: bool,
    /// Number of items in all.
    items: u32,
    /// Next item to be sent.
    item: u32,
    /// The number at which sending was taken up again after a gap last.
    back: Option<u32>,
    /// Commands not acknowledged: the first has the number `first`.
    commands: Deque<Command, COMMANDS>,
    first: u32,
    /// Whether the first command is on the line.
    commanded: bool,
    /// When something was last sent that is to be acknowledged, when anything was, and when there was
    /// progress, ms.
    sent: u64,
    spoke: u64,
    /// When the status was last asked for, ms.
    asked: u64,
    progress: u64,
}

impl Sender {
    /// A sender of `items` items. `session` should differ from that of other runs: a clock's time will
    /// do. When the controller has not heard from it for `silence` ms, it stops the machine; at 0 never.
    pub const fn new(session: u32, items: u32, silence: u16) -> Self {
        Self {
            opening: Opening { version: VERSION, session, silence, abort: false },
            opened: false,
            taken: None,
            denied: None,
            ended: false,
            items,
            item: 0,
            back: None,
            commands: Deque::new(),
            first: 0,
            commanded: false,
            sent: 0,
            spoke: 0,
            asked: 0,
            progress: 0,
        }
    }

    /// One that has what a dead session has left aborted first.
    #[must_use]
    pub const fn aborting(mut self) -> Self {
        self.opening.abort = true;
        self
    }

    /// Sets the number of items, for a caller who must know where the machine stands first.
    pub fn set_items(&mut self, items: u32) {
        self.items = items;
    }

    /// Whether the session is open.
    pub fn is_open(&self) -> bool {
        self.taken.is_some() && self.denied.is_none()
    }

    /// Why the session is not open, or is no more. While that is [`Denial::Stopping`], it goes on asking.
    pub fn denied(&self) -> Option<Denial> {
        self.denied
    }

    /// Items the controller has taken.
    pub fn taken(&self) -> u32 {
        self.taken.map_or(0, |taken| taken.next)
    }

    /// Why the controller takes no more, if so.
    pub fn refused(&self) -> Option<Refusal> {
        self.taken.and_then(|taken| taken.refused)
    }

    /// Whether the controller has taken every item and every command.
    pub fn is_done(&self) -> bool {
        self.taken() == self.items && self.commands.is_empty()
    }

    /// Queues a command, to be sent before any further item; `false` if too many wait already.
    pub fn command(&mut self, command: Command) -> bool {
        self.commands.push_back(command).is_ok()
    }

    /// Sends nothing more of the program, and queues an abort in place of the commands that wait.
    pub fn abort(&mut self) {
        self.ended = true;
        // The first may have been obeyed already: its number cannot be given to another.
        while self.commands.len() > 1 {
            self.commands.pop_back();
        }
        let queued = self.commands.push_back(Command::Abort);
        debug_assert!(queued.is_ok(), "an abort that is never sent");
    }

    /// What to say at the end, when everything is done. Should it be lost, the session ends by silence.
    pub fn farewell(&self) -> Request {
        Request::Close { session: self.opening.session }
    }

    /// Wraps an item for the line.
    pub fn item(&self, number: u32, item: super::Item) -> Request {
        Request::Item { session: self.opening.session, number, item }
    }

    /// What to do at the time `now`, ms.
    pub fn step(&mut self, now: u64) -> Step {
        let step = self.choose(now);
        if step != Step::Wait {
            self.spoke = now;
            if matches!(step, Step::Send(Request::Alive { .. })) {
                self.asked = now;
            } else {
                self.sent = now;
            }
        }
        step
    }

    fn choose(&mut self, now: u64) -> Step {
        let silent = now.saturating_sub(self.progress.max(self.sent)) >= PATIENCE;
        let session = self.opening.session;
        if !matches!(self.denied, None | Some(Denial::Stopping)) {
            return Step::Wait;
        }
        let Some(taken) = self.taken else {
            let open = !self.opened || silent;
            self.opened = true;
            return if open { Step::Send(Request::Open(self.opening)) } else { Step::Wait };
        };
        if silent {
            self.commanded = false;
            self.item = taken.next;
            self.back = None;
        }
        if let Some(&command) = self.commands.front()
            && !self.commanded
        {
            self.commanded = true;
            return Step::Send(Request::Command { session, number: self.first, command });
        }
        let idle = match self.opening.silence {
            0 => IDLE,
            silence => IDLE.min(u64::from(silence) / SIGNS),
        };
        // The end is known by the status, however much else is said.
        if now.saturating_sub(self.asked) >= idle * LONG {
            return Step::Send(Request::Alive { session });
        }
        let limit = ItemSerial::from_raw(taken.limit);
        let room = limit.since(ItemSerial::from_raw(self.item)).is_some_and(|room| room > 0);
        if self.item < self.items && room && taken.refused.is_none() && !self.ended {
            self.item += 1;
            return Step::Item(self.item - 1);
        }
        let quiet = now.saturating_sub(self.spoke) >= idle;
        if quiet { Step::Send(Request::Alive { session }) } else { Step::Wait }
    }

    /// Takes a reply of the controller at the time `now`, ms.
    pub fn hear(&mut self, reply: &Reply, now: u64) {
        let session = self.opening.session;
        let taken = match reply {
            Reply::Denied { session: denied, reason } if *denied == session => {
                self.denied = Some(*reason);
                return;
            }
            Reply::Opened(taken) if taken.session == session => {
                self.denied = None;
                *taken
            }
            Reply::Taken(taken) | Reply::Status { taken: Some(taken), .. }
                if self.taken.is_some() =>
            {
                *taken
            }
            _ => return,
        };
        if taken.session != session {
            // Someone else has the machine.
            self.denied = Some(Denial::Over);
            return;
        }
        let before = self.taken;
        self.taken = Some(taken);
        while self.first != taken.commands && self.commands.pop_front().is_some() {
            self.first = self.first.wrapping_add(1);
            self.commanded = false;
        }
        if before.is_none_or(|before| before.next != taken.next) {
            self.progress = now;
        }
        self.item = self.item.max(taken.next);
        // Once for every gap: the items behind it are on the line already, and each is reported.
        if taken.gap && self.back != Some(taken.next) {
            self.back = Some(taken.next);
            self.item = taken.next;
        }
    }
}
