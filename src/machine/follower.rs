//! What is asked of the motion by something that follows the setpoints.

use super::Limits;
use crate::number::Scalar;

/// What follows the setpoints late or not exactly, and what that takes of tolerance, acceleration and time (feature `shaping`).
/// [`Shaper::follower`](crate::output::Shaper::follower) says it of input shaping.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Follower<S, const N: usize> {
    /// How far it leaves the setpoints' path at most while they keep `acceleration`, mm: taken off every tolerance. A line whose
    /// tolerance is no more than that is run by itself: it begins `settle` after a stop. For curves that is no help, they
    /// must have more; so must lines of several axes where these do not follow alike.
    pub reserve: S,
    /// How long it takes to come to rest after the setpoints, s. Events, jogs, probes and homing wait for it.
    pub settle: S,
    /// Whether all axes follow alike, so that what is straight stays straight.
    pub alike: bool,
    /// Greatest acceleration of every axis, mm/s2, whatever its limits and those of stops say; 0 is no bound. (Where it is the bound, so
    /// is the jerk by which it is reached in two servo cycles.)
    pub acceleration: [S; N],
}

impl<S: Scalar, const N: usize> Follower<S, N> {
    /// Everything is as the setpoints say.
    pub const NONE: Self =
        Self { reserve: S::ZERO, settle: S::ZERO, alike: false, acceleration: [S::ZERO; N] };

    /// Limits that it can follow, at a servo cycle, s. Where an acceleration is lowered it is still reached within two servo cycles,
    /// or as soon as before: more jerk would be lost in the numbers.
    pub(crate) fn bound(&self, limits: &Limits<S, N>, cycle: S) -> Limits<S, N> {
        let rise = cycle * S::of(2.0);
        limits.map(|i, mut axis| {
            let most = self.acceleration.get(i).copied().unwrap_or(S::ZERO);
            if most > S::ZERO && most < axis.acceleration {
                let kept = axis.jerk / axis.acceleration * most;
                axis.acceleration = most;
                axis.jerk = axis.jerk.least((most / rise).greatest(kept));
            }
            axis
        })
    }
}
