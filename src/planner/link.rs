//! The memory of a core, and the two handles on it.

use super::command::Answered;
use super::command::reaction::Pressing;
use super::effort::Effort;
use super::horizon::Horizon;
#[cfg(feature = "jog")]
use super::jogging::Jogging;
use super::phase::{Phase, Rest};
use super::{Counters, Planner};
use crate::block::BlockError;
use crate::block::range::check_coordinates;
use crate::machine::{Config, ConfigError, SetNumber};
use crate::number::vector::zero;
use crate::number::{Coord, Scalar};
use crate::path::builder::Builder;
use crate::path::node::Node;
use crate::servo::Interpolator;
use crate::servo::link::{Channel, Origin};

/// The memory of a core, and the one place where its size is named: `N` axes, a look-ahead of `BLOCKS` blocks, a
/// planning window of `NODES` nodes. [`Link::split`] gives the two handles.
///
/// In firmware a `static`, in no need of a start-up copy: an empty link is all zeros. A type that names no sizes,
/// `Link<f32, 3>`, has [`BLOCKS`](crate::BLOCKS) and [`NODES`](crate::NODES).
pub struct Link<
    S: Scalar,
    const N: usize,
    const BLOCKS: usize = { crate::machine::BLOCKS },
    const NODES: usize = { crate::machine::NODES },
> {
    /// The only part that the interrupt uses.
    channel: Channel<S, N, NODES>,
    builder: Builder<S, N, BLOCKS>,
    horizon: Horizon<S, N, NODES>,
    #[cfg(feature = "jog")]
    jogging: Jogging<N>,
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize> Default
    for Link<S, N, BLOCKS, NODES>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize> Link<S, N, BLOCKS, NODES> {
    /// An empty link; it can live in a `static`.
    pub const fn new() -> Self {
        Self {
            channel: Channel::new(),
            builder: Builder::EMPTY,
            horizon: Horizon::EMPTY,
            #[cfg(feature = "jog")]
            jogging: Jogging::NONE,
        }
    }

    /// The two handles of a core that rests at `start`: the planner for the background, the interpolator for the
    /// servo interrupt. Both are `Send`. What an earlier split has left in the link is forgotten.
    ///
    /// Cost: a few thousand instructions; nothing large is moved.
    ///
    /// # Errors
    /// [`ConfigError`] if a setting or the start is out of its range; the link is unchanged.
    pub fn split(
        &mut self,
        config: Config<S, N>,
        start: [Coord; N],
    ) -> Result<(Planner<'_, S, N, BLOCKS, NODES>, Interpolator<'_, S, N>), ConfigError> {
        self.split_from(config, start, Origin::ZERO)
    }

    /// The same with numbers that count on from others than 0.
    pub(super) fn split_from(
        &mut self,
        config: Config<S, N>,
        start: [Coord; N],
        origin: Origin,
    ) -> Result<(Planner<'_, S, N, BLOCKS, NODES>, Interpolator<'_, S, N>), ConfigError> {
        const { assert!(N >= 1 && N <= 9, "1 to 9 axes") };
        config.check()?;
        if let Err(BlockError::Coordinate { axis, error }) = check_coordinates(&start) {
            return Err(ConfigError::Start { axis, error });
        }
        let Self { channel, builder, horizon, .. } = self;
        #[cfg(feature = "jog")]
        self.jogging.clear();
        let (side, servo, requests) = channel.ends(origin);
        #[cfg(debug_assertions)]
        side.watch(config.limits.least_jerk(), config.cycle);
        builder.restart(start);
        builder.set_limits(SetNumber::FIRST);
        horizon.begin(&config, Node { at: start, tangent: zero(), curvature: zero() }, origin.node);
        Ok((
            Planner {
                side,
                requests,
                builder,
                horizon,
                #[cfg(feature = "jog")]
                jogging: &mut self.jogging,
                #[cfg(feature = "reshape")]
                reshaping: None,
                phase: Phase::Resting(Rest::IDLE),
                making: None,
                effort: Effort::NONE,
                vain: None,
                idle: false,
                idle_at: origin.node,
                knows_stops: false,
                answered: Answered::default(),
                pressing: Pressing::NONE,
                finished: false,
                pushed: origin.cycle,
                reaction: 0,
                counters: Counters::default(),
                #[cfg(feature = "outputs")]
                switches: super::switches::Switches::NONE,
                // As long ago as the numbers reach.
                #[cfg(feature = "shaping")]
                rested: origin.cycle.plus(u32::MAX / 2 + 2),
            },
            Interpolator::new(servo, (origin.node, start), config.cycle),
        ))
    }
}
