//! Moves: where axis words lead, how fast, and along what.

use super::dialect::{Dialect, Use};
use super::error::{Note, Reason, Refusal};
use super::groups::{Codes, Found, Group};
use super::modal::Mode;
use super::offsets::{Place, Z, sum};
use super::probing::is_probe;
use super::reader::Reader;
use super::words::{LONGEST_DWELL, Words};
use super::{AXES, AXIS_WORDS, Code, LETTERS, is_rotary};
use crate::block::{Feed, Motion};
use crate::number::Coord;

/// A dwell from which on it is asked whether milliseconds were meant, s.
const LONG_DWELL: f64 = 100.0;

impl Reader {
    /// Codes that hold for their line only.
    pub(super) fn once(
        &mut self,
        found: Found,
        codes: &Codes,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let (code, column) = found;
        match code.tenths {
            40 => self.dwell(found, words),
            280 | 300 if self.settings.dialect == Dialect::Marlin => self.home(found, codes, words),
            280 | 300 => self.reference(found, codes, words),
            281 | 301 => {
                if words.has_axes() {
                    let what = "keeps the place where the machine is and takes no axis words";
                    return Err(Refusal::new(words.axis_column(), Reason::Context { code, what }));
                }
                let number = usize::from(code.tenths == 301);
                if let Some(reference) = self.frame.reference.get_mut(number) {
                    *reference = self.position;
                }
                Ok(())
            }
            // Of printers and of milling machines.
            100 | 520 | 920..=923 => self.shift(found, codes, words),
            _ => Err(Refusal::new(column, Reason::Unknown(code))),
        }
    }

    /// G4: P in seconds, of printers P in milliseconds or S in seconds.
    fn dwell(&mut self, (code, column): Found, words: &mut Words) -> Result<(), Refusal> {
        let is_marlin = self.settings.dialect == Dialect::Marlin;
        let unit = if is_marlin { 1000.0 } else { 1.0 };
        let p = words.take_in('P', code, (0.0, LONGEST_DWELL * unit), false)?.map(|p| p / unit);
        let seconds = if is_marlin {
            // S goes before P; without either it waits for the end of the motion.
            words.take_in('S', code, (0.0, LONGEST_DWELL), false)?.or(p).unwrap_or(0.0)
        } else {
            let missing = Reason::Missing { code, what: "a P word, seconds" };
            p.ok_or(Refusal::new(column, missing))?
        };
        if seconds >= LONG_DWELL && !is_marlin {
            self.note(Note::LongDwell(seconds));
        }
        #[cfg(feature = "outputs")]
        self.pierce(column)?;
        self.push_move(Motion::Dwell { seconds }, Feed::Rapid, true, column)
    }

    /// G28 and G30: over the point given to the reference point, in the axes named. Without axis words: X, Y, Z
    /// and whatever axes the program has moved.
    fn reference(&mut self, found: Found, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        let (code, column) = found;
        codes.check_one_taker(found)?;
        let values = words.take_axes(code)?;
        let home =
            self.frame.reference.get(usize::from(code.tenths == 300)).copied().unwrap_or_default();
        let all = values == [None; AXES];
        if !all {
            let over = self.target(&values, false).map_err(|reason| words.blame(reason))?;
            self.set_named(&values);
            self.rapid(over, column)?;
        }
        let mut to = self.position;
        for (axis, slot) in to.iter_mut().enumerate() {
            let named = values.get(axis).is_some_and(Option::is_some);
            let used = axis <= Z || self.named.get(axis) == Some(&true);
            let has = self.settings.axes.get(axis) == Some(&true);
            if named || all && used && has {
                *slot = home.get(axis).copied().unwrap_or_default();
            }
        }
        self.rapid(to, column)
    }

    /// G28 of printers: the axes named, X and Y before Z, whatever their numbers. Their shift is gone.
    fn home(&mut self, found: Found, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        let (code, column) = found;
        codes.check_one_taker(found)?;
        let named = ['X', 'Y', 'Z'].map(|letter| words.has(letter));
        // The others say how it is done.
        words.take_bare(&['X', 'Y', 'Z', 'E', 'L', 'O', 'R', 'W'], code);
        let home = self.frame.reference[0];
        let is_asked = |axis: usize| named == [false; 3] || named.get(axis) == Some(&true);
        for part in [0..Z, Z..Z + 1] {
            let mut to = self.position;
            for axis in part.filter(|&axis| is_asked(axis)) {
                if let (Some(slot), Some(at)) = (to.get_mut(axis), home.get(axis)) {
                    *slot = *at;
                }
                self.frame.clear_shift_of(axis);
            }
            self.rapid(to, column)?;
        }
        Ok(())
    }

    /// A rapid line, unless the machine is there.
    fn rapid(&mut self, to: Place, column: u32) -> Result<(), Refusal> {
        if to == self.position {
            return Ok(());
        }
        // (A row of cycles goes on behind it, as in LinuxCNC: on its own level, and with its words.)
        self.curve = None;
        self.push_move(Motion::Line { to }, Feed::Rapid, false, column)
    }

