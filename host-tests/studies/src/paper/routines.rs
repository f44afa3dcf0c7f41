//! Sections 3.1 to 3.5 of Guo, Yan, Wang 2023 as printed, from points to control points: independent of the core, which
//! is compared with it.

/// A point in space, mm.
pub type Point = [f64; 3];

/// Which rule of section 3.5 gave a transition its edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// e > epsilon: by alpha = e* / e.
    Scaled,
    /// In the band at once, but P4 would be the next corner: by 1/2.
    Halved,
    /// In the band at once: left as section 3.2 makes it.
    Whole,
}

/// A transition.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    /// Half the angle between the legs, rad.
    pub theta: f64,
    /// Distance from the corner of the band to the corner, delta / sin theta, mm.
    pub epsilon: f64,
    /// e of the transition of section 3.2, mm.
    pub first_e: f64,
    /// Its edge, mm.
    pub first_edge: f64,
    /// What made of it the one below.
    pub rule: Rule,
    /// P0 to P4.
    pub controls: [Point; 5],
}

/// `a + share (b - a)`.
fn between(a: &Point, b: &Point, share: f64) -> Point {
    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
}

/// The distance between two points, mm.
pub fn distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Section 3.2: five control points on both legs, of which the shorter decides. Also whether P4 is `ahead`.
fn select(from: &Point, corner: &Point, ahead: &Point) -> ([Point; 5], bool) {
    let (before, behind) = (distance(from, corner), distance(corner, ahead));
    let (first, last) = if before < behind {
        (*from, between(corner, ahead, before / behind))
    } else {
        (between(corner, from, behind / before), *ahead)
    };
    let middle = |a: &Point, b: &Point| between(a, b, 0.5);
    ([first, middle(&first, corner), *corner, middle(corner, &last), last], before >= behind)
}

impl Transition {
    /// Section 3.3 and the rules of section 3.5 at one corner. `last`: routine 3, which does not halve.
    fn new(from: &Point, corner: &Point, ahead: &Point, delta: f64, last: bool) -> Self {
        let (first, used_up) = select(from, corner, ahead);
        let (a, b) = (distance(from, corner), distance(corner, ahead));
        let cosine = (0..3).map(|i| (from[i] - corner[i]) * (ahead[i] - corner[i])).sum::<f64>();
        let theta = (cosine / (a * b)).clamp(-1.0, 1.0).acos() / 2.0;
        let mut made = Self {
            theta,
            epsilon: delta / theta.sin(),
            first_e: 0.0,
            first_edge: distance(&first[0], &first[1]),
            rule: Rule::Whole,
            controls: first,
        };
        made.first_e = made.e();
        let ideal = delta / 2.0;
        let alpha = if made.first_e > made.epsilon {
            made.rule = Rule::Scaled;
            ideal / made.first_e
        } else if used_up && !last {
            made.rule = Rule::Halved;
            0.5
        } else {
            1.0
        };
        made.controls = first.map(|p| between(corner, &p, alpha));
        made
    }

    /// Length L of an edge of the control polygon, mm.
    pub fn edge(&self) -> f64 {
        distance(&self.controls[0], &self.controls[1])
    }

    /// Distance e = |P2 - C(.5)| (eq. 7), mm.
    pub fn e(&self) -> f64 {
        distance(&self.controls[2], &self.at(0.5).0)
    }

    /// Distance of the shoulder C(.5) from the legs, mm: the greatest of the curve.
    pub fn deviation(&self) -> f64 {
        self.e() * self.theta.sin()
    }

    /// Curvature at the shoulder, 1/mm: 4 cos theta / (3 L sin^2 theta).
    pub fn apex_curvature(&self) -> f64 {
        4.0 * self.theta.cos() / (3.0 * self.edge() * self.theta.sin().powi(2))
    }

