//! Outputs in time with the path (feature `outputs`): M62 to M65, M67 and M68 as LinuxCNC has them, a laser's power by S, M3, M4 and M5
//! as grbl's laser mode has it, and coolant with a lead.

use super::error::{Reason, Refusal};
use super::groups::{Codes, Found};
use super::modal::Mode;
use super::reader::Reader;
use super::words::Words;
use super::{Code, dialect::Use};
use crate::block::{Offset, Power, Switch, Trigger};
use crate::machine::{ANALOGUE, DIGITAL};

/// A laser instead of a spindle, as in grbl's laser mode: S is its power, M3 the same at every speed, M4 in proportion to it, M5
/// off; none of them stops the motion. In rapids it is off.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Laser {
    /// Least power of M4 in motion, in units of S.
    pub least: f64,
    /// Greatest power, in units of S: more counts as this.
    pub most: f64,
}

/// Coolant in time with the path.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Coolant {
    /// Digital output of M7.
    pub mist: u8,
    /// Digital output of M8.
    pub flood: u8,
    /// How long before the motion behind M7 or M8 it is switched on: a distance or a time, negative. It is off where the motion before
    /// M9 ends.
    pub lead: Offset<f64>,
}

impl Reader {
    /// M62 to M68. Returns whether they are switches here.
    pub(super) fn switch(
        &mut self,
        (code, column): Found,
        words: &mut Words,
    ) -> Result<bool, Refusal> {
        let number = code.tenths / 10;
        if !self.settings.switches {
            if number >= 67 {
                let what = "an analogue output";
                let reason = Reason::Unsupported { code, what, harmless: false };
                return Err(Refusal::new(column, reason));
            }
            return Ok(false);
        }
        let missing = |what| Refusal::new(column, Reason::Missing { code, what });
        let switch = if number >= 67 {
            let e = words.take_in('E', code, (0.0, (ANALOGUE - 1) as f64), true)?;
            let e = e.ok_or(missing("an E word, the number of the output"))?;
            let q = words.take_in('Q', code, (-1.0e9, 1.0e9), false)?;
            Switch::analogue(e as u8, q.ok_or(missing("a Q word, its value"))?)
        } else {
            let p = words.take_in('P', code, (0.0, (DIGITAL - 1) as f64), true)?;
            let p = p.ok_or(missing("a P word, the number of the output"))?;
            Switch::digital(p as u8, matches!(number, 62 | 64))
        };
        let at_once = matches!(number, 64 | 65 | 68);
        let trigger = if at_once { Trigger::Rest } else { Trigger::Start };
        self.push_switch(Switch { tag: self.line, ..switch.at(trigger) }, column)?;
        Ok(true)
    }

    /// S, M3, M4 and M5 of a laser. Returns whether there is one.
    pub(super) fn power(&mut self, codes: &Codes, words: &mut Words) -> Result<bool, Refusal> {
        if self.settings.laser.is_none() {
            return Ok(false);
        }
        let before = self.laser_power();
        let mut column = words.column('S');
        if let Some(power) = words.take_in('S', Code::SPEED, (0.0, 1.0e6), false)? {
            self.spindle = Some(power);
        }
        if let Some((code, place)) = codes.m(Use::Spindle) {
            if code.tenths == 190 {
                let what = "orientation of a spindle";
                let reason = Reason::Unsupported { code, what, harmless: false };
                return Err(Refusal::new(place, reason));
            }
            (self.beam, column) = (code.tenths / 10, place);
        }
        let power = self.laser_power();
        if power != before {
            self.push_power(power, false, column)?;
        }
        Ok(true)
    }

    /// Before a dwell: where M3 is in force and the last move was a rapid, the laser pierces.
    pub(super) fn pierce(&mut self, column: u32) -> Result<(), Refusal> {
        let power = self.laser_power();
        let cuts = !matches!(self.modal.mode, Mode::None | Mode::Rapid);
        if power.level > 0.0 && !power.dynamic && cuts && self.was_rapid {
            self.was_rapid = false;
            self.push_power(power, true, column)?;
        }
        Ok(())
    }

    /// The power in force.
    fn laser_power(&self) -> Power<f64> {
        let (Some(laser), Some(level)) = (self.settings.laser, self.spindle) else {
            return Power::OFF;
        };
        let level = level.min(laser.most);
        match self.beam {
            3 => Power::constant(level),
            4 => Power::in_proportion(level, laser.least.min(level), laser.most),
            _ => Power::OFF,
        }
    }

    /// M7, M8 or M9. Returns whether coolant goes with the path.
    pub(super) fn coolant(&mut self, (code, column): Found) -> Result<bool, Refusal> {
        let Some(Coolant { mist, flood, lead }) = self.settings.coolant else { return Ok(false) };
        match code.tenths {
            70 | 80 => {
                let output = if code.tenths == 70 { mist } else { flood };
                let on = Switch { offset: lead, ..Switch::digital(output, true) };
                self.push_switch(on, column)?;
            }
            _ => {
                for output in [mist, flood] {
                    self.push_switch(Switch::digital(output, false).at(Trigger::End), column)?;
                }
            }
        }
        Ok(true)
    }
}
