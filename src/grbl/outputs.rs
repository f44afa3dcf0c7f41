//! Outputs in time with the path: M62 to M68, and a laser (feature `outputs`).

use super::accessories::Spindle;
use super::station::{Station, Timed};
use crate::block::{Power, PushError, SwitchError, Trigger};
use crate::gcode::Laser;
use crate::number::Scalar;
use crate::planner::Planner;
use crate::servo::events::{Event, Events};

/// Letter of an event of which the interrupt knows all: an output that switches there.
pub const IN_TIME: u8 = 0;

impl<S: Scalar, const N: usize> Station<S, N> {
    /// Hands over a switch or a power.
    pub(super) fn push_timed<const BLOCKS: usize, const NODES: usize, const M: usize>(
        &mut self,
        timed: &Timed<S>,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        events: &Events<M>,
    ) -> Result<(), PushError> {
        let stands = match timed {
            Timed::Switch(switch) => switch.trigger == Trigger::Rest,
            Timed::Power { rest, .. } => *rest,
        };
        if stands && (!events.has_room() || self.events.is_full()) {
            return Err(PushError::Full);
        }
        let pushed = match timed {
            Timed::Switch(switch) => planner.push_switch(switch),
            Timed::Power { power, rest: true } => planner.push_power(power, self.tag),
            Timed::Power { power, rest: false } => planner.set_power(power),
        };
        match pushed {
            Ok(()) => {}
            Err(SwitchError::Full) => return Err(PushError::Full),
            Err(SwitchError::Aborted) => return Err(PushError::Aborted),
            // The reader has seen to it that there are such outputs and values.
            Err(_) => debug_assert!(false, "{timed:?}"),
        }
        if stands {
            // What happens at rest is counted with the events of the program.
            let event =
                Event { tag: self.tag, letter: IN_TIME, tenths: 0, value: None, pause: false };
            events.put(&event);
            // There is room: it has been asked for.
            let _ = self.events.push_back(event);
        }
        Ok(())
    }

    /// The laser of the settings is in force. Where it is another than before, it is off, and so is the spindle.
    pub(super) fn apply_laser<const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        let settings = &self.memory.settings;
        let (least, most) = settings.spindle();
        let laser = Laser { least: f64::from(least), most: f64::from(most) };
        let laser = settings.laser().then_some(laser);
        if laser != self.laser {
            self.laser = laser;
            self.reader.set_laser(laser);
            (self.programmed.spindle, self.actual.spindle) = (Spindle::Off, Spindle::Off);
            Self::power_off(planner);
        }
    }

    /// No power for the blocks to come.
    pub(super) fn power_off<const BLOCKS: usize, const NODES: usize>(
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    ) {
        let set = planner.set_power(&Power::OFF);
        debug_assert!(set.is_ok(), "a power that is always good");
    }

    /// What the lines that have been read say of the laser; `None` without one.
    pub(super) fn beam(&self) -> Option<Spindle> {
        self.reader.beam().map(|code| match code.tenths {
            30 => Spindle::Clockwise,
            40 => Spindle::CounterClockwise,
            _ => Spindle::Off,
        })
    }
}