    /// Point, first and second derivative at a parameter in [0, 1]; knots {0, 0, 0, 0, .5, 1, 1, 1, 1}.
    pub fn at(&self, u: f64) -> (Point, Point, Point) {
        let [p0, p1, p2, p3, p4] = self.controls;
        let (a, b) = (between(&p1, &p2, 0.5), between(&p2, &p3, 0.5));
        let shoulder = between(&a, &b, 0.5);
        // Two Bezier spans, each over half of the parameter.
        let (span, v) = if u < 0.5 {
            ([p0, p1, a, shoulder], 2.0 * u)
        } else {
            ([shoulder, b, p3, p4], 2.0 * u - 1.0)
        };
        let w = 1.0 - v;
        let mix = |weights: &[f64]| -> Point {
            std::array::from_fn(|i| weights.iter().zip(&span).map(|(k, p)| k * p[i]).sum())
        };
        (
            mix(&[w * w * w, 3.0 * w * w * v, 3.0 * w * v * v, v * v * v]),
            mix(&[-6.0 * w * w, 6.0 * w * (w - 2.0 * v), 6.0 * v * (2.0 * w - v), 6.0 * v * v]),
            mix(&[24.0 * w, 24.0 * (v - 2.0 * w), 24.0 * (w - 2.0 * v), 24.0 * v]),
        )
    }

    /// Curvature at a parameter, 1/mm.
    pub fn curvature(&self, u: f64) -> f64 {
        let (_, d, dd) = self.at(u);
        let dot = |a: &Point, b: &Point| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
        let square = dot(&d, &d);
        let across = (square * dot(&dd, &dd) - dot(&d, &dd).powi(2)).max(0.0);
        across.sqrt() / square.powf(1.5)
    }

    /// The distance of a point from the curve, mm, to within `step` squared times its curvature.
    pub fn distance(&self, point: &Point) -> f64 {
        const STEPS: u32 = 200;
        let at = |k: f64| distance(&self.at(k / f64::from(STEPS)).0, point);
        let nearest = (0..=STEPS).min_by(|a, b| at(f64::from(*a)).total_cmp(&at(f64::from(*b))));
        // Unimodal next to the nearest of the samples: the golden section.
        let centre = f64::from(nearest.unwrap_or(0));
        let (mut low, mut high) = ((centre - 1.0).max(0.0), (centre + 1.0).min(f64::from(STEPS)));
        let golden = (5.0f64.sqrt() - 1.0) / 2.0;
        for _ in 0..40 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if at(a) < at(b) {
                high = b;
            } else {
                low = a;
            }
        }
        at(f64::midpoint(low, high))
    }
}

/// Section 3.5: routine 1 at the first corner, 2 at those between, 3 at the last. One transition for every inner point.
pub fn transitions(points: &[Point], delta: f64, lambda: f64) -> Vec<Transition> {
    let mut made: Vec<Transition> = Vec::new();
    for (n, corner) in points.windows(3).enumerate() {
        // Eq. 8, from the second corner on.
        let from = made.last().map_or(corner[0], |t| between(&t.controls[4], &corner[1], lambda));
        let last = n + 3 == points.len();
        made.push(Transition::new(&from, &corner[1], &corner[2], delta, last));
    }
    made
}

/// The distance of a point from the whole path - legs and transitions -, mm.
pub fn path_distance(points: &[Point], made: &[Transition], at: &Point) -> f64 {
    let (Some(mut from), Some(end)) = (points.first().copied(), points.last()) else {
        return f64::INFINITY;
    };
    let mut least = f64::INFINITY;
    for transition in made {
        least = least.min(line_distance(&from, &transition.controls[0], at));
        if distance(&transition.controls[2], at) < 2.5 * transition.edge() {
            least = least.min(transition.distance(at));
        }
        from = transition.controls[4];
    }
    least.min(line_distance(&from, end, at))
}

/// The distance of a point from the poly-line itself, mm.
pub fn poly_distance(points: &[Point], at: &Point) -> f64 {
    let legs = points.windows(2).map(|leg| line_distance(&leg[0], &leg[1], at));
    legs.fold(f64::INFINITY, f64::min)
}

fn line_distance(a: &Point, b: &Point, at: &Point) -> f64 {
    let along = |p: &Point| (0..3).map(|i| (p[i] - a[i]) * (b[i] - a[i])).sum::<f64>();
    let whole = along(b);
    let share = if whole > 0.0 { (along(at) / whole).clamp(0.0, 1.0) } else { 0.0 };
    distance(&between(a, b, share), at)
}
