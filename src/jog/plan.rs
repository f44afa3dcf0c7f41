//! What all axes do, until they rest; and the pieces of it that the interrupt runs.

use super::axis::{AxisMotion, Cursor, Goal, Room};
#[cfg(feature = "home")]
use super::homing::AxisAim;
pub use super::ramp::MOST_CYCLES;
use super::ramp::{Caps, Motion, Steps};
use super::reach::Reach;
#[cfg(feature = "probe")]
use crate::machine::Limits;
use crate::machine::{AxisLimits, Config};
use crate::number::serial::NodeSerial;
use crate::number::vector::norm;
use crate::number::{ArcLength, Coord, Scalar};
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// Longest way of a piece for which there is room for another, mm: in an `f32`, rounded to a nanometre.
const LONG: f64 = 8.0;

/// What a plan is made for.
#[derive(Clone, Copy, Debug)]
pub enum Aim<const N: usize> {
    /// Every axis by itself comes to a velocity, mm per cycle, and brakes after so many cycles.
    Velocity([f64; N], u32),
    /// To a place, at a speed over the line, mm per cycle, at most.
    Place([Coord; N], f64),
    /// To rest.
    Stop,
    /// Every axis by itself, wherever it may go.
    #[cfg(feature = "home")]
    Each([AxisAim; N]),
}

/// The motion of all axes.
#[derive(Clone, Debug)]
pub struct Plan<const N: usize> {
    pub(super) axes: [AxisMotion; N],
    /// All axes move along one straight line, in the same phases.
    pub(super) straight: bool,
}

/// A plan, and whether it does what it was made for: if not, some axes go on as they did, until they can be asked again.
#[derive(Clone, Debug)]
pub struct Planned<const N: usize> {
    pub plan: Plan<N>,
    pub whole: bool,
}

/// What all pieces have in common.
#[derive(Clone, Copy, Debug)]
pub struct Frame<S> {
    pub serial: NodeSerial,
    pub tag: u32,
    pub arc_length: ArcLength,
    pub cycle: S,
}

impl<const N: usize> Plan<N> {
    /// The memory of one: all zeros.
    pub const EMPTY: Self = Self { axes: [AxisMotion::EMPTY; N], straight: false };

    /// No motion at all.
    pub fn rest(at: &[Coord; N]) -> Self {
        Self { axes: at.map(AxisMotion::rest), straight: false }
    }

    /// Where it rests.
    pub fn end(&self) -> [Coord; N] {
        self.axes.each_ref().map(AxisMotion::end)
    }

    /// Servo cycles until all axes rest.
    pub fn total(&self) -> u32 {
        self.axes.iter().fold(0, |most, axis| most.max(axis.total()))
    }

    /// Whether an axis rests after so many servo cycles.
    #[cfg(feature = "home")]
    pub fn rests(&self, axis: usize, cycles: u32) -> bool {
        self.axes.get(axis).is_none_or(|axis| axis.total() <= cycles)
    }

    /// What is left of it after so many servo cycles.
    #[must_use]
    pub fn tail(&self, cycles: u32) -> Self {
        Self { axes: self.axes.each_ref().map(|axis| axis.tail(cycles)), ..*self }
    }

    /// Another from its beginning on.
    ///
    /// Cost: bounded; that of one or two ramps, or one to three ways to a place, per axis.
    pub fn turned<S: Scalar>(&self, aim: &Aim<N>, config: &Config<S, N>) -> Planned<N> {
        let resting = self.axes.iter().all(|axis| axis.start().motion == Motion::REST);
        match aim {
            Aim::Place(to, feed) if resting => self.along_line::<S>(to, *feed, config),
            Aim::Stop if self.straight => self.stopped_on_line::<S>(config),
            _ => self.by_axes(aim, config),
        }
    }

