//! What one axis does from a servo cycle on until it rests.

#[cfg(feature = "probe")]
use super::brake::Brake;
use super::ramp::{Caps, Motion, Steps};
use super::reach::{Reach, Times};
use crate::number::{Coord, Scalar};

/// Phases of constant jerk: two ramps of three, a cruise, and a ramp before them where the first does not lead there by itself.
const PHASES: usize = 10;

/// What the sums of a motion may be rounded by, raw units of a coordinate.
const ROUNDING: i64 = 1000;

/// A number of servo cycles of constant jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Phase {
    cycles: u32,
    /// Acceleration at its end, mm per square cycle.
    until: f64,
}

/// Where an axis is, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    pub at: Coord,
    pub motion: Motion<f64>,
}

impl State {
    /// At rest at a place.
    pub const fn rest(at: Coord) -> Self {
        Self { at, motion: Motion::REST }
    }
}

/// How far an axis may go.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    pub least: Coord,
    pub greatest: Coord,
}

impl Room {
    /// With a place that is allowed, too.
    pub fn with(self, at: Coord) -> Self {
        Self { least: self.least.min(at), greatest: self.greatest.max(at) }
    }
}

/// Where an axis shall be at rest, and how fast it may go there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    pub at: Coord,
    pub speed: f64,
}

/// The motion of one axis, until it rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMotion {
    start: State,
    phases: [Phase; PHASES],
    count: usize,
    /// Where it rests.
    end: Coord,
}

/// Distance in a phase, and the motion after it.
fn after(motion: &Motion<f64>, cycles: u32, until: f64) -> (f64, Motion<f64>) {
    let (n, Motion { velocity, acceleration }) = (f64::from(cycles), *motion);
    let distance = (velocity + (acceleration + acceleration + until) * n / 6.0) * n;
    let velocity = velocity + (acceleration + until) * 0.5 * n;
    (distance, Motion { velocity, acceleration: until })
}

impl Room {
    /// All coordinates.
    #[cfg(feature = "home")]
    pub const OPEN: Self =
        Self { least: Coord::from_raw(i64::MIN), greatest: Coord::from_raw(i64::MAX) };
}

impl AxisMotion {
    /// The memory of one: all zeros, at rest at zero.
    pub const EMPTY: Self = Self::rest(Coord::ZERO);

    /// None at all.
    pub const fn rest(at: Coord) -> Self {
        Self {
            start: State::rest(at),
            phases: [Phase { cycles: 0, until: 0.0 }; PHASES],
            count: 0,
            end: at,
        }
    }

    const fn from(start: State) -> Self {
        Self { start, ..Self::rest(start.at) }
    }

    /// Where it rests.
    pub fn end(&self) -> Coord {
        self.end
    }

    /// Where it begins.
    pub fn start(&self) -> State {
        self.start
    }

    /// Servo cycles until it rests.
    pub fn total(&self) -> u32 {
        self.list().iter().fold(0, |sum, phase| sum.saturating_add(phase.cycles))
    }

    fn list(&self) -> &[Phase] {
        self.phases.get(..self.count).unwrap_or(&[])
    }

    fn push(&mut self, cycles: u32, until: f64) {
        if cycles > 0
            && let Some(phase) = self.phases.get_mut(self.count)
        {
            *phase = Phase { cycles, until };
            self.count += 1;
        }
    }

    fn push_steps(&mut self, steps: &Steps) {
        let [rise, held, fall] = steps.cycles;
        self.push(rise, steps.peak);
        self.push(held, steps.peak);
        self.push(fall, 0.0);
    }

    fn push_reach(&mut self, reach: &Reach) {
        self.push_steps(&reach.first);
        self.push(reach.cruise, 0.0);
        self.push_steps(&reach.last);
    }

    /// What is left of it after so many.
    pub fn tail(&self, cycles: u32) -> Self {
        let mut cursor = Cursor::new(self);
        cursor.advance(cycles);
        if cursor.left.is_empty() {
            return Self::rest(self.end);
        }
        let mut tail = Self::from(cursor.state(self));
        for (i, phase) in cursor.left.iter().enumerate() {
            let passed = if i == 0 { cursor.passed } else { 0 };
            tail.push(phase.cycles - passed.min(phase.cycles), phase.until);
        }
        tail.end = self.end;
        tail
    }

