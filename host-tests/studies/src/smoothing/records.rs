//! The figures of the thesis's tables 4-1 to 4-4 case by case, for programs to read: printed, and by both methods here.

use super::cases::RADII;
use super::comparison::{Comparison, MEASURES, METHODS};
use super::{Figures, Reading};
use serde::Serialize;
use std::collections::BTreeMap;

/// Names of the figures, in the order of [`MEASURES`].
const NAMES: [&str; 4] = ["length_mm", "curvature_average_per_mm", "feed_mm_s", "time_s"];

/// A case, as given or smoothed within a radius.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// Number of the case.
    pub case: usize,
    /// Its name.
    pub name: &'static str,
    /// Radius of the tube, mm; `None` for the path as given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Each figure: `printed`, and by method and reading of section 4.5.
    #[serde(flatten)]
    pub figures: BTreeMap<&'static str, BTreeMap<String, f64>>,
}

fn called(reading: Reading) -> &'static str {
    match reading {
        Reading::Free => "free",
        Reading::Middle => "middle",
        Reading::Edges => "edges",
    }
}

/// All of them.
pub fn records(comparison: &Comparison) -> Vec<Record> {
    let mut records = Vec::new();
    for (k, case) in comparison.cases.iter().enumerate() {
        for state in 0..=RADII.len() {
            let radius = state.checked_sub(1);
            let mut figures = BTreeMap::new();
            for (measure, name) in MEASURES.iter().zip(NAMES) {
                let printed = ("printed".to_owned(), measure.table.values[k][state]);
                let mut values = BTreeMap::from([printed]);
                for (m, method) in METHODS.iter().enumerate() {
                    for (r, reading) in comparison.readings.into_iter().enumerate() {
                        let of: &Figures =
                            radius.map_or(&case.given[r], |k| &case.runs[k][m].figures[r]);
                        let method = format!("{method:?}").to_lowercase();
                        let key = format!("{method}_{}", called(reading));
                        values.insert(key, (measure.value)(of));
                    }
                }
                figures.insert(name, values);
            }
            let radius_mm = radius.map(|k| RADII[k]);
            records.push(Record {
                case: case.case.number,
                name: case.case.name,
                radius_mm,
                figures,
            });
        }
    }
    records
}
