//! Answers to overrides of feed and rapids, slice by slice.

use super::Flow;
use super::easing::time_of_fall;
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::horizon::{Horizon, Moment, Proposal};
use crate::planner::making::{Purpose, Stage};
use crate::planner::phase::Halt;
use crate::profile::law::PathState;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::solving::Solving;
use crate::servo::control::Overrides;
use crate::servo::link::{Branch, Room};

/// Leads within which a node is waited for where an override finds no answer at once.
const NEAR_LEADS: f64 = 4.0;
/// What is faster than it is asked to be by this factor is far from it, after so many times as long as a fall to that takes on a straight.
const FAR_ABOVE: f64 = 1.1;
const LONG_ENOUGH: f64 = 2.0;
/// So many answers to a command that fall short are followed by another.
const SHORT_FALLS: u8 = 100;
/// Tries in a row: from a servo cycle on, and from a node on.
const TRIES: u8 = 2;

/// A plan at other overrides in the making.
#[derive(Clone, Copy, Debug)]
pub enum Retuning<S> {
    /// The agreed motion is cut where it is left, and is to be cut finer; up to station `from` it is left as it is.
    Cut { from: usize },
    /// States are being found from a guess, as for a new plan.
    Finding(Solving<S>),
    /// The agreed ones are brought down to the goal, at a penalty.
    Slowing(Solving<S>),
    /// With the speeds reached as bounds, states of least time are being found.
    Improving(Solving<S>),
}

/// Where a plan at other overrides leaves the agreed one.
#[derive(Clone, Copy, Debug)]
enum Leaves<S> {
    /// Within a cell.
    Within(Moment<S>),
    /// At a node.
    At(NodeSerial),
}

/// What the beginning of a try has come to.
#[derive(Clone, Copy, Debug)]
enum Begun<S> {
    /// It is under way, in a draft.
    Attempt((Proposal, Stage<S>)),
    /// The motion does nothing but come to rest.
    Stops,
    /// The motion cannot be cut there.
    Nothing,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Begins a plan at other overrides: from a servo cycle on, or else from a node on. Whether one is in the making.
    pub(super) fn retune(&mut self, overrides: Overrides, at: NodeSerial) -> bool {
        if self.ease(overrides, at) || self.react(overrides, at) {
            return true;
        }
        if self.is_falling(overrides, at) {
            return false;
        }
        let now = self.side.cycles();
        let others = self.pressing.refused.is_some_and(|refused| refused != overrides);
        if self.is_due(at) || others {
            self.pressing.retunes = 0;
        }
        self.pressing.refused = None;
        let halt = self.phase.halt();
        // The motion as it slows down is the best there is.
        let eased = self.pressing.reacted == Some(overrides);
        while self.pressing.retunes < TRIES {
            let by_cycle = self.pressing.retunes == 0;
            self.pressing.retunes += 1;
            (self.pressing.at, self.pressing.retuned) = (at, now);
            let leaves = if by_cycle {
                self.moment_of_answer(at).map(Leaves::Within)
            } else {
                let node = self.horizon.branch(at, |_| S::ZERO);
                node.filter(|node| self.horizon.is_near(at, *node)).map(Leaves::At)
            };
            let begun = self.horizon.begin_retune((overrides, eased), halt, leaves);
            match begun {
                Begun::Attempt(begun) => return self.make((Purpose::Overrides, at), Some(begun)),
                Begun::Stops => {
                    // A stop under way is finished; what comes after it goes at the new pace.
                    self.horizon.set_overrides(overrides);
                    return false;
                }
                Begun::Nothing => {}
            }
        }
        self.pressing.refused = Some(overrides);
        false
    }

    /// Makes no more tries at other overrides for now.
    pub(super) fn refuse(&mut self, overrides: Overrides, at: NodeSerial) {
        (self.pressing.at, self.pressing.retuned) = (at, self.side.cycles());
        self.pressing.refused = Some(overrides);
    }

