//! The barrier's second-order model, over the control points and one number that its ends depend on.

use super::banded::{Banded, Square};
use super::barrier::{Change, Tally};
use super::course::weights;
use super::rows::{AxisRows, LengthRow, PlaceRow, Rows};
use super::vector::dot;
use super::{COUPLED, PLACES};
use crate::number::Scalar;
use core::array::from_fn;

impl<S: Scalar, const N: usize> Rows<S, N> for Tally<S> {
    fn axes(&mut self, rows: &AxisRows<'_, S, N>) {
        for shares in &rows.shares {
            for share in shares {
                self.add(*share * *share);
            }
        }
    }

    fn place(&mut self, row: &PlaceRow<'_, S, N>) {
        self.add(row.foot.square * row.inverse);
    }

    fn places_end(&mut self, _: usize) {}

    fn length<const W: usize>(
        &mut self,
        square: S,
        inverse: S,
        _: impl FnOnce() -> LengthRow<S, N, W>,
    ) {
        self.add(square * inverse);
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

/// What a place of a span adds to the model by the place.
#[derive(Clone, Copy, Debug)]
struct Pull<S, const N: usize> {
    slope: [S; N],
    /// Lower half.
    curvature: Square<S, N>,
}

impl<S: Scalar, const N: usize> Pull<S, N> {
    const NONE: Self = Self { slope: [S::ZERO; N], curvature: [[S::ZERO; N]; N] };
}

/// A model that takes rows.
pub(super) struct Modelling<'a, S, const N: usize, const K: usize> {
    model: &'a mut Model<S, N, K>,
    pub(super) tally: Tally<S>,
    /// 1 over the distance of the knots, if that is what the ends depend on.
    knots: Option<S>,
    /// Weights of the control points at the places of a span, and those of any two multiplied.
    weights: [[S; PLACES]; COUPLED],
    products: [[[S; PLACES]; COUPLED]; COUPLED],
    /// The places of this span.
    pulls: [Pull<S, N>; PLACES],
}

impl<'a, S: Scalar, const N: usize, const K: usize> Modelling<'a, S, N, K> {
    pub(super) fn new(model: &'a mut Model<S, N, K>, tally: Tally<S>, knots: Option<S>) -> Self {
        let at: [[S; COUPLED]; PLACES] =
            from_fn(|place| weights(S::from_u32(place as u32 + 1) / S::from_u32(PLACES as u32)));
        let weights = from_fn(|k| from_fn(|place| at[place][k]));
        let products = from_fn(|k| from_fn(|l| from_fn(|place| at[place][k] * at[place][l])));
        let (knots, pulls) = (knots.map(|h| S::ONE / h), [Pull::NONE; PLACES]);
        Self { model, tally, knots, weights, products, pulls }
    }

    /// Adds the rows of an axis.
    fn axis(&mut self, rows: &AxisRows<'_, S, N>, axis: usize) {
        let (two, three) = (S::of(2.0), S::of(3.0));
        let (span, shares, scales) = (rows.span, &rows.shares[axis], &rows.scales[axis]);
        // By the differences.
        let (mut slopes, mut bent, mut borders) = ([S::ZERO; 3], [S::ZERO; 3], [S::ZERO; 3]);
        for k in 0..3 {
            let square = shares[k] * shares[k];
            let change = self.add(square);
            let curvature = change.slope + change.bent * square;
            slopes[k] = change.slope * shares[k] * scales[k];
            bent[k] = curvature * scales[k] * scales[k];
            if let Some(per) = self.knots {
                let degree = S::from_u32(k as u32 + 1) * per;
                let (first, second) = (change.slope * square * degree, curvature * square * degree);
                borders[k] = -(change.slope + curvature) * shares[k] * scales[k] * degree;
                self.model.slope = self.model.slope - first;
                self.model.curvature += second * degree + first * (degree + per);
            }
        }
        let [v, a, j] = bent;
        let (a2, j3) = (two * a, three * j);
        let j9 = three * j3;
        let blocks = &mut self.model.banded.blocks[span..span + COUPLED];
        let mut add = |k: usize, back: usize, by: S| blocks[k][back][axis][axis] += by;
        add(0, 0, v + a + j);
        add(1, 0, v + two * a2 + j9);
        add(1, 1, -(v + a2 + j3));
        add(2, 0, a + j9);
        add(2, 1, -(a2 + j9));
        add(2, 2, a + j3);
        add(3, 0, j);
        add(3, 1, -j3);
        add(3, 2, j3);
        add(3, 3, -j);
        let points = &mut self.model.gradient[span..span + COUPLED];
        for (point, by) in points.iter_mut().zip(of_points(slopes)) {
            point[axis] += by;
        }
        if self.knots.is_some() {
            let points = &mut self.model.border[span..span + COUPLED];
            for (point, by) in points.iter_mut().zip(of_points(borders)) {
                point[axis] += by;
            }
        }
    }

