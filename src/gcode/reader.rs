//! A line in, actions out.

use super::dialect::{Dialect, Use};
use super::drilling::{Drilling, Series};
use super::error::{Note, Reason, Refusal};
use super::groups::{Codes, Group};
use super::lexer::{self, Shape};
use super::modal::{Modal, Mode, Plane};
use super::nurbs::{self, Curve};
use super::offsets::{Frame, Place, Setup};
use super::words::Words;
use super::{AXES, Action, Code, Event, ProbeMove};
use crate::block::{Block, Feed, Motion};
#[cfg(feature = "outputs")]
use crate::block::{Power, Switch};
use crate::machine::Quantity;
use crate::number::Coord;
use heapless::{Deque, Vec};

/// How programs are read.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Whose reading holds.
    pub dialect: Dialect,
    /// Feed of moves before any F word, mm/s.
    pub feed: f64,
    /// Where the machine stands. Axes that are never named stay there.
    pub start: Place,
    /// Which axes the machine has; words of others are refused.
    pub axes: [bool; AXES],
    /// Whether what is refused is left out with a note where it cannot change where the tool goes.
    pub lenient: bool,
    /// Whether lines that begin with `/` are left out.
    pub block_delete: bool,
    /// Offsets, tools and reference points of the machine.
    pub setup: Setup,
    /// Whether M62 to M68 switch in time with the path (feature `outputs`); else M62 to M65 are events, and the others refused.
    #[cfg(feature = "outputs")]
    pub switches: bool,
    /// What S and M3 to M5 are for, if not for a spindle (feature `outputs`).
    #[cfg(feature = "outputs")]
    pub laser: Option<super::Laser>,
    /// What M7 to M9 switch in time with the path, if they are no events (feature `outputs`).
    #[cfg(feature = "outputs")]
    pub coolant: Option<super::Coolant>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            dialect: Dialect::LinuxCnc,
            feed: 50.0,
            start: [Coord::ZERO; AXES],
            axes: [true; AXES],
            lenient: false,
            block_delete: false,
            setup: Setup::NONE,
            #[cfg(feature = "outputs")]
            switches: false,
            #[cfg(feature = "outputs")]
            laser: None,
            #[cfg(feature = "outputs")]
            coolant: None,
        }
    }
}

/// Feed in force.
#[derive(Clone, Copy, Debug)]
pub(super) struct FeedWord {
    /// As it was written, per minute: degrees, where only rotary axes move.
    pub plain: f64,
    /// With the unit that was in force where it was written, mm/s.
    pub speed: f64,
}

/// What comes before the moves of its line.
#[derive(Clone, Copy, Debug)]
enum Early {
    Event(Event),
    #[cfg(feature = "outputs")]
    Switch(Switch<f64>),
    #[cfg(feature = "outputs")]
    Power {
        power: Power<f64>,
        rest: bool,
    },
}

impl From<Early> for Action {
    fn from(early: Early) -> Self {
        match early {
            Early::Event(event) => Self::Event(event),
            #[cfg(feature = "outputs")]
            Early::Switch(switch) => Self::Switch(switch),
            #[cfg(feature = "outputs")]
            Early::Power { power, rest } => Self::Power { power, rest },
        }
    }
}

/// What a line asks for and has not been given out yet, in this order.
#[derive(Debug, Default)]
struct Pending {
    label: Option<u32>,
    events: Deque<Early, 16>,
    moves: Deque<Block<f64, AXES>, 3>,
    drilling: Option<Drilling>,
    probe: Option<ProbeMove>,
    last: Option<Action>,
}

impl Pending {
    fn is_empty(&self) -> bool {
        self.label.is_none()
            && self.events.is_empty()
            && self.moves.is_empty()
            && self.drilling.is_none()
            && self.probe.is_none()
            && self.last.is_none()
    }
}

