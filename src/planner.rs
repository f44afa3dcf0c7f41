//! The background side: blocks in, plans out.

use crate::block::{Block, BlockError, PushError};
use crate::machine::{Config, ConfigError};
use crate::number::vector::zero;
use crate::number::{Coord, Scalar};
use crate::path::builder::Builder;
use crate::path::hermite;
use crate::path::item::check_coordinates;
use crate::path::node::Node;
use crate::profile::compile::{self, Place};
use crate::profile::law::{Law, State};
use crate::profile::solver::{Solver, Stretch};
use crate::profile::window::Window;
use crate::servo::link::PlanSide;
use crate::servo::piece::Sequel;
use crate::servo::{Interpolator, Link};

/// What a call of [`Planner::poll`] came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Progress {
    /// A new plan was handed over.
    Planned,
    /// Nothing to do until the interpolator has moved on.
    Waiting,
    /// Nothing to do until more blocks come.
    NeedsBlocks,
    /// Everything that was pushed has been handed over.
    Done,
}

/// Counts since the start, for reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Plans handed over.
    pub plans: u32,
    /// Plans that came too late and were refused; the one before went on.
    pub late: u32,
    /// Improvement steps in all plans.
    pub steps: u32,
    /// Cells cut.
    pub cells: u32,
    /// Stops because blocks did not come in time.
    pub starved: u32,
    /// Stretches for which no motion within the limits was found at once; they are tried again
    /// with more of the path. Stays 0 unless numbers are at the edge of the scalar's range.
    pub stuck: u32,
}

/// The producer's handle: takes blocks, plans, hands plans over.
///
/// `N` axes, a look-ahead of `BLOCKS` blocks, a planning window of `NODES` nodes of the path.
pub struct Planner<'a, S, const N: usize, const BLOCKS: usize, const NODES: usize> {
    side: PlanSide<'a, S, N>,
    config: Config<S, N>,
    builder: Builder<S, N, BLOCKS>,
    window: Window<S, N, NODES>,
    solver: Solver<S, NODES>,
    /// Running number of the node at which the present plan ends.
    planned_end: u32,
    /// Node from which the plan that was published last branches off, and where it ends, until
    /// the interpolator has decided on it.
    pending: Option<(u32, u32)>,
    /// Node at which it is time for a new plan.
    checkpoint: u32,
    /// Tick at which the motion came to rest with nothing planned.
    waiting_since: Option<u32>,
    finished: bool,
    counters: Counters,
}

/// New plans are asked for when this part of the present one has been run.
const PLAN_PART: u32 = 4;
/// Room in the window for one more cell.
const LEAST_ROOM: usize = 2;
/// A stop is imminent when less than this many leads remain.
const URGENT_LEADS: f64 = 4.0;

