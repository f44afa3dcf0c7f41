//! Machine descriptions: TOML, a built-in default, and what flags and path files override.

mod motors;
mod text;

pub use crate::point::is_rotary;
pub use motors::{Motor, MotorRow};

use crate::input;
use crate::letters::{lettered, said};
use crate::program::{Header, LETTERS, Tape};
use crate::run::{Beyond, Seeker};
use anyhow::{Context, Result, anyhow, bail, ensure};
use serde::Deserialize;
use splineway::gcode::{OFFSETS, Place, Setup};
use splineway::machine::{Quantity, defaults};
use splineway::output::{Shape, Shaper, ShaperKind};
use splineway::{
    AxisLimits, AxisTravel, Config, ConfigError, Coord, CornerMode, Limits, Scalar, Travel,
};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

/// Limits of one axis.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// mm/s.
    pub velocity: f64,
    /// mm/s2.
    pub acceleration: f64,
    /// mm/s3.
    pub jerk: f64,
}

/// Limits of one axis for stops that must be short.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct StopLimits {
    /// mm/s2.
    pub acceleration: f64,
    /// mm/s3.
    pub jerk: f64,
}

impl Axis {
    /// With what is said of its quick stops in the place of its acceleration and jerk.
    fn with(self, StopLimits { acceleration, jerk }: StopLimits) -> Self {
        Self { acceleration, jerk, ..self }
    }

    /// Its limits in quick stops: the greater of each.
    fn in_stops(self, stop: StopLimits) -> Self {
        let (acceleration, jerk) = (self.acceleration, self.jerk);
        Self {
            acceleration: acceleration.max(stop.acceleration),
            jerk: jerk.max(stop.jerk),
            ..self
        }
    }
}

impl StopLimits {
    /// The least that is accepted: where nothing is said, the limits in force are greater.
    pub(crate) const UNSAID: Self = Self {
        acceleration: Quantity::Acceleration.range().least,
        jerk: Quantity::Jerk.range().least,
    };
}

/// How an axis vibrates, and what is done about it.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Shaping {
    /// How it is shaped.
    pub kind: Kind,
    /// Hz.
    pub frequency: f64,
    /// Damping ratio.
    #[serde(default)]
    pub damping: f64,
}

/// Kinds of input shaping.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Two impulses.
    Zv,
    /// Three impulses over three quarters of a period.
    Mzv,
    /// Three impulses over a period.
    Ei,
    /// A half wave.
    Smooth,
}

impl From<Shaping> for Shape {
    fn from(Shaping { kind, frequency, damping }: Shaping) -> Self {
        let kind = match kind {
            Kind::Zv => ShaperKind::Zv,
            Kind::Mzv => ShaperKind::Mzv,
            Kind::Ei => ShaperKind::Ei,
            Kind::Smooth => ShaperKind::Smooth,
        };
        Self { kind, frequency, damping }
    }
}

/// Servo cycles that the simulator's shaper remembers.
pub const HISTORY: usize = 1024;

/// How far an axis may go, mm or degrees.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Ends {
    /// Least position; none if it is open.
    pub least: Option<f64>,
    /// Greatest position.
    pub greatest: Option<f64>,
}

/// Corner rounding.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Full tolerance band.
    #[default]
    Band,
    /// As printed in Guo, Yan, Wang 2023.
    Paper,
}

/// A machine.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub struct Machine {
    /// Default tolerance, mm.
    pub tolerance: f64,
    /// Servo cycle, s.
    pub cycle: f64,
    /// Look-ahead depth, blocks: 16, 64 or 256.
    pub lookahead: usize,
    /// Corner rounding.
    pub mode: Mode,
    /// Share of a leg kept straight between two corners of the paper mode, 0 to 0.99.
    pub lambda: f64,
    /// Lead of a plan over the motion, s.
    pub lead: f64,
    /// Smoothing sweeps over a stretch of a run of short lines.
    pub sweeps: u16,
    /// Whether the agreed motion is made faster, shape and speed together; look-ahead 64 or 256.
    pub reshape: bool,
    /// Limits by axis letter; "default" stands for those that are not named.
    pub axes: BTreeMap<String, Axis>,
    /// Limits for quick stops by axis letter, or "default"; of an axis that is not named, its usual ones.
    pub stop: BTreeMap<String, StopLimits>,
    /// Motors that follow several axes.
    pub motor: Vec<Motor>,
    /// Limits of travel by axis letter; an axis that is not named has none.
    pub travel: BTreeMap<String, Ends>,
    /// Input shaping by axis letter; "default" stands for those that are not named.
    pub shaper: BTreeMap<String, Shaping>,
    /// Work offsets by code (G54 to G59.3), mm or degrees by axis letter.
    pub work: BTreeMap<String, BTreeMap<String, f64>>,
    /// Where G28 and G30 go, by code.
    pub reference: BTreeMap<String, BTreeMap<String, f64>>,
    /// Lengths of tools by number, mm, for G43.
    pub tools: BTreeMap<String, f64>,
    /// Where home switches are closed (`X>120`), mm, in the coordinates that the machine has when it is switched on.
    pub switches: Vec<String>,
    /// Where the probe is closed (`Z<-2.5`), in the same.
    pub surfaces: Vec<String>,
}

