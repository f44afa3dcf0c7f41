//! The trajectory generator of Naseath 2007, section 4.5.
//!
//! Tangential S-curves between the local minima and maxima of V = sqrt(A / k) (equation 4-1), without
//! acceleration at either; maxima are lowered until the distance suffices. Start and end are at the
//! speed that the curvature there allows. Where the text is silent: a minimum that cannot be reached
//! from its neighbour within the distance is lowered too, a maximum may lie anywhere between its minima,
//! and what is left of the distance is run at it.
//!
//! It compares paths; it is not what runs a machine: no axis limit is looked at, and curvature limits
//! the speed at its peaks only.

use splineway::number::Scalar;
use splineway::number::list::some_mut;

/// Most steps in searches for a speed.
const STEPS: u32 = 40;
/// How near a speed is searched for, in shares of the last digit.
const CLOSE: f64 = 64.0;

/// Limits of the generator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory<S> {
    /// Feed, mm/s.
    pub feed: S,
    /// Greatest acceleration, mm/s2.
    pub acceleration: S,
    /// Greatest jerk, mm/s3.
    pub jerk: S,
}

/// A local minimum of the speed, or an end of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Low<S> {
    /// Arc length, mm.
    pub way: S,
    /// Speed, mm/s.
    pub speed: S,
    /// Greatest speed from there to the next one, mm/s.
    pub most: S,
}

/// Finds the minima of a sequence of places.
#[derive(Clone, Copy, Debug)]
pub struct Lows<S> {
    /// The minimum that is being left.
    low: Option<Low<S>>,
    /// Speed at the last but one place, way and speed at the last one.
    before: S,
    last: (S, S),
}

impl<S: Scalar> Default for Lows<S> {
    fn default() -> Self {
        Self { low: None, before: S::ZERO, last: (S::ZERO, S::ZERO) }
    }
}

impl<S: Scalar> Lows<S> {
    /// Takes the speed allowed at a place; returns a minimum when the next one is known.
    pub fn push(&mut self, way: S, speed: S) -> Option<Low<S>> {
        let Some(low) = &mut self.low else {
            self.low = Some(Low { way, speed, most: speed });
            (self.before, self.last) = (speed, (way, speed));
            return None;
        };
        let (a, (place, b)) = (self.before, self.last);
        let is_low = (b <= a && b < speed) || (b < a && b <= speed);
        let mut done = None;
        if is_low && place > low.way {
            done = Some(*low);
            *low = Low { way: place, speed: b, most: b };
        }
        low.most = low.most.greatest(speed);
        (self.before, self.last) = (b, (way, speed));
        done
    }

    /// The last minimum and the end of the path.
    pub fn finish(self) -> Option<[Low<S>; 2]> {
        let (way, speed) = self.last;
        Some([self.low?, Low { way, speed, most: speed }])
    }
}

impl<S: Scalar> Trajectory<S> {
    /// The thesis's values.
    pub fn thesis() -> Self {
        Self { feed: S::of(400.0), acceleration: S::of(4000.0), jerk: S::of(20_000.0) }
    }

    /// The speed that a curvature, 1/mm, allows, mm/s.
    pub fn allowed(&self, curvature: S) -> S {
        let square = self.feed * self.feed;
        if curvature * square > self.acceleration {
            (self.acceleration / curvature).sqrt()
        } else {
            self.feed
        }
    }

    /// Time of an S-curve from one speed to another, s (equations 4-2 to 4-11).
    pub fn time(&self, from: S, to: S) -> S {
        let change = (to - from).abs();
        if change * self.jerk > self.acceleration * self.acceleration {
            change / self.acceleration + self.acceleration / self.jerk
        } else {
            S::of(2.0) * (change / self.jerk).sqrt()
        }
    }

    /// Its length, mm: the speed is symmetric about its mean.
    pub fn length(&self, from: S, to: S) -> S {
        self.time(from, to) * (from + to) * S::of(0.5)
    }

    /// Speed, mm/s, and way, mm, after `t` seconds of an S-curve.
    pub fn at(&self, from: S, to: S, t: S) -> (S, S) {
        let half = S::of(0.5);
        let whole = self.time(from, to);
        let late = t > whole * half;
        // The second half is the first one seen from the end.
        let (start, t) = if late { (to, whole - t) } else { (from, t) };
        let rising = (to > from) != late;
        let concave = t.least(self.acceleration / self.jerk);
        let linear = t - concave;
        let a = if rising { self.jerk * concave } else { -(self.jerk * concave) };
        let v = start + a * concave * half;
        let s = start * concave + a * concave * concave * S::of(1.0 / 6.0);
        let (speed, way) = (v + a * linear, s + v * linear + a * linear * linear * half);
        (speed, if late { self.length(from, to) - way } else { way })
    }

