//! The planning horizon: the window of path ahead of the motion, with the plan agreed on it and, while one is being
//! made or is on offer, the draft of the next.
//!
//! Nothing in here knows of the interrupt: what has been agreed is told by [`Horizon::commit`] and [`Horizon::drop_draft`],
//! and when it will be where by a [`Moment`].
//!
//! - [`draft`]: what a plan in the making has changed, kept or taken back.
//! - [`measure`]: times and distances.
//! - [`solve`]: states for a stretch.
//! - [`cutting`]: stations put in where the agreed motion will be.
//! - [`parting`]: stations put in anywhere, and taken out.

mod cutting;
mod draft;
mod measure;
mod parting;
mod solve;

pub use self::draft::ADDED;
use self::draft::Draft;
pub use self::solve::EXCESS;

use super::phase::Halt;
use crate::machine::{Config, LimitSets, OlderLimits, UNLIMITED};
#[cfg(feature = "limits")]
use crate::machine::{Limits, SetNumber};
use crate::number::Scalar;
use crate::number::optional::Optional;
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::path::node::{Cell, Node};
use crate::profile::bounds::Pace;
use crate::profile::clock::Clock;
use crate::profile::compile::{self, Placement};
use crate::profile::law::{Law, PathState};
use crate::profile::solver::{Solver, Stretch};
use crate::profile::window::{Station, Window};
#[cfg(feature = "reshape")]
use crate::profile::{barrier::Slack, bounds::Bounds, relaxation::Relaxation, rows::rows};
use crate::servo::control::Overrides;
use crate::servo::link::{Branch, Timeline};
use crate::servo::piece::{Piece, Sequel};
use core::ops::Range;

/// Where the motion is, and when an answer to a command can take effect.
#[derive(Clone, Copy, Debug)]
pub struct Moment<S> {
    /// The piece under way.
    pub timeline: Timeline<S>,
    /// Servo cycle at whose end the answer branches off.
    pub when: CycleSerial,
}

/// A draft that is ready to be offered.
#[derive(Clone, Copy, Debug)]
pub struct Proposal {
    /// What it runs through.
    pub stretch: Stretch,
    /// Where it leaves the agreed plan.
    pub branch: Branch,
    /// Why it ends where it does, if an operator has asked for it.
    pub halt: Option<Halt>,
}

/// Where a stop that is made in stages goes on ([`stages`](super::command::stages)), and how the clock of the agreed motion goes there.
#[derive(Clone, Copy, Debug)]
pub struct Handover<S> {
    pub node: NodeSerial,
    pub clock: Clock<S>,
    /// Servo cycle at whose end the motion is about there.
    pub when: CycleSerial,
}

impl<S: Scalar> Handover<S> {
    /// Nowhere: a node that is passed.
    pub const fn none(node: NodeSerial) -> Self {
        Self { node, clock: Clock::STOPPED, when: CycleSerial::ZERO }
    }
}

/// The window, and what is planned on it.
///
/// While there is no draft, every station up to the end of the agreed plan has the state of that plan, and every one
/// behind it rests.
pub struct Horizon<S: Scalar, const N: usize, const NODES: usize> {
    pub config: Config<S, N>,
    /// The limits of blocks that were taken before those of `config` came into effect.
    pub older: OlderLimits<S, N>,
    pub window: Window<S, N, NODES>,
    solver: Solver,
    /// Node at which the agreed plan ends.
    end: NodeSerial,
    /// Node up to which it is run by a clock that slows down.
    slowed: Option<NodeSerial>,
    /// Node up to which it slows down, or gathers speed, for overrides that it does not answer to in whole.
    eased: Option<NodeSerial>,
    /// Where a stop goes on in that.
    handover: Handover<S>,
    /// Overrides in effect.
    overrides: Overrides,
    draft: Optional<Draft<S, N>>,
    /// Improvement steps so far.
    pub steps: u32,
}

impl<S: Scalar, const N: usize, const NODES: usize> Horizon<S, N, NODES> {
    /// The memory of one: all zeros.
    pub const EMPTY: Self = Self {
        config: Config::UNSET,
        older: OlderLimits::NONE,
        window: Window::EMPTY,
        solver: Solver::new(),
        end: NodeSerial::ZERO,
        slowed: None,
        eased: None,
        handover: Handover::none(NodeSerial::ZERO),
        overrides: Overrides { feed: 0, rapid: 0 },
        draft: Optional::NONE,
        steps: 0,
    };

    /// Forgets everything, and rests at a node, whose running number is `first`.
    pub fn begin(&mut self, config: &Config<S, N>, node: Node<S, N>, first: NodeSerial) {
        self.config = *config;
        self.config.limit(&config.limits);
        self.config.stop_limits = config.stop_limits.map(|stops| config.bearable(&stops));
        self.older = OlderLimits::NONE;
        self.window.begin(node, first);
        self.end = first;
        (self.slowed, self.eased) = (None, None);
        self.overrides = Overrides::PROGRAMMED;
        self.draft.set(None);
        self.steps = 0;
    }

