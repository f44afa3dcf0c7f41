//! One setpoint per servo cycle.

use super::link::{Ahead, ServoSide, Timeline};
use super::piece::Slot;
use super::setpoint::{Activity, Setpoint};
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::{Coord, Scalar};

/// Pieces that may begin within one servo cycle: each lasts at least a quarter of one.
const PIECES_PER_TICK: usize = 6;

/// The interrupt's handle: call [`Interpolator::tick`] once per servo cycle.
///
/// Work per tick: one piece evaluated where it lies, at most six begun; no waiting, no division, no
/// root. `docs/target.md` has the number of instructions.
pub struct Interpolator<'a, S: Scalar, const N: usize> {
    side: ServoSide<'a, S, N>,
    cycle: S,
    /// The piece under way, in the plan that was handed over.
    piece: Option<&'a Slot<S, N>>,
    /// Its duration, s.
    time: S,
    /// Time by which the piece under way had begun at the end of the cycle that took it up, s.
    lag: S,
    /// Ticks since then.
    count: u32,
    /// Whether the piece under way has an event that has not been reported.
    event: bool,
    /// Node at which the next piece starts.
    serial: NodeSerial,
    /// Setpoint while at rest.
    rest: Setpoint<S, N>,
}

impl<'a, S: Scalar, const N: usize> Interpolator<'a, S, N> {
    pub(crate) fn new(
        side: ServoSide<'a, S, N>,
        (node, start): (NodeSerial, [Coord; N]),
        cycle: S,
    ) -> Self {
        Self {
            side,
            cycle,
            piece: None,
            time: S::ZERO,
            lag: S::ZERO,
            count: 0,
            event: false,
            serial: node,
            rest: Setpoint { origin: start, ..Setpoint::REST },
        }
    }

    /// Advances by one servo cycle and returns where the axes should be at its end.
    pub fn tick(&mut self) -> Setpoint<S, N> {
        let last = self.side.cycles();
        self.side.count_cycle();
        // A plan that branches off where the last cycle ended, or a start from rest: either way the
        // time of the new piece counts from there.
        if self.side.change_over(last) || self.piece.is_none() {
            let ahead = self.side.ahead(self.serial);
            self.begin(ahead, S::ZERO, last);
        }
        self.count = self.count.wrapping_add(1);
        let mut t = self.lag + S::from_u32(self.count) * self.cycle;
        for _ in 0..PIECES_PER_TICK {
            let Some(piece) = self.piece else { return self.rest };
            if t < self.time {
                if self.event {
                    return self.report_event(piece);
                }
                return piece.at(t);
            }
            // On to the next one, `t` seconds into it.
            let ahead = self.side.ahead(self.serial);
            if ahead.may_rest {
                // Now: the planner may write over it as soon as a new plan is taken.
                self.rest(piece);
            }
            let starves = piece.starves();
            t = t - self.time;
            self.begin(ahead, t, last.next());
            if self.piece.is_none() && starves {
                self.side.count_starved();
            }
        }
        // Never reached while pieces keep their least duration; a longer one would only be slow.
        self.piece.map_or(self.rest, |piece| piece.at(S::ZERO))
    }

    /// The setpoint at the beginning of an event, once.
    #[cold]
    fn report_event(&mut self, piece: &Slot<S, N>) -> Setpoint<S, N> {
        self.event = false;
        Setpoint { activity: Activity::Event, ..piece.at(S::ZERO) }
    }

    /// Notes where the motion rests if nothing follows the piece.
    #[cold]
    fn rest(&mut self, piece: &Slot<S, N>) {
        let last = piece.at(self.time);
        let Setpoint { origin, offset, path_origin, path_offset, tag, .. } = last;
        self.rest = Setpoint { origin, offset, path_origin, path_offset, tag, ..Setpoint::REST };
    }

    /// Takes up the next piece, `over` seconds into it at the end of servo cycle `now`.
    fn begin(&mut self, ahead: Ahead, over: S, now: CycleSerial) {
        self.piece = self.side.next(ahead);
        self.lag = over;
        self.count = 0;
        if let Some(piece) = self.piece {
            let serial = piece.serial();
            self.time = piece.time();
            self.event = piece.has_event();
            self.side.report(&Timeline { serial, began: now, lag: over });
            self.serial = serial.next();
        } else {
            self.side.report(&Timeline { serial: self.serial, began: now, lag: S::ZERO });
        }
    }
}
