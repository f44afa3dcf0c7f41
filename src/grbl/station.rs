//! The controller's end of the line.

use super::accessories::Accessories;
use super::code::{Alarm, Error};
use super::inbox::{Inbox, Line};
use super::outbox::Outbox;
use super::realtime::{self, Letters, Realtime};
use super::report::{Cadence, Inputs};
use super::settings::Settings;
use super::store::{Memory, Store};
use crate::block::Block;
#[cfg(feature = "outputs")]
use crate::block::{Power, Switch};
#[cfg(feature = "outputs")]
use crate::gcode::Laser;
#[cfg(feature = "probe")]
use crate::gcode::ProbeMove;
use crate::gcode::{self, Dialect, Reader};
use crate::machine::Travel;
use crate::number::{Coord, Scalar};
use crate::planner::{Planner, Progress};
use crate::servo::Controls;
use crate::servo::events::{Event, Events};
use heapless::Deque;

/// Events that wait for the motion to come to them.
const EVENTS: usize = 8;

/// What a line has asked for and the planner has had no room for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Waiting<S, const N: usize> {
    Block(Block<S, N>),
    Event(Event),
    #[cfg(feature = "outputs")]
    Timed(Timed<S>),
    #[cfg(feature = "probe")]
    Probe(ProbeMove),
}

/// What is done in time with the path.
#[cfg(feature = "outputs")]
#[derive(Clone, Copy, Debug)]
pub(super) enum Timed<S> {
    Switch(Switch<S>),
    Power { power: Power<S>, rest: bool },
}

/// A list that is written line by line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum List {
    /// `$$`
    Settings,
    /// `$#`
    Parameters,
    /// `$N`
    Startup,
    /// `$I`
    Build,
}

/// What is being done for the line that was read last.
#[derive(Clone, Copy, Debug)]
// One of them, in its place.
#[allow(clippy::large_enum_variant)]
pub(super) enum Doing<S, const N: usize> {
    Nothing,
    /// Its moves and events are handed over.
    Line {
        waiting: Option<Waiting<S, N>>,
    },
    /// It probes: `begun`, or when the machine rests.
    #[cfg(feature = "probe")]
    Probing {
        asked: ProbeMove,
        begun: bool,
    },
    /// It homes all axes, or one.
    #[cfg(feature = "home")]
    Homing {
        all: bool,
    },
    /// It ends a program: the machine comes to rest.
    Ending,
    /// It asks for a list, of which so many lines have been written.
    Listing {
        list: List,
        line: usize,
    },
}

/// What ends an abort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Abort {
    /// A reset: the banner.
    Reset,
    /// An alarm: the lock.
    Alarm,
    /// That of a probe: what modes and offsets were in force still are, as in grbl.
    Probe,
}

/// Why nothing is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lock {
    Open,
    Alarm,
    Sleep,
}

/// The controller's end of the line, in the protocol of grbl 1.1: see [the module](super).
///
/// It holds a [`Reader`], what is kept without power (twice), a line, and what is said: some 12 kB for three axes.
#[derive(Debug)]
pub struct Station<S: Scalar, const N: usize> {
    pub(super) inbox: Inbox,
    pub(super) outbox: Outbox,
    pub(super) letters: Letters,
    pub(super) reader: Reader,
    /// The reader before the line under way.
    pub(super) before: gcode::State,
    pub(super) memory: Memory<N>,
    pub(super) defaults: Memory<N>,
    pub(super) line: Line,
    pub(super) doing: Doing<S, N>,
    /// Startup lines that are to be run: the next.
    pub(super) startup: Option<usize>,
    /// The line under way is a startup line.
    pub(super) from_startup: bool,
    /// The reset that is being obeyed came in motion.
    pub(super) cut: bool,
    /// Lines that came before a jog was called off, and the line under way is one of them: they begin none.
    pub(super) cancelled: usize,
    pub(super) is_cancelled: bool,
    /// Lines that came before a hold that ended a jog, or while a reset was not complete, and whether the line under way is one of them:
    /// they begin no motion.
    pub(super) barred: usize,
    pub(super) is_barred: bool,
    /// Number of the last line of a program: its tag.
    pub(super) tag: u32,
    /// The travel of the configuration, which holds without soft limits.
    pub(super) travel: Option<Travel<N>>,
    pub(super) abort: Option<Abort>,
    /// An alarm that has not been said for want of room.
    pub(super) unsaid: Option<Alarm>,
    pub(super) lock: Lock,
    pub(super) check: bool,
    /// Lines have been checked, and the abort that ends that is not complete.
    pub(super) checked: bool,
    pub(super) held: bool,
    pub(super) door: bool,
    pub(super) jogging: bool,
    /// Where the last probe ended, and whether it had contact.
    pub(super) probed: ([Coord; N], bool),
    /// The laser in force, and its power at the last setpoint.
    #[cfg(feature = "outputs")]
    pub(super) laser: Option<Laser>,
    pub(super) power: f32,
    /// Of feeds, rapids and the spindle, per cent.
    pub(super) overrides: [u16; 3],
    /// The spindle is stopped by its override.
    pub(super) stopped: bool,
    /// As the lines that have been read ask for.
    pub(super) programmed: Accessories,
    /// As they are.
    pub(super) actual: Accessories,
    /// Events that have been handed over and have not happened.
    pub(super) events: Deque<Event, EVENTS>,
    /// Of these, how many have happened and have not been told.
    pub(super) happened: usize,
    /// Events that had happened at the last look.
    pub(super) seen: u32,
    pub(super) status: bool,
    pub(super) cadence: Cadence,
    pub(super) inputs: Inputs,
    pub(super) progress: Progress,
    pub(super) rests: bool,
    pub(super) empty: bool,
    pub(super) blocks: u32,
    pub(super) room: u32,
    /// What reports tell, and what they will from a tag on.
    pub(super) offsets: [Coord; N],
    pub(super) next_offsets: Option<(u32, [Coord; N])>,
    /// Work offsets may have changed since they were kept.
    pub(super) touched: bool,
    /// Settings have changed since they were told.
    pub(super) changed: bool,
}

