//! The agreed motion made faster inside the band, shape and speed together, while there is nothing else to do.
//!
//! A window of the agreed plan is given to [`crate::reshape`], from a node on that the motion will come to in time, up to where the
//! next plan ahead will change nothing. The motion that comes back is a cubic in time between any two knots, and so is the piece over
//! a cell between two stations with the states there: knots become stations ([`knots`]), in place of those between the node
//! and the place where the agreed motion is joined. The plan is offered like any other, and branches off at the node; until it is taken
//! the window is as it was. What is run then is a plan like any other for every command.
//!
//! What the band is around are the programmed lines, which are remembered for it ([`lines`]); over arcs, curves and lines without
//! a tolerance the motion is left as it is.

mod going;
mod knots;
mod lines;

use self::going::{Going, PLACES, Times, least_time};
use self::knots::{Knotted, Knotting};
use self::lines::{Lines, NEAR};
use super::Planner;
use super::making::{Purpose, Stage};
use super::phase::{Following, Offer, Phase};
use crate::block::{Block, Feed, Motion};
#[cfg(feature = "shaping")]
use crate::machine::Follower;
#[cfg(feature = "travel")]
use crate::machine::Travel;
use crate::machine::{Config, CornerMode, LimitSets};
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::{ArcLength, Coord, Scalar};
use crate::path::budget;
use crate::planner::horizon::Proposal;
use crate::profile::compile::Placement;
use crate::profile::law::PathState;
use crate::profile::solver::Stretch;
use crate::profile::window::Station;
use crate::reshape::{Bounds, Improving, Line, Places, Window};
use crate::servo::link::Branch;
use crate::servo::piece::Sequel;
use core::ops::ControlFlow;
use heapless::Vec;

/// Control points of a window.
const POINTS: usize = 31;
/// Its spans.
const SPANS: usize = POINTS - 3;
/// Time between knots, s.
const KNOTS: f64 = 8.0e-3;
/// Spans after which the next window begins, at least, and as a part of its own at most.
const RUN: usize = 7;
const MOST_RUN: (usize, usize) = (3, 4);
/// Pieces that are handed over in one slice.
const HANDED: usize = 16;
/// Making a window takes at most one in so many parts of the time: on a slow chip the next begins later.
const PARTS: f64 = 3.0;
/// Share of the band that is used where it is looked at.
const BAND: f64 = 0.97;
/// So many times as long as a window the agreed motion must go on to be sure to be joined.
const AHEAD: f64 = 1.1;
/// So far it is looked at.
const SEEN: f64 = 1.4;
/// Fewer knots than this before a rest are left as they are.
const LEAST_SPANS: f64 = 5.0;
/// Cells ahead of the motion up to which lines are found if nothing else is done.
const KEPT: usize = 2;
/// Stations of a window: its knots, and where it joins the agreed motion.
const STATIONS: usize = 72;
/// Places of which the lines are found in a slice, and tries to make stations of a span in one.
const PLACES_AT_ONCE: usize = 8;
const TRIES_AT_ONCE: usize = 1;
/// Fewer spans than this are not worth a window; and what is added after one that took few stations.
const FEWEST: usize = 20;
const MORE: usize = 2;
/// Least size of a planning window in which there is room for what a motion is made of.
const LEAST_NODES: usize = 128;

/// Stations for which room is kept: so many more may be there afterwards.
pub const fn reserve<const NODES: usize>() -> usize {
    if NODES < LEAST_NODES { 0 } else { NODES / 3 }
}

/// How stations are replaced in the plan in the making, or on offer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    /// Where the plan begins.
    start: NodeSerial,
    /// The first station that is replaced.
    first: NodeSerial,
    /// How many are.
    replaced: usize,
    /// Arc length at the next piece.
    arc_length: ArcLength,
    /// A node whose line is known once it has been taken.
    track: Option<(NodeSerial, u32)>,
}

