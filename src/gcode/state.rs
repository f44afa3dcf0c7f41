//! The reader of a controller that is talked to: its state is told, kept, brought back, and set to where the machine stands.

#[cfg(feature = "outputs")]
use super::Laser;
use super::error::{Reason, Refusal};
use super::groups::{Codes, Group};
use super::lexer;
use super::modal::{Modal, Mode, Plane};
use super::offsets::{Frame, Place, Setup, difference, offset_code};
use super::reader::{FeedWord, Reader};
use super::{AXES, Action, Code, ProbeMove};
use crate::block::Block;
use crate::number::Coord;

/// All that lines change and lines behind them build on: [`Reader::save`]. 1.2 kB.
#[derive(Clone, Debug)]
pub struct State {
    modal: Modal,
    frame: Frame,
    position: Place,
    named: [bool; AXES],
    feed: Option<FeedWord>,
    spindle: Option<f64>,
    tool: Option<u32>,
    loaded: Option<u32>,
    ended: bool,
    #[cfg(feature = "outputs")]
    laser: (u16, bool),
}

/// The modes in force, for a report.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Modes {
    /// Codes in force: motion (G80: none), work offset, plane, units, distance, feed.
    pub codes: [Code; 6],
    /// Whether lengths are in inches.
    pub inches: bool,
    /// Number of the tool.
    pub tool: u32,
    /// Feed, mm/min; degrees/min where it was written for rotary axes. 0 before any F word.
    pub feed: f64,
    /// Speed of the spindle, 1/min.
    pub spindle: f64,
}

/// A line of motion without a program: axis words, G20 G21 G53 G90 G91, and F.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JogLine {
    /// Where it leads, in the machine.
    pub to: Place,
    /// Whether it is by a distance (G91).
    pub relative: bool,
    /// Feed, mm/s; degrees/s where only rotary axes are named.
    pub feed: f64,
}

impl State {
    /// The memory of one.
    pub fn new() -> Self {
        Self {
            modal: Modal::new(Mode::Rapid),
            frame: Frame::new(&Setup::NONE),
            position: Place::default(),
            named: [false; AXES],
            feed: None,
            spindle: None,
            tool: None,
            loaded: None,
            ended: false,
            #[cfg(feature = "outputs")]
            laser: (5, true),
        }
    }

    /// Where the machine stood.
    pub const fn position(&self) -> &Place {
        &self.position
    }
}

impl Default for State {
    fn default() -> Self {
        Self::new()
    }
}

impl Reader {
    /// Keeps the state before a line. Cost: a copy of it.
    pub fn save(&self, state: &mut State) {
        state.modal = self.modal;
        state.frame.clone_from(&self.frame);
        state.position = self.position;
        state.named = self.named;
        (state.feed, state.spindle) = (self.feed, self.spindle);
        (state.tool, state.loaded) = (self.tool, self.loaded);
        state.ended = self.has_ended();
        #[cfg(feature = "outputs")]
        {
            state.laser = (self.beam, self.was_rapid);
        }
    }

    /// Brings it back: the lines since then, with whatever has not been given out of them, have not been. (A NURBS block that is
    /// open stays so, and is refused as a whole; what cycles and curves have said for the lines behind them is forgotten.)
    pub fn restore(&mut self, state: &State) {
        self.drop_pending();
        self.modal = state.modal;
        self.frame.clone_from(&state.frame);
        self.position = state.position;
        self.named = state.named;
        (self.feed, self.spindle) = (state.feed, state.spindle);
        (self.tool, self.loaded) = (state.tool, state.loaded);
        self.set_ended(state.ended);
        #[cfg(feature = "outputs")]
        {
            (self.beam, self.was_rapid) = state.laser;
        }
        (self.curve, self.series) = (None, None);
    }

