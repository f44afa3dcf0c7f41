//! One round: the least time of all motions near a given one, as a cone program.
//!
//! Unknown are, of every knot, position, velocity and acceleration, and of every block of intervals by how much their duration
//! changes. With the products of changes left out, the motion's equations are linear; limits of acceleration and jerk are,
//! and the place of the motion at every check is, too. A check far from both ends of a long line is kept in its band across
//! the line alone; elsewhere it is within the band of a point of the line, which is found as well (a second-order cone).

use super::motion::Motion;
use super::tube::{Check, Plan, Segment};
use crate::rows::Rows;
use anyhow::Result;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{NonnegativeConeT, SecondOrderConeT, SupportedConeT, ZeroConeT};
use splineway_simulator::machine::Axis;

/// Shares of the limits that are used: between knots and at the servo cycles there is a little more.
const SHARES: [f64; 3] = [0.9999, 0.9997, 0.9997];
/// Shortest interval, s.
const SHORTEST: f64 = 2.0e-4;
/// A speed or a velocity is bounded where it comes this near to its limit.
const NEAR: f64 = 0.7;
/// A line so many bands long has a middle, which begins this far from its ends: in bands, and mm more.
const LONG: f64 = 20.0;
const FROM_END: (f64, f64) = (3.0, 0.3);

/// What bounds a motion.
#[derive(Clone, Copy, Debug)]
pub struct Bounds<'a> {
    pub path: &'a [Segment],
    pub limits: &'a [Axis],
    /// Axes whose speeds make up the feed.
    pub feeding: &'a [bool],
}

/// A better motion, and by how much it leaves the band at most, in bands.
pub struct Better {
    pub motion: Motion,
    pub outside: f64,
}

/// Numbers of the unknowns.
#[derive(Clone, Copy)]
struct Unknowns {
    knots: usize,
    axes: usize,
    blocks: usize,
    along: usize,
}

impl Unknowns {
    fn position(self, k: usize, c: usize) -> usize {
        c * self.knots + k
    }
    fn velocity(self, k: usize, c: usize) -> usize {
        (self.axes + c) * self.knots + k
    }
    fn acceleration(self, k: usize, c: usize) -> usize {
        (2 * self.axes + c) * self.knots + k
    }
    fn duration(self, block: usize) -> usize {
        3 * self.axes * self.knots + block
    }
    fn along(self, n: usize) -> usize {
        self.duration(self.blocks) + n
    }
    fn slack(self) -> usize {
        self.along(self.along)
    }
    fn count(self) -> usize {
        self.slack() + 1
    }
}

/// One program: the motion in units in which its numbers are about 1.
struct Round<'a> {
    bounds: Bounds<'a>,
    plan: &'a Plan,
    motion: &'a Motion,
    /// Unit of time, s; durations of the intervals in it.
    unit: f64,
    durations: Vec<f64>,
    /// Unit of velocity, mm/s.
    speed: f64,
    /// Whether durations change.
    free: bool,
    unknowns: Unknowns,
}

