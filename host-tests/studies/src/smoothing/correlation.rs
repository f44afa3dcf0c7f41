//! Pearson's correlation, as in table 4-7 of Naseath 2007.

/// Pearson's coefficient of two series of equal length; not a number if one of them does not vary.
pub fn pearson(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len()) as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let sum = |f: fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(x, y)| f(x - mean_a, y - mean_b)).sum()
    };
    sum(|x, y| x * y) / (sum(|x, _| x * x) * sum(|_, y| y * y)).sqrt()
}

/// The probability that two series of `count` values that have nothing to do with each other correlate at
/// least as much (two-sided, by Student's t; Abramowitz and Stegun, equations 26.7.3 and 26.7.4). `count`
/// is at least 3.
pub fn probability(coefficient: f64, count: usize) -> f64 {
    // With t = r sqrt(n / (1 - r^2)) the angle there has the sine r.
    let freedom = count - 2;
    let sine = coefficient.abs().min(1.0);
    let square = 1.0 - sine * sine;
    let odd = freedom % 2 == 1;
    // Products of (k - 1) / k cos^2, from the first term on.
    let (mut term, mut sum, mut k) = if odd { (square.sqrt(), 0.0, 1) } else { (1.0, 0.0, 0) };
    while k < freedom {
        sum += term;
        k += 2;
        term *= square * (k as f64 - 1.0) / k as f64;
    }
    let within =
        if odd { (sine.asin() + sine * sum) * std::f64::consts::FRAC_2_PI } else { sine * sum };
    1.0 - within
}

#[cfg(test)]
mod tests {
    use super::super::printed::{
        CORRELATIONS, CURVATURE, FEED, LENGTH, LENGTH_OF_CASE_6, MEANS, TIME,
    };
    use super::*;

    /// Table A10 of any statistics: 5 % at these coefficients.
    #[test]
    fn probabilities_are_those_of_tables() {
        for (count, coefficient) in [(4, 0.950), (5, 0.8783), (10, 0.6319), (18, 0.4683)] {
            let p = probability(coefficient, count);
            assert!((p - 0.05).abs() < 1e-4, "{count}: {p}");
        }
        assert!(probability(1.0, 18).abs() < 1e-15 && (probability(0.0, 17) - 1.0).abs() < 1e-15);
    }

    fn flat(rows: [[f64; 3]; 6]) -> Vec<f64> {
        rows.concat()
    }

    /// Tables 4-6 and 4-7 follow from the printed percentages, but for case 6's lengths in table 4-3:
    /// with those of [`LENGTH_OF_CASE_6`] all six coefficients and all means do.
    #[test]
    fn lengths_of_case_6_are_misprinted() {
        let mut repaired = LENGTH.improvement;
        repaired[5] = LENGTH_OF_CASE_6;
        let misses = |length: [[f64; 3]; 6]| -> usize {
            let series = [length, CURVATURE.improvement, FEED.improvement, TIME.improvement];
            let off = |wrong: bool| usize::from(wrong);
            let mut misses = 0;
            for printed in CORRELATIONS {
                let [a, b] = printed.pair.map(|k| flat(series[k]));
                let r = pearson(&a, &b);
                misses += off((r - printed.coefficient).abs() > 0.002);
                misses += off((probability(r, 18) - printed.probability).abs() > 0.005);
            }
            for (rows, printed) in series.iter().zip(MEANS) {
                let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / 6.0;
                let all = (mean(0) + mean(1) + mean(2)) / 3.0;
                for (value, printed) in [all, mean(0), mean(1), mean(2)].into_iter().zip(printed) {
                    misses += off((value - printed).abs() > 0.0101);
                }
            }
            misses
        };
        assert_eq!(misses(repaired), 0);
        assert!(misses(LENGTH.improvement) >= 10, "{}", misses(LENGTH.improvement));
    }
}
