//! From the knots of a motion to stations.

use super::going::Going;
use super::{POINTS, STATIONS};
use crate::number::Scalar;
use crate::number::vector::{dot, norm};
use crate::path::budget;
use crate::path::node::{Cell, Node};
use crate::profile::bounds::LEAST_CYCLE_SHARE;
use crate::profile::law::PathState;
use crate::profile::window::Station;
use crate::reshape::{Bounds, Window};
use core::array::from_fn;
use heapless::Vec;

/// Halvings of a span, at most: where the motion is slow and turns, a cell is shorter.
const HALVINGS: u32 = 3;
/// Share of the band that is kept free for motions over a cell at other speeds than those that were found, with a rest in it too
/// (see [`budget::REST`]).
const OTHERWISE: f64 = 0.015;

/// What a motion becomes.
pub struct Knotted {
    /// How many stations it replaces.
    pub replaced: usize,
    /// The station at which the next window begins, counted from the first, and its line.
    pub next: Option<(usize, usize)>,
}

/// The stations of a motion that was found from station `first` on, in place of others. With `rests` the motion ends in the rest at
/// station `limit`, which stays.
pub fn stations<S: Scalar, const N: usize, const NODES: usize>(
    window: &mut Window<S, N, POINTS>,
    going: &Going<'_, S, N, NODES>,
    bounds: &Bounds<'_, S, N>,
    (first, rests, limit): (usize, bool, usize),
    list: &mut Vec<Station<S, N>, STATIONS>,
) -> Option<Knotted> {
    list.clear();
    let horizon = going.horizon;
    let (count, h, joins) = (window.spans(), window.knots(), window.joins());
    let start = *horizon.window.get(first)?;
    let (end, middle, replaced) = if rests {
        (*horizon.window.get(limit)?, None, limit - first)
    } else {
        let (cell, t) = going.cell(joins);
        let (end, middle) = joined(going, cell, t)?;
        (end, middle, cell + 1 - first)
    };
    let per = joins / (S::from_u32(count as u32) * h);
    let mut line = bounds.line;
    let mut next = None;
    let mut from = start;
    for k in 0..count {
        if k == super::RUN {
            next = Some((list.len(), line));
        }
        let time = S::from_u32(k as u32) * h;
        // What the block asks for: that of the agreed motion about there.
        let (cell, _) = going.cell(time * per);
        from.cell = Cell {
            length: S::ZERO,
            tangent_offset: [S::ZERO; N],
            programmed: horizon.window.get(cell)?.cell.programmed,
            dwell: S::ZERO,
            event: None,
            straight: false,
        };
        let to = if k + 1 < count { None } else { Some(end) };
        let before = list.len();
        let behind = (0..=HALVINGS).find_map(|halvings| {
            list.truncate(before);
            span(window, going, (from, to), bounds.lines.get(line)?.band, halvings, list)
        });
        from = behind?;
        line = window.advance(&Bounds { line, ..*bounds });
    }
    if !rests {
        list.push(end).ok()?;
    }
    if let Some(middle) = middle {
        list.push(middle).ok()?;
    }
    Some(Knotted { replaced, next })
}

/// The station where a cell of the agreed motion is joined `t` s after its start, and one in its middle if what is left reaches over
/// that: the jerk of a cell is bounded by that of its halves.
fn joined<S: Scalar, const N: usize, const NODES: usize>(
    going: &Going<'_, S, N, NODES>,
    cell: usize,
    t: S,
) -> Option<(Station<S, N>, Option<Station<S, N>>)> {
    let horizon = going.horizon;
    let (time, cycle) = (horizon.time(cell), horizon.config.cycle);
    if !(time - t >= cycle * S::of(LEAST_CYCLE_SHARE)) {
        return None;
    }
    let behind = horizon.window.get(cell + 1)?;
    let mut station = horizon.station_on_the_way(cell, t)?;
    let half = time * S::of(0.5);
    let mut middle = None;
    if !station.cell.straight && half - t > cycle {
        let mut there = horizon.station_on_the_way(cell, half)?;
        station.lead_to(&there.node.at, there.state, half - t);
        if !horizon.keeps(&mut there, behind) || !horizon.keeps(&mut station, &there) {
            return None;
        }
        middle = Some(there);
    } else if !horizon.keeps(&mut station, behind) {
        return None;
    }
    Some((station, middle))
}

/// The stations of the next span, cut in 2^`halvings` cells, and the one behind them; `None` if a cell does not keep what it has to.
fn span<S: Scalar, const N: usize, const NODES: usize>(
    window: &Window<S, N, POINTS>,
    going: &Going<'_, S, N, NODES>,
    (start, end): (Station<S, N>, Option<Station<S, N>>),
    band: S,
    halvings: u32,
    list: &mut Vec<Station<S, N>, STATIONS>,
) -> Option<Station<S, N>> {
    let parts = 1 << halvings;
    let part = S::ONE / S::from_u32(parts);
    let mut from = start;
    for k in 1..=parts {
        let to = match end {
            Some(end) if k == parts => end,
            _ => station(window, going, &start, S::from_u32(k) * part)?,
        };
        from.agreed = from.state;
        from.lead_to(&to.node.at, to.state, window.knots() * part);
        let bend = norm(&from.node.curvature).greatest(norm(&to.node.curvature));
        let length = from.cell.length;
        let stays = bend * length * length * S::of(budget::REST) <= band * S::of(OTHERWISE);
        if !(stays || to.rest) || !going.horizon.keeps(&mut from, &to) {
            return None;
        }
        list.push(from).ok()?;
        from = Station { cell: start.cell, ..to };
    }
    Some(from)
}

/// A station a share of the next span behind its start.
fn station<S: Scalar, const N: usize, const NODES: usize>(
    window: &Window<S, N, POINTS>,
    going: &Going<'_, S, N, NODES>,
    like: &Station<S, N>,
    share: S,
) -> Option<Station<S, N>> {
    let state = window.within(share);
    let base = window.base();
    let speed = norm(&state.velocity);
    if !(speed > going.horizon.crawl()) {
        return None;
    }
    let tangent = state.velocity.map(|v| v / speed);
    let along = dot(&state.acceleration, &tangent);
    let at = from_fn(|i| going.origin[i].plus(base[i]).plus(state.position[i]));
    let curvature = from_fn(|i| (state.acceleration[i] - along * tangent[i]) / (speed * speed));
    let found = PathState { b: speed * speed, a: along };
    Some(Station {
        node: Node { at, tangent, curvature },
        rest: false,
        pause: false,
        state: found,
        agreed: found,
        ..*like
    })
}