/// The first axes of a place.
pub(super) fn own<const N: usize>(place: &gcode::Place) -> [Coord; N] {
    core::array::from_fn(|axis| place.get(axis).copied().unwrap_or_default())
}

impl<S: Scalar, const N: usize> Station<S, N> {
    /// Of a machine at rest, before its first poll. `settings` are those that `$RST=$` brings back.
    pub fn new(settings: Settings<N>) -> Self {
        let reading = gcode::Settings {
            dialect: Dialect::Grbl,
            axes: core::array::from_fn(|axis| axis < N),
            #[cfg(feature = "outputs")]
            switches: true,
            ..gcode::Settings::default()
        };
        let memory = Memory::new(settings);
        Self {
            inbox: Inbox::default(),
            outbox: Outbox::default(),
            letters: Letters::default(),
            reader: Reader::new(&reading),
            before: gcode::State::new(),
            memory: memory.clone(),
            defaults: memory,
            line: Line::new(),
            doing: Doing::Nothing,
            startup: None,
            from_startup: false,
            cut: false,
            cancelled: 0,
            is_cancelled: false,
            barred: 0,
            is_barred: false,
            tag: 0,
            travel: None,
            abort: None,
            unsaid: None,
            lock: Lock::Open,
            check: false,
            checked: false,
            held: false,
            door: false,
            jogging: false,
            probed: ([Coord::ZERO; N], false),
            #[cfg(feature = "outputs")]
            laser: None,
            power: 0.0,
            overrides: [100; 3],
            stopped: false,
            programmed: Accessories::OFF,
            actual: Accessories::OFF,
            events: Deque::new(),
            happened: 0,
            seen: 0,
            status: false,
            cadence: Cadence::default(),
            inputs: Inputs::default(),
            progress: Progress::NeedsBlocks,
            rests: true,
            empty: true,
            blocks: 0,
            room: 0,
            offsets: [Coord::ZERO; N],
            next_offsets: None,
            touched: false,
            changed: true,
        }
    }

    /// Takes a byte from the line. What is a command by itself is obeyed now.
    ///
    /// Cost: a comparison or two; that of a line where the room for lines is full.
    pub fn receive(&mut self, byte: u8, controls: Controls<'_>) {
        if self.letters.goes_on(byte) {
            return;
        }
        match realtime::command(byte) {
            None => self.inbox.push(byte),
            Some(Realtime::Status) => self.status = true,
            Some(Realtime::Reset) => self.reset(controls),
            Some(command) => {
                if self.lock == Lock::Open && !self.check && self.abort.is_none() {
                    self.obey(command, controls);
                }
            }
        }
    }

    /// Whoever sent has gone, where that can be known (a network; a USB port that is closed): the line that has begun and not ended is
    /// dropped, so that it does not become another with what the next one sends. Whole lines are run.
    ///
    /// Cost: that of a line.
    pub fn hang_up(&mut self) {
        self.inbox.cut();
        self.letters = Letters::default();
        let waiting = self.inbox.waiting();
        (self.cancelled, self.barred) = (self.cancelled.min(waiting), self.barred.min(waiting));
    }

