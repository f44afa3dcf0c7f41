//! Every setpoint against the band and the axis limits, by finite differences, as an outsider who
//! sees only positions would.

use super::runner::{Observer, Sample};
use super::track::{Follower, Track};
use crate::machine::Axis;

/// Peaks of one axis, as ratios to its limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Peaks {
    /// Velocity, mm/s.
    pub velocity: f64,
    /// Acceleration, mm/s2.
    pub acceleration: f64,
    /// Jerk, mm/s3, by third differences of consecutive cycles.
    pub jerk: f64,
    /// Jerk over every fourth cycle, which rounding hardly disturbs.
    pub jerk4: f64,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Time from rest to rest, s.
    pub time: f64,
    /// Servo cycles.
    pub cycles: u64,
    /// Largest distance from the programmed path, mm.
    pub deviation: f64,
    /// Largest speed along the path, mm/s.
    pub path_speed: f64,
    /// Peaks per axis: mm and s.
    pub peaks: Vec<Peaks>,
    /// The same over the limits.
    pub ratios: Vec<Peaks>,
    /// Distance of the last setpoint from the programmed end, mm.
    pub end_error: f64,
}

impl Verdict {
    /// Largest ratio of any axis.
    pub fn worst(&self) -> Peaks {
        self.ratios.iter().fold(Peaks::default(), |worst, ratio| Peaks {
            velocity: worst.velocity.max(ratio.velocity),
            acceleration: worst.acceleration.max(ratio.acceleration),
            jerk: worst.jerk.max(ratio.jerk),
            jerk4: worst.jerk4.max(ratio.jerk4),
        })
    }
}

/// Differences over every fourth cycle reach back this many.
const BACK: usize = 13;

/// Watches a run.
#[derive(Debug)]
pub struct Judge<'a> {
    track: &'a Track,
    limits: &'a [Axis],
    cycle: f64,
    reach: f64,
    band: f64,
    follower: Follower,
    history: std::collections::VecDeque<Vec<f64>>,
    verdict: Verdict,
}

impl<'a> Judge<'a> {
    /// A judge of runs along `track`; `tolerance` (mm) only bounds where it looks.
    pub fn new(track: &'a Track, limits: &'a [Axis], cycle: f64, tolerance: f64) -> Self {
        Self {
            track,
            limits,
            cycle,
            // A sharp corner inside the band cuts off this much of the path.
            reach: 20.0 * tolerance + 0.02,
            band: tolerance * 1.001 + 1.0e-6,
            follower: Follower::default(),
            history: std::collections::VecDeque::with_capacity(BACK + 1),
            verdict: Verdict { peaks: vec![Peaks::default(); limits.len()], ..Verdict::default() },
        }
    }

    /// The findings.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = self.verdict.clone();
        verdict.time = verdict.cycles.saturating_sub(1) as f64 * self.cycle;
        verdict.ratios = verdict
            .peaks
            .iter()
            .zip(self.limits)
            .map(|(peak, limit)| Peaks {
                velocity: peak.velocity / limit.velocity,
                acceleration: peak.acceleration / limit.acceleration,
                jerk: peak.jerk / limit.jerk,
                jerk4: peak.jerk4 / limit.jerk,
            })
            .collect();
        if let Some(last) = self.history.back() {
            let end = self.track.end();
            verdict.end_error =
                end.iter().zip(last).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        }
        verdict
    }
}

impl Observer for Judge<'_> {
    fn setpoint(&mut self, sample: &Sample<'_>) -> anyhow::Result<()> {
        let x = &sample.position[..self.limits.len()];
        self.verdict.cycles += 1;
        let step = self.history.back().map_or(0.0, |before| {
            before.iter().zip(x).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
        });
        let off = self.follower.distance(self.track, x, self.reach + 2.0 * step, self.band);
        self.verdict.deviation = self.verdict.deviation.max(off);
        // The run starts and ends at rest: before its first setpoint it stood there.
        if self.history.is_empty() {
            self.history.extend(std::iter::repeat_n(x.to_vec(), BACK));
            return Ok(());
        }
        let mut slot = self.history.pop_front().unwrap_or_default();
        slot.clear();
        slot.extend_from_slice(x);
        self.history.push_back(slot);
        let h = self.cycle;
        let past = |back: usize, axis: usize| self.history[BACK - 1 - back][axis];
        let mut square = 0.0;
        for axis in 0..self.limits.len() {
            let p = |back: usize| past(back, axis);
            let v = (p(0) - p(1)) / h;
            let a = (p(0) - 2.0 * p(1) + p(2)) / (h * h);
            let third =
                |n: usize| (p(0) - 3.0 * p(n) + 3.0 * p(2 * n) - p(3 * n)) / (n as f64 * h).powi(3);
            let (j, j4) = (third(1), third(4));
            square += v * v;
            let peak = &mut self.verdict.peaks[axis];
            peak.velocity = peak.velocity.max(v.abs());
            peak.acceleration = peak.acceleration.max(a.abs());
            peak.jerk = peak.jerk.max(j.abs());
            peak.jerk4 = peak.jerk4.max(j4.abs());
        }
        self.verdict.path_speed = self.verdict.path_speed.max(square.sqrt());
        Ok(())
    }
}