    /// A whole answer has been made. Whether it falls short, and is followed by another: the next slows the motion down as a first answer does, by a
    /// clock, which can from any speed.
    pub(in crate::planner) fn look_at_answer(&mut self, stretch: Stretch) -> bool {
        let Self { pressing, horizon, .. } = self;
        let short = pressing.short_falls < SHORT_FALLS && horizon.falls_short(stretch);
        if short {
            pressing.short_falls += 1;
            (pressing.reacted, pressing.eased) = (Some(horizon.overrides()), None);
            horizon.mark_eased(stretch.first);
        }
        short
    }

    /// Whether the motion has come far enough since the last try for more of them.
    fn is_due(&self, at: NodeSerial) -> bool {
        let waited = self.side.cycles().since(self.pressing.retuned).unwrap_or(0);
        at != self.pressing.at || waited >= self.most_reaction()
    }

    /// Whether these overrides cannot be come to for now. Until they can, a plan on offer stands: one that is withdrawn for
    /// nothing is made again in the same servo cycle, without an end.
    pub(super) fn is_refused(&self, overrides: Overrides, at: NodeSerial) -> bool {
        self.pressing.refused == Some(overrides) && !self.is_due(at)
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Whether a node before the end of the plan is near enough to wait for: one that is far off would only
    /// keep the next try waiting.
    fn is_near(&self, at: NodeSerial, node: NodeSerial) -> bool {
        let all = self.window.clamped_index(at)..self.window.clamped_index(node);
        let time = all.fold(S::ZERO, |time, i| time + self.agreed_time(i));
        node != self.end() && time < self.config.lead * S::of(NEAR_LEADS)
    }

    /// Begins a plan at other overrides from where it `leaves` the agreed one. There is a draft afterwards only if there is
    /// an attempt. With `eased`, the motion slows down for these very overrides, and what it does until it has come down is left as it is.
    #[inline(never)]
    fn begin_retune(
        &mut self,
        (overrides, eased): (Overrides, bool),
        halt: Option<Halt>,
        leaves: Option<Leaves<S>>,
    ) -> Begun<S> {
        let mut stops = false;
        let begun = self.draft(|draft| {
            let behind = draft.cells_behind_easing().filter(|_| eased);
            let (first, branch) = match leaves? {
                Leaves::Within(moment) => draft.cut_in(moment)?,
                Leaves::At(node) => (draft.window.clamped_index(node), Branch::Node(node)),
            };
            let end = draft.end_index();
            let from = behind.map_or(first, |cells| {
                let behind = end.saturating_sub(cells).max(first);
                (first..behind).find(|&i| draft.is_down(i, overrides)).unwrap_or(behind)
            });
            stops = from == end || (branch.is_by_cycle() && draft.is_stopping(from));
            if stops {
                return None;
            }
            // Not before it is known that there is a try: all cells are bounded anew, and again when a draft at other overrides is dropped.
            draft.try_overrides(overrides);
            draft.bound_from(first);
            let stretch = Stretch { first, last: end, open: false };
            let proposal = Proposal { stretch, branch, halt };
            Some((proposal, Stage::Retuning(Retuning::Cut { from })))
        });
        match begun {
            Some(begun) => Begun::Attempt(begun),
            None if stops => Begun::Stops,
            None => Begun::Nothing,
        }
    }

    /// Whether the agreed motion is no faster at a station than it is asked to be.
    #[inline(never)]
    fn is_down(&self, i: usize, asked: Overrides) -> bool {
        let speed = self.window.get(i).map_or(S::ZERO, |station| station.agreed.b.sqrt());
        self.goal_at(i, asked).is_some_and(|goal| speed <= goal)
    }

    /// Cuts the motion finer from station `from` on, and begins to look for states.
    #[inline(never)]
    fn refine_retuning(&mut self, from: usize, proposal: &mut Proposal) -> Retuning<S> {
        let Stretch { first, last: end, .. } = proposal.stretch;
        let mut stretch = Stretch { first: from, last: end, open: false };
        let speed = self.window.get(from).map_or(S::ZERO, |station| station.state.b.sqrt());
        let distance = self.ramp(from, speed).greatest(self.braking_distance(from));
        (stretch.last, _) = self.refine(from, end, distance);
        self.loosen(first, stretch.last);
        let slower = self.exceeds_goal(stretch);
        stretch.open = proposal.halt.is_none() && self.is_open(stretch);
        proposal.stretch = Stretch { first, ..stretch };
        if slower {
            // First down to the goal, at a penalty; then, with the speeds reached as bounds, for time.
            Retuning::Slowing(self.begin_improving(stretch, Aim::Slow))
        } else {
            Retuning::Finding(self.begin_finding(stretch, from + 1))
        }
    }

    /// Whether a speed in a stretch is more than what is asked for. Asked after [`Horizon::loosen`].
    #[inline(never)]
    pub(super) fn exceeds_goal(&self, stretch: Stretch) -> bool {
        (stretch.first..stretch.last).any(|i| {
            self.window.get(i).is_some_and(|station| station.bounds.speed > station.bounds.goal)
        })
    }

    /// Whether the states found for a stretch are far faster than what is asked for, long after they could have come down to it: from a speed many
    /// times as high the steps that there are do not lead there.
    #[inline(never)]
    fn falls_short(&self, stretch: Stretch) -> bool {
        let Stretch { first, last, .. } = stretch;
        let Some(station) = self.window.get(first) else { return false };
        let [acceleration, jerk] = self.limits_over(first, false).along(&station.node.tangent);
        let PathState { b, a } = station.state;
        let a = a.greatest(S::ZERO);
        let less = b.sqrt() + a * a / (jerk + jerk) - station.bounds.goal;
        let fall = a / jerk + time_of_fall(less.greatest(S::ZERO), acceleration, jerk);
        let mut left = fall * S::of(LONG_ENOUGH) + self.config.lead;
        (first..last).any(|i| {
            let Some((station, next)) = self.window.pair(i) else { return false };
            let [from, to] = [station, next].map(|station| station.state.b.sqrt());
            if left < S::ZERO && from.least(to) > station.bounds.goal * S::of(FAR_ABOVE) {
                return true;
            }
            if from + to > S::ZERO {
                left -= station.cell.length * S::of(2.0) / (from + to);
            }
            false
        })
    }

    /// A slice of it: the cuts, or one Newton step.
    pub fn go_on_retuning(
        &mut self,
        retuning: &mut Retuning<S>,
        proposal: &mut Proposal,
        room: Room<'_, S, N>,
    ) -> Flow {
        let solving = match retuning {
            Retuning::Cut { from } => {
                *retuning = self.refine_retuning(*from, proposal);
                return Flow::Working;
            }
            Retuning::Finding(solving)
            | Retuning::Slowing(solving)
            | Retuning::Improving(solving) => solving,
        };
        if self.go_on(solving, room) {
            return Flow::Working;
        }
        let stretch = proposal.stretch;
        let found = Stretch { first: solving.first(), ..stretch };
        // Where the agreed motion crawls, one that soon does not is better.
        let runs = |horizon: &mut Self| horizon.holds(stretch) && !horizon.crawls_anew(stretch);
        match retuning {
            Retuning::Cut { .. } | Retuning::Finding(_) => {
                if runs(self) {
                    return Flow::Ready;
                }
                self.take_agreed(stretch.first..stretch.last + 1);
            }
            Retuning::Slowing(_) => self.loosen(stretch.first, stretch.last),
            Retuning::Improving(_) => {
                self.loosen(stretch.first, stretch.last);
                return if runs(self) { Flow::Ready } else { Flow::Nothing };
            }
        }
        *retuning = Retuning::Improving(self.begin_improving(found, Aim::Time));
        Flow::Working
    }
}
