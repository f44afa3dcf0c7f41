//! The barrier's second-order model, over the control points and one number that its ends depend on.

use super::banded::Banded;
use super::barrier::Barrier;
use super::rows::{AxisRow, LengthRow, Rows};
use super::vector::dot;
use crate::number::Scalar;

/// Sum of the costs of all rows.
pub(super) struct Value<'a, S> {
    barrier: &'a Barrier<S>,
    pub(super) sum: S,
    /// Greatest share of a limit.
    pub(super) worst: S,
}

impl<'a, S: Scalar> Value<'a, S> {
    pub(super) fn new(barrier: &'a Barrier<S>) -> Self {
        Self { barrier, sum: S::ZERO, worst: S::ZERO }
    }

    fn add(&mut self, share: S) {
        self.sum += self.barrier.cost(share).value;
        // What is no number is no share that is kept.
        if !(share <= self.worst) {
            self.worst = share;
        }
    }
}

impl<S: Scalar, const N: usize> Rows<S, N> for Value<'_, S> {
    fn axis(&mut self, row: &AxisRow<'_, S>) {
        self.add(row.y.abs());
    }

    fn length(&mut self, row: &LengthRow<'_, S, N>) {
        self.add(row.square.sqrt() / row.limit);
    }
}

/// Gradient and curvature over all control points, and over the distance of the knots where it is free.
#[derive(Debug)]
pub(super) struct Model<S, const N: usize, const K: usize> {
    pub(super) banded: Banded<S, N, K>,
    pub(super) gradient: [[S; N]; K],
    /// Curvature of control points with the number.
    pub(super) border: [[S; N]; K],
    /// Slope and curvature over the number.
    pub(super) slope: S,
    pub(super) curvature: S,
}

/// A model that takes rows; the distance of the knots, if that is what the ends depend on.
pub(super) struct Modelling<'a, S, const N: usize, const K: usize> {
    pub(super) model: &'a mut Model<S, N, K>,
    pub(super) barrier: &'a Barrier<S>,
    pub(super) knots: Option<S>,
}

/// How the control points at both ends depend on the number: their first and second derivative.
pub(super) struct Ends<S, const N: usize> {
    /// The first of the three.
    pub(super) first: usize,
    pub(super) slopes: [[S; N]; 3],
    pub(super) curvatures: [[S; N]; 3],
}

impl<S: Scalar, const N: usize, const K: usize> Model<S, N, K> {
    pub(super) const fn new() -> Self {
        let none = [[S::ZERO; N]; K];
        Self {
            banded: Banded::new(),
            gradient: none,
            border: none,
            slope: S::ZERO,
            curvature: S::ZERO,
        }
    }

    pub(super) fn clear(&mut self) {
        self.banded.clear();
        self.gradient = [[S::ZERO; N]; K];
        self.border = [[S::ZERO; N]; K];
        self.slope = S::ZERO;
        self.curvature = S::ZERO;
    }

    /// Lets three control points follow the number.
    pub(super) fn follow(&mut self, ends: &Ends<S, N>) {
        for (k, slope) in ends.slopes.iter().enumerate() {
            let point = ends.first + k;
            let gradient = &self.gradient[point];
            self.slope += dot(gradient, slope);
            self.curvature +=
                dot(gradient, &ends.curvatures[k]) + S::of(2.0) * dot(&self.border[point], slope);
        }
        let mut own = [[S::ZERO; N]; 3];
        for (k, slope) in ends.slopes.iter().enumerate() {
            let column = ends.first + k;
            for row in column.saturating_sub(3)..(column + 4).min(K) {
                let mut sum = [S::ZERO; N];
                self.banded.times(row, column, slope, &mut sum);
                match row.checked_sub(ends.first) {
                    Some(at @ 0..=2) => {
                        for i in 0..N {
                            own[at][i] += sum[i];
                        }
                    }
                    _ => {
                        for i in 0..N {
                            self.border[row][i] += sum[i];
                        }
                    }
                }
            }
        }
        for (own, slope) in own.iter().zip(&ends.slopes) {
            self.curvature += dot(own, slope);
        }
    }