impl Default for Machine {
    /// A small milling machine: 200 mm/s, 2000 mm/s2, 50,000 mm/s3 on every axis.
    fn default() -> Self {
        let axis = Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 };
        Self {
            tolerance: defaults::TOLERANCE,
            cycle: defaults::CYCLE,
            lookahead: 64,
            mode: Mode::Band,
            lambda: 0.0,
            lead: defaults::LEAD,
            sweeps: defaults::SWEEPS,
            reshape: false,
            axes: BTreeMap::from([("default".to_owned(), axis)]),
            stop: BTreeMap::new(),
            motor: Vec::new(),
            travel: BTreeMap::new(),
            shaper: BTreeMap::new(),
            work: BTreeMap::new(),
            reference: BTreeMap::new(),
            tools: BTreeMap::new(),
            switches: Vec::new(),
            surfaces: Vec::new(),
        }
    }
}

impl Machine {
    /// Reads a description.
    ///
    /// # Errors
    /// Names file, key and reason.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&input::text(path)?).with_context(|| path.display().to_string())
    }

    /// Parses a description.
    ///
    /// # Errors
    /// Names key and reason.
    pub fn parse(text: &str) -> Result<Self> {
        let machine: Self = toml::from_str(text)?;
        for key in machine.axes.keys() {
            if key != "default" && axis_index(key).is_none() {
                bail!("axes.{key}: no such axis; axes are X Y Z A B C U V W and default");
            }
        }
        machine.check()?;
        Ok(machine)
    }

    /// Whether every value is one that the core takes.
    ///
    /// # Errors
    /// Names key and reason.
    pub fn check(&self) -> Result<()> {
        if !LOOKAHEADS.contains(&self.lookahead) {
            bail!("lookahead is {}; it must be one of {LOOKAHEADS:?}", self.lookahead);
        }
        for (key, axis) in &self.axes {
            let limits = AxisLimits::linear(axis.velocity, axis.acceleration, axis.jerk);
            Limits::new([limits]).map_err(|error| under("axes", key, &error))?;
        }
        for (key, stop) in &self.stop {
            if key != "default" && axis_index(key).is_none() {
                bail!("stop.{key}: no such axis; axes are X Y Z A B C U V W and default");
            }
            let limits = AxisLimits::linear(1.0, stop.acceleration, stop.jerk);
            Limits::new([limits]).map_err(|error| under("stop", key, &error))?;
        }
        self.check_motors()?;
        for (key, ends) in &self.travel {
            if axis_index(key).is_none() {
                bail!("travel.{key}: no such axis; axes are X Y Z A B C U V W");
            }
            Travel::new([ends.limits(key)?]).map_err(|error| under("travel", key, &error))?;
        }
        let mut config = Config::<f64, 1>::new(Limits::new([AxisLimits::linear(1.0, 1.0, 1.0)])?);
        self.configure(&mut config);
        config.check()?;
        for (key, shaping) in &self.shaper {
            if key != "default" && axis_index(key).is_none() {
                bail!("shaper.{key}: no such axis; axes are X Y Z A B C U V W and default");
            }
            let frequency = shaping.frequency;
            ensure!(
                frequency > 0.0,
                "shaper.{key}: frequency is {frequency} Hz; it must be above 0"
            );
            let mut shaper = Shaper::<f64, 1, HISTORY>::new();
            shaper
                .set([Some((*shaping).into())], &config)
                .map_err(|error| under("shaper", key, &error))?;
        }
        self.try_seeker()?;
        self.try_setup().map(|_| ())
    }

    /// The settings that are no axis's.
    fn configure<S: Scalar, const N: usize>(&self, config: &mut Config<S, N>) {
        config.tolerance = S::of(self.tolerance);
        config.cycle = S::of(self.cycle);
        config.lead = S::of(self.lead);
        config.sweeps = self.sweeps;
        config.corner = match self.mode {
            Mode::Band => CornerMode::Band,
            Mode::Paper => CornerMode::Paper { lambda: S::of(self.lambda) },
        };
    }

    /// Its home switches and surfaces. (Those of a machine that has been parsed are all valid; of others, what is not is left out.)
    pub fn seeker(&self) -> Seeker {
        self.try_seeker().unwrap_or_default()
    }

    fn try_seeker(&self) -> Result<Seeker> {
        let parse = |key: &str, list: &[String]| -> Result<Vec<Beyond>> {
            let parsed = list.iter().map(|text| Beyond::parse(text));
            parsed.collect::<Result<_>>().with_context(|| key.to_owned())
        };
        let switches = parse("switches", &self.switches)?;
        Ok(Seeker::new(switches, parse("surfaces", &self.surfaces)?))
    }

    /// What shapes the setpoints of the first `N` of `axes`, if anything does.
    ///
    /// # Errors
    /// What the core does not accept.
    pub fn shaper<S: Scalar, const N: usize>(
        &self,
        axes: &[usize],
        config: &Config<S, N>,
    ) -> Result<Option<Box<Shaper<S, N, HISTORY>>>> {
        if self.shaper.is_empty() {
            return Ok(None);
        }
        let mut shapes = [None; N];
        for (slot, &index) in shapes.iter_mut().zip(axes) {
            *slot = self.shape(index).map(Shape::from);
        }
        let mut shaper = Box::<Shaper<S, N, HISTORY>>::default();
        shaper.set(shapes, config).map_err(|error| said(&error, axes))?;
        Ok(Some(shaper))
    }

    /// How far an axis may go.
    fn travel(&self, index: usize) -> Result<AxisTravel> {
        let named = self.travel.iter().find(|(key, _)| axis_index(key) == Some(index));
        named.map_or(Ok(AxisTravel::default()), |(key, ends)| ends.limits(key))
    }

    /// Work offsets, reference points and tools for the G-code reader. (Those of a machine that has been parsed are
    /// all valid; of others, what is not is left out.)
    pub fn setup(&self) -> Setup {
        self.try_setup().unwrap_or_default()
    }

    fn try_setup(&self) -> Result<Setup> {
        let mut setup = Setup::NONE;
        for (code, place) in &self.work {
            let slot = OFFSET_CODES.iter().position(|known| known.eq_ignore_ascii_case(code));
            let slot = slot.ok_or_else(|| {
                anyhow!("work.{code}: work offsets are {}", OFFSET_CODES.join(" "))
            })?;
            setup.work[slot] = Some(coordinates(&format!("work.{code}"), place)?);
        }
        for (code, place) in &self.reference {
            let slot = ["G28", "G30"].iter().position(|known| known.eq_ignore_ascii_case(code));
            let slot =
                slot.ok_or_else(|| anyhow!("reference.{code}: reference points are G28 and G30"))?;
            setup.reference[slot] = coordinates(&format!("reference.{code}"), place)?;
        }
        if self.tools.len() > setup.tools.len() {
            bail!("tools: {} of them; the table holds {}", self.tools.len(), setup.tools.len());
        }
        for (slot, (number, length)) in setup.tools.iter_mut().zip(&self.tools) {
            let wrong =
                || anyhow!("tools.{number}: it must be a tool's number from 1, and a length in mm");
            let tool: u32 = number.parse().map_err(|_| wrong())?;
            let length = Coord::from_mm(*length).ok().filter(|_| tool > 0).ok_or_else(wrong)?;
            *slot = Some((tool, length));
        }
        Ok(setup)
    }

    /// Takes over what a path file says.
    pub fn apply(&mut self, header: &Header) {
        self.tolerance = header.tolerance;
        self.cycle = header.cycle;
        let axis = Axis {
            velocity: header.velocity,
            acceleration: header.acceleration,
            jerk: header.jerk,
        };
        self.axes = BTreeMap::from([("default".to_owned(), axis)]);
    }

    /// Limits of an axis.
    ///
    /// # Errors
    /// If neither it nor a default is given.
    pub fn axis(&self, index: usize) -> Result<Axis> {
        let letter = LETTERS[index];
        let named = self.axes.iter().find(|(key, _)| axis_index(key) == Some(index));
        named.map(|(_, axis)| axis).or_else(|| self.axes.get("default")).copied().ok_or_else(|| {
            anyhow!(
                "axes.{letter}: the program moves this axis, but the machine has no limits for it"
            )
        })
    }

    /// Limits of an axis in a quick stop: the greater of those for it and of the usual ones.
    ///
    /// # Errors
    /// As [`Machine::axis`].
    pub fn stop_axis(&self, index: usize) -> Result<Axis> {
        Ok(self.axis(index)?.in_stops(self.said_of_stops(index)))
    }

    /// What is said of an axis's quick stops. (The core takes the greater of this and of the limits in force, which may change.)
    fn said_of_stops(&self, index: usize) -> StopLimits {
        let named = self.stop.iter().find(|(key, _)| axis_index(key) == Some(index));
        let stop = named.map(|(_, stop)| stop).or_else(|| self.stop.get("default"));
        stop.copied().unwrap_or(StopLimits::UNSAID)
    }

    /// The core's configuration for the first `N` of `axes`.
    ///
    /// # Errors
    /// What the core does not accept.
    pub fn config<S: Scalar, const N: usize>(&self, axes: &[usize]) -> Result<Config<S, N>> {
        let mut limits = [AxisLimits::linear(S::ONE, S::ONE, S::ONE); N];
        let mut stops = limits;
        let mut travel = [AxisTravel::default(); N];
        for (n, &index) in axes.iter().enumerate().take(N) {
            let of = |axis: Axis| AxisLimits {
                velocity: S::of(axis.velocity),
                acceleration: S::of(axis.acceleration),
                jerk: S::of(axis.jerk),
                rotary: is_rotary(index),
            };
            travel[n] = self.travel(index)?;
            let axis = self.axis(index)?;
            (limits[n], stops[n]) = (of(axis), of(axis.with(self.said_of_stops(index))));
        }
        let named = |error| self.named(error, axes);
        let on_motors = |limits, stops| {
            let limits = Limits::new(limits).and_then(|limits| self.on_motors(limits, axes, stops));
            limits.map_err(named)
        };
        let mut config = Config::new(on_motors(limits, false)?);
        let stops = on_motors(stops, true)?;
        let stop_sooner =
            !self.stop.is_empty() || self.motor.iter().any(|motor| motor.stop.is_some());
        config.stop_limits = stop_sooner.then_some(stops);
        config.travel = Travel::new(travel).map_err(named)?;
        self.configure(&mut config);
        if let Some(shaper) = self.shaper(axes, &config)? {
            config.follower = shaper.follower(&config);
            // Axes that the program does not have are not shaped, and never move.
            let used = &axes[..N.min(axes.len())];
            config.follower.alike =
                used.windows(2).all(|two| self.shape(two[0]) == self.shape(two[1]));
        }
        config.check().map_err(|error| self.named(error, axes))?;
        Ok(config)
    }

    /// What shapes an axis.
    fn shape(&self, index: usize) -> Option<Shaping> {
        let named = self.shaper.iter().find(|(key, _)| axis_index(key) == Some(index));
        named.map(|(_, shaping)| *shaping).or_else(|| self.shaper.get("default").copied())
    }

    /// An error of the core, with what of the description would mend it.
    fn named(&self, error: ConfigError, axes: &[usize]) -> anyhow::Error {
        if error != ConfigError::Unlike {
            return said(&error, axes);
        }
        let (own, others): (Vec<usize>, Vec<usize>) =
            axes.iter().partition(|&&axis| self.shape(axis) == self.shape(axes[0]));
        let letters =
            |axes: &[usize]| -> String { axes.iter().map(|&axis| LETTERS[axis]).collect() };
        anyhow!(
            "shaper: {} is not shaped as {} is, but where motors follow several axes, all must be: \
             [shaper.default], and no other, shapes all alike",
            letters(&others),
            letters(&own)
        )
    }

    /// Limits of the axes a program uses in quick stops, in its order.
    ///
    /// # Errors
    /// If the machine lacks one of them.
    pub fn stop_axes_of(&self, program: &dyn Tape) -> Result<Vec<Axis>> {
        program.axes().into_iter().map(|index| self.stop_axis(index)).collect()
    }

    /// The motors that move with the axes of a program.
    pub fn motors_for(&self, program: &dyn Tape) -> Vec<MotorRow> {
        self.motors_of(&program.axes())
    }

    /// Limits of the axes a program uses, in its order.
    ///
    /// # Errors
    /// If the machine lacks one of them.
    pub fn axes_of(&self, program: &dyn Tape) -> Result<Vec<Axis>> {
        program.axes().into_iter().map(|index| self.axis(index)).collect()
    }
}

