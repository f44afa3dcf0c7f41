//! A cubic curve that is taken into the look-ahead: as chords, made one at a time as there is room.
//!
//! The chords stay within a small share of the tolerance of the curve ([`budget::Chords`]), and the run they become
//! ([`super::run`]) within the rest of it: so a curve is followed within its tolerance, and curves that
//! join with the same tangent go on smoothly, whatever their curvature does. A curve that is straight
//! within that share - a line written as a curve, also one that runs back on itself - is one line to
//! each of its turning points, at which the motion rests, and to its end.

use super::budget;
#[cfg(feature = "travel")]
use super::extent::Extent;
use crate::block::range::{check_coordinates, in_range};
use crate::block::{Block, BlockError, Feed, Motion};
use crate::machine::{Config, Quantity};
use crate::number::{Coord, Range, Scalar};
use crate::spline::bezier::cubic_from_origin;
use core::array::from_fn;

/// Most chords of a curve.
const MOST: f64 = 1.0e6;
/// Parts in which the length of a curve is found, for inverse-time feeds.
const PARTS: u32 = 64;

/// What is left of a curve.
#[derive(Clone, Copy, Debug)]
pub struct Chords<S, const N: usize> {
    /// The chords' common data.
    line: Block<S, N>,
    exact_stop: bool,
    start: [Coord; N],
    end: [Coord; N],
    /// From the start to the other three Bezier points, mm.
    offsets: [[f64; N]; 3],
    /// Length, mm, where a duration makes a speed of it; else none.
    length: S,
    cut: Cut,
    count: u32,
    next: u32,
}

/// Where a curve is cut.
#[derive(Clone, Copy, Debug)]
enum Cut {
    /// At equal steps of the parameter.
    Even,
    /// At these parameters and the end: the turning points of a straight one.
    At([f64; 2]),
}

impl<S: Scalar, const N: usize> Chords<S, N> {
    /// A curve that starts at `from`, checked; `None` if the block is none.
    #[inline(never)]
    pub fn new(
        from: [Coord; N],
        block: &Block<S, N>,
        config: &Config<S, N>,
    ) -> Result<Option<Self>, BlockError> {
        let Motion::Cubic { controls, to } = block.motion else { return Ok(None) };
        for point in [&controls[0], &controls[1], &to] {
            check_coordinates(point)?;
        }
        let asked = budget::tolerance(block, config);
        let tolerance = budget::of_setpoints(asked, config);
        let quantity = Quantity::CurveTolerance;
        if tolerance < S::of(quantity.range().least) {
            let least = quantity.range().least + config.reserve().to_f64();
            let error = Range { least, ..quantity.range() }.refused(asked.to_f64());
            return Err(BlockError::OutOfRange { quantity, error });
        }
        in_range(quantity, tolerance)?;
        let offsets =
            [controls[0], controls[1], to].map(|point| from_fn(|i| point[i].minus::<f64>(from[i])));
        #[cfg(feature = "travel")]
        let tolerance = extent((&from, &to), &offsets).within(&config.travel, &from, tolerance)?;
        let budget::Chords { sag, rest } = budget::Chords::new(tolerance);
        let mut line = *block;
        line.tolerance = Some(rest);
        line.exact_stop = false;
        let mut chords = Self {
            line,
            exact_stop: block.exact_stop,
            start: from,
            end: to,
            offsets,
            length: S::ZERO,
            cut: Cut::Even,
            count: 1,
            next: 1,
        };
        if let Feed::Duration(_) = block.feed {
            chords.length = chords.measured();
        }
        if let Some((count, at)) = turning_points(&offsets, sag) {
            (chords.count, chords.cut) = (count + 1, Cut::At(at));
            return Ok(Some(chords));
        }
        let count = libm::ceil(Scalar::sqrt(0.75 * bend(&offsets) / sag));
        if count > MOST {
            let least = tolerance.to_f64() * (count / MOST) * (count / MOST);
            let quantity = Quantity::CurveTolerance;
            let error = Range { least, ..quantity.range() }.refused(tolerance.to_f64());
            return Err(BlockError::OutOfRange { quantity, error });
        }
        chords.count = (count as u32).max(1);
        Ok(Some(chords))
    }

    /// Where the curve ends.
    pub fn end(&self) -> &[Coord; N] {
        &self.end
    }

    /// Length of the whole curve, mm, if its feed is a duration; else none.
    pub fn whole(&self) -> S {
        self.length
    }

    /// From the start to the place at a share of the parameter, mm.
    fn offset(&self, u: f64) -> [f64; N] {
        cubic_from_origin(&self.offsets, u)
    }

