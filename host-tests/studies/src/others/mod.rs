//! Planners of others, as far as they can be built from what they publish, at equal limits.
//!
//! **None of this is the authors' code.** Each model is written from papers (or, of the C4 corner, from what an open
//! controller documents), and each file says from which, and what had to be decided where they say nothing; that was always decided
//! for the shorter time. The methods are theirs; equations were derived anew from what the methods are, and are stated where they
//! are used. All keep velocity, acceleration and jerk of every axis and the same band around the path, and what they come to is
//! judged like a run of the core: setpoint by setpoint, by [`Judge`].
//!
//! - [`exact_stop`]: rest at every corner;
//! - [`uninterrupted`]: constant jerk, speed and acceleration carried over the ends of the blocks (Tajima, Sencer 2017);
//! - [`c4_corner`]: C4 corners with acceleration 0 in their middle (Prunt; Jiang and others 2022), on the curve of [`pythagorean`];
//! - [`filtered`]: pulses through two moving averages (Tajima, Sencer, Shamoto 2018).
//!
//! From below: [`line_path`], [`ramp`], then these. [`known`] holds what others have measured.

mod blend;
pub mod c4_corner;
pub mod exact_stop;
mod filter;
pub mod filtered;
pub mod known;
pub mod line_path;
pub mod pythagorean;
pub mod ramp;
pub mod uninterrupted;

use crate::anymotion::motion::State;
use crate::anymotion::show;
use anyhow::{Context, Result};
use line_path::LinePath;
use splineway_simulator::judge::{Judge, Track, Verdict, violations};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::Program;
use splineway_simulator::run::{Observer, Precision, Sample, run};

/// Shares of the band that go to merging short lines before corners are made, where a planner has none but corners between two
/// lines, and how much of what that takes is taken off the corners. The fastest that the judge finds inside the band is taken.
const MERGED: [f64; 5] = [0.95, 0.8, 0.6, 0.4, 0.0];
const COUNTED: [f64; 2] = [1.0, 0.0];

/// A planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planner {
    /// This one.
    Splineway,
    /// [`exact_stop`].
    ExactStop,
    /// [`uninterrupted`].
    Uninterrupted,
    /// [`c4_corner`].
    C4Corner,
    /// [`filtered`].
    Filtered,
}

/// A planner's run, judged.
#[derive(Clone, Debug)]
pub struct Run {
    /// Positions, velocities and accelerations of all axes in use in every servo cycle: mm and s.
    pub states: Vec<[Vec<f64>; 3]>,
    /// What the judge found.
    pub verdict: Verdict,
}

impl Planner {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Splineway, Self::ExactStop, Self::Uninterrupted, Self::C4Corner, Self::Filtered];

    /// Its name, and whom it is modelled on.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Splineway => "splineway",
            Self::ExactStop => "exact stop, S-curve",
            Self::Uninterrupted => "constant jerk, (v, a) carried over (Tajima, Sencer 2017) *",
            Self::C4Corner => "C4 corner, a = 0 in its middle (Prunt; Jiang 2022) *",
            Self::Filtered => "FIR-filtered pulses (Tajima, Sencer, Shamoto 2018) *",
        }
    }

    /// Its name where there is little room.
    pub const fn short(self) -> &'static str {
        match self {
            Self::Splineway => "splineway",
            Self::ExactStop => "exact stop",
            Self::Uninterrupted => "constant jerk",
            Self::C4Corner => "C4 corner",
            Self::Filtered => "filtered pulses",
        }
    }

    /// Runs a program of lines, and judges the setpoints.
    ///
    /// # Errors
    /// What the models do not take: arcs, stops, dwells; a tolerance of 0.
    pub fn run(self, program: &Program, machine: &Machine) -> Result<Run> {
        let track = Track::new(program);
        let states = match self {
            Self::Splineway => own(program, machine)?,
            _ => self.states(&LinePath::of(program, machine)?, &track)?,
        };
        let limits = machine.axes_of(program)?;
        let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
        for (k, state) in states.iter().enumerate() {
            show(&mut judge, k as f64 * machine.cycle, state, (true, f64::EPSILON))?;
        }
        Ok(Run { verdict: judge.verdict(), states })
    }

    fn states(self, path: &LinePath, track: &Track) -> Result<Vec<State>> {
        match self {
            Self::Splineway | Self::ExactStop => Ok(exact_stop::motion(path)?.sampled(path.cycle)),
            Self::Uninterrupted => merged(path, track, |path, _| {
                Ok(Some(uninterrupted::motion(path)?.sampled(path.cycle)))
            }),
            Self::C4Corner => merged(path, track, c4_corner::states),
            Self::Filtered => filtered::states(path, track),
        }
    }
}

/// The shortest run with more or fewer of the lines merged. `plan` may leave out what is longer than so many cycles.
fn merged(
    path: &LinePath,
    track: &Track,
    plan: impl Fn(&LinePath, usize) -> Result<Option<Vec<State>>>,
) -> Result<Vec<State>> {
    let mut best: Option<Vec<State>> = None;
    // Those of few lines are the fastest as a rule, and then the others need not be looked at for long.
    for share in MERGED {
        for counted in COUNTED {
            let path = path.thinned(share, counted);
            let most = best.as_ref().map_or(usize::MAX, Vec::len);
            if let Some(states) = plan(&path, most)?
                && states.len() < most
                && path.keeps(&states, track)
            {
                best = Some(states);
            }
        }
    }
    best.context("no motion was found inside the band")
}

