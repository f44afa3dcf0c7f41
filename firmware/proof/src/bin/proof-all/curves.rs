//! Splines, as a front end on a board may use them.

use core::hint::black_box;
use splineway::spline::nurbs::{Cubics, Knots, Nurbs};
use splineway_splines::{Low, Lows, Spline, SplineError, Trajectory, bounded, thesis};

type Curve = Spline<f32, 3, 16>;

/// Knots of every convention.
fn spline() -> Result<Curve, SplineError> {
    let points = black_box([[0.0; 3]; 16]);
    let points = points.get(..black_box(6)).unwrap_or_default();
    let knots = black_box([0.0; 20]);
    let knots = knots.get(..black_box(8)).unwrap_or_default();
    if black_box(true) { Spline::open(points, knots) } else { Spline::closed(points, knots) }
}

/// NURBS of every kind.
fn converted() -> Option<Curve> {
    let points = black_box([[0.0; 3]; 16]);
    let points = points.get(..black_box(6)).unwrap_or_default();
    let weights = black_box([1.0; 16]);
    let weights = weights.get(..black_box(6)).unwrap_or_default();
    let knots = black_box([0.0; 20]);
    let knots = Knots::Given(knots.get(..black_box(8)).unwrap_or_default());
    let knots = if black_box(true) { knots } else { Knots::Even };
    let curve = Nurbs::new(black_box(3), points, weights, knots).ok()?;
    black_box(Cubics::default().step(&curve, black_box(1.0e-6)));
    Spline::from_nurbs(&curve, black_box(1.0e-3)).ok()
}

/// Everything that is told of a spline, at any place.
fn told(spline: &mut Curve, other: &Curve) -> Result<(), SplineError> {
    let (span, u) = black_box((77, 0.5));
    black_box((spline.point(span, u), spline.at(u), spline.locate(u), spline.range(span)));
    black_box((spline.bezier(span), spline.derivatives(span, u), spline.curvature(span, u)));
    black_box((spline.span_length(span), spline.length(), spline.offset(span, u, u)));
    black_box((spline.spans(), spline.is_closed(), spline.knots(), spline.controls()));
    black_box((spline.greatest(black_box(5)), spline.bound(black_box(5))));
    black_box(spline.difference(other));
    for knot in spline.printed_knots() {
        black_box(knot);
    }
    for point in spline.controls_mut() {
        *point = black_box(*point);
    }
    spline.insert(black_box(0.5))
}

/// The thesis's algorithm, whole and in parts.
fn as_printed(spline: &mut Curve, start: &Curve) -> Result<(), SplineError> {
    let options = black_box(thesis::Options::new(0.1));
    let categories = black_box(thesis::categories(spline));
    black_box(thesis::directions(spline, start, black_box(&categories)));
    let mut sensitivities = black_box([1.0; 16]);
    let some = sensitivities.get_mut(..black_box(9)).unwrap_or_default();
    thesis::move_distances(some, black_box(1.0f32));
    black_box(sensitivities);
    black_box(thesis::smooth(spline, &options)?);
    Ok(())
}

/// The trajectory generator.
fn planned() {
    let trajectory = black_box(Trajectory::<f32>::thesis());
    let mut lows = Lows::default();
    let mut all = black_box([Low { way: 0.0, speed: 0.0, most: 0.0 }; 8]);
    for slot in &mut all {
        if let Some(low) = lows.push(black_box(1.0), trajectory.allowed(black_box(1.0))) {
            *slot = low;
        }
    }
    black_box(lows.finish());
    black_box(trajectory.plan(all.get_mut(..black_box(5)).unwrap_or_default()));
    let (from, to) = black_box((1.0, 2.0));
    black_box((trajectory.at(from, to, black_box(1.0)), trajectory.length(from, to)));
}

/// All of it.
pub fn all() -> Result<(), SplineError> {
    let mut spline = black_box(spline()?);
    let start = black_box(spline.clone());
    black_box(converted());
    told(&mut spline, &start)?;
    as_printed(&mut spline, &start)?;
    planned();
    let mut smoother = black_box(bounded::Smoother::<f32, 3, 20, 80>::new());
    smoother.smooth(&mut spline, &black_box(bounded::Options::new(0.1)))?;
    black_box(spline);
    Ok(())
}
