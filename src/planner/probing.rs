//! Probes: jogs to a place that end early on an input.
//!
//! The edge is latched by [`Inputs::tell`](crate::Inputs::tell) with its time; the next poll works out where the axes were then, from
//! the very phases that the interrupt ran, and plans the stop, which begins in the servo cycle after that. A plan that takes over
//! meanwhile leaves behind what is needed for the cycle before it.
//!
//! | while it moves | at rest |
//! |---|---|
//! | its edge, a cancel or an abort: it stops | it is over |
//! | a hold, or an override of 0: it stops | it waits, and goes on to its target afterwards; an edge ends it there too |

use super::jogging::{Asked, On};
use super::phase::{Phase, Rest};
use super::{Planner, Progress};
use crate::jog::plan::{Plan, Planned};
use crate::jog::{Outcome, Overshoot, Probe, ProbeError, Probed};
use crate::machine::Quantity;
use crate::number::optional::Optional;
use crate::number::serial::CycleSerial;
use crate::number::vector::norm;
use crate::number::{Coord, Range, Scalar};
use crate::servo::control::Wish;
use crate::servo::input::EdgeTime;
use crate::servo::{Input, Inputs};
use core::array::from_fn;

/// Servo cycles from an edge to the beginning of its stop: what is left of the one in which it comes, and another if a poll has just
/// begun.
const WAIT: u32 = 2;

/// What probes and homing have in common.
#[derive(Clone, Debug)]
pub struct Seeking<const N: usize> {
    /// Jerks of the axes in the servo cycle before the plan under way.
    before: [f64; N],
    /// A cancel or an abort has come.
    pub cancelled: bool,
}

impl<const N: usize> Seeking<N> {
    /// The memory of none.
    pub const NONE: Self = Self { before: [0.0; N], cancelled: false };
}

/// A probe.
#[derive(Clone, Debug)]
pub struct Probing<const N: usize> {
    on: bool,
    input: Input,
    /// Where it ends without its edge, and how fast it goes there, mm per cycle.
    to: [Coord; N],
    feed: f64,
    /// Direction of the line under way.
    unit: [f64; N],
    /// Where the axes were at the edge.
    position: Option<[Coord; N]>,
    /// A stop has been asked for that leads to the next rest.
    stops: bool,
    /// What came of the last one.
    result: Optional<Probed<N>>,
}

impl<const N: usize> Probing<N> {
    /// The memory of none.
    pub const NONE: Self = Self {
        on: false,
        input: Input::Probe,
        to: [Coord::ZERO; N],
        feed: 0.0,
        unit: [0.0; N],
        position: None,
        stops: false,
        result: Optional::NONE,
    };

    /// Forgets it.
    pub fn clear(&mut self) {
        self.on = false;
        self.result.set(None);
    }
}

impl<'a, S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'a, S, N, BLOCKS, NODES>
{
    /// The handle of what sees the inputs (feature `probe`).
    pub fn inputs(&self) -> Inputs<'a> {
        self.side.inputs()
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Takes a probe (feature `probe`): a straight move that ends early on an input. It is planned by the next
    /// [`Planner::poll`] and begins in the servo cycle after that; the machine must rest with nothing to run. What came of it is in
    /// [`Planner::probed`] when it is over; until then [`Planner::push`] finds no room, and [`Planner::end`] is then where the machine
    /// stands.
    ///
    /// The edge counts from this call on. A hold stops the probe, and it goes on when that is resumed;
    /// [`Controls::cancel_jog`](crate::Controls::cancel_jog) and an abort end it. Overrides do not change it, but one of 0 is a hold. In
    /// single block mode the machine rests afterwards until a resume.
    ///
    /// Cost: that of a few comparisons per axis.
    ///
    /// # Errors
    /// [`ProbeError`]; nothing has changed.
    pub fn probe(&mut self, probe: &Probe<S, N>) -> Result<(), ProbeError> {
        probe.check()?;
        let here = self.rests_free()?;
        self.check_probe(probe, &here)?;
        let exists = !matches!(probe.input, Input::Home(axis) if axis >= N);
        if !(exists && self.side.lines().arm(probe.input, probe.closes)) {
            return Err(ProbeError::Input);
        }
        self.jogging.begin(On::Free, here, self.requests);
        self.jogging.seeking = Seeking::NONE;
        let feed = probe.feed.to_f64() * self.horizon.config.cycle.to_f64();
        self.jogging.probing =
            Probing { on: true, input: probe.input, to: probe.to, feed, ..Probing::NONE };
        Ok(())
    }