    /// Node at which the agreed plan ends.
    pub fn end(&self) -> NodeSerial {
        self.end
    }

    /// Index of the station there: it is not released before the motion has passed it.
    #[inline(never)]
    pub fn end_index(&self) -> usize {
        debug_assert!(self.window.find(self.end).is_some());
        self.window.clamped_index(self.end)
    }

    /// Whether the motion from a node on is run by a clock that slows down: what is known of it is its states at nodes,
    /// not what it does between them.
    pub fn is_slowed(&self, at: NodeSerial) -> bool {
        self.slowed.is_some_and(|end| at.is_before(end))
    }

    /// Whether the agreed motion is a whole answer to overrides.
    pub fn is_paced(&self, overrides: Overrides) -> bool {
        self.overrides == overrides && !self.is_eased()
    }

    /// Whether it answers to overrides in part only: a whole answer is owed, whatever they are by now.
    pub fn is_eased(&self) -> bool {
        self.eased.is_some()
    }

    /// Cells from where such a part has come to its speed to the end of the agreed plan.
    pub fn cells_behind_easing(&self) -> Option<usize> {
        self.eased.map(|node| self.end_index().saturating_sub(self.window.clamped_index(node)))
    }

    /// The agreed motion has begun to slow down for a stop that is called off, and goes evenly at what it has come down to: up to the end of
    /// what is known there is no other plan ahead, and what it is asked for is owed.
    pub fn owe_pace(&mut self, at: NodeSerial) {
        debug_assert!(!self.has_draft());
        self.eased = Some(self.even_from(at).unwrap_or(at));
    }

    /// Where the next stage of a stop goes on, with the motion at a node.
    pub fn handover(&self, at: NodeSerial) -> Option<Handover<S>> {
        let Handover { node, .. } = self.handover;
        let lies_within = self.slowed.is_some_and(|end| node.is_before(end));
        (lies_within && at.is_before(node)).then_some(self.handover)
    }

    /// Whether the motion at a node is run by a clock that slows down until it rests.
    pub fn slows_to_rest(&self, at: NodeSerial) -> bool {
        self.is_slowed(at) && self.slowed == Some(self.end)
    }

    /// Node from which on the agreed motion is run by a clock of its own no more, if that is ahead of a node.
    pub fn even_from(&self, at: NodeSerial) -> Option<NodeSerial> {
        self.slowed.filter(|end| at.is_before(*end))
    }

    /// Overrides in effect.
    pub fn overrides(&self) -> Overrides {
        self.overrides
    }

    /// Puts other overrides into effect, on all cells.
    pub fn set_overrides(&mut self, overrides: Overrides) {
        (self.overrides, self.eased) = (overrides, None);
        self.bound_from(0);
    }

    /// Puts other overrides into effect in the draft, on no cell yet.
    pub fn try_overrides(&mut self, overrides: Overrides) {
        debug_assert!(self.has_draft());
        (self.overrides, self.eased) = (overrides, None);
    }

    /// Other limits for the blocks to come. Whether there was room for those in effect now.
    #[cfg(feature = "limits")]
    pub fn set_limits(&mut self, limits: Limits<S, N>) -> bool {
        let first = self.window.get(0).map_or(SetNumber::FIRST, |from| from.cell.programmed.limits);
        let kept = self.older.keep(&self.config, first);
        if kept {
            self.config.limit(&limits);
        }
        kept
    }

    /// Adds a cell behind the last station; the new last station rests.
    pub fn append(&mut self, cell: Cell<S, N>, node: Node<S, N>, rest: bool) {
        let pace = pace(&self.config, &self.older, self.overrides);
        self.window.append(cell, node, rest, &pace);
    }

    /// Bounds of the cell of station `i` anew, at the pace that is set.
    #[inline(never)]
    pub fn bound(&mut self, i: usize) {
        let pace = pace(&self.config, &self.older, self.overrides);
        self.window.bound(i, &pace);
    }

    /// The same of all cells from station `first` on.
    pub fn bound_from(&mut self, first: usize) {
        let pace = pace(&self.config, &self.older, self.overrides);
        for i in first..self.window.len() {
            self.window.bound(i, &pace);
        }
    }

    /// The greatest path speed, mm/s, that the axes allow over a cell at any feed.
    fn speed_of_axes(&self, i: usize) -> S {
        let any = S::of(UNLIMITED);
        let pace = pace(&self.config, &self.older, self.overrides);
        self.window.bounds(i, &Pace { feed: any, rapid: any, ..pace }).map_or(any, |of| of.speed)
    }

    /// The speed, mm/s, that is asked for over a cell at other overrides; of those that are raised, the one before.
    pub fn goal_at(&self, i: usize, overrides: Overrides) -> Option<S> {
        let pace = pace(&self.config, &self.older, overrides);
        let station = self.window.get(i)?;
        let known = station.bounds.goal_at(&station.cell, &pace);
        known.or_else(|| self.window.bounds(i, &pace).map(|of| of.goal))
    }

