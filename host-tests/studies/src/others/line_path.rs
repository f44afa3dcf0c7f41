//! A path of lines, as every model of this folder takes it.

use crate::anymotion::motion::State;
use anyhow::{Result, bail, ensure};
use splineway_simulator::judge::{Follower, Track};
use splineway_simulator::machine::{Axis, Machine};
use splineway_simulator::program::{Course, Point, Program, Speed};
use splineway_simulator::run::duration::fed;
use splineway_simulator::scurve::Limit;

/// Lines with the limits of the machine that runs them.
#[derive(Clone, Debug)]
pub struct LinePath {
    /// Vertices over the axes in use, mm.
    pub points: Vec<Vec<f64>>,
    /// Unit direction of every line.
    pub directions: Vec<Vec<f64>>,
    /// Length of every line, mm.
    pub lengths: Vec<f64>,
    /// Greatest speed along every line, mm/s: its feed, or what its axes can.
    pub feeds: Vec<f64>,
    /// Tolerance, mm.
    pub band: f64,
    /// What a corner may leave the lines by, at every vertex, mm.
    pub bands: Vec<f64>,
    /// Limits of the axes.
    pub limits: Vec<Axis>,
    /// Servo cycle, s.
    pub cycle: f64,
}

impl LinePath {
    /// The path of a program. The cost is one pass.
    ///
    /// # Errors
    /// It has something else than lines that are run without a stop, or nothing moves.
    pub fn of(program: &Program, machine: &Machine) -> Result<Self> {
        let axes = program.axes();
        let limits = machine.axes_of(program)?;
        let over = |point: &Point| -> Vec<f64> { axes.iter().map(|&axis| point[axis]).collect() };
        ensure!(program.exact.is_empty(), "other planners are modelled on lines, not on curves");
        let (mut points, mut feeds) = (vec![over(&program.start)], Vec::new());
        let mut band = f64::INFINITY;
        for step in &program.moves {
            let Course::Line { to } = &step.path else {
                bail!("line {}: other planners are modelled on lines only", step.line);
            };
            ensure!(!step.exact_stop, "line {}: stops are not modelled", step.line);
            let to = over(to);
            let way: Vec<f64> = plus(&to, -1.0, &points[points.len() - 1]);
            let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length < 1e-9 {
                continue;
            }
            feeds.push(match step.speed {
                Speed::PerSecond(feed) => feed * length / fed(&way, &axes),
                Speed::Duration(seconds) => length / seconds,
                Speed::Rapid => f64::INFINITY,
            });
            band = band.min(step.tolerance.unwrap_or(machine.tolerance));
            points.push(to);
        }
        ensure!(!feeds.is_empty(), "nothing moves");
        ensure!(band > 0.0, "a tolerance of 0 leaves no corner but a stop");
        let bands = vec![band; points.len()];
        Ok(Self::new(points, feeds, (band, bands), limits, machine.cycle))
    }

