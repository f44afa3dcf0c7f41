//! The test cases of Naseath 2007, and the ripples of its section 3.12.
//!
//! The pictures of the cases are lost, and no control point was printed. What stands for them are
//! *equivalents*: splines with the printed number of control points, found by a search so that the thesis's
//! method makes of them what the thesis prints (`host-tests/data/thesis`, where the head of each file says
//! how it was found). They say what the method does to paths with these figures; they do not
//! say what the paths looked like.

use super::figures::profile;
use anyhow::{Context, Result};
use splineway_simulator::spline::{Path, SplineFile};

/// A case of chapter 4.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its number.
    pub number: usize,
    /// Its name in the thesis.
    pub name: &'static str,
    /// The equivalent.
    pub path: Path,
}

/// Radii of the thesis, mm.
pub const RADII: [f64; 3] = [0.025, 0.125, 0.25];

/// Names and files of the cases.
const FILES: [(&str, &str); 6] = [
    ("simple", include_str!("../../../data/thesis/case1.txt")),
    ("medium", include_str!("../../../data/thesis/case2.txt")),
    ("complex", include_str!("../../../data/thesis/case3.txt")),
    ("snow tire", include_str!("../../../data/thesis/case4.txt")),
    ("line", include_str!("../../../data/thesis/case5.txt")),
    ("square", include_str!("../../../data/thesis/case6.txt")),
];

/// All six cases.
///
/// # Errors
/// None, unless the files themselves are wrong.
pub fn all() -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (k, (name, text)) in FILES.into_iter().enumerate() {
        let number = k + 1;
        let path = SplineFile::parse(text, "txt").and_then(|file| file.path());
        cases.push(Case { number, name, path: path.with_context(|| format!("case {number}"))? });
    }
    Ok(cases)
}

/// How eight ripples of growing curvature resemble each other. The thesis calls them similar and does
/// not print their sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// All of one height; the steps shrink.
    OneHeight,
    /// All of one shape; steps and height shrink.
    OneShape,
}

/// Height of a ripple's control point in a family of one height, mm.
const HEIGHT: f64 = 2.0;
/// Its height over the step in a family of one shape.
const SLOPE: f64 = 1.0;

impl Family {
    /// A single ripple: a straight control polygon in equal steps with one point off, such that the peak of
    /// curvature, 1/mm, is as wanted.
    ///
    /// # Errors
    /// None for peaks of [`ripple_peaks`].
    pub fn ripple(self, peak: f64) -> Result<Path> {
        let build = |step: f64| -> Result<Path> {
            let height = match self {
                Self::OneHeight => HEIGHT,
                Self::OneShape => SLOPE * step,
            };
            let points: Vec<[f64; 3]> = (0..21)
                .map(|k| [step * f64::from(k), if k == 10 { height } else { 0.0 }, 0.0])
                .collect();
            let knots: Vec<f64> = (0..19).map(f64::from).collect();
            Ok(Path::open(&points, &knots)?)
        };
        // The peak falls as the step grows.
        let (mut low, mut high) = (1.0e-3f64, 1.0e3f64);
        for _ in 0..60 {
            let middle = (low * high).sqrt();
            if greatest_curvature(&build(middle)?) > peak { low = middle } else { high = middle }
        }
        build((low * high).sqrt())
    }
}

fn greatest_curvature(path: &Path) -> f64 {
    profile(path).iter().map(|place| place.curvature).fold(0.0, f64::max)
}

/// Peaks of curvature of the eight ripples, 1/mm: from 1/15 to 8/3 (section 3.12), in equal ratios.
pub fn ripple_peaks() -> [f64; 8] {
    std::array::from_fn(|k| 40f64.powf(k as f64 / 7.0) / 15.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_have_the_printed_number_of_control_points() {
        let counts = [62, 14, 43, 11, 32, 28];
        for (case, count) in all().unwrap().iter().zip(counts) {
            assert_eq!(case.path.controls().len(), count, "case {}", case.number);
            assert!(case.path.controls().iter().all(|p| p[2] == 0.0), "case {}", case.number);
        }
    }

    /// Case 5 is what its text says: a natural spline through 30 points, two of them 0.2 mm off a straight line of
    /// 100 mm, and case 6 one through 26 points on a square wave.
    #[test]
    fn cases_5_and_6_interpolate_what_the_text_says() {
        let cases = all().unwrap();
        let through = |path: &Path| -> Vec<[f64; 3]> {
            let points: Vec<[f64; 3]> = path.knots().iter().map(|t| path.at(*t)).collect();
            let again = Path::through(&points, path.knots()).unwrap();
            for (p, q) in again.controls().iter().zip(path.controls()) {
                assert!(p.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-9), "{p:?} {q:?}");
            }
            points
        };
        let points = through(&cases[4].path);
        let off = points.iter().filter(|p| (p[1] - 0.2).abs() < 1e-9).count();
        let on = points.iter().filter(|p| p[1].abs() < 1e-9).count();
        assert!((points.len(), off, on) == (30, 2, 28), "{points:?}");
        assert!((points[29][0] - 100.0).abs() < 1e-9);
        let points = through(&cases[5].path);
        assert_eq!(points.len(), 26);
        let along = |k: usize| [0, 1].map(|i| (points[k + 1][i] - points[k][i]).abs() > 1e-9);
        let legs: Vec<[bool; 2]> = (0..25).map(along).collect();
        assert!(legs.iter().all(|leg| leg[0] != leg[1]), "{points:?}");
        assert_eq!(legs.windows(2).filter(|pair| pair[0] != pair[1]).count(), 8);
    }

    #[test]
    fn ripples_have_the_wanted_peaks() {
        for family in [Family::OneHeight, Family::OneShape] {
            for wanted in ripple_peaks() {
                let peak = greatest_curvature(&family.ripple(wanted).unwrap());
                assert!((peak / wanted - 1.0).abs() < 1e-9, "{family:?} {wanted}: {peak}");
            }
        }
    }
}
