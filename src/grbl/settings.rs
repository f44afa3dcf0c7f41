//! Settings by number.

use super::code::Error;
use super::outbox::Outbox;
#[cfg(feature = "home")]
use crate::jog::AxisHome;
use crate::machine::{AxisLimits, AxisTravel, Config, Limits, Quantity, Travel};
use crate::number::{Coord, Scalar};

/// Settings of one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisSettings {
    /// `$100` and so on: steps per mm (per degree).
    pub steps: f32,
    /// `$110`: greatest speed, mm/min.
    pub rate: f32,
    /// `$120`: greatest acceleration, mm/s2.
    pub acceleration: f32,
    /// `$130`: travel, mm: from there below zero to zero.
    pub travel: f32,
    /// `$220`: greatest jerk, mm/s3.
    pub jerk: f32,
    /// Whether it turns; no setting.
    pub rotary: bool,
    /// Whether it has a home switch, and when it is homed: axes of a lower number first, those of the same at once. No setting: a
    /// board says so. Without a word from it Z comes first, then X and Y, and no other axis has a switch.
    pub home: Option<u8>,
    /// Greatest speed that its drive has the pulses for, mm/min: a greater `$110` is refused. No setting: a board says so; `None`: any.
    pub fastest: Option<f32>,
}

impl AxisSettings {
    const PARTS: usize = 5;

    /// Whether its drive could not follow.
    fn is_too_fast(&self) -> bool {
        self.fastest.is_some_and(|fastest| self.rate > fastest)
    }

    fn part(&mut self, part: usize) -> Option<&mut f32> {
        Some(match part {
            0 => &mut self.steps,
            1 => &mut self.rate,
            2 => &mut self.acceleration,
            3 => &mut self.travel,
            4 => &mut self.jerk,
            _ => return None,
        })
    }
}

/// First numbers of the settings of axes.
const FIRST: [u32; AxisSettings::PARTS] = [100, 110, 120, 130, 220];

/// Numbers of the others, in their order.
const NUMBERS: [u32; COMMON] =
    [0, 1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 20, 21, 22, 23, 24, 25, 26, 27, 30, 31, 32];
const COMMON: usize = 22;

/// Places in [`NUMBERS`] of those that mean something to the controller.
mod place {
    pub const PULSE: usize = 0;
    pub const REPORT: usize = 7;
    pub const TOLERANCE: usize = 8;
    pub const INCHES: usize = 10;
    pub const SOFT: usize = 11;
    pub const HARD: usize = 12;
    pub const HOMING: usize = 13;
    #[cfg(feature = "home")]
    pub const SIDES: usize = 14;
    pub const SLOW: usize = 15;
    pub const SEEK: usize = 16;
    pub const PULL_OFF: usize = 18;
    pub const FASTEST: usize = 19;
    pub const SLOWEST: usize = 20;
    pub const LASER: usize = 21;
}

/// How far away a switch is looked for, in travels of its axis.
#[cfg(feature = "home")]
const SEARCH: f64 = 1.5;

/// What they are as long as nobody has said otherwise.
const DEFAULTS: [f32; COMMON] = [
    10.0, 25.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.01, 0.002, 0.0, 0.0, 0.0, 0.0, 0.0, 25.0, 500.0,
    250.0, 1.0, 1000.0, 0.0, 0.0,
];

/// How a number is written and what it may be.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A whole number up to 255.
    Byte,
    /// A whole number up to 65,535, or a mask.
    Word,
    /// 0 or 1.
    Switch,
    /// With three decimals.
    Number,
}

const fn kind(number: u32) -> Kind {
    match number {
        0..=3 | 10 | 23 => Kind::Byte,
        26 => Kind::Word,
        4..=6 | 13 | 20..=22 | 32 => Kind::Switch,
        _ => Kind::Number,
    }
}

/// All settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<const N: usize> {
    /// Of the axes.
    pub axes: [AxisSettings; N],
    common: [f32; COMMON],
}