    fn by_axes<S: Scalar>(&self, aim: &Aim<N>, config: &Config<S, N>) -> Planned<N> {
        let mut planned = Planned { plan: Self { straight: false, ..self.clone() }, whole: true };
        for (i, axis) in planned.plan.axes.iter_mut().enumerate() {
            let Some(limits) = config.limits.axes().get(i) else { break };
            let (caps, from) = (caps(limits, config.cycle), axis.start());
            let room = room(config, i, [from.at, axis.end()]);
            let turned = match aim {
                Aim::Velocity(velocity, hold) => {
                    let wanted = velocity.get(i).copied().unwrap_or(0.0);
                    let velocity = wanted.max(-caps.velocity).min(caps.velocity);
                    at_velocity::<S>(axis, velocity, *hold, &caps, room)
                }
                Aim::Place(to, feed) => {
                    let at = to.get(i).copied().unwrap_or(axis.end());
                    let goal = Goal { at, speed: feed.min(caps.velocity) };
                    AxisMotion::to_place::<S>(from, goal, &caps, room)
                }
                Aim::Stop => at_velocity::<S>(axis, 0.0, 0, &caps, room),
                #[cfg(feature = "home")]
                Aim::Each(aims) => match aims.get(i) {
                    Some(AxisAim::Place(at, speed)) => {
                        let goal = Goal { at: *at, speed: speed.min(caps.velocity) };
                        AxisMotion::to_place::<S>(from, goal, &caps, Room::OPEN)
                    }
                    Some(AxisAim::Halt) => {
                        stop_caps(config).get(i).and_then(|stop| axis.halted(stop))
                    }
                    _ => Some(*axis),
                },
            };
            match turned {
                Some(turned) => *axis = turned,
                None => planned.whole = false,
            }
        }
        planned
    }

    /// From rest to a place, straight.
    fn along_line<S: Scalar>(
        &self,
        to: &[Coord; N],
        feed: f64,
        config: &Config<S, N>,
    ) -> Planned<N> {
        let from = self.axes.each_ref().map(|axis| axis.start().at);
        let by: [f64; N] = from_fn(|i| to[i].minus(from[i]));
        let length = norm(&by);
        if !(length > 0.0) {
            return Planned { plan: Self::rest(&from), whole: true };
        }
        let caps = caps_along(&by.map(|by| by / length), &axis_caps(config));
        let feed = feed_along(&by, feed, config);
        let Some(reach) = Reach::new::<S>(&Motion::REST, length, feed.min(caps.velocity), &caps)
        else {
            return Planned { plan: self.clone(), whole: false };
        };
        let axes = from_fn(|i| AxisMotion::in_step(from[i], to[i], &reach));
        Planned { plan: Self { axes, straight: true }, whole: true }
    }

    /// To rest on the line under way.
    fn stopped_on_line<S: Scalar>(&self, config: &Config<S, N>) -> Planned<N> {
        let states = self.axes.each_ref().map(AxisMotion::start);
        let by: [f64; N] = from_fn(|i| self.axes[i].end().minus(states[i].at));
        let length = norm(&by);
        let failed = || Planned { plan: self.clone(), whole: false };
        if !(length > 0.0) {
            return failed();
        }
        let unit = by.map(|by| by / length);
        let caps = caps_along(&unit, &axis_caps(config));
        let over = |of: fn(&Motion<f64>) -> f64| -> f64 {
            states.iter().zip(&unit).map(|(state, unit)| of(&state.motion) * unit).sum()
        };
        let from = Motion {
            velocity: over(|motion| motion.velocity),
            acceleration: over(|motion| motion.acceleration),
        };
        let Some(steps) = Steps::new::<S>(&from, 0.0, &caps) else { return failed() };
        let axes = states.map(|state| AxisMotion::to_rest_in_step(state, steps.cycles));
        Planned { plan: Self { axes, straight: true }, whole: true }
    }

    /// The place from which a step counts: where the axes would stop.
    pub fn stop_places<S: Scalar>(&self, config: &Config<S, N>) -> [Coord; N] {
        self.turned(&Aim::Stop, config).plan.end()
    }

