//! Resolving arcs: radius form to centre form.

use super::{BlockError, Turn};
use crate::number::Coord;

/// By how much a radius may be too small for half its chord, from rounding in the program, mm.
const SLACK: f64 = 0.005;
/// The same as a share of the radius, whichever is less.
const SLACK_SHARE: f64 = 0.1;

/// Greatest difference of an arc's two radii, mm; `LinuxCNC` has the same three.
const RADIUS_SLACK: f64 = 0.005;
/// The same as a share of the radius at the start, whichever is more.
const RADIUS_SLACK_SHARE: f64 = 1.0e-3;
/// The same in any case, mm.
const RADIUS_SLACK_MOST: f64 = 0.5;

/// By how much the radius at the end may differ from `start`, that at the start, mm.
pub const fn radius_slack(start: f64) -> f64 {
    (RADIUS_SLACK_SHARE * start).max(RADIUS_SLACK).min(RADIUS_SLACK_MOST)
}

/// The centre of the arc of `radius` mm (negative: the long way round, more than half a circle)
/// from `start` to `end`, both in the plane's two axes.
///
/// A radius that is too small for half the chord by no more than 0.005 mm and a tenth of itself
/// (rounding of the program) makes a half circle over the chord.
///
/// # Errors
/// [`BlockError::ArcUnreachable`] if the radius is not finite, zero or smaller than half the
/// chord, or if start and end coincide (any centre would do).
pub fn centre_from_radius(
    start: (Coord, Coord),
    end: (Coord, Coord),
    radius: f64,
    turn: Turn,
) -> Result<(Coord, Coord), BlockError> {
    let dx: f64 = end.0.minus(start.0);
    let dy: f64 = end.1.minus(start.1);
    let chord = libm::sqrt(dx * dx + dy * dy);
    let size = radius.abs();
    let unreachable = BlockError::ArcUnreachable { radius, chord };
    if !(size.is_finite() && size > 0.0 && chord > 1.0e-6) {
        return Err(unreachable);
    }
    let half = chord / 2.0;
    if half > size + SLACK.min(SLACK_SHARE * size) {
        return Err(unreachable);
    }
    // As a product: the difference of squares would lose the digits that a half circle depends on.
    let height = libm::sqrt(((size - half) * (size + half)).max(0.0));
    // Left of the chord for a short counter-clockwise arc, right of it for a clockwise one.
    let side = if (turn == Turn::CounterClockwise) == (radius > 0.0) { 1.0 } else { -1.0 };
    let x = dx / 2.0 - side * height * dy / chord;
    let y = dy / 2.0 + side * height * dx / chord;
    Ok((start.0.plus(x), start.1.plus(y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coord(mm: f64) -> Coord {
        Coord::from_mm(mm).unwrap()
    }

    #[test]
    fn quarter_circle_both_ways_round() {
        let start = (coord(1.0), coord(0.0));
        let end = (coord(0.0), coord(1.0));
        let short = centre_from_radius(start, end, 1.0, Turn::CounterClockwise).unwrap();
        assert!(short.0.to_mm().abs() < 1e-9 && short.1.to_mm().abs() < 1e-9);
        let long = centre_from_radius(start, end, -1.0, Turn::CounterClockwise).unwrap();
        assert!((long.0.to_mm() - 1.0).abs() < 1e-9 && (long.1.to_mm() - 1.0).abs() < 1e-9);
    }

    /// Too small by the rounding of a program: a half circle. By more: refused, at any size.
    #[test]
    fn radii_a_little_too_small_make_half_circles() {
        let start = (coord(0.0), coord(0.0));
        for (chord, radius, good) in [
            (20.001, 10.0, true),
            (20.009, 10.0, true),
            (20.011, 10.0, false),
            (200.02, 100.0, false),
            (0.021, 0.01, true),
            (0.023, 0.01, false),
        ] {
            let end = (coord(0.0), coord(chord));
            let centre = centre_from_radius(start, end, radius, Turn::Clockwise);
            assert_eq!(centre.is_ok(), good, "{chord} {radius}");
            if let Ok((x, y)) = centre {
                assert!(x.to_mm().abs() < 1e-12 && (y.to_mm() - chord / 2.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn impossible_radii_are_named() {
        let start = (coord(0.0), coord(0.0));
        for (end, radius) in [
            ((coord(3.0), coord(0.0)), 1.0),
            ((coord(0.0), coord(0.0)), 1.0),
            ((coord(1.0), coord(0.0)), 0.0),
        ] {
            assert!(matches!(
                centre_from_radius(start, end, radius, Turn::Clockwise),
                Err(BlockError::ArcUnreachable { .. })
            ));
        }
    }
}
