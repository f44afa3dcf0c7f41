//! The stretch of path that is being planned.

use super::bounds::{Bounds, Pace};
use super::law::{Law, PathState, crossing};
use super::rows::View;
use crate::machine::{LimitSets, SetNumber};
use crate::number::optional::Optional;
use crate::number::serial::NodeSerial;
use crate::number::vector::dot;
use crate::number::{ArcLength, Coord, Scalar};
use crate::path::feed::LinearFeed;
use crate::path::node::{Cell, Event, Node, Programmed};
use core::array::from_fn;
use core::ops::Range;
use heapless::Deque;

/// A node of the window, its speed and acceleration, and the cell that leaves it.
#[derive(Clone, Copy, Debug)]
pub struct Station<S, const N: usize> {
    pub node: Node<S, N>,
    /// Cell to the next station; meaningless in the last one.
    pub cell: Cell<S, N>,
    pub bounds: Bounds<S>,
    /// Arc length from the start of the path.
    pub arc_length: ArcLength,
    /// Whether the motion rests here whatever follows.
    pub rest: bool,
    /// Whether it then goes on only when it is resumed.
    pub pause: bool,
    /// PathState in the plan that is being worked on.
    pub state: PathState<S>,
    /// PathState in the plan that is being executed.
    pub agreed: PathState<S>,
}

/// What is still asked of the cell before the first station.
#[derive(Clone, Copy, Debug)]
struct Passed {
    tag: u32,
    dwells: bool,
}

impl Passed {
    fn of<S: Scalar, const N: usize>(cell: &Cell<S, N>) -> Self {
        let dwells = !(cell.length > S::ZERO) && cell.event.is_none();
        Self { tag: cell.programmed.tag, dwells }
    }
}

/// A ring of stations. The first is where the part under execution starts; the last is at rest.
pub struct Window<S, const N: usize, const NODES: usize> {
    stations: Deque<Station<S, N>, NODES>,
    /// Running number of the first station.
    first: NodeSerial,
    /// The cell before that, if there was one.
    passed: Optional<Passed>,
}

impl<S: Scalar, const N: usize, const NODES: usize> Window<S, N, NODES> {
    /// The memory of one, without a node.
    pub const EMPTY: Self =
        Self { stations: Deque::new(), first: NodeSerial::ZERO, passed: Optional::NONE };

    /// Forgets everything, and rests at one node, whose running number is `first`.
    pub fn begin(&mut self, node: Node<S, N>, first: NodeSerial) {
        // Fourteen nodes are kept free for what answers to commands add. With fewer than 48 the others do not
        // hold the distance to a stop over the cells of corners and arcs: it is slower than a stop at every corner.
        const {
            assert!(
                NODES >= 48,
                "a window of fewer than 48 nodes is slower than stopping at every corner"
            );
        };
        let cell = Cell {
            length: S::ZERO,
            tangent_offset: [S::ZERO; N],
            programmed: Programmed {
                feed: S::ZERO,
                linear: LinearFeed::NONE,
                rapid: false,
                limits: SetNumber::FIRST,
                tag: 0,
            },
            dwell: S::ZERO,
            event: None,
            straight: true,
        };
        self.stations.clear();
        self.first = first;
        self.passed.set(None);
        let _ = self.stations.push_back(Station {
            node,
            cell,
            bounds: Bounds::default(),
            arc_length: ArcLength::ZERO,
            rest: true,
            pause: false,
            state: PathState::REST,
            agreed: PathState::REST,
        });
    }

    /// Number of stations, at least 1.
    pub fn len(&self) -> usize {
        self.stations.len()
    }

    /// Stations that can still be added.
    pub fn room(&self) -> usize {
        NODES - self.stations.len()
    }

    /// Running number of a station.
    pub fn serial(&self, index: usize) -> NodeSerial {
        debug_assert!(index < NODES);
        self.first.plus(index as u32)
    }

    /// Index of a station by its running number, if it is in the window.
    pub fn find(&self, serial: NodeSerial) -> Option<usize> {
        let ahead = serial.since(self.first)? as usize;
        (ahead < self.len()).then_some(ahead)
    }

    /// Index of a station by its running number: of the first one if that has been released, of
    /// the last one if it is yet to come.
    pub fn clamped_index(&self, serial: NodeSerial) -> usize {
        serial.since(self.first).map_or(0, |ahead| (ahead as usize).min(self.len() - 1))
    }

    #[inline(never)]
    pub fn get(&self, index: usize) -> Option<&Station<S, N>> {
        self.stations.get(index)
    }

    #[inline(never)]
    pub fn get_mut(&mut self, index: usize) -> Option<&mut Station<S, N>> {
        self.stations.get_mut(index)
    }

    pub fn last(&self) -> Option<&Station<S, N>> {
        self.stations.back()
    }

    pub fn last_mut(&mut self) -> Option<&mut Station<S, N>> {
        self.stations.back_mut()
    }

