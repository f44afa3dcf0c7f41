//! Answers to an operator's commands: hold, stop, abort, overrides, single block.
//!
//! A command is answered by a plan that branches off where the motion will be at the end of a
//! servo cycle, so the answer shows in the cycle after it. The cell under way is cut there: what is
//! left of it starts at the very position, velocity and acceleration that the piece under way has
//! at that moment, so the motion as planned before is a valid start for the solver, and the new
//! plan joins without a step in any derivative up to the second. The cells within the distance
//! that it takes to stop are cut finer, the solver finds the states ([`Aim::Halt`], [`Aim::Slow`]
//! or, when an override is raised, [`Aim::Time`]), and the plan is offered. If the interrupt
//! has passed that cycle meanwhile, it refuses; then everything is as it was before and the
//! next attempt allows more cycles.

use super::plan::{ADDED, Changes};
use super::stop::{DEPTHS, PHASES, Stop};
use super::{Halt, Planner, Progress};
use crate::number::Scalar;
use crate::number::vector::{dot, norm, zero};
use crate::path::builder::Builder;
use crate::path::hermite::{self, Hermite};
use crate::path::node::Node;
use crate::profile::law::State;
use crate::profile::rows::Pace;
use crate::profile::solver::{Aim, Stretch};
use crate::profile::window::Station;
use crate::servo::control::Wish;
use crate::servo::link::Branch;
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// A cell is cut only if this many servo cycles are left of it.
const LEAST_CYCLES: f64 = 2.0;
/// Speed that jerk builds up in as many servo cycles squared is a crawl.
const CRAWL: f64 = 4.0;
/// Share of a crawl below which a motion is not cut: it comes to rest or gets going in a moment.
const LEAST_SPEED: f64 = 1.0e-3;
/// Cells in the distance that it takes to stop.
const BRAKE_CELLS: f64 = 4.0;
/// A part of a stop is a cell of its own if it is this much of the whole.
const LEAST_PART: f64 = 0.03;
/// Places tried for a stop.
const STOP_TRIES: u32 = 8;
/// Braking distances within which a stop is wanted; if there is none, it is looked for again a
/// little later.
const FURTHEST_STOP: f64 = 3.0;
/// Most stations on the way of a stop.
const STOP_CELLS: usize = 16;
/// Ends of blocks tried for a stop.
const END_TRIES: u32 = 4;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// How fast the machine may go, and is asked to.
    pub(super) fn pace(&self) -> Pace<S, N> {
        let factor = |percent: u16| S::from_u32(u32::from(percent.max(1))) * S::of(0.01);
        Pace {
            limits: self.config.limits,
            cycle: self.config.cycle,
            feed: factor(self.overrides.0),
            rapid: factor(self.overrides.1),
        }
    }

    /// Does what is asked for. `Some` if there is nothing else to do in this call.
    pub(super) fn obey(&mut self, wish: &Wish, at: u32) -> Option<Progress> {
        let resumed = wish.resumes != self.resumes;
        self.resumes = wish.resumes;
        if self.pending.is_none() && at == self.planned_end {
            return self.obey_at_rest(wish, resumed);
        }
        let held = wish.hold || wish.abort || wish.overrides.0 == 0 || wish.overrides.1 == 0;
        if held {
            if matches!(self.halt, Some(Halt::Hold)) {
                return Some(Progress::Waiting);
            }
            let planned = self.revoke() && self.brake();
            // If it could not be done at once: the plan is not taken further, and ends at rest.
            return Some(if planned { Progress::Planned } else { Progress::Waiting });
        }
        if resumed || (matches!(self.halt, Some(Halt::Hold)) && self.pending.is_none()) {
            self.halt = None;
        }
        if wish.overrides != self.overrides && self.revoke() && self.retune(wish.overrides) {
            return Some(Progress::Planned);
        }
        if self.pending.is_some() {
            return None;
        }
        if wish.stop || wish.single {
            if matches!(self.halt, Some(Halt::Block)) {
                return Some(Progress::Waiting);
            }
            if self.tried != self.counters.plans {
                self.tried = self.counters.plans;
                if self.rest_at_block_end() {
                    return Some(Progress::Planned);
                }
            }
        }
        None
    }

    /// At rest: whether to go on.
    fn obey_at_rest(&mut self, wish: &Wish, resumed: bool) -> Option<Progress> {
        if matches!(self.halt, Some(Halt::Block)) {
            self.waits = true;
        }
        self.halt = None;
        if wish.abort {
            let last = self.window.index(self.planned_end);
            self.window.truncate(last);
            if let Some(station) = self.window.last() {
                self.builder = Builder::new(station.node.at);
            }
            self.waits = false;
            self.requests.aborted();
            return Some(Progress::Aborted);
        }
        if wish.overrides != self.overrides {
            self.overrides = wish.overrides;
            let pace = self.pace();
            for i in 0..self.window.len() {
                self.window.bound(i, &pace);
            }
        }
        if wish.stop {
            self.requests.stopped();
            self.waits = true;
        }
        if resumed {
            self.waits = false;
        }
        let held = wish.hold || wish.overrides.0 == 0 || wish.overrides.1 == 0;
        (held || self.waits).then_some(Progress::Held)
    }

    /// Takes back a plan that has not been decided on. Whether there is none any more.
    fn revoke(&mut self) -> bool {
        match self.pending {
            None => true,
            // It will be decided on within a few cycles.
            Some(pending) if pending.by_cycle => false,
            Some(_) => {
                self.side.withdraw();
                let late = self.counters.late;
                self.hear();
                // That was no fault of the planner's.
                self.counters.late = late;
                self.pending.is_none()
            }
        }
    }

    /// Cuts the window where the motion will be when an answer can take effect. Returns the index
    /// of the station there and the branch.
    fn cut_in(&mut self) -> Option<(usize, Branch)> {
        self.changes = Changes::NONE;
        let line = self.side.timeline()?;
        let when = self.side.cycles().wrapping_add(self.reaction);
        let cycle = self.config.cycle;
        let end = self.window.index(self.planned_end);
        let (mut began, mut lag) = (line.began, line.lag);
        // As the interpolator will do it, to the last bit.
        for i in self.window.index(line.serial)..end {
            let time = self.agreed_time(i);
            let left = when.wrapping_sub(began);
            let t = lag + S::from_u32(left) * cycle;
            if t < time {
                return self.cut_cell(i, t, time, when);
            }
            let mut count = ((time - lag) / cycle).to_i64().max(0) as u32;
            // The quotient may be off by one, either way.
            count = count.saturating_sub(1);
            for _ in 0..3 {
                if lag + S::from_u32(count) * cycle < time {
                    count += 1;
                }
            }
            lag = lag + S::from_u32(count) * cycle - time;
            began = began.wrapping_add(count);
        }
        None
    }

    /// Cuts the cell of station `i`, `t` seconds after its start.
    fn cut_cell(&mut self, i: usize, t: S, time: S, when: u32) -> Option<(usize, Branch)> {
        let original = *self.window.get(i)?;
        if time - t < self.config.cycle * S::of(LEAST_CYCLES) {
            // Hardly anything is left of it: branch off at its end, if it is passed at speed.
            let next = self.window.get(i + 1)?;
            let moving = next.agreed.b > S::ZERO && next.cell.length > S::ZERO;
            return moving.then(|| (i + 1, Branch::Node(self.window.serial(i + 1))));
        }
        let station = self.station_within(i, t)?;
        self.changes.replaced = Some((self.window.serial(i), original));
        *self.window.get_mut(i)? = station;
        self.window.bound(i, &self.pace());
        Some((i, Branch::Cycle(when)))
    }

    /// A station in the middle of the cell of station `i`, `t` seconds after its start, in the
    /// motion as agreed: the rest of the cell is run as if nothing had been cut.
    fn station_within(&self, i: usize, t: S) -> Option<Station<S, N>> {
        let (station, after) = self.window.pair(i)?;
        let piece: Piece<S, N> = self.piece(i, after.agreed, Sequel::Motion)?;
        let (way, speed, _) = piece.path_at(t);
        if !(speed > self.crawl() * S::of(LEAST_SPEED)) {
            return None;
        }
        let here = piece.at(t);
        let at = from_fn(|k| here.origin[k].plus(here.offset[k]));
        let mut cut = *station;
        let node = if station.cell.straight {
            Node { at, tangent: station.node.tangent, curvature: zero() }
        } else {
            let size = norm(&here.velocity);
            let tangent = from_fn(|k| here.velocity[k] / size);
            let along = dot(&here.acceleration, &tangent);
            let per = S::ONE / (size * size);
            let curvature = if size > self.crawl() {
                from_fn(|k| (here.acceleration[k] - tangent[k] * along) * per)
            } else {
                // In a crawl the motion says little of the shape of the path, and the path's own
                // curvature makes no difference that could be felt.
                let end = station.arrival(after);
                let curve = Hermite::of_cell(&station.node, &station.cell, &end);
                curve.node(&station.node, way / station.cell.length).curvature
            };
            Node { at, tangent, curvature }
        };
        let v = dot(&here.velocity, &node.tangent);
        let state = State { b: v * v, a: dot(&here.acceleration, &node.tangent) };
        cut.node = node;
        cut.rest = false;
        cut.way = station.way.plus(way);
        cut.state = state;
        cut.agreed = state;
        if station.cell.straight {
            let rest: [S; N] = from_fn(|k| after.node.at[k].minus(at[k]));
            cut.cell.length = dot(&rest, &node.tangent);
            cut.cell.bulge = zero();
        } else {
            // The length with which the rest takes the same time: then it is the same quintic.
            let left = piece.time - t;
            cut.cell.length = left * (v + after.agreed.b.sqrt()) * S::of(0.5)
                + left * left * (state.a - after.agreed.a) * S::of(1.0 / 12.0);
            cut.cell.bulge = cut.node.bulge_to(&after.node.at, cut.cell.length);
        }
        (cut.cell.length > S::ZERO).then_some(cut)
    }

    /// Speed, mm/s, below which accelerations across the path are lost beside what jerk changes in
    /// a servo cycle.
    fn crawl(&self) -> S {
        let jerk =
            self.config.limits.axes().iter().fold(S::of(1.0e12), |j, axis| j.least(axis.jerk));
        jerk * self.config.cycle * self.config.cycle * S::of(CRAWL)
    }

    /// Stations that one answer may still add.
    fn room_to_add(&self) -> usize {
        (ADDED - self.changes.added.len()).min(self.window.room())
    }

    /// Puts a station behind the one at `i`; whether there was room.
    ///
    /// The cell of station `i` is still the whole one: it is to be shortened afterwards.
    fn add(&mut self, i: usize, station: Station<S, N>) -> bool {
        let Some(whole) = self.window.get(i).map(|station| station.cell) else { return false };
        if self.room_to_add() == 0 || !self.window.insert_after(i, station) {
            return false;
        }
        let serial = self.window.serial(i + 1);
        if self.planned_end.wrapping_sub(serial) <= u32::MAX / 2 {
            self.planned_end = self.planned_end.wrapping_add(1);
        }
        let _ = self.changes.added.push((serial, whole));
        true
    }

    /// About what braking takes from a station, mm: v (v / A + A / J) / 2 and a fifth more.
    fn braking_distance(&self, i: usize) -> S {
        let limits = &self.config.limits;
        let speed = self.window.get(i).map_or(S::ZERO, |station| station.state.b.sqrt());
        let mut time = S::ZERO;
        for axis in limits.axes() {
            time = time.greatest(speed / axis.acceleration);
        }
        speed * (time + limits.time_scale()) * S::of(0.6)
    }

    /// Cuts the cells of the agreed motion within braking distance of `first` finer.
    fn refine(&mut self, first: usize, last: usize) -> usize {
        let Some(start) = self.window.get(first) else { return last };
        let speed = start.state.b.sqrt();
        let distance = self.braking_distance(first);
        let longest = distance / S::of(BRAKE_CELLS);
        let (mut i, mut last) = (first, last);
        let mut way = S::ZERO;
        let pace = self.pace();
        for _ in 0..NODES {
            let Some(station) = self.window.get(i) else { break };
            let length = station.cell.length;
            if i >= last || way > distance {
                break;
            }
            // In its middle, or where braking may end if that is much nearer.
            let near = (distance - way) / speed;
            let middle = self
                .window
                .agreed_law(i)
                .map(|law| (law.time * S::of(0.5)).least(near))
                .filter(|t| *t > self.config.cycle)
                .and_then(|t| Some((self.station_within(i, t)?, t)));
            match middle {
                // The last ones are for the stop itself.
                Some((cut, t)) if length > longest && self.room_to_add() > PHASES => {
                    self.add(i, cut);
                    self.shorten(i, &cut, t);
                    last += 1;
                    self.window.bound(i, &pace);
                    self.window.bound(i + 1, &pace);
                }
                _ => {
                    way += length;
                    i += 1;
                }
            }
        }
        last
    }

    /// Makes the cell of station `i` end at a station within it, `t` seconds after its start.
    fn shorten(&mut self, i: usize, cut: &Station<S, N>, t: S) {
        let Some(station) = self.window.get_mut(i) else { return };
        if station.cell.straight {
            let way: [S; N] = from_fn(|k| cut.node.at[k].minus(station.node.at[k]));
            station.cell.length = dot(&way, &station.node.tangent);
        } else {
            let (from, to) = (station.agreed, cut.agreed);
            station.cell.length = t * (from.b.sqrt() + to.b.sqrt()) * S::of(0.5)
                + t * t * (from.a - to.a) * S::of(1.0 / 12.0);
            station.cell.bulge = station.node.bulge_to(&cut.node.at, station.cell.length);
        }
    }

    /// Splits the cell of station `i` in its middle; nothing is known of the motion there.
    pub(super) fn split_cell(&mut self, i: usize) -> bool {
        let Some((station, after)) = self.window.pair(i) else { return false };
        let (first, middle, second) =
            hermite::split(&station.node, &station.cell, &station.arrival(after));
        let mut cut = *station;
        cut.way = station.way.plus(first.length);
        cut.node = middle;
        cut.cell = second;
        cut.rest = false;
        cut.state = State::REST;
        cut.agreed = State::REST;
        let serial = self.window.serial(i + 1);
        if !self.window.insert_after(i, cut) {
            return false;
        }
        if self.planned_end.wrapping_sub(serial) <= u32::MAX / 2 {
            self.planned_end = self.planned_end.wrapping_add(1);
        }
        if let Some(station) = self.window.get_mut(i) {
            station.cell = first;
        }
        let pace = self.pace();
        self.window.bound(i, &pace);
        self.window.bound(i + 1, &pace);
        true
    }

    /// The stretch from a branch to the end of the plan, or to the first rest in it.
    fn stretch_from(&self, first: usize) -> Stretch {
        let end = self.window.index(self.planned_end);
        let rests = |i: &usize| self.window.get(*i).is_some_and(|station| station.rest);
        let last = (first + 1..end).find(rests).unwrap_or(end);
        Stretch { first, last, open: false }
    }

    /// The window as it was: an answer could not be made.
    fn give_up(&mut self) -> bool {
        self.undo();
        let last = self.window.index(self.planned_end);
        for i in 0..self.window.len() {
            if let Some(station) = self.window.get_mut(i) {
                station.state = if i <= last { station.agreed } else { State::REST };
            }
        }
        false
    }

    /// The motion as agreed from where an answer can take effect, on cells cut finer.
    fn prepare(&mut self) -> Option<(Stretch, Branch)> {
        let (first, branch) = self.cut_in()?;
        let mut stretch = self.stretch_from(first);
        let before = self.planned_end;
        self.refine(first, stretch.last);
        stretch.last += self.planned_end.wrapping_sub(before) as usize;
        self.loosen(first, stretch.last);
        Some((stretch, branch))
    }

    /// Gives a stretch states that brake as hard as the limits allow, and creep on.
    fn slow_down(&mut self, stretch: Stretch) {
        let limits = self.config.limits;
        let (window, most) = (&mut self.window, self.config.iterations);
        let steps = self.solver.improve(window, stretch, &limits, most, (Aim::Halt, false));
        self.counters.steps += u32::from(steps);
    }

    /// A plan that comes to rest as soon as the limits allow.
    fn brake(&mut self) -> bool {
        let Some((stretch, branch)) = self.prepare() else {
            self.give_up();
            return self.rest_next();
        };
        // At once, as on a straight; or from somewhere on the motion that brakes hardest.
        if self.stop(stretch, branch) {
            return true;
        }
        self.slow_down(stretch);
        if self.stop(stretch, branch) {
            return true;
        }
        // The rest that the plan comes to anyway may be nearer than any other.
        self.give_up();
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
                self.halt = Some(Halt::Hold);
                self.publish(held, branch, self.overrides);
                return true;
            }
            let pace = self.pace();
            while self.changes.added.len() > added
                && let Some((serial, cell)) = self.changes.added.pop()
            {
                self.take_out(self.window.index(serial), cell, &pace);
            }
            for (k, state) in states.iter().enumerate() {
                self.set_state(i + 1 + k, *state);
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
            self.halt = Some(Halt::Hold);
            let stretch = Stretch { first: i, last: i, open: false };
            self.publish(stretch, Branch::Node(next), self.overrides);
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
            self.set_state(cell, stop.state(way));
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

    /// Puts a station with a state within the cell of station `i`, at a share of its length.
    fn insert(&mut self, i: usize, share: S, state: State<S>) -> Option<()> {
        let (station, after) = self.window.pair(i)?;
        let bound = station.bounds.speed;
        let (first, middle, second) =
            hermite::split_at(&station.node, &station.cell, &station.arrival(after), share);
        let mut cut = *station;
        cut.way = station.way.plus(first.length);
        cut.node = middle;
        cut.cell = second;
        cut.rest = false;
        cut.state = state;
        if !self.add(i, cut) {
            return None;
        }
        self.window.get_mut(i)?.cell = first;
        let pace = self.pace();
        for k in [i, i + 1] {
            self.window.bound(k, &pace);
            let station = self.window.get_mut(k)?;
            station.bounds.speed = station.bounds.goal.greatest(bound);
        }
        Some(())
    }

    /// The first node behind station `first` at which a block ends.
    pub(super) fn block_end(&self, first: usize) -> Option<usize> {
        (first + 1..self.window.len()).find(|&i| self.ends_block(i))
    }

    /// Whether a block ends at station `i`.
    fn ends_block(&self, i: usize) -> bool {
        let Some((before, here)) = i.checked_sub(1).and_then(|i| self.window.pair(i)) else {
            return false;
        };
        let last = i + 1 == self.window.len();
        here.rest || (!last && before.cell.order.tag != here.cell.order.tag)
    }

    /// A plan that rests at the end of the block under way, or of the first one that is possible.
    fn rest_at_block_end(&mut self) -> bool {
        let Some((stretch, branch)) = self.prepare() else { return self.give_up() };
        self.slow_down(stretch);
        let mut tries = 0;
        for end in stretch.first + 1..=stretch.last {
            if !self.ends_block(end) {
                continue;
            }
            let state = self.window.get(end).map_or(State::REST, |station| station.state);
            self.set_state(end, State::REST);
            let held = Stretch { last: end, ..stretch };
            if self.solver.holds(&self.window, held, &self.config.limits) {
                let limits = self.config.limits;
                let start = (Aim::Time, false);
                let most = self.config.iterations;
                let steps = self.solver.improve(&mut self.window, held, &limits, most, start);
                self.counters.steps += u32::from(steps);
                self.halt = Some(Halt::Block);
                self.publish(held, branch, self.overrides);
                return true;
            }
            self.set_state(end, state);
            tries += 1;
            if tries >= END_TRIES {
                break;
            }
        }
        self.give_up()
    }

    fn set_state(&mut self, i: usize, state: State<S>) {
        if let Some(station) = self.window.get_mut(i) {
            station.state = state;
        }
    }

    /// A plan at other overrides.
    fn retune(&mut self, overrides: (u16, u16)) -> bool {
        let before = self.overrides;
        self.overrides = overrides;
        let Some((first, branch)) = self.cut_in() else {
            self.overrides = before;
            return self.give_up();
        };
        let end = self.window.index(self.planned_end);
        let last = self.refine(first, end);
        let pace = self.pace();
        for i in first..self.window.len() {
            self.window.bound(i, &pace);
        }
        self.loosen(first, last);
        let slower = (first..last).any(|i| {
            self.window.get(i).is_some_and(|station| station.bounds.speed > station.bounds.goal)
        });
        let rests = self.window.get(last).is_some_and(|station| station.rest);
        let stretch = Stretch { first, last, open: !rests && self.halt.is_none() };
        let limits = self.config.limits;
        // First down to the goal, at a price; then, with the speeds reached as bounds, for time.
        for aim in [Aim::Slow, Aim::Time] {
            if aim == Aim::Slow && !slower {
                continue;
            }
            let (window, most) = (&mut self.window, self.config.iterations);
            let steps = self.solver.improve(window, stretch, &limits, most, (aim, false));
            self.counters.steps += u32::from(steps);
            self.loosen(first, last);
        }
        if !self.solver.holds(&self.window, stretch, &limits) {
            self.overrides = before;
            return self.give_up();
        }
        self.publish(stretch, branch, before);
        true
    }
}