    /// Whether it lasts too long to be counted.
    pub fn is_too_long(&self) -> bool {
        self.total() >= MOST_CYCLES
    }

    /// Servo cycles in each of the pieces, in order, without those that are divided.
    fn spans(&self) -> impl Iterator<Item = u32> + '_ {
        let mut cursors = self.axes.each_ref().map(AxisMotion::cursor);
        core::iter::from_fn(move || {
            let next = cursors.iter().filter_map(Cursor::until_next).min()?;
            for cursor in &mut cursors {
                cursor.advance(next);
            }
            Some(next)
        })
    }

    /// Whether so many pieces are enough.
    pub fn fits(&self, most: usize) -> bool {
        self.spans().count() <= most
    }

    /// Its pieces, `most` of them at most, in order.
    pub fn pieces<S: Scalar>(
        &self,
        frame: &Frame<S>,
        most: usize,
        mut hand_over: impl FnMut(&Piece<S, N>),
    ) {
        let mut spare = most.saturating_sub(self.spans().count()) as u32;
        let mut cursors = self.axes.each_ref().map(AxisMotion::cursor);
        let mut left = self.total();
        for span in self.spans() {
            let way = cursors.iter().fold(0.0, |most: f64, cursor| {
                let mut after = *cursor;
                after.advance(span);
                most.max((after.distance - cursor.distance).abs())
            });
            let parts = 1 + ((way / LONG) as u32).min(spare).min(span - 1);
            spare -= parts - 1;
            let mut to_go = span;
            for part in (1..=parts).rev() {
                let cycles = to_go.checked_div(part).unwrap_or(to_go);
                to_go -= cycles;
                left -= cycles;
                let jerks = cursors.each_ref().map(Cursor::jerk);
                let mut piece = frame.piece(cycles);
                for i in 0..N {
                    let cursor = &mut cursors[i];
                    piece.origin[i] = self.axes[i].start().at.plus(cursor.distance);
                    piece.axes[i] = frame.polynomial(&cursor.motion, jerks[i]);
                    cursor.advance(cycles);
                }
                if left == 0 {
                    piece.end_at(&self.end());
                }
                hand_over(&piece);
            }
        }
    }
}

impl<S: Scalar> Frame<S> {
    /// A standstill in zero for so many servo cycles.
    pub fn piece<const N: usize>(&self, cycles: u32) -> Piece<S, N> {
        Piece {
            serial: self.serial,
            tag: self.tag,
            // As the interrupt counts, so that a piece ends where a servo cycle does.
            time: S::from_u32(cycles) * self.cycle,
            origin: [Coord::ZERO; N],
            axes: [[S::ZERO; 5]; N],
            arc_length: self.arc_length,
            path: [S::ZERO; 4],
            sequel: Sequel::Jog,
            event: false,
        }
    }

    /// Of a motion in mm and servo cycles, in mm and s.
    fn polynomial(&self, motion: &Motion<f64>, jerk: f64) -> [S; 5] {
        let rate = 1.0 / self.cycle.to_f64();
        let first = motion.velocity * rate;
        let second = 0.5 * motion.acceleration * rate * rate;
        let third = jerk * rate * rate * rate / 6.0;
        [S::of(first), S::of(second), S::of(third), S::ZERO, S::ZERO]
    }
}

/// Limits of an axis in servo cycles.
fn caps<S: Scalar>(limits: &AxisLimits<S>, cycle: S) -> Caps<f64> {
    let cycle = cycle.to_f64();
    Caps {
        velocity: limits.velocity.to_f64() * cycle,
        acceleration: limits.acceleration.to_f64() * cycle * cycle,
        jerk: limits.jerk.to_f64() * cycle * cycle * cycle,
    }
}