    /// The step to the least of the model, for the control points of `free` and the number, with `push` added to the slope
    /// over that; none if it is not convex enough. It is left in the gradient; the number's is returned, with how much
    /// the sum falls by.
    pub(super) fn step(&mut self, free: core::ops::Range<usize>, push: S) -> Option<(S, S)> {
        let (first, end) = (free.start, free.end);
        let slope = self.slope + push;
        if !self.banded.factor(first, end) {
            return None;
        }
        let (mut x, mut y) = (self.gradient, self.border);
        self.banded.solve(first, end, &mut x);
        self.banded.solve(first, end, &mut y);
        let (mut pull, mut left, mut falls) = (slope, self.curvature, S::ZERO);
        let mut scale = S::ZERO;
        for k in first..end {
            pull = pull - dot(&self.border[k], &x[k]);
            let explained = dot(&self.border[k], &y[k]);
            left = left - explained;
            scale += explained.abs();
            falls += dot(&self.gradient[k], &x[k]);
        }
        // Rounding, or an end that would be bent away from: as much as is there counts at least.
        left = left.greatest((scale + self.curvature.abs()) * S::of(1.0e-6));
        if !(left > S::ZERO) {
            return None;
        }
        let number = -pull / left;
        for k in first..end {
            for i in 0..N {
                self.gradient[k][i] = -x[k][i] - number * y[k][i];
            }
        }
        Some((number, falls - pull * number))
    }
}

impl<S: Scalar, const N: usize, const K: usize> Rows<S, N> for Modelling<'_, S, N, K> {
    fn axis(&mut self, row: &AxisRow<'_, S>) {
        let cost = self.barrier.cost(row.y.abs());
        let model = &mut *self.model;
        let slope = cost.slope * row.y;
        let bent = cost.curvature * row.scale * row.scale;
        let axis = row.axis;
        for (k, weight) in row.weights.iter().enumerate() {
            let at = row.first + k;
            model.gradient[at][axis] += slope * row.scale * *weight;
            for (back, other) in row.weights[..=k].iter().rev().enumerate() {
                model.banded.blocks[at][back][axis][axis] += bent * *weight * *other;
            }
        }
        let Some(h) = self.knots else { return };
        let degree = S::from_u32(u32::from(row.degree));
        let change = -degree * row.y / h;
        model.slope += slope * change;
        model.curvature +=
            cost.curvature * change * change - slope * change * (degree + S::ONE) / h;
        for (k, weight) in row.weights.iter().enumerate() {
            model.border[row.first + k][axis] +=
                *weight * row.scale * (cost.curvature * change - slope * degree / h);
        }
    }

    fn length(&mut self, row: &LengthRow<'_, S, N>) {
        let inverse = S::ONE / (row.limit * row.limit);
        let square = row.square * inverse;
        let cost = self.barrier.cost(square.sqrt());
        let model = &mut *self.model;
        let slope = cost.slope * inverse;
        let bent = if square > S::of(1.0e-6) {
            (cost.curvature - cost.slope) / square
        } else {
            S::of(4.0)
        } * inverse
            * inverse;
        let mut block = row.stiffness;
        for i in 0..N {
            for j in 0..N {
                block[i][j] = slope * block[i][j] + bent * row.gradient[i] * row.gradient[j];
            }
        }
        for (k, weight) in row.weights.iter().enumerate() {
            let at = row.first + k;
            for i in 0..N {
                model.gradient[at][i] += slope * *weight * row.gradient[i];
            }
            for (back, other) in row.weights[..=k].iter().rev().enumerate() {
                let both = *weight * *other;
                let to = &mut model.banded.blocks[at][back];
                for i in 0..N {
                    for j in 0..N {
                        to[i][j] += both * block[i][j];
                    }
                }
            }
        }
        let (Some(h), 1) = (self.knots, row.degree) else { return };
        model.slope = model.slope - cost.slope * square / h;
        model.curvature += (cost.curvature + S::of(2.0) * cost.slope) * square / (h * h);
        let border = -(cost.curvature + cost.slope) * inverse / h;
        for (k, weight) in row.weights.iter().enumerate() {
            for i in 0..N {
                model.border[row.first + k][i] += border * *weight * row.gradient[i];
            }
        }
    }
}
