//! The filter of [`filtered`](super::filtered): two moving averages, and what they make of one block and of two.

use super::line_path::LinePath;

/// Places at which a corner is looked at, and halvings of the delay.
const PLACES: usize = 80;
const HALVINGS: usize = 30;

/// Both averages, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Filter {
    pub first: f64,
    pub second: f64,
}

impl Filter {
    /// For feeds up to `most`: the times that the limits of every line demand.
    pub fn new(path: &LinePath, Choice { feed: most, longer, .. }: Choice) -> Self {
        let cycles = |time: f64| (time / path.cycle - 1e-9).ceil().max(1.0) * path.cycle;
        let greatest = |of: &dyn Fn(usize) -> f64| (0..path.lines()).map(of).fold(0.0, f64::max);
        let feed = |line: usize| path.feeds[line].min(most);
        let product = greatest(&|line| feed(line) / path.limit(line).jerk);
        let by_acceleration = greatest(&|line| feed(line) / path.limit(line).acceleration);
        // With both averages alike the acceleration is the least that the jerk allows.
        let first = cycles(by_acceleration.max(product.sqrt()));
        Self { first, second: cycles(longer * product / first) }
    }

    pub fn whole(&self) -> f64 {
        self.first + self.second
    }

    /// Way of a pulse of height 1 that goes on, after a time.
    fn way(&self, time: f64) -> f64 {
        let cube = |t: f64| t.max(0.0).powi(3);
        let ends = cube(time) - cube(time - self.first) - cube(time - self.second)
            + cube(time - self.whole());
        ends / (6.0 * self.first * self.second)
    }

    /// How far two long blocks with a turn leave their lines if one begins so long after the other.
    fn corner(&self, feeds: [f64; 2], turn: f64, delay: f64) -> f64 {
        let (sine, cosine) = turn.sin_cos();
        let whole = self.whole();
        let end = whole.max(delay + whole);
        let off = |time: f64| {
            let left = feeds[0] * (whole / 2.0 - time + self.way(time)).max(0.0);
            let done = feeds[1] * self.way(time - delay);
            let ray = |behind: f64, ahead: f64| {
                let (along, beside) = (ahead * cosine - behind, ahead * sine);
                if along < 0.0 { beside.abs() } else { along.hypot(beside) }
            };
            ray(left, done).min(ray(done, left))
        };
        (0..=PLACES).map(|n| off(end * n as f64 / PLACES as f64)).fold(0.0, f64::max)
    }

    /// The shortest delay that keeps a band.
    pub fn delay(&self, feeds: [f64; 2], turn: f64, band: f64) -> f64 {
        if self.corner(feeds, turn, 0.0) <= band {
            return 0.0;
        }
        let (mut low, mut delay) = (0.0, self.whole());
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, delay);
            if self.corner(feeds, turn, middle) <= band { delay = middle } else { low = middle }
        }
        delay
    }
}

/// What a filter is made for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Greatest feed, mm/s.
    pub feed: f64,
    /// How much longer the second average is than the jerk of one block demands.
    pub longer: f64,
    /// Blocks whose pulses are longer than so many times the filter are long.
    pub long: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both motions are of constant jerk F / (T1 T2) while they overlap for a time o: at a right angle they are J o^3 / 48 off
    /// their lines when both have gone as far.
    #[test]
    fn a_short_overlap_leaves_the_lines_by_the_jerk() {
        let filter = Filter { first: 0.1, second: 0.04 };
        let overlap = 0.036f64;
        let off = filter.corner([200.0; 2], std::f64::consts::FRAC_PI_2, 0.14 - overlap);
        let exact = 200.0 / (0.1 * 0.04) * overlap.powi(3) / 48.0;
        assert!((off / exact - 1.0).abs() < 0.02, "{off} mm, not {exact}");
        let delay = filter.delay([200.0; 2], std::f64::consts::FRAC_PI_2, exact);
        assert!((delay - (0.14 - overlap)).abs() < 1e-3, "{delay} s");
    }
}
