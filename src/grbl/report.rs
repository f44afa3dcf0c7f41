//! Reports: what the machine does, its parameters, the modes.

use super::accessories::Accessories;
use super::outbox::{INCH, Outbox};
use crate::gcode::{Code, LETTERS, Modes};
use crate::number::{Coord, Scalar};
use crate::servo::{Activity, Setpoint};

/// What the machine is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// At rest with nothing to run.
    Idle,
    /// A program runs.
    Run,
    /// Held; whether it is at rest.
    Hold {
        /// Whether it is at rest.
        rests: bool,
    },
    /// A jog.
    Jog,
    /// Axes are being homed.
    Home,
    /// Held by the door, or its command; whether it is at rest, and the door open.
    Door {
        /// Whether it is at rest.
        rests: bool,
        /// Whether the door is open.
        open: bool,
    },
    /// Locked.
    Alarm,
    /// Lines are checked and nothing is done.
    Check,
    /// Asleep until a reset.
    Sleep,
}

impl State {
    /// Its name, as reports have it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "Idle",
            Self::Run => "Run",
            Self::Hold { rests: true } => "Hold:0",
            Self::Hold { rests: false } => "Hold:1",
            Self::Jog => "Jog",
            Self::Home => "Home",
            Self::Door { rests: true, open: false } => "Door:0",
            Self::Door { rests: true, open: true } => "Door:1",
            Self::Door { rests: false, .. } => "Door:2",
            Self::Alarm => "Alarm",
            Self::Check => "Check",
            Self::Sleep => "Sleep",
        }
    }

    /// Whether something is being done, or braked: what grbl locks the machine for if it is reset.
    pub(super) const fn moves(self) -> bool {
        matches!(
            self,
            Self::Run
                | Self::Jog
                | Self::Home
                | Self::Hold { rests: false }
                | Self::Door { rests: false, .. }
        )
    }

    /// Whether reports of it come often, so that offsets and overrides are told less often.
    const fn is_busy(self) -> bool {
        matches!(self, Self::Run | Self::Hold { .. } | Self::Jog | Self::Home | Self::Door { .. })
    }
}

/// Switches that the controller reads, as reports tell them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Inputs {
    /// Limit switches, a bit per axis.
    pub limits: u16,
    /// The probe has contact.
    pub probe: bool,
    /// The door is open.
    pub door: bool,
    /// The emergency stop, or anything else that must stop the machine and keep it locked as long as it lasts.
    pub stop: bool,
}

impl Inputs {
    fn say(self, out: &mut Outbox) {
        if self == Self::default() {
            return;
        }
        out.text("|Pn:");
        if self.probe {
            out.byte(b'P');
        }
        for (axis, letter) in LETTERS.iter().enumerate() {
            if self.limits >> axis & 1 == 1 {
                out.byte(*letter as u8);
            }
        }
        if self.door {
            out.byte(b'D');
        }
        if self.stop {
            out.byte(b'R');
        }
    }
}

/// After how many reports offsets and overrides are told again: at rest, and else.
const OFFSETS: [u8; 2] = [10, 30];
const OVERRIDES: [u8; 2] = [10, 20];

/// What is told now and then.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cadence {
    offsets: u8,
    overrides: u8,
}

impl Cadence {
    /// Offsets have changed.
    pub fn tell_offsets(&mut self) {
        self.offsets = 0;
    }

    /// An override has changed.
    pub fn tell_overrides(&mut self) {
        self.overrides = 0;
    }

    /// Whether offsets are told in this report, and whether overrides are: never both.
    fn step(&mut self, state: State) -> [bool; 2] {
        let busy = usize::from(state.is_busy());
        let every = |list: [u8; 2]| list.get(busy).copied().unwrap_or(10);
        let offsets = self.offsets == 0;
        self.offsets = if offsets { every(OFFSETS) } else { self.offsets } - 1;
        let overrides = !offsets && self.overrides == 0;
        if overrides {
            self.overrides = every(OVERRIDES);
        }
        self.overrides = self.overrides.saturating_sub(1);
        [offsets, overrides]
    }
}