/// Reads a program, line by line. 7.1 kB; 8.7 with the feature `nurbs`.
#[derive(Debug)]
pub struct Reader {
    pub(super) settings: Settings,
    pub(super) modal: Modal,
    pub(super) frame: Frame,
    /// Where the machine will stand after what has been read.
    pub(super) position: Place,
    /// Axes that moves have named or moved.
    pub(super) named: [bool; AXES],
    pub(super) feed: Option<FeedWord>,
    pub(super) spindle: Option<f64>,
    /// The tool that T or M61 has named last.
    pub(super) tool: Option<u32>,
    /// The tool that M6 or M61 has put into the spindle.
    pub(super) loaded: Option<u32>,
    /// Which of M3, M4 and M5 holds of a laser.
    #[cfg(feature = "outputs")]
    pub(super) beam: u16,
    /// Whether the last move was a rapid, or there was none.
    #[cfg(feature = "outputs")]
    pub(super) was_rapid: bool,
    /// From the end of the G5 before to its second control point.
    pub(super) curve: Option<[f64; 2]>,
    /// What the canned cycles of the lines before have said.
    pub(super) series: Option<Series>,
    /// A NURBS block.
    pub(super) nurbs: Curve,
    pub(super) words: Words,
    pub(super) line: u32,
    pending: Pending,
    notes: Vec<Note, 4>,
    begun: bool,
    ended: bool,
    /// A probe has been given out, and where it ended has not been said.
    probed: bool,
}

impl Reader {
    /// A reader at the start of a program.
    pub fn new(settings: &Settings) -> Self {
        let mode = if settings.dialect == Dialect::Grbl { Mode::Rapid } else { Mode::None };
        Self {
            settings: *settings,
            modal: Modal::new(mode),
            frame: Frame::new(&settings.setup),
            position: settings.start,
            named: [false; AXES],
            feed: None,
            spindle: None,
            tool: None,
            loaded: None,
            #[cfg(feature = "outputs")]
            beam: 5,
            #[cfg(feature = "outputs")]
            was_rapid: true,
            curve: None,
            series: None,
            nurbs: Curve::default(),
            words: Words::new(),
            line: 0,
            pending: Pending::default(),
            notes: Vec::new(),
            begun: false,
            ended: false,
            probed: false,
        }
    }

    /// Reads a line, without its end; `number` becomes the tag of its moves. What it asks for comes out of
    /// [`Reader::action`]; after the end of the program it asks for nothing.
    ///
    /// # Errors
    /// What is refused, and the column. Nothing of such a line is done; the reader can go on to the next one,
    /// to find what else is wrong, with the modes of what has been understood.
    pub fn line(&mut self, number: u32, text: &[u8]) -> Result<(), Refusal> {
        self.notes.clear();
        if self.ended {
            return Ok(());
        }
        if self.probed || !(self.pending.is_empty() && self.nurbs.is_done()) {
            return Err(Refusal::new(1, Reason::Busy));
        }
        self.line = number;
        // Words are looked at by several that change other things of the reader.
        let mut words = core::mem::take(&mut self.words);
        let outcome = lexer::split(text, self.settings.dialect, &mut words)
            .and_then(|shape| self.shaped(shape, &mut words));
        self.words = words;
        if outcome.is_err() {
            self.pending = Pending::default();
            if let Some(end) = self.nurbs.refuse() {
                self.position = end;
            }
            if self.nurbs.is_open() && self.names_end(text) {
                // Else the lines behind the block would be refused as lines of it.
                self.position = self.nurbs.refuse_end();
                self.modal.mode = Mode::None;
            }
        }
        outcome
    }

    /// Whether a line that is refused has the end of a NURBS block among its words, before or behind what is wrong with it.
    fn names_end(&mut self, text: &[u8]) -> bool {
        let mut rest = text;
        // Every round leaves out a byte at least.
        for _ in 0..text.len() {
            let wrong = lexer::split(rest, self.settings.dialect, &mut self.words).err();
            if self.words.names(nurbs::END) {
                return true;
            }
            let Some(behind) = wrong.and_then(|wrong| rest.get(wrong.column as usize..)) else {
                return false;
            };
            rest = behind;
        }
        false
    }

