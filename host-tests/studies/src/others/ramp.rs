//! The seven phases of constant jerk between two states of speed and acceleration.

use splineway_simulator::scurve::Limit;

/// Speed and acceleration at an end of a leg, mm/s and mm/s2.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct End {
    /// Speed.
    pub speed: f64,
    /// What the speed rises by when one goes into the leg from this end: at its start that is the acceleration, at its end the
    /// deceleration. At least 0.
    pub rise: f64,
}

/// Phases: duration, s, and jerk, mm/s3.
pub type Phases = [(f64, f64); 7];

/// From an end up to a peak, where the acceleration is 0: three phases and their length.
#[derive(Clone, Copy, Debug)]
struct Climb {
    times: [f64; 3],
    length: f64,
}

impl Climb {
    fn new(end: End, peak: f64, limit: Limit) -> Self {
        let Limit { acceleration, jerk } = limit;
        let End { speed, rise } = end;
        // Without a phase of constant acceleration: the squares of both accelerations over 2 J are the gains of speed.
        let square = jerk * (peak - speed) + rise * rise / 2.0;
        let most = square.max(0.0).sqrt().max(rise).min(acceleration);
        let gain = |a: f64| a * a / (2.0 * jerk);
        let rest = peak - speed - (gain(most) - gain(rise)) - gain(most);
        let steady = if most > 0.0 { (rest / most).max(0.0) } else { 0.0 };
        let times = [(most - rise) / jerk, steady, most / jerk];
        let (mut length, mut v, mut a) = (0.0, speed, rise);
        for (t, j) in times.into_iter().zip([jerk, 0.0, -jerk]) {
            length += t * (v + t * (a / 2.0 + t * j / 6.0));
            v += t * (a + t * j / 2.0);
            a += t * j;
        }
        Self { times, length }
    }
}

/// The least-time phases over a length (mm) from one end to the other at no more than a speed, of those that speed up and then
/// slow down; `None` if the length is too short for it. Both ends' accelerations must be within the limit. The cost is a
/// bisection.
///
/// Source: the closed forms are those of any constant-jerk profile, as in Berscheid and Kröger, "Jerk-limited real-time trajectory
/// generation with arbitrary target states" (2021), profile "UDDU", with the speed of the peak as the unknown.
pub fn leg(ends: [End; 2], length: f64, most: f64, limit: Limit) -> Option<Phases> {
    // The least peak: where an end's acceleration is let go at once.
    let least = |end: End| end.speed + end.rise * end.rise / (2.0 * limit.jerk);
    let climbs = |peak: f64| ends.map(|end| Climb::new(end, peak, limit));
    let sum = |climbs: &[Climb; 2]| climbs[0].length + climbs[1].length;
    let low = least(ends[0]).max(least(ends[1]));
    if low > most * (1.0 + 1e-12) || sum(&climbs(low)) > length + 1e-9 {
        return None;
    }
    let (mut peak, mut high) = (low, most);
    if sum(&climbs(most)) <= length {
        peak = most;
    } else {
        for _ in 0..48 {
            let middle = f64::midpoint(peak, high);
            if sum(&climbs(middle)) <= length { peak = middle } else { high = middle }
        }
    }
    let found = climbs(peak);
    let rest = (length - sum(&found)).max(0.0);
    let cruise = if peak > 1e-9 { rest / peak } else { 0.0 };
    let [[u1, u2, u3], [d1, d2, d3]] = found.map(|climb| climb.times);
    let j = limit.jerk;
    Some([(u1, j), (u2, 0.0), (u3, -j), (cruise, 0.0), (d3, -j), (d2, 0.0), (d1, j)])
}

/// Duration of some phases, s.
pub fn duration(phases: &Phases) -> f64 {
    phases.iter().map(|(time, _)| time).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway_simulator::scurve;

    const LIMIT: Limit = Limit { acceleration: 2000.0, jerk: 50_000.0 };

    /// What phases lead to: way, speed, acceleration.
    fn run(start: End, phases: &Phases) -> [f64; 3] {
        let (mut x, mut v, mut a) = (0.0, start.speed, start.rise);
        for &(t, j) in phases {
            x += t * (v + t * (a / 2.0 + t * j / 6.0));
            v += t * (a + t * j / 2.0);
            a += t * j;
        }
        [x, v, a]
    }

    #[test]
    fn from_rest_to_rest_it_is_the_s_curve() {
        for length in [0.01, 1.0, 10.0, 100.0] {
            let phases = leg([End::default(); 2], length, 200.0, LIMIT).unwrap();
            let known = scurve::Leg::new(0.0, 0.0, length, 200.0, LIMIT).time();
            assert!((duration(&phases) - known).abs() < 1e-6, "{length}");
        }
    }

    #[test]
    fn both_ends_are_met() {
        let ends = [End { speed: 30.0, rise: 1800.0 }, End { speed: 12.0, rise: 700.0 }];
        for length in [5.0, 10.0, 60.0] {
            let phases = leg(ends, length, 200.0, LIMIT).unwrap();
            let [x, v, a] = run(ends[0], &phases);
            assert!((x - length).abs() < 1e-9 && (v - 12.0).abs() < 1e-6, "{x} {v}");
            assert!((a + 700.0).abs() < 1e-6);
        }
        assert!(leg(ends, 1.0, 200.0, LIMIT).is_none(), "no room");
        assert!(leg(ends, 10.0, 40.0, LIMIT).is_none(), "too fast at the start");
    }
}
