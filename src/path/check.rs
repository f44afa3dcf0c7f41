//! The checks of a push, without a planner.

use super::chords::Chords;
use super::queued::QueuedBlock;
use crate::block::{Block, BlockError};
use crate::machine::Config;
use crate::number::{Coord, Scalar};

impl<S: Scalar, const N: usize> Block<S, N> {
    /// Whether a planner with this configuration would take the block, from where the block before it ends:
    /// to find what is wrong with a whole program before the first block of it is sent.
    ///
    /// Costs what taking it in costs, some hundred operations; nothing is planned.
    ///
    /// # Errors
    /// What `Planner::push` would refuse it for.
    pub fn check(&self, from: &[Coord; N], config: &Config<S, N>) -> Result<(), BlockError> {
        match Chords::new(*from, self, config)? {
            // The first chord stands for all, as when it is pushed.
            Some(chords) => {
                QueuedBlock::new(*from, &chords.line(), Some(chords.whole()), config).map(|_| ())
            }
            None => QueuedBlock::new(*from, self, None, config).map(|_| ()),
        }
    }
}
