//! The longest spans that stay near enough to what was run.

use super::grain::Grain;
use super::span::{Counts, Curve, counts};

/// Servo cycles of a span at most: what is kept until a span is found.
pub const MOST: usize = 512;
/// A deviation of so many counts is none.
const NOTHING: f64 = 1.0e-3;
/// A shorter span has no bump: its bump would be made of rounding.
const BUMPED: usize = 4;

/// What one axis did in one servo cycle: position, velocity and acceleration, mm and s.
pub type State = [f64; 3];

/// A span that is found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Span {
    /// Servo cycles.
    pub cycles: usize,
    /// Axes at its end.
    pub to: Vec<Counts>,
    /// Bumps of their accelerations, in counts.
    pub bumps: Vec<i64>,
    /// Greatest deviation from the programmed path, in counts.
    pub deviation: i64,
}

/// Cycles that are in no span yet; the first is the end of the last span.
///
/// A cycle costs a few polynomials per axis: spans are tried at lengths that double, and then halved in between.
#[derive(Clone, Debug)]
pub struct Fit {
    grain: Grain,
    states: Vec<Vec<State>>,
    deviations: Vec<f64>,
    from: Vec<Counts>,
    /// The longest span that is known to do, and the next to try, cycles.
    good: (usize, Vec<i64>),
    next: usize,
}

impl Fit {
    /// From the first cycle on.
    pub fn new(grain: Grain, first: &[State]) -> Self {
        let from = first.iter().enumerate().map(|(n, x)| counts(&grain, n, *x)).collect();
        Self {
            states: first.iter().map(|state| vec![*state]).collect(),
            deviations: vec![0.0],
            from,
            good: (0, Vec::new()),
            next: 1,
            grain,
        }
    }

    /// Units.
    pub fn grain(&self) -> &Grain {
        &self.grain
    }

    /// Where the last span ended.
    pub fn from(&self) -> &[Counts] {
        &self.from
    }

    /// One more cycle, with its deviation from the programmed path, mm; `found` takes the spans that end by it, each
    /// with the axes at its beginning.
    pub fn push(
        &mut self,
        states: &[State],
        deviation: f64,
        found: &mut impl FnMut(&Grain, &[Counts], &Span),
    ) {
        for (all, state) in self.states.iter_mut().zip(states) {
            all.push(*state);
        }
        self.deviations.push(deviation);
        while self.next < self.deviations.len() {
            self.step(false, found);
        }
    }

    /// Spans of what is left.
    pub fn finish(&mut self, found: &mut impl FnMut(&Grain, &[Counts], &Span)) {
        while self.deviations.len() > 1 {
            let last = self.deviations.len() - 1;
            self.next = self.next.min(last);
            self.step(self.next == last, found);
        }
    }

    /// The cycles that are in no span yet, in order.
    pub fn rest(&self, see: &mut impl FnMut(&[State], f64)) {
        for (k, deviation) in self.deviations.iter().enumerate().skip(1) {
            let states: Vec<State> = self.states.iter().map(|all| all[k]).collect();
            see(&states, *deviation);
        }
    }

    /// Tries the next length, which is there; behind the `last` nothing comes.
    fn step(&mut self, last: bool, found: &mut impl FnMut(&Grain, &[Counts], &Span)) {
        if let Some(bumps) = self.bumps(self.next) {
            self.good = (self.next, bumps);
            if self.next < MOST && !last {
                self.next = (2 * self.next).min(MOST);
                return;
            }
        } else {
            let mut beyond = self.next;
            while beyond - self.good.0 > 1 {
                let middle = usize::midpoint(self.good.0, beyond);
                match self.bumps(middle) {
                    Some(bumps) => self.good = (middle, bumps),
                    None => beyond = middle,
                }
            }
        }
        self.close(found);
    }

    fn close(&mut self, found: &mut impl FnMut(&Grain, &[Counts], &Span)) {
        let (cycles, bumps) = std::mem::take(&mut self.good);
        let to = self.end(cycles);
        let most = self.deviations[1..=cycles].iter().copied().fold(0.0, f64::max);
        let span = Span {
            cycles,
            to,
            bumps,
            deviation: (most / self.grain.position - NOTHING).ceil().max(0.0) as i64,
        };
        found(&self.grain, &self.from, &span);
        self.from.clone_from(&span.to);
        for all in &mut self.states {
            all.drain(..cycles);
        }
        self.deviations.drain(..cycles);
        self.next = 1;
    }

    /// The axes after so many cycles.
    fn end(&self, cycles: usize) -> Vec<Counts> {
        self.states.iter().enumerate().map(|(n, all)| counts(&self.grain, n, all[cycles])).collect()
    }

    /// The bumps of a span of this many cycles; none if it is too far off.
    fn bumps(&self, cycles: usize) -> Option<Vec<i64>> {
        let to = self.end(cycles);
        let mut off = vec![0.0; cycles];
        let fits =
            |n: usize, bump: i64, off: &mut [f64]| self.fits(n, [self.from[n], to[n]], bump, off);
        (0..self.states.len())
            .map(|n| {
                let before = off.clone();
                if fits(n, 0, &mut off) {
                    return Some(0);
                }
                let bump = if cycles < BUMPED {
                    0
                } else {
                    Curve::bump(&self.grain, n, cycles, self.from[n], to[n])
                };
                off = before;
                (bump != 0 && fits(n, bump, &mut off)).then_some(bump)
            })
            .collect()
    }

    /// Whether an axis stays near; adds the squares of what its positions are off, mm2.
    fn fits(&self, n: usize, ends: [Counts; 2], bump: i64, off: &mut [f64]) -> bool {
        let (unit, cycle) = (&self.grain.axes[n], self.grain.cycle);
        let curve = Curve::new(&self.grain, n, off.len(), ends, bump);
        let most = self.grain.off * self.grain.off;
        let mut before = (curve.at(0.0)[2], self.states[n][0][2]);
        (1..=off.len()).all(|k| {
            let (is, was) = (curve.at(k as f64 / off.len() as f64), self.states[n][k]);
            let jerk = ((is[2] - before.0) - (was[2] - before.1)) / cycle;
            before = (is[2], was[2]);
            let last = k == off.len();
            off[k - 1] += (is[0] - was[0]) * (is[0] - was[0]);
            // A span of one cycle is as near as counts can be.
            off.len() == 1
                || (last || off[k - 1] <= most)
                    && (is[1] - was[1]).abs() <= unit.off[0]
                    && (is[2] - was[2]).abs() <= unit.off[1]
                    && jerk.abs() <= unit.off[2]
        })
    }
}