impl<const N: usize> Settings<N> {
    /// Of a machine, with so many steps per mm (per degree) on every axis, and open travel of so many mm.
    pub fn new<S: Scalar>(config: &Config<S, N>, steps: [f32; N], travel: [f32; N]) -> Self {
        let mut common = DEFAULTS;
        if let Some(slot) = common.get_mut(place::TOLERANCE) {
            *slot = config.tolerance.to_f64() as f32;
        }
        let mut axes = [AxisSettings::NONE; N];
        let limits = config.limits.axes().iter().zip(steps.iter().zip(&travel));
        let orders = [Some(1), Some(1), Some(0)].into_iter().chain(core::iter::repeat(None));
        let axes_of = axes.iter_mut().zip(orders);
        for ((slot, home), (limits, (steps, travel))) in axes_of.zip(limits) {
            *slot = AxisSettings {
                steps: *steps,
                rate: (limits.velocity.to_f64() * 60.0) as f32,
                acceleration: limits.acceleration.to_f64() as f32,
                travel: *travel,
                jerk: limits.jerk.to_f64() as f32,
                rotary: limits.rotary,
                home,
                fastest: None,
            };
        }
        Self { axes, common }
    }

    fn common(&self, place: usize) -> f32 {
        self.common.get(place).copied().unwrap_or(0.0)
    }

    /// By its number: what the common ones are, in the units of grbl; 0 for one that is not known.
    pub fn value(&self, number: u32) -> f32 {
        let place = NUMBERS.iter().position(|&own| own == number);
        place.map_or(0.0, |place| self.common(place))
    }

    /// `$11`: the tolerance of blocks that name none, mm.
    pub fn tolerance(&self) -> f64 {
        f64::from(self.common(place::TOLERANCE))
    }

    /// `$10`, bit 0: whether reports tell the machine's position.
    pub fn tells_machine(&self) -> bool {
        self.common(place::REPORT) as u8 & 1 != 0
    }

    /// `$10`, bit 1: whether reports tell the room there is.
    pub fn tells_room(&self) -> bool {
        self.common(place::REPORT) as u8 & 2 != 0
    }

    fn is_on(&self, place: usize) -> bool {
        self.common(place) > 0.0
    }

    /// `$13`.
    pub fn inches(&self) -> bool {
        self.is_on(place::INCHES)
    }

    /// `$20`.
    pub fn soft_limits(&self) -> bool {
        self.is_on(place::SOFT)
    }

    /// `$21`.
    pub fn hard_limits(&self) -> bool {
        self.is_on(place::HARD)
    }

    /// `$22`.
    pub fn homing(&self) -> bool {
        self.is_on(place::HOMING)
    }

    /// `$32`: whether S and M3 to M5 are for a laser.
    pub fn laser(&self) -> bool {
        self.is_on(place::LASER)
    }

    /// How axes are homed, all that have a switch or one of them alone: `$23` (sides), `$24` and `$25` (speeds), `$27` (the way back), and
    /// `$130`, the travel, of which the switch may be one and a half away. The edge is where the travel ends: at 0 or, of an axis in `$23`,
    /// at its least. So the axis ends inside the travel, by the way back.
    #[cfg(feature = "home")]
    pub(super) fn homes<S: Scalar>(&self, only: Option<usize>) -> [Option<AxisHome<S>>; N] {
        let value = |place| f64::from(self.common(place));
        let (slow, fast) = (value(place::SLOW) / 60.0, value(place::SEEK) / 60.0);
        // What is out of the range of coordinates is 0, and refused.
        let coord = |mm: f64| Coord::from_mm(mm).unwrap_or_default();
        let back = value(place::PULL_OFF);
        let sides = self.common(place::SIDES) as u16;
        core::array::from_fn(|index| {
            let axis = self.axes.get(index).filter(|_| only.is_none_or(|only| only == index))?;
            let below = sides >> index & 1 == 1;
            let (side, at) = if below { (-1.0, -f64::from(axis.travel)) } else { (1.0, 0.0) };
            Some(AxisHome {
                fast: S::of(side * fast),
                slow: S::of(slow),
                reach: coord(SEARCH * f64::from(axis.travel)),
                back: coord(back),
                at: coord(at),
                park: Some(coord(at - side * back)),
                order: axis.home?,
            })
        })
    }

    /// `$31` and `$30`: slowest and fastest speed of the spindle, 1/min.
    pub fn spindle(&self) -> (f32, f32) {
        (self.common(place::SLOWEST), self.common(place::FASTEST))
    }

    /// The limits they ask for; `None` if those are out of their ranges.
    pub fn limits<S: Scalar>(&self) -> Option<Limits<S, N>> {
        let axes = self.axes.map(|axis| {
            let of = |value: f32| S::of(f64::from(value));
            AxisLimits {
                // Also of settings that were kept by an image with other drives.
                velocity: S::of(
                    f64::from(axis.rate.min(axis.fastest.unwrap_or(f32::INFINITY))) / 60.0,
                ),
                acceleration: of(axis.acceleration),
                jerk: of(axis.jerk),
                rotary: axis.rotary,
            }
        });
        Limits::new(axes).ok()
    }

