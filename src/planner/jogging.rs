//! Jogs: plans of [`crate::jog`] in place of those on the path, while that rests.
//!
//! A jog is a plan like any other to the interrupt: it branches off at a servo cycle and ends at rest. So what is done without
//! another word from the operator is known when it begins, and nothing in the interrupt has to watch over it. While a jog is on,
//! the rest of the planner stands still: the path's plan ends where the jog began, and the numbers of its nodes stay as they
//! are.
//!
//! | the machine rests | after the jog |
//! |---|---|
//! | with nothing to run | the path begins anew from where it stands; no block is taken meanwhile |
//! | in a program, held | it is held until it stands where it was held, and then until a resume |

#[cfg(feature = "home")]
use super::homing::Homing;
use super::phase::{Phase, Rest};
#[cfg(feature = "probe")]
use super::probing::{Probing, Seeking};
use super::{Planner, Progress};
#[cfg(feature = "home")]
use crate::jog::homing::AxisAim;
use crate::jog::plan::{Aim, Frame, MOST_CYCLES, Plan, Planned, travel};
use crate::jog::{Jog, JogError};
use crate::machine::Quantity;
use crate::number::serial::CycleSerial;
use crate::number::{ArcLength, Coord, Range, Scalar};
use crate::servo::control::{Requests, Wish};
use crate::servo::link::Branch;
use core::array::from_fn;

/// Servo cycles before the end of a jog to a place from which on the same place is not planned for anew, if that is no sooner.
const ENDING: u32 = 8;

/// What is asked for.
// With a number of its own: nothing asked for is all zeros then, as the memory of a core must be.
#[derive(Clone, Copy, Debug)]
#[repr(u8)]
pub(super) enum Asked<const N: usize> {
    Nothing,
    /// Per axis, mm per cycle, for so many cycles.
    Velocity([f64; N], u32),
    /// The same until a servo cycle: so a plan has been made for it, and one that is made anew lasts no longer.
    Until([f64; N], CycleSerial),
    /// To a place, at a speed, mm per cycle.
    Place([Coord; N], f64),
    /// By a distance from where the axes would stop, at a speed.
    Step([Coord; N], f64),
    Stop,
    /// To rest on the line of a probe, as short as can be.
    #[cfg(feature = "probe")]
    Halt,
    /// Every axis by itself.
    #[cfg(feature = "home")]
    Each([AxisAim; N]),
    /// Coordinates, at rest.
    #[cfg(feature = "home")]
    Set([Coord; N]),
}

/// Whether there is a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum On {
    No,
    /// With nothing to run.
    Free,
    /// In a program that is held.
    Held,
}

/// A jog.
#[derive(Clone, Debug)]
pub struct Jogging<const N: usize> {
    on: On,
    /// Where the path rests.
    home: [Coord; N],
    /// What the interrupt runs, and from the end of which servo cycle on; at rest, where it stands.
    pub(super) agreed: Plan<N>,
    pub(super) began: CycleSerial,
    pub(super) moves: bool,
    /// Where it goes to, if it goes to a place.
    goal: Option<[Coord; N]>,
    /// What is on offer, and from when on.
    pub(super) offered: Plan<N>,
    pub(super) begins: CycleSerial,
    /// What it was made for.
    pub(super) offered_for: Asked<N>,
    /// What no plan has been made for.
    pub(super) asked: Asked<N>,
    /// The last cancel and the last hold that have been answered, and whether the motion was held then.
    pub(super) cancels: u32,
    holds: u32,
    held: bool,
    /// Whether an abort has been answered by a stop.
    pub(super) aborted: bool,
    /// Servo cycles after which a plan branches off a motion, and whether the last one came too late.
    pub(super) reaction: u32,
    refused: bool,
    /// What probes and homing have in common, and each of them.
    #[cfg(feature = "probe")]
    pub(super) seeking: Seeking<N>,
    #[cfg(feature = "probe")]
    pub(super) probing: Probing<N>,
    #[cfg(feature = "home")]
    pub(super) homing: Homing<N>,
}

