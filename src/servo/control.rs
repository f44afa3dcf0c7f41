//! What an operator asks for while the machine moves.

use super::interleave::AtomicU32;
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};

/// Greatest feed override, per cent.
pub const MOST_FEED: u16 = 200;
/// Greatest override of rapids, per cent.
pub const MOST_RAPID: u16 = 100;

/// A hold is in force.
const HOLD: u32 = 1;
/// A stop is in force.
const STOP: u32 = 2;
/// One resume; resumes are counted in fourteen bits, and one more takes what they carry over.
const RESUME: u32 = 1 << 2;
const RESUMES: u32 = 0x7FFF << 2;
const CARRY: u32 = 1 << 16;
/// One abort; they are counted in the fifteen bits above.
const ABORT: u32 = 1 << 17;

/// Bits of the feed override, and where that of rapids begins and the bit of single block mode is.
const FEED: u32 = 0xFFFF;
const RAPID: u32 = 16;
const RAPID_BITS: u32 = 0xFF;
const SINGLE: u32 = 1 << 24;
/// Times that commands which come while they are read are read anew.
const ROUNDS: usize = 3;

/// The requests, as the operator's side leaves them and the planner finds them. The planner only
/// reads: what is asked for is ended by another command, never by having been answered, so there is
/// no moment at which a command could be lost.
///
/// Commands of several contexts, on one core or on several, meet in two words that are changed by
/// read-modify-write alone: none overwrites another. Changing either releases, [`Requests::read`] acquires both, and the first once more
/// behind the second: what it makes of them was asked for at one moment. A hold, and then an override that is no longer 0, are never
/// seen as no hold with the new override, nor an override of 0 and then a resume as a resume with the old one: between what was asked for before
/// and after, nothing moves that nobody asked for.
#[derive(Debug)]
pub struct Requests {
    /// Hold, stop, and the numbers of resumes and aborts, in one word: all of them at one moment, in
    /// the order in which they were pressed.
    pressed: AtomicU32,
    /// What is set: overrides, as what they differ from 100 per cent by, and single block mode. Untouched requests are all zeros.
    set: AtomicU32,
    /// Holds and aborts for which the stop limits were asked.
    quick: AtomicU32,
    /// What was pressed as the machine came to rest, or to an event, last: a resume from then on is meant for that. Written in the interrupt.
    rested: AtomicU32,
    /// Jogs that have been called off.
    #[cfg(feature = "jog")]
    cancels: AtomicU32,
    /// Holds that have been pressed, the same one again too.
    #[cfg(any(feature = "jog", feature = "wire"))]
    holds: AtomicU32,
}

/// Overrides, per cent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Overrides {
    /// Of feeds.
    pub feed: u16,
    /// Of rapids.
    pub rapid: u16,
}

impl Overrides {
    /// As programmed.
    pub const PROGRAMMED: Self = Self { feed: 100, rapid: 100 };

    /// Whether either of them is less than another.
    pub const fn lowers(self, other: Self) -> bool {
        self.feed < other.feed || self.rapid < other.rapid
    }
}

/// What is asked for at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wish {
    pub hold: bool,
    pub stop: bool,
    pub single: bool,
    pub overrides: Overrides,
    /// Number of the last hold or abort by the stop limits.
    pub quick: u32,
    /// Numbers of the last resume and of the last abort.
    pub resumes: u32,
    pub aborts: u32,
}

impl Wish {
    /// Whether the motion is to be held: by a hold, or by an override of 0.
    pub fn holds(&self) -> bool {
        self.hold || self.overrides.feed == 0 || self.overrides.rapid == 0
    }

    /// Whether it is to rest at the end of a block: by a stop, or in single block mode.
    pub fn stops_at_end(&self) -> bool {
        self.stop || self.single
    }
}

impl Overrides {
    /// Those of what is set.
    fn of(set: u32) -> Self {
        let rapid = MOST_RAPID.saturating_sub((set >> RAPID & RAPID_BITS) as u16);
        Self { feed: (set & FEED).wrapping_add(100) as u16, rapid }
    }
}

impl Requests {
    pub const fn new() -> Self {
        Self {
            pressed: AtomicU32::new(0),
            set: AtomicU32::new(0),
            quick: AtomicU32::new(0),
            rested: AtomicU32::new(0),
            #[cfg(feature = "jog")]
            cancels: AtomicU32::new(0),
            #[cfg(any(feature = "jog", feature = "wire"))]
            holds: AtomicU32::new(0),
        }
    }

    /// Number of the last jog that was called off.
    #[cfg(feature = "jog")]
    pub fn cancels(&self) -> u32 {
        self.cancels.load(Relaxed)
    }

    /// Number of the last hold.
    #[cfg(any(feature = "jog", feature = "wire"))]
    pub fn holds(&self) -> u32 {
        self.holds.load(Relaxed)
    }