    /// Adds a row, by the square of the share that it is of its limit; how its cost changes.
    fn add(&mut self, square: S) -> Change<S> {
        self.tally.add(square);
        self.tally.barrier.change(square)
    }
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

    /// Of so many control points.
    pub(super) fn clear(&mut self, count: usize) {
        self.banded.clear(count);
        self.gradient[..count].fill([S::ZERO; N]);
        self.border[..count].fill([S::ZERO; N]);
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
    pub(super) fn step(
        &mut self,
        free: core::ops::Range<usize>,
        push: Option<S>,
    ) -> Option<(S, S)> {
        let (first, end) = (free.start, free.end);
        if !self.banded.factor(first, end) {
            return None;
        }
        let (x, y) = (&mut self.gradient, &mut self.border);
        self.banded.forward(first, end, x, y);
        // Halfway to the solutions squares are what the whole way would give as products with the right sides.
        let (mut pull, mut explained, mut falls) = (self.slope, S::ZERO, S::ZERO);
        for (x, y) in x[first..end].iter().zip(&y[first..end]) {
            falls += dot(x, x);
            pull = pull - dot(x, y);
            explained += dot(y, y);
        }
        let mut number = S::ZERO;
        if let Some(push) = push {
            pull += push;
            // Rounding, or an end that would be bent away from: as much as is there counts at least.
            let least = (explained + self.curvature.abs()) * S::of(1.0e-6);
            let left = (self.curvature - explained).greatest(least);
            if !(left > S::ZERO) {
                return None;
            }
            number = -pull / left;
        }
        for k in first..end {
            for i in 0..N {
                x[k][i] = -x[k][i] - number * y[k][i];
            }
        }
        self.banded.backward(first, end, x);
        Some((number, falls - pull * number))
    }
}

impl<S: Scalar, const N: usize, const K: usize> Rows<S, N> for Modelling<'_, S, N, K> {
    fn axes(&mut self, rows: &AxisRows<'_, S, N>) {
        for axis in 0..N {
            self.axis(rows, axis);
        }
    }

    fn place(&mut self, row: &PlaceRow<'_, S, N>) {
        let &PlaceRow { place, foot, direction, inverse } = row;
        let change = self.add(foot.square * inverse);
        let (slope, bent) = (change.slope * inverse, change.bent * inverse * inverse);
        let pull = &mut self.pulls[place];
        for i in 0..N {
            pull.slope[i] = slope * foot.off[i];
            let (off, across) = (bent * foot.off[i], slope * direction[i]);
            for j in 0..=i {
                pull.curvature[i][j] = off * foot.off[j] - across * direction[j];
            }
            pull.curvature[i][i] += slope;
        }
    }

    fn places_end(&mut self, span: usize) {
        let pulls = &self.pulls;
        let points = &mut self.model.gradient[span..span + COUPLED];
        let blocks = &mut self.model.banded.blocks[span..span + COUPLED];
        for k in 0..COUPLED {
            let weights = &self.weights[k];
            for i in 0..N {
                points[k][i] += mixed(weights, |place| pulls[place].slope[i]);
            }
            for other in 0..=k {
                let products = &self.products[k][other];
                let block = &mut blocks[k][k - other];
                for i in 0..N {
                    for j in 0..=i {
                        block[i][j] += mixed(products, |place| pulls[place].curvature[i][j]);
                    }
                }
            }
        }
        self.pulls[PLACES - 1] = Pull::NONE;
    }