/// The memory in which the agreed motion is made faster, shape and speed together: see [`Planner::reshape`]. In firmware a `static`; an
/// empty one is all zeros.
pub struct Reshaping<S: Scalar, const N: usize> {
    lines: Lines<S, N>,
    window: Window<S, N, POINTS>,
    near: Vec<Line<S, N>, NEAR>,
    places: Places<S, PLACES>,
    /// Those of its cells.
    times: Times<S>,
    /// What is to take the place of stations.
    stations: Vec<Station<S, N>, STATIONS>,
    knotting: Option<Knotting<S, N>>,
    pub(super) change: Option<Change>,
    /// A node whose line is known.
    track: Option<(NodeSerial, u32)>,
    /// Where the next window begins, at the earliest.
    next: Option<NodeSerial>,
    /// Spans of the next window, [`FEWEST`] to [`SPANS`], and those after which another begins.
    spans: usize,
    run: usize,
    /// Whether more of the path must be planned before more can be done.
    pub(super) wants: bool,
    /// Nothing can be done from this node on before the plan has another end.
    idle: Option<(NodeSerial, NodeSerial)>,
}

impl<S: Scalar, const N: usize> Default for Reshaping<S, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const N: usize> Reshaping<S, N> {
    /// An empty one.
    pub const fn new() -> Self {
        Self::NONE
    }

    const NONE: Self = Self {
        lines: Lines::NONE,
        window: Window::EMPTY,
        near: Vec::new(),
        places: Places::NONE,
        times: Vec::new(),
        stations: Vec::new(),
        knotting: None,
        change: None,
        track: None,
        next: None,
        spans: 0,
        run: 0,
        wants: false,
        idle: None,
    };

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.lines.clear();
        (self.change, self.track, self.next, self.idle) = (None, None, None, None);
        (self.spans, self.run, self.wants) = (SPANS, RUN, false);
    }

    /// Takes note of a block that has been taken.
    pub(super) fn note(&mut self, from: &[Coord; N], block: &Block<S, N>, config: &Config<S, N>) {
        let to = match &block.motion {
            Motion::Line { to } | Motion::Arc { to, .. } | Motion::Cubic { to, .. } => *to,
            Motion::Dwell { .. } | Motion::Event { .. } => return,
        };
        let straight = matches!(block.motion, Motion::Line { .. });
        if straight && to == *from {
            return;
        }
        let band = budget::of_setpoints(budget::tolerance(block, config), config);
        let feed = match block.feed {
            Feed::PerSecond(feed) => feed,
            _ => S::of(Line::<S, N>::RAPID),
        };
        if !self.lines.push(from, to, if straight { band } else { S::ZERO }, feed) {
            // The machine has been elsewhere, or has forgotten a program.
            (self.track, self.next, self.idle) = (None, None, None);
        }
    }
}

/// Whether a machine is one whose motion can be reshaped.
fn is_plain<S: Scalar, const N: usize>(config: &Config<S, N>) -> bool {
    #[cfg(feature = "travel")]
    if config.travel != Travel::OPEN {
        return false;
    }
    #[cfg(feature = "shaping")]
    if config.follower != Follower::NONE {
        return false;
    }
    config.corner == CornerMode::Band
        && config.limits.motors().next().is_none()
        && config.limits.axes().iter().all(|axis| !axis.rotary)
}

/// A stretch of the agreed plan that may be reshaped.
struct Place<S> {
    /// Where it begins.
    first: usize,
    /// A station before it, or that, and in which line that is.
    known: usize,
    line: u32,
    /// Station up to which it may be changed, and whether the motion rests there.
    limit: usize,
    rests: bool,
    /// When what is looked at ends, s from its beginning.
    ends: S,
}

/// Where a window lies in the plan.
#[derive(Clone, Copy)]
struct Extent {
    /// Where it begins, a station before it, or that, whose line is known, and the station up to which it may be changed.
    first: usize,
    known: usize,
    limit: usize,
}

/// A window that is being reshaped.
#[derive(Clone, Copy, Debug)]
pub struct Shaping<S> {
    /// Where it begins.
    first: NodeSerial,
    /// A station before it, or that, and in which line that is.
    known: NodeSerial,
    line: u32,
    /// Station up to which it may be changed, and whether the motion rests there.
    limit: NodeSerial,
    rests: bool,
    /// When what is looked at ends, s from its beginning.
    ends: S,
    /// Servo cycle in which it was begun.
    began: CycleSerial,
    work: Work<S>,
}

/// What the next slice does for a window; lines are counted from the station where they are known on.
#[derive(Clone, Copy, Debug)]
enum Work<S> {
    /// Finds the lines of some places.
    Placing,
    /// Goes on with improving the motion, which begins behind so many lines.
    Improving(usize, Improving<S>),
    /// Makes stations of some spans.
    Knotting(usize),
}

