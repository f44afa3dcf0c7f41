//! Probes and homing in files of events, and the inputs that end them, simulated.

use super::jog::{number, parse_axes};
use super::sought::{Ending, Search, Sought, Spot};
use crate::letters::{lettered, said};
use crate::program::LETTERS;
use anyhow::{Context, Result, bail, ensure};
use splineway::wire::{HomeAxis, HomeMove};
use splineway::{
    Activity, AxisHome, Coord, Input, Inputs, Outcome, Planner, Probe, ProbeError, Scalar, Setpoint,
};
use std::collections::VecDeque;

/// What homing looks like.
const HOMING: &str = "X-50 Y-50 slow 5 reach 300 back 2 at 0 [park 5]";

/// Where an input is closed: beyond a place on an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    axis: usize,
    place: f64,
    below: bool,
}

impl Beyond {
    /// Understands `Z<-2.5` or `X>120`.
    ///
    /// # Errors
    /// What is not understood.
    pub fn parse(text: &str) -> Result<Self> {
        let below = text.contains('<');
        let (letter, place) = text.split_once(['<', '>']).with_context(|| {
            format!("\"{text}\" is no place of an input, as Z<-2.5 or X>120 is")
        })?;
        let letter = letter.trim().to_ascii_uppercase();
        let axis = LETTERS.iter().position(|axis| axis.to_string() == letter);
        let axis = axis.with_context(|| format!("\"{letter}\" is no axis"))?;
        Ok(Self { axis, place: number(place.trim())?, below })
    }

    fn is_closed(&self, place: f64) -> bool {
        if self.below { place <= self.place } else { place >= self.place }
    }
}

/// Something of them at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seek {
    /// The probe closes there.
    Surface(Beyond),
    /// The home switch of the axis is closed there.
    Switch(Beyond),
    /// A probe.
    Probe {
        /// Where to, mm; axes that are not named stay where they are.
        to: [Option<f64>; 9],
        /// mm/s.
        feed: f64,
        /// Whether it ends when the probe closes, or when it opens.
        closes: bool,
    },
    /// Homing.
    Home(Homing),
}

/// How axes are homed at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homing {
    /// Speeds of the first approach, mm/s, with the side of the switch as their sign; 0: the axis is not homed.
    fast: [f64; 9],
    /// Speed of the second.
    slow: f64,
    reach: Coord,
    back: Coord,
    at: Coord,
    park: Option<Coord>,
}

impl Homing {
    /// Understands `X-50 Y-50 slow 5 reach 300 back 2 at 0 park 5`.
    ///
    /// # Errors
    /// What is not understood.
    pub fn parse(words: &str) -> Result<Self> {
        parse_home(words)
    }

    /// Where the axes end that are homed, mm; at their edges, if they are not parked.
    pub fn ends(&self) -> [Option<f64>; 9] {
        let end = self.park.unwrap_or(self.at).to_mm();
        self.fast.map(|fast| (fast != 0.0).then_some(end))
    }

    /// As it is sent to a controller.
    ///
    /// # Errors
    /// A number is beyond what can be sent.
    pub fn as_sent(&self, tag: u32) -> Result<HomeMove> {
        let um = |mm: f64| {
            let um = (mm * 1.0e3).round();
            ensure!((0.0..=f64::from(u32::MAX)).contains(&um), "homing: {mm} is out of range");
            Ok(um as u32)
        };
        let mut axes = Vec::new();
        for fast in self.fast {
            if fast == 0.0 {
                axes.push(None);
                continue;
            }
            let speed = um(fast.abs())?.min(i32::MAX as u32).cast_signed();
            axes.push(Some(HomeAxis {
                fast: if fast < 0.0 { -speed } else { speed },
                slow: um(self.slow.abs())?,
                reach: um(self.reach.to_mm())?,
                back: um(self.back.to_mm())?,
                at: self.at.to_nm(),
                park: self.park.map(Coord::to_nm),
                order: 0,
            }));
        }
        Ok(HomeMove { axes: axes.into_iter().collect(), tag })
    }
}

/// Understands one of them; `None` if the word is none of theirs.
///
/// # Errors
/// What is not understood.
pub fn parse_seek(word: &str, words: &str) -> Result<Option<Seek>> {
    Ok(Some(match word {
        "surface" => Seek::Surface(Beyond::parse(words)?),
        "switch" => Seek::Switch(Beyond::parse(words)?),
        "probe" | "probe-away" => {
            let (axes, feed) = words.split_once("at").with_context(|| {
                format!("\"{word}\" needs \"at\" and a feed, as in Z-10 at FEED")
            })?;
            let mut to = [None; 9];
            for (axis, value) in parse_axes(axes)? {
                to[axis] = Some(value);
            }
            ensure!(to != [None; 9], "\"{word} {words}\" names no axis");
            Seek::Probe { to, feed: number(feed.trim())?, closes: word == "probe" }
        }
        "home" => Seek::Home(parse_home(words)?),
        _ => return Ok(None),
    }))
}

