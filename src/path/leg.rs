//! What is asked for on a line that is a part of a run.

use super::feed;
use super::node::Programmed;
use crate::number::Scalar;

/// What is asked for on a line of the run.
#[derive(Clone, Copy, Debug)]
pub struct Leg<S> {
    pub programmed: Programmed<S>,
    /// Tolerance, mm.
    pub tolerance: S,
    /// Greatest distance of the vertices left out, mm.
    pub error: S,
}

impl<S: Scalar> Leg<S> {
    /// Whether two lines may become one, or share a span.
    pub fn is_like(&self, other: &Self) -> bool {
        feed::alike(self.programmed.feed, other.programmed.feed, feed::BLURRED)
            && self.programmed.rapid == other.programmed.rapid
            && self.programmed.limits == other.programmed.limits
            && self.tolerance == other.tolerance
    }

    /// What is asked for where both are.
    pub fn with(&self, later: &Self) -> Self {
        Self {
            programmed: Programmed {
                feed: self.programmed.feed.least(later.programmed.feed),
                linear: self.programmed.linear.with(later.programmed.linear),
                ..later.programmed
            },
            tolerance: self.tolerance.least(later.tolerance),
            error: self.error.greatest(later.error),
        }
    }
}
