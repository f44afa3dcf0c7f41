//! Coming to rest on the path as soon as the limits allow.

use super::stop::{DEPTHS, Stop};
use super::{Halt, Planner};
use crate::number::Scalar;
use crate::profile::law::State;
use crate::profile::solver::{Aim, Stretch};
use crate::servo::link::Branch;

/// Places tried for a stop.
const STOP_TRIES: u32 = 8;
/// Braking distances within which a stop is wanted; if there is none, it is looked for again a
/// little later.
const FURTHEST_STOP: f64 = 3.0;
/// Most stations on the way of a stop.
const STOP_CELLS: usize = 16;
/// A part of a stop is a cell of its own if it is this much of the whole.
const LEAST_PART: f64 = 0.03;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// A plan that comes to rest as soon as the limits allow.
    pub(super) fn brake(&mut self) -> bool {
        if let Some((stretch, branch)) = self.prepare() {
            // At once, as on a straight; or from somewhere on the motion that brakes hardest.
            if self.stop(stretch, branch) {
                return true;
            }
            self.improve(stretch, Aim::Halt);
            if self.stop(stretch, branch) {
                return true;
            }
        }
        // The rest that the plan comes to anyway may be nearer than any other.
        self.undo();
        self.rest_next()
    }

    /// A plan that ends in the nearest stop that keeps the limits, if there is one near.
    fn stop(&mut self, stretch: Stretch, branch: Branch) -> bool {
        let mut nearest = S::ZERO;
        let furthest = self.braking_distance(stretch.first) * S::of(FURTHEST_STOP);
        for _ in 0..STOP_TRIES {
            let Some((i, stop)) = self.next_stop(stretch, nearest) else { return false };
            if stop.at > furthest {
                return false;
            }
            nearest = stop.at;
            let added = self.changes.added.len();
            let mut states = heapless::Vec::new();
            let end = self.put_stop(i, &stop, stretch.last, &mut states);
            let held = Stretch { last: end.unwrap_or(i), ..stretch };
            if end.is_some() && self.solver.holds(&self.window, held, &self.config.limits) {
                self.publish(held, branch, self.overrides, Some(Halt::Hold));
                return true;
            }
            let pace = self.pace();
            while self.changes.added.len() > added
                && let Some((serial, cell)) = self.changes.added.pop()
            {
                self.take_out(self.window.index(serial), cell, &pace);
            }
            for (k, state) in states.iter().enumerate() {
                self.window.set_state(i + 1 + k, *state);
            }
            self.loosen(i, i + 1 + states.len());
        }
        false
    }

    /// If the motion comes to rest at the end of the piece under way, lets it stay there.
    fn rest_next(&mut self) -> bool {
        let next = self.side.progress().wrapping_add(1);
        let i = self.window.index(next);
        let rests = self.window.get(i).is_some_and(|station| station.rest);
        if next == self.planned_end {
            self.halt = Some(Halt::Hold);
        } else if rests && self.window.serial(i) == next {
            let stretch = Stretch { first: i, last: i, open: false };
            self.publish(stretch, Branch::Node(next), self.overrides, Some(Halt::Hold));
            return true;
        }
        false
    }

    /// The station from which the motion can come to rest nearest, but further than `beyond`, and
    /// how.
    fn next_stop(&self, stretch: Stretch, beyond: S) -> Option<(usize, Stop<S>)> {
        let mut best: Option<(usize, Stop<S>)> = None;
        let mut way = S::ZERO;
        for i in stretch.first..stretch.last {
            let station = self.window.get(i)?;
            for depth in DEPTHS {
                if let Some(stop) = Stop::new(station, way, depth)
                    && stop.at > beyond
                    && best.as_ref().is_none_or(|(_, least)| stop.at < least.at)
                {
                    best = Some((i, stop));
                }
            }
            way += station.cell.length;
        }
        best
    }

    /// Puts a stop into the window: stations on the way there get its states, what they had goes
    /// to `before`. Returns the index of the station at rest.
    fn put_stop(
        &mut self,
        i: usize,
        stop: &Stop<S>,
        last: usize,
        before: &mut heapless::Vec<State<S>, STOP_CELLS>,
    ) -> Option<usize> {
        let (mut cell, mut way) = (i, S::ZERO);
        loop {
            let length = self.window.get(cell)?.cell.length;
            if way + length > stop.length() {
                self.insert(cell, (stop.length() - way) / length, State::REST)?;
                break;
            }
            way += length;
            cell += 1;
            if cell >= last {
                return None;
            }
            before.push(self.window.get(cell)?.state).ok()?;
            self.window.set_state(cell, stop.state(way));
        }
        let mut end = cell + 1;
        // Where the jerk changes, unless a station is near.
        for change in stop.ends() {
            way = S::ZERO;
            for k in i..end {
                let length = self.window.get(k)?.cell.length;
                let share = (change - way) / length;
                if share > S::of(LEAST_PART) && share < S::of(1.0 - LEAST_PART) {
                    self.insert(k, share, stop.state(change))?;
                    end += 1;
                    break;
                }
                way += length;
            }
        }
        Some(end)
    }
}
