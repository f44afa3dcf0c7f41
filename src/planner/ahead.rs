//! Planning ahead: blocks cut into cells, and plans that go as far as is known.

use super::horizon::{ADDED, Horizon, Proposal};
use super::making::{Purpose, Stage};
use super::phase::{Halt, Phase, Rest};
use super::{Planner, Progress};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::path::cut::Cut;
use crate::path::hermite;
use crate::profile::solver::Stretch;
use crate::servo::control::Wish;
use crate::servo::link::Branch;

/// Room in the window for one more cell, and for the stations that a draft adds.
const LEAST_ROOM: usize = 2 + ADDED;
/// A producer from which nothing has come for this part of a lead has nothing.
const QUIET_LEADS: f64 = 0.5;
/// So many new cells are worth a plan.
const LEAST_NEW: u32 = 4;
/// And this part of all that lie ahead, while more can be cut: on a Cortex-M4F a plan takes about as long as it takes to cut a fifth as
/// many cells of dense lines. With fewer at a time planning starves the cutting: ever less of the path would be known.
const NEW_PART: u32 = 4;
/// So many are, where there is not enough to reshape.
#[cfg(feature = "reshape")]
const WANTED: u32 = 32;
/// A stop is imminent when less than this many leads remain.
const URGENT_LEADS: f64 = 4.0;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Cuts the next cell or does a part of the work for it, if there is room and enough is known. Whether anything
    /// was done.
    pub(super) fn build_one(&mut self) -> bool {
        // A cell may have to be split in two.
        if self.is_window_full() {
            return false;
        }
        let Some(last) = self.horizon.window.last() else { return false };
        let cut = match self.builder.emit(&last.node, &self.horizon.config) {
            Cut::Cell(cut) => cut,
            Cut::Working => return true,
            Cut::Nothing => return false,
        };
        self.counters.cells += 1;
        let before = self.last_node();
        #[cfg(feature = "outputs")]
        let (stands, begin) = (!(cut.cell.length > S::ZERO), last.arc_length);
        let lone = cut.rest && cut.cell.length > S::ZERO && self.may_rest_at(before);
        if let Some(last) = self.horizon.window.last_mut()
            && last.rest
        {
            last.node = cut.from;
        }
        if lone {
            // From rest to rest there must be a node between.
            let (first, middle, second) = hermite::split(&cut.from, &cut.cell, &cut.node);
            self.horizon.append(first, middle, false);
            self.horizon.append(second, cut.node, true);
        } else {
            self.horizon.append(cut.cell, cut.node, cut.rest);
        }
        #[cfg(feature = "outputs")]
        self.note_cut(stands, begin);
        true
    }

    /// Whether there is enough new for a plan that is wanted only to have more to reshape.
    #[allow(clippy::unused_self)]
    fn reshaping_wants(&self) -> bool {
        #[cfg(feature = "reshape")]
        if self.reshaping.as_ref().is_some_and(|memory| memory.wants) && self.new_cells() >= WANTED
        {
            return true;
        }
        false
    }

    /// Whether the window has no more room than is kept in it.
    fn is_window_full(&self) -> bool {
        #[cfg(feature = "reshape")]
        let kept = self.reshaping.as_ref().map_or(0, |_| super::reshaping::reserve::<NODES>());
        #[cfg(not(feature = "reshape"))]
        let kept = 0;
        self.horizon.window.room() < LEAST_ROOM + kept
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
    #[inline(never)]
    pub(super) fn poll_at_rest(&mut self, at: NodeSerial, single: bool) -> Progress {
        // A plan that was on offer has been withdrawn in this call: the rest is looked at in the next.
        let Phase::Resting(Rest::Ready { since }) = self.phase else { return Progress::Planning };
        self.phase = Phase::Resting(Rest::IDLE);
        let all_planned = self.last_node() == self.horizon.end();
        if all_planned && self.builder.len() == 0 {
            return if self.finished { Progress::Done } else { Progress::NeedsBlocks };
        }
        let now = self.side.cycles();
        let since = since.unwrap_or(now);
        let config = &self.horizon.config;
        let waited = S::from_u32(now.since(since).unwrap_or(u32::MAX)) * config.cycle;
        let full = self.builder.is_full() || self.is_window_full();
        if !(full || self.finished || waited >= config.start_delay) {
            self.phase = Phase::Resting(Rest::Ready { since: Some(since) });
            return Progress::NeedsBlocks;
        }
        if !full {
            self.builder.hurry(&self.horizon.config);
        }
        if self.is_vain(at) {
            return Progress::Waiting;
        }
        if !full && self.is_quiet() {
            self.builder.close();
            if self.build_one() {
                self.phase = Phase::Resting(Rest::Ready { since: Some(since) });
                return Progress::Planning;
            }
        }
        self.plan(self.horizon.end(), at, single || self.pressing.short)
    }

    /// In motion: whether a plan must be begun now with what is known, before more is cut: the motion will soon show
    /// that the present plan ends.
    pub(super) fn is_pressed(&self, at: NodeSerial) -> bool {
        let Phase::Following(now) = self.phase else { return false };
        let until = self.planned(at) + self.horizon.config.lead;
        self.new_cells() >= LEAST_NEW.max(self.cells_ahead(at) as u32 / NEW_PART)
            && !self.is_vain(at)
            && self.horizon.reaches_within(until, at, now.shown)
    }

    /// Whether a plan from station `first` on, which is decided on there, would leave no time for another that goes further, before the
    /// motion shows that the present one ends.
    #[cfg(feature = "reshape")]
    pub(super) fn leaves_no_time(&self, first: usize, at: NodeSerial) -> bool {
        let Phase::Following(now) = self.phase else { return false };
        let until = self.in_time(at);
        let shown = self.horizon.window.clamped_index(now.shown);
        self.last_node() != self.horizon.end()
            && self.horizon.window.takes_less(first..shown.max(first), until)
    }

    /// Cells behind the end of the agreed plan.
    fn new_cells(&self) -> u32 {
        self.last_node().since(self.horizon.end()).unwrap_or(0)
    }

    /// Whether no block has come for so long that the producer has none: one that has some pushes them whenever there
    /// is room.
    fn is_quiet(&self) -> bool {
        let config = &self.horizon.config;
        let cycles = self.side.cycles().since(self.pushed).unwrap_or(u32::MAX);
        S::from_u32(cycles) * config.cycle >= config.lead * S::of(QUIET_LEADS)
    }

    /// How long it takes to make a plan over all cells that lie ahead, s.
    fn planned(&self, at: NodeSerial) -> S {
        self.effort.plan.cycles(self.cells_ahead(at)) * self.horizon.config.cycle
    }

    /// So long before the motion shows that the agreed plan ends, s, the next one is begun: early enough for a second try, since one plan
    /// in some is hard to find.
    fn in_time(&self, at: NodeSerial) -> S {
        let planned = self.planned(at);
        planned + planned + self.horizon.config.lead
    }

    /// Cells of the window that lie ahead of a node.
    pub(super) fn cells_ahead(&self, at: NodeSerial) -> usize {
        self.horizon.window.len() - 1 - self.horizon.window.clamped_index(at)
    }

    /// In motion: plan on when a part of the plan has been run, or its end is near or begins to show.
    #[inline(never)]
    pub(super) fn poll_moving(&mut self, at: NodeSerial) -> Progress {
        let Phase::Following(now) = self.phase else {
            debug_assert!(false, "no plan to follow: {:?}", self.phase);
            return Progress::Waiting;
        };
        let end = self.horizon.end_index();
        if self.horizon.window.get(end).is_some_and(|end| end.pause) {
            return Progress::Waiting;
        }
        let (lead, planned) = (self.horizon.config.lead, self.planned(at));
        let soon = (lead * S::of(URGENT_LEADS)).greatest(planned + lead);
        // Asked for only where it counts: it looks at many cells, and most polls in motion only wait for blocks.
        let is_urgent =
            |planner: &Self| planner.horizon.reaches_within(soon, at, planner.horizon.end());
        if self.new_cells() < LEAST_NEW
            && !self.builder.is_full()
            && self.horizon.reaches_within(soon, at, now.shown)
        {
            self.builder.hurry(&self.horizon.config);
        }
        if !self.is_window_full()
            && !self.builder.is_full()
            && self.builder.len() > 0
            && self.is_quiet()
            && is_urgent(self)
        {
            // The blocks that wait for their neighbours must go as they are.
            self.builder.close();
            if self.build_one() {
                return Progress::Planning;
            }
        }
        if self.last_node() == self.horizon.end() {
            return if self.builder.len() > 0 { Progress::Waiting } else { Progress::NeedsBlocks };
        }
        let due = !at.is_before(now.checkpoint)
            || is_urgent(self)
            || self.reshaping_wants()
            || self.horizon.reaches_within(self.in_time(at), at, now.shown);
        if !due || self.is_vain(at) {
            return Progress::Waiting;
        }
        let (work, cycle) = (self.effort.plan, self.horizon.config.cycle);
        let Some(branch) = self.horizon.branch(at, |cells| work.cycles(cells) * cycle) else {
            return Progress::Waiting;
        };
        self.plan(branch, at, false)
    }

    /// Whether what a poll in motion finds to do, which has been nothing, depends on no more than where the motion is: the window or the
    /// look-ahead is full, and what is asked for is done.
    pub(super) fn waits_for_motion(&self, wish: &Wish) -> bool {
        #[cfg(feature = "reshape")]
        if self.reshaping.is_some() {
            return false;
        }
        let full =
            self.builder.is_full() || (self.is_window_full() && self.new_cells() >= LEAST_NEW);
        full && matches!(self.phase, Phase::Following(_)) && self.is_calm(wish)
    }

    /// Whether there is nothing to do since the last poll has found nothing.
    #[inline]
    pub(super) fn is_idle(&self, wish: &Wish, at: NodeSerial) -> bool {
        self.idle && self.idle_at == at && self.is_calm(wish)
    }

    /// Whether nothing is asked for that has not been answered.
    #[inline]
    fn is_calm(&self, wish: &Wish) -> bool {
        let asks = self.brakes(wish) || wish.stops_at_end();
        let answered = wish.resumes == self.answered.resumes && wish.quick == self.answered.quick;
        !asks && answered && self.horizon.is_paced(wish.overrides)
    }

    /// The last node that is known.
    pub(super) fn last_node(&self) -> NodeSerial {
        let window = &self.horizon.window;
        window.serial(window.len() - 1)
    }

    /// Begins a plan from a node on, over everything behind it.
    pub(super) fn plan(&mut self, branch: NodeSerial, at: NodeSerial, single: bool) -> Progress {
        let Some((mut proposal, new)) = self.horizon.propose_from(branch, single) else {
            return Progress::NeedsBlocks;
        };
        let stretch = proposal.stretch;
        self.horizon.begin_draft();
        self.horizon.loosen(stretch.first, new);
        let solving = self.horizon.begin_finding(stretch, new);
        // Where nothing would change, the agreed plan is run on.
        proposal.stretch.first = solving.first();
        proposal.branch = Branch::Node(self.horizon.window.serial(solving.first()));
        self.make(
            (Purpose::Ahead, at),
            Some((proposal, Stage::Solving { solving, guessed: Some(new) })),
        );
        Progress::Planning
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// What a plan from a node on runs through, and the first station of it that has no state; `None` if nothing
    /// lies behind the end of the agreed plan that could be planned.
    fn propose_from(&mut self, branch: NodeSerial, single: bool) -> Option<(Proposal, usize)> {
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
        let goes_on = self.window.serial(stretch.last) != self.end();
        goes_on.then_some((Proposal { stretch, branch: Branch::Node(branch), halt }, new))
    }
}
