//! Lines and arcs as parts of the path, with exact ends and lengths.

use super::budget;
use super::helix::{Helix, WHOLE};
use super::node::{Cell, Frame, Node, Programmed};
use crate::block::{BlockError, FINEST_BAND, Turn};
use crate::number::vector::{Vector, zero};
use crate::number::{Coord, Interval, Length, Scalar};
use core::array::from_fn;

/// Moves shorter than this are accepted and ignored: they are below the finest input.
pub const LEAST_LENGTH: Length = Length::from_raw(500_000);

/// Longest block, mm: well inside the range of the fixed-point arc length.
const GREATEST_LENGTH: f64 = 7.0e6;

/// A cell of length h follows an arc of curvature k to within h^2 k / 19.2, whatever the motion over it.
///
/// The arc length s(t) along the cell is a quartic, the distance from the tangent k s^2 / 2 to begin with: of degree eight,
/// and the quintic that is executed has its value, slope and second derivative at both ends. The rest is
/// k h^2 / 2 u^3 (1 - u)^3 (a^2 (6 + 3 u + u^2) + 2 a b (3 + u) + b^2), where a and b are the factors of u^4 and u^3 in
/// s / h, for a start from a standstill: 1 / 128 at constant jerk (a = 0). It is greatest for motions that creep next
/// to an end of the cell for as long as [`crate::profile::law::Law`] admits: 1 / 26.1 from a standstill, 1 / 19.2
/// where the end is passed (a search over the four Bernstein coefficients of the speed; it falls with the angle).
const CREEPING: f64 = 19.2;

/// Angle of a cell at most, rad: at steady speed its quintic then keeps to the arc by 2e-8 of its radius.
const LONGEST_ANGLE: f64 = 0.3;

/// The curve of a segment.
#[derive(Clone, Copy, Debug)]
pub enum Shape<S, const N: usize> {
    /// Straight, with its unit tangent.
    Line(Vector<S, N>),
    /// A circle, helix or spiral.
    Arc(Helix),
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
    /// Length, exact.
    pub exact_length: Length,
    /// Length, mm.
    pub length: S,
}

impl<S: Scalar, const N: usize> Segment<S, N> {
    /// The straight line, or `None` if it has no length.
    pub fn line(start: [Coord; N], end: [Coord; N]) -> Option<Self> {
        let exact_length = Length::between::<S, N>(&start, &end);
        if exact_length < LEAST_LENGTH {
            return None;
        }
        let units = S::from_i64(exact_length.raw());
        let share = |i: usize| S::from_i64(end[i].raw().wrapping_sub(start[i].raw())) / units;
        let shape = Shape::Line(from_fn(share));
        Some(Self { start, end, shape, exact_length, length: exact_length.to_mm() })
    }

    /// The arc or helix about `centre`: see [`super::helix`].
    ///
    /// # Errors
    /// [`BlockError::Plane`], [`BlockError::ArcRadius`], [`BlockError::ArcUnreachable`] or
    /// [`BlockError::TooLong`].
    pub fn arc(
        start: [Coord; N],
        end: [Coord; N],
        plane: (usize, usize),
        centre: (Coord, Coord),
        turn: Turn,
        extra_turns: u16,
    ) -> Result<Self, BlockError> {
        let helix = Helix::new((&start, &end), plane, centre, turn, extra_turns)?;
        let total = helix.length((0.0, 1.0), &helix.climb(&start, &end));
        if total > GREATEST_LENGTH {
            return Err(BlockError::TooLong { length: total, greatest: GREATEST_LENGTH });
        }
        Ok(Self {
            start,
            end,
            shape: Shape::Arc(helix),
            exact_length: Length::nearest_mm(total),
            length: S::of(total),
        })
    }

    /// Share of the segment at an arc length from the start, in 1/[`WHOLE`].
    #[inline(never)]
    fn share(&self, s: Length) -> i64 {
        if s >= self.exact_length { WHOLE } else { s.max(Length::ZERO).share_of(self.exact_length) }
    }

    /// Direction and bend at the start.
    pub fn start_frame(&self) -> Frame<S, N> {
        self.frame(0)
    }

    /// Direction and bend at the end.
    pub fn end_frame(&self) -> Frame<S, N> {
        self.frame(WHOLE)
    }

    /// Direction and bend at a share of the segment.
    #[inline(never)]
    fn frame(&self, share: i64) -> Frame<S, N> {
        match &self.shape {
            Shape::Line(tangent) => Frame { tangent: *tangent, curvature: zero() },
            Shape::Arc(helix) => {
                helix.frame(helix.polar(share), &helix.climb(&self.start, &self.end))
            }
        }
    }

    /// Whether it is straight.
    pub fn is_line(&self) -> bool {
        matches!(self.shape, Shape::Line(_))
    }