    /// Two neighbouring stations.
    #[inline(never)]
    pub fn pair(&self, index: usize) -> Option<(&Station<S, N>, &Station<S, N>)> {
        Some((self.stations.get(index)?, self.stations.get(index + 1)?))
    }

    /// Adds a cell behind the last station; the new last station rests.
    #[inline(never)]
    pub fn append(
        &mut self,
        cell: Cell<S, N>,
        node: Node<S, N>,
        rest: bool,
        pace: &Pace<'_, S, N>,
    ) {
        debug_assert!(cell.length >= S::ZERO && cell.dwell >= S::ZERO);
        debug_assert!(cell.length > S::ZERO || rest, "a dwell ends at rest");
        let mut arc_length = ArcLength::ZERO;
        if let Some(last) = self.stations.back_mut() {
            arc_length = last.arc_length.plus(cell.length);
            last.cell = cell;
            last.bounds = Bounds::new(&last.node, &cell, &node, pace);
        }
        let station = Station {
            node,
            cell,
            bounds: Bounds::default(),
            arc_length,
            rest,
            pause: cell.event == Some(Event::Pause),
            state: PathState::REST,
            agreed: PathState::REST,
        };
        // The caller asks for room first.
        let added = self.stations.push_back(station).is_ok();
        debug_assert!(added, "a cell without a node at its end");
    }

    /// Puts a station behind the one at `index`; the running numbers of those behind grow by one.
    /// Returns whether there was room.
    #[inline(never)]
    pub fn insert_after(&mut self, index: usize, station: Station<S, N>) -> bool {
        if self.stations.push_back(station).is_err() {
            return false;
        }
        for i in (index + 1..self.len() - 1).rev() {
            self.copy(i, i + 1);
        }
        if let Some(slot) = self.stations.get_mut(index + 1) {
            *slot = station;
        }
        true
    }

    /// Takes out stations, those that are marked, not the first; the running numbers of those behind each fall by one. Every station is
    /// moved once.
    pub fn remove(&mut self, out: &[bool; NODES]) {
        debug_assert!(out.first() != Some(&true), "the first station stays");
        let mut to = 0;
        for (from, _) in out.iter().take(self.len()).enumerate().filter(|(_, out)| !**out) {
            if to < from {
                self.copy(from, to);
            }
            to += 1;
        }
        self.stations.truncate(to);
    }

    /// Puts others in the place of some stations, for which there must be room; running numbers behind them change with their count.
    #[cfg(feature = "reshape")]
    pub fn replace(&mut self, old: Range<usize>, new: &[Station<S, N>]) {
        let len = self.len();
        debug_assert!(old.end <= len && len + new.len() <= NODES + old.len());
        if new.len() >= old.len() {
            let more = new.len() - old.len();
            for _ in 0..more {
                if let Some(last) = self.stations.back().copied() {
                    let _ = self.stations.push_back(last);
                }
            }
            for i in (old.end..len).rev() {
                self.copy(i, i + more);
            }
        } else {
            let fewer = old.len() - new.len();
            for i in old.end..len {
                self.copy(i, i - fewer);
            }
            self.stations.truncate(len - fewer);
        }
        for (i, station) in new.iter().enumerate() {
            if let Some(slot) = self.stations.get_mut(old.start + i) {
                *slot = *station;
            }
        }
    }

    #[inline(never)]
    fn copy(&mut self, from: usize, to: usize) {
        if let Some(station) = self.stations.get(from).copied()
            && let Some(slot) = self.stations.get_mut(to)
        {
            *slot = station;
        }
    }

    /// Forgets the stations behind the one at `index`, which then rests, and what was before the first.
    pub fn truncate(&mut self, index: usize) {
        debug_assert!(index < self.len());
        self.stations.truncate(index + 1);
        self.passed.set(None);
        if let Some(last) = self.stations.back_mut() {
            last.rest = true;
            last.pause = false;
            last.state = PathState::REST;
            last.agreed = PathState::REST;
        }
    }

    /// Sets a station's state in the plan that is being worked on.
    #[inline(never)]
    pub fn set_state(&mut self, index: usize, state: PathState<S>) {
        if let Some(station) = self.stations.get_mut(index) {
            station.state = state;
        }
    }

    /// Arc lengths behind a station anew, from its own.
    pub fn measure(&mut self, index: usize) {
        let mut arc_length = None;
        for station in self.stations.iter_mut().skip(index) {
            station.arc_length = arc_length.unwrap_or(station.arc_length);
            arc_length = Some(station.arc_length.plus(station.cell.length));
        }
    }

    /// Bounds of the cell that leaves a station, anew.
    pub fn bound(&mut self, index: usize, pace: &Pace<'_, S, N>) {
        let Some(bounds) = self.bounds(index, pace) else { return };
        if let Some(station) = self.stations.get_mut(index) {
            station.bounds = bounds;
        }
    }

