//! A stretch of time in which accelerations are quadratic, and what is between its ends.

use super::grain::Grain;

/// An axis at a servo cycle, in counts: position, velocity, acceleration.
pub type Counts = [i64; 3];

/// An axis over a span.
///
/// The acceleration is drawn from end to end and has a `bump` between; velocity and position are its integrals, with what is
/// missing at the end spread evenly. So each of them is as exact as it is counted, however short the span is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    seconds: f64,
    from: [f64; 3],
    acceleration: f64,
    bump: f64,
    /// What velocity and position lack at the end.
    lack: [f64; 2],
}

/// Counts as mm and s.
pub fn values(grain: &Grain, axis: usize, counts: Counts) -> [f64; 3] {
    let unit = &grain.axes[axis];
    [
        counts[0] as f64 * grain.position,
        counts[1] as f64 * unit.velocity,
        counts[2] as f64 * unit.acceleration,
    ]
}

/// The nearest counts of what an axis does: mm and s.
pub fn counts(grain: &Grain, axis: usize, values: [f64; 3]) -> Counts {
    let unit = &grain.axes[axis];
    [
        (values[0] / grain.position).round() as i64,
        (values[1] / unit.velocity).round() as i64,
        (values[2] / unit.acceleration).round() as i64,
    ]
}

impl Curve {
    /// Between two states, `cycles` apart.
    pub fn new(
        grain: &Grain,
        axis: usize,
        cycles: usize,
        [from, to]: [Counts; 2],
        bump: i64,
    ) -> Self {
        let h = cycles as f64 * grain.cycle;
        let bump = bump as f64 * grain.axes[axis].acceleration;
        let (from, to) = (values(grain, axis, from), values(grain, axis, to));
        let velocity = to[1] - Self::end_velocity(h, from, to[2], bump);
        let position = to[0] - Self::end_position(h, from, to[2], bump, velocity);
        Self { seconds: h, from, acceleration: to[2] - from[2], bump, lack: [velocity, position] }
    }

    /// Velocity at the end as accelerations have it.
    fn end_velocity(h: f64, from: [f64; 3], to: f64, bump: f64) -> f64 {
        from[1] + h * ((from[2] + to) * 0.5 + bump * (2.0 / 3.0))
    }

    fn end_position(h: f64, from: [f64; 3], to: f64, bump: f64, lack: f64) -> f64 {
        let twice = from[2] / 3.0 + to / 6.0 + bump / 3.0;
        from[0] + h * (from[1] + lack * 0.5 + h * twice)
    }

    /// Velocity and position at the end that are to be expected, in counts. What is decoded goes the same way, so that
    /// only the difference is written.
    pub fn expected(
        grain: &Grain,
        axis: usize,
        cycles: usize,
        from: Counts,
        to: i64,
        bump: i64,
        velocity: Option<i64>,
    ) -> i64 {
        let h = cycles as f64 * grain.cycle;
        let unit = &grain.axes[axis];
        let start = values(grain, axis, from);
        let (end, bump) = (to as f64 * unit.acceleration, bump as f64 * unit.acceleration);
        let expected = Self::end_velocity(h, start, end, bump);
        let counts = match velocity {
            None => expected / unit.velocity,
            Some(velocity) => {
                let lack = velocity as f64 * unit.velocity - expected;
                Self::end_position(h, start, end, bump, lack) / grain.position
            }
        };
        // As scripts round.
        (counts + 0.5).floor() as i64
    }

    /// The bump that makes the velocity at the end right, in counts.
    pub fn bump(grain: &Grain, axis: usize, cycles: usize, from: Counts, to: Counts) -> i64 {
        let unit = &grain.axes[axis];
        let h = cycles as f64 * grain.cycle;
        let mean = (to[1] - from[1]) as f64 * unit.velocity / h;
        let ends = (from[2] + to[2]) as f64 * 0.5 * unit.acceleration;
        ((mean - ends) * 1.5 / unit.acceleration).round() as i64
    }

    /// Position, velocity and acceleration at a share of the span: mm and s.
    pub fn at(&self, u: f64) -> [f64; 3] {
        let h = self.seconds;
        let (a, d, b) = (self.from[2], self.acceleration, self.bump);
        let acceleration = a + d * u + 4.0 * b * u * (1.0 - u);
        let once = u * (a + u * (d * 0.5 + b * (2.0 - u * (4.0 / 3.0))));
        let twice = u * u * (a * 0.5 + u * (d / 6.0 + b * (2.0 / 3.0 - u / 3.0)));
        let velocity = self.from[1] + h * once + self.lack[0] * u;
        let position = self.from[0]
            + h * (self.from[1] * u + self.lack[0] * 0.5 * u * u + h * twice)
            + self.lack[1] * u;
        [position, velocity, acceleration]
    }
}
