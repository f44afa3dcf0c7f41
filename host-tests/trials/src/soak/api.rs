//! How the core answers to an abort, and what the bugs make of it.

use super::plant::Plant;
use splineway::{Planner, PushError, Scalar};

/// Acknowledges an abort that is complete.
pub fn acknowledge<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
) -> bool {
    planner.acknowledge_abort()
}

/// What the producer is told.
pub fn told<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    planner: &mut Planner<'_, S, N, BLOCKS, NODES>,
    block: &splineway::Block<S, N>,
    plant: Option<Plant>,
) -> Result<(), PushError> {
    let result = planner.push(block);
    if plant == Some(Plant::TakenAfterAbort) && result == Err(PushError::Aborted) {
        // As if nothing had been: as soon as it can be, it is taken.
        planner.acknowledge_abort();
        return planner.push(block).map_err(|_| PushError::Full);
    }
    result
}
