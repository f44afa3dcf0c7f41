//! The hand-over from planner to interpolator: whole plans, never parts of one.
//!
//! Two plan buffers are used in turn. The planner writes a complete plan - from a place that still
//! lies ahead (the branch) to a stop - into the buffer that is not being executed, and offers it. A
//! plan branches off either at a node of the path or, to answer an operator's command at once, at a
//! servo cycle. The interpolator changes over when it gets there; if it has passed the branch
//! already, it refuses the plan and stays on the one it has, which ends at rest too. Until one of
//! the two has happened the planner may withdraw the offer. So the interrupt never waits, is never
//! without a stop, and the planner may be as late as it likes.
//!
//! Who may touch the spare buffer is settled by one atomic, the offer: only the planner while
//! nothing is offered, only the interpolator from the moment it has taken a plan. Buffers are made
//! of atomics ([`crate::number::shared`]), so even a mistake in this could not be undefined
//! behaviour; on the targets they are plain loads and stores.
//!
//! # Orderings
//!
//! On one core, where the interrupt comes in between two instructions of the background, only the compiler could
//! reorder; on several cores the processors could too. The same four pairs forbid it to both:
//!
//! - *Offered, opened*: the planner stores the offer with release, the interpolator loads it with acquire. So branch,
//!   length and pieces are seen as they were written.
//! - *Taken, told*: the interpolator takes or refuses by a compare-and-swap with release, the planner loads the verdict
//!   with acquire. So the planner writes over a buffer only after the last read from it, and finds cycles and timeline
//!   no older than the verdict. The compare-and-swap needs no acquire: it succeeds on the very word that was loaded.
//! - *Timeline* (a sequence lock): an odd version, a release fence, the values, an even version with release; the
//!   planner loads the version with acquire, the values, an acquire fence, and the version again. A look during a
//!   report fails.
//! - *Progress*: stored after that release fence, loaded with acquire: a node that is reported passed has been left in a
//!   cycle that is counted.
//!
//! A withdrawal publishes nothing, and cycles and starvations are single numbers that nothing hangs on: relaxed. The
//! tests of `models.rs` try every interleaving of at most three preemptions, and fail if any one of these orderings is weakened.

use super::control::Requests;
#[cfg(feature = "probe")]
use super::input::{Inputs, Lines};
use super::interleave::{Fault, is_planted, point};
use super::piece::{Piece, Slot, Slower};
#[cfg(feature = "outputs")]
use super::switching::Board;
use crate::number::atomic::{AtomicU32, fence};
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::shared::Shared;
use crate::number::{Coord, Scalar};
// One at which no other context comes in: what is looked at in debug builds alone does not change what interleaves.
#[cfg(debug_assertions)]
use core::sync::atomic::AtomicU32 as QuietU32;
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};

/// Where a plan leaves the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// At the node with this running number.
    Node(NodeSerial),
    /// Where the plan before stands at the end of the servo cycle with this number.
    Cycle(CycleSerial),
}

impl Branch {
    /// Whether it does so at a servo cycle.
    pub const fn is_by_cycle(self) -> bool {
        matches!(self, Self::Cycle(_))
    }
}

/// What has become of an offer: the low two bits of [`Flags::offer`]; the others count offers.
/// Taken is 0, so that an empty channel is all zeros and takes no room in the image.
const TAKEN: u32 = 0;
const OPEN: u32 = 1;
const REFUSED: u32 = 2;
const VERDICT: u32 = 3;
/// The share of jerk that is felt where two pieces meet: twice what is granted to a cell that is cut in a crawl.
#[cfg(debug_assertions)]
const LEAP: f64 = 5.0e-4;

