//! Moves of all kinds, one after the other.

use fastrand::Rng;
use splineway_simulator::program::{Course, Move, Point, Program, Speed};

/// One random move: kind, direction and size, feed, stop.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Which kind of move.
    pub kind: u8,
    /// Direction over the axes.
    pub step: Vec<f64>,
    /// Length, mm.
    pub size: f64,
    /// mm/s.
    pub feed: f64,
    /// Exact stop at its end.
    pub stop: bool,
    /// How much an arc or a curve bends.
    pub bend: f64,
}

impl Draw {
    /// Any move over a number of axes, with lengths from a micrometre to 30 mm, all orders of magnitude
    /// alike.
    pub fn any(rng: &mut Rng, axes: usize) -> Self {
        Self {
            kind: rng.u8(..20),
            step: (0..axes).map(|_| between(rng, -1.0, 1.0)).collect(),
            size: 10f64.powf(between(rng, -3.0, 1.5)),
            feed: 10f64.powf(between(rng, -0.5, 2.6)),
            stop: rng.f64() < 0.05,
            bend: between(rng, -2.5, 2.5),
        }
    }
}

/// A number in a range.
pub(super) fn between(rng: &mut Rng, least: f64, greatest: f64) -> f64 {
    least + (greatest - least) * rng.f64()
}

/// The program of some draws over some axes.
pub fn program(draws: &[Draw], axes: &[usize]) -> Program {
    let mut program = Program::default();
    for &axis in axes {
        program.uses[axis] = true;
    }
    let mut here: Point = [0.0; 9];
    for (n, draw) in draws.iter().enumerate() {
        let norm = draw.step.iter().map(|x| x * x).sum::<f64>().sqrt().max(0.1);
        let mut to = here;
        for (&axis, step) in axes.iter().zip(&draw.step) {
            to[axis] += step / norm * draw.size;
        }
        let path = match draw.kind {
            0 => Course::Dwell { seconds: draw.size.min(0.05) },
            // An arc or helix through `to`: the centre anywhere on the chord's bisector.
            1..=5 if (to[0] - here[0]).hypot(to[1] - here[1]) > 1e-3 => {
                let middle = (f64::midpoint(here[0], to[0]), f64::midpoint(here[1], to[1]));
                let chord = (to[0] - here[0], to[1] - here[1]);
                let centre = (middle.0 - chord.1 * draw.bend, middle.1 + chord.0 * draw.bend);
                Course::Arc {
                    to,
                    plane: (0, 1),
                    centre,
                    clockwise: draw.bend > 0.7,
                    extra_turns: 0,
                }
            }
            // Straight on, as dense programs go.
            6..=9 if n > 0 => {
                if let Some(Move { path: Course::Line { to: end }, .. }) = program.moves.last() {
                    let before = draws[n - 1].step.clone();
                    let size = before.iter().map(|x| x * x).sum::<f64>().sqrt().max(0.1);
                    to = *end;
                    for ((&axis, old), new) in axes.iter().zip(&before).zip(&draw.step) {
                        to[axis] += (old / size + 0.05 * new) * draw.size;
                    }
                }
                Course::Line { to }
            }
            // A curve, bent one way or the other, even back on itself.
            10..=11 => {
                let mut controls = [here, to];
                for (k, &axis) in axes.iter().enumerate() {
                    let across = draw.bend * draw.size * draw.step[(k + 1) % axes.len()];
                    controls[0][axis] += across;
                    controls[1][axis] += if draw.kind == 10 { across } else { -across };
                }
                Course::Cubic { controls, to }
            }
            _ => Course::Line { to },
        };
        if !matches!(path, Course::Dwell { .. }) {
            here = to;
        }
        program.moves.push(Move {
            path,
            // No move takes longer than a fifth of a second at its feed, or the tests would.
            speed: if draw.kind == 19 {
                Speed::Rapid
            } else {
                Speed::PerSecond(draw.feed.max(draw.size * 5.0))
            },
            tolerance: None,
            exact_stop: draw.stop,
            line: n as u32 + 1,
        });
    }
    program
}
