//! Speed laws between two speeds, in closed form.

/// Limits along a leg: mm/s2 and mm/s3. An infinite jerk makes a trapezoid.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Greatest acceleration.
    pub acceleration: f64,
    /// Greatest jerk.
    pub jerk: f64,
}

/// Time of a change of speed that starts and ends with acceleration 0, s.
pub fn change_time(from: f64, to: f64, limit: Limit) -> f64 {
    let (gain, Limit { acceleration, jerk }) = ((to - from).abs(), limit);
    if gain * jerk >= acceleration * acceleration {
        gain / acceleration + acceleration / jerk
    } else {
        2.0 * (gain / jerk).sqrt()
    }
}

/// Length of that change, mm: it is symmetric in time.
pub fn change_length(from: f64, to: f64, limit: Limit) -> f64 {
    f64::midpoint(from, to) * change_time(from, to, limit)
}

/// Greatest speed, at most `most`, that can be changed to or from `other` over a length.
pub fn reachable(other: f64, length: f64, most: f64, limit: Limit) -> f64 {
    if other >= most || change_length(other, most, limit) <= length {
        return most;
    }
    let (mut low, mut high) = (other, most);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if change_length(other, middle, limit) <= length {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// A leg from one speed to another over a peak: seven phases (three if jerk is infinite).
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    from: f64,
    peak: f64,
    to: f64,
    length: f64,
    limit: Limit,
}

impl Leg {
    /// The fastest motion over a length with these end speeds, which must be possible.
    pub fn new(from: f64, to: f64, length: f64, most: f64, limit: Limit) -> Self {
        let fits =
            |peak: f64| change_length(from, peak, limit) + change_length(peak, to, limit) <= length;
        let (mut low, mut high) = (from.max(to), most.max(from).max(to));
        if fits(high) {
            low = high;
        }
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if fits(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self { from, peak: low, to, length, limit }
    }

    /// Its duration, s.
    pub fn time(&self) -> f64 {
        let Self { from, peak, to, length, limit } = *self;
        let (up, down) = (change_length(from, peak, limit), change_length(peak, to, limit));
        let steady = (length - up - down).max(0.0);
        let steady = if peak > 0.0 { steady / peak } else { 0.0 };
        change_time(from, peak, limit) + steady + change_time(peak, to, limit)
    }

    /// Points (way, speed) of a plot.
    pub fn plot(&self, start: f64) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        let up = |from: f64, to: f64, at: f64, points: &mut Vec<(f64, f64)>| {
            let time = change_time(from, to, self.limit);
            let (mut way, mut before) = (at, from);
            points.push((at, from));
            for k in 1..=12 {
                // The S of the speed: two parabolas, a straight line between if there is room.
                let u = f64::from(k) / 12.0;
                let rise = if self.limit.jerk.is_finite() { u * u * (3.0 - 2.0 * u) } else { u };
                let speed = from + (to - from) * rise;
                way += f64::midpoint(before, speed) * time / 12.0;
                before = speed;
                points.push((way, speed));
            }
        };
        up(self.from, self.peak, start, &mut points);
        let last = start + self.length - change_length(self.peak, self.to, self.limit);
        up(self.peak, self.to, last, &mut points);
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Limit = Limit { acceleration: 2000.0, jerk: 50_000.0 };

    /// From rest to rest: 1 mm is all jerk, 4 (L / 2 J)^(1/3); over 10 mm acceleration binds as well,
    /// L = v (v / A + A / J).
    #[test]
    fn legs_from_rest_to_rest() {
        let short = Leg::new(0.0, 0.0, 1.0, 200.0, LIMIT);
        assert!((short.time() - 4.0 * (1.0f64 / 100_000.0).cbrt()).abs() < 1e-9);
        let long = Leg::new(0.0, 0.0, 10.0, 200.0, LIMIT);
        let speed = (-0.04 + (0.0016f64 + 4.0 * 10.0 / 2000.0).sqrt()) * 1000.0;
        assert!((long.time() - 2.0 * (speed / 2000.0 + 0.04)).abs() < 1e-9);
    }

    #[test]
    fn a_trapezoid_is_the_limit_of_infinite_jerk() {
        let limit = Limit { jerk: f64::INFINITY, ..LIMIT };
        let leg = Leg::new(0.0, 0.0, 100.0, 200.0, limit);
        assert!((leg.time() - (100.0 / 200.0 + 200.0 / 2000.0)).abs() < 1e-9);
        assert!((reachable(0.0, 10.0, 1e6, limit) - (2.0f64 * 2000.0 * 10.0).sqrt()).abs() < 1e-6);
    }
}
