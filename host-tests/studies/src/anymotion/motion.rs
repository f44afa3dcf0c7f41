//! A motion by knots in time, between which the jerk of every axis is constant.

/// Position, velocity and acceleration of all axes.
pub type State = [Vec<f64>; 3];

/// Shorter phases are none, s.
const NO_TIME: f64 = 1.0e-10;

/// A motion: of every knot its time and, axis by axis, position, velocity and acceleration.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Axes.
    pub axes: usize,
    /// s.
    pub time: Vec<f64>,
    /// mm; `knot * axes + axis`, as the next two.
    pub position: Vec<f64>,
    /// mm/s.
    pub velocity: Vec<f64>,
    /// mm/s2.
    pub acceleration: Vec<f64>,
}

impl Motion {
    /// Without a knot.
    pub fn new(axes: usize) -> Self {
        let (time, position, velocity, acceleration) = (vec![], vec![], vec![], vec![]);
        Self { axes, time, position, velocity, acceleration }
    }

    /// Adds a knot.
    pub fn push(&mut self, time: f64, [position, velocity, acceleration]: [&[f64]; 3]) {
        self.time.push(time);
        self.position.extend_from_slice(position);
        self.velocity.extend_from_slice(velocity);
        self.acceleration.extend_from_slice(acceleration);
    }

    /// With one knot, at rest in a point.
    pub fn resting(at: &[f64]) -> Self {
        let mut motion = Self::new(at.len());
        let rest = vec![0.0; at.len()];
        motion.push(0.0, [at, &rest, &rest]);
        motion
    }

    /// Adds a knot a time after the last, if that is any time at all.
    pub fn advance(&mut self, time: f64, state: [&[f64]; 3]) {
        if time > NO_TIME {
            self.push(self.duration() + time, state);
        }
    }

    /// Number of intervals.
    pub fn steps(&self) -> usize {
        self.time.len() - 1
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.time[self.steps()]
    }

    /// Duration of an interval, s.
    pub fn step(&self, k: usize) -> f64 {
        self.time[k + 1] - self.time[k]
    }

    /// Position, a share of interval `k` behind its start.
    pub fn within(&self, k: usize, share: f64) -> Vec<f64> {
        let h = self.step(k);
        self.after(k, share * h)[0].clone()
    }

    /// The state at a time; before the first knot and behind the last, theirs.
    pub fn at(&self, time: f64) -> State {
        let time = time.clamp(self.time[0], self.duration());
        let k = self.interval(time);
        self.after(k, time - self.time[k])
    }

    /// The states at every servo cycle, from the first knot to the first cycle that is not before the last.
    pub fn sampled(&self, cycle: f64) -> Vec<State> {
        self.cycles(cycle).map(|time| self.at(time)).collect()
    }

    /// The times of these.
    pub fn cycles(&self, cycle: f64) -> impl Iterator<Item = f64> {
        let last = (self.duration() / cycle - 1.0e-6).ceil() as usize;
        (0..=last).map(move |k| k as f64 * cycle)
    }

    /// The jerk of every axis behind a time.
    pub fn jerk(&self, time: f64) -> Vec<f64> {
        let k = self.interval(time);
        let (i, d) = (k * self.axes, self.axes);
        (i..i + d)
            .map(|i| (self.acceleration[i + d] - self.acceleration[i]) / self.step(k))
            .collect()
    }

    fn interval(&self, time: f64) -> usize {
        self.time.partition_point(|t| *t <= time).clamp(1, self.steps()) - 1
    }

    fn after(&self, k: usize, t: f64) -> State {
        let (h, d) = (self.step(k), self.axes);
        let mut state: State = [vec![0.0; d], vec![0.0; d], vec![0.0; d]];
        for c in 0..d {
            let i = k * d + c;
            let (p, v, a) = (self.position[i], self.velocity[i], self.acceleration[i]);
            let j = (self.acceleration[i + d] - a) / h;
            state[0][c] = p + t * (v + t * (a / 2.0 + t * j / 6.0));
            state[1][c] = v + t * (a + t * j / 2.0);
            state[2][c] = a + t * j;
        }
        state
    }

    /// The same, slower by a factor.
    #[must_use]
    pub fn slower(&self, factor: f64) -> Self {
        let by = |values: &[f64], factor: f64| values.iter().map(|x| x * factor).collect();
        Self {
            axes: self.axes,
            time: by(&self.time, factor),
            position: self.position.clone(),
            velocity: by(&self.velocity, 1.0 / factor),
            acceleration: by(&self.acceleration, 1.0 / (factor * factor)),
        }
    }

    /// By how much a knot's position lies off what the one before leads to, at most, mm: a program that was solved
    /// for durations that it has changed leaves this.
    pub fn defect(&self) -> f64 {
        let d = self.axes;
        let mut most = 0.0f64;
        for k in 0..self.steps() {
            let end = self.after(k, self.step(k));
            for (c, end) in end[0].iter().enumerate() {
                most = most.max((end - self.position[(k + 1) * d + c]).abs());
            }
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_of_constant_jerk_is_itself() {
        let mut motion = Motion::new(1);
        let state = |t: f64| [5.0 * t * t * t, 15.0 * t * t, 30.0 * t];
        for t in [0.0, 0.1, 0.25] {
            let [p, v, a] = state(t);
            motion.push(t, [&[p], &[v], &[a]]);
        }
        assert!(motion.defect() < 1e-15);
        let [p, v, a] = state(0.2);
        let at = motion.at(0.2);
        assert!((at[0][0] - p).abs() + (at[1][0] - v).abs() + (at[2][0] - a).abs() < 1e-12);
        let slower = motion.slower(2.0);
        assert!((slower.duration() - 0.5).abs() < 1e-15 && slower.defect() < 1e-15);
    }
}
