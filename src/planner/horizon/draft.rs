//! A plan in the making: what it has changed in the horizon, kept as a whole or taken back as a whole.
//!
//! ```text
//!             begin_draft                    mark_offered          commit
//!   (none) ───────────────▶ Stage::Making ───────────────▶ Stage::Offered ──────▶ (none), agreed
//!      ▲                         │ dropped, found nothing         │ refused, withdrawn
//!      └─────────────────────────┴──────── drop_draft ◀───────────┘
//! ```
//!
//! [`Horizon::begin_draft`] is the only way to begin one and [`Horizon::drop_draft`] the only way back, so nothing that makes a plan
//! has to clean up after itself. A draft changes the states of stations, puts stations in, cuts the cell under
//! way and may change the overrides. Its stage and all that it has changed lie in the horizon, not on the stack: it outlasts
//! a call.
//!
//! What is not part of a draft: cells split because a motion could not start or end in them
//! ([`parting`](super::parting)), which serve every plan, and the speed bounds of planned cells, which every draft
//! sets for itself ([`Horizon::loosen`]).

use super::{Handover, Horizon};
use crate::number::Scalar;
use crate::number::serial::NodeSerial;
use crate::number::vector::Vector;
use crate::profile::law::PathState;
use crate::profile::window::Station;
use crate::servo::control::Overrides;

/// Most stations that one draft adds to the window.
pub const ADDED: usize = 12;

/// How far a draft has got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// States are being looked for.
    Making,
    /// It is finished, and the interrupt has yet to decide on it.
    Offered,
}

/// What a plan in the making has changed.
#[derive(Clone, Debug)]
pub struct Draft<S, const N: usize> {
    stage: Stage,
    /// Overrides that were in effect before.
    overrides: Overrides,
    eased: Option<NodeSerial>,
    /// The station whose cell was under way, as it was, with its running number.
    pub replaced: Option<(NodeSerial, Station<S, N>)>,
    /// Up to where it is run by a clock that slows down, and where that may be taken further.
    slows: Option<(NodeSerial, Handover<S>)>,
    /// Stations put in, in order: running number, and the cell that each was put into.
    pub added: heapless::Vec<(NodeSerial, Whole<S, N>), ADDED>,
}

/// What a station that is put into a cell changes of it.
#[derive(Clone, Copy, Debug)]
pub struct Whole<S, const N: usize> {
    pub length: S,
    pub tangent_offset: Vector<S, N>,
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// Begins a draft: everything is as agreed, and what is changed from now on can be taken back.
    #[inline(never)]
    pub fn begin_draft(&mut self) {
        debug_assert!(!self.has_draft(), "one plan at a time");
        debug_assert!(self.is_as_agreed());
        self.draft.set(Some(Draft {
            stage: Stage::Making,
            overrides: self.overrides,
            eased: self.eased,
            replaced: None,
            slows: None,
            added: heapless::Vec::new(),
        }));
    }

    /// Makes a draft at once. If it comes to nothing, everything is as it was.
    pub fn draft<T>(&mut self, make: impl FnOnce(&mut Self) -> Option<T>) -> Option<T> {
        self.begin_draft();
        let made = make(self);
        if made.is_none() {
            self.drop_draft();
        }
        made
    }

    /// Whether a plan is being made or is on offer.
    pub fn has_draft(&self) -> bool {
        self.draft.is_some()
    }

    /// The draft is finished.
    pub fn mark_offered(&mut self) {
        debug_assert!(self.has_draft());
        if let Some(draft) = self.draft.as_mut() {
            draft.stage = Stage::Offered;
        }
    }

    /// The draft is run by a clock that slows down up to a node.
    pub fn mark_slowing(&mut self, until: NodeSerial, handover: Handover<S>) {
        if let Some(draft) = self.draft.as_mut() {
            draft.slows = Some((until, handover));
        }
    }

    /// The draft answers to overrides in part only, up to station `i`.
    pub fn mark_eased(&mut self, i: usize) {
        debug_assert!(self.has_draft());
        self.eased = Some(self.window.serial(i));
    }

    /// The first station from one on behind all that the draft has put in, from which the agreed motion is run by no clock of its own; and
    /// how many stations it has put in.
    pub fn whole_from(&self, i: usize) -> (usize, u32) {
        let Some(Draft { added, .. }) = self.draft.as_ref() else { return (i, 0) };
        let count = added.len() as u32;
        let even = self.slowed.map_or(0, |node| self.window.clamped_index(node.plus(count)));
        let mut first = i.max(even);
        // Those put in later, before it, are not in its number.
        for (later, (serial, _)) in added.iter().rev().enumerate() {
            first = first.max(self.window.clamped_index(*serial) + later + 1);
        }
        (first, count)
    }

    /// Makes the draft, which starts at node `first` and ends at node `end`, the agreed plan.
    pub fn commit(&mut self, first: NodeSerial, end: NodeSerial) {
        debug_assert!(self.draft.as_ref().is_some_and(|draft| draft.stage == Stage::Offered));
        let slows = self.draft.as_ref().and_then(|draft| draft.slows);
        self.slowed = slows.map(|(until, _)| until);
        if let Some((_, handover)) = slows {
            self.handover = handover;
        }
        // A cell that was cut where the motion left it begins there: arc lengths do not go on from the stations before it, which are passed.
        let replaced = self.draft.as_ref().and_then(|draft| draft.replaced.as_ref());
        if let Some((cut, _)) = replaced {
            self.window.release_before(*cut);
        }
        self.draft.set(None);
        self.end = end;
        // The part of the window before is the same in both plans.
        for i in self.window.clamped_index(first)..self.window.len() {
            if let Some(station) = self.window.get_mut(i) {
                station.agreed = station.state;
            }
        }
        debug_assert!(self.is_as_agreed());
    }

    /// Takes back all that the draft has changed: window and overrides are those of the agreed plan.
    // Once in the image, however often it is called.
    #[inline(never)]
    pub fn drop_draft(&mut self) {
        debug_assert!(self.has_draft());
        self.take_back();
        let Some(Draft { overrides, eased, replaced, .. }) = self.draft.as_ref() else { return };
        let paced = self.overrides == *overrides;
        (self.overrides, self.eased) = (*overrides, *eased);
        if let Some((serial, original)) = replaced {
            let i = self.window.clamped_index(*serial);
            if let Some(station) = self.window.get_mut(i) {
                *station = *original;
            }
        }
        self.draft.set(None);
        // Up to the end of a plan that is run by a clock of its own, what its pieces say is what was measured.
        self.window.measure(self.slowed.map_or(0, |end| self.window.clamped_index(end)));
        let last = self.end_index();
        for i in 0..self.window.len() {
            if let Some(station) = self.window.get_mut(i) {
                station.state = if i <= last { station.agreed } else { PathState::REST };
            }
        }
        if !paced {
            self.bound_from(0);
        }
    }

    /// Takes back the overrides that the draft has tried, but for the bounds of cells.
    pub fn keep_overrides(&mut self) {
        let Some(draft) = self.draft.as_ref() else { return };
        if self.overrides != draft.overrides {
            self.overrides = draft.overrides;
            self.bound_from(0);
        }
    }

    /// Whether the states are those of the agreed plan, with a rest behind its end.
    fn is_as_agreed(&self) -> bool {
        let last = self.end_index();
        (0..self.window.len()).all(|i| {
            self.window.get(i).is_some_and(|station| {
                station.state == if i <= last { station.agreed } else { PathState::REST }
            })
        })
    }
}