/// The core's own setpoints.
fn own(program: &Program, machine: &Machine) -> Result<Vec<State>> {
    let mut record = Record(Vec::new());
    run(program, machine, Precision::F64, &mut [&mut record])?;
    Ok(record.0)
}

struct Record(Vec<State>);

impl Observer for Record {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        self.0.push([sample.position, sample.velocity, sample.acceleration].map(<[f64]>::to_vec));
        Ok(())
    }
}

impl Run {
    /// Time from rest to rest, s.
    pub fn time(&self) -> f64 {
        self.verdict.time
    }

    /// Greatest deviation over the tolerance, and greatest velocity, acceleration and jerk of an axis over its limit.
    pub fn ratios(&self, machine: &Machine) -> [f64; 4] {
        let worst = self.verdict.worst();
        let off = self.verdict.deviation / machine.tolerance;
        [off, worst.velocity, worst.acceleration, worst.jerk]
    }

    /// What it has broken, as the judge says it of a run of the core.
    pub fn broken(&self) -> Vec<String> {
        violations(&self.verdict)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway_simulator::program::poly;

    const ZIGZAG: &str = include_str!("../../../data/zigzag.txt");
    /// Lines of 0.3 to 12 mm with turns of all sizes, in space.
    const CROOKED: &str = "# 200 2000 50000 0.05 0.001
        0 0 0 200\n 4 0 0 200\n 4.3 0.1 0 200\n 5 2 1 200\n 12 3 -1 200\n 1 4 -1.5 80\n 1.5 5 2 200\n 8 11 2 200
        9 13 2 200\n 9 16 2 200\n 9.5 15 2 200\n 11 15 4 150\n 12 15 7 200\n 12 20 9 200\n 0 20 9 200";

    fn read(text: &str) -> (Program, Machine) {
        let program = poly::parse(text).unwrap();
        let mut machine = Machine::default();
        machine.apply(&program.header.unwrap());
        (program, machine)
    }

    /// Legs of 10 mm and right angles at 45 degrees to the axes.
    pub(super) fn zigzag() -> LinePath {
        let (program, machine) = read(ZIGZAG);
        LinePath::of(&program, &machine).unwrap()
    }

    fn kept(planner: Planner, text: &str) -> f64 {
        let (program, machine) = read(text);
        let run = planner.run(&program, &machine).unwrap();
        assert_eq!(run.broken(), Vec::<String>::new(), "{planner:?}");
        run.time()
    }

    #[test]
    fn stops_keep_everything() {
        kept(Planner::ExactStop, CROOKED);
        let time = kept(Planner::ExactStop, ZIGZAG);
        // Both axes of a leg pull: the limits along it are greater by the root of 2.
        let (a, j) = (2000.0 * 2f64.sqrt(), 50_000.0 * 2f64.sqrt());
        let leg = (a / j).mul_add(a / j, 40.0 / a).sqrt() + a / j;
        assert!((time - 12.0 * leg).abs() < 2e-3, "{time}");
    }

    #[test]
    fn carrying_keeps_everything_and_beats_stops() {
        for text in [ZIGZAG, CROOKED] {
            assert!(kept(Planner::Uninterrupted, text) < 0.95 * kept(Planner::ExactStop, text));
        }
    }

    /// With these limits such corners may well be slower than stops: they are gone through with no acceleration along them.
    #[test]
    fn c4_corners_keep_everything() {
        assert!(kept(Planner::C4Corner, ZIGZAG) < 1.25 * kept(Planner::ExactStop, ZIGZAG));
        assert!(kept(Planner::C4Corner, CROOKED) < kept(Planner::ExactStop, CROOKED));
    }

    #[test]
    fn filters_keep_everything_and_beat_stops() {
        for text in [ZIGZAG, CROOKED] {
            assert!(kept(Planner::Filtered, text) < kept(Planner::ExactStop, text));
        }
    }

    /// Of a path that is dense the lines are merged, and the judge still finds the motion inside the band.
    #[test]
    fn dense_lines_are_merged() {
        let vertex = |k: i32| {
            let (y, x) = (0.01 * f64::from(k)).sin_cos();
            format!("{} {} 0 200", 10.0 * x, 10.0 * y)
        };
        let mut lines = vec!["# 200 2000 50000 0.05 0.001".to_owned()];
        lines.extend((0..=60).map(vertex));
        let text = lines.join("\n");
        let (program, machine) = read(&text);
        let path = LinePath::of(&program, &machine).unwrap();
        let thin = path.thinned(0.95, 1.0);
        assert!(thin.lines() < 5 && path.lines() == 60, "{}", thin.lines());
        assert!(kept(Planner::Uninterrupted, &text) < 0.6 * kept(Planner::ExactStop, &text));
    }

    #[test]
    fn what_is_not_modelled_is_refused() {
        let (mut program, machine) = read(ZIGZAG);
        program.moves[1].exact_stop = true;
        assert!(Planner::Filtered.run(&program, &machine).is_err());
    }
}
