//! Cutting the horizon where the motion will be.
//!
//! Where a cell that is being run, or will be, is cut, the station put in has the very position,
//! velocity and acceleration of the motion there: what is left of the cell is run as if nothing had
//! been cut.

use super::{Horizon, Moment};
use crate::number::Scalar;
use crate::number::serial::CycleSerial;
use crate::number::vector::{dot, norm, zero};
use crate::path::hermite::Hermite;
use crate::path::node::{Cell, Node};
use crate::profile::law::{Law, PathState};
use crate::profile::solver::Stretch;
use crate::profile::window::Station;
use crate::servo::link::Branch;
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// A cell is cut only if this many servo cycles are left of it.
const LEAST_CYCLES: f64 = 2.0;
/// A crawl is slower than so many J c^2, with the servo cycle c: what jerk builds up in less than three cycles.
const CRAWL: f64 = 4.0;
/// An acceleration across the path may leap by this share of what jerk changes in a servo cycle: within what `profile`
/// keeps of the jerk's limit in reserve. (A start or an end of a curved cell, taken for the path's own curve, leapt by
/// .006 of it, and a jerk was 1.0014 of its limit.)
const LEAP: f64 = 2.5e-4;
/// Share of a crawl below which an acceleration across the path, over the square of the speed, says nothing of a curvature.
const SLOW: f64 = 0.05;
/// Share of a crawl below which a motion is not cut that comes to rest or gets going in a moment: in so many servo cycles its acceleration
/// takes it there. (One that is asked to be so slow is cut.)
const LEAST_SPEED: f64 = 1.0e-3;
const MOMENT: f64 = 4.0;
/// Start curvature times length from which on it is not the path's, rad: no cell of a path turns so far. It is that of a motion
/// which hardly moved.
const MOST_TURN: f64 = 1.0;
/// Share of a servo cycle that is left of a dwell when it is suspended: then it is over in the cycle that
/// takes it up.
const DWELL_END: f64 = 0.5;
/// Cells in the distance that it takes to stop.
const BRAKE_CELLS: f64 = 4.0;

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Cuts the window where the motion will be when an answer can take effect. Returns the index
    /// of the station there and the branch.
    // Once in the image, however often it is called.
    #[inline(never)]
    pub fn cut_in(&mut self, moment: Moment<S>) -> Option<(usize, Branch)> {
        let Moment { timeline: line, when } = moment;
        if self.is_slowed(line.serial) {
            return None;
        }
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
    pub fn cut_dwell(&mut self, moment: Moment<S>) -> Option<(Stretch, Branch)> {
        let Moment { timeline: line, when } = moment;
        let i = self.window.clamped_index(line.serial);
        let original = *self.window.get(i)?;
        let Cell { length, dwell, event, .. } = original.cell;
        let runs = self.window.serial(i) == line.serial && line.serial != self.end;
        if length > S::ZERO || event.is_some() || !runs {
            return None;
        }
        let cycle = self.config.cycle;
        let left = dwell - (line.lag + S::from_u32(when.since(line.began)?) * cycle);
        if !(left >= cycle * S::of(LEAST_CYCLES)) {
            return None;
        }
        let rest = Cell { dwell: left, ..original.cell };
        let rest = Station { cell: rest, rest: true, pause: false, ..original };
        if !self.add(i, rest) {
            return None;
        }
        self.keep(line.serial, original);
        self.window.get_mut(i)?.cell.dwell = cycle * S::of(DWELL_END);
        Some((Stretch { first: i, last: i + 1, open: false }, Branch::Cycle(when)))
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
        self.keep(self.window.serial(i), original);
        *self.window.get_mut(i)? = station;
        self.bound(i);
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
    pub fn cut_agreed(&mut self, i: usize, t: S) -> bool {
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

    /// The same where the motion will come to rest. From there the path goes on by its own shape, not by that of the motion
    /// as agreed: near a start or an end that has next to none, and what follows a rest is a new motion along the path.
    pub fn cut_at_rest(&mut self, i: usize, t: S) -> bool {
        let Some((station, after)) = self.window.pair(i) else { return false };
        let (mut start, cell, end) = (station.node, station.cell, station.arrival(after));
        if norm(&start.curvature) * cell.length > S::of(MOST_TURN) {
            // A motion has been cut there, too.
            let along = dot(&end.curvature, &start.tangent);
            start.curvature = from_fn(|k| end.curvature[k] - start.tangent[k] * along);
        }
        if !self.cut_agreed(i, t) {
            return false;
        }
        if cell.straight {
            return true;
        }
        let Some(passed) = self.window.get(i).map(|station| station.cell.length) else {
            return false;
        };
        let Some(rest) = self.window.get_mut(i + 1) else { return false };
        let share = passed / cell.length;
        let curve = Hermite::of_cell(&start, &cell, &end);
        rest.node = Node { at: rest.node.at, ..curve.node(&start, share) };
        rest.cell.length = curve.arc_length(share, S::ONE);
        rest.cell.tangent_offset = rest.node.tangent_offset_to(&end.at, rest.cell.length);
        self.bound_halves(i);
        true
    }

    /// A station in the middle of the cell of station `i`, `t` seconds after its start, in the
    /// motion as agreed: the rest of the cell is run as if nothing had been cut.
    pub fn station_within(&self, i: usize, t: S) -> Option<Station<S, N>> {
        let (station, after) = self.window.pair(i)?;
        self.station_between(i, t, [station.agreed, after.agreed])
    }

    /// The same in the motion of the draft.
    #[cfg(feature = "reshape")]
    pub fn station_on_the_way(&self, i: usize, t: S) -> Option<Station<S, N>> {
        let (station, after) = self.window.pair(i)?;
        self.station_between(i, t, [station.state, after.state])
    }

    /// The same in the motion from a state to another at the next station.
    fn station_between(&self, i: usize, t: S, states: [PathState<S>; 2]) -> Option<Station<S, N>> {
        let (station, after) = self.window.pair(i)?;
        let piece: Piece<S, N> = self.piece_between(i, states, Sequel::Motion)?;
        let here = piece.at(t);
        let distance = here.path_offset;
        let along = dot(&here.acceleration, &station.node.tangent).abs();
        let soon =
            (along * self.config.cycle * S::of(MOMENT)).least(self.crawl() * S::of(LEAST_SPEED));
        if !(here.path_speed > soon) {
            return None;
        }
        // What is left of the cell must make good what is rounded here, in ever less time.
        let at = piece.place(t);
        let mut cut = *station;
        let node = if station.cell.straight {
            Node { at, tangent: station.node.tangent, curvature: zero() }
        } else {
            let size = norm(&here.velocity);
            let tangent = from_fn(|k| here.velocity[k] / size);
            let along = dot(&here.acceleration, &tangent);
            let across: [S; N] = from_fn(|k| here.acceleration[k] - tangent[k] * along);
            let crawl = self.crawl();
            let curvature = if size > crawl {
                across.map(|a| a / (size * size))
            } else {
                // In a crawl the motion says little of the shape of the path, and the path's own
                // curvature makes no difference that could be felt, as a rule.
                let end = station.arrival(after);
                let curve = Hermite::of_cell(&station.node, &station.cell, &end);
                let own = curve.node(&station.node, distance / station.cell.length).curvature;
                let leap = crawl / self.config.cycle * S::of(LEAP / CRAWL);
                if (0..N).all(|k| (across[k] - own[k] * (size * size)).abs() <= leap) {
                    own
                } else if size > crawl * S::of(SLOW) {
                    across.map(|a| a / (size * size))
                } else {
                    return None;
                }
            };
            Node { at, tangent, curvature }
        };
        let v = dot(&here.velocity, &node.tangent);
        let state = PathState { b: v * v, a: dot(&here.acceleration, &node.tangent) };
        cut.node = node;
        (cut.rest, cut.pause) = (false, false);
        cut.arc_length = station.arc_length.plus(distance);
        cut.state = state;
        cut.agreed = state;
        cut.lead_to(&after.node.at, states[1], piece.time - t);
        // Where a motion comes to rest so softly that it hardly crosses the last of its cell, what is left is no cell of its own.
        is_crossed(cut.cell.length, state, states[1]).then_some(cut)
    }

    /// Speed, mm/s, below which accelerations across the path are lost beside what jerk changes in
    /// a servo cycle.
    pub fn crawl(&self) -> S {
        let jerk = self.config.limits.least_jerk();
        jerk * self.config.cycle * self.config.cycle * S::of(CRAWL)
    }

    /// Cuts the cells of the agreed motion within a distance, mm, of `first` finer. Returns where the station at `last` is
    /// then, and the first one behind all that was cut.
    pub fn refine(&mut self, first: usize, last: usize, distance: S) -> (usize, usize) {
        let mut behind = first;
        let Some(start) = self.window.get(first) else { return (last, behind) };
        let speed = start.state.b.sqrt();
        let longest = distance / S::of(BRAKE_CELLS);
        let (mut i, mut last) = (first, last);
        let mut done = S::ZERO;
        for _ in 0..NODES {
            let Some(station) = self.window.get(i) else { break };
            let length = station.cell.length;
            if i >= last || done > distance {
                break;
            }
            let time = self.agreed_time(i);
            let mut cut = time * S::of(0.5);
            if station.cell.straight {
                // In its middle, or where braking may end if that is much nearer.
                cut = cut.least((distance - done) / speed);
            }
            let may = length > longest && cut > self.config.cycle && self.room_to_add() > 0;
            if may && self.cut_agreed(i, cut) {
                last += 1;
                behind = if behind > i { behind + 1 } else { i + 2 };
            } else {
                done += length;
                i += 1;
            }
        }
        (last, behind)
    }

    /// The motion as agreed from where an answer can take effect, on cells cut finer.
    // Once in the image, however often it is called.
    #[inline(never)]
    pub fn prepare(&mut self, moment: Moment<S>) -> Option<(Stretch, Branch)> {
        let (first, branch) = self.cut_in(moment)?;
        let mut stretch = self.stretch_from(first);
        (stretch.last, _) = self.refine(first, stretch.last, self.braking_distance(first));
        self.loosen(first, stretch.last);
        Some((stretch, branch))
    }
}

/// Whether there is a motion over a cell of some length between two states.
// Off the stack of its callers.
#[inline(never)]
fn is_crossed<S: Scalar>(length: S, from: PathState<S>, to: PathState<S>) -> bool {
    length > S::ZERO && Law::new(length, from, to).is_some()
}