/// What both sides tell each other besides the pieces.
pub struct Flags<S: Scalar> {
    /// Number of the last offer times four, plus what has become of it.
    offer: AtomicU32,
    /// Node or servo cycle at which the offered plan branches off.
    branch: AtomicU32,
    /// Whether `branch` is a servo cycle.
    by_cycle: AtomicU32,
    /// Length of either plan, pieces.
    lengths: [AtomicU32; 2],
    /// Node from which the piece under way starts, or at which the motion rests.
    progress: AtomicU32,
    /// Odd while what follows is being written.
    version: AtomicU32,
    /// Number of the plan under way.
    plan: AtomicU32,
    /// Servo cycle that saw the piece under way begin.
    began: AtomicU32,
    /// Time by which it had begun at the end of that cycle, s.
    lag: S::Shared,
    /// Servo cycles so far.
    cycles: AtomicU32,
    /// Stops for want of blocks.
    starved: AtomicU32,
    /// By how much an acceleration may leap where a piece begins, mm/s2, as the bits of an `f32`; 0 if that is not looked at.
    #[cfg(debug_assertions)]
    leap: QuietU32,
}

/// The numbers that are counted on from.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// Node at which the motion rests.
    pub node: NodeSerial,
    /// Servo cycles so far.
    pub cycle: CycleSerial,
    /// Plans so far, less than 2^30.
    pub plan: u32,
}

impl Origin {
    /// From nothing.
    pub const ZERO: Self = Self { node: NodeSerial::ZERO, cycle: CycleSerial::ZERO, plan: 0 };
}

impl<S: Scalar> Flags<S> {
    const fn new(origin: Origin) -> Self {
        Self {
            offer: AtomicU32::new(origin.plan << 2 | TAKEN),
            branch: AtomicU32::new(0),
            by_cycle: AtomicU32::new(0),
            lengths: [AtomicU32::new(0), AtomicU32::new(0)],
            progress: AtomicU32::new(origin.node.raw()),
            version: AtomicU32::new(0),
            plan: AtomicU32::new(origin.plan),
            began: AtomicU32::new(origin.cycle.raw()),
            lag: S::Shared::ZERO,
            cycles: AtomicU32::new(origin.cycle.raw()),
            starved: AtomicU32::new(0),
            #[cfg(debug_assertions)]
            leap: QuietU32::new(0),
        }
    }
}

/// What a core's two sides share: `NODES` pieces twice, and what an operator asks for.
pub struct Channel<S: Scalar, const N: usize, const NODES: usize> {
    plans: [[Slot<S, N>; NODES]; 2],
    flags: Flags<S>,
    requests: Requests,
    #[cfg(feature = "probe")]
    lines: Lines,
    #[cfg(feature = "outputs")]
    board: Board<S>,
}

impl<S: Scalar, const N: usize, const NODES: usize> Channel<S, N, NODES> {
    /// An empty one: all zeros.
    pub const fn new() -> Self {
        Self {
            plans: [const { [const { Slot::EMPTY }; NODES] }; 2],
            flags: Flags::new(Origin::ZERO),
            requests: Requests::new(),
            #[cfg(feature = "probe")]
            lines: Lines::new(),
            #[cfg(feature = "outputs")]
            board: Board::new(),
        }
    }

    /// Forgets everything and gives both ends.
    pub fn ends(&mut self, origin: Origin) -> (PlanSide<'_, S, N>, ServoSide<'_, S, N>, &Requests) {
        // What is left in the plan buffers is never read: their lengths are 0.
        self.flags = Flags::new(origin);
        self.requests = Requests::new();
        #[cfg(feature = "probe")]
        {
            self.lines = Lines::new();
        }
        #[cfg(feature = "outputs")]
        self.board.clear();
        let plans = [&self.plans[0][..], &self.plans[1][..]];
        let (flags, plan) = (&self.flags, origin.plan);
        (
            PlanSide {
                plans,
                shared: flags,
                #[cfg(feature = "probe")]
                lines: &self.lines,
                offered: plan,
                taken: plan,
                spare: 1,
                written: 0,
                #[cfg(feature = "outputs")]
                board: &self.board,
            },
            ServoSide {
                plans,
                flags,
                requests: &self.requests,
                plan,
                active: 0,
                next: 0,
                #[cfg(feature = "outputs")]
                board: &self.board,
            },
            &self.requests,
        )
    }
}

/// When the piece under way began.
#[derive(Clone, Copy, Debug)]
pub struct Timeline<S> {
    /// Node from which it starts.
    pub serial: NodeSerial,
    /// Servo cycle at whose end it was first evaluated or taken up.
    pub began: CycleSerial,
    /// How far into the piece the end of that cycle is, s.
    pub lag: S,
}