    /// Ends where its phases lead.
    fn closed(mut self) -> Self {
        let mut cursor = Cursor::new(&self);
        cursor.advance(u32::MAX);
        self.end = self.start.at.plus(cursor.distance);
        self
    }

    /// Whether it stays within what an axis may go: by the Bernstein coefficients of its phases, which bound them.
    pub fn is_within(&self, room: Room) -> bool {
        let end = |at: Coord, sign: i64| at.raw().saturating_add(sign * ROUNDING);
        let room = end(room.least, -1)..=end(room.greatest, 1);
        let inside = |distance: f64| room.contains(&self.start.at.plus(distance).raw());
        let (mut motion, mut distance) = (self.start.motion, 0.0);
        self.list().iter().all(|phase| {
            let n = f64::from(phase.cycles);
            let (covered, next) = after(&motion, phase.cycles, phase.until);
            let second = distance + covered - next.velocity * n / 3.0;
            let within = inside(distance + motion.velocity * n / 3.0)
                && inside(second)
                && inside(distance + covered);
            distance += covered;
            motion = next;
            within
        })
    }

    /// Its greatest speed, acceleration and jerk.
    #[cfg(feature = "kinematics")]
    pub fn peaks(&self) -> Caps<f64> {
        let Motion { velocity, acceleration } = self.start.motion;
        let mut most =
            Caps { velocity: velocity.abs(), acceleration: acceleration.abs(), jerk: 0.0 };
        let mut motion = self.start.motion;
        for phase in self.list() {
            let (_, next) = after(&motion, phase.cycles, phase.until);
            let (a, until) = (motion.acceleration, phase.until);
            let jerk = (until - a) / f64::from(phase.cycles.max(1));
            // Where the acceleration changes its sign the speed is greatest or least.
            let turned =
                if a * until < 0.0 { motion.velocity - 0.5 * a * a / jerk } else { next.velocity };
            most.velocity = most.velocity.max(turned.abs()).max(next.velocity.abs());
            most.acceleration = most.acceleration.max(until.abs());
            most.jerk = most.jerk.max(jerk.abs());
            motion = next;
        }
        most
    }

    /// To a velocity, kept until `hold` servo cycles are over, then to rest. `None`: no such motion is found from here.
    pub fn at_velocity<S: Scalar>(
        from: State,
        velocity: f64,
        hold: u32,
        caps: &Caps<f64>,
    ) -> Option<Self> {
        let mut motion = Self::from(from);
        let reached;
        if hold == 0 {
            reached = from.motion;
        } else {
            let ramp = Steps::new::<S>(&from.motion, velocity, caps)?;
            motion.push_steps(&ramp);
            let total = motion.total();
            if total <= hold {
                motion.push(hold - total, 0.0);
                reached = Motion { velocity, acceleration: 0.0 };
            } else {
                // The time is over before the velocity is reached.
                let whole = motion;
                let mut cursor = Cursor::new(&whole);
                cursor.advance(hold);
                reached = cursor.motion;
                motion = Self::from(from);
                let mut left = hold;
                for phase in whole.list() {
                    let cycles = phase.cycles.min(left);
                    motion.push(
                        cycles,
                        if cycles < phase.cycles { reached.acceleration } else { phase.until },
                    );
                    left -= cycles;
                }
            }
        }
        motion.push_steps(&Steps::new::<S>(&reached, 0.0, caps)?);
        Some(motion.closed())
    }

