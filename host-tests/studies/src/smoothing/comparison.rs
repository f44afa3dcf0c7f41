//! The cases of Naseath 2007 smoothed as printed and in bounded sweeps, and what of the printed figures comes
//! out.

use super::cases::{Case, RADII, all};
use super::correlation::{pearson, probability};
use super::printed::{CORRELATIONS, CURVATURE, FEED, LENGTH, MEANS, TIME, Table};
use super::{Figures, Method, Reading, Request, Smoothed, measure, smooth};
use anyhow::Result;
use splineway_simulator::spline::Path;
use splineway_splines::Trajectory;

/// The methods that are compared: the thesis's and the bounded one.
pub const METHODS: [Method; 2] = [Method::Thesis, Method::Bounded];

/// Shares of a printed figure within which others are counted.
pub const WITHIN: [f64; 3] = [0.02, 0.10, 0.25];

/// How often every case is smoothed: of the times the least is kept, which other programs have disturbed least.
const RUNS: usize = 10;

/// Figures by the two readings of section 4.5.
pub type Both = [Figures; 2];

/// A case smoothed by one method within one radius.
#[derive(Clone, Debug)]
pub struct Run {
    /// Of the smoothed path.
    pub figures: Both,
    /// The path and how it came about.
    pub smoothed: Smoothed,
    /// How far it is from the path as given, at equal parameter, over the radius (200 places per
    /// span).
    pub off: f64,
}

/// A case, as given and smoothed.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The case.
    pub case: Case,
    /// As given.
    pub given: Both,
    /// By radius and method.
    pub runs: Vec<Vec<Run>>,
}

/// All cases, as given and smoothed.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// How section 4.5 is read.
    pub readings: [Reading; 2],
    /// By case.
    pub cases: Vec<Compared>,
}

fn both(path: &Path, readings: [Reading; 2]) -> Both {
    readings.map(|reading| measure(path, &Trajectory::thesis(), reading))
}

/// By how much `to` is less than `from`, per cent.
pub fn saved(from: f64, to: f64) -> f64 {
    (from - to) / from * 100.0
}

/// A figure of the four that the thesis tabulates: length, curvature, feed and time, in the order of
/// [`MEANS`].
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// What the thesis prints.
    pub table: Table,
    /// The same here.
    pub value: fn(&Figures) -> f64,
    /// Whether more is better.
    pub rises: bool,
    /// Whether it depends on how section 4.5 is read.
    pub timed: bool,
}

/// The four, in the order of [`MEANS`].
pub const MEASURES: [Measure; 4] = [
    Measure { table: LENGTH, value: |f| f.length_mm, rises: false, timed: false },
    Measure { table: CURVATURE, value: |f| f.curvature_average, rises: false, timed: false },
    Measure { table: FEED, value: |f| f.feed_by_parameter, rises: true, timed: true },
    Measure { table: TIME, value: |f| f.time_s, rises: false, timed: true },
];

impl Measure {
    /// By how much a figure is better, per cent.
    pub fn improvement(&self, given: &Figures, smoothed: &Figures) -> f64 {
        let less = saved((self.value)(given), (self.value)(smoothed));
        if self.rises { -less } else { less }
    }
}

/// Counts figures that are near printed ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// All that were compared.
    pub all: usize,
    /// Those within the shares of [`WITHIN`].
    pub within: [usize; 3],
}

impl Tally {
    /// Takes a figure; one that is the printed one when rounded to its digits is within all shares.
    pub fn take(&mut self, printed: f64, digits: usize, here: f64) {
        self.all += 1;
        let off = (here - printed).abs();
        let rounding = 0.5 / 10f64.powf(digits as f64) * (1.0 + 1e-9);
        for (count, share) in self.within.iter_mut().zip(WITHIN) {
            *count += usize::from(off <= rounding || off <= share * printed.abs());
        }
    }
}