/// The slots of the plan buffer that is not being executed, while no plan is in it: a workspace of whoever looks for one.
#[derive(Clone, Copy)]
pub struct Room<'a, S: Scalar, const N: usize> {
    /// One for every node of the window.
    pub slots: &'a [Slot<S, N>],
    /// Number of the last offer: where it is another, nothing is left of what was kept.
    pub number: u32,
}

/// The planner's end.
pub struct PlanSide<'a, S: Scalar, const N: usize> {
    plans: [&'a [Slot<S, N>]; 2],
    /// Through [`PlanSide::flags`] only.
    shared: &'a Flags<S>,
    #[cfg(feature = "probe")]
    lines: &'a Lines,
    /// Number of the last offer, and of the last one that was taken.
    offered: u32,
    taken: u32,
    /// The buffer that is not being executed.
    spare: usize,
    written: usize,
    /// Outputs that are to switch.
    #[cfg(feature = "outputs")]
    pub board: &'a Board<S>,
}

/// Attempts at a consistent look at the timeline; under the model checker one, for each multiplies what it has to
/// try.
const LOOKS: usize = if cfg!(all(test, loom)) { 1 } else { 8 };

#[cfg(feature = "probe")]
impl<'a, S: Scalar, const N: usize> PlanSide<'a, S, N> {
    /// The inputs.
    pub fn lines(&self) -> &'a Lines {
        self.lines
    }

    /// The handle of what sees them.
    pub fn inputs(&self) -> Inputs<'a> {
        Inputs::new(self.lines, &self.shared.cycles)
    }
}

