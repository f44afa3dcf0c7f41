//! Input shaping: setpoints that do not make the machine vibrate.
//!
//! What an axis is given is a mean of its setpoints over the last milliseconds, by weights that let a vibration of a known frequency
//! cancel itself. The weights are positive and their sum is one, so that no axis becomes faster, or accelerates or jerks more, than
//! its setpoints do; only the path is another one. By how much is bounded: with `w` the weights, `t` how far they look
//! back and `m` the mean of these times, which is the same for all axes, an axis is off its place `m` before by
//!
//! `sum w (q(now - t) - q(now - m)) <= 1/2 sum w (t - m)^2 max|acceleration|`,
//!
//! since the first order cancels. [`Shaper::follower`] keeps so much of the tolerance free, which may cost acceleration.

mod kernel;

pub use kernel::{Shape, ShaperError, ShaperKind};

use crate::machine::{Config, Follower, Quantity};
#[cfg(feature = "outputs")]
use crate::number::ArcLength;
use crate::number::{Coord, Scalar};
use crate::servo::{Activity, Setpoint};
use core::array::from_fn;
use kernel::Kernel;

/// Slowest motion of the axes that says which of them count, mm/s: the square of what is slower, which is rounding, has no inverse in `f32`.
#[cfg(feature = "outputs")]
const LEAST_SPEED: f64 = 1.0e-12;

/// What is remembered of a setpoint.
#[derive(Clone, Copy, Debug)]
struct Past<S, const N: usize> {
    origin: [Coord; N],
    offset: [S; N],
    velocity: [S; N],
    acceleration: [S; N],
    #[cfg(feature = "outputs")]
    along: Along<S>,
}

impl<S: Scalar, const N: usize> Past<S, N> {
    const ZERO: Self = Self {
        origin: [Coord::ZERO; N],
        offset: [S::ZERO; N],
        velocity: [S::ZERO; N],
        acceleration: [S::ZERO; N],
        #[cfg(feature = "outputs")]
        along: Along { origin: ArcLength::ZERO, offset: S::ZERO, speed: S::ZERO },
    };

    fn of(setpoint: &Setpoint<S, N>) -> Self {
        let Setpoint { origin, offset, velocity, acceleration, .. } = *setpoint;
        #[cfg(feature = "outputs")]
        let along = Along {
            origin: setpoint.path_origin,
            offset: setpoint.path_offset,
            speed: setpoint.path_speed,
        };
        Self {
            origin,
            offset,
            velocity,
            acceleration,
            #[cfg(feature = "outputs")]
            along,
        }
    }
}

/// Where on the path, for outputs.
#[cfg(feature = "outputs")]
#[derive(Clone, Copy, Debug)]
struct Along<S> {
    origin: ArcLength,
    offset: S,
    speed: S,
}

#[cfg(feature = "outputs")]
impl<S: Scalar> Along<S> {
    /// How far another place lies before this one, mm.
    #[inline]
    fn since(&self, before: &Self) -> S {
        let way = self.offset - before.offset;
        if self.origin == before.origin {
            return way;
        }
        let units = self.origin.raw().wrapping_sub(before.origin.raw());
        // A way of 400 mm at least, which is one instruction on the target; the other is a call.
        let mm = u32::try_from(units).map_or_else(|_| S::from_i64(units), S::from_u32);
        way + mm * S::of(1.0e-7)
    }
}

/// How far the machine is behind along the path, mm, and its speed there: the mean of its axes.
#[cfg(feature = "outputs")]
#[derive(Clone, Copy, Debug)]
struct Reached<S> {
    behind: S,
    speed: S,
}

