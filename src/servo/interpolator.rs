//! One setpoint per servo cycle.

use super::link::{ServoSide, Timeline};
use super::piece::Slot;
use super::setpoint::{Place, Setpoint};
#[cfg(feature = "outputs")]
use super::switcher::{Switched, Switcher};
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::{Coord, Scalar};

/// The interrupt's handle: call [`Interpolator::tick`] once per servo cycle.
///
/// Work per tick: one piece evaluated where it lies, a few begun, no waiting, no division, no root. `docs/target.md` has the number of instructions, seen and proved.
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
    /// Whether there is a piece under way, and no event: what that takes is a part of a rest.
    moves: bool,
    /// Node at which the next piece starts.
    serial: NodeSerial,
    /// Where the motion rests if nothing follows.
    rest: Place<S, N>,
    #[cfg(feature = "outputs")]
    switcher: Switcher<'a, S>,
}

/// Pieces of a plan that may begin within one servo cycle: each lasts a quarter of one, but for its rounding.
const PIECES_PER_TICK: usize = 5;
/// That, in servo cycles; a shorter one would be run with what rounding makes of it, too.
const LEAST_PIECE: f64 = 0.24;
/// Pieces of the plan under way that may begin in the servo cycle in which another branches off: behind more, which are
/// short, the other is refused in the next cycle, as one that comes too late.
const BEFORE_BRANCH: usize = 2;

/// How far into a piece the end of servo cycle `began` is.
#[derive(Clone, Copy)]
struct Entry<S> {
    began: CycleSerial,
    lag: S,
    /// Servo cycles since then.
    count: u32,
}

impl<'a, S: Scalar, const N: usize> Interpolator<'a, S, N> {
    pub(crate) fn new(
        side: ServoSide<'a, S, N>,
        (node, start): (NodeSerial, [Coord; N]),
        cycle: S,
    ) -> Self {
        Self {
            #[cfg(feature = "outputs")]
            switcher: Switcher::new(side.board),
            side,
            cycle,
            piece: None,
            time: S::ZERO,
            lag: S::ZERO,
            count: 0,
            event: false,
            moves: false,
            serial: node,
            rest: Place { origin: start, ..Place::ZERO },
        }
    }

    /// Advances by one servo cycle and returns where the axes should be at its end.
    pub fn tick(&mut self) -> Setpoint<S, N> {
        let last = self.side.cycles();
        self.side.count_cycle();
        let changes = self.side.change_over(last, self.serial);
        match self.piece {
            Some(piece) if !changes => {
                self.count = self.count.wrapping_add(1);
                let t = self.lag + S::from_u32(self.count) * self.cycle;
                if t < self.time { self.show(piece, t) } else { self.leave(piece, t, last.next()) }
            }
            // The time of a plan that branches off where the last cycle ended, and of a start from rest, counts from there.
            _ => self.start(last),
        }
    }

    /// Outputs in time with the path (feature `outputs`): to be called once after every tick, with its setpoint, or with what
    /// `Shaper::shape` (feature `shaping`) has made of it: outputs switch where that is. Tells `sink` what has switched within the
    /// servo cycle, of each output in order, at most four times; returns the power at its end.
    ///
    /// Work: without anything to come, a comparison; else one comparison per output, and what switches takes a
    /// root and a division. `docs/target.md` has the number of instructions.
    #[cfg(feature = "outputs")]
    pub fn switch(&mut self, at: &Setpoint<S, N>, mut sink: impl FnMut(Switched<S>)) -> S {
        self.switcher.tick(at, (self.side.active(), self.cycle), &mut sink)
    }

    // All that follow end with the setpoint, so that none is copied.

    #[inline]
    fn show(&mut self, piece: &'a Slot<S, N>, t: S) -> Setpoint<S, N> {
        // The setpoint at the beginning of an event, once.
        let event = core::mem::take(&mut self.event);
        piece.at(if event { S::ZERO } else { t }, event)
    }

    /// From the node at which the motion is to the end of the servo cycle after `last`.
    #[inline(never)]
    fn start(&mut self, last: CycleSerial) -> Setpoint<S, N> {
        if let Some(offer) = self.side.ahead(self.serial).at(self.serial) {
            self.side.take(offer);
        }
        #[cfg(debug_assertions)]
        self.goes_on(
            self.piece.map(|piece| (piece, self.lag + S::from_u32(self.count) * self.cycle)),
            self.side.following(1).first(),
        );
        self.enter(false, self.cycle, Entry { began: last, lag: S::ZERO, count: 1 })
    }

