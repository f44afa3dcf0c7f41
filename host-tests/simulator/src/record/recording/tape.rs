//! Spans as columns of numbers.

use super::columns::{Column, Numbers};
use super::fit::{Span, State};
use super::grain::Grain;
use super::span::{Counts, Curve, values};

/// Columns that are no axis's: lengths of spans, deviations.
const COMMON: usize = 2;
/// Columns of an axis: acceleration, bump, velocity, position.
const PER_AXIS: usize = 4;

/// Every servo cycle of a run.
///
/// Of each span, what is written of an axis is the difference of its acceleration, the bump, and what velocity and position are
/// off what accelerations make of them: next to nothing, as a rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// Units.
    pub grain: Grain,
    /// Axes in the first cycle.
    pub start: Vec<Counts>,
    /// Number of spans.
    pub spans: usize,
    /// Number of servo cycles behind the first.
    pub cycles: u64,
    columns: Vec<Column>,
}

impl Tape {
    /// An empty one.
    pub fn new(grain: Grain, start: Vec<Counts>) -> Self {
        let columns = vec![Column::default(); COMMON + PER_AXIS * start.len()];
        Self { grain, start, spans: 0, cycles: 0, columns }
    }

    /// Of columns as [`Tape::columns`] gives them.
    pub fn of(grain: Grain, start: Vec<Counts>, columns: Vec<Column>) -> Self {
        let (mut spans, mut cycles) = (0, 0);
        let mut read = columns.first().map(Column::read);
        while let Some(lengths) = read.as_mut().filter(|lengths| !lengths.is_empty()) {
            cycles += lengths.count();
            spans += 1;
        }
        Self { grain, start, spans, cycles, columns }
    }

    /// Lengths in cycles, deviations in counts, then of every axis acceleration, bump, velocity and position, each a column.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Bytes that are left by compression, about.
    pub fn weight(&self) -> usize {
        self.columns.iter().map(Column::weight).sum()
    }

    /// One more span behind the last.
    pub fn add(&mut self, from: &[Counts], span: &Span) {
        let (common, axes) = self.columns.split_at_mut(COMMON);
        common[0].count(span.cycles as u64);
        common[1].count(span.deviation as u64);
        let parts = from.iter().zip(&span.to).zip(&span.bumps).zip(axes.chunks_mut(PER_AXIS));
        for (n, (((from, to), bump), columns)) in parts.enumerate() {
            let expected = |velocity| {
                Curve::expected(&self.grain, n, span.cycles, *from, to[2], *bump, velocity)
            };
            columns[0].number(to[2] - from[2]);
            columns[1].number(*bump);
            columns[2].number(to[1] - expected(None));
            columns[3].number(to[0] - expected(Some(to[1])));
        }
        self.spans += 1;
        self.cycles += span.cycles as u64;
    }

    /// The spans, each with the axes at its beginning.
    pub fn spans(&self) -> Spans<'_> {
        let columns = self.columns.iter().map(Column::read).collect();
        Spans { tape: self, columns, from: self.start.clone() }
    }

    /// Every cycle as it is decoded: its axes, and its deviation from the path, mm.
    pub fn play(&self, see: &mut impl FnMut(&[State], f64)) {
        let first = self.start.iter().enumerate();
        let mut states: Vec<State> =
            first.map(|(n, counts)| values(&self.grain, n, *counts)).collect();
        see(&states, 0.0);
        for (from, span) in self.spans() {
            let curve = |(n, from)| {
                Curve::new(&self.grain, n, span.cycles, [from, span.to[n]], span.bumps[n])
            };
            let curves: Vec<Curve> = from.into_iter().enumerate().map(curve).collect();
            let deviation = span.deviation as f64 * self.grain.position;
            for k in 1..=span.cycles {
                let u = k as f64 / span.cycles as f64;
                states.iter_mut().zip(&curves).for_each(|(state, curve)| *state = curve.at(u));
                see(&states, deviation);
            }
        }
    }
}

/// Reads spans.
#[derive(Clone, Debug)]
pub struct Spans<'a> {
    tape: &'a Tape,
    columns: Vec<Numbers<'a>>,
    from: Vec<Counts>,
}