impl Ends {
    fn limits(self, key: &str) -> Result<AxisTravel> {
        let coord = |mm: Option<f64>| {
            mm.map(Coord::from_mm).transpose().map_err(|error| anyhow!("travel.{key}: {error}"))
        };
        Ok(AxisTravel { least: coord(self.least)?, greatest: coord(self.greatest)? })
    }
}

/// Codes of work offsets in their order.
const OFFSET_CODES: [&str; OFFSETS] =
    ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// A point by axis letters; axes that are not named are 0.
fn coordinates(key: &str, place: &BTreeMap<String, f64>) -> Result<Place> {
    let mut coordinates = Place::default();
    for (letter, &mm) in place {
        let axis = axis_index(letter)
            .ok_or_else(|| anyhow!("{key}.{letter}: no such axis; axes are X Y Z A B C U V W"))?;
        coordinates[axis] = Coord::from_mm(mm).map_err(|error| {
            let unit = if is_rotary(axis) { "deg" } else { "mm" };
            anyhow!("{key}.{letter} is {mm} {unit}; it must be within +-{}", error.greatest)
        })?;
    }
    Ok(coordinates)
}

/// Depths the simulator is built for.
pub const LOOKAHEADS: [usize; 3] = [16, 64, 256];

pub(crate) fn axis_index(key: &str) -> Option<usize> {
    let mut letters = key.chars();
    let letter = letters.next()?.to_ascii_uppercase();
    if letters.next().is_some() {
        return None;
    }
    LETTERS.iter().position(|&known| known == letter)
}