    /// From a piece that has ended to the one that is under way at the end of servo cycle `now`, `t` seconds from its
    /// beginning.
    #[inline(never)]
    fn leave(&mut self, piece: &'a Slot<S, N>, t: S, now: CycleSerial) -> Setpoint<S, N> {
        let ahead = self.side.ahead(self.serial);
        let following = self.side.following(ahead.pieces);
        let (piece, t, passed) = self.walk::<BEFORE_BRANCH>(piece, t, following);
        self.side.pass(passed);
        let entry = Entry { began: now, lag: t, count: 0 };
        if t < self.time {
            return self.report(piece, t, entry);
        }
        self.serial = piece.serial().next();
        let starves = piece.starves();
        // The end of a piece within a cell is no node.
        let offer = ahead.at(self.serial).filter(|_| !piece.is_within());
        // Now: the planner may write over it as soon as a new plan is taken.
        if self.side.may_end(offer) {
            piece.place(self.time, &mut self.rest);
        }
        if let Some(offer) = offer {
            self.side.take(offer);
        }
        #[cfg(debug_assertions)]
        self.goes_on(Some((piece, self.time)), self.side.following(1).first());
        let t = t - self.time;
        self.enter(starves, t, Entry { lag: t, ..entry })
    }

    /// Into the next piece of the plan, whose beginning is `t` seconds before the end of the servo cycle. `starves`: what
    /// it means if there is none.
    #[inline(never)]
    fn enter(&mut self, starves: bool, t: S, entry: Entry<S>) -> Setpoint<S, N> {
        let following = self.side.following(usize::MAX);
        let Some((first, following)) = following.split_first() else {
            return self.stop(starves, entry.began);
        };
        self.time = first.time();
        debug_assert!(self.lasts(self.time), "a piece of less than its least duration");
        if t < self.time {
            self.side.pass(1);
            return self.report(first, t, entry);
        }
        let now = self.side.cycles();
        let (piece, t, passed) = self.walk::<{ PIECES_PER_TICK - 1 }>(first, t, following);
        self.side.pass(1 + passed);
        if t < self.time || self.side.lasts() {
            return self.report(piece, t, Entry { began: now, lag: t, count: 0 });
        }
        self.serial = piece.serial().next();
        piece.place(self.time, &mut self.rest);
        self.stop(piece.starves(), now)
    }

    /// On from a piece that ends before the servo cycle does, over `MOST` more at most. Returns also how many they were.
    // Its loop is unrolled by the compiler: the bound of a tick (see `docs/target.md`) knows none.
    #[inline]
    fn walk<const MOST: usize>(
        &mut self,
        mut piece: &'a Slot<S, N>,
        mut t: S,
        following: &'a [Slot<S, N>],
    ) -> (&'a Slot<S, N>, S, usize) {
        let mut time = self.time;
        let mut passed = 0;
        let mut following = following.iter();
        for _ in 0..MOST {
            let Some(next) = following.next() else { break };
            #[cfg(debug_assertions)]
            self.goes_on(Some((piece, time)), Some(next));
            t = t - time;
            time = next.time();
            debug_assert!(self.lasts(time), "a piece of less than its least duration");
            piece = next;
            passed += 1;
            if t < time {
                break;
            }
        }
        self.time = time;
        (piece, t, passed)
    }

    /// Whether that is as long as a piece is at least, but for its rounding.
    fn lasts(&self, time: S) -> bool {
        time >= self.cycle * S::of(LEAST_PIECE)
    }

    /// The next piece goes on from a time of the one before, s, or from rest if there is none.
    #[cfg(debug_assertions)]
    fn goes_on(&self, before: Option<(&Slot<S, N>, S)>, next: Option<&Slot<S, N>>) {
        if let (Some(leap), Some(next)) = (self.side.leap(), next) {
            assert!(next.follows(before, leap), "a piece begins as none ends");
        }
    }

    /// A piece is under way.
    fn report(&mut self, piece: &'a Slot<S, N>, t: S, entry: Entry<S>) -> Setpoint<S, N> {
        let serial = piece.serial();
        self.serial = serial.next();
        self.piece = Some(piece);
        self.event = piece.has_event();
        self.moves = !self.event;
        if self.event {
            self.side.rest();
        }
        Entry { lag: self.lag, count: self.count, .. } = entry;
        self.side.report(&Timeline { serial, began: entry.began, lag: entry.lag });
        debug_assert!(t < self.time, "pieces shorter than their least duration");
        self.show(piece, t)
    }

