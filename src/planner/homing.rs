//! Homing: several axes on their way to their switches, each by itself, and the coordinates set at the end.
//!
//! What an axis shall do comes from [`crate::jog::homing`]; here is what all of them have in common: one plan, the edges, an operator.
//! The coordinates are set as everything else is done: by a plan, of one piece that stands still in the new place, so setpoints change
//! over in one servo cycle ([`Activity::Set`](crate::Activity::Set)).

use super::jogging::{Asked, On};
use super::probing::Seeking;
use super::{Planner, Progress};
use crate::block::range::check_coordinates;
use crate::jog::homing::{AxisAim, AxisHome, AxisHoming, HomeFailure, HomeFault, HomePhase};
use crate::jog::plan::{MOST_CYCLES, Plan};
use crate::jog::{JogError, ProbeError};
use crate::machine::Quantity;
use crate::number::optional::Optional;
use crate::number::serial::CycleSerial;
use crate::number::{Coord, Range, Scalar};
use crate::servo::Input;
use crate::servo::control::Wish;
use crate::servo::input::EdgeTime;
use crate::servo::link::Branch;
use core::array::from_fn;

/// Homing, and the setting of coordinates.
#[derive(Clone, Debug)]
pub struct Homing<const N: usize> {
    on: bool,
    axes: [AxisHoming; N],
    /// Coordinates that are to be set, and whether they have been.
    new: Option<[Coord; N]>,
    is_set: bool,
    /// Whether the plan on offer does all that it was made for.
    whole: bool,
    failed: Optional<HomeFailure>,
    /// What came of the last.
    result: Optional<Result<(), HomeFailure>>,
}

impl<const N: usize> Homing<N> {
    /// The memory of none.
    pub const NONE: Self = Self {
        on: false,
        axes: [AxisHoming::NONE; N],
        new: None,
        is_set: false,
        whole: false,
        failed: Optional::NONE,
        result: Optional::NONE,
    };

    /// Whether the plan on offer does all that it was made for.
    pub fn set_whole(&mut self, whole: bool) {
        self.whole = whole;
    }

    /// Forgets it.
    pub fn clear(&mut self) {
        self.on = false;
        self.result.set(None);
    }

    /// The order of the axes whose turn it is; `None`: all are done.
    fn turn(&self) -> Option<u8> {
        let busy = |homing: &&AxisHoming| homing.phase() != HomePhase::Done;
        self.axes.iter().filter(busy).map(AxisHoming::order).min()
    }

    /// Something has gone wrong with the first axis that has something to do.
    fn fail_first(&mut self, fault: HomeFault) {
        let busy = |homing: &AxisHoming| homing.phase() != HomePhase::Done;
        let axis = self.axes.iter().position(busy).unwrap_or(0);
        let phase = self.axes.get(axis).map_or(HomePhase::Done, AxisHoming::phase);
        self.fail(HomeFailure { axis, phase, fault });
    }

    /// What has gone wrong first counts.
    fn fail(&mut self, failure: HomeFailure) {
        if !self.failed.is_some() {
            self.failed.set(Some(failure));
        }
    }
}

