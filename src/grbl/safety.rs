//! What stops the machine, what holds it, and how it begins anew.

use super::accessories::Accessories;
use super::code::{Alarm, Error};
use super::realtime::Realtime;
use super::report::{Cadence, Inputs};
use super::station::{Abort, Doing, Lock, Station};
use crate::number::{Coord, Scalar};
use crate::planner::Planner;
use crate::servo::Controls;
use crate::servo::events::Events;

impl<S: Scalar, const N: usize> Station<S, N> {
    pub(super) fn obey(&mut self, command: Realtime, controls: Controls<'_>) {
        match command {
            Realtime::Start => {
                if !self.inputs.door {
                    (self.held, self.door) = (false, false);
                    controls.resume();
                }
            }
            Realtime::Hold if self.jogging => {
                controls.cancel_jog();
                // What came before it and has not been read must not move on.
                self.cancelled = self.inbox.waiting();
                self.barred = self.cancelled;
            }
            Realtime::Hold => {
                self.held = true;
                controls.hold();
            }
            Realtime::Door => self.hold_for_door(controls),
            Realtime::CancelJog => {
                // Probes and homing are none.
                if !self.waits_for_input() {
                    controls.cancel_jog();
                }
                self.cancelled = self.inbox.waiting();
            }
            Realtime::Feed(change) => {
                let [feed, ..] = &mut self.overrides;
                *feed = change.of(*feed);
                controls.feed_override(*feed);
            }
            Realtime::Rapid(percent) => {
                let [_, rapid, _] = &mut self.overrides;
                *rapid = percent;
                controls.rapid_override(percent);
            }
            Realtime::Spindle(change) => {
                let [.., spindle] = &mut self.overrides;
                *spindle = change.of(*spindle);
            }
            // As in grbl only while held: the tool must not stand in moving material.
            Realtime::SpindleStop => self.stopped = self.held && self.rests && !self.stopped,
            Realtime::Flood => {
                self.actual.flood = !self.actual.flood;
                self.programmed.flood = self.actual.flood;
            }
            Realtime::Mist => {
                self.actual.mist = !self.actual.mist;
                self.programmed.mist = self.actual.mist;
            }
            Realtime::Status | Realtime::Reset | Realtime::Other => return,
        }
        self.stopped &= self.held;
        self.cadence.tell_overrides();
    }

    /// Brakes and stays held until the door is closed and a start is asked for.
    fn hold_for_door(&mut self, controls: Controls<'_>) {
        if self.homes() {
            self.alarm(Alarm::HomingDoor, controls);
            return;
        }
        self.door = true;
        controls.hold();
    }

    /// Brakes within the limits, and drops everything.
    pub(super) fn reset(&mut self, controls: Controls<'_>) {
        if self.abort != Some(Abort::Reset) {
            self.cut = self.state().moves();
        }
        controls.abort();
        if self.homes() && self.lock == Lock::Open {
            (self.lock, self.unsaid) = (Lock::Alarm, Some(Alarm::HomingReset));
        }
        self.inbox.clear();
        (self.doing, self.startup) = (Doing::Nothing, None);
        (self.cancelled, self.barred) = (0, 0);
        self.checked |= self.check;
        (self.status, self.check) = (false, false);
        self.abort = Some(Abort::Reset);
        if self.lock == Lock::Sleep {
            self.lock = Lock::Alarm;
        }
    }

    /// The end of check mode: a reset, behind what waits to be said.
    pub(super) fn leave_check(&mut self, controls: Controls<'_>) {
        controls.abort();
        (self.check, self.checked) = (false, true);
        self.abort = Some(Abort::Reset);
    }

    /// Whether everything is being dropped.
    pub(super) const fn abort_is_on(&self) -> bool {
        self.abort.is_some()
    }

    pub(super) const fn is_door_open(&self) -> bool {
        self.inputs.door
    }

    /// Whether the reason of an alarm lasts.
    pub(super) const fn must_stop(&self) -> bool {
        self.inputs.stop
    }

    /// Blocks that the planner has room for when it is empty.
    pub(super) const fn blocks(&self) -> u32 {
        self.blocks
    }