    /// Whether [`Planner::probe`] would take a probe that begins at a place, leaving its input and what the machine does aside (feature
    /// `probe`).
    ///
    /// Cost: that of a few comparisons per axis.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check_probe(&self, probe: &Probe<S, N>, from: &[Coord; N]) -> Result<(), ProbeError> {
        probe.check()?;
        self.inside(&probe.to)?;
        Ok(self.lasts(from, &probe.to, probe.feed)?)
    }

    /// Where the machine rests, if it does with nothing to run and nothing to hold it.
    pub(super) fn rests_free(&self) -> Result<[Coord; N], ProbeError> {
        if self.is_aborted() {
            return Err(ProbeError::Aborted);
        }
        if self.jogging.is_on() {
            return Err(ProbeError::Running);
        }
        let wish = self.requests.read();
        if wish.holds() || wish.stop || self.phase == Phase::Resting(Rest::AwaitsResume) {
            return Err(ProbeError::Held);
        }
        match self.may_jog()? {
            (On::Free, here) => Ok(here),
            _ => Err(ProbeError::Running),
        }
    }

    /// Whether a motion is on that an input ends.
    pub(super) fn is_seeking(&self) -> bool {
        #[cfg(feature = "home")]
        if self.is_homing() {
            return true;
        }
        self.is_probing()
    }

    /// Whether a probe is on (feature `probe`).
    pub fn is_probing(&self) -> bool {
        self.jogging.probing.on
    }

    /// What came of the last probe, once (feature `probe`). `None`: there is none, it is not over, or this has been said.
    pub fn probed(&mut self) -> Option<Probed<N>> {
        self.jogging.probing.result.take()
    }

    /// How far a probe in this direction at this feed goes on after its edge at the worst (feature `probe`): what is left of the
    /// servo cycle in which it comes, another if a poll was under way, as many as answers have been late by so far, and the stop.
    ///
    /// Cost: 17 stops of some two hundred operations.
    ///
    /// # Errors
    /// [`ProbeError::OutOfRange`]: the feed, or the length of the direction, is out of range.
    pub fn probe_overshoot(&self, feed: S, direction: &[S; N]) -> Result<Overshoot<S>, ProbeError> {
        Quantity::Feed
            .check(feed)
            .map_err(|error| ProbeError::OutOfRange { quantity: Quantity::Feed, error })?;
        let direction = direction.map(S::to_f64);
        let length = norm(&direction);
        let range = Range::new(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX));
        if let Err(error) = range.check(length) {
            return Err(ProbeError::OutOfRange { quantity: Quantity::Feed, error });
        }
        let config = &self.horizon.config;
        let feed = feed.to_f64() * config.cycle.to_f64();
        let wait = WAIT.saturating_add(self.jogging.reaction);
        Ok(Overshoot::new(&direction.map(|x| x / length), feed, wait, config))
    }

    /// The shortest stop of what is left of the plan.
    pub(super) fn halted(&self, from: &Plan<N>) -> Planned<N> {
        from.halted(&self.jogging.probing.unit, &self.horizon.config)
    }

    /// A plan takes over from the one under way.
    pub(super) fn leave_plan(&mut self) {
        if !self.is_seeking() {
            return;
        }
        let begins = self.jogging.begins;
        self.note_edges(Some(begins));
        self.note_jerks(begins.since(self.jogging.began).unwrap_or(0));
    }

    fn note_jerks(&mut self, cycles: u32) {
        let jogging = &mut *self.jogging;
        jogging.seeking.before = jogging.agreed.jerks_before(cycles);
    }

    /// Notes the edges that came before a servo cycle, at which a plan begins, or all.
    fn note_edges(&mut self, until: Option<CycleSerial>) {
        #[cfg(feature = "home")]
        self.note_home_edges(until);
        let probing = &self.jogging.probing;
        if probing.on
            && probing.position.is_none()
            && let Some(edge) = self.side.lines().latched(probing.input)
            && until.is_none_or(|until| edge.whole_since(until) < 0)
        {
            self.jogging.probing.position = Some(self.place_at_edge(edge));
        }
    }

    /// Where the axes were at an edge, by the plan under way.
    pub(super) fn place_at_edge(&self, edge: EdgeTime) -> [Coord; N] {
        let jogging = &*self.jogging;
        let whole = edge.whole_since(jogging.began);
        jogging.agreed.place_at(whole, edge.part(), &jogging.seeking.before)
    }

    /// A cancel or an abort ends a motion that an input ends.
    pub(super) fn note_stops_of_seek(&mut self, wish: &Wish) {
        let cancels = self.requests.cancels();
        let jogging = &mut *self.jogging;
        jogging.seeking.cancelled |=
            cancels != jogging.cancels || wish.aborts != self.answered.aborts;
        jogging.cancels = cancels;
    }

    /// Answers the edges that have come. `rests`: the plan under way has just been run to its end.
    pub(super) fn note_edge(&mut self, wish: &Wish, rests: bool) {
        if !self.is_seeking() {
            return;
        }
        self.note_edges(None);
        if rests {
            let total = self.jogging.agreed.total();
            self.note_jerks(total);
            self.jogging.began = self.jogging.began.plus(total);
        }
        if self.is_probing() {
            self.stop_probe(wish, rests);
        }
    }

    /// Stops a probe that has its edge, or is called off or held.
    fn stop_probe(&mut self, wish: &Wish, rests: bool) {
        let jogging = &mut *self.jogging;
        let probing = &mut jogging.probing;
        let stops = probing.position.is_some() || jogging.seeking.cancelled || wish.holds();
        if stops && jogging.moves && !rests {
            if !core::mem::replace(&mut probing.stops, true) {
                jogging.asked = Asked::Halt;
            }
        } else if stops || rests {
            jogging.asked = Asked::Nothing;
        }
    }

    /// What a motion that an input ends does next, if it is not what is asked for.
    pub(super) fn seek_waits(&mut self, wish: &Wish) -> Option<Progress> {
        #[cfg(feature = "home")]
        if self.is_homing() {
            return self.home_waits(wish);
        }
        self.probe_waits(wish).then_some(Progress::Held)
    }

    /// At rest: whether a probe waits there. If not it is over, or goes on.
    fn probe_waits(&mut self, wish: &Wish) -> bool {
        let jogging = &mut *self.jogging;
        let probing = &mut jogging.probing;
        if !probing.on || jogging.moves || !matches!(jogging.asked, Asked::Nothing) {
            return false;
        }
        probing.stops = false;
        let here = jogging.agreed.end();
        let outcome = if probing.position.is_some() {
            Outcome::Tripped
        } else if jogging.seeking.cancelled {
            Outcome::Cancelled
        } else if here == probing.to {
            Outcome::Missed
        } else {
            if !wish.holds() {
                let by: [f64; N] = from_fn(|i| probing.to[i].minus(here[i]));
                let length = norm(&by);
                probing.unit = by.map(|x| x / length);
                jogging.asked = Asked::Place(probing.to, probing.feed);
            }
            return wish.holds();
        };
        let position = probing.position.unwrap_or(here);
        probing.result.set(Some(Probed { position, outcome }));
        probing.on = false;
        self.side.lines().disarm(probing.input);
        if wish.single {
            self.phase = Phase::Resting(Rest::AwaitsResume);
        }
        false
    }
}
