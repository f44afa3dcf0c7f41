//! Lines and arcs as parts of the path, with exact ends and lengths.

use super::node::{Cell, Node, Order};
use crate::block::{BlockError, Turn};
use crate::number::vector::{Vector, zero};
use crate::number::{Coord, Scalar};
use core::array::from_fn;

/// Moves shorter than this, mm, are accepted and ignored: they are below the finest input.
const LEAST_LENGTH: f64 = 0.5e-6;

/// Longest block, mm: well inside the range of the fixed-point arc length.
const GREATEST_LENGTH: f64 = 7.0e6;

/// Share of the tolerance for the distance of a cell from its arc at standstill.
const ARC_SHARE: f64 = 0.1;

/// Greatest difference of an arc's two radii, mm, absolute and (above the lesser one) relative.
const RADIUS_SLACK: (f64, f64, f64) = (0.005, 1.0e-3, 0.5);

/// The curve of a segment.
#[derive(Clone, Copy, Debug)]
pub enum Shape<S, const N: usize> {
    /// Straight, with its unit tangent.
    Line(Vector<S, N>),
    /// A circle or helix.
    Arc(Helix<S, N>),
}

/// A circle or helix: the in-plane angle and the other axes grow in proportion to arc length.
#[derive(Clone, Copy, Debug)]
pub struct Helix<S, const N: usize> {
    plane: (usize, usize),
    centre: (Coord, Coord),
    radius: f64,
    /// Angle of the start, rad.
    from: f64,
    /// Signed angle per mm of arc length, rad/mm.
    rate: f64,
    /// Change of the other axes per mm of arc length.
    drift: Vector<S, N>,
}

impl<S: Scalar, const N: usize> Helix<S, N> {
    /// Tangent and curvature at an angle.
    fn frame(&self, angle: f64) -> (Vector<S, N>, Vector<S, N>) {
        let (sin, cos) = libm::sincos(angle);
        let along = self.rate * self.radius;
        let bend = -self.rate * self.rate * self.radius;
        let mut tangent = self.drift;
        self.put(&mut tangent, S::of(-along * sin), S::of(along * cos));
        let mut curvature = zero();
        self.put(&mut curvature, S::of(bend * cos), S::of(bend * sin));
        (tangent, curvature)
    }

    /// Sets what is in the plane.
    fn put<T>(&self, vector: &mut [T; N], p: T, q: T) {
        if let Some(slot) = vector.get_mut(self.plane.0) {
            *slot = p;
        }
        if let Some(slot) = vector.get_mut(self.plane.1) {
            *slot = q;
        }
    }
}

/// A line or arc of the path.
#[derive(Clone, Copy, Debug)]
pub struct Segment<S, const N: usize> {
    /// Start.
    pub start: [Coord; N],
    /// End.
    pub end: [Coord; N],
    /// Curve between them.
    pub shape: Shape<S, N>,
    /// Length in units of 1e-12 mm.
    pub length_raw: i64,
    /// Length, mm.
    pub length: S,
}

/// Arc length from units of 1e-12 mm.
pub fn raw_to_mm<S: Scalar>(raw: i64) -> S {
    S::from_i64(raw) * S::of(1.0e-12)
}

/// Arc length in units of 1e-12 mm.
pub fn mm_to_raw<S: Scalar>(mm: S) -> i64 {
    (mm * S::of(1.0e12)).to_i64()
}

impl<S: Scalar, const N: usize> Segment<S, N> {
    /// The straight line, or `None` if it has no length.
    pub fn line(start: [Coord; N], end: [Coord; N]) -> Option<Self> {
        let step: [f64; N] = from_fn(|i| end[i].minus(start[i]));
        let length = libm::sqrt(step.iter().map(|d| d * d).sum());
        if length < LEAST_LENGTH {
            return None;
        }
        Some(Self {
            start,
            end,
            shape: Shape::Line(from_fn(|i| S::of(step[i] / length))),
            length_raw: libm::round(length * 1.0e12) as i64,
            length: S::of(length),
        })
    }