impl<'a, S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'a, S, N, BLOCKS, NODES>
{
    /// Makes what is agreed faster from now on, in idle time, with this memory; what it remembers of an earlier planner is forgotten. To
    /// be called before the first block is pushed.
    ///
    /// The motion keeps everything that it keeps without it. The planning window must hold 128 nodes at least, 192 or more to gain all
    /// that can be, and nothing is gained over arcs and curves, on rotary axes, with motors that follow several axes, with corners of
    /// the paper and beside limits of travel.
    pub fn reshape(&mut self, memory: &'a mut Reshaping<S, N>) {
        memory.clear();
        self.reshaping = Some(memory);
    }

    /// Does something with what reshaping remembers, if there is any.
    pub(super) fn reshaping<T>(
        &mut self,
        work: impl FnOnce(&mut Self, &mut Reshaping<S, N>) -> T,
    ) -> Option<T> {
        let memory = self.reshaping.take()?;
        let done = work(self, memory);
        self.reshaping = Some(memory);
        Some(done)
    }

    /// Begins to reshape a part of the agreed motion, if there is one that can be. Whether a plan is in the making.
    pub(super) fn begin_reshaping(&mut self, memory: &mut Reshaping<S, N>, at: NodeSerial) -> bool {
        let Phase::Following(now) = self.phase else { return false };
        if now.halt.is_some() || self.horizon.is_slowed(at) {
            return false;
        }
        let end = self.horizon.end_index();
        let open = !self.horizon.window.get(end).is_some_and(|end| end.rest);
        let branch = Branch::Node(self.horizon.end());
        let stretch = Stretch { first: end, last: end, open };
        let Some(shaping) = self.begin_shaping(memory, stretch, at) else { return false };
        let proposal = Proposal { stretch, branch, halt: None };
        self.horizon.begin_draft();
        self.make((Purpose::Shape, at), Some((proposal, Stage::Shaping(shaping))))
    }

    /// Begins to reshape a part of what leads to the end of a stretch.
    pub(super) fn begin_shaping(
        &self,
        memory: &mut Reshaping<S, N>,
        stretch: Stretch,
        at: NodeSerial,
    ) -> Option<Shaping<S>> {
        if NODES < LEAST_NODES || !is_plain(&self.horizon.config) {
            return None;
        }
        #[cfg(feature = "outputs")]
        if self.switches.are_used() {
            return None;
        }
        let Place { first, known, line, limit, rests, ends } = self.place(memory, stretch, at)?;
        let until = rests.then_some(limit);
        self.begin_placing(memory, (known, line), (first, ends), until)?;
        // Where nothing is found, the next window begins as much later.
        self.skip(memory, Extent { first, known, limit });
        let serial = |i: usize| self.horizon.window.serial(i);
        let (first, known, limit) = (serial(first), serial(known), serial(limit));
        let began = self.side.cycles();
        Some(Shaping { first, known, line, limit, rests, ends, began, work: Work::Placing })
    }

    /// The next window begins as much later as a window runs.
    fn skip(&self, memory: &mut Reshaping<S, N>, extent: Extent) {
        let run = S::of(KNOTS) * S::from_u32(memory.run as u32);
        let Extent { known, limit, .. } = extent;
        let next = (known..limit).zip(&memory.times).find(|(_, time)| **time >= run);
        memory.next = Some(self.horizon.window.serial(next.map_or(limit, |(i, _)| i)));
    }

    /// Nothing was found: the next window begins so much later that looking for it has taken a part of the time only.
    fn leave(&self, memory: &mut Reshaping<S, N>, shaping: &Shaping<S>, extent: Extent) {
        memory.run = self.run_of(shaping, memory.spans);
        self.skip(memory, extent);
    }