/// A feed as of a block, which counts over the linear axes if any of them moves, as a speed along the direction of `by`.
pub(super) fn feed_along<S: Scalar, const N: usize>(
    by: &[f64; N],
    feed: f64,
    config: &Config<S, N>,
) -> f64 {
    let axes = config.limits.axes();
    let linear = norm::<f64, N>(&from_fn(|i| if axes[i].rotary { 0.0 } else { by[i] }));
    if linear > 0.0 { feed * norm(by) / linear } else { feed }
}

/// Limits of the axes in servo cycles.
pub(super) fn axis_caps<S: Scalar, const N: usize>(config: &Config<S, N>) -> [Caps<f64>; N] {
    config.limits.axes().each_ref().map(|limits| caps(limits, config.cycle))
}

/// The same for stops that must be short.
#[cfg(feature = "probe")]
pub(super) fn stop_caps<S: Scalar, const N: usize>(config: &Config<S, N>) -> [Caps<f64>; N] {
    let mut own = axis_caps(config);
    let stop = config.stop_limits.as_ref().map(Limits::axes);
    for (own, stop) in own.iter_mut().zip(stop.into_iter().flatten()) {
        let stop = caps(stop, config.cycle);
        own.acceleration = own.acceleration.max(stop.acceleration);
        own.jerk = own.jerk.max(stop.jerk);
    }
    own
}

/// Limits along a unit direction.
pub(super) fn caps_along<const N: usize>(unit: &[f64; N], axes: &[Caps<f64>; N]) -> Caps<f64> {
    let none = f64::MAX;
    let mut along = Caps { velocity: none, acceleration: none, jerk: none };
    for (caps, share) in axes.iter().zip(unit) {
        let share = share.abs();
        let least = |along: f64, cap: f64| if along * share > cap { cap / share } else { along };
        along = Caps {
            velocity: least(along.velocity, caps.velocity),
            acceleration: least(along.acceleration, caps.acceleration),
            jerk: least(along.jerk, caps.jerk),
        };
    }
    along
}

/// How far an axis may go; from outside the limits of travel, no further out than it is, or is bound for.
fn room<S: Scalar, const N: usize>(config: &Config<S, N>, axis: usize, inside: [Coord; 2]) -> Room {
    let (mut least, mut greatest) = travel(config, axis);
    for at in inside {
        (least, greatest) = (least.min(at), greatest.max(at));
    }
    Room { least, greatest }
}

/// Limits of travel of an axis: all coordinates that are accepted, if there are none.
pub fn travel<S: Scalar, const N: usize>(config: &Config<S, N>, axis: usize) -> (Coord, Coord) {
    let most = Coord::from_raw(Coord::LIMIT_MM as i64 * Coord::PER_MM);
    let most = (Coord::from_raw(-most.raw()), most);
    #[cfg(feature = "travel")]
    if let Some((least, greatest)) = config.travel.ends().get(axis) {
        return ((*least).max(most.0), (*greatest).min(most.1));
    }
    let _ = (config, axis);
    most
}

/// One axis at a velocity; where that leads out of the room, to its end.
fn at_velocity<S: Scalar>(
    axis: &AxisMotion,
    velocity: f64,
    hold: u32,
    caps: &Caps<f64>,
    room: Room,
) -> Option<AxisMotion> {
    let from = axis.start();
    if velocity == 0.0 && from.motion == Motion::REST {
        return Some(AxisMotion::rest(from.at));
    }
    let free = AxisMotion::at_velocity::<S>(from, velocity, hold, caps)?;
    if free.is_within(room) {
        return Some(free);
    }
    let (at, is_beyond) = if velocity > 0.0 {
        (room.greatest, free.end() >= room.greatest)
    } else {
        (room.least, free.end() <= room.least)
    };
    if velocity == 0.0 || !is_beyond {
        return None;
    }
    if axis.end() == at && from.motion != Motion::REST {
        // It is on its way.
        return Some(*axis);
    }
    AxisMotion::to_place::<S>(from, Goal { at, speed: velocity.abs() }, caps, room)
}