    /// The place at a share of the parameter: between the least and the greatest coordinates of the Bezier
    /// points, as it is but for rounding, so that it is a coordinate that is accepted.
    fn place(&self, u: f64) -> [Coord; N] {
        let offset = self.offset(u);
        from_fn(|i| {
            let (mut least, mut greatest) = (self.start[i], self.start[i]);
            for point in self.points() {
                (least, greatest) = (least.min(point[i]), greatest.max(point[i]));
            }
            // (`clamp` could panic, for all that the compiler sees of it for size.)
            self.start[i].plus(offset[i]).max(least).min(greatest)
        })
    }

    /// The three Bezier points behind the start.
    fn points(&self) -> [[Coord; N]; 3] {
        match self.line.motion {
            Motion::Cubic { controls: [a, b], to } => [a, b, to],
            _ => [self.end; 3],
        }
    }

    /// Length, mm: the integral of the speed along it, by Simpson's rule in equal parts.
    fn measured(&self) -> S {
        let [a, b, c] = self.offsets.map(|offset| offset.map(S::of));
        let two = S::of(2.0);
        let speed = |u: S| -> S {
            let v = S::ONE - u;
            let mut square = S::ZERO;
            for i in 0..N {
                let d = v * v * a[i] + two * v * u * (b[i] - a[i]) + u * u * (c[i] - b[i]);
                square += d * d;
            }
            square.sqrt()
        };
        let step = S::of(1.0 / f64::from(PARTS));
        let mut sum = S::ZERO;
        for k in 0..PARTS {
            let u = S::from_u32(k) * step;
            sum += speed(u) + S::of(4.0) * speed(u + step * S::of(0.5)) + speed(u + step);
        }
        sum * step * S::of(3.0 / 6.0)
    }

    /// The next chord, as a line.
    pub fn line(&self) -> Block<S, N> {
        let last = self.next >= self.count;
        let to = match self.cut {
            _ if last => self.end,
            Cut::Even => self.place(f64::from(self.next) / f64::from(self.count)),
            Cut::At([first, second]) => self.place(if self.next == 1 { first } else { second }),
        };
        Block { motion: Motion::Line { to }, exact_stop: last && self.exact_stop, ..self.line }
    }

    /// Moves on to the chord after it; `None` if that was the last.
    #[inline(never)]
    pub fn advanced(&self) -> Option<Self> {
        (self.next < self.count).then_some(Self { next: self.next + 1, ..*self })
    }
}

/// A sixth of the greatest second derivative by the parameter of a cubic from 0, mm: the greater of the
/// second differences of its Bezier points.
fn bend<const N: usize>([a, b, c]: &[[f64; N]; 3]) -> f64 {
    let (mut early, mut late) = (0.0, 0.0);
    for i in 0..N {
        early += (b[i] - 2.0 * a[i]) * (b[i] - 2.0 * a[i]);
        let x = c[i] - 2.0 * b[i] + a[i];
        late += x * x;
    }
    Scalar::sqrt(f64::max(early, late))
}

/// How many turning points a straight cubic from 0 has, and where, by the parameter; `None` if it leaves
/// the line to its farthest Bezier point by more than `sag`.
fn turning_points<const N: usize>(offsets: &[[f64; N]; 3], sag: f64) -> Option<(u32, [f64; 2])> {
    let square = |offset: &[f64; N]| offset.iter().map(|x| x * x).sum::<f64>();
    let [mut farthest, others @ ..] = *offsets;
    for offset in others {
        if square(&offset) > square(&farthest) {
            farthest = offset;
        }
    }
    let size = Scalar::sqrt(square(&farthest));
    if !(size > 0.0) {
        return Some((0, [1.0; 2]));
    }
    let along =
        offsets.map(|offset| offset.iter().zip(&farthest).map(|(x, d)| x * d).sum::<f64>() / size);
    for (offset, along) in offsets.iter().zip(along) {
        let off: [f64; N] = from_fn(|i| offset[i] - along * farthest[i] / size);
        if square(&off) > sag * sag {
            return None;
        }
    }
    let [first, second] = turns(along);
    Some((u32::from(first < 1.0) + u32::from(second < 1.0), [first, second]))
}

/// Where a cubic from 0 along an axis turns back, by the parameter, in order; 1 for what it has not.
fn turns([a, b, c]: [f64; 3]) -> [f64; 2] {
    // The first derivative is a parabola: v^2 d0 + 2 v u d1 + u^2 d2, zero where the
    // quotient r = u / v of d2 r^2 + 2 d1 r + d0 = 0 is positive.
    let (d0, d1, d2) = (a, b - a, c - b);
    let inner = d1 * d1 - d0 * d2;
    if inner <= 0.0 {
        return [1.0; 2];
    }
    let sum = d1 + if d1 < 0.0 { -Scalar::sqrt(inner) } else { Scalar::sqrt(inner) };
    // u / (u + v) with u and v up to a common factor.
    let parameter = |u: f64, v: f64| if u * v > 0.0 { u / (u + v) } else { 1.0 };
    let (p, q) = (parameter(-sum, d2), parameter(-d0, sum));
    if p < q { [p, q] } else { [q, p] }
}

