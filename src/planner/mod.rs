//! The background side: blocks in, plans out.
//!
//! [`Planner`] holds the look-ahead and says what is to be done now; [`plan`] makes plans and hands
//! them over; [`control`] answers an operator's commands: it [`cutting`]s the window where an answer
//! takes effect, and comes to rest by [`brake`] and [`stop`].

mod brake;
mod control;
mod cutting;
mod plan;
mod stop;

use self::cutting::{ADDED, Changes};
use self::plan::Pending;

use crate::block::range::check_coordinates;
use crate::block::{Block, BlockError, PushError};
use crate::machine::{Config, ConfigError};
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::vector::zero;
use crate::number::{Coord, Scalar};
use crate::path::builder::Builder;
use crate::path::hermite;
use crate::path::node::Node;
use crate::profile::solver::Solver;
use crate::profile::window::Window;
use crate::servo::control::{Requests, Wish};
use crate::servo::link::PlanSide;
use crate::servo::{Controls, Interpolator, Link};

/// What a call of [`Planner::poll`] came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Progress {
    /// A new plan was handed over.
    Planned,
    /// Nothing to do until the interpolator has moved on.
    Waiting,
    /// Nothing to do until more blocks come.
    NeedsBlocks,
    /// Everything that was pushed has been handed over.
    Done,
    /// At rest because an operator asked for it: see [`Controls`].
    Held,
    /// At rest after an abort, and everything that had been pushed is dropped. Said at every poll until
    /// [`Planner::acknowledge_abort`].
    Aborted,
}

/// Why the plan ends where it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Halt {
    /// As soon as the limits allow.
    Hold,
    /// At the end of a block.
    Block,
}

impl Halt {
    /// Whether it is still asked for.
    fn is_wanted(self, wish: &Wish) -> bool {
        match self {
            Self::Hold => wish.holds(),
            Self::Block => wish.stop || wish.single,
        }
    }
}

/// Counts since the start, for reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
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
/// `N` axes (1 to 9), a look-ahead of `BLOCKS` blocks (4 at least), a planning window of `NODES` nodes of the
/// path (48 at least: fewer would be slower than a stop at every corner).
///
/// A type that names no sizes, `Planner<'_, f32, 3>`, has [`BLOCKS`](crate::BLOCKS) and [`NODES`](crate::NODES).
pub struct Planner<
    'a,
    S: Scalar,
    const N: usize,
    const BLOCKS: usize = { crate::machine::BLOCKS },
    const NODES: usize = { crate::machine::NODES },
> {
    side: PlanSide<'a, S, N>,
    config: Config<S, N>,
    builder: Builder<S, N, BLOCKS>,
    window: Window<S, N, NODES>,
    solver: Solver<S, NODES>,
    /// Running number of the node at which the present plan ends.
    planned_end: NodeSerial,
    /// The plan that was offered last, until the interpolator has decided on it.
    pending: Option<Pending>,
    /// What that plan has changed in the window.
    changes: Changes<S, N>,
    requests: &'a Requests,
    /// Overrides in effect, per cent: of feeds and of rapids.
    overrides: (u16, u16),
    /// Why the plan ends where it does, if an operator has asked for it.
    halt: Option<Halt>,
    /// Whether the motion rests until it is resumed: at a pause, or in single block mode.
    waits: bool,
    /// Number of the last resume seen.
    resumes: u32,
    /// Number of the last abort that has been acknowledged.
    aborts: u32,
    /// Number of the last abort that is complete, until it is acknowledged.
    dropped: Option<u32>,
    /// Servo cycles after which an answer to a command takes effect.
    reaction: u32,
    /// Plans made when a rest at the end of a block was looked for last.
    tried: u32,
    /// Node at which it is time for a new plan.
    checkpoint: NodeSerial,
    /// Tick at which the motion came to rest with nothing planned.
    waiting_since: Option<CycleSerial>,
    finished: bool,
    counters: Counters,
}

