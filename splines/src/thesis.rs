//! The smoothing algorithm of Naseath (2007), chapter 3, as printed.
//!
//! Every iteration sorts the control points into ends, ripples and smooth groups ([`categories`]),
//! gives each a direction ([`directions`]) and moves it as far as makes the whole spline move
//! evenly ([`move_distances`]); it ends when the spline is within `accuracy` of the tube's radius,
//! with the control polygon of the iteration before ([`smooth`]).
//!
//! Where the text is silent or leaves a choice, this is what is done:
//! - *Sides of a line* (section 3.5) are told by the scalar product of the two points' distances from
//!   it, as vectors: in a plane that is the product of the signed distances of equations 3-7 to
//!   3-13, and it means the same in three dimensions and more, where section 5.1.2 wants quadrants between two
//!   planes whose rotation it leaves open. A point on the line is on neither side.
//! - *Groups*: all contiguous smooth points, but two secondary smooth points next to each other end
//!   one group and begin the next (as in figure 3-9). A secondary point between two primary ones
//!   belongs to one group with both.
//! - *Ends* move at right angles to the path as it was given, not to the control polygon as it is now
//!   (equation 3-17 has the polygon, the text around it the tube). In more than two axes the direction
//!   is that part of the way to the target line that is at right angles to the path.
//! - *Rings*: a closed spline may be one smooth group all around, without beginning, end or apex. Its
//!   points move outwards (equation 3-29).
//! - *Double apex*: equation 3-27 takes the point after the second apex; if it lies on the line, the
//!   one before the first is taken.
//! - *Sensitivities* that are 0 are made 1 (section 3.9). A point without a direction has the one that its
//!   neighbours' moves give its place: 1 only if the spline rests there.
//! - *Maximum distance* is sampled, `precision` places per knot interval (section 3.8): between them
//!   the spline may be farther out, by up to several per cent of the radius where knots are uneven.
//!   [`super::bounded`] is bounded instead.
//! - *Overshooting*: a move is as long as the tube allows, not as the way to the straight line is. A ripple smaller than the
//!   tube passes that line to and fro, and its curvature may be greater in the end than it was.
//! - *First iteration*: where smooth groups move as a whole it may reach the tube at once, and the
//!   result would be the spline as given. Then its moves are halved until it does not.
//! - *No end*: if no point has a direction the spline is straight; then, and after
//!   `most_iterations`, what there is is the result.

use crate::bspline::{Spline, append};
use crate::error::SplineError;
use heapless::Vec;
use splineway::machine::Quantity;
use splineway::number::vector::{Vector, dot, mix, norm, sub, zero};
use splineway::number::{Range, Scalar};

/// How much the direction of the apex outweighs the preliminary one (equation 3-30).
const APEX_SHARE: f64 = 9.0;
/// Most halvings of the first move.
const HALVINGS: u32 = 4;
/// Squares of lengths below this share of the squares they came from are 0.
const FLAT: f64 = 1.0e-24;

/// What kind of point a control point is (section 3.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Category {
    /// First or last of an open spline.
    End,
    /// Between points on opposite sides, or on a straight line.
    Ripple,
    /// On an arc; with the group's first and last apex (equal if there is one).
    Smooth {
        /// Index of the first apex.
        first: usize,
        /// Index of the second apex.
        second: usize,
    },
    /// Smooth, on a closed spline that is one arc all around.
    Ring,
}

/// Before grouping.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Ripple,
    Primary,
    Secondary,
}

/// Parameters of the algorithm (section 4.2).
#[derive(Clone, Copy, Debug)]
pub struct Options<S> {
    /// Radius of the tube, mm.
    pub radius: S,
    /// Places per knot interval at which distances are taken (the thesis: 5).
    pub precision: u32,
    /// Share of the radius within which the spline counts as touching the tube (the thesis: 0.01).
    pub accuracy: S,
    /// Most iterations.
    pub most_iterations: u32,
    /// Whether distances are bounded instead of sampled: the tube is not left between the places
    /// either. The thesis: no.
    pub bounded: bool,
}

impl<S: Scalar> Options<S> {
    /// The thesis's values for a radius, mm.
    pub fn new(radius: S) -> Self {
        Self { radius, precision: 5, accuracy: S::of(0.01), most_iterations: 1000, bounded: false }
    }