    /// The arc or helix about `centre`; `Ok(None)` if it has no length.
    ///
    /// The centre is moved by the least amount that puts it at the same distance from both ends,
    /// so that start and end are met exactly.
    ///
    /// # Errors
    /// [`BlockError::Plane`], [`BlockError::ArcRadius`] or [`BlockError::ArcUnreachable`].
    pub fn arc(
        start: [Coord; N],
        end: [Coord; N],
        plane: (usize, usize),
        centre: (Coord, Coord),
        turn: Turn,
        extra_turns: u16,
    ) -> Result<Option<Self>, BlockError> {
        let (p, q) = plane;
        if p == q || p >= N || q >= N {
            return Err(BlockError::Plane { axes: plane });
        }
        let from: (f64, f64) = (start[p].minus(centre.0), start[q].minus(centre.1));
        let to: (f64, f64) = (end[p].minus(centre.0), end[q].minus(centre.1));
        let (r0, r1) = (length(from), length(to));
        let gap = (r0 - r1).abs();
        let (least, relative, most) = RADIUS_SLACK;
        if gap > most || (gap > least && gap > relative * r0) {
            return Err(BlockError::ArcRadius { start: r0, end: r1 });
        }
        let chord = (to.0 - from.0, to.1 - from.1);
        let span = length(chord);
        let full_circle = span < LEAST_LENGTH;
        let (mut cx, mut cy) = (0.0, 0.0);
        if !full_circle {
            let middle = (from.0 + chord.0 / 2.0, from.1 + chord.1 / 2.0);
            let off = (middle.0 * chord.0 + middle.1 * chord.1) / (span * span);
            cx = off * chord.0;
            cy = off * chord.1;
        }
        let from = (from.0 - cx, from.1 - cy);
        let to = (to.0 - cx, to.1 - cy);
        let radius = length(from);
        if !(radius > LEAST_LENGTH) {
            return Err(BlockError::ArcUnreachable { radius, chord: span });
        }
        let full_turn = 2.0 * core::f64::consts::PI;
        let start_angle = libm::atan2(from.1, from.0);
        let mut sweep = if full_circle { full_turn } else { libm::atan2(to.1, to.0) - start_angle };
        if turn == Turn::Clockwise && !full_circle {
            sweep = -sweep;
        }
        if sweep <= 0.0 {
            sweep += full_turn;
        }
        sweep += full_turn * f64::from(extra_turns);
        let step: [f64; N] =
            from_fn(|i| if i == p || i == q { 0.0 } else { end[i].minus(start[i]) });
        let circle = radius * sweep;
        let total = libm::sqrt(circle * circle + step.iter().map(|d| d * d).sum::<f64>());
        if total > GREATEST_LENGTH {
            return Err(BlockError::TooLong { length: total, greatest: GREATEST_LENGTH });
        }
        let sign = if turn == Turn::Clockwise { -1.0 } else { 1.0 };
        Ok(Some(Self {
            start,
            end,
            shape: Shape::Arc(Helix {
                plane,
                centre: (centre.0.plus(cx), centre.1.plus(cy)),
                radius,
                from: start_angle,
                rate: sign * sweep / total,
                drift: from_fn(|i| S::of(step[i] / total)),
            }),
            length_raw: libm::round(total * 1.0e12) as i64,
            length: S::of(total),
        }))
    }

    /// Tangent and curvature at the start (`false`) or the end (`true`).
    pub fn end_frame(&self, end: bool) -> (Vector<S, N>, Vector<S, N>) {
        match &self.shape {
            Shape::Line(tangent) => (*tangent, zero()),
            Shape::Arc(helix) => {
                let way = if end { raw_to_mm::<f64>(self.length_raw) } else { 0.0 };
                helix.frame(helix.from + helix.rate * way)
            }
        }
    }

    /// Whether it is straight.
    pub fn is_line(&self) -> bool {
        matches!(self.shape, Shape::Line(_))
    }

    /// The node at an arc length (units of 1e-12 mm) from the start.
    pub fn node(&self, way_raw: i64) -> Node<S, N> {
        match &self.shape {
            Shape::Line(tangent) => {
                let fraction = if way_raw >= self.length_raw {
                    1 << 62
                } else {
                    ((i128::from(way_raw) << 62) / i128::from(self.length_raw.max(1))) as i64
                };
                Node {
                    at: from_fn(|i| self.start[i].towards(self.end[i], fraction)),
                    tangent: *tangent,
                    curvature: zero(),
                }
            }
            Shape::Arc(helix) => {
                let way = raw_to_mm::<f64>(way_raw);
                let angle = helix.from + helix.rate * way;
                let (tangent, curvature) = helix.frame(angle);
                let mut at: [Coord; N] =
                    from_fn(|i| self.start[i].plus(helix.drift[i].to_f64() * way));
                let (sin, cos) = libm::sincos(angle);
                let (x, y) = (helix.radius * cos, helix.radius * sin);
                helix.put(&mut at, helix.centre.0.plus(x), helix.centre.1.plus(y));
                if way_raw <= 0 {
                    at = self.start;
                } else if way_raw >= self.length_raw {
                    at = self.end;
                }
                Node { at, tangent, curvature }
            }
        }
    }

