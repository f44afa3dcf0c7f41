//! A corner of [`c4_corner`](super::c4_corner): the curve of [`pythagorean`](super::pythagorean) where it lies on a path.

use super::line_path::{LinePath, plus, times};
use super::pythagorean::Corner as Curve;

/// Turns without and with a curve, rad.
const TURNS: (f64, f64) = (1.0e-9, 3.0);
/// What is kept of limits and band against rounding and between the places that are looked at.
pub(super) const KEPT: f64 = 1.0 - 1.0e-3;

/// A corner as it lies.
pub(super) struct Corner {
    pub curve: Curve,
    /// Size of the curve, mm.
    pub size: f64,
    /// Unit vectors along the line that comes in and across it to the inside.
    axes: [Vec<f64>; 2],
}

impl Corner {
    /// The corner at the end of a line; `None`: a stop, or no turn.
    pub fn new(path: &LinePath, line: usize, size: f64) -> Option<Self> {
        let turn = path.turn(line);
        if !(TURNS.0..TURNS.1).contains(&turn) {
            return None;
        }
        let curve = Curve::new(turn);
        let room = path.lengths[line].min(path.lengths[line + 1]) / 2.0;
        // The lines are nearer to the apex than the corner.
        let band = path.bands[line + 1] * size * KEPT / (curve.apex * (turn / 2.0).cos());
        let (a, b) = (&path.directions[line], &path.directions[line + 1]);
        let across = times(1.0 / turn.sin(), &plus(b, -turn.cos(), a));
        Some(Self { curve, size: band.min(room / curve.reach), axes: [a.clone(), across] })
    }

    pub fn half(&self) -> f64 {
        self.size * self.curve.length / 2.0
    }

    /// Place from the corner, mm, and derivatives by arc length up to the third, at an arc length.
    pub fn derivatives(&self, way: f64) -> [Vec<f64>; 4] {
        let place = self.curve.place(way / self.size);
        let ([x, y], [c, s]) = (place.at, place.tangent);
        let bend = place.curvature / self.size;
        let change = place.change / (self.size * self.size);
        let of = |a: f64, b: f64| plus(&times(a, &self.axes[0]), b, &self.axes[1]);
        [
            of(self.size * (x - self.curve.reach), self.size * y),
            of(c, s),
            of(-s * bend, c * bend),
            of(-s * change - c * bend * bend, c * change - s * bend * bend),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::others::tests::zigzag;

    /// The corner is as far from the lines as the band allows.
    #[test]
    fn corners_use_the_band() {
        let path = zigzag();
        let corner = Corner::new(&path, 0, 1.0).unwrap();
        let [apex, ..] = corner.derivatives(corner.half());
        let off = apex.iter().map(|x| x * x).sum::<f64>().sqrt() * (path.turn(0) / 2.0).cos();
        assert!((off / path.band - 1.0).abs() < 2e-3, "{off} mm");
    }
}
