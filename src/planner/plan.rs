//! Plans: from the states of a stretch to pieces handed over, and the word that comes back.

use super::cutting::{ADDED, Changes};
use super::{Halt, Planner, Progress};
use crate::machine::Config;
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::profile::compile::{self, Placement};
use crate::profile::law::{Law, PathState};
use crate::profile::solver::{Aim, Stretch};
use crate::servo::link::Branch;
use crate::servo::piece::{Piece, Sequel};
use core::ops::Range;

/// A plan that was offered, until the interpolator has decided on it.
#[derive(Clone, Copy, Debug)]
pub struct Pending {
    /// Node from which it starts.
    pub first: NodeSerial,
    /// Node at which it ends.
    pub end: NodeSerial,
    /// Whether it branches off at a servo cycle.
    pub by_cycle: bool,
    /// Overrides that were in effect before, per cent.
    pub overrides: (u16, u16),
    /// Why the plan before ends where it does.
    pub halt: Option<Halt>,
}

/// Share by which a bound lies above a speed that exceeds what is asked for; the limits of the axes
/// have as much in reserve.
const EXCESS: f64 = 1.0001;
/// A cell that takes so many times as long as with stops at both ends is a crawl.
const CRAWL: f64 = 10.0;
/// Share of its speed that a motion must have left after letting go of the brake, to be taken on.
const LEAST_LEFT: f64 = 0.3;
/// Where the way from rest to a speed is cut, as shares of it: constant jerk covers the last in a quarter of the
/// time in which acceleration builds up.
const RAMP: [f64; 3] = [0.75, 0.125, 0.02];
/// A cell at a rest is cut only if the part there is at most this share of it.
const MOST_PART: f64 = 0.4;
/// New plans are asked for when this part of the present one has been run, and no more than this
/// many cells of it are left: enough that its stop at the end does not show in what is run.
const PLAN_PART: u32 = 2;
const CELLS_LEFT: u32 = 64;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// The interpolator's word on the plan offered last.
    pub(super) fn hear(&mut self) {
        let Some(pending) = self.pending else { return };
        let Some(taken) = self.side.verdict() else { return };
        self.pending = None;
        if taken {
            self.planned_end = pending.end;
            self.changes = Changes::NONE;
            // The part of the window before is the same in both plans.
            for i in self.window.clamped_index(pending.first)..self.window.len() {
                if let Some(station) = self.window.get_mut(i) {
                    station.agreed = station.state;
                }
            }
            return;
        }
        self.counters.late += 1;
        #[cfg(feature = "defmt")]
        defmt::warn!("the plan from node {} came too late", pending.first.raw());
        self.undo();
        self.halt = pending.halt;
        if self.overrides != pending.overrides {
            self.overrides = pending.overrides;
            self.bound_all();
        }
        if pending.by_cycle {
            // Allow more time for the next attempt.
            self.reaction = (2 * self.reaction + 1).min(self.most_reaction());
        }
    }

    /// Improves the states of a stretch for an aim, and counts the steps.
    pub(super) fn improve(&mut self, stretch: Stretch, aim: Aim) {
        let Config { limits, iterations, .. } = self.config;
        let steps = self.solver.on(&mut self.window, &limits, stretch).improve(iterations, aim);
        self.counters.steps += u32::from(steps);
    }

    /// Whether the states of a stretch keep all limits, with a rest at its end.
    pub(super) fn holds(&mut self, stretch: Stretch) -> bool {
        self.solver.on(&mut self.window, &self.config.limits, stretch).holds()
    }

    /// Gives the stations of a stretch from index `new` on states, and improves those before.
    /// Returns whether there is a motion.
    fn find(&mut self, stretch: Stretch, new: usize) -> bool {
        if self.find_from_guess(stretch, new) {
            return true;
        }
        // From the plan as it stands, and slow speeds behind it.
        self.take_agreed(stretch.first..new);
        let limits = self.config.limits;
        let found = self.solver.on(&mut self.window, &limits, stretch).seed(new);
        if found {
            self.improve(stretch, Aim::Time);
        }
        found
    }

    /// The same by a guess at the stations from index `new` on, which need not lead to a motion.
    pub(super) fn find_from_guess(&mut self, stretch: Stretch, new: usize) -> bool {
        let Config { limits, iterations, .. } = self.config;
        let mut problem = self.solver.on(&mut self.window, &limits, stretch);
        problem.guess(new);
        let (steps, found) = problem.find(iterations);
        self.counters.steps += u32::from(steps);
        found
    }

    /// Gives stations the states of the plan that is being executed.
    pub(super) fn take_agreed(&mut self, stations: Range<usize>) {
        for i in stations {
            if let Some(station) = self.window.get_mut(i) {
                station.state = station.agreed;
            }
        }
    }

    /// Servo cycles in a lead.
    fn most_reaction(&self) -> u32 {
        (self.config.lead / self.config.cycle).to_i64().clamp(1, 1_000_000) as u32
    }

    /// Whether less than this time, s, is left from the end of the piece under way to the end of
    /// the plan. Looks no further than it must.
    pub(super) fn ends_within(&self, limit: S, at: NodeSerial) -> bool {
        let mut time = S::ZERO;
        for i in self.window.clamped_index(at) + 1..self.end_index() {
            time += self.agreed_time(i);
            if time >= limit {
                return false;
            }
        }
        true
    }

    pub(super) fn agreed_time(&self, i: usize) -> S {
        match self.window.get(i) {
            Some(station) if !(station.cell.length > S::ZERO) => station.cell.dwell,
            Some(_) => self.window.agreed_law(i).map_or(S::ZERO, |law| law.time),
            None => S::ZERO,
        }
    }

    /// Whether from station `first` on the plan does nothing but come to rest where it ends: even if it let
    /// go of the brake as fast as the limits allow, hardly any speed would be left. To go on from there without
    /// that rest would save nothing, and a motion that all but rests in the middle of its way is one that
    /// no solver gets going again.
    pub(super) fn is_stopping(&self, first: usize) -> bool {
        let end = self.end_index();
        first < end
            && (first..end).all(|i| {
                let Some(from) = self.window.get(i) else { return false };
                let PathState { b, a } = from.agreed;
                let least = S::of(2.0 * (1.0 - LEAST_LEFT)) * from.bounds.jerk * b.sqrt();
                from.cell.length > S::ZERO && a < S::ZERO && a * a > least
            })
    }

    /// The node from which a new plan can branch off: a lead ahead of the motion, or half of what is left
    /// of the plan if that is less. At its end the motion would rest.
    pub(super) fn branch(&self, at: NodeSerial) -> Option<NodeSerial> {
        let end = self.end_index();
        let first = self.window.clamped_index(at) + 1;
        let mut left = S::ZERO;
        for i in first..end {
            left += self.agreed_time(i);
        }
        let lead = self.config.lead.least(left * S::of(0.5));
        let mut time = S::ZERO;
        for i in first..=end {
            if time >= lead || i == end {
                return Some(if self.is_stopping(i) {
                    self.planned_end
                } else {
                    self.window.serial(i)
                });
            }
            time += self.agreed_time(i);
        }
        None
    }

    /// The first cell in a stretch that the motion crawls through: it takes many times as long as stopping
    /// at both its ends would, and longer than the feed asks for.
    pub(super) fn crawl_in(&self, stretch: Stretch) -> Option<usize> {
        let most = S::of(CRAWL);
        (stretch.first..stretch.last).find(|&i| {
            let Some((station, after)) = self.window.pair(i) else { return false };
            let (length, bounds) = (station.cell.length, &station.bounds);
            let to = if i + 1 == stretch.last { PathState::REST } else { after.state };
            let Some(law) = Law::new(length, station.state, to) else { return false };
            // From rest to rest: (32 h / J)^(1/3) by jerk alone, 2 (h / A)^(1/2) by acceleration alone.
            let t = law.time / most;
            t > self.config.cycle
                && t * bounds.goal > length
                && t * t * bounds.acceleration > S::of(4.0) * length
                && t * t * t * bounds.jerk > S::of(32.0) * length
        })
    }

    /// One planning step: states for everything behind the branch, handed over as a plan.
    pub(super) fn plan(&mut self, branch: NodeSerial, single: bool) -> Progress {
        if branch != self.planned_end {
            if let Some(progress) = self.plan_from(branch, single) {
                return progress;
            }
            // The rest that is agreed comes first.
            self.undo();
        }
        let progress = self.plan_from(self.planned_end, single);
        progress.unwrap_or(Progress::Waiting)
    }

    /// A plan from a node on; `None` if it would crawl and the node is not a rest.
    fn plan_from(&mut self, branch: NodeSerial, single: bool) -> Option<Progress> {
        let first = self.window.clamped_index(branch);
        let new = self.end_index().max(first);
        let mut stretch = Stretch { first, last: self.window.len() - 1, open: true };
        let mut halt = None;
        if single && let Some(end) = self.block_end(first) {
            stretch = Stretch { last: end, open: false, ..stretch };
            halt = Some(Halt::Block);
        }
        let pauses = |i: &usize| self.window.get(*i).is_some_and(|station| station.pause);
        if let Some(last) = (first + 1..=stretch.last).find(pauses) {
            stretch = Stretch { last, open: false, ..stretch };
        }
        self.split_lone(&mut stretch);
        self.split_ramps(&mut stretch, new);
        if stretch.open && self.is_lone_start(stretch) {
            stretch.last -= 1;
        }
        if self.window.serial(stretch.last) == self.planned_end {
            return Some(Progress::NeedsBlocks);
        }
        self.loosen(stretch.first, new);
        if !self.find(stretch, new) {
            self.counters.stuck += 1;
            #[cfg(feature = "defmt")]
            defmt::warn!("no motion found from node {}", branch.raw());
            return Some(Progress::Waiting);
        }
        if branch != self.planned_end && self.crawl_in(stretch).is_some() {
            return None;
        }
        self.publish(stretch, Branch::Node(branch), self.overrides, halt);
        Some(Progress::Planned)
    }

    /// A cell from a rest inside a block to the next rest needs a node between.
    fn split_lone(&mut self, stretch: &mut Stretch) {
        let Some((station, after)) = self.window.pair(stretch.first) else { return };
        let starts = station.rest || self.window.serial(stretch.first) == self.planned_end;
        let ends = after.rest || (!stretch.open && stretch.first + 1 == stretch.last);
        if starts
            && ends
            && station.cell.length > S::ZERO
            && self.split_cell(stretch.first, S::of(0.5))
        {
            stretch.last += 1;
        }
    }

    /// Splits cells at rests, from station `new` on, that are much longer than the way to the speed that is
    /// asked for now: over the whole of one the motion would gather speed, or lose it.
    fn split_ramps(&mut self, stretch: &mut Stretch, new: usize) {
        let mut i = new;
        for _ in 0..NODES {
            let Some((station, after)) = self.window.pair(i).filter(|_| i < stretch.last) else {
                return;
            };
            let starts = station.rest || i == stretch.first;
            let ends = after.rest || (!stretch.open && i + 1 == stretch.last);
            if (starts || ends) && station.cell.length > S::ZERO {
                let (ramp, apart) = (self.ramp(i, S::ZERO), self.apart(station.bounds.jerk));
                for share in RAMP {
                    let Some(length) = self.window.get(i).map(|station| station.cell.length) else {
                        return;
                    };
                    let part = (ramp * S::of(share)).greatest(apart) / length;
                    if part > S::of(MOST_PART) {
                        continue;
                    }
                    let place = if starts { part } else { S::ONE - part };
                    if self.window.room() + RAMP.len() <= ADDED || !self.split_cell(i, place) {
                        return;
                    }
                    stretch.last += 1;
                    i += usize::from(!starts);
                }
            }
            i += 1;
        }
    }

    /// Whether the last cell starts at rest and ends where the window does: from rest to rest in a
    /// single cell there is no motion, so it must wait for the next.
    fn is_lone_start(&self, Stretch { first, last, .. }: Stretch) -> bool {
        let Some((station, after)) = last.checked_sub(1).and_then(|i| self.window.pair(i)) else {
            return false;
        };
        (station.rest || first + 1 == last) && !after.rest && station.cell.length > S::ZERO
    }

    /// Lets the speed bounds of planned cells be no less than the speeds of the plan: an override
    /// may have been lowered since.
    pub(super) fn loosen(&mut self, first: usize, last: usize) {
        for i in first..last {
            let Some((station, after)) = self.window.pair(i) else { return };
            let Some(law) = Law::new(station.cell.length, station.state, after.state) else {
                continue;
            };
            let [early, late] = law.inner_speeds();
            let most = law.v0.greatest(law.v1).greatest(early.greatest(late));
            if let Some(station) = self.window.get_mut(i) {
                let goal = station.bounds.goal;
                station.bounds.speed = if most < goal { goal } else { most * S::of(EXCESS) };
            }
        }
    }

    /// The motion over a cell as it stands in the plan that is being made.
    pub(super) fn piece(&self, i: usize, to: PathState<S>, sequel: Sequel) -> Option<Piece<S, N>> {
        let (station, after) = self.window.pair(i)?;
        let view = station.view(after, &self.config.limits);
        let place = Placement { serial: self.window.serial(i), way: station.way, sequel };
        if !(station.cell.length > S::ZERO) {
            return Some(compile::standstill(&view, place));
        }
        let law = Law::new(station.cell.length, station.state, to)?;
        Some(compile::piece(&view, &law, place))
    }

    /// Offers the states of a stretch as a plan that ends where it does for `halt`. `overrides` are those
    /// in effect before it.
    pub(super) fn publish(
        &mut self,
        stretch: Stretch,
        branch: Branch,
        overrides: (u16, u16),
        halt: Option<Halt>,
    ) {
        self.window.measure(stretch.first);
        for i in stretch.first..stretch.last {
            let Some(after) = self.window.get(i + 1) else { break };
            let at_end = i + 1 == stretch.last;
            let sequel = if after.rest || (at_end && !stretch.open) {
                Sequel::Stop
            } else if at_end {
                Sequel::Starved
            } else {
                Sequel::Motion
            };
            let to = if at_end { PathState::REST } else { after.state };
            let Some(piece) = self.piece(i, to, sequel) else { break };
            self.side.write(&piece);
        }
        for i in stretch.last..self.window.len() {
            self.window.set_state(i, PathState::REST);
        }
        self.side.offer(branch);
        let (first, end) = (self.window.serial(stretch.first), self.window.serial(stretch.last));
        let by_cycle = matches!(branch, Branch::Cycle(_));
        let before = core::mem::replace(&mut self.halt, halt);
        self.pending = Some(Pending { first, end, by_cycle, overrides, halt: before });
        let cells = end.since(first).unwrap_or(0);
        let run = (cells / PLAN_PART).max(cells.saturating_sub(CELLS_LEFT)).max(1);
        self.checkpoint = first.plus(run);
        self.counters.plans += 1;
        #[cfg(feature = "defmt")]
        defmt::debug!(
            "plan {}: nodes {} to {}, {} steps so far",
            self.counters.plans,
            first.raw(),
            end.raw(),
            self.counters.steps
        );
    }
}