    /// Moves to the corners of a canned cycle that has not begun.
    #[cfg(feature = "grbl")]
    pub(crate) fn cycle_corners(&self) -> impl Iterator<Item = Block<f64, AXES>> + '_ {
        let cycle = self.pending.drilling.as_ref();
        cycle.into_iter().flat_map(|cycle| (0..4).map(|number| cycle.corner(number, self.line)))
    }

    /// The next thing to do for the line read last; `None` when that is all. The cost is that of one move.
    pub fn action(&mut self) -> Option<Action> {
        if let Some(label) = self.pending.label.take() {
            return Some(Action::Label(label));
        }
        if let Some(early) = self.pending.events.pop_front() {
            return Some(early.into());
        }
        if let Some(block) = self.pending.moves.pop_front() {
            return Some(Action::Move(block));
        }
        if let Some(block) = self.curve_block() {
            return Some(Action::Move(block));
        }
        if let Some(mut drilling) = self.pending.drilling.take()
            && let Some(block) = drilling.step(&mut self.position, self.line)
        {
            self.pending.drilling = Some(drilling);
            return Some(Action::Move(block));
        }
        if let Some(probe) = self.pending.probe.take() {
            self.probed = true;
            return Some(Action::Probe(probe));
        }
        let last = self.pending.last.take();
        self.ended |= last == Some(Action::End);
        last
    }

    /// Says where the machine stands after a probe: the next line begins there. At any other time it is where a jog, or whatever else has
    /// moved it, has left it; with a line still to be given out, nothing changes.
    pub fn set_position(&mut self, place: &Place) {
        if self.pending.is_empty() && self.nurbs.is_done() || self.probed {
            (self.position, self.probed) = (*place, false);
            (self.curve, self.series) = (None, None);
        }
    }

    /// The next block of a NURBS.
    fn curve_block(&mut self) -> Option<Block<f64, AXES>> {
        let mut to = self.position;
        let block = self.nurbs.step(&mut to)?;
        self.set_moved(&block.motion);
        self.position = to;
        Some(block)
    }

    /// To be asked where the text ends without an end of the program (M2, M30, %).
    ///
    /// # Errors
    /// What of it is not complete: a NURBS block without its G5.3.
    pub fn finish(&self) -> Result<(), Refusal> {
        let open = self.nurbs.is_open() && !self.ended;
        if open {
            Err(Refusal::new(1, Reason::Missing { code: Code::g(52), what: "its end, G5.3" }))
        } else {
            Ok(())
        }
    }

    /// What is worth a remark about the line read last.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// Where the machine will stand when all that has been given out is done.
    pub fn position(&self) -> &Place {
        &self.position
    }

    /// Axes that moves have named so far, or moved without their word: by a rotation, along an arc or a hole, to a
    /// reference point.
    pub fn named(&self) -> [bool; AXES] {
        self.named
    }

    /// Whether the end of the program has been given out.
    pub fn has_ended(&self) -> bool {
        self.ended
    }

    /// The line read last asks for nothing more.
    pub(super) fn drop_pending(&mut self) {
        self.pending = Pending::default();
        self.probed = false;
        self.notes.clear();
        // The rest of a curve; of one that is open, all of it.
        self.nurbs.refuse();
    }

    pub(super) fn set_ended(&mut self, ended: bool) {
        self.ended = ended;
    }

    pub(super) fn pending_moves(&self) -> impl Iterator<Item = &Block<f64, AXES>> {
        self.pending.moves.iter()
    }

    pub(super) const fn pending_probe(&self) -> Option<&ProbeMove> {
        self.pending.probe.as_ref()
    }

    pub(super) fn pending_last(&self) -> Option<Action> {
        self.pending.label.map(Action::Label).or(self.pending.last)
    }

    fn shaped(&mut self, shape: Shape, words: &mut Words) -> Result<(), Refusal> {
        if shape.percent {
            if self.begun {
                let outcome = self.finish();
                self.nurbs.drop();
                self.ended |= outcome.is_err();
                outcome?;
                self.pending.last = Some(Action::End);
            }
            self.begun = true;
            return Ok(());
        }
        if shape.deleted && self.settings.block_delete {
            return Ok(());
        }
        if words.is_empty() {
            return Ok(());
        }
        if shape.deleted {
            self.note(Note::Optional);
        }
        self.begun = true;
        words.take_bare(&[], Code::word('N'));
        words.take_in('N', Code::word('N'), (0.0, 1.0e9), false)?;
        if self.nurbs.is_open() && words.has('O') {
            let what = "cannot stand in a NURBS block (G5.2 to G5.3)";
            let reason = Reason::Context { code: Code::word('O'), what };
            return Err(Refusal::new(words.column('O'), reason));
        }
        if let Some(label) = words.take_in('O', Code::word('O'), (0.0, 99_999.0), true)? {
            self.pending.label = Some(label as u32);
            return self.leftovers(words);
        }
        let (dialect, lenient) = (self.settings.dialect, self.settings.lenient);
        let notes = &mut self.notes;
        let codes = Codes::sort(words, dialect, lenient, &mut |note| {
            // A line has few notes; those of more are said of other lines.
            let _ = notes.push(note);
        })?;
        if self.nurbs.is_open() {
            return self.curve_line(&codes, words).and_then(|()| self.leftovers(words));
        }
        if let Some((found, what)) = codes.alone {
            words.take_all(found.0);
            self.alone(found.0, what, words);
            return Ok(());
        }
        let before = self.position;
        let outcome = self.execute(&codes, words).and_then(|()| self.leftovers(words));
        if outcome.is_err() && !codes.takes_axes() && self.position == before {
            self.recover(&codes, words);
        }
        if outcome.is_err() && codes.g(Group::Motion).is_some_and(|(code, _)| code == nurbs::BEGIN)
        {
            // The lines behind it are no moves.
            self.nurbs.begin(&before);
        }
        outcome
    }

    /// The order of execution is that of RS274/NGC.
    fn execute(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        self.modes(codes, words)?;
        self.feed_word(words)?;
        self.machine_events(codes, words)?;
        self.length(codes, words)?;
        self.offset(codes)?;
        self.rotation(codes, words)?;
        if let Some(found) = codes.g(Group::Once) {
            self.once(found, codes, words)?;
        }
        self.motion(codes, words)?;
        self.last(codes, words)
    }

    /// Units, plane, distances, centres, feed mode, path mode.
    fn modes(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        if let Some((code, _)) = codes.g(Group::Units) {
            self.modal.inches = code.tenths == 200;
        }
        if let Some((code, column)) = codes.g(Group::Plane) {
            let plane = match code.tenths {
                170 => Plane::Xy,
                180 => Plane::Zx,
                _ => Plane::Yz,
            };
            if plane != self.modal.plane && self.frame.rotation.is_some() {
                let what = "cannot change the plane of a rotation (G68)";
                return Err(Refusal::new(column, Reason::Context { code, what }));
            }
            if plane != self.modal.plane {
                self.series = None;
            }
            self.modal.plane = plane;
        }
        if let Some((code, _)) = codes.g(Group::Distance) {
            self.modal.relative = code.tenths == 910;
        }
        if let Some((code, _)) = codes.g(Group::Centre) {
            self.modal.absolute_centre = code.tenths == 901;
        }
        if let Some((code, _)) = codes.g(Group::Feed) {
            let inverse_time = code.tenths == 930;
            if inverse_time != self.modal.inverse_time {
                // A feed of the other mode is none of this.
                self.feed = None;
            }
            self.modal.inverse_time = inverse_time;
        }
        if let Some((code, _)) = codes.g(Group::Return) {
            self.modal.to_initial = code.tenths == 980;
        }
        if let Some((code, _)) = codes.g(Group::Path) {
            self.modal.exact_stop = code.tenths != 640;
            if code.tenths == 640 {
                let scale = self.scale();
                let greatest = Quantity::Tolerance.range().greatest;
                let p = words.take_in('P', code, (0.0, greatest), false)?;
                words.take_in('Q', code, (0.0, greatest), false)?;
                self.modal.tolerance = p.map(|p| p * scale);
            }
        }
        Ok(())
    }

    /// F, in the unit that is in force in its line. (Under G93 it belongs to the move.)
    pub(super) fn feed_word(&mut self, words: &mut Words) -> Result<(), Refusal> {
        if self.modal.inverse_time {
            return Ok(());
        }
        let scale = self.scale();
        if let Some(plain) = words.take_in('F', Code::word('F'), (1.0e-6, 1.0e9), false)? {
            self.feed = Some(FeedWord { plain, speed: plain * scale / 60.0 });
        }
        Ok(())
    }

    /// The stop, the call or the end of a line.
    fn last(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        if let Some((code, _)) = codes.m(Use::Stop) {
            let ends = matches!(code.tenths, 20 | 300);
            let event = Event { code, value: None, pause: true };
            self.pending.last = Some(if ends { Action::End } else { Action::Event(event) });
        }
        if let Some((code, column)) = codes.m(Use::Call) {
            self.pending.last = Some(if code.tenths == 990 {
                Action::Return
            } else {
                let program = words.take_in('P', code, (1.0, 9999.0), true)?;
                let missing = Reason::Missing { code, what: "a P word, the number of the program" };
                let program = program.ok_or(Refusal::new(column, missing))? as u32;
                let times = words.take_in('L', code, (1.0, 9999.0), true)?.unwrap_or(1.0) as u32;
                Action::Call { program, times }
            });
        }
        Ok(())
    }

    /// What no code has taken.
    fn leftovers(&mut self, words: &mut Words) -> Result<(), Refusal> {
        while let Some(word) = words.left().copied() {
            let letter = char::from(word.letter);
            let mut refusal = Refusal::new(word.column, Reason::Unused(letter));
            if word.value.is_none() {
                refusal.reason = Reason::NoNumber(letter);
            } else if self.settings.lenient && refusal.is_harmless() {
                self.note(Note::LeftOut(refusal.reason));
                words.take_bare(&[letter], Code::word(letter));
                continue;
            }
            return Err(refusal);
        }
        Ok(())
    }

    /// After a line that is refused: where it would have ended, and in which mode, lest the lines after it are refused
    /// for it.
    fn recover(&mut self, codes: &Codes, words: &Words) {
        if let Some((code, _)) = codes.g(Group::Motion) {
            self.modal.mode = Mode::of(code);
        }
        let mut values = [None; AXES];
        for (value, letter) in values.iter_mut().zip(super::LETTERS) {
            let word = words.list().iter().find(|word| char::from(word.letter) == letter);
            *value = word.and_then(|word| word.value);
        }
        if let Ok(to) = self.target(&values, false) {
            self.position = to;
        }
    }

    pub(super) fn note(&mut self, note: Note) {
        // As above: those of more are said of other lines.
        let _ = self.notes.push(note);
    }

    pub(super) fn push_event(
        &mut self,
        code: Code,
        value: Option<f64>,
        pause: bool,
        column: u32,
    ) -> Result<(), Refusal> {
        self.push_early(Early::Event(Event { code, value, pause }), column)
    }

    fn push_early(&mut self, early: Early, column: u32) -> Result<(), Refusal> {
        self.pending.events.push_back(early).map_err(|_| Refusal::new(column, Reason::TooManyWords))
    }

    #[cfg(feature = "outputs")]
    pub(super) fn push_switch(&mut self, switch: Switch<f64>, column: u32) -> Result<(), Refusal> {
        self.push_early(Early::Switch(switch), column)
    }

    #[cfg(feature = "outputs")]
    pub(super) fn push_power(
        &mut self,
        power: Power<f64>,
        rest: bool,
        column: u32,
    ) -> Result<(), Refusal> {
        self.push_early(Early::Power { power, rest }, column)
    }

    /// A move, from where the machine stands; it stands at its end then.
    pub(super) fn push_move(
        &mut self,
        motion: Motion<f64, AXES>,
        feed: Feed<f64>,
        exact_stop: bool,
        column: u32,
    ) -> Result<(), Refusal> {
        self.set_moved(&motion);
        #[cfg(feature = "outputs")]
        if !matches!(motion, Motion::Dwell { .. }) {
            self.was_rapid = feed == Feed::Rapid;
        }
        if let Motion::Line { to } | Motion::Arc { to, .. } | Motion::Cubic { to, .. } = &motion {
            self.position = *to;
        }
        let block = Block {
            motion,
            feed,
            tolerance: self.modal.tolerance,
            exact_stop: exact_stop || self.modal.exact_stop,
            tag: self.line,
        };
        self.pending.moves.push_back(block).map_err(|_| Refusal::new(column, Reason::TooManyWords))
    }

    pub(super) fn set_probe(&mut self, probe: ProbeMove) {
        self.pending.probe = Some(probe);
    }

    pub(super) fn set_drilling(&mut self, drilling: Drilling) {
        self.pending.drilling = Some(drilling);
    }

    /// mm in the unit in force.
    pub(super) const fn scale(&self) -> f64 {
        if self.modal.inches { 25.4 } else { 1.0 }
    }
}
