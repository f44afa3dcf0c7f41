//! The background side: blocks in, plans out.
//!
//! - [`Planner`] is the producer's handle, on the memory of a [`Link`].
//! - [`phase`]: what it is doing, as one value, with all its transitions.
//! - [`horizon`]: the path ahead, the plan agreed on it, and the draft of the next.
//! - [`ahead`]: blocks cut into cells, and when a plan goes on as far as is known.
//! - [`command`]: answers to an operator's commands.
//! - `jogging`: motion off the path, while that rests; `probing`: such that ends on an input.
//! - [`making`]: a plan in the making, slice by slice.
//! - [`effort`]: what that takes, in servo cycles.
//! - `settings`: what may be changed at rest.
//! - [`offer`]: plans handed over, and the interrupt's word on them.
//! - `switches`: outputs in time with the path.
//! - `reshaping`: what is agreed made faster, while there is nothing else to do.

mod ahead;
mod command;
mod effort;
#[cfg(feature = "home")]
mod homing;
mod horizon;
#[cfg(feature = "jog")]
mod jogging;
mod link;
mod making;
mod offer;
mod phase;
#[cfg(feature = "probe")]
mod probing;
#[cfg(feature = "reshape")]
mod reshaping;
mod settings;
#[cfg(feature = "outputs")]
mod switches;
#[cfg(test)]
mod tests;

use self::command::Answered;
use self::command::reaction::Pressing;
use self::effort::Effort;
use self::horizon::Horizon;
pub use self::link::Link;
use self::making::{Making, Vain};
use self::phase::{Phase, Rest};
#[cfg(feature = "reshape")]
pub use self::reshaping::Reshaping;

use crate::block::{Block, PushError};
use crate::machine::Limits;
#[cfg(feature = "travel")]
use crate::machine::Travel;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::{Coord, Scalar};
use crate::path::builder::Builder;
use crate::servo::Controls;
use crate::servo::control::{Requests, Wish};
use crate::servo::link::PlanSide;

/// Slices within which a plan is made and a window of path is cut, with room to spare.
const MOST_SLICES: u32 = 10_000;