    /// Says where the machine stands, in the axes it has. What lines before have said of a place - of a curve that goes on, of the
    /// cycles - is forgotten if that is another one, and a NURBS block that is open is refused.
    pub fn stand_at<const N: usize>(&mut self, place: &[Coord; N]) {
        let own = self.position.get_mut(..N).unwrap_or_default();
        if own != place {
            for (own, at) in own.iter_mut().zip(place) {
                *own = *at;
            }
            (self.curve, self.series) = (None, None);
            // Of a curve that is open: its beginning is where the machine stood.
            self.nurbs.refuse();
        }
    }

    /// What is still to be given out is dropped, and what a curve or a cycle would go on from. Modes, feed and offsets stay.
    pub fn drop_moves(&mut self) {
        self.drop_pending();
        self.nurbs.drop();
        (self.curve, self.series) = (None, None);
    }

    /// As after power-up, where the machine stands: modes, feed, shifts and the length of the tool are forgotten. Work offsets and
    /// reference points stay.
    pub fn restart(&mut self) {
        self.drop_moves();
        self.modal = Modal::new(Mode::Rapid);
        self.frame.clear_shift(false);
        self.frame.set_tool(Coord::ZERO);
        self.frame.rotation = None;
        self.frame.select(0);
        self.named = [false; AXES];
        (self.feed, self.spindle, self.tool, self.loaded) = (None, None, None, None);
        #[cfg(feature = "outputs")]
        {
            (self.beam, self.was_rapid) = (5, true);
        }
        self.set_ended(false);
    }

    /// A further program behind M2 or M30: modes are as RS274/NGC 3.6.1 has them after the end of one. Offsets, units and the feed stay.
    pub fn begin_anew(&mut self) {
        self.nurbs.drop();
        let modal = Modal { inches: self.modal.inches, ..Modal::new(Mode::Feed) };
        self.modal = modal;
        self.frame.rotation = None;
        self.frame.select(0);
        #[cfg(feature = "outputs")]
        {
            (self.beam, self.was_rapid) = (5, true);
        }
        (self.curve, self.series) = (None, None);
        self.set_ended(false);
    }

    /// The first moves of the line read last that have not been given out; further holes and pieces of a NURBS are none of these.
    pub fn moves(&self) -> impl Iterator<Item = &Block<f64, AXES>> {
        self.pending_moves()
    }

    /// Whether the line read last asks for another place of the text, which only its caller can know: a label, a call, a return.
    pub fn asks_for_text(&self) -> bool {
        matches!(self.pending_last(), Some(Action::Label(_) | Action::Call { .. } | Action::Return))
    }

    /// The probe of the line read last, as long as it has not been given out.
    pub const fn probe_move(&self) -> Option<&ProbeMove> {
        self.pending_probe()
    }

    /// What S and M3 to M5 are for from now on: a laser, with M5 in force, or a spindle (feature `outputs`).
    #[cfg(feature = "outputs")]
    pub fn set_laser(&mut self, laser: Option<Laser>) {
        self.settings.laser = laser;
        self.beam = 5;
    }

    /// Which of M3, M4 and M5 is in force of a laser; `None` if there is none (feature `outputs`).
    #[cfg(feature = "outputs")]
    pub fn beam(&self) -> Option<Code> {
        self.settings.laser.map(|_| Code::m(self.beam))
    }

    /// The modes in force.
    pub fn modes_in_force(&self) -> Modes {
        let modal = &self.modal;
        let plane = match modal.plane {
            Plane::Xy => 170,
            Plane::Zx => 180,
            Plane::Yz => 190,
        };
        let of = |either: bool, yes, no| Code::g(if either { yes } else { no });
        Modes {
            codes: [
                modal.mode.code(),
                offset_code(self.frame.active()),
                Code::g(plane),
                of(modal.inches, 200, 210),
                of(modal.relative, 910, 900),
                of(modal.inverse_time, 930, 940),
            ],
            inches: modal.inches,
            tool: self.tool.unwrap_or(0),
            feed: self.feed.map_or(0.0, |feed| feed.speed * 60.0),
            spindle: self.spindle.unwrap_or(0.0),
        }
    }

