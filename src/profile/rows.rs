//! The limits of one cell, as rows r(v0, a0, v1, a1) with |r| < 1 or r < 1.
//!
//! On a cell every axis moves as x(t) = x0' s(t) + y(t): s is the path's quartic ([`Law`]), y the
//! quintic that takes the axis from the tangent to the path, with
//!   y = y' = 0, y'' = E0            at the start, E0 = x0'' v0^2,
//!   y = offset, y' = turn v1, y'' = E1  at the end, E1 = x1'' v1^2 + turn a1, turn = x1' - x0'.
//! Its jerk is a parabola in t. With w = 1 / T the Bernstein coefficients of the whole are
//!   Q0 = x0' j(0)    +  60 offset w^3 - 24 turn v1 w^2 + (3 E1 - 9 E0) w
//!   Q1 = x0' j(mean) - 120 offset w^3 + 60 turn v1 w^2 + (9 E0 - 9 E1) w
//!   Q2 = x0' j(T)    +  60 offset w^3 - 36 turn v1 w^2 + (9 E1 - 3 E0) w
//! and those of the acceleration A0, A0 + Q0 T / 3, A1 - Q2 T / 3, A1. A polynomial lies between
//! its least and greatest Bernstein coefficient: where these keep the limits, the axis keeps them
//! at every instant of the cell. (For the jerk those of either half of the cell are taken: Q0, (Q0 +
//! Q1) / 2, (Q1 + Q2) / 2, Q2, their middle ones being the mean of two of these.) Those of the path speed, v0, v0 + a0 T / 3, v1 - a1 T / 3, v1,
//! are kept below the feed; [`Law`] exists only where they are not below zero.

use super::bounds::Bounds;
use super::law::Law;
use crate::machine::{AxisLimits, Limits, Motor};
use crate::number::Scalar;
use crate::number::vector::sub;
use crate::path::node::{Cell, Node};

/// Gradient by (v0, a0, v1, a1).
pub type Gradient<S> = [S; 4];

/// An end of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Start,
    Finish,
}

/// Takes the rows, some at a time; asks for their gradients if it wants them.
///
/// A row r is a quantity times a scale, and the gradient that goes with it is the quantity's. One at an [`End`]
/// depends on speed and acceleration there alone, and so does its gradient.
pub trait Sink<S> {
    /// Whether gradients are wanted.
    const GRADIENT: bool;
    /// Rows with -1 < r < 1.
    fn two_sided<const M: usize>(
        &mut self,
        r: [S; M],
        scale: [S; M],
        g: impl FnOnce() -> [Gradient<S>; M],
    );
    /// One at an end.
    fn two_sided_at(&mut self, end: End, r: S, scale: S, g: [S; 2]);
    /// Rows with r < 1.
    fn one_sided<const M: usize>(
        &mut self,
        r: [S; M],
        scale: S,
        g: impl FnOnce() -> [Gradient<S>; M],
    );
    /// One at an end.
    fn one_sided_at(&mut self, end: End, r: S, scale: S, g: [S; 2]);
    /// A row with r > 0 and its own gradient.
    fn positive(&mut self, r: S, g: impl FnOnce() -> Gradient<S>);
    /// One at an end.
    fn positive_at(&mut self, end: End, r: S, g: [S; 2]);
    /// Rows that may exceed 1 at a penalty of `weight` times the excess, and their own gradients.
    fn penalised<const M: usize>(
        &mut self,
        r: [S; M],
        weight: S,
        g: impl FnOnce() -> [Gradient<S>; M],
    );
}

/// One cell with all that bounds it.
#[derive(Clone, Copy)]
pub struct View<'a, S, const N: usize> {
    pub from: &'a Node<S, N>,
    pub cell: &'a Cell<S, N>,
    pub to: &'a Node<S, N>,
    pub bounds: Bounds<S>,
    pub limits: &'a Limits<S, N>,
    /// Whether other limits bound the next cell: what is asked at its start says nothing of this one's end then.
    pub leaves: bool,
    /// Share of acceleration and jerk limits that may be used.
    pub share: S,
    /// Penalty on speed above the goal, s for as much again; 0 if there is none.
    pub penalty: S,
    /// Whether there are rows that are no limits, but lead the method.
    pub led: bool,
}

