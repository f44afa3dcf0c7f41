//! What bounds the motion over a cell besides its shape: speed, and on a straight acceleration and jerk.

use crate::machine::{AxisLimits, LEAST_CYCLE_SHARE, LimitSets, Limits, UNLIMITED};
use crate::number::Scalar;
use crate::number::vector::{Vector, norm};
use crate::path::node::{Cell, Node};

/// Share of the velocity limits and the feed that is used: the length of a curved cell is known to
/// this much.
const SPEED_SHARE: f64 = 0.9998;

/// Share of its factors that a motor is taken to move more than at steady speed. Where it hardly moves, because what the axes do
/// cancels out, a path that turns makes more of a change of speed than for any axis: up to .0001 of them was seen.
const MOTOR_RESERVE: f64 = 5.0e-4;

/// Jerk along a cell that is not straight, mm/s^3: its axes bound it in other places. A guess takes the root of it, and that
/// of [`UNLIMITED`] would hold speeds down over cells of micrometres.
const NO_JERK_LIMIT: f64 = 1.0e15;

/// How fast the machine may go, and is asked to.
#[derive(Clone, Copy, Debug)]
pub struct Pace<'a, S, const N: usize> {
    pub limits: LimitSets<'a, S, N>,
    /// Servo cycle, s.
    pub cycle: S,
    /// Override of feeds, as a factor.
    pub feed: S,
    /// Override of rapids, as a factor.
    pub rapid: S,
}

/// What bounds the motion over a cell besides its shape.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bounds<S> {
    /// Greatest path speed, mm/s.
    pub speed: S,
    /// Path speed that is asked for, mm/s. It is less than `speed` while the motion slows down to
    /// an override that has just been lowered: no motion could keep it at once.
    pub goal: S,
    /// Greatest path acceleration and jerk on a straight cell.
    pub acceleration: S,
    /// See `acceleration`.
    pub jerk: S,
}

impl<S: Scalar> Bounds<S> {
    /// The bounds of a cell.
    pub fn new<const N: usize>(
        from: &Node<S, N>,
        cell: &Cell<S, N>,
        to: &Node<S, N>,
        Pace { limits, cycle, feed, rapid }: &Pace<'_, S, N>,
    ) -> Self {
        let by = if cell.programmed.rapid { *rapid } else { *feed };
        let mut bounds = Self {
            goal: S::ZERO,
            speed: (cell.programmed.feed * by)
                .least(cell.length / (*cycle * S::of(LEAST_CYCLE_SHARE))),
            acceleration: S::of(UNLIMITED),
            jerk: S::of(NO_JERK_LIMIT),
        };
        let steady = Steady::over(cell.length);
        // Of an axis, or of a motor.
        let mut keep = |shape: [S; 5], axis: &AxisLimits<S>| {
            // At any other speed below the bound its velocity was never seen beyond these by more than the share above leaves.
            let [t0, early, middle, late, t1] = steady.velocities(shape);
            let ends = t0.abs().greatest(t1.abs()).greatest(middle.abs());
            let share = ends.greatest(early.abs()).greatest(late.abs());
            if share * bounds.speed > axis.velocity {
                bounds.speed = axis.velocity / share;
            }
            let fastest = share;
            let share = t0.abs();
            if share * bounds.acceleration > axis.acceleration {
                bounds.acceleration = axis.acceleration / share;
            }
            if share * bounds.jerk > axis.jerk {
                bounds.jerk = axis.jerk / share;
            }
            fastest
        };
        let limits = limits.of(cell.programmed.limits);
        let shape =
            [&from.tangent, &to.tangent, &from.curvature, &to.curvature, &cell.tangent_offset];
        for (i, axis) in limits.axes().iter().enumerate() {
            keep(shape.map(|of| of[i]), axis);
        }
        let mut slower = S::of(UNLIMITED);
        for motor in limits.motors() {
            let mut share = keep(shape.map(|of| motor.of(of)), &motor.limits);
            if !cell.straight {
                share += norm(&motor.factors) * S::of(MOTOR_RESERVE);
            }
            if share * slower > motor.limits.velocity {
                slower = motor.limits.velocity / share;
            }
        }
        bounds.speed = bounds.speed.least(slower);
        if let Some(linear) = cell.programmed.linear.speed::<S>().filter(|_| !cell.straight) {
            // The path's feed is that of its line, which has another share of the linear axes.
            let (share, most) = (steady.linear_share([from, to], cell, limits), linear * by);
            if share * bounds.speed > most {
                bounds.speed = most / share;
            }
        }
        bounds.speed = bounds.speed * S::of(SPEED_SHARE);
        bounds.goal = bounds.speed;
        bounds
    }

    /// The speed, mm/s, that is asked for over its cell at a pace which is no faster, without the work of bounding it anew; `None` if only that tells.
    pub fn goal_at<const N: usize>(
        &self,
        cell: &Cell<S, N>,
        Pace { feed, rapid, .. }: &Pace<'_, S, N>,
    ) -> Option<S> {
        let programmed = cell.programmed;
        let by = if programmed.rapid { *rapid } else { *feed };
        let is_by_path = cell.straight || programmed.linear.speed::<S>().is_none();
        is_by_path.then(|| self.goal.least(programmed.feed * by * S::of(SPEED_SHARE)))
    }
}

/// A cell at steady speed: the velocity of every axis is a quartic, between its Bernstein coefficients.
#[derive(Clone, Copy)]
struct Steady<S> {
    quarter: S,
    per: S,
}

impl<S: Scalar> Steady<S> {
    /// Over a length, mm.
    #[inline]
    fn over(length: S) -> Self {
        Self { quarter: length * S::of(0.25), per: S::of(5.0) / length }
    }

    /// The coefficients, at a path speed of 1, by direction and bend at both ends, and by how far the end lies off the direction at the start.
    #[inline]
    fn velocities(&self, [t0, t1, k0, k1, offset]: [S; 5]) -> [S; 5] {
        let early = t0 + k0 * self.quarter;
        let late = t1 - k1 * self.quarter;
        let middle = S::of(4.0) * t0 + offset * self.per - early - late - t1;
        [t0, early, middle, late, t1]
    }

    /// Most speed over the linear axes at a path speed of 1; none where rotary axes do not move, and all of the path is theirs.
    #[inline(never)]
    fn linear_share<const N: usize>(
        &self,
        [from, to]: [&Node<S, N>; 2],
        cell: &Cell<S, N>,
        limits: &Limits<S, N>,
    ) -> S {
        let (mut squares, mut turns) = ([S::ZERO; 5], false);
        let shape =
            [&from.tangent, &to.tangent, &from.curvature, &to.curvature, &cell.tangent_offset];
        for (i, axis) in limits.axes().iter().enumerate() {
            let at = |of: &Vector<S, N>| of.get(i).copied().unwrap_or(S::ZERO);
            let velocities = self.velocities(shape.map(at));
            if axis.rotary {
                turns |= velocities.iter().any(|v| *v != S::ZERO);
                continue;
            }
            for (square, v) in squares.iter_mut().zip(velocities) {
                *square += v * v;
            }
        }
        let most = squares.into_iter().fold(S::ZERO, S::greatest);
        if turns { most.sqrt() } else { S::ZERO }
    }
}

impl<S: Scalar> Bounds<S> {
    /// The same with only a share of acceleration and jerk.
    #[must_use]
    pub fn share(self, share: S) -> Self {
        Self { acceleration: self.acceleration * share, jerk: self.jerk * share, ..self }
    }
}
