//! Cutting the window: stations put into cells in motion, and taken out again.
//!
//! Where a cell that is being run, or will be, is cut, the station put in has the very position,
//! velocity and acceleration of the motion there: what is left of the cell is run as if nothing had
//! been cut. Whatever is changed for an answer that the interrupt refuses is undone.

use super::Planner;
use super::stop::PHASES;
use crate::number::Scalar;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::vector::{dot, norm, zero};
use crate::path::hermite::{self, Hermite};
use crate::path::node::{Cell, Node};
use crate::profile::law::PathState;
use crate::profile::rows::{Bounds, Pace};
use crate::profile::solver::Stretch;
use crate::profile::window::Station;
use crate::servo::link::Branch;
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// Most stations that one answer to a command adds to the window.
pub const ADDED: usize = 12;

/// What an answer to a command has changed in the window, in case it is refused.
#[derive(Clone, Debug)]
pub struct Changes<S, const N: usize> {
    /// The station whose cell was under way, with its running number.
    pub replaced: Option<(NodeSerial, Station<S, N>)>,
    /// Stations put in, in order: running number, and the cell that each was put into.
    pub added: heapless::Vec<(NodeSerial, Cell<S, N>), ADDED>,
}

impl<S, const N: usize> Changes<S, N> {
    pub const NONE: Self = Self { replaced: None, added: heapless::Vec::new() };
}

