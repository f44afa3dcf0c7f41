//! A corner curve with a Pythagorean hodograph, in C4 contact with both lines.
//!
//! Written from "C4 continuous" corners of the kind of Jiang and others (2022, doi 10.1007/s00170-022-09463-y), which the Prunt
//! motion controller uses in symmetric form: a Bezier curve of degree 15 whose hodograph is the square of a complex polynomial w of
//! degree 7, so that the arc length is a polynomial too. For C4 contact the first four coefficients of w (in Bernstein form) point
//! along the one line and the last four along the other; here they are equal, so that with S, the sum of the last four Bernstein
//! polynomials, and half the turn h
//!
//!   w = 1 - S + S e^(i h),   r' = w^2,   s' = |w|^2,   curvature = 2 S' sin h / |w|^4.
//!
//! Lengths are for r' = 1 at the ends, angles are from the line that comes in.

/// A vector in the plane of the corner: along the line that comes in, and across it to the inside.
pub type Planar = [f64; 2];

/// Nodes and weights of Gauss's rule with 8 points on 0..1: exact for what is integrated, which has degree 14.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
/// Newton's steps to a parameter.
const STEPS: usize = 40;

/// A corner of unit size.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    sine: f64,
    cosine: f64,
    /// Length of the curve, of what it takes of either line, and distance of its apex from the corner.
    pub length: f64,
    /// See `length`.
    pub reach: f64,
    /// See `length`.
    pub apex: f64,
}

/// A place of the curve.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// From its start.
    pub at: Planar,
    /// Unit tangent.
    pub tangent: Planar,
    /// Curvature, to the inside, and its derivative by arc length.
    pub curvature: f64,
    /// See `curvature`.
    pub change: f64,
}

/// S and its first two derivatives.
fn step(t: f64) -> [f64; 3] {
    let u = 1.0 - t;
    let (t3, u3) = (t * t * t, u * u * u);
    [
        t3 * t * (35.0 + t * (-84.0 + t * (70.0 - 20.0 * t))),
        140.0 * t3 * u3,
        420.0 * t * t * u * u * (u - t),
    ]
}

impl Corner {
    /// The curve for a turn, rad, less than half a circle.
    pub fn new(turn: f64) -> Self {
        let (sine, cosine) = (turn / 2.0).sin_cos();
        let mut corner = Self { sine, cosine, length: 0.0, reach: 0.0, apex: 0.0 };
        let [length, end, _] = corner.integral(1.0);
        let [_, x, y] = corner.integral(0.5);
        corner.length = length;
        // By symmetry the way from end to end is what both lines lose, turned.
        corner.reach = end / (1.0 + turn.cos());
        corner.apex = (x - corner.reach).hypot(y);
        corner
    }

    /// |w|^2 and w^2.
    fn hodograph(&self, t: f64) -> [f64; 3] {
        let s = step(t)[0];
        let (re, im) = (1.0 - s + s * self.cosine, s * self.sine);
        [re * re + im * im, re * re - im * im, 2.0 * re * im]
    }

    /// Arc length and place at a parameter.
    fn integral(&self, t: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (node, weight) in GAUSS {
            for sign in [-1.0, 1.0] {
                let values = self.hodograph(t * (1.0 + sign * node) / 2.0);
                for (sum, value) in sum.iter_mut().zip(values) {
                    *sum += weight / 2.0 * t * value;
                }
            }
        }
        sum
    }

    /// The place at an arc length from its start. The cost is some Newton steps of eight evaluations.
    pub fn place(&self, way: f64) -> Place {
        let way = way.clamp(0.0, self.length);
        let mut t = way / self.length;
        for _ in 0..STEPS {
            let off = (self.integral(t)[0] - way) / self.hodograph(t)[0];
            t = (t - off).clamp(0.0, 1.0);
            if off.abs() < 1e-15 {
                break;
            }
        }
        let [_, x, y] = self.integral(t);
        let [size, re, im] = self.hodograph(t);
        let [s, first, second] = step(t);
        let slope = -2.0 * (1.0 - 2.0 * s) * first * (1.0 - self.cosine);
        let square = size * size;
        Place {
            at: [x, y],
            tangent: [re / size, im / size],
            curvature: 2.0 * first * self.sine / square,
            change: 2.0 * self.sine * (second - 2.0 * first * slope / size) / (square * size),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It ends on the other line with its direction; tangent, curvature and its change are the derivatives of the place.
    #[test]
    fn it_is_what_it_says() {
        for degrees in [5.0f64, 60.0, 90.0, 150.0] {
            let turn = degrees.to_radians();
            let corner = Corner::new(turn);
            let end = corner.place(corner.length);
            let other = [corner.reach * (1.0 + turn.cos()), corner.reach * turn.sin()];
            assert!((end.at[0] - other[0]).hypot(end.at[1] - other[1]) < 1e-12);
            assert!((end.tangent[0] - turn.cos()).hypot(end.tangent[1] - turn.sin()) < 1e-12);
            assert!(end.curvature.abs() + end.change.abs() < 1e-9, "C4 contact");
            let h = 1e-4;
            for share in [0.1, 0.3, 0.5, 0.8] {
                let [a, b, c] = [-h, 0.0, h].map(|off| corner.place(share * corner.length + off));
                let tangent = [0, 1].map(|n| (c.at[n] - a.at[n]) / (2.0 * h));
                let bend = [0, 1].map(|n| (c.tangent[n] - a.tangent[n]) / (2.0 * h));
                let curvature = b.tangent[0] * bend[1] - b.tangent[1] * bend[0];
                let change = (c.curvature - a.curvature) / (2.0 * h);
                assert!((tangent[0] - b.tangent[0]).hypot(tangent[1] - b.tangent[1]) < 1e-5);
                assert!((curvature - b.curvature).abs() < 1e-4 * (1.0 + b.curvature.powi(3)));
                assert!((change - b.change).abs() < 1e-3 * (1.0 + b.curvature.powi(4)));
            }
        }
    }
}