/// Shapes the setpoints of `N` axes (feature `shaping`); `HISTORY` is how many servo cycles it remembers, 1.5 periods of the lowest
/// frequency and 2 more at most. To be called between [`Interpolator::tick`](crate::Interpolator::tick) and what follows setpoints.
///
/// ```
/// use splineway::output::{Shape, Shaper, ShaperKind};
/// # use splineway::{AxisLimits, Config, Limits, Link, Coord};
/// # let axis = AxisLimits::linear(200.0, 2000.0, 1.0e5);
/// # let mut config = Config::<f32, 2>::new(Limits::new([axis; 2])?);
/// config.tolerance = 0.05;
/// let shape = Shape { kind: ShaperKind::Zv, frequency: 45.0, damping: 0.06 };
/// let mut shaper = Shaper::<f32, 2, 64>::new(); // or a `static`: it is large
/// shaper.set([Some(shape); 2], &config)?;
/// config.follower = shaper.follower(&config);
/// # let mut link = Link::<f32, 2>::new();
/// let (planner, mut interpolator) = link.split(config, [Coord::ZERO; 2])?;
/// // In the servo interrupt:
/// let setpoint = shaper.shape(&interpolator.tick());
/// # assert!(shaper.is_settled());
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Shaper<S, const N: usize, const HISTORY: usize> {
    kernels: [Kernel<S, HISTORY>; N],
    past: [Past<S, N>; HISTORY],
    /// Where the last setpoint is kept.
    newest: usize,
    /// How far back it is known, cycles: before that the axes rested where they were then.
    known: usize,
    /// How far back the weights reach, cycles.
    span: usize,
    /// Servo cycles at rest so far, up to one more than the span: then the last of the motion has been weighed.
    rested: usize,
    /// An event that waits for the rest, and for how many cycles.
    event: Option<(u32, usize)>,
    /// Whether a setpoint has been seen.
    begun: bool,
    /// Whether all axes are shaped alike.
    alike: bool,
    /// How much each of them counts for the place on the path, if they are not: by the square of the speed with which it moved last.
    #[cfg(feature = "outputs")]
    shares: [S; N],
    /// Mean time that all axes look back, cycles.
    mean: f64,
    cycle: f64,
}

impl<S: Scalar, const N: usize, const HISTORY: usize> Default for Shaper<S, N, HISTORY> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar, const N: usize, const HISTORY: usize> Shaper<S, N, HISTORY> {
    /// One that shapes nothing: setpoints stay as they are.
    pub const fn new() -> Self {
        Self {
            kernels: [const { Kernel::NONE }; N],
            past: [Past::ZERO; HISTORY],
            newest: 0,
            known: 0,
            span: 0,
            rested: 1,
            event: None,
            begun: false,
            alike: true,
            #[cfg(feature = "outputs")]
            shares: [S::ZERO; N],
            mean: 0.0,
            cycle: 0.0,
        }
    }

    /// Shapes the axes that have a shape; the others wait as long as these do on the average, so that all stay together. To be done
    /// while the machine rests, and before [`Config::follower`] is asked for; it then rests where the next setpoint is, or where that
    /// comes from, if it is already in motion.
    ///
    /// Cost: some hundred thousand instructions, and little stack.
    ///
    /// # Errors
    /// [`ShaperError`] names what is out of its range; all is as before.
    pub fn set(
        &mut self,
        shapes: [Option<Shape>; N],
        config: &Config<S, N>,
    ) -> Result<(), ShaperError> {
        if self.begun && self.rested <= self.span {
            return Err(ShaperError::Moving);
        }
        Quantity::Cycle.check(config.cycle).map_err(ShaperError::Cycle)?;
        let cycle = config.cycle.to_f64();
        for (axis, shape) in shapes.iter().enumerate() {
            if let Some(shape) = shape {
                shape.check(axis, cycle, HISTORY)?;
            }
        }
        let own = shapes.each_ref().map(|shape| {
            shape.as_ref().map_or(0.0, |shape| Kernel::<S, HISTORY>::mean(shape, cycle))
        });
        let mean = own.iter().fold(0.0, |mean: f64, own| mean.max(*own));
        let mut span = 0;
        for (axis, (shape, own)) in shapes.iter().zip(own).enumerate() {
            let cycles = Kernel::<S, HISTORY>::cycles(shape.as_ref(), mean - own, cycle);
            if cycles > HISTORY {
                return Err(ShaperError::TooLong { axis, cycles, greatest: HISTORY });
            }
            span = span.max(cycles - 1);
        }
        for (kernel, (shape, own)) in self.kernels.iter_mut().zip(shapes.iter().zip(own)) {
            kernel.set(shape.as_ref(), mean - own, cycle);
        }
        self.known = 0;
        self.span = span;
        self.rested = span + 1;
        self.event = None;
        self.begun = false;
        self.alike = shapes.windows(2).all(|two| two[0] == two[1]);
        #[cfg(feature = "outputs")]
        {
            self.shares = from_fn(|axis| if axis == 0 { S::ONE } else { S::ZERO });
        }
        self.mean = mean;
        self.cycle = cycle;
        Ok(())
    }