#[cfg(test)]
impl<'a, S: Scalar, const N: usize> View<'a, S, N> {
    /// A cell for its motion alone: without bounds.
    pub fn unbound(
        [from, to]: [&'a Node<S, N>; 2],
        cell: &'a Cell<S, N>,
        limits: &'a Limits<S, N>,
    ) -> Self {
        Self {
            from,
            cell,
            to,
            bounds: Bounds::default(),
            limits,
            leaves: false,
            share: S::ONE,
            penalty: S::ZERO,
            led: true,
        }
    }
}

/// Factors of offset w^3, turn v1 w^2, E0 w and E1 w in one Bernstein coefficient of the jerk.
#[derive(Clone, Copy)]
struct JerkMix {
    offset: f64,
    turn: f64,
    e0: f64,
    e1: f64,
}

/// Those of Q0, Q1, Q2.
const JERK_MIX: [JerkMix; 3] = [
    JerkMix { offset: 60.0, turn: -24.0, e0: -9.0, e1: 3.0 },
    JerkMix { offset: -120.0, turn: 60.0, e0: 9.0, e1: -9.0 },
    JerkMix { offset: 60.0, turn: -36.0, e0: -3.0, e1: 9.0 },
];

/// Parts of an axis's motion, or a motor's, that do not depend on which coefficient is wanted.
#[derive(Clone, Copy)]
pub struct Axis<S> {
    pub tangent: S,
    pub turn: S,
    pub tangent_offset: S,
    pub k0: S,
    pub k1: S,
    /// E0 and E1.
    pub e0: S,
    pub e1: S,
}

impl<S: Scalar> Axis<S> {
    #[inline]
    pub fn new<const N: usize>(view: &View<'_, S, N>, law: &Law<S>, i: usize) -> Self {
        let tangent = view.from.tangent[i];
        let turn = view.to.tangent[i] - tangent;
        let curvature = [view.from.curvature[i], view.to.curvature[i]];
        Self::made(law, [tangent, turn, view.cell.tangent_offset[i]], curvature)
    }

    /// What a motor does is a sum of what the axes do, and so are all its parts.
    #[inline]
    pub fn of_motor<const N: usize>(
        view: &View<'_, S, N>,
        law: &Law<S>,
        motor: &Motor<S, N>,
    ) -> Self {
        let (from, to) = (view.from, view.to);
        let turn = sub(&to.tangent, &from.tangent);
        let shape = [&from.tangent, &turn, &view.cell.tangent_offset].map(|of| motor.of(of));
        Self::made(law, shape, [&from.curvature, &to.curvature].map(|of| motor.of(of)))
    }

    #[inline]
    fn made(law: &Law<S>, [tangent, turn, tangent_offset]: [S; 3], [k0, k1]: [S; 2]) -> Self {
        Self {
            tangent,
            turn,
            tangent_offset,
            k0,
            k1,
            e0: k0 * law.v0 * law.v0,
            e1: k1 * law.v1 * law.v1 + turn * law.a1,
        }
    }

    /// The Bernstein coefficients of the axis jerk, mm/s3.
    #[inline]
    pub fn jerks(&self, law: &Law<S>) -> [S; 3] {
        let [first, middle, last] = JERK_MIX;
        let [q0, q1, q2] = law.jerk;
        [self.jerk(law, q0, first), self.jerk(law, q1, middle), self.jerk(law, q2, last)]
    }

