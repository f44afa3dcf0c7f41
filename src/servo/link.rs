//! The way from planner to interpolator: plans, handed over whole.
//!
//! Two single-producer single-consumer queues are used in turn. The planner writes a complete
//! plan, from a node that still lies ahead (the branch) to a stop, into the queue that is not in use,
//! and publishes it. The interpolator, on reaching the branch, changes over; if it has passed the
//! branch already, it refuses the plan and stays on the one it has, which ends at rest too. Then
//! it empties the queue that is left over, a few pieces a tick, and reports its verdict; only then
//! is the next plan published. So the interrupt never waits, is never without a stop, and the
//! planner may be as late as it likes.

use super::piece::Piece;
use core::sync::atomic::{AtomicU32, Ordering};
use heapless::spsc::{Consumer, Producer, Queue};

/// What both sides tell each other besides the pieces.
#[derive(Debug, Default)]
pub(crate) struct Flags {
    /// Number of the last plan published.
    published: AtomicU32,
    /// Number of the last plan decided on, times 2, plus 1 if it was taken.
    verdict: AtomicU32,
    /// Node from which the piece under way starts, or at which the motion rests.
    progress: AtomicU32,
    /// Servo cycles so far.
    ticks: AtomicU32,
    /// Stops for want of blocks.
    starved: AtomicU32,
}

/// Shared memory of the two sides: `NODES` pieces twice.
pub struct Link<S, const N: usize, const NODES: usize> {
    queues: [Queue<Piece<S, N>, NODES>; 2],
    flags: Flags,
}

impl<S, const N: usize, const NODES: usize> Default for Link<S, N, NODES> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S, const N: usize, const NODES: usize> Link<S, N, NODES> {
    /// An empty link; it can live in a `static`.
    pub const fn new() -> Self {
        Self {
            queues: [Queue::new(), Queue::new()],
            flags: Flags {
                published: AtomicU32::new(0),
                verdict: AtomicU32::new(1),
                progress: AtomicU32::new(0),
                ticks: AtomicU32::new(0),
                starved: AtomicU32::new(0),
            },
        }
    }

    pub(crate) fn split(&mut self) -> (PlanSide<'_, S, N>, ServoSide<'_, S, N>) {
        let [first, second] = &mut self.queues;
        let (write_first, read_first) = first.split();
        let (write_second, read_second) = second.split();
        let flags = &self.flags;
        (
            PlanSide { queues: [write_first, write_second], flags, published: 0, spare: 1 },
            ServoSide {
                queues: [read_first, read_second],
                flags,
                decided: 0,
                active: 0,
                stale: None,
                taken: true,
            },
        )
    }
}

/// The planner's end.
pub(crate) struct PlanSide<'a, S, const N: usize> {
    queues: [Producer<'a, Piece<S, N>>; 2],
    flags: &'a Flags,
    published: u32,
    /// The queue that is not being executed.
    spare: usize,
}

impl<S, const N: usize> PlanSide<'_, S, N> {
    /// Whether the last plan was taken (`Some(true)`), refused, or is undecided (`None`). To be
    /// asked once per plan.
    pub fn verdict(&mut self) -> Option<bool> {
        let verdict = self.flags.verdict.load(Ordering::Acquire);
        if verdict >> 1 != self.published & (u32::MAX >> 1) {
            return None;
        }
        let taken = verdict & 1 == 1;
        if taken {
            self.spare = 1 - self.spare;
        }
        Some(taken)
    }

    /// Adds a piece to the plan that will be published next; only after a verdict.
    pub fn write(&mut self, piece: Piece<S, N>) {
        // The queue is empty and as long as the window: it cannot be full.
        let _ = self.queues[self.spare].enqueue(piece);
    }

    /// Hands over the pieces written since the last time.
    pub fn publish(&mut self) {
        self.published = self.published.wrapping_add(1);
        self.flags.published.store(self.published, Ordering::Release);
    }

    pub fn progress(&self) -> u32 {
        self.flags.progress.load(Ordering::Acquire)
    }

    pub fn ticks(&self) -> u32 {
        self.flags.ticks.load(Ordering::Relaxed)
    }

    pub fn starved(&self) -> u32 {
        self.flags.starved.load(Ordering::Relaxed)
    }
}

/// Stale pieces dropped in one tick at most.
const DROPS: usize = 8;

/// The interrupt's end.
pub(crate) struct ServoSide<'a, S, const N: usize> {
    queues: [Consumer<'a, Piece<S, N>>; 2],
    flags: &'a Flags,
    /// Number of the last plan decided on.
    decided: u32,
    /// Queue that is being executed.
    active: usize,
    /// Queue that is being emptied.
    stale: Option<usize>,
    taken: bool,
}

impl<S, const N: usize> ServoSide<'_, S, N> {
    /// Drops a few stale pieces; reports the verdict once there are none left.
    pub fn tidy(&mut self) {
        let Some(queue) = self.stale else { return };
        for _ in 0..DROPS {
            if self.queues[queue].dequeue().is_none() {
                self.stale = None;
                let verdict = self.decided.wrapping_mul(2) | u32::from(self.taken);
                self.flags.verdict.store(verdict, Ordering::Release);
                return;
            }
        }
    }

    /// The piece that starts at node `serial`: of the new plan if one branches off there, else of
    /// the present one.
    pub fn next(&mut self, serial: u32) -> Option<Piece<S, N>> {
        if self.flags.published.load(Ordering::Acquire) != self.decided && self.stale.is_none() {
            let other = 1 - self.active;
            if let Some(branch) = self.queues[other].peek().map(|piece| piece.serial) {
                let ahead = branch.wrapping_sub(serial);
                if ahead == 0 {
                    self.decide(true, self.active);
                    self.active = other;
                } else if ahead > u32::MAX / 2 {
                    self.decide(false, other);
                }
            }
        }
        self.queues[self.active].dequeue()
    }

    fn decide(&mut self, taken: bool, stale: usize) {
        self.decided = self.decided.wrapping_add(1);
        self.taken = taken;
        self.stale = Some(stale);
    }

    /// Reports from where the motion goes on.
    pub fn report(&self, serial: u32) {
        self.flags.progress.store(serial, Ordering::Release);
    }

    /// Counts a servo cycle.
    pub fn count_tick(&self) {
        let ticks = self.flags.ticks.load(Ordering::Relaxed);
        self.flags.ticks.store(ticks.wrapping_add(1), Ordering::Relaxed);
    }

    /// Counts a stop for want of blocks.
    pub fn count_starved(&self) {
        let starved = self.flags.starved.load(Ordering::Relaxed);
        self.flags.starved.store(starved.wrapping_add(1), Ordering::Relaxed);
    }
}