    /// What it asks of the motion: [`Config::follower`]. It keeps as much of the tolerance free as the limits of
    /// the axes make it leave the path, but at most half of it: where that is not enough, accelerations are lowered. (In a corner the
    /// speed goes with the root of acceleration times what is left of the band: their product is greatest at the half.)
    ///
    /// For a tolerance that a program changes, give the least one at which curves are run. Without a tolerance no acceleration is
    /// lowered, and all that they make it leave the path is kept free of those that blocks name.
    pub fn follower(&self, config: &Config<S, N>) -> Follower<S, N> {
        // Rounding of the weights, and of what comes of them.
        let safe = 1.001;
        let mut accelerations = config.limits.axes().map(|axis| axis.acceleration.to_f64());
        if let Some(stops) = &config.stop_limits {
            for (most, stop) in accelerations.iter_mut().zip(stops.axes()) {
                *most = most.max(stop.acceleration.to_f64());
            }
        }
        let off: [f64; N] = from_fn(|i| accelerations[i] * self.kernels[i].spread * safe);
        // Without one, blocks that name their own have what the full accelerations need taken off it.
        let tolerance = config.tolerance.to_f64();
        let half = if tolerance > 0.0 { tolerance / 2.0 } else { f64::INFINITY };
        // Each axis may be off by so much: those that are off by less leave the others more.
        let mut level = f64::INFINITY;
        let norm = |level: f64| libm::sqrt(off.iter().map(|x| x.min(level) * x.min(level)).sum());
        if norm(level) > half {
            let mut sorted = off;
            sorted.sort_unstable_by(f64::total_cmp);
            let mut left = half * half;
            for (i, x) in sorted.iter().enumerate() {
                level = libm::sqrt(left / (N - i) as f64);
                if *x > level {
                    break;
                }
                left -= x * x;
            }
        }
        for (most, off) in accelerations.iter_mut().zip(&off) {
            if *off > level {
                *most *= level / off;
            }
        }
        Follower {
            reserve: S::of(norm(level)),
            alike: self.alike,
            settle: S::of(self.span as f64 * self.cycle),
            acceleration: accelerations.map(S::of),
        }
    }

    /// By how much the machine is behind the setpoints, s.
    pub fn delay(&self) -> f64 {
        self.mean * self.cycle
    }

    /// Whether the machine rests where the last setpoint is.
    pub fn is_settled(&self) -> bool {
        // The oldest setpoint that is weighed is `span` cycles before the newest.
        self.rested > self.span || self.span == 0
    }

