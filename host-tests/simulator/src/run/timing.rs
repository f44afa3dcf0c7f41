//! How long many calls took, in a room that does not grow with their number.

use std::time::Instant;

/// Parts of an octave: what is between is known to 1.6 %.
const PARTS: u32 = 64;
/// Octaves of a `u32`.
const OCTAVES: u32 = 32;

/// Durations of many calls, ns.
#[derive(Clone, Debug)]
pub struct Timing {
    count: u64,
    sum: f64,
    greatest: u32,
    /// How many there were, by octave and part of it.
    buckets: Vec<u64>,
}

impl Default for Timing {
    fn default() -> Self {
        let buckets = vec![0; (OCTAVES * PARTS) as usize];
        Self { count: 0, sum: 0.0, greatest: 0, buckets }
    }
}

/// The bucket of a duration.
fn bucket(ns: u32) -> usize {
    let octave = ns.max(1).ilog2();
    let above = u64::from(ns) - (u64::from(ns != 0) << octave);
    ((octave * PARTS) as usize + ((above * u64::from(PARTS)) >> octave) as usize)
        .min((OCTAVES * PARTS) as usize - 1)
}

/// The greatest duration of a bucket, ns.
fn greatest(bucket: usize) -> f64 {
    let (octave, part) = (bucket as u32 / PARTS, bucket as u32 % PARTS);
    f64::from(1u32 << octave) * (1.0 + f64::from(part + 1) / f64::from(PARTS))
}

impl Timing {
    /// What has passed since a moment.
    pub(super) fn add(&mut self, since: Instant) {
        self.take(u32::try_from(since.elapsed().as_nanos()).unwrap_or(u32::MAX));
    }

    fn take(&mut self, ns: u32) {
        self.count += 1;
        self.sum += f64::from(ns);
        self.greatest = self.greatest.max(ns);
        self.buckets[bucket(ns)] += 1;
    }

    /// Sum, ns.
    pub fn total(&self) -> f64 {
        self.sum
    }

    /// Mean, 99th percentile (at most 1.6 % more than it is) and maximum, ns.
    pub fn summary(&self) -> (f64, f64, f64) {
        if self.count == 0 {
            return (0.0, 0.0, 0.0);
        }
        let most = f64::from(self.greatest);
        let rank = (self.count - 1) * 99 / 100;
        let mut before = 0;
        let percentile = self.buckets.iter().position(|count| {
            before += count;
            before > rank
        });
        let percentile = percentile.map_or(most, |bucket| greatest(bucket).min(most));
        (self.sum / self.count as f64, percentile, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_percentile_is_near_the_true_one() {
        let mut timing = Timing::default();
        assert_eq!(timing.summary(), (0.0, 0.0, 0.0));
        (1..=1000).for_each(|k| timing.take(k * 100));
        let (mean, percentile, most) = timing.summary();
        assert!((mean - 50_050.0).abs() < 1e-6 && (most - 100_000.0).abs() < 1e-6);
        assert!((99_000.0..99_000.0 * 1.017).contains(&percentile), "{percentile}");
        for ns in [0, 1, 2, 3, 100, 65_535, 65_536, u32::MAX] {
            let top = greatest(bucket(ns));
            assert!(
                f64::from(ns) <= top && top <= f64::from(ns.max(1)) * (2.0 + 1e-9),
                "{ns}: {top}"
            );
        }
        timing.take(u32::MAX);
        assert!((timing.summary().2 - f64::from(u32::MAX)).abs() < 1.0);
    }
}
