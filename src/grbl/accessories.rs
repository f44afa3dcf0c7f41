//! Spindle and coolant.

use super::outbox::Outbox;
use crate::servo::events::Event;

/// What the spindle does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Spindle {
    /// It stands.
    #[default]
    Off,
    /// It turns clockwise (M3).
    Clockwise,
    /// It turns the other way (M4).
    CounterClockwise,
}

/// What the machine switches besides its axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Accessories {
    /// The spindle.
    pub spindle: Spindle,
    /// Its speed, 1/min.
    pub speed: f32,
    /// Flood coolant (M8).
    pub flood: bool,
    /// Mist coolant (M7).
    pub mist: bool,
    /// Of the power of [`Interpolator::switch`](crate::Interpolator) (feature `outputs`), the laser gets so many per cent: the override of the
    /// spindle in laser mode (`$32`), else 0.
    pub laser: u16,
}

impl Accessories {
    /// With everything off.
    pub const OFF: Self =
        Self { spindle: Spindle::Off, speed: 0.0, flood: false, mist: false, laser: 0 };

    /// Goes on from an event of a program. Whether it is one of these.
    pub(super) fn apply(&mut self, event: &Event) -> bool {
        match (event.letter, event.tenths) {
            (b'S', _) => self.speed = event.value.unwrap_or(0.0),
            (b'M', 30 | 40) => {
                let clockwise = event.tenths == 30;
                self.spindle =
                    if clockwise { Spindle::Clockwise } else { Spindle::CounterClockwise };
                self.speed = event.value.unwrap_or(self.speed);
            }
            (b'M', 50) => self.spindle = Spindle::Off,
            (b'M', 70) => self.mist = true,
            (b'M', 80) => self.flood = true,
            (b'M', 90) => (self.mist, self.flood) = (false, false),
            _ => return false,
        }
        true
    }

    /// With the speed as it is at an override, per cent, within slowest and fastest; 0 where the spindle stands.
    pub(super) fn at(self, percent: u16, (slowest, fastest): (f32, f32)) -> Self {
        let asked = self.speed * f32::from(percent) * 0.01;
        let turns = self.spindle != Spindle::Off && self.speed > 0.0;
        let speed = if !turns {
            0.0
        } else if fastest > slowest {
            asked.max(slowest).min(fastest)
        } else {
            asked
        };
        Self { speed, ..self }
    }

    /// Whether any is on.
    pub(super) fn any(self) -> bool {
        self.spindle != Spindle::Off || self.flood || self.mist
    }

    /// Their letters in a report.
    pub(super) fn say(self, out: &mut Outbox) {
        match self.spindle {
            Spindle::Off => {}
            Spindle::Clockwise => _ = out.byte(b'S'),
            Spindle::CounterClockwise => _ = out.byte(b'C'),
        }
        if self.flood {
            out.byte(b'F');
        }
        if self.mist {
            out.byte(b'M');
        }
    }

    /// Their codes, each behind a blank.
    pub(super) fn say_codes(self, out: &mut Outbox) {
        out.text(match self.spindle {
            Spindle::Off => " M5",
            Spindle::Clockwise => " M3",
            Spindle::CounterClockwise => " M4",
        });
        out.text(match (self.mist, self.flood) {
            (false, false) => " M9",
            (true, false) => " M7",
            (false, true) => " M8",
            (true, true) => " M7 M8",
        });
    }
}