impl<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>
    Planner<'_, S, N, BLOCKS, NODES>
{
    /// Homes axes (feature `home`): each that is named goes to its switch, back, to it again slowly, and the coordinate of its edge then
    /// is the one it is told to be. The machine must rest with nothing to run; [`Planner::homed`] says what came of it.
    ///
    /// Limits of travel do not count meanwhile, for coordinates are not known. A hold stops all axes, and they go on when it is
    /// resumed; [`Controls::cancel_jog`](crate::Controls::cancel_jog) and an abort end it, and so does an axis whose switch does not close
    /// or open: then all axes stop, and the coordinates are as they were.
    ///
    /// When all are done the coordinates change, at rest: setpoints are the new ones from the one with
    /// [`Activity::Set`](crate::Activity::Set) on.
    ///
    /// # Errors
    /// [`ProbeError`]; nothing has changed.
    pub fn home(&mut self, axes: &[Option<AxisHome<S>>; N]) -> Result<(), ProbeError> {
        let here = self.rests_free()?;
        let cycle = self.horizon.config.cycle.to_f64();
        let mut homing = Homing { on: true, ..Homing::NONE };
        for (axis, (slot, home)) in homing.axes.iter_mut().zip(axes).enumerate() {
            let Some(home) = home else { continue };
            let from = here.get(axis).copied().unwrap_or_default();
            check(home, axis, from, cycle)?;
            let home = AxisHome {
                fast: home.fast.to_f64(),
                slow: home.slow.to_f64(),
                reach: home.reach,
                back: home.back,
                at: home.at,
                park: home.park,
                order: home.order,
            };
            *slot = AxisHoming::new(&home, cycle);
        }
        self.begin_homing(here, homing);
        Ok(())
    }

    /// Sets the coordinates of where the machine stands (feature `home`), which must be at rest with nothing to run. Setpoints
    /// are the new ones from the one with [`Activity::Set`](crate::Activity::Set) on; [`Planner::homed`] says when it is done.
    ///
    /// # Errors
    /// [`ProbeError`]; nothing has changed.
    pub fn set_position(&mut self, to: &[Coord; N]) -> Result<(), ProbeError> {
        check_coordinates(to).map_err(JogError::from)?;
        let here = self.rests_free()?;
        self.begin_homing(here, Homing { on: true, new: Some(*to), ..Homing::NONE });
        Ok(())
    }

    fn begin_homing(&mut self, here: [Coord; N], homing: Homing<N>) {
        self.jogging.begin(On::Free, here, self.requests);
        self.jogging.seeking = Seeking::NONE;
        self.jogging.homing = homing;
    }

    /// Whether axes are being homed, or coordinates set (feature `home`).
    pub fn is_homing(&self) -> bool {
        self.jogging.homing.on
    }

    /// What came of the last [`Planner::home`] or [`Planner::set_position`], once (feature `home`). `None`: there is none, it is not over,
    /// or this has been said.
    pub fn homed(&mut self) -> Option<Result<(), HomeFailure>> {
        self.jogging.homing.result.take()
    }

    /// What an axis does while it is homed (feature `home`).
    pub fn home_phase(&self, axis: usize) -> HomePhase {
        self.jogging.homing.axes.get(axis).map_or(HomePhase::Done, AxisHoming::phase)
    }

    /// When the switch of an axis closed for which it waits.
    fn home_edge(&self, axis: usize) -> Option<EdgeTime> {
        let homing = &self.jogging.homing;
        let seeks = homing.on && homing.axes.get(axis).is_some_and(AxisHoming::seeks);
        if seeks { self.side.lines().latched(Input::Home(axis)) } else { None }
    }

    /// Notes the edges that came before `until`, a plan's beginning, or all.
    pub(super) fn note_home_edges(&mut self, until: Option<CycleSerial>) {
        for axis in 0..N {
            let Some(edge) = self.home_edge(axis) else { continue };
            if until.is_some_and(|until| edge.whole_since(until) >= 0) {
                continue;
            }
            let place = self.place_at_edge(edge);
            self.side.lines().disarm(Input::Home(axis));
            if let (Some(homing), Some(place)) =
                (self.jogging.homing.axes.get_mut(axis), place.get(axis))
            {
                homing.found(*place);
            }
        }
    }

    /// The plan on offer has been taken.
    pub(super) fn note_home_plan(&mut self) {
        let jogging = &mut *self.jogging;
        match jogging.offered_for {
            Asked::Each(aims) if jogging.homing.whole => {
                for (homing, aim) in jogging.homing.axes.iter_mut().zip(aims) {
                    homing.set_planned(aim);
                }
            }
            Asked::Set(_) => jogging.homing.is_set = true,
            _ => {}
        }
    }

    /// What is to be done next for axes that are homed. `None`: what is asked for, or it is over.
    pub(super) fn home_waits(&mut self, wish: &Wish) -> Option<Progress> {
        if !self.is_homing() {
            return None;
        }
        // Once the coordinates have changed, all is done.
        if self.jogging.seeking.cancelled && !self.jogging.homing.is_set {
            self.jogging.homing.fail_first(HomeFault::Cancelled);
        }
        let jogging = &*self.jogging;
        let stops = jogging.homing.failed.is_some() || wish.holds();
        let passed = self.side.cycles().since(jogging.began).unwrap_or(0);
        let turn = jogging.homing.turn();
        for axis in 0..N {
            let rests = !self.jogging.moves || self.jogging.agreed.rests(axis, passed);
            if rests && !stops {
                self.step_axis(axis, turn);
            } else if let Some(homing) = self.jogging.homing.axes.get_mut(axis) {
                if rests { homing.rest() } else { homing.halt_if(stops) }
            }
        }
        let jogging = &mut *self.jogging;
        let aims = jogging.homing.axes.each_ref().map(AxisHoming::aim);
        if aims.iter().any(|aim| *aim != AxisAim::Keep) {
            jogging.asked = Asked::Each(aims);
            return None;
        }
        if jogging.moves {
            return None;
        }
        if let Some(failure) = jogging.homing.failed.as_ref().copied() {
            self.end_homing(Err(failure));
            return None;
        }
        if jogging.homing.is_set {
            self.end_homing(Ok(()));
            return None;
        }
        if wish.holds() {
            return Some(Progress::Held);
        }
        if turn.is_some() {
            return Some(Progress::Planning);
        }
        let end = jogging.agreed.end();
        let axes = &jogging.homing.axes;
        let new = jogging.homing.new.unwrap_or_else(|| {
            from_fn(|i| Coord::from_raw(end[i].raw().saturating_add(axes[i].shift())))
        });
        jogging.asked = Asked::Set(new);
        None
    }

    /// At rest: what comes next for an axis.
    fn step_axis(&mut self, axis: usize, turn: Option<u8>) {
        let lines = self.side.lines();
        let switch = Input::Home(axis);
        let jogging = &mut *self.jogging;
        let here = jogging.agreed.end().get(axis).copied().unwrap_or_default();
        let Some(homing) = jogging.homing.axes.get_mut(axis) else { return };
        let is_turn = turn == Some(homing.order());
        let stepped = homing.step(here, is_turn, lines.is_closed(switch));
        let fault = match stepped {
            Ok(arms) if !arms || lines.arm(switch, true) => return,
            Ok(_) => HomeFault::Stuck,
            Err(fault) => fault,
        };
        let phase = homing.phase();
        jogging.homing.fail(HomeFailure { axis, phase, fault });
    }

    fn end_homing(&mut self, result: Result<(), HomeFailure>) {
        for axis in 0..N {
            self.side.lines().disarm(Input::Home(axis));
        }
        let homing = &mut self.jogging.homing;
        homing.on = false;
        homing.result.set(Some(result));
    }

    /// Offers a standstill in other coordinates.
    pub(super) fn plan_set(&mut self, to: &[Coord; N]) -> Progress {
        let when = self.side.cycles().plus(self.jogging.reaction);
        let mut piece = self.jog_frame().piece(STANDS);
        (piece.origin, piece.event) = (*to, true);
        self.side.write(&piece);
        self.side.offer(Branch::Cycle(when));
        let jogging = &mut *self.jogging;
        (jogging.offered, jogging.begins) = (Plan::rest(to), when);
        jogging.offered_for = Asked::Set(*to);
        self.counters.plans += 1;
        Progress::Planned
    }
}

