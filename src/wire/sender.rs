//! The host's end.

use super::message::{Command, Refusal, Reply, Request, Taken};
use heapless::Deque;

/// Silence after which the host sends again what is not acknowledged, ms.
const PATIENCE: u64 = 100;
/// Silence after which it asks how things are, ms.
const IDLE: u64 = 50;
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
    session: u32,
    /// Whether the request to open it has been sent.
    opening: bool,
    /// The last word of the controller; `None` before the session is open.
    taken: Option<Taken>,
    /// Axes of the controller.
    axes: u8,
    version: u8,
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
    progress: u64,
}

impl Sender {
    /// A sender of `items` items. `session` should differ from that of other runs: a clock's time will
    /// do.
    pub const fn new(session: u32, items: u32) -> Self {
        Self {
            session,
            opening: false,
            taken: None,
            axes: 0,
            version: 0,
            items,
            item: 0,
            back: None,
            commands: Deque::new(),
            first: 0,
            commanded: false,
            sent: 0,
            spoke: 0,
            progress: 0,
        }
    }

    /// Sets the number of items, for a caller who must know the controller's axes first.
    pub fn set_items(&mut self, items: u32) {
        self.items = items;
    }

    /// Axes of the controller, and the version of its protocol, once the session is open.
    pub fn controller(&self) -> Option<(u8, u8)> {
        self.taken.map(|_| (self.axes, self.version))
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

    /// Wraps an item for the line.
    pub fn item(&self, number: u32, item: super::Item) -> Request {
        Request::Item { session: self.session, number, item }
    }

    /// What to do at the time `now`, ms.
    pub fn step(&mut self, now: u64) -> Step {
        let step = self.choose(now);
        if step != Step::Wait {
            self.spoke = now;
            if step != Step::Send(Request::Ask) {
                self.sent = now;
            }
        }
        step
    }

    fn choose(&mut self, now: u64) -> Step {
        let silent = now.saturating_sub(self.progress.max(self.sent)) >= PATIENCE;
        let session = self.session;
        let Some(taken) = self.taken else {
            let open = !self.opening || silent;
            self.opening = true;
            return if open { Step::Send(Request::Open { session }) } else { Step::Wait };
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
        let room = taken.limit.wrapping_sub(self.item).cast_signed() > 0;
        if self.item < self.items && room && taken.refused.is_none() {
            self.item += 1;
            return Step::Item(self.item - 1);
        }
        if now.saturating_sub(self.spoke) >= IDLE { Step::Send(Request::Ask) } else { Step::Wait }
    }

    /// Takes a reply of the controller at the time `now`, ms.
    pub fn hear(&mut self, reply: &Reply, now: u64) {
        let taken = match reply {
            Reply::Opened { version, axes, taken } if taken.session == self.session => {
                (self.version, self.axes) = (*version, *axes);
                *taken
            }
            Reply::Taken(taken) | Reply::Status { taken: Some(taken), .. } => *taken,
            _ => return,
        };
        if taken.session != self.session || self.version == 0 {
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
