//! Commands of the line: `$`.

#[cfg(feature = "outputs")]
use super::accessories::Accessories;
use super::code::Error;
use super::inbox::{Line, RECEIVE};
use super::lines::place_of;
use super::report::{say_modes, say_place};
use super::station::{Doing, List, Lock, Station, own};
use super::store::{STARTUPS, Store, Text, WORKS};
use crate::gcode::{LETTERS, number};
use crate::jog::Jog;
use crate::machine::AxisTravel;
use crate::number::{Coord, Scalar};
use crate::planner::Planner;

impl<S: Scalar, const N: usize> Station<S, N> {
    /// Does a `$` command.
    pub(super) fn command<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        store: &mut impl Store,
    ) -> Result<(), Error> {
        self.compact();
        let line = self.line.clone();
        let idle = self.is_idle(planner);
        let rests = idle || self.lock == Lock::Alarm && planner.is_empty();
        let needs = |good: bool| if good { Ok(()) } else { Err(Error::NotIdle) };
        match line.as_slice() {
            b"$" => {
                self.outbox.line(
                    "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]",
                );
                Ok(())
            }
            b"$G" => {
                let inches = self.memory.settings.inches();
                let programmed = self.programmed;
                #[cfg(feature = "outputs")]
                let programmed = Accessories {
                    spindle: self.beam().unwrap_or(programmed.spindle),
                    ..programmed
                };
                say_modes(&mut self.outbox, &self.reader.modes_in_force(), programmed, inches);
                Ok(())
            }
            [b'$', b'J', b'=', ..] if self.is_cancelled => Ok(()),
            [b'$', b'J', b'=', ..] if self.is_barred => Err(Error::NotIdle),
            [b'$', b'J', b'=', jog @ ..] => {
                needs(idle || self.lock == Lock::Open && planner.is_jogging())?;
                self.jog(jog, planner)
            }
            b"$C" => {
                if self.touched && idle {
                    // Before lines that are only checked change them.
                    self.keep_offsets(store);
                }
                self.toggle_check(planner, idle)
            }
            b"$X" => self.unlock(),
            b"$$" => needs(rests || self.check).map(|()| self.begin_list(List::Settings)),
            b"$#" => needs(rests || self.check).map(|()| self.begin_list(List::Parameters)),
            b"$I" => needs(rests || self.check).map(|()| self.begin_list(List::Build)),
            b"$N" => needs(rests || self.check).map(|()| self.begin_list(List::Startup)),
            #[cfg(feature = "home")]
            [b'$', b'H', name @ ..] => {
                needs(rests)?;
                self.begin_homing(name, planner)
            }
            #[cfg(not(feature = "home"))]
            b"$H" => {
                needs(rests)?;
                Err(Error::HomingDisabled)
            }
            b"$SLP" => {
                needs(rests)?;
                self.lock = Lock::Sleep;
                self.outbox.line("[MSG:Sleeping]");
                Ok(())
            }
            [b'$', b'R', b'S', b'T', b'=', what] => {
                needs(rests)?;
                self.forget(*what, planner, store)
            }
            [b'$', b'I', b'=', text @ ..] => {
                needs(rests)?;
                self.memory.info = Text::from_slice(text).map_err(|_| Error::TooLong)?;
                self.keep(store)
            }
            [b'$', b'N', number, b'=', text @ ..] => {
                needs(idle)?;
                self.set_startup(*number, text, planner, store)
            }
            [b'$', rest @ ..] => {
                needs(rests)?;
                self.set(rest, planner, store)
            }
            _ => Err(Error::Statement),
        }
    }

    /// Leaves out blanks and comments, and makes letters capital.
    fn compact(&mut self) {
        let mut compact = Line::new();
        let mut within = false;
        for &byte in &self.line {
            match byte {
                b'(' => within = true,
                b')' if within => within = false,
                b';' if !within => break,
                b' ' | b'\t' => {}
                // It is no longer than it was.
                _ if !within => _ = compact.push(byte.to_ascii_uppercase()),
                _ => {}
            }
        }
        self.line = compact;
    }

    fn jog<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        text: &[u8],
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) -> Result<(), Error> {
        let end = planner.jog_end();
        self.reader.stand_at(&end);
        let jog = self.reader.jog_line(text).map_err(|refusal| Error::of_jog_line(&refusal))?;
        let from = place_of(&end);
        let to: [Coord; N] = own(&jog.to);
        let feed = S::of(jog.feed);
        let inside = is_inside(&planner.travel().axes(), &to);
        let jog = if jog.relative {
            Jog::Step { by: own(&jog.distance(&from)), feed }
        } else {
            Jog::To { to, feed }
        };
        if !inside {
            return Err(Error::Travel);
        }
        planner.jog(&jog).map_err(|error| Error::of_jog(&error))?;
        self.jogging = true;
        Ok(())
    }

    fn toggle_check<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
        idle: bool,
    ) -> Result<(), Error> {
        if self.check {
            self.outbox.line("[MSG:Disabled]");
            self.leave_check(planner.controls());
            return Ok(());
        }
        if !idle {
            return Err(Error::NotIdle);
        }
        self.check = true;
        self.outbox.line("[MSG:Enabled]");
        Ok(())
    }

    fn unlock(&mut self) -> Result<(), Error> {
        if self.lock == Lock::Alarm {
            if self.is_door_open() {
                return Err(Error::Door);
            }
            if self.must_stop() {
                return Err(Error::Locked);
            }
            self.lock = Lock::Open;
            self.outbox.line("[MSG:Caution: Unlocked]");
        }
        Ok(())
    }

    /// `$RST=`: what had been set is as it was.
    fn forget<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        what: u8,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        store: &mut impl Store,
    ) -> Result<(), Error> {
        if !matches!(what, b'$' | b'#' | b'*') {
            return Err(Error::Statement);
        }
        if matches!(what, b'$' | b'*') {
            self.memory.settings = self.defaults.settings;
        }
        if matches!(what, b'#' | b'*') {
            (self.memory.work, self.memory.reference) =
                (self.defaults.work, self.defaults.reference);
            self.load_offsets();
        }
        if what == b'*' {
            self.memory = self.defaults.clone();
        }
        if !self.apply(planner) {
            return Err(Error::NotIdle);
        }
        self.keep(store)?;
        self.outbox.line("[MSG:Restoring defaults]");
        Ok(())
    }

    fn set_startup<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        number: u8,
        text: &[u8],
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        store: &mut impl Store,
    ) -> Result<(), Error> {
        let number = usize::from(number.wrapping_sub(b'0'));
        if number >= STARTUPS {
            return Err(Error::Statement);
        }
        let text = Text::from_slice(text).map_err(|_| Error::TooLong)?;
        if text.first() == Some(&b'$') {
            return Err(Error::Statement);
        }
        self.line.clear();
        // Shorter than a line.
        let _ = self.line.extend_from_slice(&text);
        // It is looked at, and not done.
        self.read(planner)?;
        self.reader.restore(&self.before);
        if let Some(slot) = self.memory.startup.get_mut(number) {
            *slot = text;
        }
        self.keep(store)
    }

    /// A number, `=` and a value.
    fn set<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        text: &[u8],
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        store: &mut impl Store,
    ) -> Result<(), Error> {
        let (number, rest) = number::parse(text).ok_or(Error::Statement)?;
        let [b'=', value @ ..] = rest else { return Err(Error::Statement) };
        let (value, rest) = number::parse(value).ok_or(Error::Number)?;
        let is_number = (0.0..256.0).contains(&number) && libm::trunc(number) >= number;
        if !is_number || !rest.is_empty() {
            return Err(Error::Statement);
        }
        let before = self.memory.settings;
        self.memory.settings.set(number as u32, value)?;
        if !self.apply(planner) {
            self.memory.settings = before;
            return Err(Error::NotIdle);
        }
        self.keep(store)
    }

    /// Puts the settings in force. `false`: the machine does not rest.
    pub(super) fn apply<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) -> bool {
        let settings = &self.memory.settings;
        let Some(limits) = settings.limits() else { return false };
        if !planner.set_limits_at_rest(limits) {
            return false;
        }
        #[cfg(feature = "outputs")]
        self.apply_laser(planner);
        let settings = &self.memory.settings;
        let open = self.travel.unwrap_or(*planner.travel());
        let soft = settings.soft_limits().then(|| settings.travel()).flatten();
        planner.set_travel(soft.unwrap_or(open));
        self.changed = true;
        true
    }

    /// Writes what outlasts power.
    fn keep(&mut self, store: &mut impl Store) -> Result<(), Error> {
        if self.memory.save(store) { Ok(()) } else { Err(Error::Store) }
    }

    /// Work offsets and reference points as they are kept.
    pub(super) fn load_offsets(&mut self) {
        for (number, kept) in self.memory.work.iter().enumerate() {
            self.reader.set_work(number, &place_of(kept));
        }
        for (number, kept) in self.memory.reference.iter().enumerate() {
            self.reader.set_reference(number, &place_of(kept));
        }
        self.show_offsets_now();
    }

    /// Keeps them, if a program has changed them.
    pub(super) fn keep_offsets(&mut self, store: &mut impl Store) {
        self.touched = false;
        let before = (self.memory.work, self.memory.reference);
        for (number, kept) in self.memory.work.iter_mut().enumerate() {
            *kept = own(&self.reader.work_offset(number).unwrap_or_default());
        }
        for (number, kept) in self.memory.reference.iter_mut().enumerate() {
            *kept = own(&self.reader.reference_point(number));
        }
        if before != (self.memory.work, self.memory.reference) && !self.memory.save(store) {
            self.outbox.line("[MSG:Offsets could not be kept]");
        }
    }

    fn begin_list(&mut self, list: List) {
        self.doing = Doing::Listing { list, line: 0 };
    }

    /// Writes a line of a list; behind the last, the answer.
    pub(super) fn list(&mut self, list: List, line: usize) {
        let more = match list {
            List::Settings => self.memory.settings.say(line, &mut self.outbox),
            List::Parameters => self.say_parameter(line),
            List::Startup => self.say_startup(line),
            List::Build => self.say_build(line),
        };
        if more {
            self.doing = Doing::Listing { list, line: line + 1 };
        } else {
            self.doing = Doing::Nothing;
            self.answer(Ok(()));
        }
    }

    fn say_startup(&mut self, line: usize) -> bool {
        let Some(text) = self.memory.startup.get(line) else { return false };
        self.outbox.text("$N").whole(line as u32).byte(b'=').bytes(text).end();
        true
    }

    fn say_build(&mut self, line: usize) -> bool {
        let blocks = self.blocks();
        let out = &mut self.outbox;
        match line {
            0 => out.text("[VER:1.1h.20190825:").bytes(&self.memory.info).line("]"),
            1 => {
                out.text(if cfg!(feature = "home") { "[OPT:VMH," } else { "[OPT:VM," });
                out.whole(blocks).byte(b',').whole(RECEIVE as u32).line("]");
            }
            2 if N > 3 => {
                out.text("[AXS:").whole(N as u32).byte(b':');
                for letter in LETTERS.iter().take(N) {
                    out.byte(*letter as u8);
                }
                out.line("]");
            }
            2 | 3 if line == 2 + usize::from(N > 3) => {
                out.line(concat!("[FIRMWARE:splineway ", env!("CARGO_PKG_VERSION"), "]"));
            }
            _ => return false,
        }
        true
    }

    /// Where the last probe ended, and whether it had contact.
    pub(super) fn say_probed(&mut self) {
        let inches = self.memory.settings.inches();
        let (place, found) = &self.probed;
        self.outbox.text("[PRB:");
        say_place(&mut self.outbox, place, inches);
        self.outbox.byte(b':').whole(u32::from(*found)).line("]");
    }

    fn say_parameter(&mut self, line: usize) -> bool {
        let inches = self.memory.settings.inches();
        let (reader, out) = (&self.reader, &mut self.outbox);
        let mut place = |name: &str, place: &[Coord; N]| {
            out.byte(b'[').text(name).byte(b':');
            say_place(out, place, inches);
            out.line("]");
        };
        let names = ["G54", "G55", "G56", "G57", "G58", "G59"];
        match line {
            0..WORKS => {
                let name = names.get(line).copied().unwrap_or_default();
                place(name, &own(&reader.work_offset(line).unwrap_or_default()));
            }
            6 | 7 => {
                let name = if line == 6 { "G28" } else { "G30" };
                place(name, &own(&reader.reference_point(line - 6)));
            }
            8 => place("G92", &own(&reader.shift_in_force())),
            9 => {
                let length = reader.tool_length();
                out.text("[TLO:").coordinate(length, inches).line("]");
            }
            10 => self.say_probed(),
            _ => return false,
        }
        true
    }
}

/// Whether a point lies inside the limits of travel.
fn is_inside<const N: usize>(travel: &[AxisTravel; N], to: &[Coord; N]) -> bool {
    travel.iter().zip(to).all(|(travel, at)| {
        travel.least.is_none_or(|least| *at >= least)
            && travel.greatest.is_none_or(|greatest| *at <= greatest)
    })
}