    /// The travel they ask for: from below zero to zero. Axes that turn have none.
    pub fn travel(&self) -> Option<Travel<N>> {
        let axes = self.axes.map(|axis| {
            let open = axis.rotary || !(axis.travel > 0.0);
            let least = Coord::from_mm(-f64::from(axis.travel)).ok();
            let range = AxisTravel { least, greatest: Some(Coord::ZERO) };
            if open { AxisTravel::default() } else { range }
        });
        Travel::new(axes).ok()
    }

    /// Whether every one is in its range.
    pub fn is_sound(&self) -> bool {
        let tolerance = Quantity::Tolerance.range();
        let has_travel =
            self.axes.iter().all(|axis| Coord::from_mm(f64::from(axis.travel)).is_ok());
        let all = self.axes.iter().flat_map(|axis| [axis.steps, axis.travel]).chain(self.common);
        let sound = all.into_iter().all(|value| value.is_finite() && value >= 0.0);
        sound
            && has_travel
            && (tolerance.least..=tolerance.greatest).contains(&self.tolerance())
            && self.limits::<f32>().is_some()
    }

    /// Sets one.
    ///
    /// # Errors
    /// The number is not known, or the value is out of its range or of use without another one. Nothing has changed.
    pub fn set(&mut self, number: u32, value: f64) -> Result<(), Error> {
        if !(value >= 0.0) {
            return Err(Error::Negative);
        }
        let mut after = *self;
        let slot = after.slot(number).ok_or(Error::Statement)?;
        let whole = match kind(number) {
            Kind::Byte => Some(255.0),
            Kind::Word => Some(65_535.0),
            Kind::Switch => Some(1.0),
            Kind::Number => None,
        };
        // As grbl reads them: what is behind the point does not count, and every number but 0 is on.
        let value = match whole {
            Some(most) => libm::trunc(value).min(most),
            None => value,
        };
        *slot = value as f32;
        after.allow(number)?;
        if !after.is_sound() {
            return Err(Error::Negative);
        }
        *self = after;
        Ok(())
    }

    /// What goes with what.
    fn allow(&mut self, number: u32) -> Result<(), Error> {
        match number {
            0 if self.common(place::PULSE) < 3.0 => Err(Error::StepPulse),
            20 if self.soft_limits() && !self.homing() => Err(Error::NeedsHoming),
            22 if !self.homing() => {
                if let Some(soft) = self.common.get_mut(place::SOFT) {
                    *soft = 0.0;
                }
                Ok(())
            }
            22 if cfg!(not(feature = "home")) => Err(Error::Statement),
            24 | 25 | 27 if self.has_no_way_home() => Err(Error::Negative),
            110..=119
                if self.axes.get(number as usize - 110).is_some_and(AxisSettings::is_too_fast) =>
            {
                Err(Error::StepRate)
            }
            32 if self.laser() && cfg!(not(feature = "outputs")) => Err(Error::Laser),
            _ => Ok(()),
        }
    }

    /// Whether a number of homing is 0 that must not be.
    fn has_no_way_home(&self) -> bool {
        [place::SLOW, place::SEEK, place::PULL_OFF].into_iter().any(|place| !self.is_on(place))
    }

    fn slot(&mut self, number: u32) -> Option<&mut f32> {
        if let Some(place) = NUMBERS.iter().position(|&own| own == number) {
            return self.common.get_mut(place);
        }
        let (part, first) = FIRST
            .iter()
            .enumerate()
            .find(|(_, first)| (**first..**first + 10).contains(&number))?;
        self.axes.get_mut((number - first) as usize)?.part(part)
    }

    /// Every value, in the order of [`Settings::number`].
    pub(super) fn values(&mut self) -> impl Iterator<Item = &mut f32> {
        let axes = self.axes.iter_mut().flat_map(|axis| {
            [
                &mut axis.steps,
                &mut axis.rate,
                &mut axis.acceleration,
                &mut axis.travel,
                &mut axis.jerk,
            ]
        });
        self.common.iter_mut().chain(axes)
    }