    /// To a place. `None`: no such motion is found from here.
    pub fn to_place<S: Scalar>(
        from: State,
        goal: Goal,
        caps: &Caps<f64>,
        room: Room,
    ) -> Option<Self> {
        if from.motion == Motion::REST && from.at == goal.at {
            return Some(Self::rest(goal.at));
        }
        let distance: f64 = goal.at.minus(from.at);
        let reach =
            |from: &Motion<f64>, distance: f64| Reach::new::<S>(from, distance, goal.speed, caps);
        let ended = |mut motion: Self| {
            motion.end = goal.at;
            motion.is_within(room).then_some(motion)
        };
        let direct = reach(&from.motion, distance).and_then(|reach| {
            let mut motion = Self::from(from);
            motion.push_reach(&reach);
            ended(motion)
        });
        if direct.is_some() {
            return direct;
        }
        // First to the speed that would be best, or to rest: from where it is easier.
        let best = Times::new::<S>(&from.motion, distance, goal.speed, caps, 1.0).speed;
        [best, 0.0].into_iter().find_map(|speed| {
            let mut motion = Self::from(from);
            motion.push_steps(&Steps::new::<S>(&from.motion, speed, caps)?);
            let mut cursor = Cursor::new(&motion);
            cursor.advance(u32::MAX);
            let left = distance - cursor.distance;
            let between = Motion { velocity: speed, acceleration: 0.0 };
            motion.push_reach(&reach(&between, left)?);
            ended(motion)
        })
    }

    /// From rest to a place in phases of given durations, which all axes share.
    pub fn in_step(from: Coord, to: Coord, like: &Reach) -> Self {
        let times = like.times();
        let mut motion = Self::rest(from);
        motion.push_reach(&Reach::at(&Motion::REST, to.minus(from), &times));
        motion.end = to;
        motion
    }

    /// To rest in phases of given durations, which all axes share.
    pub fn to_rest_in_step(from: State, cycles: [u32; 3]) -> Self {
        let mut motion = Self::from(from);
        motion.push_steps(&Steps::between(&from.motion, 0.0, cycles));
        motion.closed()
    }

    /// The shortest stop by itself; `None` if it would have to go back first.
    #[cfg(feature = "home")]
    pub fn halted(&self, caps: &Caps<f64>) -> Option<Self> {
        let from = self.start;
        Brake::new(&from.motion, caps).map(|brake| Self::braked(from, &brake, 1.0))
    }

    /// To rest in the phases of a stop, of which it has a share.
    #[cfg(feature = "probe")]
    pub fn braked(from: State, brake: &Brake, share: f64) -> Self {
        let mut motion = Self::from(from);
        for (cycles, until) in brake.phases() {
            motion.push(*cycles, until * share);
        }
        motion.closed()
    }

    /// The places between which the interrupt needs pieces of its own, and what they are.
    pub fn cursor(&self) -> Cursor<'_> {
        Cursor::new(self)
    }
}

/// A place in a motion.
#[derive(Clone, Copy, Debug)]
pub struct Cursor<'a> {
    left: &'a [Phase],
    /// Servo cycles that have passed of the first of them.
    passed: u32,
    /// From the start, mm.
    pub distance: f64,
    pub motion: Motion<f64>,
}

impl<'a> Cursor<'a> {
    fn new(motion: &'a AxisMotion) -> Self {
        Self { left: motion.list(), passed: 0, distance: 0.0, motion: motion.start.motion }
    }

    /// Servo cycles until the next phase; `None` at rest.
    pub fn until_next(&self) -> Option<u32> {
        self.left.first().map(|phase| phase.cycles - self.passed.min(phase.cycles))
    }

    /// Jerk in this phase, mm per cubic cycle; 0 at rest.
    pub fn jerk(&self) -> f64 {
        let Some((phase, left)) = self.left.first().zip(self.until_next()) else { return 0.0 };
        (phase.until - self.motion.acceleration) / f64::from(left.max(1))
    }

    /// On by so many servo cycles.
    pub fn advance(&mut self, cycles: u32) {
        let mut to_go = cycles;
        while let Some(left) = self.until_next()
            && let Some((phase, rest)) = self.left.split_first()
        {
            let ends = to_go >= left;
            let passed = left.min(to_go);
            let until = if ends {
                phase.until
            } else {
                self.motion.acceleration + self.jerk() * f64::from(passed)
            };
            let (covered, motion) = after(&self.motion, passed, until);
            self.distance += covered;
            self.motion = motion;
            if !ends {
                self.passed += passed;
                return;
            }
            to_go -= passed;
            (self.left, self.passed) = (rest, 0);
        }
        self.motion = Motion::REST;
    }

    fn state(&self, motion: &AxisMotion) -> State {
        State { at: motion.start.at.plus(self.distance), motion: self.motion }
    }
}