impl<const N: usize> Jogging<N> {
    /// The memory of none.
    pub const NONE: Self = Self {
        on: On::No,
        home: [Coord::ZERO; N],
        agreed: Plan::EMPTY,
        began: CycleSerial::ZERO,
        moves: false,
        goal: None,
        offered: Plan::EMPTY,
        begins: CycleSerial::ZERO,
        offered_for: Asked::Nothing,
        asked: Asked::Nothing,
        cancels: 0,
        holds: 0,
        held: false,
        aborted: false,
        reaction: 0,
        refused: false,
        #[cfg(feature = "probe")]
        seeking: Seeking::NONE,
        #[cfg(feature = "probe")]
        probing: Probing::NONE,
        #[cfg(feature = "home")]
        homing: Homing::NONE,
    };

    /// Forgets it.
    pub fn clear(&mut self) {
        (self.on, self.reaction, self.refused) = (On::No, 0, false);
        #[cfg(feature = "probe")]
        self.probing.clear();
        #[cfg(feature = "home")]
        self.homing.clear();
    }

    /// Whether there is one.
    pub fn is_on(&self) -> bool {
        self.on != On::No
    }

    /// Whether there is one outside a program.
    pub fn is_free(&self) -> bool {
        self.on == On::Free
    }

    /// Begins, with the path at rest at a place.
    pub(super) fn begin(&mut self, on: On, home: [Coord; N], requests: &Requests) {
        (self.on, self.home) = (on, home);
        self.agreed = Plan::rest(&home);
        (self.asked, self.offered_for) = (Asked::Nothing, Asked::Nothing);
        (self.moves, self.aborted, self.goal) = (false, false, None);
        (self.cancels, self.holds) = (requests.cancels(), requests.holds());
        self.held = requests.read().holds();
    }

    /// The place from which a step counts, if it is known.
    fn bound_for(&self) -> Option<[Coord; N]> {
        match (&self.asked, &self.offered_for) {
            (Asked::Place(to, _), _) | (Asked::Nothing, Asked::Place(to, _)) => Some(*to),
            (Asked::Nothing, Asked::Nothing) if self.moves => self.goal,
            (Asked::Nothing, Asked::Nothing) => Some(self.agreed.end()),
            _ => None,
        }
    }
}