    /// Where the machine should be, by the setpoint of this servo cycle and those before it.
    ///
    /// What is off the path is not shaped: jogs, probes and homing are where their setpoints are, so that an edge is where it was
    /// seen. They begin when the machine has settled. `Activity::Idle`, `Dwelling` and `Event` are told when it has, too;
    /// the tag is that of the setpoint.
    ///
    /// With the feature `outputs`, arc length and speed along the path are the machine's: a mean by the same weights, which on a straight
    /// line is where the axes are. Where axes are shaped unlike each other, those count that move, by the squares of their speeds: of a
    /// line that is parallel to an axis, this one. Give this setpoint to `Interpolator::switch`, and what
    /// switches does so where the machine is. Without the feature they are those of the setpoint.
    ///
    /// Cost: at rest that of a copy, else a few instructions per weight, axis and derivative: [docs/shaping.md has the numbers].
    ///
    /// [docs/shaping.md has the numbers]: https://docs.rs/crate/splineway/latest/source/docs/shaping.md
    pub fn shape(&mut self, now: &Setpoint<S, N>) -> Setpoint<S, N> {
        let off_path = matches!(now.activity, Activity::Jogging | Activity::Set);
        if !core::mem::replace(&mut self.begun, true) {
            self.begin(now);
        }
        if off_path && self.is_settled() {
            self.keep(now, 0);
            return *now;
        }
        let zero = |of: &[S; N]| of.iter().all(|x| *x == S::ZERO);
        let rests = !off_path
            && now.activity != Activity::Running
            && zero(&now.velocity)
            && zero(&now.acceleration);
        if rests && self.is_settled() {
            self.keep(now, 0);
            self.rested = self.rested.max(self.span + 1);
        } else {
            self.keep(now, (self.known + 1).min(HISTORY.saturating_sub(1)));
            self.rested = if rests { self.rested + 1 } else { 0 };
        }
        let mut shaped = *now;
        if !self.is_settled() {
            self.weigh(&mut shaped);
        }
        shaped.activity = self.told(now);
        if let Activity::Event = shaped.activity
            && let Some((tag, _)) = self.event.take()
        {
            shaped.tag = tag;
        }
        shaped
    }

    /// Before the first setpoint the axes rested: if that is in motion, where they were a servo cycle before. From rest, at a jerk that stays
    /// as it is, an axis goes a third of the way that it goes at its speed at the end.
    #[inline(never)]
    fn begin(&mut self, first: &Setpoint<S, N>) {
        let mut rest = *first;
        let share = S::of(self.cycle / 3.0);
        rest.offset = from_fn(|i| first.offset[i] - first.velocity[i] * share);
        (rest.velocity, rest.acceleration) = ([S::ZERO; N], [S::ZERO; N]);
        #[cfg(feature = "outputs")]
        {
            rest.path_offset = first.path_offset - first.path_speed * share;
            rest.path_speed = S::ZERO;
        }
        self.keep(&rest, 0);
    }

    /// Remembers a setpoint. Before that `known` cycles are.
    fn keep(&mut self, now: &Setpoint<S, N>, known: usize) {
        let next = self.newest + 1;
        self.newest = if next < HISTORY { next } else { 0 };
        self.known = known;
        if let Some(slot) = self.past.get_mut(self.newest) {
            *slot = Past::of(now);
        }
    }

    /// The weighted mean.
    #[inline(never)]
    fn weigh(&mut self, shaped: &mut Setpoint<S, N>) {
        let now = Past::of(shaped);
        for (i, kernel) in self.kernels.iter().enumerate() {
            let (mut behind, mut velocity, mut acceleration) = (S::ZERO, S::ZERO, S::ZERO);
            for tap in &kernel.taps {
                let Some(past) = self.past.get(self.slot(tap.back)) else { continue };
                let mut way = now.offset[i] - past.offset[i];
                // Most lie on the same piece of the motion.
                if past.origin[i] != now.origin[i] {
                    way += now.origin[i].minus::<S>(past.origin[i]);
                }
                behind += tap.weight * way;
                velocity += tap.weight * past.velocity[i];
                acceleration += tap.weight * past.acceleration[i];
            }
            shaped.offset[i] = now.offset[i] - behind;
            shaped.velocity[i] = velocity;
            shaped.acceleration[i] = acceleration;
        }
        #[cfg(feature = "outputs")]
        self.reach(shaped, &now.along);
    }

    /// Where on the path an axis sees the machine.
    #[cfg(feature = "outputs")]
    fn seen_by(&self, kernel: &Kernel<S, HISTORY>, now: &Along<S>) -> Reached<S> {
        let mut reached = Reached { behind: S::ZERO, speed: S::ZERO };
        for tap in &kernel.taps {
            let Some(Past { along, .. }) = self.past.get(self.slot(tap.back)) else { continue };
            reached.behind += tap.weight * now.since(along);
            reached.speed += tap.weight * along.speed;
        }
        reached
    }

    /// Where the setpoint of so many cycles before is kept, or the first that is known.
    #[inline]
    fn slot(&self, back: usize) -> usize {
        let back = back.min(self.known);
        if back <= self.newest {
            self.newest - back
        } else {
            (self.newest + HISTORY).saturating_sub(back)
        }
    }

