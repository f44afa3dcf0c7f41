//! Motors of a machine description: what each follows of the axes of a program, and its limits.

use super::{Axis, Machine, StopLimits, axis_index};
use crate::letters::{ALL, lettered};
use crate::program::{AXES, LETTERS};
use anyhow::{Result, anyhow, bail};
use serde::Deserialize;
use splineway::{AxisLimits, ConfigError, Limits, MOTORS, Scalar};
use std::collections::BTreeMap;

/// A motor that follows several axes.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// What it is called.
    pub name: String,
    /// How far it goes for one of each axis, by letter.
    pub axes: BTreeMap<String, f64>,
    /// mm/s.
    pub velocity: f64,
    /// mm/s2.
    pub acceleration: f64,
    /// mm/s3.
    pub jerk: f64,
    /// Limits for quick stops; none of its own if it is left out.
    #[serde(default)]
    pub stop: Option<StopLimits>,
}

/// A motor over the axes of a program, in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorRow {
    /// What it is called.
    pub name: String,
    /// How far it goes for one of each axis.
    pub factors: Vec<f64>,
    /// Its limits.
    pub limits: Axis,
    /// Those of quick stops: the greater of both.
    pub stop: Axis,
}

impl Motor {
    /// Its limits, but for quick stops.
    const fn limits(&self) -> Axis {
        Axis { velocity: self.velocity, acceleration: self.acceleration, jerk: self.jerk }
    }

    /// What is said of its quick stops.
    fn said_of_stops(&self) -> StopLimits {
        self.stop.unwrap_or(StopLimits::UNSAID)
    }
}

impl MotorRow {
    /// What it does where the axes do this.
    pub fn of(&self, axes: &[f64]) -> f64 {
        self.factors.iter().zip(axes).map(|(factor, axis)| factor * axis).sum()
    }
}

impl Machine {
    /// The motors that move with some axes, in the machine's order, and how far they go for one of each.
    fn moving(&self, axes: &[usize]) -> impl Iterator<Item = (&Motor, Vec<f64>)> {
        let factors = |motor: &Motor| -> Vec<f64> {
            let factor = |index: &usize| {
                let named = motor.axes.iter().find(|(key, _)| axis_index(key) == Some(*index));
                named.map_or(0.0, |(_, factor)| *factor)
            };
            axes.iter().map(factor).collect()
        };
        let all = self.motor.iter().map(move |motor| (motor, factors(motor)));
        all.filter(|(_, factors)| factors.iter().any(|factor| *factor != 0.0))
    }

    /// The same as rows.
    pub fn motors_of(&self, axes: &[usize]) -> Vec<MotorRow> {
        let row = |(motor, factors): (&Motor, _)| {
            let limits = motor.limits();
            let stop = limits.in_stops(motor.said_of_stops());
            MotorRow { name: motor.name.clone(), factors, limits, stop }
        };
        self.moving(axes).map(row).collect()
    }

    /// Limits of axes with those of their motors; `stops`: for quick stops.
    pub(crate) fn on_motors<S: Scalar, const N: usize>(
        &self,
        limits: Limits<S, N>,
        axes: &[usize],
        stops: bool,
    ) -> Result<Limits<S, N>, ConfigError> {
        let motors: Vec<_> = self
            .moving(axes)
            .map(|(motor, all)| {
                let said = motor.said_of_stops();
                let limits = motor.limits();
                let Axis { velocity, acceleration, jerk } =
                    if stops { limits.with(said) } else { limits };
                let mut factors = [S::ZERO; N];
                for (slot, factor) in factors.iter_mut().zip(all) {
                    *slot = S::of(factor);
                }
                let limits = AxisLimits::linear(S::of(velocity), S::of(acceleration), S::of(jerk));
                splineway::Motor::new(factors, limits)
            })
            .collect();
        limits.with_motor_list(&motors)
    }

    /// Whether the motors make sense.
    pub(crate) fn check_motors(&self) -> Result<()> {
        if self.motor.len() > MOTORS {
            bail!("motor: {} of them; a machine has {MOTORS} at most", self.motor.len());
        }
        for (n, motor) in self.motor.iter().enumerate() {
            let name = &motor.name;
            // Setpoints are written in columns: time, axes, motors. (A motor A beside axes X and Y is as CoreXY has it.)
            let mut driven = self.motor.iter().flat_map(|motor| motor.axes.keys());
            if name.eq_ignore_ascii_case("t") || driven.any(|axis| axis.eq_ignore_ascii_case(name))
            {
                bail!(
                    "motor {name}: t and the axes that motors move name other columns of setpoints"
                );
            }
            if self.motor.iter().take(n).any(|other| other.name == *name) {
                bail!("motor {name}: there are two of this name");
            }
            for key in motor.axes.keys() {
                if axis_index(key).is_none() {
                    bail!("motor {name}, axes.{key}: no such axis; axes are X Y Z A B C U V W");
                }
            }
            if motor.axes.values().all(|factor| *factor == 0.0) {
                bail!("motor {name}: it moves no axis");
            }
            // The greater of two hides what is no number.
            if let Some(stop) = motor.stop {
                let stop = AxisLimits::linear(1.0, stop.acceleration, stop.jerk);
                Limits::new([stop]).map_err(|error| anyhow!("motor {name}, stop: {error}"))?;
            }
        }
        let any = AxisLimits::linear(1.0, 1.0, 1.0);
        let limits = Limits::<f64, AXES>::new([any; AXES])?;
        for stops in [false, true] {
            self.on_motors(limits, &ALL, stops).map_err(|error| self.in_words(&error))?;
        }
        Ok(())
    }

