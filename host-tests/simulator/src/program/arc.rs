//! Arcs as they are meant: about their centre, with a radius that goes evenly from the start's distance to
//! the end's. Programs are rounded, so the two differ.

use super::{Course, Point};
use std::f64::consts::TAU;

/// Ends of an arc that are nearer than this in its plane, mm, are one, as in the core: it is a full circle.
const CLOSED: f64 = 1.5e-6;

/// An arc or helix, from its start to its end.
#[derive(Clone, Copy, Debug)]
pub struct Spiral {
    plane: (usize, usize),
    centre: (f64, f64),
    from: Point,
    to: Point,
    /// Distances of start and end from the centre, mm.
    pub radii: (f64, f64),
    /// Angle of the start, rad.
    pub start: f64,
    /// Angle turned through, counter-clockwise positive, rad.
    pub sweep: f64,
}

impl Spiral {
    /// The arc that a course is from a place on; `None` if it is none.
    pub fn of(course: &Course, here: &Point) -> Option<Self> {
        let Course::Arc { to, plane: (p, q), centre, clockwise, extra_turns } = course else {
            return None;
        };
        let from = (here[*p] - centre.0, here[*q] - centre.1);
        let end = (to[*p] - centre.0, to[*q] - centre.1);
        let start = from.1.atan2(from.0);
        let sign = if *clockwise { -1.0 } else { 1.0 };
        let mut sweep = sign * (end.1.atan2(end.0) - start);
        if (from.0 - end.0).hypot(from.1 - end.1) < CLOSED {
            sweep = TAU;
        } else if sweep <= 0.0 {
            sweep += TAU;
        }
        sweep += TAU * f64::from(*extra_turns);
        Some(Self {
            plane: (*p, *q),
            centre: *centre,
            from: *here,
            to: *to,
            radii: (from.0.hypot(from.1), end.0.hypot(end.1)),
            start,
            sweep: sign * sweep,
        })
    }

    /// The point at a share of the angle.
    pub fn point(&self, u: f64) -> Point {
        let mut point = self.from;
        for (x, to) in point.iter_mut().zip(&self.to) {
            *x += (to - *x) * u;
        }
        let (sin, cos) = (self.start + self.sweep * u).sin_cos();
        let radius = self.radii.0 + (self.radii.1 - self.radii.0) * u;
        point[self.plane.0] = self.centre.0 + radius * cos;
        point[self.plane.1] = self.centre.1 + radius * sin;
        point
    }

    /// Length, mm, over the axes of a list.
    pub fn length(&self, axes: &[usize]) -> f64 {
        let (p, q) = self.plane;
        let round = f64::midpoint(self.radii.0, self.radii.1) * self.sweep.abs();
        let square = |axis: &&usize| **axis != p && **axis != q;
        let rest: f64 =
            axes.iter().filter(square).map(|&axis| (self.to[axis] - self.from[axis]).powi(2)).sum();
        (round * round + rest + (self.radii.1 - self.radii.0).powi(2)).sqrt()
    }

    /// Places, as shares of the angle, at which the arc reaches furthest along an axis of its plane.
    pub fn extremes(&self) -> impl Iterator<Item = f64> {
        let (start, sweep) = (self.start, self.sweep);
        let quarter = TAU / 4.0;
        let (low, high) = (start.min(start + sweep), start.max(start + sweep));
        let first = (low / quarter).ceil();
        // Every turn passes the same places, but for the radius: first and last count.
        let count = ((high - first * quarter) / quarter).floor().max(-1.0) as i64 + 1;
        let wanted = move |k: &i64| *k < 4 || *k >= count - 4;
        (0..count).filter(wanted).map(move |k| ((first + k as f64) * quarter - start) / sweep)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(to: (f64, f64), centre: (f64, f64), clockwise: bool, extra_turns: u16) -> Spiral {
        let mut end = [0.0; 9];
        (end[0], end[1]) = to;
        let course = Course::Arc { to: end, plane: (0, 1), centre, clockwise, extra_turns };
        Spiral::of(&course, &[0.0; 9]).unwrap()
    }

    #[test]
    fn ends_are_met_and_full_circles_are_full() {
        for (to, centre, clockwise, turns, sweep) in [
            ((10.0, 10.0), (10.0, 0.0), true, 0, -TAU / 4.0),
            ((10.0, 10.0), (10.0, 0.0), false, 0, TAU * 0.75),
            ((0.0, 0.0), (10.0, 0.0), false, 0, TAU),
            ((0.0, 0.0), (10.0, 0.0), true, 2, -3.0 * TAU),
        ] {
            let arc = arc(to, centre, clockwise, turns);
            assert!((arc.sweep - sweep).abs() < 1e-12, "{arc:?}");
            let end = arc.point(1.0);
            assert!((end[0] - to.0).hypot(end[1] - to.1) < 1e-12);
        }
    }

    #[test]
    fn extremes_are_the_quarters_on_the_way() {
        let half = arc((20.0, 0.0), (10.0, 0.0), true, 0);
        let tops: Vec<f64> = half.extremes().map(|u| half.point(u)[1]).collect();
        assert!(tops.iter().any(|y| (y - 10.0).abs() < 1e-12), "{tops:?}");
        let many = arc((0.0, 0.0), (10.0, 0.0), false, 999);
        assert!(many.extremes().count() <= 8);
    }
}
