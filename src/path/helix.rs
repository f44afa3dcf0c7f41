//! Arcs and helices that start and end exactly where the program says, whatever it has rounded.
//!
//! A program of three decimals never gives both ends of an arc at the same distance from its centre. The
//! centre stays where it is: the radius goes in proportion to the angle from the start's to the end's (a
//! spiral of Archimedes, by a fraction of a micrometre as a rule), and so do the axes outside the plane.
//!
//! How far it turns follows from the angles alone:
//! - ends that are equal in the plane (within [`EQUAL`]) make a full turn;
//! - else it is the angle from start to end, seen from the centre, in the sense of the turn: an end just
//!   behind the start is a tiny arc, one just before it nearly a full turn, however small the gap;
//! - an end on the ray of the start, but at another radius ([`SAME_RAY`]), could be no turn as well as a
//!   full one: it is refused, because neither may be run by mistake.

use super::node::Frame;
use crate::block::{BlockError, Turn, radius_slack};
use crate::number::quadrature::integral;
use crate::number::trig::sin_cos;
use crate::number::{Coord, Scalar};
use core::array::from_fn;
use core::f64::consts::TAU;

/// Ends less than this far apart, mm, are equal: the nanometre of the finest input, either way.
const EQUAL: f64 = 1.5e-6;

/// Ends lie on the same ray if they are apart along the circle by less than this share of the difference of
/// their radii.
const SAME_RAY: f64 = 0.1;

/// Growth of the radius over its least value up to which one quadrature over the whole arc gives its
/// length to 1e-9.
const SLIGHT: f64 = 0.02;
/// Parts in which the length of others is found.
const PARTS: u32 = 16;

/// Whole of a share.
pub const WHOLE: i64 = 1 << 62;

/// A circle, helix or spiral by a share of its angle: 0 to [`WHOLE`].
#[derive(Clone, Copy, Debug)]
pub struct Helix {
    plane: (u8, u8),
    /// Whole turns besides the sweep. Kept apart: an angle of a thousand turns would lose its last digits.
    turns: u16,
    centre: (Coord, Coord),
    /// Radius at the start, mm, and what it grows by.
    radius: f64,
    growth: f64,
    /// Angle of the start, rad.
    from: f64,
    /// Angle from start to end without the whole turns, rad; positive if the first axis turns to the second.
    sweep: f64,
}

/// A point of the arc in its plane, in polar form about the centre.
#[derive(Clone, Copy)]
pub struct Polar {
    radius: f64,
    sin: f64,
    cos: f64,
}

impl Helix {
    /// The arc about `centre`.
    ///
    /// # Errors
    /// [`BlockError::Plane`], [`BlockError::ArcRadius`] or [`BlockError::ArcUnreachable`].
    pub fn new<const N: usize>(
        (start, end): (&[Coord; N], &[Coord; N]),
        plane: (usize, usize),
        centre: (Coord, Coord),
        turn: Turn,
        extra_turns: u16,
    ) -> Result<Self, BlockError> {
        let (p, q) = plane;
        if p == q || p >= N || q >= N {
            return Err(BlockError::Plane { axes: plane });
        }
        let from: (f64, f64) = (start[p].minus(centre.0), start[q].minus(centre.1));
        let to: (f64, f64) = (end[p].minus(centre.0), end[q].minus(centre.1));
        let (r0, r1) = (length(from), length(to));
        let gap = (r0 - r1).abs();
        let misfit = BlockError::ArcRadius { start: r0, end: r1 };
        if gap > radius_slack(r0) {
            return Err(misfit);
        }
        let chord = (end[p].minus::<f64>(start[p]), end[q].minus::<f64>(start[q]));
        let span = length(chord);
        if !(r0 > EQUAL && r1 > EQUAL) {
            return Err(BlockError::ArcUnreachable { radius: r0.min(r1), chord: span });
        }
        // From the start to the end the short way round, in the sense of the turn.
        let cross = from.0 * chord.1 - from.1 * chord.0;
        let sign = if turn == Turn::Clockwise { -1.0 } else { 1.0 };
        let apart = sign * libm::atan2(cross, from.0 * to.0 + from.1 * to.1);
        let sweep = if span < EQUAL {
            TAU + apart
        } else if apart.abs() * r0.min(r1) <= SAME_RAY * gap {
            return Err(misfit);
        } else if apart > 0.0 {
            apart
        } else {
            TAU + apart
        };
        Ok(Self {
            plane: (p as u8, q as u8),
            turns: extra_turns,
            centre,
            radius: r0,
            growth: r1 - r0,
            from: libm::atan2(from.1, from.0),
            sweep: sign * sweep,
        })
    }