    /// Where on the path the machine is, by where each axis sees it.
    #[cfg(feature = "outputs")]
    fn reach(&mut self, shaped: &mut Setpoint<S, N>, now: &Along<S>) {
        let mut at = Reached { behind: S::ZERO, speed: S::ZERO };
        if self.alike {
            // The first stands for all.
            if let Some(kernel) = self.kernels.first() {
                at = self.seen_by(kernel, now);
            }
        } else {
            let squares = shaped.velocity.map(|speed| speed * speed);
            let sum = squares.iter().fold(S::ZERO, |sum, square| sum + *square);
            // Between two moves the axes stay those of the last.
            if sum > S::of(LEAST_SPEED * LEAST_SPEED) {
                let part = S::ONE / sum;
                self.shares = squares.map(|square| square * part);
            }
            for (kernel, share) in self.kernels.iter().zip(self.shares) {
                let seen = self.seen_by(kernel, now);
                at.behind += share * seen.behind;
                at.speed += share * seen.speed;
            }
        }
        shaped.path_offset = shaped.path_offset - at.behind;
        shaped.path_speed = at.speed;
    }

    /// What the machine does.
    fn told(&mut self, now: &Setpoint<S, N>) -> Activity {
        if now.activity == Activity::Event {
            let wait = if self.is_settled() { 0 } else { self.span + 1 - self.rested };
            self.event = Some((now.tag, wait));
        }
        match &mut self.event {
            Some((_, 0)) => return Activity::Event,
            Some((_, wait)) => *wait -= 1,
            None => {}
        }
        match now.activity {
            Activity::Idle | Activity::Dwelling | Activity::Event if !self.is_settled() => {
                Activity::Running
            }
            // It is told once.
            Activity::Event => Activity::Dwelling,
            activity => activity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{AxisLimits, Limits};

    fn follower(tolerance: f64, shapes: [Option<Shape>; 2]) -> Follower<f64, 2> {
        let axis = AxisLimits::linear(200.0, 2000.0, 1.0e5);
        let mut config = Config::new(Limits::new([axis; 2]).unwrap());
        config.tolerance = tolerance;
        let mut shaper = Shaper::<f64, 2, 64>::new();
        shaper.set(shapes, &config).unwrap();
        shaper.follower(&config)
    }

    const SHAPE: Shape = Shape { kind: ShaperKind::Zv, frequency: 50.0, damping: 0.0 };

    /// Two impulses `T / 2` apart: half the variance is `T^2 / 32`.
    #[test]
    fn what_is_taken_is_what_accelerations_make_it_leave_the_path() {
        let off = 2000.0 / (32.0 * 50.0 * 50.0);
        let both = f64::sqrt(2.0) * off;
        for (tolerance, reserve) in [(0.2, both), (0.0, both), (0.04, 0.02)] {
            let asked = follower(tolerance, [Some(SHAPE); 2]);
            assert!((asked.reserve / reserve - 1.0).abs() < 0.002, "{asked:?}");
            let borne = 2000.0 * (reserve / both).min(1.0);
            assert!(asked.acceleration.iter().all(|a| (a / borne - 1.0).abs() < 0.002));
            assert!(asked.alike && (asked.settle - 0.01).abs() < 1.0e-9);
        }
        // The other axis only waits, for five servo cycles.
        let asked = follower(0.04, [Some(SHAPE), None]);
        assert!((asked.acceleration[0] / 2000.0 * off - 0.02).abs() < 1.0e-4, "{asked:?}");
        assert!((asked.acceleration[1], asked.alike) == (2000.0, false), "{asked:?}");
    }

    /// A motion of one axis from a place at rest to another at rest, by phases of constant jerk.
    fn motion(from: f64) -> std::vec::Vec<Setpoint<f64, 2>> {
        let (cycle, jerk) = (1.0e-3, 4.0e4);
        let origin = [Coord::from_mm(from).unwrap(), Coord::ZERO];
        let mut at = Setpoint { origin, activity: Activity::Running, ..Setpoint::REST };
        let mut motion = std::vec::Vec::new();
        for k in 0..40 {
            let jerk = if (10..30).contains(&k) { -jerk } else { jerk };
            let (v, a) = (at.velocity[0], at.acceleration[0]);
            at.offset[0] += cycle * (v + cycle * (a / 2.0 + cycle * jerk / 6.0));
            at.velocity[0] = v + cycle * (a + cycle * jerk / 2.0);
            at.acceleration[0] = a + cycle * jerk;
            motion.push(at);
        }
        // The last of them rests, but for a rounding.
        motion.pop();
        (at.velocity, at.acceleration, at.activity) = ([0.0; 2], [0.0; 2], Activity::Idle);
        motion.extend([at; 60]);
        motion
    }

    /// The first setpoint may be in motion, far from zero, and the last of the motion is weighed to its end: position and velocity are
    /// integrals of the acceleration, which changes evenly within each cycle.
    #[test]
    fn a_motion_is_shaped_from_its_beginning_to_its_end() {
        let axis = AxisLimits::linear(200.0, 2000.0, 1.0e5);
        let mut config = Config::new(Limits::new([axis; 2]).unwrap());
        config.cycle = 1.0e-3;
        let kinds = [ShaperKind::Zv, ShaperKind::Mzv, ShaperKind::Ei, ShaperKind::Smooth];
        for (kind, rests) in kinds.into_iter().flat_map(|kind| [(kind, 0), (kind, 3)]) {
            let mut shaper = Shaper::<f64, 2, 64>::new();
            let shape = Shape { kind, frequency: 37.0, damping: 0.05 };
            shaper.set([Some(shape), None], &config).unwrap();
            let motion = motion(133.0);
            let start = Setpoint { origin: motion[0].origin, ..Setpoint::REST };
            for _ in 0..rests {
                assert_eq!(shaper.shape(&start), start);
            }
            let (mut before, h) = (start, config.cycle);
            for (k, now) in motion.iter().enumerate() {
                let now = shaper.shape(now);
                let mean = |of: fn(&Setpoint<f64, 2>) -> f64| f64::midpoint(of(&before), of(&now));
                let gain = now.velocity[0] - before.velocity[0];
                let off = gain - h * mean(|at| at.acceleration[0]);
                assert!(off.abs() < 1.0e-9, "{kind:?} {k}: velocity is off by {off}");
                let bend = now.acceleration[0] - before.acceleration[0];
                let way = h * (mean(|at| at.velocity[0]) - h * bend / 12.0);
                let off = now.position_mm(0) - before.position_mm(0) - way;
                assert!(off.abs() < 1.0e-9, "{kind:?} {k}: position is off by {off}");
                let moving = |x: &f64| x.abs() > 0.0;
                let rests = !now.velocity.iter().chain(&now.acceleration).any(moving);
                assert!(now.activity != Activity::Idle || rests, "{kind:?} {k}");
                before = now;
            }
            assert!(shaper.is_settled() && before.activity == Activity::Idle);
        }
    }

    /// Other weights while any of the motion is still to be weighed would be a step: they are refused, and what was set goes on.
    #[test]
    fn shapers_are_changed_at_rest() {
        let config =
            Config::new(Limits::new([AxisLimits::linear(200.0, 2000.0, 1.0e5); 2]).unwrap());
        let other = [Some(Shape { frequency: 30.0, ..SHAPE }), None];
        for shapes in [[None; 2], [Some(SHAPE), None]] {
            let mut shaper = Shaper::<f64, 2, 64>::new();
            shaper.set(shapes, &config).unwrap();
            let motion = motion(0.0);
            let mut rested = 0;
            for now in &motion {
                let shaped = shaper.shape(now);
                let rests = shaped.activity == Activity::Idle;
                let changed = shaper.set(if rests { shapes } else { other }, &config);
                assert_eq!(changed, if rests { Ok(()) } else { Err(ShaperError::Moving) });
                rested += u32::from(rests);
            }
            assert!(rested > 30, "{rested}");
            shaper.set(other, &config).unwrap();
        }
    }
}
