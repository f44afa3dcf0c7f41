//! The controller's end.

use super::frame::{FRAME, Inlet, encode};
use super::jog::{JogMove, JogRefusal};
use super::message::{
    Command, Denial, Item, ItemSerial, Opening, Refusal, Reply, Request, SILENCE, Situation, State,
    Taken, VERSION,
};
use super::moves::{Move, Path};
#[cfg(feature = "outputs")]
use super::outputs::IN_TIME;
use super::outputs::{PowerMove, SwitchMove, SwitchRefusal};
use super::seeking::Seeking;
use crate::block::{Block, Motion, PushError};
#[cfg(feature = "outputs")]
use crate::block::{Power, SwitchError};
use crate::number::{Coord, Scalar};
use crate::planner::{Planner, Progress};
use crate::servo::events::{Event, Events};
use crate::servo::{Activity, Controls, Setpoint};
use heapless::Deque;

/// What waits for the planner.
#[derive(Clone, Copy, Debug)]
pub(super) enum Waiting<S, const N: usize> {
    Block(Block<S, N>),
    Event(Event),
    #[cfg(feature = "outputs")]
    Switch(SwitchMove),
    #[cfg(feature = "outputs")]
    Power(PowerMove),
    /// What is in [`Station::seeking`].
    #[cfg_attr(not(feature = "probe"), allow(dead_code))]
    Seek,
    End,
}

/// What has become of the first item of the queue.
enum Fed {
    Taken,
    /// It waits.
    Full,
    /// Nothing is taken any more.
    Aborted,
    Refused(Refusal),
}

/// Lines that are handed over in one call: no more work than a slice of planning.
const FED: usize = 4;

/// The session of the sender that has the machine.
#[derive(Clone, Copy, Debug)]
struct Session {
    number: u32,
    /// Number of the item that comes next.
    next: ItemSerial,
    /// Number of the command that comes next.
    commands: u32,
    refused: Option<Refusal>,
    /// Silence after which the sender is lost, ms; 0: never.
    silence: u16,
    /// When it was last heard of, ms.
    heard: u32,
    /// It has been silent for too long: another may have the machine, if nothing is left to run.
    lapsed: bool,
    /// It has left.
    closed: bool,
    /// Events that had happened when it began.
    events: u32,
}

/// The hold that the station has pressed for a sender that is lost.
#[derive(Clone, Copy, Debug)]
struct OwnHold {
    /// Its number, if none that an operator had pressed was in force.
    alone: Option<u32>,
}

impl OwnHold {
    fn press(controls: Controls<'_>) -> Self {
        let (held, last) = controls.held();
        controls.hold();
        Self { alone: (!held).then_some(last.wrapping_add(1)) }
    }
}

/// Replies that are due.
#[derive(Clone, Copy, Debug)]
pub(super) struct Due {
    hello: Option<u32>,
    denied: Option<(u32, Denial)>,
    opened: bool,
    pub taken: bool,
    pub status: bool,
    gap: bool,
}

impl Due {
    const NONE: Self =
        Self { hello: None, denied: None, opened: false, taken: false, status: false, gap: false };
}

