//! The background's side of outputs in time with the path (feature `outputs`): from places in the program to places on the
//! path, as soon as the path is cut there, and to earlier ones by a time, as soon as a plan gets there.

mod leads;
mod placing;

use super::Planner;
use crate::block::{Block, Motion, Offset, Output, Power, Switch, SwitchError, Trigger};
use crate::machine::DIGITAL;
use crate::number::{ArcLength, Scalar};
use crate::path::builder::meter::Milestone;
use crate::servo::link::Branch;
use crate::servo::switching::{EntrySerial, Item, LINES, MOST_WAIT, Passing};
use leads::{LEAD, TIMED, Timed};

/// How far a queue is written, and how far its places are known.
#[derive(Clone, Copy, Debug)]
struct Written {
    next: EntrySerial,
    ready: EntrySerial,
}

impl Written {
    const NONE: Self = Self { next: EntrySerial::ZERO, ready: EntrySerial::ZERO };

    /// How many entries have no place yet.
    fn waiting(self) -> u32 {
        self.next.since(self.ready).unwrap_or(0)
    }

    /// Those entries.
    fn unplaced(self) -> impl Iterator<Item = EntrySerial> {
        (0..self.waiting()).map(move |k| self.ready.plus(k))
    }
}

impl<S, const M: usize> Item<S, M> {
    /// Its place on the programmed path, as long as it has no other.
    fn milestone(&self) -> Milestone {
        Milestone { length: self.place, stands: self.order }
    }
}

/// What has been asked for.
#[derive(Clone, Debug)]
pub struct Switches<S> {
    lines: [Written; LINES],
    powers: Written,
    /// Beginning and end of the last cell that was cut, on the programmed path and on the path as it was cut first.
    from: (i64, ArcLength),
    to: (i64, ArcLength),
    /// End of the last standstill that was cut.
    floor: ArcLength,
    /// End of the last standstill that was pushed, and its tag.
    stand: Option<(Milestone, u32)>,
    /// Whether something is to switch at the end of one.
    rests: bool,
    timed: heapless::Vec<Timed<S>, TIMED>,
    /// Where the last plan that was offered branches off.
    branch: Option<Branch>,
    /// The power of the blocks to come, and what is asked for by those pushed so far.
    power: Power<S>,
    last: [S; 4],
    /// Events pushed so far.
    events: u32,
}

impl<S: Scalar> Switches<S> {
    /// Nothing.
    pub const NONE: Self = Self {
        lines: [Written::NONE; LINES],
        powers: Written::NONE,
        from: (0, ArcLength::ZERO),
        to: (0, ArcLength::ZERO),
        floor: ArcLength::ZERO,
        stand: None,
        rests: false,
        timed: heapless::Vec::new(),
        branch: None,
        power: Power::OFF,
        last: [S::ZERO; 4],
        events: 0,
    };

    /// Whether anything has ever been asked for: then the path stays where it was cut.
    #[cfg(feature = "reshape")]
    pub fn are_used(&self) -> bool {
        let written = self.lines.iter().chain([&self.powers]);
        self.power.level > S::ZERO || written.into_iter().any(|line| line.next != EntrySerial::ZERO)
    }

    /// Whether what was pushed last is a standstill, of which this is the end.
    fn stands_at(&self, here: Milestone) -> bool {
        self.stand.is_some_and(|(stand, _)| stand == here)
    }

    /// The place on the path of one on the programmed path within the last cell, or at its end.
    fn place(&self, length: i64, share_before: impl Fn(S) -> S) -> ArcLength {
        let (whole, part) = (self.to.0.wrapping_sub(self.from.0), length.wrapping_sub(self.from.0));
        if part >= whole {
            return self.to.1;
        }
        let mm = S::from_i64(self.to.1.raw().wrapping_sub(self.from.1.raw())) * S::of(1.0e-7);
        let share = S::from_i64(part) / S::from_i64(whole);
        self.from.1.plus(mm * share_before(share.greatest(S::ZERO)))
    }
}

/// What a power asks for at rest.
fn level_at_rest<S: Scalar>(power: &Power<S>) -> [S; 4] {
    let level = if power.dynamic { S::ZERO } else { power.level };
    [level, S::ZERO, S::ZERO, S::ZERO]
}