    /// Where axis words lead to. Axes without a word stay where they are, but for the other one of a plane
    /// that is turned.
    pub(super) fn target(
        &self,
        values: &[Option<f64>; AXES],
        machine: bool,
    ) -> Result<Place, Reason> {
        let mut to = self.position;
        for (axis, (slot, value)) in to.iter_mut().zip(values).enumerate() {
            let Some(value) = value else { continue };
            if self.settings.axes.get(axis) != Some(&true) {
                return Err(Reason::NoAxis(LETTERS.get(axis).copied().unwrap_or('?')));
            }
            let value = self.coordinate(axis, *value)?;
            *slot = match (machine, self.modal.relative) {
                (true, _) => value,
                (_, true) => sum(*slot, value),
                _ => sum(self.frame.offset(axis), value),
            };
        }
        if !machine {
            self.turn(values, &mut to)?;
        }
        for (axis, coord) in to.iter().enumerate() {
            let value = coord.to_mm();
            if value.abs() > Coord::LIMIT_MM {
                return Err(Reason::Coordinate { axis, value });
            }
        }
        Ok(to)
    }

    /// The two axes of a rotation, if one of them is named.
    fn turn(&self, values: &[Option<f64>; AXES], to: &mut Place) -> Result<(), Reason> {
        let Some(rotation) = self.frame.rotation else { return Ok(()) };
        let plane @ (p, q) = rotation.plane;
        let value = |axis: usize| values.get(axis).copied().flatten();
        if value(p).is_none() && value(q).is_none() {
            return Ok(());
        }
        let here = self.frame.in_program(&self.position, plane);
        let place = |axis: usize, here: Coord| match value(axis) {
            None => Ok(here),
            Some(value) => {
                let value = self.coordinate(axis, value)?;
                Ok(if self.modal.relative { sum(here, value) } else { value })
            }
        };
        let point = self.frame.in_machine((place(p, here.0)?, place(q, here.1)?), plane);
        for (axis, coord) in [(p, point.0), (q, point.1)] {
            if let Some(slot) = to.get_mut(axis) {
                *slot = coord;
            }
        }
        Ok(())
    }

    pub(super) fn set_named(&mut self, values: &[Option<f64>; AXES]) {
        for (named, value) in self.named.iter_mut().zip(values) {
            *named |= value.is_some();
        }
    }

    /// Axes that a move takes elsewhere, with or without a word.
    pub(super) fn set_moved(&mut self, motion: &Motion<f64, AXES>) {
        let ends = match motion {
            Motion::Line { to } => [to; 3],
            Motion::Arc { to, plane, .. } => {
                for axis in [plane.0, plane.1] {
                    self.set_named_axis(axis);
                }
                [to; 3]
            }
            Motion::Cubic { controls: [first, second], to } => [first, second, to],
            Motion::Dwell { .. } | Motion::Event { .. } => return,
        };
        for place in ends {
            let own = self.named.iter_mut().zip(&self.position);
            for ((named, from), to) in own.zip(place) {
                *named |= from != to;
            }
        }
    }

    pub(super) fn set_named_axis(&mut self, axis: usize) {
        if let Some(named) = self.named.get_mut(axis) {
            *named = true;
        }
    }

    /// The motion of a line, if it asks for any.
    pub(super) fn motion(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        self.motion_modes(codes, words);
        if let Some(found) = codes.g(Group::Motion)
            && is_probe(found.0.tenths)
        {
            return self.probe(found, codes, words);
        }
        if cfg!(feature = "nurbs")
            && let Some(found @ (Code { tenths: 52 | 53, .. }, _)) = codes.g(Group::Motion)
        {
            return self.begin_curve(found, codes, words);
        }
        let explicit = codes.g(Group::Motion);
        let machine = codes.g(Group::Machine);
        let mode = self.modal.mode;
        let code = mode.code();
        let centre = ['I', 'J', 'K', 'R'].into_iter().any(|letter| words.has(letter));
        let asks = words.has_axes() || mode.is_arc() && centre;
        if self.leaves_axes(codes, explicit, words) || !asks {
            if let (Some((code, column)), true) = (machine, !asks) {
                return Err(Refusal::new(column, Reason::Missing { code, what: AXIS_WORDS }));
            }
            return self.no_motion(codes, words);
        }
        if matches!(mode, Mode::None | Mode::Nurbs) {
            return Err(Refusal::new(words.axis_column(), Reason::NoMotion));
        }
        let column = explicit.map_or(words.axis_column(), |(_, column)| column);
        if let Some((code, column)) = machine
            && !matches!(mode, Mode::Rapid | Mode::Feed)
        {
            let what = "needs G0 or G1 in force";
            return Err(Refusal::new(column, Reason::Context { code, what }));
        }
        if let Mode::Cycle(cycle) = mode {
            return self.cycle(cycle, (code, column), words);
        }
        self.single_move((code, column), codes, words)
    }