    /// What is asked for.
    pub fn read(&self) -> Wish {
        let (pressed_now, set_now) = (|| self.pressed.load(Acquire), || self.set.load(Acquire));
        let (mut pressed, mut set) = (pressed_now(), set_now());
        for _ in 0..ROUNDS {
            let now = pressed_now();
            if now == pressed {
                break;
            }
            (pressed, set) = (now, set_now());
        }
        Wish {
            hold: pressed & HOLD != 0,
            stop: pressed & STOP != 0,
            single: set & SINGLE != 0,
            quick: self.quick.load(Relaxed),
            overrides: Overrides::of(set),
            resumes: pressed & RESUMES,
            aborts: pressed / ABORT,
        }
    }

    /// The machine has come to rest, or to an event.
    pub fn rest(&self) {
        self.rested.store(self.pressed.load(Relaxed), Relaxed);
    }

    /// Number of the last resume that was pressed before. (Who has seen that the motion is there sees this, too.)
    pub fn resumes_before_rest(&self) -> u32 {
        self.rested.load(Relaxed) & RESUMES
    }

    /// Number of the last abort.
    pub fn aborts(&self) -> u32 {
        self.pressed.load(Relaxed) / ABORT
    }

    /// Whether single block mode is on.
    pub fn is_single(&self) -> bool {
        self.set.load(Relaxed) & SINGLE != 0
    }

    /// Of what is pressed, some bits are kept and others added.
    fn press(&self, kept: u32, added: u32) {
        change(&self.pressed, kept, added);
    }

    /// Sets some bits.
    fn set(&self, which: u32, bits: u32) {
        change(&self.set, !which, bits & which);
    }
}

/// Goes round again only if a command of another context came between.
// Once in the image.
#[inline(never)]
fn change(word: &AtomicU32, kept: u32, added: u32) {
    let mut was = word.load(Relaxed);
    while let Err(now) =
        word.compare_exchange(was, (was & kept).wrapping_add(added), Release, Relaxed)
    {
        was = now;
    }
}

/// The operator's handle: commands that overtake the queue. It may be copied and used from any
/// context; a command is noted at once and obeyed by the planner's next
/// [`poll`](crate::Planner::poll), always within every limit and always on the path.
///
/// As a rule the motion changes in the servo cycle after that poll. Where the path bends so that no answer
/// is found at once, or if the interrupt was faster than the answer, the next polls try again.
///
/// No command is ever lost, however near to another or to a rest it comes: each stays in force until
/// the one that ends it.
///
/// | command | what it does | ended by |
/// |---|---|---|
/// | [`hold`](Self::hold) | brakes at once, rests on the path | a resume or an abort pressed after it |
/// | [`quick_hold`](Self::quick_hold) | the same by the stop limits | as a hold |
/// | [`stop`](Self::stop) | rests at the end of the block | a resume or an abort pressed after it |
/// | [`resume`](Self::resume) | ends a hold, a stop, the rest at a pause or in single block mode | - (it is a moment) |
/// | [`abort`](Self::abort) | brakes at once, drops everything; nothing is taken any more | [`Planner::acknowledge_abort`](crate::Planner::acknowledge_abort), once it is complete |
/// | [`quick_abort`](Self::quick_abort) | the same by the stop limits | as an abort |
/// | [`feed_override`](Self::feed_override), [`rapid_override`](Self::rapid_override) | change the speed; 0 is a hold | the next of its kind |
/// | [`single_block`](Self::single_block) | rests at the end of every block | `single_block(false)`; a rest that it has come to, by a resume |
/// | `cancel_jog` (feature `jog`) | ends a jog: as a hold and an abort do | the next jog |
///
/// Which one wins: abort over everything; a hold (or an override of 0) over a stop and single block
/// mode; these over motion. An abort ends a hold and a stop that were pressed before it; one pressed
/// after it, while it brakes or until it is acknowledged, stays in force: the machine is then held until
/// it is resumed. A resume does not end an abort, nor a hold that an override of 0 makes. A resume
/// in motion does nothing to a pause or to a rest of single block mode that is still to come: it is meant for one from the servo cycle on
/// whose setpoint is the first to show the rest, or the pause's event, polled or not. A stop that a hold or an override of 0 interrupts, and that
/// is still in force when they are over, goes on to the end of the block. An abort
/// pressed while another brakes is the same one; one pressed after the first is complete is a new one,
/// complete at the next poll, and is acknowledged by itself. Overrides and single block mode outlast an
/// abort.
#[derive(Clone, Copy, Debug)]
pub struct Controls<'a> {
    requests: &'a Requests,
}

impl<'a> Controls<'a> {
    pub(crate) const fn new(requests: &'a Requests) -> Self {
        Self { requests }
    }

    /// Feed hold: brake as hard as the limits allow, rest on the path, keep everything. In a dwell: rest at
    /// once, and dwell for what is left of it when resumed.
    pub fn hold(self) {
        self.requests.pressed.fetch_or(HOLD, Release);
        #[cfg(any(feature = "jog", feature = "wire"))]
        self.requests.holds.fetch_add(1, Relaxed);
    }