    /// # Errors
    /// Names the first value that is out of its range.
    pub fn check(&self) -> Result<(), SplineError> {
        let within = |what, value: S, least: f64, greatest: f64| {
            let value = value.to_f64();
            if value >= least && value <= greatest {
                return Ok(());
            }
            Err(SplineError::OutOfRange { what, value, least, greatest })
        };
        let Range { least, greatest } = Quantity::Tolerance.range();
        within("tolerance radius", self.radius, least, greatest)?;
        within("precision", S::from_u32(self.precision), 1.0, 1.0e3)?;
        within("accuracy", self.accuracy, 1.0e-6, 0.5)
    }
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ending {
    /// The spline touches the tube.
    Touching,
    /// It is straight.
    Straight,
    /// The iterations were used up.
    Iterations,
}

/// What the algorithm did.
#[derive(Clone, Copy, Debug)]
pub struct Outcome<S> {
    /// Iterations.
    pub iterations: u32,
    /// How it ended.
    pub ending: Ending,
    /// Distance left to the tube after the last iteration kept, as sampled, mm.
    pub left: S,
}

/// A neighbour's index: `None` beyond the ends of an open spline.
fn neighbour<S: Scalar, const N: usize, const CAP: usize>(
    spline: &Spline<S, N, CAP>,
    i: usize,
    by: isize,
) -> Option<usize> {
    let m = spline.controls().len();
    if spline.is_closed() {
        // `by` is less than a turn.
        return (i + m).checked_add_signed(by)?.checked_rem(m);
    }
    i.checked_add_signed(by).filter(|&j| j < m)
}

/// From the line through `a` and `b` to `p`, at right angles to it.
fn off_line<S: Scalar, const N: usize>(
    p: &Vector<S, N>,
    a: &Vector<S, N>,
    b: &Vector<S, N>,
) -> Vector<S, N> {
    let (line, way) = (sub(b, a), sub(p, a));
    let square = dot(&line, &line);
    if !(square > S::ZERO) {
        return way;
    }
    let off = mix(S::ONE, &way, -(dot(&way, &line) / square), &line);
    if dot(&off, &off) <= S::of(FLAT) * dot(&way, &way) { zero() } else { off }
}

/// In the direction of a vector, of length 1; null if it is.
fn normalised<S: Scalar, const N: usize>(v: &Vector<S, N>) -> Vector<S, N> {
    let length = norm(v);
    if length > S::ZERO { v.map(|x| x / length) } else { zero() }
}

/// The category of every control point.
pub fn categories<S: Scalar, const N: usize, const CAP: usize>(
    spline: &Spline<S, N, CAP>,
) -> Vec<Category, CAP> {
    let mut out = Vec::new();
    categorise(spline, &mut out);
    out
}

/// The same, in place: moving a list moves all of its room.
fn categorise<S: Scalar, const N: usize, const CAP: usize>(
    spline: &Spline<S, N, CAP>,
    out: &mut Vec<Category, CAP>,
) {
    out.clear();
    let points = spline.controls();
    let m = points.len();
    let mut kinds: Vec<Kind, CAP> = Vec::new();
    let at = |i: usize, by: isize| neighbour(spline, i, by).and_then(|j| points.get(j));
    // Whether i - 2 and i + 1 lie on one side of the line through i - 1 and i.
    let one_side = |i: usize| -> bool {
        let four = (at(i, -2), at(i, -1), at(i, 0), at(i, 1));
        let (Some(a), Some(b), Some(p), Some(c)) = four else { return false };
        dot(&off_line(a, b, p), &off_line(c, b, p)) > S::ZERO
    };
    let mut sides: Vec<bool, CAP> = Vec::new();
    for i in 0..m {
        append(&mut sides, one_side(i));
    }
    for (i, side) in sides.iter().enumerate() {
        let next = neighbour(spline, i, 1).and_then(|next| sides.get(next));
        let primary = *side && next == Some(&true);
        append(&mut kinds, if primary { Kind::Primary } else { Kind::Ripple });
    }
    for i in 0..m {
        let kind = |by: isize| neighbour(spline, i, by).and_then(|j| kinds.get(j));
        let beside = [-1, 1].into_iter().any(|by| kind(by) == Some(&Kind::Primary));
        if let Some(kind) = kinds.get_mut(i)
            && beside
            && *kind == Kind::Ripple
        {
            *kind = Kind::Secondary;
        }
    }
    for kind in &kinds {
        let ripple = *kind == Kind::Ripple;
        append(out, if ripple { Category::Ripple } else { Category::Ring });
    }
    let kind = |i: usize| kinds.get(i).copied().unwrap_or(Kind::Ripple);
    let ends_before = |i: usize| -> bool {
        let Some(before) = neighbour(spline, i, -1) else { return true };
        kind(before) == Kind::Ripple
            || (kind(before) == Kind::Secondary && kind(i) == Kind::Secondary)
    };
    for begin in 0..m {
        if kind(begin) == Kind::Ripple || !ends_before(begin) {
            continue;
        }
        let mut count = 1;
        while count < m
            && let Some(next) = neighbour(spline, begin, count.cast_signed())
            && kind(next) != Kind::Ripple
            && !ends_before(next)
        {
            count += 1;
        }
        let member = |k: usize| neighbour(spline, begin, k.cast_signed()).unwrap_or(begin);
        let (first, second) = (member((count - 1) / 2), member(count / 2));
        for k in 0..count {
            if let Some(category) = out.get_mut(member(k)) {
                *category = Category::Smooth { first, second };
            }
        }
    }
    if let [first, .., last] = out.as_mut_slice()
        && !spline.is_closed()
    {
        (*first, *last) = (Category::End, Category::End);
    }
}

/// The direction in which every control point moves, of length 1 or null (section 3.6). `start` is the
/// spline as it was given. A control point without a category, or with one that names points that there are
/// not, does not move: as none does if the splines are not of the same size.
pub fn directions<S: Scalar, const N: usize, const CAP: usize>(
    spline: &Spline<S, N, CAP>,
    start: &Spline<S, N, CAP>,
    categories: &[Category],
) -> Vec<Vector<S, N>, CAP> {
    let mut out = Vec::new();
    direct(spline, start, categories, &mut out);
    out
}

/// The same, in place.
fn direct<S: Scalar, const N: usize, const CAP: usize>(
    spline: &Spline<S, N, CAP>,
    start: &Spline<S, N, CAP>,
    categories: &[Category],
    out: &mut Vec<Vector<S, N>, CAP>,
) {
    out.clear();
    let points = spline.controls();
    let m = points.len();
    let at = |i: usize, by: isize| neighbour(spline, i, by).and_then(|j| points.get(j));
    let same = start.controls().len() == m && m > 3;
    let known = |category: &Category| match *category {
        Category::Smooth { first, second } => first < m && second < m,
        _ => true,
    };
    // Equations 3-23 to 3-25.
    let bisector = |i: usize| -> Vector<S, N> {
        let three = (at(i, -1), at(i, 0), at(i, 1));
        let (Some(before), Some(point), Some(after)) = three else { return zero() };
        let a = normalised(&sub(before, point));
        let b = normalised(&sub(after, point));
        let sum = mix(S::ONE, &a, S::ONE, &b);
        // Opposite vectors of length 1 leave a rounding error.
        if norm(&sum) > S::EPSILON * S::of(8.0) { normalised(&sum) } else { zero() }
    };
    let apex = |first: usize, second: usize| -> Vector<S, N> {
        if first == second {
            return bisector(first);
        }
        // Equations 3-26 to 3-28: from the line of both towards the point behind them.
        let (Some(a), Some(b)) = (points.get(first), points.get(second)) else { return zero() };
        for beside in [at(second, 1), at(first, -1)] {
            let off = beside.map_or(zero(), |p| off_line(p, a, b));
            if norm(&off) > S::ZERO {
                return normalised(&off);
            }
        }
        zero()
    };
    let end = |[p, inner, next]: [&Vector<S, N>; 3], [q, q_inner]: [&Vector<S, N>; 2]| {
        // Equations 3-17 to 3-22.
        let path = normalised(&sub(q_inner, q));
        let way: Vector<S, N> = off_line(p, inner, next).map(|x| -x);
        normalised(&mix(S::ONE, &way, -dot(&way, &path), &path))
    };
    let (first_end, last_end) = match (points, start.controls()) {
        ([a, b, c, .., x, y, z], [p, q, .., r, s]) => {
            (end([a, b, c], [p, q]), end([z, y, x], [s, r]))
        }
        // Four or five points: the inner ones count from both ends.
        ([a, b, c, y, z], [p, q, .., r, s]) => (end([a, b, c], [p, q]), end([z, y, c], [s, r])),
        ([a, b, y, z], [p, q, r, s]) => (end([a, b, y], [p, q]), end([z, y, b], [s, r])),
        _ => (zero(), zero()),
    };
    for i in 0..m {
        let category = categories.get(i).filter(|category| same && known(category));
        let Some(category) = category else {
            append(out, zero());
            continue;
        };
        let direction = match *category {
            Category::End if i == 0 => first_end,
            Category::End => last_end,
            Category::Ripple => bisector(i),
            Category::Ring => bisector(i).map(|x| -x),
            Category::Smooth { first, second } if i == first || i == second => apex(first, second),
            // Equations 3-29 to 3-31.
            Category::Smooth { first, second } => {
                normalised(&mix(-S::ONE, &bisector(i), S::of(APEX_SHARE), &apex(first, second)))
            }
        };
        append(out, direction);
    }
}

/// How far every control point moves so that the spline moves evenly: the sensitivities inverted,
/// scaled to the greatest of them, times the greatest distance (equations 3-40 and 3-41).
pub fn move_distances<S: Scalar>(sensitivities: &mut [S], greatest: S) {
    let mut most = S::ZERO;
    for value in &mut *sensitivities {
        *value = if *value > S::ZERO { S::ONE / *value } else { S::ONE };
        most = most.greatest(*value);
    }
    for value in sensitivities {
        *value = greatest * (*value / most);
    }
}

/// Span and share of it that belong to control point `i` (equations 3-33 to 3-37).
fn place<S: Scalar, const N: usize, const CAP: usize>(
    spline: &Spline<S, N, CAP>,
    i: usize,
) -> (usize, S) {
    let m = spline.controls().len();
    let half = S::of(0.5);
    if spline.is_closed() {
        return ((i + m - 1) % m.max(1), S::ZERO);
    }
    match i {
        0 => (0, S::ZERO),
        1 => (0, half),
        _ if i + 1 == m => (m.saturating_sub(4), S::ONE),
        _ if i + 2 == m => (m.saturating_sub(4), half),
        _ => (i - 1, S::ZERO),
    }
}

/// Moves the control points; `move_by` holds their distances.
fn shift<S: Scalar, const N: usize, const CAP: usize>(
    from: &Spline<S, N, CAP>,
    directions: &[Vector<S, N>],
    move_by: &[S],
    to: &mut Spline<S, N, CAP>,
) {
    let start = from.controls().iter().zip(directions).zip(move_by);
    for (point, ((old, direction), distance)) in to.controls_mut().iter_mut().zip(start) {
        *point = mix(S::ONE, old, *distance, direction);
    }
}

/// The difference of two splines into a third over the same knots (equation 3-32).
fn subtract<S: Scalar, const N: usize, const CAP: usize>(
    a: &Spline<S, N, CAP>,
    b: &Spline<S, N, CAP>,
    out: &mut Spline<S, N, CAP>,
) {
    for (d, (x, y)) in out.controls_mut().iter_mut().zip(a.controls().iter().zip(b.controls())) {
        *d = sub(x, y);
    }
}

/// Span and basis functions there of the place of every control point: they stay the same while points move.
fn places<S: Scalar, const N: usize, const CAP: usize>(
    spline: &Spline<S, N, CAP>,
) -> Vec<(usize, [S; 4]), CAP> {
    let mut out = Vec::new();
    for i in 0..spline.controls().len() {
        let (span, u) = place(spline, i);
        append(&mut out, (span, spline.basis(span, u)));
    }
    out
}

/// From distances that control points were moved by to how far the spline moved per distance
/// (equation 3-38).
fn to_sensitivities<S: Scalar, const N: usize, const CAP: usize>(
    difference: &Spline<S, N, CAP>,
    places: &[(usize, [S; 4])],
    move_by: &mut [S],
) {
    for (distance, (span, basis)) in move_by.iter_mut().zip(places) {
        *distance = norm(&difference.weighted(*span, basis)) / *distance;
    }
}

/// Smooths a spline inside the tube around it, as printed.
///
/// Work: per iteration, some 50 operations per control point and axis, and `precision` points per span.
///
/// # Errors
/// Names the option that is out of its range.
pub fn smooth<S: Scalar, const N: usize, const CAP: usize>(
    spline: &mut Spline<S, N, CAP>,
    options: &Options<S>,
) -> Result<Outcome<S>, SplineError> {
    options.check()?;
    let start = spline.clone();
    let radius = options.radius;
    let mut outcome = Outcome { iterations: 0, ending: Ending::Iterations, left: radius };
    let is_null = |directions: &[Vector<S, N>]| directions.iter().all(|d| norm(d) == S::ZERO);
    let (mut kinds, mut heading) = (Vec::new(), Vec::new());
    categorise(spline, &mut kinds);
    direct(spline, &start, &kinds, &mut heading);
    if is_null(&heading) || radius == S::ZERO {
        outcome.ending = Ending::Straight;
        return Ok(outcome);
    }
    // The mock iteration (section 3.7).
    let mut move_by: Vec<S, CAP> = Vec::new();
    for _ in 0..start.controls().len() {
        append(&mut move_by, radius);
    }
    let (mut next, mut difference, places) = (start.clone(), start.clone(), places(&start));
    shift(spline, &heading, &move_by, &mut next);
    subtract(&next, spline, &mut difference);
    to_sensitivities(&difference, &places, &mut move_by);
    for iteration in 1..=options.most_iterations {
        move_distances(&mut move_by, outcome.left);
        let mut left = S::ZERO;
        for _ in 0..if iteration == 1 { HALVINGS } else { 1 } {
            shift(spline, &heading, &move_by, &mut next);
            subtract(&next, &start, &mut difference);
            let bounded = options.bounded;
            let precision = options.precision;
            let off =
                if bounded { difference.bound(precision) } else { difference.greatest(precision) };
            left = radius - off;
            if left > options.accuracy * radius {
                break;
            }
            for distance in &mut move_by {
                *distance = *distance * S::of(0.5);
            }
        }
        outcome.iterations = iteration;
        if left <= options.accuracy * radius {
            outcome.ending = Ending::Touching;
            return Ok(outcome);
        }
        subtract(&next, spline, &mut difference);
        to_sensitivities(&difference, &places, &mut move_by);
        outcome.left = left;
        spline.move_to(next.controls());
        categorise(spline, &mut kinds);
        direct(spline, &start, &kinds, &mut heading);
        if is_null(&heading) {
            outcome.ending = Ending::Straight;
            return Ok(outcome);
        }
    }
    Ok(outcome)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // what is exact is meant to be
mod tests {
    use super::*;
    use core::array::from_fn;

    /// The worked numbers of equations 3-42 to 3-46.
    #[test]
    fn worked_example_of_section_3_9() {
        let given = [0.2f64, 0.4, 0.5, 0.8, 1.0];
        let mut scaled = given;
        move_distances(&mut scaled, 1.0);
        assert!(scaled == [1.0, 0.5, 0.4, 0.25, 0.2], "{scaled:?}");
        let mut moves = given;
        move_distances(&mut moves, 10.0);
        assert!(moves == [10.0, 5.0, 4.0, 2.5, 2.0], "{moves:?}");
        for (distance, sensitivity) in moves.iter().zip(given) {
            assert!((distance * sensitivity - 2.0).abs() < 1e-15);
        }
        // Zero sensitivities count as 1.
        let mut moves = [0.0, 0.5];
        move_distances(&mut moves, 4.0);
        assert!(moves == [2.0, 4.0], "{moves:?}");
    }

    /// Categories of another spline move nothing that is not there.
    #[test]
    fn categories_of_another_size_do_not_move() {
        let points: [[f64; 2]; 9] = from_fn(|k| [k as f64, (k % 3) as f64]);
        let (long, short) = (even(&points), even(&points[..5]));
        let kinds = categories(&long);
        assert_eq!(directions(&short, &short, &kinds).len(), 5);
        assert!(directions(&short, &long, &kinds).iter().all(|way| *way == [0.0; 2]));
        let few = directions(&long, &long, &categories(&short));
        assert!(few.len() == 9 && few[5..].iter().all(|way| *way == [0.0; 2]));
        assert!(directions(&long, &long, &[]).iter().all(|way| *way == [0.0; 2]));
    }

    fn even<const N: usize>(points: &[[f64; N]]) -> Spline<f64, N, 32> {
        let knots: std::vec::Vec<f64> = (0..points.len() - 2).map(|k| k as f64).collect();
        Spline::open(points, &knots).unwrap()
    }

    #[test]
    fn ripples_groups_and_apexes() {
        let zigzag: std::vec::Vec<[f64; 2]> =
            (0..8).map(|k| [f64::from(k), f64::from(k % 2)]).collect();
        let found = categories(&even(&zigzag));
        assert_eq!((found[0], found[7]), (Category::End, Category::End));
        assert!(found[1..7].iter().all(|c| *c == Category::Ripple));
        // A straight line, then an arc of six points, as points 4 to 9 of figure 3-15.
        let arc = [[4.0, 0.3], [4.8, 0.9], [5.3, 1.8], [5.3, 2.8], [4.8, 3.7], [4.0, 4.3]];
        let mut points = std::vec![[0.0, 0.0], [1.0, -0.2], [2.0, 0.2], [3.0, -0.1]];
        points.extend(arc);
        points.extend([[3.0, 4.7], [2.0, 4.4], [1.0, 4.8], [0.0, 4.6]]);
        let found = categories(&even(&points));
        let group = Category::Smooth { first: 6, second: 7 };
        assert!(found[4..10].iter().all(|c| *c == group), "{found:?}");
        assert!(found[2] == Category::Ripple && found[11] == Category::Ripple, "{found:?}");
    }

    /// Turned into space, the same spline has the same categories and does the same.
    #[test]
    fn space_is_as_the_plane() {
        let wave = |k: usize| [k as f64, (0.9 * k as f64).sin() + 0.4 * (2.3 * k as f64).cos()];
        let flat: std::vec::Vec<[f64; 2]> = (0..14).map(wave).collect();
        let turn = |p: [f64; 2]| [p[0] * 0.6 - p[1] * 0.48, p[0] * 0.8 + p[1] * 0.36, p[1] * 0.8];
        let bent: std::vec::Vec<[f64; 3]> = flat.iter().map(|p| turn(*p)).collect();
        let (mut a, mut b) = (even(&flat), even(&bent));
        assert_eq!(categories(&a), categories(&b));
        let (x, y) = (
            smooth(&mut a, &Options::new(0.2)).unwrap(),
            smooth(&mut b, &Options::new(0.2)).unwrap(),
        );
        assert_eq!((x.iterations, x.ending), (y.iterations, y.ending));
        for (p, q) in a.controls().iter().zip(b.controls()) {
            let turned = turn(*p);
            let off: [f64; 3] = from_fn(|i| turned[i] - q[i]);
            assert!(norm(&off) < 1e-9, "{off:?}");
        }
    }

    #[test]
    fn straight_lines_stay_and_ripples_go() {
        let line: std::vec::Vec<[f64; 2]> = (0..10).map(|k| [f64::from(k), 0.0]).collect();
        let mut spline = even(&line);
        let outcome = smooth(&mut spline, &Options::new(0.1)).unwrap();
        assert_eq!((outcome.ending, outcome.iterations), (Ending::Straight, 0));
        let mut noisy = line;
        noisy[4][1] = 0.2;
        noisy[5][1] = -0.2;
        let mut spline = even(&noisy);
        let before = (spline.clone(), spline.peak(10));
        let outcome = smooth(&mut spline, &Options::new(0.1)).unwrap();
        assert_eq!(outcome.ending, Ending::Touching);
        assert!(spline.peak(10) < 0.5 * before.1);
        assert!(spline.length() < before.0.length());
        assert!(spline.difference(&before.0).unwrap().greatest(5) <= 0.1);
    }

    #[test]
    fn a_closed_spline_has_no_ends() {
        let points: std::vec::Vec<[f64; 2]> = (0..24)
            .map(|k| {
                let angle = f64::from(k) * core::f64::consts::TAU / 24.0;
                let r = if k % 4 == 0 { 11.0 } else { 10.0 };
                [r * angle.cos(), r * angle.sin()]
            })
            .collect();
        let mut spline = Spline::<f64, 2, 32>::closed(&points, &[1.0; 24]).unwrap();
        assert!(categories(&spline).iter().all(|c| *c != Category::End));
        let before = spline.clone();
        let outcome = smooth(&mut spline, &Options::new(0.1)).unwrap();
        assert!(outcome.iterations > 1 && spline.peak(10) < 0.98 * before.peak(10), "{outcome:?}");
        assert!(spline.difference(&before).unwrap().greatest(5) <= 0.1);
    }
}
