//! Trapezoids as filtered pulses: every block is a rectangular pulse of velocity, and two moving averages make it a motion with
//! limited acceleration and jerk.
//!
//! Written from Tajima, Sencer and Shamoto, "Accurate interpolation of machining tool-paths based on FIR filtering" (2018), after
//! Sencer, Ishizaki and Shamoto, "High speed cornering strategy with confined contour error and vibration suppression for CNC
//! machine tools" (2015). With the averages' times T1 and T2 a block at feed F has the acceleration F / T1 and the jerk F / (T1
//! T2), and takes T1 + T2 longer than its pulse; the pulse of the next block begins in that time, which rounds the corner. The
//! delay between the pulses is the shortest that keeps the band, found on the closed form of both blocks' motion. Times are whole
//! servo cycles; pulses are not.
//!
//! What is ours: where blocks are shorter than the filter, several corners act together; wherever band or limits are then not kept,
//! feeds are lowered a little (or delays made longer between long blocks), until all is kept. The papers lower the feed of short
//! blocks too, by other rules. The feed that the filter is made for, and what counts as long, is the best of a row.

use super::filter::{Choice, Filter};
use super::line_path::{LinePath, apart, plus, times};
use crate::anymotion::motion::State;
use anyhow::{Context, Result};
use splineway_simulator::judge::{Follower, Track};

/// The feeds that the filter is made for: the highest, and by these shares lower.
const FEEDS: i32 = 14;
const LOWER: f64 = 0.84;
/// How much longer the second average is than the jerk of one block demands: where an axis takes part in two blocks, there is
/// room then for both.
const LONGER: [f64; 3] = [1.0, 1.5, 2.0];
/// Blocks whose pulses are longer than so many times the filter are joined by delays; shorter ones have their feeds lowered.
const LONG: [f64; 3] = [0.5, 2.0, 0.0];
/// Rounds of repair, and what changes in each, first roughly, then in those that have come out best: feeds by a factor, delays by a
/// share of the filter's time.
const ROUNDS: usize = 300;
const STEPS: [f64; 2] = [0.06, 0.01];
const BEST: usize = 3;
/// What is kept of limits and band.
const KEPT: f64 = 1.0 - 1.0e-4;

/// The pulses of all blocks.
struct Train<'a> {
    path: &'a LinePath,
    choice: Choice,
    filter: Filter,
    feeds: Vec<f64>,
    /// Between every pulse and the next, s.
    delays: Vec<f64>,
    /// When pulses begin and end: time and vertex.
    edges: Vec<(f64, usize)>,
}

impl<'a> Train<'a> {
    fn new(path: &'a LinePath, choice: Choice) -> Self {
        let filter = Filter::new(path, choice);
        let feeds: Vec<f64> = path.feeds.iter().map(|feed| feed.min(choice.feed)).collect();
        let delays = vec![0.0; path.lines() - 1];
        let mut train = Self { path, choice, filter, feeds, delays, edges: Vec::new() };
        for line in 0..path.lines() - 1 {
            // Between short blocks the closed form says nothing.
            if train.is_long(line) && train.is_long(line + 1) {
                let feeds = [train.feeds[line], train.feeds[line + 1]];
                train.delays[line] = filter.delay(feeds, path.turn(line), path.band * KEPT);
            }
        }
        train.lay();
        train
    }

    fn is_long(&self, line: usize) -> bool {
        let time = self.path.lengths[line] / self.feeds[line];
        time >= self.choice.long * self.filter.whole()
    }

    fn lay(&mut self) {
        self.edges.clear();
        let mut time = 0.0;
        for (line, feed) in self.feeds.iter().enumerate() {
            self.edges.push((time, line));
            time += self.path.lengths[line] / feed;
            self.edges.push((time, line + 1));
            time += self.delays.get(line).unwrap_or(&0.0);
        }
    }

    fn duration(&self) -> f64 {
        self.edges[self.edges.len() - 1].0 + self.filter.whole()
    }