    /// The same by the stop limits ([`Config::stop_limits`](crate::Config)): for a limit switch, a probe, a door. If the
    /// motion brakes already, it goes on as it does.
    pub fn quick_hold(self) {
        // Before the hold itself, whose release makes it seen.
        self.requests.quick.fetch_add(1, Relaxed);
        self.hold();
    }

    /// Ends a jog: every axis brakes as hard as its limits allow. Without a jog it does nothing.
    #[cfg(feature = "jog")]
    pub fn cancel_jog(self) {
        self.requests.cancels.fetch_add(1, Relaxed);
    }

    /// Whether a hold has been pressed and not been ended, and the number of the last.
    #[cfg(feature = "wire")]
    pub(crate) fn held(self) -> (bool, u32) {
        (self.requests.read().hold, self.requests.holds())
    }

    /// Ends a hold or a stop, and the rest at a pause; in single block mode, runs the next block.
    pub fn resume(self) {
        self.requests.press(!(HOLD | STOP | CARRY), RESUME);
    }

    /// Finish the block under way, then rest until [`Controls::resume`]. If the motion is too fast
    /// to rest at its end, the first block is finished at whose end it can. Where a corner is
    /// rounded, the end of a block is the middle of the rounding. Of lines that run on as one curve, and are short beside the way on which
    /// the feed is reached or lie beside such, one in some counts; the rest may lie within one, up to half of it off its end. Where no
    /// motion to such an end is found in time, the machine brakes as for a hold, and goes on from rest to the end of that block. Where
    /// a curve turns back within itself (a cusp), the motion rests in any case: that counts as an end, too.
    pub fn stop(self) {
        self.requests.pressed.fetch_or(STOP, Release);
    }

    /// Brake as for a hold; once at rest, drop everything that has been pushed and not been run.
    /// [`Planner::end`](crate::Planner::end) then says exactly where the machine stands. From now
    /// until [`Planner::acknowledge_abort`](crate::Planner::acknowledge_abort),
    /// [`Planner::push`](crate::Planner::push) takes no block. A hold or a stop that has been pressed before ends with it: press hold behind
    /// the abort, and what is pushed next waits for a resume.
    pub fn abort(self) {
        self.requests.press(!(HOLD | STOP), ABORT);
    }

    /// The same by the stop limits ([`Config::stop_limits`](crate::Config)).
    pub fn quick_abort(self) {
        self.requests.quick.fetch_add(1, Relaxed);
        self.abort();
    }

    /// Feed override, 0 to 200 per cent of the programmed feed (more counts as 200), never beyond
    /// what the axes allow. At 0 the motion is held.
    pub fn feed_override(self, percent: u16) {
        self.requests.set(FEED, u32::from(percent.min(MOST_FEED)).wrapping_sub(100));
    }

    /// Override of rapids, 0 to 100 per cent. At 0 the motion is held.
    pub fn rapid_override(self, percent: u16) {
        let less = MOST_RAPID.saturating_sub(percent);
        self.requests.set(RAPID_BITS << RAPID, u32::from(less) << RAPID);
    }

    /// Single block mode: rest at the end of every block until [`Controls::resume`]; what follows on with the same tag
    /// is one block. The rest is exactly on the programmed end, as after an exact stop, of every block that is pushed, or
    /// joined to the next one, while the mode is on. A block whose joint was rounded before ends in the middle of the
    /// rounding.
    pub fn single_block(self, on: bool) {
        self.requests.set(SINGLE, if on { SINGLE } else { 0 });
    }
}

// Of one context; `models.rs` has those of several.
#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    /// Longer than any of the numbers can count.
    #[test]
    fn a_resume_and_an_abort_are_never_like_the_ones_before() {
        let requests = Requests::new();
        let controls = Controls::new(&requests);
        let mut before = requests.read();
        for i in 0..100_000 {
            controls.hold();
            controls.stop();
            if i % 3 == 0 {
                controls.abort();
            } else {
                controls.resume();
            }
            let now = requests.read();
            assert!(!now.hold && !now.stop);
            let changed = (now.resumes != before.resumes, now.aborts != before.aborts);
            assert_eq!(changed, (i % 3 != 0, i % 3 == 0), "{i}");
            before = now;
        }
    }

    #[test]
    fn what_is_set_is_what_is_read() {
        let requests = Requests::new();
        let controls = Controls::new(&requests);
        assert_eq!(requests.read().overrides, Overrides::PROGRAMMED);
        for feed in [0, 1, 99, 100, 101, 200, u16::MAX] {
            for rapid in [0, 1, 25, 99, 100, u16::MAX] {
                for single in [false, true] {
                    controls.feed_override(feed);
                    controls.rapid_override(rapid);
                    controls.single_block(single);
                    let Wish { overrides, single: read, .. } = requests.read();
                    let wanted =
                        Overrides { feed: feed.min(MOST_FEED), rapid: rapid.min(MOST_RAPID) };
                    assert_eq!((overrides, read), (wanted, single));
                }
            }
        }
    }
}