    /// The cell between two arc lengths, `from` being the node at the first.
    pub fn cell(&self, from: &Node<S, N>, way: (i64, i64), order: Order<S>) -> Cell<S, N> {
        let length = raw_to_mm::<S>(way.1 - way.0);
        let (bulge, straight) = match &self.shape {
            Shape::Line(_) => (zero(), true),
            Shape::Arc(helix) => (helix.bulge(from, length), false),
        };
        Cell { length, bulge, order, dwell: S::ZERO, straight }
    }

    /// Longest cell that follows the curve closely enough, mm.
    ///
    /// At steady speed the quintic of a cell keeps to an arc of 0.3 rad by 1e-8 of its radius. Next
    /// to a standstill the way grows with t^3 and the bend with t^6, which it follows only to
    /// curvature h^2 / 128: that may take [`ARC_SHARE`] of the tolerance.
    pub fn longest_cell(&self, tolerance: S) -> S {
        match &self.shape {
            Shape::Line(_) => self.length,
            Shape::Arc(helix) => {
                let radius = S::of(1.0 / (helix.rate * helix.rate * helix.radius));
                let still = (tolerance * S::of(128.0 * ARC_SHARE) * radius).sqrt();
                let least = self.length * S::of(1.0e-3);
                self.longest_angle().least(still.greatest(least))
            }
        }
    }

    /// Length of 0.3 rad of an arc, mm; all of a line.
    pub fn longest_angle(&self) -> S {
        match &self.shape {
            Shape::Line(_) => self.length,
            Shape::Arc(helix) => S::of(0.3 / helix.rate.abs()),
        }
    }

    /// Offset from a node of the curve to the point `way` mm further on (back if negative).
    pub fn walk(&self, frame: (&Vector<S, N>, &Vector<S, N>), way: S) -> Vector<S, N> {
        match &self.shape {
            Shape::Line(tangent) => from_fn(|i| tangent[i] * way),
            Shape::Arc(helix) => {
                let bulge = helix.bulge_along(frame, way);
                from_fn(|i| frame.0[i] * way + bulge[i])
            }
        }
    }

    /// Tangent and curvature `way` mm from the start, or from the end if negative.
    pub fn frame_at(&self, way: S) -> (Vector<S, N>, Vector<S, N>) {
        match &self.shape {
            Shape::Line(tangent) => (*tangent, zero()),
            Shape::Arc(helix) => {
                let origin = if way < S::ZERO { raw_to_mm::<f64>(self.length_raw) } else { 0.0 };
                helix.frame(helix.from + helix.rate * (origin + way.to_f64()))
            }
        }
    }
}

impl<S: Scalar, const N: usize> Helix<S, N> {
    fn bulge(&self, from: &Node<S, N>, length: S) -> Vector<S, N> {
        self.bulge_along((&from.tangent, &from.curvature), length)
    }

    /// Position after `way` mm minus `way x tangent`:
    /// in the plane (R sin phi - R phi) along the tangent and R (1 - cos phi) towards the centre.
    fn bulge_along(
        &self,
        (tangent, curvature): (&Vector<S, N>, &Vector<S, N>),
        way: S,
    ) -> Vector<S, N> {
        let phi = S::of(self.rate) * way;
        let (sin_half, _) = (phi * S::of(0.5)).sin_cos();
        // curvature = rate^2 R towards the centre, so R (1 - cos) = curvature 2 sin^2(phi/2) / rate^2.
        let towards = S::of(2.0 / (self.rate * self.rate)) * sin_half * sin_half;
        // (sin phi - phi) / phi, small: from the series where the difference would lose its digits.
        let square = phi * phi;
        let short = if square < S::of(0.25) {
            -square / S::of(6.0)
                * (S::ONE
                    - square / S::of(20.0)
                        * (S::ONE - square / S::of(42.0) * (S::ONE - square / S::of(72.0))))
        } else {
            phi.sin_cos().0 / phi - S::ONE
        };
        from_fn(|i| {
            if i == self.plane.0 || i == self.plane.1 {
                tangent[i] * way * short + curvature[i] * towards
            } else {
                S::ZERO
            }
        })
    }
}

fn length((x, y): (f64, f64)) -> f64 {
    libm::sqrt(x * x + y * y)
}
