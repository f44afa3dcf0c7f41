//! The paths of the paper, with transitions worked out by another program from the paper's text alone:
//! `host-tests/data/vectors/guo_2023.txt`, whose head says what its lines are.

use super::routines::{Point, Rule};

const FILE: &str = include_str!("../../../data/vectors/guo_2023.txt");

/// A transition as the other program has it.
#[derive(Clone, Debug)]
pub struct Vector {
    /// Which rule gave the edge.
    pub rule: Rule,
    /// Half the angle between the legs, rad.
    pub theta: f64,
    /// L, mm.
    pub edge: f64,
    /// |P2 - C(.5)|, mm.
    pub e: f64,
    /// Distance of C(.5) from the legs, mm.
    pub deviation: f64,
    /// Curvature there, 1/mm.
    pub curvature: f64,
    /// P0 to P4.
    pub controls: [Point; 5],
}

/// A path.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name.
    pub name: String,
    /// Half the width of the band, mm.
    pub delta: f64,
    /// Eq. 8.
    pub lambda: f64,
    /// Q0 to Qn.
    pub points: Vec<Point>,
    /// A transition for every inner point.
    pub vectors: Vec<Vector>,
}

/// All of them.
pub fn all() -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    for line in FILE.lines().filter(|line| !line.starts_with('#')) {
        let words: Vec<&str> = line.split_whitespace().collect();
        // Words that are no numbers are the kind, the name and the rule.
        let values: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
        let point = |k: usize| -> Point { std::array::from_fn(|i| values[k + i]) };
        match (words[0], cases.last_mut()) {
            ("point", Some(case)) => case.points.push(point(0)),
            ("corner", Some(case)) => case.vectors.push(Vector {
                rule: match words[1] {
                    "scaled" => Rule::Scaled,
                    "halved" => Rule::Halved,
                    _ => Rule::Whole,
                },
                theta: values[0].to_radians(),
                edge: values[1],
                e: values[2],
                deviation: values[3],
                curvature: values[4],
                controls: std::array::from_fn(|k| point(5 + 3 * k)),
            }),
            _ => cases.push(Case {
                name: words[1].to_owned(),
                delta: values[0],
                lambda: values[1],
                points: Vec::new(),
                vectors: Vec::new(),
            }),
        }
    }
    cases
}

/// One of them by its name, if it is there.
pub fn case(name: &str) -> Option<Case> {
    all().into_iter().find(|case| case.name == name)
}

#[cfg(test)]
mod tests {
    use super::super::routines::{Transition, distance, transitions};
    use super::*;

    /// What rounding may leave, mm.
    const ROUNDING: f64 = 1.0e-9;

    /// The routines here and there: rules, control points, and the closed forms of edge, distance and curvature.
    #[test]
    fn the_routines_are_as_printed() {
        let cases = all();
        assert_eq!(cases.len(), 7);
        for case in cases {
            let made = transitions(&case.points, case.delta, case.lambda);
            assert_eq!(made.len(), case.vectors.len());
            for (n, (own, vector)) in made.iter().zip(&case.vectors).enumerate() {
                let name = format!("{}, corner {}", case.name, n + 1);
                assert_eq!(own.rule, vector.rule, "{name}");
                for (p, q) in own.controls.iter().zip(&vector.controls) {
                    assert!(distance(p, q) < ROUNDING, "{name}: {p:?} and {q:?}");
                }
                for (a, b) in [
                    (own.edge(), vector.edge),
                    (own.e(), vector.e),
                    (own.edge() / 2.0 * vector.theta.cos(), vector.e),
                    (own.deviation(), vector.deviation),
                ] {
                    assert!((a - b).abs() < ROUNDING, "{name}: {a} and {b}");
                }
                for a in [own.apex_curvature(), own.curvature(0.5)] {
                    assert!((a / vector.curvature - 1.0).abs() < 1.0e-7, "{name}: {a}");
                }
            }
        }
    }

    /// Section 4.1: of the 79 corners of the butterfly 57 are scaled, 20 left and 2 halved; all are in the band.
    #[test]
    fn corners_of_the_butterfly() {
        let case = case("butterfly80").unwrap();
        let made = transitions(&case.points, case.delta, case.lambda);
        let count = |rule| made.iter().filter(|t| t.rule == rule).count();
        assert_eq!([Rule::Scaled, Rule::Whole, Rule::Halved].map(count), [57, 20, 2]);
        let most = made.iter().map(Transition::deviation).fold(0.0, f64::max);
        assert!((most - 0.04828).abs() < 1.0e-5 && most < case.delta, "{most}");
    }

    /// Curvature is zero where a transition meets its legs, and the same on either side of the shoulder: GC2 by its
    /// geometry, whatever equations 5 and 6 say.
    #[test]
    fn transitions_join_with_continuous_curvature() {
        for case in all() {
            for own in transitions(&case.points, case.delta, case.lambda) {
                let apex = own.curvature(0.5);
                assert!(own.curvature(0.0) < 1.0e-6 * apex && own.curvature(1.0) < 1.0e-6 * apex);
                assert!((own.curvature(0.5 - 1.0e-12) / apex - 1.0).abs() < 1.0e-6);
            }
        }
    }
}