/// Moved by a distance.
fn moved<const N: usize>(from: &[Coord; N], by: &[Coord; N]) -> [Coord; N] {
    from_fn(|i| Coord::from_raw(from[i].raw().saturating_add(by[i].raw())))
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Takes a jog (feature `jog`): it is planned by the next [`Planner::poll`] and begins in the servo cycle after that. From rest
    /// with nothing to run, or from a hold within a program; while one is under way, the newest counts.
    ///
    /// With nothing to run, [`Planner::push`] finds no room until the machine rests again, and [`Planner::end`] is then where it
    /// stands. In a held program the machine stays held, whatever is resumed, until a jog ends exactly where it was held
    /// ([`Jog::Back`]), and then until it is resumed. [`Controls::cancel_jog`](crate::Controls::cancel_jog), a hold and an abort
    /// end a jog as soon as the limits allow; overrides do not change it, but one of 0 is a hold.
    ///
    /// Cost: that of a few comparisons per axis; the poll that plans it looks at every axis once, for a bounded number of durations.
    ///
    /// # Errors
    /// [`JogError`]; nothing has changed.
    pub fn jog(&mut self, jog: &Jog<S, N>) -> Result<(), JogError> {
        jog.check()?;
        if self.is_aborted() {
            return Err(JogError::Aborted);
        }
        #[cfg(feature = "probe")]
        if self.is_seeking() {
            return Err(JogError::Running);
        }
        let begins = if self.jogging.is_on() { None } else { Some(self.may_jog()?) };
        let cycle = self.horizon.config.cycle.to_f64();
        let home = match begins {
            Some((_, home)) => home,
            None => self.jogging.home,
        };
        let per_cycle = |feed: S| feed.to_f64() * cycle;
        let held = begins.map_or(self.jogging.on, |(on, _)| on) == On::Held;
        let asked = match jog {
            Jog::Velocity { velocity, time } => {
                let hold = (time.to_f64() / cycle) as u32;
                Asked::Velocity(velocity.map(per_cycle), hold.max(1))
            }
            Jog::To { to, feed } => {
                self.inside(to)?;
                self.lasts(&self.stands(), to, *feed)?;
                Asked::Place(*to, per_cycle(*feed))
            }
            Jog::Back { .. } if !held => return Err(JogError::NoProgram),
            Jog::Back { feed } => {
                self.lasts(&self.stands(), &home, *feed)?;
                Asked::Place(home, per_cycle(*feed))
            }
            Jog::Step { by, feed } => {
                let from = if begins.is_some() { Some(home) } else { self.jogging.bound_for() };
                let stands = self.stands();
                self.lasts(&stands, &moved(&stands, by), *feed)?;
                let feed = per_cycle(*feed);
                match (from, &self.jogging.asked) {
                    (Some(from), _) => self.clipped(&from, by, feed),
                    (None, Asked::Step(before, _)) => Asked::Step(moved(before, by), feed),
                    (None, _) => Asked::Step(*by, feed),
                }
            }
        };
        if let Some((on, home)) = begins {
            self.jogging.begin(on, home, self.requests);
            if on == On::Held {
                self.phase = Phase::Resting(Rest::AwaitsResume);
            }
        }
        // The newest counts: a cancel from before is not meant for it. A hold is: what an operator's device sends again
        // and again must not outrun the hand that stops the machine.
        self.jogging.cancels = self.requests.cancels();
        self.jogging.asked = asked;
        Ok(())
    }

    /// Whether a jog may begin now: what of, and where.
    pub(super) fn may_jog(&self) -> Result<(On, [Coord; N]), JogError> {
        let Phase::Resting(rest) = self.phase else { return Err(JogError::Running) };
        let Some(here) = self.horizon.window.get(self.horizon.end_index()) else {
            return Err(JogError::Running);
        };
        if self.side.progress() != self.horizon.end()
            || self.making.is_some()
            || !self.has_settled()
        {
            return Err(JogError::Running);
        }
        let is_free = self.last_node() == self.horizon.end() && self.builder.len() == 0;
        let wish = self.requests.read();
        if is_free {
            Ok((On::Free, here.node.at))
        } else if wish.holds() || wish.stop || rest == Rest::AwaitsResume {
            Ok((On::Held, here.node.at))
        } else {
            Err(JogError::Running)
        }
    }

    /// Whether a point lies inside the limits of travel.
    pub(super) fn inside(&self, to: &[Coord; N]) -> Result<(), JogError> {
        for (axis, at) in to.iter().enumerate() {
            let (least, greatest) = travel(&self.horizon.config, axis);
            if *at < least || *at > greatest {
                let error = Range::new(least.to_mm(), greatest.to_mm()).refused(at.to_mm());
                return Err(JogError::Travel { axis, error });
            }
        }
        Ok(())
    }

    /// Whether the way from a place to another takes no longer than can be counted in servo cycles.
    pub(super) fn lasts(
        &self,
        from: &[Coord; N],
        to: &[Coord; N],
        feed: S,
    ) -> Result<(), JogError> {
        let way = to.iter().zip(from).fold(0.0, |most: f64, (to, at)| {
            let way: f64 = to.minus(*at);
            most.max(way.abs())
        });
        let most = f64::from(MOST_CYCLES / 4) * self.horizon.config.cycle.to_f64();
        let Range { least, greatest } = Quantity::Feed.range();
        let (least, feed) = (least.max(way / most), feed.to_f64());
        if feed < least {
            let error = Range::new(least, greatest).refused(feed);
            return Err(JogError::OutOfRange { quantity: Quantity::Feed, error });
        }
        Ok(())
    }

    /// Whether a jog is on (feature `jog`): it moves, or the machine is away from where its program was held.
    pub fn is_jogging(&self) -> bool {
        self.jogging.is_on()
    }

    /// Where the machine rests, or will when the jog under way is over (feature `jog`).
    pub fn jog_end(&self) -> [Coord; N] {
        self.jogging.bound_for().filter(|_| self.jogging.is_on()).unwrap_or_else(|| self.stands())
    }

    /// Where the machine stands, or will when the jog under way is over.
    fn stands(&self) -> [Coord; N] {
        if self.jogging.is_on() {
            return self.jogging.agreed.end();
        }
        let here = self.horizon.window.get(self.horizon.end_index());
        here.map_or([Coord::ZERO; N], |here| here.node.at)
    }

    /// By a distance from a place, but not out of the limits of travel; from outside, no further out.
    fn clipped(&self, from: &[Coord; N], by: &[Coord; N], feed: f64) -> Asked<N> {
        let mut to = moved(from, by);
        for (axis, (to, from)) in to.iter_mut().zip(from).enumerate() {
            let (least, greatest) = travel(&self.horizon.config, axis);
            *to = (*to).max(least.min(*from)).min(greatest.max(*from));
        }
        Asked::Place(to, feed)
    }

    /// Does what is to be done for a jog that is on. `None`: it has ended.
    #[inline(never)]
    pub(super) fn poll_jog(&mut self) -> Option<Progress> {
        let wish = self.requests.read();
        // What is resumed away from the path is not meant for it.
        self.answered.resumes = wish.resumes;
        if !matches!(self.jogging.offered_for, Asked::Nothing) && !self.hear_of_jog() {
            return Some(Progress::Waiting);
        }
        self.note_stops(&wish);
        let rests = self.jogging.moves
            && self.side.timeline().is_some_and(|now| now.serial == self.horizon.end());
        #[cfg(feature = "probe")]
        self.note_edge(&wish, rests);
        if rests {
            let end = self.jogging.agreed.end();
            self.jogging.agreed = Plan::rest(&end);
            self.jogging.moves = false;
        }
        if !self.jogging.moves && matches!(self.jogging.asked, Asked::Stop) {
            self.jogging.asked = Asked::Nothing;
        }
        #[cfg(feature = "probe")]
        if let Some(progress) = self.seek_waits(&wish) {
            return Some(progress);
        }
        if !matches!(self.jogging.asked, Asked::Nothing) {
            return Some(self.plan_jog());
        }
        if self.jogging.moves { Some(Progress::Waiting) } else { self.end_jog(&wish) }
    }

    /// The interrupt's word on what is on offer. Whether it has been said.
    fn hear_of_jog(&mut self) -> bool {
        let Some(taken) = self.side.verdict() else { return false };
        #[cfg(feature = "probe")]
        if taken {
            self.leave_plan();
        }
        #[cfg(feature = "home")]
        if taken {
            self.note_home_plan();
        }
        let jogging = &mut *self.jogging;
        let offered_for = core::mem::replace(&mut jogging.offered_for, Asked::Nothing);
        jogging.refused = !taken;
        if taken {
            jogging.agreed = jogging.offered.clone();
            (jogging.began, jogging.moves) = (jogging.begins, true);
            jogging.goal = match offered_for {
                Asked::Place(to, _) => Some(to),
                _ => None,
            };
        } else {
            if matches!(jogging.asked, Asked::Nothing) {
                jogging.asked = offered_for;
            }
            self.counters.late += 1;
            self.jogging.reaction = (2 * self.jogging.reaction + 1).min(self.most_reaction());
        }
        true
    }

    /// A cancel, a new hold or an abort ends what is under way.
    fn note_stops(&mut self, wish: &Wish) {
        #[cfg(feature = "probe")]
        if self.is_seeking() {
            return self.note_stops_of_seek(wish);
        }
        let (cancels, holds) = (self.requests.cancels(), self.requests.holds());
        let jogging = &mut *self.jogging;
        let pressed = cancels != jogging.cancels || holds != jogging.holds;
        let stops = pressed || (wish.holds() && !jogging.held);
        (jogging.cancels, jogging.holds, jogging.held) = (cancels, holds, wish.holds());
        let aborts = wish.aborts != self.answered.aborts && !jogging.aborted;
        jogging.aborted |= aborts;
        if stops || aborts {
            jogging.asked = Asked::Stop;
        }
    }

    /// Makes a plan for what is asked for, and offers it.
    fn plan_jog(&mut self) -> Progress {
        let now = self.side.cycles();
        let branch = now.plus(self.jogging.reaction);
        let jogging = &mut *self.jogging;
        let from = if jogging.moves {
            jogging.agreed.tail(branch.since(jogging.began).unwrap_or(0))
        } else {
            jogging.agreed.clone()
        };
        let asked = core::mem::replace(&mut jogging.asked, Asked::Nothing);
        let asked = match asked {
            Asked::Step(by, feed) => {
                let places = from.stop_places(&self.horizon.config);
                self.clipped(&places, &by, feed)
            }
            Asked::Velocity(velocity, hold) => Asked::Until(velocity, now.plus(hold)),
            Asked::Until(_, until) if !now.is_before(until) => Asked::Stop,
            asked => asked,
        };
        #[cfg(feature = "home")]
        if let Asked::Set(to) = asked {
            return self.plan_set(&to);
        }
        let aim = match asked {
            Asked::Until(velocity, until) => Aim::Velocity(velocity, until.since(now).unwrap_or(0)),
            Asked::Place(to, feed) => Aim::Place(to, feed),
            #[cfg(feature = "home")]
            Asked::Each(aims) => Aim::Each(aims),
            _ => Aim::Stop,
        };
        let mut planned = match asked {
            #[cfg(feature = "probe")]
            Asked::Halt => self.halted(&from),
            _ => from.turned(&aim, &self.horizon.config),
        };
        if !planned.plan.fits(NODES) {
            // Of many axes in motion, each by itself: from rest it fits.
            let stop = Aim::Stop;
            #[cfg(feature = "home")]
            let stop = if self.is_homing() { Aim::Each([AxisAim::Halt; N]) } else { stop };
            planned = from.turned(&stop, &self.horizon.config);
            planned.whole = false;
        }
        let Planned { plan, whole } = planned;
        let jogging = &mut *self.jogging;
        if let Aim::Place(to, _) = aim
            && jogging.moves
            && whole
            && from.end() == to
            && from.total() <= ENDING.min(plan.total())
        {
            // Asked for again and again, it would come nearer for ever.
            return Progress::Waiting;
        }
        let nothing = plan.total() == 0;
        if nothing || plan.is_too_long() || !plan.fits(NODES) {
            if jogging.moves && !whole {
                jogging.asked = asked;
            }
            return if jogging.moves { Progress::Waiting } else { Progress::Planning };
        }
        #[cfg(feature = "home")]
        jogging.homing.set_whole(whole);
        if !whole {
            jogging.asked = asked;
        }
        let frame = self.jog_frame();
        plan.pieces(&frame, NODES, |piece| self.side.write(piece));
        // What it took this time the next will take: a stop is not planned in vain first.
        let taken = self.side.cycles().since(now).unwrap_or(0);
        if taken > 0 {
            let reaction = self.jogging.reaction.max(taken + 1);
            self.jogging.reaction = reaction.min(self.most_reaction());
        }
        // From rest it may begin at any time: however long it was being made, the next servo cycle will do.
        let when = if self.jogging.moves {
            branch
        } else {
            let later = if self.jogging.refused { self.jogging.reaction } else { 0 };
            self.side.cycles().plus(later)
        };
        #[cfg(feature = "outputs")]
        self.time_switches(Branch::Cycle(when));
        self.side.offer(Branch::Cycle(when));
        self.jogging.offered = plan;
        self.jogging.begins = when;
        self.jogging.offered_for = asked;
        self.counters.plans += 1;
        Progress::Planned
    }

    /// What the pieces of a jog have in common.
    pub(super) fn jog_frame(&self) -> Frame<S> {
        let here = self.horizon.window.get(self.horizon.end_index());
        Frame {
            serial: self.horizon.end().previous(),
            tag: here.map_or(0, |here| here.cell.programmed.tag),
            arc_length: here.map_or(ArcLength::ZERO, |here| here.arc_length),
            cycle: self.horizon.config.cycle,
        }
    }

    /// At rest, and nothing is asked for.
    fn end_jog(&mut self, wish: &Wish) -> Option<Progress> {
        let place = self.jogging.agreed.end();
        let aborted = wish.aborts != self.answered.aborts;
        let away = place != self.jogging.home;
        if self.jogging.is_free() || aborted {
            if away {
                self.begin_at(place);
            }
        } else if away {
            return Some(Progress::Held);
        }
        self.jogging.on = On::No;
        None
    }

    /// The path rests at another place: what is left of it is dropped.
    fn begin_at(&mut self, place: [Coord; N]) {
        let end = self.horizon.end_index();
        self.horizon.window.truncate(end);
        if let Some(station) = self.horizon.window.last_mut() {
            station.node.at = place;
        }
        self.builder.restart(place);
    }
}