    /// Where the pulses themselves have come to, and the edge before.
    fn pulses(&self, time: f64) -> (Vec<f64>, usize) {
        let after = self.edges.partition_point(|(edge, _)| *edge <= time);
        let points = &self.path.points;
        if after == 0 {
            return (points[0].clone(), 0);
        }
        let (begin, vertex) = self.edges[after - 1];
        let at = match self.edges.get(after) {
            Some(&(_, next)) if next != vertex => {
                let way = (time - begin) * self.feeds[vertex];
                plus(&points[vertex], way, &self.path.directions[vertex])
            }
            _ => points[vertex].clone(),
        };
        (at, after)
    }

    /// The filtered state: with X the pulses' way, Y its integral and Z that of Y, from T1 + T2 before on,
    /// x(t) = (Z(t) - Z(t - T1) - Z(t - T2)) / (T1 T2), and so for velocity and acceleration with Y and X.
    fn state(&self, time: f64) -> State {
        let Filter { first, second } = self.filter;
        let (base, mut edge) = self.pulses(time - self.filter.whole());
        let zero = vec![0.0; base.len()];
        let mut sums = [zero.clone(), zero.clone(), zero.clone()];
        // X, Y and Z at a place that moves on.
        let mut now = (time - self.filter.whole(), [zero.clone(), zero.clone(), zero]);
        for (stop, sign) in
            [(first.min(second), -1.0), (first.max(second), -1.0), (first + second, 1.0)]
        {
            let stop = time - self.filter.whole() + stop;
            loop {
                let next = self.edges.get(edge).map_or(f64::INFINITY, |(next, _)| *next);
                self.integrate(&mut now, edge, next.min(stop));
                if next > stop {
                    break;
                }
                edge += 1;
            }
            for (sum, value) in sums.iter_mut().zip(&now.1) {
                *sum = plus(sum, sign, value);
            }
        }
        let [x, y, z] = sums.map(|sum| times(1.0 / (first * second), &sum));
        [plus(&base, 1.0, &z), y, x]
    }

    /// Goes on to a time behind no further edge than the one before `edge`.
    fn integrate(&self, (now, [x, y, z]): &mut (f64, [Vec<f64>; 3]), edge: usize, to: f64) {
        let h = to - *now;
        *now = to;
        // Pulses begin at even edges.
        let moves = edge % 2 == 1;
        for axis in 0..x.len() {
            let line = edge / 2;
            let v = if moves { self.feeds[line] * self.path.directions[line][axis] } else { 0.0 };
            z[axis] += h * (y[axis] + h * (x[axis] / 2.0 + h * v / 6.0));
            y[axis] += h * (x[axis] + h * v / 2.0);
            x[axis] += h * v;
        }
    }

    fn states(&self) -> Vec<State> {
        let cycles = (self.duration() / self.path.cycle - 1e-6).ceil() as usize;
        (0..=cycles).map(|k| self.state(k as f64 * self.path.cycle)).collect()
    }

    /// Times at which band or limits are not kept.
    fn broken(&self, states: &[State], track: &Track) -> Vec<f64> {
        let (cycle, band) = (self.path.cycle, self.path.band);
        let mut follower = Follower::default();
        let mut found = Vec::new();
        let mut before: Option<&State> = None;
        for (k, state) in states.iter().enumerate() {
            let last = before.unwrap_or(state);
            let step = apart(&last[0], &state[0]);
            let off = follower.look(track, &state[0], 20.0 * band + 0.02 + 2.0 * step, band);
            let beyond = |(axis, limit): (usize, &splineway_simulator::machine::Axis)| {
                let jerk = (state[2][axis] - last[2][axis]) / cycle;
                state[2][axis].abs() > limit.acceleration / KEPT || jerk.abs() > limit.jerk / KEPT
            };
            let mut axes = self.path.limits.iter().enumerate();
            if off.outside.distance > 0.0 || axes.any(beyond) {
                found.push(k as f64 * cycle);
            }
            before = Some(state);
        }
        found
    }