impl Iterator for Spans<'_> {
    type Item = (Vec<Counts>, Span);

    fn next(&mut self) -> Option<Self::Item> {
        if self.columns[0].is_empty() {
            return None;
        }
        let (common, axes) = self.columns.split_at_mut(COMMON);
        let mut span = Span {
            cycles: common[0].count() as usize,
            deviation: common[1].count().cast_signed(),
            ..Span::default()
        };
        for (n, (from, columns)) in self.from.iter().zip(axes.chunks_mut(PER_AXIS)).enumerate() {
            let acceleration = from[2] + columns[0].number();
            let bump = columns[1].number();
            let expected = |velocity| {
                let grain = &self.tape.grain;
                Curve::expected(grain, n, span.cycles, *from, acceleration, bump, velocity)
            };
            let velocity = columns[2].number() + expected(None);
            let position = columns[3].number() + expected(Some(velocity));
            span.to.push([position, velocity, acceleration]);
            span.bumps.push(bump);
        }
        let from = std::mem::replace(&mut self.from, span.to.clone());
        Some((from, span))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Axis;
    use crate::record::recording::fit::Fit;

    /// Two axes under a jerk that jumps at any time between cycles, with rests and stretches of constant velocity.
    fn motion(cycle: f64, cycles: usize) -> Vec<Vec<State>> {
        let mut seed = 12_345u64;
        let mut random = move || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1u32 << 31)
        };
        let mut jerks = [(0.0, 0.0); 2];
        let mut axes = [[0.0f64; 3]; 2];
        let mut all = vec![axes.to_vec()];
        for _ in 0..cycles {
            for (axis, (jerk, left)) in axes.iter_mut().zip(&mut jerks) {
                let mut rest = cycle;
                while rest > 0.0 {
                    if *left <= 0.0 {
                        *left = 0.002 + random() * 0.05;
                        let pull = -axis[2] * 20.0 - axis[1] * 100.0;
                        *jerk = if random() < 0.2 {
                            0.0
                        } else {
                            pull.clamp(-3e4, 3e4) + (random() - 0.5) * 4e4
                        };
                    }
                    let (h, j) = (rest.min(*left), *jerk);
                    let [x, v, a] = *axis;
                    *axis = [
                        x + h * (v + h * (a / 2.0 + h * j / 6.0)),
                        v + h * (a + h * j / 2.0),
                        a + h * j,
                    ];
                    rest -= h;
                    *left -= h;
                }
            }
            all.push(axes.to_vec());
        }
        all
    }

    fn limits() -> [Axis; 2] {
        [Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 }; 2]
    }

    #[test]
    fn what_is_played_is_what_was_recorded() {
        let cycle = 1e-3;
        let run = motion(cycle, 20_000);
        let mut grain = Grain::new(cycle, 0.005, &limits());
        let mut sizes = Vec::new();
        for level in 0..5 {
            let mut fit = Fit::new(grain.clone(), &run[0]);
            let mut tape = Tape::new(grain.clone(), fit.from().to_vec());
            for (k, states) in run.iter().enumerate().skip(1) {
                let deviation = (k % 100) as f64 * 1e-4;
                fit.push(states, deviation, &mut |_, from, span| tape.add(from, span));
            }
            fit.finish(&mut |_, from, span| tape.add(from, span));
            assert_eq!(tape.cycles as usize + 1, run.len());
            let again = Tape::of(grain.clone(), tape.start.clone(), tape.columns().to_vec());
            let mut cycles = run.iter().enumerate();
            let mut before: Option<(Vec<State>, &Vec<State>)> = None;
            again.play(&mut |states, deviation| {
                let (k, was) = cycles.next().unwrap();
                let off =
                    states.iter().zip(was).map(|(a, b)| (a[0] - b[0]).powi(2)).sum::<f64>().sqrt();
                assert!(
                    off <= grain.off.max(2.0 * grain.position),
                    "level {level}, cycle {k}: {off} mm off"
                );
                assert!(k == 0 || deviation + 1e-6 >= (k % 100) as f64 * 1e-4);
                for (n, unit) in grain.axes.iter().enumerate() {
                    let slack = 1.001;
                    assert!((states[n][1] - was[n][1]).abs() <= unit.off[0] * slack);
                    assert!((states[n][2] - was[n][2]).abs() <= unit.off[1] * slack);
                    if let Some((drawn, run)) = &before {
                        let jerk = (states[n][2] - drawn[n][2]) - (was[n][2] - run[n][2]);
                        assert!(jerk.abs() / cycle <= unit.off[2] * slack, "cycle {k}: jerk");
                    }
                }
                before = Some((states.to_vec(), was));
            });
            assert!(cycles.next().is_none());
            sizes.push(tape.weight());
            grain = grain.coarser();
        }
        // Behind these, positions are what takes room.
        assert!(sizes[2] < sizes[1] && sizes[1] < sizes[0], "{sizes:?}");
        assert!(sizes[0] < 20_000 * 4, "{sizes:?}");
    }

    /// A rest of an hour is a few hundred bytes a minute, and a jump in one cycle is kept.
    #[test]
    fn rests_and_jumps() {
        let mut fit = Fit::new(Grain::new(1e-3, 0.001, &limits()), &[[1.0, 0.0, 0.0]; 2]);
        let mut tape = Tape::new(fit.grain().clone(), fit.from().to_vec());
        for k in 1..=100_000 {
            let x = if k == 50_000 { 7.0 } else { 1.0 };
            fit.push(&[[x, 0.0, 0.0]; 2], 0.0, &mut |_, from, span| tape.add(from, span));
        }
        fit.finish(&mut |_, from, span| tape.add(from, span));
        assert!(tape.spans < 220, "{}", tape.spans);
        let mut k = 0;
        tape.play(&mut |states, _| {
            let x = if k == 50_000 { 7.0 } else { 1.0 };
            assert!((states[1][0] - x).abs() < 1e-4, "cycle {k}: {states:?}");
            k += 1;
        });
    }
}