/// What a call of [`Planner::poll`] came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Progress {
    /// A part of the work has been done, and more can be done now: poll again.
    Planning,
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
    requests: &'a Requests,
    builder: &'a mut Builder<S, N, BLOCKS>,
    horizon: &'a mut Horizon<S, N, NODES>,
    #[cfg(feature = "jog")]
    jogging: &'a mut jogging::Jogging<N>,
    #[cfg(feature = "reshape")]
    reshaping: Option<&'a mut Reshaping<S, N>>,
    phase: Phase,
    /// The plan in the making.
    making: Option<Making<S>>,
    effort: Effort<S>,
    /// What no plan was found for, until it changes.
    vain: Option<Vain>,
    /// Whether there was nothing to do with the motion at a node: there is not before that, what is asked for or what is known changes.
    idle: bool,
    idle_at: NodeSerial,
    answered: Answered,
    /// How far the answer to a command that lasts has got.
    pressing: Pressing,
    /// Whether a stop has been measured.
    knows_stops: bool,
    /// Whether the producer has said that no more blocks come for now.
    finished: bool,
    /// Servo cycle in which the last block was taken.
    pushed: CycleSerial,
    /// Servo cycles after which an answer to a command takes effect: more after one that came too late.
    reaction: u32,
    counters: Counters,
    #[cfg(feature = "outputs")]
    switches: switches::Switches<S>,
    /// Servo cycle in which the motion was first seen at rest.
    #[cfg(feature = "shaping")]
    rested: CycleSerial,
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
        #[cfg(feature = "jog")]
        if self.jogging.is_free() {
            return Err(PushError::Full);
        }
        #[cfg(feature = "outputs")]
        if !self.has_room_for_power() {
            return Err(PushError::Full);
        }
        #[cfg(feature = "outputs")]
        if let Some(event) = self.power_between(block) {
            self.take(&event)?;
        }
        self.take(block)
    }

    /// Takes a block for which there is room, if the builder has any.
    fn take(&mut self, block: &Block<S, N>) -> Result<(), PushError> {
        self.builder.set_single(self.requests.is_single());
        #[cfg(feature = "reshape")]
        let from = *self.builder.end();
        self.builder.push(block, &self.horizon.config)?;
        self.idle = false;
        #[cfg(feature = "reshape")]
        if let Some(memory) = self.reshaping.as_deref_mut() {
            memory.note(&from, block, &self.horizon.config);
        }
        self.finished = false;
        self.pushed = self.side.cycles();
        #[cfg(feature = "outputs")]
        self.note_taken(block);
        Ok(())
    }

    /// Changes the limits of travel (feature `travel`): they hold for every block that is pushed from now on. What has been
    /// taken is run as it is. Known after homing, as a rule.
    #[cfg(feature = "travel")]
    pub fn set_travel(&mut self, travel: Travel<N>) {
        self.horizon.config.travel = travel;
    }

    /// The limits of travel of the blocks to come.
    #[cfg(feature = "travel")]
    pub fn travel(&self) -> &Travel<N> {
        &self.horizon.config.travel
    }

    /// Changes the limits of the axes (feature `limits`): they bound every block that is pushed from now on, and jogs. What has
    /// been taken is run as it was meant: a block keeps the limits it was taken with, on either side of the place where they
    /// change the motion keeps both, and the change is planned ahead. For a tool or a load that bears less, or a part of
    /// a program that is to be calm. Of motors (feature `kinematics`) only limits change: their factors stay, and so do the
    /// limits of motors that are not named.
    ///
    /// Cost: a copy of the limits.
    ///
    /// # Errors
    /// [`PushError::Full`] if there is no room now: limits have changed four times, with blocks, between the motion and the last block, a
    /// curve is still being taken, or a jog is on. Poll, and set them again. Nothing has changed.
    #[cfg(feature = "limits")]
    pub fn set_limits(&mut self, limits: Limits<S, N>) -> Result<(), PushError> {
        #[cfg(feature = "jog")]
        if self.jogging.is_on() {
            return Err(PushError::Full);
        }
        if self.builder.takes_curve() {
            return Err(PushError::Full);
        }
        #[cfg(feature = "kinematics")]
        let limits = limits.on_motors_of(&self.horizon.config.limits);
        #[cfg(debug_assertions)]
        self.side.watch(limits.least_jerk(), self.horizon.config.cycle);
        self.idle = false;
        if !self.builder.uses_limits() {
            self.horizon.config.limit(&limits);
        } else if self.horizon.set_limits(limits) {
            self.builder.set_limits(self.horizon.older.newest());
        } else {
            return Err(PushError::Full);
        }
        Ok(())
    }

    /// The limits of the blocks to come, as they were given.
    pub fn limits(&self) -> &Limits<S, N> {
        self.horizon.config.given()
    }

    /// Says that no more blocks come for now: the path ends where the last one ends. Without it
    /// the planner waits for more blocks as long as the motion under way allows. It says nothing of
    /// blocks that an abort has dropped: until that is acknowledged it does nothing.
    pub fn finish(&mut self) {
        if !self.is_aborted() {
            (self.finished, self.idle) = (true, false);
        }
    }

    /// Whether an abort has been asked for that has not been acknowledged.
    pub fn is_aborted(&self) -> bool {
        self.requests.aborts() != self.answered.aborts
    }

    /// The producer knows that everything was dropped and will begin anew from [`Planner::end`], where
    /// the machine stands. `true`: the abort is complete, and blocks are taken again. `false`, and
    /// nothing has changed: there is none, or [`Planner::poll`] has not said [`Progress::Aborted`] since
    /// the last was asked for.
    pub fn acknowledge_abort(&mut self) -> bool {
        let aborts = self.requests.aborts();
        let complete = aborts != self.answered.aborts
            && self.phase == Phase::Resting(Rest::Dropped { abort: aborts })
            && self.has_settled();
        if complete {
            self.answered.aborts = aborts;
            self.phase = Phase::Resting(Rest::IDLE);
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
        #[cfg(feature = "jog")]
        if self.jogging.is_free() {
            return true;
        }
        self.builder.is_full()
    }

    /// Nodes of the window that lie ahead of the motion: the fill of the look-ahead.
    pub fn nodes_ahead(&self) -> usize {
        self.cells_ahead(self.side.progress())
    }

    /// Counts since the start.
    pub fn counters(&self) -> Counters {
        Counters { starved: self.side.starved(), steps: self.horizon.steps, ..self.counters }
    }

    /// Does a slice of what is to be done now. Call it in the background, again and again; at once if it says
    /// [`Progress::Planning`].
    ///
    /// What an operator asks for comes first: a plan in the making that does not serve it is dropped.
    ///
    /// Cost: bounded; at most one cell is cut, or one step of a plan is done. `docs/target.md` has the number of
    /// instructions.
    pub fn poll(&mut self) -> Progress {
        #[cfg(feature = "jog")]
        if self.jogging.is_on()
            && let Some(progress) = self.poll_jog()
        {
            return progress;
        }
        let at = self.side.progress();
        let wish = self.requests.read();
        let is_idle = self.is_idle(&wish, at);
        // In every other servo cycle of a debug build it is looked for all the same, in vain.
        if is_idle && (!cfg!(debug_assertions) || self.side.cycles().raw() & 1 == 0) {
            return Progress::Waiting;
        }
        self.idle = false;
        self.hear();
        if self.finished {
            self.builder.close();
        }
        self.builder.set_single(wish.single);
        self.drop_unwanted(&wish, at);
        #[cfg(feature = "reshape")]
        if !self.making.as_ref().is_some_and(Making::is_shaping) {
            self.reshaping(|planner, memory| planner.keep_track(memory, at));
        }
        let progress = if self.making.is_some() { self.go_on() } else { self.begin(&wish, at) };
        let has_draft = self.phase.offer().is_some() || self.making.is_some();
        debug_assert_eq!(has_draft, self.horizon.has_draft());
        debug_assert!(!is_idle || progress == Progress::Waiting, "something to do: {progress:?}");
        #[cfg(feature = "outputs")]
        self.end_standstills();
        progress
    }

    /// Polls until nothing can be done before the interpolator has moved on or blocks come, or until a plan was
    /// handed over: for tests and simulations in which planning takes no time.
    ///
    /// Cost: that of a whole plan, and of all blocks that can be cut.
    pub fn settle(&mut self) -> Progress {
        for _ in 0..MOST_SLICES {
            let progress = self.poll();
            if progress != Progress::Planning {
                return progress;
            }
        }
        Progress::Planning
    }

    /// Begins what is to be done now, with no plan in the making.
    #[inline(never)]
    fn begin(&mut self, wish: &Wish, at: NodeSerial) -> Progress {
        // While a plan is undecided, the motion may be on the one before, whose running numbers mean
        // something else from the new plan's first node on: keep all behind that.
        let behind = match self.phase.offer() {
            Some(offer) if !at.is_before(offer.first) => offer.first,
            _ => at,
        };
        self.horizon.window.release_before(behind);
        if let Some(progress) = self.obey(wish, at) {
            return progress;
        }
        if !self.is_pressed(at) && self.build_one() {
            return Progress::Planning;
        }
        match self.phase {
            Phase::Offered(_) => Progress::Waiting,
            // A plan ahead would not be what is asked for.
            _ if wish.overrides != self.horizon.overrides()
                && (self.is_falling(wish.overrides, at)
                    || self.rests_first(wish.overrides, at)) =>
            {
                Progress::Waiting
            }
            _ if at == self.horizon.end() => self.poll_at_rest(at, wish.single),
            _ => {
                let progress = self.poll_moving(at);
                #[cfg(feature = "reshape")]
                if matches!(progress, Progress::Waiting | Progress::NeedsBlocks)
                    && !wish.stops_at_end()
                    && self.reshaping(|planner, memory| planner.begin_reshaping(memory, at))
                        == Some(true)
                {
                    return Progress::Planning;
                }
                if progress == Progress::Waiting {
                    (self.idle, self.idle_at) = (self.waits_for_motion(wish), at);
                }
                progress
            }
        }
    }
}