    /// Whether an axis lies in the plane.
    pub fn turns_axis(&self, axis: usize) -> bool {
        axis == usize::from(self.plane.0) || axis == usize::from(self.plane.1)
    }

    /// Angle of the whole, rad, signed.
    #[inline(never)]
    fn angle(&self) -> f64 {
        let turns = TAU * f64::from(self.turns);
        self.sweep + if self.sweep < 0.0 { -turns } else { turns }
    }

    /// Where the arc is at a share of its angle.
    #[inline(never)]
    pub fn polar(&self, share: i64) -> Polar {
        let per = 1.0 / WHOLE as f64;
        // Whole turns drop out of the product exactly.
        let part = share.wrapping_mul(i64::from(self.turns)) & (WHOLE - 1);
        let turned = TAU * (part as f64 * per);
        let u = share as f64 * per;
        let turned = if self.sweep < 0.0 { -turned } else { turned };
        let (sin, cos) = sin_cos(self.from + (turned + self.sweep * u));
        Polar { radius: self.radius + self.growth * u, sin, cos }
    }

    /// Sets what is in the plane.
    fn put<T, const N: usize>(&self, vector: &mut [T; N], p: T, q: T) {
        if let Some(slot) = vector.get_mut(usize::from(self.plane.0)) {
            *slot = p;
        }
        if let Some(slot) = vector.get_mut(usize::from(self.plane.1)) {
            *slot = q;
        }
    }

    /// Shows every place between the ends where an axis of the plane turns back, if the arc comes there, by the index of
    /// the axis: of several turns the farthest.
    ///
    /// Seen from the end with the greater radius R, at an angle t from there the radius is R - k t. Along a direction at the
    /// angle b from that end the coordinate (R - k t) cos(b - t) is greatest where t + atan(k / (R - k t)) = b: the
    /// left side rises in t, by 1 to 2 per unit, so there is one such place, and Newton's method finds it. Of
    /// several turns it is the first from that end. On a circle it is b itself.
    #[cfg(feature = "travel")]
    pub fn reaches(&self, mut reach: impl FnMut(usize, Coord)) {
        const STEPS: u32 = 5;
        let whole = self.angle().abs();
        let loss = self.growth.abs() / whole;
        let (start, sense) = if self.growth > 0.0 {
            (self.from + self.sweep, -self.sweep)
        } else {
            (self.from, self.sweep)
        };
        let greatest = self.radius.max(self.radius + self.growth);
        for quarter in 0..4u8 {
            let apart = TAU * 0.25 * f64::from(quarter) - start;
            let turns = if sense < 0.0 { -apart } else { apart } / TAU;
            let ahead = TAU * (turns - libm::floor(turns));
            let lag = |t: f64| libm::atan2(loss, greatest - loss * t);
            let ahead = if ahead < lag(0.0) { ahead + TAU } else { ahead };
            if whole + lag(whole) < ahead {
                continue;
            }
            let mut t = ahead - lag(0.0);
            for _ in 0..STEPS {
                let radius = greatest - loss * t;
                let slope = 1.0 + loss * loss / (radius * radius + loss * loss);
                t = (t - (t + lag(t) - ahead) / slope).max(0.0).min(whole);
            }
            let radius = greatest - loss * t;
            let far = radius * radius / length((radius, loss));
            let far = if quarter < 2 { far } else { -far };
            if quarter % 2 == 0 {
                reach(usize::from(self.plane.0), self.centre.0.plus(far));
            } else {
                reach(usize::from(self.plane.1), self.centre.1.plus(far));
            }
        }
    }

