//! Switches a time before a place: where a plan is then.

use super::Planner;
use crate::number::{ArcLength, Scalar};
use crate::servo::link::{Branch, PlanSide};
use crate::servo::piece::Slot;
use crate::servo::switching::{EntrySerial, MOST_WAIT, ZONE, moved};

/// Says of an item whose place is not known that it is due a time before it.
pub const LEAD: u32 = MOST_WAIT;
/// Switches a time before a place that wait at once.
pub const TIMED: usize = 8;

/// A switch a time before a place.
#[derive(Clone, Copy, Debug)]
pub struct Timed<S> {
    pub line: usize,
    pub serial: EntrySerial,
    pub place: ArcLength,
    /// Not before here.
    pub floor: ArcLength,
    /// Time before, s.
    pub lead: S,
}

/// Where a plan is a time before a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Led {
    /// The place lies before the plan.
    Behind,
    /// The plan does not get to it.
    Beyond,
    /// Here.
    At(ArcLength),
    /// Here, where what is known of the motion begins, or before.
    From(ArcLength),
}

/// A place before `end`, but not before the motion has left a standstill: beyond what counts as the same place.
pub fn not_before(stand: ArcLength, place: ArcLength, end: ArcLength) -> ArcLength {
    let left = ArcLength::from_raw(stand.raw().wrapping_add(2 * ZONE));
    if !is_before(place, left) {
        place
    } else if is_before(left, end) {
        left
    } else {
        end
    }
}

/// Whether a place on the path lies before another.
pub fn is_before(place: ArcLength, other: ArcLength) -> bool {
    place.raw().wrapping_sub(other.raw()) < 0
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Whether another switch a time before a place may wait.
    pub(in crate::planner) fn has_room_for_lead(&mut self) -> bool {
        self.forget_done();
        let unplaced = self.switches.lines.iter().enumerate().map(|(i, written)| {
            let queue = self.side.board.lines.get(i);
            let items = written.unplaced().filter_map(|serial| queue?.read(serial));
            items.filter(|item| item.wait == LEAD).count()
        });
        unplaced.sum::<usize>() + self.switches.timed.len() < TIMED
    }

    /// Forgets the timed switches that have been carried out.
    pub(in crate::planner) fn forget_done(&mut self) {
        let board = self.side.board;
        self.switches.timed.retain(|timed| {
            board.lines.get(timed.line).is_some_and(|line| !line.is_done(timed.serial))
        });
    }

    /// Sets the place of a timed switch in a plan of so many pieces; `before`: if it lies before that plan.
    pub(in crate::planner) fn set_led(
        &self,
        timed: &Timed<S>,
        (plan, count): (usize, usize),
        branch: Option<Branch>,
        before: ArcLength,
    ) {
        let Some(queue) = self.side.board.lines.get(timed.line) else { return };
        let shift = self.side.board.shift(plan);
        let place =
            match self.side.led((plan, count), branch, moved(timed.place, shift), timed.lead) {
                Led::Behind => before,
                Led::Beyond => timed.place,
                Led::At(place) => {
                    not_before(timed.floor, moved(place, shift.wrapping_neg()), timed.place)
                }
                Led::From(place) => {
                    let place = moved(place, shift.wrapping_neg());
                    // What follows the setpoints may not have come to one that an earlier plan has run past.
                    let place = if is_before(before, place) { before } else { place };
                    not_before(timed.floor, place, timed.place)
                }
            };
        queue.set_place(timed.serial, plan, place);
    }

    /// Before a plan is offered whose pieces have been written: where the motion will be a time before the places that it passes.
    pub(in crate::planner) fn time_switches(&mut self, branch: Branch) {
        self.time_switches_behind(branch, 0);
    }

    /// The same for a plan in which what lies behind it comes later by `longer`, in units of arc lengths.
    pub(in crate::planner) fn time_switches_behind(&mut self, branch: Branch, longer: i64) {
        self.switches.branch = Some(branch);
        let (active, spare) = self.side.buffers();
        let board = self.side.board;
        if let Some(last) = self.horizon.window.last() {
            let end = self.switches.to.1;
            let shift = last.arc_length.raw().wrapping_sub(end.raw());
            board.set_shift(spare, shift.wrapping_add(longer));
        }
        if self.switches.timed.is_empty() {
            return;
        }
        self.forget_done();
        let written = (spare, self.side.written());
        for timed in &self.switches.timed {
            let Some(queue) = board.lines.get(timed.line) else { continue };
            self.set_led(timed, written, Some(branch), queue.place(timed.serial, active));
        }
    }
}

impl<S: Scalar, const N: usize> PlanSide<'_, S, N> {
    /// Where the motion of the first pieces of a plan buffer is `lead` s before it gets to a place. If it branches off the
    /// other one at a node, the pieces of that before the node come before.
    fn led(
        &self,
        (plan, count): (usize, usize),
        branch: Option<Branch>,
        place: ArcLength,
        lead: S,
    ) -> Led {
        let pieces = self.pieces(plan, count);
        let Some(first) = pieces.first() else { return Led::Beyond };
        if is_before(place, first.arc_length()) {
            return Led::Behind;
        }
        let ends = |i: usize| match pieces.get(i + 1) {
            Some(next) => next.arc_length(),
            None => pieces.get(i).map_or(place, |last| last.arc_length_at(last.time())),
        };
        // What sums of lengths round must not take the place beyond the rest at it.
        let near = ArcLength::from_raw(place.raw().wrapping_sub(ZONE));
        let rests = |i: usize| pieces.get(i + 1).is_none_or(Slot::stands);
        let gets_there = |&i: &usize| !is_before(ends(i), if rests(i) { near } else { place });
        let Some(at) = (0..pieces.len()).find(gets_there) else { return Led::Beyond };
        let Some(piece) = pieces.get(at) else { return Led::Beyond };
        let mut left = lead - piece.time_at(place);
        if !(left > S::ZERO) {
            return Led::At(piece.arc_length_at(-left));
        }
        let before = match branch {
            Some(Branch::Node(node)) => {
                let other = self.pieces(1 - plan, self.agreed());
                let end = other.iter().position(|piece| !piece.serial().is_before(node));
                other.get(..end.unwrap_or(other.len())).unwrap_or(&[])
            }
            _ => &[],
        };
        let earlier = before.iter().chain(pieces.iter().take(at)).rev();
        for piece in earlier {
            let time = piece.time();
            if left <= time {
                return Led::At(piece.arc_length_at(time - left));
            }
            left = left - time;
        }
        Led::From(before.first().unwrap_or(first).arc_length())
    }
}
