//! What blocks of random programs do, and how far beside the programmed path a motion is: every block in its own tolerance.

use splineway::{Coord, Motion, Scalar, Setpoint, Turn};

/// Chords of an arc or curve leave it by no more, mm.
pub const SAGITTA: f64 = 5.0e-6;
/// What is granted to the finest input, mm.
pub const FINEST: f64 = 1.0e-6;

pub type Point<const A: usize> = [f64; A];

pub fn distance<const A: usize>(a: &Point<A>, b: &Point<A>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

pub fn towards<const A: usize>(a: &Point<A>, b: &Point<A>, share: f64) -> Point<A> {
    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
}

/// What a block does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way<const A: usize> {
    Line,
    /// About a centre in XY, by an angle that is not a full turn.
    Arc([f64; 2], f64),
    Curve([Point<A>; 2]),
    Dwell(f64),
    Event,
}

impl<const A: usize> Way<A> {
    /// The place after a share of it.
    pub fn at(&self, from: &Point<A>, to: &Point<A>, share: f64) -> Point<A> {
        match *self {
            Self::Line => towards(from, to, share),
            Self::Arc([x, y], angle) => {
                let (dx, dy) = (from[0] - x, from[1] - y);
                let (sin, cos) = (angle * share).sin_cos();
                let mut at = towards(from, to, share);
                (at[0], at[1]) = (x + cos * dx - sin * dy, y + sin * dx + cos * dy);
                at
            }
            Self::Curve([b, c]) => {
                let [ab, bc, cd] =
                    [(from, &b), (&b, &c), (&c, to)].map(|(a, b)| towards(a, b, share));
                towards(&towards(&ab, &bc, share), &towards(&bc, &cd, share), share)
            }
            Self::Dwell(_) | Self::Event => *from,
        }
    }

    /// How many chords stand for it.
    pub fn chords(&self, from: &Point<A>, to: &Point<A>) -> usize {
        let square = match *self {
            Self::Line | Self::Dwell(_) | Self::Event => return 1,
            Self::Arc([x, y], angle) => {
                (from[0] - x).hypot(from[1] - y) * angle * angle / (8.0 * SAGITTA)
            }
            Self::Curve([b, c]) => {
                let bend = |a: &Point<A>, b: &Point<A>, c: &Point<A>| {
                    (0..A).map(|i| (a[i] - 2.0 * b[i] + c[i]).powi(2)).sum::<f64>().sqrt()
                };
                0.75 * bend(from, &b, &c).max(bend(&b, &c, to)) / SAGITTA
            }
        };
        (square.sqrt().ceil() as usize).clamp(8, 100_000)
    }

    /// What is granted beyond its tolerance, mm.
    pub fn grant(&self) -> f64 {
        if matches!(self, Self::Line) { FINEST } else { SAGITTA }
    }

    pub fn moves(&self) -> bool {
        !matches!(self, Self::Dwell(_) | Self::Event)
    }

    /// The motion of a block to a place, of the first axes; of one that moves.
    pub fn motion<S, const N: usize>(&self, to: &Point<A>) -> Motion<S, N> {
        let mm = |x: f64| Coord::from_mm(x).unwrap();
        let at = |p: &Point<A>| -> [Coord; N] { std::array::from_fn(|i| mm(p[i])) };
        match *self {
            Self::Curve(controls) => {
                Motion::Cubic { controls: controls.map(|p| at(&p)), to: at(to) }
            }
            Self::Arc([x, y], angle) => Motion::Arc {
                to: at(to),
                plane: (0, 1),
                centre: (mm(x), mm(y)),
                turn: if angle > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise },
                extra_turns: 0,
            },
            _ => Motion::Line { to: at(to) },
        }
    }
}

/// The programmed path as chords, each with the tolerance of its block, and how far the motion has come along it.
pub struct Followed<const A: usize> {
    /// Ends of the chords, the way up to each, and the number and tolerance of its block.
    points: Vec<(Point<A>, f64, usize, f64)>,
    /// Chord and way that have been reached at least, and the way that may have been.
    chord: usize,
    way: f64,
    far: f64,
    last: Point<A>,
    widest: f64,
}