    /// What the axes outside the plane travel, mm.
    #[inline(never)]
    pub fn climb<const N: usize>(&self, start: &[Coord; N], end: &[Coord; N]) -> [f64; N] {
        from_fn(|i| if self.turns_axis(i) { 0.0 } else { end[i].minus(start[i]) })
    }

    /// Length per share where the radius is `radius`, mm. It depends on nothing else, so that
    /// on a circle it is the same everywhere to the last bit.
    #[inline(never)]
    fn speed<const N: usize>(&self, radius: f64, climb: &[f64; N]) -> f64 {
        let round = self.angle() * radius;
        let mut square = round * round + self.growth * self.growth;
        for travel in climb {
            square += travel * travel;
        }
        libm::sqrt(square)
    }

    /// Length between two parts of the whole, mm.
    pub fn length<const N: usize>(&self, (from, to): (f64, f64), climb: &[f64; N]) -> f64 {
        if self.growth == 0.0 {
            return self.speed(self.radius, climb) * (to - from);
        }
        let speed = |u: f64| self.speed(self.radius + self.growth * u, climb);
        let least = self.radius.min(self.radius + self.growth);
        if (to - from) * self.growth.abs() <= SLIGHT * least {
            return integral(from, to, speed);
        }
        let step = (to - from) / f64::from(PARTS);
        (0..PARTS).map(|k| from + step * f64::from(k)).map(|u| integral(u, u + step, speed)).sum()
    }

    /// Position of the plane's axes at a point; the others are left.
    pub fn set_position<const N: usize>(
        &self,
        at: &mut [Coord; N],
        Polar { radius, sin, cos }: Polar,
    ) {
        self.put(at, self.centre.0.plus(radius * cos), self.centre.1.plus(radius * sin));
    }

    /// Tangent and curvature at a point.
    pub fn frame<S: Scalar, const N: usize>(
        &self,
        Polar { radius, sin, cos }: Polar,
        climb: &[f64; N],
    ) -> Frame<S, N> {
        let (turn, growth) = (self.angle(), self.growth);
        let speed = self.speed(radius, climb);
        let mut tangent: [f64; N] = from_fn(|i| climb[i] / speed);
        let round = turn * radius;
        self.put(
            &mut tangent,
            (growth * cos - round * sin) / speed,
            (growth * sin + round * cos) / speed,
        );
        // The second derivative by the share, without its part along the tangent.
        let square = speed * speed;
        let along = turn * turn * radius * growth / speed;
        let mut second = [0.0; N];
        let (inwards, across) = (-turn * turn * radius, 2.0 * growth * turn);
        self.put(&mut second, inwards * cos - across * sin, inwards * sin + across * cos);
        let curvature = from_fn(|i| S::of((second[i] - along * tangent[i]) / square));
        Frame { tangent: tangent.map(S::of), curvature }
    }