    /// Nothing follows.
    fn stop(&mut self, starves: bool, now: CycleSerial) -> Setpoint<S, N> {
        self.piece = None;
        if core::mem::take(&mut self.moves) {
            self.side.rest();
        }
        if starves {
            self.side.count_starved();
        }
        self.side.report(&Timeline { serial: self.serial, began: now, lag: S::ZERO });
        self.rest.setpoint()
    }
}

// Of one context; `models.rs` has those of several.
#[cfg(all(test, not(loom)))]
mod tests {
    use super::super::link::{Branch, Channel, Origin, PlanSide};
    use super::super::piece::{Piece, Sequel};
    use super::super::setpoint::Activity;
    use super::*;
    use crate::number::ArcLength;
    use std::vec::Vec;

    type Core = Channel<f64, 1, 8>;

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

    /// Whoever works in the room for the next plan leaves the one under way alone, whatever has become of the last offer.
    #[test]
    fn what_is_kept_in_the_room_for_a_plan_is_never_run() {
        let scribble = |plan: &PlanSide<'_, f64, 1>| {
            for slot in plan.room().slots {
                slot.keep_four([f64::NAN; 4]);
                slot.keep_five([f64::NAN; 5]);
                slot.keep_two([f64::NAN; 2]);
            }
        };
        let mut link = Core::new();
        let (mut plan, mut interpolator) = ends(&mut link, Origin::ZERO);
        let node = NodeSerial::ZERO;
        scribble(&plan);
        plan.write(&piece(node, 1, 4.5, Sequel::Motion));
        plan.write(&piece(node.next(), 2, 2.5, Sequel::Stop));
        plan.offer(Branch::Node(node));
        let mut run = |cycles: u32, tag: u32| {
            for at in (0..cycles).map(|_| interpolator.tick()) {
                assert_eq!((at.tag, at.velocity), (tag, [f64::from(tag)]));
            }
        };
        run(1, 1);
        assert_eq!(plan.verdict(), Some(true));
        let number = plan.room().number;
        scribble(&plan);
        run(1, 1);
        // Written and not offered.
        plan.write(&piece(node.next(), 3, 1.0, Sequel::Stop));
        plan.discard();
        scribble(&plan);
        run(1, 1);
        // Withdrawn.
        plan.write(&piece(node.next(), 3, 1.0, Sequel::Stop));
        plan.offer(Branch::Node(node.next()));
        plan.withdraw();
        assert_eq!(plan.verdict(), Some(false));
        assert_ne!(plan.room().number, number);
        scribble(&plan);
        run(1, 1);
        // Taken: the room is where the first plan was.
        plan.write(&piece(node.next(), 3, 2.5, Sequel::Stop));
        plan.offer(Branch::Node(node.next()));
        run(1, 3);
        assert_eq!(plan.verdict(), Some(true));
        scribble(&plan);
        run(1, 3);
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

    /// Several pieces to a cell, some shorter than a servo cycle: a plan takes over behind the last of them.
    #[test]
    fn a_plan_takes_over_at_the_end_of_a_cell_in_parts() {
        for times in [[2.5, 2.5, 2.5], [1.5, 0.25, 2.75], [2.25, 0.5, 0.5]] {
            let mut link = Core::new();
            let (mut plan, mut interpolator) = ends(&mut link, Origin::ZERO);
            let (first, second) = (NodeSerial::ZERO, NodeSerial::ZERO.next());
            plan.write(&piece(first, 1, times[0], Sequel::Motion));
            plan.write(&piece(second, 2, times[1], Sequel::Within));
            plan.write(&piece(second, 3, times[2], Sequel::Stop));
            plan.offer(Branch::Node(first));
            let mut seen = tags(&mut interpolator, 1);
            assert_eq!(plan.verdict(), Some(true));
            plan.write(&piece(second.next(), 4, 2.0, Sequel::Stop));
            plan.offer(Branch::Node(second.next()));
            let whole = times.iter().sum::<f64>() + 2.0;
            seen.extend(tags(&mut interpolator, whole.ceil() as usize));
            let first_of = |tag| seen.iter().position(|(seen, _)| *seen == tag).unwrap();
            // The setpoint of cycle k is that k + 1 s after the start.
            let ends = times[0] + times[1] + times[2];
            assert_eq!(
                first_of(4),
                ends.ceil() as usize - usize::from(ends.fract() > 0.0),
                "{times:?}"
            );
            assert!(seen[..first_of(4)].iter().all(|(tag, _)| *tag < 4));
            assert_eq!(plan.verdict(), Some(true));
        }
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