    /// A step of reshaping a plan whose states are found. `None`: there is more to do. Whether it could be done, and may begin sooner
    /// then.
    pub(super) fn go_on_shaping(
        &self,
        memory: &mut Reshaping<S, N>,
        shaping: &mut Shaping<S>,
        proposal: &mut Proposal,
    ) -> Option<bool> {
        let Some(extent) = self.extent(shaping) else { return Some(false) };
        let (passed, mut improving) = match shaping.work {
            Work::Placing => {
                if !self.go_on_placing(memory, (extent.known, extent.first), shaping.ends) {
                    return None;
                }
                let Some(work) = self.begin_improving(memory, shaping, extent) else {
                    return Some(false);
                };
                shaping.work = work;
                return None;
            }
            Work::Improving(passed, improving) => (passed, Some(improving)),
            Work::Knotting(passed) => (passed, None),
        };
        let Reshaping { near, places, window, stations, knotting, run, times, .. } = &mut *memory;
        let going = self.going(shaping.ends, extent, times, (near, places, passed));
        let horizon = &*self.horizon;
        let Some(from) = horizon.window.get(extent.first) else { return Some(false) };
        let limits = LimitSets::new(&horizon.config, &horizon.older);
        let limits = limits.of(from.cell.programmed.limits).axes();
        let bounds = Bounds { limits, lines: near.get(passed..).unwrap_or(&[]), line: 0 };
        if let Some(improving) = &mut improving {
            match window.go_on(improving, &going, &bounds) {
                ControlFlow::Continue(()) => {
                    shaping.work = Work::Improving(passed, *improving);
                    return None;
                }
                ControlFlow::Break(Err(_)) => {
                    self.leave(memory, shaping, extent);
                    return Some(false);
                }
                ControlFlow::Break(Ok(_)) => {}
            }
            let rests = shaping.rests && !(window.joins() < shaping.ends);
            stations.clear();
            let spans = window.spans();
            *run = self.run_of(shaping, spans);
            *knotting = Knotting::new(window, &going, (extent.first, rests, extent.limit), *run);
            shaping.work = Work::Knotting(passed);
            if knotting.is_some() {
                return None;
            }
            self.leave(memory, shaping, extent);
            return Some(false);
        }
        let Some(knots) = knotting else { return Some(false) };
        let ControlFlow::Break(found) =
            knots.go_on(window, &going, &bounds, TRIES_AT_ONCE, stations)
        else {
            return None;
        };
        let spans = knots.spans();
        let line = shaping.line.wrapping_add(passed as u32);
        let changed = self.change(memory, proposal, (extent.first, spans, line), found);
        if !changed {
            self.leave(memory, shaping, extent);
        }
        Some(changed)
    }

    /// Spans of a window that are run in so long a time that making it takes a part of it only, if it has so many.
    fn run_of(&self, shaping: &Shaping<S>, spans: usize) -> usize {
        let cycles = self.side.cycles().since(shaping.began).unwrap_or(0);
        let time = S::from_u32(cycles) * self.horizon.config.cycle;
        let run = (time * S::of(PARTS / KNOTS)).to_i64().clamp(0, 1000) as usize;
        run.min(spans * MOST_RUN.0 / MOST_RUN.1).max(RUN)
    }

    /// Where a window lies in the plan.
    fn extent(&self, shaping: &Shaping<S>) -> Option<Extent> {
        let find = |serial| self.horizon.window.find(serial);
        let (first, known) = (find(shaping.first)?, find(shaping.known)?);
        Some(Extent { first, known, limit: find(shaping.limit)? })
    }