    /// Length and tangent offset ([`super::node::Cell`]) of the part between two shares.
    ///
    /// In `f64` and from the angles: the tangent offset is a small difference, and what it lost would be felt as jerk.
    pub fn cell<S: Scalar, const N: usize>(
        &self,
        (from, to): (i64, i64),
        climb: &[f64; N],
    ) -> (S, [S; N]) {
        let per = 1.0 / WHOLE as f64;
        let (u0, part) = (from as f64 * per, (to - from) as f64 * per);
        let length = self.length((u0, u0 + part), climb);
        let middle = self.polar(from + (to - from) / 2);
        let (half_sin, half_cos) = sin_cos(self.angle() * part * 0.5);
        // Seen from the middle: what the radius grows by along it, and the chord across it.
        let grown = self.growth * part;
        let (out, across) = (grown * half_cos, 2.0 * middle.radius * half_sin);
        // The tangent at the start, which is half the part back.
        let cos = middle.cos * half_cos + middle.sin * half_sin;
        let sin = middle.sin * half_cos - middle.cos * half_sin;
        let radius = middle.radius - grown * 0.5;
        let speed = self.speed(radius, climb);
        let round = self.angle() * radius;
        let share = length / speed;
        let mut tangent_offset: [S; N] =
            from_fn(
                |i| if self.growth == 0.0 { S::ZERO } else { S::of(climb[i] * (part - share)) },
            );
        self.put(
            &mut tangent_offset,
            S::of(
                out * middle.cos - across * middle.sin - (self.growth * cos - round * sin) * share,
            ),
            S::of(
                out * middle.sin + across * middle.cos - (self.growth * sin + round * cos) * share,
            ),
        );
        (S::of(length), tangent_offset)
    }

    /// Greatest curvature, 1/mm.
    pub fn bend<const N: usize>(&self, climb: &[f64; N]) -> f64 {
        let turn = self.angle();
        let across = 2.0 * self.growth * turn;
        let at = |radius: f64| {
            let (inwards, speed) = (turn * turn * radius, self.speed(radius, climb));
            libm::sqrt(inwards * inwards + across * across) / (speed * speed)
        };
        at(self.radius).max(at(self.radius + self.growth))
    }

    /// Angle per length on the mean, rad/mm.
    pub fn rate<S: Scalar>(&self, length: S) -> S {
        S::of(self.angle()) / length
    }
}

