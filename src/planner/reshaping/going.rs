//! The agreed motion as reshaping sees it: states by time, and the line that each is in.

use crate::machine::{Config, LEAST_CYCLE_SHARE};
use crate::number::{Coord, Scalar};
use crate::planner::horizon::Horizon;
use crate::reshape::{Agreed, Line, Onward, Places, State};
use heapless::Vec;

/// Places at which the agreed motion is held against the lines.
pub const PLACES: usize = 320;

/// The jerk of a cell changes by at most so many roundings of a speed at its ends over its time squared; and the share of the limit that
/// they may be.
const ROUNDINGS: f64 = 32.0;
const ROUNDED: f64 = 4.0e-3;

/// Cells of a stretch, at most.
const CELLS: usize = 256;

/// Times at which the cells of a stretch begin, s from a station in it, and the last ends. Made once for a window: each takes a division
/// or two.
pub type Times<S> = Vec<S, { CELLS + 1 }>;

/// The agreed motion about a station.
pub struct Going<'a, S: Scalar, const N: usize, const NODES: usize> {
    pub horizon: &'a Horizon<S, N, NODES>,
    /// The first cell whose time is known.
    pub first: usize,
    /// From the station on.
    pub times: &'a Times<S>,
    /// What positions are about.
    pub origin: [Coord; N],
    /// When it ends for this purpose, s from the station.
    pub ends: S,
    /// Least time of what is left of a cell where it is joined, s.
    pub least: S,
    /// The lines, and which of them the motion is in when, from that cell on; how many of them lie before the station.
    pub lines: &'a [Line<S, N>],
    pub places: Option<&'a Places<S, PLACES>>,
    pub passed: usize,
}

/// A cell takes at least so long, s, that a speed which is rounded at its ends is worth no more than a share of the jerk.
pub fn least_time<S: Scalar, const N: usize>(config: &Config<S, N>) -> S {
    let most = config
        .limits
        .axes()
        .iter()
        .fold(S::ZERO, |most, axis| most.greatest(axis.velocity / axis.jerk));
    let least = (S::EPSILON * most * S::of(ROUNDINGS / ROUNDED)).sqrt();
    least.greatest(config.cycle * S::of(LEAST_CYCLE_SHARE * 1.1))
}

impl<S: Scalar, const N: usize, const NODES: usize> Going<'_, S, N, NODES> {
    /// The cell of a time from the station on, and how long after its start that is.
    pub fn cell(&self, time: S) -> (usize, S) {
        // Those that begin after the first, but for the end of the last.
        let starts = self.times.get(1..self.times.len().saturating_sub(1)).unwrap_or(&[]);
        let cell = starts.partition_point(|start| time >= *start);
        let begun = self.times.get(cell).copied().unwrap_or(S::ZERO);
        (self.first + cell, (time - begun).greatest(S::ZERO))
    }

    /// State with jerk and its rate, a time from the station on.
    pub fn state(&self, time: S) -> Onward<S, N> {
        let (cell, t) = self.cell(time);
        let none = [S::ZERO; N];
        let Some(piece) = self.horizon.piece_within(cell) else {
            let at = self.horizon.window.get(cell).map_or([Coord::ZERO; N], |at| at.node.at);
            let position = core::array::from_fn(|i| at[i].minus(self.origin[i]));
            return Onward { state: State::resting(position), jerk: none, snap: none };
        };
        let t = t.least(piece.time);
        let mut onward = Onward { state: State::resting(none), jerk: none, snap: none };
        let of = S::of;
        for i in 0..N {
            let [a, b, c, d, e] = piece.axes[i];
            let start: S = piece.origin[i].minus(self.origin[i]);
            let State { position, velocity, acceleration } = &mut onward.state;
            position[i] = start + t * (a + t * (b + t * (c + t * (d + t * e))));
            velocity[i] =
                a + t * (of(2.0) * b + t * (of(3.0) * c + t * (of(4.0) * d + t * of(5.0) * e)));
            acceleration[i] =
                of(2.0) * b + t * (of(6.0) * c + t * (of(12.0) * d + t * of(20.0) * e));
            onward.jerk[i] = of(6.0) * c + t * (of(24.0) * d + t * of(60.0) * e);
            onward.snap[i] = of(24.0) * d + t * of(120.0) * e;
        }
        onward
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Agreed<S, N> for Going<'_, S, N, NODES> {
    fn at(&self, time: S) -> Onward<S, N> {
        self.state(time.least(self.ends))
    }

    fn line(&self, time: S) -> usize {
        let place = self.state(time).state.position;
        let line =
            self.places.and_then(|at| at.line(self.lines, time - *self.times.first()?, &place));
        line.and_then(|line| line.checked_sub(self.passed)).unwrap_or(usize::MAX)
    }

    fn can_be_joined(&self, time: S) -> S {
        let (cell, t) = self.cell(time);
        let left = (self.horizon.time(cell) - self.least).greatest(S::ZERO);
        if t <= left || self.times.last().is_none_or(|end| time >= *end) {
            return time;
        }
        self.times.get(cell - self.first).map_or(time, |begun| *begun + left)
    }

    fn end(&self) -> S {
        self.ends
    }
}