    /// With names in the place of numbers.
    fn in_words(&self, error: &ConfigError) -> anyhow::Error {
        let letter = |axis: usize| LETTERS[axis];
        let name = |motor: usize| self.motor.get(motor).map_or("?", |motor| motor.name.as_str());
        match *error {
            ConfigError::MotorLimit { motor, quantity, error } => {
                anyhow!("motor {}: limit of {quantity:?}: {error}", name(motor))
            }
            ConfigError::MotorFactor { motor, axis, error } => {
                anyhow!("motor {}, axes.{}: {error}", name(motor), letter(axis))
            }
            ConfigError::Singular { axis, error } => anyhow!(
                "motor: {} could move with others and no motor turn ({} of it is its own, and it must be {}): is a motor missing, \
                 or does one follow the axes as another does?",
                letter(axis),
                error.value,
                error.least
            ),
            ref other => anyhow!("motor: {}", lettered(&other.to_string(), &ALL)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BELTS: &str = "[[motor]]\nname = 'left'\naxes = { X = 1, Y = 1 }\nvelocity = 300\nacceleration = 3000\njerk = 60000\n\
        [[motor]]\nname = 'right'\naxes = { X = 1, y = -1 }\nvelocity = 300\nacceleration = 3000\njerk = 60000\n\
        stop = { acceleration = 9000, jerk = 1000 }\n";

    #[test]
    fn motors_follow_the_axes_of_the_program() {
        let machine = Machine::parse(BELTS).unwrap();
        let rows = machine.motors_of(&[1, 0, 2]);
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[1].name.as_str(), &rows[1].factors[..]), ("right", &[-1.0, 1.0, 0.0][..]));
        assert!((rows[1].stop.acceleration - 9000.0).abs() < 1e-9);
        assert!((rows[1].stop.jerk - 60_000.0).abs() < 1e-9);
        assert!((rows[0].of(&[2.0, 3.0, 7.0]) - 5.0).abs() < 1e-12);
        // Of one axis both follow it; of another none.
        assert_eq!(machine.motors_of(&[0]).len(), 2);
        assert!(machine.motors_of(&[2]).is_empty());
        let config = machine.config::<f32, 3>(&[0, 1, 2]).unwrap();
        assert!(config.limits.motor(1).is_some() && config.limits.motor(2).is_none());
        assert!(config.stop_limits.is_some());
    }

    /// Axes that a program does not have - those of blocks are checked with all there can be - are no reason to refuse a shaper.
    #[test]
    fn motors_are_shaped_with_all_axes_of_the_program() {
        let shaped = |shapers: &[(&str, &str)]| {
            let shapers = shapers.iter().map(|(axis, hertz)| {
                format!("[shaper.{axis}]\nkind = 'zv'\nfrequency = {hertz}\n")
            });
            let machine =
                Machine::parse(&(BELTS.to_owned() + &shapers.collect::<String>())).unwrap();
            machine.config::<f64, AXES>(&[0, 1, 2]).map(|config| config.follower.alike)
        };
        assert!(shaped(&[("default", "45")]).unwrap());
        assert!(shaped(&[("X", "45"), ("Y", "45"), ("Z", "45")]).unwrap());
        for (shapers, words) in [
            (&[("X", "45"), ("Y", "45")][..], "Z is not shaped as XY is"),
            (&[("default", "45"), ("Y", "40")], "Y is not shaped as XZ is"),
        ] {
            let error = format!("{:#}", shaped(shapers).unwrap_err());
            assert!(error.contains(words) && error.contains("[shaper.default]"), "{error}");
        }
    }

    #[test]
    fn a_motor_may_have_the_name_of_an_axis_that_no_motor_moves() {
        assert!(Machine::parse(&BELTS.replacen("'right'", "'A'", 1)).is_ok());
    }

    #[test]
    fn errors_name_the_motor() {
        let with = |from: &str, to: &str| {
            let text = BELTS.replacen(from, to, 1);
            format!("{:#}", Machine::parse(&text).unwrap_err())
        };
        for (from, to, part) in [
            ("'right'", "'left'", "motor left: there are two"),
            ("'right'", "'x'", "motor x: t and the axes"),
            ("'right'", "'T'", "motor T: t and the axes"),
            ("X = 1, Y = 1", "Q = 1", "axes.Q: no such axis"),
            ("X = 1, Y = 1", "", "moves no axis"),
            ("X = 1, Y = 1", "X = 1, Y = -1", "is a motor missing, or"),
            ("X = 1, Y = 1", "X = 1001, Y = 1", "motor left, axes.X: 1001"),
            ("velocity = 300", "velocity = -3", "motor left: limit of Velocity: -3"),
            ("jerk = 1000", "jerk = nan", "motor right"),
            ("velocity = 300", "speed = 300", "speed"),
        ] {
            let error = with(from, to);
            assert!(error.contains(part), "{error}");
        }
    }
}
