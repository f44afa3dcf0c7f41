//! Coming to rest on the path as soon as the limits allow.

use super::halting::{ATTEMPTS, Begun, FIRST_REACH, Tried};
use super::reaction::Asked;
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::planner::Planner;
use crate::planner::horizon::stop_profile::{DEPTHS, HARD, SHARES, StopProfile};
use crate::planner::horizon::{Horizon, Proposal};
use crate::planner::making::Purpose;
use crate::planner::phase::{Halt, Phase};
use crate::profile::law::PathState;
use crate::profile::solver::Stretch;
use crate::servo::link::Branch;

/// Places tried for a stop.
const STOP_TRIES: u8 = 12;
/// Servo cycles that the last part of a stop takes at least.
const LEAST_CYCLES: f64 = 0.5;
/// Braking distances within which a stop is wanted; if there is none, it is looked for again a
/// little later.
const FURTHEST_STOP: f64 = 3.0;
/// Most stations that a stop passes.
const STOP_CELLS: usize = 16;
/// A part of a stop is a cell of its own if it is this much of the whole.
const LEAST_PART: f64 = 0.03;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// A plan that comes to rest as soon as the limits allow. Whether there is one.
    pub(super) fn brake(&mut self, at: NodeSerial) -> bool {
        let stands = self.horizon.stands(at);
        if stands {
            let moment = self.moment();
            let made = self.horizon.draft(|draft| {
                let (stretch, branch) = draft.cut_dwell(moment?)?;
                Some(Proposal { stretch, branch, halt: Some(Halt::Hold) })
            });
            return self.propose(Purpose::Hold, made) || self.rest_next(Halt::Hold);
        }
        if self.react(Asked::Hold, at) {
            return true;
        }
        if self.pressing.attempts >= ATTEMPTS {
            // As long as nothing is known that could change it, once in every cell.
            if self.pressing.at == at {
                return self.rest_next(Halt::Hold);
            }
            (self.pressing.attempts, self.pressing.reach) = (0, FIRST_REACH);
        }
        (self.pressing.at, self.pressing.nearer) = (at, 0);
        let attempt = (self.pressing.attempts, self.pressing.reach);
        match self.horizon.begin_halt(self.moment_of_attempt(), attempt) {
            Begun::Attempt(begun) => self.make((Purpose::Hold, at), Some(begun)),
            // The rest that the plan comes to anyway may be nearer than any other.
            Begun::Soon => self.rest_as_agreed(),
            Begun::Nothing => self.rest_next(Halt::Hold),
        }
    }

    /// A rest has been found: looks for a nearer one while the motion brakes towards it. Whether one is in the making.
    pub(super) fn come_nearer(&mut self, at: NodeSerial) -> bool {
        if !matches!(self.phase, Phase::Following(_)) || self.horizon.stands(at) {
            return false;
        }
        let failures = self.pressing.nearer;
        let begun = self.horizon.begin_nearer(self.moment_of_attempt(), failures);
        // Without an attempt it does not get any nearer.
        self.pressing.nearer = if begun.is_some() { failures } else { u8::MAX };
        self.make((Purpose::Hold, at), begun)
    }

    /// If the motion comes to rest at the end of the piece under way, lets it stay there.
    pub(super) fn rest_next(&mut self, halt: Halt) -> bool {
        let (at, end) = (self.side.progress(), self.horizon.end());
        if at == end {
            return false;
        }
        let next = at.next();
        let i = self.horizon.window.clamped_index(next);
        if halt == Halt::Block && !self.horizon.ends_block(i) {
            return false;
        }
        let rests = self.horizon.window.get(i).is_some_and(|station| station.rest);
        (rests || next == end) && self.rest_there(next, halt)
    }

    /// Lets the motion stay at the next rest of the plan.
    fn rest_as_agreed(&mut self) -> bool {
        let at = self.side.progress();
        let window = &self.horizon.window;
        let last = self.horizon.stretch_from(window.clamped_index(at)).last;
        let rest = window.serial(last);
        at != self.horizon.end() && self.rest_there(rest, Halt::Hold)
    }

    /// Lets the motion stay at a node at which it rests; whether a plan was made for it.
    pub(super) fn rest_there(&mut self, node: NodeSerial, halt: Halt) -> bool {
        if node == self.horizon.end() {
            if let Phase::Following(now) = &mut self.phase {
                now.rest_at_end(halt);
            }
            return false;
        }
        let i = self.horizon.window.clamped_index(node);
        let stretch = Stretch { first: i, last: i, open: false };
        let purpose = match halt {
            Halt::Hold => Purpose::Hold,
            Halt::Block => Purpose::BlockEnd,
        };
        let branch = Branch::Node(node);
        let made = self.horizon.draft(|_| Some(Proposal { stretch, branch, halt: Some(halt) }));
        self.propose(purpose, made)
    }
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Tries the nearest stop of a stretch that is further than `nearest` mm.
    pub(super) fn try_stop(&mut self, stretch: Stretch, nearest: &mut S, tries: &mut u8) -> Tried {
        let furthest = self.braking_distance(stretch.first) * S::of(FURTHEST_STOP);
        let Some((i, stop)) = self.next_stop(stretch, *nearest, furthest) else {
            return Tried::Exhausted;
        };
        if stop.at > furthest || *tries >= STOP_TRIES {
            return Tried::Exhausted;
        }
        (*nearest, *tries) = (stop.at, *tries + 1);
        let added = self.count_added();
        let mut states = heapless::Vec::new();
        let end = self.put_stop(i, &stop, stretch.last, &mut states);
        let held = Stretch { last: end.unwrap_or(i), ..stretch };
        if end.is_some() && self.holds(held) && self.crawl_in(held).is_none() {
            return Tried::Rests(held);
        }
        self.take_back(added);
        for (k, state) in states.iter().enumerate() {
            self.window.set_state(i + 1 + k, *state);
        }
        self.loosen(i, i + 1 + states.len());
        Tried::Fails
    }

    /// The station from which the motion can come to rest nearest, but further than `beyond`, and
    /// how.
    fn next_stop(
        &self,
        stretch: Stretch,
        beyond: S,
        furthest: S,
    ) -> Option<(usize, StopProfile<S>)> {
        let mut best: Option<(usize, StopProfile<S>)> = None;
        let mut distance = S::ZERO;
        for i in stretch.first..stretch.last {
            if distance > furthest {
                break;
            }
            let station = self.window.get(i)?;
            for depth in DEPTHS {
                // The hardest that ends clear of all nodes.
                let mut brief = true;
                for (k, share) in SHARES.iter().enumerate() {
                    if k >= HARD && !brief {
                        break;
                    }
                    let Some(stop) = StopProfile::new(station, distance, depth, S::of(*share))
                    else {
                        continue;
                    };
                    brief = self.is_brief(&stop);
                    if !self.is_clear(stretch, &stop) {
                        continue;
                    }
                    if stop.at > beyond {
                        if best.as_ref().is_none_or(|(_, least)| stop.at < least.at) {
                            best = Some((i, stop));
                        }
                        break;
                    }
                    // A brief one may still do if it is longer.
                    if !brief {
                        break;
                    }
                }
            }
            distance += station.cell.length;
        }
        best
    }

    /// Whether a stop ends not too near to a node of the stretch: the piece that comes to rest lasts, and the
    /// one that will start there.
    fn is_clear(&self, stretch: Stretch, stop: &StopProfile<S>) -> bool {
        let begin = stop.at - stop.length();
        let mut distance = S::ZERO;
        for i in stretch.first..stretch.last {
            let Some(station) = self.window.get(i) else { return false };
            let apart = self.apart(station.bounds.jerk);
            let end = distance + station.cell.length;
            if stop.at < end + apart {
                let (before, behind) = (stop.at - distance, end - stop.at);
                let speed = stop.state((distance - begin).greatest(S::ZERO)).b.sqrt();
                return before >= speed * self.config.cycle * S::of(LEAST_CYCLES)
                    && behind >= apart;
            }
            distance = end;
        }
        false
    }

    /// Puts a stop into the window: stations before its end get its states, what they had goes
    /// to `before`. Returns the index of the station at rest.
    fn put_stop(
        &mut self,
        i: usize,
        stop: &StopProfile<S>,
        last: usize,
        before: &mut heapless::Vec<PathState<S>, STOP_CELLS>,
    ) -> Option<usize> {
        let (mut cell, mut distance) = (i, S::ZERO);
        loop {
            let length = self.window.get(cell)?.cell.length;
            if distance + length > stop.length() {
                self.insert(cell, (stop.length() - distance) / length, PathState::REST)?;
                break;
            }
            distance += length;
            cell += 1;
            if cell >= last {
                return None;
            }
            before.push(self.window.get(cell)?.state).ok()?;
            self.window.set_state(cell, stop.state(distance));
        }
        let mut end = cell + 1;
        // Where the jerk changes, unless a station is near.
        for change in stop.changes(self.config.cycle * S::of(LEAST_CYCLES)) {
            distance = S::ZERO;
            for k in i..end {
                let length = self.window.get(k)?.cell.length;
                let share = (change - distance) / length;
                if share > S::of(LEAST_PART) && share < S::of(1.0 - LEAST_PART) {
                    // Without room it may do without.
                    end += usize::from(self.insert(k, share, stop.state(change)).is_some());
                    break;
                }
                distance += length;
            }
        }
        Some(end)
    }
}