/// What a power asks for on a block of some feed, mm/s along the path; `None` of a rapid.
fn level<S: Scalar>(power: &Power<S>, feed: Option<S>) -> [S; 4] {
    let off = [S::ZERO; 4];
    let Some(feed) = feed.filter(|_| power.level > S::ZERO) else { return off };
    if !power.dynamic {
        return [power.level, S::ZERO, S::ZERO, S::ZERO];
    }
    let slope = power.level / feed;
    if slope > S::ZERO && slope.is_finite() {
        [power.level, slope, power.least, power.most]
    } else {
        off
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Has an output switch in time with the path (feature `outputs`), at or about the end of the block that was pushed
    /// last.
    ///
    /// Cost: bounded; for a time before a place, a pass over the plan.
    ///
    /// # Errors
    /// [`SwitchError`]; nothing has changed then. [`SwitchError::Full`]: poll, and push the same switch again.
    /// Of every output [`SWITCHES`](crate::SWITCHES) may wait, and eight in all that are a time before a place.
    pub fn push_switch(&mut self, switch: &Switch<S>) -> Result<(), SwitchError> {
        switch.check()?;
        if self.is_aborted() {
            return Err(SwitchError::Aborted);
        }
        let line = match switch.output {
            Output::Digital(number) => usize::from(number),
            Output::Analogue(number) => DIGITAL + usize::from(number),
            Output::Power => return Err(SwitchError::Output(switch.output)),
        };
        let (Some(queue), Some(written)) =
            (self.side.board.lines.get(line), self.switches.lines.get(line))
        else {
            return Err(SwitchError::Output(switch.output));
        };
        let is_lead = matches!(switch.offset, Offset::Time(seconds) if seconds < S::ZERO);
        let full = !queue.has_room(written.next)
            || (is_lead && !self.has_room_for_lead())
            || (switch.trigger == Trigger::Rest && !self.has_room_for_power());
        if full || !self.is_open() {
            return Err(SwitchError::Full);
        }
        let mut item = Item {
            passing: switch.trigger.into(),
            place: 0,
            order: 0,
            wait: 0,
            part: S::ZERO,
            values: [switch.value],
        };
        if switch.trigger == Trigger::Rest {
            item.order = self.push_rest(switch.tag)?;
        } else {
            self.set_milestone(&mut item, switch.offset);
        }
        let Some(written) = self.switches.lines.get_mut(line) else { return Ok(()) };
        queue.write(written.next, &item);
        written.next = written.next.next();
        self.place_switches();
        Ok(())
    }

    /// The power of the blocks that are pushed from now on (feature `outputs`): none at first, and after an abort. It
    /// changes where each of them starts.
    ///
    /// In a dwell or an event directly behind such a block a power that is the same at every speed stays on; what has been off is put on
    /// at rest by [`Planner::push_power`] only. Between two dwells it changes at an event of its own, with the tag of the first.
    ///
    /// # Errors
    /// [`SwitchError::Value`], [`SwitchError::Aborted`].
    pub fn set_power(&mut self, power: &Power<S>) -> Result<(), SwitchError> {
        power.check()?;
        if self.is_aborted() {
            return Err(SwitchError::Aborted);
        }
        self.switches.power = *power;
        Ok(())
    }

    /// The same, and at rest, behind all that was pushed, before all that will be: one that is the same at every speed is on
    /// in the dwells that follow. `tag` is that of the event.
    ///
    /// # Errors
    /// [`SwitchError`]; nothing has changed then.
    pub fn push_power(&mut self, power: &Power<S>, tag: u32) -> Result<(), SwitchError> {
        power.check()?;
        if self.is_aborted() {
            return Err(SwitchError::Aborted);
        }
        // One for the event, if a power has been taken back, and one at it.
        let last = self.switches.powers.next.next();
        if !self.side.board.powers.has_room(last) || !self.is_open() {
            return Err(SwitchError::Full);
        }
        let order = self.push_rest(tag)?;
        self.switches.power = *power;
        let values = level_at_rest(power);
        let passing = Passing::Event;
        self.write_power(&Item { passing, place: 0, order, wait: 0, part: S::ZERO, values });
        Ok(())
    }

    /// Whether something can be put behind what has been pushed: where that ends is known, and the path goes on from there.
    fn is_open(&self) -> bool {
        #[cfg(feature = "jog")]
        if self.jogging.is_free() {
            return false;
        }
        self.builder.knows_end()
    }

    /// An event at which something is to switch: its number.
    fn push_rest(&mut self, tag: u32) -> Result<u32, SwitchError> {
        let event = Block::event(tag);
        // An event has nothing that could be out of range.
        self.take(&event).map_err(|_| SwitchError::Full)?;
        Ok(self.switches.events)
    }

    /// Where, and how long before or behind it, an item is to be.
    fn set_milestone(&mut self, item: &mut Item<S, 1>, offset: Offset<S>) {
        let here = self.builder.meter().taken();
        (item.place, item.order) = (here.length, here.stands);
        if self.switches.stands_at(here) && item.passing == Passing::Arriving {
            // What is behind a standstill is not before it.
            item.passing = Passing::Ending;
            self.switches.rests = true;
        }
        match offset {
            Offset::Distance(mm) => item.part = mm,
            Offset::Time(seconds) if seconds < S::ZERO => {
                (item.wait, item.part) = (LEAD, -seconds);
            }
            Offset::Time(seconds) => {
                let cycles = seconds / self.horizon.config.cycle;
                let whole = cycles.to_i64().clamp(0, i64::from(MOST_WAIT / 2));
                // A part of a cycle, and at least one: else it would be taken for a distance.
                item.wait = whole as u32 + 1;
                item.part = cycles - S::from_i64(whole);
            }
        }
    }

    /// Whether a change of power could be taken, if the next block needs one.
    pub(super) fn has_room_for_power(&self) -> bool {
        let Switches { power, last, powers, .. } = &self.switches;
        let off = !(power.level > S::ZERO) && *last == [S::ZERO; 4];
        off || self.side.board.powers.has_room(powers.next)
    }

    /// A block has been taken.
    pub(super) fn note_taken(&mut self, block: &Block<S, N>) {
        let (mut from, taken) = (self.builder.meter().from(), self.builder.meter().taken());
        if from.stands == taken.stands && taken.is_before(from) {
            // The last line has become one with it that is shorter: a spike within the tolerance.
            self.draw_back(taken);
            from = taken;
        }
        if from.stands != taken.stands {
            self.put_behind(from, taken);
            let is_event = matches!(block.motion, Motion::Event { .. });
            self.switches.events = self.switches.events.wrapping_add(u32::from(is_event));
            self.change_power_at_rest(from, is_event);
            self.switches.stand = Some((taken, block.tag));
        } else if self.builder.meter().from() != taken {
            let values = level(&self.switches.power, self.builder.asked());
            if values != self.switches.last {
                let (place, order) = (from.length, from.stands);
                let passing = Passing::Leaving;
                self.write_power(&Item { passing, place, order, wait: 0, part: S::ZERO, values });
            }
        }
    }

    /// A standstill has been pushed, behind a place. The power changes when the motion arrives there; behind another standstill it is there already, and the
    /// power changes at an event.
    fn change_power_at_rest(&mut self, from: Milestone, is_event: bool) {
        let Some(values) = self.power_at_rest() else { return };
        let (passing, order) = if is_event && self.switches.stands_at(from) {
            (Passing::Event, self.switches.events)
        } else {
            (Passing::Arriving, from.stands)
        };
        let place = from.length;
        self.write_power(&Item { passing, place, order, wait: 0, part: S::ZERO, values });
    }

    /// What power is put on in a standstill that is pushed now, if that is another one. One that is the same at every speed may be on in it: not one
    /// that has been taken back since. What is off is put on at rest by [`Planner::push_power`] only.
    fn power_at_rest(&self) -> Option<[S; 4]> {
        let Switches { power, last, .. } = &self.switches;
        let ([full, slope, ..], values) = (*last, level_at_rest(power));
        (full > S::ZERO && slope == S::ZERO && values != *last).then_some(values)
    }

    /// The event between a dwell that is to be taken and another standstill before it, if the power changes between them.
    pub(super) fn power_between(&self, block: &Block<S, N>) -> Option<Block<S, N>> {
        let dwells = matches!(block.motion, Motion::Dwell { seconds } if seconds > S::ZERO && seconds.is_finite());
        let (_, tag) = self.switches.stand?;
        let behind = self.switches.stands_at(self.builder.meter().taken());
        (dwells && behind && self.power_at_rest().is_some()).then(|| Block::event(tag))
    }

    /// Adds a change of power, for which there is room.
    fn write_power(&mut self, item: &Item<S, 4>) {
        let written = &mut self.switches.powers;
        self.side.board.powers.write(written.next, item);
        written.next = written.next.next();
        self.switches.last = item.values;
        self.place_switches();
    }
}