/// Room in the window for one more cell, and for the stations that answers to commands add.
const LEAST_ROOM: usize = 2 + ADDED;
/// A stop is imminent when less than this many leads remain.
const URGENT_LEADS: f64 = 4.0;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize> Link<S, N, BLOCKS, NODES> {
    /// The two handles of a core that rests at `start`: the planner for the background, the interpolator for the
    /// servo interrupt. Both are `Send`. What an earlier split has left in the link is forgotten.
    ///
    /// Cost: writes the planner once (its size is `size_of::<Planner<..>>()`), where the result is bound.
    ///
    /// # Errors
    /// [`ConfigError`] if a setting or the start is out of its range; the link is unchanged.
    // Not inlined, the planner is made on the stack and copied twice: 75 kB on the target.
    #[allow(clippy::inline_always)]
    #[inline(always)]
    pub fn split(
        &mut self,
        config: Config<S, N>,
        start: [Coord; N],
    ) -> Result<(Planner<'_, S, N, BLOCKS, NODES>, Interpolator<'_, S, N>), ConfigError> {
        const { assert!(N >= 1 && N <= 9, "1 to 9 axes") };
        config.check()?;
        if let Err(BlockError::Coordinate { axis, error }) = check_coordinates(&start) {
            return Err(ConfigError::Start { axis, error });
        }
        let (plan, servo, requests) = self.ends();
        let node = Node { at: start, tangent: zero(), curvature: zero() };
        // Built where it is returned to: it is large.
        Ok((
            Planner {
                side: plan,
                config,
                builder: Builder::new(start),
                window: Window::new(node),
                solver: Solver::new(),
                planned_end: NodeSerial::ZERO,
                pending: None,
                changes: Changes::NONE,
                requests,
                overrides: (100, 100),
                halt: None,
                waits: false,
                resumes: 0,
                aborts: 0,
                dropped: None,
                reaction: 0,
                tried: 0,
                checkpoint: NodeSerial::ZERO,
                waiting_since: None,
                finished: false,
                counters: Counters::default(),
            },
            Interpolator::new(servo, start, config.cycle),
        ))
    }
}

impl<'a, S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'a, S, N, BLOCKS, NODES>
{
    /// Takes a block into the look-ahead. It starts where the block before ended.
    ///
    /// Cost: bounded; an arc costs more than a line.
    ///
    /// # Errors
    /// [`PushError::Full`] if there is no room now: poll, and push the same block again.
    /// [`PushError::Rejected`] if the block is not valid. [`PushError::Aborted`] from the moment an abort
    /// is asked for until it is acknowledged. In each case nothing has changed.
    pub fn push(&mut self, block: &Block<S, N>) -> Result<(), PushError> {
        if self.is_aborted() {
            return Err(PushError::Aborted);
        }
        self.builder.push(block, &self.config)?;
        self.finished = false;
        Ok(())
    }

    /// Says that no more blocks come for now: the path ends where the last one ends. Without it
    /// the planner waits for more blocks as long as the motion under way allows. It says nothing of
    /// blocks that an abort has dropped: until that is acknowledged it does nothing.
    pub fn finish(&mut self) {
        if !self.is_aborted() {
            self.finished = true;
        }
    }

    /// Whether an abort has been asked for that has not been acknowledged.
    pub fn is_aborted(&self) -> bool {
        self.requests.aborts() != self.aborts
    }

    /// The producer knows that everything was dropped and will begin anew from [`Planner::end`], where
    /// the machine stands. `true`: the abort is complete, and blocks are taken again. `false`, and
    /// nothing has changed: there is none, or [`Planner::poll`] has not said [`Progress::Aborted`] since
    /// the last was asked for.
    pub fn acknowledge_abort(&mut self) -> bool {
        let aborts = self.requests.aborts();
        let complete = aborts != self.aborts && self.dropped == Some(aborts);
        if complete {
            self.aborts = aborts;
            self.dropped = None;
        }
        complete
    }