impl<const A: usize> Followed<A> {
    /// Blocks by what they do, where they end, and their tolerance.
    pub fn new(start: Point<A>, blocks: impl Iterator<Item = (Way<A>, Point<A>, f64)>) -> Self {
        let mut points = vec![(start, 0.0, 0, f64::INFINITY)];
        let (mut from, mut widest) = (start, 0.0f64);
        for (n, (way, to, tolerance)) in blocks.enumerate().filter(|(_, block)| block.0.moves()) {
            let chords = way.chords(&from, &to);
            for k in 1..=chords {
                let to = if k < chords { way.at(&from, &to, k as f64 / chords as f64) } else { to };
                let before = points[points.len() - 1];
                let way = before.1 + distance(&before.0, &to);
                if way > before.1 + 1.0e-9 {
                    points.push((to, way, n, tolerance));
                }
            }
            widest = widest.max(tolerance);
            from = to;
        }
        Self { points, chord: 0, way: 0.0, far: 0.0, last: start, widest }
    }

    /// Where it begins.
    pub fn start(&self) -> Point<A> {
        self.points[0].0
    }

    /// How far a place is outside, mm, and the block and tolerance by which that is least: of the blocks near the way
    /// come so far, each in its own tolerance, or beside its end in the lesser of its own and the next's.
    pub fn outside(&mut self, x: &Point<A>) -> (f64, usize, f64) {
        if self.points.len() < 2 {
            return (distance(x, &self.points[0].0), 0, 0.0);
        }
        let step = distance(&self.last, x);
        self.last = *x;
        let reach = 20.0 * self.widest + 0.02 + 2.0 * step;
        let mut low = self.chord;
        while low > 0 && self.points[low].1 > self.way - reach {
            low -= 1;
        }
        let near = self.far + 2.0 * step;
        let (mut best, mut nearest) =
            ((f64::INFINITY, 0, 0.0), (f64::INFINITY, self.chord, self.way));
        let (mut place, mut begin, mut far) = (None, None, self.way);
        for k in low..self.points.len() - 1 {
            let ((a, start, ..), (b, end, block, own)) = (self.points[k], self.points[k + 1]);
            if k > self.chord && start > self.far + reach {
                break;
            }
            let length = end - start;
            let along =
                (0..A).map(|i| (x[i] - a[i]) * (b[i] - a[i])).sum::<f64>() / (length * length);
            let off = |share: f64| distance(&towards(&a, &b, share), x);
            let share = along.clamp(0.0, 1.0);
            let tolerance = match share {
                0.0 => own.min(self.points[k].3),
                1.0 => own.min(self.points.get(k + 2).map_or(own, |next| next.3)),
                _ => own,
            };
            let here = off(share);
            if here - tolerance < best.0 {
                best = (here - tolerance, block, tolerance);
            }
            if here < nearest.0 {
                nearest = (here, k, start + share * length);
            }
            // Never back: a path that is run to and fro is passed twice.
            if k >= self.chord && place.is_none() {
                let share = share.max((self.way - start) / length).min(1.0);
                if off(share) <= own * 1.001 + FINEST {
                    place = Some((k, start + share * length));
                }
            }
            // Where the path winds within its band nobody can tell which turn it is.
            let band = (own * 1.001 + FINEST) / length;
            let half = (band * band - (off(along) / length).powi(2)).sqrt();
            let (from, to) = (along - half, along + half);
            let before: Option<f64> = begin.take();
            if from <= 1.0 && to >= 0.0 {
                let since =
                    before.filter(|_| from <= 0.0).unwrap_or(start + from.max(0.0) * length);
                if since <= near {
                    far = far.max(start + to.min(1.0) * length);
                }
                begin = (to >= 1.0).then_some(since);
            }
        }
        let (chord, way) = place.unwrap_or((nearest.1, nearest.2));
        if way > self.way {
            (self.chord, self.way) = (chord, way);
        }
        self.far = far.max(self.way);
        best
    }
}

/// The place a part of a servo cycle behind its start, of so many seconds: the quintic between both states, and 0 in axes that the
/// machine does not have.
pub fn between<S: Scalar, const N: usize, const A: usize>(
    [from, to]: [&Setpoint<S, N>; 2],
    cycle: f64,
    part: f64,
) -> Point<A> {
    std::array::from_fn(|i| {
        if i >= N {
            return 0.0;
        }
        let moved: f64 = to.position(i).minus(from.position(i));
        let [v0, v1] = [from, to].map(|at| at.velocity[i].to_f64() * cycle);
        let [a0, a1] = [from, to].map(|at| at.acceleration[i].to_f64() * cycle * cycle);
        let (p, v, a) = (moved - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0);
        let (c, d, e) =
            (10.0 * p - 4.0 * v + 0.5 * a, -15.0 * p + 7.0 * v - a, 6.0 * p - 3.0 * v + 0.5 * a);
        let cube = part * part * part;
        from.position_mm(i) + part * (v0 + 0.5 * a0 * part) + cube * (c + part * (d + part * e))
    })
}