impl<S: Scalar, const N: usize> PlanSide<'_, S, N> {
    /// What is shared; before every access another context may come in.
    fn flags(&self) -> &Flags<S> {
        point();
        self.shared
    }

    /// Has the interrupt look whether every piece begins as the one before ends: its acceleration leaps by no more than a share of what a
    /// jerk, mm/s3, changes in a servo cycle, s. Of several the greatest counts.
    #[cfg(debug_assertions)]
    pub fn watch(&self, jerk: S, cycle: S) {
        let leap = (jerk * cycle * S::of(LEAP)).to_f64() as f32;
        self.shared.leap.fetch_max(leap.to_bits(), Relaxed);
    }

    /// Uses every atomic once.
    #[cfg(all(test, loom))]
    pub fn touch(&self) {
        let Flags { offer, branch, by_cycle, lengths, progress, version, plan, .. } = self.shared;
        let Flags { began, lag, cycles, starved, .. } = self.shared;
        for flag in [offer, branch, by_cycle, progress, version, plan, began, cycles, starved] {
            flag.load(Relaxed);
        }
        for length in lengths {
            length.load(Relaxed);
        }
        lag.load();
        for slot in self.plans.into_iter().flatten() {
            slot.at(S::ZERO, false);
            (slot.serial(), slot.time(), slot.has_event());
        }
    }

    /// Whether the last plan was taken (`Some(true)`), refused, or is undecided (`None`). To be
    /// asked until it is decided, then no more.
    pub fn verdict(&mut self) -> Option<bool> {
        let offer = self.flags().offer.load(Acquire);
        match offer & VERDICT {
            OPEN => None,
            said if said == TAKEN || is_planted(Fault::RefusedIsTaken) => {
                self.spare = 1 - self.spare;
                self.taken = self.offered;
                Some(true)
            }
            _ => Some(false),
        }
    }

    /// Takes an offer back if it is still undecided. The verdict then is that it was refused.
    pub fn withdraw(&mut self) {
        let offer = self.offered << 2;
        // If this fails, the interpolator has been faster, and its verdict stands.
        let _ =
            self.flags().offer.compare_exchange(offer | OPEN, offer | REFUSED, Relaxed, Relaxed);
    }

    /// Servo cycles until the interpolator decides on the last offer, which branches off at one.
    pub fn undecided_for(&self) -> u32 {
        let branch = CycleSerial::from_raw(self.flags().branch.load(Relaxed));
        branch.since(self.cycles()).unwrap_or(0)
    }

    /// Whether the buffer that is taken for the spare one is: nothing is undecided, and of what was taken the verdict has been heard.
    fn has_spare(&self) -> bool {
        self.taken == self.offered || self.shared.offer.load(Relaxed) & VERDICT == REFUSED
    }

    /// The room for a plan that has not been written: only when the last is decided, until the first piece of the next.
    pub fn room(&self) -> Room<'_, S, N> {
        debug_assert_eq!(self.written, 0, "a workspace in place of a plan");
        debug_assert!(self.has_spare(), "a workspace in place of a plan that may be under way");
        Room { slots: self.plans[self.spare & 1], number: self.offered }
    }

    /// Adds a piece to the plan that will be offered next; only when the last is decided.
    pub fn write(&mut self, piece: &Piece<S, N>) {
        debug_assert!(piece.time > S::ZERO, "a piece of no duration");
        debug_assert!(self.has_spare(), "a piece in place of a plan that may be under way");
        let slot = self.plans[self.spare & 1].get(self.written);
        debug_assert!(slot.is_some(), "more pieces than the window has nodes");
        if let Some(slot) = slot {
            slot.store(piece);
            self.written += 1;
        }
    }

    /// Index in the plan under way of its first piece from a node.
    pub fn find(&self, node: NodeSerial) -> Option<usize> {
        self.under_way().iter().position(|slot| slot.serial() == node)
    }

    /// Adds the piece of the plan under way with an index, run by a clock that goes evenly at a rate, if it is what comes over a cell
    /// that begins at a place. Whether it is.
    pub fn write_slower(
        &mut self,
        index: usize,
        place: &[Coord; N],
        rate: S,
        slower: &Slower<S>,
    ) -> bool {
        debug_assert!(self.has_spare(), "a piece in place of a plan that may be under way");
        let Some(agreed) = self.under_way().get(index) else { return false };
        let Some(slot) = self.plans[self.spare & 1].get(self.written) else { return false };
        let is_that = agreed.passes(place, slower.time * rate);
        if is_that {
            slot.store_slower(agreed, rate, slower);
            self.written += 1;
        }
        is_that
    }

    /// Whether the last piece written is one, but for rounding.
    pub fn has_written(&self, piece: &Piece<S, N>) -> bool {
        let last = self.written.checked_sub(1);
        let slot = last.and_then(|last| self.plans[self.spare & 1].get(last));
        slot.is_some_and(|slot| slot.is_about(piece))
    }

    /// The pieces of the plan under way.
    fn under_way(&self) -> &[Slot<S, N>] {
        let active = (1 - self.spare) & 1;
        let length = self.flags().lengths[active].load(Relaxed) as usize;
        self.plans[active].get(..length).unwrap_or(&[])
    }

    /// Forgets the pieces written since the last offer.
    pub fn discard(&mut self) {
        self.written = 0;
    }

    /// Offers the pieces written since the last time; none at all means a rest at the branch.
    pub fn offer(&mut self, branch: Branch) {
        debug_assert_ne!(
            self.shared.offer.load(Relaxed) & VERDICT,
            OPEN,
            "an offer in place of one that is undecided"
        );
        let (place, by_cycle) = match branch {
            Branch::Node(serial) => (serial.raw(), 0),
            Branch::Cycle(cycle) => (cycle.raw(), 1),
        };
        if is_planted(Fault::OfferFirst) {
            self.flags().offer.store(self.offered.wrapping_add(1) << 2 | OPEN, Release);
        }
        self.flags().branch.store(place, Relaxed);
        self.flags().by_cycle.store(by_cycle, Relaxed);
        self.flags().lengths[self.spare & 1].store(self.written as u32, Relaxed);
        self.written = 0;
        self.offered = self.offered.wrapping_add(1) & (u32::MAX >> 2);
        self.flags().offer.store(self.offered << 2 | OPEN, Release);
    }

    /// The buffer that is being executed, and the other one.
    #[cfg(feature = "outputs")]
    pub fn buffers(&self) -> (usize, usize) {
        (1 - self.spare, self.spare)
    }

    /// Pieces written for the next offer.
    #[cfg(feature = "outputs")]
    pub fn written(&self) -> usize {
        self.written
    }

    /// Pieces of the plan that is being executed.
    #[cfg(feature = "outputs")]
    pub fn agreed(&self) -> usize {
        self.under_way().len()
    }

    /// Pieces of the plan on offer.
    #[cfg(feature = "outputs")]
    pub fn offered(&self) -> usize {
        self.flags().lengths[self.spare & 1].load(Relaxed) as usize
    }

    /// The first pieces of a plan buffer.
    #[cfg(feature = "outputs")]
    pub fn pieces(&self, plan: usize, count: usize) -> &[Slot<S, N>] {
        let plan = self.plans[plan & 1];
        plan.get(..count).unwrap_or(plan)
    }

    /// Node from which the piece under way starts, or at which the motion rests.
    pub fn progress(&self) -> NodeSerial {
        NodeSerial::from_raw(self.flags().progress.load(Acquire))
    }

    /// When the piece under way began; `None` if it changed at every look, or if the interpolator
    /// has taken a plan and not yet begun on it.
    pub fn timeline(&self) -> Option<Timeline<S>> {
        for _ in 0..LOOKS {
            let version = self.flags().version.load(Acquire);
            let timeline = Timeline {
                serial: NodeSerial::from_raw(self.flags().progress.load(Relaxed)),
                began: CycleSerial::from_raw(self.flags().began.load(Relaxed)),
                lag: self.flags().lag.load(),
            };
            let plan = self.flags().plan.load(Relaxed);
            fence(Acquire);
            if version & 1 == 0 && self.flags().version.load(Relaxed) == version {
                return (plan == self.taken).then_some(timeline);
            }
        }
        None
    }

    /// Number of the last servo cycle.
    pub fn cycles(&self) -> CycleSerial {
        CycleSerial::from_raw(self.flags().cycles.load(Relaxed))
    }

    pub fn starved(&self) -> u32 {
        self.flags().starved.load(Relaxed)
    }
}

