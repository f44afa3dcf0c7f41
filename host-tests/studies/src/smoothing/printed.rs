//! What Naseath 2007 prints of its cases, digit by digit.
//!
//! Percentages and means of the thesis were taken from more digits than it prints: they are given as printed, and not
//! computed again.

/// A table of chapter 4: a figure of every case, original and at the three radii, and by how much it is
/// better, per cent.
#[derive(Clone, Copy, Debug)]
pub struct Table {
    /// Number in the thesis.
    pub number: &'static str,
    /// What it holds, with its unit.
    pub name: &'static str,
    /// Digits after the point.
    pub digits: usize,
    /// By case: original, R = 0.025, 0.125, 0.25 mm.
    pub values: [[f64; 4]; 6],
    /// By case: R = 0.025, 0.125, 0.25 mm.
    pub improvement: [[f64; 3]; 6],
}

/// Table 4-1.
#[allow(clippy::unreadable_literal)] // as printed
pub const CURVATURE: Table = Table {
    number: "4-1",
    name: "average of curvature, 1/mm",
    digits: 6,
    values: [
        [0.040314, 0.040154, 0.039588, 0.038976],
        [0.14091, 0.140219, 0.137186, 0.133279],
        [0.564505, 0.557309, 0.53213, 0.510896],
        [0.296756, 0.295998, 0.292879, 0.288374],
        [0.093916, 0.08424, 0.04706, 0.005922],
        [0.175172, 0.168204, 0.143115, 0.131753],
    ],
    improvement: [
        [0.39, 1.80, 3.32],
        [0.49, 2.64, 5.42],
        [1.27, 5.74, 9.50],
        [0.26, 1.31, 2.82],
        [10.30, 49.89, 93.69],
        [3.98, 18.30, 24.79],
    ],
};

/// Table 4-2.
pub const FEED: Table = Table {
    number: "4-2",
    name: "average of feed, mm/s",
    digits: 1,
    values: [
        [195.0, 195.1, 195.4, 195.4],
        [180.8, 180.9, 181.1, 186.2],
        [52.3, 52.4, 53.8, 54.8],
        [71.4, 72.6, 72.9, 73.0],
        [73.1, 74.9, 91.9, 299.5],
        [58.2, 59.5, 65.6, 71.6],
    ],
    improvement: [
        [0.07, 0.22, 0.21],
        [0.03, 0.14, 3.00],
        [0.26, 2.93, 4.84],
        [1.63, 2.01, 2.17],
        [2.45, 25.74, 309.58],
        [2.29, 12.79, 23.01],
    ],
};

/// Table 4-3.
pub const LENGTH: Table = Table {
    number: "4-3",
    name: "length, mm",
    digits: 3,
    values: [
        [766.089, 765.773, 764.601, 763.681],
        [376.394, 376.158, 375.179, 373.853],
        [209.649, 208.522, 203.649, 198.750],
        [66.292, 66.051, 65.092, 63.817],
        [100.444, 100.383, 100.157, 100.017],
        [123.277, 123.200, 122.914, 122.263],
    ],
    improvement: [
        [0.04, 0.19, 0.31],
        [0.06, 0.32, 0.68],
        [0.54, 2.86, 5.20],
        [0.36, 1.81, 3.73],
        [0.06, 0.29, 0.43],
        [0.06, 0.29, 0.82],
    ],
};

/// By how much case 6 would have to be shorter, per cent, for tables 4-6 and 4-7 to follow from table
/// 4-3: see [`super::correlation`].
pub const LENGTH_OF_CASE_6: [f64; 3] = [0.113, 0.634, 1.239];

/// Table 4-4.
pub const TIME: Table = Table {
    number: "4-4",
    name: "machining time, s",
    digits: 3,
    values: [
        [3.810, 3.806, 3.790, 3.769],
        [2.199, 2.197, 2.186, 2.147],
        [4.042, 4.009, 3.849, 3.695],
        [0.943, 0.940, 0.921, 0.895],
        [1.341, 1.304, 1.065, 0.334],
        [1.970, 1.922, 1.757, 1.647],
    ],
    improvement: [
        [0.11, 0.54, 1.09],
        [0.11, 0.59, 2.39],
        [0.83, 4.78, 8.60],
        [0.36, 2.37, 5.14],
        [2.76, 20.58, 75.09],
        [2.45, 10.83, 16.43],
    ],
};

/// Table 4-5: calculation times on the computer of its day, s.
pub const CALCULATION: [[f64; 3]; 6] = [
    [1.636, 1.661, 1.514],
    [0.076, 0.085, 0.090],
    [0.800, 0.969, 0.779],
    [0.101, 0.101, 0.113],
    [0.231, 0.339, 0.851],
    [0.237, 0.160, 0.741],
];

/// The four figures that tables 4-6 and 4-7 are about.
pub const NAMES: [&str; 4] = ["length", "curvature", "feed", "time"];

/// Table 4-6, per cent, in the order of [`NAMES`]: each over all and at the three radii.
pub const MEANS: [[f64; 4]; 4] = [
    [1.05, 0.20, 1.02, 1.93],
    [13.11, 2.78, 13.28, 23.26],
    [21.85, 1.12, 7.31, 57.13],
    [8.61, 1.10, 6.61, 18.12],
];

/// A row of table 4-7: correlation of two improvements over all cases and radii, and its P-value.
#[derive(Clone, Copy, Debug)]
pub struct Correlation {
    /// Which two, of length, curvature, feed and time (in the order of [`NAMES`]).
    pub pair: [usize; 2],
    /// The figure of the thesis that shows it.
    pub figure: Option<&'static str>,
    /// Pearson's coefficient.
    pub coefficient: f64,
    /// Its P-value.
    pub probability: f64,
}

const fn correlation(
    pair: [usize; 2],
    figure: Option<&'static str>,
    coefficient: f64,
    probability: f64,
) -> Correlation {
    Correlation { pair, figure, coefficient, probability }
}

/// Table 4-7.
pub const CORRELATIONS: [Correlation; 6] = [
    correlation([1, 3], Some("4-30"), 0.9680, 0.0000),
    correlation([0, 3], Some("4-31"), -0.0280, 0.9110),
    correlation([0, 1], None, -0.1110, 0.6620),
    correlation([2, 3], Some("4-29"), 0.9720, 0.0000),
    correlation([2, 1], Some("4-28"), 0.9010, 0.0000),
    correlation([2, 0], None, -0.1050, 0.6770),
];