    /// Hands lines to the planner as long as it has room, lets it plan, and keeps the rules: call it in place of
    /// [`Planner::poll`], again and again. `events` are the firmware's; `store` is only asked while the machine rests.
    ///
    /// Cost: that of reading a line and of [`Planner::push`] for one block, and that of [`Planner::poll`]. If more could be done at once
    /// it says [`Progress::Planning`].
    pub fn poll<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
        store: &mut impl Store,
        inputs: Inputs,
    ) -> Progress {
        if self.travel.is_none() {
            // A reset may have come before anything else.
            let progress = planner.poll();
            if planner.is_aborted() && (!planner.acknowledge_abort() || planner.is_aborted()) {
                return progress;
            }
            (self.abort, self.blocks) = (None, BLOCKS as u32);
            self.begin(planner, store);
        }
        self.say_alarm();
        self.watch(planner, inputs);
        let happened = events.happened();
        self.happened += happened.wrapping_sub(self.seen) as usize;
        self.seen = happened;
        let more = self.abort.is_none() && self.work(planner, events, store);
        self.progress = planner.poll();
        self.complete_abort(planner, events);
        self.jogging = planner.is_jogging();
        #[cfg(feature = "probe")]
        if self.seeks(planner) {
            self.jogging = false;
        }
        self.empty = planner.is_empty();
        self.room = (BLOCKS - planner.blocks_waiting().min(BLOCKS)) as u32;
        if self.touched && self.empty {
            self.keep_offsets(store);
        }
        match self.progress {
            Progress::Waiting | Progress::NeedsBlocks | Progress::Done if more => {
                Progress::Planning
            }
            progress => progress,
        }
    }

    /// What has been kept is in force; the banner.
    fn begin<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        store: &mut impl Store,
    ) {
        self.travel = Some(*planner.travel());
        if let Some(memory) = Memory::load(store, &self.defaults) {
            self.memory = memory;
        }
        let kept = self.apply(planner);
        debug_assert!(kept, "a machine that does not rest when it begins");
        self.load_offsets();
        if self.memory.settings.homing() {
            // Nobody knows where the machine stands.
            self.lock = Lock::Alarm;
        }
        self.greet();
    }

    /// The banner; what runs at a start. Where a motion was cut off, that would begin another which nobody expects: as in grbl.
    pub(super) fn greet(&mut self) {
        self.outbox.end();
        self.outbox.line("Grbl 1.1h ['$' for help]");
        let cut = core::mem::take(&mut self.cut);
        if self.lock == Lock::Open {
            self.startup = (!cut).then_some(0);
        } else {
            self.outbox.line("[MSG:'$H'|'$X' to unlock]");
        }
    }

    /// The answer to the line under way.
    pub(super) fn answer(&mut self, outcome: Result<(), Error>) {
        if core::mem::take(&mut self.from_startup) {
            let Self { outbox, line, .. } = self;
            outbox.byte(b'>').bytes(line).byte(b':');
        }
        match outcome {
            Ok(()) => self.outbox.line("ok"),
            Err(error) => self.outbox.text("error:").whole(error as u32).end(),
        }
    }

    /// Reports tell other offsets from the line with this tag on.
    pub(super) fn show_offsets_from(&mut self, tag: u32) {
        let offsets = own(&self.reader.offsets());
        let newest = self.next_offsets.map_or(self.offsets, |(_, next)| next);
        if offsets != newest {
            self.next_offsets = Some((tag, offsets));
        }
    }

    pub(super) fn show_offsets_now(&mut self) {
        self.offsets = own(&self.reader.offsets());
        self.next_offsets = None;
        self.cadence.tell_offsets();
    }

    /// Whether the machine is idle: it rests, is not locked, and has nothing to run.
    pub(super) fn is_idle<const BLOCKS: usize, const NODES: usize>(
        &self,
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
    ) -> bool {
        let free = self.lock == Lock::Open && !self.check && !self.held && !self.door;
        free && self.abort.is_none() && planner.is_empty()
    }

    /// Whether axes are being homed.
    pub(super) const fn homes(&self) -> bool {
        #[cfg(feature = "home")]
        let homes = matches!(self.doing, Doing::Homing { .. });
        #[cfg(not(feature = "home"))]
        let homes = false;
        homes
    }

    /// Whether what moves the machine off the path is no jog: a probe, or homing.
    #[cfg(feature = "probe")]
    fn seeks<const BLOCKS: usize, const NODES: usize>(
        &self,
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
    ) -> bool {
        #[cfg(feature = "home")]
        if planner.is_homing() {
            return true;
        }
        planner.is_probing() || self.waits_for_input()
    }

    /// Whether the line under way is one that an input ends.
    pub(super) const fn waits_for_input(&self) -> bool {
        #[cfg(feature = "probe")]
        let probes = matches!(self.doing, Doing::Probing { .. });
        #[cfg(not(feature = "probe"))]
        let probes = false;
        probes || self.homes()
    }

    /// Spindle and coolant are switched off, at the end of a program.
    pub(super) fn switch_off(&mut self) {
        (self.programmed, self.actual) = (Accessories::OFF, Accessories::OFF);
        self.overrides = [100; 3];
        self.cadence.tell_overrides();
    }
}
