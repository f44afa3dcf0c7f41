//! The interrupt's side of outputs in time with the path (feature `outputs`): what has been passed, and the power.

use super::setpoint::{Activity, Setpoint};
use super::switching::{Board, Entry, EntrySerial, LINES, Line, Passing, ZONE, moved};
use crate::block::Output;
use crate::machine::DIGITAL;
use crate::number::shared::Shared;
use crate::number::{ArcLength, Scalar};
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};

/// Entries of one queue that one servo cycle passes, and that it carries out: of more, which lie closer than it goes,
/// the others follow in the next.
const PER_TICK: usize = 4;
const ZONE_SHARE: f64 = 16.0;

/// An output has switched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Switched<S> {
    /// Which.
    pub output: Output,
    /// To what: 0 or 1 of a digital one. Of [`Output::Power`] its level.
    pub value: S,
    /// When in the servo cycle that ends with the setpoint: 0 at its beginning, 1 at its end.
    pub fraction: S,
}

/// The power in force.
#[derive(Clone, Copy, Debug)]
struct Level<S> {
    full: S,
    /// That over the feed, s/mm; 0 of one that does not go with the speed.
    slope: S,
    least: S,
    most: S,
}

impl<S: Scalar> Level<S> {
    const OFF: Self = Self { full: S::ZERO, slope: S::ZERO, least: S::ZERO, most: S::ZERO };

    /// At a setpoint of this activity and speed, `before` being that of the setpoint before.
    fn at(&self, activity: Activity, [before, speed]: [S; 2]) -> S {
        match activity {
            // Between a rest of the setpoints and that of what follows them an axis that stands already has none.
            Activity::Running if !(speed > S::ZERO || before > S::ZERO) => S::ZERO,
            Activity::Running if self.slope > S::ZERO => {
                (self.slope * speed).greatest(self.least).least(self.most)
            }
            Activity::Idle | Activity::Jogging | Activity::Set => S::ZERO,
            _ if self.slope > S::ZERO => S::ZERO,
            _ => self.full,
        }
    }
}

/// How far the interrupt has got in a queue.
#[derive(Clone, Copy, Debug)]
struct Head {
    /// The first entry whose place has not been passed.
    ahead: EntrySerial,
    /// The first one that has not been carried out.
    next: EntrySerial,
}

/// A servo cycle, for entries.
struct Now<S> {
    /// Which plan buffer the motion is on.
    plan: usize,
    path: ArcLength,
    /// What counts as the same place near a rest.
    zone: i64,
    activity: Activity,
    /// Speed at its end and at its beginning, mm/s.
    speed: S,
    before: S,
    events: u32,
    count: u32,
    cycle: S,
}

impl<S: Scalar> Now<S> {
    /// How far through the cycle the place of an entry has been passed, 0 to 1; `None` if it lies ahead.
    fn passes<const M: usize>(&self, entry: &Entry<S, M>) -> Option<S> {
        let beyond = self.path.raw().wrapping_sub(entry.place(self.plan).raw());
        let runs = self.activity == Activity::Running;
        let passed = match Passing::from_raw(entry.kind.load(Relaxed)) {
            Passing::Event => {
                let seen = self.events.wrapping_sub(entry.order.load(Relaxed)).cast_signed() >= 0;
                return seen.then_some(S::ONE);
            }
            Passing::Arriving => beyond >= 0 || (!runs && beyond >= -self.zone),
            // Where it comes to rest it does not leave; from rest it does with the first of its speed, however short the way.
            Passing::Leaving | Passing::Ending => {
                let starts = self.before == S::ZERO && self.speed > S::ZERO;
                let passed = beyond > self.zone || (beyond > 0 && !(self.speed < self.before));
                runs && (passed || (starts && beyond >= 0))
            }
        };
        passed.then(|| self.fraction(beyond))
    }

    /// When the motion was `beyond` units of arc length before where it is, with the acceleration that it has had on
    /// average.
    fn fraction(&self, beyond: i64) -> S {
        if beyond <= 0 {
            return S::ONE;
        }
        let two = S::of(2.0);
        let distance = S::from_i64(beyond) * S::of(1.0e-7);
        let gain = self.speed - self.before;
        // In servo cycles t: distance = speed t - gain t^2 / 2, with both times the cycle.
        let (speed, gain, distance) = (self.speed * self.cycle, gain * self.cycle, distance);
        let root = (speed * speed - two * gain * distance).greatest(S::ZERO).sqrt();
        let sum = speed + root;
        if !(two * distance < sum) {
            return S::ZERO;
        }
        S::ONE - two * distance / sum
    }
}

impl Head {
    const FIRST: Self = Self { ahead: EntrySerial::ZERO, next: EntrySerial::ZERO };