    /// The motion mode of a line, and what it ends.
    fn motion_modes(&mut self, codes: &Codes, words: &mut Words) {
        if codes.g(Group::CycleEnd).is_some() {
            self.modal.mode = Mode::None;
            self.series = None;
        }
        if let Some((code, _)) = codes.g(Group::Motion) {
            self.modal.mode = Mode::of(code);
            if !matches!(self.modal.mode, Mode::Cycle(_)) {
                self.series = None;
            }
        }
        if let Some((code, _)) = codes.g(Group::Extruder) {
            // Retraction by the firmware: of the extruder only.
            words.take_bare(&['S', 'E'], code);
            self.note(Note::Extruder);
        }
    }

    /// A line whose motion code, if it has one, only sets the mode.
    fn no_motion(&mut self, codes: &Codes, words: &mut Words) -> Result<(), Refusal> {
        let (Some((code, column)), false) = (codes.g(Group::Motion), codes.takes_axes()) else {
            return Ok(());
        };
        self.extruder(code, words);
        match self.modal.mode {
            Mode::None | Mode::Rapid | Mode::Feed => Ok(()),
            _ => Err(Refusal::new(column, Reason::Missing { code, what: AXIS_WORDS })),
        }
    }

    /// A line, an arc or a curve.
    fn single_move(
        &mut self,
        (code, column): Found,
        codes: &Codes,
        words: &mut Words,
    ) -> Result<(), Refusal> {
        let mode = self.modal.mode;
        let values = words.take_axes(code)?;
        let from = self.position;
        let machine = codes.g(Group::Machine).is_some();
        let to = self.target(&values, machine).map_err(|reason| words.blame(reason))?;
        let before = self.curve.take();
        let path = match mode {
            Mode::Clockwise | Mode::CounterClockwise => {
                self.arc((code, column), &from, to, words)?
            }
            Mode::Cubic => self.cubic((code, column), &from, to, before, words)?,
            Mode::Quadratic => self.quadratic((code, column), &from, to, words)?,
            _ => Motion::Line { to },
        };
        let is_linear = |axis: usize| !is_rotary(axis) && to.get(axis) != from.get(axis);
        let linear = mode.is_arc() || (0..AXES).any(is_linear);
        let feed = self.speed((code, column), linear, words)?;
        self.extruder(code, words);
        self.set_named(&values);
        self.push_move(path, feed, codes.g(Group::Stop).is_some(), column)
    }

    /// Whether the axis words of a line, if there are any, are none of its motion.
    fn leaves_axes(&self, codes: &Codes, explicit: Option<Found>, words: &Words) -> bool {
        if codes.takes_axes() || codes.m(Use::Call).is_some() {
            return true;
        }
        // Elsewhere words beside these codes are the code's own: only a motion code of the line itself takes them.
        // (G50 X sets coordinates on a lathe, G92.1 X elsewhere.)
        let is_owner =
            |group, own: fn(u16) -> bool| codes.g(group).is_some_and(|(code, _)| own(code.tenths));
        let owned = is_owner(Group::Length, |tenths| tenths == 490)
            || is_owner(Group::Once, |tenths| matches!(tenths, 921..=923))
            || codes.g(Group::NO_SCALE).is_some()
            || self.settings.dialect == Dialect::Marlin && (codes.has_m() || words.has('T'));
        explicit.is_none() && owned
    }

    /// E words of printers are taken and left out.
    pub(super) fn extruder(&mut self, code: Code, words: &mut Words) {
        if self.settings.dialect == Dialect::Marlin && words.has('E') {
            words.take_bare(&['E'], code);
            self.note(Note::Extruder);
        }
    }

    /// How fast a move runs; a feed is over the linear axes if any of them moves.
    pub(super) fn speed(
        &mut self,
        (code, column): Found,
        linear: bool,
        words: &mut Words,
    ) -> Result<Feed<f64>, Refusal> {
        // Printers run G0 as G1: at the feed in force, if there is one.
        let as_feed = self.settings.dialect == Dialect::Marlin && self.feed.is_some();
        if self.modal.mode == Mode::Rapid && !as_feed {
            return Ok(Feed::Rapid);
        }
        if self.modal.inverse_time {
            let missing = Reason::Missing { code, what: "an F word in every line under G93" };
            let per_minute = words.take_in('F', code, (1.0e-6, 1.0e9), false)?;
            return Ok(Feed::Duration(60.0 / per_minute.ok_or(Refusal::new(column, missing))?));
        }
        let Some(feed) = self.feed else {
            let feed = self.settings.feed;
            self.note(Note::NoFeed(feed));
            return Ok(Feed::PerSecond(feed));
        };
        Ok(Feed::PerSecond(if linear { feed.speed } else { feed.plain / 60.0 }))
    }
}