    /// The operator's handle: hold, resume, overrides and the like.
    pub fn controls(&self) -> Controls<'a> {
        Controls::new(self.requests)
    }

    /// End point of the last block taken; after an abort, where the machine stands.
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
        self.window.len() - 1 - self.window.clamped_index(self.side.progress())
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
        let at = self.side.progress();
        self.hear();
        // While a plan is undecided, the motion may be on the one before, whose running numbers mean
        // something else from the new plan's first node on: keep all behind that.
        let behind = match self.pending {
            Some(pending) if !at.is_before(pending.first) => pending.first,
            _ => at,
        };
        self.window.release_before(behind);
        if self.finished {
            self.builder.close();
        }
        self.build();
        let wish = self.requests.read();
        if let Some(progress) = self.obey(&wish, at) {
            return progress;
        }
        if self.pending.is_some() {
            return Progress::Waiting;
        }
        let resting = at == self.planned_end;
        if resting { self.poll_at_rest(wish.single) } else { self.poll_moving(at) }
    }

    /// Cuts blocks into cells as long as there is room.
    fn build(&mut self) {
        let pace = self.pace();
        for _ in 0..NODES {
            // A cell may have to be split in two.
            if self.window.room() < LEAST_ROOM {
                return;
            }
            let Some(last) = self.window.last() else { return };
            let node = last.node;
            let Some(cut) = self.builder.emit(&node, &self.config) else { return };
            self.counters.cells += 1;
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
                self.window.append(first, middle, false, &pace);
                self.window.append(second, cut.node, true, &pace);
            } else {
                self.window.append(cut.cell, cut.node, cut.rest, &pace);
            }
        }
    }

    /// Index of the station at which the agreed plan ends: it is never released before the motion is there.
    fn end_index(&self) -> usize {
        debug_assert!(self.window.find(self.planned_end).is_some());
        self.window.clamped_index(self.planned_end)
    }

    /// Whether a plan may end at a node.
    fn may_rest_at(&self, serial: NodeSerial) -> bool {
        let rests =
            self.window.get(self.window.clamped_index(serial)).is_some_and(|station| station.rest);
        rests
            || serial == self.planned_end
            || self.pending.is_some_and(|pending| pending.end == serial)
    }

    /// At rest where the plan ends: start when the look-ahead is full, when no more is to come, or
    /// when more has not come for a while.
    fn poll_at_rest(&mut self, single: bool) -> Progress {
        let end = self.window.serial(self.window.len() - 1);
        let unplanned = end != self.planned_end;
        if !unplanned && self.builder.len() == 0 {
            self.waiting_since = None;
            return if self.finished { Progress::Done } else { Progress::NeedsBlocks };
        }
        let now = self.side.cycles();
        let since = *self.waiting_since.get_or_insert(now);
        let waited = S::from_u32(now.since(since).unwrap_or(u32::MAX)) * self.config.cycle;
        let full = self.builder.is_full() || self.window.room() < LEAST_ROOM;
        if !(full || self.finished || waited >= self.config.start_delay) {
            return Progress::NeedsBlocks;
        }
        if !full {
            self.builder.close();
            self.build();
        }
        self.waiting_since = None;
        self.plan(self.planned_end, single)
    }

    /// In motion: plan on when a part of the plan has been run or its end is near.
    fn poll_moving(&mut self, at: NodeSerial) -> Progress {
        self.waiting_since = None;
        if self.window.get(self.end_index()).is_some_and(|end| end.pause) {
            return Progress::Waiting;
        }
        let urgent = self.ends_within(self.config.lead * S::of(URGENT_LEADS), at);
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
        let passed = !at.is_before(self.checkpoint);
        if !(passed || urgent) {
            return Progress::Waiting;
        }
        let Some(branch) = self.branch(at) else { return Progress::Waiting };
        self.plan(branch, false)
    }
}