/// Servo cycles of the piece that stands still in other coordinates: the first of them shows them.
const STANDS: u32 = 2;

/// Whether an axis can be homed so from where it stands.
fn check<S: Scalar>(
    home: &AxisHome<S>,
    axis: usize,
    from: Coord,
    cycle: f64,
) -> Result<(), ProbeError> {
    let most = Range::new(LEAST_WAY, Coord::LIMIT_MM);
    let way = |way: Coord| {
        let error = most.check(way.to_mm());
        error.map_err(|error| ProbeError::Coordinate { axis, error })
    };
    way(home.reach)?;
    way(home.back)?;
    let longest = home.reach.to_mm() + 2.0 * home.back.to_mm();
    for place in [home.at, home.park.unwrap_or_default()] {
        let error = Coord::RANGE.check(place.to_mm());
        error.map_err(|error| ProbeError::Coordinate { axis, error })?;
    }
    let furthest = Coord::RANGE.check(from.to_mm().abs() + longest);
    furthest.map_err(|error| ProbeError::Coordinate { axis, error })?;
    let Range { least, greatest } = Quantity::Feed.range();
    // No longer than can be counted in servo cycles. The slow approach goes no further than from before the edge to behind it.
    for (feed, way) in [(home.fast, longest), (home.slow, 2.0 * home.back.to_mm())] {
        let slowest = way / (f64::from(MOST_CYCLES / 4) * cycle);
        let error = Range::new(least.max(slowest), greatest).check(feed.abs());
        error.map_err(|error| ProbeError::OutOfRange { quantity: Quantity::Feed, error })?;
    }
    Ok(())
}

/// Shortest way of a homing, mm.
const LEAST_WAY: f64 = 1.0e-6;