    /// Carries out what is due, and returns how many entries are done with.
    fn run<S: Scalar, const DEPTH: usize, const M: usize>(
        &mut self,
        line: &Line<S, DEPTH, M>,
        now: &Now<S>,
        mut carry_out: impl FnMut(&Entry<S, M>, S),
    ) -> u32 {
        let first = self.next;
        // Before `void`: whoever sees entries that never got a place sees that they are void.
        let ready = EntrySerial::from_raw(line.ready.load(Acquire));
        let void = EntrySerial::from_raw(line.void.load(Acquire));
        if self.next.is_before(void) {
            *self = Self { ahead: void, next: void };
        }
        for _ in 0..PER_TICK {
            let Some(entry) = line.entry(self.ahead).filter(|_| self.ahead.is_before(ready)) else {
                break;
            };
            let Some(fraction) = now.passes(entry) else { break };
            let wait = entry.kind.load(Relaxed) >> 2;
            let mut due = fraction + entry.part.load();
            let later = due > S::ONE;
            if later {
                due = due - S::ONE;
            }
            entry.order.store(now.count.wrapping_add(wait).wrapping_add(u32::from(later)), Relaxed);
            entry.part.store(due);
            self.ahead = self.ahead.next();
        }
        let mut least = S::ZERO;
        for _ in 0..PER_TICK {
            let Some(entry) = line.entry(self.next).filter(|_| self.next.is_before(self.ahead))
            else {
                break;
            };
            let late = now.count.wrapping_sub(entry.order.load(Relaxed)).cast_signed();
            if late < 0 {
                break;
            }
            // One that has waited for others before it.
            let due = if late > 0 { S::ZERO } else { entry.part.load() };
            least = least.greatest(due);
            carry_out(entry, least);
            self.next = self.next.next();
        }
        let done = self.next.since(first).unwrap_or(0);
        if done > 0 {
            line.done.store(self.next.raw(), Release);
        }
        done
    }
}

/// The interrupt's end.
pub struct Switcher<'a, S: Scalar> {
    board: &'a Board<S>,
    heads: [Head; LINES],
    power_head: Head,
    /// Entries done with, modulo 2^32.
    done: u32,
    events: u32,
    resets: u32,
    /// Speed at the end of the last servo cycle, mm/s.
    speed: S,
    /// Servo cycles so far.
    count: u32,
    power: Level<S>,
    /// Whether it has been put on for a rest, and the motion has not gone on.
    at_rest: bool,
    /// Whether it has gone off since because the motion came to rest unasked: then it is off until the motion goes on.
    dark: bool,
}

impl<'a, S: Scalar> Switcher<'a, S> {
    pub fn new(board: &'a Board<S>) -> Self {
        Self {
            board,
            heads: [Head::FIRST; LINES],
            power_head: Head::FIRST,
            done: 0,
            events: 0,
            resets: 0,
            speed: S::ZERO,
            count: 0,
            power: Level::OFF,
            at_rest: false,
            dark: false,
        }
    }

    /// After the tick of a servo cycle, whose setpoint is on plan buffer `plan`: tells what has switched in it, and returns the power
    /// at its end.
    #[inline]
    pub fn tick<const N: usize>(
        &mut self,
        at: &Setpoint<S, N>,
        (plan, cycle): (usize, S),
        sink: &mut impl FnMut(Switched<S>),
    ) -> S {
        self.count = self.count.wrapping_add(1);
        if at.activity == Activity::Event {
            self.events = self.events.wrapping_add(1);
            self.board.events.store(self.events, Release);
        }
        let resets = self.board.resets.load(Acquire);
        if resets != self.resets {
            self.resets = resets;
            self.power = Level::OFF;
        }
        if self.board.placed.load(Acquire) != self.done {
            self.look(at, (plan, cycle), sink);
        }
        let speeds = [core::mem::replace(&mut self.speed, at.path_speed), at.path_speed];
        let [before, speed] = speeds;
        match at.activity {
            Activity::Running => {
                let starts = !(before > S::ZERO) && speed > S::ZERO;
                (self.at_rest, self.dark) = (self.at_rest && !starts, false);
            }
            // What a dwell has on is on in what is left of it.
            Activity::Dwelling | Activity::Event if self.dark => return S::ZERO,
            Activity::Dwelling | Activity::Event => self.at_rest = true,
            _ => self.dark = !self.at_rest,
        }
        self.power.at(at.activity, speeds)
    }

    /// Compares the first entry of every queue.
    #[inline(never)]
    fn look<const N: usize>(
        &mut self,
        at: &Setpoint<S, N>,
        (plan, cycle): (usize, S),
        sink: &mut impl FnMut(Switched<S>),
    ) {
        let share = at.path_offset.abs() * S::of(ZONE_SHARE * 1.0e7) * S::EPSILON;
        let now = Now {
            plan,
            path: moved(at.path_origin.plus(at.path_offset), self.board.shift(plan).wrapping_neg()),
            zone: ZONE + share.to_i64(),
            activity: at.activity,
            speed: at.path_speed,
            before: self.speed,
            events: self.events,
            count: self.count,
            cycle,
        };
        let mut done = 0;
        for (i, (line, head)) in self.board.lines.iter().zip(&mut self.heads).enumerate() {
            let output = if i < DIGITAL {
                Output::Digital(i as u8)
            } else {
                Output::Analogue((i - DIGITAL) as u8)
            };
            done += head.run(line, &now, |entry, fraction| {
                let value = entry.values[0].load();
                sink(Switched { output, value, fraction });
            });
        }
        let Self { board, power_head, power, at_rest, dark, .. } = self;
        done += power_head.run(&board.powers, &now, |entry, fraction| {
            let [level, slope, least, most] = entry.values.each_ref().map(Shared::load);
            *power = Level { full: level, slope, least, most };
            let passing = Passing::from_raw(entry.kind.load(Relaxed));
            *at_rest = matches!(passing, Passing::Arriving | Passing::Event);
            *dark &= !*at_rest;
            sink(Switched { output: Output::Power, value: level, fraction });
        });
        self.done = self.done.wrapping_add(done);
    }
}
