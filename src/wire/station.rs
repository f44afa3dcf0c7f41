//! The controller's end.

use super::frame::{FRAME, Inlet, encode};
use super::message::{Command, Item, Refusal, Reply, Request, Situation, Taken, VERSION};
use crate::block::{Block, PushError};
use crate::number::Scalar;
use crate::planner::Planner;
use heapless::Deque;

/// What waits for the planner.
#[derive(Clone, Copy, Debug)]
enum Waiting<S, const N: usize> {
    Block(Block<S, N>),
    End,
}

/// The controller's end of the line: bytes in, blocks to the planner, commands out, replies out.
///
/// `QUEUE` items wait until the planner has room; that is the window the host may fill. It holds
/// 100 bytes per item and 350 bytes besides (three axes, `f32`).
#[derive(Debug)]
pub struct Station<S: Scalar, const N: usize, const QUEUE: usize> {
    inlet: Inlet,
    queue: Deque<Waiting<S, N>, QUEUE>,
    session: Option<u32>,
    next: u32,
    commands: u32,
    refused: Option<Refusal>,
    /// Whether the session has not begun on the planner: an abort before it is still to be acknowledged.
    fresh: bool,
    /// Replies that are due.
    opened: bool,
    taken: bool,
    asked: bool,
    gap: bool,
}

impl<S: Scalar, const N: usize, const QUEUE: usize> Default for Station<S, N, QUEUE> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const N: usize, const QUEUE: usize> Station<S, N, QUEUE> {
    /// A station before its first session.
    pub const fn new() -> Self {
        Self {
            inlet: Inlet::new(),
            queue: Deque::new(),
            session: None,
            next: 0,
            commands: 0,
            refused: None,
            fresh: false,
            opened: false,
            taken: false,
            asked: false,
            gap: false,
        }
    }

    /// Takes a byte from the line. Gives the command it completes, to be obeyed now: see
    /// [`Command::send`]. Everything else is remembered until [`Station::feed`] and
    /// [`Station::reply`].
    ///
    /// Cost: that of [`Inlet::push`].
    pub fn receive(&mut self, byte: u8) -> Option<Command> {
        match self.inlet.push::<Request>(byte)? {
            Request::Ask => self.asked = true,
            Request::Open { session } => self.open(session),
            Request::Item { session, number, item } if self.session == Some(session) => {
                self.take(number, &item);
            }
            Request::Command { session, number, command } if self.session == Some(session) => {
                self.taken = true;
                if number == self.commands {
                    self.commands = self.commands.wrapping_add(1);
                    if command == Command::Abort {
                        self.close(Refusal::Aborted);
                    }
                    return Some(command);
                }
            }
            Request::Item { .. } | Request::Command { .. } => {}
        }
        None
    }

    fn open(&mut self, session: u32) {
        self.opened = true;
        // A second copy of the same request must not begin anew.
        if self.session != Some(session) {
            self.session = Some(session);
            self.next = 0;
            self.commands = 0;
            self.refused = None;
            self.fresh = true;
            self.gap = false;
        }
    }

    fn take(&mut self, number: u32, item: &Item) {
        self.taken = true;
        if number != self.next {
            self.gap |= number.wrapping_sub(self.next) <= u32::MAX / 2;
            return;
        }
        // Without room the host has sent beyond the window: it will have to send it again.
        if self.refused.is_some() || self.queue.is_full() {
            return;
        }
        let waiting = match item {
            Item::End => Waiting::End,
            Item::Move(step) => match step.block() {
                Ok(block) => Waiting::Block(block),
                Err(_) => return self.refuse(step.tag),
            },
        };
        if self.queue.push_back(waiting).is_ok() {
            self.next = self.next.wrapping_add(1);
        }
    }

    /// What has been taken before is run to its end; no more is taken.
    fn refuse(&mut self, tag: u32) {
        self.refused = Some(Refusal::Block { tag });
        // There is room: the refused block itself would have needed it.
        let _ = self.queue.push_back(Waiting::End);
    }

    /// Drops what waits and takes nothing more until a new session is opened.
    pub fn close(&mut self, reason: Refusal) {
        self.queue.clear();
        self.refused = Some(reason);
        self.taken = true;
    }

    /// Hands items to the planner as long as it has room. Call it before every
    /// [`Planner::poll`].
    ///
    /// The first call in a new session acknowledges an abort from before it, and waits until that is
    /// complete; an abort later on, whoever asked for it, closes the session.
    pub fn feed<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        if planner.is_aborted() {
            let waits = self.fresh && self.refused.is_none();
            if !waits {
                if self.session.is_some() && self.refused.is_none() {
                    self.close(Refusal::Aborted);
                }
                return;
            }
            if !planner.acknowledge_abort() {
                return;
            }
        }
        self.fresh = false;
        for _ in 0..QUEUE {
            match self.queue.front() {
                None => return,
                Some(Waiting::End) => planner.finish(),
                Some(Waiting::Block(block)) => match planner.push(block) {
                    Ok(()) => {}
                    Err(PushError::Full | PushError::Aborted) => return,
                    Err(PushError::Rejected { tag, .. }) => {
                        self.queue.clear();
                        self.refuse(tag);
                        self.taken = true;
                        continue;
                    }
                },
            }
            self.queue.pop_front();
            // Room has come: the host wants to know.
            self.taken = true;
        }
    }

    /// Items taken in this session.
    pub fn taken(&self) -> u32 {
        self.next
    }

    /// Whether no further item can be taken now.
    pub fn is_full(&self) -> bool {
        self.queue.is_full()
    }

    /// Whether items wait for the planner.
    pub fn is_waiting(&self) -> bool {
        !self.queue.is_empty()
    }

    fn progress(&self) -> Option<Taken> {
        let room = QUEUE - self.queue.len();
        Some(Taken {
            session: self.session?,
            next: self.next,
            limit: self.next.wrapping_add(room as u32),
            commands: self.commands,
            gap: self.gap,
            refused: self.refused,
        })
    }

    /// Writes the next reply that is due and gives its length; 0 if none is. Call it until then,
    /// whenever the line is free.
    pub fn reply(&mut self, situation: impl FnOnce() -> Situation, out: &mut [u8; FRAME]) -> usize {
        let taken = self.progress();
        let reply = match taken {
            Some(taken) if self.opened => {
                (self.opened, self.taken) = (false, false);
                Reply::Opened { version: VERSION, axes: N as u8, taken }
            }
            taken if self.asked => {
                (self.asked, self.taken) = (false, false);
                Reply::Status { taken, situation: situation(), damaged: self.inlet.damaged() }
            }
            Some(taken) if self.taken => {
                self.taken = false;
                Reply::Taken(taken)
            }
            _ => return 0,
        };
        self.gap = false;
        encode(&reply, out).unwrap_or(0)
    }
}