impl<S: Scalar, const N: usize, const NODES: usize> Link<S, N, NODES> {
    /// The two handles of a core that rests at `start`. They can live in different contexts.
    ///
    /// # Errors
    /// [`ConfigError`] if the settings cannot be used.
    pub fn handles<const BLOCKS: usize>(
        &mut self,
        config: Config<S, N>,
        start: [Coord; N],
    ) -> Result<(Planner<'_, S, N, BLOCKS, NODES>, Interpolator<'_, S, N>), ConfigError> {
        const { assert!(N >= 1 && N <= 9, "1 to 9 axes") };
        config.check()?;
        if let Err(BlockError::Coordinate { axis, value }) = check_coordinates(&start) {
            return Err(ConfigError::Start { axis, value });
        }
        *self = Self::new();
        let (plan, servo) = self.split();
        let node = Node { at: start, tangent: zero(), curvature: zero() };
        let planner = Planner {
            side: plan,
            config,
            builder: Builder::new(start),
            window: Window::new(node),
            solver: Solver::new(),
            planned_end: 0,
            pending: None,
            checkpoint: 0,
            waiting_since: None,
            finished: false,
            counters: Counters::default(),
        };
        Ok((planner, Interpolator::new(servo, start, config.cycle)))
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Takes a block into the look-ahead. It starts where the block before ended.
    ///
    /// Cost: bounded; an arc costs more than a line.
    ///
    /// # Errors
    /// [`PushError::Full`] if there is no room now: poll, and push the same block again.
    /// [`PushError::Rejected`] if the block is not valid. Either way nothing has changed.
    pub fn push(&mut self, block: &Block<S, N>) -> Result<(), PushError> {
        self.builder.push(block, &self.config)?;
        self.finished = false;
        Ok(())
    }

    /// Says that no more blocks come for now: the path ends where the last one ends. Without it
    /// the planner waits for more blocks as long as the motion under way allows.
    pub fn finish(&mut self) {
        self.finished = true;
    }

    /// End point of the last block taken.
    pub fn end(&self) -> &[Coord; N] {
        self.builder.end()
    }

    /// Blocks in the look-ahead that have not been cut into cells yet.
    pub fn blocks_waiting(&self) -> usize {
        self.builder.len()
    }

    /// Whether the look-ahead has no room for another block.
    pub fn is_full(&self) -> bool {
        self.builder.is_full()
    }

    /// Nodes of the window that lie ahead of the motion: the fill of the look-ahead.
    pub fn nodes_ahead(&self) -> usize {
        self.window.len() - 1 - self.window.index(self.side.progress())
    }

    /// Counts since the start.
    pub fn counters(&self) -> Counters {
        Counters { starved: self.side.starved(), ..self.counters }
    }

    /// Does what is to be done now: one planning step at most. Call it in the background, again
    /// and again.
    ///
    /// Cost: bounded by the window and the number of iterations set.
    pub fn poll(&mut self) -> Progress {
        self.hear();
        let at = self.side.progress();
        self.window.release_before(at);
        if self.finished {
            self.builder.close();
        }
        self.build();
        if self.pending.is_some() {
            return Progress::Waiting;
        }
        let resting = at == self.planned_end;
        if resting { self.poll_at_rest() } else { self.poll_moving(at) }
    }

    /// The interpolator's word on the plan published last.
    fn hear(&mut self) {
        let Some((branch, end)) = self.pending else { return };
        let Some(taken) = self.side.verdict() else { return };
        self.pending = None;
        if taken {
            self.planned_end = end;
        } else {
            self.counters.late += 1;
            #[cfg(feature = "defmt")]
            defmt::warn!("the plan from node {} came too late", branch);
        }
        // The part of the window that both plans share is the same in either.
        let from = if taken { branch } else { self.side.progress() };
        let last = self.window.index(self.planned_end);
        for i in self.window.index(from)..self.window.len() {
            if let Some(station) = self.window.get_mut(i) {
                if taken {
                    station.agreed = station.state;
                } else {
                    station.state = if i <= last { station.agreed } else { State::REST };
                }
            }
        }
    }

    /// Cuts blocks into cells as long as there is room.
    fn build(&mut self) {
        for _ in 0..NODES {
            // A cell may have to be split in two.
            if self.window.room() < LEAST_ROOM {
                return;
            }
            let Some(last) = self.window.last() else { return };
            let node = last.node;
            let Some(cut) = self.builder.emit(&node, &self.config) else { return };
            self.counters.cells += 1;
            let (limits, cycle) = (&self.config.limits, self.config.cycle);
            let before = self.window.serial(self.window.len() - 1);
            let lone = cut.rest && cut.cell.length > S::ZERO && self.may_rest_at(before);
            if let Some(last) = self.window.last_mut()
                && last.rest
            {
                last.node = cut.from;
            }
            if lone {
                // From rest to rest there must be a node between.
                let (first, middle, second) = hermite::split(&cut.from, &cut.cell, &cut.node);
                self.window.append(first, middle, false, limits, cycle);
                self.window.append(second, cut.node, true, limits, cycle);
            } else {
                self.window.append(cut.cell, cut.node, cut.rest, limits, cycle);
            }
        }
    }

    /// Whether a plan may end at a node.
    fn may_rest_at(&self, serial: u32) -> bool {
        let rests = self.window.get(self.window.index(serial)).is_some_and(|station| station.rest);
        rests || serial == self.planned_end || self.pending.is_some_and(|(_, end)| end == serial)
    }

    /// At rest where the plan ends: start when the look-ahead is full, when no more is to come, or
    /// when more has not come for a while.
    fn poll_at_rest(&mut self) -> Progress {
        let end = self.window.serial(self.window.len() - 1);
        let unplanned = end != self.planned_end;
        if !unplanned && self.builder.len() == 0 {
            self.waiting_since = None;
            return if self.finished { Progress::Done } else { Progress::NeedsBlocks };
        }
        let now = self.side.ticks();
        let since = *self.waiting_since.get_or_insert(now);
        let waited = S::from_u32(now.wrapping_sub(since)) * self.config.cycle;
        let full = self.builder.is_full() || self.window.room() < LEAST_ROOM;
        if !(full || self.finished || waited >= self.config.start_delay) {
            return Progress::NeedsBlocks;
        }
        if !full {
            self.builder.close();
            self.build();
        }
        self.waiting_since = None;
        self.plan(self.planned_end)
    }

    /// In motion: plan on when a part of the plan has been run or its end is near.
    fn poll_moving(&mut self, at: u32) -> Progress {
        self.waiting_since = None;
        let urgent = self.time_ahead(at) < self.config.lead * S::of(URGENT_LEADS);
        if urgent
            && self.window.room() >= LEAST_ROOM
            && !self.builder.is_full()
            && self.builder.len() > 0
        {
            // The blocks that wait for their neighbours must go as they are.
            self.builder.close();
            self.build();
        }
        let end = self.window.serial(self.window.len() - 1);
        if end == self.planned_end {
            return if self.builder.len() > 0 { Progress::Waiting } else { Progress::NeedsBlocks };
        }
        let passed = at.wrapping_sub(self.checkpoint) <= u32::MAX / 2;
        if !(passed || urgent) {
            return Progress::Waiting;
        }
        let Some(branch) = self.branch(at) else { return Progress::Waiting };
        self.plan(branch)
    }

    /// Time from the end of the piece under way to the end of the plan, s.
    fn time_ahead(&self, at: u32) -> S {
        let mut time = S::ZERO;
        for i in self.window.index(at) + 1..self.window.index(self.planned_end) {
            time += self.agreed_time(i);
        }
        time
    }

    fn agreed_time(&self, i: usize) -> S {
        match self.window.get(i) {
            Some(station) if !(station.cell.length > S::ZERO) => station.cell.dwell,
            Some(_) => self.window.agreed_law(i).map_or(S::ZERO, |law| law.time),
            None => S::ZERO,
        }
    }

    /// The node from which a new plan can branch off: a lead ahead of the motion.
    fn branch(&self, at: u32) -> Option<u32> {
        let end = self.window.index(self.planned_end);
        let mut time = S::ZERO;
        for i in self.window.index(at) + 1..=end {
            if time >= self.config.lead || i == end {
                return Some(self.window.serial(i));
            }
            time += self.agreed_time(i);
        }
        None
    }

    /// One planning step: states for everything behind the branch, handed over as a plan.
    fn plan(&mut self, branch: u32) -> Progress {
        let first = self.window.index(branch);
        let new = self.window.index(self.planned_end).max(first);
        let mut stretch = Stretch { first, last: self.window.len() - 1 };
        if self.is_lone_start(stretch) {
            stretch.last -= 1;
        }
        if self.window.serial(stretch.last) == self.planned_end {
            return Progress::NeedsBlocks;
        }
        let limits = self.config.limits;
        if !self.solver.seed(&mut self.window, stretch, new, &limits) {
            self.counters.stuck += 1;
            #[cfg(feature = "defmt")]
            defmt::warn!("no motion found from node {}", branch);
            return Progress::Waiting;
        }
        let cold = new == first;
        let steps =
            self.solver.improve(&mut self.window, stretch, &limits, self.config.iterations, cold);
        self.counters.steps += u32::from(steps);
        self.publish(stretch);
        Progress::Planned
    }

    /// Whether the last cell starts at rest and ends where the window does: from rest to rest in a
    /// single cell there is no motion, so it must wait for the next.
    fn is_lone_start(&self, Stretch { first, last }: Stretch) -> bool {
        let Some((station, after)) = last.checked_sub(1).and_then(|i| self.window.pair(i)) else {
            return false;
        };
        (station.rest || first + 1 == last) && !after.rest && station.cell.length > S::ZERO
    }

    fn publish(&mut self, stretch: Stretch) {
        for i in stretch.first..stretch.last {
            let Some((station, after)) = self.window.pair(i) else { break };
            let view = station.view(after, &self.config.limits);
            let at_end = i + 1 == stretch.last;
            let place = Place {
                serial: self.window.serial(i),
                way: station.way,
                sequel: if after.rest {
                    Sequel::Stop
                } else if at_end {
                    Sequel::Starved
                } else {
                    Sequel::Motion
                },
            };
            let to = if at_end { State::REST } else { after.state };
            let piece = if station.cell.length > S::ZERO {
                let Some(law) = Law::new(station.cell.length, station.state, to) else { break };
                compile::piece(&view, &law, place)
            } else {
                compile::standstill(&view, place)
            };
            self.side.write(piece);
        }
        self.side.publish();
        let (branch, end) = (self.window.serial(stretch.first), self.window.serial(stretch.last));
        self.pending = Some((branch, end));
        self.checkpoint = branch.wrapping_add((end.wrapping_sub(branch) / PLAN_PART).max(1));
        self.counters.plans += 1;
        #[cfg(feature = "defmt")]
        defmt::debug!(
            "plan {}: nodes {} to {}, {} steps so far",
            self.counters.plans,
            branch,
            end,
            self.counters.steps
        );
    }
}