/// A cell is cut only if this many servo cycles are left of it.
const LEAST_CYCLES: f64 = 2.0;
/// Speed that jerk builds up in as many servo cycles squared is a crawl.
const CRAWL: f64 = 4.0;
/// Share of a crawl below which a motion is not cut: it comes to rest or gets going in a moment.
const LEAST_SPEED: f64 = 1.0e-3;
/// Nodes of the path lie at least as far apart as jerk takes a motion from rest in this many servo cycles:
/// nearer ones would be passed no faster than they lie apart.
const APART_CYCLES: f64 = 2.0;
/// Share of a servo cycle that is left of a dwell when it is suspended: then it is over in the cycle that
/// takes it up.
const DWELL_END: f64 = 0.5;
/// Cells in the distance that it takes to stop.
const BRAKE_CELLS: f64 = 4.0;

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Cuts the window where the motion will be when an answer can take effect. Returns the index
    /// of the station there and the branch.
    pub(super) fn cut_in(&mut self) -> Option<(usize, Branch)> {
        self.changes = Changes::NONE;
        let line = self.side.timeline()?;
        let when = self.side.cycles().plus(self.reaction);
        let cycle = self.config.cycle;
        let end = self.end_index();
        let (mut began, mut lag) = (line.began, line.lag);
        // As the interpolator will do it, to the last bit.
        for i in self.window.clamped_index(line.serial)..end {
            let time = self.agreed_time(i);
            let passed = when.since(began)?;
            let t = lag + S::from_u32(passed) * cycle;
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
            began = began.plus(count);
        }
        None
    }

    /// Cuts the dwell under way where it will be when an answer can take effect: the motion rests there,
    /// and what is left of the dwell follows. Returns the stretch up to that rest and the branch; `None` if
    /// there is none, or if it is as good as over.
    pub(super) fn cut_dwell(&mut self) -> Option<(Stretch, Branch)> {
        self.changes = Changes::NONE;
        let line = self.side.timeline()?;
        let i = self.window.clamped_index(line.serial);
        let original = *self.window.get(i)?;
        let Cell { length, dwell, event, .. } = original.cell;
        let runs = self.window.serial(i) == line.serial && line.serial != self.planned_end;
        if length > S::ZERO || event.is_some() || !runs {
            return None;
        }
        let cycle = self.config.cycle;
        let when = self.side.cycles().plus(self.reaction);
        let left = dwell - (line.lag + S::from_u32(when.since(line.began)?) * cycle);
        if !(left >= cycle * S::of(LEAST_CYCLES)) {
            return None;
        }
        let rest = Cell { dwell: left, ..original.cell };
        let rest = Station { cell: rest, rest: true, pause: false, ..original };
        if !self.add(i, rest) {
            return None;
        }
        self.changes.replaced = Some((line.serial, original));
        self.window.get_mut(i)?.cell.dwell = cycle * S::of(DWELL_END);
        Some((Stretch { first: i, last: i + 1, open: false }, Branch::Cycle(when)))
    }

    /// Whether the node under way, and the motion with it, stands still.
    pub(super) fn stands(&self, at: NodeSerial) -> bool {
        let cell =
            self.window.get(self.window.clamped_index(at)).map(|station| station.cell.length);
        at != self.planned_end && cell.is_some_and(|length| !(length > S::ZERO))
    }

    /// Least distance of two nodes in a cell, mm.
    pub(super) fn apart(&self, jerk: S) -> S {
        let time = self.config.cycle * S::of(APART_CYCLES);
        jerk * time * time * time * S::of(1.0 / 6.0)
    }

    /// Cuts the cell of station `i`, `t` seconds after its start.
    fn cut_cell(&mut self, i: usize, t: S, time: S, when: CycleSerial) -> Option<(usize, Branch)> {
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
        // The jerk of a curved cell is bounded by that of its halves (see the rows): a part that reaches over
        // its middle may seem to break a limit that the whole keeps.
        let half = time * S::of(0.5) - t;
        if !station.cell.straight && half > self.config.cycle {
            self.cut_agreed(i, half);
        }
        Some((i, Branch::Cycle(when)))
    }

    /// Puts a station into the cell of station `i` where the agreed motion is after `t` seconds; whether that
    /// could be done.
    fn cut_agreed(&mut self, i: usize, t: S) -> bool {
        let Some(cut) = self.station_within(i, t) else { return false };
        if !self.add(i, cut) {
            return false;
        }
        if let Some(station) = self.window.get_mut(i) {
            station.lead_to(&cut.node.at, cut.agreed, t);
        }
        self.bound_halves(i);
        true
    }

    /// A station in the middle of the cell of station `i`, `t` seconds after its start, in the
    /// motion as agreed: the rest of the cell is run as if nothing had been cut.
    fn station_within(&self, i: usize, t: S) -> Option<Station<S, N>> {
        let (station, after) = self.window.pair(i)?;
        let piece: Piece<S, N> = self.piece(i, after.agreed, Sequel::Motion)?;
        let here = piece.at(t);
        let way = here.path_offset;
        if !(here.path_speed > self.crawl() * S::of(LEAST_SPEED)) {
            return None;
        }
        // In `f64`: what is left of the cell must make good what is rounded here, in ever less time.
        let time = t.to_f64();
        let at = from_fn(|k| {
            let offset = piece.axes[k].iter().rev().fold(0.0, |sum, c| (sum + c.to_f64()) * time);
            here.origin[k].plus(offset)
        });
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
        let state = PathState { b: v * v, a: dot(&here.acceleration, &node.tangent) };
        cut.node = node;
        (cut.rest, cut.pause) = (false, false);
        cut.way = station.way.plus(way);
        cut.state = state;
        cut.agreed = state;
        cut.lead_to(&after.node.at, after.agreed, piece.time - t);
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

    /// Puts a station behind the one at `i`, to be undone if the answer is refused; whether there
    /// was room.
    ///
    /// The cell of station `i` is still the whole one: it is to be shortened afterwards.
    fn add(&mut self, i: usize, station: Station<S, N>) -> bool {
        let Some(whole) = self.window.get(i).map(|station| station.cell) else { return false };
        if self.room_to_add() == 0 || !self.put_behind(i, station) {
            return false;
        }
        let _ = self.changes.added.push((self.window.serial(i + 1), whole));
        true
    }

    /// Puts a station behind the one at `i`, for good; whether there was room.
    fn put_behind(&mut self, i: usize, station: Station<S, N>) -> bool {
        if !self.window.insert_after(i, station) {
            return false;
        }
        if !self.planned_end.is_before(self.window.serial(i + 1)) {
            self.planned_end = self.planned_end.next();
        }
        true
    }

    /// The cell of station `i` cut at a share of its length: its first part, and a station with the
    /// other.
    fn parted(&self, i: usize, share: S) -> Option<(Cell<S, N>, Station<S, N>)> {
        let (station, after) = self.window.pair(i)?;
        let (first, node, cell) =
            hermite::split_at(&station.node, &station.cell, &station.arrival(after), share);
        let way = station.way.plus(first.length);
        Some((first, Station { node, cell, way, rest: false, pause: false, ..*station }))
    }

    /// Makes `first` the cell of station `i`; it and the one behind are bounded anew.
    fn part(&mut self, i: usize, first: Cell<S, N>) {
        if let Some(station) = self.window.get_mut(i) {
            station.cell = first;
        }
        self.bound_halves(i);
    }

    /// Bounds the cell of station `i` and the next anew.
    fn bound_halves(&mut self, i: usize) {
        let pace = self.pace();
        self.window.bound(i, &pace);
        self.window.bound(i + 1, &pace);
    }

    /// Puts a station with a state within the cell of station `i`, at a share of its length.
    pub(super) fn insert(&mut self, i: usize, share: S, state: PathState<S>) -> Option<()> {
        let bound = self.window.get(i)?.bounds.speed;
        let (first, cut) = self.parted(i, share)?;
        if !self.add(i, Station { state, ..cut }) {
            return None;
        }
        self.part(i, first);
        for k in [i, i + 1] {
            let station = self.window.get_mut(k)?;
            station.bounds.speed = station.bounds.goal.greatest(bound);
        }
        Some(())
    }

    /// Splits the cell of station `i` at a share of its length; nothing is known of the motion there.
    pub(super) fn split_cell(&mut self, i: usize, share: S) -> bool {
        let Some((first, cut)) = self.parted(i, share) else { return false };
        let done =
            self.put_behind(i, Station { state: PathState::REST, agreed: PathState::REST, ..cut });
        if done {
            self.part(i, first);
        }
        done
    }

    /// About what braking takes from a station, mm: v (v / A + A / J) / 2 and a fifth more.
    pub(super) fn braking_distance(&self, i: usize) -> S {
        let Some(station) = self.window.get(i) else { return S::ZERO };
        let PathState { b, a } = station.state;
        // What the acceleration adds until it is gone.
        let more = a.greatest(S::ZERO) * a / (station.bounds.jerk + station.bounds.jerk);
        let speed = b.sqrt() + more;
        let limits = &self.config.limits;
        let mut time = S::ZERO;
        for axis in limits.axes() {
            time = time.greatest(speed / axis.acceleration);
        }
        speed * (time + limits.time_scale()) * S::of(0.6)
    }

    /// What it takes from a speed, mm/s, to the one that the cell of station `i` is asked for, mm.
    pub(super) fn ramp(&self, i: usize, speed: S) -> S {
        let Some(station) = self.window.get(i) else { return S::ZERO };
        let Bounds { goal, acceleration, jerk, .. } = station.bounds;
        let gain = (goal - speed).greatest(S::ZERO);
        let time = if gain * jerk < acceleration * acceleration {
            S::of(2.0) * (gain / jerk).sqrt()
        } else {
            gain / acceleration + acceleration / jerk
        };
        (speed + goal) * time * S::of(0.5)
    }

    /// Cuts the cells of the agreed motion within a distance, mm, of `first` finer.
    pub(super) fn refine(&mut self, first: usize, last: usize, distance: S) -> usize {
        let Some(start) = self.window.get(first) else { return last };
        let speed = start.state.b.sqrt();
        let longest = distance / S::of(BRAKE_CELLS);
        let (mut i, mut last) = (first, last);
        let mut way = S::ZERO;
        for _ in 0..NODES {
            let Some(station) = self.window.get(i) else { break };
            let length = station.cell.length;
            if i >= last || way > distance {
                break;
            }
            let time = self.agreed_time(i);
            let mut cut = time * S::of(0.5);
            if station.cell.straight {
                // In its middle, or where braking may end if that is much nearer.
                cut = cut.least((distance - way) / speed);
            }
            // The last ones are for the stop itself.
            let may = length > longest && cut > self.config.cycle && self.room_to_add() > PHASES;
            if may && self.cut_agreed(i, cut) {
                last += 1;
            } else {
                way += length;
                i += 1;
            }
        }
        last
    }

    /// The window as it was before an answer that was refused or could not be made, with the states
    /// of the plan that goes on.
    pub(super) fn undo(&mut self) {
        let changes = core::mem::replace(&mut self.changes, Changes::NONE);
        let pace = self.pace();
        for (serial, cell) in changes.added.iter().rev() {
            self.take_out(self.window.clamped_index(*serial), *cell, &pace);
        }
        if let Some((serial, original)) = changes.replaced {
            let i = self.window.clamped_index(serial);
            if let Some(station) = self.window.get_mut(i) {
                *station = original;
            }
        }
        self.window.measure(0);
        let last = self.end_index();
        for i in 0..self.window.len() {
            if let Some(station) = self.window.get_mut(i) {
                station.state = if i <= last { station.agreed } else { PathState::REST };
            }
        }
    }

    /// Takes out the station at `i`, which was put into `cell`.
    pub(super) fn take_out(&mut self, i: usize, cell: Cell<S, N>, pace: &Pace<S, N>) {
        let Some(before) = i.checked_sub(1) else { return };
        if let Some(station) = self.window.get_mut(before) {
            station.cell = cell;
        }
        self.window.remove(i);
        self.planned_end = self.planned_end.previous();
        self.window.bound(before, pace);
    }
}