impl Round<'_> {
    /// Unit of position, mm.
    fn length(&self) -> f64 {
        self.speed * self.unit
    }

    fn most_acceleration(&self, c: usize) -> f64 {
        self.bounds.limits[c].acceleration * SHARES[1]
    }

    /// What a unit of acceleration gains in a unit of time, in units of velocity.
    fn gain(&self, c: usize) -> f64 {
        self.most_acceleration(c) * self.unit / self.speed
    }

    fn velocity(&self, k: usize, c: usize) -> f64 {
        self.motion.velocity[k * self.motion.axes + c] / self.speed
    }

    fn acceleration(&self, k: usize, c: usize) -> f64 {
        self.motion.acceleration[k * self.motion.axes + c] / self.most_acceleration(c)
    }

    /// The motion's equations from knot to knot.
    fn equations(&self, rows: &mut Rows) {
        let x = self.unknowns;
        for c in 0..x.axes {
            let gain = self.gain(c);
            for k in 0..self.motion.steps() {
                let h = self.durations[k];
                let (a0, a1) = (self.acceleration(k, c), self.acceleration(k + 1, c));
                let mut velocity = vec![
                    (x.velocity(k + 1, c), 1.0),
                    (x.velocity(k, c), -1.0),
                    (x.acceleration(k, c), -gain * h / 2.0),
                    (x.acceleration(k + 1, c), -gain * h / 2.0),
                ];
                let mut position = vec![
                    (x.position(k + 1, c), 1.0),
                    (x.position(k, c), -1.0),
                    (x.velocity(k, c), -h),
                    (x.acceleration(k, c), -gain * h * h / 3.0),
                    (x.acceleration(k + 1, c), -gain * h * h / 6.0),
                ];
                if self.free {
                    let block = x.duration(self.plan.blocks[k]);
                    velocity.push((block, -gain * (a0 + a1) / 2.0));
                    let more = self.velocity(k, c) + gain * h * (2.0 * a0 + a1) / 3.0;
                    position.push((block, -more));
                }
                rows.push_scaled(velocity, 0.0, 1.0);
                rows.push_scaled(position, 0.0, 1.0);
            }
        }
    }

    /// At rest at both ends of the path.
    fn ends(&self, rows: &mut Rows) {
        let (x, last) = (self.unknowns, self.motion.steps());
        let path = self.bounds.path;
        let end = &path[path.len() - 1];
        for c in 0..x.axes {
            for k in [0, last] {
                let at = match k {
                    0 => path[0].from[c],
                    _ => end.from[c] + end.direction[c] * end.length,
                };
                rows.push_scaled([(x.position(k, c), 1.0)], at / self.length(), 1.0);
                rows.push_scaled([(x.velocity(k, c), 1.0)], 0.0, 1.0);
                rows.push_scaled([(x.acceleration(k, c), 1.0)], 0.0, 1.0);
            }
        }
    }

    /// Acceleration, jerk and velocity of every axis.
    fn limits(&self, rows: &mut Rows) {
        let x = self.unknowns;
        for (c, axis) in self.bounds.limits.iter().enumerate() {
            let jerk = axis.jerk * SHARES[2] * self.unit / self.most_acceleration(c);
            let most = axis.velocity * SHARES[0] / self.speed;
            for k in 0..x.knots {
                for sign in [1.0, -1.0] {
                    rows.push_scaled([(x.acceleration(k, c), sign)], 1.0, 1.0);
                    if self.velocity(k, c).abs() > NEAR * most {
                        rows.push_scaled([(x.velocity(k, c), sign)], most, 1.0);
                    }
                    if k + 1 == x.knots {
                        continue;
                    }
                    let mut row = vec![
                        (x.acceleration(k + 1, c), sign / jerk),
                        (x.acceleration(k, c), -sign / jerk),
                    ];
                    if self.free {
                        row.push((x.duration(self.plan.blocks[k]), -1.0));
                    }
                    rows.push_scaled(row, self.durations[k], 1.0);
                }
            }
        }
    }

    /// How much durations may change: a share, and not below the shortest.
    fn trust(&self, rows: &mut Rows, share: f64) {
        if !self.free {
            return;
        }
        let (mut sums, mut counts) =
            (vec![0.0; self.unknowns.blocks], vec![0.0; self.unknowns.blocks]);
        for (block, h) in self.plan.blocks.iter().zip(&self.durations) {
            sums[*block] += h;
            counts[*block] += 1.0;
        }
        for block in 0..self.unknowns.blocks {
            let mean: f64 = sums[block] / counts[block];
            let less = (mean * share).min((mean - SHORTEST / self.unit).max(0.0));
            rows.push_scaled([(self.unknowns.duration(block), 1.0)], mean * share, 1.0);
            rows.push_scaled([(self.unknowns.duration(block), -1.0)], less, 1.0);
        }
    }

    /// The position of axis `c` at a check, times a factor.
    fn place(&self, check: &Check, c: usize, factor: f64) -> Vec<(usize, f64)> {
        let (x, k, f) = (self.unknowns, check.interval, check.share);
        let (h, gain) = (self.durations[k], self.gain(c));
        let (a0, a1) = (self.acceleration(k, c), self.acceleration(k + 1, c));
        let cube = f * f * f / 6.0;
        let mut row = vec![
            (x.position(k, c), factor),
            (x.velocity(k, c), factor * f * h),
            (x.acceleration(k, c), factor * gain * h * h * (f * f / 2.0 - cube)),
            (x.acceleration(k + 1, c), factor * gain * h * h * cube),
        ];
        if self.free {
            let more = gain * h * (f * f * a0 + f * f * f * (a1 - a0) / 3.0);
            row.push((x.duration(self.plan.blocks[k]), factor * (f * self.velocity(k, c) + more)));
        }
        row
    }

    /// Across a line in the plane: two rows.
    fn across(&self, rows: &mut Rows, check: &Check) {
        let segment = &self.bounds.path[check.segment];
        let band = segment.band * check.part;
        let normal = [-segment.direction[1], segment.direction[0]];
        let offset = (segment.from[0] * normal[0] + segment.from[1] * normal[1]) / band;
        for sign in [1.0, -1.0] {
            let per = sign * self.length() / band;
            let mut row = self.place(check, 0, per * normal[0]);
            row.extend(self.place(check, 1, per * normal[1]));
            row.push((self.unknowns.slack(), -1.0));
            rows.push_scaled(row, 1.0 + sign * offset, 1.0);
        }
    }

    /// Across a line in space: a cone over the part of the distance that is not along it.
    fn around(&self, rows: &mut Rows, check: &Check) {
        let segment = &self.bounds.path[check.segment];
        let band = segment.band * check.part;
        let d = &segment.direction;
        rows.push_scaled([(self.unknowns.slack(), -1.0)], 1.0, 1.0);
        for c in 0..d.len() {
            let (mut row, mut offset) = (Vec::new(), 0.0);
            for e in 0..d.len() {
                let share = f64::from(u8::from(c == e)) - d[c] * d[e];
                row.extend(self.place(check, e, -share * self.length() / band));
                offset += share * segment.from[e];
            }
            rows.push_scaled(row, -offset / band, 1.0);
        }
    }

    /// Within the band of a point of a line, the `n`th that is found.
    fn beside(&self, rows: &mut Rows, check: &Check, n: usize) {
        let segment = &self.bounds.path[check.segment];
        let band = segment.band * check.part;
        rows.push_scaled([(self.unknowns.slack(), -1.0)], 1.0, 1.0);
        for c in 0..segment.direction.len() {
            let mut row = self.place(check, c, -self.length() / band);
            let per = segment.direction[c] * segment.length / band;
            row.push((self.unknowns.along(n), per));
            rows.push_scaled(row, -segment.from[c] / band, 1.0);
        }
    }

    /// The knots at which the speed comes near to the feed.
    fn fast(&self) -> Vec<(usize, f64)> {
        let d = self.motion.axes;
        (0..self.unknowns.knots)
            .filter_map(|k| {
                let feed = self.bounds.path[self.plan.segments[k]].feed * SHARES[0] / self.speed;
                let square =
                    (0..d).filter(|c| self.bounds.feeding[*c]).map(|c| self.velocity(k, c).powi(2));
                (square.sum::<f64>().sqrt() > NEAR * feed).then_some((k, feed))
            })
            .collect()
    }

    fn result(&self, x: &[f64]) -> Better {
        let (unknowns, d) = (self.unknowns, self.motion.axes);
        let mut motion = Motion::new(d);
        let mut time = 0.0;
        for k in 0..unknowns.knots {
            let of = |number: usize, unit: f64| x[number] * unit;
            let position: Vec<f64> =
                (0..d).map(|c| of(unknowns.position(k, c), self.length())).collect();
            let velocity: Vec<f64> =
                (0..d).map(|c| of(unknowns.velocity(k, c), self.speed)).collect();
            let acceleration: Vec<f64> = (0..d)
                .map(|c| of(unknowns.acceleration(k, c), self.most_acceleration(c)))
                .collect();
            motion.push(time, [&position, &velocity, &acceleration]);
            if k + 1 < unknowns.knots {
                let more = if self.free { x[unknowns.duration(self.plan.blocks[k])] } else { 0.0 };
                time += (self.durations[k] + more) * self.unit;
            }
        }
        Better { motion, outside: x[unknowns.slack()] }
    }
}