    /// Its circle, helix or spiral, if it is none of the lines.
    #[cfg(feature = "travel")]
    pub fn helix(&self) -> Option<&Helix> {
        if let Shape::Arc(helix) = &self.shape { Some(helix) } else { None }
    }

    /// The node at an arc length from the start.
    pub fn node(&self, s: Length) -> Node<S, N> {
        let share = self.share(s);
        let mut at = from_fn(|i| self.start[i].towards(self.end[i], share));
        let Shape::Arc(helix) = &self.shape else { return Node::new(at, self.frame(share)) };
        let point = helix.polar(share);
        if share > 0 && share < WHOLE {
            helix.set_position(&mut at, point);
        }
        Node::new(at, helix.frame(point, &helix.climb(&self.start, &self.end)))
    }

    /// The cell over a piece of it.
    pub fn cell(&self, Interval { from, to }: Interval, programmed: Programmed<S>) -> Cell<S, N> {
        let (length, tangent_offset, straight) = match &self.shape {
            Shape::Line(_) => ((to - from).to_mm::<S>(), zero(), true),
            Shape::Arc(helix) => {
                let shares = (self.share(from), self.share(to));
                let (length, tangent_offset) =
                    helix.cell(shares, &helix.climb(&self.start, &self.end));
                (length, tangent_offset, false)
            }
        };
        Cell { length, tangent_offset, programmed, dwell: S::ZERO, event: None, straight }
    }

    /// Longest cell that follows the curve closely enough, mm, whatever the motion over it.
    ///
    /// A tolerance below [`FINEST_BAND`] counts as that.
    pub fn longest_cell(&self, tolerance: S) -> S {
        match &self.shape {
            Shape::Line(_) => self.length,
            Shape::Arc(helix) => {
                let bend = helix.bend(&helix.climb(&self.start, &self.end));
                let band = tolerance.greatest(S::of(FINEST_BAND));
                let close = (band * S::of(CREEPING * budget::ARC / bend)).sqrt();
                self.longest_angle().least(close)
            }
        }
    }

    /// Length of [`LONGEST_ANGLE`] of an arc, mm; all of a line.
    pub fn longest_angle(&self) -> S {
        match &self.shape {
            Shape::Line(_) => self.length,
            Shape::Arc(helix) => S::of(LONGEST_ANGLE) / helix.rate(self.length).abs(),
        }
    }

    /// Angle per length, rad/mm; none on a line.
    pub fn rate(&self) -> S {
        match &self.shape {
            Shape::Line(_) => S::ZERO,
            Shape::Arc(helix) => helix.rate(self.length),
        }
    }

    /// Offset from a node of the curve to the point `along` mm further on (back if negative), at the segment's own
    /// [`rate`](Self::rate).
    #[inline(never)]
    pub fn walk(&self, frame: &Frame<S, N>, rate: S, along: S) -> Vector<S, N> {
        match &self.shape {
            Shape::Line(tangent) => from_fn(|i| tangent[i] * along),
            Shape::Arc(helix) => {
                let tangent_offset = tangent_offset_along(helix, rate, frame, along);
                from_fn(|i| frame.tangent[i] * along + tangent_offset[i])
            }
        }
    }
}

/// Position after `along` mm of a circle or helix minus `along x tangent`:
/// in the plane (R sin phi - R phi) along the tangent and R (1 - cos phi) towards the centre.
#[inline(never)]
fn tangent_offset_along<S: Scalar, const N: usize>(
    helix: &Helix,
    rate: S,
    Frame { tangent, curvature }: &Frame<S, N>,
    along: S,
) -> Vector<S, N> {
    let phi = rate * along;
    let square = phi * phi;
    // (sin phi - phi) / phi, small: from the series where the difference would lose its digits. So much of an angle
    // is all that a blend takes; the series are as exact there as the functions, and far less work.
    let short = |square: S| {
        -square / S::of(6.0)
            * (S::ONE
                - square / S::of(20.0)
                    * (S::ONE - square / S::of(42.0) * (S::ONE - square / S::of(72.0))))
    };
    let half = phi * S::of(0.5);
    let (short, sin_half) = if square < S::of(0.25) {
        (short(square), half + half * short(square * S::of(0.25)))
    } else {
        (phi.sin_cos().0 / phi - S::ONE, half.sin_cos().0)
    };
    // curvature = rate^2 R towards the centre, so R (1 - cos) = curvature 2 sin^2(phi/2) / rate^2.
    let towards = (sin_half + sin_half) / rate * (sin_half / rate);
    from_fn(|i| {
        if helix.turns_axis(i) {
            tangent[i] * along * short + curvature[i] * towards
        } else {
            S::ZERO
        }
    })
}
