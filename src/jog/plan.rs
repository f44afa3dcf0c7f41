//! What all axes do, until they rest; and the pieces of it that the interrupt runs.

#[cfg(feature = "kinematics")]
use super::axis::State;
use super::axis::{AxisMotion, Cursor, Goal, Room};
#[cfg(feature = "home")]
use super::homing::AxisAim;
pub use super::ramp::MOST_CYCLES;
use super::ramp::{Caps, Motion, Steps};
use super::reach::Reach;
#[cfg(feature = "kinematics")]
use super::shares::{self, Want};
use crate::machine::{AxisLimits, Config, Limits};
use crate::number::serial::NodeSerial;
use crate::number::vector::{dot, norm};
use crate::number::{ArcLength, Coord, Scalar};
use crate::servo::piece::{Piece, Sequel};
use core::array::from_fn;

/// Longest way of a piece for which there is room for another, mm: in an `f32`, rounded to a nanometre.
const LONG: f64 = 8.0;

/// Share of the speed of its share that an axis may have at least while it comes down to that.
#[cfg(feature = "kinematics")]
const LEAST_LESS: f64 = 0.02;
/// Share of the speed it wants below which an axis that is homed rather waits for others.
#[cfg(feature = "kinematics")]
const LEAST_SHARE: f64 = 0.1;

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
        let resting = self.axes.iter().all(|axis| axis.start().motion.is_rest());
        match aim {
            Aim::Place(to, feed) if resting => self.along_line::<S>(to, *feed, config),
            Aim::Stop if self.straight => self.stopped_on_line::<S>(config),
            #[cfg(feature = "kinematics")]
            _ if binds_motors(config) => self.by_shares(aim, config),
            _ => {
                let caps = axis_caps(&config.limits, config.cycle);
                let most = caps.map(|caps| Some(caps.velocity));
                self.by_axes(aim, (&caps, &most), config, || stop_caps(config))
            }
        }
    }

    /// Every axis by itself, within limits of its own, and at a speed of so much at most; without one it goes on as it does.
    fn by_axes<S: Scalar>(
        &self,
        aim: &Aim<N>,
        (caps, most): (&[Caps<f64>; N], &[Option<f64>; N]),
        config: &Config<S, N>,
        stops: impl Fn() -> [Caps<f64>; N],
    ) -> Planned<N> {
        #[cfg(not(feature = "home"))]
        let _ = &stops;
        let mut planned = Planned { plan: Self { straight: false, ..self.clone() }, whole: true };
        for (i, axis) in planned.plan.axes.iter_mut().enumerate() {
            let (Some(caps), Some(Some(most))) = (caps.get(i), most.get(i)) else { continue };
            let from = axis.start();
            let room = room(config, i, [from.at, axis.end()]);
            let turned = match aim {
                Aim::Velocity(velocity, hold) => {
                    let wanted = velocity.get(i).copied().unwrap_or(0.0);
                    let velocity = wanted.max(-most).min(*most);
                    at_velocity::<S>(axis, velocity, *hold, caps, room)
                }
                Aim::Place(to, feed) => {
                    let at = to.get(i).copied().unwrap_or(axis.end());
                    let goal = Goal { at, speed: feed.min(*most) };
                    // It has been looked at, or is where a program was held.
                    AxisMotion::to_place::<S>(from, goal, caps, room.with(at))
                }
                Aim::Stop => at_velocity::<S>(axis, 0.0, 0, caps, room),
                #[cfg(feature = "home")]
                Aim::Each(aims) => match aims.get(i) {
                    Some(AxisAim::Place(at, speed)) => {
                        let goal = Goal { at: *at, speed: speed.min(*most) };
                        AxisMotion::to_place::<S>(from, goal, caps, Room::OPEN)
                    }
                    Some(AxisAim::Halt) => stops().get(i).and_then(|stop| axis.halted(stop)),
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

    /// The speed that an axis is asked for, mm per cycle; 0 if it is to rest.
    #[cfg(feature = "kinematics")]
    fn asked(&self, aim: &Aim<N>, i: usize) -> f64 {
        let axis = self.axes.get(i);
        match aim {
            Aim::Velocity(velocity, _) => velocity.get(i).map_or(0.0, |velocity| velocity.abs()),
            Aim::Place(to, feed) => {
                let there = to.get(i).copied().map(State::rest);
                if axis.map(AxisMotion::start) == there { 0.0 } else { *feed }
            }
            Aim::Stop => 0.0,
            #[cfg(feature = "home")]
            Aim::Each(aims) => match aims.get(i) {
                Some(AxisAim::Place(_, speed)) => *speed,
                Some(AxisAim::Halt) | None => 0.0,
                Some(AxisAim::Keep) => axis.map_or(0.0, |axis| axis.peaks().velocity),
            },
        }
    }

    /// Every axis by itself, with its share of what the motors give. Where that does not lead from what is under way - an axis
    /// had more of them before others were asked to move too - those that move come down to it first, and are asked again.
    #[cfg(feature = "kinematics")]
    fn by_shares<S: Scalar>(&self, aim: &Aim<N>, config: &Config<S, N>) -> Planned<N> {
        let own = shares::alone(config);
        let moves = self.axes.each_ref().map(|axis| axis.start().motion != Motion::REST);
        let asked: [Option<f64>; N] = from_fn(|i| {
            let asked = self.asked(aim, i).min(own[i].velocity);
            (moves[i] || asked > 0.0).then_some(asked)
        });
        // What changes nothing is not made into a plan again: every one is rounded.
        let nothing = || Planned { plan: Self::rest(&self.end()), whole: false };
        let (caps, planned) = self.shared_out(aim, &asked, &[f64::MAX; N], config);
        if let Some(planned) = planned {
            let same = is_of_each(aim) && planned.plan.axes == self.axes;
            return if same { nothing() } else { planned };
        }
        let alone = moves.iter().filter(|moves| **moves).count() == 1;
        let most = from_fn(|i| {
            let (least, speed) =
                (caps[i].velocity * LEAST_LESS, self.axes[i].start().motion.velocity.abs());
            caps[i].velocity.min(if alone { f64::MAX } else { speed.max(least) })
        });
        let less = from_fn(|i| asked[i].filter(|_| moves[i]).map(|asked| asked.min(most[i])));
        let (_, planned) = self.shared_out(aim, &less, &most, config);
        match planned {
            Some(planned) => Planned { whole: false, ..planned },
            None if self.straight => Planned { whole: false, ..self.stopped_on_line::<S>(config) },
            None => nothing(),
        }
    }

    /// With shares for axes that are asked for such speeds, of which they use so much at most. What they may do, and the plan if
    /// it keeps that.
    #[cfg(feature = "kinematics")]
    fn shared_out<S: Scalar>(
        &self,
        aim: &Aim<N>,
        asked: &[Option<f64>; N],
        most: &[f64; N],
        config: &Config<S, N>,
    ) -> ([Caps<f64>; N], Option<Planned<N>>) {
        let own = shares::alone(config);
        let wants = from_fn(|i| {
            let axis = &self.axes[i];
            let bound = shares::bound_for(&axis.start().motion, &own[i]);
            // What it has it keeps, where it is not asked for anything else.
            let kept = goes_on(aim, i);
            let speed = asked[i]?.max(if kept { axis.peaks().velocity } else { bound });
            Some(Want { speed, kept })
        });
        let caps = shares::shared(&wants, config);
        let stops = shares::stopping(&caps, config);
        let is_enough = |i: usize| {
            wants[i].is_some_and(|want| want.kept || caps[i].velocity > LEAST_SHARE * want.speed)
        };
        let each = is_of_each(aim);
        let speeds: [Option<f64>; N] = from_fn(|i| {
            asked[i].filter(|_| !each || is_enough(i)).map(|_| caps[i].velocity.min(most[i]))
        });
        // One that waits rests where it is, and is asked for its way again.
        let planned = self.by_axes(aim, (&caps, &speeds), config, || stops);
        let stays = planned.plan.stays(if each { &stops } else { &caps });
        (caps, stays.then_some(planned))
    }

    /// Whether every axis that moves keeps such limits.
    #[cfg(feature = "kinematics")]
    fn stays(&self, caps: &[Caps<f64>; N]) -> bool {
        self.axes.iter().zip(caps).all(|(axis, caps)| axis.total() == 0 || axis.stays(caps))
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
        let caps = caps_along(&by.map(|by| by / length), &config.limits, config.cycle);
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
        let stays = |whole| Planned { plan: self.clone(), whole };
        if !(length > 0.0) {
            return stays(false);
        }
        let unit = by.map(|by| by / length);
        let caps = caps_along(&unit, &config.limits, config.cycle);
        let over = |of: fn(&Motion<f64>) -> f64| -> f64 {
            states.iter().zip(&unit).map(|(state, unit)| of(&state.motion) * unit).sum()
        };
        let from = Motion {
            velocity: over(|motion| motion.velocity),
            acceleration: over(|motion| motion.acceleration),
        };
        let Some(steps) = Steps::new::<S>(&from, 0.0, &caps) else { return stays(false) };
        let stopped = |state| AxisMotion::to_rest_in_step(state, steps.cycles);
        // In whole cycles, each of the same jerk, a stop may be longer than the one that is under way.
        let way = states.map(|state| stopped(state).end().minus::<f64>(state.at));
        if dot(&way, &unit) >= length {
            return stays(true);
        }
        Planned { plan: Self { axes: states.map(stopped), straight: true }, whole: true }
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

/// Whether an aim is one for every axis by itself, where stops are by the limits of stops.
#[cfg(feature = "kinematics")]
fn is_of_each<const N: usize>(aim: &Aim<N>) -> bool {
    #[cfg(feature = "home")]
    return matches!(aim, Aim::Each(_));
    #[cfg(not(feature = "home"))]
    {
        let _ = aim;
        false
    }
}

/// Whether an axis moves on as it does, or stops as short as can be.
#[cfg(feature = "kinematics")]
fn goes_on<const N: usize>(aim: &Aim<N>, i: usize) -> bool {
    #[cfg(feature = "home")]
    if let Aim::Each(aims) = aim {
        return !matches!(aims.get(i), Some(AxisAim::Place(..)));
    }
    let _ = (aim, i);
    false
}

/// Limits of an axis in servo cycles.
pub(super) fn caps<S: Scalar>(limits: &AxisLimits<S>, cycle: S) -> Caps<f64> {
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
pub(super) fn axis_caps<S: Scalar, const N: usize>(
    limits: &Limits<S, N>,
    cycle: S,
) -> [Caps<f64>; N] {
    limits.axes().each_ref().map(|limits| caps(limits, cycle))
}

/// Limits of stops that must be short.
#[cfg(any(feature = "probe", feature = "kinematics"))]
pub(super) fn stop_limits<S: Scalar, const N: usize>(config: &Config<S, N>) -> Limits<S, N> {
    match &config.stop_limits {
        Some(stop) => config.limits.with_more(stop),
        None => config.limits,
    }
}

/// Whether axes that keep their own limits, or those of stops, could be too much for a motor.
#[cfg(feature = "kinematics")]
#[inline(never)]
fn binds_motors<S: Scalar, const N: usize>(config: &Config<S, N>) -> bool {
    config.limits.motors().next().is_some() || stop_limits(config).motors().next().is_some()
}

/// The same of the axes in servo cycles.
fn stop_caps<S: Scalar, const N: usize>(config: &Config<S, N>) -> [Caps<f64>; N] {
    #[cfg(feature = "probe")]
    return axis_caps(&stop_limits(config), config.cycle);
    #[cfg(not(feature = "probe"))]
    axis_caps(&config.limits, config.cycle)
}

/// Limits along a unit direction.
pub(super) fn caps_along<S: Scalar, const N: usize>(
    unit: &[f64; N],
    limits: &Limits<S, N>,
    cycle: S,
) -> Caps<f64> {
    let none = f64::MAX;
    let mut along = Caps { velocity: none, acceleration: none, jerk: none };
    let mut keep = |caps: &Caps<f64>, share: f64| {
        let least = |along: f64, cap: f64| if along * share > cap { cap / share } else { along };
        along = Caps {
            velocity: least(along.velocity, caps.velocity),
            acceleration: least(along.acceleration, caps.acceleration),
            jerk: least(along.jerk, caps.jerk),
        };
    };
    for (axis, share) in limits.axes().iter().zip(unit) {
        keep(&caps(axis, cycle), share.abs());
    }
    for motor in limits.motors() {
        let share = dot(&motor.factors.map(Scalar::to_f64), unit);
        keep(&caps(&motor.limits, cycle), share.abs());
    }
    along
}

/// How far an axis may go; from outside the limits of travel, no further out than it is, or is bound for.
fn room<S: Scalar, const N: usize>(config: &Config<S, N>, axis: usize, inside: [Coord; 2]) -> Room {
    let (least, greatest) = travel(config, axis);
    inside.into_iter().fold(Room { least, greatest }, Room::with)
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
    #[cfg(feature = "kinematics")]
    let stays = axis.stays(caps);
    #[cfg(not(feature = "kinematics"))]
    let stays = true;
    if axis.end() == at && from.motion != Motion::REST && stays {
        // It is on its way.
        return Some(*axis);
    }
    AxisMotion::to_place::<S>(from, Goal { at, speed: velocity.abs() }, caps, room)
}