/// Whether a check lies so far from both ends of a long line that only the distance across it counts.
fn is_amid(segment: &Segment, x: &[f64]) -> bool {
    let along = segment.distance(x).1;
    let from_end = FROM_END.0 * segment.band + FROM_END.1;
    segment.length > LONG * segment.band && along > from_end && along < segment.length - from_end
}

/// The best motion near one, whose durations change by a share of at most `trust`; with none, the motion that leaves the band
/// least.
///
/// # Errors
/// The program has no solution.
pub fn round(
    bounds: Bounds<'_>,
    motion: &Motion,
    plan: &Plan,
    trust: Option<f64>,
) -> Result<Better> {
    let (steps, d) = (motion.steps(), motion.axes);
    let unit = motion.duration() / steps as f64;
    let (amid, beside): (Vec<Check>, Vec<Check>) = plan.checks.iter().partition(|check| {
        is_amid(&bounds.path[check.segment], &motion.within(check.interval, check.share))
    });
    let blocks = trust.map_or(0, |_| plan.blocks[steps - 1] + 1);
    let unknowns = Unknowns { knots: steps + 1, axes: d, blocks, along: beside.len() };
    let speed = bounds.limits.iter().map(|axis| axis.velocity).fold(0.0, f64::max);
    let durations = (0..steps).map(|k| motion.step(k) / unit).collect();
    let free = trust.is_some();
    let round = Round { bounds, plan, motion, unit, durations, speed, free, unknowns };
    let mut rows = Rows::default();
    round.equations(&mut rows);
    round.ends(&mut rows);
    let equations = rows.len();
    round.limits(&mut rows);
    round.trust(&mut rows, trust.unwrap_or(0.0));
    if d == 2 {
        for check in &amid {
            round.across(&mut rows, check);
        }
    }
    rows.push_scaled([(unknowns.slack(), -1.0)], 0.0, 1.0);
    for n in 0..beside.len() {
        rows.push_scaled([(unknowns.along(n), 1.0)], 1.0, 1.0);
        rows.push_scaled([(unknowns.along(n), -1.0)], 0.0, 1.0);
    }
    let mut cones: Vec<SupportedConeT<f64>> =
        vec![ZeroConeT(equations), NonnegativeConeT(rows.len() - equations)];
    for (k, feed) in round.fast() {
        rows.push_scaled([], feed, 1.0);
        let feeding = (0..d).filter(|c| bounds.feeding[*c]);
        let mut size = 1;
        for c in feeding {
            rows.push_scaled([(unknowns.velocity(k, c), -1.0)], 0.0, 1.0);
            size += 1;
        }
        cones.push(SecondOrderConeT(size));
    }
    if d > 2 {
        for check in &amid {
            round.around(&mut rows, check);
            cones.push(SecondOrderConeT(d + 1));
        }
    }
    for (n, check) in beside.iter().enumerate() {
        round.beside(&mut rows, check, n);
        cones.push(SecondOrderConeT(d + 1));
    }
    let count = unknowns.count();
    let mut cost = vec![0.0; count];
    if free {
        for block in &plan.blocks {
            cost[unknowns.duration(*block)] += 1.0 / steps as f64;
        }
    }
    cost[unknowns.slack()] = 1.0;
    let nothing = CscMatrix::new_from_triplets(count, count, vec![], vec![], vec![]);
    let x = rows.minimise(&nothing, &cost, &cones)?;
    Ok(round.result(&x))
}
