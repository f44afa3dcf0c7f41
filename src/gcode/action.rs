//! What comes out of a line.

use super::{AXES, Event, ProbeMove};
use crate::block::Block;
#[cfg(feature = "outputs")]
use crate::block::{Power, Switch};
use crate::number::Scalar;

/// One thing to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
// It lives on the stack for the length of a call; there is no heap to box it on.
#[allow(clippy::large_enum_variant)]
pub enum Action {
    /// A move or a dwell, over all nine axes, in the machine's coordinates; its tag is the number of the line.
    Move(Block<f64, AXES>),
    /// Something the machine does at rest, in order with the motion.
    Event(Event),
    /// An output that switches in time with the path, for `Planner::push_switch` (feature `outputs`).
    #[cfg(feature = "outputs")]
    Switch(Switch<f64>),
    /// The power of the moves to come, for `Planner::set_power`; `rest`: and of the dwell that follows, for
    /// `Planner::push_power` (feature `outputs`).
    #[cfg(feature = "outputs")]
    Power {
        /// Which.
        power: Power<f64>,
        /// Whether it is on at rest, too.
        rest: bool,
    },
    /// A probe, when everything before it is done: see [`ProbeMove`].
    Probe(ProbeMove),
    /// `O` and a number: here begins a program.
    Label(u32),
    /// M98: the program of this number is to be read so many times, then the line after this one.
    Call {
        /// Number behind its O.
        program: u32,
        /// Times, from 1.
        times: u32,
    },
    /// M99: back to the line after the call.
    Return,
    /// The end; what stands behind it is no part of the program.
    End,
}

impl Action {
    /// A move as a machine's block; `axes` are the indices in [`super::LETTERS`] of its axes. `None` if it is no
    /// move, or an arc in a plane that the machine has not.
    ///
    /// Moves of other axes are left out: `Settings::axes` has them refused.
    pub fn block<S: Scalar, const N: usize>(&self, axes: &[usize; N]) -> Option<Block<S, N>> {
        let Self::Move(block) = self else { return None };
        let pick =
            |place: &[_; AXES]| axes.map(|axis| place.get(axis).copied().unwrap_or_default());
        let find = |axis: usize| axes.iter().position(|&own| own == axis);
        let motion = block.motion.mapped(pick, find)?;
        Some(Block {
            motion,
            feed: block.feed.to_scalar(),
            tolerance: block.tolerance.map(S::of),
            exact_stop: block.exact_stop,
            tag: block.tag,
        })
    }
}