fn length((x, y): (f64, f64)) -> f64 {
    libm::sqrt(x * x + y * y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn point(x: f64, y: f64, z: f64) -> [Coord; 3] {
        [x, y, z].map(|x| Coord::from_mm(x).unwrap())
    }

    fn helix(end: [Coord; 3], turn: Turn) -> Result<Helix, BlockError> {
        let start = point(10.0, 0.0, 0.0);
        Helix::new((&start, &end), (0, 1), (Coord::ZERO, Coord::ZERO), turn, 0)
    }

    /// The rule of the turn, line by line.
    #[test]
    fn how_far_an_arc_turns() {
        let both = [Turn::CounterClockwise, Turn::Clockwise];
        let angle = |x: f64, y: f64, turn| helix(point(x, y, 0.0), turn).map(|helix| helix.angle());
        for (turn, sign) in both.into_iter().zip([1.0, -1.0]) {
            // Equal within a nanometre: a full turn.
            for (x, y) in [(10.0, 0.0), (10.000_001, 0.0), (10.0, 0.000_001), (10.0, -0.000_001)] {
                assert!((angle(x, y, turn).unwrap() - sign * TAU).abs() < 1.1e-7, "{x} {y}");
            }
            // On the same ray at another radius: nothing or a full turn, nobody knows.
            for x in [10.001, 9.996, 10.0001] {
                assert!(matches!(angle(x, 0.0, turn), Err(BlockError::ArcRadius { .. })), "{x}");
            }
            // A half turn.
            assert!((angle(-10.0, 0.0, turn).unwrap().abs() - TAU / 2.0).abs() < 1e-12);
        }
        // A micrometre before and behind the start, at a radius of a micrometre less.
        for (x, y) in [(10.0, 0.001), (9.999, 0.001), (9.9995, 0.0002)] {
            let (small, large) = (y / 10.0, TAU - y / 10.0);
            assert!((angle(x, y, both[0]).unwrap() - small).abs() < 1e-7);
            assert!((angle(x, y, both[1]).unwrap() + large).abs() < 1e-7);
            assert!((angle(x, -y, both[0]).unwrap() - large).abs() < 1e-7);
            assert!((angle(x, -y, both[1]).unwrap() + small).abs() < 1e-7);
        }
        // The usual rule: 0.005 mm or a thousandth, and never 0.5 mm.
        assert!(angle(0.0, 10.009, both[0]).is_ok() && angle(0.0, 10.011, both[0]).is_err());
        let far = |r: f64| {
            let ends = (&point(2e3, 0.0, 0.0), &point(0.0, r, 0.0));
            Helix::new(ends, (0, 1), (Coord::ZERO, Coord::ZERO), both[0], 0)
        };
        assert!(far(2000.49).is_ok() && far(2000.51).is_err());
    }

    /// Tangent, curvature, lengths and tangent offsets against differences of positions, on circles, helices and
    /// spirals, of many turns too.
    #[test]
    fn frames_and_cells_are_those_of_the_curve() {
        let start = point(3.0, 4.0, 1.0);
        for (end, turns) in [
            (point(-5.0, 0.0, 1.0), 0),
            (point(-5.0, 0.0, 7.0), 0),
            (point(-5.003, 0.001, 7.0), 0),
            (point(-5.003, 0.001, 7.0), 3),
            (point(3.0, 4.0, 100.0), 1000),
        ] {
            let helix = Helix::new(
                (&start, &end),
                (0, 1),
                (Coord::ZERO, Coord::ZERO),
                Turn::Clockwise,
                turns,
            )
            .unwrap();
            let climb = helix.climb(&start, &end);
            let at = |share: i64| -> [f64; 3] {
                let mut at = start.map(|_| Coord::ZERO);
                helix.set_position(&mut at, helix.polar(share));
                let z = climb[2] * (share as f64 / WHOLE as f64);
                [at[0].to_mm(), at[1].to_mm(), z]
            };
            let ends = [at(0), at(WHOLE)];
            for i in 0..2 {
                assert!((ends[0][i] - start[i].to_mm()).abs() < 1e-11, "{turns} {ends:?}");
                assert!((ends[1][i] - end[i].to_mm()).abs() < 1e-11, "{turns} {ends:?}");
            }
            let whole = helix.length((0.0, 1.0), &climb);
            // A step of a hundredth of a radian.
            let step = (WHOLE as f64 * 0.01 / helix.angle().abs()) as i64;
            for share in [0, WHOLE / 3, WHOLE - step] {
                let (length, tangent_offset) = helix.cell::<f64, 3>((share, share + step), &climb);
                let Frame { tangent: t0, curvature: k0 }: Frame<f64, 3> =
                    helix.frame(helix.polar(share), &climb);
                let Frame { tangent: t1, curvature: k1 }: Frame<f64, 3> =
                    helix.frame(helix.polar(share + step), &climb);
                let (a, b) = (at(share), at(share + step));
                let expected = whole * (step as f64 / WHOLE as f64);
                assert!((length - expected).abs() < 1e-3 * expected);
                let unit: f64 = t0.iter().map(|x| x * x).sum();
                let right: f64 = t0.iter().zip(&k0).map(|(t, k)| t * k).sum();
                assert!((unit - 1.0).abs() < 1e-12 && right.abs() < 1e-12);
                for i in 0..3 {
                    let moved = b[i] - a[i];
                    assert!(
                        (t0[i] * length + tangent_offset[i] - moved).abs() < 1e-11,
                        "{turns} {i}"
                    );
                    // Simpson and the trapezoidal rule of the same quantities.
                    let mean = f64::midpoint(t0[i], t1[i]) + (k0[i] - k1[i]) * length / 12.0;
                    assert!((mean * length - moved).abs() < 1e-9, "{turns} {i}");
                    let turned = f64::midpoint(k0[i], k1[i]) * length;
                    assert!((t1[i] - t0[i] - turned).abs() < 2e-6, "{turns} {i}");
                }
            }
            // Parts add up.
            let parts: Vec<f64> = (0..8)
                .map(|k| f64::from(k) / 8.0)
                .map(|u| helix.length((u, u + 0.125), &climb))
                .collect();
            assert!((parts.iter().sum::<f64>() - whole).abs() < 1e-9 * whole);
        }
    }
}
