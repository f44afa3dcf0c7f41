//! What may be changed while the machine rests with nothing to run.

use super::Planner;
use super::phase::{Phase, Rest};
use crate::block::{Block, BlockError};
use crate::machine::Limits;
use crate::number::{Coord, Scalar};

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Whether the machine rests and nothing is left to run: no block, no plan, no jog, no pause, no abort.
    pub fn is_empty(&self) -> bool {
        #[cfg(feature = "jog")]
        if self.jogging.is_on() {
            return false;
        }
        matches!(self.phase, Phase::Resting(Rest::Ready { .. }))
            && self.making.is_none()
            && !self.is_aborted()
            && self.builder.len() == 0
            && self.last_node() == self.horizon.end()
            && self.side.progress() == self.horizon.end()
    }

    /// At rest, whether what follows the setpoints rests too ([`Config::settle`](crate::Config)).
    #[cfg(feature = "shaping")]
    pub(super) fn has_settled(&self) -> bool {
        let config = &self.horizon.config;
        let cycles = self.side.cycles().since(self.rested).unwrap_or(u32::MAX);
        S::from_u32(cycles) * config.cycle >= config.settle()
    }

    /// The same where everything follows.
    #[cfg(not(feature = "shaping"))]
    #[allow(clippy::unused_self)]
    pub(super) const fn has_settled(&self) -> bool {
        true
    }

    /// Changes the limits of the axes, for all that comes. `false`, and nothing has changed, unless [`Planner::is_empty`]. Limits
    /// without motors (feature `kinematics`) leave these as they are; with motors, they come in the place of those before. These are
    /// refused, too, where axes are shaped unlike each other ([`Config::follower`](crate::Config)).
    pub fn set_limits_at_rest(&mut self, limits: Limits<S, N>) -> bool {
        let may = self.is_empty();
        #[cfg(feature = "kinematics")]
        let may = may && self.horizon.config.follows_motors_of(&limits);
        if may {
            #[cfg(feature = "kinematics")]
            let limits = if limits.names_motors() {
                limits
            } else {
                limits.on_motors_of(&self.horizon.config.limits)
            };
            #[cfg(debug_assertions)]
            self.side.watch(limits.least_jerk(), self.horizon.config.cycle);
            self.horizon.config.limit(&limits);
            self.vain = None;
        }
        may
    }

    /// Whether [`Planner::push`] would take a block that begins at a place, leaving room aside.
    ///
    /// Cost: that of taking a block.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(&self, block: &Block<S, N>, from: &[Coord; N]) -> Result<(), BlockError> {
        block.check(from, &self.horizon.config)
    }
}