/// What the interrupt has found at a node.
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    /// The offer that branches off ahead, and the node where it does.
    offer: Option<(u32, NodeSerial)>,
    /// Pieces of the plan under way before that.
    pub pieces: usize,
}

impl Ahead {
    /// The offer that branches off at this node.
    pub fn at(self, serial: NodeSerial) -> Option<u32> {
        self.offer.filter(|(_, node)| *node == serial).map(|(offer, _)| offer)
    }
}

/// The interrupt's end.
pub struct ServoSide<'a, S: Scalar, const N: usize> {
    plans: [&'a [Slot<S, N>]; 2],
    flags: &'a Flags<S>,
    requests: &'a Requests,
    /// Number of the plan under way.
    plan: u32,
    /// Buffer that is being executed.
    active: usize,
    /// Index of the next piece in it.
    next: usize,
    /// Outputs that are to switch.
    #[cfg(feature = "outputs")]
    pub board: &'a Board<S>,
}

impl<'a, S: Scalar, const N: usize> ServoSide<'a, S, N> {
    /// The machine comes to rest, or to an event: to be called before [`ServoSide::report`], which lets the planner see it.
    pub fn rest(&self) {
        self.requests.rest();
    }

    /// By how much an acceleration may leap where a piece begins, mm/s2; `None` if that is not looked at.
    #[cfg(debug_assertions)]
    pub fn leap(&self) -> Option<S> {
        let leap = f32::from_bits(self.flags.leap.load(Relaxed));
        (leap > 0.0).then(|| S::of(f64::from(leap)))
    }

    /// The offer that is open: its word, its branch.
    fn open(&self) -> Option<(u32, Branch)> {
        let offer = self.flags.offer.load(Acquire);
        if offer & VERDICT != OPEN {
            return None;
        }
        let place = self.flags.branch.load(Relaxed);
        let by_cycle = self.flags.by_cycle.load(Relaxed) != 0;
        let branch = if by_cycle {
            Branch::Cycle(CycleSerial::from_raw(place))
        } else {
            Branch::Node(NodeSerial::from_raw(place))
        };
        Some((offer, branch))
    }