    /// Zero of a work offset, by its number from 0 (G54); `None` if nobody has set it.
    pub fn work_offset(&self, number: usize) -> Option<Place> {
        self.frame.work_of(number)
    }

    /// Sets the zero of a work offset, by its number from 0 (G54).
    pub fn set_work(&mut self, number: usize, place: &Place) {
        for (axis, at) in place.iter().enumerate() {
            self.frame.set_work(number, axis, *at);
        }
    }

    /// Where G28 (0) and G30 (1) go.
    pub fn reference_point(&self, number: usize) -> Place {
        self.frame.reference.get(number).copied().unwrap_or_default()
    }

    /// Sets where G28 (0) and G30 (1) go.
    pub fn set_reference(&mut self, number: usize, place: &Place) {
        if let Some(slot) = self.frame.reference.get_mut(number) {
            *slot = *place;
        }
    }

    /// The shift of G92 or G52.
    pub fn shift_in_force(&self) -> Place {
        self.frame.shift_in_force()
    }

    /// Length of the tool in force.
    pub fn tool_length(&self) -> Coord {
        self.frame.tool_length()
    }

    /// What is added to the program's coordinates of every axis: work offset, shift, length of the tool.
    pub fn offsets(&self) -> Place {
        core::array::from_fn(|axis| self.frame.offset(axis))
    }

    /// Reads a line of motion without a program, from where the reader stands. Modes, feed and position of the program stay as they are.
    ///
    /// # Errors
    /// What is refused; no F word is [`Reason::Missing`] of F.
    pub fn jog_line(&mut self, text: &[u8]) -> Result<JogLine, Refusal> {
        let modal = self.modal;
        let mut words = core::mem::take(&mut self.words);
        let outcome = lexer::split(text, self.settings.dialect, &mut words)
            .and_then(|_| self.read_jog(&mut words));
        self.words = words;
        self.modal = modal;
        outcome
    }

    fn read_jog(&mut self, words: &mut super::words::Words) -> Result<JogLine, Refusal> {
        words.take_in('N', Code::word('N'), (0.0, 1.0e9), false)?;
        let codes = Codes::sort(words, self.settings.dialect, false, &mut |_| {})?;
        let allowed = [Group::Distance, Group::Units, Group::Machine];
        if let Some((code, column)) = codes.beside(&allowed) {
            let what = "cannot stand in a line of a jog";
            return Err(Refusal::new(column, Reason::Context { code, what }));
        }
        if let Some((code, _)) = codes.g(Group::Units) {
            self.modal.inches = code.tenths == 200;
        }
        if let Some((code, _)) = codes.g(Group::Distance) {
            self.modal.relative = code.tenths == 910;
        }
        let machine = codes.g(Group::Machine).is_some();
        let code = Code::word('J');
        let values = words.take_axes(code)?;
        let feed = words.take_in('F', code, (1.0e-6, 1.0e9), false)?;
        if let Some(word) = words.left() {
            return Err(Refusal::new(word.column, Reason::Unused(char::from(word.letter))));
        }
        if values == [None; AXES] {
            return Err(Refusal::new(1, Reason::Missing { code, what: super::AXIS_WORDS }));
        }
        let feed = feed.ok_or(Refusal::new(1, Reason::Missing { code, what: "an F word" }))?;
        let to = self.target(&values, machine).map_err(|reason| words.blame(reason))?;
        let linear = values.iter().enumerate();
        let linear =
            linear.into_iter().any(|(axis, value)| value.is_some() && !super::is_rotary(axis));
        let scale = if linear { self.scale() } else { 1.0 };
        let relative = self.modal.relative && !machine;
        Ok(JogLine { to, relative, feed: feed * scale / 60.0 })
    }
}

impl JogLine {
    /// By which distance it leads from a place.
    pub fn distance(&self, from: &Place) -> Place {
        let mut by = Place::default();
        for (by, (to, from)) in by.iter_mut().zip(self.to.iter().zip(from)) {
            *by = difference(*to, *from);
        }
        by
    }
}
