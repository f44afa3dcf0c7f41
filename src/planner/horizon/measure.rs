//! Times and distances in the horizon: what the agreed plan takes, and what a change of speed would.

use super::{Horizon, Moment};
use crate::machine::{LEAST_CYCLE_SHARE, Limits};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::number::vector::norm;
use crate::planner::phase::Halt;
use crate::profile::bounds::Bounds;
use crate::profile::law::{Law, PathState};
use crate::profile::solver::Stretch;

/// A cell that takes so many times as long as with stops at both ends is a crawl.
const CRAWL: f64 = 10.0;
/// One that takes so many times as long as it does in the agreed motion, at most, takes as long.
const AS_LONG: f64 = 1.1;
/// Share of the least duration of a cell that one takes at least, for its rounding.
const BARELY: f64 = 0.97;
/// Share of its speed that a motion must have left after letting go of the brake, to be taken on.
const LEAST_LEFT: f64 = 0.3;
/// So many braking distances before the end of a plan its motion is not what it would be without the stop there.
const SHOWN: f64 = 1.1;
/// v^2 falls by more than this factor over a cell where a motion slows down.
const SLOWER: f64 = 1.002;
/// Nodes of the path lie at least as far apart as jerk takes a motion from rest in this many servo cycles:
/// nearer ones would be passed no faster than they lie apart.
const APART_CYCLES: f64 = 2.0;
/// Servo cycles within which a rest is as near as an answer.
const IN_A_MOMENT: f64 = 2.0;

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// How long the agreed plan takes for the cell of station `i`, s; 0 if there is none.
    #[inline(never)]
    pub fn agreed_time(&self, i: usize) -> S {
        self.window.pair(i).map_or(S::ZERO, |(station, next)| station.agreed_time(next))
    }

    /// The node from which a new plan can branch off: a lead ahead of the motion, or half of what is left
    /// of the plan if that is less; but not before the plan will be there, `planned` s from the end of the piece under way, of
    /// the cells that it would be looked for over. At its end the motion would rest.
    pub fn branch(&self, at: NodeSerial, planned: impl Fn(usize) -> S) -> Option<NodeSerial> {
        let end = self.end_index();
        let mut first = self.window.clamped_index(at) + 1;
        if let Some(even) = self.even_from(at) {
            first = first.max(self.window.clamped_index(even));
        }
        let mut left = S::ZERO;
        for i in first..end {
            left += self.agreed_time(i);
        }
        let lead = self.config.lead.least(left * S::of(0.5));
        let last = self.window.len() - 1;
        let mut time = S::ZERO;
        for i in first..=end {
            if time >= lead.greatest(planned(last - i)) || i == end {
                return Some(if self.is_stopping(i) { self.end } else { self.window.serial(i) });
            }
            time += self.agreed_time(i);
        }
        None
    }

    /// The node, not before station `first`, from which on the motion shows that the agreed plan ends at rest: from
    /// which a stop would take about all that is left of it, and no further than where it slows down to its end.
    pub fn shown_from(&self, first: usize) -> NodeSerial {
        let end = self.end_index();
        let mut left = S::ZERO;
        let mut slows = end;
        for i in (first..end).rev() {
            let Some((station, after)) = self.window.pair(i) else { break };
            left += station.cell.length;
            if slows == i + 1 && station.agreed.b > after.agreed.b * S::of(SLOWER) {
                slows = i;
            }
        }
        let mut shown = first;
        while shown < slows && left > self.braking_distance(shown) * S::of(SHOWN) {
            left -= self.window.get(shown).map_or(S::ZERO, |station| station.cell.length);
            shown += 1;
        }
        self.window.serial(shown)
    }

    /// Whether the agreed plan takes less than this time, s, from the end of the piece under way to a node. Looks no
    /// further than it must.
    pub fn reaches_within(&self, limit: S, at: NodeSerial, node: NodeSerial) -> bool {
        let cells = self.window.clamped_index(at) + 1..self.window.clamped_index(node);
        self.window.takes_less(cells, limit)
    }

    /// Whether the agreed motion comes to a rest before an answer can take effect, or in a moment behind: looked at from there the rest would have
    /// been passed.
    #[inline(never)]
    pub fn rests_before(&self, Moment { timeline: line, when }: Moment<S>) -> bool {
        let passed = when.since(line.began).map_or(S::ZERO, S::from_u32);
        let mut left = line.lag + (passed + S::of(IN_A_MOMENT)) * self.config.cycle;
        let end = self.end_index();
        for i in self.window.clamped_index(line.serial)..end {
            left -= self.agreed_time(i);
            if left < S::ZERO {
                return false;
            }
            if i + 1 == end || self.window.get(i + 1).is_some_and(|station| station.rest) {
                return true;
            }
        }
        false
    }

    /// The stretch from a branch to the end of the plan, or to the first rest in it.
    #[inline(never)]
    pub fn stretch_from(&self, first: usize) -> Stretch {
        let end = self.end_index();
        let rests = |i: &usize| self.window.get(*i).is_some_and(|station| station.rest);
        let last = (first + 1..end).find(rests).unwrap_or(end);
        Stretch { first, last, open: false }
    }

    /// Whether the node under way, and the motion with it, stands still.
    pub fn stands(&self, at: NodeSerial) -> bool {
        let cell =
            self.window.get(self.window.clamped_index(at)).map(|station| station.cell.length);
        at != self.end && cell.is_some_and(|length| !(length > S::ZERO))
    }

    /// The first node behind station `first` at which a block ends.
    pub fn block_end(&self, first: usize) -> Option<usize> {
        (first + 1..self.window.len()).find(|&i| self.ends_block(i))
    }

    /// The node at which the block under way ends, if the agreed plan rests there.
    pub fn agreed_block_end(&self, at: NodeSerial) -> Option<NodeSerial> {
        let i = self.block_end(self.window.clamped_index(at))?;
        let rests = i <= self.end_index() && self.window.get(i).is_some_and(|end| end.rest);
        rests.then(|| self.window.serial(i))
    }

    /// Whether a block ends at station `i`.
    pub fn ends_block(&self, i: usize) -> bool {
        self.window.ends_block(i) == Some(true)
    }

    /// What a halt is that rests at station `i`.
    pub fn halt_at(&self, i: usize, halt: Halt) -> Halt {
        if halt == Halt::Short && self.ends_block(i) { Halt::Block } else { halt }
    }

    /// Whether from station `first` on the plan does nothing but come to rest where it ends: even if it let
    /// go of the brake as fast as the limits allow, hardly any speed would be left. To go on from there without
    /// that rest would save nothing, and a motion that all but rests in the middle is one that
    /// no solver gets going again.
    #[inline(never)]
    pub fn is_stopping(&self, first: usize) -> bool {
        let end = self.end_index();
        first < end
            && (first..end).all(|i| {
                let Some(from) = self.window.get(i) else { return false };
                let PathState { b, a } = from.agreed;
                let least = S::of(2.0 * (1.0 - LEAST_LEFT)) * from.bounds.jerk * b.sqrt();
                from.cell.length > S::ZERO && a < S::ZERO && a * a > least
            })
    }

    /// The first cell in a stretch that the motion crawls through.
    pub fn crawl_in(&self, stretch: Stretch) -> Option<usize> {
        (stretch.first..stretch.last).find(|&i| self.crawls(stretch, i))
    }

    /// Whether the motion crawls through a cell of a stretch for which the agreed one does not take as long.
    pub fn crawls_anew(&self, stretch: Stretch) -> bool {
        (stretch.first..stretch.last)
            .any(|i| self.crawls(stretch, i) && self.time(i) > self.agreed_time(i) * S::of(AS_LONG))
    }

    /// Whether the motion crawls through a cell of a stretch: that takes many times as long as stopping at both its ends would, and longer than the feed
    /// asks for.
    #[inline(never)]
    fn crawls(&self, stretch: Stretch, i: usize) -> bool {
        let Some((station, after)) = self.window.pair(i) else { return false };
        let (length, bounds) = (station.cell.length, &station.bounds);
        let to = if i + 1 == stretch.last { PathState::REST } else { after.state };
        let Some(law) = Law::new(length, station.state, to) else { return false };
        // From rest to rest: (32 h / J)^(1/3) by jerk alone, 2 (h / A)^(1/2) by acceleration alone.
        let t = law.time / S::of(CRAWL);
        t > self.config.cycle
            && t * bounds.goal > length
            && t * t * bounds.acceleration > S::of(4.0) * length
            && t * t * t * bounds.jerk > S::of(32.0) * length
    }

    /// Whether no cell of a stretch is over so soon that a tick would pass more of them than it may: the bound that sees to it is on speeds, and is let go
    /// for those that are agreed.
    #[inline(never)]
    pub fn lasts(&self, stretch: Stretch) -> bool {
        let least = self.config.cycle * S::of(LEAST_CYCLE_SHARE * BARELY);
        (stretch.first..stretch.last).all(|i| self.time(i) >= least)
    }

    /// How long the plan in the making takes for the cell of station `i`, s; 0 if there is none.
    pub fn time(&self, i: usize) -> S {
        let Some((station, next)) = self.window.pair(i) else { return S::ZERO };
        if station.cell.length > S::ZERO {
            Law::new(station.cell.length, station.state, next.state).map_or(S::ZERO, |law| law.time)
        } else {
            station.cell.dwell
        }
    }

    /// The last station that the next plan ahead leaves as it is: what it changes is felt no further back (see
    /// `Problem::guess`).
    #[cfg(feature = "reshape")]
    pub fn settled_end(&self, end: usize) -> usize {
        let brakes =
            |i: &usize| self.window.get(*i).is_some_and(|station| station.state.a < S::ZERO);
        let braking = (1..end).rev().take_while(brakes).count();
        let mut time = self.config.limits.time_scale() * S::of(crate::profile::guess::FELT);
        let mut station = end.saturating_sub(1 + braking);
        while station > 0 && time > S::ZERO {
            station -= 1;
            time = time - self.time(station);
        }
        // Guesses take the mean of the speeds for a cell's.
        station.saturating_sub(2)
    }

    /// About what braking takes from a station, mm: v (v / A + A / J) / 2 and a fifth more.
    #[inline(never)]
    pub fn braking_distance(&self, i: usize) -> S {
        let Some(station) = self.window.get(i) else { return S::ZERO };
        let PathState { b, a } = station.state;
        // What the acceleration adds until it is gone.
        let more = a.greatest(S::ZERO) * a / (station.bounds.jerk + station.bounds.jerk);
        let speed = b.sqrt() + more;
        let limits = &self.config.limits;
        let mut time = S::ZERO;
        for axis in limits.axes() {
            time = time.greatest(speed / axis.usable_acceleration());
        }
        for motor in limits.motors() {
            time = time.greatest(speed * norm(&motor.factors) / motor.limits.usable_acceleration());
        }
        speed * (time + limits.time_scale()) * S::of(0.6)
    }

    /// The least time, s, in which the motion could come to rest from a state if the path were straight from station `i` on: the
    /// acceleration is built up to its depth, held, and released together with the speed.
    pub fn stop_time(&self, i: usize, from: PathState<S>, limits: &Limits<S, N>) -> S {
        let Some(station) = self.window.get(i) else { return S::ZERO };
        let (speed, slows) = (from.b.sqrt(), -from.a);
        let [acceleration, jerk] = limits.along(&station.node.tangent);
        let two = S::of(2.0);
        // All of it is speed that is left when the acceleration is built up and released at once.
        let free = (jerk * speed + slows * slows / two).sqrt();
        if !(slows < free) {
            // It stops sooner than jerk allows.
            return two * speed / slows.greatest(S::of(1.0e-6));
        }
        let depth = free.least(acceleration.greatest(slows));
        let built_up = speed + (slows * slows - depth * depth) / (two * jerk);
        let released = depth * depth / (two * jerk);
        (two * depth - slows) / jerk + (built_up - released).greatest(S::ZERO) / depth
    }

    /// What it takes from a speed, mm/s, to the one that the cell of station `i` is asked for, mm.
    #[inline(never)]
    pub fn ramp(&self, i: usize, speed: S) -> S {
        let Some(station) = self.window.get(i) else { return S::ZERO };
        let Bounds { goal, acceleration, jerk, .. } = station.bounds;
        let gain = (goal - speed).greatest(S::ZERO);
        let time = if gain * jerk < acceleration * acceleration {
            S::of(2.0) * (gain / jerk).sqrt()
        } else {
            gain / acceleration + acceleration / jerk
        };
        (speed + goal) * time * S::of(0.5)
    }

    /// Least distance of two nodes in a cell, mm.
    pub fn apart(&self, jerk: S) -> S {
        let time = self.config.cycle * S::of(APART_CYCLES);
        jerk * time * time * time * S::of(1.0 / 6.0)
    }
}
