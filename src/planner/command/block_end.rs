//! Coming to rest at the end of a block, slice by slice: of the ends of blocks that lie ahead, the first that a stop could be short enough for is
//! tried, and then those behind it. A try is a plan like any other, over the few cells up to there: a guess, and some Newton steps.
//! If that comes to nothing, or too late, the motion is not let run on to another end: it brakes as for a hold, and goes from where it rests to
//! the end of that block ([`Halt::Short`]).

use super::Flow;
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::making::{Purpose, Stage};
use crate::planner::phase::Halt;
use crate::profile::law::PathState;
use crate::profile::solver::Stretch;
use crate::profile::solving::Solving;
use crate::servo::link::Room;

/// Ends of blocks tried for a stop.
const END_TRIES: u8 = 6;
/// Share of the way that a stop on a straight takes, which no stop is much shorter than; and how much farther off the next end that is tried lies at
/// least.
const LEAST_WAY: f64 = 0.95;
const FARTHER: f64 = 1.25;
/// So many times as long a way is more than enough for a stop.
const AMPLE: f64 = 1.5;
/// Cells that a plan to the end of a block has more than there are, since they are cut finer.
const MORE_CELLS: usize = 8;

/// A rest at the end of a block that is being looked for.
#[derive(Clone, Copy, Debug)]
pub enum Ending<S> {
    /// The first one is to be tried that lies so far away, mm, and behind station `behind`.
    Trying { way: S, behind: usize, tries: u8 },
    /// A motion to one is being found. `last`: of the whole stretch.
    Finding { solving: Solving<S>, way: S, last: usize, tries: u8 },
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Begins to look for a rest at the end of the block under way, or of the first one that is possible. Whether
    /// that is under way. If there is such an end and it is not: another rest comes first.
    #[inline(never)]
    pub(super) fn rest_at_block_end(&mut self, at: NodeSerial) -> bool {
        let from = self.horizon.window.clamped_index(at);
        let (mut begins, mut cycles) = (from, S::ZERO);
        // What it takes to plan to the end that can be reached at once, and then to the one that can be when that is planned.
        for _ in 0..2 {
            let Some(end) = self.horizon.end_in_reach(begins) else { return false };
            cycles = self.effort.plan.usual(end - from + MORE_CELLS);
            begins = self.horizon.station_after(from, cycles * self.horizon.config.cycle);
        }
        let Some(moment) = self.moment_after(cycles) else {
            // The interrupt is changing over.
            self.try_again(Purpose::BlockEnd);
            return false;
        };
        let begun = self.horizon.begin_ending(moment);
        self.pressing.short = begun.is_none();
        self.make((Purpose::BlockEnd, at), begun)
    }

    /// Whether there is an end of a block, in what is agreed, at which the motion could rest.
    #[inline(never)]
    pub(super) fn sees_block_end(&self, at: NodeSerial) -> bool {
        self.horizon.end_in_reach(self.horizon.window.clamped_index(at)).is_some()
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// There is a draft afterwards only if there is something to look for.
    fn begin_ending(&mut self, moment: Moment<S>) -> Option<(Proposal, Stage<S>)> {
        self.draft(|draft| {
            let (stretch, branch) = draft.prepare(moment)?;
            if draft.is_stopping(stretch.first) {
                return None;
            }
            let way = draft.least_way(stretch.first);
            draft.end_behind(stretch.first, way)?;
            let proposal = Proposal { stretch, branch, halt: Some(Halt::Block) };
            Some((proposal, Stage::Ending(Ending::Trying { way, behind: stretch.first, tries: 0 })))
        })
    }

    /// The way, mm, that no stop from a station on is much shorter than.
    #[inline(never)]
    fn least_way(&self, first: usize) -> S {
        let from = self.window.get(first).map_or(PathState::REST, |station| station.agreed);
        let time = self.stop_time(first, from, &self.limits_over(first, false));
        from.b.sqrt() * time * S::of(0.5 * LEAST_WAY)
    }

    /// The first end of a block that a stop from a station on could be short enough for.
    fn end_in_reach(&self, first: usize) -> Option<usize> {
        self.end_behind(first, self.least_way(first))
    }

    /// The first station, so far behind another, mm, at which a block ends.
    #[inline(never)]
    fn end_behind(&self, first: usize, way: S) -> Option<usize> {
        let mut left = way;
        for i in first..self.end_index() {
            left -= self.window.get(i).map_or(S::ZERO, |station| station.cell.length);
            if !(left > S::ZERO) && self.ends_block(i + 1) {
                return Some(i + 1);
            }
        }
        None
    }

    /// The station up to which the agreed motion can be kept, and come to rest at the end of a stretch.
    #[inline(never)]
    fn brakes_from(&self, stretch: Stretch) -> usize {
        let mut left = S::ZERO;
        for i in (stretch.first + 1..stretch.last).rev() {
            left += self.window.get(i).map_or(S::ZERO, |station| station.cell.length);
            if left > self.least_way(i) * S::of(AMPLE) {
                return i;
            }
        }
        stretch.first + 1
    }

    /// The station that the agreed motion comes to a time, s, after another; or the last.
    #[inline(never)]
    fn station_after(&self, first: usize, time: S) -> usize {
        let mut left = time;
        for i in first..self.end_index() {
            if !(left > S::ZERO) {
                return i;
            }
            left -= self.agreed_time(i);
        }
        self.end_index()
    }

    /// A slice of looking for a rest at the end of a block: a part of a Newton step, or what comes before and after a try.
    pub fn go_on_ending(
        &mut self,
        ending: &mut Ending<S>,
        proposal: &mut Proposal,
        room: Room<'_, S, N>,
    ) -> Flow {
        let stretch = proposal.stretch;
        *ending = match ending {
            Ending::Trying { way, behind, tries } => {
                let end = self.end_behind(stretch.first, *way).map(|end| end.max(*behind + 1));
                let end = end.and_then(|end| (end..=stretch.last).find(|&i| self.ends_block(i)));
                let Some(end) = end.filter(|_| *tries < END_TRIES) else { return Flow::Nothing };
                let (way, last, tries) = (*way, stretch.last, *tries + 1);
                proposal.stretch = Stretch { last: end, ..stretch };
                self.window.set_state(end, PathState::REST);
                let new = self.brakes_from(proposal.stretch);
                let solving = self.begin_finding(proposal.stretch, new);
                Ending::Finding { solving, way, last, tries }
            }
            Ending::Finding { solving, way, last, tries } => {
                if self.go_on(solving, room) {
                    return Flow::Working;
                }
                if self.holds(stretch) && self.crawl_in(stretch).is_none() {
                    return Flow::Ready;
                }
                self.take_agreed(stretch.first..stretch.last + 1);
                proposal.stretch = Stretch { last: *last, ..stretch };
                Ending::Trying { way: *way * S::of(FARTHER), behind: stretch.last, tries: *tries }
            }
        };
        Flow::Working
    }
}