/// The controller's end of the line: bytes in, blocks to the planner, commands out, replies out; and the
/// rules of who may move the machine: see [the module](super).
///
/// `QUEUE` items wait until the planner has room; that is the window the host may fill. It holds
/// 104 bytes per item and 730 bytes besides (three axes, `f32`); with `probe` 112 more, with `home` 256.
#[derive(Debug)]
pub struct Station<S: Scalar, const N: usize, const QUEUE: usize> {
    inlet: Inlet,
    pub(super) queue: Deque<Waiting<S, N>, QUEUE>,
    /// Where the last move taken ends: the next begins there.
    pub(super) end: [Coord; N],
    session: Option<Session>,
    /// A request to open a session that has not been answered.
    knock: Option<Opening>,
    /// The session has been heard of since the last look at the clock.
    heard: bool,
    /// A jog that the planner has not seen.
    jog: Option<JogMove>,
    /// Why the last was not taken.
    jog_refused: Option<JogRefusal>,
    pub(super) seeking: Seeking<S, N>,
    /// What runs is to be dropped.
    pub(super) aborting: bool,
    /// An abort that no command of the session has asked for.
    alarm: bool,
    /// The machine is held because the sender has fallen silent.
    lost: Option<OwnHold>,
    /// Blocks are left that have not been run.
    left: bool,
    progress: Progress,
    starved: u32,
    /// Events of the session that have happened.
    happened: u32,
    pub(super) due: Due,
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
            end: [Coord::ZERO; N],
            session: None,
            knock: None,
            heard: false,
            jog: None,
            jog_refused: None,
            seeking: Seeking::NONE,
            aborting: false,
            alarm: false,
            lost: None,
            left: false,
            progress: Progress::NeedsBlocks,
            starved: 0,
            happened: 0,
            due: Due::NONE,
        }
    }

    /// Takes a byte from the line. Gives the command it completes, to be obeyed now: see
    /// [`Command::send`]. Everything else is remembered until [`Station::poll`] and
    /// [`Station::reply`].
    ///
    /// Cost: that of [`Inlet::push`].
    pub fn receive(&mut self, byte: u8) -> Option<Command> {
        match self.inlet.push::<Request>(byte)? {
            Request::Hello { session } => self.due.hello = Some(session),
            Request::Ask => self.due.status = true,
            Request::Open(opening) => self.knock = Some(opening),
            Request::Item { session, number, item } => {
                if self.owner(session).is_some() {
                    self.take(ItemSerial::from_raw(number), &item);
                }
            }
            Request::Command { session, number, command } => {
                return self.command(session, number, command);
            }
            Request::Alive { session } => {
                self.due.status = true;
                // Only to hear that it is there.
                let _ = self.owner(session);
            }
            Request::Close { session } => {
                // Who has only knocked goes, too.
                self.knock = self.knock.filter(|opening| opening.session != session);
                if let Some(owner) = self.owner(session) {
                    owner.closed = true;
                }
            }
        }
        None
    }

    /// The session, if it is this one and its sender has not left; and its sender has been heard.
    fn owner(&mut self, number: u32) -> Option<&mut Session> {
        let owner = self.session.as_mut().filter(|owner| owner.number == number && !owner.closed);
        self.heard |= owner.is_some();
        owner
    }

    fn command(&mut self, session: u32, number: u32, command: Command) -> Option<Command> {
        let owner = self.owner(session)?;
        let fresh = number == owner.commands;
        if fresh {
            owner.commands = owner.commands.wrapping_add(1);
        }
        self.due.taken = true;
        if !fresh {
            return None;
        }
        match command {
            Command::Abort | Command::QuickAbort => self.close(Refusal::Aborted),
            Command::Resume => self.lost = None,
            Command::Jog(jog) => self.jog = Some(jog),
            Command::Hold | Command::QuickHold | Command::CancelJog => self.jog = None,
            _ => {}
        }
        Some(command)
    }

    fn take(&mut self, number: ItemSerial, item: &Item) {
        self.due.taken = true;
        let Some(owner) = self.session else { return };
        if number != owner.next {
            self.due.gap |= number.since(owner.next).is_some();
            return;
        }
        // Without room the host has sent beyond the window: it will have to send it again.
        if owner.refused.is_some() || self.queue.is_full() || self.seeking.is_on() {
            return;
        }
        let prepared = match item {
            Item::End => Ok(Waiting::End),
            Item::Move(step) => self.prepare(step).ok_or(Refusal::Block { tag: step.tag }),
            Item::Switch(switch) => Self::prepare_switch(switch)
                .map_err(|reason| Refusal::Output { tag: switch.tag, reason }),
            Item::Power(power) => Self::prepare_power(power)
                .map_err(|reason| Refusal::Output { tag: power.tag, reason }),
            Item::Probe(probe) => self.prepare_probe(number.raw(), probe),
            Item::Home(home) => self.prepare_home(number.raw(), home),
        };
        let waiting = match prepared {
            Ok(waiting) => waiting,
            Err(reason) => return self.refuse(reason),
        };
        if self.queue.push_back(waiting).is_ok()
            && let Some(owner) = &mut self.session
        {
            owner.next = owner.next.next();
        }
    }

    /// A move as it waits; `None` if it is no block of this controller.
    fn prepare(&mut self, step: &Move) -> Option<Waiting<S, N>> {
        if let Path::Event { letter, tenths, value, pause } = step.path {
            return Some(Waiting::Event(Event { tag: step.tag, letter, tenths, value, pause }));
        }
        let block = step.block(&self.end).ok()?;
        if let Motion::Line { to } | Motion::Arc { to, .. } | Motion::Cubic { to, .. } =
            &block.motion
        {
            self.end = *to;
        }
        Some(Waiting::Block(block))
    }

    /// An output as it waits.
    #[cfg(feature = "outputs")]
    fn prepare_switch(switch: &SwitchMove) -> Result<Waiting<S, N>, SwitchRefusal> {
        switch.switch::<S>().check()?;
        Ok(Waiting::Switch(*switch))
    }

    #[cfg(feature = "outputs")]
    fn prepare_power(power: &PowerMove) -> Result<Waiting<S, N>, SwitchRefusal> {
        power.power::<S>().check()?;
        Ok(Waiting::Power(*power))
    }

    #[cfg(not(feature = "outputs"))]
    const fn prepare_switch(_: &SwitchMove) -> Result<Waiting<S, N>, SwitchRefusal> {
        Err(SwitchRefusal::Unknown)
    }

    #[cfg(not(feature = "outputs"))]
    const fn prepare_power(_: &PowerMove) -> Result<Waiting<S, N>, SwitchRefusal> {
        Err(SwitchRefusal::Unknown)
    }

    /// What has been taken before is run to its end; no more is taken.
    pub(super) fn refuse(&mut self, reason: Refusal) {
        self.no_more(reason);
        // There is room: the refused block itself would have needed it.
        let queued = self.queue.push_back(Waiting::End);
        debug_assert!(queued.is_ok(), "an end that never comes");
    }

    pub(super) fn no_more(&mut self, reason: Refusal) {
        if let Some(owner) = &mut self.session {
            owner.refused = Some(reason);
        }
        self.due.taken = true;
    }

    /// Drops what waits and takes nothing more until a new session is opened. For aborts that come from
    /// somewhere else than the line, together with [`Controls::abort`](crate::Controls::abort); with
    /// [`Refusal::Alarm`] it shows as [`State::Alarm`] until then.
    pub fn close(&mut self, reason: Refusal) {
        self.queue.clear();
        self.seeking.drop_waiting();
        (self.aborting, self.lost, self.jog) = (true, None, None);
        self.alarm |= reason == Refusal::Alarm;
        self.no_more(reason);
    }

    /// Hands items to the planner as long as it has room, lets it plan, and keeps the rules: call it in
    /// place of [`Planner::poll`]. `now` is the time in ms, from any beginning; it may wrap around. A sender
    /// that has been silent for longer than its session allows is lost with this call, and the machine is
    /// held. `events` are the firmware's.
    ///
    /// Cost: that of [`Planner::push`] for one block that is not a line, or for four others, and that of
    /// [`Planner::poll`]. If items are left that the planner could take at once, it says [`Progress::Planning`].
    pub fn poll<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
        now: u32,
    ) -> Progress {
        self.watch(planner, now);
        self.note_sought(planner);
        self.pass_jog(planner);
        let more = self.feed(planner, events);
        self.progress = planner.poll();
        if self.progress == Progress::Aborted && !self.aborting {
            self.close(Refusal::Aborted);
        }
        let ahead = planner.blocks_waiting() > 0 || planner.nodes_ahead() > 0;
        self.left = ahead || !self.queue.is_empty();
        self.starved = planner.counters().starved;
        let before = self.session.map_or(0, |owner| owner.events);
        self.happened = events.happened().wrapping_sub(before);
        if let Some(opening) = self.knock.take() {
            match self.admit(opening, planner, events, now) {
                Ok(()) => self.due.opened = true,
                Err(reason) => self.due.denied = Some((opening.session, reason)),
            }
        }
        match self.progress {
            Progress::Waiting | Progress::NeedsBlocks if more => Progress::Planning,
            progress => progress,
        }
    }

    /// Hands a jog over.
    #[cfg(feature = "jog")]
    fn pass_jog<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        let Some(jog) = self.jog.take() else { return };
        let taken = match jog.jog(&planner.jog_end()) {
            Ok(jog) => planner.jog(&jog).map_err(JogRefusal::from),
            Err(refusal) => Err(refusal),
        };
        self.jog_refused = taken.err();
        self.due.status = true;
        // A probe that waits would begin elsewhere, and go another way.
        let rests = planner.blocks_waiting() == 0 && planner.nodes_ahead() == 0;
        if taken.is_ok() && (!self.left || (self.seeking.is_on() && rests)) {
            self.queue.clear();
            self.seeking.drop_waiting();
            self.no_more(Refusal::Jogged);
        }
    }

    #[cfg(not(feature = "jog"))]
    fn pass_jog<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        _: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        if self.jog.take().is_some() {
            self.jog_refused = Some(JogRefusal::Unknown);
            self.due.status = true;
        }
    }

    /// Holds the machine if its sender is gone.
    fn watch<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
        now: u32,
    ) {
        let heard = core::mem::take(&mut self.heard);
        let Some(owner) = &mut self.session else { return };
        if heard {
            owner.heard = now;
            owner.lapsed = false;
        }
        let silence = if owner.silence > 0 { owner.silence } else { SILENCE };
        let silent = now.wrapping_sub(owner.heard) > u32::from(silence);
        if owner.lapsed || !(silent || owner.closed) {
            return;
        }
        owner.lapsed = true;
        let watched = owner.silence > 0 || owner.closed;
        #[cfg(feature = "jog")]
        if watched {
            planner.controls().cancel_jog();
        }
        if watched && self.left && !self.aborting {
            self.lost = Some(OwnHold::press(planner.controls()));
        }
    }

    /// Opens a session, if that may be.
    fn admit<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        opening: Opening,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
        now: u32,
    ) -> Result<(), Denial> {
        if opening.version != VERSION {
            return Err(Denial::Version);
        }
        if let Some(owner) = self.session {
            if owner.number == opening.session {
                // A second copy of the same request must not begin anew.
                return self.owner(opening.session).map(|_| ()).ok_or(Denial::Over);
            }
            // Whether one without a watchdog is still there nobody knows: what it runs can be stopped.
            let unknown = owner.silence == 0 && opening.abort;
            if !(owner.lapsed || unknown) {
                return Err(Denial::Busy);
            }
        }
        let (held, last) = planner.controls().held();
        let operated = held && self.lost.is_none_or(|own| own.alone != Some(last));
        if self.left && !self.aborting {
            if !opening.abort {
                return Err(Denial::Left);
            }
            // What an operator has pressed is not for the line to end.
            planner.controls().abort();
            if operated {
                planner.controls().hold();
            }
            self.close(Refusal::Aborted);
        }
        #[cfg(feature = "jog")]
        if planner.is_jogging() {
            planner.controls().cancel_jog();
            return Err(Denial::Stopping);
        }
        if self.left || (planner.is_aborted() && !planner.acknowledge_abort()) {
            return Err(Denial::Stopping);
        }
        if self.lost.take().is_some() && !operated {
            // It came to rest by itself before the hold could be obeyed, which is in force still.
            planner.controls().resume();
        }
        (self.aborting, self.alarm, self.heard) = (false, false, false);
        (self.jog, self.jog_refused) = (None, None);
        self.seeking = Seeking::NONE;
        #[cfg(feature = "outputs")]
        {
            let set = planner.set_power(&Power::OFF);
            debug_assert!(set.is_ok(), "a power that is always good");
        }
        self.progress = Progress::NeedsBlocks;
        self.end = *planner.end();
        events.clear();
        self.happened = 0;
        self.due = Due { hello: self.due.hello, status: self.due.status, ..Due::NONE };
        self.session = Some(Session {
            number: opening.session,
            next: ItemSerial::ZERO,
            commands: 0,
            refused: None,
            silence: opening.silence,
            heard: now,
            lapsed: false,
            closed: false,
            events: events.happened(),
        });
        Ok(())
    }

    /// Hands items to the planner as long as it has room, and what that takes is a slice. Whether there are more that it
    /// might take.
    fn feed<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
    ) -> bool {
        for fed in 0..QUEUE {
            let Some(waiting) = self.queue.front() else { return false };
            if fed >= FED {
                return true;
            }
            if let Waiting::Seek = waiting {
                self.begin_seek(planner);
                return false;
            }
            let slow = match waiting {
                Waiting::Block(block) => !matches!(block.motion, Motion::Line { .. }),
                Waiting::End => false,
                _ => true,
            };
            match Self::hand_over(waiting, planner, events) {
                Fed::Taken => {}
                Fed::Full => return false,
                Fed::Aborted => {
                    if !self.aborting {
                        self.close(Refusal::Aborted);
                    }
                    self.queue.clear();
                    return false;
                }
                Fed::Refused(reason) => {
                    self.queue.clear();
                    self.seeking.drop_waiting();
                    self.refuse(reason);
                    continue;
                }
            }
            self.queue.pop_front();
            // Room has come: the host wants to know.
            self.due.taken = true;
            if slow && !self.queue.is_empty() {
                return true;
            }
        }
        false
    }

    /// Hands one item to the planner.
    fn hand_over<const BLOCKS: usize, const NODES: usize, const M: usize>(
        waiting: &Waiting<S, N>,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
    ) -> Fed {
        let made;
        let (block, event) = match waiting {
            // It has its own way.
            Waiting::Seek => return Fed::Full,
            Waiting::End => {
                planner.finish();
                return Fed::Taken;
            }
            #[cfg(feature = "outputs")]
            Waiting::Switch(switch) => {
                let rests = switch.trigger == super::outputs::SwitchTrigger::Rest;
                let event = rests.then_some(switch.tag);
                return Self::hand_over_output(event, switch.tag, planner, events, |planner| {
                    planner.push_switch(&switch.switch())
                });
            }
            #[cfg(feature = "outputs")]
            Waiting::Power(power) => {
                let event = power.rest.then_some(power.tag);
                return Self::hand_over_output(event, power.tag, planner, events, |planner| {
                    if power.rest {
                        planner.push_power(&power.power(), power.tag)
                    } else {
                        planner.set_power(&power.power())
                    }
                });
            }
            Waiting::Block(block) => (block, None),
            // It comes when one before it has happened.
            Waiting::Event(_) if !events.has_room() => return Fed::Full,
            Waiting::Event(event) => {
                made = event.block();
                (&made, Some(*event))
            }
        };
        match planner.push(block) {
            Ok(()) => {
                if let Some(event) = &event {
                    events.put(event);
                }
                Fed::Taken
            }
            Err(PushError::Full) => Fed::Full,
            Err(PushError::Aborted) => Fed::Aborted,
            Err(PushError::Rejected { tag, reason }) => Fed::Refused(Refusal::of(tag, &reason)),
        }
    }

    /// The same of an output; `event`: the tag of the event at which it switches, if it does at rest.
    #[cfg(feature = "outputs")]
    fn hand_over_output<const BLOCKS: usize, const NODES: usize, const M: usize>(
        event: Option<u32>,
        tag: u32,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
        push: impl FnOnce(&mut Planner<'_, S, N, BLOCKS, NODES>) -> Result<(), SwitchError>,
    ) -> Fed {
        if event.is_some() && !events.has_room() {
            return Fed::Full;
        }
        match push(planner) {
            Ok(()) => {
                if let Some(tag) = event {
                    // It is counted with the events of the program.
                    let (letter, tenths) = (IN_TIME, 0);
                    events.put(&Event { tag, letter, tenths, value: None, pause: false });
                }
                Fed::Taken
            }
            // What it waits for never comes: nothing is left to run.
            Err(SwitchError::Full) if planner.is_empty() => {
                Fed::Refused(Refusal::Output { tag, reason: SwitchRefusal::Full })
            }
            Err(SwitchError::Full) => Fed::Full,
            Err(SwitchError::Aborted) => Fed::Aborted,
            Err(error) => Fed::Refused(Refusal::Output { tag, reason: error.into() }),
        }
    }

    /// Items taken in this session.
    pub fn taken(&self) -> u32 {
        self.session.map_or(0, |owner| owner.next.raw())
    }

    /// Whether no further item can be taken now.
    pub fn is_full(&self) -> bool {
        self.queue.is_full()
    }

    /// Whether items wait for the planner.
    pub fn is_waiting(&self) -> bool {
        !self.queue.is_empty()
    }

    /// What the machine is doing, by the last [`Station::poll`] and the last setpoint.
    pub fn state(&self, setpoint: &Setpoint<S, N>) -> State {
        let rests = setpoint.activity == Activity::Idle;
        match self.progress {
            _ if self.alarm => State::Alarm,
            Progress::Held if self.lost.is_some() => State::SenderLost,
            Progress::Held => State::Held,
            Progress::Aborted => State::Aborted,
            Progress::Done | Progress::NeedsBlocks if rests && !self.left => State::Idle,
            _ => State::Running,
        }
    }

    fn situation(&self, setpoint: &Setpoint<S, N>) -> Situation {
        Situation {
            state: self.state(setpoint),
            position: (0..N).map(|axis| setpoint.position_nm(axis)).collect(),
            speed: setpoint.path_speed.to_f64() as f32,
            tag: setpoint.tag,
            starved: self.starved,
            events: self.happened,
            jog: self.jog_refused,
            probe: self.seeking.probed(),
            homing: self.seeking.homed(),
        }
    }

    fn account(&self) -> Option<Taken> {
        let owner = self.session?;
        // What follows a probe waits until that is over.
        let room = if self.seeking.is_on() { 0 } else { QUEUE - self.queue.len() };
        Some(Taken {
            session: owner.number,
            next: owner.next.raw(),
            limit: owner.next.plus(room as u32).raw(),
            commands: owner.commands,
            gap: self.due.gap,
            refused: owner.refused,
        })
    }

    /// Writes the next reply that is due and gives its length; 0 if none is. Call it until then,
    /// whenever the line is free.
    pub fn reply(&mut self, setpoint: &Setpoint<S, N>, out: &mut [u8; FRAME]) -> usize {
        let reply = match (self.account(), self.due) {
            (_, Due { hello: Some(session), .. }) => {
                self.due.hello = None;
                let taken =
                    Taken { session, next: 0, limit: 0, commands: 0, gap: false, refused: None };
                Reply::Hello { version: VERSION, axes: N as u8, taken }
            }
            (_, Due { denied: Some((session, reason)), .. }) => {
                self.due.denied = None;
                Reply::Denied { session, reason }
            }
            (Some(taken), Due { opened: true, .. }) => {
                (self.due.opened, self.due.taken, self.due.gap) = (false, false, false);
                Reply::Opened(taken)
            }
            (taken, Due { status: true, .. }) => {
                (self.due.status, self.due.taken, self.due.gap) = (false, false, false);
                let situation = self.situation(setpoint);
                Reply::Status { taken, situation, damaged: self.inlet.damaged() }
            }
            (Some(taken), Due { taken: true, .. }) => {
                (self.due.taken, self.due.gap) = (false, false);
                Reply::Taken(taken)
            }
            _ => return 0,
        };
        encode(&reply, out).unwrap_or(0)
    }
}
