//! From places in the program to places on the path, as soon as the path is cut there.

use super::leads::{LEAD, Timed, is_before, not_before};
use super::{Planner, Switches, Written};
use crate::number::{ArcLength, Scalar};
use crate::path::builder::meter::Milestone;
use crate::servo::switching::{EntrySerial, Item, Line, Passing, moved};

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// A cell has been cut, from a place in the window on; `stands`: it is a standstill.
    pub(in crate::planner) fn note_cut(&mut self, stands: bool, begin: ArcLength) {
        let Some(last) = self.horizon.window.last() else { return };
        let length = last.arc_length.raw().wrapping_sub(begin.raw());
        let switches = &mut self.switches;
        switches.from = switches.to;
        let end = moved(switches.to.1, length);
        switches.to = (self.builder.meter().cut().length, end);
        if stands {
            switches.floor = end;
        }
        self.place_switches();
    }

    /// Gives a place on the path to all entries whose end of a block has been cut.
    pub(in crate::planner) fn place_switches(&mut self) {
        let cut = self.builder.meter().cut();
        let board = self.side.board;
        let mut count = 0;
        for (i, queue) in board.lines.iter().enumerate() {
            // At most all of the queue.
            while let Some(written) = self.switches.lines.get(i).copied()
                && let Some(item) = due(queue, written, cut)
            {
                self.place_one(i, written.ready, item);
                if let Some(written) = self.switches.lines.get_mut(i) {
                    written.ready = written.ready.next();
                    queue.set_ready(written.ready);
                }
                count += 1;
            }
        }
        while let Some(item) = due(&board.powers, self.switches.powers, cut) {
            let written = &mut self.switches.powers;
            let serial = written.ready;
            written.ready = serial.next();
            if item.passing != Passing::Event {
                let place = self.switches.place(item.place, |x| self.builder.share_before(x));
                (0..2).for_each(|plan| board.powers.set_place(serial, plan, place));
            }
            board.powers.set_ready(serial.next());
            count += 1;
        }
        if count > 0 {
            board.add_placed(count);
        }
    }

    /// Gives a place to one entry of an output.
    pub(in crate::planner) fn place_one(
        &mut self,
        line: usize,
        serial: EntrySerial,
        item: Item<S, 1>,
    ) {
        let Some(queue) = self.side.board.lines.get(line) else { return };
        if item.passing == Passing::Event {
            return;
        }
        let end = self.switches.place(item.place, |x| self.builder.share_before(x));
        let floor = self.switches.floor;
        let (mut placed, mut place) = (Item { wait: 0, part: S::ZERO, ..item }, end);
        if item.wait == LEAD {
            if is_before(floor, end) {
                placed.passing = Passing::Arriving;
                let timed = Timed { line, serial, place: end, floor, lead: item.part };
                let kept = self.switches.timed.push(timed);
                debug_assert!(kept.is_ok(), "no room for a lead that was taken");
            }
        } else if item.wait > 0 {
            (placed.wait, placed.part) = (item.wait - 1, item.part);
        } else {
            place = end.plus(item.part);
            if item.part < S::ZERO {
                place = not_before(floor, place, end);
                if is_before(floor, end) {
                    placed.passing = Passing::Arriving;
                }
            }
        }
        queue.write(serial, &Item { place: place.raw(), ..placed });
        // The plans that the motion may be on already.
        if let Some(timed) = self.switches.timed.last().copied()
            && (timed.line, timed.serial) == (line, serial)
        {
            let (active, spare) = self.side.buffers();
            self.set_led(&timed, (active, self.side.agreed()), None, timed.place);
            if self.phase.offer().is_some() {
                let offered = (spare, self.side.offered());
                let before = queue.place(serial, active);
                self.set_led(&timed, offered, self.switches.branch, before);
            }
        }
    }

    /// What was to switch where the programmed path has gone no further than `end` after all, does so there.
    pub(in crate::planner) fn draw_back(&self, end: Milestone) {
        let board = self.side.board;
        for (queue, written) in board.lines.iter().zip(&self.switches.lines) {
            put(queue, *written, end, |item| end.is_before(item.milestone()));
        }
        put(&board.powers, self.switches.powers, end, |item| end.is_before(item.milestone()));
    }

    /// Where the machine rests behind all that was pushed, what was to switch at the end of a standstill, as soon as the motion leaves
    /// it or there is no more, does so.
    pub(in crate::planner) fn end_standstills(&mut self) {
        if !(self.switches.rests && self.is_empty() && self.has_settled()) {
            return;
        }
        self.switches.rests = false;
        for (queue, written) in self.side.board.lines.iter().zip(&self.switches.lines) {
            queue.end_standstills(written.ready);
        }
    }

    /// A standstill has been pushed, from a place to another: what was to switch before the next motion begins is not before this.
    pub(in crate::planner) fn put_behind(&self, from: Milestone, to: Milestone) {
        for (queue, written) in self.side.board.lines.iter().zip(&self.switches.lines) {
            put(queue, *written, to, |item| {
                item.milestone() == from
                    && item.passing == Passing::Leaving
                    && (item.wait == LEAD || item.part < S::ZERO)
            });
        }
    }

    /// Everything that has not been run is dropped: nothing of it switches, and the power is off.
    pub(in crate::planner) fn drop_switches(&mut self) {
        let board = self.side.board;
        let mut count = 0;
        for (queue, written) in board.lines.iter().zip(&mut self.switches.lines) {
            count += written.waiting();
            written.ready = written.next;
            queue.set_void(written.next);
        }
        let written = &mut self.switches.powers;
        count += written.waiting();
        written.ready = written.next;
        board.powers.set_void(written.next);
        board.add_placed(count);
        board.reset();
        let here = self.horizon.window.last().map_or(ArcLength::ZERO, |last| last.arc_length);
        let here = moved(here, board.shift(self.side.buffers().0).wrapping_neg());
        let cut = self.builder.meter().cut().length;
        let Switches { lines, powers, .. } = self.switches;
        self.switches = Switches {
            lines,
            powers,
            from: (cut, here),
            to: (cut, here),
            floor: here,
            events: board.events(),
            ..Switches::NONE
        };
    }
}

/// The next entry without a place, if its end of a block has been cut.
fn due<S: Scalar, const DEPTH: usize, const M: usize>(
    queue: &Line<S, DEPTH, M>,
    written: Written,
    cut: Milestone,
) -> Option<Item<S, M>> {
    if written.ready == written.next {
        return None;
    }
    let item = queue.read(written.ready)?;
    (item.passing == Passing::Event || !cut.is_before(item.milestone())).then_some(item)
}

/// Puts those of the entries without a place somewhere else that are to be there; one at an event stays with it.
fn put<S: Scalar, const DEPTH: usize, const M: usize>(
    queue: &Line<S, DEPTH, M>,
    written: Written,
    to: Milestone,
    is_meant: impl Fn(&Item<S, M>) -> bool,
) {
    for serial in written.unplaced() {
        if let Some(item) = queue.read(serial)
            && item.passing != Passing::Event
            && is_meant(&item)
        {
            queue.write(serial, &Item { place: to.length, order: to.stands, ..item });
        }
    }
}