    fn new(
        points: Vec<Vec<f64>>,
        feeds: Vec<f64>,
        (band, bands): (f64, Vec<f64>),
        limits: Vec<Axis>,
        cycle: f64,
    ) -> Self {
        let lengths: Vec<f64> = points.windows(2).map(|pair| apart(&pair[0], &pair[1])).collect();
        let unit = |(pair, length): (&[Vec<f64>], &f64)| -> Vec<f64> {
            pair[1].iter().zip(&pair[0]).map(|(b, a)| (b - a) / length).collect()
        };
        let directions: Vec<_> = points.windows(2).zip(&lengths).map(unit).collect();
        let within = |(feed, direction): (f64, &Vec<f64>)| {
            feed.min(along(direction, &limits, |axis| axis.velocity))
        };
        let feeds = feeds.into_iter().zip(&directions).map(within).collect();
        Self { points, directions, lengths, feeds, band, bands, limits, cycle }
    }

    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.lengths.len()
    }

    /// Limits along a line.
    pub fn limit(&self, line: usize) -> Limit {
        limit(&self.directions[line], &self.limits)
    }

    /// Turn at the end of a line, rad.
    pub fn turn(&self, line: usize) -> f64 {
        let (a, b) = (&self.directions[line], &self.directions[line + 1]);
        // Of nearly parallel directions the cosine says nothing.
        let (sum, gap) = (|x: &f64, y: &f64| x + y, |x: &f64, y: &f64| x - y);
        let size = |of: &dyn Fn(&f64, &f64) -> f64| {
            a.iter().zip(b).map(|(x, y)| of(x, y).powi(2)).sum::<f64>().sqrt()
        };
        2.0 * size(&gap).atan2(size(&sum))
    }

    /// The same with as few lines as leave it by no more than a share of the band; corners have what is left of it, if
    /// the lines' own deviation is `counted` by so much (1: all of it. But it is greatest where the corners are not).
    /// Every line is as long as it can be, from the first on (LinuxCNC calls it the naive CAM detector). The cost is one
    /// pass for every line that is left.
    #[must_use]
    pub fn thinned(&self, share: f64, counted: f64) -> Self {
        if share <= 0.0 {
            return self.clone();
        }
        let (mut points, mut feeds) = (vec![self.points[0].clone()], Vec::new());
        let mut offs = Vec::new();
        let mut start = 0;
        while start < self.lines() {
            let fits = |end: &usize| self.off(start, *end) <= share * self.band;
            let end = (start + 2..self.points.len()).take_while(fits).last().unwrap_or(start + 1);
            points.push(self.points[end].clone());
            feeds.push(self.feeds[start..end].iter().copied().fold(f64::INFINITY, f64::min));
            offs.push(self.off(start, end));
            start = end;
        }
        let off = |k: usize| offs[k.saturating_sub(1)..(k + 1).min(offs.len())].iter().copied();
        let band = |k: usize| self.band - counted * off(k).fold(0.0, f64::max);
        let bands = (0..points.len()).map(band).collect();
        Self::new(points, feeds, (self.band, bands), self.limits.clone(), self.cycle)
    }

    /// Whether setpoints of a motion keep to the band of the path that this one stands for, as the judge follows it.
    pub fn keeps(&self, states: &[State], track: &Track) -> bool {
        let mut follower = Follower::default();
        let mut before = &states[0];
        states.iter().all(|state| {
            let step = apart(&before[0], &state[0]);
            before = state;
            let reach = 20.0 * self.band + 0.02 + 2.0 * step;
            follower.look(track, &state[0], reach, self.band).outside.distance <= 0.0
        })
    }

    /// Greatest distance of vertices from the chord between two of them, mm; infinite if they do not go forward along it.
    fn off(&self, start: usize, end: usize) -> f64 {
        let (from, to) = (&self.points[start], &self.points[end]);
        let length = apart(from, to);
        let (mut most, mut way) = (0.0f64, 0.0);
        for point in &self.points[start + 1..end] {
            let parts = point.iter().zip(from).zip(to);
            let along: f64 = parts.map(|((x, a), b)| (x - a) * (b - a)).sum::<f64>() / length;
            if !(along >= way && along <= length) {
                return f64::INFINITY;
            }
            way = along;
            most = most.max((apart(point, from).powi(2) - along * along).max(0.0).sqrt());
        }
        most
    }
}

/// Distance of two points.
pub(super) fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Greatest value along a direction that leaves every axis within its own.
pub(super) fn along(direction: &[f64], limits: &[Axis], of: fn(&Axis) -> f64) -> f64 {
    let most = |(d, limit): (&f64, &Axis)| of(limit) / d.abs().max(1e-12);
    direction.iter().zip(limits).map(most).fold(f64::INFINITY, f64::min)
}

/// Greatest acceleration and jerk along a direction.
pub(super) fn limit(direction: &[f64], limits: &[Axis]) -> Limit {
    Limit {
        acceleration: along(direction, limits, |axis| axis.acceleration),
        jerk: along(direction, limits, |axis| axis.jerk),
    }
}

/// `a` + `factor` `b`.
pub(super) fn plus(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

/// A vector times a factor.
pub(super) fn times(factor: f64, a: &[f64]) -> Vec<f64> {
    a.iter().map(|a| factor * a).collect()
}