    /// The number of the line of a list; `None` behind its end.
    fn number(line: usize) -> Option<u32> {
        if let Some(number) = NUMBERS.get(line) {
            return Some(*number);
        }
        let line = line - COMMON;
        let axis = line.checked_rem(N)?;
        FIRST.get(line / N).map(|first| first + axis as u32)
    }

    /// Writes a line of the list of all settings; `false` behind its end.
    pub(super) fn say(&self, line: usize, out: &mut Outbox) -> bool {
        let Some(number) = Self::number(line) else { return false };
        let mut own = *self;
        let value = own.slot(number).copied().unwrap_or(0.0);
        let decimals = match kind(number) {
            _ if matches!(number, 30 | 31) => 0,
            Kind::Number => 3,
            _ => 0,
        };
        out.byte(b'$').whole(number).byte(b'=').number(f64::from(value), decimals).end();
        true
    }
}

impl AxisSettings {
    /// The memory of some.
    const NONE: Self = Self {
        steps: 0.0,
        rate: 0.0,
        acceleration: 0.0,
        travel: 0.0,
        jerk: 0.0,
        rotary: false,
        home: None,
        fastest: None,
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn settings() -> Settings<3> {
        let axis = AxisLimits::linear(200.0f32, 2000.0, 50_000.0);
        let config = Config::new(Limits::new([axis; 3]).unwrap());
        Settings::new(&config, [250.0; 3], [300.0; 3])
    }

    #[test]
    fn what_is_set_is_what_is_said_and_what_holds() {
        let mut settings = settings();
        for (number, value) in [(100, 80.0), (111, 6000.0), (122, 500.0), (130, 400.0), (222, 9e3)]
        {
            settings.set(number, value).unwrap();
        }
        let limits = settings.limits::<f64>().unwrap();
        assert!((limits.axes()[1].velocity - 100.0).abs() < 1e-9);
        assert!((limits.axes()[2].acceleration - 500.0).abs() < 1e-9);
        assert!((limits.axes()[2].jerk - 9000.0).abs() < 1e-9);
        let mut out = Outbox::default();
        let mut said = Vec::new();
        for line in 0.. {
            if !settings.say(line, &mut out) {
                break;
            }
            while let Some(byte) = out.peek() {
                said.push(byte);
                out.sent();
            }
        }
        let said = std::string::String::from_utf8(said).unwrap();
        assert_eq!(said.lines().count(), COMMON + 15);
        for line in
            ["$0=10", "$11=0.010", "$30=1000", "$100=80.000", "$111=6000.000", "$222=9000.000"]
        {
            assert!(said.lines().any(|own| own == line), "{line} in {said}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused_and_changes_nothing() {
        let before = settings();
        let mut settings = before;
        for (number, value, error) in [
            (0, 2.0, Error::StepPulse),
            (20, 1.0, Error::NeedsHoming),
            #[cfg(not(feature = "home"))]
            (22, 1.0, Error::Statement),
            #[cfg(not(feature = "outputs"))]
            (32, 1.0, Error::Laser),
            (24, 0.0, Error::Negative),
            (27, 0.4e-46, Error::Negative),
            (110, 0.0, Error::Negative),
            (110, -5.0, Error::Negative),
            (120, f64::INFINITY, Error::Negative),
            (11, f64::NAN, Error::Negative),
            (7, 1.0, Error::Statement),
            (103, 1.0, Error::Statement),
            (999, 1.0, Error::Statement),
        ] {
            assert_eq!(settings.set(number, value), Err(error), "${number}={value}");
            assert_eq!(settings, before);
        }
        settings.set(10, 3.7).unwrap();
        assert!(settings.tells_machine() && settings.tells_room());
    }

    /// An axis whose pulses come too fast for its drive falls behind: the board stops it in the middle of a move.
    #[test]
    fn no_axis_is_faster_than_its_drive() {
        let mut settings = settings();
        settings.axes[1].fastest = Some(6000.0);
        settings.set(110, 9000.0).unwrap();
        settings.set(111, 6000.0).unwrap();
        let before = settings;
        assert_eq!(settings.set(111, 6000.5), Err(Error::StepRate));
        assert_eq!(settings, before);
        // One that was kept before the board had this drive.
        settings.axes[1].rate = 30_000.0;
        let limits = settings.limits::<f64>().unwrap();
        let velocities = limits.axes().each_ref().map(|axis| axis.velocity);
        assert!((velocities[0] - 150.0).abs() < 1e-9 && (velocities[1] - 100.0).abs() < 1e-9);
    }
}
