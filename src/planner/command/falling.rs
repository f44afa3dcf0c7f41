//! A lowered override in stages: the motion begins to slow down while most of the fall is still to be planned.
//!
//! Where planning takes time, a whole first answer ([`easing`](super::easing)) would show only when all of it is made. So the clock is slowed down
//! as for a stop, a stage at a time ([`stages`](super::stages)), but for its end: a step is taken only if the clock, let go behind it, goes
//! no slower than is asked for. When it nearly goes like that, the whole answer ([`retune`](super::retune)) follows, from where it goes evenly on.

use super::slowing::{Begun, Goal};
use super::stages::LEAST_LEFT;
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::horizon::{EXCESS, Horizon};
use crate::planner::making::Purpose;
use crate::profile::solver::Stretch;
use crate::servo::control::Overrides;
use core::ops::Range;

/// Above what is asked for by less than this share of it, the motion has come down.
pub(super) const NEARLY: f64 = 0.006;
/// Stages of a fall at most: while they are made, nothing is planned ahead.
const STAGES: u8 = 8;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Begins a stage of a fall to other overrides, where it is made in stages and is to begin now. Whether that was looked into in this slice.
    pub(super) fn fall(&mut self, asked: Overrides, at: NodeSerial) -> bool {
        let may = self.pressing.easings == 0 && self.pressing.falls < STAGES;
        if !may || self.phase.halt().is_some() {
            return false;
        }
        let handover = self.horizon.handover(at);
        let (needed, staging) = self.stage_of_stop(handover, at);
        if staging.is_whole() && handover.is_none() {
            return false;
        }
        let start = self.start_of_stage(handover, needed);
        let begun = self.horizon.begin_slowing(start, (0, false), Goal::Overrides(asked), staging);
        if let Begun::Attempt(begun) = begun {
            return self.make((Purpose::Falling(asked), at), Some(begun));
        }
        // Nor would there be one in the next slice.
        self.pressing.falls = STAGES;
        true
    }

    /// Whether the motion is within a stage of a fall to overrides: all but the next stage branches off where it goes evenly.
    pub(in crate::planner) fn is_falling(&self, asked: Overrides, at: NodeSerial) -> bool {
        self.pressing.reacted == Some(asked) && self.horizon.is_slowed(at)
    }

    /// Whether the motion comes to rest by a stop that has been called off, and is to go on slower than before: a plan at the old pace would be many times as
    /// fast as it is asked to be.
    pub(in crate::planner) fn rests_first(&self, asked: Overrides, at: NodeSerial) -> bool {
        asked.lowers(self.horizon.overrides()) && self.horizon.slows_to_rest(at)
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// How slowly a clock must go for the agreed motion over a stretch to be what overrides ask for; `None` if it is, or need not begin to slow
    /// down at once.
    #[inline(never)]
    pub(super) fn rate_for(&self, stretch: Stretch, asked: Overrides) -> Option<S> {
        let Stretch { first, last, .. } = stretch;
        let (rate, fastest) = self.excess(first..last, asked)?;
        let now = !self.gets_going(first, asked) && self.falls_from(first, fastest, rate) == first;
        (now && rate > S::of(LEAST_LEFT)).then_some(rate)
    }

    /// The share of its speed that the agreed motion may keep over some cells by what overrides ask for, and the first station where it is too fast;
    /// `None` if it is nowhere.
    #[inline(never)]
    pub(super) fn excess(&self, cells: Range<usize>, asked: Overrides) -> Option<(S, usize)> {
        let (mut rate, mut fastest) = (S::ONE, None);
        for i in cells {
            // A standstill has no speed.
            let Some(most) = self.greatest_speed(i) else { continue };
            let goal = self.goal_at(i, asked)?;
            if most > goal {
                // What is run at that rate may be faster by a rounding.
                rate = rate.least(goal / (most * S::of(EXCESS)));
                fastest = fastest.or(Some(i));
            }
        }
        let fastest = fastest?;
        (rate < S::of(1.0 - NEARLY)).then_some((rate, fastest))
    }
}