fn parse_home(words: &str) -> Result<Homing> {
    let start =
        words.find("slow").with_context(|| format!("homing needs \"slow\", as in {HOMING}"))?;
    let (axes, settings) = words.split_at(start);
    let [mut slow, mut reach, mut back, mut at, mut park] = [None; 5];
    let mut rest = settings.split_whitespace();
    while let Some(name) = rest.next() {
        let slot = match name {
            "slow" => &mut slow,
            "reach" => &mut reach,
            "back" => &mut back,
            "at" => &mut at,
            "park" => &mut park,
            _ => bail!("\"{name}\" is nothing of homing, which is as in {HOMING}"),
        };
        let value = rest.next().with_context(|| format!("\"{name}\" needs a number"))?;
        *slot = Some(number(value)?);
    }
    let coord = |mm: f64| Coord::from_mm(mm).context("a length or coordinate of homing, mm");
    let needed = |value: Option<f64>, name: &str| {
        value.with_context(|| format!("homing needs \"{name}\", as in {HOMING}"))
    };
    let mut fast = [0.0; 9];
    for (axis, speed) in parse_axes(axes)? {
        ensure!(speed != 0.0, "{} has no speed to be homed at", LETTERS[axis]);
        fast[axis] = speed;
    }
    ensure!(fast.iter().any(|speed| *speed != 0.0), "\"home {words}\" names no axis");
    Ok(Homing {
        fast,
        slow: needed(slow, "slow")?,
        reach: coord(needed(reach, "reach")?)?,
        back: coord(needed(back, "back")?)?,
        at: coord(needed(at, "at")?)?,
        park: park.map(coord).transpose()?,
    })
}

/// The inputs of a simulated machine, and what waits for the machine to rest.
#[derive(Clone, Debug, Default)]
pub struct Seeker {
    surfaces: Vec<Beyond>,
    switches: Vec<Beyond>,
    waiting: VecDeque<Seek>,
    /// What came of what was done.
    pub outcomes: Vec<Sought>,
    /// Where the machine is, less what setpoints say, mm: coordinates are set by homing.
    pub shift: [f64; 9],
}

impl Seeker {
    /// With home switches and surfaces that are there from the beginning.
    pub fn new(switches: Vec<Beyond>, surfaces: Vec<Beyond>) -> Self {
        Self { surfaces, switches, ..Self::default() }
    }

    /// The inputs change as the machine moves, and coordinates are set.
    pub fn sense<S: Scalar, const N: usize>(
        &mut self,
        inputs: Inputs<'_>,
        axes: &[usize],
        between: (&Setpoint<S, N>, &Setpoint<S, N>),
        cycle: f64,
    ) {
        let (from, to) = between;
        if to.activity == Activity::Set {
            for (i, shift) in self.shift.iter_mut().enumerate().take(N) {
                *shift += from.position_mm(i) - to.position_mm(i);
            }
            return;
        }
        self.tell(inputs, axes, between, cycle);
    }

    /// It is time for it.
    pub fn take(&mut self, seek: Seek) {
        match seek {
            Seek::Surface(beyond) => self.surfaces.push(beyond),
            Seek::Switch(beyond) => self.switches.push(beyond),
            _ => self.waiting.push_back(seek),
        }
    }

    /// Whether something waits for the machine to rest.
    pub fn is_waiting(&self) -> bool {
        !self.waiting.is_empty()
    }

