//! Where a line may be run by the axes' full limits though what follows the setpoints cannot bear them: it leaves the path only where
//! that bends, within the time that it looks back or needs to settle.

use super::{Body, Front};
use crate::machine::{Config, UNLIMITED};
use crate::number::vector::{norm, sub};
use crate::number::{Length, Scalar};
use crate::path::queued::Joint;

/// How much faster than programmed an operator may let a line be run.
const MOST_OVERRIDE: f64 = 2.0;

/// The free part of a line, and where cells end for it.
#[derive(Clone, Copy, Debug)]
pub struct Free {
    from: Length,
    to: Length,
    /// A joint that is passed bends the cell next to it: behind these places.
    bends: [Length; 2],
}

/// Greatest speed at the beginning and end of a joint, mm/s: what a line beside it is left or entered with.
///
/// A corner of turn `theta` takes `L` of either line and is at most `2 L` long, so that somewhere its curvature is `theta / 2 L` at
/// least. There the square of the speed is at most `2 a L / theta`, with `a` the greatest acceleration in any direction,
/// and from there to either end it gains `4 a L` at most. `alike`: the limits are the same on either side.
pub fn beside<S: Scalar, const N: usize>(
    joint: Joint,
    (before, after): (&[S; N], &[S; N]),
    (taken, alike): (Length, bool),
    config: &Config<S, N>,
) -> S {
    match joint {
        Joint::Stop => S::ZERO,
        Joint::Corner if alike => {
            let mut square = S::ZERO;
            for axis in config.limits.axes() {
                square += axis.acceleration * axis.acceleration;
            }
            // A chord is shorter than its angle.
            let turn = norm(&sub(after, before));
            let two = S::of(2.0);
            (square.sqrt() * taken.to_mm::<S>() * (two / turn + two + two)).sqrt()
        }
        Joint::Corner | Joint::Through | Joint::Blend | Joint::Run => S::of(UNLIMITED),
    }
}

impl Free {
    /// That of the front segment, if there is one; `speeds` are those at the joints before and behind it ([`beside`]).
    ///
    /// For so long as it takes to settle, `T`, the motion before and behind a bend must be one that can be borne. In that time it goes
    /// `v T + a T^2 / 2` at most, with `v` the speed at the bend and `a` the acceleration that can be borne.
    #[inline(never)]
    pub fn of<S: Scalar, const N: usize>(
        Front { block, segment, entrance }: &Front<S, N>,
        body: &Body<S>,
        speeds: [S; 2],
        config: &Config<S, N>,
    ) -> Option<Self> {
        let direction = segment.start_frame().tangent;
        let mut most = block.feed * S::of(MOST_OVERRIDE);
        for (axis, share) in config.limits.axes().iter().zip(&direction) {
            let share = share.abs();
            if share * most > axis.velocity {
                most = axis.velocity / share;
            }
        }
        let [acceleration, _] = config.limits.along(&direction);
        // Rounding, and servo cycles that have begun.
        let time = config.settle() + config.cycle + config.cycle;
        let away = speeds.map(|speed| {
            let way = (speed.least(most) + acceleration * time * S::of(0.5)) * time;
            Length::from_mm(way)
        });
        let margin = |joint: Joint, away: Length| {
            if joint == Joint::Through { away + away } else { away }
        };
        let from = entrance.taken + margin(entrance.joint, away[0]);
        let to = body.until - margin(block.joint, away[1]);
        let bends = [entrance.taken + away[0], body.until - away[1]];
        // A part that is not longer than what lies beside it is no gain.
        (to - from > (away[0] + away[1]) / 2).then_some(Self { from, to, bends })
    }

    /// A goal, or the end of a part before it.
    pub fn goal(&self, s: Length, goal: Length) -> Length {
        let [first, last] = self.bends;
        let ends = [first, self.from, self.to, last];
        ends.into_iter().find(|&end| s < end && end < goal).unwrap_or(goal)
    }

    /// Whether a cell lies in it.
    pub fn holds(&self, s: Length, next: Length) -> bool {
        self.from <= s && next <= self.to
    }
}