    /// Locks the machine, says why, and drops what was to be run: it brakes within its limits.
    pub(super) fn alarm(&mut self, alarm: Alarm, controls: Controls<'_>) {
        if self.abort.is_none() {
            controls.abort();
        }
        if matches!(self.abort, None | Some(Abort::Probe)) {
            let probes = matches!(alarm, Alarm::ProbeInitial | Alarm::ProbeContact);
            self.abort = Some(if probes { Abort::Probe } else { Abort::Alarm });
        }
        self.lock = Lock::Alarm;
        self.startup = None;
        self.unsaid = Some(alarm);
        self.say_alarm();
    }

    /// Says why the machine is locked, as soon as there is room.
    pub(super) fn say_alarm(&mut self) {
        if let Some(alarm) = self.unsaid
            && self.outbox.has_room()
        {
            self.unsaid = None;
            self.outbox.text("ALARM:").whole(alarm as u32).end();
            // The banner has it too.
            if self.abort != Some(Abort::Reset) {
                self.outbox.line("[MSG:'$H'|'$X' to unlock]");
            }
        }
    }

    /// Switches, and aborts that come from elsewhere.
    pub(super) fn watch<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &Planner<'_, S, N, BLOCKS, NODES>,
        inputs: Inputs,
    ) {
        let before = core::mem::replace(&mut self.inputs, inputs);
        // Homing runs into them.
        let hard = self.memory.settings.hard_limits() && !self.homes();
        let hit = hard && inputs.limits & !before.limits != 0;
        let stop = inputs.stop && !before.stop;
        let foreign = planner.is_aborted() && self.abort.is_none();
        if inputs.door && !before.door && self.lock == Lock::Open {
            // A jog ends with it.
            self.hold_for_door(planner.controls());
        }
        if !self.outbox.has_room() {
            // Nobody reads: the motion is stopped all the same, and the word is said when somebody does.
            if (hit || stop) && !planner.is_aborted() {
                planner.controls().abort();
            }
            self.inputs = Inputs { door: inputs.door, ..before };
            return;
        }
        if hit && self.lock == Lock::Open {
            self.alarm(Alarm::HardLimit, planner.controls());
        } else if stop || foreign {
            self.alarm(Alarm::Abort, planner.controls());
        }
    }

    /// Where an abort is complete: everything is as after power-up, where the machine stands; behind a probe the reader is as before.
    pub(super) fn complete_abort<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
    ) {
        let Some(abort) = self.abort else { return };
        if !self.outbox.has_room() || !planner.acknowledge_abort() || planner.is_aborted() {
            return;
        }
        self.abort = None;
        self.say_alarm();
        events.clear();
        self.events.clear();
        (self.happened, self.seen) = (0, events.happened());
        (self.programmed, self.actual) = (Accessories::OFF, Accessories::OFF);
        (self.held, self.door, self.stopped) = (false, false, false);
        // A hold that was asked for while it braked.
        planner.controls().resume();
        match abort {
            Abort::Reset | Abort::Alarm => self.reader.restart(),
            Abort::Probe => self.reader.drop_moves(),
        }
        self.reader.stand_at(planner.end());
        self.show_offsets_now();
        let line = core::mem::replace(&mut self.doing, Doing::Nothing);
        // What is locked is not unlocked while the door is open.
        if self.inputs.door && self.lock == Lock::Open {
            self.hold_for_door(planner.controls());
        }
        if core::mem::take(&mut self.checked) {
            // What is only checked moves no zero either.
            self.load_offsets();
        }
        if abort == Abort::Reset {
            // A sender may have had lines under way when it was asked for: they belong to what has been dropped.
            self.barred = self.inbox.waiting();
            self.overrides = [100; 3];
            self.probed = ([Coord::ZERO; N], false);
            planner.controls().feed_override(100);
            planner.controls().rapid_override(100);
            self.cadence = Cadence::default();
            self.greet();
        } else if !matches!(line, Doing::Nothing) {
            self.answer(Err(Error::Locked));
        }
    }
}
