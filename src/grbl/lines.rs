//! Lines of a program: read, checked, handed over.

use super::code::{Alarm, Error};
use super::inbox::Lost;
#[cfg(feature = "outputs")]
use super::station::Timed;
use super::station::{Doing, Lock, Station, Waiting, own};
use super::store::Store;
use crate::block::{Block, Motion, PushError};
use crate::gcode::{Action, Note, Place};
use crate::number::{Coord, Scalar};
use crate::planner::Planner;
use crate::servo::events::{Event, Events};

/// A point over all axes.
pub(super) fn place_of<const N: usize>(at: &[Coord; N]) -> Place {
    let mut place = Place::default();
    for (slot, coord) in place.iter_mut().zip(at) {
        *slot = *coord;
    }
    place
}

/// Steps of lines in one poll, at most: a line of one move takes three.
const STEPS: usize = 6;

impl<S: Scalar, const N: usize> Station<S, N> {
    /// Does lines until the planner or the line out has no more room, or enough has been done for one poll. Whether more could be
    /// done at once.
    pub(super) fn work<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
        store: &mut impl Store,
    ) -> bool {
        for _ in 0..STEPS {
            if !self.outbox.has_room() {
                return false;
            }
            let goes_on = match self.doing {
                Doing::Nothing => {
                    let found = self.next_line();
                    match found {
                        Some(Ok(())) => self.begin_line(planner, store),
                        Some(Err(Lost)) => self.answer(Err(Error::Overflow)),
                        None => {}
                    }
                    found.is_some()
                }
                Doing::Line { waiting } => self.go_on(waiting, planner, events),
                #[cfg(feature = "probe")]
                Doing::Probing { asked, begun } => self.go_on_probing(&asked, begun, planner),
                #[cfg(feature = "home")]
                Doing::Homing { all } => self.go_on_homing(all, planner),
                Doing::Ending => {
                    let rests = planner.is_empty() || self.check;
                    if rests {
                        self.end_program(planner);
                    }
                    rests
                }
                Doing::Listing { list, line } => {
                    self.list(list, line);
                    true
                }
            };
            if !goes_on || self.abort_is_on() {
                return false;
            }
        }
        true
    }

    /// Takes the next line: one that runs at a start, or one that has come.
    fn next_line(&mut self) -> Option<Result<(), Lost>> {
        while let Some(next) = self.startup {
            let Some(text) = self.memory.startup.get(next) else {
                self.startup = None;
                break;
            };
            self.startup = Some(next + 1);
            if !text.is_empty() {
                self.line.clear();
                // Shorter than a line.
                let _ = self.line.extend_from_slice(text);
                self.from_startup = true;
                (self.is_cancelled, self.is_barred) = (false, false);
                return Some(Ok(()));
            }
        }
        let taken = self.inbox.take(&mut self.line)?;
        self.is_cancelled = self.cancelled > 0;
        self.cancelled = self.cancelled.saturating_sub(1);
        self.is_barred = self.barred > 0;
        self.barred = self.barred.saturating_sub(1);
        Some(taken)
    }

    fn begin_line<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        store: &mut impl Store,
    ) {
        let line = self.line.trim_ascii();
        let is_command = line.first() == Some(&b'$');
        let outcome = match line {
            [] | [b'%'] => Ok(()),
            [b'$', ..] => self.command(planner, store),
            _ if self.lock != Lock::Open || self.is_barred || planner.is_jogging() => {
                Err(Error::Locked)
            }
            _ => self.read(planner).map(|()| self.doing = Doing::Line { waiting: None }),
        };
        if outcome == Err(Error::Travel) && !is_command && !self.check {
            self.alarm(Alarm::SoftLimit, planner.controls());
        }
        match (outcome, self.doing) {
            (Ok(()), Doing::Line { .. } | Doing::Listing { .. }) => {}
            #[cfg(feature = "home")]
            (Ok(()), Doing::Homing { .. }) => {}
            (outcome, _) => self.answer(outcome),
        }
    }

    /// Reads a line. What is refused changes nothing.
    pub(super) fn read<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
    ) -> Result<(), Error> {
        if !self.check {
            self.reader.stand_at(planner.end());
        }
        self.reader.save(&mut self.before);
        self.tag = self.tag.wrapping_add(1);
        let read = self.reader.line(self.tag, &self.line).map_err(|refusal| Error::of(&refusal));
        let outcome = read.and_then(|()| self.may_be_done(planner));
        if outcome.is_err() {
            self.reader.restore(&self.before);
        }
        outcome
    }

    /// Whether the planner would take what a line asks for.
    fn may_be_done<const BLOCKS: usize, const NODES: usize>(
        &self,
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
    ) -> Result<(), Error> {
        if self.reader.asks_for_text() {
            return Err(Error::Unsupported);
        }
        if self.reader.notes().iter().any(|note| matches!(note, Note::NoFeed(_))) {
            return Err(Error::Feed);
        }
        let mut from: [Coord; N] = own(self.before.position());
        for block in self.reader.moves().copied().chain(self.reader.cycle_corners()) {
            let block = self.block(&Action::Move(block)).ok_or(Error::Unsupported)?;
            planner.check(&block, &from).map_err(|error| Error::of_block(&error))?;
            if let Motion::Line { to } | Motion::Arc { to, .. } | Motion::Cubic { to, .. } =
                &block.motion
            {
                from = *to;
            }
        }
        #[cfg(feature = "probe")]
        if let Some(asked) = self.reader.probe_move() {
            Self::check_probe(asked, &from, planner)?;
        }
        #[cfg(not(feature = "probe"))]
        if self.reader.probe_move().is_some() {
            return Err(Error::Unsupported);
        }
        Ok(())
    }

    /// A move as the planner takes it.
    fn block(&self, action: &Action) -> Option<Block<S, N>> {
        let block: Block<S, N> = action.block(&core::array::from_fn(|axis| axis))?;
        let tolerance = block.tolerance.unwrap_or(S::of(self.memory.settings.tolerance()));
        Some(Block { tolerance: Some(tolerance), ..block })
    }

    /// Hands over what a line asks for. Whether more could be done at once.
    fn go_on<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        waiting: Option<Waiting<S, N>>,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
    ) -> bool {
        let waiting = waiting.or_else(|| self.next());
        let pushed = match waiting {
            None => {
                self.finish_line(planner);
                return true;
            }
            #[cfg(feature = "probe")]
            Some(Waiting::Probe(asked)) => {
                self.begin_probe(&asked);
                return true;
            }
            Some(_) if self.check => Ok(()),
            Some(Waiting::Block(block)) => planner.push(&block),
            Some(Waiting::Event(_)) if !events.has_room() || self.events.is_full() => {
                Err(PushError::Full)
            }
            Some(Waiting::Event(event)) => self.push_event(&event, planner, events),
            #[cfg(feature = "outputs")]
            Some(Waiting::Timed(timed)) => self.push_timed(&timed, planner, events),
        };
        #[cfg(feature = "outputs")]
        if pushed == Err(PushError::Full)
            && matches!(waiting, Some(Waiting::Timed(_)))
            && planner.is_empty()
        {
            // Too many switches wait for a motion that cannot come before they are taken.
            self.reader.restore(&self.before);
            self.doing = Doing::Nothing;
            self.answer(Err(Error::Overflow));
            return true;
        }
        match pushed {
            Ok(()) => {
                self.doing = Doing::Line { waiting: None };
                true
            }
            Err(PushError::Full | PushError::Aborted) => {
                self.doing = Doing::Line { waiting };
                false
            }
            Err(PushError::Rejected { .. }) => {
                // A later move of the line, behind others that have been handed over.
                self.alarm(Alarm::SoftLimit, planner.controls());
                false
            }
        }
    }

    fn push_event<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        event: &Event,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
    ) -> Result<(), PushError> {
        planner.push(&event.block())?;
        events.put(event);
        // There is room: it has been asked for.
        let _ = self.events.push_back(*event);
        self.programmed.apply(event);
        Ok(())
    }

    /// What the line under way asks for next; `None` behind its last.
    fn next(&mut self) -> Option<Waiting<S, N>> {
        loop {
            match self.reader.action()? {
                action @ Action::Move(_) => return self.block(&action).map(Waiting::Block),
                Action::Event(event) => {
                    // An optional stop is none here.
                    if (event.code.letter, event.code.tenths) == ('M', 10) {
                        continue;
                    }
                    return Some(Waiting::Event(Event {
                        tag: self.tag,
                        letter: event.code.letter as u8,
                        tenths: event.code.tenths,
                        value: event.value.map(|value| value as f32),
                        pause: event.pause,
                    }));
                }
                #[cfg(feature = "outputs")]
                Action::Switch(switch) => {
                    return Some(Waiting::Timed(Timed::Switch(switch.to_scalar())));
                }
                #[cfg(feature = "outputs")]
                Action::Power { power, rest } => {
                    let power = power.to_scalar();
                    return Some(Waiting::Timed(Timed::Power { power, rest }));
                }
                #[cfg(feature = "probe")]
                Action::Probe(asked) => return Some(Waiting::Probe(asked)),
                // The end is seen by the reader's; labels, calls and returns have been refused.
                _ => {}
            }
        }
    }

    /// Everything of a line has been handed over.
    fn finish_line<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        self.show_offsets_from(self.tag);
        self.touched |= !self.check;
        if self.reader.has_ended() {
            planner.finish();
            self.doing = Doing::Ending;
            return;
        }
        self.doing = Doing::Nothing;
        self.answer(Ok(()));
    }

    /// The machine rests behind the end of a program.
    fn end_program<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        self.reader.begin_anew();
        self.show_offsets_from(self.tag);
        if !self.check {
            self.switch_off();
            #[cfg(feature = "outputs")]
            Self::power_off(planner);
            planner.controls().feed_override(100);
            planner.controls().rapid_override(100);
        }
        self.outbox.line("[MSG:Pgm End]");
        self.doing = Doing::Nothing;
        self.answer(Ok(()));
    }
}
