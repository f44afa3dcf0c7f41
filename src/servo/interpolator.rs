//! One setpoint per servo cycle.

use super::link::{ServoSide, Timeline};
use super::piece::{Piece, Sequel};
use super::setpoint::{Activity, Setpoint};
use crate::number::{Coord, Scalar};

/// Pieces that may begin within one servo cycle: each lasts at least a quarter of one.
const PIECES_PER_TICK: usize = 6;

/// The interrupt's handle: call [`Interpolator::tick`] once per servo cycle.
///
/// Work per tick: one piece evaluated, at most six begun; no waiting, no division, no root.
pub struct Interpolator<'a, S: Scalar, const N: usize> {
    side: ServoSide<'a, S, N>,
    cycle: S,
    piece: Option<Piece<S, N>>,
    /// Time by which the piece under way had begun at the end of the cycle that took it up, s.
    lag: S,
    /// Ticks since then.
    count: u32,
    /// Node at which the next piece starts.
    serial: u32,
    /// Setpoint while at rest.
    rest: Setpoint<S, N>,
}

impl<'a, S: Scalar, const N: usize> Interpolator<'a, S, N> {
    pub(crate) fn new(side: ServoSide<'a, S, N>, start: [Coord; N], cycle: S) -> Self {
        Self {
            side,
            cycle,
            piece: None,
            lag: S::ZERO,
            count: 0,
            serial: 0,
            rest: Setpoint {
                origin: start,
                offset: [S::ZERO; N],
                velocity: [S::ZERO; N],
                acceleration: [S::ZERO; N],
                path_origin: Coord::ZERO,
                path_offset: S::ZERO,
                path_speed: S::ZERO,
                tag: 0,
                activity: Activity::Idle,
            },
        }
    }

    /// Advances by one servo cycle and returns where the axes should be at its end.
    pub fn tick(&mut self) -> Setpoint<S, N> {
        let last = self.side.cycles();
        self.side.count_cycle();
        // A plan that branches off where the last cycle ended, or a start from rest: either way the
        // time of the new piece counts from there.
        if self.side.change_over(last) || self.piece.is_none() {
            self.begin(S::ZERO, last);
        }
        self.count = self.count.wrapping_add(1);
        for _ in 0..PIECES_PER_TICK {
            let Some(piece) = &self.piece else { return self.rest };
            let t = self.lag + S::from_u32(self.count) * self.cycle;
            if t < piece.time {
                return piece.at(t);
            }
            self.finish(t, last.wrapping_add(1));
        }
        // Never reached while pieces keep their least duration; a longer one would only be slow.
        match &self.piece {
            Some(piece) => piece.at(S::ZERO),
            None => self.rest,
        }
    }

    /// The piece under way is over at its own time `t`, in servo cycle `now`: on to the next one.
    fn finish(&mut self, t: S, now: u32) {
        let Some(piece) = self.piece.take() else { return };
        let over = t - piece.time;
        self.begin(over, now);
        if self.piece.is_none() {
            if piece.sequel == Sequel::Starved {
                self.side.count_starved();
            }
            let last = piece.at(piece.time);
            self.rest = Setpoint {
                velocity: [S::ZERO; N],
                acceleration: [S::ZERO; N],
                path_speed: S::ZERO,
                activity: Activity::Idle,
                ..last
            };
        }
    }

    /// Takes up the next piece, `over` seconds into it at the end of servo cycle `now`.
    fn begin(&mut self, over: S, now: u32) {
        self.piece = self.side.next(self.serial);
        if let Some(piece) = &self.piece {
            self.side.report(&Timeline { serial: piece.serial, began: now, lag: over });
            self.serial = piece.serial.wrapping_add(1);
        } else {
            self.side.report(&Timeline { serial: self.serial, began: now, lag: S::ZERO });
        }
        self.lag = over;
        self.count = 0;
    }
}