    /// Pieces of a proposal, over some of its cells, in order. When the last is made, every station behind its end
    /// rests in the draft.
    pub fn compile(
        &mut self,
        stretch: Stretch,
        cells: Range<usize>,
        mut hand_over: impl FnMut(&Piece<S, N>),
    ) {
        debug_assert!(self.has_draft());
        if cells.start == stretch.first {
            debug_assert!(self.keeps_limits(stretch), "a plan beyond a limit");
            self.window.measure(stretch.first);
        }
        for i in cells.clone() {
            let Some(after) = self.window.get(i + 1) else { break };
            let at_end = i + 1 == stretch.last;
            let sequel = if after.rest || (at_end && !stretch.open) {
                Sequel::Stop
            } else if at_end {
                Sequel::Starved
            } else {
                Sequel::Motion
            };
            let to = if at_end { PathState::REST } else { after.state };
            let piece = self.piece(i, to, sequel);
            debug_assert!(piece.is_some(), "a plan without motion over cell {i}");
            let Some(piece) = piece else { break };
            hand_over(&piece);
        }
        if cells.end == stretch.last {
            for i in stretch.last..self.window.len() {
                self.window.set_state(i, PathState::REST);
            }
        }
    }

    /// The motion over a cell as it stands in the draft.
    fn piece(&self, i: usize, to: PathState<S>, sequel: Sequel) -> Option<Piece<S, N>> {
        self.piece_between(i, [self.window.get(i)?.state, to], sequel)
    }

    /// The motion over a cell as it stands in the draft, between two stations of it.
    #[cfg(feature = "reshape")]
    pub fn piece_within(&self, i: usize) -> Option<Piece<S, N>> {
        self.piece(i, self.window.get(i + 1)?.state, Sequel::Motion)
    }

    /// The motion over a cell as agreed.
    #[inline(never)]
    pub fn agreed_piece(&self, i: usize) -> Option<Piece<S, N>> {
        let (station, after) = self.window.pair(i)?;
        self.piece_between(i, [station.agreed, after.agreed], Sequel::Motion)
    }

    /// Bounds the cell from a station that is not in the window to another, and says whether the agreed motion keeps all limits.
    #[cfg(feature = "reshape")]
    pub fn keeps(&self, station: &mut Station<S, N>, after: &Station<S, N>) -> bool {
        let pace = pace(&self.config, &self.older, self.overrides);
        station.bounds = Bounds::new(&station.node, &station.cell, &after.node, &pace);
        let Some(law) = Law::new(station.cell.length, station.state, after.state) else {
            return false;
        };
        let [early, late] = law.inner_speeds();
        let most = law.v0.greatest(law.v1).greatest(early.greatest(late));
        if !(most <= station.bounds.speed * S::of(1.002)) {
            return false;
        }
        station.bounds.speed = station.bounds.speed.greatest(most * S::of(1.0001));
        let mut slack = Slack::new(Relaxation::STRICT);
        rows(&station.view(after, LimitSets::new(&self.config, &self.older)), &law, &mut slack);
        !slack.is_broken()
    }

    /// Puts other stations, with what is agreed for them, in the place of some from a node on.
    #[cfg(feature = "reshape")]
    pub fn replace(&mut self, first: NodeSerial, replaced: usize, stations: &[Station<S, N>]) {
        let i = self.window.clamped_index(first);
        self.window.replace(i..i + replaced, stations);
        self.window.measure(i);
    }

    #[inline(never)]
    fn piece_between(
        &self,
        i: usize,
        states: [PathState<S>; 2],
        sequel: Sequel,
    ) -> Option<Piece<S, N>> {
        let (station, after) = self.window.pair(i)?;
        let (serial, arc_length) = (self.window.serial(i), station.arc_length);
        self.piece_of([station, after], states, Placement { serial, arc_length, sequel })
    }

    /// The motion from a station to another, with states at both, in a place.
    pub fn piece_of(
        &self,
        [station, after]: [&Station<S, N>; 2],
        [from, to]: [PathState<S>; 2],
        placement: Placement,
    ) -> Option<Piece<S, N>> {
        let view = station.view(after, LimitSets::new(&self.config, &self.older));
        if !(station.cell.length > S::ZERO) {
            return Some(compile::standstill(&view, placement));
        }
        let law = Law::new(station.cell.length, from, to)?;
        Some(compile::piece(&view, &law, placement))
    }
}

/// How fast the machine may go, and is asked to.
fn pace<'a, S: Scalar, const N: usize>(
    config: &'a Config<S, N>,
    older: &'a OlderLimits<S, N>,
    overrides: Overrides,
) -> Pace<'a, S, N> {
    let factor = |percent: u16| S::from_u32(u32::from(percent.max(1))) * S::of(0.01);
    Pace {
        limits: LimitSets::new(config, older),
        cycle: config.cycle,
        feed: factor(overrides.feed),
        rapid: factor(overrides.rapid),
    }
}