    /// What they are.
    pub fn bounds(&self, index: usize, pace: &Pace<'_, S, N>) -> Option<Bounds<S>> {
        let (from, to) = self.pair(index)?;
        Some(Bounds::new(&from.node, &from.cell, &to.node, pace))
    }

    /// Forgets the stations before the one with this running number.
    #[inline(never)]
    pub fn release_before(&mut self, serial: NodeSerial) {
        // At most the whole window.
        for _ in 0..NODES {
            if !self.first.is_before(serial) || self.stations.len() <= 1 {
                return;
            }
            let passed = self.stations.pop_front().map(|station| Passed::of(&station.cell));
            self.passed.set(passed);
            self.first = self.first.next();
        }
    }

    /// Whether a block ends at station `i`; `None` if nothing leads there.
    #[inline(never)]
    pub fn ends_block(&self, i: usize) -> Option<bool> {
        let before = match i.checked_sub(1) {
            Some(before) => Passed::of(&self.stations.get(before)?.cell),
            None => *self.passed.as_ref()?,
        };
        let here = self.stations.get(i)?;
        let after = Passed::of(&here.cell);
        let last = i + 1 == self.len();
        // A long dwell is many cells.
        let dwells = before.dwells && after.dwells;
        Some((!last && before.tag != after.tag) || (here.rest && (last || !dwells)))
    }

    /// Whether cells take less than `limit`, s, in the plan that is being executed. Looks no further than it must: it is
    /// asked between any two steps of planning.
    pub fn takes_less(&self, cells: Range<usize>, limit: S) -> bool {
        let mut stations = self.stations.iter().skip(cells.start).take(cells.len() + 1);
        let Some(mut from) = stations.next() else { return true };
        let (mut time, mut speed) = (S::ZERO, from.agreed.b.sqrt());
        for to in stations {
            let faster = to.agreed.b.sqrt();
            time += from.agreed_time_between(to, [speed, faster]);
            if time >= limit {
                return false;
            }
            (from, speed) = (to, faster);
        }
        true
    }
}

impl<S: Scalar, const N: usize> Station<S, N> {
    /// The cell from this station to the next one, for its limits.
    pub fn view<'a>(&'a self, next: &'a Self, sets: LimitSets<'a, S, N>) -> View<'a, S, N> {
        let set = self.cell.programmed.limits;
        View {
            from: &self.node,
            cell: &self.cell,
            to: &next.node,
            bounds: self.bounds,
            limits: sets.of(set),
            leaves: set.differs(next.cell.programmed.limits),
            share: S::ONE,
            penalty: S::ZERO,
            led: true,
        }
    }

    /// What the cell from this station to the next one takes in the plan that is being executed, s; 0 if there is no motion
    /// over it.
    #[inline]
    pub fn agreed_time(&self, next: &Self) -> S {
        self.agreed_time_between(next, [self.agreed.b.sqrt(), next.agreed.b.sqrt()])
    }

    /// The same where the speeds at the two are known.
    #[inline]
    fn agreed_time_between(&self, next: &Self, speeds: [S; 2]) -> S {
        let Cell { length, dwell, .. } = self.cell;
        if length > S::ZERO {
            let fall = self.agreed.a - next.agreed.a;
            crossing(length, speeds, fall).map_or(S::ZERO, |[time, _]| time)
        } else {
            dwell
        }
    }

    /// Makes the cell end at a place where the agreed motion arrives after `time` seconds.
    pub fn lead_to(&mut self, end: &[Coord; N], arriving: PathState<S>, time: S) {
        if self.cell.straight {
            let chord: [S; N] = from_fn(|i| end[i].minus(self.node.at[i]));
            self.cell.length = dot(&chord, &self.node.tangent);
            self.cell.tangent_offset = [S::ZERO; N];
        } else {
            // The length that takes this time: then it is a part of the same quintic.
            self.cell.length = Law::length(self.agreed, arriving, time);
            self.cell.tangent_offset = self.node.tangent_offset_to(end, self.cell.length);
        }
    }

    /// How the path arrives at the next station. A node at rest holds the direction in which the
    /// motion goes on, which says nothing of the cell before: that is taken for an arc, as long
    /// as this one's curvature and chord make it.
    #[inline(never)]
    pub fn arrival(&self, next: &Self) -> Node<S, N> {
        let (here, cell) = (&self.node, &self.cell);
        if cell.straight {
            return Node { at: next.node.at, ..*here };
        }
        if !next.rest {
            return next.node;
        }
        let chord: [S; N] = from_fn(|i| here.tangent[i] * cell.length + cell.tangent_offset[i]);
        let per = S::of(2.0) / dot(&chord, &chord);
        let (along, across) =
            (dot(&here.tangent, &chord) * per, dot(&here.curvature, &chord) * per);
        Node {
            at: next.node.at,
            tangent: from_fn(|i| chord[i] * along - here.tangent[i]),
            curvature: from_fn(|i| here.curvature[i] - chord[i] * across),
        }
    }
}
