//! Stations put into cells, and taken out again.

use super::Horizon;
use super::draft::{ADDED, Whole};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::path::hermite;
use crate::path::node::Cell;
use crate::profile::law::PathState;
use crate::profile::solver::Stretch;
use crate::profile::window::Station;

/// Where the distance from rest to a speed is cut, as shares of it: constant jerk covers the last in a quarter of the
/// time in which acceleration builds up.
const RAMP: [f64; 3] = [0.75, 0.125, 0.02];
/// A cell at a rest is cut only if the part there is at most this share of it.
const MOST_PART: f64 = 0.4;
/// A neighbour of a crawl is cut where it has gone on for so many times the length of the crawl, and again so many times farther.
const GROWTH: f64 = 4.0;
/// So often at a time.
const EASINGS: usize = 3;
/// Stations for which there must be room before that: fewer than a draft adds, but no draft should want for them.
const EASING_ROOM: usize = ADDED - 4;

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Puts a station behind the one at `i`, as a part of the draft; whether there was room.
    ///
    /// The cell of station `i` is still the whole one: it is to be shortened afterwards.
    pub(super) fn add(&mut self, i: usize, station: Station<S, N>) -> bool {
        let Some(Station { cell, .. }) = self.window.get(i) else { return false };
        let whole = Whole { length: cell.length, tangent_offset: cell.tangent_offset };
        if self.room_to_add() == 0 || !self.put_behind(i, station) {
            return false;
        }
        let serial = self.window.serial(i + 1);
        let noted =
            self.draft.as_mut().is_some_and(|draft| draft.added.push((serial, whole)).is_ok());
        debug_assert!(noted, "there was room to note it");
        noted
    }

    /// Keeps a station, which is about to be cut, for the case that the draft is dropped.
    pub(super) fn keep(&mut self, serial: NodeSerial, original: Station<S, N>) {
        debug_assert!(self.draft.as_ref().is_some_and(|draft| draft.replaced.is_none()));
        if let Some(draft) = self.draft.as_mut() {
            draft.replaced = Some((serial, original));
        }
    }

    /// Takes out again the stations that the draft has put in: all at once, since to move the window for each takes as long as to plan.
    pub fn take_back(&mut self) {
        let mut out = [false; NODES];
        while let Some(draft) = self.draft.as_mut()
            && let Some((serial, whole)) = draft.added.pop()
        {
            // Counted without those that were put in later.
            let i = self.window.clamped_index(serial);
            let mut kept = out.iter_mut().enumerate().filter(|(_, out)| !**out);
            let before = i.checked_sub(1).and_then(|before| kept.nth(before));
            let (Some((before, _)), Some((_, here))) = (before, kept.next()) else { continue };
            *here = true;
            if let Some(Station { cell, .. }) = self.window.get_mut(before) {
                (cell.length, cell.tangent_offset) = (whole.length, whole.tangent_offset);
            }
            self.end = self.end.previous();
        }
        self.window.remove(&out);
        let (mut next, mut joined) = (0, false);
        for out in out {
            if out && !joined {
                self.bound(next - 1);
            }
            (next, joined) = (next + usize::from(!out), out);
        }
    }

    /// Puts a station behind the one at `i`, for good; whether there was room.
    fn put_behind(&mut self, i: usize, station: Station<S, N>) -> bool {
        if !self.window.insert_after(i, station) {
            return false;
        }
        if !self.end.is_before(self.window.serial(i + 1)) {
            self.end = self.end.next();
        }
        true
    }

    /// The cell of station `i` cut at a share of its length: its first part, and a station with the
    /// other.
    fn parted(&self, i: usize, share: S) -> Option<(Cell<S, N>, Station<S, N>)> {
        let (station, after) = self.window.pair(i)?;
        let (first, node, cell) =
            hermite::split_at(&station.node, &station.cell, &station.arrival(after), share);
        let arc_length = station.arc_length.plus(first.length);
        Some((first, Station { node, cell, arc_length, rest: false, pause: false, ..*station }))
    }

    /// Makes `first` the cell of station `i`; it and the one behind are bounded anew.
    fn part(&mut self, i: usize, first: Cell<S, N>) {
        if let Some(station) = self.window.get_mut(i) {
            station.cell = first;
        }
        self.bound_halves(i);
    }

    /// Bounds the cell of station `i` and the next anew.
    pub(super) fn bound_halves(&mut self, i: usize) {
        self.bound(i);
        self.bound(i + 1);
    }

    /// Splits the cell of station `i` at a share of its length; nothing is known of the motion there.
    pub fn split_cell(&mut self, i: usize, share: S) -> bool {
        let Some((first, cut)) = self.parted(i, share) else { return false };
        let done =
            self.put_behind(i, Station { state: PathState::REST, agreed: PathState::REST, ..cut });
        if done {
            self.part(i, first);
        }
        done
    }

    /// A cell from a rest inside a block to the next rest needs a node between.
    pub fn split_lone(&mut self, stretch: &mut Stretch) {
        let Some((station, after)) = self.window.pair(stretch.first) else { return };
        let starts = station.rest || self.window.serial(stretch.first) == self.end;
        let ends = after.rest || (!stretch.open && stretch.first + 1 == stretch.last);
        if starts
            && ends
            && station.cell.length > S::ZERO
            && self.split_cell(stretch.first, S::of(0.5))
        {
            stretch.last += 1;
        }
    }

    /// Splits cells at rests, from station `new` on, that are much longer than the distance to the speed that is
    /// asked for now: over the whole of one the motion would gather speed, or lose it.
    pub fn split_ramps(&mut self, stretch: &mut Stretch, new: usize) {
        let mut i = new;
        for _ in 0..NODES {
            let Some((station, after)) = self.window.pair(i).filter(|_| i < stretch.last) else {
                return;
            };
            let starts = station.rest || i == stretch.first;
            let ends = after.rest || (!stretch.open && i + 1 == stretch.last);
            if (starts || ends) && station.cell.length > S::ZERO {
                let (ramp, apart) = (self.ramp(i, S::ZERO), self.apart(station.bounds.jerk));
                for share in RAMP {
                    let Some(length) = self.window.get(i).map(|station| station.cell.length) else {
                        return;
                    };
                    let part = (ramp * S::of(share)).greatest(apart) / length;
                    if part > S::of(MOST_PART) {
                        continue;
                    }
                    let place = if starts { part } else { S::ONE - part };
                    if self.window.room() + RAMP.len() <= ADDED || !self.split_cell(i, place) {
                        return;
                    }
                    stretch.last += 1;
                    i += usize::from(!starts);
                }
            }
            i += 1;
        }
    }

    /// Whether the crawl through the cell of station `crawl` of a stretch that starts from rest can be eased: a neighbour is much
    /// longer than it, and there is room to cut that.
    ///
    /// Where a hold has come to rest just before the end of a cell, what is left of it may be a thousandth of the next. A guess leads to
    /// no motion there, and slow states are hardly improved: they gather no speed over the first, and the next takes all of the speed
    /// to its end.
    pub fn eases_crawl(&self, stretch: Stretch, crawl: usize) -> bool {
        self.easing(stretch, crawl).is_some()
    }

    /// Cuts the longer neighbour of a crawl, in lengths that grow away from it. They are cut for good, and every cut takes room that
    /// only motion gives back: it is not done for ever.
    pub fn ease_crawl(&mut self, stretch: Stretch, crawl: usize) {
        let Some((mut i, behind)) = self.easing(stretch, crawl) else { return };
        let Some(mut part) = self.window.get(crawl).map(|station| station.cell.length) else {
            return;
        };
        for _ in 0..EASINGS {
            let Some(length) = self.window.get(i).map(|station| station.cell.length) else {
                return;
            };
            part = part * S::of(GROWTH);
            let share = part / length;
            let place = if behind { share } else { S::ONE - share };
            if share > S::of(MOST_PART)
                || self.window.room() <= EASING_ROOM
                || !self.split_cell(i, place)
            {
                return;
            }
            i += usize::from(behind);
        }
    }

    /// The cell beside a crawl that is to be cut, and whether it lies behind it.
    fn easing(&self, stretch: Stretch, crawl: usize) -> Option<(usize, bool)> {
        let length = |i: usize| self.window.get(i).map_or(S::ZERO, |station| station.cell.length);
        let least = length(crawl) * S::of(GROWTH / MOST_PART);
        let before = crawl.checked_sub(1).filter(|i| *i >= stretch.first && length(*i) > least);
        let behind = (crawl + 1 < stretch.last && length(crawl + 1) > least).then_some(crawl + 1);
        let (i, is_behind) = match (before, behind) {
            (Some(before), Some(behind)) if length(before) > length(behind) => (before, false),
            (_, Some(behind)) => (behind, true),
            (Some(before), None) => (before, false),
            (None, None) => return None,
        };
        (self.window.room() > EASING_ROOM).then_some((i, is_behind))
    }

    /// Whether the last cell starts at rest and ends where the window does: from rest to rest in a
    /// single cell there is no motion, so it must wait for the next.
    pub fn is_lone_start(&self, Stretch { first, last, .. }: Stretch) -> bool {
        let Some((station, after)) = last.checked_sub(1).and_then(|i| self.window.pair(i)) else {
            return false;
        };
        (station.rest || first + 1 == last) && !after.rest && station.cell.length > S::ZERO
    }

    /// Stations that one answer may still add.
    pub fn room_to_add(&self) -> usize {
        let added = self.draft.as_ref().map_or(ADDED, |draft| draft.added.len());
        (ADDED - added).min(self.window.room())
    }
}
