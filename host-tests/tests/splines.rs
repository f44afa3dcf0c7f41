//! Splines smoothed inside their tube: random ones, and the cases of the thesis.

mod common;

use common::config;
use proptest::prelude::*;
use splineway_simulator::spline::Path;
use splineway_splines::{Spline, Trajectory, bounded, thesis};
use splineway_studies::smoothing::cases::{Family, RADII, all, ripple_peaks};
use splineway_studies::smoothing::{Method, Reading, Request, measure, smooth};

type Random = Spline<f64, 3, 61>;
type Narrow = Spline<f32, 3, 61>;

/// Control points and knot intervals; intervals over `decades` orders of magnitude.
fn polygon(decades: f64) -> impl Strategy<Value = Vec<([f64; 3], f64)>> {
    let step = prop::array::uniform3(-1.0f64..1.0);
    let size = (-2.0f64..1.5).prop_map(|e| 10f64.powf(e));
    let interval = (-decades / 2.0..=decades / 2.0).prop_map(|e| 10f64.powf(e));
    prop::collection::vec((step, size, interval), 5..40).prop_map(|steps| {
        let mut here = [0.0; 3];
        steps
            .into_iter()
            .map(|(step, size, interval)| {
                for (x, dx) in here.iter_mut().zip(step) {
                    *x += dx * size;
                }
                (here, interval)
            })
            .collect()
    })
}

fn spline(polygon: &[([f64; 3], f64)], closed: bool, flat: bool) -> Random {
    let points: Vec<[f64; 3]> =
        polygon.iter().map(|(p, _)| if flat { [p[0], p[1], 0.0] } else { *p }).collect();
    let intervals: Vec<f64> = polygon.iter().map(|(_, interval)| *interval).collect();
    if closed {
        return Random::closed(&points, &intervals).unwrap();
    }
    let mut knots = vec![0.0];
    for interval in &intervals[..points.len() - 3] {
        knots.push(knots[knots.len() - 1] + interval);
    }
    Random::open(&points, &knots).unwrap()
}

fn inside(path: &Random, given: &Random, radius: f64) -> Result<(), TestCaseError> {
    let off = path.difference(given).unwrap();
    prop_assert!(off.controls().iter().flatten().all(|x| x.is_finite()));
    let dense = off.greatest(100);
    prop_assert!(dense <= radius, "{dense} of {radius}");
    Ok(())
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn no_spline_leaves_its_tube(
        polygon in polygon(3.0),
        radius in (-3.0f64..0.5).prop_map(|e| 10f64.powf(e)),
        (closed, flat, ends_stay) in (any::<bool>(), any::<bool>(), any::<bool>()),
        (sweeps, passes) in (0u16..10, 0u16..4),
    ) {
        let given = spline(&polygon, closed, flat);
        let mut path = given.clone();
        let mut room: Box<bounded::Smoother<f64, 3, 64, 256>> = Box::default();
        let options =
            bounded::Options { sweeps, passes, ends_stay, ..bounded::Options::new(radius) };
        room.smooth(&mut path, &options).unwrap();
        inside(&path, &given, radius)?;
        if ends_stay && !closed {
            let last = given.controls().len() - 1;
            for end in [0, last] {
                let bits = |p: &Random| p.controls()[end].map(f64::to_bits);
                prop_assert_eq!(bits(&path), bits(&given));
            }
        }
    }

    /// The thesis's moves with bounded distances; sampled, they may be out between the samples.
    #[test]
    fn bounded_moves_stay_inside(
        polygon in polygon(3.0),
        radius in (-3.0f64..0.5).prop_map(|e| 10f64.powf(e)),
        (closed, flat) in (any::<bool>(), any::<bool>()),
        precision in 1u32..12,
    ) {
        let given = spline(&polygon, closed, flat);
        let mut path = given.clone();
        let options = thesis::Options {
            precision, most_iterations: 100, bounded: true, ..thesis::Options::new(radius)
        };
        thesis::smooth(&mut path, &options).unwrap();
        inside(&path, &given, radius)?;
        let mut sampled = given.clone();
        let options = thesis::Options { bounded: false, ..options };
        thesis::smooth(&mut sampled, &options).unwrap();
        let off = sampled.difference(&given).unwrap().greatest(precision);
        prop_assert!(off <= radius, "{off} of {radius}");
    }

    /// In single precision the tube is kept but for rounding.
    #[test]
    fn single_precision_keeps_the_tube(
        polygon in polygon(1.5),
        radius in (-2.0f64..0.5).prop_map(|e| 10f64.powf(e)),
    ) {
        let given = spline(&polygon, false, false);
        let points: Vec<[f32; 3]> =
            given.controls().iter().map(|p| p.map(|x| x as f32)).collect();
        let knots: Vec<f32> = given.knots().iter().map(|t| *t as f32).collect();
        let mut path = Narrow::open(&points, &knots).unwrap();
        let narrow = path.clone();
        let mut room: Box<bounded::Smoother<f32, 3, 64, 256>> = Box::default();
        room.smooth(&mut path, &bounded::Options::new(radius as f32)).unwrap();
        let off = f64::from(path.difference(&narrow).unwrap().greatest(100));
        let extent = points.iter().flatten().fold(0.0f32, |most, x| most.max(x.abs()));
        prop_assert!(off <= radius + 1e-6 * f64::from(extent), "{off} of {radius}");
    }
}

/// The share of the time saved, and the greatest distance over the radius.
fn time_saved(path: &Path, method: Method, radius: f64) -> (f64, f64) {
    let trajectory = Trajectory::thesis();
    let smoothed = smooth(path, &Request::new(method, radius)).unwrap();
    let off = smoothed.path.difference(path).unwrap();
    if method == Method::Bounded {
        assert!(off.bound(200) <= radius * (1.0 + 1e-9), "{} of {radius}", off.bound(200));
    }
    let time = |path: &Path| measure(path, &trajectory, Reading::Free).time_s;
    (1.0 - time(&smoothed.path) / time(path), off.greatest(200) / radius)
}

/// The bounded method saves at least as much time as the thesis's on every case and ripple, but for
/// a ten-thousandth; where the thesis's samples miss that it leaves the tube, as much less as it is outside.
#[test]
fn bounded_saves_as_much_as_the_thesis_on_every_case() {
    let mut paths: Vec<(String, Path)> =
        all().unwrap().into_iter().map(|case| (case.name.to_owned(), case.path)).collect();
    for family in [Family::OneHeight, Family::OneShape] {
        for peak in ripple_peaks() {
            paths.push((format!("ripple {peak:.3}, {family:?}"), family.ripple(peak).unwrap()));
        }
    }
    for (name, path) in &paths {
        for radius in RADII {
            let [(printed, off), (own, _)] =
                [Method::Thesis, Method::Bounded].map(|method| time_saved(path, method, radius));
            let inside = printed / off.max(1.0).powi(2);
            assert!(own > inside - 1.2e-4, "{name}, {radius}: {own} {printed}, {off}");
        }
    }
}