    /// The agreed motion from there on; lines are those from the station where they are known on, of which so many lie before.
    fn going<'b>(
        &'b self,
        ends: S,
        extent: Extent,
        times: &'b Times<S>,
        (lines, places, passed): (&'b [Line<S, N>], &'b Places<S, PLACES>, usize),
    ) -> Going<'b, S, N, NODES> {
        let horizon = &*self.horizon;
        Going {
            horizon,
            first: extent.known,
            times,
            origin: horizon.window.get(extent.first).map_or([Coord::ZERO; N], |at| at.node.at),
            ends,
            least: least_time(&horizon.config),
            lines,
            places: Some(places),
            passed,
        }
    }

    /// The lines are found: the motion is to be improved.
    fn begin_improving(
        &self,
        memory: &mut Reshaping<S, N>,
        shaping: &Shaping<S>,
        extent: Extent,
    ) -> Option<Work<S>> {
        let Reshaping { near, places, window, spans, track, times, .. } = &mut *memory;
        let passed = if extent.known == extent.first {
            0
        } else {
            places.line(near, -*times.first()?, &[S::ZERO; N])?
        };
        *track = Some((shaping.first, shaping.line.wrapping_add(passed as u32)));
        let going = self.going(shaping.ends, extent, times, (near, places, passed));
        window.set(S::of(KNOTS), S::of(BAND), *spans);
        window.begin(&going.state(S::ZERO).state, S::ZERO);
        Some(Work::Improving(passed, window.begin_improving(&going).ok()?))
    }

    /// The stations are made, of so many spans from a station on, in a line: the plan is changed. Whether it could be.
    fn change(
        &self,
        memory: &mut Reshaping<S, N>,
        proposal: &mut Proposal,
        (first, spans, line): (usize, usize, u32),
        found: Option<Knotted>,
    ) -> bool {
        // So many as there is room for their stations.
        memory.spans = if memory.stations.is_full() {
            spans * 3 / 4
        } else if memory.stations.len() + spans / 4 < STATIONS {
            spans + MORE
        } else {
            spans
        }
        .clamp(FEWEST, SPANS);
        let Some(Knotted { replaced, next }) = found else { return false };
        let window = &self.horizon.window;
        if window.len() + memory.stations.len() + super::horizon::ADDED + 2 > NODES + replaced {
            return false;
        }
        let begins = proposal.stretch.first.min(first);
        let Some(station) = window.get(begins) else { return false };
        let (start, first) = (window.serial(begins), window.serial(first));
        let track =
            next.map(|(station, leg)| (first.plus(station as u32), line.wrapping_add(leg as u32)));
        let arc_length = station.arc_length;
        memory.change = Some(Change { start, first, replaced, arc_length, track });
        proposal.stretch.first = begins;
        proposal.branch = Branch::Node(start);
        true
    }

    /// What can be reshaped now of what leads to the end of a stretch.
    fn place(
        &self,
        memory: &mut Reshaping<S, N>,
        stretch: Stretch,
        at: NodeSerial,
    ) -> Option<Place<S>> {
        let window = &self.horizon.window;
        let end = stretch.last;
        let mut first = if matches!(self.phase, Phase::Following(_)) {
            let planned = self.effort.shape.cycles(1) * self.horizon.config.cycle;
            let branch = self.horizon.branch(at, |_| planned)?;
            if branch == self.horizon.end() {
                return None;
            }
            let next = memory.next.and_then(|next| window.find(next)).unwrap_or(0);
            window.clamped_index(branch).max(next)
        } else {
            stretch.first
        };
        while first < end && window.get(first).is_some_and(|from| !(from.cell.length > S::ZERO)) {
            first += 1;
        }
        if first >= end || self.leaves_no_time(first, at) {
            return None;
        }
        let idle = (window.serial(first), window.serial(end));
        if memory.idle == Some(idle) {
            return None;
        }
        memory.idle = Some(idle);
        memory.wants = false;
        let (known, line) = self.known(memory, first)?;
        let window = &self.horizon.window;
        memory.track = Some((window.serial(known), line));
        let is_rest = |i: &usize| window.get(*i).is_some_and(|station| station.rest);
        let rest = (first + 1..=end).find(is_rest);
        let limit = rest.unwrap_or_else(|| self.horizon.settled_end(end));
        let whole = S::of(KNOTS) * S::from_u32(memory.spans as u32);
        let seen = whole * S::of(SEEN);
        let reached = self.times(known, first, limit, seen, &mut memory.times)?;
        let left = memory.times.last().copied()?;
        if (rest.is_none() || reached < limit) && left < whole * S::of(AHEAD) {
            memory.wants = true;
            return None;
        }
        if left < S::of(KNOTS * LEAST_SPANS) {
            // On behind the rest.
            memory.next = Some(window.serial(limit));
            return None;
        }
        // Up to the rest, if it can be seen.
        let rests = rest.is_some() && reached == limit && !(seen < left);
        Some(Place { first, known, line, limit, rests, ends: left.least(seen) })
    }

    /// When the cells from station `known` on begin, s from `first` on, up to the cell in which it is `until`, or to station `limit`:
    /// at which they end. `None` if limits change between them.
    fn times(
        &self,
        known: usize,
        first: usize,
        limit: usize,
        until: S,
        times: &mut Times<S>,
    ) -> Option<usize> {
        let window = &self.horizon.window;
        let limits = window.get(first)?.cell.programmed.limits;
        times.clear();
        for _ in known..=first {
            times.push(S::ZERO).ok()?;
        }
        for k in (known..first).rev() {
            times[k - known] = times[k + 1 - known] - self.horizon.time(k);
        }
        let mut time = S::ZERO;
        let mut end = first;
        while end < limit && time < until && !times.is_full() {
            if window.get(end)?.cell.programmed.limits.differs(limits) {
                return None;
            }
            time += self.horizon.time(end);
            times.push(time).ok()?;
            end += 1;
        }
        Some(end)
    }

    /// The line at a station, from one before it at which that is known.
    fn line_at(&self, memory: &mut Reshaping<S, N>, first: usize) -> Option<u32> {
        let (known, line) = self.known(memory, first)?;
        if known == first {
            return Some(line);
        }
        self.times(known, first, first, S::ZERO, &mut memory.times)?;
        self.begin_placing(memory, (known, line), (first, S::ZERO), None)?;
        // It is not far: see `keep_track`.
        while !self.go_on_placing(memory, (known, first), S::ZERO) {}
        let before = -*memory.times.first()?;
        let leg = memory.places.line(&memory.near, before, &[S::ZERO; N])?;
        Some(line.wrapping_add(leg as u32))
    }

    /// The line at a station that the motion is about to pass is not known to anybody else: goes on to one further ahead.
    pub(super) fn keep_track(&mut self, memory: &mut Reshaping<S, N>, at: NodeSerial) {
        let window = &self.horizon.window;
        let Some((node, _)) = memory.track else { return };
        let (Some(known), here) = (window.find(node), window.clamped_index(at)) else { return };
        // What is on offer may have other stations from here on.
        let offered =
            self.phase.offer().map_or(window.len() - 1, |offer| window.clamped_index(offer.first));
        let ahead = (here + KEPT).min(offered).min(self.horizon.end_index());
        if known <= here + 1 && ahead > known {
            let track =
                self.line_at(memory, ahead).map(|line| (self.horizon.window.serial(ahead), line));
            if track.is_some() {
                memory.track = track;
            }
        }
    }

    /// Begins to find the lines of the motion from a station on, in the first of which it is there, to a time behind another, s, about
    /// which they are; with `rests` up to the end of one, at that station. `None` if they are not known for all of it.
    fn begin_placing(
        &self,
        memory: &mut Reshaping<S, N>,
        (known, line): (usize, u32),
        (first, ends): (usize, S),
        rests: Option<usize>,
    ) -> Option<()> {
        let window = &self.horizon.window;
        let (mut length, mut left) = (S::ZERO, ends);
        for i in known..window.len() - 1 {
            if i >= first && !(left > S::ZERO) {
                break;
            }
            length += window.get(i)?.cell.length;
            if i >= first {
                left = left - self.horizon.time(i);
            }
        }
        let rests = rests.and_then(|i| window.get(i)).map(|rest| rest.node.at);
        // What the path is longer than the motion, a corner's cut.
        let length = length * S::of(1.02) + S::of(2.0);
        let Reshaping { lines, near, places, times, .. } = &mut *memory;
        let overrides = self.horizon.overrides();
        let feed = S::from_u32(u32::from(overrides.feed.max(1))) * S::of(0.01);
        lines.release_before(line);
        let [from, origin] = [window.get(known)?.node.at, window.get(first)?.node.at];
        lines.near((line, &from), &origin, length, feed, rests.as_ref(), near)?;
        places.set_step(S::of(KNOTS / crate::reshape::PLACES as f64));
        places.begin(0, ends - *times.first()?);
        Some(())
    }

    /// Goes on with that. Whether all are found, up to `ends` s behind the station `first`.
    fn go_on_placing(
        &self,
        memory: &mut Reshaping<S, N>,
        (known, first): (usize, usize),
        ends: S,
    ) -> bool {
        let horizon = &*self.horizon;
        let Reshaping { near, places, times, .. } = &mut *memory;
        let (Some(begins), Some(station)) = (times.first(), horizon.window.get(first)) else {
            return true;
        };
        let going = Going {
            horizon,
            first: known,
            times,
            origin: station.node.at,
            ends,
            least: S::ZERO,
            lines: near,
            places: None,
            passed: 0,
        };
        let at = |time: S| going.state((time + *begins).least(ends)).state.position;
        places.go_on(near, PLACES_AT_ONCE, at)
    }

    /// A station before another, or that, whose line is known.
    fn known(&self, memory: &Reshaping<S, N>, first: usize) -> Option<(usize, u32)> {
        let window = &self.horizon.window;
        let track = memory.track;
        if let Some((node, line)) = track
            && let Some(i) = window.find(node)
        {
            return (i <= first).then_some((i, line));
        }
        // Where the motion rests it is at the end of a line.
        (0..=first).rev().find_map(|i| {
            let station = window.get(i).filter(|station| station.rest)?;
            let from = track.map(|(_, line)| line);
            Some((i, memory.lines.starting_at(&station.node.at, from)?))
        })
    }

    /// Hands over some pieces of the changed plan; from which one on there are more.
    pub(super) fn hand_over_reshaped(
        &mut self,
        memory: &mut Reshaping<S, N>,
        proposal: Proposal,
        next: usize,
    ) -> Option<usize> {
        let mut change = memory.change?;
        let stations = &memory.stations;
        let Stretch { first, last: end, open } = proposal.stretch;
        let before = change.first.since(change.start).unwrap_or(0) as usize;
        let behind = first + before + change.replaced;
        let count = before + stations.len() + end - behind;
        let last = count.min(next + HANDED);
        let window = &self.horizon.window;
        for k in next..last {
            let station = |k: usize| match k.checked_sub(before) {
                None => window.get(first + k),
                Some(k) => match k.checked_sub(stations.len()) {
                    None => stations.get(k),
                    Some(k) => window.get(behind + k),
                },
            };
            let (Some(from), Some(to)) = (station(k), station(k + 1)) else { break };
            let at_end = k + 1 == count;
            let sequel = if to.rest || (at_end && !open) {
                Sequel::Stop
            } else if at_end {
                Sequel::Starved
            } else {
                Sequel::Motion
            };
            let state = if at_end { PathState::REST } else { to.state };
            let (serial, arc_length) = (change.start.plus(k as u32), change.arc_length);
            let placement = Placement { serial, arc_length, sequel };
            let states = [from.state, state];
            let Some(piece) = self.horizon.piece_of([from, to], states, placement) else { break };
            change.arc_length = change.arc_length.plus(from.cell.length);
            self.side.write(&piece);
        }
        memory.change = Some(change);
        if last < count {
            return Some(last);
        }
        // Every station behind the end rests in the draft.
        for i in end..self.horizon.window.len() {
            self.horizon.window.set_state(i, PathState::REST);
        }
        None
    }

    /// Offers the changed plan.
    pub(super) fn offer_reshaped(&mut self, memory: &Reshaping<S, N>, proposal: Proposal) {
        let Some(change) = memory.change else { return };
        let before = match self.phase {
            Phase::Following(now) => Some(now),
            _ => None,
        };
        let Stretch { first, last, .. } = proposal.stretch;
        self.horizon.mark_offered();
        #[cfg(feature = "outputs")]
        if let Some(end) = self.horizon.window.get(last) {
            // By how much what lies behind comes to lie elsewhere.
            let longer = change.arc_length.raw().wrapping_sub(end.arc_length.raw());
            self.time_switches_behind(proposal.branch, longer);
        }
        self.side.offer(proposal.branch);
        let stations = memory.stations.len();
        let cells = stations + last - change.replaced - first;
        let end = change.start.plus(cells as u32);
        let checkpoint = match before {
            // Nothing new.
            Some(now) if self.horizon.window.serial(last) == self.horizon.end() => {
                let joined = change.first.plus(stations as u32);
                let behind = change.first.plus(change.replaced as u32);
                now.checkpoint.since(behind).map_or(joined, |more| joined.plus(more))
            }
            _ => change.start.plus((cells / 2) as u32),
        };
        let taken =
            Following { halt: proposal.halt, checkpoint, shown: end, tried_block_end: false };
        self.phase = Phase::Offered(Offer {
            first: change.start,
            end,
            by_cycle: false,
            begins: false,
            taken,
            before,
        });
        self.counters.plans += 1;
    }

    /// The changed plan has been taken, or refused.
    pub(super) fn decide_reshaped(&mut self, memory: &mut Reshaping<S, N>, taken: bool) {
        let Some(change) = memory.change.take() else { return };
        if taken {
            if let Some((node, _)) = change.track {
                memory.next = Some(node);
                memory.track = change.track;
            } else {
                // It ends in a rest.
                let joined = change.first.plus(memory.stations.len() as u32);
                memory.next = Some(joined);
            }
            self.horizon.replace(change.first, change.replaced, &memory.stations);
        } else {
            memory.next = None;
            memory.idle = None;
        }
    }
}
