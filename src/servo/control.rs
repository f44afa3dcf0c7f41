//! What an operator asks for while the machine moves.

use super::interleave::{AtomicBool, AtomicU32};
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};

/// Greatest feed override, per cent.
pub const MOST_FEED: u16 = 200;
/// Greatest override of rapids, per cent.
pub const MOST_RAPID: u16 = 100;

/// The requests, as the operator's side leaves them and the planner finds them.
#[derive(Debug)]
pub struct Requests {
    hold: AtomicBool,
    stop: AtomicBool,
    abort: AtomicBool,
    single: AtomicBool,
    /// Overrides, as what they differ from 100 per cent by: untouched requests are all zeros.
    feed: AtomicU32,
    rapid: AtomicU32,
    /// Counts [`Controls::resume`], so that none is missed.
    resumes: AtomicU32,
}

/// What is asked for at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wish {
    pub hold: bool,
    pub stop: bool,
    pub abort: bool,
    pub single: bool,
    /// Overrides of feed and of rapids, per cent.
    pub overrides: (u16, u16),
    pub resumes: u32,
}

impl Wish {
    /// Whether the motion is to be held: by a hold, or by an override of 0.
    pub fn holds(&self) -> bool {
        self.hold || self.overrides.0 == 0 || self.overrides.1 == 0
    }
}

fn per_cent(share: &AtomicU32) -> u16 {
    share.load(Acquire).wrapping_add(100) as u16
}

fn set_per_cent(share: &AtomicU32, percent: u16) {
    share.store(u32::from(percent).wrapping_sub(100), Release);
}

impl Requests {
    pub const fn new() -> Self {
        Self {
            hold: AtomicBool::new(false),
            stop: AtomicBool::new(false),
            abort: AtomicBool::new(false),
            single: AtomicBool::new(false),
            feed: AtomicU32::new(0),
            rapid: AtomicU32::new(0),
            resumes: AtomicU32::new(0),
        }
    }

    pub fn read(&self) -> Wish {
        Wish {
            hold: self.hold.load(Acquire),
            stop: self.stop.load(Acquire),
            abort: self.abort.load(Acquire),
            single: self.single.load(Acquire),
            overrides: (per_cent(&self.feed), per_cent(&self.rapid)),
            resumes: self.resumes.load(Acquire),
        }
    }

    /// The abort is done with: everything that was asked for before is.
    pub fn aborted(&self) {
        self.hold.store(false, Relaxed);
        self.stop.store(false, Relaxed);
        self.abort.store(false, Release);
    }

    /// The block under way has been finished and the motion rests.
    pub fn stopped(&self) {
        self.stop.store(false, Release);
    }
}

/// The operator's handle: commands that overtake the queue. It may be copied and used from any
/// context; a command is noted at once and obeyed by the planner's next
/// [`poll`](crate::Planner::poll), always within every limit and always on the path.
#[derive(Clone, Copy, Debug)]
pub struct Controls<'a> {
    requests: &'a Requests,
}

impl<'a> Controls<'a> {
    pub(crate) const fn new(requests: &'a Requests) -> Self {
        Self { requests }
    }

    /// Feed hold: brake as hard as the limits allow, rest on the path, keep everything.
    pub fn hold(self) {
        self.requests.hold.store(true, Release);
    }

    /// Ends a hold or a stop; in single block mode, runs the next block.
    pub fn resume(self) {
        self.requests.hold.store(false, Relaxed);
        self.requests.stop.store(false, Release);
        let resumes = self.requests.resumes.load(Relaxed);
        self.requests.resumes.store(resumes.wrapping_add(1), Release);
    }

    /// Finish the block under way, then rest until [`Controls::resume`]. If the motion is too fast
    /// to rest at its end, the first block is finished at whose end it can. Where a corner is
    /// rounded, the end of a block is the middle of the rounding.
    pub fn stop(self) {
        self.requests.stop.store(true, Release);
    }

    /// Brake as for a hold; once at rest, drop everything that has been pushed and not been run.
    /// [`Planner::end`](crate::Planner::end) then says exactly where the machine stands. Until
    /// then [`Planner::push`](crate::Planner::push) takes no block. An abort ends a hold.
    pub fn abort(self) {
        self.requests.abort.store(true, Release);
    }

    /// Feed override, 0 to 200 per cent of the programmed feed (more counts as 200), never beyond
    /// what the axes allow. At 0 the motion is held.
    pub fn feed_override(self, percent: u16) {
        set_per_cent(&self.requests.feed, percent.min(MOST_FEED));
    }

    /// Override of rapids, 0 to 100 per cent. At 0 the motion is held.
    pub fn rapid_override(self, percent: u16) {
        set_per_cent(&self.requests.rapid, percent.min(MOST_RAPID));
    }

    /// Single block mode: rest at the end of every block until [`Controls::resume`].
    pub fn single_block(self, on: bool) {
        self.requests.single.store(on, Release);
    }
}