    #[inline]
    fn jerk(&self, law: &Law<S>, jerk: S, JerkMix { offset, turn, e0, e1 }: JerkMix) -> S {
        let w = law.rate;
        self.tangent * jerk
            + ((S::of(offset) * self.tangent_offset * w + S::of(turn) * self.turn * law.v1) * w
                + S::of(e0) * self.e0
                + S::of(e1) * self.e1)
                * w
    }
}

/// Gradients of the path motion, shared by all axes.
struct Slopes<S> {
    time: Gradient<S>,
    rate: Gradient<S>,
    jerk: [Gradient<S>; 3],
}

/// Gradient of the duration by (v0, a0, v1, a1).
#[inline]
pub fn time_gradient<S: Scalar>(law: &Law<S>) -> Gradient<S> {
    let per_speed = -(law.time * S::of(0.5)) / law.root;
    let per_acceleration = law.time * law.time * S::of(1.0 / 12.0) / law.root;
    [per_speed, -per_acceleration, per_speed, per_acceleration]
}

impl<S: Scalar> Slopes<S> {
    #[inline]
    fn new(law: &Law<S>) -> Self {
        let w = law.rate;
        let time = time_gradient(law);
        let rate = scaled(&time, -(w * w));
        let half = S::of(0.5);
        let step = law.a1 - law.a0;
        let direct_twist = [w, half, -w, half];
        let direct_slope = [S::ZERO, -w, S::ZERO, w];
        let mut jerk = [[S::ZERO; 4]; 3];
        for k in 0..4 {
            let twist = direct_twist[k] - law.gain * rate[k];
            let slope = direct_slope[k] + step * rate[k];
            let swing = S::of(6.0) * (twist * w + law.twist * rate[k]);
            jerk[0][k] = slope - swing;
            jerk[1][k] = slope;
            jerk[2][k] = slope + swing;
        }
        Self { time, rate, jerk }
    }
}

/// Hands every row of a cell to the sink.
#[inline]
pub fn rows<S: Scalar, const N: usize, K: Sink<S>>(
    view: &View<'_, S, N>,
    law: &Law<S>,
    sink: &mut K,
) {
    let slopes = if K::GRADIENT {
        Slopes::new(law)
    } else {
        Slopes { time: [S::ZERO; 4], rate: [S::ZERO; 4], jerk: [[S::ZERO; 4]; 3] }
    };
    speed_rows(view, law, &slopes, sink);
    if view.cell.straight {
        straight_rows(view, law, &slopes, sink);
    } else {
        for (i, limits) in view.limits.axes().iter().enumerate() {
            axis_rows(view, law, &slopes, (&Axis::new(view, law, i), limits), sink);
        }
        for motor in view.limits.motors() {
            let axis = Axis::of_motor(view, law, motor);
            axis_rows(view, law, &slopes, (&axis, &motor.limits), sink);
        }
    }
}

/// A gradient times a factor. (Written out, here and below, because the compiler does better with
/// it than with the array functions of the standard library: a fifth of the planner's work.)
#[inline]
fn scaled<S: Scalar>(g: &Gradient<S>, factor: S) -> Gradient<S> {
    [g[0] * factor, g[1] * factor, g[2] * factor, g[3] * factor]
}

/// The sum of two gradients, each times a factor.
#[inline]
fn mixed<S: Scalar>((f, factor): (&Gradient<S>, S), (g, other): (&Gradient<S>, S)) -> Gradient<S> {
    let part = |k: usize| f[k] * factor + g[k] * other;
    [part(0), part(1), part(2), part(3)]
}

/// The sum of two gradients.
#[inline]
fn sum<S: Scalar>(f: &Gradient<S>, g: &Gradient<S>) -> Gradient<S> {
    [f[0] + g[0], f[1] + g[1], f[2] + g[2], f[3] + g[3]]
}

/// Path speed: Bernstein coefficients of s'(t).
#[inline]
fn speed_rows<S: Scalar, const N: usize, K: Sink<S>>(
    view: &View<'_, S, N>,
    law: &Law<S>,
    slopes: &Slopes<S>,
    sink: &mut K,
) {
    let (zero, one) = (S::ZERO, S::ONE);
    let third = S::of(1.0 / 3.0);
    let [early, late] = law.inner_speeds();
    let inner = || {
        let reach = law.time * third;
        let mut early = scaled(&slopes.time, law.a0 * third);
        early[0] += one;
        early[1] += reach;
        let mut late = scaled(&slopes.time, -(law.a1 * third));
        late[2] += one;
        late[3] -= reach;
        [early, late]
    };
    let per = one / view.bounds.speed;
    sink.one_sided_at(End::Start, law.v0 * per, per, [one, zero]);
    sink.one_sided_at(End::Finish, law.v1 * per, per, [one, zero]);
    sink.one_sided([early * per, late * per], per, inner);
    if view.penalty > zero {
        let per = one / view.bounds.goal;
        let speeds = [law.v0, law.v1, early, late];
        sink.penalised(scaled(&speeds, per), view.penalty, || {
            let [early, late] = inner();
            let ends = [[one, zero, zero, zero], [zero, zero, one, zero]];
            [scaled(&ends[0], per), scaled(&ends[1], per), scaled(&early, per), scaled(&late, per)]
        });
    }
    if view.led {
        forward_rows(view, law, sink);
    }
}

/// Never backwards: Bernstein coefficients of the cubic b(s) between the nodes, and the
/// discriminant of the duration with v0 v1 left out. They are linear in (b, a), so that the
/// method is not led into a corner where speed, acceleration and duration all vanish.
#[inline]
fn forward_rows<S: Scalar, const N: usize, K: Sink<S>>(
    view: &View<'_, S, N>,
    law: &Law<S>,
    sink: &mut K,
) {
    let zero = S::ZERO;
    let per = S::ONE / (view.bounds.speed * view.bounds.speed);
    let third = view.cell.length * S::of(1.0 / 3.0) * per;
    let two = S::of(2.0);
    let (b0, b1) = (law.v0 * law.v0 * per, law.v1 * law.v1 * per);
    if law.v0 > zero {
        let r = b0 + two * third * law.a0;
        sink.positive_at(End::Start, r, [two * law.v0 * per, two * third]);
    }
    if law.v1 > zero {
        let r = b1 - two * third * law.a1;
        sink.positive_at(End::Finish, r, [two * law.v1 * per, -(two * third)]);
    }
    let share = S::of(0.24);
    let r = share * (b0 + b1) + third * (law.a0 - law.a1);
    let slope = two * share * per;
    sink.positive(r, || [slope * law.v0, third, slope * law.v1, -third]);
}

/// A straight cell: the axis that binds first binds everywhere.
#[inline]
fn straight_rows<S: Scalar, const N: usize, K: Sink<S>>(
    view: &View<'_, S, N>,
    law: &Law<S>,
    slopes: &Slopes<S>,
    sink: &mut K,
) {
    let (zero, one) = (S::ZERO, S::ONE);
    let per = one / view.bounds.jerk;
    // The jerk is linear in time: greatest at an end.
    let ([j0, _, j2], [g0, _, g2]) = (law.jerk, slopes.jerk);
    sink.two_sided([j0 * per, j2 * per], [per; 2], || [g0, g2]);
    let ends = Ends {
        per: one / view.bounds.acceleration,
        leaves: view.leaves,
        acceleration: [law.a0, law.a1],
        gradients: [[zero, one]; 2],
        jerk: [Term { value: j0, gradient: g0 }, Term { value: j2, gradient: g2 }],
    };
    acceleration_rows(law, slopes, &ends, sink);
}

/// One axis of a curved cell, or one motor.
#[inline]
fn axis_rows<S: Scalar, const N: usize, K: Sink<S>>(
    view: &View<'_, S, N>,
    law: &Law<S>,
    slopes: &Slopes<S>,
    (axis, limits): (&Axis<S>, &AxisLimits<S>),
    sink: &mut K,
) {
    let zero = S::ZERO;
    let bent =
        axis.turn != zero || axis.tangent_offset != zero || axis.k0 != zero || axis.k1 != zero;
    if !bent && axis.tangent == zero {
        return;
    }
    let two = S::of(2.0);
    let gradients = if K::GRADIENT { axis.jerk_gradients(law, slopes) } else { [[zero; 4]; 3] };
    // The coefficients of either half of the cell: a kinked path swings the middle one of the whole
    // far beyond any jerk that occurs.
    let per = S::ONE / (limits.jerk * view.share);
    let half = S::of(0.5) * per;
    let [q0, q1, q2] = axis.jerks(law);
    let rows = [q0 * per, (q0 + q1) * half, (q1 + q2) * half, q2 * per];
    sink.two_sided(rows, [per, half, half, per], || {
        let [g0, g1, g2] = &gradients;
        [*g0, sum(g0, g1), sum(g1, g2), *g2]
    });
    let ends = Ends {
        per: S::ONE / (limits.acceleration * view.share),
        leaves: view.leaves,
        acceleration: [axis.e0 + axis.tangent * law.a0, axis.e1 + axis.tangent * law.a1],
        gradients: [
            [two * axis.k0 * law.v0, axis.tangent],
            [two * axis.k1 * law.v1, axis.tangent + axis.turn],
        ],
        jerk: [
            Term { value: q0, gradient: gradients[0] },
            Term { value: q2, gradient: gradients[2] },
        ],
    };
    acceleration_rows(law, slopes, &ends, sink);
}

impl<S: Scalar> Axis<S> {
    /// Gradients of the Bernstein coefficients of the axis jerk.
    #[inline]
    fn jerk_gradients(&self, law: &Law<S>, slopes: &Slopes<S>) -> [Gradient<S>; 3] {
        let (w, two) = (law.rate, S::of(2.0));
        let gradient = |slope: &Gradient<S>, JerkMix { offset, turn, e0, e1 }: JerkMix| {
            let (offset, turn, e0, e1) = (S::of(offset), S::of(turn), S::of(e0), S::of(e1));
            let per_rate = (S::of(3.0) * offset * self.tangent_offset * w
                + two * turn * self.turn * law.v1)
                * w
                + e0 * self.e0
                + e1 * self.e1;
            let mut g = mixed((slope, self.tangent), (&slopes.rate, per_rate));
            g[0] += two * e0 * self.k0 * law.v0 * w;
            g[2] += (turn * self.turn * w + two * e1 * self.k1 * law.v1) * w;
            g[3] += e1 * self.turn * w;
            g
        };
        let ([s0, s1, s2], [first, middle, last]) = (&slopes.jerk, JERK_MIX);
        [gradient(s0, first), gradient(s1, middle), gradient(s2, last)]
    }
}

/// A term of a row, with its gradient by (v0, a0, v1, a1).
#[derive(Clone, Copy)]
struct Term<S> {
    value: S,
    gradient: Gradient<S>,
}

/// Acceleration at both ends of a cell and jerk next to them.
struct Ends<S> {
    /// 1 / limit of the acceleration.
    per: S,
    /// Whether that of the next cell is another.
    leaves: bool,
    acceleration: [S; 2],
    /// Gradients of the acceleration by speed and acceleration along the path at the same end.
    gradients: [[S; 2]; 2],
    jerk: [Term<S>; 2],
}

/// Bernstein coefficients A0, A0 + Q0 T / 3, A1 - Q2 T / 3. The fourth, A1, is A0 of the next cell, or 0
/// at a rest: the path's second derivative is continuous everywhere else. It has a row of its own only where other limits
/// bound the next cell.
#[inline]
fn acceleration_rows<S: Scalar, K: Sink<S>>(
    law: &Law<S>,
    slopes: &Slopes<S>,
    ends: &Ends<S>,
    sink: &mut K,
) {
    let third = S::of(1.0 / 3.0);
    let reach = law.time * third;
    let per = ends.per;
    let [a0, a1] = ends.acceleration;
    let [q0, q2] = &ends.jerk;
    let inner =
        |jerk: &Gradient<S>, reach: S, per_time: S| mixed((jerk, reach), (&slopes.time, per_time));
    sink.two_sided_at(End::Start, a0 * per, per, ends.gradients[0]);
    if ends.leaves {
        sink.two_sided_at(End::Finish, a1 * per, per, ends.gradients[1]);
    }
    let early = a0 + q0.value * reach;
    let late = a1 - q2.value * reach;
    sink.two_sided([early * per, late * per], [per; 2], || {
        let mut early = inner(&q0.gradient, reach, q0.value * third);
        let mut late = inner(&q2.gradient, -reach, -(q2.value * third));
        let [[v0, a0], [v1, a1]] = ends.gradients;
        early[0] += v0;
        early[1] += a0;
        late[2] += v1;
        late[3] += a1;
        [early, late]
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::LimitSets;
    use crate::number::Coord;
    use crate::path::node::Programmed;
    use crate::profile::bounds::Pace;
    use crate::profile::law::PathState;
    use std::vec::Vec;

    #[derive(Default)]
    struct List {
        rows: Vec<(f64, Gradient<f64>)>,
    }

    /// At an end: the other entries are 0.
    fn whole(end: End, [v, a]: [f64; 2]) -> Gradient<f64> {
        if end == End::Start { [v, a, 0.0, 0.0] } else { [0.0, 0.0, v, a] }
    }

    impl Sink<f64> for List {
        const GRADIENT: bool = true;
        fn two_sided<const M: usize>(
            &mut self,
            r: [f64; M],
            scale: [f64; M],
            g: impl FnOnce() -> [Gradient<f64>; M],
        ) {
            let g = g();
            self.rows.extend((0..M).map(|k| (r[k], scaled(&g[k], scale[k]))));
        }
        fn two_sided_at(&mut self, end: End, r: f64, scale: f64, g: [f64; 2]) {
            self.rows.push((r, scaled(&whole(end, g), scale)));
        }
        fn one_sided<const M: usize>(
            &mut self,
            r: [f64; M],
            scale: f64,
            g: impl FnOnce() -> [Gradient<f64>; M],
        ) {
            self.two_sided(r, [scale; M], g);
        }
        fn one_sided_at(&mut self, end: End, r: f64, scale: f64, g: [f64; 2]) {
            self.two_sided_at(end, r, scale, g);
        }
        fn positive(&mut self, r: f64, g: impl FnOnce() -> Gradient<f64>) {
            self.rows.push((r, g()));
        }
        fn positive_at(&mut self, end: End, r: f64, g: [f64; 2]) {
            self.two_sided_at(end, r, 1.0, g);
        }
        fn penalised<const M: usize>(
            &mut self,
            r: [f64; M],
            _: f64,
            g: impl FnOnce() -> [Gradient<f64>; M],
        ) {
            self.rows.extend(r.into_iter().zip(g()));
        }
    }

    fn list(straight: bool, x: [f64; 4]) -> Vec<(f64, Gradient<f64>)> {
        let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
        let limits = Limits::new([axis; 2]).unwrap();
        let (h, k) = (0.5f64, if straight { 0.0 } else { 1.0 });
        let phi: f64 = h * k * 0.9;
        let from =
            Node { at: [Coord::ZERO; 2], tangent: [0.8, 0.6], curvature: [-0.6 * k, 0.8 * k] };
        let t1 = [0.8 * phi.cos() - 0.6 * phi.sin(), 0.6 * phi.cos() + 0.8 * phi.sin()];
        let to = Node {
            at: [Coord::ZERO; 2],
            tangent: t1,
            curvature: [-0.5 * k * t1[1], 0.5 * k * t1[0]],
        };
        let cell = Cell {
            length: h,
            tangent_offset: [-0.07 * k, 0.09 * k],
            programmed: Programmed::feed(100.0),
            dwell: 0.0,
            event: None,
            straight,
        };
        let bounds = Bounds::new(
            &from,
            &cell,
            &to,
            &Pace { limits: LimitSets::only(&limits), cycle: 1e-3, feed: 1.0, rapid: 1.0 },
        );
        let law = Law::new(
            h,
            PathState { b: x[0] * x[0], a: x[1] },
            PathState { b: x[2] * x[2], a: x[3] },
        )
        .unwrap();
        let mut sink = List::default();
        rows(
            &View {
                from: &from,
                cell: &cell,
                to: &to,
                bounds,
                limits: &limits,
                leaves: true,
                share: 1.0,
                penalty: 1.0,
                led: true,
            },
            &law,
            &mut sink,
        );
        sink.rows
    }

    /// Every gradient against central differences.
    #[test]
    fn gradients_agree_with_differences() {
        for straight in [true, false] {
            let x = [20.0, 150.0, 26.0, -220.0];
            let here = list(straight, x);
            for k in 0..4 {
                let step = 1e-4 * x[k].abs();
                let (mut up, mut down) = (x, x);
                up[k] += step;
                down[k] -= step;
                for ((row, a), b) in here.iter().zip(list(straight, up)).zip(list(straight, down)) {
                    let difference = (a.0 - b.0) / (2.0 * step);
                    let scale = difference.abs().max(row.1[k].abs()).max(1e-6);
                    assert!(
                        (difference - row.1[k]).abs() < 1e-4 * scale,
                        "{straight} {k}: {difference} {}",
                        row.1[k]
                    );
                }
            }
        }
    }
}