    /// Notes what came of what is over at a time, s.
    pub fn hear<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        axes: &[usize],
        now: f64,
    ) {
        if let Some(probed) = planner.probed() {
            let place = Spot::new(&probed.position, axes);
            let (outcome, edge, rest) = match probed.outcome {
                Outcome::Tripped => (Ending::Tripped, Some(place), Spot::new(planner.end(), axes)),
                Outcome::Missed => (Ending::Missed, None, place),
                _ => (Ending::Cancelled, None, place),
            };
            let (kind, failure) = (Search::Probe, None);
            self.outcomes.push(Sought { kind, time_s: now, outcome, edge, rest, failure });
        }
        if let Some(homed) = planner.homed() {
            let failure = homed.err().map(|failure| lettered(&failure.to_string(), axes));
            let outcome = if failure.is_none() { Ending::Homed } else { Ending::Failed };
            let (kind, rest) = (Search::Home, Spot::new(planner.end(), axes));
            self.outcomes.push(Sought { kind, time_s: now, outcome, edge: None, rest, failure });
        }
    }

    /// Begins what waits, if the machine rests.
    ///
    /// # Errors
    /// What the planner refuses.
    pub fn begin<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
        &mut self,
        planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
        axes: &[usize],
    ) -> Result<()> {
        let Some(seek) = self.waiting.front() else { return Ok(()) };
        let begun = match seek {
            Seek::Probe { to, feed, closes } => {
                let mut point = *planner.end();
                for (axis, mm) in to.iter().enumerate() {
                    let Some(mm) = mm else { continue };
                    point[place(axis, axes)?] = Coord::from_mm(*mm).context("target of a probe")?;
                }
                let probe =
                    Probe { to: point, feed: S::of(*feed), input: Input::Probe, closes: *closes };
                planner.probe(&probe)
            }
            Seek::Home(Homing { fast, slow, reach, back, at, park }) => {
                let mut homes = [None; N];
                for (axis, fast) in fast.iter().enumerate().filter(|(_, fast)| **fast != 0.0) {
                    homes[place(axis, axes)?] = Some(AxisHome {
                        fast: S::of(*fast),
                        slow: S::of(*slow),
                        reach: *reach,
                        back: *back,
                        at: *at,
                        park: *park,
                        order: 0,
                    });
                }
                planner.home(&homes)
            }
            _ => Ok(()),
        };
        match begun {
            // It waits until the machine rests, or is resumed.
            Err(ProbeError::Running | ProbeError::Held) => Ok(()),
            begun => {
                self.waiting.pop_front();
                begun.map_err(|error| said(&error, axes)).context("a probe, or homing")
            }
        }
    }

    /// Tells the edges between two setpoints, and all levels at the beginning.
    fn tell<S: Scalar, const N: usize>(
        &self,
        inputs: Inputs<'_>,
        axes: &[usize],
        between: (&Setpoint<S, N>, &Setpoint<S, N>),
        cycle: f64,
    ) {
        let place = |axis: usize, part: f64| {
            let Some(i) = axes.iter().position(|&used| used == axis) else { return f64::NAN };
            self.shift[i] + along(between, i, part, cycle)
        };
        let probe = |part: f64| self.surfaces.iter().any(|at| at.is_closed(place(at.axis, part)));
        tell(inputs, Input::Probe, probe);
        for (i, &axis) in axes.iter().enumerate() {
            let closed = |part: f64| {
                let mut own = self.switches.iter().filter(|at| at.axis == axis);
                own.any(|at| at.is_closed(place(axis, part)))
            };
            tell(inputs, Input::Home(i), closed);
        }
    }
}

/// Index of an axis in the run.
fn place(axis: usize, axes: &[usize]) -> Result<usize> {
    let place = axes.iter().position(|&used| used == axis);
    place.with_context(|| format!("the program does not use {}", LETTERS[axis]))
}

/// Position of an axis after a part of a cycle, mm: the jerk in it is constant.
fn along<S: Scalar, const N: usize>(
    (from, to): (&Setpoint<S, N>, &Setpoint<S, N>),
    axis: usize,
    part: f64,
    cycle: f64,
) -> f64 {
    let t = part * cycle;
    let (v, a) = (from.velocity[axis].to_f64(), from.acceleration[axis].to_f64());
    let jerk = (to.acceleration[axis].to_f64() - a) / cycle;
    from.position_mm(axis) + ((jerk * t / 3.0 + a) * t * 0.5 + v) * t
}

/// Halvings of a cycle: to the rounding of an `f32`.
const HALVINGS: usize = 24;

fn tell(inputs: Inputs<'_>, input: Input, closed: impl Fn(f64) -> bool) {
    let (was, is) = (inputs.is_closed(input), closed(1.0));
    if was == is {
        return;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if closed(middle) == was { low = middle } else { high = middle }
    }
    inputs.tell(input, is, high as f32);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_words() {
        let seek = |word, words| parse_seek(word, words).unwrap().unwrap();
        let beyond = Beyond { axis: 2, place: -2.5, below: true };
        assert_eq!(seek("surface", "z < -2.5"), Seek::Surface(beyond));
        let beyond = Beyond { axis: 0, place: 120.0, below: false };
        assert_eq!(seek("switch", "X>120"), Seek::Switch(beyond));
        let Seek::Probe { to, feed, closes } = seek("probe-away", "Z0 at 5") else { panic!() };
        assert_eq!(
            (to[2], to[0], feed.to_bits(), closes),
            (Some(0.0), None, 5f64.to_bits(), false)
        );
        let homed = seek("home", "X-50 Y20 slow 5 reach 300 back 2 at 0 park 5");
        let Seek::Home(Homing { fast, park, .. }) = homed else { panic!() };
        assert_eq!(fast.map(f64::to_bits)[..3], [-50.0, 20.0, 0.0].map(f64::to_bits));
        assert_eq!(park, Some(Coord::from_mm(5.0).unwrap()));
        assert_eq!(parse_seek("hold", "").unwrap(), None);
        for (word, words) in [
            ("surface", "Z-2.5"),
            ("switch", "Q>1"),
            ("probe", "Z-1"),
            ("probe", "at 5"),
            ("home", "X5 reach 1"),
            ("home", "X5 slow 1 back 1 at 0"),
            ("home", "slow 1 reach 1 back 1 at 0"),
            ("home", "X5 slow 1 reach 1 back 1 at 0 swing 3"),
        ] {
            assert!(parse_seek(word, words).is_err(), "{word} {words}");
        }
    }
}
