//! What the controller's end tells: bytes for the line, states, and what is to be switched.

use super::accessories::{Accessories, Spindle};
#[cfg(feature = "outputs")]
use super::outputs::IN_TIME;
use super::report::{State, Status};
use super::settings::Settings;
use super::station::{Abort, Lock, Station};
use crate::number::Scalar;
use crate::planner::Progress;
use crate::servo::events::Event;
use crate::servo::{Activity, Setpoint};

impl<S: Scalar, const N: usize> Station<S, N> {
    /// The power of a laser at the last setpoint, as reports tell it in laser mode (`$32`): what
    /// [`Interpolator::switch`](crate::Interpolator) gave, after the override (feature `outputs`).
    pub const fn set_power(&mut self, power: f32) {
        self.power = power;
    }

    /// The next byte to be sent; `None` if nothing is to be said. A report that has been asked for is of this setpoint.
    /// [`Station::sent`] goes on to the next.
    pub fn say(&mut self, setpoint: &Setpoint<S, N>) -> Option<u8> {
        self.rests = setpoint.activity == Activity::Idle;
        if let Some((tag, offsets)) = self.next_offsets
            && (self.empty || setpoint.tag.wrapping_sub(tag).cast_signed() >= 0)
        {
            (self.offsets, self.next_offsets) = (offsets, None);
            self.cadence.tell_offsets();
        }
        if self.status && self.outbox.has_room() {
            self.status = false;
            let (settings, accessories) = (&self.memory.settings, self.accessories());
            let turns = if settings.laser() { self.power } else { accessories.speed };
            let status = Status {
                state: self.state(),
                machine: settings.tells_machine(),
                inches: settings.inches(),
                room: settings.tells_room().then_some([self.room, self.inbox.room() as u32]),
                inputs: self.inputs,
                offsets: &self.offsets,
                overrides: self.overrides,
                accessories,
                turns,
            };
            status.say(setpoint, &mut self.cadence, &mut self.outbox);
        }
        self.outbox.peek()
    }

    /// The byte has been sent.
    pub fn sent(&mut self) {
        self.outbox.sent();
    }

    /// What the machine is doing, by the last [`Station::poll`] and the last setpoint.
    pub fn state(&self) -> State {
        let rests = self.rests;
        match self.lock {
            Lock::Sleep => return State::Sleep,
            Lock::Alarm => return State::Alarm,
            Lock::Open => {}
        }
        if self.check {
            State::Check
        } else if self.door {
            State::Door { rests: rests && !self.jogging, open: self.inputs.door }
        } else if self.jogging {
            State::Jog
        } else if self.held || self.progress == Progress::Held {
            State::Hold { rests }
        } else if self.homes() {
            State::Home
        } else if self.empty && rests && self.abort.is_none() {
            State::Idle
        } else {
            State::Run
        }
    }

    /// Spindle and coolant as they are to be now.
    pub fn accessories(&self) -> Accessories {
        let [.., percent] = self.overrides;
        let at = self.actual.at(percent, self.memory.settings.spindle());
        #[cfg(feature = "outputs")]
        let at = match self.beam() {
            Some(spindle) => Accessories { spindle, speed: 0.0, laser: percent, ..at },
            None => at,
        };
        match self.lock {
            _ if self.abort == Some(Abort::Reset) => Accessories::OFF,
            Lock::Open if self.stopped => {
                Accessories { spindle: Spindle::Off, speed: 0.0, laser: 0, ..at }
            }
            Lock::Open => at,
            Lock::Alarm | Lock::Sleep => Accessories::OFF,
        }
    }

    /// The next event of the program that has happened and is neither spindle nor coolant nor an output in time with the path: a tool. To be asked until there is
    /// none.
    pub fn event(&mut self) -> Option<Event> {
        while self.happened > 0
            && let Some(event) = self.events.pop_front()
        {
            self.happened -= 1;
            #[cfg(feature = "outputs")]
            if event.letter == IN_TIME {
                continue;
            }
            if !self.actual.apply(&event) {
                return Some(event);
            }
            self.cadence.tell_overrides();
        }
        None
    }

    /// The settings, if they have changed since this was asked.
    pub fn new_settings(&mut self) -> Option<&Settings<N>> {
        core::mem::take(&mut self.changed).then_some(&self.memory.settings)
    }

    /// The settings in force.
    pub const fn settings(&self) -> &Settings<N> {
        &self.memory.settings
    }
}
