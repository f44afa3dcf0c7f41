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
        debug_assert!(self.piece.is_none(), "pieces shorter than their least duration");
        // Never reached while pieces keep it; shorter ones would only be slow.
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

// Of one context; `models.rs` has those of several.
#[cfg(all(test, not(loom)))]
mod tests {
    use super::super::link::{Branch, Link, Origin, PlanSide};
    use super::super::piece::{Piece, Sequel};
    use super::*;
    use crate::number::ArcLength;
    use std::vec::Vec;

    type Core = Link<f64, 1, 4, 8>;

    /// Both ends, at a servo cycle of 1 s.
    fn ends(link: &mut Core, origin: Origin) -> (PlanSide<'_, f64, 1>, Interpolator<'_, f64, 1>) {
        let (plan, servo, _) = link.ends(origin);
        (plan, Interpolator::new(servo, (origin.node, [Coord::ZERO]), 1.0))
    }

    /// A piece at a velocity that is its tag, for a time.
    fn piece(serial: NodeSerial, tag: u32, time: f64, sequel: Sequel) -> Piece<f64, 1> {
        let speed = f64::from(tag);
        Piece {
            serial,
            tag,
            time,
            origin: [Coord::ZERO],
            axes: [[speed, 0.0, 0.0, 0.0, 0.0]],
            arc_length: ArcLength::ZERO,
            path: [speed, 0.0, 0.0, 0.0],
            sequel,
            event: false,
        }
    }

    fn tags(interpolator: &mut Interpolator<'_, f64, 1>, cycles: usize) -> Vec<(u32, Activity)> {
        (0..cycles).map(|_| interpolator.tick()).map(|at| (at.tag, at.activity)).collect()
    }

    const IDLE: Activity = Activity::Idle;
    const RUNS: Activity = Activity::Running;

    #[test]
    fn nothing_offered_is_a_rest_where_it_started() {
        let mut link = Core::new();
        let (plan, mut interpolator) = ends(&mut link, Origin::ZERO);
        assert_eq!(tags(&mut interpolator, 3), [(0, IDLE); 3]);
        assert_eq!((plan.cycles().raw(), plan.starved()), (3, 0));
    }

    /// The running numbers of nodes, cycles and plans may wrap in the midst of it.
    #[test]
    fn a_plan_takes_over_at_its_node_and_ends_at_rest() {
        let last = Origin {
            node: NodeSerial::from_raw(u32::MAX),
            cycle: CycleSerial::from_raw(u32::MAX - 1),
            plan: u32::MAX >> 2,
        };
        for origin in [Origin::ZERO, last] {
            let mut link = Core::new();
            let (mut plan, mut interpolator) = ends(&mut link, origin);
            let node = origin.node;
            plan.write(&piece(node, 1, 2.5, Sequel::Motion));
            plan.write(&piece(node.next(), 2, 2.5, Sequel::Starved));
            plan.offer(Branch::Node(node));
            assert_eq!(plan.verdict(), None);
            assert_eq!(tags(&mut interpolator, 2), [(1, RUNS); 2]);
            assert_eq!(plan.verdict(), Some(true));
            // A longer one from the node ahead.
            plan.write(&piece(node.next(), 3, 1.0, Sequel::Stop));
            plan.offer(Branch::Node(node.next()));
            assert_eq!(tags(&mut interpolator, 3), [(3, RUNS), (3, IDLE), (3, IDLE)]);
            assert_eq!((plan.verdict(), plan.starved()), (Some(true), 0));
            assert_eq!(plan.progress(), node.plus(2));
            assert_eq!(plan.cycles(), origin.cycle.plus(5));
        }
    }

    #[test]
    fn a_plan_that_comes_too_late_is_refused_and_the_one_before_ends() {
        let mut link = Core::new();
        let (mut plan, mut interpolator) = ends(&mut link, Origin::ZERO);
        plan.write(&piece(NodeSerial::ZERO, 1, 3.5, Sequel::Starved));
        plan.offer(Branch::Node(NodeSerial::ZERO));
        tags(&mut interpolator, 2);
        assert_eq!(plan.verdict(), Some(true));
        plan.write(&piece(NodeSerial::ZERO.next(), 2, 1.0, Sequel::Stop));
        plan.offer(Branch::Cycle(CycleSerial::from_raw(1)));
        assert_eq!(tags(&mut interpolator, 3), [(1, RUNS), (1, IDLE), (1, IDLE)]);
        assert_eq!((plan.verdict(), plan.starved()), (Some(false), 1));
    }

    #[test]
    fn an_answer_takes_over_at_its_servo_cycle() {
        let mut link = Core::new();
        let (mut plan, mut interpolator) = ends(&mut link, Origin::ZERO);
        plan.write(&piece(NodeSerial::ZERO, 1, 10.0, Sequel::Stop));
        plan.offer(Branch::Node(NodeSerial::ZERO));
        tags(&mut interpolator, 1);
        assert_eq!(plan.verdict(), Some(true));
        plan.write(&piece(NodeSerial::ZERO.next(), 2, 5.0, Sequel::Stop));
        plan.offer(Branch::Cycle(CycleSerial::from_raw(3)));
        assert_eq!(tags(&mut interpolator, 3), [(1, RUNS), (1, RUNS), (2, RUNS)]);
        assert_eq!(plan.verdict(), Some(true));
        let timeline = plan.timeline().unwrap();
        assert_eq!((timeline.serial.raw(), timeline.began.raw(), timeline.lag), (1, 3, 0.0));
    }

    #[test]
    fn what_is_withdrawn_is_never_run() {
        let mut link = Core::new();
        let (mut plan, mut interpolator) = ends(&mut link, Origin::ZERO);
        plan.write(&piece(NodeSerial::ZERO, 1, 2.0, Sequel::Stop));
        plan.offer(Branch::Node(NodeSerial::ZERO));
        plan.withdraw();
        assert_eq!(plan.verdict(), Some(false));
        assert_eq!(tags(&mut interpolator, 2), [(0, IDLE); 2]);
        // Too late for that.
        plan.write(&piece(NodeSerial::ZERO, 2, 2.0, Sequel::Stop));
        plan.offer(Branch::Node(NodeSerial::ZERO));
        tags(&mut interpolator, 1);
        plan.withdraw();
        assert_eq!(plan.verdict(), Some(true));
    }

    #[test]
    fn an_event_is_reported_in_one_servo_cycle_and_a_standstill_is_a_dwell() {
        let mut link = Core::new();
        let (mut plan, mut interpolator) = ends(&mut link, Origin::ZERO);
        let dwell = Piece {
            path: [0.0; 4],
            axes: [[0.0; 5]],
            ..piece(NodeSerial::ZERO, 7, 3.5, Sequel::Stop)
        };
        plan.write(&Piece { event: true, ..dwell });
        plan.offer(Branch::Node(NodeSerial::ZERO));
        let dwells = (7, Activity::Dwelling);
        assert_eq!(tags(&mut interpolator, 4), [(7, Activity::Event), dwells, dwells, (7, IDLE)]);
    }
}