    /// The greatest speed from `least` to `most` with which `excess`, that grows with the speed, is not above 0; `least`
    /// if there is none. By false position (Illinois): some eight evaluations.
    fn greatest(least: S, most: S, excess: impl Fn(S) -> S) -> S {
        let (mut low, mut high) = (least, most);
        let mut above = excess(most);
        if !(above > S::ZERO) {
            return most;
        }
        let mut below = excess(least);
        let half = S::of(0.5);
        // Which end stayed the last time: its value counts half, or it would stay for ever.
        let mut low_stayed = None;
        for _ in 0..STEPS {
            if !(below < S::ZERO && high - low > S::EPSILON * S::of(CLOSE) * high) {
                break;
            }
            let middle = low + (high - low) * (below / (below - above));
            let middle = if middle > low && middle < high { middle } else { (low + high) * half };
            let value = excess(middle);
            if value > S::ZERO {
                (high, above) = (middle, value);
                if low_stayed == Some(true) {
                    below = below * half;
                }
                low_stayed = Some(true);
            } else {
                (low, below) = (middle, value);
                if low_stayed == Some(false) {
                    above = above * half;
                }
                low_stayed = Some(false);
            }
        }
        low
    }

    /// The speed of a minimum, lowered so that it can be reached from another.
    fn within(&self, from: &Low<S>, to: &Low<S>) -> S {
        let room = (to.way - from.way).abs();
        if to.speed <= from.speed {
            return to.speed;
        }
        Self::greatest(from.speed, to.speed, |v| self.length(from.speed, v) - room)
    }

    /// Plans between minima: lowers their speeds, and the greatest between them, to what can be
    /// run. Returns the time, s.
    pub fn plan(&self, lows: &mut [Low<S>]) -> S {
        let neighbours = lows.len().saturating_sub(1);
        for k in 0..neighbours {
            if let Some([from, to]) = some_mut(lows, k) {
                to.speed = self.within(from, to);
            }
        }
        for k in (0..neighbours).rev() {
            if let Some([from, to]) = some_mut(lows, k) {
                from.speed = self.within(to, from);
            }
        }
        let mut time = S::ZERO;
        for k in 0..neighbours {
            let Some([from, to]) = some_mut(lows, k) else { break };
            let (v0, v1, room) = (from.speed, to.speed, to.way - from.way);
            let needs = |v: S| self.length(v0, v) + self.length(v, v1);
            let least = v0.greatest(v1);
            let top = Self::greatest(least, from.most.greatest(least), |v| needs(v) - room);
            from.most = top;
            let along = (room - needs(top)).greatest(S::ZERO);
            time += self.time(v0, top) + self.time(top, v1) + along / top;
        }
        time
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn lows(trajectory: &Trajectory<f64>, curvatures: &[f64]) -> Vec<Low<f64>> {
        let mut finder = Lows::default();
        let mut out = Vec::new();
        for (k, curvature) in curvatures.iter().enumerate() {
            out.extend(finder.push(k as f64, trajectory.allowed(*curvature)));
        }
        out.extend(finder.finish().unwrap());
        out
    }

    /// A straight line of 100 mm takes 0.25 s (section 4.9.7).
    #[test]
    fn a_line_is_run_at_the_feed() {
        let trajectory = Trajectory::thesis();
        let time = trajectory.plan(&mut lows(&trajectory, &[0.0; 101]));
        assert!((time - 0.25).abs() < 1e-12);
    }

    #[test]
    fn s_curves_meet_their_ends() {
        let trajectory = Trajectory::thesis();
        for (from, to) in [(10.0, 12.0), (20.0, 400.0), (390.0, 35.0)] {
            let time = trajectory.time(from, to);
            let (v, s) = trajectory.at(from, to, time);
            assert!((v - to).abs() < 1e-9 && (s - trajectory.length(from, to)).abs() < 1e-9);
            let (mut way, n) = (0.0, 2000);
            for k in 0..n {
                let t = time * (f64::from(k) + 0.5) / f64::from(n);
                way += trajectory.at(from, to, t).0 * time / f64::from(n);
            }
            assert!((way - s).abs() < 1e-4 * s, "{from} {to}: {way} {s}");
        }
    }

    /// Down for a bend and up again; the speed at the bend is what it may be, and the greatest between
    /// fits the distance.
    #[test]
    fn a_bend_is_slowed_down_for() {
        let trajectory = Trajectory::thesis();
        let mut curvatures = [0.0; 101];
        curvatures[50] = 1.0;
        let mut lows = lows(&trajectory, &curvatures);
        let time = trajectory.plan(&mut lows);
        assert_eq!(lows.len(), 3);
        assert!((lows[1].speed - 4000f64.sqrt()).abs() < 1e-9 && (lows[1].way - 50.0).abs() < 1e-9);
        assert!(time > 0.25 && lows[0].most <= 400.0);
        let needs = trajectory.length(lows[0].speed, lows[0].most)
            + trajectory.length(lows[0].most, lows[1].speed);
        assert!(needs <= 50.0 + 1e-9);
    }
}