    fn length<const W: usize>(
        &mut self,
        square: S,
        inverse: S,
        row: impl FnOnce() -> LengthRow<S, N, W>,
    ) {
        let LengthRow { first, weights, gradient, mut stiffness, stretches } = row();
        let square = square * inverse;
        let change = self.add(square);
        let (slope, bent) = (change.slope * inverse, change.bent * inverse * inverse);
        let model = &mut *self.model;
        for i in 0..N {
            let bent = bent * gradient[i];
            for j in 0..=i {
                stiffness[i][j] = slope * stiffness[i][j] + bent * gradient[j];
            }
        }
        let points = &mut model.gradient[first..first + W];
        let blocks = &mut model.banded.blocks[first..first + W];
        for k in 0..W {
            let by = slope * weights[k];
            for i in 0..N {
                points[k][i] += by * gradient[i];
            }
            for other in 0..=k {
                let both = weights[k] * weights[other];
                let to = &mut blocks[k][k - other];
                for i in 0..N {
                    for j in 0..=i {
                        to[i][j] += both * stiffness[i][j];
                    }
                }
            }
        }
        let (Some(per), true) = (self.knots, stretches) else { return };
        let curved = change.slope + change.bent * square;
        model.slope = model.slope - change.slope * square * per;
        model.curvature += (curved + S::of(2.0) * change.slope) * square * per * per;
        let border = -(curved + change.slope) * inverse * per;
        for k in 0..W {
            for i in 0..N {
                model.border[first + k][i] += border * weights[k] * gradient[i];
            }
        }
    }
}

/// What belongs to the places of a span, by their weights.
fn mixed<S: Scalar>(weights: &[S; PLACES], of: impl Fn(usize) -> S) -> S {
    let mut sum = weights[0] * of(0);
    for place in 1..PLACES {
        sum += weights[place] * of(place);
    }
    sum
}

/// What belongs to first, second and third differences, by the four control points.
fn of_points<S: Scalar>([first, second, third]: [S; 3]) -> [S; COUPLED] {
    let three = S::of(3.0) * third;
    [second - first - third, first - second - second + three, second - three, third]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::AxisLimits;
    use crate::reshape::barrier::Barrier;
    use crate::reshape::rows::rows;
    use crate::reshape::vector::{minus, square};
    use crate::reshape::{Bounds, Draft, Line};

    const N: usize = 3;
    const K: usize = 14;

    /// A motion that cuts the corners of some lines, one that bends gently among them, with limits that it uses by half or more.
    fn case() -> (Draft<f64, N, K>, [Line<f64, N>; 4]) {
        let corners =
            [[0.0; N], [2.0, 0.0, 0.1], [3.0, 0.3, 0.1], [3.5, 2.0, 0.0], [1.0, 3.0, 0.2]];
        let lines = from_fn(|k| {
            let way = minus(&corners[k + 1], &corners[k]);
            let length = square(&way).sqrt();
            let direction = way.map(|x| x / length);
            Line { from: corners[k], direction, length, band: 0.4, feed: 90.0 }
        });
        let mut draft = Draft { points: [[0.0; N]; K], count: K, h: 8.0e-3, joins: 1.0 };
        let (mut line, mut left) = (0, 0.1);
        for k in 0..K {
            let along: [f64; N] = from_fn(|i| {
                lines[line].from[i]
                    + left * lines[line].direction[i]
                    + 0.02 * ((k * 7 + i * 3) % 5) as f64
            });
            draft.points[k] = along;
            left += 0.45;
            if left > lines[line].length {
                left -= lines[line].length;
                line += 1;
            }
        }
        (draft, lines)
    }

    #[test]
    fn a_model_is_that_of_the_sum_and_its_slopes_are_the_sum_s() {
        let (draft, lines) = case();
        let limits = [AxisLimits::linear(200.0, 20_000.0, 5.0e6); N];
        let bounds = Bounds { limits: &limits, lines: &lines, line: 0 };
        let used = [0.9; K];
        let tally = || Tally::new(Barrier::new(0.02));
        let sum = |draft: &Draft<f64, N, K>| {
            let mut tally = tally();
            assert_eq!(rows(draft, &bounds, &used, &mut tally), 3);
            tally.sum()
        };
        let mut model = Model::<f64, N, K>::new();
        let mut modelling = Modelling::new(&mut model, tally(), Some(draft.h));
        rows(&draft, &bounds, &used, &mut modelling);
        assert!((modelling.tally.sum() - sum(&draft)).abs() < 1e-9 * sum(&draft));
        let step = 1e-7;
        for k in 0..K {
            for i in 0..N {
                let [less, more] = [-step, step].map(|by| {
                    let mut other = draft.clone();
                    other.points[k][i] += by;
                    sum(&other)
                });
                let (slope, found) = ((more - less) / (2.0 * step), model.gradient[k][i]);
                // A crossing is come to in a straight line.
                assert!(
                    (slope - found).abs() < 2e-3 * (1.0 + slope.abs()),
                    "{k} {i}: {slope} {found}"
                );
            }
        }
        let [less, more] =
            [-1.0, 1.0].map(|by| sum(&Draft { h: draft.h * (1.0 + by * step), ..draft.clone() }));
        let slope = (more - less) / (2.0 * step * draft.h);
        assert!((slope - model.slope).abs() < 1e-4 * slope.abs(), "{slope} {}", model.slope);
    }
}