/// What a report tells.
#[derive(Clone, Copy, Debug)]
pub struct Status<'a, const N: usize> {
    pub state: State,
    /// Whether it tells the machine's position, and not that in the work's coordinates.
    pub machine: bool,
    pub inches: bool,
    /// Blocks and bytes for which there is room.
    pub room: Option<[u32; 2]>,
    pub inputs: Inputs,
    /// What is added to the work's coordinates.
    pub offsets: &'a [Coord; N],
    /// Of feeds, rapids and the spindle, per cent.
    pub overrides: [u16; 3],
    pub accessories: Accessories,
    /// Speed of the spindle, 1/min, or power of a laser.
    pub turns: f32,
}

impl<const N: usize> Status<'_, N> {
    /// The report of a setpoint.
    pub fn say<S: Scalar>(&self, at: &Setpoint<S, N>, cadence: &mut Cadence, out: &mut Outbox) {
        out.byte(b'<').text(self.state.name());
        out.text(if self.machine { "|MPos:" } else { "|WPos:" });
        for (axis, offset) in self.offsets.iter().enumerate() {
            let place = at.position(axis).raw();
            let place = if self.machine { place } else { place.saturating_sub(offset.raw()) };
            say_axis(out, (axis, Coord::from_raw(place)), self.inches);
        }
        if let Some([blocks, bytes]) = self.room {
            out.text("|Bf:").whole(blocks).byte(b',').whole(bytes);
        }
        let scale = if self.inches { INCH } else { 1.0 };
        let feed = speed(at) * 60.0 / scale;
        out.text("|FS:").number(feed, usize::from(self.inches));
        out.byte(b',').number(f64::from(self.turns), 0);
        self.inputs.say(out);
        let [offsets, overrides] = cadence.step(self.state);
        if offsets {
            out.text("|WCO:");
            say_place(out, self.offsets, self.inches);
        }
        if overrides {
            let [feed, rapid, spindle] = self.overrides.map(u32::from);
            out.text("|Ov:").whole(feed).byte(b',').whole(rapid).byte(b',').whole(spindle);
            if self.accessories.any() {
                out.text("|A:");
                self.accessories.say(out);
            }
        }
        out.line(">");
    }
}

/// Speed of the tool, mm/s.
fn speed<S: Scalar, const N: usize>(at: &Setpoint<S, N>) -> f64 {
    if at.activity != Activity::Jogging {
        return at.path_speed.to_f64();
    }
    let sum = at.velocity.iter().fold(0.0, |sum, v| sum + v.to_f64() * v.to_f64());
    libm::sqrt(sum)
}

fn say_axis(out: &mut Outbox, (axis, place): (usize, Coord), inches: bool) {
    if axis > 0 {
        out.byte(b',');
    }
    out.coordinate(place, inches && !matches!(axis, 3..=5));
}

/// Numbers of all axes.
pub fn say_place<const N: usize>(out: &mut Outbox, place: &[Coord; N], inches: bool) {
    for (axis, coord) in place.iter().enumerate() {
        say_axis(out, (axis, *coord), inches);
    }
}

/// A code as a program has it.
pub fn say_code(out: &mut Outbox, code: Code) {
    out.byte(code.letter as u8).whole(u32::from(code.tenths / 10));
    if !code.tenths.is_multiple_of(10) {
        out.byte(b'.').whole(u32::from(code.tenths % 10));
    }
}

/// The modes in force (`$G`).
pub fn say_modes(out: &mut Outbox, modes: &Modes, programmed: Accessories, inches: bool) {
    out.text("[GC:");
    for (i, code) in modes.codes.into_iter().enumerate() {
        if i > 0 {
            out.byte(b' ');
        }
        say_code(out, code);
    }
    programmed.say_codes(out);
    let scale = if inches { INCH } else { 1.0 };
    out.text(" T").whole(modes.tool);
    out.text(" F").number(modes.feed / scale, usize::from(inches));
    out.text(" S").number(modes.spindle, 0).line("]");
}