/// How far a cubic curve reaches.
#[cfg(feature = "travel")]
fn extent<const N: usize>(
    (from, to): (&[Coord; N], &[Coord; N]),
    offsets: &[[f64; N]; 3],
) -> Extent<N> {
    let mut extent = Extent::between(from, to);
    for axis in 0..N {
        for u in turns(offsets.map(|offset| offset[axis])) {
            if u < 1.0 {
                extent.reach(axis, from[axis].plus(cubic_from_origin(offsets, u)[axis]));
            }
        }
    }
    extent
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{AxisLimits, Limits};
    use std::vec::Vec;

    fn config() -> Config<f64, 2> {
        let axis = AxisLimits::linear(1.0, 1.0, 1.0);
        Config::new(Limits::new([axis; 2]).unwrap())
    }

    fn at(x: f64, y: f64) -> [Coord; 2] {
        [x, y].map(|x| Coord::from_mm(x).unwrap())
    }

    fn ends(from: [Coord; 2], points: [[Coord; 2]; 3]) -> Vec<[f64; 2]> {
        let block = Block::cubic([points[0], points[1]], points[2], 1.0, 0);
        let mut left = Chords::new(from, &block, &config()).unwrap();
        let mut list = Vec::new();
        while let Some(chords) = left {
            let Motion::Line { to } = chords.line().motion else { panic!("no line") };
            check_coordinates(&to).unwrap();
            list.push(to.map(Coord::to_mm));
            left = chords.advanced();
        }
        list
    }

    #[test]
    fn a_line_written_as_a_curve_is_one_line() {
        let (a, b) = (at(0.0, 0.0), at(30.0, 40.0));
        for points in [[a, a, b], [a, b, b], [b, b, b], [at(10.5, 14.0), at(18.0, 24.0), b]] {
            assert_eq!(ends(a, points), [[30.0, 40.0]]);
        }
        assert_eq!(ends(a, [a, a, a]), [[0.0, 0.0]]);
    }

    #[test]
    fn a_straight_curve_is_cut_where_it_turns_back() {
        let a = at(0.0, 0.0);
        // x = 3 u v^2 10 - 3 u^2 v 10: turning points at (3 -+ sqrt(3)) / 6.
        let list = ends(a, [at(10.0, 0.0), at(-10.0, 0.0), a]);
        assert_eq!(list.len(), 3);
        let most = 5.0 / f64::sqrt(3.0);
        assert!(
            (list[0][0] - most).abs() < 1.0e-9 && (list[1][0] + most).abs() < 1.0e-9,
            "{list:?}"
        );
        // There and back.
        let list = ends(a, [at(0.0, 8.0), at(0.0, 8.0), a]);
        assert_eq!(list.len(), 2);
        assert!((list[0][1] - 6.0).abs() < 1.0e-9);
        // Overshooting the end.
        assert_eq!(ends(a, [at(4.0, 0.0), at(9.0, 0.0), at(5.0, 0.0)]).len(), 2);
    }

    #[test]
    fn no_chord_leaves_the_range_of_coordinates() {
        for k in 0..200 {
            let s = f64::from(k) * 7.31 - 700.0;
            let edge = |y: f64| at(1.0e6, y);
            let list = ends(at(s * 1000.0, 0.0), [edge(-s), edge(s * 0.5), edge(s)]);
            assert!(list.iter().all(|p| p[0] <= 1.0e6));
            let along = ends(edge(0.0), [edge(s), edge(-s), edge(s)]);
            assert!(along.iter().all(|p| (p[0] - 1.0e6).abs() < 1.0e-9));
        }
    }

    #[test]
    fn length_is_exact_enough() {
        let a = at(0.0, 0.0);
        let mut block = Block::cubic([at(0.0, 10.0), at(10.0, 10.0)], at(10.0, 0.0), 1.0, 0);
        block.feed = Feed::Duration(1.0);
        let chords = Chords::<f64, 2>::new(a, &block, &config()).unwrap().unwrap();
        // |c'|^2 / 900 = (v^2 - u^2)^2 + (2 u v)^2 = (u^2 + v^2)^2, and its integral over u is 2 / 3.
        assert!((chords.length - 20.0).abs() < 1.0e-9, "{}", chords.length);
    }
}