impl Comparison {
    /// Smooths all cases; section 4.5 is read in both ways.
    ///
    /// # Errors
    /// None, unless the cases themselves are wrong.
    pub fn new(readings: [Reading; 2]) -> Result<Self> {
        let run = |path: &Path, radius: f64, method: Method| -> Result<Run> {
            let request = Request::new(method, radius);
            let mut smoothed = smooth(path, &request)?;
            for _ in 1..RUNS {
                smoothed.took = smoothed.took.min(smooth(path, &request)?.took);
            }
            let off = smoothed.path.difference(path).map_or(0.0, |d| d.greatest(200)) / radius;
            Ok(Run { figures: both(&smoothed.path, readings), smoothed, off })
        };
        let mut cases = Vec::new();
        for case in all()? {
            let by_method = |radius: f64| -> Result<Vec<Run>> {
                METHODS.into_iter().map(|method| run(&case.path, radius, method)).collect()
            };
            let runs = RADII.into_iter().map(by_method).collect::<Result<_>>()?;
            cases.push(Compared { given: both(&case.path, readings), case, runs });
        }
        Ok(Self { readings, cases })
    }

    /// Improvements of a measure over all cases and radii, per cent, by a method and a reading.
    pub fn improvements(&self, measure: &Measure, method: usize, reading: usize) -> Vec<[f64; 3]> {
        let of = |case: &Compared| -> [f64; 3] {
            std::array::from_fn(|k| {
                let run = &case.runs[k][method];
                measure.improvement(&case.given[reading], &run.figures[reading])
            })
        };
        self.cases.iter().map(of).collect()
    }

    /// A row of table 4-6, per cent: over all, and at the three radii.
    pub fn means(&self, measure: &Measure, method: usize, reading: usize) -> [f64; 4] {
        let rows = self.improvements(measure, method, reading);
        let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / rows.len() as f64;
        let radii = [mean(0), mean(1), mean(2)];
        [radii.iter().sum::<f64>() / 3.0, radii[0], radii[1], radii[2]]
    }

    /// Correlation of two measures, of [`MEASURES`], over all cases and radii, and its P-value.
    pub fn correlation(&self, pair: [usize; 2], method: usize, reading: usize) -> (f64, f64) {
        let series =
            pair.map(|k| self.improvements(&MEASURES[k], method, reading).as_flattened().to_vec());
        let coefficient = pearson(&series[0], &series[1]);
        (coefficient, probability(coefficient, series[0].len()))
    }

    /// How many of the printed figures of tables 4-1 to 4-4, 4-6 and 4-7 the thesis's method gives here.
    pub fn tally(&self, reading: usize) -> Tally {
        let mut tally = Tally::default();
        for measure in &MEASURES {
            let table = &measure.table;
            let improvements = self.improvements(measure, 0, reading);
            for (k, case) in self.cases.iter().enumerate() {
                let smoothed = case.runs.iter().map(|run| run[0].figures[reading]);
                let states = std::iter::once(case.given[reading]).chain(smoothed);
                for (printed, figures) in table.values[k].into_iter().zip(states) {
                    tally.take(printed, table.digits, (measure.value)(&figures));
                }
                for (printed, here) in table.improvement[k].into_iter().zip(improvements[k]) {
                    tally.take(printed, 2, here);
                }
            }
        }
        for (measure, printed) in MEASURES.iter().zip(MEANS) {
            for (printed, here) in printed.into_iter().zip(self.means(measure, 0, reading)) {
                tally.take(printed, 2, here);
            }
        }
        for printed in CORRELATIONS {
            let (coefficient, probability) = self.correlation(printed.pair, 0, reading);
            tally.take(printed.coefficient, 4, coefficient);
            tally.take(printed.probability, 4, probability);
        }
        tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_counted_by_their_distance() {
        let mut tally = Tally::default();
        for (printed, digits, here) in
            [(100.0, 0, 101.9), (100.0, 1, 109.0), (100.0, 1, 76.0), (100.0, 1, 74.0)]
        {
            tally.take(printed, digits, here);
        }
        assert_eq!(tally, Tally { all: 4, within: [1, 2, 3] });
        // 0.03 printed is anything that rounds to it, and 0.0000 is.
        tally.take(0.03, 2, 0.0349);
        tally.take(0.0, 4, 0.00004);
        assert_eq!(tally, Tally { all: 6, within: [3, 4, 5] });
    }
}