    /// Takes or refuses an offer; `false` if it has been withdrawn meanwhile.
    fn decide(&mut self, offer: u32, verdict: u32) -> bool {
        let decided = offer & !VERDICT | verdict;
        let done = self.flags.offer.compare_exchange(offer, decided, Release, Relaxed).is_ok();
        if done && verdict == TAKEN {
            self.plan = offer >> 2;
            self.active = 1 - self.active;
            self.next = 0;
        }
        done
    }

    /// Whether a new plan has just been taken that branches off at the end of servo cycle `last`. One that branched off
    /// before, or before the end of the piece under way, which is node `serial`, is refused.
    pub fn change_over(&mut self, last: CycleSerial, serial: NodeSerial) -> bool {
        let Some((offer, branch)) = self.open() else { return false };
        let late = match branch {
            Branch::Cycle(cycle) if cycle == last => return self.decide(offer, TAKEN),
            Branch::Cycle(cycle) => cycle.is_before(last),
            Branch::Node(node) => node.is_before(serial),
        };
        if late {
            self.decide(offer, REFUSED);
        }
        false
    }

    /// What comes from node `serial` on, where the next piece begins.
    pub fn ahead(&self, serial: NodeSerial) -> Ahead {
        let none = Ahead { offer: None, pieces: usize::MAX };
        let Some((offer, Branch::Node(node))) = self.open() else { return none };
        let Some(pieces) = node.since(serial) else { return none };
        Ahead { offer: Some((offer, node)), pieces: pieces as usize }
    }

    /// Whether nothing may follow, whatever becomes of an offer that branches off here.
    pub fn may_end(&self, offer: Option<u32>) -> bool {
        // Taken or withdrawn: either plan may be the one.
        !self.lasts() || (offer.is_some() && self.length(1 - self.active) == 0)
    }

    /// Takes an offer, if it still stands.
    pub fn take(&mut self, offer: u32) {
        self.decide(offer, TAKEN);
    }

    /// Whether the plan under way has another piece.
    pub fn lasts(&self) -> bool {
        self.next < self.length(self.active)
    }

    fn length(&self, plan: usize) -> usize {
        self.flags.lengths[plan & 1].load(Relaxed) as usize
    }

    /// The next pieces of the plan under way, at most `count` of them.
    #[inline]
    pub fn following(&self, count: usize) -> &'a [Slot<S, N>] {
        let left = self.length(self.active).saturating_sub(self.next);
        let plan: &'a [Slot<S, N>] = self.plans[self.active & 1];
        plan.get(self.next..).and_then(|plan| plan.get(..left.min(count))).unwrap_or(&[])
    }

    /// So many of them are behind, or under way.
    #[inline]
    pub fn pass(&mut self, count: usize) {
        self.next += count;
    }

    /// Reports the piece that is taken up, or that there is none.
    pub fn report(&self, timeline: &Timeline<S>) {
        let version = self.flags.version.load(Relaxed);
        self.flags.version.store(version.wrapping_add(1), Relaxed);
        fence(Release);
        self.flags.plan.store(self.plan, Relaxed);
        self.flags.began.store(timeline.began.raw(), Relaxed);
        self.flags.lag.store(timeline.lag);
        self.flags.progress.store(timeline.serial.raw(), Relaxed);
        self.flags.version.store(version.wrapping_add(2), Release);
    }

    /// The buffer that is being executed.
    #[cfg(feature = "outputs")]
    pub fn active(&self) -> usize {
        self.active
    }

    /// Number of the last servo cycle.
    pub fn cycles(&self) -> CycleSerial {
        CycleSerial::from_raw(self.flags.cycles.load(Relaxed))
    }

    /// Counts a servo cycle.
    pub fn count_cycle(&self) {
        self.flags.cycles.store(self.cycles().next().raw(), Relaxed);
    }

    /// Counts a stop for want of blocks.
    pub fn count_starved(&self) {
        let starved = self.flags.starved.load(Relaxed);
        self.flags.starved.store(starved.wrapping_add(1), Relaxed);
    }
}