    /// Makes slower, or later, by a step, what the filter sees at some times.
    fn repair(&mut self, broken: &[f64], step: f64) {
        let whole = self.filter.whole();
        let (mut slow, mut late) = (vec![false; self.feeds.len()], vec![false; self.delays.len()]);
        for time in broken {
            let first = self.edges.partition_point(|(edge, _)| *edge < time - whole);
            let last = self.edges.partition_point(|(edge, _)| *edge <= *time);
            for edge in first.saturating_sub(1)..last {
                let line = edge / 2;
                // The delay that begins or ends there, if both blocks are long.
                let join = if edge % 2 == 1 { Some(line) } else { line.checked_sub(1) };
                let join = join.filter(|&join| {
                    join + 1 < self.feeds.len()
                        && self.is_long(join)
                        && self.is_long(join + 1)
                        && self.delays[join] < whole
                });
                match join {
                    Some(join) => late[join] = true,
                    None => slow[line] = true,
                }
            }
        }
        for (feed, _) in self.feeds.iter_mut().zip(&slow).filter(|(_, slow)| **slow) {
            *feed *= 1.0 - step;
        }
        for (delay, _) in self.delays.iter_mut().zip(&late).filter(|(_, late)| **late) {
            *delay = (*delay + step / 2.0 * whole).min(whole);
        }
        self.lay();
    }

    /// Repairs until all is kept, if that comes to less than `most` cycles.
    fn settle(&mut self, track: &Track, step: f64, most: f64) -> Option<Vec<State>> {
        for _ in 0..ROUNDS {
            if self.duration() >= most * self.path.cycle {
                return None;
            }
            let states = self.states();
            let broken = self.broken(&states, track);
            if broken.is_empty() {
                return Some(states);
            }
            self.repair(&broken, step);
        }
        None
    }
}

/// The states in every servo cycle. The cost is that of some hundred motions.
///
/// # Errors
/// None of the filters can be made to keep everything.
pub fn states(path: &LinePath, track: &Track) -> Result<Vec<State>> {
    let highest = path.feeds.iter().copied().fold(0.0, f64::max);
    let mut choices = Vec::new();
    for long in LONG {
        for longer in LONGER {
            let feed = |n: i32| highest * LOWER.powi(n);
            choices.extend((0..FEEDS).map(|n| Choice { feed: feed(n), longer, long }));
        }
    }
    let mut best: Vec<(Vec<State>, Choice)> = Vec::new();
    for choice in choices {
        let most = best.get(BEST - 1).map_or(f64::INFINITY, |(states, _)| states.len() as f64);
        let found = Train::new(path, choice).settle(track, STEPS[0], most);
        best.extend(found.map(|states| (states, choice)));
        best.sort_by_key(|(states, _)| states.len());
        best.truncate(BEST);
    }
    let finer = |(states, choice): &(Vec<State>, Choice)| {
        Train::new(path, *choice).settle(track, STEPS[1], states.len() as f64)
    };
    let fine: Vec<_> = best.iter().filter_map(finer).collect();
    let rough = best.into_iter().map(|(states, _)| states);
    let all = rough.chain(fine).min_by_key(Vec::len);
    all.context("no filter was found that keeps limits and band")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::others::tests::zigzag;

    /// A block takes its pulse and the filter; half way of both it is half way, with F / T1 at most.
    #[test]
    fn a_block_is_a_filtered_pulse() {
        let mut path = zigzag();
        let choice = Choice { feed: 100.0, longer: 1.0, long: 0.0 };
        let mut train = Train::new(&path, choice);
        train.delays.fill(train.filter.whole());
        train.lay();
        let time = path.lengths[0] / train.feeds[0] + train.filter.whole();
        let [x, v, a] = train.state(time);
        assert!(apart(&x, &path.points[1]) < 1e-12);
        assert!(v.iter().chain(&a).all(|value| value.abs() < 1e-9));
        let half = plus(&path.points[0], path.lengths[0] / 2.0, &path.directions[0]);
        assert!(apart(&train.state(time / 2.0)[0], &half) < 1e-12);
        let whole = train.filter.whole();
        path.limits[0].jerk = 1.0;
        assert!(Filter::new(&path, choice).whole() > whole);
    }
}
