//! Planning ahead: blocks cut into cells, and plans that go as far as is known.

use super::horizon::{ADDED, Horizon, Proposal};
use super::phase::{Halt, Phase, Rest};
use super::{Planner, Progress};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::path::cut::Cut;
use crate::path::hermite;
use crate::profile::solver::Stretch;
use crate::servo::link::Branch;

/// Room in the window for one more cell, and for the stations that a draft adds.
const LEAST_ROOM: usize = 2 + ADDED;
/// Parts of the work on a cell, at most and on average.
const PARTS: usize = 16;
/// A stop is imminent when less than this many leads remain.
const URGENT_LEADS: f64 = 4.0;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Cuts blocks into cells as long as there is room.
    pub(super) fn build(&mut self) {
        let pace = self.horizon.pace();
        for _ in 0..PARTS * NODES {
            // A cell may have to be split in two.
            if self.horizon.window.room() < LEAST_ROOM {
                return;
            }
            let Some(last) = self.horizon.window.last() else { return };
            let node = last.node;
            let cut = match self.builder.emit(&node, &self.horizon.config) {
                Cut::Cell(cut) => cut,
                Cut::Working => continue,
                Cut::Nothing => return,
            };
            self.counters.cells += 1;
            let before = self.horizon.window.serial(self.horizon.window.len() - 1);
            let lone = cut.rest && cut.cell.length > S::ZERO && self.may_rest_at(before);
            if let Some(last) = self.horizon.window.last_mut()
                && last.rest
            {
                last.node = cut.from;
            }
            if lone {
                // From rest to rest there must be a node between.
                let (first, middle, second) = hermite::split(&cut.from, &cut.cell, &cut.node);
                self.horizon.window.append(first, middle, false, &pace);
                self.horizon.window.append(second, cut.node, true, &pace);
            } else {
                self.horizon.window.append(cut.cell, cut.node, cut.rest, &pace);
            }
        }
    }

    /// Whether a plan may end at a node.
    fn may_rest_at(&self, serial: NodeSerial) -> bool {
        let rests = self
            .horizon
            .window
            .get(self.horizon.window.clamped_index(serial))
            .is_some_and(|station| station.rest);
        rests
            || serial == self.horizon.end()
            || self.phase.offer().is_some_and(|offer| offer.end == serial)
    }

    /// At rest where the plan ends: start when the look-ahead is full, when no more is to come, or
    /// when more has not come for a while.
    pub(super) fn poll_at_rest(&mut self, single: bool) -> Progress {
        let Phase::Resting(Rest::Ready { since }) = self.phase else {
            debug_assert!(false, "no rest to start from: {:?}", self.phase);
            return Progress::Waiting;
        };
        self.phase = Phase::Resting(Rest::IDLE);
        let all_planned = self.last_node() == self.horizon.end();
        if all_planned && self.builder.len() == 0 {
            return if self.finished { Progress::Done } else { Progress::NeedsBlocks };
        }
        let now = self.side.cycles();
        let since = since.unwrap_or(now);
        let config = &self.horizon.config;
        let waited = S::from_u32(now.since(since).unwrap_or(u32::MAX)) * config.cycle;
        let full = self.builder.is_full() || self.horizon.window.room() < LEAST_ROOM;
        if !(full || self.finished || waited >= config.start_delay) {
            self.phase = Phase::Resting(Rest::Ready { since: Some(since) });
            return Progress::NeedsBlocks;
        }
        if !full {
            self.builder.close();
            self.build();
        }
        self.plan(self.horizon.end(), single)
    }

    /// In motion: plan on when a part of the plan has been run or its end is near.
    pub(super) fn poll_moving(&mut self, at: NodeSerial) -> Progress {
        let Phase::Following(now) = self.phase else {
            debug_assert!(false, "no plan to follow: {:?}", self.phase);
            return Progress::Waiting;
        };
        let end = self.horizon.end_index();
        if self.horizon.window.get(end).is_some_and(|end| end.pause) {
            return Progress::Waiting;
        }
        let urgent = self.horizon.ends_within(self.horizon.config.lead * S::of(URGENT_LEADS), at);
        if urgent
            && self.horizon.window.room() >= LEAST_ROOM
            && !self.builder.is_full()
            && self.builder.len() > 0
        {
            // The blocks that wait for their neighbours must go as they are.
            self.builder.close();
            self.build();
        }
        if self.last_node() == self.horizon.end() {
            return if self.builder.len() > 0 { Progress::Waiting } else { Progress::NeedsBlocks };
        }
        let passed = !at.is_before(now.checkpoint);
        if !(passed || urgent) {
            return Progress::Waiting;
        }
        let Some(branch) = self.horizon.branch(at) else { return Progress::Waiting };
        self.plan(branch, false)
    }

    /// The last node that is known.
    fn last_node(&self) -> NodeSerial {
        let window = &self.horizon.window;
        window.serial(window.len() - 1)
    }

    /// One planning step: states for everything behind the branch, handed over as a plan.
    fn plan(&mut self, branch: NodeSerial, single: bool) -> Progress {
        let end = self.horizon.end();
        let mut made = self.horizon.plan_from(branch, single);
        if matches!(made, Made::Crawl) && branch != end {
            // The rest that is agreed comes first.
            made = self.horizon.plan_from(self.horizon.end(), single);
        }
        match made {
            Made::Plan(proposal) => {
                self.offer(Some(proposal));
                Progress::Planned
            }
            Made::Stuck => {
                self.counters.stuck += 1;
                #[cfg(feature = "defmt")]
                defmt::warn!("no motion found from node {}", branch.raw());
                Progress::Waiting
            }
            Made::NeedsBlocks => Progress::NeedsBlocks,
            Made::Crawl => Progress::Waiting,
        }
    }
}

/// What a planning step came to.
#[derive(Clone, Copy, Debug)]
enum Made {
    Plan(Proposal),
    /// There is nothing behind the end of the agreed plan that could be planned.
    NeedsBlocks,
    /// The motion would crawl: it is better to rest first.
    Crawl,
    /// No motion within the limits was found.
    Stuck,
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// A plan from a node on.
    fn plan_from(&mut self, branch: NodeSerial, single: bool) -> Made {
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
        if self.window.serial(stretch.last) == self.end() {
            return Made::NeedsBlocks;
        }
        let mut failure = Made::Stuck;
        let made = self.draft(|draft| {
            draft.loosen(stretch.first, new);
            if !draft.find(stretch, new) {
                return None;
            }
            if branch != draft.end() && draft.crawl_in(stretch).is_some() {
                failure = Made::Crawl;
                return None;
            }
            Some(Proposal { stretch, branch: Branch::Node(branch), halt })
        });
        made.map_or(failure, Made::Plan)
    }
}