/// An error of the core about the one axis of a table, by the key of that.
fn under(table: &str, key: &str, error: &impl Display) -> anyhow::Error {
    let text = error.to_string();
    let text = match axis_index(key) {
        Some(index) => lettered(&text, &[index]),
        None => text.replace(" of axis 0", ""),
    };
    anyhow!("{table}.{key}: {text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_and_defaults() {
        let machine = Machine::parse(
            "tolerance = 0.02\n[axes.x]\nvelocity = 1\nacceleration = 2\njerk = 3\n[axes.default]\nvelocity = 4\nacceleration = 5\njerk = 6\n",
        )
        .unwrap();
        assert!((machine.axis(0).unwrap().jerk - 3.0).abs() < 1e-12);
        assert!((machine.axis(8).unwrap().velocity - 4.0).abs() < 1e-12);
        assert!((machine.tolerance - 0.02).abs() < 1e-12);
    }

    #[test]
    fn errors_name_the_key() {
        for (text, part) in [
            ("tolerence = 1", "tolerence"),
            ("lookahead = 3", "lookahead is 3"),
            ("[axes.Q]\nvelocity = 1\nacceleration = 2\njerk = 3\n", "axes.Q"),
            ("[axes.X]\nvelocity = -1\nacceleration = 2\njerk = 3\n", "axes.X: velocity"),
            ("[axes.X]\nvelocity = 1\n", "missing field"),
            ("[travel]\nQ = { least = 0 }\n", "travel.Q"),
            ("[travel]\nX = { least = 3, greatest = 2 }\n", "travel.X"),
            ("[travel]\nX = { greatest = nan }\n", "travel.X"),
            ("[travel]\nX = { least = 1e7 }\n", "travel.X"),
            ("[travel]\nX = { most = 1 }\n", "most"),
            ("[travel]\nC = { least = 3, greatest = 2 }\n", "limit of travel of C is 2 deg"),
            (
                "[axes.default]\nvelocity = -1\nacceleration = 2\njerk = 3\n",
                "default: velocity limit is",
            ),
            ("[axes.B]\nvelocity = -1\nacceleration = 2\njerk = 3\n", "limit of B is -1 deg/s"),
            (
                "[shaper.default]\nkind = 'zv'\nfrequency = 0\n",
                "frequency is 0 Hz; it must be above 0",
            ),
            ("switches = [\"X>1\", \"Q>1\"]\n", "switches"),
            ("switches = [\"X=5\"]\n", "\"X=5\" is no place of an input, as Z<-2.5 or X>120 is"),
            ("surfaces = [\"Z-1\"]\n", "surfaces"),
            ("tolerance = -1\n", "tolerance is -1 mm"),
            ("cycle = 5\n", "servo cycle is 5 s"),
            ("lead = -1\n", "lead is -1 s"),
            ("mode = \"paper\"\nlambda = 2\n", "lambda is 2"),
        ] {
            let error = format!("{:#}", Machine::parse(text).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
    }
}
